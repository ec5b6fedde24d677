//! What all writers check.

use sprs::CsMat;

use crate::Error;
use crate::value::Array;

/// Refuses entries that no reader would take back.
pub(crate) fn finite(name: &str, array: &Array) -> Result<(), Error> {
    let values = match array {
        Array::Dense(m) => m.data(),
        Array::Sparse(m) => m.data(),
        Array::Integers(_) | Array::Text(_) => &[],
    };
    finite_values(name, values)
}

/// Refuses entries that no reader would take back.
pub(crate) fn finite_values(name: &str, values: &[f64]) -> Result<(), Error> {
    match values.iter().find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(value) => Err(unwritable(
            name,
            format!("an entry is {value}"),
            "only finite numbers can be written; look for what made it",
        )),
    }
}

/// Whether a sparse matrix equals its transpose, pattern and values.
pub(crate) fn is_symmetric(m: &CsMat<f64>) -> bool {
    m.rows() == m.cols() && *m == m.transpose_view().to_other_storage()
}

/// What cannot be said in the format.
pub(crate) fn unwritable(name: &str, reason: impl Into<String>, remedy: &'static str) -> Error {
    Error::Unwritable {
        name: name.into(),
        reason: reason.into(),
        remedy,
    }
}

/// What [`is_nastran_name`] asks for.
pub(crate) const NASTRAN_NAME: &str = "begin with a letter and use letters and digits, 8 at most";

/// Whether Nastran allows the name of a matrix.
pub(crate) fn is_nastran_name(name: &str) -> bool {
    (1..=8).contains(&name.len())
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric())
}
