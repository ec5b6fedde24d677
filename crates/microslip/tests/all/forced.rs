//! Responses to harmonic forces, from a scene to its files.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{exit_code, folder, messages, read_json, run, succeeds};
use matrix_files::npz;
use matrix_files::value::Array;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const QUICK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scenes/brb-quick.json");

/// The coarse beam with few free motions, in a folder of its own.
fn scene(name: &str) -> PathBuf {
    let folder = folder(name);
    let mut scene = read_json(Path::new(QUICK));
    scene["name"] = json!("joint");
    scene["analyses"]["backbone"]["methods"] = json!(["rqnma"]);
    scene["analyses"]["epmc"] = json!({ "modal_amplitudes": [2e-5, 6e-5, 2e-4], "samples": 64 });
    scene["analyses"]["forced"] = json!({ "levels": [1.0, 4.0], "from_hz": 162, "to_hz": 175 });
    std::fs::write(folder.join("joint.json"), scene.to_string()).unwrap();
    folder
}

fn numbers(array: &Array) -> &[f64] {
    match array {
        Array::Dense(values) => values.data(),
        other => panic!("no numbers: {other:?}"),
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_forced_responses_are_written_as_a_set_that_can_be_repeated() {
    let folder = scene("forced");
    let arguments = ["run", "joint.json", "--only", "forced,epmc", "--verbose"];
    let output = run(&folder, &arguments);
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    let progress = messages(&output);
    assert!(
        progress.contains("epmc ... ") && progress.contains("forced ... "),
        "{progress}"
    );
    // No other methods.
    assert!(!progress.contains("methods ... "), "{progress}");

    let results = folder.join("results/joint-forced");
    let summary = read_json(&results.join("summary.json"));
    assert_eq!(summary["backbone"], json!([]));
    let methods: Vec<&String> = summary["methods"].as_object().unwrap().keys().collect();
    assert_eq!(methods, ["epmc"]);
    let levels = summary["forced"].as_array().unwrap();
    let forces: Vec<f64> = levels.iter().map(|level| level["level"].as_f64().unwrap()).collect();
    assert_eq!(forces, [1.0, 4.0]);
    for stage in ["epmc", "forced"] {
        assert!(summary["timings"][stage].as_f64().unwrap() > 0.0, "{stage}");
    }

    // The terminal tells what the summary has.
    let printed = String::from_utf8(output.stdout).unwrap();
    for level in levels {
        let frequency = level["resonances"][0]["frequency_hz"].as_f64().unwrap();
        assert!(printed.contains(&format!("{frequency:.4}")), "{printed}");
        let points = level["frequency"].as_array().unwrap().len();
        assert!(printed.contains(&format!("{points} points")), "{printed}");
        assert!(level["single_mode_error"].is_array());
    }
    assert!(printed.contains("stability: not judged"), "{printed}");

    // So do the tables and the arrays.
    let table = std::fs::read_to_string(results.join("forced.csv")).unwrap();
    let frequencies = |level: &Value| level["frequency"].as_array().unwrap().clone();
    let all: Vec<f64> = levels
        .iter()
        .flat_map(frequencies)
        .map(|f| f.as_f64().unwrap())
        .collect();
    assert_eq!(table.lines().count(), 1 + all.len());
    let column = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(2).unwrap().parse().unwrap());
    assert_eq!(column.collect::<Vec<f64>>(), all);
    let table = std::fs::read_to_string(results.join("epmc.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 3);
    let arrays = npz::read(&results.join("periodic.npz")).unwrap().arrays;
    assert_eq!(numbers(&arrays["forced_frequency"]), all);
    assert_eq!(numbers(&arrays["epmc_modal_amplitude"]).len(), 3);
    assert!(!numbers(&arrays["single_mode_amplitude"]).is_empty());

    for (picture, label) in [
        ("forced.svg", "EPMC backbone"),
        ("harmonics.svg", "harmonic 2"),
        ("backbone.svg", "EPMC"),
    ] {
        let text = std::fs::read_to_string(results.join(picture)).unwrap();
        assert!(text.contains("<polyline") && text.contains(label), "{picture}");
    }
    let report = std::fs::read_to_string(results.join("report.html")).unwrap();
    assert!(report.contains("<h2>Periodic motions</h2>") && report.contains("EPMC backbone"));
    assert!(!report.contains("Backbone in numbers") && !report.contains("All amplitudes converged"));

    let verified = succeeds(&folder, &["verify", "results/joint-forced", "--rerun"]);
    assert!(verified.contains("bit by bit"), "{verified}");
}

#[test]
fn what_a_scene_does_not_ask_for_is_refused_before_anything_is_computed() {
    let folder = scene("only-refused");
    for (only, parts) in [
        (
            "ring_down",
            ["does not ask for `ring_down`", "backbone, epmc, forced, modes"],
        ),
        ("epmc,forces", ["does not ask for `forces`", "analyses"]),
    ] {
        let output = run(&folder, &["run", "joint.json", "--only", only]);
        assert_eq!(exit_code(&output), 1, "{only}");
        let text = messages(&output);
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    }
    assert!(!folder.join("results").exists());
}

#[test]
#[ignore = "twenty seconds; `.ci/run slow` runs it"]
fn slow_a_controlled_test_is_identified_from_the_table_that_its_simulation_writes() {
    let folder = folder("controlled");
    let mut scene = read_json(Path::new(QUICK));
    scene["name"] = json!("joint");
    scene["background_damping"] = json!(1e-3);
    scene["analyses"]["forced"] =
        json!({ "response_levels": ["1 um", "30 um"], "from_hz": 160, "to_hz": 180, "samples": 64, "stability": true });
    std::fs::write(folder.join("joint.json"), scene.to_string()).unwrap();
    succeeds(&folder, &["run", "joint.json"]);
    let results = folder.join("results/joint");
    let summary = read_json(&results.join("summary.json"));
    let table = std::fs::read_to_string(results.join("forced.csv")).unwrap();
    let headings = table.lines().next().unwrap();
    assert!(
        headings.ends_with("force [N],largest_multiplier [-],stable"),
        "{headings}"
    );

    let identify = [
        "identify",
        "results/joint/forced.csv",
        "--stepped-sine",
        "--out",
        "steps",
    ];
    succeeds(&folder, &identify);
    let found = read_json(&folder.join("steps/identification.json"));
    let levels = found["levels"].as_array().unwrap();
    assert_eq!(levels.len(), 2);
    for (level, simulated) in levels.iter().zip(summary["forced"].as_array().unwrap()) {
        let number = |name: &str| level[name].as_f64().unwrap();
        let resonance = &simulated["resonances"][0];
        let at = |name: &str| resonance[name].as_f64().unwrap();
        let omega = std::f64::consts::TAU * at("frequency_hz");
        let zeta = at("force") / (2.0 * number("modal_mass_kg") * omega * omega * at("amplitude"));
        let errors = [
            number("frequency_hz") / at("frequency_hz") - 1.0,
            number("damping_ratio") / zeta - 1.0,
            number("residual"),
            number("amplitude_error"),
        ];
        println!("{errors:?} {level}");
        assert!(errors[0].abs() < 1e-4 && errors[1].abs() < 1e-2, "{errors:?}");
        assert!(errors[2] < 1e-2 && errors[3] < 1e-6, "{errors:?}");
    }
    // A stuck joint has the damping of the background alone.
    let least = levels[0]["damping_ratio"].as_f64().unwrap();
    assert!((least / 1e-3 - 1.0).abs() < 0.05, "{least}");
    succeeds(&folder, &["compare", "results/joint", "steps", "--out", "beside"]);

    // What is no such table is refused with the column that it lacks.
    std::fs::write(folder.join("other.csv"), "frequency [Hz],amplitude [m]\n1,2\n").unwrap();
    let refused = run(&folder, &["identify", "other.csv", "--stepped-sine", "--out", "other"]);
    assert_eq!(exit_code(&refused), 1, "{}", messages(&refused));
    assert!(messages(&refused).contains("phase_lag"), "{}", messages(&refused));
    let mixed = [
        "identify",
        "other.csv",
        "--stepped-sine",
        "--unit",
        "g",
        "--out",
        "other",
    ];
    assert_eq!(exit_code(&run(&folder, &mixed)), 2);
}
