//! A joint with few coordinates and few points, in one static state.

use crate::error::Error;
use crate::force::PointForce;
use crate::training::{Trained, shape_of};
use cqsma_solver::Linearisation;
use dense_algebra::product;
use faer::Mat;
use zte_assembly::{Interface, State};

/// A joint about a static state whose motions are those of one mode and of what was learned beside it.
///
/// The static state, the structure with everything stuck and the mode are those of the whole joint, so that frequency and shape at small
/// amplitudes are exact.
pub struct HyperReducedJoint<'a> {
    interface: &'a Interface,
    whole: &'a Linearisation<'a, State>,
    /// Motions of the coordinates, the mode first.
    pub(crate) basis: Mat<f64>,
    /// Elastic forces of these motions.
    elastic: Mat<f64>,
    pub(crate) stiffness: Mat<f64>,
    pub(crate) mass: Mat<f64>,
    pub(crate) force: PointForce<'a>,
    /// Mass times the mass-normalised shape of the mode, and its frequency (rad/s).
    inertia: Vec<f64>,
    pub(crate) omega: f64,
    pub(crate) mode: usize,
}

impl<'a> HyperReducedJoint<'a> {
    /// About the static state of `whole`, for its mode number `mode`, zero-based.
    ///
    /// # Errors
    /// [`Error::Size`] if it was trained on another structure, or the structure lacks the mode.
    pub fn try_new(
        interface: &'a Interface,
        whole: &'a Linearisation<'a, State>,
        mode: usize,
        trained: &Trained,
    ) -> Result<Self, Error> {
        let (n, of_points) = (whole.stiffness().size(), interface.operators().n_points());
        let sizes = [
            ("the motion of a trained coordinate", trained.basis.nrows(), n),
            ("the interface that was trained on", trained.of_points, of_points),
        ];
        if let Some((what, found, expected)) = sizes.into_iter().find(|(_, found, expected)| found != expected) {
            return Err(Error::Size { what, found, expected });
        }
        let (shape, inertia, omega) = shape_of(whole, mode)?;
        let basis = Mat::from_fn(n, trained.basis.ncols() + 1, |i, k| match k {
            // Of unit energy, as the others are.
            0 => shape[i] / omega,
            k => trained.basis[(i, k - 1)],
        });
        let elastic = whole.stiffness().product(basis.as_ref());
        let jump = &whole.displacement()[..interface.n_dofs()];
        let stuck = whole.stuck_tangent();
        Ok(Self {
            stiffness: product(basis.transpose(), elastic.as_ref()),
            mass: product(basis.transpose(), whole.mass().product(basis.as_ref()).as_ref()),
            force: PointForce::new(interface, &trained.points, basis.as_ref(), jump, whole.state(), stuck),
            interface,
            whole,
            basis,
            elastic,
            inertia,
            omega,
            mode,
        })
    }

    pub(crate) fn interface(&self) -> &'a Interface {
        self.interface
    }

    pub(crate) fn whole(&self) -> &'a Linearisation<'a, State> {
        self.whole
    }

    /// Displacement of the whole joint from the static state (m).
    pub(crate) fn motion(&self, coordinates: &[f64]) -> Vec<f64> {
        combined(&self.basis, coordinates)
    }

    /// Nodal jumps (m) where the whole joint is displaced from the static state.
    pub(crate) fn jump(&self, increment: &[f64]) -> Vec<f64> {
        let at_rest = &self.whole.displacement()[..self.interface.n_dofs()];
        at_rest.iter().zip(increment).map(|(u, v)| u + v).collect()
    }

    /// Modal amplitude of a motion (sqrt(kg) m).
    pub(crate) fn amplitude(&self, motion: &[f64]) -> f64 {
        self.inertia.iter().zip(motion).map(|(a, b)| a * b).sum()
    }

    /// Energy of the stuck structure under a modal force, twice (J).
    pub(crate) fn energy_of_load(&self, modal_force: f64) -> f64 {
        (modal_force / self.omega).powi(2)
    }

    /// What is missing in the balance of the whole joint (N), where its contact has the force `contact` (N).
    pub(crate) fn residual(&self, coordinates: &[f64], contact: &[f64], modal_force: f64) -> Vec<f64> {
        let mut residual = combined(&self.elastic, coordinates);
        let changes = contact.iter().zip(self.whole.contact_force()).map(|(f, f0)| f - f0);
        residual.iter_mut().zip(changes).for_each(|(r, change)| *r += change);
        let loads = self.inertia.iter().map(|inertia| modal_force * inertia);
        residual.iter_mut().zip(loads).for_each(|(r, load)| *r -= load);
        residual
    }
}

/// Sum of columns times factors.
fn combined(columns: &Mat<f64>, factors: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; columns.nrows()];
    for (column, factor) in columns.col_iter().zip(factors) {
        sum.iter_mut()
            .zip(column.iter())
            .for_each(|(sum, value)| *sum += factor * value);
    }
    sum
}
