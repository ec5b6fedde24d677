//! `schema`: JSON Schema of the files that the program reads and writes, for editors and scripts.

use crate::text::print;
use analyses::results::summary::Summary;
use anyhow::{Context, Result};
use clap::ValueEnum;

/// What a schema is of.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum Subject {
    /// Scene files.
    Scene,
    /// `summary.json`.
    Summary,
    /// Plans of studies.
    Plan,
}

/// Options of `schema`.
#[derive(clap::Args)]
pub struct Arguments {
    /// What the schema is of.
    subject: Subject,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let schema = match arguments.subject {
        Subject::Scene => scenes::file_schema(),
        Subject::Summary => schemars::schema_for!(Summary),
        Subject::Plan => parameter_studies::schema(),
    };
    let text = serde_json::to_string_pretty(&schema).context("encoding the schema")?;
    print(&(text + "\n"))
}
