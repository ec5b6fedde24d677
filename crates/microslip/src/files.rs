//! Output files that appear whole or not at all.

use anyhow::{Context, Result};
use reports::Output;
use reports::run::{amplitude_file, picture_file, table_file};
use std::path::{Path, PathBuf};

/// Writes all files into `directory`: first under temporary names, then, when none failed, renamed in the given order.
///
/// # Errors
/// The first file that cannot be written or renamed; temporary files are removed.
pub fn write_all(directory: &Path, outputs: &[Output]) -> Result<()> {
    let temporary: Vec<PathBuf> = outputs
        .iter()
        .map(|o| directory.join(format!(".{}.part{}", o.name, std::process::id())))
        .collect();
    let written = outputs
        .iter()
        .zip(&temporary)
        .try_for_each(|(output, path)| {
            std::fs::write(path, &output.contents).with_context(|| format!("writing {}", path.display()))
        })
        .and_then(|()| {
            outputs.iter().zip(&temporary).try_for_each(|(output, from)| {
                let to = directory.join(&output.name);
                std::fs::rename(from, &to).with_context(|| format!("moving {} into place", to.display()))
            })
        });
    if written.is_err() {
        // Those already renamed are gone from here; the others are of no use.
        temporary.iter().for_each(|path| drop(std::fs::remove_file(path)));
    }
    written
}

/// Removes the interface files of amplitudes, the backbones of further modes, and those `named`, that are not among `outputs`.
///
/// # Errors
/// The folder cannot be listed, or a file cannot be removed.
pub(crate) fn remove_stale(directory: &Path, outputs: &[Output], named: &[&str]) -> Result<()> {
    let entries = std::fs::read_dir(directory).with_context(|| format!("listing {}", directory.display()))?;
    for entry in entries {
        let path = entry
            .with_context(|| format!("listing {}", directory.display()))?
            .path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
            continue;
        };
        let ours = is_of_amplitudes_or_modes(name) || named.contains(&name);
        if ours && outputs.iter().all(|output| output.name != name) {
            std::fs::remove_file(&path).with_context(|| format!("removing {} of an earlier run", path.display()))?;
        }
    }
    Ok(())
}

/// Whether a run writes the fields of some amplitude, or the backbone of a further mode, to a file of this name.
fn is_of_amplitudes_or_modes(name: &str) -> bool {
    let number = |text: &str| text.parse::<usize>().ok();
    if let Some(mode) = name
        .strip_prefix("mode-")
        .and_then(|rest| number(rest.split_once('-')?.0))
    {
        return name == table_file(Some(mode)) || name == picture_file(Some(mode));
    }
    let Some(rest) = name.strip_prefix("interface-") else {
        return false;
    };
    let (mode, rest) = match rest.strip_prefix("mode-").and_then(|rest| rest.split_once('-')) {
        Some((mode, rest)) => (number(mode), rest),
        None => (None, rest),
    };
    let amplitude = rest
        .strip_prefix("amplitude-")
        .and_then(|rest| number(rest.strip_suffix(".vtu")?));
    amplitude.is_some_and(|amplitude| amplitude_file(mode, amplitude) == name)
}
