//! Records as Fortran writes them: length, contents, length.

use super::stream::{Header, Stream};
use crate::Error;
use file_io::{Place, Source};

pub(super) struct Binary<'a> {
    source: Source<'a>,
    at: usize,
    /// Where the contents of the record end.
    end: usize,
    /// Bytes of a word.
    word: usize,
    is_big_endian: bool,
}

impl<'a> Binary<'a> {
    /// None if the file does not begin with the length of the head of a matrix: six words of 32 or 64 bits.
    pub(super) fn detect(source: Source<'a>) -> Option<Self> {
        let length = *source.bytes.first_chunk::<4>()?;
        let (word, is_big_endian) = match [u32::from_le_bytes(length), u32::from_be_bytes(length)] {
            [24, _] => (4, false),
            [48, _] => (8, false),
            [_, 24] => (4, true),
            [_, 48] => (8, true),
            _ => return None,
        };
        Some(Self {
            source,
            at: 0,
            end: 0,
            word,
            is_big_endian,
        })
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

    /// Goes into the next record.
    fn begin(&mut self) -> Result<usize, Error> {
        let length = self.length(self.at)?;
        let possible = self.source.bytes.len().saturating_sub(self.at + 8);
        if length > possible {
            return Err(Error::Oversized {
                file: self.source.name.into(),
                place: self.place(),
                what: "the number of bytes of a record",
                stated: length as u128,
                possible,
            });
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

    fn integer(&mut self) -> Result<i64, Error> {
        let integer = match self.word {
            8 => i64::from_le_bytes(self.bytes(self.at, self.end)?),
            _ => i32::from_le_bytes(self.bytes(self.at, self.end)?).into(),
        };
        self.at += self.word;
        Ok(integer)
    }
}

impl Stream for Binary<'_> {
    fn file(&self) -> &str {
        self.source.name
    }

    fn place(&self) -> Place {
        Place::Byte(self.at)
    }

    fn at(&self) -> usize {
        self.at
    }

    fn header(&mut self) -> Result<Option<Header>, Error> {
        if self.at == self.source.bytes.len() {
            return Ok(None);
        }
        let length = self.begin()?;
        if length != 6 * self.word {
            let expected = format!("the head of a matrix, of {} bytes", 6 * self.word);
            return Err(self.malformed(format!("a record of {length} bytes"), expected));
        }
        let mut numbers = [0; 4];
        for number in &mut numbers {
            *number = self.integer()?;
        }
        let header = self.head(numbers, &self.source.bytes[self.at..self.end])?;
        self.at = self.end + 4;
        Ok(Some(header))
    }

    fn column(&mut self) -> Result<[usize; 3], Error> {
        let length = self.begin()?;
        let [column, row, words] = self.string()?;
        if length / self.word != words.saturating_add(3) {
            let expected = format!("a record of three words more, not of {length} bytes");
            return Err(self.malformed(format!("{words} words in a column"), expected));
        }
        Ok([column, row, words])
    }

    fn string<const N: usize>(&mut self) -> Result<[usize; N], Error> {
        let mut integers = [0; N];
        for integer in &mut integers {
            let stated = self.integer()?;
            *integer = usize::try_from(stated).map_err(|_| self.malformed(stated, "no negative number"))?;
        }
        Ok(integers)
    }

    fn words(&self, is_double: bool, _is_dense: bool) -> usize {
        if is_double && self.word == 4 { 2 } else { 1 }
    }

    fn numbers(&mut self, count: usize, is_double: bool, values: &mut Vec<f64>) -> Result<(), Error> {
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

    fn finish(&mut self) -> Result<(), Error> {
        if self.at != self.end {
            let found = format!("{} bytes more in the record", self.end - self.at);
            return Err(self.malformed(found, "the end of the column"));
        }
        self.at = self.end + 4;
        Ok(())
    }
}
