//! Requirements and their tests, listed from the names of the tests.

use anyhow::{Context, Result};
use microslip::commands::print;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// A test: its name says what must hold.
#[derive(Debug, PartialEq, Eq)]
struct Test {
    name: String,
    /// Why it does not run with the others.
    ignored: Option<String>,
}

/// Prints the tables.
pub(crate) fn run() -> Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    print(&table(&root)?)
}

/// One table for each crate with tests of its public interface.
fn table(root: &Path) -> Result<String> {
    let mut text = String::new();
    let mut crates = sorted(&root.join("crates"))?;
    crates.push(root.join("xtask"));
    crates.extend(sorted(&root.join("xtask"))?);
    for of in crates.iter().filter(|of| of.join("Cargo.toml").is_file()) {
        let mut files = Vec::new();
        for folder in ["tests", "tests/all"] {
            let folder = of.join(folder);
            files.extend(if folder.is_dir() { sorted(&folder)? } else { Vec::new() });
        }
        let mut rows = String::new();
        for file in files.iter().filter(|file| file.extension().is_some_and(|e| e == "rs")) {
            let source = fs::read_to_string(file).with_context(|| format!("reading {}", file.display()))?;
            let stem = file.file_stem().unwrap_or_default().to_string_lossy();
            for test in found(&source) {
                let evidence = test
                    .ignored
                    .map_or_else(|| "gate".into(), |why| format!("on request: {}", why.replace('|', "/")));
                // Writing to a string cannot fail.
                let _ = writeln!(rows, "| {} | `{stem}` | {evidence} |", test.name.replace('_', " "));
            }
        }
        if !rows.is_empty() {
            let manifest =
                fs::read_to_string(of.join("Cargo.toml")).with_context(|| format!("reading {}", of.display()))?;
            let name = manifest
                .lines()
                .find_map(|line| line.strip_prefix("name = "))
                .unwrap_or_default();
            let name = name.trim_matches('"');
            let _ = writeln!(
                text,
                "\n### `{name}`\n\n| requirement | tests of | evidence |\n|---|---|---|\n{}",
                rows.trim_end()
            );
        }
    }
    Ok(text)
}

fn sorted(folder: &Path) -> Result<Vec<PathBuf>> {
    let listing = || format!("listing {}", folder.display());
    let entries = fs::read_dir(folder).with_context(listing)?;
    let mut paths = entries
        .map(|entry| Ok(entry.with_context(listing)?.path()))
        .collect::<Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}

/// The tests in a source file, in its order.
fn found(source: &str) -> Vec<Test> {
    let mut tests = Vec::new();
    let mut lines = source.lines().map(str::trim);
    while lines.any(|line| line == "#[test]") {
        let mut ignored = None;
        for line in lines.by_ref() {
            if let Some(attribute) = line.strip_prefix("#[ignore") {
                ignored = Some(attribute.trim_matches([' ', '=', '"', ']']).to_owned());
            }
            if let Some((name, _)) = line.strip_prefix("fn ").and_then(|line| line.split_once('(')) {
                tests.push(Test {
                    name: name.to_owned(),
                    ignored,
                });
                break;
            }
        }
    }
    tests
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_are_found_with_what_keeps_them_from_running() {
        let source = "fn helper() {}\n#[test]\nfn one_holds() {\n}\n\n    #[test]\n    #[ignore = \"minutes: cargo\"]\n    fn two_hold(x in 0..3) {}\n";
        let expected = [("one_holds", None), ("two_hold", Some("minutes: cargo"))];
        let expected = expected.map(|(name, ignored)| Test {
            name: name.into(),
            ignored: ignored.map(String::from),
        });
        assert_eq!(found(source), expected);
    }
}
