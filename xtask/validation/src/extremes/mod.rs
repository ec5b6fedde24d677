//! Hostile but finite situations, each with what must happen. A case converges to values known
//! from elsewhere, or is refused with a reason; it never ends in a silent number, a panic, a hang or NaN.
//!
//! # Fields of `extremes.json`
//!
//! `cargo xtask extremes` writes `extremes.json` into `results/extremes/` (or `--out DIR`), and exits with 1 if a case does not do what it must.
//!
//! | field | meaning |
//! |---|---|
//! | `schema_version`, `seconds`, `failed` | 1; wall time of all cases (s); cases that did not do what they must |
//! | `scene`, `full` | the scene that the cases start from (SI); whether on the mesh of the default scene |
//! | `cases[].{name, change, expected}` | as for `--only`; what is done to the scene, and what must happen |
//! | `cases[].{outcome, iterations, seconds, passed}` | what happened, of a refusal the message; Newton iterations, `null` for refusals; wall time (s); whether all checks hold |
//! | `cases[].checks` | by name: `holds`; of numbers `value` and `allowed` (a bound of the magnitude, or both ends), and `known` with the relative `error`; of messages `text` and `wanted` |
mod asked;
mod bench;
mod case;
mod execution;
mod findings;
mod laws;
mod loads;
mod meshes;
mod sizes;

use anyhow::{Context, Result, bail};
use bench::Bench;
pub use case::Case;
use findings::Findings;
use reports::Output;
use serde_json::{Value, json};
use std::fmt::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

/// Name of the file of all accounts.
pub const FILE: &str = "extremes.json";

/// Version of the layout of the file; grows with every change that is not a mere addition.
const SCHEMA_VERSION: u32 = 1;

/// All groups of cases, in the order of the table.
fn table() -> impl Iterator<Item = &'static Case> {
    [
        loads::CASES,
        laws::CASES,
        asked::CASES,
        sizes::CASES,
        meshes::CASES,
        execution::CASES,
    ]
    .into_iter()
    .flatten()
}

/// Cases of these names, all without any.
///
/// # Errors
/// An unknown name, listing those that exist.
pub fn select(only: &[String]) -> Result<Vec<&'static Case>> {
    let cases: Vec<&Case> = table()
        .filter(|case| only.is_empty() || only.iter().any(|name| name == case.name))
        .collect();
    if let Some(unknown) = only.iter().find(|name| cases.iter().all(|case| case.name != **name)) {
        let known: Vec<&str> = table().map(|case| case.name).collect();
        bail!("there is no case `{unknown}`; there are {}", known.join(", "));
    }
    Ok(cases)
}

/// What came of the cases.
pub struct Extremes {
    /// `extremes.json`.
    pub document: Output,
    /// Number of cases.
    pub all: usize,
    /// Names of those that did not do what they must.
    pub failed: Vec<&'static str>,
}

/// Runs the cases, on the mesh of the default scene if `full`, else on the coarse one. `show` is given the lines of a table, one
/// after each case.
///
/// # Errors
/// The scene that all cases start from fails, or `show` does.
pub fn run(cases: &[&'static Case], full: bool, mut show: impl FnMut(&str) -> Result<()>) -> Result<Extremes> {
    let began = Instant::now();
    let bench = Arc::new(Bench::try_new(full)?);
    let limit = Duration::from_secs(if full { 3600 } else { 300 });
    show(&format!(
        "{:28} {:7} {:>8} {:>10}  outcome\n",
        "case", "", "time [s]", "iterations"
    ))?;
    let mut accounts = Vec::new();
    let mut failed = Vec::new();
    for case in cases {
        let (account, line, passed) = judge(case, &bench, limit);
        show(&line)?;
        if !passed {
            failed.push(case.name);
        }
        accounts.push(account);
    }
    let all = accounts.len();
    let document = json!({
        "schema_version": SCHEMA_VERSION,
        "full": full,
        "scene": serde_json::to_value(&bench.scene).context("encoding the scene")?,
        "seconds": began.elapsed().as_secs_f64(),
        "failed": failed.len(),
        "cases": accounts,
    });
    let text = serde_json::to_string_pretty(&document).context("encoding the cases")? + "\n";
    Ok(Extremes {
        document: Output::new(FILE, text),
        all,
        failed,
    })
}

/// Runs a case and says what came of it: its entry in the file, its line in the table, and whether it passed.
fn judge(case: &'static Case, bench: &Arc<Bench>, limit: Duration) -> (Value, String, bool) {
    let bench = Arc::clone(bench);
    let began = Instant::now();
    let findings = attend(move || (case.run)(&bench), limit).unwrap_or_else(Findings::defect);
    let seconds = began.elapsed().as_secs_f64();
    let passed = findings.passed();
    let mut line = format!(
        "{:28} {:7} {seconds:8.2} {:>10}  {}\n",
        case.name,
        if passed { "ok" } else { "FAILED" },
        findings.iterations.map_or_else(|| "-".into(), |n| n.to_string()),
        findings.outcome
    );
    for (name, check) in findings.broken() {
        // Writing to a string cannot fail.
        let _ = writeln!(line, "{:28} {name}: {check}", "");
    }
    let account = json!({
        "name": case.name,
        "change": case.change,
        "expected": case.expected,
        "outcome": findings.outcome,
        "iterations": findings.iterations,
        "seconds": seconds,
        "checks": findings.checks(),
        "passed": passed,
    });
    (account, line, passed)
}

/// Does work on a thread of its own, which a panic ends and a hang outlasts; says what was wrong with it.
fn attend(work: impl FnOnce() -> Result<Findings> + Send + 'static, limit: Duration) -> Result<Findings, String> {
    let (answer, answered) = mpsc::channel();
    std::thread::spawn(move || {
        let outcome = catch_unwind(AssertUnwindSafe(work));
        // Nobody listens any more once the time is over.
        let _ = answer.send(outcome);
    });
    match answered.recv_timeout(limit) {
        Ok(Ok(Ok(findings))) => Ok(findings),
        Ok(Ok(Err(error))) => Err(format!("unexpected error: {error:#}")),
        Ok(Err(panic)) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            Err(format!("panic: {}", text.unwrap_or("without a message")))
        }
        Err(_) => Err(format!("no answer within {} s", limit.as_secs_f64())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::anyhow;

    #[test]
    fn whatever_a_case_does_is_reported() {
        let long = Duration::from_secs(60);
        let of = |outcome: Result<Findings, String>| outcome.err().unwrap_or_else(|| "nothing wrong".into());
        assert_eq!(of(attend(|| Ok(Findings::default()), long)), "nothing wrong");
        assert_eq!(
            of(attend(|| Err(anyhow!("no mesh")), long)),
            "unexpected error: no mesh"
        );
        assert_eq!(of(attend(|| panic!("at {}", 7), long)), "panic: at 7");
        let hang = || {
            std::thread::sleep(Duration::from_secs(5));
            Ok(Findings::default())
        };
        assert_eq!(of(attend(hang, Duration::from_millis(20))), "no answer within 0.02 s");
        assert!(!Findings::defect("panic".into()).passed());
    }

    #[test]
    fn cases_have_names_of_their_own_and_say_what_must_happen() {
        let mut names: Vec<&str> = table().map(|case| case.name).collect();
        names.sort_unstable();
        let all = names.len();
        names.dedup();
        assert_eq!(names.len(), all);
        assert!(table().all(|case| !case.change.is_empty() && !case.expected.is_empty()));
    }
}
