//! Free decay in time.

use super::check::Check;
use super::units::{Force, Length};
use crate::Error;
use cqsma_solver::transient::{self, MOST_STEPS};
use serde::{Deserialize, Serialize};

/// A free decay of the first mode followed, in time, begun by `release` or by `strike`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct RingDown {
    /// Displacement of the response point that the mode is released from, by linear estimate (length): from the equilibrium under its own
    /// inertial load.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub release: Option<Length>,
    /// In its place, a half-sine of force along the response.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strike: Option<Strike>,
    /// Periods of the linearised mode to follow.
    pub periods: usize,
    /// Steps per period.
    pub steps_per_period: usize,
    /// Spectral radius of the integration at infinite frequency, from 0 to 1.
    pub spectral_radius: f64,
    /// Viscous damping ratio of the linearised modes beside the one followed, where it is larger than `background_damping` (-).
    pub other_damping: f64,
}

/// A half-sine of force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Strike {
    /// Largest force (force).
    pub force: Force,
    /// Its duration (s).
    pub contact_time_s: f64,
}

impl Default for RingDown {
    fn default() -> Self {
        let solver = transient::Settings::default();
        Self {
            release: None,
            strike: None,
            periods: 150,
            steps_per_period: solver.steps_per_period,
            spectral_radius: solver.spectral_radius,
            other_damping: solver.other_damping,
        }
    }
}

impl RingDown {
    /// Refuses values outside their ranges.
    pub(super) fn validate(&self, check: &Check<'_>) -> Result<(), Error> {
        let one = self.release.is_some() != self.strike.is_some();
        check.that(
            one,
            "analyses.ring_down",
            f64::from(u8::from(self.release.is_some())) + f64::from(u8::from(self.strike.is_some())),
            "(of release and strike)",
            "begun by one of the two, such as \"release\": \"1 mm\"",
        )?;
        if let Some(release) = self.release {
            check.positive("analyses.ring_down.release", release.si(), "m")?;
        }
        if let Some(strike) = self.strike {
            check.positive("analyses.ring_down.strike.force", strike.force.si(), "N")?;
            check.positive("analyses.ring_down.strike.contact_time_s", strike.contact_time_s, "s")?;
        }
        let periods = self.periods as f64;
        check.that(
            self.periods > 0,
            "analyses.ring_down.periods",
            periods,
            "",
            "at least 1",
        )?;
        check.that(
            (1..=MOST_STEPS).contains(&self.steps_per_period.saturating_mul(self.periods)),
            "analyses.ring_down.periods",
            periods,
            "",
            "so few that they have at most 1e7 steps; follow fewer periods, or take fewer steps for each",
        )?;
        let radius = self.spectral_radius;
        check.that(
            (0.0..=1.0).contains(&radius),
            "analyses.ring_down.spectral_radius",
            radius,
            "",
            "between 0 and 1",
        )?;
        check.not_negative("analyses.ring_down.other_damping", self.other_damping, "")
    }
}
