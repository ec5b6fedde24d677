//! The documents and the type hints for Python say what the registry of laws says.

use std::fs;
use std::path::{Path, PathBuf};

use crate::*;

fn in_workspace(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// Whether files are to be written instead of compared.
fn writes() -> bool {
    std::env::var_os("CONTACT_LAWS_WRITE").is_some()
}

/// Compares what stands in a file between `begin` and `end` with what the registry makes of it.
fn compare(path: &str, begin: &str, end: &str, made: &str) {
    let file = in_workspace(path);
    let text = fs::read_to_string(&file).unwrap();
    let (before, rest) = text
        .split_once(begin)
        .unwrap_or_else(|| panic!("{path} has no line {begin}"));
    let (found, after) = rest
        .split_once(end)
        .unwrap_or_else(|| panic!("{path}: nothing ends {begin}"));
    if writes() {
        fs::write(&file, [before, begin, made, end, after].concat()).unwrap();
        return;
    }
    assert!(
        found == made,
        "{path} disagrees with the registry of history rules, after {begin}:\n{made}\n\
         To write it, set CONTACT_LAWS_WRITE=1 and run this test again."
    );
}

fn state(row: &HistoryRuleInfo) -> String {
    let [x, y] = &row.state;
    format!("`{}`, `{}` ({})", x.name, y.name, x.unit)
}

/// A table between two comments.
fn compare_table(path: &str, head: &str, row: impl Fn(&HistoryRuleInfo) -> String) {
    let rows = HISTORY_RULES.iter().map(|rule| format!("{}\n", row(rule)));
    let columns = "|---".repeat(head.matches('|').count() - 1);
    let made = format!("\n\n{head}\n{columns}|\n{}\n", rows.collect::<String>());
    compare(path, "<!-- history rules -->", "<!-- end of history rules -->", &made);
}

#[test]
fn the_page_on_friction_has_the_table_of_rules() {
    let head = "| `interfaces.law.history` | what it is | stuck trial | state beside the jump | source |";
    compare_table("docs/laws/friction.md", head, |row| {
        let (name, summary) = (row.rule.name(), row.rule.summary());
        format!(
            "| `\"{name}\"` | {summary} | `{}` | {} | {} |",
            row.stuck_trial,
            state(row),
            row.source
        )
    });
}

#[test]
fn the_readme_has_the_table_of_rules() {
    let head = "| `HistoryRule` | stuck traction | state beside the jump |";
    compare_table("crates/contact-laws/README.md", head, |row| {
        format!("| `{:?}` | {} | {} |", row.rule, row.rule.summary(), state(row))
    });
}

#[test]
fn the_guide_to_scenes_names_all_rules() {
    let names = HistoryRule::ALL.iter().map(|rule| format!("`\"{}\"`", rule.name()));
    let names = names.collect::<Vec<_>>().join(", ");
    compare(
        "docs/guide/scenes.md",
        "| `history` | `\"incremental\"` | ",
        ": [history rules]",
        &names,
    );
}

#[test]
fn the_hints_for_python_have_all_names() {
    fn names<T: Choice>() -> String {
        let names = T::ALL.iter().map(|value| format!("\"{}\"", value.name()));
        names.collect::<Vec<_>>().join(", ")
    }
    let path = "crates/microslip-python/python/microslip/laws.py";
    compare(path, "\nHistory = Literal[", "]", &names::<HistoryRule>());
    let text = fs::read_to_string(in_workspace(path)).unwrap();
    for (hint, names) in [
        ("Cone = ", names::<Cone>()),
        ("Sticking = ", names::<Sticking>()),
        ("Reading = ", names::<TangentialReading>()),
        ("ends: ", names::<TangentialEnds>()),
        ("yield_curves: ", names::<YieldCurves>()),
        ("slip_limit: ", names::<AsperityLimit>()),
    ] {
        let line = format!("{hint}Literal[{names}]");
        assert!(text.contains(&line), "{path} must have {line}");
    }
}

/// Every parameter of curves stands in a row of the table on their page, with its bounds.
#[test]
fn the_pages_of_curves_have_their_parameters_and_bounds() {
    for curves in CURVES {
        let path = format!("docs/laws/{}", curves.page);
        let page = fs::read_to_string(in_workspace(&path)).unwrap();
        for Parameter { name, bounds, .. } in curves.parameters {
            let bounds = bounds.text().trim_start_matches("finite and ");
            let in_row = |row: &str| {
                let words = name.split(' ').all(|word| row.contains(&format!("`{word}`")));
                row.starts_with('|') && (words || row.contains(&format!("`{name}`"))) && row.contains(bounds)
            };
            assert!(
                page.lines().any(in_row),
                "{path} must have a row with `{name}` and \"{bounds}\""
            );
        }
    }
}

#[test]
fn names_and_numbers_tell_choices_apart() {
    fn check<T: Choice + Default + std::fmt::Debug>() {
        assert_eq!(T::ALL[0], T::default());
        for &value in T::ALL {
            assert_eq!(T::by_name(value.name()), Some(value), "another value has this name");
            assert_eq!(
                T::by_number(value.number()),
                Some(value),
                "another value has this number"
            );
        }
        assert_eq!((T::by_name("none"), T::by_number(-1)), (None, None));
    }
    check::<HistoryRule>();
    check::<Cone>();
    check::<Sticking>();
    check::<AsperityLimit>();
    check::<YieldCurves>();
    check::<TangentialEnds>();
    check::<TangentialReading>();
}
