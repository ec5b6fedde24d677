//! Scenes and their composition: from surface and geometry to frequency and damping against amplitude.
//!
//! A [`scene::Scene`] says what is modelled. [`structure::Structure`] meshes, assembles and reduces it, or takes the reduced
//! model from a cache; [`interface::SceneInterface`] turns its surface into traction laws; [`run`] finds the prestress and
//! the modes about it and follows the hysteresis loops. [`results::summary`] is the machine-readable account of a run.
pub mod analysis;
mod error;
pub mod interface;
pub mod joint;
pub mod progress;
pub mod results;
pub mod scene;
mod scoped;
mod store;
pub mod structure;

pub use analysis::uncertainty::run_samples;
pub use analysis::{Run, run, run_ensemble};
pub use error::Error;
pub use joint::benchmark::{Benchmark, Benchmarks};
pub use scene::Scene;
pub use store::Options;
