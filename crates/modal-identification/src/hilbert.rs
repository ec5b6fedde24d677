//! The second method: the analytic signal (Hilbert) under a Gaussian band, independent of the recursive filter and of
//! extrema. Its band has no delay, but smears the hit: the first and last stretches are not compared.

use std::f64::consts::{LN_2, PI, TAU};

use rustfft::FftDirection;
use rustfft::num_complex::Complex64;

use crate::fft;
use crate::filter::Transfer;
use crate::median::upper_median;
use crate::point::{Point, moments};
use crate::smoothing::SavitzkyGolay;
use crate::spectrum::transform;
use crate::track::{Track, unwrapped};

/// Standard deviations of the Gaussian that are kept in frequency, and left out at the ends in time.
const REACH: f64 = 6.0;

/// How the second method differs from the first, over the points compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossCheck {
    /// Number of points compared.
    pub points: usize,
    /// Median of the magnitude of the difference of frequency (Hz).
    pub frequency_median: f64,
    /// Largest difference of frequency (Hz).
    pub frequency_largest: f64,
    /// Median of the magnitude of the difference of the damping ratio over the ratio of the first method.
    pub damping_median: f64,
    /// Largest such difference.
    pub damping_largest: f64,
    /// Median of the magnitude of the difference of amplitude over the amplitude.
    pub amplitude_median: f64,
}

/// Compares the points of the first method with those of the second, in `samples` without their mean from `start` to `end`
/// (s); `None` where the record leaves nothing to compare.
pub(crate) fn cross_check(
    samples: &[f64],
    rate: f64,
    [start, end]: [f64; 2],
    [centre, bandwidth]: [f64; 2],
    points: &[Point],
    smoother: &SavitzkyGolay,
) -> Option<CrossCheck> {
    // Half-power points at the same distance as those of the filter; `tau` is the duration of the Gaussian.
    let tau = LN_2.sqrt() / (PI * bandwidth);
    let first = (start * rate) as usize;
    let last = samples.len().min((end * rate) as usize);
    let duration = last.checked_sub(first)? as f64 / rate;
    let margin = REACH * tau;
    let track = track(&samples[first..last], rate, first as f64 / rate, centre, tau);
    let kept = track.times.iter().zip(&track.states);
    let kept = kept.filter(|(t, _)| (start + margin..start + duration - margin).contains(*t));
    let (times, states) = kept.map(|(t, s)| (*t, *s)).unzip();
    let track = Track { times, states };
    if track.times.len() < smoother.window() + 8 {
        return None;
    }
    let gaussian = |lambda: Complex64| {
        let distance = lambda - Complex64::new(0.0, TAU * centre);
        Transfer {
            logarithm: 0.5 * distance * distance * tau * tau,
            delay: distance * tau * tau,
            dispersion: Complex64::from(tau * tau),
            skew: Complex64::default(),
        }
    };
    let (track, _) = track.before_filter(gaussian, smoother);
    differences(points, &moments(&track, smoother))
}

/// Amplitude and phase of the analytic signal under the Gaussian, twice per cycle.
fn track(samples: &[f64], rate: f64, start: f64, centre: f64, tau: f64) -> Track {
    // Zeros behind the end take what the Gaussian smears around the circle.
    let padded = samples.len() + (2.0 * REACH * tau * rate) as usize + 1;
    let size = padded.next_power_of_two();
    let lines = transform(samples.iter().copied(), size);
    let step = rate / size as f64;
    let middle = (centre / step).round() as usize;
    // Shifted to zero, the band needs only as many lines as there are half cycles.
    let count = ((2.0 * centre / step).ceil() as usize).next_power_of_two().min(size);
    let mut band = vec![Complex64::default(); count];
    for offset in -(count as i64 / 2)..count as i64 / 2 {
        let line = middle as i64 + offset;
        if line > 0 && line < size as i64 / 2 {
            let distance = TAU * (line as f64 * step - centre) * tau;
            let weight = 2.0 / size as f64 * (-0.5 * distance * distance).exp();
            band[offset.rem_euclid(count as i64) as usize] = weight * lines[line as usize];
        }
    }
    fft::transform(&mut band, FftDirection::Inverse);
    let carrier = TAU * middle as f64 * step;
    let spacing = size as f64 / rate / count as f64;
    let within = ((samples.len() as f64 / rate) / spacing) as usize;
    band.truncate(within);
    let mut out = Track::default();
    for (i, (value, phase)) in band.iter().zip(unwrapped(&band)).enumerate() {
        let time = i as f64 * spacing;
        out.times.push(start + time);
        out.states
            .push(Complex64::new(value.norm().ln(), phase + carrier * time));
    }
    out
}

/// Differences at the times of the first points, between which the second are interpolated.
fn differences(first: &[Point], second: &[Point]) -> Option<CrossCheck> {
    let [mut frequency, mut damping, mut amplitude] = [const { Vec::new() }; 3];
    for point in first {
        let after = second.partition_point(|p| p.time < point.time);
        let (Some(a), Some(b)) = (after.checked_sub(1).map(|i| second[i]), second.get(after)) else {
            continue;
        };
        let part = (point.time - a.time) / (b.time - a.time);
        let between = |value: fn(&Point) -> f64| value(&a) + part * (value(b) - value(&a));
        frequency.push((between(|p| p.frequency_hz) - point.frequency_hz).abs());
        damping.push((between(|p| p.damping_ratio) / point.damping_ratio - 1.0).abs());
        amplitude.push((between(|p| p.amplitude.ln()) - point.amplitude.ln()).exp_m1().abs());
    }
    let points = frequency.len();
    let largest = |values: &[f64]| values.iter().copied().max_by(f64::total_cmp);
    Some(CrossCheck {
        points,
        frequency_largest: largest(&frequency)?,
        frequency_median: upper_median(&mut frequency),
        damping_largest: largest(&damping)?,
        damping_median: upper_median(&mut damping),
        amplitude_median: upper_median(&mut amplitude),
    })
}
