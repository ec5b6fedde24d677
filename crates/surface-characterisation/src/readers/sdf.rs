//! SDF: ISO 25178-71 (1.0, 2.0) and its forerunner BCR-1.0, as text (`aISO-1.0`, `aBCR-1.0`) and binary (`bISO-1.0`,
//! `bBCR-1.0`).
//!
//! Layout: ISO 25178-71; K. J. Stout et al., *The Development of Methods for the Characterisation of Roughness in Three
//! Dimensions*, EUR 15178 EN, 1993 (BCR). A header, then `NumProfiles` lines of `NumPoints` numbers, height = number x
//! `Zscale` (m). Missing are, by rule of the revision, the smallest number of the data type (ISO) or its largest (BCR,
//! and unsigned types); floating-point numbers within a percent of either end (1.7e308, 3.4e38), which includes 1.797e308
//! of either sign; NaN; in text also `BAD`. Integers at the other end of their type are heights, and are noted.
//! Compressed and checksummed data are refused.
use file_io::{Place, Source, quoted};

use super::bytes::{Bytes, malformed, oversized, unsupported};
use super::format::Format;
use super::options::Options;
use super::scan::{RawGrid, Scan};
use super::text;
use super::units::LengthUnit;
use crate::error::FileError;

/// Whether a file begins as the format demands. A byte order mark before text and capitals are seen in practice.
pub(super) fn is_magic(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(text::UTF8_MARK).unwrap_or(bytes);
    matches!(bytes, [b'a' | b'b' | b'A' | b'B', b'I', b'S', b'O', b'-', ..])
        || matches!(bytes, [b'a' | b'b' | b'A' | b'B', b'B', b'C', b'R', b'-', ..])
}

/// What the header says, in either form.
struct Header {
    bcr: bool,
    size: [usize; 2],
    step: [f64; 2],
    scale: f64,
    resolution: f64,
    data: DataType,
    /// Where sizes and scales stand, for messages.
    place: Place,
}

#[derive(Clone, Copy, PartialEq)]
enum DataType {
    /// Smallest and largest number.
    Integer { min: f64, max: f64 },
    /// Numbers this large or larger are missing.
    Float { bound: f64 },
}

/// Types by their codes 0 to 7, with the size of a number in bytes.
fn data_type(code: u8) -> Option<(DataType, usize)> {
    let integer = |min: i64, max: i64, size| {
        let (min, max) = (min as f64, max as f64);
        (DataType::Integer { min, max }, size)
    };
    Some(match code {
        0 => integer(0, u8::MAX.into(), 1),
        1 => integer(0, u16::MAX.into(), 2),
        2 => integer(0, u32::MAX.into(), 4),
        3 => (DataType::Float { bound: 3.4e38 }, 4),
        4 => integer(i8::MIN.into(), i8::MAX.into(), 1),
        5 => integer(i16::MIN.into(), i16::MAX.into(), 2),
        6 => integer(i32::MIN.into(), i32::MAX.into(), 4),
        7 => (DataType::Float { bound: 1.7e308 }, 8),
        _ => return None,
    })
}

/// Reads a file in either form.
///
/// # Errors
/// [`FileError`].
pub fn parse(source: Source<'_>, options: &Options) -> Result<Scan, FileError> {
    let bytes = source.bytes.strip_prefix(text::UTF8_MARK).unwrap_or(source.bytes);
    if !is_magic(bytes) || bytes.len() < 8 {
        return Err(malformed(
            source.name,
            Place::Byte(0),
            quoted(bytes),
            "`aISO-1.0`, `bISO-1.0`, `aISO-2.0`, `bISO-2.0`, `aBCR-1.0` or `bBCR-1.0`",
        ));
    }
    let revision = &bytes[1..8];
    if ![&b"ISO-1.0"[..], b"ISO-2.0", b"BCR-1.0"].contains(&revision) {
        return Err(unsupported(
            source.name,
            Place::Byte(1),
            format!("the revision {}", quoted(revision)),
            "save the scan as ISO-1.0, ISO-2.0 or BCR-1.0",
        ));
    }
    if bytes[0].eq_ignore_ascii_case(&b'a') {
        as_text(Source { bytes, ..source }, options)
    } else {
        binary(source, options)
    }
}

fn binary(source: Source<'_>, options: &Options) -> Result<Scan, FileError> {
    let bytes = Bytes(source);
    let iso2 = &source.bytes[1..8] == b"ISO-2.0";
    // After the magic, manufacturer and two dates.
    let counts = 42;
    let (size, at) = if iso2 {
        ([bytes.u32(counts)?, bytes.u32(counts + 4)?], counts + 8)
    } else {
        let size = [bytes.u16(counts)?, bytes.u16(counts + 2)?];
        (size.map(u32::from), counts + 4)
    };
    let (compression, code, check) = (bytes.u8(at + 32)?, bytes.u8(at + 33)?, bytes.u8(at + 34)?);
    let data_at = at + 35;
    let (data, width) = allowed(
        source.name,
        |field| Place::Byte(at + 32 + field),
        compression,
        code,
        check,
    )?;
    let n = bytes.points(counts, size.map(u64::from), width, source.bytes.len() - data_at)?;
    let end = data_at + n * width;
    let raw = &source.bytes[data_at..end];
    macro_rules! numbers {
        ($type:ty) => {
            raw.as_chunks()
                .0
                .iter()
                .map(|b| <$type>::from_le_bytes(*b).into())
                .collect()
        };
    }
    let numbers: Vec<f64> = match code {
        0 => numbers!(u8),
        1 => numbers!(u16),
        2 => numbers!(u32),
        3 => numbers!(f32),
        4 => numbers!(i8),
        5 => numbers!(i16),
        6 => numbers!(i32),
        _ => numbers!(f64),
    };
    let header = Header {
        bcr: &source.bytes[1..4] == b"BCR",
        size: size.map(|n| n as usize),
        step: [bytes.f64(at)?, bytes.f64(at + 8)?],
        scale: bytes.f64(at + 16)?,
        resolution: bytes.f64(at + 24)?,
        data,
        place: Place::Byte(at),
    };
    let notes = bytes.rest(end, true)?.into_iter().collect();
    finish(source, options, header, numbers, notes)
}

/// The data type, if data of it are neither compressed nor checksummed. The three codes stand at `place(0)` to
/// `place(2)`.
fn allowed(
    file: &str,
    place: impl Fn(usize) -> Place,
    compression: u8,
    code: u8,
    check: u8,
) -> Result<(DataType, usize), FileError> {
    if compression != 0 {
        let found = format!("compression {compression}");
        return Err(unsupported(file, place(0), found, "save the scan without compression"));
    }
    if check != 0 {
        let found = format!("check type {check}");
        return Err(unsupported(file, place(2), found, "save the scan without checksums"));
    }
    data_type(code).ok_or_else(|| malformed(file, place(1), format!("the data type {code}"), "0 to 7"))
}

/// The fields of a header in text: lower-case name, value, line.
struct Fields<'a> {
    file: &'a str,
    bcr: bool,
    fields: Vec<(String, String, usize)>,
}

impl<'a> Fields<'a> {
    /// Reads up to the `*` that closes the header.
    fn read<'b>(
        source: Source<'a>,
        bcr: bool,
        mut lines: impl Iterator<Item = (usize, &'b [u8])>,
    ) -> Result<Self, FileError> {
        let file = source.name;
        let mut fields = Vec::new();
        loop {
            let Some((number, line)) = lines.next() else {
                let last = text::lines(source.bytes).count();
                return Err(malformed(
                    file,
                    Place::Line(last),
                    "the end of the file",
                    "`*` after the header",
                ));
            };
            let line = without_comment(line, bcr);
            if line == b"*" {
                return Ok(Self { file, bcr, fields });
            }
            if line.is_empty() {
                continue;
            }
            let text = String::from_utf8_lossy(line).into_owned();
            let Some((name, value)) = text.split_once('=') else {
                return Err(malformed(file, Place::Line(number), quoted(line), "`name = value`"));
            };
            fields.push((name.trim().to_ascii_lowercase(), value.trim().to_owned(), number));
        }
    }

    fn field(&self, name: &str) -> Result<(&str, Place), FileError> {
        let mut found = self.fields.iter().filter(|(key, ..)| key.eq_ignore_ascii_case(name));
        match (found.next(), found.next()) {
            (Some((_, value, line)), None) => Ok((value, Place::Line(*line))),
            (None, _) => Err(malformed(
                self.file,
                Place::Line(1),
                format!("a header without `{name}`"),
                "all fields",
            )),
            (_, Some((_, _, line))) => {
                let place = Place::Line(*line);
                Err(malformed(self.file, place, format!("a second `{name}`"), "one"))
            }
        }
    }

    fn real(&self, name: &str) -> Result<f64, FileError> {
        let (value, place) = self.field(name)?;
        let number = value.parse::<f64>();
        number.map_err(|_| malformed(self.file, place, quoted(value.as_bytes()), "a number"))
    }

    /// A whole number; BCR may write one of `words` for it.
    fn whole(&self, name: &str, words: &[(&str, u32)]) -> Result<u32, FileError> {
        let (value, place) = self.field(name)?;
        let word = words
            .iter()
            .find(|(word, _)| self.bcr && value.eq_ignore_ascii_case(word));
        let number = word.map_or_else(|| value.parse().ok(), |(_, code)| Some(*code));
        number.ok_or_else(|| malformed(self.file, place, quoted(value.as_bytes()), "a whole number"))
    }

    fn data_type(&self) -> Result<DataType, FileError> {
        const NONE: [(&str, u32); 2] = [("NULL", 0), ("NONE", 0)];
        const TYPES: [(&str, u32); 8] = [
            ("UCHAR", 0),
            ("UINTEGER", 1),
            ("ULONGINT", 2),
            ("FLOAT", 3),
            ("CHAR", 4),
            ("INTEGER", 5),
            ("LONGINT", 6),
            ("DOUBLE", 7),
        ];
        let code = |name, words: &[(&str, u32)]| Ok::<_, FileError>(self.whole(name, words)?.min(255) as u8);
        let names = ["Compression", "DataType", "CheckType"];
        let places = [
            self.field(names[0])?.1,
            self.field(names[1])?.1,
            self.field(names[2])?.1,
        ];
        let (data, _) = allowed(
            self.file,
            |field| places[field].clone(),
            code(names[0], &NONE)?,
            code(names[1], &TYPES)?,
            code(names[2], &NONE)?,
        )?;
        Ok(data)
    }

    fn header(&self) -> Result<Header, FileError> {
        let data = self.data_type()?;
        Ok(Header {
            bcr: self.bcr,
            size: [
                self.whole("NumPoints", &[])? as usize,
                self.whole("NumProfiles", &[])? as usize,
            ],
            step: [self.real("Xscale")?, self.real("Yscale")?],
            scale: self.real("Zscale")?,
            resolution: self.real("Zresolution")?,
            data,
            place: self.field("Xscale")?.1,
        })
    }
}

/// A line without the white space around it, and without the comment that a semicolon begins in BCR.
fn without_comment(line: &[u8], bcr: bool) -> &[u8] {
    let end = if bcr {
        line.iter().position(|b| *b == b';')
    } else {
        None
    };
    line[..end.unwrap_or(line.len())].trim_ascii()
}

fn as_text(source: Source<'_>, options: &Options) -> Result<Scan, FileError> {
    let bcr = &source.bytes[1..4] == b"BCR";
    let mut lines = text::lines(source.bytes).skip(1);
    let fields = Fields::read(source, bcr, lines.by_ref())?;
    let header = fields.header()?;
    // A number and a space.
    let possible = source.bytes.len() / 2;
    let stated = header.size[0] as u128 * header.size[1] as u128;
    if stated > possible as u128 {
        let place = fields.field("NumPoints")?.1;
        return Err(oversized(source.name, place, "the number of points", stated, possible));
    }
    let (numbers, closed) = heights(source.name, &header, stated as usize, lines.by_ref())?;
    let mut notes = Vec::new();
    if !closed {
        notes.push("the heights end without `*`".into());
    }
    let trailer = lines
        .map(|(_, line)| line.trim_ascii())
        .filter(|l| !l.is_empty() && *l != b"*")
        .count();
    if trailer > 0 {
        notes.push(format!("a trailer of {trailer} lines after the heights ignored"));
    }
    finish(source, options, header, numbers, notes)
}

/// The numbers of `stated` points, and whether a `*` closes them.
fn heights<'a>(
    file: &str,
    header: &Header,
    stated: usize,
    lines: impl Iterator<Item = (usize, &'a [u8])>,
) -> Result<(Vec<f64>, bool), FileError> {
    let mut numbers = Vec::with_capacity(stated);
    let mut last = 1;
    let mut closed = false;
    for (number, line) in lines {
        last = number;
        let line = without_comment(line, header.bcr);
        if line == b"*" {
            closed = true;
            break;
        }
        for token in line.split(u8::is_ascii_whitespace).filter(|token| !token.is_empty()) {
            numbers.push(height(file, header.data, number, token)?);
        }
        if numbers.len() > stated {
            let found = format!("height {}", numbers.len());
            return Err(malformed(
                file,
                Place::Line(number),
                found,
                format!("`*` after {stated} heights"),
            ));
        }
    }
    if numbers.len() < stated {
        let found = format!("the end of the heights after {}", numbers.len());
        return Err(malformed(file, Place::Line(last), found, format!("{stated} heights")));
    }
    Ok((numbers, closed))
}

/// A number of the data type, NaN if it is missing.
fn height(file: &str, data: DataType, line: usize, token: &[u8]) -> Result<f64, FileError> {
    if text::is_missing(token) {
        return Ok(f64::NAN);
    }
    let value = str::from_utf8(token).ok().and_then(|t| t.parse::<f64>().ok());
    let fits = |v: &f64| match data {
        DataType::Float { .. } => true,
        DataType::Integer { min, max } => v.fract() == 0.0 && *v >= min && *v <= max,
    };
    value
        .filter(fits)
        .ok_or_else(|| malformed(file, Place::Line(line), quoted(token), "a number of the data type"))
}

/// Masks and scales the numbers.
fn finish(
    source: Source<'_>,
    options: &Options,
    header: Header,
    mut numbers: Vec<f64>,
    mut notes: Vec<String>,
) -> Result<Scan, FileError> {
    let positive = |name: &str, value: f64| {
        if value.is_finite() && value > 0.0 {
            Ok(value)
        } else {
            let found = format!("{name} = {value}");
            Err(malformed(
                source.name,
                header.place.clone(),
                found,
                "a positive number of metres",
            ))
        }
    };
    positive("Xscale", header.step[0])?;
    positive("Yscale", header.step[1])?;
    positive("Zscale", header.scale)?;
    let mut at_other_end = 0;
    for z in &mut numbers {
        let missing = match header.data {
            DataType::Float { bound } => !(z.abs() < bound),
            DataType::Integer { min, max } => {
                let (marker, other) = if header.bcr || min == 0.0 {
                    (max, min)
                } else {
                    (min, max)
                };
                at_other_end += usize::from(*z == other && min != 0.0);
                *z == marker
            }
        };
        *z = if missing { f64::NAN } else { *z * header.scale };
    }
    if at_other_end > 0 {
        notes.push(format!(
            "{at_other_end} heights at the end of the number range that does not mark missing points kept"
        ));
    }
    let stored = match header.data {
        DataType::Integer { .. } => Some(header.scale),
        DataType::Float { .. } => None,
    };
    let resolution = Some(header.resolution).filter(|r| r.is_finite() && *r > 0.0);
    let [lateral_unit, height_unit] = options.units(source.name, Some(LengthUnit::Metre), Some(LengthUnit::Metre))?;
    RawGrid {
        format: Format::Sdf,
        size: header.size,
        step: header.step,
        origin: [0.0; 2],
        heights: numbers,
        lateral_unit,
        height_unit,
        stated_step: stored.into_iter().chain(resolution).reduce(f64::max),
        rows_open: header.bcr,
        notes,
    }
    .finish(source.name, options)
}
