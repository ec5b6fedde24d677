//! The table of element shapes: node counts, shape functions and sums.

use crate::kernels::{Kernels, pairs};
use std::fmt;

/// Most nodes that an element can have. A row of the table with more does not compile.
pub(crate) const MAX_NODES: usize = 9;

/// Reference shape of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// The square from -1 to 1.
    Square,
    /// The triangle with corners at the origin and at 1 on each axis.
    Triangle,
    /// A single point without extent. What area it stands for is said by the element.
    Point,
}

/// One row of the table of element shapes. Nodes run counter-clockwise: the corners first, then the middles of the edges from
/// each corner to the next, then the centre. Edges with a middle may be curved.
pub struct Shape {
    /// Name: shape and number of nodes.
    pub name: &'static str,
    /// Reference shape, which decides the quadrature rule.
    pub domain: Domain,
    /// Number of nodes.
    pub n_nodes: usize,
    /// Number of corners.
    pub n_corners: usize,
    /// Values and natural derivatives at a quadrature point, one per node.
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

/// Six-node triangle.
pub static TRI6: Shape = Shape {
    name: "Tri6",
    domain: Domain::Triangle,
    n_nodes: 6,
    n_corners: 3,
    interpolation: tri6,
    kernels: Kernels::of::<6, { pairs(6) }>(),
};

/// Eight-node quadrilateral. A uniform traction pulls at its corners in the opposite sense (-1/12 of the force each), which
/// does no harm: contact is judged at the quadrature points.
pub static QUAD8: Shape = Shape {
    name: "Quad8",
    domain: Domain::Square,
    n_nodes: 8,
    n_corners: 4,
    interpolation: quad8,
    kernels: Kernels::of::<8, { pairs(8) }>(),
};

/// Nine-node quadrilateral.
pub static QUAD9: Shape = Shape {
    name: "Quad9",
    domain: Domain::Square,
    n_nodes: 9,
    n_corners: 4,
    interpolation: quad9,
    kernels: Kernels::of::<9, { pairs(9) }>(),
};

/// A single node with one quadrature point at it, whose weight is the area that the element stands for.
pub static POINT1: Shape = Shape {
    name: "Point1",
    domain: Domain::Point,
    n_nodes: 1,
    n_corners: 1,
    interpolation: point1,
    kernels: Kernels::of::<1, { pairs(1) }>(),
};

/// All element shapes. Each has a number of nodes of its own.
pub static SHAPES: [&Shape; 6] = [&TRI3, &QUAD4, &TRI6, &QUAD8, &QUAD9, &POINT1];

const _: () = {
    let mut row = 0;
    while row < SHAPES.len() {
        assert!(SHAPES[row].n_nodes <= MAX_NODES, "raise MAX_NODES");
        row += 1;
    }
};

/// Corners of the reference square.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

fn tri3([s, t]: [f64; 2], values: &mut [f64], derivatives: &mut [[f64; 2]]) {
    values.copy_from_slice(&[1.0 - s - t, s, t]);
    derivatives.copy_from_slice(&[[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]);
}

fn quad4([s, t]: [f64; 2], values: &mut [f64], derivatives: &mut [[f64; 2]]) {
    values.copy_from_slice(&CORNERS.map(|[a, b]| 0.25 * (1.0 + a * s) * (1.0 + b * t)));
    derivatives.copy_from_slice(&CORNERS.map(|[a, b]| [0.25 * a * (1.0 + b * t), 0.25 * b * (1.0 + a * s)]));
}

fn tri6([s, t]: [f64; 2], values: &mut [f64], derivatives: &mut [[f64; 2]]) {
    let (l, d) = ([1.0 - s - t, s, t], [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]);
    for a in 0..3 {
        let b = (a + 1) % 3;
        values[a] = l[a] * (2.0 * l[a] - 1.0);
        values[3 + a] = 4.0 * l[a] * l[b];
        for i in 0..2 {
            derivatives[a][i] = d[a][i] * (4.0 * l[a] - 1.0);
            derivatives[3 + a][i] = 4.0 * (d[a][i] * l[b] + l[a] * d[b][i]);
        }
    }
}

/// The bilinear functions of the corners less half of each neighbouring middle's.
fn quad8(xi: [f64; 2], values: &mut [f64], derivatives: &mut [[f64; 2]]) {
    quad4(xi, &mut values[..4], &mut derivatives[..4]);
    for (edge, [a, b]) in [[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]
        .into_iter()
        .enumerate()
    {
        // A parabola along the edge, a line across it.
        let (along, across, sign) = if a == 0.0 { (0, 1, b) } else { (1, 0, a) };
        let (bubble, line) = (1.0 - xi[along] * xi[along], 0.5 * (1.0 + sign * xi[across]));
        let mut slope = [0.0; 2];
        slope[along] = -2.0 * xi[along] * line;
        slope[across] = 0.5 * sign * bubble;
        values[4 + edge] = bubble * line;
        derivatives[4 + edge] = slope;
        for corner in [edge, (edge + 1) % 4] {
            values[corner] -= 0.5 * bubble * line;
            for i in 0..2 {
                derivatives[corner][i] -= 0.5 * slope[i];
            }
        }
    }
}

/// The functions of eight nodes less the part of the centre: -1/4 at the corners, 1/2 at the middles.
fn quad9(xi: [f64; 2], values: &mut [f64], derivatives: &mut [[f64; 2]]) {
    quad8(xi, &mut values[..8], &mut derivatives[..8]);
    let [f, g] = xi.map(|x| 1.0 - x * x);
    let slope = [-2.0 * xi[0] * g, -2.0 * xi[1] * f];
    values[8] = f * g;
    derivatives[8] = slope;
    for node in 0..8 {
        let part = if node < 4 { -0.25 } else { 0.5 };
        values[node] -= part * f * g;
        for i in 0..2 {
            derivatives[node][i] -= part * slope[i];
        }
    }
}

fn point1(_: [f64; 2], values: &mut [f64], derivatives: &mut [[f64; 2]]) {
    values.copy_from_slice(&[1.0]);
    derivatives.copy_from_slice(&[[0.0; 2]]);
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

/// Shape functions at a point, in memory of fixed size.
#[derive(Clone, Copy)]
pub(crate) struct Functions {
    n: usize,
    values: [f64; MAX_NODES],
    derivatives: [[f64; 2]; MAX_NODES],
}

impl Functions {
    pub(crate) fn new(shape: &Shape, xi: [f64; 2]) -> Self {
        let mut at = Self {
            n: shape.n_nodes,
            values: [0.0; MAX_NODES],
            derivatives: [[0.0; 2]; MAX_NODES],
        };
        (shape.interpolation)(xi, &mut at.values[..at.n], &mut at.derivatives[..at.n]);
        at
    }

    pub(crate) fn values(&self) -> &[f64] {
        &self.values[..self.n]
    }

    pub(crate) fn derivatives(&self) -> &[[f64; 2]] {
        &self.derivatives[..self.n]
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
