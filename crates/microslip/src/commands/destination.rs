//! Folders that commands write to.

use anyhow::{Result, bail};
use std::path::{Component, Path, PathBuf};

/// Folder of all results, under the current one.
pub const RESULTS: &str = "results";

/// Writes files into a folder that has none of them.
///
/// # Errors
/// One of them is there already, of which none is written then; or a file cannot be written.
pub(super) fn write_new(directory: &Path, files: &[(&str, &[u8])]) -> Result<()> {
    for (name, _) in files {
        let path = directory.join(name);
        if path.exists() {
            bail!("{} is there already; choose another folder", path.display());
        }
    }
    for (name, contents) in files {
        file_io::durable::write(&directory.join(name), contents)?;
    }
    Ok(())
}

/// The folder of this name among the results.
pub(super) fn default_directory(name: &str) -> Result<PathBuf> {
    let mut components = Path::new(name).components();
    match (components.next(), components.next()) {
        (Some(Component::Normal(_)), None) if !name.starts_with('.') => Ok(Path::new(RESULTS).join(name)),
        _ => bail!("the scene's name `{name}` cannot name a folder; choose one with --out"),
    }
}
