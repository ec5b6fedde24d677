//! `cargo xtask paper` as scripts meet it: its folder, its pages and what it stores.
#![allow(clippy::unwrap_used)]

use crate::common::{exit_code, folder, messages, read_json, run};
use serde_json::json;

/// One entry from its scenes to its page, on the coarse mesh; what is stored serves the next run.
#[test]
fn an_entry_of_the_paper_is_computed_written_and_stored() {
    let folder = folder("paper");
    let arguments = ["paper", "--only", "table3", "--quick", "--out", "page"];
    let output = run(&folder, &arguments);
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    let first = read_json(&folder.join("page/paper.json"));
    let [entry] = first.as_array().unwrap().as_slice() else {
        panic!("one entry was asked for: {first}");
    };
    assert_eq!((&entry["id"], &entry["status"]), (&json!("table3"), &json!("computed")));
    let number = |column: &str, name: &str| entry[column][name].as_f64().unwrap();
    let mode = "mode 1, free (Hz)";
    assert_eq!(number("published", mode), 167.42);
    let computed = number("computed", mode);
    assert!((computed / 167.42 - 1.0).abs() < 0.03, "{computed}");
    assert!((number("difference", mode) - (computed / 167.42 - 1.0)).abs() < 1e-12);
    // Friction that sticks holds more than none.
    assert!(number("computed", "mode 1 without friction (Hz)") < computed);
    // Springs stiffen, by less than two decimals show.
    for mode in 1..=10 {
        let [free, hung] = ["free", "on cords"].map(|how| number("computed", &format!("mode {mode}, {how} (Hz)")));
        assert!(free < hung && hung < free + 5e-3, "{mode}: {free} {hung}");
    }
    let mut fields: Vec<&str> = entry.as_object().unwrap().keys().map(String::as_str).collect();
    fields.sort_unstable();
    let agreed = "comparable computed difference id inputs judgement published seconds status title";
    assert_eq!(fields, agreed.split_whitespace().collect::<Vec<_>>());
    let names = |column: &str| entry[column].as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(names("published"), names("computed"));
    assert_eq!(names("difference"), names("computed"));
    let page = std::fs::read_to_string(folder.join("page/report.html")).unwrap();
    assert!(page.contains("Table 3") && page.contains("167.42") && page.contains("quick look"));
    for outside in ["http-equiv", "src=", "<script", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }

    let again = run(&folder, &arguments);
    assert_eq!(exit_code(&again), 0, "{}", messages(&again));
    assert!(
        messages(&again).contains("2 of 2 scenes were taken from an earlier run"),
        "{}",
        messages(&again)
    );
    let second = read_json(&folder.join("page/paper.json"));
    assert_eq!(second[0]["computed"], entry["computed"]);
}

#[test]
fn an_unknown_entry_of_the_paper_is_refused() {
    let folder = folder("paper-unknown");
    let output = run(&folder, &["paper", "--only", "table99"]);
    assert_eq!(exit_code(&output), 1);
    let text = messages(&output);
    for part in ["error: ", "`table99`", "table1", "fig19", "experiment"] {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
    assert!(!folder.join("results").exists(), "a refused command leaves no folder");
}
