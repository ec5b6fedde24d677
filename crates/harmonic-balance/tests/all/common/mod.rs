//! Forces at single coordinates with known answers.
#![allow(dead_code)]

use contact_laws::{Components, ComponentsMut, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut};
use cqsma_solver::{HystereticForce, Linearisation, PatternView, modes};
use faer::Mat;
use harmonic_balance::PointwiseForce;
use std::ops::Range;

/// A force at one coordinate, as a function of displacement and state.
#[derive(Clone, Debug)]
pub(crate) enum Element {
    /// Spring of `stiffness` in series with a slider of `limit`.
    Jenkins { stiffness: f64, limit: f64 },
    /// `coefficient u^3`.
    Cubic { coefficient: f64 },
    /// `coefficient u^2`.
    Quadratic { coefficient: f64 },
    /// Unilateral spring that is pressed by `preload` at rest.
    Unilateral { stiffness: f64, preload: f64 },
}

/// One element per leading coordinate. Points are coordinates, their jump is along x, their state `u` and the force there.
#[derive(Clone, Debug)]
pub(crate) struct Elements {
    pub elements: Vec<Element>,
    batches: Vec<Range<usize>>,
    diagonal: Vec<usize>,
    weights: Vec<f64>,
}

impl Elements {
    pub(crate) fn new(elements: Vec<Element>) -> Self {
        let n = elements.len();
        Self {
            elements,
            batches: (0..n).step_by(2).map(|from| from..n.min(from + 2)).collect(),
            diagonal: (0..=n).collect(),
            weights: vec![1.0; n],
        }
    }

    /// Force and its derivatives along the displacement and the two numbers of the state.
    fn respond(&self, point: usize, sticking: Sticking, u: f64, begin: [f64; 2]) -> (f64, [f64; 3]) {
        match self.elements[point] {
            Element::Jenkins { stiffness, limit } => {
                let trial = begin[1] + stiffness * (u - begin[0]);
                if sticking == Sticking::Coulomb && trial.abs() > limit {
                    (limit.copysign(trial), [0.0; 3])
                } else {
                    (trial, [stiffness, -stiffness, 1.0])
                }
            }
            Element::Cubic { coefficient } => (coefficient * u.powi(3), [3.0 * coefficient * u * u, 0.0, 0.0]),
            Element::Quadratic { coefficient } => (coefficient * u * u, [2.0 * coefficient * u, 0.0, 0.0]),
            Element::Unilateral { stiffness, preload } => {
                let force = stiffness * u + preload;
                if force > 0.0 {
                    (force - preload, [stiffness, 0.0, 0.0])
                } else {
                    (-preload, [0.0; 3])
                }
            }
        }
    }
}

impl HystereticForce for Elements {
    type State = Vec<[f64; 2]>;
    type Workspace = ();

    fn n_dofs(&self) -> usize {
        self.elements.len()
    }

    fn pattern(&self) -> PatternView<'_> {
        PatternView {
            indptr: &self.diagonal,
            indices: &self.diagonal[..self.elements.len()],
        }
    }

    fn initial_state(&self) -> Self::State {
        vec![[0.0; 2]; self.elements.len()]
    }

    fn workspace(&self) {}

    fn evaluate(
        &self,
        u: &[f64],
        sticking: Sticking,
        begin: &Self::State,
        end: &mut Self::State,
        (): &mut (),
        force: &mut [f64],
        mut tangent: Option<&mut [f64]>,
    ) -> RegimeCounts {
        for i in 0..self.elements.len() {
            let (f, slopes) = self.respond(i, sticking, u[i], begin[i]);
            force[i] = f;
            end[i] = [u[i], f];
            if let Some(tangent) = tangent.as_mut() {
                tangent[i] = slopes[0];
            }
        }
        RegimeCounts::default()
    }
}

impl PointwiseForce for Elements {
    fn n_points(&self) -> usize {
        self.elements.len()
    }

    fn batches(&self) -> &[Range<usize>] {
        &self.batches
    }

    fn n_state(&self, _batch: usize) -> usize {
        2
    }

    fn state_of(&self, batch: usize, state: &Self::State, into: &mut [f64]) {
        let n = self.batches[batch].len();
        for (i, point) in self.batches[batch].clone().enumerate() {
            (into[i], into[n + i]) = (state[point][0], state[point][1]);
        }
    }

    fn jumps(&self, u: &[f64], [x, y, n]: [&mut [f64]; 3]) {
        x.copy_from_slice(u);
        y.fill(0.0);
        n.fill(0.0);
    }

    fn subtract_gap(&self, _jump_n: &mut [f64]) {}

    fn forces(&self, [x, ..]: [&[f64]; 3], force: &mut [f64]) {
        force.copy_from_slice(x);
    }

    fn weights(&self) -> &[f64] {
        &self.weights
    }

    fn evaluate_batch(
        &self,
        batch: usize,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        mut tangent: Option<TangentMut<'_>>,
    ) {
        let n = jump.x.len();
        let ([u0, f0], [u1, f1]) = (begin.components::<2>(n), end.components::<2>(n));
        for (i, point) in self.batches[batch].clone().enumerate() {
            let (force, slopes) = self.respond(point, Sticking::Coulomb, jump.x[i], [u0[i], f0[i]]);
            (traction.x[i], traction.y[i], traction.n[i]) = (force, 0.0, 0.0);
            (u1[i], f1[i]) = (jump.x[i], force);
            if let Some(tangent) = tangent.as_mut() {
                tangent.xx[i] = slopes[0];
            }
        }
    }

    fn assemble_tangent(&self, [xx, ..]: [&[f64]; 9], values: &mut [f64]) {
        values.copy_from_slice(xx);
    }

    fn derivative_batch(
        &self,
        batch: usize,
        jump: Components<'_>,
        begin: StateView<'_>,
        d_jump: Components<'_>,
        d_begin: StateView<'_>,
        end: StateViewMut<'_>,
        d_end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        d_traction: ComponentsMut<'_>,
    ) {
        let n = jump.x.len();
        let ([u0, f0], [u1, f1]) = (begin.components::<2>(n), end.components::<2>(n));
        let ([du0, df0], [du1, df1]) = (d_begin.components::<2>(n), d_end.components::<2>(n));
        for (i, point) in self.batches[batch].clone().enumerate() {
            let (force, slopes) = self.respond(point, Sticking::Coulomb, jump.x[i], [u0[i], f0[i]]);
            let change = slopes[0] * d_jump.x[i] + slopes[1] * du0[i] + slopes[2] * df0[i];
            (traction.x[i], traction.y[i], traction.n[i]) = (force, 0.0, 0.0);
            (d_traction.x[i], d_traction.y[i], d_traction.n[i]) = (change, 0.0, 0.0);
            (u1[i], f1[i]) = (jump.x[i], force);
            (du1[i], df1[i]) = (d_jump.x[i], change);
        }
    }
}

/// A structure at rest.
pub(crate) fn linearised<'a>(
    stiffness: &'a Mat<f64>,
    mass: &'a Mat<f64>,
    force: &Elements,
    n_modes: usize,
) -> Linearisation<'a, Vec<[f64; 2]>> {
    let rest = vec![0.0; stiffness.nrows()];
    let state = force.initial_state();
    modes::linearise(stiffness.as_ref(), mass.as_ref(), force, rest, state, n_modes)
        .expect("the stuck structure is positive definite")
}

/// Masses of 1 kg in a chain of springs (N/m), the last one fixed.
pub(crate) fn chain(n: usize, spring: f64) -> (Mat<f64>, Mat<f64>) {
    let stiffness = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 if i + 1 == n => spring,
        0 => 2.0 * spring,
        1 => -spring,
        _ => 0.0,
    });
    (stiffness, Mat::identity(n, n))
}
