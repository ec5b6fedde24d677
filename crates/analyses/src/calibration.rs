//! Numbers of a scene from measured backbones: nonlinear least squares on the logarithms of frequency and damping.

use super::comparison::{Backbone, Point};
use super::ensemble::loops_alone;
use super::finite_differences;
use super::outcome::Analysis;
use super::variants::{Forces, Rates, Reading, Solved, Variant, Variants};
use crate::Error;
use joints::progress::{Progress, Quiet};
use joints::store::Options;
use joints::store::checkpoint::Checkpoints;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use scenes::{Marginal, Parameter, Scene, Shape};
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Loops per backbone at most: at the measured amplitudes, or spread over them where they are more.
const LOOPS: usize = 24;

/// Standard deviation of the weak prior about the scene's value that parameters without one have, in logarithms or over the value: it keeps
/// combinations that the data do not tell where they are, and weighs nothing beside data that tell anything.
const WEAK: f64 = 3.0;

/// Weighted residuals that stand for those of a trial at which the model fails, so that it is not taken.
const REJECTED: f64 = 1e6;

/// How far beyond the measured amplitudes loops reach.
const BEYOND: f64 = 1.6;

/// Least ratio of modelled to measured damping that is told apart: a joint that sticks in the model has no damping, and no logarithm of it.
const LEAST_DAMPING: f64 = 1e-3;

/// Step along derivatives, in what they are with respect to: interpolants between amplitudes are differenced over it.
const ALONG: f64 = 1e-5;

/// Normal quantile of a 95 % interval.
const INTERVAL: f64 = 1.959_963_984_540_054;

/// Standard deviation of a direction beyond which it is not identified: the data leave its parameters a factor of e.
const UNKNOWN: f64 = 1.0;

/// A measured backbone over the displacement at the response point.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Its name.
    pub name: String,
    /// The mode, counted from 1; one that the scene follows.
    pub mode: usize,
    /// Its points.
    pub backbone: Backbone,
}

/// How well backbones were measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Noise {
    /// Standard deviation of the logarithm of a frequency.
    pub frequency_ln: f64,
    /// Standard deviation of the logarithm of a damping ratio.
    pub damping_ln: f64,
}

/// A calibrated parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Its path.
    pub name: String,
    /// SI unit; empty for pure numbers.
    pub unit: String,
    /// Value before the calibration.
    pub before: f64,
    /// Value.
    pub estimate: f64,
    /// Standard error, of the posterior where there are priors.
    pub standard_error: f64,
    /// 95 % interval; symmetric in the logarithm where that is what was varied.
    pub interval_95: [f64; 2],
    /// Whether its logarithm was varied.
    pub logarithmic: bool,
    /// Mean and standard deviation of the prior of what was varied, if there is one.
    pub prior: Option<[f64; 2]>,
    /// Bounds, if there are any.
    pub bounds: Option<[f64; 2]>,
}

/// A combination of parameters that the data do not tell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Direction {
    /// Weights of the logarithms of the parameters, with unit length.
    pub direction: BTreeMap<String, f64>,
    /// Singular value of the weighted Jacobian: the reciprocal is the standard deviation along the direction.
    pub singular_value: f64,
}

/// A measured point beside the calibrated model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Residual {
    /// Backbone.
    pub experiment: String,
    /// Its mode.
    pub mode: usize,
    /// Measured.
    pub measured: Point,
    /// Calibrated model: frequency of the first harmonic (Hz).
    pub frequency_hz: f64,
    /// Calibrated model: damping ratio with that frequency; none where it sticks.
    pub damping_ratio: Option<f64>,
    /// Model less measurement, logarithm of the frequency.
    pub frequency_ln: f64,
    /// Model less measurement, logarithm of the damping ratio; none where none was measured.
    pub damping_ln: Option<f64>,
}

/// A calibration.
#[derive(Clone, Debug, Serialize)]
pub struct Calibration {
    /// What was calibrated.
    pub parameters: Vec<Estimate>,
    /// Covariance of what was varied (logarithms where `logarithmic`), in the order of the parameters.
    pub covariance: Vec<Vec<f64>>,
    /// Correlation of the same.
    pub correlation: Vec<Vec<f64>>,
    /// Combinations that the data do not tell.
    pub unidentifiable: Vec<Direction>,
    /// Assumed standard deviations of the measurement.
    pub noise: Noise,
    /// Sum of squares of the weighted residuals over the degrees of freedom; where it is above 1 it is a factor in the covariance.
    pub reduced_chi_squared: f64,
    /// Measured numbers.
    pub observations: usize,
    /// How many independent ones they count for in the covariance: neighbouring points of an identified backbone share most of their record,
    /// and a model errs alike at neighbouring amplitudes. From the correlation of the residuals along each backbone.
    pub effective_observations: f64,
    /// Evaluations of the model, each with its derivatives.
    pub evaluations: usize,
    /// Whether the least-squares method says that it has converged.
    pub converged: bool,
    /// Why it ended.
    pub ended: String,
    /// Point by point.
    #[serde(skip)]
    pub residuals: Vec<Residual>,
    /// The calibrated scene.
    #[serde(skip)]
    pub scene: Scene,
    /// What lets an interrupted calibration resume.
    #[serde(skip)]
    pub checkpoints: Checkpoints,
}

/// A parameter that is free, in the variable that is varied.
#[derive(Clone, Copy)]
struct Free {
    logarithmic: bool,
    /// Mean and standard deviation.
    prior: Option<[f64; 2]>,
    bounds: Option<[f64; 2]>,
    start: f64,
    /// Standard deviation of the prior about the start where there is no other.
    weak: f64,
}

/// What was found at a point: weighted residuals of data and priors, their derivatives by what is varied, and the model itself.
#[derive(Clone)]
struct Evaluation {
    at: DVector<f64>,
    /// Of each residual that is one of the data.
    series: Vec<usize>,
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
    model: Variant,
}

/// A measured number beside the model.
struct Datum {
    /// What it stands in a row with: frequencies along a backbone, or damping ratios.
    series: usize,
    /// Model less measurement, weighted.
    residual: f64,
}

impl Free {
    /// Mean and standard deviation of the prior, a weak one where no other is given.
    fn holds(&self) -> [f64; 2] {
        self.prior.unwrap_or([self.start, self.weak])
    }

    fn new(nominal: f64, prior: Option<&Marginal>) -> Self {
        let logarithmic = nominal > 0.0;
        let of = |value: f64| if logarithmic { value.ln() } else { value };
        let bounds = prior.and_then(Marginal::support).map(|bounds| {
            bounds.map(|bound| {
                if logarithmic {
                    bound.max(f64::MIN_POSITIVE).ln()
                } else {
                    bound
                }
            })
        });
        let normal = prior.and_then(|prior| match prior.shape() {
            Shape::Uniform { .. } => None,
            Shape::Lognormal { median, sd_of_log } if logarithmic => Some([median.ln(), sd_of_log]),
            _ => {
                let [mean, sd] = prior.moments();
                Some([of(mean), if logarithmic { sd / mean } else { sd }])
            }
        });
        let start = match bounds {
            // Inside, so that the map of the bounds has a slope.
            Some([low, high]) => of(nominal).clamp(low + 1e-3 * (high - low), high - 1e-3 * (high - low)),
            None => of(nominal),
        };
        let weak = match (logarithmic, nominal == 0.0) {
            (true, _) => WEAK,
            (false, false) => WEAK * nominal.abs(),
            (false, true) => WEAK * bounds.map_or(1.0, |[low, high]| high - low),
        };
        Self {
            logarithmic,
            prior: normal,
            bounds,
            start,
            weak,
        }
    }

    fn value(&self, varied: f64) -> f64 {
        if self.logarithmic { varied.exp() } else { varied }
    }

    /// The varied number within its bounds from one without, and its slope.
    fn bounded(&self, free: f64) -> [f64; 2] {
        match self.bounds {
            None => [free, 1.0],
            Some([low, high]) => {
                let part = 1.0 / (1.0 + (-free).exp());
                [low + (high - low) * part, (high - low) * part * (1.0 - part)]
            }
        }
    }

    fn unbounded(&self, varied: f64) -> f64 {
        match self.bounds {
            None => varied,
            Some([low, high]) => ((varied - low) / (high - varied)).ln(),
        }
    }
}

/// The least-squares problem.
struct Problem<'a> {
    variants: &'a Variants<'a>,
    nominal: &'a Variant,
    analysis: &'a Analysis,
    measured: &'a [Measured],
    /// Place of each backbone's mode among those followed.
    modes: Vec<usize>,
    forces: Forces,
    free: Vec<Free>,
    noise: Noise,
    progress: &'a dyn Progress,
    at: DVector<f64>,
    /// The last point, or why there is none.
    found: Result<Evaluation, Error>,
    /// All points so far.
    known: Vec<Evaluation>,
    checkpoints: Checkpoints,
}

impl Problem<'_> {
    fn varied(&self) -> Vec<f64> {
        self.free
            .iter()
            .zip(self.at.iter())
            .map(|(free, at)| free.bounded(*at)[0])
            .collect()
    }

    /// Logarithms of frequency and damping less those measured, in units of their standard deviations.
    fn data(&self, variant: &Variant) -> Result<Vec<Datum>, Error> {
        let refused = |reason: String| Error::Calibration { reason };
        if let Some(reason) = &variant.failure {
            let inputs: Vec<String> = self
                .variants
                .parameters()
                .iter()
                .zip(&variant.inputs)
                .map(|(p, v)| format!("{p} = {v}"))
                .collect();
            return Err(refused(format!(
                "the model fails with {}: {reason}; give priors or bounds that keep away from there",
                inputs.join(", ")
            )));
        }
        let mut all = Vec::new();
        for (number, (measured, &mode)) in self.measured.iter().zip(&self.modes).enumerate() {
            for point in measured.backbone.points() {
                let found = variant.curves[mode].at(Reading::Measured, point.amplitude);
                let [frequency, damping] = found.ok_or_else(|| {
                    refused(format!(
                        "{}: the model does not reach {:.3e} m; leave out measured amplitudes there",
                        measured.name, point.amplitude
                    ))
                })?;
                all.push(Datum {
                    series: 2 * number,
                    residual: (frequency / point.frequency_hz).ln() / self.noise.frequency_ln,
                });
                if let Some(zeta) = point.damping_ratio {
                    all.push(Datum {
                        series: 2 * number + 1,
                        residual: (damping / zeta).max(LEAST_DAMPING).ln() / self.noise.damping_ln,
                    });
                }
            }
        }
        Ok(all)
    }

    /// Runs the model.
    fn run(&mut self, values: &[f64], rates: Rates) -> Result<Option<Variant>, Error> {
        let inputs = [(values.to_vec(), self.forces.clone())];
        let quiet = Quiet(self.progress);
        let (mut found, checkpoints) = self.variants.run("runs", &inputs, rates, self.analysis, &quiet)?;
        self.checkpoints.extend(checkpoints);
        Ok(found.pop())
    }

    /// The model at `values`, with the derivatives that its loops bring along.
    fn model(&mut self, values: &[f64]) -> Result<Variant, Error> {
        let mut found = self.run(values, Rates::WhereTheyCostLittle)?;
        if found.as_ref().is_none_or(|found| found.failure.is_some()) {
            // It may be the derivatives alone that there are none of.
            found = self.run(values, Rates::None)?;
        }
        found.ok_or_else(|| Error::Calibration {
            reason: "the model was not run".into(),
        })
    }

    /// The model with each parameter moved up and down in turn: along the derivatives of its loops, or by runs where there are none.
    fn beside(&mut self, model: &Variant, steps: &[f64]) -> Result<Vec<[Variant; 2]>, Error> {
        let along = |(place, parameter): (usize, &Parameter)| {
            let [above, below] = [ALONG, -ALONG].map(|by| model.moved(parameter, place, by));
            Some([above?, below?])
        };
        let known: Vec<Option<[Variant; 2]>> = self.variants.parameters().iter().enumerate().map(along).collect();
        let unknown = (0..known.len()).filter(|place| known[*place].is_none());
        let (inputs, quiet) = ((model.inputs.as_slice(), steps), Quiet(self.progress));
        let (pairs, checkpoints) =
            finite_differences::pairs(self.variants, inputs, unknown, &self.forces, self.analysis, &quiet)?;
        self.checkpoints.extend(checkpoints);
        let mut pairs = pairs.into_iter();
        let all = known.into_iter().map(|known| known.or_else(|| pairs.next()));
        Ok(all.flatten().collect())
    }

    /// Residuals and Jacobian by what is varied.
    fn evaluate(&mut self) -> Result<Evaluation, Error> {
        if let Some(known) = self.known.iter().find(|known| known.at == self.at) {
            return Ok(known.clone());
        }
        let varied = self.varied();
        let values: Vec<f64> = self
            .free
            .iter()
            .zip(&varied)
            .map(|(free, varied)| free.value(*varied))
            .collect();
        let widths = self.free.iter().map(|free| free.holds()[1]);
        let steps: Vec<f64> = values
            .iter()
            .zip(widths)
            .map(|(value, width)| finite_differences::step(*value, width))
            .collect();
        let model = self.model(&values)?;
        let data = self.data(&model)?;
        let mut residuals: Vec<f64> = data.iter().map(|datum| datum.residual).collect();
        let pairs = self.beside(&model, &steps)?;
        let n = residuals.len();
        let priors = self.free.iter().zip(&varied).map(|(free, varied)| {
            let [mean, sd] = free.holds();
            (varied - mean) / sd
        });
        residuals.extend(priors);
        self.progress.note(&format!(
            "evaluation {}: {}, sum of squares {:.4e}",
            self.known.len() + 1,
            self.variants
                .parameters()
                .iter()
                .zip(&values)
                .map(|(p, v)| format!("{p} = {v:.5e}"))
                .collect::<Vec<_>>()
                .join(", "),
            residuals.iter().map(|r| r * r).sum::<f64>()
        ));
        let mut jacobian = DMatrix::zeros(residuals.len(), self.free.len());
        for (place, pair) in pairs.iter().enumerate() {
            let of = |variant: &Variant| {
                if self.free[place].logarithmic {
                    variant.inputs[place].ln()
                } else {
                    variant.inputs[place]
                }
            };
            let width = of(&pair[0]) - of(&pair[1]);
            let (above, below) = (self.data(&pair[0])?, self.data(&pair[1])?);
            for row in 0..n {
                jacobian[(row, place)] = (above[row].residual - below[row].residual) / width;
            }
        }
        for (place, free) in self.free.iter().enumerate() {
            jacobian[(n + place, place)] = 1.0 / free.holds()[1];
        }
        let found = Evaluation {
            at: self.at.clone(),
            series: data.iter().map(|datum| datum.series).collect(),
            residuals: DVector::from_vec(residuals),
            jacobian,
            model,
        };
        self.known.push(found.clone());
        Ok(found)
    }

    /// The point of the last evaluation, where the model fails.
    fn rejected(&self, last: &Evaluation) -> Evaluation {
        Evaluation {
            at: self.at.clone(),
            residuals: last.residuals.map(|_| REJECTED),
            ..last.clone()
        }
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, at: &DVector<f64>) {
        self.at.copy_from(at);
        self.found = match (self.evaluate(), self.known.last()) {
            (Err(Error::Calibration { reason }), Some(last)) => {
                self.progress.note(&format!("a step is not taken: {reason}"));
                Ok(self.rejected(last))
            }
            (found, _) => found,
        };
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.found.as_ref().ok().map(|found| found.residuals.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let mut jacobian = self.found.as_ref().ok()?.jacobian.clone();
        for (place, free) in self.free.iter().enumerate() {
            let slope = free.bounded(self.at[place])[1];
            jacobian.column_mut(place).iter_mut().for_each(|entry| *entry *= slope);
        }
        Some(jacobian)
    }
}

/// Calibrates numbers of a scene by measured backbones, from the values of the scene on. `priors` go with the parameters, where there are
/// any; a uniform one bounds its parameter alone.
///
/// # Errors
/// [`Error::Calibration`] for parameters, modes and amplitudes that cannot be calibrated; as [`run`](super::run).
pub fn calibrate(
    scene: &Scene,
    parameters: &[(Parameter, Option<Marginal>)],
    measured: &[Measured],
    noise: Noise,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Calibration, Error> {
    scene.validate(&scene.name)?;
    let refused = |reason: String| Error::Calibration { reason };
    let names: Vec<Parameter> = parameters.iter().map(|(parameter, _)| parameter.clone()).collect();
    if names.is_empty() || measured.is_empty() {
        return Err(refused("it needs a parameter and a measured backbone at least".into()));
    }
    for (number, name) in names.iter().enumerate() {
        name.value(scene)?;
        if names[..number].contains(name) {
            return Err(refused(format!("{name} is named twice; leave one out")));
        }
        if name.is_drawn() {
            return Err(refused(format!(
                "backbones do not change smoothly with {name}; take interfaces.scale.asperity_radius, interfaces.scale.asperity_density and interfaces.scale.asperity_height"
            )));
        }
    }
    Parameter::refuse_together(names.iter(), scene).map_err(refused)?;
    if !(noise.frequency_ln > 0.0 && noise.damping_ln > 0.0) {
        return Err(refused(
            "standard deviations of the measurement must be positive".into(),
        ));
    }
    let modes = measured.iter().map(|measured| {
        let place = scene
            .analyses
            .modes
            .followed
            .iter()
            .position(|mode| *mode == measured.mode);
        place.ok_or_else(|| {
            let followed: Vec<String> = scene.analyses.modes.followed.iter().map(usize::to_string).collect();
            refused(format!(
                "{} is of mode {}, and the scene follows {}; add it to analyses.modes.followed",
                measured.name,
                measured.mode,
                followed.join(", ")
            ))
        })
    });
    let modes: Vec<usize> = modes.collect::<Result<_, _>>()?;
    let Solved {
        structure,
        prepared,
        analysis,
    } = Solved::new(&loops_alone(scene, true), &names, Rates::None, options, progress)?;
    let variants = Variants::new(scene, names, &structure, &prepared, options);
    let nominal: Vec<f64> = variants
        .parameters()
        .iter()
        .map(|parameter| parameter.value(variants.scene()))
        .collect::<Result<_, _>>()?;
    let free: Vec<Free> = nominal
        .iter()
        .zip(parameters)
        .map(|(value, (_, prior))| Free::new(*value, prior.as_ref()))
        .collect();
    let before = variants.nominal(&analysis, nominal.clone());
    let at = DVector::from_iterator(free.len(), free.iter().map(|free| free.unbounded(free.start)));
    let mut problem = Problem {
        forces: forces(&before, measured, &modes)?,
        variants: &variants,
        nominal: &before,
        analysis: &analysis,
        measured,
        modes,
        free,
        noise,
        progress,
        at: at.clone(),
        found: Err(refused("not evaluated".into())),
        known: Vec::new(),
        checkpoints: analysis.checkpoints.clone(),
    };
    problem.set_params(&at);
    // Derivatives by differences, where it takes them, are known to four digits or so.
    let method = LevenbergMarquardt::new()
        .with_ftol(1e-8)
        .with_xtol(1e-6)
        .with_gtol(1e-8)
        .with_patience(20);
    let (mut problem, report) = method.minimize(problem);
    // Ended by an error, or at a step that was tried.
    let last = std::mem::replace(&mut problem.found, Err(refused(String::new())))?;
    let size = |evaluation: &Evaluation| evaluation.residuals.norm_squared();
    let best = problem.known.iter().min_by(|a, b| size(a).total_cmp(&size(b))).cloned();
    let best = best.unwrap_or(last);
    problem.at.copy_from(&best.at);
    let mut found = problem.result(&best)?;
    found.converged = report.termination.was_successful();
    found.ended = format!("{:?}", report.termination);
    Ok(found)
}

/// Modal forces of the modes followed at which the model has about the measured amplitudes, if it has the measured frequencies.
fn forces(nominal: &Variant, measured: &[Measured], modes: &[usize]) -> Result<Forces, Error> {
    let mut all: Forces = vec![Vec::new(); nominal.curves.len()];
    for (place, curve) in nominal.curves.iter().enumerate() {
        let mine: Vec<&Measured> = measured
            .iter()
            .zip(modes)
            .filter(|(_, mode)| **mode == place)
            .map(|(m, _)| m)
            .collect();
        if mine.is_empty() {
            continue;
        }
        let point = curve.points.first().ok_or_else(|| Error::Calibration {
            reason: format!("mode {}: the scene itself has no amplitude that converges", curve.mode),
        })?;
        let response = point.response_displacement / point.modal_amplitude;
        let points = mine.iter().flat_map(|measured| measured.backbone.points());
        let mut amplitudes: Vec<f64> = points.map(|point| point.amplitude).collect();
        amplitudes.sort_by(f64::total_cmp);
        amplitudes.dedup();
        let [low, high] = [0, amplitudes.len() - 1].map(|end| amplitudes[end]);
        if amplitudes.len() > LOOPS {
            let spread = |k: usize| low * (high / low).powf(k as f64 / (LOOPS - 1) as f64);
            amplitudes = (0..LOOPS).map(spread).collect();
        }
        amplitudes.insert(0, low / BEYOND);
        amplitudes.push(high * BEYOND);
        let force = |x: &f64| {
            let within = mine.iter().map(|measured| {
                let [a, b] = measured.backbone.range();
                measured
                    .backbone
                    .at(x.clamp(a, b))
                    .map_or(0.0, |(frequency, _)| frequency)
            });
            (TAU * within.sum::<f64>() / mine.len() as f64).powi(2) * x / response
        };
        all[place] = amplitudes.iter().map(force).collect();
    }
    Ok(all)
}

/// Points of a series that say as much as an independent one: one and twice the sum of the correlations of points of growing distance, as far
/// as the sum of two of them is positive (Geyer 1992, doi:10.1214/ss/1177011137).
fn integrated_correlation(residuals: &[f64]) -> f64 {
    let n = residuals.len();
    let at = |lag: usize| -> f64 {
        residuals
            .iter()
            .zip(residuals.iter().skip(lag))
            .map(|(a, b)| a * b)
            .sum()
    };
    let variance = at(0);
    if variance == 0.0 {
        return 1.0;
    }
    let pairs = (1..n).step_by(2).map(|lag| (at(lag) + at(lag + 1)) / variance);
    (1.0 + 2.0 * pairs.take_while(|pair| *pair > 0.0).sum::<f64>()).clamp(1.0, n as f64)
}

impl Problem<'_> {
    fn result(
        self,
        Evaluation {
            series,
            residuals,
            jacobian,
            model,
            ..
        }: &Evaluation,
    ) -> Result<Calibration, Error> {
        let varied = self.varied();
        let k = self.free.len();
        // Every parameter has a prior, if only a weak one.
        let data = series.len();
        let with_prior = self.free.iter().filter(|free| free.prior.is_some()).count();
        let freedom = (data + with_prior).saturating_sub(k).max(1);
        let reduced_chi_squared = residuals.norm_squared() / freedom as f64;
        // Rows of frequencies, and of damping ratios, along each backbone.
        let mut jacobian = jacobian.clone();
        let mut effective_observations = 0.0;
        for number in 0..2 * self.measured.len() {
            let rows = series.iter().enumerate().filter(|(_, series)| **series == number);
            let rows: Vec<usize> = rows.map(|(row, _)| row).collect();
            let along: Vec<f64> = rows.iter().map(|row| residuals[*row]).collect();
            let alike = integrated_correlation(&along);
            effective_observations += rows.len() as f64 / alike;
            rows.iter()
                .for_each(|row| jacobian.row_mut(*row).scale_mut(alike.sqrt().recip()));
        }
        let svd = jacobian.clone().svd(false, true);
        let directions = svd.v_t.ok_or_else(|| Error::Calibration {
            reason: "the Jacobian has no singular values".into(),
        })?;
        // A direction without any information has no finite variance; the least singular value keeps it a number.
        let least = svd.singular_values.max() * 1e-12;
        let factor = reduced_chi_squared.max(1.0);
        let covariance = |i: usize, j: usize| {
            let terms = (0..svd.singular_values.len()).map(|d| {
                directions[(d, i)] * directions[(d, j)]
                    / svd.singular_values[d].max(least).max(f64::MIN_POSITIVE).powi(2)
            });
            factor * terms.sum::<f64>()
        };
        let covariance: Vec<Vec<f64>> = (0..k).map(|i| (0..k).map(|j| covariance(i, j)).collect()).collect();
        let correlation = (0..k)
            .map(|i| {
                (0..k)
                    .map(|j| covariance[i][j] / (covariance[i][i] * covariance[j][j]).sqrt())
                    .collect()
            })
            .collect();
        // Of the data alone: what priors hold is not identified by them.
        let of_data = jacobian.rows(0, data).into_owned().svd(false, true);
        let mut unidentifiable = Vec::new();
        if let Some(directions) = &of_data.v_t {
            for (d, singular) in of_data
                .singular_values
                .iter()
                .enumerate()
                .filter(|(_, s)| **s * UNKNOWN < 1.0)
            {
                let weights = self
                    .variants
                    .parameters()
                    .iter()
                    .enumerate()
                    .map(|(i, name)| (name.to_string(), directions[(d, i)]));
                unidentifiable.push(Direction {
                    direction: weights.collect(),
                    singular_value: *singular,
                });
            }
        }
        let mut parameters = Vec::new();
        for (i, (free, name)) in self.free.iter().zip(self.variants.parameters()).enumerate() {
            let (estimate, sd) = (free.value(varied[i]), covariance[i][i].sqrt());
            parameters.push(Estimate {
                name: name.to_string(),
                unit: name.unit(self.variants.scene())?.to_owned(),
                before: self.nominal.inputs[i],
                estimate,
                standard_error: if free.logarithmic { estimate * sd } else { sd },
                interval_95: [-INTERVAL, INTERVAL].map(|z| free.value(varied[i] + z * sd)),
                logarithmic: free.logarithmic,
                prior: free.prior,
                bounds: free.bounds.map(|bounds| bounds.map(|bound| free.value(bound))),
            });
        }
        let mut points = Vec::new();
        for (measured, &mode) in self.measured.iter().zip(&self.modes) {
            for point in measured.backbone.points() {
                let curve = model.curves.get(mode);
                let found = curve.and_then(|curve| curve.at(Reading::Measured, point.amplitude));
                let Some([frequency_hz, damping]) = found else { continue };
                let damping_ratio = Some(damping).filter(|zeta| zeta.is_finite());
                points.push(Residual {
                    experiment: measured.name.clone(),
                    mode: measured.mode,
                    measured: *point,
                    frequency_hz,
                    damping_ratio,
                    frequency_ln: (frequency_hz / point.frequency_hz).ln(),
                    damping_ln: damping_ratio
                        .zip(point.damping_ratio)
                        .map(|(model, measured)| (model / measured).ln()),
                });
            }
        }
        let scene = self
            .variants
            .parameters()
            .iter()
            .zip(&parameters)
            .try_fold(self.variants.given().clone(), |scene, (name, found)| {
                name.with(&scene, found.estimate)
            })?;
        Ok(Calibration {
            parameters,
            covariance,
            correlation,
            unidentifiable,
            noise: self.noise,
            reduced_chi_squared,
            observations: data,
            effective_observations,
            evaluations: self.known.len(),
            converged: false,
            ended: String::new(),
            residuals: points,
            scene,
            checkpoints: self.checkpoints,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    #[test]
    fn what_is_smoothed_counts_for_as_many_points_as_are_independent() {
        let mut random = Pcg64::seed_from_u64(5);
        let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        let white: Vec<f64> = (0..20_000).map(|_| normal()).collect();
        assert!((integrated_correlation(&white) - 1.0).abs() < 0.1);
        // The spectrum of a moving average of m points at zero is m times its variance.
        let smooth: Vec<f64> = white.windows(15).map(|window| window.iter().sum()).collect();
        let found = integrated_correlation(&smooth);
        assert!((found / 15.0 - 1.0).abs() < 0.15, "{found}");
        assert_eq!(integrated_correlation(&[1.0; 40]), 40.0);
        assert_eq!(integrated_correlation(&[0.0; 3]), 1.0);
        assert_eq!(integrated_correlation(&[1.0, -1.0, 1.0]), 1.0);
    }
}
