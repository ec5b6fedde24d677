//! Responses to a harmonic force against the frequency: at a given amplitude of the force, or at a given one of the response, for which the force is
//! found.
//!
//! `M u'' + C u' + K u + F(u) = f + P (e_c cos(Omega t) + e_s sin(Omega t))`, with `P = a Omega^2` under a rotating unbalance `a`. The curve is followed by its arc length, in which a relative change of the motion
//! (energy norm) and one of the frequency count as many steps as their largest allowed sizes, so that it goes around turning points and
//! every resonance is resolved, however sharp. At a given amplitude `|r^T V_1| = x` of the response, the force is one more unknown; such curves do not turn
//! back where those of a given force do.

use crate::Error;
use crate::aft::Sampling;
use crate::backbone::{LARGEST_DRIFT, check_sampling};
use crate::error::require;
use crate::force::PointwiseForce;
use crate::harmonics::Harmonics;
use crate::load::Load;
use crate::solve::{BUDGET, Closure, Condition, Converged, Effort, Failure, NewtonSettings, Reason, solve};
use crate::system::{Parameter, System, Unknown};
use cqsma_solver::Linearisation;
use std::ops::ControlFlow;

/// Settings of a forced response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// First and last angular frequency (rad/s); the curve is followed from the one to the other.
    pub range: [f64; 2],
    /// Harmonics, samples and periods.
    pub sampling: Sampling,
    /// Viscous damping ratio of the linear modes beside friction.
    pub background: f64,
    /// Factors of mass (1/s) and of the stiffness without contact (s) in a proportional (Rayleigh) damping beside it.
    pub rayleigh: [f64; 2],
    /// Largest relative change of the motion from point to point.
    pub amplitude_step: f64,
    /// Largest relative change of the frequency.
    pub frequency_step: f64,
    /// Most points of a curve.
    pub max_points: usize,
    /// Newton's method.
    pub newton: NewtonSettings,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            range: [0.0; 2],
            sampling: Sampling {
                harmonics: 3,
                samples: 128,
                periods: 2,
            },
            background: 0.0,
            rayleigh: [0.0; 2],
            amplitude_step: 0.2,
            frequency_step: 0.02,
            max_points: 2000,
            newton: NewtonSettings::default(),
        }
    }
}

/// What is held along a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Held<'a> {
    /// The amplitude of the load.
    Force(f64),
    /// The amplitude of the first harmonic of a displacement; the force follows.
    Response {
        /// The displacement, as a row over the coordinates.
        row: &'a [f64],
        /// Its amplitude (m).
        amplitude: f64,
    },
}

/// A point of a response curve.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Point {
    /// Angular frequency of the force (rad/s).
    pub omega: f64,
    /// Amplitude of the load: of a force (N), or of an unbalance (kg m).
    pub force: f64,
    /// Harmonics of the displacements from the static state (m).
    pub displacement: Harmonics,
    /// Residual relative to the elastic forces (energy norm).
    pub residual: f64,
    /// Change of the tractions from the last period to the one before relative to their range.
    pub drift: f64,
    /// What the force gives over a period, over `2 pi omega^2 V_1^H M V_1`: the damping ratio of the motion.
    pub damping_ratio: f64,
    /// What contact and viscous damping take over a period less what the force gives, over `2 pi omega^2 V_1^H M V_1`: an error in the unit of damping
    /// ratios.
    pub energy_error: f64,
    /// Whether the frequency turns back here.
    pub turns: bool,
}

/// A response curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Points in the order in which they follow one another on the curve.
    pub points: Vec<Point>,
    /// Why the curve ends before the last frequency, if it does.
    pub failure: Option<Failure>,
    /// Work done.
    pub effort: Effort,
}

impl Curve {
    /// Puts a point behind the one with this index.
    pub fn insert(&mut self, after: usize, point: Point) {
        self.points.insert(after + 1, point);
        mark_turns(&mut self.points);
    }
}

/// Follows the response to a load, with what is `held`; `observe` hears of every point and may stop the run.
///
/// # Errors
/// Settings or sizes that do not fit, and [`Error::Interrupted`]. A curve that ends early says why.
pub fn follow<F: PointwiseForce>(
    line: &Linearisation<'_, F::State>,
    law: &F,
    load: &Load,
    held: Held<'_>,
    settings: &Settings,
    observe: &mut dyn FnMut(&Point) -> ControlFlow<()>,
) -> Result<Curve, Error> {
    let mut tracer = Tracer::new(line, law, load, held, settings)?;
    let mut points = Vec::new();
    let failure = match tracer.trace(&mut points, observe) {
        Ok(()) => None,
        Err(Stop::Failure(failure)) if !line.limits.stops() => Some(failure),
        Err(_) => return Err(Error::Interrupted),
    };
    let mut effort = tracer.before;
    effort += tracer.effort;
    Ok(Curve {
        points,
        failure,
        effort,
    })
}

/// The condition that a response has a share of its amplitude, if it is held; there are `free` parameters beside the motion.
pub(crate) fn amplitude(unknown: &Unknown, held: Held<'_>, share: f64, free: usize) -> Option<Condition> {
    let Held::Response { row, amplitude } = held else {
        return None;
    };
    let target = share * amplitude;
    let along = unknown.v.along(row);
    let size = along[1].hypot(along[2]);
    let mut gradient = Harmonics::zeros(unknown.v.size(), unknown.v.count());
    for column in [1, 2] {
        let factor = along[column] / (size * target);
        let values = gradient.column_mut(column).iter_mut().zip(row);
        values.for_each(|(to, r)| *to = factor * r);
    }
    Some(Condition {
        value: size / target - 1.0,
        gradient,
        along: vec![0.0; free],
    })
}

fn check<S>(line: &Linearisation<'_, S>, load: &Load, held: Held<'_>, settings: &Settings) -> Result<(), Error> {
    let n = line.shapes.nrows();
    let loads = [&load.cosine, &load.sine].map(|row| ("the load", row));
    let dampers = line.dampers.iter().map(|row| ("the row of a damper", row));
    for (what, row) in loads.into_iter().chain(dampers) {
        if row.len() != n {
            return Err(Error::Size {
                what,
                found: row.len(),
                expected: n,
            });
        }
    }
    check_sampling(settings.sampling)?;
    let (field, level) = match held {
        Held::Force(force) => ("force", force),
        Held::Response { row, amplitude } if row.len() == n => ("amplitude", amplitude),
        Held::Response { row, .. } => {
            return Err(Error::Size {
                what: "the displacement held",
                found: row.len(),
                expected: n,
            });
        }
    };
    require(level > 0.0 && level.is_finite(), field, level, "positive and finite")?;
    for omega in settings.range {
        require(
            omega > 0.0 && omega.is_finite(),
            "frequency",
            omega,
            "positive and finite",
        )?;
    }
    let [from, to] = settings.range;
    require(
        from != to,
        "frequency",
        to,
        "another one than that which the curve begins with",
    )?;
    for (field, step) in [
        ("amplitude_step", settings.amplitude_step),
        ("frequency_step", settings.frequency_step),
    ] {
        require(step > 0.0 && step <= 1.0, field, step, "above 0 and at most 1")?;
    }
    Ok(())
}

/// Why tracing ends early.
enum Stop {
    Failure(Failure),
    Interrupted,
}

impl From<Failure> for Stop {
    fn from(failure: Failure) -> Self {
        Self::Failure(failure)
    }
}

/// The length of steps of the frequency alone.
const FIRST: f64 = 0.1;

/// Steps are not made shorter than this.
const SHORTEST: f64 = 1e-5;

/// Iterations far from the solution beyond which steps are not made longer.
const EASY: usize = 3;

/// Krylov steps of a point beyond which the next one is preconditioned with its mean tangent, and not with that of the stuck structure.
const HARD: usize = 40;

/// Most times that the force is halved to reach the first point.
const MAX_RAMP: i32 = 8;

pub(crate) struct Tracer<'a, 's, F: PointwiseForce> {
    pub(crate) system: System<'a, F>,
    pub(crate) settings: &'s Settings,
    pub(crate) held: Held<'s>,
    /// Part of the amplitude held that is asked for at the moment.
    share: f64,
    /// For the point at hand.
    pub(crate) effort: Effort,
    /// For all before it.
    before: Effort,
}

/// Direction of the curve at a point, of unit length.
pub(crate) struct Tangent {
    v: Harmonics,
    p: Harmonics,
    /// Of the logarithm of the frequency.
    log_omega: f64,
    /// Of the force (N).
    force: f64,
    /// Distance of the points that it was found from.
    length: f64,
}

impl Tangent {
    /// Goes along it.
    fn lead(&self, way: f64, to: &mut Unknown) {
        to.v.add(way, &self.v);
        to.p.add(way, &self.p);
        *to.at_mut(Parameter::Square) *= (2.0 * way * self.log_omega).exp();
        *to.at_mut(Parameter::Force) += way * self.force;
    }
}

impl<'a, 's, F: PointwiseForce> Tracer<'a, 's, F> {
    pub(crate) fn new(
        line: &'a Linearisation<'a, F::State>,
        law: &'a F,
        load: &Load,
        held: Held<'s>,
        settings: &'s Settings,
    ) -> Result<Self, Error> {
        check(line, load, held, settings)?;
        let (background, rayleigh, sampling) = (settings.background, settings.rayleigh, settings.sampling);
        Ok(Self {
            system: System::new(line, law, load.clone(), background, rayleigh, sampling).with_dampers(),
            settings,
            held,
            share: 1.0,
            effort: Effort::default(),
            before: Effort::default(),
        })
    }

    fn trace(
        &mut self,
        points: &mut Vec<Point>,
        observe: &mut dyn FnMut(&Point) -> ControlFlow<()>,
    ) -> Result<(), Stop> {
        let [from, to] = self.settings.range;
        let direction = (to - from).signum();
        let (mut here, found) = self.first(from)?;
        let mut report = |point: Point, points: &mut Vec<Point>| {
            let flow = observe(&point);
            points.push(point);
            if flow.is_break() {
                Err(Stop::Interrupted)
            } else {
                Ok(())
            }
        };
        report(self.point(&here, &found), points)?;
        // The first step is one of the frequency alone.
        let mut step = FIRST;
        let mut tangent: Option<Tangent> = None;
        // The one before it.
        let mut earlier: Option<Tangent> = None;
        let mut ahead = direction;
        while points.len() < self.settings.max_points {
            let mut next = here.clone();
            let predicted = match &tangent {
                None => {
                    let square = next.at(Parameter::Square);
                    *next.at_mut(Parameter::Square) =
                        square * (2.0 * ahead * step * self.settings.frequency_step).exp();
                    None
                }
                Some(tangent) => {
                    tangent.lead(step, &mut next);
                    if let Some(earlier) = &earlier {
                        // The parabola through the last three points.
                        let bend = step * (step + tangent.length) / (earlier.length + tangent.length);
                        tangent.lead(bend, &mut next);
                        earlier.lead(-bend, &mut next);
                    }
                    // Its round-off would grow from prediction to prediction.
                    self.system.restore(&mut next);
                    Some((next.clone(), tangent))
                }
            };
            let corrected = self.correct(&mut next, predicted.as_ref().map(|(at, tangent)| (at, *tangent)));
            let length = self.length(&here, &next);
            let outcome = match corrected {
                // A load that changes its sign is that of the same motions half a period later: the curve's mirror image.
                Ok(found) if length <= longest(step, &tangent, points.len()) && next.at(Parameter::Force) > 0.0 => {
                    Ok(found)
                }
                Ok(_) => Err(Failure {
                    reason: Reason::StepTooSmall,
                    history: Vec::new(),
                }),
                Err(failure) => Err(failure),
            };
            match outcome {
                Err(failure) if failure.reason.is_final() => return Err(failure.into()),
                Err(failure) => {
                    step *= 0.5;
                    if step < SHORTEST {
                        // At a corner, as where a point begins to slip, the direction of the step before leads off the curve.
                        let Some(before) = tangent.take() else {
                            return Err(Failure {
                                reason: Reason::StepTooSmall,
                                history: failure.history,
                            }
                            .into());
                        };
                        earlier = None;
                        ahead = before.log_omega.signum();
                        step = FIRST;
                    }
                    continue;
                }
                Ok(found) => {
                    let omega = next.at(Parameter::Square).sqrt();
                    if direction * (omega - to) >= 0.0 {
                        // The last point lies at the last frequency.
                        let mut last = next.clone();
                        *last.at_mut(Parameter::Square) = to * to;
                        match self.correct(&mut last, None) {
                            Ok(found) => report(self.point(&last, &found), points)?,
                            Err(failure) if failure.reason == Reason::Interrupted => return Err(Stop::Interrupted),
                            Err(_) => report(self.point(&next, &found), points)?,
                        }
                        return Ok(());
                    }
                    report(self.point(&next, &found), points)?;
                    let before = points.len().saturating_sub(3);
                    mark_turns(&mut points[before..]);
                    if direction * (omega - from) < -1e-9 * from {
                        return Err(Failure {
                            reason: Reason::LeftRange,
                            history: vec![found.residual],
                        }
                        .into());
                    }
                    let easy = found.far <= EASY;
                    self.settle(&next.v);
                    earlier = tangent.replace(self.secant(&here, &next, length));
                    here = next;
                    if easy {
                        step = (1.5 * step).min(1.0);
                    } else {
                        step = (0.8 * length).clamp(SHORTEST, 1.0);
                    }
                }
            }
        }
        Err(Failure {
            reason: Reason::IterationLimit,
            history: Vec::new(),
        }
        .into())
    }

    /// Closes the account of a motion that was found, and takes its mean tangent for the preconditioner if it was hard to find.
    pub(crate) fn settle(&mut self, motion: &Harmonics) {
        if self.effort.krylov_steps > HARD {
            self.system.adapt(motion);
        }
        self.before += std::mem::take(&mut self.effort);
    }

    pub(crate) fn point(&self, unknown: &Unknown, found: &Converged) -> Point {
        let [damping_ratio, energy_error] = self.system.damping_ratio(unknown, &found.evaluation);
        Point {
            omega: unknown.at(Parameter::Square).sqrt(),
            force: unknown.at(Parameter::Force),
            displacement: unknown.v.clone(),
            residual: found.residual,
            drift: found.drift,
            damping_ratio,
            energy_error,
            turns: false,
        }
    }

    /// The point at the first frequency, under a force, or at a response, that grows where the whole of it at once is too much.
    fn first(&mut self, omega: f64) -> Result<(Unknown, Converged), Failure> {
        let n = self.system.size();
        let count = self.system.sampling().harmonics;
        let mut halvings = 0;
        let mut unknown = Unknown {
            v: Harmonics::zeros(n, count),
            p: Harmonics::zeros(n, count),
            parameters: [omega * omega, 0.0, 0.0],
        };
        let mut reached = 0.0;
        let mut share = 1.0;
        loop {
            let mut trial = unknown.clone();
            let level = reached + share * (1.0 - reached);
            if reached > 0.0 {
                trial.v.scale(level / reached);
                trial.p.scale(level / reached);
                *trial.at_mut(Parameter::Force) *= level / reached;
            } else {
                self.stuck_response(&mut trial, level);
            }
            self.share = level;
            if let Held::Force(force) = self.held {
                *trial.at_mut(Parameter::Force) = level * force;
            }
            match self.correct(&mut trial, None) {
                Ok(found) if share >= 1.0 => return Ok((trial, found)),
                Ok(_) => {
                    (unknown, reached) = (trial, level);
                    share = (2.0 * share).min(1.0);
                }
                Err(failure) => {
                    halvings += 1;
                    if halvings > MAX_RAMP || failure.reason.is_final() {
                        return Err(failure);
                    }
                    share *= 0.5;
                }
            }
        }
    }

    /// What the stuck structure does under a share of what is held, by the preconditioner: modes near resonance and static rest.
    fn stuck_response(&self, unknown: &mut Unknown, share: f64) {
        let force = match self.held {
            Held::Force(force) => share * force,
            Held::Response { .. } => 1.0,
        };
        let mut load = Harmonics::zeros(self.system.size(), unknown.v.count());
        self.system.load.add(force, unknown.at(Parameter::Square), &mut load);
        let response = self.system.solve_stuck(&load);
        [unknown.v, unknown.p] = self.system.precondition(unknown, &load, &response);
        *unknown.at_mut(Parameter::Force) = force;
        if let Held::Response { row, amplitude } = self.held {
            let along = unknown.v.along(row);
            let factor = share * amplitude / along[1].hypot(along[2]);
            unknown.v.scale(factor);
            unknown.p.scale(factor);
            *unknown.at_mut(Parameter::Force) *= factor;
        }
    }

    /// Solves at the frequency of the guess, or on the plane across the tangent through the prediction.
    pub(crate) fn correct(
        &mut self,
        unknown: &mut Unknown,
        predicted: Option<(&Unknown, &Tangent)>,
    ) -> Result<Converged, Failure> {
        let newton = &self.settings.newton;
        let (held, share) = (self.held, self.share);
        let is_free = matches!(held, Held::Response { .. });
        let Some((at, tangent)) = predicted else {
            let free = if is_free { &[Parameter::Force][..] } else { &[] };
            let closure = Closure {
                free,
                conditions: &|unknown, _| amplitude(unknown, held, share, free.len()).into_iter().collect(),
            };
            let found = solve(&self.system, unknown, &closure, newton, &mut self.effort, BUDGET[0])?;
            return periodic(found);
        };
        let scale = self.metric(at);
        let settings = self.settings;
        let free = match is_free {
            true => &[Parameter::Square, Parameter::Force][..],
            false => &[Parameter::Square],
        };
        let conditions = |unknown: &Unknown, _: &Harmonics| {
            let mut change = unknown.v.clone();
            change.add(-1.0, &at.v);
            let a = unknown.at(Parameter::Square);
            let log = 0.5 * (a / at.at(Parameter::Square)).ln();
            let weight = tangent.log_omega / settings.frequency_step.powi(2);
            let mut gradient = tangent.p.clone();
            gradient.scale(scale);
            let mut along = vec![0.0; free.len()];
            along[0] = 0.5 * weight / a;
            let arc = Condition {
                value: gradient.dot(&change) + weight * log,
                along,
                gradient,
            };
            std::iter::once(arc)
                .chain(amplitude(unknown, held, share, free.len()))
                .collect()
        };
        let closure = Closure {
            free,
            conditions: &conditions,
        };
        let found = solve(&self.system, unknown, &closure, newton, &mut self.effort, BUDGET[0])?;
        periodic(found)
    }

    /// What a unit of the energy norm squared counts.
    fn metric(&self, at: &Unknown) -> f64 {
        1.0 / (self.settings.amplitude_step * self.system.scale(at)).powi(2)
    }

    /// Distance of two points in steps.
    pub(crate) fn length(&self, from: &Unknown, to: &Unknown) -> f64 {
        let (mut v, mut p) = (to.v.clone(), to.p.clone());
        v.add(-1.0, &from.v);
        p.add(-1.0, &from.p);
        let log = 0.5 * (to.at(Parameter::Square) / from.at(Parameter::Square)).ln();
        (self.metric(from) * v.dot(&p).max(0.0) + (log / self.settings.frequency_step).powi(2)).sqrt()
    }

    pub(crate) fn secant(&self, from: &Unknown, to: &Unknown, length: f64) -> Tangent {
        let (mut v, mut p) = (to.v.clone(), to.p.clone());
        v.add(-1.0, &from.v);
        p.add(-1.0, &from.p);
        v.scale(1.0 / length);
        p.scale(1.0 / length);
        Tangent {
            v,
            p,
            log_omega: 0.5 * (to.at(Parameter::Square) / from.at(Parameter::Square)).ln() / length,
            force: (to.at(Parameter::Force) - from.at(Parameter::Force)) / length,
            length,
        }
    }
}

/// How long a step may come out that was to be `step` long: beyond, it has left the curve. From the first point the frequency alone is
/// changed, without a measure of what the motion does; at a corner it may be a whole step.
fn longest(step: f64, tangent: &Option<Tangent>, points: usize) -> f64 {
    match tangent {
        Some(_) => 3.0 * step.max(SHORTEST),
        None if points == 1 => f64::INFINITY,
        None => 1.0,
    }
}

/// A solution whose history repeats.
fn periodic(found: Converged) -> Result<Converged, Failure> {
    if found.drift <= LARGEST_DRIFT {
        Ok(found)
    } else {
        Err(Failure {
            reason: Reason::NotPeriodic,
            history: vec![found.drift],
        })
    }
}

/// Marks the points at which the frequency turns.
fn mark_turns(points: &mut [Point]) {
    for at in 2..points.len() {
        let [a, b, c] = [points[at - 2].omega, points[at - 1].omega, points[at].omega];
        points[at - 1].turns = (b - a) * (c - b) < 0.0;
    }
}
