//! Two surfaces of a mesh that lie upon one another, as an interface.

use crate::Error;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use substructure::mesh::Face;
use zte_assembly::shape::Shape;
use zte_assembly::{Element, InterfaceMesh};

/// How far nodes that face one another may be apart, relative to the shortest edge of the interface.
const COINCIDENCE: f64 = 1e-3;

/// Least cosine between the normal of a face and the mean normal.
const FLATNESS: f64 = 0.99;

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
            if Shape::with_nodes(nodes.len()).is_none() {
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
            .filter_map(|face| {
                let nodes: Vec<u32> = face.nodes().iter().map(|node| number[node]).collect();
                // Shapes that no interface element has were refused above.
                Element::from_nodes(&nodes)
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
    let corners: Vec<Vector3<f64>> = face.corners().iter().map(|&node| at(node)).collect();
    match corners[..] {
        [a, b, c, d] => (c - a).cross(&(d - b)) * 0.5,
        [a, b, c, ..] => (b - a).cross(&(c - a)) * 0.5,
        _ => Vector3::zeros(),
    }
}
