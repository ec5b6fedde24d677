//! Stiffness and mass of one element.

use crate::Error;
use crate::material::Material;
use nalgebra::{Matrix3, Vector3};

/// An element where it stands.
pub(crate) struct Place<'a> {
    /// Its number, for messages.
    pub(super) element: usize,
    /// Positions of its nodes (m).
    pub(super) x: &'a [[f64; 3]],
    pub(super) material: &'a Material,
}

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
    pub(super) fn zeros(n_nodes: usize) -> Self {
        Self {
            n_nodes,
            stiffness: vec![0.0; 9 * n_nodes * n_nodes],
            mass: vec![0.0; n_nodes * n_nodes],
        }
    }

    /// Adds `factor n_a n_b`.
    pub(super) fn add_mass(&mut self, values: &[f64], factor: f64) {
        for (a, va) in values.iter().enumerate() {
            for (b, vb) in values.iter().enumerate() {
                self.mass[a * self.n_nodes + b] += factor * va * vb;
            }
        }
    }

    /// Replaces the mass by the sums of its rows.
    pub(super) fn lump(&mut self) {
        for row in 0..self.n_nodes {
            let entries = &mut self.mass[row * self.n_nodes..(row + 1) * self.n_nodes];
            let sum = entries.iter().sum();
            entries.fill(0.0);
            entries[row] = sum;
        }
    }
}

/// Adds the stiffness of the strain with the gradients `g` to the leading nodes of a matrix of `3 n` rows, times
/// `weight`.
pub(super) fn add_stiffness(stiffness: &mut [f64], g: &[Vector3<f64>], [lambda, mu]: [f64; 2], weight: f64) {
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
pub(super) fn add_volumetric(stiffness: &mut [f64], g: &[Vector3<f64>], weight: f64) {
    add_stiffness(stiffness, g, [1.0, 0.0], weight);
}

/// The map to an element from its reference shape, at one point.
pub(super) struct Jacobian {
    pub(super) determinant: f64,
    pub(super) inverse: Matrix3<f64>,
}

impl Jacobian {
    /// `derivatives` are those of the shape functions by the natural coordinates; `point` is for messages.
    pub(super) fn try_new(place: &Place<'_>, point: usize, derivatives: &[[f64; 3]]) -> Result<Self, Error> {
        let mut jacobian = Matrix3::zeros();
        for (x, d) in place.x.iter().zip(derivatives) {
            jacobian += Vector3::from(*d) * Vector3::from(*x).transpose();
        }
        let determinant = jacobian.determinant();
        match jacobian.try_inverse() {
            Some(inverse) if determinant > 0.0 => Ok(Self { determinant, inverse }),
            _ => Err(Error::InvertedElement {
                element: place.element,
                point,
                determinant,
            }),
        }
    }

    /// Gradient of a function with this natural derivative.
    pub(super) fn gradient(&self, derivative: [f64; 3]) -> Vector3<f64> {
        self.inverse * Vector3::from(derivative)
    }
}
