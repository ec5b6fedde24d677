//! `upgrade`: scenes and plans of former versions in the present layout.

use crate::text::print;
use anyhow::{Result, anyhow, bail};
use file_io::durable;
use file_io::input::{Kind, read_text};
use std::path::PathBuf;

/// Options of `upgrade`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Scenes or plans. Each is rewritten with its comments, and stays as it was beside it under its name with `.old` behind.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    for path in &arguments.files {
        let name = path.display();
        let text = read_text(path, Kind::Scene)?;
        let Some(new) = scenes::upgraded(&text).map_err(|reason| anyhow!("{name}: {reason}"))? else {
            print(&format!("{name} has the present layout\n"))?;
            continue;
        };
        let mut kept = path.clone().into_os_string();
        kept.push(".old");
        let kept = PathBuf::from(kept);
        if kept.exists() {
            bail!(
                "{} is there already; move it away, as the file before the change goes there",
                kept.display()
            );
        }
        durable::write(&kept, text.as_bytes())?;
        durable::write(path, new.as_bytes())?;
        print(&format!("{name} is rewritten; what it was is in {}\n", kept.display()))?;
    }
    Ok(())
}
