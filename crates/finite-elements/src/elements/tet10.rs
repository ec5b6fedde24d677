//! Ten-node tetrahedron: 4 points for the stiffness; 64 for the mass, exact where faces are plane.

use super::cell::{Cell, ElementType, ForeignType, Formulation};
use super::face::TRI6;
use super::isoparametric::isoparametric;
use super::quadrature::{TETRAHEDRON_4, tetrahedron_64};
use super::tet4::SLOPES;

const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Ten-node tetrahedron.
pub static TET10: ElementType = ElementType {
    name: "Tet10",
    description: "tetrahedra of 10 nodes",
    nodes: &[
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.5, 0.0, 0.0],
        [0.5, 0.5, 0.0],
        [0.0, 0.5, 0.0],
        [0.0, 0.0, 0.5],
        [0.5, 0.0, 0.5],
        [0.0, 0.5, 0.5],
    ],
    middles: &[&EDGES[0], &EDGES[1], &EDGES[2], &EDGES[3], &EDGES[4], &EDGES[5]],
    faces: &[
        (&TRI6, &[0, 2, 1, 6, 5, 4]),
        (&TRI6, &[0, 1, 3, 4, 8, 7]),
        (&TRI6, &[1, 2, 3, 5, 9, 8]),
        (&TRI6, &[2, 0, 3, 6, 7, 9]),
    ],
    formulations: &[(Formulation::Full, Some("C3D10"))],
    gmsh: ForeignType {
        number: 11,
        // The last two edges are exchanged.
        order: &[0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
        alternative: None,
    },
    vtk: ForeignType::same_order(24),
    interpolation,
    matrices: |place, _| isoparametric(place, &TET10, &TETRAHEDRON_4, &tetrahedron_64()),
};

impl Cell {
    /// A ten-node tetrahedron; nodes 4-9 lie between corners 01, 12, 20, 03, 13, 23.
    pub fn tet10(nodes: [u32; 10]) -> Self {
        Self::from_row(&TET10, Formulation::Full, &nodes)
    }
}

fn interpolation([r, s, t]: [f64; 3], values: &mut [f64], derivatives: &mut [[f64; 3]]) {
    let (l, d) = ([1.0 - r - s - t, r, s, t], SLOPES);
    for a in 0..4 {
        values[a] = l[a] * (2.0 * l[a] - 1.0);
        derivatives[a] = d[a].map(|d| d * (4.0 * l[a] - 1.0));
    }
    for (e, [a, b]) in EDGES.into_iter().enumerate() {
        values[4 + e] = 4.0 * l[a] * l[b];
        derivatives[4 + e] = [0, 1, 2].map(|i| 4.0 * (l[a] * d[b][i] + d[a][i] * l[b]));
    }
}
