//! Bolts as decks model them: beams, rigid bodies, inertia at nodes, and pretension sections.

use super::assembly::{Choices, Roles};
use super::deck::{
    Deck, DeckBeamSection, DeckCoupling, DeckCouplingKind, DeckInertia, DeckPretension, Label, Line, Members,
    PretensionOf,
};
use super::reader::{Point, Reader};
use super::text::{Block, Data, excerpt};
use crate::error::{DeckProblem, Error};
use crate::mesh::{Assembly, Coupling, CouplingKind, Cut, Dof, Face, Section, Shank};
use nalgebra::{Matrix3, Vector3};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Least cosine between the given direction of a pretension section and that of its beam.
const ALONG_BEAM: f64 = 0.999;

/// Least cosine between the given direction of a pretension section and the normal of its surface.
const ALONG_NORMAL: f64 = 0.7;

impl Reader<'_> {
    /// `*BEAM SECTION`: sizes, then the direction of the first local axis.
    pub(super) fn beam_section(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["ELSET", "MATERIAL", "SECTION"])?;
        block.required(self.source, "SECTION")?;
        let circle = block.choice(self.source, "SECTION", &["CIRC", "RECT"])? == "CIRC";
        let material = self.material_index(block)?;
        let Some(line) = block.data.first() else {
            let (what, name) = ("data of *BEAM SECTION", excerpt(block.required(self.source, "ELSET")?));
            return Err(self.error(block.at, DeckProblem::Empty { what, name }));
        };
        let texts = line.columns::<2>(self.source)?;
        let size = |text: &str| {
            let value = line.number(self.source, "size of the section", text)?;
            match value > 0.0 {
                true => Ok(value),
                false => Err(line.invalid(self.source, "size of the section", text, "positive (m)")),
            }
        };
        let shape = match (circle, texts) {
            (true, [radius, ""]) => Section::Circle(2.0 * size(radius)?),
            (true, [first, second]) => {
                let diameter = size(first)?;
                if size(second)? != diameter {
                    return Err(line.invalid(self.source, "diameters of the circle", line.text, "equal"));
                }
                Section::Circle(diameter)
            }
            (false, [first, second]) => Section::Rectangle([size(first)?, size(second)?]),
        };
        let first = match block.data.get(1) {
            Some(line) => self.vector(line, "direction of the first axis", line.columns::<3>(self.source)?)?,
            None => -Vector3::z(),
        };
        let beams = self.take_up(
            instance,
            block,
            Point::Beam,
            ["set of B31 or B32 elements", "B31 or B32 element"],
        )?;
        let section = DeckBeamSection {
            shape,
            material,
            first: first.into(),
        };
        for beam in beams {
            self.deck.beams[beam as usize].section = Some(section);
        }
        Ok(())
    }

    /// `*ROTARY INERTIA` of `ROTARYI` elements: I11, I22, I33, I12, I13, I23.
    pub(super) fn rotary_inertia(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["ELSET"])?;
        let [line] = block.data[..] else {
            return Err(self.error(
                block.at,
                DeckProblem::Count {
                    what: "data lines of *ROTARY INERTIA (I11, I22, I33, I12, I13, I23)".into(),
                    found: block.data.len(),
                    expected: 1,
                },
            ));
        };
        let mut values = [0.0; 6];
        for (value, text) in values.iter_mut().zip(line.columns::<6>(self.source)?) {
            *value = line.number(self.source, "inertia", text)?;
        }
        let [xx, yy, zz, xy, xz, yz] = values;
        let inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let principal = Matrix3::from_fn(|i, j| inertia[i][j]).symmetric_eigenvalues();
        if !(principal.min() >= -1e-9 * principal.amax() && principal.amax() > 0.0) {
            return Err(line.invalid(self.source, "inertia", line.text, "positive about all axes (kg m^2)"));
        }
        let names = ["set of ROTARYI elements", "ROTARYI element"];
        let nodes = self.take_up(instance, block, Point::RotaryInertia, names)?;
        self.deck.inertias.extend(nodes.into_iter().map(|node| DeckInertia {
            node,
            inertia,
            line: block.at,
        }));
        Ok(())
    }

    /// `*RIGID BODY`: all nodes of a set follow the reference node.
    pub(super) fn rigid_body(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["REFNODE", "NSET", "TIENSET", "ELSET"])?;
        let reference = self.reference(instance, block)?;
        let mut members: BTreeSet<u32> = BTreeSet::new();
        for parameter in ["NSET", "TIENSET"] {
            if let Some(text) = block.optional(parameter) {
                members.extend(self.node_list(instance, &Data { at: block.at, text }, text)?);
            }
        }
        if let Some(text) = block.optional("ELSET") {
            let (solids, facets) = self.element_list(instance, &Data { at: block.at, text }, text)?;
            for element in solids {
                members.extend(self.deck.elements[element as usize].cell.nodes());
            }
            // Rigid elements, whose nodes follow too.
            for facet in facets {
                members.extend(self.facets.all[facet as usize].nodes());
            }
        }
        members.remove(&reference);
        self.spend(members.len(), block.at)?;
        self.close(DeckCoupling {
            name: format!("rigid body of node {}", self.deck.node_name(reference)),
            reference,
            nodes: members.into_iter().map(|node| (node, 1.0)).collect(),
            kind: DeckCouplingKind::Kinematic([true; 3]),
            line: block.at,
        })
    }

    /// `*PRE-TENSION SECTION` of a beam or a surface.
    pub(super) fn pretension(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["SURFACE", "ELEMENT", "NODE"])?;
        let text = block.required(self.source, "NODE")?;
        let node = self.one_node(instance, &Data { at: block.at, text }, text)?;
        let through = match (block.optional("SURFACE"), block.optional("ELEMENT")) {
            (Some(name), None) => {
                let name = self.full_name(instance, name);
                match self.deck.surfaces.get(&name).map(|surface| &surface.members) {
                    Some(Members::Faces(_)) => PretensionOf::Surface(name),
                    _ => return Err(self.undefined(block.at, "surface of element faces", &name)),
                }
            }
            (None, Some(element)) => PretensionOf::Beam(self.one_beam(instance, block.at, element)?),
            (None, None) => {
                let keyword = block.keyword.clone();
                let parameter = "SURFACE or ELEMENT";
                return Err(self.error(block.at, DeckProblem::MissingParameter { keyword, parameter }));
            }
            (Some(_), Some(_)) => return Err(block.refuse(self.source, "ELEMENT", "give it or SURFACE, not both")),
        };
        let direction = match block.data.first() {
            Some(line) => {
                let given = self.vector(line, "direction", line.columns::<3>(self.source)?)?;
                let unit = given.try_normalize(0.0);
                let unit =
                    unit.ok_or_else(|| line.invalid(self.source, "direction", line.text, "different from zero"))?;
                Some(unit.into())
            }
            None => None,
        };
        self.deck.pretensions.push(DeckPretension {
            node,
            through,
            direction,
            line: block.at,
        });
        Ok(())
    }

    /// The number of the beam with this label, or of the only one in this set.
    fn one_beam(&self, instance: u32, at: Line, text: &str) -> Result<u32, Error> {
        let (scope, rest) = self.scope(instance, text);
        let label = rest.parse().ok().map(|number| Label {
            instance: scope,
            number,
        });
        let of_set = || match self.point_sets.get(&self.full_name(instance, text)).map(Vec::as_slice) {
            Some([label]) => Some(*label),
            _ => None,
        };
        match label.or_else(of_set).and_then(|label| self.points.get(&label)) {
            Some((Point::Beam, beam, _)) => Ok(*beam),
            _ => Err(self.undefined(at, "beam (B31, B32), or a set of one,", text)),
        }
    }
}

impl Deck {
    /// Makes beams shanks; returns the first shank of each.
    pub(super) fn add_beams(
        &self,
        roles: &mut Roles,
        choices: &Choices,
        assembly: &mut Assembly,
    ) -> Result<Vec<u32>, Error> {
        let mut firsts = Vec::with_capacity(self.beams.len());
        for beam in &self.beams {
            let name = self.name(beam.label);
            let Some(section) = beam.section else {
                return Err(self.error(beam.line, DeckProblem::NoSection { element: name }));
            };
            let material = match &choices.material {
                Some(material) => material.clone(),
                None => self.material(&self.materials[usize::from(section.material)])?,
            };
            firsts.push(assembly.shanks.len() as u32);
            for (part, pair) in (1..).zip(beam.nodes.windows(2)) {
                let at = [pair[0], pair[1]].map(|node| self.nodes[node as usize].at);
                let ends = [
                    self.beam_node(roles, assembly, pair[0], beam.line)?,
                    self.beam_node(roles, assembly, pair[1], beam.line)?,
                ];
                let along = Vector3::from(at[1]) - Vector3::from(at[0]);
                let transverse = match section.shape {
                    // All directions are alike.
                    Section::Circle(_) => Vector3::ith(along.iamin(), 1.0).into(),
                    Section::Rectangle(_) => section.first,
                };
                let name = match beam.nodes.len() {
                    2 => format!("beam {name}"),
                    _ => format!("beam {name}, part {part}"),
                };
                assembly
                    .shanks
                    .push(Shank::uniform(name, ends, at, section.shape, &material, transverse));
            }
        }
        Ok(firsts)
    }

    /// The coupling whose reference point a node of a beam is.
    fn beam_node(&self, roles: &mut Roles, assembly: &mut Assembly, node: u32, line: Line) -> Result<u32, Error> {
        if let Some((coupling, released)) = roles.references.get(&node) {
            if let Some(component) = (3..6_u8).find(|c| released[usize::from(*c) - 3]) {
                return Err(self.error(
                    line,
                    DeckProblem::NoSuchComponent {
                        node: self.node_name(node),
                        component: component + 1,
                        place: "*BEAM SECTION",
                        reason: "the coupling of this reference node leaves that rotation free",
                    },
                ));
            }
            return Ok(*coupling);
        }
        let name = format!("beam at node {}", self.node_name(node));
        let of_solid = roles.mesh[node as usize];
        if of_solid.is_some() {
            for component in 0..3 {
                self.follow(roles, node, component, &name, line)?;
            }
        }
        let coupling = assembly.couplings.len() as u32;
        assembly.couplings.push(Coupling {
            name,
            reference: self.nodes[node as usize].at,
            nodes: of_solid.into_iter().collect(),
            kind: CouplingKind::Kinematic([true; 3]),
        });
        roles.references.insert(node, (coupling, [false; 3]));
        Ok(coupling)
    }

    /// Gives beams and solids their pretension sections; the overlaps of all other beams are held. `labels` are those of the nodes of
    /// the mesh.
    pub(super) fn add_pretensions(
        &self,
        roles: &mut Roles,
        first_shanks: &[u32],
        assembly: &mut Assembly,
        labels: &mut Vec<Label>,
    ) -> Result<(), Error> {
        let mut free: BTreeMap<u32, Line> = BTreeMap::new();
        for pretension in &self.pretensions {
            let (node, line) = (pretension.node, pretension.line);
            let taken = roles.mesh[node as usize].is_some()
                || roles.references.contains_key(&node)
                || roles.pretensions.contains_key(&node);
            let invalid = |what, found, requirement| {
                Err(self.error(
                    line,
                    DeckProblem::Value {
                        what,
                        found,
                        requirement,
                    },
                ))
            };
            if taken {
                let requirement = "one that nothing else uses";
                return invalid("node of the pretension section", self.node_name(node), requirement);
            }
            let dof = match &pretension.through {
                PretensionOf::Beam(beam) => {
                    let nodes = &self.beams[*beam as usize].nodes;
                    let [a, b] = [nodes[0], nodes[1]].map(|n| Vector3::from(self.nodes[n as usize].at));
                    let along = (b - a).normalize();
                    if let Some(given) = pretension.direction
                        && !(Vector3::from(given).dot(&along) > ALONG_BEAM)
                    {
                        let requirement =
                            "that from the first to the second node of the beam; remove the line, or correct it";
                        return invalid("direction of the pretension section", format!("{given:?}"), requirement);
                    }
                    let shank = first_shanks[*beam as usize];
                    if let Some(first) = free.insert(shank, line) {
                        let (what, first) = ("pretension section of beam", self.place(first));
                        let name = self.name(self.beams[*beam as usize].label);
                        return Err(self.error(line, DeckProblem::Duplicate { what, name, first }));
                    }
                    Dof::Pretension(shank)
                }
                PretensionOf::Surface(name) => {
                    let cut = self.cut(roles, pretension, name, assembly, labels)?;
                    assembly.cuts.push(cut);
                    Dof::Pretension((assembly.shanks.len() + assembly.cuts.len()) as u32 - 1)
                }
            };
            roles.pretensions.insert(node, dof);
        }
        let held = (0..assembly.shanks.len() as u32).filter(|shank| !free.contains_key(shank));
        assembly.supports.extend(held.map(Dof::Pretension));
        Ok(())
    }

    /// Gives the elements behind a surface nodes of their own.
    fn cut(
        &self,
        roles: &Roles,
        pretension: &DeckPretension,
        surface: &str,
        assembly: &mut Assembly,
        labels: &mut Vec<Label>,
    ) -> Result<Cut, Error> {
        let invalid = |what, found, requirement| {
            self.error(
                pretension.line,
                DeckProblem::Value {
                    what,
                    found,
                    requirement,
                },
            )
        };
        let Some(Members::Faces(members)) = self.surfaces.get(surface).map(|surface| &surface.members) else {
            return Err(invalid("surface", surface.to_owned(), "made of element faces"));
        };
        let mesh = &mut assembly.mesh;
        let at = |nodes: &[[f64; 3]], node: u32| Vector3::from(nodes[node as usize]);
        let owners: BTreeSet<u32> = members.iter().map(|(element, _)| *element).collect();
        let faces: Vec<Face> = members
            .iter()
            .map(|&(element, face)| mesh.elements[element as usize].cell.face(usize::from(face)))
            .collect();
        let area = |face: &Face| {
            let x: Vec<_> = face.corners().iter().map(|&n| at(&mesh.nodes, n)).collect();
            let fan = (1..x.len() - 1).map(|i| (x[i] - x[0]).cross(&(x[i + 1] - x[0])));
            fan.sum::<Vector3<f64>>()
        };
        let section: BTreeSet<u32> = faces.iter().flat_map(Face::nodes).copied().collect();
        let mean = faces.iter().map(area).sum::<Vector3<f64>>().try_normalize(0.0);
        let mean = mean.ok_or_else(|| invalid("surface", surface.to_owned(), "open, not closed upon itself"))?;
        let normal = match pretension.direction.map(Vector3::from) {
            None => mean,
            Some(given) if given.dot(&mean) > ALONG_NORMAL => given,
            Some(given) => {
                let requirement = "about the normal of the surface that points away from its elements; reverse it, or remove the line";
                return Err(invalid(
                    "direction of the pretension section",
                    format!("{given:?}"),
                    requirement,
                ));
            }
        };
        let in_tie = |node: u32| {
            let mut faces = assembly.ties.iter().flat_map(|tie| &tie.master_faces);
            faces.any(|face| face.nodes().contains(&node))
        };
        let followers: BTreeSet<u32> = roles
            .followers
            .keys()
            .filter_map(|(n, _)| roles.mesh[*n as usize])
            .collect();
        if let Some(&node) = section.iter().find(|&&node| followers.contains(&node) || in_tie(node)) {
            let name = self.name(labels[node as usize]);
            let requirement = "in no tie, coupling or rigid body; move the section away from them";
            return Err(invalid("node of the pretension section", name, requirement));
        }
        let mut second: HashMap<u32, u32> = HashMap::new();
        let mut pairs = Vec::new();
        for (index, element) in (0_u32..).zip(&mut mesh.elements) {
            let nodes = element.cell.nodes();
            let shared: Vec<_> = nodes.iter().filter(|node| section.contains(node)).collect();
            if shared.is_empty() || owners.contains(&index) {
                continue;
            }
            let middle = |of: &mut dyn Iterator<Item = u32>, count: usize| {
                of.map(|node| at(&mesh.nodes, node)).sum::<Vector3<f64>>() / count as f64
            };
            let own = middle(&mut nodes.iter().copied(), nodes.len());
            let cut = middle(&mut shared.iter().map(|node| **node), shared.len());
            if (own - cut).dot(&normal) <= 0.0 {
                continue;
            }
            element.cell = element.cell.map_nodes(|node| {
                if !section.contains(&node) {
                    return node;
                }
                *second.entry(node).or_insert_with(|| {
                    mesh.nodes.push(mesh.nodes[node as usize]);
                    labels.push(labels[node as usize]);
                    pairs.push([node, mesh.nodes.len() as u32 - 1]);
                    mesh.nodes.len() as u32 - 1
                })
            });
        }
        if pairs.len() != section.len() {
            let requirement = "a whole section of the bolt with elements on both sides";
            return Err(invalid("surface", surface.to_owned(), requirement));
        }
        Ok(Cut {
            name: format!("pretension section at {}", self.place(pretension.line)),
            normal: normal.into(),
            pairs,
        })
    }
}
