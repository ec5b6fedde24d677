//! From a deck to an assembly.

use super::deck::{AtComponents, Deck, DeckMaterial, Label, Line, Members};
use super::model::DeckModel;
use crate::elements::Formulation;
use crate::error::{DeckProblem, Error};
use crate::mesh::{
    Assembly, BeyondTolerance, Dof, Element, Equation, GroundSpring, LoadPattern, Material, PointMass, RigidMass,
};
use std::collections::{BTreeMap, BTreeSet, HashMap};

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

/// Indices of what a deck's nodes have become.
pub(super) struct Roles {
    /// Node of the mesh.
    pub(super) mesh: Vec<Option<u32>>,
    /// First coupling with this reference node, and its released rotations.
    pub(super) references: BTreeMap<u32, (u32, [bool; 3])>,
    /// Overlaps at pretension sections, by their nodes.
    pub(super) pretensions: BTreeMap<u32, Dof>,
    /// Which constraint each dependent component follows.
    pub(super) followers: HashMap<(u32, u8), (String, Line)>,
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
        let (mesh, mut labels) = self.mesh(choices, &mut assembly)?;
        if labels.len() < self.nodes.len() {
            let mut references: BTreeSet<u32> = self.couplings.iter().map(|c| c.reference).collect();
            references.extend(self.beams.iter().flat_map(|beam| &beam.nodes));
            references.extend(self.pretensions.iter().map(|pretension| pretension.node));
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
            pretensions: BTreeMap::new(),
            followers: HashMap::new(),
        };
        self.add_couplings(&mut roles, &mut assembly)?;
        let first_shanks = self.add_beams(&mut roles, choices, &mut assembly)?;
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
        for point in &self.masses {
            match roles.references.get(&point.node) {
                Some(&(coupling, _)) => assembly.rigid_masses.push(RigidMass {
                    coupling,
                    mass: point.mass,
                    inertia: [[0.0; 3]; 3],
                }),
                None => assembly.masses.push(PointMass {
                    node: self.mesh_node(&roles, point.node, 0, point.line, "*MASS")?,
                    mass: point.mass,
                }),
            }
        }
        for point in &self.inertias {
            let coupling = match self.dof(&roles, point.node, 3, point.line, "*ROTARY INERTIA")? {
                Dof::Reference(coupling, _) => coupling,
                Dof::Node(..) | Dof::Pretension(_) => continue,
            };
            assembly.rigid_masses.push(RigidMass {
                coupling,
                mass: 0.0,
                inertia: point.inertia,
            });
        }
        self.add_pretensions(&mut roles, &first_shanks, &mut assembly, &mut labels)?;
        let mut rotations = 0;
        let supports = self.dofs(&roles, &self.supports, &mut rotations)?;
        assembly.supports.extend(supports);
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
        let mut pretensions: BTreeMap<String, Dof> = BTreeMap::new();
        for (name, set) in &self.node_sets {
            let [node] = set[..] else { continue };
            if let Some(&(coupling, _)) = roles.references.get(&node) {
                references.insert(name.clone(), coupling);
            }
            if let Some(&dof) = roles.pretensions.get(&node) {
                pretensions.insert(name.clone(), dof);
            }
        }
        for (&node, &dof) in &roles.pretensions {
            pretensions.insert(self.node_name(node), dof);
        }
        for (&node, &(coupling, _)) in &roles.references {
            references.insert(self.node_name(node), coupling);
        }
        let mut surfaces = BTreeMap::new();
        for (name, surface) in &self.surfaces {
            if let Members::Faces(faces) = &surface.members {
                let faces = faces
                    .iter()
                    .map(|&(e, face)| assembly.mesh.elements[e as usize].cell.face(usize::from(face)));
                surfaces.insert(name.clone(), faces.collect());
            }
        }
        DeckModel {
            step_supports,
            ignored: self.ignored.clone(),
            notes,
            instances: self.instances.clone(),
            // The first of those with one label: the others are behind a cut.
            nodes: labels
                .iter()
                .enumerate()
                .rev()
                .map(|(i, &label)| (label, i as u32))
                .collect(),
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
            pretensions,
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
                materials[i] = mesh.materials.len() as u16;
                mesh.materials.push(self.material(material)?);
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
            let mut cell = element.cell.map_nodes(at);
            if let Some(formulation) = choices.formulation {
                cell.set_formulation(formulation);
            }
            let material = materials[usize::from(element.material.unwrap_or_default())];
            mesh.elements.push(Element { cell, material });
        }
        Ok((index, labels))
    }

    /// A material with all constants that it needs.
    pub(super) fn material(&self, material: &DeckMaterial) -> Result<Material, Error> {
        let missing = |keyword| {
            let name = format!("{keyword} of material {}", material.name);
            self.error(material.line, DeckProblem::Undefined { what: "constant", name })
        };
        let [youngs_modulus, poisson_ratio] = material.elastic.ok_or_else(|| missing("*ELASTIC"))?;
        Ok(Material {
            name: material.name.clone(),
            youngs_modulus,
            poisson_ratio,
            density: material.density.ok_or_else(|| missing("*DENSITY"))?,
        })
    }

    /// Marks a component of a mesh node as dependent.
    pub(super) fn follow(
        &self,
        roles: &mut Roles,
        node: u32,
        component: u8,
        name: &str,
        line: Line,
    ) -> Result<(), Error> {
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

    pub(super) fn mesh_node(
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
    pub(super) fn dof(
        &self,
        roles: &Roles,
        node: u32,
        component: u8,
        line: Line,
        place: &'static str,
    ) -> Result<Dof, Error> {
        let fail = |reason| {
            let problem = DeckProblem::NoSuchComponent {
                node: self.node_name(node),
                component: component + 1,
                place,
                reason,
            };
            Err(self.error(line, problem))
        };
        if let Some(&overlap) = roles.pretensions.get(&node) {
            return match component {
                0 => Ok(overlap),
                _ => fail("the node of a pretension section has component 1 alone"),
            };
        }
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
            let absent = !roles.pretensions.contains_key(&node)
                && match reference {
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
}
