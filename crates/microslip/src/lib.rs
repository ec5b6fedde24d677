#![doc = include_str!("../README.md")]

pub mod commands;
pub mod files;
pub mod progress;

pub use commands::{Command, Defaults, Outcome, execute};
pub use joint_pipeline::summary::Summary;
pub use joint_pipeline::{Error, Options, Run, Scene, run, run_ensemble};
