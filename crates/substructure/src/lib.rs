//! Linear finite elements: solids, ties, couplings, equations, sparse mass and stiffness, and eigenpairs.
//!
//! The road through the crate: an [`mesh::Assembly`] (mesh, ties, couplings, equations, loads) becomes a
//! [`assemble::System`] (sparse `M`, `K`, loads over the independent displacement components), whose shifted
//! stiffness is factored by [`factor::SparseCholesky`] and whose lowest modes come from [`eigen::lowest_modes`].
//! [`deck`] reads assemblies from input decks of Abaqus and CalculiX, and writes them; meshes come from and go to other
//! programs with [`gmsh`] and [`vtu`]. Lengths are metres, forces newtons, masses kilograms.
pub mod assemble;
pub mod constraints;
pub mod deck;
pub mod eigen;
pub mod elements;
mod error;
pub mod factor;
pub mod gmsh;
mod interchange;
pub mod mesh;
pub mod ordering;
pub mod sparse;
pub mod vtu;

pub use error::{DeckProblem, Error, Position};
