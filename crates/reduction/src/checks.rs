//! How well a reduced model keeps the spectrum of the full one.

use crate::Error;
use crate::craig_bampton::ReducedModel;
use crate::relative::RelativeSystem;
use sprs::{CsMat, TriMat};
use substructure::eigen::lowest_modes;

/// Frequencies of the full system with a diagonal stiffness added to the jump (Hz).
///
/// `penalty` has one stiffness per jump coordinate (N/m); zero everywhere gives the unstressed assembly.
/// Returns the number of zero-energy modes and the `n` lowest frequencies above them.
///
/// # Errors
/// Failures of the factorisation or of the eigensolver.
pub fn full_frequencies(
    system: &RelativeSystem,
    penalty: &[f64],
    n: usize,
    tolerance: f64,
) -> Result<(usize, Vec<f64>), Error> {
    let size = system.stiffness.rows();
    let mut spring = TriMat::with_capacity((size, size), penalty.len());
    for (i, &value) in penalty.iter().enumerate() {
        spring.add_triplet(i, i, value);
    }
    let spring: CsMat<f64> = spring.to_csr();
    let stiffness = &system.stiffness + &spring;
    let modes = lowest_modes(&stiffness, &system.mass, &system.positions, n, tolerance)?;
    Ok((modes.n_zero, modes.frequencies()))
}

/// Frequencies of the reduced model with the same stiffness added to the jump (Hz), `n` lowest.
///
/// # Errors
/// If the reduced mass is not positive definite or the eigenvalue decomposition fails.
pub fn reduced_frequencies(model: &ReducedModel, penalty: &[f64], n: usize) -> Result<Vec<f64>, Error> {
    let mut stiffness = model.stiffness.clone();
    for (i, &value) in penalty.iter().enumerate() {
        stiffness[(i, i)] += value;
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
