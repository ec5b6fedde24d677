//! Motions in time that are known in closed form.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use cqsma_solver::newton::NewtonSettings;
use cqsma_solver::test_problems::{FrictionalBar, Jenkins, JenkinsChain};
use cqsma_solver::transient::{Sample, Settings, Start, Transient, algorithmic_error, run};
use cqsma_solver::{Error, HystereticForce, Linearisation, NoObserver, cqsma, modes};
use faer::Mat;
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

fn go<F: HystereticForce>(
    line: &Linearisation<'_, F::State>,
    force: &F,
    row: &[f64],
    start: &Start,
    settings: &Settings,
) -> Transient {
    run(line, force, row, start, settings, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// One mass on a spring and a Jenkins element.
struct Oscillator {
    stiffness: Mat<f64>,
    mass: Mat<f64>,
    force: Jenkins,
}

impl Oscillator {
    fn new(mass: f64, spring: f64, slider: (f64, f64)) -> Self {
        Self {
            stiffness: Mat::from_fn(1, 1, |_, _| spring),
            mass: Mat::from_fn(1, 1, |_, _| mass),
            force: Jenkins::new(vec![slider]),
        }
    }

    fn run(&self, start: &Start, settings: &Settings) -> Transient {
        let (k, m) = (self.stiffness.as_ref(), self.mass.as_ref());
        let mut line = modes::linearise(k, m, &self.force, vec![0.0], self.force.initial_state(), 1).unwrap();
        line.orient(&[1.0]).unwrap();
        go(&line, &self.force, &[1.0], start, settings)
    }
}

/// Strong enough never to slide.
const STUCK: f64 = 1e30;

fn largest_error(found: &Transient, exact: impl Fn(f64) -> f64) -> f64 {
    let error = |s: &Sample| (s.displacement - exact(s.time)).abs();
    found.samples.iter().map(error).fold(0.0, f64::max)
}

fn order(errors: &[f64]) -> f64 {
    errors
        .windows(2)
        .map(|w| (w[0] / w[1]).log2())
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn a_linear_oscillator_converges_to_its_closed_form_with_second_order() {
    let (m, k, kt): (f64, f64, f64) = (3.0, 1000.0, 500.0);
    let oscillator = Oscillator::new(m, k, (kt, STUCK));
    let omega = ((k + kt) / m).sqrt();
    let alpha = 2.0;
    let amplitude = alpha / m.sqrt() / (omega * omega);
    for spectral_radius in [0.0, 0.5, 0.9, 1.0] {
        for zeta in [0.0, 0.02] {
            let damped = omega * (1.0_f64 - zeta * zeta).sqrt();
            // Released with the acceleration of the load alone: viscous damping acts from there on.
            let exact = |t: f64| {
                let decay = (-zeta * omega * t).exp();
                amplitude * decay * ((damped * t).cos() + zeta * omega / damped * (damped * t).sin())
            };
            let errors: Vec<f64> = [20, 40, 80, 160]
                .iter()
                .map(|&steps_per_period| {
                    let settings = Settings {
                        steps_per_period,
                        periods: 3,
                        spectral_radius,
                        background_damping: zeta,
                        ..Settings::default()
                    };
                    let found = oscillator.run(&Start::Release { modal_force: alpha }, &settings);
                    assert!(found.failure.is_none());
                    assert_eq!(found.samples.len(), 3 * steps_per_period + 1);
                    largest_error(&found, exact) / amplitude
                })
                .collect();
            assert!(order(&errors[1..]) > 1.9, "{spectral_radius} {zeta}: {errors:?}");
            assert!(errors[3] < 0.02, "{spectral_radius} {zeta}: {errors:?}");
        }
    }
}

#[test]
fn a_driven_oscillator_stays_in_its_steady_state() {
    let (m, k, kt, zeta): (f64, f64, f64, f64) = (3.0, 1000.0, 500.0, 0.02);
    let oscillator = Oscillator::new(m, k, (kt, STUCK));
    let omega = ((k + kt) / m).sqrt();
    for ratio in [0.7, 1.0, 1.4] {
        let drive = ratio * omega;
        // (omega^2 - drive^2 + 2 i zeta omega drive) (c - i s) = force / m.
        let (real, imaginary) = (omega * omega - drive * drive, 2.0 * zeta * omega * drive);
        let force = 2.0;
        let scale = force / m / (real * real + imaginary * imaginary);
        let (c, s) = (scale * real, scale * imaginary);
        let start = Start::Driven {
            amplitude: force,
            omega: drive,
            point: vec![1.0],
            motion: [vec![c], vec![drive * s], vec![-drive * drive * c]],
        };
        let errors: Vec<f64> = [40, 80, 160]
            .iter()
            .map(|&steps_per_period| {
                let settings = Settings {
                    steps_per_period,
                    periods: 10,
                    background_damping: zeta,
                    spectral_radius: 1.0,
                    ..Settings::default()
                };
                let found = oscillator.run(&start, &settings);
                assert!(found.failure.is_none() && found.energy_error() < 1e-6);
                largest_error(&found, |t| c * (drive * t).cos() + s * (drive * t).sin()) / c.hypot(s)
            })
            .collect();
        assert!(order(&errors) > 1.9 && errors[2] < 0.02, "{ratio}: {errors:?}");
    }
}

#[test]
fn what_the_scheme_does_to_an_oscillation_is_known_exactly() {
    let oscillator = Oscillator::new(1.0, 1000.0, (500.0, STUCK));
    for spectral_radius in [0.0, 0.5, 0.9, 1.0] {
        let settings = Settings {
            steps_per_period: 30,
            periods: 40,
            spectral_radius,
            ..Settings::default()
        };
        let found = oscillator.run(&Start::Release { modal_force: 1.0 }, &settings);
        let exact = algorithmic_error(spectral_radius, 30.0);
        assert_eq!(found.algorithmic, exact);
        // `x = Re(c z^n)` for the principal root once the spurious one is gone, so that three samples give `z`.
        let z = |x: &[Sample]| {
            let x: Vec<f64> = x.iter().map(|s| s.displacement).collect();
            // x2 = 2 a x1 - b x0 and x3 = 2 a x2 - b x1, a = Re z, b = |z|^2.
            let d = x[1] * x[1] - x[0] * x[2];
            let two_a = (x[1] * x[2] - x[0] * x[3]) / d;
            let b = (x[2] * x[2] - x[1] * x[3]) / d;
            (0.5 * two_a, b)
        };
        let (a, b) = z(&found.samples[1000..]);
        let (decay, turn) = (-0.5 * b.ln(), (a / b.sqrt()).acos());
        let exponent = decay.hypot(turn);
        assert!((exponent / (TAU / 30.0) - exact.frequency_ratio).abs() < 1e-9);
        assert!(
            (decay / exponent - exact.damping_ratio).abs() < 1e-9,
            "{decay} {exact:?}"
        );
        if spectral_radius == 1.0 {
            assert!(exact.damping_ratio.abs() < 1e-14);
            assert!(found.energy_error() < 1e-8, "{}", found.energy_error());
            // The trapezoidal rule, in closed form.
            let half = 0.5 * TAU / 30.0;
            assert!((exact.frequency_ratio - half.atan() / half).abs() < 1e-13);
        }
    }
    // Third order in the step.
    let ratio = algorithmic_error(0.9, 50.0).damping_ratio / algorithmic_error(0.9, 100.0).damping_ratio;
    assert!((ratio.log2() - 3.0).abs() < 0.05, "{ratio}");
}

/// Ring-down of a mass on a spring and a Jenkins element from rest at `x0` with the slider at `force0`: each stretch of
/// sticking or sliding is a cosine about its own centre, and ends where the slider reaches its limit or the velocity is zero.
struct Exact {
    /// Start, centre, and cosine and sine parts with their angular frequency, of each stretch.
    stretches: Vec<[f64; 5]>,
}

impl Exact {
    fn new(m: f64, k: f64, (kt, limit): (f64, f64), x0: f64, force0: f64, until: f64) -> Self {
        let (stuck, sliding) = (((k + kt) / m).sqrt(), (k / m).sqrt());
        let (mut t, mut x, mut v, mut f) = (0.0, x0, 0.0, force0);
        let mut stretches = Vec::new();
        let mut sticks = true;
        while t < until {
            let omega = if sticks { stuck } else { sliding };
            // m x'' + (k + kt) x + (f - kt x_begin) = 0, or m x'' + k x + f = 0.
            let centre = if sticks { (kt * x - f) / (k + kt) } else { -f / k };
            let (c, s) = (x - centre, v / omega);
            stretches.push([t, centre, c, s, omega]);
            let (amplitude, phase) = (c.hypot(s), s.atan2(c));
            // x = centre + amplitude cos(omega tau - phase).
            let tau = if sticks {
                // To the next limit in the direction of the motion, or never.
                let angle = [-1.0, 1.0]
                    .iter()
                    .filter_map(|sign| {
                        let goal = x + (sign * limit - f) / kt;
                        let cosine = (goal - centre) / amplitude;
                        if cosine.abs() > 1.0 {
                            return None;
                        }
                        let towards = |angle: f64| {
                            let angle = angle.rem_euclid(TAU);
                            // Moving outwards there: velocity has the sign of the limit.
                            ((-(angle - phase).sin() * sign) > 0.0 && angle > 1e-9).then_some(angle)
                        };
                        let root = cosine.acos();
                        [towards(phase + root), towards(phase - root)]
                            .into_iter()
                            .flatten()
                            .reduce(f64::min)
                    })
                    .reduce(f64::min);
                match angle {
                    Some(angle) => angle / omega,
                    None => break,
                }
            } else {
                // Until the velocity is zero.
                let angle = phase.rem_euclid(PI);
                (if angle > 1e-9 { angle } else { PI }) / omega
            };
            let (sin, cos) = (omega * tau).sin_cos();
            let next = centre + c * cos + s * sin;
            if sticks {
                f = (f + kt * (next - x)).clamp(-limit, limit);
            }
            v = if sticks { omega * (s * cos - c * sin) } else { 0.0 };
            x = next;
            t += tau;
            sticks = !sticks;
        }
        Self { stretches }
    }

    fn at(&self, time: f64) -> f64 {
        let index = self.stretches.partition_point(|s| s[0] <= time).max(1) - 1;
        let [start, centre, c, s, omega] = self.stretches[index];
        let angle = omega * (time - start);
        centre + c * angle.cos() + s * angle.sin()
    }
}

#[test]
fn a_jenkins_oscillator_rings_down_as_its_exact_solution() {
    let (m, k, slider) = (3.0, 1000.0, (500.0, 2.0));
    let oscillator = Oscillator::new(m, k, slider);
    // Loaded to 40 N: the slider gives way, and holds 2 N.
    let (peak, limit) = (40.0_f64, slider.1);
    let x0 = (peak - limit) / k;
    let exact = Exact::new(m, k, slider, x0, limit, 100.0);
    assert!(exact.stretches.len() > 20, "it slides many times");
    let mut errors = Vec::new();
    for steps_per_period in [50, 100, 200, 400] {
        let settings = Settings {
            steps_per_period,
            periods: 15,
            ..Settings::default()
        };
        let start = Start::Release {
            modal_force: peak / m.sqrt(),
        };
        let found = oscillator.run(&start, &settings);
        assert!((found.samples[0].displacement / x0 - 1.0).abs() < 1e-9);
        errors.push(largest_error(&found, |t| exact.at(t)) / x0);
        // What the slider has taken is what the motion has lost; dissipation by the last sample is positive.
        let last = found.samples.last().unwrap().energy;
        assert!(last.contact > 0.9 * (found.samples[0].energy.elastic - last.kinetic - last.elastic));
        assert!(
            found.energy_error() < 1e-3 * (100.0 / steps_per_period as f64).powi(2),
            "{}",
            found.energy_error()
        );
    }
    // Kinks at which the step is not aligned leave second order in the mean.
    assert!((errors[0] / errors[3]).log2() / 3.0 > 1.8, "{errors:?}");
    assert!(errors[3] < 1e-3, "{errors:?}");
}

#[test]
fn a_pulse_moves_an_oscillator_as_duhamels_integral_says() {
    let (m, k, kt): (f64, f64, f64) = (2.0, 1000.0, 200.0);
    let oscillator = Oscillator::new(m, k, (kt, STUCK));
    let omega = ((k + kt) / m).sqrt();
    let (impulse, duration) = (0.3, 0.1 * TAU / omega);
    let p = PI / duration;
    let force = 0.5 * PI * impulse / duration;
    // A half-sine is the sum of two sines, the second beginning where the pulse ends.
    let response = |t: f64| force / m / (p * p - omega * omega) * (p / omega * (omega * t).sin() - (p * t).sin());
    let exact = |t: f64| match t < duration {
        true => response(t),
        false => force / m / (p * p - omega * omega) * p / omega * ((omega * t).sin() + (omega * (t - duration)).sin()),
    };
    let errors: Vec<f64> = [100, 200, 400]
        .iter()
        .map(|&steps_per_period| {
            let start = Start::Pulse {
                impulse,
                duration,
                point: vec![1.0],
            };
            let settings = Settings {
                steps_per_period,
                periods: 2,
                ..Settings::default()
            };
            let found = oscillator.run(&start, &settings);
            let bound = 3e-4 * (100.0 / steps_per_period as f64).powi(2);
            assert!(found.energy_error() < bound, "{}", found.energy_error());
            largest_error(&found, exact) * m * omega / impulse
        })
        .collect();
    assert!(order(&errors) > 1.8 && errors[2] < 1e-3, "{errors:?}");
}

#[test]
fn a_chain_loses_energy_to_friction_alone() {
    let chain = JenkinsChain::new(10, 2000.0, (400.0, 1.0));
    let (k, m) = (chain.stiffness.as_ref(), chain.mass.as_ref());
    let mut line = modes::linearise(k, m, &chain.force, vec![0.0; 10], chain.force.initial_state(), 3).unwrap();
    line.orient(&[1.0; 10]).unwrap();
    let mut row = vec![0.0; 10];
    row[9] = 1.0;
    let settings = Settings {
        periods: 20,
        spectral_radius: 1.0,
        ..Settings::default()
    };
    let found = go(
        &line,
        &chain.force,
        &row,
        &Start::Release { modal_force: 20.0 },
        &settings,
    );
    assert!(found.failure.is_none());
    assert!(found.energy_error() < 1e-6, "{}", found.energy_error());
    let (first, last) = (found.samples[0].energy, found.samples.last().unwrap().energy);
    assert!(last.kinetic + last.elastic < 0.2 * first.elastic);
    // Released in one mode, others take part little.
    let elsewhere = found.share_elsewhere();
    assert!(elsewhere > 0.0 && elsewhere < 0.1, "{elsewhere}");
    // The first acceleration is that of the load.
    let first = found.samples[0].acceleration + 20.0 * line.shapes[(9, 0)];
    assert!(first.abs() < 1e-12);
    assert!(found.effort.krylov_steps > 0 && found.effort.factorisations == 0);
}

#[test]
fn a_step_that_does_not_converge_is_a_status_after_halvings() {
    let oscillator = Oscillator::new(3.0, 1000.0, (500.0, 2.0));
    let settings = Settings {
        newton: NewtonSettings {
            max_iterations: 0,
            max_halvings: 3,
            ..NewtonSettings::default()
        },
        ..Settings::default()
    };
    let found = oscillator.run(&Start::Release { modal_force: 10.0 }, &settings);
    assert_eq!(found.samples.len(), 1);
    assert_eq!(found.halved_steps, 3);
    assert!(found.failure.is_some());
}

#[test]
fn inadmissible_settings_are_named() {
    let chain = JenkinsChain::new(2, 2000.0, (400.0, 1.0));
    let (k, m) = (chain.stiffness.as_ref(), chain.mass.as_ref());
    let line = modes::linearise(k, m, &chain.force, vec![0.0; 2], chain.force.initial_state(), 1).unwrap();
    let release = Start::Release { modal_force: 1.0 };
    let pulse = |impulse, duration, point| Start::Pulse {
        impulse,
        duration,
        point,
    };
    let driven = |amplitude, omega, row, size| Start::Driven {
        amplitude,
        omega,
        point: vec![1.0; row],
        motion: std::array::from_fn(|_| vec![0.0; size]),
    };
    let default = Settings::default;
    for (name, row, start, settings) in [
        ("row", vec![1.0], release.clone(), default()),
        ("row struck", vec![1.0; 2], pulse(1.0, 1.0, vec![1.0]), default()),
        ("impulse", vec![1.0; 2], pulse(f64::NAN, 1.0, vec![1.0; 2]), default()),
        ("duration", vec![1.0; 2], pulse(1.0, 0.0, vec![1.0; 2]), default()),
        (
            "modal_force",
            vec![1.0; 2],
            Start::Release { modal_force: -1.0 },
            default(),
        ),
        ("row driven", vec![1.0; 2], driven(1.0, 1.0, 1, 2), default()),
        ("motion at the start", vec![1.0; 2], driven(1.0, 1.0, 2, 1), default()),
        ("amplitude", vec![1.0; 2], driven(0.0, 1.0, 2, 2), default()),
        ("omega", vec![1.0; 2], driven(1.0, f64::INFINITY, 2, 2), default()),
        ("mode", vec![1.0; 2], release.clone(), Settings { mode: 1, ..default() }),
        (
            "steps_per_period",
            vec![1.0; 2],
            release.clone(),
            Settings {
                steps_per_period: 3,
                ..default()
            },
        ),
        (
            "spectral_radius",
            vec![1.0; 2],
            release.clone(),
            Settings {
                spectral_radius: 1.1,
                ..default()
            },
        ),
        (
            "background_damping",
            vec![1.0; 2],
            release.clone(),
            Settings {
                background_damping: -0.1,
                ..default()
            },
        ),
        (
            "other_damping",
            vec![1.0; 2],
            release,
            Settings {
                other_damping: f64::INFINITY,
                ..default()
            },
        ),
    ] {
        let error = run(&line, &chain.force, &row, &start, &settings, &mut |_| {
            ControlFlow::Continue(())
        })
        .unwrap_err();
        assert!(error.to_string().contains(name), "{name}: {error}");
    }
    for (periods, steps_per_period) in [(1_000_000_000_000, 100), (usize::MAX, usize::MAX), (100_001, 100)] {
        let settings = Settings {
            periods,
            steps_per_period,
            ..default()
        };
        let start = Start::Release { modal_force: 1.0 };
        let error = run(&line, &chain.force, &[1.0; 2], &start, &settings, &mut |_| {
            ControlFlow::Break(())
        })
        .unwrap_err();
        assert!(error.to_string().contains("1e7 steps"), "{error}");
    }
    let stopped = run(
        &line,
        &chain.force,
        &[1.0; 2],
        &Start::Release { modal_force: 1.0 },
        &default(),
        &mut |_| ControlFlow::Break(()),
    );
    assert!(matches!(stopped, Err(Error::Interrupted)));
}

/// One mode whose load never changes its place, so that nothing but the decay itself tells the motion from its loops.
#[test]
fn the_period_of_a_frictional_bar_is_that_of_the_first_harmonic_and_not_of_the_secant() {
    let bar = FrictionalBar::new(120, 6.0, 1.0, (1.0, 1.0), 1.0);
    // A spring beside it, three times as stiff as the stuck bar, lets it ring.
    let mut stiffness = bar.stiffness.clone();
    stiffness[(0, 0)] += 3.0;
    let n = stiffness.nrows();
    let mut row = vec![0.0; n];
    row[0] = 1.0;
    let (k, m) = (stiffness.as_ref(), bar.mass.as_ref());
    let mut line = modes::linearise(k, m, &bar.force, vec![0.0; n], bar.force.initial_state(), 1).unwrap();
    line.orient(&row).unwrap();
    let settings = Settings {
        steps_per_period: 400,
        periods: 12,
        ..Settings::default()
    };
    let found = go(
        &line,
        &bar.force,
        &row,
        &Start::Release { modal_force: 20.0 },
        &settings,
    );
    assert!(found.failure.is_none());
    let settings = cqsma::Settings {
        vertices_per_quarter: 64,
        ..cqsma::Settings::default()
    };
    let forces: Vec<f64> = (0..=60).map(|i| 3.0 * (7.0_f64).powf(f64::from(i) / 60.0)).collect();
    let loops: Vec<_> = cqsma::run(&line, &bar.force, &forces, &settings, |_| NoObserver)
        .unwrap()
        .into_iter()
        .map(|(point, _)| point.result.unwrap())
        .collect();
    // Reversals, by parabolas through three samples: time and displacement.
    let reversals: Vec<(f64, f64)> = found
        .samples
        .windows(3)
        .filter(|w| (w[1].displacement - w[0].displacement) * (w[2].displacement - w[1].displacement) < 0.0)
        .map(|w| {
            let [a, b, c] = [0, 1, 2].map(|i| w[i].displacement);
            let offset = 0.5 * (a - c) / (a - 2.0 * b + c);
            (w[1].time + offset * found.step, b - 0.25 * (a - c) * offset)
        })
        .collect();
    // Half ranges, which know nothing of what slip is left over, in the middle between two reversals.
    let halves: Vec<(f64, f64)> = reversals
        .windows(2)
        .map(|w| (0.5 * (w[0].0 + w[1].0), 0.5 * (w[0].1 - w[1].1).abs()))
        .collect();
    let mut seen = 0;
    for w in halves.windows(5) {
        let amplitude = w[2].1;
        let above = loops.partition_point(|l| l.modal_amplitude < amplitude);
        if above == 0 || above == loops.len() {
            continue;
        }
        let (a, b) = (&loops[above - 1], &loops[above]);
        let part = (amplitude / a.modal_amplitude).ln() / (b.modal_amplitude / a.modal_amplitude).ln();
        let between = |a: f64, b: f64| a + part * (b - a);
        let time = w[4].0 - w[0].0;
        let (turn, decay) = (2.0 * TAU / time, (w[0].1 / w[4].1).ln() / time);
        let omega = turn.hypot(decay) / found.algorithmic.frequency_ratio;
        let harmonic = between(a.hysteresis.harmonic_omega(), b.hysteresis.harmonic_omega()) / omega - 1.0;
        let secant = between(a.omega, b.omega) / omega - 1.0;
        let zeta = decay / omega;
        let damping = between(a.zeta, b.zeta) / zeta - 1.0;
        eprintln!(
            "amplitude {amplitude:.3}: omega {omega:.4}, zeta {zeta:.4}; harmonic {harmonic:+.5}, secant {secant:+.5}, \
             damping {damping:+.4}"
        );
        assert!(harmonic.abs() < 1e-3, "{harmonic} {secant}");
        assert!(damping.abs() < 0.15, "{damping}");
        seen += usize::from(secant.abs() > 4.0 * harmonic.abs());
    }
    assert!(seen >= 6, "{seen}");
}

#[test]
fn a_recorded_load_is_what_it_records() {
    // The half-sine of a pulse, sampled: the same motion but for its straight lines.
    let oscillator = Oscillator::new(3.0, 1000.0, (500.0, STUCK));
    let omega = (1500.0_f64 / 3.0).sqrt();
    let (duration, impulse) = (0.4 * TAU / omega, 2.0);
    let settings = Settings {
        steps_per_period: 400,
        periods: 5,
        ..Settings::default()
    };
    let pulse = Start::Pulse {
        impulse,
        duration,
        point: vec![1.0],
    };
    let samples = 2000;
    let step = duration / f64::from(samples);
    let values = (1..=samples).map(|k| pulse.force_at(f64::from(k) * step)).collect();
    let record = Start::Record {
        step,
        values,
        point: vec![1.0],
    };
    assert_eq!(record.force_at(0.0), 0.0);
    assert!((record.force_at(0.5 * duration) / (0.5 * PI * impulse / duration) - 1.0).abs() < 1e-12);
    assert_eq!(record.force_at(2.0 * duration), 0.0);
    let [a, b] = [&pulse, &record].map(|start| oscillator.run(start, &settings));
    let largest = a.samples.iter().map(|s| s.displacement.abs()).fold(0.0, f64::max);
    let apart = a.samples.iter().zip(&b.samples);
    let apart = apart
        .map(|(a, b)| (a.displacement - b.displacement).abs())
        .fold(0.0, f64::max);
    assert!(apart < 1e-6 * largest, "{apart} {largest}");
    for (values, step) in [(vec![], 1.0), (vec![0.0], 1.0), (vec![f64::NAN], 1.0), (vec![1.0], 0.0)] {
        let start = Start::Record {
            step,
            values,
            point: vec![1.0],
        };
        let (k, m) = (oscillator.stiffness.as_ref(), oscillator.mass.as_ref());
        let line = modes::linearise(k, m, &oscillator.force, vec![0.0], oscillator.force.initial_state(), 1).unwrap();
        let found = run(&line, &oscillator.force, &[1.0], &start, &settings, &mut |_| {
            ControlFlow::Continue(())
        });
        assert!(matches!(found, Err(Error::Setting { .. })));
    }
}

#[test]
fn a_slider_that_was_pushed_stays_where_the_springs_balance() {
    // A force that rises slowly beyond slip and falls again slowly: the mass comes to rest where the spring carries what friction is left, the closed form
    // of the static path: at the top the slider has slipped, on the way back it follows elastically and slips again if it must.
    let (k, kt, limit, peak) = (1000.0, 4000.0, 1.0, 6.0);
    let oscillator = Oscillator::new(1.0, k, (kt, limit));
    let omega = ((k + kt) / 1.0_f64).sqrt();
    let periods = 400;
    let duration = 0.6 * f64::from(periods) * TAU / omega;
    let steps = 4000;
    let step = duration / f64::from(steps);
    let values = (1..steps)
        .map(|i| peak * (PI * f64::from(i) / f64::from(steps)).sin().powi(2))
        .collect();
    let start = Start::Record {
        step,
        values,
        point: vec![1.0],
    };
    let settings = Settings {
        steps_per_period: 40,
        periods: periods as usize,
        background_damping: 0.02,
        ..Settings::default()
    };
    let found = oscillator.run(&start, &settings);
    assert!(found.failure.is_none());
    // Up: k u + limit = peak. Down: friction would be limit - kt (u_top - u), until it reaches -limit.
    let top = (peak - limit) / k;
    let rest = (kt * top - limit) / (k + kt);
    let friction = limit - kt * (top - rest);
    let expected = if friction < -limit { limit / k } else { rest };
    let settled = found.settled[0];
    assert!((settled / expected - 1.0).abs() < 1e-3, "{settled} for {expected}");
}
