//! Orthonormal bases of the spaces that columns span.

use faer::{Mat, MatRef};

/// What is left of a direction beside a basis, relative to it, that counts as round-off.
pub(crate) const DEPENDENT: f64 = 1e-13;

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
pub(crate) fn extended_basis(basis: &Mat<f64>, more: MatRef<'_, f64>, least: &[f64]) -> Mat<f64> {
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

/// The sum of the products of two lists, in several sums that the processor adds up at once.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    const SUMS: usize = 16;
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<SUMS>(), b.as_chunks::<SUMS>());
    let mut sums = [0.0; SUMS];
    for (a, b) in a.iter().zip(b) {
        for i in 0..SUMS {
            sums[i] += a[i] * b[i];
        }
    }
    sums.into_iter().sum::<f64>() + crate::dot(a_rest, b_rest)
}
