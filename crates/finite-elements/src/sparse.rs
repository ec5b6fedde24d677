//! Operations on compressed sparse row matrices that the sparse container lacks: blocked products and submatrices.

use faer::{Mat, MatMut, MatRef};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use sprs::CsMat;

/// Columns handled together, so that each matrix entry is loaded once for all of them; they fill a vector register.
pub(crate) const LANES: usize = 8;

/// Rows computed together.
const GROUP: usize = 2048;

/// `y = a * x` for a compressed-row matrix and dense columns, in parallel over groups of columns and rows.
///
/// The order of every sum is fixed, so the result does not depend on the number of threads.
///
/// # Panics
/// If the shapes do not fit.
pub fn multiply_into(a: &CsMat<f64>, x: MatRef<'_, f64>, y: MatMut<'_, f64>) {
    assert!(a.is_csr() && a.cols() == x.nrows() && a.rows() == y.nrows() && x.ncols() == y.ncols());
    let groups: Vec<_> = y.par_col_chunks_mut(LANES).collect::<Vec<_>>();
    groups.into_par_iter().enumerate().for_each(|(group, out)| {
        let width = out.ncols();
        let columns = x.subcols(group * LANES, width);
        let mut packed = vec![[0.0; LANES]; a.cols()];
        packed.par_chunks_mut(GROUP).enumerate().for_each(|(part, slots)| {
            for (row, slot) in (part * GROUP..).zip(slots) {
                for lane in 0..width {
                    slot[lane] = columns[(row, lane)];
                }
            }
        });
        let parts = out.par_row_chunks_mut(GROUP).enumerate();
        parts.for_each(|(part, out)| {
            let first = part * GROUP;
            let packed = packed.as_slice();
            Arch::new().dispatch(LanesOfRows { a, first, packed, out });
        });
    });
}

/// As [`multiply_into`], in a matrix of its own.
///
/// # Panics
/// If the shapes do not fit.
pub fn multiply(a: &CsMat<f64>, x: MatRef<'_, f64>) -> Mat<f64> {
    let mut y = Mat::zeros(a.rows(), x.ncols());
    multiply_into(a, x, y.as_mut());
    y
}

/// Rows of a product, from the row `first` of the matrix on.
struct LanesOfRows<'a> {
    a: &'a CsMat<f64>,
    first: usize,
    packed: &'a [[f64; LANES]],
    out: MatMut<'a, f64>,
}

impl WithSimd for LanesOfRows<'_> {
    type Output = ();

    // Products and sums of all lanes are instructions of the widest registers that there are; they are not fused, so that all machines find the same bits.
    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) {
        for i in 0..self.out.nrows() {
            let mut sum = [0.0; LANES];
            for (column, value) in entries(self.a, self.first + i) {
                let lanes = &self.packed[column];
                for lane in 0..LANES {
                    sum[lane] += value * lanes[lane];
                }
            }
            for lane in 0..self.out.ncols() {
                self.out[(i, lane)] = sum[lane];
            }
        }
    }
}

/// `y = a * x` for one vector.
///
/// # Panics
/// If the shapes do not fit.
pub fn multiply_vector(a: &CsMat<f64>, x: &[f64]) -> Vec<f64> {
    assert!(a.is_csr() && a.cols() == x.len());
    a.outer_iterator()
        .map(|row| row.iter().map(|(column, value)| value * x[column]).sum())
        .collect()
}

/// The congruence `t^T a t` of a symmetric compressed-row matrix, exactly symmetric, in parallel over groups of rows.
///
/// The order of every sum is fixed, so the result does not depend on the number of threads.
///
/// # Panics
/// If the shapes do not fit.
pub fn congruence(t: &CsMat<f64>, a: &CsMat<f64>) -> CsMat<f64> {
    assert!(t.is_csr() && a.is_csr() && a.rows() == a.cols() && a.cols() == t.rows());
    let n = t.cols();
    let products = RowProducts {
        columns: &t.transpose_view().to_csr(),
        a,
        t,
    };
    let memory = || (Accumulator::new(n), Accumulator::new(n));
    let length = |i: usize, (row, _): &mut (Accumulator, Accumulator)| {
        products.pattern(i, row);
        row.pattern.len()
    };
    let whole = from_rows((n, n), memory, length, |i, (row, part), indices, data| {
        products.row(i, row, part);
        for ((index, value), &column) in indices.iter_mut().zip(data).zip(&row.pattern) {
            (*index, *value) = (column, row.values[column]);
        }
    });
    symmetric_part(whole)
}

/// Whether `t^T a t` is `a`, for matrices as in [`congruence`]: no entry `ij` differs by more than `tolerance` times the root of the product of the
/// entries `ii` and `jj` of `a`. It is not formed.
///
/// # Panics
/// If the shapes do not fit.
pub fn is_kept_by(t: &CsMat<f64>, a: &CsMat<f64>, tolerance: f64) -> bool {
    assert!(t.is_csr() && a.is_csr() && a.rows() == a.cols() && a.cols() == t.rows() && t.cols() == t.rows());
    let n = t.cols();
    let columns = &t.transpose_view().to_csr();
    let products = RowProducts { columns, a, t };
    let own: Vec<f64> = diagonal(a).into_iter().map(|value| value.max(0.0).sqrt()).collect();
    let memory = || (Accumulator::new(n), Accumulator::new(n));
    let rows = (0..n).into_par_iter().with_min_len(GROUP);
    rows.map_init(memory, |(row, part), i| {
        products.row(i, row, part);
        entries(a, i).for_each(|(j, value)| row.add(j, -value));
        // Also false for NaN.
        row.pattern
            .iter()
            .all(|&j| row.values[j].abs() <= tolerance * own[i] * own[j])
    })
    .all(|is_kept| is_kept)
}

/// The matrix whose row `i` has `length(i)` entries, which `fill` writes with ascending columns, in parallel over groups of
/// rows; each thread has a `memory` of its own.
///
/// The size of the result is found first: lists that grow would hold it twice.
pub(crate) fn from_rows<Memory>(
    shape: (usize, usize),
    memory: impl Fn() -> Memory + Sync + Send,
    length: impl Fn(usize, &mut Memory) -> usize + Sync + Send,
    fill: impl Fn(usize, &mut Memory, &mut [usize], &mut [f64]) + Sync + Send,
) -> CsMat<f64> {
    let n = shape.0;
    let mut indptr = vec![0; n + 1];
    let lengths = indptr[1..].par_chunks_mut(GROUP).enumerate();
    lengths.for_each_init(&memory, |memory, (group, lengths)| {
        for (i, count) in lengths.iter_mut().enumerate() {
            *count = length(group * GROUP + i, memory);
        }
    });
    for i in 0..n {
        indptr[i + 1] += indptr[i];
    }
    let (mut indices, mut data) = (vec![0; indptr[n]], vec![0.0; indptr[n]]);
    let (mut rest, mut groups) = ((indices.as_mut_slice(), data.as_mut_slice()), Vec::new());
    for first in (0..n).step_by(GROUP) {
        let count = indptr[n.min(first + GROUP)] - indptr[first];
        let (indices, data) = (rest.0.split_at_mut(count), rest.1.split_at_mut(count));
        groups.push((first, indices.0, data.0));
        rest = (indices.1, data.1);
    }
    let groups = groups.into_par_iter();
    groups.for_each_init(&memory, |memory, (first, indices, data)| {
        for i in first..n.min(first + GROUP) {
            let own = indptr[i] - indptr[first]..indptr[i + 1] - indptr[first];
            fill(i, memory, &mut indices[own.clone()], &mut data[own]);
        }
    });
    CsMat::new(shape, indptr, indices, data)
}

/// As [`from_rows`] from the entries of each row in any order.
pub(crate) fn from_unsorted_rows<I: Iterator<Item = (usize, f64)>>(
    shape: (usize, usize),
    row: impl Fn(usize) -> I + Sync + Send,
) -> CsMat<f64> {
    let length = |i: usize, _: &mut Vec<(usize, f64)>| row(i).count();
    from_rows(shape, Vec::new, length, |i, line, indices, data| {
        line.clear();
        line.extend(row(i));
        line.sort_unstable_by_key(|(column, _)| *column);
        for ((index, value), entry) in indices.iter_mut().zip(data).zip(line) {
            (*index, *value) = *entry;
        }
    })
}

/// `a + factor b` of matrices in compressed rows.
///
/// # Panics
/// If the shapes do not fit.
pub fn sum(a: &CsMat<f64>, factor: f64, b: &CsMat<f64>) -> CsMat<f64> {
    assert!(a.is_csr() && b.is_csr() && a.shape() == b.shape());
    let merged = |i: usize| {
        let (mut left, mut right) = (entries(a, i).peekable(), entries(b, i).peekable());
        std::iter::from_fn(move || match (left.peek().copied(), right.peek().copied()) {
            (Some((j, value)), Some((k, other))) if j == k => {
                left.next();
                right.next();
                Some((j, value + factor * other))
            }
            (Some((j, _)), Some((k, other))) if k < j => right.next().map(|_| (k, factor * other)),
            (None, Some((k, other))) => right.next().map(|_| (k, factor * other)),
            _ => left.next(),
        })
    };
    let length = |i: usize, _: &mut ()| merged(i).count();
    from_rows(
        a.shape(),
        || (),
        length,
        |i, _, indices, data| {
            for ((index, value), entry) in indices.iter_mut().zip(data).zip(merged(i)) {
                (*index, *value) = entry;
            }
        },
    )
}

/// Rows of `t^T a t`.
struct RowProducts<'a> {
    /// `t^T`.
    columns: &'a CsMat<f64>,
    a: &'a CsMat<f64>,
    t: &'a CsMat<f64>,
}

/// One sparse row under way.
struct Accumulator {
    /// Columns that are not zero; ascending once the row is complete.
    pattern: Vec<usize>,
    /// The number of the row that a column was last in.
    stamps: Vec<usize>,
    stamp: usize,
    values: Vec<f64>,
}

impl Accumulator {
    fn new(n: usize) -> Self {
        Self {
            pattern: Vec::new(),
            stamps: vec![0; n],
            stamp: 0,
            values: vec![0.0; n],
        }
    }

    fn clear(&mut self) {
        self.pattern.clear();
        self.stamp += 1;
    }

    fn touch(&mut self, column: usize) {
        if self.stamps[column] != self.stamp {
            self.stamps[column] = self.stamp;
            self.values[column] = 0.0;
            self.pattern.push(column);
        }
    }

    fn add(&mut self, column: usize, value: f64) {
        self.touch(column);
        self.values[column] += value;
    }
}

impl RowProducts<'_> {
    /// The columns of row `i`, in any order.
    fn pattern(&self, i: usize, row: &mut Accumulator) {
        row.clear();
        for (k, _) in entries(self.columns, i) {
            for (j, _) in entries(self.a, k) {
                entries(self.t, j).for_each(|(column, _)| row.touch(column));
            }
        }
    }

    /// Row `i`; `part` is memory for a row of `a t`.
    fn row(&self, i: usize, row: &mut Accumulator, part: &mut Accumulator) {
        row.clear();
        for (k, factor) in entries(self.columns, i) {
            part.clear();
            for (j, value) in entries(self.a, k) {
                entries(self.t, j).for_each(|(column, coefficient)| part.add(column, value * coefficient));
            }
            for &column in &part.pattern {
                row.add(column, factor * part.values[column]);
            }
        }
        row.pattern.sort_unstable();
    }
}

/// Columns and values of a row.
pub(crate) fn entries(a: &CsMat<f64>, row: usize) -> impl Iterator<Item = (usize, f64)> {
    let range = a.indptr().outer_inds_sz(row);
    a.indices()[range.clone()]
        .iter()
        .copied()
        .zip(a.data()[range].iter().copied())
}

/// `(a + a^T) / 2` of a square matrix in compressed rows.
///
/// # Panics
/// If the matrix is not of that kind.
pub fn symmetric_part(a: CsMat<f64>) -> CsMat<f64> {
    assert!(a.is_csr() && a.rows() == a.cols());
    let shape = a.shape();
    let (indptr, indices, mut data) = a.into_raw_storage();
    let is_done = average_mirrored(&indptr, &indices, &mut data);
    let a = CsMat::new(shape, indptr, indices, data);
    if is_done {
        return a;
    }
    let transposed: CsMat<f64> = a.transpose_view().to_csr();
    (&a + &transposed).map(|value| 0.5 * value)
}

/// Replaces mirrored entries of sorted compressed rows by their mean; false, with some of them replaced, if an entry has no
/// mirror image.
fn average_mirrored(indptr: &[usize], indices: &[usize], data: &mut [f64]) -> bool {
    let n = indptr.len() - 1;
    // The first entry of each row whose mirror image was not met yet.
    let mut next = indptr[..n].to_vec();
    for row in 0..n {
        let end = indptr[row + 1];
        // Rows before this one have met all entries before the diagonal.
        if next[row] < end && indices[next[row]] < row {
            return false;
        }
        for at in next[row]..end {
            let column = indices[at];
            let mirrored = next[column];
            if mirrored == indptr[column + 1] || indices[mirrored] != row {
                return false;
            }
            let mean = 0.5 * (data[at] + data[mirrored]);
            (data[at], data[mirrored]) = (mean, mean);
            next[column] += 1;
        }
    }
    true
}

/// The block of `a` with the given rows and columns, where `column_of[j]` is the new number of column `j`, if kept.
pub fn submatrix(a: &CsMat<f64>, rows: &[usize], column_of: &[Option<usize>], n_columns: usize) -> CsMat<f64> {
    from_unsorted_rows((rows.len(), n_columns), |i| {
        entries(a, rows[i]).filter_map(|(j, v)| Some((column_of[j]?, v)))
    })
}

/// Numbers a selection of indices: `Some(position)` for the selected, `None` for the rest.
pub fn numbering(selection: &[usize], n: usize) -> Vec<Option<usize>> {
    let mut number = vec![None; n];
    for (position, &index) in selection.iter().enumerate() {
        number[index] = Some(position);
    }
    number
}

/// The diagonal.
pub fn diagonal(a: &CsMat<f64>) -> Vec<f64> {
    (0..a.rows()).map(|i| a.get(i, i).copied().unwrap_or(0.0)).collect()
}
