//! From a prepared scene to its results: prestress, backbones, other methods, ensembles, motion in time.

mod backbone;
pub mod calibration;
pub mod cases;
pub mod comparison;
mod deformed;
mod effects;
mod element_loops;
pub mod ensemble;
pub mod error_estimate;
pub mod finite_differences;
pub mod hyper_reduced;
pub mod mesh_error;
pub mod methods;
mod observer;
mod outcome;
pub mod periodic;
mod prestress;
pub mod registration;
mod run;
mod sampling;
mod sensitivities;
mod tightening;
pub mod transient;
pub mod uncertainty;
pub mod validity;
pub mod variants;
pub mod warnings;

pub use crate::store::checkpoint::Checkpoints;
pub use deformed::Deformed;
pub use element_loops::{ElementLoops, MOST_RECORDED, element_centres};
pub use outcome::{AmplitudeResult, Fields, LoopFields, PrestressResult};
pub use run::{ModeBackbone, Prepared, Run, prepare, run, run_ensemble};
pub use sampling::unit_cube;
pub use sensitivities::{FoundBy, Per, Sensitivity};
pub use tightening::{ENERGY_TOLERANCE, TighteningEnergy, TighteningResult, TighteningStep};
