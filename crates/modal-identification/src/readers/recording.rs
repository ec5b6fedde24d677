//! What the readers make of files, and what they share.

use file_io::{Place, Source};
use matrix_files::value::Skipped;

use crate::signal::{Channel, Timing};
use crate::{Error, Warning};

/// Names of channels in a message.
const MOST_NAMES: usize = 20;

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
        let more = names.len().saturating_sub(MOST_NAMES);
        names.truncate(MOST_NAMES);
        if more > 0 {
            names.push(format!("and {more} more"));
        }
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

/// One sample rate or list of times for all channels.
pub(super) fn recording(
    source: Source<'_>,
    timing: &Timing,
    channels: Vec<(String, Option<String>, Vec<f64>)>,
) -> Recording {
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

pub(super) fn malformed(source: Source<'_>, place: Place, found: impl ToString, expected: impl ToString) -> Error {
    let error = matrix_files::Error::Malformed {
        file: source.name.into(),
        place,
        found: found.to_string(),
        expected: expected.to_string(),
    };
    error.into()
}

/// Scale to seconds of a unit of time.
pub(super) fn seconds(unit: &str) -> Option<f64> {
    match unit.trim().to_lowercase().as_str() {
        "s" | "sec" | "second" | "seconds" => Some(1.0),
        "ms" | "msec" => Some(1e-3),
        "us" | "µs" | "μs" => Some(1e-6),
        _ => None,
    }
}
