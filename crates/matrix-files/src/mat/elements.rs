//! The elements of a file, and the arrays that they make.

use std::io::Read;

use flate2::read::ZlibDecoder;
use sprs::CsMat;

use super::layout::{
    CELL_CLASS, CHAR_CLASS, COMPLEX, COMPRESSED, DEPTH, DOUBLE, DOUBLE_CLASS, INT8, INT16, INT32, INT64, MATRIX,
    NAME_LENGTH, OPAQUE_CLASS, SINGLE, SINGLE_CLASS, SPARSE_CLASS, STRUCT_CLASS, UINT8, UINT16, UINT32, UINT64, UTF8,
    UTF16,
};
use crate::Error;
use crate::archive::INFLATION;
use crate::value::{Array, Collection, Dense, Skipped, plausible};
use file_io::Place;

/// The inside of an element.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) file: &'a str,
    pub(super) part: Option<&'a str>,
    pub(super) bytes: &'a [u8],
    /// Place of the first byte.
    pub(super) start: usize,
    /// Next byte to read.
    pub(super) at: usize,
    pub(super) big: bool,
}

impl<'a> View<'a> {
    fn place(&self) -> Place {
        let byte = self.start + self.at;
        match self.part {
            None => Place::Byte(byte),
            Some(part) => Place::Inside {
                part: part.into(),
                byte,
            },
        }
    }

    pub(super) fn malformed(&self, found: impl std::fmt::Display, expected: impl std::fmt::Display) -> Error {
        Error::Malformed {
            file: self.file.into(),
            place: self.place(),
            found: found.to_string(),
            expected: expected.to_string(),
        }
    }

    fn oversized(&self, what: &'static str, stated: u128, possible: usize) -> Error {
        Error::Oversized {
            file: self.file.into(),
            place: self.place(),
            what,
            stated,
            possible,
        }
    }

    fn bytes<const N: usize>(&self, at: usize) -> Result<[u8; N], Error> {
        match self.bytes.get(at..).and_then(<[u8]>::first_chunk::<N>) {
            Some(&bytes) => Ok(bytes),
            None => Err(self.malformed("the end of the data", format!("{N} bytes more"))),
        }
    }

    fn word(&self, at: usize) -> Result<u32, Error> {
        let bytes = self.bytes(at)?;
        Ok(if self.big {
            u32::from_be_bytes(bytes)
        } else {
            u32::from_le_bytes(bytes)
        })
    }

    /// Type and data of the next element.
    pub(super) fn element(&mut self) -> Result<(u32, Self), Error> {
        let tag = self.word(self.at)?;
        let (kind, from, size) = match tag >> 16 {
            0 => (tag, self.at + 8, self.word(self.at + 4)? as usize),
            // Up to four bytes lie in the tag itself.
            size => (tag & 0xffff, self.at + 4, size as usize),
        };
        let small = from == self.at + 4;
        let possible = if small { 4 } else { self.bytes.len() - from };
        if size > possible || small && self.bytes.len() < from + 4 {
            return Err(self.oversized("the number of bytes of an element", size as u128, possible));
        }
        let body = Self {
            bytes: &self.bytes[from..from + size],
            start: self.start + from,
            at: 0,
            ..*self
        };
        let end = if small {
            self.at + 8
        } else if kind == COMPRESSED {
            from + size
        } else {
            from + size.next_multiple_of(8)
        };
        self.at = end.min(self.bytes.len());
        Ok((kind, body))
    }

    /// The next element, of a type among those given.
    fn expect(&mut self, kinds: &[u32], what: &str) -> Result<(u32, Self), Error> {
        match self.element()? {
            (kind, body) if kinds.contains(&kind) => Ok((kind, body)),
            (kind, body) => Err(body.malformed(format!("an element of type {kind}"), what)),
        }
    }

    /// Unpacks the one element inside.
    pub(super) fn inflate(&self) -> Result<Vec<u8>, Error> {
        let failed = |e: std::io::Error| self.malformed(format!("data that do not unpack ({e})"), "zlib data");
        let mut decoder = ZlibDecoder::new(self.bytes);
        let mut unpacked = vec![0; 8];
        decoder.read_exact(&mut unpacked).map_err(failed)?;
        let tag = View {
            file: self.file,
            part: self.part,
            bytes: &unpacked,
            start: 0,
            at: 0,
            big: self.big,
        };
        let size = if tag.word(0)? >> 16 == 0 {
            tag.word(4)? as usize
        } else {
            0
        };
        let possible = self.bytes.len().saturating_mul(INFLATION);
        if size > possible {
            return Err(self.oversized("the number of bytes of a compressed element", size as u128, possible));
        }
        unpacked.reserve_exact(size);
        decoder
            .by_ref()
            .take(size as u64)
            .read_to_end(&mut unpacked)
            .map_err(failed)?;
        if unpacked.len() < 8 + size {
            return Err(self.malformed(format!("{} bytes unpacked", unpacked.len()), format!("{}", 8 + size)));
        }
        // Reading to the end compares the checksum.
        match decoder.read(&mut [0]).map_err(failed)? {
            0 => Ok(unpacked),
            _ => Err(self.malformed("data after the array", "one array per compressed element")),
        }
    }

    /// The array inside, added to those found.
    pub(super) fn array(&mut self, field: Option<&str>, depth: usize, found: &mut Collection) -> Result<(), Error> {
        if self.bytes.is_empty() && field.is_some() {
            // An empty field.
            return self.insert(field, "", Array::Dense(Dense::default()), found);
        }
        let (_, flags) = self.expect(&[UINT32], "the flags of an array")?;
        let flags = flags.word(0)?;
        let class = flags & 0xff;
        if class == OPAQUE_CLASS {
            let (_, name) = self.expect(&[INT8], "the name of an object")?;
            return name.skip(field, &name.name()?, "an object", found);
        }
        let (_, dimensions) = self.expect(&[INT32], "the dimensions of an array")?;
        let dimensions = dimensions.sizes(dimensions.bytes.len() / 4)?;
        let (_, name) = self.expect(&[INT8, UINT8], "the name of an array")?;
        let name = name.name()?;
        let &[rows, columns] = &dimensions[..] else {
            return self.skip(
                field,
                &name,
                &format!("an array of {} dimensions", dimensions.len()),
                found,
            );
        };
        let array = match class {
            CELL_CLASS => return self.skip(field, &name, "a cell array", found),
            3 => return self.skip(field, &name, "an object", found),
            16 => return self.skip(field, &name, "a function", found),
            _ if flags & COMPLEX != 0 => return self.skip(field, &name, "an array of complex numbers", found),
            _ if name.is_empty() && field.is_none() => {
                return self.skip(field, "(without a name)", "data of MATLAB's own for objects", found);
            }
            STRUCT_CLASS if (rows, columns) != (1, 1) => {
                return self.skip(
                    field,
                    &name,
                    &format!("an array of {rows} x {columns} structures"),
                    found,
                );
            }
            STRUCT_CLASS if depth == DEPTH => return self.skip(field, &name, "a structure nested too deeply", found),
            STRUCT_CLASS => return self.fields(&joined(field, &name), depth, found),
            CHAR_CLASS => Array::Text(self.characters(rows, columns)?),
            SPARSE_CLASS => Array::Sparse(self.sparse(rows, columns)?),
            DOUBLE_CLASS | SINGLE_CLASS => {
                let values = self.reals()?;
                self.filled(rows, columns, values.len())?;
                Array::Dense(Dense::try_new(rows, columns, values)?)
            }
            8..=15 => {
                let values = self.integers()?;
                self.filled(rows, columns, values.len())?;
                Array::Integers(Dense::try_new(rows, columns, values)?)
            }
            _ => return Err(self.malformed(format!("an array of class {class}"), "a class from 1 to 17")),
        };
        self.insert(field, &name, array, found)
    }

    fn filled(&self, rows: usize, columns: usize, entries: usize) -> Result<(), Error> {
        if rows.checked_mul(columns) == Some(entries) {
            return Ok(());
        }
        Err(self.malformed(format!("{entries} entries"), format!("{rows} x {columns}")))
    }

    fn insert(&self, field: Option<&str>, name: &str, array: Array, found: &mut Collection) -> Result<(), Error> {
        let name = joined(field, name);
        if found.arrays.contains_key(&name) {
            return Err(self.malformed(format!("a second `{name}`"), "each name once"));
        }
        found.arrays.insert(name, array);
        Ok(())
    }

    fn skip(&self, field: Option<&str>, name: &str, reason: &str, found: &mut Collection) -> Result<(), Error> {
        found.skipped.push(Skipped {
            name: joined(field, name),
            reason: reason.into(),
        });
        Ok(())
    }

    fn name(&self) -> Result<String, Error> {
        match std::str::from_utf8(self.bytes) {
            Ok(name) if name.len() <= NAME_LENGTH && !name.contains('\0') => Ok(name.into()),
            _ => Err(self.malformed(
                file_io::quoted(self.bytes),
                format!("a name of at most {NAME_LENGTH} letters"),
            )),
        }
    }

    /// The fields of one structure.
    fn fields(&mut self, name: &str, depth: usize, found: &mut Collection) -> Result<(), Error> {
        let (_, length) = self.expect(&[INT32], "the length of field names")?;
        let length = length.word(0)? as usize;
        let (_, names) = self.expect(&[INT8], "the names of fields")?;
        if length == 0 || !names.bytes.len().is_multiple_of(length) {
            return Err(names.malformed(
                format!("{} bytes of names", names.bytes.len()),
                format!("a multiple of {length}"),
            ));
        }
        for chunk in names.bytes.chunks(length) {
            let end = chunk.iter().position(|b| *b == 0).unwrap_or(length);
            let field = Self {
                bytes: &chunk[..end],
                ..names
            };
            let field = joined(Some(name), &field.name()?);
            let (_, mut body) = self.expect(&[MATRIX], "the value of a field")?;
            body.array(Some(&field), depth + 1, found)?;
        }
        Ok(())
    }

    /// Text, the rows of which are stored column by column.
    fn characters(&mut self, rows: usize, columns: usize) -> Result<String, Error> {
        let (kind, body) = self.expect(&[INT8, UINT8, UINT16, UTF8, UTF16], "characters")?;
        let no_text = || body.malformed("bytes that are no text", "text in UTF-8 or UTF-16");
        let characters: Vec<char> = match kind {
            UTF8 => std::str::from_utf8(body.bytes)
                .map_err(|_| no_text())?
                .chars()
                .collect(),
            UINT16 | UTF16 => {
                let (units, rest) = body.bytes.as_chunks::<2>();
                if !rest.is_empty() {
                    return Err(no_text());
                }
                let units = units.iter().map(|u| {
                    if body.big {
                        u16::from_be_bytes(*u)
                    } else {
                        u16::from_le_bytes(*u)
                    }
                });
                char::decode_utf16(units)
                    .collect::<Result<_, _>>()
                    .map_err(|_| no_text())?
            }
            _ => body.bytes.iter().map(|b| char::from(*b)).collect(),
        };
        if rows <= 1 {
            return Ok(characters.into_iter().collect());
        }
        body.filled(rows, columns, characters.len())?;
        let mut out = String::new();
        for row in 0..rows.min(characters.len()) {
            out.extend(characters[row..].iter().step_by(rows));
            out.truncate(out.trim_end_matches([' ', '\0']).len());
            out.push('\n');
        }
        out.pop();
        Ok(out)
    }

    /// A sparse matrix: row indices, starts of the columns, values.
    fn sparse(&mut self, rows: usize, columns: usize) -> Result<CsMat<f64>, Error> {
        plausible(rows, columns, self.bytes.len())
            .map_err(|(stated, possible)| self.oversized("the number of rows or columns", stated as u128, possible))?;
        let (_, row_of) = self.expect(&[INT32], "the rows of a sparse matrix")?;
        let (_, starts) = self.expect(&[INT32], "the columns of a sparse matrix")?;
        let begins = starts.sizes(columns + 1)?;
        let count = *begins.last().unwrap_or(&0);
        // What is reserved beyond the entries is not read.
        let row_of_entry = row_of.sizes(count)?;
        let values_at = *self;
        let mut values = self.reals()?;
        if begins[0] != 0 || !begins.is_sorted() {
            return Err(starts.malformed("starts of columns that descend", "ascending numbers from 0"));
        }
        for column in begins.windows(2) {
            let inside = &row_of_entry[column[0]..column[1]];
            if !inside.is_sorted_by(|a, b| a < b) {
                return Err(row_of.malformed(
                    "rows that do not ascend in a column",
                    "each row once, in ascending order",
                ));
            }
            if let Some(&last) = inside.last()
                && last >= rows
            {
                return Err(Error::OutOfRange {
                    file: self.file.into(),
                    place: row_of.place(),
                    what: "row (from zero)",
                    index: last as i128,
                    first: 0,
                    last: rows.saturating_sub(1),
                });
            }
        }
        if values.len() < count {
            return Err(values_at.malformed(format!("{} values", values.len()), count));
        }
        values.truncate(count);
        Ok(CsMat::new_csc((rows, columns), begins, row_of_entry, values).to_csr())
    }

    /// The first `count` of an element's integers of 32 bits, none negative.
    fn sizes(&self, count: usize) -> Result<Vec<usize>, Error> {
        let possible = self.bytes.len() / 4;
        if count > possible {
            return Err(self.oversized("the number of indices", count as u128, possible));
        }
        (0..count)
            .map(|i| {
                let size = self.word(4 * i)?;
                usize::try_from(size.cast_signed())
                    .map_err(|_| self.malformed(size.cast_signed(), "no negative number"))
            })
            .collect()
    }

    /// The next element's numbers as they are.
    fn numbers<T>(
        &mut self,
        real: impl Fn(f64) -> Option<T>,
        integer: impl Fn(i128) -> Option<T>,
        expected: &str,
    ) -> Result<Vec<T>, Error> {
        let (kind, body) = self.element()?;
        macro_rules! each {
            ($type:ty, $to:expr) => {{
                let (chunks, rest) = body.bytes.as_chunks::<{ size_of::<$type>() }>();
                if !rest.is_empty() {
                    return Err(body.malformed("part of a number", "whole numbers"));
                }
                let number = |bytes: &[u8; size_of::<$type>()]| {
                    if body.big {
                        <$type>::from_be_bytes(*bytes)
                    } else {
                        <$type>::from_le_bytes(*bytes)
                    }
                };
                let to = |(i, bytes)| {
                    let at = View {
                        at: i * size_of::<$type>(),
                        ..body
                    };
                    let value = number(bytes);
                    $to(at, value)
                };
                chunks.iter().enumerate().map(to).collect()
            }};
        }
        let from_real = |at: View<'_>, value: f64| {
            if !value.is_finite() {
                return Err(Error::NotFinite {
                    file: at.file.into(),
                    place: at.place(),
                    value,
                });
            }
            real(value).ok_or_else(|| at.malformed(value, expected))
        };
        let from_integer = |at: View<'_>, value: i128| integer(value).ok_or_else(|| at.malformed(value, expected));
        match kind {
            INT8 => each!(i8, |at, v: i8| from_integer(at, v.into())),
            UINT8 => each!(u8, |at, v: u8| from_integer(at, v.into())),
            INT16 => each!(i16, |at, v: i16| from_integer(at, v.into())),
            UINT16 => each!(u16, |at, v: u16| from_integer(at, v.into())),
            INT32 => each!(i32, |at, v: i32| from_integer(at, v.into())),
            UINT32 => each!(u32, |at, v: u32| from_integer(at, v.into())),
            INT64 => each!(i64, |at, v: i64| from_integer(at, v.into())),
            UINT64 => each!(u64, |at, v: u64| from_integer(at, v.into())),
            SINGLE => each!(f32, |at, v: f32| from_real(at, v.into())),
            DOUBLE => each!(f64, from_real),
            _ => Err(body.malformed(format!("an element of type {kind}"), "numbers")),
        }
    }

    /// Real numbers; MATLAB stores those that are small integers as such.
    fn reals(&mut self) -> Result<Vec<f64>, Error> {
        let exact = |v: i128| (v.unsigned_abs() <= 1 << f64::MANTISSA_DIGITS).then_some(v as f64);
        self.numbers(Some, exact, "a number that is exact in double precision")
    }

    fn integers(&mut self) -> Result<Vec<i64>, Error> {
        self.numbers(|_| None, |v| i64::try_from(v).ok(), "an integer of 64 bits with sign")
    }
}

/// The name of a field of a structure, or of a variable.
fn joined(parent: Option<&str>, name: &str) -> String {
    match parent {
        Some(parent) if name.is_empty() => parent.into(),
        Some(parent) => format!("{parent}.{name}"),
        None => name.into(),
    }
}
