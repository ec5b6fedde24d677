//! `identify`: frequency and damping against amplitude from measured ring-downs, or from sine tests at controlled response.

use crate::files::{self, Overwrite};
use crate::text::print;
use anyhow::{Result, bail, ensure};
use file_io::durable::Identity;
use modal_identification::average::{MeanPoint, average};
use modal_identification::backbone::{Identification, Point, Settings, Trims, identify};
use modal_identification::signal::{Channel, Force, Quantity, Signal, Stated};
use modal_identification::stepped_sine::Level;
use modal_identification::swept_sine::{self, Sweep};
use modal_identification::{Warning, readers};
use reports::{Output, identification};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;

/// A response that differs from its mean by more is not held (relative).
const HELD: f64 = 0.05;

/// Options of `identify`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Records: universal files (58, 58b), .mat (v5, v7), .npz, CSV, WAV. Each channel of the name is one hit.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Channel to identify [default: the only one].
    #[arg(long, value_name = "NAME")]
    channel: Option<String>,
    /// Frequency near which the mode is (Hz) [default: the highest peak of the spectrum].
    #[arg(long, allow_negative_numbers = true, value_name = "HZ")]
    frequency: Option<f64>,
    /// Width of the band (Hz) [default: a ninth of the frequency].
    #[arg(long, allow_negative_numbers = true, value_name = "HZ")]
    bandwidth: Option<f64>,
    /// Start of the backbone (s) [default: a cycle after the hit].
    #[arg(long, allow_negative_numbers = true, value_name = "S")]
    start: Option<f64>,
    /// Points per window of the smoothing, two per cycle.
    #[arg(long, value_name = "POINTS", default_value_t = Settings::default().smoothing)]
    smoothing: usize,
    /// The backbone ends at this many times the amplitude of the noise.
    #[arg(long, allow_negative_numbers = true, value_name = "FACTOR", default_value_t = Settings::default().noise_margin)]
    noise_margin: f64,
    /// Unit of the samples where the file states none, also with a factor: `g`, `mm/s`, `0.5 m/s^2`.
    #[arg(long)]
    unit: Option<String>,
    /// Sample rate where the file states none, or to more digits (Hz).
    #[arg(long, allow_negative_numbers = true, value_name = "HZ")]
    sample_rate: Option<f64>,
    /// What amplitudes are [default: the quantity measured].
    #[arg(long, value_enum)]
    amplitude: Option<Amplitude>,
    /// Amplitudes of the mean of several hits.
    #[arg(long, value_name = "NUMBER", default_value_t = 200)]
    points: usize,
    /// The files are tables of stepped-sine tests at controlled response (CSV), as `forced.csv` of a run with response levels.
    #[arg(
        long,
        conflicts_with_all = ["channel", "frequency", "bandwidth", "start", "smoothing", "noise_margin", "unit", "sample_rate", "amplitude", "points"]
    )]
    stepped_sine: bool,
    /// The files are records of swept-sine tests at controlled response, one sweep each: channel of the force.
    #[arg(
        long,
        value_name = "FORCE",
        conflicts_with_all = ["stepped_sine", "frequency", "bandwidth", "start", "smoothing", "noise_margin", "amplitude", "points"]
    )]
    swept_sine: Option<String>,
    /// Unit of the force of a sweep where the file states none, also with a factor: `N`, `lbf`, `2.5 N`.
    #[arg(long, requires = "swept_sine", value_name = "UNIT")]
    force_unit: Option<String>,
    /// Mass of the mode at the points of force and response, for tests at phase resonance (kg).
    #[arg(long, requires = "stepped_sine", value_name = "KG")]
    modal_mass: Option<f64>,
    /// Folder for backbone.csv, backbone.svg (of ring-downs) and identification.json.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

#[derive(Clone, Copy, clap::ValueEnum)]
pub(super) enum Amplitude {
    Acceleration,
    Velocity,
    Displacement,
}

impl Amplitude {
    pub(super) fn quantity(self) -> Quantity {
        match self {
            Self::Acceleration => Quantity::Acceleration,
            Self::Velocity => Quantity::Velocity,
            Self::Displacement => Quantity::Displacement,
        }
    }
}

/// One ring-down and what was found in it.
struct Hit {
    file: String,
    channel: String,
    signal: Signal,
    found: Identification,
    /// Of the file, the signal and the identification.
    warnings: Vec<Warning>,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    if let Some(force) = &arguments.swept_sine {
        return run_levels(arguments, sweeps(arguments, force)?);
    }
    if arguments.stepped_sine {
        return run_levels(arguments, tables(arguments)?);
    }
    let stated = Stated {
        unit: arguments.unit.clone(),
        sample_rate: arguments.sample_rate,
    };
    let mut settings = Settings {
        frequency: arguments.frequency,
        bandwidth: arguments.bandwidth,
        start: arguments.start,
        smoothing: arguments.smoothing,
        noise_margin: arguments.noise_margin,
        quantity: arguments.amplitude.map(Amplitude::quantity),
    };
    let mut hits = Vec::new();
    for path in &arguments.files {
        let recording = readers::read(path)?;
        let (channels, of_file) = recording.select(arguments.channel.as_deref())?;
        for channel in channels {
            let (signal, of_signal) = Signal::try_new(&recording.file, channel, &stated)?;
            // Hits of another kind of sensor are converted to that of the first.
            settings.quantity.get_or_insert(signal.quantity);
            let found = identify(&signal, &settings)?;
            let all = [of_file.clone(), of_signal, found.warnings.clone()];
            hits.push(Hit {
                file: recording.file.clone(),
                channel: channel.name.clone(),
                signal,
                found,
                warnings: all.concat(),
            });
        }
    }
    let backbones: Vec<&[Point]> = hits.iter().map(|hit| &hit.found.backbone[..]).collect();
    let mean = average(&backbones, arguments.points)?;
    // Every hit has been given this quantity.
    let quantity = settings.quantity.unwrap_or(Quantity::Acceleration);
    let directory = &arguments.out;
    let outputs = [
        Output::new("backbone.csv", identification::table(&mean, quantity)?),
        Output::new("backbone.svg", picture(&hits, &mean, quantity)?),
        Output::new(
            "identification.json",
            format!("{:#}\n", report(&hits, &mean, quantity, &settings)),
        ),
    ];
    let records: Vec<&str> = hits.iter().map(|hit| hit.file.as_str()).collect();
    let identity = Identity::new("identify", records.join(", "));
    files::publish(arguments.overwrite.open(directory, &identity, &[])?, &outputs)?;
    let names = outputs.each_ref().map(|o| o.name.as_str()).join(", ");
    let text = printed(&hits, &mean, quantity);
    print(&format!("{text}written to {}: {names}\n", directory.display()))
}

/// A level of a sine test.
struct Held {
    file: String,
    level: Level,
    /// Of the record of a sweep.
    sweep: Option<Sweep>,
    warnings: Vec<Warning>,
}

/// The levels of tables of stepped-sine tests.
fn tables(arguments: &Arguments) -> Result<Vec<Held>> {
    if let Some(mass) = arguments.modal_mass {
        ensure!(
            mass > 0.0 && mass.is_finite(),
            "--modal-mass {mass}: it must be positive (kg)"
        );
    }
    let mut found = Vec::new();
    for path in &arguments.files {
        let file = path.display().to_string();
        found.extend(readers::steps::read(path)?.into_iter().map(|level| Held {
            file: file.clone(),
            level,
            sweep: None,
            warnings: Vec::new(),
        }));
    }
    Ok(found)
}

/// The records of swept-sine tests, a level each.
fn sweeps(arguments: &Arguments, force: &str) -> Result<Vec<Held>> {
    let stated = |unit: &Option<String>| Stated {
        unit: unit.clone(),
        sample_rate: arguments.sample_rate,
    };
    let mut found = Vec::new();
    for path in &arguments.files {
        let mut recording = readers::read(path)?;
        let file = recording.file.clone();
        let forces: Vec<Channel> = recording.select(Some(force))?.0.into_iter().cloned().collect();
        recording.channels.retain(|channel| channel.name != force);
        let (channels, mut warnings) = recording.select(arguments.channel.as_deref())?;
        let ([force], [channel]) = (&forces[..], &channels[..]) else {
            bail!(
                "{file}: it has {} records of the force `{force}` and {} of the response; give a file for each sweep",
                forces.len(),
                channels.len()
            );
        };
        let (force, of_force) = Force::try_new(&file, force, &stated(&arguments.force_unit))?;
        let (response, of_response) = Signal::try_new(&file, channel, &stated(&arguments.unit))?;
        warnings.extend(of_force.into_iter().chain(of_response));
        let (level, sweep) = swept_sine::steps(&channel.name, &force, &response)?;
        found.push(Held {
            file,
            level,
            sweep: Some(sweep),
            warnings,
        });
    }
    Ok(found)
}

/// A mode for each level that was held.
fn run_levels(arguments: &Arguments, mut found: Vec<Held>) -> Result<()> {
    let Some(quantity) = found.first().map(|held| held.level.quantity) else {
        bail!("no level was found in the files");
    };
    if let Some(Held { file, level, .. }) = found.iter().find(|held| held.level.quantity != quantity) {
        bail!(
            "{file}: amplitudes are those of {}, and of {quantity} in the first file; identify them apart",
            level.quantity
        );
    }
    let (mut mean, mut levels, mut text) = (Vec::new(), Vec::new(), String::new());
    for Held {
        file,
        level,
        sweep,
        warnings,
    } in &mut found
    {
        let fitted = level.fit(arguments.modal_mass);
        match &fitted {
            Ok(fit) => {
                mean.push(MeanPoint {
                    amplitude: fit.amplitude,
                    frequency_hz: fit.frequency_hz,
                    damping_ratio: fit.damping_ratio,
                    hits: 1,
                    spread: None,
                });
                let left = fit.residual.map_or_else(
                    || "at phase resonance".to_owned(),
                    |r| format!("residual {:.2} %", 100.0 * r),
                );
                // Writing into text does not fail.
                let _ = writeln!(
                    text,
                    "{file}, level {}: {:.4e} {} held to {:.2} %, {:.4} Hz, damping ratio {:.4e}, modal mass {:.4e} kg, {} frequencies, {left}",
                    level.name,
                    fit.amplitude,
                    quantity.unit(),
                    100.0 * fit.amplitude_error,
                    fit.frequency_hz,
                    fit.damping_ratio,
                    fit.modal_mass,
                    fit.steps
                );
                if fit.amplitude_error > HELD {
                    warnings.push(Warning::NotHeld {
                        apart: fit.amplitude_error,
                    });
                }
            }
            Err(reason) => {
                let _ = writeln!(text, "{file}, level {}: not identified: {reason}", level.name);
            }
        }
        for warning in &*warnings {
            let _ = writeln!(text, "  warning: {warning}");
        }
        let sweep = sweep.as_ref().map(|sweep| {
            let limit = fitted
                .ok()
                .map(|fit| 2.0 * (fit.damping_ratio * fit.frequency_hz).powi(2));
            json!({
                "rate_hz_per_s": sweep.rate_hz_per_s,
                "slow_below_hz_per_s": limit,
                "distortion": sweep.distortion,
            })
        });
        levels.push(json!({
            "file": file,
            "level": level.name,
            "amplitude": fitted.ok().map(|f| f.amplitude),
            "amplitude_error": fitted.ok().map(|f| f.amplitude_error),
            "frequency_hz": fitted.ok().map(|f| f.frequency_hz),
            "damping_ratio": fitted.ok().map(|f| f.damping_ratio),
            "modal_mass_kg": fitted.ok().map(|f| f.modal_mass),
            "modal_mass_is_given": arguments.modal_mass.is_some() && fitted.is_ok_and(|f| f.residual.is_none()),
            "residual": fitted.ok().and_then(|f| f.residual),
            "frequencies": fitted.ok().map(|f| f.steps),
            "failure": fitted.err().map(|reason| reason.to_string()),
            "sweep": sweep,
            "warnings": warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        }));
    }
    if arguments.modal_mass.is_some() && !levels.iter().any(|level| level["modal_mass_is_given"] == true) {
        let _ = writeln!(
            text,
            "the modal mass given served no level: all had frequencies enough for a fit of their own, or none at phase resonance"
        );
    }
    ensure!(!mean.is_empty(), "no level was identified:\n{text}");
    mean.sort_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
    let report = json!({
        "schema_version": 1,
        "amplitude": { "quantity": quantity.to_string(), "unit": quantity.unit() },
        "levels": levels,
        "points": mean.len(),
    });
    let outputs = [
        Output::new("backbone.csv", identification::table(&mean, quantity)?),
        Output::new("identification.json", format!("{report:#}\n")),
    ];
    let files: Vec<&str> = found.iter().map(|held| held.file.as_str()).collect();
    let identity = Identity::new("identify", files.join(", "));
    files::publish(arguments.overwrite.open(&arguments.out, &identity, &[])?, &outputs)?;
    let names = outputs.each_ref().map(|o| o.name.as_str()).join(", ");
    print(&format!("{text}written to {}: {names}\n", arguments.out.display()))
}

fn picture(hits: &[Hit], mean: &[MeanPoint], quantity: Quantity) -> Result<String> {
    let drawn = hits.iter().map(|hit| identification::Hit {
        signal: &hit.signal,
        found: &hit.found,
    });
    Ok(identification::svg(&drawn.collect::<Vec<_>>(), mean, quantity)?)
}

/// Settings, trims and warnings.
fn report(hits: &[Hit], mean: &[MeanPoint], quantity: Quantity, settings: &Settings) -> Value {
    let hit = |hit: &Hit| {
        let (signal, found) = (&hit.signal, &hit.found);
        let check = found.cross_check.map(|c| {
            json!({
                "method": "analytic signal under a Gaussian band",
                "points": c.points,
                "frequency_difference_hz": { "median": c.frequency_median, "largest": c.frequency_largest },
                "damping_ratio_difference": { "median": c.damping_median, "largest": c.damping_largest },
                "amplitude_difference": { "median": c.amplitude_median },
            })
        });
        json!({
            "file": hit.file,
            "channel": hit.channel,
            "measured": { "quantity": signal.quantity.to_string(), "unit": signal.quantity.unit() },
            "sample_rate_hz": signal.sample_rate,
            "samples": signal.samples.len(),
            "peak_hz": found.peak_hz,
            "band_hz": found.band_hz,
            "upsampling": found.upsampling,
            "trims": trims(&found.trims),
            "filter_gain": found.filter_gain,
            "filter_delay_s": found.filter_delay,
            "noise_amplitude": found.noise_amplitude,
            "points": found.backbone.len(),
            "cross_check": check,
            "warnings": hit.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        })
    };
    json!({
        "schema_version": 1,
        "amplitude": { "quantity": quantity.to_string(), "unit": quantity.unit() },
        "settings": {
            "frequency_hz": settings.frequency,
            "bandwidth_hz": settings.bandwidth,
            "start_s": settings.start,
            "smoothing_points": settings.smoothing,
            "noise_margin": settings.noise_margin,
        },
        "hits": hits.iter().map(hit).collect::<Vec<_>>(),
        "points": mean.len(),
    })
}

/// Ends of what is used.
fn trims(trims: &Trims) -> Value {
    json!({
        "hit_s": trims.hit,
        "start_s": trims.start,
        "end_s": trims.end,
        "end_reason": format!("{:?}", trims.reason),
        "duration_s": trims.duration,
    })
}

/// What the terminal shows: warnings, and about ten amplitudes.
fn printed(hits: &[Hit], mean: &[MeanPoint], quantity: Quantity) -> String {
    let mut out = String::new();
    for hit in hits {
        let found = &hit.found;
        let [low, high] = found.band_hz;
        // Writing into text does not fail.
        let _ = writeln!(
            out,
            "{}, channel `{}`: mode at {:.2} Hz, band {low:.2} to {high:.2} Hz, {} points",
            hit.file,
            hit.channel,
            found.peak_hz,
            found.backbone.len()
        );
        if let Some(c) = found.cross_check {
            let _ = writeln!(
                out,
                "  second method: differs by {:.1e} Hz and {:.2} % of the damping ratio in the median",
                c.frequency_median,
                100.0 * c.damping_median
            );
        }
        for warning in &hit.warnings {
            let _ = writeln!(out, "  warning: {warning}");
        }
    }
    let _ = writeln!(
        out,
        "{:>22}  frequency [Hz]  damping ratio [-]  hits",
        format!("{quantity} [{}]", quantity.unit())
    );
    for p in mean.iter().step_by(mean.len().div_ceil(10).max(1)) {
        let _ = writeln!(
            out,
            "{:>22.4e}  {:>14.4}  {:>17.4e}  {:>4}",
            p.amplitude, p.frequency_hz, p.damping_ratio, p.hits
        );
    }
    out
}
