//! A deck while it is read, and how its names are resolved.

use super::deck::{Deck, DeckCoupling, Ignored, Label, Line, qualified};
use super::facets::Facets;
use super::keywords::Extent;
use super::text::{Block, Data, Source, excerpt};
use crate::error::{DeckProblem, Error};
use nalgebra::{Isometry3, Vector3};
use std::collections::{HashMap, HashSet};

/// Number of set members, copies and the like that any deck may hold, and how many more per byte.
const MEMBERS: [usize; 2] = [1_000_000, 16];

/// A deck while it is read.
pub(super) struct Reader<'a> {
    pub(super) source: &'a Source,
    pub(super) deck: Deck,
    pub(super) nodes: HashMap<Label, u32>,
    pub(super) elements: HashMap<Label, u32>,
    /// Numbers of the instances by their names in capitals; the model itself has none.
    instances: HashMap<String, u32>,
    /// Where each instance stands, and is defined.
    pub(super) frames: Vec<(Isometry3<f64>, Line)>,
    /// Elements that are no solids: label to node, and the line.
    pub(super) points: HashMap<Label, (Point, u32, Line)>,
    /// Those that a `*MASS`, a `*SPRING` or a coupling has taken up.
    pub(super) used_points: HashSet<Label>,
    /// Sets of those.
    pub(super) point_sets: HashMap<String, Vec<Label>>,
    /// Elements without stiffness, and their sets.
    pub(super) facets: Facets,
    /// What is read.
    pub(super) extent: Extent,
    /// Keywords that are not read of a mesh.
    pub(super) left_out: Vec<Ignored>,
    /// Node sets that keep the order of the deck, with their members.
    pub(super) unsorted: HashMap<String, HashSet<u32>>,
    /// A coupling whose kind is still to come.
    pub(super) open_coupling: Option<DeckCoupling>,
    pub(super) in_step: bool,
    /// Which load case of the step is open.
    pub(super) in_case: Option<usize>,
    pub(super) assembly: String,
    members: usize,
}

/// An element of one node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Point {
    Mass,
    Spring,
    Coupling,
    RotaryInertia,
    /// An element of several nodes: its number among [`Deck::beams`] is in the place of the node.
    Beam,
}

impl<'a> Reader<'a> {
    pub(super) fn new(source: &'a Source, extent: Extent) -> Self {
        Self {
            facets: Facets::default(),
            extent,
            left_out: Vec::new(),
            source,
            deck: Deck {
                files: source.files.clone(),
                instances: vec![String::new()],
                ..Deck::default()
            },
            nodes: HashMap::new(),
            elements: HashMap::new(),
            instances: HashMap::new(),
            frames: vec![(Isometry3::identity(), Line::default())],
            points: HashMap::new(),
            used_points: HashSet::new(),
            point_sets: HashMap::new(),
            unsorted: HashMap::new(),
            open_coupling: None,
            in_step: false,
            in_case: None,
            assembly: String::new(),
            members: 0,
        }
    }

    pub(super) fn vector(&self, line: &Data<'_>, what: &'static str, text: [&str; 3]) -> Result<Vector3<f64>, Error> {
        let mut vector = Vector3::zeros();
        for (value, text) in vector.iter_mut().zip(text) {
            *value = line.number(self.source, what, text)?;
        }
        Ok(vector)
    }

    /// Accounts for `count` members, so that short texts cannot fill the memory.
    pub(super) fn spend(&mut self, count: usize, at: Line) -> Result<(), Error> {
        let limit = MEMBERS[0] + MEMBERS[1] * self.source.size();
        self.members = self.members.saturating_add(count);
        if self.members > limit {
            return Err(self.error(at, DeckProblem::TooLarge { limit }));
        }
        Ok(())
    }

    pub(super) fn error(&self, at: Line, problem: DeckProblem) -> Error {
        self.source.error(at, problem)
    }

    pub(super) fn refused(&self, block: &Block<'_>, remedy: &'static str) -> Error {
        self.error(
            block.at,
            DeckProblem::Keyword {
                keyword: block.keyword.clone(),
                remedy,
            },
        )
    }

    pub(super) fn misplaced(&self, block: &Block<'_>) -> Error {
        self.refused(
            block,
            "blocks may not cross, and are closed in the order they were opened; move it",
        )
    }

    pub(super) fn unclosed(&self, line: Line, keyword: &str) -> Error {
        self.error(
            line,
            DeckProblem::Syntax {
                found: format!("*{keyword}"),
                reason: "the block is never closed by its *END line",
            },
        )
    }

    pub(super) fn duplicate(&self, at: Line, what: &'static str, name: String, first: Line) -> Error {
        let first = self.deck.place(first);
        self.error(at, DeckProblem::Duplicate { what, name, first })
    }

    /// Adds an instance, whose name is in capitals.
    pub(super) fn add_instance(&mut self, name: String, frame: Isometry3<f64>, at: Line) {
        self.instances.insert(name.clone(), self.deck.instances.len() as u32);
        self.deck.instances.push(name);
        self.frames.push((frame, at));
    }

    pub(super) fn instance_named(&self, name: &str) -> Option<u32> {
        self.instances.get(&name.to_ascii_uppercase()).copied()
    }

    /// Splits a label or set name of `instance` into an instance and the rest.
    pub(super) fn scope<'t>(&self, instance: u32, text: &'t str) -> (u32, &'t str) {
        let text = match (instance, text.split_once('.')) {
            (0, Some((first, rest))) if !self.assembly.is_empty() && first.eq_ignore_ascii_case(&self.assembly) => rest,
            _ => text,
        };
        if let (0, Some((first, rest))) = (instance, text.split_once('.'))
            && let Some(found) = self.instance_named(first)
        {
            return (found, rest);
        }
        (instance, text)
    }

    /// The qualified name of what `text` means in `instance`.
    pub(super) fn full_name(&self, instance: u32, text: &str) -> String {
        let (instance, rest) = self.scope(instance, text);
        qualified(&self.deck.instances[instance as usize], rest)
    }

    /// The instance of a block: the one it stands in, or its `INSTANCE` parameter.
    pub(super) fn instance_of(&self, instance: u32, block: &Block<'_>) -> Result<u32, Error> {
        let Some(name) = block.optional("INSTANCE") else {
            return Ok(instance);
        };
        self.instance_named(name).ok_or_else(|| {
            let (what, name) = ("instance", excerpt(name));
            self.error(block.at, DeckProblem::Undefined { what, name })
        })
    }

    /// The node with this label (or the nodes of this set), as `instance` names it.
    pub(super) fn node_list(&self, instance: u32, line: &Data<'_>, text: &str) -> Result<Vec<u32>, Error> {
        let (scope, rest) = self.scope(instance, text);
        if rest.starts_with(|c: char| c.is_ascii_digit()) && rest.bytes().all(|c| c.is_ascii_digit()) {
            let label = Label {
                instance: scope,
                number: line.label(self.source, "node", rest)?,
            };
            return Ok(vec![self.node(line.at, label)?]);
        }
        let name = self.full_name(instance, text);
        match self.deck.node_sets.get(&name) {
            Some(set) => Ok(set.clone()),
            None => Err(self.undefined(line.at, "node set", &name)),
        }
    }

    /// The one node that `text` names.
    pub(super) fn one_node(&self, instance: u32, line: &Data<'_>, text: &str) -> Result<u32, Error> {
        let nodes = self.node_list(instance, line, text)?;
        match nodes[..] {
            [node] => Ok(node),
            _ => Err(self.error(
                line.at,
                DeckProblem::Count {
                    what: format!("nodes of `{}`", excerpt(text)),
                    found: nodes.len(),
                    expected: 1,
                },
            )),
        }
    }

    pub(super) fn node(&self, at: Line, label: Label) -> Result<u32, Error> {
        let found = self.nodes.get(&label).copied();
        found.ok_or_else(|| self.undefined(at, "node", &self.deck.name(label)))
    }

    pub(super) fn undefined(&self, at: Line, what: &'static str, name: &str) -> Error {
        let name = excerpt(name);
        self.error(at, DeckProblem::Undefined { what, name })
    }
}

/// Counts a keyword that is not read.
pub(super) fn count(list: &mut Vec<Ignored>, block: &Block<'_>) {
    match list.iter_mut().find(|known| known.keyword == block.keyword) {
        Some(known) => known.count += 1,
        None => list.push(Ignored {
            keyword: block.keyword.clone(),
            count: 1,
            first_line: block.at,
        }),
    }
}
