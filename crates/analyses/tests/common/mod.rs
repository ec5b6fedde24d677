//! Scenes on the benchmark that the tests use.
#![allow(dead_code, clippy::unwrap_used, reason = "each test uses some of it")]

pub(crate) mod points;

use brake_reuss_beam::BrakeReussBenchmark;
use joint_model::Benchmark;
use scenes::Scene;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Benchmarks that scenes of the tests may name.
pub(crate) static BENCHMARKS: [&dyn Benchmark; 1] = [&BrakeReussBenchmark];

/// The Brake-Reuss beam as the method paper models it: linear elements and one friction limit per point take a third of the time of the
/// default scene, and most of what is tested does not depend on them.
pub(crate) fn beam(name: &str) -> Scene {
    let text = BrakeReussBenchmark.scene("brb-paper-flat").unwrap();
    Scene::from_json(text, name, name, &BENCHMARKS).unwrap()
}

/// Of the beam; the law of most scenes has none, the check of the reduction is scaled by it.
pub(crate) fn material() -> Value {
    json!({ "youngs_modulus": "192.85 GPa", "poisson_ratio": 0.29 })
}

/// A scene on the beam with linear elements and one friction limit per point, as [`beam`], unless it says something else.
pub(crate) fn plain(mut scene: Value) -> Value {
    let choices = [
        ("/model", "element_order", json!("linear")),
        ("/interfaces", "points_per_direction", json!(2)),
        ("/interfaces", "law", json!({})),
        ("/interfaces/law", "friction", json!("lumped")),
    ];
    let has_asperities = scene.pointer("/interfaces/surface/parameters").is_none();
    for (block, field, value) in choices {
        if field == "friction" && !has_asperities {
            continue;
        }
        let block = scene.pointer_mut(block).and_then(Value::as_object_mut).unwrap();
        block.entry(field).or_insert(value);
    }
    scene
}

pub(crate) fn fixture(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests", "fixtures", name].iter().collect()
}

/// Two blocks that lie upon one another, the upper one being the top, with an elastic interface. `matrices` adds to what
/// is said of the matrices.
pub(crate) fn lap(path: &Path, length: f64, matrices: &Value) -> Value {
    let node = |side: u64, i: u64, j: u64, k: u64| 1 + 16 * side + i + 4 * (j + 2 * k);
    let at = |side, k| -> Vec<u64> { (0..2).flat_map(|j| (0..4).map(move |i| node(side, i, j, k))).collect() };
    let nodes: Vec<[f64; 2]> = (0..2)
        .flat_map(|j| (0..4).map(move |i| [0.02 * f64::from(i) / length, 0.02 * f64::from(j) / length]))
        .collect();
    let elements: Vec<[u32; 4]> = (1..4).map(|i| [i, i + 1, i + 5, i + 4]).collect();
    // Pulled together at four nodes of the outer faces.
    let pull = |side, k, factor: f64| {
        let places = [(1, 0), (2, 0), (1, 1), (2, 1)];
        places.map(|(i, j)| json!([node(side, i, j, k), 3, 0.25 * factor]))
    };
    let bolt = [pull(0, 1, -1.0), pull(1, 0, 1.0)].concat();
    let mut scene = json!({
        "units": { "length": if length == 1.0 { "m" } else { "mm" }, "mass": if length == 1.0 { "kg" } else { "t" }, "time": "s" },
        "structure": { "matrices": {
            "path": path,
            "coordinates": { "both-sides": {
                "top": at(0, 0),
                "bottom": at(1, 1),
                "frame": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
            } },
            "interface": { "nodes": nodes, "elements": elements },
            "bolts": [{ "terms": bolt }],
            "response": { "terms": [[node(0, 3, 1, 1), 3, 1.0]] },
        } },
        "model": { "material": material() },
        "interfaces": {
            "mu": 0.2,
            "surface": { "parameters": { "per": "interface", "sets": [{
                "curves": { "elastic": {
                    "normal_stiffness": 1e13 * length.powi(2) / if length == 1.0 { 1.0 } else { 1e3 },
                    "tangential_stiffness": [7e12 * length.powi(2) / if length == 1.0 { 1.0 } else { 1e3 },
                        7e12 * length.powi(2) / if length == 1.0 { 1.0 } else { 1e3 }],
                } },
            }] } },
        },
        "bolts": { "load": 2000.0 },
        "analyses": { "backbone": {
            "amplitudes": 5, "amplitude_from": 1e-9 / length, "amplitude_to": 1e-7 / length, "vertices_per_quarter": 6,
        } },
    });
    let target = &mut scene["structure"]["matrices"];
    for (name, value) in matrices.as_object().unwrap() {
        target[name] = value.clone();
    }
    scene
}
