//! The whole way from scene to backbone on a small mesh: one reduced model, many scenes on it.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{BENCHMARKS, beam};
use analyses::results::summary::{Status, Summary};
use analyses::{Error, Prepared, Run, prepare, run};
use cqsma_solver::{NewtonSettings, prestress};
use dense_algebra::Limits;
use faer::Mat;
use joint_model::benchmark::RefinementLevel;
use joint_model::{Bodies, Sides};
use joints::Options;
use joints::interface::InterfaceForce;
use joints::progress::{Amplitude, Progress, Silent, Stage};
use joints::structure::Structure;
use scenes::{BoltBehaviour, Commit, Force, Gap, LawKind, Length, Mass, PointMass, Scene, Surface, SyntheticScan};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};
use test_support::TemporaryFolder;

/// Folder with the reduced model that all tests share; the first test in makes it.
fn cache() -> PathBuf {
    ready().0.clone()
}

/// The common cache, and the end of the names of the files that belong to the model of [`quick`].
fn ready() -> &'static (PathBuf, String) {
    static READY: OnceLock<(PathBuf, String)> = OnceLock::new();
    READY.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("analyses-{}", std::process::id()));
        let mut first = quick();
        first.analyses.backbone.amplitudes = 1;
        run(&first, &Options::cached(&folder), &Silent)
            .unwrap()
            .checkpoints
            .remove();
        let reduced = file_of(&folder, "reduced-");
        let name = reduced.file_name().unwrap().to_string_lossy();
        let end = name.trim_start_matches("reduced-").to_owned();
        (folder, end)
    })
}

fn quick() -> Scene {
    let mut scene = beam("quick");
    scene.model.refinement = RefinementLevel::Quick;
    scene.analyses.backbone.amplitudes = 7;
    scene.analyses.backbone.amplitude_from = Length::from_si(1e-6);
    scene.analyses.backbone.vertices_per_quarter = 4;
    scene
}

fn go(scene: &Scene) -> Run {
    let run = run(scene, &Options::cached(cache()), &Silent).unwrap();
    run.checkpoints.remove();
    run
}

fn damping(run: &Run) -> Vec<f64> {
    run.amplitudes()
        .iter()
        .map(|a| a.point.result.as_ref().unwrap().zeta)
        .collect()
}

#[test]
fn the_structure_is_the_benchmark() {
    let run = go(&quick());
    assert!((run.model.facts.mass.unwrap() / 3.70 - 1.0).abs() < 0.005);
    let area = 0.120 * 0.0254 - 3.0 * std::f64::consts::PI * 0.0085_f64.powi(2) / 4.0;
    assert!((run.interface.operators().area() / area - 1.0).abs() < 1e-3);
    assert_eq!((run.model.reduced.zem_stuck, run.model.facts.zem_unstressed), (6, 7));
    // Ten modes of the full model with a uniform linear interface stiffness.
    assert!(
        run.model.facts.penalty_error < 1e-4,
        "{}",
        run.model.facts.penalty_error
    );
    assert!(run.model.reduced.asymmetry < 1e-6);
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_accelerometers_lower_the_first_frequency_as_perturbation_theory_says() {
    let mut scene = quick();
    scene.analyses.backbone.amplitudes = 1;
    scene.analyses.backbone.amplitude_from = Length::from_si(1e-9);
    scene.analyses.backbone.amplitude_to = Length::from_si(1e-9);
    let bare = Structure::try_new(&scene, &Silent).unwrap();
    let Bodies::Meshed(bodies) = &bare.joint.bodies else {
        panic!("the benchmark is meshed");
    };
    let nodes = &bodies.assembly.mesh.nodes;
    let along = |node: &u32| nodes[*node as usize][0];
    let last = nodes.len() as u32 - 1;
    let ends = [
        (0..=last).min_by(|a, b| along(a).total_cmp(&along(b))).unwrap(),
        (0..=last).max_by(|a, b| along(a).total_cmp(&along(b))).unwrap(),
    ];
    // Mass-normalised mode shape at the ends along perpendicular directions, all of which the mode has a part in.
    let directions = [[2.0, -1.0, 2.0], [2.0, 2.0, -1.0], [-1.0, 2.0, 2.0]];
    let (mut squares, mut frequency) = (0.0, 0.0);
    for (node, direction) in ends
        .into_iter()
        .flat_map(|node| directions.map(|direction| (node, direction)))
    {
        let mut structure = bare.clone();
        let Bodies::Meshed(bodies) = &mut structure.joint.bodies else {
            panic!("the benchmark is meshed");
        };
        bodies.response_node = node;
        bodies.response_direction = direction.map(|x| x / 3.0);
        let prepared = Prepared::try_new(&scene, &structure, &Options::default(), &Silent).unwrap();
        let run = prepared.solve(&Silent).unwrap();
        let summary = Summary::new(&run, BTreeMap::new(), None);
        let point = &summary.backbone[0];
        let shape = point.response_displacement.unwrap() / point.modal_amplitude.unwrap();
        squares += shape * shape;
        frequency = run.frequencies[0];
    }
    scene.analyses.backbone.amplitudes = 0;
    // A millimetre beside the nodes.
    scene.structure.point_masses = ends
        .map(|node| PointMass {
            at: Some(nodes[node as usize].map(|x| Length::from_si(x + 1e-3 / 3.0_f64.sqrt()))),
            within: None,
            node: None,
            mass: Mass::from_si(8e-4),
        })
        .to_vec();
    let heavy = run(&scene, &Options::default(), &Silent).unwrap();
    let mass = |structure: &Structure| structure.describe(None, &Silent).unwrap().mass.unwrap();
    let added = heavy.model.facts.mass.unwrap() - mass(&bare);
    assert!((added / 1.6e-3 - 1.0).abs() < 1e-9, "{added}");
    let shift = heavy.frequencies[0] / frequency - 1.0;
    let expected = -0.5 * 8e-4 * squares;
    assert!((shift / expected - 1.0).abs() < 1e-2, "{shift} {expected}");
    // The published figure: about 0.04 % by each.
    assert!((-9e-4..-7e-4).contains(&shift), "{shift}");

    scene.structure.point_masses[1].at = Some([Length::from_si(1.0); 3]);
    let far = Structure::try_new(&scene, &Silent).unwrap_err().to_string();
    assert!(far.contains("number 2") && far.contains("the node nearest to"), "{far}");
    scene.structure.point_masses[1].within = Some(Length::from_si(2.0));
    Structure::try_new(&scene, &Silent).unwrap();
}

#[test]
fn prestress_carries_the_bolt_load() {
    for gap in [Gap::Flat, Gap::Measured] {
        let mut scene = quick();
        scene.interfaces.gap = gap;
        let run = go(&scene);
        let p = &run.prestress;
        assert!(
            p.equilibrium_error <= 10.0 * p.residual_ratio + 1e-12,
            "{gap:?}: {} {}",
            p.equilibrium_error,
            p.residual_ratio
        );
        assert!(p.residual_ratio < 1e-6, "{gap:?}: {}", p.residual_ratio);
        let area = run.validity().contact_area_fraction_by_points;
        assert!(area > 0.2 && area <= 1.0, "{gap:?}: {area}");
        assert!(run.validity().contact_area_fraction_by_elements >= area);
    }
}

#[test]
fn dissipation_from_the_points_equals_that_from_the_mode() {
    let run = go(&quick());
    for a in run.amplitudes() {
        let (result, fields) = (a.point.result.as_ref().unwrap(), a.fields.as_ref().unwrap());
        let allowed = 1e-6 * result.loop_area.abs()
            + 10.0 * run.scene.analyses.backbone.tolerance * a.point.modal_force * result.modal_amplitude;
        assert!(
            (fields.dissipation - result.loop_area).abs() <= allowed,
            "{} {}",
            fields.dissipation,
            result.loop_area
        );
    }
}

/// Area of a loop of jumps and tractions (J/m^2).
fn shoelace(vertices: &[([f64; 3], [f64; 3])]) -> f64 {
    let from_the_first = |of: &[f64; 3], first: &[f64; 3]| [0, 1, 2].map(|c| of[c] - first[c]);
    let (first_jump, first_traction) = &vertices[0];
    // The prestress would leave its round-off.
    let vertices: Vec<_> = vertices
        .iter()
        .map(|(jump, traction)| {
            (
                from_the_first(jump, first_jump),
                from_the_first(traction, first_traction),
            )
        })
        .collect();
    // The polygon of jump and traction runs clockwise where energy is dissipated.
    let polygon = |every: usize| -> f64 {
        let vertices: Vec<_> = vertices.iter().step_by(every).collect();
        let edges = vertices.iter().zip(vertices.iter().cycle().skip(1));
        edges
            .flat_map(|((u, t), (v, s))| [0, 1, 2].map(|c| 0.5 * (v[c] * t[c] - u[c] * s[c])))
            .sum()
    };
    // Simpson's rule.
    (4.0 * polygon(1) - polygon(2)) / 3.0
}

#[test]
fn loops_of_elements_enclose_what_their_points_dissipate() {
    for points_per_direction in [1, 2] {
        let mut scene = quick();
        scene.interfaces.points_per_direction = points_per_direction;
        scene.output.fields_at = Some(vec![5, 7]);
        let run = go(&scene);
        let operators = run.interface.operators();
        for (number, amplitude) in (1..).zip(run.amplitudes()) {
            let found = amplitude.fields.as_ref().unwrap();
            assert_eq!(found.loops.is_some(), [5, 7].contains(&number));
            let Some(loops) = &found.loops else { continue };
            let hysteresis = &amplitude.point.result.as_ref().unwrap().hysteresis;
            assert_eq!(loops.modal_force, hysteresis.force);
            assert_eq!(loops.elements, (0..operators.n_elements()).collect::<Vec<_>>());
            let fields = found.fields.as_ref().unwrap();
            let fluxes = fields.flux.each_ref().map(|of| operators.element_means(of));
            let jumps = fields.jump.each_ref().map(|of| operators.element_means(of));
            let (mut largest, mut worst) = (0.0_f64, 0.0_f64);
            for element in 0..operators.n_elements() {
                let vertices: Vec<_> = loops.of_element(element).unwrap().collect();
                assert_eq!(vertices.len(), loops.modal_force.len());
                // Fields are those of the last vertex at the peak.
                assert_eq!(vertices.last().unwrap().0, jumps.each_ref().map(|of| of[element]));
                let flux: f64 = fluxes.iter().map(|of| of[element]).sum();
                let area = shoelace(&vertices);
                largest = largest.max(flux);
                worst = worst.max((area - flux).abs());
            }
            println!("{points_per_direction}, {number}: {worst:e} of {largest:e}");
            // An element of one point is that point; means of several leave out how jumps and tractions vary within it.
            let bound = if points_per_direction == 1 { 1e-9 } else { 0.1 };
            assert!(worst < bound * largest, "{number}: {worst:e} of {largest:e}");
            assert!(loops.of_element(operators.n_elements()).is_none());
        }
    }
}

#[test]
fn friction_lowers_the_frequency_and_raises_the_damping_later_for_larger_mu() {
    let onset = |mu: f64| {
        let mut scene = quick();
        scene.interfaces.mu = mu;
        let run = go(&scene);
        let results: Vec<_> = run
            .amplitudes()
            .iter()
            .map(|a| a.point.result.as_ref().unwrap())
            .collect();
        for pair in results.windows(2) {
            assert!(
                pair[1].omega <= pair[0].omega * (1.0 + 1e-6),
                "mu {mu}: frequency falls"
            );
        }
        assert!(results[6].zeta > 1e-3, "mu {mu}: {}", results[6].zeta);
        results.iter().position(|r| r.zeta > 5e-4).unwrap()
    };
    let (low, middle, high) = (onset(0.05), onset(0.2), onset(0.6));
    assert!(low < middle && middle <= high, "{low} {middle} {high}");
}

#[test]
fn without_slip_there_is_no_damping() {
    let mut scene = quick();
    scene.interfaces.mu = 1e3;
    scene.analyses.backbone.commit = Commit::AtReversals;
    scene.analyses.backbone.amplitude_from = Length::from_si(1e-8);
    scene.analyses.backbone.amplitude_to = Length::from_si(3e-6);
    let run = go(&scene);
    for (a, zeta) in run.amplitudes().iter().zip(damping(&run)) {
        assert_eq!(a.fields.as_ref().unwrap().slip_fraction, 0.0);
        // With commits at reversals only, the path between them counts as straight: the remainder grows with the
        // amplitude squared and stays below 2e-6 here.
        let x = a.response_displacement.unwrap() / 3e-6;
        assert!(zeta.abs() < 2e-6 * (x * x).max(1e-4), "{x}: {zeta}");
    }
    // At a millimetre it is the damping of a joint that slips, and still no result: the floor contains it.
    scene.analyses.backbone.amplitude_to = Length::from_si(1e-3);
    let run = go(&scene);
    assert!(damping(&run)[6] > 5e-3, "{}", damping(&run)[6]);
    for b in &Summary::new(&run, Default::default(), None).backbone {
        assert_eq!((b.status, b.damping_ratio), (Status::BelowFloor, None));
    }
}

#[test]
fn without_slip_commits_at_every_vertex_leave_no_damping_at_all() {
    let mut scene = quick();
    scene.interfaces.mu = 1e3;
    // With half as many, points that nearly open slip between two vertices of the largest amplitude.
    scene.analyses.backbone.vertices_per_quarter = 8;
    scene.analyses.backbone.amplitude_from = Length::from_si(1e-7);
    scene.analyses.backbone.amplitude_to = Length::from_si(1e-3);
    assert_eq!(scene.analyses.backbone.commit, Commit::AtEveryVertex, "the default");
    let run = go(&scene);
    for (a, zeta) in run.amplitudes().iter().zip(damping(&run)) {
        // From 2e-4 m on points at the edge open and close, and what they lose in tangential stretch is dissipation of the law.
        let opens = a.fields.as_ref().unwrap().open_fraction > 0.0;
        assert!(opens || zeta.abs() < 1e-9, "{zeta:e}");
        assert_eq!(a.point.result.as_ref().unwrap().one_way, !opens);
    }
    // Both ways it is the same: nothing is lost between the vertices, and nothing is assumed.
    scene.analyses.backbone.cycles = Some(4);
    let both = go(&scene);
    for ((a, b), zeta) in run.amplitudes().iter().zip(both.amplitudes()).zip(damping(&both)) {
        let [a, b] = [a, b].map(|a| a.point.result.as_ref().unwrap());
        assert!(!b.one_way);
        let bound = (1e-2 * a.zeta).max(1e-9);
        assert!((zeta - a.zeta).abs() < bound, "{zeta:e} {:e}", a.zeta);
        let bound = if b.counts.open > 0 { 1e-4 } else { 1e-8 };
        assert!((a.omega / b.omega - 1.0).abs() < bound, "{} {}", a.omega, b.omega);
    }
}

#[test]
fn locked_bolts_leave_the_prestress_alone_and_stiffen_the_vibration() {
    let (mut scene, dead) = (quick(), go(&quick()));
    scene.bolts.behaviour = BoltBehaviour::Locked;
    let locked = go(&scene);
    let jump = |run: &Run| run.prestress.solution.displacement[..run.model.reduced.n_relative].to_vec();
    let largest = jump(&dead).iter().fold(0.0_f64, |a, u| a.max(u.abs()));
    for (a, b) in jump(&dead).iter().zip(jump(&locked)) {
        assert!((a - b).abs() < 1e-9 * largest, "{a} {b}");
    }
    // A constraint raises every frequency or leaves it; the joint's opening in bending is what the bolts resist.
    assert!(dead.validity().separation_modal_force.is_some() && locked.validity().separation_modal_force.is_none());
    for (a, b) in dead.frequencies.iter().zip(&locked.frequencies) {
        assert!(b / a > 1.0 - 1e-9, "{a} {b}");
    }
    let ratio = locked.frequencies[0] / dead.frequencies[0];
    assert!(ratio > 1.0 + 1e-5 && ratio < 1.01, "{ratio}");
    // Against the full model with the bolts locked by elimination.
    assert!(
        locked.model.facts.penalty_error < 1e-4,
        "{}",
        locked.model.facts.penalty_error
    );
    let free = &dead.model.facts.penalty_frequencies_hz;
    assert!(locked.model.facts.penalty_frequencies_hz[0] > free[0] * (1.0 + 1e-6));
    for (a, b) in dead.amplitudes().iter().zip(locked.amplitudes()) {
        let (dead, locked) = (a.point.result.as_ref().unwrap(), b.point.result.as_ref().unwrap());
        assert!(locked.omega > dead.omega, "{} {}", locked.omega, dead.omega);
        let fields = b.fields.as_ref().unwrap();
        let tolerance = scene.analyses.backbone.tolerance;
        let allowed = 1e-6 * locked.loop_area.abs() + 10.0 * tolerance * b.point.modal_force * locked.modal_amplitude;
        assert!((fields.dissipation - locked.loop_area).abs() <= allowed);
    }
    let cached = go(&scene);
    assert_eq!(locked.frequencies, cached.frequencies, "from the cache");
}

#[test]
fn faces_of_deformed_bodies_are_apart_by_the_jump() {
    for behaviour in [BoltBehaviour::DeadLoad, BoltBehaviour::Locked] {
        let mut scene = quick();
        scene.bolts.behaviour = behaviour;
        scene.output.deformed = true;
        scene.output.fields_at = Some(vec![2, 7]);
        let run = go(&scene);
        let structure = Structure::try_new(&scene, &Silent).unwrap();
        let Bodies::Meshed(bodies) = &structure.joint.bodies else {
            panic!("the benchmark has bodies");
        };
        let Sides::Pairs { top, bottom } = &bodies.sides else {
            panic!("the meshes of the benchmark match");
        };
        let deformed = run.deformed.as_ref().unwrap();
        assert_eq!(deformed.prestress.len(), bodies.assembly.mesh.nodes.len());
        let stored: Vec<bool> = deformed.peaks[0].iter().map(Option::is_some).collect();
        let expected: Vec<bool> = (1..=run.amplitudes().len())
            .map(|number| [2, 7].contains(&number))
            .collect();
        assert_eq!(stored, expected);
        let peak = |number: usize| {
            let fields = run.amplitudes()[number - 1].fields.as_ref().unwrap();
            let jump = fields.displacement.as_deref().unwrap();
            (jump, deformed.peaks[0][number - 1].as_deref().unwrap())
        };
        let at_rest = (
            run.prestress.solution.displacement.as_slice(),
            deformed.prestress.as_slice(),
        );
        for (jump, displacement) in [at_rest, peak(2), peak(7)] {
            let (mut error, mut size) = (0.0_f64, 0.0_f64);
            for (pair, (top, bottom)) in top.iter().zip(bottom).enumerate() {
                let apart = [0, 1, 2].map(|c| displacement[*top as usize][c] - displacement[*bottom as usize][c]);
                for (component, direction) in run.joint.frame.iter().enumerate() {
                    let along: f64 = (0..3).map(|c| apart[c] * direction[c]).sum();
                    error = error.max((along - jump[3 * pair + component]).abs());
                    size = size.max(along.abs());
                }
            }
            println!("{behaviour:?}: {error:.1e} of {size:.1e} m");
            assert!(error < 1e-9 * size, "{error:e} of {size:e}");
        }
        // The response from rest to the peak is the amplitude of the loop and what moves beside the mode.
        let (node, along) = (bodies.response_node as usize, bodies.response_direction);
        let response = |of: &[[f64; 3]]| (0..3).map(|c| of[node][c] * along[c]).sum::<f64>();
        for number in [2, 7] {
            let loop_of = &run.amplitudes()[number - 1];
            let moved = (response(peak(number).1) - response(&deformed.prestress)).abs();
            let range = loop_of.fields.as_ref().unwrap().response_motion;
            assert!((moved / range - 1.0).abs() < 0.1, "{moved:e} {range:e}");
        }
    }
    // Nothing is kept or computed unasked.
    let run = go(&quick());
    assert!(run.deformed.is_none());
    assert!(
        run.amplitudes()
            .iter()
            .all(|a| a.fields.as_ref().is_none_or(|f| f.displacement.is_none()))
    );
}

#[test]
fn few_vertices_resolve_the_loop() {
    let area = |vertices: usize| {
        let mut scene = quick();
        scene.analyses.backbone.vertices_per_quarter = vertices;
        scene.analyses.backbone.amplitudes = 1;
        scene.analyses.backbone.amplitude_from = Length::from_si(3e-4);
        go(&scene).amplitudes()[0].point.result.as_ref().unwrap().loop_area
    };
    let (coarse, middle, fine) = (area(4), area(8), area(32));
    assert!((coarse / fine - 1.0).abs() < 2e-3, "{coarse} {fine}");
    assert!((middle / fine - 1.0).abs() < 1e-3, "{middle} {fine}");
}

/// What the first cycles leave behind, points near the onset of slip keep for ever: after steps over the whole quarter the damping there
/// had been four times too large.
#[test]
fn loops_near_the_onset_of_slip_close_in_the_state_that_finer_paths_lead_to() {
    let zeta = |vertices: usize, cycles: Option<usize>| {
        let mut scene = quick();
        scene.interfaces.mu = 0.6;
        scene.bolts.load = Force::from_si(12e3);
        scene.interfaces.points_per_direction = 2;
        scene.analyses.backbone.vertices_per_quarter = vertices;
        scene.analyses.backbone.cycles = cycles;
        scene.analyses.backbone.amplitudes = 1;
        scene.analyses.backbone.amplitude_from = Length::from_si(2e-4);
        damping(&go(&scene))[0]
    };
    let (closed, tenth, fine) = (zeta(4, None), zeta(4, Some(10)), zeta(16, Some(10)));
    assert!(closed > 1e-4 && closed < 1e-3, "near the onset: {closed:e}");
    assert!((closed / tenth - 1.0).abs() < 0.03, "{closed:e} {tenth:e}");
    assert!((closed / fine - 1.0).abs() < 0.25, "{closed:e} {fine:e}");
}

#[test]
fn background_damping_is_added_to_the_total_alone() {
    let plain = go(&quick());
    let mut scene = quick();
    scene.background_damping = 0.001;
    let damped = go(&scene);
    let summary = |run: &Run| Summary::new(run, std::collections::BTreeMap::new(), None);
    for (a, b) in summary(&plain).backbone.iter().zip(&summary(&damped).backbone) {
        assert_eq!(a.friction_damping_ratio, b.friction_damping_ratio);
        assert_eq!(a.damping_ratio.map(|zeta| zeta + 0.001), b.damping_ratio);
        assert_eq!(
            a.damping_ratio_first_harmonic.map(|zeta| zeta + 0.001),
            b.damping_ratio_first_harmonic
        );
    }
    assert!(summary(&plain).backbone[6].damping_ratio.is_some());
}

#[test]
fn laws_agree_within_what_they_say_of_themselves() {
    let first = |kind| {
        let mut scene = quick();
        scene.interfaces.law.kind = kind;
        scene.analyses.backbone.amplitudes = 1;
        let run = go(&scene);
        (run.frequencies[0], run.law().clone())
    };
    let (summed, _) = first(LawKind::AsperitySum);
    let (tabulated, report) = first(LawKind::Tabulated);
    assert!((tabulated / summed - 1.0).abs() < 1e-5, "{tabulated} {summed}");
    let of_asperities = report.asperities.unwrap();
    let errors = [of_asperities.table_error_normal, of_asperities.table_error_tangential];
    assert!(errors[0].unwrap() <= 1e-5 && errors[1].unwrap() <= 1e-4);
    // Eq. (29) does not follow the measured population: the fit says so, and the frequency shows it.
    let (fitted, report) = first(LawKind::Fitted);
    let rms = report.asperities.unwrap().fit_rms_tangential;
    assert!(rms > 0.1, "{rms}");
    assert!(
        fitted != tabulated && (fitted / summed - 1.0).abs() < 0.1,
        "{fitted} {summed}"
    );
}

#[test]
fn a_synthetic_scan_is_characterised_element_by_element() {
    let mut scene = quick();
    // A coarser grid than the default keeps this quick; still dozens of peaks per element.
    scene.interfaces.surface = Surface::SyntheticScan(SyntheticScan {
        step: [60e-6, 80e-6].map(Length::from_si),
        bootstrap: 4,
        ..SyntheticScan::default()
    });
    scene.interfaces.gap = Gap::Scan;
    scene.interfaces.law.kind = LawKind::Fitted;
    scene.analyses.backbone.amplitudes = 2;
    let run = go(&scene);
    assert_eq!(
        run.law().asperities.as_ref().unwrap().n_populations,
        run.interface.operators().n_elements()
    );
    assert!(run.interface.gap().unwrap().iter().copied().fold(0.0, f64::max) > 1e-7);
    assert!(run.amplitudes().iter().all(|a| a.point.result.is_ok()));
}

#[test]
fn the_cache_serves_the_same_model_and_ignores_damaged_files() {
    #[derive(Default)]
    struct Heard(Mutex<Vec<Stage>>);
    impl Progress for Heard {
        fn begin(&self, stage: Stage) {
            self.0.lock().unwrap().push(stage);
        }
    }
    let mut scene = quick();
    scene.analyses.backbone.amplitudes = 1;
    let folder = std::env::temp_dir().join(format!("analyses-damaged-{}", std::process::id()));
    let options = Options::cached(&folder);
    let with = |heard: &Heard| {
        let run = run(&scene, &options, heard).unwrap();
        run.checkpoints.remove();
        run
    };
    let fresh = with(&Heard::default());
    let heard = Heard::default();
    let cached = with(&heard);
    assert!(!heard.0.lock().unwrap().contains(&Stage::Reduce));
    assert_eq!(fresh.amplitudes()[0].point.result, cached.amplitudes()[0].point.result);
    let file = file_of(&folder, "reduced-");
    let mut bytes = std::fs::read(&file).unwrap();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    std::fs::write(&file, bytes).unwrap();
    let heard = Heard::default();
    let again = with(&heard);
    assert!(
        heard.0.lock().unwrap().contains(&Stage::Reduce),
        "a damaged file must not be used"
    );
    assert_eq!(fresh.amplitudes()[0].point.result, again.amplitudes()[0].point.result);
    std::fs::remove_dir_all(folder).unwrap();
}

/// A folder of a test's own with the reduced model that all tests share.
fn folder_with_model(name: &str) -> TemporaryFolder {
    let folder = TemporaryFolder::new(&format!("analyses-{name}"));
    copy_of_cache("reduced-", &folder);
    folder
}

/// Copies the file of the common cache whose name begins so and that belongs to the model of [`quick`]; other tests leave those of other models there.
fn copy_of_cache(name: &str, folder: &Path) {
    let (cache, end) = ready();
    let file = format!("{name}{end}");
    std::fs::copy(cache.join(&file), folder.join(&file)).unwrap();
}

#[test]
fn modes_from_the_cache_are_those_found_again() {
    let scene = quick();
    let structure = Structure::try_new(&scene, &Silent).unwrap();
    let folder = folder_with_model("modes");
    let options = Options::cached(&*folder);
    let model = structure.reduce(&options, &Silent).unwrap();
    let motion = Mat::from_fn(model.reduced.size(), 1, |i, _| 1e-6 * (i as f64).sin());
    // How often it is asked whether to stop tells how much is done.
    let displacements = || {
        let asked = AtomicUsize::new(0);
        let stop = || {
            asked.fetch_add(1, Ordering::Relaxed);
            false
        };
        let limits = Limits::default().until(&stop);
        let found = structure
            .displacements(&model, motion.as_ref(), &options, limits)
            .unwrap();
        (found, asked.into_inner())
    };
    let (found, all) = displacements();
    go(&scene);
    copy_of_cache("modes-", &folder);
    let (with_modes, less) = displacements();
    assert!(with_modes == found && 2 * less < all, "{less} {all}");
    let path = file_of(&folder, "modes-");
    let intact = std::fs::read(&path).unwrap();
    for place in (0..intact.len()).step_by(intact.len() / 4) {
        let mut damaged = intact.clone();
        damaged[place] ^= 1 << (place % 8);
        std::fs::write(&path, damaged).unwrap();
        assert_eq!(displacements(), (found.clone(), all));
    }
}

/// The file in a folder whose name begins so.
fn file_of(folder: &Path, name: &str) -> PathBuf {
    let mut entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap());
    let found = entries.find(|e| e.file_name().to_string_lossy().starts_with(name));
    found.unwrap().path()
}

/// Every bit of the header, which says sizes, mass and frequencies, and of some of the numbers.
#[test]
fn a_cached_model_with_any_bit_flipped_is_computed_again() {
    let scene = quick();
    let folder = folder_with_model("flipped");
    let path = file_of(&folder, "reduced-");
    let intact = std::fs::read(&path).unwrap();
    let header = intact
        .iter()
        .enumerate()
        .filter(|(_, byte)| **byte == b'\n')
        .nth(1)
        .unwrap()
        .0;
    let structure = Structure::try_new(&scene, &Silent).unwrap();
    // Whether the file is taken for the model; computing another one is not what this test is about.
    let is_read = |options: &Options| {
        struct Stop(Mutex<bool>);
        impl Progress for Stop {
            fn begin(&self, _: Stage) {
                std::panic::panic_any("computed again");
            }
            fn note(&self, text: &str) {
                *self.0.lock().unwrap() |= text.contains("read from the cache");
            }
        }
        let stop = Stop(Mutex::new(false));
        let reduced = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| structure.reduce(options, &stop)));
        assert_eq!(reduced.is_ok(), *stop.0.lock().unwrap());
        reduced.is_ok()
    };
    let options = Options::cached(&*folder);
    assert!(is_read(&options));
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let payload = (header..intact.len()).step_by(intact.len() / 50);
    let taken: Vec<usize> = (0..header)
        .step_by(7)
        .chain(payload)
        .filter(|&place| {
            let mut damaged = intact.clone();
            damaged[place] ^= 1 << (place % 8);
            std::fs::write(&path, damaged).unwrap();
            is_read(&options)
        })
        .collect();
    std::fs::write(&path, &intact).unwrap();
    let of_another_build = Options {
        build: Some("another".into()),
        ..options.clone()
    };
    let [own, other] = [is_read(&options), is_read(&of_another_build)];
    std::panic::set_hook(usual);
    assert_eq!(taken, Vec::<usize>::new());
    assert!(own && !other);
}

#[test]
fn a_line_of_a_checkpoint_with_a_digit_changed_counts_as_not_done() {
    let mut scene = quick();
    scene.name = "digits".into();
    scene.analyses.backbone.amplitudes = 3;
    let folder = folder_with_model("digits");
    let options = Options::cached(&*folder);
    struct Notes(Mutex<String>);
    impl Progress for Notes {
        fn note(&self, text: &str) {
            *self.0.lock().unwrap() += text;
        }
    }
    let go = || {
        let notes = Notes(Mutex::default());
        let run = run(&scene, &options, &notes).unwrap();
        let frequencies: Vec<f64> = (run.amplitudes().iter())
            .map(|a| a.point.result.as_ref().unwrap().omega)
            .collect();
        (frequencies, notes.0.into_inner().unwrap())
    };
    let (undisturbed, _) = go();
    let path = file_of(&folder, "loops-");
    let intact = std::fs::read_to_string(&path).unwrap();
    assert_eq!(intact.lines().count(), 3);
    assert_eq!(go().0, undisturbed);
    let omega = intact.find("\"omega\":").unwrap() + 8;
    // A digit of the frequency, of the checksum, and of the number of the amplitude.
    for place in [omega, omega + 3, 0, intact.find("\"index\":").unwrap() + 8] {
        let mut damaged = intact.clone().into_bytes();
        damaged[place] = if damaged[place] == b'2' { b'1' } else { b'2' };
        std::fs::write(&path, damaged).unwrap();
        let (found, notes) = go();
        assert_eq!(found, undisturbed, "byte {place}");
        assert!(notes.contains("2 of 3 amplitudes were taken"), "{notes}");
    }
}

#[test]
fn a_gap_beyond_all_closure_and_bad_scenes_are_refused_by_name() {
    let parse = |text: &str| {
        Scene::from_json(text, "scene.json", "scene", &BENCHMARKS)
            .unwrap_err()
            .to_string()
    };
    let units =
        r#""units": {"length": "m", "mass": "kg", "time": "s"}, "structure": {"benchmark": "brake-reuss-beam"}"#;
    assert!(parse("{}").contains("units"));
    assert!(parse(&format!("{{{units}, \"frobnicate\": 1}}")).contains("frobnicate"));
    assert!(parse(&format!("{{{units}, \"model\": {{\"n_modes\": 1}}}}")).contains("n_modes"));
    assert!(parse(&format!("{{{units}, \"interfaces\": {{\"mu\": -0.1}}}}")).contains("interfaces.mu = -0.1"));
    assert!(
        parse(&format!(
            "{{{units}, \"analyses\": {{\"modes\": {{\"followed\": [11]}}}}}}"
        ))
        .contains("analyses.modes.followed")
    );
    assert!(parse(&format!("{{{units}, \"interfaces\": {{\"gap\": \"scan\"}}}}")).contains("interfaces.gap"));
    assert!(parse(&format!("{{{units}, \"output\": {{\"fields_at\": [21]}}}}")).contains("fields_at"));
    assert!(parse("{\"units\": {\"length\": \"furlong\", \"mass\": \"kg\", \"time\": \"s\"}}").contains("furlong"));
    assert!(parse(&format!("{{{units}, \"bolts\": {{\"behaviour\": \"glued\"}}}}")).contains("glued"));
    let mut scene = quick();
    scene.bolts.load = Force::from_si(f64::NAN);
    assert!(matches!(
        run(&scene, &Options::default(), &Silent),
        Err(Error::Scene(scenes::Error::Value {
            field: "bolts.load",
            ..
        }))
    ));
}

#[test]
fn quantities_are_converted_where_they_are_given() {
    let mm = r#"{"units": {"length": "mm", "mass": "t", "time": "s"},
        "structure": {"benchmark": "brake-reuss-beam"}, "bolts": {"load": 12845.0},
        "model": {"material": {"youngs_modulus": 192850.0, "density": 7.8578e-9}},
        "analyses": {"backbone": {"amplitude_from": 1e-4}}}"#;
    let scene = Scene::from_json(mm, "mm.json", "x", &BENCHMARKS).unwrap();
    let si = beam("x");
    assert!((scene.model.material.unwrap().youngs_modulus.si() / 192.85e9 - 1.0).abs() < 1e-15);
    assert!((scene.model.material.unwrap().density.unwrap().si() / 7857.8 - 1.0).abs() < 1e-15);
    assert_eq!(
        scene.model.material.unwrap().poisson_ratio,
        si.model.material.unwrap().poisson_ratio
    );
    assert_eq!(
        scene.model.material.unwrap().hardness,
        si.model.material.unwrap().hardness,
        "defaults are SI and stay so"
    );
    assert_eq!(scene.bolts, si.bolts);
    assert_eq!(scene.bolts.behaviour, BoltBehaviour::DeadLoad);
    let locked = mm.replace("12845.0", "12845.0, \"behaviour\": \"locked\"");
    let locked = Scene::from_json(&locked, "mm.json", "x", &BENCHMARKS).unwrap();
    assert_eq!(locked.bolts.behaviour, BoltBehaviour::Locked);
    assert_eq!(locked.bolts.load, si.bolts.load);
    assert!((scene.analyses.backbone.amplitude_from.si() / 1e-7 - 1.0).abs() < 1e-15);
    assert_eq!(scene.analyses.backbone.amplitude_to, si.analyses.backbone.amplitude_to);
}

#[test]
fn a_mode_that_does_not_move_the_response_point_is_refused() {
    // The second mode bends across the beam, the response is normal to the interface.
    let mut scene = quick();
    scene.analyses.modes.followed = vec![2];
    let error = run(&scene, &Options::cached(cache()), &Silent).unwrap_err();
    assert!(matches!(error, Error::NoResponse { mode: 2, .. }), "{error}");
}

/// Stops a run after so many amplitudes.
struct Impatient {
    left: std::sync::atomic::AtomicUsize,
}

impl Impatient {
    fn after(amplitudes: usize) -> Self {
        Self {
            left: amplitudes.into(),
        }
    }
}

impl Progress for Impatient {
    fn fraction(&self, stage: Stage, _: f64) {
        use std::sync::atomic::Ordering::Relaxed;
        if stage == Stage::Backbone {
            self.left
                .fetch_update(Relaxed, Relaxed, |n| Some(n.saturating_sub(1)))
                .unwrap();
        }
    }

    fn interrupted(&self) -> bool {
        self.left.load(std::sync::atomic::Ordering::Relaxed) == 0
    }
}

/// Amplitudes that a run tells.
#[derive(Default)]
struct Told(Mutex<Vec<Amplitude>>);

impl Progress for Told {
    fn amplitude(&self, found: &Amplitude) {
        self.0.lock().unwrap().push(*found);
    }
}

/// What a run has to tell, by its summary.
fn amplitudes(run: &Run) -> Vec<Amplitude> {
    let summary = Summary::new(run, Default::default(), None);
    let amplitude = |b: &analyses::results::summary::BackboneSummary| Amplitude {
        mode: 1,
        amplitude_m: b.response_displacement.unwrap(),
        frequency_hz: b.frequency_hz.unwrap(),
        damping_ratio: b.damping_ratio,
    };
    summary.backbone.iter().map(amplitude).collect()
}

#[test]
fn an_interrupted_run_goes_on_to_the_same_bits() {
    let mut scene = quick();
    scene.name = "interrupted".into();
    scene.output.fields_at = Some(vec![2, 7]);
    let numbers = |run: &Run| -> String {
        run.amplitudes()
            .iter()
            .map(|a| format!("{:?} {:?} {:?}\n", a.point, a.fields, a.response_acceleration))
            .collect()
    };
    // A folder of its own with the common reduced model, so that only these runs leave loops there.
    let folder = std::env::temp_dir().join(format!("analyses-interrupted-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    copy_of_cache("reduced-", &folder);
    let options = Options::cached(&folder);
    let loops = || {
        let mut entries = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path());
        entries.find(|p| p.extension().is_some_and(|e| e == "jsonl"))
    };
    // Alone, a thread stops where it is told to; the others of a pool would finish what they have begun.
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let finished = run(&scene, &options, &Silent).unwrap();
    let undisturbed = numbers(&finished);
    assert!(loops().is_some(), "the results are not safe yet");
    finished.checkpoints.remove();
    assert!(loops().is_none(), "a finished run leaves no loops behind");
    for stops in [vec![1], vec![3, 1, 2], vec![6]] {
        for &stop in &stops {
            let result = one_thread.install(|| run(&scene, &options, &Impatient::after(stop)));
            assert!(matches!(result, Err(Error::Solver(cqsma_solver::Error::Interrupted))));
        }
        // The last write was cut short as well.
        let path = loops().unwrap();
        let text = std::fs::read(&path).unwrap();
        std::fs::write(&path, &text[..text.len() - 7]).unwrap();
        let told = Told::default();
        let resumed = run(&scene, &options, &told).unwrap();
        assert!(numbers(&resumed) == undisturbed, "{stops:?}");
        let mut told = told.0.into_inner().unwrap();
        told.sort_by(|a, b| a.amplitude_m.total_cmp(&b.amplitude_m));
        assert_eq!(told, amplitudes(&resumed), "{stops:?}");
        resumed.checkpoints.remove();
        assert!(loops().is_none());
    }
    // Loops of another scene are not taken for those of this one.
    assert!(
        one_thread
            .install(|| run(&scene, &options, &Impatient::after(2)))
            .is_err()
    );
    let mut other = scene.clone();
    other.interfaces.mu = 0.3;
    let of_other = run(&other, &options, &Silent).unwrap();
    assert!(numbers(&of_other) != undisturbed);
    of_other.checkpoints.remove();
    assert!(loops().is_some());
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn prestress_is_found_from_far_guesses() {
    for gap in [Gap::Flat, Gap::Measured] {
        let mut scene = quick();
        scene.interfaces.gap = gap;
        let options = Options::cached(cache());
        let prepared = prepare(&scene, &options, &Silent).unwrap();
        let reduced = &prepared.model().reduced;
        let force = InterfaceForce::new(&prepared.interface().interface);
        let (load, start) = (prepared.static_load(), prepared.start());
        let newton = NewtonSettings::default();
        let from = |factor: f64| {
            let start: Vec<f64> = start.iter().map(|u| factor * u).collect();
            prestress::solve(reduced.stiffness.as_ref(), &force, &load, &start, &newton)
                .unwrap()
                .unwrap_or_else(|failure| panic!("{gap:?} {factor}: {failure:?}"))
        };
        let usual = from(1.0);
        let largest = usual.displacement.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        for factor in [0.3, 0.5, 2.0, 10.0, 100.0] {
            let other = from(factor);
            let pairs = usual.displacement.iter().zip(&other.displacement);
            let difference = pairs.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            println!(
                "{gap:?} {factor}: {:?} iterations, {difference:e} of {largest:e}",
                other.iterations
            );
            assert!(
                difference < 1e-6 * largest,
                "{gap:?} {factor}: {difference:e} of {largest:e}"
            );
        }
    }
}

#[test]
fn amplitudes_from_a_femtometre_to_a_metre_are_found_and_noise_is_called_so() {
    let mut scene = quick();
    scene.analyses.backbone.amplitude_from = Length::from_si(1e-15);
    scene.analyses.backbone.amplitude_to = Length::from_si(1.0);
    scene.analyses.backbone.amplitudes = 16;
    let run = go(&scene);
    let summary = Summary::new(&run, Default::default(), None);
    let linear = run.frequencies[0];
    for (amplitude, b) in run.amplitudes().iter().zip(&summary.backbone) {
        println!(
            "{:?} m: {:?} Hz, {:?}, floor {:?}, {:?}",
            b.response_displacement, b.frequency_hz, b.damping_ratio, b.damping_floor, amplitude.point.effort
        );
        assert!(b.converged);
        let (x, f) = (b.response_displacement.unwrap(), b.frequency_hz.unwrap());
        if x < 1e-8 {
            // The stuck structure within what round-off leaves; no damping is claimed.
            assert!((f / linear - 1.0).abs() < 1e-6 + b.damping_floor.unwrap(), "{x}: {f}");
            assert_eq!((b.status, b.damping_ratio), (Status::BelowFloor, None), "{x}");
        }
        // Points slip from 3e-5 m on.
        match x {
            x if x > 5e-5 => assert_eq!(b.status, Status::Resolved, "{x}"),
            x if x < 2e-5 => assert_eq!((b.status, b.slip_fraction), (Status::BelowFloor, Some(0.0)), "{x}"),
            _ => {}
        }
    }
}
