//! What the arguments of commands leave open.

use joint_model::Benchmark;
use std::path::PathBuf;

/// What the program decides where the arguments leave it open.
#[derive(Clone, Default)]
pub struct Defaults {
    /// Folder of the cache; none: nothing is cached.
    pub cache: Option<PathBuf>,
    /// The benchmark that scenes without a structure are on, and whose first scene commands take that are given none.
    pub benchmark: Option<&'static dyn Benchmark>,
}
