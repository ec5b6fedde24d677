//! Responses to harmonic forces.

use super::check::Check;
use super::epmc::sampling;
use super::units::Force;
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

impl Forced {
    /// Refuses values outside their ranges.
    pub(super) fn validate(&self, check: &Check<'_>) -> Result<(), Error> {
        sampling(
            check,
            ["analyses.forced.harmonics", "analyses.forced.samples"],
            self.harmonics,
            self.samples,
        )?;
        let both = self.node.is_some() == self.direction.is_some();
        let (node, terms) = (f64::from(u8::from(self.node.is_some())), self.terms.is_some());
        check.that(
            both,
            "analyses.forced.node",
            node,
            "(given)",
            "given together with analyses.forced.direction",
        )?;
        let one = !terms || self.node.is_none();
        check.that(
            one,
            "analyses.forced.terms",
            1.0,
            "(given)",
            "left out where analyses.forced.node is given",
        )?;
        if let Some(direction) = self.direction {
            let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
            let unit = (length - 1.0).abs() < 1e-6;
            check.that(unit, "analyses.forced.direction", length, "(length)", "a unit vector")?;
        }
        if let Some(rayleigh) = self.rayleigh {
            check.not_negative("analyses.forced.rayleigh.mass", rayleigh.mass, "1/s")?;
            check.not_negative("analyses.forced.rayleigh.stiffness", rayleigh.stiffness, "s")?;
        }
        for (_, _, factor) in self.terms.iter().flatten() {
            let finite = factor.is_finite() && *factor != 0.0;
            check.that(finite, "analyses.forced.terms", *factor, "", "finite and not zero")?;
        }
        let empty = self.terms.as_ref().is_some_and(Vec::is_empty);
        check.that(!empty, "analyses.forced.terms", 0.0, "(terms)", "at least one")?;
        check.that(
            !self.levels.is_empty(),
            "analyses.forced.levels",
            0.0,
            "(levels)",
            "at least one",
        )?;
        for level in &self.levels {
            check.positive("analyses.forced.levels", level.si(), "N")?;
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
