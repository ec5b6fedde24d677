//! Periodic motions about the static state of a scene: EPMC backbones, forced responses and their resonances.

use super::linearised::Linearised;
use super::sensitivities::Sensitivity;
use crate::Error;
use harmonic_balance::aft::PointHistory;
use harmonic_balance::backbone::{self, Accuracy, Kind, Motion, Point};
use harmonic_balance::{Failure, NewtonSettings, Sampling, forced, interface, synthesis};
use joints::progress::{Progress, Stage};
use joints::store::checkpoint::{Checkpoint, Checkpoints};
use joints::store::key::KeyBuilder;
use scenes::{Epmc, Forced};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;

/// Periods that histories are followed for at first; more where they do not repeat.
const PERIODS: usize = 2;

/// Damping ratio below which errors of sampling do not matter.
const DAMPING_FLOOR: f64 = 1e-5;

/// Most harmonics and samples that an accuracy leads to.
const MOST: (usize, usize) = (31, 4096);

/// Smallest share of a harmonic whose maximum is reported.
const LEAST_SHARE: f64 = 1e-3;

/// Intervals between two amplitudes of a backbone in the response of one mode.
const BETWEEN: usize = 16;

/// An EPMC backbone.
#[derive(Clone, Debug)]
pub struct EpmcBackbone {
    /// Amplitudes in ascending order.
    pub points: Vec<Point>,
    /// Displacement amplitude of the first harmonic at the response point (m), where there is a motion.
    pub response_displacement: Vec<Option<f64>>,
    /// Hysteresis loops of single points, amplitude by amplitude, at a few amplitudes.
    pub loops: Vec<PointLoop>,
    /// Derivatives with respect to the parameters of the scene's `sensitivities`, in their order.
    pub sensitivities: Vec<Sensitivity>,
}

/// The loop of a point at an amplitude.
#[derive(Clone, Debug)]
pub struct PointLoop {
    /// Modal amplitude (sqrt(kg) m).
    pub modal_amplitude: f64,
    /// The loop, sample by sample; points are counted from 0.
    pub history: PointHistory,
}

impl Linearised<'_> {
    /// The backbone of free motions that begins as mode `mode` (from 0), at the amplitudes of the scene or else at `otherwise`.
    pub(super) fn epmc(
        &self,
        settings: &Epmc,
        mode: usize,
        otherwise: Vec<f64>,
        key: Option<(&Path, KeyBuilder)>,
        progress: &dyn Progress,
    ) -> Result<(EpmcBackbone, Checkpoints), Error> {
        progress.begin(Stage::Epmc);
        let amplitudes = settings.modal_amplitudes.as_ref().map_or(otherwise, |a| a.values());
        let checkpoint: Checkpoint<Point> = match key {
            None => Checkpoint::default(),
            Some((directory, mut key)) => {
                key.numbers(self.line.displacement().iter().copied());
                key.numbers(self.line.shapes.col(mode).iter().copied());
                key.numbers(amplitudes.iter().copied());
                Checkpoint::open(directory, "epmc", &key.finish())
            }
        };
        let known = checkpoint.leading();
        if !known.is_empty() {
            let (found, all) = (known.len(), amplitudes.len());
            progress.note(&format!(
                "{found} of {all} periodic motions were taken from an interrupted run"
            ));
        }
        let mut done = known.len();
        let points = backbone::follow(
            self.line,
            self.force,
            Kind::Free,
            &amplitudes,
            &backbone::Settings {
                mode,
                sampling: Sampling {
                    harmonics: settings.harmonics,
                    samples: settings.samples,
                    periods: settings.periods,
                },
                accuracy: settings.accuracy.map(|target| Accuracy {
                    frequency: target.frequency,
                    damping: target.damping,
                    damping_floor: DAMPING_FLOOR * target.damping,
                    max_harmonics: MOST.0,
                    max_samples: MOST.1,
                }),
                newton: newton(settings.tolerance),
            },
            known,
            &mut |point| {
                checkpoint.add(done, point);
                done += 1;
                progress.fraction(Stage::Epmc, done as f64 / amplitudes.len() as f64);
                flow(progress)
            },
        )?;
        let first = |motion: &Motion| {
            let along = motion.displacement.along(self.response);
            along[1].hypot(along[2])
        };
        let response_displacement = points.iter().map(|p| p.result.as_ref().ok().map(first)).collect();
        let loops = self.loops(settings, &points);
        progress.end(Stage::Epmc);
        let (_, checkpoints) = checkpoint.complete();
        Ok((
            EpmcBackbone {
                points,
                response_displacement,
                loops,
                sensitivities: Vec::new(),
            },
            checkpoints,
        ))
    }

    /// Loops of the points asked for at the largest amplitude and two smaller ones.
    fn loops(&self, settings: &Epmc, points: &[Point]) -> Vec<PointLoop> {
        let motions: Vec<&Motion> = points.iter().filter_map(|p| p.result.as_ref().ok()).collect();
        let Some(last) = motions.last() else { return Vec::new() };
        let wanted = settings
            .loops_at
            .as_ref()
            .map(|points| points.iter().map(|p| p - 1).collect());
        let wanted: Vec<usize> = wanted.unwrap_or_else(|| {
            let flux = interface::dissipation(self.line, self.force, &last.displacement, last.sampling);
            let total = |point: usize| flux.iter().map(|f| f[point]).sum::<f64>();
            let most = (0..flux[0].len()).max_by(|a, b| total(*a).total_cmp(&total(*b)));
            most.into_iter().collect()
        });
        let mut chosen: Vec<usize> = [motions.len() / 2, 3 * motions.len() / 4, motions.len() - 1].into();
        chosen.dedup();
        let of = |index: usize| {
            let motion = motions[index];
            let found = interface::histories(self.line, self.force, &motion.displacement, motion.sampling, &wanted);
            found.into_iter().map(|history| PointLoop {
                modal_amplitude: motion.modal_amplitude,
                history,
            })
        };
        chosen.into_iter().flat_map(of).collect()
    }

    /// Forced responses at all levels; `free` are EPMC backbones, from which those of one mode follow.
    pub(super) fn forced(
        &self,
        settings: &Forced,
        free: &[&EpmcBackbone],
        key: Option<(&Path, KeyBuilder)>,
        progress: &dyn Progress,
    ) -> Result<(Vec<ForcedResponse>, Checkpoints), Error> {
        progress.begin(Stage::Forced);
        let row: Vec<f64> = match self.vibrating.recovery.nrows() {
            1 => self.response.to_vec(),
            _ => self.vibrating.recovery.row(1).iter().copied().collect(),
        };
        let range = [TAU * settings.from_hz, TAU * settings.to_hz];
        let background = self.scene.background_damping;
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
        let found = |backbone: &&EpmcBackbone| -> Vec<Motion> {
            let motions = backbone.points.iter().filter_map(|p| p.result.as_ref().ok());
            motions.cloned().collect()
        };
        let begins_inside = |motions: &Vec<Motion>| {
            let first = motions.first().map(|m| (m.omega - range[0]) * (m.omega - range[1]));
            first.is_some_and(|side| side <= 0.0)
        };
        let motions = free.iter().map(found).find(begins_inside).unwrap_or_default();
        let motions: Vec<&Motion> = motions.iter().collect();
        // What the viscous damping is of the mode alone.
        let omega = motions.first().map_or(1.0, |m| m.omega);
        let [of_mass, of_stiffness] = solver.rayleigh;
        let viscous = background + 0.5 * (of_mass / omega + of_stiffness * omega);
        let checkpoint: Checkpoint<ForcedResponse> = match key {
            None => Checkpoint::default(),
            Some((directory, mut key)) => {
                key.numbers(self.line.displacement().iter().copied());
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
            let curve = forced::follow(self.line, self.force, &row, level, &solver, &mut |point| {
                let way = (point.omega - range[0]) / (range[1] - range[0]);
                progress.fraction(Stage::Forced, (index as f64 + way.clamp(0.0, 1.0)) / levels as f64);
                flow(progress)
            })?;
            let resonances = forced::resonances(self.line, self.force, &row, &curve, &solver)?;
            let synthesis = synthesis::response(&motions, &row, self.response, level, viscous, BETWEEN)
                .into_iter()
                .filter(|p| (p.omega - range[0]) * (p.omega - range[1]) <= 0.0)
                .collect();
            let response = ForcedResponse::new(self.response, curve, &resonances, synthesis);
            checkpoint.add(index, &response);
            responses.push(response);
        }
        progress.end(Stage::Forced);
        let (_, checkpoints) = checkpoint.complete();
        Ok((responses, checkpoints))
    }
}

fn newton(tolerance: f64) -> NewtonSettings {
    NewtonSettings {
        tolerance,
        ..NewtonSettings::default()
    }
}

fn flow(progress: &dyn Progress) -> ControlFlow<()> {
    if progress.interrupted() {
        ControlFlow::Break(())
    } else {
        ControlFlow::Continue(())
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
