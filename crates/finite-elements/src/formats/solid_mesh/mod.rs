//! Solid meshes of any format: nodes, cells and named groups, without materials and units.
//!
//! | format | volumes | surfaces | points |
//! |---|---|---|---|
//! | Gmsh 4.1 and 2.2 (`.msh`), text and binary | physical volumes | physical surfaces | physical points and curves |
//! | Abaqus and CalculiX (`.inp`) | `ELSET` of solids | `*SURFACE` of element faces; `ELSET` of shells, membranes, plane and rigid elements on faces of solids | `NSET`; `*SURFACE` of nodes; `ELSET` of trusses and beams |
//! | Nastran and Optistruct (`.bdf`, `.nas`, `.fem`) | `PSOLID=N` | `PSHELL=N`, `PLOAD4=N`, `BSURFS=N` | `SPC=N`, `SET=N`, `RBE2=N`, `CBAR=N` |
//! | Ansys archives (`.cdb`) | components of elements, `MAT=N`, `TYPE=N` | components of shell, contact and target elements, `TYPE=N` | components of nodes |
//! | Exodus II (`.exo`, `.e`, `.g`) | blocks | side sets, blocks of shells | node sets |
//! | MED (`.med`) | groups of volumes | groups of faces | groups of nodes, edges and points |
//! | Universal files (`.unv`) | groups of elements, `PROPERTY=N` | the same, of shells | groups of nodes |
//! | VTK (`.vtu`) | integer cell arrays, `ARRAY=VALUE` | the same, of two-dimensional cells | the same, of points and lines |
//!
//! Groups are found by [`SolidMesh::volume`], [`SolidMesh::surface`] and [`SolidMesh::points`]: by the name as it stands, or
//! else without regard to case, as in decks. In VTK files with one integer array `VALUE` alone is a name too.
//!
//! A surface is a set of faces of solids, each counter-clockwise seen from outside, whichever way the file lists it. Lines and
//! facets are there to name things: they are no part of the structure. In the files of Nastran, Ansys and I-DEAS a group of nodes
//! is also a surface: the faces of the outside that have all their nodes in it.
//!
//! Cells whose nodes are listed in mirrored order are read the other way round, with a note. Refused are cells that are inverted at
//! an integration point, listed twice, or that use a node twice.

mod checks;
mod mesh;
mod raw;

pub use mesh::SolidMesh;
pub(super) use raw::{Raw, Side};

use super::{abaqus, ansys, exodus, gmsh, med, nastran, universal, vtu};
use crate::Error;
use std::path::{Path, PathBuf};

/// Formats of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MSH 4.1 or 2.2 of Gmsh (`.msh`).
    Gmsh,
    /// Input decks of Abaqus and CalculiX (`.inp`), of which only the mesh is read.
    Abaqus,
    /// Unstructured grids of VTK (`.vtu`).
    Vtu,
    /// Bulk data of Nastran and Optistruct (`.bdf`, `.nas`, `.fem`).
    Nastran,
    /// Archives of Ansys Mechanical APDL (`.cdb`).
    Ansys,
    /// Exodus II (`.exo`, `.e`, `.g`).
    Exodus,
    /// MED files of Salome and code_aster (`.med`).
    Med,
    /// Universal files of I-DEAS (`.unv`).
    Universal,
}

impl Format {
    /// The format of files with the extension of `path`.
    ///
    /// # Errors
    /// [`Error::MeshFormat`] for others.
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
            "bdf" | "nas" | "fem" => Ok(Self::Nastran),
            "cdb" => Ok(Self::Ansys),
            "unv" => Ok(Self::Universal),
            "med" | "rmed" | "mmed" => Ok(Self::Med),
            "exo" | "e" | "g" => Ok(Self::Exodus),
            "dat" => refuse(
                "several programs write files `.dat`".into(),
                "call it .bdf if it is bulk data of Nastran, .cdb if it is an input of Ansys",
            ),
            "cgns" | "mesh" => refuse(
                format!("files `.{extension}` are not read"),
                "convert it by Gmsh: gmsh IN -save -format msh41 -o OUT.msh",
            ),
            "vtk" | "pvtu" | "vtm" | "vtkhdf" | "xdmf" => refuse(
                format!("files `.{extension}` are not read"),
                "save it as one unstructured grid (.vtu) by ParaView",
            ),
            "step" | "stp" | "iges" | "igs" | "brep" | "geo" => refuse(
                format!("`.{extension}` is a geometry, not a mesh"),
                "mesh it by Gmsh: gmsh IN -3 -format msh41 -o OUT.msh",
            ),
            _ => refuse(
                "the extension is not that of a mesh".into(),
                "give a mesh of Gmsh (.msh), Abaqus or CalculiX (.inp), Nastran (.bdf), Ansys (.cdb), I-DEAS (.unv), Exodus (.exo), Salome (.med) or VTK (.vtu)",
            ),
        }
    }
}

impl SolidMesh {
    /// Reads a file of at most the size that [`file_io::input::Kind::Mesh`] allows (of decks [`file_io::input::Kind::Deck`]),
    /// by the format that its extension tells. Decks and bulk data may include files in their folder and below.
    ///
    /// # Errors
    /// [`Error::MeshFormat`] for other extensions; [`Error::InputFile`] if the file cannot be read; else as
    /// [`SolidMesh::from_bytes`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        let format = Format::of(path)?;
        match format {
            Format::Abaqus => return abaqus::solid_mesh_of_file(path),
            Format::Nastran => return nastran::solid_mesh_of_file(path),
            _ => {}
        }
        let bytes = file_io::input::read(path, file_io::input::Kind::Mesh)?;
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        Self::from_bytes(&name, format, &bytes)
    }

    /// The files that [`SolidMesh::read`] reads: `path`, and what it includes.
    ///
    /// # Errors
    /// Those of the files and the lines that include them.
    pub fn files(path: &Path) -> Result<Vec<PathBuf>, Error> {
        match Format::of(path)? {
            Format::Abaqus => abaqus::files(path, abaqus::Includes::BelowTheDeck),
            Format::Nastran => nastran::files(path),
            _ => Ok(vec![path.to_owned()]),
        }
    }

    /// Reads `bytes`; `file` is its name in messages. Decks may not include files here.
    ///
    /// # Errors
    /// Those of the formats: [`Error::MeshSyntax`], [`Error::MeshUnsupported`], [`Error::MeshContents`],
    /// [`Error::NotFinite`], and [`Error::Deck`] for decks. [`Error::MeshCells`] for inverted and repeated cells,
    /// [`Error::MeshGroup`] for a physical surface of Gmsh with a face that belongs to no solid.
    pub fn from_bytes(file: &str, format: Format, bytes: &[u8]) -> Result<Self, Error> {
        match format {
            Format::Gmsh => gmsh::solid_mesh(file, bytes),
            Format::Abaqus => abaqus::solid_mesh(file, bytes),
            Format::Vtu => vtu::solid_mesh(file, bytes),
            Format::Nastran => nastran::solid_mesh(file, bytes),
            Format::Ansys => ansys::solid_mesh(file, bytes),
            Format::Exodus => exodus::solid_mesh(file, bytes),
            Format::Med => med::solid_mesh(file, bytes),
            Format::Universal => universal::solid_mesh(file, bytes),
        }
    }
}
