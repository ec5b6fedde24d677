//! `new`: a commented scene to start from.

use crate::files;
use anyhow::{Context, Result, bail};
use reports::Output;
use std::path::PathBuf;

/// The scene that is written.
const SCENE: &str = include_str!("new.json");

/// Name of its file.
const FILE: &str = "scene.json";

/// Options of `new`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder for the scene, made if missing.
    directory: PathBuf,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let directory = &arguments.directory;
    let path = directory.join(FILE);
    if path.exists() {
        bail!("{} is there already; choose another folder", path.display());
    }
    std::fs::create_dir_all(directory).with_context(|| format!("making the folder {}", directory.display()))?;
    files::write_all(directory, &[Output::new(FILE, SCENE.to_owned())])?;
    super::print(&format!(
        "a scene to start from is in {0}; run it by\n  microslip run {0}\n",
        path.display()
    ))
}
