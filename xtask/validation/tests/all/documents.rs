//! What the documents say against what it is said of: figures against the records of `cargo xtask validate`, names of tests against
//! the sources.
//!
//! A comment behind a figure names where it is recorded: `<!-- scenes brb-flat/frequencies_hz/0 -->` is the report, then a path into
//! what it found; a row of a list is named by its `name` or `id`, or by its number from 0. A factor may follow: `*1e-3`.
#![allow(clippy::unwrap_used)]

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const PAGES: [&str; 2] = ["README.md", "docs/validation.md"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A figure in a page.
#[derive(Debug, PartialEq)]
struct Figure {
    value: f64,
    /// Half a unit of its last digit.
    rounding: f64,
}

impl Figure {
    /// The last number of a text; a sign of per cent behind it counts.
    fn last_of(text: &str) -> Option<Self> {
        let is_part = |c: char| c.is_ascii_digit() || ".eE+-".contains(c);
        let end = text.rfind(|c: char| c.is_ascii_digit())? + 1;
        let start = text[..end].rfind(|c| !is_part(c)).map_or(0, |before| {
            before + text[before..].chars().next().map_or(1, char::len_utf8)
        });
        let number = text[start..end].trim_start_matches('-').trim_start_matches('+');
        let value: f64 = text[start..end].parse().ok()?;
        let (mantissa, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
        let decimals = mantissa.split_once('.').map_or(0, |(_, behind)| behind.len());
        let exponent = exponent.parse::<i32>().ok()? - i32::try_from(decimals).ok()?;
        let scale = if text[end..].trim_start().starts_with('%') {
            0.01
        } else {
            1.0
        };
        Some(Self {
            value: scale * value,
            rounding: 0.5 * scale * 10_f64.powi(exponent),
        })
    }
}

/// What a path leads to.
fn at<'v>(found: &'v Value, path: &str) -> Option<&'v Value> {
    path.split('/').try_fold(found, |value, segment| match value {
        Value::Array(rows) => {
            let named = |row: &&Value| ["name", "id"].iter().any(|key| row[key] == segment);
            let numbered = segment.parse().ok().and_then(|number: usize| rows.get(number));
            rows.iter().find(named).or(numbered)
        }
        _ => value.get(segment),
    })
}

/// What is wrong with the figures of a page, and how many there are.
fn check(text: &str, records: &BTreeMap<String, Value>) -> (Vec<String>, usize) {
    let (mut wrong, mut count) = (Vec::new(), 0);
    for (begin, _) in text.match_indices("<!-- ") {
        let comment = text[begin + 5..].split(" -->").next().unwrap();
        let Some((report, path)) = comment.split_once(' ').filter(|(name, _)| records.contains_key(*name)) else {
            wrong.push(format!("`{comment}` names no record"));
            continue;
        };
        count += 1;
        let (path, factor) = path
            .rsplit_once(" *")
            .map_or((path, 1.0), |(path, by)| (path, by.parse().unwrap()));
        let line = text[..begin].rfind('\n').map_or(0, |end| end + 1);
        let shown = Figure::last_of(&text[line..begin]);
        let recorded = at(&records[report]["found"], path).and_then(Value::as_f64);
        let agree = shown.as_ref().zip(recorded).is_some_and(|(shown, recorded)| {
            let recorded = factor * recorded;
            (shown.value - recorded).abs() <= 1.000_001 * shown.rounding
        });
        if !agree {
            wrong.push(format!("`{comment}`: {shown:?} in the page, {recorded:?} recorded"));
        }
    }
    (wrong, count)
}

#[test]
fn figures_of_the_documents_are_those_recorded() {
    let folder = root().join("fixtures/validation");
    let mut records = BTreeMap::new();
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        let record: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let commit = record["commit"].as_str().unwrap();
        assert!(!commit.contains("modified"), "{}: {commit}", path.display());
        assert!(record["date"].as_str().unwrap().starts_with("20"), "{}", path.display());
        records.insert(path.file_stem().unwrap().to_str().unwrap().to_owned(), record);
    }
    let mut wrong = Vec::new();
    let mut all = 0;
    for page in PAGES {
        let (of_page, count) = check(&std::fs::read_to_string(root().join(page)).unwrap(), &records);
        wrong.extend(of_page.into_iter().map(|what| format!("{page}: {what}")));
        all += count;
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(all >= 30, "{all} figures");
}

/// Sources of all crates and tasks.
fn sources(folder: &Path, all: &mut String) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.ends_with("target") {
            sources(&path, all);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            all.push_str(&std::fs::read_to_string(&path).unwrap());
        }
    }
}

#[test]
fn tests_that_the_documents_name_exist() {
    let mut all = String::new();
    for folder in ["crates", "xtask"] {
        sources(&root().join(folder), &mut all);
    }
    let pages =
        ["docs/equations.md", "CONTRIBUTING.md"].map(|page| std::fs::read_to_string(root().join(page)).unwrap());
    // Names of tests are sentences.
    let is_test =
        |name: &&str| name.matches('_').count() > 3 && name.chars().all(|c| c == '_' || c.is_ascii_alphanumeric());
    let named: Vec<&str> = pages
        .iter()
        .flat_map(|text| text.split('`').skip(1).step_by(2))
        .filter(is_test)
        .collect();
    assert!(named.len() > 50, "{named:?}");
    let missing: Vec<&&str> = named
        .iter()
        .filter(|name| !all.contains(&format!("fn {name}(")))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn a_figure_that_is_not_the_recorded_one_is_found() {
    let records = BTreeMap::from([(
        "scenes".to_owned(),
        serde_json::json!({ "found": [{ "name": "flat", "hz": [168.268], "share": 0.0214 }] }),
    )]);
    let sound = "f1 is 168.27 Hz <!-- scenes flat/hz/0 -->, **+2.1 %**<!-- scenes flat/share -->\n| 0.1683 kHz <!-- scenes 0/hz/0 *1e-3 --> |";
    assert_eq!(check(sound, &records), (Vec::new(), 3));
    for page in [
        "168.28 Hz <!-- scenes flat/hz/0 -->",
        "168.27 Hz <!-- scenes flat/hz/1 -->",
        "168.27 Hz <!-- scene flat/hz/0 -->",
        "168.27 Hz\n<!-- scenes flat/hz/0 -->",
        "2.1 <!-- scenes flat/share -->",
    ] {
        assert_eq!(check(page, &records).0.len(), 1, "{page}");
    }
}
