//! Shocks of a scene's structure in time, beside those of a joint that answers linearly.

use super::linearised::{Drive, Linearised, flow, whole};
use super::vibration::{Start, VibrationAnalysis};
use crate::Error;
use cqsma_solver::transient::{self, Transient};
use joints::progress::{Progress, Silent, Stage, go_on};
use joints::store::checkpoint::Checkpoints;
use modal_identification::readers;
use modal_identification::shock_spectrum::maximax;
use modal_identification::signal::{Quantity, Signal, Stated};
use scenes::{Pulse, Record, Shock};
use serde::{Deserialize, Serialize};

/// Part of the load under which the joint answers linearly: so little that nothing slips, and far above the round-off of increments.
const LINEAR: f64 = 1e-6;

/// Steps that a pulse has at least.
const STEPS_OF_PULSE: f64 = 10.0;

/// Frequencies of the spectrum: from this part of the mode's on, so many per octave, with so many samples per period at least.
const LOWEST: f64 = 0.1;
const PER_OCTAVE: f64 = 6.0;
const SAMPLES: f64 = 10.0;

/// A load in time.
enum Load {
    Pulse(Pulse),
    Record { step: f64, values: Vec<f64> },
}

impl Load {
    fn of(shock: &Shock, progress: &dyn Progress) -> Result<Self, Error> {
        if let Some(pulse) = shock.pulse {
            return Ok(Self::Pulse(pulse));
        }
        let Some(Record {
            path,
            channel,
            unit,
            sample_rate,
        }) = &shock.record
        else {
            // Scenes have one of the two; the solver refuses a load without values.
            return Ok(Self::Record {
                step: 1.0,
                values: Vec::new(),
            });
        };
        let recording = readers::read(path)?;
        let (channels, warnings) = recording.select(channel.as_deref())?;
        let stated = Stated {
            unit: unit.clone(),
            sample_rate: *sample_rate,
        };
        let [only] = channels.as_slice() else {
            return Err(Error::Shock {
                reason: format!(
                    "{} has {} channels; name one as record.channel",
                    recording.file,
                    channels.len()
                ),
            });
        };
        let (signal, of_signal) = Signal::try_new(&recording.file, only, &stated)?;
        for warning in warnings.iter().chain(&of_signal) {
            progress.warn(&warning.to_string());
        }
        if signal.quantity != Quantity::Acceleration {
            return Err(Error::Shock {
                reason: format!(
                    "{} is a {}; give the acceleration of the supports",
                    signal.at, signal.quantity
                ),
            });
        }
        Ok(Self::Record {
            step: 1.0 / signal.sample_rate,
            values: signal.samples,
        })
    }

    /// Steps and values of the load while the motion is followed with steps of `step` for `duration` (s).
    fn sampled(self, step: f64, duration: f64) -> Result<(f64, Vec<f64>), Error> {
        match self {
            Self::Record { step, mut values } => {
                values.truncate((duration / step).ceil() as usize + 1);
                Ok((step, values))
            }
            Self::Pulse(pulse) => {
                let steps = pulse.duration_s / step;
                if steps < STEPS_OF_PULSE {
                    return Err(Error::Shock {
                        reason: format!(
                            "a pulse of {} s has {steps:.1} steps; take so many steps_per_period that it has {STEPS_OF_PULSE}",
                            pulse.duration_s
                        ),
                    });
                }
                let last = (pulse.duration_s.min(duration) / step).floor() as usize;
                Ok((step, (1..=last.max(1)).map(|k| pulse.at(k as f64 * step)).collect()))
            }
        }
    }
}

/// Refuses records that cannot be read, before anything is computed.
///
/// # Errors
/// [`Error::Shock`], [`Error::Identification`].
pub(super) fn check(shock: &Shock) -> Result<(), Error> {
    Load::of(shock, &Silent).map(|_| ())
}

impl VibrationAnalysis for Shock {
    type Found = Result<ShockResponse, Error>;

    /// The motion from rest, and that of a joint that answers linearly. A step that does not converge ends it, not the run.
    fn run(&self, start: Start<'_>) -> Result<(Self::Found, Checkpoints), Error> {
        let Start { about, progress, .. } = start;
        let found = about.shock(self, progress);
        go_on(progress)?;
        Ok((found, Checkpoints::default()))
    }
}

/// A shock.
#[derive(Debug)]
pub struct ShockResponse {
    /// The motion.
    pub motion: Transient,
    /// That of a joint that answers linearly, at the same scale.
    pub linear: Transient,
    /// Load at the samples: force (N), or acceleration of the supports (m/s^2).
    pub load: Vec<f64>,
    /// Acceleration of the response point at the samples, that of the supports included: of the joint, of the linear one (m/s^2).
    pub accelerations: [Vec<f64>; 2],
    /// Largest tangential jump of a node of the interfaces where the motion settles (m).
    pub residual_sliding: f64,
    /// Displacement of the response point there (m).
    pub residual_response: f64,
    /// Shock response spectra: frequency (Hz), joint, linear (m/s^2).
    pub spectrum: Vec<[f64; 3]>,
    /// Quality factor of their oscillators.
    pub quality: f64,
    /// Steps per period of the first mode followed.
    pub steps_per_period: usize,
}

impl Linearised<'_> {
    fn shock(&self, settings: &Shock, progress: &dyn Progress) -> Result<ShockResponse, Error> {
        progress.begin(Stage::Shock);
        let Drive { row, base } = self.drive(&settings.excitation());
        let mode = self.scene.analyses.modes.followed[0] - 1;
        let frequency = self.line.frequencies()[mode];
        let step = 1.0 / (frequency * settings.steps_per_period as f64);
        let wanted = settings.periods as f64 / frequency;
        let (record_step, values) = Load::of(settings, progress)?.sampled(step, wanted)?;
        let solver = transient::Settings {
            mode,
            steps_per_period: settings.steps_per_period,
            periods: settings.periods,
            background_damping: self.scene.background_damping,
            ..transient::Settings::default()
        };
        let follow = |scale: f64, done: f64| {
            let start = transient::Start::Record {
                step: record_step,
                values: values.iter().map(|value| scale * value).collect(),
                point: row.clone(),
            };
            let found = transient::run(self.line, self.force, self.response, &start, &solver, &mut |sample| {
                progress.fraction(Stage::Shock, done + 0.5 * sample.time / wanted);
                flow(progress)
            })?;
            Ok::<_, Error>((whole(found, wanted)?, start))
        };
        let (motion, start) = follow(1.0, 0.0)?;
        let (mut linear, _) = follow(LINEAR, 0.5)?;
        for sample in &mut linear.samples {
            sample.displacement /= LINEAR;
            sample.velocity /= LINEAR;
            sample.acceleration /= LINEAR;
        }
        let load: Vec<f64> = motion
            .samples
            .iter()
            .map(|sample| start.force_at(sample.time))
            .collect();
        let carried = base.map_or(0.0, |base| base.carried);
        let felt = |of: &Transient| -> Vec<f64> {
            let samples = of.samples.iter().zip(&load);
            samples
                .map(|(sample, load)| sample.acceleration + carried * load)
                .collect()
        };
        let accelerations = [felt(&motion), felt(&linear)];
        let highest = 1.0 / (SAMPLES * motion.step);
        let count = ((highest / (LOWEST * frequency)).log2() * PER_OCTAVE).floor().max(0.0) as usize;
        let spectrum = (0..=count).map(|k| {
            let f = LOWEST * frequency * (k as f64 / PER_OCTAVE).exp2();
            let of = |signal: &[f64]| maximax(signal, motion.step, f, settings.quality);
            [f, of(&accelerations[0]), of(&accelerations[1])]
        });
        let jumps = motion.settled[..self.vibrating.n_relative].chunks_exact(3);
        let found = ShockResponse {
            spectrum: spectrum.collect(),
            residual_sliding: jumps.map(|jump| jump[0].hypot(jump[1])).fold(0.0, f64::max),
            residual_response: motion.settled.iter().zip(self.response).map(|(u, r)| u * r).sum(),
            quality: settings.quality,
            steps_per_period: settings.steps_per_period,
            motion,
            linear,
            load,
            accelerations,
        };
        progress.end(Stage::Shock);
        Ok(found)
    }
}

/// What a summary says of a shock.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ShockSummary {
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// Largest size of the load: force (N), or acceleration of the supports (m/s^2).
    pub largest_load: f64,
    /// Its unit: `N` or `m/s^2`.
    pub load_unit: String,
    /// Largest size of the displacement of the response point from its static position (m), against the supports where they move: of the joint, and of
    /// one that answers linearly.
    pub largest_response: [f64; 2],
    /// Largest size of its acceleration (m/s^2), that of the supports included, of both.
    pub largest_acceleration: [f64; 2],
    /// Displacement of the response point where the motion settles, by its mean over the last two periods (m).
    pub residual_response: f64,
    /// Largest tangential jump of a node of the interfaces there (m).
    pub residual_sliding: f64,
    /// Largest displacement of the response point in the last period over the largest of all (-): what has not died away yet.
    pub still_moving: f64,
    /// Work done on the contact: dissipated by friction, and stored in it (J).
    pub work_on_contact: f64,
    /// Largest change of the balance of energies, relative to the largest energy in the motion (-).
    pub energy_error: f64,
    /// Step of time (s).
    pub step_s: f64,
    /// Steps.
    pub steps: usize,
    /// Steps that had to be halved.
    pub halved_steps: usize,
    /// Quality factor of the oscillators of the spectrum (-).
    pub quality: f64,
    /// Shock response spectrum of the response point's acceleration (maximax).
    pub spectrum: ShockSpectrum,
}

/// Shock response spectra; lists run along the frequencies.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ShockSpectrum {
    /// Natural frequencies of the oscillators (Hz).
    pub frequency_hz: Vec<f64>,
    /// Their largest absolute acceleration (m/s^2) on the response point.
    pub joint: Vec<f64>,
    /// The same where the joint answers linearly (m/s^2).
    pub linear: Vec<f64>,
}

impl ShockSummary {
    pub(crate) fn of(found: &Result<ShockResponse, Error>, load_unit: &str) -> Self {
        let found = match found {
            Ok(found) => found,
            Err(error) => {
                return Self {
                    failure: Some(error.to_string()),
                    load_unit: load_unit.to_owned(),
                    ..Self::default()
                };
            }
        };
        let motions = [&found.motion, &found.linear];
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |most, value| most.max(value.abs()));
        let moved = |of: &Transient, from: usize| largest(&mut of.samples[from..].iter().map(|s| s.displacement));
        let [joint, linear] = motions.map(|of| moved(of, 0));
        let samples = found.motion.samples.len();
        let last = moved(&found.motion, samples.saturating_sub(found.steps_per_period));
        let column = |place: usize| found.spectrum.iter().map(|row| row[place]).collect();
        Self {
            failure: None,
            largest_load: largest(&mut found.load.iter().copied()),
            load_unit: load_unit.to_owned(),
            largest_response: [joint, linear],
            largest_acceleration: [0, 1].map(|of| largest(&mut found.accelerations[of].iter().copied())),
            residual_response: found.residual_response,
            residual_sliding: found.residual_sliding,
            still_moving: last / joint,
            work_on_contact: found.motion.samples.last().map_or(0.0, |s| s.energy.contact),
            energy_error: found.motion.energy_error(),
            step_s: found.motion.step,
            steps: samples.saturating_sub(1),
            halved_steps: found.motion.halved_steps,
            quality: found.quality,
            spectrum: ShockSpectrum {
                frequency_hz: column(0),
                joint: column(1),
                linear: column(2),
            },
        }
    }
}
