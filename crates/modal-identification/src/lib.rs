//! From measured ring-downs to natural frequency and damping ratio against amplitude.
//!
//! | module | does |
//! |---|---|
//! | [`readers`] | universal files 58 and 58b, `.mat`, `.npz`, CSV, WAV: channels with unit and timing as the file states them |
//! | [`signal`] | one channel in SI units, checked: gaps, clipping, times, what is constant or not finite |
//! | [`filter`] | Butterworth band-pass of fourth order, run backward in time; what it does to a decaying oscillation |
//! | [`peaks`] | extrema by parabolas, interpolation where samples are few |
//! | [`smoothing`] | Savitzky-Golay |
//! | [`backbone`] | the identification of one hit, with the rules for its ends |
//! | [`hilbert`] | a second method on the same signal, for the difference |
//! | [`stepped_sine`] | tests at controlled response and at phase resonance: a mode for each level |
//! | [`swept_sine`] | records of sweeps at controlled response: the steps that they pass |
//! | [`average`] | several hits: mean and spread |
//! | [`spectrum`] | where the mode is |
//! | [`synthetic`] | ring-downs of known frequency and damping, for tests |
//!
//! The method is peak finding and fitting (M. Jin, M. R. W. Brake, H. Song, *Comparison of nonlinear system identification
//! methods for free decay measurements with application to jointed structures*, Journal of Sound and Vibration), as the
//! method paper uses it (sections 3.4 and 4.1,
//! [DOI 10.1016/j.ymssp.2020.106615](https://doi.org/10.1016/j.ymssp.2020.106615)), with the filter's effect undone. Frequencies
//! are undamped natural ones, amplitudes those of the mode alone.

pub mod average;
pub mod backbone;
mod error;
mod fft;
pub mod filter;
pub mod hilbert;
mod median;
pub mod peaks;
mod point;
pub mod readers;
pub mod shock_spectrum;
pub mod signal;
pub mod smoothing;
pub mod spectrum;
pub mod stepped_sine;
pub mod swept_sine;
pub mod synthetic;
mod track;

pub use error::{Error, Setting, Warning};
