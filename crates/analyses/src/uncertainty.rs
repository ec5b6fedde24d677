//! Bands of frequency and damping from inputs that are not known exactly.
//!
//! Samples of the inputs go through prestress, modes and loops, on the same reduced structure unless an input changes it. Everything depends
//! on the seed alone, so that neither the number of threads nor an interruption changes a bit. Beside the samples stands the linear
//! propagation of uncertainty (JCGM 100:2008, eq. 13) from the derivatives at the scene's own values.

use super::costs;
use super::ensemble::percentile;
use super::finite_differences::{self, AROUND, Gradient, values};
use super::sampling::samples;
use super::variants::{Curve, Rates, Reading, Solved, Variant, Variants};
use crate::{Error, Run};
use joints::progress::Progress;
use joints::store::Options;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use scenes::distribution::standard_normal;
use scenes::uncertain::{LAW_ERROR, beyond, of_parameter};
use scenes::{LawKind, Marginal, Parameter, Scene, Surface, TIGHTENING_SIGMAS, Uncertain};
use serde::{Deserialize, Serialize};
use statrs::distribution::{Binomial, DiscreteCDF};

/// Confidence of the intervals of band edges and of Sobol's indices.
pub const CONFIDENCE: f64 = 0.95;

/// Bootstrap replicates behind the intervals of Sobol's indices.
const REPLICATES: usize = 400;

/// Change of the logarithm of a frequency up to which derivatives choose the forces of a sample.
const FARTHEST: f64 = 0.3;

/// Bands of a scene with uncertain inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Uncertainty {
    /// Samples.
    pub samples: usize,
    /// How many of them have no backbone.
    pub failed: usize,
    /// How they were placed.
    pub method: String,
    /// Seed.
    pub seed: u64,
    /// Probability between the edges of the bands.
    pub confidence: f64,
    /// Runs of the scene with other numbers, those for derivatives and indices included.
    pub runs: usize,
    /// What is uncertain, in the order of the columns of inputs.
    pub inputs: Vec<Input>,
    /// The modes followed, in the order of the scene.
    pub modes: Vec<ModeBands>,
    /// What is known to be in error and is not in the bands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out: Option<String>,
    /// The samples themselves; in tables alone.
    #[serde(skip)]
    pub variants: Vec<Variant>,
}

/// An uncertain input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Input {
    /// Its path.
    pub parameter: Parameter,
    /// SI unit; empty for pure numbers.
    pub unit: String,
    /// Value in the scene.
    pub nominal: f64,
    /// Mean of the distribution.
    pub mean: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// Values that are not exceeded with a probability of 5, 50 and 95 %, or those of the confidence asked for.
    pub quantiles: [f64; 3],
    /// What was assumed about it beyond what the scene says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assumption: Option<String>,
}

/// Bands of a mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ModeBands {
    /// The mode, counted from 1.
    pub mode: usize,
    /// The linearised mode, and then the amplitudes of the scene's own backbone.
    pub bands: Vec<Band>,
}

/// What is known at an amplitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Band {
    /// Modal amplitude (sqrt(kg) m); 0 of the linearised mode, which has no damping.
    pub modal_amplitude: f64,
    /// Displacement amplitude at the response point in the scene's own backbone (m).
    pub response_displacement: f64,
    /// Frequency (Hz).
    pub frequency_hz: Spread,
    /// Total damping ratio. Below its floor it counts as below every other.
    pub damping_ratio: Spread,
}

/// How a quantity spreads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Spread {
    /// Of the scene's own backbone.
    pub nominal: Option<f64>,
    /// Samples that reach the amplitude.
    pub samples: usize,
    /// Mean; none where a sample has no value.
    pub mean: Option<f64>,
    /// Standard deviation; none where a sample has no value.
    pub sd: Option<f64>,
    /// Lower edge of the band, median and upper edge; none where the quantile lies among dampings below their floor.
    pub quantiles: [Option<f64>; 3],
    /// Half the width of a 95 % confidence interval of either edge, from order statistics; none where there are too few samples for one.
    pub half_widths: [Option<f64>; 2],
    /// The quantiles of the first half of the samples.
    pub of_first_half: [Option<f64>; 3],
    /// By linear propagation; none where a derivative is.
    pub linear: Option<Linear>,
    /// Shares of the variance by linear propagation, the largest first; of correlated inputs they may be negative.
    pub shares: Vec<Share>,
    /// Sobol's indices, in the order of the inputs; empty unless asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub indices: Vec<Index>,
}

/// Linear propagation of uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Linear {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Edges of the band and median, of a normal distribution.
    pub quantiles: [f64; 3],
}

/// An input's share of the variance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Share {
    /// The input.
    pub parameter: Parameter,
    /// Share (-).
    pub share: f64,
}

/// Sobol's indices of an input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Index {
    /// The input.
    pub parameter: Parameter,
    /// Share of the variance by the input alone (-).
    pub first: f64,
    /// 95 % bootstrap interval of it.
    pub first_interval: [f64; 2],
    /// Share of the variance with the input's interactions (-).
    pub total: f64,
    /// 95 % bootstrap interval of it.
    pub total_interval: [f64; 2],
    /// Samples that it is from.
    pub samples: usize,
}

/// Runs a scene and `number` samples of its uncertain inputs; `seed` stands for that of the scene. With a cache, samples of an interrupted
/// run are taken from there.
///
/// # Errors
/// As [`run`](super::run); [`scenes::Error::Uncertain`] for a scene without uncertain inputs, or for a sample that the scene refuses.
pub fn run_samples(
    scene: &Scene,
    number: usize,
    seed: Option<u64>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<(Run, Uncertainty), Error> {
    scene.validate(&scene.name)?;
    let asked = asked(scene)?;
    let uncertain = &asked.with_law_error(scene);
    if number < 2 {
        return Err(scenes::Error::Uncertain {
            field: "parameters".into(),
            reason: format!("{number} samples make no band; ask for 2 at least, and for 100 to know its edges"),
        }
        .into());
    }
    let parameters: Vec<Parameter> = uncertain.parameters.keys().cloned().collect();
    let marginals = uncertain.marginals(scene)?;
    let seed = seed.unwrap_or(uncertain.seed);
    let [first, second] = samples(uncertain, scene, seed, number, uncertain.sobol_indices)?;
    for sample in first.iter().chain(&second) {
        refuse(&parameters, &marginals, scene, sample)?;
    }
    costs::expect_samples(first.len() + second.len() * (1 + marginals.len()), progress);
    let Solved {
        structure,
        prepared,
        mut analysis,
    } = Solved::new(scene, &parameters, Rates::WhereTheyCostLittle, options, progress)?;
    let variants = Variants::new(scene, parameters, &structure, &prepared, options);
    if variants.changes_the_structure() {
        progress.note(
            "an uncertain input changes the structure: it is built anew for every sample, and reduced anew unless its matrices are multiples \
             of those of the scene",
        );
    }
    let values = variants
        .parameters()
        .iter()
        .map(|parameter| parameter.value(variants.scene()));
    let nominal = variants.nominal(&analysis, values.collect::<Result<_, _>>()?);
    let moments: Vec<[f64; 2]> = marginals.iter().map(Marginal::moments).collect();
    let steps = nominal
        .inputs
        .iter()
        .zip(&moments)
        .map(|(value, [_, sd])| finite_differences::step(*value, *sd));
    let steps: Vec<f64> = steps.collect();

    let known = |parameter: &Parameter| -> Option<Vec<Gradient>> {
        let modes = nominal.curves.iter();
        modes.map(|curve| gradient(parameter, curve)).collect()
    };
    let known: Vec<Option<Vec<Gradient>>> = variants.parameters().iter().map(known).collect();
    // Those of all other parameters are differences.
    let unknown = (0..known.len()).filter(|place| known[*place].is_none());
    let near = variants.forces(&nominal, &|_, _| 1.0, &AROUND);
    let inputs = (nominal.inputs.as_slice(), steps.as_slice());
    let (pairs, checkpoints) = finite_differences::pairs(&variants, inputs, unknown, &near, &analysis, progress)?;
    analysis.checkpoints.extend(checkpoints);
    let derivative_runs = 2 * pairs.len();
    let mut pairs = pairs.into_iter();
    let all = known.into_iter().zip(variants.parameters()).enumerate();
    let all = all.filter_map(|(place, (known, parameter))| {
        known.or_else(|| {
            let pair = pairs.next()?;
            let modes = 0..nominal.curves.len();
            let of = |mode| finite_differences::gradient(parameter, place, &nominal, &pair, mode);
            Some(modes.map(of).collect())
        })
    });
    let all: Vec<Vec<Gradient>> = all.collect();
    let sensitivities: Vec<Vec<Gradient>> = (0..nominal.curves.len())
        .map(|mode| all.iter().map(|of_modes| of_modes[mode].clone()).collect())
        .collect();

    let exchanged = (0..if second.is_empty() { 0 } else { marginals.len() }).flat_map(|place| {
        first.iter().zip(&second).map(move |(a, b)| {
            let mut inputs = a.clone();
            inputs[place] = b[place];
            inputs
        })
    });
    let exchanged: Vec<Vec<f64>> = exchanged.collect();
    let with_forces = |inputs: Vec<f64>| {
        // A force is the square of the circular frequency times the modal amplitude: its derivative at fixed amplitude is twice that of
        // the frequency. So samples land beside the amplitudes where they are asked for, and little is left to interpolation.
        let factor =
            |mode: usize, amplitude: f64| (2.0 * moved(&sensitivities[mode], &nominal, &inputs, amplitude)).exp();
        let forces = variants.forces(&nominal, &factor, &[1.0]);
        (inputs, forces)
    };
    let inputs: Vec<_> = [first, second, exchanged]
        .concat()
        .into_iter()
        .map(with_forces)
        .collect();
    let (mut samples, checkpoints) = variants.run("samples", &inputs, Rates::None, &analysis, progress)?;
    analysis.checkpoints.extend(checkpoints);
    let of_indices = samples.split_off(number);
    let runs = Runs {
        variants: &variants,
        nominal: &nominal,
        samples: &samples,
        sensitivities: &sensitivities,
        of_indices: &of_indices,
    };
    let knowledge = Knowledge::new(uncertain, &marginals, &moments)?;
    let modes = (0..nominal.curves.len()).map(|mode| runs.bands(mode, &knowledge));
    let modes = modes.collect();
    let inputs_of = variants
        .parameters()
        .iter()
        .zip(&marginals)
        .zip(&moments)
        .zip(&nominal.inputs);
    let described = inputs_of.map(|(((parameter, marginal), [mean, sd]), nominal)| {
        Ok(Input {
            parameter: parameter.clone(),
            unit: parameter.unit(variants.scene())?.to_owned(),
            nominal: *nominal,
            mean: *mean,
            sd: *sd,
            quantiles: knowledge.probabilities.map(|p| marginal.quantile(p)),
            assumption: assumption(asked, parameter),
        })
    });
    let found = Uncertainty {
        samples: number,
        failed: samples.iter().filter(|variant| variant.failure.is_some()).count(),
        method: uncertain.method.name().to_owned(),
        seed,
        confidence: uncertain.confidence,
        runs: derivative_runs + inputs.len(),
        inputs: described.collect::<Result<_, Error>>()?,
        modes,
        left_out: left_out(scene, uncertain),
        variants: samples,
    };
    let bodies = prepared.bodies(&analysis, progress)?;
    Ok((prepared.finish(analysis, bodies, progress), found))
}

/// The derivatives of a mode's backbone that its loops have brought along; amplitude 0 is the linearised mode.
fn gradient(parameter: &Parameter, curve: &Curve) -> Option<Gradient> {
    let (found, rates) = curve.derivatives(parameter, Reading::Modal)?;
    let amplitudes = curve.points.iter().map(|point| point.modal_amplitude);
    Some(Gradient {
        parameter: parameter.clone(),
        modal_amplitude: std::iter::once(0.0).chain(amplitudes).collect(),
        dln_frequency: std::iter::once(Some(found.dln_linear_frequency))
            .chain(rates.iter().map(|[frequency, _]| *frequency))
            .collect(),
        dln_damping: std::iter::once(None)
            .chain(rates.iter().map(|[_, damping]| *damping))
            .collect(),
    })
}

/// By how much the logarithm of the frequency moves with the inputs, to first order; as far as derivatives are known.
fn moved(sensitivities: &[Gradient], nominal: &Variant, inputs: &[f64], amplitude: f64) -> f64 {
    let terms = sensitivities
        .iter()
        .zip(inputs)
        .zip(&nominal.inputs)
        .map(|((sensitivity, value), nominal)| {
            let by = match value / nominal {
                ratio if ratio > 0.0 && ratio.is_finite() => ratio.ln(),
                ratio if ratio.is_finite() => ratio - 1.0,
                _ => *value,
            };
            sensitivity.at(amplitude)[0].unwrap_or(0.0) * by
        });
    // Far from the scene's own values the line says little.
    terms.sum::<f64>().clamp(-FARTHEST, FARTHEST)
}

fn asked(scene: &Scene) -> Result<&Uncertain, Error> {
    let asked = scene.uncertain.as_ref().ok_or_else(|| scenes::Error::Uncertain {
        field: "parameters".into(),
        reason: "the scene says of no number how well it is known; add for example \"uncertain\": { \"parameters\": { \"mu\": { \
                 \"normal\": { \"sd\": 0.02 } } } }"
            .into(),
    });
    Ok(asked?)
}

/// Refuses a sample with a value that the scene refuses. What lies between two values that it accepts is accepted.
fn refuse(parameters: &[Parameter], marginals: &[Marginal], scene: &Scene, sample: &[f64]) -> Result<(), Error> {
    for ((parameter, marginal), value) in parameters.iter().zip(marginals).zip(sample) {
        let [low, high] = [1e-6, 1.0 - 1e-6].map(|p| marginal.quantile(p));
        if !(low..=high).contains(value)
            && let Err(error) = parameter.with(scene, *value)
        {
            return Err(of_parameter(parameter, beyond(*value, &error)).into());
        }
    }
    Ok(())
}

/// The error of the law, unless an input stands for it.
fn left_out(scene: &Scene, uncertain: &Uncertain) -> Option<String> {
    if uncertain.parameters.keys().any(Parameter::is_asperity_height) {
        return None;
    }
    let interfaces = scene.interfaces.single();
    let mut of_asperities = interfaces
        .filter(|one| !matches!(one.surface, Surface::Parameters(_)))
        .peekable();
    of_asperities.peek()?;
    Some(match of_asperities.all(|one| one.law.kind == LawKind::BoundaryElements) {
        true => "the error of the traction law is not in the bands: against boundary elements of faces that were held out its stiffness was right \
                 within 5 %; scatter between faces of one kind is not in it"
            .into(),
        false => "the error of the traction law is not in the bands: asperity sums have 0.9, 0.7 and 0.5 times the stiffness of boundary \
                  elements at 5, 20 and 50 MPa, and patches scatter by 0.2; leave out uncertain.law_error to have it in"
            .into(),
    })
}

/// What was assumed of an input: the error of the law, or what turns a method of tightening into a distribution.
fn assumption(asked: &Uncertain, parameter: &Parameter) -> Option<String> {
    let Some(distribution) = asked.parameters.get(parameter) else {
        let factor = asked.law_error.unwrap_or(LAW_ERROR);
        return Some(format!(
            "the error of the traction law, a factor of {factor} on the stiffness: against boundary elements, asperity sums \
             err by factors of 1.36, 1.52 and 2.04 at 5, 20 and 50 MPa (root mean square); another factor, or 1 to leave it out, is uncertain.law_error"
        ));
    };
    let method = distribution.tightening?;
    let [low, high] = method.alpha_a();
    let alpha = distribution.alpha_a.unwrap_or(high);
    let range = match distribution.alpha_a {
        Some(_) => "as given".to_owned(),
        None => format!("the largest of {low} to {high} in VDI 2230-1, table A8"),
    };
    Some(format!(
        "tightening factor {alpha}, {range}; normal, with the smallest and the largest preload at {TIGHTENING_SIGMAS} standard deviations \
         from the mean"
    ))
}

/// What is known of the inputs.
struct Knowledge {
    covariance: Vec<Vec<f64>>,
    means: Vec<f64>,
    /// Of lower edge, median and upper edge.
    probabilities: [f64; 3],
    seed: u64,
}

impl Knowledge {
    fn new(uncertain: &Uncertain, marginals: &[Marginal], moments: &[[f64; 2]]) -> Result<Self, Error> {
        let correlation = uncertain.correlation()?;
        let n = marginals.len();
        let covariance = |i: usize, j: usize| match (i == j, correlation[i][j]) {
            (true, _) => moments[i][1].powi(2),
            (false, 0.0) => 0.0,
            (false, correlation) => marginals[i].covariance(&marginals[j], correlation),
        };
        let tail = 0.5 * (1.0 - uncertain.confidence);
        Ok(Self {
            covariance: (0..n).map(|i| (0..n).map(|j| covariance(i, j)).collect()).collect(),
            means: moments.iter().map(|[mean, _]| *mean).collect(),
            probabilities: [tail, 0.5, 1.0 - tail],
            seed: uncertain.seed,
        })
    }
}

/// All runs of a scene with uncertain inputs.
struct Runs<'a> {
    variants: &'a Variants<'a>,
    nominal: &'a Variant,
    samples: &'a [Variant],
    /// By all inputs, of each mode.
    sensitivities: &'a [Vec<Gradient>],
    /// A second set of samples, and the first with each input in turn taken from the second; none unless indices are asked for.
    of_indices: &'a [Variant],
}

impl Runs<'_> {
    fn bands(&self, mode: usize, knowledge: &Knowledge) -> ModeBands {
        let curve = &self.nominal.curves[mode];
        let mut amplitudes = vec![(0.0, 0.0)];
        amplitudes.extend(
            curve
                .points
                .iter()
                .map(|point| (point.modal_amplitude, point.response_displacement)),
        );
        let band = |(modal_amplitude, response_displacement): (f64, f64)| {
            let spread = |which: usize| self.spread(mode, modal_amplitude, which, knowledge);
            Band {
                modal_amplitude,
                response_displacement,
                frequency_hz: spread(0),
                damping_ratio: spread(1),
            }
        };
        ModeBands {
            mode: curve.mode,
            bands: amplitudes.into_iter().map(band).collect(),
        }
    }

    /// Spread of frequency (0) or damping (1).
    fn spread(&self, mode: usize, amplitude: f64, which: usize, knowledge: &Knowledge) -> Spread {
        let of = |variant: &Variant| -> Option<f64> {
            let curve = variant.curves.get(mode)?;
            match (amplitude == 0.0, which) {
                (true, 0) => Some(curve.linear_frequency_hz),
                (true, _) => None,
                (false, _) => curve.at(Reading::Modal, amplitude).map(|found| found[which]),
            }
        };
        let all: Vec<Option<f64>> = self.samples.iter().map(of).collect();
        let half: Vec<f64> = all.iter().take(all.len() / 2).copied().flatten().collect();
        let mut sorted: Vec<f64> = all.into_iter().flatten().collect();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        let complete = n > 1 && sorted[0].is_finite();
        let mean = sorted.iter().sum::<f64>() / n as f64;
        let variance = sorted.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n as f64 - 1.0);
        let nominal = values(self.nominal, mode, amplitude)[which];
        let derivatives: Option<Vec<f64>> = self.sensitivities[mode]
            .iter()
            .map(|sensitivity| sensitivity.at(amplitude)[which])
            .collect();
        let (linear, shares) = match nominal.zip(derivatives) {
            Some((nominal, derivatives)) => self.linear(nominal, &derivatives, knowledge),
            None => (None, Vec::new()),
        };
        Spread {
            nominal,
            samples: n,
            mean: complete.then_some(mean),
            sd: complete.then(|| variance.sqrt()),
            quantiles: quantiles(&sorted, knowledge.probabilities),
            half_widths: [knowledge.probabilities[0], knowledge.probabilities[2]].map(|p| half_width(&sorted, p)),
            of_first_half: {
                let mut half = half;
                half.sort_by(f64::total_cmp);
                quantiles(&half, knowledge.probabilities)
            },
            linear,
            shares,
            indices: self.indices(&of, knowledge.seed),
        }
    }

    /// Linear propagation from logarithmic derivatives.
    fn linear(&self, nominal: f64, derivatives: &[f64], knowledge: &Knowledge) -> (Option<Linear>, Vec<Share>) {
        let inputs = &self.nominal.inputs;
        // By the inputs themselves.
        let slopes = derivatives
            .iter()
            .zip(inputs)
            .map(|(slope, value)| if *value == 0.0 { *slope } else { slope / value });
        let slopes: Vec<f64> = slopes.map(|slope| slope * nominal).collect();
        let parts: Vec<f64> = slopes
            .iter()
            .zip(&knowledge.covariance)
            .map(|(slope, row)| {
                slope
                    * row
                        .iter()
                        .zip(&slopes)
                        .map(|(covariance, other)| covariance * other)
                        .sum::<f64>()
            })
            .collect();
        let variance: f64 = parts.iter().sum();
        let moved = slopes
            .iter()
            .zip(&knowledge.means)
            .zip(inputs)
            .map(|((slope, mean), value)| slope * (mean - value));
        let (mean, sd) = (nominal + moved.sum::<f64>(), variance.max(0.0).sqrt());
        let mut shares: Vec<Share> = Vec::new();
        if variance > 0.0 {
            let all = self.variants.parameters().iter().zip(&parts);
            shares.extend(all.map(|(parameter, part)| Share {
                parameter: parameter.clone(),
                share: part / variance,
            }));
            shares.sort_by(|a, b| b.share.total_cmp(&a.share));
        }
        let quantiles = knowledge.probabilities.map(|p| mean + sd * standard_normal(p));
        (Some(Linear { mean, sd, quantiles }), shares)
    }

    /// Sobol's indices by Jansen's estimators (Jansen 1999, doi:10.1016/S0010-4655(98)00154-4; Saltelli et al. 2010,
    /// doi:10.1016/j.cpc.2009.09.018, table 2), over the samples of which all runs have a value.
    fn indices(&self, of: &dyn Fn(&Variant) -> Option<f64>, seed: u64) -> Vec<Index> {
        let n = self.samples.len();
        let mut sets = self.of_indices.chunks_exact(n);
        let Some(second) = sets.next() else {
            return Vec::new();
        };
        let finite = |variant: &Variant| of(variant).filter(|value| value.is_finite());
        let index = |(parameter, exchanged): (&Parameter, &[Variant])| {
            let rows = (0..n).filter_map(|row| {
                Some([
                    finite(&self.samples[row])?,
                    finite(&second[row])?,
                    finite(&exchanged[row])?,
                ])
            });
            let rows: Vec<[f64; 3]> = rows.collect();
            let [first, total] = jansen(rows.iter().copied())?;
            let mut random = Pcg64::seed_from_u64(seed);
            let mut replicates = [Vec::new(), Vec::new()];
            for _ in 0..REPLICATES {
                let drawn = (0..rows.len()).map(|_| rows[random.random_range(0..rows.len())]);
                if let Some(found) = jansen(drawn.collect::<Vec<_>>().into_iter()) {
                    replicates
                        .iter_mut()
                        .zip(found)
                        .for_each(|(all, value)| all.push(value));
                }
            }
            let [first_interval, total_interval] = replicates.map(|mut all| {
                all.sort_by(f64::total_cmp);
                let tail = 0.5 * (1.0 - CONFIDENCE);
                if all.is_empty() {
                    [f64::NAN; 2]
                } else {
                    [tail, 1.0 - tail].map(|p| percentile(&all, p))
                }
            });
            Some(Index {
                parameter: parameter.clone(),
                first,
                first_interval,
                total,
                total_interval,
                samples: rows.len(),
            })
        };
        self.variants.parameters().iter().zip(sets).filter_map(index).collect()
    }
}

/// First-order and total index from the values of a sample, of a second one, and of the first with one input of the second.
fn jansen(rows: impl Iterator<Item = [f64; 3]> + Clone) -> Option<[f64; 2]> {
    let n = rows.clone().count() as f64;
    let mean = rows.clone().map(|[a, b, _]| a + b).sum::<f64>() / (2.0 * n);
    let variance = rows
        .clone()
        .map(|[a, b, _]| (a - mean).powi(2) + (b - mean).powi(2))
        .sum::<f64>()
        / (2.0 * n - 1.0);
    let half =
        |difference: fn([f64; 3]) -> f64| rows.clone().map(|row| difference(row).powi(2)).sum::<f64>() / (2.0 * n);
    let found = [
        1.0 - half(|[_, b, c]| b - c) / variance,
        half(|[a, _, c]| a - c) / variance,
    ];
    (variance > 0.0 && n > 1.0).then_some(found)
}

fn quantiles(sorted: &[f64], probabilities: [f64; 3]) -> [Option<f64>; 3] {
    probabilities.map(|p| {
        (!sorted.is_empty())
            .then(|| percentile(sorted, p))
            .filter(|value| value.is_finite())
    })
}

/// Half the width of the interval between order statistics that has the quantile with [`CONFIDENCE`] or more, whatever the distribution
/// (David and Nagaraja, Order Statistics, 2003, section 7.1).
fn half_width(sorted: &[f64], p: f64) -> Option<f64> {
    let tail = 0.5 * (1.0 - CONFIDENCE);
    let below = Binomial::new(p, sorted.len() as u64).ok()?;
    // The rank r, from 1, is below the quantile with the probability that r samples or more are.
    let low = usize::try_from(below.inverse_cdf(tail)).ok()?.checked_sub(1)?;
    let high = usize::try_from(below.inverse_cdf(1.0 - tail)).ok()?;
    let (low, high) = (sorted.get(low)?, sorted.get(high)?);
    Some(0.5 * (high - low)).filter(|width| width.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_of_quantiles_cover_them_as_often_as_they_say() {
        let mut random = Pcg64::seed_from_u64(11);
        for (n, p) in [(100, 0.05), (200, 0.5), (500, 0.95)] {
            let trials = 2000;
            let mut covered = 0;
            for _ in 0..trials {
                let mut sorted: Vec<f64> = (0..n).map(|_| random.random()).collect();
                sorted.sort_by(f64::total_cmp);
                let below = Binomial::new(p, n as u64).unwrap();
                let [low, high] = [0.025, 0.975].map(|tail| below.inverse_cdf(tail) as usize);
                let [low, high] = [sorted[low - 1], sorted[high]];
                assert!((half_width(&sorted, p).unwrap() - 0.5 * (high - low)).abs() < 1e-15);
                covered += usize::from((low..=high).contains(&p));
            }
            let share = covered as f64 / trials as f64;
            assert!(share > 0.94 && share < 0.985, "{n} {p}: {share}");
        }
        assert!(half_width(&[0.1, 0.2, 0.3], 0.05).is_none());
    }

    #[test]
    fn indices_of_the_ishigami_function_are_the_closed_form() {
        use crate::sampling::unit_cube;
        use scenes::SamplingMethod;
        use std::f64::consts::PI;
        let (a, b) = (7.0, 0.1);
        let f = |x: [f64; 3]| x[0].sin() + a * x[1].sin().powi(2) + b * x[2].powi(4) * x[0].sin();
        let cube = unit_cube(SamplingMethod::Sobol, 1, 8192, 6).unwrap();
        let at = |p: &[f64], from: usize| [0, 1, 2].map(|k| PI * (2.0 * p[from + k] - 1.0));
        let variance = a * a / 8.0 + b * PI.powi(4) / 5.0 + b * b * PI.powi(8) / 18.0 + 0.5;
        let alone = [0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2), a * a / 8.0, 0.0];
        let together = b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
        let all = [alone[0] + together, alone[1], together];
        for place in 0..3 {
            let rows = cube.iter().map(|p| {
                let (first, second) = (at(p, 0), at(p, 3));
                let mut exchanged = first;
                exchanged[place] = second[place];
                [f(first), f(second), f(exchanged)]
            });
            let [first, total] = jansen(rows).unwrap();
            assert!((first - alone[place] / variance).abs() < 0.01, "{place}: {first}");
            assert!((total - all[place] / variance).abs() < 0.01, "{place}: {total}");
        }
    }
}
