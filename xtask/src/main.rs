//! The tasks of the workspace: `cargo xtask --help`.
mod handover;
mod requirements;

use clap::{Parser, Subcommand};
use handover::hand_over;
use microslip::Outcome;
use microslip::check::{self, Demand};
use microslip::commands::{EXIT_CODES, print};
use microslip::progress::Display;
use std::env::args_os;
use std::path::PathBuf;
use std::process::ExitCode;
use xtask::arguments::Validation;
use xtask::{brb, defaults};

/// Runs scenes of the Brake-Reuss beam, draws and reports their results, and checks the workspace.
///
/// Reduced models and finished amplitudes are kept in results/.cache.
#[derive(Parser)]
#[command(bin_name = "cargo xtask", after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Run a scene of the Brake-Reuss beam: frequency and damping against amplitude.
    #[command(after_help = EXIT_CODES)]
    Brb(brb::Arguments),
    #[command(flatten)]
    Program(microslip::Command),
    #[command(flatten)]
    Validation(Validation),
    /// Check that the dependencies between the crates point one way only.
    CheckLayering,
    /// List what the tests of the public interfaces demand, from their names.
    Requirements,
    /// Check a finished run against bounds that hold for every sound scene of the beam.
    CheckResults {
        /// Folder of the run.
        directory: PathBuf,
    },
}

fn main() -> ExitCode {
    let success = |()| Outcome::Success;
    match Cli::parse().command {
        Task::Brb(arguments) => microslip::execute(arguments.display(), || brb::run(&arguments, &defaults())),
        Task::Program(command) => microslip::execute(command.display(), || command.run(&defaults())),
        Task::Validation(Validation::Bench(_)) => hand_over("validation", "bench", args_os().skip(1)),
        Task::Validation(_) | Task::CheckLayering => hand_over("validation", "release", args_os().skip(1)),
        Task::Requirements => microslip::execute(Display::default(), || requirements::run().map(success)),
        Task::CheckResults { directory } => microslip::execute(Display::default(), || {
            let count = check::results(&directory, Demand::Complete)?;
            print(&format!("{}: {count} checks passed\n", directory.display())).map(success)
        }),
    }
}
