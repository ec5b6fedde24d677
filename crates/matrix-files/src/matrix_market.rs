//! Matrix Market exchange files (`.mtx`, `.mm`): one matrix or vector as text.
//!
//! Layout: R. F. Boisvert, R. Pozo, K. A. Remington, *The Matrix Market Exchange Formats: Initial Design*, NISTIR 5935,
//! 1996. A banner, comments, a line of sizes, then one entry per line: `row column value` for sparse matrices, values
//! column by column for full ones; of symmetric matrices only one triangle.

use std::fmt::Write as _;
use std::path::Path;

use sprs::CsMat;

use crate::text::{self, Line};
use crate::triplets::{self, Entry, Origin};
use crate::value::{Array, Dense, plausible};
use crate::{Error, writing};
use file_io::{Source, quoted};

/// Reads the file at `path`.
///
/// # Errors
/// [`Error::File`], and those of [`parse`].
pub fn read(path: &Path) -> Result<Array, Error> {
    text::read(path, parse)
}

/// Reads a matrix: [`Array::Sparse`] from coordinates, [`Array::Dense`] or [`Array::Integers`] from arrays.
///
/// Symmetric matrices come out with both triangles. A place given twice is refused: the format does not say that
/// entries add up.
///
/// # Errors
/// [`Error::Malformed`], [`Error::Unsupported`] for pattern, complex, Hermitian and skew-symmetric matrices,
/// [`Error::Oversized`], [`Error::OutOfRange`], [`Error::NotFinite`], [`Error::Duplicate`], [`Error::Asymmetric`].
pub fn parse(source: Source<'_>) -> Result<Array, Error> {
    let mut lines = text::lines(source);
    let end = Line {
        file: source.name,
        number: source.bytes.split(|b| *b == b'\n').count(),
        text: b"",
    };
    let banner = Banner::parse(lines.next().unwrap_or(end))?;
    let mut lines = lines.filter(|line| !line.text.is_empty() && !line.text.starts_with(b"%"));
    let sizes = lines
        .next()
        .ok_or_else(|| end.malformed("the end of the file", "the line of sizes"))?;
    let body = Body {
        source,
        lines,
        sizes,
        end,
    };
    if banner.sparse {
        body.coordinates(&banner)
    } else if banner.integer {
        let (rows, columns, data) = body.array(&banner, |line, token| line.integer(token, "an integer"))?;
        Ok(Array::Integers(Dense::try_new(rows, columns, data)?))
    } else {
        let (rows, columns, data) = body.array(&banner, |line, token| line.real(token))?;
        Ok(Array::Dense(Dense::try_new(rows, columns, data)?))
    }
}

struct Banner {
    sparse: bool,
    integer: bool,
    symmetric: bool,
}

impl Banner {
    fn parse(line: Line<'_>) -> Result<Self, Error> {
        const EXPECTED: &str = "`%%MatrixMarket matrix coordinate|array real|integer general|symmetric`";
        let text = line.text.to_ascii_lowercase();
        let words: Vec<&[u8]> = text
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty())
            .take(6)
            .collect();
        let &[b"%%matrixmarket", b"matrix", layout, field, symmetry] = &words[..] else {
            return Err(line.malformed(quoted(line.text), EXPECTED));
        };
        let sparse = match layout {
            b"coordinate" => true,
            b"array" => false,
            _ => return Err(line.malformed(quoted(layout), EXPECTED)),
        };
        let integer = match field {
            b"real" | b"double" => false,
            b"integer" => true,
            b"pattern" => return Err(line.unsupported("a matrix without values", "write it with the field `real`")),
            b"complex" => return Err(line.unsupported("a complex matrix", "write its real part")),
            _ => return Err(line.malformed(quoted(field), EXPECTED)),
        };
        let symmetric = match symmetry {
            b"general" => false,
            b"symmetric" => true,
            b"hermitian" | b"skew-symmetric" => {
                return Err(line.unsupported("a Hermitian or skew-symmetric matrix", "write all entries as `general`"));
            }
            _ => return Err(line.malformed(quoted(symmetry), EXPECTED)),
        };
        Ok(Self {
            sparse,
            integer,
            symmetric,
        })
    }
}

/// What follows the banner.
struct Body<'a, I> {
    source: Source<'a>,
    lines: I,
    sizes: Line<'a>,
    end: Line<'a>,
}

impl<'a, I: Iterator<Item = Line<'a>>> Body<'a, I> {
    fn square(&self, rows: usize, columns: usize, banner: &Banner) -> Result<(), Error> {
        if banner.symmetric && rows != columns {
            let found = format!("a symmetric matrix of {rows} rows and {columns} columns");
            return Err(self.sizes.malformed(found, "as many rows as columns"));
        }
        Ok(())
    }

    fn coordinates(mut self, banner: &Banner) -> Result<Array, Error> {
        let fields = self.sizes.fields::<3>("rows, columns and the number of entries")?;
        let mut sizes = [0; 3];
        for (size, field) in sizes.iter_mut().zip(fields) {
            *size = self.sizes.integer(field, "a size")?;
        }
        let [rows, columns, count] = sizes;
        self.square(rows, columns, banner)?;
        plausible(rows, columns, self.source.bytes.len()).map_err(|(stated, possible)| {
            self.sizes
                .oversized("the number of rows or columns", stated as u128, possible)
        })?;
        // `1 1 1` and the end of the line.
        let possible = self.source.bytes.len() / 6;
        if count > possible {
            return Err(self.sizes.oversized("the number of entries", count as u128, possible));
        }
        let mut entries = Vec::with_capacity(count);
        for line in self.lines.by_ref().take(count) {
            let [row, column, value] = line.fields("row, column and value")?;
            let value = if banner.integer {
                exact(&line, value)?
            } else {
                line.real(value)?
            };
            entries.push(Entry {
                row: line.index(row, "row", rows)?,
                column: line.index(column, "column", columns)?,
                value,
                at: line.number,
            });
        }
        let found = entries.len();
        if found < count {
            return Err(self
                .end
                .malformed(format!("{found} entries"), format!("{count} as stated")));
        }
        self.finish(count)?;
        let matrix = if banner.symmetric {
            triplets::symmetric(Origin::lines(self.source.name), rows, entries, false)?
        } else {
            triplets::general(Origin::lines(self.source.name), (rows, columns), entries)?
        };
        Ok(Array::Sparse(matrix))
    }

    /// Rows, columns and all entries by columns.
    fn array<T: Copy + Default>(
        mut self,
        banner: &Banner,
        value: impl Fn(&Line<'_>, &[u8]) -> Result<T, Error>,
    ) -> Result<(usize, usize, Vec<T>), Error> {
        let [rows, columns] = self.sizes.fields("rows and columns")?;
        let rows: usize = self.sizes.integer(rows, "a size")?;
        let columns: usize = self.sizes.integer(columns, "a size")?;
        self.square(rows, columns, banner)?;
        let stated = if banner.symmetric {
            rows as u128 * (rows as u128 + 1) / 2
        } else {
            rows as u128 * columns as u128
        };
        // A digit and the end of the line.
        let possible = self.source.bytes.len() / 2;
        let count = usize::try_from(stated).ok().filter(|count| *count <= possible);
        let count = count.ok_or_else(|| self.sizes.oversized("the number of entries", stated, possible))?;
        let mut values = Vec::with_capacity(count);
        for line in self.lines.by_ref().take(count) {
            let [token] = line.fields("one value")?;
            values.push(value(&line, token)?);
        }
        let found = values.len();
        if found < count {
            return Err(self
                .end
                .malformed(format!("{found} entries"), format!("{count} as stated")));
        }
        self.finish(count)?;
        if banner.symmetric {
            let mut lower = values.into_iter();
            let mut full = vec![T::default(); rows * rows];
            for j in 0..rows {
                for (i, v) in (j..rows).zip(&mut lower) {
                    full[i + j * rows] = v;
                    full[j + i * rows] = v;
                }
            }
            values = full;
        }
        Ok((rows, columns, values))
    }

    fn finish(&mut self, count: usize) -> Result<(), Error> {
        match self.lines.next() {
            None => Ok(()),
            Some(line) => Err(line.malformed(quoted(line.text), format!("the end after {count} entries"))),
        }
    }
}

/// An integer as a real number that is the same.
fn exact(line: &Line<'_>, token: &[u8]) -> Result<f64, Error> {
    let value: i64 = line.integer(token, "an integer")?;
    if value.unsigned_abs() > 1 << f64::MANTISSA_DIGITS {
        return Err(line.unsupported(
            quoted(token),
            "sparse integers beyond 2^53 have no exact value: write them as `real`",
        ));
    }
    Ok(value as f64)
}

/// The file of one array. Square matrices that are exactly symmetric are written as such.
///
/// # Errors
/// [`Error::Unwritable`] for text and for entries that are not finite.
pub fn to_bytes(array: &Array) -> Result<Vec<u8>, Error> {
    const NAME: &str = "matrix";
    writing::finite(NAME, array)?;
    let mut out = String::from("%%MatrixMarket matrix ");
    match array {
        Array::Dense(m) => write_array(&mut out, "real", m, |v| format!("{v:e}")),
        Array::Integers(m) => write_array(&mut out, "integer", m, i64::to_string),
        Array::Sparse(m) => write_coordinates(&mut out, m),
        Array::Text(_) => {
            return Err(Error::Unwritable {
                name: NAME.into(),
                reason: "text has no place in a Matrix Market file".into(),
                remedy: "write numbers only",
            });
        }
    }
    Ok(out.into_bytes())
}

fn write_array<T: Copy + PartialEq>(out: &mut String, field: &str, m: &Dense<T>, shown: impl Fn(&T) -> String) {
    let (rows, columns) = (m.rows(), m.columns());
    let symmetric = rows == columns && rows > 0 && (0..rows).all(|j| (0..j).all(|i| m[(i, j)] == m[(j, i)]));
    let kind = if symmetric { "symmetric" } else { "general" };
    // Writing into a string cannot fail.
    let _ = writeln!(out, "array {field} {kind}\n{rows} {columns}");
    for j in 0..columns {
        for i in if symmetric { j } else { 0 }..rows {
            let _ = writeln!(out, "{}", shown(&m[(i, j)]));
        }
    }
}

fn write_coordinates(out: &mut String, m: &CsMat<f64>) {
    let symmetric = writing::is_symmetric(m);
    let kind = if symmetric { "symmetric" } else { "general" };
    let kept = || m.iter().filter(|(_, (i, j))| !symmetric || i >= j);
    let count = kept().count();
    let _ = writeln!(out, "coordinate real {kind}\n{} {} {count}", m.rows(), m.cols());
    for (value, (row, column)) in kept() {
        let _ = writeln!(out, "{} {} {value:e}", row + 1, column + 1);
    }
}
