//! Errors of this crate.

use std::io;
use std::num::ParseIntError;

/// An error with its causes in one line. A cause that the text before states already is not said again.
pub fn with_causes(error: &dyn std::error::Error) -> String {
    let mut text = String::new();
    let mut next = Some(error);
    while let Some(error) = next {
        let cause = error.to_string();
        if !text.contains(&cause) {
            let separator = if text.is_empty() { "" } else { ": " };
            text += separator;
            text += &cause;
        }
        next = error.source();
    }
    text
}

/// Why a scene is not found, or why it is not known where its results come from.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A scene cannot be read, or a file that it names.
    #[error(transparent)]
    Scene(#[from] analyses::Error),
    /// There is no benchmark of this name.
    #[error("there is no benchmark `{name}`; there are {known}")]
    NoBenchmark {
        /// Name asked for.
        name: String,
        /// Names there are.
        known: String,
    },
    /// A benchmark has no scene of this name.
    #[error("{benchmark} has no scene `{name}`; it has {known}")]
    NoScene {
        /// Name of the benchmark.
        benchmark: &'static str,
        /// Name asked for.
        name: String,
        /// Names there are.
        known: String,
    },
    /// The date that the environment gives is none.
    #[error("SOURCE_DATE_EPOCH = `{text}` is no whole number of seconds since 1970")]
    Date {
        /// Value of the variable.
        text: String,
        /// Why it is no number.
        source: ParseIntError,
    },
    /// The working directory is gone.
    #[error("finding the working directory")]
    WorkingDirectory(#[source] io::Error),
}

impl From<scenes::Error> for Error {
    fn from(error: scenes::Error) -> Self {
        Self::Scene(error.into())
    }
}
