//! Gmsh meshes: MSH files of versions 4.1 and 2.2, read as text or binary; those of version 4.1 written as text.
//!
//! | Gmsh | here |
//! |---|---|
//! | elements of type 4, 5, 6, 11 (tetrahedron, hexahedron, prism, 10-node tetrahedron) | elements of the mesh |
//! | elements of type 17, 12, 18 (20-node and 27-node hexahedron, 15-node prism) | elements of the mesh |
//! | physical group of dimension 3 | material, by name |
//! | elements of type 2, 3, 9, 16, 10 (triangle, quadrangle, 6-node triangle, 8-node and 9-node quadrangle) in a group of dimension 2 | list of faces |
//! | points and lines in a group of dimension 0 or 1 | list of nodes |
//!
//! Gmsh writes quadratic elements without nodes in faces and inside (types 17, 18) if `Mesh.SecondOrderIncomplete` is 1.
//!
//! Node orders (Gmsh reference manual, section "Node ordering") stand in the table of [`crate::elements`]. Faces keep the
//! order of the file, whose normals are those of the geometry and not necessarily outward
//! ([`SolidMesh`] turns them outward); the sign of a physical tag is ignored. Gmsh knows no units: lengths are taken as metres.

mod assemble;
mod listed;
mod parts;
mod reader;
mod solid;
mod write;

pub use parts::Contents;
pub use write::write;

use super::solid_mesh::SolidMesh;
use crate::Error;
use crate::mesh::Material;
use parts::Parts;
use reader::Reader;

/// Reads `bytes`; `file` is its name in messages.
///
/// A physical group of dimension 3 without a name goes by its tag. A volume takes the material that has the name of one
/// of its groups, or else `fallback`. Hexahedra get the default formulation.
///
/// # Errors
/// [`Error::MeshSyntax`] where the format is broken; [`Error::MeshUnsupported`] for other versions, partitioned
/// meshes and other elements; [`Error::MeshContents`] for counts that the file cannot hold, tags given twice or
/// missing, files without solids, faces in groups that belong to no solid, volumes with no material or several;
/// [`Error::NotFinite`] for coordinates.
pub fn read(file: &str, bytes: &[u8], materials: &[Material], fallback: Option<&Material>) -> Result<Contents, Error> {
    let mut reader = Reader::new(file, bytes);
    let mut parts = Parts::default();
    reader.sections(&mut parts)?;
    parts.assemble(&reader, materials, fallback)
}

/// The solids and groups of a file, without materials.
pub(super) fn solid_mesh(file: &str, bytes: &[u8]) -> Result<SolidMesh, Error> {
    let mut reader = Reader::new(file, bytes);
    let mut parts = Parts::default();
    reader.sections(&mut parts)?;
    parts.solids(&reader)?.finish(file)
}
