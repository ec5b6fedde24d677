//! Equilibrium under the static load (eq. 37).

use crate::Error;
use crate::error::check_size;
use crate::force::{HystereticForce, PointCounts, Sliding};
use crate::linear::StuckFactor;
use crate::newton::{Effort, Equilibrium, Failure, NewtonSettings, Strategy, Walk};
use faer::MatRef;

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
    pub counts: PointCounts,
}

/// Solves `K u + F(u) = load` from the guess `start`.
///
/// The energy norm is that of the structure linearised at `start` with everything stuck, so `start` must close the
/// interface: a uniform closure that carries the load on average makes the first Newton step the solution of that
/// linear problem. The equilibrium is first found with sliding prevented, then with friction. The outer `Result`
/// tells of input that cannot be used, the inner one of a solve that did not converge.
///
/// # Errors
/// Sizes that do not match, and [`Error::Dense`] if `start` leaves the structure loose.
pub fn solve<F: HystereticForce>(
    stiffness: MatRef<'_, f64>,
    force: &F,
    load: &[f64],
    start: &[f64],
    settings: &NewtonSettings,
) -> Result<Result<Prestress<F::State>, Failure>, Error> {
    let n = stiffness.nrows();
    check_size("the static load", load.len(), n)?;
    check_size("the starting guess", start.len(), n)?;
    let nc = force.n_dofs();
    let initial = force.initial_state();
    let mut tangent = vec![0.0; force.pattern().indices.len()];
    let mut contact = vec![0.0; nc];
    let mut state = initial.clone();
    force.evaluate(
        &start[..nc],
        Sliding::Prevented,
        &initial,
        &mut state,
        &mut force.workspace(),
        &mut contact,
        Some(&mut tangent),
    );
    let factor = StuckFactor::try_new(stiffness, force.pattern(), &tangent)?;
    let scale = factor.energy_norm(load, &mut Vec::new());
    let zero = vec![0.0; n];
    let equilibrium = Equilibrium {
        stiffness,
        force,
        factor: &factor,
        reference: &zero[..nc],
        reference_force: &zero[..nc],
    };
    let mut walk = Walk::<F>::new(force, start.to_vec(), initial);
    let mut iterations = [0; 2];
    let mut solved = None;
    for (stage, sliding) in [Sliding::Prevented, Sliding::Allowed].into_iter().enumerate() {
        let before = walk.effort.iterations;
        match equilibrium.solve(&mut walk, load, scale, sliding, Strategy::Direct, settings) {
            Ok(converged) => solved = Some(converged),
            Err(failure) => return Ok(Err(failure)),
        }
        iterations[stage] = walk.effort.iterations - before;
    }
    walk.commit();
    let (residual, counts) = solved.map_or((f64::NAN, PointCounts::default()), |s| (s.residual, s.counts));
    Ok(Ok(Prestress {
        displacement: walk.v,
        state: walk.begin,
        iterations,
        effort: walk.effort,
        residual,
        counts,
    }))
}
