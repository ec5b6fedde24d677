//! The equations of harmonic balance: residual, product with the Jacobian, preconditioner.
//!
//! With the harmonics `V_h = C_h - i S_h` of the motion `v(t) = u(t) - u*` about the static state, those `G_h` of the contact force
//! from that state, and the stuck structure `P = K + T`, the residual of harmonic `h` is
//!
//! `R_h = P V_h + (G_h - T V_h) - (h^2 a + i h b) M V_h + i h sqrt(a) C V_h - E_h`, `a = omega^2`.
//!
//! `b = 2 zeta omega^2` is the negative damping that sustains a free periodic motion (Krack 2015, DOI
//! 10.1016/j.compstruc.2015.03.008), `C = sum_k 2 beta omega_k M phi_k phi_k^T M + c_m M + c_k K` the viscous damping of a forced one, and
//! `E_1` its force; with dampers `d`, `sum d d^T` belongs to `C` too.
//!
//! # Linear solves
//! `P^-1` is at hand as a matrix. Of the dynamic stiffness of the stuck structure, `P - (h^2 a + i h b) M`, it misses the inertia, which
//! matters in the lowest modes alone; there it is put in,
//!
//! `N_h^-1 = P^-1 + sum_k phi_k (1 / d_kh - 1 / lambda_k) phi_k^T`, `d_kh = lambda_k - h^2 a - i h b`,
//!
//! so that a step of the iteration costs products with `P^-1` and `M` for each harmonic, and one derivative of the contact forces.
//! Residuals are measured in the energy norm `sqrt(sum_h R_h^T P^-1 R_h)`.

use crate::aft::{Contact, Forces, Sampling};
use crate::force::{DifferentiablePointwiseForce, PointwiseForce};
use crate::harmonics::{Harmonics, add_rotated};
use crate::load::Load;
use cqsma_solver::Linearisation;
use cqsma_solver::sensitivity::{ParameterRate, add_product};
use dense_algebra::{Inverse, Packed, Vector, dot};
use faer::Mat;
use nalgebra::Complex;
use std::f64::consts::PI;

/// Denominators of modes closer to resonance than this, relative to their eigenvalue, are kept away from zero.
const CLOSEST: f64 = 1e-3;

/// A periodic motion with what it was found with.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unknown {
    /// Displacements from the static state.
    pub(crate) v: Harmonics,
    /// `P v`.
    pub(crate) p: Harmonics,
    /// Values of the [`Parameter`]s.
    pub(crate) parameters: [f64; 3],
}

/// What may be unknown beside the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parameter {
    /// Square of the angular frequency, `a` (rad^2/s^2).
    Square = 0,
    /// `b = 2 zeta omega^2` (rad^2/s^2).
    Damping = 1,
    /// Amplitude of the exciting force (N).
    Force = 2,
}

impl Unknown {
    pub(crate) fn at(&self, parameter: Parameter) -> f64 {
        self.parameters[parameter as usize]
    }

    pub(crate) fn at_mut(&mut self, parameter: Parameter) -> &mut f64 {
        &mut self.parameters[parameter as usize]
    }

    /// `self += factor * step`, with the changes of the free parameters.
    pub(crate) fn add(&mut self, factor: f64, step: &Step, free: &[Parameter]) {
        self.v.add(factor, &step.v);
        self.p.add(factor, &step.p);
        for (parameter, change) in free.iter().zip(&step.parameters) {
            *self.at_mut(*parameter) += factor * change;
        }
    }
}

/// A change of an [`Unknown`].
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub(crate) v: Harmonics,
    pub(crate) p: Harmonics,
    /// Of the free parameters.
    pub(crate) parameters: Vec<f64>,
}

impl Vector for Step {
    fn add(&mut self, factor: f64, other: &Self) {
        self.v.add(factor, &other.v);
        self.p.add(factor, &other.p);
        let parameters = self.parameters.iter_mut().zip(&other.parameters);
        parameters.for_each(|(a, b)| *a += factor * b);
    }

    fn scale(&mut self, factor: f64) {
        self.v.scale(factor);
        self.p.scale(factor);
        self.parameters.iter_mut().for_each(|p| *p *= factor);
    }
}

/// Samples per period over those of coarse forces.
const COARSER: usize = 4;

/// Fewest samples per period of the highest harmonic that those have.
const LEAST: usize = 8;

/// Part of the motion, in the energy norm, that it is changed by for a difference of forces.
const DIFFERENCE: f64 = 1e-4;

fn coarser(sampling: Sampling) -> Sampling {
    let Sampling { harmonics, samples, .. } = sampling;
    Sampling {
        samples: (samples / COARSER).max(LEAST * harmonics).min(samples),
        ..sampling
    }
}

/// Share of the stuck tangent in that of [`Averaged`], so that nothing can move freely.
const STUCK_SHARE: f64 = 0.02;

/// The structure with the contact's mean tangent over a period in the place of the stuck one, where motions are far from stuck.
struct Averaged {
    flexibility: Inverse,
    eigenvalues: Vec<f64>,
    shapes: Mat<f64>,
    /// Forces that hold the shapes in the stuck structure.
    forces: Mat<f64>,
    /// Stuck tangent less this one.
    difference: Vec<f64>,
}

/// The structure, its contact, and what excites it.
pub(crate) struct System<'a, F: PointwiseForce> {
    line: &'a Linearisation<'a, F::State>,
    force: &'a F,
    contact: Contact<'a, F>,
    /// The same at fewer samples, from the middle of the first period on.
    coarse: Contact<'a, F>,
    mass: Packed<'a>,
    /// `M phi_k`, `n x n_modes`.
    momenta: Mat<f64>,
    /// Forces that hold the shapes in the structure of the preconditioner, `P phi_k`.
    elastic: Mat<f64>,
    /// What the preconditioner is made of, if it is not the stuck structure.
    averaged: Option<Averaged>,
    /// `2 beta omega_k` of the background damping.
    background: Vec<f64>,
    /// Factors of mass (1/s) and stiffness without contact (s) in a proportional damping.
    rayleigh: [f64; 2],
    /// Rows of viscous dampers.
    dampers: &'a [Vec<f64>],
    /// What they take of each mode, `sum (d^T phi_k)^2`.
    damped: Vec<f64>,
    pub(crate) load: Load,
    sampling: Sampling,
}

/// How derivatives of the contact forces along a change of the motion are found.
#[derive(Clone, Debug)]
pub(crate) enum Derivative {
    /// To rounding, at several times the price of the forces.
    Exact,
    /// By a difference from the forces at the motion.
    Fine(Harmonics),
    /// By a difference from those of fewer samples: at a fraction of the price, with the error of their sampling.
    Coarse(Harmonics),
}

/// What an evaluation leaves.
pub(crate) struct Evaluation {
    /// Residual forces.
    pub(crate) residual: Harmonics,
    /// `P^-1` times the residual.
    pub(crate) response: Harmonics,
    /// `M V_h`, zero for the mean.
    pub(crate) inertia: Harmonics,
    /// Change of the tractions over the measured period relative to their range.
    pub(crate) drift: f64,
    /// Harmonics of the contact force from the static state.
    pub(crate) contact: Harmonics,
}

impl<'a, F: PointwiseForce> System<'a, F> {
    pub(crate) fn new(
        line: &'a Linearisation<'a, F::State>,
        force: &'a F,
        load: Load,
        background: f64,
        rayleigh: [f64; 2],
        sampling: Sampling,
    ) -> Self {
        let mass = line.mass().packed();
        let momenta = line.mass().product(line.shapes.as_ref());
        let mut elastic = momenta.clone();
        let tangents = line.preconditioner_tangent().iter().zip(line.stuck_tangent());
        let difference: Vec<f64> = tangents.map(|(a, b)| a - b).collect();
        for (mode, &eigenvalue) in line.eigenvalues.iter().enumerate() {
            let held = elastic.col_as_slice_mut(mode);
            held.iter_mut().for_each(|f| *f *= eigenvalue);
            force
                .pattern()
                .add_product(&difference, line.shapes.col_as_slice(mode), held);
        }
        let omega = line.eigenvalues.iter().map(|lambda| lambda.max(0.0).sqrt());
        Self {
            contact: Contact::new(force, line.displacement(), line.state(), sampling),
            coarse: Contact::new(force, line.displacement(), line.state(), coarser(sampling)).skip_half(),
            background: omega.map(|omega| 2.0 * background * omega).collect(),
            line,
            force,
            mass,
            momenta,
            elastic,
            averaged: None,
            rayleigh,
            dampers: &[],
            damped: vec![0.0; line.eigenvalues.len()],
            load,
            sampling,
        }
    }

    /// With the viscous dampers of the structure.
    pub(crate) fn with_dampers(self) -> Self {
        let line = self.line;
        Self {
            dampers: &line.dampers,
            damped: (0..line.eigenvalues.len())
                .map(|mode| line.damper_coefficient(mode))
                .collect(),
            ..self
        }
    }

    /// Takes other harmonics, samples or periods.
    pub(crate) fn resample(&mut self, sampling: Sampling) {
        if self.sampling != sampling {
            let contact = |sampling| Contact::new(self.force, self.line.displacement(), self.line.state(), sampling);
            (self.contact, self.coarse) = (contact(sampling), contact(coarser(sampling)).skip_half());
            self.sampling = sampling;
        }
    }

    /// Makes the preconditioner of the structure with the mean tangent of a motion; the stuck one stays where that fails.
    pub(crate) fn adapt(&mut self, motion: &Harmonics) {
        let line = self.line;
        let stuck = line.preconditioner_tangent();
        let mut tangent = self.coarse.mean_tangent(motion);
        for (mean, stuck) in tangent.iter_mut().zip(stuck) {
            *mean = (1.0 - STUCK_SHARE) * *mean + STUCK_SHARE * stuck;
        }
        let pattern = self.force.pattern();
        let Ok(factor) = line.stiffness().to_owned().factor_plus(pattern.entries(&tangent)) else {
            return;
        };
        let Ok((eigenvalues, shapes)) = factor.lowest_pairs(line.mass(), line.shapes.ncols()) else {
            return;
        };
        let difference: Vec<f64> = stuck.iter().zip(&tangent).map(|(stuck, mean)| stuck - mean).collect();
        let mut forces = line.mass().product(shapes.as_ref());
        for (mode, &eigenvalue) in eigenvalues.iter().enumerate() {
            let force = forces.col_as_slice_mut(mode);
            force.iter_mut().for_each(|f| *f *= eigenvalue);
            pattern.add_product(&difference, shapes.col_as_slice(mode), force);
        }
        self.averaged = Some(Averaged {
            flexibility: factor.into_inverse(),
            eigenvalues,
            shapes,
            forces,
            difference,
        });
    }

    /// Goes back to the preconditioner of the stuck structure.
    pub(crate) fn forget(&mut self) {
        self.averaged = None;
    }

    /// Whether the preconditioner is not that of the stuck structure.
    pub(crate) fn is_adapted(&self) -> bool {
        self.averaged.is_some()
    }

    pub(crate) fn sampling(&self) -> Sampling {
        self.sampling
    }

    pub(crate) fn line(&self) -> &'a Linearisation<'a, F::State> {
        self.line
    }

    pub(crate) fn size(&self) -> usize {
        self.line.shapes.nrows()
    }

    /// `M phi` of a mode.
    pub(crate) fn momentum(&self, mode: usize) -> &[f64] {
        self.momenta.col_as_slice(mode)
    }

    /// `P phi` of a mode.
    pub(crate) fn elastic_force(&self, mode: usize) -> &[f64] {
        self.elastic.col_as_slice(mode)
    }

    /// `P^-1 x`, column by column.
    pub(crate) fn solve_stuck(&self, x: &Harmonics) -> Harmonics {
        let mut out = Harmonics::zeros(x.size(), x.count());
        out.each_column(|column, y| self.line.preconditioner_solve_into(x.column(column), y));
        out
    }

    /// `M x` of every column.
    pub(crate) fn momentum_of(&self, x: &Harmonics) -> Harmonics {
        self.momentum_from(0, x)
    }

    /// `M x`, but for the mean, which has no inertia.
    fn inertia(&self, x: &Harmonics) -> Harmonics {
        self.momentum_from(1, x)
    }

    /// `M x` of the columns from `first` on, zero before.
    fn momentum_from(&self, first: usize, x: &Harmonics) -> Harmonics {
        let mut out = Harmonics::zeros(x.size(), x.count());
        out.each_column(|column, y| {
            if column >= first {
                self.mass.product_into(x.column(column), y);
            }
        });
        out
    }

    /// `T x`, column by column, taken off `from`.
    pub(crate) fn subtract_stuck(&self, x: &Harmonics, from: &mut Harmonics) {
        let nd = self.force.n_dofs();
        from.each_column(|column, y| {
            let mut product = vec![0.0; nd];
            self.force
                .pattern()
                .add_product(self.line.preconditioner_tangent(), x.column(column), &mut product);
            for (y, product) in y.iter_mut().zip(product) {
                *y -= product;
            }
        });
    }

    /// Coordinates of the lowest modes, `[column][mode]`, `weights` being shapes or momenta.
    fn modal(&self, x: &Harmonics, weights: &Mat<f64>) -> Vec<Vec<f64>> {
        (0..x.n_columns())
            .map(|column| {
                let x = x.column(column);
                let along = |mode: usize| weights.col(mode).iter().zip(x).map(|(w, x)| w * x).sum();
                (0..weights.ncols()).map(along).collect()
            })
            .collect()
    }

    /// Adds the combination of vectors with the coefficients `[column][mode]`.
    fn add_modes(&self, coefficients: &[Vec<f64>], vectors: &Mat<f64>, to: &mut Harmonics) {
        to.each_column(|column, to| {
            for (mode, &c) in coefficients[column].iter().enumerate() {
                if c != 0.0 {
                    to.iter_mut()
                        .zip(vectors.col(mode).iter())
                        .for_each(|(to, v)| *to += c * v);
                }
            }
        });
    }

    /// Adds `i h factor C x` of every harmonic of a motion `x`, of which `p = P x` and `momentum = M x`.
    fn add_damping(&self, x: &Harmonics, p: &Harmonics, momentum: &Harmonics, factor: f64, to: &mut Harmonics) {
        let Some(damping) = self.damping(x, p, momentum) else {
            return;
        };
        for h in 1..=x.count() {
            add_rotated(to.pair_mut(h), damping.pair(h), 0.0, h as f64 * factor);
        }
    }

    /// `C x` of every column, of which `p = P x` and `momentum = M x`; `None` without viscous damping.
    pub(crate) fn damping(&self, x: &Harmonics, p: &Harmonics, momentum: &Harmonics) -> Option<Harmonics> {
        let [of_mass, of_stiffness] = self.rayleigh;
        let has_background = self.background.iter().any(|c| *c != 0.0);
        let is_proportional = [of_mass, of_stiffness] != [0.0; 2];
        if !has_background && !is_proportional && self.dampers.is_empty() {
            return None;
        }
        let mut force = Harmonics::zeros(x.size(), x.count());
        if has_background {
            let mut modal = self.modal(x, &self.momenta);
            for column in &mut modal {
                column
                    .iter_mut()
                    .zip(&self.background)
                    .for_each(|(q, damping)| *q *= damping);
            }
            self.add_modes(&modal, &self.momenta, &mut force);
        }
        if is_proportional {
            let mut elastic = p.clone();
            self.subtract_stuck(x, &mut elastic);
            force.add(of_stiffness, &elastic);
            force.add(of_mass, momentum);
        }
        force.each_column(|column, force| {
            for damper in self.dampers {
                let rate = dot(damper, x.column(column));
                force.iter_mut().zip(damper).for_each(|(f, d)| *f += rate * d);
            }
        });
        Some(force)
    }

    /// Adds `-(h^2 a + i h b)` times `inertia` of every harmonic.
    fn add_inertia(&self, inertia: &Harmonics, a: f64, b: f64, to: &mut Harmonics) {
        for h in 1..=inertia.count() {
            let order = h as f64;
            add_rotated(to.pair_mut(h), inertia.pair(h), -order * order * a, -order * b);
        }
    }

    /// Contact forces along a motion.
    pub(crate) fn contact_forces(&self, motion: &Harmonics) -> Harmonics {
        self.contact.forces(motion).force
    }

    /// What grows of them along what grows by `exp(growth)` per period ([`Contact::growing_derivative`]).
    pub(crate) fn growing_contact(
        &self,
        motion: &Harmonics,
        change: [&Harmonics; 2],
        growth: Complex<f64>,
    ) -> [Harmonics; 2] {
        self.contact.growing_derivative(motion, change, growth)
    }

    /// The same from fewer samples, and from the middle of the first period on.
    pub(crate) fn coarse_forces(&self, motion: &Harmonics) -> Harmonics {
        self.coarse.forces(motion).force
    }

    /// Their derivative along a change of the motion.
    pub(crate) fn contact_derivative(
        &self,
        unknown: &Unknown,
        [v, p]: [&Harmonics; 2],
        derivative: &Derivative,
    ) -> Harmonics {
        let ratio = unknown.v.dot(&unknown.p) / v.dot(p);
        let (contact, base) = match derivative {
            Derivative::Coarse(base) if ratio.is_finite() && ratio > 0.0 => (&self.coarse, base),
            Derivative::Fine(base) if ratio.is_finite() && ratio > 0.0 => (&self.contact, base),
            _ => return self.contact.derivative(&unknown.v, v),
        };
        let step = DIFFERENCE * ratio.sqrt();
        let mut moved = unknown.v.clone();
        moved.add(step, v);
        let mut change = contact.forces(&moved).force;
        change.add(-1.0, base);
        change.scale(1.0 / step);
        change
    }

    /// The residual at a motion.
    pub(crate) fn evaluate(&self, unknown: &Unknown) -> Evaluation {
        let [a, b, excitation] = unknown.parameters;
        let Forces { force: contact, drift } = self.contact.forces(&unknown.v);
        let inertia = self.inertia(&unknown.v);
        let mut residual = contact.clone();
        self.subtract_stuck(&unknown.v, &mut residual);
        residual.add(1.0, &unknown.p);
        self.add_inertia(&inertia, a, b, &mut residual);
        self.add_damping(&unknown.v, &unknown.p, &inertia, a.max(0.0).sqrt(), &mut residual);
        self.load.add(-excitation, a, &mut residual);
        let response = self.solve_stuck(&residual);
        Evaluation {
            residual,
            response,
            inertia,
            drift,
            contact,
        }
    }

    /// Change of the residual at a free motion with a parameter, per unit of it.
    pub(crate) fn parameter_change(&self, unknown: &Unknown, rate: &ParameterRate<'_, F>) -> Harmonics
    where
        F: DifferentiablePointwiseForce,
    {
        let mut change = self.contact.parameter_change(&unknown.v, rate);
        change.each_column(|column, y| add_product(1.0, &rate.change.stiffness, unknown.v.column(column), y));
        if let Some(inertia) = self.inertia_change(unknown, rate) {
            let [a, b, _] = unknown.parameters;
            self.add_inertia(&inertia, a, b, &mut change);
        }
        change
    }

    /// `M' v` of the harmonics of a motion, if the mass changes with a parameter.
    pub(crate) fn inertia_change(&self, unknown: &Unknown, rate: &ParameterRate<'_, F>) -> Option<Harmonics>
    where
        F: DifferentiablePointwiseForce,
    {
        let mass = &rate.change.mass;
        let mut inertia = Harmonics::zeros(unknown.v.size(), unknown.v.count());
        inertia.each_column(|column, y| {
            if column > 0 {
                add_product(1.0, mass, unknown.v.column(column), y);
            }
        });
        (!mass.is_empty()).then_some(inertia)
    }

    /// Computes `p` from `v` and the stiffness.
    pub(crate) fn restore(&self, unknown: &mut Unknown) {
        let (stiffness, Unknown { v, p, .. }) = (self.line.stiffness(), unknown);
        p.each_column(|column, p| {
            let v = v.column(column);
            stiffness.multiply(v, p);
            self.force
                .pattern()
                .add_product(self.line.preconditioner_tangent(), v, p);
        });
    }

    /// Work of the viscous damping over a period (J).
    pub(crate) fn viscous_work(&self, unknown: &Unknown) -> f64 {
        let mut force = Harmonics::zeros(unknown.v.size(), unknown.v.count());
        let omega = unknown.at(Parameter::Square).max(0.0).sqrt();
        self.add_damping(&unknown.v, &unknown.p, &self.inertia(&unknown.v), omega, &mut force);
        force.work(&unknown.v)
    }

    /// Work of the exciting force over a period (J).
    pub(crate) fn supplied_work(&self, unknown: &Unknown) -> f64 {
        let [_, behind] = self.load.along(&unknown.v);
        PI * unknown.at(Parameter::Force) * self.load.factor(unknown.at(Parameter::Square)) * behind
    }

    /// Damping ratio of a driven motion by what its force gives over a period, and the error of that: what forces take is more or less. Both are over `4 pi`
    /// times the energy of the first harmonic.
    pub(crate) fn damping_ratio(&self, unknown: &Unknown, evaluation: &Evaluation) -> [f64; 2] {
        let supplied = self.supplied_work(unknown);
        let taken = evaluation.contact.work(&unknown.v) + self.viscous_work(unknown);
        let ([c, s], [mc, ms]) = (unknown.v.pair(1), evaluation.inertia.pair(1));
        let square: f64 = c.iter().zip(mc).chain(s.iter().zip(ms)).map(|(v, m)| v * m).sum();
        [supplied, (taken - supplied).abs()].map(|work| work / (2.0 * PI * unknown.at(Parameter::Square) * square))
    }

    /// The residual's energy norm with the stiffness itself in the place of what was carried along, relative to that of the first
    /// harmonic's elastic forces: an independent check of the balance.
    pub(crate) fn imbalance(&self, unknown: &Unknown) -> f64 {
        let mut fresh = unknown.clone();
        self.restore(&mut fresh);
        self.evaluate(&fresh).norm() / self.scale(&fresh)
    }

    /// Energy norm of the elastic forces of the motion's harmonics.
    pub(crate) fn scale(&self, unknown: &Unknown) -> f64 {
        let [c, s] = unknown.v.pair(1);
        let [pc, ps] = unknown.p.pair(1);
        let energy: f64 = c.iter().zip(pc).chain(s.iter().zip(ps)).map(|(v, p)| v * p).sum();
        energy.max(0.0).sqrt()
    }

    /// Derivative of the residual with respect to a parameter.
    pub(crate) fn column(&self, unknown: &Unknown, inertia: &Harmonics, parameter: Parameter) -> Harmonics {
        let mut out = Harmonics::zeros(unknown.v.size(), unknown.v.count());
        match parameter {
            Parameter::Square => {
                self.add_inertia(inertia, 1.0, 0.0, &mut out);
                let omega = unknown.at(Parameter::Square).max(f64::MIN_POSITIVE).sqrt();
                self.add_damping(&unknown.v, &unknown.p, inertia, 0.5 / omega, &mut out);
                if self.load.is_unbalance {
                    self.load.add(-unknown.at(Parameter::Force), 1.0, &mut out);
                }
            }
            Parameter::Damping => self.add_inertia(inertia, 0.0, 1.0, &mut out),
            Parameter::Force => self.load.add(-1.0, unknown.at(Parameter::Square), &mut out),
        }
        out
    }

    /// Product of the Jacobian with a change of the motion, given with `p = P v`.
    pub(crate) fn product(
        &self,
        unknown: &Unknown,
        v: &Harmonics,
        p: &Harmonics,
        derivative: &Derivative,
    ) -> Harmonics {
        let [a, b, _] = unknown.parameters;
        let mut out = self.contact_derivative(unknown, [v, p], derivative);
        self.subtract_stuck(v, &mut out);
        out.add(1.0, p);
        let inertia = self.inertia(v);
        self.add_inertia(&inertia, a, b, &mut out);
        self.add_damping(v, p, &inertia, a.max(0.0).sqrt(), &mut out);
        out
    }

    /// The preconditioner's answer to a force `r`, of which `z = P^-1 r`, as displacement `v` and force `P v`.
    pub(crate) fn precondition(&self, unknown: &Unknown, r: &Harmonics, z: &Harmonics) -> [Harmonics; 2] {
        let line = self.line;
        let Some(averaged) = &self.averaged else {
            let (v, p) = (z.clone(), r.clone());
            return self.add_inertia_of_modes(unknown, r, &line.eigenvalues, &line.shapes, &self.elastic, [v, p]);
        };
        let mut v = Harmonics::zeros(r.size(), r.count());
        v.each_column(|column, v| averaged.flexibility.product_into(r.column(column), v));
        let mut p = r.clone();
        p.each_column(|column, p| {
            self.force
                .pattern()
                .add_product(&averaged.difference, v.column(column), p);
        });
        let Averaged {
            eigenvalues,
            shapes,
            forces,
            ..
        } = averaged;
        self.add_inertia_of_modes(unknown, r, eigenvalues, shapes, forces, [v, p])
    }

    /// Adds what the inertia of the lowest modes changes in the response `v` to the force `r`, and the force that holds it.
    fn add_inertia_of_modes(
        &self,
        unknown: &Unknown,
        r: &Harmonics,
        eigenvalues: &[f64],
        shapes: &Mat<f64>,
        forces: &Mat<f64>,
        [mut v, mut p]: [Harmonics; 2],
    ) -> [Harmonics; 2] {
        let [a, b, _] = unknown.parameters;
        let omega = a.max(0.0).sqrt();
        let mut along = self.modal(r, shapes);
        along[0].fill(0.0);
        for h in 1..=r.count() {
            let order = h as f64;
            for (mode, &lambda) in eigenvalues.iter().enumerate() {
                let mut real = lambda - order * order * a;
                let viscous = self.background[mode] + self.rayleigh[0] + self.rayleigh[1] * lambda + self.damped[mode];
                let mut imaginary = order * (omega * viscous - b);
                let closest = CLOSEST * lambda.abs();
                if real.hypot(imaginary) < closest {
                    (real, imaginary) = (closest, 0.0);
                }
                let square = real * real + imaginary * imaginary;
                // The factor 1/d - 1/lambda.
                let (x, y) = (real / square - 1.0 / lambda, -imaginary / square);
                let (c, s) = (along[2 * h - 1][mode], along[2 * h][mode]);
                (along[2 * h - 1][mode], along[2 * h][mode]) = (x * c + y * s, x * s - y * c);
            }
        }
        self.add_modes(&along, shapes, &mut v);
        self.add_modes(&along, forces, &mut p);
        [v, p]
    }
}

impl Evaluation {
    /// Energy norm of the residual; NaN if it is not finite.
    pub(crate) fn norm(&self) -> f64 {
        let square = self.residual.dot(&self.response);
        if square >= 0.0 { square.sqrt() } else { f64::NAN }
    }
}
