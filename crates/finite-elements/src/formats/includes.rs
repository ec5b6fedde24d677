//! Files that include other files.

use crate::Error;
use std::path::{Component, Path, PathBuf};

/// How deep files may include one another.
const INCLUDE_DEPTH: usize = 10;
/// How many files a deck may include.
const INCLUDE_COUNT: usize = 1000;

/// Which files a deck may include.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Includes {
    /// Those in the folder of the deck and below, links followed.
    #[default]
    BelowTheDeck,
    /// Any. Of files elsewhere errors say the place, and quote nothing.
    Anywhere,
}

/// What is said of files outside the folder of a deck, and of a mesh.
const OUTSIDE: &str =
    "it is outside the folder of the deck; move it there, or allow files elsewhere (--allow-includes-outside)";
const OUTSIDE_OF_MESH: &str = "it is outside the folder of the mesh; move it there";

/// What a deck may still include, and what it is including.
pub(super) struct Open {
    /// Folder of the deck.
    root: PathBuf,
    includes: Includes,
    /// What is said of files outside the folder.
    outside: &'static str,
    /// The file itself and those that include it.
    files: Vec<PathBuf>,
    /// Bytes that all files together may still have.
    left: u64,
}

impl Open {
    /// Opens a deck that may have `limit` bytes with all that it includes; with the bytes of its own file.
    ///
    /// # Errors
    /// If the file cannot be read, or is larger.
    pub(super) fn new(path: &Path, includes: Includes, limit: u64) -> Result<(Self, Vec<u8>), Error> {
        let bytes = file_io::input::read_at_most(path, file_io::input::Kind::Deck, limit)?;
        let canonical = path
            .canonicalize()
            .map_err(|reason| file_io::input::Error::Unreadable {
                path: path.to_owned(),
                reason,
            })?;
        let open = Self {
            root: canonical.parent().map(Path::to_owned).unwrap_or_default(),
            includes,
            outside: OUTSIDE,
            left: limit - bytes.len() as u64,
            files: vec![canonical],
        };
        Ok((open, bytes))
    }

    /// Opens a mesh, which may include files of its folder and below.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn mesh(path: &Path) -> Result<(Self, Vec<u8>), Error> {
        let (open, bytes) = Self::new(path, Includes::BelowTheDeck, file_io::input::Kind::Deck.limit())?;
        let outside = OUTSIDE_OF_MESH;
        Ok((Self { outside, ..open }, bytes))
    }

    /// The file that is being read.
    pub(super) fn current(&self) -> &Path {
        self.files.last().map_or(Path::new(""), PathBuf::as_path)
    }

    /// Goes back to the file that includes the present one.
    pub(super) fn leave(&mut self) {
        self.files.pop();
    }

    /// The bytes of the next file, and whether it is outside the folder of the deck; or why it is not taken.
    pub(super) fn include(&mut self, input: &str, count: usize) -> Result<(Vec<u8>, bool), String> {
        let outside = self.outside;
        let folder = self.current().parent().unwrap_or(Path::new(""));
        let path = folder.join(input);
        let allowed = |path: &Path| self.includes == Includes::Anywhere || path.starts_with(&self.root);
        let canonical = match path.canonicalize() {
            Ok(canonical) => canonical,
            // Whether a file is there is no one's concern where it may not be read.
            Err(_) if !allowed(&without_parents(&path)) => return Err(outside.into()),
            Err(error) => return Err(error.to_string()),
        };
        if !allowed(&canonical) {
            return Err(outside.into());
        }
        if self.files.contains(&canonical) {
            return Err("the file includes itself".into());
        }
        if self.files.len() > INCLUDE_DEPTH || count > INCLUDE_COUNT {
            return Err(format!(
                "more than {INCLUDE_DEPTH} files deep, or {INCLUDE_COUNT} files; join some of them"
            ));
        }
        let bytes = file_io::input::read_at_most(&canonical, file_io::input::Kind::Deck, self.left).map_err(|error| {
            let left = self.left;
            match error {
                file_io::input::Error::TooLarge { kind, .. } => format!(
                    "the files before it leave {left} of the {} bytes that a deck may have with all its includes; remove \
                     what the structure does not need",
                    kind.limit()
                ),
                other => other.to_string(),
            }
        })?;
        self.left -= bytes.len() as u64;
        let is_outside = !canonical.starts_with(&self.root);
        self.files.push(canonical);
        Ok((bytes, is_outside))
    }
}

/// The path without `..`, as far as names tell.
fn without_parents(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}

/// The name of a file in messages.
pub(super) fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}
