//! Block Lanczos steps in the inner product of a mass, for the lowest pairs of matrices that are solved with.

use crate::bases::dot;
use crate::{Error, add_product, product, product_into};
use faer::{Mat, MatMut, MatRef, unzip, zip};
use std::ops::Range;

/// `y = M x` for all columns.
type Product<'a> = dyn Fn(MatRef<'_, f64>, MatMut<'_, f64>) + 'a;

/// An orthonormal Krylov basis (mass inner product) with the projected operator, built in blocks.
pub struct Krylov {
    basis: Mat<f64>,
    /// Projection coefficients: column `j` expands the operator's image of basis vector `j`.
    projected: Mat<f64>,
    /// Basis vectors whose image the next block is.
    source: Range<usize>,
    /// The first so many are left out of all others, and of the pairs that are found.
    n_left_out: usize,
}

impl Krylov {
    /// Vectors of a block: as many equal eigenvalues are found.
    pub const WIDTH: usize = 8;

    /// An empty basis of vectors of `n` numbers, with room for `limit` of them and a block.
    pub fn new(n: usize, limit: usize) -> Self {
        let room = limit + Self::WIDTH;
        let mut basis = Mat::with_capacity(n, room);
        basis.resize_with(n, 0, |_, _| 0.0);
        Self {
            basis,
            projected: Mat::zeros(room, room),
            source: 0..0,
            n_left_out: 0,
        }
    }

    /// Leaves these orthonormal vectors out of all that are appended; they count as vectors of the basis. For an empty one.
    pub fn leave_out(&mut self, multiply: &Product<'_>, known: MatRef<'_, f64>) {
        self.append(multiply, known.to_owned());
        self.n_left_out = self.size();
    }

    /// Vectors.
    pub fn size(&self) -> usize {
        self.basis.ncols()
    }

    /// Orthonormalises the block against the basis and appends it; returns `M` times the new vectors, ready for the
    /// solve. Vectors that add nothing are left out.
    pub fn append(&mut self, multiply: &Product<'_>, mut block: Mat<f64>) -> Mat<f64> {
        let (n, size, width) = (block.nrows(), self.size(), block.ncols());
        let mut momentum = Mat::zeros(n, width);
        // The block as it came is basis * along + block * upper.
        let mut along = Mat::<f64>::zeros(size, width);
        let mut upper = Mat::<f64>::identity(width, width);
        multiply(block.as_ref(), momentum.as_mut());
        for _ in 0..2 {
            let initial: Vec<f64> = (0..block.ncols())
                .map(|j| dot(block.col_as_slice(j), momentum.col_as_slice(j)).max(0.0).sqrt())
                .collect();
            let coefficients = product(self.basis.transpose(), momentum.as_ref());
            add_product(block.as_mut(), self.basis.as_ref(), coefficients.as_ref(), -1.0);
            multiply(block.as_ref(), momentum.as_mut());
            along += product(coefficients.as_ref(), upper.as_ref());
            let new = orthonormalise(&mut block, &mut momentum, &initial);
            upper = product(new.as_ref(), upper.as_ref());
        }
        for column in 0..self.source.len() {
            let image = self.source.start + column;
            for row in 0..size {
                self.projected[(row, image)] = along[(row, column)];
            }
            for row in 0..block.ncols() {
                self.projected[(size + row, image)] = upper[(row, column)];
            }
        }
        let grown = size + block.ncols();
        self.basis
            .resize_with(n, grown, |row, column| block[(row, column - size)]);
        momentum
    }

    /// Says that the next block is the image of the last `width` vectors.
    pub fn follow(&mut self, width: usize) {
        self.source = self.size() - width..self.size();
    }

    /// Eigenpairs of the projected operator over the vectors whose images are known, descending.
    fn ritz(&self) -> Result<(Vec<f64>, Mat<f64>, usize), Error> {
        let first = self.n_left_out;
        let known = self.source.end.saturating_sub(first);
        let h = Mat::from_fn(known, known, |i, j| {
            let (i, j) = (first + i, first + j);
            0.5 * (self.projected[(i, j)] + self.projected[(j, i)])
        });
        let (ascending, columns) = crate::symmetric_eigen(h.as_ref())?;
        let values = ascending.into_iter().rev().collect();
        let vectors = Mat::from_fn(known, known, |i, j| columns[(i, known - 1 - j)]);
        Ok((values, vectors, known))
    }

    /// Whether the residuals `|A phi - theta phi|_M` of the leading pairs are below `tolerance * theta`; how many are `wanted` may depend on the
    /// values found, which are descending.
    ///
    /// # Errors
    /// [`Error::NoConvergence`].
    pub fn converged(&self, wanted: impl FnOnce(&[f64]) -> usize, tolerance: f64) -> Result<bool, Error> {
        let (values, vectors, known) = self.ritz()?;
        let wanted = wanted(&values);
        if known < wanted {
            return Ok(false);
        }
        let tail = self.source.clone();
        Ok((0..wanted).all(|pair| {
            let mut squares = 0.0;
            for row in self.source.end..self.size() {
                let sum: f64 = tail
                    .clone()
                    .map(|j| self.projected[(row, j)] * vectors[(j - self.n_left_out, pair)])
                    .sum();
                squares += sum * sum;
            }
            squares.sqrt() <= tolerance * values[pair].abs()
        }))
    }

    /// The largest eigenvalues and their vectors, at most `wanted`.
    ///
    /// # Errors
    /// [`Error::NoConvergence`].
    pub fn ritz_pairs(&self, wanted: usize) -> Result<(Vec<f64>, Mat<f64>), Error> {
        let (mut values, vectors, known) = self.ritz()?;
        let take = wanted.min(known);
        let mut shapes = Mat::zeros(self.basis.nrows(), take);
        let leading = vectors.subcols(0, take);
        product_into(shapes.as_mut(), self.basis.subcols(self.n_left_out, known), leading);
        values.truncate(take);
        Ok((values, shapes))
    }

    /// All vectors.
    pub fn into_basis(self) -> Mat<f64> {
        self.basis
    }
}

/// Modified Gram-Schmidt on the columns of `block` in the mass inner product, with the mass times them alongside.
///
/// Columns left with less than 1e-12 of their `initial` norm are dropped. Returns the coefficients of the old columns
/// in the new ones.
fn orthonormalise(block: &mut Mat<f64>, momentum: &mut Mat<f64>, initial: &[f64]) -> Mat<f64> {
    let (n, width) = (block.nrows(), block.ncols());
    let mut coefficients = Mat::zeros(width, width);
    let mut kept = 0;
    for column in 0..width {
        for other in 0..kept {
            let along = dot(block.col_as_slice(column), momentum.col_as_slice(other));
            coefficients[(other, column)] = along;
            let take_out = |vectors: &mut Mat<f64>| {
                let (before, from) = vectors.as_mut().split_at_col_mut(column);
                zip!(from.col_mut(0), before.col(other)).for_each(|unzip!(a, b)| *a -= along * b);
            };
            rayon::join(|| take_out(block), || take_out(momentum));
        }
        let square = dot(block.col_as_slice(column), momentum.col_as_slice(column));
        let norm = square.max(0.0).sqrt();
        // `!(a > b)` also catches NaN.
        if !(norm > 1e-12 * initial[column]) {
            continue;
        }
        coefficients[(kept, column)] = norm;
        let scale = |vectors: &mut Mat<f64>| {
            for row in 0..n {
                vectors[(row, kept)] = vectors[(row, column)] / norm;
            }
        };
        rayon::join(|| scale(block), || scale(momentum));
        kept += 1;
    }
    block.truncate(n, kept);
    momentum.truncate(n, kept);
    coefficients.truncate(kept, width);
    coefficients
}
