//! Six-node wedge: 3 points in the triangle times 2 along it, for stiffness and mass.

use super::cell::{Alternative, Cell, ElementType, ForeignType, Formulation};
use super::face::{QUAD4, TRI3};
use super::isoparametric::isoparametric;
use super::quadrature::wedge_6;
use nalgebra::Vector3;

/// Six-node wedge.
pub static WEDGE6: ElementType = ElementType {
    name: "Wedge6",
    description: "wedges of 6 nodes",
    nodes: &[
        [0.0, 0.0, -1.0],
        [1.0, 0.0, -1.0],
        [0.0, 1.0, -1.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
    ],
    middles: &[],
    faces: &[
        (&TRI3, &[0, 2, 1]),
        (&TRI3, &[3, 4, 5]),
        (&QUAD4, &[0, 1, 4, 3]),
        (&QUAD4, &[1, 2, 5, 4]),
        (&QUAD4, &[2, 0, 3, 5]),
    ],
    formulations: &[(Formulation::Full, Some("C3D6"))],
    gmsh: ForeignType::same_order(6),
    vtk: ForeignType {
        number: 13,
        order: &[],
        // VTK 9.7 takes the first triangle counter-clockwise seen from within, as here; its manual and VTK 9.3 take it
        // from outside. The order with a positive volume is meant.
        alternative: Some(Alternative {
            order: &[0, 2, 1, 3, 5, 4],
            applies: |x| signed_volume(x) < 0.0,
        }),
    },
    interpolation,
    matrices: |place, _| {
        let points = wedge_6();
        isoparametric(place, &WEDGE6, &points, &points)
    },
};

impl Cell {
    /// A six-node wedge.
    pub fn wedge6(nodes: [u32; 6]) -> Self {
        Self::from_row(&WEDGE6, Formulation::Full, &nodes)
    }
}

/// On the prism over the triangle with corners at the origin and at 1 on two axes, from -1 to 1 along the third.
fn interpolation([r, s, t]: [f64; 3], values: &mut [f64], derivatives: &mut [[f64; 3]]) {
    let l = [1.0 - r - s, r, s];
    let d = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
    for (level, sign) in [-1.0, 1.0].into_iter().enumerate() {
        let h = 0.5 * (1.0 + sign * t);
        for a in 0..3 {
            values[3 * level + a] = l[a] * h;
            derivatives[3 * level + a] = [d[a][0] * h, d[a][1] * h, 0.5 * sign * l[a]];
        }
    }
}

/// Six times the volume between the six corners, cut into tetrahedra (m^3): positive in this crate's order.
pub(super) fn signed_volume(x: &[[f64; 3]]) -> f64 {
    let at = |i: usize| Vector3::from(x[i]);
    let tetrahedron = |a, b, c| (at(a) - at(0)).dot(&(at(b) - at(0)).cross(&(at(c) - at(0))));
    tetrahedron(1, 2, 5) + tetrahedron(1, 5, 4) + tetrahedron(3, 4, 5)
}
