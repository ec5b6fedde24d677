//! Loops and periodic motions against the extended periodic motion concept, as an independent harmonic-balance code solved it on the reduced
//! matrices of the coarse beam: with the frequency of the first harmonic CQSMA and EPMC are two approximations of one motion, and the periodic motions
//! of this program are the same approximation.
//!
//! The points are in `$BRB_REFERENCE/epmc_independent.json`; without it the test passes and says so.
#![expect(clippy::unwrap_used, reason = "tests")]
#![expect(clippy::print_stdout, reason = "tests print how far they are from the reference")]

use crate::common::{BENCHMARKS, plain};
use analyses::results::summary::{BackboneSummary, Status, Summary};
use analyses::run;
use joints::Options;
use joints::progress::Silent;
use scenes::{Amplitudes, Epmc, Length, ModalAmplitude, Scene};
use serde::Deserialize;
use serde_json::{Value, json};
use test_support::{TemporaryFolder, reference_file};

/// A periodic motion.
#[derive(Deserialize)]
struct Point {
    /// Modal amplitude (sqrt(kg) m).
    q: f64,
    frequency_hz: f64,
    zeta: f64,
    /// Displacement at the response point (m).
    response_m: f64,
}

fn points(value: &Value) -> Vec<Point> {
    serde_json::from_value(value.clone()).unwrap()
}

/// The loop whose modal amplitude is `q`, within 1e-4.
fn at(q: f64, scene: &Scene, options: &Options) -> BackboneSummary {
    let mut scene = scene.clone();
    scene.analyses.backbone.amplitudes = 1;
    let mut x = q;
    for _ in 0..8 {
        scene.analyses.backbone.amplitude_from = Length::from_si(x);
        scene.analyses.backbone.amplitude_to = Length::from_si(x);
        let found = run(&scene, options, &Silent).unwrap();
        found.checkpoints.remove();
        let mut summary = Summary::new(&found, Default::default(), None);
        let point = summary.backbone.remove(0);
        let error = point.modal_amplitude.unwrap() / q;
        if (error - 1.0).abs() < 1e-4 {
            return point;
        }
        x /= error;
    }
    panic!("no loop has the modal amplitude {q}");
}

/// Scenes with the points that were found for them, and the highest harmonic that these have.
fn cases(reference: &Value) -> [(&'static str, Scene, Vec<Point>, usize); 3] {
    let scene = |interfaces: Value| {
        let scene = json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "benchmark": "brake-reuss-beam" },
            "model": { "refinement": "quick" },
            "interfaces": interfaces,
        });
        Scene::from_json(&plain(scene).to_string(), "scene", "epmc", &BENCHMARKS).unwrap()
    };
    let measured = |mu: f64| {
        scene(json!({
            "surface": "measured", "gap": "flat", "mu": mu,
            "law": { "kind": "asperity-sum" }, "points_per_direction": 2,
        }))
    };
    let elastic = &reference["elastic_law"];
    let tangential = &elastic["kt"];
    let constant = scene(json!({
        "surface": { "parameters": { "per": "interface", "sets": [{ "curves": { "elastic": {
            "normal_stiffness": elastic["kn"], "tangential_stiffness": [tangential, tangential]
        } } }] } },
        "mu": elastic["mu"], "points_per_direction": elastic["points_per_direction"],
    }));
    let asperities = &reference["measured_law_asperity_sums"];
    [
        ("constant stiffness, mu = 0.2", constant, points(&elastic["points"]), 5),
        ("measured, mu = 0.2", measured(0.2), points(&asperities["mu_0.2"]), 3),
        ("measured, mu = 0.6", measured(0.6), points(&asperities["mu_0.6"]), 3),
    ]
}

/// The reference, or none where it is absent.
fn reference() -> Option<Value> {
    let file = reference_file("epmc_independent.json")?;
    Some(serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap())
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_periodic_motions_are_those_of_an_independent_harmonic_balance() {
    compare(|name| name.starts_with("constant"));
}

#[test]
#[ignore = "half a minute; `.ci/run slow` runs it"]
fn slow_periodic_motions_on_asperity_sums_are_those_of_an_independent_harmonic_balance() {
    compare(|name| name.starts_with("measured"));
}

fn compare(is_meant: fn(&str) -> bool) {
    let Some(reference) = reference() else { return };
    let cases = cases(&reference).into_iter().filter(|(name, ..)| is_meant(name));
    for (name, mut scene, points, harmonics) in cases {
        scene.analyses.backbone.amplitudes = 0;
        scene.analyses.epmc = Some(Epmc {
            modal_amplitudes: Some(Amplitudes::List(
                points.iter().map(|p| ModalAmplitude::from_si(p.q)).collect(),
            )),
            harmonics,
            ..Epmc::default()
        });
        let found = run(&scene, &Options::default(), &Silent).unwrap();
        let epmc = found.first().epmc.as_ref().unwrap();
        assert_eq!(epmc.points.len(), points.len());
        for ((found, x), point) in epmc.points.iter().zip(&epmc.response_displacement).zip(&points) {
            let motion = found.result.as_ref().unwrap();
            let frequency = motion.omega / std::f64::consts::TAU / point.frequency_hz - 1.0;
            let damping = motion.zeta.unwrap() - point.zeta;
            let response = x.unwrap() / point.response_m - 1.0;
            println!(
                "{name}, q = {:.3e}: frequency {frequency:+.1e}, damping {damping:+.1e} of {:.4e}, motion {response:+.1e}, drift {:.1e}",
                point.q, point.zeta, motion.drift
            );
            // What creeps from period to period is cut off elsewhere there.
            assert!(frequency.abs() < 3e-5, "frequency at {:e}: {frequency:e}", point.q);
            assert!(response.abs() < 1e-5, "motion at {:e}: {response:e}", point.q);
            assert!(
                damping.abs() < 2e-3 * point.zeta + 1e-9,
                "damping at {:e}: {damping:e}",
                point.q
            );
            assert!(motion.residual < 2e-8 && motion.energy_error < 1e-8);
        }
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_first_harmonics_of_the_loops_are_those_of_periodic_motions() {
    let Some(reference) = reference() else { return };
    let folder = TemporaryFolder::new("independent-epmc");
    let options = Options {
        cache: Some(folder.to_path_buf()),
        ..Options::default()
    };
    let mut compared = 0;
    for (name, scene, points, _) in cases(&reference) {
        // The last of the constant stiffness slides as a whole: a motion that no longer has the shape of the linear mode.
        for point in points.iter().filter(|p| p.q < 2e-3) {
            let found = at(point.q, &scene, &options);
            let frequency = found.frequency_first_harmonic_hz.unwrap() / point.frequency_hz - 1.0;
            let secant = found.frequency_hz.unwrap() / point.frequency_hz - 1.0;
            let motion = found.response_motion.unwrap() / point.response_m - 1.0;
            let zeta = found.damping_ratio_first_harmonic;
            println!(
                "{name}, q = {:.3e}: frequency {frequency:+.1e} (secant {secant:+.1e}), damping {zeta:?} for {:.4e}, motion \
                 {motion:+.1e}",
                point.q, point.zeta
            );
            assert!(frequency.abs() < 1e-3, "frequency at {:e}: {frequency:e}", point.q);
            assert!(motion.abs() < 1e-3, "motion at {:e}: {motion:e}", point.q);
            if point.zeta.abs() < 1e-9 {
                assert_eq!((found.status, zeta), (Status::BelowFloor, None), "{:e}", point.q);
            } else {
                let error = zeta.unwrap() / point.zeta - 1.0;
                assert!(error.abs() < 2e-2, "damping at {:e}: {error:e}", point.q);
            }
            compared += 1;
        }
    }
    assert_eq!(compared, 9);
}
