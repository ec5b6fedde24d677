//! `cargo xtask validate`: the reports that the documents quote, recorded with date and commit.

use super::tested;
use analyses::run;
use anyhow::{Context, Result, bail};
use brake_reuss_beam::BrakeReussBenchmark;
use file_io::durable;
use host::{GivenScene, provenance};
use joint_model::Benchmark;
use joints::Options;
use microslip::commands::print;
use microslip::progress::{Display, Monitor};
use microslip::{Defaults, Outcome};
use serde_json::{Map, Value, json};
use std::path::Path;
use std::process::Command;
use xtask::arguments::{self, Report};

/// Runs the command.
///
/// # Errors
/// The sources are not those of a commit; of the tasks. Nothing is recorded of one that fails or is incomplete.
pub(crate) fn run_all(arguments: &arguments::Validate, defaults: &Defaults) -> Result<Outcome> {
    let commit = provenance::commit().filter(|commit| !commit.contains("-modified"));
    let Some(commit) = commit else {
        bail!("the sources are not those of a commit, which a record must name: commit them first");
    };
    // What an interrupted call has finished is kept, and is of the same sources.
    let out = arguments.out.join(&commit);
    for report in arguments.reports() {
        let provenance = provenance::of(Vec::new())?;
        let found = compute(report, &out, &arguments.record, defaults)?;
        let record = json!({
            "date": provenance.date,
            "commit": commit,
            "arithmetic": provenance.arithmetic,
            "found": found,
        });
        let path = arguments.record.join(format!("{}.json", report.name()));
        std::fs::create_dir_all(&arguments.record)
            .with_context(|| format!("making the folder {}", arguments.record.display()))?;
        durable::write(&path, format!("{record:#}\n").as_bytes())?;
        print(&format!("recorded in {}\n", path.display()))?;
    }
    Ok(Outcome::Success)
}

/// Computes a report anew and gives its figures, as rows with a `name` or an `id`. What is compared with tests stands beside its record.
fn compute(report: Report, out: &Path, record: &Path, defaults: &Defaults) -> Result<Value> {
    let task = || task(report, out);
    Ok(match report {
        Report::Tests => tested::predictions(&record.join("measured.json"), defaults)?,
        Report::Scenes => scenes(defaults)?,
        Report::Paper => rows(&task()?, &["id", "computed"]),
        Report::Trade => rows(&task()?["rungs"], &["name", "errors", "seconds", "peak_memory"]),
        Report::Extremes => {
            let found = task()?;
            let done = found["cases"].as_array().map_or(0, Vec::len);
            json!([{ "name": "all", "cases": { "done": done, "failed": found["failed"] } }])
        }
    })
}

/// Some fields of all rows.
fn rows(rows: &Value, keep: &[&str]) -> Value {
    let row = |row: &Value| {
        keep.iter()
            .map(|key| ((*key).to_owned(), row[*key].clone()))
            .collect::<Map<_, _>>()
    };
    rows.as_array().into_iter().flatten().map(row).collect()
}

/// What a task writes that runs in a process of its own, as if somebody had called it.
fn task(report: Report, out: &Path) -> Result<Value> {
    let (name, out) = (report.name(), out.join(report.name()));
    let program = std::env::current_exe().context("finding this program")?;
    let status = Command::new(program)
        .args([name, "--out"])
        .arg(&out)
        .args((report == Report::Paper).then_some("--no-cache"))
        .status()
        .with_context(|| format!("starting {name}"))?;
    if !status.success() {
        bail!(
            "{name} failed or is incomplete, and is not recorded: see {}",
            out.display()
        );
    }
    let path = out.join(format!("{name}.json"));
    let text = std::fs::read_to_string(&path).with_context(|| format!("reading {}", path.display()))?;
    serde_json::from_str(&text).with_context(|| format!("reading {}", path.display()))
}

/// Mass and linearised frequencies of the built-in scenes that need no further file.
fn scenes(defaults: &Defaults) -> Result<Value> {
    let options = Options {
        cache: defaults.cache.clone(),
        build: provenance::commit(),
        ..Options::default()
    };
    let mut rows = Vec::new();
    for (name, text) in BrakeReussBenchmark.scenes() {
        let mut scene = GivenScene::built_in(name, text)?.scene;
        if scene.structure.deck().is_some() {
            continue;
        }
        scene = scene.only(&["modes".to_owned()])?;
        let monitor = Monitor::new(Display::default())?;
        let found = run(&scene, &options, &monitor);
        monitor.finish();
        let found = found.with_context(|| format!("running the scene {name}"))?;
        rows.push(json!({
            "name": name,
            "model": { "mass": found.model.facts.mass },
            "frequencies_hz": found.frequencies,
        }));
    }
    Ok(rows.into())
}
