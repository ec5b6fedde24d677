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
mod raw;

pub(super) use raw::{Raw, Side};

use super::{abaqus, gmsh, vtu};
use crate::elements::Sides;
use crate::error::{Error, known_names};
use crate::mesh::{Cell, Face, Group};
use crate::sets::DisjointSets;
use raw::Defect;
use std::collections::BTreeMap;
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

/// A mesh file: solids and named groups, without materials or units.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidMesh {
    /// Nodes of the cells, in the length unit and in the order of the file.
    pub nodes: Vec<[f64; 3]>,
    /// The file's own number of each node, for messages; of VTU files the index of the point. In decks with instances it
    /// is the number within the instance.
    pub labels: Vec<u64>,
    /// Solids. Those of decks have the formulation that their type names, the others the default of their type.
    pub cells: Vec<Cell>,
    /// Named groups of cells (indices, ascending). No group is empty; those that would be are in the notes.
    pub volumes: Vec<Group<u32>>,
    /// Named groups of faces, each face once and counter-clockwise seen from outside its solid. Groups that no surface can be
    /// made of are left out; [`SolidMesh::surface`] tells why.
    pub surfaces: Vec<Group<Face>>,
    /// Named groups of nodes (ascending indices, each once).
    pub points: Vec<Group<u32>>,
    /// What was skipped or is noteworthy, a sentence each.
    pub notes: Vec<String>,
    /// Name of the file, for messages.
    file: String,
    /// Surfaces that are left out, by name.
    defects: BTreeMap<String, Defect>,
    /// The one integer array of a VTU file.
    array: Option<String>,
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

    /// Faces of one cell only, outward, with their cell: the surface of the bodies. They are in the order of the cells.
    pub fn boundary(&self) -> Vec<(Face, u32)> {
        Sides::of(&self.cells).boundary(&self.cells)
    }

    /// Sets of cells that share nodes: for each cell the number of its body. Bodies are numbered from zero in the order of
    /// their first cells.
    pub fn bodies(&self) -> Vec<u32> {
        let mut sets = DisjointSets::of_groups(self.nodes.len(), self.cells.iter().map(Cell::nodes));
        let mut number_of = vec![u32::MAX; self.nodes.len()];
        let mut count = 0;
        let numbers = self.cells.iter().map(|cell| {
            let number = &mut number_of[sets.root(cell.nodes()[0]) as usize];
            if *number == u32::MAX {
                *number = count;
                count += 1;
            }
            *number
        });
        numbers.collect()
    }

    /// The cells of a group.
    ///
    /// # Errors
    /// [`Error::NotInMesh`] with the names that there are; [`Error::MeshGroup`] if the name fits several groups.
    pub fn volume(&self, name: &str) -> Result<&[u32], Error> {
        self.group(&self.volumes, "volume", name)
    }

    /// The faces of a group, counter-clockwise seen from outside.
    ///
    /// # Errors
    /// As [`SolidMesh::volume`]; [`Error::MeshGroup`] also for groups with faces between two solids, or beside them all.
    pub fn surface(&self, name: &str) -> Result<&[Face], Error> {
        if let Some(error) = self.defect(name, |a, b| a == b) {
            return Err(error);
        }
        match self.group(&self.surfaces, "surface", name) {
            Err(unknown @ Error::NotInMesh { .. }) => {
                Err(self.defect(name, str::eq_ignore_ascii_case).unwrap_or(unknown))
            }
            result => result,
        }
    }

    /// Why the group that `name` means is no surface, if it is none.
    fn defect(&self, name: &str, same: fn(&str, &str) -> bool) -> Option<Error> {
        let mut meant = self
            .defects
            .iter()
            .filter(|(known, _)| self.is_meant(known, name, same));
        meant.next().map(|(group, defect)| defect.error(&self.file, group))
    }

    /// The nodes of a group.
    ///
    /// # Errors
    /// As [`SolidMesh::volume`].
    pub fn points(&self, name: &str) -> Result<&[u32], Error> {
        self.group(&self.points, "group of nodes", name)
    }

    /// Whether `name` means the group `known`.
    fn is_meant(&self, known: &str, name: &str, same: fn(&str, &str) -> bool) -> bool {
        let value = self.array.as_ref().and_then(|array| {
            let value = known.strip_prefix(array.as_str())?;
            value.strip_prefix('=')
        });
        same(known, name) || value == Some(name)
    }

    fn group<'g, T>(&self, groups: &'g [Group<T>], what: &'static str, name: &str) -> Result<&'g [T], Error> {
        let find = |same: fn(&str, &str) -> bool| -> Vec<&'g Group<T>> {
            let meant = groups.iter().filter(|group| self.is_meant(&group.name, name, same));
            meant.collect()
        };
        let mut found = find(|a, b| a == b);
        if found.is_empty() {
            found = find(str::eq_ignore_ascii_case);
        }
        match found[..] {
            [group] => Ok(&group.members),
            [] => Err(Error::NotInMesh {
                file: self.file.clone(),
                what,
                name: name.to_owned(),
                known: known_names(groups.iter().map(|group| group.name.as_str())),
            }),
            _ => Err(Error::MeshGroup {
                file: self.file.clone(),
                group: name.to_owned(),
                problem: format!("{} groups have this name", found.len()),
                remedy: "give every group a name of its own",
            }),
        }
    }
}
