//! The table of errors against bandwidth, noise, neighbouring mode and sample rate in docs/validation.md.
#![expect(clippy::print_stdout, reason = "the table goes there")]

use std::error::Error;

use modal_identification::backbone::{Identification, Point, Settings, identify};
use modal_identification::signal::{Channel, Signal, Stated, Timing};
use modal_identification::synthetic::{RingDown, add_noise};

const AMPLITUDE: f64 = 100.0;
const SECONDS: f64 = 4.0;

fn frequency(a: f64) -> f64 {
    180.0 - 2.0 * a / AMPLITUDE
}

fn damping_ratio(a: f64) -> f64 {
    0.001 + 0.009 * a / AMPLITUDE
}

/// A case: samples per cycle, noise and second mode in per cent of the first amplitude, bandwidth (Hz).
fn identified([per_cycle, noise, neighbour, bandwidth]: [f64; 4]) -> Result<Identification, Box<dyn Error>> {
    let sample_rate = 180.0 * per_cycle;
    let count = (SECONDS * sample_rate) as usize;
    let mode = RingDown {
        amplitude: AMPLITUDE,
        phase: 0.3,
        frequency,
        damping_ratio,
    };
    let other = RingDown {
        amplitude: 0.01 * neighbour.max(1e-300) * AMPLITUDE,
        phase: -0.7,
        frequency: |_| 230.0,
        damping_ratio: |_| 0.002,
    };
    let both = mode
        .samples(sample_rate, count)
        .into_iter()
        .zip(other.samples(sample_rate, count));
    let mut samples: Vec<f64> = both.map(|(a, b)| a + b).collect();
    add_noise(&mut samples, 0.01 * noise * AMPLITUDE, 7);
    let channel = Channel {
        name: "synthetic".into(),
        unit: Some("m/s^2".into()),
        timing: Timing::Rate(sample_rate),
        samples,
    };
    let (signal, _) = Signal::try_new("table", &channel, &Stated::default())?;
    let settings = Settings {
        frequency: Some(180.0),
        bandwidth: Some(bandwidth),
        ..Settings::default()
    };
    Ok(identify(&signal, &settings)?)
}

/// Median and largest.
fn of_errors(points: &[Point], error: impl Fn(&Point) -> f64) -> [f64; 2] {
    let mut errors: Vec<f64> = points.iter().map(|p| error(p).abs()).collect();
    errors.sort_by(f64::total_cmp);
    [errors[errors.len() / 2], errors[errors.len() - 1]]
}

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "| per cycle | noise % | 230 Hz % | band (Hz) | f (Hz) | zeta (%) | amplitudes (%) | gain | second: f (Hz), zeta (%) |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let clean = [10.0, 20.0, 40.0, 60.0].map(|b| [80.0, 0.0, 0.0, b]);
    let rates = [6.0, 10.0, 20.0, 39.0, 40.0, 160.0].map(|n| [n, 0.0, 0.0, 20.0]);
    let bands = [10.0, 20.0, 40.0, 60.0];
    let noisy = [0.1, 0.3, 1.0]
        .into_iter()
        .flat_map(|n| bands.map(|b| [80.0, n, 0.0, b]));
    let beside = [5.0, 10.0, 25.0, 50.0]
        .into_iter()
        .flat_map(|n| bands.map(|b| [80.0, 0.0, n, b]));
    let worst = [
        [6.0, 1.0, 50.0, 20.0],
        [40.0, 1.0, 50.0, 20.0],
        [160.0, 1.0, 50.0, 20.0],
    ];
    for case in clean.into_iter().chain(rates).chain(noisy).chain(beside).chain(worst) {
        let found = identified(case)?;
        let points = &found.backbone;
        let f = of_errors(points, |p| p.frequency_hz - frequency(p.amplitude));
        let zeta = of_errors(points, |p| 100.0 * (p.damping_ratio / damping_ratio(p.amplitude) - 1.0));
        let [first, last] = [points[0], points[points.len() - 1]].map(|p| 100.0 * p.amplitude / AMPLITUDE);
        let second = found.cross_check.map_or("none".into(), |c| {
            format!("{:.0e}, {:.2}", c.frequency_median, 100.0 * c.damping_median)
        });
        let [per_cycle, noise, neighbour, bandwidth] = case;
        println!(
            "| {per_cycle} | {noise} | {neighbour} | {bandwidth} | {:.0e}, {:.0e} | {:.2}, {:.2} | {first:.0} to {last:.1} | {:.2} | {second} |",
            f[0], f[1], zeta[0], zeta[1], found.filter_gain[0]
        );
    }
    Ok(())
}
