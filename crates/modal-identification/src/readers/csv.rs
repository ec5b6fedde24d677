//! Columns of text (`.csv`, `.txt`): separated by semicolons, tabulators or commas, whichever the first line has in this
//! order; with semicolons and tabulators numbers may have decimal commas. Lines that begin with `#` are comments.
//!
//! A first row that is not all numbers has the names, with units in brackets behind them or in a second row:
//! `time [s],acc [m/s^2]`. The column called `time` or `t`, or a first column in s, ms or us, has the times. Without names the
//! columns are called `1`, `2` and so on. Empty cells are missing samples.

use csv::{ByteRecord, ReaderBuilder, Trim};
use file_io::{Place, Source, quoted};

use super::recording::{Recording, malformed, recording, seconds};
use crate::Error;
use crate::signal::Timing;

/// Columns of a file.
const MOST_COLUMNS: usize = 1024;

/// A column.
#[derive(Default)]
struct Column {
    name: String,
    unit: Option<String>,
    values: Vec<f64>,
}

/// Reads all columns.
///
/// # Errors
/// [`Error::File`].
pub fn parse(source: Source<'_>) -> Result<Recording, Error> {
    let bytes = source.bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(source.bytes);
    if let Some(at) = bytes
        .iter()
        .position(|b| b.is_ascii_control() && !matches!(b, b'\t' | b'\n' | b'\r' | b'\x0c' | b'\x1a'))
    {
        return Err(malformed(
            source,
            Place::Byte(at + source.bytes.len() - bytes.len()),
            format!("{}, which is no text", quoted(&bytes[at..])),
            "a universal file, a MATLAB, NumPy or WAV file, or columns of numbers as text in UTF-8",
        ));
    }
    let mut lines = bytes.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with(b"#"));
    let first = first.unwrap_or_default();
    let delimiter = [b';', b'\t'].into_iter().find(|d| first.contains(d)).unwrap_or(b',');
    let number = |cell: &[u8]| -> Option<f64> {
        let text = std::str::from_utf8(cell).ok()?;
        match text.parse() {
            Ok(value) => Some(value),
            Err(_) if delimiter != b',' => text.replace(',', ".").parse().ok(),
            Err(_) => None,
        }
    };
    let mut reader = ReaderBuilder::new()
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .from_reader(bytes);
    let mut columns: Vec<Column> = Vec::new();
    let mut record = ByteRecord::new();
    let mut row = 0_usize;
    while (reader.read_byte_record(&mut record)).map_err(|e| malformed(source, Place::Line(1), e, "columns of text"))? {
        let line = Place::Line(record.position().map_or(0, |p| p.line()) as usize);
        if record.len() > MOST_COLUMNS {
            let most = format!("at most {MOST_COLUMNS}");
            return Err(malformed(source, line, format!("{} columns", record.len()), most));
        }
        let cells: Vec<&[u8]> = match record.iter().collect::<Vec<_>>() {
            // A separator behind the last column.
            cells
                if cells.len() > 1 && cells.last().is_some_and(|cell| cell.is_empty()) && {
                    row == 0 || cells.len() == columns.len() + 1
                } =>
            {
                cells[..cells.len() - 1].to_vec()
            }
            cells => cells,
        };
        row += 1;
        let numbers: Vec<Option<f64>> = cells.iter().map(|cell| number(cell)).collect();
        if row == 1 {
            let names = numbers.iter().any(Option::is_none);
            columns = cells
                .iter()
                .enumerate()
                .map(|(i, cell)| heading(i, names.then_some(*cell)))
                .collect();
            if names {
                continue;
            }
        }
        if cells.len() != columns.len() {
            let separator = match delimiter {
                b'\t' => "tabulators",
                b';' => "semicolons",
                _ => "commas",
            };
            return Err(malformed(
                source,
                line,
                format!("{} in {}", cells_of(cells.len()), quoted(&cells.join(&delimiter))),
                format!(
                    "{} between {separator}, as in the first row {}, or a record of another format (universal file, MATLAB, NumPy, WAV)",
                    cells_of(columns.len()),
                    quoted(first)
                ),
            ));
        }
        let all_text = numbers.iter().all(Option::is_none) && cells.iter().any(|cell| !cell.is_empty());
        if row == 2 && all_text {
            for (column, cell) in columns.iter_mut().zip(&cells) {
                let unit = String::from_utf8_lossy(cell);
                let unit = unit.trim_matches(['[', ']', '(', ')', ' ']);
                column.unit = (!unit.is_empty()).then(|| unit.into());
            }
            continue;
        }
        for ((column, cell), value) in columns.iter_mut().zip(&cells).zip(numbers) {
            match value {
                Some(value) => column.values.push(value),
                None if cell.is_empty() => column.values.push(f64::NAN),
                None => return Err(malformed(source, line, quoted(cell), "a number")),
            }
        }
    }
    let timing = take_timing(source, &mut columns)?;
    let channels = columns.into_iter().map(|c| (c.name, c.unit, c.values)).collect();
    Ok(recording(source, &timing, channels))
}

/// Takes out the column of times, if there is one.
fn take_timing(source: Source<'_>, columns: &mut Vec<Column>) -> Result<Timing, Error> {
    let is_time = |(i, column): (usize, &Column)| {
        let name = column.name.to_lowercase();
        name == "time" || name == "t" || i == 0 && column.unit.as_deref().and_then(seconds).is_some()
    };
    match columns.iter().enumerate().position(is_time) {
        None => Ok(Timing::Unstated),
        Some(i) => {
            let column = columns.remove(i);
            let unit = column.unit.as_deref().unwrap_or("s");
            let Some(scale) = seconds(unit) else {
                return Err(malformed(
                    source,
                    Place::Line(1),
                    format!("the unit `{unit}` of time"),
                    "s, ms or us",
                ));
            };
            let times = column.values.into_iter().map(|t| t * scale);
            Ok(Timing::Times(times.collect()))
        }
    }
}

fn cells_of(count: usize) -> String {
    format!("{count} {}", if count == 1 { "cell" } else { "cells" })
}

/// Name and unit from the first row.
fn heading(index: usize, cell: Option<&[u8]>) -> Column {
    let Some(cell) = cell.filter(|cell| !cell.is_empty()) else {
        let name = (index + 1).to_string();
        return Column {
            name,
            ..Column::default()
        };
    };
    let text = String::from_utf8_lossy(cell);
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((name, unit)) = text.strip_suffix(close).and_then(|text| text.rsplit_once(open)) {
            return Column {
                name: name.trim().into(),
                unit: Some(unit.trim().into()),
                values: Vec::new(),
            };
        }
    }
    Column {
        name: text.into_owned(),
        ..Column::default()
    }
}
