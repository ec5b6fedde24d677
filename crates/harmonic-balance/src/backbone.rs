//! Backbones: periodic motions against the amplitude, free (EPMC) or at phase resonance.
//!
//! The amplitude is that of the first harmonic in the norm of the mass, `q^2 = C_1^T M C_1 + S_1^T M S_1`, the mass-normalised modal
//! amplitude of the linear mode. At each amplitude the motion is found together with
//! - [`Kind::Free`]: frequency and damping ratio of the extended periodic motion concept (Krack 2015, DOI
//!   10.1016/j.compstruc.2015.03.008): `M u'' - 2 zeta omega M u' + K u + F(u) = f` has a periodic solution, since a negative damping
//!   proportional to the mass supplies what friction takes;
//! - [`Kind::PhaseResonance`]: frequency and amplitude of a force whose point moves a quarter period behind it.

use crate::Error;
use crate::aft::Sampling;
use crate::error::require;
use crate::force::{DifferentiablePointwiseForce, PointwiseForce};
use crate::harmonics::Harmonics;
use crate::load::Load;
use crate::solve::{
    BUDGET, Closure, Condition, Converged, Effort, Failure, NewtonSettings, Reason, parameter_rates, solve,
};
use crate::system::{Parameter, System, Unknown};
use cqsma_solver::Linearisation;
use cqsma_solver::sensitivity::Derivatives;
use dense_algebra::dot;
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// What a backbone is of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind<'a> {
    /// Free motions of a damped structure (EPMC).
    Free,
    /// Resonances under a harmonic force.
    PhaseResonance {
        /// Direction of the force over all coordinates.
        row: &'a [f64],
        /// Viscous damping ratio of the linear modes beside friction.
        background: f64,
    },
}

/// Settings of a backbone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The linear mode that the backbone begins as, counted from 0.
    pub mode: usize,
    /// Harmonics, samples and periods; with an `accuracy` those that the first point tries.
    pub sampling: Sampling,
    /// Error target; none takes `sampling` as it is and estimates nothing.
    pub accuracy: Option<Accuracy>,
    /// Newton's method.
    pub newton: NewtonSettings,
}

/// Errors that are borne, and how far harmonics and samples may be raised for them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Relative error of the frequency.
    pub frequency: f64,
    /// Error of the damping ratio relative to it, plus `damping_floor`.
    pub damping: f64,
    /// Damping ratio below which errors do not matter.
    pub damping_floor: f64,
    /// Most harmonics.
    pub max_harmonics: usize,
    /// Most samples per period.
    pub max_samples: usize,
}

/// Largest change of the tractions from one period to the next, relative to their range, that counts as periodic.
pub const LARGEST_DRIFT: f64 = 1e-2;

/// Most periods that the history is followed for.
const MAX_PERIODS: usize = 32;

/// Krylov steps per iteration above which the preconditioner is made anew from the mean tangent.
const HARD: usize = 40;

/// How many powers of ten below the first amplitude the linear mode is tried.
const FIRST_DECADES: i32 = 4;

/// Most halvings of the way from one amplitude to the next.
const MAX_HALVINGS: usize = 8;

/// A periodic motion on a backbone.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Motion {
    /// Amplitude `q` (sqrt(kg) m).
    pub modal_amplitude: f64,
    /// Angular frequency (rad/s).
    pub omega: f64,
    /// Damping ratio: of free motions.
    pub zeta: Option<f64>,
    /// Amplitude of the exciting force (N): of phase resonances.
    pub force: Option<f64>,
    /// Harmonics of the displacements from the static state (m).
    pub displacement: Harmonics,
    /// Harmonics of the contact force from that of the static state (N).
    pub contact_force: Harmonics,
    /// Energy that the contact takes per period (J).
    pub dissipation: f64,
    /// What is missing in the balance of energies, as a damping ratio: work of the contact less that of what sustains the motion, per
    /// `2 pi omega^2 q^2`.
    pub energy_error: f64,
    /// Largest share of the amplitude in the norm of the mass that a harmonic above the first has.
    pub share_of_harmonics: Vec<f64>,
    /// Residual relative to the elastic forces (energy norm), evaluated anew from the stiffness.
    pub residual: f64,
    /// Change of the tractions from the last period to the one before relative to their range.
    pub drift: f64,
    /// Harmonics, samples and periods that it was found with.
    pub sampling: Sampling,
    /// Estimated errors of sampling, if a target was given.
    pub errors: Option<SamplingErrors>,
}

/// Errors estimated from the changes that two harmonics more and twice the samples make.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SamplingErrors {
    /// Relative error of the frequency: of too few harmonics, of too few samples.
    pub frequency: [f64; 2],
    /// Error of the damping ratio, or relative error of the force.
    pub damping: [f64; 2],
}

/// A point of a backbone.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Point {
    /// Amplitude asked for (sqrt(kg) m).
    pub modal_amplitude: f64,
    /// The motion, or why there is none.
    pub result: Result<Motion, Failure>,
    /// Work done for it.
    pub effort: Effort,
}

/// Follows a backbone through ascending amplitudes (sqrt(kg) m); `known` are points found before, which are not computed again, and
/// `observe` hears of every new one and may stop the run.
///
/// # Errors
/// Settings or sizes that do not fit, and [`Error::Interrupted`]. A point that does not converge is a status of it.
pub fn follow<F: PointwiseForce>(
    line: &Linearisation<'_, F::State>,
    force: &F,
    kind: Kind<'_>,
    amplitudes: &[f64],
    settings: &Settings,
    known: Vec<Point>,
    observe: &mut dyn FnMut(&Point) -> ControlFlow<()>,
) -> Result<Vec<Point>, Error> {
    let n = line.shapes.nrows();
    check(line.shapes.ncols(), amplitudes, settings)?;
    let none = vec![0.0; n];
    let (row, background) = match kind {
        Kind::Free => (none.as_slice(), 0.0),
        Kind::PhaseResonance { row, background } => {
            if row.len() != n {
                return Err(Error::Size {
                    what: "the direction of the force",
                    found: row.len(),
                    expected: n,
                });
            }
            (row, background)
        }
    };
    let system = System::new(line, force, Load::force(row), background, [0.0; 2], settings.sampling);
    let mut follower = Follower {
        system,
        free: matches!(kind, Kind::Free),
        settings,
        found: Vec::new(),
        reported: Vec::new(),
        sampling: settings.sampling,
        is_hard: false,
        left: BUDGET[0],
    };
    let mut points = Vec::with_capacity(amplitudes.len());
    let mut known = known.into_iter();
    for &amplitude in amplitudes {
        if let Some(point) = known.next().filter(|point| point.modal_amplitude == amplitude) {
            // As if it had just been found.
            point.result.iter().for_each(|motion| follower.accept(motion));
            follower.judge(&point);
            points.push(point);
            continue;
        }
        known = Vec::new().into_iter();
        let mut effort = Effort::default();
        let result = follower.find(amplitude, &mut effort);
        if result.is_err() && line.limits.stops() {
            return Err(Error::Interrupted);
        }
        let point = Point {
            modal_amplitude: amplitude,
            result,
            effort,
        };
        follower.judge(&point);
        let flow = observe(&point);
        points.push(point);
        if flow.is_break() {
            return Err(Error::Interrupted);
        }
    }
    Ok(points)
}

/// Derivatives of a free motion with respect to a parameter, per unit of the parameter and at the same amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionRate {
    /// Of the logarithm of the frequency.
    pub ln_omega: f64,
    /// Of the logarithm of the damping ratio.
    pub ln_zeta: f64,
}

/// Accuracy of the linear solves for derivatives, relative in the energy norm.
const RATE_TOLERANCE: f64 = 1e-9;

/// Derivatives of a free motion with respect to all parameters, of the discrete motion with its harmonics, samples and periods. `None` if a
/// linear system could not be solved, or for a motion that is not free.
///
/// With the residual `R(V, a, b; p)` of the motion, the changes `V'`, `a'`, `b'` solve `J (V', a', b') = -dR/dp` with the Jacobian of Newton's
/// method, bordered by the conditions of amplitude and phase; `dR/dp` carries the changes of the static state and its history along.
pub fn rates<F: DifferentiablePointwiseForce>(
    line: &Linearisation<'_, F::State>,
    force: &F,
    derivatives: &Derivatives<'_, F>,
    motion: &Motion,
) -> Option<Vec<MotionRate>> {
    let zeta = motion.zeta?;
    let none = vec![0.0; line.shapes.nrows()];
    let settings = Settings {
        mode: derivatives.mode(),
        sampling: motion.sampling,
        accuracy: None,
        newton: NewtonSettings::default(),
    };
    let mut follower = Follower {
        system: System::new(line, force, Load::force(&none), 0.0, [0.0; 2], motion.sampling),
        free: true,
        settings: &settings,
        found: Vec::new(),
        reported: Vec::new(),
        sampling: motion.sampling,
        is_hard: false,
        left: BUDGET[0],
    };
    let unknown = follower.unknown_of(motion);
    let amplitude = motion.modal_amplitude;
    let changes = || {
        let system = &follower.system;
        let changes = derivatives.parameters().iter().map(|rate| {
            let [c, s] = unknown.v.pair(1);
            let inertia = system.inertia_change(&unknown, rate);
            let of_amplitude = inertia.map_or(0.0, |inertia| {
                let [mc, ms] = inertia.pair(1);
                0.5 * (dot(c, mc) + dot(s, ms)) / (amplitude * amplitude)
            });
            let of_phase = dot(s, &rate.unit) / amplitude;
            (system.parameter_change(&unknown, rate), vec![of_amplitude, of_phase])
        });
        changes.collect::<Vec<_>>()
    };
    let solve = |follower: &Follower<'_, '_, F>, changes| {
        let free = follower.parameters();
        let conditions = |unknown: &Unknown, inertia: &Harmonics| follower.conditions(amplitude, unknown, inertia);
        let closure = Closure {
            free: &free,
            conditions: &conditions,
        };
        parameter_rates(&follower.system, &unknown, &closure, changes, RATE_TOLERANCE)
    };
    let found = match solve(&follower, changes()) {
        Some(found) => found,
        None => {
            let changes = changes();
            follower.system.adapt(&motion.displacement);
            solve(&follower, changes)?
        }
    };
    let [a, b] = [Parameter::Square, Parameter::Damping].map(|parameter| unknown.at(parameter));
    let rates = found.into_iter().map(|changes| {
        let [of_a, of_b] = [changes[0] / a, changes[1] / b];
        MotionRate {
            ln_omega: 0.5 * of_a,
            ln_zeta: if zeta == 0.0 { f64::NAN } else { of_b - of_a },
        }
    });
    Some(rates.collect())
}

fn check(n_modes: usize, amplitudes: &[f64], settings: &Settings) -> Result<(), Error> {
    require(
        settings.mode < n_modes,
        "mode",
        settings.mode as f64,
        "less than the number of linearised modes (counted from 0)",
    )?;
    check_sampling(settings.sampling)?;
    for pair in amplitudes.windows(2) {
        require(
            pair[0] < pair[1],
            "modal_amplitude",
            pair[1],
            "larger than the one before it",
        )?;
    }
    for &amplitude in amplitudes {
        let ok = amplitude > 0.0 && amplitude.is_finite();
        require(ok, "modal_amplitude", amplitude, "positive and finite")?;
    }
    Ok(())
}

pub(crate) fn check_sampling(sampling: Sampling) -> Result<(), Error> {
    let Sampling {
        harmonics,
        samples,
        periods,
    } = sampling;
    require(
        (1..=200).contains(&harmonics),
        "harmonics",
        harmonics as f64,
        "from 1 to 200",
    )?;
    let enough = samples > 2 * harmonics && (8..=1 << 16).contains(&samples);
    require(
        enough,
        "samples",
        samples as f64,
        "from 8 to 65536, and more than twice the number of harmonics",
    )?;
    require(
        (1..=1000).contains(&periods),
        "periods",
        periods as f64,
        "from 1 to 1000",
    )
}

struct Follower<'a, 's, F: PointwiseForce> {
    system: System<'a, F>,
    free: bool,
    settings: &'s Settings,
    /// The last points found: logarithm of the amplitude, and the motion.
    found: Vec<(f64, Unknown)>,
    /// The same of the amplitudes asked for alone, so that a run that goes on after an interruption finds the same numbers.
    reported: Vec<(f64, Unknown)>,
    /// Sampling of the last of them.
    sampling: Sampling,
    /// Whether the last of them needed many Krylov steps, or another preconditioner.
    is_hard: bool,
    /// Residuals and products that the next amplitude may take.
    left: usize,
}

impl<'a, F: PointwiseForce> Follower<'a, '_, F> {
    fn parameters(&self) -> [Parameter; 2] {
        if self.free {
            [Parameter::Square, Parameter::Damping]
        } else {
            [Parameter::Square, Parameter::Force]
        }
    }

    /// What may be spent on the way on from a point, and whether it shall begin with its mean tangent.
    fn judge(&mut self, point: &Point) {
        let Effort {
            iterations,
            krylov_steps,
            ..
        } = point.effort;
        let found = point.result.is_ok();
        self.is_hard |= found && krylov_steps > HARD * iterations;
        self.left = self.left.saturating_sub(point.effort.products()) + if found { BUDGET[1] } else { 0 };
    }

    /// A motion as it was found.
    fn unknown_of(&self, motion: &Motion) -> Unknown {
        let mut unknown = Unknown {
            v: motion.displacement.clone(),
            p: motion.displacement.clone(),
            parameters: [0.0; 3],
        };
        self.system.restore(&mut unknown);
        let square = motion.omega * motion.omega;
        *unknown.at_mut(Parameter::Square) = square;
        *unknown.at_mut(Parameter::Damping) = motion.zeta.map_or(0.0, |zeta| 2.0 * zeta * square);
        *unknown.at_mut(Parameter::Force) = motion.force.unwrap_or(0.0);
        unknown
    }

    /// Makes a motion one that later ones are extrapolated from, as it is stored.
    fn accept(&mut self, motion: &Motion) {
        let unknown = self.unknown_of(motion);
        self.sampling = motion.sampling;
        push(&mut self.reported, motion.modal_amplitude, unknown);
    }

    fn keep(&mut self, amplitude: f64, unknown: Unknown) {
        push(&mut self.found, amplitude, unknown);
    }

    /// The linear mode.
    fn mode(&self, amplitude: f64) -> Unknown {
        let system = &self.system;
        let line = system.line();
        let mut v = Harmonics::zeros(system.size(), system.sampling().harmonics);
        // A force in the cosine moves its point as the sine.
        let column = if self.free { 1 } else { 2 };
        let shape = line.shapes.col(self.settings.mode).iter();
        v.column_mut(column)
            .iter_mut()
            .zip(shape)
            .for_each(|(v, phi)| *v = amplitude * phi);
        let mut unknown = Unknown {
            p: v.clone(),
            v,
            parameters: [line.eigenvalues[self.settings.mode], 0.0, 0.0],
        };
        system.restore(&mut unknown);
        unknown
    }

    /// Extrapolation of what was found: the shape and the parameters change little with the logarithm of the amplitude.
    fn predict(&self, amplitude: f64) -> Unknown {
        let target = amplitude.ln();
        let count = self.system.sampling().harmonics;
        let at = |(log, unknown): &(f64, Unknown)| {
            let mut scaled = unknown.clone();
            scaled.v = scaled.v.with_count(count);
            scaled.p = scaled.p.with_count(count);
            let factor = (target - log).exp();
            scaled.v.scale(factor);
            scaled.p.scale(factor);
            if !self.free {
                *scaled.at_mut(Parameter::Force) *= factor;
            }
            scaled
        };
        match self.found.as_slice() {
            [] => self.mode(amplitude),
            [only] => at(only),
            [.., before, last] => {
                let weight = ((target - last.0) / (last.0 - before.0)).min(1.0);
                let (mut next, earlier) = (at(last), at(before));
                let combine = |a: f64, b: f64| a + weight * (a - b);
                let blend = |a: &mut Harmonics, b: &Harmonics| {
                    a.values_mut()
                        .iter_mut()
                        .zip(b.values())
                        .for_each(|(a, b)| *a = combine(*a, *b));
                };
                blend(&mut next.v, &earlier.v);
                blend(&mut next.p, &earlier.p);
                for (a, b) in next.parameters.iter_mut().zip(earlier.parameters) {
                    *a = combine(*a, b);
                }
                next
            }
        }
    }

    /// The conditions of amplitude and phase.
    fn conditions(&self, amplitude: f64, unknown: &Unknown, inertia: &Harmonics) -> Vec<Condition> {
        let (size, count) = (unknown.v.size(), unknown.v.count());
        let square = amplitude * amplitude;
        let [c, s] = unknown.v.pair(1);
        let [mc, ms] = inertia.pair(1);
        let mut gradient = Harmonics::zeros(size, count);
        for (column, from) in [(1, mc), (2, ms)] {
            gradient
                .column_mut(column)
                .iter_mut()
                .zip(from)
                .for_each(|(to, m)| *to = m / square);
        }
        let of_amplitude = Condition {
            value: 0.5 * ((dot(c, mc) + dot(s, ms)) / square - 1.0),
            gradient,
            along: vec![0.0; 2],
        };
        let mut gradient = Harmonics::zeros(size, count);
        let (column, row, reference) = if self.free {
            (2, self.system.momentum(self.settings.mode), amplitude)
        } else {
            // The mode's motion at the point of the force.
            let row = self.system.load.cosine.as_slice();
            let shape: f64 = self
                .system
                .line()
                .shapes
                .col(self.settings.mode)
                .iter()
                .zip(row)
                .map(|(a, b)| a * b)
                .sum();
            (1, row, amplitude * shape.abs().max(f64::MIN_POSITIVE))
        };
        gradient
            .column_mut(column)
            .iter_mut()
            .zip(row)
            .for_each(|(to, r)| *to = r / reference);
        let of_phase = Condition {
            value: dot(unknown.v.column(column), row) / reference,
            gradient,
            along: vec![0.0; 2],
        };
        vec![of_amplitude, of_phase]
    }

    /// Solves at an amplitude; where that fails with the preconditioner of the stuck structure, with that of the last motion found.
    fn solve(&mut self, amplitude: f64, unknown: &mut Unknown, effort: &mut Effort) -> Result<Converged, Failure> {
        let guess = unknown.clone();
        let failure = match self.attempt(amplitude, unknown, effort) {
            Ok(found) => return Ok(found),
            Err(failure) => failure,
        };
        let again = !(self.system.is_adapted() || failure.reason.is_final());
        let Some((_, last)) = self.found.last().filter(|_| again) else {
            return Err(failure);
        };
        self.system.adapt(&last.v.with_count(self.system.sampling().harmonics));
        *unknown = guess;
        self.attempt(amplitude, unknown, effort)
    }

    fn attempt(&self, amplitude: f64, unknown: &mut Unknown, effort: &mut Effort) -> Result<Converged, Failure> {
        let free = self.parameters();
        let conditions = |unknown: &Unknown, inertia: &Harmonics| self.conditions(amplitude, unknown, inertia);
        let closure = Closure {
            free: &free,
            conditions: &conditions,
        };
        solve(
            &self.system,
            unknown,
            &closure,
            &self.settings.newton,
            effort,
            self.left,
        )
    }

    /// The first motion, from the linear mode or on the way from a smaller amplitude.
    fn begin(&mut self, amplitude: f64, effort: &mut Effort) -> Result<(Unknown, Converged), Failure> {
        let mut unknown = self.mode(amplitude);
        let failure = match self.solve(amplitude, &mut unknown, effort) {
            Ok(found) => return Ok((unknown, found)),
            Err(failure) if failure.reason.is_final() => return Err(failure),
            Err(failure) => failure,
        };
        for decade in 1..=FIRST_DECADES {
            let small = amplitude * 0.1_f64.powi(decade);
            let mut first = self.mode(small);
            if self.solve(small, &mut first, effort).is_ok() {
                self.keep(small, first);
                return self.reach(amplitude, effort);
            }
        }
        Err(failure)
    }

    /// A motion at an amplitude, with points between where the way there is too long.
    fn reach(&mut self, amplitude: f64, effort: &mut Effort) -> Result<(Unknown, Converged), Failure> {
        let (mut share, mut halvings) = (1.0, 0);
        loop {
            let Some(last) = self.found.last().map(|found| found.0) else {
                return self.begin(amplitude, effort);
            };
            let way = amplitude.ln() - last;
            let is_final = share >= 1.0;
            let next = if is_final {
                amplitude
            } else {
                (last + share * way).exp()
            };
            let mut unknown = self.predict(next);
            match self.solve(next, &mut unknown, effort) {
                Ok(found) if is_final => return Ok((unknown, found)),
                Ok(_) => {
                    self.keep(next, unknown);
                    share = (2.0 * share / (1.0 - share)).min(1.0);
                }
                Err(failure) => {
                    halvings += 1;
                    if halvings > MAX_HALVINGS || failure.reason.is_final() {
                        return Err(failure);
                    }
                    share *= 0.5;
                }
            }
        }
    }

    /// As [`Follower::reach`], with as many periods as the history needs to repeat.
    fn reach_periodic(&mut self, amplitude: f64, effort: &mut Effort) -> Result<(Unknown, Converged), Failure> {
        let (mut unknown, mut found) = self.reach(amplitude, effort)?;
        while found.drift > LARGEST_DRIFT {
            let sampling = self.system.sampling();
            if sampling.periods >= MAX_PERIODS {
                return Err(Failure {
                    reason: Reason::NotPeriodic,
                    history: vec![found.drift],
                });
            }
            self.system.resample(Sampling {
                periods: 2 * sampling.periods,
                ..sampling
            });
            found = self.solve(amplitude, &mut unknown, effort)?;
        }
        Ok((unknown, found))
    }

    fn find(&mut self, amplitude: f64, effort: &mut Effort) -> Result<Motion, Failure> {
        self.found.clone_from(&self.reported);
        self.system.resample(self.sampling);
        self.system.forget();
        if let Some((_, last)) = self.found.last().filter(|_| self.is_hard) {
            self.system.adapt(&last.v);
        }
        let (mut unknown, mut found) = self.reach_periodic(amplitude, effort)?;
        let mut errors = None;
        if let Some(accuracy) = self.settings.accuracy {
            loop {
                let (estimate, finer) = self.estimate(amplitude, &unknown, effort)?;
                errors = Some(estimate);
                let sampling = self.system.sampling();
                let Some(raised) = self.raised(&estimate, &unknown, accuracy, sampling) else {
                    break;
                };
                let index = usize::from(raised.samples > sampling.samples);
                self.system.resample(raised);
                let [of_harmonics, of_samples] = finer;
                unknown = if index == 0 { of_harmonics } else { of_samples };
                found = self.solve(amplitude, &mut unknown, effort)?;
            }
        }
        let motion = self.describe(amplitude, &unknown, &found, errors);
        self.accept(&motion);
        Ok(motion)
    }

    /// What too few harmonics and samples may make wrong, with the motions that they lead to.
    fn estimate(
        &mut self,
        amplitude: f64,
        unknown: &Unknown,
        effort: &mut Effort,
    ) -> Result<(SamplingErrors, [Unknown; 2]), Failure> {
        let sampling = self.system.sampling();
        let [more, denser] = refined(sampling);
        let mut errors = SamplingErrors::default();
        let mut finer = [unknown.clone(), unknown.clone()];
        for (index, trial) in [more, denser].into_iter().enumerate() {
            self.system.resample(trial);
            finer[index].v = unknown.v.with_count(trial.harmonics);
            finer[index].p = unknown.p.with_count(trial.harmonics);
            let solved = self.solve(amplitude, &mut finer[index], effort);
            self.system.resample(sampling);
            solved?;
            let [a, b, force] = unknown.parameters;
            let [next_a, next_b, next_force] = finer[index].parameters;
            let rest = remainder(sampling)[index];
            errors.frequency[index] = rest * ((next_a / a).sqrt() - 1.0).abs();
            errors.damping[index] = rest
                * if self.free {
                    (0.5 * next_b / next_a - 0.5 * b / a).abs()
                } else {
                    (next_force / force - 1.0).abs()
                };
        }
        Ok((errors, finer))
    }

    /// Finer sampling, if the errors ask for it and bounds allow it.
    fn raised(
        &self,
        errors: &SamplingErrors,
        unknown: &Unknown,
        accuracy: Accuracy,
        sampling: Sampling,
    ) -> Option<Sampling> {
        let [a, b, _] = unknown.parameters;
        let borne = if self.free {
            accuracy.damping * (0.5 * b / a).abs() + accuracy.damping_floor
        } else {
            accuracy.damping
        };
        let excess = |index: usize| (errors.frequency[index] / accuracy.frequency).max(errors.damping[index] / borne);
        let harmonics = (excess(0) > 1.0 && sampling.harmonics + 2 <= accuracy.max_harmonics).then_some(excess(0));
        let samples = (excess(1) > 1.0 && 2 * sampling.samples <= accuracy.max_samples).then_some(excess(1));
        let [more, denser] = refined(sampling);
        match (harmonics, samples) {
            (None, None) => None,
            (Some(h), Some(n)) if h >= n => Some(more),
            (Some(_), None) => Some(more),
            _ => Some(denser),
        }
    }

    fn describe(&self, amplitude: f64, unknown: &Unknown, found: &Converged, errors: Option<SamplingErrors>) -> Motion {
        let system = &self.system;
        let [a, b, force] = unknown.parameters;
        let dissipation = found.evaluation.contact.work(&unknown.v);
        let squares: Vec<f64> = (1..=unknown.v.count())
            .map(|h| {
                let ([c, s], [mc, ms]) = (unknown.v.pair(h), found.evaluation.inertia.pair(h));
                c.iter().zip(mc).chain(s.iter().zip(ms)).map(|(v, m)| v * m).sum()
            })
            .collect();
        let supplied = if self.free {
            let weighted: f64 = squares.iter().zip(1..).map(|(e, h)| f64::from(h * h) * e).sum();
            PI * b * weighted
        } else {
            system.supplied_work(unknown) - system.viscous_work(unknown)
        };
        Motion {
            modal_amplitude: amplitude,
            omega: a.sqrt(),
            zeta: self.free.then_some(0.5 * b / a),
            force: (!self.free).then_some(force),
            displacement: unknown.v.clone(),
            contact_force: found.evaluation.contact.clone(),
            dissipation,
            energy_error: (dissipation - supplied).abs() / (2.0 * PI * a * amplitude * amplitude),
            share_of_harmonics: squares.iter().map(|e| (e / squares[0]).max(0.0).sqrt()).collect(),
            residual: found.residual.max(system.imbalance(unknown)),
            drift: found.drift,
            sampling: system.sampling(),
            errors,
        }
    }
}

/// Sampling with two harmonics more, as one alone may be one that the motion hardly has, and with twice the samples.
fn refined(sampling: Sampling) -> [Sampling; 2] {
    let harmonics = sampling.harmonics + 2;
    [
        Sampling {
            harmonics,
            samples: sampling.samples.max(2 * harmonics + 2),
            ..sampling
        },
        Sampling {
            samples: 2 * sampling.samples,
            ..sampling
        },
    ]
}

/// Error over the change that [`refined`] makes: friction makes harmonics fall with the square of their order, and sampling errors at
/// least in proportion to the step.
fn remainder(sampling: Sampling) -> [f64; 2] {
    let share = sampling.harmonics as f64 / (sampling.harmonics as f64 + 2.0);
    [1.0 / (1.0 - share * share), 2.0]
}

/// Adds a point and forgets all but two.
fn push(points: &mut Vec<(f64, Unknown)>, amplitude: f64, unknown: Unknown) {
    if points.len() == 2 {
        points.remove(0);
    }
    points.push((amplitude.ln(), unknown));
}
