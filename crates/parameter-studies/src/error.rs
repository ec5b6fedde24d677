//! Errors of this crate.

use std::path::PathBuf;

/// Why a study cannot be done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The plan cannot be read.
    #[error(transparent)]
    InputFile(#[from] file_io::input::Error),
    /// The plan is not JSON, or has fields that plans do not have.
    #[error("{}: {message}", path.display())]
    Syntax {
        /// The plan.
        path: PathBuf,
        /// Field and remedy.
        message: String,
    },
    /// Something in the plan cannot be done.
    #[error("{plan}: {field}: {reason}")]
    Plan {
        /// The plan.
        plan: String,
        /// Field within the plan.
        field: String,
        /// Value, and what would be accepted.
        reason: String,
    },
    /// A parameter names nothing in the scene.
    #[error("{plan}: {pointer} = {value} names nothing in the scene: {reason}")]
    Pointer {
        /// The plan.
        plan: String,
        /// JSON pointer of the parameter.
        pointer: String,
        /// Value that was to be put there.
        value: String,
        /// What is there, and what can be done.
        reason: String,
    },
    /// The scene of a case is not admissible.
    #[error("{0}")]
    Case(#[source] analyses::Error),
    /// The scene of the plan, or an analysis.
    #[error(transparent)]
    Scene(#[from] analyses::Error),
    /// A file of the store.
    #[error(transparent)]
    Store(#[from] file_io::durable::Error),
    /// A part that the study does not have.
    #[error("part {text} is not K/N with whole numbers from 1 on and K at most N, such as 3/20")]
    Part {
        /// As it was given.
        text: String,
    },
    /// A finished case could not be encoded.
    #[error("encoding the case {case}")]
    Encoding {
        /// Its address.
        case: String,
        /// Why.
        source: serde_json::Error,
    },
    /// Cases that no worker has finished.
    #[error(
        "{pending} of {cases} cases are not finished, in parts {parts}, after {tries} tries of each; read the logs in {}, and give the same \
         command again to go on",
        logs.display()
    )]
    Unfinished {
        /// Cases that are missing.
        pending: usize,
        /// Of so many.
        cases: usize,
        /// The parts they are in.
        parts: String,
        /// Times that each was submitted.
        tries: usize,
        /// Where its logs are.
        logs: PathBuf,
    },
    /// A program of the scheduler failed.
    #[error("{program}: {reason}")]
    Scheduler {
        /// The program.
        program: &'static str,
        /// What it says, and what can be done.
        reason: String,
    },
    /// A table could not be written as comma-separated values.
    #[error("writing a table")]
    Table(#[from] csv::Error),
    /// A table could not be written as Parquet.
    #[error("writing a table as Parquet")]
    Parquet(#[from] parquet::errors::ParquetError),
    /// A picture or a page.
    #[error(transparent)]
    Report(#[from] reports::Error),
    /// A file of the scheduler could not be written or read.
    #[error("{}: {operation} failed", path.display())]
    File {
        /// File.
        path: PathBuf,
        /// What was attempted.
        operation: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
}
