//! The Masing shortcut: a whole backbone from one initial loading curve instead of closed loops.
//!
//! `K u + F(u) = F_b + alpha M phi` (eq. 40) is followed once from the static state to the largest modal force;
//! frequency and damping at every amplitude on the way come from [Masing's rule](crate::loading), with
//! `q = phi^T M (u - u*)` (eq. 41). The history that forces start from is that of the static state throughout: there is no reversal.

use crate::Error;
use crate::force::HystereticForce;
use crate::linear::Motion;
use crate::loading::{LoadingPoint, Settings, check, finished, follow};
use crate::modes::{Linearisation, Mode};
use crate::newton::Sequence;
use crate::path::Path;
use dense_algebra::dot;

/// One sweep through `modal_forces` (sqrt(kg) m/s^2), positive and ascending.
///
/// # Errors
/// Settings or forces outside their range. A sweep that does not converge ends in points with a
/// [`Failure`](crate::Failure).
pub fn run<F: HystereticForce>(
    structure: &Linearisation<'_, F::State>,
    force: &F,
    modal_forces: &[f64],
    settings: &Settings,
) -> Result<Vec<LoadingPoint>, Error> {
    check(settings, "modal_force", modal_forces)?;
    let mode = Mode::try_new(structure, force.pattern(), settings.mode)?;
    let sequence = Sequence::new(force, Motion::zero(mode.shape.len()), structure.state.clone());
    let solution = (settings.solver, settings.newton);
    let path = Path::new(structure.equilibrium(force), &mode.unit, 1.0, solution, sequence);
    finished(
        structure,
        follow(path, modal_forces, settings.edges, |path| {
            let q = dot(&mode.unit.force, &path.sequence.motion.v);
            (q, path.at / q)
        }),
    )
}
