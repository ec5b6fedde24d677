//! The numbers of the arrays of a VTK file.

use super::document::{Array, Grid, Reader, Source};
use crate::Error;
use crate::formats::common::quoted;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

impl<'a> Reader<'a> {
    /// All numbers of an array.
    pub(super) fn numbers(&self, grid: &Grid, array: &Array) -> Result<Vec<f64>, Error> {
        let what = format!("numbers of type {} in the array `{}`", array.kind, array.name);
        let width = match array.kind.as_str() {
            "Int8" | "UInt8" => 1,
            "Int16" | "UInt16" => 2,
            "Int32" | "UInt32" | "Float32" => 4,
            "Int64" | "UInt64" | "Float64" => 8,
            _ => return Err(self.unsupported(array.at, what, "save integers or floating-point numbers")),
        };
        let float = array.kind.starts_with("Float");
        let exact = |integer: i128| {
            let real = integer as f64;
            (real as i128 == integer).then_some(real).ok_or_else(|| {
                self.unsupported(
                    array.at,
                    format!("the integer {integer} in the array `{}`", array.name),
                    "leave out integers beyond 2^53",
                )
            })
        };
        if let Source::Ascii(text) = &array.source {
            return text
                .split_ascii_whitespace()
                .map(|word| {
                    let wrong = || self.syntax(array.at, &*what, quoted(word.as_bytes()));
                    if float {
                        word.parse().map_err(|_| wrong())
                    } else {
                        exact(word.parse().map_err(|_| wrong())?)
                    }
                })
                .collect();
        }
        let raw = self.raw(grid, array)?;
        if raw.len() % width != 0 {
            return Err(self.syntax(array.at, what, format!("{} bytes", raw.len())));
        }
        raw.chunks_exact(width)
            .map(|bytes| {
                let mut wide = [0; 8];
                wide[..width].copy_from_slice(bytes);
                let unsigned = u64::from_le_bytes(wide);
                // Two's complement of the array's width.
                let unused = 64 - 8 * width as u32;
                let signed = (unsigned << unused) as i64 >> unused;
                match (float, width) {
                    (true, 4) => Ok(f32::from_bits(unsigned as u32).into()),
                    (true, _) => Ok(f64::from_bits(unsigned)),
                    (false, _) if array.kind.starts_with('U') => exact(unsigned.into()),
                    _ => exact(signed.into()),
                }
            })
            .collect()
    }

    /// The bytes of an array that is not text, without the header that tells their number.
    fn raw(&self, grid: &Grid, array: &Array) -> Result<Vec<u8>, Error> {
        let what = format!("the array `{}`", array.name);
        if let Some(compressor) = &grid.compressor {
            return Err(self.unsupported(
                array.at,
                format!("data compressed with {}", quoted(compressor.as_bytes())),
                "save without compression (in ParaView: Compressor Type None; in meshio: compression=None), or as text",
            ));
        }
        if grid.big_endian {
            return Err(self.unsupported(
                array.at,
                "data in big-endian order".into(),
                "save as text, or in little-endian order",
            ));
        }
        let header = if grid.header_64 { 8 } else { 4 };
        let length = |bytes: &[u8]| {
            let mut wide = [0; 8];
            wide[..header].copy_from_slice(bytes.get(..header)?);
            usize::try_from(u64::from_le_bytes(wide)).ok()
        };
        let short = || self.syntax(array.at, format!("all bytes of {what}"), "fewer");
        let broken = |error: base64::DecodeError| self.syntax(array.at, format!("{what} in base64"), error.to_string());
        match (&array.source, &grid.appended) {
            (Source::Ascii(text) | Source::Base64(text), _) => {
                let text: Vec<u8> = text.bytes().filter(|byte| !byte.is_ascii_whitespace()).collect();
                let mut bytes = Vec::new();
                // Some programs encode the header by itself: then padding stands in the middle.
                for part in text.split_inclusive(|byte| *byte == b'=') {
                    if part != b"=" {
                        let padding = (4 - part.len() % 4) % 4;
                        let padded = [part, &b"=="[..padding.min(2)]].concat();
                        STANDARD.decode_vec(padded, &mut bytes).map_err(broken)?;
                    }
                }
                let announced = length(&bytes).ok_or_else(short)?;
                if bytes.len() - header != announced {
                    let found = format!("{} bytes", bytes.len() - header);
                    return Err(self.syntax(array.at, format!("{announced} bytes of {what}"), found));
                }
                bytes.drain(..header);
                Ok(bytes)
            }
            (Source::Appended(_), None) => Err(self.syntax(array.at, "appended data", "none")),
            (Source::Appended(offset), Some(appended)) => {
                let data = appended.data.get(*offset..).ok_or_else(short)?;
                if appended.base64 {
                    let characters = |bytes: usize| bytes.div_ceil(3).checked_mul(4);
                    let head = data.get(..4 * header.div_ceil(3)).ok_or_else(short)?;
                    let head = STANDARD.decode(head).map_err(broken)?;
                    let end = length(&head).and_then(|n| n.checked_add(header)).and_then(characters);
                    let all = data.get(..end.ok_or_else(short)?).ok_or_else(short)?;
                    let mut bytes = STANDARD.decode(all).map_err(broken)?;
                    bytes.drain(..header);
                    Ok(bytes)
                } else {
                    let end = length(data).and_then(|n| n.checked_add(header));
                    let all = data.get(header..end.ok_or_else(short)?).ok_or_else(short)?;
                    Ok(all.to_vec())
                }
            }
        }
    }

    /// Numbers of an array that must have `count` of them.
    pub(super) fn exactly(&self, grid: &Grid, array: &Array, count: Option<usize>) -> Result<Vec<f64>, Error> {
        let numbers = self.numbers(grid, array)?;
        if count == Some(numbers.len()) {
            return Ok(numbers);
        }
        let expected = count.map_or("fewer".into(), |count| count.to_string());
        let expected = format!("{expected} numbers in the array `{}`", array.name);
        Err(self.syntax(array.at, expected, numbers.len().to_string()))
    }

    pub(super) fn cells_array<'g>(&self, grid: &'g Grid<'a>, name: &str) -> Result<&'g Array<'a>, Error> {
        let array = grid.arrays[1].iter().find(|array| array.name == name);
        array.ok_or_else(|| self.syntax(grid.at, format!("the array `{name}` in `Cells`"), "none"))
    }
}
