//! Stiffness or mass of a reduced structure: dense, or blocks with a coupling of low rank.

use crate::blocks::{BlockInverse, BlockMatrix};
use crate::{Error, Symmetric, cholesky_in_place, lowest_pairs, product, symmetric, symmetric_pair};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Most subspace iterations for modes of a [`BlockMatrix`]; a dozen are usual.
const MAX_ITERATIONS: usize = 200;

/// Relative change of the eigenvalues from one iteration to the next at which they count as found, and at which they do where it does not fall any more.
const SETTLED: f64 = 1e-13;
const PLATEAU: f64 = 1e-9;

/// Iterations without a smaller change that make a plateau.
const WAITING: usize = 5;

/// A symmetric matrix.
#[derive(Clone, Debug, PartialEq)]
pub enum SystemMatrix {
    /// All entries.
    Dense(Mat<f64>),
    /// Blocks with a coupling of low rank.
    Blocks(BlockMatrix),
}

/// A look at one.
#[derive(Clone, Copy, Debug)]
pub enum SystemMatrixRef<'a> {
    /// All entries.
    Dense(MatRef<'a, f64>),
    /// Blocks with a coupling of low rank.
    Blocks(&'a BlockMatrix),
}

impl From<Mat<f64>> for SystemMatrix {
    fn from(matrix: Mat<f64>) -> Self {
        Self::Dense(matrix)
    }
}

impl<'a> From<MatRef<'a, f64>> for SystemMatrixRef<'a> {
    fn from(matrix: MatRef<'a, f64>) -> Self {
        Self::Dense(matrix)
    }
}

impl<'a> From<&'a SystemMatrix> for SystemMatrixRef<'a> {
    fn from(matrix: &'a SystemMatrix) -> Self {
        matrix.as_ref()
    }
}

impl SystemMatrix {
    /// A look at it.
    pub fn as_ref(&self) -> SystemMatrixRef<'_> {
        match self {
            Self::Dense(matrix) => SystemMatrixRef::Dense(matrix.as_ref()),
            Self::Blocks(matrix) => SystemMatrixRef::Blocks(matrix),
        }
    }

    /// The factor of the matrix plus a symmetric one with these entries, `(row, column, value)`, which do not couple blocks.
    ///
    /// # Errors
    /// [`Error::NotPositiveDefinite`]; [`Error::NoConvergence`] where the coupling of blocks is singular.
    ///
    /// # Panics
    /// If an entry couples two blocks.
    pub fn factor_plus(self, entries: impl Iterator<Item = (usize, usize, f64)>) -> Result<Factor, Error> {
        match self {
            Self::Dense(mut sum) => {
                entries.for_each(|(row, column, value)| sum[(row, column)] += value);
                Ok(Factor::Whole(cholesky_in_place(sum)?))
            }
            Self::Blocks(matrix) => Ok(Factor::Blocks(matrix.inverse_plus(entries)?)),
        }
    }

    /// The matrix and `weight u u^T` for each of the vectors `u` given.
    ///
    /// # Panics
    /// If the lengths do not fit.
    #[must_use]
    pub fn plus_outer(self, given: &[(f64, &[f64])]) -> Self {
        match self {
            Self::Dense(mut matrix) => {
                for &(weight, u) in given {
                    for (column, factor) in matrix.col_iter_mut().zip(u) {
                        let share = weight * factor;
                        column.iter_mut().zip(u).for_each(|(a, u)| *a += share * u);
                    }
                }
                Self::Dense(matrix)
            }
            Self::Blocks(matrix) => Self::Blocks(matrix.plus_outer(given)),
        }
    }

    /// All entries.
    pub fn into_dense(self) -> Mat<f64> {
        match self {
            Self::Dense(matrix) => matrix,
            Self::Blocks(matrix) => matrix.to_dense(),
        }
    }

    /// A factor times the matrix.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Dense(matrix) => Self::Dense(matrix * faer::Scale(factor)),
            Self::Blocks(matrix) => Self::Blocks(matrix.scaled(factor)),
        }
    }
}

impl<'a> SystemMatrixRef<'a> {
    /// This matrix and a factor times another one of the same form.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn plus(self, factor: f64, other: SystemMatrixRef<'_>) -> SystemMatrix {
        match (self, other) {
            (Self::Blocks(own), SystemMatrixRef::Blocks(other)) => SystemMatrix::Blocks(own.plus(factor, other)),
            _ => {
                let (own, other) = (self.to_dense(), other.to_dense());
                SystemMatrix::Dense(Mat::from_fn(own.nrows(), own.ncols(), |i, j| {
                    own[(i, j)] + factor * other[(i, j)]
                }))
            }
        }
    }

    /// Rows and columns.
    pub fn size(self) -> usize {
        match self {
            Self::Dense(matrix) => matrix.nrows(),
            Self::Blocks(matrix) => matrix.size(),
        }
    }

    /// A copy.
    pub fn to_owned(self) -> SystemMatrix {
        match self {
            Self::Dense(matrix) => SystemMatrix::Dense(matrix.to_owned()),
            Self::Blocks(matrix) => SystemMatrix::Blocks(matrix.clone()),
        }
    }

    /// All entries, if they are stored.
    pub fn dense(self) -> Option<MatRef<'a, f64>> {
        match self {
            Self::Dense(matrix) => Some(matrix),
            Self::Blocks(_) => None,
        }
    }

    /// A copy of all entries.
    pub fn to_dense(self) -> Mat<f64> {
        match self {
            Self::Dense(matrix) => matrix.to_owned(),
            Self::Blocks(matrix) => matrix.to_dense(),
        }
    }

    /// For many products with vectors.
    pub fn packed(self) -> Packed<'a> {
        match self {
            Self::Dense(matrix) => Packed::Whole(Symmetric::from_lower(matrix)),
            Self::Blocks(matrix) => Packed::Blocks(matrix),
        }
    }

    /// The diagonal.
    pub fn diagonal(self) -> Vec<f64> {
        match self {
            Self::Dense(matrix) => (0..matrix.nrows()).map(|i| matrix[(i, i)]).collect(),
            Self::Blocks(matrix) => matrix.diagonal(),
        }
    }

    /// `y = a x`.
    ///
    /// # Panics
    /// If the lengths do not fit.
    pub fn multiply(self, x: &[f64], y: &mut [f64]) {
        let x = MatRef::from_column_major_slice(x, x.len(), 1);
        match self {
            Self::Dense(matrix) => {
                let rows = y.len();
                let y = MatMut::from_column_major_slice_mut(y, rows, 1);
                matmul(y, Accum::Replace, matrix, x, 1.0, Par::Seq);
            }
            Self::Blocks(matrix) => {
                let found = matrix.product(x);
                y.iter_mut().zip(found.col_as_slice(0)).for_each(|(y, f)| *y = *f);
            }
        }
    }

    /// `a x` for all columns.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn product(self, x: MatRef<'_, f64>) -> Mat<f64> {
        match self {
            Self::Dense(matrix) => product(matrix, x),
            Self::Blocks(matrix) => matrix.product(x),
        }
    }
}

/// A [`SystemMatrix`] for many products with vectors: entries are stored once.
#[derive(Clone, Debug)]
pub enum Packed<'a> {
    /// All entries.
    Whole(Symmetric),
    /// Blocks with a coupling of low rank, as they are.
    Blocks(&'a BlockMatrix),
}

impl Packed<'_> {
    /// `y = a x`.
    ///
    /// # Panics
    /// If the lengths do not fit.
    pub fn product_into(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Whole(matrix) => matrix.product_into(x, y),
            Self::Blocks(matrix) => SystemMatrixRef::Blocks(matrix).multiply(x, y),
        }
    }
}

/// A positive definite [`SystemMatrix`] that can be solved with.
#[derive(Clone, Debug)]
pub enum Factor {
    /// The lower Cholesky factor.
    Whole(Mat<f64>),
    /// The inverse of blocks.
    Blocks(BlockInverse),
}

/// The inverse of a positive definite [`SystemMatrix`], for products.
#[derive(Clone, Debug, PartialEq)]
pub enum Inverse {
    /// Of all entries.
    Whole(Symmetric),
    /// Of blocks.
    Blocks(BlockInverse),
}

impl Factor {
    /// The inverse.
    pub fn into_inverse(self) -> Inverse {
        match self {
            Self::Whole(lower) => Inverse::Whole(Symmetric::inverse_of_factor(lower.as_ref())),
            Self::Blocks(inverse) => Inverse::Blocks(inverse),
        }
    }

    /// The `count` lowest eigenpairs `a y = lambda m y` of the matrix that was factored and a positive semi-definite `m`, with `y^T m y = 1`.
    ///
    /// # Errors
    /// As [`lowest_pairs`].
    pub fn lowest_pairs(&self, m: SystemMatrixRef<'_>, count: usize) -> Result<(Vec<f64>, Mat<f64>), Error> {
        match (self, m) {
            (Self::Whole(lower), SystemMatrixRef::Dense(m)) => lowest_pairs(lower.as_ref(), m, count),
            (Self::Whole(lower), m) => lowest_pairs(lower.as_ref(), m.to_dense().as_ref(), count),
            (Self::Blocks(inverse), m) => lowest_pairs_of_inverse(inverse, m, count),
        }
    }
}

impl Inverse {
    /// `y = a^-1 x`.
    ///
    /// # Panics
    /// If the lengths do not fit.
    pub fn product_into(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Whole(inverse) => inverse.product_into(x, y),
            Self::Blocks(inverse) => inverse.product_into(x, y),
        }
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        match self {
            Self::Whole(inverse) => inverse.diagonal().collect(),
            Self::Blocks(inverse) => inverse.diagonal(),
        }
    }
}

/// The `count` lowest eigenpairs of `a y = lambda m y` with the `inverse` of `a` and a positive semi-definite `m`, with `y^T m y = 1`, by subspace
/// iteration.
fn lowest_pairs_of_inverse(
    inverse: &BlockInverse,
    m: SystemMatrixRef<'_>,
    count: usize,
) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let size = m.size();
    let width = (2 * count + 10).min(size);
    let mut shapes = crate::scattered(size, width);
    let mut previous = vec![0.0; count];
    let (mut least_change, mut since) = (f64::INFINITY, 0);
    for _ in 0..MAX_ITERATIONS {
        let momenta = m.product(shapes.as_ref());
        let mut motions = Mat::zeros(size, momenta.ncols());
        for j in 0..momenta.ncols() {
            inverse.product_into(momenta.col_as_slice(j), motions.col_as_slice_mut(j));
        }
        // Of the motions: the stiffness is that of the momenta that cause them.
        let stiffness = symmetric(product(motions.transpose(), momenta.as_ref()).as_ref());
        let inertia = symmetric(product(motions.transpose(), m.product(motions.as_ref()).as_ref()).as_ref());
        // In the metric of the stiffness, which is positive definite where momenta are independent.
        let (ascending, rotation) =
            symmetric_pair(inertia.as_ref(), stiffness.as_ref()).map_err(|error| match error {
                Error::NotPositiveDefinite { .. } => Error::Rank { size, count },
                other => other,
            })?;
        let values: Vec<f64> = ascending.iter().rev().take(count).copied().collect();
        let largest = values.first().copied().unwrap_or_default();
        if values.len() < count || !values.iter().all(|v| *v > f64::EPSILON * largest) {
            return Err(Error::Rank { size, count });
        }
        let n = ascending.len();
        let turn = Mat::from_fn(n, n, |i, j| {
            rotation[(i, n - 1 - j)] / ascending[n - 1 - j].abs().sqrt()
        });
        shapes = product(motions.as_ref(), turn.as_ref());
        let changes = values
            .iter()
            .zip(&previous)
            .map(|(value, before)| (value - before).abs() / value);
        let change = changes.fold(0.0, f64::max);
        since = if change < least_change { 0 } else { since + 1 };
        least_change = change.min(least_change);
        previous.clone_from(&values);
        if change < SETTLED || (since >= WAITING && change < PLATEAU) {
            let shapes = shapes.subcols(0, count).to_owned();
            return Ok((values.iter().map(|v| 1.0 / v).collect(), shapes));
        }
    }
    Err(Error::NoConvergence { size })
}
