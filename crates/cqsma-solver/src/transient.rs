//! Free decay in time: the equations of motion with the friction law, as a check of the quasi-static methods.
//!
//! `M v'' + C v' + K v + F(u* + v) - F(u*) = p(t)` in increments `v` from the static state, by the generalised-alpha method
//! (Chung and Hulbert 1993, DOI 10.1115/1.2900803): second order, unconditionally stable where linear, with the spectral
//! radius at infinite frequency as its one parameter. With a radius of one nothing is damped by the scheme, and the work
//! of all forces by the trapezoidal rule is exactly the change of the kinetic energy.
//!
//! One step is one equilibrium of the structure with the stiffness `K + c M + c' C`, whose stuck form is factored once.
//! The history of the force is committed at every step. The shape of the motion, the way that amplitudes have fallen, and
//! the inertia of all coordinates are thus what they are; what [`crate::cqsma`] assumes of them is not assumed here.

use crate::Error;
use crate::error::check_size;
use crate::force::HystereticForce;
use crate::linear::{Motion, Stuck, dot};
use crate::modes::{Linearisation, Mode};
use crate::newton::{Effort, Equilibrium, Failure, Goal, LinearSolver, Load, NewtonSettings, Walk};
use crate::path::Path;
use contact_laws::Sticking;
use dense_algebra::Symmetric;
use faer::{Mat, c64};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

/// Equal steps of the modal force that a released motion is loaded in.
const LOADING_STEPS: usize = 16;

/// How motion begins.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// Released from the equilibrium under the load `alpha M phi` of the mode, `alpha` in sqrt(kg) m/s^2. The first
    /// acceleration is `-alpha phi` exactly, so that the mode alone begins to move.
    Release {
        /// Modal force `alpha`.
        modal_force: f64,
    },
    /// Struck at rest: one half-sine of force.
    Pulse {
        /// Integral of the force over time (N s).
        impulse: f64,
        /// Duration of the contact (s).
        duration: f64,
        /// Work-conjugate displacement as a row over the coordinates: the force acts along it.
        point: Vec<f64>,
    },
}

/// How a motion is followed.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The mode that sets the step and that a release moves, zero-based.
    pub mode: usize,
    /// Steps per period of this mode, linearised.
    pub steps_per_period: usize,
    /// Periods of this mode to follow.
    pub periods: usize,
    /// Spectral radius of the scheme at infinite frequency, from 0 (such motion vanishes in a step) to 1.
    pub spectral_radius: f64,
    /// Viscous damping ratio of every linearised mode.
    pub background_damping: f64,
    /// Viscous damping ratio of the linearised modes beside that one, where it is larger: quietens what else was excited.
    pub other_damping: f64,
    /// Newton's method. The tolerance refers to the inertia at the energy of the moment, moving with the frequency of the
    /// mode; the halvings of a step in time are as many as those of a Newton step.
    pub newton: NewtonSettings,
    /// How its linear systems are solved.
    pub solver: LinearSolver,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: 0,
            steps_per_period: 100,
            periods: 100,
            spectral_radius: 0.9,
            background_damping: 0.0,
            other_damping: 0.0,
            newton: NewtonSettings {
                tolerance: 1e-8,
                max_iterations: 30,
                max_halvings: 8,
            },
            solver: LinearSolver::default(),
        }
    }
}

/// Where the energy is and has gone (J). Those of the bodies count from the static state, with the static force of the
/// contact in the contact's share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Energy {
    /// Kinetic.
    pub kinetic: f64,
    /// Part of it outside the mode.
    pub kinetic_elsewhere: f64,
    /// Elastic, of the bodies.
    pub elastic: f64,
    /// Work done on the contact since the start: dissipated by friction, and stored in it.
    pub contact: f64,
    /// Work done against viscous forces.
    pub viscous: f64,
    /// Work of the pulse.
    pub external: f64,
}

impl Energy {
    /// Energy of all kinds beyond what the pulse has put in; its change from the first sample is what the scheme, unfinished
    /// iterations and round-off take away or add.
    pub fn balance(&self) -> f64 {
        self.kinetic + self.elastic + self.contact + self.viscous - self.external
    }
}

/// One moment; displacement, velocity and acceleration are those of the row observed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the start (s).
    pub time: f64,
    /// Displacement from the static state (m).
    pub displacement: f64,
    /// Velocity (m/s).
    pub velocity: f64,
    /// Acceleration (m/s^2).
    pub acceleration: f64,
    /// Energies.
    pub energy: Energy,
}

/// What the scheme itself does to an undamped linear oscillation, exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AlgorithmicError {
    /// Frequency over the true one.
    pub frequency_ratio: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
}

/// A motion followed.
#[derive(Clone, Debug)]
pub struct Transient {
    /// Step (s).
    pub step: f64,
    /// Uniform in time, the first at the start.
    pub samples: Vec<Sample>,
    /// Why it ended before its time.
    pub failure: Option<Failure>,
    /// Steps that had to be halved.
    pub halved_steps: usize,
    /// Largest residual of a step, relative to the inertia that the tolerance refers to (energy norm).
    pub residual: f64,
    /// What the scheme does to the mode.
    pub algorithmic: AlgorithmicError,
    /// Work done.
    pub effort: Effort,
}

impl Transient {
    /// Largest change of [`Energy::balance`] relative to the largest energy that was in the motion.
    pub fn energy_error(&self) -> f64 {
        let Some(first) = self.samples.first() else { return 0.0 };
        let put_in = |s: &Sample| s.energy.kinetic + s.energy.elastic;
        let most = self.samples.iter().map(put_in).fold(0.0, f64::max);
        let change = |s: &Sample| (s.energy.balance() - first.energy.balance()).abs();
        self.samples.iter().map(change).fold(0.0, f64::max) / most
    }

    /// Share of the kinetic energy outside the mode, over all samples.
    pub fn share_elsewhere(&self) -> f64 {
        let sum = |part: fn(&Energy) -> f64| self.samples.iter().map(|s| part(&s.energy)).sum::<f64>();
        sum(|e| e.kinetic_elsewhere) / sum(|e| e.kinetic)
    }
}

/// Weights of the generalised-alpha method for a spectral radius at infinite frequency.
#[derive(Clone, Copy, Debug)]
struct Scheme {
    alpha_m: f64,
    alpha_f: f64,
    beta: f64,
    gamma: f64,
}

impl Scheme {
    fn new(spectral_radius: f64) -> Self {
        let rho = spectral_radius;
        let (alpha_m, alpha_f) = ((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0));
        Self {
            alpha_m,
            alpha_f,
            beta: 0.25 * (1.0 - alpha_m + alpha_f).powi(2),
            gamma: 0.5 - alpha_m + alpha_f,
        }
    }
}

/// What the generalised-alpha method does to an undamped oscillation in `steps_per_period` steps per period: from the root
/// of its characteristic polynomial
/// `((1-a_m) z + a_m) (z-1)^2 + W^2 ((1-a_f) z + a_f) (b z^2 + (1/2+g-2b) z + 1/2-g+b)`, `W = 2 pi / steps_per_period`.
pub fn algorithmic_error(spectral_radius: f64, steps_per_period: f64) -> AlgorithmicError {
    let s = Scheme::new(spectral_radius);
    let angle = TAU / steps_per_period;
    let polynomial = |z: c64| {
        let newmark = z * z * s.beta + z * (0.5 + s.gamma - 2.0 * s.beta) + (0.5 - s.gamma + s.beta);
        let inertia = z * (1.0 - s.alpha_m) + s.alpha_m;
        let restoring = z * (1.0 - s.alpha_f) + s.alpha_f;
        inertia * (z - 1.0) * (z - 1.0) + restoring * newmark * (angle * angle)
    };
    // Secants in the complex plane from the true root and a neighbour.
    let (mut before, mut z) = (c64::cis(1.001 * angle), c64::cis(angle));
    let mut value = polynomial(before);
    for _ in 0..50 {
        let next = polynomial(z);
        let slope = (next - value) / (z - before);
        (before, value) = (z, next);
        let change = next / slope;
        if !(change.norm() > 0.0) {
            break;
        }
        z -= change;
        if change.norm() <= f64::EPSILON * angle {
            break;
        }
    }
    let exponent = z.ln();
    AlgorithmicError {
        frequency_ratio: exponent.norm() / angle,
        damping_ratio: -exponent.re / exponent.norm(),
    }
}

/// Follows the motion of a structure, whose displacement, velocity and acceleration along `row` are recorded; `observe`
/// hears of every sample and may stop the run.
///
/// # Errors
/// Sizes that do not match, settings outside their range, [`Error::Dense`], and [`Error::Interrupted`] if the observer
/// stopped the run. A step that does not converge, however often halved, ends the record with [`Transient::failure`].
pub fn run<F: HystereticForce>(
    structure: &Linearisation<'_, F::State>,
    force: &F,
    row: &[f64],
    start: &Start,
    settings: &Settings,
    observe: &mut dyn FnMut(&Sample) -> ControlFlow<()>,
) -> Result<Transient, Error> {
    check(structure, row, start, settings)?;
    let mode = Mode::try_new(structure, settings.mode)?;
    let step = TAU / mode.eigenvalue.sqrt() / settings.steps_per_period as f64;
    let mut integrator = Integrator::new(structure, force, &mode, start, settings);
    let mut transient = Transient {
        step,
        samples: Vec::new(),
        failure: None,
        halved_steps: 0,
        residual: 0.0,
        algorithmic: algorithmic_error(settings.spectral_radius, settings.steps_per_period as f64),
        effort: Effort::default(),
    };
    let mut failure = integrator.begin().err();
    for number in 0..=settings.steps_per_period * settings.periods {
        if failure.is_none() && number > 0 {
            failure = integrator.advance(step, 0)?.err();
        }
        if failure.is_some() {
            break;
        }
        // Without the round-off of summing steps.
        integrator.time = number as f64 * step;
        let sample = integrator.sample(row);
        transient.samples.push(sample);
        if observe(&sample).is_break() {
            return Err(Error::Interrupted);
        }
    }
    Ok(Transient {
        failure,
        halved_steps: integrator.halved_steps,
        residual: integrator.residual,
        effort: integrator.walk.effort,
        ..transient
    })
}

fn check<S>(structure: &Linearisation<'_, S>, row: &[f64], start: &Start, settings: &Settings) -> Result<(), Error> {
    let n = structure.shapes.nrows();
    check_size("the row observed", row.len(), n)?;
    let refuse = |field, value, requirement| {
        Err(Error::Setting {
            field,
            value,
            requirement,
        })
    };
    if settings.steps_per_period < 8 {
        return refuse("steps_per_period", settings.steps_per_period as f64, "at least 8");
    }
    if !(0.0..=1.0).contains(&settings.spectral_radius) {
        return refuse("spectral_radius", settings.spectral_radius, "between 0 and 1");
    }
    for (field, ratio) in [
        ("background_damping", settings.background_damping),
        ("other_damping", settings.other_damping),
    ] {
        if !(0.0..1.0).contains(&ratio) {
            return refuse(field, ratio, "from 0 to below 1");
        }
    }
    let positive = |value: f64| value > 0.0 && value.is_finite();
    match start {
        Start::Release { modal_force } if !positive(*modal_force) => {
            refuse("modal_force", *modal_force, "positive and finite")
        }
        Start::Pulse { impulse, .. } if !positive(*impulse) => refuse("impulse", *impulse, "positive and finite"),
        Start::Pulse { duration, .. } if !positive(*duration) => refuse("duration", *duration, "positive and finite"),
        Start::Pulse { point, .. } => check_size("the row struck", point.len(), n),
        Start::Release { .. } => Ok(()),
    }
}

/// The structure of one step length: its stiffness with inertia and damping, and that stuck.
struct Level {
    step: f64,
    /// Factors of mass and damping in the stiffness, `c` and `c'`.
    inertia: f64,
    damping: f64,
    stiffness: Mat<f64>,
    stuck: Stuck,
    round_off: f64,
    /// Energy norm of the peak force of the pulse.
    pulse: f64,
}

/// Viscous modal damping: `C = sum 2 zeta omega_i (M phi_i) (M phi_i)^T`.
struct ModalDamping {
    /// `2 zeta omega_i` and `M phi_i`.
    modes: Vec<(f64, Vec<f64>)>,
}

impl ModalDamping {
    /// `C x`.
    fn product(&self, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; x.len()];
        for (factor, momentum) in &self.modes {
            add(&mut out, factor * dot(momentum, x), momentum);
        }
        out
    }
}

/// State and structure of a motion.
struct Integrator<'a, F: HystereticForce> {
    structure: &'a Linearisation<'a, F::State>,
    force: &'a F,
    mode: &'a Mode,
    start: &'a Start,
    settings: &'a Settings,
    scheme: Scheme,
    stiffness: Symmetric,
    mass: Symmetric,
    damping: ModalDamping,
    /// By halvings of the step; the shorter ones are made when needed.
    levels: Vec<Level>,
    walk: Walk<F>,
    time: f64,
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
    residual: f64,
    halved_steps: usize,
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
    fn new(
        structure: &'a Linearisation<'a, F::State>,
        force: &'a F,
        mode: &'a Mode,
        start: &'a Start,
        settings: &'a Settings,
    ) -> Self {
        let n = mode.shape.len();
        let mass = Symmetric::from_lower(structure.mass);
        let mut damping = ModalDamping { modes: Vec::new() };
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
                damping.modes.push((2.0 * ratio * eigenvalue.max(0.0).sqrt(), momentum));
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
            stiffness: Symmetric::from_lower(structure.stiffness),
            mass,
            damping,
            levels: Vec::new(),
            walk: Walk::new(force, Motion::zero(n), structure.state.clone()),
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
    fn begin(&mut self) -> Result<(), Failure> {
        let Start::Release { modal_force } = *self.start else {
            return Ok(());
        };
        let walk = Walk::new(self.force, self.walk.motion.clone(), self.structure.state.clone());
        let solution = (self.settings.solver, NewtonSettings::default());
        let equilibrium = self.structure.equilibrium(self.force);
        let mut path = Path::new(equilibrium, &self.mode.unit, modal_force, solution, walk);
        for step in 1..=LOADING_STEPS {
            path.advance(modal_force * step as f64 / LOADING_STEPS as f64)?;
            path.walk.commit();
        }
        self.walk = path.walk;
        self.displacement.copy_from_slice(&self.walk.motion.v);
        self.stiffness.product_into(&self.displacement, &mut self.elastic_force);
        self.mass.product_into(&self.displacement, &mut self.mass_displacement);
        self.acceleration = combine([(-modal_force, &self.mode.shape)]);
        self.mass_acceleration = combine([(-modal_force, &self.mode.unit.p)]);
        self.contact = self.contact_change();
        self.energy.elastic = 0.5 * dot(&self.displacement, &self.elastic_force);
        Ok(())
    }

    /// Change of the contact force from the static state, at the last solution.
    fn contact_change(&self) -> Vec<f64> {
        let pairs = self.walk.contact.iter().zip(&self.structure.contact_force);
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
        let mut stiffness = self.structure.stiffness + faer::Scale(inertia) * self.structure.mass;
        for (factor, momentum) in &self.damping.modes {
            for (j, column) in stiffness.col_iter_mut().enumerate() {
                let share = damping * factor * momentum[j];
                column.iter_mut().zip(momentum).for_each(|(k, p)| *k += share * p);
            }
        }
        let pattern = self.force.pattern();
        let (_, stuck) = Stuck::try_new(stiffness.as_ref(), pattern, self.structure.stuck.tangent())?;
        let reference = &self.structure.displacement[..self.force.n_dofs()];
        self.levels.push(Level {
            step,
            inertia,
            damping,
            stiffness,
            round_off: stuck.round_off(pattern, reference, &self.structure.contact_force),
            pulse: match self.start {
                Start::Pulse { point, .. } => self.peak_force() * stuck.response(point).norm(),
                Start::Release { .. } => 0.0,
            },
            stuck,
        });
        Ok(())
    }

    fn peak_force(&self) -> f64 {
        match self.start {
            Start::Pulse { impulse, duration, .. } => 0.5 * PI * impulse / duration,
            Start::Release { .. } => 0.0,
        }
    }

    /// External force along its row (N).
    fn external_force(&self, time: f64) -> f64 {
        match self.start {
            Start::Pulse { duration, .. } if time < *duration => self.peak_force() * (PI * time / duration).sin(),
            _ => 0.0,
        }
    }

    /// One step, in halves if it must be. The outer result is that of a factorisation.
    fn advance(&mut self, step: f64, halvings: usize) -> Result<Result<(), Failure>, Error> {
        self.level(halvings, step)?;
        let Err(failure) = self.step(halvings) else {
            return Ok(Ok(()));
        };
        if halvings == self.settings.newton.max_halvings {
            return Ok(Err(failure));
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
        let Scheme {
            alpha_m,
            alpha_f,
            beta,
            gamma,
        } = self.scheme;
        let level = &self.levels[index];
        let h = level.step;
        // Displacement and velocity at the end of the step, but for the acceleration there.
        let weights = [1.0, h, h * h * (0.5 - beta)];
        let [a, b, c] = weights;
        let ahead = combine([(a, &self.displacement), (b, &self.velocity), (c, &self.acceleration)]);
        let mass_ahead = combine([
            (a, &self.mass_displacement),
            (b, &self.mass_velocity),
            (c, &self.mass_acceleration),
        ]);
        let (old, new) = (alpha_f / (1.0 - alpha_f), 1.0 / (1.0 - alpha_f));
        let mut load = combine([
            (level.inertia, &mass_ahead),
            (-alpha_m * new, &self.mass_acceleration),
            (-old, &self.elastic_force),
        ]);
        add(&mut load, -old, &self.contact);
        let (force_before, force_after) = (self.external_force(self.time), self.external_force(self.time + h));
        if let Start::Pulse { point, .. } = self.start {
            add(&mut load, force_after + old * force_before, point);
        }
        if !self.damping.modes.is_empty() {
            let rates = combine([
                (level.damping, &ahead),
                (-1.0 - old, &self.velocity),
                (-h * (1.0 - gamma), &self.acceleration),
            ]);
            add(&mut load, 1.0, &self.damping.product(&rates));
        }

        let n = self.displacement.len();
        let mut here = Motion {
            v: self.displacement.clone(),
            p: combine([(1.0, &self.elastic_force), (level.inertia, &self.mass_displacement)]),
        };
        let pattern = self.force.pattern();
        pattern.add_product(level.stuck.tangent(), &self.displacement, &mut here.p);
        if !self.damping.modes.is_empty() {
            add(&mut here.p, level.damping, &self.damping.product(&self.displacement));
        }
        let equilibrium = Equilibrium {
            stiffness: level.stiffness.as_ref(),
            force: self.force,
            stuck: &level.stuck,
            reference: &self.structure.displacement[..self.force.n_dofs()],
            reference_force: &self.structure.contact_force,
            round_off: level.round_off,
        };
        // The inertia of a motion with this energy at the frequency of the mode.
        let energy = self.energy.kinetic + self.energy.elastic;
        let eigenvalue = self.mode.eigenvalue;
        let inertia = (2.0 * energy * eigenvalue / (eigenvalue + level.inertia)).sqrt();
        let pulse = if force_after > 0.0 { level.pulse } else { 0.0 };
        let goal = Goal {
            factor: 1.0,
            load: Load::Pattern(&load),
            scale: inertia.max(pulse),
            sticking: Sticking::Coulomb,
        };
        let solve = |walk: &mut Walk<F>| equilibrium.solve(walk, &goal, self.settings.solver, &self.settings.newton);
        // A cubic through the last full steps; where it leads astray, the displacement at hand.
        let walk = &mut self.walk;
        walk.motion.copy_from(&here);
        let outcome = match (&self.previous[..], index) {
            ([first, second, third], 0) => {
                walk.motion.scale(4.0);
                walk.motion.add(-6.0, first);
                walk.motion.add(4.0, second);
                walk.motion.add(-1.0, third);
                solve(walk).or_else(|_| {
                    walk.motion.copy_from(&here);
                    solve(walk)
                })
            }
            _ => solve(walk),
        };
        let converged = outcome?;
        self.residual = self.residual.max(converged.residual);
        walk.commit();

        let displacement = walk.motion.v.clone();
        let advance = combine([(1.0, &displacement), (-1.0, &self.displacement)]);
        let contact = self.contact_change();
        let shared = &advance[..contact.len()];
        let work = |before: &[f64], after: &[f64], way: &[f64]| 0.5 * (dot(before, way) + dot(after, way));
        self.energy.contact += work(&self.contact, &contact, shared);
        if let Start::Pulse { point, .. } = self.start {
            self.energy.external += 0.5 * (force_before + force_after) * dot(point, &advance);
        }
        let mut mass_displacement = vec![0.0; n];
        self.mass.product_into(&displacement, &mut mass_displacement);
        self.stiffness.product_into(&displacement, &mut self.elastic_force);
        // Newmark's formulas, for the vectors and their products with the mass.
        let newmark = |at: &[f64], ahead: &[f64], velocity: &[f64], acceleration: &[f64]| {
            let scale = 1.0 / (beta * h * h);
            let next = combine([(scale, at), (-scale, ahead)]);
            let velocity = combine([(1.0, velocity), (h * (1.0 - gamma), acceleration), (h * gamma, &next)]);
            (velocity, next)
        };
        let (velocity, acceleration) = newmark(&displacement, &ahead, &self.velocity, &self.acceleration);
        let (mass_velocity, mass_acceleration) = newmark(
            &mass_displacement,
            &mass_ahead,
            &self.mass_velocity,
            &self.mass_acceleration,
        );
        if !self.damping.modes.is_empty() {
            let (before, after) = (self.damping.product(&self.velocity), self.damping.product(&velocity));
            self.energy.viscous += work(&before, &after, &advance);
        }
        if index == 0 {
            self.previous.insert(0, here);
            self.previous.truncate(3);
        }
        self.energy.elastic = 0.5 * dot(&displacement, &self.elastic_force);
        self.energy.kinetic = 0.5 * dot(&velocity, &mass_velocity);
        let modal = dot(&self.mode.unit.p, &velocity);
        self.energy.kinetic_elsewhere = (self.energy.kinetic - 0.5 * modal * modal).max(0.0);
        self.displacement = displacement;
        self.velocity = velocity;
        self.acceleration = acceleration;
        self.mass_displacement = mass_displacement;
        self.mass_velocity = mass_velocity;
        self.mass_acceleration = mass_acceleration;
        self.contact = contact;
        self.time += h;
        Ok(())
    }

    fn sample(&self, row: &[f64]) -> Sample {
        Sample {
            time: self.time,
            displacement: dot(row, &self.displacement),
            velocity: dot(row, &self.velocity),
            acceleration: dot(row, &self.acceleration),
            energy: self.energy,
        }
    }
}
