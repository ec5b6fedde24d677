//! Assemblies of linear elements turned into quadratic ones.

use crate::Error;
use crate::constraints::{Tied, check_cloud};
use crate::elements::{Cell, ElementType, Face};
use crate::mesh::{Assembly, Coupling, CouplingKind, Dof, Element, Equation, Tie};
use nalgebra::Vector3;
use std::collections::{BTreeMap, HashMap, HashSet};

/// An assembly whose elements have a node in the middle of each edge.
///
/// | part | in quadratic elements |
/// |---|---|
/// | elements | of [`ElementType::quadratic`], in its default formulation; neighbours share the middles of their edges |
/// | nodes | corners keep their numbers; middles follow, in the order in which the elements name their edges |
/// | ties | faces gain their middles; a middle between two slaves is a slave |
/// | kinematic couplings, supports | a middle between two nodes that follow (or do not move) does so too |
/// | distributing couplings | on faces whose corners all belong to the cloud the weights move to the middles, as consistent forces do; other nodes keep theirs |
/// | springs, masses, loads, materials, shanks | unchanged: what acts on a node or a reference point acts on it still |
/// | cuts | middles between pairs of nodes are pairs |
/// | equations | unchanged if no node of an element is in them, otherwise refused |
#[derive(Clone, Debug, PartialEq)]
pub struct Quadratic {
    /// The assembly.
    pub assembly: Assembly,
    middles: Middles,
}

impl Quadratic {
    /// Raises the order of all elements. `position` is asked once for each edge, by the numbers of its two ends in increasing
    /// order, where its middle lies (m); `None` stands for the mean of the ends, after slaves were moved onto the faces
    /// they are tied to: what follows a slave by half keeps its edges straight.
    ///
    /// # Errors
    /// [`Error::NotLinear`], [`Error::NotRaisable`]; those of [`Mesh::validate`](crate::mesh::Mesh::validate), and ties and couplings whose
    /// nodes, distances or weights [`DofMap::try_new`](crate::constraints::DofMap::try_new) refuses.
    pub fn try_new(assembly: &Assembly, mut position: impl FnMut([u32; 2]) -> Option<[f64; 3]>) -> Result<Self, Error> {
        let mesh = &assembly.mesh;
        mesh.validate()?;
        let at = Tied::try_new(assembly)?.coordinates;
        let mut middles = Middles::default();
        let mut raised = assembly.clone();
        for (index, element) in mesh.elements.iter().enumerate() {
            let row = element.cell.element_type();
            let quadratic = row.quadratic().ok_or(Error::NotLinear {
                element: index,
                element_type: row.name,
            })?;
            let cell = middles.cell(&element.cell, quadratic, |edge| {
                let ends = edge.map(|node| at[node as usize]);
                let mean = [0, 1, 2].map(|c| 0.5 * (ends[0][c] + ends[1][c]));
                raised.mesh.nodes.push(position(edge).unwrap_or(mean));
                raised.mesh.nodes.len() as u32 - 1
            });
            raised.mesh.elements[index].cell = cell;
        }
        raised.mesh.validate()?;

        raised.ties = assembly
            .ties
            .iter()
            .map(|tie| middles.tie(tie))
            .collect::<Result<_, _>>()?;
        let mut outside = None;
        for coupling in &mut raised.couplings {
            check_cloud(coupling, &mesh.nodes)?;
            match &coupling.kind {
                CouplingKind::Kinematic(_) => coupling.nodes.extend(middles.between(&coupling.nodes)),
                CouplingKind::Distributing(weights) => {
                    let faces = outside.get_or_insert_with(|| by_least_corner(assembly.mesh.boundary()));
                    *coupling = middles.distributing(assembly, faces, coupling, weights);
                }
            }
        }
        for component in 0..3 {
            let supported = assembly.supports.iter().filter_map(|support| match *support {
                Dof::Node(node, c) if c == component => Some(node),
                _ => None,
            });
            let supported: Vec<u32> = supported.collect();
            let between = middles.between(&supported);
            raised.supports.extend(between.map(|node| Dof::Node(node, component)));
        }
        for (cut, of) in raised.cuts.iter_mut().zip(&assembly.cuts) {
            cut.pairs.extend(middles.of_pairs(&of.pairs));
        }
        refuse_nodes(&assembly.equations, &mesh.elements)?;
        Ok(Self {
            assembly: raised,
            middles,
        })
    }

    /// The node in the middle of the edge between two nodes, if an element has this edge.
    pub fn middle(&self, ends: [u32; 2]) -> Option<u32> {
        self.middles.find(ends)
    }
}

/// Where only the corners of elements fulfil an equation, their middles would be free.
fn refuse_nodes(equations: &[Equation], elements: &[Element]) -> Result<(), Error> {
    let corners: HashSet<u32> = elements
        .iter()
        .flat_map(|element| element.cell.nodes())
        .copied()
        .collect();
    let has_corner = |equation: &&Equation| {
        let mut terms = equation.terms.iter();
        terms.any(|(dof, _)| matches!(dof, Dof::Node(node, _) if corners.contains(node)))
    };
    equations.iter().find(has_corner).map_or(Ok(()), |equation| {
        Err(Error::NotRaisable {
            place: format!("equation `{}`", equation.name),
            reason: "it names nodes of elements, and does not say what the middles between them do; write the equations on the \
                     quadratic mesh",
        })
    })
}

impl ElementType {
    /// The type with the same corners and a node in the middle of each edge; `None` if this type is not linear.
    pub fn quadratic(&self) -> Option<&'static Self> {
        let is_quadratic = |row: &&Self| {
            let has_edges_alone = row.middles.iter().all(|between| between.len() == 2);
            !row.middles.is_empty() && has_edges_alone && row.nodes.starts_with(self.nodes)
        };
        let mut rows = super::elements::ELEMENT_TYPES.into_iter();
        rows.find(is_quadratic).filter(|_| self.middles.is_empty())
    }
}

/// Faces by the smallest number of their corners.
fn by_least_corner(faces: Vec<Face>) -> BTreeMap<u32, Vec<Face>> {
    let mut found: BTreeMap<u32, Vec<Face>> = BTreeMap::new();
    for face in faces {
        if let Some(&least) = face.corners().iter().min() {
            found.entry(least).or_default().push(face);
        }
    }
    found
}

/// The nodes in the middle of edges.
#[derive(Clone, Debug, Default, PartialEq)]
struct Middles {
    /// By the ends of the edge in increasing order.
    nodes: HashMap<[u32; 2], u32>,
    /// In the order of their numbers.
    edges: Vec<([u32; 2], u32)>,
}

impl Middles {
    fn find(&self, [a, b]: [u32; 2]) -> Option<u32> {
        self.nodes.get(&[a.min(b), a.max(b)]).copied()
    }

    /// The element of the type `quadratic` on the corners of `linear`; `add` makes the nodes that are missing.
    fn cell(&mut self, linear: &Cell, quadratic: &'static ElementType, mut add: impl FnMut([u32; 2]) -> u32) -> Cell {
        let corners = linear.nodes();
        let mut nodes = corners.to_vec();
        for between in quadratic.middles {
            let [a, b] = [between[0], between[1]].map(|local| corners[local]);
            let edge = [a.min(b), a.max(b)];
            nodes.push(*self.nodes.entry(edge).or_insert_with(|| {
                let node = add(edge);
                self.edges.push((edge, node));
                node
            }));
        }
        Cell::of_type(quadratic, &nodes)
    }

    /// Those between two of the given nodes.
    fn between(&self, nodes: &[u32]) -> impl Iterator<Item = u32> + use<> {
        let ends: HashSet<u32> = nodes.iter().copied().collect();
        let edges = self.edges.iter();
        let found = edges.filter(|(edge, _)| edge.iter().all(|end| ends.contains(end)));
        found.map(|(_, node)| *node).collect::<Vec<u32>>().into_iter()
    }

    /// Pairs in the middle between pairs.
    fn of_pairs(&self, pairs: &[[u32; 2]]) -> Vec<[u32; 2]> {
        let second: HashMap<u32, u32> = pairs.iter().map(|&[first, second]| (first, second)).collect();
        let pair = |(edge, node): &([u32; 2], u32)| {
            let across = edge.map(|end| second.get(&end).copied());
            let [Some(a), Some(b)] = across else { return None };
            Some([*node, self.find([a, b])?])
        };
        self.edges.iter().filter_map(pair).collect()
    }

    fn tie(&self, tie: &Tie) -> Result<Tie, Error> {
        let mut raised = tie.clone();
        raised.slave_nodes.extend(self.between(&tie.slave_nodes));
        for face in &mut raised.master_faces {
            *face = self.face(face).ok_or_else(|| Error::NotRaisable {
                place: format!("tie `{}`", tie.name),
                reason: "one of its faces is not bounded by edges of linear elements; give it faces of the mesh",
            })?;
        }
        Ok(raised)
    }

    fn face(&self, face: &Face) -> Option<Face> {
        if face.nodes() != face.corners() {
            return None;
        }
        let mut nodes = face.corners().to_vec();
        for edge in edges(face.corners()) {
            nodes.push(self.find(edge)?);
        }
        Face::from_nodes(&nodes)
    }

    /// A corner's weight is divided among its faces by their areas, and within each between the two edges that meet there. For
    /// weights that are areas this gives the areas of the quadratic faces ([`QUAD8`](crate::elements::QUAD8),
    /// [`TRI6`](crate::elements::TRI6)).
    fn distributing(
        &self,
        assembly: &Assembly,
        outside: &BTreeMap<u32, Vec<Face>>,
        coupling: &Coupling,
        weights: &[f64],
    ) -> Coupling {
        let mesh = &assembly.mesh;
        let mut of_node: BTreeMap<u32, f64> = BTreeMap::new();
        for (&node, weight) in coupling.nodes.iter().zip(weights) {
            *of_node.entry(node).or_default() += weight;
        }
        let mut faces: BTreeMap<Vec<u32>, &Face> = BTreeMap::new();
        for face in of_node.keys().filter_map(|node| outside.get(node)).flatten() {
            if face.corners().iter().all(|corner| of_node.contains_key(corner)) {
                let mut key = face.corners().to_vec();
                key.sort_unstable();
                faces.insert(key, face);
            }
        }
        let shares: Vec<(&Face, Vec<(usize, f64)>)> = faces
            .into_values()
            .map(|face| {
                let at = face
                    .corners()
                    .iter()
                    .map(|&node| Vector3::from(mesh.nodes[node as usize]));
                (face, (face.face_type().node_areas)(&at.collect::<Vec<_>>()))
            })
            .collect();
        let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
        for (face, shares) in &shares {
            for (local, share) in shares {
                *areas.entry(face.corners()[*local]).or_default() += share;
            }
        }
        areas.retain(|_, area| *area > 0.0);
        let mut raised: BTreeMap<u32, f64> = of_node.clone();
        raised.retain(|node, _| !areas.contains_key(node));
        for (face, shares) in &shares {
            let corners = face.corners();
            let ends: Vec<[u32; 2]> = edges(corners).collect();
            for &(local, share) in shares {
                let Some(area) = areas.get(&corners[local]) else {
                    continue;
                };
                let part = 0.5 * of_node[&corners[local]] * share / area;
                for edge in [ends[local], ends[(local + ends.len() - 1) % ends.len()]] {
                    if let Some(middle) = self.find(edge) {
                        *raised.entry(middle).or_default() += part;
                    }
                }
            }
        }
        Coupling {
            nodes: raised.keys().copied().collect(),
            kind: CouplingKind::Distributing(raised.into_values().collect()),
            ..coupling.clone()
        }
    }
}

/// The edges between neighbouring corners of a face, the first between the first two.
fn edges(corners: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]])
}
