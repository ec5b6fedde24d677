//! Loops against the extended periodic motion concept, as an independent harmonic-balance code solved it on the reduced
//! matrices of the coarse beam: with the frequency of the first harmonic CQSMA and EPMC are two approximations of one motion.
//!
//! The points are in `$BRB_REFERENCE/epmc_independent.json`; without it the test passes and says so.
#![expect(clippy::unwrap_used, reason = "tests")]

mod common;

use common::BENCHMARKS;
use joint_pipeline::progress::Silent;
use joint_pipeline::results::summary::{BackboneSummary, Status, Summary};
use joint_pipeline::scene::Length;
use joint_pipeline::{Options, Scene, run};
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
    scene.cqsma.amplitudes = 1;
    let mut x = q;
    for _ in 0..8 {
        scene.cqsma.amplitude_from = Length::from_si(x);
        scene.cqsma.amplitude_to = Length::from_si(x);
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

#[test]
fn first_harmonics_of_the_loops_are_those_of_periodic_motions() {
    let Some(file) = reference_file("epmc_independent.json") else {
        return;
    };
    let reference: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let folder = TemporaryFolder::new("independent-epmc");
    let options = Options {
        cache: Some(folder.to_path_buf()),
        ..Options::default()
    };
    let scene = |rest: Value| {
        let mut scene = json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "benchmark": "brake-reuss-beam" },
            "model": { "refinement": "quick" },
        });
        scene.as_object_mut().unwrap().extend(rest.as_object().unwrap().clone());
        Scene::from_json(&scene.to_string(), "scene", "epmc", &BENCHMARKS).unwrap()
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
    let mut compared = 0;
    for (name, scene, points) in [
        ("constant stiffness, mu = 0.2", constant, points(&elastic["points"])),
        ("measured, mu = 0.2", measured(0.2), points(&asperities["mu_0.2"])),
        ("measured, mu = 0.6", measured(0.6), points(&asperities["mu_0.6"])),
    ] {
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
