//! Text: a line of heights per line of points, or `x y z` on each line.
//!
//! Columns are separated by semicolons, tabs, commas or spaces, in this order of precedence. A comma is a decimal point
//! where another separator is there (spaces: between numbers) and no number has a point; a comma before a space separates. Lines of
//! three numbers are points, unless [`Options::format`] says [`Format::Grid`]. Missing are `NaN`, `BAD`, stars and empty
//! cells; a separator at the end of every line opens no column. Encodings are ASCII and what contains it (UTF-8,
//! Latin-1), and UTF-16 with a byte order mark.
//!
//! Lines before the numbers, lines that begin with `#`, `%` or `//`, and empty lines are no data. Of the former two, those
//! before the numbers may state units and steps: `lateral_unit`, `height_unit`, `dx`, `dy`, `x0`, `y0` as
//! [`crate::writers::csv`] writes them; `Width`, `Height` (of the whole field) and `Value units` of Gwyddion; three units
//! in brackets or parentheses, `x [mm] y [mm] z [um]`.

use file_io::{Place, Source, quoted};
use std::borrow::Cow;

use super::bytes::{latin_or_utf8, malformed};
use super::format::Format;
use super::grid::{Gridded, grid};
use super::options::Options;
use super::scan::{RawGrid, Scan};
use super::units::LengthUnit;
use crate::error::FileError;

pub(super) const UTF8_MARK: &[u8] = b"\xef\xbb\xbf";

pub(super) fn is_utf16(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff")
}

/// The text in ASCII or what contains it, without a byte order mark.
pub(super) fn decode(source: Source<'_>) -> Result<Cow<'_, [u8]>, FileError> {
    if !is_utf16(source.bytes) {
        return Ok(source.bytes.strip_prefix(UTF8_MARK).unwrap_or(source.bytes).into());
    }
    let (pairs, odd) = source.bytes[2..].as_chunks::<2>();
    let big = source.bytes[0] == 0xfe;
    let units = pairs.iter().map(|pair| match big {
        true => u16::from_be_bytes(*pair),
        false => u16::from_le_bytes(*pair),
    });
    let mut text = String::with_capacity(pairs.len());
    let mut at = 2;
    for found in char::decode_utf16(units) {
        let character = found.map_err(|e| {
            malformed(
                source.name,
                Place::Byte(at),
                format!("half a character ({e})"),
                "UTF-16",
            )
        })?;
        at += 2 * character.len_utf16();
        text.push(character);
    }
    if !odd.is_empty() {
        return Err(malformed(source.name, Place::Byte(at), "an odd byte", "UTF-16"));
    }
    Ok(text.into_bytes().into())
}

/// Lines without their ends, with their numbers from one. Only text without line feeds is cut at carriage returns.
pub(super) fn lines(text: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let end = if text.contains(&b'\n') { b'\n' } else { b'\r' };
    let lines = (1..).zip(text.split(move |b| *b == end));
    lines.map(|(number, line)| (number, line.strip_suffix(b"\r").unwrap_or(line)))
}

/// Whether a cell says that there is no height.
pub(super) fn is_missing(cell: &[u8]) -> bool {
    cell.iter().all(|b| *b == b'*') || cell.eq_ignore_ascii_case(b"nan") || cell.eq_ignore_ascii_case(b"bad")
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Blank,
    Comment,
    Numbers,
    Words,
}

fn kind(line: &[u8]) -> Kind {
    let trimmed = line.trim_ascii();
    if trimmed.is_empty() {
        return Kind::Blank;
    }
    if matches!(trimmed, [b'#' | b'%', ..] | [b'/', b'/', ..]) {
        return Kind::Comment;
    }
    let number = |cell: &[u8]| {
        let allowed = |b: &u8| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.' | b'e' | b'E');
        is_missing(cell) || cell.iter().all(allowed) && cell.iter().any(u8::is_ascii_digit)
    };
    let mut cells = trimmed.split(|b| matches!(b, b';' | b'\t' | b',' | b' '));
    if cells.all(number) { Kind::Numbers } else { Kind::Words }
}

/// What lines before the numbers state, in the units of the file.
#[derive(Default)]
struct Header {
    lateral: Option<LengthUnit>,
    height: Option<LengthUnit>,
    step: [Option<f64>; 2],
    origin: [Option<f64>; 2],
    /// Of the whole field.
    extent: [Option<f64>; 2],
}

impl Header {
    fn read(&mut self, file: &str, number: usize, line: &[u8]) -> Result<(), FileError> {
        let text = latin_or_utf8(line);
        let text = text.trim_start_matches(['#', '%', '/', ' ']).trim();
        let place = || Place::Line(number);
        let unit = |text: &str| {
            text.parse::<LengthUnit>().map_err(|source| FileError::Unit {
                file: file.into(),
                place: place(),
                source,
            })
        };
        let real = |text: &str| {
            let value = text.trim().parse().ok().filter(|v: &f64| v.is_finite());
            value.ok_or_else(|| malformed(file, place(), quoted(text.as_bytes()), "a number"))
        };
        let conflict = |found: &str| {
            malformed(
                file,
                place(),
                format!("a second unit ({found})"),
                "one unit for x and y",
            )
        };
        let mut lateral = |found: LengthUnit| match self.lateral.replace(found) {
            Some(before) if before != found => Err(conflict(found.symbol())),
            _ => Ok(()),
        };
        if let Some((key, value)) = text.split_once(['=', ':']) {
            let (key, value) = (key.trim().to_ascii_lowercase(), value.trim());
            match key.as_str() {
                "lateral_unit" => lateral(unit(value)?)?,
                "height_unit" | "value units" => self.height = Some(unit(value)?),
                "dx" => self.step[0] = Some(real(value)?),
                "dy" => self.step[1] = Some(real(value)?),
                "x0" => self.origin[0] = Some(real(value)?),
                "y0" => self.origin[1] = Some(real(value)?),
                "width" | "height" => {
                    let expected = || malformed(file, place(), quoted(value.as_bytes()), "a length with its unit");
                    let (number, symbol) = value.split_once(char::is_whitespace).ok_or_else(expected)?;
                    lateral(unit(symbol)?)?;
                    self.extent[usize::from(key == "height")] = Some(real(number)?);
                }
                _ => {}
            }
            return Ok(());
        }
        let enclosed = text
            .split(['[', '('])
            .skip(1)
            .filter_map(|part| part.split([']', ')']).next());
        let found: Vec<_> = enclosed.map(str::parse::<LengthUnit>).collect();
        if let [Ok(x), Ok(y), Ok(z)] = found[..] {
            lateral(x)?;
            lateral(y)?;
            self.height = Some(z);
        }
        Ok(())
    }
}

/// How numbers and columns are written.
#[derive(Clone, Copy)]
struct Style {
    /// Any number of spaces or tabs if `None`.
    separator: Option<u8>,
    decimal_comma: bool,
}

impl Style {
    fn of<'a>(file: &str, lines: impl Iterator<Item = (usize, &'a [u8])>) -> Result<Self, FileError> {
        let [mut semicolon, mut tab, mut gap, mut inner] = [false; 4];
        // The first lines with a comma and with a point.
        let [mut comma, mut point] = [None; 2];
        for (number, line) in lines {
            let line = line.trim_ascii();
            // The last byte that is no space, and whether spaces follow it.
            let (mut before, mut spaced) = (0u8, false);
            for (i, b) in line.iter().enumerate() {
                if *b == b' ' {
                    spaced = true;
                    continue;
                }
                inner |= spaced && before.is_ascii_digit() && (b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'*'));
                (before, spaced) = (*b, false);
                match b {
                    b';' => semicolon = true,
                    b'\t' => tab = true,
                    b'.' => point = point.or(Some(number)),
                    b',' => {
                        comma = comma.or(Some(number));
                        gap |= line.get(i + 1).is_none_or(|next| *next == b' ');
                    }
                    _ => {}
                }
            }
        }
        let separator = match (semicolon, tab) {
            (true, _) => Some(b';'),
            (false, true) => Some(b'\t'),
            (false, false) if comma.is_none() => None,
            (false, false) if point.is_none() && !gap && inner => None,
            (false, false) => Some(b','),
        };
        let decimal_comma = comma.is_some() && separator != Some(b',');
        match (decimal_comma, comma.max(point), point) {
            (true, Some(line), Some(_)) => Err(malformed(
                file,
                Place::Line(line),
                "numbers with points and others with commas",
                "one of them as decimal point, and none between thousands",
            )),
            _ => Ok(Self {
                separator,
                decimal_comma,
            }),
        }
    }

    /// A number, NaN if missing.
    fn number(self, cell: &[u8]) -> Option<f64> {
        if is_missing(cell) {
            return Some(f64::NAN);
        }
        let text = str::from_utf8(cell).ok()?;
        let value = if self.decimal_comma && text.contains(',') {
            text.replacen(',', ".", 1).parse()
        } else {
            text.parse()
        };
        value.ok().filter(|v: &f64| v.is_finite())
    }

    /// Appends the numbers of a line; says whether its last cell is empty.
    fn numbers(self, file: &str, number: usize, line: &[u8], to: &mut Vec<f64>) -> Result<bool, FileError> {
        let mut last_empty = false;
        let mut push = |cell: &[u8]| {
            let value = self.number(cell);
            to.push(value.ok_or_else(|| malformed(file, Place::Line(number), quoted(cell), "a number"))?);
            last_empty = cell.is_empty();
            Ok::<_, FileError>(())
        };
        match self.separator {
            None => {
                let cells = line.split(u8::is_ascii_whitespace);
                cells.filter(|cell| !cell.is_empty()).try_for_each(&mut push)?;
            }
            Some(separator) => {
                let cells = line.split(|b| *b == separator);
                cells.map(<[u8]>::trim_ascii).try_for_each(&mut push)?;
            }
        }
        Ok(last_empty)
    }
}

/// Reads a text of either kind.
///
/// # Errors
/// [`FileError`].
pub fn parse(source: Source<'_>, options: &Options) -> Result<Scan, FileError> {
    let file = source.name;
    let text = decode(source)?;
    let mut notes = Vec::new();
    let (header, first) = read_header(file, &text, options.header_lines, &mut notes)?;
    let table = Table::read(file, &text, first, &mut notes)?;
    let place = |row: usize| Place::Line(data(&text, first).nth(row).map_or(first, |(number, _)| number));

    let [lateral_unit, height_unit] = options.units(file, header.lateral, header.height)?;
    let (lateral, height) = (lateral_unit.unit(), height_unit.unit());
    let format = if table.columns == 3 && options.format != Some(Format::Grid) {
        Format::Xyz
    } else {
        Format::Grid
    };
    let mut found = match format {
        Format::Xyz => table.points(file, place, &mut notes)?,
        _ if options.format == Some(Format::Xyz) => {
            return Err(malformed(
                file,
                Place::Line(first),
                format!("{} columns", table.columns),
                "x, y and z",
            ));
        }
        _ => table.grid(file, &header, options)?,
    };
    let metres = |pair: [f64; 2]| pair.map(|value| lateral.metres(value));
    found.heights.iter_mut().for_each(|z| *z = height.metres(*z));
    RawGrid {
        format,
        size: found.size,
        step: metres(found.step),
        origin: metres(found.origin),
        heights: found.heights,
        lateral_unit,
        height_unit,
        stated_step: None,
        rows_open: format == Format::Grid,
        notes,
    }
    .finish(file, options)
}

/// What stands before the numbers, and the line of the first of them.
fn read_header(
    file: &str,
    text: &[u8],
    header_lines: Option<usize>,
    notes: &mut Vec<String>,
) -> Result<(Header, usize), FileError> {
    let mut header = Header::default();
    let mut skipped = 0;
    for (number, line) in lines(text) {
        let kind = kind(line);
        let before = match header_lines {
            Some(stated) => number <= stated,
            None => kind != Kind::Numbers,
        };
        if !before && !matches!(kind, Kind::Blank | Kind::Comment) {
            if skipped > 0 {
                notes.push(format!(
                    "{skipped} lines before the numbers searched for units and steps alone"
                ));
            }
            return Ok((header, number));
        }
        if kind != Kind::Blank {
            header.read(file, number, line)?;
            skipped += 1;
        }
    }
    Err(malformed(
        file,
        Place::Line(lines(text).count()),
        "the end of the file",
        "a line of numbers",
    ))
}

/// The lines with data from line `first` on, with their numbers.
fn data(text: &[u8], first: usize) -> impl Iterator<Item = (usize, &[u8])> {
    lines(text).skip(first - 1).filter(|(_, line)| {
        let trimmed = line.trim_ascii();
        // A line of tabs is one of empty cells.
        let blank = trimmed.is_empty() && !line.contains(&b'\t');
        !blank && !matches!(trimmed, [b'#' | b'%', ..] | [b'/', b'/', ..])
    })
}

/// The numbers of all lines, in the units of the file.
struct Table {
    columns: usize,
    rows: usize,
    /// Line by line.
    numbers: Vec<f64>,
}

impl Table {
    fn read(file: &str, text: &[u8], first: usize, notes: &mut Vec<String>) -> Result<Self, FileError> {
        let style = Style::of(file, data(text, first))?;
        let mut numbers = Vec::new();
        let (mut columns, mut rows, mut open_ends) = (0, 0, 0);
        for (number, line) in data(text, first) {
            if style.separator != Some(b'\t') && line.trim_ascii().is_empty() {
                continue;
            }
            let before = numbers.len();
            open_ends += usize::from(style.numbers(file, number, line, &mut numbers)?);
            let found = numbers.len() - before;
            if rows == 0 {
                columns = found;
            } else if found != columns {
                let expected = format!("{columns}, as in line {first}");
                return Err(malformed(
                    file,
                    Place::Line(number),
                    format!("{found} columns"),
                    expected,
                ));
            }
            rows += 1;
        }
        if open_ends == rows && columns > 1 {
            let kept = columns - 1;
            for j in 0..rows {
                numbers.copy_within(j * columns..j * columns + kept, j * kept);
            }
            numbers.truncate(rows * kept);
            columns = kept;
            notes.push("the separator at the end of every line opens no column".into());
        }
        Ok(Self { columns, rows, numbers })
    }

    /// The grid that lines of x, y and z form; `place` tells where a line stands.
    fn points(
        &self,
        file: &str,
        place: impl Fn(usize) -> Place,
        notes: &mut Vec<String>,
    ) -> Result<Gridded, FileError> {
        let points = self.numbers.as_chunks::<3>().0;
        if let Some(row) = points.iter().position(|p| p[0].is_nan() || p[1].is_nan()) {
            return Err(malformed(file, place(row), "a point without position", "x and y"));
        }
        let found = grid(file, points, place)?;
        if found.deviation > 0.0 {
            notes.push(format!(
                "points lie up to {:.1e} steps beside their grid",
                found.deviation
            ));
        }
        Ok(found)
    }

    /// The grid whose lines of heights these are.
    fn grid(self, file: &str, header: &Header, options: &Options) -> Result<Gridded, FileError> {
        let stated = match (header.step, header.extent) {
            ([Some(dx), Some(dy)], _) => Some([dx, dy]),
            (_, [Some(width), Some(height)]) => Some([width / self.columns as f64, height / self.rows as f64]),
            _ => None,
        };
        Ok(Gridded {
            size: [self.columns, self.rows],
            step: options.steps(file, Format::Grid, stated)?,
            origin: header.origin.map(Option::unwrap_or_default),
            heights: self.numbers,
            deviation: 0.0,
        })
    }
}
