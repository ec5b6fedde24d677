//! Newton's method for the equilibrium of a structure with a hysteretic force.

use crate::force::{HystereticForce, PointCounts, Sliding};
use crate::linear::{StuckFactor, multiply, norm, solve_direct, solve_krylov};
use faer::MatRef;

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

/// Why a solve gave up.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// What happened.
    pub reason: &'static str,
    /// Residual relative to the load at each iteration.
    pub history: Vec<f64>,
}

/// How a solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Newton iterations.
    pub iterations: usize,
    /// Evaluations of the force.
    pub evaluations: usize,
    /// Preconditioned Krylov steps.
    pub krylov_steps: usize,
    /// Direct factorisations.
    pub factorisations: usize,
}

impl std::ops::AddAssign for Effort {
    fn add_assign(&mut self, other: Self) {
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
    pub(crate) counts: PointCounts,
}

/// How the linear systems are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Strategy {
    /// LU of the tangent at every iteration.
    Direct,
    /// GMRES with the stuck factor, LU where it does not converge.
    Krylov,
}

/// `K v + F(u0 + v) - F0 = load`: equilibrium in increments `v` from a reference state, so that small increments do not
/// drown in the round-off of the prestress.
pub(crate) struct Equilibrium<'a, F: HystereticForce> {
    pub(crate) stiffness: MatRef<'a, f64>,
    pub(crate) force: &'a F,
    pub(crate) factor: &'a StuckFactor,
    pub(crate) reference: &'a [f64],
    pub(crate) reference_force: &'a [f64],
}

/// Buffers and history of one sequence of solves.
pub(crate) struct Walk<F: HystereticForce> {
    /// Increment from the reference.
    pub(crate) v: Vec<f64>,
    /// History at the last commit.
    pub(crate) begin: F::State,
    /// History reached by the last solve.
    pub(crate) end: F::State,
    pub(crate) effort: Effort,
    workspace: F::Workspace,
    total: Vec<f64>,
    contact: Vec<f64>,
    residual: Vec<f64>,
    scaled: Vec<f64>,
    tangent: Vec<f64>,
}

impl<F: HystereticForce> Walk<F> {
    pub(crate) fn new(force: &F, v: Vec<f64>, begin: F::State) -> Self {
        let n = v.len();
        Self {
            end: begin.clone(),
            begin,
            effort: Effort::default(),
            workspace: force.workspace(),
            total: vec![0.0; force.n_dofs()],
            contact: vec![0.0; force.n_dofs()],
            residual: vec![0.0; n],
            scaled: Vec::with_capacity(n),
            tangent: vec![0.0; force.pattern().indices.len()],
            v,
        }
    }

    /// Makes the history reached by the last solve the one that later solves start from.
    pub(crate) fn commit(&mut self) {
        std::mem::swap(&mut self.begin, &mut self.end);
    }
}

impl<F: HystereticForce> Equilibrium<'_, F> {
    /// Residual at the increment `trial`; leaves `L^-1 r` in `walk.scaled` and returns its norm.
    fn residual(
        &self,
        walk: &mut Walk<F>,
        trial: &[f64],
        load: &[f64],
        sliding: Sliding,
        with_tangent: bool,
    ) -> (f64, PointCounts) {
        let nc = self.force.n_dofs();
        for i in 0..nc {
            walk.total[i] = self.reference[i] + trial[i];
        }
        let tangent = with_tangent.then_some(&mut walk.tangent[..]);
        let (begin, end) = (&walk.begin, &mut walk.end);
        let counts = self.force.evaluate(
            &walk.total,
            sliding,
            begin,
            end,
            &mut walk.workspace,
            &mut walk.contact,
            tangent,
        );
        multiply(self.stiffness, trial, &mut walk.residual);
        for (i, r) in walk.residual.iter_mut().enumerate() {
            *r -= load[i];
            if i < nc {
                *r += walk.contact[i] - self.reference_force[i];
            }
        }
        walk.effort.evaluations += 1;
        (self.factor.energy_norm(&walk.residual, &mut walk.scaled), counts)
    }

    /// Solves for `load` from the guess in `walk.v`; `scale` is the energy norm that the tolerance refers to.
    ///
    /// On success `walk.v` and `walk.end` belong to the solution; on failure `walk.v` is left where the search ended.
    pub(crate) fn solve(
        &self,
        walk: &mut Walk<F>,
        load: &[f64],
        scale: f64,
        sliding: Sliding,
        strategy: Strategy,
        settings: &NewtonSettings,
    ) -> Result<Converged, Failure> {
        let mut history = Vec::new();
        let fail = |reason, history| Err(Failure { reason, history });
        let start = walk.v.clone();
        let (mut merit, mut counts) = self.residual(walk, &start, load, sliding, true);
        let mut trial = start;
        // Steps that did not reduce the residual although they were cut short.
        let mut stalled = 0;
        for _ in 0..settings.max_iterations {
            history.push(merit / scale);
            if !merit.is_finite() {
                return fail("the residual is not a finite number", history);
            }
            if merit <= settings.tolerance * scale {
                return Ok(Converged {
                    residual: merit / scale,
                    counts,
                });
            }
            walk.effort.iterations += 1;
            // Far from the solution an accurate step is wasted; near it the forcing term follows the residual, which
            // keeps the convergence superlinear.
            let forcing = (0.1 * merit / scale).sqrt().clamp(1e-6, 1e-2);
            let pattern = self.force.pattern();
            let krylov = match strategy {
                Strategy::Krylov => solve_krylov(self.factor, pattern, &walk.tangent, &walk.scaled, forcing),
                Strategy::Direct => None,
            };
            let step = match krylov {
                Some((step, steps)) => {
                    walk.effort.krylov_steps += steps;
                    step
                }
                None => {
                    walk.effort.factorisations += 1;
                    match solve_direct(self.stiffness, pattern, &walk.tangent, &walk.residual) {
                        Some(step) => step,
                        None => return fail("the tangent is singular", history),
                    }
                }
            };
            let mut length = 1.0;
            let mut best = (f64::INFINITY, 1.0);
            for halving in 0..=settings.max_halvings {
                for i in 0..trial.len() {
                    trial[i] = walk.v[i] - length * step[i];
                }
                let (next, next_counts) = self.residual(walk, &trial, load, sliding, true);
                counts = next_counts;
                if next < best.0 {
                    best = (next, length);
                }
                if next <= (1.0 - 1e-4 * length) * merit {
                    break;
                }
                if halving == settings.max_halvings {
                    // No descent along this direction: a kink. Take the best point seen and let the next tangent
                    // show another side of it.
                    stalled += 1;
                    length = best.1;
                    for i in 0..trial.len() {
                        trial[i] = walk.v[i] - length * step[i];
                    }
                    (_, counts) = self.residual(walk, &trial, load, sliding, true);
                    break;
                }
                length *= 0.5;
            }
            walk.v.copy_from_slice(&trial);
            merit = norm(&walk.scaled);
            if stalled > 3 {
                history.push(merit / scale);
                return fail("the residual stopped falling", history);
            }
        }
        history.push(merit / scale);
        if merit <= settings.tolerance * scale {
            return Ok(Converged {
                residual: merit / scale,
                counts,
            });
        }
        fail("the iteration limit was reached", history)
    }
}
