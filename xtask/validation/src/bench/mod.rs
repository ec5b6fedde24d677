//! The benchmark set: figures of one run, so that ratios hold even where times do not.
mod instruments;
mod periodic;
mod solver;

use anyhow::Result;
use serde_json::{Value, json};
use std::path::PathBuf;

pub use instruments::Instruments;
pub use solver::Scaling;

/// Interface, solver and reduction of 588 elements of 25 points, from the mesh to the backbone: figures under their names, and a
/// table of them.
///
/// # Errors
/// The scene cannot be run, or does not converge.
pub fn solver(instruments: &Instruments<'_>) -> Result<(Vec<(&'static str, Value)>, String)> {
    solver::figures(instruments)
}

/// Free periodic motions: 25 amplitudes on the default mesh, and on the coarse one with a point per element; figures and a table.
///
/// # Errors
/// A scene cannot be run, or a motion does not converge.
pub fn periodic(instruments: &Instruments<'_>) -> Result<(Value, String)> {
    periodic::figures(instruments)
}

/// Cost of the backbone against the number of elements at 4 points each, and against points per element. Reduced models are kept in
/// the folder `cache`.
///
/// # Errors
/// A scene cannot be run, or does not converge.
pub fn scaling(cache: PathBuf, instruments: &Instruments<'_>) -> Result<Scaling> {
    solver::scaling(cache, instruments)
}

/// What the figures were measured on.
pub fn processor() -> Value {
    json!({
        "architecture": std::env::consts::ARCH,
        "instruction_set": contact_laws::instruction_set(),
        "features": features(),
        "threads": std::thread::available_parallelism().map_or(1, usize::from),
    })
}

#[cfg(target_arch = "x86_64")]
fn features() -> Vec<&'static str> {
    [
        ("sse4.2", std::arch::is_x86_feature_detected!("sse4.2")),
        ("avx", std::arch::is_x86_feature_detected!("avx")),
        ("avx2", std::arch::is_x86_feature_detected!("avx2")),
        ("fma", std::arch::is_x86_feature_detected!("fma")),
        ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
    ]
    .into_iter()
    .filter_map(|(name, has)| has.then_some(name))
    .collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn features() -> Vec<&'static str> {
    Vec::new()
}
