#![doc = include_str!("../README.md")]

pub mod benchmark;
pub mod fit;
pub mod quadratic;
mod significant_digits;

pub use benchmark::{Benchmark, Benchmarks};
pub use significant_digits::significant;

use finite_elements::mesh::{Assembly, Face};
use fit::Fit;
use quadratic::RaisedElements;
use reduction::RelativeSystem;
use serde::{Deserialize, Serialize};
use sprs::CsMat;
use std::ops::Range;
use zte_assembly::{Covered, InterfaceMesh};

/// Two bodies with everything that connects and loads them, before contact, and the interface between them.
#[derive(Clone, Debug)]
pub struct Joint {
    /// The bodies.
    pub bodies: Bodies,
    /// The interface in its plane (m).
    pub interface: InterfaceMesh,
    /// Unit vectors of the relative coordinates as rows: two in the interface, and the normal from the top body into the
    /// bottom one; the mean ones where the interface is curved.
    pub frame: [[f64; 3]; 3],
    /// The same at each interface node, where the interface is curved or consists of parts in different planes; otherwise empty.
    pub node_frames: Vec<[[f64; 3]; 3]>,
    /// Parts of the interface, where a scene names several or one of them has a name; otherwise empty.
    pub parts: Vec<InterfacePart>,
    /// Position of each interface node in the coordinates of the model (m); none of matrices, whose nodes have no known place.
    pub positions: Option<Vec<[f64; 3]>>,
    /// By how much the bodies can slide before a shank touches its hole (m), if it is known.
    pub clearance: Option<f64>,
    /// Where and in which direction amplitudes are measured, in words.
    pub response: String,
    /// How the geometry of a mesh fits what a scene says of it; empty where no mesh was read.
    pub fit: Fit,
}

/// What the bodies are made of.
#[derive(Clone, Debug)]
pub enum Bodies {
    /// Finite elements.
    Meshed(MeshedBodies),
    /// Matrices of another program.
    Imported(ImportedBodies),
}

/// Bodies of finite elements.
#[derive(Clone, Debug)]
pub struct MeshedBodies {
    /// One load pattern of unit tension per bolt.
    pub assembly: Assembly,
    /// The nodes on both sides of the interface.
    pub sides: Sides,
    /// Where amplitudes are measured.
    pub response_node: u32,
    /// Direction there.
    pub response_direction: [f64; 3],
    /// What drives it in analyses beside a force at the response, in the order of the scene's drivers.
    pub excitations: Vec<Excited>,
    /// Pairs of interface nodes that were moved; none where all nodes coincide in pairs.
    pub moved_pairs: Option<MovedPairs>,
    /// Linear elements that were made quadratic; none where the elements have the order that they were meshed in.
    pub raised: Option<RaisedElements>,
    /// Rigid motions that cost no energy when the interface sticks: six of a free structure, none of one that is clamped.
    pub rigid_motions: usize,
}

/// What drives bodies of finite elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Excited {
    /// A force at a node along a direction.
    Force {
        /// The node.
        node: u32,
        /// The direction.
        direction: [f64; 3],
    },
    /// All supports move along a direction.
    Base([f64; 3]),
}

/// What drives a structure that comes as matrices.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcitedRow {
    /// Of a force the displacement that it works on, as a row over the coordinates; of a moving base the momentum per velocity (kg).
    pub row: Vec<f64>,
    /// Of a moving base, the displacement at the response point when everything moves with it by one; none of a force.
    pub carried: Option<f64>,
}

/// A part of an interface: where two bodies touch. Parts lie side by side in the plane of the interface.
#[derive(Clone, Debug, PartialEq)]
pub struct InterfacePart {
    /// Its name.
    pub name: String,
    /// Number of the interface in the scene that it belongs to, from zero.
    pub source: usize,
    /// Its nodes in the interface mesh.
    pub nodes: Range<usize>,
    /// Its elements in the interface mesh.
    pub elements: Range<usize>,
    /// What was added to its own plane coordinates (m).
    pub offset: [f64; 2],
    /// Mean normal from the top body into the bottom one.
    pub normal: [f64; 3],
}

/// The nodes on both sides of an interface.
#[derive(Clone, Debug, PartialEq)]
pub enum Sides {
    /// Nodes that coincide, one of the top body and one of the bottom body for each interface node.
    Pairs {
        /// Of the top body.
        top: Vec<u32>,
        /// Of the bottom body.
        bottom: Vec<u32>,
    },
    /// Meshes that do not match, one part of the interface after another.
    Projected(Vec<ProjectedSide>),
}

/// Two sides of an interface, or of a part of it, whose meshes do not match.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectedSide {
    /// Nodes that carry the jump, one for each interface node.
    pub own: Vec<u32>,
    /// Whether they belong to the top body.
    pub own_is_top: bool,
    /// Their faces, outward.
    pub own_faces: Vec<Face>,
    /// Nodes of the other side.
    pub other: Vec<u32>,
    /// Their faces, outward.
    pub other_faces: Vec<Face>,
    /// Weights of the other nodes at each own node (own x other).
    pub projection: CsMat<f64>,
}

/// Pairs of interface nodes that did not coincide and were moved to their midpoints in the plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MovedPairs {
    /// How many.
    pub count: usize,
    /// Largest distance in the plane before (m); each node was moved by half of it at most.
    pub largest_distance: f64,
}

impl InterfacePart {
    /// Its mesh in its own plane coordinates, out of that of the whole interface.
    pub fn mesh(&self, whole: &InterfaceMesh) -> InterfaceMesh {
        let first = self.nodes.start as u32;
        let elements = whole.elements[self.elements.clone()].iter().map(|element| {
            let mut element = *element;
            element.nodes_mut().iter_mut().for_each(|node| *node -= first);
            element
        });
        let own = |x: &[f64; 2]| [x[0] - self.offset[0], x[1] - self.offset[1]];
        let covered = whole
            .covered
            .iter()
            .filter(|part| self.elements.contains(&part.element));
        InterfaceMesh {
            nodes: whole.nodes[self.nodes.clone()].iter().map(own).collect(),
            elements: elements.collect(),
            heights: match whole.heights.is_empty() {
                true => Vec::new(),
                false => whole.heights[self.nodes.clone()].to_vec(),
            },
            covered: covered
                .map(|part| Covered {
                    element: part.element - self.elements.start,
                    centroid: own(&part.centroid),
                    ..*part
                })
                .collect(),
        }
    }
}

impl MeshedBodies {
    /// Positions of the nodes that carry the jump (m), in the order of the interface nodes.
    pub fn interface_positions(&self) -> Vec<[f64; 3]> {
        let nodes = &self.assembly.mesh.nodes;
        let place = |&node: &u32| nodes[node as usize];
        match &self.sides {
            Sides::Pairs { top, .. } => top.iter().map(place).collect(),
            Sides::Projected(parts) => parts.iter().flat_map(|part| part.own.iter().map(place)).collect(),
        }
    }
}

impl Joint {
    /// Pairs of interface nodes that were moved.
    pub fn moved_pairs(&self) -> Option<MovedPairs> {
        match &self.bodies {
            Bodies::Meshed(bodies) => bodies.moved_pairs,
            Bodies::Imported(_) => None,
        }
    }

    /// Linear elements that were made quadratic.
    pub fn raised(&self) -> Option<RaisedElements> {
        match &self.bodies {
            Bodies::Meshed(bodies) => bodies.raised,
            Bodies::Imported(_) => None,
        }
    }
}

/// A structure over `[jump; rest]` in SI, with what the reduction needs besides.
#[derive(Clone, Debug)]
pub struct ImportedBodies {
    /// Matrices, and loads of unit tension.
    pub relative: RelativeSystem,
    /// Row of the response displacement.
    pub response: Vec<f64>,
    /// What drives it in analyses beside a force at the response, in the order of the scene's drivers.
    pub excitations: Vec<ExcitedRow>,
    /// Rows `d` of viscous dampers: the damping matrix is `sum d d^T` (d in sqrt(kg/s)).
    pub dampers: Vec<Vec<f64>>,
    /// Whether the coordinates came over the jump, so that a reduction has been made already and all are retained.
    pub is_reduced: bool,
    /// Zero-energy modes that the structure with a stuck interface should have.
    pub zero_energy_modes: usize,
    /// Mass (kg), if the coordinates show it.
    pub mass: Option<f64>,
}
