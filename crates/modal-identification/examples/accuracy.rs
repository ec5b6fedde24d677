//! The table of errors against bandwidth, noise, neighbouring mode and sample rate: a mode whose frequency falls from
//! 180 Hz by 2 Hz and whose damping ratio rises from 0.1 % to 1 %, both with the amplitude.

use std::error::Error;

use modal_identification::backbone::{Identification, Settings, identify};
use modal_identification::signal::{Channel, Signal, Stated, Timing};
use modal_identification::synthetic::{RingDown, add_noise};

const AMPLITUDE: f64 = 100.0;

fn frequency(a: f64) -> f64 {
    180.0 - 2.0 * a / AMPLITUDE
}

fn damping_ratio(a: f64) -> f64 {
    0.001 + 0.009 * a / AMPLITUDE
}

fn case(per_cycle: f64, noise: f64, neighbour: f64, bandwidth: f64) -> Result<Identification, Box<dyn Error>> {
    let rate = 180.0 * per_cycle;
    let count = (4.0 * rate) as usize;
    let mode = RingDown {
        amplitude: AMPLITUDE,
        phase: -1.2,
        frequency,
        damping_ratio,
    };
    let mut samples = mode.samples(rate, count);
    if neighbour > 0.0 {
        let other = RingDown {
            amplitude: neighbour * AMPLITUDE,
            phase: 0.4,
            frequency: |_| 230.0,
            damping_ratio: |_| 0.002,
        };
        for (sum, v) in samples.iter_mut().zip(other.samples(rate, count)) {
            *sum += v;
        }
    }
    add_noise(&mut samples, noise * AMPLITUDE, 7);
    let channel = Channel {
        name: "synthetic".into(),
        unit: Some("m/s^2".into()),
        timing: Timing::Rate(rate),
        samples,
    };
    let (signal, _) = Signal::try_new("accuracy", &channel, &Stated::default())?;
    Ok(identify(
        &signal,
        &Settings {
            frequency: Some(180.0),
            bandwidth: Some(bandwidth),
            smoothing: std::env::var("W").map_or(41, |w| w.parse().unwrap()),
            noise_margin: std::env::var("M").map_or(50.0, |w| w.parse().unwrap()),
            ..Settings::default()
        },
    )?)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "| samples per cycle | noise % | 230 Hz % | bandwidth Hz | f: median, largest error (Hz) | zeta: median, largest error % | amplitudes | filter gain | second method: f (Hz), zeta % |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut rows = Vec::new();
    for bandwidth in [10.0, 20.0, 40.0, 60.0] {
        rows.push((80.0, 0.0, 0.0, bandwidth));
    }
    for per_cycle in [6.0, 10.0, 20.0, 39.0, 40.0, 80.0, 160.0] {
        rows.push((per_cycle, 0.0, 0.0, 40.0));
    }
    for noise in [0.001, 0.003, 0.01] {
        for bandwidth in [20.0, 40.0, 60.0] {
            rows.push((80.0, noise, 0.0, bandwidth));
        }
    }
    for neighbour in [0.1, 0.25, 0.5] {
        for bandwidth in [20.0, 40.0, 60.0] {
            rows.push((80.0, 0.0, neighbour, bandwidth));
        }
    }
    for per_cycle in [6.0, 160.0] {
        rows.push((per_cycle, 0.01, 0.5, 20.0));
    }
    for (per_cycle, noise, neighbour, bandwidth) in rows {
        let found = match case(per_cycle, noise, neighbour, bandwidth) {
            Ok(found) => found,
            Err(error) => {
                println!("| {per_cycle} | {noise} | {neighbour} | {bandwidth} | {error}");
                continue;
            }
        };
        let errors = |error: &dyn Fn(&modal_identification::backbone::Point) -> f64| {
            let mut errors: Vec<f64> = found.backbone.iter().map(|p| error(p).abs()).collect();
            errors.sort_by(f64::total_cmp);
            [errors[errors.len() / 2], errors[errors.len() - 1]]
        };
        let f = errors(&|p| p.frequency_hz - frequency(p.amplitude));
        let zeta = errors(&|p| 100.0 * (p.damping_ratio / damping_ratio(p.amplitude) - 1.0));
        let ends = [found.backbone[0], found.backbone[found.backbone.len() - 1]].map(|p| p.amplitude);
        let check = found.cross_check.map_or("none".into(), |c| {
            format!("{:.1e}, {:.2}", c.frequency_median, 100.0 * c.damping_median)
        });
        println!(
            "| {per_cycle} | {} | {} | {bandwidth} | {:.1e}, {:.1e} | {:.2e}, {:.2e} | {:.1} to {:.2e} | {:.2} to {:.2} | {check} |{:?}{}",
            100.0 * noise,
            100.0 * neighbour,
            f[0],
            f[1],
            zeta[0],
            zeta[1],
            ends[0],
            ends[1],
            found.filter_gain[0],
            found.filter_gain[1],
            found.trims.reason,
            found
                .warnings
                .iter()
                .map(|w| w.to_string())
                .collect::<Vec<_>>()
                .join("; ")
        );
    }
    Ok(())
}
