//! Sparse matrices from entries in any order.

use crate::Error;
use file_io::Place;
use sprs::CsMat;

/// An entry, counted from zero, and the line or byte it stands at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) row: usize,
    pub(crate) column: usize,
    pub(crate) value: f64,
    pub(crate) at: usize,
}

/// A file and what its places are: lines or bytes.
#[derive(Clone, Copy)]
pub(crate) struct Origin<'a> {
    pub(crate) file: &'a str,
    pub(crate) place: fn(usize) -> Place,
}

impl<'a> Origin<'a> {
    /// A file of text.
    pub(crate) fn lines(file: &'a str) -> Self {
        Self {
            file,
            place: Place::Line,
        }
    }
}

/// Compresses entries that must all stand at different places.
pub(crate) fn general(origin: Origin<'_>, shape: (usize, usize), mut entries: Vec<Entry>) -> Result<CsMat<f64>, Error> {
    entries.sort_unstable_by_key(|e| (e.row, e.column, e.at));
    if let Some([_, second]) = entries
        .array_windows()
        .find(|[a, b]| (a.row, a.column) == (b.row, b.column))
    {
        return Err(duplicate(origin, second));
    }
    Ok(compressed(shape, &entries))
}

/// Compresses entries of which those at the same place add up, in the order given.
pub(crate) fn summed(shape: (usize, usize), mut entries: Vec<Entry>) -> CsMat<f64> {
    entries.sort_by_key(|e| (e.row, e.column));
    entries.dedup_by(|later, first| {
        let same = (later.row, later.column) == (first.row, first.column);
        if same {
            first.value += later.value;
        }
        same
    });
    compressed(shape, &entries)
}

/// Fills both triangles of a symmetric matrix of which one is given, or both with equal values where `both` allows it.
pub(crate) fn symmetric(
    origin: Origin<'_>,
    size: usize,
    mut entries: Vec<Entry>,
    both: bool,
) -> Result<CsMat<f64>, Error> {
    let key = |e: &Entry| (e.row.min(e.column), e.row.max(e.column));
    entries.sort_unstable_by_key(|e| (key(e), e.row, e.at));
    let mut twins = 0;
    for [a, b] in entries.array_windows() {
        if key(a) == key(b) {
            if a.row == b.row || !both && a.value == b.value {
                return Err(duplicate(origin, if a.at > b.at { a } else { b }));
            }
            if a.value != b.value {
                return Err(asymmetric(origin, b, a.value));
            }
            twins += 1;
        }
    }
    if twins == 0 {
        let mirrored: Vec<Entry> = entries.iter().filter(|e| e.row != e.column).copied().collect();
        entries.extend(mirrored.iter().map(|e| Entry {
            row: e.column,
            column: e.row,
            ..*e
        }));
    } else {
        // Both triangles are given, so what stands in one alone is zero in the other.
        let alone = entries.chunk_by(|a, b| key(a) == key(b)).find(|pair| {
            let first = pair[0];
            pair.len() == 1 && first.row != first.column && first.value != 0.0
        });
        if let Some(pair) = alone {
            return Err(asymmetric(origin, &pair[0], 0.0));
        }
    }
    entries.sort_unstable_by_key(|e| (e.row, e.column));
    Ok(compressed((size, size), &entries))
}

/// From entries in order, all at different places inside the shape.
fn compressed(shape: (usize, usize), entries: &[Entry]) -> CsMat<f64> {
    let mut starts = vec![0; shape.0 + 1];
    for entry in entries {
        starts[entry.row + 1] += 1;
    }
    for row in 0..shape.0 {
        starts[row + 1] += starts[row];
    }
    let columns = entries.iter().map(|e| e.column).collect();
    CsMat::new(shape, starts, columns, entries.iter().map(|e| e.value).collect())
}

fn duplicate(origin: Origin<'_>, second: &Entry) -> Error {
    Error::Duplicate {
        file: origin.file.into(),
        place: (origin.place)(second.at),
        row: second.row + 1,
        column: second.column + 1,
    }
}

fn asymmetric(origin: Origin<'_>, entry: &Entry, mirrored: f64) -> Error {
    Error::Asymmetric {
        file: origin.file.into(),
        place: (origin.place)(entry.at),
        row: entry.row + 1,
        column: entry.column + 1,
        value: entry.value,
        mirrored,
    }
}
