//! Runs a scene and writes its results.

use super::defaults::Defaults;
use super::destination::default_directory;
use super::outcome::Outcome;
use super::resources::{Cache, Threads};
use crate::check;
use crate::files::{self, Overwrite};
use crate::progress::{Display, Monitor};
use analyses::error_estimate::ErrorEstimate;
use analyses::mesh_error::{MeshEstimate, Partner};
use analyses::registration::Moved;
use analyses::results::summary::Summary;
use analyses::{Run, registration};
use anyhow::{Context, Result};
use host::{GivenScene, peak_memory, provenance, results_of};
use joints::Options;
use joints::progress::Progress;
use reports::account::account;
use reports::names::SUMMARY;
use reports::registry::is_complete;
use reports::run::outputs;
use reports::{Output, csv};
use scenes::{Accuracy, Length, Preset, Scene};
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
    /// How the command shows what it does.
    #[command(flatten)]
    pub display: Display,
    /// In the end print all that was found, and not the answer alone.
    #[arg(long, conflicts_with = "json")]
    verbose: bool,
    /// Of the analyses that the scene asks for, these alone, by their names in its block `analyses`; `modes` for none but the linearised
    /// modes about the prestress [default folder: results/NAME-FIRST].
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    only: Vec<String>,
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
    let scene = &match arguments.only.as_slice() {
        [] => given.scene.clone(),
        only => given.scene.only(only)?,
    };
    let request = Request {
        ensemble: arguments.ensemble.map(usize::from),
        samples: arguments.samples.map(|number| (usize::from(number), arguments.seed)),
        estimate_error: arguments.estimate_error,
    };
    request.check(scene)?;
    let moves = arguments.registration_study;
    let (command, suffix, names) = match (moves, arguments.only.first()) {
        (None, None) => (
            "run".to_owned(),
            String::new(),
            &[SUMMARY, "report.html", "backbone.csv"][..],
        ),
        (None, Some(first)) => {
            let only = format!("run --only {}", arguments.only.join(","));
            (only, format!("-{first}"), &[SUMMARY, "report.html"][..])
        }
        (Some(_), _) => (
            "run --registration-study".to_owned(),
            "-registration".to_owned(),
            &[REGISTRATION][..],
        ),
    };
    let directory = match &arguments.out {
        Some(path) => path.clone(),
        None => default_directory(&format!("{}{suffix}", scene.name))?,
    };
    // Before the computation: it would be a pity to find out only afterwards.
    let folder = (arguments.overwrite).open_for(arguments.display, &directory, &results_of(&command, scene), names)?;
    arguments.threads.start()?;
    let provenance = provenance::of(given.inputs()?)?;

    let (options, display) = (arguments.cache.options(defaults), arguments.display);
    if let Some(moves) = moves {
        let monitor = Monitor::new(display)?;
        let study = registration::study(scene, moves, &options, &monitor);
        monitor.finish();
        let (study, checkpoints) =
            study.with_context(|| format!("moving the bottom face of the scene {}", scene.name))?;
        files::publish(folder, &[Output::new(REGISTRATION, csv::registration(&study)?)])?;
        checkpoints.remove();
        display.conclude(&directory, &study, &moved(&study, &directory))?;
        let complete = study.iter().all(|moved| moved.not_converged == 0);
        return Ok(if complete {
            Outcome::Success
        } else {
            Outcome::Incomplete
        });
    }
    let (run, mut summary) = request.compute(scene, &options, display)?;
    // What was hashed before must be what was read since.
    let here = Path::new(&provenance.working_directory);
    provenance.inputs.iter().try_for_each(|input| input.check(here))?;
    summary.provenance = Some(provenance);
    files::publish(folder, &outputs(&run, &summary)?)?;
    run.checkpoints.remove();
    let text = account(&summary, scene, &directory, arguments.verbose);
    display.conclude(&directory, &summary.answer, &text)?;
    let defects = check::defects(scene, &summary);
    for defect in &defects {
        display.warn(&format!("NOT SOUND, and `verify` will say so: {defect}"));
    }
    Ok(match defects.is_empty() && is_complete(&summary) {
        true => Outcome::Success,
        false => Outcome::Incomplete,
    })
}

impl Request {
    /// Refuses what cannot be computed for the scene.
    fn check(&self, scene: &Scene) -> Result<()> {
        if self.ensemble.is_some() && !scene.interfaces.surface.is_scanned() {
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
    pub(super) fn compute(&self, scene: &Scene, options: &Options, display: Display) -> Result<(Run, Summary)> {
        let began = Instant::now();
        let monitor = Monitor::new(display)?;
        if let Some(preset) = Preset::of(scene) {
            monitor.note(&format!(
                "settings `{}`: expect {}",
                preset.name,
                preset.expectation(scene)
            ));
        }
        let is_target = matches!(scene.accuracy, Some(Accuracy::Target(_)));
        if is_target && (self.ensemble.is_some() || self.samples.is_some()) {
            monitor.note(
                "with realisations or samples the accuracy chooses a set of settings and does not adapt it; a run without them shows what to \
                 give",
            );
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
        let mut summary = Summary::new(&run, timings, peak_memory()).with_uncertainty(uncertainty);
        summary.ensemble = ensemble;
        match self.estimate_error {
            Some(ErrorOf::Settings) => {
                let (preset, finer) = scenes::refined(scene)?;
                let fine = again(
                    &finer,
                    &format!("the settings `{}`", preset.name),
                    &preset.expectation(&finer),
                    options,
                    display,
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
                    display,
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
fn again(scene: &Scene, with: &str, time: &str, options: &Options, display: Display) -> Result<Run> {
    let monitor = Monitor::new(display)?.beside();
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
