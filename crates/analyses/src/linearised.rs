//! A structure about its static state: what all analyses of its vibration start from.

use cqsma_solver::Linearisation;
use harmonic_balance::NewtonSettings;
use joints::interface::InterfaceForce;
use joints::progress::Progress;
use reduction::ReducedModel;
use scenes::Scene;
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
