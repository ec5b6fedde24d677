//! The program: `microslip --help`.

use clap::{CommandFactory, Parser, Subcommand};
use host::user_cache;
use microslip::commands::{self, EXIT_CODES, SceneArguments};
use microslip::{Defaults, Outcome};
use std::process::ExitCode;

/// Frequency and damping of bolted joints against amplitude.
///
/// Reduced models and finished amplitudes are kept in the folder `microslip` among the user's caches.
#[derive(Parser)]
#[command(version, after_help = EXIT_CODES)]
struct Cli {
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
    Other(microslip::Command),
    /// Write a completion script for a shell.
    Completions {
        /// Shell.
        shell: clap_complete::Shell,
    },
}

fn main() -> ExitCode {
    let command = Cli::parse().command;
    microslip::execute(|| {
        let defaults = Defaults {
            cache: user_cache(),
            benchmark: None,
        };
        match command {
            Program::Run { scene, options } => commands::run::run(&scene.read(&defaults)?, &options, &defaults),
            Program::Other(other) => other.run(&defaults),
            Program::Completions { shell } => {
                let mut script = Vec::new();
                clap_complete::generate(shell, &mut Cli::command(), "microslip", &mut script);
                commands::print(&String::from_utf8_lossy(&script)).map(|()| Outcome::Success)
            }
        }
    })
}
