//! `cargo xtask extremes` as scripts meet it: exit codes and `extremes.json`.
#![allow(clippy::unwrap_used)]

use crate::common::{folder, run};
use serde_json::Value;
use std::path::Path;
use std::process::Output;

fn extremes(folder: &Path, arguments: &[&str]) -> Output {
    run(folder, &[&["extremes"], arguments].concat())
}

/// Cases of every group; the others take longer and run among the gates.
const CASES: [&str; 9] = [
    "bolt-load-0",
    "modal-force-below-round-off",
    "units-mm-t-s",
    "mu-0",
    "gap-beyond-all-closure",
    "one-element-carries-all",
    "inverted-solid-element",
    "unconnected-part",
    "interrupted-and-resumed",
];

#[test]
fn every_case_gives_its_account() {
    let folder = folder("extremes");
    let output = extremes(&folder, &[&["--out", "here", "--only"], &CASES[..]].concat());
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{table}");
    assert!(table.contains("9 of 9 cases did what they must"), "{table}");
    let mut names: Vec<_> = std::fs::read_dir(folder.join("here"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["extremes.json", "manifest.json"]);
    let text = std::fs::read_to_string(folder.join("here/extremes.json")).unwrap();
    let all: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&all["schema_version"], &all["full"], &all["failed"]),
        (&1.into(), &false.into(), &0.into())
    );
    assert_eq!(all["scene"]["model"]["refinement"], "quick");
    let cases = all["cases"].as_array().unwrap();
    assert_eq!(
        cases
            .iter()
            .map(|case| case["name"].as_str().unwrap())
            .collect::<Vec<_>>(),
        CASES
    );
    for case in cases {
        let name = case["name"].as_str().unwrap();
        assert!(table.contains(name), "{name}");
        for field in ["change", "expected", "outcome"] {
            assert!(!case[field].as_str().unwrap().is_empty(), "{name} {field}");
        }
        assert_eq!(case["passed"], true, "{name}");
        assert!(case["seconds"].as_f64().unwrap() >= 0.0, "{name}");
        let checks = case["checks"].as_object().unwrap();
        assert!(
            !checks.is_empty() && checks.values().all(|check| check["holds"] == true),
            "{name}"
        );
        let refused = case["outcome"].as_str().unwrap().starts_with("refused: ");
        assert_eq!(case["iterations"].is_null(), refused, "{name}");
    }
    // Invariants stand in the account with what they are and what they may be.
    let energy = &cases[2]["checks"]["energy identity, of what is allowed"];
    assert!(energy["value"].as_f64().unwrap() <= energy["allowed"].as_f64().unwrap());
}

#[test]
fn an_unknown_case_is_refused_by_name() {
    let folder = folder("extremes-unknown");
    let output = extremes(&folder, &["--only", "mu-0", "mu-11", "--out", "here"]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.contains("no case `mu-11`") && text.contains("mu-10"), "{text}");
    assert!(!folder.join("here").exists());
}
