//! `cargo xtask brb`: runs a scene, by default a built-in one of the beam.

use anyhow::Result;
use microslip::commands::{self, read_scene};
use microslip::{Defaults, Outcome};
use std::path::PathBuf;

/// Arguments of the command.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Scene file; without it the built-in scene brb-flat runs, or brb-deck if there is a deck.
    scene: Option<PathBuf>,
    /// Input deck of the structure, in the place of the one that the scene names.
    #[arg(long, value_name = "FILE")]
    deck: Option<PathBuf>,
    #[command(flatten)]
    options: commands::run::Arguments,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments, defaults: &Defaults) -> Result<Outcome> {
    let scene = read_scene(arguments.scene.as_deref(), arguments.deck.as_deref())?;
    commands::run::run(&scene, &arguments.options, defaults)
}
