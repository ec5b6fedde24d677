//! VTK unstructured grids (`.vtu`): solids with a material number per cell, and fields of points and cells.
//!
//! Cell types are 10, 12, 13 and 24 (tetrahedron, hexahedron, wedge, quadratic tetrahedron), 25, 29 and 26 (quadratic and
//! triquadratic hexahedron, quadratic wedge); the cell array [`MATERIAL`] is the index into the materials. Node orders (VTK file formats, "Cell types") stand in the table of
//! [`crate::elements`]; they are this crate's, except that versions of VTK differ in the first triangle of a wedge: both
//! orders are read. VTK knows no units: lengths are taken as metres.
//!
//! [`write()`] writes solids, [`write_surface`] a surface, such as an interface with fields of its elements; [`read_surface`] reads either.

mod arrays;
mod contents;
mod document;
mod field;
mod solid;
mod write;

pub use contents::{Contents, Surface};
pub use field::{Encoding, Field, MATERIAL};
pub use write::{write, write_surface};

use super::solid_mesh::SolidMesh;
use crate::Error;
use crate::mesh::Material;
use document::{Grid, Reader};

/// Reads `bytes`; `file` is its name in messages. Arrays may be text, base64 or appended, little endian, uncompressed or
/// compressed by zlib.
///
/// Without an array [`MATERIAL`] all cells have material 0, if it is the only one. Hexahedra get the default
/// formulation.
///
/// # Errors
/// [`Error::MeshSyntax`] where the format is broken; [`Error::MeshUnsupported`] for other data sets, several pieces,
/// other compression, big-endian numbers and other cells; [`Error::MeshContents`] for indices without a target and files
/// without solids; [`Error::NotFinite`] for coordinates.
pub fn read(file: &str, bytes: &[u8], materials: &[Material]) -> Result<Contents, Error> {
    let reader = Reader::new(file, bytes);
    let mut grid = Grid::default();
    reader.document(&mut grid)?;
    reader.contents(&grid, materials)
}

/// Reads the surface in `bytes`, with its fields: that of [`write_surface`], or the outer faces of solids; `file` is its name in messages.
///
/// # Errors
/// As those of [`read()`], but for files without solids.
pub fn read_surface(file: &str, bytes: &[u8]) -> Result<Surface, Error> {
    let reader = Reader::new(file, bytes);
    let mut grid = Grid::default();
    reader.document(&mut grid)?;
    reader.surface(&grid)
}

/// The solids of a file, and the groups that integer arrays of its cells make, without materials.
pub(super) fn solid_mesh(file: &str, bytes: &[u8]) -> Result<SolidMesh, Error> {
    let reader = Reader::new(file, bytes);
    let mut grid = Grid::default();
    reader.document(&mut grid)?;
    reader.solid_mesh(&grid)?.finish(file)
}
