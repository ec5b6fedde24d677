//! Writing.

use std::collections::BTreeMap;

use sprs::CsMat;

use crate::value::{Array, Dense};
use crate::{Error, writing};

const SQUARE: i32 = 1;
const RECTANGULAR: i32 = 2;
const SYMMETRIC: i32 = 6;

/// Type of real numbers in double precision.
const DOUBLE: i32 = 2;

/// A binary file in double precision, lowest byte first: dense matrices as dense columns, sparse ones as strings with two
/// integers ahead, integers as reals.
///
/// # Errors
/// [`Error::Unwritable`] for names that Nastran does not allow, text, entries that are not finite, integers beyond 2^53,
/// and columns of 2 GiB or more.
pub fn to_bytes(arrays: &BTreeMap<String, Array>) -> Result<Vec<u8>, Error> {
    let mut out = Vec::new();
    for (name, array) in arrays {
        if !writing::is_nastran_name(name) {
            return Err(writing::unwritable(
                name,
                "Nastran allows no such name",
                writing::NASTRAN_NAME,
            ));
        }
        writing::finite(name, array)?;
        let written = match array {
            Array::Dense(m) => dense(&mut out, name, m),
            Array::Sparse(m) => sparse(&mut out, name, m),
            Array::Integers(m) => {
                if m.data().iter().any(|v| v.unsigned_abs() > 1 << f64::MANTISSA_DIGITS) {
                    let remedy = "write it in another format";
                    return Err(writing::unwritable(
                        name,
                        "it has integers that no real number equals",
                        remedy,
                    ));
                }
                let data = m.data().iter().map(|v| *v as f64).collect();
                dense(&mut out, name, &Dense::try_new(m.rows(), m.columns(), data)?)
            }
            Array::Text(_) => {
                let remedy = "write numbers only";
                return Err(writing::unwritable(name, "text has no place in this file", remedy));
            }
        };
        written.ok_or_else(|| {
            let remedy = "write it in another format";
            writing::unwritable(name, "a column takes more than 2 GiB, or it has 2^31 rows", remedy)
        })?;
    }
    Ok(out)
}

/// None if the format has no room for the matrix, here and below.
fn dense(out: &mut Vec<u8>, name: &str, m: &Dense<f64>) -> Option<()> {
    let (rows, columns) = (m.rows(), m.columns());
    let is_symmetric = rows == columns && (0..rows).all(|j| (0..j).all(|i| m[(i, j)] == m[(j, i)]));
    head(out, name, [rows, columns], is_symmetric, false)?;
    for (column, entries) in m.data().chunks(rows.max(1)).enumerate() {
        // By bits, so that zeros below zero stay.
        let is_given = |v: &f64| v.to_bits() != 0;
        let Some(first) = entries.iter().position(is_given) else {
            continue;
        };
        let last = entries.iter().rposition(is_given).unwrap_or(first);
        let body = bytes(&entries[first..=last]);
        let words = body.len() / 4;
        record(out, &[column + 1, first + 1, words], &body)?;
    }
    end(out, columns)
}

fn sparse(out: &mut Vec<u8>, name: &str, m: &CsMat<f64>) -> Option<()> {
    head(out, name, [m.rows(), m.cols()], writing::is_symmetric(m), true)?;
    let by_columns = m.to_csc();
    for (column, entries) in by_columns.outer_iterator().enumerate() {
        let mut body = Vec::new();
        let (rows, mut values) = (entries.indices(), entries.data());
        for string in rows.chunk_by(|a, b| a + 1 == *b) {
            let (here, rest) = values.split_at(string.len());
            values = rest;
            body.extend(integers(&[2 * string.len() + 1, string[0] + 1])?);
            body.extend(bytes(here));
        }
        if !body.is_empty() {
            let words = body.len() / 4;
            record(out, &[column + 1, 0, words], &body)?;
        }
    }
    end(out, m.cols())
}

fn head(out: &mut Vec<u8>, name: &str, [rows, columns]: [usize; 2], is_symmetric: bool, is_sparse: bool) -> Option<()> {
    let form = match rows == columns {
        true if is_symmetric => SYMMETRIC,
        true => SQUARE,
        false => RECTANGULAR,
    };
    let rows = i32::try_from(rows).ok()?;
    let numbers = [
        i32::try_from(columns).ok()?,
        if is_sparse { -rows } else { rows },
        form,
        DOUBLE,
    ];
    let mut body = numbers.map(i32::to_le_bytes).concat();
    body.extend(format!("{name:<8}").into_bytes());
    record(out, &[], &body)
}

/// The column beyond the last.
fn end(out: &mut Vec<u8>, columns: usize) -> Option<()> {
    record(out, &[columns + 1, 1, 2], &1_f64.to_le_bytes())
}

fn record(out: &mut Vec<u8>, numbers: &[usize], body: &[u8]) -> Option<()> {
    let numbers = integers(numbers)?;
    let length = i32::try_from(numbers.len() + body.len()).ok()?.to_le_bytes();
    out.extend([length.as_slice(), &numbers, body, &length].concat());
    Some(())
}

fn integers(values: &[usize]) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(4 * values.len());
    for value in values {
        out.extend(i32::try_from(*value).ok()?.to_le_bytes());
    }
    Some(out)
}

fn bytes(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}
