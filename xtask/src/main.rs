//! The tasks of the workspace: `cargo xtask --help`.
mod bench;
mod brb;
mod check;
mod extremes;
mod layering;
mod paper;
mod trade;

use anyhow::{Context, Result};
use brake_reuss_beam::BrakeReussBenchmark;
use clap::{Parser, Subcommand};
use microslip::commands::{EXIT_CODES, RESULTS};
use microslip::{Defaults, Outcome};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

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
    /// Measure what every numerical setting costs and misses: errors, time and memory, setting by setting.
    Trade(trade::Arguments),
    /// Recompute the results of the method paper that need no private scan, each beside the published figure.
    Paper(paper::Arguments),
    /// Time the kernels in one run: ratios between them, not times, are what to compare.
    Bench(bench::Arguments),
    /// Run scenes in hostile but finite situations, and check that each does what it must.
    Extremes(extremes::Arguments),
    /// Check that the dependencies between the crates point one way only.
    CheckLayering,
    /// Check a finished run against bounds that hold for every sound scene of the beam.
    CheckResults {
        /// Folder of the run.
        directory: PathBuf,
    },
}

fn main() -> ExitCode {
    let task = Cli::parse().command;
    // Beside the results, where an interrupted command finds it again.
    let defaults = Defaults {
        cache: Some(Path::new(RESULTS).join(".cache")),
        benchmark: Some(&BrakeReussBenchmark),
    };
    let success = |()| Outcome::Success;
    microslip::execute(|| match task {
        Task::Brb(arguments) => brb::run(&arguments, &defaults),
        Task::Program(command) => command.run(&defaults).map(success),
        Task::Trade(arguments) => trade::run(&arguments, &defaults),
        Task::Paper(arguments) => paper::run(&arguments, &defaults),
        Task::Bench(arguments) => bench::run(&arguments).map(success),
        Task::Extremes(arguments) => extremes::run(&arguments).map(success),
        Task::CheckLayering => layering::run().map(success),
        Task::CheckResults { directory } => check::run(&directory).map(success),
    })
}

/// The folder, made if missing. Before computations: it would be a pity to find out only afterwards.
fn folder(path: &Path) -> Result<&Path> {
    std::fs::create_dir_all(path).with_context(|| format!("making the folder {}", path.display()))?;
    Ok(path)
}
