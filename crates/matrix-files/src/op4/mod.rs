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

use self::binary::Binary;
use self::stream::Stream;
use self::text::Text;
pub use self::writer::to_bytes;
use crate::Error;
use crate::columns::{Columns, Header};
use crate::value::Collection;
use file_io::Source;

/// Rows from which on strings have two integers ahead, even if these are not stated as negative.
const BIG: usize = 65_536;

/// Reads the file at `path`.
///
/// # Errors
/// [`Error::File`], and those of [`parse`].
pub fn read(path: &Path) -> Result<Collection, Error> {
    crate::text::read(path, parse)
}

/// Reads all matrices by the names that they have in the file: text in any format of numbers, binary in either byte
/// order with words of 32 or 64 bits, single and double precision.
///
/// [`Dense`](crate::value::Array::Dense) if all columns are dense, and not so many zeros are left out that the matrix would take much more
/// room than the file; else [`Sparse`](crate::value::Array::Sparse). Entries come as they stand: programs state matrices as symmetric (form 6)
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
        stream.check_size("the number of rows or columns", stated, source.bytes.len())?;
        if found.arrays.contains_key(&header.name) {
            return Err(stream.malformed(format!("a second `{}`", header.name), "each name once"));
        }
        let start = stream.at();
        let columns = read_columns(&mut stream, &header)?;
        let array = columns.array(&stream, &header, stream.at() - start)?;
        found.arrays.insert(header.name, array);
    }
    if found.arrays.is_empty() {
        return Err(stream.malformed("the end of the file", "a matrix"));
    }
    Ok(found)
}

fn read_columns(stream: &mut impl Stream, header: &Header) -> Result<Columns, Error> {
    let mut columns = Columns::new(header.is_negative);
    loop {
        let [column, row, words] = stream.column()?;
        if column > header.columns + 1 {
            return Err(stream.out_of_range("column", column, header.columns + 1));
        }
        if column < columns.next() {
            let expected = format!("columns that ascend, each once, here {} or later", columns.next());
            return Err(stream.malformed(format!("column {column}"), expected));
        }
        columns.skip_to(column);
        if column > header.columns {
            let count = count(stream, words, stream.words(header.is_double, true))?;
            stream.numbers(count, header.is_double, &mut Vec::new())?;
            stream.finish()?;
            return Ok(columns);
        }
        if row > 0 {
            let count = count(stream, words, stream.words(header.is_double, true))?;
            read_string(&mut columns, stream, header, row, count)?;
        } else {
            columns.is_sparse = true;
            read_strings(&mut columns, stream, header, words)?;
        }
        stream.finish()?;
        columns.skip_to(column + 1);
    }
}

/// A sparse column.
fn read_strings(columns: &mut Columns, stream: &mut impl Stream, header: &Header, words: usize) -> Result<(), Error> {
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
        read_string(columns, stream, header, row, count)?;
        left -= all;
    }
    Ok(())
}

/// Entries from `row` on.
fn read_string(
    columns: &mut Columns,
    stream: &mut impl Stream,
    header: &Header,
    row: usize,
    count: usize,
) -> Result<(), Error> {
    let rows = columns.string(stream, header, row, count)?;
    stream.numbers(count, header.is_double, &mut columns.values)?;
    columns.rows.extend(rows);
    Ok(())
}

/// Numbers that so many words are.
fn count(stream: &impl Stream, words: usize, each: usize) -> Result<usize, Error> {
    if words.is_multiple_of(each) {
        return Ok(words / each);
    }
    Err(stream.malformed(format!("{words} words of entries"), format!("{each} for each")))
}
