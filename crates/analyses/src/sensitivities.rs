//! Derivatives of backbones with respect to numbers of the scene.

use super::effects::Effects;
use super::prestress::{load_of, response};
use crate::Error;
use cqsma_solver::Linearisation;
use cqsma_solver::cqsma::LoopResult;
use cqsma_solver::prestress::Prestress;
use cqsma_solver::sensitivity::{Change, Derivatives, LoopRate, ModeRate, ParameterRate, StaticRate, static_rates};
use dense_algebra::{SystemMatrix, dot};
use harmonic_balance::backbone::{self, Motion, MotionRate, Point};
use joints::interface::{InterfaceForce, SceneInterface};
use joints::progress::Progress;
use joints::structure::{StructuralModel, Structure};
use rayon::prelude::*;
use reduction::ReducedModel;
use scenes::{BoltBehaviour, EPMC, Influence, Parameter, Scene};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use zte_assembly::{State, Variation};

/// Relative distance of neighbouring values over which ingredients that change smoothly are differenced.
const STEP: f64 = 1e-4;

/// The same for matrices, whose modes are known to less than round-off.
const STRUCTURAL_STEP: f64 = 1e-3;

/// Distance of neighbouring values of a number that is zero, in its unit: a slope of the gap (rad), as a rule.
const STEP_FROM_ZERO: f64 = 1e-6;

/// What a derivative is with respect to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Per {
    /// The logarithm of the parameter.
    Logarithm,
    /// The parameter, whose value is zero, in its SI unit.
    Value,
}

/// How derivatives are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum FoundBy {
    /// Implicit differentiation along the loops, or of the periodic motions.
    ImplicitDifferentiation,
    /// Central differences of whole backbones.
    CentralDifferences,
}

/// Derivatives of the backbone of a mode with respect to a parameter, amplitude by amplitude: none where there is no result, and of the
/// damping where it is not resolved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Sensitivity {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Method that found the backbone: `cqsma` or `epmc`.
    pub method: String,
    /// Path of the parameter in the scene.
    pub parameter: Parameter,
    /// Its value (SI).
    pub value: f64,
    /// Its SI unit; empty for a pure number.
    pub unit: String,
    /// What the derivatives are with respect to.
    pub per: Per,
    /// How they are found. Central differences give frequency and damping of the secant alone.
    pub by: FoundBy,
    /// Of the logarithm of the linearised frequency (-).
    pub dln_linear_frequency: f64,
    /// Of the logarithm of the displacement at the response point per modal amplitude, in the linearised mode (-).
    pub dln_mode_shape: f64,
    /// Modal amplitudes (sqrt(kg) m).
    pub modal_amplitude: Vec<Option<f64>>,
    /// Of the logarithm of the frequency, at the same modal amplitude (-).
    pub dln_frequency: Vec<Option<f64>>,
    /// Of the logarithm of the damping ratio of the contact, at the same modal amplitude (-).
    pub dln_damping: Vec<Option<f64>>,
    /// Of the logarithm of the frequency of the first harmonic, at the same modal amplitude (-).
    pub dln_frequency_first_harmonic: Vec<Option<f64>>,
    /// Of the logarithm of the damping ratio of the contact with that frequency, at the same modal amplitude (-).
    pub dln_damping_first_harmonic: Vec<Option<f64>>,
    /// Of the logarithm of the energy dissipated per cycle, at the same modal amplitude (-); not of free periodic motions.
    pub dln_dissipation: Vec<Option<f64>>,
    /// Of the logarithm of the displacement at the response point, at the same modal force (-); not of free periodic motions.
    pub dln_response: Vec<Option<f64>>,
}

/// A parameter with its scenes on both sides, and what it changes in the law between them.
#[derive(Debug)]
pub(super) struct Neighbours {
    parameter: Parameter,
    value: f64,
    unit: &'static str,
    per: Per,
    /// Distance to both sides: of the logarithm, or of the value.
    step: f64,
    above: Scene,
    below: Scene,
    /// Change of the law; none where the parameter changes loads alone.
    variation: Option<Variation>,
    /// Reduced structures above and below, where the parameter changes the structure.
    models: Option<Models>,
}

/// Reduced structures above and below a scene.
#[derive(Debug)]
enum Models {
    /// Of structures whose stiffness and mass are multiples of those of the scene: the factors.
    Multiples([[f64; 2]; 2]),
    Reduced(Box<[ReducedModel; 2]>),
}

impl Neighbours {
    /// Those of the parameters that a scene asks for, and the parameters that are left to differences of whole runs: the law, or the static
    /// state, is not differentiated with respect to them.
    ///
    /// # Errors
    /// [`scenes::Error::Parameter`] for one that no result depends on; values beside that of the scene which are not admissible; of the law there, of
    /// the structure and of its reduction.
    pub(super) fn of(
        scene: &Scene,
        structure: &Structure,
        model: &StructuralModel,
        interface: &SceneInterface,
        progress: &dyn Progress,
    ) -> Result<(Vec<Self>, Vec<Parameter>), Error> {
        let is_locked = scene.bolts.behaviour == BoltBehaviour::Locked;
        let (mut all, mut others) = (Vec::new(), Vec::new());
        let effects = match scene.analyses.sensitivities.as_slice() {
            [] => None,
            _ => Some(Effects::try_new(scene, structure, Some(interface))?),
        };
        let asked = scene.analyses.sensitivities.par_iter();
        let required = asked.map(|parameter| effects.iter().try_for_each(|effects| effects.require(parameter)));
        let required: Vec<Result<(), Error>> = required.collect();
        for (parameter, required) in scene.analyses.sensitivities.iter().zip(required) {
            required?;
            let is_structural = parameter.influence() == Influence::Structure;
            let is_left = scene.analyses.tightening.is_some() || (is_structural && is_locked);
            let beside = match is_left {
                true => None,
                false => Self::beside(scene, parameter)?.with_law(interface)?,
            };
            let Some(mut one) = beside else {
                others.push(parameter.clone());
                continue;
            };
            if is_structural {
                let of = |side| Structure::try_new(side, progress);
                let (above, below) = rayon::join(|| of(&one.above), || of(&one.below));
                let sides = [above?, below?];
                // The law's derivatives belong to the mesh of the interface.
                if sides.iter().any(|side| side.interface() != structure.interface()) {
                    others.push(parameter.clone());
                    continue;
                }
                let [above, below] = &sides;
                one.models = Some(match above.multiple_of(structure).zip(below.multiple_of(structure)) {
                    Some((above, below)) => Models::Multiples([above, below]),
                    None => {
                        let reduced = |side: &Structure| side.neighbour_of(&model.reduced, progress);
                        let (above, below) = rayon::join(|| reduced(above), || reduced(below));
                        Models::Reduced(Box::new([above?, below?]))
                    }
                });
            }
            all.push(one);
        }
        Ok((all, others))
    }

    /// Those of all of `parameters` that take no further reduction and that the law is differentiated with respect to.
    ///
    /// # Errors
    /// Of the law beside the values of the scene.
    pub(super) fn without_reduction<'p>(
        scene: &Scene,
        parameters: impl Iterator<Item = &'p Parameter>,
        interface: &SceneInterface,
    ) -> Result<Vec<Self>, Error> {
        let mut all = Vec::new();
        for parameter in parameters {
            let is_smooth = parameter.influence() != Influence::Structure && !parameter.is_drawn();
            if !is_smooth || scene.analyses.tightening.is_some() {
                continue;
            }
            // A number at the edge of what is admissible has no neighbours.
            let Ok(one) = Self::beside(scene, parameter) else {
                continue;
            };
            all.extend(one.with_law(interface)?);
        }
        Ok(all)
    }

    pub(super) fn parameter(&self) -> &Parameter {
        &self.parameter
    }

    /// The scenes beside a scene.
    fn beside(scene: &Scene, parameter: &Parameter) -> Result<Self, Error> {
        let value = parameter.value(scene)?;
        let is_structural = parameter.influence() == Influence::Structure;
        let relative = if is_structural { STRUCTURAL_STEP } else { STEP };
        let from_zero = if is_structural { STRUCTURAL_STEP } else { STEP_FROM_ZERO };
        let (per, step, [above, below]) = match value == 0.0 {
            true => (Per::Value, from_zero, [from_zero, -from_zero]),
            false => (
                Per::Logarithm,
                relative,
                [relative, -relative].map(|step: f64| value * step.exp()),
            ),
        };
        let mut bare = scene.clone();
        bare.analyses.sensitivities.clear();
        let varied = |number: f64| {
            parameter.with(&bare, number).map_err(|error| match value == 0.0 {
                true => scenes::Error::Parameter {
                    path: parameter.path().into(),
                    reason: format!(
                        "it is zero, from where results do not go on in both directions ({error}); give it a value"
                    ),
                },
                false => error,
            })
        };
        let [above, below] = [varied(above)?, varied(below)?];
        Ok(Self {
            unit: parameter.unit(scene)?,
            parameter: parameter.clone(),
            value,
            per,
            step,
            above,
            below,
            variation: None,
            models: None,
        })
    }

    /// It with the change of the law of the interface; none if the law is not differentiated with respect to the parameter.
    ///
    /// # Errors
    /// Of the law at the neighbouring values.
    fn with_law(self, interface: &SceneInterface) -> Result<Option<Self>, Error> {
        if self.parameter.influence() == Influence::Loads {
            return Ok(Some(self));
        }
        let variation = interface.variation([&self.above, &self.below], 2.0 * self.step)?;
        Ok(variation.map(|variation| Self {
            variation: Some(variation),
            ..self
        }))
    }

    /// Static load of one of the scenes (N).
    fn load(scene: &Scene, model: &ReducedModel) -> Vec<f64> {
        let tensions: Vec<f64> = (0..model.loads.len()).map(|bolt| scene.tension(bolt)).collect();
        load_of(model, &tensions)
    }

    /// What the parameter changes in the static and the vibrating structure.
    fn ingredients<'b>(&'b self, reduced: &'b ReducedModel) -> Ingredients<'b> {
        let apart = 2.0 * self.step;
        let matrix = |a: &'b SystemMatrix, b: &'b SystemMatrix| match (a, b) {
            (SystemMatrix::Dense(a), SystemMatrix::Dense(b)) => vec![(1.0 / apart, Cow::Owned((a - b).into()))],
            // Blocks beside one another are coupled through other combinations.
            (a, b) => vec![(1.0 / apart, Cow::Borrowed(a)), (-1.0 / apart, Cow::Borrowed(b))],
        };
        let multiple = |of: &'b SystemMatrix, above: f64, below: f64| match above - below {
            0.0 => Vec::new(),
            change => vec![(change / apart, Cow::Borrowed(of))],
        };
        let ([above, below], stiffness, mass) = match &self.models {
            None => ([reduced; 2], Vec::new(), Vec::new()),
            Some(Models::Multiples([above, below])) => (
                [reduced; 2],
                multiple(&reduced.stiffness, above[0], below[0]),
                multiple(&reduced.mass, above[1], below[1]),
            ),
            Some(Models::Reduced(sides)) => {
                let [above, below] = &**sides;
                let stiffness = matrix(&above.stiffness, &below.stiffness);
                ([above, below], stiffness, matrix(&above.mass, &below.mass))
            }
        };
        let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) / apart).collect();
        Ingredients {
            of: self,
            stiffness,
            mass,
            load: difference(&Self::load(&self.above, above), &Self::load(&self.below, below)),
            response: difference(&response(above), &response(below)),
        }
    }
}

/// A sum of factors times matrices.
type Terms<'a> = Vec<(f64, Cow<'a, SystemMatrix>)>;

/// Change of all that a solve is made of, per unit of the parameter or of its logarithm.
struct Ingredients<'a> {
    /// The parameter, with the change of the law.
    of: &'a Neighbours,
    stiffness: Terms<'a>,
    mass: Terms<'a>,
    load: Vec<f64>,
    response: Vec<f64>,
}

impl Ingredients<'_> {
    fn change<'a>(&'a self) -> Change<'a, InterfaceForce<'a>> {
        let looked_at = |terms: &'a Terms<'_>| terms.iter().map(|(factor, matrix)| (*factor, matrix.as_ref().as_ref()));
        Change {
            step: self.of.step,
            force: self.of.variation.as_ref(),
            stiffness: looked_at(&self.stiffness).collect(),
            mass: looked_at(&self.mass).collect(),
            load: Some(&self.load),
        }
    }

    /// What is known of a backbone's derivatives from those of its mode, whose shape is `shape` and eigenvalue `eigenvalue`; `response`
    /// recovers the displacement at the response point. What its amplitudes give is missing.
    fn of_mode(
        &self,
        (mode, method): (usize, &str),
        (shape, eigenvalue): (&[f64], f64),
        response: &[f64],
        rate: &ModeRate,
    ) -> Sensitivity {
        let of_shape = dot(&rate.shape, response) + dot(shape, &self.response);
        Sensitivity {
            mode: mode + 1,
            method: method.into(),
            parameter: self.of.parameter.clone(),
            value: self.of.value,
            unit: self.of.unit.into(),
            per: self.of.per,
            by: FoundBy::ImplicitDifferentiation,
            dln_linear_frequency: 0.5 * rate.eigenvalue / eigenvalue,
            dln_mode_shape: of_shape / dot(shape, response),
            modal_amplitude: Vec::new(),
            dln_frequency: Vec::new(),
            dln_damping: Vec::new(),
            dln_frequency_first_harmonic: Vec::new(),
            dln_damping_first_harmonic: Vec::new(),
            dln_dissipation: Vec::new(),
            dln_response: Vec::new(),
        }
    }
}

/// What the derivatives of all modes of a scene start from.
pub(super) struct Sensitivities<'a> {
    ingredients: Vec<Ingredients<'a>>,
    statics: Vec<StaticRate<State>>,
}

impl<'a> Sensitivities<'a> {
    /// Differentiates the static state under `assembled`.
    ///
    /// # Errors
    /// [`Error::Derivatives`] where the static state has a singular tangent.
    pub(super) fn try_new(
        neighbours: &'a [Neighbours],
        reduced: &'a ReducedModel,
        assembled: &InterfaceForce<'_>,
        prestress: &Prestress<State>,
    ) -> Result<Self, Error> {
        let ingredients: Vec<Ingredients<'_>> = neighbours.iter().map(|one| one.ingredients(reduced)).collect();
        let changes: Vec<_> = ingredients.iter().map(Ingredients::change).collect();
        let statics = static_rates(&reduced.stiffness, assembled, prestress, &changes);
        let statics = statics.ok_or(Error::Derivatives {
            of: "the static state, whose tangent is singular, or too far from that with everything in contact stuck",
        })?;
        Ok(Self { ingredients, statics })
    }

    /// What the loops of a mode, counted from 0, carry along.
    ///
    /// # Errors
    /// [`Error::Derivatives`] for a mode that is not alone at its frequency.
    pub(super) fn of_mode<'b>(
        &'b self,
        line: &Linearisation<'_, State>,
        force: &'b InterfaceForce<'b>,
        mode: usize,
    ) -> Result<Derivatives<'b, InterfaceForce<'b>>, Error> {
        let changes = self.ingredients.iter().map(Ingredients::change).collect();
        let found = Derivatives::try_new(line, force, mode, changes, &self.statics)?;
        found.ok_or(Error::Derivatives {
            of: "the mode, which is not alone at its frequency",
        })
    }

    /// The derivatives of a backbone; `response` recovers the displacement at the response point.
    pub(super) fn of_loops<'r>(
        &self,
        derivatives: &Derivatives<'_, InterfaceForce<'_>>,
        (shape, eigenvalue): (&[f64], f64),
        response: &[f64],
        loops: impl Iterator<Item = Option<&'r LoopResult>> + Clone,
    ) -> Vec<Sensitivity> {
        let of_parameter = |(number, (ingredients, rate)): (usize, (&Ingredients<'_>, &ParameterRate<'_, _>))| {
            let rates = loops.clone().map(|found| {
                let found = found?;
                Some((found, *found.rates.as_ref()?.get(number)?))
            });
            let rates: Vec<Option<(&LoopResult, _)>> = rates.collect();
            let each = |of: &dyn Fn(&LoopResult, LoopRate) -> Option<f64>| {
                let values = rates
                    .iter()
                    .map(|found| found.as_ref().and_then(|(found, rate)| of(found, *rate)));
                values.map(|value| value.filter(|value| value.is_finite())).collect()
            };
            let of_mode = ingredients.of_mode((derivatives.mode(), "cqsma"), (shape, eigenvalue), response, &rate.mode);
            Sensitivity {
                modal_amplitude: loops
                    .clone()
                    .map(|found| found.map(|found| found.modal_amplitude))
                    .collect(),
                dln_frequency: each(&|_, rate| Some(rate.ln_omega)),
                dln_damping: each(&|found, rate| rate.ln_zeta.filter(|_| found.is_resolved())),
                dln_frequency_first_harmonic: each(&|_, rate| Some(rate.ln_harmonic_omega)),
                dln_damping_first_harmonic: each(&|found, rate| rate.ln_harmonic_zeta.filter(|_| found.is_resolved())),
                dln_dissipation: each(&|found, rate| rate.ln_dissipation.filter(|_| found.is_resolved())),
                dln_response: each(&|_, rate| Some(rate.ln_amplitude + of_mode.dln_mode_shape)),
                ..of_mode
            }
        };
        let parameters = self.ingredients.iter().zip(derivatives.parameters());
        parameters.enumerate().map(of_parameter).collect()
    }

    /// The derivatives of a backbone of free motions. Dissipation and response are not differentiated.
    pub(super) fn of_motions<'f>(
        &self,
        derivatives: &Derivatives<'_, InterfaceForce<'f>>,
        line: &Linearisation<'_, State>,
        force: &InterfaceForce<'f>,
        (shape, response): (&[f64], &[f64]),
        points: &[Point],
    ) -> Vec<Sensitivity> {
        let rates: Vec<Option<(&Motion, Vec<MotionRate>)>> = points
            .iter()
            .map(|point| {
                let motion = point.result.as_ref().ok()?;
                Some((motion, backbone::rates(line, force, derivatives, motion)?))
            })
            .collect();
        let eigenvalue = line.eigenvalues[derivatives.mode()];
        let none = || vec![None; points.len()];
        let each = |of: &dyn Fn(&Motion, &[MotionRate]) -> Option<f64>| -> Vec<Option<f64>> {
            let values = rates
                .iter()
                .map(|found| found.as_ref().and_then(|(motion, rates)| of(motion, rates)));
            values.map(|value| value.filter(|value| value.is_finite())).collect()
        };
        let parameters = self.ingredients.iter().zip(derivatives.parameters());
        parameters
            .enumerate()
            .map(|(number, (ingredients, rate))| {
                let frequency = each(&|_, rates| Some(rates.get(number)?.ln_omega));
                let damping = each(&|motion, rates| {
                    let floor = motion.energy_error.abs().max(motion.residual);
                    let is_resolved = motion.zeta.is_some_and(|zeta| zeta.abs() > floor);
                    is_resolved.then_some(rates.get(number)?.ln_zeta)
                });
                Sensitivity {
                    modal_amplitude: each(&|motion, _| Some(motion.modal_amplitude)),
                    // A motion in time has one frequency.
                    dln_frequency_first_harmonic: frequency.clone(),
                    dln_damping_first_harmonic: damping.clone(),
                    dln_frequency: frequency,
                    dln_damping: damping,
                    dln_dissipation: none(),
                    dln_response: none(),
                    ..ingredients.of_mode((derivatives.mode(), EPMC), (shape, eigenvalue), response, &rate.mode)
                }
            })
            .collect()
    }
}
