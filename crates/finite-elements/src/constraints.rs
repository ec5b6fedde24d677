//! Ties, couplings and equations, turned into one map from independent to all displacement components.

use crate::Error;
use crate::mesh::{Assembly, BeyondTolerance, Coupling, CouplingKind, Cut, Dof, Face, Tie};
use faer::Mat;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use sprs::{CsMat, TriMat};
use std::collections::BTreeMap;

/// A linear combination of components: `3 node + component` of the nodes, six of each coupling's reference point, one of each
/// overlap.
type Combination = Vec<(usize, f64)>;

/// The map from independent displacement components to all of them.
#[derive(Clone, Debug)]
pub struct DofMap {
    /// `u_nodes = transform * u`, shape `3 n_nodes x n_independent`.
    pub transform: CsMat<f64>,
    /// Motions of the reference points of kinematic couplings (m, rad), the overlaps of shanks and cuts (m) and inner coordinates of superelements:
    /// `u_reference = references * u`, shape `(6 n_couplings + n_pretensions + n_inner) x n_independent`. Rows of distributing couplings
    /// are empty: their reference points follow the nodes.
    references: CsMat<f64>,
    /// For each independent component `3 node + component` of the displacement that it stands for, or, beyond the nodes,
    /// `3 n_nodes + 6 coupling + component` of a kinematic coupling's reference point, then `3 n_nodes + 6 n_couplings +
    /// pretension` of an overlap, and after these the inner coordinates of superelements.
    pub independent: Vec<usize>,
    /// Node coordinates after slaves were moved onto the surfaces they are tied to (m).
    pub coordinates: Vec<[f64; 3]>,
    /// The largest such move (m).
    pub largest_adjustment: f64,
    /// Slaves that were left free beyond the tolerance of their tie: number of the tie, node, distance (m).
    pub untied: Vec<(usize, u32, f64)>,
    /// Position of each independent component (m).
    pub positions: Vec<[f64; 3]>,
    n_couplings: usize,
}

impl DofMap {
    /// Index among the independent components of `component` of `node`, or `None` if it is dependent.
    pub fn independent_index(&self, node: u32, component: u8) -> Option<usize> {
        self.independent
            .binary_search(&(3 * node as usize + component as usize))
            .ok()
    }

    /// Unit translations along the axes, and unit rotations about them through a centre, over the independent components. Overlaps of bolts do not
    /// move; how inner coordinates of superelements do is not known.
    pub fn rigid_motions(&self, centre: [f64; 3]) -> Mat<f64> {
        let n_nodal = 3 * self.coordinates.len();
        let mut motions = Mat::zeros(self.independent.len(), 6);
        for (row, (&full, at)) in self.independent.iter().zip(&self.positions).enumerate() {
            let component = match full.checked_sub(n_nodal) {
                None => full % 3,
                Some(beyond) if beyond < 6 * self.n_couplings => beyond % 6,
                Some(_) => continue,
            };
            motions[(row, component)] = 1.0;
            if component >= 3 {
                continue;
            }
            // A rotation about axis k moves the components next to it by its arms.
            let [next, last] = [(component + 1) % 3, (component + 2) % 3];
            motions[(row, 3 + next)] = at[last] - centre[last];
            motions[(row, 3 + last)] = -(at[next] - centre[next]);
        }
        motions
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

    /// What a component of the assembly is of the independent ones, in ascending order.
    ///
    /// # Errors
    /// As [`DofMap::try_new`] for references that do not exist.
    pub(crate) fn combination(&self, assembly: &Assembly, place: &str, dof: Dof) -> Result<Vec<(usize, f64)>, Error> {
        let mut sum = BTreeMap::new();
        for (full, coefficient) in expand(assembly, &self.coordinates, place, dof)? {
            for (column, &entry) in self.row(full) {
                *sum.entry(column).or_insert(0.0) += coefficient * entry;
            }
        }
        Ok(sum.into_iter().collect())
    }

    /// What the component `full` is of the independent ones, counted as in [`Self::independent`].
    pub fn row(&self, full: usize) -> impl Iterator<Item = (usize, &f64)> {
        let (of, row) = match full.checked_sub(self.transform.rows()) {
            None => (&self.transform, full),
            Some(beyond) => (&self.references, beyond),
        };
        let range = of.indptr().outer_inds_sz(row);
        of.indices()[range.clone()].iter().copied().zip(&of.data()[range])
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
        let Tied {
            coordinates,
            mut dependent,
            largest_adjustment,
            untied,
        } = Tied::try_new(assembly)?;
        for (index, coupling) in assembly.couplings.iter().enumerate() {
            check_cloud(coupling, &coordinates)?;
            if let CouplingKind::Kinematic(components) = &coupling.kind {
                insert_kinematic(index, coupling, *components, &coordinates, &mut dependent)?;
            }
        }
        for (index, cut) in assembly.cuts.iter().enumerate() {
            let overlap = 3 * coordinates.len() + 6 * assembly.couplings.len() + assembly.shanks.len() + index;
            insert_cut(overlap, cut, coordinates.len(), &mut dependent)?;
        }
        for &support in &assembly.supports {
            let combination = expand(assembly, &coordinates, "supports", support)?;
            // A support of what cannot move anyway is no contradiction.
            eliminate(combination, &mut dependent)?;
        }
        for equation in &assembly.equations {
            let mut combination = Combination::new();
            for &(dof, coefficient) in &equation.terms {
                if !coefficient.is_finite() {
                    return Err(Error::NotFinite {
                        place: format!("equation `{}`", equation.name),
                        value: coefficient,
                    });
                }
                let terms = expand(assembly, &coordinates, &equation.name, dof)?;
                combination.extend(terms.into_iter().map(|(full, factor)| (full, coefficient * factor)));
            }
            if !eliminate(combination, &mut dependent)? {
                return Err(Error::RedundantEquation {
                    equation: equation.name.clone(),
                });
            }
        }
        let n_nodal = 3 * coordinates.len();
        let n_beyond_nodes = n_nodal + 6 * assembly.couplings.len();
        let references: Vec<usize> = assembly
            .couplings
            .iter()
            .enumerate()
            .filter(|(_, coupling)| matches!(coupling.kind, CouplingKind::Kinematic(_)))
            .flat_map(|(index, _)| (0..6).map(move |c| n_nodal + 6 * index + c))
            .chain(n_beyond_nodes..n_beyond_nodes + assembly.n_pretensions() + assembly.n_inner())
            .collect();
        let independent: Vec<usize> = (0..n_nodal)
            .chain(references.iter().copied())
            .filter(|dof| !dependent.contains_key(dof))
            .collect();
        let column: BTreeMap<usize, usize> = independent.iter().enumerate().map(|(i, &dof)| (dof, i)).collect();
        // Rows of `full` components, counted from the first of them.
        let rows = |full: &mut dyn Iterator<Item = usize>, first: usize, count: usize| {
            let mut triplets = TriMat::with_capacity((count, independent.len()), count);
            for dof in full {
                let Some(combination) = dependent.get(&dof) else {
                    triplets.add_triplet(dof - first, column[&dof], 1.0);
                    continue;
                };
                let mut expression: BTreeMap<usize, f64> = combination.iter().copied().collect();
                substitute(&mut expression, &dependent)?;
                for (&master, &coefficient) in &expression {
                    triplets.add_triplet(dof - first, column[&master], coefficient);
                }
            }
            Ok::<_, Error>(triplets.to_csr())
        };
        let transform = rows(&mut (0..n_nodal), 0, n_nodal)?;
        let references = rows(
            &mut references.iter().copied(),
            n_nodal,
            6 * assembly.couplings.len() + assembly.n_pretensions() + assembly.n_inner(),
        )?;
        // Inner coordinates are where the nodes of their superelement are.
        let inner: Vec<[f64; 3]> = (assembly.superelements.iter())
            .flat_map(|body| {
                let nodes = body.nodes();
                let at = nodes.iter().filter_map(|&node| coordinates.get(node as usize));
                let sum = at.fold([0.0; 3], |sum, x| [0, 1, 2].map(|c| sum[c] + x[c] / nodes.len() as f64));
                std::iter::repeat_n(sum, body.n_inner())
            })
            .collect();
        let middle = |pretension: usize| {
            if let Some(at) = pretension.checked_sub(assembly.n_pretensions()) {
                return inner[at];
            }
            let Some(shank) = assembly.shanks.get(pretension) else {
                let pair = assembly.cuts[pretension - assembly.shanks.len()].pairs.first();
                return pair.map_or([0.0; 3], |[first, _]| coordinates[*first as usize]);
            };
            let ends = shank.ends;
            let [a, b] = ends.map(|end| assembly.couplings.get(end as usize).map_or([0.0; 3], |c| c.reference));
            [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]))
        };
        let positions = independent
            .iter()
            .map(
                |&dof| match (dof.checked_sub(n_nodal), dof.checked_sub(n_beyond_nodes)) {
                    (None, _) => coordinates[dof / 3],
                    (_, Some(pretension)) => middle(pretension),
                    (Some(beyond), None) => assembly.couplings[beyond / 6].reference,
                },
            )
            .collect();
        Ok(Self {
            transform,
            references,
            independent,
            coordinates,
            largest_adjustment,
            untied,
            positions,
            n_couplings: assembly.couplings.len(),
        })
    }
}

/// Makes the component with the largest coefficient of `combination = 0` dependent on the others; whether there was
/// one.
fn eliminate(combination: Combination, dependent: &mut BTreeMap<usize, Combination>) -> Result<bool, Error> {
    let mut expression = BTreeMap::new();
    for (dof, coefficient) in combination {
        *expression.entry(dof).or_insert(0.0) += coefficient;
    }
    let scale = largest(&expression);
    substitute(&mut expression, dependent)?;
    let pivot = expression
        .iter()
        // The first of equal candidates, so that round-off in the last digit cannot change the choice.
        .reduce(|best, next| {
            if next.1.abs() > best.1.abs() * (1.0 + 1e-9) {
                next
            } else {
                best
            }
        })
        .filter(|(_, value)| value.abs() > 1e-10 * scale);
    let Some((&pivot, &coefficient)) = pivot else {
        return Ok(false);
    };
    expression.remove(&pivot);
    let rest = expression.into_iter().map(|(dof, c)| (dof, -c / coefficient)).collect();
    dependent.insert(pivot, rest);
    Ok(true)
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

/// One component of the assembly in terms of displacement components of nodes, motions of kinematic couplings and overlaps.
pub(crate) fn expand(
    assembly: &Assembly,
    coordinates: &[[f64; 3]],
    place: &str,
    dof: Dof,
) -> Result<Combination, Error> {
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
            let component = component as usize;
            match &coupling.kind {
                CouplingKind::Distributing(weights) => mean_motion(coupling, weights, coordinates, component),
                CouplingKind::Kinematic(_) => Ok(vec![(3 * coordinates.len() + 6 * index as usize + component, 1.0)]),
            }
        }
        Dof::Pretension(pretension) => {
            let count = assembly.n_pretensions();
            if pretension as usize >= count {
                return Err(dangling("pretension", pretension as usize, count));
            }
            let first = 3 * coordinates.len() + 6 * assembly.couplings.len();
            Ok(vec![(first + pretension as usize, 1.0)])
        }
    }
}

/// Checks references and weights.
pub(crate) fn check_cloud(coupling: &Coupling, coordinates: &[[f64; 3]]) -> Result<(), Error> {
    let fail = |reason| Error::Coupling {
        coupling: coupling.name.clone(),
        reason,
    };
    if let Some(&node) = coupling.nodes.iter().find(|&&node| node as usize >= coordinates.len()) {
        return Err(Error::Dangling {
            place: format!("coupling `{}`", coupling.name),
            what: "node",
            index: node as usize,
            count: coordinates.len(),
        });
    }
    if let Some(&value) = coupling.reference.iter().find(|x| !x.is_finite()) {
        return Err(Error::NotFinite {
            place: format!("the reference point of coupling `{}`", coupling.name),
            value,
        });
    }
    match &coupling.kind {
        CouplingKind::Distributing(weights) if weights.len() != coupling.nodes.len() || weights.is_empty() => {
            Err(fail("it needs one weight per node and at least one node"))
        }
        CouplingKind::Distributing(weights) if !weights.iter().all(|w| w.is_finite() && *w > 0.0) => {
            Err(fail("every weight must be positive and finite"))
        }
        _ => Ok(()),
    }
}

/// Makes the cloud of a kinematic coupling follow its reference point: `u = u_ref + theta x (x - x_ref)`.
fn insert_kinematic(
    index: usize,
    coupling: &Coupling,
    components: [bool; 3],
    coordinates: &[[f64; 3]],
    dependent: &mut BTreeMap<usize, Combination>,
) -> Result<(), Error> {
    let first = 3 * coordinates.len() + 6 * index;
    for &node in &coupling.nodes {
        let arm = Vector3::from(coordinates[node as usize]) - Vector3::from(coupling.reference);
        let rotation = -arm.cross_matrix();
        for component in (0..3).filter(|&c| components[c]) {
            let mut combination = vec![(first + component, 1.0)];
            for axis in 0..3 {
                let coefficient = rotation[(component, axis)];
                if coefficient != 0.0 {
                    combination.push((first + 3 + axis, coefficient));
                }
            }
            if dependent.insert(3 * node as usize + component, combination).is_some() {
                return Err(Error::DependentTwice {
                    place: coupling.name.clone(),
                    node,
                    component: component as u8,
                });
            }
        }
    }
    Ok(())
}

/// Makes the second part of a cut bolt follow the first: `u_second = u_first - overlap normal`.
fn insert_cut(
    overlap: usize,
    cut: &Cut,
    n_nodes: usize,
    dependent: &mut BTreeMap<usize, Combination>,
) -> Result<(), Error> {
    let length = Vector3::from(cut.normal).norm();
    if cut.pairs.is_empty() || !((length - 1.0).abs() < 1e-6) {
        return Err(Error::Cut {
            cut: cut.name.clone(),
            reason: "it needs a normal of length one and at least one pair of nodes",
        });
    }
    for &[first, second] in &cut.pairs {
        if let Some(node) = [first, second].into_iter().find(|node| *node as usize >= n_nodes) {
            return Err(Error::Dangling {
                place: format!("cut `{}`", cut.name),
                what: "node",
                index: node as usize,
                count: n_nodes,
            });
        }
        for (component, along) in cut.normal.into_iter().enumerate() {
            let combination = vec![(3 * first as usize + component, 1.0), (overlap, -along)];
            if dependent.insert(3 * second as usize + component, combination).is_some() {
                return Err(Error::DependentTwice {
                    place: cut.name.clone(),
                    node: second,
                    component: component as u8,
                });
            }
        }
    }
    Ok(())
}

/// Mean translation or rotation of a cloud of nodes (weighted least squares), at the reference point.
///
/// With centroid `c`, arms `r_i = x_i - c` and `I = sum w_i (|r_i|^2 1 - r_i r_i^T)`:
/// `theta = I^-1 sum w_i r_i x u_i`, `u_ref = sum w_i u_i + theta x (x_ref - c)`.
fn mean_motion(
    coupling: &Coupling,
    weights: &[f64],
    coordinates: &[[f64; 3]],
    component: usize,
) -> Result<Combination, Error> {
    let fail = |reason| Error::Coupling {
        coupling: coupling.name.clone(),
        reason,
    };
    let total: f64 = weights.iter().sum();
    let cloud = || {
        coupling
            .nodes
            .iter()
            .zip(weights)
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

/// An assembly whose slaves were moved onto the faces they are tied to.
pub(crate) struct Tied {
    /// Of all nodes after the moves (m).
    pub(crate) coordinates: Vec<[f64; 3]>,
    dependent: BTreeMap<usize, Combination>,
    largest_adjustment: f64,
    untied: Vec<(usize, u32, f64)>,
}

impl Tied {
    pub(crate) fn try_new(assembly: &Assembly) -> Result<Self, Error> {
        let mut tied = Self {
            coordinates: assembly.mesh.nodes.clone(),
            dependent: BTreeMap::new(),
            largest_adjustment: 0.0,
            untied: Vec::new(),
        };
        for (index, tie) in assembly.ties.iter().enumerate() {
            let (moved, free) = insert_tie(tie, &mut tied.coordinates, &mut tied.dependent)?;
            tied.largest_adjustment = tied.largest_adjustment.max(moved);
            tied.untied
                .extend(free.into_iter().map(|(node, distance)| (index, node, distance)));
        }
        Ok(tied)
    }
}

/// Makes the slaves of a tie dependent and moves them onto their faces; returns the largest move and the slaves left
/// free with their distances.
fn insert_tie(
    tie: &Tie,
    coordinates: &mut [[f64; 3]],
    dependent: &mut BTreeMap<usize, Combination>,
) -> Result<(f64, Vec<(u32, f64)>), Error> {
    let place = || format!("tie `{}`", tie.name);
    let masters = tie.master_faces.iter().flat_map(Face::nodes);
    if let Some(&node) = tie
        .slave_nodes
        .iter()
        .chain(masters)
        .find(|&&node| node as usize >= coordinates.len())
    {
        return Err(Error::Dangling {
            place: place(),
            what: "node",
            index: node as usize,
            count: coordinates.len(),
        });
    }
    let (mut largest, mut free) = (0.0_f64, Vec::new());
    for &slave in &tie.slave_nodes {
        let x = Vector3::from(coordinates[slave as usize]);
        let feet = tie
            .master_faces
            .iter()
            .map(|face| (face, project(x, face, coordinates)));
        let nearest = feet.min_by(|(_, a), (_, b)| (a.at - x).norm().total_cmp(&(b.at - x).norm()));
        let distance = nearest.as_ref().map_or(f64::INFINITY, |(_, foot)| (foot.at - x).norm());
        let Some((face, foot)) = nearest.filter(|_| distance <= tie.position_tolerance) else {
            if tie.beyond == BeyondTolerance::LeaveFree {
                free.push((slave, distance));
                continue;
            }
            return Err(Error::TieTooFar {
                tie: tie.name.clone(),
                node: slave,
                distance,
                tolerance: tie.position_tolerance,
            });
        };
        let arm = if tie.adjust {
            largest = largest.max(distance);
            coordinates[slave as usize] = foot.at.into();
            Vector3::zeros()
        } else {
            x - foot.at
        };
        for component in 0..3 {
            let combination = foot.motion(face.nodes(), arm, component);
            if dependent.insert(3 * slave as usize + component, combination).is_some() {
                return Err(Error::DependentTwice {
                    place: tie.name.clone(),
                    node: slave,
                    component: component as u8,
                });
            }
        }
    }
    Ok((largest, free))
}

/// The nearest point of a face.
struct Foot {
    at: Vector3<f64>,
    /// Shape functions there, and their derivatives by two natural coordinates.
    values: Vec<f64>,
    derivatives: Vec<Vector2<f64>>,
    /// Derivatives of the position.
    tangents: [Vector3<f64>; 2],
}

impl Foot {
    fn new(face: &Face, s: Vector2<f64>, coordinates: &[[f64; 3]]) -> Self {
        let (values, derivatives) = (face.face_type().interpolation)(s);
        let mut foot = Self {
            at: Vector3::zeros(),
            tangents: [Vector3::zeros(); 2],
            values,
            derivatives,
        };
        for ((&node, value), d) in face.nodes().iter().zip(&foot.values).zip(&foot.derivatives) {
            let x = Vector3::from(coordinates[node as usize]);
            foot.at += x * *value;
            foot.tangents[0] += x * d.x;
            foot.tangents[1] += x * d.y;
        }
        foot
    }

    /// One displacement component of a point at the end of a rigid arm on the face.
    fn motion(&self, nodes: &[u32], arm: Vector3<f64>, component: usize) -> Combination {
        let mut rows: Vec<Vector3<f64>> = self
            .values
            .iter()
            .map(|&value| Vector3::ith(component, value))
            .collect();
        let metric = Matrix2::from_fn(|i, j| self.tangents[i].dot(&self.tangents[j]));
        if let (true, Some(inverse)) = (arm != Vector3::zeros(), metric.try_inverse()) {
            let normal = self.tangents[0].cross(&self.tangents[1]).normalize();
            for (row, d) in rows.iter_mut().zip(&self.derivatives) {
                // Surface gradient of the shape function. The rotation of the face is
                // sum -(n x grad) (n . u) + n (n x grad . u) / 2.
                let weights = inverse * d;
                let gradient = self.tangents[0] * weights.x + self.tangents[1] * weights.y;
                let tilt = -normal.cross(&gradient) * normal.transpose();
                let spin = normal * normal.cross(&gradient).transpose() * 0.5;
                // theta x arm
                *row += (-arm.cross_matrix() * (tilt + spin)).row(component).transpose();
            }
        }
        let terms = nodes.iter().zip(&rows);
        terms
            .flat_map(|(&node, row)| (0..3).map(move |i| (3 * node as usize + i, row[i])))
            .filter(|(_, weight)| *weight != 0.0)
            .collect()
    }
}

/// Nearest point of a face, by Gauss-Newton steps in the natural coordinates.
fn project(x: Vector3<f64>, face: &Face, coordinates: &[[f64; 3]]) -> Foot {
    let domain = face.face_type().domain;
    let mut s = domain.centre();
    let mut foot = Foot::new(face, s, coordinates);
    for _ in 0..30 {
        let gap = x - foot.at;
        let [ds, dt] = foot.tangents;
        let metric = Matrix2::new(ds.dot(&ds), ds.dot(&dt), ds.dot(&dt), dt.dot(&dt));
        let Some(inverse) = metric.try_inverse() else { break };
        let next = domain.clamp(s + inverse * Vector2::new(ds.dot(&gap), dt.dot(&gap)));
        let moved = (next - s).norm();
        s = next;
        foot = Foot::new(face, s, coordinates);
        if moved < 1e-14 {
            break;
        }
    }
    foot
}
