//! Equilibrium under the static load (eq. 37).

use crate::Error;
use crate::error::check_size;
use crate::force::HystereticForce;
use crate::linear::{Motion, Stuck, UnitLoad, symmetrised};
use crate::newton::{Effort, Equilibrium, Failure, LinearSolver, NewtonSettings, Sequence};
use crate::path::Path;
use contact_laws::{RegimeCounts, Sticking};
use dense_algebra::{Inner, Limits, SystemMatrixRef};

/// A static equilibrium.
#[derive(Clone, Debug)]
pub struct Prestress<S> {
    /// Displacements `u*`.
    pub displacement: Vec<f64>,
    /// Committed history at `u*`.
    pub state: S,
    /// Newton iterations with everything stuck, then with friction.
    pub iterations: [usize; 2],
    /// Work done.
    pub effort: Effort,
    /// Residual relative to the load in the energy norm.
    pub residual: f64,
    /// Regimes of the points.
    pub counts: RegimeCounts,
}

/// Ratio of energy norms beyond which the stuck structure at the guess is too stiff a measure of residuals; good guesses
/// are below five.
const FAR_GUESS: f64 = 10.0;

/// Searches, each but the first beginning where the one before ended.
const MOST_SEARCHES: usize = 5;

/// Solves `K u + F(u) = load` from the guess `start`.
///
/// Forces `F(0)` of the initial history, as of faces that are pressed together at rest, count as load: residuals are relative to
/// `load - F(0)`, and load steps apply both together. Where that is zero, the structure rests at `u = 0`.
///
/// The energy norm is that of the structure linearised at `start` with everything stuck, so `start` must close the
/// interface: a uniform closure that carries the load on average makes the first Newton step the solution of that
/// linear problem. The equilibrium is first found with full sticking, then with friction. A guess so far off that its
/// energy norm says little about the solution is replaced by what was found from it, and the work repeated from there;
/// so is one from which Newton's method came nearer, but did not arrive. Where that does not help either, the load is
/// applied in steps. The outer `Result` tells of input that cannot be used, the inner one of a solve that did not
/// converge.
///
/// # Errors
/// Sizes that do not match, and [`Error::Dense`] if `start` leaves the structure loose.
pub fn solve<'a, F: HystereticForce>(
    stiffness: impl Into<SystemMatrixRef<'a>>,
    force: &F,
    load: &[f64],
    start: &[f64],
    settings: &NewtonSettings,
) -> Result<Result<Prestress<F::State>, Failure>, Error> {
    solve_after(&force.initial_state(), stiffness, force, load, start, settings)
}

/// As [`solve`], of a structure that has a `history` already: friction of earlier static states, committed. The
/// load is the whole one, not its change.
///
/// # Errors
/// As [`solve`].
pub fn solve_after<'a, F: HystereticForce>(
    history: &F::State,
    stiffness: impl Into<SystemMatrixRef<'a>>,
    force: &F,
    load: &[f64],
    start: &[f64],
    settings: &NewtonSettings,
) -> Result<Result<Prestress<F::State>, Failure>, Error> {
    solve_within(Limits::default(), history, stiffness, force, load, start, settings)
}

/// As [`solve_after`], within limits of time; the part that is done follows the decrease of the residual.
///
/// # Errors
/// As [`solve`].
pub fn solve_within<'a, F: HystereticForce>(
    limits: Limits<'_>,
    history: &F::State,
    stiffness: impl Into<SystemMatrixRef<'a>>,
    force: &F,
    load: &[f64],
    start: &[f64],
    settings: &NewtonSettings,
) -> Result<Result<Prestress<F::State>, Failure>, Error> {
    let (stiffness, settings) = (stiffness.into(), (settings, limits));
    let n = stiffness.size();
    check_size("the static load", load.len(), n)?;
    check_size("the starting guess", start.len(), n)?;
    let rest = Rest::new(force);
    let mut net = load.to_vec();
    net.iter_mut().zip(&rest.force).for_each(|(net, force)| *net -= force);
    let load = net.as_slice();
    if load.iter().all(|load| *load == 0.0) {
        return Ok(Ok(rest.equilibrium(n)));
    }
    let mut work = Work::default();
    let mut from = start.to_vec();
    let mut is_refined = false;
    for _ in 0..MOST_SEARCHES {
        match search(
            history,
            stiffness,
            force,
            load,
            &rest.force,
            &from,
            Loading::Direct,
            settings,
            &mut work,
        ) {
            Ok(Ok(found)) if found.stretch <= FAR_GUESS || is_refined => return Ok(Ok(found.solution)),
            Ok(Ok(found)) => {
                is_refined = true;
                from = found.solution.displacement;
            }
            Ok(Err(lost)) if lost.is_nearer() => from = lost.displacement,
            Ok(Err(_)) => break,
            Err(error) if from == start => return Err(error),
            // Where a search ended may leave the structure loose.
            Err(_) => break,
        }
    }
    let last = search(
        history,
        stiffness,
        force,
        load,
        &rest.force,
        start,
        Loading::InSteps,
        settings,
        &mut work,
    )?;
    Ok(last.map(|found| found.solution).map_err(|lost| lost.failure))
}

/// The contact before anything moves.
struct Rest<S> {
    force: Vec<f64>,
    state: S,
    counts: RegimeCounts,
}

impl<S: Clone> Rest<S> {
    fn new<F: HystereticForce<State = S>>(force: &F) -> Self {
        let state = force.initial_state();
        let (mut end, zero) = (state.clone(), vec![0.0; force.n_dofs()]);
        let mut at_rest = zero.clone();
        let workspace = &mut force.workspace();
        let counts = force.evaluate(
            &zero,
            Sticking::Coulomb,
            &state,
            &mut end,
            workspace,
            &mut at_rest,
            None,
        );
        Self {
            force: at_rest,
            state,
            counts,
        }
    }

    /// Over `n` coordinates, of a load that the forces at rest balance.
    fn equilibrium(self, n: usize) -> Prestress<S> {
        Prestress {
            displacement: vec![0.0; n],
            state: self.state,
            iterations: [0; 2],
            effort: Effort::default(),
            residual: 0.0,
            counts: self.counts,
        }
    }
}

/// How a search goes about its load.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Loading {
    /// All at once.
    Direct,
    /// In steps, if all at once does not do.
    InSteps,
}

/// Work done by all searches.
#[derive(Default)]
struct Work {
    iterations: [usize; 2],
    effort: Effort,
}

/// A solution, and how good its guess was.
struct Solved<S> {
    solution: Prestress<S>,
    /// Energy norm of the motion, in the stuck structure at the guess, over that of the load.
    stretch: f64,
}

/// Where a search without success ended.
struct Lost {
    failure: Failure,
    displacement: Vec<f64>,
}

impl Lost {
    /// Whether another search from here may do better.
    fn is_nearer(&self) -> bool {
        match self.failure.history.as_slice() {
            [first, .., last] => *last < 0.5 * first,
            _ => false,
        }
    }
}

/// One search from `start`, whose work is added up; `load` is that less the forces `rest` of the contact at rest.
fn search<F: HystereticForce>(
    history: &F::State,
    stiffness: SystemMatrixRef<'_>,
    force: &F,
    load: &[f64],
    rest: &[f64],
    start: &[f64],
    loading: Loading,
    (settings, limits): (&NewtonSettings, Limits<'_>),
    work: &mut Work,
) -> Result<Result<Solved<F::State>, Lost>, Error> {
    let n = stiffness.size();
    let nc = force.n_dofs();
    let mut tangent = vec![0.0; force.pattern().indices.len()];
    let mut contact = vec![0.0; nc];
    let mut state = history.clone();
    force.evaluate(
        &start[..nc],
        Sticking::Full,
        history,
        &mut state,
        &mut force.workspace(),
        &mut contact,
        Some(&mut tangent),
    );
    let tangent = symmetrised(force.pattern(), &tangent);
    let stuck = Stuck::try_new(stiffness, force.pattern(), &tangent, force.reflections())?;
    let mut guess = Motion::zero(n);
    guess.v.copy_from_slice(start);
    stiffness.multiply(start, &mut guess.p);
    force.pattern().add_product(stuck.tangent(), start, &mut guess.p);
    let unit = UnitLoad {
        force: load.to_vec(),
        response: stuck.response(load),
    };
    let zero = vec![0.0; nc];
    let equilibrium = Equilibrium {
        stiffness,
        force,
        stuck: &stuck,
        reference: &zero,
        reference_force: rest,
        round_off: stuck.round_off(force.pattern(), &start[..nc], &contact),
        limits,
    };
    let sequence = Sequence::<F>::new(force, guess, history.clone());
    let mut path = Path::new(equilibrium, &unit, 1.0, (LinearSolver::Krylov, *settings), sequence);
    let mut counts = RegimeCounts::default();
    for (stage, sticking) in [Sticking::Full, Sticking::Coulomb].into_iter().enumerate() {
        path.equilibrium.limits = limits.of_part(stage, 2);
        path.sticking = sticking;
        path.residual = 0.0;
        let before = path.sequence.effort.iterations;
        let guess = path.sequence.motion.clone();
        let solved = path.settle(1.0).or_else(|failure| {
            if loading == Loading::Direct {
                return Err(failure);
            }
            path.sequence.motion.copy_from(&guess);
            path.at = 0.0;
            path.advance(1.0)
        });
        work.iterations[stage] += path.sequence.effort.iterations - before;
        match solved {
            Ok(found) => counts = found,
            Err(failure) => {
                work.effort += path.sequence.effort;
                let displacement = path.sequence.motion.v;
                return Ok(Err(Lost { failure, displacement }));
            }
        }
    }
    path.sequence.commit();
    work.effort += path.sequence.effort;
    let stretch = path.sequence.motion.norm() / unit.norm();
    let solution = Prestress {
        displacement: path.sequence.motion.v,
        state: path.sequence.begin,
        iterations: work.iterations,
        effort: work.effort,
        residual: path.residual,
        counts,
    };
    Ok(Ok(Solved { solution, stretch }))
}
