//! Scenes with friction resolved over asperities, against published backbones and against themselves.
#![allow(clippy::unwrap_used, clippy::print_stdout)]
use analyses::results::trends::at;
use analyses::{Run, run};
use brake_reuss_beam::BrakeReussBenchmark;
use brake_reuss_beam::published::{BACKBONE_FLAT, BACKBONE_TOPOGRAPHY, BACKBONE_VISCOUS_DAMPING, BackbonePoint};
use joint_model::benchmark::Benchmark as _;
use joint_model::benchmark::RefinementLevel;
use joints::Options;
use joints::progress::{Progress, Silent};
use scenes::{Assembly, Bins, Friction, Law, RadialRule, Scene};
use std::path::PathBuf;
use std::sync::OnceLock;

/// Reduced models that several tests use, in a folder of this process.
fn cache() -> &'static PathBuf {
    static CACHE: OnceLock<PathBuf> = OnceLock::new();
    CACHE.get_or_init(|| std::env::temp_dir().join(format!("analyses-resolved-{}", std::process::id())))
}

fn go(scene: &Scene) -> Run {
    let run = run(scene, &Options::cached(cache()), &Silent).unwrap();
    run.checkpoints.remove();
    run
}

/// A scene of the benchmark on the quick mesh.
fn scene(name: &str) -> Scene {
    let mut scene = embedded(name);
    scene.model.refinement = RefinementLevel::Quick;
    scene.model.modes = Some(10);
    scene
}

fn embedded(name: &str) -> Scene {
    let text = BrakeReussBenchmark.scene(name).unwrap();
    Scene::from_json(text, name, name, &[&BrakeReussBenchmark]).unwrap()
}

/// Modal amplitude, frequency and damping ratio of the first harmonic at all amplitudes.
fn backbone(run: &Run) -> Vec<[f64; 3]> {
    let points = run.amplitudes().iter().map(|a| {
        let found = a.point.result.as_ref().unwrap();
        let hz = found.harmonic_omega / std::f64::consts::TAU;
        [
            found.modal_amplitude,
            hz,
            found.harmonic_zeta() + run.scene.background_damping,
        ]
    });
    points.collect()
}

fn curve(points: &[[f64; 3]], of: usize) -> Vec<(f64, f64)> {
    points.iter().map(|p| (p[0], p[of])).collect()
}

/// Largest relative differences to published points up to a modal amplitude: of the damping, and of the frequency's change.
fn apart(points: &[[f64; 3]], published: &[BackbonePoint], upto: f64) -> [f64; 2] {
    let (frequency, damping) = (curve(points, 1), curve(points, 2));
    let mut worst = [0.0_f64; 2];
    let inside = |p: &&BackbonePoint| p.modal_amplitude >= points[0][0] && p.modal_amplitude <= upto;
    let mut first = None;
    for p in published.iter().filter(inside) {
        let of = at(&frequency, p.modal_amplitude).unwrap() / p.frequency;
        let offset = *first.get_or_insert(of);
        let differences = [
            at(&damping, p.modal_amplitude).unwrap() / p.damping_ratio - 1.0,
            of / offset - 1.0,
        ];
        println!(
            "{:.3e}: damping {:+.3}, change of frequency {:+.5}",
            p.modal_amplitude, differences[0], differences[1]
        );
        worst = [0, 1].map(|i| worst[i].max(differences[i].abs()));
    }
    assert!(first.is_some());
    worst
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_damping_far_below_gross_slip_is_that_of_the_published_model() {
    // The coarse mesh follows the gap of the topography less well.
    for (name, published, bounds) in [
        ("published-epmc-flat", &BACKBONE_FLAT[..], [0.1, 4e-3]),
        ("published-epmc-topography", &BACKBONE_TOPOGRAPHY[..], [0.2, 9e-3]),
    ] {
        let mut scene = scene(name);
        scene.analyses.backbone.amplitudes = 16;
        scene.analyses.backbone.vertices_per_quarter = 8;
        within(&scene, published, bounds);
    }
}

/// Takes minutes: the scenes as they are.
#[test]
#[ignore = "minutes"]
fn damping_far_below_gross_slip_on_the_full_mesh() {
    for (name, published, bounds) in [
        ("published-epmc-flat", &BACKBONE_FLAT[..], [0.05, 1.5e-3]),
        ("published-epmc-topography", &BACKBONE_TOPOGRAPHY[..], [0.08, 4e-3]),
    ] {
        within(&embedded(name), published, bounds);
    }
}

fn within(scene: &Scene, published: &[BackbonePoint], bounds: [f64; 2]) {
    assert_eq!(scene.background_damping, BACKBONE_VISCOUS_DAMPING);
    let name = &scene.name;
    let [damping, frequency] = apart(&backbone(&go(scene)), published, 4.5e-5);
    println!("{name}: damping within {damping:.3}, change of frequency within {frequency:.5}");
    assert!(damping < bounds[0], "{name}: {damping}");
    assert!(frequency < bounds[1], "{name}: {frequency}");
}

#[test]
fn the_default_bins_do_what_a_hundred_do() {
    let mut scene = scene("published-epmc-flat");
    scene.analyses.backbone.amplitudes = 5;
    scene.analyses.backbone.vertices_per_quarter = 8;
    scene.interfaces.points_per_direction = 2;
    scene.interfaces.law.yielding = None;
    let many = go(&scene);
    scene.interfaces.law.bins = Law::default().bins;
    let few = go(&scene);
    let report = few.law().resolved.clone().unwrap();
    assert!((8..=28).contains(&report.bins), "{report:?}");
    assert!(
        report.bin_errors.unwrap().iter().all(|error| *error <= 3e-4),
        "{report:?}"
    );
    let first = few.frequencies[0] / many.frequencies[0] - 1.0;
    println!("first frequency {first:+.1e}, {report:?}");
    assert!(first.abs() < 1e-3, "{first}");
    for ([q, f, zeta], [q_many, f_many, zeta_many]) in backbone(&few).into_iter().zip(backbone(&many)) {
        println!("{q:.2e}: {:+.1e} {:+.1e}", f / f_many - 1.0, zeta / zeta_many - 1.0);
        assert!((q / q_many - 1.0).abs() < 1e-3 && (f / f_many - 1.0).abs() < 1e-3);
        // Far below a tenth of gross slip neither has many bins that slip.
        let bound = if q < 2e-6 { 0.08 } else { 0.03 };
        assert!((zeta / zeta_many - 1.0).abs() < bound, "{zeta} {zeta_many}");
    }
}

#[test]
fn annuli_dissipate_more_than_asperities_as_a_whole_and_few_of_them_suffice() {
    let mut scene = scene("published-epmc-flat");
    scene.analyses.backbone.amplitudes = 3;
    scene.analyses.backbone.vertices_per_quarter = 8;
    scene.interfaces.law.yielding = None;
    scene.interfaces.law.bins = Bins::Gauss(8);
    scene.background_damping = 0.0;
    let mut damping = |friction, radii| {
        scene.interfaces.law.friction = Some(friction);
        scene.interfaces.law.radii = RadialRule::Annuli(radii);
        backbone(&go(&scene)).into_iter().map(|p| p[2]).collect::<Vec<_>>()
    };
    let whole = damping(Friction::Resolved, 8);
    let [few, more] = [8, 16].map(|n| damping(Friction::MindlinIwan, n));
    println!("{whole:?} {few:?} {more:?}");
    assert!(few[0] > whole[0] && few[1] > whole[1]);
    // At the smallest amplitude hardly the outermost annulus slips.
    for (few, more) in few.iter().zip(&more).skip(1) {
        assert!((few / more - 1.0).abs() < 0.05);
    }
}

#[test]
fn assembly_without_friction_leaves_no_tangential_traction() {
    let mut scene = scene("published-epmc-topography");
    scene.analyses.backbone.amplitudes = 0;
    let largest = |scene: &Scene| {
        let run = go(scene);
        let [x, y, n] = &run.prestress.fields.traction;
        let most = |v: &[f64]| v.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
        assert!(most(n) > 1e6);
        most(x).max(most(y))
    };
    assert_eq!(largest(&scene), 0.0);
    scene.bolts.assembly = Assembly::WithFriction;
    assert!(largest(&scene) > 1e3);
}

#[test]
fn yield_is_part_of_the_validity() {
    let mut scene = scene("published-epmc-flat");
    scene.analyses.backbone.amplitudes = 1;
    let run = go(&scene);
    let onset = run.law().resolved.as_ref().unwrap().onset_of_yield.unwrap();
    assert!((1e-8..1e-6).contains(&onset), "{onset}");
    assert_eq!(run.validity().yield_onset_interference, Some(onset));
    let share = run.validity().yielded_asperity_fraction.unwrap();
    assert!((0.5..1.0).contains(&share), "{share}");
}

#[test]
fn what_does_not_belong_to_the_friction_of_a_scene_is_refused() {
    let refusal = |law: &str| {
        let text = format!(
            r#"{{ "units": {{ "length": "m", "mass": "kg", "time": "s" }}, "structure": {{ "benchmark": "brake-reuss-beam" }},
                "interfaces": {{ "law": {law} }} }}"#
        );
        Scene::from_json(&text, "a.json", "a", &[&BrakeReussBenchmark])
            .unwrap_err()
            .to_string()
    };
    let yielding = r#""yield": { "strength": "300 MPa", "tangent_modulus": 0 }"#;
    for (law, parts) in [
        (
            format!(r#"{{ "friction": "lumped", {yielding} }}"#),
            ["interfaces.law.yield", "interfaces.law.friction"],
        ),
        (
            r#"{ "friction": "lumped", "bins": { "gauss": 8 } }"#.into(),
            ["interfaces.law.bins", "interfaces.law.friction"],
        ),
        (
            r#"{ "friction": "resolved", "kind": "fitted" }"#.into(),
            ["interfaces.law.kind", "lumped"],
        ),
        (
            r#"{ "friction": "resolved", "tangential": "paper" }"#.into(),
            ["interfaces.law.tangential", "lumped"],
        ),
        (
            r#"{ "friction": "resolved", "radii": { "annuli": 4 } }"#.into(),
            ["interfaces.law.radii", "mindlin-iwan"],
        ),
        (
            r#"{ "friction": "mindlin-iwan", "radii": { "equally-spaced": 100 }, "history": "paper" }"#.into(),
            ["interfaces.law.history", "end point"],
        ),
        (
            r#"{ "friction": "resolved", "bins": { "gauss": 7 } }"#.into(),
            ["interfaces.law.bins.gauss", "even"],
        ),
        (
            r#"{ "friction": "resolved", "bins": { "error": 0 } }"#.into(),
            ["interfaces.law.bins.error", "1e-8"],
        ),
        (
            r#"{ "friction": "resolved", "yield": { "strength": -1, "tangent_modulus": 0 } }"#.into(),
            ["interfaces.law.yield.strength", "positive"],
        ),
        (
            r#"{ "friction": "resolved", "yield": { "strength": 1e8, "tangent_modulus": 1e12 } }"#.into(),
            ["interfaces.law.yield.tangent_modulus", "below"],
        ),
        (
            r#"{ "history": "paper" }"#.into(),
            ["interfaces.law.history", "foundation"],
        ),
        (
            r#"{ "friction": "foundation", "cone": "box" }"#.into(),
            ["interfaces.law.cone", "foundation"],
        ),
        (
            format!(r#"{{ "friction": "foundation", {yielding} }}"#),
            ["interfaces.law.yield", "mindlin-iwan"],
        ),
        (
            r#"{ "friction": "resolved", "kind": "boundary-elements" }"#.into(),
            ["interfaces.law.kind", "lumped"],
        ),
        (
            r#"{ "friction": "sticky" }"#.into(),
            ["interfaces.law.friction", "resolved"],
        ),
    ] {
        let text = refusal(&law);
        assert!(parts.iter().all(|part| text.contains(part)), "{law}: {text}");
    }
    // Refused where the law is made.
    let mut scene = scene("published-epmc-flat");
    scene.interfaces.law.history = contact_laws::HistoryRule::Potential;
    let error = analyses::run(&scene, &joints::Options::default(), &joints::progress::Silent);
    assert!(error.unwrap_err().to_string().contains("yield"));
}

/// Contact of synthetic scans by boundary elements, as the curves of both kinds of friction.
#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_boundary_elements_take_the_place_of_asperities() {
    let scene = |law: &str, more: &str| {
        let text = format!(
            r#"{{ "units": {{ "length": "m", "mass": "kg", "time": "s" }}, "structure": {{ "benchmark": "brake-reuss-beam" }},
                "model": {{ "element_order": "linear", "refinement": "quick", "modes": 10 }},
                "analyses": {{ "backbone": {{ "amplitudes": 2, "vertices_per_quarter": 4 }} }}, "output": {{ "fields_at": [] }},
                "interfaces": {{ "surface": {{ "synthetic-scan": {{ "bootstrap": 0, "step": [60e-6, 100e-6], "correlation_length": [300e-6, 400e-6] }} }}, "gap": "flat", "mu": 0.2, "points_per_direction": 2,
                    "law": {law} {more} }} }}"#
        );
        Scene::from_json(&text, "a.json", "a", &[&BrakeReussBenchmark]).unwrap()
    };
    let springs = go(&scene(r#"{ "kind": "boundary-elements" }"#, ""));
    let lumped = go(&scene(r#"{ "kind": "boundary-elements", "friction": "lumped" }"#, ""));
    let sums = go(&scene("{}", ""));
    let omega = |run: &Run| run.amplitudes()[0].point.result.as_ref().unwrap().omega;
    // The same stiffness where nothing slips, and another one than that of the sums.
    assert!(
        (omega(&springs) / omega(&lumped) - 1.0).abs() < 1.5e-3,
        "{} {}",
        omega(&springs),
        omega(&lumped)
    );
    assert!(
        (omega(&springs) / omega(&sums) - 1.0).abs() > 3e-3,
        "{} {}",
        omega(&springs),
        omega(&sums)
    );
    let of_law = |run: &Run| run.law().asperities.clone().unwrap().boundary_elements;
    let report = of_law(&springs).unwrap();
    assert_eq!(report.elements, 32);
    assert!(
        report.points.iter().all(|n| (16..=256).contains(n)) && report.stride == [1, 1] && report.missing < 0.2,
        "{report:?}"
    );
    assert!((0.2..1.5).contains(&report.sums_to_boundary_elements), "{report:?}");
    assert!(of_law(&sums).is_none());

    // How asperities are read has no effect on contact without them.
    let read = |kind: &str| {
        let text = format!(
            r#"{{ "units": {{ "length": "m", "mass": "kg", "time": "s" }}, "structure": {{ "benchmark": "brake-reuss-beam" }},
                "interfaces": {{ "surface": {{ "scans": {{ "top": "a.x3p", "bottom": "b.x3p", "readings": {{ "count": "summits" }} }} }},
                    "gap": "scan", "mu": 0.2, "law": {kind} }} }}"#
        );
        Scene::from_json(&text, "a.json", "a", &[&BrakeReussBenchmark]).map_err(|error| error.to_string())
    };
    let text = read(r#"{ "kind": "boundary-elements" }"#).unwrap_err();
    assert!(
        text.contains("readings") && text.contains("boundary-elements"),
        "{text}"
    );
    assert!(read("{}").is_ok());

    let refused = |scene: &Scene| run(scene, &Options::cached(cache()), &Silent).unwrap_err().to_string();
    let text = refused(&scene(
        r#"{ "kind": "boundary-elements" }"#,
        r#", "scale": { "asperity_height": 1.1 }"#,
    ));
    assert!(
        text.contains("boundary-elements") && text.contains("asperity_height"),
        "{text}"
    );
    let mut without = scene(r#"{ "kind": "boundary-elements" }"#, "");
    without.interfaces.surface = scenes::Surface::Measured;
    assert!(refused(&without).contains("needs the scans"));
}

/// Hears what was read from the cache.
#[derive(Default)]
struct Heard(std::sync::Mutex<Vec<String>>);

impl Progress for Heard {
    fn note(&self, text: &str) {
        self.0.lock().unwrap().push(text.to_owned());
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_contact_by_boundary_elements_is_kept_for_the_next_run() {
    let scene = |seed: u64| {
        let text = format!(
            r#"{{ "units": {{ "length": "m", "mass": "kg", "time": "s" }}, "structure": {{ "benchmark": "brake-reuss-beam" }},
                "model": {{ "element_order": "linear", "refinement": "quick", "modes": 10 }}, "analyses": {{}},
                "interfaces": {{ "surface": {{ "synthetic-scan": {{ "seed": {seed}, "bootstrap": 0, "step": [120e-6, 200e-6], "correlation_length": [300e-6, 400e-6] }} }},
                    "gap": "flat", "mu": 0.2, "points_per_direction": 1, "law": {{ "kind": "boundary-elements", "friction": "lumped" }} }} }}"#
        );
        Scene::from_json(&text, "a.json", "a", &[&BrakeReussBenchmark]).unwrap()
    };
    let folder = cache().join("contact");
    let options = Options::cached(&folder);
    // Frequencies, and whether the contact was read.
    let go = |seed: u64| {
        let heard = Heard::default();
        let found = run(&scene(seed), &options, &heard).unwrap();
        let read = heard
            .0
            .lock()
            .unwrap()
            .iter()
            .any(|note| note.contains("contact by boundary elements was read"));
        (found.frequencies, read)
    };
    let kept = || {
        let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        files
            .filter(|path| path.to_string_lossy().contains("contact-"))
            .collect::<Vec<_>>()
    };
    let (first, read) = go(1);
    assert!(!read && kept().len() == 1);
    assert_eq!(go(1), (first.clone(), true));
    // A damaged file counts as none, and other faces are others.
    let path = kept().remove(0);
    let mut bytes = std::fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    assert_eq!(go(1), (first.clone(), false));
    let (other, read) = go(2);
    assert!(!read && other != first && kept().len() == 2);
}
