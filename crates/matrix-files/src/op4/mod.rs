//! Matrices that Nastran's module `OUTPUT4` writes (`.op4`), as text or binary, several in a file.
//!
//! Layout: *MSC Nastran DMAP Programmer's Guide*, modules `OUTPUT4` and `INPUTT4`. A matrix is a head (columns, rows,
//! form, type, name), its columns that are not zero, and a column beyond the last with one number that means nothing. A
//! dense column has the entries from its first row that is not zero to the last one; a sparse one has strings of
//! entries in rows that follow one another.

mod binary;
mod stream;
mod text;
mod writer;

use std::path::Path;

use sprs::CsMat;

use self::binary::Binary;
use self::stream::{Header, Stream};
use self::text::Text;
pub use self::writer::to_bytes;
use crate::Error;
use crate::value::{Array, Collection, Dense, plausible};
use file_io::Source;

/// Rows from which on strings have two integers ahead, even if these are not stated as negative.
const BIG: usize = 65_536;

/// Most places of a dense matrix for each byte that it takes in the file.
const FILLED: usize = 4;

/// Reads the file at `path`.
///
/// # Errors
/// [`Error::File`], and those of [`parse`].
pub fn read(path: &Path) -> Result<Collection, Error> {
    let bytes = crate::text::load(path)?;
    parse(Source {
        name: &path.to_string_lossy(),
        bytes: &bytes,
    })
}

/// Reads all matrices by the names that they have in the file: text in any format of numbers, binary in either byte
/// order with words of 32 or 64 bits, single and double precision.
///
/// [`Array::Dense`] if all columns are dense, and not so many zeros are left out that the matrix would take much more
/// room than the file; else [`Array::Sparse`]. Entries come as they stand: programs state matrices as symmetric (form 6)
/// that are so but for round-off. A diagonal (form 3) that is stored as a vector becomes a square matrix, and so does an
/// identity (form 8) without columns.
///
/// # Errors
/// [`Error::Unsupported`] for complex matrices, forms beyond 8 and symmetric matrices of which one triangle is given;
/// [`Error::Malformed`], among others for columns, rows and names given twice; [`Error::Oversized`],
/// [`Error::OutOfRange`], [`Error::NotFinite`].
pub fn parse(source: Source<'_>) -> Result<Collection, Error> {
    match Binary::detect(source) {
        Some(binary) => collection(source, binary),
        None => collection(source, Text::new(source)),
    }
}

fn collection(source: Source<'_>, mut stream: impl Stream) -> Result<Collection, Error> {
    let mut found = Collection::default();
    let mut stated = 0_usize;
    while let Some(header) = stream.header()? {
        // All matrices together, as each may have rows or columns that take no room in the file.
        stated = stated.saturating_add(header.rows.max(header.columns));
        plausible(stated, 0, source.bytes.len()).map_err(|(stated, possible)| Error::Oversized {
            file: source.name.into(),
            place: stream.place(),
            what: "the number of rows or columns",
            stated: stated as u128,
            possible,
        })?;
        if found.arrays.contains_key(&header.name) {
            return Err(stream.malformed(format!("a second `{}`", header.name), "each name once"));
        }
        let start = stream.at();
        let columns = Columns::read(&mut stream, &header)?;
        let array = columns.array(&stream, &header, stream.at() - start)?;
        found.arrays.insert(header.name, array);
    }
    if found.arrays.is_empty() {
        return Err(stream.malformed("the end of the file", "a matrix"));
    }
    Ok(found)
}

/// A matrix compressed by columns.
struct Columns {
    begins: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
    is_sparse: bool,
}

impl Columns {
    fn read(stream: &mut impl Stream, header: &Header) -> Result<Self, Error> {
        let mut columns = Self {
            begins: vec![0],
            rows: Vec::new(),
            values: Vec::new(),
            is_sparse: header.is_negative,
        };
        loop {
            let [column, row, words] = stream.column()?;
            if column > header.columns + 1 {
                return Err(out_of_range(stream, "column", column, header.columns + 1));
            }
            if column < columns.begins.len() {
                let expected = format!("columns that ascend, each once, here {} or later", columns.begins.len());
                return Err(stream.malformed(format!("column {column}"), expected));
            }
            columns.begins.resize(column, columns.values.len());
            if column > header.columns {
                let count = count(stream, words, stream.words(header.is_double, true))?;
                stream.numbers(count, header.is_double, &mut Vec::new())?;
                stream.finish()?;
                return Ok(columns);
            }
            if row > 0 {
                let count = count(stream, words, stream.words(header.is_double, true))?;
                columns.string(stream, header, row, count)?;
            } else {
                columns.is_sparse = true;
                columns.strings(stream, header, words)?;
            }
            stream.finish()?;
            columns.begins.push(columns.values.len());
        }
    }

    /// A sparse column.
    fn strings(&mut self, stream: &mut impl Stream, header: &Header, words: usize) -> Result<(), Error> {
        let mut left = words;
        while left > 0 {
            // The words of a string with the integers ahead, and its first row.
            let (all, ahead, row) = if header.is_negative || header.rows >= BIG {
                let [length, row] = stream.string()?;
                (length.saturating_add(1), 2, row)
            } else {
                let [packed] = stream.string()?;
                (packed >> 16, 1, packed & 0xffff)
            };
            if all <= ahead || all > left {
                let expected = format!("up to {left}, and some for entries");
                return Err(stream.malformed(format!("a string of {all} words"), expected));
            }
            let count = count(stream, all - ahead, stream.words(header.is_double, false))?;
            self.string(stream, header, row, count)?;
            left -= all;
        }
        Ok(())
    }

    /// Entries from `row` on, which counts from one.
    fn string(&mut self, stream: &mut impl Stream, header: &Header, row: usize, count: usize) -> Result<(), Error> {
        let begin = self.begins.last().copied().unwrap_or(0);
        let before = self.rows[begin..].last().map_or(0, |row| row + 1);
        if row <= before {
            let expected = format!("rows that ascend, each once, here {} or later", before + 1);
            return Err(stream.malformed(format!("row {row} of column {}", self.begins.len()), expected));
        }
        let last = (row - 1).saturating_add(count);
        if last > header.rows {
            return Err(out_of_range(stream, "row", last, header.rows));
        }
        stream.numbers(count, header.is_double, &mut self.values)?;
        self.rows.extend(row - 1..last);
        Ok(())
    }

    /// The matrix of `bytes` bytes of the file.
    fn array(self, stream: &impl Stream, header: &Header, bytes: usize) -> Result<Array, Error> {
        let (rows, columns) = (header.rows, header.columns);
        let malformed = |found: String, expected: &str| Error::Malformed {
            file: stream.file().into(),
            place: header.place.clone(),
            found,
            expected: expected.into(),
        };
        let unsupported = |found: String, remedy| Error::Unsupported {
            file: stream.file().into(),
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
                    for at in ends[0]..ends[1] {
                        data[column * rows + self.rows[at]] = self.values[at];
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

/// Numbers that so many words are.
fn count(stream: &impl Stream, words: usize, each: usize) -> Result<usize, Error> {
    if words.is_multiple_of(each) {
        return Ok(words / each);
    }
    Err(stream.malformed(format!("{words} words of entries"), format!("{each} for each")))
}

fn out_of_range(stream: &impl Stream, what: &'static str, index: usize, last: usize) -> Error {
    Error::OutOfRange {
        file: stream.file().into(),
        place: stream.place(),
        what,
        index: index as i128,
        first: 1,
        last,
    }
}
