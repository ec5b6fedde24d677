//! A scene with other numbers, over and over: what samples, finite differences and calibrations run.

use super::amplitude::AmplitudeResult;
use super::effects::Effects;
use super::ensemble::{self, Batch};
use super::mode_backbone::ModeAnalysis;
use super::outcome::Analysis;
use super::prepared::{Prepared, prepare_on};
use super::prestress::closing_force;
use super::sensitivities::{Neighbours, Per, Sensitivity};
use super::solver::{Solver, kept};
use crate::Error;
use cqsma_solver::LoopResult;
use joints::interface::SceneInterface;
use joints::progress::{Progress, Stage};
use joints::store::Options;
use joints::store::checkpoint::{Checkpoint, Checkpoints};
use joints::structure::Structure;
use scenes::{Influence, Parameter, Scene};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::f64::consts::TAU;

/// How far beyond the forces of a scene those of its variants reach at either end, so that all of them reach the amplitudes of the scene.
const BEYOND: f64 = 1.2;

/// Part of the step between two amplitudes within which either of them has the say, where damping is below its floor at one alone.
const BESIDE: f64 = 0.1;

/// Changes whenever [`Variant`] means something else.
const LAYOUT: u64 = 3;

/// Modal forces (sqrt(kg) m/s^2) of the modes followed.
pub(super) type Forces = Vec<Vec<f64>>;

/// An amplitude of a backbone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariantPoint {
    /// Modal amplitude (sqrt(kg) m).
    pub modal_amplitude: f64,
    /// Displacement amplitude at the response point (m).
    pub response_displacement: f64,
    /// Secant frequency (Hz).
    pub frequency_hz: f64,
    /// Total damping ratio, friction plus background; none below its floor.
    pub damping_ratio: Option<f64>,
    /// The motion as a measurement sees it.
    pub first_harmonic: FirstHarmonic,
}

/// The first harmonic of an amplitude, over the motion of the response point as it was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FirstHarmonic {
    /// Half the range of the displacement at the response point (m).
    pub response_motion: f64,
    /// Frequency of the first harmonic (Hz).
    pub frequency_hz: f64,
    /// Total damping ratio with that frequency; none below its floor.
    pub damping_ratio: Option<f64>,
}

/// The backbone of a mode of a variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Its linearised frequency (Hz).
    pub linear_frequency_hz: f64,
    /// Damping ratio that is in all others, apart from friction.
    pub background: f64,
    /// The amplitudes that converged, ascending.
    pub points: Vec<VariantPoint>,
    /// Derivatives that its loops have brought along.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensitivities: Vec<Sensitivity>,
}

/// What became of a variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Variant {
    /// Values of the parameters (SI).
    pub inputs: Vec<f64>,
    /// Its modes, in the order of the scene; empty if it failed.
    pub curves: Vec<Curve>,
    /// Why it has none, if so.
    pub failure: Option<String>,
}

/// What is read off a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// Frequency and damping of the secant at a modal amplitude.
    Modal,
    /// The same at a displacement of the response point in the linearised mode.
    Secant,
    /// Those of the first harmonic at a motion of the response point: what measurements are compared with.
    Measured,
}

/// What is read at one amplitude.
struct Read {
    amplitude: f64,
    frequency_hz: f64,
    damping_ratio: Option<f64>,
}

impl VariantPoint {
    /// An amplitude that converged; `background` is the damping ratio apart from friction.
    pub(super) fn new(found: &AmplitudeResult, background: f64) -> Option<Self> {
        let (result, fields) = (found.point.result.as_ref().ok()?, found.fields.as_ref()?);
        let displacement = found.response_displacement?;
        Some(Self::of(result, displacement, fields.response_motion, background))
    }

    /// A loop that moves the response point by `displacement` in the linearised mode, and by `motion` (m).
    pub(super) fn of(result: &LoopResult, displacement: f64, motion: f64, background: f64) -> Self {
        Self {
            modal_amplitude: result.modal_amplitude,
            response_displacement: displacement,
            frequency_hz: result.omega / TAU,
            damping_ratio: result.is_resolved().then_some(result.zeta + background),
            first_harmonic: FirstHarmonic {
                response_motion: motion,
                frequency_hz: result.harmonic_omega / TAU,
                damping_ratio: result.is_resolved().then_some(result.harmonic_zeta() + background),
            },
        }
    }

    fn read(&self, reading: Reading) -> Read {
        match reading {
            Reading::Modal => Read {
                amplitude: self.modal_amplitude,
                frequency_hz: self.frequency_hz,
                damping_ratio: self.damping_ratio,
            },
            Reading::Secant => Read {
                amplitude: self.response_displacement,
                frequency_hz: self.frequency_hz,
                damping_ratio: self.damping_ratio,
            },
            Reading::Measured => Read {
                amplitude: self.first_harmonic.response_motion,
                frequency_hz: self.first_harmonic.frequency_hz,
                damping_ratio: self.first_harmonic.damping_ratio,
            },
        }
    }
}

impl Variant {
    /// It with the parameter at `place` moved `by` this much: see [`Curve::moved`].
    pub(super) fn moved(&self, parameter: &Parameter, place: usize, by: f64) -> Option<Self> {
        let curves = self.curves.iter().map(|curve| curve.moved(parameter, by));
        let curves = curves.collect::<Option<Vec<_>>>()?;
        let (of, _) = self.curves.first()?.derivatives(parameter, Reading::Measured)?;
        let mut inputs = self.inputs.clone();
        let value = inputs.get_mut(place)?;
        *value = match of.per {
            Per::Logarithm => *value * by.exp(),
            Per::Value => *value + by,
        };
        Some(Self {
            inputs,
            curves,
            failure: None,
        })
    }
}

impl Curve {
    fn new(found: &ModeAnalysis, frequencies: &[f64]) -> Self {
        let points = found
            .amplitudes
            .iter()
            .filter_map(|amplitude| VariantPoint::new(amplitude, found.background));
        let mut points: Vec<VariantPoint> = points.collect();
        points.sort_by(|a, b| a.modal_amplitude.total_cmp(&b.modal_amplitude));
        points.dedup_by_key(|point| point.modal_amplitude);
        Self {
            mode: found.mode,
            linear_frequency_hz: frequencies.get(found.mode - 1).copied().unwrap_or(f64::NAN),
            background: found.background,
            points,
            sensitivities: found.sensitivities.clone(),
        }
    }

    /// Derivatives of the logarithms of frequency and damping ratio at the amplitudes of the curve, at the same modal amplitude, with respect
    /// to a parameter that its loops are differentiated with respect to.
    pub(super) fn derivatives(
        &self,
        parameter: &Parameter,
        reading: Reading,
    ) -> Option<(&Sensitivity, Vec<[Option<f64>; 2]>)> {
        let found = self.sensitivities.iter().find(|one| one.parameter == *parameter)?;
        let [frequency, damping] = match reading {
            Reading::Modal | Reading::Secant => [&found.dln_frequency, &found.dln_damping],
            Reading::Measured => [&found.dln_frequency_first_harmonic, &found.dln_damping_first_harmonic],
        };
        let of = |point: &VariantPoint| {
            let same = |q: &Option<f64>| *q == Some(point.modal_amplitude);
            let place = found.modal_amplitude.iter().position(same);
            let at = |values: &[Option<f64>]| place.and_then(|place| values.get(place).copied().flatten());
            // Derivatives are those of the damping of the contact alone.
            let total = point.read(reading).damping_ratio;
            let share = total.map(|total| self.contact_share(total));
            [at(frequency), at(damping).zip(share).map(|(rate, share)| rate * share)]
        };
        Some((found, self.points.iter().map(of).collect()))
    }

    /// Part of a total damping ratio that the contact has.
    pub(super) fn contact_share(&self, total: f64) -> f64 {
        (total - self.background) / total
    }

    /// What measurements are compared with where the parameter is moved `by` this much, in what its derivatives are with respect to: a
    /// straight line. The motion of the response point changes as in the linearised mode. None without the derivatives of all frequencies
    /// and of all damping ratios that the curve has.
    pub(super) fn moved(&self, parameter: &Parameter, by: f64) -> Option<Self> {
        let (found, rates) = self.derivatives(parameter, Reading::Measured)?;
        let points = self.points.iter().zip(rates).map(|(point, [frequency, damping])| {
            let first_harmonic = FirstHarmonic {
                response_motion: point.first_harmonic.response_motion * (by * found.dln_mode_shape).exp(),
                frequency_hz: point.first_harmonic.frequency_hz * (by * frequency?).exp(),
                damping_ratio: match point.first_harmonic.damping_ratio {
                    Some(zeta) => Some(zeta * (by * damping?).exp()),
                    None => None,
                },
            };
            Some(VariantPoint {
                first_harmonic,
                ..*point
            })
        });
        Some(Self {
            points: points.collect::<Option<_>>()?,
            sensitivities: Vec::new(),
            ..*self
        })
    }

    /// Frequency (Hz) and damping ratio at an amplitude, by monotone cubics through the logarithms; none beyond the amplitudes of the
    /// curve. Damping below its floor is that of the background, and minus infinity, below every other, where there is none. Between an amplitude
    /// where it is so and one where it is not, damping rises in proportion to the logarithm of the amplitude.
    pub fn at(&self, reading: Reading, amplitude: f64) -> Option<[f64; 2]> {
        let read: Vec<Read> = self.points.iter().map(|point| point.read(reading)).collect();
        let x: Vec<f64> = read.iter().map(|point| point.amplitude.ln()).collect();
        let at = amplitude.ln();
        if !(*x.first()? <= at && at <= *x.last()?) {
            return None;
        }
        let frequencies: Vec<f64> = read.iter().map(|point| point.frequency_hz.ln()).collect();
        let frequency = monotone_cubic(&x, &frequencies, at).exp();
        let dampings: Vec<Option<f64>> = read.iter().map(|point| point.damping_ratio).collect();
        let floor = match self.background > 0.0 {
            true => self.background,
            false => f64::NEG_INFINITY,
        };
        let damping = self.damping(&x, &dampings, at).unwrap_or(floor);
        Some([frequency, damping])
    }

    /// The same by a straight line through the logarithms at the two amplitudes about it, which must both have damping.
    pub(super) fn between(&self, modal_amplitude: f64) -> [Option<f64>; 2] {
        let right = self
            .points
            .partition_point(|point| point.modal_amplitude < modal_amplitude);
        let Some(b) = self.points.get(right) else {
            return [None; 2];
        };
        if b.modal_amplitude == modal_amplitude {
            return [Some(b.frequency_hz), b.damping_ratio];
        }
        let Some(a) = right.checked_sub(1).map(|left| self.points[left]) else {
            return [None; 2];
        };
        let part = (modal_amplitude / a.modal_amplitude).ln() / (b.modal_amplitude / a.modal_amplitude).ln();
        let line = |from: f64, to: f64| from * (part * (to / from).ln()).exp();
        let dampings = a
            .damping_ratio
            .zip(b.damping_ratio)
            .filter(|(a, b)| *a > 0.0 && *b > 0.0);
        [
            Some(line(a.frequency_hz, b.frequency_hz)),
            dampings.map(|(a, b)| line(a, b)),
        ]
    }

    /// Damping at the logarithm of an amplitude within the curve, if it is above its floor.
    fn damping(&self, x: &[f64], dampings: &[Option<f64>], at: f64) -> Option<f64> {
        let known = |k: usize| dampings[k].filter(|zeta| *zeta > 0.0);
        let right = x.partition_point(|node| *node < at);
        let left = if x[right] == at { right } else { right - 1 };
        // Part of the step from the left one to the right one.
        let part = if left == right {
            0.0
        } else {
            (at - x[left]) / (x[right] - x[left])
        };
        let (nearest, other, distance) = if part <= 0.5 {
            (left, right, part)
        } else {
            (right, left, 1.0 - part)
        };
        let is_known = [nearest, other].map(|k| known(k).is_some());
        if is_known != [true, true] && distance > BESIDE {
            // From the floor to the value of the one that has it, within what lies between the neighbourhoods of the two.
            let (value, from_floor) = known(nearest)
                .map(|value| (value, 1.0 - distance))
                .or(known(other).map(|v| (v, distance)))?;
            let risen = (from_floor - BESIDE) / (1.0 - 2.0 * BESIDE);
            return Some(self.background + risen * (value - self.background));
        }
        known(nearest)?;
        let first = (0..nearest)
            .rev()
            .take_while(|k| known(*k).is_some())
            .last()
            .unwrap_or(nearest);
        let last = (nearest..x.len())
            .take_while(|k| known(*k).is_some())
            .last()
            .unwrap_or(nearest);
        let values: Vec<f64> = (first..=last).filter_map(known).map(f64::ln).collect();
        Some(monotone_cubic(&x[first..=last], &values, at).exp())
    }
}

/// Value at `at` of the cubic Hermite interpolant with the slopes of Fritsch and Butland (1984, doi:10.1137/0905021), which has no extremes
/// of its own; beyond its ends the line with the slope there. `x` rises and is not empty.
fn monotone_cubic(x: &[f64], y: &[f64], at: f64) -> f64 {
    let n = x.len();
    if n == 1 {
        return y[0];
    }
    let step = |k: usize| x[k + 1] - x[k];
    let secant = |k: usize| (y[k + 1] - y[k]) / step(k);
    let slope = |k: usize| {
        if n == 2 {
            return secant(0);
        }
        if k == 0 || k == n - 1 {
            // The parabola through three points, but without a turn.
            let (near, far) = if k == 0 { (0, 1) } else { (n - 2, n - 3) };
            let (h, g, a, b) = (step(near), step(far), secant(near), secant(far));
            let end = ((2.0 * h + g) * a - h * b) / (h + g);
            return if end * a <= 0.0 {
                0.0
            } else if a * b <= 0.0 && end.abs() > 3.0 * a.abs() {
                3.0 * a
            } else {
                end
            };
        }
        let (a, b, h, g) = (secant(k - 1), secant(k), step(k - 1), step(k));
        if a * b <= 0.0 {
            return 0.0;
        }
        let (wa, wb) = (2.0 * g + h, g + 2.0 * h);
        (wa + wb) / (wa / a + wb / b)
    };
    if at <= x[0] {
        return y[0] + slope(0) * (at - x[0]);
    }
    if at >= x[n - 1] {
        return y[n - 1] + slope(n - 1) * (at - x[n - 1]);
    }
    let k = x.partition_point(|node| *node <= at).clamp(1, n - 1) - 1;
    let (h, t) = (step(k), (at - x[k]) / step(k));
    let (left, right) = (h * slope(k), h * slope(k + 1));
    let rest = 1.0 - t;
    y[k] * rest * rest * (1.0 + 2.0 * t) + left * t * rest * rest + y[k + 1] * t * t * (3.0 - 2.0 * t)
        - right * t * t * rest
}

/// Which derivatives variants bring along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rates {
    None,
    /// Those that take no further reduction, of laws that have them.
    WhereTheyCostLittle,
}

/// A scene whose numbers vary.
pub(super) struct Variants<'a> {
    prepared: &'a Prepared,
    structure: &'a Structure,
    given: Scene,
    /// It with the loops alone.
    scene: Scene,
    options: Options,
    parameters: Vec<Parameter>,
    changes_the_structure: bool,
}

impl<'a> Variants<'a> {
    pub(super) fn new(
        scene: &Scene,
        parameters: Vec<Parameter>,
        structure: &'a Structure,
        prepared: &'a Prepared,
        options: &Options,
    ) -> Self {
        let is_structural = |parameter: &Parameter| parameter.influence() == Influence::Structure;
        Self {
            prepared,
            structure,
            given: scene.clone(),
            scene: ensemble::loops_alone(scene, true),
            options: options.clone(),
            changes_the_structure: parameters.iter().any(is_structural),
            parameters,
        }
    }

    pub(super) fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// The scene that varies, with all that is asked for.
    pub(super) fn given(&self) -> &Scene {
        &self.given
    }

    /// The scene that varies, with the loops alone.
    pub(super) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene with these values (SI).
    pub(super) fn with(&self, inputs: &[f64]) -> Result<Scene, Error> {
        let mut values = self.parameters.iter().zip(inputs);
        Ok(values.try_fold(self.scene.clone(), |scene, (parameter, value)| {
            parameter.with(&scene, *value)
        })?)
    }

    /// Whether variants have structures of their own.
    pub(super) fn changes_the_structure(&self) -> bool {
        self.changes_the_structure
    }

    fn analyse(
        &self,
        (inputs, forces): &(Vec<f64>, Forces),
        rates: Rates,
        progress: &dyn Progress,
    ) -> Result<Analysis, Error> {
        let mut scene = self.with(inputs)?;
        let forces = Some(forces.as_slice());
        let model = match self.changes_the_structure {
            false => Cow::Borrowed(self.prepared.model()),
            true => {
                let structure = Structure::try_new(&scene, progress)?;
                // What is known of the interface belongs to its mesh.
                let is_same = structure.interface() == self.structure.interface();
                match structure.multiple_of(self.structure).filter(|_| is_same) {
                    Some(factors) => Cow::Owned(self.prepared.model().scaled(factors)),
                    None => return self.analyse_anew(&scene, &structure, forces, rates, progress),
                }
            }
        };
        let (mesh, parts) = (self.structure.interface(), &self.structure.joint.parts);
        let load = closing_force(&scene, &model);
        let interface = SceneInterface::knowing(Some(self.prepared.interface()), &scene, mesh, parts, load)?;
        let interface = Solver::of(&model, &self.prepared.options).settled(&scene, interface, progress)?;
        let neighbours = match rates {
            Rates::None => Vec::new(),
            Rates::WhereTheyCostLittle => Neighbours::without_reduction(&scene, self.parameters.iter(), &interface)?,
        };
        scene.analyses.sensitivities = neighbours.iter().map(|one| one.parameter().clone()).collect();
        let solver = Solver {
            model: &model,
            neighbours: &neighbours,
            ..self.prepared.solver()
        };
        solver.analyse(&scene, &interface.interface, interface.closure, forces, progress)
    }

    /// A variant on a structure that is reduced for it.
    fn analyse_anew(
        &self,
        scene: &Scene,
        structure: &Structure,
        forces: Option<&[Vec<f64>]>,
        rates: Rates,
        progress: &dyn Progress,
    ) -> Result<Analysis, Error> {
        // A stored model would never be asked for again.
        let options = Options {
            cache: None,
            ..self.options.clone()
        };
        let mut prepared = Prepared::try_new(scene, structure, &options, progress)?;
        if rates == Rates::WhereTheyCostLittle {
            prepared.differentiate_also(&self.parameters)?;
        }
        prepared.analyse_itself(forces, None, progress)
    }

    /// The backbone of the scene itself.
    pub(super) fn nominal(&self, analysis: &Analysis, inputs: Vec<f64>) -> Variant {
        self.variant(inputs, Ok(analysis))
    }

    fn variant(&self, inputs: Vec<f64>, found: Result<&Analysis, Error>) -> Variant {
        match found {
            Ok(analysis) => Variant {
                inputs,
                curves: analysis
                    .modes
                    .iter()
                    .map(|mode| Curve::new(mode, &analysis.frequencies))
                    .collect(),
                failure: None,
            },
            Err(error) => Variant {
                inputs,
                curves: Vec::new(),
                failure: Some(error.to_string()),
            },
        }
    }

    /// Modal forces at which a variant has about the modal amplitudes of the scene, and one more on either side. `factor` is that of the
    /// forces that it takes, for each amplitude of each mode that has converged, and `around` has those about it.
    pub(super) fn forces(&self, nominal: &Variant, factor: &dyn Fn(usize, f64) -> f64, around: &[f64]) -> Forces {
        let of_mode = |(mode, curve): (usize, &Curve)| {
            let force = |point: &VariantPoint| {
                let omega = TAU * point.frequency_hz;
                omega * omega * point.modal_amplitude * factor(mode, point.modal_amplitude)
            };
            let all = curve.points.iter().map(force);
            let mut forces: Vec<f64> = all
                .flat_map(|force| around.iter().map(move |factor| factor * force))
                .collect();
            forces.sort_by(f64::total_cmp);
            if let (Some(first), Some(last)) = (forces.first().copied(), forces.last().copied()) {
                forces.insert(0, first / BEYOND);
                forces.push(last * BEYOND);
            }
            forces
        };
        nominal.curves.iter().enumerate().map(of_mode).collect()
    }

    /// Runs variants; `name` is what they are called in messages, `inputs` their values (SI) and modal forces. With a cache, those of an
    /// interrupted run are taken from there.
    ///
    /// # Errors
    /// An interruption; whatever else ends a variant is part of it.
    pub(super) fn run(
        &self,
        name: &str,
        inputs: &[(Vec<f64>, Forces)],
        rates: Rates,
        nominal: &Analysis,
        progress: &dyn Progress,
    ) -> Result<(Vec<Variant>, Checkpoints), Error> {
        let checkpoint = match kept(&self.scene, &self.options)? {
            None => Checkpoint::default(),
            Some((directory, mut key)) => {
                self.parameters.iter().for_each(|parameter| key.text(parameter.path()));
                inputs.iter().for_each(|(values, forces)| {
                    key.numbers(values.iter().copied());
                    key.numbers(forces.iter().flatten().copied());
                });
                key.integers([LAYOUT, rates as u64]);
                // Whatever else the variants depend on has left its mark in the backbone of the scene.
                key.numbers(nominal.prestress.solution.displacement.iter().copied());
                key.numbers(nominal.frequencies.iter().copied());
                Checkpoint::open(directory, "variants", &key.finish())
            }
        };
        progress.begin(Stage::Ensemble);
        let batch = Batch {
            name,
            number: inputs.len(),
            loops: inputs
                .iter()
                .flat_map(|(_, forces)| forces)
                .map(Vec::len)
                .max()
                .unwrap_or(0)
                * self.scene.analyses.modes.followed.len(),
            progress,
        };
        let found = batch.run(
            checkpoint,
            |k, progress| self.analyse(&inputs[k], rates, progress),
            |k, found| self.variant(inputs[k].0.clone(), found),
        )?;
        progress.end(Stage::Ensemble);
        Ok(found)
    }
}

/// A scene prepared and solved, and what its variants need beside.
pub(super) struct Solved {
    pub(super) structure: Structure,
    pub(super) prepared: Prepared,
    pub(super) analysis: Analysis,
}

impl Solved {
    /// With derivatives with respect to the `parameters` that are to vary.
    ///
    /// # Errors
    /// [`scenes::Error::Parameter`] for one that no result depends on; as [`run`](super::run).
    pub(super) fn new(
        scene: &Scene,
        parameters: &[Parameter],
        rates: Rates,
        options: &Options,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let (structure, mut prepared) = prepare_on(scene, options, progress)?;
        let effects = Effects::try_new(scene, &structure, Some(prepared.interface()))?;
        parameters.iter().try_for_each(|parameter| effects.require(parameter))?;
        if rates == Rates::WhereTheyCostLittle {
            prepared.differentiate_also(parameters)?;
        }
        let analysis = prepared.analyse_in_full(progress)?;
        Ok(Self {
            structure,
            prepared,
            analysis,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(zeta: impl Fn(f64) -> Option<f64>) -> Curve {
        let point = |k: i32| {
            let modal_amplitude = 10_f64.powf(f64::from(k) / 3.0);
            let (frequency_hz, damping_ratio) = (100.0 * modal_amplitude.powf(-0.1), zeta(modal_amplitude));
            VariantPoint {
                modal_amplitude,
                response_displacement: 3.0 * modal_amplitude,
                frequency_hz,
                damping_ratio,
                first_harmonic: FirstHarmonic {
                    response_motion: 2.0 * modal_amplitude,
                    frequency_hz,
                    damping_ratio,
                },
            }
        };
        Curve {
            mode: 1,
            linear_frequency_hz: 100.0,
            background: 0.0,
            points: (0..10).map(point).collect(),
            sensitivities: Vec::new(),
        }
    }

    #[test]
    fn powers_are_interpolated_exactly_and_nothing_is_beyond_the_ends() {
        let found = curve(|q| Some(1e-4 * q.powf(0.7)));
        for q in [1.0, 1.7, 33.0, 999.0] {
            let [f, zeta] = found.at(Reading::Modal, q).unwrap();
            assert!((f / (100.0 * q.powf(-0.1)) - 1.0).abs() < 1e-12);
            assert!((zeta / (1e-4 * q.powf(0.7)) - 1.0).abs() < 1e-12);
            let [other, damping] = found.at(Reading::Measured, 2.0 * q).unwrap();
            assert!((other / f - 1.0).abs() < 1e-12 && (damping / zeta - 1.0).abs() < 1e-12);
        }
        assert!(found.at(Reading::Modal, 0.99).is_none() && found.at(Reading::Modal, 1001.0).is_none());
    }

    #[test]
    fn damping_rises_from_its_floor() {
        let found = curve(|q| (q > 9.0).then(|| 1e-4 * q.powf(0.7)));
        let at = |q: f64| found.at(Reading::Modal, q).unwrap()[1];
        assert!((at(9.5) / (1e-4 * 9.5_f64.powf(0.7)) - 1.0).abs() < 1e-12);
        // The amplitude below is 10^(2/3).
        assert!((at(10_f64.powf(5.0 / 6.0)) / (0.5e-4 * 10_f64.powf(0.7)) - 1.0).abs() < 1e-12);
        assert_eq!(at(4.8), f64::NEG_INFINITY);
        assert_eq!(at(found.points[2].modal_amplitude), f64::NEG_INFINITY);
        assert_eq!(at(2.0), f64::NEG_INFINITY);
    }

    #[test]
    fn cubics_have_no_extremes_of_their_own_and_third_order() {
        let x: Vec<f64> = (0..6).map(f64::from).collect();
        let y = [0.0, 0.0, 0.0, 5.0, 5.0, 5.0];
        for k in 0..=100 {
            let value = monotone_cubic(&x, &y, 0.05 * f64::from(k));
            assert!((-1e-12..=5.0 + 1e-12).contains(&value));
        }
        let error = |n: i32| {
            let x: Vec<f64> = (0..=n).map(|k| f64::from(k) / f64::from(n)).collect();
            let y: Vec<f64> = x.iter().map(|x| x.exp()).collect();
            (0..200)
                .map(|k| f64::from(k) / 200.0)
                .map(|x0| (monotone_cubic(&x, &y, x0) - x0.exp()).abs())
                .fold(0.0, f64::max)
        };
        assert!(
            error(40) < 0.3 * error(20) && error(40) < 1e-4,
            "{} {}",
            error(20),
            error(40)
        );
    }
}
