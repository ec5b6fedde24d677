//! What bodies look like from outside.

use finite_elements::mesh::Face;
use joint_model::{Bodies, Joint, Sides};

/// The outer surface of the bodies without the faces that touch.
#[derive(Clone, Debug)]
pub struct OuterSurface {
    /// Positions of its nodes (m).
    pub nodes: Vec<[f64; 3]>,
    /// Their numbers in the mesh, from zero.
    pub numbers: Vec<u32>,
    /// Its faces, outward, over these nodes.
    pub faces: Vec<Face>,
}

impl OuterSurface {
    /// That of a joint; none of matrices, whose bodies have no known shape.
    pub fn of(joint: &Joint) -> Option<Self> {
        let Bodies::Meshed(bodies) = &joint.bodies else {
            return None;
        };
        let mesh = &bodies.assembly.mesh;
        let mut touches = vec![false; mesh.nodes.len()];
        let mut mark = |nodes: &[u32]| nodes.iter().for_each(|&node| touches[node as usize] = true);
        match &bodies.sides {
            Sides::Pairs { top, bottom } => [top, bottom].into_iter().for_each(|nodes| mark(nodes)),
            Sides::Projected(parts) => {
                let sides = parts.iter().flat_map(|part| [&part.own, &part.other]);
                sides.for_each(|nodes| mark(nodes));
            }
        }
        let mut faces = mesh.boundary();
        faces.retain(|face| !face.corners().iter().all(|&node| touches[node as usize]));
        Some(Self::from_faces(&mesh.nodes, &faces))
    }

    /// Faces over the nodes of a mesh, with the nodes that they have alone.
    pub fn from_faces(nodes: &[[f64; 3]], faces: &[Face]) -> Self {
        let mut place = vec![u32::MAX; nodes.len()];
        let mut numbers = Vec::new();
        let mut renumbered = |&node: &u32| {
            let place = &mut place[node as usize];
            if *place == u32::MAX {
                *place = numbers.len() as u32;
                numbers.push(node);
            }
            *place
        };
        let faces = faces.iter().filter_map(|face| {
            let nodes: Vec<u32> = face.nodes().iter().map(&mut renumbered).collect();
            Face::from_nodes(&nodes)
        });
        let faces = faces.collect();
        Self {
            nodes: numbers.iter().map(|&node| nodes[node as usize]).collect(),
            numbers,
            faces,
        }
    }
}
