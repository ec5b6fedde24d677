//! The jump across an interface as coordinates.

use crate::Error;
use sprs::{CsMat, TriMat};
use substructure::assemble::System;
use substructure::sparse::{congruence, multiply_vector, numbering, submatrix};

/// Which nodes face each other, and the axes in which their jump is measured.
#[derive(Clone, Copy, Debug)]
pub struct InterfacePairs<'a> {
    /// Nodes of the top side.
    pub top: &'a [u32],
    /// Nodes of the bottom side, in the same order.
    pub bottom: &'a [u32],
    /// Unit vectors x, y (in the plane) and n (from the top body into the bottom body).
    pub frame: [[f64; 3]; 3],
}

/// A system in the coordinates `[jump; rest]`, where `u_top = jump + u_bottom` (eq. 30 of Balaji, Chen and Brake 2020).
#[derive(Clone, Debug)]
pub struct RelativeSystem {
    /// Stiffness over `[jump; rest]` (N/m).
    pub stiffness: CsMat<f64>,
    /// Mass over `[jump; rest]` (kg).
    pub mass: CsMat<f64>,
    /// Loads over `[jump; rest]` (N).
    pub loads: Vec<Vec<f64>>,
    /// Number of jump coordinates: three per pair, pair-major, in the order x, y, n.
    pub n_relative: usize,
    /// Position of each coordinate's node (m).
    pub positions: Vec<[f64; 3]>,
    /// `u = transform * [jump; rest]` over the independent components of the system.
    pub(crate) transform: CsMat<f64>,
}

/// The four blocks of a symmetric matrix over `[jump; rest]`.
pub(crate) struct Blocks {
    pub(crate) jump: CsMat<f64>,
    pub(crate) jump_rest: CsMat<f64>,
    pub(crate) rest: CsMat<f64>,
}

impl RelativeSystem {
    /// Changes the coordinates of a system.
    ///
    /// # Errors
    /// Pairs that do not match, do not coincide, or are not free; axes that are not orthonormal.
    pub fn try_new(system: &System, pairs: InterfacePairs<'_>) -> Result<Self, Error> {
        let (top, bottom, frame) = (pairs.top, pairs.bottom, pairs.frame);
        if top.len() != bottom.len() || top.is_empty() {
            return Err(Error::PairCount {
                top: top.len(),
                bottom: bottom.len(),
            });
        }
        let mut deviation = 0.0_f64;
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|c| frame[i][c] * frame[j][c]).sum();
                deviation = deviation.max((product - f64::from(u8::from(i == j))).abs());
            }
        }
        // `!(a <= b)` also catches NaN.
        if !(deviation <= 1e-12) {
            return Err(Error::Frame { deviation });
        }
        let n = system.n_dofs();
        let n_relative = 3 * top.len();
        let place = |node: u32, component: u8| {
            let known = (node as usize) < system.dofs.coordinates.len();
            known
                .then(|| system.dofs.independent_index(node, component))
                .flatten()
                .ok_or(Error::DependentInterface { node, component })
        };
        let mut top_index = vec![None; n];
        let mut bottom_index = vec![0; n_relative];
        for (pair, (&t, &b)) in top.iter().zip(bottom).enumerate() {
            for component in 0..3_u8 {
                top_index[place(t, component)?] = Some(3 * pair + component as usize);
                bottom_index[3 * pair + component as usize] = place(b, component)?;
            }
        }
        let coordinates = |node: u32| system.dofs.coordinates[node as usize];
        let distance = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        let origin = coordinates(top[0]);
        let size = top
            .iter()
            .map(|&node| distance(coordinates(node), origin))
            .fold(0.0, f64::max);
        for (pair, (&t, &b)) in top.iter().zip(bottom).enumerate() {
            let apart = distance(coordinates(t), coordinates(b));
            if !(apart <= 1e-6 * size) {
                return Err(Error::PairApart {
                    pair,
                    top: t,
                    bottom: b,
                    distance: apart,
                });
            }
        }
        let rest: Vec<usize> = (0..n).filter(|&dof| top_index[dof].is_none()).collect();
        let column = numbering(&rest, n);
        let mut transform = TriMat::with_capacity((n, n), n + 4 * n_relative);
        let mut positions = vec![[0.0; 3]; n];
        for dof in 0..n {
            let Some(jump) = top_index[dof] else {
                if let Some(at) = column[dof] {
                    transform.add_triplet(dof, n_relative + at, 1.0);
                    positions[n_relative + at] = system.positions[dof];
                }
                continue;
            };
            let component = jump % 3;
            for (axis, direction) in frame.iter().enumerate() {
                if direction[component] != 0.0 {
                    transform.add_triplet(dof, jump - component + axis, direction[component]);
                }
            }
            positions[jump] = system.positions[dof];
            // A bottom component listed as a top one too would have no column of its own.
            let at = column[bottom_index[jump]].ok_or(Error::DependentInterface {
                node: bottom[jump / 3],
                component: component as u8,
            })?;
            transform.add_triplet(dof, n_relative + at, 1.0);
        }
        let transform: CsMat<f64> = transform.to_csr();
        let transposed: CsMat<f64> = transform.transpose_view().to_csr();
        Ok(Self {
            stiffness: congruence(&transform, &system.stiffness),
            mass: congruence(&transform, &system.mass),
            loads: system
                .loads
                .iter()
                .map(|load| multiply_vector(&transposed, load))
                .collect(),
            n_relative,
            positions,
            transform,
        })
    }

    /// A row over the independent components of the system (for example a response), over `[jump; rest]` instead.
    pub fn row(&self, over_independent: &[f64]) -> Vec<f64> {
        multiply_vector(&self.transform.transpose_view().to_csr(), over_independent)
    }

    pub(crate) fn blocks(&self, matrix: &CsMat<f64>) -> Blocks {
        let n = matrix.rows();
        let (jump, rest): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| i < self.n_relative);
        let (jump_column, rest_column) = (numbering(&jump, n), numbering(&rest, n));
        Blocks {
            jump: submatrix(matrix, &jump, &jump_column, jump.len()),
            jump_rest: submatrix(matrix, &jump, &rest_column, rest.len()),
            rest: submatrix(matrix, &rest, &rest_column, rest.len()),
        }
    }
}
