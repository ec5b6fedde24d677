//! Matrices as Nastran's files have them: a head, then columns of strings of entries in rows that follow one another.

use crate::Error;
use crate::value::{Array, Dense, plausible};
use file_io::Place;
use sprs::CsMat;
use std::ops::Range;

/// Most places of a dense matrix for each byte that it takes in the file.
const FILLED: usize = 4;

/// The head of a matrix.
pub(crate) struct Header {
    pub(crate) name: String,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) form: i64,
    pub(crate) is_double: bool,
    /// Rows were stated as a negative number: a sparse matrix, whose strings have two integers ahead.
    pub(crate) is_negative: bool,
    pub(crate) place: Place,
}

/// Where in a file a reader is.
pub(crate) trait Position {
    fn file(&self) -> &str;

    /// Place of what was read last.
    fn place(&self) -> Place;

    /// From columns, rows, form and type.
    fn head(&self, [columns, rows, form, kind]: [i64; 4], name: &[u8]) -> Result<Header, Error> {
        let name = self.checked_name(name)?;
        if matches!(kind, 3 | 4) {
            return Err(self.unsupported(format!("the complex matrix `{name}`"), "write its real part"));
        }
        let size = |stated: i64| {
            usize::try_from(stated.unsigned_abs()).map_err(|_| self.malformed(stated, "a number of rows or columns"))
        };
        if columns < 0 || !matches!(kind, 1 | 2) {
            let found = format!("{columns} columns of type {kind}");
            return Err(self.malformed(found, "a number of columns, and a type from 1 to 4"));
        }
        Ok(Header {
            name,
            rows: size(rows)?,
            columns: size(columns)?,
            form,
            is_double: kind == 2,
            is_negative: rows < 0,
            place: self.place(),
        })
    }

    /// The name of a matrix or block.
    fn checked_name(&self, words: &[u8]) -> Result<String, Error> {
        let name = text_of(words);
        match name.is_empty() || !name.chars().all(|c| c.is_ascii_graphic()) {
            true => Err(self.malformed(format!("the name `{}`", name.escape_debug()), "letters and digits")),
            false => Ok(name),
        }
    }

    fn malformed(&self, found: impl ToString, expected: impl ToString) -> Error {
        Error::Malformed {
            file: self.file().into(),
            place: self.place(),
            found: found.to_string(),
            expected: expected.to_string(),
        }
    }

    fn unsupported(&self, found: impl ToString, remedy: &'static str) -> Error {
        Error::Unsupported {
            file: self.file().into(),
            place: self.place(),
            found: found.to_string(),
            remedy,
        }
    }

    fn oversized(&self, what: &'static str, stated: u128, possible: usize) -> Error {
        Error::Oversized {
            file: self.file().into(),
            place: self.place(),
            what,
            stated,
            possible,
        }
    }

    /// Refuses rows or columns of a file of so many bytes that [`plausible`] does.
    fn check_size(&self, what: &'static str, size: usize, bytes: usize) -> Result<(), Error> {
        plausible(size, 0, bytes).map_err(|(stated, possible)| self.oversized(what, stated as u128, possible))
    }

    fn out_of_range(&self, what: &'static str, index: usize, last: usize) -> Error {
        Error::OutOfRange {
            file: self.file().into(),
            place: self.place(),
            what,
            index: index as i128,
            first: 1,
            last,
        }
    }
}

/// Words as text; machines with words of 64 bits leave blanks inside.
pub(crate) fn text_of(words: &[u8]) -> String {
    let kept = words.iter().filter(|b| !matches!(b, b' ' | 0));
    kept.map(|b| char::from(*b)).collect()
}

/// A matrix compressed by columns.
pub(crate) struct Columns {
    begins: Vec<usize>,
    pub(crate) rows: Vec<usize>,
    pub(crate) values: Vec<f64>,
    pub(crate) is_sparse: bool,
}

impl Columns {
    pub(crate) fn new(is_sparse: bool) -> Self {
        Self {
            begins: vec![0],
            rows: Vec::new(),
            values: Vec::new(),
            is_sparse,
        }
    }

    /// The column that comes next, from one.
    pub(crate) fn next(&self) -> usize {
        self.begins.len()
    }

    /// Leaves columns empty up to `column`, which comes next then.
    pub(crate) fn skip_to(&mut self, column: usize) {
        self.begins.resize(column, self.values.len());
    }

    /// Whether entries are left out within columns.
    pub(crate) fn has_gaps(&self, rows: usize) -> bool {
        let mut ends = self.begins.windows(2).map(|ends| &self.rows[ends[0]..ends[1]]);
        ends.any(|column| !column.is_empty() && column.len() < rows)
    }

    /// Rows, from zero, of `count` entries from `row` on, which counts from one.
    pub(crate) fn string(
        &self,
        at: &impl Position,
        header: &Header,
        row: usize,
        count: usize,
    ) -> Result<Range<usize>, Error> {
        let begin = self.begins.last().copied().unwrap_or(0);
        let before = self.rows[begin..].last().map_or(0, |row| row + 1);
        if row <= before {
            let expected = format!("rows that ascend, each once, here {} or later", before + 1);
            return Err(at.malformed(format!("row {row} of column {}", self.next()), expected));
        }
        let last = (row - 1).saturating_add(count);
        if last > header.rows {
            return Err(at.out_of_range("row", last, header.rows));
        }
        Ok(row - 1..last)
    }

    /// The matrix of `bytes` bytes of the file.
    pub(crate) fn array(self, at: &impl Position, header: &Header, bytes: usize) -> Result<Array, Error> {
        let (rows, columns) = (header.rows, header.columns);
        let malformed = |found: String, expected: &str| Error::Malformed {
            file: at.file().into(),
            place: header.place.clone(),
            found,
            expected: expected.into(),
        };
        let unsupported = |found: String, remedy| Error::Unsupported {
            file: at.file().into(),
            place: header.place.clone(),
            found,
            remedy,
        };
        let is_vector = rows.min(columns) == 1;
        let of = format!("{rows} rows and {columns} columns of form {}", header.form);
        match header.form {
            3 if is_vector => return Ok(Array::Sparse(self.diagonal(rows.max(columns)))),
            1 | 3..=6 | 8 if rows != columns => return Err(malformed(of, "as many rows as columns")),
            3 if self.sides() != [false, false] => return Err(malformed(of, "entries on the diagonal alone")),
            6 if matches!(self.sides(), [true, false] | [false, true]) => {
                let found = format!(
                    "the symmetric matrix `{}` with entries on one side of its diagonal",
                    header.name
                );
                return Err(unsupported(
                    found,
                    "write both triangles, or all entries as a square matrix (form 1)",
                ));
            }
            8 if self.values.is_empty() => return Ok(Array::Sparse(CsMat::eye(rows))),
            1..=8 => {}
            form => {
                let found = format!("the form {form} of the matrix `{}`", header.name);
                return Err(unsupported(
                    found,
                    "write it as a square or rectangular matrix (form 1 or 2)",
                ));
            }
        }
        let places = rows.checked_mul(columns);
        match places.filter(|places| !self.is_sparse && *places <= bytes.saturating_mul(FILLED)) {
            Some(places) => {
                let mut data = vec![0.0; places];
                for (column, ends) in self.begins.windows(2).enumerate() {
                    for k in ends[0]..ends[1] {
                        data[column * rows + self.rows[k]] = self.values[k];
                    }
                }
                Ok(Array::Dense(Dense::try_new(rows, columns, data)?))
            }
            None => {
                let by_columns = CsMat::new_csc((rows, columns), self.begins, self.rows, self.values);
                Ok(Array::Sparse(by_columns.to_csr()))
            }
        }
    }

    /// Whether there are entries other than zero below the diagonal, and above.
    fn sides(&self) -> [bool; 2] {
        let mut sides = [false; 2];
        for (column, ends) in self.begins.windows(2).enumerate() {
            for at in ends[0]..ends[1] {
                let is_entry = self.values[at] != 0.0;
                sides[0] |= is_entry && self.rows[at] > column;
                sides[1] |= is_entry && self.rows[at] < column;
            }
        }
        sides
    }

    /// The square matrix with this vector on its diagonal.
    fn diagonal(self, size: usize) -> CsMat<f64> {
        let mut places = Vec::with_capacity(self.rows.len());
        for (column, ends) in self.begins.windows(2).enumerate() {
            places.extend(self.rows[ends[0]..ends[1]].iter().map(|row| column.max(*row)));
        }
        let mut starts = vec![0; size + 1];
        for place in &places {
            starts[place + 1] = 1;
        }
        for row in 0..size {
            starts[row + 1] += starts[row];
        }
        CsMat::new((size, size), starts, places, self.values)
    }
}
