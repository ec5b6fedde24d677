//! The numbers of the arrays of a VTK file.

use super::document::{Array, Grid, Reader, Source};
use crate::Error;
use crate::formats::common::quoted;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// Most bytes that an array may have before compression, per byte of the file and on top. Meshes shrink by less.
const MOST_INFLATED: [usize; 2] = [200, 1 << 20];

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
        let compressed = match grid.compressor.as_deref() {
            None => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                return Err(self.unsupported(
                    array.at,
                    format!("data compressed with {}", quoted(other.as_bytes())),
                    "save with zlib or without compression (in ParaView: Compressor Type ZLib or None; in meshio: \
                     compression=None), or as text",
                ));
            }
        };
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
                if compressed {
                    let (inflated, used) = self.inflated(array, header, &bytes)?;
                    if used != bytes.len() {
                        let found = format!("{} bytes", bytes.len());
                        return Err(self.syntax(array.at, format!("{used} bytes of {what}"), found));
                    }
                    return Ok(inflated);
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
                let characters = |bytes: usize| bytes.div_ceil(3).checked_mul(4);
                if compressed && appended.base64 {
                    // The header, whose first word tells its length, and the blocks are encoded each by itself.
                    let decoded = |from: usize, bytes: Option<usize>| {
                        let end = bytes.and_then(characters).and_then(|count| count.checked_add(from));
                        let end = end.ok_or_else(short)?;
                        let text = data.get(from..end).ok_or_else(short)?;
                        Ok::<_, Error>((STANDARD.decode(text).map_err(broken)?, end))
                    };
                    let (first, _) = decoded(0, Some(3 * header))?;
                    let blocks = length(&first).and_then(|n| n.checked_add(3));
                    let (mut all, end) = decoded(0, blocks.and_then(|words| words.checked_mul(header)))?;
                    let mut sizes = all.chunks_exact(header).skip(3).map(length);
                    let total = sizes.try_fold(0_usize, |sum, size| sum.checked_add(size?));
                    all.extend(decoded(end, total)?.0);
                    self.inflated(array, header, &all).map(|(inflated, _)| inflated)
                } else if compressed {
                    self.inflated(array, header, data).map(|(inflated, _)| inflated)
                } else if appended.base64 {
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

    /// What blocks compressed by zlib hold, and how many bytes they and their header have. The header, in words of `width`
    /// bytes, is the number of blocks, their size before compression, that of the last (0 if it is as large), and the
    /// compressed size of each.
    fn inflated(&self, array: &Array, width: usize, bytes: &[u8]) -> Result<(Vec<u8>, usize), Error> {
        let what = format!("the array `{}`", array.name);
        let short = || self.syntax(array.at, format!("all bytes of {what}"), "fewer");
        let word = |number: usize| {
            let start = number.checked_mul(width)?;
            let mut wide = [0; 8];
            wide[..width].copy_from_slice(bytes.get(start..start.checked_add(width)?)?);
            usize::try_from(u64::from_le_bytes(wide)).ok()
        };
        let [count, size, last] = [word(0), word(1), word(2)].map(|word| word.ok_or_else(short));
        let (count, size, last) = (count?, size?, last?);
        let last = if last == 0 { size } else { last };
        let mut at = count.checked_add(3).and_then(|words| words.checked_mul(width));
        if count > 0 && word(count + 2).is_none() {
            return Err(short());
        }
        let most = MOST_INFLATED[0] * self.end_of_file() + MOST_INFLATED[1];
        let total = count
            .saturating_sub(1)
            .checked_mul(size)
            .and_then(|n| n.checked_add(last));
        if total.is_none_or(|total| total > most) {
            return Err(self.unsupported(
                array.at,
                format!("{what} of more than {most} bytes"),
                "save without compression (in ParaView: Compressor Type None; in meshio: compression=None), or as text",
            ));
        }
        let mut inflated = Vec::new();
        for block in 0..count {
            let start = at.ok_or_else(short)?;
            let end = word(3 + block)
                .and_then(|length| start.checked_add(length))
                .ok_or_else(short)?;
            let data = bytes.get(start..end).ok_or_else(short)?;
            let expected = if block + 1 == count { last } else { size };
            let before = inflated.len();
            let read = ZlibDecoder::new(data)
                .take(expected as u64 + 1)
                .read_to_end(&mut inflated);
            let found = match read {
                Ok(_) if inflated.len() - before == expected => None,
                Ok(_) => Some("another number".to_owned()),
                Err(error) => Some(error.to_string()),
            };
            if let Some(found) = found {
                let expected = format!("{expected} bytes in block {block} of {what}");
                return Err(self.syntax(array.at, expected, found));
            }
            at = Some(end);
        }
        at.filter(|at| *at <= bytes.len())
            .map(|at| (inflated, at))
            .ok_or_else(short)
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
