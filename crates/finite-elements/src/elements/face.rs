//! Faces of elements: a table of their types, and the nodes of one face.

use super::lagrange::lagrange;
use nalgebra::{Vector2, Vector3};
use std::fmt;

/// Most nodes that a face can have. A row of the table with more does not compile.
const MAX_NODES: usize = 9;

/// Reference shape of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// The triangle with corners at the origin and at 1 on each axis.
    Triangle,
    /// The square from -1 to 1.
    Square,
}

impl Domain {
    /// Its middle.
    pub(crate) fn centre(self) -> Vector2<f64> {
        match self {
            Self::Square => Vector2::zeros(),
            Self::Triangle => Vector2::repeat(1.0 / 3.0),
        }
    }

    /// Natural coordinates brought back into the shape.
    pub(crate) fn clamp(self, s: Vector2<f64>) -> Vector2<f64> {
        match self {
            Self::Square => s.map(|v| v.clamp(-1.0, 1.0)),
            Self::Triangle => {
                let s = s.map(|v| v.max(0.0));
                let excess = s.x + s.y - 1.0;
                if excess <= 0.0 {
                    return s;
                }
                // Onto the slanted edge.
                let x = (s.x - 0.5 * excess).clamp(0.0, 1.0);
                Vector2::new(x, 1.0 - x)
            }
        }
    }
}

/// Values and derivatives by two natural coordinates, one per node.
pub(crate) type FaceShape = (Vec<f64>, Vec<Vector2<f64>>);

/// Local numbers of nodes, and their shares of a face's area (m^2).
pub(crate) type NodeAreas = Vec<(usize, f64)>;

/// One row of the table of faces. Nodes are the corners, then the middles of the edges between them, then the centre.
pub struct FaceType {
    /// Name: shape and number of nodes.
    pub name: &'static str,
    /// Reference shape.
    pub domain: Domain,
    /// Number of nodes.
    pub n_nodes: usize,
    /// Number of corners, which come first.
    pub n_corners: usize,
    /// Element type in Gmsh; nodes are in the same order.
    pub gmsh: u8,
    /// Cell type in VTK; nodes are in the same order.
    pub vtk: u8,
    pub(crate) interpolation: fn(Vector2<f64>) -> FaceShape,
    /// Shares of the area of a face whose nodes are at the given positions (m), by local number (m^2), none negative:
    /// the integrals of the shape functions, but for the row's own exceptions. Nodes without a share are left out.
    pub(crate) node_areas: fn(&[Vector3<f64>]) -> NodeAreas,
}

/// Triangle with three nodes.
pub static TRI3: FaceType = FaceType {
    name: "Tri3",
    domain: Domain::Triangle,
    n_nodes: 3,
    n_corners: 3,
    gmsh: 2,
    vtk: 5,
    interpolation: tri3,
    node_areas: |x| {
        let third = triangle_area(x, [0, 1, 2]) / 3.0;
        (0..3).map(|node| (node, third)).collect()
    },
};

/// Bilinear quadrilateral.
pub static QUAD4: FaceType = FaceType {
    name: "Quad4",
    domain: Domain::Square,
    n_nodes: 4,
    n_corners: 4,
    gmsh: 3,
    vtk: 9,
    interpolation: quad4,
    node_areas: |x| integrals(x, quad4, &square_4()).into_iter().enumerate().collect(),
};

/// Quadratic triangle; nodes 3-5 lie between corners 01, 12, 20.
pub static TRI6: FaceType = FaceType {
    name: "Tri6",
    domain: Domain::Triangle,
    n_nodes: 6,
    n_corners: 3,
    gmsh: 9,
    vtk: 22,
    interpolation: tri6,
    node_areas: |x| {
        // A third of the area for each middle node: the integrals on a plane face.
        let area = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
        let area: f64 = area.map(|part| triangle_area(x, part)).iter().sum();
        (3..6).map(|node| (node, area / 3.0)).collect()
    },
};

/// Serendipity quadrilateral; nodes 4-7 lie between corners 01, 12, 23, 30.
pub static QUAD8: FaceType = FaceType {
    name: "Quad8",
    domain: Domain::Square,
    n_nodes: 8,
    n_corners: 4,
    gmsh: 16,
    vtk: 23,
    interpolation: quad8,
    node_areas: |x| {
        // The integrals are negative at the corners, a twelfth of the area on a parallelogram. Half of each goes to
        // the two middles beside it, so that every share is positive and the shares of a parallelogram keep its centroid.
        let integrals = integrals(x, quad8, &square_9());
        let share = |edge: usize| integrals[4 + edge] + 0.5 * (integrals[edge] + integrals[(edge + 1) % 4]);
        (0..4).map(|edge| (4 + edge, share(edge))).collect()
    },
};

/// Biquadratic quadrilateral; nodes 4-7 lie between corners 01, 12, 23, 30, node 8 in the centre.
pub static QUAD9: FaceType = FaceType {
    name: "Quad9",
    domain: Domain::Square,
    n_nodes: 9,
    n_corners: 4,
    gmsh: 10,
    vtk: 28,
    interpolation: quad9,
    node_areas: |x| integrals(x, quad9, &square_9()).into_iter().enumerate().collect(),
};

/// All face types.
pub static FACE_TYPES: [&FaceType; 5] = [&TRI3, &QUAD4, &TRI6, &QUAD8, &QUAD9];

const _: () = {
    let mut row = 0;
    while row < FACE_TYPES.len() {
        assert!(FACE_TYPES[row].n_nodes <= MAX_NODES, "raise MAX_NODES");
        row += 1;
    }
};

fn triangle_area(x: &[Vector3<f64>], [a, b, c]: [usize; 3]) -> f64 {
    0.5 * (x[b] - x[a]).cross(&(x[c] - x[a])).norm()
}

fn barycentric(s: Vector2<f64>) -> ([f64; 3], [Vector2<f64>; 3]) {
    (
        [1.0 - s.x - s.y, s.x, s.y],
        [Vector2::new(-1.0, -1.0), Vector2::x(), Vector2::y()],
    )
}

fn tri3(s: Vector2<f64>) -> FaceShape {
    let (l, d) = barycentric(s);
    (l.to_vec(), d.to_vec())
}

const SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

fn quad4(s: Vector2<f64>) -> FaceShape {
    let (a, b) = (s.x, s.y);
    let values = SIGNS.map(|[p, q]| 0.25 * (1.0 + p * a) * (1.0 + q * b));
    let slopes = SIGNS.map(|[p, q]| Vector2::new(0.25 * p * (1.0 + q * b), 0.25 * q * (1.0 + p * a)));
    (values.to_vec(), slopes.to_vec())
}

/// The functions of [`super::hex20`] with one coordinate less.
fn quad8(s: Vector2<f64>) -> FaceShape {
    let (a, b) = (s.x, s.y);
    let mut values: Vec<f64> = Vec::with_capacity(8);
    let mut slopes: Vec<Vector2<f64>> = Vec::with_capacity(8);
    for [p, q] in SIGNS {
        let (f, g) = (1.0 + p * a, 1.0 + q * b);
        values.push(0.25 * f * g * (p * a + q * b - 1.0));
        slopes.push(Vector2::new(
            0.25 * p * g * (2.0 * p * a + q * b),
            0.25 * q * f * (p * a + 2.0 * q * b),
        ));
    }
    for (edge, sign) in [-1.0, 1.0, 1.0, -1.0].into_iter().enumerate() {
        let (along, across) = if edge % 2 == 0 { (a, b) } else { (b, a) };
        let (bubble, linear) = (1.0 - along * along, 0.5 * (1.0 + sign * across));
        let slope = [-2.0 * along * linear, 0.5 * sign * bubble];
        values.push(bubble * linear);
        slopes.push(match edge % 2 {
            0 => Vector2::new(slope[0], slope[1]),
            _ => Vector2::new(slope[1], slope[0]),
        });
    }
    (values, slopes)
}

/// Natural coordinates of the nodes of a biquadratic quadrilateral.
const NINE: [[f64; 2]; 9] = [
    SIGNS[0],
    SIGNS[1],
    SIGNS[2],
    SIGNS[3],
    [0.0, -1.0],
    [1.0, 0.0],
    [0.0, 1.0],
    [-1.0, 0.0],
    [0.0, 0.0],
];

fn quad9(s: Vector2<f64>) -> FaceShape {
    let lines = NINE.map(|[p, q]| [lagrange(p, s.x), lagrange(q, s.y)]);
    (
        lines.map(|[f, g]| f[0] * g[0]).to_vec(),
        lines.map(|[f, g]| Vector2::new(f[1] * g[0], f[0] * g[1])).to_vec(),
    )
}

/// A point of the reference square and its weight.
type SquarePoint = (Vector2<f64>, f64);

fn square_4() -> [SquarePoint; 4] {
    SIGNS.map(|sign| (Vector2::from(sign) * (1.0 / 3.0_f64.sqrt()), 1.0))
}

fn square_9() -> [SquarePoint; 9] {
    let along = |sign: f64| sign * 0.6_f64.sqrt();
    let weight = |sign: f64| if sign == 0.0 { 8.0 / 9.0 } else { 5.0 / 9.0 };
    NINE.map(|[p, q]| (Vector2::new(along(p), along(q)), weight(p) * weight(q)))
}

/// Integrals of the shape functions over a quadrilateral in space (m^2).
fn integrals(x: &[Vector3<f64>], interpolation: fn(Vector2<f64>) -> FaceShape, points: &[SquarePoint]) -> Vec<f64> {
    let mut sums = vec![0.0; x.len()];
    for (at, weight) in points {
        let (values, slopes) = interpolation(*at);
        let [mut ds, mut dt] = [Vector3::zeros(); 2];
        for (slope, x) in slopes.iter().zip(x) {
            ds += x * slope.x;
            dt += x * slope.y;
        }
        let area = weight * ds.cross(&dt).norm();
        for (value, sum) in values.iter().zip(&mut sums) {
            *sum += value * area;
        }
    }
    sums
}

fn tri6(s: Vector2<f64>) -> FaceShape {
    let (l, d) = barycentric(s);
    let mut values: Vec<f64> = l.iter().map(|l| l * (2.0 * l - 1.0)).collect();
    let mut slopes: Vec<Vector2<f64>> = l.iter().zip(&d).map(|(l, d)| d * (4.0 * l - 1.0)).collect();
    for [i, j] in [[0, 1], [1, 2], [2, 0]] {
        values.push(4.0 * l[i] * l[j]);
        slopes.push((d[i] * l[j] + d[j] * l[i]) * 4.0);
    }
    (values, slopes)
}

/// Types are equal if they are the same row of the table.
impl PartialEq for FaceType {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

impl Eq for FaceType {}

impl fmt::Debug for FaceType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// Type and nodes (zero based) of an element's face, counter-clockwise seen from outside: the corners, then the middles
/// of the edges between them.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Face {
    face_type: &'static FaceType,
    /// Zero beyond the nodes of the type.
    nodes: [u32; MAX_NODES],
}

impl Face {
    /// The face with these nodes, whose number tells its type; `None` if no type has so many.
    pub fn from_nodes(nodes: &[u32]) -> Option<Self> {
        let face_type = FACE_TYPES.into_iter().find(|row| row.n_nodes == nodes.len())?;
        Some(Self::from_row(face_type, nodes.iter().copied()))
    }

    /// A triangle.
    pub fn tri3(nodes: [u32; 3]) -> Self {
        Self::from_row(&TRI3, nodes.into_iter())
    }

    /// A bilinear quadrilateral.
    pub fn quad4(nodes: [u32; 4]) -> Self {
        Self::from_row(&QUAD4, nodes.into_iter())
    }

    /// A serendipity quadrilateral.
    pub fn quad8(nodes: [u32; 8]) -> Self {
        Self::from_row(&QUAD8, nodes.into_iter())
    }

    /// A biquadratic quadrilateral.
    pub fn quad9(nodes: [u32; 9]) -> Self {
        Self::from_row(&QUAD9, nodes.into_iter())
    }

    /// A quadratic triangle.
    pub fn tri6(nodes: [u32; 6]) -> Self {
        Self::from_row(&TRI6, nodes.into_iter())
    }

    /// `nodes` are as many as the type has.
    pub(super) fn from_row(face_type: &'static FaceType, nodes: impl Iterator<Item = u32>) -> Self {
        let mut face = Self {
            face_type,
            nodes: [0; MAX_NODES],
        };
        face.nodes.iter_mut().zip(nodes).for_each(|(slot, node)| *slot = node);
        face
    }

    /// Its row in the table of faces.
    pub fn face_type(&self) -> &'static FaceType {
        self.face_type
    }

    /// Shares of its area (m^2) by node: the integrals of the shape functions, but for shapes where these are negative or zero at
    /// corners, which share with the middles beside them. Nodes without a share are left out.
    ///
    /// # Panics
    /// If a node has no position in `coordinates` (m).
    pub fn node_areas(&self, coordinates: &[[f64; 3]]) -> Vec<(u32, f64)> {
        let x: Vec<_> = self
            .nodes()
            .iter()
            .map(|&node| coordinates[node as usize].into())
            .collect();
        let shares = (self.face_type().node_areas)(&x).into_iter();
        shares.map(|(local, area)| (self.nodes()[local], area)).collect()
    }

    /// All nodes.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..self.face_type.n_nodes]
    }

    /// The nodes at its corners.
    pub fn corners(&self) -> &[u32] {
        &self.nodes[..self.face_type.n_corners]
    }

    /// Its nodes with the shares of its area that stand for them (m^2), for `nodes` of the mesh (m): consistent with uniform
    /// pressure, except that corners of quadrilaterals with eight nodes give their negative shares to the middles beside them.
    /// Nodes without a share are left out.
    ///
    /// # Panics
    /// If a node does not exist.
    pub fn areas(&self, nodes: &[[f64; 3]]) -> Vec<(u32, f64)> {
        let at: Vec<_> = self.nodes().iter().map(|&node| nodes[node as usize].into()).collect();
        let shares = (self.face_type().node_areas)(&at).into_iter();
        shares.map(|(local, area)| (self.nodes()[local], area)).collect()
    }

    /// Volume between the face and a place (m^3), positive where the face looks away from it: a third of the integral of its distance. Exact
    /// for nodes between corners anywhere.
    pub(super) fn volume_from(&self, origin: Vector3<f64>, nodes: &[[f64; 3]]) -> f64 {
        let x = self
            .nodes()
            .iter()
            .map(|&node| Vector3::from(nodes[node as usize]) - origin);
        let x: Vec<Vector3<f64>> = x.collect();
        let point = |(at, weight): SquarePoint| {
            let (at, weight) = match self.face_type.domain {
                Domain::Square => (at, weight),
                // The square collapsed onto the triangle.
                Domain::Triangle => {
                    let u = at.map(|v| 0.5 * (1.0 + v));
                    (Vector2::new(u.x, (1.0 - u.x) * u.y), 0.25 * weight * (1.0 - u.x))
                }
            };
            let (values, derivatives) = (self.face_type.interpolation)(at);
            let mut sums = [Vector3::zeros(); 3];
            for ((x, value), derivative) in x.iter().zip(values).zip(derivatives) {
                sums[0] += x * value;
                sums[1] += x * derivative.x;
                sums[2] += x * derivative.y;
            }
            weight * sums[0].dot(&sums[1].cross(&sums[2])) / 3.0
        };
        square_9().map(point).iter().sum()
    }

    /// The same face on other nodes: `of` gives the new number of each node.
    ///
    /// # Errors
    /// The first error of `of`.
    pub fn try_map_nodes<E>(&self, mut of: impl FnMut(u32) -> Result<u32, E>) -> Result<Self, E> {
        let mut mapped = *self;
        for node in &mut mapped.nodes[..self.face_type.n_nodes] {
            *node = of(*node)?;
        }
        Ok(mapped)
    }
}

impl fmt::Debug for Face {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple(self.face_type.name).field(&self.nodes()).finish()
    }
}
