//! The basis of the coordinates beside the jump: modes of the stuck structure, and its responses to the loads.

use crate::Error;
use dense_algebra::product;
use faer::{Mat, MatRef};
use finite_elements::eigen::Modes;

/// Least flexibility of a load, relative to its whole one, that the other coordinates must leave to its own.
const LEAST_FLEXIBILITY: f64 = 1e-8;

/// The basis of the interior and its `omega^2` (rad^2/s^2).
pub(crate) struct Interior {
    pub(crate) shapes: Mat<f64>,
    pub(crate) eigenvalues: Vec<f64>,
}

impl Interior {
    /// The `n_modes` lowest modes of the stuck structure.
    pub(crate) fn modes(stuck: &Modes, n_modes: usize) -> Self {
        Self {
            shapes: stuck.elastic().subcols(0, n_modes).to_owned(),
            eigenvalues: stuck.eigenvalues[stuck.n_zero..][..n_modes].to_vec(),
        }
    }

    /// Adds the static responses `attached` to `loads`, with their `momentum` (mass times response), and finds the
    /// Rayleigh-Ritz modes of them all.
    ///
    /// These are mass-normalised and uncoupled like the modes; the last of them, as many as there are loads, are the
    /// flexibility at the loads that the modes leave out (residual attachment modes).
    pub(crate) fn attach(
        &mut self,
        attached: MatRef<'_, f64>,
        momentum: MatRef<'_, f64>,
        loads: MatRef<'_, f64>,
    ) -> Result<(), Error> {
        let n_modes = self.shapes.ncols();
        let n = n_modes + loads.ncols();
        let phi = self.shapes.transpose();
        let (modal_load, modal_momentum) = (product(phi, loads), product(phi, momentum));
        let (flexibility, inertia) = (
            product(attached.transpose(), loads),
            product(attached.transpose(), momentum),
        );
        let gram = |modal: &dyn Fn(usize) -> f64, coupling: &Mat<f64>, own: &Mat<f64>| {
            Mat::from_fn(n, n, |i, j| match (i.min(j), i.max(j)) {
                (low, high) if high < n_modes => modal(low) * f64::from(u8::from(low == high)),
                (low, high) if low < n_modes => coupling[(low, high - n_modes)],
                (low, high) => 0.5 * (own[(low - n_modes, high - n_modes)] + own[(high - n_modes, low - n_modes)]),
            })
        };
        let stiffness = gram(&|i| self.eigenvalues[i], &modal_load, &flexibility);
        let mass = gram(&|_| 1.0, &modal_momentum, &inertia);
        check_independence(&stiffness, n_modes)?;
        // The stiffness is the metric: flexibility at a load stores energy but may move hardly any mass.
        let (inverse, vectors) = dense_algebra::symmetric_pair(mass.as_ref(), stiffness.as_ref())?;
        let rotation = Mat::from_fn(n, n, |i, j| vectors[(i, n - 1 - j)] / inverse[n - 1 - j].sqrt());
        self.eigenvalues = inverse.iter().rev().map(|v| 1.0 / v).collect();
        let mut shapes = product(self.shapes.as_ref(), rotation.subrows(0, n_modes));
        shapes += product(attached, rotation.subrows(n_modes, loads.ncols()));
        self.shapes = shapes;
        Ok(())
    }
}

fn check_independence(stiffness: &Mat<f64>, n_modes: usize) -> Result<(), Error> {
    let n = stiffness.nrows();
    let scale: Vec<f64> = (0..n).map(|i| stiffness[(i, i)].sqrt().recip()).collect();
    let unit = Mat::from_fn(n, n, |i, j| stiffness[(i, j)] * scale[i] * scale[j]);
    let dependent = match dense_algebra::cholesky(unit.as_ref()) {
        // `!(a > b)` also catches NaN.
        Ok(lower) => (n_modes..n).find(|&i| !(lower[(i, i)].powi(2) > LEAST_FLEXIBILITY)),
        Err(dense_algebra::Error::NotPositiveDefinite { pivot, .. }) => Some(pivot.max(n_modes)),
        Err(error) => return Err(error.into()),
    };
    dependent.map_or(Ok(()), |i| Err(Error::DependentLoad { load: i - n_modes }))
}
