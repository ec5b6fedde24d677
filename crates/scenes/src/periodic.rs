//! Periodic motions of a scene: EPMC backbones and forced responses.

use super::units::{Force, ModalAmplitude};
use serde::{Deserialize, Serialize};

/// Free periodic motions by the extended periodic motion concept (method `epmc`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Epmc {
    /// Modal amplitudes of the first harmonic (sqrt(mass) length), ascending; by default those that the amplitudes of `backbone`
    /// belong to by linear estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modal_amplitudes: Option<Amplitudes>,
    /// Highest harmonic, 1 to 100; with `accuracy` the one that the first amplitude begins with.
    pub harmonics: usize,
    /// Samples per period, 8 to 65536 and more than twice the harmonics; the same.
    pub samples: usize,
    /// Periods that the history is followed for, the last of which is measured.
    pub periods: usize,
    /// Residual relative to the elastic forces of the first harmonic, in the energy norm.
    pub tolerance: f64,
    /// Errors that are borne: harmonics and samples are raised at each amplitude until what two harmonics more and twice the samples
    /// change shows smaller ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<SamplingAccuracy>,
    /// Quadrature points, counted from 1, whose hysteresis loops are stored; by default the one that takes most energy per area at the
    /// largest amplitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loops_at: Option<Vec<usize>>,
}

impl Default for Epmc {
    fn default() -> Self {
        Self {
            modal_amplitudes: None,
            harmonics: 3,
            samples: 128,
            periods: 2,
            tolerance: 1e-8,
            accuracy: None,
            loops_at: None,
        }
    }
}

/// Amplitudes one by one, in ascending order, or `{ "from": .., "to": .., "number": .. }`, spaced in log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    untagged,
    expecting = "a list of modal amplitudes, or {\"from\": .., \"to\": .., \"number\": ..}"
)]
pub enum Amplitudes {
    /// Each of them.
    List(Vec<ModalAmplitude>),
    /// Spaced in log.
    Range(AmplitudeRange),
}

/// Amplitudes that are spaced in log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AmplitudeRange {
    /// Smallest (sqrt(mass) length).
    pub from: ModalAmplitude,
    /// Largest (sqrt(mass) length).
    pub to: ModalAmplitude,
    /// How many.
    pub number: usize,
}

impl Amplitudes {
    /// All of them (sqrt(kg) m).
    pub fn values(&self) -> Vec<f64> {
        match self {
            Self::List(values) => values.iter().map(|q| q.si()).collect(),
            Self::Range(AmplitudeRange { from, to, number }) => {
                let ratio = (to.si() / from.si()).ln();
                let last = number.saturating_sub(1).max(1) as f64;
                (0..*number)
                    .map(|i| match i {
                        // To the last bit.
                        0 => from.si(),
                        i if i + 1 == *number => to.si(),
                        i => from.si() * (ratio * i as f64 / last).exp(),
                    })
                    .collect()
            }
        }
    }
}

/// Errors of sampling that are borne.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SamplingAccuracy {
    /// Relative error of the frequency.
    pub frequency: f64,
    /// Relative error of the damping ratio, where that is above 1e-5.
    pub damping: f64,
}

/// Damping in proportion to mass and stiffness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Rayleigh {
    /// Factor of the mass (1/s).
    pub mass: f64,
    /// Factor of the stiffness of the structure without contact (s).
    pub stiffness: f64,
}

/// Responses to a harmonic force: at the response point in its direction, unless `node` and `direction` or `terms` say otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Forced {
    /// Node that the force acts on: in a deck a label or a set of one node, in matrices a label. Not for benchmarks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// Direction of the force at the node, a unit vector.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// In matrices: factors of the coordinates that the force acts on, in the place of a node: label, component, factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terms: Option<Vec<(i64, u32, f64)>>,
    /// Proportional damping beside `background_damping`: factors of the mass (1/s) and of the stiffness without contact (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rayleigh: Option<Rayleigh>,
    /// Amplitudes of the force (force).
    pub levels: Vec<Force>,
    /// First frequency (Hz).
    pub from_hz: f64,
    /// Last frequency (Hz); above or below the first.
    pub to_hz: f64,
    /// Highest harmonic, 1 to 100.
    #[serde(default = "three")]
    pub harmonics: usize,
    /// Samples per period, 8 to 65536 and more than twice the harmonics.
    #[serde(default = "samples")]
    pub samples: usize,
    /// Residual relative to the elastic forces of the first harmonic, in the energy norm.
    #[serde(default = "tolerance")]
    pub tolerance: f64,
    /// Largest relative change of the motion from one point of a curve to the next.
    #[serde(default = "amplitude_step")]
    pub amplitude_step: f64,
    /// Largest relative change of the frequency from one point of a curve to the next.
    #[serde(default = "frequency_step")]
    pub frequency_step: f64,
}

impl Forced {
    /// These levels between these frequencies (Hz), with defaults for all else.
    pub fn new(levels: Vec<Force>, from_hz: f64, to_hz: f64) -> Self {
        Self {
            node: None,
            direction: None,
            terms: None,
            rayleigh: None,
            levels,
            from_hz,
            to_hz,
            harmonics: three(),
            samples: samples(),
            tolerance: tolerance(),
            amplitude_step: amplitude_step(),
            frequency_step: frequency_step(),
        }
    }
}

fn three() -> usize {
    3
}

fn samples() -> usize {
    128
}

fn tolerance() -> f64 {
    1e-8
}

fn amplitude_step() -> f64 {
    0.2
}

fn frequency_step() -> f64 {
    0.02
}
