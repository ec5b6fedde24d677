//! What the programs behind `cargo xtask` share: the arguments of tasks, the command `brb`, and where results go.
//!
//! The first program runs scenes and knows the arguments of all tasks. Long tasks and the check of the layering are
//! another program, so that the first backbone does not wait for their compilation.

pub mod arguments;
pub mod brb;

use brake_reuss_beam::BrakeReussBenchmark;
use microslip::Defaults;
use microslip::commands::RESULTS;
use std::path::Path;

/// The beam where a scene names no structure; the cache beside the results, where an interrupted command finds it again.
#[must_use]
pub fn defaults() -> Defaults {
    Defaults {
        cache: Some(Path::new(RESULTS).join(".cache")),
        benchmark: Some(&BrakeReussBenchmark),
    }
}
