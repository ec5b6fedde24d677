//! The tasks as scripts meet them: the built program, its exit codes, its messages and its files.
#![allow(clippy::unwrap_used)]
#[path = "../../crates/microslip/tests/common/mod.rs"]
mod common;

use common::{assert_same_numbers, exit_code, folder, messages, read_json, run};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

const PROGRAM: &str = env!("CARGO_BIN_EXE_xtask");
const QUICK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/scenes/brb-quick.json");

/// The quick scene, run once with two threads and an empty cache; the folder that it ran in.
fn quick() -> &'static Path {
    static RUN: OnceLock<PathBuf> = OnceLock::new();
    RUN.get_or_init(|| {
        let folder = folder("quick");
        let output = run(&folder, &["brb", QUICK, "--threads", "2"]);
        assert_eq!(exit_code(&output), 0, "{}", messages(&output));
        folder
    })
}

fn quick_results() -> PathBuf {
    quick().join("results/brb-quick")
}

fn quick_summary() -> Value {
    read_json(&quick_results().join("summary.json"))
}

#[test]
fn the_quick_scene_passes_its_checks() {
    let output = run(quick(), &["check-results", "results/brb-quick"]);
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
}

#[test]
fn a_cached_model_gives_the_same_results_and_old_fields_are_removed() {
    let folder = folder("cached");
    let cache = quick().join("results/.cache");
    std::fs::create_dir_all(folder.join("results/.cache")).unwrap();
    for entry in std::fs::read_dir(cache).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.join("results/.cache").join(path.file_name().unwrap())).unwrap();
    }
    let mut scene = read_json(Path::new(QUICK));
    let go = |scene: &Value| {
        std::fs::write(folder.join("brb-quick.json"), scene.to_string()).unwrap();
        let output = run(&folder, &["brb", "brb-quick.json", "--out", "here"]);
        assert_eq!(exit_code(&output), 0, "{}", messages(&output));
        read_json(&folder.join("here/summary.json"))
    };
    let first = go(&scene);
    assert_eq!(first["timings"]["reduce"], 0.0);
    assert_same_numbers(&folder.join("here"), &quick_results());

    let fields = |folder: &Path| {
        let names = std::fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|n| n.starts_with("interface-amplitude-")).collect();
        names.sort();
        names
    };
    let here = folder.join("here");
    let foreign = "interface-amplitude-of-mine.vtu";
    std::fs::write(here.join(foreign), "mine").unwrap();
    assert_eq!(fields(&here).len(), 5);
    scene["output"] = json!({ "fields_at": [2] });
    go(&scene);
    assert_eq!(fields(&here), ["interface-amplitude-02.vtu", foreign]);
    // Of a scene of another name, nothing is removed.
    scene["name"] = json!("another");
    scene["output"] = json!({ "fields_at": [3] });
    go(&scene);
    assert_eq!(
        fields(&here),
        ["interface-amplitude-02.vtu", "interface-amplitude-03.vtu", foreign]
    );
    let left: Vec<_> = std::fs::read_dir(&here)
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert!(left.iter().all(|n| !n.to_string_lossy().contains(".part")), "{left:?}");
}

#[test]
fn a_check_names_what_is_wrong() {
    let folder = folder("damaged");
    for entry in std::fs::read_dir(quick_results()).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
    }
    let mut summary = quick_summary();
    summary["model"]["mass"] = json!(3.6);
    summary["backbone"][6]["friction_damping_ratio"] = json!(0.9);
    std::fs::write(folder.join("summary.json"), summary.to_string()).unwrap();
    std::fs::write(
        folder.join("interface-prestress.vtu"),
        "<VTKFile>\n<Points>\n</VTKFile>",
    )
    .unwrap();
    std::fs::remove_file(folder.join("backbone.svg")).unwrap();
    let output = run(&folder, &["check-results", "."]);
    assert_eq!(exit_code(&output), 1);
    let text = messages(&output);
    for part in [
        "model.mass = 3.6",
        "damping does not rise from amplitude 7",
        "interface-prestress.vtu: line 3",
        "backbone.svg",
    ] {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
    assert!(text.contains("4 of "), "{text}");
}

#[test]
fn a_check_names_the_amplitudes_that_did_not_converge() {
    let folder = folder("too-far");
    let mut scene = read_json(Path::new(QUICK));
    scene["cqsma"] = json!({ "amplitudes": 2, "vertices_per_quarter": 1, "amplitude_to": 1e6 });
    std::fs::write(folder.join("too-far.json"), scene.to_string()).unwrap();
    let output = run(&folder, &["brb", "too-far.json"]);
    assert_eq!(exit_code(&output), 3, "{}", messages(&output));
    let output = run(&folder, &["check-results", "results/too-far"]);
    assert!(
        messages(&output).contains("amplitude 2 did not converge"),
        "{}",
        messages(&output)
    );
}

#[test]
fn a_check_without_results_is_an_error() {
    let folder = folder("no-results");
    let output = run(&folder, &["check-results", "nothing-here"]);
    assert_eq!(exit_code(&output), 1);
    assert!(messages(&output).contains("nothing-here"), "{}", messages(&output));
}

#[test]
fn the_layering_holds() {
    let output = run(&folder("layering"), &["check-layering"]);
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
}

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
