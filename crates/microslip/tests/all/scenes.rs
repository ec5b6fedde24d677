//! Scenes that come with the program, their schema, and runs that follow several modes.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{exit_code, folder, messages, read_json, run, succeeds};
use analyses::results::summary::BackboneSummary;
use boon::{Compiler, Schemas};
use host::benchmarks::{BENCHMARKS, read};
use microslip::{Scene, Summary};
use serde_json::{Value, json};
use std::path::Path;

/// A scene of the coarse benchmark in a file.
fn quick(folder: &Path, analyses: Value) -> String {
    let scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": "quick" },
        "interfaces": { "law": { "friction": "lumped" } },
        "analyses": analyses,
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
    let mut with_loops = base.clone();
    with_loops["analyses"]["backbone"]["loops_at"] = json!([[0.36, 0.0, "1 mm"], ["3 mm", 0.0]]);
    satisfies(&schema, &with_loops).unwrap();
    let scene = read("loops", &with_loops.to_string()).unwrap();
    satisfies(&schema, &serde_json::to_value(scene).unwrap()).unwrap();
    for (field, value) in [
        ("frobnicate", json!(1)),
        ("analyses", json!({ "backbone": { "loops_at": [[0.36]] } })),
        ("interfaces", json!({ "mu": "high" })),
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
        ("analyses", json!({ "backbone": { "amplitudes": -1 } })),
    ] {
        let mut wrong = base.clone();
        wrong[field] = value;
        assert!(satisfies(&schema, &wrong).is_err(), "{field}");
    }
    let scene = quick(
        &folder,
        json!({ "backbone": { "amplitudes": 2, "vertices_per_quarter": 2 } }),
    );
    succeeds(&folder, &["run", &scene, "--out", "results"]);
    let schema = succeeds(&folder, &["schema", "summary"]);
    satisfies(&schema, &read_json(&folder.join("results/summary.json"))).unwrap();
}

#[test]
fn several_modes_have_a_backbone_each() {
    let folder = folder("modes");
    let settings = |followed: &[usize]| {
        json!({
            "modes": { "followed": followed },
            "backbone": { "amplitudes": 3, "vertices_per_quarter": 4, "amplitude_from": 1e-6, "amplitude_to": 1e-4 },
        })
    };
    let scene = quick(&folder, settings(&[1, 3]));
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
        let scene = quick(&folder, settings(&[mode]));
        succeeds(&folder, &["run", &scene, "--out", "alone"]);
        let alone: Summary = serde_json::from_value(read_json(&folder.join("alone/summary.json"))).unwrap();
        // The error of the mesh is the largest of all modes that are followed.
        let numbers = |backbone: &[BackboneSummary]| -> Vec<Value> {
            let without_error = |point: &BackboneSummary| BackboneSummary {
                error: None,
                ..point.clone()
            };
            let points = backbone.iter().map(without_error);
            points.map(|point| serde_json::to_value(point).unwrap()).collect()
        };
        assert_eq!(
            numbers(&both.backbones[index].backbone),
            numbers(&alone.backbone),
            "mode {mode}"
        );
        assert!(alone.backbones.is_empty());
    }
    // A run of the same scene that follows one mode leaves nothing of the other behind.
    let scene = quick(&folder, settings(&[1]));
    succeeds(&folder, &["run", &scene, "--out", "both"]);
    assert!(!folder.join("both/mode-3-backbone.csv").exists());
    assert!(!folder.join("both/interface-mode-3-amplitude-01.vtu").exists());
}

/// Terminal text and spectrum of `model SCENE --spectrum`.
fn spectrum(folder: &Path, scene: &str) -> (String, Value) {
    let text = succeeds(
        folder,
        &[
            "model",
            scene,
            "--spectrum",
            "--count",
            "6",
            "--out",
            "model",
            "--overwrite",
        ],
    );
    (text, read_json(&folder.join("model/summary.json"))["model"].take())
}

/// The frequencies of one kind, and how many motions have no energy.
fn frequencies(model: &Value, kind: &str) -> (u64, Vec<f64>) {
    let found = &model["spectrum"][kind];
    let list = found["frequencies_hz"].as_array().unwrap();
    (
        found["zero_energy_modes"].as_u64().unwrap(),
        list.iter().map(|f| f.as_f64().unwrap()).collect(),
    )
}

#[test]
#[ignore = "half a minute; `.ci/run slow` runs it"]
fn slow_spectra_are_printed_for_any_order_of_elements() {
    let folder = folder("orders");
    let write = |name: &str, scene: &Value| std::fs::write(folder.join(name), scene.to_string()).unwrap();
    let beam = |order: &str, symmetry: &str| {
        json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "benchmark": "brake-reuss-beam" },
            "model": { "refinement": "quick", "element_order": order, "symmetry": symmetry },
        })
    };
    let printed = |text: &str, model: &Value| {
        for kind in ["unstressed", "stuck", "with_linear"] {
            let (_, list) = frequencies(model, kind);
            assert_eq!(list.len(), 6);
            for f in list {
                assert!(text.contains(&format!("{f:.2}")), "{text} has no {f:.2}");
            }
        }
    };
    let mut of_beam = Vec::new();
    for order in ["linear", "quadratic"] {
        let [whole, half] = ["none", "half"].map(|symmetry| {
            write("scene.json", &beam(order, symmetry));
            let (text, model) = spectrum(&folder, "scene.json");
            printed(&text, &model);
            assert!(
                model["raised"].is_null() && !text.contains("were made quadratic"),
                "{text}"
            );
            model
        });
        // The half has the symmetric modes of the whole.
        for (kind, zero) in [("unstressed", [7, 4]), ("stuck", [6, 3]), ("with_linear", [6, 3])] {
            let [whole, half] = [&whole, &half].map(|model| frequencies(model, kind));
            assert_eq!([whole.0, half.0], zero, "{order}, {kind}");
            assert!(
                half.1
                    .iter()
                    .any(|f| whole.1.iter().any(|w| (f / w - 1.0).abs() < 1e-6))
            );
            for f in half.1.iter().filter(|f| **f < whole.1[5] * (1.0 - 1e-6)) {
                assert!(
                    whole.1.iter().any(|w| (f / w - 1.0).abs() < 1e-6),
                    "{order}, {kind}: {f}"
                );
            }
        }
        of_beam.push(whole);
    }
    let [linear, quadratic] = [&of_beam[0], &of_beam[1]].map(|model| frequencies(model, "stuck").1);
    assert!(linear.iter().zip(&quadratic).all(|(a, b)| b < a && *b > 0.9 * a));

    // The block mesh as a deck: linear as it is, and made quadratic, where holes stay polygons.
    write("scene.json", &beam("linear", "none"));
    succeeds(&folder, &["export", "scene.json", "--format", "inp", "--out", "deck"]);
    let mut scene = read_json(&folder.join("deck/structure.json"));
    let (text, model) = spectrum(&folder, "deck/structure.json");
    printed(&text, &model);
    assert!(model["raised"].is_null());
    for (a, b) in linear.iter().zip(frequencies(&model, "stuck").1) {
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    }
    scene["model"]["element_order"] = json!("quadratic");
    write("deck/quadratic.json", &scene);
    let (text, model) = spectrum(&folder, "deck/quadratic.json");
    printed(&text, &model);
    let stuck = frequencies(&model, "stuck").1;
    // Softer than the same mesh of linear elements, and near the benchmark's quadratic mesh, which is graded.
    for ((linear, raised), graded) in linear.iter().zip(&stuck).zip(&quadratic) {
        assert!(
            raised < linear && (raised / graded - 1.0).abs() < 2e-2,
            "{linear} {raised} {graded}"
        );
    }
    // The equally spaced block mesh in C3D20R with curved edges instead of polygons (Hz).
    assert!((stuck[0] / 200.6213 - 1.0).abs() < 1e-4, "{}", stuck[0]);
    let count = |field: &str| model["raised"][field].as_u64().unwrap();
    assert_eq!(count("elements"), model["n_elements"].as_u64().unwrap());
    let said = format!(
        "{} linear elements of the deck were made quadratic, which added {} nodes",
        count("elements"),
        count("added_nodes")
    );
    assert!(text.contains(&said), "{text}");

    // Written as a deck of quadratic elements, with a scene that takes them, and their materials, as they are.
    let mut own = scene.clone();
    own["structure"]["deck"]["materials"] = json!("deck");
    own["model"]["material"].as_object_mut().unwrap().remove("density");
    write("deck/own.json", &own);
    succeeds(
        &folder,
        &["export", "deck/own.json", "--format", "inp", "--out", "again"],
    );
    let written = std::fs::read_to_string(folder.join("again/structure.inp")).unwrap();
    assert!(written.contains("TYPE=C3D20R") && !written.contains("TYPE=C3D8"));
    let (_, again) = spectrum(&folder, "again/structure.json");
    assert!(again["raised"].is_null());
    assert_eq!(again["n_nodes"], model["n_nodes"]);
    for (a, b) in stuck.iter().zip(frequencies(&again, "stuck").1) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
    // So is the quadratic mesh of the benchmark.
    write("scene.json", &beam("quadratic", "none"));
    succeeds(&folder, &["export", "scene.json", "--format", "inp", "--out", "curved"]);
    let (_, curved) = spectrum(&folder, "curved/structure.json");
    for (a, b) in quadratic.iter().zip(frequencies(&curved, "stuck").1) {
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    }

    // Summary and report of a run say it too.
    scene["analyses"]["backbone"]["amplitudes"] = json!(0);
    scene["interfaces"]["points_per_direction"] = json!(2);
    write("deck/quadratic.json", &scene);
    succeeds(&folder, &["run", "deck/quadratic.json", "--out", "run"]);
    let summary = read_json(&folder.join("run/summary.json"));
    assert_eq!(
        summary["model"]["raised"]["added_nodes"],
        model["raised"]["added_nodes"]
    );
    let report = std::fs::read_to_string(folder.join("run/report.html")).unwrap();
    assert!(report.contains("were made quadratic"));
    satisfies(&succeeds(&folder, &["schema", "summary"]), &summary).unwrap();
}
