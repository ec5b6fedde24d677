//! Responses of a scene's structure to harmonic forces, about its static state.

use super::epmc::EpmcBackbone;
use super::linearised::{flow, newton};
use super::vibration::{Start, VibrationAnalysis};
use crate::Error;
use harmonic_balance::backbone::Motion;
use harmonic_balance::{Failure, Sampling, forced, synthesis};
use joints::progress::Stage;
use joints::store::checkpoint::{Checkpoint, Checkpoints};
use scenes::Forced;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Periods that histories are followed for at first; more where they do not repeat.
const PERIODS: usize = 2;

/// Smallest share of a harmonic whose maximum is reported.
const LEAST_SHARE: f64 = 1e-3;

/// Intervals between two amplitudes of a backbone in the response of one mode.
const BETWEEN: usize = 16;

impl VibrationAnalysis for Forced {
    type Found = Vec<ForcedResponse>;

    /// The responses at all levels. Those of one mode follow from the EPMC backbones.
    fn run(&self, start: Start<'_>) -> Result<(Self::Found, Checkpoints), Error> {
        let (about, progress, settings) = (start.about, start.progress, self);
        let free = start.modes.iter().filter_map(|mode| mode.epmc.as_ref());
        progress.begin(Stage::Forced);
        let row: Vec<f64> = match about.vibrating.recovery.nrows() {
            1 => about.response.to_vec(),
            _ => about.vibrating.recovery.row(1).iter().copied().collect(),
        };
        let range = [TAU * settings.from_hz, TAU * settings.to_hz];
        let background = about.scene.background_damping;
        let solver = forced::Settings {
            range,
            sampling: Sampling {
                harmonics: settings.harmonics,
                samples: settings.samples,
                periods: PERIODS,
            },
            background,
            rayleigh: settings.rayleigh.map_or([0.0; 2], |c| [c.mass, c.stiffness]),
            amplitude_step: settings.amplitude_step,
            frequency_step: settings.frequency_step,
            newton: newton(settings.tolerance),
            ..forced::Settings::default()
        };
        // The backbone that begins between the frequencies of the responses: the others belong to other resonances.
        let found = |backbone: &EpmcBackbone| -> Vec<Motion> {
            let motions = backbone.points.iter().filter_map(|p| p.result.as_ref().ok());
            motions.cloned().collect()
        };
        let begins_inside = |motions: &Vec<Motion>| {
            let first = motions.first().map(|m| (m.omega - range[0]) * (m.omega - range[1]));
            first.is_some_and(|side| side <= 0.0)
        };
        let motions = free.map(found).find(begins_inside).unwrap_or_default();
        let motions: Vec<&Motion> = motions.iter().collect();
        // What the viscous damping is of the mode alone.
        let omega = motions.first().map_or(1.0, |m| m.omega);
        let [of_mass, of_stiffness] = solver.rayleigh;
        let viscous = background + 0.5 * (of_mass / omega + of_stiffness * omega);
        let checkpoint: Checkpoint<ForcedResponse> = match start.kept {
            None => Checkpoint::default(),
            Some((directory, mut key)) => {
                key.numbers(about.line.displacement().iter().copied());
                key.numbers(row.iter().copied());
                Checkpoint::open(directory, "forced", &key.finish())
            }
        };
        let mut responses = checkpoint.leading();
        let levels = settings.levels.len();
        if !responses.is_empty() {
            let found = responses.len();
            progress.note(&format!(
                "{found} of {levels} forced responses were taken from an interrupted run"
            ));
        }
        for (index, level) in settings.levels.iter().enumerate().skip(responses.len()) {
            let level = level.si();
            let curve = forced::follow(about.line, about.force, &row, level, &solver, &mut |point| {
                let way = (point.omega - range[0]) / (range[1] - range[0]);
                progress.fraction(Stage::Forced, (index as f64 + way.clamp(0.0, 1.0)) / levels as f64);
                flow(progress)
            })?;
            let resonances = forced::resonances(about.line, about.force, &row, &curve, &solver)?;
            let synthesis = synthesis::response(&motions, &row, about.response, level, viscous, BETWEEN)
                .into_iter()
                .filter(|p| (p.omega - range[0]) * (p.omega - range[1]) <= 0.0)
                .collect();
            let response = ForcedResponse::new(about.response, curve, &resonances, synthesis);
            checkpoint.add(index, &response);
            responses.push(response);
        }
        progress.end(Stage::Forced);
        let (_, checkpoints) = checkpoint.complete();
        Ok((responses, checkpoints))
    }
}

/// The response to a force of one amplitude.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ForcedResponse {
    /// Amplitude of the force (N).
    pub level: f64,
    /// Points in the order in which they follow one another on the curve.
    pub points: Vec<ForcedPoint>,
    /// Where the response is a quarter period behind the force.
    pub resonances: Vec<Result<ForcedPoint, Failure>>,
    /// The response of the nonlinear mode alone, where there is an EPMC backbone.
    pub synthesis: Vec<synthesis::Point>,
    /// Why the curve ends early, if it does.
    pub failure: Option<Failure>,
    /// Work done.
    pub effort: harmonic_balance::Effort,
}

/// The motion of the response point under a force.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ForcedPoint {
    /// Frequency of the force (Hz).
    pub frequency_hz: f64,
    /// Amplitudes of the displacement's harmonics from the first on (m).
    pub harmonics: Vec<f64>,
    /// Cosines and sines of these harmonics (m).
    pub components: Vec<[f64; 2]>,
    /// How far the first lags behind the force (rad), from 0 to 2 pi.
    pub phase: f64,
    /// Mean displacement from the static state (m).
    pub mean: f64,
    /// Residual relative to the elastic forces (energy norm).
    pub residual: f64,
    /// Whether the frequency turns back here.
    pub turns: bool,
}

impl ForcedPoint {
    fn new(row: &[f64], omega: f64, displacement: &harmonic_balance::Harmonics, residual: f64, turns: bool) -> Self {
        let along = displacement.along(row);
        let amplitude = |h: usize| along[2 * h - 1].hypot(along[2 * h]);
        Self {
            frequency_hz: omega / TAU,
            harmonics: (1..=displacement.count()).map(amplitude).collect(),
            components: (1..=displacement.count())
                .map(|h| [along[2 * h - 1], along[2 * h]])
                .collect(),
            phase: along[2].atan2(along[1]).rem_euclid(TAU),
            mean: along[0],
            residual,
            turns,
        }
    }
}

impl ForcedResponse {
    fn new(
        row: &[f64],
        curve: forced::Curve,
        resonances: &[Result<forced::Resonance, Failure>],
        synthesis: Vec<synthesis::Point>,
    ) -> Self {
        let point = |p: &forced::Point| ForcedPoint::new(row, p.omega, &p.displacement, p.residual, p.turns);
        let resonance = |r: &forced::Resonance| ForcedPoint::new(row, r.omega, &r.displacement, r.residual, false);
        let mut points: Vec<ForcedPoint> = curve.points.iter().map(point).collect();
        // Resonances are points of the curve too; from the last to the first, so that the indices hold.
        for found in resonances.iter().flatten().rev() {
            points.insert(found.after + 1, resonance(found));
        }
        Self {
            level: curve.force,
            points,
            resonances: resonances
                .iter()
                .map(|r| r.as_ref().map(resonance).map_err(Clone::clone))
                .collect(),
            synthesis,
            failure: curve.failure,
            effort: curve.effort,
        }
    }

    /// Where the share of a harmonic above the first has a maximum: number of the harmonic, and the point. Small ones are left out.
    pub fn superharmonics(&self) -> Vec<(usize, &ForcedPoint)> {
        let highest = self.points.first().map_or(0, |p| p.harmonics.len());
        let share = |p: &ForcedPoint, h: usize| p.harmonics[h - 1] / p.harmonics[0];
        let maxima = |h: usize| {
            let inner = self.points.windows(3).filter(move |p| {
                let [before, here, after] = [&p[0], &p[1], &p[2]].map(|p| share(p, h));
                here > LEAST_SHARE && here > before && here >= after
            });
            inner.map(move |p| (h, &p[1]))
        };
        (2..=highest).flat_map(maxima).collect()
    }

    /// The point of the largest first harmonic.
    pub fn peak(&self) -> Option<&ForcedPoint> {
        self.points
            .iter()
            .max_by(|a, b| a.harmonics[0].total_cmp(&b.harmonics[0]))
    }
}

/// The response to a harmonic force of one amplitude; lists run along the curve.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ForcedSummary {
    /// Amplitude of the force (N).
    pub level: f64,
    /// Frequencies of the force (Hz).
    pub frequency: Vec<f64>,
    /// Amplitudes of the first harmonic of the displacement at the response point (m).
    pub amplitude: Vec<f64>,
    /// How far it lags behind the force (degrees).
    pub phase: Vec<f64>,
    /// Amplitudes of all harmonics of the displacement from the first on (m).
    pub harmonics: Vec<Vec<f64>>,
    /// Cosines and sines of the same harmonics, the force being a cosine (m).
    #[serde(default)]
    pub components: Vec<Vec<[f64; 2]>>,
    /// Mean displacements at the response point from the static state (m).
    #[serde(default)]
    pub mean: Vec<f64>,
    /// Residuals relative to the elastic forces (energy norm).
    pub residual: Vec<f64>,
    /// Indices, from 0, of the points at which the frequency turns back.
    pub turning_points: Vec<usize>,
    /// Where the response is a quarter period behind the force.
    pub resonances: Vec<ResonanceSummary>,
    /// Where the share of a harmonic above the first has a maximum of more than a thousandth.
    #[serde(default)]
    pub superharmonics: Vec<SuperharmonicSummary>,
    /// The largest first harmonic of the curve: frequency (Hz) and amplitude (m).
    pub peak: Option<[f64; 2]>,
    /// The same by the response of the nonlinear mode alone, where an EPMC backbone is there.
    pub single_mode_peak: Option<[f64; 2]>,
    /// Differences of the two, relative to the first.
    pub single_mode_error: Option<[f64; 2]>,
    /// Whether it is known that the motions are stable: never with friction, whose histories have no monodromy matrix; between
    /// turning points they usually are not.
    pub stability: String,
    /// Krylov steps of the whole curve.
    pub krylov_steps: usize,
    /// Why the curve ends early, if it does.
    pub failure: Option<String>,
}

/// A maximum of the share of a harmonic.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SuperharmonicSummary {
    /// The harmonic.
    pub harmonic: usize,
    /// Frequency of the force there (Hz).
    pub frequency_hz: f64,
    /// Amplitude of the harmonic over that of the first, at the response point.
    pub share: f64,
}

/// A resonance of a forced response.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ResonanceSummary {
    /// Frequency (Hz); `null` where it was not found.
    pub frequency_hz: Option<f64>,
    /// Amplitude of the first harmonic (m).
    pub amplitude: Option<f64>,
    /// Residual relative to the elastic forces (energy norm).
    pub residual: Option<f64>,
    /// Why there is none.
    pub failure: Option<String>,
}

impl ForcedSummary {
    pub(crate) fn of(of: &ForcedResponse) -> Self {
        let each = |value: &dyn Fn(&ForcedPoint) -> f64| of.points.iter().map(value).collect::<Vec<f64>>();
        let peak = of.peak().map(|p| [p.frequency_hz, p.harmonics[0]]);
        let alone = of
            .synthesis
            .iter()
            .max_by(|a, b| a.displacement.total_cmp(&b.displacement));
        let alone = alone.map(|p| [p.omega / TAU, p.displacement]);
        let resonance = |found: &Result<ForcedPoint, _>| {
            let point = found.as_ref().ok();
            ResonanceSummary {
                frequency_hz: point.map(|p: &ForcedPoint| p.frequency_hz),
                amplitude: point.map(|p| p.harmonics[0]),
                residual: point.map(|p| p.residual),
                failure: found.as_ref().err().map(|f: &Failure| f.reason.to_string()),
            }
        };
        Self {
        level: of.level,
        frequency: each(&|p| p.frequency_hz),
        amplitude: each(&|p| p.harmonics[0]),
        phase: each(&|p| p.phase.to_degrees()),
        harmonics: of.points.iter().map(|p| p.harmonics.clone()).collect(),
        components: of.points.iter().map(|p| p.components.clone()).collect(),
        mean: each(&|p| p.mean),
        residual: each(&|p| p.residual),
        turning_points: (0..of.points.len()).filter(|i| of.points[*i].turns).collect(),
        resonances: of.resonances.iter().map(resonance).collect(),
        superharmonics: of
            .superharmonics()
            .into_iter()
            .map(|(harmonic, point)| SuperharmonicSummary {
                harmonic,
                frequency_hz: point.frequency_hz,
                share: point.harmonics[harmonic - 1] / point.harmonics[0],
            })
            .collect(),
        single_mode_error: peak.zip(alone).map(|(p, a)| [a[0] / p[0] - 1.0, a[1] / p[1] - 1.0]),
        peak,
        single_mode_peak: alone,
        stability: "not judged: the history of friction has no monodromy matrix; motions between two turning points are usually unstable"
            .to_owned(),
        krylov_steps: of.effort.krylov_steps,
        failure: of.failure.as_ref().map(|f| f.reason.to_string()),
    }
    }
}
