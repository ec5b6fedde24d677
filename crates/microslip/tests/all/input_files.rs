//! Files that users name, where they are none that can be read: every command ends with a message.
#![allow(clippy::unwrap_used)]
#![cfg(target_os = "linux")]
use crate::common::{exit_code, folder, messages, run_program};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

/// What the program says; if it does not end, it is ended.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = run_program("timeout", folder, &[&["60", crate::PROGRAM], arguments].concat());
    let text = messages(&output);
    assert_eq!(exit_code(&output), 1, "{arguments:?}: {text}");
    text
}

fn scene(structure: &Value, surface: &Value) -> String {
    json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": structure,
        "model": { "material": { "youngs_modulus": "200 GPa", "poisson_ratio": 0.3 } },
        "interfaces": { "surface": surface, "mu": 0.3 },
        "bolts": { "load": "10 kN" },
    })
    .to_string()
}

fn on_deck(path: &str) -> String {
    let deck = json!({ "deck": {
        "path": path, "top_surface": "TOP", "bottom_surface": "BOTTOM",
        "bolts": [{ "top": "HEAD", "bottom": "NUT" }], "response": { "node": "TIP", "direction": [0.0, 0.0, 1.0] },
    } });
    scene(&deck, &json!({ "benchmark": "brake-reuss-beam" }))
}

#[test]
fn pipes_and_devices_are_refused_wherever_a_file_is_named() {
    let folder = folder("input-files");
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    for pipe in ["pipe", "pipe.x3p"] {
        assert!(
            Command::new("mkfifo")
                .arg(folder.join(pipe))
                .status()
                .unwrap()
                .success()
        );
    }
    std::os::unix::fs::symlink("/dev/zero", folder.join("zero.npz")).unwrap();
    write("deck.json", &on_deck("pipe"));
    let sides = json!({ "matrices": { "path": "zero.npz", "coordinates": "jump" } });
    write(
        "matrices.json",
        &scene(&sides, &json!({ "benchmark": "brake-reuss-beam" })),
    );
    let beam = json!({ "benchmark": "brake-reuss-beam" });
    write(
        "scans.json",
        &scene(&beam, &json!({ "scans": ["pipe.x3p", "zero.npz"] })),
    );
    for (arguments, said) in [
        (&["run", "pipe"][..], "pipe: it is a pipe"),
        (&["run", "/dev/zero"], "/dev/zero: it is a device"),
        (&["run", "."], "it is a folder"),
        (&["run", "deck.json", "--out", "a"], "pipe: it is a pipe"),
        (
            &["model", "deck.json", "--deck", "/dev/zero"],
            "/dev/zero: it is a device",
        ),
        (&["model", "matrices.json"], "zero.npz: it is a device"),
        (&["run", "scans.json", "--out", "b"], "pipe.x3p: it is a pipe"),
        (&["identify", "pipe", "--out", "c"], "pipe: it is a pipe"),
        (&["identify", "zero.npz", "--out", "c"], "zero.npz: it is a device"),
        (
            &[
                "characterise",
                "--benchmark",
                "brake-reuss-beam",
                "pipe.x3p",
                "pipe.x3p",
                "--out",
                "d",
            ],
            "pipe.x3p: it is a pipe",
        ),
        (
            &[
                "characterise",
                "--mesh",
                "pipe",
                "--benchmark",
                "brake-reuss-beam",
                "--out",
                "d",
            ],
            "pipe: it is a pipe",
        ),
        (&["compare", "pipe", "pipe"], "pipe: it is a pipe"),
    ] {
        let text = refused(&folder, arguments);
        assert!(text.contains(said), "{arguments:?}: {text}");
    }
}

#[test]
fn includes_stay_below_the_deck_unless_they_may_not() {
    let folder = folder("includes");
    std::fs::create_dir_all(folder.join("deck")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("deck/joint.inp", "*INCLUDE, INPUT=../secret\n");
    write("secret", "root:hash\n");
    write("scene.json", &on_deck("deck/joint.inp"));
    for command in ["run", "model", "export"] {
        let mut arguments = vec![command, "scene.json"];
        if command == "export" {
            arguments.extend(["--format", "npz"]);
        }
        let text = refused(&folder, &arguments);
        assert!(text.contains("joint.inp:1: *INCLUDE of `../secret`"), "{text}");
        assert!(
            text.contains("--allow-includes-outside") && !text.contains("hash"),
            "{text}"
        );
        for deck in [&[][..], &["--deck", "deck/joint.inp"]] {
            let text = refused(&folder, &[&arguments[..], deck, &["--allow-includes-outside"]].concat());
            assert!(text.contains("../secret:1:") && !text.contains("hash"), "{text}");
        }
    }
}
