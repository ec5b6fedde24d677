//! The built program in a folder of its own: what the tests of all commands share.
#![allow(clippy::unwrap_used)]
#![allow(dead_code, reason = "no test file needs all of it")]
pub(crate) mod page;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the program of this binary, with a cache of its own.
pub(crate) fn run(folder: &Path, arguments: &[&str]) -> Output {
    run_program(crate::PROGRAM, folder, arguments)
}

/// Runs a program in the same way.
pub(crate) fn run_program(program: &str, folder: &Path, arguments: &[&str]) -> Output {
    Command::new(program)
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

/// The summary in a folder of results without what depends on the machine and on who ran the scene.
pub(crate) fn reproducible(results: &Path) -> Value {
    let mut summary = read_json(&results.join("summary.json"));
    for field in ["provenance", "timings", "peak_memory"] {
        assert!(summary.as_object_mut().unwrap().remove(field).is_some(), "{field}");
    }
    summary
}

/// Copies a folder with all that is in it.
pub(crate) fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let to = to.join(entry.file_name());
        match entry.file_type().unwrap().is_dir() {
            true => copy(&entry.path(), &to),
            false => drop(std::fs::copy(entry.path(), to).unwrap()),
        }
    }
}

/// Asserts that two summaries agree in every digit, but for what depends on the machine and on who ran the scene.
pub(crate) fn assert_same_numbers(a: &Path, b: &Path) {
    let [a, b] = [a, b].map(|results| {
        // Every number in the shortest digits that read back to it.
        serde_json::to_string_pretty(&reproducible(results)).unwrap()
    });
    assert!(a.contains("\"backbone\"") && a.contains("\"validity\""));
    assert_eq!(a.lines().count(), b.lines().count());
    for (number, (a, b)) in a.lines().zip(b.lines()).enumerate() {
        assert_eq!(a, b, "line {}", number + 1);
    }
}
