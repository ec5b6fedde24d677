//! Static states in which some loads have a given tension and the displacement of others is held, condensed to the jump.
//!
//! With `l = [l_D; l_r]` and the compliance `S = l_r^T K_r^-1 l_r` at the loads, the rest follows tensions `T` as
//! `u_r = K_r^-1 l_r T`, so that the displacement of the loads is `l^T u = l_D^T u_D + S T`. Held displacements give the tensions of
//! their loads, and the jump alone remains.

use crate::Error;
use crate::craig_bampton::ReducedModel;
use dense_algebra::{SystemMatrix, product, solve_lower, solve_lower_transposed};
use faer::Mat;

/// What is known of a load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold {
    /// Its tension (N).
    Tension(f64),
    /// Its displacement `l^T u` (m), as of a tightened nut.
    Displacement(f64),
}

/// A reduced structure with the compliance at its loads.
#[derive(Clone, Debug)]
pub struct LoadCompliance<'a> {
    model: &'a ReducedModel,
    /// `K_r^-1 l_r`, load by load.
    responses: Mat<f64>,
    /// `S` (m/N).
    compliance: Mat<f64>,
}

/// The static problem over the jump: `stiffness u_D + F(u_D) = load`.
#[derive(Clone, Debug)]
pub struct HeldSystem {
    /// Stiffness over the jump (N/m).
    pub stiffness: SystemMatrix,
    /// Load over the jump (N).
    pub load: Vec<f64>,
    /// Tension of every load where the jump is zero (N).
    tension: Vec<f64>,
    /// Change of the tensions with the jump, load by load (N/m); nothing for those of given tension.
    change: Mat<f64>,
}

impl ReducedModel {
    /// The compliance at the loads.
    ///
    /// # Errors
    /// [`Error::NoAttachmentModes`] for a model reduced without them, which would be far too stiff. [`Error::DependentLoad`] for loads
    /// that act on the jump alone, whose displacement no elongation could hold.
    pub fn load_compliance(&self) -> Result<LoadCompliance<'_>, Error> {
        let n_loads = self.loads.len();
        if self.n_attachment != n_loads {
            return Err(Error::NoAttachmentModes {
                loads: n_loads,
                attachment: self.n_attachment,
            });
        }
        let nd = self.n_relative;
        let n_rest = self.size() - nd;
        let loads = Mat::from_fn(n_rest, n_loads, |i, j| self.loads[j][nd + i]);
        let lower = dense_algebra::cholesky(self.stiffness_of_rest().as_ref())?;
        let mut responses = loads.clone();
        solve_lower(lower.as_ref(), responses.as_mut());
        solve_lower_transposed(lower.as_ref(), responses.as_mut());
        let compliance = dense_algebra::symmetric(product(loads.transpose(), responses.as_ref()).as_ref());
        // Also catches NaN.
        if let Some(load) = (0..n_loads).find(|&i| !(compliance[(i, i)] > 0.0)) {
            return Err(Error::DependentLoad { load });
        }
        Ok(LoadCompliance {
            model: self,
            responses,
            compliance,
        })
    }
}

impl ReducedModel {
    /// The stiffness between coordinates behind the jump.
    fn stiffness_of_rest(&self) -> Mat<f64> {
        let (nd, n_rest) = (self.n_relative, self.size() - self.n_relative);
        match &self.stiffness {
            SystemMatrix::Dense(stiffness) => stiffness.submatrix(nd, nd, n_rest, n_rest).to_owned(),
            SystemMatrix::Blocks(stiffness) => {
                let rank = stiffness.rank();
                stiffness.seen().submatrix(rank, rank, n_rest, n_rest).to_owned()
            }
        }
    }
}

impl LoadCompliance<'_> {
    /// The problem over the jump with `holds` for the loads, in their order.
    ///
    /// # Errors
    /// [`Error::DependentLoad`] where held displacements depend on one another.
    pub fn held(&self, holds: &[Hold]) -> Result<HeldSystem, Error> {
        let (model, nd, n_loads) = (self.model, self.model.n_relative, self.model.loads.len());
        let mut tension: Vec<f64> = (0..n_loads)
            .map(|i| match holds.get(i) {
                Some(Hold::Tension(tension)) => *tension,
                _ => 0.0,
            })
            .collect();
        let held: Vec<(usize, f64)> = holds
            .iter()
            .take(n_loads)
            .enumerate()
            .filter_map(|(load, hold)| match hold {
                Hold::Displacement(displacement) => Some((load, *displacement)),
                Hold::Tension(_) => None,
            })
            .collect();
        let own = Mat::from_fn(held.len(), held.len(), |i, j| self.compliance[(held[i].0, held[j].0)]);
        let lower = dense_algebra::cholesky(own.as_ref()).map_err(|error| match error {
            dense_algebra::Error::NotPositiveDefinite { pivot, .. } => Error::DependentLoad {
                load: held.get(pivot).map_or(0, |(load, _)| *load),
            },
            other => other.into(),
        })?;
        // Tensions of the held loads are S_HH^-1 (what is held - S_HT T - l_D^T u_D).
        let mut known = Mat::from_fn(held.len(), 1, |i, _| {
            let (load, displacement) = held[i];
            let by_others: f64 = (0..n_loads).map(|j| self.compliance[(load, j)] * tension[j]).sum();
            displacement - by_others
        });
        let mut change = Mat::from_fn(held.len(), nd, |i, j| -model.loads[held[i].0][j]);
        for right in [&mut known, &mut change] {
            solve_lower(lower.as_ref(), right.as_mut());
            solve_lower_transposed(lower.as_ref(), right.as_mut());
        }
        for (i, (load, _)) in held.iter().enumerate() {
            tension[*load] = known[(i, 0)];
        }
        let mut all = Mat::zeros(n_loads, nd);
        for (i, (load, _)) in held.iter().enumerate() {
            all.subrows_mut(*load, 1).copy_from(change.subrows(i, 1));
        }
        let load = (0..nd)
            .map(|i| (0..n_loads).map(|j| tension[j] * model.loads[j][i]).sum())
            .collect();
        let over_jump = Mat::from_fn(nd, n_loads, |i, j| model.loads[j][i]);
        let stiffness = match &model.stiffness {
            SystemMatrix::Dense(stiffness) => {
                let added = product(over_jump.as_ref(), all.as_ref());
                SystemMatrix::Dense(stiffness.submatrix(0, 0, nd, nd) - dense_algebra::symmetric(added.as_ref()))
            }
            SystemMatrix::Blocks(stiffness) => {
                let stiffness = stiffness.groups_alone();
                let (loads, change) = (
                    stiffness.onto_core(over_jump.as_ref()),
                    stiffness.onto_core(all.transpose()),
                );
                let added = dense_algebra::symmetric(product(loads.as_ref(), change.transpose()).as_ref());
                SystemMatrix::Blocks(stiffness.with_seen(stiffness.seen() - added))
            }
        };
        Ok(HeldSystem {
            stiffness,
            load,
            tension,
            change: all,
        })
    }

    /// All coordinates of the model where the jump and all tensions (N) are known.
    pub fn displacement(&self, jump: &[f64], tensions: &[f64]) -> Vec<f64> {
        let rest = (0..self.responses.nrows()).map(|i| {
            let terms = tensions
                .iter()
                .enumerate()
                .map(|(j, tension)| self.responses[(i, j)] * tension);
            terms.sum::<f64>()
        });
        jump.iter().copied().chain(rest).collect()
    }

    /// Displacements `l^T u` of the loads (m) where the jump and all tensions (N) are known.
    pub fn displacements_of_loads(&self, jump: &[f64], tensions: &[f64]) -> Vec<f64> {
        let at = |(i, load): (usize, &Vec<f64>)| {
            let own: f64 = load.iter().zip(jump).map(|(l, u)| l * u).sum();
            let elastic = tensions.iter().enumerate().map(|(j, t)| self.compliance[(i, j)] * t);
            own + elastic.sum::<f64>()
        };
        self.model.loads.iter().enumerate().map(at).collect()
    }
}

impl HeldSystem {
    /// Tension of every load where the jump is known (N).
    pub fn tensions(&self, jump: &[f64]) -> Vec<f64> {
        let change = |i: usize| {
            jump.iter()
                .enumerate()
                .map(|(j, u)| self.change[(i, j)] * u)
                .sum::<f64>()
        };
        self.tension
            .iter()
            .enumerate()
            .map(|(i, tension)| tension + change(i))
            .collect()
    }
}
