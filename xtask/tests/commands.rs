//! The tasks as scripts meet them: the built program, its exit codes, its messages and its files.
#![allow(clippy::unwrap_used)]
#[path = "../../crates/microslip/tests/all/common/mod.rs"]
mod common;

use common::{assert_same_numbers, exit_code, folder, messages, read_json, run, succeeds};
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
    // Of a scene of another name, nothing is removed, and nothing overwritten, unless that is asked for.
    scene["name"] = json!("another");
    scene["output"] = json!({ "fields_at": [3] });
    std::fs::write(folder.join("brb-quick.json"), scene.to_string()).unwrap();
    let arguments = ["brb", "brb-quick.json", "--out", "here"];
    let output = run(&folder, &arguments);
    assert_eq!(exit_code(&output), 1);
    assert!(messages(&output).contains("--overwrite"), "{}", messages(&output));
    assert_eq!(fields(&here), ["interface-amplitude-02.vtu", foreign]);
    let output = run(&folder, &[&arguments[..], &["--overwrite"]].concat());
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    assert_eq!(fields(&here), ["interface-amplitude-03.vtu", foreign]);
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
    scene["analyses"]["backbone"] = json!({ "amplitudes": 2, "vertices_per_quarter": 1, "amplitude_to": 1e6 });
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
fn an_accuracy_chooses_settings_and_an_error_is_estimated() {
    let folder = folder("accuracy");
    let mut scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "accuracy": "draft",
        "analyses": { "backbone": { "amplitudes": 3, "amplitude_from": 5e-5, "amplitude_to": 5e-4 } },
    });
    std::fs::write(folder.join("draft.json"), scene.to_string()).unwrap();
    let text = succeeds(&folder, &["brb", "draft.json", "--out", "run", "--estimate-error"]);
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
    assert!(
        text.contains("settings `draft`") && text.contains("against the settings `coarse`"),
        "{text}"
    );

    scene["accuracy"] = json!({ "damping": 1e-12 });
    std::fs::write(folder.join("impossible.json"), scene.to_string()).unwrap();
    let output = run(&folder, &["brb", "impossible.json"]);
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.contains("impossible.json") && message.contains("no measured mesh"),
        "{message}"
    );
}

#[test]
fn two_formulations_of_the_elements_estimate_the_limit_of_the_mesh() {
    /// The flat beam's first frequency in the limit of the mesh, as measured on finer meshes (Hz).
    const LIMIT: f64 = 166.30;
    let folder = folder("mesh-estimate");
    let mut scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "model": { "element_order": "linear", "refinement": "coarse", "symmetry": "half" },
        "interfaces": { "law": { "friction": "lumped" } },
        "analyses": { "backbone": { "amplitudes": 3, "amplitude_from": 5e-5, "amplitude_to": 5e-4 } },
    });
    std::fs::write(folder.join("coarse.json"), scene.to_string()).unwrap();
    let text = succeeds(
        &folder,
        &["brb", "coarse.json", "--out", "run", "--estimate-error", "mesh"],
    );
    let summary = read_json(&folder.join("run/summary.json"));
    let number = |pointer: &str| summary.pointer(pointer).and_then(Value::as_f64).unwrap();
    assert_eq!(
        (
            &summary["mesh_estimate"]["formulation"],
            &summary["mesh_estimate"]["other"]
        ),
        (&json!("incompatible-modes"), &json!("reduced"))
    );
    assert!(summary.get("error_estimate").is_none());
    let of = |place: &str, field: &str| number(&format!("/mesh_estimate/modes/0/{place}/{field}"));
    assert_eq!(number("/modes/0/frequency_hz"), of("linear_frequency", "own_hz"));
    for place in [
        "linear_frequency",
        "amplitudes/0/frequency",
        "amplitudes/1/frequency",
        "amplitudes/2/frequency",
    ] {
        let [stiff, soft, limit] = ["own_hz", "other_hz", "limit_hz"].map(|field| of(place, field));
        assert!(soft < limit && limit < stiff, "{place}: {soft} {limit} {stiff}");
        assert!((of(place, "relative_difference") - (stiff / soft - 1.0)).abs() < 1e-12);
        assert!(of(place, "uncertainty_hz") < 0.5 * (stiff - soft));
    }
    let (limit, uncertainty) = (
        of("linear_frequency", "limit_hz"),
        of("linear_frequency", "uncertainty_hz"),
    );
    assert!((limit - LIMIT).abs() < uncertainty, "{limit} +- {uncertainty}");
    // The error bar of the table covers the distance as well.
    let bar = number("/model/error_bar/frequency_relative");
    assert!(of("linear_frequency", "own_hz") / LIMIT - 1.0 < bar, "{bar}");
    let damping = of("amplitudes/1", "damping_ratio") / of("amplitudes/1", "other_damping_ratio");
    assert!((of("amplitudes/1", "damping_ln_difference") - damping.ln()).abs() < 1e-12);
    assert!(
        text.contains("error of the mesh:") && text.contains("incompatible modes and reduced integration"),
        "{text}"
    );
    let report = std::fs::read_to_string(folder.join("run/report.html")).unwrap();
    for part in [
        "Error of the mesh",
        "Limit of the mesh",
        "Two formulations on the same mesh",
    ] {
        assert!(report.contains(part), "{part}");
    }
    assert!(succeeds(&folder, &["verify", "run", "--rerun"]).contains("the same when they are computed again"));

    // The weight is not known of full integration: the two frequencies alone.
    scene["model"] =
        json!({ "element_order": "linear", "refinement": "quick", "symmetry": "half", "formulation": "full" });
    std::fs::write(folder.join("full.json"), scene.to_string()).unwrap();
    let text = succeeds(
        &folder,
        &["brb", "full.json", "--out", "full", "--estimate-error", "mesh"],
    );
    let summary = read_json(&folder.join("full/summary.json"));
    // Nor is the error in the table, so that it is estimated.
    let bar = &summary["model"]["error_bar"];
    assert!(bar["frequency_relative"].as_f64().unwrap() > 0.0);
    assert!(bar["source"].as_str().unwrap().starts_with("estimated"), "{bar}");
    assert!(summary["mesh_estimate"]["weight"].is_null());
    assert!(summary["mesh_estimate"]["modes"][0]["linear_frequency"]["limit_hz"].is_null());
    assert!(text.contains("not calibrated"), "{text}");
}

/// Cargo, as the program calls it for tasks of other programs: it gets the same arguments, its exit code is returned.
#[cfg(unix)]
#[test]
fn studies_and_the_layering_are_handed_over() {
    use std::os::unix::fs::PermissionsExt;
    use std::process::Command;
    let folder = folder("handed-over");
    let cargo = folder.join("cargo");
    std::fs::write(&cargo, "#!/bin/sh\nprintf '%s\\n' \"$@\"\nexit 3\n").unwrap();
    std::fs::set_permissions(&cargo, std::fs::Permissions::from_mode(0o755)).unwrap();
    let call = |cargo: &Path, arguments: &[&str]| {
        let mut command = Command::new(PROGRAM);
        command
            .args(arguments)
            .current_dir(&folder)
            .env("CARGO", cargo)
            .output()
            .unwrap()
    };
    for (arguments, profile) in [
        (&["paper", "--only", "table3", "--out", "a folder"][..], "release"),
        (&["trade", "a scene.json", "--quick"], "release"),
        (&["bench", "--periodic"], "bench"),
        (&["extremes", "--only", "mu-0"], "release"),
        (&["check-layering"], "release"),
    ] {
        let output = call(&cargo, arguments);
        assert_eq!(exit_code(&output), 3, "{}", messages(&output));
        let text = String::from_utf8(output.stdout).unwrap();
        let (before, after) = text.split_once("--\n").unwrap();
        assert!(
            before.starts_with(&format!("run\n--profile\n{profile}\n")) && before.contains("validation\n"),
            "{text}"
        );
        assert_eq!(after.lines().collect::<Vec<_>>(), arguments);
    }
    // Wrong arguments are refused before anything is built.
    let output = call(&cargo, &["paper", "--onyl", "table3"]);
    assert_eq!((exit_code(&output), output.stdout.len()), (2, 0));
    let output = call(&folder.join("missing"), &["bench"]);
    assert_eq!(exit_code(&output), 1);
    assert!(messages(&output).contains("error: running"), "{}", messages(&output));
}
