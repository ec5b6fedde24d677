//! `cargo xtask extremes`: hostile but finite situations.

use crate::folder;
use anyhow::{Result, bail};
use microslip::commands::print;
use microslip::files::write_all;
use std::path::PathBuf;
use studies::extremes::{self, select};

/// Arguments of the command.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// On the mesh of the default scene instead of the coarse one.
    #[arg(long)]
    full: bool,
    /// Only these cases.
    #[arg(long, value_name = "NAME", num_args = 1..)]
    only: Vec<String>,
    /// Folder for extremes.json, made if missing.
    #[arg(long, value_name = "DIR", default_value = "results/extremes")]
    out: PathBuf,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let cases = select(&arguments.only)?;
    let out = folder(&arguments.out)?;
    let found = extremes::run(&cases, arguments.full, print)?;
    let (all, failed) = (found.all, found.failed.len());
    let path = out.join(&found.document.name);
    write_all(out, &[found.document])?;
    print(&format!(
        "\n{} of {all} cases did what they must; written to {}\n",
        all - failed,
        path.display()
    ))?;
    if failed > 0 {
        bail!(
            "{failed} of {all} cases did not do what they must: {}",
            found.failed.join(", ")
        )
    }
    Ok(())
}
