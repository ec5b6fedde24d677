//! What the instrument resolves, beside what was found with it.

use crate::peaks::LinePeak;
use crate::topography::HeightMap;

/// Limits that the instrument's steps put on the estimates of one element of one face.
///
/// Heights, R_t and gaps are known to about one height step. A three-point kernel sees curvatures in multiples of
/// `least_curvature`, and every curvature carries the rounding of its three heights, `least_curvature / sqrt(2)` rms
/// per peak. The lateral step is fine enough where twice the step gives the same curvature and a peak spans many
/// samples; where the curvature falls with the step, it is the step's and not the surface's.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Resolution {
    /// Height step of the instrument (m), where stated.
    pub height_step: Option<f64>,
    /// Lateral steps along x and y (m).
    pub lateral_step: [f64; 2],
    /// Least curvature that a three-point kernel tells from zero along x and y (1/m): height step over the square of
    /// the lateral step. Its inverse is the largest radius.
    pub least_curvature: Option<[f64; 2]>,
    /// Mean curvature of the peaks found along x and y (1/m).
    pub curvature: [Option<f64>; 2],
    /// Mean curvature at the same peaks by kernels of twice the lateral step (1/m), where data reach that far.
    pub curvature_at_double_step: [Option<f64>; 2],
    /// Samples of the profiles per peak along x and y; 2 is the least, 3 that of white noise.
    pub samples_per_peak: [Option<f64>; 2],
}

/// Sums over the peaks of the profiles along one axis.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PeakSums {
    curvature: f64,
    peaks: usize,
    at_double_step: f64,
    peaks_at_double_step: usize,
}

impl PeakSums {
    /// Adds a peak of `profile`, sampled at `step` (m).
    pub(crate) fn add(&mut self, peak: &LinePeak, profile: &[f64], step: f64) {
        self.curvature += peak.curvature;
        self.peaks += 1;
        let at = |offset: isize| {
            peak.index
                .checked_add_signed(offset)
                .and_then(|k| profile.get(k))
                .copied()
        };
        if let (Some(before), Some(middle), Some(after)) = (at(-2), at(0), at(2)) {
            let bend = (2.0 * middle - before - after) / (4.0 * step * step);
            if !bend.is_nan() {
                self.at_double_step += bend;
                self.peaks_at_double_step += 1;
            }
        }
    }
}

impl Resolution {
    /// Limits for an element of `points` points with the given sums along x and y.
    pub(crate) fn new(map: &HeightMap, points: usize, sums: [PeakSums; 2]) -> Self {
        let mean = |sum: f64, n: usize| (n > 0).then(|| sum / n as f64);
        Self {
            height_step: map.height_step(),
            lateral_step: map.step(),
            least_curvature: map.height_step().map(|q| map.step().map(|d| q / (d * d))),
            curvature: sums.map(|s| mean(s.curvature, s.peaks)),
            curvature_at_double_step: sums.map(|s| mean(s.at_double_step, s.peaks_at_double_step)),
            samples_per_peak: sums.map(|s| mean(points as f64, s.peaks)),
        }
    }
}
