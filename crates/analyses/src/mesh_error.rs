//! How far the mesh of a scene is from its limit, estimated from a second formulation of the elements.
//!
//! On the same mesh hexahedra of eight nodes with incompatible modes are too stiff and those with reduced integration are too soft, so
//! that the limit of a frequency lies between the two. Hexahedra of twenty nodes with full integration are too stiff; with reduced
//! integration they are less so, and the limit may lie below both. Where it lies is known of benchmarks whose meshes were refined,
//! see [`LimitWeight`]. Damping has no such order: both formulations may lie on one side.

use super::comparison::{Backbone, Point};
use super::error_bar::accuracy;
use super::mode_backbone::ModeBackbone;
use super::run::Run;
use crate::Error;
use finite_elements::elements::Formulation;
use finite_elements::mesh::Cell;
use joint_model::Bodies;
use joint_model::benchmark::LimitWeight;
use joints::progress::Silent;
use joints::structure::Structure;
use scenes::Scene;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Both runs have the same forces, at which their amplitudes differ a little: the outermost ones may lie beyond the other's range by
/// this factor.
const BESIDE: f64 = 1.05;

/// The limit of a scene's mesh, estimated by a run of the same mesh with another formulation of its hexahedra.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MeshEstimate {
    /// Formulation of the run.
    pub formulation: Formulation,
    /// Formulation of the run beside it.
    pub other: Formulation,
    /// Share of the elements that have both formulations; the others are the same in both runs.
    pub share_of_elements: f64,
    /// `w` in the estimate `f_S - w (f_S - f_R)` of the limit of a frequency from the stiffer and the softer formulation; `null` where
    /// it is not calibrated.
    pub weight: Option<f64>,
    /// Largest deviation from the weight where it was calibrated.
    pub weight_spread: Option<f64>,
    /// Where the weight comes from, or why there is none.
    pub source: String,
    /// One entry per mode followed.
    pub modes: Vec<ModeEstimate>,
}

/// The estimate of one mode. Modes of the two runs belong together by their number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ModeEstimate {
    /// Mode, counted from 1.
    pub mode: usize,
    /// Its linearised frequency.
    pub linear_frequency: FrequencyEstimate,
    /// Amplitudes of the run that the other run covers.
    pub amplitudes: Vec<AmplitudeEstimate>,
}

/// A frequency in both runs and, where the weight is calibrated, its limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FrequencyEstimate {
    /// Of the run (Hz).
    pub own_hz: f64,
    /// Of the run with the other formulation (Hz).
    pub other_hz: f64,
    /// Own over other, less one.
    pub relative_difference: f64,
    /// Estimate of the limit of the mesh (Hz).
    pub limit_hz: Option<f64>,
    /// Its uncertainty (Hz): the spread of the weight, and the uncertainty of the limit that it was calibrated against.
    pub uncertainty_hz: Option<f64>,
}

/// What both runs say at one amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AmplitudeEstimate {
    /// Displacement amplitude at the response point (m).
    pub response_displacement: f64,
    /// Frequency.
    pub frequency: FrequencyEstimate,
    /// Damping ratio of the run; `null` where either run has none above its floor, as are the next two.
    pub damping_ratio: Option<f64>,
    /// Damping ratio of the run with the other formulation.
    pub other_damping_ratio: Option<f64>,
    /// Logarithm of own over other. It says how much the formulation matters, and brackets nothing.
    pub damping_ln_difference: Option<f64>,
}

/// The scene with the other formulation of its hexahedra, and what makes the two runs comparable.
#[derive(Clone, Debug)]
pub struct Partner {
    /// The same scene but for the formulation.
    pub scene: Scene,
    own: Formulation,
    other: Formulation,
    share: f64,
    limit: Result<(LimitWeight, &'static str), &'static str>,
}

impl Partner {
    /// The partner of a scene: reduced integration, or for a scene that has reduced integration incompatible modes, with quadratic
    /// elements full integration.
    ///
    /// # Errors
    /// [`Error::OneFormulation`] where the structure has no hexahedra that could have another formulation, or several
    /// formulations at once; those of the mesher and of the deck.
    pub fn try_new(scene: &Scene) -> Result<Self, Error> {
        let refuse = |what| Error::OneFormulation {
            place: scene.name.clone(),
            what,
        };
        if scene.structure.matrices().is_some() {
            return Err(refuse(
                "the structure consists of matrices, whose elements are not known",
            ));
        }
        let structure = Structure::try_new(scene, &Silent)?;
        let Bodies::Meshed(bodies) = &structure.joint.bodies else {
            return Err(refuse("the structure has no mesh"));
        };
        let elements = &bodies.assembly.mesh.elements;
        let stiffer = |cell: &Cell| {
            let row = cell.element_type();
            [Formulation::IncompatibleModes, Formulation::Full]
                .into_iter()
                .find(|formulation| row.offers(*formulation) && row.offers(Formulation::Reduced))
        };
        let mut formulations = elements
            .iter()
            .filter_map(|e| Some((e.cell.formulation(), stiffer(&e.cell)?)));
        let (own, stiffer) = formulations.next().ok_or_else(|| {
            refuse("none of its elements has two formulations; only hexahedra of eight or twenty nodes have")
        })?;
        let mut count = 1_usize;
        for next in formulations {
            count += 1;
            if next != (own, stiffer) {
                return Err(refuse(
                    "its hexahedra have several formulations or numbers of nodes; model.formulation gives all of them one \
                     formulation",
                ));
            }
        }
        let other = match own {
            Formulation::Reduced => stiffer,
            _ => Formulation::Reduced,
        };
        let mut partner = scene.clone();
        partner.model.formulation = Some(other);
        let pair = [own, other];
        let limit = match accuracy(scene) {
            Err(reason) => Err(reason),
            Ok(_) if !pair.contains(&stiffer) => Err(
                "the weight was measured between reduced integration and incompatible modes, with quadratic elements full integration",
            ),
            Ok(accuracy) => {
                let mut rows = accuracy.limits.iter();
                let own = (scene.element_order(), scene.model.refinement);
                let row = rows.find(|row| (row.element_order, row.refinement) == own);
                row.map(|row| (*row, accuracy.source))
                    .ok_or("the weight was not measured on this refinement")
            }
        };
        Ok(Self {
            scene: partner,
            own,
            other,
            share: count as f64 / elements.len() as f64,
            limit,
        })
    }
}

impl MeshEstimate {
    /// The two formulations for readers, that of the run first.
    pub fn formulations(&self) -> [&'static str; 2] {
        [self.formulation, self.other].map(|formulation| match formulation {
            Formulation::IncompatibleModes => "incompatible modes",
            Formulation::BBar => "B-bar",
            Formulation::Full => "full integration",
            Formulation::Reduced => "reduced integration",
        })
    }

    /// How the limit follows from the two frequencies, or why there is none, for readers.
    pub fn rule(&self) -> String {
        match (self.weight, self.weight_spread) {
            (Some(weight), Some(spread)) => format!(
                "f_S - w (f_S - f_R) with w = {weight} +- {spread}, f_R of reduced integration and f_S of the other formulation; {}",
                self.source
            ),
            _ => self.source.clone(),
        }
    }

    /// Compares the run of a scene with that of its partner.
    pub fn new(run: &Run, partner: &Partner, other: &Run) -> Self {
        let weight = partner.limit.as_ref().ok().map(|(weight, _)| *weight);
        let estimate = |own_hz: f64, other_hz: f64| {
            let [stiff, soft] = match partner.own {
                Formulation::Reduced => [other_hz, own_hz],
                _ => [own_hz, other_hz],
            };
            let limit_hz = weight.map(|w| stiff - w.weight * (stiff - soft));
            let uncertainty = |w: LimitWeight| w.spread * (stiff - soft).abs() + w.limit_uncertainty * stiff;
            FrequencyEstimate {
                own_hz,
                other_hz,
                relative_difference: own_hz / other_hz - 1.0,
                limit_hz,
                uncertainty_hz: weight.map(uncertainty),
            }
        };
        let modes = run.backbones.iter().zip(&other.backbones).filter_map(|(own, partner)| {
            let at = own.mode - 1;
            let linear_frequency = estimate(*run.frequencies.get(at)?, *other.frequencies.get(at)?);
            let backbone = Backbone::try_new("other formulation", points(partner)).ok();
            let amplitudes = points(own).into_iter().filter_map(|point| {
                let (frequency_hz, damping) = backbone.as_ref()?.at_or_beyond(point.amplitude, BESIDE)?;
                let both = point.damping_ratio.zip(damping);
                Some(AmplitudeEstimate {
                    response_displacement: point.amplitude,
                    frequency: estimate(point.frequency_hz, frequency_hz),
                    damping_ratio: both.map(|(own, _)| own),
                    other_damping_ratio: both.map(|(_, other)| other),
                    damping_ln_difference: both.map(|(own, other)| (own / other).ln()),
                })
            });
            Some(ModeEstimate {
                mode: own.mode,
                linear_frequency,
                amplitudes: amplitudes.collect(),
            })
        });
        Self {
            formulation: partner.own,
            other: partner.other,
            share_of_elements: partner.share,
            weight: weight.map(|w| w.weight),
            weight_spread: weight.map(|w| w.spread),
            source: match partner.limit {
                Ok((_, source)) => source.to_owned(),
                Err(reason) => format!("not calibrated: {reason}"),
            },
            modes: modes.collect(),
        }
    }
}

/// Backbone over the displacement by the mode.
fn points(mode: &ModeBackbone) -> Vec<Point> {
    let converged = mode.amplitudes.iter().filter_map(|amplitude| {
        let result = amplitude.point.result.as_ref().ok()?;
        Some(Point {
            amplitude: amplitude.response_displacement?,
            frequency_hz: result.omega / TAU,
            damping_ratio: result.is_resolved().then_some(result.zeta + mode.background),
        })
    });
    converged.collect()
}
