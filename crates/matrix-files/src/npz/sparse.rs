//! Sparse matrices, each of which is five arrays.

use std::collections::BTreeMap;

use sprs::CsMat;

use crate::Error;
use crate::triplets::{self, Entry};
use crate::value::{Array, plausible};
use file_io::{Place, Source};

/// Name of a sparse matrix that is alone in its file, as `scipy.sparse.save_npz` writes it and `load_npz` reads it.
pub const MATRIX: &str = "matrix";

/// Names of the arrays of a sparse matrix.
const PARTS: [&str; 5] = ["format", "shape", "indptr", "indices", "data"];

/// Puts sparse matrices together from their arrays.
pub(super) fn sparse_matrices(source: Source<'_>, arrays: &mut BTreeMap<String, Array>) -> Result<(), Error> {
    let prefix = |key: &String| match key.strip_suffix("format") {
        Some(prefix) if prefix.is_empty() || prefix.ends_with('.') => Some(prefix.to_owned()),
        _ => None,
    };
    let prefixes: Vec<String> = arrays.keys().filter_map(prefix).collect();
    for prefix in prefixes {
        let place = Place::Inside {
            part: format!("the sparse matrix `{}`", prefix.escape_debug()),
            byte: 0,
        };
        let of = |part: &str| format!("{prefix}{part}");
        if !matches!(arrays.get(&of("format")), Some(Array::Text(_))) || !arrays.contains_key(&of("shape")) {
            continue;
        }
        if PARTS.iter().any(|part| !arrays.contains_key(&of(part))) {
            return Err(Error::Unsupported {
                file: source.name.into(),
                place,
                found: "a sparse matrix in another format than csr and csc".into(),
                remedy: "convert it with `.tocsr()` before saving",
            });
        }
        let [format, shape, starts, indices, data] = PARTS.map(|part| arrays.remove(&of(part)));
        let sparse = Sparse {
            source,
            place,
            format,
            shape,
            starts,
            indices,
            data,
        };
        // Tells SciPy's arrays and matrices apart.
        arrays.remove(&of("_is_array"));
        let name = if prefix.is_empty() {
            MATRIX
        } else {
            prefix.trim_end_matches('.')
        };
        let matrix = Array::Sparse(sparse.assemble()?);
        if arrays.insert(name.into(), matrix).is_some() {
            return Err(Error::Malformed {
                file: source.name.into(),
                place: Place::Byte(0),
                found: format!("both a full and a sparse `{name}`"),
                expected: "each name once".into(),
            });
        }
    }
    Ok(())
}

/// The arrays of a sparse matrix.
struct Sparse<'a> {
    source: Source<'a>,
    place: Place,
    format: Option<Array>,
    shape: Option<Array>,
    starts: Option<Array>,
    indices: Option<Array>,
    data: Option<Array>,
}

impl Sparse<'_> {
    fn malformed(&self, found: impl std::fmt::Display, expected: impl std::fmt::Display) -> Error {
        Error::Malformed {
            file: self.source.name.into(),
            place: self.place.clone(),
            found: found.to_string(),
            expected: expected.to_string(),
        }
    }

    fn assemble(&self) -> Result<CsMat<f64>, Error> {
        let integers = |array: &Option<Array>, what| match array {
            Some(Array::Integers(m)) => {
                let sizes: Option<Vec<usize>> = m.data().iter().map(|v| usize::try_from(*v).ok()).collect();
                sizes.ok_or_else(|| self.malformed(format!("negative {what}"), "no negative number"))
            }
            _ => Err(self.malformed(format!("{what} that are no integers"), "integers")),
        };
        let by_rows = match &self.format {
            Some(Array::Text(text)) if text == "csr" => true,
            Some(Array::Text(text)) if text == "csc" => false,
            _ => {
                return Err(Error::Unsupported {
                    file: self.source.name.into(),
                    place: self.place.clone(),
                    found: "a sparse matrix in another format than csr and csc".into(),
                    remedy: "convert it with `.tocsr()` before saving",
                });
            }
        };
        let &[rows, columns] = &integers(&self.shape, "sizes")?[..] else {
            return Err(self.malformed("a shape", "the numbers of rows and columns"));
        };
        let real;
        let values = match &self.data {
            Some(Array::Dense(m)) => m.data(),
            Some(Array::Integers(m)) => {
                let exact = |v: &i64| (v.unsigned_abs() <= 1 << f64::MANTISSA_DIGITS).then_some(*v as f64);
                let values: Option<Vec<f64>> = m.data().iter().map(exact).collect();
                real = values.ok_or_else(|| self.malformed("an entry beyond 2^53", "exact numbers"))?;
                &real
            }
            _ => return Err(self.malformed("entries that are no numbers", "numbers")),
        };
        plausible(rows, columns, self.source.bytes.len()).map_err(|(stated, possible)| Error::Oversized {
            file: self.source.name.into(),
            place: self.place.clone(),
            what: "the number of rows or columns",
            stated: stated as u128,
            possible,
        })?;
        let starts = integers(&self.starts, "starts")?;
        let indices = integers(&self.indices, "indices")?;
        let (outer, inner) = if by_rows { (rows, columns) } else { (columns, rows) };
        let ascending = starts.is_sorted() && starts.first() == Some(&0) && starts.last() == Some(&indices.len());
        if starts.len() != outer + 1 || !ascending || indices.len() != values.len() {
            let found = format!(
                "{} starts, {} indices, {} entries",
                starts.len(),
                indices.len(),
                values.len()
            );
            return Err(self.malformed(
                found,
                format!("{} ascending starts for as many indices as entries", outer + 1),
            ));
        }
        let mut entries = Vec::with_capacity(values.len());
        for (line, range) in starts.windows(2).enumerate() {
            for at in range[0]..range[1] {
                let index = indices[at];
                if index >= inner {
                    return Err(Error::OutOfRange {
                        file: self.source.name.into(),
                        place: self.place.clone(),
                        what: "index (from zero)",
                        index: index as i128,
                        first: 0,
                        last: inner.saturating_sub(1),
                    });
                }
                let (row, column) = if by_rows { (line, index) } else { (index, line) };
                entries.push(Entry {
                    row,
                    column,
                    value: values[at],
                    at,
                });
            }
        }
        let matrix = triplets::summed((rows, columns), entries);
        match matrix.data().iter().find(|v| !v.is_finite()) {
            None => Ok(matrix),
            Some(&value) => Err(Error::NotFinite {
                file: self.source.name.into(),
                place: self.place.clone(),
                value,
            }),
        }
    }
}
