//! The methods beside CQSMA on the same scenes.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{BENCHMARKS, beam};
use analyses::results::summary::Summary;
use analyses::run;
use contact_laws::{ElasticCurves, FrictionalLaw, HistoryRule, PointParameters, RegimeCounts, Sticking};
use cqsma_solver::cqsma::LoopObserver;
use cqsma_solver::cqsma::{self, Cycles, Settings};
use cqsma_solver::{HystereticForce, LoopResult, NewtonSettings, NoObserver, PatternView, modes, prestress};
use faer::Mat;
use joint_model::benchmark::RefinementLevel;
use joints::Options;
use joints::interface::InterfaceForce;
use joints::progress::Silent;
use scenes::{Gap, Length, Method, Scene};
use std::collections::BTreeMap;
use std::sync::Arc;
use zte_assembly::{Element, Interface, InterfaceMesh, Operators, State, Workspace};

fn loops(interface: &Interface, displacement: &[f64], state: State, k: &Mat<f64>, m: &Mat<f64>) -> Vec<LoopResult> {
    let force = InterfaceForce::new(interface);
    let mut line = modes::linearise(k.as_ref(), m.as_ref(), &force, displacement.to_vec(), state, 1).unwrap();
    line.orient(&[1.0; 12]).unwrap();
    let forces = [20.0, 75.0, 80.0, 150.0];
    let settings = Settings {
        vertices_per_quarter: 8,
        ..Settings::default()
    };
    let points = cqsma::run(&line, &force, &forces, &settings, |_| NoObserver).unwrap();
    points.into_iter().map(|(point, _)| point.result.unwrap()).collect()
}

#[test]
fn where_pressure_stays_qsma_is_cqsma() {
    // One square of 1 cm on springs, pressed unevenly, moving along x: pressures do not change, points slip one by one.
    let mesh = InterfaceMesh::flat(
        vec![[0.0, 0.0], [0.01, 0.0], [0.01, 0.01], [0.0, 0.01]],
        vec![Element::quad4([0, 1, 2, 3])],
    );
    let operators = Arc::new(Operators::try_new(&mesh, 3).unwrap());
    let n = operators.n_points();
    let curves = PointParameters::uniform(ElasticCurves::try_new(3e12, [1e12, 2e12]).unwrap(), n);
    let law = FrictionalLaw::try_new(curves, PointParameters::uniform(0.3, n), HistoryRule::Incremental).unwrap();
    let interface = Interface::try_new(operators, vec![(0..n, Arc::new(law))], vec![0.0; n]).unwrap();

    // Stiff against everything but uniform motion, which keeps the lowest mode uniform.
    let stiffness = Mat::from_fn(12, 12, |i, j| match (i == j, i % 3 == j % 3) {
        (true, _) => 1e7 + 0.75e8,
        (_, true) => -0.25e8,
        _ => 0.0,
    });
    let mass = Mat::identity(12, 12);
    let (mut load, mut start) = (vec![0.0; 12], vec![0.0; 12]);
    for node in 0..4 {
        load[3 * node + 2] = 40.0 + 60.0 * node as f64;
        start[3 * node + 2] = 1.5e-6;
    }
    // A little slip is left from the static load.
    load[0] = 30.0;
    let force = InterfaceForce::new(&interface);
    let rest = prestress::solve(stiffness.as_ref(), &force, &load, &start, &NewtonSettings::default())
        .unwrap()
        .unwrap();
    let u = &rest.displacement;
    let (linear, at_rest) = interface.linearised(u, &rest.state).unwrap();
    let coupled = loops(&interface, u, rest.state.clone(), &stiffness, &mass);
    let decoupled = loops(&linear, u, at_rest, &stiffness, &mass);
    let slipping: Vec<usize> = coupled.iter().map(|r| r.counts.slip).collect();
    assert!(slipping[0] < slipping[1] && slipping[1] < slipping[3], "{slipping:?}");
    assert!(coupled[3].zeta > 1e-2, "{}", coupled[3].zeta);
    for (a, b) in coupled.iter().zip(&decoupled) {
        // Shakedown leaves points exactly at their limit, where round-off decides.
        assert!(
            a.counts.slip.abs_diff(b.counts.slip) <= 1,
            "{:?} {:?}",
            a.counts,
            b.counts
        );
        assert!((a.omega / b.omega - 1.0).abs() < 1e-7, "{} {}", a.omega, b.omega);
        assert!((a.zeta - b.zeta).abs() < 1e-7, "{} {}", a.zeta, b.zeta);
    }
}

/// A force that does not say that it has no friction.
struct Reticent<'a>(InterfaceForce<'a>);

impl HystereticForce for Reticent<'_> {
    type State = State;
    type Workspace = Workspace;

    fn n_dofs(&self) -> usize {
        self.0.n_dofs()
    }

    fn pattern(&self) -> PatternView<'_> {
        self.0.pattern()
    }

    fn initial_state(&self) -> State {
        self.0.initial_state()
    }

    fn workspace(&self) -> Workspace {
        self.0.workspace()
    }

    fn evaluate(
        &self,
        u: &[f64],
        sticking: Sticking,
        begin: &State,
        end: &mut State,
        workspace: &mut Workspace,
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> RegimeCounts {
        self.0.evaluate(u, sticking, begin, end, workspace, force, tangent)
    }
}

#[derive(Default)]
struct Path(Vec<(f64, Vec<f64>)>);

impl<W> LoopObserver<W> for Path {
    fn begin(&mut self) {
        self.0.clear();
    }

    fn vertex(&mut self, modal_force: f64, displacement: &[f64], _: &W) {
        self.0.push((modal_force, displacement.to_vec()));
    }
}

#[test]
fn without_friction_one_way_of_a_loop_is_the_whole_loop() {
    let mut scene = beam("quick");
    scene.model.refinement = RefinementLevel::Quick;
    scene.interfaces.gap = Gap::Flat;
    scene.interfaces.mu = 0.0;
    scene.analyses.backbone.amplitudes = 1;
    let run = run(&scene, &Options::default(), &Silent).unwrap();
    let force = InterfaceForce::new(&run.interface);
    assert!(!force.dissipates());
    let (reduced, rest) = (&run.model.reduced, &run.prestress);
    let (k, m) = (reduced.stiffness.as_ref(), reduced.mass.as_ref());
    let line = modes::linearise(
        k,
        m,
        &force,
        rest.solution.displacement.clone(),
        rest.solution.state.clone(),
        1,
    )
    .unwrap();
    let forces = [0.5, 5.0, 20.0];
    let mut settings = Settings::default();
    settings.newton.tolerance = 1e-11;
    let one_way = cqsma::run(&line, &force, &forces, &settings, |_| Path::default()).unwrap();
    // So many cycles are measured both ways, whatever the cycle before them tells.
    settings.cycles = Cycles::Fixed(2);
    let both = cqsma::run(&line, &Reticent(force), &forces, &settings, |_| Path::default()).unwrap();
    for ((a, path), (b, full)) in one_way.iter().zip(&both) {
        let (found, expected) = (a.result.as_ref().unwrap(), b.result.as_ref().unwrap());
        println!(
            "{}: {} and {} iterations, frequency {:e}, damping {:e} and {:e}, open {} and {}",
            a.modal_force,
            a.effort.iterations,
            b.effort.iterations,
            found.omega / expected.omega - 1.0,
            found.zeta,
            expected.zeta,
            found.counts.open,
            expected.counts.open,
        );
        assert!((found.omega / expected.omega - 1.0).abs() < 1e-9);
        for (a, b) in found.half_omegas.iter().zip(&expected.half_omegas) {
            assert!((a / b - 1.0).abs() < 1e-9);
        }
        assert!(found.zeta.abs() < 1e-14 && expected.zeta.abs() < 1e-9);
        assert!(found.closed && found.one_way && !expected.one_way);
        assert_eq!(found.counts, expected.counts);
        assert_eq!(found.hysteresis.force, expected.hysteresis.force);
        assert_eq!(path.0.len(), full.0.len());
        for ((f, u), (g, v)) in path.0.iter().zip(&full.0) {
            assert_eq!(f, g);
            let size = v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            let worst = u.iter().zip(v).fold(0.0_f64, |most, (u, v)| most.max((u - v).abs()));
            assert!(worst < 1e-9 * size, "{f}: {worst:e} of {size:e}");
        }
        assert!(a.effort.iterations < b.effort.iterations);
    }
    let summary = serde_json::to_value(Summary::new(&run, BTreeMap::new(), None)).unwrap();
    assert!(summary["skipped"]["gap"].is_string() && summary["skipped"]["way_back_of_loops"].is_string());
}

/// Rough faces, which open: the loops shake down, where one loading curve counts what slips once.
#[test]
fn slip_that_shakes_down_is_damping_for_masings_rule_alone() {
    let mut scene = beam("quick");
    scene.model.refinement = RefinementLevel::Quick;
    scene.interfaces.gap = Gap::Measured;
    scene.analyses.backbone.amplitudes = 9;
    scene.analyses.backbone.amplitude_from = Length::from_si(1e-8);
    scene.analyses.backbone.methods = vec![Method::Rqnma, Method::Qsma, Method::Masing];
    let run = run(&scene, &Options::default(), &Silent).unwrap();
    let mut counted = 0;
    for (i, amplitude) in run.amplitudes().iter().enumerate() {
        let reference = amplitude.point.result.as_ref().unwrap();
        let [rqnma, qsma, masing] = [0, 1, 2].map(|m| *run.first().methods[m].points[i].result.as_ref().unwrap());
        for (name, found) in [("rqnma", rqnma), ("qsma", qsma), ("masing", masing)] {
            let x = amplitude.response_displacement.unwrap();
            let frequency = found.harmonic_omega / reference.harmonic_omega - 1.0;
            println!(
                "{x:10.3e} m {:.3e} {name:>8} {frequency:+.2e} {:?}",
                reference.zeta, found.zeta
            );
            let allowed = if i == 0 { 1e-6 } else { 0.03 };
            assert!(frequency.abs() < allowed, "{name} {x:e}: {frequency:e}");
            if reference.zeta > 5e-3 {
                assert!((found.zeta.unwrap() / reference.zeta - 1.0).abs() < 0.5, "{name} {x:e}");
            }
        }
        if !reference.is_resolved() {
            // Closed loops have nothing; neither has QSMA, whose loops close as well.
            assert!(qsma.zeta.is_none(), "{:?}", qsma.zeta);
            counted += usize::from(rqnma.zeta.is_some_and(|zeta| zeta > 1e-5));
        }
    }
    assert!(counted > 0, "one loading curve slips where closed loops do not");
}

#[test]
fn all_methods_agree_at_small_amplitude_and_roughly_beyond() {
    let mut scene = beam("quick");
    scene.model.refinement = RefinementLevel::Quick;
    scene.analyses.backbone.amplitudes = 6;
    scene.analyses.backbone.amplitude_from = Length::from_si(1e-8);
    scene.analyses.backbone.methods = vec![Method::Rqnma, Method::Qsma, Method::Masing];
    let run = run(&scene, &Options::default(), &Silent).unwrap();
    let asked: Vec<Method> = run.first().methods.iter().map(|m| m.method).collect();
    assert_eq!(asked, scene.analyses.backbone.methods);

    for (i, amplitude) in run.amplitudes().iter().enumerate() {
        let reference = amplitude.point.result.as_ref().unwrap();
        let x = amplitude.response_displacement.unwrap();
        println!("{x:10.3e} m  cqsma {:.3} rad/s {:.3e}", reference.omega, reference.zeta);
        for method in &run.first().methods {
            let found = method.points[i].result.as_ref().unwrap();
            let name = method.method.name();
            let frequency = found.omega / reference.omega - 1.0;
            let zeta = found.zeta.unwrap_or(0.0);
            println!(
                "{:>22} {frequency:+.2e} {zeta:.3e} at {:.3e} m",
                name, found.response_displacement
            );
            let allowed = if i == 0 { 1e-6 } else { 0.03 };
            assert!(frequency.abs() < allowed, "{name} {x:e}: {frequency:e}");
            assert!((found.response_displacement / x - 1.0).abs() < 0.3, "{name} {x:e}");
            assert!((found.modal_force / found.modal_amplitude / found.omega.powi(2) - 1.0).abs() < 1e-9);
            if reference.zeta > 5e-3 {
                assert!((zeta / reference.zeta - 1.0).abs() < 0.3, "{name} {x:e}: {zeta:e}");
            }
        }
    }

    let summary = serde_json::to_value(Summary::new(&run, BTreeMap::new(), None)).unwrap();
    for name in ["qsma", "masing", "rqnma"] {
        let points = summary["methods"][name].as_array().unwrap();
        assert_eq!(points.len(), 6);
        assert!(
            points
                .iter()
                .all(|p| p["converged"] == true && p["frequency_hz"].is_f64())
        );
        assert!(points[5]["damping_ratio"].as_f64().unwrap() > points[5]["damping_floor"].as_f64().unwrap());
    }
    // Below the first slip there is no damping in a law that is linear there.
    assert!(summary["methods"]["qsma"][0]["damping_ratio"].is_null());
}

#[test]
fn methods_are_asked_for_by_name_and_once() {
    let scene = |more: &str| {
        let units =
            r#""units": {"length": "m", "mass": "kg", "time": "s"}, "structure": {"benchmark": "brake-reuss-beam"}"#;
        Scene::from_json(&format!("{{{units}{more}}}"), "scene.json", "scene", &BENCHMARKS)
    };
    assert_eq!(scene("").unwrap().analyses.backbone.methods, []);
    let asking = |methods: &str| scene(&format!(r#", "analyses": {{"backbone": {{"methods": {methods}}}}}"#));
    let named = asking(r#"["masing", "qsma", "rqnma"]"#).unwrap();
    let named = named.analyses.backbone.methods;
    let all = [Method::Masing, Method::Qsma, Method::Rqnma];
    assert_eq!(named, all);
    for method in named {
        assert_eq!(serde_json::to_value(method).unwrap(), method.name());
    }
    let error = |methods| asking(methods).unwrap_err().to_string();
    assert!(error(r#"["harmonic-balance"]"#).contains("harmonic-balance"));
    let repeated = error(r#"["qsma", "masing", "qsma"]"#);
    assert!(repeated.contains("analyses.backbone.methods = 3"), "{repeated}");
}

#[test]
fn a_joint_that_is_nearly_its_own_mirror_image_is_solved_by_reflected_parts_and_no_other() {
    for (gap, times, is_reflected) in [
        (Gap::Flat, 1.0, true),
        (Gap::Measured, 1.0, true),
        (Gap::Measured, 4.0, false),
    ] {
        let mut scene = beam("quick");
        scene.model.refinement = RefinementLevel::Quick;
        scene.interfaces.gap = gap;
        scene.interfaces.scale.gap = times;
        scene.analyses.backbone.amplitudes = 1;
        let run = run(&scene, &Options::default(), &Silent).unwrap();
        let force = InterfaceForce::new(&run.interface);
        let (reduced, rest) = (&run.model.reduced, &run.prestress.solution);
        let (k, m) = (reduced.stiffness.as_ref(), reduced.mass.as_ref());
        let (displacement, state) = (&rest.displacement, &rest.state);
        let line = modes::linearise(k, m, &force, displacement.clone(), state.clone(), 1).unwrap();
        let hidden = Reticent(InterfaceForce::new(&run.interface));
        let whole = modes::linearise(k, m, &hidden, displacement.clone(), state.clone(), 1).unwrap();
        // By parts, an antisymmetric part that is zero stays zero to the last bit.
        let reflections = force.reflections();
        let across = &reflections[1];
        let nd = reduced.n_relative;
        let any = |i: usize| (1.0 + i as f64).sin();
        let even: Vec<f64> = (0..k.size())
            .map(|i| match i < nd {
                true => {
                    let (image, sign) = across.image(i);
                    any(i) + sign * any(image)
                }
                false => any(i),
            })
            .collect();
        let mut found = vec![0.0; even.len()];
        line.preconditioner_solve_into(&even, &mut found);
        let stays = (0..nd).all(|i| {
            let (image, sign) = across.image(i);
            found[i] == sign * found[image]
        });
        assert_eq!(stays, is_reflected);
        assert!(is_reflected || line.preconditioner_tangent() == line.stuck_tangent());
        // It is exact for the tangent that it names.
        let elastic = k.product(Mat::from_fn(found.len(), 1, |i, _| found[i]).as_ref());
        let mut back: Vec<f64> = elastic.col(0).iter().copied().collect();
        let pattern = force.pattern();
        pattern.add_product(line.preconditioner_tangent(), &found, &mut back);
        let largest = even.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (a, b) in back.iter().zip(&even) {
            assert!((a - b).abs() < 1e-8 * largest, "{a} {b}");
        }
        assert_eq!(line.stuck_tangent(), whole.stuck_tangent());
        assert_eq!(line.eigenvalues, whole.eigenvalues);
        let forces = [5.0, 100.0];
        let mut settings = Settings::default();
        settings.newton.tolerance = 1e-11;
        let found = cqsma::run(&line, &force, &forces, &settings, |_| NoObserver).unwrap();
        let expected = cqsma::run(&whole, &hidden, &forces, &settings, |_| NoObserver).unwrap();
        for ((a, _), (b, _)) in found.iter().zip(&expected) {
            let (a, b) = (a.result.as_ref().unwrap(), b.result.as_ref().unwrap());
            println!(
                "frequency {:e}, damping {:e} of {:e}",
                a.omega / b.omega - 1.0,
                a.zeta - b.zeta,
                b.zeta
            );
            assert!((a.omega / b.omega - 1.0).abs() < 1e-9);
            assert!((a.zeta - b.zeta).abs() < 1e-9 + 1e-7 * b.zeta);
        }
        assert!(found[1].0.result.as_ref().unwrap().zeta > 1e-4);
    }
}
