//! Folders of results: written by one command at a time, replaced as a set, and checked to the last byte.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{copy, exit_code, folder, messages, read_json, run, succeeds};
use file_io::durable::{Folder, MANIFEST, Manifest, sha256};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

const QUICK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scenes/brb-quick.json");

/// Two amplitudes on the coarse mesh, run once; the folder that it ran in, with its cache.
fn finished() -> &'static Path {
    static RUN: OnceLock<PathBuf> = OnceLock::new();
    RUN.get_or_init(|| {
        let folder = folder("results");
        scene(&folder, "few", &json!({ "amplitudes": 2, "vertices_per_quarter": 2 }));
        succeeds(&folder, &["run", "few.json", "--out", "out", "--cache", "kept"]);
        folder
    })
}

/// A scene on the coarse mesh in the file `name.json`.
fn scene(folder: &Path, name: &str, backbone: &Value) {
    let mut scene = read_json(Path::new(QUICK));
    scene["name"] = json!(name);
    scene["analyses"]["backbone"] = backbone.clone();
    std::fs::write(folder.join(format!("{name}.json")), scene.to_string()).unwrap();
}

/// A folder of a test's own with a copy of the finished run, its scene and its cache.
fn copied(name: &str) -> PathBuf {
    let folder = folder(name);
    for part in ["out", "kept"] {
        copy(&finished().join(part), &folder.join(part));
    }
    std::fs::copy(finished().join("few.json"), folder.join("few.json")).unwrap();
    folder
}

/// A refused command, whose message holds all these parts.
fn refused(folder: &Path, arguments: &[&str], parts: &[&str]) {
    let output = run(folder, arguments);
    assert_eq!(exit_code(&output), 1, "{arguments:?}: {}", messages(&output));
    let text = messages(&output);
    for part in parts {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn every_changed_byte_is_noticed_and_its_file_named() {
    let folder = copied("changed");
    let text = succeeds(&folder, &["verify", "out"]);
    assert!(
        text.contains("files as they were written") && text.contains("checks of the results passed"),
        "{text}"
    );
    let all = names(&folder.join("out"));
    for name in &all {
        let path = folder.join("out").join(name);
        let intact = std::fs::read(&path).unwrap();
        for place in [0, intact.len() / 2, intact.len() - 1] {
            let mut damaged = intact.clone();
            damaged[place] ^= 1;
            std::fs::write(&path, damaged).unwrap();
            refused(&folder, &["verify", "out"], &[name]);
        }
        std::fs::write(&path, &intact[..intact.len() - 1]).unwrap();
        refused(&folder, &["verify", "out"], &[name]);
        std::fs::remove_file(&path).unwrap();
        refused(&folder, &["verify", "out"], &[name]);
        std::fs::write(&path, intact).unwrap();
    }
    assert!(all.len() >= 7, "{all:?}");
    // What a run could have written is not of this one; other files may stand beside it.
    std::fs::write(folder.join("out/notes.txt"), "mine").unwrap();
    succeeds(&folder, &["verify", "out"]);
    std::fs::write(folder.join("out/mode-3-backbone.csv"), "").unwrap();
    refused(
        &folder,
        &["verify", "out"],
        &["mode-3-backbone.csv", "not of these results"],
    );
    refused(&folder, &["verify", "nowhere"], &["nowhere", MANIFEST]);
}

/// A number that a manifest vouches for and that is out of bounds, or another than the program computes.
#[test]
fn a_wrong_number_is_noticed_whoever_vouches_for_it() {
    let folder = copied("wrong");
    let out = folder.join("out");
    let text = succeeds(&folder, &["verify", "out", "--rerun"]);
    assert!(
        text.contains("numbers are the same") && text.contains("bit by bit"),
        "{text}"
    );
    let republish = |change: &dyn Fn(&mut Value)| {
        let manifest = Manifest::read(&out).unwrap();
        let mut files: Vec<(&str, Vec<u8>)> = (manifest.files.keys())
            .map(|name| (name.as_str(), std::fs::read(out.join(name)).unwrap()))
            .collect();
        let summary = files.iter_mut().find(|(name, _)| *name == "summary.json").unwrap();
        let mut value: Value = serde_json::from_slice(&summary.1).unwrap();
        change(&mut value);
        summary.1 = serde_json::to_vec_pretty(&value).unwrap();
        let files: Vec<(&str, &[u8])> = files.iter().map(|(name, of)| (*name, &of[..])).collect();
        Folder::open(&out, &manifest.identity, false)
            .unwrap()
            .publish(&files)
            .unwrap();
    };
    republish(&|summary| summary["model"]["mass"] = json!(2.7));
    refused(&folder, &["verify", "out"], &["model.mass = 2.7"]);
    republish(&|summary| summary["model"]["mass"] = json!(3.7));
    succeeds(&folder, &["verify", "out"]);
    refused(
        &folder,
        &["verify", "out", "--rerun"],
        &["/model/mass: 3.7 then", "bit by bit"],
    );
    // Of another processor the last digits may differ, and no more.
    republish(&|summary| summary["provenance"]["arithmetic"] = json!("another"));
    refused(
        &folder,
        &["verify", "out", "--rerun"],
        &["/model/mass: 3.7 then", "within 1e-6"],
    );
}

#[test]
fn a_summary_says_where_it_comes_from() {
    let summary = read_json(&finished().join("out/summary.json"));
    let provenance = &summary["provenance"];
    let program = &provenance["program"];
    assert_eq!(
        (&program["name"], &program["version"]),
        (&json!("microslip"), &json!(env!("CARGO_PKG_VERSION")))
    );
    let commit = program["commit"].as_str();
    assert!(
        commit.is_none_or(|c| c.len() >= 40 && c[..40].bytes().all(|b| b.is_ascii_hexdigit())),
        "{commit:?}"
    );
    let command: Vec<&str> = provenance["command_line"]
        .as_array()
        .unwrap()
        .iter()
        .map(|a| a.as_str().unwrap())
        .collect();
    assert_eq!(command[1..], ["run", "few.json", "--out", "out", "--cache", "kept"]);
    assert!(provenance["threads"].as_u64().unwrap() > 0);
    assert!(provenance["instruction_set"].is_string() && provenance["arithmetic"].is_string());
    let scene = std::fs::read(finished().join("few.json")).unwrap();
    let input = json!({ "role": "scene", "path": "few.json", "bytes": scene.len(), "sha256": sha256(&scene) });
    assert_eq!(provenance["inputs"], json!([input]));
    assert!(provenance["date"].as_str().unwrap().ends_with('Z'));

    let folder = copied("dated");
    let dated = |seconds: &str| {
        let mut command = Command::new(crate::PROGRAM);
        command
            .args(["model", "few.json", "--out", "model"])
            .env("SOURCE_DATE_EPOCH", seconds);
        command.current_dir(&folder).output().unwrap()
    };
    assert_eq!(exit_code(&dated("951782400")), 0);
    let date = &read_json(&folder.join("model/summary.json"))["provenance"]["date"];
    assert_eq!(*date, "2000-02-29T00:00:00Z");
    let output = dated("today");
    assert_eq!(exit_code(&output), 1);
    assert!(
        messages(&output).contains("SOURCE_DATE_EPOCH = `today`"),
        "{}",
        messages(&output)
    );
}

#[test]
fn results_of_something_else_are_not_overwritten_unasked() {
    let folder = copied("unasked");
    let before = std::fs::read(folder.join("out/summary.json")).unwrap();
    // The same name, changed: replaced as ever.
    scene(&folder, "few", &json!({ "amplitudes": 1, "vertices_per_quarter": 2 }));
    let again = ["run", "few.json", "--out", "out", "--cache", "kept"];
    succeeds(&folder, &again);
    let after = std::fs::read(folder.join("out/summary.json")).unwrap();
    assert_ne!(before, after);
    assert!(!folder.join("out/interface-amplitude-02.vtu").exists());
    succeeds(&folder, &["verify", "out"]);
    // Another scene, another command.
    scene(&folder, "other", &json!({ "amplitudes": 1, "vertices_per_quarter": 2 }));
    let other = ["run", "other.json", "--out", "out", "--cache", "kept"];
    refused(
        &folder,
        &other,
        &[
            "`run` of few on brake-reuss-beam",
            "`run` of other",
            "--out",
            "--overwrite",
        ],
    );
    refused(
        &folder,
        &["model", "few.json", "--out", "out"],
        &["`run` of few", "`model` of few", "--overwrite"],
    );
    assert_eq!(std::fs::read(folder.join("out/summary.json")).unwrap(), after);
    succeeds(&folder, &["verify", "out"]);
    succeeds(&folder, &[&other[..], &["--overwrite"]].concat());
    assert!(succeeds(&folder, &["verify", "out"]).contains("`run` of other"));
    // A file of nobody's.
    std::fs::create_dir(folder.join("mine")).unwrap();
    std::fs::write(folder.join("mine/backbone.csv"), "mine").unwrap();
    let mine = ["run", "few.json", "--out", "mine", "--cache", "kept"];
    refused(&folder, &mine, &["mine/backbone.csv", "no manifest", "--overwrite"]);
    assert_eq!(names(&folder.join("mine")), ["backbone.csv"]);
}

/// Starts a run of many amplitudes, and waits until some of them are finished.
fn slow(folder: &Path, out: &str) -> Child {
    scene(folder, "slow", &json!({ "amplitudes": 60, "vertices_per_quarter": 12 }));
    let child = Command::new(crate::PROGRAM)
        .args(["run", "slow.json", "--out", out, "--cache", "kept", "--threads", "1"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    while finished_loops(folder) < 3 {
        assert!(began.elapsed() < Duration::from_secs(120), "the run does not get on");
        std::thread::sleep(Duration::from_millis(5));
    }
    child
}

/// Lines in the checkpoint of loops.
fn finished_loops(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder.join("kept"))
        .unwrap()
        .map(|e| e.unwrap().path());
    let loops = entries.filter(|path| path.extension().is_some_and(|e| e == "jsonl"));
    loops
        .map(|path| std::fs::read_to_string(path).unwrap().lines().count())
        .sum()
}

#[test]
fn one_command_at_a_time_writes_into_a_folder_and_a_killed_one_leaves_it_free() {
    let folder = copied("held");
    let mut first = slow(&folder, "out2");
    let second = ["run", "few.json", "--out", "out2", "--cache", "kept"];
    refused(
        &folder,
        &second,
        &["out2", "`run` of slow", &format!("process {} on ", first.id())],
    );
    refused(&folder, &[&second[..], &["--overwrite"]].concat(), &["in use by"]);
    first.kill().unwrap();
    first.wait().unwrap();
    // Nothing of it is in the way, also where it had begun to write.
    let staged = folder.join("out2/.microslip-abcdefabcdef.part");
    std::fs::create_dir(&staged).unwrap();
    std::fs::write(staged.join("summary.json"), "half").unwrap();
    succeeds(&folder, &second);
    succeeds(&folder, &["verify", "out2"]);
    assert!(names(&folder.join("out2")).iter().all(|name| !name.starts_with('.')));
}

#[test]
fn finished_amplitudes_are_kept_until_the_results_are_in_place() {
    let folder = copied("kept-loops");
    let mut child = slow(&folder, "out3");
    // A folder in the way of a file: all is computed, nothing can be written.
    std::fs::create_dir(folder.join("out3/report.html")).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1));
    assert_eq!(finished_loops(&folder), 60);
    assert_eq!(names(&folder.join("out3")), ["report.html"]);
    std::fs::remove_dir(folder.join("out3/report.html")).unwrap();
    let output = run(&folder, &["run", "slow.json", "--out", "out3", "--cache", "kept"]);
    assert_eq!(exit_code(&output), 0, "{}", messages(&output));
    assert!(
        messages(&output).contains("60 of 60 amplitudes were taken"),
        "{}",
        messages(&output)
    );
    assert_eq!(finished_loops(&folder), 0);
    succeeds(&folder, &["verify", "out3"]);
}

/// Runs with the numbers of the same process, as in containers, and different scenes in one folder.
#[test]
fn of_many_runs_into_one_folder_one_is_whole() {
    let folder = copied("many");
    let backbone = json!({ "amplitudes": 1, "vertices_per_quarter": 2 });
    let children: Vec<Child> = (0..4)
        .map(|k| {
            let name = format!("scene-{k}");
            scene(&folder, &name, &backbone);
            let mut command = Command::new(crate::PROGRAM);
            command.args([
                "run",
                &format!("{name}.json"),
                "--out",
                "shared",
                "--cache",
                "kept",
                "--overwrite",
            ]);
            command
                .current_dir(&folder)
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap()
        })
        .collect();
    let codes: Vec<i32> = children
        .into_iter()
        .map(|mut c| c.wait().unwrap().code().unwrap())
        .collect();
    assert!(codes.contains(&0), "{codes:?}");
    succeeds(&folder, &["verify", "shared"]);
    let name = read_json(&folder.join("shared/summary.json"))["scene"]["name"].clone();
    let manifest = Manifest::read(&folder.join("shared")).unwrap();
    assert_eq!(
        manifest.identity.subject,
        format!("{} on brake-reuss-beam", name.as_str().unwrap())
    );
}

#[test]
fn a_run_is_repeated_on_the_inputs_it_was_made_from() {
    let folder = folder("inputs");
    let quick = succeeds(
        &folder,
        &["export", QUICK, "--format", "inp", "--out", "deck", "--no-cache"],
    );
    assert!(quick.contains("structure.inp"), "{quick}");
    // Half of the deck in another file.
    let deck = std::fs::read_to_string(folder.join("deck/structure.inp")).unwrap();
    let cut = deck.find("*ELEMENT").or_else(|| deck.find("*Element")).unwrap();
    std::fs::create_dir(folder.join("own")).unwrap();
    std::fs::write(folder.join("own/nodes.inp"), &deck[..cut]).unwrap();
    std::fs::write(
        folder.join("own/structure.inp"),
        format!("*INCLUDE, INPUT=nodes.inp\n{}", &deck[cut..]),
    )
    .unwrap();
    let mut scene = read_json(&folder.join("deck/structure.json"));
    scene["analyses"]["backbone"]["amplitudes"] = json!(1);
    scene["output"] = json!({});
    std::fs::write(folder.join("own/scene.json"), scene.to_string()).unwrap();
    succeeds(&folder, &["run", "own/scene.json", "--out", "out", "--no-cache"]);
    let summary = read_json(&folder.join("out/summary.json"));
    let inputs = summary["provenance"]["inputs"].as_array().unwrap();
    let roles: Vec<&str> = inputs.iter().map(|input| input["role"].as_str().unwrap()).collect();
    assert_eq!(roles, ["scene", "deck", "deck-include"]);
    let nodes = std::fs::read(folder.join("own/nodes.inp")).unwrap();
    assert_eq!(inputs[2]["sha256"], sha256(&nodes));
    // From another folder as well.
    succeeds(&folder.join("own"), &["verify", "../out", "--rerun"]);
    std::fs::write(folder.join("own/nodes.inp"), [&nodes[..], b"** a comment\n"].concat()).unwrap();
    succeeds(&folder, &["verify", "out"]);
    refused(
        &folder,
        &["verify", "out", "--rerun"],
        &["nodes.inp", "is not the file that the results were computed from"],
    );
}

/// The range of a loop counts both of its ends; the halves count the last one. Where they differ, the frequency lies beside those of the halves.
#[test]
fn loops_that_close_within_their_tolerance_pass_and_others_do_not() {
    let folder = folder("open-loops");
    succeeds(&folder, &["samples", "samples"]);
    let text = std::fs::read_to_string(folder.join("samples/joint-mesh.json")).unwrap();
    let mut scene = scenes::parse_json(&text).unwrap();
    scene["analyses"]["backbone"] = json!({
        "amplitudes": 1, "amplitude_from": "50 um", "vertices_per_quarter": 2, "commit": "at-reversals",
    });
    scene["interfaces"]["law"] = json!({ "friction": "lumped" });
    scene["interfaces"]["points_per_direction"] = json!(2);
    scene["output"] = json!({ "deformed": true });
    std::fs::write(folder.join("samples/open.json"), scene.to_string()).unwrap();
    succeeds(&folder, &["run", "samples/open.json", "--out", "out", "--no-cache"]);
    // The mesh is the file's own, so that its error is estimated.
    for (file, has_error) in [("bodies-prestress.vtu", true), ("bodies-amplitude-01.vtu", false)] {
        let text = std::fs::read_to_string(folder.join("out").join(file)).unwrap();
        assert_eq!(text.contains(r#"Name="share of mesh error [-]""#), has_error, "{file}");
    }
    let point = &read_json(&folder.join("out/summary.json"))["backbone"][0];
    let frequency = point["frequency_hz"].as_f64().unwrap();
    let halves = [0, 1].map(|half| point["half_frequencies_hz"][half].as_f64().unwrap());
    assert!(halves.iter().all(|half| frequency < *half), "{frequency} {halves:?}");
    succeeds(&folder, &["verify", "out"]);
    // A frequency that is wrong by more than the distance of the ends.
    let (mut summary, scene) = microslip::check::read(&folder.join("out")).unwrap();
    assert_eq!(microslip::check::defects(&scene, &summary), Vec::<String>::new());
    summary.backbone[0].frequency_hz = Some(0.99 * frequency);
    let defects = microslip::check::defects(&scene, &summary);
    assert!(defects.len() == 1 && defects[0].contains("halves"), "{defects:?}");
}
