//! Linear solves with the tangent: directly, or by GMRES preconditioned with the factor of the stuck tangent.

use crate::Error;
use crate::force::Pattern;
use faer::linalg::matmul::matmul;
use faer::{Accum, ColMut, Mat, MatMut, MatRef, Par};

/// Most GMRES steps before the direct solve takes over; its cost is that of about this many steps.
const MAX_KRYLOV: usize = 60;

/// `y = a x`.
pub(crate) fn multiply(a: MatRef<'_, f64>, x: &[f64], y: &mut [f64]) {
    let x = MatRef::from_column_major_slice(x, x.len(), 1);
    let rows = y.len();
    matmul(
        MatMut::from_column_major_slice_mut(y, rows, 1),
        Accum::Replace,
        a,
        x,
        1.0,
        Par::Seq,
    );
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Stiffness plus a sparse tangent on its leading block.
pub(crate) fn with_tangent(stiffness: MatRef<'_, f64>, pattern: &Pattern, values: &[f64]) -> Mat<f64> {
    let mut sum = stiffness.to_owned();
    for row in 0..pattern.indptr.len() - 1 {
        for k in pattern.indptr[row]..pattern.indptr[row + 1] {
            sum[(row, pattern.indices[k])] += values[k];
        }
    }
    sum
}

/// Cholesky factor of the structure with everything in contact stuck: preconditioner and energy norm.
#[derive(Clone, Debug)]
pub(crate) struct StuckFactor {
    lower: Mat<f64>,
    /// Tangent values that went into it (symmetrised).
    tangent: Vec<f64>,
}

impl StuckFactor {
    /// Factors `stiffness + (tangent + tangent^T) / 2`.
    pub(crate) fn try_new(stiffness: MatRef<'_, f64>, pattern: &Pattern, tangent: &[f64]) -> Result<Self, Error> {
        let tangent = symmetrised(pattern, tangent);
        let lower = dense_algebra::cholesky(with_tangent(stiffness, pattern, &tangent).as_ref())?;
        Ok(Self { lower, tangent })
    }

    pub(crate) fn lower(&self) -> MatRef<'_, f64> {
        self.lower.as_ref()
    }

    /// `x = L^-1 x`.
    pub(crate) fn forward(&self, x: &mut [f64]) {
        dense_algebra::solve_lower(self.lower(), ColMut::from_slice_mut(x).as_mat_mut());
    }

    /// `x = L^-T x`.
    pub(crate) fn backward(&self, x: &mut [f64]) {
        dense_algebra::solve_lower_transposed(self.lower(), ColMut::from_slice_mut(x).as_mat_mut());
    }

    /// Energy norm `sqrt(r^T P^-1 r)` of a force; leaves `L^-1 r` in the buffer.
    pub(crate) fn energy_norm(&self, r: &[f64], buffer: &mut Vec<f64>) -> f64 {
        buffer.clear();
        buffer.extend_from_slice(r);
        self.forward(buffer);
        norm(buffer)
    }
}

fn symmetrised(pattern: &Pattern, values: &[f64]) -> Vec<f64> {
    let mut out = values.to_vec();
    for row in 0..pattern.indptr.len() - 1 {
        for k in pattern.indptr[row]..pattern.indptr[row + 1] {
            let column = pattern.indices[k];
            let range = pattern.indptr[column]..pattern.indptr[column + 1];
            // An entry without a mirror image is halved, as its mirror is zero.
            let mirror = pattern.indices[range.clone()]
                .binary_search(&row)
                .map_or(0.0, |at| values[range.start + at]);
            out[k] = 0.5 * (values[k] + mirror);
        }
    }
    out
}

/// Solves `(stiffness + tangent) x = b` by LU; `None` if the matrix is numerically singular.
pub(crate) fn solve_direct(
    stiffness: MatRef<'_, f64>,
    pattern: &Pattern,
    tangent: &[f64],
    b: &[f64],
) -> Option<Vec<f64>> {
    dense_algebra::solve_general(with_tangent(stiffness, pattern, tangent), b)
}

/// Solves `(stiffness + tangent) x = b` by GMRES on `L^-1 (P + dT) L^-T = I + L^-1 dT L^-T`, where `dT` is the
/// difference between the tangent and the stuck one: only triangular solves and a sparse product per step.
///
/// `scaled` is `L^-1 b`. Returns the solution and the number of steps, or `None` if `tolerance` (relative, energy norm)
/// is not reached.
pub(crate) fn solve_krylov(
    factor: &StuckFactor,
    pattern: &Pattern,
    tangent: &[f64],
    scaled: &[f64],
    tolerance: f64,
) -> Option<(Vec<f64>, usize)> {
    let n = scaled.len();
    let difference: Vec<f64> = tangent.iter().zip(&factor.tangent).map(|(a, b)| a - b).collect();
    let beta = norm(scaled);
    if beta == 0.0 {
        return Some((vec![0.0; n], 0));
    }
    let mut basis: Vec<Vec<f64>> = vec![scaled.iter().map(|v| v / beta).collect()];
    // Rows of the Hessenberg matrix made triangular by Givens rotations, and the rotated right-hand side.
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut rotations: Vec<(f64, f64)> = Vec::new();
    let mut rhs = vec![beta];
    for step in 0..MAX_KRYLOV.min(n) {
        let mut direction = basis[step].clone();
        factor.backward(&mut direction);
        let mut w = vec![0.0; n];
        pattern.add_product(&difference, &direction, &mut w);
        factor.forward(&mut w);
        w.iter_mut().zip(&basis[step]).for_each(|(w, v)| *w += v);
        let mut h = Vec::with_capacity(step + 2);
        for v in &basis {
            let c = dot(&w, v);
            w.iter_mut().zip(v).for_each(|(w, v)| *w -= c * v);
            h.push(c);
        }
        let length = norm(&w);
        for (i, &(c, s)) in rotations.iter().enumerate() {
            (h[i], h[i + 1]) = (c * h[i] + s * h[i + 1], c * h[i + 1] - s * h[i]);
        }
        let radius = h[step].hypot(length);
        if !(radius > 0.0 && radius.is_finite()) {
            return None;
        }
        let (c, s) = (h[step] / radius, length / radius);
        h[step] = radius;
        rotations.push((c, s));
        columns.push(h);
        let last = rhs[step];
        rhs[step] = c * last;
        rhs.push(-s * last);
        if rhs[step + 1].abs() <= tolerance * beta || length <= f64::EPSILON * radius {
            let m = step + 1;
            let mut y = vec![0.0; m];
            for i in (0..m).rev() {
                let known: f64 = (i + 1..m).map(|j| columns[j][i] * y[j]).sum();
                y[i] = (rhs[i] - known) / columns[i][i];
            }
            let mut x = vec![0.0; n];
            for (v, c) in basis.iter().zip(&y) {
                x.iter_mut().zip(v).for_each(|(x, v)| *x += c * v);
            }
            factor.backward(&mut x);
            return Some((x, m));
        }
        w.iter_mut().for_each(|w| *w /= length);
        basis.push(w);
    }
    None
}
