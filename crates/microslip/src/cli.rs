//! The command line of the program, which its manual pages and completions are made of too.

use crate::commands::{self, Command, Defaults, EXIT_CODES, Outcome, SceneArguments};
use crate::progress::Display;
use anyhow::Result;
use clap::{CommandFactory, Parser, Subcommand};
use clap_complete::Shell;

/// Frequency and damping of bolted joints against amplitude.
///
/// Reduced models and finished amplitudes are kept in the folder `microslip` among the user's caches.
#[derive(Parser)]
#[command(name = "microslip", version, after_help = EXIT_CODES)]
pub struct Cli {
    #[command(subcommand)]
    command: Program,
}

#[derive(Subcommand)]
enum Program {
    /// Run a scene: frequency and damping against amplitude.
    #[command(after_help = EXIT_CODES)]
    Run {
        #[command(flatten)]
        scene: SceneArguments,
        #[command(flatten)]
        options: commands::run::Arguments,
    },
    #[command(flatten)]
    Other(Command),
    /// Write a completion script for a shell.
    Completions {
        /// Shell.
        shell: Shell,
    },
}

impl Cli {
    /// How the command shows what it does.
    pub fn display(&self) -> Display {
        match &self.command {
            Program::Run { options, .. } => options.display,
            Program::Other(other) => other.display(),
            Program::Completions { .. } => Display::default(),
        }
    }

    /// Runs the command that is asked for.
    ///
    /// # Errors
    /// Those of [`Command::run`].
    pub fn run(&self, defaults: &Defaults) -> Result<Outcome> {
        match &self.command {
            Program::Run { scene, options } => commands::run::run(&scene.read(defaults)?, options, defaults),
            Program::Other(other) => other.run(defaults),
            Program::Completions { shell } => {
                let script = completions(*shell);
                commands::print(&String::from_utf8_lossy(&script)).map(|()| Outcome::Success)
            }
        }
    }
}

/// The completion script for a shell.
pub fn completions(shell: Shell) -> Vec<u8> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "microslip", &mut script);
    script
}
