//! Surfaces in space for the pages.

use super::encode;
use finite_elements::mesh::Face;
use joints::structure::OuterSurface;
use serde::Serialize;
use std::collections::BTreeMap;

/// Cosine of the angle between neighbouring faces below which their edge is drawn.
const SHARP: f64 = 0.85;

/// Triangles beyond which only the edges of a surface are drawn.
pub(super) const MOST_TRIANGLES: usize = 120_000;

/// Steps that positions are rounded to, over the longest extent.
const STEPS: f64 = 32_767.0;

/// A surface with its sharp edges.
#[derive(Debug, Serialize)]
pub(crate) struct Bodies {
    /// Lower corner of the box around it (m).
    origin: [f64; 3],
    /// Length of a step of the positions (m).
    step: f64,
    /// Positions of the nodes from the origin in steps, three numbers of two bytes per node.
    positions: String,
    /// Nodes of the triangles, four bytes each; empty where there are more than a page can hold.
    triangles: String,
    /// Nodes of the edges, four bytes each.
    edges: String,
}

impl Bodies {
    /// A surface; none without faces.
    pub(crate) fn of(surface: &OuterSurface) -> Option<Self> {
        let nodes = &surface.nodes;
        let bound = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| nodes.iter().map(|x| x[axis]).fold(from, pick);
        let origin = [0, 1, 2].map(|axis| bound(axis, f64::min, f64::INFINITY));
        let extents = [0, 1, 2].map(|axis| bound(axis, f64::max, f64::NEG_INFINITY) - origin[axis]);
        let longest = extents.into_iter().fold(0.0, f64::max);
        // `!(a > b)` also catches NaN.
        if surface.faces.is_empty() || !(longest > 0.0 && longest.is_finite()) {
            return None;
        }
        let step = longest / STEPS;
        let positions = nodes
            .iter()
            .flat_map(|x| [0, 1, 2].map(|c| ((x[c] - origin[c]) / step).round() as i16));
        let triangles: Vec<u32> = surface.faces.iter().flat_map(triangles).collect();
        let edges = sharp_edges(&surface.faces, nodes);
        Some(Self {
            origin,
            step,
            positions: encode::shorts(positions),
            triangles: match triangles.len() / 3 {
                0..=MOST_TRIANGLES => encode::integers(triangles),
                _ => String::new(),
            },
            edges: encode::integers(edges.into_iter().flatten()),
        })
    }
}

/// Nodes of the triangles around the first corner of a face.
pub(super) fn triangles(face: &Face) -> Vec<u32> {
    let corners = face.corners();
    let pairs = corners[1..].windows(2);
    pairs.flat_map(|pair| [corners[0], pair[0], pair[1]]).collect()
}

/// Unit normal of a face by the diagonals of its corners; the zero vector of a degenerate one.
pub(crate) fn normal(face: &Face, nodes: &[[f64; 3]]) -> [f64; 3] {
    let corners: Vec<[f64; 3]> = face.corners().iter().map(|&n| nodes[n as usize]).collect();
    let minus = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|c| a[c] - b[c]);
    let (first, second) = match corners[..] {
        [a, b, c] => (minus(b, a), minus(c, a)),
        [a, b, c, d] => (minus(c, a), minus(d, b)),
        _ => return [0.0; 3],
    };
    let product = [0, 1, 2].map(|c| {
        let (next, last) = ((c + 1) % 3, (c + 2) % 3);
        first[next] * second[last] - first[last] * second[next]
    });
    let length = product.iter().map(|v| v * v).sum::<f64>().sqrt();
    product.map(|v| if length > 0.0 { v / length } else { 0.0 })
}

/// Edges between faces at an angle, and those of one face alone.
pub(crate) fn sharp_edges(faces: &[Face], nodes: &[[f64; 3]]) -> Vec<[u32; 2]> {
    let normals: Vec<[f64; 3]> = faces.iter().map(|face| normal(face, nodes)).collect();
    let mut of_edge: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (number, face) in faces.iter().enumerate() {
        let corners = face.corners();
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            of_edge.entry([a.min(b), a.max(b)]).or_default().push(number);
        }
    }
    let cosine = |a: usize, b: usize| normals[a].iter().zip(normals[b]).map(|(a, b)| a * b).sum::<f64>();
    let is_drawn = |faces: &[usize]| match faces {
        &[a, b] => cosine(a, b) < SHARP,
        _ => true,
    };
    let edges = of_edge.into_iter().filter(|(_, faces)| is_drawn(faces));
    edges.map(|(edge, _)| edge).collect()
}
