//! Symmetric matrices stored once, and their product with a vector: half the memory traffic of a general matrix.

use crate::tiles::{TILE, solve_here};
use faer::{Mat, MatRef};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Columns that are multiplied together, so that the result is read and written once for all of them.
const WIDTH: usize = 4;

/// A symmetric matrix of which every entry off the diagonal blocks is stored once.
///
/// Blocks of four columns follow one another, each with its diagonal block in full and then its columns below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Symmetric {
    size: usize,
    entries: Vec<f64>,
}

impl Symmetric {
    /// Takes the lower triangle of `a`.
    ///
    /// # Panics
    /// If `a` is not square.
    pub fn from_lower(a: MatRef<'_, f64>) -> Self {
        let size = a.nrows();
        assert_eq!(size, a.ncols());
        let mut entries = vec![0.0; stored(size, 0)];
        pack(a, &mut entries);
        Self { size, entries }
    }

    /// The inverse of `lower lower^T`, some columns after others: there is never room for all of it in full.
    ///
    /// # Panics
    /// If `lower` is not square.
    pub fn inverse_of_factor(lower: MatRef<'_, f64>) -> Self {
        let size = lower.nrows();
        assert_eq!(size, lower.ncols());
        let mut entries = vec![0.0; stored(size, 0)];
        let (mut rest, mut tiles) = (entries.as_mut_slice(), Vec::new());
        for first in (0..size).step_by(TILE) {
            let (own, next) = rest.split_at_mut(stored(size, first) - stored(size, size.min(first + TILE)));
            tiles.push((first, own));
            rest = next;
        }
        // One by one: the first are the longest.
        tiles.into_par_iter().with_max_len(1).for_each(|(first, own)| {
            let height = size - first;
            // Rows above are those of other tiles, and the rows at hand do not depend on them.
            let lower = lower.submatrix(first, first, height, height);
            let mut columns = Mat::identity(height, TILE.min(height));
            solve_here(lower, columns.as_mut(), false);
            solve_here(lower, columns.as_mut(), true);
            pack(columns.as_ref(), own);
        });
        Self { size, entries }
    }

    /// Number of rows and columns.
    pub fn size(&self) -> usize {
        self.size
    }

    /// All entries.
    pub fn to_dense(&self) -> Mat<f64> {
        let size = self.size;
        let mut whole = Mat::zeros(size, size);
        let mut entries = self.entries.iter();
        let mut next = || entries.next().copied().unwrap_or_default();
        for start in (0..size).step_by(WIDTH) {
            let end = size.min(start + WIDTH);
            for j in start..end {
                (start..end).for_each(|i| whole[(i, j)] = next());
            }
            for j in start..end {
                for i in end..size {
                    let value = next();
                    (whole[(i, j)], whole[(j, i)]) = (value, value);
                }
            }
        }
        whole
    }

    /// This matrix and a factor times another one.
    ///
    /// # Panics
    /// If their sizes differ.
    #[must_use]
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        assert_eq!(self.size, other.size);
        let entries = self.entries.iter().zip(&other.entries);
        Self {
            size: self.size,
            entries: entries.map(|(a, b)| a + factor * b).collect(),
        }
    }

    /// A factor times the matrix.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            size: self.size,
            entries: self.entries.iter().map(|a| factor * a).collect(),
        }
    }

    /// Memory of the entries, which a product reads once.
    pub fn bytes(&self) -> usize {
        size_of_val(self.entries.as_slice())
    }

    /// The diagonal, from the first entry to the last.
    pub fn diagonal(&self) -> impl Iterator<Item = f64> {
        let mut at = 0;
        (0..self.size).map(move |i| {
            let start = i - i % WIDTH;
            let width = WIDTH.min(self.size - start);
            let place = at + (i - start) * (width + 1);
            if i + 1 == start + width {
                at += width * (width + self.size - start - width);
            }
            self.entries[place]
        })
    }

    /// `y = self x`. The order of summation is fixed; with and without fused multiplication the last bits differ.
    ///
    /// # Panics
    /// If the lengths do not fit.
    pub fn product_into(&self, x: &[f64], y: &mut [f64]) {
        assert_eq!(x.len(), self.size);
        assert_eq!(y.len(), self.size);
        Arch::new().dispatch(Product { matrix: self, x, y });
    }
}

/// Entries that the columns from `first` on of a matrix of this size take; `first` begins a block.
fn stored(size: usize, first: usize) -> usize {
    (first..size)
        .step_by(WIDTH)
        .map(|start| WIDTH.min(size - start) * (size - start))
        .sum()
}

/// Writes the lower triangle of the leading columns of a symmetric matrix.
fn pack(columns: MatRef<'_, f64>, entries: &mut [f64]) {
    let (height, width) = (columns.nrows(), columns.ncols());
    let mut entries = entries.iter_mut();
    let mut put = |value| entries.next().into_iter().for_each(|entry| *entry = value);
    for start in (0..width).step_by(WIDTH) {
        let end = width.min(start + WIDTH);
        for j in start..end {
            (start..end).for_each(|i| put(columns[(i.max(j), i.min(j))]));
        }
        for j in start..end {
            (end..height).for_each(|i| put(columns[(i, j)]));
        }
    }
}

struct Product<'a> {
    matrix: &'a Symmetric,
    x: &'a [f64],
    y: &'a mut [f64],
}

impl WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { matrix, x, y } = self;
        y.fill(0.0);
        let mut rest = matrix.entries.as_slice();
        for start in (0..matrix.size).step_by(WIDTH) {
            let end = matrix.size.min(start + WIDTH);
            let width = end - start;
            let (diagonal, below) = rest.split_at(width * width);
            for (column, x) in diagonal.chunks_exact(width).zip(&x[start..end]) {
                for (y, a) in y[start..end].iter_mut().zip(column) {
                    *y += a * x;
                }
            }
            // Only the last block can be narrower, and nothing is below it.
            let height = matrix.size - end;
            let (columns, next) = below.split_at(width * height);
            rest = next;
            if height == 0 {
                continue;
            }
            let column = |j: usize| &columns[j * height..(j + 1) * height];
            let columns = [column(0), column(1), column(2), column(3)];
            let (above, y_below) = y.split_at_mut(end);
            let sums = block(
                simd,
                columns,
                [x[start], x[start + 1], x[start + 2], x[start + 3]],
                &x[end..],
                y_below,
            );
            for (y, sum) in above[start..].iter_mut().zip(sums) {
                *y += sum;
            }
        }
    }
}

/// `y += columns factors`; returns the products of the columns with `x`.
#[inline(always)]
fn block<S: Simd>(simd: S, columns: [&[f64]; WIDTH], factors: [f64; WIDTH], x: &[f64], y: &mut [f64]) -> [f64; WIDTH] {
    // Without closures: in builds of several codegen units they are functions of their own, without the wide registers.
    let [c0, c1, c2, c3] = columns;
    let ((c0, r0), (c1, r1)) = (S::as_simd_f64s(c0), S::as_simd_f64s(c1));
    let ((c2, r2), (c3, r3)) = (S::as_simd_f64s(c2), S::as_simd_f64s(c3));
    let ((x, x_rest), (y, y_rest)) = (S::as_simd_f64s(x), S::as_mut_simd_f64s(y));
    let [f0, f1, f2, f3] = factors;
    let (f0, f1) = (simd.splat_f64s(f0), simd.splat_f64s(f1));
    let (f2, f3) = (simd.splat_f64s(f2), simd.splat_f64s(f3));
    let mut sums = [simd.splat_f64s(0.0); WIDTH];
    for (((((c0, c1), c2), c3), x), y) in c0.iter().zip(c1).zip(c2).zip(c3).zip(x).zip(y) {
        sums[0] = simd.mul_add_e_f64s(*c0, *x, sums[0]);
        sums[1] = simd.mul_add_e_f64s(*c1, *x, sums[1]);
        sums[2] = simd.mul_add_e_f64s(*c2, *x, sums[2]);
        sums[3] = simd.mul_add_e_f64s(*c3, *x, sums[3]);
        // Two short chains instead of one long one.
        let left = simd.mul_add_e_f64s(*c0, f0, simd.mul_f64s(*c1, f1));
        let right = simd.mul_add_e_f64s(*c2, f2, simd.mul_add_e_f64s(*c3, f3, *y));
        *y = simd.add_f64s(left, right);
    }
    let [s0, s1, s2, s3] = sums;
    let mut out = [
        simd.reduce_sum_f64s(s0),
        simd.reduce_sum_f64s(s1),
        simd.reduce_sum_f64s(s2),
        simd.reduce_sum_f64s(s3),
    ];
    for i in 0..x_rest.len() {
        let row = [r0[i], r1[i], r2[i], r3[i]];
        for (out, c) in out.iter_mut().zip(row) {
            *out += c * x_rest[i];
        }
        for (c, f) in row.iter().zip(factors) {
            y_rest[i] += c * f;
        }
    }
    out
}
