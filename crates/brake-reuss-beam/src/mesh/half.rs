//! Half of the beam, for motions that are symmetric about the plane `y = 0`.

use super::{BrakeReussBeam, Part};
use crate::{Error, Result};
use finite_elements::mesh::{Assembly, Cell, Coupling, Dof, Element as Solid, Equation, Face, Mesh, Tie};
use std::collections::BTreeMap;
use zte_assembly::InterfaceMesh;

/// Nodes this close to the plane lie on it, and images this close to where they should be are found, relative to the
/// beam's width.
const COINCIDENCE: f64 = 1e-9;

impl BrakeReussBeam {
    /// The half `y >= 0`, which moves as the whole beam does in motions that are symmetric about the plane `y = 0`, with
    /// the mass, the energies and the loads of the whole.
    ///
    /// Its elements stand for their mirror images too: their material is twice as stiff and as heavy. Those that the
    /// plane cuts, in the cores of the bolts, are kept as they are. Nodes beyond the plane, of such elements and of
    /// couplings, follow their images; nodes on the plane stay there. The interface mesh is that of the half, nodes on
    /// the plane having `y = 0` exactly; contact forces over it must count twice. The beam must be as [`super::build`] made
    /// it.
    ///
    /// # Errors
    /// [`Error::NotSymmetric`].
    pub fn half(&self) -> Result<Self> {
        let whole = Whole::new(self);
        let (kept, parts) = whole.kept();
        let mut needed = vec![false; whole.nodes.len()];
        let of_elements = kept.iter().flat_map(|element| element.cell.nodes());
        let of_couplings = self.assembly.couplings.iter().flat_map(|coupling| &coupling.nodes);
        for &node in of_elements.chain(of_couplings) {
            needed[node as usize] = true;
        }
        let images = whole.images(&needed)?;
        let mut nodes = Vec::new();
        let number: Vec<Option<u32>> = (whole.nodes.iter().zip(&needed))
            .map(|(&at, needed)| {
                needed.then(|| {
                    nodes.push(at);
                    nodes.len() as u32 - 1
                })
            })
            .collect();
        let number = Numbers {
            numbers: &number,
            whole: &whole,
        };

        let of_whole = &self.assembly;
        let ties = of_whole.ties.iter().map(|tie| whole.half_tie(tie, &number));
        let ties: Vec<Tie> = ties.collect::<Result<_>>()?;
        let couplings = of_whole.couplings.iter().map(|coupling| {
            Ok(Coupling {
                nodes: number.all(&coupling.nodes)?,
                ..coupling.clone()
            })
        });
        let slaves: Vec<u32> = ties.iter().flat_map(|tie| tie.slave_nodes.iter().copied()).collect();
        // The faces that slaves lie on keep them in the plane.
        let on_plane = (0..)
            .zip(&nodes)
            .filter(|(node, at)| at[1] == 0.0 && !slaves.contains(node));
        let supports = on_plane.map(|(node, _)| Dof::Node(node, 1)).collect();
        let mut equations = Vec::with_capacity(3 * images.len() + of_whole.equations.len());
        for (&node, &image) in &images {
            let (node, image) = (number.of(node)?, number.of(image)?);
            for (component, sign) in [(0, -1.0), (1, 1.0), (2, -1.0)] {
                equations.push(Equation {
                    name: format!("mirror image of node {image}"),
                    terms: vec![(Dof::Node(node, component), 1.0), (Dof::Node(image, component), sign)],
                });
            }
        }
        // Displacement across and the other two rotations of all references are zero.
        let vanishes = |(dof, _): &(Dof, f64)| matches!(dof, Dof::Reference(_, 1 | 3 | 5));
        let remaining = of_whole.equations.iter().filter(|e| !e.terms.iter().all(vanishes));
        equations.extend(remaining.cloned());

        let mut materials = of_whole.mesh.materials.clone();
        materials.extend(of_whole.mesh.materials.iter().map(|material| {
            let mut both = material.clone();
            both.name.push_str(", both halves");
            both.youngs_modulus *= 2.0;
            both.density *= 2.0;
            both
        }));
        let elements = kept.iter().map(|element| {
            let material = match whole.is_cut(element.cell.nodes()) {
                true => element.material,
                false => element.material + of_whole.mesh.materials.len() as u16,
            };
            let cell = number.cell(&element.cell)?;
            Ok(Solid { cell, material })
        });
        let assembly = Assembly {
            mesh: Mesh {
                elements: elements.collect::<Result<_>>()?,
                nodes,
                materials,
            },
            ties,
            couplings: couplings.collect::<Result<_>>()?,
            equations,
            supports,
            loads: of_whole.loads.clone(),
            ..Assembly::default()
        };
        let (interface, pairs) = whole.half_interface(&self.interface)?;
        let facing = |nodes: &[u32]| pairs.iter().map(|&pair| number.of(nodes[pair])).collect::<Result<_>>();
        Ok(Self {
            assembly,
            interface,
            top_nodes: facing(&self.top_nodes)?,
            bottom_nodes: facing(&self.bottom_nodes)?,
            frame: self.frame,
            response_node: number.of(self.response_node)?,
            response_direction: self.response_direction,
            parts,
        })
    }
}

/// The whole beam, its nodes near the plane moved onto it.
struct Whole<'a> {
    beam: &'a BrakeReussBeam,
    nodes: Vec<[f64; 3]>,
    reach: f64,
}

impl<'a> Whole<'a> {
    fn new(beam: &'a BrakeReussBeam) -> Self {
        let given = &beam.assembly.mesh.nodes;
        let reach = COINCIDENCE * given.iter().fold(0.0, |most, at| f64::max(most, at[1].abs()));
        let nodes = given.iter().map(|&[x, y, z]| [x, onto_plane(y, reach), z]).collect();
        Self { beam, nodes, reach }
    }

    fn y(&self, node: u32) -> f64 {
        self.nodes[node as usize][1]
    }

    fn is_in_half(&self, nodes: &[u32]) -> bool {
        nodes.iter().all(|&node| self.y(node) >= 0.0)
    }

    fn is_cut(&self, nodes: &[u32]) -> bool {
        !self.is_in_half(nodes) && nodes.iter().any(|&node| self.y(node) > 0.0)
    }

    /// Elements that are not wholly beyond the plane, and the parts that they form.
    fn kept(&self) -> (Vec<Solid>, Vec<Part>) {
        let mut kept = Vec::new();
        let parts = self.beam.parts.iter().map(|part| {
            let first = kept.len();
            let elements = &self.beam.assembly.mesh.elements[part.elements.clone()];
            let near = |element: &&Solid| element.cell.nodes().iter().any(|&node| self.y(node) > 0.0);
            kept.extend(elements.iter().filter(near));
            Part {
                name: part.name.clone(),
                elements: first..kept.len(),
            }
        });
        let parts = parts.collect();
        (kept, parts)
    }

    /// The mirror images of those of some nodes that are beyond the plane. They are looked for in the same part: nodes of
    /// different parts may coincide.
    fn images(&self, needed: &[bool]) -> Result<BTreeMap<u32, u32>> {
        let mut images = BTreeMap::new();
        for part in &self.beam.parts {
            let elements = &self.beam.assembly.mesh.elements[part.elements.clone()];
            let mut nodes: Vec<u32> = elements.iter().flat_map(|e| e.cell.nodes()).copied().collect();
            nodes.sort_unstable();
            nodes.dedup();
            let beyond = |node: &&u32| needed[**node as usize] && self.y(**node) < 0.0;
            for &node in nodes.iter().filter(beyond) {
                let [x, y, z] = self.nodes[node as usize];
                let is_image = |other: &&u32| {
                    let [a, b, c] = self.nodes[**other as usize];
                    (a - x).abs().max((b + y).abs()).max((c - z).abs()) <= self.reach
                };
                let image = nodes.iter().find(is_image);
                let image = *image.ok_or_else(|| self.not_symmetric(node))?;
                images.insert(node, image);
            }
        }
        Ok(images)
    }

    fn half_tie(&self, tie: &Tie, number: &Numbers<'_>) -> Result<Tie> {
        let slaves = tie.slave_nodes.iter().filter(|node| self.y(**node) >= 0.0);
        let faces = tie.master_faces.iter().filter(|face| self.is_in_half(face.nodes()));
        Ok(Tie {
            slave_nodes: slaves.map(|&node| number.of(node)).collect::<Result<_>>()?,
            master_faces: faces.map(|face| number.face(face)).collect::<Result<_>>()?,
            ..tie.clone()
        })
    }

    /// The half of the interface, and which of the nodes of the whole one it has.
    fn half_interface(&self, interface: &InterfaceMesh) -> Result<(InterfaceMesh, Vec<usize>)> {
        let mut mesh = InterfaceMesh::flat(Vec::new(), Vec::new());
        let mut pairs = Vec::new();
        let mut number = vec![None; interface.nodes.len()];
        for (pair, &[x, y]) in interface.nodes.iter().enumerate() {
            let y = onto_plane(y, self.reach);
            if y >= 0.0 {
                number[pair] = Some(pairs.len() as u32);
                pairs.push(pair);
                mesh.nodes.push([x, y]);
            }
        }
        let of = |node: u32| {
            let top = self.beam.top_nodes[node as usize];
            number[node as usize].ok_or_else(|| self.not_symmetric(top))
        };
        let is_near = |node: &u32| interface.nodes[*node as usize][1] > self.reach;
        for element in interface.elements.iter().filter(|e| e.nodes().iter().any(is_near)) {
            mesh.elements.push(element.try_map_nodes(of)?);
        }
        Ok((mesh, pairs))
    }

    fn not_symmetric(&self, node: u32) -> Error {
        Error::NotSymmetric {
            node,
            position: self.nodes[node as usize],
        }
    }
}

fn onto_plane(y: f64, reach: f64) -> f64 {
    if y.abs() <= reach { 0.0 } else { y }
}

/// Numbers of the nodes in the half.
struct Numbers<'a> {
    numbers: &'a [Option<u32>],
    whole: &'a Whole<'a>,
}

impl Numbers<'_> {
    fn of(&self, node: u32) -> Result<u32> {
        self.numbers[node as usize].ok_or_else(|| self.whole.not_symmetric(node))
    }

    fn all(&self, nodes: &[u32]) -> Result<Vec<u32>> {
        nodes.iter().map(|&node| self.of(node)).collect()
    }

    fn face(&self, face: &Face) -> Result<Face> {
        face.try_map_nodes(|node| self.of(node))
    }

    fn cell(&self, cell: &Cell) -> Result<Cell> {
        cell.try_map_nodes(|node| self.of(node))
    }
}
