//! What the sections of a Gmsh file hold, and what is made of them.

use crate::elements::{ELEMENT_TYPES, ElementType, FACE_TYPES, Face, FaceType};
use crate::mesh::{Group, Mesh};
use std::collections::{BTreeMap, BTreeSet};

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// Solids. Its materials are those that were passed in, then the fallback if it was needed and is not among them.
    pub mesh: Mesh,
    /// Lists of faces, by ascending physical tag.
    pub faces: Vec<Group<Face>>,
    /// Lists of nodes, by dimension, then ascending physical tag; members ascend.
    pub nodes: Vec<Group<u32>>,
    /// Nodes that belong to no solid: they are dropped, since nothing would hold them.
    pub orphan_nodes: usize,
    /// Points, lines and faces that belong to no physical group.
    pub ignored_elements: usize,
    /// Sections that were not read.
    pub skipped_sections: BTreeSet<String>,
}

/// What elements of a type are to this crate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// Points or lines: only their nodes matter.
    Nodes {
        dimension: i32,
        n_nodes: usize,
    },
    Face(&'static FaceType),
    Solid(&'static ElementType),
}

/// Dimension and number of nodes.
pub(super) type Shape = (i32, usize);

/// Type, dimension and number of nodes of points and lines.
const POINTS_AND_LINES: [(i32, i32, usize); 6] = [(15, 0, 1), (1, 1, 2), (8, 1, 3), (26, 1, 4), (27, 1, 5), (28, 1, 6)];

impl Kind {
    /// The kind of an element type of Gmsh.
    pub(super) fn from_number(number: i32) -> Option<Self> {
        let solid = ELEMENT_TYPES
            .into_iter()
            .find(|row| i32::from(row.gmsh.number) == number);
        let face = FACE_TYPES.into_iter().find(|row| i32::from(row.gmsh) == number);
        let rest = POINTS_AND_LINES.into_iter().find(|(known, ..)| *known == number);
        let nodes = rest.map(|(_, dimension, n_nodes)| Self::Nodes { dimension, n_nodes });
        solid.map(Self::Solid).or(face.map(Self::Face)).or(nodes)
    }

    pub(super) fn dimension(self) -> i32 {
        match self {
            Self::Nodes { dimension, .. } => dimension,
            Self::Face(_) => 2,
            Self::Solid(_) => 3,
        }
    }

    /// What tells the kinds apart.
    pub(super) fn shape(self) -> Shape {
        (self.dimension(), self.n_nodes())
    }

    pub(super) fn n_nodes(self) -> usize {
        match self {
            Self::Nodes { n_nodes, .. } => n_nodes,
            Self::Face(row) => row.n_nodes,
            Self::Solid(row) => row.n_nodes(),
        }
    }
}

/// Elements of one type on one entity.
pub(super) struct Block {
    pub(super) at: usize,
    pub(super) kind: Kind,
    pub(super) entity: i32,
    /// Physical tags.
    pub(super) groups: BTreeSet<u32>,
    /// Tags of the elements.
    pub(super) tags: Vec<u64>,
    /// Nodes of all elements in Gmsh's order, zero based, element by element.
    pub(super) nodes: Vec<u32>,
}

/// The sections of a file.
#[derive(Default)]
pub(super) struct Parts {
    /// By dimension and physical tag.
    pub(super) names: BTreeMap<(i32, u32), String>,
    /// Physical tags by dimension and entity.
    pub(super) entities: BTreeMap<(i32, i32), BTreeSet<u32>>,
    pub(super) positions: Option<Vec<[f64; 3]>>,
    /// Tags of the nodes, ascending, with their numbers.
    pub(super) tags: Vec<(u64, u32)>,
    pub(super) blocks: Option<Vec<Block>>,
    pub(super) skipped: BTreeSet<String>,
}

impl Parts {
    /// Gives the elements the physical groups of their entities, as version 4.1 means it.
    pub(super) fn groups_of_entities(&mut self) {
        for block in self.blocks.iter_mut().flatten() {
            if let Some(groups) = self.entities.get(&(block.kind.dimension(), block.entity)) {
                block.groups.extend(groups);
            }
        }
    }
}
