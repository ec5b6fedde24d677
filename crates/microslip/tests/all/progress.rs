//! What commands show while they work: to persons, and to programs.
#![allow(clippy::unwrap_used)]
#![allow(clippy::print_stdout, reason = "a test prints what it measures")]

use crate::common::{exit_code, folder, messages, read_json, run};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

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
    assert!(progress.iter().filter(|event| event["seconds_left"].is_f64()).count() > 3);
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
fn a_program_reads_how_far_a_study_is() {
    let folder = folder("progress-study");
    let mut scene: Value = scenes::parse_json(&std::fs::read_to_string(QUICK).unwrap()).unwrap();
    scene["analyses"]["backbone"]["amplitudes"] = json!(2);
    let plan = json!({ "scene": scene, "cases": [{ "/interfaces/mu": 0.2 }, { "/interfaces/mu": 0.3 }] });
    std::fs::write(folder.join("plan.json"), plan.to_string()).unwrap();
    let output = run(&folder, &["study", "plan.json", "--out", "out", "--json"]);
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&printed["results"], &printed["answer"]["converged"]),
        (&json!("out"), &json!(2))
    );
    let events = events(&messages(&output));
    for name in ["begin", "progress", "end"] {
        assert!(
            named(&events, name).iter().all(|event| event["stage"] == "study"),
            "{name}"
        );
    }
    assert_eq!([named(&events, "begin").len(), named(&events, "end").len()], [1, 1]);
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

/// Runs a scene, and gives what it told was left at parts of its time, over what was left.
fn estimates(folder: &Path, arguments: &[&str]) -> (f64, Vec<Option<f64>>) {
    let began = Instant::now();
    let mut program = Command::new(crate::PROGRAM)
        .args(arguments)
        .args(["--no-cache", "--json"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut told: Vec<(f64, Option<f64>)> = Vec::new();
    for line in BufReader::new(program.stderr.take().unwrap()).lines() {
        let event: Value = serde_json::from_str(&line.unwrap()).unwrap();
        if event["event"] == "progress" {
            told.push((began.elapsed().as_secs_f64(), event["seconds_left"].as_f64()));
        }
    }
    assert!(program.wait().unwrap().success());
    let total = began.elapsed().as_secs_f64();
    let at = |part: f64| {
        let (when, left) = told.iter().rev().find(|(when, _)| *when <= part * total)?;
        Some((when + (*left)?) / total)
    };
    (total, [0.2, 0.4, 0.6, 0.8].map(at).to_vec())
}

/// Prints predicted over true total times; what else the computer does while it runs is in the figures.
#[test]
#[ignore = "a minute and a half; `.ci/run slow` runs it"]
fn slow_what_is_left_is_told_from_the_first_fifth_on() {
    let folder = folder("progress-left");
    for (name, arguments) in [
        ("flange", &["new", "flange", "--benchmark", "flange"][..]),
        (
            "chain",
            &["new", "chain", "--benchmark", "chain-of-laps", "--joints", "8"],
        ),
    ] {
        let output = run(&folder, arguments);
        assert_eq!(exit_code(&output), 0, "{name}: {}", messages(&output));
    }
    for scene in [
        &["--benchmark", "brb/brb-flat"][..],
        &["--benchmark", "brb/brb-topography"],
        &["--benchmark", "brb/brb-synthetic-scan"],
        &["flange/scene.json"],
        &["chain/scene.json"],
    ] {
        let (total, found) = estimates(&folder, &[&["run", "--out", "out", "--overwrite"], scene].concat());
        println!("{scene:?}: {total:.1} s, predicted over true at 20, 40, 60 and 80 %: {found:.2?}");
        for ratio in found {
            let ratio = ratio.unwrap_or_else(|| panic!("{scene:?}: no estimate"));
            assert!((1.0 / 3.0..3.0).contains(&ratio), "{scene:?}: {ratio}");
        }
    }
}
