//! What is known of an element at an amplitude.

use serde::Serialize;
use std::f64::consts::PI;

/// A closed loop of force against displacement, in units that belong together: displacement in m, stiffness in N/m and dissipation in J; of a modal
/// coordinate sqrt(kg) m, rad^2/s^2 and J.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Level {
    /// Half the range of the displacement.
    pub amplitude: f64,
    /// Half the range of the force, over it.
    pub stiffness: f64,
    /// Dissipation per cycle; none where it is not told from noise.
    pub dissipation: Option<f64>,
}

impl Level {
    /// Loss factor of a linear element of this stiffness with structural damping that dissipates as much: `D / (pi K u^2)`.
    pub fn loss_factor(&self) -> Option<f64> {
        Some(self.dissipation? / (PI * self.stiffness * self.amplitude.powi(2)))
    }
}

/// An element whose steady loops between `-u` and `u` are known.
pub trait Hysteretic {
    /// Half the range of the force over that of the displacement `u`.
    fn stiffness(&self, u: f64) -> f64;

    /// Dissipation per cycle at the amplitude `u`.
    fn dissipation(&self, u: f64) -> f64;
}
