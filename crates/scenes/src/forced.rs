//! Responses to harmonic forces, and to harmonic motion of the supports.

use super::check::Check;
use super::epmc::sampling;
use super::excitation::{
    BaseMotion, Excitation, ExcitationFields, PointFields, PointForce, check_excitation, excitation,
};
use super::units::{Acceleration, Force, Length};
use crate::Error;
use serde::{Deserialize, Serialize};

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

/// Names of the fields of its excitation.
pub(super) const FIELDS: ExcitationFields = ExcitationFields {
    base: ["analyses.forced.base.direction", "analyses.forced.base.motion"],
    point: PointFields {
        node: "analyses.forced.node",
        direction: "analyses.forced.direction",
        terms: "analyses.forced.terms",
    },
};

/// Harmonic motion of all supports together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ForcedBase {
    /// Direction of the motion, a unit vector; either this or `motion` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// In matrices whose coordinates do not show it, how these move when everything moves by one: label, component, factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Vec<(i64, u32, f64)>>,
    /// Amplitudes of its acceleration (acceleration; texts: `m/s^2`, `g`).
    pub levels: Vec<Acceleration>,
}

/// Responses to a harmonic force, or to harmonic motion of the supports. A force acts at the response point in its direction, unless `node` and `direction` or `terms` say otherwise.
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
    /// All supports move alike, in the place of a force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<ForcedBase>,
    /// Amplitudes of the force (force).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<Force>,
    /// In their place, amplitudes of the first harmonic of the response that are held (length): a controlled test, of which the force is found.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub response_levels: Vec<Length>,
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
            base: None,
            levels,
            response_levels: Vec::new(),
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

impl Forced {
    /// The base, and where a force acts.
    fn parts(&self) -> (Option<BaseMotion>, PointForce) {
        let base = self.base.as_ref().map(|base| BaseMotion {
            direction: base.direction,
            motion: base.motion.clone(),
        });
        let force = PointForce {
            node: self.node.clone(),
            direction: self.direction,
            terms: self.terms.clone(),
        };
        (base, force)
    }

    /// What drives the structure.
    pub fn excitation(&self) -> Excitation {
        let (base, force) = self.parts();
        excitation(base.as_ref(), Some(&force))
    }

    /// Whether the amplitude of the response is held, and not that of the force.
    pub fn holds_response(&self) -> bool {
        !self.response_levels.is_empty()
    }

    /// Amplitudes of the force (N), of the acceleration of the supports (m/s^2), or of the response (m).
    pub fn levels(&self) -> Vec<f64> {
        match &self.base {
            Some(base) => base.levels.iter().map(|level| level.si()).collect(),
            None if self.holds_response() => self.response_levels.iter().map(|level| level.si()).collect(),
            None => self.levels.iter().map(|level| level.si()).collect(),
        }
    }

    /// Unit of the levels.
    pub fn unit(&self) -> &'static str {
        match self.base {
            Some(_) => Acceleration::SI_SYMBOL,
            None if self.holds_response() => Length::SI_SYMBOL,
            None => Force::SI_SYMBOL,
        }
    }

    /// Refuses values outside their ranges.
    pub(super) fn validate(&self, check: &Check<'_>, is_matrices: bool) -> Result<(), Error> {
        sampling(
            check,
            ["analyses.forced.harmonics", "analyses.forced.samples"],
            self.harmonics,
            self.samples,
        )?;
        let (base, force) = self.parts();
        check_excitation(check, &FIELDS, base.as_ref(), Some(&force), is_matrices)?;
        if base.is_some() {
            let alone = self.levels.is_empty() && !self.holds_response() && force == PointForce::default();
            check.that(
                alone,
                "analyses.forced.base",
                1.0,
                "(given)",
                "given without node, direction, terms and levels of a force or a response; its own levels are accelerations",
            )?;
        }
        if let Some(rayleigh) = self.rayleigh {
            check.not_negative("analyses.forced.rayleigh.mass", rayleigh.mass, "1/s")?;
            check.not_negative("analyses.forced.rayleigh.stiffness", rayleigh.stiffness, "s")?;
        }
        check.that(
            self.levels.is_empty() || !self.holds_response(),
            "analyses.forced.response_levels",
            self.response_levels.len() as f64,
            "(levels)",
            "left out where levels of the force are given",
        )?;
        let levels = self.levels();
        check.that(
            !levels.is_empty(),
            "analyses.forced.levels",
            0.0,
            "(levels)",
            "at least one",
        )?;
        for level in levels {
            check.positive("analyses.forced.levels", level, self.unit())?;
        }
        check.positive("analyses.forced.from_hz", self.from_hz, "Hz")?;
        check.positive("analyses.forced.to_hz", self.to_hz, "Hz")?;
        check.that(
            self.from_hz != self.to_hz,
            "analyses.forced.to_hz",
            self.to_hz,
            "Hz",
            "another frequency than analyses.forced.from_hz",
        )?;
        for (field, step) in [
            ("analyses.forced.amplitude_step", self.amplitude_step),
            ("analyses.forced.frequency_step", self.frequency_step),
        ] {
            check.that(step > 0.0 && step <= 1.0, field, step, "", "above 0 and at most 1")?;
        }
        check.that(
            self.tolerance >= 1e-13 && self.tolerance <= 1e-3,
            "analyses.forced.tolerance",
            self.tolerance,
            "",
            "between 1e-13 and 1e-3",
        )
    }
}
