//! Twenty-seven-node Lagrange hexahedron: 3 x 3 x 3 Gauss points for the stiffness, 4 x 4 x 4 for the mass, exact where edges
//! are straight.

use super::cell::{Cell, ElementType, ForeignType, Formulation};
use super::face::QUAD9;
use super::hex20;
use super::isoparametric::isoparametric;
use super::lagrange::lagrange;
use super::quadrature::{hexahedron_27, hexahedron_64};

/// Twenty-seven-node hexahedron.
pub static HEX27: ElementType = ElementType {
    name: "Hex27",
    description: "hexahedra of 27 nodes",
    nodes: &NODES,
    middles: &[
        &[0, 1],
        &[1, 2],
        &[2, 3],
        &[3, 0],
        &[4, 5],
        &[5, 6],
        &[6, 7],
        &[7, 4],
        &[0, 4],
        &[1, 5],
        &[2, 6],
        &[3, 7],
        &[3, 0, 4, 7],
        &[1, 2, 6, 5],
        &[0, 1, 5, 4],
        &[2, 3, 7, 6],
        &[0, 3, 2, 1],
        &[4, 5, 6, 7],
        &[0, 1, 2, 3, 4, 5, 6, 7],
    ],
    faces: &[
        (&QUAD9, &[0, 3, 2, 1, 11, 10, 9, 8, 24]),
        (&QUAD9, &[4, 5, 6, 7, 12, 13, 14, 15, 25]),
        (&QUAD9, &[0, 1, 5, 4, 8, 17, 12, 16, 22]),
        (&QUAD9, &[1, 2, 6, 5, 9, 18, 13, 17, 21]),
        (&QUAD9, &[2, 3, 7, 6, 10, 19, 14, 18, 23]),
        (&QUAD9, &[3, 0, 4, 7, 11, 16, 15, 19, 20]),
    ],
    // Abaqus reserves C3D27 for elements some of whose middles of faces may be missing; CalculiX has none.
    formulations: &[(Formulation::Full, None)],
    gmsh: ForeignType {
        number: 12,
        // Edges as those of 20 nodes, then the faces by their lowest corners.
        order: &[
            0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14, 24, 22, 20, 21, 23, 25, 26,
        ],
        alternative: None,
    },
    vtk: ForeignType::same_order(29),
    interpolation,
    matrices: |place, _| isoparametric(place, &HEX27, &hexahedron_27(), &hexahedron_64()),
};

impl Cell {
    /// A twenty-seven-node hexahedron; nodes 8-19 as those of [`Cell::hex20`], nodes 20-25 in the middles of the faces
    /// where the natural coordinates are r = -1, 1, s = -1, 1, t = -1, 1, and node 26 in the centre.
    pub fn hex27(nodes: [u32; 27]) -> Self {
        Self::from_row(&HEX27, Formulation::Full, &nodes)
    }
}

/// Natural coordinates of the nodes.
const NODES: [[f64; 3]; 27] = {
    let mut nodes = [[0.0; 3]; 27];
    let mut node = 0;
    while node < 20 {
        nodes[node] = hex20::NODES[node];
        node += 1;
    }
    nodes[20][0] = -1.0;
    nodes[21][0] = 1.0;
    nodes[22][1] = -1.0;
    nodes[23][1] = 1.0;
    nodes[24][2] = -1.0;
    nodes[25][2] = 1.0;
    nodes
};

fn interpolation(xi: [f64; 3], values: &mut [f64], derivatives: &mut [[f64; 3]]) {
    for (node, (value, derivative)) in NODES.iter().zip(values.iter_mut().zip(derivatives)) {
        let [f, g, h] = [0, 1, 2].map(|i| lagrange(node[i], xi[i]));
        *value = f[0] * g[0] * h[0];
        *derivative = [f[1] * g[0] * h[0], f[0] * g[1] * h[0], f[0] * g[0] * h[1]];
    }
}
