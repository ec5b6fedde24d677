//! What a set of files consists of.

use crate::durable::{Error, sha256, sha256_of_file};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Component, Path};

/// Name of the manifest in the folder of a set.
pub const MANIFEST: &str = "manifest.json";

/// Folder of a set that is complete but not in place yet.
pub(crate) const COMPLETE: &str = ".microslip-complete";

/// Version of the layout of manifests.
const FORMAT: u32 = 1;

/// What a set of files is the result of. Sets of the same identity replace one another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// The command that writes the set.
    pub command: String,
    /// What it works on, such as the name of a scene and its structure.
    pub subject: String,
}

impl Identity {
    /// Of a command and what it works on.
    pub fn new(command: impl Into<String>, subject: impl Into<String>) -> Self {
        Self {
            command: command.into(),
            subject: subject.into(),
        }
    }
}

impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.subject.as_str() {
            "" => write!(f, "`{}`", self.command),
            subject => write!(f, "`{}` of {subject}", self.command),
        }
    }
}

/// A file of a set.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Its size.
    pub bytes: u64,
    /// Its SHA-256, as hexadecimal text.
    pub sha256: String,
}

/// The files of a set by name, with their sizes and checksums.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    format: u32,
    /// What the set is the result of.
    pub identity: Identity,
    /// Its files.
    pub files: BTreeMap<String, Entry>,
    /// SHA-256 of all of the above.
    sha256: String,
}

/// What is wrong with a file of a set.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Defect {
    /// It is not there.
    Missing {
        /// Its name.
        name: String,
    },
    /// Its bytes are others.
    Changed {
        /// Its name.
        name: String,
        /// What the manifest says.
        expected: Entry,
        /// What is there.
        found: Entry,
    },
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing { name } => write!(f, "{name}: is missing"),
            Self::Changed { name, expected, found } => write!(
                f,
                "{name}: is not as it was written: {} bytes with SHA-256 {} instead of {} with {}",
                found.bytes, found.sha256, expected.bytes, expected.sha256
            ),
        }
    }
}

/// Whether a name cannot lead out of its folder.
fn is_plain(name: &str) -> bool {
    let mut components = Path::new(name).components();
    matches!(
        (components.next(), components.next()),
        (Some(Component::Normal(_)), None)
    )
}

impl Manifest {
    pub(crate) fn new(identity: &Identity, files: &[(&str, &[u8])]) -> Self {
        let entry = |contents: &[u8]| Entry {
            bytes: contents.len() as u64,
            sha256: sha256(contents),
        };
        let mut manifest = Self {
            format: FORMAT,
            identity: identity.clone(),
            files: files.iter().map(|(name, of)| ((*name).to_owned(), entry(of))).collect(),
            sha256: String::new(),
        };
        manifest.sha256 = manifest.checksum();
        manifest
    }

    /// The manifest of a folder.
    ///
    /// # Errors
    /// [`Error::NoManifest`], [`Error::Interrupted`], [`Error::DamagedManifest`], [`Error::File`].
    pub fn read(folder: &Path) -> Result<Self, Error> {
        if folder.join(COMPLETE).exists() {
            return Err(Error::Interrupted {
                folder: folder.to_owned(),
            });
        }
        Self::read_file(&folder.join(MANIFEST))?.ok_or_else(|| Error::NoManifest {
            folder: folder.to_owned(),
        })
    }

    /// The manifest in a file, if the file is there. Every byte must be as it was written.
    pub(crate) fn read_file(path: &Path) -> Result<Option<Self>, Error> {
        let damaged = |reason: String| Error::DamagedManifest {
            path: path.to_owned(),
            reason,
        };
        let bytes = match std::fs::read(path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            read => read.map_err(|source| Error::file(path, "reading", source))?,
        };
        let manifest: Self = serde_json::from_slice(&bytes).map_err(|error| damaged(error.to_string()))?;
        if manifest.format != FORMAT {
            return Err(damaged(format!(
                "its format is {} instead of {FORMAT}",
                manifest.format
            )));
        }
        if let Some(name) = manifest.files.keys().find(|name| !is_plain(name)) {
            return Err(damaged(format!("`{name}` is no file of the folder itself")));
        }
        if manifest.sha256 != manifest.checksum() || manifest.to_bytes() != bytes {
            return Err(damaged("its checksum does not fit".into()));
        }
        Ok(Some(manifest))
    }

    /// Compares every byte of the files in `folder` with what was written.
    ///
    /// # Errors
    /// [`Error::File`] for what is there but cannot be read.
    pub fn defects(&self, folder: &Path) -> Result<Vec<Defect>, Error> {
        let mut defects = Vec::new();
        for (name, expected) in &self.files {
            let path = folder.join(name);
            if !path.is_file() {
                defects.push(Defect::Missing { name: name.clone() });
                continue;
            }
            let (bytes, sha256) = sha256_of_file(&path)?;
            let found = Entry { bytes, sha256 };
            if found != *expected {
                defects.push(Defect::Changed {
                    name: name.clone(),
                    expected: expected.clone(),
                    found,
                });
            }
        }
        Ok(defects)
    }

    fn checksum(&self) -> String {
        let mut body = self.clone();
        body.sha256.clear();
        sha256(&body.to_bytes())
    }

    /// The file; texts and whole numbers are always encodable.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = serde_json::to_vec_pretty(self).unwrap_or_default();
        bytes.push(b'\n');
        bytes
    }
}
