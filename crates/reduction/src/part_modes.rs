//! Lowest modes of the parts of a structure, and of one whose jump is held.

use crate::Error;
use crate::relative::RelativeSystem;
use crate::symmetry::Parts;
use crate::zem::Supported;
use dense_algebra::Limits;
use faer::reborrow::ReborrowMut;
use faer::{Mat, MatMut, MatRef};
use finite_elements::eigen::{Modes, Pair, finds_all, least_energy, lowest_modes_within, zero_energy_motions};
use finite_elements::factor::Condensed;
use finite_elements::groups::Groups;
use finite_elements::sparse::multiply_into;
use sprs::CsMat;
use std::borrow::Cow;

/// Share of the time of condensing and of finding modes with the same factor that condensing takes.
const CONDENSING: f64 = 0.7;

/// What is found of each part, with `modes` among it: those without energy, and at least those that are among the `n` lowest of the others of all parts.
/// `of_part` finds so many of a part, or all if there are fewer, from its system and within the limits for it. Systems may be `separate` ones ([`Parts::each`]).
pub(crate) fn modes_of_parts<'a, T: Send>(
    parts: &'a Parts<'_>,
    separate: Vec<RelativeSystem>,
    n: usize,
    limits: Limits<'_>,
    of_part: impl Fn(usize, Cow<'a, RelativeSystem>, usize, Limits<'_>) -> Result<T, Error> + Sync,
    modes: impl Fn(&T) -> &Modes,
) -> Result<Vec<T>, Error> {
    // Parts have about as many each. Large ones, whose systems may be given away, cannot be asked again.
    let share = match parts.len() > 1 && parts.are_small() {
        true => n.min(3 * n / 5 + 2),
        false => n,
    };
    let mut found = parts.each(separate, limits, |part, system, limits| {
        of_part(part, system, share, limits)
    })?;
    let elastic = |of: &T| modes(of).eigenvalues[modes(of).n_zero..].to_vec();
    let mut all: Vec<f64> = found.iter().flat_map(elastic).collect();
    all.sort_by(f64::total_cmp);
    // At most the highest that is wanted.
    let highest = all.get(n.saturating_sub(1)).copied().unwrap_or(f64::INFINITY);
    for (part, of) in found.iter_mut().enumerate() {
        let own = elastic(of);
        let may_lack = own.len() == share && own.last().is_none_or(|last| *last < highest);
        if share < n && may_lack {
            *of = of_part(part, parts.system(part), n, limits.of_part(part, parts.len()))?;
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

/// As [`modes_of_rest`], by the factor of the supported rest. Its modes without energy are those that it knows, and more if there are more.
pub(crate) fn modes_of_supported(
    system: &RelativeSystem,
    supported: &Supported,
    n: usize,
    tolerance: f64,
    limits: Limits<'_>,
) -> Result<Modes, Error> {
    let nd = system.n_relative;
    let at_rest = |a: &CsMat<f64>, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>| {
        multiply_into(a, x, y.rb_mut());
        y.subrows_mut(0, nd).fill(0.0);
    };
    let mut modes = Pair {
        stiffness: &|x, y| at_rest(&system.stiffness, x, y),
        mass: &|x, y| at_rest(&system.mass, x, y),
        solve: &|mut x| {
            x.rb_mut().subrows_mut(0, nd).fill(0.0);
            supported.respond(x.subrows_mut(nd, system.n_rest()));
        },
        sigma: 0.0,
        energy: least_energy(&system.stiffness, &system.mass),
        zero_energy: with_held_jump(supported.modes.as_ref(), nd).as_ref(),
    }
    .lowest_modes(n, tolerance, limits)?;
    modes.shapes = modes.shapes.subrows(nd, system.n_rest()).to_owned();
    Ok(modes)
}

/// Supports the rest of a system and condenses it onto the jump, and finds the `n` lowest modes of the stuck structure with the same factor, to this
/// tolerance. Its zero-energy modes are those rigid motions that cost no energy; where there are others too, or rigid motions are not known and so many are
/// expected, they and all modes are found before, with a factor of their own.
pub(crate) fn condense_with_modes(
    system: &RelativeSystem,
    kept: &Groups,
    n: usize,
    (tolerance, expected_zem): (f64, usize),
    limits: Limits<'_>,
) -> Result<(Supported, Condensed, Modes), Error> {
    let (first, second) = (limits.part(0.0, CONDENSING), limits.part(CONDENSING, 1.0));
    let is_known = system.rigid_motions.ncols() > 0 || expected_zem == 0;
    if is_known && !finds_all(system.n_rest(), n) {
        let rigid = zero_energy_motions(&system.stiffness, &system.mass, system.rigid_motions.as_ref())?;
        let rigid = rigid.subrows(system.n_relative, system.n_rest());
        let found = Supported::condense(system, rigid, kept, first).and_then(|(supported, condensed)| {
            let modes = modes_of_supported(system, &supported, n, tolerance, second)?;
            Ok((supported, condensed, modes))
        });
        match found {
            Ok((supported, condensed, mut modes)) if modes.n_zero == rigid.ncols() => {
                // To the last bit those that the rest is supported for.
                modes.shapes.subcols_mut(0, modes.n_zero).copy_from(rigid);
                return Ok((supported, condensed, modes));
            }
            // A matrix that is singular but for round-off.
            Ok(_) => {}
            Err(Error::Substructure(
                finite_elements::Error::NotPositiveDefinite { .. } | finite_elements::Error::EigenNotConverged { .. },
            )) => {}
            Err(error) => return Err(error),
        }
    }
    let modes = modes_of_rest(Cow::Borrowed(system), n, tolerance, first)?;
    let (supported, condensed) = Supported::condense(system, modes.zero_energy(), kept, second)?;
    Ok((supported, condensed, modes))
}

/// Columns over the rest, over `[jump; rest]`.
pub(crate) fn with_held_jump(rest: MatRef<'_, f64>, n_relative: usize) -> Mat<f64> {
    let mut whole = Mat::zeros(n_relative + rest.nrows(), rest.ncols());
    whole.subrows_mut(n_relative, rest.nrows()).copy_from(rest);
    whole
}
