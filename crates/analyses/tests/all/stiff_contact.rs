//! Contact far stiffer than the structure: in the energy norm of such a contact hardly any force is large.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::BENCHMARKS;
use analyses::{Error, Prepared, Run};
use joints::Options;
use joints::progress::Silent;
use joints::structure::{StructuralModel, Structure};
use scenes::Scene;
use serde_json::{Value, json};
use std::sync::OnceLock;

/// The coarse beam with a constant stiffness per area of each element, normal and tangential (Pa/m).
fn scene(stiffnesses: impl Iterator<Item = f64>, per: &str, backbone: Value) -> Scene {
    let set = |k: f64| {
        let tangential = 0.83 * k;
        json!({ "curves": { "elastic": { "normal_stiffness": k, "tangential_stiffness": [tangential, tangential] } } })
    };
    let scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": "quick" },
        "interfaces": {
            "surface": { "parameters": { "per": per, "sets": stiffnesses.map(set).collect::<Vec<_>>() } },
            "mu": 0.2,
            "points_per_direction": 2,
        },
        "analyses": { "backbone": backbone },
    });
    Scene::from_json(&scene.to_string(), "scene", "stiff", &BENCHMARKS).unwrap()
}

fn go(scene: &Scene) -> Result<Run, Error> {
    // One structure, reduced once, for all contacts.
    static STRUCTURE: OnceLock<(Structure, StructuralModel)> = OnceLock::new();
    let (structure, model) = STRUCTURE.get_or_init(|| {
        let structure = Structure::try_new(scene, &Silent).unwrap();
        let model = structure.reduce(&Options::default(), &Silent).unwrap();
        (structure, model)
    });
    Prepared::with_model(scene, structure, model.clone(), &Options::default(), &Silent)?.solve(&Silent)
}

#[test]
fn a_prestress_out_of_balance_is_refused_or_balanced() {
    let linear = |stiffness: f64, tolerance: f64| {
        let backbone = json!({ "amplitudes": 0, "tolerance": tolerance });
        go(&scene([stiffness].into_iter(), "interface", backbone))
    };
    let limit = linear(1e18, 1e-9).unwrap().frequencies[0];
    // With everything closed, also where the faces pull, it would be 191.3 and 192.7 Hz.
    for (stiffness, tolerance) in [(1e16, 1e-2), (1e18, 1e-2), (1e20, 1e-5)] {
        let found = linear(stiffness, tolerance).unwrap();
        let error = found.frequencies[0] / limit - 1.0;
        assert!(error.abs() < 1e-3, "{stiffness:e} {tolerance:e}: {error:e}");
        assert!(found.prestress.residual_ratio < 1e-3 && found.prestress.equilibrium_error < 1e-3);
    }
    // Where a closure of round-off takes more than the loads, round-off decides which of these are balanced; none is wrong.
    let mut refused = 0;
    for (stiffness, tolerance) in [1e24, 1e28, 1e30, 1e32].map(|k| [(k, 1e-9), (k, 1e-2)]).concat() {
        match linear(stiffness, tolerance) {
            Ok(found) => {
                let error = found.frequencies[0] / limit - 1.0;
                assert!(error.abs() < 1e-3, "{stiffness:e} {tolerance:e}: {error:e}");
                assert!(found.prestress.residual_ratio < 1e-3 && found.prestress.equilibrium_error < 1e-3);
            }
            Err(error) => {
                let message = error.to_string();
                // Of the loads as a whole, or at the interface, or on the way there.
                let reasons = ["do not balance", "out of balance", "stopped falling"];
                assert!(reasons.iter().any(|reason| message.contains(reason)), "{message}");
                refused += 1;
            }
        }
    }
    assert!(refused > 0);
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_points_of_very_different_stiffness_end_with_a_reason() {
    let elements = (0..148).map(|i| if i % 2 == 0 { 1e8 } else { 1e18 });
    let backbone = json!({ "amplitudes": 3, "amplitude_from": 1e-6, "amplitude_to": 1e-4 });
    let found = go(&scene(elements, "element", backbone)).unwrap();
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
