//! Errors of numerical settings, estimated from the run, against runs with finer settings.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use crate::common::BENCHMARKS;
use analyses::Run;
use analyses::dials::Dial;
use joints::progress::Silent;
use joints::store::Options;
use scenes::Scene;
use serde_json::{Value, json};

/// The beam on its coarsest linear mesh with friction of annuli, from the onset of slip on.
fn scene(amplitudes: usize, more: &Value) -> Scene {
    let mut scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": "quick" },
        "interfaces": {
            "surface": "measured", "gap": "flat", "mu": 0.2, "points_per_direction": 2,
            "law": { "friction": "mindlin-iwan", "bins": { "gauss": 6 }, "radii": { "annuli": 4 } },
        },
        "analyses": { "backbone": {
            "amplitudes": amplitudes, "amplitude_from": 2e-5, "amplitude_to": 2e-4, "vertices_per_quarter": 4,
        } },
        "output": { "fields_at": [] },
    });
    json_merge(&mut scene, more);
    Scene::from_value(scene, "here", "errors", &BENCHMARKS).unwrap()
}

fn json_merge(into: &mut Value, from: &Value) {
    match (into, from) {
        (Value::Object(into), Value::Object(from)) => {
            for (name, value) in from {
                match into.get_mut(name) {
                    Some(own) if own.is_object() && value.get("gauss").or(value.get("annuli")).is_none() => {
                        json_merge(own, value);
                    }
                    _ => drop(into.insert(name.clone(), value.clone())),
                }
            }
        }
        (into, from) => *into = from.clone(),
    }
}

fn run(scene: &Scene) -> Run {
    analyses::run(scene, &Options::default(), &Silent).unwrap()
}

/// Frequencies and damping ratios along a backbone.
fn found(run: &Run) -> Vec<[f64; 2]> {
    let results = run
        .amplitudes()
        .iter()
        .map(|amplitude| amplitude.point.result.as_ref().unwrap());
    results.map(|result| [result.omega, result.zeta]).collect()
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_estimates_are_what_finer_settings_change() {
    let law = |more: Value| json!({ "interfaces": { "law": more } });
    let springs =
        |count: usize| law(json!({ "friction": "foundation", "bins": { "gauss": count }, "radii": { "annuli": 8 } }));
    compare(&springs(32), vec![(Dial::Bins, springs(128))]);
    compare(
        &json!({}),
        vec![
            (Dial::Bins, law(json!({ "bins": { "gauss": 30 } }))),
            (Dial::Radii, law(json!({ "radii": { "annuli": 16 } }))),
            (Dial::Points, json!({ "interfaces": { "points_per_direction": 5 } })),
            (
                Dial::Vertices,
                json!({ "analyses": { "backbone": { "vertices_per_quarter": 16 } } }),
            ),
        ],
    );
}

/// Estimated errors of a scene against what finer settings change.
fn compare(more: &Value, finer: Vec<(Dial, Value)>) {
    let own = run(&scene(3, more));
    let base = found(&own);
    for (dial, finer) in finer {
        let fine = found(&run(&scene(3, &finer)));
        let mut sums = [[0.0; 2]; 2];
        for ((base, fine), amplitude) in base.iter().zip(&fine).zip(own.amplitudes()) {
            let error = amplitude.error.as_ref().unwrap().of[&dial];
            let estimates = [error.frequency_relative.unwrap(), error.damping_ln.unwrap()];
            let truth = [(base[0] / fine[0] - 1.0).abs(), (base[1] / fine[1]).ln().abs()];
            for q in 0..2 {
                // Of single amplitudes an error may pass through zero.
                let least = [1e-5, 2e-3][q];
                assert!(
                    estimates[q] > truth[q] / 4.0 - least,
                    "{dial:?}: {estimates:?} for {truth:?}"
                );
                sums[q][0] += estimates[q];
                sums[q][1] += truth[q];
            }
        }
        // Vertices change the frequency by round-off alone.
        let judged = if dial == Dial::Vertices { 1..2 } else { 0..2 };
        for [estimates, truth] in &sums[judged] {
            let effectivity = estimates / truth;
            assert!(
                (0.5..8.0).contains(&effectivity),
                "{dial:?}: {estimates:e} for {truth:e}"
            );
        }
    }
    for amplitude in own.amplitudes() {
        let error = amplitude.error.as_ref().unwrap();
        let parts: f64 = error.of.values().map(|part| part.damping_ln.unwrap()).sum();
        assert!((error.damping_ln.unwrap() / parts - 1.0).abs() < 1e-12);
        assert_eq!(error.of[&Dial::Mesh].frequency_relative, Some(mesh_error()));
        assert!(error.of[&Dial::Modes].frequency_relative.unwrap() < 1e-5);
    }
}

/// Of the coarsest linear mesh, in the table of the benchmark.
fn mesh_error() -> f64 {
    let accuracy = BENCHMARKS[0].mesh_accuracy().unwrap();
    let scene = scene(1, &json!({}));
    let row = accuracy.errors.iter().find(|row| {
        (row.element_order, row.refinement, row.hexahedra)
            == (scene.element_order(), scene.model.refinement, scene.hexahedra())
    });
    row.unwrap().frequency
}

#[test]
#[ignore = "twenty seconds; `.ci/run slow` runs it"]
fn slow_settings_are_adapted_to_the_errors_that_are_borne() {
    let asked = |more: Value| {
        let mut scene = json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "accuracy": { "damping": 0.2 },
            "structure": { "benchmark": "brake-reuss-beam" },
            "model": { "element_order": "linear", "refinement": "quick" },
            "interfaces": { "surface": "measured", "gap": "flat", "mu": 0.2, "points_per_direction": 2 },
            "analyses": { "backbone": { "amplitudes": 11, "amplitude_from": 5e-5, "amplitude_to": 2e-4 } },
            "output": { "fields_at": [] },
        });
        json_merge(&mut scene, &more);
        run(&Scene::from_value(scene, "here", "errors", &BENCHMARKS).unwrap())
    };
    let own = asked(json!({}));
    let adaptation = own.adaptation.as_ref().unwrap();
    assert!(adaptation.met && adaptation.limited_by.is_empty(), "{adaptation:?}");
    assert!(adaptation.steps.len() > 1);
    let last = adaptation.steps.last().unwrap();
    assert_eq!(last.loops, 11);
    // What the scene gives stays.
    assert_eq!(last.numbers[&Dial::Points], 2);
    assert_eq!(own.scene.accuracy, None);
    let fine = json!({
        "model": { "element_order": "linear", "refinement": "quick" },
        "interfaces": { "points_per_direction": 2, "law": { "bins": { "gauss": 24 }, "radii": { "annuli": 12 } } },
        "analyses": { "backbone": { "vertices_per_quarter": 10, "amplitude_from": 5e-5 } },
    });
    let fine = found(&run(&scene(11, &fine)));
    // Without the mesh, which both have.
    for ([_, zeta], [_, fine]) in found(&own).into_iter().zip(fine) {
        assert!((zeta / fine).ln().abs() < 0.2 - 0.084, "{zeta:e} for {fine:e}");
    }
    // The mesh is given, and misses more than is borne.
    let missed = asked(json!({ "accuracy": { "frequency": 1e-3 } }));
    let adaptation = missed.adaptation.as_ref().unwrap();
    assert!(!adaptation.met);
    assert_eq!(adaptation.limited_by[0], Dial::Mesh);
}

/// Were the places of the bins the same in all elements, the error of single points (8e-4 with eight bins) would not average out.
#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_four_points_per_direction_agree_with_five() {
    let first_frequency = |points: usize| {
        let scene = json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "benchmark": "brake-reuss-beam" },
            "interfaces": { "surface": "measured", "gap": "flat", "mu": 0.2, "points_per_direction": points },
            "analyses": { "backbone": { "amplitudes": 0 } },
        });
        run(&Scene::from_value(scene, "here", "points", &BENCHMARKS).unwrap()).frequencies[0]
    };
    let [four, five] = [4, 5].map(first_frequency);
    assert!((four / five - 1.0).abs() < 4e-4, "{four} {five}");
}

#[test]
fn errors_measured_for_one_mode_refuse_no_other() {
    let asked = |mode: usize, damping: f64| {
        let scene = json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "accuracy": { "damping": damping },
            "structure": { "benchmark": "brake-reuss-beam" },
            "analyses": { "modes": { "followed": [mode] } },
        });
        Scene::from_value(scene, "here", "accuracy", &BENCHMARKS)
    };
    assert!(asked(1, 1e-9).unwrap_err().to_string().contains("no measured mesh"));
    assert!(asked(1, 0.02).is_ok());
    assert!(asked(3, 1e-9).is_ok());
}
