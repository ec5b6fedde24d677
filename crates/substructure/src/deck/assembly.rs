//! From a deck to an assembly.

use super::{AtComponents, Deck, DeckCouplingKind, Ignored, Label, Line, LinkKind, Members, qualified};
use crate::elements::Formulation;
use crate::error::{DeckProblem, Error};
use crate::mesh::{
    Assembly, BeyondTolerance, Cell, Coupling, CouplingKind, Dof, Element, Equation, Face, GroundSpring, LoadPattern,
    Material, Tie,
};
use nalgebra::Vector3;
use std::collections::{BTreeMap, HashMap};

/// Position tolerance of ties relative to the typical element size, where nothing else is said.
const TIE_TOLERANCE: f64 = 0.05;

/// What may be chosen otherwise than the deck says.
#[derive(Clone, Debug, PartialEq)]
pub struct Choices {
    /// Formulation of all hexahedra; `None` for that of each element's type.
    pub formulation: Option<Formulation>,
    /// Material of all elements; `None` for those of the deck.
    pub material: Option<Material>,
    /// Position tolerance of all ties (m); `None` for the deck's, or 5 % of the typical element size.
    pub tie_tolerance: Option<f64>,
    /// What becomes of slaves beyond the tolerance.
    pub beyond: BeyondTolerance,
}

impl Default for Choices {
    /// Everything as the deck says, and slaves beyond the tolerance left free, as in Abaqus.
    fn default() -> Self {
        Self {
            formulation: None,
            material: None,
            tie_tolerance: None,
            beyond: BeyondTolerance::LeaveFree,
        }
    }
}

/// An assembly, and what the deck calls its parts.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckModel {
    /// The assembly. Nodes that no element uses are left out.
    pub assembly: Assembly,
    /// Components that each step supports; they are not part of the assembly.
    pub step_supports: Vec<(String, Vec<Dof>)>,
    /// As [`Deck::ignored`].
    pub ignored: Vec<Ignored>,
    /// What a user should know: nodes left out, tolerances used, and so on.
    pub notes: Vec<String>,
    instances: Vec<String>,
    labels: Vec<Label>,
    elements: Vec<Label>,
    nodes: HashMap<Label, u32>,
    node_sets: BTreeMap<String, Vec<u32>>,
    element_sets: BTreeMap<String, Vec<u32>>,
    surfaces: BTreeMap<String, Vec<Face>>,
    references: BTreeMap<String, u32>,
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
    map.get(&name.to_ascii_uppercase()).ok_or_else(|| {
        let mut known: Vec<&str> = map.keys().take(12).map(String::as_str).collect();
        match map.len() {
            0 => known.push("none"),
            1..=12 => {}
            _ => known.push("..."),
        }
        Error::NotInDeck {
            what,
            name: name.to_owned(),
            known: known.join(", "),
        }
    })
}

/// Indices of what a deck's nodes have become.
struct Roles {
    /// Node of the mesh.
    mesh: Vec<Option<u32>>,
    /// First coupling with this reference node, and its released rotations.
    references: BTreeMap<u32, (u32, [bool; 3])>,
    /// Which constraint each dependent component follows.
    followers: HashMap<(u32, u8), (String, Line)>,
}

impl Deck {
    /// Makes an assembly of the deck.
    ///
    /// Steps are not run: of each, the loads become load patterns (`step` or `step/case`) and the supports are listed
    /// in [`DeckModel::step_supports`].
    ///
    /// # Errors
    /// [`Error::Deck`] for elements without section, sections without complete material, nodes that follow two
    /// constraints, and components used that do not exist.
    pub fn assembly(&self, choices: &Choices) -> Result<DeckModel, Error> {
        let mut notes = self.notes.clone();
        let mut assembly = Assembly::default();
        let (mesh, labels) = self.mesh(choices, &mut assembly)?;
        if labels.len() < self.nodes.len() {
            let references: std::collections::BTreeSet<u32> = self.couplings.iter().map(|c| c.reference).collect();
            let unused =
                (0..self.nodes.len() as u32).filter(|&n| mesh[n as usize].is_none() && !references.contains(&n));
            match unused.count() {
                0 => {}
                count => notes.push(format!("{count} nodes belong to no element and are left out")),
            }
        }
        let mut roles = Roles {
            mesh,
            references: BTreeMap::new(),
            followers: HashMap::new(),
        };
        self.add_couplings(&mut roles, &mut assembly)?;
        self.add_links(&mut roles, &mut assembly)?;
        self.add_ties(&mut roles, choices, &mut assembly, &mut notes)?;
        for spring in &self.springs {
            let node = self.mesh_node(&roles, spring.node, spring.component, spring.line, "*SPRING")?;
            assembly.springs.push(GroundSpring {
                node,
                component: spring.component,
                stiffness: spring.stiffness,
            });
        }
        let mut rotations = 0;
        assembly.supports = self.dofs(&roles, &self.supports, &mut rotations)?;
        for equation in &self.equations {
            let mut terms = Vec::with_capacity(equation.terms.len());
            for &(node, component, coefficient) in &equation.terms {
                terms.push((
                    self.dof(&roles, node, component, equation.line, "*EQUATION")?,
                    coefficient,
                ));
            }
            let name = format!("equation at {}", self.place(equation.line));
            assembly.equations.push(Equation { name, terms });
        }
        let mut step_supports = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            step_supports.push((step.name.clone(), self.dofs(&roles, &step.supports, &mut rotations)?));
            for case in &step.cases {
                let name = match &case.name {
                    Some(case) => format!("{}/{case}", step.name),
                    None => step.name.clone(),
                };
                let mut terms = Vec::with_capacity(case.loads.len());
                for (&(node, component), &(value, line)) in &case.loads {
                    terms.push((self.dof(&roles, node, component, line, "*CLOAD")?, value));
                }
                assembly.loads.push(LoadPattern { name, terms });
            }
        }
        if rotations > 0 {
            notes.push(format!(
                "{rotations} supports of rotations stand at nodes of solids, which have none, and do nothing"
            ));
        }
        Ok(self.model(assembly, roles, labels, step_supports, notes))
    }

    fn model(
        &self,
        assembly: Assembly,
        roles: Roles,
        labels: Vec<Label>,
        step_supports: Vec<(String, Vec<Dof>)>,
        notes: Vec<String>,
    ) -> DeckModel {
        let in_mesh = |nodes: &[u32]| nodes.iter().filter_map(|&n| roles.mesh[n as usize]).collect();
        let mut references: BTreeMap<String, u32> = BTreeMap::new();
        for (name, set) in &self.node_sets {
            if let [node] = set[..]
                && let Some(&(coupling, _)) = roles.references.get(&node)
            {
                references.insert(name.clone(), coupling);
            }
        }
        for (&node, &(coupling, _)) in &roles.references {
            references.insert(self.node_name(node), coupling);
        }
        let mut surfaces = BTreeMap::new();
        for (name, surface) in &self.surfaces {
            if let Members::Faces(faces) = &surface.members {
                let faces = faces
                    .iter()
                    .map(|&(e, face)| assembly.mesh.elements[e as usize].cell.faces()[usize::from(face)]);
                surfaces.insert(name.clone(), faces.collect());
            }
        }
        DeckModel {
            step_supports,
            ignored: self.ignored.clone(),
            notes,
            instances: self.instances.clone(),
            nodes: labels.iter().enumerate().map(|(i, &label)| (label, i as u32)).collect(),
            labels,
            elements: self.elements.iter().map(|element| element.label).collect(),
            node_sets: self
                .node_sets
                .iter()
                .map(|(name, set)| (name.clone(), in_mesh(set)))
                .collect(),
            element_sets: self.element_sets.clone(),
            surfaces,
            references,
            assembly,
        }
    }

    /// Fills the mesh; returns the mesh node of each node, if any, and the labels of the mesh's nodes.
    fn mesh(&self, choices: &Choices, assembly: &mut Assembly) -> Result<(Vec<Option<u32>>, Vec<Label>), Error> {
        let mesh = &mut assembly.mesh;
        let mut used = vec![false; self.nodes.len()];
        let mut wanted: Vec<Option<Line>> = vec![None; self.materials.len()];
        for element in &self.elements {
            let Some(material) = element.material else {
                let element_name = self.name(element.label);
                return Err(self.error(element.line, DeckProblem::NoSection { element: element_name }));
            };
            wanted[usize::from(material)].get_or_insert(element.line);
            for &node in element.cell.nodes() {
                used[node as usize] = true;
            }
        }
        let mut materials = vec![0_u16; self.materials.len()];
        if let Some(material) = &choices.material {
            mesh.materials.push(material.clone());
        } else {
            for (i, material) in self.materials.iter().enumerate().filter(|(i, _)| wanted[*i].is_some()) {
                let missing = |keyword| {
                    let name = format!("{keyword} of material {}", material.name);
                    self.error(material.line, DeckProblem::Undefined { what: "constant", name })
                };
                let [youngs_modulus, poisson_ratio] = material.elastic.ok_or_else(|| missing("*ELASTIC"))?;
                materials[i] = mesh.materials.len() as u16;
                mesh.materials.push(Material {
                    name: material.name.clone(),
                    youngs_modulus,
                    poisson_ratio,
                    density: material.density.ok_or_else(|| missing("*DENSITY"))?,
                });
            }
        }
        let (mut index, mut labels) = (vec![None; used.len()], Vec::new());
        for (i, node) in self.nodes.iter().enumerate().filter(|(i, _)| used[*i]) {
            index[i] = Some(labels.len() as u32);
            labels.push(node.label);
            mesh.nodes.push(node.at);
        }
        // Every node of an element is used.
        let at = |node: u32| index[node as usize].unwrap_or_default();
        for element in &self.elements {
            let cell = match element.cell {
                Cell::Hex8(nodes, formulation) => Cell::Hex8(nodes.map(at), choices.formulation.unwrap_or(formulation)),
                Cell::Wedge6(nodes) => Cell::Wedge6(nodes.map(at)),
                Cell::Tet4(nodes) => Cell::Tet4(nodes.map(at)),
                Cell::Tet10(nodes) => Cell::Tet10(nodes.map(at)),
            };
            let material = materials[usize::from(element.material.unwrap_or_default())];
            mesh.elements.push(Element { cell, material });
        }
        Ok((index, labels))
    }

    /// Marks a component of a mesh node as dependent.
    fn follow(&self, roles: &mut Roles, node: u32, component: u8, name: &str, line: Line) -> Result<(), Error> {
        if let Some((first, first_line)) = roles.followers.get(&(node, component)) {
            return Err(self.error(
                line,
                DeckProblem::DependentTwice {
                    node: self.node_name(node),
                    component: component + 1,
                    first: format!("{first} at {}", self.place(*first_line)),
                    second: name.to_owned(),
                },
            ));
        }
        roles.followers.insert((node, component), (name.to_owned(), line));
        Ok(())
    }

    fn mesh_node(
        &self,
        roles: &Roles,
        node: u32,
        component: u8,
        line: Line,
        place: &'static str,
    ) -> Result<u32, Error> {
        roles.mesh[node as usize].ok_or_else(|| {
            self.error(
                line,
                DeckProblem::NoSuchComponent {
                    node: self.node_name(node),
                    component: component + 1,
                    place,
                    reason: "no element uses the node",
                },
            )
        })
    }

    /// The component of a node of the mesh or of a reference node.
    fn dof(&self, roles: &Roles, node: u32, component: u8, line: Line, place: &'static str) -> Result<Dof, Error> {
        let fail = |reason| {
            let problem = DeckProblem::NoSuchComponent {
                node: self.node_name(node),
                component: component + 1,
                place,
                reason,
            };
            Err(self.error(line, problem))
        };
        match (roles.references.get(&node), roles.mesh[node as usize]) {
            (Some((_, released)), _) if component >= 3 && released[usize::from(component) - 3] => {
                fail("the coupling of this reference node leaves that rotation free")
            }
            (Some(&(coupling, _)), _) => Ok(Dof::Reference(coupling, component)),
            (None, Some(_)) if component >= 3 => fail("nodes of solids have no rotations"),
            (None, Some(node)) => Ok(Dof::Node(node, component)),
            (None, None) => fail("no element uses the node and it is no coupling's reference"),
        }
    }

    /// Supported components; counts the rotations of solids among them, which do not exist.
    fn dofs(&self, roles: &Roles, supports: &AtComponents<Line>, rotations: &mut usize) -> Result<Vec<Dof>, Error> {
        let mut dofs = Vec::with_capacity(supports.len());
        for (&(node, component), &line) in supports {
            let reference = roles.references.get(&node);
            let absent = match reference {
                Some((_, released)) => component >= 3 && released[usize::from(component) - 3],
                None => component >= 3,
            };
            if absent {
                *rotations += 1;
                continue;
            }
            dofs.push(self.dof(roles, node, component, line, "*BOUNDARY")?);
        }
        Ok(dofs)
    }

    fn add_couplings(&self, roles: &mut Roles, assembly: &mut Assembly) -> Result<(), Error> {
        for (index, coupling) in self.couplings.iter().enumerate() {
            let reference = coupling.reference;
            if roles.mesh[reference as usize].is_some() {
                return Err(self.error(
                    coupling.line,
                    DeckProblem::Value {
                        what: "reference node",
                        found: self.node_name(reference),
                        requirement: "a node that no element uses",
                    },
                ));
            }
            let mut nodes = Vec::with_capacity(coupling.nodes.len());
            let mut seen = std::collections::HashSet::new();
            for &(node, _) in &coupling.nodes {
                nodes.push(self.mesh_node(roles, node, 0, coupling.line, "*COUPLING")?);
                if !seen.insert(node) {
                    let (name, line) = (self.node_name(node), coupling.line);
                    let first = self.place(line);
                    let what = "node of a coupling's cloud";
                    return Err(self.error(line, DeckProblem::Duplicate { what, name, first }));
                }
            }
            let (kind, released) = match coupling.kind {
                DeckCouplingKind::Distributing(released) => {
                    let weights = coupling.nodes.iter().map(|(_, weight)| *weight).collect();
                    (CouplingKind::Distributing(weights), released)
                }
                DeckCouplingKind::Kinematic(components) => {
                    let name = format!("coupling `{}`", coupling.name);
                    for &(node, _) in &coupling.nodes {
                        for component in (0..3).filter(|c| components[usize::from(*c)]) {
                            self.follow(roles, node, component, &name, coupling.line)?;
                        }
                    }
                    (CouplingKind::Kinematic(components), [false; 3])
                }
            };
            assembly.couplings.push(Coupling {
                name: coupling.name.clone(),
                reference: self.nodes[reference as usize].at,
                nodes,
                kind,
            });
            let index = index as u32;
            match roles.references.get_mut(&reference) {
                None => {
                    roles.references.insert(reference, (index, released));
                }
                // One reference node of several clouds: its motions are one.
                Some((first, known)) => {
                    for component in 0..6_u8 {
                        let rotation = usize::from(component).checked_sub(3);
                        if rotation.is_some_and(|r| released[r] || known[r]) {
                            return Err(self.error(
                                coupling.line,
                                DeckProblem::NoSuchComponent {
                                    node: self.node_name(reference),
                                    component: component + 1,
                                    place: "*COUPLING",
                                    reason: "a reference node of several couplings must be coupled in all motions",
                                },
                            ));
                        }
                        assembly.equations.push(Equation {
                            name: format!("shared reference node {}", self.node_name(reference)),
                            terms: vec![
                                (Dof::Reference(index, component), 1.0),
                                (Dof::Reference(*first, component), -1.0),
                            ],
                        });
                    }
                }
            }
        }
        Ok(())
    }

    /// Rigid links: beams between nodes of the mesh and a point that is no coupling's reference yet become a kinematic
    /// coupling of that point; all others become equations.
    fn add_links(&self, roles: &mut Roles, assembly: &mut Assembly) -> Result<(), Error> {
        let mut made: BTreeMap<u32, u32> = BTreeMap::new();
        for link in self.links.iter().filter(|link| link.kind == LinkKind::Beam) {
            let [slave, master] = link.nodes;
            let free = !roles.references.contains_key(&master) || made.contains_key(&master);
            let (Some(node), None, true) = (roles.mesh[slave as usize], roles.mesh[master as usize], free) else {
                continue;
            };
            let name = format!("*MPC beam to node {}", self.node_name(master));
            for component in 0..3 {
                self.follow(roles, slave, component, &name, link.line)?;
            }
            let index = *made.entry(master).or_insert_with(|| {
                assembly.couplings.push(Coupling {
                    name,
                    reference: self.nodes[master as usize].at,
                    nodes: Vec::new(),
                    kind: CouplingKind::Kinematic([true; 3]),
                });
                assembly.couplings.len() as u32 - 1
            });
            roles.references.insert(master, (index, [false; 3]));
            assembly.couplings[index as usize].nodes.push(node);
        }
        for link in &self.links {
            let [slave, master] = link.nodes;
            if link.kind == LinkKind::Beam && made.contains_key(&master) && roles.mesh[slave as usize].is_some() {
                continue;
            }
            self.link_equations(roles, assembly, link)?;
        }
        Ok(())
    }

    fn link_equations(&self, roles: &Roles, assembly: &mut Assembly, link: &super::Link) -> Result<(), Error> {
        let [slave, master] = link.nodes;
        let dof = |node, component| self.dof(roles, node, component, link.line, "*MPC");
        let [a, b] = [slave, master].map(|node| Vector3::from(self.nodes[node as usize].at));
        let arm = a - b;
        let rotates = [slave, master].map(|node| roles.references.contains_key(&node));
        let mut push = |terms| {
            assembly.equations.push(Equation {
                name: format!("*MPC at {}", self.place(link.line)),
                terms,
            });
        };
        if link.kind == LinkKind::Link {
            let direction = arm.try_normalize(0.0).ok_or_else(|| {
                self.error(
                    link.line,
                    DeckProblem::Value {
                        what: "linked nodes",
                        found: self.node_name(slave),
                        requirement: "at different positions",
                    },
                )
            })?;
            let mut terms = Vec::new();
            for component in (0..3_u8).filter(|c| direction[usize::from(*c)] != 0.0) {
                let along = direction[usize::from(component)];
                terms.push((dof(slave, component)?, along));
                terms.push((dof(master, component)?, -along));
            }
            push(terms);
            return Ok(());
        }
        let beam = link.kind == LinkKind::Beam;
        for component in 0..3_u8 {
            let mut terms = vec![(dof(slave, component)?, 1.0), (dof(master, component)?, -1.0)];
            // u_slave = u_master + theta x arm
            let rotation = -arm.cross_matrix();
            for axis in (0..3_u8).filter(|_| beam) {
                let coefficient = rotation[(usize::from(component), usize::from(axis))];
                if coefficient != 0.0 {
                    terms.push((dof(master, 3 + axis)?, -coefficient));
                }
            }
            push(terms);
        }
        let rotations = match link.kind {
            LinkKind::Beam | LinkKind::Tie => rotates == [true; 2],
            LinkKind::Pin | LinkKind::Link => false,
        };
        for component in (3..6).filter(|_| rotations) {
            push(vec![(dof(slave, component)?, 1.0), (dof(master, component)?, -1.0)]);
        }
        Ok(())
    }

    fn add_ties(
        &self,
        roles: &mut Roles,
        choices: &Choices,
        assembly: &mut Assembly,
        notes: &mut Vec<String>,
    ) -> Result<(), Error> {
        for tie in &self.ties {
            let [slaves, masters] = tie.surfaces.each_ref().map(|name| &self.surfaces[name].members);
            let slaves: Vec<u32> = match slaves {
                Members::Nodes(nodes) => nodes.iter().map(|(node, _)| *node).collect(),
                Members::Faces(faces) => {
                    let mut nodes: Vec<u32> = faces
                        .iter()
                        .flat_map(|&(e, face)| {
                            let face = self.elements[e as usize].cell.faces()[usize::from(face)];
                            face.nodes().to_vec()
                        })
                        .collect();
                    nodes.sort_unstable();
                    nodes.dedup();
                    nodes
                }
            };
            let mut slave_nodes = Vec::with_capacity(slaves.len());
            for node in slaves {
                slave_nodes.push(self.mesh_node(roles, node, 0, tie.line, "*TIE")?);
                for component in 0..3 {
                    self.follow(roles, node, component, &format!("tie `{}`", tie.name), tie.line)?;
                }
            }
            let elements = &assembly.mesh.elements;
            let master_faces: Vec<Face> = match masters {
                Members::Nodes(_) => Vec::new(),
                Members::Faces(faces) => faces
                    .iter()
                    .map(|&(e, face)| elements[e as usize].cell.faces()[usize::from(face)])
                    .collect(),
            };
            let position_tolerance = match choices.tie_tolerance.or(tie.tolerance) {
                Some(tolerance) => tolerance,
                None => {
                    let tolerance = TIE_TOLERANCE * mean_edge(&master_faces, &assembly.mesh.nodes);
                    notes.push(format!(
                        "tie `{}` at {} has no tolerance; slaves within {tolerance:.3e} m are tied (5 % of the mean \
                         edge of its master faces)",
                        tie.name,
                        self.place(tie.line)
                    ));
                    tolerance
                }
            };
            assembly.ties.push(Tie {
                name: tie.name.clone(),
                slave_nodes,
                master_faces,
                position_tolerance,
                beyond: choices.beyond,
                adjust: tie.adjust,
            });
        }
        Ok(())
    }
}

/// Mean length of the edges between the corners of faces (m); edges of two faces count twice.
fn mean_edge(faces: &[Face], nodes: &[[f64; 3]]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for face in faces {
        let corners = match face {
            Face::Tri6(nodes) => &nodes[..3],
            Face::Tri3(_) | Face::Quad4(_) => face.nodes(),
        };
        for (a, &node) in corners.iter().enumerate() {
            let next = corners[(a + 1) % corners.len()];
            let [a, b] = [node, next].map(|n| Vector3::from(nodes[n as usize]));
            sum += (b - a).norm();
            count += 1.0;
        }
    }
    sum / count
}
