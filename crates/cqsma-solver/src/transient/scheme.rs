//! The generalised-alpha method: its weights, and what it does to a linear oscillation.

use faer::c64;
use std::f64::consts::TAU;

/// Weights of the generalised-alpha method for a spectral radius at infinite frequency.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scheme {
    pub(super) alpha_m: f64,
    pub(super) alpha_f: f64,
    pub(super) beta: f64,
    pub(super) gamma: f64,
}

impl Scheme {
    pub(super) fn new(spectral_radius: f64) -> Self {
        let rho = spectral_radius;
        let (alpha_m, alpha_f) = ((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0));
        Self {
            alpha_m,
            alpha_f,
            beta: 0.25 * (1.0 - alpha_m + alpha_f).powi(2),
            gamma: 0.5 - alpha_m + alpha_f,
        }
    }
}

/// What the scheme itself does to an undamped linear oscillation, exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AlgorithmicError {
    /// Frequency over the true one.
    pub frequency_ratio: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
}

/// What the generalised-alpha method does to an undamped oscillation in `steps_per_period` steps per period: from the root
/// of its characteristic polynomial
/// `((1-a_m) z + a_m) (z-1)^2 + W^2 ((1-a_f) z + a_f) (b z^2 + (1/2+g-2b) z + 1/2-g+b)`, `W = 2 pi / steps_per_period`.
pub fn algorithmic_error(spectral_radius: f64, steps_per_period: f64) -> AlgorithmicError {
    let s = Scheme::new(spectral_radius);
    let angle = TAU / steps_per_period;
    let polynomial = |z: c64| {
        let newmark = z * z * s.beta + z * (0.5 + s.gamma - 2.0 * s.beta) + (0.5 - s.gamma + s.beta);
        let inertia = z * (1.0 - s.alpha_m) + s.alpha_m;
        let restoring = z * (1.0 - s.alpha_f) + s.alpha_f;
        inertia * (z - 1.0) * (z - 1.0) + restoring * newmark * (angle * angle)
    };
    // Secants in the complex plane from the true root and a neighbour.
    let (mut before, mut z) = (c64::cis(1.001 * angle), c64::cis(angle));
    let mut value = polynomial(before);
    for _ in 0..50 {
        let next = polynomial(z);
        let slope = (next - value) / (z - before);
        (before, value) = (z, next);
        let change = next / slope;
        if !(change.norm() > 0.0) {
            break;
        }
        z -= change;
        if change.norm() <= f64::EPSILON * angle {
            break;
        }
    }
    let exponent = z.ln();
    AlgorithmicError {
        frequency_ratio: exponent.norm() / angle,
        damping_ratio: -exponent.re / exponent.norm(),
    }
}
