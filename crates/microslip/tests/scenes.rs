//! Scenes that come with the program, their schema, and runs that follow several modes.
#![expect(clippy::unwrap_used, reason = "tests")]

mod common;

use boon::{Compiler, Schemas};
use common::{exit_code, folder, messages, read_json, run, succeeds};
use microslip::benchmarks::{BENCHMARKS, read};
use microslip::{Scene, Summary};
use serde_json::{Value, json};
use std::path::Path;

const PROGRAM: &str = env!("CARGO_BIN_EXE_microslip");

/// A scene of the coarse benchmark in a file.
fn quick(folder: &Path, cqsma: Value) -> String {
    let scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "refinement": "quick" },
        "cqsma": cqsma,
    });
    std::fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
    "scene.json".into()
}

#[test]
fn a_new_scene_runs_and_is_not_overwritten() {
    let folder = folder("new");
    let said = succeeds(&folder, &["new", "joint"]);
    assert!(said.contains("microslip run joint/scene.json"), "{said}");
    succeeds(&folder, &["run", "joint/scene.json", "--out", "results"]);
    let summary: Summary = serde_json::from_value(read_json(&folder.join("results/summary.json"))).unwrap();
    assert_eq!(
        (summary.title.as_str(), summary.backbone.len()),
        ("Brake-Reuss beam", 8)
    );
    assert!(summary.backbone.iter().all(|point| point.converged));
    let again = run(&folder, &["new", "joint"]);
    assert_eq!(exit_code(&again), 1);
    assert!(messages(&again).contains("is there already"), "{}", messages(&again));
}

#[test]
fn benchmarks_are_listed_and_run_by_name() {
    let folder = folder("benchmarks");
    let listed = succeeds(&folder, &["benchmarks"]);
    assert!(listed.contains("brake-reuss-beam/brb-flat"), "{listed}");
    succeeds(
        &folder,
        &[
            "run",
            "--benchmark",
            "brake-reuss-beam/brb-quick",
            "--out",
            "quick",
            "--no-cache",
        ],
    );
    assert!(folder.join("quick/report.html").exists());
    let unknown = run(&folder, &["run", "--benchmark", "s4"]);
    assert_eq!(exit_code(&unknown), 1);
    let text = messages(&unknown);
    assert!(text.contains("no benchmark `s4`; there are brake-reuss-beam"), "{text}");
    let nothing = run(&folder, &["run"]);
    assert_eq!(exit_code(&nothing), 1);
    assert!(messages(&nothing).contains("--benchmark"), "{}", messages(&nothing));
}

#[test]
fn every_scene_of_a_benchmark_is_admissible() {
    for benchmark in BENCHMARKS {
        for (name, text) in benchmark.scenes() {
            let scene = read(name, text).unwrap();
            // What the summary repeats is the same scene.
            let again = serde_json::to_string(&scene).unwrap();
            assert_eq!(Scene::from_json(&again, name, "", &BENCHMARKS).unwrap(), scene);
        }
    }
}

/// Whether `instance` satisfies the schema that the program prints.
fn satisfies(schema: &str, instance: &Value) -> Result<(), String> {
    let printed: Value = serde_json::from_str(schema).unwrap();
    let (mut compiler, mut schemas) = (Compiler::new(), Schemas::new());
    compiler.add_resource("schema.json", printed).unwrap();
    let index = compiler.compile("schema.json", &mut schemas).unwrap();
    schemas.validate(instance, index).map_err(|error| error.to_string())
}

#[test]
fn schemas_accept_what_the_program_reads_and_writes() {
    let folder = folder("schemas");
    let schema = succeeds(&folder, &["schema", "scene"]);
    for benchmark in BENCHMARKS {
        for (name, text) in benchmark.scenes() {
            // Comments stand on lines of their own.
            let plain = text.lines().filter(|line| !line.trim_start().starts_with("//"));
            let scene: Value = serde_json::from_str(&plain.collect::<String>()).unwrap();
            satisfies(&schema, &scene).unwrap_or_else(|error| panic!("{name}: {error}"));
            let written = serde_json::to_value(read(name, text).unwrap()).unwrap();
            satisfies(&schema, &written).unwrap_or_else(|error| panic!("{name}, as written: {error}"));
        }
    }
    let base: Value = serde_json::from_str(BENCHMARKS[0].scenes()[0].1).unwrap();
    let mut with_masses = base.clone();
    with_masses["structure"]["point_masses"] = json!([{ "at": [0.36, 0.0, "1 mm"], "mass": "0.8 g" }]);
    satisfies(&schema, &with_masses).unwrap();
    let scene = read("masses", &with_masses.to_string()).unwrap();
    satisfies(&schema, &serde_json::to_value(scene).unwrap()).unwrap();
    for (field, value) in [
        ("frobnicate", json!(1)),
        ("mu", json!("high")),
        ("structure", json!({ "mesh": "a.msh" })),
        ("structure", json!({})),
        ("structure", json!({ "point_masses": [] })),
        (
            "structure",
            json!({ "benchmark": "brake-reuss-beam", "matrices": { "path": "m.npz", "coordinates": "jump" } }),
        ),
        (
            "structure",
            json!({ "benchmark": "brake-reuss-beam", "point_masses": [{ "at": [0.0, 0.0, 0.0] }] }),
        ),
        ("cqsma", json!({ "amplitudes": -1 })),
    ] {
        let mut wrong = base.clone();
        wrong[field] = value;
        assert!(satisfies(&schema, &wrong).is_err(), "{field}");
    }
    let scene = quick(&folder, json!({ "amplitudes": 2, "vertices_per_quarter": 2 }));
    succeeds(&folder, &["run", &scene, "--out", "results"]);
    let schema = succeeds(&folder, &["schema", "summary"]);
    satisfies(&schema, &read_json(&folder.join("results/summary.json"))).unwrap();
}

#[test]
fn several_modes_have_a_backbone_each() {
    let folder = folder("modes");
    let settings = |modes: Value| {
        let mut cqsma =
            json!({ "amplitudes": 3, "vertices_per_quarter": 4, "amplitude_from": 1e-6, "amplitude_to": 1e-4 });
        cqsma
            .as_object_mut()
            .unwrap()
            .extend(modes.as_object().unwrap().clone());
        cqsma
    };
    let scene = quick(&folder, settings(json!({ "modes_of_interest": [1, 3] })));
    let said = succeeds(&folder, &["run", &scene, "--out", "both"]);
    assert!(said.contains("mode 3"), "{said}");
    let both: Summary = serde_json::from_value(read_json(&folder.join("both/summary.json"))).unwrap();
    assert_eq!(both.backbones.iter().map(|of| of.mode).collect::<Vec<_>>(), [1, 3]);
    for name in [
        "backbone.csv",
        "backbone.svg",
        "mode-3-backbone.csv",
        "mode-3-backbone.svg",
    ] {
        assert!(folder.join("both").join(name).exists(), "{name}");
    }
    assert!(folder.join("both/interface-mode-3-amplitude-01.vtu").exists());
    let page = std::fs::read_to_string(folder.join("both/report.html")).unwrap();
    assert!(page.contains("of mode 1, 3 against amplitude") && page.contains("Backbone: Mode 3"));
    // Each is what a run that follows it alone finds.
    for (index, mode) in [1, 3].into_iter().enumerate() {
        let scene = quick(&folder, settings(json!({ "mode": mode })));
        succeeds(&folder, &["run", &scene, "--out", "alone"]);
        let alone: Summary = serde_json::from_value(read_json(&folder.join("alone/summary.json"))).unwrap();
        let numbers = |backbone| serde_json::to_value(backbone).unwrap();
        assert_eq!(
            numbers(&both.backbones[index].backbone),
            numbers(&alone.backbone),
            "mode {mode}"
        );
        assert!(alone.backbones.is_empty());
    }
    // A run of the same scene that follows one mode leaves nothing of the other behind.
    let scene = quick(&folder, settings(json!({ "mode": 1 })));
    succeeds(&folder, &["run", &scene, "--out", "both"]);
    assert!(!folder.join("both/mode-3-backbone.csv").exists());
    assert!(!folder.join("both/interface-mode-3-amplitude-01.vtu").exists());
}
