//! Runs a task in another program of the workspace.

use microslip::progress::Display;
use std::ffi::OsString;
use std::process::{Command, ExitCode};

const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");

/// Builds the program of `package` with a profile if need be and runs it in the current folder; its exit code is that of the task.
pub(crate) fn hand_over(package: &str, profile: &str, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    // Cargo names itself to the programs that it runs.
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(&cargo);
    command
        .args([
            "run",
            "--profile",
            profile,
            "--manifest-path",
            WORKSPACE,
            "--package",
            package,
            "--",
        ])
        .args(arguments);
    become_command(&mut command).unwrap_or_else(|error| {
        microslip::execute(Display::default(), || {
            Err(anyhow::Error::new(error).context(format!("running {}", cargo.display())))
        })
    })
}

/// In the place of this process, so that whoever ends the task ends the right one.
#[cfg(unix)]
fn become_command(command: &mut Command) -> std::io::Result<ExitCode> {
    Err(std::os::unix::process::CommandExt::exec(command))
}

#[cfg(not(unix))]
fn become_command(command: &mut Command) -> std::io::Result<ExitCode> {
    let code = command.status()?.code();
    Ok(ExitCode::from(
        code.and_then(|code| u8::try_from(code).ok()).unwrap_or(1),
    ))
}
