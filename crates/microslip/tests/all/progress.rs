//! What commands show while they work: to persons, and to programs.
#![allow(clippy::unwrap_used)]

use crate::common::{exit_code, folder, messages, read_json, run};
use serde_json::{Value, json};
use std::path::Path;

const QUICK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scenes/brb-quick.json");

/// The lines of standard error.
fn events(text: &str) -> Vec<Value> {
    let event = |line: &str| {
        let event: Value = serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
        assert!(event["event"].is_string(), "{line}");
        event
    };
    text.lines().map(event).collect()
}

/// Events with this name.
fn named<'a>(events: &'a [Value], name: &str) -> Vec<&'a Value> {
    events.iter().filter(|event| event["event"] == name).collect()
}

#[test]
fn a_program_reads_events_and_the_answer() {
    let folder = folder("progress-json");
    let output = run(&folder, &["run", QUICK, "--json"]);
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let summary = read_json(&folder.join("results/brb-quick/summary.json"));
    assert_eq!(
        Path::new(printed["results"].as_str().unwrap()),
        Path::new("results/brb-quick")
    );
    assert_eq!(printed["answer"], summary["answer"]);
    assert_eq!(printed["answer"][0]["mode"], 1);

    let events = events(&messages(&output));
    let stages = |name: &str| -> Vec<String> {
        let stages = named(&events, name).into_iter();
        stages
            .map(|event| event["stage"].as_str().unwrap().to_owned())
            .collect()
    };
    for stage in [
        "mesh",
        "assemble",
        "factor",
        "reduce",
        "characterise",
        "prestress",
        "modes",
        "backbone",
    ] {
        assert!(stages("begin").contains(&stage.to_owned()), "{stage}");
    }
    let (mut begun, mut ended) = (stages("begin"), stages("end"));
    begun.sort_unstable();
    ended.sort_unstable();
    assert_eq!(begun, ended);
    assert!(
        named(&events, "end")
            .iter()
            .all(|end| end["seconds"].as_f64().unwrap() >= 0.0)
    );
    let progress = named(&events, "progress");
    assert!(progress.iter().any(|event| event["stage"] == "backbone"));
    for event in progress {
        let fraction = event["fraction"].as_f64().unwrap();
        assert!((0.0..=1.0).contains(&fraction), "{event}");
        assert!(
            event["seconds_left"].is_null() || event["seconds_left"].as_f64().unwrap() >= 0.0,
            "{event}"
        );
    }
    assert!(!named(&events, "echo").is_empty());

    let mut points: Vec<Value> = named(&events, "point").into_iter().cloned().collect();
    points.sort_by(|a, b| {
        a["amplitude_m"]
            .as_f64()
            .unwrap()
            .total_cmp(&b["amplitude_m"].as_f64().unwrap())
    });
    let expected = summary["backbone"].as_array().unwrap().iter().map(|point| {
        json!({
            "event": "point",
            "mode": 1,
            "amplitude_m": point["response_displacement"],
            "frequency_hz": point["frequency_hz"],
            "damping_ratio": point["damping_ratio"],
        })
    });
    assert_eq!(points, expected.collect::<Vec<_>>());
}

#[test]
fn samples_and_second_runs_tell_no_amplitudes() {
    let folder = folder("progress-samples");
    let mut scene: Value = scenes::parse_json(&std::fs::read_to_string(QUICK).unwrap()).unwrap();
    scene["analyses"]["backbone"]["amplitudes"] = json!(3);
    scene["uncertain"] = json!({ "parameters": { "interfaces.mu": { "normal": { "mean": 0.2, "sd": 0.02 } } } });
    std::fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
    let output = run(
        &folder,
        &["run", "scene.json", "--samples", "2", "--estimate-error=mesh", "--json"],
    );
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    let events = events(&messages(&output));
    assert_eq!(named(&events, "point").len(), 3);
    assert!(
        named(&events, "begin")
            .iter()
            .filter(|event| event["stage"] == "backbone")
            .count()
            > 1
    );
}

#[test]
fn errors_are_events_too() {
    let folder = folder("progress-error");
    std::fs::write(folder.join("scene.json"), "{ \"frobnicate\": 1 }").unwrap();
    let output = run(&folder, &["run", "scene.json", "--json"]);
    assert_eq!(exit_code(&output), 1);
    assert!(output.stdout.is_empty());
    let events = events(&messages(&output));
    let [error] = events.as_slice() else {
        panic!("{events:?}")
    };
    assert_eq!(error["event"], "error");
    assert!(error["text"].as_str().unwrap().contains("scene.json"), "{error}");
    let plain = run(&folder, &["run", "scene.json", "--quiet"]);
    assert_eq!(
        messages(&plain),
        format!("error: {}\n", error["text"].as_str().unwrap())
    );
}

#[test]
fn a_quiet_run_says_the_answer_alone() {
    let folder = folder("progress-quiet");
    let output = run(&folder, &["run", QUICK, "--quiet"]);
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    let others: Vec<String> = messages(&output)
        .lines()
        .filter(|line| !line.starts_with("warning: "))
        .map(str::to_owned)
        .collect();
    assert_eq!(others, Vec::<String>::new());
    assert!(String::from_utf8(output.stdout).unwrap().contains("mode 1: "));
    let both = run(&folder, &["run", QUICK, "--quiet", "--json"]);
    assert_eq!(exit_code(&both), 2);
}
