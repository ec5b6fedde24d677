//! Periodic motions of structures with hysteretic forces by harmonic balance.
//!
//! A structure is a prestressed one that [`cqsma_solver::modes::linearise`] has linearised; its contact is a [`PointwiseForce`].
//! [`backbone::follow`] computes free motions (EPMC) or phase resonances against the amplitude, [`forced::follow`] forced responses against
//! the frequency through turning points, [`synthesis`] the forced response that one nonlinear mode alone would have.
//!
//! The contact is followed in time ([`aft::Sampling`]), the rest in frequency. Newton's method sees the Jacobian through its products
//! alone. Residuals are measured in the energy norm of the stuck structure, relative to the elastic forces of the motion.
pub mod aft;
pub mod backbone;
mod error;
pub mod force;
pub mod forced;
pub mod harmonics;
pub mod interface;
mod load;
pub mod points;
pub mod probe;
mod solve;
pub mod stability;
pub mod synthesis;
mod system;

pub use aft::Sampling;
pub use error::Error;
pub use force::{DifferentiablePointwiseForce, PointwiseForce};
pub use harmonics::Harmonics;
pub use load::Load;
pub use solve::{Effort, Failure, NewtonSettings, Reason};
