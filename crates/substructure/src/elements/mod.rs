//! Stiffness and mass of single elements.
//!
//! | cell | stiffness | mass |
//! |---|---|---|
//! | hexahedron, [`Formulation`] | 2 x 2 x 2 Gauss points, or one | consistent; lumped by row sums if reduced |
//! | wedge | 3 points in the triangle x 2 along it | the same points |
//! | tetrahedron, 4 nodes | constant strain | exact |
//! | tetrahedron, 10 nodes | 4 points | 64 points: exact where faces are plane |
//!
//! All are isotropic: with the gradients `g_a` of the shape functions the block of nodes `a`, `b` is
//! `lambda g_a g_b^T + mu g_b g_a^T + mu (g_a . g_b) 1`.

mod hex8;
mod quadrature;

pub use hex8::{CORNERS, Formulation};

use crate::Error;
use crate::mesh::{Cell, Material};
use nalgebra::{Matrix3, Vector3};
use quadrature::{Point, TETRAHEDRON_4, tetrahedron_64, wedge_6};

/// Matrices of one element with `n` nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrices {
    /// Number of nodes.
    pub n_nodes: usize,
    /// Stiffness (N/m), `3n x 3n`, row by row, node-major order `3 node + component`.
    pub stiffness: Vec<f64>,
    /// Mass (kg), `n x n`, row by row, the same for all three components.
    pub mass: Vec<f64>,
}

impl Matrices {
    fn zeros(n_nodes: usize) -> Self {
        Self {
            n_nodes,
            stiffness: vec![0.0; 9 * n_nodes * n_nodes],
            mass: vec![0.0; n_nodes * n_nodes],
        }
    }

    /// Adds `factor n_a n_b`.
    fn add_mass(&mut self, values: &[f64], factor: f64) {
        for (a, va) in values.iter().enumerate() {
            for (b, vb) in values.iter().enumerate() {
                self.mass[a * self.n_nodes + b] += factor * va * vb;
            }
        }
    }

    /// Replaces the mass by the sums of its rows.
    fn lump(&mut self) {
        for row in 0..self.n_nodes {
            let entries = &mut self.mass[row * self.n_nodes..(row + 1) * self.n_nodes];
            let sum = entries.iter().sum();
            entries.fill(0.0);
            entries[row] = sum;
        }
    }
}

/// Lame's constants `[lambda, mu]` (Pa).
fn lame(material: &Material) -> [f64; 2] {
    let (e, nu) = (material.youngs_modulus, material.poisson_ratio);
    [e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), 0.5 * e / (1.0 + nu)]
}

/// Adds the stiffness of the strain with the gradients `g` to the leading nodes of a matrix of `3 n` rows, times
/// `weight`.
fn add_stiffness(stiffness: &mut [f64], g: &[Vector3<f64>], [lambda, mu]: [f64; 2], weight: f64) {
    let columns = stiffness.len().isqrt();
    let (lambda, mu) = (lambda * weight, mu * weight);
    for (a, ga) in g.iter().enumerate() {
        for (b, gb) in g.iter().enumerate() {
            let mut block = ga * gb.transpose() * lambda + gb * ga.transpose() * mu;
            let shear = mu * ga.dot(gb);
            for i in 0..3 {
                block[(i, i)] += shear;
                for j in 0..3 {
                    stiffness[(3 * a + i) * columns + 3 * b + j] += block[(i, j)];
                }
            }
        }
    }
}

/// Adds `weight g_a g_b^T`: the stiffness against the volumetric strain `sum g_a . u_a`.
fn add_volumetric(stiffness: &mut [f64], g: &[Vector3<f64>], weight: f64) {
    add_stiffness(stiffness, g, [1.0, 0.0], weight);
}

/// The map to an element from its reference shape, at one point.
struct Jacobian {
    determinant: f64,
    inverse: Matrix3<f64>,
}

impl Jacobian {
    /// `derivatives` are those of the shape functions by the natural coordinates; `element` and `point` are for messages.
    fn try_new(element: usize, point: usize, x: &[[f64; 3]], derivatives: &[[f64; 3]]) -> Result<Self, Error> {
        let mut jacobian = Matrix3::zeros();
        for (x, d) in x.iter().zip(derivatives) {
            jacobian += Vector3::from(*d) * Vector3::from(*x).transpose();
        }
        let determinant = jacobian.determinant();
        match jacobian.try_inverse() {
            Some(inverse) if determinant > 0.0 => Ok(Self { determinant, inverse }),
            _ => Err(Error::InvertedElement {
                element,
                point,
                determinant,
            }),
        }
    }

    /// Gradients of functions with these natural derivatives.
    fn gradients<const N: usize>(&self, derivatives: &[[f64; 3]; N]) -> [Vector3<f64>; N] {
        derivatives.map(|d| self.inverse * Vector3::from(d))
    }
}

/// Values and natural derivatives of shape functions at a point.
type Shape<const N: usize> = ([f64; N], [[f64; 3]; N]);

/// Stiffness and mass of a cell whose nodes are at `x` (m); `element` is its number in messages.
///
/// # Errors
/// [`Error::InvertedElement`] if the Jacobian determinant is not positive at an integration point.
///
/// # Panics
/// If there are not as many points as nodes.
pub fn matrices(element: usize, cell: &Cell, x: &[[f64; 3]], material: &Material) -> Result<Matrices, Error> {
    assert_eq!(x.len(), cell.nodes().len());
    match cell {
        Cell::Hex8(_, formulation) => hex8::matrices(element, x, material, *formulation),
        Cell::Wedge6(_) => isoparametric(element, x, material, wedge6, &wedge_6(), &wedge_6()),
        Cell::Tet4(_) => isoparametric(element, x, material, tet4, &TETRAHEDRON_4, &TETRAHEDRON_4),
        Cell::Tet10(_) => isoparametric(element, x, material, tet10, &TETRAHEDRON_4, &tetrahedron_64()),
    }
}

fn isoparametric<const N: usize>(
    element: usize,
    x: &[[f64; 3]],
    material: &Material,
    shape: fn([f64; 3]) -> Shape<N>,
    stiffness: &[Point],
    mass: &[Point],
) -> Result<Matrices, Error> {
    let mut out = Matrices::zeros(N);
    for (number, point) in stiffness.iter().enumerate() {
        let (_, derivatives) = shape(point.at);
        let jacobian = Jacobian::try_new(element, number, x, &derivatives)?;
        let weight = point.weight * jacobian.determinant;
        add_stiffness(
            &mut out.stiffness,
            &jacobian.gradients(&derivatives),
            lame(material),
            weight,
        );
    }
    for (number, point) in mass.iter().enumerate() {
        let (values, derivatives) = shape(point.at);
        let jacobian = Jacobian::try_new(element, number, x, &derivatives)?;
        out.add_mass(&values, material.density * point.weight * jacobian.determinant);
    }
    Ok(out)
}

/// On the tetrahedron with corners at the origin and at 1 on each axis.
fn tet4([r, s, t]: [f64; 3]) -> Shape<4> {
    (
        [1.0 - r - s - t, r, s, t],
        [[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    )
}

fn tet10(at: [f64; 3]) -> Shape<10> {
    const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
    let (l, d) = tet4(at);
    let mut shape = ([0.0; 10], [[0.0; 3]; 10]);
    for a in 0..4 {
        shape.0[a] = l[a] * (2.0 * l[a] - 1.0);
        shape.1[a] = d[a].map(|d| d * (4.0 * l[a] - 1.0));
    }
    for (e, [a, b]) in EDGES.into_iter().enumerate() {
        shape.0[4 + e] = 4.0 * l[a] * l[b];
        shape.1[4 + e] = [0, 1, 2].map(|i| 4.0 * (l[a] * d[b][i] + d[a][i] * l[b]));
    }
    shape
}

/// On the prism over the triangle with corners at the origin and at 1 on two axes, from -1 to 1 along the third.
fn wedge6([r, s, t]: [f64; 3]) -> Shape<6> {
    let l = [1.0 - r - s, r, s];
    let d = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
    let mut shape = ([0.0; 6], [[0.0; 3]; 6]);
    for (level, sign) in [-1.0, 1.0].into_iter().enumerate() {
        let h = 0.5 * (1.0 + sign * t);
        for a in 0..3 {
            shape.0[3 * level + a] = l[a] * h;
            shape.1[3 * level + a] = [d[a][0] * h, d[a][1] * h, 0.5 * sign * l[a]];
        }
    }
    shape
}
