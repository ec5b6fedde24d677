//! Matrices of Python as sparse rows, and what is asked of them.

use crate::arrays::{check_shape, readable, slice, tuple};
use crate::error::{Exception, input};
use faer::Mat;
use finite_elements::factor::SparseCholesky;
use finite_elements::sparse::{diagonal, sum, symmetric_part};
use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use sprs::{CsMat, TriMat};

/// Relative to the diagonal, by how much mirrored entries may differ.
const ROUND_OFF: f64 = 1e-6;

/// Relative to the largest entry of the diagonal, what makes a semi-definite matrix definite.
const SEMI_DEFINITE: f64 = 1e-10;

/// A matrix: an array of two dimensions, or shape, row starts, columns and values of compressed rows.
///
/// # Errors
/// `InputError` for anything else, and values that are not finite.
pub(super) fn matrix(name: &str, value: &Bound<'_, PyAny>) -> Result<CsMat<f64>, Exception> {
    let matrix = match value.cast::<PyTuple>() {
        Ok(parts) => compressed(name, parts)?,
        Err(_) => {
            let array = readable::<f64, numpy::Ix2>(name, value)?;
            let array = array.as_array();
            let mut triplets = TriMat::new((array.shape()[0], array.shape()[1]));
            for ((row, column), &value) in array.indexed_iter() {
                if value != 0.0 {
                    triplets.add_triplet(row, column, value);
                }
            }
            triplets.to_csr()
        }
    };
    if let Some((value, (row, column))) = matrix.iter().find(|(value, _)| !value.is_finite()) {
        return Err(input(format!("{name}[{row}, {column}] is {value}; it must be finite")));
    }
    Ok(matrix)
}

fn compressed(name: &str, parts: &Bound<'_, PyTuple>) -> Result<CsMat<f64>, Exception> {
    let broken = |what: &str| input(format!("{name} is no matrix in compressed rows: {what}"));
    type Parts<'py> = ((usize, usize), Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);
    let (shape, starts, columns, values): Parts<'_> = parts
        .extract()
        .map_err(|_| broken("shape, indptr, indices and data are needed"))?;
    let numbers = |part: &Bound<'_, PyAny>| -> Result<Vec<usize>, Exception> {
        let array = readable::<i64, numpy::Ix1>(name, part)?;
        let number = |&i: &i64| usize::try_from(i).map_err(|_| broken("it has a negative index"));
        slice(name, &array)?.iter().map(number).collect()
    };
    let (starts, columns) = (numbers(&starts)?, numbers(&columns)?);
    let values = readable::<f64, numpy::Ix1>(name, &values)?;
    let values = slice(name, &values)?.to_vec();
    CsMat::try_new(shape, starts, columns, values).map_err(|(.., error)| broken(&error.to_string()))
}

/// A symmetric and semi-definite matrix of `size` rows, or of any size.
///
/// # Errors
/// `InputError` with what was found.
pub(super) fn semi_definite(
    name: &'static str,
    value: &Bound<'_, PyAny>,
    size: Option<usize>,
) -> Result<CsMat<f64>, Exception> {
    let matrix = matrix(name, value)?;
    let (rows, columns) = matrix.shape();
    match size {
        Some(size) => check_shape(name, &[rows, columns], &[size, size])?,
        None if rows != columns || rows == 0 => {
            let shape = tuple(&[rows, columns]);
            return Err(input(format!(
                "{name} has the shape {shape}, but a square matrix is needed"
            )));
        }
        None => {}
    }
    let transposed: CsMat<f64> = matrix.transpose_view().to_csr();
    let own = diagonal(&matrix);
    let differences = sum(&matrix, -1.0, &transposed);
    let is_large = |value: f64, i: usize, j: usize| !(value.abs() <= ROUND_OFF * (own[i].abs() * own[j].abs()).sqrt());
    if let Some((value, (i, j))) = differences.iter().find(|(value, (i, j))| is_large(**value, *i, *j)) {
        return Err(input(format!(
            "{name} is not symmetric: the entries [{i}, {j}] and [{j}, {i}] differ by {value:.3e}"
        )));
    }
    let matrix = symmetric_part(matrix);
    let largest = own.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    if !(largest > 0.0) {
        return Err(input(format!("{name} is zero; it must have entries on its diagonal")));
    }
    let shifted = sum(&matrix, SEMI_DEFINITE * largest, &CsMat::eye(rows));
    if let Err(error) = SparseCholesky::try_new(&shifted, &vec![[0.0; 3]; rows], name) {
        return Err(input(format!(
            "{name} is indefinite; it must be positive semi-definite, without negative eigenvalues ({error})"
        )));
    }
    Ok(matrix)
}

/// Rows over `columns` coordinates.
///
/// # Errors
/// `InputError` for another shape and values that are not finite.
pub(super) fn vectors(name: &str, value: &Bound<'_, PyAny>, columns: usize) -> Result<Vec<Vec<f64>>, Exception> {
    let array = readable::<f64, numpy::Ix2>(name, value)?;
    check_shape(name, array.shape(), &[array.shape()[0], columns])?;
    let array = array.as_array();
    if let Some(((row, column), value)) = array.indexed_iter().find(|(_, value)| !value.is_finite()) {
        return Err(input(format!("{name}[{row}, {column}] is {value}; it must be finite")));
    }
    Ok(array.rows().into_iter().map(|row| row.to_vec()).collect())
}

/// One number for each of `count` points, or one for all.
///
/// # Errors
/// `InputError` for another number of them.
pub(super) fn per_point(name: &str, value: &Bound<'_, PyAny>, count: usize) -> Result<Vec<f64>, Exception> {
    let array = readable::<f64, numpy::Ix1>(name, value)?;
    let values = slice(name, &array)?;
    if values.len() == 1 {
        return Ok(vec![values[0]; count]);
    }
    check_shape(name, &[values.len()], &[count])?;
    Ok(values.to_vec())
}

/// The whole matrix.
pub(super) fn full(matrix: &CsMat<f64>) -> Mat<f64> {
    let mut full = Mat::zeros(matrix.rows(), matrix.cols());
    for (value, (i, j)) in matrix.iter() {
        full[(i, j)] = *value;
    }
    full
}
