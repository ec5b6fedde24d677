//! How well a reduced model keeps the spectrum of the full one.

use crate::Error;
use crate::craig_bampton::ReducedModel;
pub use crate::full_modes::{full_frequencies, full_modes, stuck_frequencies, stuck_modes};
use dense_algebra::Factor;
use faer::Mat;
use finite_elements::eigen::count_zero;
use sprs::CsMat;

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
