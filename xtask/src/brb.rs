//! `cargo xtask brb`: runs a scene, by default a built-in one of the beam.

use anyhow::Result;
use microslip::commands::{self, SceneArguments};
use microslip::{Defaults, Outcome};

/// Arguments of the command: without a scene the built-in scene brb-flat runs, or brb-deck if there is a deck.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    options: commands::run::Arguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments, defaults: &Defaults) -> Result<Outcome> {
    commands::run::run(&arguments.scene.read(defaults)?, &arguments.options, defaults)
}
