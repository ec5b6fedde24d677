//! Where tests read reference data and write files.

use std::ops::Deref;
use std::path::{Path, PathBuf};

/// The reference file of this name in the folder that the environment variable `BRB_REFERENCE` names; relative folders
/// start at the workspace. `None`, and a line that says what is skipped, where the variable is not set.
#[must_use]
#[expect(clippy::print_stdout, reason = "tests say what they skip")]
pub fn reference_file(name: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("BRB_REFERENCE") else {
        println!("skipped: BRB_REFERENCE does not name the folder that holds {name}");
        return None;
    };
    // Tests run in the folder of their crate.
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Some(workspace.join(folder).join(name))
}

/// An empty folder of a test's own, removed with all that is in it when the value is dropped.
#[derive(Debug)]
pub struct TemporaryFolder(PathBuf);

impl TemporaryFolder {
    /// Makes the folder; `name` is unique among the tests that run at one time.
    ///
    /// # Panics
    /// If it cannot be made.
    pub fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("{name}-{}", std::process::id()));
        if let Err(error) = std::fs::create_dir_all(&folder) {
            panic!("{}: {error}", folder.display());
        }
        Self(folder)
    }
}

impl Deref for TemporaryFolder {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        // What is left over harms nobody.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
