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

mod integrator;
mod motion;
mod scheme;

use crate::Error;
use crate::error::check_size;
use crate::force::HystereticForce;
use crate::modes::{Linearisation, Mode};
use crate::newton::Effort;
use integrator::Integrator;
pub use motion::{Energy, Sample, Settings, Start, Transient};
pub use scheme::{AlgorithmicError, algorithmic_error};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Most steps of a motion: a hundred thousand periods of a hundred steps, whose record takes 1 GB. Free motions have decayed long before.
pub const MOST_STEPS: usize = 10_000_000;

/// Periods over which the mean is taken that a motion settles at.
const SETTLED: usize = 2;

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
    let mode = Mode::try_new(structure, force.pattern(), settings.mode)?;
    let step = TAU / mode.eigenvalue.sqrt() / settings.steps_per_period as f64;
    let mut integrator = Integrator::new(structure, force, &mode, start, settings);
    let mut transient = Transient {
        step,
        samples: Vec::new(),
        settled: vec![0.0; structure.shapes.nrows()],
        failure: None,
        halved_steps: 0,
        residual: 0.0,
        algorithmic: algorithmic_error(settings.spectral_radius, settings.steps_per_period as f64),
        effort: Effort::default(),
    };
    let mut failure = integrator.begin().err();
    let steps = settings.steps_per_period * settings.periods;
    let last = (SETTLED * settings.steps_per_period).min(steps).max(1);
    for number in 0..=steps {
        if failure.is_none() && number > 0 {
            failure = integrator.advance(step, 0)?.err();
        }
        if failure.is_some() {
            break;
        }
        // Without the round-off of summing steps.
        integrator.time = number as f64 * step;
        if number + last > steps {
            let moved = transient.settled.iter_mut().zip(integrator.displacement());
            moved.for_each(|(mean, u)| *mean += u / last as f64);
        }
        let sample = integrator.sample(row);
        transient.samples.push(sample);
        if observe(&sample).is_break() {
            return Err(Error::Interrupted);
        }
    }
    if failure.is_some() && structure.limits.stops() {
        return Err(Error::Interrupted);
    }
    Ok(Transient {
        failure,
        halved_steps: integrator.halved_steps,
        residual: integrator.residual,
        effort: integrator.sequence.effort,
        ..transient
    })
}

fn check<S>(structure: &Linearisation<'_, S>, row: &[f64], start: &Start, settings: &Settings) -> Result<(), Error> {
    let n = structure.shapes.nrows();
    check_size("the row observed", row.len(), n)?;
    structure
        .dampers
        .iter()
        .try_for_each(|damper| check_size("the row of a damper", damper.len(), n))?;
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
    if settings.steps_per_period.saturating_mul(settings.periods) > MOST_STEPS {
        return refuse(
            "periods",
            settings.periods as f64,
            "so few that there are at most 1e7 steps in all; follow fewer periods, or take fewer steps for each",
        );
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
        Start::Driven { amplitude, .. } if !positive(*amplitude) => {
            refuse("amplitude", *amplitude, "positive and finite")
        }
        Start::Driven { omega, .. } if !positive(*omega) => refuse("omega", *omega, "positive and finite"),
        Start::Driven { point, motion, .. } => {
            check_size("the row driven", point.len(), n)?;
            motion
                .iter()
                .try_for_each(|part| check_size("the motion at the start", part.len(), n))
        }
        Start::Record { step, .. } if !positive(*step) => refuse("step", *step, "positive and finite"),
        Start::Record { values, point, .. } => {
            if let Some(wrong) = values.iter().find(|value| !value.is_finite()) {
                return refuse("values", *wrong, "finite");
            }
            if values.iter().all(|value| *value == 0.0) {
                return refuse("values", 0.0, "not all zero");
            }
            check_size("the row loaded", point.len(), n)
        }
        Start::Release { .. } => Ok(()),
    }
}
