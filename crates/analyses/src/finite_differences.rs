//! Derivatives of backbones by central differences: what is there of parameters that have no gradient.

use super::mode_backbone::ModeAnalysis;
use super::outcome::Analysis;
use super::sensitivities::{FoundBy, Per, Sensitivity};
use super::variants::{Forces, Rates, Variant, Variants};
use crate::Error;
use joints::progress::Progress;
use joints::store::checkpoint::Checkpoints;
use scenes::Parameter;
use serde::{Deserialize, Serialize};

/// Step relative to the value of a parameter. The error of central differences is its square times the third derivative; loops converge to 1e-9.
/// It is less than half of what [`AROUND`] spans, so that backbones of both sides have loops on either side of an amplitude.
const STEP: f64 = 1e-3;

/// Factors on the forces of the scene's own amplitudes: there are loops on either side of each of them, and a straight line between
/// the two, whose error is the same above and below. Cubics through widely spaced amplitudes have slopes that are off by as much as the
/// derivatives.
pub(super) const AROUND: [f64; 2] = [0.998, 1.002];

/// Derivatives of a backbone by a parameter, at fixed modal amplitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Gradient {
    /// The parameter.
    pub parameter: Parameter,
    /// Modal amplitudes (sqrt(kg) m); 0 of the linearised mode.
    pub modal_amplitude: Vec<f64>,
    /// Derivatives of the logarithm of the frequency by that of the parameter, or by the parameter (per its SI unit) where its value is 0.
    pub dln_frequency: Vec<Option<f64>>,
    /// The same of the damping ratio; none where it is below its floor.
    pub dln_damping: Vec<Option<f64>>,
}

impl Gradient {
    /// Derivatives of frequency and damping at one of its amplitudes.
    pub fn at(&self, modal_amplitude: f64) -> [Option<f64>; 2] {
        let place = self.modal_amplitude.iter().position(|known| *known == modal_amplitude);
        let of = |values: &[Option<f64>]| place.and_then(|place| values.get(place).copied().flatten());
        [of(&self.dln_frequency), of(&self.dln_damping)]
    }
}

/// Step (SI) of a parameter with this value and, where it is 0, this standard deviation.
pub(super) fn step(nominal: f64, sd: f64) -> f64 {
    if nominal == 0.0 {
        0.01 * sd
    } else {
        STEP * nominal.abs()
    }
}

/// Variants above and below its parameters at these places in turn, from `inputs` by `steps` (SI), with what lets them resume.
///
/// # Errors
/// An interruption.
pub(super) fn pairs(
    variants: &Variants<'_>,
    (inputs, steps): (&[f64], &[f64]),
    places: impl Iterator<Item = usize>,
    forces: &Forces,
    analysis: &Analysis,
    progress: &dyn Progress,
) -> Result<(Vec<[Variant; 2]>, Checkpoints), Error> {
    let moved = |place: usize, by: f64| {
        let mut inputs = inputs.to_vec();
        inputs[place] += by;
        (inputs, forces.clone())
    };
    let inputs: Vec<_> = places
        .flat_map(|place| [moved(place, steps[place]), moved(place, -steps[place])])
        .collect();
    if inputs.is_empty() {
        return Ok((Vec::new(), Checkpoints::default()));
    }
    let (runs, checkpoints) = variants.run("runs for derivatives", &inputs, Rates::None, analysis, progress)?;
    let mut runs = runs.into_iter();
    let pairs = std::iter::from_fn(|| Some([runs.next()?, runs.next()?]));
    Ok((pairs.collect(), checkpoints))
}

/// Frequency and damping of a mode at an amplitude; amplitude 0 is the linearised mode. Damping below its floor is none.
pub(super) fn values(variant: &Variant, mode: usize, amplitude: f64) -> [Option<f64>; 2] {
    let Some(curve) = variant.curves.get(mode) else {
        return [None; 2];
    };
    if amplitude == 0.0 {
        return [Some(curve.linear_frequency_hz), None];
    }
    curve.between(amplitude)
}

/// Derivatives of a mode's backbone by the parameter at `place` from the runs above and below its value, at the amplitudes of the scene's own
/// backbone; from one of the runs and the scene's own where the other has no value.
pub(super) fn gradient(
    parameter: &Parameter,
    place: usize,
    nominal: &Variant,
    [above, below]: &[Variant; 2],
    mode: usize,
) -> Gradient {
    let is_relative = nominal.inputs[place] != 0.0;
    let coordinate = |variant: &Variant| {
        let value = variant.inputs[place];
        if is_relative { value.abs().ln() } else { value }
    };
    let derivative = |amplitude: f64, which: usize| {
        let of = |variant| Some((values(variant, mode, amplitude)[which]?.ln(), coordinate(variant)));
        let (up, down) = (of(above).or_else(|| of(nominal))?, of(below).or_else(|| of(nominal))?);
        let width = up.1 - down.1;
        (width != 0.0).then(|| (up.0 - down.0) / width)
    };
    let own = nominal.curves[mode].points.iter().map(|point| point.modal_amplitude);
    let amplitudes: Vec<f64> = std::iter::once(0.0).chain(own).collect();
    let all = |which: usize| {
        amplitudes
            .iter()
            .map(|amplitude| derivative(*amplitude, which))
            .collect()
    };
    Gradient {
        parameter: parameter.clone(),
        dln_frequency: all(0),
        dln_damping: all(1),
        modal_amplitude: amplitudes,
    }
}

/// Derivatives of the backbones of all modes with respect to the parameters of a variants, mode by mode, with what lets their runs resume.
///
/// # Errors
/// [`scenes::Error::Parameter`] for a parameter that is zero; an interruption.
pub(super) fn sensitivities(
    variants: &Variants<'_>,
    analysis: &Analysis,
    progress: &dyn Progress,
) -> Result<(Vec<Vec<Sensitivity>>, Checkpoints), Error> {
    let mut values = Vec::with_capacity(variants.parameters().len());
    for parameter in variants.parameters() {
        let value = parameter.value(variants.scene())?;
        if value == 0.0 {
            return Err(scenes::Error::Parameter {
                path: parameter.path().into(),
                reason:
                    "it is zero, and its derivatives are differences over a thousandth of its value; give it a value"
                        .into(),
            }
            .into());
        }
        values.push(value);
    }
    let steps: Vec<f64> = values.iter().map(|value| step(*value, 0.0)).collect();
    let nominal = variants.nominal(analysis, values);
    let forces = variants.forces(&nominal, &|_, _| 1.0, &AROUND);
    let places = 0..steps.len();
    let (pairs, checkpoints) = pairs(variants, (&nominal.inputs, &steps), places, &forces, analysis, progress)?;
    let mut all = Vec::with_capacity(analysis.modes.len());
    for mode in 0..analysis.modes.len() {
        let parameters = variants.parameters().iter().zip(&pairs).enumerate();
        let of_mode = parameters.map(|(place, (parameter, pair))| {
            let gradient = gradient(parameter, place, &nominal, pair, mode);
            of_gradient(
                variants,
                &analysis.modes[mode],
                &nominal,
                &gradient,
                (mode, place),
                pair,
            )
        });
        all.push(of_mode.collect::<Result<_, Error>>()?);
    }
    Ok((all, checkpoints))
}

/// A gradient at all amplitudes of a mode, by the parameter at `place`.
fn of_gradient(
    variants: &Variants<'_>,
    found: &ModeAnalysis,
    nominal: &Variant,
    gradient: &Gradient,
    (mode, place): (usize, usize),
    pair: &[Variant; 2],
) -> Result<Sensitivity, Error> {
    let missing = || Error::Derivatives {
        of: "the scene with a parameter a thousandth larger or smaller, which has no backbone",
    };
    let shape = |variant: &Variant| {
        let point = variant.curves.get(mode)?.points.first()?;
        Some((point.response_displacement / point.modal_amplitude).ln())
    };
    let [above, below] = pair.each_ref();
    let (up, down) = shape(above).zip(shape(below)).ok_or_else(missing)?;
    let width = (above.inputs[place] / below.inputs[place]).ln();
    let amplitudes: Vec<Option<f64>> = found
        .amplitudes
        .iter()
        .map(|one| Some(one.point.result.as_ref().ok()?.modal_amplitude))
        .collect();
    let curve = &nominal.curves[mode];
    let damping = |q: f64| {
        let point = curve.points.iter().find(|point| point.modal_amplitude == q)?;
        Some(gradient.at(q)[1]? / curve.contact_share(point.damping_ratio?))
    };
    let of = |value: &dyn Fn(f64) -> Option<f64>| amplitudes.iter().map(|q| value((*q)?)).collect();
    let none = || vec![None; amplitudes.len()];
    Ok(Sensitivity {
        mode: found.mode,
        method: "cqsma".into(),
        parameter: gradient.parameter.clone(),
        value: nominal.inputs[place],
        unit: gradient.parameter.unit(variants.scene())?.into(),
        per: Per::Logarithm,
        by: FoundBy::CentralDifferences,
        dln_linear_frequency: gradient.at(0.0)[0].ok_or_else(missing)?,
        dln_mode_shape: (up - down) / width,
        dln_frequency: of(&|q| gradient.at(q)[0]),
        dln_damping: of(&damping),
        dln_frequency_first_harmonic: none(),
        dln_damping_first_harmonic: none(),
        dln_dissipation: none(),
        dln_response: none(),
        modal_amplitude: amplitudes,
    })
}
