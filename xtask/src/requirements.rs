//! The table of requirements and their tests, made from the names of the tests.

use anyhow::{Context, Result, ensure};
use microslip::commands::print;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// The page with the table, and what encloses it there.
const PAGE: &str = "docs/verification.md";
const BEGIN: &str = "<!-- Written by `cargo xtask requirements`. -->\n";
const END: &str = "<!-- End of what is written. -->\n";

/// Options of the command.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Write nothing, and fail if the page is not as it would be written.
    #[arg(long)]
    check: bool,
}

/// A test: its name says what must hold.
#[derive(Debug, PartialEq, Eq)]
struct Test {
    name: String,
    /// Why it does not run with the others.
    ignored: Option<String>,
}

/// Writes the table into the page, or compares.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let path = root.join(PAGE);
    let page = fs::read_to_string(&path).with_context(|| format!("reading {PAGE}"))?;
    let (table, count) = table(&root)?;
    let written = with_table(&page, &table)?;
    if arguments.check {
        ensure!(
            written == page,
            "{PAGE}: the table of tests is stale; run `cargo xtask requirements`"
        );
    } else if written != page {
        fs::write(&path, written).with_context(|| format!("writing {PAGE}"))?;
    }
    print(&format!("{PAGE}: {count} requirements with their tests\n"))
}

/// The page with another table between the marks.
fn with_table(page: &str, table: &str) -> Result<String> {
    let parts = page
        .split_once(BEGIN)
        .and_then(|(before, rest)| Some((before, rest.split_once(END)?.1)));
    let (before, after) =
        parts.with_context(|| format!("{PAGE} lacks the lines `{}` and `{}`", BEGIN.trim(), END.trim()))?;
    Ok(format!("{before}{BEGIN}{table}{END}{after}"))
}

/// One table for each crate with tests of its public interface, and the number of tests.
fn table(root: &Path) -> Result<(String, usize)> {
    let (mut text, mut count) = (String::new(), 0);
    let mut crates = sorted(&root.join("crates"))?;
    crates.push(root.join("xtask"));
    crates.extend(sorted(&root.join("xtask"))?);
    for of in crates.iter().filter(|of| of.join("Cargo.toml").is_file()) {
        let tests = of.join("tests");
        let files = if tests.is_dir() { sorted(&tests)? } else { Vec::new() };
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
                count += 1;
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
    text.push('\n');
    Ok((text, count))
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

    #[test]
    fn the_table_replaces_the_one_between_the_marks_alone() {
        let page = format!("before\n{BEGIN}old\n{END}after\n");
        let written = with_table(&page, "new\n").unwrap();
        assert_eq!(written, format!("before\n{BEGIN}new\n{END}after\n"));
        assert!(with_table("no marks", "new").is_err());
    }
}
