//! Whether the map of an element keeps its orientation.

use super::cell::ElementType;
use super::quadrature::{
    Point, TETRAHEDRON_4, hexahedron_8, hexahedron_27, hexahedron_64, tetrahedron_64, wedge_6, wedge_9, wedge_64,
};
use nalgebra::{Matrix3, Vector3};

/// The sign of the Jacobian determinant of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Orientation {
    /// Positive at all points.
    Right,
    /// Negative at all points.
    Mirrored,
    /// Neither.
    Inverted,
}

/// Derivatives of the shape functions of an element type at all integration points of its stiffness and mass.
pub(crate) struct JacobianCheck {
    row: &'static ElementType,
    /// One per node, point by point.
    derivatives: Vec<[f64; 3]>,
}

impl JacobianCheck {
    pub(crate) fn new(row: &'static ElementType) -> Self {
        let points: Vec<Point> = match (row.faces.len(), row.middles.is_empty()) {
            (4, true) => Vec::from(TETRAHEDRON_4),
            (4, false) => TETRAHEDRON_4.into_iter().chain(tetrahedron_64()).collect(),
            (5, true) => wedge_6(),
            (5, false) => wedge_9().into_iter().chain(wedge_64()).collect(),
            (_, true) => hexahedron_8(),
            (_, false) => [hexahedron_8(), hexahedron_27(), hexahedron_64()]
                .into_iter()
                .flatten()
                .collect(),
        };
        let derivatives = points.iter().flat_map(|point| row.shape_functions(point.at).1);
        Self {
            row,
            derivatives: derivatives.collect(),
        }
    }

    /// Of an element with its nodes at `x`, as many as the type has.
    pub(crate) fn orientation(&self, x: &[[f64; 3]]) -> Orientation {
        let n = self.row.n_nodes();
        // The determinant of a tetrahedron with straight edges is the same everywhere.
        let straight = self.row.faces.len() == 4 && self.is_straight(x);
        let points = if straight { 1 } else { self.derivatives.len() / n };
        let positive = self.derivatives.chunks_exact(n).take(points).map(|derivatives| {
            let mut jacobian = Matrix3::zeros();
            for (x, d) in x.iter().zip(derivatives) {
                jacobian += Vector3::from(*d) * Vector3::from(*x).transpose();
            }
            let determinant = jacobian.determinant();
            (determinant > 0.0, determinant < 0.0)
        });
        match positive.fold((true, true), |all, one| (all.0 && one.0, all.1 && one.1)) {
            (true, _) => Orientation::Right,
            (_, true) => Orientation::Mirrored,
            _ => Orientation::Inverted,
        }
    }

    /// Whether the nodes after the corners lie midway between theirs, to a part in 10^9 of the distance.
    fn is_straight(&self, x: &[[f64; 3]]) -> bool {
        let at = |node: usize| Vector3::from(x[node]);
        let first = x.len() - self.row.middles.len();
        self.row.middles.iter().enumerate().all(|(number, between)| {
            let mean = between.iter().map(|&node| at(node)).sum::<Vector3<f64>>() / between.len() as f64;
            (at(first + number) - mean).norm() <= 1e-9 * (at(between[0]) - mean).norm()
        })
    }
}
