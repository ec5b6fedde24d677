//! Stiffness or mass of a reduced structure: dense, or blocks with a coupling of low rank.

use crate::blocks::BlockMatrix;
use crate::{Error, Krylov, Symmetric, cholesky_in_place, lowest_pairs, product, solve_lower, solve_lower_transposed};
use faer::linalg::matmul::matmul;
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par, unzip, zip};

/// Most vectors of all steps.
const MOST_VECTORS: usize = 600;

/// What the image of a pair may have beside all vectors, relative to it.
const SETTLED: f64 = 1e-9;

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
            (Self::Dense(own), SystemMatrixRef::Dense(other)) => {
                // A product with the factor would be one copy more of what may be large.
                let mut sum = own.to_owned();
                zip!(&mut sum, other).for_each(|unzip!(a, b)| *a += factor * b);
                SystemMatrix::Dense(sum)
            }
            (own, other) => SystemMatrix::Dense(own.to_dense() + other.to_dense() * faer::Scale(factor)),
        }
    }

    /// Rows and columns.
    pub fn size(self) -> usize {
        match self {
            Self::Dense(matrix) => matrix.nrows(),
            Self::Blocks(matrix) => matrix.size(),
        }
    }

    /// Memory of its entries, symmetric ones once (bytes).
    pub fn bytes(self) -> usize {
        match self {
            Self::Dense(matrix) => size_of::<f64>() * matrix.nrows() * (matrix.nrows() + 1) / 2,
            Self::Blocks(matrix) => matrix.bytes(),
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
        match self {
            Self::Dense(matrix) => {
                let x = MatRef::from_column_major_slice(x, x.len(), 1);
                let rows = y.len();
                let y = MatMut::from_column_major_slice_mut(y, rows, 1);
                matmul(y, Accum::Replace, matrix, x, 1.0, Par::Seq);
            }
            Self::Blocks(matrix) => matrix.product_into(x, y),
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
            Self::Blocks(matrix) => matrix.product_into(x, y),
        }
    }
}

/// A positive definite [`SystemMatrix`] that can be solved with.
#[derive(Clone, Debug)]
pub enum Factor {
    /// The lower Cholesky factor.
    Whole(Mat<f64>),
    /// The inverse of blocks.
    Blocks(BlockMatrix),
}

/// The inverse of a positive definite [`SystemMatrix`], for products.
#[derive(Clone, Debug, PartialEq)]
pub enum Inverse {
    /// Of all entries.
    Whole(Symmetric),
    /// Of blocks.
    Blocks(BlockMatrix),
}

impl Factor {
    /// `x = a^-1 x` for all columns.
    ///
    /// # Panics
    /// If the number of rows does not fit.
    pub fn solve_in_place(&self, mut x: MatMut<'_, f64>) {
        match self {
            Self::Whole(lower) => {
                solve_lower(lower.as_ref(), x.rb_mut());
                solve_lower_transposed(lower.as_ref(), x);
            }
            Self::Blocks(inverse) => {
                let solved = inverse.product(x.rb());
                x.copy_from(solved);
            }
        }
    }

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

    /// Memory of the entries, which a product reads once.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Whole(inverse) => inverse.bytes(),
            Self::Blocks(inverse) => inverse.bytes(),
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

/// The `count` lowest eigenpairs of `a y = lambda m y` with the `inverse` of `a` and a positive semi-definite `m`, with `y^T m y = 1`, by block Lanczos
/// steps with `a^-1 m` in the inner product of `m`: with blocks a product is most of the work, and each adds to all pairs.
fn lowest_pairs_of_inverse(
    inverse: &BlockMatrix,
    m: SystemMatrixRef<'_>,
    count: usize,
) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let size = m.size();
    let multiply = |x: MatRef<'_, f64>, mut y: MatMut<'_, f64>| y.copy_from(m.product(x));
    let mut krylov = Krylov::new(size, MOST_VECTORS.min(size));
    let mut block = inverse.product(
        m.product(crate::scattered(size, Krylov::WIDTH.min(size)).as_ref())
            .as_ref(),
    );
    loop {
        let momenta = krylov.append(&multiply, block);
        let width = momenta.ncols();
        if width == 0 || krylov.converged(|_| count, SETTLED)? {
            break;
        }
        if krylov.size() >= MOST_VECTORS {
            return Err(Error::NoConvergence { size });
        }
        block = inverse.product(momenta.as_ref());
        krylov.follow(width);
    }
    let (values, shapes) = krylov.ritz_pairs(count)?;
    let largest = values.first().copied().unwrap_or_default();
    if values.len() < count || !values.iter().all(|v| *v > f64::EPSILON * largest) {
        return Err(Error::Rank { size, count });
    }
    Ok((values.iter().map(|v| 1.0 / v).collect(), shapes))
}
