//! From an assembly to a deck.

use crate::elements;
use crate::error::Error;
use crate::mesh::{Assembly, CouplingKind, Dof, Face, Group};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Write;

/// Labels on a line.
const PER_LINE: usize = 12;

/// Entries on a line of an element, its label included: the most that Abaqus reads.
const ENTRIES: usize = 16;

/// Writes an assembly as a deck for Abaqus or CalculiX, which [`super::parse`] reads back with the same coordinates.
///
/// Nodes and elements are numbered from one in the order of the mesh, reference points of couplings after the nodes.
/// Load patterns become steps. `surfaces` and `node_sets` are written under their names, for steps and scenes to refer to.
/// [`crate::mesh::BeyondTolerance`] has no keyword: both codes leave such slaves free.
///
/// # Errors
/// [`Error::NotWritable`] for shanks, cuts, rigid masses and superelements, elements without a name in decks ([`crate::elements::ElementType::formulations`]), faces that are no element's, components and nodes
/// that do not exist; [`Error::NotFinite`]; errors of [`crate::mesh::Mesh::validate`].
pub fn write(assembly: &Assembly, surfaces: &[Group<Face>], node_sets: &[Group<u32>]) -> Result<String, Error> {
    let mut deck = Writer {
        text: String::from("*HEADING\nLengths in m, forces in N, masses in kg\n"),
        assembly,
        faces: HashMap::new(),
    };
    assembly.mesh.validate()?;
    if let Some(shank) = assembly.shanks.first() {
        return refuse(format!("shank `{}`", shank.name), PRETENSION);
    }
    if let Some(cut) = assembly.cuts.first() {
        return refuse(
            format!("cut `{}`", cut.name),
            "write the deck of the uncut bolt, and add *PRE-TENSION SECTION to it",
        );
    }
    if !assembly.rigid_masses.is_empty() {
        return refuse(
            "rigid mass 0".to_owned(),
            "masses at reference points have no place in the written deck; put the mass at a node of the cloud",
        );
    }
    if let Some(body) = assembly.superelements.first() {
        return refuse(
            format!("superelement `{}`", body.name),
            "matrices have no place in the written deck; name the file of the superelement in the code that reads it",
        );
    }
    deck.nodes()?;
    deck.elements()?;
    deck.groups(surfaces, node_sets)?;
    deck.springs()?;
    deck.masses()?;
    deck.couplings()?;
    deck.ties()?;
    for equation in &assembly.equations {
        let place = format!("equation `{}`", equation.name);
        let _ = writeln!(deck.text, "*EQUATION\n{}", equation.terms.len());
        for &(dof, coefficient) in &equation.terms {
            let [node, component] = deck.dof(&place, dof)?;
            let coefficient = finite(&place, coefficient)?;
            let _ = writeln!(deck.text, "{node}, {component}, {coefficient:?}");
        }
    }
    if !assembly.supports.is_empty() {
        deck.text.push_str("*BOUNDARY\n");
        for &dof in &assembly.supports {
            let [node, component] = deck.dof("a support", dof)?;
            let _ = writeln!(deck.text, "{node}, {component}, {component}");
        }
    }
    deck.loads()?;
    Ok(deck.text)
}

/// Why shanks are not written.
const PRETENSION: &str = "an axial stiffness that is not that of a uniform section has no keyword that both codes share; model the \
                          bolt by solid elements to write a deck";

struct Writer<'a> {
    text: String,
    assembly: &'a Assembly,
    /// Element and number of its face, by ascending nodes; filled by the first that asks.
    faces: HashMap<Vec<u32>, (usize, usize)>,
}

fn finite(place: &str, value: f64) -> Result<f64, Error> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(Error::NotFinite {
        place: place.to_owned(),
        value,
    })
}

fn refuse<T>(place: String, reason: &'static str) -> Result<T, Error> {
    Err(Error::NotWritable { place, reason })
}

/// Names as decks can hold them, all different without regard to case.
fn names<'n>(of: impl Iterator<Item = &'n String>) -> Vec<String> {
    let mut known = HashSet::new();
    of.map(|name| {
        let clean: String = name
            .chars()
            .map(|c| match c {
                '"' | ',' | '=' => '_',
                c if c.is_control() => '_',
                c => c,
            })
            .collect();
        let clean = match clean.trim() {
            "" => "unnamed",
            text => text,
        };
        let mut candidate = clean.to_owned();
        let mut number = 1;
        while !known.insert(candidate.to_ascii_uppercase()) {
            number += 1;
            candidate = format!("{clean}-{number}");
        }
        candidate
    })
    .collect()
}

impl Writer<'_> {
    fn list(&mut self, labels: &[usize]) {
        for line in labels.chunks(PER_LINE) {
            let line: Vec<String> = line.iter().map(usize::to_string).collect();
            let _ = writeln!(self.text, "{},", line.join(", "));
        }
    }

    /// Label of a coupling's reference point.
    fn reference(&self, coupling: u32) -> u64 {
        self.assembly.mesh.nodes.len() as u64 + u64::from(coupling) + 1
    }

    /// Label and component, from one.
    fn dof(&self, place: &str, dof: Dof) -> Result<[u64; 2], Error> {
        let (label, component, exists) = match dof {
            Dof::Node(node, component) => {
                let exists = (node as usize) < self.assembly.mesh.nodes.len() && component < 3;
                (u64::from(node) + 1, component, exists)
            }
            Dof::Reference(coupling, component) => {
                let exists = (coupling as usize) < self.assembly.couplings.len() && component < 6;
                (self.reference(coupling), component, exists)
            }
            Dof::Pretension(_) => return refuse(place.to_owned(), PRETENSION),
        };
        match exists {
            true => Ok([label, u64::from(component) + 1]),
            false => refuse(place.to_owned(), "it uses a component that does not exist"),
        }
    }

    fn nodes(&mut self) -> Result<(), Error> {
        self.text.push_str("*NODE\n");
        let references = self.assembly.couplings.iter().map(|coupling| &coupling.reference);
        for (i, x) in self.assembly.mesh.nodes.iter().chain(references).enumerate() {
            for &x in x {
                finite("a reference point", x)?;
            }
            // The shortest digits that read back as the same number.
            let _ = writeln!(self.text, "{}, {:?}, {:?}, {:?}", i + 1, x[0], x[1], x[2]);
        }
        Ok(())
    }

    fn elements(&mut self) -> Result<(), Error> {
        let mesh = &self.assembly.mesh;
        let mut of_material = vec![Vec::new(); mesh.materials.len()];
        let mut previous = "";
        for (i, element) in mesh.elements.iter().enumerate() {
            let Some(kind) = elements::to_abaqus(element.cell.element_type(), element.cell.formulation()) else {
                return refuse(
                    format!("element {i}"),
                    "decks have no element type with its nodes and its formulation; choose another formulation, or write \
                     hexahedra of 20 nodes in place of those of 27",
                );
            };
            if kind != previous {
                let _ = writeln!(self.text, "*ELEMENT, TYPE={kind}");
                previous = kind;
            }
            let _ = write!(self.text, "{}", i + 1);
            for (entry, node) in (1..).zip(element.cell.nodes()) {
                let separator = if entry % ENTRIES == 0 { ",\n" } else { ", " };
                let _ = write!(self.text, "{separator}{}", node + 1);
            }
            self.text.push('\n');
            of_material[usize::from(element.material)].push(i + 1);
        }
        let materials = names(mesh.materials.iter().map(|material| &material.name));
        for ((material, name), elements) in mesh.materials.iter().zip(&materials).zip(&of_material) {
            let _ = writeln!(
                self.text,
                "*MATERIAL, NAME=\"{name}\"\n*DENSITY\n{:?}\n*ELASTIC\n{:?}, {:?}",
                material.density, material.youngs_modulus, material.poisson_ratio
            );
            if !elements.is_empty() {
                let _ = writeln!(self.text, "*ELSET, ELSET=\"made of {name}\"");
                self.list(elements);
                let _ = writeln!(
                    self.text,
                    "*SOLID SECTION, ELSET=\"made of {name}\", MATERIAL=\"{name}\""
                );
            }
        }
        Ok(())
    }

    fn springs(&mut self) -> Result<(), Error> {
        let first = self.assembly.mesh.elements.len() + 1;
        for (i, spring) in self.assembly.springs.iter().enumerate() {
            let place = format!("ground spring {i}");
            let [node, component] = self.dof(&place, Dof::Node(spring.node, spring.component))?;
            let stiffness = finite(&place, spring.stiffness)?;
            let _ = writeln!(
                self.text,
                "*ELEMENT, TYPE=SPRING1, ELSET=SPRING-{n}\n{}, {node}\n*SPRING, ELSET=SPRING-{n}\n{component}\n\
                 {stiffness:?}",
                first + i,
                n = i + 1,
            );
        }
        Ok(())
    }

    fn masses(&mut self) -> Result<(), Error> {
        let first = self.assembly.mesh.elements.len() + self.assembly.springs.len() + 1;
        for (i, point) in self.assembly.masses.iter().enumerate() {
            let place = format!("point mass {i}");
            let [node, _] = self.dof(&place, Dof::Node(point.node, 0))?;
            let mass = finite(&place, point.mass)?;
            let _ = writeln!(
                self.text,
                "*ELEMENT, TYPE=MASS, ELSET=MASS-{n}\n{}, {node}\n*MASS, ELSET=MASS-{n}\n{mass:?}",
                first + i,
                n = i + 1,
            );
        }
        Ok(())
    }

    fn couplings(&mut self) -> Result<(), Error> {
        let names = names(self.assembly.couplings.iter().map(|coupling| &coupling.name));
        for (i, (coupling, name)) in self.assembly.couplings.iter().zip(&names).enumerate() {
            let place = format!("coupling `{}`", coupling.name);
            let weights = match &coupling.kind {
                CouplingKind::Distributing(weights) => weights.clone(),
                CouplingKind::Kinematic(_) => vec![1.0; coupling.nodes.len()],
            };
            if weights.len() != coupling.nodes.len() {
                return refuse(place, "it needs one weight per node");
            }
            let _ = writeln!(self.text, "*SURFACE, TYPE=NODE, NAME=COUPLING-{}", i + 1);
            for (&node, &weight) in coupling.nodes.iter().zip(&weights) {
                let [node, _] = self.dof(&place, Dof::Node(node, 0))?;
                let weight = finite(&place, weight)?;
                let _ = writeln!(self.text, "{node}, {weight:?}");
            }
            let _ = writeln!(
                self.text,
                "*COUPLING, CONSTRAINT NAME=\"{name}\", REF NODE={}, SURFACE=COUPLING-{}",
                self.reference(i as u32),
                i + 1
            );
            match &coupling.kind {
                CouplingKind::Distributing(_) => self.text.push_str("*DISTRIBUTING\n"),
                CouplingKind::Kinematic(components) => {
                    self.text.push_str("*KINEMATIC\n");
                    for component in (0..3).filter(|&c| components[c]) {
                        let _ = writeln!(self.text, "{c}, {c}", c = component + 1);
                    }
                }
            }
        }
        Ok(())
    }

    fn ties(&mut self) -> Result<(), Error> {
        if self.assembly.ties.is_empty() {
            return Ok(());
        }
        let names = names(self.assembly.ties.iter().map(|tie| &tie.name));
        for (i, (tie, name)) in self.assembly.ties.iter().zip(&names).enumerate() {
            let place = format!("tie `{}`", tie.name);
            let i = i + 1;
            let _ = writeln!(self.text, "*SURFACE, TYPE=NODE, NAME=SLAVE-{i}");
            for &node in &tie.slave_nodes {
                let [node, _] = self.dof(&place, Dof::Node(node, 0))?;
                let _ = writeln!(self.text, "{node},");
            }
            self.surface(&place, &format!("MASTER-{i}"), &tie.master_faces)?;
            let adjust = if tie.adjust { "YES" } else { "NO" };
            let tolerance = finite(&place, tie.position_tolerance)?;
            let _ = writeln!(
                self.text,
                "*TIE, NAME=\"{name}\", POSITION TOLERANCE={tolerance:?}, ADJUST={adjust}\nSLAVE-{i}, MASTER-{i}"
            );
        }
        Ok(())
    }

    fn groups(&mut self, surfaces: &[Group<Face>], node_sets: &[Group<u32>]) -> Result<(), Error> {
        for (set, name) in node_sets.iter().zip(names(node_sets.iter().map(|set| &set.name))) {
            let place = format!("node set `{}`", set.name);
            let labels = set
                .members
                .iter()
                .map(|&node| Ok(self.dof(&place, Dof::Node(node, 0))?[0] as usize));
            let labels = labels.collect::<Result<Vec<_>, Error>>()?;
            let _ = writeln!(self.text, "*NSET, NSET=\"{name}\"");
            self.list(&labels);
        }
        for (surface, name) in surfaces.iter().zip(names(surfaces.iter().map(|surface| &surface.name))) {
            self.surface(
                &format!("surface `{}`", surface.name),
                &format!("\"{name}\""),
                &surface.members,
            )?;
        }
        Ok(())
    }

    fn surface(&mut self, place: &str, name: &str, faces: &[Face]) -> Result<(), Error> {
        if self.faces.is_empty() {
            for (i, element) in self.assembly.mesh.elements.iter().enumerate() {
                for (number, face) in element.cell.faces().enumerate() {
                    self.faces.entry(sorted(&face)).or_insert((i + 1, number + 1));
                }
            }
        }
        let _ = writeln!(self.text, "*SURFACE, TYPE=ELEMENT, NAME={name}");
        for face in faces {
            let Some((element, number)) = self.faces.get(&sorted(face)) else {
                return refuse(place.to_owned(), "one of its faces is no element's face");
            };
            let _ = writeln!(self.text, "{element}, S{number}");
        }
        Ok(())
    }

    fn loads(&mut self) -> Result<(), Error> {
        let names = names(self.assembly.loads.iter().map(|load| &load.name));
        for (load, name) in self.assembly.loads.iter().zip(&names) {
            let place = format!("load `{}`", load.name);
            let _ = writeln!(self.text, "*STEP, NAME=\"{name}\"\n*STATIC\n*CLOAD");
            // One line per component: what a second one does depends on the code that reads the deck.
            let mut terms: BTreeMap<[u64; 2], f64> = BTreeMap::new();
            for &(dof, value) in &load.terms {
                let at = self.dof(&place, dof)?;
                *terms.entry(at).or_insert(0.0) += finite(&place, value)?;
            }
            for ([node, component], value) in terms {
                let _ = writeln!(self.text, "{node}, {component}, {value:?}");
            }
            self.text.push_str("*END STEP\n");
        }
        Ok(())
    }
}

fn sorted(face: &Face) -> Vec<u32> {
    let mut nodes = face.nodes().to_vec();
    nodes.sort_unstable();
    nodes
}
