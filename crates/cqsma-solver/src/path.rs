//! Equilibria along a load factor: prediction, step halving, commits.

use crate::force::{HystereticForce, PointCounts, Sliding};
use crate::linear::Motion;
use crate::newton::{Equilibrium, Failure, Goal, LinearSolver, NewtonSettings, Walk};

/// Smallest step of the load factor, relative to its range, before a failure is final.
const SMALLEST_STEP: f64 = 1e-3;

/// Degree of the polynomial that a branch is extrapolated with.
const DEGREE: usize = 2;

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
    /// The last points of the same branch before the one at hand, the later one first, for extrapolation.
    previous: Vec<(f64, Motion)>,
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
            previous: Vec::new(),
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
            self.predict(next, &origin);
            let outcome = self.settle(next).or_else(|_| {
                self.walk.motion.copy_from(&origin);
                self.settle(next)
            });
            match outcome {
                Ok(found) => {
                    self.previous.insert(0, (from, origin));
                    self.previous.truncate(DEGREE);
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

    /// Moves the motion on to where the last points of the branch lead; after a reversal everything sticks.
    fn predict(&mut self, next: f64, origin: &Motion) {
        let from = self.at;
        if self.previous.is_empty() {
            self.walk.motion.add(next - from, self.unit);
            return;
        }
        let points = || std::iter::once((from, origin)).chain(self.previous.iter().map(|(at, motion)| (*at, motion)));
        for (at, motion) in points() {
            // Lagrange's polynomial through the points.
            let weight: f64 = points()
                .filter(|(other, _)| *other != at)
                .map(|(other, _)| (next - other) / (at - other))
                .product();
            // The origin is there already.
            self.walk
                .motion
                .add(if at == from { weight - 1.0 } else { weight }, motion);
        }
    }

    /// Makes the history reached the one that later solves start from, and forgets the way there.
    pub(crate) fn turn(&mut self) {
        self.walk.commit();
        self.previous.clear();
        // Both halves of the motion have taken the same steps; this keeps their round-off from growing with the walk.
        let Motion { v, p } = &mut self.walk.motion;
        self.equilibrium.stuck.solve_into(p, v);
    }
}
