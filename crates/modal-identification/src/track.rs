//! Amplitude and phase of an oscillation at successive times, what a filter did to them, and the rates at which they change.

use std::f64::consts::{PI, TAU};

use rustfft::num_complex::Complex64;

use crate::filter::Transfer;
use crate::smoothing::SavitzkyGolay;

/// Points on either side of a point over which rates are taken: four half cycles, two periods in all.
const SIDE: usize = 2;

/// An oscillation `exp(log_amplitude) cos(phase)` twice per cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Track {
    /// Times (s).
    pub(crate) times: Vec<f64>,
    /// Logarithm of the amplitude over the unit of the signal, and phase (rad) as imaginary part.
    pub(crate) states: Vec<Complex64>,
}

impl Track {
    /// Rates of change (1/s), each over two periods: minus the decay rate and, as imaginary part, the angular frequency.
    /// Two points at either end have none.
    pub(crate) fn rates(&self) -> Vec<Complex64> {
        let pairs = self.times.windows(2 * SIDE + 1).zip(self.states.windows(2 * SIDE + 1));
        pairs
            .map(|(t, s)| (s[2 * SIDE] - s[0]) / (t[2 * SIDE] - t[0]))
            .collect()
    }

    /// The points that [`rates`](Self::rates) belong to.
    pub(crate) fn inner(&self) -> Self {
        let inner = SIDE..self.times.len().saturating_sub(SIDE).max(SIDE).min(self.times.len());
        match self.times.get(inner.clone()) {
            Some(times) => Self {
                times: times.to_vec(),
                states: self.states[inner].to_vec(),
            },
            None => Self::default(),
        }
    }

    /// From the extrema of an oscillation: maxima and minima in turn.
    pub(crate) fn from_extrema(extrema: &[(f64, f64)], smoother: &SavitzkyGolay) -> Self {
        let mut track = Self {
            times: extrema.iter().map(|e| e.0).collect(),
            states: Vec::new(),
        };
        let states = extrema.iter().enumerate();
        track.states = states
            .map(|(k, (_, value))| Complex64::new(value.abs().ln(), PI * k as f64))
            .collect();
        // A decaying oscillation is largest shortly before its phase passes a multiple of pi.
        let rates = smooth(&track.rates(), smoother);
        let mut track = track.inner();
        for (state, rate) in track.states.iter_mut().zip(&rates) {
            let ratio = rate.re / rate.im;
            *state += Complex64::new(0.5 * (ratio * ratio).ln_1p(), ratio.atan());
        }
        track
    }

    /// What went into a filter, from what came out. About the rate `lambda` of each point the filter is a factor, a delay
    /// and a dispersion, `ln y(t) = ln x(t + g) + ln F - g lambda + (c - Im(g)^2) lambda'/2 + d lambda''/6`, with `g`, `c`, `d`
    /// the first three derivatives of `ln F` with respect to `lambda`. Returns the track with smoothed logarithms of the factors.
    pub(crate) fn before_filter(
        &self,
        transfer: impl Fn(Complex64) -> Transfer,
        smoother: &SavitzkyGolay,
    ) -> (Self, Vec<Transfer>) {
        let rates = self.rates();
        let slopes = both(&rates, |v| smoother.slope(v));
        let bends = both(&slopes, |v| smoother.slope(v));
        let rates = smooth(&rates, smoother);
        let mut track = self.inner();
        let transfers: Vec<Transfer> = rates.iter().map(|rate| transfer(*rate)).collect();
        let times = &self.times;
        let spacing = |i: usize| (times[i + 2 * SIDE] - times[i]) / (2 * SIDE) as f64;
        let mut turn = 0.0;
        for (i, transfer) in transfers.iter().enumerate() {
            // Phases of the factor are known to a whole turn.
            if i > 0 {
                let jump = transfer.logarithm.im - transfers[i - 1].logarithm.im;
                turn -= TAU * (jump / TAU).round();
            }
            let delay = transfer.delay.re;
            let (slope, bend) = (slopes[i] / spacing(i), bends[i] / spacing(i).powi(2));
            let spread = transfer.dispersion - transfer.delay.im.powi(2);
            track.times[i] += delay;
            track.states[i] += rates[i] * delay
                - transfer.logarithm
                - Complex64::new(0.0, turn)
                - 0.5 * spread * slope
                - transfer.skew * bend / 6.0;
        }
        (track, transfers)
    }
}

/// Real and imaginary parts smoothed.
pub(crate) fn smooth(values: &[Complex64], smoother: &SavitzkyGolay) -> Vec<Complex64> {
    both(values, |v| smoother.smooth(v))
}

fn both(values: &[Complex64], apply: impl Fn(&[f64]) -> Vec<f64>) -> Vec<Complex64> {
    let re: Vec<f64> = values.iter().map(|v| v.re).collect();
    let im: Vec<f64> = values.iter().map(|v| v.im).collect();
    apply(&re)
        .into_iter()
        .zip(apply(&im))
        .map(|(re, im)| Complex64::new(re, im))
        .collect()
}

/// Phases of numbers, continued over whole turns.
pub(crate) fn unwrapped(values: &[Complex64]) -> Vec<f64> {
    let (mut turns, mut before) = (0.0, None);
    let continued = values.iter().map(|value| {
        let phase = value.arg();
        turns -= TAU * before.map_or(0.0, |before: f64| ((phase - before) / TAU).round());
        before = Some(phase);
        phase + turns
    });
    continued.collect()
}
