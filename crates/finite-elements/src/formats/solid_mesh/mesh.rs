//! Nodes, cells and named groups of a mesh file.

use crate::elements::Sides;
use crate::error::{Error, known_names};
use crate::mesh::{Cell, Face, Group};
use crate::sets::DisjointSets;
use std::collections::BTreeMap;

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
    pub(super) file: String,
    /// Surfaces that are left out, by name.
    pub(super) defects: BTreeMap<String, Defect>,
    /// The one integer array of a VTU file.
    pub(super) array: Option<String>,
}

impl SolidMesh {
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

/// Why a group is no surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Defect {
    /// Faces between two solids.
    pub(super) interior: usize,
    /// Facets that are no faces of solids.
    pub(super) beside: usize,
    pub(super) count: usize,
}

impl Defect {
    pub(super) fn problem(&self) -> String {
        let Self {
            interior,
            beside,
            count,
        } = self;
        match interior {
            0 => format!("{beside} of its {count} faces belong to no solid"),
            _ => format!("{interior} of its {count} faces lie between two solids that share their nodes"),
        }
    }

    pub(super) fn error(&self, file: &str, group: &str) -> Error {
        Error::MeshGroup {
            file: file.to_owned(),
            group: group.to_owned(),
            problem: self.problem(),
            remedy: match self.interior {
                0 => "mesh the solid beside the surface and save it too, or ungroup the surface",
                _ => {
                    "an interface needs two faces: mesh the bodies with nodes of their own (in Gmsh do not fragment, leave \
                     Coherence out; else duplicate the nodes) and make a group of each face"
                }
            },
        }
    }
}
