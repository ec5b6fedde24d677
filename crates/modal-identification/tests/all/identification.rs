//! Backbones of ring-downs whose frequency and damping are known, and what is said of those that are not sound.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::f64::consts::TAU;

use modal_identification::average::average;
use modal_identification::backbone::{End, Identification, Point, Settings, identify};
use modal_identification::signal::{Channel, Quantity, Signal, Stated, Timing};
use modal_identification::synthetic::{RingDown, add_noise};
use modal_identification::{Error, Warning};

fn signal(samples: Vec<f64>, rate: f64, unit: &str) -> (Signal, Vec<Warning>) {
    let channel = Channel {
        name: "acc".into(),
        unit: Some(unit.into()),
        timing: Timing::Rate(rate),
        samples,
    };
    Signal::try_new("synthetic", &channel, &Stated::default()).unwrap()
}

fn frequency(a: f64) -> f64 {
    180.0 - 0.02 * a
}

fn damping_ratio(a: f64) -> f64 {
    0.001 + 9e-5 * a
}

/// From amplitude 100 on: the frequency rises from 178 to 180 Hz, the damping ratio falls from 1 to 0.1 %.
fn joint(rate: f64, seconds: f64) -> Vec<f64> {
    let mode = RingDown {
        amplitude: 100.0,
        phase: 0.3,
        frequency,
        damping_ratio,
    };
    mode.samples(rate, (rate * seconds) as usize)
}

fn linear(amplitude: f64, f: f64, zeta: f64, rate: f64, seconds: f64) -> Vec<f64> {
    let mode = RingDown {
        amplitude,
        phase: -0.7,
        frequency: |_| f,
        damping_ratio: |_| zeta,
    };
    mode.samples(rate, (rate * seconds) as usize)
}

fn sum(mut a: Vec<f64>, b: &[f64]) -> Vec<f64> {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    a
}

fn settings(bandwidth: f64) -> Settings {
    Settings {
        frequency: Some(180.0),
        bandwidth: Some(bandwidth),
        ..Settings::default()
    }
}

/// Largest errors of frequency (Hz) and damping ratio (relative) at the amplitudes found.
fn errors(backbone: &[Point]) -> [f64; 2] {
    let largest = |error: &dyn Fn(&Point) -> f64| backbone.iter().map(|p| error(p).abs()).fold(0.0, f64::max);
    [
        largest(&|p| p.frequency_hz - frequency(p.amplitude)),
        largest(&|p| p.damping_ratio / damping_ratio(p.amplitude) - 1.0),
    ]
}

#[test]
fn the_generator_is_exact_for_a_linear_mode() {
    let (rate, zeta) = (7200.0, 0.01);
    let omega = TAU * 180.0;
    for (i, found) in linear(3.0, 180.0, zeta, rate, 1.0).iter().enumerate() {
        let t = i as f64 / rate;
        let expected = 3.0 * (-zeta * omega * t).exp() * (omega * (1.0 - zeta * zeta).sqrt() * t - 0.7).cos();
        assert!((found - expected).abs() < 1e-9, "{i}");
    }
}

#[test]
fn clean_ring_downs_at_any_rate_and_bandwidth() {
    for per_cycle in [6.0, 8.0, 13.3, 25.0, 39.9, 40.0, 63.7, 160.0] {
        for bandwidth in [20.0, 40.0, 60.0] {
            let rate = 180.0 * per_cycle;
            let (signal, warnings) = signal(joint(rate, 4.0), rate, "m/s^2");
            assert!(warnings.is_empty(), "{warnings:?}");
            let found = identify(&signal, &settings(bandwidth)).unwrap();
            let [f, zeta] = errors(&found.backbone);
            assert!(
                f <= 0.005 && zeta <= 0.002,
                "{per_cycle} per cycle, {bandwidth} Hz: {f} Hz, {zeta} of zeta"
            );
            assert!(found.warnings.is_empty(), "{:?}", found.warnings);
            assert!(found.backbone[0].amplitude > 50.0 && found.backbone.last().unwrap().amplitude < 0.3);
            let check = found.cross_check.unwrap();
            assert!(check.points > 500 && check.frequency_median < 1e-3 && check.damping_median < 1e-3);
            assert!(check.amplitude_median < 1e-3);
        }
    }
}

#[test]
fn an_oscillator_integrated_in_time_has_the_backbone_of_the_textbook() {
    // x'' + 2 zeta w x' + w^2 x + k x^3 = 0: w(a) = w + 3 k a^2/(8 w) to first order in k (A. H. Nayfeh, D. T. Mook,
    // Nonlinear Oscillations, 1979, section 2.3); the first harmonic of the displacement has the amplitude a.
    let (omega, zeta, rate) = (TAU * 180.0, 0.004, 7200.0);
    let cubic = -0.02 * omega * omega;
    let rhs = |[x, v]: [f64; 2]| [v, -2.0 * zeta * omega * v - omega * omega * x - cubic * x * x * x];
    let mut state = [1.0, 0.0];
    let (substeps, count) = (8, 7200 * 2);
    let step = 1.0 / rate / f64::from(substeps);
    let mut samples = Vec::new();
    for _ in 0..count {
        samples.push(state[0]);
        for _ in 0..substeps {
            let ahead = |k: [f64; 2], h: f64| [state[0] + h * k[0], state[1] + h * k[1]];
            let k1 = rhs(state);
            let k2 = rhs(ahead(k1, 0.5 * step));
            let k3 = rhs(ahead(k2, 0.5 * step));
            let k4 = rhs(ahead(k3, step));
            for i in 0..2 {
                state[i] += step * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0;
            }
        }
    }
    let (signal, _) = signal(samples, rate, "m");
    let found = identify(&signal, &settings(40.0)).unwrap();
    assert_eq!(found.quantity, Quantity::Displacement);
    for point in &found.backbone {
        let a = point.amplitude;
        let expected = (omega + 3.0 * cubic * a * a / (8.0 * omega)) / TAU;
        // The second order in k: 15/256 (k a^2/w^2)^2 w.
        let second = 0.1 * (cubic * a * a / (omega * omega)).powi(2) * 180.0;
        assert!(
            (point.frequency_hz - expected).abs() < 1e-3 + second,
            "{point:?} {expected}"
        );
        // Viscous damping takes the action, w(a) a^2/2 to first order in k, with the rate 2 zeta w.
        let slope = 3.0 * cubic * a / (4.0 * omega);
        let decay = zeta * omega / (1.0 + 0.5 * slope * a / (TAU * expected));
        let found = point.damping_ratio * TAU * point.frequency_hz;
        assert!((found / decay - 1.0).abs() < 1e-3, "{point:?} {found} {decay}");
    }
    assert!(found.backbone[0].frequency_hz < 179.5);
}

#[test]
fn noise_and_a_neighbour_cost_what_the_table_says() {
    let rate = 180.0 * 40.0;
    let neighbour = linear(50.0, 230.0, 0.002, rate, 4.0);
    let (alone, _) = signal(sum(joint(rate, 4.0), &neighbour), rate, "m/s^2");
    let found = identify(&alone, &settings(20.0)).unwrap();
    let [f, zeta] = errors(&found.backbone);
    assert!(f < 0.05 && zeta < 0.03, "{f} {zeta}");
    // A bandwidth that lets it in is named by a warning.
    let found = identify(&alone, &settings(60.0)).unwrap();
    let named = found
        .warnings
        .iter()
        .any(|w| matches!(w, Warning::OtherMode { frequency, .. } if (frequency - 230.0).abs() < 0.5));
    assert!(named, "{:?}", found.warnings);

    let mut noisy = joint(rate, 4.0);
    add_noise(&mut noisy, 1.0, 3);
    let (signal, _) = signal(noisy, rate, "m/s^2");
    let found = identify(&signal, &settings(20.0)).unwrap();
    assert_eq!(found.trims.reason, End::Noise);
    // White noise of 1 over 3600 Hz, of which 20 Hz pass.
    let expected = (2.0 * 20.0 * 1.026 / 3600.0_f64).sqrt();
    assert!(
        (found.noise_amplitude / expected - 1.0).abs() < 0.15,
        "{} {expected}",
        found.noise_amplitude
    );
    let loud: Vec<Point> = found.backbone.iter().filter(|p| p.amplitude > 10.0).copied().collect();
    let [f, zeta] = errors(&loud);
    assert!(f < 0.1 && zeta < 0.2, "{f} {zeta}");
}

#[test]
fn two_modes_in_the_band_are_refused_by_name() {
    let rate = 7200.0;
    for (f, amplitude, zeta) in [
        (186.0, 30.0, 0.001),
        (176.0, 80.0, 0.002),
        (184.0, 100.0, 0.001),
        (187.0, 200.0, 0.001),
    ] {
        let both = sum(
            linear(100.0, 180.0, 0.0015, rate, 4.0),
            &linear(amplitude, f, zeta, rate, 4.0),
        );
        let (signal, _) = signal(both, rate, "m/s^2");
        match identify(&signal, &settings(20.0)) {
            Err(Error::TwoModes { first, second, .. }) => {
                let near = |a: f64, b: f64| (a - b).abs() < 0.2;
                assert!(
                    near(first, 180.0) && near(second, f) || near(first, f) && near(second, 180.0),
                    "{f}: {first}, {second}"
                );
            }
            other => panic!("{f}: {:?}", other.map(|o| o.warnings)),
        }
        // Beats so fast that extrema do not follow one another in turn.
        let wide = sum(
            linear(100.0, 180.0, 0.003, rate, 2.0),
            &linear(80.0, 230.0, 0.003, rate, 2.0),
        );
        let found = identify(&self::signal(wide, rate, "m/s^2").0, &settings(140.0));
        assert!(matches!(found, Err(Error::TwoModes { .. })));
        // A band that holds one of them is enough where they are far enough apart.
        if f == 187.0 {
            assert!(identify(&signal, &settings(4.0)).is_ok());
        }
    }
}

#[test]
fn one_mode_that_changes_much_is_not_taken_for_two() {
    let rate = 7200.0;
    for (drop, rise) in [(4.0, 0.01), (8.0, 0.02), (12.0, 0.03), (15.0, 0.005)] {
        let mode = RingDown {
            amplitude: 100.0,
            phase: 0.0,
            frequency: |a: f64| 180.0 - drop * a / 100.0,
            damping_ratio: |a: f64| 0.0005 + rise * a / 100.0,
        };
        let (signal, _) = signal(mode.samples(rate, 36_000), rate, "m/s^2");
        let found = identify(&signal, &settings(50.0)).unwrap();
        for p in &found.backbone {
            assert!(
                (p.frequency_hz - 180.0 + drop * p.amplitude / 100.0).abs() < 0.2,
                "{drop}, {rise}: {p:?}"
            );
        }
    }
}

#[test]
fn units_scale_and_quantity_convert() {
    let rate = 7200.0;
    let samples = joint(rate, 4.0);
    let standard = identify(&signal(samples.clone(), rate, "m/s^2").0, &settings(20.0)).unwrap();
    let thousandths: Vec<f64> = samples.iter().map(|v| 1000.0 * v).collect();
    let small = identify(&signal(thousandths, rate, "mm/s^2").0, &settings(20.0)).unwrap();
    let compare = |a: &Identification, b: &Identification, scale: &dyn Fn(&Point) -> f64| {
        assert_eq!(a.backbone.len(), b.backbone.len());
        for (p, q) in a.backbone.iter().zip(&b.backbone) {
            let near = |x: f64, y: f64| (x / y - 1.0).abs() < 1e-9;
            assert!(near(p.amplitude * scale(p), q.amplitude) && near(p.frequency_hz, q.frequency_hz));
            assert!(near(p.damping_ratio, q.damping_ratio));
        }
    };
    compare(&standard, &small, &|_| 1.0);
    let displacement = Settings {
        quantity: Some(Quantity::Displacement),
        ..settings(20.0)
    };
    let converted = identify(&signal(samples, rate, "m/s^2").0, &displacement).unwrap();
    assert_eq!(converted.quantity, Quantity::Displacement);
    compare(&standard, &converted, &|p| (TAU * p.frequency_hz).powi(-2));
}

#[test]
fn the_loudest_mode_is_found_without_a_frequency() {
    let rate = 7200.0;
    let both = sum(joint(rate, 4.0), &linear(20.0, 610.0, 0.001, rate, 4.0));
    let found = identify(&signal(both, rate, "m/s^2").0, &Settings::default()).unwrap();
    assert!((found.peak_hz - 180.0).abs() < 0.5, "{}", found.peak_hz);
    assert!((found.band_hz[1] - found.band_hz[0] - 20.0).abs() < 0.1);
}

#[test]
fn clipping_and_further_hits_are_left_out_and_reported() {
    let rate = 7200.0;
    let mut samples = vec![0.0; 1000];
    samples.extend(joint(rate, 2.0));
    samples.extend(joint(rate, 4.0).iter().map(|v| 0.5 * v));
    let (both, _) = signal(samples.clone(), rate, "m/s^2");
    let found = identify(&both, &settings(40.0)).unwrap();
    assert_eq!(found.trims.reason, End::LaterExcitation);
    assert!(found.trims.end < 1000.0 / rate + 2.0);
    assert!(
        matches!(found.warnings[..], [Warning::LaterExcitation { .. }]),
        "{:?}",
        found.warnings
    );
    let [f, zeta] = errors(&found.backbone);
    assert!(f < 0.005 && zeta < 0.005, "{f} {zeta}");

    let mut weak_first: Vec<f64> = joint(rate, 2.0).iter().map(|v| 0.5 * v).collect();
    weak_first.extend(joint(rate, 4.0));
    let found = identify(&signal(weak_first, rate, "m/s^2").0, &settings(40.0)).unwrap();
    assert!((found.trims.hit - 2.0).abs() < 0.01);
    assert!(
        matches!(found.warnings[..], [Warning::EarlierExcitation { .. }]),
        "{:?}",
        found.warnings
    );

    let clipped = joint(rate, 4.0).iter().map(|v| v.clamp(-70.0, 70.0)).collect();
    let (signal, warnings) = signal(clipped, rate, "m/s^2");
    let [Warning::Clipped { last, .. }] = warnings[..] else {
        panic!("{warnings:?}")
    };
    let found = identify(&signal, &settings(40.0)).unwrap();
    assert!(found.trims.hit >= last - 1e-9 && found.backbone[0].time > last);
    let [f, zeta] = errors(&found.backbone);
    assert!(f < 0.005 && zeta < 0.002, "{f} {zeta}");
}

#[test]
fn several_hits_are_averaged_with_their_spread() {
    let rate = 7200.0;
    let hits: Vec<Vec<Point>> = (0..5)
        .map(|seed| {
            let mut samples = joint(rate, 4.0);
            // The last hit is weaker.
            let skip = if seed == 4 { 3600 } else { 0 };
            add_noise(&mut samples, 0.1, seed);
            let (signal, _) = signal(samples[skip..].to_vec(), rate, "m/s^2");
            identify(&signal, &settings(20.0)).unwrap().backbone
        })
        .collect();
    let hits: Vec<&[Point]> = hits.iter().map(Vec::as_slice).collect();
    let mean = average(&hits, 60).unwrap();
    assert!(mean.is_sorted_by(|a, b| a.amplitude < b.amplitude));
    assert_eq!(
        mean[59].amplitude,
        hits.iter().map(|h| h[0].amplitude).fold(0.0, f64::max)
    );
    let (middle, loud) = (&mean[30], &mean[55]);
    assert_eq!((middle.hits, loud.hits), (5, 4));
    for point in [middle, loud] {
        let [f, zeta] = point.spread.unwrap();
        assert!((1e-5..0.05).contains(&f), "{point:?}");
        assert!(
            (point.frequency_hz - frequency(point.amplitude)).abs() < 3.0 * f + 1e-3,
            "{point:?}"
        );
        assert!(
            (point.damping_ratio - damping_ratio(point.amplitude)).abs() < 3.0 * zeta + 1e-5,
            "{point:?}"
        );
    }
    // Two points on a line give their mean and half their distance times sqrt 2.
    let line = |shift: f64| {
        [2.0, 1.0].map(|amplitude| Point {
            time: 0.0,
            amplitude,
            frequency_hz: 100.0 + shift,
            damping_ratio: 0.01,
        })
    };
    let mean = average(&[&line(0.0), &line(2.0)], 3).unwrap();
    assert_eq!(mean[1].frequency_hz, 101.0);
    assert!((mean[1].spread.unwrap()[0] - 2.0_f64.sqrt()).abs() < 1e-12);
    assert_eq!(average(&[&line(0.0)], 3).unwrap()[0].spread, None);
    for bad in [
        average(&[], 3),
        average(&[&[]], 3),
        average(&[&line(0.0)], 1),
        average(&[&line(0.0), &line(2.0)], 1_000_000_000),
    ] {
        assert!(matches!(bad, Err(Error::Average { .. })));
    }
}

#[test]
fn what_cannot_be_identified_is_an_error() {
    let rate = 7200.0;
    let short = signal(joint(rate, 0.2), rate, "m/s^2").0;
    assert!(matches!(
        identify(&short, &settings(20.0)),
        Err(Error::TooFewCycles { .. })
    ));
    let sound = signal(joint(rate, 4.0), rate, "m/s^2").0;
    let base = settings(20.0);
    for bad in [
        Settings {
            frequency: Some(f64::NAN),
            ..base.clone()
        },
        Settings {
            frequency: Some(-1.0),
            ..base.clone()
        },
        Settings {
            frequency: Some(3000.0),
            ..base.clone()
        },
        Settings {
            bandwidth: Some(0.0),
            ..base.clone()
        },
        Settings {
            // Rounding would make the filter unstable.
            frequency: None,
            bandwidth: Some(1e-11),
            ..base.clone()
        },
        Settings {
            bandwidth: Some(400.0),
            ..base.clone()
        },
        Settings {
            start: Some(5.0),
            ..base.clone()
        },
        Settings {
            smoothing: 20,
            ..base.clone()
        },
        Settings {
            // No memory could hold it.
            smoothing: usize::MAX,
            ..base.clone()
        },
        Settings {
            noise_margin: 0.5,
            ..base.clone()
        },
    ] {
        let error = identify(&sound, &bad).unwrap_err();
        assert!(matches!(error, Error::Setting(_)), "{error}");
    }
    // A ramp has no peak in its spectrum near 180 Hz, or nothing that rings down.
    let ramp = signal((0..20_000).map(f64::from).collect(), rate, "m/s^2").0;
    assert!(identify(&ramp, &base).is_err());
    let one = signal((0..2000).map(|i| f64::from(i == 1000)).collect(), rate, "m/s^2").0;
    assert!(identify(&one, &base).is_err());
}
