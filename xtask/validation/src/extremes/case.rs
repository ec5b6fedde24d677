//! What a case is.

use super::bench::Bench;
use super::findings::Findings;
use anyhow::Result;

/// One hostile situation.
pub struct Case {
    pub(super) name: &'static str,
    /// What is done to the scene.
    pub(super) change: &'static str,
    /// What must happen.
    pub(super) expected: &'static str,
    /// Does it, and compares. Errors are those that the case did not expect.
    pub(super) run: fn(&Bench) -> Result<Findings>,
}
