//! A structure about its static state: what all analyses of its vibration start from.

use crate::Error;
use cqsma_solver::Linearisation;
use cqsma_solver::transient::Transient;
use harmonic_balance::NewtonSettings;
use joints::interface::InterfaceForce;
use joints::progress::Progress;
use joints::structure::Facts;
use reduction::ReducedModel;
use scenes::{Excitation, Scene};
use std::ops::ControlFlow;
use zte_assembly::State;

/// A structure about its static state.
#[derive(Clone, Copy)]
pub(super) struct Linearised<'a> {
    pub(super) scene: &'a Scene,
    pub(super) force: &'a InterfaceForce<'a>,
    /// The structure that vibrates, with locked bolts if they are so.
    pub(super) vibrating: &'a ReducedModel,
    pub(super) line: &'a Linearisation<'a, State>,
    /// Recovers the displacement at the response point.
    pub(super) response: &'a [f64],
    /// What is known of the full model.
    pub(super) facts: &'a Facts,
}

/// What drives the structure about its static state.
pub(super) struct Drive {
    /// Load per unit: of a force of 1 N, or of an acceleration of the supports of 1 m/s^2.
    pub(super) row: Vec<f64>,
    /// Of moving supports, what their motion does beside the load.
    pub(super) base: Option<Base>,
}

/// What moves with supports.
#[derive(Clone, Copy)]
pub(super) struct Base {
    /// Displacement at the response point when everything moves with the supports by one.
    pub(super) carried: f64,
    /// Mass of everything (kg), where it is known.
    pub(super) mass: Option<f64>,
}

impl Linearised<'_> {
    /// Damping ratio of a linearised mode, zero-based, apart from friction: that of the scene, and that of the structure's dampers.
    pub(super) fn background(&self, mode: usize) -> f64 {
        self.scene.background_damping + self.line.damper_ratio(mode)
    }

    /// What an excitation of one of the scene's analyses does: an acceleration of the supports loads the structure with minus the momentum per velocity.
    pub(super) fn drive(&self, excitation: &Excitation) -> Drive {
        let number = self.scene.analyses.recovered(excitation);
        let row = self.vibrating.recovery.row(number).iter().copied();
        let carried = number.checked_sub(1).and_then(|place| *self.facts.carried.get(place)?);
        match carried {
            None => Drive {
                row: row.collect(),
                base: None,
            },
            Some(carried) => Drive {
                row: row.map(|momentum| -momentum).collect(),
                base: Some(Base {
                    carried,
                    mass: self.facts.mass,
                }),
            },
        }
    }
}

/// A motion that was followed for all of the time `wanted` (s).
///
/// # Errors
/// [`Error::Transient`] for one that ended before.
pub(super) fn whole(mut motion: Transient, wanted: f64) -> Result<Transient, Error> {
    match motion.failure.take() {
        None => Ok(motion),
        Some(failure) => Err(Error::Transient {
            time: motion.samples.last().map_or(0.0, |s| s.time),
            wanted,
            reason: failure.reason,
            history: failure.history,
        }),
    }
}

/// Settings of harmonic balance with this tolerance.
pub(super) fn newton(tolerance: f64) -> NewtonSettings {
    NewtonSettings {
        tolerance,
        ..NewtonSettings::default()
    }
}

/// Whether a computation that asks step by step goes on.
pub(super) fn flow(progress: &dyn Progress) -> ControlFlow<()> {
    match progress.interrupted() {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    }
}
