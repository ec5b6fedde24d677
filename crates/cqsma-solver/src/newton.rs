//! Newton's method for the equilibrium of a structure with a hysteretic force.

use crate::force::HystereticForce;
use crate::linear::{Border, Motion, RoundOff, Stuck, solve_direct, solve_krylov, solve_near};
use contact_laws::{RegimeCounts, Sticking};
use dense_algebra::{Limits, SystemMatrixRef, Vector, dot};

/// Round-off of the forces, relative to that of one evaluation, that a residual may add up to.
const NOISE: f64 = 8.0;

/// Accuracy of Newton steps that are made for the balance of forces alone, relative.
const BALANCING: f64 = 1e-3;

/// When to stop, and when to give up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonSettings {
    /// Residual relative to the load, both in the energy norm.
    pub tolerance: f64,
    /// Most iterations per solve.
    pub max_iterations: usize,
    /// Most halvings of one step.
    pub max_halvings: usize,
}

impl Default for NewtonSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-9,
            max_iterations: 60,
            max_halvings: 12,
        }
    }
}

/// What ended a solve without success.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reason {
    /// Overflow, or values outside what the force can bear.
    #[error("the residual is not a finite number")]
    NotFinite,
    /// No descent along several directions.
    #[error("the residual stopped falling")]
    Stalled,
    /// The linear system has no solution.
    #[error("the tangent is singular")]
    Singular,
    /// The linear system of a structure in blocks, which has no direct solver, was not solved.
    #[error(
        "a linear system was not solved: joints slip or open so much that the stuck structure tells little of them; take a smaller amplitude, or \
         dense matrices by a `model.coupling_tolerance` of 0"
    )]
    Unsolved,
    /// A motion of given amplitude whose shape is not that of its neighbour.
    #[error("the solution belongs to another mode")]
    OtherMode,
    /// Too many iterations.
    #[error("the iteration limit was reached")]
    IterationLimit,
    /// Too many iterations for the equilibria found so far: the next ones would take as long.
    #[error(
        "more than {} iterations and {} for each equilibrium found were needed: points of very different stiffness slip and open \
         one by one; take a smaller amplitude, or laws that differ less",
        BUDGET[0],
        BUDGET[1]
    )]
    Budget,
    /// The run was interrupted; no result shows it.
    #[error("the run was interrupted")]
    Interrupted,
    /// The residual is small in the energy norm and large as a force: against a contact this stiff hardly any work is done.
    #[error(
        "the forces do not balance, although the residual is small in the energy norm: the contact is too stiff for this \
         tolerance, or for double precision; ask for a smaller tolerance, or make the contact softer"
    )]
    Unbalanced,
    /// The load is so small that the round-off of the contact forces is no small part of it. The history holds this part
    /// alone.
    #[error(
        "the load is within the round-off that the contact forces leave at the static state, so that neither frequency nor \
         damping can be told; take a larger amplitude"
    )]
    BelowRoundOff,
}

/// Why a solve gave up.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Failure {
    /// What happened.
    pub reason: Reason,
    /// Residual relative to the load at each iteration.
    pub history: Vec<f64>,
    /// Coordinate of the contact with the largest part of the last residual's energy; none where nothing was out of balance.
    #[cfg_attr(feature = "serde", serde(default))]
    pub coordinate: Option<usize>,
}

impl Failure {
    /// One that is no matter of a residual.
    pub(crate) fn of(reason: Reason, history: Vec<f64>) -> Self {
        Self {
            reason,
            history,
            coordinate: None,
        }
    }
}

/// Iterations that a sequence of solves may take, and those that each equilibrium found adds. Three to six each is usual.
pub(crate) const BUDGET: [usize; 2] = [2000, 10];

/// How a solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Effort {
    /// Equilibria found.
    pub solves: usize,
    /// Newton iterations.
    pub iterations: usize,
    /// Evaluations of the force.
    pub evaluations: usize,
    /// Preconditioned Krylov steps.
    pub krylov_steps: usize,
    /// Direct factorisations.
    pub factorisations: usize,
}

impl Effort {
    pub(crate) fn is_within_budget(&self) -> bool {
        self.iterations <= BUDGET[0] + BUDGET[1] * self.solves
    }
}

impl std::ops::AddAssign for Effort {
    fn add_assign(&mut self, other: Self) {
        self.solves += other.solves;
        self.iterations += other.iterations;
        self.evaluations += other.evaluations;
        self.krylov_steps += other.krylov_steps;
        self.factorisations += other.factorisations;
    }
}

/// A converged solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Converged {
    pub(crate) residual: f64,
    pub(crate) counts: RegimeCounts,
    /// Sum of the magnitudes of the contact forces, from the reference (N).
    pub(crate) force: f64,
}

/// How the linear systems of Newton's method are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinearSolver {
    /// GMRES with the inverse of the stuck tangent, and an LU factorisation where it does not converge.
    #[default]
    Krylov,
    /// An LU factorisation of the tangent at every iteration: slow, and independent of the other solver.
    Direct,
}

/// `K v + F(u0 + v) - F0 = load`: equilibrium in increments `v` from a reference state, so that small increments do not
/// drown in the round-off of the prestress.
pub(crate) struct Equilibrium<'a, F: HystereticForce> {
    pub(crate) stiffness: SystemMatrixRef<'a>,
    pub(crate) force: &'a F,
    pub(crate) stuck: &'a Stuck,
    pub(crate) reference: &'a [f64],
    pub(crate) reference_force: &'a [f64],
    /// Below it a residual is round-off.
    pub(crate) round_off: RoundOff,
    /// Asked before each iteration.
    pub(crate) limits: Limits<'a>,
}

/// The load of a solve.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Load<'a> {
    /// The factor times a pattern.
    Pattern(&'a [f64]),
    /// The inertia `lambda M v` of the motion itself, whose modal amplitude `sqrt(v^T M v)` is the factor; `lambda` is
    /// found along with the motion.
    Inertia(SystemMatrixRef<'a>),
}

/// What a solve must reach.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal<'a> {
    pub(crate) factor: f64,
    pub(crate) load: Load<'a>,
    /// Energy norm that the tolerance refers to.
    pub(crate) scale: f64,
    pub(crate) sticking: Sticking,
    /// What the contact forces must satisfy beside the energy norm; none where nothing is known of their size.
    pub(crate) balance: Option<Balance>,
}

/// Balance of the contact forces. In the energy norm alone a stiff contact hides forces that are out of balance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Balance {
    /// Largest sum of residual contact forces over that of the contact forces themselves, from the reference.
    pub(crate) share: f64,
    /// What the latter was so far (N).
    pub(crate) force: f64,
}

/// State, buffers and history of one sequence of solves.
pub(crate) struct Sequence<F: HystereticForce> {
    /// Increment from the reference.
    pub(crate) motion: Motion,
    /// History at the last commit.
    pub(crate) begin: F::State,
    /// History reached by the last solve.
    pub(crate) end: F::State,
    /// Square of the frequency at the last evaluation with [`Load::Inertia`].
    pub(crate) lambda: f64,
    pub(crate) effort: Effort,
    /// What the last evaluation left: that at the solution, after a solve.
    pub(crate) workspace: F::Workspace,
    total: Vec<f64>,
    /// Force of the contact at the last evaluation: that at the solution, after a solve.
    pub(crate) contact: Vec<f64>,
    /// That at the last evaluation.
    pub(crate) tangent: Vec<f64>,
    /// Preconditioner that takes the place of the stuck structure where the tangent is nearer to it.
    pub(crate) slipping: Option<Stuck>,
    trial: Motion,
    /// Residual force, and the stuck structure's response to it.
    residual: Motion,
    /// With [`Load::Inertia`]: the force `M v`, and the stuck structure's response to it.
    inertia: Motion,
}

impl<F: HystereticForce> Sequence<F> {
    pub(crate) fn new(force: &F, motion: Motion, begin: F::State) -> Self {
        let n = motion.v.len();
        Self {
            end: begin.clone(),
            begin,
            lambda: f64::NAN,
            effort: Effort::default(),
            workspace: force.workspace(),
            total: vec![0.0; force.n_dofs()],
            contact: vec![0.0; force.n_dofs()],
            tangent: vec![0.0; force.pattern().indices.len()],
            slipping: None,
            trial: motion.clone(),
            residual: Motion::zero(n),
            inertia: Motion::zero(n),
            motion,
        }
    }

    /// The contact coordinate with the largest part of the residual's energy.
    fn least_balanced(&self) -> Option<usize> {
        let Motion { v, p } = &self.residual;
        let energies = p.iter().zip(v).take(self.contact.len()).map(|(p, v)| (p * v).abs());
        let largest = energies.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
        largest.filter(|(_, energy)| *energy > 0.0).map(|(at, _)| at)
    }

    /// Makes the history reached by the last solve the one that later solves start from.
    pub(crate) fn commit(&mut self) {
        std::mem::swap(&mut self.begin, &mut self.end);
    }
}

impl<F: HystereticForce> Equilibrium<'_, F> {
    /// Leaves residual and tangent at `sequence.trial` in the sequence, with [`Load::Inertia`] after bringing the trial to the
    /// amplitude of the goal; returns the residual's energy norm.
    fn evaluate(&self, sequence: &mut Sequence<F>, goal: &Goal<'_>) -> (f64, RegimeCounts) {
        if let Load::Inertia(mass) = goal.load {
            mass.multiply(&sequence.trial.v, &mut sequence.inertia.p);
            let factor = goal.factor / dot(&sequence.trial.v, &sequence.inertia.p).sqrt();
            sequence.trial.scale(factor);
            sequence.inertia.p.iter_mut().for_each(|p| *p *= factor);
            self.stuck.solve_into(&sequence.inertia.p, &mut sequence.inertia.v);
        }
        let Motion { v, p } = &sequence.trial;
        for ((total, u), v) in sequence.total.iter_mut().zip(self.reference).zip(v) {
            *total = u + v;
        }
        let counts = self.force.evaluate(
            &sequence.total,
            goal.sticking,
            &sequence.begin,
            &mut sequence.end,
            &mut sequence.workspace,
            &mut sequence.contact,
            Some(&mut sequence.tangent),
        );
        let residual = &mut sequence.residual.p;
        residual.fill(0.0);
        self.force.pattern().add_product(self.stuck.tangent(), v, residual);
        for (r, p) in residual.iter_mut().zip(p) {
            *r = p - *r;
        }
        for (r, (f, f0)) in residual
            .iter_mut()
            .zip(sequence.contact.iter().zip(self.reference_force))
        {
            *r += f - f0;
        }
        let (factor, load) = match goal.load {
            Load::Pattern(pattern) => (goal.factor, pattern),
            Load::Inertia(_) => {
                // The one that leaves the smallest residual.
                let Motion { v, p } = &sequence.inertia;
                sequence.lambda = dot(v, residual) / dot(v, p);
                (sequence.lambda, p.as_slice())
            }
        };
        for (r, load) in residual.iter_mut().zip(load) {
            *r -= factor * load;
        }
        self.stuck.solve_into(residual, &mut sequence.residual.v);
        sequence.effort.evaluations += 1;
        // A residual that is not finite must not pass for a small one.
        let square = dot(&sequence.residual.p, &sequence.residual.v);
        (if square >= 0.0 { square.sqrt() } else { f64::NAN }, counts)
    }

    /// Sums of the magnitudes of the residual at the contact coordinates, and of the contact forces from the reference (N).
    fn balance(&self, sequence: &Sequence<F>) -> (f64, f64) {
        let sum = |terms: &mut dyn Iterator<Item = f64>| terms.fold(0.0, |sum, term| sum + term.abs());
        let changes = sequence.contact.iter().zip(self.reference_force).map(|(f, f0)| f - f0);
        let residual = sequence.residual.p[..sequence.contact.len()].iter().copied();
        (sum(&mut { residual }), sum(&mut { changes }))
    }

    /// Newton step from the residual and tangent in the sequence.
    fn step(
        &self,
        sequence: &mut Sequence<F>,
        load: Load<'_>,
        merit: f64,
        tolerance: f64,
        solver: LinearSolver,
    ) -> Option<Motion> {
        let (pattern, tangent) = (self.force.pattern(), &sequence.tangent);
        let border = match load {
            Load::Pattern(_) => None,
            Load::Inertia(mass) => Some(Border {
                mass,
                lambda: sequence.lambda,
                inertia: &sequence.inertia,
            }),
        };
        let border = border.as_ref();
        if solver == LinearSolver::Krylov {
            let slipping = sequence.slipping.as_ref();
            let near = slipping.filter(|slipping| border.is_none() && slipping.is_nearer(tangent, self.stuck));
            let residual = &sequence.residual;
            let found = near
                .and_then(|near| solve_near(near, self.stuck, pattern, tangent, &residual.p, tolerance))
                .or_else(|| solve_krylov(self.stuck, pattern, tangent, border, residual, merit, tolerance));
            if let Some((step, steps)) = found {
                sequence.effort.krylov_steps += steps;
                return Some(step);
            }
        }
        sequence.effort.factorisations += usize::from(self.stiffness.dense().is_some());
        let v = solve_direct(self.stiffness, pattern, tangent, border, &sequence.residual.p)?;
        let mut p = vec![0.0; v.len()];
        self.stiffness.multiply(&v, &mut p);
        pattern.add_product(self.stuck.tangent(), &v, &mut p);
        Some(Motion { v, p })
    }

    /// Solves for the goal from the guess in `sequence.motion`.
    ///
    /// On success `sequence.motion` and `sequence.end` belong to the solution; on failure `sequence.motion` is left where the search
    /// ended.
    pub(crate) fn solve(
        &self,
        sequence: &mut Sequence<F>,
        goal: &Goal<'_>,
        solver: LinearSolver,
        settings: &NewtonSettings,
    ) -> Result<Converged, Failure> {
        let mut history = Vec::new();
        let fail = |reason, history, sequence: &Sequence<F>| {
            let coordinate = sequence.least_balanced();
            Err(Failure {
                reason,
                history,
                coordinate,
            })
        };
        let target = (settings.tolerance * goal.scale).max(self.round_off.energy);
        sequence.trial.copy_from(&sequence.motion);
        let (mut merit, mut counts) = self.evaluate(sequence, goal);
        sequence.motion.copy_from(&sequence.trial);
        // Steps that did not reduce the residual although they were cut short.
        let mut stalled = 0;
        let mut iteration = 0;
        loop {
            history.push(merit / goal.scale);
            if !merit.is_finite() {
                return fail(Reason::NotFinite, history, sequence);
            }
            let is_small = merit <= target;
            if is_small {
                let (unbalanced, force) = self.balance(sequence);
                let is_balanced = goal.balance.is_none_or(|balance| {
                    unbalanced <= balance.share * force.max(balance.force) + NOISE * self.round_off.force
                });
                if is_balanced {
                    sequence.effort.solves += 1;
                    return Ok(Converged {
                        residual: merit / goal.scale,
                        counts,
                        force,
                    });
                }
            }
            let or_unbalanced = |reason| if is_small { Reason::Unbalanced } else { reason };
            if stalled > 3 {
                return fail(or_unbalanced(Reason::Stalled), history, sequence);
            }
            if self.limits.stops() {
                return fail(Reason::Interrupted, history, sequence);
            }
            self.limits
                .done((history[0] * goal.scale / merit).ln() / (history[0] * goal.scale / target).ln());
            if iteration == settings.max_iterations {
                return fail(or_unbalanced(Reason::IterationLimit), history, sequence);
            }
            sequence.effort.iterations += 1;
            // Far from the solution an accurate step is wasted; near it the forcing term follows the residual, which
            // keeps the convergence superlinear. More than a tenth of the target is never needed.
            let forcing = (0.01 * merit / goal.scale)
                .sqrt()
                .min(0.1)
                .max(if is_small { BALANCING } else { 0.1 * target / merit })
                .min(0.5);
            let Some(step) = self.step(sequence, goal.load, merit, forcing, solver) else {
                let reason = match self.stiffness {
                    SystemMatrixRef::Dense(_) => Reason::Singular,
                    SystemMatrixRef::Blocks(_) => Reason::Unsolved,
                };
                return fail(or_unbalanced(reason), history, sequence);
            };
            let mut length = 1.0;
            let mut best = (f64::INFINITY, 1.0);
            for halving in 0..=settings.max_halvings {
                sequence.trial.copy_from(&sequence.motion);
                sequence.trial.add(-length, &step);
                let (next, next_counts) = self.evaluate(sequence, goal);
                (merit, counts) = (next, next_counts);
                if next < best.0 {
                    best = (next, length);
                }
                if next <= (1.0 - 1e-4 * length) * history[iteration] * goal.scale {
                    break;
                }
                if halving == settings.max_halvings {
                    // No descent along this direction: a kink. Take the best point seen, unless it is far worse, and let
                    // the tangent there show another side of it.
                    if best.0 > 2.0 * history[iteration] * goal.scale {
                        return fail(or_unbalanced(Reason::Stalled), history, sequence);
                    }
                    stalled += 1;
                    sequence.trial.copy_from(&sequence.motion);
                    sequence.trial.add(-best.1, &step);
                    (merit, counts) = self.evaluate(sequence, goal);
                    break;
                }
                length *= 0.5;
            }
            sequence.motion.copy_from(&sequence.trial);
            iteration += 1;
        }
    }
}
