//! `calibrate`: numbers of a scene from measured backbones.

use super::compare;
use super::defaults::Defaults;
use super::destination::default_directory;
use super::outcome::Outcome;
use super::resources::{Cache, Threads};
use super::scene;
use crate::files::{self, Overwrite};
use crate::progress::{Display, Monitor};
use analyses::calibration;
use analyses::calibration::{Calibration, Measured, Noise};
use analyses::comparison::Experiment;
use analyses::comparison::{Backbone, Point};
use anyhow::{Context, Result, bail, ensure};
use host::results_of;
use modal_identification::signal::Quantity;
use reports::Output;
use reports::csv::{number, optional, table};
use reports::overlay::{self, Series};
use scenes::{Marginal, Parameter, Scene, Shape};
use std::fmt::Write;
use std::path::PathBuf;

/// Options of `calibrate`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file.
    scene: PathBuf,
    /// Backbones of `identify`, or of other runs: the folder, or its backbone.csv.
    #[arg(required = true, value_name = "EXPERIMENT")]
    experiments: Vec<PathBuf>,
    /// Numbers of the scene that are free, by their paths: mu,bolts.load.
    #[arg(long, value_name = "NAME,NAME,..", value_delimiter = ',', required = true)]
    parameters: Vec<String>,
    /// What is known of one before: NAME=normal:MEAN:SD, NAME=lognormal:MEDIAN:FACTOR or NAME=uniform:LOW:HIGH, in SI [default: what
    /// the scene says in `uncertain`].
    #[arg(long = "prior", value_name = "NAME=PRIOR")]
    priors: Vec<String>,
    /// Modes of the experiments, one for each [default: the first mode that the scene follows].
    #[arg(long, value_name = "N,N,..", value_delimiter = ',')]
    modes: Vec<usize>,
    /// Relative standard deviation of measured frequencies.
    #[arg(long, value_name = "SD", default_value_t = 1e-3)]
    frequency_sd: f64,
    /// Relative standard deviation of measured damping ratios.
    #[arg(long, value_name = "SD", default_value_t = 0.1)]
    damping_sd: f64,
    /// Folder for the results [default: results/NAME-calibrated].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    cache: Cache,
    #[command(flatten)]
    pub(super) display: Display,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, defaults: &Defaults) -> Result<Outcome> {
    let given = scene::read(Some(&arguments.scene), None, defaults)?;
    let scene = &given.scene;
    let parameters = arguments.free(scene)?;
    let measured = arguments.measured(scene)?;
    let directory = match &arguments.out {
        Some(path) => path.clone(),
        None => default_directory(&format!("{}-calibrated", scene.name))?,
    };
    let names = ["calibration.json", "residuals.csv", "scene.json"];
    let folder =
        (arguments.overwrite).open_for(arguments.display, &directory, &results_of("calibrate", scene), &names)?;
    arguments.threads.start()?;
    let noise = Noise {
        frequency_ln: arguments.frequency_sd,
        damping_ln: arguments.damping_sd,
    };
    let monitor = Monitor::new(arguments.display)?;
    let options = arguments.cache.options(defaults);
    let found = calibration::calibrate(scene, &parameters, &measured, noise, &options, &monitor);
    monitor.finish();
    let found = found.with_context(|| format!("calibrating the scene {}", scene.name))?;
    let json = serde_json::to_string_pretty(&found).context("encoding the calibration")?;
    let calibrated = serde_json::to_string_pretty(&found.scene).context("encoding the scene")?;
    let mut outputs = vec![
        Output::new("calibration.json", json + "\n"),
        Output::new("residuals.csv", residuals(&found)?),
        Output::new("scene.json", calibrated + "\n"),
    ];
    outputs.extend(pictures(&found, &measured)?);
    files::publish(folder, &outputs)?;
    found.checkpoints.remove();
    let names: Vec<&str> = outputs.iter().map(|output| output.name.as_str()).collect();
    let text = format!(
        "{}written to {}: {}\n",
        printed(&found),
        directory.display(),
        names.join(", ")
    );
    arguments.display.conclude(&directory, &found.parameters, &text)?;
    Ok(match found.converged {
        true => Outcome::Success,
        false => Outcome::Incomplete,
    })
}

impl Arguments {
    /// The free numbers with what is known of them.
    fn free(&self, scene: &Scene) -> Result<Vec<(Parameter, Option<Marginal>)>> {
        let mut priors = Vec::new();
        for text in &self.priors {
            let (name, prior) = text
                .split_once('=')
                .and_then(|(name, prior)| Some((name, self::prior(prior)?)))
                .with_context(|| {
                    format!(
                        "--prior {text}: NAME=normal:MEAN:SD, NAME=lognormal:MEDIAN:FACTOR or NAME=uniform:LOW:HIGH is expected, such \
                         as interfaces.mu=normal:0.2:0.05"
                    )
                })?;
            ensure!(
                self.parameters.iter().any(|known| known == name),
                "--prior {text}: {name} is not among --parameters; add it there, or leave out its prior"
            );
            let prior = Marginal::try_new(prior, None);
            priors.push((
                name,
                prior.map_err(|reason| anyhow::anyhow!("--prior {text}: {reason}"))?,
            ));
        }
        let of_scene = match &scene.uncertain {
            None => Vec::new(),
            Some(uncertain) => uncertain
                .parameters
                .keys()
                .cloned()
                .zip(uncertain.marginals(scene)?)
                .collect(),
        };
        let free = self.parameters.iter().map(|name| {
            let own = priors.iter().find(|(known, _)| known == name).map(|(_, prior)| *prior);
            let by_scene = || {
                of_scene
                    .iter()
                    .find(|(known, _)| known.path() == name)
                    .map(|(_, prior)| *prior)
            };
            (Parameter::new(name.as_str()), own.or_else(by_scene))
        });
        Ok(free.collect())
    }

    fn measured(&self, scene: &Scene) -> Result<Vec<Measured>> {
        let first = scene.analyses.modes.followed[0];
        if !self.modes.is_empty() && self.modes.len() != self.experiments.len() {
            bail!(
                "--modes has {} modes for {} experiments; give one for each",
                self.modes.len(),
                self.experiments.len()
            );
        }
        let measured = self.experiments.iter().enumerate().map(|(place, path)| {
            let Experiment { name, backbone, .. } = compare::experiment(path)?.over(Quantity::Displacement)?;
            let mode = self.modes.get(place).copied().unwrap_or(first);
            Ok(Measured { name, mode, backbone })
        });
        measured.collect()
    }
}

/// A prior in words with colons between.
fn prior(text: &str) -> Option<Shape> {
    let mut parts = text.split(':');
    let kind = parts.next()?;
    let numbers: Option<Vec<f64>> = parts.map(|part| part.trim().parse().ok()).collect();
    match (kind, numbers?.as_slice()) {
        ("normal", &[mean, sd]) => Some(Shape::Normal { mean, sd }),
        ("lognormal", &[median, factor]) => Some(Shape::Lognormal {
            median,
            sd_of_log: factor.ln(),
        }),
        ("uniform", &[low, high]) => Some(Shape::Uniform { low, high }),
        _ => None,
    }
}

fn residuals(found: &Calibration) -> Result<String> {
    let headings = [
        "experiment",
        "mode",
        "amplitude [m]",
        "frequency_measured [Hz]",
        "frequency [Hz]",
        "frequency_ln",
        "damping_ratio_measured [-]",
        "damping_ratio [-]",
        "damping_ln",
    ];
    let rows = found.residuals.iter().map(|r| {
        [
            r.experiment.clone(),
            r.mode.to_string(),
            number(r.measured.amplitude),
            number(r.measured.frequency_hz),
            number(r.frequency_hz),
            number(r.frequency_ln),
            optional(r.measured.damping_ratio),
            optional(r.damping_ratio),
            optional(r.damping_ln),
        ]
    });
    Ok(table(headings, rows)?)
}

/// Measured and calibrated backbones, one picture per mode.
fn pictures(found: &Calibration, measured: &[Measured]) -> Result<Vec<Output>> {
    let mut modes: Vec<usize> = measured.iter().map(|of| of.mode).collect();
    modes.sort_unstable();
    modes.dedup();
    let mut outputs = Vec::new();
    for mode in &modes {
        let model = found.residuals.iter().filter(|r| r.mode == *mode).map(|r| Point {
            amplitude: r.measured.amplitude,
            frequency_hz: r.frequency_hz,
            damping_ratio: r.damping_ratio,
        });
        let model = Backbone::try_new("the calibrated model", model.collect())?;
        let mut series = vec![Series {
            name: format!("mode {mode}, calibrated"),
            backbone: &model,
            dashes: None,
            band: None,
        }];
        series.extend(measured.iter().filter(|of| of.mode == *mode).map(|of| Series {
            name: of.name.clone(),
            backbone: &of.backbone,
            dashes: Some((9, 4)),
            band: None,
        }));
        let name = match modes.len() {
            1 => "calibration.svg".to_owned(),
            _ => format!("calibration-mode-{mode}.svg"),
        };
        outputs.push(Output::new(name, overlay::svg(&series, Quantity::Displacement)?));
    }
    Ok(outputs)
}

fn printed(found: &Calibration) -> String {
    let mut out = String::new();
    for of in &found.parameters {
        let [low, high] = of.interval_95;
        let unit = if of.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", of.unit)
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{}: {:.5e}{unit}, standard error {:.2e}{unit}, 95 % from {low:.5e} to {high:.5e}{unit}; before {:.5e}{unit}",
            of.name, of.estimate, of.standard_error, of.before
        );
    }
    for direction in &found.unidentifiable {
        let weights = direction
            .direction
            .iter()
            .map(|(name, weight)| format!("{weight:+.2} {name}"));
        let _ = writeln!(
            out,
            "NOT IDENTIFIED by the measurement: {} (singular value {:.1e}); give a prior, or measure what tells it",
            weights.collect::<Vec<_>>().join(" "),
            direction.singular_value
        );
    }
    let _ = writeln!(
        out,
        "{} measured numbers that count for {:.0} independent ones, taken as known within {} of frequencies and {} of damping ratios (one standard deviation); reduced chi-squared \
         {:.2}{}",
        found.observations,
        found.effective_observations,
        found.noise.frequency_ln,
        found.noise.damping_ln,
        found.reduced_chi_squared,
        if found.reduced_chi_squared > 1.0 {
            ", by the root of which the standard errors are larger"
        } else {
            ""
        }
    );
    let state = if found.converged { "converged" } else { "NOT CONVERGED" };
    let _ = writeln!(out, "{state} after {} evaluations ({})", found.evaluations, found.ended);
    out
}
