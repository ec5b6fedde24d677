//! Universal files (`.unv`) of I-DEAS, as Simcenter, Salome and Gmsh write them: the mesh and its groups.
//!
//! | dataset | read |
//! |---|---|
//! | 15, 2411 | nodes |
//! | 2412 | elements: solids; shells, membranes and plane elements as facets; others as groups of nodes |
//! | 2435, 2452, 2467, 2477 | groups of nodes and elements |
//! | 164 | units: a note says what they are |
//!
//! Elements with the number `N` of a physical property are the group `PROPERTY=N`. Other datasets are named in a note.
//!
//! Format: universal file datasets, published by the Structural Dynamics Research Laboratory of the University of Cincinnati.
//! Quadratic elements list their nodes along the edges of each level: corner, middle, corner.

use super::labelled::{GroupId, Labelled, Shape};
use super::lines::{Text, real};
use super::solid_mesh::SolidMesh;
use crate::Error;
use crate::elements::{ElementType, HEX8, HEX20, TET4, TET10, WEDGE6, WEDGE15};
use std::collections::{BTreeMap, BTreeSet};

/// Solids: descriptor, type, and for each of the crate's nodes its place in the file.
const SOLIDS: [(u64, &ElementType, &[usize]); 6] = [
    (111, &TET4, &[0, 1, 2, 3]),
    (112, &WEDGE6, &[0, 1, 2, 3, 4, 5]),
    (113, &WEDGE15, &[0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8]),
    (115, &HEX8, &[0, 1, 2, 3, 4, 5, 6, 7]),
    (
        116,
        &HEX20,
        &[0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11],
    ),
    (118, &TET10, &[0, 2, 4, 9, 1, 3, 5, 6, 7, 8]),
];

/// The solids, facets and groups of a file.
pub(super) fn solid_mesh(file: &str, bytes: &[u8]) -> Result<SolidMesh, Error> {
    let text = String::from_utf8_lossy(bytes);
    Reader {
        text: Text::new(file, &text),
        at: 0,
        mesh: Labelled::default(),
        systems: BTreeSet::new(),
        others: BTreeMap::new(),
    }
    .read()
}

struct Reader<'a> {
    text: Text<'a>,
    /// The next line, from zero.
    at: usize,
    mesh: Labelled,
    /// Coordinate systems of the positions of nodes.
    systems: BTreeSet<u64>,
    /// Datasets that are not read, and how many of each.
    others: BTreeMap<u64, usize>,
}

impl<'a> Reader<'a> {
    fn read(mut self) -> Result<SolidMesh, Error> {
        let mut ended = true;
        while self.at < self.text.lines.len() {
            let line = self.text.lines[self.at].trim();
            if line.is_empty() {
                self.at += 1;
                continue;
            }
            if line != "-1" {
                return Err(self.text.syntax(self.at, "a line with -1 before a dataset", line));
            }
            self.at += 1;
            let [number] = self.integers::<1>("the number of a dataset")?;
            match number {
                15 => self.nodes(1)?,
                2411 => self.nodes(2)?,
                2412 => self.elements()?,
                2435 | 2452 | 2467 | 2477 => self.groups()?,
                164 => self.units()?,
                _ => {
                    *self.others.entry(number).or_default() += 1;
                    while !self.is_end() {
                        self.at += 1;
                        if self.at >= self.text.lines.len() {
                            break;
                        }
                    }
                }
            }
            ended = self.is_end();
            if !ended {
                return Err(self.text.syntax(self.at, "a line with -1 after a dataset", self.line()));
            }
            self.at += 1;
        }
        if !ended {
            return Err(self.text.syntax(self.at, "a line with -1 after a dataset", ""));
        }
        if self.systems.len() > 1 {
            return Err(self.text.unsupported(
                self.at.saturating_sub(1),
                format!("nodes in {} coordinate systems", self.systems.len()),
                "save the positions of all nodes in the global system",
            ));
        }
        if !self.others.is_empty() {
            let names: Vec<String> = self.others.keys().map(u64::to_string).collect();
            self.mesh
                .notes
                .push(format!("the datasets {} are not read from a mesh", names.join(", ")));
        }
        let Self { text, mesh, at, .. } = self;
        let raw = mesh.finish(&|at, problem, remedy| text.contents(at, problem, remedy))?;
        if raw.cells.is_empty() {
            return Err(text.contents(
                at.saturating_sub(1) as u32,
                "the file holds no solids".into(),
                "mesh in three dimensions, and save elements of dataset 2412",
            ));
        }
        raw.finish(text.file)
    }

    fn line(&self) -> &'a str {
        self.text.lines.get(self.at).copied().unwrap_or("")
    }

    fn is_end(&self) -> bool {
        self.line().trim() == "-1"
    }

    /// The first whole numbers of the next line.
    fn integers<const N: usize>(&mut self, expected: &str) -> Result<[u64; N], Error> {
        let line = self.line();
        let mut words = line.split_ascii_whitespace();
        let mut values = [0; N];
        for value in &mut values {
            let word = words.next().and_then(|word| word.parse().ok());
            *value = word.ok_or_else(|| self.text.syntax(self.at, expected, line.trim()))?;
        }
        self.at += 1;
        Ok(values)
    }

    /// So many whole numbers from the next lines.
    fn many(&mut self, count: usize, expected: &str) -> Result<Vec<u64>, Error> {
        let mut values = Vec::new();
        while values.len() < count {
            let line = self.line();
            let before = values.len();
            for word in line.split_ascii_whitespace() {
                let value = word.parse();
                values.push(value.map_err(|_| self.text.syntax(self.at, expected, word))?);
            }
            if values.len() == before || values.len() > count {
                return Err(self.text.syntax(self.at, expected, line.trim()));
            }
            self.at += 1;
        }
        Ok(values)
    }

    fn nodes(&mut self, lines: usize) -> Result<(), Error> {
        while !self.is_end() {
            let at = self.at;
            let [label, system, _, _] = self.integers("number, two coordinate systems and colour of a node")?;
            self.systems.insert(system);
            self.at = at + lines - 1;
            let line = self.line();
            let skipped = if lines == 1 { 4 } else { 0 };
            let mut words = line.split_ascii_whitespace().skip(skipped);
            let mut position = [0.0; 3];
            for x in &mut position {
                let value = words.next().and_then(real);
                *x = value.ok_or_else(|| self.text.syntax(self.at, "three coordinates", line.trim()))?;
            }
            self.at += 1;
            let refuse = |at, problem, remedy| self.text.contents(at, problem, remedy);
            self.mesh.node(at as u32, label, position, &refuse)?;
        }
        Ok(())
    }

    fn elements(&mut self) -> Result<(), Error> {
        while !self.is_end() {
            let at = self.at;
            let [label, kind, property, _, _, count] =
                self.integers("number, type, property, material, colour and number of nodes of an element")?;
            // Rods and beams have a line of their cross-section.
            if matches!(kind, 11 | 21..=24) {
                self.at += 1;
            }
            if count > 27 {
                let found = count.to_string();
                return Err(self.text.syntax(at, "at most 27 nodes of an element", &found));
            }
            let mut nodes = self.many(count as usize, "as many nodes as the element has")?;
            let corners = match (kind, count) {
                (41..=95, 3 | 6) => Some((3, count / 3)),
                (41..=95, 4 | 8 | 9) => Some((4, count / 4)),
                _ => None,
            };
            let solid = SOLIDS.iter().find(|(known, ..)| *known == kind);
            let shape = match (solid, corners) {
                (Some((_, row, order)), _) if nodes.len() == order.len() => {
                    nodes = order.iter().map(|place| nodes[*place]).collect();
                    Shape::Solid(row)
                }
                (None, Some((corners, step))) => {
                    nodes = nodes.iter().copied().step_by(step as usize).take(corners).collect();
                    Shape::Facet(corners)
                }
                // Rods, beams, springs, masses and rigid elements.
                (None, None) if !(100..=118).contains(&kind) => Shape::Nodes,
                _ => {
                    return Err(self.text.unsupported(
                        at,
                        format!("element {label} of type {kind} with {count} nodes"),
                        "mesh solids as tetrahedra, wedges or hexahedra of first or second order (types 111, 112, 113, 115, 116 and 118)",
                    ));
                }
            };
            let group = self.mesh.group(format!("PROPERTY={property}"));
            self.mesh.element(at as u32, label, shape, &nodes, [Some(group), None]);
        }
        Ok(())
    }

    fn groups(&mut self) -> Result<(), Error> {
        while !self.is_end() {
            let [.., count] = self.integers::<8>("the eight numbers that begin a group")?;
            let name = self.line().trim().to_owned();
            if name.is_empty() {
                return Err(self.text.syntax(self.at, "the name of a group", ""));
            }
            self.at += 1;
            let group = self.mesh.group(name);
            self.members(group, count)?;
            // Salome writes an empty line for the members of an empty group.
            if count == 0 && self.line().trim().is_empty() && self.at < self.text.lines.len() {
                self.at += 1;
            }
        }
        Ok(())
    }

    fn members(&mut self, group: GroupId, count: u64) -> Result<(), Error> {
        let (mut nodes, mut elements, mut others) = (Vec::new(), Vec::new(), 0_usize);
        let mut left = count;
        while left > 0 {
            let here = left.min(2);
            let values = self.many(4 * here as usize, "four numbers for each member of a group")?;
            for member in values.chunks_exact(4) {
                match member[0] {
                    7 => nodes.push(member[1]),
                    8 => elements.push(member[1]),
                    _ => others += 1,
                }
            }
            left -= here;
        }
        if others > 0 {
            self.mesh.notes.push(format!(
                "{others} members of groups are neither nodes nor elements and are not read"
            ));
        }
        if !nodes.is_empty() {
            self.mesh.node_set(group, nodes);
        }
        if !elements.is_empty() {
            self.mesh.set(group, elements);
        }
        Ok(())
    }

    fn units(&mut self) -> Result<(), Error> {
        let line = self.line();
        let expected = "the code and the name of the units";
        // The code has ten columns; a name follows without a blank.
        let code = line.get(..10).map(str::trim).and_then(|code| code.parse::<u64>().ok());
        let name = match code {
            Some(1) => "metre, newton",
            Some(2) => "foot, pound force",
            Some(3) => "metre, kilogram force",
            Some(4) => "foot, poundal",
            Some(5) => "millimetre, millinewton",
            Some(6) => "centimetre, centinewton",
            Some(7) => "inch, pound force",
            Some(8) => "millimetre, kilogram force",
            Some(10) => "millimetre, newton",
            Some(_) => "of their own",
            None => return Err(self.text.syntax(self.at, expected, line.trim())),
        };
        self.mesh.notes.push(format!(
            "the file says that its units are {name}; those of the scene hold"
        ));
        while self.at < self.text.lines.len() && !self.is_end() {
            self.at += 1;
        }
        Ok(())
    }
}
