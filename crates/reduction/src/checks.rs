//! How well a reduced model keeps the spectrum of the full one.

use crate::Error;
use crate::craig_bampton::ReducedModel;
use crate::relative::RelativeSystem;
use sprs::{CsMat, TriMat};
use substructure::eigen::lowest_modes;

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
    let size = system.stiffness.rows();
    let sum = interface.map(|interface| {
        let mut spring = TriMat::with_capacity((size, size), interface.nnz());
        for (&value, (i, j)) in interface {
            spring.add_triplet(i, j, value);
        }
        let spring: CsMat<f64> = spring.to_csr();
        &system.stiffness + &spring
    });
    let stiffness = sum.as_ref().unwrap_or(&system.stiffness);
    let modes = lowest_modes(stiffness, &system.mass, &system.positions, n, tolerance)?;
    Ok((modes.n_zero, modes.frequencies()))
}

/// Frequencies of the full system with the interface stuck (Hz), and the number of its zero-energy modes.
///
/// # Errors
/// Failures of the factorisation or of the eigensolver.
pub fn stuck_frequencies(system: &RelativeSystem, n: usize, tolerance: f64) -> Result<(usize, Vec<f64>), Error> {
    let [stiffness, mass] = [&system.stiffness, &system.mass].map(|matrix| system.blocks(matrix).rest);
    let modes = lowest_modes(&stiffness, &mass, &system.positions[system.n_relative..], n, tolerance)?;
    Ok((modes.n_zero, modes.frequencies()))
}

/// Frequencies of the reduced model with the same interface (Hz), `n` lowest.
///
/// # Errors
/// If the reduced mass is not positive definite or the eigenvalue decomposition fails.
pub fn reduced_frequencies(model: &ReducedModel, interface: &CsMat<f64>, n: usize) -> Result<Vec<f64>, Error> {
    let mut stiffness = model.stiffness.clone();
    for (&value, (i, j)) in interface {
        stiffness[(i, j)] += value;
    }
    let lower = dense_algebra::cholesky(model.mass.as_ref())?;
    let seen = dense_algebra::congruent(lower.as_ref(), stiffness.as_ref());
    let values = dense_algebra::symmetric_eigenvalues(seen.as_ref())?;
    Ok(values
        .iter()
        .take(n)
        .map(|w2| w2.max(0.0).sqrt() / (2.0 * std::f64::consts::PI))
        .collect())
}
