//! Stationary random vibration.

use super::check::Check;
use super::excitation::{
    BaseMotion, Excitation, ExcitationFields, PointFields, PointForce, check_excitation, excitation, of_kind, one_of,
};
use super::uncertain::NumberOrText;
use super::units::dimension::{OfAccelerationDensity, OfForceDensity};
use super::units::{Acceleration, AccelerationDensity, Force, ForceDensity};
use crate::Error;
use cqsma_solver::transient::MOST_STEPS;
use serde::{Deserialize, Serialize};

/// Names of the fields of its excitation.
pub(super) const FIELDS: ExcitationFields = ExcitationFields {
    base: ["analyses.random.base.direction", "analyses.random.base.motion"],
    point: PointFields {
        node: "analyses.random.force.node",
        direction: "analyses.random.force.direction",
        terms: "analyses.random.force.terms",
    },
};

/// Stationary random vibration under a moving base or a force, from the backbones of the modes followed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "RandomFields")]
pub struct Random {
    /// All supports move alike; either this or `force` is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<BaseMotion>,
    /// A force acts: at the response point in its direction, unless it says otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<PointForce>,
    /// One-sided power spectral density: frequencies (Hz), ascending, with densities of the base's acceleration ((m/s^2)^2/Hz) or of the force
    /// (N^2/Hz); straight lines in log-log between them, nothing beyond them.
    pub psd: Vec<(f64, f64)>,
    /// Levels: factors of the load's amplitude, so that the density is multiplied by their squares.
    pub levels: Vec<f64>,
    /// Motions in time beside it, under noise of the same density.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub in_time: Option<RandomInTime>,
}

/// Motions in time under stationary noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct RandomInTime {
    /// Periods of the first mode followed that the motion is followed for at each level.
    pub periods: usize,
    /// Steps per period.
    pub steps_per_period: usize,
    /// Number that the noise follows from: the same gives the same noise.
    pub seed: u64,
}

impl Default for RandomInTime {
    fn default() -> Self {
        Self {
            periods: 1000,
            steps_per_period: 50,
            seed: 1,
        }
    }
}

/// [`Random`] as files have it.
#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct RandomFields {
    /// All supports move alike; either this or `force` is given.
    #[serde(default)]
    base: Option<BaseMotion>,
    /// A force acts: at the response point in its direction, unless it says otherwise.
    #[serde(default)]
    force: Option<PointForce>,
    /// One-sided power spectral density: frequencies (Hz), ascending, with densities of the base's acceleration (texts: `(m/s^2)^2/Hz`, `g^2/Hz`) or
    /// of the force (`N^2/Hz`); straight lines in log-log between them, nothing beyond them.
    psd: Vec<(f64, NumberOrText)>,
    /// Levels: factors of the load's amplitude, so that the density is multiplied by their squares.
    #[serde(default = "as_given")]
    levels: Vec<f64>,
    /// Motions in time beside it, under noise of the same density.
    #[serde(default)]
    in_time: Option<RandomInTime>,
}

fn as_given() -> Vec<f64> {
    vec![1.0]
}

impl TryFrom<RandomFields> for Random {
    type Error = String;

    fn try_from(fields: RandomFields) -> Result<Self, String> {
        let is_base = one_of(fields.base.as_ref(), fields.force.as_ref())?;
        let psd = fields.psd.iter().zip(1..).map(|((frequency, value), number)| {
            let value = of_kind::<OfAccelerationDensity, OfForceDensity>(is_base, value)
                .map_err(|reason| format!("psd, number {number}: {reason}"))?;
            Ok((*frequency, value))
        });
        Ok(Self {
            psd: psd.collect::<Result<_, String>>()?,
            base: fields.base,
            force: fields.force,
            levels: fields.levels,
            in_time: fields.in_time,
        })
    }
}

impl Random {
    /// What drives the structure.
    pub fn excitation(&self) -> Excitation {
        excitation(self.base.as_ref(), self.force.as_ref())
    }

    /// Unit of the load.
    pub fn load_unit(&self) -> &'static str {
        match self.base {
            Some(_) => Acceleration::SI_SYMBOL,
            None => Force::SI_SYMBOL,
        }
    }

    /// Unit of the densities.
    pub fn unit(&self) -> &'static str {
        match self.base {
            Some(_) => AccelerationDensity::SI_SYMBOL,
            None => ForceDensity::SI_SYMBOL,
        }
    }

    /// Refuses values outside their ranges; `amplitudes` are those of the backbone.
    pub(super) fn validate(&self, check: &Check<'_>, amplitudes: usize, is_matrices: bool) -> Result<(), Error> {
        check_excitation(check, &FIELDS, self.base.as_ref(), self.force.as_ref(), is_matrices)?;
        let field = "analyses.random.psd";
        let points = self.psd.len();
        check.that(
            points > 1,
            field,
            points as f64,
            "(points)",
            "at least two points, since one has no band; give the first and the last frequency of a flat one",
        )?;
        for &(frequency, density) in &self.psd {
            check.positive(field, frequency, "Hz")?;
            let positive = density.is_finite() && density > 0.0;
            let requirement =
                "positive and finite; leave out frequencies without load, beyond the first and the last there is none";
            check.that(positive, field, density, self.unit(), requirement)?;
        }
        for pair in self.psd.windows(2) {
            let ascends = pair[0].0 < pair[1].0;
            check.that(
                ascends,
                field,
                pair[1].0,
                "Hz",
                "in ascending order, each frequency once",
            )?;
        }
        let levels = "analyses.random.levels";
        check.that(!self.levels.is_empty(), levels, 0.0, "(levels)", "at least one")?;
        for level in &self.levels {
            check.not_negative(levels, *level, "")?;
        }
        if let Some(asked) = self.in_time {
            let steps = asked.steps_per_period.saturating_mul(asked.periods);
            check.that(
                asked.steps_per_period >= 8,
                "analyses.random.in_time.steps_per_period",
                asked.steps_per_period as f64,
                "",
                "at least 8",
            )?;
            check.that(
                asked.periods >= 20 && steps <= MOST_STEPS,
                "analyses.random.in_time.periods",
                asked.periods as f64,
                "",
                "at least 20, and so few that they have at most 1e7 steps",
            )?;
        }
        check.that(
            amplitudes > 1,
            "analyses.backbone.amplitudes",
            amplitudes as f64,
            "",
            "at least 2 with analyses.random, which takes frequency and damping from the backbone",
        )
    }
}
