//! The static state of a scene, and the structure linearised about it.

use super::amplitude::Fields;
use crate::Error;
use contact_laws::Sticking;
use cqsma_solver::prestress::{self, Prestress};
use cqsma_solver::{Failure, HystereticForce, Linearisation, NewtonSettings, Reason, modes};
use dense_algebra::Limits;
use joints::interface::InterfaceForce;
use joints::structure::StructuralModel;
use reduction::ReducedModel;
use scenes::{BoltBehaviour, Scene};
use zte_assembly::{Interface, State};

/// The static state.
#[derive(Clone, Debug)]
pub struct PrestressResult {
    /// Solver's account.
    pub solution: Prestress<State>,
    /// Sum of the absolute residual forces over the interface relative to that of the loads.
    pub residual_ratio: f64,
    /// Relative difference between the integrated pressure and the bolt loads.
    pub equilibrium_error: f64,
    /// Fields.
    pub fields: Fields,
    /// Contact forces (N).
    pub contact_force: Vec<f64>,
    /// Tension of each bolt (N).
    pub tensions: Vec<f64>,
}

/// Largest sum of residual forces over that of the loads, all at the interface, evaluated anew from stiffness and laws. It
/// bounds what is missing in the balance of forces and, times the largest lever, of moments.
const LARGEST_IMBALANCE: f64 = 1e-3;

/// Largest normal traction relative to that of the preload at rest that is round-off of faces that have just parted.
const PARTED: f64 = 1e-9;

/// The equilibrium of the interface and the static load (N), from the guess `start`.
///
/// # Errors
/// [`Error::Prestress`].
pub(super) fn solve(
    reduced: &ReducedModel,
    force: &InterfaceForce<'_>,
    static_load: &[f64],
    start: &[f64],
    (newton, limits): (&NewtonSettings, Limits<'_>),
) -> Result<Prestress<State>, Error> {
    let (history, stiffness) = (force.initial_state(), reduced.stiffness.as_ref());
    prestress::solve_within(limits, &history, stiffness, force, static_load, start, newton)?.map_err(failed)
}

pub(super) fn failed(failure: Failure) -> Error {
    if failure.reason == Reason::Interrupted {
        return cqsma_solver::Error::Interrupted.into();
    }
    Error::Prestress {
        reason: failure.reason,
        history: failure.history,
    }
}

/// A static state under bolts of these tensions (N), whose sum along the normal is `bolts` (N) and whose load over all
/// coordinates is `static_load` (N), with its balance.
///
/// # Errors
/// [`Error::Unbalanced`] if the forces of the equilibrium do not balance; [`Error::NothingInContact`].
pub(super) fn checked(
    reduced: &ReducedModel,
    force: &InterfaceForce<'_>,
    solution: Prestress<State>,
    static_load: &[f64],
    tensions: Vec<f64>,
    bolts: f64,
) -> Result<PrestressResult, Error> {
    let rest = Rest::new(force.interface());
    let found = describe(reduced, force, &rest.force, solution, static_load, tensions, bolts);
    if !(found.residual_ratio <= LARGEST_IMBALANCE) {
        return Err(Error::Unbalanced {
            residual_ratio: found.residual_ratio,
            limit: LARGEST_IMBALANCE,
        });
    }
    let [preload, traction] =
        [&rest.traction[2], &found.fields.traction[2]].map(|t| t.iter().copied().fold(0.0, f64::max));
    if preload > 0.0 && traction <= PARTED * preload {
        return Err(Error::NothingInContact);
    }
    Ok(found)
}

/// Forces (N) and tractions of faces that are pressed together at rest; zero without preload.
struct Rest {
    force: Vec<f64>,
    traction: [Vec<f64>; 3],
}

impl Rest {
    fn new(interface: &Interface) -> Self {
        let state = interface.initial_state();
        let (mut end, mut workspace) = (state.clone(), interface.workspace());
        let (jump, mut force) = (vec![0.0; interface.n_dofs()], vec![0.0; interface.n_dofs()]);
        interface.evaluate(
            &jump,
            Sticking::Coulomb,
            &state,
            &mut end,
            &mut workspace,
            &mut force,
            None,
        );
        let traction = workspace.traction;
        Self { force, traction }
    }
}

/// Balance and fields of a static state; `rest` are the contact forces before anything moves (N).
fn describe(
    reduced: &ReducedModel,
    force: &InterfaceForce<'_>,
    rest: &[f64],
    solution: Prestress<State>,
    static_load: &[f64],
    tensions: Vec<f64>,
    bolts: f64,
) -> PrestressResult {
    let interface = force.interface();
    let nd = interface.n_dofs();
    let mut workspace = interface.workspace();
    let mut end = solution.state.clone();
    let mut contact = vec![0.0; nd];
    let u = &solution.displacement;
    let state = &solution.state;
    interface.evaluate(
        &u[..nd],
        Sticking::Coulomb,
        state,
        &mut end,
        &mut workspace,
        &mut contact,
        None,
    );
    let mut elastic = vec![0.0; u.len()];
    reduced.stiffness.as_ref().multiply(u, &mut elastic);
    let (mut residual, mut loads) = (0.0, 0.0);
    // Along the normal: what is missing in the balance, and the loads.
    let (mut missing, mut pressing) = (0.0_f64, 0.0);
    for i in 0..nd {
        let out_of_balance = elastic[i] + contact[i] - static_load[i];
        residual += out_of_balance.abs();
        loads += static_load[i].abs() + rest[i].abs();
        if i % 3 == 2 {
            missing += out_of_balance;
            pressing += static_load[i].abs() + rest[i].abs();
        }
    }
    // Preload is carried by the structure too, and not by the contact alone.
    let is_preloaded = bolts == 0.0 || rest.iter().any(|force| *force != 0.0);
    let carried: f64 = contact.iter().skip(2).step_by(3).sum();
    PrestressResult {
        solution,
        residual_ratio: share(residual, loads),
        equilibrium_error: match is_preloaded {
            true => share(missing.abs(), pressing),
            false => (carried / bolts - 1.0).abs(),
        },
        fields: Fields {
            jump: workspace.jump,
            traction: workspace.traction,
            regime: workspace.regime,
            flux: std::array::from_fn(|_| vec![0.0; interface.operators().n_points()]),
        },
        contact_force: contact,
        tensions,
    }
}

/// A part of a whole, which may be zero where the part is.
fn share(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}

/// Modes of the structure that vibrates, with locked bolts if they are so, about a static state of the one that does not;
/// the response is not negative on any of them. There are as many as the scene wants, or as the rank of the mass.
///
/// # Errors
/// Of the linear structure; [`scenes::Error::Value`] for a mode that the structure does not have.
pub(crate) fn linearise<'a>(
    scene: &Scene,
    vibrating: &'a ReducedModel,
    force: &InterfaceForce<'_>,
    solution: &Prestress<State>,
) -> Result<Linearisation<'a, State>, Error> {
    let mut displacement = solution.displacement.clone();
    if scene.bolts.behaviour == BoltBehaviour::Locked {
        // The jump acts on the contact; the other coordinates of the locked structure count from the prestress.
        displacement.truncate(vibrating.n_relative);
        displacement.resize(vibrating.size(), 0.0);
    }
    let (stiffness, mass) = (vibrating.stiffness.as_ref(), vibrating.mass.as_ref());
    let about = |n_modes: usize| {
        let (displacement, state) = (displacement.clone(), solution.state.clone());
        modes::linearise(stiffness, mass, force, displacement, state, n_modes)
    };
    let wanted = scene.analyses.modes.number.min(mass.size());
    let mut line = about(wanted).or_else(|error| {
        use cqsma_solver::Error::{Dense, Setting};
        if !matches!(
            error,
            Setting { .. } | Dense(dense_algebra::Error::NoConvergence { .. })
        ) {
            return Err(error);
        }
        // Massless coordinates have no modes of their own.
        let Some(dense) = mass.dense() else {
            return Err(error);
        };
        match dense_algebra::rank(dense).map_err(cqsma_solver::Error::from)? {
            rank if (1..wanted).contains(&rank) => about(rank),
            _ => Err(error),
        }
    })?;
    let found = line.eigenvalues.len();
    if let Some(mode) = scene.analyses.modes.followed.iter().find(|mode| **mode > found) {
        return Err(scenes::Error::Value {
            place: scene.name.clone(),
            field: "analyses.modes.followed",
            value: *mode as f64,
            unit: "",
            requirement: "no more than the modes of the structure, of which there are as many as coordinates with a mass",
        }.into());
    }
    line.orient(&response(vibrating))?;
    Ok(line)
}

/// Recovers the displacement at the response point.
pub(crate) fn response(model: &ReducedModel) -> Vec<f64> {
    model.recovery.row(0).iter().copied().collect()
}

/// Load of tensions of the bolts (N) on the reduced coordinates (N).
pub(super) fn load_of(reduced: &ReducedModel, tensions: &[f64]) -> Vec<f64> {
    let mut load = vec![0.0; reduced.size()];
    for (tension, unit) in tensions.iter().zip(&reduced.loads) {
        load.iter_mut()
            .zip(unit)
            .for_each(|(sum, value)| *sum += tension * value);
    }
    load
}

/// Generalised force of all bolts at their load on a uniform closure of the interface (N).
pub(super) fn closing_force(scene: &Scene, model: &StructuralModel) -> f64 {
    let ones = closing(&model.reduced);
    match scene.bolts.loads.is_empty() {
        true => scene.bolts.load.si() * ones.sum::<f64>(),
        false => ones.enumerate().map(|(bolt, one)| scene.tension(bolt) * one).sum(),
    }
}

/// Generalised force of unit tension of each bolt on a uniform closure of the interface (-).
pub(super) fn closing(reduced: &ReducedModel) -> impl Iterator<Item = f64> {
    let of_one = |load: &Vec<f64>| load[2..reduced.n_relative].iter().step_by(3).sum::<f64>();
    reduced.loads.iter().map(of_one)
}
