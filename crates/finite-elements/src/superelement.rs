//! Bodies that come as matrices of another program, over displacements of some nodes and inner coordinates.

use crate::Error;
use crate::constraints::DofMap;
use dense_algebra::{cholesky, product, solve_lower, solve_lower_transposed, symmetric_eigen};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use sprs::{CsMat, TriMat};
use std::collections::{BTreeSet, HashMap};

/// Share of its terms in the energy of a rigid motion, up to which it is round-off of the matrices and of the positions of the nodes.
const RESISTED: f64 = 1e-5;

/// Most coordinates of one: its matrices are filled for a moment.
const MOST: usize = 6000;

/// Smallest part of a rigid motion that the nodes must show, relative to the largest.
const SEEN: f64 = 1e-6;

/// A body by its stiffness and mass, reduced elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Superelement {
    /// Name used in messages.
    pub name: String,
    /// Of each coordinate the displacement component (0..3) of a node that it is. None of an inner coordinate: a retained mode, a rotation, or a
    /// displacement of a node that the mesh does not have.
    pub coordinates: Vec<Option<(u32, u8)>>,
    /// Stiffness, symmetric (N/m of displacements).
    pub stiffness: CsMat<f64>,
    /// Mass, symmetric (kg of displacements).
    pub mass: CsMat<f64>,
    /// Whether supports of its own are in the stiffness. Otherwise it must let the nodes move rigidly.
    pub is_held: bool,
}

impl Superelement {
    /// Coordinates that are no displacements of the mesh.
    pub fn n_inner(&self) -> usize {
        self.coordinates.iter().filter(|at| at.is_none()).count()
    }

    /// Nodes of the mesh that it moves with, in ascending order.
    pub fn nodes(&self) -> Vec<u32> {
        let nodes: BTreeSet<u32> = self.coordinates.iter().flatten().map(|(node, _)| *node).collect();
        nodes.into_iter().collect()
    }

    /// Its translations and its turns about the middle of its nodes, in their size, as [`Self::in_rigid_motions`] takes them.
    pub(crate) fn motions(&self, positions: &[[f64; 3]]) -> impl Fn(u32, u8) -> [f64; 6] {
        let nodes = self.nodes();
        let at: Vec<Vector3<f64>> = (nodes.iter().filter_map(|&node| positions.get(node as usize)))
            .map(|x| Vector3::from(*x))
            .collect();
        let centre = at.iter().sum::<Vector3<f64>>() / at.len().max(1) as f64;
        let size = at
            .iter()
            .map(|x| (x - centre).norm())
            .fold(0.0, f64::max)
            .max(f64::MIN_POSITIVE);
        let of: HashMap<u32, Vector3<f64>> = nodes
            .into_iter()
            .zip(at.into_iter().map(move |x| (x - centre) / size))
            .collect();
        move |node, component| {
            let turn = of.get(&node).map_or_else(Matrix3::zeros, |arm| -arm.cross_matrix());
            let component = usize::from(component);
            std::array::from_fn(|motion| match motion.checked_sub(3) {
                None => f64::from(u8::from(motion == component)),
                Some(axis) => turn[(component, axis)],
            })
        }
    }

    fn fail(&self, reason: impl Into<String>) -> Error {
        Error::Superelement {
            superelement: self.name.clone(),
            reason: reason.into(),
        }
    }

    /// Its coordinates from the independent ones; `first_inner` is its first inner coordinate, counted as in [`DofMap::independent`].
    pub(crate) fn transform(&self, dofs: &DofMap, first_inner: usize) -> CsMat<f64> {
        let mut inner = first_inner..;
        let mut entries = TriMat::new((self.coordinates.len(), dofs.independent.len()));
        for (row, at) in self.coordinates.iter().enumerate() {
            let full = at.map_or_else(
                || inner.next().unwrap_or(first_inner),
                |(node, component)| 3 * node as usize + usize::from(component),
            );
            for (column, &value) in dofs.row(full) {
                entries.add_triplet(row, column, value);
            }
        }
        entries.to_csr()
    }

    /// What it does in rigid motions, of which `of` gives the six amounts in each displacement component of a node.
    ///
    /// # Errors
    /// [`Error::Superelement`] for matrices, nodes and coordinates that make no body.
    pub(crate) fn in_rigid_motions(&self, n_nodes: usize, of: impl Fn(u32, u8) -> [f64; 6]) -> Result<Rigid, Error> {
        self.validate(n_nodes)?;
        let n = self.coordinates.len();
        let mut motions = Mat::<f64>::zeros(n, 6);
        for (row, at) in self.coordinates.iter().enumerate() {
            let amounts = at.map_or([0.0; 6], |(node, component)| of(node, component));
            (0..6).for_each(|motion| motions[(row, motion)] = amounts[motion]);
        }
        let seen = symmetric_eigen(product(motions.transpose(), motions.as_ref()).as_ref())?.0;
        if !(seen[0] > SEEN * SEEN * seen[5]) {
            return Err(self.fail(
                "its nodes in the mesh are too few, or lie in a line, so that it could turn without them; keep three or more displacements at three or \
                 more nodes",
            ));
        }
        let inner: Vec<usize> = (0..n).filter(|&row| self.coordinates[row].is_none()).collect();
        if !inner.is_empty() {
            // Inner coordinates follow without force.
            let own = dense(&self.stiffness);
            let lower = cholesky(Mat::from_fn(inner.len(), inner.len(), |i, j| own[(inner[i], inner[j])]).as_ref())
                .map_err(|_| {
                    self.fail(
                        "its stiffness does not hold its inner coordinates where its nodes are held; leave rigid modes out of it, and give the nodes of \
                         the mesh that it is joined to the labels that they have in its map of degrees of freedom",
                    )
                })?;
            let force = product(own.as_ref(), motions.as_ref());
            let mut follow = Mat::from_fn(inner.len(), 6, |i, motion| -force[(inner[i], motion)]);
            solve_lower(lower.as_ref(), follow.as_mut());
            solve_lower_transposed(lower.as_ref(), follow.as_mut());
            for (i, &row) in inner.iter().enumerate() {
                (0..6).for_each(|motion| motions[(row, motion)] = follow[(i, motion)]);
            }
        }
        let energies = |matrix: &CsMat<f64>| {
            Mat::from_fn(6, 6, |i, j| {
                let terms = matrix.iter();
                terms
                    .map(|(value, (row, column))| motions[(row, i)] * value * motions[(column, j)])
                    .sum::<f64>()
            })
        };
        let terms = self.stiffness.iter();
        let size = terms.fold([0.0; 6], |sum: [f64; 6], (value, (row, column))| {
            std::array::from_fn(|i| sum[i] + (motions[(row, i)] * value * motions[(column, i)]).abs())
        });
        let energy = energies(&self.stiffness);
        let scaled = Mat::from_fn(6, 6, |i, j| {
            energy[(i, j)] / (size[i] * size[j]).sqrt().max(f64::MIN_POSITIVE)
        });
        let (shares, directions) = symmetric_eigen(scaled.as_ref())?;
        let resisted = (0..6)
            .filter(|&at| shares[at] > RESISTED)
            .map(|at| std::array::from_fn(|i| directions[(i, at)] * size[i].sqrt()));
        let resisted: Vec<[f64; 6]> = resisted.collect();
        if !self.is_held && !resisted.is_empty() {
            return Err(self.fail(format!(
                "its stiffness resists {} of six rigid motions of its nodes, with up to {:.0e} of the terms that should cancel: either its nodes have \
                 other labels or another unit of length than those of the mesh, or it is held by supports of its own, which `held` must say",
                resisted.len(),
                shares[5]
            )));
        }
        let momenta = product(dense(&self.mass).as_ref(), motions.as_ref());
        Ok(Rigid {
            resisted,
            mass: std::array::from_fn(|axis| (0..n).map(|row| motions[(row, axis)] * momenta[(row, axis)]).sum()),
            momenta: std::array::from_fn(|axis| momenta.col(axis).iter().copied().collect()),
        })
    }

    /// # Errors
    /// [`Error::Superelement`].
    pub(crate) fn validate(&self, n_nodes: usize) -> Result<(), Error> {
        let n = self.coordinates.len();
        if n > MOST {
            return Err(self.fail(format!(
                "it has {n} coordinates, and at most {MOST} are taken; reduce it to the nodes that it is joined by and some of its modes"
            )));
        }
        for (what, matrix) in [("stiffness", &self.stiffness), ("mass", &self.mass)] {
            if matrix.shape() != (n, n) || !matrix.is_csr() {
                return Err(self.fail(format!("its {what} is {:?} instead of {n} x {n}", matrix.shape())));
            }
            if let Some(value) = matrix.data().iter().find(|value| !value.is_finite()) {
                return Err(self.fail(format!("its {what} has the entry {value}")));
            }
        }
        let mut known = BTreeSet::new();
        for &(node, component) in self.coordinates.iter().flatten() {
            if node as usize >= n_nodes || component > 2 {
                return Err(self.fail(format!("component {component} of node {node} is not in the mesh")));
            }
            if !known.insert((node, component)) {
                return Err(self.fail(format!(
                    "component {component} of node {node} is two of its coordinates"
                )));
            }
        }
        Ok(())
    }
}

/// What a superelement does in rigid motions.
pub(crate) struct Rigid {
    /// Combinations of the six motions that it holds at zero.
    pub(crate) resisted: Vec<[f64; 6]>,
    /// Mass in each of the first three motions, the translations (kg).
    pub(crate) mass: [f64; 3],
    /// Momenta of its coordinates per velocity of these (kg).
    pub(crate) momenta: [Vec<f64>; 3],
}

fn dense(matrix: &CsMat<f64>) -> Mat<f64> {
    let mut found = Mat::zeros(matrix.rows(), matrix.cols());
    matrix
        .iter()
        .for_each(|(value, (row, column))| found[(row, column)] = *value);
    found
}
