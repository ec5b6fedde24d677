//! Arrays of NumPy as slices and matrices.

use crate::error::{Exception, input};
use numpy::{
    Element, PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray, PyReadwriteArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

/// An array to be read; `name` is that of the argument.
///
/// # Errors
/// `InputError` for anything but an array of numbers of the right kind and dimension.
pub(crate) fn readable<'py, T: Element, D: numpy::ndarray::Dimension>(
    name: &str,
    value: &Bound<'py, PyAny>,
) -> Result<PyReadonlyArray<'py, T, D>, Exception> {
    let array = value
        .cast::<PyArray<T, D>>()
        .map_err(|_| input(format!("{name} is no array of the right type and number of dimensions")))?;
    array
        .try_readonly()
        .map_err(|_| input(format!("{name} is being written at the same time; give another array")))
}

/// An array of this shape to be written, contiguous in C order.
///
/// # Errors
/// `InputError` for anything else.
pub(crate) fn writable<'py, D: numpy::ndarray::Dimension>(
    name: &str,
    value: &Bound<'py, PyAny>,
    shape: &[usize],
) -> Result<PyReadwriteArray<'py, f64, D>, Exception> {
    let array = value
        .cast::<PyArray<f64, D>>()
        .map_err(|_| input(format!("{name} must be an array of float64 with the shape {shape:?}")))?;
    check_shape(name, array.shape(), shape)?;
    if !array.is_c_contiguous() {
        return Err(input(format!("{name} must be contiguous in C order")));
    }
    array.try_readwrite().map_err(|_| {
        input(format!(
            "{name} must be writable, and share no memory with other arguments"
        ))
    })
}

/// Compares shapes.
///
/// # Errors
/// `InputError` with both.
pub(crate) fn check_shape(name: &str, found: &[usize], expected: &[usize]) -> Result<(), Exception> {
    if found == expected {
        return Ok(());
    }
    Err(input(format!(
        "{name} has the shape {}, but {} is needed",
        tuple(found),
        tuple(expected)
    )))
}

/// A shape as Python writes it.
pub(crate) fn tuple(shape: &[usize]) -> String {
    match shape {
        [n] => format!("({n},)"),
        _ => {
            let numbers: Vec<String> = shape.iter().map(ToString::to_string).collect();
            format!("({})", numbers.join(", "))
        }
    }
}

/// The numbers of a contiguous array.
///
/// # Errors
/// `InputError` for arrays with gaps.
pub(crate) fn slice<'a, T: Element, D: numpy::ndarray::Dimension>(
    name: &str,
    array: &'a PyReadonlyArray<'_, T, D>,
) -> Result<&'a [T], Exception> {
    array
        .as_slice()
        .map_err(|_| input(format!("{name} must be contiguous in C order")))
}

/// A list of numbers.
pub(crate) fn list<'py>(py: Python<'py>, values: Vec<f64>) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_vec(py, values)
}

/// Rows of `columns` numbers.
///
/// # Errors
/// Of NumPy.
pub(crate) fn rows<'py>(py: Python<'py>, values: Vec<f64>, columns: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    PyArray1::from_vec(py, values).reshape([rows, columns])
}
