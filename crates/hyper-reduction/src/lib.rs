#![doc = include_str!("../README.md")]

mod error;
mod estimate;
mod force;
mod joint;
mod loops;
mod quadrature;
mod training;

pub use error::Error;
pub use estimate::ErrorEstimate;
pub use force::{PointForce, Scratch, SelectedPoints};
pub use joint::HyperReducedJoint;
pub use loops::JudgedLoop;
pub use quadrature::{Selection, select};
pub use training::{LoopRecord, Recorder, Settings, StaticState, Trained, TrainingMode, train};
