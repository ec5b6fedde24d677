//! Equilibria along a load factor: prediction, step halving, commits.

use crate::force::{HystereticForce, PointCounts, Sliding};
use crate::linear::Motion;
use crate::newton::{Equilibrium, Failure, Goal, LinearSolver, NewtonSettings, Walk};

/// Smallest step of the load factor, relative to its range, before a failure is final.
const SMALLEST_STEP: f64 = 1e-3;

/// A walk along the factor of one load.
pub(crate) struct Path<'a, F: HystereticForce> {
    pub(crate) equilibrium: Equilibrium<'a, F>,
    /// Unit load, and the stuck structure's response to it.
    pub(crate) unit: &'a Motion,
    /// Largest factor of the walk: tolerances and smallest steps refer to it.
    pub(crate) range: f64,
    pub(crate) sliding: Sliding,
    pub(crate) solver: LinearSolver,
    pub(crate) settings: NewtonSettings,
    pub(crate) walk: Walk<F>,
    /// Factor reached.
    pub(crate) at: f64,
    /// Largest residual since it was last set to zero, relative to the load of the range (energy norm).
    pub(crate) residual: f64,
    /// An earlier point of the same branch, for extrapolation.
    previous: Option<(f64, Motion)>,
}

impl<'a, F: HystereticForce> Path<'a, F> {
    pub(crate) fn new(
        equilibrium: Equilibrium<'a, F>,
        unit: &'a Motion,
        range: f64,
        (solver, settings): (LinearSolver, NewtonSettings),
        walk: Walk<F>,
    ) -> Self {
        Self {
            equilibrium,
            unit,
            range,
            sliding: Sliding::Allowed,
            solver,
            settings,
            walk,
            at: 0.0,
            residual: 0.0,
            previous: None,
        }
    }

    /// Solves at `factor` from the motion at hand.
    pub(crate) fn settle(&mut self, factor: f64) -> Result<PointCounts, Failure> {
        let goal = Goal {
            factor,
            pattern: &self.unit.p,
            scale: self.range * self.unit.norm(),
            sliding: self.sliding,
        };
        let converged = self
            .equilibrium
            .solve(&mut self.walk, &goal, self.solver, &self.settings)?;
        self.at = factor;
        self.residual = self.residual.max(converged.residual);
        Ok(converged.counts)
    }

    /// Walks to `goal` in one step. A step that fails is tried again from the last equilibrium as it stands, then halved.
    pub(crate) fn advance(&mut self, goal: f64) -> Result<PointCounts, Failure> {
        let mut targets = vec![goal];
        let mut counts = PointCounts::default();
        while let Some(&next) = targets.last() {
            let (from, origin) = (self.at, self.walk.motion.clone());
            let step = next - from;
            match &self.previous {
                // Along the secant of the branch.
                Some((earlier, motion)) if *earlier != from => {
                    let ratio = step / (from - earlier);
                    self.walk.motion.add(ratio, &origin);
                    self.walk.motion.add(-ratio, motion);
                }
                // After a reversal everything sticks.
                _ => self.walk.motion.add(step, self.unit),
            }
            let outcome = self.settle(next).or_else(|_| {
                self.walk.motion.copy_from(&origin);
                self.settle(next)
            });
            match outcome {
                Ok(found) => {
                    self.previous = Some((from, origin));
                    counts = found;
                    targets.pop();
                }
                Err(failure) => {
                    self.walk.motion.copy_from(&origin);
                    if step.abs() < SMALLEST_STEP * self.range {
                        return Err(failure);
                    }
                    targets.push(from + 0.5 * step);
                }
            }
        }
        Ok(counts)
    }

    /// Makes the history reached the one that later solves start from, and forgets the way there.
    pub(crate) fn turn(&mut self) {
        self.walk.commit();
        self.previous = None;
        // Both halves of the motion have taken the same steps; this keeps their round-off from growing with the walk.
        let Motion { v, p } = &mut self.walk.motion;
        self.equilibrium.stuck.solve_into(p, v);
    }
}
