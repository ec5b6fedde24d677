//! Points of a backbone, as both methods take them from a track.

use std::f64::consts::TAU;

use rustfft::num_complex::Complex64;

use crate::smoothing::SavitzkyGolay;
use crate::track::{Track, smooth};

/// One point of a backbone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Time after the first sample (s).
    pub time: f64,
    /// Amplitude (SI unit of its quantity).
    pub amplitude: f64,
    /// Undamped natural frequency (Hz).
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
}

/// Smoothed amplitude (of the signal's quantity), frequency and damping ratio, without an eighth of a window at either end,
/// where the outermost fits follow noise most.
pub(crate) fn moments(track: &Track, smoother: &SavitzkyGolay) -> Vec<Point> {
    let modal = |rate: &Complex64| Complex64::new(-rate.re / rate.norm(), rate.norm() / TAU);
    let modal: Vec<Complex64> = track.rates().iter().map(modal).collect();
    let modal = smooth(&modal, smoother);
    let points = track.inner();
    let states = smooth(&points.states, smoother);
    let all: Vec<_> = points.times.iter().zip(states).zip(modal).collect();
    let margin = smoother.window() / 8;
    let inner = all.get(margin..all.len().saturating_sub(margin)).unwrap_or_default();
    inner
        .iter()
        .map(|((time, state), modal)| Point {
            time: **time,
            amplitude: state.re.exp(),
            frequency_hz: modal.im,
            damping_ratio: modal.re,
        })
        .collect()
}
