//! What happens at the points of the contact along a periodic motion.

use crate::aft::{Contact, PointHistory, Sampling};
use crate::force::PointwiseForce;
use crate::harmonics::Harmonics;
use cqsma_solver::Linearisation;

/// Energy per area that each point takes per period by its tractions along x, y and n (J/m^2).
pub fn dissipation<F: PointwiseForce>(
    line: &Linearisation<'_, F::State>,
    force: &F,
    displacement: &Harmonics,
    sampling: Sampling,
) -> [Vec<f64>; 3] {
    Contact::new(force, line.displacement(), line.state(), sampling).dissipation(displacement)
}

/// Jumps and tractions of some points over the measured period; points that the force does not have are left out.
pub fn histories<F: PointwiseForce>(
    line: &Linearisation<'_, F::State>,
    force: &F,
    displacement: &Harmonics,
    sampling: Sampling,
    points: &[usize],
) -> Vec<PointHistory> {
    Contact::new(force, line.displacement(), line.state(), sampling).histories(displacement, points)
}
