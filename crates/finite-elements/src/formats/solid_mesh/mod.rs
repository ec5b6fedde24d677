//! Solid meshes of any format: nodes, cells and named groups, without materials and units.
//!
//! | format | volumes | surfaces | points |
//! |---|---|---|---|
//! | Gmsh 4.1 and 2.2 (`.msh`), text and binary | physical volumes | physical surfaces | physical points and curves |
//! | Abaqus and CalculiX (`.inp`) | `ELSET` of solids | `*SURFACE` of element faces; `ELSET` of shells, membranes, plane and rigid elements on faces of solids | `NSET`; `*SURFACE` of nodes; `ELSET` of trusses and beams |
//! | VTK (`.vtu`) | integer cell arrays, `ARRAY=VALUE` | the same, of two-dimensional cells | the same, of points and lines |
//!
//! Groups are found by [`SolidMesh::volume`], [`SolidMesh::surface`] and [`SolidMesh::points`]: by the name as it stands, or
//! else without regard to case, as in decks. In VTK files with one integer array `VALUE` alone is a name too.
//!
//! A surface is a set of faces of solids, each counter-clockwise seen from outside, whichever way the file lists it. Lines and
//! facets are there to name things: they are no part of the structure.
//!
//! Refused are cells that are inverted at an integration point, listed in mirrored order, listed twice, or that use a node
//! twice.

mod checks;
mod mesh;
mod raw;

pub use mesh::SolidMesh;
pub(super) use raw::{Raw, Side};

use super::{abaqus, gmsh, vtu};
use crate::Error;
use std::path::Path;

/// Formats of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MSH 4.1 or 2.2 of Gmsh (`.msh`).
    Gmsh,
    /// Input decks of Abaqus and CalculiX (`.inp`), of which only the mesh is read.
    Abaqus,
    /// Unstructured grids of VTK (`.vtu`).
    Vtu,
}

impl Format {
    /// The format of files with the extension of `path`.
    ///
    /// # Errors
    /// [`Error::MeshFormat`] for all but `.msh`, `.inp` and `.vtu`.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let extension = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_ascii_lowercase();
        let refuse = |problem: String, remedy| {
            Err(Error::MeshFormat {
                file: path.display().to_string(),
                problem,
                remedy,
            })
        };
        match extension.as_str() {
            "msh" => Ok(Self::Gmsh),
            "inp" => Ok(Self::Abaqus),
            "vtu" => Ok(Self::Vtu),
            "unv" | "med" | "rmed" | "mmed" | "bdf" | "nas" | "cgns" | "mesh" => refuse(
                format!("files `.{extension}` are not read"),
                "convert it by Gmsh: gmsh IN -save -format msh41 -o OUT.msh",
            ),
            "vtk" | "pvtu" | "vtm" | "vtkhdf" | "xdmf" | "e" | "exo" => refuse(
                format!("files `.{extension}` are not read"),
                "save it as one unstructured grid (.vtu) by ParaView",
            ),
            "step" | "stp" | "iges" | "igs" | "brep" | "geo" => refuse(
                format!("`.{extension}` is a geometry, not a mesh"),
                "mesh it by Gmsh: gmsh IN -3 -format msh41 -o OUT.msh",
            ),
            _ => refuse(
                "the extension is not that of a mesh".into(),
                "give a mesh of Gmsh (.msh), Abaqus or CalculiX (.inp) or VTK (.vtu)",
            ),
        }
    }
}

impl SolidMesh {
    /// Reads a file of at most the size that [`file_io::input::Kind::Mesh`] allows (of decks [`file_io::input::Kind::Deck`]),
    /// by the format that its extension tells. Decks may include files in their folder and below.
    ///
    /// # Errors
    /// [`Error::MeshFormat`] for other extensions; [`Error::InputFile`] if the file cannot be read; else as
    /// [`SolidMesh::from_bytes`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        let format = Format::of(path)?;
        if format == Format::Abaqus {
            return abaqus::solid_mesh_of_file(path);
        }
        let bytes = file_io::input::read(path, file_io::input::Kind::Mesh)?;
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        Self::from_bytes(&name, format, &bytes)
    }

    /// Reads `bytes`; `file` is its name in messages. Decks may not include files here.
    ///
    /// # Errors
    /// Those of the formats: [`Error::MeshSyntax`], [`Error::MeshUnsupported`], [`Error::MeshContents`],
    /// [`Error::NotFinite`], and [`Error::Deck`] for decks. [`Error::MeshCells`] for inverted, mirrored and repeated cells,
    /// [`Error::MeshGroup`] for a physical surface of Gmsh with a face that belongs to no solid.
    pub fn from_bytes(file: &str, format: Format, bytes: &[u8]) -> Result<Self, Error> {
        match format {
            Format::Gmsh => gmsh::solid_mesh(file, bytes),
            Format::Abaqus => abaqus::solid_mesh(file, bytes),
            Format::Vtu => vtu::solid_mesh(file, bytes),
        }
    }
}
