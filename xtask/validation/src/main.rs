//! Runs the validation tasks of the workspace. `cargo xtask` starts it, and has checked the arguments.
mod commands;
mod layering;
mod modules;

use clap::{Parser, Subcommand};
use commands::{bench, dist, extremes, paper, trade, validate};
use microslip::Outcome;
use microslip::progress::Display;
use std::process::ExitCode;
use xtask::arguments::Validation;
use xtask::{brb, defaults};

#[derive(Parser)]
#[command(bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    command: Task,
}

#[derive(Subcommand)]
enum Task {
    #[command(flatten)]
    Validation(Validation),
    /// `trade` runs every setting in a process of its own.
    Brb(brb::Arguments),
    CheckLayering,
}

fn main() -> ExitCode {
    let task = Cli::parse().command;
    let success = |()| Outcome::Success;
    let display = match &task {
        Task::Brb(arguments) => arguments.display(),
        _ => Display::default(),
    };
    microslip::execute(display, || match task {
        Task::Validation(Validation::Trade(arguments)) => trade::run(&arguments, &defaults()),
        Task::Validation(Validation::Paper(arguments)) => paper::run(&arguments, &defaults()),
        Task::Validation(Validation::Bench(arguments)) => bench::run(&arguments).map(success),
        Task::Validation(Validation::Extremes(arguments)) => extremes::run(&arguments).map(success),
        Task::Validation(Validation::Validate(arguments)) => validate::run_all(&arguments, &defaults()),
        Task::Validation(Validation::Dist(arguments)) => dist::run(&arguments).map(success),
        Task::CheckLayering => layering::check().map(success),
        Task::Brb(arguments) => brb::run(&arguments, &defaults()),
    })
}
