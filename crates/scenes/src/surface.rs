//! What the traction law of a scene follows from, and the gap between the faces.

use super::finish::Finish;
use super::scans::{Registration, Scans};
use super::units::{ArealDensity, ContactStiffness, Length, Stress};
use crate::BenchmarkRef;
use contact_laws::TangentialReading;
use serde::{Deserialize, Serialize};

/// What the traction law follows from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Surface {
    /// The measured statistics of the benchmark that the structure is, the same everywhere.
    Measured,
    /// Those of the benchmark of this name, whatever the structure is.
    Benchmark(BenchmarkRef),
    /// Two seeded synthetic scans, characterised element by element.
    SyntheticScan(SyntheticScan),
    /// Two scans from files, characterised element by element.
    Scans(Box<Scans>),
    /// Two faces by their roughness parameters, as a drawing or a roughness report gives them.
    Finish(Box<Finish>),
    /// No asperities: the parameters of the law themselves.
    Parameters(Parameters),
}

impl Surface {
    /// Whether there are samples of heights.
    pub fn is_scanned(&self) -> bool {
        matches!(self, Self::SyntheticScan(_) | Self::Scans(_))
    }

    /// Whether its law follows from the material of the asperities.
    pub fn needs_material(&self) -> bool {
        match self {
            Self::Parameters(parameters) => {
                let is_rough = |set: &ParameterSet| matches!(set.curves, Curves::GreenwoodWilliamson(_));
                parameters.sets.iter().any(is_rough)
            }
            _ => true,
        }
    }

    /// Whether faces are pressed together before bolts load them.
    pub fn is_preloaded(&self) -> bool {
        match self {
            Self::Parameters(parameters) => parameters.sets.iter().any(|set| !is_zero(&set.preload)),
            _ => false,
        }
    }

    /// Motion of the bottom face against the top one, of surfaces that are scanned.
    pub fn registration(&mut self) -> Option<&mut Registration> {
        match self {
            Self::SyntheticScan(scan) => Some(&mut scan.registration),
            Self::Scans(scans) => Some(&mut scans.registration),
            Self::Measured | Self::Benchmark(_) | Self::Finish(_) | Self::Parameters(_) => None,
        }
    }
}

/// Parameters of the traction law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// What each set belongs to.
    pub per: Per,
    /// One set for the interface, for each element, or for each integration point (element by element).
    pub sets: Vec<ParameterSet>,
}

/// What a set of parameters belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Per {
    /// The whole interface.
    Interface,
    /// An element.
    Element,
    /// An integration point.
    Point,
}

/// One set of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ParameterSet {
    /// Traction and stiffness against interference; of the same kind in all sets.
    pub curves: Curves,
    /// Friction coefficient (-); by default that of the scene. Not together with `interfaces.friction_zones`.
    #[serde(default)]
    pub mu: Option<f64>,
    /// Gap before the faces are loaded (length).
    #[serde(default)]
    pub gap: Length,
    /// Pressure before the faces are loaded (force/length^2), as if they were pressed into one another by the interference that
    /// has it. Not together with a gap.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub preload: Stress,
}

fn is_zero(preload: &Stress) -> bool {
    preload.si() == 0.0
}

/// Traction and stiffness against interference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Curves {
    /// Constant stiffnesses.
    Elastic(Elastic),
    /// Eqs. (28) and (29).
    Fitted(Fitted),
    /// Rough contact after Greenwood and Williamson.
    GreenwoodWilliamson(GreenwoodWilliamson),
}

/// Constant stiffnesses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Elastic {
    /// Per area (force/length^3).
    pub normal_stiffness: ContactStiffness,
    /// Per area along x and y (force/length^3).
    pub tangential_stiffness: [ContactStiffness; 2],
}

/// Coefficients of eqs. (28) and (29).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Fitted {
    /// `a, b, c, d, e` of eq. (28) (-).
    pub normal: [f64; 5],
    /// `a, b, c, d` of eq. (29) along x and y (-).
    pub tangential: [[f64; 4]; 2],
    /// Interference that the logarithms refer to (length).
    pub u_ref: Length,
    /// Traction that they refer to (force/length^2); by default one unit.
    #[serde(default = "one_unit_of_stress")]
    pub t_ref: Stress,
    /// Stiffness that they refer to (force/length^3); by default one unit.
    #[serde(default = "one_unit_of_stiffness")]
    pub k_ref: ContactStiffness,
    /// Interferences between which the fits hold (length); everywhere by default.
    #[serde(default)]
    pub range: Option<[Length; 2]>,
}

/// Asperities of equal radius whose heights follow a distribution ([`contact_laws::GreenwoodWilliamsonCurves`]). Young's modulus and
/// Poisson's ratio are those of `model.material`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GreenwoodWilliamson {
    /// Distribution of the heights.
    pub heights: Heights,
    /// Height over the zero of the heights that the opposite plane begins to touch (length).
    pub reference_height: Length,
    /// Asperities per area (1/length^2).
    pub asperity_density: ArealDensity,
    /// Effective radii along x and y (length).
    pub radii: [Length; 2],
    /// Tangential stiffness of an asperity.
    #[serde(default = "mindlin")]
    pub tangential: TangentialReading,
}

fn mindlin() -> TangentialReading {
    TangentialReading::Mindlin
}

/// Distribution of the heights of asperities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Heights {
    /// Exponential from zero with this scale (length).
    Exponential(Length),
    /// Gaussian about zero with this standard deviation (length).
    Gaussian(Length),
}

/// Two synthetic faces on the grid of a profilometer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct SyntheticScan {
    /// Seed of the top face; the bottom one uses the next number.
    pub seed: u64,
    /// Grid steps along x and y (length).
    pub step: [Length; 2],
    /// Height step of the instrument (length).
    pub height_step: Length,
    /// Rms roughness of each face (length).
    pub rms: Length,
    /// Correlation lengths along x and y (length).
    pub correlation_length: [Length; 2],
    /// Amplitude of the waviness of each face (length).
    pub waviness: Length,
    /// Wavelength of the waviness along the beam (length).
    pub wavelength: Length,
    /// Tilt of the raw scans, taken out again by de-trending (-).
    pub tilt: [f64; 2],
    /// Bootstrap draws for the bands of the curves.
    pub bootstrap: usize,
    /// Motion of the bottom face against the top one (length, and slopes without unit).
    pub registration: Registration,
}

impl Default for SyntheticScan {
    fn default() -> Self {
        Self {
            seed: 1,
            step: [30e-6, 50e-6].map(Length::from_si),
            height_step: Length::from_si(0.5e-6),
            rms: Length::from_si(2.5e-6),
            correlation_length: [150e-6, 200e-6].map(Length::from_si),
            waviness: Length::from_si(1e-6),
            wavelength: Length::from_si(0.2),
            tilt: [1e-4, -2e-4],
            bootstrap: 30,
            registration: Registration::default(),
        }
    }
}

/// Gap between the faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Gap {
    /// No gap.
    #[default]
    Flat,
    /// The measured gap of the benchmark that the structure is.
    Measured,
    /// That of the benchmark of this name, whatever the structure is.
    Benchmark(BenchmarkRef),
    /// The gap of the scans.
    Scan,
}

/// One in the units of the file.
fn one_unit_of_stress() -> Stress {
    Stress::in_units(1.0)
}

/// One in the units of the file.
fn one_unit_of_stiffness() -> ContactStiffness {
    ContactStiffness::in_units(1.0)
}
