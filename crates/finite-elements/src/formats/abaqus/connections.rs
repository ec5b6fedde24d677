//! Couplings, rigid links and ties of a deck in an assembly.

use super::assembly::{Choices, Roles};
use super::deck::{Deck, DeckCouplingKind, Link, LinkKind, Members};
use crate::error::{DeckProblem, Error};
use crate::mesh::{Assembly, Coupling, CouplingKind, Dof, Equation, Face, Tie};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Position tolerance of ties relative to the typical element size, where nothing else is said.
const TIE_TOLERANCE: f64 = 0.05;

impl Deck {
    pub(super) fn add_couplings(&self, roles: &mut Roles, assembly: &mut Assembly) -> Result<(), Error> {
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
    pub(super) fn add_links(&self, roles: &mut Roles, assembly: &mut Assembly) -> Result<(), Error> {
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

    fn link_equations(&self, roles: &Roles, assembly: &mut Assembly, link: &Link) -> Result<(), Error> {
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

    pub(super) fn add_ties(
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
                            let face = self.elements[e as usize].cell.face(usize::from(face));
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
                    .map(|&(e, face)| elements[e as usize].cell.face(usize::from(face)))
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
        let corners = face.corners();
        for (a, &node) in corners.iter().enumerate() {
            let next = corners[(a + 1) % corners.len()];
            let [a, b] = [node, next].map(|n| Vector3::from(nodes[n as usize]));
            sum += (b - a).norm();
            count += 1.0;
        }
    }
    sum / count
}
