//! Numbers of a scene that are not known exactly: their distributions, how they depend on one another, and how they are sampled.

use crate::distribution::{Marginal, Shape};
use crate::error::Error;
use crate::parameter::Parameter;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Standard deviations from the mean that the smallest and the largest preload of a tightening method are taken to lie at.
pub const TIGHTENING_SIGMAS: f64 = 2.0;

/// Factor of [`Uncertain::law_error`] by default. Logarithms of the stiffness by asperity sums over that by boundary elements have a root mean
/// square of 0.31 at 5 MPa, 0.42 at 20 MPa and 0.71 at 50 MPa: factors of 1.36, 1.52 and 2.04.
pub const LAW_ERROR: f64 = 1.5;

/// Numbers of a scene that are not known exactly, see [`Scene::uncertain`](super::Scene::uncertain).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Uncertain {
    /// Their distributions, by their paths.
    pub parameters: BTreeMap<Parameter, Distribution>,
    /// Correlation coefficients of pairs of them: two paths and a number between -1 and 1. It is that of the Gaussian copula, and of the
    /// parameters themselves where both are normal. Other pairs are independent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub correlations: Vec<(Parameter, Parameter, f64)>,
    /// How samples are placed.
    #[serde(default)]
    pub method: SamplingMethod,
    /// Seed of the samples.
    #[serde(default = "one")]
    pub seed: u64,
    /// Probability between the lower and the upper edge of a band.
    #[serde(default = "ninety_percent")]
    pub confidence: f64,
    /// Whether Sobol's indices are computed: with N samples and k parameters N (k + 1) further runs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub sobol_indices: bool,
    /// Error of the sum over asperities against boundary elements: the heights of asperities are lognormal with this factor (-), and the
    /// stiffness at a pressure is nearly in proportion to one over them. By default 1.5 where the law is such a sum and `parameters` does not have
    /// `interfaces.scale.asperity_height`; 1 leaves it out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law_error: Option<f64>,
}

fn one() -> u64 {
    1
}

fn ninety_percent() -> f64 {
    0.9
}

/// How samples are placed in the unit cube, before distributions and correlations shape them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SamplingMethod {
    /// One sample in each of N equally probable intervals of every parameter (McKay, Beckman, Conover 1979, doi:10.2307/1268522).
    #[default]
    LatinHypercube,
    /// Sobol's sequence, scrambled (Owen 1998, doi:10.1006/jcom.1998.0487; Burley 2020, JCGT 9(4)).
    Sobol,
}

impl SamplingMethod {
    /// Name as used in scenes and outputs.
    pub fn name(self) -> &'static str {
        match self {
            Self::LatinHypercube => "latin-hypercube",
            Self::Sobol => "sobol",
        }
    }
}

/// A value of a parameter: a number in the units of the scene, or a text with a unit such as `"12.8 kN"`. Once the scene is read it is a
/// number in SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "a number, or a text with a unit such as \"12.8 kN\"")]
pub enum NumberOrText {
    /// In SI, or in the units of a scene that is being read.
    Number(f64),
    /// With its unit, in a scene that is being read.
    Text(String),
}

/// The distribution of a parameter: one of `normal`, `lognormal`, `uniform`, `triangular` and `tightening`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Distribution {
    /// Normal distribution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<Normal>,
    /// Lognormal distribution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lognormal: Option<Lognormal>,
    /// Smallest and largest value, and all between alike.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uniform: Option<[NumberOrText; 2]>,
    /// Smallest, most likely and largest value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub triangular: Option<[NumberOrText; 3]>,
    /// How a bolt is tightened; its load is normal about that of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tightening: Option<TighteningMethod>,
    /// Tightening factor, the largest preload over the smallest one, where it is known better than by the method (-).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alpha_a: Option<f64>,
    /// Bounds at which the distribution is truncated: values beyond do not occur, those between keep their ratios.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between: Option<[NumberOrText; 2]>,
}

/// A normal distribution.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Normal {
    /// Mean; by default the value of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean: Option<NumberOrText>,
    /// Standard deviation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sd: Option<NumberOrText>,
    /// In its place, the coefficient of variation: standard deviation over mean (-).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cov: Option<f64>,
}

/// A lognormal distribution.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Lognormal {
    /// Median; by default the value of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub median: Option<NumberOrText>,
    /// Geometric standard deviation: the median times it is exceeded with a probability of 15.9 % (-).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
    /// In its place, the coefficient of variation: standard deviation over mean (-).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cov: Option<f64>,
}

/// Methods of tightening with guide values of the tightening factor `alpha_A = F_Mmax / F_Mmin` of VDI 2230 part 1, table A8.
///
/// The largest factor of the method's range is taken. The load is taken as normal about that of the scene, with `F_Mmin` and `F_Mmax`
/// at [`TIGHTENING_SIGMAS`] standard deviations from the mean, so that its coefficient of variation is
/// `(alpha_A - 1) / (alpha_A + 1) / 2`. The table itself states no distribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum TighteningMethod {
    /// Elongation measured by ultrasound: 1.1 to 1.2.
    Ultrasound,
    /// Elongation measured mechanically: 1.1 to 1.5.
    Elongation,
    /// Controlled by yield, by motor or by hand: 1.2 to 1.4.
    Yield,
    /// Controlled by the angle of rotation, by motor or by hand: 1.2 to 1.4.
    Angle,
    /// Hydraulic: 1.2 to 1.6.
    Hydraulic,
    /// Torque wrench, with the torque found by tests on the joint: 1.4 to 1.6.
    TestedTorqueWrench,
    /// Torque wrench, with the torque from an estimated friction coefficient of class B (0.08 to 0.16): 1.6 to 2.0.
    TorqueWrench,
    /// The same with friction of class A (0.04 to 0.10): 1.7 to 2.5.
    TorqueWrenchLowFriction,
    /// Torque-controlled screwdriver: 1.7 to 2.5.
    Screwdriver,
    /// Impact or pulse wrench: 2.5 to 4.
    ImpactWrench,
}

impl TighteningMethod {
    /// Smallest and largest tightening factor (-).
    pub fn alpha_a(self) -> [f64; 2] {
        match self {
            Self::Ultrasound => [1.1, 1.2],
            Self::Elongation => [1.1, 1.5],
            Self::Yield | Self::Angle => [1.2, 1.4],
            Self::Hydraulic => [1.2, 1.6],
            Self::TestedTorqueWrench => [1.4, 1.6],
            Self::TorqueWrench => [1.6, 2.0],
            Self::TorqueWrenchLowFriction | Self::Screwdriver => [1.7, 2.5],
            Self::ImpactWrench => [2.5, 4.0],
        }
    }
}

impl NumberOrText {
    /// In SI, once the scene is read.
    fn si(&self) -> Result<f64, String> {
        match self {
            Self::Number(value) if value.is_finite() => Ok(*value),
            Self::Number(value) => Err(format!("{value} is not finite")),
            Self::Text(text) => Err(format!(
                "`{text}` has a unit, which is understood in scenes that are read alone"
            )),
        }
    }
}

impl Distribution {
    /// All values in the unit of the parameter, with their places.
    pub(super) fn quantities(&mut self) -> impl Iterator<Item = (&'static str, &mut NumberOrText)> {
        let normal = self.normal.iter_mut().flat_map(|normal| {
            let mean = normal.mean.iter_mut().map(|given| ("normal.mean", given));
            mean.chain(normal.sd.iter_mut().map(|given| ("normal.sd", given)))
        });
        let lognormal = self.lognormal.iter_mut().flat_map(|lognormal| &mut lognormal.median);
        let uniform = self.uniform.iter_mut().flatten().map(|given| ("uniform", given));
        let triangular = self.triangular.iter_mut().flatten().map(|given| ("triangular", given));
        let between = self.between.iter_mut().flatten().map(|given| ("between", given));
        normal
            .chain(lognormal.map(|given| ("lognormal.median", given)))
            .chain(uniform)
            .chain(triangular)
            .chain(between)
    }

    /// The distribution in numbers (SI), of a parameter whose value in the scene is `nominal`.
    ///
    /// # Errors
    /// What is wrong with it, and the remedy.
    pub(super) fn marginal(&self, parameter: &Parameter, nominal: f64) -> Result<Marginal, String> {
        let given = [
            self.normal.is_some(),
            self.lognormal.is_some(),
            self.uniform.is_some(),
            self.triangular.is_some(),
            self.tightening.is_some(),
        ];
        let count = given.iter().filter(|given| **given).count();
        if count != 1 {
            return Err(format!(
                "there are {count} distributions; give one of normal, lognormal, uniform, triangular and tightening"
            ));
        }
        if self.alpha_a.is_some() && self.tightening.is_none() {
            return Err("alpha_a belongs to tightening; leave it out".into());
        }
        let or_nominal = |given: &Option<NumberOrText>| given.as_ref().map_or(Ok(nominal), NumberOrText::si);
        let shape = if let Some(Normal { mean, sd, cov }) = &self.normal {
            let mean = or_nominal(mean)?;
            let sd = match (sd, cov) {
                (Some(sd), None) => sd.si()?,
                (None, Some(cov)) => cov * mean.abs(),
                _ => return Err("a normal distribution needs either sd or cov".into()),
            };
            Shape::Normal { mean, sd }
        } else if let Some(Lognormal { median, factor, cov }) = &self.lognormal {
            let median = or_nominal(median)?;
            let sd_of_log = match (factor, cov) {
                (Some(factor), None) if *factor > 1.0 => factor.ln(),
                (Some(factor), None) => return Err(format!("lognormal.factor = {factor} must be above 1")),
                (None, Some(cov)) => (1.0 + cov * cov).ln().sqrt() * cov.signum(),
                _ => return Err("a lognormal distribution needs either factor or cov".into()),
            };
            Shape::Lognormal { median, sd_of_log }
        } else if let Some([low, high]) = &self.uniform {
            Shape::Uniform {
                low: low.si()?,
                high: high.si()?,
            }
        } else if let Some([low, mode, high]) = &self.triangular {
            Shape::Triangular {
                low: low.si()?,
                mode: mode.si()?,
                high: high.si()?,
            }
        } else {
            if !parameter.path().starts_with("bolts.load") {
                return Err(
                    "tightening is how the load of a bolt comes about; give this parameter another distribution".into(),
                );
            }
            let largest = self.tightening.map_or(1.0, |method| method.alpha_a()[1]);
            let alpha = self.alpha_a.unwrap_or(largest);
            if !(alpha > 1.0 && alpha.is_finite()) {
                return Err(format!(
                    "alpha_a = {alpha} must be above 1: it is the largest preload over the smallest"
                ));
            }
            let sd = nominal * (alpha - 1.0) / (alpha + 1.0) / TIGHTENING_SIGMAS;
            Shape::Normal { mean: nominal, sd }
        };
        let between = match &self.between {
            None => None,
            Some([low, high]) => Some([low.si()?, high.si()?]),
        };
        Marginal::try_new(shape, between)
    }
}

impl Uncertain {
    /// Correlation matrix of the Gaussian copula, row by row, in the order of the parameters.
    ///
    /// # Errors
    /// [`Error::Uncertain`] for pairs that are none.
    pub fn correlation(&self) -> Result<Vec<Vec<f64>>, Error> {
        let names: Vec<&Parameter> = self.parameters.keys().collect();
        let n = names.len();
        let mut matrix: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
            .collect();
        for (number, (a, b, value)) in self.correlations.iter().enumerate() {
            let refused = |reason: String| Error::Uncertain {
                field: format!("correlations.{number}"),
                reason,
            };
            let place = |name: &Parameter| {
                let found = names.iter().position(|known| *known == name);
                found.ok_or_else(|| refused(format!("{name} has no distribution; add it to uncertain.parameters")))
            };
            let (i, j) = (place(a)?, place(b)?);
            if i == j {
                return Err(refused(format!("{a} is correlated with itself; name two parameters")));
            }
            if !(value.abs() < 1.0) {
                return Err(refused(format!(
                    "a correlation of {value} is none; it must be between -1 and 1"
                )));
            }
            if matrix[i][j] != 0.0 {
                return Err(refused(format!("{a} and {b} are there twice; leave one out")));
            }
            (matrix[i][j], matrix[j][i]) = (*value, *value);
        }
        Ok(matrix)
    }
}

/// Why a value of a distribution is none of the parameter.
pub fn beyond(value: f64, error: &Error) -> String {
    format!(
        "the distribution reaches {value:.6}, which the scene refuses ({error}); truncate it with \"between\": [LOW, HIGH]"
    )
}

/// A distribution that is refused.
pub fn of_parameter(parameter: &Parameter, reason: String) -> Error {
    Error::Uncertain {
        field: format!("parameters.{parameter}"),
        reason,
    }
}
