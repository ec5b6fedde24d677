//! What is reduced: two bodies, the interface between them, bolts and a response point.

use crate::Error;
use crate::matrices::{self, ImportedBodies};
use crate::scene::{self, MaterialSource, Symmetry, Untied};
use brake_reuss_beam::geometry::Geometry;
use brake_reuss_beam::mesh::{Refinement, build};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use substructure::deck::{self, Choices};
use substructure::elements::Formulation;
use substructure::mesh::{Assembly, BeyondTolerance, Dof, Face, LoadPattern, Material};
use zte_assembly::{Element, InterfaceMesh};

/// How far nodes that face one another may be apart, relative to the shortest edge of the interface.
const COINCIDENCE: f64 = 1e-3;

/// Least cosine between the normal of a face and the mean normal.
const FLATNESS: f64 = 0.99;

/// Two bodies with everything that connects and loads them, before contact, and the interface between them.
#[derive(Clone, Debug)]
pub struct Joint {
    /// The bodies.
    pub bodies: Bodies,
    /// The interface in its plane (m).
    pub interface: InterfaceMesh,
    /// Unit vectors of the relative coordinates as rows: two in the interface, and the normal from the top body into the
    /// bottom one.
    pub frame: [[f64; 3]; 3],
    /// By how much the bodies can slide before a shank touches its hole (m).
    pub clearance: Option<f64>,
}

/// What the bodies are made of.
#[derive(Clone, Debug)]
pub enum Bodies {
    /// Finite elements.
    Meshed(MeshedBodies),
    /// Matrices of another program.
    Imported(ImportedBodies),
}

/// Bodies of finite elements.
#[derive(Clone, Debug)]
pub struct MeshedBodies {
    /// One load pattern of unit tension per bolt.
    pub assembly: Assembly,
    /// Node of the top body for each interface node.
    pub top_nodes: Vec<u32>,
    /// Node of the bottom body for each interface node.
    pub bottom_nodes: Vec<u32>,
    /// Where amplitudes are measured.
    pub response_node: u32,
    /// Direction there.
    pub response_direction: [f64; 3],
}

impl Joint {
    /// The Brake-Reuss beam, or its half `y >= 0`.
    ///
    /// # Errors
    /// Of the mesher.
    pub fn beam(
        refinement: &Refinement,
        symmetry: Symmetry,
        material: &Material,
        hexahedra: Formulation,
    ) -> Result<Self, Error> {
        let geometry = Geometry::default();
        let mut beam = build(&geometry, refinement, material, 1.0)?;
        if symmetry == Symmetry::Half {
            beam = beam.half()?;
        }
        beam.assembly.mesh.set_formulation(hexahedra);
        Ok(Self {
            bodies: Bodies::Meshed(MeshedBodies {
                assembly: beam.assembly,
                top_nodes: beam.top_nodes,
                bottom_nodes: beam.bottom_nodes,
                response_node: beam.response_node,
                response_direction: beam.response_direction,
            }),
            interface: beam.interface,
            frame: beam.frame,
            clearance: Some(0.5 * (geometry.hole_diameter - geometry.shank_diameter)),
        })
    }

    /// A structure from matrices, in SI.
    ///
    /// # Errors
    /// Of the files; [`Error::Matrices`].
    pub fn from_matrices(source: &scene::Matrices, notes: &mut dyn FnMut(&str)) -> Result<Self, Error> {
        let imported = matrices::read(source, notes)?;
        Ok(Self {
            bodies: Bodies::Imported(imported.bodies),
            interface: imported.interface,
            frame: imported.frame,
            clearance: source.bolt_hole_clearance,
        })
    }

    /// A structure from an input deck, in SI.
    ///
    /// # Errors
    /// Of the deck; [`Error::Facing`].
    pub fn from_deck(
        source: &scene::Deck,
        material: &Material,
        formulation: Option<Formulation>,
        notes: &mut dyn FnMut(&str),
    ) -> Result<Self, Error> {
        let (length, mass) = source.units.map_or((1.0, 1.0), |u| (u.length_in_si(), u.mass_in_si()));
        let choices = Choices {
            formulation,
            tie_tolerance: source.tie_tolerance.map(|tolerance| tolerance / length),
            beyond: match source.untied {
                Untied::Refuse => BeyondTolerance::Refuse,
                Untied::Free => BeyondTolerance::LeaveFree,
            },
            ..Choices::default()
        };
        let deck = deck::read(&source.path)?.assembly(&choices)?;
        deck.notes.iter().for_each(|note| notes(note));
        let mut assembly = deck.assembly.clone();
        assembly.convert_units(length, mass);
        if source.materials == MaterialSource::Scene {
            assembly.mesh.materials.fill(material.clone());
        }
        let facing = Facing::try_new(
            &assembly.mesh.nodes,
            deck.surface_faces(&source.top_surface)?,
            deck.surface_faces(&source.bottom_surface)?,
            source.along,
            &|node| deck.node_name(node),
        )?;
        let normal = facing.frame[2];
        assembly.loads = source
            .bolts
            .iter()
            .map(|bolt| {
                let ends = [(deck.reference(&bolt.top)?, 1.0), (deck.reference(&bolt.bottom)?, -1.0)];
                let components = |(reference, sign)| {
                    (0..3_u8).map(move |c| (Dof::Reference(reference, c), sign * normal[usize::from(c)]))
                };
                Ok(LoadPattern {
                    name: format!("{} against {}", bolt.top, bolt.bottom),
                    terms: ends.into_iter().flat_map(components).collect(),
                })
            })
            .collect::<Result<_, Error>>()?;
        let response_node = match deck.node_set(&source.response.node) {
            Ok(&[node]) => node,
            Ok(nodes) => {
                return Err(Error::ResponseSet {
                    set: source.response.node.clone(),
                    count: nodes.len(),
                });
            }
            Err(_) => deck.node(&source.response.node)?,
        };
        Ok(Self {
            bodies: Bodies::Meshed(MeshedBodies {
                assembly,
                top_nodes: facing.top_nodes,
                bottom_nodes: facing.bottom_nodes,
                response_node,
                response_direction: source.response.direction,
            }),
            interface: facing.interface,
            frame: facing.frame,
            clearance: source.bolt_hole_clearance,
        })
    }
}

/// Two surfaces that lie upon one another, node by node.
#[derive(Debug)]
pub(crate) struct Facing {
    pub(crate) interface: InterfaceMesh,
    pub(crate) top_nodes: Vec<u32>,
    pub(crate) bottom_nodes: Vec<u32>,
    pub(crate) frame: [[f64; 3]; 3],
}

impl Facing {
    /// Pairs the nodes of two surfaces; the first axis of the frame is `along` as far as it lies in the plane. `label` names
    /// a node in messages.
    ///
    /// # Errors
    /// [`Error::Facing`] naming the node or face.
    pub(crate) fn try_new(
        coordinates: &[[f64; 3]],
        top: &[Face],
        bottom: &[Face],
        along: [f64; 3],
        label: &dyn Fn(u32) -> String,
    ) -> Result<Self, Error> {
        let fail = |reason: String| Err(Error::Facing { reason });
        let at = |node: u32| Vector3::from(coordinates[node as usize]);
        let mut normal = Vector3::zeros();
        let mut shortest = f64::INFINITY;
        for face in top {
            let nodes = face.nodes();
            if matches!(face, Face::Tri6(_)) {
                return fail(format!(
                    "the face at node {} is quadratic; interfaces take triangles with three nodes and quadrilaterals with four",
                    label(nodes[0])
                ));
            }
            normal += area_vector(face, coordinates);
            for (i, &node) in nodes.iter().enumerate() {
                shortest = shortest.min((at(nodes[(i + 1) % nodes.len()]) - at(node)).norm());
            }
        }
        let Some(normal) = normal.try_normalize(0.0) else {
            return fail("the top surface has no faces, or they enclose something".into());
        };
        if let Some(face) = top.iter().find(|face| {
            let area = area_vector(face, coordinates);
            area.dot(&normal) < FLATNESS * area.norm()
        }) {
            return fail(format!(
                "the face of the top surface at node {} is not in one plane with the others",
                label(face.nodes()[0])
            ));
        }
        let along = Vector3::from(along);
        let Some(first) = (along - normal * along.dot(&normal)).try_normalize(1e-6 * along.norm()) else {
            return fail("the direction along the interface is perpendicular to it".into());
        };
        let second = normal.cross(&first);

        let unique = |faces: &[Face]| {
            let mut nodes: Vec<u32> = faces.iter().flat_map(|f| f.nodes().to_vec()).collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        };
        let (top_nodes, mut others) = (unique(top), unique(bottom));
        let position = |node: u32| at(node).dot(&first);
        others.sort_by(|&a, &b| position(a).total_cmp(&position(b)));
        let reach = COINCIDENCE * shortest;
        let mut bottom_nodes = Vec::with_capacity(top_nodes.len());
        for &node in &top_nodes {
            let start = others.partition_point(|&other| position(other) < position(node) - reach);
            let near = others[start..]
                .iter()
                .take_while(|&&other| position(other) <= position(node) + reach)
                .find(|&&other| (at(other) - at(node)).norm() <= reach);
            let Some(&near) = near else {
                return fail(format!(
                    "node {} of the top surface has no node of the bottom surface within {reach:.3e} m; both must have the \
                     same mesh there",
                    label(node)
                ));
            };
            bottom_nodes.push(near);
        }
        if others.len() != top_nodes.len() {
            return fail(format!(
                "the surfaces have {} and {} nodes; both must have the same mesh",
                top_nodes.len(),
                others.len()
            ));
        }
        let number: BTreeMap<u32, u32> = top_nodes.iter().zip(0..).map(|(&node, i)| (node, i)).collect();
        let elements = top
            .iter()
            .filter_map(|face| match face {
                Face::Tri3(nodes) => Some(Element::Tri3(nodes.map(|n| number[&n]))),
                Face::Quad4(nodes) => Some(Element::Quad4(nodes.map(|n| number[&n]))),
                // Refused above.
                Face::Tri6(_) => None,
            })
            .collect();
        Ok(Self {
            interface: InterfaceMesh {
                nodes: top_nodes.iter().map(|&n| [position(n), at(n).dot(&second)]).collect(),
                elements,
            },
            top_nodes,
            bottom_nodes,
            frame: [first.into(), second.into(), normal.into()],
        })
    }
}

/// Area times outward normal.
fn area_vector(face: &Face, coordinates: &[[f64; 3]]) -> Vector3<f64> {
    let at = |node: u32| Vector3::from(coordinates[node as usize]);
    match face {
        Face::Quad4([a, b, c, d]) => (at(*c) - at(*a)).cross(&(at(*d) - at(*b))) * 0.5,
        Face::Tri3([a, b, c]) | Face::Tri6([a, b, c, ..]) => (at(*b) - at(*a)).cross(&(at(*c) - at(*a))) * 0.5,
    }
}
