//! The filter against closed forms.

use std::f64::consts::{PI, TAU};

use modal_identification::Error;
use modal_identification::filter::{BandPass, NOISE_BANDWIDTH};
use modal_identification::smoothing::SavitzkyGolay;

const CASES: [[f64; 3]; 5] = [
    [170.0, 190.0, 1080.0],
    [170.0, 190.0, 7200.0],
    [150.0, 210.0, 28_800.0],
    [175.0, 185.0, 51_200.0],
    [1.0, 400.0, 1000.0],
];

#[test]
fn the_response_is_maximally_flat() {
    for [low, high, rate] in CASES {
        let filter = BandPass::try_new(low, high, rate).unwrap();
        assert_eq!(filter.sections().len(), 4);
        let warped = |f: f64| (PI * f / rate).tan();
        for i in 1..200 {
            let f = 0.5 * rate * f64::from(i) / 200.0;
            let prototype =
                (warped(f).powi(2) - warped(low) * warped(high)) / (warped(f) * (warped(high) - warped(low)));
            let expected = 1.0 / (1.0 + prototype.powi(8)).sqrt();
            let found = filter.response(f).norm();
            assert!(
                (found - expected).abs() <= 1e-9 * expected + 1e-14,
                "{low} to {high} at {f}: {found} {expected}"
            );
        }
        for edge in [low, high] {
            assert!((filter.response(edge).norm_sqr() - 0.5).abs() < 1e-9);
        }
        assert!(filter.poles().iter().all(|p| p.norm() < 1.0));
    }
    // A gain of one at any frequency would do too: half the power at the edges, and the poles, tell the order.
    let n = 4.0;
    assert!((NOISE_BANDWIDTH - PI / (2.0 * n) / (PI / (2.0 * n)).sin()).abs() < 1e-15);
}

#[test]
fn run_backward_it_scales_free_decay_by_a_constant() {
    for [low, high, rate] in CASES {
        let filter = BandPass::try_new(low, high, rate).unwrap();
        let centre = (low * high).sqrt();
        let lambda = rustfft::num_complex::Complex64::new(-0.01 * TAU * centre, TAU * centre);
        let decay = |i: usize| (lambda * (i as f64 / rate)).exp();
        let count = (filter.settling_time(1e-15) * rate) as usize + (0.1 * rate) as usize;
        let mut samples: Vec<f64> = (0..count).map(|i| decay(i).re).collect();
        filter.run_backward(&mut samples);
        let gain = filter.backward_gain(lambda);
        for i in 0..(0.1 * rate) as usize {
            let expected = (gain * decay(i)).re;
            assert!((samples[i] - expected).abs() < 1e-9, "{i}: {} {expected}", samples[i]);
        }
    }
    // 1 % damping in a band of 20 Hz at 180 Hz.
    let filter = BandPass::try_new(170.0, 190.0, 7200.0).unwrap();
    let lambda = rustfft::num_complex::Complex64::new(-0.01 * TAU * 180.0, TAU * 180.0);
    assert!((0.6..0.8).contains(&filter.backward_gain(lambda).norm()));
}

#[test]
fn impossible_bands_are_refused() {
    for [low, high, rate] in [
        [0.0, 10.0, 100.0],
        [10.0, 10.0, 100.0],
        [10.0, 41.0, 100.0],
        [f64::NAN, 20.0, 100.0],
        [10.0, f64::NAN, 100.0],
        [10.0, 20.0, 0.0],
        [10.0, 20.0, f64::INFINITY],
    ] {
        let error = BandPass::try_new(low, high, rate).unwrap_err();
        assert!(matches!(error, Error::Setting(_)), "{error}");
    }
}

#[test]
fn smoothing_has_the_published_weights_and_keeps_cubics() {
    // A. Savitzky, M. J. E. Golay, Analytical Chemistry 36 (1964) 1627, Table I.
    for (window, weights, norm) in [
        (5, &[-3.0, 12.0, 17.0, 12.0, -3.0][..], 35.0),
        (7, &[-2.0, 3.0, 6.0, 7.0, 6.0, 3.0, -2.0], 21.0),
        (9, &[-21.0, 14.0, 39.0, 54.0, 59.0, 54.0, 39.0, 14.0, -21.0], 231.0),
    ] {
        let smoother = SavitzkyGolay::try_new(window).unwrap();
        for (i, weight) in weights.iter().enumerate() {
            let mut unit = vec![0.0; window];
            unit[i] = 1.0;
            assert!((smoother.smooth(&unit)[window / 2] - weight / norm).abs() < 1e-14);
        }
    }
    let smoother = SavitzkyGolay::try_new(21).unwrap();
    let cubic = |x: f64| 2.0 - x + 0.3 * x * x - 0.004 * x * x * x;
    let slope = |x: f64| -1.0 + 0.6 * x - 0.012 * x * x;
    let values: Vec<f64> = (0..60).map(|i| cubic(f64::from(i))).collect();
    for (i, (value, rise)) in smoother.smooth(&values).iter().zip(smoother.slope(&values)).enumerate() {
        assert!(
            (value - values[i]).abs() < 1e-9 && (rise - slope(i as f64)).abs() < 1e-9,
            "{i}"
        );
    }
    for window in [0, 3, 20] {
        assert!(matches!(SavitzkyGolay::try_new(window), Err(Error::Setting(_))));
    }
}
