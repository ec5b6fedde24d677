//! The interface point by point: for methods that follow each point through many load states by itself, such as harmonic balance.

use crate::interface::{Interface, State, TILE, Variation};
use contact_laws::{Components, ComponentsMut, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut};
use std::ops::Range;

/// How the points of an interface are divided into batches of points with one law.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Batches {
    points: Vec<Range<usize>>,
    /// Of each batch: its law, the law's first point, and the begin of the law's block in a [`State`].
    places: Vec<(usize, usize, usize)>,
}

impl Batches {
    /// The points of each batch, in order and without holes.
    pub fn points(&self) -> &[Range<usize>] {
        &self.points
    }
}

impl Interface {
    /// Batches of at most 64 points.
    pub fn batches(&self) -> Batches {
        let (mut points, mut places) = (Vec::new(), Vec::new());
        let mut block = 0;
        for (index, (range, law)) in self.laws.iter().enumerate() {
            for from in range.clone().step_by(TILE) {
                points.push(from..range.end.min(from + TILE));
                places.push((index, range.start, block));
            }
            block += range.len() * law.info().n_state();
        }
        Batches { points, places }
    }

    /// Batches of these points alone, which ascend; those beside each other are in one.
    pub fn batches_of(&self, selected: &[usize]) -> Batches {
        let (mut points, mut places) = (Vec::new(), Vec::new());
        let mut block = 0;
        for (index, (range, law)) in self.laws.iter().enumerate() {
            let from = selected.partition_point(|point| *point < range.start);
            let to = selected.partition_point(|point| *point < range.end);
            for run in selected[from..to].chunk_by(|a, b| a + 1 == *b) {
                for part in run.chunks(TILE) {
                    points.push(part[0]..part[0] + part.len());
                    places.push((index, range.start, block));
                }
            }
            block += range.len() * law.info().n_state();
        }
        Batches { points, places }
    }

    /// State components per point of a batch.
    pub fn batch_states(&self, batches: &Batches, batch: usize) -> usize {
        self.laws[batches.places[batch].0].1.info().n_state()
    }

    /// Copies the history of a batch, `[component][point]`.
    ///
    /// # Panics
    /// If `into` has another length than the batch's points times [`Interface::batch_states`].
    pub fn copy_state(&self, batches: &Batches, batch: usize, state: &State, into: &mut [f64]) {
        let (law, first, block) = batches.places[batch];
        let points = &batches.points[batch];
        assert_eq!(into.len(), points.len() * self.batch_states(batches, batch));
        self.copy_history(law, block, points.start - first..points.end - first, state, into);
    }

    /// Jumps at all points of nodal jumps `jump` (m), without the gap.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn interpolate(&self, jump: &[f64], [x, y, n]: [&mut [f64]; 3]) {
        for (nodes, points, shape) in self.operators.elements() {
            let fields = [&mut x[points.clone()], &mut y[points.clone()], &mut n[points]];
            (shape.shape.kernels.interpolate)(&shape.values, nodes, jump, &self.is_held, fields);
        }
    }

    /// Nodal forces (N) of tractions at all points (Pa).
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn integrate(&self, traction: [&[f64]; 3], force: &mut [f64]) {
        force.fill(0.0);
        for (nodes, points, shape) in self.operators.elements() {
            let weights = &self.operators.weights[points.clone()];
            let fields = traction.map(|field| &field[points.clone()]);
            (shape.shape.kernels.integrate)(&shape.values, weights, fields, nodes, force);
        }
        for &coordinate in self.operators.held() {
            force[coordinate] = 0.0;
        }
    }

    /// Tangent values (N/m) in the order of [`Interface::pattern`] of tangents at all points, row by row (Pa/m).
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn integrate_tangent(&self, tangent: [&[f64]; 9], values: &mut [f64]) {
        self.assemble_tangent(tangent, values);
    }

    /// Tractions, end state and, on request, tangent of a batch, whose states are stored `[component][point]`.
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn evaluate_batch(
        &self,
        batches: &Batches,
        batch: usize,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        tangent: Option<TangentMut<'_>>,
    ) -> RegimeCounts {
        let (law, of_law) = self.batch_law(batches, batch);
        law.evaluate(of_law, sticking, jump, begin, end, traction, tangent, None)
    }

    /// Tractions of a batch along a path ([`TractionLaw::follow`](contact_laws::TractionLaw::follow)).
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn follow_batch(
        &self,
        batches: &Batches,
        batch: usize,
        sticking: Sticking,
        path: &[f64],
        state: &mut [f64],
        room: &mut [f64],
        traction: &mut [f64],
    ) {
        let (law, of_law) = self.batch_law(batches, batch);
        law.follow(of_law, sticking, path, state, room, traction);
    }

    /// The same with their derivatives along a direction ([`TractionLaw::derivative`](contact_laws::TractionLaw::derivative)).
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn derivative_batch(
        &self,
        batches: &Batches,
        batch: usize,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        d_jump: Components<'_>,
        d_begin: StateView<'_>,
        end: StateViewMut<'_>,
        d_end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        d_traction: ComponentsMut<'_>,
    ) {
        let (law, of_law) = self.batch_law(batches, batch);
        law.derivative(
            of_law, sticking, jump, begin, d_jump, d_begin, end, d_end, traction, d_traction,
        );
    }

    /// The same with the change of a parameter by one beside them. `d_jump` and `d_begin` are used up.
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn parameter_batch(
        &self,
        batches: &Batches,
        batch: usize,
        sticking: Sticking,
        variation: &Variation,
        jump: Components<'_>,
        begin: StateView<'_>,
        d_jump: ComponentsMut<'_>,
        d_begin: &mut [f64],
        end: StateViewMut<'_>,
        d_end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        d_traction: ComponentsMut<'_>,
    ) {
        let (law, of_law) = self.batch_law(batches, batch);
        if !variation.gap.is_empty() {
            let gap = &variation.gap[batches.points[batch].clone()];
            d_jump.n.iter_mut().zip(gap).for_each(|(n, gap)| *n -= gap);
        }
        variation.scalings[batches.places[batch].0].derivative(
            law, of_law, sticking, jump, begin, d_jump, d_begin, end, d_end, traction, d_traction,
        );
    }

    /// The law of a batch and the law's own range of points.
    fn batch_law(&self, batches: &Batches, batch: usize) -> (&dyn contact_laws::TractionLaw, Range<usize>) {
        let (law, first, _) = batches.places[batch];
        let points = &batches.points[batch];
        (self.laws[law].1.as_ref(), points.start - first..points.end - first)
    }
}
