//! Newton's method with a bordered Krylov solve.

use crate::aft::Sampling;
use crate::force::PointwiseForce;
use crate::harmonics::Harmonics;
use crate::system::{Derivative, Evaluation, Parameter, Step, System, Unknown};
use dense_algebra::{ConjugateResiduals, Inner, Vector};

/// Most steps of the iteration for one linear solve.
const MAX_KRYLOV: usize = 120;

/// Steps that take less than this share off the residual make no way.
const CRAWLING: f64 = 0.9;

/// Most whole steps that are taken although the residual grows, and by how much it may.
const MAX_BOLD: usize = 8;
const WORST: f64 = 10.0;

/// Round-off of the contact forces over the elastic forces of the first harmonic, in the energy norm, from which a motion says nothing.
const LARGEST_ROUND_OFF: f64 = 1e-2;

/// Most iterations in a row that do not reduce the residual.
const MAX_STALLED: usize = 4;

/// Settings of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonSettings {
    /// Residual relative to the elastic forces of the first harmonic, both in the energy norm.
    pub tolerance: f64,
    /// Most iterations per point.
    pub max_iterations: usize,
    /// Most halvings of one step.
    pub max_halvings: usize,
}

impl Default for NewtonSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-8,
            max_iterations: 30,
            max_halvings: 6,
        }
    }
}

/// Why a point has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reason {
    /// The residual stopped falling.
    #[error(
        "the residual stopped falling, however often the step was halved; take more samples per period, or smaller steps"
    )]
    Stalled,
    /// The motion is too small to be told from round-off.
    #[error(
        "the motion is within the round-off of the contact forces of the static state; take larger amplitudes or forces"
    )]
    BelowRoundOff,
    /// Too many iterations.
    #[error("more iterations were needed than allowed")]
    IterationLimit,
    /// The linear solve did not converge.
    #[error("the linear solve did not converge: the motion is far from all that the stuck structure does")]
    LinearSolve,
    /// A number that is not finite.
    #[error("a residual was not finite")]
    NotFinite,
    /// Smaller steps of the continuation do not help.
    #[error("no further point was found on the curve, however short the step")]
    StepTooSmall,
    /// A forced response turned back.
    #[error(
        "the curve turned back and left the range of frequencies where it began; begin farther from the resonance, or from the other end"
    )]
    LeftRange,
    /// The history does not repeat.
    #[error("the history still changes from period to period; follow more periods")]
    NotPeriodic,
    /// The frequency fell to zero or below.
    #[error("no positive frequency balances the forces")]
    NoFrequency,
    /// More work than motions found so far and this one may take.
    #[error(
        "more than {} residuals and products with the Jacobian, and {} for each motion found before, were needed; take smaller amplitudes or \
         forces, or ask for less accuracy",
        BUDGET[0],
        BUDGET[1]
    )]
    Budget,
    /// The run was interrupted; no result shows it.
    #[error("the run was interrupted")]
    Interrupted,
}

impl Reason {
    /// Whether no other attempt may follow.
    pub(crate) fn is_final(self) -> bool {
        matches!(self, Self::Budget | Self::Interrupted)
    }
}

/// Residuals and products with the Jacobian that may be spent on a backbone, and those that each motion found adds to it; a point of a forced
/// response may take the first number. With a target for errors, amplitudes of the Brake-Reuss beam take up to 500: what is asked for beyond
/// these numbers is not within reach of the method.
pub(crate) const BUDGET: [usize; 2] = [10_000, 2_000];

/// Why a solve gave up.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Failure {
    /// What happened.
    pub reason: Reason,
    /// Relative residual at each iteration.
    pub history: Vec<f64>,
}

/// Work done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Effort {
    /// Newton iterations.
    pub iterations: usize,
    /// Residuals evaluated.
    pub evaluations: usize,
    /// Steps of the Krylov iteration.
    pub krylov_steps: usize,
    /// Evaluations of the law at all points that the residuals took: one for each sample of all periods.
    pub law_evaluations: usize,
    /// Products with the stuck structure's flexibility: one for each coefficient of the Fourier series of residuals and Krylov steps.
    pub flexibility_products: usize,
}

impl Effort {
    /// Counts a residual.
    fn add_residual(&mut self, sampling: Sampling) {
        self.evaluations += 1;
        self.law_evaluations += sampling.samples * sampling.periods;
        self.flexibility_products += 2 * sampling.harmonics + 1;
    }

    /// Counts Krylov steps.
    fn add_krylov_steps(&mut self, steps: usize, sampling: Sampling) {
        self.krylov_steps += steps;
        self.flexibility_products += steps * (2 * sampling.harmonics + 1);
    }

    /// Residuals and products with the Jacobian.
    pub(crate) fn products(&self) -> usize {
        self.evaluations + self.krylov_steps
    }
}

impl std::ops::AddAssign for Effort {
    fn add_assign(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.evaluations += other.evaluations;
        self.krylov_steps += other.krylov_steps;
        self.law_evaluations += other.law_evaluations;
        self.flexibility_products += other.flexibility_products;
    }
}

/// A condition that makes up for a free parameter: a function of the motion and of the parameters.
pub(crate) struct Condition {
    /// Its value, without unit; zero where it holds.
    pub(crate) value: f64,
    /// Its derivative with respect to the motion.
    pub(crate) gradient: Harmonics,
    /// That with respect to the free parameters.
    pub(crate) along: Vec<f64>,
}

/// What is solved for beside the motion.
pub(crate) struct Closure<'c> {
    /// Free parameters.
    pub(crate) free: &'c [Parameter],
    /// As many conditions as free parameters, from motion and `M v`.
    pub(crate) conditions: &'c dyn Fn(&Unknown, &Harmonics) -> Vec<Condition>,
}

/// Where a part of a step leads.
struct Trial {
    part: f64,
    unknown: Unknown,
    evaluation: Evaluation,
    /// Of the conditions.
    values: Vec<f64>,
    /// Residual and conditions, in the energy norm.
    size: f64,
}

/// A converged point.
pub(crate) struct Converged {
    pub(crate) residual: f64,
    /// Iterations that began with a residual above [`NEAR`].
    pub(crate) far: usize,
    pub(crate) drift: f64,
    pub(crate) evaluation: Evaluation,
}

/// Relative residual from which the way to a solution is one of patience alone.
const NEAR: f64 = 1e-4;

/// Accuracy of steps with an approximate Jacobian, relative: its own error is of this size.
const COARSE_FORCING: f64 = 0.01;

/// Residual over the one before from which the Jacobian of all samples takes over.
const SLOW: f64 = 0.5;

/// Residual over the one before up to which the next step is made with the same Jacobian.
const REUSED: f64 = 0.3;

/// Most directions that are kept for right-hand sides that share a Jacobian.
const MOST_SEARCHED: usize = 600;

/// Steps made before whose change of the residual the next step makes use of.
const MOST_SECANTS: usize = 6;

/// A step whose change of the residual says less than this share of its own beside those of later ones is not used.
const LEAST_NEWS: f64 = 1e-2;

/// Directions, with what the bordered Jacobian makes of them.
type Searched = ConjugateResiduals<Step, Direction>;

/// The bordered Jacobian at a motion.
struct Bordered<'s, 'a, F: PointwiseForce> {
    system: &'s System<'a, F>,
    unknown: Unknown,
    /// How the contact forces are differentiated.
    derivative: Derivative,
    /// Derivatives of the residual with respect to the free parameters, their preconditioned answers as displacement and force.
    columns: Vec<Harmonics>,
    answers: Vec<[Harmonics; 2]>,
    conditions: Vec<Condition>,
    /// Rows and columns of the conditions' block after elimination of the motion, inverted.
    inverse: Vec<Vec<f64>>,
    /// What a condition counts in the energy norm.
    scale: f64,
}

/// A vector of the Krylov space: a force with its stuck response, and a value per condition.
#[derive(Clone)]
struct Direction {
    force: Harmonics,
    response: Harmonics,
    conditions: Vec<f64>,
}

impl Inner for Direction {
    fn dot(&self, other: &Self) -> f64 {
        let conditions: f64 = self.conditions.iter().zip(&other.conditions).map(|(a, b)| a * b).sum();
        self.force.dot(&other.response) + conditions
    }
}

impl Vector for Direction {
    fn add(&mut self, factor: f64, other: &Self) {
        self.force.add(factor, &other.force);
        self.response.add(factor, &other.response);
        for (a, b) in self.conditions.iter_mut().zip(&other.conditions) {
            *a += factor * b;
        }
    }

    fn scale(&mut self, factor: f64) {
        self.force.scale(factor);
        self.response.scale(factor);
        self.conditions.iter_mut().for_each(|c| *c *= factor);
    }
}

impl<'s, 'a, F: PointwiseForce> Bordered<'s, 'a, F> {
    fn try_new(
        system: &'s System<'a, F>,
        unknown: &Unknown,
        derivative: Derivative,
        evaluation: &Evaluation,
        closure: &Closure<'_>,
        conditions: Vec<Condition>,
        scale: f64,
    ) -> Option<Self> {
        let columns: Vec<Harmonics> = closure
            .free
            .iter()
            .map(|parameter| system.column(unknown, &evaluation.inertia, *parameter))
            .collect();
        let answer = |column: &Harmonics| system.precondition(unknown, column, &system.solve_stuck(column));
        let answers: Vec<[Harmonics; 2]> = columns.iter().map(answer).collect();
        let entry = |i: usize, j: usize| conditions[i].along[j] - conditions[i].gradient.dot(&answers[j][0]);
        let m = columns.len();
        let block: Vec<Vec<f64>> = (0..m).map(|i| (0..m).map(|j| entry(i, j)).collect()).collect();
        Some(Self {
            system,
            unknown: unknown.clone(),
            derivative,
            inverse: inverse(&block)?,
            columns,
            answers,
            conditions,
            scale,
        })
    }

    /// The preconditioner's answer.
    fn precondition(&self, direction: &Direction) -> Step {
        let [mut v, mut p] = self
            .system
            .precondition(&self.unknown, &direction.force, &direction.response);
        let missing: Vec<f64> = self
            .conditions
            .iter()
            .zip(&direction.conditions)
            .map(|(condition, value)| value / self.scale - condition.gradient.dot(&v))
            .collect();
        let parameters: Vec<f64> = self
            .inverse
            .iter()
            .map(|row| row.iter().zip(&missing).map(|(a, b)| a * b).sum())
            .collect();
        for (change, [answer_v, answer_p]) in parameters.iter().zip(&self.answers) {
            v.add(-change, answer_v);
            p.add(-change, answer_p);
        }
        Step { v, p, parameters }
    }

    /// The Jacobian times a step whose values of the conditions are `conditions`.
    fn product(&self, step: &Step, conditions: &[f64]) -> Direction {
        let mut force = self.system.product(&self.unknown, &step.v, &step.p, &self.derivative);
        for (change, column) in step.parameters.iter().zip(&self.columns) {
            force.add(*change, column);
        }
        let response = self.system.solve_stuck(&force);
        Direction {
            force,
            response,
            conditions: conditions.to_vec(),
        }
    }

    /// A residual with the values of its conditions.
    fn direction(&self, evaluation: &Evaluation, values: &[f64]) -> Direction {
        Direction {
            force: evaluation.residual.clone(),
            response: evaluation.response.clone(),
            conditions: values.iter().map(|value| value * self.scale).collect(),
        }
    }

    /// The step that does nothing.
    fn none(&self) -> Step {
        let zero = || Harmonics::zeros(self.unknown.v.size(), self.unknown.v.count());
        Step {
            v: zero(),
            p: zero(),
            parameters: vec![0.0; self.columns.len()],
        }
    }

    /// `first` and the step that takes `start` away, with what was `searched` before at this Jacobian. `None` if `tolerance` (relative, in the energy norm) is
    /// not reached.
    fn solve(&self, start: Direction, first: Step, searched: &mut Searched, tolerance: f64) -> Option<Step> {
        let search = |rest: &Direction| {
            if self.system.line().limits.stops() {
                return None;
            }
            let step = self.precondition(rest);
            let image = self.product(&step, &rest.conditions);
            Some((step, image))
        };
        let renew = |rest: &mut Direction| rest.response = self.system.solve_stuck(&rest.force);
        searched.solve(start, first, tolerance, renew, search)
    }
}

/// Changes of the free parameters that keep residual and conditions where they are, where these change by `changes`: of the residual, and of the
/// values of the conditions.
pub(crate) fn parameter_rates<F: PointwiseForce>(
    system: &System<'_, F>,
    unknown: &Unknown,
    closure: &Closure<'_>,
    changes: Vec<(Harmonics, Vec<f64>)>,
    tolerance: f64,
) -> Option<Vec<Vec<f64>>> {
    let evaluation = system.evaluate(unknown);
    let conditions = (closure.conditions)(unknown, &evaluation.inertia);
    let scale = system.scale(unknown);
    let bordered = Bordered::try_new(
        system,
        unknown,
        Derivative::Exact,
        &evaluation,
        closure,
        conditions,
        scale,
    )?;
    let starts = changes.into_iter().map(|(force, conditions)| {
        let mut start = Direction {
            response: system.solve_stuck(&force),
            force,
            conditions: conditions.iter().map(|value| value * scale).collect(),
        };
        start.scale(-1.0);
        start
    });
    // What was searched for one serves the next ones.
    let mut searched = Searched::new(MOST_SEARCHED);
    let mut solve = |start| {
        Some(
            bordered
                .solve(start, bordered.none(), &mut searched, tolerance)?
                .parameters,
        )
    };
    starts.map(&mut solve).collect()
}

/// Inverse of a matrix of one or two rows; `None` if it is singular.
fn inverse(block: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let found = match block {
        [] => Vec::new(),
        [row] => vec![vec![1.0 / row[0]]],
        _ => {
            let [a, b, c, d] = [block[0][0], block[0][1], block[1][0], block[1][1]];
            let determinant = a * d - b * c;
            vec![
                vec![d / determinant, -b / determinant],
                vec![-c / determinant, a / determinant],
            ]
        }
    };
    found.iter().flatten().all(|v| v.is_finite()).then_some(found)
}

/// Solves for motion and free parameters from the guess in `unknown`, which is left at the solution or where the search ended; `most` residuals
/// and products may be in `effort` before an iteration.
pub(crate) fn solve<F: PointwiseForce>(
    system: &System<'_, F>,
    unknown: &mut Unknown,
    closure: &Closure<'_>,
    settings: &NewtonSettings,
    effort: &mut Effort,
    most: usize,
) -> Result<Converged, Failure> {
    let mut history = Vec::new();
    let fail = |reason, history| Err(Failure { reason, history });
    let merit = |evaluation: &Evaluation, values: &[f64], scale: f64| {
        let conditions: f64 = values.iter().map(|value| (value * scale).powi(2)).sum();
        (evaluation.norm().powi(2) + conditions).sqrt()
    };
    let values_of = |conditions: &[Condition]| -> Vec<f64> { conditions.iter().map(|c| c.value).collect() };
    let mut evaluation = system.evaluate(unknown);
    effort.add_residual(system.sampling());
    let (mut stalled, mut bold_steps) = (0, 0);
    let mut is_coarse = true;
    // The Jacobian of an iterate before, as long as its steps take enough off the residual: what was searched there need not be searched again.
    let mut jacobian: Option<(Bordered<'_, '_, F>, Searched)> = None;
    // Steps and what they changed the residual by, the last one first: what an approximate Jacobian says wrong of them is put right.
    let mut secants: Vec<(Step, Direction)> = Vec::new();
    loop {
        if unknown.at(Parameter::Square) <= 0.0 {
            return fail(Reason::NoFrequency, history);
        }
        let conditions = (closure.conditions)(unknown, &evaluation.inertia);
        let scale = system.scale(unknown);
        let values = values_of(&conditions);
        let size = merit(&evaluation, &values, scale);
        history.push(size / scale);
        if !(size / scale).is_finite() {
            return fail(Reason::NotFinite, history);
        }
        let round_off = system.line().round_off();
        if round_off > LARGEST_ROUND_OFF * scale {
            return fail(Reason::BelowRoundOff, history);
        }
        // Round-off that falls no further is as good as it gets; the result says how large it is.
        let stays = history.len() > 1 && history[history.len() - 2] <= 2.0 * history[history.len() - 1];
        if size <= settings.tolerance * scale || (size <= round_off && stays) {
            return Ok(Converged {
                residual: size / scale,
                far: history.iter().filter(|residual| **residual > NEAR).count(),
                drift: evaluation.drift,
                evaluation,
            });
        }
        if system.line().limits.stops() {
            return fail(Reason::Interrupted, history);
        }
        if history.len() > settings.max_iterations {
            return fail(Reason::IterationLimit, history);
        }
        if effort.products() > most {
            return fail(Reason::Budget, history);
        }
        if stalled > MAX_STALLED {
            return fail(Reason::Stalled, history);
        }
        effort.iterations += 1;
        let forcing = (0.1 * size / scale)
            .sqrt()
            .min(0.1)
            .max(0.1 * settings.tolerance * scale / size)
            .min(0.3);
        let forcing = if is_coarse {
            forcing.max(COARSE_FORCING)
        } else {
            forcing
        };
        let is_new = jacobian.is_none();
        if is_new {
            let derivative = match is_coarse {
                true => Derivative::Coarse(system.coarse_forces(&unknown.v)),
                false => Derivative::Fine(evaluation.contact.clone()),
            };
            let made = Bordered::try_new(system, unknown, derivative, &evaluation, closure, conditions, scale);
            jacobian = made.map(|bordered| (bordered, Searched::new(MAX_KRYLOV)));
        }
        let Some((bordered, searched)) = &mut jacobian else {
            return fail(Reason::LinearSolve, history);
        };
        let here = bordered.direction(&evaluation, &values);
        let mut start = here.clone();
        start.scale(-1.0);
        let mut first = bordered.none();
        let mut past = Searched::new(MOST_SECANTS);
        for (step, image) in &secants {
            past.keep(step.clone(), image.clone(), LEAST_NEWS);
        }
        past.fit(&mut start, &mut first);
        let known = searched.searched();
        let solved = bordered.solve(start, first, searched, forcing);
        effort.add_krylov_steps(searched.searched() - known, system.sampling());
        let Some(mut step) = solved else {
            jacobian = None;
            let stops = system.line().limits.stops();
            if !stops && (!is_new || is_coarse) {
                is_coarse &= !is_new;
                continue;
            }
            let reason = match stops {
                true => Reason::Interrupted,
                false => Reason::LinearSolve,
            };
            return fail(reason, history);
        };
        let mut part = 1.0;
        let mut best: Option<Trial> = None;
        let mut whole: Option<Trial> = None;
        for halving in 0..=settings.max_halvings {
            let mut next = unknown.clone();
            next.add(part, &step, closure.free);
            if next.at(Parameter::Square) > 0.0 {
                let evaluation = system.evaluate(&next);
                effort.add_residual(system.sampling());
                let values = values_of(&(closure.conditions)(&next, &evaluation.inertia));
                let trial = Trial {
                    part,
                    unknown: next,
                    size: merit(&evaluation, &values, scale),
                    evaluation,
                    values,
                };
                let is_better = best.as_ref().is_none_or(|best| trial.size < best.size);
                let is_enough = trial.size <= (1.0 - 1e-4 * part) * size;
                if trial.size.is_finite() && halving == 0 && !is_enough {
                    whole = Some(trial);
                } else if trial.size.is_finite() && is_better {
                    best = Some(trial);
                }
                if is_enough {
                    break;
                }
            }
            part *= 0.5;
        }
        // Where only short steps help, points stick, slip or lift off along the step: after the whole one they are as it says,
        // and from there the residual often falls at once. It is taken if it is not far worse, a few times.
        let crawls = best.as_ref().is_none_or(|best| best.size > CRAWLING * size);
        let whole_is_finite = whole.is_some();
        let bold = whole.filter(|whole| crawls && bold_steps < MAX_BOLD && whole.size < WORST * size);
        bold_steps += usize::from(bold.is_some());
        let Some(taken) = bold.or(best) else {
            return fail(
                if whole_is_finite {
                    Reason::Stalled
                } else {
                    Reason::NotFinite
                },
                history,
            );
        };
        let mut image = bordered.direction(&taken.evaluation, &taken.values);
        image.add(-1.0, &here);
        step.scale(taken.part);
        secants.truncate(MOST_SECANTS - 1);
        secants.insert(0, (step, image));
        if taken.size > REUSED * size {
            is_coarse &= taken.size <= SLOW * size || !is_new;
            jacobian = None;
        }
        if taken.size > 0.999 * size {
            stalled += 1;
        } else {
            stalled = 0;
        }
        *unknown = taken.unknown;
        evaluation = taken.evaluation;
    }
}
