//! Modes of the full structure: stuck, without contact, or with a linear interface.

use crate::Error;
use crate::part_modes::{modes_of_parts, modes_of_rest, with_held_jump};
use crate::relative::RelativeSystem;
use crate::symmetry::Parts;
use crate::zem::Supported;
use dense_algebra::{Limits, SystemMatrix, product, solve_lower, solve_lower_transposed};
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut};
use finite_elements::eigen::{Modes, Pair, finds_all, least_energy, lowest_modes_within};
use finite_elements::sparse::{multiply, multiply_into, sum};
use sprs::{CsMat, TriMat};
use std::borrow::Cow;
use std::ops::Range;

/// Frequencies of the full system with a linear interface, a stiffness over the jump coordinates (N/m), or without any
/// contact (Hz).
///
/// Returns the number of zero-energy modes and the `n` lowest frequencies above them.
///
/// # Errors
/// Failures of the factorisation or of the eigensolver; the `limits`.
pub fn full_frequencies(
    system: &RelativeSystem,
    interface: Option<&CsMat<f64>>,
    n: usize,
    tolerance: f64,
    limits: Limits<'_>,
) -> Result<(usize, Vec<f64>), Error> {
    let modes = full_modes(system, interface, n, tolerance, limits)?;
    Ok((modes.n_zero, modes.frequencies()))
}

/// The same with the mode shapes, over `[jump; rest]`.
///
/// # Errors
/// Failures of the factorisation or of the eigensolver; the `limits`.
pub fn full_modes(
    system: &RelativeSystem,
    interface: Option<&CsMat<f64>>,
    n: usize,
    tolerance: f64,
    limits: Limits<'_>,
) -> Result<Modes, Error> {
    let parts = Parts::of(Cow::Borrowed(system), interface);
    modes_of_whole(&parts, n, limits, |part, system, n, limits| {
        // What is not needed any more would be in the way of the factor.
        let (mut stiffness, mass, positions) = match system {
            Cow::Borrowed(own) => (
                Cow::Borrowed(&own.stiffness),
                Cow::Borrowed(&own.mass),
                Cow::Borrowed(&own.positions),
            ),
            Cow::Owned(own) => (
                Cow::Owned(own.stiffness),
                Cow::Owned(own.mass),
                Cow::Owned(own.positions),
            ),
        };
        if let Some(interface) = interface {
            let (interface, size) = (parts.springs(part, interface), stiffness.rows());
            let mut springs = TriMat::with_capacity((size, size), interface.nnz());
            for (&value, (i, j)) in interface.as_ref() {
                springs.add_triplet(i, j, value);
            }
            stiffness = Cow::Owned(sum(&stiffness, 1.0, &springs.to_csr()));
        }
        Ok(lowest_modes_within(
            limits, &stiffness, &mass, &positions, n, tolerance,
        )?)
    })
}

/// The modes of all parts, over the whole: those without energy, and the `n` lowest of the others.
fn modes_of_whole<'a>(
    parts: &'a Parts<'_>,
    n: usize,
    limits: Limits<'_>,
    of_part: impl Fn(usize, Cow<'a, RelativeSystem>, usize, Limits<'_>) -> Result<Modes, Error> + Sync,
) -> Result<Modes, Error> {
    let mut found = modes_of_parts(parts, Vec::new(), n, limits, of_part, |modes| modes)?;
    for (part, modes) in found.iter_mut().enumerate() {
        let own = std::mem::replace(&mut modes.shapes, Mat::zeros(0, 0));
        modes.shapes = parts.displacements(part, own);
    }
    if found.len() == 1 {
        return Ok(found.remove(0));
    }
    let of_kind = |range: &dyn Fn(&Modes) -> Range<usize>| -> Vec<(usize, usize)> {
        let each = found.iter().enumerate();
        each.flat_map(|(part, modes)| range(modes).map(move |mode| (part, mode)))
            .collect()
    };
    let eigenvalue = |&(part, mode): &(usize, usize)| found[part].eigenvalues[mode];
    let zero = of_kind(&|modes| 0..modes.n_zero);
    let mut elastic = of_kind(&|modes| modes.n_zero..modes.eigenvalues.len());
    elastic.sort_by(|a, b| eigenvalue(a).total_cmp(&eigenvalue(b)));
    elastic.truncate(n);
    let n_zero = zero.len();
    let order = [zero, elastic].concat();
    Ok(Modes {
        eigenvalues: order.iter().map(eigenvalue).collect(),
        shapes: Mat::from_fn(found[0].shapes.nrows(), order.len(), |i, j| {
            let (part, mode) = order[j];
            found[part].shapes[(i, mode)]
        }),
        n_zero,
        residual: found.iter().map(|modes| modes.residual).fold(0.0, f64::max),
    })
}

/// Frequencies of the full system with the interface stuck (Hz), and the number of its zero-energy modes.
///
/// # Errors
/// Failures of the factorisation or of the eigensolver; the `limits`.
pub fn stuck_frequencies(
    system: &RelativeSystem,
    n: usize,
    tolerance: f64,
    limits: Limits<'_>,
) -> Result<(usize, Vec<f64>), Error> {
    let modes = stuck_modes(system, n, tolerance, limits)?;
    Ok((modes.n_zero, modes.frequencies()))
}

/// The same with the mode shapes, over `[jump; rest]`.
///
/// # Errors
/// Failures of the factorisation or of the eigensolver; the `limits`.
pub fn stuck_modes(system: &RelativeSystem, n: usize, tolerance: f64, limits: Limits<'_>) -> Result<Modes, Error> {
    let parts = Parts::of(Cow::Borrowed(system), None);
    modes_of_whole(&parts, n, limits, |_, system, n, limits| {
        let nd = system.n_relative;
        let mut modes = modes_of_rest(system, n, tolerance, limits)?;
        modes.shapes = with_held_jump(modes.shapes.as_ref(), nd);
        Ok(modes)
    })
}

/// A linear interface to compare the frequencies of full and reduced models with.
#[derive(Clone, Copy, Debug)]
pub struct LinearCheck<'a> {
    /// Stiffness over the jump (N/m).
    pub springs: &'a CsMat<f64>,
    /// Frequencies that are found.
    pub count: usize,
    /// Residual that their modes reach.
    pub tolerance: f64,
    /// Whether the displacements of all loads are held.
    pub is_locked: bool,
}

/// Frequencies of the lowest modes of a system that store energy, with `check.springs` across its interface (Hz): the factor of the rest, and the
/// `condensed` stiffness, which it leaves, solve the whole.
pub(crate) fn frequencies_with_springs(
    system: &RelativeSystem,
    check: LinearCheck<'_>,
    supported: &Supported,
    condensed: &SystemMatrix,
    limits: Limits<'_>,
) -> Result<Vec<f64>, Error> {
    let (nd, n) = (system.n_relative, system.stiffness.rows());
    let springs = check.springs;
    if finds_all(n, check.count) {
        let locked = match check.is_locked {
            true => Cow::Owned(system.locked()?),
            false => Cow::Borrowed(system),
        };
        let (_, found) = full_frequencies(&locked, Some(springs), check.count, check.tolerance, limits)?;
        return Ok(found);
    }
    let entries = springs.iter().map(|(&value, (i, j))| (i, j, value));
    let jump = condensed.clone().factor_plus(entries)?;
    let jump_rest = system.jump_rest(&system.stiffness);
    let rest_jump = jump_rest.transpose_view().to_csr();
    let respond = |mut x: MatMut<'_, f64>| {
        let mut rest = x.rb().subrows(nd, n - nd).to_owned();
        supported.respond(rest.as_mut());
        let mut moved = x.rb().subrows(0, nd) - multiply(&jump_rest, rest.as_ref());
        jump.solve_in_place(moved.as_mut());
        x.rb_mut().subrows_mut(0, nd).copy_from(&moved);
        let mut follow = multiply(&rest_jump, moved.as_ref());
        supported.respond(follow.as_mut());
        x.subrows_mut(nd, n - nd).copy_from(rest - follow);
    };
    // Loads that hold their displacements.
    let acting: Vec<usize> = (0..system.loads.len())
        .filter(|&load| check.is_locked && system.loads[load].iter().any(|force| *force != 0.0))
        .collect();
    let loads = Mat::from_fn(n, acting.len(), |i, j| system.loads[acting[j]][i]);
    let mut yields = loads.clone();
    respond(yields.as_mut());
    let compliance = dense_algebra::cholesky(product(loads.transpose(), yields.as_ref()).as_ref());
    let compliance = compliance.map_err(|error| match error {
        dense_algebra::Error::NotPositiveDefinite { pivot, .. } => Error::DependentLoad { load: acting[pivot] },
        other => other.into(),
    })?;
    let modes = Pair {
        stiffness: &|x, mut y| {
            multiply_into(&system.stiffness, x, y.rb_mut());
            let mut own = y.subrows_mut(0, nd);
            own += multiply(springs, x.subrows(0, nd));
        },
        mass: &|x, y| multiply_into(&system.mass, x, y),
        solve: &|mut x| {
            respond(x.rb_mut());
            if !acting.is_empty() {
                let mut forces = product(loads.transpose(), x.rb());
                solve_lower(compliance.as_ref(), forces.as_mut());
                solve_lower_transposed(compliance.as_ref(), forces.as_mut());
                dense_algebra::add_product(x, yields.as_ref(), forces.as_ref(), -1.0);
            }
        },
        sigma: 0.0,
        energy: least_energy(&system.stiffness, &system.mass),
        zero_energy: with_held_jump(supported.modes.as_ref(), nd).as_ref(),
    }
    .lowest_modes(check.count, check.tolerance, limits)?;
    Ok(modes.frequencies())
}
