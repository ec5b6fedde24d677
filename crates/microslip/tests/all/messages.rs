//! Messages of commands that fail: one line that names the file or field, says each thing once, and what to do.
#![allow(clippy::unwrap_used)]

use crate::common::page::{data_of, scripts_of};
use crate::common::{exit_code, folder, messages, read_json, run, succeeds};
use serde_json::{Value, json};
use std::path::Path;

const QUICK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scenes/brb-quick.json");
/// Two bars of three bricks each.
const DECK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../analyses/tests/fixtures/bricks.inp");

/// What a command prints that must fail, in one readable piece.
fn fails(folder: &Path, arguments: &[&str], expected: &[&str]) -> String {
    let output = run(folder, arguments);
    let text = messages(&output);
    assert!(matches!(exit_code(&output), 1 | 2), "{arguments:?}: {text}");
    let start = text.rfind("error: ").unwrap_or_else(|| panic!("{arguments:?}: {text}"));
    let message = text[start + "error: ".len()..].trim_end();
    // Usage of arguments is laid out in lines.
    if exit_code(&output) == 1 {
        assert!(!message.contains("  "), "two blanks: {message}");
        assert!(
            message.chars().count() < 2500,
            "{} characters: {message:.200}",
            message.len()
        );
        let clauses: Vec<&str> = message.split(": ").filter(|clause| clause.len() > 8).collect();
        for (index, clause) in clauses.iter().enumerate() {
            assert!(!clauses[..index].contains(clause), "twice `{clause}`: {message}");
        }
        assert_eq!(message.matches("os error").count().max(1), 1, "{message}");
    }
    assert!(!text.contains("panicked"), "{text}");
    let is_shown = |c: char| c == '\n' || !c.is_control();
    assert!(text.chars().all(is_shown), "control characters: {text:?}");
    for part in expected {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
    message.to_owned()
}

/// A scene on the two bars, read as a mesh.
fn on_mesh() -> Value {
    json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "mesh": {
            "path": "bars.inp",
            "interfaces": [{ "top": "TOP", "bottom": "BOTTOM" }],
            "bolts": [{ "head": "UP", "nut": "UNDER" }],
            "response": { "node": "TIP", "direction": [0, 0, 1] },
        } },
        "model": { "material": { "youngs_modulus": "200 GPa", "poisson_ratio": 0.3, "density": "7800 kg/m^3" } },
        "interfaces": {
            "surface": { "parameters": { "per": "interface", "sets": [{ "curves": { "elastic": {
                "normal_stiffness": 4e13, "tangential_stiffness": [3e13, 3e13] } } }] } },
            "mu": 0.15,
            "gap": "flat",
        },
        "bolts": { "load": "1 kN" },
        "analyses": {
            "backbone": { "amplitudes": 2, "amplitude_from": 1e-9, "amplitude_to": 1e-8, "vertices_per_quarter": 4 },
        },
    })
}

/// The bars without what only decks have.
fn bars() -> String {
    let deck = std::fs::read_to_string(DECK).unwrap();
    let (mesh, _) = deck.split_once("*SURFACE, NAME=DOWN").unwrap();
    let nodes = mesh
        .lines()
        .filter(|line| !line.starts_with("101, ") && !line.starts_with("102, "));
    let mesh: Vec<&str> = nodes.collect();
    let mesh = mesh.join("\n");
    let mesh = mesh
        .replace("*NSET, NSET=HEAD\n101\n", "")
        .replace("*NSET, NSET=NUT\n102\n", "");
    format!("{mesh}\n*SURFACE, NAME=UNDER\nLOWER, S1\n")
}

fn with(mut scene: Value, pointer: &str, value: Value) -> Value {
    let (parent, name) = pointer.rsplit_once('/').unwrap();
    scene.pointer_mut(parent).unwrap()[name] = value;
    scene
}

#[test]
fn files_that_cannot_be_read_are_named_once_with_a_remedy() {
    let folder = folder("messages-files");
    std::fs::create_dir(folder.join("dir")).unwrap();
    std::fs::create_dir(folder.join("results")).unwrap();
    std::fs::write(folder.join("empty"), "").unwrap();
    std::fs::write(folder.join("bytes"), [0xff_u8, 0xfe, 0, 7, 27, 91, 50, 74].repeat(200)).unwrap();
    std::fs::write(folder.join("results/summary.json"), "").unwrap();
    std::fs::write(folder.join("bars.inp"), bars()).unwrap();
    std::fs::write(folder.join("scene.json"), on_mesh().to_string()).unwrap();
    for (name, remedy) in [
        ("nowhere", "check the path"),
        ("dir", "copy its contents"),
        ("empty", ""),
        ("bytes", ""),
    ] {
        for arguments in [
            &["run", name, "--out", "out"][..],
            &["model", name],
            &["export", name, "--format", "npz", "--out", "out"],
            &["characterise", "--scene", name, "--out", "out"],
            &["characterise", name, name, "--scene", "scene.json", "--out", "out"],
            &["identify", name, "--out", "out"],
        ] {
            // Folders hold results for commands that compare.
            let message = fails(&folder, arguments, &[name]);
            assert!(message.contains(remedy) || arguments[0] == "identify", "{message}");
        }
        fails(&folder, &["compare", name, name, "--out", "out"], &[name]);
        fails(&folder, &["verify", name], &[name]);
        // A mesh of each kind.
        for extension in ["inp", "msh", "vtu", "stl"] {
            let mesh = format!("{name}.{extension}");
            if name != "nowhere" {
                let _ = std::fs::remove_file(folder.join(&mesh));
                match name {
                    "dir" => std::fs::create_dir(folder.join(&mesh)).unwrap(),
                    _ => drop(std::fs::copy(folder.join(name), folder.join(&mesh)).unwrap()),
                }
            }
            let scene = with(on_mesh(), "/structure/mesh/path", json!(mesh));
            std::fs::write(folder.join("broken.json"), scene.to_string()).unwrap();
            let message = fails(&folder, &["model", "broken.json"], &[&mesh]);
            assert!(!message.contains("line 0"), "{message}");
            fails(&folder, &["run", "broken.json"], &[&mesh]);
        }
    }
    let message = fails(&folder, &["run", "empty"], &["the file is empty"]);
    assert!(!message.contains("EOF"), "{message}");
}

#[test]
fn wrong_values_name_their_field_and_what_is_expected() {
    let folder = folder("messages-values");
    std::fs::write(folder.join("bars.inp"), bars()).unwrap();
    let refuse = |text: String, parts: &[&str]| {
        std::fs::write(folder.join("scene.json"), text).unwrap();
        fails(
            &folder,
            &["model", "scene.json", "--overwrite"],
            &[&["scene"], parts].concat(),
        );
    };
    let mesh = |pointer: &str, value: Value| with(on_mesh(), pointer, value).to_string();
    // The scene itself is sound.
    std::fs::write(folder.join("scene.json"), on_mesh().to_string()).unwrap();
    succeeds(&folder, &["model", "scene.json"]);
    let number = "a whole number that is not negative";
    refuse(
        mesh("/analyses/backbone/amplitudes", json!("many")),
        &["analyses.backbone.amplitudes", "\"many\"", number],
    );
    refuse(
        mesh("/analyses/backbone/amplitudes", json!(-2)),
        &["analyses.backbone.amplitudes", "-2", number],
    );
    refuse(
        mesh("/interfaces/mu", json!("0.2")),
        &["interfaces.mu: ", "\"0.2\"", "a number"],
    );
    refuse(
        mesh("/interfaces/mu", json!(0.25)).replace("0.25", "NaN"),
        &["line 1 column", "`NaN", "finite"],
    );
    refuse(
        mesh("/interfaces/mu", json!(0.25)).replace("0.25", "1e999"),
        &["line 1 column", "finite"],
    );
    refuse(
        mesh("/units/length", json!(3)),
        &["units.length", "`3`", "a text in quotes"],
    );
    refuse(mesh("/units", json!("SI")), &["units: ", "\"SI\"", "an object"]);
    refuse(mesh("/structure", json!(3)), &["structure", "`3`", "an object"]);
    refuse(
        mesh("/model/material/poisson_ratio", json!(0.7)),
        &["poisson_ratio = 0.7 is not"],
    );
    refuse(
        mesh("/bolts/load", json!(format!("8 {}", "x".repeat(100_000)))),
        &["bolts.load", "kN"],
    );
    refuse(
        mesh("/bolts/load", json!("8 \u{1b}[31m\u{7}")),
        &["bolts.load", "\\u{1b}", "kN"],
    );
    let named = json!({ "top": "TOP", "bottom": "BOTTOM" });
    let interface = |field: &str, value: Value| {
        let mut interface = named.clone();
        interface[field] = value;
        mesh("/structure/mesh/interfaces", json!([named, interface]))
    };
    let own = |mu: Value| {
        let scene = with(on_mesh(), "/structure/mesh/interfaces", json!([named, named]));
        with(scene, "/interfaces/each", json!([{}, { "mu": mu }])).to_string()
    };
    refuse(
        own(json!(-1)),
        &["interfaces.each, number 2: interfaces.mu = -1 is not"],
    );
    refuse(own(json!([])), &["interfaces.each[1].mu", "a number"]);
    refuse(
        interface("within", json!("1 kN")),
        &["structure.mesh.interfaces[1].within", "`1 kN`", "mm"],
    );
    refuse(
        interface("along", json!([0, 0, 0])),
        &["structure.mesh.interfaces, number 2: along = 0"],
    );
    refuse(
        interface("top", json!("T\u{1b}[2J")),
        &["bars.inp", "T\\u{1b}[2J", "TOP"],
    );
    refuse(
        interface("top", json!("T".repeat(100_000))),
        &["bars.inp", "100003 characters", "UP"],
    );
    // An interface twice, or where nothing can move.
    refuse(
        mesh("/structure/mesh/interfaces", json!([named, named])),
        &["interface", "remove"],
    );
    refuse(
        mesh("/structure/mesh/supports", json!([{ "surface": "BOTTOM" }])),
        &["interface", "support"],
    );
    refuse(
        mesh(
            "/structure/mesh/supports",
            json!([{ "surface": "UNDER", "components": [false, false, false] }]),
        ),
        &["structure.mesh.supports, number 1: components", "at least one"],
    );
    refuse(
        mesh(
            "/structure/mesh/interfaces",
            json!([{ "top": "UP", "bottom": "UNDER" }]),
        ),
        &[
            "structure.mesh.interfaces, number 1",
            "which faces are named, and the distance that is allowed",
        ],
    );
    let material = |fields: Value| mesh("/structure/mesh/materials", json!({ "UPPER": fields }));
    refuse(
        material(json!({ "youngs_modulus": 1e9, "poisson_ratio": 0.3 })),
        &["structure.mesh.materials.UPPER", "missing field `density`", "kg/m^3"],
    );
    refuse(
        material(json!({ "youngs_modulus": -1e9, "poisson_ratio": 0.3, "density": 1 })),
        &["structure.mesh.materials.UPPER: youngs_modulus = -1000000000 Pa"],
    );
    let response = |nearest: [f64; 3]| {
        mesh(
            "/structure/mesh/response",
            json!({ "nearest": nearest, "direction": [0, 0, 1] }),
        )
    };
    refuse(response([1e300, 0.0, 0.0]), &["structure.mesh.response.nearest"]);
    refuse(
        response([160.0, 0.0, 10.0]),
        &["structure.mesh.response.nearest", "check its unit"],
    );
}

#[test]
fn summaries_and_meshes_of_interfaces_name_the_field_that_is_wrong() {
    let folder = folder("messages-json");
    std::fs::create_dir(folder.join("run")).unwrap();
    std::fs::write(
        folder.join("backbone.csv"),
        "amplitude [m],frequency_hz,damping_ratio\n1e-6,170,0.001\n",
    )
    .unwrap();
    for (text, parts) in [
        ("", &["the file is empty"][..]),
        ("{ \"backbone\": [", &["ends too early"]),
        (
            "{ \"backbone\": [{ \"frequency_hz\": \"x\" }] }",
            &["backbone[0].frequency_hz", "\"x\"", "a number", "line 1"],
        ),
        (
            "{ \"backbone\": [{ \"frequency_hz\": NaN }] }",
            &["`NaN", "line 1 column"],
        ),
        ("{}", &["missing field `backbone`"]),
        ("3", &["an object"]),
    ] {
        std::fs::write(folder.join("run/summary.json"), text).unwrap();
        let parts = [
            &["run/summary.json is not the summary of a run", "microslip run"],
            parts,
        ]
        .concat();
        fails(&folder, &["compare", "run", "backbone.csv", "--out", "out"], &parts);
    }
    for (text, parts) in [
        (
            "{\"nodes\": [[0, 0], [1, \"x\"]], \"elements\": []}",
            &["nodes[1][1]", "\"x\"", "a number"][..],
        ),
        ("{\"nodes\": [[0, 0]], \"elements\": [[1, 2, -3, 4]]}", &["elements[0]"]),
        ("", &["empty"]),
    ] {
        std::fs::write(folder.join("mesh.json"), text).unwrap();
        let benchmark = [
            "characterise",
            "a",
            "b",
            "--benchmark",
            "brake-reuss-beam",
            "--mesh",
            "mesh.json",
            "--out",
            "out",
        ];
        fails(&folder, &benchmark, &[&["mesh.json"], parts].concat());
    }
}

#[test]
fn garbage_is_quoted_shortened_and_escaped() {
    let folder = folder("messages-garbage");
    let identify = |name: &str, contents: &[u8], parts: &[&str]| {
        std::fs::write(folder.join(name), contents).unwrap();
        fails(&folder, &["identify", name, "--out", "out"], &[&[name], parts].concat());
    };
    let binary: Vec<u8> = (0..5000_u32).map(|i| (i * i % 251) as u8).collect();
    identify("binary.csv", &binary, &["byte 0", "no text", "universal file"]);
    identify(
        "words.csv",
        b"hello world\nthis is no record, at all\n",
        &[
            "2 cells in `this is no record,at all`",
            "1 cell between commas",
            "`hello world`",
            "MATLAB",
        ],
    );
    identify("line.csv", "a".repeat(3_000_000).as_bytes(), &["16 are needed"]);
    let names: Vec<String> = (0..800).map(|i| format!("n{i}")).collect();
    let rows: String = (0..40).map(|i| vec![i.to_string(); 800].join(",") + "\n").collect();
    identify(
        "names.csv",
        format!("{}\n{rows}", names.join(",")).as_bytes(),
        &["`n19`, and 780 more"],
    );
    fails(
        &folder,
        &[
            "identify",
            "names.csv",
            "--channel",
            "n3",
            "--unit",
            "m/s^2",
            "--sample-rate",
            "-1",
            "--out",
            "out",
        ],
        &["sample rate", "-1 Hz", "positive"],
    );
    // Decks, and meshes in their format.
    for (name, text) in [
        ("control.inp", "*NODE\n1, \u{1b}[31m0, 0, 0\n".to_owned()),
        ("long.inp", format!("*NODE\n1, {}\n", "z".repeat(3_000_000))),
        ("keyword.inp", format!("*{}\n1\n", "K".repeat(2_000_000))),
        ("before.inp", format!("\u{7}\u{1b}[2J{}\n", "z ".repeat(2_000_000))),
        ("control.msh", "\u{1b}[31m$MeshFormat\n".to_owned()),
        ("control.vtu", "<VTKFile><\u{1b}[31m a=\"\u{7}\">".to_owned()),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
        let scene = with(on_mesh(), "/structure/mesh/path", json!(name));
        std::fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
        fails(&folder, &["model", "scene.json"], &[name]);
        if name.ends_with("inp") {
            let scene = with(
                scene,
                "/structure",
                json!({ "deck": {
                    "path": name, "top": "TOP", "bottom": "BOTTOM", "along": [1, 0, 0],
                    "bolts": [{ "head": "HEAD", "nut": "NUT" }],
                    "response": { "node": "TIP", "direction": [0, 0, 1] },
                } }),
            );
            std::fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
            fails(&folder, &["model", "scene.json"], &[]);
        }
    }
}

#[test]
fn a_run_says_what_its_accuracy_takes_and_counts_all_its_time() {
    let folder = folder("messages-accuracy");
    let mut scene = read_json(Path::new(QUICK));
    scene["name"] = json!("drafted");
    scene["accuracy"] = json!("draft");
    scene["analyses"]["backbone"] = json!({ "amplitudes": 3, "amplitude_from": 1e-6 });
    std::fs::write(folder.join("drafted.json"), scene.to_string()).unwrap();
    let began = std::time::Instant::now();
    let output = run(
        &folder,
        &["run", "drafted.json", "--no-cache", "--estimate-error", "mesh"],
    );
    let wall = began.elapsed().as_secs_f64();
    let told = messages(&output);
    assert_eq!(exit_code(&output), 0, "{told}");
    let expected =
        "settings `draft`: expect about 2 s where nothing is in the cache, as measured on the flat Brake-Reuss beam";
    let at = told.find(expected).unwrap_or_else(|| panic!("{told}"));
    assert!(at < told.find("mesh ...").unwrap(), "{told}");
    assert!(
        told.contains("this scene has 3 loops") && told.contains("as long as the first run"),
        "{told}"
    );
    let summary = read_json(&folder.join("results/drafted/summary.json"));
    let seconds = |name: &str| summary["timings"][name].as_f64().unwrap();
    // Starting the program and writing the results take the rest.
    assert!(
        seconds("error_estimate") > 0.2 * seconds("total"),
        "{}",
        summary["timings"]
    );
    assert!(
        seconds("total") <= wall && seconds("total") > 0.6 * wall,
        "{} {wall}",
        summary["timings"]
    );
}

#[test]
fn units_are_spelled_in_one_way_per_medium() {
    let folder = folder("messages-units");
    let mut scene = read_json(Path::new(QUICK));
    scene["name"] = json!("units");
    scene["analyses"]["backbone"] = json!({ "amplitudes": 2, "amplitude_from": 1e-6, "vertices_per_quarter": 2 });
    std::fs::write(folder.join("units.json"), scene.to_string()).unwrap();
    succeeds(&folder, &["run", "units.json", "--no-cache"]);
    for entry in std::fs::read_dir(folder.join("results/units")).unwrap() {
        let path = entry.unwrap().path();
        let mut text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
        if path.extension().is_some_and(|e| e == "html") {
            // A page carries the table that it hands out as a file, spelled as in that file.
            let (markup, _) = scripts_of(&text);
            let mut data: Value = serde_json::from_str(data_of(&text)).unwrap();
            assert!(data["modes"][0]["table"].take().as_str().unwrap().contains("[m/s^2]"));
            text = markup + &data.to_string();
        }
        let raised = path.extension().is_some_and(|e| e == "html" || e == "svg");
        let other = if raised {
            ["m^2", "m^3", "s^2"]
        } else {
            ["m²", "m³", "s²"]
        };
        for spelling in other {
            assert!(!text.contains(spelling), "{}: {spelling}", path.display());
        }
    }
    let report = std::fs::read_to_string(folder.join("results/units/report.html")).unwrap();
    assert!(report.contains("[J/m²]") && report.contains("mm²"));
}

#[test]
fn loops_that_did_not_close_are_not_said_to_be_all_well() {
    let folder = folder("messages-open");
    let mut scene = read_json(Path::new(QUICK));
    scene["name"] = json!("open");
    scene["analyses"]["backbone"] =
        json!({ "amplitudes": 2, "amplitude_from": 1e-4, "vertices_per_quarter": 2, "until_closed": 1e-9 });
    std::fs::write(folder.join("open.json"), scene.to_string()).unwrap();
    let told = succeeds(&folder, &["run", "open.json", "--no-cache"]);
    assert!(told.contains("2 loops did not close"), "{told}");
    let report = std::fs::read_to_string(folder.join("results/open/report.html")).unwrap();
    assert!(report.contains("2 of 2 loops did not close within the cycles allowed"));
    assert!(!report.contains("All amplitudes converged."));
}
