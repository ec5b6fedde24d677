//! Rayleigh-quotient nonlinear modal analysis (RQNMA): the mode's shape changes with the amplitude.
//!
//! At a modal amplitude `q` the static equilibrium is sought whose load is the inertia of the motion itself,
//!
//! - `K u + F(u) - lambda M (u - u*) = F_b`,
//! - `(u - u*)^T M (u - u*) = q^2`,
//!
//! with the frequency `omega = sqrt(lambda)` as a further unknown: the stationary points of a nonlinear structure's
//! Rayleigh quotient, for small `q` its linear modes. No shape is assumed, unlike in the loops of
//! [`cqsma`](crate::cqsma), whose load keeps the shape of the linear mode. Damping follows from
//! [Masing's rule](crate::loading) along `alpha = lambda q`. The history that forces start from is that of the static
//! state throughout.
//!
//! Source: N. N. Balaji and M. R. W. Brake, *The surrogate system hypothesis for joint mechanics*, Mech. Syst. Signal
//! Process., 2020.

use crate::Error;
use crate::force::HystereticForce;
use crate::linear::Motion;
use crate::loading::{LoadingPoint, Settings, check, finished, follow};
use crate::modes::{Linearisation, Mode};
use crate::newton::Sequence;
use crate::path::Path;

/// One sweep through `modal_amplitudes` (sqrt(kg) m), positive and ascending; it begins in the direction of the linear
/// mode.
///
/// # Errors
/// Settings or amplitudes outside their range. A sweep that does not converge ends in points with a
/// [`Failure`](crate::Failure).
pub fn run<F: HystereticForce>(
    structure: &Linearisation<'_, F::State>,
    force: &F,
    modal_amplitudes: &[f64],
    settings: &Settings,
) -> Result<Vec<LoadingPoint>, Error> {
    check(settings, "modal_amplitude", modal_amplitudes)?;
    let mut mode = Mode::try_new(structure, force.pattern(), settings.mode)?;
    // The inertia of the linear mode at unit amplitude.
    mode.unit.scale(mode.eigenvalue);
    let sequence = Sequence::new(force, Motion::zero(mode.shape.len()), structure.state.clone());
    let solution = (settings.solver, settings.newton);
    let mut path = Path::new(structure.equilibrium(force), &mode.unit, 1.0, solution, sequence);
    path.mass = Some(structure.mass);
    finished(
        structure,
        follow(path, modal_amplitudes, settings.edges, |path| {
            (path.at, path.sequence.lambda)
        }),
    )
}
