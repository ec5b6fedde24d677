//! NumPy: a matrix of heights as `.npy`, or in an archive (`.npz`). Rows are lines of points along x, NaN is missing.
//!
//! The format has no place for units and steps: [`Options`] must name them. Other arrays of an archive are noted.

use file_io::{Place, Source};
use matrix_files::npz;
use matrix_files::value::{Array, Dense};

use super::bytes::{malformed, unsupported};
use super::format::Format;
use super::options::Options;
use super::scan::{RawGrid, Scan};
use crate::error::FileError;

/// Reads an array, or an archive of arrays.
///
/// # Errors
/// [`FileError`].
pub fn parse(source: Source<'_>, options: &Options) -> Result<Scan, FileError> {
    let mut notes = Vec::new();
    let (format, array) = if source.bytes.starts_with(b"PK") {
        let found = npz::parse_measured(source)?;
        let mut maps = Vec::new();
        let mut others: Vec<String> = found.skipped.into_iter().map(|s| s.name).collect();
        for (name, array) in found.arrays {
            let wanted = match &options.array {
                Some(wanted) => *wanted == name,
                None => shape(&array).is_some_and(|[rows, columns]| rows.min(columns) >= 3),
            };
            if wanted {
                maps.push((name, array));
            } else {
                others.push(name);
            }
        }
        if maps.len() != 1 {
            let names = maps.iter().map(|(name, _)| name).chain(&others);
            let names: Vec<_> = names.map(|name| format!("`{}`", name.escape_debug())).collect();
            return Err(FileError::Choice {
                file: source.name.into(),
                found: format!("the arrays {}", names.join(", ")),
                option: "array",
            });
        }
        if !others.is_empty() {
            notes.push(format!("arrays ignored: {}", others.join(", ")));
        }
        (Format::Npz, maps.remove(0).1)
    } else {
        (Format::Npy, npz::parse_measured_array(source)?)
    };
    let (size, heights) = match array {
        Array::Dense(m) => by_lines(&m, Some),
        // Every integer below 2^53 is a double.
        Array::Integers(m) => by_lines(&m, |z| (z.unsigned_abs() <= 1 << 53).then_some(z as f64)),
        _ => {
            let found = "an array that is no matrix of numbers";
            return Err(unsupported(
                source.name,
                Place::Byte(0),
                found,
                "save a matrix of heights",
            ));
        }
    };
    let heights = heights.ok_or_else(|| {
        malformed(
            source.name,
            Place::Byte(0),
            "an integer beyond 2^53",
            "heights that doubles hold",
        )
    })?;
    if size[0] == 3 {
        return Err(unsupported(
            source.name,
            Place::Byte(0),
            "a matrix of three columns, which may be positions and heights of points",
            "save the heights alone, a row for each line along x",
        ));
    }
    let [lateral_unit, height_unit] = options.units(source.name, None, None)?;
    let step = options.steps(source.name, format, None)?;
    let metres = height_unit.unit();
    RawGrid {
        format,
        size,
        step: step.map(|d| lateral_unit.unit().metres(d)),
        origin: [0.0; 2],
        heights: heights.into_iter().map(|z| metres.metres(z)).collect(),
        lateral_unit,
        height_unit,
        stated_step: None,
        rows_open: true,
        notes,
    }
    .finish(source.name, options)
}

fn shape(array: &Array) -> Option<[usize; 2]> {
    match array {
        Array::Dense(m) => Some([m.rows(), m.columns()]),
        Array::Integers(m) => Some([m.rows(), m.columns()]),
        _ => None,
    }
}

/// Number of columns and rows, and the entries row by row.
fn by_lines<T: Copy>(m: &Dense<T>, height: impl Fn(T) -> Option<f64>) -> ([usize; 2], Option<Vec<f64>>) {
    let (rows, columns) = (m.rows(), m.columns());
    // No entries may come with any number of rows.
    let lines = if columns == 0 { 0 } else { rows };
    let entries = (0..lines).flat_map(|j| m.data()[j..].iter().step_by(rows));
    ([columns, rows], entries.map(|z| height(*z)).collect())
}
