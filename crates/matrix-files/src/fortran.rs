//! Records as Fortran writes them: length, contents, length.

use crate::Error;
use crate::columns::Position;
use file_io::{Place, Source};

/// The records of a file, one after another.
pub(crate) struct Records<'a> {
    source: Source<'a>,
    /// Where the next word is.
    pub(crate) at: usize,
    /// Where the contents of the record end.
    pub(crate) end: usize,
    /// Bytes of a word.
    pub(crate) word: usize,
    is_big_endian: bool,
}

impl<'a> Records<'a> {
    /// None if the file does not begin with a record of so many words of 32 or 64 bits.
    pub(crate) fn detect(source: Source<'a>, words: u32) -> Option<Self> {
        let length = *source.bytes.first_chunk::<4>()?;
        let lengths = [u32::from_le_bytes(length), u32::from_be_bytes(length)];
        let is = |bytes: u32| lengths.iter().position(|length| *length == bytes * words);
        let (word, order) = is(4).map(|order| (4, order)).or(is(8).map(|order| (8, order)))?;
        Some(Self {
            source,
            at: 0,
            end: 0,
            word,
            is_big_endian: order == 1,
        })
    }

    /// Whether all records have been read.
    pub(crate) fn is_at_end(&self) -> bool {
        self.at == self.source.bytes.len()
    }

    /// What is left of the record.
    pub(crate) fn rest(&self) -> &'a [u8] {
        self.source.bytes.get(self.at..self.end).unwrap_or_default()
    }

    /// The next `N` bytes, in the order of lowest first.
    fn bytes<const N: usize>(&self, at: usize, end: usize) -> Result<[u8; N], Error> {
        let bytes = self.source.bytes.get(at..end).and_then(<[u8]>::first_chunk::<N>);
        let mut bytes = *bytes.ok_or_else(|| self.malformed("the end of the record or file", "more bytes"))?;
        if self.is_big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn length(&self, at: usize) -> Result<usize, Error> {
        let length = u32::from_le_bytes(self.bytes(at, self.source.bytes.len())?);
        Ok(length as usize)
    }

    /// Goes into the next record, and gives its number of bytes.
    pub(crate) fn begin(&mut self) -> Result<usize, Error> {
        let length = self.length(self.at)?;
        let possible = self.source.bytes.len().saturating_sub(self.at + 8);
        if length > possible {
            return Err(self.oversized("the number of bytes of a record", length as u128, possible));
        }
        let (start, end) = (self.at + 4, self.at + 4 + length);
        let repeated = self.length(end)?;
        if repeated != length {
            return Err(self.malformed(
                format!("a record of {length} bytes that ends as one of {repeated}"),
                "the same length at both ends",
            ));
        }
        (self.at, self.end) = (start, end);
        Ok(length)
    }

    pub(crate) fn integer(&mut self) -> Result<i64, Error> {
        let integer = match self.word {
            8 => i64::from_le_bytes(self.bytes(self.at, self.end)?),
            _ => i32::from_le_bytes(self.bytes(self.at, self.end)?).into(),
        };
        self.at += self.word;
        Ok(integer)
    }

    /// The next numbers, appended to `values`.
    pub(crate) fn numbers(&mut self, count: usize, is_double: bool, values: &mut Vec<f64>) -> Result<(), Error> {
        for _ in 0..count {
            let (value, size) = if is_double || self.word == 8 {
                (f64::from_le_bytes(self.bytes(self.at, self.end)?), 8)
            } else {
                (f32::from_le_bytes(self.bytes(self.at, self.end)?).into(), 4)
            };
            if !value.is_finite() {
                return Err(Error::NotFinite {
                    file: self.source.name.into(),
                    place: self.place(),
                    value,
                });
            }
            values.push(value);
            self.at += size;
        }
        Ok(())
    }

    /// Leaves the record, of which all must have been read.
    pub(crate) fn finish(&mut self) -> Result<(), Error> {
        if self.at != self.end {
            let found = format!("{} bytes more in the record", self.end - self.at);
            return Err(self.malformed(found, "the end of the record"));
        }
        self.at = self.end + 4;
        Ok(())
    }
}

impl Position for Records<'_> {
    fn file(&self) -> &str {
        self.source.name
    }

    fn place(&self) -> Place {
        Place::Byte(self.at)
    }
}
