//! Zero-thickness interface elements: interpolation and integration operators, force and tangent assembly,
//! dissipation flux.
//!
//! A [`mesh::InterfaceMesh`] and a quadrature give [`operators::Operators`] (`Q` and `T` of section 2.1 of Balaji, Chen
//! and Brake 2020, DOI 10.1016/j.ymssp.2020.106615); with a traction law per range of points they become an
//! [`interface::Interface`] that turns nodal jumps into nodal forces and a sparse tangent. Nothing here knows about a
//! solver or about the bodies on either side.
mod clip;
mod element;
mod element_sums;
mod error;
pub mod flux;
pub mod interface;
mod kernels;
pub mod mesh;
pub mod mortar;
pub mod operators;
mod overlap;
mod points;
pub mod quadrature;
pub mod shape;
mod tree;

pub use error::Error;
pub use interface::{Interface, LocalGradient, State, Step, Variation, Workspace};
pub use mesh::{Covered, Element, InterfaceMesh, PointContact};
pub use mortar::{Mortar, Rise};
pub use operators::Operators;
pub use points::Batches;
