//! Readers of recorded signals: one type of result, whatever the file.
//!
//! | module | files |
//! |---|---|
//! | [`uff`] | universal files, dataset 58: text and binary (58b) |
//! | [`named`] | `.mat` (v5, v7) and `.npz`: arrays by name |
//! | [`csv`] | columns of text |
//! | [`wav`] | sound files |
//!
//! Readers refuse what breaks the rules of the format and list what they pass over. Memory stays within a fixed multiple of
//! the file's size (of its unpacked size where a format packs).

pub mod csv;
pub mod named;
pub mod uff;
pub mod wav;

use std::path::Path;

use matrix_files::value::Skipped;
use matrix_files::{Place, Source};

use crate::signal::{Channel, Timing};
use crate::{Error, Warning};

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// File, for messages.
    pub file: String,
    /// Its channels, in the order of the file.
    pub channels: Vec<Channel>,
    /// What was not read.
    pub skipped: Vec<Skipped>,
}

impl Recording {
    /// The channels to identify: those called `name` (several of one name are successive hits), or all where all have one
    /// name; and what is worth knowing of the rest.
    ///
    /// # Errors
    /// [`Error::NoChannels`], [`Error::UnknownChannel`], [`Error::SeveralChannels`].
    pub fn select(&self, name: Option<&str>) -> Result<(Vec<&Channel>, Vec<Warning>), Error> {
        let file = self.file.clone();
        let Some(first) = self.channels.first() else {
            return Err(Error::NoChannels { file });
        };
        let mut names: Vec<String> = self.channels.iter().map(|c| format!("`{}`", c.name)).collect();
        names.dedup();
        let available = names.join(", ");
        let wanted = match name {
            Some(name) => name,
            None if self.channels.iter().any(|c| c.name != first.name) => {
                return Err(Error::SeveralChannels { file, available });
            }
            None => &first.name,
        };
        let (chosen, others): (Vec<&Channel>, Vec<&Channel>) = self.channels.iter().partition(|c| c.name == wanted);
        if chosen.is_empty() {
            let wanted = wanted.into();
            return Err(Error::UnknownChannel {
                file,
                wanted,
                available,
            });
        }
        let skipped = self.skipped.iter().map(|s| Warning::Skipped {
            name: s.name.clone(),
            reason: s.reason.clone(),
        });
        let constant = others
            .iter()
            .filter(|c| c.is_constant())
            .map(|c| Warning::ConstantChannel { name: c.name.clone() });
        Ok((chosen, skipped.chain(constant).collect()))
    }
}

/// Reads the file at `path`. Its beginning tells the format; what no other format begins with is read as CSV.
///
/// # Errors
/// [`Error::File`].
pub fn read(path: &Path) -> Result<Recording, Error> {
    let bytes = std::fs::read(path).map_err(|source| matrix_files::Error::Io {
        path: path.to_owned(),
        source,
    })?;
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

/// One sample rate or list of times for all channels.
fn recording(source: Source<'_>, timing: &Timing, channels: Vec<(String, Option<String>, Vec<f64>)>) -> Recording {
    let channel = |(name, unit, samples)| Channel {
        name,
        unit,
        timing: timing.clone(),
        samples,
    };
    Recording {
        file: source.name.into(),
        channels: channels.into_iter().map(channel).collect(),
        skipped: Vec::new(),
    }
}

fn malformed(source: Source<'_>, place: Place, found: impl ToString, expected: impl ToString) -> Error {
    let error = matrix_files::Error::Malformed {
        file: source.name.into(),
        place,
        found: found.to_string(),
        expected: expected.to_string(),
    };
    error.into()
}

/// The start of a piece of a file, for messages.
fn quoted(bytes: &[u8]) -> String {
    let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(40)]);
    format!("`{}`", shown.escape_debug())
}

/// Scale to seconds of a unit of time.
fn seconds(unit: &str) -> Option<f64> {
    match unit.trim().to_lowercase().as_str() {
        "s" | "sec" | "second" | "seconds" => Some(1.0),
        "ms" | "msec" => Some(1e-3),
        "us" | "µs" | "μs" => Some(1e-6),
        _ => None,
    }
}
