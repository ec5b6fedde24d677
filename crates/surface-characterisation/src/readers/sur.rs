//! SUR of Digital Surf: a header of 512 bytes, a comment, private data, then the heights as integers of 16 or 32 bits,
//! plain (`DIGITAL SURF`) or compressed with zlib (`DSCOMPRESSED`).
//!
//! Layout: Digital Surf, *Surface file format*, as public readers of the format (RosettaSciIO, surfalize) spell it out.
//! Height = integer x spacing + offset, in the unit of the spacing; programs differ by a constant in where they put zero,
//! which de-trending removes. Missing is the smallest height stated less two, if the header says that there are such.
//! Surfaces alone are read, also as the first part of surfaces with images; series, profiles, images, heights stated as
//! inverted (programs disagree on whether the numbers are) and files of big-endian machines are refused.

use std::io::Read;

use file_io::{Place, Source, quoted};
use flate2::read::ZlibDecoder;
use matrix_files::archive::INFLATION;

use super::bytes::Bytes;
use super::format::Format;
use super::options::Options;
use super::scan::{RawGrid, Scan};
use super::units::LengthUnit;
use crate::error::FileError;

const HEADER: usize = 512;
const SURFACE: u16 = 2;
/// Surfaces followed by images: intensity, colour, colour and intensity.
const WITH_IMAGES: [u16; 3] = [11, 13, 16];
const PROFILE: u16 = 1;

pub(super) fn is_magic(bytes: &[u8]) -> bool {
    bytes.starts_with(b"DIGITAL SURF") || bytes.starts_with(b"DSCOMPRESSED")
}

/// Reads a file.
///
/// # Errors
/// [`FileError`].
pub fn parse(source: Source<'_>, options: &Options) -> Result<Scan, FileError> {
    let bytes = Bytes(source);
    if !is_magic(source.bytes) {
        return Err(bytes.malformed(0, quoted(source.bytes), "`DIGITAL SURF` or `DSCOMPRESSED`"));
    }
    if source.bytes.len() < HEADER {
        return Err(bytes.truncated("the header"));
    }
    let mut notes = Vec::new();
    let with_images = check_kind(&bytes, &mut notes)?;
    let body = Body::read(&bytes)?;
    let unpacked;
    let (raw, end) = if source.bytes.starts_with(b"DSC") {
        let (found, end) = unpack(&bytes, body.start, body.length())?;
        unpacked = found;
        (&unpacked[..], end)
    } else {
        let end = body.start + body.length();
        (&source.bytes[body.start..end], end)
    };
    if !with_images {
        notes.extend(bytes.rest(end, false)?);
    }
    let axes = Axes::read(&bytes, &mut notes)?;
    let [spacing, offset] = [axes.spacing, axes.offset];
    let lowest = i64::from(bytes.i32(100)?);
    let missing = (bytes.u16(86)? == 1).then_some(lowest - 2);
    let height = |raw: i64| {
        if Some(raw) == missing {
            f64::NAN
        } else {
            raw as f64 * spacing[2] + offset[2]
        }
    };
    let heights = if body.width == 2 {
        let numbers = raw.as_chunks().0.iter();
        numbers.map(|b| height(i16::from_le_bytes(*b).into())).collect()
    } else {
        let numbers = raw.as_chunks().0.iter();
        numbers.map(|b| height(i32::from_le_bytes(*b).into())).collect()
    };
    let [lateral_unit, height_unit] = options.units(source.name, Some(axes.unit[0]), Some(axes.unit[2]))?;
    RawGrid {
        format: Format::Sur,
        size: body.size,
        step: [spacing[0], spacing[1]],
        origin: [offset[0], offset[1]],
        heights,
        lateral_unit,
        height_unit,
        stated_step: Some(spacing[2]),
        rows_open: true,
        notes,
    }
    .finish(source.name, options)
}

/// Refuses what is no surface in the form that is read; says whether images follow the heights.
fn check_kind(bytes: &Bytes<'_>, notes: &mut Vec<String>) -> Result<bool, FileError> {
    for (at, what, allowed, remedy) in [
        (12, "the byte order", 0, "save the scan in the format of PCs"),
        (16, "the version", 1, "save the scan in version 1"),
        (290, "the inversion", 0, "save the scan without inverting it"),
    ] {
        let found = bytes.u16(at)?;
        if found != allowed {
            return Err(bytes.unsupported(at, format!("{what} {found}"), remedy));
        }
    }
    let lines = bytes.i32(112)?;
    let kind = bytes.u16(18)?;
    let with_images = WITH_IMAGES.contains(&kind);
    match kind {
        SURFACE => {}
        PROFILE if lines > 1 => notes.push(format!("stated as a profile, but of {lines} lines: read as a surface")),
        _ if with_images => notes.push("images beside the heights ignored".into()),
        _ => {
            let found = format!("an object of type {kind}");
            return Err(bytes.unsupported(18, found, "save the surface alone (type 2)"));
        }
    }
    let objects = bytes.u16(14)?;
    if objects > 1 && !with_images {
        let found = format!("a file of {objects} objects");
        return Err(bytes.unsupported(14, found, "save each surface in a file of its own"));
    }
    let channels = bytes.u32(94)?;
    if channels > 1 {
        let found = format!("{channels} numbers per point");
        return Err(bytes.unsupported(94, found, "save the heights alone"));
    }
    Ok(with_images)
}

/// Where the heights are, packed or not.
struct Body {
    /// First byte in the file.
    start: usize,
    /// Points along x and y.
    size: [usize; 2],
    /// Bytes per point.
    width: usize,
}

impl Body {
    fn read(bytes: &Bytes<'_>) -> Result<Self, FileError> {
        let source = bytes.0;
        let size = [bytes.i32(108)?, bytes.i32(112)?];
        let width = match bytes.u16(98)? {
            16 => 2,
            32 => 4,
            bits => return Err(bytes.malformed(98, format!("points of {bits} bits"), "16 or 32")),
        };
        let [Ok(nx), Ok(ny)] = size.map(u64::try_from) else {
            return Err(bytes.malformed(108, format!("{} x {} points", size[0], size[1]), "positive numbers"));
        };
        let start = HEADER + usize::from(bytes.u16(334)?) + usize::from(bytes.u16(336)?);
        let Some(body) = source.bytes.get(start..) else {
            return Err(bytes.truncated("the comment"));
        };
        let compressed = source.bytes.starts_with(b"DSC");
        let inflation = if compressed { INFLATION } else { 1 };
        let n = bytes.points(108, [nx, ny], width, body.len().saturating_mul(inflation))?;
        let stated = bytes.u32(116)?;
        if u64::from(stated) != n as u64 {
            return Err(bytes.malformed(116, format!("{stated} points"), format!("{nx} x {ny}")));
        }
        Ok(Self {
            start,
            size: [nx as usize, ny as usize],
            width,
        })
    }

    /// Number of bytes, unpacked.
    fn length(&self) -> usize {
        self.size[0] * self.size[1] * self.width
    }
}

/// Units, steps and offsets along x, y and z.
struct Axes {
    unit: [LengthUnit; 3],
    /// Steps (m).
    spacing: [f64; 3],
    /// Offsets (m).
    offset: [f64; 3],
}

impl Axes {
    fn read(bytes: &Bytes<'_>, notes: &mut Vec<String>) -> Result<Self, FileError> {
        let mut unit = [LengthUnit::Metre; 3];
        for (q, unit) in unit.iter_mut().enumerate() {
            let at = 180 + 16 * q;
            *unit = bytes.text(at, 16)?.parse().map_err(|source| FileError::Unit {
                file: bytes.0.name.into(),
                place: Place::Byte(at),
                source,
            })?;
        }
        if unit[0] != unit[1] {
            notes.push(format!("steps along y are stated in {}", unit[1]));
        }
        let mut numbers = [[0.0; 3]; 2];
        for (row, at) in numbers.iter_mut().zip([120, 466]) {
            for (q, number) in row.iter_mut().enumerate() {
                // The decimal number that was stored in single precision, where it is short, not its binary neighbour.
                let stored = bytes.f32(at + 4 * q)?;
                let stored = stored.to_string().parse().unwrap_or(f64::from(stored));
                *number = unit[q].metres(stored);
            }
        }
        let [spacing, offset] = numbers;
        if let Some(q) = offset.iter().position(|offset| !offset.is_finite()) {
            return Err(bytes.malformed(466 + 4 * q, format!("an offset of {}", offset[q]), "a finite number"));
        }
        for (q, value) in spacing.into_iter().enumerate() {
            if !(value.is_finite() && value > 0.0) {
                let found = format!("a spacing of {value} m");
                return Err(bytes.malformed(120 + 4 * q, found, "a positive number"));
            }
        }
        Ok(Self { unit, spacing, offset })
    }
}

/// Unpacks `needed` bytes: the number of streams, for each its size unpacked and packed, then the streams.
fn unpack(bytes: &Bytes<'_>, start: usize, needed: usize) -> Result<(Vec<u8>, usize), FileError> {
    let file = bytes.0.bytes;
    let streams = bytes.u32(start)? as usize;
    let directory = start + 4;
    let mut at = streams
        .checked_mul(8)
        .and_then(|size| size.checked_add(directory))
        .filter(|end| *end <= file.len())
        .ok_or_else(|| bytes.malformed(start, format!("{streams} streams"), "as many as the file holds"))?;
    let mut unpacked = Vec::with_capacity(needed);
    for stream in 0..streams {
        let entry = directory + 8 * stream;
        let (size, packed) = (bytes.u32(entry)? as usize, bytes.u32(entry + 4)? as usize);
        let Some(data) = at.checked_add(packed).and_then(|end| file.get(at..end)) else {
            return Err(bytes.truncated(&format!("stream {stream}")));
        };
        if unpacked.len() + size > needed {
            return Err(bytes.malformed(entry, format!("{size} bytes more"), format!("{needed} in all")));
        }
        let before = unpacked.len();
        let result = ZlibDecoder::new(data).take(size as u64 + 1).read_to_end(&mut unpacked);
        let found = match result {
            Ok(found) if found == size => None,
            Ok(_) => Some(format!("{} bytes unpacked", unpacked.len() - before)),
            Err(e) => Some(format!("data that do not unpack ({e})")),
        };
        if let Some(found) = found {
            return Err(bytes.malformed(at, found, format!("{size} bytes packed by zlib")));
        }
        at += packed;
    }
    if unpacked.len() != needed {
        return Err(bytes.malformed(directory, format!("{} bytes in all streams", unpacked.len()), needed));
    }
    Ok((unpacked, at))
}
