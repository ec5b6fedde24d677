//! How well a reduced model keeps the spectrum of the full one.

use crate::Error;
use crate::craig_bampton::ReducedModel;
use crate::part_modes::{modes_of_parts, modes_of_rest};
use crate::relative::RelativeSystem;
use crate::symmetry::Parts;
use dense_algebra::{Factor, Limits};
use faer::Mat;
use finite_elements::eigen::{Modes, count_zero, lowest_modes_within};
use finite_elements::sparse::sum;
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
    let parts = Parts::of(system, interface);
    modes_of_whole(&parts, n, limits, |part, n, limits| {
        // What is not needed any more would be in the way of the factor.
        let (mut stiffness, mass, positions) = match parts.system(part) {
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
fn modes_of_whole(
    parts: &Parts<'_>,
    n: usize,
    limits: Limits<'_>,
    of_part: impl Fn(usize, usize, Limits<'_>) -> Result<Modes, Error> + Sync,
) -> Result<Modes, Error> {
    let mut found = modes_of_parts(parts, n, limits, of_part)?;
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
    let parts = Parts::of(system, None);
    modes_of_whole(&parts, n, limits, |part, n, limits| {
        let own = parts.system(part);
        let (size, nd) = (own.stiffness.rows(), own.n_relative);
        let mut modes = modes_of_rest(own, n, tolerance, limits)?;
        let mut shapes = Mat::zeros(size, modes.shapes.ncols());
        shapes.subrows_mut(nd, size - nd).copy_from(&modes.shapes);
        modes.shapes = shapes;
        Ok(modes)
    })
}

/// The reduced model with the same interface: its frequencies, and what they owe to each mode.
#[derive(Clone, Debug)]
pub struct ReducedSpectrum {
    /// The lowest frequencies, ascending (Hz).
    pub frequencies: Vec<f64>,
    /// For each stuck-interface mode the largest relative rise of any of these frequencies if that mode were left out,
    /// to first order. The rises of several modes add up.
    pub without_mode: Vec<f64>,
}

/// The `n` lowest frequencies of the reduced model with a linear interface.
///
/// # Errors
/// If the stiffness with the interface is not positive definite, or the subspace iteration does not converge.
pub fn reduced_spectrum(model: &ReducedModel, interface: &CsMat<f64>, n: usize) -> Result<ReducedSpectrum, Error> {
    let springs = interface.iter().map(|(&value, (i, j))| (i, j, value));
    let (values, shapes) = lowest_pairs(model.stiffness.clone().factor_plus(springs)?, model, n)?;
    let squares = model.stiffness.as_ref().diagonal();
    // A coordinate j that no stiffness couples to others carries the part (omega_j^2 - lambda) eta_j^2 of the Rayleigh
    // quotient; without it, the quotient of what remains of a mode is higher by as much.
    let without_mode = (model.n_relative..model.size() - model.n_attachment)
        .map(|j| {
            let rise = |(i, lambda): (usize, &f64)| 0.5 * (squares[j] - lambda).abs() * shapes[(j, i)].powi(2) / lambda;
            values.iter().enumerate().map(rise).fold(0.0, f64::max)
        })
        .collect();
    Ok(ReducedSpectrum {
        frequencies: values.into_iter().map(frequency).collect(),
        without_mode,
    })
}

/// Frequencies of the reduced model without any contact (Hz).
///
/// Returns the number of zero-energy modes, those that the reduction took out included, and the `n` lowest frequencies
/// above them; fewer if the jump alone has more than six motions that cost no energy.
///
/// # Errors
/// If the stiffness is not positive semi-definite, or the subspace iteration does not converge.
pub fn unstressed_spectrum(model: &ReducedModel, n: usize) -> Result<(usize, Vec<f64>), Error> {
    // The lowest value that one coordinate alone would have: of the order of those that are sought.
    let (stiffness, mass) = (model.stiffness.as_ref(), model.mass.as_ref());
    let alone = stiffness.diagonal().into_iter().zip(mass.diagonal());
    let sigma = alone
        .map(|(k, m)| k / m)
        .filter(|w2| *w2 > 0.0)
        .fold(f64::INFINITY, f64::min);
    if sigma.is_infinite() {
        return Ok((model.zem_stuck + model.size(), Vec::new()));
    }
    let shifted = stiffness.plus(sigma, mass).factor_plus(std::iter::empty())?;
    // The sides of an interface without bolts move rigidly against each other.
    let (values, _) = lowest_pairs(shifted, model, n + 6)?;
    let values: Vec<f64> = values.into_iter().map(|value| value - sigma).collect();
    let n_zero = count_zero(&values, 1e-6 * sigma);
    let elastic = values[n_zero..].iter().take(n).copied();
    Ok((model.zem_stuck + n_zero, elastic.map(frequency).collect()))
}

fn lowest_pairs(factor: Factor, model: &ReducedModel, n: usize) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let n = n.min(model.size());
    let mass = model.mass.as_ref();
    factor.lowest_pairs(mass, n).or_else(|error| {
        let Some(dense) = mass.dense() else {
            return Err(error.into());
        };
        // Massless coordinates have no modes of their own.
        match dense_algebra::rank(dense)? {
            rank if (1..n).contains(&rank) => Ok(factor.lowest_pairs(mass, rank)?),
            _ => Err(error.into()),
        }
    })
}

/// Of the mode with this `omega^2` (Hz).
fn frequency(w2: f64) -> f64 {
    w2.sqrt() / (2.0 * std::f64::consts::PI)
}
