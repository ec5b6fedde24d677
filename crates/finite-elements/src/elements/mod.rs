//! The table of solid elements, and the stiffness and mass of single elements.
//!
//! Each element type is a file with one row, an [`ElementType`]: nodes, faces, formulations, interpolation, quadrature
//! and the names and node orders of the file formats. [`ELEMENT_TYPES`] lists the rows; readers, writers, assembly and
//! ties look everything up there. The faces have a table of their own, [`FACE_TYPES`].
//!
//! | element | stiffness | mass |
//! |---|---|---|
//! | hexahedron of 8 nodes, [`Formulation`] | 2 x 2 x 2 Gauss points, or one | consistent; lumped by row sums if reduced |
//! | hexahedron of 20, [`Formulation`] | 3 x 3 x 3 Gauss points, or 2 x 2 x 2 | 4 x 4 x 4 points: exact where edges are straight |
//! | hexahedron of 27 | 3 x 3 x 3 Gauss points | 4 x 4 x 4 points: exact where edges are straight |
//! | wedge of 6 | 3 points in the triangle x 2 along it | the same points |
//! | wedge of 15 | 3 points in the triangle x 3 along it | 64 points: exact where edges are straight |
//! | tetrahedron of 4 | constant strain | exact |
//! | tetrahedron of 10 | 4 points | 64 points: exact where faces are plane |
//!
//! All are isotropic: with the gradients `g_a` of the shape functions the block of nodes `a`, `b` is
//! `lambda g_a g_b^T + mu g_b g_a^T + mu (g_a . g_b) 1`.

mod cell;
mod face;
mod hex20;
mod hex27;
mod hex8;
mod isoparametric;
mod lagrange;
mod matrices;
mod orientation;
mod quadrature;
mod sampling;
mod sides;
mod table;
mod tet10;
mod tet4;
mod wedge15;
mod wedge6;

pub use cell::{Alternative, Cell, ElementType, ForeignType, Formulation};
pub use face::{Domain, FACE_TYPES, Face, FaceType, QUAD4, QUAD8, QUAD9, TRI3, TRI6};
pub use hex8::{CORNERS, HEX8};
pub use hex20::HEX20;
pub use hex27::HEX27;
pub use matrices::Matrices;
pub(crate) use orientation::{JacobianCheck, Orientation};
pub(crate) use sampling::{COMPONENTS, Samples, Strains, determinant};
pub(crate) use sides::{Corners, Sides};
pub use table::ELEMENT_TYPES;
pub(crate) use table::{abaqus_names, descriptions, from_abaqus, to_abaqus};
pub use tet4::TET4;
pub use tet10::TET10;
pub use wedge6::WEDGE6;
pub use wedge15::WEDGE15;

use crate::Error;
use crate::material::Material;
use matrices::Place;

/// Stiffness and mass of a cell whose nodes are at `x` (m); `element` is its number in messages.
///
/// # Errors
/// [`Error::InvertedElement`] if the Jacobian determinant is not positive at an integration point.
///
/// # Panics
/// If there are not as many points as nodes.
pub fn matrices(element: usize, cell: &Cell, x: &[[f64; 3]], material: &Material) -> Result<Matrices, Error> {
    assert_eq!(x.len(), cell.nodes().len());
    (cell.element_type().matrices)(&Place { element, x, material }, cell.formulation())
}
