//! Relative interface coordinates, zero-energy modes and Craig-Bampton reduction.
//!
//! [`relative::RelativeSystem`] replaces the motion of the top side of an interface by the jump across it;
//! [`craig_bampton::reduce`] keeps the jump and the first modes of the stuck structure, and drops the rigid-body
//! motions in a way that leaves the jump untouched, so that contact forces act on the leading coordinates alone.
//! `locked`, of either, holds the displacement of every load; [`LoadCompliance`] holds that of some in static states.
//! Nothing here knows about contact.
pub mod checks;
pub mod craig_bampton;
mod error;
mod full_modes;
mod held;
mod interior;
mod locked;
mod part_modes;
pub mod relative;
mod symmetry;
mod zem;

pub use craig_bampton::{ReducedModel, Reduction, Settings, displacements, modes_of_basis, reduce, reduce_with_modes};
pub use dense_algebra::Limits;
pub use error::Error;
pub use full_modes::LinearCheck;
pub use held::{HeldSystem, Hold, LoadCompliance};
pub use relative::{FacingNodes, InterfacePairs, RelativeSystem, SystemMatrices};
