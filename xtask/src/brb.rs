//! Runs a scene and writes its results.

use crate::files::{self, Output};
use crate::progress::{Monitor, peak_memory};
use crate::{Outcome, csv, fields, plot, print, report, vtu};
use anyhow::{Context, Result, bail};
use joint_pipeline::registration::{self, Moved};
use joint_pipeline::summary::{BackboneSummary, Status, Summary};
use joint_pipeline::{Options, Run, Scene};
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

const FLAT: &str = include_str!("../../fixtures/scenes/brb-flat.json");
const DECK: &str = include_str!("../../fixtures/scenes/brb-deck.json");
pub(crate) const RESULTS: &str = "results";
pub(crate) const SUMMARY: &str = "summary.json";
const ENSEMBLE: &str = "ensemble.csv";
const REGISTRATION: &str = "registration.csv";

/// Arguments of the command.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Scene file; without it the built-in scene brb-flat runs, or brb-deck if there is a deck.
    scene: Option<PathBuf>,
    /// Input deck of the structure, in the place of the one that the scene names.
    #[arg(long, value_name = "FILE")]
    deck: Option<PathBuf>,
    /// Folder for the results, made if missing; other files in it are left alone, except that fields of amplitudes
    /// that this run does not store are removed when the folder holds an earlier run of a scene of the same name
    /// [default: a folder in results, named like the scene].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of threads [default: one per processor].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Neither read nor store reduced models and finished amplitudes in results/.cache.
    #[arg(long)]
    no_cache: bool,
    /// Also run K bootstrap realisations of the laws of all elements, for bands about the backbone; the surface of the
    /// scene must be scanned.
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=10_000))]
    ensemble: Option<u16>,
    /// Instead, the backbone with the bottom face of a scanned surface moved: by SHIFT (m) and tilted by TILT to either side
    /// along x and y; written to registration.csv.
    #[arg(long, value_name = "SHIFT,TILT", num_args = 0..=1, default_missing_value = "6e-4,1e-4", value_parser = shift_and_tilt,
        conflicts_with = "ensemble")]
    registration_study: Option<[f64; 2]>,
}

fn shift_and_tilt(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    match numbers.as_slice() {
        &[shift, tilt] if shift.is_finite() && tilt.is_finite() => Ok([shift, tilt]),
        _ => Err("a shift in metres and a tilt are expected, such as 6e-4,1e-4".into()),
    }
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Outcome> {
    let scene = read_scene(arguments.scene.as_deref(), arguments.deck.as_deref())?;
    if arguments.ensemble.is_some() && !scene.surface.is_scanned() {
        return Err(joint_pipeline::Error::NoSamples.into());
    }
    let directory = match &arguments.out {
        Some(path) => path.clone(),
        None => default_directory(&scene.name)?,
    };
    // Before the computation: it would be a pity to find out only afterwards.
    std::fs::create_dir_all(&directory).with_context(|| format!("making the folder {}", directory.display()))?;
    if let Some(threads) = arguments.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global()
            .with_context(|| format!("starting {threads} threads"))?;
    }

    let options = Options {
        cache: (!arguments.no_cache).then(|| Path::new(RESULTS).join(".cache")),
    };
    let monitor = Monitor::new()?;
    if let Some(moves) = arguments.registration_study {
        let study = registration::study(&scene, moves, &options, &monitor);
        monitor.finish();
        let study = study.with_context(|| format!("moving the bottom face of the scene {}", scene.name))?;
        let outputs = [Output::new(REGISTRATION, csv::registration(&study))];
        files::write_all(&directory, &outputs)?;
        print(&moved(&study, &directory))?;
        let complete = study.iter().all(|moved| moved.not_converged == 0);
        return Ok(if complete {
            Outcome::Success
        } else {
            Outcome::Incomplete
        });
    }
    let result = match arguments.ensemble {
        None => joint_pipeline::run(&scene, &options, &monitor).map(|run| (run, None)),
        Some(k) => {
            joint_pipeline::run_ensemble(&scene, k.into(), &options, &monitor).map(|(run, all)| (run, Some(all)))
        }
    };
    let timings = monitor.finish();
    let (run, ensemble) = result.with_context(|| format!("running the scene {}", scene.name))?;
    let mut summary = Summary::new(&run, timings, peak_memory());
    summary.ensemble = ensemble;

    let stale = is_run_of(&directory, &scene.name);
    let outputs = outputs(&run, &summary)?;
    files::write_all(&directory, &outputs)?;
    if stale {
        files::remove_stale(&directory, &outputs, &[ENSEMBLE])?;
    }
    print(&account(&summary, &scene.name, &directory))?;
    let others = summary.methods.values().flatten();
    let mut members = summary.ensemble.iter().flat_map(|all| &all.members);
    let complete = summary.backbone.iter().all(|b| b.converged)
        && others.into_iter().all(|m| m.converged)
        && members.all(|m| m.failure.is_none() && m.not_converged == 0);
    Ok(if complete {
        Outcome::Success
    } else {
        Outcome::Incomplete
    })
}

/// Total damping ratio as text, or the floor that it lies below.
pub(crate) fn damping(b: &BackboneSummary) -> String {
    match (b.status, b.damping_ratio, b.damping_floor) {
        (Status::BelowFloor, _, Some(floor)) => format!("< {floor:.1e}"),
        (_, Some(zeta), _) => format!("{zeta:.4e}"),
        _ => "-".into(),
    }
}

/// The scene of a file or a built-in one, with its deck replaced on request.
pub(crate) fn read_scene(scene: Option<&Path>, deck: Option<&Path>) -> Result<Scene> {
    let mut scene = match (scene, deck) {
        (Some(path), _) => Scene::read(path)?,
        (None, None) => Scene::from_json(FLAT, "the built-in scene", "brb-flat")?,
        (None, Some(_)) => Scene::from_json(DECK, "the built-in scene", "brb-deck")?,
    };
    if let Some(path) = deck {
        let Some(source) = &mut scene.model.deck else {
            bail!(
                "the scene {} has no model.deck to say which surfaces and bolts of {} to take",
                scene.name,
                path.display()
            )
        };
        source.path = path.to_owned();
    }
    Ok(scene)
}

/// The folder of this name among the results.
pub(crate) fn default_directory(name: &str) -> Result<PathBuf> {
    let mut components = Path::new(name).components();
    match (components.next(), components.next()) {
        (Some(Component::Normal(_)), None) if !name.starts_with('.') => Ok(Path::new(RESULTS).join(name)),
        _ => bail!("the scene's name `{name}` cannot name a folder; choose one with --out"),
    }
}

/// Whether `directory` holds an earlier run of the scene `name`.
fn is_run_of(directory: &Path, name: &str) -> bool {
    let text = std::fs::read_to_string(directory.join(SUMMARY)).unwrap_or_default();
    let earlier: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    earlier.pointer("/scene/name").and_then(serde_json::Value::as_str) == Some(name)
}

/// All files of a run; the summary comes last, so that a new one never stands beside old files.
fn outputs(run: &Run, summary: &Summary) -> Result<Vec<Output>> {
    let field_file =
        |name: String, fields| Output::new(name, vtu::document(&run.mesh, &fields::cell_fields(run, fields)));
    let picture = plot::backbone(summary, &title(run))?;
    let mut outputs = vec![field_file("interface-prestress.vtu".into(), &run.prestress.fields)];
    for (index, amplitude) in run.amplitudes.iter().enumerate() {
        if let Some(fields) = amplitude.fields.as_ref().and_then(|f| f.fields.as_ref()) {
            outputs.push(field_file(files::amplitude_file(index + 1), fields));
        }
    }
    outputs.push(Output::new("backbone.csv", csv::document(summary)));
    if let Some(ensemble) = &summary.ensemble {
        outputs.push(Output::new(ENSEMBLE, csv::ensemble(ensemble)));
    }
    outputs.push(Output::new("report.html", report::document(run, summary, &picture)?));
    outputs.push(Output::new("backbone.svg", picture));
    let json = serde_json::to_string_pretty(summary).context("encoding the summary")?;
    outputs.push(Output::new(SUMMARY, json + "\n"));
    Ok(outputs)
}

fn title(run: &Run) -> String {
    let scene = &run.scene;
    format!(
        "{}: mode {}, mu = {}, bolts {:.3} kN each",
        scene.name,
        scene.cqsma.mode,
        scene.mu,
        scene.bolts.load / 1e3
    )
}

/// What is printed at the end of a registration study.
fn moved(study: &[Moved], directory: &Path) -> String {
    let mut out = String::new();
    for moved in study {
        let ([x, y], [tx, ty]) = (moved.registration.shift, moved.registration.tilt);
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "bottom face at ({x:+.2e}, {y:+.2e}) m, tilted by ({tx:+.1e}, {ty:+.1e}): first frequency {:.3} Hz; changes up to {:.3} \
             Hz and {:.1} % of damping",
            moved.first_frequency_hz,
            moved.frequency_change_hz,
            100.0 * moved.damping_change.exp_m1()
        );
    }
    let _ = writeln!(out, "written to {}: {REGISTRATION}", directory.display());
    out
}

/// What is printed at the end.
fn account(summary: &Summary, name: &str, directory: &Path) -> String {
    let mut out = String::from("\n");
    let cell = |value: Option<f64>, format: &dyn Fn(f64) -> String| value.map_or_else(|| "-".into(), format);
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "{:>4} {:>14} {:>15} {:>12} {:>14} {:>11}",
        "no.", "amplitude [m]", "frequency [Hz]", "damping [-]", "slipping area", "iterations"
    );
    for (index, b) in summary.backbone.iter().enumerate() {
        let _ = writeln!(
            out,
            "{:>4} {:>14} {:>15} {:>12} {:>14} {:>11}{}",
            index + 1,
            cell(b.response_displacement, &|v| format!("{v:.4e}")),
            cell(b.frequency_hz, &|v| format!("{v:.4}")),
            damping(b),
            cell(b.slip_fraction, &|v| format!("{:.2} %", 100.0 * v)),
            b.iterations,
            b.failure
                .as_ref()
                .map_or_else(String::new, |reason| format!("  not converged: {reason}")),
        );
    }
    let _ = writeln!(out, "\namplitude: {}", plot::RESPONSE);
    if let (Some(first), Some(stuck)) = (summary.modes.first(), summary.model.stuck_frequencies_hz.first()) {
        let first = first.frequency_hz;
        let _ = writeln!(
            out,
            "first frequency about the prestress: {first:.3} Hz (interface stuck: {stuck:.3} Hz)"
        );
    }
    let failed = summary.backbone.iter().filter(|b| !b.converged).count();
    if failed > 0 {
        let all = summary.backbone.len();
        let _ = writeln!(
            out,
            "{failed} of {all} amplitudes DID NOT CONVERGE; their results are missing"
        );
    }
    let open = summary.backbone.iter().filter(|b| b.closed == Some(false)).count();
    if open > 0 {
        let _ = writeln!(
            out,
            "{open} loops did not close within the cycles allowed; see loop_closure in {SUMMARY}"
        );
    }
    if let Some(ensemble) = &summary.ensemble {
        let _ = writeln!(
            out,
            "{} bootstrap realisations, {} without a backbone; bands in {ENSEMBLE}",
            ensemble.realisations, ensemble.failed
        );
    }
    let total = summary.timings.get("total").copied().unwrap_or_default();
    let _ = writeln!(
        out,
        "{name}: {total:.1} s; results, with report.html to begin with, in {}",
        directory.display()
    );
    out
}
