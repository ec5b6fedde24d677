//! Output files that appear whole or not at all.

use anyhow::{Context, Result};
use std::path::{Path, PathBuf};

/// A file to be written.
pub(crate) struct Output {
    pub(crate) name: String,
    pub(crate) contents: Vec<u8>,
}

impl Output {
    pub(crate) fn new(name: impl Into<String>, contents: impl Into<Vec<u8>>) -> Self {
        Self {
            name: name.into(),
            contents: contents.into(),
        }
    }
}

/// Writes all files into `directory`: first under temporary names, then, when none failed, renamed in the given order.
pub(crate) fn write_all(directory: &Path, outputs: &[Output]) -> Result<()> {
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

/// Name of the interface file of an amplitude, counted from 1.
pub(crate) fn amplitude_file(number: usize) -> String {
    format!("interface-amplitude-{number:02}.vtu")
}

/// Removes the interface files of amplitudes, and those `named`, that are not among `outputs`.
pub(crate) fn remove_stale(directory: &Path, outputs: &[Output], named: &[&str]) -> Result<()> {
    let entries = std::fs::read_dir(directory).with_context(|| format!("listing {}", directory.display()))?;
    for entry in entries {
        let path = entry
            .with_context(|| format!("listing {}", directory.display()))?
            .path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
            continue;
        };
        let number = name
            .strip_prefix("interface-amplitude-")
            .and_then(|rest| rest.strip_suffix(".vtu"));
        let ours = number
            .and_then(|n| n.parse().ok())
            .is_some_and(|n| amplitude_file(n) == name)
            || named.contains(&name);
        if ours && outputs.iter().all(|output| output.name != name) {
            std::fs::remove_file(&path).with_context(|| format!("removing {} of an earlier run", path.display()))?;
        }
    }
    Ok(())
}
