//! Where what outlives a run is kept, and in whose name.

use std::path::PathBuf;

/// What is not part of the scene.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Folder of cached reduced models, and of the finished amplitudes of interrupted runs; none: nothing is read or
    /// stored.
    pub cache: Option<PathBuf>,
    /// What distinguishes the build of the program from others of the same version, such as its commit. What other builds
    /// have stored is not read.
    pub build: Option<String>,
    /// Memory that the run may take beside what the process has (bytes); none: as much as it needs. More is refused before it is taken.
    pub memory: Option<u64>,
}

impl Options {
    /// With a folder for what is stored between runs, in the name of no particular build.
    pub fn cached(folder: impl Into<PathBuf>) -> Self {
        Self {
            cache: Some(folder.into()),
            ..Self::default()
        }
    }
}
