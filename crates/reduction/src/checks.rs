//! How well a reduced model keeps the spectrum of the full one.

use crate::Error;
use crate::craig_bampton::ReducedModel;
use crate::relative::RelativeSystem;
use faer::{Mat, Side};
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
    let size = model.mass.nrows();
    let fail = |operation, reason: String| Error::Dense { operation, reason };
    let mut stiffness = model.stiffness.clone();
    for (i, &value) in penalty.iter().enumerate() {
        stiffness[(i, i)] += value;
    }
    let llt = faer::linalg::solvers::Llt::new(model.mass.as_ref(), Side::Lower)
        .map_err(|e| fail("Cholesky factorisation of the reduced mass", format!("{e:?}")))?;
    let lower = llt.L();
    lower.solve_lower_triangular_in_place(stiffness.as_mut());
    let mut transposed = stiffness.transpose().to_owned();
    lower.solve_lower_triangular_in_place(transposed.as_mut());
    // Brought to unit size: the library's tolerances are absolute.
    let scale = transposed.norm_max();
    let symmetric = Mat::from_fn(size, size, |i, j| {
        0.5 / scale * (transposed[(i, j)] + transposed[(j, i)])
    });
    let values = symmetric
        .self_adjoint_eigenvalues(Side::Lower)
        .map_err(|e| fail("eigenvalue decomposition of the reduced model", format!("{e:?}")))?;
    Ok(values
        .iter()
        .take(n)
        .map(|w2| (w2 * scale).max(0.0).sqrt() / (2.0 * std::f64::consts::PI))
        .collect())
}
