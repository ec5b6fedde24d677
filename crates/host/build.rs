//! Tells the library the commit that it is built from, as `MICROSLIP_COMMIT`; empty if that is not known.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::process::Command;

fn main() {
    let commit = packaged().or_else(checked_out).unwrap_or_default();
    println!("cargo::rustc-env=MICROSLIP_COMMIT={commit}");
    println!("cargo::rerun-if-changed=build.rs");
}

/// The commit that `cargo package` writes beside a published crate.
fn packaged() -> Option<String> {
    let text = std::fs::read_to_string(".cargo_vcs_info.json").ok()?;
    let (_, rest) = text.split_once("\"sha1\"")?;
    let commit = rest.split('"').nth(1)?;
    Some(commit.to_owned())
}

/// The commit of the checkout that this is a part of, if there is one and the program `git` is there.
fn checked_out() -> Option<String> {
    // A copy within somebody else's repository is not of its commit.
    if git(&["rev-parse", "--show-prefix"])? != "crates/host/" || git(&["ls-files", "Cargo.toml"])?.is_empty() {
        return None;
    }
    let commit = git(&["rev-parse", "HEAD"])?;
    let sources = ["--", "..", "../../xtask", "../../Cargo.lock"];
    let changes = git(&[&["status", "--porcelain", "--untracked-files=no"][..], &sources].concat())?;
    // Every commit is appended to the log of HEAD, and whatever changes a source compiles programs anew anyway.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    if Path::new(&log).exists() {
        println!("cargo::rerun-if-changed={log}");
    }
    println!("cargo::rerun-if-changed=../../Cargo.lock");
    // The tasks have this commit too, and name it in their records.
    println!("cargo::rerun-if-changed=../../xtask/src");
    println!("cargo::rerun-if-changed=../../xtask/validation/src");
    for entry in std::fs::read_dir("..").ok()?.flatten() {
        let sources = entry.path().join("src");
        if sources.exists() {
            println!("cargo::rerun-if-changed={}", sources.display());
        }
    }
    if changes.is_empty() {
        return Some(commit);
    }
    // What builds of other changes have stored must not be taken for results of this one.
    let mut hash = DefaultHasher::new();
    git(&[&["diff", "HEAD"][..], &sources].concat())?.hash(&mut hash);
    Some(format!("{commit}-modified-{:016x}", hash.finish()))
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
