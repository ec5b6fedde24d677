//! The ring-down of a scene's reduced model in time, identified like a measured one: an independent check of the backbone.

use super::comparison::{Backbone, Misfit, Point};
use super::linearised::{Linearised, flow, whole};
use super::vibration::{Start, VibrationAnalysis};
use crate::Error;
use cqsma_solver::transient::{self, Transient};
use joints::progress::{Progress, Stage, go_on};
use joints::store::checkpoint::Checkpoints;
use modal_identification::average::{MeanPoint, average};
use modal_identification::backbone::{Identification, identify};
use modal_identification::signal::{Quantity, Signal};
use modal_identification::{backbone, synthetic};
use scenes::{Length, Strike};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// A ring-down.
#[derive(Debug)]
pub struct RingDown {
    /// The motion of the response point.
    pub motion: Motion,
    /// What is identified from it like from a measured one, or why nothing is.
    pub identified: Result<Identified, Error>,
}

/// What is identified from a ring-down.
#[derive(Debug)]
pub struct Identified {
    /// Points, band and trims.
    pub identification: Identification,
    /// The points, as those of measurements are averaged.
    pub mean: Vec<MeanPoint>,
    /// The backbone over acceleration.
    pub backbone: Backbone,
    /// Other backbones over acceleration, by name.
    pub theories: Vec<(String, Backbone)>,
    /// Theory minus ring-down.
    pub misfits: Vec<(String, Misfit)>,
    /// Identification of a ring-down that has the first theory's backbone, minus that backbone.
    pub own_error: Option<Misfit>,
}

/// The motion of the response point after a release or a strike.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Samples with the energies.
    pub transient: Transient,
    /// Frequency of the linearised mode (Hz).
    pub frequency_hz: f64,
}

impl VibrationAnalysis for scenes::RingDown {
    type Found = Result<RingDown, Error>;

    /// The motion of the first mode followed, compared with its backbones. A step that does not converge ends it, not the run.
    fn run(&self, start: Start<'_>) -> Result<(Self::Found, Checkpoints), Error> {
        let Start {
            about, modes, progress, ..
        } = start;
        let theories = modes[0].over_acceleration();
        let found = about.motion(self, progress).map(|motion| RingDown {
            identified: theories.and_then(|theories| Identified::of(&motion, theories)),
            motion,
        });
        go_on(progress)?;
        Ok((found, Checkpoints::default()))
    }
}

impl Identified {
    fn of(motion: &Motion, theories: Vec<(String, Backbone)>) -> Result<Self, Error> {
        let how = motion.identification();
        let (identification, backbone) = motion.identify(&how)?;
        let mean = average(&[&identification.backbone], 2)?;
        let misfits = theories.iter();
        let misfits = misfits.filter_map(|(name, theory)| Some((name.clone(), theory.misfit(&backbone)?)));
        let misfits = misfits.collect();
        let own_error = match theories.first() {
            Some((_, known)) => motion.identified_again(known, &how)?.misfit(known),
            None => None,
        };
        Ok(Self {
            identification,
            mean,
            backbone,
            theories,
            misfits,
            own_error,
        })
    }
}

/// What a summary says of a ring-down.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RingDownSummary {
    /// Why there is none, or why nothing could be identified from it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// Frequency of the linearised mode (Hz).
    pub linearised_frequency_hz: f64,
    /// Step of time (s).
    pub step_s: f64,
    /// Steps.
    pub steps: usize,
    /// Steps that had to be halved.
    pub halved_steps: usize,
    /// What the integration makes of the frequency of the linear mode (-); identified frequencies are divided by it.
    pub integration_frequency_ratio: f64,
    /// What it adds to the damping ratio (-).
    pub integration_damping_ratio: f64,
    /// Largest change of the balance of energies, relative to the largest energy in the motion (-).
    pub energy_error: f64,
    /// Share of the kinetic energy outside the mode (-).
    pub kinetic_elsewhere: f64,
    /// Largest residual of a step, relative to inertia (energy norm).
    pub residual: f64,
    /// Band that was identified in (Hz).
    pub band_hz: [f64; 2],
    /// Points of the identified backbone.
    pub points: usize,
    /// Its smallest and largest amplitude (m/s^2).
    pub amplitudes: [f64; 2],
    /// The backbone itself, amplitudes ascending.
    #[serde(default)]
    pub backbone: Vec<RingDownPoint>,
    /// What is doubtful of the identification.
    pub warnings: Vec<String>,
    /// Differences of the backbones of the run, by name.
    pub theory_minus_ring_down: BTreeMap<String, Misfit>,
    /// What identification makes of a ring-down that has exactly the backbone by CQSMA.
    pub identification_of_cqsma_minus_cqsma: Option<Misfit>,
}

/// A point of an identified backbone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RingDownPoint {
    /// Displacement amplitude at the response point (m), of the acceleration at this frequency.
    pub response_displacement: f64,
    /// Natural frequency (Hz).
    pub frequency_hz: f64,
    /// Damping ratio (-), background included.
    pub damping_ratio: f64,
}

impl RingDownPoint {
    fn of(mean: &MeanPoint) -> Self {
        Self {
            response_displacement: mean.amplitude / (TAU * mean.frequency_hz).powi(2),
            frequency_hz: mean.frequency_hz,
            damping_ratio: mean.damping_ratio,
        }
    }
}

impl RingDownSummary {
    pub(crate) fn of(found: &Result<RingDown, Error>) -> Self {
        let failed = |error: &Error| Some(error.to_string());
        let RingDown { motion, identified } = match found {
            Ok(found) => found,
            Err(error) => {
                return Self {
                    failure: failed(error),
                    ..Self::default()
                };
            }
        };
        let transient = &motion.transient;
        let mut summary = Self {
            failure: identified.as_ref().err().and_then(failed),
            linearised_frequency_hz: motion.frequency_hz,
            step_s: transient.step,
            steps: transient.samples.len().saturating_sub(1),
            halved_steps: transient.halved_steps,
            integration_frequency_ratio: transient.algorithmic.frequency_ratio,
            integration_damping_ratio: transient.algorithmic.damping_ratio,
            energy_error: transient.energy_error(),
            kinetic_elsewhere: transient.share_elsewhere(),
            residual: transient.residual,
            ..Self::default()
        };
        if let Ok(found) = identified {
            let identification = &found.identification;
            summary.band_hz = identification.band_hz;
            summary.points = identification.backbone.len();
            summary.amplitudes = found.backbone.range();
            summary.backbone = found.mean.iter().map(RingDownPoint::of).collect();
            summary.warnings = identification.warnings.iter().map(ToString::to_string).collect();
            summary.theory_minus_ring_down = found.misfits.iter().cloned().collect();
            summary.identification_of_cqsma_minus_cqsma = found.own_error;
        }
        summary
    }
}

impl Linearised<'_> {
    /// The motion of the first mode followed.
    fn motion(&self, settings: &scenes::RingDown, progress: &dyn Progress) -> Result<Motion, Error> {
        progress.begin(Stage::Transient);
        let (scene, line) = (self.scene, self.line);
        let row = self.response;
        let mode = scene.analyses.modes.followed[0] - 1;
        let phi: f64 = line.shapes.col(mode).iter().zip(row).map(|(a, b)| a * b).sum();
        let start = match (settings.strike, settings.release) {
            (Some(Strike { force, contact_time_s }), _) => transient::Start::Pulse {
                // Of a half-sine.
                impulse: force.si() * contact_time_s * 2.0 / PI,
                duration: contact_time_s,
                point: row.to_vec(),
            },
            (None, release) => transient::Start::Release {
                modal_force: line.eigenvalues[mode] * release.map_or(0.0, Length::si) / phi,
            },
        };
        let solver = transient::Settings {
            mode,
            steps_per_period: settings.steps_per_period,
            periods: settings.periods,
            spectral_radius: settings.spectral_radius,
            background_damping: scene.background_damping,
            other_damping: settings.other_damping,
            ..transient::Settings::default()
        };
        let frequency_hz = line.frequencies()[mode];
        let wanted = settings.periods as f64 / frequency_hz;
        let transient = transient::run(line, self.force, row, &start, &solver, &mut |sample| {
            progress.fraction(Stage::Transient, sample.time / wanted);
            flow(progress)
        })?;
        progress.end(Stage::Transient);
        Ok(Motion {
            transient: whole(transient, wanted)?,
            frequency_hz,
        })
    }
}

impl Motion {
    /// Acceleration of the response point.
    pub fn signal(&self) -> Signal {
        signal(
            self.transient.step,
            self.transient.samples.iter().map(|s| s.acceleration).collect(),
        )
    }

    /// How such a signal is identified by default: a band of half the frequency and the shortest smoothing that
    /// still is one, since there is no noise and amplitudes fall fast.
    pub fn identification(&self) -> backbone::Settings {
        backbone::Settings {
            frequency: Some(self.frequency_hz),
            bandwidth: Some(self.frequency_hz / 2.0),
            smoothing: 9,
            ..backbone::Settings::default()
        }
    }

    /// The backbone identified, over acceleration; the frequency error of the time integration, which is known for the
    /// linear mode, is taken out.
    ///
    /// # Errors
    /// [`Error::Identification`], [`Error::Comparison`].
    pub fn identify(&self, settings: &backbone::Settings) -> Result<(Identification, Backbone), Error> {
        let mut found = identify(&self.signal(), settings)?;
        for point in &mut found.backbone {
            point.frequency_hz /= self.transient.algorithmic.frequency_ratio;
        }
        let backbone = of_points("the ring-down", &found.backbone)?;
        Ok((found, backbone))
    }

    /// What identification makes of a ring-down that has exactly the backbone `known` (over acceleration), from the
    /// amplitude that this one begins with and as long.
    ///
    /// # Errors
    /// [`Error::Identification`], [`Error::Comparison`].
    pub fn identified_again(&self, known: &Backbone, settings: &backbone::Settings) -> Result<Backbone, Error> {
        let [low, high] = known.range();
        let at = |amplitude: f64| {
            known
                .at(amplitude.clamp(low, high))
                .unwrap_or((self.frequency_hz, None))
        };
        let samples = &self.transient.samples;
        let ring = synthetic::RingDown {
            amplitude: samples.first().map_or(high, |s| s.acceleration.abs()).min(high),
            phase: 0.0,
            frequency: |a: f64| at(a).0,
            damping_ratio: |a: f64| at(a).1.unwrap_or(0.0),
        };
        let step = self.transient.step;
        let found = identify(&signal(step, ring.samples(1.0 / step, samples.len())), settings)?;
        of_points("the synthetic ring-down", &found.backbone)
    }
}

fn signal(step: f64, samples: Vec<f64>) -> Signal {
    Signal {
        at: "the computed motion".into(),
        quantity: Quantity::Acceleration,
        sample_rate: 1.0 / step,
        samples,
        last_clipped: None,
    }
}

fn of_points(what: &str, points: &[backbone::Point]) -> Result<Backbone, Error> {
    let point = |p: &backbone::Point| Point {
        amplitude: p.amplitude,
        frequency_hz: p.frequency_hz,
        damping_ratio: Some(p.damping_ratio),
    };
    Backbone::try_new(what, points.iter().map(point).collect())
}
