//! Alternating frequency and time: the harmonics of the contact forces along a periodic motion, and their derivative.
//!
//! A motion given by its harmonics is sampled `N` times per period at every point. The law is evaluated from sample to sample, each
//! with the history that the one before left, for a number of periods; the harmonics of the tractions over the last period are the
//! answer. The first period leads from the static state onto the motion; with laws that repeat after that, the second is periodic.
//!
//! The derivative along a change of the motion goes along the same samples, with the derivative of the law's update, so that it is that
//! of the sampled problem to rounding: Newton's method converges as it would with the whole Jacobian, which is never formed.

use crate::force::{DifferentiablePointwiseForce, PointwiseForce};
use crate::harmonics::Harmonics;
use contact_laws::{Components, ComponentsMut, StateView, StateViewMut, TangentMut};
use cqsma_solver::sensitivity::ParameterRate;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::Complex;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// How motions are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sampling {
    /// The highest harmonic.
    pub harmonics: usize,
    /// Samples per period.
    pub samples: usize,
    /// Periods that the history is followed for; the last one is measured.
    pub periods: usize,
}

/// Samples that are followed together.
const STRETCH: usize = 32;

impl Sampling {
    /// Stretches of the samples of a period from one on.
    fn stretches(self, from: usize) -> impl Iterator<Item = Range<usize>> {
        (from..self.samples)
            .step_by(STRETCH)
            .map(move |first| first..self.samples.min(first + STRETCH))
    }
}

/// The contact along periodic motions about the static state.
pub(crate) struct Contact<'a, F: PointwiseForce> {
    force: &'a F,
    state: &'a F::State,
    sampling: Sampling,
    /// Samples of the first period that forces do without.
    skipped: usize,
    /// Value of each column's function at each sample, `[sample][column]`, and what it adds of a sample to the coefficient.
    basis: Vec<f64>,
    weights: Vec<f64>,
    /// Jump (m) and traction (Pa) of each batch at the static state, `[component][point]`.
    jump: Vec<Vec<f64>>,
    traction: Vec<Vec<f64>>,
}

/// A point of the contact over one period, sample by sample, beginning with the first sample.
#[derive(Clone, Debug, PartialEq)]
pub struct PointHistory {
    /// The point.
    pub point: usize,
    /// Jump along x, y and interference, gap subtracted (m).
    pub jump: [Vec<f64>; 3],
    /// Traction along x, y and n (Pa).
    pub traction: [Vec<f64>; 3],
}

/// What a batch of points answers.
struct BatchResponse {
    /// Harmonics of the tractions, `[component][column][point]`.
    coefficients: Vec<f64>,
    /// Of the points asked for, the traction from the static state.
    histories: Vec<PointHistory>,
    /// Change of the tractions from the begin of the last period to its end, and their range in it: sums of magnitudes times areas (N).
    drift: [f64; 2],
}

/// Memory of one batch along a stretch.
struct Batch {
    n: usize,
    /// `[step][component][point]`, as are the tractions.
    jump: Vec<f64>,
    traction: Vec<f64>,
    begin: Vec<f64>,
    end: Vec<f64>,
}

impl Batch {
    fn new(n: usize, n_state: usize) -> Self {
        let fields = || vec![0.0; STRETCH * 3 * n];
        Self {
            n,
            jump: fields(),
            traction: fields(),
            begin: vec![0.0; n * n_state],
            end: vec![0.0; n * n_state],
        }
    }

    /// Numbers of some steps.
    fn steps(&self, steps: Range<usize>) -> Range<usize> {
        3 * self.n * steps.start..3 * self.n * steps.end
    }

    /// The begin state becomes the end state.
    fn commit(&mut self) {
        std::mem::swap(&mut self.begin, &mut self.end);
    }
}

/// Factors of real and imaginary part of a number in the real (0) or imaginary part (1) of its product with `factor`.
fn part_of_product(factor: Complex<f64>, part: usize) -> [f64; 2] {
    match part {
        0 => [factor.re, -factor.im],
        _ => [factor.im, factor.re],
    }
}

/// Harmonics of the contact forces.
pub(crate) struct Forces {
    /// Contact force less that of the static state (N), over the leading coordinates and zero on the others.
    pub(crate) force: Harmonics,
    /// Change of the tractions over the last period relative to their range: zero where the history repeats.
    pub(crate) drift: f64,
}

impl<'a, F: PointwiseForce> Contact<'a, F> {
    /// About the static state with the displacements `displacement` (m) and the history `state`.
    pub(crate) fn new(force: &'a F, displacement: &[f64], state: &'a F::State, sampling: Sampling) -> Self {
        let n = force.n_points();
        let mut jump: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; n]);
        force.jumps(&displacement[..force.n_dofs()], jump.each_mut().map(Vec::as_mut_slice));
        force.subtract_gap(&mut jump[2]);
        let columns = 2 * sampling.harmonics + 1;
        let mut basis = vec![1.0; sampling.samples * columns];
        for (sample, row) in basis.chunks_exact_mut(columns).enumerate() {
            for h in 1..=sampling.harmonics {
                // The product is reduced before it is divided, so that equal phases give equal bits.
                let phase = TAU * ((sample * h) % sampling.samples) as f64 / sampling.samples as f64;
                (row[2 * h], row[2 * h - 1]) = phase.sin_cos();
            }
        }
        let per_sample = 1.0 / sampling.samples as f64;
        let weigh = |(at, value): (usize, &f64)| {
            if at % columns == 0 {
                per_sample
            } else {
                2.0 * per_sample * value
            }
        };
        let weights = basis.iter().enumerate().map(weigh).collect();
        let jump: Vec<Vec<f64>> = force.batches().iter().map(|range| stacked(&jump, range)).collect();
        let traction = jump.iter().enumerate().map(|(index, jump)| {
            let mut begin = vec![0.0; force.n_state(index) * (jump.len() / 3)];
            force.state_of(index, state, &mut begin);
            let (mut end, mut traction) = (begin.clone(), vec![0.0; jump.len()]);
            force.follow_batch(index, jump, &mut begin, &mut end, &mut traction);
            traction
        });
        Self {
            force,
            state,
            sampling,
            skipped: 0,
            basis,
            weights,
            traction: traction.collect(),
            jump,
        }
    }

    /// Goes from the static state to the middle of the first period, where another one follows: forces that lead to a solution need no more.
    pub(crate) fn skip_half(mut self) -> Self {
        if self.sampling.periods > 1 {
            self.skipped = self.sampling.samples / 2;
        }
        self
    }

    /// Evaluates a step of a batch, whose end state becomes the begin state.
    fn advance(&self, index: usize, batch: &mut Batch, step: usize, tangent: Option<TangentMut<'_>>) {
        let (n, own) = (batch.n, batch.steps(step..step + 1));
        self.force.evaluate_batch(
            index,
            Components::stacked(&batch.jump[own.clone()]),
            StateView::new(&batch.begin, n, 0),
            StateViewMut::new(&mut batch.end, n, 0),
            ComponentsMut::stacked(&mut batch.traction[own]),
            tangent,
        );
        batch.commit();
    }

    /// Means over the measured period of what the tangents along and across the surface are, without what couples the two: symmetric
    /// and not negative. Values over the pattern of the force.
    pub(crate) fn mean_tangent(&self, motion: &Harmonics) -> Vec<f64> {
        let jumps = self.jumps(motion);
        let means: Vec<[Vec<f64>; 9]> = self
            .force
            .batches()
            .par_iter()
            .zip(&jumps)
            .enumerate()
            .map(|(index, (range, jumps))| self.mean_of_batch(index, range.len(), jumps))
            .collect();
        let mut all: [Vec<f64>; 9] = std::array::from_fn(|_| vec![0.0; self.force.n_points()]);
        for (range, means) in self.force.batches().iter().zip(means) {
            for (all, mean) in all.iter_mut().zip(means) {
                all[range.clone()].copy_from_slice(&mean);
            }
        }
        let mut values = vec![0.0; self.force.pattern().indices.len()];
        self.force
            .assemble_tangent(all.each_ref().map(Vec::as_slice), &mut values);
        values
    }

    fn mean_of_batch(&self, index: usize, n: usize, jumps: &[f64]) -> [Vec<f64>; 9] {
        let mut batch = self.begin(index, n);
        let zeros = || -> [Vec<f64>; 9] { std::array::from_fn(|_| vec![0.0; n]) };
        let (mut sum, mut tangent) = (zeros(), zeros());
        for period in 1..=self.sampling.periods {
            for samples in self.sampling.stretches(0) {
                self.place(index, jumps, &samples, &mut batch);
                for step in 0..samples.len() {
                    let entries = TangentMut::from_entries(tangent.each_mut().map(Vec::as_mut_slice));
                    self.advance(index, &mut batch, step, Some(entries));
                    if period < self.sampling.periods {
                        continue;
                    }
                    for i in 0..n {
                        sum[0][i] += tangent[0][i];
                        sum[4][i] += tangent[4][i];
                        sum[8][i] += tangent[8][i].max(0.0);
                        let across = 0.5 * (tangent[1][i] + tangent[3][i]);
                        sum[1][i] += across;
                        sum[3][i] += across;
                    }
                }
            }
        }
        let per_sample = 1.0 / self.sampling.samples as f64;
        sum.map(|values| values.into_iter().map(|v| per_sample * v).collect())
    }

    /// A batch of `n` points at the static state.
    fn begin(&self, index: usize, n: usize) -> Batch {
        let mut batch = Batch::new(n, self.force.n_state(index));
        self.force.state_of(index, self.state, &mut batch.begin);
        batch
    }

    /// Brings the jumps of a batch to those of a stretch.
    fn place(&self, index: usize, jumps: &[f64], samples: &Range<usize>, batch: &mut Batch) {
        let stretch = batch.steps(0..samples.len());
        let steps = &mut batch.jump[stretch];
        for step in steps.chunks_exact_mut(3 * batch.n) {
            step.copy_from_slice(&self.jump[index]);
        }
        self.synthesise(Accum::Add, jumps, samples, steps);
    }

    /// Coefficients of the jumps that belong to a motion, `[column][component][point]`, batch by batch.
    fn jumps(&self, motion: &Harmonics) -> Vec<Vec<f64>> {
        let (n, nd, columns) = (self.force.n_points(), self.force.n_dofs(), motion.n_columns());
        let fields: Vec<[Vec<f64>; 3]> = (0..columns)
            .into_par_iter()
            .map(|column| {
                let mut jump: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; n]);
                self.force
                    .jumps(&motion.column(column)[..nd], jump.each_mut().map(Vec::as_mut_slice));
                jump
            })
            .collect();
        let of_batch = |range: &Range<usize>| {
            let columns = fields.iter().flat_map(|field| stacked(field, range));
            columns.collect()
        };
        self.force.batches().iter().map(of_batch).collect()
    }

    /// Values of a batch along a stretch, from the coefficients: in the place of what is there, or added to it.
    fn synthesise(&self, accum: Accum, coefficients: &[f64], samples: &Range<usize>, steps: &mut [f64]) {
        let columns = 2 * self.sampling.harmonics + 1;
        let basis = &self.basis[samples.start * columns..samples.end * columns];
        let size = steps.len() / samples.len();
        let steps = MatMut::from_column_major_slice_mut(steps, size, samples.len());
        let coefficients = MatRef::from_column_major_slice(coefficients, size, columns);
        let basis = MatRef::from_column_major_slice(basis, columns, samples.len());
        matmul(steps, accum, coefficients, basis, 1.0, Par::Seq);
    }

    /// Adds what the values of a batch along a stretch bring to the coefficients of a Fourier series.
    fn analyse(&self, steps: &[f64], samples: &Range<usize>, coefficients: &mut [f64]) {
        let columns = 2 * self.sampling.harmonics + 1;
        let weights = &self.weights[samples.start * columns..samples.end * columns];
        let size = steps.len() / samples.len();
        let steps = MatRef::from_column_major_slice(steps, size, samples.len());
        let weights = MatRef::from_row_major_slice(weights, samples.len(), columns);
        let coefficients = MatMut::from_column_major_slice_mut(coefficients, size, columns);
        matmul(coefficients, Accum::Add, steps, weights, 1.0, Par::Seq);
    }

    /// Harmonics of the forces of tractions given batch by batch, on `size` coordinates.
    fn collect(&self, of_batches: &[BatchResponse], size: usize) -> Harmonics {
        let n_points = self.force.n_points();
        let nd = self.force.n_dofs();
        let mut force = Harmonics::zeros(size, self.sampling.harmonics);
        force.each_column(|column, values| {
            let mut traction: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; n_points]);
            for (range, answer) in self.force.batches().iter().zip(of_batches) {
                let n = range.len();
                for (q, field) in traction.iter_mut().enumerate() {
                    let from = &answer.coefficients[(column * 3 + q) * n..][..n];
                    field[range.clone()].copy_from_slice(from);
                }
            }
            self.force
                .forces(traction.each_ref().map(Vec::as_slice), &mut values[..nd]);
        });
        force
    }

    /// Contact forces along the motion.
    pub(crate) fn forces(&self, motion: &Harmonics) -> Forces {
        let jumps = self.jumps(motion);
        let answers = self.follow_all(&jumps);
        let [drift, extent] = answers.iter().fold([0.0; 2], |sum, answer| {
            [sum[0] + answer.drift[0], sum[1] + answer.drift[1]]
        });
        Forces {
            force: self.collect(&answers, motion.size()),
            drift: if extent > 0.0 { drift / extent } else { 0.0 },
        }
    }

    /// Energy per area that each point takes per period, by its tractions along x, y and n (J/m^2).
    pub(crate) fn dissipation(&self, motion: &Harmonics) -> [Vec<f64>; 3] {
        let jumps = self.jumps(motion);
        let mut flux: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; self.force.n_points()]);
        let answers = self.follow_all(&jumps);
        for ((range, jumps), answer) in self.force.batches().iter().zip(&jumps).zip(&answers) {
            let n = range.len();
            for (q, flux) in flux.iter_mut().enumerate() {
                for (i, flux) in flux[range.clone()].iter_mut().enumerate() {
                    let at = |values: &[f64], column: usize| values[(column * 3 + q) * n + i];
                    *flux = (1..=motion.count())
                        .map(|h| {
                            let t = |column| at(&answer.coefficients, column);
                            let u = |column| at(jumps, column);
                            PI * h as f64 * (t(2 * h - 1) * u(2 * h) - t(2 * h) * u(2 * h - 1))
                        })
                        .sum();
                }
            }
        }
        flux
    }

    /// Histories of some points over the measured period.
    pub(crate) fn histories(&self, motion: &Harmonics, points: &[usize]) -> Vec<PointHistory> {
        let jumps = self.jumps(motion);
        let batches = self.force.batches().iter().zip(&jumps).enumerate();
        batches
            .flat_map(|(index, (range, jumps))| {
                let inside: Vec<usize> = points.iter().copied().filter(|p| range.contains(p)).collect();
                if inside.is_empty() {
                    return Vec::new();
                }
                let mut histories = self.follow(index, range, jumps, &inside).histories;
                for history in &mut histories {
                    // Batches follow tractions from the static state.
                    let at_rest = self.traction[index].chunks_exact(range.len());
                    for (traction, at_rest) in history.traction.iter_mut().zip(at_rest) {
                        traction
                            .iter_mut()
                            .for_each(|t| *t += at_rest[history.point - range.start]);
                    }
                }
                histories
            })
            .collect()
    }

    /// All batches along all periods.
    fn follow_all(&self, jumps: &[Vec<f64>]) -> Vec<BatchResponse> {
        let batches = self.force.batches().par_iter().zip(jumps).enumerate();
        batches
            .map(|(index, (range, jumps))| self.follow(index, range, jumps, &[]))
            .collect()
    }

    /// One batch along all periods; `recorded` are points of it whose last period is kept.
    fn follow(&self, index: usize, range: &Range<usize>, jumps: &[f64], recorded: &[usize]) -> BatchResponse {
        let n = range.len();
        let mut batch = self.begin(index, n);
        let mut coefficients = vec![0.0; jumps.len()];
        let empty = |&point: &usize| PointHistory {
            point,
            jump: Default::default(),
            traction: Default::default(),
        };
        let mut histories: Vec<PointHistory> = recorded.iter().map(empty).collect();
        let [mut before, mut last] = [0; 2].map(|_| vec![0.0; 3 * n]);
        let (mut least, mut most) = (vec![f64::INFINITY; 3 * n], vec![f64::NEG_INFINITY; 3 * n]);
        for period in 1..=self.sampling.periods {
            before.clone_from(&last);
            let skipped = if period == 1 { self.skipped } else { 0 };
            for samples in self.sampling.stretches(skipped) {
                self.place(index, jumps, &samples, &mut batch);
                let stretch = batch.steps(0..samples.len());
                let (steps, tractions) = (&batch.jump[stretch.clone()], &mut batch.traction[stretch]);
                self.force
                    .follow_batch(index, steps, &mut batch.begin, &mut batch.end, tractions);
                for traction in tractions.chunks_exact_mut(3 * n) {
                    for (traction, at_rest) in traction.iter_mut().zip(&self.traction[index]) {
                        *traction -= at_rest;
                    }
                    last.copy_from_slice(traction);
                }
                if period < self.sampling.periods {
                    continue;
                }
                self.analyse(tractions, &samples, &mut coefficients);
                for (jump, traction) in steps.chunks_exact(3 * n).zip(tractions.chunks_exact(3 * n)) {
                    for history in &mut histories {
                        let at = history.point - range.start;
                        for q in 0..3 {
                            history.jump[q].push(jump[q * n + at]);
                            history.traction[q].push(traction[q * n + at]);
                        }
                    }
                    for ((least, most), traction) in least.iter_mut().zip(&mut most).zip(traction) {
                        *least = least.min(*traction);
                        *most = most.max(*traction);
                    }
                }
            }
        }
        let mut drift = [0.0; 2];
        let weights = self.force.weights()[range.clone()].iter().cycle();
        for (i, weight) in (0..3 * n).zip(weights) {
            drift[0] += weight * (last[i] - before[i]).abs();
            drift[1] += weight * (most[i] - least[i]);
        }
        BatchResponse {
            coefficients,
            histories,
            drift,
        }
    }

    /// Derivative of the contact forces at `motion` along `change`.
    pub(crate) fn derivative(&self, motion: &Harmonics, change: &Harmonics) -> Harmonics {
        let (jumps, changes) = (self.jumps(motion), self.jumps(change));
        let answers: Vec<BatchResponse> = jumps
            .par_iter()
            .zip(&changes)
            .enumerate()
            .map(|(index, (jumps, changes))| self.follow_change(index, jumps, changes))
            .collect();
        self.collect(&answers, motion.size())
    }

    /// `exp(-growth t)` times the change of the contact forces at `motion` along `exp(growth t) change(t)`, with the time `t` in periods; real and
    /// imaginary part.
    pub(crate) fn growing_derivative(
        &self,
        motion: &Harmonics,
        change: [&Harmonics; 2],
        growth: Complex<f64>,
    ) -> [Harmonics; 2] {
        let jumps = self.jumps(motion);
        let changes = change.map(|part| self.jumps(part));
        let answers: Vec<[BatchResponse; 2]> = jumps
            .par_iter()
            .enumerate()
            .map(|(index, jumps)| {
                let changes = changes.each_ref().map(|part| part[index].as_slice());
                self.follow_growth(index, jumps, changes, growth)
            })
            .collect();
        let (re, im): (Vec<_>, Vec<_>) = answers.into_iter().map(|[re, im]| (re, im)).unzip();
        [re, im].map(|part| self.collect(&part, motion.size()))
    }

    /// Change of the contact forces at `motion` with a parameter, per unit of it, from that of the static state.
    pub(crate) fn parameter_change(&self, motion: &Harmonics, rate: &ParameterRate<'_, F>) -> Harmonics
    where
        F: DifferentiablePointwiseForce,
    {
        let jumps = self.jumps(motion);
        let mut at_rest: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; self.force.n_points()]);
        self.force
            .jumps(&rate.state.displacement, at_rest.each_mut().map(Vec::as_mut_slice));
        let answers: Vec<BatchResponse> = self
            .force
            .batches()
            .par_iter()
            .zip(&jumps)
            .enumerate()
            .map(|(index, (range, jumps))| self.follow_parameter(index, jumps, rate, &stacked(&at_rest, range)))
            .collect();
        let mut change = self.collect(&answers, motion.size());
        let mean = change.column_mut(0).iter_mut();
        mean.zip(&rate.reference).for_each(|(change, own)| *change -= own);
        change
    }

    /// The same of the tractions of one batch.
    fn follow_parameter(
        &self,
        index: usize,
        jumps: &[f64],
        rate: &ParameterRate<'_, F>,
        at_rest: &[f64],
    ) -> BatchResponse
    where
        F: DifferentiablePointwiseForce,
    {
        let mut change = Batch::new(at_rest.len() / 3, self.force.n_state(index));
        self.force.state_of(index, &rate.state.state, &mut change.begin);
        let place = |_: &_, steps: &mut [f64]| {
            for step in steps.chunks_exact_mut(at_rest.len()) {
                step.copy_from_slice(at_rest);
            }
        };
        match rate.change.force {
            None => self.follow_along(index, jumps, change, place, |batch, change, step| {
                self.differentiate(index, batch, change, step);
            }),
            Some(parameter) => self.follow_along(index, jumps, change, place, |batch, change, step| {
                let (n, own) = (batch.n, batch.steps(step..step + 1));
                self.force.parameter_batch(
                    index,
                    parameter,
                    Components::stacked(&batch.jump[own.clone()]),
                    StateView::new(&batch.begin, n, 0),
                    ComponentsMut::stacked(&mut change.jump[own.clone()]),
                    &mut change.begin,
                    StateViewMut::new(&mut batch.end, n, 0),
                    StateViewMut::new(&mut change.end, n, 0),
                    ComponentsMut::stacked(&mut batch.traction[own.clone()]),
                    ComponentsMut::stacked(&mut change.traction[own]),
                );
            }),
        }
    }

    /// Derivative of one batch along what grows by `exp(growth)` per period, without that growth.
    fn follow_growth(
        &self,
        index: usize,
        jumps: &[f64],
        changes: [&[f64]; 2],
        growth: Complex<f64>,
    ) -> [BatchResponse; 2] {
        let n = self.jump[index].len() / 3;
        let mut batch = self.begin(index, n);
        // Without the imaginary part there is one real motion, and not two.
        let is_real = growth.im == 0.0 && changes[1].iter().all(|value| *value == 0.0);
        let mut grown: Vec<Batch> = (0..if is_real { 1 } else { 2 })
            .map(|_| Batch::new(n, self.force.n_state(index)))
            .collect();
        let mut own = changes.map(|_| Batch::new(n, 0).jump);
        let mut coefficients = [vec![0.0; jumps.len()], vec![0.0; jumps.len()]];
        let Sampling { samples, periods, .. } = self.sampling;
        for period in 1..=periods {
            for stretch in self.sampling.stretches(0) {
                let whole = batch.steps(0..stretch.len());
                self.place(index, jumps, &stretch, &mut batch);
                for (own, changes) in own.iter_mut().zip(changes) {
                    self.synthesise(Accum::Replace, changes, &stretch, &mut own[whole.clone()]);
                }
                for (step, sample) in stretch.clone().enumerate() {
                    let time = period as f64 - periods as f64 + sample as f64 / samples as f64;
                    let factor = (growth * time).exp();
                    let at = batch.steps(step..step + 1);
                    for (part, change) in grown.iter_mut().enumerate() {
                        let [a, b] = part_of_product(factor, part);
                        let parts = own[0][at.clone()].iter().zip(&own[1][at.clone()]);
                        for (jump, (re, im)) in change.jump[at.clone()].iter_mut().zip(parts) {
                            *jump = a * re + b * im;
                        }
                        self.differentiate(index, &mut batch, change, step);
                        change.commit();
                    }
                    batch.commit();
                    if period < periods {
                        continue;
                    }
                    let factor = (-growth * time).exp();
                    let mut tractions = grown.iter().map(|change| &change.traction);
                    let (Some(re), im) = (tractions.next(), tractions.next()) else {
                        continue;
                    };
                    for (part, own) in own.iter_mut().enumerate() {
                        let [a, b] = part_of_product(factor, part);
                        for i in at.clone() {
                            own[i] = a * re[i] + im.map_or(0.0, |im| b * im[i]);
                        }
                    }
                }
                if period == periods {
                    for (own, coefficients) in own.iter().zip(&mut coefficients) {
                        self.analyse(&own[whole.clone()], &stretch, coefficients);
                    }
                }
            }
        }
        coefficients.map(|coefficients| BatchResponse {
            coefficients,
            histories: Vec::new(),
            drift: [0.0; 2],
        })
    }

    /// Derivative of one batch along all periods. The static state does not change.
    fn follow_change(&self, index: usize, jumps: &[f64], changes: &[f64]) -> BatchResponse {
        let change = Batch::new(self.jump[index].len() / 3, self.force.n_state(index));
        let place = |samples: &_, steps: &mut [f64]| self.synthesise(Accum::Replace, changes, samples, steps);
        self.follow_along(index, jumps, change, place, |batch, change, step| {
            self.differentiate(index, batch, change, step);
        })
    }

    /// Derivative of one batch along all periods, from the change of its history in `change`. `place` brings the changes of the jumps to those of a
    /// stretch, and `differentiate` evaluates both at a step.
    fn follow_along(
        &self,
        index: usize,
        jumps: &[f64],
        mut change: Batch,
        place: impl Fn(&Range<usize>, &mut [f64]),
        differentiate: impl Fn(&mut Batch, &mut Batch, usize),
    ) -> BatchResponse {
        let mut batch = self.begin(index, change.n);
        let mut coefficients = vec![0.0; jumps.len()];
        for period in 1..=self.sampling.periods {
            for samples in self.sampling.stretches(0) {
                let whole = batch.steps(0..samples.len());
                self.place(index, jumps, &samples, &mut batch);
                place(&samples, &mut change.jump[whole.clone()]);
                for step in 0..samples.len() {
                    differentiate(&mut batch, &mut change, step);
                    batch.commit();
                    change.commit();
                }
                if period == self.sampling.periods {
                    self.analyse(&change.traction[whole], &samples, &mut coefficients);
                }
            }
        }
        BatchResponse {
            coefficients,
            histories: Vec::new(),
            drift: [0.0; 2],
        }
    }

    /// Evaluates a step of a batch and its change.
    fn differentiate(&self, index: usize, batch: &mut Batch, change: &mut Batch, step: usize) {
        let (n, own) = (batch.n, batch.steps(step..step + 1));
        self.force.derivative_batch(
            index,
            Components::stacked(&batch.jump[own.clone()]),
            StateView::new(&batch.begin, n, 0),
            Components::stacked(&change.jump[own.clone()]),
            StateView::new(&change.begin, n, 0),
            StateViewMut::new(&mut batch.end, n, 0),
            StateViewMut::new(&mut change.end, n, 0),
            ComponentsMut::stacked(&mut batch.traction[own.clone()]),
            ComponentsMut::stacked(&mut change.traction[own]),
        );
    }
}

/// The fields of some points one after the other.
fn stacked(fields: &[Vec<f64>; 3], points: &Range<usize>) -> Vec<f64> {
    fields
        .iter()
        .flat_map(|field| &field[points.clone()])
        .copied()
        .collect()
}
