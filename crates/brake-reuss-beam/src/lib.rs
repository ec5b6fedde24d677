//! The Brake-Reuss beam, the field's benchmark of a bolted lap joint: geometry, block-structured hexahedral mesh and
//! published data.
//!
//! Two half-beams of square section overlap in a lap and are held by three bolts with washers and nuts.
//! [`mesh::build`] turns a [`geometry::Geometry`] and a [`mesh::Refinement`] into a
//! [`mesh::BrakeReussBeam`]: the solid mesh with its ties, couplings, equations and bolt loads, and the interface
//! mesh whose nodes pair the two half-beams. [`published`] carries measured and computed figures with their sources.
//!
//! Axes: `x` along the beam, `y` across, `z` along the bolts; the origin is the middle of the interface, which is the
//! plane `z = 0`. Everything is SI.
pub mod benchmark;
mod error;
pub mod geometry;
pub mod identification;
pub mod mesh;
mod mesh_accuracy;
pub mod published;
pub mod quality;

pub use benchmark::BrakeReussBenchmark;
pub use error::Error;

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
