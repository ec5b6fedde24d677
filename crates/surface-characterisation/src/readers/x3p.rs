//! X3P (ISO 25178-72): a ZIP archive with `main.xml` and the coordinates, there or in a binary member.
//!
//! Layout: ISO 25178-72:2017 with Amendment 1:2020, as the schema of openGPS (ISO 5436-2 XML) and its samples show it.
//! Lengths are metres: coordinate = increment x number + offset. Axes x and y count along the grid (incremental) or are
//! given for each point (absolute); such points must lie on a grid. Data types are `I`, `L` (integers of 16 and 32 bits),
//! `F`, `D` (floating point of 32 and 64 bits), least significant byte first. Missing are NaN, empty `Datum` elements and
//! points whose bit in the file of valid points is zero, counted from the least significant one. MD5 checksums that are
//! stated are verified; one that is absent is noted. A layer of several is chosen by [`Options::layer`].

use std::borrow::Cow;
use std::collections::BTreeMap;

use matrix_files::archive::Archive;
use matrix_files::{Place, Source};
use md5::{Digest, Md5};
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::Event;

use super::bytes::{latin_or_utf8, malformed, oversized, unsupported};
use super::grid::grid;
use super::{Format, Found, LengthUnit, Options, Scan, quoted, text, units};
use crate::error::FileError;

const MAIN: &str = "main.xml";
const CHECKSUM: &str = "md5checksum.hex";
const DATUM: &str = "Record3/DataList/Datum";

/// Whether a member of an archive is the document, at the top or in one folder.
pub(super) fn is_main(name: &str) -> bool {
    let path = plain(name);
    path == MAIN || path.split_once('/').is_some_and(|(_, rest)| rest == MAIN)
}

/// A member by its path from the folder of `main.xml`.
struct Members<'a> {
    file: &'a str,
    archive: Archive<'a>,
    paths: Vec<String>,
    read: usize,
}

impl<'a> Members<'a> {
    fn open(source: Source<'a>) -> Result<Self, FileError> {
        let archive = Archive::open(source)?;
        let mut paths: Vec<String> = archive.names()?.iter().map(|name| plain(name)).collect();
        let folder = paths
            .iter()
            .find(|path| is_main(path))
            .and_then(|path| path.strip_suffix(MAIN));
        if let Some(folder) = folder
            .map(str::to_owned)
            .filter(|folder| !paths.iter().any(|p| p == MAIN) && !folder.is_empty())
        {
            for path in &mut paths {
                *path = path.strip_prefix(&folder).unwrap_or_default().to_owned();
            }
        }
        Ok(Self {
            file: source.name,
            archive,
            paths,
            read: 0,
        })
    }

    fn get(&mut self, path: &str) -> Result<Option<Vec<u8>>, FileError> {
        let wanted = plain(path);
        let Some(index) = self.paths.iter().position(|path| *path == wanted) else {
            return Ok(None);
        };
        self.read += 1;
        Ok(Some(self.archive.member(index)?))
    }

    /// A member that the document refers to, checked against the checksum that the document states.
    fn linked(&mut self, path: &str, stated: Option<&str>, notes: &mut Vec<String>) -> Result<Vec<u8>, FileError> {
        let Some(bytes) = self.get(path)? else {
            let found = format!("no member {}", quoted(path.as_bytes()));
            return Err(malformed(self.file, Place::Byte(0), found, "what `main.xml` refers to"));
        };
        verify(self.file, path, &bytes, stated, notes)?;
        Ok(bytes)
    }
}

/// A path with slashes and without a beginning.
fn plain(path: &str) -> String {
    let path = path.replace('\\', "/");
    path.trim_start_matches("./").trim_start_matches('/').to_owned()
}

fn verify(
    file: &str,
    part: &str,
    bytes: &[u8],
    stated: Option<&str>,
    notes: &mut Vec<String>,
) -> Result<(), FileError> {
    let stated = stated.unwrap_or_default().trim();
    if stated.len() != 32 || !stated.bytes().all(|b| b.is_ascii_hexdigit()) {
        notes.push(format!("no checksum of `{}` to verify", part.escape_debug()));
        return Ok(());
    }
    let computed: String = Md5::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
    if computed.eq_ignore_ascii_case(stated) {
        return Ok(());
    }
    Err(FileError::Checksum {
        file: file.into(),
        part: part.into(),
        stated: stated.to_ascii_lowercase(),
        computed,
    })
}

/// `main.xml`: texts of elements by their path below the root, and the points that it lists.
struct Document<'a> {
    file: &'a str,
    fields: BTreeMap<String, (String, usize)>,
    /// As many numbers for each point as there are absolute axes, NaN if missing.
    datums: Vec<f64>,
    /// Number of absolute axes, known once points are listed: axes come before them.
    listed: Option<usize>,
}

impl<'a> Document<'a> {
    fn place(byte: usize) -> Place {
        Place::Inside {
            part: format!("`{MAIN}`"),
            byte,
        }
    }

    fn malformed(&self, byte: usize, found: impl ToString, expected: impl ToString) -> FileError {
        malformed(self.file, Self::place(byte), found, expected)
    }

    fn parse(file: &'a str, bytes: &[u8]) -> Result<Self, FileError> {
        let mut document = Self {
            file,
            fields: BTreeMap::new(),
            datums: Vec::new(),
            listed: None,
        };
        let decoded = text::decode(Source { name: file, bytes })?;
        let declared = decoded[..decoded.len().min(100)].to_ascii_lowercase();
        let latin = |name: &[u8]| declared.windows(name.len()).any(|w| w == name);
        let text = match str::from_utf8(&decoded) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) if latin(b"iso-8859-1") || latin(b"windows-1252") => Cow::Owned(latin_or_utf8(&decoded)),
            Err(e) => return Err(document.malformed(e.valid_up_to(), "bytes that are not UTF-8", "XML in UTF-8")),
        };
        let mut xml = quick_xml::Reader::from_str(&text);
        xml.config_mut().expand_empty_elements = true;
        // The path of the open element below the root, and its lengths before each element was opened.
        let (mut path, mut lengths) = (String::new(), Vec::new());
        let (mut content, mut leaf) = (String::new(), false);
        loop {
            let at = xml.buffer_position() as usize;
            let event = xml
                .read_event()
                .map_err(|e| document.malformed(xml.error_position() as usize, e, "well-formed XML"))?;
            match event {
                Event::Start(element) => {
                    let name = element.local_name();
                    let name: &str = name.as_ref();
                    if lengths.is_empty() && name != "ISO5436_2" {
                        return Err(document.malformed(at, quoted(name.as_bytes()), "the element `ISO5436_2`"));
                    }
                    lengths.push(path.len());
                    if lengths.len() > 1 {
                        if !path.is_empty() {
                            path.push('/');
                        }
                        path.push_str(name);
                    }
                    content.clear();
                    leaf = true;
                }
                Event::Text(part) if leaf => content.push_str(&part.into_inner()),
                Event::CData(part) if leaf => content.push_str(&part.into_inner()),
                Event::GeneralRef(name) if leaf => {
                    let character = name.resolve_char_ref().ok().flatten().map(String::from);
                    let known = character.or_else(|| resolve_predefined_entity(&name).map(str::to_owned));
                    match known {
                        Some(known) => content.push_str(&known),
                        // Entities that a document defines itself could grow without bound.
                        None if counts(&path) => {
                            return Err(document.malformed(at, format!("the entity `{}`", &*name), "text"));
                        }
                        None => {}
                    }
                }
                Event::End(_) => {
                    if std::mem::replace(&mut leaf, false) && counts(&path) {
                        document.leaf(&path, content.trim(), at)?;
                    }
                    path.truncate(lengths.pop().unwrap_or_default());
                }
                Event::Eof if lengths.is_empty() => return Ok(document),
                Event::Eof => return Err(document.malformed(at, "the end of the document", "its closing tags")),
                _ => {}
            }
        }
    }

    fn leaf(&mut self, path: &str, text: &str, at: usize) -> Result<(), FileError> {
        if path != DATUM {
            if self.fields.insert(path.into(), (text.into(), at)).is_some() {
                return Err(self.malformed(at, format!("a second element `{path}`"), "one"));
            }
            return Ok(());
        }
        let absolute = match self.listed {
            Some(absolute) => absolute,
            None => {
                let kind = |axis| self.text(&format!("Record1/Axes/{axis}/AxisType"));
                let absolute = AXES.into_iter().filter(|axis| kind(*axis) == Some("A")).count();
                self.listed = Some(absolute);
                absolute
            }
        };
        if text.is_empty() {
            self.datums.extend(std::iter::repeat_n(f64::NAN, absolute));
            return Ok(());
        }
        let before = self.datums.len();
        for number in text.split(';') {
            let value = number
                .trim()
                .parse()
                .map_err(|_| self.malformed(at, quoted(number.as_bytes()), "a number"))?;
            self.datums.push(value);
        }
        let found = self.datums.len() - before;
        if found != absolute {
            let expected = format!("{absolute}, one for each absolute axis");
            return Err(self.malformed(at, format!("{found} numbers"), expected));
        }
        Ok(())
    }

    /// Text of an element that is there and not empty.
    fn text(&self, path: &str) -> Option<&str> {
        let (text, _) = self.fields.get(path)?;
        Some(text.as_str()).filter(|text| !text.is_empty())
    }

    fn at(&self, path: &str) -> usize {
        self.fields.get(path).map_or(0, |(_, at)| *at)
    }

    fn required(&self, path: &str) -> Result<&str, FileError> {
        let missing = || self.malformed(self.at(path), "nothing", format!("the element `{path}`"));
        self.text(path).ok_or_else(missing)
    }

    fn real(&self, path: &str) -> Result<Option<f64>, FileError> {
        let Some(text) = self.text(path) else {
            return Ok(None);
        };
        let value = text.parse().ok().filter(|v: &f64| v.is_finite());
        let refused = || self.malformed(self.at(path), quoted(text.as_bytes()), format!("a number as `{path}`"));
        value.map(Some).ok_or_else(refused)
    }

    fn count(&self, path: &str) -> Result<u64, FileError> {
        let text = self.required(path)?;
        let refused = |_| {
            self.malformed(
                self.at(path),
                quoted(text.as_bytes()),
                format!("a whole number as `{path}`"),
            )
        };
        text.parse().map_err(refused)
    }
}

fn counts(path: &str) -> bool {
    path.len() <= 64
        && ["Record1/", "Record3/", "Record4/"]
            .iter()
            .any(|record| path.starts_with(record))
}

const AXES: [&str; 3] = ["CX", "CY", "CZ"];

#[derive(Clone, Copy)]
struct Axis {
    /// Type of the numbers, unless they are counted.
    data: Option<DataType>,
    increment: f64,
    offset: f64,
}

impl Axis {
    fn metres(&self, number: f64) -> f64 {
        let scaled = if self.increment == 1.0 {
            number
        } else {
            self.increment * number
        };
        // Adding zero would lose the sign of zeros.
        if self.offset == 0.0 {
            scaled
        } else {
            scaled + self.offset
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum DataType {
    I,
    L,
    F,
    D,
}

impl DataType {
    fn width(self) -> usize {
        match self {
            Self::I => 2,
            Self::L | Self::F => 4,
            Self::D => 8,
        }
    }

    /// The number at the start of a piece that is long enough.
    fn number(self, bytes: &[u8]) -> Option<f64> {
        Some(match self {
            Self::I => i16::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::L => i32::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::F => f32::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::D => f64::from_le_bytes(*bytes.first_chunk()?),
        })
    }
}

/// Reads a file.
///
/// # Errors
/// [`FileError`].
pub fn parse(source: Source<'_>, options: &Options) -> Result<Scan, FileError> {
    let file = source.name;
    let mut notes = Vec::new();
    let mut members = Members::open(source)?;
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
    verify(file, MAIN, &main, checksum.split_whitespace().next(), &mut notes)?;

    let feature = document.required("Record1/FeatureType")?;
    if !["SUR", "PCL"].iter().any(|known| feature.eq_ignore_ascii_case(known)) {
        let place = Document::place(document.at("Record1/FeatureType"));
        let found = format!("a feature of type {}", quoted(feature.as_bytes()));
        return Err(unsupported(
            file,
            place,
            found,
            "save a surface (`SUR`) or points (`PCL`)",
        ));
    }
    let mut rotated = false;
    for row in 1..=3 {
        for column in 1..=3 {
            let entry = document.real(&format!("Record1/Axes/Rotation/r{row}{column}"))?;
            let unit = f64::from(u8::from(row == column));
            // Angles below 1e-6 move no point of a field by as much as a step.
            rotated |= (entry.unwrap_or(unit) - unit).abs() > 1e-6;
        }
    }
    let mut axes = [Axis {
        data: None,
        increment: 1.0,
        offset: 0.0,
    }; 3];
    for (name, axis) in AXES.iter().zip(&mut axes) {
        *axis = read_axis(&document, name)?;
    }
    if axes[2].data.is_none() {
        let at = document.at("Record1/Axes/CZ/AxisType");
        return Err(document.malformed(at, "an incremental axis z", "an absolute one"));
    }
    if rotated {
        let offsets = axes.map(|axis| axis.offset);
        notes.push(format!(
            "rotation and offsets {offsets:?} m not applied: the map is in the axes of its grid"
        ));
        axes.iter_mut().for_each(|axis| axis.offset = 0.0);
    }

    let matrix = document.text("Record3/ListDimension").is_none();
    let [nx, ny, layers] = if matrix {
        let size = ["SizeX", "SizeY", "SizeZ"].map(|q| document.count(&format!("Record3/MatrixDimension/{q}")));
        let [nx, ny, nz] = size;
        [nx?, ny?, nz?]
    } else {
        [document.count("Record3/ListDimension")?, 1, 1]
    };
    let size_at = document.at(if matrix {
        "Record3/MatrixDimension/SizeX"
    } else {
        "Record3/ListDimension"
    });
    let absolute: Vec<DataType> = axes.iter().filter_map(|axis| axis.data).collect();

    let link = document.text("Record3/DataLink/PointDataLink");
    // Where the numbers of all points stand, how many there are for each (bytes if linked), and how many in all.
    let data;
    let valid;
    let (part, width, held) = match link {
        Some(link) => {
            let stated = document.text("Record3/DataLink/MD5ChecksumPointData");
            data = members.linked(link, stated, &mut notes)?;
            valid = match document.text("Record3/DataLink/ValidPointsLink") {
                Some(link) => {
                    let stated = document.text("Record3/DataLink/MD5ChecksumValidPoints");
                    Some((link, members.linked(link, stated, &mut notes)?))
                }
                None => None,
            };
            let width = absolute.iter().map(|d| d.width()).sum();
            (plain(link), width, data.len())
        }
        None if document.listed.is_some() => {
            data = Vec::new();
            valid = None;
            (MAIN.into(), absolute.len(), document.datums.len())
        }
        None => return Err(document.malformed(0, "no points", "`DataLink` or `DataList` in `Record3`")),
    };
    let stated = u128::from(nx).saturating_mul(ny.into()).saturating_mul(layers.into());
    let possible = held / width;
    if stated > possible as u128 {
        return Err(oversized(
            file,
            Document::place(size_at),
            "the number of points",
            stated,
            possible,
        ));
    }
    if stated * width as u128 != held as u128 {
        let place = Place::Inside {
            part: format!("`{}`", part.escape_debug()),
            byte: if link.is_none() { 0 } else { stated as usize * width },
        };
        return Err(malformed(
            file,
            place,
            format!("data of {possible} points or more"),
            format!("{stated} points"),
        ));
    }
    let [nx, ny, layers] = [nx as usize, ny as usize, layers as usize];
    let layer = match (layers, options.layer) {
        (1, None) => 0,
        (_, Some(layer)) if layer < layers => layer,
        _ => {
            return Err(FileError::Choice {
                file: file.into(),
                found: format!("{layers} layers, numbered from 0"),
                option: "layer",
            });
        }
    };
    let per_layer = nx * ny;
    let first = layer * per_layer;
    if let Some((link, bits)) = &valid {
        let expected = (per_layer * layers).div_ceil(8);
        if bits.len() != expected {
            let place = Place::Inside {
                part: format!("`{}`", link.escape_debug()),
                byte: bits.len().min(expected),
            };
            return Err(malformed(
                file,
                place,
                format!("{} bytes", bits.len()),
                format!("{expected}, a bit per point"),
            ));
        }
    }
    let is_valid = |k: usize| valid.as_ref().is_none_or(|(_, bits)| bits[k / 8] >> (k % 8) & 1 == 1);
    // Coordinate `column` of the absolute ones.
    let number = |k: usize, column: usize| {
        if link.is_none() {
            return document.datums[k * width + column];
        }
        let skipped: usize = absolute[..column].iter().map(|d| d.width()).sum();
        let bytes = data.get(k * width + skipped..).unwrap_or_default();
        absolute[column].number(bytes).unwrap_or(f64::NAN)
    };
    let last = absolute.len() - 1;
    let height = |k: usize| {
        if is_valid(k) {
            axes[2].metres(number(k, last))
        } else {
            f64::NAN
        }
    };

    let (size, step, origin, heights) = match (axes[0].data, axes[1].data) {
        (None, None) if matrix => {
            let heights = (first..first + per_layer).map(height).collect();
            let step = [axes[0].increment, axes[1].increment];
            ([nx, ny], step, [axes[0].offset, axes[1].offset], heights)
        }
        (x, y) if matrix || x.is_some() && y.is_some() => {
            let mut points = Vec::with_capacity(per_layer);
            for k in first..first + per_layer {
                let index = [(k - first) % nx, (k - first) / nx];
                let mut point = [0.0, 0.0, height(k)];
                let mut column = 0;
                for q in 0..2 {
                    point[q] = if axes[q].data.is_some() {
                        column += 1;
                        axes[q].metres(number(k, column - 1))
                    } else {
                        axes[q].metres(index[q] as f64)
                    };
                }
                if is_valid(k) && point[0].is_finite() && point[1].is_finite() {
                    points.push((k, point));
                }
            }
            let (indices, points): (Vec<_>, Vec<_>) = points.into_iter().unzip();
            let place = |index: usize| Place::Inside {
                part: format!("`{}`", part.escape_debug()),
                byte: if link.is_none() {
                    0
                } else {
                    indices.get(index).map_or(0, |k| k * width)
                },
            };
            let found = grid(file, &points, place)?;
            if found.deviation > 0.0 {
                notes.push(format!(
                    "points lie up to {:.1e} steps beside their grid",
                    found.deviation
                ));
            }
            (found.size, found.step, found.origin, found.heights)
        }
        _ => {
            let found = "a list of points with an incremental axis";
            return Err(document.malformed(size_at, found, "absolute axes, or a matrix"));
        }
    };
    let others = members
        .paths
        .iter()
        .filter(|path| !path.is_empty() && !path.ends_with('/'))
        .count();
    if others > members.read {
        notes.push(format!(
            "{} other members of the archive ignored",
            others - members.read
        ));
    }
    let integers = matches!(axes[2].data, Some(DataType::I | DataType::L));
    let [lateral_unit, height_unit] = units(file, options, Some(LengthUnit::Metre), Some(LengthUnit::Metre))?;
    Found {
        format: Format::X3p,
        size,
        step,
        origin,
        heights,
        lateral_unit,
        height_unit,
        stated_step: integers.then_some(axes[2].increment.abs()),
        rows_open: false,
        notes,
    }
    .finish(file, options)
}

fn read_axis(document: &Document<'_>, name: &str) -> Result<Axis, FileError> {
    let path = |field: &str| format!("Record1/Axes/{name}/{field}");
    let refused = |field: &str, found: &str, expected: &str| {
        let path = path(field);
        document.malformed(
            document.at(&path),
            quoted(found.as_bytes()),
            format!("{expected} as `{path}`"),
        )
    };
    let data = match document.required(&path("AxisType"))? {
        "I" => None,
        "A" => Some(match document.required(&path("DataType"))? {
            "I" => DataType::I,
            "L" => DataType::L,
            "F" => DataType::F,
            "D" => DataType::D,
            other => return Err(refused("DataType", other, "I, L, F or D")),
        }),
        other => return Err(refused("AxisType", other, "I or A")),
    };
    let increment = match document.real(&path("Increment"))? {
        Some(0.0) => return Err(refused("Increment", "0", "a number that is not zero")),
        Some(increment) => increment,
        None if data.is_some() => 1.0,
        None => return Err(refused("Increment", "", "the length of a step")),
    };
    Ok(Axis {
        data,
        increment,
        offset: document.real(&path("Offset"))?.unwrap_or(0.0),
    })
}
