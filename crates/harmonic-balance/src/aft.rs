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

/// The contact along periodic motions about the static state.
pub(crate) struct Contact<'a, F: PointwiseForce> {
    force: &'a F,
    state: &'a F::State,
    sampling: Sampling,
    /// Samples of the first period that forces do without.
    skipped: usize,
    /// Value of each column's function at each sample, `[sample][column]`.
    basis: Vec<f64>,
    /// Jump (m) and traction (Pa) at the static state.
    jump: [Vec<f64>; 3],
    traction: [Vec<f64>; 3],
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

/// Memory of one batch.
struct Batch {
    jump: [Vec<f64>; 3],
    traction: [Vec<f64>; 3],
    begin: Vec<f64>,
    end: Vec<f64>,
}

impl Batch {
    fn new(n: usize, n_state: usize) -> Self {
        let zeros = || std::array::from_fn(|_| vec![0.0; n]);
        Self {
            jump: zeros(),
            traction: zeros(),
            begin: vec![0.0; n * n_state],
            end: vec![0.0; n * n_state],
        }
    }
}

/// Factors of real and imaginary part of a number in the real (0) or imaginary part (1) of its product with `factor`.
fn part_of_product(factor: Complex<f64>, part: usize) -> [f64; 2] {
    match part {
        0 => [factor.re, -factor.im],
        _ => [factor.im, factor.re],
    }
}

fn components_mut(fields: &mut [Vec<f64>; 3]) -> ComponentsMut<'_> {
    let [x, y, n] = fields;
    ComponentsMut { x, y, n }
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
        let mut contact = Self {
            force,
            state,
            sampling,
            skipped: 0,
            basis,
            jump,
            traction: std::array::from_fn(|_| vec![0.0; n]),
        };
        contact.traction = contact.static_traction();
        contact
    }

    /// Goes from the static state to the middle of the first period, where another one follows: forces that lead to a solution need no more.
    pub(crate) fn skip_half(mut self) -> Self {
        if self.sampling.periods > 1 {
            self.skipped = self.sampling.samples / 2;
        }
        self
    }

    fn static_traction(&self) -> [Vec<f64>; 3] {
        let mut all: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; self.force.n_points()]);
        for (index, range) in self.force.batches().iter().enumerate() {
            let n_state = self.force.n_state(index);
            let mut batch = Batch::new(range.len(), n_state);
            self.force.state_of(index, self.state, &mut batch.begin);
            for q in 0..3 {
                batch.jump[q].copy_from_slice(&self.jump[q][range.clone()]);
            }
            self.advance(index, &mut batch, None);
            for q in 0..3 {
                all[q][range.clone()].copy_from_slice(&batch.traction[q]);
            }
        }
        all
    }

    /// Evaluates a batch, whose end state becomes the begin state.
    fn advance(&self, index: usize, batch: &mut Batch, tangent: Option<TangentMut<'_>>) {
        let n = batch.jump[0].len();
        let [x, y, normal] = &batch.jump;
        self.force.evaluate_batch(
            index,
            Components { x, y, n: normal },
            StateView::new(&batch.begin, n, 0),
            StateViewMut::new(&mut batch.end, n, 0),
            components_mut(&mut batch.traction),
            tangent,
        );
        std::mem::swap(&mut batch.begin, &mut batch.end);
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
            .map(|(index, (range, jumps))| self.mean_of_batch(index, range, jumps))
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

    fn mean_of_batch(&self, index: usize, range: &Range<usize>, jumps: &[f64]) -> [Vec<f64>; 9] {
        let n = range.len();
        let mut batch = Batch::new(n, self.force.n_state(index));
        self.force.state_of(index, self.state, &mut batch.begin);
        let zeros = || -> [Vec<f64>; 9] { std::array::from_fn(|_| vec![0.0; n]) };
        let (mut sum, mut tangent) = (zeros(), zeros());
        for period in 1..=self.sampling.periods {
            for sample in 0..self.sampling.samples {
                self.place(jumps, sample, range, &mut batch);
                let entries = TangentMut::from_entries(tangent.each_mut().map(Vec::as_mut_slice));
                self.advance(index, &mut batch, Some(entries));
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
        let per_sample = 1.0 / self.sampling.samples as f64;
        sum.map(|values| values.into_iter().map(|v| per_sample * v).collect())
    }

    /// Brings the jumps of a batch to those of a sample.
    fn place(&self, jumps: &[f64], sample: usize, range: &Range<usize>, batch: &mut Batch) {
        self.synthesise(jumps, sample, &mut batch.jump);
        for (jump, at_rest) in batch.jump.iter_mut().zip(&self.jump) {
            for (jump, at_rest) in jump.iter_mut().zip(&at_rest[range.clone()]) {
                *jump += at_rest;
            }
        }
    }

    /// Coefficients of the jumps that belong to a motion, `[component][column][point]`, batch by batch.
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
            let mut coefficients = Vec::with_capacity(3 * columns * range.len());
            for q in 0..3 {
                for field in &fields {
                    coefficients.extend_from_slice(&field[q][range.clone()]);
                }
            }
            coefficients
        };
        self.force.batches().iter().map(of_batch).collect()
    }

    /// Values of a batch at a sample, from the coefficients.
    fn synthesise(&self, coefficients: &[f64], sample: usize, fields: &mut [Vec<f64>; 3]) {
        let columns = 2 * self.sampling.harmonics + 1;
        let basis = &self.basis[sample * columns..][..columns];
        let n = fields[0].len();
        for (field, coefficients) in fields.iter_mut().zip(coefficients.chunks_exact(columns * n)) {
            field.fill(0.0);
            for (factor, column) in basis.iter().zip(coefficients.chunks_exact(n)) {
                for (value, c) in field.iter_mut().zip(column) {
                    *value += factor * c;
                }
            }
        }
    }

    /// Adds what the fields at a sample bring to the coefficients of a Fourier series.
    fn analyse(&self, fields: &[Vec<f64>; 3], sample: usize, coefficients: &mut [f64]) {
        let columns = 2 * self.sampling.harmonics + 1;
        let basis = &self.basis[sample * columns..][..columns];
        let per_sample = 1.0 / self.sampling.samples as f64;
        let n = fields[0].len();
        for (field, coefficients) in fields.iter().zip(coefficients.chunks_exact_mut(columns * n)) {
            for (index, (value, column)) in basis.iter().zip(coefficients.chunks_exact_mut(n)).enumerate() {
                let factor = if index == 0 {
                    per_sample
                } else {
                    2.0 * per_sample * value
                };
                for (c, value) in column.iter_mut().zip(field) {
                    *c += factor * value;
                }
            }
        }
    }

    /// Harmonics of the forces of tractions given batch by batch, on `size` coordinates.
    fn collect(&self, of_batches: &[BatchResponse], size: usize) -> Harmonics {
        let columns = 2 * self.sampling.harmonics + 1;
        let n_points = self.force.n_points();
        let nd = self.force.n_dofs();
        let mut force = Harmonics::zeros(size, self.sampling.harmonics);
        force.each_column(|column, values| {
            let mut traction: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; n_points]);
            for (range, answer) in self.force.batches().iter().zip(of_batches) {
                let n = range.len();
                for (q, field) in traction.iter_mut().enumerate() {
                    let from = &answer.coefficients[(q * columns + column) * n..][..n];
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
        let columns = motion.n_columns();
        let mut flux: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; self.force.n_points()]);
        let answers = self.follow_all(&jumps);
        for ((range, jumps), answer) in self.force.batches().iter().zip(&jumps).zip(&answers) {
            let n = range.len();
            for (q, flux) in flux.iter_mut().enumerate() {
                for (i, flux) in flux[range.clone()].iter_mut().enumerate() {
                    let at = |values: &[f64], column: usize| values[(q * columns + column) * n + i];
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
                self.follow(index, range, jumps, &inside).histories
            })
            .map(|mut history| {
                // Batches follow tractions from the static state.
                for (traction, at_rest) in history.traction.iter_mut().zip(&self.traction) {
                    traction.iter_mut().for_each(|t| *t += at_rest[history.point]);
                }
                history
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
        let mut batch = Batch::new(n, self.force.n_state(index));
        self.force.state_of(index, self.state, &mut batch.begin);
        let mut coefficients = vec![0.0; jumps.len()];
        let empty = |&point: &usize| PointHistory {
            point,
            jump: Default::default(),
            traction: Default::default(),
        };
        let mut histories: Vec<PointHistory> = recorded.iter().map(empty).collect();
        let zeros = || -> [Vec<f64>; 3] { std::array::from_fn(|_| vec![0.0; n]) };
        let (mut before, mut least, mut most) = (zeros(), zeros(), zeros());
        for period in 1..=self.sampling.periods {
            let is_last = period == self.sampling.periods;
            if is_last {
                before.clone_from(&batch.traction);
                least.iter_mut().for_each(|field| field.fill(f64::INFINITY));
                most.iter_mut().for_each(|field| field.fill(f64::NEG_INFINITY));
            }
            let skipped = if period == 1 { self.skipped } else { 0 };
            for sample in skipped..self.sampling.samples {
                self.place(jumps, sample, range, &mut batch);
                self.advance(index, &mut batch, None);
                for (traction, at_rest) in batch.traction.iter_mut().zip(&self.traction) {
                    for (traction, at_rest) in traction.iter_mut().zip(&at_rest[range.clone()]) {
                        *traction -= at_rest;
                    }
                }
                if is_last {
                    self.analyse(&batch.traction, sample, &mut coefficients);
                    for history in &mut histories {
                        let at = history.point - range.start;
                        for q in 0..3 {
                            history.jump[q].push(batch.jump[q][at]);
                            history.traction[q].push(batch.traction[q][at]);
                        }
                    }
                    for q in 0..3 {
                        for i in 0..n {
                            least[q][i] = least[q][i].min(batch.traction[q][i]);
                            most[q][i] = most[q][i].max(batch.traction[q][i]);
                        }
                    }
                }
            }
        }
        let mut drift = [0.0; 2];
        let weights = &self.force.weights()[range.clone()];
        for q in 0..3 {
            for (i, weight) in weights.iter().enumerate() {
                drift[0] += weight * (batch.traction[q][i] - before[q][i]).abs();
                drift[1] += weight * (most[q][i] - least[q][i]);
            }
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
        let answers: Vec<BatchResponse> = self
            .force
            .batches()
            .par_iter()
            .zip(jumps.par_iter().zip(&changes))
            .enumerate()
            .map(|(index, (range, (jumps, changes)))| self.follow_change(index, range, jumps, changes))
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
        let answers: Vec<[BatchResponse; 2]> = self
            .force
            .batches()
            .par_iter()
            .enumerate()
            .map(|(index, range)| {
                let changes = changes.each_ref().map(|part| part[index].as_slice());
                self.follow_growth(index, range, &jumps[index], changes, growth)
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
            .map(|(index, (range, jumps))| self.follow_parameter(index, range, jumps, rate, &at_rest))
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
        range: &Range<usize>,
        jumps: &[f64],
        rate: &ParameterRate<'_, F>,
        at_rest: &[Vec<f64>; 3],
    ) -> BatchResponse
    where
        F: DifferentiablePointwiseForce,
    {
        let mut change = Batch::new(range.len(), self.force.n_state(index));
        self.force.state_of(index, &rate.state.state, &mut change.begin);
        let place = |_, jump: &mut [Vec<f64>; 3]| {
            for (jump, at_rest) in jump.iter_mut().zip(at_rest) {
                jump.copy_from_slice(&at_rest[range.clone()]);
            }
        };
        match rate.change.force {
            None => self.follow_along(index, range, jumps, change, place, |batch, change| {
                self.differentiate(index, batch, change);
            }),
            Some(parameter) => self.follow_along(index, range, jumps, change, place, |batch, change| {
                let n = batch.jump[0].len();
                let [x, y, normal] = &batch.jump;
                self.force.parameter_batch(
                    index,
                    parameter,
                    Components { x, y, n: normal },
                    StateView::new(&batch.begin, n, 0),
                    components_mut(&mut change.jump),
                    &mut change.begin,
                    StateViewMut::new(&mut batch.end, n, 0),
                    StateViewMut::new(&mut change.end, n, 0),
                    components_mut(&mut batch.traction),
                    components_mut(&mut change.traction),
                );
            }),
        }
    }

    /// Derivative of one batch along what grows by `exp(growth)` per period, without that growth.
    fn follow_growth(
        &self,
        index: usize,
        range: &Range<usize>,
        jumps: &[f64],
        changes: [&[f64]; 2],
        growth: Complex<f64>,
    ) -> [BatchResponse; 2] {
        let n = range.len();
        let n_state = self.force.n_state(index);
        let mut batch = Batch::new(n, n_state);
        self.force.state_of(index, self.state, &mut batch.begin);
        // Without the imaginary part there is one real motion, and not two.
        let is_real = growth.im == 0.0 && changes[1].iter().all(|value| *value == 0.0);
        let mut grown: Vec<Batch> = (0..if is_real { 1 } else { 2 })
            .map(|_| Batch::new(n, n_state))
            .collect();
        let mut own = changes.map(|_| Batch::new(n, 0).jump);
        let mut coefficients = [vec![0.0; jumps.len()], vec![0.0; jumps.len()]];
        let Sampling { samples, periods, .. } = self.sampling;
        for period in 1..=periods {
            for sample in 0..samples {
                self.place(jumps, sample, range, &mut batch);
                for (own, changes) in own.iter_mut().zip(changes) {
                    self.synthesise(changes, sample, own);
                }
                let time = period as f64 - periods as f64 + sample as f64 / samples as f64;
                let factor = (growth * time).exp();
                for (part, change) in grown.iter_mut().enumerate() {
                    let [a, b] = part_of_product(factor, part);
                    for (q, jump) in change.jump.iter_mut().enumerate() {
                        for (jump, (re, im)) in jump.iter_mut().zip(own[0][q].iter().zip(&own[1][q])) {
                            *jump = a * re + b * im;
                        }
                    }
                    self.differentiate(index, &mut batch, change);
                    std::mem::swap(&mut change.begin, &mut change.end);
                }
                std::mem::swap(&mut batch.begin, &mut batch.end);
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
                    for (q, values) in own.iter_mut().enumerate() {
                        for (i, value) in values.iter_mut().enumerate() {
                            *value = a * re[q][i] + im.map_or(0.0, |im| b * im[q][i]);
                        }
                    }
                    self.analyse(own, sample, &mut coefficients[part]);
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
    fn follow_change(&self, index: usize, range: &Range<usize>, jumps: &[f64], changes: &[f64]) -> BatchResponse {
        let change = Batch::new(range.len(), self.force.n_state(index));
        let place = |sample, jump: &mut [Vec<f64>; 3]| self.synthesise(changes, sample, jump);
        self.follow_along(index, range, jumps, change, place, |batch, change| {
            self.differentiate(index, batch, change);
        })
    }

    /// Derivative of one batch along all periods, from the change of its history in `change`. `place` brings the change of the jumps to that of a
    /// sample, and `differentiate` evaluates both.
    fn follow_along(
        &self,
        index: usize,
        range: &Range<usize>,
        jumps: &[f64],
        mut change: Batch,
        place: impl Fn(usize, &mut [Vec<f64>; 3]),
        differentiate: impl Fn(&mut Batch, &mut Batch),
    ) -> BatchResponse {
        let mut batch = Batch::new(range.len(), self.force.n_state(index));
        self.force.state_of(index, self.state, &mut batch.begin);
        let mut coefficients = vec![0.0; jumps.len()];
        for period in 1..=self.sampling.periods {
            for sample in 0..self.sampling.samples {
                self.place(jumps, sample, range, &mut batch);
                place(sample, &mut change.jump);
                differentiate(&mut batch, &mut change);
                std::mem::swap(&mut batch.begin, &mut batch.end);
                std::mem::swap(&mut change.begin, &mut change.end);
                if period == self.sampling.periods {
                    self.analyse(&change.traction, sample, &mut coefficients);
                }
            }
        }
        BatchResponse {
            coefficients,
            histories: Vec::new(),
            drift: [0.0; 2],
        }
    }

    /// Evaluates a batch and its change.
    fn differentiate(&self, index: usize, batch: &mut Batch, change: &mut Batch) {
        let n = batch.jump[0].len();
        let ([x, y, normal], [d_x, d_y, d_n]) = (&batch.jump, &change.jump);
        self.force.derivative_batch(
            index,
            Components { x, y, n: normal },
            StateView::new(&batch.begin, n, 0),
            Components { x: d_x, y: d_y, n: d_n },
            StateView::new(&change.begin, n, 0),
            StateViewMut::new(&mut batch.end, n, 0),
            StateViewMut::new(&mut change.end, n, 0),
            components_mut(&mut batch.traction),
            components_mut(&mut change.traction),
        );
    }
}
