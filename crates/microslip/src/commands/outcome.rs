//! How commands end, and what exit codes say of it.

use crate::progress::Display;
use anyhow::Result;
use std::process::ExitCode;

/// What the exit codes mean, for the help texts.
pub const EXIT_CODES: &str = "Exit codes:
  0  success
  1  error: bad scene, failed check, unreadable or unwritable file
  2  wrong arguments
  3  the run finished and its outputs were written, but some amplitudes did not converge or a forced response ended early";

/// How a command ended that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All is well.
    Success,
    /// Some amplitudes did not converge.
    Incomplete,
}

/// Runs a command and turns its outcome into an exit code; an error is shown by `display`, in one line.
pub fn execute(display: Display, command: impl FnOnce() -> Result<Outcome>) -> ExitCode {
    // Amplitudes and elements already run in parallel; threads within matrix kernels would only compete with them.
    faer::set_global_parallelism(faer::Par::Seq);
    match command() {
        Ok(Outcome::Success) => ExitCode::SUCCESS,
        Ok(Outcome::Incomplete) => ExitCode::from(3),
        Err(error) => {
            display.error(&error);
            ExitCode::FAILURE
        }
    }
}
