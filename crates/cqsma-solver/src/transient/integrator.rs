//! The steps of a motion.

use super::motion::{Energy, Sample, Settings, Start};
use super::scheme::Scheme;
use crate::Error;
use crate::force::HystereticForce;
use crate::linear::{Motion, RoundOff, Stuck};
use crate::modes::{Linearisation, Mode};
use crate::newton::{Equilibrium, Failure, Goal, Load, NewtonSettings, Reason, Sequence};
use crate::path::Path;
use contact_laws::Sticking;
use dense_algebra::{Inner, Packed, SystemMatrix, Vector, dot};

/// Equal steps of the modal force that a released motion is loaded in.
const LOADING_STEPS: usize = 16;

/// The structure of one step length: its stiffness with inertia and damping, and that stuck.
struct Level {
    step: f64,
    /// Factors of mass and damping in the stiffness, `c` and `c'`.
    inertia: f64,
    damping: f64,
    stiffness: SystemMatrix,
    stuck: Stuck,
    round_off: RoundOff,
    /// Energy norm of the peak force of the pulse.
    pulse: f64,
}

/// Viscous damping: `C = sum 2 zeta omega_i (M phi_i) (M phi_i)^T + sum d d^T`, of modes and of dampers.
struct Damping {
    /// Factors and vectors of the terms.
    terms: Vec<(f64, Vec<f64>)>,
}

impl Damping {
    /// `C x`.
    fn product(&self, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; x.len()];
        for (factor, vector) in &self.terms {
            add(&mut out, factor * dot(vector, x), vector);
        }
        out
    }
}

/// What is known of the end of a step before it is computed.
struct Ahead {
    displacement: Vec<f64>,
    mass_displacement: Vec<f64>,
}

/// State and structure of a motion.
pub(super) struct Integrator<'a, F: HystereticForce> {
    structure: &'a Linearisation<'a, F::State>,
    force: &'a F,
    mode: &'a Mode,
    start: &'a Start,
    settings: &'a Settings,
    scheme: Scheme,
    stiffness: Packed<'a>,
    mass: Packed<'a>,
    damping: Damping,
    /// By halvings of the step; the shorter ones are made when needed.
    levels: Vec<Level>,
    pub(super) sequence: Sequence<F>,
    pub(super) time: f64,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    /// Products with stiffness and mass.
    elastic_force: Vec<f64>,
    mass_displacement: Vec<f64>,
    mass_velocity: Vec<f64>,
    mass_acceleration: Vec<f64>,
    /// Change of the contact force from the static state.
    contact: Vec<f64>,
    /// Displacements at the last full steps, the later one first.
    previous: Vec<Motion>,
    energy: Energy,
    pub(super) residual: f64,
    pub(super) halved_steps: usize,
}

fn add(to: &mut [f64], factor: f64, from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(a, b)| *a += factor * b);
}

/// `sum factor * vector`.
fn combine<const N: usize>(terms: [(f64, &[f64]); N]) -> Vec<f64> {
    let mut out = vec![0.0; terms[0].1.len()];
    for (factor, vector) in terms {
        add(&mut out, factor, vector);
    }
    out
}

impl<'a, F: HystereticForce> Integrator<'a, F> {
    pub(super) fn new(
        structure: &'a Linearisation<'a, F::State>,
        force: &'a F,
        mode: &'a Mode,
        start: &'a Start,
        settings: &'a Settings,
    ) -> Self {
        let n = mode.shape.len();
        let mass = structure.mass.packed();
        let mut damping = Damping {
            terms: structure.dampers.iter().map(|damper| (1.0, damper.clone())).collect(),
        };
        for (index, (shape, eigenvalue)) in structure.shapes.col_iter().zip(&structure.eigenvalues).enumerate() {
            let other = if index == settings.mode {
                0.0
            } else {
                settings.other_damping
            };
            let ratio = settings.background_damping.max(other);
            if ratio > 0.0 {
                let shape: Vec<f64> = shape.iter().copied().collect();
                let mut momentum = vec![0.0; n];
                mass.product_into(&shape, &mut momentum);
                damping.terms.push((2.0 * ratio * eigenvalue.max(0.0).sqrt(), momentum));
            }
        }
        let zeros = || vec![0.0; n];
        Self {
            structure,
            force,
            mode,
            start,
            settings,
            scheme: Scheme::new(settings.spectral_radius),
            stiffness: structure.stiffness.packed(),
            mass,
            damping,
            levels: Vec::new(),
            sequence: Sequence::new(force, Motion::zero(n), structure.state.clone()),
            time: 0.0,
            displacement: zeros(),
            velocity: zeros(),
            acceleration: zeros(),
            elastic_force: zeros(),
            mass_displacement: zeros(),
            mass_velocity: zeros(),
            mass_acceleration: zeros(),
            contact: vec![0.0; force.n_dofs()],
            previous: Vec::new(),
            energy: Energy::default(),
            residual: 0.0,
            halved_steps: 0,
        }
    }

    /// Brings the structure to where its motion begins.
    pub(super) fn begin(&mut self) -> Result<(), Failure> {
        let modal_force = match self.start {
            Start::Pulse { .. } | Start::Record { .. } => return Ok(()),
            Start::Driven { motion, .. } => {
                self.place(motion);
                return Ok(());
            }
            Start::Release { modal_force } => *modal_force,
        };
        let sequence = Sequence::new(self.force, self.sequence.motion.clone(), self.structure.state.clone());
        let solution = (self.settings.solver, NewtonSettings::default());
        let equilibrium = self.structure.equilibrium(self.force);
        let mut path = Path::new(equilibrium, &self.mode.unit, modal_force, solution, sequence);
        for step in 1..=LOADING_STEPS {
            path.advance(modal_force * step as f64 / LOADING_STEPS as f64)?;
            path.sequence.commit();
        }
        self.sequence = path.sequence;
        self.displacement.copy_from_slice(&self.sequence.motion.v);
        self.stiffness.product_into(&self.displacement, &mut self.elastic_force);
        self.mass.product_into(&self.displacement, &mut self.mass_displacement);
        self.acceleration = combine([(-modal_force, &self.mode.shape)]);
        self.mass_acceleration = combine([(-modal_force, &self.mode.unit.force)]);
        self.contact = self.contact_change();
        self.energy.elastic = 0.5 * dot(&self.displacement, &self.elastic_force);
        Ok(())
    }

    /// Puts the structure into a given motion.
    fn place(&mut self, [displacement, velocity, acceleration]: &[Vec<f64>; 3]) {
        self.displacement.copy_from_slice(displacement);
        self.velocity.copy_from_slice(velocity);
        self.acceleration.copy_from_slice(acceleration);
        self.stiffness.product_into(&self.displacement, &mut self.elastic_force);
        self.mass.product_into(&self.displacement, &mut self.mass_displacement);
        self.mass.product_into(&self.velocity, &mut self.mass_velocity);
        self.mass.product_into(&self.acceleration, &mut self.mass_acceleration);
        let nd = self.force.n_dofs();
        let total: Vec<f64> = (0..nd)
            .map(|i| self.structure.displacement[i] + displacement[i])
            .collect();
        let mut end = self.structure.state.clone();
        self.force.evaluate(
            &total,
            Sticking::Coulomb,
            &self.structure.state,
            &mut end,
            &mut self.force.workspace(),
            &mut self.contact,
            None,
        );
        for (f, f0) in self.contact.iter_mut().zip(&self.structure.contact_force) {
            *f -= f0;
        }
        self.sequence.begin = end;
        self.sequence.motion.v.copy_from_slice(displacement);
        let p = &mut self.sequence.motion.p;
        p.copy_from_slice(&self.elastic_force);
        self.force
            .pattern()
            .add_product(&self.structure.tangent, displacement, p);
        self.energy.kinetic = 0.5 * dot(&self.velocity, &self.mass_velocity);
        self.energy.elastic = 0.5 * dot(&self.displacement, &self.elastic_force);
    }

    /// Change of the contact force from the static state, at the last solution.
    fn contact_change(&self) -> Vec<f64> {
        let pairs = self.sequence.contact.iter().zip(&self.structure.contact_force);
        pairs.map(|(f, f0)| f - f0).collect()
    }

    fn level(&mut self, index: usize, step: f64) -> Result<(), Error> {
        if index < self.levels.len() {
            return Ok(());
        }
        let Scheme {
            alpha_m,
            alpha_f,
            beta,
            gamma,
        } = self.scheme;
        let inertia = (1.0 - alpha_m) / ((1.0 - alpha_f) * beta * step * step);
        let damping = gamma / (beta * step);
        let terms = self.damping.terms.iter();
        let viscous: Vec<(f64, &[f64])> = terms
            .map(|(factor, vector)| (damping * factor, vector.as_slice()))
            .collect();
        let stiffness = self
            .structure
            .stiffness
            .plus(inertia, self.structure.mass)
            .plus_outer(&viscous);
        let pattern = self.force.pattern();
        let stuck = Stuck::try_new(stiffness.as_ref(), pattern, &self.structure.tangent, Vec::new())?;
        let reference = &self.structure.displacement[..self.force.n_dofs()];
        self.levels.push(Level {
            step,
            inertia,
            damping,
            stiffness,
            round_off: stuck.round_off(pattern, reference, &self.structure.contact_force),
            pulse: self
                .start
                .point()
                .map_or(0.0, |point| self.start.peak_force() * stuck.response(point).norm()),
            stuck,
        });
        Ok(())
    }

    /// One step, in halves if it must be. The outer result is that of a factorisation.
    pub(super) fn advance(&mut self, step: f64, halvings: usize) -> Result<Result<(), Failure>, Error> {
        self.level(halvings, step)?;
        let Err(failure) = self.step(halvings) else {
            return Ok(Ok(()));
        };
        if halvings == self.settings.newton.max_halvings || failure.reason == Reason::Interrupted {
            return Ok(Err(failure));
        }
        if !self.sequence.effort.is_within_budget() {
            return Ok(Err(Failure {
                reason: Reason::Budget,
                ..failure
            }));
        }
        self.halved_steps += 1;
        for _ in 0..2 {
            if let Err(failure) = self.advance(0.5 * step, halvings + 1)? {
                return Ok(Err(failure));
            }
        }
        // What is left of the past is not equidistant.
        self.previous.clear();
        Ok(Ok(()))
    }

    /// One step of a level's length.
    fn step(&mut self, index: usize) -> Result<(), Failure> {
        let h = self.levels[index].step;
        let ahead = self.ahead(h);
        let pulse = [self.start.force_at(self.time), self.start.force_at(self.time + h)];
        let load = self.load(index, &ahead, pulse);
        let here = self.here(index);
        self.settle(index, &load, &here, pulse[1])?;
        self.accept(h, &ahead, pulse);
        if index == 0 {
            self.previous.insert(0, here);
            self.previous.truncate(3);
        }
        Ok(())
    }

    /// Displacement at the end of a step, but for the acceleration there, and its product with the mass.
    fn ahead(&self, h: f64) -> Ahead {
        let [a, b, c] = [1.0, h, h * h * (0.5 - self.scheme.beta)];
        Ahead {
            displacement: combine([(a, &self.displacement), (b, &self.velocity), (c, &self.acceleration)]),
            mass_displacement: combine([
                (a, &self.mass_displacement),
                (b, &self.mass_velocity),
                (c, &self.mass_acceleration),
            ]),
        }
    }

    /// Load of the equilibrium at the end of a step, with the forces of the pulse before and after it.
    fn load(&self, index: usize, ahead: &Ahead, [before, after]: [f64; 2]) -> Vec<f64> {
        let Scheme {
            alpha_m,
            alpha_f,
            gamma,
            ..
        } = self.scheme;
        let level = &self.levels[index];
        let (old, new) = (alpha_f / (1.0 - alpha_f), 1.0 / (1.0 - alpha_f));
        let mut load = combine([
            (level.inertia, &ahead.mass_displacement),
            (-alpha_m * new, &self.mass_acceleration),
            (-old, &self.elastic_force),
        ]);
        add(&mut load, -old, &self.contact);
        if let Some(point) = self.start.point() {
            add(&mut load, after + old * before, point);
        }
        if !self.damping.terms.is_empty() {
            let rates = combine([
                (level.damping, &ahead.displacement),
                (-1.0 - old, &self.velocity),
                (-level.step * (1.0 - gamma), &self.acceleration),
            ]);
            add(&mut load, 1.0, &self.damping.product(&rates));
        }
        load
    }

    /// The displacement at hand as a motion of a level's structure.
    fn here(&self, index: usize) -> Motion {
        let level = &self.levels[index];
        let mut here = Motion {
            v: self.displacement.clone(),
            p: combine([(1.0, &self.elastic_force), (level.inertia, &self.mass_displacement)]),
        };
        let pattern = self.force.pattern();
        pattern.add_product(level.stuck.tangent(), &self.displacement, &mut here.p);
        if !self.damping.terms.is_empty() {
            add(&mut here.p, level.damping, &self.damping.product(&self.displacement));
        }
        here
    }

    /// Finds the displacement at the end of a step and commits the history there; `pulse` is the external force at the end.
    fn settle(&mut self, index: usize, load: &[f64], here: &Motion, pulse: f64) -> Result<(), Failure> {
        let level = &self.levels[index];
        let equilibrium = Equilibrium {
            stiffness: level.stiffness.as_ref(),
            force: self.force,
            stuck: &level.stuck,
            reference: &self.structure.displacement[..self.force.n_dofs()],
            reference_force: &self.structure.contact_force,
            round_off: level.round_off,
            limits: self.structure.limits,
        };
        // The inertia of a motion with this energy at the frequency of the mode.
        let energy = self.energy.kinetic + self.energy.elastic;
        let eigenvalue = self.mode.eigenvalue;
        let inertia = (2.0 * energy * eigenvalue / (eigenvalue + level.inertia)).sqrt();
        let pulse = if pulse == 0.0 { 0.0 } else { level.pulse };
        let goal = Goal {
            factor: 1.0,
            load: Load::Pattern(load),
            scale: inertia.max(pulse),
            sticking: Sticking::Coulomb,
            // Motions pass through the reference, where the contact forces do not change; the balance of energies tells.
            balance: None,
        };
        let solve = |sequence: &mut Sequence<F>| {
            equilibrium.solve(sequence, &goal, self.settings.solver, &self.settings.newton)
        };
        // A cubic through the last full steps; where it leads astray, the displacement at hand.
        let sequence = &mut self.sequence;
        sequence.motion.copy_from(here);
        let outcome = match (&self.previous[..], index) {
            ([first, second, third], 0) => {
                sequence.motion.scale(4.0);
                sequence.motion.add(-6.0, first);
                sequence.motion.add(4.0, second);
                sequence.motion.add(-1.0, third);
                solve(sequence).or_else(|_| {
                    sequence.motion.copy_from(here);
                    solve(sequence)
                })
            }
            _ => solve(sequence),
        };
        self.residual = self.residual.max(outcome?.residual);
        sequence.commit();
        Ok(())
    }

    /// Takes over the displacement found: velocity, acceleration and energies at the end of the step.
    fn accept(&mut self, h: f64, ahead: &Ahead, [force_before, force_after]: [f64; 2]) {
        let Scheme { beta, gamma, .. } = self.scheme;
        let displacement = self.sequence.motion.v.clone();
        let advance = combine([(1.0, &displacement), (-1.0, &self.displacement)]);
        let contact = self.contact_change();
        let shared = &advance[..contact.len()];
        let work = |before: &[f64], after: &[f64], way: &[f64]| 0.5 * (dot(before, way) + dot(after, way));
        self.energy.contact += work(&self.contact, &contact, shared);
        if let Some(point) = self.start.point() {
            self.energy.external += 0.5 * (force_before + force_after) * dot(point, &advance);
        }
        let mut mass_displacement = vec![0.0; displacement.len()];
        self.mass.product_into(&displacement, &mut mass_displacement);
        self.stiffness.product_into(&displacement, &mut self.elastic_force);
        // Newmark's formulas, for the vectors and their products with the mass.
        let newmark = |at: &[f64], ahead: &[f64], velocity: &[f64], acceleration: &[f64]| {
            let scale = 1.0 / (beta * h * h);
            let next = combine([(scale, at), (-scale, ahead)]);
            let velocity = combine([(1.0, velocity), (h * (1.0 - gamma), acceleration), (h * gamma, &next)]);
            (velocity, next)
        };
        let (velocity, acceleration) = newmark(&displacement, &ahead.displacement, &self.velocity, &self.acceleration);
        let (mass_velocity, mass_acceleration) = newmark(
            &mass_displacement,
            &ahead.mass_displacement,
            &self.mass_velocity,
            &self.mass_acceleration,
        );
        if !self.damping.terms.is_empty() {
            let (before, after) = (self.damping.product(&self.velocity), self.damping.product(&velocity));
            self.energy.viscous += work(&before, &after, &advance);
        }
        self.energy.elastic = 0.5 * dot(&displacement, &self.elastic_force);
        self.energy.kinetic = 0.5 * dot(&velocity, &mass_velocity);
        let modal = dot(&self.mode.unit.force, &velocity);
        self.energy.kinetic_elsewhere = (self.energy.kinetic - 0.5 * modal * modal).max(0.0);
        self.displacement = displacement;
        self.velocity = velocity;
        self.acceleration = acceleration;
        self.mass_displacement = mass_displacement;
        self.mass_velocity = mass_velocity;
        self.mass_acceleration = mass_acceleration;
        self.contact = contact;
        self.time += h;
    }

    /// Displacements of all coordinates (m).
    pub(super) fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    pub(super) fn sample(&self, row: &[f64]) -> Sample {
        Sample {
            time: self.time,
            displacement: dot(row, &self.displacement),
            velocity: dot(row, &self.velocity),
            acceleration: dot(row, &self.acceleration),
            energy: self.energy,
        }
    }
}
