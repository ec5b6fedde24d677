//! How a motion begins, how it is followed, and what is recorded of it.

use super::scheme::AlgorithmicError;
use crate::newton::{Effort, Failure, LinearSolver, NewtonSettings};
use std::f64::consts::PI;

/// How motion begins.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// Released from the equilibrium under the load `alpha M phi` of the mode, `alpha` in sqrt(kg) m/s^2. The first
    /// acceleration is `-alpha phi` exactly, so that the mode alone begins to move.
    Release {
        /// Modal force `alpha`.
        modal_force: f64,
    },
    /// Struck at rest: one half-sine of force.
    Pulse {
        /// Integral of the force over time (N s).
        impulse: f64,
        /// Duration of the contact (s).
        duration: f64,
        /// Work-conjugate displacement as a row over the coordinates: the force acts along it.
        point: Vec<f64>,
    },
    /// Driven by a harmonic force, `amplitude cos(omega t)`, from a given motion, to which the history leads straight from the static
    /// state.
    Driven {
        /// Amplitude of the force (N).
        amplitude: f64,
        /// Its angular frequency (rad/s).
        omega: f64,
        /// Work-conjugate displacement as a row over the coordinates.
        point: Vec<f64>,
        /// Displacements from the static state (m), velocities (m/s) and accelerations (m/s^2) at time zero.
        motion: [Vec<f64>; 3],
    },
    /// Loaded at rest by a force that is known at equal steps of time, the first of them one step after the start, at which there is none: straight lines
    /// between them, nothing one step after the last.
    Record {
        /// Step (s).
        step: f64,
        /// Forces (N).
        values: Vec<f64>,
        /// Work-conjugate displacement as a row over the coordinates.
        point: Vec<f64>,
    },
}

impl Start {
    /// External force at a time (N).
    pub fn force_at(&self, time: f64) -> f64 {
        match self {
            Self::Release { .. } => 0.0,
            Self::Pulse { duration, .. } if time < *duration => self.peak_force() * (PI * time / duration).sin(),
            Self::Pulse { .. } => 0.0,
            Self::Driven { amplitude, omega, .. } => amplitude * (omega * time).cos(),
            Self::Record { step, values, .. } => recorded(*step, values, time),
        }
    }

    /// Largest size of the external force (N).
    pub(super) fn peak_force(&self) -> f64 {
        match self {
            Self::Release { .. } => 0.0,
            Self::Pulse { impulse, duration, .. } => 0.5 * PI * impulse / duration,
            Self::Driven { amplitude, .. } => *amplitude,
            Self::Record { values, .. } => values.iter().fold(0.0, |most, value| value.abs().max(most)),
        }
    }

    /// The row that an external force acts along, if there is one.
    pub(super) fn point(&self) -> Option<&[f64]> {
        match self {
            Self::Release { .. } => None,
            Self::Pulse { point, .. } | Self::Driven { point, .. } | Self::Record { point, .. } => Some(point),
        }
    }
}

/// Value at a time of a record whose values are one step apart, the first one step after zero.
fn recorded(step: f64, values: &[f64], time: f64) -> f64 {
    let place = time / step;
    let before = place.floor();
    let at = |index: f64| match index >= 1.0 && index <= values.len() as f64 {
        true => values[index as usize - 1],
        false => 0.0,
    };
    at(before) + (place - before) * (at(before + 1.0) - at(before))
}

/// How a motion is followed.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The mode that sets the step and that a release moves, zero-based.
    pub mode: usize,
    /// Steps per period of this mode, linearised.
    pub steps_per_period: usize,
    /// Periods of this mode to follow.
    pub periods: usize,
    /// Spectral radius of the scheme at infinite frequency, from 0 (such motion vanishes in a step) to 1.
    pub spectral_radius: f64,
    /// Viscous damping ratio of every linearised mode.
    pub background_damping: f64,
    /// Viscous damping ratio of the linearised modes beside that one, where it is larger: quietens what else was excited.
    pub other_damping: f64,
    /// Newton's method. The tolerance refers to the inertia at the energy of the moment, moving with the frequency of the
    /// mode; the halvings of a step in time are as many as those of a Newton step.
    pub newton: NewtonSettings,
    /// How its linear systems are solved.
    pub solver: LinearSolver,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: 0,
            steps_per_period: 100,
            periods: 100,
            spectral_radius: 0.9,
            background_damping: 0.0,
            other_damping: 0.0,
            newton: NewtonSettings {
                tolerance: 1e-8,
                max_iterations: 30,
                max_halvings: 8,
            },
            solver: LinearSolver::default(),
        }
    }
}

/// Where the energy is and has gone (J). Those of the bodies count from the static state, with the static force of the
/// contact in the contact's share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Energy {
    /// Kinetic.
    pub kinetic: f64,
    /// Part of it outside the mode.
    pub kinetic_elsewhere: f64,
    /// Elastic, of the bodies.
    pub elastic: f64,
    /// Work done on the contact since the start: dissipated by friction, and stored in it.
    pub contact: f64,
    /// Work done against viscous forces.
    pub viscous: f64,
    /// Work of the external force.
    pub external: f64,
}

impl Energy {
    /// Energy of all kinds beyond what the pulse has put in; its change from the first sample is what the scheme, unfinished
    /// iterations and round-off take away or add.
    pub fn balance(&self) -> f64 {
        self.kinetic + self.elastic + self.contact + self.viscous - self.external
    }
}

/// One moment; displacement, velocity and acceleration are those of the row observed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the start (s).
    pub time: f64,
    /// Displacement from the static state (m).
    pub displacement: f64,
    /// Velocity (m/s).
    pub velocity: f64,
    /// Acceleration (m/s^2).
    pub acceleration: f64,
    /// Energies.
    pub energy: Energy,
}

/// A motion followed.
#[derive(Clone, Debug)]
pub struct Transient {
    /// Step (s).
    pub step: f64,
    /// Uniform in time, the first at the start.
    pub samples: Vec<Sample>,
    /// Mean displacement of all coordinates over the last two periods of the mode (m): where the motion settles.
    pub settled: Vec<f64>,
    /// Why it ended before its time.
    pub failure: Option<Failure>,
    /// Steps that had to be halved.
    pub halved_steps: usize,
    /// Largest residual of a step, relative to the inertia that the tolerance refers to (energy norm).
    pub residual: f64,
    /// What the scheme does to the mode.
    pub algorithmic: AlgorithmicError,
    /// Work done.
    pub effort: Effort,
}

impl Transient {
    /// Largest change of [`Energy::balance`] relative to the largest energy that was in the motion.
    pub fn energy_error(&self) -> f64 {
        let Some(first) = self.samples.first() else { return 0.0 };
        let put_in = |s: &Sample| s.energy.kinetic + s.energy.elastic;
        let most = self.samples.iter().map(put_in).fold(0.0, f64::max);
        let change = |s: &Sample| (s.energy.balance() - first.energy.balance()).abs();
        self.samples.iter().map(change).fold(0.0, f64::max) / most
    }

    /// Share of the kinetic energy outside the mode, over all samples.
    pub fn share_elsewhere(&self) -> f64 {
        let sum = |part: fn(&Energy) -> f64| self.samples.iter().map(|s| part(&s.energy)).sum::<f64>();
        sum(|e| e.kinetic_elsewhere) / sum(|e| e.kinetic)
    }
}
