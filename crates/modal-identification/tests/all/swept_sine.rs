//! Swept-sine tests against the oscillators that made them.

use modal_identification::Error;
use modal_identification::signal::{Channel, Force, Quantity, Signal, Stated, Timing};
use modal_identification::stepped_sine::{Fitted, Level};
use modal_identification::swept_sine::{Sweep, steps};
use rand::{RngExt, SeedableRng};
use std::f64::consts::{PI, TAU};

const MASS: f64 = 0.7;
const RATE: f64 = 8000.0;

/// Frequency near which the oscillators have their resonance (Hz).
const NEAR: f64 = 160.0;

fn stiffness() -> f64 {
    MASS * (TAU * NEAR).powi(2)
}

/// A sweep of the frequency from the first to the second at a rate: times, phases and angular frequencies.
fn sweep(from: f64, to: f64, hz_per_s: f64) -> Vec<(f64, f64)> {
    let count = ((to - from).abs() / hz_per_s * RATE) as usize;
    let slope = (to - from).signum() * hz_per_s;
    let at = |i: usize| {
        let time = i as f64 / RATE;
        (TAU * (from + 0.5 * slope * time) * time, TAU * (from + slope * time))
    };
    (0..count).map(at).collect()
}

fn swept(force: Vec<f64>, response: Vec<f64>, unit: &str) -> Result<(Level, Sweep), Error> {
    let channel = |name: &str, unit: &str, samples| Channel {
        name: name.into(),
        unit: Some(unit.into()),
        timing: Timing::Rate(RATE),
        samples,
    };
    let (force, _) = Force::try_new("sweep", &channel("shaker", "N", force), &Stated::default())?;
    let (response, _) = Signal::try_new("sweep", &channel("tip", unit, response), &Stated::default())?;
    steps("tip", &force, &response)
}

fn fitted(force: Vec<f64>, response: Vec<f64>, unit: &str) -> (Level, Sweep, Fitted) {
    let (level, sweep) = swept(force, response, unit).expect("a sweep");
    let fit = level.fit(None).expect("a mode");
    (level, sweep, fit)
}

/// What a Jenkins element with this stiffness and limit of force passes on along a motion.
fn jenkins(motion: &[f64], stiffness: f64, limit: f64) -> Vec<f64> {
    let mut slid = 0.0;
    let mut force = |x: &f64| {
        let trial = stiffness * (x - slid);
        let held = trial.clamp(-limit, limit);
        slid = x - held / stiffness;
        held
    };
    motion.iter().map(&mut force).collect()
}

#[test]
fn a_response_that_is_held_gives_the_equivalent_mode_of_a_jenkins_element() {
    let (own, limit, zeta) = (0.06 * stiffness(), 20.0, 1e-3);
    let sticks = limit / own;
    for (times, from, to) in [(0.5, 156.0, 174.0), (1.6, 155.0, 173.0), (4.0, 170.0, 152.0)] {
        let amplitude = times * sticks;
        let path = sweep(from, to, 1.0);
        let motion: Vec<f64> = path.iter().map(|(phase, _)| amplitude * phase.cos()).collect();
        let slope = TAU * (to - from).signum();
        let damping = 2.0 * MASS * zeta * TAU * NEAR;
        let accelerations: Vec<f64> = path
            .iter()
            .map(|(phase, omega)| -amplitude * (omega * omega * phase.cos() + slope * phase.sin()))
            .collect();
        let mut force = jenkins(&motion, own, limit);
        for (at, (phase, omega)) in path.iter().enumerate() {
            let velocity = -amplitude * omega * phase.sin();
            force[at] += MASS * accelerations[at] + damping * velocity + stiffness() * motion[at];
        }
        // Closed form of the first harmonic of the element.
        let angle = if times > 1.0 { (1.0 - 2.0 / times).acos() } else { PI };
        let stiffness = stiffness() + own / PI * (angle - 0.5 * (2.0 * angle).sin());
        let natural = (stiffness / MASS).sqrt();
        let lost = 4.0 * limit * (amplitude - sticks).max(0.0) / (PI * amplitude * amplitude);
        let expected = 0.5 * (damping * natural + lost) / stiffness;
        for (unit, scale, response, quantity) in [
            ("um", 1e6, &motion, Quantity::Displacement),
            ("g", 1.0 / 9.80665, &accelerations, Quantity::Acceleration),
        ] {
            // Noise of a thousandth of the response, and an offset.
            let mut random = rand_pcg::Pcg64::seed_from_u64(3);
            let size = response.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            let noisy: Vec<f64> = response
                .iter()
                .map(|v| scale * (v + size * (0.1 + 2e-3 * (random.random::<f64>() - 0.5))))
                .collect();
            let (level, swept, found) = fitted(force.clone(), noisy, unit);
            let errors = [
                TAU * found.frequency_hz / natural - 1.0,
                found.damping_ratio / expected - 1.0,
                found.modal_mass / MASS - 1.0,
            ];
            println!(
                "{times} {unit} {errors:?} {:?} {:.1e}",
                swept.rate_hz_per_s, swept.distortion
            );
            assert_eq!(level.quantity, quantity);
            assert!(
                errors[0].abs() < 2e-5 && errors[1].abs() < 5e-3 && errors[2].abs() < 5e-3,
                "{errors:?}"
            );
        }
    }
}

#[test]
fn a_force_that_is_held_gives_a_linear_mode_up_to_the_rate_of_slow_sweeps() {
    let zeta = 0.004;
    let natural = TAU * NEAR;
    let limit = 2.0 * (zeta * NEAR).powi(2);
    for (from, to, times) in [(150.0, 170.0, 0.5), (190.0, 130.0, 1.0)] {
        // A force that is held, and the motion by the fourth order of Runge and Kutta.
        let path = sweep(from, to, times * limit);
        let force: Vec<f64> = path.iter().map(|(phase, _)| 3.0 * phase.cos()).collect();
        let mut motion = vec![0.0; force.len()];
        let (mut x, mut v) = (0.0, 0.0);
        let parts = 8;
        for at in 1..force.len() {
            let slope = (to - from).signum() * times * limit;
            for part in 0..parts {
                let step = 1.0 / RATE / f64::from(parts);
                let begin = (at - 1) as f64 / RATE + f64::from(part) * step;
                let load = |time: f64| 3.0 * (TAU * (from + 0.5 * slope * time) * time).cos() / MASS;
                let acceleration =
                    |time: f64, x: f64, v: f64| load(time) - 2.0 * zeta * natural * v - natural * natural * x;
                let first = (v, acceleration(begin, x, v));
                let middle = begin + 0.5 * step;
                let half = 0.5 * step;
                let second = (
                    v + half * first.1,
                    acceleration(middle, x + half * first.0, v + half * first.1),
                );
                let third = (
                    v + half * second.1,
                    acceleration(middle, x + half * second.0, v + half * second.1),
                );
                let last = (
                    v + step * third.1,
                    acceleration(begin + step, x + step * third.0, v + step * third.1),
                );
                x += step / 6.0 * (first.0 + 2.0 * second.0 + 2.0 * third.0 + last.0);
                v += step / 6.0 * (first.1 + 2.0 * second.1 + 2.0 * third.1 + last.1);
            }
            motion[at] = x;
        }
        let (_, swept, found) = fitted(force, motion, "m");
        let errors = [
            found.frequency_hz / NEAR - 1.0,
            found.damping_ratio / zeta - 1.0,
            found.modal_mass / MASS - 1.0,
        ];
        println!("{times} {errors:?} {found:?} {:?}", swept.rate_hz_per_s);
        assert!(
            errors[0].abs() < 2e-6 && errors[1].abs() < 2e-3 && errors[2].abs() < 2e-3,
            "{errors:?}"
        );
    }
}

#[test]
fn what_is_no_sweep_is_refused() {
    let record = |path: &[(f64, f64)]| -> Vec<f64> { path.iter().map(|(phase, _)| phase.cos()).collect() };
    let lagging = |path: &[(f64, f64)]| -> Vec<f64> { path.iter().map(|(phase, _)| phase.sin()).collect() };
    let up = sweep(150.0, 170.0, 10.0);
    let (force, response) = (record(&up), lagging(&up));
    let told = |force: Vec<f64>, response: Vec<f64>| match swept(force, response, "m") {
        Err(Error::NoSweep { what, .. }) => what,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("accepted"),
    };
    assert!(told(force[1..].to_vec(), response.clone()).contains("samples at 8000 Hz"));
    assert!(told(force[..600].to_vec(), response[..600].to_vec()).contains("windows"));
    // Up and down again.
    let turn = up[up.len() - 1].0;
    let down = sweep(170.0, 150.0, 10.0)
        .into_iter()
        .map(|(phase, omega)| (turn + phase, omega));
    let both: Vec<(f64, f64)> = up.iter().copied().chain(down).collect();
    let told_of_path = told(record(&both), lagging(&both));
    assert!(told_of_path.contains("by a path of"), "{told_of_path}");

    let refused = swept([1.0, 2.0].repeat(100), response[..200].to_vec(), "furlong").expect_err("refused");
    assert!(matches!(refused, Error::UnknownUnit { .. }), "{refused}");
    for (unit, size) in [
        ("kN", Some(1e3)),
        ("2.5 N", Some(2.5)),
        ("lbf", Some(4.4482216152605)),
        ("kg", None),
        ("n", None),
    ] {
        let found = unit
            .parse::<modal_identification::signal::ForceUnit>()
            .ok()
            .map(|unit| unit.scale);
        assert_eq!(found, size, "{unit}");
    }
}
