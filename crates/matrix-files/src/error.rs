//! Errors of this crate.

use file_io::Place;

/// Why a file cannot be read or written. Rows and columns are counted from one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file cannot be opened or read, is not a regular file, or is too large.
    #[error(transparent)]
    File(#[from] file_io::input::Error),
    /// The file breaks the rules of its format.
    #[error("{file}, {place}: found {found}, expected {expected}; write the file anew, or check that it is complete")]
    Malformed {
        /// File.
        file: String,
        /// Place.
        place: Place,
        /// What stands there.
        found: String,
        /// What should stand there.
        expected: String,
    },
    /// The file is sound, but of a kind that is not read.
    #[error("{file}, {place}: {found} is not supported; {remedy}")]
    Unsupported {
        /// File.
        file: String,
        /// Place.
        place: Place,
        /// What stands there.
        found: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// An entry is NaN or infinite.
    #[error("{file}, {place}: the entry {value} is not a finite number; remove it from the model that wrote the file")]
    NotFinite {
        /// File.
        file: String,
        /// Place.
        place: Place,
        /// The entry.
        value: f64,
    },
    /// An index points outside its matrix.
    #[error("{file}, {place}: the {what} {index} is outside {first} to {last}; write the file anew")]
    OutOfRange {
        /// File.
        file: String,
        /// Place.
        place: Place,
        /// What is counted.
        what: &'static str,
        /// The index.
        index: i128,
        /// Smallest index allowed.
        first: usize,
        /// Largest index allowed.
        last: usize,
    },
    /// A size that the file states cannot be true of a file this short.
    #[error(
        "{file}, {place}: {what} is stated as {stated}, but this file can hold no more than {possible}; it is \
         truncated or damaged: write it anew"
    )]
    Oversized {
        /// File.
        file: String,
        /// Place.
        place: Place,
        /// What is counted.
        what: &'static str,
        /// Number stated.
        stated: u128,
        /// Largest number possible.
        possible: usize,
    },
    /// An entry is given twice in a format where entries do not add up.
    #[error(
        "{file}, {place}: the entry of row {row}, column {column} is given twice, and this format does not say that \
         entries add up; keep one"
    )]
    Duplicate {
        /// File.
        file: String,
        /// Place of the second.
        place: Place,
        /// Row.
        row: usize,
        /// Column.
        column: usize,
    },
    /// A matrix that is symmetric by its format has two different values.
    #[error(
        "{file}, {place}: row {row}, column {column} is {value:e}, but {mirrored:e} the other way round, in a matrix \
         stated as symmetric; write it as a general one, or correct the model"
    )]
    Asymmetric {
        /// File.
        file: String,
        /// Place.
        place: Place,
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// Entry there.
        value: f64,
        /// Entry with row and column exchanged.
        mirrored: f64,
    },
    /// Nothing says which node and component a row belongs to.
    #[error("{file}: the rows cannot be told apart, because {missing} is missing; {remedy}")]
    NoDofMap {
        /// File.
        file: String,
        /// What is missing.
        missing: String,
        /// How to get it.
        remedy: &'static str,
    },
    /// The number of entries does not fit the shape.
    #[error("{entries} entries do not fill {rows} rows and {columns} columns; give exactly one per place")]
    Shape {
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
        /// Entries given.
        entries: usize,
    },
    /// What shall be written cannot be said in the format.
    #[error("`{name}` cannot be written: {reason}; {remedy}")]
    Unwritable {
        /// Which array.
        name: String,
        /// Why.
        reason: String,
        /// What to do about it.
        remedy: &'static str,
    },
}
