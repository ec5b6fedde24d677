//! From measured ring-downs to natural frequency and damping ratio against amplitude.
pub mod average;
pub mod backbone;
mod error;
pub mod filter;
pub mod hilbert;
pub mod peaks;
pub mod readers;
pub mod signal;
pub mod smoothing;
pub mod spectrum;
pub mod synthetic;
mod track;

pub use error::{Error, Setting, Warning};
