//! The basis of the coordinates beside the jump: modes of the stuck structure, and its responses to the loads.

use crate::Error;
use dense_algebra::product;
use faer::{Mat, MatRef};

/// Least flexibility of a load, relative to its whole one, that the other coordinates must leave to its own.
const LEAST_FLEXIBILITY: f64 = 1e-8;

/// Mass-normalised modes of the stuck structure, and behind them its static responses to loads, as far as their products with stiffness and mass tell.
pub(crate) struct Interior {
    /// `omega^2` of the modes (rad^2/s^2).
    eigenvalues: Vec<f64>,
    /// All modes that the stuck structure has.
    n_complete: usize,
    /// The loads that there are responses to.
    attached: Vec<usize>,
    /// Work of these loads in modes and responses.
    work: Mat<f64>,
    /// Momentum of the responses in modes and responses.
    momentum: Mat<f64>,
}

/// Coordinates of the interior that are retained.
pub(crate) struct Retained {
    /// Their `omega^2` (rad^2/s^2).
    pub(crate) eigenvalues: Vec<f64>,
    /// Each as a combination of modes and responses.
    pub(crate) turn: Mat<f64>,
    /// How many of them, the last ones, stand for loads.
    pub(crate) n_attachment: usize,
}

impl Interior {
    /// Of modes with these `eigenvalues` among `n_complete`, and of the static responses to the loads numbered `attached`. `shapes` are all of
    /// them; columns of `loads` are these loads, of `momentum` the mass times the responses.
    pub(crate) fn new(
        (eigenvalues, n_complete): (&[f64], usize),
        shapes: MatRef<'_, f64>,
        attached: &[usize],
        loads: MatRef<'_, f64>,
        momentum: MatRef<'_, f64>,
    ) -> Self {
        Self {
            eigenvalues: eigenvalues.to_vec(),
            n_complete,
            attached: attached.to_vec(),
            work: product(shapes.transpose(), loads),
            momentum: product(shapes.transpose(), momentum),
        }
    }

    /// The first `n_modes` modes and the responses, as their Rayleigh-Ritz modes.
    ///
    /// These are mass-normalised and uncoupled like the modes; the last of them, as many as there are loads, are the
    /// flexibility at the loads that the modes leave out (residual attachment modes).
    pub(crate) fn retained(&self, n_modes: usize) -> Result<Retained, Error> {
        let (n_found, n_loads) = (self.eigenvalues.len(), self.attached.len());
        // Where no mode is left out, the flexibility at the loads is complete without them.
        let is_complete = n_modes == self.n_complete;
        if n_loads == 0 || is_complete {
            return Ok(Retained {
                eigenvalues: self.eigenvalues[..n_modes].to_vec(),
                turn: Mat::from_fn(n_found + n_loads, n_modes, |i, j| f64::from(u8::from(i == j))),
                n_attachment: n_loads.min(n_modes),
            });
        }
        let n = n_modes + n_loads;
        let gram = |modal: &dyn Fn(usize) -> f64, of_responses: &Mat<f64>| {
            let response = |i: usize, j: usize| of_responses[(n_found + i, j)];
            Mat::from_fn(n, n, |i, j| match (i.min(j), i.max(j)) {
                (low, high) if high < n_modes => modal(low) * f64::from(u8::from(low == high)),
                (low, high) if low < n_modes => of_responses[(low, high - n_modes)],
                (low, high) => {
                    0.5 * (response(low - n_modes, high - n_modes) + response(high - n_modes, low - n_modes))
                }
            })
        };
        let stiffness = gram(&|i| self.eigenvalues[i], &self.work);
        let mass = gram(&|_| 1.0, &self.momentum);
        if let Some(load) = dependent(&stiffness, n_modes)? {
            let load = self.attached[load];
            return Err(Error::DependentLoad { load });
        }
        // The stiffness is the metric: flexibility at a load stores energy but may move hardly any mass.
        let (inverse, vectors) = dense_algebra::symmetric_pair(mass.as_ref(), stiffness.as_ref())?;
        let mut turn = Mat::zeros(n_found + n_loads, n);
        for (i, place) in (0..n_modes).chain(n_found..n_found + n_loads).enumerate() {
            for j in 0..n {
                turn[(place, j)] = vectors[(i, n - 1 - j)] / inverse[n - 1 - j].sqrt();
            }
        }
        Ok(Retained {
            eigenvalues: inverse.iter().rev().map(|v| 1.0 / v).collect(),
            turn,
            n_attachment: n_loads,
        })
    }
}

/// The first response that depends on what comes before it.
fn dependent(stiffness: &Mat<f64>, n_modes: usize) -> Result<Option<usize>, Error> {
    let n = stiffness.nrows();
    let scale: Vec<f64> = (0..n).map(|i| stiffness[(i, i)].sqrt().recip()).collect();
    let unit = Mat::from_fn(n, n, |i, j| stiffness[(i, j)] * scale[i] * scale[j]);
    let dependent = match dense_algebra::cholesky(unit.as_ref()) {
        // `!(a > b)` also catches NaN.
        Ok(lower) => (n_modes..n).find(|&i| !(lower[(i, i)].powi(2) > LEAST_FLEXIBILITY)),
        Err(dense_algebra::Error::NotPositiveDefinite { pivot, .. }) => Some(pivot.max(n_modes)),
        Err(error) => return Err(error.into()),
    };
    Ok(dependent.map(|i| i - n_modes))
}
