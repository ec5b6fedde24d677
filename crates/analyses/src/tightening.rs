//! Bolts tightened one after the other.
//!
//! Whatever tightens a bolt relaxes or strains those that are tightened already: their elongation is held by the thread, the parts
//! below them are not. A step solves `K u + F(u; history) = sum of T_i l_i` with the tension `T_i` of the bolt at hand given, that of
//! bolts not tightened yet zero, and those of all others such that their elongation `l_j^T u` stays as it was. The friction of the
//! interface remembers the steps before.

use super::prestress;
use crate::Error;
use contact_laws::Sticking;
use cqsma_solver::NewtonSettings;
use cqsma_solver::newton::Effort;
use cqsma_solver::prestress::{Prestress, solve_after};
use joints::interface::InterfaceForce;
use reduction::{Hold, LoadCompliance, ReducedModel};
use scenes::Tightening;
use serde::{Deserialize, Serialize};
use zte_assembly::State;

/// Largest difference between the work on the bolts and what became of it, relative to that work.
pub const ENERGY_TOLERANCE: f64 = 1e-6;

/// What tightening the bolts one after the other has come to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TighteningResult {
    /// In their order, pass by pass.
    pub steps: Vec<TighteningStep>,
    /// Tension of each bolt after the last step (N).
    pub residual_preloads: Vec<f64>,
    /// The same over the loads that the bolts were tightened to in the last pass (-).
    pub residual_ratios: Vec<f64>,
    /// Work and what became of it.
    pub energy: TighteningEnergy,
}

/// One bolt tightened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TighteningStep {
    /// Pass, counted from 1.
    pub pass: usize,
    /// The bolt that is tightened, counted from 1.
    pub bolt: usize,
    /// Tension that it is tightened to (N).
    pub target: f64,
    /// Tension of each bolt after the step (N).
    pub tensions: Vec<f64>,
    /// Change of the tension of each other bolt in the step (N), the elastic interaction; zero at the bolt itself.
    pub interaction: Vec<f64>,
    /// Advance of each bolt's end in the direction of its tension since the first step (m): elongation of the bolt and closure of the
    /// parts. It is held while others are tightened.
    pub advances: Vec<f64>,
    /// Work on the bolt along its axis in the step (J).
    pub external_work: f64,
    /// Newton iterations.
    pub iterations: usize,
}

/// Work on the bolts along their axes, and what became of it (J). The sums along the way are by the trapezoidal rule over the
/// equilibria that were computed, so that more increments per step make each of them more exact; their balance does not need it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TighteningEnergy {
    /// Work on all bolts (J), without what a wrench loses in threads and below heads.
    pub external_work: f64,
    /// Elastic energy of bolts and parts (J).
    pub stored_in_structure: f64,
    /// Work of compressing the interface, and the energy that its shear gives back at constant pressure with everything
    /// stuck (J).
    pub stored_in_contact: f64,
    /// The rest of the work in shear (J): friction, and what the history rule of the law takes where pressure changes under shear.
    pub dissipated: f64,
    /// Difference between the first and the sum of the others, relative to the first.
    pub imbalance: f64,
    /// What it may be at most.
    pub tolerance: f64,
}

/// Tightens the bolts to `targets` (N) as `plan` says, from the guess `start` over the jump (m).
///
/// # Errors
/// [`Error::Tightening`] for a step without equilibrium; those of the compliance at the bolts.
pub(super) fn tighten(
    reduced: &ReducedModel,
    force: &InterfaceForce<'_>,
    targets: &[f64],
    plan: &Tightening,
    start: &[f64],
    newton: &NewtonSettings,
    progress: &dyn Fn(f64),
) -> Result<(Prestress<State>, TighteningResult), Error> {
    let compliance = reduced.load_compliance().map_err(|error| match error {
        reduction::Error::DependentLoad { load } => joints::Error::NoElongation { bolt: Some(load + 1) },
        reduction::Error::NoAttachmentModes { .. } => joints::Error::NoElongation { bolt: None },
        other => other.into(),
    })?;
    let mut way = Way::new(reduced, &compliance, force, start, newton)?;
    let mut steps = Vec::new();
    let n_steps = (plan.passes.len() * plan.order.len()) as f64;
    for (pass, share) in (1..).zip(&plan.passes) {
        for &number in &plan.order {
            let bolt = number - 1;
            let (from, to) = (way.tensions[bolt], share * targets[bolt]);
            let (before, work, iterations) = (way.tensions.clone(), way.external_work, way.iterations());
            for increment in 1..=plan.increments {
                let part = increment as f64 / plan.increments as f64;
                let tension = if increment == plan.increments {
                    to
                } else {
                    from + part * (to - from)
                };
                way.proceed(bolt, tension).map_err(|failure| match failure {
                    Stop::Failure(reason, history) => Error::Tightening {
                        pass,
                        bolt: number,
                        reason,
                        history,
                    },
                    Stop::Error(error) => error,
                })?;
            }
            let change = way.tensions.iter().zip(&before).enumerate();
            steps.push(TighteningStep {
                pass,
                bolt: number,
                target: to,
                interaction: change
                    .map(|(other, (now, before))| if other == bolt { 0.0 } else { now - before })
                    .collect(),
                tensions: way.tensions.clone(),
                advances: way.advances.clone(),
                external_work: way.external_work - work,
                iterations: way.iterations() - iterations,
            });
            progress(steps.len() as f64 / n_steps);
        }
    }
    let energy = way.energy();
    let residual_preloads = way.tensions.clone();
    let ratio = |(tension, target): (&f64, &f64)| tension / target;
    let result = TighteningResult {
        steps,
        residual_ratios: residual_preloads.iter().zip(targets).map(ratio).collect(),
        residual_preloads,
        energy,
    };
    Ok((way.solution, result))
}

enum Stop {
    Failure(cqsma_solver::Reason, Vec<f64>),
    Error(Error),
}

/// A sequence of equilibria.
struct Way<'a> {
    reduced: &'a ReducedModel,
    compliance: &'a LoadCompliance<'a>,
    force: &'a InterfaceForce<'a>,
    start: &'a [f64],
    newton: &'a NewtonSettings,
    /// The last one; over all coordinates of the reduced model.
    solution: Prestress<State>,
    /// By bolt (N).
    tensions: Vec<f64>,
    /// By bolt (m).
    advances: Vec<f64>,
    is_tightened: Vec<bool>,
    points: Points,
    /// What the structure had stored before the first step (J).
    stored_before: f64,
    external_work: f64,
    /// Work of the interface against its compression, and against its shear (J).
    compression: f64,
    shear: f64,
    /// What shear had stored before the first step (J).
    shear_before: f64,
}

/// Jumps (m) and tractions (Pa) at the points.
struct Points {
    jump: [Vec<f64>; 3],
    traction: [Vec<f64>; 3],
}

impl<'a> Way<'a> {
    /// At rest without any tension, under the preload of the interface if it has one.
    fn new(
        reduced: &'a ReducedModel,
        compliance: &'a LoadCompliance<'a>,
        force: &'a InterfaceForce<'a>,
        start: &'a [f64],
        newton: &'a NewtonSettings,
    ) -> Result<Self, Error> {
        let n_loads = reduced.loads.len();
        let loose = vec![Hold::Tension(0.0); n_loads];
        let system = compliance.held(&loose)?;
        let found = cqsma_solver::prestress::solve(system.stiffness.as_ref(), force, &system.load, start, newton)?;
        let mut solution = found.map_err(prestress::failed)?;
        let (points, shear_before) = points(force, &solution);
        let tensions = vec![0.0; n_loads];
        let advances = compliance.displacements_of_loads(&solution.displacement, &tensions);
        solution.displacement = compliance.displacement(&solution.displacement, &tensions);
        Ok(Self {
            reduced,
            compliance,
            force,
            start,
            newton,
            stored_before: stored(reduced, &solution.displacement),
            solution,
            tensions,
            advances,
            is_tightened: vec![false; n_loads],
            points,
            external_work: 0.0,
            compression: 0.0,
            shear: 0.0,
            shear_before,
        })
    }

    fn iterations(&self) -> usize {
        self.solution.iterations.iter().sum()
    }

    /// Brings a bolt to a tension (N), commits and keeps the accounts.
    fn proceed(&mut self, bolt: usize, tension: f64) -> Result<(), Stop> {
        let hold = |other: usize| match (other == bolt, self.is_tightened[other]) {
            (true, _) => Hold::Tension(tension),
            (false, true) => Hold::Displacement(self.advances[other]),
            (false, false) => Hold::Tension(0.0),
        };
        let holds: Vec<Hold> = (0..self.tensions.len()).map(hold).collect();
        let system = self
            .compliance
            .held(&holds)
            .map_err(|error| Stop::Error(error.into()))?;
        let nd = self.reduced.n_relative;
        let from = |start: &[f64]| {
            let (history, stiffness) = (&self.solution.state, system.stiffness.as_ref());
            solve_after(history, stiffness, self.force, &system.load, start, self.newton)
        };
        let near = &self.solution.displacement[..nd];
        // The state before may leave parts of the structure loose that the step presses together.
        let found = match near.iter().any(|u| *u != 0.0) {
            true => match from(near) {
                Ok(Ok(found)) => Ok(found),
                _ => from(self.start).map_err(|error| Stop::Error(error.into()))?,
            },
            false => from(self.start).map_err(|error| Stop::Error(error.into()))?,
        };
        let mut solution = found.map_err(|failure| Stop::Failure(failure.reason, failure.history))?;
        let tensions = system.tensions(&solution.displacement);
        let mut advances = self
            .compliance
            .displacements_of_loads(&solution.displacement, &tensions);
        let (points, _) = points(self.force, &solution);
        let weights = &self.force.interface().operators().weights;
        let [x, y, n] = points.work_since(&self.points, weights);
        self.compression += n;
        self.shear += x + y;
        let advance = advances[bolt] - self.advances[bolt];
        self.external_work += 0.5 * (self.tensions[bolt] + tensions[bolt]) * advance;
        for (other, hold) in holds.iter().enumerate() {
            // What is held stays to the last bit.
            if let Hold::Displacement(held) = hold {
                advances[other] = *held;
            }
        }
        solution.displacement = self.compliance.displacement(&solution.displacement, &tensions);
        solution.iterations = [0, 1].map(|i| self.solution.iterations[i] + solution.iterations[i]);
        let mut effort: Effort = self.solution.effort;
        effort += solution.effort;
        solution.effort = effort;
        self.solution = solution;
        (self.tensions, self.advances, self.points) = (tensions, advances, points);
        self.is_tightened[bolt] = true;
        Ok(())
    }

    fn energy(&self) -> TighteningEnergy {
        let elastic_shear = points(self.force, &self.solution).1 - self.shear_before;
        let stored_in_structure = stored(self.reduced, &self.solution.displacement) - self.stored_before;
        let stored_in_contact = self.compression + elastic_shear;
        let dissipated = self.shear - elastic_shear;
        let sum = stored_in_structure + stored_in_contact + dissipated;
        TighteningEnergy {
            external_work: self.external_work,
            stored_in_structure,
            stored_in_contact,
            dissipated,
            imbalance: ((self.external_work - sum) / self.external_work).abs(),
            tolerance: ENERGY_TOLERANCE,
        }
    }
}

impl Points {
    /// Work per direction x, y, n since an earlier state by the trapezoidal rule (J).
    fn work_since(&self, before: &Self, weights: &[f64]) -> [f64; 3] {
        std::array::from_fn(|c| {
            let (u, t) = (&self.jump[c], &self.traction[c]);
            let (u0, t0) = (&before.jump[c], &before.traction[c]);
            let terms = weights.iter().enumerate();
            terms.map(|(i, w)| w * 0.5 * (t[i] + t0[i]) * (u[i] - u0[i])).sum()
        })
    }
}

/// `u^T K u / 2` (J).
fn stored(reduced: &ReducedModel, u: &[f64]) -> f64 {
    let mut forces = vec![0.0; u.len()];
    reduced.stiffness.as_ref().multiply(u, &mut forces);
    u.iter().zip(forces).map(|(u, force)| 0.5 * u * force).sum()
}

/// What happens at the points in a state that is committed, and the energy that its shear gives back with everything stuck at
/// constant pressure: `t^T k^-1 t / 2` with the tangential stiffness `k` (J).
fn points(force: &InterfaceForce<'_>, solution: &Prestress<State>) -> (Points, f64) {
    let interface = force.interface();
    let nd = interface.n_dofs();
    let mut workspace = interface.workspace();
    let (mut end, mut contact) = (solution.state.clone(), vec![0.0; nd]);
    let mut tangent = vec![0.0; interface.pattern().indices.len()];
    let jump = &solution.displacement[..nd];
    let mut evaluate = |sticking, tangent: Option<&mut [f64]>| {
        interface.evaluate(
            jump,
            sticking,
            &solution.state,
            &mut end,
            &mut workspace,
            &mut contact,
            tangent,
        )
    };
    evaluate(Sticking::Full, Some(&mut tangent));
    evaluate(Sticking::Coulomb, None);
    let [xx, xy, _, yx, yy, ..] = workspace.tangent();
    let [x, y, _] = &workspace.traction;
    let elastic = |i: usize| {
        let determinant = xx[i] * yy[i] - xy[i] * yx[i];
        match determinant > 0.0 {
            true => {
                let squares = yy[i] * x[i] * x[i] + xx[i] * y[i] * y[i] - (xy[i] + yx[i]) * x[i] * y[i];
                0.5 * squares / determinant
            }
            // Open, or without shear stiffness.
            false => 0.0,
        }
    };
    let weights = interface.operators().weights.iter().enumerate();
    let energy = weights.map(|(i, w)| w * elastic(i)).sum();
    let (jump, traction) = (workspace.jump, workspace.traction);
    (Points { jump, traction }, energy)
}
