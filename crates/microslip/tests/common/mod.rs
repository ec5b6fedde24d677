//! The built program in a folder of its own: what the tests of all commands share.
#![allow(clippy::unwrap_used)]
#![allow(dead_code, reason = "no test file needs all of it")]
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the program that the test file names, with a cache of its own.
pub(crate) fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(crate::PROGRAM)
        .args(arguments)
        .current_dir(folder)
        .env("XDG_CACHE_HOME", folder.join("caches"))
        .output()
        .unwrap()
}

/// What a run prints that must succeed.
pub(crate) fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {text}");
    String::from_utf8(output.stdout).unwrap()
}

/// An empty folder of its own for each test.
pub(crate) fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

pub(crate) fn read_json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

pub(crate) fn exit_code(output: &Output) -> i32 {
    output.status.code().expect("ended by a signal")
}

pub(crate) fn messages(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Asserts that two summaries agree in every digit, but for what depends on the machine and on who ran the scene.
pub(crate) fn assert_same_numbers(a: &Path, b: &Path) {
    let [a, b] = [a, b].map(|results| {
        let mut summary = read_json(&results.join("summary.json"));
        for field in ["provenance", "timings", "peak_memory"] {
            assert!(summary.as_object_mut().unwrap().remove(field).is_some(), "{field}");
        }
        // Every number in the shortest digits that read back to it.
        serde_json::to_string_pretty(&summary).unwrap()
    });
    assert!(a.contains("\"backbone\"") && a.contains("\"validity\""));
    assert_eq!(a.lines().count(), b.lines().count());
    for (number, (a, b)) in a.lines().zip(b.lines()).enumerate() {
        assert_eq!(a, b, "line {}", number + 1);
    }
}

/// A ring-down of a mode at 180 Hz with 0.3 % of damping, and a neighbour, as text.
pub(crate) fn ring_down(scale: f64, neighbour: f64) -> String {
    let mut text = String::from("time [s],acc [g],still [g]\n");
    for i in 0..8192 {
        let t = f64::from(i) / 4096.0;
        let mode =
            |a: f64, f: f64| a * (-0.003 * std::f64::consts::TAU * f * t).exp() * (std::f64::consts::TAU * f * t).cos();
        let a = scale * (mode(5.0, 180.0) + mode(neighbour, 230.0));
        text += &format!("{t:.9},{a:.9},0\n");
    }
    text
}

/// Two synthetic faces on 18 mm x 12 mm as files that state nothing but their numbers, and the mesh of 6 x 4 elements on
/// them; steps of 60 and 100 um, heights in um.
pub(crate) fn faces(folder: &Path) {
    use surface_characterisation::SyntheticFace;
    for (name, seed) in [("top.csv", 1), ("bottom.csv", 2)] {
        let face = SyntheticFace {
            points: [301, 121],
            step: [60e-6, 100e-6],
            origin: [0.0, 0.0],
            rms: 2e-6,
            correlation_length: [200e-6, 300e-6],
            waviness: vec![],
            tilt: [1e-4, 0.0],
            height_step: Some(0.1e-6),
            seed,
        };
        let map = face.generate(|_| false).unwrap();
        let rows = (0..121).map(|j| {
            let row = (0..301).map(|i| format!("{:.1}", 1e6 * map.height(i, j).unwrap()));
            row.collect::<Vec<_>>().join(",")
        });
        std::fs::write(folder.join(name), rows.collect::<Vec<_>>().join("\n")).unwrap();
    }
    let nodes: Vec<[f64; 2]> = (0..35)
        .map(|k| [f64::from(k % 7) * 3.0, f64::from(k / 7) * 3.0])
        .collect();
    let element = |e: u32| {
        let a = e / 6 * 7 + e % 6 + 1;
        [a, a + 1, a + 8, a + 7]
    };
    let elements: Vec<[u32; 4]> = (0..24).map(element).collect();
    let mesh = json!({ "nodes": nodes, "elements": elements });
    std::fs::write(folder.join("mesh.json"), mesh.to_string()).unwrap();
}
