//! Responses of a scene's structure to harmonic forces, or to harmonic motion of its supports, about its static state.
//!
//! Under an acceleration `a` of the supports along `d`, displacements `u` against them obey `M u'' + K u + F(u) = -M r a` with the translation `r` of
//! everything along `d`; seen from outside they are `u + r a / (i omega)^2`. The supports push with the rate of the whole momentum,
//! `r^T M (u'' + r a)`.

use super::epmc::EpmcBackbone;
use super::linearised::{Base, Drive, Linearised, flow, newton};
use super::sweep::Swept;
use super::vibration::{Start, VibrationAnalysis};
use crate::Error;
use harmonic_balance::backbone::Motion;
use harmonic_balance::forced::Held;
use harmonic_balance::points::{Between, Finder, LEAST_SHARE, OpenPeak};
use harmonic_balance::stability::{self, Bifurcation, Exponent};
use harmonic_balance::{Failure, Harmonics, Load, Sampling, forced, synthesis};
use joints::progress::Stage;
use joints::store::checkpoint::{Checkpoint, Checkpoints};
use scenes::Forced;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Periods that histories are followed for.
const PERIODS: usize = 2;

/// Intervals between two amplitudes of a backbone in the response of one mode.
const BETWEEN: usize = 16;

impl VibrationAnalysis for Forced {
    type Found = Vec<ForcedResponse>;

    /// The responses at all levels. Those of one mode follow from the EPMC backbones.
    fn run(&self, start: Start<'_>) -> Result<(Self::Found, Checkpoints), Error> {
        let (about, progress, settings) = (start.about, start.progress, self);
        let free = (start.modes.iter()).filter_map(|mode| Some((mode.background, mode.epmc.as_ref()?)));
        progress.begin(Stage::Forced);
        let (load, base) = load(settings, about);
        let range = settings.range_hz().map(|hz| TAU * hz);
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
        let found = |(background, backbone): (f64, &EpmcBackbone)| -> (f64, Vec<Motion>) {
            let motions = backbone.points.iter().filter_map(|p| p.result.as_ref().ok());
            (background, motions.cloned().collect())
        };
        let begins_inside = |(_, motions): &(f64, Vec<Motion>)| {
            let first = motions.first().map(|m| (m.omega - range[0]) * (m.omega - range[1]));
            first.is_some_and(|side| side <= 0.0)
        };
        let (of_mode, motions) = free.map(found).find(begins_inside).unwrap_or_default();
        let motions: Vec<&Motion> = motions.iter().collect();
        // What the viscous damping is of the mode alone.
        let omega = motions.first().map_or(1.0, |m| m.omega);
        let [of_mass, of_stiffness] = solver.rayleigh;
        let viscous = of_mode + 0.5 * (of_mass / omega + of_stiffness * omega);
        let checkpoint: Checkpoint<ForcedResponse> = match start.kept {
            None => Checkpoint::default(),
            Some((directory, mut key)) => {
                key.numbers(about.line.displacement().iter().copied());
                key.numbers(load.cosine.iter().chain(&load.sine).copied());
                key.numbers(about.line.dampers.iter().flatten().copied());
                Checkpoint::open(directory, "forced", &key.finish())
            }
        };
        let mut responses = checkpoint.leading();
        let levels = settings.levels();
        if !responses.is_empty() {
            let found = responses.len();
            let all = levels.len();
            progress.note(&format!(
                "{found} of {all} forced responses were taken from an interrupted run"
            ));
        }
        for (index, &level) in levels.iter().enumerate().skip(responses.len()) {
            // A sweep takes the second half of a level's share.
            let share = if settings.sweep.is_some() { 0.5 } else { 1.0 };
            let done = |way: f64| progress.fraction(Stage::Forced, (index as f64 + way) / levels.len() as f64);
            let held = match settings.held() {
                scenes::Held::Response => Held::Response {
                    row: about.response,
                    amplitude: level,
                },
                _ => Held::Force(level),
            };
            let mut way = Way::new(about, &solver);
            let mut curve = forced::follow(about.line, about.force, &load, held, &solver, &mut |point| {
                done(share * way.at(point));
                flow(progress)
            })?;
            let mut finder = Finder::try_new(about.line, about.force, &load, held, &solver)?;
            let open_peaks = finder.resolve_peaks(&mut curve, about.response)?;
            let resonances = finder.resonances(&curve)?;
            // Resonances are points of the curve too; from the last to the first, so that the indices hold.
            for found in resonances.iter().flatten().rev() {
                curve.insert(found.after, found.point.clone());
            }
            let mut at_frequencies = Vec::new();
            for hz in &settings.frequencies_hz {
                at_frequencies.extend(finder.at(&curve, TAU * hz)?);
            }
            let exponents = match settings.stability {
                true => Some(finder.exponents(&curve, &mut |_| flow(progress))?),
                false => None,
            };
            let alone = match held {
                Held::Force(force) if !load.is_unbalance => {
                    synthesis::response(&motions, &load, about.response, force, viscous, BETWEEN)
                }
                _ => Vec::new(),
            };
            let synthesis = alone
                .into_iter()
                .filter(|p| (p.omega - range[0]) * (p.omega - range[1]) <= 0.0)
                .collect();
            let observed = Observed {
                row: about.response,
                load: &load.cosine,
                base,
                level,
            };
            let apart = [resonances.as_slice(), &at_frequencies];
            let swept = match &settings.sweep {
                Some(sweep) => {
                    Some(
                        about.sweep(sweep, (&load.cosine, level), range, (&curve, &resonances), &mut |way| {
                            done(share + (1.0 - share) * way);
                            flow(progress)
                        })?,
                    )
                }
                None => None,
            };
            let mut response = ForcedResponse::new(&observed, curve, apart, exponents, synthesis);
            response.open_peaks = open_peaks;
            response.sweep = swept;
            checkpoint.add(index, &response);
            responses.push(response);
        }
        progress.end(Stage::Forced);
        let (_, checkpoints) = checkpoint.complete();
        Ok((responses, checkpoints))
    }
}

/// Points of a resonance, by experience.
pub(super) const OF_RESONANCE: f64 = 20.0;

/// How far a curve is followed: by its frequency, and by the phase, which turns by half a period at each resonance.
struct Way<'a> {
    response: &'a [f64],
    range: [f64; 2],
    /// Points for the whole range, without those of the phase.
    of_range: f64,
    /// By how much the resonances in the range turn the phase (rad).
    turns: f64,
    phase: Option<f64>,
    /// By how much it has turned.
    turned: f64,
}

impl<'a> Way<'a> {
    fn new(about: Linearised<'a>, settings: &forced::Settings) -> Self {
        let [from, to] = settings.range;
        let is_inside = |square: &&f64| (square.sqrt() - from) * (square.sqrt() - to) < 0.0;
        let resonances = about.line.eigenvalues.iter().filter(is_inside).count() as f64;
        let steps = (to / from).ln().abs() / settings.frequency_step;
        Self {
            response: about.response,
            range: settings.range,
            // On its way to resonances the motion grows in as many steps at least.
            of_range: steps.max(OF_RESONANCE * resonances).max(1.0),
            turns: PI * resonances,
            phase: None,
            turned: 0.0,
        }
    }

    /// The part of the curve that ends at a new point, from 0 to 1.
    fn at(&mut self, point: &forced::Point) -> f64 {
        let along = point.displacement.along(self.response);
        let phase = along[2].atan2(along[1]);
        if let Some(before) = self.phase.replace(phase) {
            let turn = (phase - before).rem_euclid(TAU);
            self.turned += turn.min(TAU - turn);
        }
        let [from, to] = self.range;
        let of_range = ((point.omega / from).ln() / (to / from).ln()).clamp(0.0, 1.0);
        let of_phase = OF_RESONANCE / PI;
        (self.of_range * of_range + of_phase * self.turned.min(self.turns)) / (self.of_range + of_phase * self.turns)
    }
}

/// The load of a response per unit of its level, and what moves with the supports if these move.
fn load(settings: &Forced, about: Linearised<'_>) -> (Load, Option<Base>) {
    let n = about.response.len();
    let mut load = Load {
        cosine: vec![0.0; n],
        sine: vec![0.0; n],
        is_unbalance: settings.held() == scenes::Held::Unbalance,
    };
    let mut moving = None;
    for (excitation, [cosine, sine]) in settings.excitations() {
        let Drive { row, base } = about.drive(&excitation);
        for (i, value) in row.iter().enumerate() {
            load.cosine[i] += cosine * value;
            load.sine[i] += sine * value;
        }
        moving = moving.or(base);
    }
    (load, moving)
}

/// The response to an excitation of one amplitude.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ForcedResponse {
    /// Amplitude of the force (N), of the acceleration of the supports (m/s^2), of the unbalance (kg m), or of the response (m): what is held.
    pub level: f64,
    /// Points in the order in which they follow one another on the curve.
    pub points: Vec<ForcedPoint>,
    /// Where the response is a quarter period behind the force.
    pub resonances: Vec<Result<ForcedPoint, Failure>>,
    /// At the frequencies asked for, on each branch.
    pub at_frequencies: Vec<Result<ForcedPoint, Failure>>,
    /// Peaks whose height is not known to a thousandth.
    pub open_peaks: Vec<OpenPeak>,
    /// The response of the nonlinear mode alone, where there is an EPMC backbone.
    pub synthesis: Vec<synthesis::Point>,
    /// What a sweep finds, if one is asked for.
    pub sweep: Option<Swept>,
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
    /// Amplitude of the force (N), or of the acceleration of the supports (m/s^2).
    pub force: f64,
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
    /// What contact and viscous damping take over a period less what is put in, in the unit of damping ratios.
    pub energy_error: f64,
    /// Under moving supports, what is seen from outside.
    pub outside: Option<Outside>,
    /// Whether the frequency turns back here.
    pub turns: bool,
    /// Floquet exponents, where the stability is judged.
    pub exponents: Option<Result<Vec<Exponent>, Failure>>,
}

/// A motion under moving supports, seen from outside.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Outside {
    /// Amplitude of the first harmonic of the displacement of the response point (m).
    pub amplitude: f64,
    /// How far it lags behind that of the supports (rad), from 0 to 2 pi.
    pub phase: f64,
    /// Its amplitude over that of the supports.
    pub transmissibility: f64,
    /// Amplitude of the first harmonic of the force that the supports put on the structure along their motion (N), where its mass is known.
    pub support_force: Option<f64>,
}

/// What is seen of a motion.
struct Observed<'a> {
    /// Recovers the displacement of the response point.
    row: &'a [f64],
    /// Load per level.
    load: &'a [f64],
    base: Option<Base>,
    level: f64,
}

impl Observed<'_> {
    /// What is seen from outside of a motion with `[cosine, sine]` of the first harmonic at the response point.
    fn outside(&self, base: Base, omega: f64, [c, s]: [f64; 2], displacement: &Harmonics) -> Outside {
        let supports = -self.level / (omega * omega);
        let c = c + base.carried * supports;
        let amplitude = c.hypot(s);
        // The load is minus the momentum.
        let momentum = displacement.along(self.load);
        let force = base.mass.map(|mass| {
            let rate = omega * omega;
            (rate * momentum[1] + mass * self.level).hypot(rate * momentum[2])
        });
        Outside {
            amplitude,
            phase: (-s).atan2(-c).rem_euclid(TAU),
            transmissibility: amplitude / supports.abs(),
            support_force: force,
        }
    }
}

impl ForcedPoint {
    fn new(of: &Observed<'_>, point: &forced::Point) -> Self {
        let forced::Point {
            omega,
            force,
            ref displacement,
            residual,
            energy_error,
            turns,
            ..
        } = *point;
        let along = displacement.along(of.row);
        let pair = |h: usize| [along[2 * h - 1], along[2 * h]];
        let components: Vec<[f64; 2]> = (1..=displacement.count()).map(pair).collect();
        let [c, s] = components[0];
        // Inertia acts against the acceleration of the supports.
        let sign = if of.base.is_some() { -1.0 } else { 1.0 };
        Self {
            frequency_hz: omega / TAU,
            force,
            harmonics: components.iter().map(|[c, s]| c.hypot(*s)).collect(),
            phase: (sign * s).atan2(sign * c).rem_euclid(TAU),
            mean: along[0],
            residual,
            energy_error,
            outside: of.base.map(|base| of.outside(base, omega, [c, s], displacement)),
            turns,
            exponents: None,
            components,
        }
    }
}

/// Points of a curve that were found apart, or why not.
type FoundApart = [Result<Between, Failure>];

impl ForcedResponse {
    fn new(
        of: &Observed<'_>,
        curve: forced::Curve,
        [resonances, at_frequencies]: [&FoundApart; 2],
        exponents: Option<Vec<Result<Vec<Exponent>, Failure>>>,
        synthesis: Vec<synthesis::Point>,
    ) -> Self {
        let mut points: Vec<ForcedPoint> = curve.points.iter().map(|p| ForcedPoint::new(of, p)).collect();
        for (point, exponents) in points.iter_mut().zip(exponents.into_iter().flatten()) {
            point.exponents = Some(exponents);
        }
        let apart = |found: &FoundApart| {
            let point = |r: &Result<Between, Failure>| match r {
                Ok(found) => Ok(ForcedPoint::new(of, &found.point)),
                Err(failure) => Err(failure.clone()),
            };
            found.iter().map(point).collect()
        };
        Self {
            level: of.level,
            points,
            resonances: apart(resonances),
            at_frequencies: apart(at_frequencies),
            open_peaks: Vec::new(),
            sweep: None,
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

/// The response to a harmonic force, or to harmonic motion of the supports, of one amplitude; lists run along the curve. Under moving supports,
/// displacements are those against the supports, and the force is that of inertia, minus their acceleration.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ForcedSummary {
    /// What is held: the amplitude of the force (N), of the acceleration of the supports (m/s^2), of the unbalance (kg m), or of the first harmonic of the
    /// response (m).
    pub level: f64,
    /// Unit of the level: `N`, `m/s^2`, `kg m` or `m`.
    #[serde(default = "newton_unit")]
    pub level_unit: String,
    /// Frequencies of the force (Hz).
    pub frequency: Vec<f64>,
    /// Amplitudes of the force (N), of the acceleration of the supports (m/s^2), or of the unbalance (kg m).
    #[serde(default)]
    pub force: Vec<f64>,
    /// Amplitudes of the first harmonic of the displacement at the response point (m).
    pub amplitude: Vec<f64>,
    /// How far it lags behind the force (degrees).
    pub phase: Vec<f64>,
    /// Amplitudes of all harmonics of the displacement from the first on (m).
    pub harmonics: Vec<Vec<f64>>,
    /// Cosines and sines of the same harmonics, the force or the acceleration of the supports being a cosine (m).
    #[serde(default)]
    pub components: Vec<Vec<[f64; 2]>>,
    /// Mean displacements at the response point from the static state (m).
    #[serde(default)]
    pub mean: Vec<f64>,
    /// Residuals relative to the elastic forces (energy norm).
    pub residual: Vec<f64>,
    /// What contact and viscous damping take over a period less what is put in, over `4 pi` times the energy of the first harmonic: an error in the unit of
    /// damping ratios (-).
    #[serde(default)]
    pub energy_error: Vec<f64>,
    /// Under moving supports, what is seen from outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<OutsideSummary>,
    /// Indices, from 0, of the points at which the frequency turns back.
    pub turning_points: Vec<usize>,
    /// Where the response is a quarter period behind the force; of several forces, where nothing of it is in phase with them.
    pub resonances: Vec<PointSummary>,
    /// At the frequencies asked for, on each branch of the curve.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at_frequencies: Vec<PointSummary>,
    /// Where the share of a harmonic above the first has a maximum of more than a thousandth.
    #[serde(default)]
    pub superharmonics: Vec<SuperharmonicSummary>,
    /// Peaks of the first harmonic, and of shares of the others, whose height is not known to a thousandth: number of the harmonic and frequency (Hz).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub open_peaks: Vec<(usize, f64)>,
    /// What a sweep finds, if one is asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<Swept>,
    /// The largest first harmonic of the curve: frequency (Hz) and amplitude (m).
    pub peak: Option<[f64; 2]>,
    /// The same by the response of the nonlinear mode alone, where an EPMC backbone is there.
    pub single_mode_peak: Option<[f64; 2]>,
    /// Differences of the two, relative to the first.
    pub single_mode_error: Option<[f64; 2]>,
    /// What is known of the stability of the motions.
    pub stability: String,
    /// The stability, where it is judged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floquet: Option<FloquetSummary>,
    /// Krylov steps of the whole curve.
    pub krylov_steps: usize,
    /// Why the curve ends early, if it does.
    pub failure: Option<String>,
}

fn newton_unit() -> String {
    "N".to_owned()
}

/// Motion under moving supports seen from outside; lists run along the curve.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OutsideSummary {
    /// Amplitudes of the first harmonic of the displacement of the response point (m).
    pub amplitude: Vec<f64>,
    /// The same over the displacement of the supports (-).
    pub transmissibility: Vec<f64>,
    /// How far it lags behind that of the supports (degrees).
    pub phase: Vec<f64>,
    /// Amplitudes of the first harmonic of the force that the supports put on the structure along their motion (N); `null` where its mass is not known.
    pub support_force: Vec<Option<f64>>,
}

impl OutsideSummary {
    fn of(points: &[ForcedPoint]) -> Option<Self> {
        let all: Vec<Outside> = points.iter().map(|point| point.outside).collect::<Option<_>>()?;
        Some(Self {
            amplitude: all.iter().map(|p| p.amplitude).collect(),
            transmissibility: all.iter().map(|p| p.transmissibility).collect(),
            phase: all.iter().map(|p| p.phase.to_degrees()).collect(),
            support_force: all.iter().map(|p| p.support_force).collect(),
        })
    }
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

/// Stability of the motions of a curve; lists run along it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FloquetSummary {
    /// Whether each motion is stable; `null` where it is not known.
    pub stable: Vec<Option<bool>>,
    /// Floquet multipliers, real and imaginary part, one or a pair (of which the upper one is given) for each mode that the harmonics reach; empty where
    /// they were not found.
    pub multipliers: Vec<Vec<[f64; 2]>>,
    /// Estimates of their errors, relative to them.
    pub errors: Vec<Vec<f64>>,
    /// Where the stability changes.
    pub bifurcations: Vec<BifurcationSummary>,
}

/// A change of the stability between two points of a curve.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BifurcationSummary {
    /// `fold` (a multiplier passes 1: the curve turns back or branches), `period doubling` (one passes -1) or `Neimark-Sacker` (a pair passes the unit circle). The
    /// curve is followed through all of them; branches of other periods are not.
    pub kind: String,
    /// Index, from 0, of the point before it.
    pub after: usize,
    /// Frequencies of the points before and after it (Hz).
    pub frequency_hz: [f64; 2],
}

impl FloquetSummary {
    fn of(points: &[ForcedPoint]) -> Option<Self> {
        let all: Vec<&Result<Vec<Exponent>, Failure>> =
            points.iter().map(|p| p.exponents.as_ref()).collect::<Option<_>>()?;
        let omega = |i: usize| TAU * points[i].frequency_hz;
        let each = |found: &Result<Vec<Exponent>, Failure>| found.as_deref().unwrap_or_default().to_vec();
        let found: Vec<Vec<Exponent>> = all.iter().map(|found| each(found)).collect();
        let between = |i: usize| {
            let kind = stability::bifurcation((omega(i), &found[i]), (omega(i + 1), &found[i + 1]))?;
            let is_known = !found[i].is_empty() && !found[i + 1].is_empty();
            is_known.then(|| BifurcationSummary {
                kind: match kind {
                    Bifurcation::Fold => "fold",
                    Bifurcation::PeriodDoubling => "period doubling",
                    Bifurcation::NeimarkSacker => "Neimark-Sacker",
                }
                .to_owned(),
                after: i,
                frequency_hz: [points[i].frequency_hz, points[i + 1].frequency_hz],
            })
        };
        let multipliers = |i: usize| found[i].iter().map(|e| e.multiplier(omega(i))).collect();
        let errors = |i: usize| found[i].iter().map(|e| e.error * TAU / omega(i)).collect();
        Some(Self {
            stable: found.iter().map(|of| stability::is_stable(of)).collect(),
            multipliers: (0..points.len()).map(multipliers).collect(),
            errors: (0..points.len()).map(errors).collect(),
            bifurcations: (0..points.len().saturating_sub(1)).filter_map(between).collect(),
        })
    }

    /// What it says in one line.
    fn said(&self) -> String {
        let count = |of: Option<bool>| self.stable.iter().filter(|stable| **stable == of).count();
        let mut said = format!("{} of {} motions are stable", count(Some(true)), self.stable.len());
        let unknown = count(None);
        if unknown > 0 {
            said +=
                &format!(", {unknown} not judged (multipliers on the unit circle within their errors, or not found)");
        }
        for found in &self.bifurcations {
            let [from, to] = found.frequency_hz;
            said += &format!("; {} between {from:.4} and {to:.4} Hz", found.kind);
        }
        said + "; modes beyond the highest harmonic are not judged"
    }
}

/// A point of a forced response that was found apart.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PointSummary {
    /// Frequency (Hz); `null` where it was not found.
    pub frequency_hz: Option<f64>,
    /// Amplitude of the first harmonic (m).
    pub amplitude: Option<f64>,
    /// How far it lags behind the force (degrees).
    #[serde(default)]
    pub phase: Option<f64>,
    /// Amplitude of the force (N), of the acceleration of the supports (m/s^2), or of the unbalance (kg m).
    #[serde(default)]
    pub force: Option<f64>,
    /// Residual relative to the elastic forces (energy norm).
    pub residual: Option<f64>,
    /// Why there is none.
    pub failure: Option<String>,
}

impl ForcedSummary {
    /// Whether the amplitude of the response was held, so that the force tells.
    pub fn holds_response(&self) -> bool {
        self.level_unit == scenes::Held::Response.unit()
    }

    /// Whether an unbalance was held.
    pub fn is_unbalance(&self) -> bool {
        self.level_unit == scenes::Held::Unbalance.unit()
    }

    /// What is drawn against the frequency: amplitudes of the response, or of the force where the response is held.
    pub fn ordinate(&self) -> &[f64] {
        match self.holds_response() {
            true => &self.force,
            false => &self.amplitude,
        }
    }

    pub(crate) fn of(of: &ForcedResponse, unit: &str) -> Self {
        let each = |value: &dyn Fn(&ForcedPoint) -> f64| of.points.iter().map(value).collect::<Vec<f64>>();
        // Of a response that is held there is none.
        let peak = of
            .peak()
            .filter(|_| unit != scenes::Held::Response.unit())
            .map(|p| [p.frequency_hz, p.harmonics[0]]);
        let alone = of
            .synthesis
            .iter()
            .max_by(|a, b| a.displacement.total_cmp(&b.displacement));
        let alone = alone.map(|p| [p.omega / TAU, p.displacement]);
        let floquet = FloquetSummary::of(&of.points);
        let apart = |found: &Result<ForcedPoint, _>| {
            let point = found.as_ref().ok();
            PointSummary {
                frequency_hz: point.map(|p: &ForcedPoint| p.frequency_hz),
                amplitude: point.map(|p| p.harmonics[0]),
                phase: point.map(|p| p.phase.to_degrees()),
                force: point.map(|p| p.force),
                residual: point.map(|p| p.residual),
                failure: found.as_ref().err().map(|f: &Failure| f.reason.to_string()),
            }
        };
        Self {
            level: of.level,
            level_unit: unit.to_owned(),
            force: each(&|p| p.force),
            energy_error: each(&|p| p.energy_error),
            base: OutsideSummary::of(&of.points),
            frequency: each(&|p| p.frequency_hz),
            amplitude: each(&|p| p.harmonics[0]),
            phase: each(&|p| p.phase.to_degrees()),
            harmonics: of.points.iter().map(|p| p.harmonics.clone()).collect(),
            components: of.points.iter().map(|p| p.components.clone()).collect(),
            mean: each(&|p| p.mean),
            residual: each(&|p| p.residual),
            turning_points: (0..of.points.len()).filter(|i| of.points[*i].turns).collect(),
            resonances: of.resonances.iter().map(apart).collect(),
            at_frequencies: of.at_frequencies.iter().map(apart).collect(),
            superharmonics: of
                .superharmonics()
                .into_iter()
                .map(|(harmonic, point)| SuperharmonicSummary {
                    harmonic,
                    frequency_hz: point.frequency_hz,
                    share: point.harmonics[harmonic - 1] / point.harmonics[0],
                })
                .collect(),
            open_peaks: of
                .open_peaks
                .iter()
                .map(|open| (open.harmonic, open.omega / TAU))
                .collect(),
            sweep: of.sweep.clone(),
            single_mode_error: peak.zip(alone).map(|(p, a)| [a[0] / p[0] - 1.0, a[1] / p[1] - 1.0]),
            peak,
            single_mode_peak: alone,
            stability: match &floquet {
                Some(floquet) => floquet.said(),
                None => {
                    "not judged: `stability` was not asked for; motions between two turning points are usually unstable"
                        .to_owned()
                }
            },
            floquet,
            krylov_steps: of.effort.krylov_steps,
            failure: of.failure.as_ref().map(|f| f.reason.to_string()),
        }
    }
}
