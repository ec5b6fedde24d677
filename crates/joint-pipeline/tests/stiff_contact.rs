//! Contact far stiffer than the structure: in the energy norm of such a contact hardly any force is large.
#![expect(clippy::unwrap_used, reason = "tests")]

mod common;

use common::BENCHMARKS;
use joint_pipeline::progress::Silent;
use joint_pipeline::{Error, Options, Run, Scene, run};
use serde_json::{Value, json};

/// The coarse beam with a constant stiffness per area of each element, normal and tangential (Pa/m).
fn scene(stiffnesses: impl Iterator<Item = f64>, per: &str, cqsma: Value) -> Scene {
    let set = |k: f64| {
        let tangential = 0.83 * k;
        json!({ "curves": { "elastic": { "normal_stiffness": k, "tangential_stiffness": [tangential, tangential] } } })
    };
    let scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "refinement": "quick" },
        "surface": { "parameters": { "per": per, "sets": stiffnesses.map(set).collect::<Vec<_>>() } },
        "mu": 0.2,
        "cqsma": cqsma,
    });
    Scene::from_json(&scene.to_string(), "scene", "stiff", &BENCHMARKS).unwrap()
}

fn go(scene: &Scene) -> Result<Run, Error> {
    run(scene, &Options::default(), &Silent)
}

#[test]
fn a_prestress_out_of_balance_is_refused_or_balanced() {
    let linear = |stiffness: f64, tolerance: f64| {
        let cqsma = json!({ "amplitudes": 0, "tolerance": tolerance });
        go(&scene([stiffness].into_iter(), "interface", cqsma))
    };
    let limit = linear(1e18, 1e-9).unwrap().frequencies[0];
    // With everything closed, also where the faces pull, it would be 191.3 and 192.7 Hz.
    for (stiffness, tolerance) in [(1e16, 1e-2), (1e18, 1e-2), (1e20, 1e-5)] {
        let found = linear(stiffness, tolerance).unwrap();
        let error = found.frequencies[0] / limit - 1.0;
        assert!(error.abs() < 1e-3, "{stiffness:e} {tolerance:e}: {error:e}");
        assert!(found.prestress.residual_ratio < 1e-3 && found.prestress.equilibrium_error < 1e-3);
    }
    for tolerance in [1e-9, 1e-2] {
        let refused = linear(1e30, tolerance).map(|run| run.frequencies[0]);
        let message = refused.unwrap_err().to_string();
        // Of the loads as a whole, or at the interface: which it is, round-off decides.
        assert!(
            message.contains("do not balance") || message.contains("out of balance"),
            "{message}"
        );
    }
}

#[test]
fn points_of_very_different_stiffness_end_with_a_reason() {
    let elements = (0..148).map(|i| if i % 2 == 0 { 1e8 } else { 1e18 });
    let cqsma = json!({ "amplitudes": 3, "amplitude_from": 1e-6, "amplitude_to": 1e-4 });
    let found = go(&scene(elements, "element", cqsma)).unwrap();
    let [small, .., large] = found.amplitudes() else {
        panic!()
    };
    let small = small.point.result.as_ref().unwrap();
    assert!((small.omega / found.frequencies[0] / std::f64::consts::TAU - 1.0).abs() < 1e-6);
    // Within the budget, or told that it was not enough.
    let effort = large.point.effort;
    println!("{effort:?} {:?}", large.point.result.as_ref().map(|r| r.zeta));
    assert!(effort.iterations < 2100 + 10 * effort.solves, "{effort:?}");
    if let Err(failure) = &large.point.result {
        assert!(failure.reason.to_string().contains("iterations"), "{}", failure.reason);
    }
}
