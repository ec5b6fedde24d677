//! `cargo xtask trade`, and scenes that ask for an accuracy, as scripts meet them.
#![allow(clippy::unwrap_used)]
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn xtask(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// An empty folder of its own for each test.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn read_json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn errors_fall_from_rung_to_rung_and_finished_runs_are_kept() {
    let folder = folder("trade");
    let go = || {
        xtask(
            &folder,
            &["trade", "--quick", "--only", "vertices", "tolerance", "--out", "t"],
        )
    };
    let output = go();
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let trade = read_json(&folder.join("t/trade.json"));
    let rungs: Vec<&Value> = trade["rungs"].as_array().unwrap().iter().collect();
    assert_eq!(rungs.len(), 7 + 5);
    for rung in &rungs {
        assert_eq!(rung["status"], "measured");
        assert_eq!(rung["not_converged"], 0);
        assert!(rung["seconds"].as_f64().unwrap() > 0.0);
    }
    // The largest error of damping falls from rung to rung until the reference, whose own is zero.
    let errors = |dial: &str| -> Vec<f64> {
        let own = rungs.iter().filter(|rung| rung["dial"] == dial);
        own.map(|rung| {
            let at = rung["errors"]["damping_ln"].as_array().unwrap();
            at.iter().map(|e| e.as_f64().unwrap().abs()).fold(0.0, f64::max)
        })
        .collect()
    };
    let vertices = errors("vertices");
    assert!(vertices.windows(2).all(|pair| pair[1] < pair[0]), "{vertices:?}");
    assert_eq!(vertices.last(), Some(&0.0));
    // Work by a polygon through the loop: second order in the vertices.
    let order = trade["limits"]["vertices"][1]["order"].as_f64().unwrap();
    assert!((1.5..3.0).contains(&order), "{order}");
    let tolerance = errors("tolerance");
    assert!(tolerance[0] < 0.1 && tolerance[3] < 1e-6, "{tolerance:?}");
    let parts = &trade["budget"]["parts"];
    assert!(parts["vertices"]["damping_ln"].as_f64().unwrap() < 0.01);
    for file in ["trade.csv", "trade.md", "trade.svg"] {
        assert!(folder.join("t").join(file).exists(), "{file}");
    }
    // Nothing is run again: a run would leave another time.
    let again = go();
    assert_eq!(again.status.code(), Some(0));
    assert_eq!(read_json(&folder.join("t/trade.json")), trade);

    let unknown = xtask(&folder, &["trade", "--only", "speed"]);
    assert_eq!(unknown.status.code(), Some(1));
    let message = String::from_utf8(unknown.stderr).unwrap();
    assert!(message.contains("`speed`") && message.contains("vertices"), "{message}");
}

#[test]
fn an_accuracy_chooses_settings_and_an_error_is_estimated() {
    let folder = folder("accuracy");
    let mut scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "accuracy": "draft",
        "cqsma": { "amplitudes": 3, "amplitude_from": 5e-5, "amplitude_to": 5e-4 },
    });
    std::fs::write(folder.join("draft.json"), scene.to_string()).unwrap();
    let output = xtask(&folder, &["brb", "draft.json", "--out", "run", "--estimate-error"]);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let summary = read_json(&folder.join("run/summary.json"));
    assert_eq!(summary["scene"]["model"]["refinement"], "quick");
    assert_eq!(summary["accuracy"]["name"], "draft");
    assert_eq!(summary["error_estimate"]["finer"], "coarse");
    // What is promised against the finest mesh covers the difference to the next one.
    let number = |pointer: &str| summary.pointer(pointer).and_then(Value::as_f64).unwrap();
    let linear = number("/error_estimate/linear_frequency").abs();
    assert!(
        linear > 1e-4 && linear < number("/accuracy/frequency_error"),
        "{linear}"
    );
    assert!(number("/error_estimate/damping") < number("/accuracy/damping_error"));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("settings `draft`") && text.contains("against the settings `coarse`"),
        "{text}"
    );

    scene["accuracy"] = json!({ "damping": 1e-12 });
    std::fs::write(folder.join("impossible.json"), scene.to_string()).unwrap();
    let output = xtask(&folder, &["brb", "impossible.json"]);
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.contains("impossible.json") && message.contains("no measured set"),
        "{message}"
    );
}
