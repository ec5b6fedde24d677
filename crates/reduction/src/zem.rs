//! Static solves in a structure that can move as a rigid body.

use crate::Error;
use crate::relative::RelativeSystem;
use dense_algebra::Limits;
use faer::linalg::matmul::matmul;
use faer::reborrow::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use finite_elements::factor::{Condensed, SparseCholesky};
use finite_elements::groups::Groups;

/// What messages call the matrix that is factored.
const NAME: &str = "stuck stiffness without its zero-energy modes";

/// A semi-definite stiffness held at as many components as it has zero-energy modes.
///
/// For loads in equilibrium the reactions vanish, so the solution is exact up to a zero-energy motion, which
/// [`Supported::remove_zero_energy`] takes out in the mass inner product (eq. 31).
pub(crate) struct Supported {
    factor: SparseCholesky,
    held: Vec<usize>,
    /// Mass-orthonormal zero-energy modes, `n x n_zero`.
    pub(crate) modes: Mat<f64>,
    /// `M` times the modes.
    pub(crate) mass_modes: Mat<f64>,
}

impl Supported {
    /// Supports the rest of a system with the given zero-energy modes.
    pub(crate) fn try_new(system: &RelativeSystem, modes: MatRef<'_, f64>, limits: Limits<'_>) -> Result<Self, Error> {
        let held = components_to_hold(modes);
        let stiffness = system.rest(&system.stiffness);
        let positions = &system.positions[system.n_relative..];
        let factor = SparseCholesky::holding(&stiffness, positions, &held, NAME, limits)?;
        Ok(Self::new(system, factor, held, modes))
    }

    /// As [`Self::try_new`], and condenses the rest onto the jump: a rest that is held follows the jump up to a zero-energy motion.
    pub(crate) fn condense(
        system: &RelativeSystem,
        modes: MatRef<'_, f64>,
        kept: &Groups,
        limits: Limits<'_>,
    ) -> Result<(Self, Condensed), Error> {
        let nd = system.n_relative;
        let held = components_to_hold(modes);
        let fixed: Vec<usize> = held.iter().map(|component| nd + component).collect();
        let (factor, condensed) = SparseCholesky::condense(
            &system.stiffness,
            &system.mass,
            &system.positions,
            kept,
            &fixed,
            NAME,
            limits,
        )?;
        Ok((Self::new(system, factor, held, modes), condensed))
    }

    fn new(system: &RelativeSystem, factor: SparseCholesky, held: Vec<usize>, modes: MatRef<'_, f64>) -> Self {
        let [_, mass_modes] = system.momentum(None, modes);
        Self {
            factor,
            held,
            modes: modes.to_owned(),
            mass_modes,
        }
    }

    /// One particular solution of `K x = b` for columns in equilibrium, in place.
    pub(crate) fn solve_in_place(&self, mut rhs: MatMut<'_, f64>) {
        for &component in &self.held {
            rhs.rb_mut().row_mut(component).fill(0.0);
        }
        self.factor.solve_in_place(rhs);
    }

    /// As [`Self::solve_in_place`], of any columns: what of them is not in equilibrium is taken out first, as inertia forces of zero-energy motions.
    pub(crate) fn respond(&self, mut rhs: MatMut<'_, f64>) {
        self.remove_zero_energy(rhs.rb_mut());
        self.solve_in_place(rhs);
    }

    /// Coefficients `a = -Z^T m` that make `m + M Z a` orthogonal to the zero-energy modes, and that correction of `m`.
    pub(crate) fn remove_zero_energy(&self, mut momentum: MatMut<'_, f64>) -> Mat<f64> {
        let mut a = Mat::zeros(self.modes.ncols(), momentum.ncols());
        matmul(
            a.as_mut(),
            Accum::Replace,
            self.modes.transpose(),
            momentum.as_ref(),
            -1.0,
            Par::Seq,
        );
        matmul(
            momentum.as_mut(),
            Accum::Add,
            self.mass_modes.as_ref(),
            a.as_ref(),
            1.0,
            Par::Seq,
        );
        a
    }
}

/// Greedy choice of well-separated components: the one that moves most in the modes not yet held.
fn components_to_hold(modes: MatRef<'_, f64>) -> Vec<usize> {
    let mut rows = modes.to_owned();
    let mut held = Vec::with_capacity(rows.ncols());
    for _ in 0..rows.ncols() {
        let squared = |i: usize| rows.row(i).iter().map(|v| v * v).sum::<f64>();
        let best = (0..rows.nrows())
            .max_by(|&a, &b| squared(a).total_cmp(&squared(b)))
            .unwrap_or(0);
        let direction: Vec<f64> = {
            let norm = squared(best).sqrt();
            rows.row(best).iter().map(|v| v / norm).collect()
        };
        for i in 0..rows.nrows() {
            let along: f64 = rows.row(i).iter().zip(&direction).map(|(a, b)| a * b).sum();
            for (j, d) in direction.iter().enumerate() {
                rows[(i, j)] -= along * d;
            }
        }
        held.push(best);
    }
    held
}
