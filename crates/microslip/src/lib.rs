#![doc = include_str!("../README.md")]

pub mod check;
pub mod cli;
pub mod commands;
pub mod files;
pub mod progress;
mod text;

/// What the book shows of Rust compiles, and runs unless it says otherwise.
#[cfg(doctest)]
mod book {
    #[doc = include_str!("../../../docs/guide/rust-and-c.md")]
    mod rust_and_c {}
    #[doc = include_str!("../../../docs/laws/foundation.md")]
    mod foundation {}
    #[doc = include_str!("../../../docs/laws/greenwood-williamson.md")]
    mod greenwood_williamson {}
}

pub use analyses::results::summary::Summary;
pub use analyses::{Error, Run, run, run_ensemble, run_samples};
pub use commands::{Command, Defaults, Outcome, execute};
pub use host::BENCHMARKS;
pub use joints::Options;
pub use scenes::Scene;
