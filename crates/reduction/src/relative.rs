//! The jump across an interface as coordinates.

use crate::Error;
use dense_algebra::{cholesky, product, solve_lower, solve_lower_transposed};
use faer::{Mat, MatRef};
use finite_elements::assemble::System;
use finite_elements::reflection::Reflection;
use finite_elements::sparse::{congruence, multiply, multiply_vector, numbering, submatrix, symmetric_part};
use sprs::{CsMat, TriMat};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

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

/// Nodes of one side of an interface, which carry the jump, and what faces them on the other.
#[derive(Clone, Copy, Debug)]
pub struct FacingNodes<'a> {
    /// Nodes that carry the jump.
    pub own: &'a [u32],
    /// Whether they belong to the top body.
    pub own_is_top: bool,
    /// Nodes of the other side.
    pub other: &'a [u32],
    /// What faces each own node: weights of the other nodes (own x other). Each row sums to one and reproduces the own node's place, so that
    /// rigid motions are no jump.
    pub projection: &'a CsMat<f64>,
    /// For each own node, unit vectors x, y (along the interface) and n (from the top body into the bottom body).
    pub frames: &'a [[[f64; 3]; 3]],
}

/// What one displacement component is in the new coordinates: `sign` times the jump, and these rows with their weights.
struct Carried {
    row: usize,
    sign: f64,
    other: Vec<(usize, f64)>,
}

impl Carried {
    /// Of a pair of coinciding nodes: the top one is the jump and the bottom one.
    fn pair(top: usize, bottom: usize) -> Self {
        Self {
            row: top,
            sign: 1.0,
            other: vec![(bottom, 1.0)],
        }
    }
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
    /// Jump coordinates of each interface, which follow one another; all together where it is not known that there are several.
    pub groups: Vec<usize>,
    /// Position of each coordinate's node (m).
    pub positions: Vec<[f64; 3]>,
    /// Reflections that take the mesh to itself, over `[jump; rest]`.
    pub(crate) reflections: Vec<Reflection>,
    /// Rigid motions of the whole structure as columns over `[jump; rest]`; none where they are not known.
    pub(crate) rigid_motions: Mat<f64>,
    /// `u = transform * [jump; rest]` over the coordinates before the change.
    pub(crate) transform: CsMat<f64>,
}

/// Symmetric matrices with both triangles filled, and what goes with them.
#[derive(Clone, Copy, Debug)]
pub struct SystemMatrices<'a> {
    /// Stiffness, `n x n` (N/m).
    pub stiffness: &'a CsMat<f64>,
    /// Mass, `n x n` (kg).
    pub mass: &'a CsMat<f64>,
    /// Loads of length `n` (N).
    pub loads: &'a [Vec<f64>],
    /// A point for each row (m), which guides the elimination; all alike where they are not known.
    pub positions: &'a [[f64; 3]],
}

impl SystemMatrices<'_> {
    fn check(&self) -> Result<usize, Error> {
        let n = self.stiffness.rows();
        let shapes = [
            ("stiffness", self.stiffness.shape()),
            ("mass", self.mass.shape()),
            ("positions", (self.positions.len(), n)),
        ];
        let loads = self.loads.iter().map(|load| ("load", (load.len(), n)));
        for (what, (rows, columns)) in shapes.into_iter().chain(loads) {
            if (rows, columns) != (n, n) {
                return Err(Error::MatrixShape { what, rows, columns, n });
            }
        }
        Ok(n)
    }
}

/// Full form of a sparse matrix.
fn full(matrix: &CsMat<f64>) -> Mat<f64> {
    let mut full = Mat::zeros(matrix.rows(), matrix.cols());
    for (&value, (i, j)) in matrix {
        full[(i, j)] = value;
    }
    full
}

/// The matrix with a value added to some entries of its diagonal.
fn with_diagonal(matrix: &CsMat<f64>, at: &[usize], value: f64) -> CsMat<f64> {
    let mut alone = TriMat::new(matrix.shape());
    at.iter().for_each(|&i| alone.add_triplet(i, i, value));
    matrix + &alone.to_csr()
}

/// A full matrix without its zeros.
fn sparse(matrix: MatRef<'_, f64>) -> CsMat<f64> {
    let mut entries = TriMat::new((matrix.nrows(), matrix.ncols()));
    for i in 0..matrix.nrows() {
        for j in (0..matrix.ncols()).filter(|&j| matrix[(i, j)] != 0.0) {
            entries.add_triplet(i, j, matrix[(i, j)]);
        }
    }
    entries.to_csr()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn mean(points: &[[f64; 3]]) -> [f64; 3] {
    let sum = points.iter().fold([0.0; 3], |sum, x| [0, 1, 2].map(|i| sum[i] + x[i]));
    sum.map(|sum| sum / points.len().max(1) as f64)
}

fn check_jump(n_relative: usize, n: usize) -> Result<(), Error> {
    if n_relative == 0 || n_relative > n || !n_relative.is_multiple_of(3) {
        return Err(Error::MatrixShape {
            what: "jump",
            rows: n_relative,
            columns: 1,
            n,
        });
    }
    Ok(())
}

fn check_frame(frame: [[f64; 3]; 3]) -> Result<(), Error> {
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
    Ok(())
}

impl RelativeSystem {
    /// Changes the coordinates of a system.
    ///
    /// Where both nodes of a pair are fixed along an axis, as on a plane of symmetry, their jump is zero. Its coordinate
    /// stays, with the largest stiffness and the smallest mass of all the others and without coupling to them, so that
    /// nothing moves it and no low mode has it; forces on it must be left out.
    ///
    /// # Errors
    /// Pairs that do not match, do not coincide, share nodes, are not free or fixed along other directions; axes that
    /// are not orthonormal.
    pub fn try_new(system: &System, pairs: InterfacePairs<'_>) -> Result<Self, Error> {
        let (top, bottom, frame) = (pairs.top, pairs.bottom, pairs.frame);
        if top.len() != bottom.len() || top.is_empty() {
            return Err(Error::PairCount {
                top: top.len(),
                bottom: bottom.len(),
            });
        }
        let n_relative = 3 * top.len();
        let dofs = &system.dofs;
        let is_fixed = |node: u32, component: u8| {
            let full = 3 * node as usize + usize::from(component);
            full < dofs.transform.rows() && dofs.row(full).next().is_none()
        };
        let place = |node: u32, component: u8| {
            let known = (node as usize) < dofs.coordinates.len();
            known
                .then(|| dofs.independent_index(node, component))
                .flatten()
                .ok_or(Error::DependentInterface { node, component })
        };
        let mut rows = Vec::with_capacity(n_relative);
        let mut paired = BTreeSet::new();
        for (pair, (&t, &b)) in top.iter().zip(bottom).enumerate() {
            for node in [t, b] {
                if !paired.insert(node) {
                    return Err(Error::PairTwice { pair, node });
                }
            }
            for component in 0..3_u8 {
                let both_fixed = is_fixed(t, component) && is_fixed(b, component);
                rows.push(match both_fixed {
                    true => None,
                    false => Some(Carried::pair(place(t, component)?, place(b, component)?)),
                });
            }
        }
        let coordinates = |node: u32| system.dofs.coordinates[node as usize];
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
        let both = SystemMatrices {
            stiffness: &system.stiffness,
            mass: &system.mass,
            loads: &system.loads,
            positions: &system.positions,
        };
        Self::from_carried(both, Some(system), &rows, &vec![frame; top.len()])
    }

    /// Changes the coordinates of a system with any number of interfaces, whose sides need not have the same mesh. Jumps follow one
    /// another in the order of the interfaces.
    ///
    /// # Errors
    /// Nodes that carry two jumps, or carry one and face another; weights that do not sum to one or miss the place of a node; nodes that are
    /// not free; axes that are not orthonormal.
    pub fn from_facing(system: &System, interfaces: &[FacingNodes<'_>]) -> Result<Self, Error> {
        let dofs = &system.dofs;
        let coordinates = |node: u32| dofs.coordinates.get(node as usize).copied();
        let (mut rows, mut frames) = (Vec::new(), Vec::new());
        let mut carriers = BTreeSet::new();
        let mut first = 0;
        for side in interfaces {
            let sizes = (side.own.len(), side.other.len());
            if side.own.is_empty() || side.projection.shape() != sizes || side.frames.len() != sizes.0 {
                return Err(Error::PairCount {
                    top: side.own.len(),
                    bottom: side.projection.rows(),
                });
            }
            let free = |node: u32, component: u8| {
                let known = (node as usize) < dofs.coordinates.len();
                let row = known.then(|| dofs.independent_index(node, component)).flatten();
                row.ok_or(Error::DependentInterface { node, component })
            };
            let places: Vec<[f64; 3]> = side.own.iter().filter_map(|&node| coordinates(node)).collect();
            let size = match places.first() {
                Some(origin) => places.iter().map(|x| distance(*x, *origin)).fold(0.0, f64::max),
                None => 0.0,
            };
            for (index, &own) in side.own.iter().enumerate() {
                let pair = first + index;
                if !carriers.insert(own) {
                    return Err(Error::PairTwice { pair, node: own });
                }
                let weights: Vec<(u32, f64)> = side
                    .projection
                    .outer_view(index)
                    .iter()
                    .flat_map(|row| row.iter())
                    .map(|(column, &weight)| (side.other[column], weight))
                    .collect();
                let mut facing = [0.0; 3];
                let mut total = 0.0;
                for &(node, weight) in &weights {
                    let x = coordinates(node).ok_or(Error::DependentInterface { node, component: 0 })?;
                    (0..3).for_each(|i| facing[i] += weight * x[i]);
                    total += weight;
                }
                let apart = coordinates(own).map_or(f64::INFINITY, |x| distance(x, facing));
                // `!(a <= b)` also catches NaN.
                if !(apart <= 1e-6 * size && (total - 1.0).abs() <= 1e-9) {
                    return Err(Error::FacingApart {
                        pair,
                        node: own,
                        distance: apart,
                        total,
                    });
                }
                for component in 0..3_u8 {
                    let mut other = BTreeMap::new();
                    for &(node, weight) in &weights {
                        for (row, share) in dofs.row(3 * node as usize + usize::from(component)) {
                            *other.entry(row).or_insert(0.0) += weight * share;
                        }
                    }
                    rows.push(Some(Carried {
                        row: free(own, component)?,
                        sign: if side.own_is_top { 1.0 } else { -1.0 },
                        other: other.into_iter().collect(),
                    }));
                }
            }
            frames.extend_from_slice(side.frames);
            first += side.own.len();
        }
        let matrices = SystemMatrices {
            stiffness: &system.stiffness,
            mass: &system.mass,
            loads: &system.loads,
            positions: &system.positions,
        };
        let mut found = Self::from_carried(matrices, Some(system), &rows, &frames)?;
        found.groups = interfaces.iter().map(|side| 3 * side.own.len()).collect();
        Ok(found)
    }

    /// Changes the coordinates of matrices over the displacements of both sides; `top` and `bottom` are the rows of
    /// their interface components, three per pair.
    ///
    /// # Errors
    /// [`Error::Frame`], [`Error::MatrixShape`], [`Error::InterfaceRow`] for a row that does not exist or occurs twice.
    pub fn from_both_sides(
        system: SystemMatrices<'_>,
        top: &[usize],
        bottom: &[usize],
        frame: [[f64; 3]; 3],
    ) -> Result<Self, Error> {
        let n_relative = top.len();
        if n_relative == 0 || !n_relative.is_multiple_of(3) || bottom.len() != n_relative {
            return Err(Error::PairCount {
                top: n_relative / 3,
                bottom: bottom.len() / 3,
            });
        }
        let mut bottoms = BTreeSet::new();
        if let Some(&row) = bottom.iter().find(|&&row| !bottoms.insert(row)) {
            let n = system.stiffness.rows();
            return Err(Error::InterfaceRow { row, n });
        }
        let rows: Vec<_> = top
            .iter()
            .zip(bottom)
            .map(|(&t, &b)| Some(Carried::pair(t, b)))
            .collect();
        Self::from_carried(system, None, &rows, &vec![frame; n_relative / 3])
    }

    /// The matrices may come from a mesh; `pairs` are the components that carry the jump, three for each frame; none where both sides are fixed.
    fn from_carried(
        system: SystemMatrices<'_>,
        meshed: Option<&System>,
        pairs: &[Option<Carried>],
        frames: &[[[f64; 3]; 3]],
    ) -> Result<Self, Error> {
        frames.iter().try_for_each(|frame| check_frame(*frame))?;
        let n = system.check()?;
        let n_relative = pairs.len();
        let mut used = vec![false; n];
        for carried in pairs.iter().flatten() {
            let row = carried.row;
            if row >= n || std::mem::replace(&mut used[row], true) {
                return Err(Error::InterfaceRow { row, n });
            }
        }
        for &(row, _) in pairs.iter().flatten().flat_map(|carried| &carried.other) {
            // What carries a jump has no coordinate of its own.
            if row >= n || used[row] {
                return Err(Error::InterfaceRow { row, n });
            }
        }
        let mut carried_by = vec![None; n];
        let mut zero = Vec::new();
        for (index, rows) in pairs.iter().enumerate() {
            let (component, frame) = (index % 3, &frames[index / 3]);
            let Some(carried) = rows else {
                let along = |axis: &[f64; 3]| (0..3).all(|c| (axis[c] != 0.0) == (c == component));
                let alone = frame.iter().position(along).filter(|&own| {
                    let others = (0..3).filter(|&axis| axis != own);
                    others.into_iter().all(|axis| frame[axis][component] == 0.0)
                });
                let axis = alone.ok_or(Error::FixedInterface {
                    pair: index / 3,
                    component,
                })?;
                zero.push(index - component + axis);
                continue;
            };
            carried_by[carried.row] = Some((index, carried));
        }
        zero.sort_unstable();
        if zero.len() == n_relative {
            return Err(Error::FixedInterface { pair: 0, component: 0 });
        }
        let rest: Vec<usize> = (0..n).filter(|&dof| carried_by[dof].is_none()).collect();
        let column: Vec<usize> = numbering(&rest, n).into_iter().map(Option::unwrap_or_default).collect();
        let n_changed = n + zero.len();
        let mut transform = TriMat::with_capacity((n, n_changed), n + 4 * n_relative);
        let mut positions = vec![[0.0; 3]; n_changed];
        for dof in 0..n {
            let Some((jump, carried)) = carried_by[dof] else {
                transform.add_triplet(dof, n_relative + column[dof], 1.0);
                positions[n_relative + column[dof]] = system.positions[dof];
                continue;
            };
            let component = jump % 3;
            for (axis, direction) in frames[jump / 3].iter().enumerate() {
                if direction[component] != 0.0 {
                    transform.add_triplet(dof, jump - component + axis, carried.sign * direction[component]);
                    positions[jump - component + axis] = system.positions[dof];
                }
            }
            for &(row, weight) in &carried.other {
                transform.add_triplet(dof, n_relative + column[row], weight);
            }
        }
        for &jump in &zero {
            let pair = jump - jump % 3;
            let other = (pair..pair + 3).find(|other| zero.binary_search(other).is_err());
            positions[jump] = other.map_or([0.0; 3], |other| positions[other]);
        }
        let mut changed = Self::changed(system, transform.to_csr(), n_relative, positions);
        changed.leave_alone(&zero);
        let Some(meshed) = meshed else { return Ok(changed) };
        let rigid_motions = meshed.dofs.rigid_motions(mean(&meshed.positions));
        changed.rigid_motions = Mat::from_fn(n_changed, rigid_motions.ncols(), |i, j| {
            // None is a jump.
            i.checked_sub(n_relative).map_or(0.0, |i| rigid_motions[(rest[i], j)])
        });
        let reflections = &meshed.reflections;
        if zero.is_empty() && !reflections.is_empty() {
            // `[jump; rest]` of displacements.
            let mut inverse = TriMat::with_capacity((n, n), n + 4 * n_relative);
            for &dof in &rest {
                inverse.add_triplet(n_relative + column[dof], dof, 1.0);
            }
            for (jump, carried) in carried_by.iter().flatten() {
                let component = jump % 3;
                for (axis, direction) in frames[jump / 3].iter().enumerate() {
                    let share = carried.sign * direction[component];
                    if share != 0.0 {
                        let row = jump - component + axis;
                        inverse.add_triplet(row, carried.row, share);
                        carried
                            .other
                            .iter()
                            .for_each(|&(dof, weight)| inverse.add_triplet(row, dof, -share * weight));
                    }
                }
            }
            let inverse: CsMat<f64> = inverse.to_csr();
            let over = |reflection: &Reflection| Reflection {
                matrix: &(&inverse * &reflection.matrix) * &changed.transform,
                ..*reflection
            };
            changed.reflections = reflections.iter().map(over).collect();
        }
        Ok(changed)
    }

    /// Gives jump coordinates without stiffness and mass the largest and the smallest of the others.
    fn leave_alone(&mut self, zero: &[usize]) {
        if zero.is_empty() {
            return;
        }
        let others = |matrix: &CsMat<f64>| -> Vec<f64> {
            let free = (0..self.n_relative).filter(|i| zero.binary_search(i).is_err());
            free.map(|i| matrix.get(i, i).copied().unwrap_or(0.0)).collect()
        };
        let stiffness = others(&self.stiffness).into_iter().fold(0.0, f64::max);
        let mass = others(&self.mass).into_iter().fold(f64::INFINITY, f64::min);
        for (matrix, value) in [(&mut self.stiffness, stiffness), (&mut self.mass, mass)] {
            *matrix = with_diagonal(matrix, zero, value);
        }
    }

    /// Takes matrices whose coordinates include the jump, at the rows `jump`, three per pair in the order x, y, n; none for a
    /// component that the matrices do not have.
    ///
    /// Such a coordinate is added with the largest stiffness of the others, without mass and coupling, so that nothing moves it
    /// and no mode has it; forces on it must be left out.
    ///
    /// # Errors
    /// [`Error::MatrixShape`], also for no jump or a number of rows that is not a multiple of three;
    /// [`Error::InterfaceRow`] for a row that does not exist or occurs twice; [`Error::FixedInterface`] where all are missing.
    pub fn from_relative(system: SystemMatrices<'_>, jump: &[Option<usize>]) -> Result<Self, Error> {
        let n = system.check()?;
        let missing: Vec<usize> = (0..jump.len()).filter(|&i| jump[i].is_none()).collect();
        check_jump(jump.len(), n + missing.len())?;
        if missing.len() == jump.len() {
            return Err(Error::FixedInterface { pair: 0, component: 0 });
        }
        let mut order = jump.to_vec();
        let mut used = vec![false; n];
        for &row in jump.iter().flatten() {
            if row >= n || std::mem::replace(&mut used[row], true) {
                return Err(Error::InterfaceRow { row, n });
            }
        }
        order.extend((0..n).filter(|&row| !used[row]).map(Some));
        let mut transform = TriMat::with_capacity((n, order.len()), n);
        for (&row, column) in order.iter().zip(0..) {
            if let Some(row) = row {
                transform.add_triplet(row, column, 1.0);
            }
        }
        let position = |row: &Option<usize>| row.map_or([0.0; 3], |row| system.positions[row]);
        let positions = order.iter().map(position).collect();
        let mut changed = Self::changed(system, transform.to_csr(), jump.len(), positions);
        if !missing.is_empty() {
            let diagonal = (0..order.len()).filter_map(|i| changed.stiffness.get(i, i).copied());
            let largest = diagonal.fold(0.0, f64::max);
            // Masses that contact alone holds have no stiffness at all.
            let stiffness = if largest > 0.0 { largest } else { 1.0 };
            changed.stiffness = with_diagonal(&changed.stiffness, &missing, stiffness);
        }
        Ok(changed)
    }

    /// Takes matrices over coordinates `x` whose combinations `P x` are the jump, three rows of `P` per pair in the order
    /// x, y, n.
    ///
    /// The new coordinates are `[P x; N^T x]` with an orthonormal basis `N` of what `P` does not see, and
    /// `x = P^T (P P^T)^-1 jump + N z`. All is done with full matrices.
    ///
    /// # Errors
    /// [`Error::MatrixShape`], [`Error::DependentJump`] if the rows of `P` depend on one another.
    pub fn from_combinations(system: SystemMatrices<'_>, jump: &CsMat<f64>) -> Result<Self, Error> {
        let n = system.check()?;
        let nd = jump.rows();
        check_jump(nd, n)?;
        if jump.cols() != n {
            return Err(Error::MatrixShape {
                what: "matrix of the jump",
                rows: nd,
                columns: jump.cols(),
                n,
            });
        }
        let rows = full(jump);
        let dependent = |_| Error::DependentJump { rows: nd };
        let lower = cholesky(product(rows.as_ref(), rows.transpose()).as_ref()).map_err(dependent)?;
        let project = |mut right: Mat<f64>| {
            solve_lower(lower.as_ref(), right.as_mut());
            solve_lower_transposed(lower.as_ref(), right.as_mut());
            product(rows.transpose(), right.as_ref())
        };
        let own = project(Mat::identity(nd, nd));
        let deviation = (product(rows.as_ref(), own.as_ref()) - Mat::<f64>::identity(nd, nd)).norm_max();
        // `!(a <= b)` also catches NaN.
        if !(deviation <= 1e-8) {
            return Err(Error::DependentJump { rows: nd });
        }
        let mut rest = dense_algebra::scattered(n, n - nd);
        // The second round takes out what round-off left after the first.
        for _ in 0..2 {
            let seen = product(rows.as_ref(), rest.as_ref());
            rest -= project(seen);
            let gram = cholesky(product(rest.transpose(), rest.as_ref()).as_ref()).map_err(dependent)?;
            let mut turned = rest.transpose().to_owned();
            solve_lower(gram.as_ref(), turned.as_mut());
            rest = turned.transpose().to_owned();
        }
        let mut change = Mat::<f64>::zeros(n, n);
        change.subcols_mut(0, nd).copy_from(own);
        change.subcols_mut(nd, n - nd).copy_from(rest);
        let matrix = |a: &CsMat<f64>| {
            let right = product(full(a).as_ref(), change.as_ref());
            symmetric_part(sparse(product(change.transpose(), right.as_ref()).as_ref()))
        };
        let transform = sparse(change.as_ref());
        let transposed: CsMat<f64> = transform.transpose_view().to_csr();
        Ok(Self {
            stiffness: matrix(system.stiffness),
            mass: matrix(system.mass),
            loads: system
                .loads
                .iter()
                .map(|load| multiply_vector(&transposed, load))
                .collect(),
            n_relative: nd,
            groups: vec![nd],
            // Combinations have no place.
            positions: vec![[0.0; 3]; n],
            reflections: Vec::new(),
            rigid_motions: Mat::zeros(n, 0),
            transform,
        })
    }

    /// The system in coordinates of which `transform` makes those that it has.
    pub(crate) fn changed(
        system: SystemMatrices<'_>,
        transform: CsMat<f64>,
        n_relative: usize,
        positions: Vec<[f64; 3]>,
    ) -> Self {
        let transposed: CsMat<f64> = transform.transpose_view().to_csr();
        let n = transform.cols();
        Self {
            stiffness: congruence(&transform, system.stiffness),
            mass: congruence(&transform, system.mass),
            loads: system
                .loads
                .iter()
                .map(|load| multiply_vector(&transposed, load))
                .collect(),
            n_relative,
            groups: vec![n_relative],
            positions,
            reflections: Vec::new(),
            rigid_motions: Mat::zeros(n, 0),
            transform,
        }
    }

    /// A row over the coordinates before the change (for example a response), over `[jump; rest]` instead.
    pub fn row(&self, over_independent: &[f64]) -> Vec<f64> {
        multiply_vector(&self.transform.transpose_view().to_csr(), over_independent)
    }

    /// Columns over `[jump; rest]`, over the coordinates before the change instead.
    pub fn displacements(&self, columns: MatRef<'_, f64>) -> Mat<f64> {
        multiply(&self.transform, columns)
    }

    /// Coordinates beside the jump.
    pub(crate) fn n_rest(&self) -> usize {
        self.stiffness.rows() - self.n_relative
    }

    /// The rows of a matrix over `[jump; rest]` at the jump, and their columns at the rest.
    pub(crate) fn jump_rest(&self, matrix: &CsMat<f64>) -> CsMat<f64> {
        self.block(matrix, 0..self.n_relative)
    }

    /// The block of a matrix over `[jump; rest]` that is left where the jump is held.
    pub(crate) fn rest(&self, matrix: &CsMat<f64>) -> CsMat<f64> {
        self.block(matrix, self.n_relative..matrix.rows())
    }

    fn block(&self, matrix: &CsMat<f64>, rows: Range<usize>) -> CsMat<f64> {
        let rest: Vec<usize> = (self.n_relative..matrix.rows()).collect();
        let column = numbering(&rest, matrix.rows());
        submatrix(matrix, &rows.collect::<Vec<_>>(), &column, rest.len())
    }

    /// The mass times columns over the rest, and perhaps over the jump: at the jump, and at the rest.
    pub(crate) fn momentum(&self, jump: Option<MatRef<'_, f64>>, rest: MatRef<'_, f64>) -> [Mat<f64>; 2] {
        let (nd, n) = (self.n_relative, self.mass.rows());
        let mut motion = Mat::zeros(n, rest.ncols());
        if let Some(jump) = jump {
            motion.subrows_mut(0, nd).copy_from(jump);
        }
        motion.subrows_mut(nd, n - nd).copy_from(rest);
        let momentum = multiply(&self.mass, motion.as_ref());
        [0..nd, nd..n].map(|rows| momentum.subrows(rows.start, rows.len()).to_owned())
    }
}
