//! Writing of variables.

use std::collections::BTreeMap;

use super::layout::{
    CHAR_CLASS, DOUBLE, DOUBLE_CLASS, INT8, INT32, INT64, INT64_CLASS, MATRIX, NAME_LENGTH, SPARSE_CLASS, UINT32, UTF8,
};
use crate::value::Array;
use crate::{Error, writing};

/// A plain file of level 5 with the arrays as variables: double precision, sparse, 64-bit integers, text.
///
/// # Errors
/// [`Error::Unwritable`] for names that MATLAB does not allow, entries that are not finite, and more than 2 GiB in one
/// variable.
pub fn to_bytes(arrays: &BTreeMap<String, Array>) -> Result<Vec<u8>, Error> {
    let mut out = format!("{:<116}", "MATLAB 5.0 MAT-file").into_bytes();
    out.extend([0; 8]);
    out.extend([0, 1, b'I', b'M']);
    for (name, array) in arrays {
        let letters = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if !letters || !name.starts_with(|c: char| c.is_ascii_alphabetic()) || name.len() > NAME_LENGTH {
            let remedy = "begin with a letter and use letters, digits and underscores, 63 at most";
            return Err(writing::unwritable(name, "MATLAB allows no such name", remedy));
        }
        writing::finite(name, array)?;
        let body = variable(name, array).ok_or_else(|| {
            writing::unwritable(
                name,
                "it takes more than 2 GiB or 2^31 rows",
                "write it in another format",
            )
        })?;
        element(&mut out, MATRIX, &body)
            .ok_or_else(|| writing::unwritable(name, "it takes more than 2 GiB", "write it in another format"))?;
    }
    Ok(out)
}

/// The inside of an array's element; `None` if the format has no room for it.
fn variable(name: &str, array: &Array) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    let mut head = |class: u32, reserved: usize, rows: usize, columns: usize| {
        let flags = [class, u32::try_from(reserved).ok()?];
        element(&mut out, UINT32, &flags.map(u32::to_le_bytes).concat())?;
        element(&mut out, INT32, &indices([rows, columns].into_iter())?)?;
        element(&mut out, INT8, name.as_bytes())
    };
    match array {
        Array::Dense(m) => {
            head(DOUBLE_CLASS, 0, m.rows(), m.columns())?;
            element(&mut out, DOUBLE, &bytes(m.data(), |v| v.to_le_bytes()))?;
        }
        Array::Integers(m) => {
            head(INT64_CLASS, 0, m.rows(), m.columns())?;
            element(&mut out, INT64, &bytes(m.data(), |v| v.to_le_bytes()))?;
        }
        Array::Sparse(m) => {
            let m = m.to_csc();
            head(SPARSE_CLASS, m.nnz().max(1), m.rows(), m.cols())?;
            element(&mut out, INT32, &indices(m.indices().iter().copied())?)?;
            element(&mut out, INT32, &indices(m.indptr().raw_storage().iter().copied())?)?;
            element(&mut out, DOUBLE, &bytes(m.data(), |v| v.to_le_bytes()))?;
        }
        Array::Text(text) => {
            // In UTF-8, which SciPy and Octave read too; MATLAB counts units of UTF-16.
            let units = text.encode_utf16().count();
            head(CHAR_CLASS, 0, usize::from(units > 0), units)?;
            element(&mut out, UTF8, text.as_bytes())?;
        }
    }
    Some(out)
}

fn bytes<T: Copy, const N: usize>(values: &[T], to: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|v| to(*v)).collect()
}

fn indices(values: impl Iterator<Item = usize>) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    for value in values {
        out.extend(i32::try_from(value).ok()?.to_le_bytes());
    }
    Some(out)
}

fn element(out: &mut Vec<u8>, kind: u32, data: &[u8]) -> Option<()> {
    let size = i32::try_from(data.len()).ok()?;
    out.extend(kind.to_le_bytes());
    out.extend(size.to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
    Some(())
}
