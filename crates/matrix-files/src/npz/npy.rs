//! One array in NumPy's format.

use crate::Error;
use crate::value::{Array, Dense};
use file_io::Place;

/// One array file.
#[derive(Clone, Copy)]
pub(super) struct Npy<'a> {
    pub(super) file: &'a str,
    /// Its name in the archive, unless it is the file itself.
    pub(super) member: Option<&'a str>,
    /// Whether NaN and infinities are kept.
    pub(super) measured: bool,
    pub(super) bytes: &'a [u8],
}

/// What the header says.
struct Header {
    /// Type of the entries; `None` if it is a structure.
    kind: Option<String>,
    by_columns: bool,
    shape: Vec<usize>,
}

impl Npy<'_> {
    fn place(&self, byte: usize) -> Place {
        match self.member {
            None => Place::Byte(byte),
            Some(member) => Place::Inside {
                part: format!("`{}`", member.escape_debug()),
                byte,
            },
        }
    }

    pub(super) fn malformed(
        &self,
        byte: usize,
        found: impl std::fmt::Display,
        expected: impl std::fmt::Display,
    ) -> Error {
        Error::Malformed {
            file: self.file.into(),
            place: self.place(byte),
            found: found.to_string(),
            expected: expected.to_string(),
        }
    }

    /// The array, or why it is skipped.
    pub(super) fn parse(&self) -> Result<Result<Array, String>, Error> {
        let (start, header, data) = self.parts()?;
        let data_at = start + header.len();
        let Some(Header {
            kind,
            by_columns,
            shape,
        }) = dictionary(header)
        else {
            return Err(self.malformed(start, file_io::quoted(header), "`descr`, `fortran_order` and `shape`"));
        };
        let (rows, columns) = match shape[..] {
            [] => (1, 1),
            [rows] => (rows, 1),
            [rows, columns] => (rows, columns),
            _ => return Ok(Err(format!("an array of {} dimensions", shape.len()))),
        };
        let Some(kind) = kind else {
            return Ok(Err("an array of structures".into()));
        };
        let (big, code) = match kind.as_bytes() {
            [order @ (b'<' | b'>' | b'|' | b'='), code @ ..] => (*order == b'>', code),
            code => (false, code),
        };
        let size = match code {
            [b'b' | b'i' | b'u', size @ (b'1' | b'2' | b'4' | b'8')] => usize::from(size - b'0'),
            b"f4" => 4,
            b"f8" => 8,
            [letter @ (b'U' | b'S'), size @ ..] => {
                let size = std::str::from_utf8(size).ok().and_then(|s| s.parse::<usize>().ok());
                let size = size.and_then(|s| s.checked_mul(if *letter == b'U' { 4 } else { 1 }));
                size.ok_or_else(|| self.malformed(start, &kind, "a length of text"))?
            }
            _ => return Ok(Err(format!("entries of the type `{}`", kind.escape_debug()))),
        };
        let stated = rows as u128 * columns as u128 * size as u128;
        if stated > data.len() as u128 {
            return Err(Error::Oversized {
                file: self.file.into(),
                place: self.place(data_at),
                what: "the number of bytes of the entries",
                stated,
                possible: data.len(),
            });
        }
        if stated < data.len() as u128 {
            return Err(self.malformed(data_at, format!("{} bytes of entries", data.len()), stated));
        }
        let entries = Entries {
            code,
            big,
            size,
            data,
            at: data_at,
            rows,
            columns,
            by_columns,
        };
        Ok(match code {
            [b'U' | b'S', ..] if shape.len() < 2 => Ok(Array::Text(self.text(&entries)?)),
            b"f4" | b"f8" | b"b1" | [b'i' | b'u', ..] => Ok(self.numbers(&entries)?),
            _ => Err(format!("a matrix with entries of the type `{}`", kind.escape_debug())),
        })
    }

    /// Where the header begins, the header, and what follows it.
    fn parts(&self) -> Result<(usize, &[u8], &[u8]), Error> {
        let (header, start) = match *self.bytes {
            [0x93, b'N', b'U', b'M', b'P', b'Y', 1, _, a, b, ..] => (usize::from(u16::from_le_bytes([a, b])), 10),
            [0x93, b'N', b'U', b'M', b'P', b'Y', 2 | 3, _, a, b, c, d, ..] => {
                (u32::from_le_bytes([a, b, c, d]) as usize, 12)
            }
            _ => {
                return Err(self.malformed(
                    0,
                    file_io::quoted(&self.bytes[..self.bytes.len().min(8)]),
                    "`\\x93NUMPY` and 1 to 3",
                ));
            }
        };
        let Some((header, data)) = self.bytes[start..].split_at_checked(header) else {
            return Err(Error::Oversized {
                file: self.file.into(),
                place: self.place(start),
                what: "the number of bytes of the header",
                stated: header as u128,
                possible: self.bytes.len() - start,
            });
        };
        Ok((start, header, data))
    }

    /// The entries as numbers.
    fn numbers(&self, entries: &Entries<'_>) -> Result<Array, Error> {
        macro_rules! numbers {
            ($type:ty) => {
                entries
                    .data
                    .as_chunks::<{ size_of::<$type>() }>()
                    .0
                    .iter()
                    .map(|bytes| {
                        if entries.big {
                            <$type>::from_be_bytes(*bytes)
                        } else {
                            <$type>::from_le_bytes(*bytes)
                        }
                    })
            };
        }
        let reals = |values| self.finite(entries, entries.dense(values)?).map(Array::Dense);
        let integers = |values| entries.dense(values).map(Array::Integers);
        match entries.code {
            b"f4" => reals(numbers!(f32).map(f64::from).collect()),
            b"f8" => reals(numbers!(f64).collect()),
            b"i1" => integers(numbers!(i8).map(i64::from).collect()),
            b"i2" => integers(numbers!(i16).map(i64::from).collect()),
            b"u2" => integers(numbers!(u16).map(i64::from).collect()),
            b"i4" => integers(numbers!(i32).map(i64::from).collect()),
            b"u4" => integers(numbers!(u32).map(i64::from).collect()),
            b"i8" => integers(numbers!(i64).collect()),
            b"u8" => {
                let too_large = |v| self.malformed(entries.at, v, "an integer of 64 bits with sign");
                let values = numbers!(u64).map(|v| i64::try_from(v).map_err(|_| too_large(v)));
                integers(values.collect::<Result<_, _>>()?)
            }
            // Truth values and bytes.
            _ => integers(numbers!(u8).map(i64::from).collect()),
        }
    }

    /// The entries as lines of text.
    fn text(&self, entries: &Entries<'_>) -> Result<String, Error> {
        let wide = entries.code[0] == b'U';
        let lines = entries.data.chunks(entries.size.max(1)).map(|line| {
            if wide {
                wide_text(line, entries.big)
            } else {
                Some(latin(line))
            }
        });
        let lines: Option<Vec<String>> = lines.collect();
        let lines = lines.ok_or_else(|| self.malformed(entries.at, "numbers that are no characters", "text"))?;
        Ok(lines.join("\n"))
    }

    fn finite(&self, entries: &Entries<'_>, values: Dense<f64>) -> Result<Dense<f64>, Error> {
        let refused = |v: &f64| !v.is_finite() && !self.measured;
        match values.data().iter().position(refused) {
            None => Ok(values),
            Some(at) => Err(Error::NotFinite {
                file: self.file.into(),
                place: self.place(entries.at + at * entries.size),
                value: values.data()[at],
            }),
        }
    }
}

/// The entries of an array as they are stored.
struct Entries<'a> {
    /// Type, without its byte order.
    code: &'a [u8],
    /// Whether the most significant byte comes first.
    big: bool,
    /// Bytes per entry.
    size: usize,
    data: &'a [u8],
    /// First byte in the file.
    at: usize,
    rows: usize,
    columns: usize,
    by_columns: bool,
}

impl Entries<'_> {
    /// The matrix of values in the order of storage.
    fn dense<T: Copy>(&self, values: Vec<T>) -> Result<Dense<T>, Error> {
        if self.by_columns {
            Dense::try_new(self.rows, self.columns, values)
        } else {
            Dense::try_from_rows(self.rows, self.columns, values)
        }
    }
}

/// Text in 32-bit characters, padded with zeros.
fn wide_text(bytes: &[u8], big: bool) -> Option<String> {
    let units = bytes.as_chunks::<4>().0.iter();
    let codes = units.map(|u| {
        if big {
            u32::from_be_bytes(*u)
        } else {
            u32::from_le_bytes(*u)
        }
    });
    let text: String = codes.map(char::from_u32).collect::<Option<_>>()?;
    Some(text.trim_end_matches('\0').into())
}

fn latin(bytes: &[u8]) -> String {
    let text: String = bytes.iter().map(|b| char::from(*b)).collect();
    text.trim_end_matches('\0').into()
}

/// The header: a dictionary as Python writes it.
fn dictionary(text: &[u8]) -> Option<Header> {
    let text = std::str::from_utf8(text).ok()?.trim();
    let mut rest = text.strip_prefix('{')?.strip_suffix('}')?.trim_start();
    let (mut kind, mut by_columns, mut shape) = (None, None, None);
    while !rest.is_empty() {
        let (key, after) = string_literal(rest)?;
        rest = after.trim_start().strip_prefix(':')?.trim_start();
        rest = match key {
            "descr" if rest.starts_with('[') => {
                // A list of fields ends before the next key.
                kind = Some(None);
                rest.split_once("'fortran_order'")
                    .map(|(fields, _)| &rest[fields.len()..])?
            }
            "descr" => {
                let (code, after) = string_literal(rest)?;
                kind = Some(Some(code.to_owned()));
                after
            }
            "fortran_order" => {
                let (value, after) = rest.split_at_checked(if rest.starts_with("True") { 4 } else { 5 })?;
                by_columns = Some(match value {
                    "True" => true,
                    "False" => false,
                    _ => return None,
                });
                after
            }
            "shape" => {
                let (numbers, after) = rest.strip_prefix('(')?.split_once(')')?;
                let sizes = numbers.split(',').map(str::trim).filter(|n| !n.is_empty());
                shape = Some(
                    sizes
                        .map(|n| n.trim_end_matches('L').parse().ok())
                        .collect::<Option<_>>()?,
                );
                after
            }
            _ => return None,
        };
        rest = rest.trim_start();
        rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
    }
    Some(Header {
        kind: kind?,
        by_columns: by_columns?,
        shape: shape?,
    })
}

/// What stands in quotation marks, and what follows.
fn string_literal(text: &str) -> Option<(&str, &str)> {
    let mark = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(mark)
}
