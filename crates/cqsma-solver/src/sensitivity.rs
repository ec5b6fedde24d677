//! Derivatives of static states, modes and loops with respect to parameters, by implicit differentiation.
//!
//! At an equilibrium `K u + F(u; s, p) = load` the change of the displacement with a parameter `p` solves
//! `(K + dF/du) u' = load' - K' u - dF/ds s' - dF/dp`, with the tangent that Newton's method has left there. The history `s` carries its own
//! change along: `s_end' = dS/du u' + dS/ds s' + dS/dp`. So the derivative of a loop is that of its vertices, one linear solve per
//! parameter and vertex, and it belongs to the discrete loop: to its vertices and its number of cycles, which are held.
//!
//! All of `F` and `S` is differentiated by the force itself, on the branch that it takes. That matters more than it seems: a point that slipped
//! on first loading and shakes down returns to its slip limit to rounding, at every peak. A difference between neighbouring values of the
//! parameter would take it half as sticking and half as slipping, and the tangent as one of them.
//!
//! A loop is computed for a given modal force; its derivatives are given at the same modal amplitude `Q`. The logarithm of the modal force is one
//! more parameter of the loop, so that `d/dp` at constant `Q` is `d/dp - (dQ/dp) / (dQ/d ln alpha) d/d ln alpha`.

use crate::force::HystereticForce;
use crate::hysteresis::Loop;
use crate::linear::{Motion, Solves, dot, multiply};
use crate::modes::{Linearisation, Mode};
use crate::path::Path;
use crate::prestress::Prestress;
use contact_laws::Sticking;
use faer::{Mat, MatRef};

/// Accuracy of the linear solves, relative in the energy norm. Damping is the small difference of large parts, and so is its derivative.
const TOLERANCE: f64 = 1e-11;

/// A force that can be differentiated along a change of displacements, history and a parameter.
pub trait DifferentiableForce: HystereticForce {
    /// How it depends on a parameter.
    type Parameter: Sync;

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
    /// Of the stiffness.
    pub stiffness: Option<MatRef<'a, f64>>,
    /// Of the mass.
    pub mass: Option<MatRef<'a, f64>>,
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

/// `y -= a x` for matrices that may be absent.
fn subtract_product(a: Option<MatRef<'_, f64>>, x: &[f64], y: &mut [f64]) {
    if let Some(a) = a {
        let mut product = vec![0.0; y.len()];
        multiply(a, x, &mut product);
        y.iter_mut().zip(product).for_each(|(y, product)| *y -= product);
    }
}

/// Changes of the static state under `force`, whose changes are those of `changes` beside those of the stiffness and the load. `None` if
/// the tangent there is singular.
pub fn static_rates<F: DifferentiableForce>(
    stiffness: MatRef<'_, f64>,
    force: &F,
    prestress: &Prestress<F::State>,
    changes: &[Change<'_, F>],
) -> Option<Vec<StaticRate<F::State>>> {
    let (u, nc) = (&prestress.displacement, force.n_dofs());
    let rest = force.initial_state();
    let mut local = Local::new(force);
    let mut tangent = vec![0.0; force.pattern().indices.len()];
    force.evaluate(
        &u[..nc],
        Sticking::Coulomb,
        &rest,
        &mut local.end,
        &mut local.workspace,
        &mut local.contact,
        Some(&mut tangent),
    );
    let (mut begins, mut rights) = (Vec::new(), Vec::new());
    for change in changes {
        let begin = change
            .force
            .map_or_else(|| force.no_change(), |parameter| force.initial_change(parameter));
        let mut right = change.load.map_or_else(|| vec![0.0; u.len()], <[f64]>::to_vec);
        subtract_product(change.stiffness, u, &mut right);
        let mut d_end = force.no_change();
        let carried = local.along(&u[..nc], &rest, &vec![0.0; nc], &begin, change.force, &mut d_end);
        right.iter_mut().zip(carried).for_each(|(r, f)| *r -= f);
        begins.push(begin);
        rights.push(right);
    }
    let rights: Vec<&[f64]> = rights.iter().map(Vec::as_slice).collect();
    let matrix = force.pattern().added_to(stiffness, &tangent);
    let found = dense_algebra::solve_general_all(matrix, &rights)?;
    let rates = found.into_iter().zip(begins).zip(changes);
    let rates = rates.map(|((displacement, begin), change)| {
        let mut state = force.no_change();
        local.along(&u[..nc], &rest, &displacement[..nc], &begin, change.force, &mut state);
        StaticRate { displacement, state }
    });
    Some(rates.collect())
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
        let followed = Mode::try_new(structure, mode)?;
        let Some(modes) = mode_rates(structure, force, &followed, &changes, statics) else {
            return Ok(None);
        };
        let (n, nc) = (followed.shape.len(), force.n_dofs());
        let u = &structure.displacement[..nc];
        let mut local = Local::new(force);
        let parameters = changes.into_iter().zip(statics).zip(modes);
        let parameters = parameters.map(|((change, given), mode)| {
            let mut unit = vec![0.0; n];
            multiply(structure.mass, &mode.shape, &mut unit);
            if let Some(mass) = change.mass {
                let mut own = vec![0.0; n];
                multiply(mass, &followed.shape, &mut own);
                unit.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
            }
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
        });
        let parameters = parameters.collect();
        Ok(Some(Self {
            force,
            mode,
            parameters,
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

    /// A companion of a loop.
    pub(crate) fn companion(&self) -> Companion<'_, F> {
        let carried = self.parameters.iter().map(|parameter| parameter.state.state.clone());
        Companion {
            shared: self,
            local: Local::new(self.force),
            begin: carried.chain([self.force.no_change()]).collect(),
            vertex: Vec::new(),
            is_lost: false,
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
    let mut workspace = force.workspace();
    let mut tangent = vec![0.0; pattern.indices.len()];
    let mut rights = Vec::with_capacity(changes.len());
    let mut eigenvalues = Vec::with_capacity(changes.len());
    // The border has the unit of the matrix.
    let matrix = pattern.added_to(structure.stiffness, structure.stuck.tangent());
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |m, v| m.max(v.abs()));
    let scale = largest(&mut matrix.diagonal().column_vector().iter().copied())
        / largest(&mut mode.unit.p.iter().copied()).max(f64::MIN_POSITIVE);
    for (change, state) in changes.iter().zip(statics) {
        let mut rate = vec![0.0; tangent.len()];
        for side in [1.0, -1.0] {
            let u = structure.displacement[..nc].iter().zip(&state.displacement);
            let u: Vec<f64> = u.map(|(u, rate)| u + side * change.step * rate).collect();
            let mut begin = structure.state.clone();
            force.add_change(&mut begin, side * change.step, &state.state);
            let parameter = change.force.map(|parameter| (parameter, side * change.step));
            force.stuck_tangent(&u, &begin, parameter, &mut workspace, &mut tangent);
            let terms = rate.iter_mut().zip(&tangent);
            terms.for_each(|(sum, t)| *sum += 0.5 * side / change.step * t);
        }
        let rate = crate::linear::symmetrised(pattern, &rate);
        // -(P' - lambda M') phi.
        let mut right = vec![0.0; n];
        pattern.add_product(&rate, phi, &mut right);
        right.iter_mut().for_each(|r| *r = -*r);
        subtract_product(change.stiffness, phi, &mut right);
        let mut of_mass = 0.0;
        if let Some(mass) = change.mass {
            let mut own = vec![0.0; n];
            multiply(mass, phi, &mut own);
            of_mass = dot(&own, phi);
            right.iter_mut().zip(own).for_each(|(r, own)| *r += lambda * own);
        }
        let eigenvalue = -dot(&right, phi);
        right
            .iter_mut()
            .zip(&mode.unit.p)
            .for_each(|(r, m)| *r += eigenvalue * m);
        right.push(-0.5 * scale * of_mass);
        rights.push(right);
        eigenvalues.push(eigenvalue);
    }
    let bordered = Mat::from_fn(n + 1, n + 1, |i, j| match (i == n, j == n) {
        (false, false) => matrix[(i, j)] - lambda * structure.mass[(i, j)],
        (true, true) => 0.0,
        _ => scale * mode.unit.p[i.min(j)],
    });
    let rights: Vec<&[f64]> = rights.iter().map(Vec::as_slice).collect();
    let found = dense_algebra::solve_general_all(bordered, &rights)?;
    let rates = found.into_iter().zip(eigenvalues).map(|(mut shape, eigenvalue)| {
        shape.truncate(n);
        ModeRate { eigenvalue, shape }
    });
    Some(rates.collect())
}

/// Follows a loop and carries its derivatives along: those of all parameters, then that of the logarithm of the modal force.
pub(crate) struct Companion<'a, F: DifferentiableForce> {
    shared: &'a Derivatives<'a, F>,
    local: Local<'a, F>,
    /// Changes of the history at the last commit.
    begin: Vec<F::State>,
    /// At the last vertex.
    vertex: Vec<VertexRate>,
    /// A linear system could not be solved.
    is_lost: bool,
}

/// Changes at a vertex.
struct VertexRate {
    /// Of the jump in all, the static state included.
    total: Vec<f64>,
    /// Of the modal amplitude.
    amplitude: f64,
}

/// What goes along with a loop; whether it differentiates is not the loop's business.
pub(crate) trait Follower<F: HystereticForce> {
    /// A vertex has been found.
    fn vertex(&mut self, path: &Path<'_, F>);
    /// The history of the last vertex becomes the one that later vertices start from.
    fn commit(&mut self, path: &Path<'_, F>);
    /// Changes of the modal amplitude at the last vertex; none if they were lost.
    fn amplitudes(&self) -> Option<Vec<f64>>;
}

impl<F: DifferentiableForce> Companion<'_, F> {
    /// Total displacements of the contact at the vertex.
    fn total(path: &Path<'_, F>) -> Vec<f64> {
        let reference = path.equilibrium.reference.iter();
        reference.zip(&path.sequence.motion.v).map(|(u, v)| u + v).collect()
    }

    /// Derivatives at the vertex that the path has reached; `None` if a linear system could not be solved.
    fn differentiate(&mut self, path: &Path<'_, F>) -> Option<Vec<VertexRate>> {
        let (sequence, equilibrium) = (&path.sequence, &path.equilibrium);
        let u = Self::total(path);
        let Motion { v, .. } = &sequence.motion;
        let begin = &sequence.begin;
        let mut solves = Solves::new(equilibrium.stuck, equilibrium.force.pattern(), sequence.tangent());
        let mut unused = self.shared.force.no_change();
        let none = vec![0.0; u.len()];
        let parameters = self.shared.parameters.iter().map(Some).chain([None]);
        let mut rates = Vec::with_capacity(self.begin.len());
        for (parameter, carried) in parameters.zip(&self.begin) {
            let still = parameter.map_or(none.as_slice(), |p| &p.state.displacement);
            let mut right = vec![0.0; v.len()];
            let own = parameter.and_then(|parameter| parameter.change.force);
            let along = self.local.along(&u, begin, still, carried, own, &mut unused);
            right.iter_mut().zip(along).for_each(|(r, f)| *r -= f);
            match parameter {
                Some(parameter) => {
                    right.iter_mut().zip(&parameter.reference).for_each(|(r, f)| *r += f);
                    right
                        .iter_mut()
                        .zip(&parameter.unit)
                        .for_each(|(r, unit)| *r += path.at * unit);
                    subtract_product(parameter.change.stiffness, v, &mut right);
                }
                // All forces of the loop grow with its peak.
                None => right
                    .iter_mut()
                    .zip(&path.unit.p)
                    .for_each(|(r, unit)| *r += path.at * unit),
            }
            let found = match solves.solve(&right, TOLERANCE) {
                Some(found) => found.v,
                None => {
                    let matrix = equilibrium
                        .force
                        .pattern()
                        .added_to(equilibrium.stiffness, sequence.tangent());
                    dense_algebra::solve_general(matrix, &right)?
                }
            };
            let amplitude = dot(&path.unit.p, &found) + parameter.map_or(0.0, |p| dot(&p.unit, v));
            rates.push(VertexRate {
                total: still.iter().zip(&found).map(|(a, b)| a + b).collect(),
                amplitude,
            });
        }
        Some(rates)
    }
}

impl<F: DifferentiableForce> Follower<F> for Companion<'_, F> {
    fn vertex(&mut self, path: &Path<'_, F>) {
        if self.is_lost {
            return;
        }
        match self.differentiate(path) {
            Some(rates) => self.vertex = rates,
            None => self.is_lost = true,
        }
    }

    fn commit(&mut self, path: &Path<'_, F>) {
        if self.is_lost {
            return;
        }
        let u = Self::total(path);
        let mut end = self.shared.force.no_change();
        let own = self.shared.parameters.iter().map(|parameter| parameter.change.force);
        let own = own.chain([None]);
        for ((begin, rate), own) in self.begin.iter_mut().zip(&self.vertex).zip(own) {
            self.local
                .along(&u, &path.sequence.begin, &rate.total, begin, own, &mut end);
            std::mem::swap(begin, &mut end);
        }
    }

    fn amplitudes(&self) -> Option<Vec<f64>> {
        (!self.is_lost).then(|| self.vertex.iter().map(|rate| rate.amplitude).collect())
    }
}

/// Derivatives of what a loop gives with respect to one parameter, per unit of the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoopRate {
    /// Of the logarithm of the secant frequency, at the same modal amplitude.
    pub ln_omega: f64,
    /// Of the logarithm of the damping ratio, at the same modal amplitude; meaningless where the damping is not resolved.
    pub ln_zeta: f64,
    /// Of the logarithm of the dissipation per cycle, at the same modal amplitude.
    pub ln_dissipation: f64,
    /// Of the logarithm of the modal amplitude, at the same modal force.
    pub ln_amplitude: f64,
}

/// Derivatives of a loop from those of the amplitudes of its vertices, of which the last one in each list is with respect to the logarithm of the
/// modal force.
pub(crate) fn loop_rates(hysteresis: &Loop, vertices: &[Vec<f64>]) -> Vec<LoopRate> {
    let n = vertices.first().map_or(0, Vec::len);
    let position = |wanted: f64| hysteresis.amplitude.iter().position(|q| *q == wanted).unwrap_or(0);
    let (low, high) = hysteresis.extremes();
    let (at_low, at_high) = (position(low), position(high));
    let area = hysteresis.area();
    // Of amplitude and area, both logarithmic and at the same force.
    let plain = |which: usize| {
        let of = |vertex: usize| vertices.get(vertex).map_or(0.0, |rates| rates[which]);
        let varied = Loop {
            force: hysteresis.force.clone(),
            amplitude: (0..vertices.len()).map(of).collect(),
        };
        [(of(at_high) - of(at_low)) / (high - low), varied.area() / area]
    };
    let Some(last) = n.checked_sub(1) else {
        return Vec::new();
    };
    let [amplitude_by_force, area_by_force] = plain(last);
    let area_by_force = area_by_force + 1.0;
    (0..last)
        .map(|which| {
            let [ln_amplitude, ln_area] = plain(which);
            // How much less force brings the amplitude back.
            let back = ln_amplitude / amplitude_by_force;
            let ln_dissipation = ln_area - back * area_by_force;
            LoopRate {
                // omega^2 Q is the force, and Q is held; zeta is the area over 2 pi Q times the force.
                ln_omega: -0.5 * back,
                ln_zeta: ln_dissipation + back,
                ln_dissipation,
                ln_amplitude,
            }
        })
        .collect()
}
