//! `cargo xtask brb`: runs a scene, by default a built-in one of the beam.

use anyhow::Result;
use microslip::commands::{self, SceneArguments};
use microslip::progress::Display;
use microslip::{Defaults, Outcome};

/// Arguments of the command: without a scene the built-in scene brb-flat runs, or brb-deck if there is a deck.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    options: commands::run::Arguments,
}

impl Arguments {
    /// How the command shows what it does.
    pub fn display(&self) -> Display {
        self.options.display
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, defaults: &Defaults) -> Result<Outcome> {
    commands::run::run(&arguments.scene.read(defaults)?, &arguments.options, defaults)
}
