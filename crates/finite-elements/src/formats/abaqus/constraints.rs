//! Ties, couplings, rigid links and equations.

use super::deck::{Deck, DeckCoupling, DeckCouplingKind, DeckEquation, DeckTie, Line, Link, LinkKind, Members};
use super::reader::{Point, Reader};
use super::text::{Block, Data, excerpt};
use crate::error::{DeckProblem, Error};
use nalgebra::Vector3;
use std::collections::BTreeMap;

impl Reader<'_> {
    pub(super) fn constraint(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        let sub = matches!(block.key.as_str(), "DISTRIBUTING" | "KINEMATIC");
        if !sub {
            self.close_coupling()?;
        }
        match block.key.as_str() {
            "TIE" => self.tie(instance, block),
            "COUPLING" => self.coupling(instance, block),
            "DISTRIBUTING" | "KINEMATIC" => self.coupling_kind(block),
            "DISTRIBUTINGCOUPLING" => self.distributing_elements(instance, block),
            "KINEMATICCOUPLING" => self.kinematic_nodes(instance, block),
            "MPC" => self.links(instance, block),
            "RIGIDBODY" => self.rigid_body(instance, block),
            "PRE-TENSIONSECTION" => self.pretension(instance, block),
            _ => self.equations(instance, block),
        }
    }

    fn tie(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        let known = [
            "NAME",
            "ADJUST",
            "POSITIONTOLERANCE",
            "TYPE",
            "NOROTATION",
            "NOTHICKNESS",
        ];
        block.allow(self.source, &known)?;
        let name = block.optional("NAME").unwrap_or("").to_owned();
        let adjust = block.choice(self.source, "ADJUST", &["YES", "NO"])? == "YES";
        block.choice(self.source, "TYPE", &["SURFACETOSURFACE", "NODETOSURFACE"])?;
        let tolerance = block.number(self.source, "POSITIONTOLERANCE")?;
        if tolerance.is_some_and(|tolerance| tolerance < 0.0) {
            return Err(block.refuse(self.source, "POSITIONTOLERANCE", "it must not be negative (m)"));
        }
        if block.data.is_empty() {
            return Err(self.error(block.at, DeckProblem::Empty { what: "tie", name }));
        }
        for line in &block.data {
            let surfaces = line.columns::<2>(self.source)?;
            let surfaces = surfaces.map(|text| self.full_name(instance, text));
            for name in &surfaces {
                if !self.deck.surfaces.contains_key(name) {
                    return Err(self.undefined(line.at, "surface", name));
                }
            }
            if let Members::Nodes(_) = self.deck.surfaces[&surfaces[1]].members {
                return Err(line.invalid(
                    self.source,
                    "master surface",
                    &surfaces[1],
                    "a surface of element faces; exchange the surfaces, or define it by faces",
                ));
            }
            self.deck.ties.push(DeckTie {
                name: name.clone(),
                surfaces,
                tolerance,
                adjust,
                line: line.at,
            });
        }
        Ok(())
    }

    fn coupling(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["CONSTRAINTNAME", "REFNODE", "SURFACE"])?;
        let reference = self.reference(instance, block)?;
        let surface = self.full_name(instance, block.required(self.source, "SURFACE")?);
        let Some(found) = self.deck.surfaces.get(&surface) else {
            return Err(self.undefined(block.at, "surface", &surface));
        };
        let nodes = match &found.members {
            Members::Nodes(nodes) => nodes.clone(),
            Members::Faces(faces) => tributary_areas(&self.deck, faces),
        };
        self.spend(nodes.len(), block.at)?;
        self.open_coupling = Some(DeckCoupling {
            name: block.optional("CONSTRAINTNAME").unwrap_or(&surface).to_owned(),
            reference,
            nodes,
            kind: DeckCouplingKind::Kinematic([false; 3]),
            line: block.at,
        });
        Ok(())
    }

    pub(super) fn reference(&self, instance: u32, block: &Block<'_>) -> Result<u32, Error> {
        let text = block.required(self.source, "REFNODE")?;
        self.one_node(instance, &Data { at: block.at, text }, text)
    }

    /// `*DISTRIBUTING` or `*KINEMATIC`.
    fn coupling_kind(&mut self, block: &Block<'_>) -> Result<(), Error> {
        let Some(mut coupling) = self.open_coupling.take() else {
            return Err(self.refused(block, "move it below its *COUPLING"));
        };
        let given = self.components(block)?;
        coupling.kind = if block.key == "DISTRIBUTING" {
            block.allow(self.source, &["WEIGHTINGMETHOD", "COUPLING", "ROTATIONALCOUPLING"])?;
            block.choice(self.source, "WEIGHTINGMETHOD", &["UNIFORM"])?;
            block.choice(self.source, "COUPLING", &["CONTINUUM", "STRUCTURAL"])?;
            block.choice(self.source, "ROTATIONALCOUPLING", &["STRUCTURAL", "CONTINUUM"])?;
            // Displacements are always coupled.
            DeckCouplingKind::Distributing([3, 4, 5].map(|component| !given[component]))
        } else {
            block.allow(self.source, &[])?;
            DeckCouplingKind::Kinematic([given[0], given[1], given[2]])
        };
        self.close(coupling)
    }

    /// Components 0..6 that the lines `first, last` name; all if there are none.
    fn components(&self, block: &Block<'_>) -> Result<[bool; 6], Error> {
        let mut given = [block.data.is_empty(); 6];
        for line in &block.data {
            let [first, last] = line.columns::<2>(self.source)?;
            if first.is_empty() {
                return Ok([true; 6]);
            }
            let (first, last) = self.component_range(line, first, last)?;
            for component in first..=last {
                given[usize::from(component)] = true;
            }
        }
        Ok(given)
    }

    /// Components from zero; `last` may be empty.
    pub(super) fn component_range(&self, line: &Data<'_>, first: &str, last: &str) -> Result<(u8, u8), Error> {
        let first = self.component(line, first)?;
        let last = match last {
            "" => first,
            text => self.component(line, text)?,
        };
        if last < first {
            return Err(line.invalid(
                self.source,
                "range of components",
                line.text,
                "`first, last` in ascending order",
            ));
        }
        Ok((first, last))
    }

    /// A component 1-6, counted from zero.
    pub(super) fn component(&self, line: &Data<'_>, text: &str) -> Result<u8, Error> {
        text.parse::<u8>()
            .ok()
            .filter(|component| (1..=6).contains(component))
            .map(|component| component - 1)
            .ok_or_else(|| {
                line.invalid(
                    self.source,
                    "component",
                    text,
                    "1 to 3 for displacements or 4 to 6 for rotations",
                )
            })
    }

    /// `*DISTRIBUTING COUPLING`: clouds of the `DCOUP3D` elements of a set.
    fn distributing_elements(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["ELSET"])?;
        let set = self.full_name(instance, block.required(self.source, "ELSET")?);
        let Some(labels) = self.point_sets.get(&set).cloned() else {
            return Err(self.undefined(block.at, "set of DCOUP3D elements", &set));
        };
        let mut nodes = Vec::new();
        for line in &block.data {
            let [of, weight] = line.columns::<2>(self.source)?;
            let weight = match weight {
                "" => 1.0,
                text => line.number(self.source, "weight", text)?,
            };
            let list = self.node_list(instance, line, of)?;
            self.spend(list.len() * labels.len(), line.at)?;
            nodes.extend(list.into_iter().map(|node| (node, weight)));
        }
        for label in labels {
            let reference = match self.points.get(&label) {
                Some((Point::Coupling, node, _)) => *node,
                _ => return Err(self.undefined(block.at, "DCOUP3D element", &self.deck.name(label))),
            };
            self.used_points.insert(label);
            self.close(DeckCoupling {
                name: set.clone(),
                reference,
                nodes: nodes.clone(),
                kind: DeckCouplingKind::Distributing([false; 3]),
                line: block.at,
            })?;
        }
        Ok(())
    }

    /// `*KINEMATIC COUPLING`: nodes with the components that follow.
    fn kinematic_nodes(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["REFNODE"])?;
        let reference = self.reference(instance, block)?;
        let mut by_components: BTreeMap<[bool; 3], Vec<(u32, f64)>> = BTreeMap::new();
        for line in &block.data {
            let [of, first, last] = line.columns::<3>(self.source)?;
            let mut given = [first.is_empty(); 3];
            if !first.is_empty() {
                let (first, last) = self.component_range(line, first, last)?;
                for component in first..=last.min(2) {
                    given[usize::from(component)] = true;
                }
            }
            let list = self.node_list(instance, line, of)?;
            self.spend(list.len(), line.at)?;
            let nodes = by_components.entry(given).or_default();
            nodes.extend(list.into_iter().map(|node| (node, 1.0)));
        }
        if by_components.is_empty() {
            let (what, name) = ("coupling of node", self.deck.node_name(reference));
            return Err(self.error(block.at, DeckProblem::Empty { what, name }));
        }
        for (components, nodes) in by_components {
            self.close(DeckCoupling {
                name: format!("kinematic coupling of node {}", self.deck.node_name(reference)),
                reference,
                nodes,
                kind: DeckCouplingKind::Kinematic(components),
                line: block.at,
            })?;
        }
        Ok(())
    }

    /// Checks a coupling and keeps it.
    pub(super) fn close(&mut self, coupling: DeckCoupling) -> Result<(), Error> {
        let name = excerpt(&coupling.name);
        if coupling.nodes.is_empty() || coupling.kind == DeckCouplingKind::Kinematic([false; 3]) {
            let what = "coupling";
            return Err(self.error(coupling.line, DeckProblem::Empty { what, name }));
        }
        if let Some((node, _)) = coupling.nodes.iter().find(|(_, weight)| !(*weight > 0.0)) {
            return Err(self.error(
                coupling.line,
                DeckProblem::Value {
                    what: "weight in a coupling",
                    found: format!("node {}", self.deck.node_name(*node)),
                    requirement: "positive",
                },
            ));
        }
        self.deck.couplings.push(coupling);
        Ok(())
    }

    pub(super) fn close_coupling(&mut self) -> Result<(), Error> {
        match self.open_coupling.take() {
            None => Ok(()),
            Some(coupling) => Err(self.error(
                coupling.line,
                DeckProblem::Syntax {
                    found: excerpt(&coupling.name),
                    reason: "neither *DISTRIBUTING nor *KINEMATIC follows *COUPLING",
                },
            )),
        }
    }

    fn links(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &[])?;
        for line in &block.data {
            let [kind, first, second] = line.columns::<3>(self.source)?;
            let kind = match kind.to_ascii_uppercase().as_str() {
                "BEAM" => LinkKind::Beam,
                "LINK" => LinkKind::Link,
                "PIN" => LinkKind::Pin,
                "TIE" => LinkKind::Tie,
                _ => {
                    let found = excerpt(kind);
                    return Err(self.error(line.at, DeckProblem::MpcType { found }));
                }
            };
            let slaves = self.node_list(instance, line, first)?;
            let masters = self.node_list(instance, line, second)?;
            self.spend(slaves.len(), line.at)?;
            if masters.len() != 1 && masters.len() != slaves.len() {
                return Err(self.error(
                    line.at,
                    DeckProblem::Count {
                        what: format!("nodes of `{}`", excerpt(second)),
                        found: masters.len(),
                        expected: slaves.len(),
                    },
                ));
            }
            for (i, &slave) in slaves.iter().enumerate() {
                let master = masters[if masters.len() == 1 { 0 } else { i }];
                if slave == master {
                    let node = self.deck.node_name(slave);
                    return Err(line.invalid(self.source, "linked nodes", &node, "two different nodes"));
                }
                self.deck.links.push(Link {
                    kind,
                    nodes: [slave, master],
                    line: line.at,
                });
            }
        }
        Ok(())
    }

    fn equations(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &[])?;
        let mut lines = block.data.iter();
        while let Some(header) = lines.next() {
            let [text] = header.columns::<1>(self.source)?;
            let count = text.parse::<usize>().ok().filter(|count| *count > 0);
            let count = count
                .ok_or_else(|| header.invalid(self.source, "number of terms", text, "a whole number above zero"))?;
            let mut terms: Vec<(Vec<u32>, u8, f64)> = Vec::new();
            while terms.len() < count {
                let Some(line) = lines.next() else {
                    return Err(self.terms(header.at, terms.len(), count));
                };
                let mut entries = line.entries().peekable();
                while entries.peek().is_some_and(|entry| !entry.is_empty()) {
                    let [of, component, coefficient] = [(); 3].map(|()| entries.next().unwrap_or(""));
                    let nodes = self.node_list(instance, line, of)?;
                    let component = self.component(line, component)?;
                    let value = line.number(self.source, "coefficient", coefficient)?;
                    if value == 0.0 {
                        return Err(line.invalid(self.source, "coefficient", coefficient, "different from zero"));
                    }
                    self.spend(nodes.len(), line.at)?;
                    terms.push((nodes, component, value));
                }
            }
            if terms.len() > count {
                return Err(self.terms(header.at, terms.len(), count));
            }
            let size = terms.iter().map(|(nodes, ..)| nodes.len()).max().unwrap_or(0);
            if let Some((nodes, ..)) = terms.iter().find(|(nodes, ..)| nodes.len() != 1 && nodes.len() != size) {
                return Err(self.error(
                    header.at,
                    DeckProblem::Count {
                        what: "nodes of a set in an equation over sets".into(),
                        found: nodes.len(),
                        expected: size,
                    },
                ));
            }
            self.spend(size * terms.len(), header.at)?;
            for i in 0..size {
                let of_member = |(nodes, component, value): &(Vec<u32>, u8, f64)| {
                    (nodes[if nodes.len() == 1 { 0 } else { i }], *component, *value)
                };
                self.deck.equations.push(DeckEquation {
                    terms: terms.iter().map(of_member).collect(),
                    line: header.at,
                });
            }
        }
        Ok(())
    }

    fn terms(&self, at: Line, found: usize, expected: usize) -> Error {
        let what = "terms of an equation".into();
        self.error(at, DeckProblem::Count { what, found, expected })
    }
}

/// The nodes of faces, each once in order of appearance, with the area of the faces shared among them.
fn tributary_areas(deck: &Deck, faces: &[(u32, u8)]) -> Vec<(u32, f64)> {
    let mut areas: Vec<(u32, f64)> = Vec::new();
    let mut place: BTreeMap<u32, usize> = BTreeMap::new();
    for &(element, face) in faces {
        let face = deck.elements[element as usize].cell.face(usize::from(face));
        let x: Vec<Vector3<f64>> = face
            .nodes()
            .iter()
            .map(|&node| Vector3::from(deck.nodes[node as usize].at))
            .collect();
        for (local, area) in (face.face_type().node_areas)(&x) {
            let node = face.nodes()[local];
            let at = *place.entry(node).or_insert_with(|| {
                areas.push((node, 0.0));
                areas.len() - 1
            });
            areas[at].1 += area;
        }
    }
    areas
}
