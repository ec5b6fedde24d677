//! Signals that are made: ring-downs whose frequency and damping are known at every amplitude, to test identification with, and stationary noise.

use std::f64::consts::TAU;

use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rustfft::FftDirection;
use rustfft::num_complex::Complex64;

use crate::fft::transform;

/// A mode that rings down: `x = A cos(phi)` with `A' = -zeta omega A` and `phi' = omega sqrt(1 - zeta^2)`,
/// `omega = 2 pi f(A)`, `zeta = zeta(A)`.
pub struct RingDown<F, Z> {
    /// Amplitude at the start, in any unit.
    pub amplitude: f64,
    /// Phase at the start (rad).
    pub phase: f64,
    /// Undamped natural frequency (Hz) against amplitude.
    pub frequency: F,
    /// Damping ratio against amplitude.
    pub damping_ratio: Z,
}

impl<F: Fn(f64) -> f64, Z: Fn(f64) -> f64> RingDown<F, Z> {
    /// Samples at `sample_rate` (Hz), the first at the start. Amplitude and phase are integrated by the classical
    /// Runge-Kutta method in at least 32 steps per cycle, which leaves an error of about 1e-11 of the amplitude.
    pub fn samples(&self, sample_rate: f64, count: usize) -> Vec<f64> {
        let rates = |log: f64| {
            let amplitude = log.exp();
            let (omega, zeta) = (TAU * (self.frequency)(amplitude), (self.damping_ratio)(amplitude));
            [-zeta * omega, omega * (1.0 - zeta * zeta).sqrt()]
        };
        let (mut log, mut phase) = (self.amplitude.ln(), self.phase);
        let per_sample = (32.0 * rates(log)[1] / TAU / sample_rate).ceil().max(1.0);
        let step = 1.0 / (sample_rate * per_sample);
        let mut out = Vec::with_capacity(count);
        for _ in 0..count {
            out.push(log.exp() * phase.cos());
            for _ in 0..per_sample as usize {
                let k1 = rates(log);
                let k2 = rates(log + 0.5 * step * k1[0]);
                let k3 = rates(log + 0.5 * step * k2[0]);
                let k4 = rates(log + step * k3[0]);
                let mean = |i: usize| (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0;
                log += step * mean(0);
                phase += step * mean(1);
            }
        }
        out
    }
}

/// Adds white Gaussian noise of the standard deviation `rms`; the same seed gives the same noise.
pub fn add_noise(samples: &mut [f64], rms: f64, seed: u64) {
    let mut random = Pcg64::seed_from_u64(seed);
    for sample in samples {
        *sample += rms * normal(&mut random);
    }
}

/// Stationary Gaussian noise of a one-sided power spectral density (per Hz), `step` (s) apart: a sum of harmonics of a period that is no shorter than the
/// record, with normally distributed amplitudes. What the density has above half the rate of samples is left out. The same seed gives the same noise.
pub fn stationary(density: impl Fn(f64) -> f64, step: f64, count: usize, seed: u64) -> Vec<f64> {
    let size = count.next_power_of_two().max(2);
    let spacing = 1.0 / (size as f64 * step);
    let mut random = Pcg64::seed_from_u64(seed);
    let mut values = vec![Complex64::default(); size];
    for (k, value) in values.iter_mut().enumerate().take(size / 2).skip(1) {
        let amplitude = (density(k as f64 * spacing) * spacing).sqrt();
        *value = Complex64::new(amplitude * normal(&mut random), -amplitude * normal(&mut random));
    }
    transform(&mut values, FftDirection::Inverse);
    values.into_iter().take(count).map(|value| value.re).collect()
}

/// A standard normal number (Box and Muller).
fn normal(random: &mut impl Rng) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (TAU * random.random::<f64>()).cos()
}
