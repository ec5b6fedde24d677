//! Four-node tetrahedron: constant strain, exact mass.

use super::cell::{Cell, ElementType, ForeignType, Formulation};
use super::face::TRI3;
use super::isoparametric::isoparametric;
use super::quadrature::TETRAHEDRON_4;

/// Four-node tetrahedron.
pub static TET4: ElementType = ElementType {
    name: "Tet4",
    description: "tetrahedra of 4 nodes",
    nodes: &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    middles: &[],
    faces: &[
        (&TRI3, &[0, 2, 1]),
        (&TRI3, &[0, 1, 3]),
        (&TRI3, &[1, 2, 3]),
        (&TRI3, &[2, 0, 3]),
    ],
    formulations: &[(Formulation::Full, Some("C3D4"))],
    gmsh: ForeignType::same_order(4),
    vtk: ForeignType::same_order(10),
    interpolation,
    matrices: |place, _| isoparametric(place, &TET4, &TETRAHEDRON_4, &TETRAHEDRON_4),
};

impl Cell {
    /// A four-node tetrahedron.
    pub fn tet4(nodes: [u32; 4]) -> Self {
        Self::from_row(&TET4, Formulation::Full, &nodes)
    }
}

/// Derivatives of the four volume coordinates.
pub(super) const SLOPES: [[f64; 3]; 4] = [[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// On the tetrahedron with corners at the origin and at 1 on each axis.
fn interpolation([r, s, t]: [f64; 3], values: &mut [f64], derivatives: &mut [[f64; 3]]) {
    values.copy_from_slice(&[1.0 - r - s - t, r, s, t]);
    derivatives.copy_from_slice(&SLOPES);
}
