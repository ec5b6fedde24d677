//! The program as `cargo xtask check-layering` meets it, and what else Cargo knows of the dependencies.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

#[test]
fn the_layering_holds() {
    let output = Command::new(env!("CARGO_BIN_EXE_validation"))
        .arg("check-layering")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{text}");
}

/// Otherwise running one after the other would compile everything anew.
#[test]
fn the_programs_share_one_build_of_what_they_use() {
    let packages = |edges: &str, which: &[&str]| -> BTreeMap<String, BTreeSet<String>> {
        let output = Command::new(env!("CARGO"))
            .args(["tree", "--offline", "--edges", edges, "--prefix", "none"])
            .args(["--format", "{p}|{f}"])
            .args(which)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let mut features: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        // Between the packages of a workspace are empty lines.
        let text = String::from_utf8(output.stdout).unwrap();
        for (package, enabled) in text.lines().filter_map(|line| line.split_once('|')) {
            // What was printed before is marked.
            let enabled = enabled.trim_end_matches(" (*)");
            features.entry(package.into()).or_default().insert(enabled.into());
        }
        features
    };
    let tasks = packages("normal,build", &["--package", "xtask"]);
    assert!(
        tasks.keys().any(|package| package.starts_with("analyses ")),
        "{tasks:?}"
    );
    let others = [
        ("microslip", packages("normal,build", &["--package", "microslip"])),
        ("validation", packages("normal,build", &["--package", "validation"])),
        ("the tests", packages("normal,build,dev", &["--workspace"])),
    ];
    for (other, packages) in others {
        for (package, features) in packages {
            if let Some(of_tasks) = tasks.get(&package) {
                // What it needs beside does not make cargo compile the rest anew.
                assert!(
                    of_tasks.is_subset(&features),
                    "features of {package}: {other} {features:?}, xtask {of_tasks:?}"
                );
            }
        }
    }
}
