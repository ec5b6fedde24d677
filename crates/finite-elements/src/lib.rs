//! Linear finite elements: solids, ties, couplings, shanks of bolts, equations, sparse mass and stiffness, and eigenpairs.
//!
//! An [`mesh::Assembly`] (mesh, ties, couplings, shanks, equations, loads) becomes a [`assemble::System`] (sparse `M`, `K`, loads
//! over the independent displacement components). [`factor::SparseCholesky`] factors its shifted stiffness, and
//! [`eigen::lowest_modes`] finds its lowest modes. [`elements`] holds one table with a row per element type. [`Quadratic`] turns
//! an assembly of linear elements into quadratic ones. [`formats`]
//! reads and writes files: input decks of Abaqus and CalculiX, meshes of Gmsh and VTK. Lengths are metres, forces
//! newtons, masses kilograms.
pub mod assemble;
pub mod constraints;
pub mod eigen;
pub mod elements;
mod error;
pub mod factor;
pub mod formats;
pub mod groups;
mod material;
pub mod mesh;
pub mod ordering;
mod quadratic;
pub mod recovery;
pub mod reflection;
mod rigid;
pub mod sets;
mod shank;
pub mod sparse;
mod superelement;

pub use error::{DeckProblem, Error, Position};
pub use quadratic::Quadratic;
