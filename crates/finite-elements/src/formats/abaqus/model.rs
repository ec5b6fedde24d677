//! The assembly of a deck with the deck's names for its parts.

use super::deck::{Ignored, Label, qualified};
use crate::error::{Error, known_names};
use crate::mesh::{Assembly, Dof, Face};
use std::collections::{BTreeMap, HashMap};

/// An assembly, and what the deck calls its parts.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckModel {
    /// The assembly. Nodes that no element uses are left out.
    pub assembly: Assembly,
    /// Components that each step supports; they are not part of the assembly.
    pub step_supports: Vec<(String, Vec<Dof>)>,
    /// As [`Deck::ignored`](super::Deck::ignored).
    pub ignored: Vec<Ignored>,
    /// What a user should know: nodes left out, tolerances used, and so on.
    pub notes: Vec<String>,
    pub(super) instances: Vec<String>,
    pub(super) labels: Vec<Label>,
    pub(super) elements: Vec<Label>,
    pub(super) nodes: HashMap<Label, u32>,
    pub(super) node_sets: BTreeMap<String, Vec<u32>>,
    pub(super) element_sets: BTreeMap<String, Vec<u32>>,
    pub(super) surfaces: BTreeMap<String, Vec<Face>>,
    pub(super) references: BTreeMap<String, u32>,
    pub(super) pretensions: BTreeMap<String, Dof>,
}

impl DeckModel {
    /// Index in the mesh of the node `12` or `INSTANCE.12`.
    ///
    /// # Errors
    /// [`Error::NotInDeck`] if there is no such node, or no element uses it.
    pub fn node(&self, label: &str) -> Result<u32, Error> {
        let (instance, number) = label.rsplit_once('.').unwrap_or(("", label));
        let instance = self.instances.iter().position(|i| i.eq_ignore_ascii_case(instance));
        let found = instance.zip(number.parse().ok()).and_then(|(instance, number)| {
            let instance = instance as u32;
            self.nodes.get(&Label { instance, number }).copied()
        });
        found.ok_or_else(|| Error::NotInDeck {
            what: "node",
            name: label.to_owned(),
            known: format!("{} nodes in elements", self.labels.len()),
        })
    }

    /// Name in the deck of a node of the mesh.
    ///
    /// # Panics
    /// If the mesh has no such node.
    pub fn node_name(&self, node: u32) -> String {
        self.text(self.labels[node as usize])
    }

    /// Name in the deck of an element of the mesh.
    ///
    /// # Panics
    /// If the mesh has no such element.
    pub fn element_name(&self, element: usize) -> String {
        self.text(self.elements[element])
    }

    fn text(&self, label: Label) -> String {
        qualified(&self.instances[label.instance as usize], &label.number.to_string())
    }

    /// The nodes of a set, as indices in the mesh; those that no element uses are left out.
    ///
    /// # Errors
    /// [`Error::NotInDeck`].
    pub fn node_set(&self, name: &str) -> Result<&[u32], Error> {
        look_up(&self.node_sets, "node set", name).map(Vec::as_slice)
    }

    /// The elements of a set, as indices in the mesh.
    ///
    /// # Errors
    /// [`Error::NotInDeck`].
    pub fn element_set(&self, name: &str) -> Result<&[u32], Error> {
        look_up(&self.element_sets, "element set", name).map(Vec::as_slice)
    }

    /// The faces of a surface.
    ///
    /// # Errors
    /// [`Error::NotInDeck`], also for surfaces of nodes.
    pub fn surface_faces(&self, name: &str) -> Result<&[Face], Error> {
        look_up(&self.surfaces, "surface of faces", name).map(Vec::as_slice)
    }

    /// The coupling of a reference node, given by its label or by a set that holds it alone. If several couplings share
    /// the node, this is the first of them.
    ///
    /// # Errors
    /// [`Error::NotInDeck`].
    pub fn reference(&self, name: &str) -> Result<u32, Error> {
        look_up(&self.references, "reference node", name).copied()
    }

    /// The overlap at the pretension section of a node, given by its label or by a set that holds it alone.
    ///
    /// # Errors
    /// [`Error::NotInDeck`].
    pub fn pretension(&self, name: &str) -> Result<Dof, Error> {
        look_up(&self.pretensions, "node of a pretension section", name).copied()
    }

    /// Index in [`Assembly::loads`] of the loads of `step` or `step/case`.
    ///
    /// # Errors
    /// [`Error::NotInDeck`].
    pub fn load(&self, name: &str) -> Result<usize, Error> {
        let loads = &self.assembly.loads;
        let known: BTreeMap<String, usize> = loads
            .iter()
            .enumerate()
            .map(|(i, load)| (load.name.to_ascii_uppercase(), i))
            .collect();
        look_up(&known, "loads of a step or case", name).copied()
    }
}

fn look_up<'m, T>(map: &'m BTreeMap<String, T>, what: &'static str, name: &str) -> Result<&'m T, Error> {
    map.get(&name.to_ascii_uppercase()).ok_or_else(|| Error::NotInDeck {
        what,
        name: name.to_owned(),
        known: known_names(map.keys().map(String::as_str)),
    })
}
