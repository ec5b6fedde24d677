//! Runs a scene and writes its results.

use super::{Cache, Defaults, GivenScene, Outcome, Threads, default_directory, forced, print};
use crate::check;
use crate::files::{self, Overwrite};
use crate::progress::Monitor;
use analyses::error_estimate::ErrorEstimate;
use analyses::mesh_error::{FrequencyEstimate, MeshEstimate, Partner};
use analyses::registration::Moved;
use analyses::results::summary::Summary;
use analyses::uncertainty::Uncertainty;
use analyses::{Run, registration};
use anyhow::{Context, Result, anyhow};
use host::{peak_memory, provenance, results_of};
use joints::Options;
use joints::progress::Progress;
use reports::run::{ENSEMBLE, SUMMARY, damping, outputs};
use reports::tightening::TIGHTENING;
use reports::uncertainty::{self, BANDS, INFLUENCES, SAMPLES};
use reports::{Output, csv, plot, sensitivity};
use scenes;
use scenes::{Length, Scene};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

const REGISTRATION: &str = "registration.csv";

/// Options of a run.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder for the results, made if missing; results of the same scene in it are replaced, other files are left alone
    /// [default: a folder in results, named like the scene].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    cache: Cache,
    /// Also run K bootstrap realisations of the laws of all elements, for bands about the backbone; the surface of the
    /// scene must be scanned.
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=10_000))]
    ensemble: Option<u16>,
    /// Also run N samples of the uncertain inputs of the scene (`uncertain`), for bands of frequency and damping.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=10_000), conflicts_with = "ensemble")]
    samples: Option<u16>,
    /// Seed of the samples [default: that of the scene].
    #[arg(long, value_name = "SEED", requires = "samples")]
    seed: Option<u64>,
    /// Also run the scene with finer settings (settings), or with another formulation of its elements (mesh), and report the
    /// differences as an estimate of its errors; on the Brake-Reuss beam `mesh` also estimates the limit of the mesh.
    #[arg(long, value_name = "OF", num_args = 0..=1, default_missing_value = "settings", conflicts_with = "registration_study")]
    estimate_error: Option<ErrorOf>,
    /// Instead, the backbone with the bottom face of a scanned surface moved: by SHIFT (m) and tilted by TILT to either side
    /// along x and y; written to registration.csv [default folder: results/NAME-registration].
    #[arg(long, value_name = "SHIFT,TILT", num_args = 0..=1, default_missing_value = "6e-4,1e-4", value_parser = shift_and_tilt,
        conflicts_with_all = ["ensemble", "samples"])]
    registration_study: Option<[f64; 2]>,
}

fn shift_and_tilt(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    match numbers.as_slice() {
        &[shift, tilt] if shift.is_finite() && tilt.is_finite() => Ok([shift, tilt]),
        _ => Err("a shift in metres and a tilt are expected, such as 6e-4,1e-4".into()),
    }
}

/// What an error is estimated of.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum ErrorOf {
    /// All settings, by finer ones.
    Settings,
    /// The mesh, by another formulation of its elements.
    Mesh,
}

/// What is asked of a run beside its scene.
#[derive(Clone, Copy)]
pub(super) struct Request {
    /// Bootstrap realisations.
    pub(super) ensemble: Option<usize>,
    /// Samples of uncertain inputs, and their seed where it is not that of the scene.
    pub(super) samples: Option<(usize, Option<u64>)>,
    /// What else is run, to estimate errors.
    pub(super) estimate_error: Option<ErrorOf>,
}

/// Runs a scene and writes its results.
///
/// # Errors
/// The scene cannot be run as asked, or its results cannot be written.
pub fn run(given: &GivenScene, arguments: &Arguments, defaults: &Defaults) -> Result<Outcome> {
    let scene = &given.scene;
    let request = Request {
        ensemble: arguments.ensemble.map(usize::from),
        samples: arguments.samples.map(|number| (usize::from(number), arguments.seed)),
        estimate_error: arguments.estimate_error,
    };
    request.check(scene)?;
    let moves = arguments.registration_study;
    let (command, suffix, names) = match moves {
        None => ("run", "", &[SUMMARY, "report.html", "backbone.csv"][..]),
        Some(_) => ("run --registration-study", "-registration", &[REGISTRATION][..]),
    };
    let directory = match &arguments.out {
        Some(path) => path.clone(),
        None => default_directory(&format!("{}{suffix}", scene.name))?,
    };
    // Before the computation: it would be a pity to find out only afterwards.
    let folder = (arguments.overwrite).open(&directory, &results_of(command, scene), names)?;
    arguments.threads.start()?;
    let provenance = provenance::of(given.inputs()?)?;

    let options = arguments.cache.options(defaults);
    if let Some(moves) = moves {
        let monitor = Monitor::new()?;
        let study = registration::study(scene, moves, &options, &monitor);
        monitor.finish();
        let (study, checkpoints) =
            study.with_context(|| format!("moving the bottom face of the scene {}", scene.name))?;
        files::publish(folder, &[Output::new(REGISTRATION, csv::registration(&study)?)])?;
        checkpoints.remove();
        print(&moved(&study, &directory))?;
        let complete = study.iter().all(|moved| moved.not_converged == 0);
        return Ok(if complete {
            Outcome::Success
        } else {
            Outcome::Incomplete
        });
    }
    let (run, mut summary) = request.compute(scene, &options)?;
    // What was hashed before must be what was read since.
    let here = Path::new(&provenance.working_directory);
    provenance.inputs.iter().try_for_each(|input| input.check(here))?;
    summary.provenance = Some(provenance);
    files::publish(folder, &outputs(&run, &summary)?)?;
    run.checkpoints.remove();
    conclude(account(&summary, scene, &directory), scene, &summary)
}

/// Prints what was found, with what is wrong in it, and gives the outcome.
pub(super) fn conclude(mut account: String, scene: &Scene, summary: &Summary) -> Result<Outcome> {
    let defects = check::defects(scene, summary);
    for defect in &defects {
        // Writing to a string cannot fail.
        let _ = writeln!(account, "NOT SOUND, and `verify` will say so: {defect}");
    }
    print(&account)?;
    Ok(match defects.is_empty() && is_complete(summary) {
        true => Outcome::Success,
        false => Outcome::Incomplete,
    })
}

/// Whether all that was asked for converged.
pub(super) fn is_complete(summary: &Summary) -> bool {
    let mut members = summary.ensemble.iter().flat_map(|all| &all.members);
    let mut levels = summary.forced.iter();
    summary.by_mode().all(|(_, of_mode)| {
        of_mode.backbone.iter().all(|b| b.converged) && of_mode.methods.values().flatten().all(|m| m.converged)
    }) && members.all(|m| m.failure.is_none() && m.not_converged == 0)
        && summary.uncertainty.iter().all(|found| found.failed == 0)
        && levels.all(|level| level.failure.is_none() && level.resonances.iter().all(|r| r.failure.is_none()))
}

impl Request {
    /// Refuses what cannot be computed for the scene.
    fn check(&self, scene: &Scene) -> Result<()> {
        if self.ensemble.is_some() && !scene.surface.is_scanned() {
            return Err(joints::Error::NoSamples.into());
        }
        match self.estimate_error {
            Some(ErrorOf::Settings) => drop(scenes::refined(scene)?),
            Some(ErrorOf::Mesh) => drop(Partner::try_new(scene)?),
            None => {}
        }
        Ok(())
    }

    /// The run and its summary, which lacks only where it comes from. The checkpoints of the run are those of all that was
    /// computed.
    pub(super) fn compute(&self, scene: &Scene, options: &Options) -> Result<(Run, Summary)> {
        let began = Instant::now();
        let monitor = Monitor::new()?;
        if let Some(accuracy) = scene.accuracy {
            // The scene was read with it.
            let preset = accuracy
                .preset()
                .map_err(|reason| anyhow!("{}: {reason}", scene.name))?;
            monitor.note(&format!(
                "settings `{}`: expect {}",
                preset.name,
                preset.expectation(scene)
            ));
        }
        if scene.uncertain.is_some() && self.samples.is_none() {
            monitor.note("the scene has uncertain inputs; --samples N gives bands");
        }
        let result = match (self.ensemble, self.samples) {
            (Some(k), _) => {
                analyses::run_ensemble(scene, k, options, &monitor).map(|(run, all)| (run, Some(all), None))
            }
            (None, Some((number, seed))) => analyses::run_samples(scene, number, seed, options, &monitor)
                .map(|(run, found)| (run, None, Some(found))),
            (None, None) => analyses::run(scene, options, &monitor).map(|run| (run, None, None)),
        };
        let timings = monitor.finish();
        let (mut run, ensemble, uncertainty) = result.with_context(|| format!("running the scene {}", scene.name))?;
        let mut summary = Summary::new(&run, timings, peak_memory());
        summary.ensemble = ensemble;
        summary.uncertainty = uncertainty;
        match self.estimate_error {
            Some(ErrorOf::Settings) => {
                let (preset, finer) = scenes::refined(scene)?;
                let fine = again(
                    &finer,
                    &format!("the settings `{}`", preset.name),
                    &preset.expectation(&finer),
                    options,
                )?;
                summary.error_estimate = Some(ErrorEstimate::new(&run, preset, &fine));
                run.checkpoints.extend(fine.checkpoints);
            }
            Some(ErrorOf::Mesh) => {
                let partner = Partner::try_new(scene)?;
                let other = again(
                    &partner.scene,
                    "the other formulation of the elements",
                    "as long as the first run",
                    options,
                )?;
                summary.mesh_estimate = Some(MeshEstimate::new(&run, &partner, &other));
                run.checkpoints.extend(other.checkpoints);
            }
            None => {}
        }
        if self.estimate_error.is_some() {
            // The second run is part of what was asked for.
            let total = began.elapsed().as_secs_f64();
            let first = summary.timings.insert("total".into(), total).unwrap_or_default();
            summary.timings.insert("error_estimate".into(), total - first);
        }
        Ok((run, summary))
    }
}

/// Runs a variant of a scene that was run before; `time` says how long it is expected to take.
fn again(scene: &Scene, with: &str, time: &str, options: &Options) -> Result<Run> {
    let monitor = Monitor::new()?;
    monitor.note(&format!("again, with {with}: expect {time}"));
    let result = analyses::run(scene, options, &monitor);
    monitor.finish();
    result.with_context(|| format!("running the scene {} with {with}", scene.name))
}

/// What is printed at the end of a registration study.
fn moved(study: &[Moved], directory: &Path) -> String {
    let mut out = String::new();
    for moved in study {
        let ([x, y], [tx, ty]) = (moved.registration.shift.map(Length::si), moved.registration.tilt);
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

/// The backbone of one mode, with what went wrong.
fn table(out: &mut String, summary: &Summary) {
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
}

/// The two formulations beside each other.
fn mesh_estimate(estimate: &MeshEstimate) -> String {
    let mut out = String::new();
    let [own, other] = estimate.formulations();
    let limit = |frequency: &FrequencyEstimate| match (frequency.limit_hz, frequency.uncertainty_hz) {
        (Some(limit), Some(uncertainty)) => format!("{limit:.3} +- {uncertainty:.3}"),
        _ => "-".into(),
    };
    for mode in &estimate.modes {
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "\nmode {} with two formulations, {own} and {other}\n{:>14} {:>15} {:>15} {:>12} {:>20} {:>14}",
            mode.mode, "amplitude [m]", "frequency [Hz]", "other [Hz]", "difference", "limit [Hz]", "ln(damping)"
        );
        let first = (None, &mode.linear_frequency, None);
        let amplitudes = mode.amplitudes.iter();
        let rows = amplitudes.map(|a| (Some(a.response_displacement), &a.frequency, a.damping_ln_difference));
        for (amplitude, frequency, damping) in std::iter::once(first).chain(rows) {
            let _ = writeln!(
                out,
                "{:>14} {:>15.4} {:>15.4} {:>+11.3}% {:>20} {:>14}",
                amplitude.map_or_else(|| "linearised".into(), |a| format!("{a:.4e}")),
                frequency.own_hz,
                frequency.other_hz,
                100.0 * frequency.relative_difference,
                limit(frequency),
                damping.map_or_else(|| "-".into(), |d: f64| format!("{d:+.3}"))
            );
        }
    }
    let _ = writeln!(out, "limit: {}", estimate.rule());
    if estimate.share_of_elements < 1.0 {
        let share = 100.0 * estimate.share_of_elements;
        let _ = writeln!(
            out,
            "only {share:.1} % of the elements have both formulations; the error of the others is not in it"
        );
    }
    out
}

/// Bands from uncertain inputs, and which of them matter most.
fn samples(found: &Uncertainty) -> String {
    let mut out = String::new();
    for mode in &found.modes {
        let table = uncertainty::influence_table(found, mode);
        let columns = 0..table.headings.len();
        let cells = |column: usize| table.rows.iter().map(move |row| row[column].chars().count());
        let widths: Vec<usize> = columns
            .map(|column| {
                cells(column)
                    .chain([table.headings[column].chars().count()])
                    .max()
                    .unwrap_or(0)
            })
            .collect();
        // Writing to a string cannot fail.
        let _ = writeln!(out, "\nmode {}: bands from uncertain inputs", mode.mode);
        for row in std::iter::once(&table.headings).chain(&table.rows) {
            let mut line = String::new();
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                // Texts from the left, numbers from the right.
                let is_text = column == 1 || column + 1 == row.len();
                let _ = match is_text {
                    true => write!(line, "{cell:<width$}  "),
                    false => write!(line, "{cell:>width$}  "),
                };
            }
            let _ = writeln!(out, "{}", line.trim_end());
        }
    }
    for remark in uncertainty::remarks(found) {
        let _ = writeln!(out, "{remark}");
    }
    let _ = writeln!(
        out,
        "bands in {BANDS}, samples in {SAMPLES}, shares of the variance in {INFLUENCES}"
    );
    out
}

/// What is printed at the end.
fn account(summary: &Summary, scene: &Scene, directory: &Path) -> String {
    let (mut out, name) = (String::new(), &scene.name);
    let cell = |value: Option<f64>, format: &dyn Fn(f64) -> String| value.map_or_else(|| "-".into(), format);
    for (mode, of_mode) in summary.by_mode() {
        // Writing to a string cannot fail.
        let _ = match mode {
            Some(mode) => writeln!(out, "\nmode {mode}"),
            None => writeln!(out),
        };
        table(&mut out, &of_mode);
    }
    out.push_str(&sensitivity::most_influential(summary));
    let _ = writeln!(out, "\namplitude: {}", plot::amplitude_label(&summary.response));
    for level in &summary.forced {
        let _ = writeln!(out, "{}", forced::line(level));
    }
    if let (Some(first), Some(stuck)) = (summary.modes.first(), summary.model.stuck_frequencies_hz.first()) {
        let first = first.frequency_hz;
        let _ = writeln!(
            out,
            "first frequency about the prestress: {first:.3} Hz (interface stuck: {stuck:.3} Hz)"
        );
    }
    if let Some(torque) = &summary.torque {
        let _ = writeln!(out, "{}", torque.line());
    }
    if let Some(result) = &summary.tightening {
        let residual: Vec<String> = result
            .residual_preloads
            .iter()
            .map(|load| format!("{:.3}", 1e-3 * load))
            .collect();
        let lowest = result.residual_ratios.iter().copied().fold(f64::INFINITY, f64::min);
        let _ = writeln!(
            out,
            "tightened in {} steps: {} kN are left, at least {:.2} % of the load; {:.2e} of the work on the bolts is dissipated; table in \
             {TIGHTENING}",
            result.steps.len(),
            residual.join(", "),
            100.0 * lowest,
            result.energy.dissipated / result.energy.external_work
        );
    }
    if let Some(ensemble) = &summary.ensemble {
        let _ = writeln!(
            out,
            "{} bootstrap realisations, {} without a backbone; bands in {ENSEMBLE}",
            ensemble.realisations, ensemble.failed
        );
    }
    if let Some(found) = &summary.uncertainty {
        out.push_str(&samples(found));
    }
    if let Some(preset) = summary.accuracy {
        let _ = writeln!(out, "settings `{}`: {}", preset.name, preset.promise(scene));
    }
    if let Some(estimate) = &summary.error_estimate {
        let _ = writeln!(
            out,
            "against the settings `{}`: first frequency {:+.2e}, frequencies within {}, logarithm of damping within {}",
            estimate.finer,
            estimate.linear_frequency,
            cell(estimate.frequency, &|v| format!("{v:.1e}")),
            cell(estimate.damping, &|v| format!("{v:.1e}"))
        );
    }
    let _ = writeln!(out, "error of the mesh: {}", summary.model.error_bar.sentence());
    if let Some(estimate) = &summary.mesh_estimate {
        out.push_str(&mesh_estimate(estimate));
    }
    let total = summary.timings.get("total").copied().unwrap_or_default();
    let _ = writeln!(
        out,
        "{name}: {total:.1} s; results, with report.html to begin with, in {}",
        directory.display()
    );
    out
}
