//! Stationary random vibration against closed forms, and against long motions in time.

use cqsma_solver::Error;
use cqsma_solver::random::{AmplitudeCurve, Oscillator, Spectrum, Transfer, dissipated_power};
use std::f64::consts::{PI, TAU};

/// One-sided white noise of density 1 between two frequencies (Hz).
fn white(from: f64, to: f64) -> Spectrum {
    Spectrum::try_new(vec![[from, 1.0], [to, 1.0]]).expect("a spectrum")
}

/// Mean square of an oscillator of unit mass under white noise of density 1 from zero to a frequency (Hz) in closed form (Crandall and Mark, Random
/// Vibration in Mechanical Systems, 1963, equation 2.49), without cancellation.
fn exact(omega: f64, zeta: f64, to: f64) -> f64 {
    let (r, root) = (TAU * to / omega, (1.0 - zeta * zeta).sqrt());
    let angle = (2.0 * zeta * r).atan2(1.0 - r * r);
    let log = ((1.0 + r * r + 2.0 * root * r) / (1.0 + r * r - 2.0 * root * r)).ln();
    (angle / PI + zeta / (2.0 * PI * root) * log) / (8.0 * zeta * omega.powi(3))
}

#[test]
fn mean_squares_of_a_linear_mode_are_those_of_the_closed_form() {
    let omega = TAU * 100.0;
    for zeta in [1e-5, 1e-3, 0.02, 0.3] {
        let oscillator = Oscillator {
            omega,
            zeta,
            load: 2.0,
            response: 3.0,
        };
        for [from, to] in [[1e-3, 1e4], [99.9, 100.1], [100.0, 150.0], [120.0, 130.0], [1.0, 90.0]] {
            let expected = 4.0 * (exact(omega, zeta, to) - exact(omega, zeta, from));
            let found = oscillator.mean_square(&white(from, to));
            assert!(
                (found / expected - 1.0).abs() < 1e-8,
                "zeta {zeta}, {from} to {to} Hz: {found} for {expected}"
            );
            let transfer = Transfer {
                oscillators: vec![oscillator],
                remainder: 0.0,
                carried: 0.0,
            };
            let squares = transfer.mean_squares(&white(from, to));
            assert!((squares.displacement / (9.0 * found) - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn the_mean_square_of_a_spectrum_is_its_integral() {
    // 1/f^2 from 1 to 2 Hz, then 1/f, then flat.
    let points = vec![[1.0, 4.0], [2.0, 1.0], [8.0, 0.25], [10.0, 0.25]];
    let spectrum = Spectrum::try_new(points).expect("a spectrum");
    let expected = 4.0 * (1.0 - 0.5) + 2.0 * 4.0_f64.ln() + 0.25 * 2.0;
    assert!((spectrum.mean_square() / expected - 1.0).abs() < 1e-14);
    assert_eq!(spectrum.density(0.99), 0.0);
    assert!((spectrum.density(4.0) - 0.5).abs() < 1e-15);
    assert!((spectrum.scaled(9.0).density(4.0) - 4.5).abs() < 1e-14);
}

#[test]
fn supports_that_move_slowly_carry_the_response_point_with_them() {
    let transfer = Transfer {
        oscillators: vec![Oscillator {
            omega: TAU * 100.0,
            zeta: 0.01,
            load: -1.0,
            response: 1.0,
        }],
        remainder: 0.0,
        carried: 1.0,
    };
    let spectrum = white(0.1, 0.2);
    let squares = transfer.mean_squares(&spectrum);
    assert!((squares.acceleration / spectrum.mean_square() - 1.0).abs() < 1e-5);
    // Above its resonance a mass on a spring stays where it is.
    let spectrum = white(1e4, 2e4);
    let share = transfer.mean_squares(&spectrum).acceleration / spectrum.mean_square();
    assert!(share < 1e-3, "{share}");
}

#[test]
fn spectra_and_curves_that_are_none_are_refused() {
    let spectrum = |points: &[[f64; 2]]| match Spectrum::try_new(points.to_vec()) {
        Err(Error::Setting { value, .. }) => value,
        other => panic!("{other:?}"),
    };
    assert_eq!(spectrum(&[[10.0, 1.0]]), 1.0);
    assert_eq!(spectrum(&[[10.0, 1.0], [20.0, -2.0]]), -2.0);
    assert_eq!(spectrum(&[[20.0, 1.0], [10.0, 2.0]]), 10.0);
    assert!(spectrum(&[[10.0, 1.0], [20.0, f64::NAN]]).is_nan());
    for curve in [&[][..], &[[1.0, 1.0, 0.0]], &[[1.0, 1.0, 0.1], [1.0, 1.0, 0.1]]] {
        assert!(matches!(AmplitudeCurve::try_new(curve), Err(Error::Setting { .. })));
    }
}

#[test]
fn a_linear_backbone_is_the_linear_oscillator_at_every_level() {
    let curve = AmplitudeCurve::try_new(&[[1e-6, 600.0, 0.01], [1e-3, 600.0, 0.01]]).expect("a curve");
    let oscillator = Oscillator {
        omega: 600.0,
        zeta: 0.01,
        load: 0.5,
        response: 0.0,
    };
    for level in [1e-12, 1.0, 1e12] {
        let spectrum = Spectrum::try_new(vec![[20.0, 0.1], [90.0, 3.0], [400.0, 0.01]]).expect("a spectrum");
        let spectrum = spectrum.scaled(level);
        let found = curve.stationary(0.5, &spectrum);
        let expected = oscillator.mean_square(&spectrum).sqrt();
        assert!((found.sigma / expected - 1.0).abs() < 1e-12, "{level}");
        assert!((found.omega / 600.0 - 1.0).abs() < 1e-12 && (found.zeta / 0.01 - 1.0).abs() < 1e-9);
    }
    let rest = curve.stationary(0.0, &white(10.0, 200.0));
    assert_eq!([rest.sigma, rest.zeta], [0.0, 0.01]);
}

/// A mass of 1 kg on a spring, and on another one that slips beyond a force.
struct Jenkins {
    elastic: f64,
    stuck: f64,
    slip: f64,
    background: f64,
}

impl Jenkins {
    /// Frequency and damping of harmonic motions in closed form.
    fn curve(&self) -> AmplitudeCurve {
        let begins = self.slip / self.stuck;
        let point = |i: i32| {
            let a = begins * 10.0_f64.powf(f64::from(i) / 20.0);
            let (stiffness, lost) = match a > begins {
                true => {
                    let angle = (1.0 - 2.0 * begins / a).acos();
                    let share = (angle - 0.5 * (2.0 * angle).sin()) / PI;
                    (self.elastic + self.stuck * share, 4.0 * self.slip * (a - begins))
                }
                false => (self.elastic + self.stuck, 0.0),
            };
            let omega = stiffness.sqrt();
            [a, omega, lost / (2.0 * PI * omega * omega * a * a) + self.background]
        };
        AmplitudeCurve::try_new(&(-60..=40).map(point).collect::<Vec<_>>()).expect("a curve")
    }

    /// Root of the mean square of a motion in time, and the power that comes in and goes out again, under white noise of one-sided density `density`.
    fn motion(&self, density: f64, periods: usize) -> [f64; 2] {
        let omega = (self.elastic + self.stuck).sqrt();
        let steps = 200;
        let h = TAU / omega / f64::from(steps);
        let damping = 2.0 * self.background * omega;
        // Samples that hold for a step have a flat density up to the frequency of sampling.
        let scale = (0.5 * density / h).sqrt();
        let mut seed = 1_u64;
        let mut uniform = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((seed >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        let mut normal = || (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos();
        let (mut x, mut v, mut friction) = (0.0, 0.0, 0.0);
        let (mut square, mut count) = (0.0, 0.0);
        let all = periods * steps as usize;
        for step in 0..all {
            let force = scale * normal();
            v += h * (force - self.elastic * x - friction - damping * v);
            x += h * v;
            friction = (friction + self.stuck * h * v).clamp(-self.slip, self.slip);
            if step > all / 20 {
                square += x * x;
                count += 1.0;
            }
        }
        [(square / count).sqrt(), 0.25 * density]
    }
}

#[test]
fn a_jenkins_oscillator_moves_as_much_as_in_long_motions_in_time() {
    let oscillator = Jenkins {
        elastic: 7.0e5,
        stuck: 3.0e5,
        slip: 3.0,
        background: 0.002,
    };
    let curve = oscillator.curve();
    // Almost everything sticks; slip begins; most of it slips.
    for (density, expected_state) in [(0.002, "sticks"), (0.4, "begins to slip"), (6.0, "slips")] {
        let found = curve.stationary(
            1.0,
            &Spectrum::try_new(vec![[0.1, density], [2e4, density]]).expect("a spectrum"),
        );
        let [sigma, power] = oscillator.motion(density, 40_000);
        let error = found.sigma / sigma - 1.0;
        println!(
            "{expected_state}: rms {:.4e} for {sigma:.4e} ({error:+.3}), damping {:.4}, power {:.4e} for {power:.4e}",
            found.sigma,
            found.zeta,
            dissipated_power(&found)
        );
        assert!(error.abs() < 0.05, "{expected_state}: {error}");
        assert!((dissipated_power(&found) / power - 1.0).abs() < 0.02);
    }
}
