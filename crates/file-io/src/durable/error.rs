//! Errors of this crate.

use std::path::{Path, PathBuf};

/// Why files could not be written or trusted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An operation of the file system failed.
    #[error("{}: {operation} failed", path.display())]
    File {
        /// File or folder.
        path: PathBuf,
        /// What was attempted.
        operation: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
    /// Another process writes into the folder.
    #[error(
        "{}: in use by {holder}; wait until it ends, or choose another folder with --out",
        folder.display()
    )]
    Busy {
        /// Folder.
        folder: PathBuf,
        /// Process, host and command of the holder, as far as they are known.
        holder: String,
    },
    /// The folder holds results of something else.
    #[error(
        "{}: holds the results of {there}, and would be overwritten with those of {wanted}; choose another folder with --out, or \
         pass --overwrite",
        folder.display()
    )]
    OtherResults {
        /// Folder.
        folder: PathBuf,
        /// What the folder holds.
        there: String,
        /// What was to be written.
        wanted: String,
    },
    /// A file is in the way that belongs to no known set.
    #[error(
        "{}: is there already, and no manifest of {wanted} lists it; choose another folder with --out, move it away, or pass \
         --overwrite",
        path.display()
    )]
    Unlisted {
        /// File.
        path: PathBuf,
        /// What was to be written.
        wanted: String,
    },
    /// A folder stands where a file is to be written.
    #[error("{}: is a folder, and a file of this name is to be written; move it away", path.display())]
    Obstructed {
        /// Folder.
        path: PathBuf,
    },
    /// The folder has no manifest.
    #[error(
        "{}: has no {}, so that nothing vouches for its files; run the command again",
        folder.display(),
        crate::durable::MANIFEST
    )]
    NoManifest {
        /// Folder.
        folder: PathBuf,
    },
    /// A manifest that is not what this crate writes.
    #[error("{}: is damaged ({reason}); run the command again with --overwrite", path.display())]
    DamagedManifest {
        /// File.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The results were being replaced when the process ended.
    #[error(
        "{}: its files were not all moved into place, or are being moved; run the command again, which completes the move",
        folder.display()
    )]
    Interrupted {
        /// Folder.
        folder: PathBuf,
    },
}

impl Error {
    /// The file or folder.
    pub fn path(&self) -> &Path {
        match self {
            Self::File { path, .. }
            | Self::Unlisted { path, .. }
            | Self::Obstructed { path }
            | Self::DamagedManifest { path, .. } => path,
            Self::Busy { folder, .. }
            | Self::OtherResults { folder, .. }
            | Self::NoManifest { folder }
            | Self::Interrupted { folder } => folder,
        }
    }

    pub(crate) fn file(path: &Path, operation: &'static str, source: std::io::Error) -> Self {
        Self::File {
            path: path.to_owned(),
            operation,
            source,
        }
    }
}
