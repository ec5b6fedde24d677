//! Spectra: where the mode is, what else is in its band, and how much noise.

use std::f64::consts::{LN_2, PI};

use rustfft::FftDirection;
use rustfft::num_complex::Complex64;

use crate::fft;
use crate::median::upper_median;
use crate::peaks::peaks;

/// Magnitudes of a one-sided spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Distance between the lines (Hz); the first is at zero.
    pub step: f64,
    /// Magnitudes of the lines (unit of the signal times s).
    pub magnitudes: Vec<f64>,
}

/// A local maximum of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) frequency: f64,
    pub(crate) magnitude: f64,
}

impl Spectrum {
    /// Spectrum of a ring-down that begins with the first sample: weighted with half a Hann window that falls to zero at
    /// the end, padded with zeros to at least twice its length.
    pub fn of_ring_down(samples: &[f64], sample_rate: f64) -> Self {
        let n = samples.len();
        let weight = |i: usize| 0.5 + 0.5 * (PI * i as f64 / n as f64).cos();
        let weighted = samples.iter().enumerate().map(|(i, v)| v * weight(i));
        let size = (2 * n).next_power_of_two();
        let lines = transform(weighted, size);
        Self {
            step: sample_rate / size as f64,
            magnitudes: lines[..=size / 2].iter().map(|v| v.norm() / sample_rate).collect(),
        }
    }

    /// Numbers of the lines between two frequencies.
    fn lines(&self, low: f64, high: f64) -> (usize, usize) {
        let last = self.magnitudes.len() - 1;
        let line = |f: f64| ((f / self.step).max(0.0) as usize).min(last);
        (line(low), line(high))
    }

    /// Local maxima between two frequencies, with magnitudes times `weight`.
    pub(crate) fn maxima(&self, low: f64, high: f64, weight: impl Fn(f64) -> f64) -> Vec<Line> {
        let (from, to) = self.lines(low, high);
        let weighted: Vec<f64> = (from..=to)
            .map(|i| self.magnitudes[i] * weight(i as f64 * self.step))
            .collect();
        let lines = peaks(&weighted).into_iter().map(|peak| Line {
            frequency: (from as f64 + peak.position) * self.step,
            magnitude: peak.value,
        });
        lines.collect()
    }

    /// Smallest magnitude times `weight` between two frequencies.
    pub(crate) fn valley(&self, a: f64, b: f64, weight: impl Fn(f64) -> f64) -> f64 {
        let (from, to) = self.lines(a.min(b), a.max(b));
        let weighted = (from..=to).map(|i| self.magnitudes[i] * weight(i as f64 * self.step));
        weighted.fold(f64::INFINITY, f64::min)
    }
}

/// The largest of some lines.
pub(crate) fn largest(lines: &[Line]) -> Option<Line> {
    lines.iter().copied().max_by(|a, b| a.magnitude.total_cmp(&b.magnitude))
}

/// The discrete Fourier transform of real numbers, padded with zeros to a `size` that is a power of two.
pub(crate) fn transform(values: impl Iterator<Item = f64>, size: usize) -> Vec<Complex64> {
    let mut lines: Vec<Complex64> = values.map(Complex64::from).collect();
    lines.resize(size, Complex64::default());
    fft::transform(&mut lines, FftDirection::Forward);
    lines
}

/// Variance per Hz of the noise beside a band, in samples from the tail of a record: the median of the periodogram (under a
/// Hann window) between one and four bandwidths on either side, so that modes there do not count.
pub(crate) fn noise_density(tail: &[f64], sample_rate: f64, centre: f64, bandwidth: f64) -> f64 {
    let n = tail.len();
    let weight = |i: usize| 0.5 - 0.5 * (2.0 * PI * (i as f64 + 0.5) / n as f64).cos();
    let power: f64 = (0..n).map(|i| weight(i).powi(2)).sum();
    let size = n.next_power_of_two();
    let step = sample_rate / size as f64;
    let lines = transform(tail.iter().enumerate().map(|(i, v)| v * weight(i)), size);
    let beside = |i: &usize| {
        let distance = (*i as f64 * step - centre).abs() / bandwidth;
        (1.0..=4.0).contains(&distance)
    };
    let mut densities: Vec<f64> = (1..size / 2)
        .filter(beside)
        .map(|i| 2.0 * lines[i].norm_sqr() / (power * sample_rate))
        .collect();
    if densities.is_empty() {
        return 0.0;
    }
    // The median of an exponential distribution is ln 2 of its mean.
    upper_median(&mut densities) / LN_2
}
