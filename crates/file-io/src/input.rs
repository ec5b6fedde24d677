//! The bytes of files that users name: regular files alone, up to the limit of their kind.

use std::fs::{File, Metadata};
use std::io::Read;
use std::path::{Path, PathBuf};

/// What a file is read as, which decides how large it may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// A scene.
    Scene,
    /// An input deck; the limit holds for the deck and all files that it includes.
    Deck,
    /// A mesh of solids.
    Mesh,
    /// Matrices, or one of the files of a structure of matrices.
    Matrices,
    /// A map of heights.
    Scan,
    /// A recorded signal.
    Record,
    /// A table, a mesh of an interface, or the summary of a run.
    Table,
    /// Finished parts of a run.
    Checkpoint,
    /// A reduced model in the cache.
    Model,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 9] = [
        Self::Scene,
        Self::Deck,
        Self::Mesh,
        Self::Matrices,
        Self::Scan,
        Self::Record,
        Self::Table,
        Self::Checkpoint,
        Self::Model,
    ];

    /// Most bytes of a file of this kind.
    pub const fn limit(self) -> u64 {
        const MIB: u64 = 1 << 20;
        match self {
            Self::Scene | Self::Table => 256 * MIB,
            Self::Deck => 512 * MIB,
            Self::Checkpoint => 1024 * MIB,
            Self::Mesh | Self::Matrices | Self::Scan | Self::Record => 4096 * MIB,
            Self::Model => 16_384 * MIB,
        }
    }

    /// For messages.
    const fn name(self) -> &'static str {
        match self {
            Self::Scene => "a scene",
            Self::Deck => "a deck with its includes",
            Self::Mesh => "a mesh",
            Self::Matrices => "a file of matrices",
            Self::Scan => "a scan",
            Self::Record => "a record",
            Self::Table => "a table",
            Self::Checkpoint => "a checkpoint",
            Self::Model => "a reduced model",
        }
    }

    /// What to do about a file that is too large.
    const fn remedy(self) -> &'static str {
        match self {
            Self::Scene => "name scans, decks and matrices by their files instead of listing numbers in the scene",
            Self::Deck => "remove what the structure does not need, such as output requests and unused parts",
            Self::Mesh => "use a coarser mesh, or save it in binary",
            Self::Matrices => "store the matrices sparse, or reduce the structure further",
            Self::Scan => "crop the scan to the interface, or thin it out",
            Self::Record => "cut the record into its hits, or sample it more slowly",
            Self::Table => "check that this is the file meant",
            Self::Checkpoint | Self::Model => "remove it; it is made again",
        }
    }
}

/// Why a file was not read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system cannot open or read it.
    #[error("{}: {reason}; check the path and its permissions", path.display())]
    Unreadable {
        /// Path.
        path: PathBuf,
        /// What the system says.
        reason: std::io::Error,
    },
    /// It has no contents of its own.
    #[error("{}: it is {found}, not a regular file; copy its contents into a file first", path.display())]
    NotRegular {
        /// Path.
        path: PathBuf,
        /// What it is.
        found: &'static str,
    },
    /// It is too large.
    #[error(
        "{}: it has {} {size} bytes, but {} may have at most {limit}; {}",
        path.display(),
        if *exact { "" } else { "more than" },
        kind.name(),
        kind.remedy()
    )]
    TooLarge {
        /// Path.
        path: PathBuf,
        /// What it was read as.
        kind: Kind,
        /// Bytes it has, or that were read of it.
        size: u64,
        /// Whether it has so many, or more.
        exact: bool,
        /// Most bytes it may have.
        limit: u64,
    },
    /// Text was asked for, and it is something else.
    #[error("{}: byte {byte} is not UTF-8; save the file as UTF-8 text", path.display())]
    NotText {
        /// Path.
        path: PathBuf,
        /// Where the text ends, from 0.
        byte: usize,
    },
}

impl Error {
    /// The file.
    pub fn path(&self) -> &Path {
        match self {
            Self::Unreadable { path, .. }
            | Self::NotRegular { path, .. }
            | Self::TooLarge { path, .. }
            | Self::NotText { path, .. } => path,
        }
    }
}

/// The bytes of a regular file.
///
/// # Errors
/// [`Error::Unreadable`], [`Error::NotRegular`], [`Error::TooLarge`].
pub fn read(path: &Path, kind: Kind) -> Result<Vec<u8>, Error> {
    read_at_most(path, kind, kind.limit())
}

/// The text of a regular file.
///
/// # Errors
/// As [`read`], and [`Error::NotText`].
pub fn read_text(path: &Path, kind: Kind) -> Result<String, Error> {
    String::from_utf8(read(path, kind)?).map_err(|error| Error::NotText {
        path: path.to_owned(),
        byte: error.utf8_error().valid_up_to(),
    })
}

/// Refuses what [`read`] would refuse before it opens a file, for those who read it in another way.
///
/// # Errors
/// As [`read`].
pub fn check(path: &Path, kind: Kind) -> Result<(), Error> {
    let metadata = std::fs::metadata(path).map_err(|reason| unreadable(path, reason))?;
    admissible(path, &metadata, kind, kind.limit()).map(drop)
}

fn unreadable(path: &Path, reason: std::io::Error) -> Error {
    Error::Unreadable {
        path: path.to_owned(),
        reason,
    }
}

/// The size of a regular file within the limit.
fn admissible(path: &Path, metadata: &Metadata, kind: Kind, limit: u64) -> Result<u64, Error> {
    let (path, size) = (path.to_owned(), metadata.len());
    if !metadata.is_file() {
        let found = what(metadata);
        return Err(Error::NotRegular { path, found });
    }
    if size > limit {
        return Err(Error::TooLarge {
            path,
            kind,
            size,
            exact: true,
            limit,
        });
    }
    Ok(size)
}

/// The bytes of a regular file of which no more than `limit` are allowed, for files that share the limit of their kind.
///
/// # Errors
/// As [`read`].
pub fn read_at_most(path: &Path, kind: Kind, limit: u64) -> Result<Vec<u8>, Error> {
    let unreadable = |reason| unreadable(path, reason);
    // Before it is opened: opening a pipe waits for its writer, and opening a device may act.
    admissible(path, &std::fs::metadata(path).map_err(unreadable)?, kind, limit)?;
    let file = File::open(path).map_err(unreadable)?;
    // Once more: what stood there may have been replaced.
    let size = admissible(path, &file.metadata().map_err(unreadable)?, kind, limit)?;
    let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or_default());
    // Files of the system state no size, and others grow.
    file.take(limit.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(Error::TooLarge {
            path: path.to_owned(),
            kind,
            size: limit,
            exact: false,
            limit,
        });
    }
    Ok(bytes)
}

/// What something is that is not a regular file.
fn what(metadata: &Metadata) -> &'static str {
    if metadata.is_dir() {
        return "a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = metadata.file_type();
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
    }
    "a device"
}
