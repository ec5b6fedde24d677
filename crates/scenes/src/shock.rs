//! Shocks.

use super::check::Check;
use super::excitation::{
    BaseMotion, Excitation, ExcitationFields, PointFields, PointForce, check_excitation, excitation, of_kind, one_of,
};
use super::uncertain::NumberOrText;
use super::units::dimension::{OfAcceleration, OfForce};
use super::units::{Acceleration, Force};
use crate::Error;
use cqsma_solver::transient::MOST_STEPS;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Names of the fields of its excitation.
pub(super) const FIELDS: ExcitationFields = ExcitationFields {
    base: ["analyses.shock.base.direction", "analyses.shock.base.motion"],
    point: PointFields {
        node: "analyses.shock.force.node",
        direction: "analyses.shock.force.direction",
        terms: "analyses.shock.force.terms",
    },
};

/// A shock of the supports or of a force, followed in time from rest, beside the same of a joint that answers linearly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "ShockFields")]
pub struct Shock {
    /// All supports move alike; either this or `force` is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<BaseMotion>,
    /// A force acts: at the response point in its direction, unless it says otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<PointForce>,
    /// A pulse; either this or `record` is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pulse: Option<Pulse>,
    /// A measured acceleration of the supports.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub record: Option<Record>,
    /// Periods of the first mode followed that the motion is followed for.
    pub periods: usize,
    /// Steps per period.
    pub steps_per_period: usize,
    /// Quality factor of the oscillators of the shock response spectrum.
    pub quality: f64,
}

/// A pulse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Pulse {
    /// Its shape.
    pub shape: PulseShape,
    /// Its largest value: an acceleration of the supports (m/s^2), or a force (N).
    pub amplitude: f64,
    /// Its duration (s).
    pub duration_s: f64,
}

/// Shape of a pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum PulseShape {
    /// Half a period of a sine.
    HalfSine,
    /// A line from zero to the largest value at the end.
    SawTooth,
}

impl Pulse {
    /// Value at a time after its begin (s).
    pub fn at(&self, time: f64) -> f64 {
        let share = time / self.duration_s;
        match self.shape {
            _ if !(0.0..=1.0).contains(&share) => 0.0,
            PulseShape::HalfSine => self.amplitude * (std::f64::consts::PI * share).sin(),
            PulseShape::SawTooth => self.amplitude * share,
        }
    }
}

/// A record of a channel of a file, as `identify` reads them: UFF, MAT, NPZ, WAV, CSV.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// The file.
    pub path: PathBuf,
    /// Name or number of the channel; may be left out where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    /// Unit of the samples, such as `g` or `m/s^2`, where the file has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Samples per second (Hz), where the file has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_rate: Option<f64>,
}

/// [`Shock`] as files have it.
#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct ShockFields {
    /// All supports move alike; either this or `force` is given.
    #[serde(default)]
    base: Option<BaseMotion>,
    /// A force acts: at the response point in its direction, unless it says otherwise.
    #[serde(default)]
    force: Option<PointForce>,
    /// A pulse; either this or `record` is given.
    #[serde(default)]
    pulse: Option<PulseFields>,
    /// A measured acceleration of the supports.
    #[serde(default)]
    record: Option<Record>,
    /// Periods of the first mode followed that the motion is followed for.
    #[serde(default = "fifty")]
    periods: usize,
    /// Steps per period.
    #[serde(default = "hundred")]
    steps_per_period: usize,
    /// Quality factor of the oscillators of the shock response spectrum.
    #[serde(default = "ten")]
    quality: f64,
}

/// [`Pulse`] as files have it.
#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct PulseFields {
    /// Its shape.
    shape: PulseShape,
    /// Its largest value: an acceleration of the supports (texts: `m/s^2`, `g`), or a force.
    amplitude: NumberOrText,
    /// Its duration (s).
    duration_s: f64,
}

fn fifty() -> usize {
    50
}

fn hundred() -> usize {
    100
}

fn ten() -> f64 {
    10.0
}

impl TryFrom<ShockFields> for Shock {
    type Error = String;

    fn try_from(fields: ShockFields) -> Result<Self, String> {
        let is_base = one_of(fields.base.as_ref(), fields.force.as_ref())?;
        let pulse = match (fields.pulse, &fields.record) {
            (Some(pulse), None) => Some(Pulse {
                shape: pulse.shape,
                amplitude: of_kind::<OfAcceleration, OfForce>(is_base, &pulse.amplitude)
                    .map_err(|reason| format!("pulse.amplitude: {reason}"))?,
                duration_s: pulse.duration_s,
            }),
            (None, Some(_)) if is_base => None,
            (None, Some(_)) => {
                return Err("`record` is an acceleration of the supports; give `base` in the place of `force`".into());
            }
            _ => return Err("exactly one of `pulse` and `record` must be given".into()),
        };
        Ok(Self {
            base: fields.base,
            force: fields.force,
            pulse,
            record: fields.record,
            periods: fields.periods,
            steps_per_period: fields.steps_per_period,
            quality: fields.quality,
        })
    }
}

impl Shock {
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

    /// Refuses values outside their ranges.
    pub(super) fn validate(&self, check: &Check<'_>, is_matrices: bool) -> Result<(), Error> {
        check_excitation(check, &FIELDS, self.base.as_ref(), self.force.as_ref(), is_matrices)?;
        if let Some(pulse) = self.pulse {
            let finite = pulse.amplitude.is_finite() && pulse.amplitude != 0.0;
            check.that(
                finite,
                "analyses.shock.pulse.amplitude",
                pulse.amplitude,
                self.load_unit(),
                "finite and not zero",
            )?;
            check.positive("analyses.shock.pulse.duration_s", pulse.duration_s, "s")?;
        }
        if let Some(rate) = self.record.as_ref().and_then(|record| record.sample_rate) {
            check.positive("analyses.shock.record.sample_rate", rate, "Hz")?;
        }
        let steps = self.steps_per_period.saturating_mul(self.periods);
        check.that(
            self.steps_per_period >= 8,
            "analyses.shock.steps_per_period",
            self.steps_per_period as f64,
            "",
            "at least 8",
        )?;
        check.that(
            (1..=MOST_STEPS).contains(&steps),
            "analyses.shock.periods",
            self.periods as f64,
            "",
            "at least 1, and so few that they have at most 1e7 steps",
        )?;
        let quality = self.quality;
        check.that(
            quality.is_finite() && quality >= 1.0,
            "analyses.shock.quality",
            quality,
            "",
            "finite and at least 1",
        )
    }
}
