//! Operations on compressed sparse row matrices that the sparse container lacks: blocked products and submatrices.

use faer::{MatMut, MatRef};
use rayon::prelude::*;
use sprs::CsMat;

/// Columns handled together, so that each matrix entry is loaded once for all of them.
const LANES: usize = 8;

/// `y = a * x` for a compressed-row matrix and dense columns, in parallel over groups of columns.
///
/// The order of every sum is fixed, so the result does not depend on the number of threads.
///
/// # Panics
/// If the shapes do not fit.
pub fn multiply_into(a: &CsMat<f64>, x: MatRef<'_, f64>, y: MatMut<'_, f64>) {
    assert!(a.is_csr() && a.cols() == x.nrows() && a.rows() == y.nrows() && x.ncols() == y.ncols());
    let groups: Vec<_> = y.par_col_chunks_mut(LANES).collect::<Vec<_>>();
    groups.into_par_iter().enumerate().for_each(|(group, mut out)| {
        let width = out.ncols();
        let columns = x.subcols(group * LANES, width);
        let mut packed = vec![[0.0; LANES]; a.cols()];
        for lane in 0..width {
            for (slot, value) in packed.iter_mut().zip(columns.col(lane).iter()) {
                slot[lane] = *value;
            }
        }
        for (row, entries) in a.outer_iterator().enumerate() {
            let mut sum = [0.0; LANES];
            for (column, value) in entries.iter() {
                let lanes = &packed[column];
                for lane in 0..LANES {
                    sum[lane] += value * lanes[lane];
                }
            }
            for lane in 0..width {
                out[(row, lane)] = sum[lane];
            }
        }
    });
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

/// The congruence `t^T a t` of a symmetric compressed-row matrix, exactly symmetric.
pub fn congruence(t: &CsMat<f64>, a: &CsMat<f64>) -> CsMat<f64> {
    let at = a * t;
    let result: CsMat<f64> = &t.transpose_view().to_csr() * &at;
    symmetric_part(result)
}

/// `(a + a^T) / 2` of a matrix with a symmetric pattern, in sorted compressed rows.
pub fn symmetric_part(a: CsMat<f64>) -> CsMat<f64> {
    let transposed: CsMat<f64> = a.transpose_view().to_csr();
    (&a + &transposed).map(|value| 0.5 * value)
}

/// The block of `a` with the given rows and columns, where `column_of[j]` is the new number of column `j`, if kept.
pub fn submatrix(a: &CsMat<f64>, rows: &[usize], column_of: &[Option<usize>], n_columns: usize) -> CsMat<f64> {
    let mut indptr = Vec::with_capacity(rows.len() + 1);
    let (mut indices, mut data) = (Vec::new(), Vec::new());
    indptr.push(0);
    let mut line: Vec<(usize, f64)> = Vec::new();
    for &row in rows {
        let range = a.indptr().outer_inds_sz(row);
        line.clear();
        line.extend(
            a.indices()[range.clone()]
                .iter()
                .zip(&a.data()[range])
                .filter_map(|(&j, &v)| Some((column_of[j]?, v))),
        );
        line.sort_unstable_by_key(|(column, _)| *column);
        indices.extend(line.iter().map(|(column, _)| *column));
        data.extend(line.iter().map(|(_, value)| *value));
        indptr.push(indices.len());
    }
    CsMat::new((rows.len(), n_columns), indptr, indices, data)
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
