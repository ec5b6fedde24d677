//! Dense symmetric factorisations and eigenpairs with results that depend neither on units nor on the number of threads.
//!
//! A thin layer over `faer` with two decisions made once for all crates above it. What is large is cut into tiles of fixed
//! size that the threads of the caller's pool share; each tile, and all else, runs on one thread. The library's own choice
//! follows a process-wide setting that a library must not touch, and would let results depend on the number of threads.
//! And eigenproblems are brought to unit size, because the library's divide-and-conquer step
//! deflates with an absolute tolerance (a matrix of size 1e12 lost four digits to it, one of size 1e-5 five).

mod bases;
mod blocks;
mod fingerprint;
mod krylov;
mod limits;
mod packed;
mod reflected;
mod residuals;
mod subspace;
mod system_matrix;
mod tiles;
mod tree;

pub use bases::leading_basis;
pub use blocks::BlockMatrix;
pub use fingerprint::arithmetic_fingerprint;
pub use krylov::Krylov;
pub use limits::Limits;
pub use packed::Symmetric;
pub use reflected::{ReflectedInverse, Reflection};
pub use residuals::{ConjugateResiduals, Inner, Vector};
pub use subspace::lowest_pairs;
pub use system_matrix::{Factor, Inverse, Packed, SystemMatrix, SystemMatrixRef};
pub use tree::{Node, Tree};

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{self as llt, LltError};
use faer::linalg::evd::{self, ComputeEigenvectors};
use faer::linalg::lu::partial_pivoting::{factor as lu, solve as lu_solve};
use faer::reborrow::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par, Spec};
use tiles::PANEL;

/// Why a dense operation failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A matrix that must be positive definite is not.
    #[error("the matrix is not positive definite: pivot {pivot} of {size}")]
    NotPositiveDefinite {
        /// Pivot at which the factorisation stopped.
        pivot: usize,
        /// Size of the matrix.
        size: usize,
    },
    /// A matrix that must be positive semi-definite is not.
    #[error(
        "the matrix is not positive semi-definite: coordinate {coordinate} of {size} has most of a negative eigenvector"
    )]
    NotSemidefinite {
        /// Coordinate with the largest part in the eigenvector of the lowest eigenvalue, counted from 0.
        coordinate: usize,
        /// Size of the matrix.
        size: usize,
    },
    /// More eigenpairs are asked for than there are.
    #[error(
        "{count} eigenpairs are asked for, but the semi-definite matrix of size {size} has fewer, or is not finite"
    )]
    Rank {
        /// Size of the matrix.
        size: usize,
        /// Eigenpairs asked for.
        count: usize,
    },
    /// The eigenvalue iteration did not converge.
    #[error("the eigenvalue decomposition of a matrix of size {size} did not converge")]
    NoConvergence {
        /// Size of the matrix.
        size: usize,
    },
}

/// Lower Cholesky factor `L` of `a = L L^T`; only the lower triangle of `a` is read.
///
/// # Errors
/// [`Error::NotPositiveDefinite`].
pub fn cholesky(a: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
    let size = a.nrows();
    let mut lower = Mat::zeros(size, size);
    for j in 0..size {
        for i in j..size {
            lower[(i, j)] = a[(i, j)];
        }
    }
    cholesky_in_place(lower)
}

/// The same in the memory of `a`, for matrices of which there is no room for two.
///
/// # Errors
/// [`Error::NotPositiveDefinite`].
pub fn cholesky_in_place(mut a: Mat<f64>) -> Result<Mat<f64>, Error> {
    let size = a.nrows();
    let width = if size < 2 * PANEL { size } else { PANEL };
    let mut memory = MemBuffer::new(llt::cholesky_in_place_scratch::<f64>(width, Par::Seq, Spec::default()));
    let stack = MemStack::new(&mut memory);
    for first in (0..size).step_by(width.max(1)) {
        let width = width.min(size - first);
        let rest = a.as_mut().submatrix_mut(first, first, size - first, size - first);
        let (mut own, _, mut below, beyond) = rest.split_at_mut(width, width);
        llt::cholesky_in_place(
            own.rb_mut(),
            llt::LltRegularization::default(),
            Par::Seq,
            stack,
            Spec::default(),
        )
        .map_err(|LltError::NonPositivePivot { index }| Error::NotPositiveDefinite {
            pivot: first + index,
            size,
        })?;
        tiles::solve(own.as_ref(), below.rb_mut().transpose_mut(), false);
        tiles::add_lower(beyond, below.as_ref(), below.as_ref().transpose(), -1.0);
    }
    // Above the diagonal stands what came with the matrix, or scratch of the blocked factorisation.
    for j in 0..size {
        a.col_mut(j).subrows_mut(0, j).fill(0.0);
    }
    Ok(a)
}

/// `x = L^-1 x` for all columns.
///
/// # Panics
/// If the shapes do not fit.
pub fn solve_lower(lower: MatRef<'_, f64>, x: MatMut<'_, f64>) {
    tiles::solve(lower, x, false);
}

/// `x = L^-T x` for all columns.
///
/// # Panics
/// If the shapes do not fit.
pub fn solve_lower_transposed(lower: MatRef<'_, f64>, x: MatMut<'_, f64>) {
    tiles::solve(lower, x, true);
}

/// `L^-1 a L^-T`, symmetrised: a symmetric `a` seen in the metric of `L L^T`.
///
/// # Panics
/// If the shapes do not fit.
pub fn congruent(lower: MatRef<'_, f64>, a: MatRef<'_, f64>) -> Mat<f64> {
    let mut half = a.to_owned();
    solve_lower(lower, half.as_mut());
    let mut whole = half.transpose().to_owned();
    solve_lower(lower, whole.as_mut());
    symmetric(whole.as_ref())
}

/// `(a + a^T) / 2`.
pub fn symmetric(a: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
}

/// The sum of the products of two lists, added up in their order.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a b`.
///
/// # Panics
/// If the shapes do not fit.
pub fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut c = Mat::zeros(a.nrows(), b.ncols());
    product_into(c.as_mut(), a, b);
    c
}

/// `c = a b`, into memory of the caller.
///
/// # Panics
/// If the shapes do not fit.
pub fn product_into(c: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    tiles::product(c, Accum::Replace, a, b, 1.0);
}

/// `c += factor a b`.
///
/// # Panics
/// If the shapes do not fit.
pub fn add_product(c: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>, factor: f64) {
    tiles::product(c, Accum::Add, a, b, factor);
}

/// The lower triangle of `c += factor a b`; what stands above stays.
///
/// # Panics
/// If the shapes do not fit, or `c` is not square.
pub fn add_product_lower(c: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>, factor: f64) {
    tiles::add_lower(c, a, b, factor);
}

/// `c += factor a L` of a lower triangle `L`, above which there are zeros.
///
/// # Panics
/// If the shapes do not fit.
pub fn add_product_with_lower(c: MatMut<'_, f64>, a: MatRef<'_, f64>, lower: MatRef<'_, f64>, factor: f64) {
    tiles::add_with_lower(c, a, lower, factor);
}

/// Copies the lower triangle to the upper one.
///
/// # Panics
/// If the matrix is not square.
pub fn mirror_lower(mut matrix: MatMut<'_, f64>) {
    // Squares that fit into the fastest memory.
    const SQUARE: usize = 32;
    let size = matrix.nrows();
    assert_eq!(matrix.ncols(), size);
    for first in (0..size).step_by(SQUARE) {
        for above in (0..=first).step_by(SQUARE) {
            for column in first..size.min(first + SQUARE) {
                for row in above..(above + SQUARE).min(column) {
                    matrix[(row, column)] = matrix[(column, row)];
                }
            }
        }
    }
}

/// Solves `a x = b` by LU with partial pivoting; `None` if the matrix is numerically singular. Overwrites `a`.
///
/// # Panics
/// If the shapes do not fit.
pub fn solve_general(a: Mat<f64>, b: &[f64]) -> Option<Vec<f64>> {
    solve_general_all(a, &[b]).and_then(|mut all| all.pop())
}

/// The same for several right-hand sides with one factorisation.
///
/// # Panics
/// If the shapes do not fit.
pub fn solve_general_all(mut a: Mat<f64>, b: &[&[f64]]) -> Option<Vec<Vec<f64>>> {
    let n = a.nrows();
    let (mut forward, mut backward) = (vec![0_usize; n], vec![0_usize; n]);
    let mut memory = MemBuffer::new(faer::dyn_stack::StackReq::any_of(&[
        lu::lu_in_place_scratch::<usize, f64>(n, n, Par::Seq, Spec::default()),
        lu_solve::solve_in_place_scratch::<usize, f64>(n, b.len(), Par::Seq),
    ]));
    let stack = MemStack::new(&mut memory);
    let (_, order) = lu::lu_in_place(
        a.as_mut(),
        &mut forward,
        &mut backward,
        Par::Seq,
        stack,
        Spec::default(),
    );
    let mut x = b.concat();
    let columns = MatMut::from_column_major_slice_mut(&mut x, n, b.len());
    lu_solve::solve_in_place(
        a.as_ref(),
        a.as_ref(),
        order,
        columns,
        Par::Seq,
        MemStack::new(&mut memory),
    );
    let all = x.chunks_exact(n.max(1)).map(<[f64]>::to_vec).collect();
    x.iter().all(|v| v.is_finite()).then_some(all)
}

/// Ascending eigenvalues and orthonormal eigenvectors of a symmetric matrix; only the lower triangle is read.
///
/// # Errors
/// [`Error::NoConvergence`].
pub fn symmetric_eigen(a: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let mut vectors = Mat::zeros(a.nrows(), a.nrows());
    let values = eigen(a, Some(vectors.as_mut()))?;
    Ok((values, vectors))
}

/// Ascending eigenvalues of a symmetric matrix; only the lower triangle is read.
///
/// # Errors
/// [`Error::NoConvergence`].
pub fn symmetric_eigenvalues(a: MatRef<'_, f64>) -> Result<Vec<f64>, Error> {
    eigen(a, None)
}

/// The orthogonal matrix nearest to `a`, `a (a^T a)^(-1/2)`. With `a = x^T y` it turns the columns of `x` onto those of `y` as well as a rotation
/// can. Of one number it is its sign.
///
/// # Errors
/// [`Error::NoConvergence`].
pub fn nearest_rotation(a: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
    let size = a.nrows();
    if size == 1 {
        return Ok(Mat::from_fn(1, 1, |_, _| 1.0_f64.copysign(a[(0, 0)])));
    }
    let (values, vectors) = symmetric_eigen(product(a.transpose(), a).as_ref())?;
    // a (a^T a)^(-1/2).
    let root = Mat::from_fn(size, size, |i, j| {
        let terms = (0..size).map(|k| vectors[(i, k)] * vectors[(j, k)] / values[k].max(f64::MIN_POSITIVE).sqrt());
        terms.sum::<f64>()
    });
    Ok(product(a, root.as_ref()))
}

/// Rank of a symmetric positive semi-definite matrix: how many of its eigenvalues are above round-off once its diagonal is one.
/// Only the lower triangle is read.
///
/// # Errors
/// [`Error::NoConvergence`].
pub fn rank(a: MatRef<'_, f64>) -> Result<usize, Error> {
    let (unit, _) = with_unit_diagonal(a);
    let values = symmetric_eigenvalues(unit.as_ref())?;
    let round_off = unit_round_off(values.len());
    Ok(values.iter().filter(|value| **value > round_off).count())
}

/// `F` with as many columns as the rank of a positive semi-definite `a = F F^T`; only the lower triangle of `a` is read. Units of the coordinates
/// do not matter. Eigenvalues of the matrix scaled to a unit diagonal that are negative by less than `tolerance` count as zero.
///
/// # Errors
/// [`Error::NotSemidefinite`], [`Error::NoConvergence`].
pub fn semidefinite_factor(a: MatRef<'_, f64>, tolerance: f64) -> Result<Mat<f64>, Error> {
    let size = a.nrows();
    let (unit, scaled) = with_unit_diagonal(a);
    // What has no diagonal has nothing beside it.
    let has_diagonal = |i: usize| scaled.binary_search_by_key(&i, |(row, _)| *row).is_ok();
    for j in (0..size).filter(|j| !has_diagonal(*j)) {
        let column = (0..size).map(|i| a[(i.max(j), i.min(j))]);
        if column.into_iter().any(|value| value != 0.0) {
            return Err(Error::NotSemidefinite { coordinate: j, size });
        }
    }
    let (values, vectors) = symmetric_eigen(unit.as_ref())?;
    if let Some(lowest) = values.first().filter(|value| **value < -tolerance || value.is_nan()) {
        let column = (0..scaled.len()).map(|i| if lowest.is_nan() { 0.0 } else { vectors[(i, 0)].abs() });
        let most = column.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        let coordinate = most.map_or(0, |(i, _)| scaled[i].0);
        return Err(Error::NotSemidefinite { coordinate, size });
    }
    let round_off = unit_round_off(values.len());
    let kept: Vec<usize> = (0..values.len()).filter(|k| values[*k] > round_off).collect();
    let mut factor = Mat::zeros(size, kept.len());
    for (column, &k) in kept.iter().enumerate() {
        for (i, &(row, scale)) in scaled.iter().enumerate() {
            factor[(row, column)] = vectors[(i, k)] * values[k].sqrt() / scale;
        }
    }
    Ok(factor)
}

/// A symmetric matrix scaled to a unit diagonal, without the rows whose diagonal is not positive, and the rows that are left with their factors.
fn with_unit_diagonal(a: MatRef<'_, f64>) -> (Mat<f64>, Vec<(usize, f64)>) {
    let scaled: Vec<(usize, f64)> = (0..a.nrows())
        .map(|i| (i, a[(i, i)].sqrt().recip()))
        .filter(|(_, scale)| scale.is_finite())
        .collect();
    let n = scaled.len();
    let unit = Mat::from_fn(n, n, |i, j| {
        let ((i, of_row), (j, of_column)) = (scaled[i], scaled[j]);
        a[(i.max(j), i.min(j))] * of_row * of_column
    });
    (unit, scaled)
}

/// Eigenvalues of a matrix of unit diagonal that say nothing.
fn unit_round_off(size: usize) -> f64 {
    16.0 * f64::EPSILON * size as f64
}

fn eigen(a: MatRef<'_, f64>, vectors: Option<MatMut<'_, f64>>) -> Result<Vec<f64>, Error> {
    let size = a.nrows();
    let largest = a.norm_max();
    let scale = if largest > 0.0 { largest } else { 1.0 };
    let unit = Mat::from_fn(size, size, |i, j| a[(i, j)] / scale);
    let mut values = Diag::<f64>::zeros(size);
    let wanted = if vectors.is_some() {
        ComputeEigenvectors::Yes
    } else {
        ComputeEigenvectors::No
    };
    let mut memory = MemBuffer::new(evd::self_adjoint_evd_scratch::<f64>(
        size,
        wanted,
        Par::Seq,
        Spec::default(),
    ));
    let stack = MemStack::new(&mut memory);
    evd::self_adjoint_evd(
        unit.as_ref(),
        values.as_mut(),
        vectors,
        Par::Seq,
        stack,
        Spec::default(),
    )
    .map_err(|_| Error::NoConvergence { size })?;
    Ok(values.column_vector().iter().map(|v| v * scale).collect())
}

/// Eigenpairs of `k y = lambda g y` for symmetric `k` and positive definite `g`, ascending, with `y^T g y = 1`.
///
/// # Errors
/// [`Error::NotPositiveDefinite`] for `g`, [`Error::NoConvergence`].
pub fn symmetric_pair(k: MatRef<'_, f64>, g: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let size = k.nrows();
    // Coordinates of very different size would spoil the factor.
    let scale: Vec<f64> = (0..size).map(|i| g[(i, i)].sqrt().recip()).collect();
    let scaled = |a: MatRef<'_, f64>| Mat::from_fn(size, size, |i, j| a[(i, j)] * scale[i] * scale[j]);
    let lower = cholesky(scaled(g).as_ref())?;
    let (values, mut vectors) = symmetric_eigen(congruent(lower.as_ref(), scaled(k).as_ref()).as_ref())?;
    solve_lower_transposed(lower.as_ref(), vectors.as_mut());
    Ok((values, Mat::from_fn(size, size, |i, j| vectors[(i, j)] * scale[i])))
}

/// A reproducible matrix of scattered numbers in [-1/2, 1/2): a start for iterations that must not be orthogonal to
/// anything (64-bit linear congruential generator).
pub fn scattered(rows: usize, columns: usize) -> Mat<f64> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    Mat::from_fn(rows, columns, |_, _| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    })
}
