//! Numbers and text of binary files with the least significant byte first.
use file_io::{Place, Source, quoted};
use matrix_files::Error as Layout;

use crate::error::FileError;

/// The bytes of a file, read at given places.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a>(pub(super) Source<'a>);

macro_rules! numbers {
    ($($name:ident)*) => {
        $(pub(super) fn $name(&self, at: usize) -> Result<$name, FileError> {
            Ok($name::from_le_bytes(self.array(at)?))
        })*
    };
}

impl<'a> Bytes<'a> {
    numbers!(u8 u16 u32 i32 f32 f64);

    fn array<const N: usize>(&self, at: usize) -> Result<[u8; N], FileError> {
        let found = self.0.bytes.get(at..).and_then(|rest| rest.first_chunk());
        found.copied().ok_or_else(|| self.truncated("the header"))
    }

    /// Text of fixed width, without what fills it up. What is not UTF-8 is taken as Latin-1, in which every byte is a
    /// character.
    pub(super) fn text(&self, at: usize, width: usize) -> Result<String, FileError> {
        let field = self.0.bytes.get(at..at + width);
        let field = field.ok_or_else(|| self.truncated("the header"))?;
        let field = field.split(|b| *b == 0).next().unwrap_or_default();
        Ok(latin_or_utf8(field).trim().to_owned())
    }

    pub(super) fn truncated(&self, what: &str) -> FileError {
        self.malformed(self.0.bytes.len(), "the end of the file", format!("the rest of {what}"))
    }

    pub(super) fn malformed(&self, at: usize, found: impl ToString, expected: impl ToString) -> FileError {
        malformed(self.0.name, Place::Byte(at), found, expected)
    }

    pub(super) fn unsupported(&self, at: usize, found: impl ToString, remedy: &'static str) -> FileError {
        unsupported(self.0.name, Place::Byte(at), found, remedy)
    }

    /// Product of the sizes stated at `size_at`, if `possible` bytes can hold as many points.
    pub(super) fn points(
        &self,
        size_at: usize,
        size: [u64; 2],
        bytes_per_point: usize,
        possible: usize,
    ) -> Result<usize, FileError> {
        let stated = u128::from(size[0]) * u128::from(size[1]);
        let possible = possible / bytes_per_point;
        if stated <= possible as u128 {
            return Ok(stated as usize);
        }
        Err(oversized(
            self.0.name,
            Place::Byte(size_at),
            "the number of points",
            stated,
            possible,
        ))
    }

    /// Refuses anything but zeros, white space or, if `text` is allowed, text after `end`; says what is there.
    pub(super) fn rest(&self, end: usize, text: bool) -> Result<Option<String>, FileError> {
        let rest = self.0.bytes.get(end..).unwrap_or_default();
        let filling = |b: &u8| *b == 0 || b.is_ascii_whitespace() || *b == 0x1a;
        let Some(first) = rest.iter().position(|b| !filling(b)) else {
            let n = rest.len();
            return Ok((n > 0).then(|| format!("{n} bytes of filling after the heights ignored")));
        };
        // Of a comment in Latin-1 a few bytes are not ASCII.
        let readable = |b: &&u8| filling(b) || b.is_ascii_graphic();
        if text && rest.iter().filter(readable).count() * 4 >= rest.len() * 3 {
            return Ok(Some(format!(
                "a trailer of {} bytes after the heights ignored",
                rest.len()
            )));
        }
        Err(self.malformed(
            end + first,
            format!("{} and {} bytes more", quoted(&rest[first..]), rest.len() - first),
            "the end of the file after the last point; cut the file there if the rest is foreign",
        ))
    }
}

pub(super) fn latin_or_utf8(bytes: &[u8]) -> String {
    match str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    }
}

pub(super) fn malformed(file: &str, place: Place, found: impl ToString, expected: impl ToString) -> FileError {
    FileError::Layout(Layout::Malformed {
        file: file.into(),
        place,
        found: found.to_string(),
        expected: expected.to_string(),
    })
}

pub(super) fn unsupported(file: &str, place: Place, found: impl ToString, remedy: &'static str) -> FileError {
    FileError::Layout(Layout::Unsupported {
        file: file.into(),
        place,
        found: found.to_string(),
        remedy,
    })
}

pub(super) fn oversized(file: &str, place: Place, what: &'static str, stated: u128, possible: usize) -> FileError {
    FileError::Layout(Layout::Oversized {
        file: file.into(),
        place,
        what,
        stated,
        possible,
    })
}
