//! Readers of recorded signals: one type of result, whatever the file.
//!
//! | module | files |
//! |---|---|
//! | [`uff`] | universal files, dataset 58: text and binary (58b) |
//! | [`named`] | `.mat` (v5, v7) and `.npz`: arrays by name |
//! | [`csv`] | columns of text |
//! | [`wav`] | sound files |
//! | [`steps`] | tables of stepped-sine tests |
//!
//! Readers refuse what breaks the rules of the format and list what they pass over. Memory stays within a fixed multiple of
//! the file's size (of its unpacked size where a format packs).

pub mod csv;
pub mod named;
mod recording;
pub mod steps;
pub mod uff;
pub mod wav;

use std::path::Path;

use file_io::Source;

use crate::Error;
pub use recording::Recording;

/// Reads the file at `path`. Its beginning tells the format; what no other format begins with is read as CSV.
///
/// # Errors
/// [`Error::File`].
pub fn read(path: &Path) -> Result<Recording, Error> {
    let bytes = file_io::input::read(path, file_io::input::Kind::Record).map_err(matrix_files::Error::from)?;
    parse(Source {
        name: &path.to_string_lossy(),
        bytes: &bytes,
    })
}

/// Reads the bytes of a file of any of the formats.
///
/// # Errors
/// [`Error::File`].
pub fn parse(source: Source<'_>) -> Result<Recording, Error> {
    let bytes = source.bytes;
    let matlab = [&b"MATLAB"[..], b"\x89HDF"]
        .iter()
        .any(|start| bytes.starts_with(start))
        || matches!(bytes.get(124..128), Some([0, 1, b'I', b'M'] | [1, 0, b'M', b'I']));
    if matlab {
        return named::parse_matlab(source);
    }
    if bytes.starts_with(b"PK") {
        return named::parse_numpy(source);
    }
    if bytes.starts_with(b"RIFF") {
        return wav::parse(source);
    }
    let first_line = bytes
        .trim_ascii_start()
        .split(|b| *b == b'\n')
        .next()
        .unwrap_or_default();
    if first_line.trim_ascii() == b"-1" {
        return uff::parse(source);
    }
    csv::parse(source)
}
