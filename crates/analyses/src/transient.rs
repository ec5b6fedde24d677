//! The ring-down of a scene's reduced model in time, identified like a measured one: an independent check of the backbone.

use super::comparison::{Backbone, Point};
use super::prestress::{linearise, response};
use super::run::Run;
use crate::Error;
use cqsma_solver::transient::{self, MOST_STEPS, Start, Transient};
use harmonic_balance::backbone::Motion;
use joints::interface::InterfaceForce;
use joints::progress::{Progress, Stage};
use modal_identification::backbone::{Identification, identify};
use modal_identification::signal::{Quantity, Signal};
use modal_identification::{backbone, synthetic};
use scenes::{BoltBehaviour, Length, Method, Scene};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// How a ring-down is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What begins it.
    pub excitation: Excitation,
    /// Periods of the linearised mode to follow.
    pub periods: usize,
    /// Steps per period.
    pub steps_per_period: usize,
    /// Spectral radius of the scheme at infinite frequency.
    pub spectral_radius: f64,
    /// Viscous damping ratio of the scene's linearised modes beside the one followed, where it is larger than the
    /// background's.
    pub other_damping: f64,
}

/// What begins a ring-down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Excitation {
    /// Released from the equilibrium under the mode's own inertial load, by linear estimate at this displacement of the
    /// response point (m).
    Release(f64),
    /// A half-sine of force along the response.
    Impact {
        /// Impulse (N s).
        impulse: f64,
        /// Duration (s).
        duration: f64,
    },
}

impl Default for Settings {
    fn default() -> Self {
        let solver = transient::Settings::default();
        Self {
            excitation: Excitation::Release(2e-3),
            periods: 150,
            steps_per_period: solver.steps_per_period,
            spectral_radius: solver.spectral_radius,
            other_damping: solver.other_damping,
        }
    }
}

impl Settings {
    /// Checks what is known before any work is done.
    ///
    /// # Errors
    /// [`Error::Motion`].
    pub fn validate(&self) -> Result<(), Error> {
        let check = |ok, field, value, unit, requirement| match ok {
            true => Ok(()),
            false => Err(Error::Motion {
                field,
                value,
                unit,
                requirement,
            }),
        };
        if let Excitation::Release(amplitude) = self.excitation {
            let ok = amplitude > 0.0 && amplitude.is_finite();
            check(ok, "amplitude", amplitude, "m", "positive and finite")?;
        }
        let periods = self.periods as f64;
        check(self.periods > 0, "periods", periods, "", "at least 1")?;
        check(
            self.steps_per_period.saturating_mul(self.periods) <= MOST_STEPS,
            "periods",
            periods,
            "",
            "so few that they have at most 1e7 steps; follow fewer periods, or take fewer steps for each",
        )
    }
}

/// A ring-down.
#[derive(Clone, Debug)]
pub struct RingDown {
    /// The motion of the response point, with the energies.
    pub transient: Transient,
    /// Frequency of the linearised mode (Hz).
    pub frequency_hz: f64,
}

/// The scene of a run whose backbone covers a ring-down from `amplitude` (m): from an eightieth of it to the whole, with
/// RQNMA and EPMC beside.
pub fn scene_for(mut scene: Scene, amplitude: f64) -> Scene {
    scene.cqsma.amplitude_from = Length::from_si(amplitude / 80.0);
    scene.cqsma.amplitude_to = Length::from_si(amplitude);
    scene.cqsma.amplitudes = scene.cqsma.amplitudes.max(24);
    for method in [Method::Rqnma, Method::Epmc] {
        if !scene.methods.contains(&method) {
            scene.methods.push(method);
        }
    }
    if let Some(epmc) = &mut scene.epmc {
        epmc.modal_amplitudes = None;
    }
    scene.forced = None;
    scene
}

/// Follows the motion of a finished run's reduced model, with its law, static state and background damping.
///
/// # Errors
/// [`Error::Motion`], [`Error::Transient`] if a step did not converge, [`Error::Solver`].
pub fn ring_down(run: &Run, settings: &Settings, progress: &dyn Progress) -> Result<RingDown, Error> {
    settings.validate()?;
    progress.begin(Stage::Transient);
    let scene = &run.scene;
    let reduced = &run.model.reduced;
    let locked = match scene.bolts.behaviour {
        BoltBehaviour::DeadLoad => None,
        BoltBehaviour::Locked => Some(reduced.locked()?),
    };
    let vibrating = locked.as_ref().unwrap_or(reduced);
    let force = InterfaceForce::new(&run.interface);
    let stop = || progress.interrupted();
    let mut line = linearise(scene, vibrating, &force, &run.prestress.solution)?;
    line.limits = line.limits.until(&stop);
    let row = response(vibrating);
    let mode = run.first().mode - 1;
    let phi: f64 = line.shapes.col(mode).iter().zip(&row).map(|(a, b)| a * b).sum();
    let start = match settings.excitation {
        Excitation::Release(amplitude) => Start::Release {
            modal_force: line.eigenvalues[mode] * amplitude / phi,
        },
        Excitation::Impact { impulse, duration } => Start::Pulse {
            impulse,
            duration,
            point: row.clone(),
        },
    };
    let solver = transient::Settings {
        mode,
        steps_per_period: settings.steps_per_period,
        periods: settings.periods,
        spectral_radius: settings.spectral_radius,
        background_damping: scene.background_damping,
        other_damping: settings.other_damping,
        ..transient::Settings::default()
    };
    let frequency_hz = line.frequencies()[mode];
    let wanted = settings.periods as f64 / frequency_hz;
    let transient = transient::run(&line, &force, &row, &start, &solver, &mut |sample| {
        progress.fraction(Stage::Transient, sample.time / wanted);
        if progress.interrupted() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    })?;
    progress.end(Stage::Transient);
    if let Some(failure) = transient.failure {
        return Err(Error::Transient {
            time: transient.samples.last().map_or(0.0, |s| s.time),
            wanted,
            reason: failure.reason,
            history: failure.history,
        });
    }
    Ok(RingDown {
        transient,
        frequency_hz,
    })
}

impl RingDown {
    /// Acceleration of the response point.
    pub fn signal(&self) -> Signal {
        signal(
            self.transient.step,
            self.transient.samples.iter().map(|s| s.acceleration).collect(),
        )
    }

    /// How such a signal is identified by default: a band of half the frequency and the shortest smoothing that
    /// still is one, since there is no noise and amplitudes fall fast.
    pub fn identification(&self) -> backbone::Settings {
        backbone::Settings {
            frequency: Some(self.frequency_hz),
            bandwidth: Some(self.frequency_hz / 2.0),
            smoothing: 9,
            ..backbone::Settings::default()
        }
    }

    /// The backbone identified, over acceleration; the frequency error of the time integration, which is known for the
    /// linear mode, is taken out.
    ///
    /// # Errors
    /// [`Error::Identification`], [`Error::Comparison`].
    pub fn identify(&self, settings: &backbone::Settings) -> Result<(Identification, Backbone), Error> {
        let mut found = identify(&self.signal(), settings)?;
        for point in &mut found.backbone {
            point.frequency_hz /= self.transient.algorithmic.frequency_ratio;
        }
        let backbone = of_points("the ring-down", &found.backbone)?;
        Ok((found, backbone))
    }

    /// What identification makes of a ring-down that has exactly the backbone `known` (over acceleration), from the
    /// amplitude that this one begins with and as long.
    ///
    /// # Errors
    /// [`Error::Identification`], [`Error::Comparison`].
    pub fn identified_again(&self, known: &Backbone, settings: &backbone::Settings) -> Result<Backbone, Error> {
        let [low, high] = known.range();
        let at = |amplitude: f64| {
            known
                .at(amplitude.clamp(low, high))
                .unwrap_or((self.frequency_hz, None))
        };
        let samples = &self.transient.samples;
        let ring = synthetic::RingDown {
            amplitude: samples.first().map_or(high, |s| s.acceleration.abs()).min(high),
            phase: 0.0,
            frequency: |a: f64| at(a).0,
            damping_ratio: |a: f64| at(a).1.unwrap_or(0.0),
        };
        let step = self.transient.step;
        let found = identify(&signal(step, ring.samples(1.0 / step, samples.len())), settings)?;
        of_points("the synthetic ring-down", &found.backbone)
    }
}

fn signal(step: f64, samples: Vec<f64>) -> Signal {
    Signal {
        at: "the computed motion".into(),
        quantity: Quantity::Acceleration,
        sample_rate: 1.0 / step,
        samples,
        last_clipped: None,
    }
}

fn of_points(what: &str, points: &[backbone::Point]) -> Result<Backbone, Error> {
    let point = |p: &backbone::Point| Point {
        amplitude: p.amplitude,
        frequency_hz: p.frequency_hz,
        damping_ratio: Some(p.damping_ratio),
    };
    Backbone::try_new(what, points.iter().map(point).collect())
}

/// The backbones of a run over the acceleration at the response point, by name: `cqsma` (secants, amplitudes of the linearised
/// mode), the same loops with the frequency of their first harmonic over the motion as it was, and the other methods of the
/// scene.
///
/// # Errors
/// [`Error::Comparison`] if fewer than two amplitudes converged.
pub fn backbones(run: &Run) -> Result<Vec<(String, Backbone)>, Error> {
    let background = run.scene.background_damping;
    let point = |displacement: f64, omega: f64, friction: Option<f64>| Point {
        amplitude: displacement * omega * omega,
        frequency_hz: omega / TAU,
        damping_ratio: friction.map(|zeta| zeta + background),
    };
    let converged = || {
        let all = run.amplitudes().iter();
        all.filter_map(|a| Some((a.point.result.as_ref().ok()?, a)))
    };
    let secant = converged().filter_map(|(r, a)| {
        let zeta = r.is_resolved().then_some(r.zeta);
        Some(point(a.response_displacement?, r.omega, zeta))
    });
    let harmonic = converged().filter_map(|(r, a)| {
        let zeta = r.is_resolved().then_some(r.harmonic_zeta());
        Some(point(a.fields.as_ref()?.response_motion, r.harmonic_omega, zeta))
    });
    let mut all = vec![
        ("cqsma".to_owned(), Backbone::try_new("cqsma", secant.collect())?),
        (
            "cqsma, first harmonic".to_owned(),
            Backbone::try_new("cqsma, first harmonic", harmonic.collect())?,
        ),
    ];
    for method in &run.first().methods {
        let found = method.points.iter().filter_map(|p| p.result.as_ref().ok());
        let points = found.map(|v| point(v.response_displacement, v.omega, v.zeta)).collect();
        let name = method.method.name();
        all.push((name.to_owned(), Backbone::try_new(name, points)?));
    }
    if let Some(epmc) = &run.first().epmc {
        let found = epmc.points.iter().zip(&epmc.response_displacement);
        let found = found.filter_map(|(point, displacement)| Some((point.result.as_ref().ok()?, (*displacement)?)));
        // Below it the balance of energies says nothing.
        let resolved = |m: &Motion| m.zeta.filter(|zeta| *zeta > m.energy_error.max(m.residual));
        let points = found
            .map(|(motion, x)| point(x, motion.omega, resolved(motion)))
            .collect();
        let name = Method::Epmc.name();
        all.push((name.to_owned(), Backbone::try_new(name, points)?));
    }
    Ok(all)
}
