//! The band-pass filter: Butterworth of fourth order by its low-pass prototype (eight poles), as second-order sections
//! designed from poles and zeros, run on the time-reversed signal only.
//!
//! Run forward, the filter would smear the hit over the first tenths of a second of the ring-down; run both ways, it
//! would do so as well and falsify the damping. Run backward it answers at time `t` to what comes after `t` alone, so
//! that a decaying oscillation `exp(lambda t)` passes with the constant factor `F(lambda)`, its transfer function at
//! `z = exp(-lambda dt)`, from the first moment on.

use std::f64::consts::{PI, TAU};

use rustfft::num_complex::Complex64;

use crate::Error;
use crate::error::Setting;

/// Order of the low-pass prototype.
pub const ORDER: usize = 4;

/// Noise bandwidth over the width between the half-power points: `(pi/2n)/sin(pi/2n)`.
pub const NOISE_BANDWIDTH: f64 = 1.026_172_152_977_031;

/// Band edges beyond this fraction of the sample rate are refused.
pub const HIGHEST_EDGE: f64 = 0.4;

/// Bands narrower than this fraction of the sample rate are refused: rounding would put poles on the unit circle.
const NARROWEST_BAND: f64 = 1e-9;

/// `gain (1 - w^2)/(1 + a1 w + a2 w^2)` with `w = 1/z`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Factor of the numerator.
    pub gain: f64,
    /// Coefficients of the denominator.
    pub a: [f64; 2],
}

/// A Butterworth band-pass filter.
#[derive(Clone, Debug, PartialEq)]
pub struct BandPass {
    sections: [Section; ORDER],
    poles: [Complex64; ORDER],
    low: f64,
    high: f64,
    sample_rate: f64,
}

/// What a filter does to a slowly changing oscillation, about `exp(lambda t)`: the logarithm of its transfer function
/// and the first three derivatives with respect to `lambda` (1, s, s^2, s^3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Transfer {
    pub(crate) logarithm: Complex64,
    pub(crate) delay: Complex64,
    pub(crate) dispersion: Complex64,
    pub(crate) skew: Complex64,
}

impl BandPass {
    /// The filter with half-power points `low` and `high` (Hz) for samples at `sample_rate` (Hz).
    ///
    /// # Errors
    /// [`Error::Setting`] unless `0 < low < high <= 0.4 sample_rate`, and for bands narrower than 1e-9 of the sample rate.
    pub fn try_new(low: f64, high: f64, sample_rate: f64) -> Result<Self, Error> {
        let refuse = |name, value, allowed: String| {
            Err(Error::Setting(Setting {
                name,
                value,
                unit: "Hz",
                allowed,
            }))
        };
        if !(sample_rate > 0.0 && sample_rate.is_finite()) {
            return refuse("sample rate", sample_rate, "positive".into());
        }
        if !(low > 0.0) {
            return refuse("lower band edge", low, "positive: make the bandwidth smaller".into());
        }
        if !(high > low && high <= HIGHEST_EDGE * sample_rate) {
            let most = HIGHEST_EDGE * sample_rate;
            return refuse("upper band edge", high, format!("above {low} and at most {most}"));
        }
        let narrowest = NARROWEST_BAND * sample_rate;
        if !(high - low >= narrowest) {
            return refuse("bandwidth", high - low, format!("at least {narrowest:e}"));
        }
        // The bilinear transformation moves frequencies; the edges are moved the other way first.
        let warped = |f: f64| 2.0 * sample_rate * (PI * f / sample_rate).tan();
        let (from, to) = (warped(low), warped(high));
        let (width, centre_squared) = (to - from, from * to);
        let centre = Complex64::cis(-2.0 * (centre_squared.sqrt() / (2.0 * sample_rate)).atan());
        let mut poles = [Complex64::default(); ORDER];
        for k in 0..ORDER / 2 {
            let prototype = Complex64::cis(PI * (0.5 + (2 * k + 1) as f64 / (2 * ORDER) as f64));
            let half = prototype * (width / 2.0);
            let root = (half * half - centre_squared).sqrt();
            // Of each conjugate pair, one.
            for (slot, s) in [half + root, half - root].into_iter().enumerate() {
                let s = s / (2.0 * sample_rate);
                poles[2 * k + slot] = (1.0 + s) / (1.0 - s);
            }
        }
        let sections = poles.map(|pole| {
            let a = [-2.0 * pole.re, pole.norm_sqr()];
            let section = Section { gain: 1.0, a };
            let gain = 1.0 / section.response(centre).norm();
            Section { gain, a }
        });
        Ok(Self {
            sections,
            poles,
            low,
            high,
            sample_rate,
        })
    }

    /// The sections.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// One pole (in `z`) of each section; its conjugate is the other.
    pub fn poles(&self) -> &[Complex64] {
        &self.poles
    }

    /// Half-power points (Hz).
    pub fn edges(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// Transfer function at `frequency` (Hz), of the filter run forward.
    pub fn response(&self, frequency: f64) -> Complex64 {
        let w = Complex64::cis(-TAU * frequency / self.sample_rate);
        self.sections.iter().map(|s| s.response(w)).product()
    }

    /// The factor by which `exp(lambda t)` passes the filter run backward (`lambda` in 1/s).
    pub fn backward_gain(&self, lambda: Complex64) -> Complex64 {
        let w = (lambda / self.sample_rate).exp();
        self.sections.iter().map(|s| s.response(w)).product()
    }

    /// Time (s) after which the slowest natural oscillation of the filter has decayed by the factor `fraction`.
    pub fn settling_time(&self, fraction: f64) -> f64 {
        let slowest = self.poles.iter().fold(0.0, |most: f64, pole| most.max(pole.norm()));
        fraction.ln() / slowest.ln() / self.sample_rate
    }

    /// Runs the filter over `samples` from the last to the first, starting from rest, in place.
    pub fn run_backward(&self, samples: &mut [f64]) {
        for Section { gain, a: [a1, a2] } in self.sections {
            // Transposed direct form.
            let (mut s1, mut s2) = (0.0, 0.0);
            for sample in samples.iter_mut().rev() {
                let x = gain * *sample;
                let y = x + s1;
                s1 = s2 - a1 * y;
                s2 = -x - a2 * y;
                *sample = y;
            }
        }
    }

    /// About `exp(lambda t)`, run backward.
    pub(crate) fn transfer(&self, lambda: Complex64) -> Transfer {
        let w = (lambda / self.sample_rate).exp();
        let w2 = w * w;
        let mut sum = Transfer {
            logarithm: self.backward_gain(lambda).ln(),
            delay: Complex64::default(),
            dispersion: Complex64::default(),
            skew: Complex64::default(),
        };
        let numerator = 1.0 - w2;
        for Section { a: [a1, a2], .. } in self.sections {
            // Logarithmic derivatives with respect to ln w.
            let denominator = 1.0 + a1 * w + a2 * w2;
            let [first, second, third] = [2.0, 4.0, 8.0].map(|power| (a1 * w + power * a2 * w2) / denominator);
            sum.delay += -2.0 * w2 / numerator - first;
            sum.dispersion += -4.0 * w2 / numerator.powi(2) - second + first * first;
            sum.skew +=
                -8.0 * w2 * (1.0 + w2) / numerator.powi(3) - third + first * (3.0 * second - 2.0 * first * first);
        }
        sum.delay /= self.sample_rate;
        sum.dispersion /= self.sample_rate.powi(2);
        sum.skew /= self.sample_rate.powi(3);
        sum
    }
}

impl Section {
    fn response(&self, w: Complex64) -> Complex64 {
        self.gain * (1.0 - w * w) / (1.0 + self.a[0] * w + self.a[1] * w * w)
    }
}
