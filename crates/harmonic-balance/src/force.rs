//! What harmonic balance needs to know of a hysteretic force beyond what equilibria need: its points.

use contact_laws::{Components, ComponentsMut, StateView, StateViewMut, TangentMut, along_path};
use cqsma_solver::{DifferentiableForce, HystereticForce};
use std::ops::Range;

/// A force that is the sum over points with a history each: the jump at a point is linear in the coordinates, and the law of a
/// point sees nothing of the others.
///
/// A period is followed point by point, in batches that share no history, so that batches can be evaluated in parallel.
/// States of a batch are stored as `[component][point]`.
pub trait PointwiseForce: HystereticForce {
    /// Number of points.
    fn n_points(&self) -> usize;
    /// The points of each batch; batches follow one another without holes, and none is empty.
    fn batches(&self) -> &[Range<usize>];
    /// Numbers that the history of one point of a batch has.
    fn n_state(&self, batch: usize) -> usize;
    /// Copies the histories of a batch out of a history of the whole force.
    fn state_of(&self, batch: usize, state: &Self::State, into: &mut [f64]);
    /// Jumps at all points that belong to displacements `u` of the leading coordinates (m): linear, without the gap.
    fn jumps(&self, u: &[f64], jump: [&mut [f64]; 3]);
    /// Takes what separates the bodies at rest off the jumps (m).
    fn subtract_gap(&self, jump_n: &mut [f64]);
    /// Forces on the leading coordinates (N) of tractions at all points (Pa).
    fn forces(&self, traction: [&[f64]; 3], force: &mut [f64]);
    /// Area that each point stands for (m^2).
    fn weights(&self) -> &[f64];
    /// Tangent values over the pattern (N/m) of tangents at all points, row by row (Pa/m).
    fn assemble_tangent(&self, tangent: [&[f64]; 9], values: &mut [f64]);
    /// Tractions, end state and, on request, tangent of a batch, with friction.
    fn evaluate_batch(
        &self,
        batch: usize,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        tangent: Option<TangentMut<'_>>,
    );
    /// Tractions of a batch along a path, step by step: `path` and `traction` are `[step][component][point]`, `state` becomes that at the end, and `room` is as
    /// large as it.
    fn follow_batch(&self, batch: usize, path: &[f64], state: &mut [f64], room: &mut [f64], traction: &mut [f64]) {
        let n = self.batches()[batch].len();
        along_path(n, path, state, room, traction, |jump, begin, end, traction| {
            self.evaluate_batch(batch, jump, begin, end, traction, None);
        });
    }
    /// The same with their derivatives along a change of jump and begin state
    /// ([`TractionLaw::derivative`](contact_laws::TractionLaw::derivative)).
    fn derivative_batch(
        &self,
        batch: usize,
        jump: Components<'_>,
        begin: StateView<'_>,
        d_jump: Components<'_>,
        d_begin: StateView<'_>,
        end: StateViewMut<'_>,
        d_end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        d_traction: ComponentsMut<'_>,
    );
}

/// A force whose points can be differentiated with respect to parameters too.
pub trait DifferentiablePointwiseForce: PointwiseForce + DifferentiableForce {
    /// [`PointwiseForce::derivative_batch`] with the change of a parameter by one beside those of jump and begin state, which are used up;
    /// `d_begin` is stored `[component][point]`.
    fn parameter_batch(
        &self,
        batch: usize,
        parameter: &Self::Parameter,
        jump: Components<'_>,
        begin: StateView<'_>,
        d_jump: ComponentsMut<'_>,
        d_begin: &mut [f64],
        end: StateViewMut<'_>,
        d_end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        d_traction: ComponentsMut<'_>,
    );
}
