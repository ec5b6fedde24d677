//! Other programs, and what they say.

use anyhow::{Context, Result, bail};
use std::path::Path;
use std::process::Command;

/// Runs a program to its end, and gives what it printed.
///
/// # Errors
/// It cannot be started, or fails; the message has the last lines of what it said.
pub fn output(command: &mut Command) -> Result<String> {
    const LAST: usize = 20;
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .output()
        .with_context(|| format!("starting `{name}`: is it installed?"))?;
    if !output.status.success() {
        let arguments: Vec<_> = command.get_args().map(|a| a.to_string_lossy()).collect();
        let said = String::from_utf8_lossy(&output.stderr);
        let lines: Vec<&str> = said.lines().collect();
        bail!(
            "`{name} {}` failed:\n{}",
            arguments.join(" "),
            lines[lines.len().saturating_sub(LAST)..].join("\n")
        );
    }
    String::from_utf8(output.stdout).with_context(|| format!("reading what `{name}` printed"))
}

/// A command in a folder, of words between blanks.
pub fn command(words: &str, folder: &Path) -> Command {
    let mut words = words.split_whitespace();
    // Cargo names itself to the programs that it runs.
    let own = |name| std::env::var_os("CARGO").filter(|_| name == "cargo");
    let name = words.next().unwrap_or_default();
    let mut command = Command::new(own(name).unwrap_or_else(|| name.into()));
    command.args(words).current_dir(folder);
    command
}
