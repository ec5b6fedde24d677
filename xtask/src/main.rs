//! The commands of the workspace: `cargo xtask --help`.
mod bench;
mod brb;
mod characterise;
mod check;
mod compare;
mod csv;
mod elements;
mod export;
mod extremes;
mod fields;
mod files;
mod identify;
mod layering;
mod map;
mod markup;
mod model;
mod overlay;
mod paper;
mod plot;
mod progress;
mod report;
mod trade;
mod transient;
mod vtu;

use clap::{Parser, Subcommand};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

const EXIT_CODES: &str = "Exit codes:
  0  success
  1  error: bad scene, failed check, unreadable or unwritable file
  2  wrong arguments
  3  the run finished and its outputs were written, but some amplitudes did not converge";

/// Runs scenes of the Brake-Reuss beam, draws and reports their results, and checks the workspace.
#[derive(Parser)]
#[command(bin_name = "cargo xtask", after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene of the Brake-Reuss beam: frequency and damping against amplitude.
    #[command(after_help = EXIT_CODES)]
    Brb(brb::Arguments),
    /// Describe the structure of a scene: size, mass and, with `--spectrum`, frequencies with linear interfaces.
    Model(model::Arguments),
    /// Write the reduced model of a scene for other programs: NumPy, MATLAB and Octave, Matrix Market.
    Export(export::Arguments),
    /// Frequency and damping against amplitude from measured ring-downs; several files are hits to be averaged.
    Identify(identify::Arguments),
    /// Characterise two scans over an interface: gaps, roughness, asperities and traction laws with bands per element.
    Characterise(characterise::Arguments),
    /// Follow the ring-down of a scene in time, identify it, and lay it over the quasi-static backbones.
    Transient(transient::Arguments),
    /// Lay a run over measured backbones at the same response point: misfit in frequency and damping.
    Compare(compare::Arguments),
    /// Measure what every numerical setting costs and misses: errors, time and memory, rung by rung.
    Trade(trade::Arguments),
    /// Recompute the results of the method paper that need no private scan, each beside the published figure.
    Paper(paper::Arguments),
    /// Time the kernels in one run: ratios between them, not times, are what to compare.
    Bench(bench::Arguments),
    /// Put hostile but finite situations to the whole road, and check that each does what it must.
    Extremes(extremes::Arguments),
    /// Check that the dependencies between the crates point one way only.
    CheckLayering,
    /// Check a finished run against bounds that hold for every sound scene of the beam.
    CheckResults {
        /// Folder of the run.
        directory: PathBuf,
    },
}

/// A command that finished.
enum Outcome {
    Success,
    /// Some amplitudes did not converge.
    Incomplete,
}

fn main() -> ExitCode {
    // Amplitudes and elements already run in parallel; threads within matrix kernels would only compete with them.
    faer::set_global_parallelism(faer::Par::Seq);
    let result = match Cli::parse().command {
        Command::Brb(arguments) => brb::run(&arguments),
        Command::Model(arguments) => model::run(&arguments).map(|()| Outcome::Success),
        Command::Export(arguments) => export::run(&arguments).map(|()| Outcome::Success),
        Command::Identify(arguments) => identify::run(&arguments).map(|()| Outcome::Success),
        Command::Characterise(arguments) => characterise::run(&arguments).map(|()| Outcome::Success),
        Command::Transient(arguments) => transient::run(&arguments).map(|()| Outcome::Success),
        Command::Compare(arguments) => compare::run(&arguments).map(|()| Outcome::Success),
        Command::Trade(arguments) => trade::run(&arguments),
        Command::Paper(arguments) => paper::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments).map(|()| Outcome::Success),
        Command::Extremes(arguments) => extremes::run(&arguments).map(|()| Outcome::Success),
        Command::CheckLayering => layering::run().map(|()| Outcome::Success),
        Command::CheckResults { directory } => check::run(&directory).map(|()| Outcome::Success),
    };
    match result {
        Ok(Outcome::Success) => ExitCode::SUCCESS,
        Ok(Outcome::Incomplete) => ExitCode::from(3),
        Err(error) => {
            // `{:#}` prints the chain of causes in one line. A closed standard error leaves nobody to tell.
            let _ = writeln!(std::io::stderr(), "error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Prints a finished text; a reader that has gone away (as `head` does) is no error.
fn print(text: &str) -> anyhow::Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}
