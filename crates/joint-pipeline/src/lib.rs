//! Scenes and their composition: from surface and geometry to frequency and damping against amplitude.
//!
//! A [`scene::Scene`] says what is modelled; [`run::run`] meshes, assembles and reduces the structure (or takes the
//! reduced model from a cache), turns the surface into traction laws, finds the prestress and the modes about it, and
//! walks the hysteresis loops. [`summary`] is the machine-readable account of a run.
pub mod accuracy;
mod cache;
mod checkpoint;
pub mod comparison;
pub mod ensemble;
mod error;
pub mod export;
pub mod interface;
pub mod joint;
pub mod matrices;
pub mod methods;
pub mod model;
mod parameters;
pub mod progress;
pub mod registration;
pub mod run;
mod scans;
pub mod scene;
pub mod summary;
pub mod surface;
pub mod transient;
pub mod trends;
pub mod validity;

pub use error::Error;
pub use run::{Options, Run, run, run_ensemble};
pub use scene::Scene;
