//! Elements without stiffness of their own: facets and lines that preprocessors write beside solids.

use super::deck::{Label, Line};
use std::collections::{BTreeMap, HashMap};

/// Most nodes of a facet.
const MOST_NODES: usize = 9;

/// Prefixes of the types whose number of nodes follows: shells, membranes, plane, axisymmetric, surface and rigid elements.
const FACETS: [&str; 9] = ["CPS", "CPE", "CAX", "SFM3D", "M3D", "R3D", "STRI", "DS", "S"];

/// Trusses, beams and rigid lines, and their numbers of nodes.
const LINES: [(&str, usize); 13] = [
    ("T2D2", 2),
    ("T2D3", 3),
    ("T3D2", 2),
    ("T3D3", 3),
    ("B21", 2),
    ("B22", 3),
    ("B23", 2),
    ("B31", 2),
    ("B32", 3),
    ("B33", 2),
    ("RB2D2", 2),
    ("RB3D2", 2),
    ("R2D2", 2),
];

/// Elements of one or two nodes that are no geometry.
const CONNECTORS: [&str; 10] = [
    "MASS", "ROTARYI", "SPRING", "DASHPOT", "CONN", "GAP", "ITS", "DCOUP", "JOINTC", "DRAG",
];

/// Number of nodes, and of corners (none of lines), of the elements called `name` (in capitals), if they are facets or lines.
pub(super) fn shape(name: &str) -> Option<(usize, usize)> {
    if let Some((_, nodes)) = LINES.iter().find(|(known, _)| {
        name.strip_prefix(known)
            .is_some_and(|rest| rest.bytes().all(|c| c.is_ascii_alphabetic()))
    }) {
        return Some((*nodes, 0));
    }
    let rest = FACETS.iter().find_map(|prefix| {
        let rest = name.strip_prefix(prefix)?;
        rest.starts_with(|c: char| c.is_ascii_digit()).then_some(rest)
    })?;
    match rest.as_bytes() {
        [b'6', b'5', ..] if name == "STRI65" => Some((6, 3)),
        [b'3', ..] => Some((3, 3)),
        [b'4', ..] => Some((4, 4)),
        [b'6', ..] => Some((6, 3)),
        [b'8', ..] => Some((8, 4)),
        [b'9', ..] => Some((9, 4)),
        _ => None,
    }
}

/// Whether elements called `name` (in capitals) join nodes or load them with mass.
pub(super) fn is_connector(name: &str) -> bool {
    CONNECTORS.iter().any(|prefix| name.starts_with(prefix))
}

/// A facet, a line, or an element of which no nodes are kept.
#[derive(Clone, Copy)]
pub(super) struct Facet {
    nodes: [u32; MOST_NODES],
    n_nodes: u8,
    n_corners: u8,
    /// Where it is defined.
    pub(super) line: Line,
}

impl Facet {
    /// Of nodes, of which the first are corners; none if it is a line.
    pub(super) fn new(nodes: &[u32], n_corners: usize, line: Line) -> Self {
        let mut facet = Self {
            nodes: [0; MOST_NODES],
            n_nodes: 0,
            n_corners: n_corners as u8,
            line,
        };
        for (kept, node) in facet.nodes.iter_mut().zip(nodes) {
            *kept = *node;
            facet.n_nodes += 1;
        }
        facet
    }

    pub(super) fn nodes(&self) -> &[u32] {
        &self.nodes[..usize::from(self.n_nodes)]
    }

    /// The corners of a facet.
    pub(super) fn corners(&self) -> Option<&[u32]> {
        (self.n_corners > 0).then(|| &self.nodes[..usize::from(self.n_corners)])
    }
}

/// All of them.
#[derive(Default)]
pub(super) struct Facets {
    pub(super) all: Vec<Facet>,
    pub(super) index: HashMap<Label, u32>,
    /// By the name of the set.
    pub(super) sets: BTreeMap<String, Vec<u32>>,
    /// Those in surfaces, by the name of the surface.
    pub(super) surfaces: BTreeMap<String, Vec<u32>>,
    /// How many there are of each type.
    pub(super) types: BTreeMap<String, usize>,
}

impl Facets {
    /// How many there are of each type, and what becomes of them.
    pub(super) fn note(&self, fate: &str) -> Option<String> {
        let counts: Vec<String> = self
            .types
            .iter()
            .map(|(name, count)| format!("{count} of type {name}"))
            .collect();
        (!counts.is_empty()).then(|| format!("elements that are no solids {fate}: {}", counts.join(", ")))
    }

    /// Adds to a set.
    pub(super) fn add(&mut self, set: &str, members: Vec<u32>) {
        if !members.is_empty() {
            let set = self.sets.entry(set.to_owned()).or_default();
            set.extend(members);
        }
    }
}
