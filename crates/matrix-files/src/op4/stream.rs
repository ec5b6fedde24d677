//! What the text and the binary encoding have in common.

use crate::Error;
use file_io::Place;

/// The head of a matrix.
pub(super) struct Header {
    pub(super) name: String,
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) form: i64,
    pub(super) is_double: bool,
    /// Rows were stated as a negative number: a sparse matrix, whose strings have two integers ahead.
    pub(super) is_negative: bool,
    pub(super) place: Place,
}

/// The records of a file one after another.
pub(super) trait Stream {
    fn file(&self) -> &str;

    /// Place of what was read last.
    fn place(&self) -> Place;

    /// Bytes read so far.
    fn at(&self) -> usize;

    /// The next matrix, if there is one.
    fn header(&mut self) -> Result<Option<Header>, Error>;

    /// Column, first row and number of words of the next column.
    fn column(&mut self) -> Result<[usize; 3], Error>;

    /// The integers ahead of a string.
    fn string<const N: usize>(&mut self) -> Result<[usize; N], Error>;

    /// Words that a number counts as, in a dense column or in a sparse one.
    fn words(&self, is_double: bool, is_dense: bool) -> usize;

    /// The next numbers, appended to `values`.
    fn numbers(&mut self, count: usize, is_double: bool, values: &mut Vec<f64>) -> Result<(), Error>;

    /// The end of a column.
    fn finish(&mut self) -> Result<(), Error>;

    /// From columns, rows, form and type.
    fn head(&self, [columns, rows, form, kind]: [i64; 4], name: &[u8]) -> Result<Header, Error> {
        // Machines with words of 64 bits leave blanks inside.
        let kept = name.iter().filter(|b| !matches!(b, b' ' | 0));
        let name: String = kept.map(|b| char::from(*b)).collect();
        if name.is_empty() || !name.chars().all(|c| c.is_ascii_graphic()) {
            return Err(self.malformed(format!("the name `{}`", name.escape_debug()), "letters and digits"));
        }
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
}
