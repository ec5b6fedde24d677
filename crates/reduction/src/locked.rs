//! Loads whose displacement is held: the full and the reduced system with `l_i^T u = 0` for every load `i`.
//!
//! A unit load does the work `l_i^T u`, so for opposite unit forces on two nodes that is their relative motion: a
//! preloaded bolt whose thread is locked. Motion counts from the state in which the loads were applied.

use crate::Error;
use crate::craig_bampton::ReducedModel;
use crate::relative::RelativeSystem;
use dense_algebra::{SystemMatrix, product, solve_lower, solve_lower_transposed};
use faer::{Mat, MatRef};
use finite_elements::sparse::congruence;
use sprs::{CsMat, TriMat};

/// Least share of a load that must act on the rest of the structure, or be left after others are taken out.
const LEAST_SHARE: f64 = 1e-9;

impl RelativeSystem {
    /// The same system with the displacement of every load held, by eliminating one component of the rest per load.
    ///
    /// It has no loads, because they could do no work.
    ///
    /// # Errors
    /// [`Error::DependentLoad`].
    pub fn locked(&self) -> Result<Self, Error> {
        let n = self.stiffness.rows();
        let size = |row: &[f64]| row.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        // Gauss-Jordan: each row has a one at its own pivot and a zero at those of the others.
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(self.loads.len());
        let mut pivots: Vec<usize> = Vec::with_capacity(self.loads.len());
        for (load, given) in self.loads.iter().enumerate() {
            let subtract = |row: &mut [f64], other: &[f64], pivot: usize| {
                let factor = row[pivot];
                row.iter_mut().zip(other).for_each(|(a, b)| *a -= factor * b);
            };
            let mut row = given.clone();
            for (other, &pivot) in rows.iter().zip(&pivots) {
                subtract(&mut row, other, pivot);
            }
            let pivot = (self.n_relative..n)
                .max_by(|&a, &b| row[a].abs().total_cmp(&row[b].abs()))
                .filter(|&pivot| row[pivot].abs() > LEAST_SHARE * size(given))
                .ok_or(Error::DependentLoad { load })?;
            let value = row[pivot];
            row.iter_mut().for_each(|v| *v /= value);
            for other in &mut rows {
                subtract(other, &row, pivot);
            }
            rows.push(row);
            pivots.push(pivot);
        }
        let kept: Vec<usize> = (0..n).filter(|i| !pivots.contains(i)).collect();
        let mut transform = TriMat::new((n, kept.len()));
        for (column, &i) in kept.iter().enumerate() {
            transform.add_triplet(i, column, 1.0);
            for (row, &pivot) in rows.iter().zip(&pivots) {
                if row[i] != 0.0 {
                    transform.add_triplet(pivot, column, -row[i]);
                }
            }
        }
        let transform: CsMat<f64> = transform.to_csr();
        Ok(Self {
            stiffness: congruence(&transform, &self.stiffness),
            mass: congruence(&transform, &self.mass),
            loads: Vec::new(),
            n_relative: self.n_relative,
            groups: self.groups.clone(),
            positions: kept.iter().map(|&i| self.positions[i]).collect(),
            reflections: Vec::new(),
            rigid_motions: Mat::zeros(kept.len(), 0),
            transform: &self.transform * &transform,
        })
    }
}

impl ReducedModel {
    /// The same structure with the displacement of every load held: one coordinate less per load, the jump leading
    /// as before, stiffness again without coupling between it and the rest, the rest again mass-normalised modes.
    ///
    /// With `l = [l_D; l_r]` the rest follows the jump statically as `-K_r^-1 l_r S^-1 l_D^T` with the compliance
    /// `S = l_r^T K_r^-1 l_r` at the loads, which adds `l_D S^-1 l_D^T` to the stiffness of the jump. The model has no
    /// loads, because they could do no work.
    ///
    /// # Errors
    /// [`Error::NoAttachmentModes`] for a model reduced without them, which would be far too stiff because the retained
    /// modes hold little of the flexibility at the loads. [`Error::DependentLoad`]; failures of the eigenvalue
    /// decomposition.
    pub fn locked(&self) -> Result<Self, Error> {
        Ok(self.locked_with_motions()?.0)
    }

    /// As [`ReducedModel::locked`], with the motion of this model's coordinates behind the jump in unit motions of those of the locked one, column by column;
    /// the jump is that of both.
    ///
    /// # Errors
    /// As [`ReducedModel::locked`].
    pub fn locked_with_motions(&self) -> Result<(Self, Mat<f64>), Error> {
        let n_loads = self.loads.len();
        if self.n_attachment != n_loads {
            return Err(Error::NoAttachmentModes {
                loads: n_loads,
                attachment: self.n_attachment,
            });
        }
        let (Some(own_stiffness), Some(own_mass)) = (self.stiffness.as_ref().dense(), self.mass.as_ref().dense())
        else {
            let small = self.seen()?;
            let (locked, motions) = small.locked_with_motions()?;
            return Ok(self.with_seen(&small, locked, &motions));
        };
        let nd = self.n_relative;
        let n_rest = self.size() - nd;
        let n_modes = n_rest - n_loads;
        let rest = |matrix: MatRef<'_, f64>| matrix.submatrix(nd, nd, n_rest, n_rest).to_owned();
        let (k_rest, m_rest) = (rest(own_stiffness), rest(own_mass));
        let lower = dense_algebra::cholesky(k_rest.as_ref())?;
        // In the metric of K_r = L L^T, S = H^T H with H = L^-1 l_r, and Q = H R^-T with S = R R^T is orthonormal.
        let mut h = Mat::from_fn(n_rest, n_loads, |i, j| self.loads[j][nd + i]);
        solve_lower(lower.as_ref(), h.as_mut());
        let root =
            dense_algebra::cholesky(product(h.transpose(), h.as_ref()).as_ref()).map_err(|error| match error {
                dense_algebra::Error::NotPositiveDefinite { pivot, .. } => Error::DependentLoad { load: pivot },
                other => other.into(),
            })?;
        let mut q = h.transpose().to_owned();
        solve_lower(root.as_ref(), q.as_mut());
        let q = q.transpose().to_owned();
        // Modes: of the mass on the complement of Q; its other eigenvalues, as many as loads, are zero.
        let complement = Mat::<f64>::identity(n_rest, n_rest) - product(q.as_ref(), q.transpose());
        let seen = dense_algebra::congruent(lower.as_ref(), m_rest.as_ref());
        let held = product(
            complement.as_ref(),
            product(seen.as_ref(), complement.as_ref()).as_ref(),
        );
        let (inverse, vectors) = dense_algebra::symmetric_eigen(held.as_ref())?;
        let mut shapes = Mat::from_fn(n_rest, n_modes, |i, j| {
            vectors[(i, n_rest - 1 - j)] / inverse[n_rest - 1 - j].sqrt()
        });
        solve_lower_transposed(lower.as_ref(), shapes.as_mut());
        let eigenvalues: Vec<f64> = inverse.iter().rev().take(n_modes).map(|v| 1.0 / v).collect();
        // Static response of the rest to the jump.
        let mut tension = Mat::from_fn(n_loads, nd, |i, j| self.loads[i][j]);
        solve_lower(root.as_ref(), tension.as_mut());
        let mut follow = product(q.as_ref(), tension.as_ref());
        follow *= faer::Scale(-1.0);
        solve_lower_transposed(lower.as_ref(), follow.as_mut());

        let n = nd + n_modes;
        let mut stiffness = Mat::zeros(n, n);
        let added = product(tension.transpose(), tension.as_ref());
        stiffness
            .submatrix_mut(0, 0, nd, nd)
            .copy_from(own_stiffness.submatrix(0, 0, nd, nd) + added);
        for (i, value) in eigenvalues.iter().enumerate() {
            stiffness[(nd + i, nd + i)] = *value;
        }
        let own = own_mass.submatrix(nd, 0, n_rest, nd);
        let momentum = product(m_rest.as_ref(), follow.as_ref()) + own;
        let coupling = product(shapes.transpose(), momentum.as_ref());
        let mut mass = Mat::zeros(n, n);
        let changed = product(own.transpose(), follow.as_ref()) + product(follow.transpose(), momentum.as_ref());
        mass.submatrix_mut(0, 0, nd, nd)
            .copy_from(own_mass.submatrix(0, 0, nd, nd) + dense_algebra::symmetric(changed.as_ref()));
        mass.submatrix_mut(nd, 0, n_modes, nd).copy_from(&coupling);
        mass.submatrix_mut(0, nd, nd, n_modes).copy_from(coupling.transpose());
        for i in nd..n {
            mass[(i, i)] = 1.0;
        }
        let recovered = self.recovery.subcols(nd, n_rest);
        let mut recovery = Mat::zeros(self.recovery.nrows(), n);
        recovery
            .subcols_mut(0, nd)
            .copy_from(self.recovery.subcols(0, nd) + product(recovered, follow.as_ref()));
        recovery
            .subcols_mut(nd, n_modes)
            .copy_from(product(recovered, shapes.as_ref()));
        let mut motions = Mat::zeros(n_rest, n);
        motions.subcols_mut(0, nd).copy_from(&follow);
        motions.subcols_mut(nd, n_modes).copy_from(&shapes);
        let locked = Self {
            mass: mass.into(),
            stiffness: stiffness.into(),
            loads: Vec::new(),
            n_relative: nd,
            n_attachment: 0,
            recovery,
            stuck_frequencies: eigenvalues
                .iter()
                .map(|w2| w2.sqrt() / (2.0 * std::f64::consts::PI))
                .collect(),
            zem_stuck: self.zem_stuck,
            asymmetry: self.asymmetry,
        };
        Ok((locked, motions))
    }

    /// What a model of blocks is without them: the combinations in the place of the jump, and nothing recovered from these.
    ///
    /// # Errors
    /// [`Error::OtherModel`] for matrices that do not share their tree.
    fn seen(&self) -> Result<Self, Error> {
        let (SystemMatrix::Blocks(stiffness), SystemMatrix::Blocks(mass)) = (&self.stiffness, &self.mass) else {
            return Err(Error::OtherModel { deviation: 1.0 });
        };
        if stiffness.tree() != mass.tree() {
            return Err(Error::OtherModel { deviation: 1.0 });
        }
        let over_core = |row: &Vec<f64>| {
            let column = MatRef::from_column_major_slice(row, row.len(), 1);
            stiffness.onto_core(column).col_as_slice(0).to_vec()
        };
        let mut recovery = Mat::zeros(self.recovery.nrows(), stiffness.core().nrows());
        let n_rest = self.size() - self.n_relative;
        recovery
            .subcols_mut(stiffness.rank(), n_rest)
            .copy_from(self.recovery.subcols(self.n_relative, n_rest));
        Ok(Self {
            mass: mass.seen().into(),
            stiffness: stiffness.seen().into(),
            loads: self.loads.iter().map(over_core).collect(),
            n_relative: stiffness.rank(),
            recovery,
            stuck_frequencies: self.stuck_frequencies.clone(),
            ..*self
        })
    }

    /// The model of blocks that `seen`, of [`Self::seen`] with held loads, is without them, and the motions of this one's coordinates in its own.
    fn with_seen(&self, small: &Self, seen: Self, motions: &Mat<f64>) -> (Self, Mat<f64>) {
        let (nd, rank) = (self.n_relative, small.n_relative);
        let over_blocks = |own: &SystemMatrix, seen: SystemMatrix| match own {
            SystemMatrix::Blocks(own) => SystemMatrix::Blocks(own.with_seen(seen.into_dense())),
            SystemMatrix::Dense(_) => seen,
        };
        // Rows over the combinations as rows over the jump.
        let over_jump = |rows: MatRef<'_, f64>| match &self.mass {
            SystemMatrix::Blocks(own) => own.from_core(rows.transpose()).transpose().to_owned(),
            SystemMatrix::Dense(_) => rows.to_owned(),
        };
        let n_modes = seen.recovery.ncols() - rank;
        let mut recovery = Mat::zeros(self.recovery.nrows(), nd + n_modes);
        recovery
            .subcols_mut(0, nd)
            .copy_from(self.recovery.subcols(0, nd) + over_jump(seen.recovery.subcols(0, rank)));
        recovery
            .subcols_mut(nd, n_modes)
            .copy_from(seen.recovery.subcols(rank, n_modes));
        let mut whole = Mat::zeros(motions.nrows(), nd + n_modes);
        whole.subcols_mut(0, nd).copy_from(over_jump(motions.subcols(0, rank)));
        whole.subcols_mut(nd, n_modes).copy_from(motions.subcols(rank, n_modes));
        let model = Self {
            mass: over_blocks(&self.mass, seen.mass),
            stiffness: over_blocks(&self.stiffness, seen.stiffness),
            n_relative: nd,
            recovery,
            ..seen
        };
        (model, whole)
    }
}
