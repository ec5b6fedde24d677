//! X3P (ISO 25178-72): a ZIP archive with `main.xml` and the coordinates, there or in a binary member.
//!
//! Layout: ISO 25178-72:2017 with Amendment 1:2020, as the schema of openGPS (ISO 5436-2 XML) and its samples show it.
//! Lengths are metres: coordinate = increment x number + offset. Axes x and y count along the grid (incremental) or are
//! given for each point (absolute); such points must lie on a grid. Data types are `I`, `L` (integers of 16 and 32 bits),
//! `F`, `D` (floating point of 32 and 64 bits), least significant byte first. Missing are NaN, empty `Datum` elements and
//! points whose bit in the file of valid points is zero, counted from the least significant one. MD5 checksums that are
//! stated are verified; one that is absent is noted. A layer of several is chosen by [`Options::layer`].

mod axes;
mod document;
mod members;
mod points;
use file_io::{Place, Source, quoted};

use self::axes::{DataType, axes};
use self::document::{Document, MAIN};
pub(super) use self::members::is_main;
use self::members::{Members, verify};
use self::points::{Extent, Points};
use super::bytes::{latin_or_utf8, malformed, unsupported};
use super::format::Format;
use super::options::Options;
use super::scan::{RawGrid, Scan};
use super::units::LengthUnit;
use crate::error::FileError;

/// Name of the member with the document's checksum, unless the document says otherwise.
const CHECKSUM: &str = "md5checksum.hex";

/// Reads a file.
///
/// # Errors
/// [`FileError`].
pub fn parse(source: Source<'_>, options: &Options) -> Result<Scan, FileError> {
    let file = source.name;
    let mut notes = Vec::new();
    let mut members = Members::open(source)?;
    let document = read_document(file, &mut members, &mut notes)?;
    check_feature(&document)?;
    let axes = axes(&document, &mut notes)?;
    let extent = Extent::read(&document)?;
    let points = Points::read(&document, &axes, &mut members, &mut notes)?;
    let (size, layer) = points.layer(&extent, options.layer)?;
    let grid = points.grid(&extent, &axes, size, layer)?;
    if grid.deviation > 0.0 {
        notes.push(format!(
            "points lie up to {:.1e} steps beside their grid",
            grid.deviation
        ));
    }
    members.note_others(&mut notes);
    let integers = matches!(axes[2].data, Some(DataType::I | DataType::L));
    let [lateral_unit, height_unit] = options.units(file, Some(LengthUnit::Metre), Some(LengthUnit::Metre))?;
    RawGrid {
        format: Format::X3p,
        size: grid.size,
        step: grid.step,
        origin: grid.origin,
        heights: grid.heights,
        lateral_unit,
        height_unit,
        stated_step: integers.then_some(axes[2].increment.abs()),
        rows_open: false,
        notes,
    }
    .finish(file, options)
}

/// The document, checked against the checksum that the archive holds for it.
fn read_document<'a>(
    file: &'a str,
    members: &mut Members<'_>,
    notes: &mut Vec<String>,
) -> Result<Document<'a>, FileError> {
    let Some(main) = members.get(MAIN)? else {
        return Err(malformed(
            file,
            Place::Byte(0),
            format!("no member `{MAIN}`"),
            "an X3P archive",
        ));
    };
    let document = Document::parse(file, &main)?;
    let checksum = document.text("Record4/ChecksumFile").unwrap_or(CHECKSUM);
    let checksum = members.get(checksum)?.unwrap_or_default();
    let checksum = latin_or_utf8(&checksum);
    verify(file, MAIN, &main, checksum.split_whitespace().next(), notes)?;
    Ok(document)
}

/// Refuses what is neither a surface nor a set of points.
fn check_feature(document: &Document<'_>) -> Result<(), FileError> {
    let feature = document.required("Record1/FeatureType")?;
    if ["SUR", "PCL"].iter().any(|known| feature.eq_ignore_ascii_case(known)) {
        return Ok(());
    }
    let place = Document::place(document.at("Record1/FeatureType"));
    let found = format!("a feature of type {}", quoted(feature.as_bytes()));
    Err(unsupported(
        document.file,
        place,
        found,
        "save a surface (`SUR`) or points (`PCL`)",
    ))
}
