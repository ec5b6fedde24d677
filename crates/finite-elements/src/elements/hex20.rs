//! Twenty-node serendipity hexahedron: 3 x 3 x 3 or 2 x 2 x 2 Gauss points for the stiffness, 4 x 4 x 4 for the mass.
//!
//! The mass is integrated alike in both formulations, and exactly where edges are straight: products of two functions are
//! of degree 4 along each coordinate, the determinant of the Jacobian is then of degree 2, and four points are exact to degree 7.
//!
//! On parallelepipeds, and on meshes that tend to them under refinement, the functions hold all quadratic fields. On elements
//! whose distortion does not fall with their size they hold only the linear ones (Arnold, Boffi and Falk 2002, DOI
//! 10.1090/S0025-5718-02-01439-4); [`super::HEX27`] holds the quadratic ones there too.

use super::cell::{Cell, ElementType, ForeignType, Formulation};
use super::face::QUAD8;
use super::hex8::CORNERS;
use super::isoparametric::isoparametric;
use super::quadrature::{hexahedron_8, hexahedron_27, hexahedron_64};

/// Twenty-node hexahedron.
pub static HEX20: ElementType = ElementType {
    name: "Hex20",
    description: "hexahedra of 20 nodes",
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
    ],
    faces: &[
        (&QUAD8, &[0, 3, 2, 1, 11, 10, 9, 8]),
        (&QUAD8, &[4, 5, 6, 7, 12, 13, 14, 15]),
        (&QUAD8, &[0, 1, 5, 4, 8, 17, 12, 16]),
        (&QUAD8, &[1, 2, 6, 5, 9, 18, 13, 17]),
        (&QUAD8, &[2, 3, 7, 6, 10, 19, 14, 18]),
        (&QUAD8, &[3, 0, 4, 7, 11, 16, 15, 19]),
    ],
    formulations: &[
        (Formulation::Reduced, Some("C3D20R")),
        (Formulation::Full, Some("C3D20")),
    ],
    gmsh: ForeignType {
        number: 17,
        // Edges by their lower corner, then by the other one.
        order: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14],
        alternative: None,
    },
    vtk: ForeignType::same_order(25),
    interpolation,
    matrices: |place, formulation| {
        let mass = hexahedron_64();
        match formulation {
            Formulation::Reduced => isoparametric(place, &HEX20, &hexahedron_8(), &mass),
            _ => isoparametric(place, &HEX20, &hexahedron_27(), &mass),
        }
    },
};

impl Cell {
    /// A twenty-node hexahedron of reduced integration; nodes 8-19 lie between corners 01, 12, 23, 30, 45, 56, 67, 74, 04,
    /// 15, 26, 37. [`Cell::set_formulation`] makes it one of full integration.
    pub fn hex20(nodes: [u32; 20]) -> Self {
        Self::from_row(&HEX20, Formulation::Reduced, &nodes)
    }
}

/// Natural coordinates of the nodes.
pub(super) const NODES: [[f64; 3]; 20] = [
    CORNERS[0],
    CORNERS[1],
    CORNERS[2],
    CORNERS[3],
    CORNERS[4],
    CORNERS[5],
    CORNERS[6],
    CORNERS[7],
    [0.0, -1.0, -1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, -1.0],
    [-1.0, 0.0, -1.0],
    [0.0, -1.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [-1.0, 0.0, 1.0],
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
];

fn interpolation(xi: [f64; 3], values: &mut [f64], derivatives: &mut [[f64; 3]]) {
    for (node, (value, derivative)) in NODES.iter().zip(values.iter_mut().zip(derivatives)) {
        // Along each coordinate a factor with its slope: linear, or a bubble where the node is in the middle.
        let factors = [0, 1, 2].map(|i| match node[i] {
            0.0 => [1.0 - xi[i] * xi[i], -2.0 * xi[i]],
            sign => [0.5 * (1.0 + sign * xi[i]), 0.5 * sign],
        });
        let product = factors[0][0] * factors[1][0] * factors[2][0];
        let slopes = [
            factors[0][1] * factors[1][0] * factors[2][0],
            factors[0][0] * factors[1][1] * factors[2][0],
            factors[0][0] * factors[1][0] * factors[2][1],
        ];
        if node.contains(&0.0) {
            (*value, *derivative) = (product, slopes);
        } else {
            let sum = node[0] * xi[0] + node[1] * xi[1] + node[2] * xi[2] - 2.0;
            *value = product * sum;
            *derivative = [0, 1, 2].map(|i| slopes[i] * sum + product * node[i]);
        }
    }
}
