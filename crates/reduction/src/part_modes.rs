//! Lowest modes of the parts of a structure, and of one whose jump is held.

use crate::Error;
use crate::relative::RelativeSystem;
use crate::symmetry::Parts;
use dense_algebra::Limits;
use finite_elements::eigen::{Modes, lowest_modes_within};
use std::borrow::Cow;

/// Modes of each part: those without energy, and at least those that are among the `n` lowest of the others of all parts. `of_part` finds so many of a
/// part, or all if there are fewer, within the limits for it.
pub(crate) fn modes_of_parts(
    parts: &Parts<'_>,
    n: usize,
    limits: Limits<'_>,
    of_part: impl Fn(usize, usize, Limits<'_>) -> Result<Modes, Error> + Sync,
) -> Result<Vec<Modes>, Error> {
    // Parts have about as many each.
    let share = match parts.len() {
        1 => n,
        _ => n.min(3 * n / 5 + 2),
    };
    let mut found = parts.each(limits, |part, limits| of_part(part, share, limits))?;
    let mut all: Vec<f64> = found
        .iter()
        .flat_map(|modes| &modes.eigenvalues[modes.n_zero..])
        .copied()
        .collect();
    all.sort_by(f64::total_cmp);
    // At most the highest that is wanted.
    let highest = all.get(n.saturating_sub(1)).copied().unwrap_or(f64::INFINITY);
    for (part, modes) in found.iter_mut().enumerate() {
        let elastic = &modes.eigenvalues[modes.n_zero..];
        let may_lack = elastic.len() == share && elastic.last().is_none_or(|last| *last < highest);
        if share < n && may_lack {
            *modes = of_part(part, n, limits.of_part(part, parts.len()))?;
        }
    }
    Ok(found)
}

/// Modes of the structure whose jump is held, over the rest.
pub(crate) fn modes_of_rest(
    system: Cow<'_, RelativeSystem>,
    n: usize,
    tolerance: f64,
    limits: Limits<'_>,
) -> Result<Modes, Error> {
    let [stiffness, mass] = [&system.stiffness, &system.mass].map(|matrix| system.rest(matrix));
    let positions = system.positions[system.n_relative..].to_vec();
    // It would be in the way of the factor.
    drop(system);
    Ok(lowest_modes_within(
        limits, &stiffness, &mass, &positions, n, tolerance,
    )?)
}
