//! What the scripts of the page of a set-up read.

use super::bodies::{MOST_TRIANGLES, sharp_edges, triangles};
use super::encode;
use joints::structure::Shape;
use serde::Serialize;
use serde_json::Value;

/// A mesh to be set up.
#[derive(Debug, Serialize)]
pub(crate) struct Setup<'a> {
    /// What the program says of it.
    facts: &'a Value,
    shape: Outside<'a>,
}

/// The outer surface of a mesh, in the unit of its file.
#[derive(Debug, Serialize)]
struct Outside<'a> {
    /// Positions of the nodes, three numbers in single precision per node.
    positions: String,
    /// Labels of the nodes in the file.
    labels: &'a [u64],
    /// Nodes of the triangles, four bytes each; empty where there are more than a page can hold.
    triangles: String,
    /// The face that each triangle is part of, and of each face the body, the smooth surface, and the pair of bodies that touch there, from 1; 0
    /// where it touches none. Four bytes each.
    face_of_triangle: String,
    bodies: String,
    patches: String,
    touching: String,
    /// Nodes of the sharp edges, four bytes each.
    edges: String,
    /// Surfaces with names, and the numbers of their faces, four bytes each.
    named: Vec<(&'a str, String)>,
}

impl<'a> Setup<'a> {
    pub(crate) fn of(shape: &'a Shape, facts: &'a Value) -> Self {
        let surface = &shape.surface;
        let (mut corners, mut owners) = (Vec::new(), Vec::new());
        for (number, face) in (0..).zip(&surface.faces) {
            let own = triangles(face);
            owners.extend(std::iter::repeat_n(number, own.len() / 3));
            corners.extend(own);
        }
        if owners.len() > MOST_TRIANGLES {
            (corners, owners) = (Vec::new(), Vec::new());
        }
        let edges = sharp_edges(&surface.faces, &surface.nodes);
        let touching = shape.touching.iter().map(|pair| pair.map_or(0, |pair| pair + 1));
        let named = shape.named.iter();
        Self {
            facts,
            shape: Outside {
                positions: encode::singles(surface.nodes.iter().flatten().copied()),
                labels: &shape.labels,
                triangles: encode::integers(corners),
                face_of_triangle: encode::integers(owners),
                bodies: encode::integers(shape.bodies.iter().copied()),
                patches: encode::integers(shape.patches.iter().copied()),
                touching: encode::integers(touching),
                edges: encode::integers(edges.into_iter().flatten()),
                named: named
                    .map(|(name, faces)| (name.as_str(), encode::integers(faces.iter().copied())))
                    .collect(),
            },
        }
    }
}
