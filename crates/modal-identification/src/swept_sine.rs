//! Records of swept-sine tests: force and response over time, as the steps of [`stepped_sine`](crate::stepped_sine) that the sweep passes.
//!
//! Windows of eight periods of the response overlap by half. In each the frequency is the slope of the phase of the response's analytic signal, and both
//! channels are averaged with the conjugate of that motion under a Hann window, which passes neither offsets nor harmonics. How frequency and amplitude change
//! is taken between windows, so that sweeps need not be slow.

use crate::Error;
use crate::fft;
use crate::signal::{Force, Quantity, Signal};
use crate::spectrum::transform;
use crate::stepped_sine::{LEAST_PHASE, Level, Step};
use crate::track::unwrapped;
use rustfft::FftDirection;
use rustfft::num_complex::Complex64;
use std::f64::consts::TAU;
use std::ops::Range;

/// Periods in a window.
const PERIODS: f64 = 8.0;

/// The record is used from the first to the last moment at which the response has this part of its largest amplitude.
const LEAST_RESPONSE: f64 = 0.05;

/// Windows to either side between which changes are taken.
const NEIGHBOURS: usize = 2;

/// Fewest windows of a sweep.
const LEAST_WINDOWS: usize = 8;

/// The path of the frequency over the distance between its ends, above which it went back and forth.
const MOST_PATH: f64 = 2.0;

/// Sample rates of two channels that differ by more are not those of one record (relative).
const SAME_RATE: f64 = 1e-6;

/// What a record tells of its sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Mean rate at which the frequency changes near the resonance (Hz/s); none where the sweep passes none.
    pub rate_hz_per_s: Option<f64>,
    /// Largest part of the response in a window that is not at the frequency of the sweep, by its root mean square (-): harmonics, other modes and noise.
    pub distortion: f64,
}

/// What the middle of a window has.
struct Window {
    /// Time (s).
    time: f64,
    frequency_hz: f64,
    /// Amplitudes with their phases.
    force: Complex64,
    response: Complex64,
    distortion: f64,
}

/// The steps about the resonance, one per window, along a sweep, as a level of this name.
///
/// # Errors
/// [`Error::NoSweep`] where the channels have different rates or lengths, for fewer than eight windows, and where the frequency goes back and forth.
pub fn steps(name: &str, force: &Force, response: &Signal) -> Result<(Level, Sweep), Error> {
    let refused = |what: String| {
        Err(Error::NoSweep {
            at: response.at.clone(),
            what,
        })
    };
    let (rate, count) = (response.sample_rate, response.samples.len());
    if count != force.samples.len() || (force.sample_rate / rate - 1.0).abs() > SAME_RATE {
        let of_force = force.samples.len();
        return refused(format!(
            "it has {count} samples at {rate} Hz, {} has {of_force} at {} Hz",
            force.at, force.sample_rate
        ));
    }
    let windows = windows(&analytic(&force.samples), &analytic(&response.samples), rate);
    if windows.len() < LEAST_WINDOWS {
        return refused(format!(
            "it has {} windows of {PERIODS} periods, at least {LEAST_WINDOWS} are needed",
            windows.len()
        ));
    }
    let passed: Vec<Step> = (0..windows.len())
        .map(|at| step(&windows, at, response.quantity))
        .collect();
    let near = resonance(&passed);
    let (steps, near) = (passed[near.clone()].to_vec(), &windows[near]);
    let path: f64 = near
        .windows(2)
        .map(|pair| (pair[1].frequency_hz - pair[0].frequency_hz).abs())
        .sum();
    let mut rate_hz_per_s = None;
    if let [first, .., last] = near {
        let [from, to] = [first, last].map(|window| window.frequency_hz);
        if path > MOST_PATH * (to - from).abs() {
            return refused(format!(
                "near the resonance its frequency goes from {from:.4} to {to:.4} Hz by a path of {path:.4} Hz"
            ));
        }
        rate_hz_per_s = Some((to - from) / (last.time - first.time));
    }
    let level = Level {
        name: name.to_owned(),
        quantity: response.quantity,
        steps,
    };
    let sweep = Sweep {
        rate_hz_per_s,
        distortion: near.iter().map(|window| window.distortion).fold(0.0, f64::max),
    };
    Ok((level, sweep))
}

/// The steps about that of the largest motion per force which are near the resonance without a gap: where a sweep begins and ends, free motions beat with it.
fn resonance(steps: &[Step]) -> Range<usize> {
    let near: Vec<bool> = steps.iter().map(|step| step.is_near(LEAST_PHASE)).collect();
    let gain = |at: &usize| steps[*at].response / steps[*at].force;
    let Some(peak) = (0..steps.len())
        .filter(|at| near[*at])
        .max_by(|a, b| gain(a).total_cmp(&gain(b)))
    else {
        return 0..0;
    };
    let before = near[..peak].iter().rev().take_while(|near| **near).count();
    let after = near[peak..].iter().take_while(|near| **near).count();
    peak - before..peak + after
}

/// The step of a window.
fn step(windows: &[Window], at: usize, quantity: Quantity) -> Step {
    let here = &windows[at];
    let before = &windows[at.saturating_sub(NEIGHBOURS)];
    let after = &windows[(at + NEIGHBOURS).min(windows.len() - 1)];
    let duration = after.time - before.time;
    let rate = (after.frequency_hz - before.frequency_hz) / duration;
    let growth = (after.response.norm() / before.response.norm()).ln() / duration;
    let derivatives = f64::from(quantity.derivatives());
    let frequency = here.frequency_hz;
    Step {
        frequency_hz: frequency,
        force: here.force.norm(),
        response: here.response.norm(),
        phase_deg: ((here.force / here.response).arg().to_degrees() + 90.0 * derivatives).rem_euclid(360.0),
        // Displacement grows by what its derivatives gain with the frequency less than these.
        drift_hz_per_s: rate + 2.0 * frequency * (growth - derivatives * rate / frequency),
    }
}

/// Windows along the record, without those at its ends, where the transform closes the record to a circle.
fn windows(force: &[Complex64], response: &[Complex64], rate: f64) -> Vec<Window> {
    let largest = response.iter().map(|value| value.norm()).fold(0.0, f64::max);
    let loud = |value: &Complex64| value.norm() >= LEAST_RESPONSE * largest;
    let (Some(first), Some(last)) = (response.iter().position(loud), response.iter().rposition(loud)) else {
        return Vec::new();
    };
    let (force, response) = (&force[first..=last], &response[first..=last]);
    let phases = unwrapped(response);
    let after = |from: usize, periods: f64| {
        let reached = |phase: &f64| *phase >= phases[from] + TAU * periods;
        phases[from..].iter().position(reached).map(|more| from + more)
    };
    let mut found = Vec::new();
    let mut from = 0;
    while let Some(to) = after(from, PERIODS) {
        let part = from..to + 1;
        let mut window = window(&force[part.clone()], &response[part.clone()], &phases[part], rate);
        window.time += from as f64 / rate;
        found.push(window);
        match after(from, 0.5 * PERIODS) {
            Some(next) if next > from => from = next,
            _ => break,
        }
    }
    found.pop();
    found.drain(..1.min(found.len()));
    found
}

/// What a part of the record holds at its middle, weighted by a cosine that is zero at its ends; `time` is from its begin.
fn window(force: &[Complex64], response: &[Complex64], phases: &[f64], rate: f64) -> Window {
    let middle = 0.5 * (phases.len() - 1) as f64;
    let weighted: Vec<(f64, f64)> = (0..phases.len())
        .map(|at| {
            let along = (at as f64 - middle) / middle;
            (0.5 + 0.5 * (0.5 * TAU * along).cos(), along * middle / rate)
        })
        .collect();
    let total: f64 = weighted.iter().map(|(weight, _)| weight).sum();
    let mean = |of: &dyn Fn(usize, f64) -> Complex64| -> Complex64 {
        let terms = weighted.iter().enumerate();
        terms
            .map(|(at, (weight, time))| *weight * of(at, *time))
            .sum::<Complex64>()
            / total
    };
    let phase = mean(&|at, time| Complex64::from(time * phases[at]));
    let slope = phase.re / mean(&|_, time| Complex64::from(time * time)).re;
    let turned = |values: &[Complex64]| mean(&|at, time| values[at] * Complex64::cis(-slope * time));
    let amplitude = turned(response);
    let left = |at: usize, time: f64| (response[at] - amplitude * Complex64::cis(slope * time)).norm_sqr();
    Window {
        time: middle / rate,
        frequency_hz: slope / TAU,
        force: turned(force),
        response: amplitude,
        distortion: mean(&|at, time| Complex64::from(left(at, time))).re.sqrt() / amplitude.norm(),
    }
}

/// The analytic signal, without the mean.
fn analytic(samples: &[f64]) -> Vec<Complex64> {
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    let size = samples.len().next_power_of_two();
    let mut lines = transform(samples.iter().map(|value| value - mean), size);
    lines[0] = Complex64::default();
    for (line, value) in lines.iter_mut().enumerate().skip(1) {
        *value *= if 2 * line < size { 2.0 / size as f64 } else { 0.0 };
    }
    fft::transform(&mut lines, FftDirection::Inverse);
    lines.truncate(samples.len());
    lines
}
