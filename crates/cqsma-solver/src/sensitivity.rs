//! Derivatives of static states, modes and loops with respect to parameters, by implicit differentiation.
//!
//! At an equilibrium `K u + F(u; s, p) = load` the change of the displacement with a parameter `p` solves
//! `(K + dF/du) u' = load' - K' u - dF/ds s' - dF/dp`, with the tangent that Newton's method has left there. The history `s` carries its own
//! change along: `s_end' = dS/du u' + dS/ds s' + dS/dp`. That is how static states are differentiated.
//!
//! Of a loop three numbers are wanted, half its range `Q`, its area `A` and the frequency `H` of its first harmonic, all of them functions of the
//! modal amplitudes `q_k` of the vertices, and of many parameters. So its vertices are gone through backwards. With the weight `w_k` of a vertex, the
//! slope of the number, and the adjoint `l` of the history that it leaves,
//!
//! ```text
//! (K + dF/du)^T m = w_k M phi + (dS/du)^T l,      l before it = (dS/ds)^T l - (dF/ds)^T m,
//! Q', A' or H' = sum over vertices of  w_k (M phi)' v_k + m^T (load' - K' v - dF/dp) + l^T dS/dp,   plus  l^T s' of the static state :
//! ```
//!
//! at most three linear solves per vertex, whatever the number of parameters. The result belongs to the discrete loop: to its vertices and its
//! number of cycles, which are held.
//!
//! All of `F` and `S` is differentiated by the force itself, on the branch that it takes. That matters more than it seems: a point that slipped
//! on first loading and shakes down returns to its slip limit to rounding, at every peak. A difference between neighbouring values of the
//! parameter would take it half as sticking and half as slipping, and the tangent as one of them.
//!
//! A loop is computed for a given modal force; its derivatives are given at the same modal amplitude. The logarithm of the modal force is one
//! more parameter of the loop, so that `d/dp` at constant `Q` is `d/dp - (dQ/dp) / (dQ/d ln alpha) d/d ln alpha`.

use crate::force::HystereticForce;
use crate::hysteresis::Loop;
use crate::linear::{Border, Stuck, TransposedSolves, solve, symmetrised};
use crate::modes::{Linearisation, Mode};
use crate::path::Path;
use crate::prestress::Prestress;
use contact_laws::{Sticking, WayBack};
use dense_algebra::{SystemMatrixRef, dot};
use faer::Mat;
use rayon::prelude::*;
use std::sync::Mutex;

/// Accuracy of the linear solves, relative in the energy norm. Damping is the small difference of large parts, and so is its derivative.
const TOLERANCE: f64 = 1e-9;

/// A step of a path, evaluated under friction.
#[derive(Debug)]
pub struct Step<'a, F: HystereticForce + ?Sized> {
    /// Where it leads to, over the leading coordinates.
    pub u: &'a [f64],
    /// The history that it begins with.
    pub begin: &'a F::State,
    /// What [`HystereticForce::evaluate`] has left.
    pub workspace: &'a F::Workspace,
}

/// A force that can be differentiated along a change of displacements, history and a parameter.
pub trait DifferentiableForce: HystereticForce {
    /// How it depends on a parameter.
    type Parameter: Sync;
    /// How a number grows with what parameters may change, as far as a path has been gone back along.
    type LocalGradient;

    /// What [`HystereticForce::evaluate`] gives, and its change along `d_u` (over the leading coordinates), `d_begin` and, if there is one, a unit
    /// of the parameter: `d_force` and `d_end`. One-sided at kinks, of the branch taken.
    fn derivative(
        &self,
        u: &[f64],
        sticking: Sticking,
        begin: &Self::State,
        d_u: &[f64],
        d_begin: &Self::State,
        parameter: Option<&Self::Parameter>,
        end: &mut Self::State,
        d_end: &mut Self::State,
        workspace: &mut Self::Workspace,
        force: &mut [f64],
        d_force: &mut [f64],
    );
    /// Change of the history of the unloaded structure with a unit of the parameter.
    fn initial_change(&self, parameter: &Self::Parameter) -> Self::State;
    /// Tangent values (N/m) with everything stuck at the value of the parameter plus a step, if there is one.
    fn stuck_tangent(
        &self,
        u: &[f64],
        begin: &Self::State,
        parameter: Option<(&Self::Parameter, f64)>,
        workspace: &mut Self::Workspace,
        tangent: &mut [f64],
    );
    /// The way back through a step: with adjoints `l` of the end state and `m` of the force, none if `forces` is empty, it gives
    /// `(dS/du)^T l - (dF/du)^T m` over the leading coordinates, adds `l^T dS/dp - m^T dF/dp` to `gradients`, and changes `l` as `way` has it. What of
    /// this adds up to nothing but a term of the begin of a whole path may be left out ([`Self::at_start`]). Of the step `before`, the first term with
    /// the adjoints that are left is found as well.
    fn transposed(
        &self,
        step: Step<'_, Self>,
        way: WayBack,
        adjoints: &mut [Self::State],
        forces: &[Vec<f64>],
        to_displacements: &mut [Vec<f64>],
        gradients: &mut [Self::LocalGradient],
        before: Option<(Step<'_, Self>, &mut [Vec<f64>])>,
    );
    /// That before the way back.
    fn no_gradient(&self) -> Self::LocalGradient;
    /// Adds what [`Self::transposed`] leaves of all steps of a path, by the history that the path begins with and the adjoint of that.
    fn at_start(&self, begin: &Self::State, adjoint: &Self::State, gradient: &mut Self::LocalGradient);
    /// How much of a gradient a parameter takes.
    fn of_parameter(&self, gradient: &Self::LocalGradient, parameter: &Self::Parameter) -> f64;
    /// Product of an adjoint of a history with a change of one.
    fn product(&self, adjoint: &Self::State, change: &Self::State) -> f64;
    /// No change of the history.
    fn no_change(&self) -> Self::State;
    /// `state += factor * change`.
    fn add_change(&self, state: &mut Self::State, factor: f64, change: &Self::State);
}

/// What a parameter changes, per unit of the parameter.
#[derive(Debug)]
pub struct Change<'a, F: DifferentiableForce> {
    /// A distance between neighbouring values that differences of smooth quantities can be taken over, in units of the parameter.
    pub step: f64,
    /// The force; none if it does not depend on the parameter.
    pub force: Option<&'a F::Parameter>,
    /// Of the stiffness: the sum of these factors times matrices.
    pub stiffness: Vec<(f64, SystemMatrixRef<'a>)>,
    /// Of the mass, likewise.
    pub mass: Vec<(f64, SystemMatrixRef<'a>)>,
    /// Of the static load.
    pub load: Option<&'a [f64]>,
}

/// Change of a static state per unit of a parameter.
#[derive(Clone, Debug)]
pub struct StaticRate<S> {
    /// Of the displacements.
    pub displacement: Vec<f64>,
    /// Of the committed history.
    pub state: S,
}

/// The force with memory for its derivatives.
struct Local<'a, F: DifferentiableForce> {
    force: &'a F,
    workspace: F::Workspace,
    end: F::State,
    contact: Vec<f64>,
    change: Vec<f64>,
}

impl<'a, F: DifferentiableForce> Local<'a, F> {
    fn new(force: &'a F) -> Self {
        Self {
            force,
            workspace: force.workspace(),
            end: force.no_change(),
            contact: vec![0.0; force.n_dofs()],
            change: vec![0.0; force.n_dofs()],
        }
    }

    /// Changes of force and, in `d_end`, of the end state.
    fn along(
        &mut self,
        u: &[f64],
        begin: &F::State,
        d_u: &[f64],
        d_begin: &F::State,
        parameter: Option<&F::Parameter>,
        d_end: &mut F::State,
    ) -> &[f64] {
        self.force.derivative(
            u,
            Sticking::Coulomb,
            begin,
            d_u,
            d_begin,
            parameter,
            &mut self.end,
            d_end,
            &mut self.workspace,
            &mut self.contact,
            &mut self.change,
        );
        &self.change
    }
}

/// `y += factor a x` for the sum `a` of factors times matrices.
pub fn add_product(factor: f64, a: &[(f64, SystemMatrixRef<'_>)], x: &[f64], y: &mut [f64]) {
    let mut product = vec![0.0; y.len()];
    for (own, matrix) in a {
        matrix.multiply(x, &mut product);
        y.iter_mut()
            .zip(&product)
            .for_each(|(y, product)| *y += factor * own * product);
    }
}

/// Changes of the static state under `force`, whose changes are those of `changes` beside those of the stiffness and the load. `None` if
/// the tangent there is singular, or a linear system in blocks is not solved.
pub fn static_rates<'a, F: DifferentiableForce>(
    stiffness: impl Into<SystemMatrixRef<'a>>,
    force: &F,
    prestress: &Prestress<F::State>,
    changes: &[Change<'_, F>],
) -> Option<Vec<StaticRate<F::State>>> {
    let (stiffness, pattern) = (stiffness.into(), force.pattern());
    let (u, nc) = (&prestress.displacement, force.n_dofs());
    let rest = force.initial_state();
    let mut local = Local::new(force);
    let [full, tangent] = [Sticking::Full, Sticking::Coulomb].map(|sticking| {
        let mut tangent = vec![0.0; pattern.indices.len()];
        let Local {
            end,
            workspace,
            contact,
            ..
        } = &mut local;
        force.evaluate(&u[..nc], sticking, &rest, end, workspace, contact, Some(&mut tangent));
        tangent
    });
    let stuck = Stuck::try_new(stiffness, pattern, &symmetrised(pattern, &full), force.reflections()).ok()?;
    let of_change = |local: &mut Local<'_, F>, change: &Change<'_, F>| {
        let begin = change
            .force
            .map_or_else(|| force.no_change(), |parameter| force.initial_change(parameter));
        let mut right = change.load.map_or_else(|| vec![0.0; u.len()], <[f64]>::to_vec);
        add_product(-1.0, &change.stiffness, u, &mut right);
        let mut d_end = force.no_change();
        let carried = local.along(&u[..nc], &rest, &vec![0.0; nc], &begin, change.force, &mut d_end);
        right.iter_mut().zip(carried).for_each(|(r, f)| *r -= f);
        let displacement = solve(&stuck, stiffness, pattern, &tangent, None, &right, TOLERANCE)?;
        let mut state = force.no_change();
        local.along(&u[..nc], &rest, &displacement[..nc], &begin, change.force, &mut state);
        Some(StaticRate { displacement, state })
    };
    let found = changes.par_iter().map_init(|| Local::new(force), of_change);
    found.collect()
}

/// Change of a mode per unit of a parameter.
#[derive(Clone, Debug)]
pub struct ModeRate {
    /// Of `omega^2` (rad^2/s^2).
    pub eigenvalue: f64,
    /// Of the mass-normalised shape.
    pub shape: Vec<f64>,
}

/// What the derivatives of all loops of a mode have in common.
pub struct Derivatives<'a, F: DifferentiableForce> {
    force: &'a F,
    mode: usize,
    parameters: Vec<ParameterRate<'a, F>>,
    /// Room for states, which loops leave to one another: it is long before memory that was given back can be written again.
    spare: Mutex<Vec<F::State>>,
}

/// How what motions of a mode start from changes with a parameter, per unit of it.
pub struct ParameterRate<'a, F: DifferentiableForce> {
    /// The structure and the force.
    pub change: Change<'a, F>,
    /// The static state, over the leading coordinates.
    pub state: StaticRate<F::State>,
    /// The mode.
    pub mode: ModeRate,
    /// The load of unit modal force, `M phi`.
    pub unit: Vec<f64>,
    /// The contact force of the static state, over the leading coordinates (N).
    pub reference: Vec<f64>,
}

impl<'a, F: DifferentiableForce> Derivatives<'a, F> {
    /// From the changes of the structure that vibrates and those of its static state, in the same order. `None` if the mode is not
    /// alone at its frequency.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] for a mode that there is not.
    pub fn try_new(
        structure: &Linearisation<'_, F::State>,
        force: &'a F,
        mode: usize,
        changes: Vec<Change<'a, F>>,
        statics: &[StaticRate<F::State>],
    ) -> Result<Option<Self>, crate::Error> {
        let followed = Mode::try_new(structure, force.pattern(), mode)?;
        let Some(modes) = mode_rates(structure, force, &followed, &changes, statics) else {
            return Ok(None);
        };
        let (n, nc) = (followed.shape.len(), force.n_dofs());
        let u = &structure.displacement[..nc];
        let parameters = changes.into_par_iter().zip(statics).zip(modes);
        let of_parameter =
            |local: &mut Local<'a, F>, ((change, given), mode): ((Change<'a, F>, &StaticRate<F::State>), ModeRate)| {
                let mut unit = vec![0.0; n];
                structure.mass.multiply(&mode.shape, &mut unit);
                add_product(1.0, &change.mass, &followed.shape, &mut unit);
                let state = StaticRate {
                    displacement: given.displacement[..nc].to_vec(),
                    state: given.state.clone(),
                };
                let mut d_end = force.no_change();
                let (d_u, d_begin) = (&state.displacement, &state.state);
                let reference = local.along(u, &structure.state, d_u, d_begin, change.force, &mut d_end);
                let reference = reference.to_vec();
                ParameterRate {
                    change,
                    state,
                    mode,
                    unit,
                    reference,
                }
            };
        let parameters = parameters.map_init(|| Local::new(force), of_parameter).collect();
        Ok(Some(Self {
            force,
            mode,
            parameters,
            spare: Mutex::default(),
        }))
    }

    /// The mode that they belong to, counted from 0.
    pub fn mode(&self) -> usize {
        self.mode
    }

    /// Parameter by parameter.
    pub fn parameters(&self) -> &[ParameterRate<'a, F>] {
        &self.parameters
    }

    /// A copy of a state.
    fn copy(&self, state: &F::State) -> F::State {
        match self.spare.lock().ok().and_then(|mut spare| spare.pop()) {
            Some(mut room) => {
                room.clone_from(state);
                room
            }
            None => state.clone(),
        }
    }

    /// Takes back the room of states that are no longer needed.
    fn leave(&self, states: impl IntoIterator<Item = F::State>) {
        if let Ok(mut spare) = self.spare.lock() {
            spare.extend(states);
        }
    }

    /// A companion of a loop.
    pub(crate) fn companion(&self) -> Companion<'_, F> {
        Companion {
            shared: self,
            vertices: Vec::new(),
        }
    }
}

/// Changes of a mode, from those of the structure stuck about the static state.
fn mode_rates<F: DifferentiableForce>(
    structure: &Linearisation<'_, F::State>,
    force: &F,
    mode: &Mode,
    changes: &[Change<'_, F>],
    statics: &[StaticRate<F::State>],
) -> Option<Vec<ModeRate>> {
    let (phi, lambda) = (&mode.shape, mode.eigenvalue);
    let (n, nc) = (phi.len(), force.n_dofs());
    let pattern = force.pattern();
    let border = Border {
        mass: structure.mass,
        lambda,
        inertia: &structure.stuck.response(&mode.unit.force),
    };
    let rooms = || (force.workspace(), vec![0.0; pattern.indices.len()]);
    let of_change = |(workspace, tangent): &mut (F::Workspace, Vec<f64>),
                     (change, state): (&Change<'_, F>, &StaticRate<F::State>)| {
        let mut rate = vec![0.0; tangent.len()];
        for side in [1.0, -1.0] {
            let u = structure.displacement[..nc].iter().zip(&state.displacement);
            let u: Vec<f64> = u.map(|(u, rate)| u + side * change.step * rate).collect();
            let mut begin = structure.state.clone();
            force.add_change(&mut begin, side * change.step, &state.state);
            let parameter = change.force.map(|parameter| (parameter, side * change.step));
            force.stuck_tangent(&u, &begin, parameter, workspace, tangent);
            let terms = rate.iter_mut().zip(&*tangent);
            terms.for_each(|(sum, t)| *sum += 0.5 * side / change.step * t);
        }
        let rate = crate::linear::symmetrised(pattern, &rate);
        // -(P' - lambda M') phi.
        let mut right = vec![0.0; n];
        pattern.add_product(&rate, phi, &mut right);
        right.iter_mut().for_each(|r| *r = -*r);
        add_product(-1.0, &change.stiffness, phi, &mut right);
        let mut own = vec![0.0; n];
        add_product(1.0, &change.mass, phi, &mut own);
        let along = -0.5 * dot(&own, phi);
        right.iter_mut().zip(own).for_each(|(r, own)| *r += lambda * own);
        let eigenvalue = -dot(&right, phi);
        right
            .iter_mut()
            .zip(&mode.unit.force)
            .for_each(|(r, m)| *r += eigenvalue * m);
        let mut shape = solve(
            &structure.stuck,
            structure.stiffness,
            pattern,
            &structure.tangent,
            Some(&border),
            &right,
            TOLERANCE,
        )?;
        // The mass-normalised shape keeps its length as the mass changes.
        shape.iter_mut().zip(phi).for_each(|(s, phi)| *s += along * phi);
        Some(ModeRate { eigenvalue, shape })
    };
    let found = changes.par_iter().zip(statics).map_init(rooms, of_change);
    found.collect()
}

/// Remembers a loop for its derivatives.
pub(crate) struct Companion<'a, F: DifferentiableForce> {
    shared: &'a Derivatives<'a, F>,
    vertices: Vec<Vertex<F>>,
}

/// A vertex of a path.
struct Vertex<F: DifferentiableForce> {
    /// Modal force.
    at: f64,
    /// Displacements from the static state.
    v: Vec<f64>,
    begin: F::State,
    /// What the evaluation there has left.
    workspace: F::Workspace,
    tangent: Vec<f64>,
    /// Whether the history that it leads to is the one that later vertices start from.
    is_committed: bool,
}

impl<F: DifferentiableForce> Vertex<F> {
    /// The step to it, at the displacements `u`.
    fn step<'a>(&'a self, u: &'a [f64]) -> Step<'a, F> {
        Step {
            u,
            begin: &self.begin,
            workspace: &self.workspace,
        }
    }
}

/// What goes along with a loop; whether it differentiates is not the loop's business.
pub(crate) trait Follower<F: HystereticForce> {
    /// A vertex has been found.
    fn vertex(&mut self, path: &Path<'_, F>);
    /// The history of the last vertex becomes the one that later vertices start from.
    fn commit(&mut self);
    /// Number of the last vertex.
    fn last(&self) -> usize;
    /// Derivatives of a loop whose vertices have the given numbers; none if a linear system could not be solved.
    fn rates(&self, hysteresis: &Loop, numbers: &[usize], path: &Path<'_, F>) -> Option<Vec<LoopRate>>;
}

/// What is differentiated of a loop: half its range, its area, and the square of the frequency of its first harmonic.
const GOALS: usize = 3;

impl<F: DifferentiableForce> Companion<'_, F> {
    /// Numbers of the vertices that a goal depends on, from the last to the first, each with the first of the goals that does.
    fn counting(&self, weights: &[[f64; GOALS]]) -> Vec<(usize, usize)> {
        let mut is_met = [false; GOALS];
        let of_vertex = |(number, (vertex, weight)): (usize, (&Vertex<F>, &[f64; GOALS]))| {
            for (is_met, weight) in is_met.iter_mut().zip(weight) {
                *is_met |= *weight != 0.0;
            }
            // A vertex without a weight counts for the later ones that begin in it.
            let counts = |goal: &usize| weight[*goal] != 0.0 || (vertex.is_committed && is_met[*goal]);
            (0..GOALS).find(counts).map(|first| (number, first))
        };
        self.vertices
            .iter()
            .zip(weights)
            .enumerate()
            .rev()
            .filter_map(of_vertex)
            .collect()
    }

    /// Derivatives of the goals with respect to all parameters at the same force, and last to the logarithm of the force,
    /// but for what area and frequency grow by as they are products with the force. `weights` are those of the amplitudes of all vertices.
    fn sweep(&self, weights: &[[f64; GOALS]], path: &Path<'_, F>) -> Option<Vec<[f64; GOALS]>> {
        let Derivatives { force, parameters, .. } = self.shared;
        let equilibrium = &path.equilibrium;
        let (nc, pattern) = (force.n_dofs(), force.pattern());
        let zero = force.no_change();
        let mut sums = vec![[0.0; GOALS]; parameters.len() + 1];
        let mut adjoints: [F::State; GOALS] = std::array::from_fn(|_| self.shared.copy(&zero));
        let mut by_displacement = vec![vec![0.0; nc]; GOALS];
        // Of the vertex at hand, by the adjoints of the history that it leaves.
        let mut by_history = vec![vec![0.0; nc]; GOALS];
        let mut gradients: [F::LocalGradient; GOALS] = std::array::from_fn(|_| force.no_gradient());
        // Of all vertices at once, so that the matrices are read once.
        let motions = Mat::from_fn(path.unit.force.len(), self.vertices.len(), |row, vertex| {
            self.vertices[vertex].v[row]
        });
        let stiffness_changes: Vec<Vec<Mat<f64>>> = parameters
            .iter()
            .map(|parameter| {
                let terms = parameter.change.stiffness.iter();
                terms
                    .map(|(factor, matrix)| *factor * matrix.product(motions.as_ref()))
                    .collect()
            })
            .collect();
        let counting = self.counting(weights);
        for (place, &(number, first)) in counting.iter().enumerate() {
            let (vertex, weight) = (&self.vertices[number], &weights[number]);
            let before = counting.get(place + 1);
            // Adjoints that come from later vertices pass by one that is not committed.
            let first = before.map_or(first, |(_, of_before)| first.min(*of_before));
            let mut solves = TransposedSolves::new(equilibrium.stuck, pattern, &vertex.tangent);
            let mut forces = Vec::with_capacity(GOALS);
            for (goal, history) in by_history.iter().enumerate().skip(first) {
                let mut right: Vec<f64> = path.unit.force.iter().map(|unit| weight[goal] * unit).collect();
                right.iter_mut().zip(history).for_each(|(r, own)| *r += own);
                let found = match solves.solve(&right, TOLERANCE) {
                    Some(found) => found.v,
                    None => {
                        let matrix = pattern.added_to(equilibrium.stiffness.dense()?, &vertex.tangent);
                        dense_algebra::solve_general(matrix.transpose().to_owned(), &right)?
                    }
                };
                forces.push(found);
            }
            let way = match vertex.is_committed {
                true => WayBack::Committed,
                false => WayBack::Passed,
            };
            by_history.iter_mut().for_each(|values| values.fill(0.0));
            let before = before.map(|(number, _)| &self.vertices[*number]);
            let before = before.filter(|before| before.is_committed);
            let displacement = |vertex: &Vertex<F>| -> Vec<f64> {
                let terms = equilibrium.reference.iter().zip(&vertex.v);
                terms.map(|(u, v)| u + v).collect()
            };
            let (u, u_before) = (displacement(vertex), before.map(displacement));
            let before = before.zip(u_before.as_ref()).map(|(before, u)| before.step(u));
            force.transposed(
                vertex.step(&u),
                way,
                &mut adjoints[first..],
                &forces,
                &mut by_displacement[first..],
                &mut gradients[first..],
                before.map(|before| (before, &mut by_history[first..])),
            );
            for (at, (sum, parameter)) in sums.iter_mut().zip(parameters).enumerate() {
                let mut right: Vec<f64> = parameter.unit.iter().map(|unit| vertex.at * unit).collect();
                let terms = right.iter_mut().zip(&parameter.reference);
                terms.for_each(|(r, reference)| *r += reference);
                for change in &stiffness_changes[at] {
                    let terms = right.iter_mut().zip(change.col(number).iter());
                    terms.for_each(|(r, change)| *r -= change);
                }
                let amplitude = dot(&parameter.unit, &vertex.v);
                for (goal, sum) in sum.iter_mut().enumerate().skip(first) {
                    *sum += weight[goal] * amplitude + dot(&forces[goal - first], &right);
                    *sum += dot(&by_displacement[goal], &parameter.state.displacement);
                }
            }
            if let Some(by_force) = sums.last_mut() {
                // All forces of the loop grow with its peak.
                for (sum, m) in by_force[first..].iter_mut().zip(&forces) {
                    *sum += vertex.at * dot(m, &path.unit.force);
                }
            }
        }
        if let Some(start) = self.vertices.first() {
            let of_goals = adjoints.iter().zip(&mut gradients);
            of_goals.for_each(|(adjoint, gradient)| force.at_start(&start.begin, adjoint, gradient));
        }
        for (sum, parameter) in sums.iter_mut().zip(parameters) {
            for (sum, (adjoint, gradient)) in sum.iter_mut().zip(adjoints.iter().zip(&gradients)) {
                let own = parameter.change.force.map(|own| force.of_parameter(gradient, own));
                *sum += force.product(adjoint, &parameter.state.state) + own.unwrap_or(0.0);
            }
        }
        self.shared.leave(adjoints);
        Some(sums)
    }
}

impl<F: DifferentiableForce> Drop for Companion<'_, F> {
    fn drop(&mut self) {
        self.shared.leave(self.vertices.drain(..).map(|vertex| vertex.begin));
    }
}

impl<F: DifferentiableForce> Follower<F> for Companion<'_, F> {
    fn vertex(&mut self, path: &Path<'_, F>) {
        let sequence = &path.sequence;
        self.vertices.push(Vertex {
            at: path.at,
            v: sequence.motion.v.clone(),
            begin: self.shared.copy(&sequence.begin),
            workspace: sequence.workspace.clone(),
            tangent: sequence.tangent.clone(),
            is_committed: false,
        });
    }

    fn commit(&mut self) {
        if let Some(last) = self.vertices.last_mut() {
            last.is_committed = true;
        }
    }

    fn last(&self) -> usize {
        self.vertices.len().saturating_sub(1)
    }

    fn rates(&self, hysteresis: &Loop, numbers: &[usize], path: &Path<'_, F>) -> Option<Vec<LoopRate>> {
        let (low, high) = hysteresis.extremes();
        let mut weights = vec![[0.0; GOALS]; self.vertices.len()];
        let number = |wanted: f64| {
            let at = hysteresis.amplitude.iter().position(|q| *q == wanted)?;
            numbers.get(at).copied()
        };
        weights[number(high)?][0] += 0.5;
        weights[number(low)?][0] -= 0.5;
        for (goal, of_vertices) in [(1, hysteresis.area_weights()), (2, hysteresis.harmonic_weights())] {
            for (weight, number) in of_vertices.into_iter().zip(numbers) {
                weights[*number][goal] += weight;
            }
        }
        let mut sums = self.sweep(&weights, path)?;
        let [half, area] = [0.5 * (high - low), hysteresis.area()];
        let harmonic = hysteresis.harmonic_omega().powi(2);
        let [by_force, area_by_force, harmonic_by_force] = sums.pop()?;
        let by_force = by_force / half;
        let has_area = area != 0.0;
        let rates = sums.into_iter().map(|[of_half, of_area, of_harmonic]| {
            let ln_amplitude = of_half / half;
            // How much less force brings the amplitude back.
            let back = ln_amplitude / by_force;
            let ln_dissipation = has_area.then(|| of_area / area - back * (area_by_force / area + 1.0));
            let ln_omega = -0.5 * back;
            let ln_zeta = ln_dissipation.map(|of_area| of_area + back);
            let ln_harmonic_omega = 0.5 * (of_harmonic / harmonic - back * (harmonic_by_force / harmonic + 1.0));
            LoopRate {
                // omega^2 Q is the force, and Q is held; zeta is the area over 2 pi Q times the force.
                ln_omega,
                ln_zeta,
                ln_dissipation,
                ln_harmonic_omega,
                ln_harmonic_zeta: ln_zeta.map(|zeta| zeta + 2.0 * (ln_omega - ln_harmonic_omega)),
                ln_amplitude,
            }
        });
        Some(rates.collect())
    }
}

/// Derivatives of what a loop gives with respect to one parameter, per unit of the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoopRate {
    /// Of the logarithm of the secant frequency, at the same modal amplitude.
    pub ln_omega: f64,
    /// Of the logarithm of the damping ratio, at the same modal amplitude; none of a loop without area, and meaningless where the damping is not
    /// resolved.
    pub ln_zeta: Option<f64>,
    /// Of the logarithm of the dissipation per cycle, at the same modal amplitude; likewise.
    pub ln_dissipation: Option<f64>,
    /// Of the logarithm of the frequency of the first harmonic, at the same modal amplitude.
    pub ln_harmonic_omega: f64,
    /// Of the logarithm of the damping ratio with that frequency, at the same modal amplitude; likewise.
    pub ln_harmonic_zeta: Option<f64>,
    /// Of the logarithm of the modal amplitude, at the same modal force.
    pub ln_amplitude: f64,
}
