//! Equilibria along a load factor: prediction, step halving, commits.

use crate::force::HystereticForce;
use crate::linear::{Motion, UnitLoad};
use crate::newton::{Balance, Equilibrium, Failure, Goal, LinearSolver, Load, NewtonSettings, Reason, Sequence};
use contact_laws::{RegimeCounts, Sticking};
use dense_algebra::{SystemMatrixRef, Vector, dot};

/// Smallest step of the load factor, relative to its range, before a failure is final.
const SMALLEST_STEP: f64 = 1e-3;

/// Degree of the polynomial that a branch is extrapolated with.
const DEGREE: usize = 2;

/// Longest extrapolation, relative to the distance of the points that it rests on.
const REACH: f64 = 4.0;

/// Steps before the two halves of the motions are brought together again: extrapolation lets the round-off between them
/// grow with the square of this number.
const FRESH: usize = 16;

/// Smallest share that two neighbouring solutions of one mode have in common (square of the cosine in the mass inner
/// product).
const SAME_MODE: f64 = 0.5;

/// Largest share of the load that the round-off of the contact forces may be: the motion is known no better than that.
const LARGEST_ROUND_OFF: f64 = 1e-2;

/// Largest sum of residual contact forces, relative to the contact forces of the path.
const LARGEST_IMBALANCE: f64 = 1e-3;

/// Equilibria along the factor of one load.
pub(crate) struct Path<'a, F: HystereticForce> {
    pub(crate) equilibrium: Equilibrium<'a, F>,
    pub(crate) unit: &'a UnitLoad,
    /// Largest factor of the path: tolerances and smallest steps refer to it.
    pub(crate) range: f64,
    /// Given: the factor is the amplitude of the motion, the load its own inertia, and the unit load a first guess.
    pub(crate) mass: Option<SystemMatrixRef<'a>>,
    pub(crate) sticking: Sticking,
    pub(crate) solver: LinearSolver,
    pub(crate) settings: NewtonSettings,
    pub(crate) sequence: Sequence<F>,
    /// Factor reached.
    pub(crate) at: f64,
    /// Largest sum of contact forces so far, from the reference (N).
    force: f64,
    /// Largest residual since it was last set to zero, relative to the load of the range (energy norm).
    pub(crate) residual: f64,
    /// The last points of the same branch before the one at hand, the later one first, for extrapolation.
    previous: Vec<(f64, Motion)>,
    /// The same branch in the cycle before, whose motions at the same factors the next ones are like.
    pub(crate) guide: Vec<(f64, Motion)>,
    /// Steps since the forces of the motions were last turned into their displacements.
    steps: usize,
}

impl<'a, F: HystereticForce> Path<'a, F> {
    pub(crate) fn new(
        equilibrium: Equilibrium<'a, F>,
        unit: &'a UnitLoad,
        range: f64,
        (solver, settings): (LinearSolver, NewtonSettings),
        sequence: Sequence<F>,
    ) -> Self {
        Self {
            equilibrium,
            unit,
            range,
            mass: None,
            sticking: Sticking::Coulomb,
            solver,
            settings,
            sequence,
            at: 0.0,
            force: 0.0,
            residual: 0.0,
            previous: Vec::new(),
            guide: Vec::new(),
            steps: 0,
        }
    }

    /// Solves at `factor` from the motion at hand.
    pub(crate) fn settle(&mut self, factor: f64) -> Result<RegimeCounts, Failure> {
        let scale = self.range * self.unit.norm();
        // Residuals below round-off count as converged, which says nothing where round-off is as large as the load. Without
        // any load there is nothing to compare with.
        if scale > 0.0 && self.equilibrium.round_off.energy > LARGEST_ROUND_OFF * scale {
            let share = self.equilibrium.round_off.energy / scale;
            return Err(Failure::of(Reason::BelowRoundOff, vec![share]));
        }
        let goal = Goal {
            factor,
            load: self.mass.map_or(Load::Pattern(&self.unit.force), Load::Inertia),
            scale,
            sticking: self.sticking,
            balance: Some(Balance {
                share: LARGEST_IMBALANCE,
                force: self.force,
            }),
        };
        let converged = self
            .equilibrium
            .solve(&mut self.sequence, &goal, self.solver, &self.settings)?;
        self.at = factor;
        self.force = self.force.max(converged.force);
        self.residual = self.residual.max(converged.residual);
        Ok(converged.counts)
    }

    /// [`settle`](Self::settle), refusing a motion of given amplitude that belongs to another mode than its neighbour.
    fn settle_beside(&mut self, factor: f64, neighbour: &Motion) -> Result<RegimeCounts, Failure> {
        let counts = self.settle(factor)?;
        let Some(mass) = self.mass else { return Ok(counts) };
        let known = if neighbour.v.iter().all(|&v| v == 0.0) {
            &self.unit.response.v
        } else {
            &neighbour.v
        };
        let mut inertia = vec![0.0; known.len()];
        mass.multiply(known, &mut inertia);
        let common = dot(&self.sequence.motion.v, &inertia) / factor;
        if common * common < SAME_MODE * dot(known, &inertia) {
            return Err(Failure::of(Reason::OtherMode, Vec::new()));
        }
        Ok(counts)
    }

    /// Goes to `goal` in one step. A step that fails is tried again from the last equilibrium as it stands, then halved.
    pub(crate) fn advance(&mut self, goal: f64) -> Result<RegimeCounts, Failure> {
        let mut targets = vec![goal];
        let mut counts = RegimeCounts::default();
        while let Some(&next) = targets.last() {
            if !self.sequence.effort.is_within_budget() {
                return Err(Failure::of(Reason::Budget, Vec::new()));
            }
            let (from, origin) = (self.at, self.sequence.motion.clone());
            let step = next - from;
            self.predict(next, &origin);
            let mut outcome = self.settle_beside(next, &origin);
            if outcome.is_err() && !self.equilibrium.limits.stops() {
                self.sequence.motion.copy_from(&origin);
                outcome = self.settle_beside(next, &origin);
            }
            match outcome {
                Ok(found) => {
                    self.previous.insert(0, (from, origin));
                    self.previous.truncate(DEGREE);
                    counts = found;
                    targets.pop();
                    self.steps += 1;
                    if self.steps == FRESH {
                        self.refresh();
                    }
                }
                Err(failure) => {
                    self.at = from;
                    self.sequence.motion.copy_from(&origin);
                    if matches!(failure.reason, Reason::BelowRoundOff | Reason::Interrupted)
                        || step.abs() < SMALLEST_STEP * self.range
                    {
                        return Err(failure);
                    }
                    targets.push(from + 0.5 * step);
                }
            }
        }
        Ok(counts)
    }

    /// Moves the motion on like the guide. Without one, to where the last points of the branch lead. Without any, as after a reversal, everything sticks,
    /// or a motion of given amplitude keeps its shape.
    fn predict(&mut self, next: f64, origin: &Motion) {
        let from = self.at;
        let guided = |at: f64| {
            self.guide
                .iter()
                .find(|(other, _)| *other == at)
                .map(|(_, motion)| motion)
        };
        if let (Some(there), Some(here)) = (guided(next), guided(from)) {
            self.sequence.motion.add(1.0, there);
            self.sequence.motion.add(-1.0, here);
            return;
        }
        // Points close together tell nothing of what is far away.
        let reached = |at: f64| (next - from).abs() <= REACH * (at - from).abs();
        let points: Vec<(f64, &Motion)> = std::iter::once((from, origin))
            .chain(
                self.previous
                    .iter()
                    .map(|(at, motion)| (*at, motion))
                    .filter(|(at, _)| reached(*at)),
            )
            .collect();
        if points.len() == 1 {
            if self.mass.is_none() || from == 0.0 {
                self.sequence.motion.add(next - from, &self.unit.response);
            }
            return;
        }
        for &(at, motion) in &points {
            // Lagrange's polynomial through the points.
            let others = points.iter().filter(|(other, _)| *other != at);
            let weight: f64 = others.map(|(other, _)| (next - other) / (at - other)).product();
            // The origin is there already.
            self.sequence
                .motion
                .add(if at == from { weight - 1.0 } else { weight }, motion);
        }
    }

    /// Brings the two halves of the motions together: both have taken the same steps, but each with its own round-off.
    fn refresh(&mut self) {
        for Motion { v, p } in self
            .previous
            .iter_mut()
            .map(|(_, motion)| motion)
            .chain([&mut self.sequence.motion])
        {
            self.equilibrium.stuck.solve_into(p, v);
        }
        self.steps = 0;
    }

    /// Makes the history reached the one that later solves start from, and forgets the way there.
    pub(crate) fn turn(&mut self) {
        self.sequence.commit();
        self.previous.clear();
        self.refresh();
    }
}
