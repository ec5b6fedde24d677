#![doc = include_str!("../README.md")]

pub mod benchmarks;
pub mod check;
pub mod commands;
pub mod files;
pub mod progress;
pub mod provenance;
mod text;

pub use benchmarks::BENCHMARKS;
pub use commands::{Command, Defaults, Outcome, execute};
pub use joint_pipeline::results::summary::Summary;
pub use joint_pipeline::{Error, Options, Run, Scene, run, run_ensemble};
