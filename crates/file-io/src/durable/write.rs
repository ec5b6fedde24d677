//! Single files that appear whole or not at all.

use crate::durable::Error;
use std::ffi::OsStr;
use std::fs::{File, TryLockError};
use std::io::{self, Write};
use std::path::Path;
use tempfile::{Builder, NamedTempFile};

/// What names of temporary files and folders begin with.
pub(crate) const PREFIX: &str = ".microslip-";

/// What they end with.
pub(crate) const SUFFIX: &str = ".part";

/// Replaces a file: readers see the old contents or the new ones, also after a loss of power. Temporary files that killed
/// processes left in the folder are removed.
///
/// # Errors
/// [`Error::File`]; the file is as it was then, and the temporary one is gone.
pub fn write(path: &Path, contents: &[u8]) -> Result<(), Error> {
    write_all(path, &[contents])
}

/// As [`write`], of contents one after the other.
pub(crate) fn write_all(path: &Path, contents: &[&[u8]]) -> Result<(), Error> {
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    create_folder(folder)?;
    remove_abandoned(folder);
    let mut part = held_part(folder)?;
    // Dropping the part removes it.
    (contents.iter())
        .try_for_each(|contents| part.write_all(contents))
        .and_then(|()| part.as_file().sync_all())
        .map_err(|source| Error::file(path, "writing", source))?;
    std::fs::rename(part.path(), path).map_err(|source| Error::file(path, "moving into place", source))?;
    // It has another name by now.
    let _ = part.keep();
    sync_folder(folder)
}

/// Makes a folder, with those above it, if it is missing.
pub(crate) fn create_folder(folder: &Path) -> Result<(), Error> {
    if folder.is_dir() {
        return Ok(());
    }
    std::fs::create_dir_all(folder).map_err(|source| Error::file(folder, "making the folder", source))?;
    match folder.parent() {
        Some(parent) if parent != Path::new("") => sync_folder(parent),
        _ => Ok(()),
    }
}

/// Makes the names in a folder durable, where the system can.
pub(crate) fn sync_folder(folder: &Path) -> Result<(), Error> {
    if cfg!(not(unix)) {
        return Ok(());
    }
    match File::open(folder).and_then(|file| file.sync_all()) {
        // Some file systems cannot sync folders.
        Err(error) if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => Ok(()),
        other => other.map_err(|source| Error::file(folder, "syncing the folder", source)),
    }
}

/// Temporary names, with the permissions of usual files and folders.
pub(crate) fn temporary<'a>() -> Builder<'a, 'a> {
    let mut builder = Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX).rand_bytes(12);
    builder
}

/// A temporary file with a lock that says that its owner lives.
fn held_part(folder: &Path) -> Result<NamedTempFile, Error> {
    let fail = |source| Error::file(folder, "making a temporary file", source);
    let mut builder = temporary();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    loop {
        let part = builder.tempfile_in(folder).map_err(fail)?;
        match part.as_file().try_lock() {
            // Without locks nobody removes it either.
            Err(TryLockError::Error(_)) => return Ok(part),
            // Unless one that cleans up held the lock before, and the file is gone.
            Ok(()) if part.path().exists() => return Ok(part),
            Ok(()) | Err(TryLockError::WouldBlock) => {}
        }
    }
}

/// Removes the temporary files whose owners are gone. What cannot be removed is left for the next time.
fn remove_abandoned(folder: &Path) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && is_temporary(&entry.file_name()) {
            let path = entry.path();
            let abandoned = File::options().read(true).write(true).open(&path);
            if let Ok(file) = abandoned
                && file.try_lock().is_ok()
            {
                let _ = std::fs::remove_file(&path);
            }
        }
    }
}

/// Whether a name is one of those that [`temporary`] makes.
pub(crate) fn is_temporary(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    name.starts_with(PREFIX) && name.ends_with(SUFFIX)
}
