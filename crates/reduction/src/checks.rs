//! How well a reduced model keeps the spectrum of the full one.

use crate::Error;
use crate::craig_bampton::ReducedModel;
use crate::relative::RelativeSystem;
use faer::Mat;
use sprs::{CsMat, TriMat};
use substructure::eigen::{Modes, count_zero, lowest_modes};
use substructure::sparse::sum;

/// Frequencies of the full system with a linear interface, a stiffness over the jump coordinates (N/m), or without any
/// contact (Hz).
///
/// Returns the number of zero-energy modes and the `n` lowest frequencies above them.
///
/// # Errors
/// Failures of the factorisation or of the eigensolver.
pub fn full_frequencies(
    system: &RelativeSystem,
    interface: Option<&CsMat<f64>>,
    n: usize,
    tolerance: f64,
) -> Result<(usize, Vec<f64>), Error> {
    let modes = full_modes(system, interface, n, tolerance)?;
    Ok((modes.n_zero, modes.frequencies()))
}

/// The same with the mode shapes, over `[jump; rest]`.
///
/// # Errors
/// Failures of the factorisation or of the eigensolver.
pub fn full_modes(
    system: &RelativeSystem,
    interface: Option<&CsMat<f64>>,
    n: usize,
    tolerance: f64,
) -> Result<Modes, Error> {
    let size = system.stiffness.rows();
    let with_springs = interface.map(|interface| {
        let mut spring = TriMat::with_capacity((size, size), interface.nnz());
        for (&value, (i, j)) in interface {
            spring.add_triplet(i, j, value);
        }
        sum(&system.stiffness, 1.0, &spring.to_csr())
    });
    let stiffness = with_springs.as_ref().unwrap_or(&system.stiffness);
    Ok(lowest_modes(stiffness, &system.mass, &system.positions, n, tolerance)?)
}

/// Frequencies of the full system with the interface stuck (Hz), and the number of its zero-energy modes.
///
/// # Errors
/// Failures of the factorisation or of the eigensolver.
pub fn stuck_frequencies(system: &RelativeSystem, n: usize, tolerance: f64) -> Result<(usize, Vec<f64>), Error> {
    let modes = modes_of_rest(system, n, tolerance)?;
    Ok((modes.n_zero, modes.frequencies()))
}

/// The same with the mode shapes, over `[jump; rest]`.
///
/// # Errors
/// Failures of the factorisation or of the eigensolver.
pub fn stuck_modes(system: &RelativeSystem, n: usize, tolerance: f64) -> Result<Modes, Error> {
    let mut modes = modes_of_rest(system, n, tolerance)?;
    let mut shapes = Mat::zeros(system.stiffness.rows(), modes.shapes.ncols());
    let rest = shapes.nrows() - system.n_relative;
    shapes.subrows_mut(system.n_relative, rest).copy_from(&modes.shapes);
    modes.shapes = shapes;
    Ok(modes)
}

/// Modes of the structure whose jump is held, over the rest.
pub(crate) fn modes_of_rest(system: &RelativeSystem, n: usize, tolerance: f64) -> Result<Modes, Error> {
    let [stiffness, mass] = [&system.stiffness, &system.mass].map(|matrix| system.rest(matrix));
    let positions = &system.positions[system.n_relative..];
    Ok(lowest_modes(&stiffness, &mass, positions, n, tolerance)?)
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
    let mut stiffness = model.stiffness.clone();
    for (&value, (i, j)) in interface {
        stiffness[(i, j)] += value;
    }
    let (values, shapes) = lowest_pairs(stiffness, model, n)?;
    // A coordinate j that no stiffness couples to others carries the part (omega_j^2 - lambda) eta_j^2 of the Rayleigh
    // quotient; without it, the quotient of what remains of a mode is higher by as much.
    let without_mode = (model.n_relative..model.mass.nrows() - model.n_attachment)
        .map(|j| {
            let rise = |(i, lambda): (usize, &f64)| {
                0.5 * (model.stiffness[(j, j)] - lambda).abs() * shapes[(j, i)].powi(2) / lambda
            };
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
    let alone = |i: usize| model.stiffness[(i, i)] / model.mass[(i, i)];
    let sigma = (0..model.mass.nrows())
        .map(alone)
        .filter(|w2| *w2 > 0.0)
        .fold(f64::INFINITY, f64::min);
    if sigma.is_infinite() {
        return Ok((model.zem_stuck + model.mass.nrows(), Vec::new()));
    }
    let shifted = Mat::from_fn(model.mass.nrows(), model.mass.nrows(), |i, j| {
        model.stiffness[(i, j)] + sigma * model.mass[(i, j)]
    });
    // The sides of an interface without bolts move rigidly against each other.
    let (values, _) = lowest_pairs(shifted, model, n + 6)?;
    let values: Vec<f64> = values.into_iter().map(|value| value - sigma).collect();
    let n_zero = count_zero(&values, 1e-6 * sigma);
    let elastic = values[n_zero..].iter().take(n).copied();
    Ok((model.zem_stuck + n_zero, elastic.map(frequency).collect()))
}

fn lowest_pairs(stiffness: Mat<f64>, model: &ReducedModel, n: usize) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let n = n.min(stiffness.nrows());
    let lower = dense_algebra::cholesky_in_place(stiffness)?;
    let lowest = |n: usize| dense_algebra::lowest_pairs(lower.as_ref(), model.mass.as_ref(), n);
    lowest(n).or_else(|error| {
        // Massless coordinates have no modes of their own.
        match dense_algebra::rank(model.mass.as_ref())? {
            rank if (1..n).contains(&rank) => Ok(lowest(rank)?),
            _ => Err(error.into()),
        }
    })
}

/// Of the mode with this `omega^2` (Hz).
fn frequency(w2: f64) -> f64 {
    w2.sqrt() / (2.0 * std::f64::consts::PI)
}
