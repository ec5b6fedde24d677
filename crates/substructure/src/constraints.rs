//! Ties, distributing couplings and equations, turned into one map from independent to all displacement components.

use crate::Error;
use crate::mesh::{Assembly, DistributingCoupling, Dof, Tie};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use sprs::{CsMat, TriMat};
use std::collections::BTreeMap;

/// A linear combination of nodal displacement components `3 node + component`.
type Combination = Vec<(usize, f64)>;

/// The map from independent displacement components to all of them.
#[derive(Clone, Debug)]
pub struct DofMap {
    /// `u_all = transform * u`, shape `3 n_nodes x n_independent`.
    pub transform: CsMat<f64>,
    /// For each independent component, `3 node + component` of the displacement it stands for.
    pub independent: Vec<usize>,
    /// Node coordinates after slaves were moved onto the surfaces they are tied to (m).
    pub coordinates: Vec<[f64; 3]>,
    /// The largest such move (m).
    pub largest_adjustment: f64,
}

impl DofMap {
    /// Index among the independent components of `component` of `node`, or `None` if it is dependent.
    pub fn independent_index(&self, node: u32, component: u8) -> Option<usize> {
        self.independent
            .binary_search(&(3 * node as usize + component as usize))
            .ok()
    }

    /// Position of the node of each independent component (m).
    pub fn positions(&self) -> Vec<[f64; 3]> {
        self.independent.iter().map(|dof| self.coordinates[dof / 3]).collect()
    }

    /// Force over the independent components of unit actions at the given components of the assembly.
    ///
    /// # Errors
    /// As [`DofMap::try_new`] for references that do not exist.
    pub fn force(&self, assembly: &Assembly, place: &str, terms: &[(Dof, f64)]) -> Result<Vec<f64>, Error> {
        let mut force = vec![0.0; self.independent.len()];
        for &(dof, value) in terms {
            for (full, coefficient) in expand(assembly, &self.coordinates, place, dof)? {
                for (column, &entry) in self.row(full) {
                    force[column] += value * coefficient * entry;
                }
            }
        }
        Ok(force)
    }

    /// Entries of the transform's row for `3 node + component`.
    pub fn row(&self, full: usize) -> impl Iterator<Item = (usize, &f64)> {
        let range = self.transform.indptr().outer_inds_sz(full);
        self.transform.indices()[range.clone()]
            .iter()
            .copied()
            .zip(&self.transform.data()[range])
    }

    /// Collects the constraints of an assembly and eliminates the dependent components.
    ///
    /// Ties go first (each slave component depends on the nodes of its master face); each equation then eliminates
    /// the component with its largest remaining coefficient.
    ///
    /// # Errors
    /// Dangling references, slaves out of tolerance, components made dependent twice, redundant or circular
    /// constraints, couplings that do not define a rigid motion.
    pub fn try_new(assembly: &Assembly) -> Result<Self, Error> {
        let mut coordinates = assembly.mesh.nodes.clone();
        let mut dependent: BTreeMap<usize, Combination> = BTreeMap::new();
        let mut largest_adjustment = 0.0_f64;
        for tie in &assembly.ties {
            largest_adjustment = largest_adjustment.max(insert_tie(tie, &mut coordinates, &mut dependent)?);
        }
        for equation in &assembly.equations {
            let mut expression = BTreeMap::new();
            for &(dof, coefficient) in &equation.terms {
                if !coefficient.is_finite() {
                    return Err(Error::NotFinite {
                        place: format!("equation `{}`", equation.name),
                        value: coefficient,
                    });
                }
                for (full, factor) in expand(assembly, &coordinates, &equation.name, dof)? {
                    *expression.entry(full).or_insert(0.0) += coefficient * factor;
                }
            }
            let scale = largest(&expression);
            substitute(&mut expression, &dependent)?;
            let Some((&pivot, &coefficient)) = expression
                .iter()
                // The first of equal candidates, so that round-off in the last digit cannot change the choice.
                .reduce(|best, next| {
                    if next.1.abs() > best.1.abs() * (1.0 + 1e-9) {
                        next
                    } else {
                        best
                    }
                })
                .filter(|(_, value)| value.abs() > 1e-10 * scale)
            else {
                return Err(Error::RedundantEquation {
                    equation: equation.name.clone(),
                });
            };
            expression.remove(&pivot);
            dependent.insert(
                pivot,
                expression.into_iter().map(|(dof, c)| (dof, -c / coefficient)).collect(),
            );
        }
        let n_full = 3 * coordinates.len();
        let independent: Vec<usize> = (0..n_full).filter(|dof| !dependent.contains_key(dof)).collect();
        let mut column = vec![usize::MAX; n_full];
        for (index, &dof) in independent.iter().enumerate() {
            column[dof] = index;
        }
        let mut triplets = TriMat::with_capacity((n_full, independent.len()), n_full);
        for dof in 0..n_full {
            if column[dof] != usize::MAX {
                triplets.add_triplet(dof, column[dof], 1.0);
                continue;
            }
            let mut expression: BTreeMap<usize, f64> = dependent[&dof].iter().copied().collect();
            substitute(&mut expression, &dependent)?;
            for (&master, &coefficient) in &expression {
                triplets.add_triplet(dof, column[master], coefficient);
            }
        }
        Ok(Self {
            transform: triplets.to_csr(),
            independent,
            coordinates,
            largest_adjustment,
        })
    }
}

fn largest(expression: &BTreeMap<usize, f64>) -> f64 {
    expression.values().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// Replaces dependent components until only independent ones are left, and drops round-off.
fn substitute(expression: &mut BTreeMap<usize, f64>, dependent: &BTreeMap<usize, Combination>) -> Result<(), Error> {
    let scale = largest(expression);
    // A chain longer than the number of constraints must contain a circle.
    for _ in 0..=dependent.len() {
        let found: Vec<usize> = expression
            .keys()
            .copied()
            .filter(|dof| dependent.contains_key(dof))
            .collect();
        if found.is_empty() {
            expression.retain(|_, value| value.abs() > 1e-14 * scale);
            return Ok(());
        }
        for dof in found {
            let value = expression.remove(&dof).unwrap_or(0.0);
            for &(master, coefficient) in &dependent[&dof] {
                *expression.entry(master).or_insert(0.0) += value * coefficient;
            }
        }
    }
    let dof = expression
        .keys()
        .copied()
        .find(|dof| dependent.contains_key(dof))
        .unwrap_or(0);
    Err(Error::CircularConstraint {
        node: (dof / 3) as u32,
        component: (dof % 3) as u8,
    })
}

/// One component of the assembly in terms of nodal displacement components.
fn expand(assembly: &Assembly, coordinates: &[[f64; 3]], place: &str, dof: Dof) -> Result<Combination, Error> {
    let dangling = |what, index, count| Error::Dangling {
        place: format!("`{place}`"),
        what,
        index,
        count,
    };
    match dof {
        Dof::Node(node, component) => {
            if node as usize >= coordinates.len() {
                return Err(dangling("node", node as usize, coordinates.len()));
            }
            if component > 2 {
                return Err(dangling("displacement component", component as usize, 3));
            }
            Ok(vec![(3 * node as usize + component as usize, 1.0)])
        }
        Dof::Reference(index, component) => {
            let count = assembly.couplings.len();
            let coupling = assembly
                .couplings
                .get(index as usize)
                .ok_or_else(|| dangling("coupling", index as usize, count))?;
            if component > 5 {
                return Err(dangling("motion component", component as usize, 6));
            }
            reference_motion(coupling, coordinates, component as usize)
        }
    }
}

/// Mean translation or rotation of a cloud of nodes (weighted least squares), at the reference point.
///
/// With centroid `c`, arms `r_i = x_i - c` and `I = sum w_i (|r_i|^2 1 - r_i r_i^T)`:
/// `theta = I^-1 sum w_i r_i x u_i`, `u_ref = sum w_i u_i + theta x (x_ref - c)`.
fn reference_motion(
    coupling: &DistributingCoupling,
    coordinates: &[[f64; 3]],
    component: usize,
) -> Result<Combination, Error> {
    let fail = |reason| Error::Coupling {
        coupling: coupling.name.clone(),
        reason,
    };
    if coupling.nodes.len() != coupling.weights.len() || coupling.nodes.is_empty() {
        return Err(fail("it needs one weight per node and at least one node"));
    }
    if !coupling.weights.iter().all(|w| w.is_finite() && *w > 0.0) {
        return Err(fail("every weight must be positive and finite"));
    }
    if let Some(&node) = coupling.nodes.iter().find(|&&node| node as usize >= coordinates.len()) {
        return Err(Error::Dangling {
            place: format!("coupling `{}`", coupling.name),
            what: "node",
            index: node as usize,
            count: coordinates.len(),
        });
    }
    let total: f64 = coupling.weights.iter().sum();
    let cloud = || {
        coupling
            .nodes
            .iter()
            .zip(&coupling.weights)
            .map(|(&node, w)| (node as usize, Vector3::from(coordinates[node as usize]), w / total))
    };
    let centroid = cloud().fold(Vector3::zeros(), |sum, (_, x, w)| sum + x * w);
    let inertia = cloud().fold(Matrix3::zeros(), |sum, (_, x, w)| {
        let r = x - centroid;
        sum + (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * w
    });
    let eigenvalues = inertia.symmetric_eigenvalues();
    let inverse = inertia
        .try_inverse()
        .filter(|_| eigenvalues.min() > 1e-10 * eigenvalues.max())
        .ok_or_else(|| fail("its nodes lie on one line, so that no rotation is defined"))?;
    // `action` picks the motion: row of theta = I^-1 (r x u), or of u_ref = u + theta x d.
    let arm = Vector3::from(coupling.reference) - centroid;
    let mut combination = Vec::with_capacity(3 * coupling.nodes.len());
    for (node, x, w) in cloud() {
        let rotation = inverse * (x - centroid).cross_matrix() * w;
        let row = if component < 3 {
            (Matrix3::identity() * w - arm.cross_matrix() * rotation)
                .row(component)
                .into_owned()
        } else {
            rotation.row(component - 3).into_owned()
        };
        combination.extend((0..3).map(|i| (3 * node + i, row[i])));
    }
    Ok(combination)
}

/// Makes the slaves of a tie dependent and moves them onto their faces; returns the largest move.
fn insert_tie(
    tie: &Tie,
    coordinates: &mut [[f64; 3]],
    dependent: &mut BTreeMap<usize, Combination>,
) -> Result<f64, Error> {
    let place = || format!("tie `{}`", tie.name);
    let all = tie.slave_nodes.iter().chain(tie.master_faces.iter().flatten());
    if let Some(&node) = all.clone().find(|&&node| node as usize >= coordinates.len()) {
        return Err(Error::Dangling {
            place: place(),
            what: "node",
            index: node as usize,
            count: coordinates.len(),
        });
    }
    let mut largest = 0.0_f64;
    for &slave in &tie.slave_nodes {
        let x = Vector3::from(coordinates[slave as usize]);
        let feet = tie.master_faces.iter().map(|&face| {
            let corners = face.map(|node| Vector3::from(coordinates[node as usize]));
            let (weights, foot) = project(x, &corners);
            ((foot - x).norm(), weights, face, foot)
        });
        let nearest = feet.min_by(|a, b| a.0.total_cmp(&b.0));
        let (distance, weights, face, foot) = nearest.unwrap_or((f64::INFINITY, [0.0; 4], [0; 4], x));
        if distance > tie.position_tolerance {
            return Err(Error::TieTooFar {
                tie: tie.name.clone(),
                node: slave,
                distance,
                tolerance: tie.position_tolerance,
            });
        }
        largest = largest.max(distance);
        coordinates[slave as usize] = foot.into();
        for component in 0..3 {
            let masters = face.iter().zip(weights).filter(|(_, weight)| *weight != 0.0);
            let combination = masters
                .map(|(&node, weight)| (3 * node as usize + component, weight))
                .collect();
            if dependent.insert(3 * slave as usize + component, combination).is_some() {
                return Err(Error::DependentTwice {
                    place: tie.name.clone(),
                    node: slave,
                    component: component as u8,
                });
            }
        }
    }
    Ok(largest)
}

/// Nearest point of a bilinear face: shape-function weights and position.
fn project(x: Vector3<f64>, corners: &[Vector3<f64>; 4]) -> ([f64; 4], Vector3<f64>) {
    let weights = |s: Vector2<f64>| {
        let (a, b) = (s.x, s.y);
        [
            0.25 * (1.0 - a) * (1.0 - b),
            0.25 * (1.0 + a) * (1.0 - b),
            0.25 * (1.0 + a) * (1.0 + b),
            0.25 * (1.0 - a) * (1.0 + b),
        ]
    };
    let at = |s| {
        weights(s)
            .iter()
            .zip(corners)
            .fold(Vector3::zeros(), |sum, (w, c)| sum + c * *w)
    };
    let mut s = Vector2::zeros();
    for _ in 0..30 {
        let ds = ((corners[1] - corners[0]) * (1.0 - s.y) + (corners[2] - corners[3]) * (1.0 + s.y)) * 0.25;
        let dt = ((corners[3] - corners[0]) * (1.0 - s.x) + (corners[2] - corners[1]) * (1.0 + s.x)) * 0.25;
        let gap = x - at(s);
        let normal = Matrix2::new(ds.dot(&ds), ds.dot(&dt), ds.dot(&dt), dt.dot(&dt));
        let Some(inverse) = normal.try_inverse() else { break };
        let step = inverse * Vector2::new(ds.dot(&gap), dt.dot(&gap));
        let next = (s + step).map(|v| v.clamp(-1.0, 1.0));
        let moved = (next - s).norm();
        s = next;
        if moved < 1e-14 {
            break;
        }
    }
    (weights(s), at(s))
}
