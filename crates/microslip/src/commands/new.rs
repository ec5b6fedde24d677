//! `new`: a commented scene to start from.

use anyhow::{Result, bail};
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
    durable_files::write(&path, SCENE.as_bytes())?;
    super::print(&format!(
        "a scene to start from is in {0}; run it by\n  microslip run {0}\n",
        path.display()
    ))
}
