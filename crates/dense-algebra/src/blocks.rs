//! Symmetric matrices over groups of coordinates that are coupled through few combinations of each: block low rank.
//!
//! `A = blkdiag(A_1, .., A_J, d) + T C T^T` with `T = blkdiag(B_1, .., B_J, 1)`: dense blocks `A_g` over the groups, a diagonal `d` over the coordinates that
//! follow them, bases `B_g` of few columns, and a small dense core `C`. Memory and products cost the sum of the squares of the groups.

use crate::packed::Symmetric;
use crate::{Error, cholesky_in_place, dot, product, solve_general_all};
use faer::{Mat, MatRef};
use std::sync::Arc;

/// What is left of a direction beside a basis, relative to it, that counts as round-off.
const DEPENDENT: f64 = 1e-13;

/// A symmetric matrix of groups of coordinates and a few more behind them.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockMatrix {
    /// `B_g`, with orthonormal columns.
    bases: Arc<Vec<Mat<f64>>>,
    /// `A_g`, in full. Matrices that differ in their coupling share them.
    local: Arc<Vec<Mat<f64>>>,
    /// `d`.
    rest: Vec<f64>,
    /// `C` over the columns of all bases and the rest.
    core: Mat<f64>,
}

/// The inverse of a [`BlockMatrix`].
#[derive(Clone, Debug, PartialEq)]
pub struct BlockInverse {
    /// Inverses of the blocks.
    local: Vec<Symmetric>,
    /// `1 / d`.
    rest: Vec<f64>,
    /// `A_g^-1 B_g`.
    responses: Vec<Mat<f64>>,
    /// `(1 + C G)^-1 C` with `G = T^T blkdiag(A_g, d)^-1 T`.
    core: Mat<f64>,
}

impl BlockMatrix {
    /// The matrix of these parts; `core` is over the columns of all bases and the rest.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn new(bases: Arc<Vec<Mat<f64>>>, local: Arc<Vec<Mat<f64>>>, rest: Vec<f64>, core: Mat<f64>) -> Self {
        assert_eq!(bases.len(), local.len());
        for (basis, block) in bases.iter().zip(local.iter()) {
            assert_eq!((basis.nrows(), basis.nrows()), block.shape());
        }
        let size = bases.iter().map(|basis| basis.ncols()).sum::<usize>() + rest.len();
        assert_eq!(core.shape(), (size, size));
        Self {
            bases,
            local,
            rest,
            core,
        }
    }

    /// Rows and columns.
    pub fn size(&self) -> usize {
        self.bases.iter().map(|basis| basis.nrows()).sum::<usize>() + self.rest.len()
    }

    /// Whether a product with its inverse takes fewer numbers than one with a dense inverse, both symmetric.
    pub fn is_smaller_than_dense(&self) -> bool {
        let square = |n: usize| n * n;
        let blocks: usize = self.local.iter().map(|block| square(block.nrows())).sum();
        blocks / 2 + square(self.core.nrows()) < square(self.size()) / 2
    }

    /// The bases, which matrices of one structure share.
    pub fn bases(&self) -> &Arc<Vec<Mat<f64>>> {
        &self.bases
    }

    /// The blocks.
    pub fn local(&self) -> &[Mat<f64>] {
        &self.local
    }

    /// The diagonal behind the groups.
    pub fn rest(&self) -> &[f64] {
        &self.rest
    }

    /// The core.
    pub fn core(&self) -> MatRef<'_, f64> {
        self.core.as_ref()
    }

    /// The core with the diagonal behind the groups on its own: what is left of the matrix without its blocks.
    pub fn seen(&self) -> Mat<f64> {
        let mut seen = self.core.clone();
        let first = self.rank();
        for (k, d) in self.rest.iter().enumerate() {
            seen[(first + k, first + k)] += d;
        }
        seen
    }

    /// The matrix with the same blocks and another such core, over the columns of all bases and any number of coordinates behind the groups.
    ///
    /// # Panics
    /// If it is smaller than the rank.
    #[must_use]
    pub fn with_seen(&self, mut seen: Mat<f64>) -> Self {
        let rest = (self.rank()..seen.nrows())
            .map(|k| std::mem::take(&mut seen[(k, k)]))
            .collect();
        Self::new(self.bases.clone(), self.local.clone(), rest, seen)
    }

    /// The bases with more columns, so that their space contains those of `columns` over all coordinates, but for what is below `least` of a whole column.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn extended_bases(&self, columns: MatRef<'_, f64>, least: f64) -> Arc<Vec<Mat<f64>>> {
        let least: Vec<f64> = columns.col_iter().map(|column| least * column.norm_l2()).collect();
        let mut at = 0;
        let extended = self.bases.iter().map(|basis| {
            let own = columns.subrows(at, basis.nrows());
            at += basis.nrows();
            extended_basis(basis, own, &least)
        });
        Arc::new(extended.collect())
    }

    /// The same matrix over bases that begin with its own.
    ///
    /// # Panics
    /// If the shapes do not fit.
    #[must_use]
    pub fn over_bases(&self, bases: &Arc<Vec<Mat<f64>>>) -> Self {
        let mut places = Vec::with_capacity(self.core.nrows());
        let mut first = 0;
        for (own, extended) in self.bases.iter().zip(bases.iter()) {
            places.extend(first..first + own.ncols());
            first += extended.ncols();
        }
        places.extend(first..first + self.rest.len());
        let size = first + self.rest.len();
        let mut core = Mat::zeros(size, size);
        for (j, &column) in places.iter().enumerate() {
            for (i, &row) in places.iter().enumerate() {
                core[(row, column)] = self.core[(i, j)];
            }
        }
        Self::new(bases.clone(), self.local.clone(), self.rest.clone(), core)
    }

    /// This matrix and a factor times another one over the same bases.
    ///
    /// # Panics
    /// If the shapes do not fit.
    #[must_use]
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let sum =
            |a: &Mat<f64>, b: &Mat<f64>| Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] + factor * b[(i, j)]);
        Self {
            bases: self.bases.clone(),
            local: Arc::new(
                self.local
                    .iter()
                    .zip(other.local.iter())
                    .map(|(a, b)| sum(a, b))
                    .collect(),
            ),
            rest: self.rest.iter().zip(&other.rest).map(|(a, b)| a + factor * b).collect(),
            core: sum(&self.core, &other.core),
        }
    }

    /// The matrix and `weight u u^T` for each of the vectors `u` given; its bases contain them.
    ///
    /// # Panics
    /// If the lengths do not fit.
    #[must_use]
    pub fn plus_outer(&self, given: &[(f64, &[f64])]) -> Self {
        let columns = Mat::from_fn(self.size(), given.len(), |i, j| given[j].1[i]);
        let mut sum = self.over_bases(&self.extended_bases(columns.as_ref(), DEPENDENT));
        let seen = sum.onto_core(columns.as_ref());
        let weighted = Mat::from_fn(seen.nrows(), seen.ncols(), |i, j| given[j].0 * seen[(i, j)]);
        sum.core += crate::symmetric(product(weighted.as_ref(), seen.transpose()).as_ref());
        sum
    }

    /// The blocks alone, without what lies behind them.
    #[must_use]
    pub fn groups_alone(&self) -> Self {
        let rank = self.rank();
        let core = self.core.submatrix(0, 0, rank, rank).to_owned();
        Self::new(self.bases.clone(), self.local.clone(), Vec::new(), core)
    }

    /// `T x` over the groups alone: rows over the columns of all bases as rows over the coordinates of the groups.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn from_core(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let n = self.size() - self.rest.len();
        let mut out = Mat::zeros(n, x.ncols());
        let (mut at, mut column) = (0, 0);
        for basis in self.bases.iter() {
            let (n, r) = basis.shape();
            out.subrows_mut(at, n)
                .copy_from(product(basis.as_ref(), x.subrows(column, r)));
            (at, column) = (at + n, column + r);
        }
        out
    }

    /// Columns of all bases together.
    pub fn rank(&self) -> usize {
        self.core.nrows() - self.rest.len()
    }

    /// A factor times the matrix.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let of = |a: &Mat<f64>| a * faer::Scale(factor);
        Self {
            bases: self.bases.clone(),
            local: Arc::new(self.local.iter().map(of).collect()),
            rest: self.rest.iter().map(|d| factor * d).collect(),
            core: of(&self.core),
        }
    }

    /// `T^T x`.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn onto_core(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        onto_core(&self.bases, self.core.nrows(), x)
    }

    /// `y = A x` for all columns.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn product(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let mut y = Mat::zeros(self.size(), x.ncols());
        let seen = product(self.core.as_ref(), self.onto_core(x).as_ref());
        let (mut at, mut column) = (0, 0);
        for (basis, block) in self.bases.iter().zip(self.local.iter()) {
            let (n, r) = basis.shape();
            let own = product(block.as_ref(), x.subrows(at, n)) + product(basis.as_ref(), seen.subrows(column, r));
            y.subrows_mut(at, n).copy_from(own);
            (at, column) = (at + n, column + r);
        }
        for (k, d) in self.rest.iter().enumerate() {
            for j in 0..x.ncols() {
                y[(at + k, j)] = d * x[(at + k, j)] + seen[(column + k, j)];
            }
        }
        y
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.size());
        let mut column = 0;
        for (basis, block) in self.bases.iter().zip(self.local.iter()) {
            let r = basis.ncols();
            let seen = product(basis.as_ref(), self.core.submatrix(column, column, r, r));
            out.extend((0..basis.nrows()).map(|i| block[(i, i)] + row_dot(seen.as_ref(), basis.as_ref(), i)));
            column += r;
        }
        out.extend((0..self.rest.len()).map(|k| self.rest[k] + self.core[(column + k, column + k)]));
        out
    }

    /// All entries.
    pub fn to_dense(&self) -> Mat<f64> {
        let size = self.size();
        let mut transform = Mat::<f64>::zeros(size, self.core.nrows());
        let mut out = Mat::<f64>::zeros(size, size);
        let (mut at, mut column) = (0, 0);
        for (basis, block) in self.bases.iter().zip(self.local.iter()) {
            let (n, r) = basis.shape();
            transform.submatrix_mut(at, column, n, r).copy_from(basis);
            out.submatrix_mut(at, at, n, n).copy_from(block);
            (at, column) = (at + n, column + r);
        }
        for (k, d) in self.rest.iter().enumerate() {
            transform[(at + k, column + k)] = 1.0;
            out[(at + k, at + k)] = *d;
        }
        out + product(
            product(transform.as_ref(), self.core.as_ref()).as_ref(),
            transform.transpose(),
        )
    }

    /// The inverse of the matrix plus a symmetric one with these entries, `(row, column, value)`, none of which couples two groups or lies behind them.
    ///
    /// # Errors
    /// [`Error::NotPositiveDefinite`] for a block; [`Error::NoConvergence`] where the coupling is singular.
    ///
    /// # Panics
    /// If an entry couples two groups or lies behind them.
    pub fn inverse_plus(&self, entries: impl Iterator<Item = (usize, usize, f64)>) -> Result<BlockInverse, Error> {
        let mut place = Vec::new();
        for (group, basis) in self.bases.iter().enumerate() {
            place.extend((0..basis.nrows()).map(|i| (group, i)));
        }
        let n_groups = self.local.len();
        let mut added = vec![Vec::new(); n_groups];
        for (row, column, value) in entries {
            let ((group, i), (other, j)) = (place[row], place[column]);
            assert_eq!(group, other, "entries must not couple groups");
            added[group].push((i, j, value));
        }
        let mut local = Vec::with_capacity(n_groups);
        let mut responses = Vec::with_capacity(n_groups);
        let rank = self.core.nrows();
        // C G: columns of the core times the compliance seen by each basis.
        let mut system = Mat::<f64>::zeros(rank, rank);
        let mut column = 0;
        let mut first = 0;
        for ((block, basis), added) in self.local.iter().zip(self.bases.iter()).zip(added) {
            let r = basis.ncols();
            let mut block = block.clone();
            added.into_iter().for_each(|(i, j, value)| block[(i, j)] += value);
            let lower = cholesky_in_place(block).map_err(|error| match error {
                Error::NotPositiveDefinite { pivot, .. } => Error::NotPositiveDefinite {
                    pivot: first + pivot,
                    size: self.size(),
                },
                other => other,
            })?;
            first += basis.nrows();
            let mut response = basis.clone();
            crate::solve_lower(lower.as_ref(), response.as_mut());
            crate::solve_lower_transposed(lower.as_ref(), response.as_mut());
            let compliance = crate::symmetric(product(basis.transpose(), response.as_ref()).as_ref());
            let seen = product(self.core.subcols(column, r), compliance.as_ref());
            system.subcols_mut(column, r).copy_from(seen);
            local.push(Symmetric::inverse_of_factor(lower.as_ref()));
            responses.push(response);
            column += r;
        }
        for (k, d) in self.rest.iter().enumerate() {
            for i in 0..rank {
                system[(i, column + k)] = self.core[(i, column + k)] / d;
            }
        }
        for i in 0..rank {
            system[(i, i)] += 1.0;
        }
        let right: Vec<&[f64]> = (0..rank).map(|j| self.core.col_as_slice(j)).collect();
        let columns = solve_general_all(system, &right).ok_or(Error::NoConvergence { size: rank })?;
        let core = Mat::from_fn(rank, rank, |i, j| 0.5 * (columns[j][i] + columns[i][j]));
        Ok(BlockInverse {
            local,
            rest: self.rest.iter().map(|d| 1.0 / d).collect(),
            responses,
            core,
        })
    }
}

impl BlockInverse {
    /// Memory of the entries, which a product reads once.
    pub fn bytes(&self) -> usize {
        let dense = self.responses.iter().chain([&self.core]);
        let entries: usize = dense.map(|matrix| matrix.nrows() * matrix.ncols()).sum();
        let local: usize = self.local.iter().map(Symmetric::bytes).sum();
        local + (self.rest.len() + entries) * size_of::<f64>()
    }

    /// `y = A^-1 x`.
    ///
    /// # Panics
    /// If the lengths do not fit.
    pub fn product_into(&self, x: &[f64], y: &mut [f64]) {
        let rank = self.core.nrows();
        let column_of = |x: &'_ [f64]| MatRef::from_column_major_slice(x, x.len(), 1).to_owned();
        let mut seen = Mat::<f64>::zeros(rank, 1);
        let (mut at, mut column) = (0, 0);
        for (block, response) in self.local.iter().zip(&self.responses) {
            let (n, r) = response.shape();
            block.product_into(&x[at..at + n], &mut y[at..at + n]);
            let own = product(response.transpose(), column_of(&x[at..at + n]).as_ref());
            seen.subrows_mut(column, r).copy_from(own);
            (at, column) = (at + n, column + r);
        }
        for (k, inverse) in self.rest.iter().enumerate() {
            y[at + k] = inverse * x[at + k];
            seen[(column + k, 0)] = y[at + k];
        }
        let given = product(self.core.as_ref(), seen.as_ref());
        (at, column) = (0, 0);
        for response in &self.responses {
            let (n, r) = response.shape();
            let own = product(response.as_ref(), given.subrows(column, r));
            y[at..at + n]
                .iter_mut()
                .zip(own.col(0).iter())
                .for_each(|(y, own)| *y -= own);
            (at, column) = (at + n, column + r);
        }
        for (k, inverse) in self.rest.iter().enumerate() {
            y[at + k] -= inverse * given[(column + k, 0)];
        }
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        let mut out = Vec::new();
        let mut column = 0;
        for (block, response) in self.local.iter().zip(&self.responses) {
            let r = response.ncols();
            let seen = product(response.as_ref(), self.core.submatrix(column, column, r, r));
            let own = block.diagonal().enumerate();
            out.extend(own.map(|(i, value)| value - row_dot(seen.as_ref(), response.as_ref(), i)));
            column += r;
        }
        let rest = self.rest.iter().enumerate();
        out.extend(rest.map(|(k, d)| d - d * d * self.core[(column + k, column + k)]));
        out
    }
}

fn row_dot(a: MatRef<'_, f64>, b: MatRef<'_, f64>, i: usize) -> f64 {
    (0..a.ncols()).map(|j| a[(i, j)] * b[(i, j)]).sum()
}

fn onto_core(bases: &[Mat<f64>], rank: usize, x: MatRef<'_, f64>) -> Mat<f64> {
    let mut seen = Mat::zeros(rank, x.ncols());
    let (mut at, mut column) = (0, 0);
    for basis in bases {
        let (n, r) = basis.shape();
        seen.subrows_mut(column, r)
            .copy_from(product(basis.transpose(), x.subrows(at, n)));
        (at, column) = (at + n, column + r);
    }
    seen.subrows_mut(column, rank - column)
        .copy_from(x.subrows(at, rank - column));
    seen
}

/// An orthonormal basis of the space of `columns`, the one that sticks out most first, until nothing sticks out by more than `least`.
pub fn leading_basis(mut columns: Mat<f64>, least: f64) -> Mat<f64> {
    let size = columns.nrows();
    let mut squares: Vec<f64> = columns.col_iter().map(|column| column.squared_norm_l2()).collect();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    while basis.len() < size {
        let Some((pivot, &largest)) = squares.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)) else {
            break;
        };
        // Also ends at NaN.
        if !(largest.sqrt() > least) {
            break;
        }
        let mut direction = columns.col_as_slice(pivot).to_vec();
        if !put_beside(&mut direction, &basis, 0.0) {
            squares[pivot] = 0.0;
            continue;
        }
        for (j, square) in squares.iter_mut().enumerate() {
            let column = columns.col_as_slice_mut(j);
            add(column, -dot(&direction, column), &direction);
            *square = dot(column, column);
        }
        squares[pivot] = 0.0;
        basis.push(direction);
    }
    Mat::from_fn(size, basis.len(), |i, j| basis[j][i])
}

/// An orthonormal basis that begins with that of `basis` and also has the space of `more`, but for what is not longer than `least` of each column.
fn extended_basis(basis: &Mat<f64>, more: MatRef<'_, f64>, least: &[f64]) -> Mat<f64> {
    let mut columns: Vec<Vec<f64>> = basis
        .col_iter()
        .map(|column| column.iter().copied().collect())
        .collect();
    for (column, least) in more.col_iter().zip(least) {
        let mut direction: Vec<f64> = column.iter().copied().collect();
        if columns.len() < basis.nrows() && put_beside(&mut direction, &columns, *least) {
            columns.push(direction);
        }
    }
    Mat::from_fn(basis.nrows(), columns.len(), |i, j| columns[j][i])
}

/// Makes a direction orthogonal to those of a basis and of unit length; false if what is left is no longer than `least`, or round-off.
fn put_beside(direction: &mut [f64], basis: &[Vec<f64>], least: f64) -> bool {
    let given = dot(direction, direction).sqrt();
    for _ in 0..2 {
        for known in basis {
            add(direction, -dot(known, direction), known);
        }
    }
    let left = dot(direction, direction).sqrt();
    // Also false for NaN.
    let is_new = left > least.max(DEPENDENT * given);
    if is_new {
        direction.iter_mut().for_each(|v| *v /= left);
    }
    is_new
}

fn add(to: &mut [f64], factor: f64, from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from);
}
