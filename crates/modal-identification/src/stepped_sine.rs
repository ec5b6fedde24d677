//! Sine tests at controlled response: frequency and damping ratio at each response that was held.
//!
//! While the amplitude of the response is held, so are stiffness `k` and damping `c` of a mode that depend on it. A force `F cos(w t)` with the response
//! `x cos(w t - phi)` then says, with the mass `m` of the mode at its points of force and response,
//!
//! `F exp(i phi) / x = k - m w^2 + i c w`,
//!
//! which is linear in all three: least squares at each level. At phase resonance, a quarter period, one frequency is enough if the mass is known:
//! `zeta = F / (2 m w^2 x)`.
//!
//! In a sweep the frequency changes, and the amplitude where it is not held. With `x(t) = X(t) exp(i theta(t))`, `theta' = w`, the mass has the acceleration
//! `(-w^2 + i (w' + 2 w X'/X)) x` to first order in the changes: the right side above gains `i m (w' + 2 w X'/X)`.

use crate::signal::Quantity;
use std::f64::consts::TAU;

/// Phases that are used lie as far from 0 and 180 degrees (degrees): farther from the resonance other modes count.
pub(crate) const LEAST_PHASE: f64 = 25.0;

/// Fewest frequencies of a fit: one more than it has parameters.
const LEAST_FREQUENCIES: usize = 4;

/// Distance from a quarter period up to which a test counts as one of phase resonance (degrees).
const PHASE_RESONANCE: f64 = 5.0;

/// A steady state of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Amplitude of the force (N).
    pub force: f64,
    /// Amplitude of the response (SI unit of its quantity).
    pub response: f64,
    /// How far the displacement lags behind the force (degrees).
    pub phase_deg: f64,
    /// `f' + 2 f X'/X` of a frequency `f` and an amplitude of displacement `X` that change (Hz/s); zero in a steady state.
    pub drift_hz_per_s: f64,
}

impl Step {
    /// Whether its phase is between `least` and 180 degrees less that.
    pub(crate) fn is_near(&self, least: f64) -> bool {
        self.phase_deg >= least && self.phase_deg <= 180.0 - least
    }
}

/// Steps at one level.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// As the file names it.
    pub name: String,
    /// What the response measures.
    pub quantity: Quantity,
    /// The steps.
    pub steps: Vec<Step>,
}

/// What a level says of the mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    /// Mean amplitude of the response (SI unit of its quantity).
    pub amplitude: f64,
    /// Largest difference of an amplitude from it, relative: how well the response was held.
    pub amplitude_error: f64,
    /// Undamped natural frequency (Hz).
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Mass of the mode at the points of force and response (kg): found, or as it was given.
    pub modal_mass: f64,
    /// Root mean square of what the fit leaves of the force, relative to that of the force; none at phase resonance.
    pub residual: Option<f64>,
    /// Frequencies used.
    pub steps: usize,
}

/// Why a level says nothing.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Unfitted {
    /// Too few frequencies about the resonance.
    #[error(
        "{found} of its frequencies have a phase between {LEAST_PHASE} and {} degrees; a fit needs {LEAST_FREQUENCIES}, and one at a quarter period \
         needs the modal mass",
        180.0 - LEAST_PHASE
    )]
    TooFew {
        /// How many there are.
        found: usize,
    },
    /// No mode.
    #[error(
        "its stiffness {stiffness:e} N/m, mass {mass:e} kg and damping {damping:e} N s/m are not those of a mode: all must be positive"
    )]
    NoMode {
        /// Fitted stiffness.
        stiffness: f64,
        /// Fitted mass.
        mass: f64,
        /// Fitted damping.
        damping: f64,
    },
}

impl Level {
    /// Fits a mode to the level, or where it has too few frequencies takes it at phase resonance with a modal mass (kg) that is known.
    ///
    /// # Errors
    /// [`Unfitted`].
    pub fn fit(&self, modal_mass: Option<f64>) -> Result<Fitted, Unfitted> {
        let derivatives = self.quantity.derivatives();
        let displacement = |step: &Step| step.response / (TAU * step.frequency_hz).powi(derivatives);
        let used = self.near(LEAST_PHASE);
        if used.len() < LEAST_FREQUENCIES {
            if let (Some(mass), [step]) = (modal_mass, self.near(90.0 - PHASE_RESONANCE).as_slice()) {
                let omega = TAU * step.frequency_hz;
                let in_quadrature = step.force * step.phase_deg.to_radians().sin();
                return Ok(Fitted {
                    amplitude: step.response,
                    amplitude_error: 0.0,
                    frequency_hz: step.frequency_hz,
                    damping_ratio: in_quadrature / (2.0 * mass * omega * omega * displacement(step)),
                    modal_mass: mass,
                    residual: None,
                    steps: 1,
                });
            }
            return Err(Unfitted::TooFew { found: used.len() });
        }
        let count = used.len() as f64;
        // Per step: square of the frequency, frequency, dynamic stiffness, what the mass adds to it where the motion changes.
        let data: Vec<[f64; 5]> = used
            .iter()
            .map(|step| {
                let omega = TAU * step.frequency_hz;
                let (sine, cosine) = step.phase_deg.to_radians().sin_cos();
                let size = step.force / displacement(step);
                [
                    omega * omega,
                    omega,
                    size * cosine,
                    size * sine,
                    TAU * step.drift_hz_per_s,
                ]
            })
            .collect();
        let mean = |of: fn(&[f64; 5]) -> f64| data.iter().map(of).sum::<f64>() / count;
        let (square, real) = (mean(|d| d[0]), mean(|d| d[2]));
        let spread: f64 = data.iter().map(|d| (d[0] - square).powi(2)).sum();
        let slope = data.iter().map(|d| (d[0] - square) * (d[2] - real)).sum::<f64>() / spread;
        let (mass, stiffness) = (-slope, real - slope * square);
        let damped = |d: &[f64; 5]| d[3] - mass * d[4];
        let damping = data.iter().map(|d| d[1] * damped(d)).sum::<f64>() / data.iter().map(|d| d[0]).sum::<f64>();
        if !(mass > 0.0 && stiffness > 0.0 && damping > 0.0 && stiffness.is_finite()) {
            return Err(Unfitted::NoMode {
                stiffness,
                mass,
                damping,
            });
        }
        let left = |d: &[f64; 5]| (stiffness - mass * d[0] - d[2]).powi(2) + (damping * d[1] - damped(d)).powi(2);
        let whole: f64 = data.iter().map(|d| d[2] * d[2] + d[3] * d[3]).sum();
        let amplitude = used.iter().map(|step| step.response).sum::<f64>() / count;
        let apart = used.iter().map(|step| (step.response / amplitude - 1.0).abs());
        Ok(Fitted {
            amplitude,
            amplitude_error: apart.fold(0.0, f64::max),
            frequency_hz: (stiffness / mass).sqrt() / TAU,
            damping_ratio: 0.5 * damping / (stiffness * mass).sqrt(),
            modal_mass: mass,
            residual: Some((data.iter().map(left).sum::<f64>() / whole).sqrt()),
            steps: used.len(),
        })
    }

    /// The steps that are near the resonance by `least`.
    fn near(&self, least: f64) -> Vec<Step> {
        self.steps.iter().filter(|step| step.is_near(least)).copied().collect()
    }
}
