//! `cargo xtask extremes`: hostile but finite situations.

use anyhow::{Result, bail};
use file_io::durable::Identity;
use microslip::commands::print;
use microslip::files::publish;
use validation::extremes::{self, select};
use xtask::arguments;

/// Runs the command.
pub(crate) fn run(arguments: &arguments::Extremes) -> Result<()> {
    let cases = select(&arguments.only)?;
    let identity = Identity::new("extremes", "");
    let results = arguments.overwrite.open(&arguments.out, &identity, &[])?;
    let found = extremes::run(&cases, arguments.full, print)?;
    let (all, failed) = (found.all, found.failed.len());
    let path = arguments.out.join(&found.document.name);
    publish(results, &[found.document])?;
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
