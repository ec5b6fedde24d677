//! Prestress, linearised modes and coupled quasi-static modal analysis (CQSMA) of structures with hysteretic forces.
//!
//! A structure is a pair of dense symmetric matrices whose leading coordinates feel a [`force::HystereticForce`]. In
//! the order of a computation: [`prestress::solve`] finds the equilibrium under the static load, [`modes::linearise`] the
//! modes about it with everything stuck, [`cqsma::run`] computes the hysteresis loops of one mode and turns them into
//! frequency and damping (Balaji, Chen and Brake 2020, DOI 10.1016/j.ymssp.2020.106615, section 3.1.2).
//!
//! Beside it, on the same equilibria: [`masing::run`] takes the loops from one initial loading curve by Masing's rule,
//! [`rqnma::run`] lets the mode's shape change with the amplitude. QSMA (eqs. 34-36) is [`cqsma::run`] on a force that
//! is linear in the normal direction. [`transient::run`] assumes none of what they have in common: it integrates the
//! motion in time.
//!
//! The feature `serde` makes results serialisable.
//!
//! Residuals are measured in the energy norm of the stuck structure, `sqrt(r^T P^-1 r)`: one number for forces and
//! modal forces alike, independent of units.
pub mod cqsma;
mod error;
pub mod force;
pub mod hysteresis;
mod linear;
pub mod loading;
pub mod masing;
pub mod modes;
pub mod newton;
mod path;
pub mod prestress;
pub mod random;
pub mod rqnma;
pub mod sensitivity;
pub mod test_problems;
pub mod transient;

pub use contact_laws::{RegimeCounts, Sticking};
pub use cqsma::{BackbonePoint, LoopObserver, LoopResult, NoObserver};
pub use dense_algebra::{Limits, Reflection};
pub use error::Error;
pub use force::{HystereticForce, PatternView};
pub use loading::{LoadingPoint, LoadingResult};
pub use modes::Linearisation;
pub use newton::{Failure, LinearSolver, NewtonSettings, Reason};
pub use sensitivity::{DifferentiableForce, Step};
