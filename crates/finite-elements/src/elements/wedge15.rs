//! Fifteen-node wedge: 3 points in the triangle times 3 along it for the stiffness, 4 x 4 x 4 for the mass, exact where edges
//! are straight.

use super::cell::{Alternative, Cell, ElementType, ForeignType, Formulation};
use super::face::{QUAD8, TRI6};
use super::isoparametric::isoparametric;
use super::quadrature::{wedge_9, wedge_64};
use super::wedge6::signed_volume;

/// Corners of the triangle between which an edge of it lies.
const EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// Fifteen-node wedge.
pub static WEDGE15: ElementType = ElementType {
    name: "Wedge15",
    description: "wedges of 15 nodes",
    nodes: &[
        [0.0, 0.0, -1.0],
        [1.0, 0.0, -1.0],
        [0.0, 1.0, -1.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
        [0.5, 0.0, -1.0],
        [0.5, 0.5, -1.0],
        [0.0, 0.5, -1.0],
        [0.5, 0.0, 1.0],
        [0.5, 0.5, 1.0],
        [0.0, 0.5, 1.0],
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
    ],
    middles: &[
        &[0, 1],
        &[1, 2],
        &[2, 0],
        &[3, 4],
        &[4, 5],
        &[5, 3],
        &[0, 3],
        &[1, 4],
        &[2, 5],
    ],
    faces: &[
        (&TRI6, &[0, 2, 1, 8, 7, 6]),
        (&TRI6, &[3, 4, 5, 9, 10, 11]),
        (&QUAD8, &[0, 1, 4, 3, 6, 13, 9, 12]),
        (&QUAD8, &[1, 2, 5, 4, 7, 14, 10, 13]),
        (&QUAD8, &[2, 0, 3, 5, 8, 12, 11, 14]),
    ],
    formulations: &[(Formulation::Full, Some("C3D15"))],
    gmsh: ForeignType {
        number: 18,
        // Edges by their lower corner, then by the other one.
        order: &[0, 1, 2, 3, 4, 5, 6, 8, 12, 7, 13, 14, 9, 11, 10],
        alternative: None,
    },
    vtk: ForeignType {
        number: 26,
        order: &[],
        // As for wedges of 6 nodes: the manual of VTK takes the first triangle from the other side.
        alternative: Some(Alternative {
            order: &[0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13],
            applies: |x| signed_volume(x) < 0.0,
        }),
    },
    interpolation,
    matrices: |place, _| isoparametric(place, &WEDGE15, &wedge_9(), &wedge_64()),
};

impl Cell {
    /// A fifteen-node wedge; nodes 6-14 lie between corners 01, 12, 20, 34, 45, 53, 03, 14, 25.
    pub fn wedge15(nodes: [u32; 15]) -> Self {
        Self::from_row(&WEDGE15, Formulation::Full, &nodes)
    }
}

/// On the prism over the triangle with corners at the origin and at 1 on two axes, from -1 to 1 along the third.
fn interpolation([r, s, t]: [f64; 3], values: &mut [f64], derivatives: &mut [[f64; 3]]) {
    let l = [1.0 - r - s, r, s];
    let d = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
    let bubble = 1.0 - t * t;
    for (level, sign) in [-1.0, 1.0].into_iter().enumerate() {
        let end = 1.0 + sign * t;
        for a in 0..3 {
            let corner = 3 * level + a;
            values[corner] = 0.5 * l[a] * ((2.0 * l[a] - 1.0) * end - bubble);
            let slope = 0.5 * ((4.0 * l[a] - 1.0) * end - bubble);
            let along = 0.5 * l[a] * ((2.0 * l[a] - 1.0) * sign + 2.0 * t);
            derivatives[corner] = [d[a][0] * slope, d[a][1] * slope, along];
        }
        for (edge, [a, b]) in EDGES.into_iter().enumerate() {
            let middle = 6 + 3 * level + edge;
            values[middle] = 2.0 * l[a] * l[b] * end;
            let across = [0, 1].map(|i| 2.0 * end * (l[a] * d[b][i] + l[b] * d[a][i]));
            derivatives[middle] = [across[0], across[1], 2.0 * sign * l[a] * l[b]];
        }
    }
    for a in 0..3 {
        values[12 + a] = l[a] * bubble;
        derivatives[12 + a] = [d[a][0] * bubble, d[a][1] * bubble, -2.0 * t * l[a]];
    }
}
