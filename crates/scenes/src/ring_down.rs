//! Free decay in time.

use super::units::{Force, Length};
use cqsma_solver::transient;
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
