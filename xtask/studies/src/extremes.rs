//! `cargo xtask extremes`: hostile but finite situations.

use crate::folder;
use anyhow::{Result, bail};
use microslip::commands::print;
use microslip::files::write_all;
use studies::extremes::{self, select};
use xtask::study;

/// Runs the command.
pub(crate) fn run(arguments: &study::Extremes) -> Result<()> {
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
