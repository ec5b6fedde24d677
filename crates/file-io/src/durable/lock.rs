//! Locks on folders that end with the process that holds them.

use crate::durable::Error;
use std::fs::{File, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

/// Name of the file that carries the lock.
pub(crate) const LOCK: &str = ".microslip-lock";

/// A lock on a folder, released when it is dropped or the process ends.
#[derive(Debug)]
pub(crate) struct Lock {
    path: PathBuf,
    /// None where the file system has no locks.
    file: Option<File>,
}

impl Lock {
    /// Takes the lock for `purpose`, which the message of others names.
    pub(crate) fn acquire(folder: &Path, purpose: &str) -> Result<Self, Error> {
        let path = folder.join(LOCK);
        let fail = |source| Error::file(&path, "locking the folder", source);
        loop {
            let open = File::options()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&path);
            let mut file = open.map_err(fail)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    // A lock that covers its file's contents, as on Windows, leaves the holder unnamed.
                    let mut holder = String::new();
                    let _ = file.read_to_string(&mut holder);
                    return Err(Error::Busy {
                        folder: folder.to_owned(),
                        holder: match holder.trim() {
                            "" => "another process".into(),
                            named => named.to_owned(),
                        },
                    });
                }
                Err(TryLockError::Error(error)) if error.kind() == std::io::ErrorKind::Unsupported => {
                    return Ok(Self { path, file: None });
                }
                Err(TryLockError::Error(source)) => return Err(fail(source)),
            }
            // The holder before may have removed the file between opening and locking.
            if is_at(&file, &path) {
                let holder = format!("{purpose} (process {} on {})\n", std::process::id(), host());
                let named = file.set_len(0).and_then(|()| file.rewind());
                named.and_then(|()| file.write_all(holder.as_bytes())).map_err(fail)?;
                return Ok(Self { path, file: Some(file) });
            }
        }
    }

    pub(crate) fn is_held(&self) -> bool {
        self.file.is_some()
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Where it is not known whether an open file is the one of that name, the file stays.
        if cfg!(unix) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Whether the open file is the one of this name.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |m: std::fs::Metadata| (m.dev(), m.ino());
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(open), Ok(named)) => identity(open) == identity(named),
        _ => false,
    }
}

#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

/// Name of this computer, as far as the system tells without asking others.
fn host() -> String {
    let kernel = std::fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let named = kernel.or_else(|| std::env::var("HOSTNAME").ok());
    let named = named.or_else(|| std::env::var("COMPUTERNAME").ok());
    named.map_or_else(|| "an unknown host".into(), |name| name.trim().to_owned())
}
