//! Surfaces by roughness parameters: scenes, laws, gaps and refusals.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{BENCHMARKS, beam};
use analyses::run;
use joint_model::benchmark::{RefinementLevel, Symmetry};
use joints::Options;
use joints::interface::{FinishReport, FinishedSurface, LawReport, SceneInterface};
use joints::progress::Silent;
use joints::structure::Structure;
use scenes::{Gap, LawKind, Length, Route, Scene, Surface};
use std::sync::OnceLock;

const FACE: &str = r#"{ "ra": "0.8 um", "rsm": "400 um" }"#;

fn structure() -> &'static Structure {
    static MESHED: OnceLock<Structure> = OnceLock::new();
    MESHED.get_or_init(|| {
        let mut scene = beam("finish");
        scene.model.refinement = RefinementLevel::Quick;
        Structure::try_new(&scene, &Silent).unwrap()
    })
}

/// A scene on the benchmark with this `finish` block, lengths in millimetres.
fn read(finish: &str) -> Result<Scene, scenes::Error> {
    let text = format!(
        r#"{{ "units": {{ "length": "mm", "mass": "t", "time": "s" }}, "structure": {{ "benchmark": "brake-reuss-beam" }},
             "model": {{ "element_order": "linear", "refinement": "quick" }},
             "interfaces": {{ "surface": {{ "finish": {finish} }}, "law": {{ "friction": "lumped" }}, "points_per_direction": 2 }} }}"#
    );
    Scene::from_json(&text, "drawing.json", "drawing", &BENCHMARKS)
}

fn equal_faces(more: &str) -> String {
    format!(r#"{{ "top": {FACE}, "bottom": {FACE}{more} }}"#)
}

fn interface(scene: &Scene) -> Result<SceneInterface, joints::Error> {
    SceneInterface::try_new(scene, structure().interface(), &[], 36e3)
}

fn law(interface: &SceneInterface) -> LawReport {
    interface.reports().unwrap().remove(0).law
}

fn report(interface: &SceneInterface) -> FinishReport {
    *law(interface).asperities.unwrap().finish.unwrap()
}

#[test]
fn both_routes_give_a_law_its_interval_and_every_assumption() {
    for (route, populations) in [("ensemble", 32), ("fast", 1)] {
        let scene = read(&equal_faces(&format!(r#", "route": "{route}""#))).unwrap();
        let found = interface(&scene).unwrap();
        let law = law(&found);
        assert_eq!(law.asperities.as_ref().unwrap().n_populations, populations);
        assert!(law.normal_stiffness > 0.0 && law.tangential_stiffness > 0.0 && law.mean_closure > 0.0);
        let report = report(&found);
        let expected = [
            "top face: skewness 0",
            "bottom face: kurtosis 3",
            "top face: Gaussian autocorrelation",
            "bottom face: rq = ra/0.7979",
            "top face: correlation length l = rsm/4.443",
            "window ",
            "grid steps ",
            "flat faces",
            if route == "fast" { "a typical patch" } else { "by lot" },
        ];
        for what in expected {
            assert!(
                report.assumptions.iter().any(|line| line.contains(what)),
                "{what}: {:?}",
                report.assumptions
            );
        }
        assert_eq!(report.realisations, 32);
        let interval = &report.interval;
        for k in 0..interval.interference.len() {
            for bounds in [
                &interval.normal,
                &interval.normal_stiffness,
                &interval.tangential[0],
                &interval.tangential[1],
            ] {
                assert!(0.0 <= bounds[0][k] && bounds[0][k] <= bounds[1][k] && bounds[1][k] <= bounds[2][k]);
            }
        }
        // Nayak: bandwidth 3 of a Gaussian correlation; the sum of two equal faces has the curvature of one times sqrt 2.
        let sum = &report.greenwood_williamson;
        assert!((sum.bandwidth - 3.0).abs() < 1e-9);
        let length: f64 = 400e-6 / 4.442_882_938;
        let density = 6.0 / (length * length) / (6.0 * std::f64::consts::PI * 3f64.sqrt());
        assert!((sum.summit_density / density - 1.0).abs() < 1e-6);
        assert!(found.interface.gap().is_none_or(|gap| gap.iter().all(|g| *g == 0.0)));
        // What the summary holds is a scene, and its law, again.
        let text = serde_json::to_string(&scene).unwrap();
        assert_eq!(Scene::from_json(&text, "again", "", &BENCHMARKS).unwrap(), scene);
        let written = serde_json::to_value(&law).unwrap();
        assert_eq!(written["finish"]["route"], route);
        let back: LawReport = serde_json::from_value(written).unwrap();
        assert_eq!(back, law);
    }
}

#[test]
fn lengths_are_one_or_two_in_any_unit_and_figures_do_not_depend_on_it() {
    let scene = |face: &str| read(&format!(r#"{{ "top": {face}, "bottom": {face}, "route": "fast" }}"#)).unwrap();
    let one = scene(r#"{ "rq": 1e-3, "correlation_length": 0.1 }"#);
    let two = scene(r#"{ "rq": "1 um", "correlation_length": ["100 um", "0.1 mm"] }"#);
    let [a, b] = [&one, &two].map(|scene| report(&interface(scene).unwrap()).interval.clone());
    for (a, b) in a.normal.concat().iter().zip(b.normal.concat()) {
        assert!((a - b).abs() <= 1e-9 * b);
    }
    let lay = scene(r#"{ "rq": "1 um", "correlation_length": ["300 um", "60 um"], "lay_degrees": 90 }"#);
    let interval = report(&interface(&lay).unwrap()).clone();
    // The lay runs along y: profiles along x are the fine ones.
    assert!(interval.faces[0].moments.m2[0] > 20.0 * interval.faces[0].moments.m2[2]);
}

#[test]
fn the_same_bits_on_any_number_of_threads_and_others_by_seed() {
    for route in ["ensemble", "fast"] {
        let scene = read(&equal_faces(&format!(
            r#", "route": "{route}", "flatness": "5 um", "realisations": 20"#
        )))
        .unwrap();
        let on = |threads: usize, scene: &Scene| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| FinishedSurface::try_new(scene, structure().interface()).unwrap())
        };
        let (one, four) = (on(1, &scene), on(4, &scene));
        assert!(one.report == four.report && one.populations == four.populations && one.of_element == four.of_element);
        assert_eq!(one.forms, four.forms);
        let mut other = scene.clone();
        if let Surface::Finish(finish) = &mut other.interfaces.surface {
            finish.seed += 1;
        }
        let other = on(2, &other);
        assert!(one.report.interval != other.report.interval && one.forms != other.forms);
        assert_eq!(one.populations == other.populations, route == "fast");
    }
}

#[test]
fn flatness_makes_a_gap_that_scales_with_it_and_touches_somewhere() {
    let gap = |flatness: &str, seed: u64| {
        let more = format!(r#", "route": "fast", "flatness": "{flatness}", "seed": {seed}"#);
        let found = interface(&read(&equal_faces(&more)).unwrap()).unwrap();
        assert!(
            report(&found)
                .assumptions
                .iter()
                .any(|line| line.contains("flatness tolerance"))
        );
        found.interface.gap().unwrap().to_vec()
    };
    let (five, ten) = (gap("5 um", 1), gap("10 um", 1));
    let largest = five.iter().copied().fold(0.0, f64::max);
    assert!(five.iter().all(|g| *g >= 0.0) && five.contains(&0.0));
    assert!(largest > 2e-6 && largest <= 10e-6, "{largest}");
    for (a, b) in five.iter().zip(&ten) {
        assert!((2.0 * a - b).abs() < 1e-15);
    }
    assert_ne!(five, gap("5 um", 2));
}

#[test]
fn a_run_takes_the_law() {
    for route in ["fast", "ensemble"] {
        let mut scene = read(&equal_faces(&format!(r#", "route": "{route}", "flatness": "2 um""#))).unwrap();
        scene.analyses.backbone.amplitudes = 2;
        scene.analyses.backbone.amplitude_from = Length::from_si(1e-6);
        scene.analyses.backbone.vertices_per_quarter = 4;
        let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("finish");
        let found = run(&scene, &Options::cached(folder), &Silent).unwrap();
        for amplitude in found.amplitudes() {
            let result = amplitude.point.result.as_ref().unwrap();
            let frequency = result.omega / std::f64::consts::TAU;
            assert!(frequency > 100.0 && frequency < 200.0, "{route}: {frequency} Hz");
        }
    }
}

#[test]
fn laws_of_every_kind_have_nearly_the_same_stiffness() {
    for route in ["fast", "ensemble"] {
        let mut scene = read(&equal_faces(&format!(r#", "route": "{route}""#))).unwrap();
        let mut stiffness = |kind| {
            scene.interfaces.law.kind = kind;
            law(&interface(&scene).unwrap()).normal_stiffness
        };
        let table = stiffness(LawKind::Tabulated);
        if route == "fast" {
            assert!((stiffness(LawKind::AsperitySum) / table - 1.0).abs() < 0.01);
        }
        // Eq. (28) has five parameters for a range of three decades.
        assert!((stiffness(LawKind::Fitted) / table - 1.0).abs() < 0.3);
    }
}

#[test]
fn what_no_face_has_is_refused_with_file_field_and_remedy() {
    let finish = |face: &str| format!(r#"{{ "top": {face}, "bottom": {FACE} }}"#);
    let cases = [
        (
            finish("{}"),
            "drawing.json: interfaces.surface.finish.top: the spacing of the roughness is not given; add \"rsm\"",
        ),
        (
            finish(r#"{ "rsm": "0.1 mm" }"#),
            "interfaces.surface.finish.top: a roughness is not given; add \"ra\"",
        ),
        (
            finish(r#"{ "process": "ground" }"#),
            "the spacing of the roughness is not given",
        ),
        (
            finish(r#"{ "process": "sanded", "rsm": 0.1 }"#),
            "interfaces.surface.finish.top.process: unknown variant `sanded`, expected one of",
        ),
        (
            finish(r#"{ "rq": "8 um", "rz": "2 um", "rsm": 0.1 }"#),
            "rq = 8.0000e-6 m is above rz = 2.0000e-6 m",
        ),
        (
            finish(r#"{ "ra": "2 um", "rq": "1 um", "rsm": 0.1 }"#),
            "ra = 2.0000e-6 m is above rq = 1.0000e-6 m",
        ),
        (
            finish(r#"{ "ra": -1, "rsm": 0.1 }"#),
            "ra = -0.001 m; it must be positive",
        ),
        (finish(r#"{ "ra": "1 um", "rsm": 0 }"#), "rsm = 0 m"),
        (
            finish(r#"{ "ra": "1 um", "rsm": 0.1, "kurtosis": 1.2, "skewness": 0.6 }"#),
            "kurtosis = 1.2 with skewness = 0.6",
        ),
        (
            finish(r#"{ "ra": "1 um", "rsm": 0.1, "correlation_length": 0.1 }"#),
            "the two differ by more than a factor of 1.5",
        ),
        (
            finish(r#"{ "ra": "1 um", "psd": { "hurst": 2, "rolloff": 1, "cutoff": 0.1 } }"#),
            "psd.hurst = 2; it must be above 0 and below 1",
        ),
        (
            finish(r#"{ "ra": "1 um", "rsm": "1 s" }"#),
            "interfaces.surface.finish.top.rsm: `1 s` is not a length",
        ),
        (
            finish(r#"{ "ra": "1 um", "rsm": [1, 2, 3] }"#),
            "interfaces.surface.finish.top.rsm",
        ),
        (finish(r#"{ "roughness": 1 }"#), "unknown field `roughness`"),
        (
            equal_faces(r#", "realisations": 5"#),
            "interfaces.surface.finish.realisations = 5 is not admissible; it must be from 19",
        ),
        (
            equal_faces(r#", "flatness": 0"#),
            "interfaces.surface.finish.flatness = 0 m is not admissible",
        ),
        (
            equal_faces(r#", "step": -1"#),
            "interfaces.surface.finish.step = -0.001 m is not admissible",
        ),
        (equal_faces(r#", "route": "slow""#), "unknown variant `slow`"),
    ];
    for (block, expected) in cases {
        let error = read(&block).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
        assert!(
            error
                .field()
                .is_some_and(|field| field.starts_with("interfaces.surface.finish")),
            "{error}: {:?}",
            error.field()
        );
    }
    // What depends on the mesh is found when the law is built.
    for (more, expected) in [
        (
            r#", "step": "60 um""#,
            "drawing: interfaces.surface.finish: the correlation length of 9.0032e-5 m along x is below two grid steps",
        ),
        (
            r#", "window": "300 um""#,
            "window = 0.0003 m; it must be at least 4 correlation lengths",
        ),
        (r#", "step": "0.1 um""#, "points; between 16 and 2048 are computed"),
        (
            r#", "route": "fast", "readings": { "heights": "summed" }"#,
            "no theory for heights = \"summed\"; leave it out, or take \"route\": \"ensemble\"",
        ),
    ] {
        let error = interface(&read(&equal_faces(more)).unwrap()).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    let mut two_gaps = read(&equal_faces(r#", "flatness": "5 um""#)).unwrap();
    two_gaps.interfaces.gap = Gap::Measured;
    let message = two_gaps.validate("drawing.json").unwrap_err().to_string();
    assert!(
        message.contains("left out where `interfaces.gap` says what the gap is"),
        "{message}"
    );
    let mut half = read(&equal_faces("")).unwrap();
    half.model.symmetry = Symmetry::Half;
    assert!(matches!(
        half.validate("x"),
        Err(scenes::Error::Symmetry {
            what: "the surface",
            ..
        })
    ));
    if let Surface::Finish(finish) = &mut half.interfaces.surface {
        finish.route = Route::Fast;
    }
    half.validate("x").unwrap();
}
