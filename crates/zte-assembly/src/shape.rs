//! The table of element shapes: node counts, shape functions and sums.

use crate::kernels::{Kernels, pairs};
use std::fmt;

/// Most nodes that an element can have. A row of the table with more does not compile.
pub(crate) const MAX_NODES: usize = 4;

/// Reference shape of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// The square from -1 to 1.
    Square,
    /// The triangle with corners at the origin and at 1 on each axis.
    Triangle,
}

/// One row of the table of element shapes. Nodes run counter-clockwise: the corners first, then all others.
pub struct Shape {
    /// Name: shape and number of nodes.
    pub name: &'static str,
    /// Reference shape, which decides the quadrature rule.
    pub domain: Domain,
    /// Number of nodes.
    pub n_nodes: usize,
    /// Number of corners.
    pub n_corners: usize,
    /// Values and natural derivatives at a point, one per node.
    interpolation: fn([f64; 2], &mut [f64], &mut [[f64; 2]]),
    pub(crate) kernels: Kernels,
}

/// Three-node triangle.
pub static TRI3: Shape = Shape {
    name: "Tri3",
    domain: Domain::Triangle,
    n_nodes: 3,
    n_corners: 3,
    interpolation: tri3,
    kernels: Kernels::of::<3, { pairs(3) }>(),
};

/// Four-node quadrilateral.
pub static QUAD4: Shape = Shape {
    name: "Quad4",
    domain: Domain::Square,
    n_nodes: 4,
    n_corners: 4,
    interpolation: quad4,
    kernels: Kernels::of::<4, { pairs(4) }>(),
};

/// All element shapes. Each has a number of nodes of its own.
pub static SHAPES: [&Shape; 2] = [&TRI3, &QUAD4];

const _: () = {
    let mut row = 0;
    while row < SHAPES.len() {
        assert!(SHAPES[row].n_nodes <= MAX_NODES, "raise MAX_NODES");
        row += 1;
    }
};

fn tri3([s, t]: [f64; 2], values: &mut [f64], derivatives: &mut [[f64; 2]]) {
    values.copy_from_slice(&[1.0 - s - t, s, t]);
    derivatives.copy_from_slice(&[[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]);
}

fn quad4([s, t]: [f64; 2], values: &mut [f64], derivatives: &mut [[f64; 2]]) {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    values.copy_from_slice(&corners.map(|[a, b]| 0.25 * (1.0 + a * s) * (1.0 + b * t)));
    derivatives.copy_from_slice(&corners.map(|[a, b]| [0.25 * a * (1.0 + b * t), 0.25 * b * (1.0 + a * s)]));
}

impl Shape {
    /// The shape with this number of nodes.
    pub fn with_nodes(n_nodes: usize) -> Option<&'static Self> {
        SHAPES.into_iter().find(|row| row.n_nodes == n_nodes)
    }

    /// Shape functions and their natural derivatives at the natural coordinates `xi`, one per node.
    pub fn functions(&self, xi: [f64; 2]) -> (Vec<f64>, Vec<[f64; 2]>) {
        let (mut values, mut derivatives) = (vec![0.0; self.n_nodes], vec![[0.0; 2]; self.n_nodes]);
        (self.interpolation)(xi, &mut values, &mut derivatives);
        (values, derivatives)
    }
}

/// Shapes are equal if they are the same row of the table.
impl PartialEq for Shape {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

impl Eq for Shape {}

impl fmt::Debug for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}
