//! Arrays by name: MATLAB files (`.mat`, v5 and v7) and NumPy archives (`.npz`), as [`matrix_files`] reads them.
//!
//! Vectors of numbers are channels, and so are the columns of matrices (the rows, if those are fewer), called `name:1`,
//! `name:2` and so on. What belongs to a channel is looked for beside it (fields of the same structure), then at the top:
//! - `time` or `t`: the times (s), as many as samples;
//! - `sample_rate` or `fs` (Hz), or `dt` (s), if there is no vector of times;
//! - the text `NAME_unit`, or `unit` or `units` for all.
//!
//! Capitals do not matter in these names.

use std::collections::BTreeMap;

use file_io::Source;
use matrix_files::value::{Array, Collection, Skipped};
use matrix_files::{mat, npz};

use super::recording::Recording;
use crate::Error;
use crate::signal::{Channel, Timing};

/// Reads a MATLAB file.
///
/// # Errors
/// [`Error::File`].
pub fn parse_matlab(source: Source<'_>) -> Result<Recording, Error> {
    Ok(channels(source, mat::parse(source)?))
}

/// Reads a NumPy archive.
///
/// # Errors
/// [`Error::File`].
pub fn parse_numpy(source: Source<'_>) -> Result<Recording, Error> {
    Ok(channels(source, npz::parse(source)?))
}

/// A full array of numbers.
struct Numbers {
    rows: usize,
    columns: usize,
    data: Vec<f64>,
}

fn channels(source: Source<'_>, collection: Collection) -> Recording {
    let mut found = Recording {
        file: source.name.into(),
        channels: Vec::new(),
        skipped: collection.skipped,
    };
    let mut texts: BTreeMap<String, String> = BTreeMap::new();
    let mut numbers: BTreeMap<String, Numbers> = BTreeMap::new();
    for (name, array) in collection.arrays {
        let of = |rows, columns, data| Numbers { rows, columns, data };
        match array {
            Array::Dense(m) => drop(numbers.insert(name, of(m.rows(), m.columns(), m.into_data()))),
            Array::Integers(m) => {
                let data = m.data().iter().map(|v| *v as f64).collect();
                numbers.insert(name, of(m.rows(), m.columns(), data));
            }
            Array::Text(text) => drop(texts.insert(name.to_lowercase(), text)),
            _ => found.skipped.push(Skipped {
                name,
                reason: "a sparse matrix is no signal".into(),
            }),
        }
    }
    let special: BTreeMap<String, &Numbers> = numbers
        .iter()
        .filter(|(name, _)| is_timing(last_part(name)))
        .map(|(name, n)| (name.to_lowercase(), n))
        .collect();
    for (name, array) in &numbers {
        if is_timing(last_part(name)) || array.data.len() < 2 {
            if !is_timing(last_part(name)) {
                let reason = "it has fewer than two numbers".into();
                found.skipped.push(Skipped {
                    name: name.clone(),
                    reason,
                });
            }
            continue;
        }
        let length = array.rows.max(array.columns);
        let count = array.data.len() / length;
        let timing = timing(name, length, &special);
        let unit = beside(name, &[&format!("{}_unit", last_part(name)), "unit", "units"], |key| {
            texts.get(key).map(|text| text.trim().to_owned())
        });
        // Stored by columns.
        let (next, first) = if array.rows < array.columns {
            (count, 1)
        } else {
            (1, length)
        };
        for i in 0..count {
            found.channels.push(Channel {
                name: if count > 1 {
                    format!("{name}:{}", i + 1)
                } else {
                    name.clone()
                },
                unit: unit.clone(),
                timing: timing.clone(),
                samples: array.data[i * first..]
                    .iter()
                    .step_by(next)
                    .take(length)
                    .copied()
                    .collect(),
            });
        }
    }
    for (name, array) in numbers.iter().filter(|(name, _)| is_timing(last_part(name))) {
        let count = array.data.len();
        if count != 1 && found.channels.iter().all(|c| c.samples.len() != count) {
            found.skipped.push(Skipped {
                name: name.clone(),
                reason: format!("no channel has its number of values, {count}"),
            });
        }
    }
    found
}

fn last_part(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

fn is_timing(name: &str) -> bool {
    ["time", "t", "sample_rate", "fs", "dt"]
        .iter()
        .any(|known| name.eq_ignore_ascii_case(known))
}

/// What is called by one of the names beside `name`, or at the top.
fn beside<T>(name: &str, names: &[&str], find: impl Fn(&str) -> Option<T>) -> Option<T> {
    let parent = name.rsplit_once('.').map(|(parent, _)| parent);
    let places = parent.into_iter().map(|p| format!("{p}.")).chain([String::new()]);
    places
        .flat_map(|place| names.iter().map(move |n| format!("{place}{n}").to_lowercase()))
        .find_map(|key| find(&key))
}

fn timing(name: &str, length: usize, special: &BTreeMap<String, &Numbers>) -> Timing {
    let of_length = |key: &str| special.get(key).filter(|n| n.data.len() == length && length > 1);
    let single = |key: &str| special.get(key).and_then(|n| (n.data.len() == 1).then(|| n.data[0]));
    if let Some(times) = beside(name, &["time", "t"], |key| of_length(key).map(|n| n.data.clone())) {
        return Timing::Times(times);
    }
    let rate = beside(name, &["sample_rate", "fs"], single);
    match rate.or_else(|| beside(name, &["dt"], single).map(|step| 1.0 / step)) {
        Some(rate) => Timing::Rate(rate),
        None => Timing::Unstated,
    }
}
