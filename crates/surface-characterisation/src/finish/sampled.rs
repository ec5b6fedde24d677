//! Peaks of profiles and summits of areas on a grid, in expectation: what the characterisation finds of a random face.
//!
//! On a grid a peak is a point above its two neighbours and a summit one above its eight. Both depend on the correlation at
//! one and two steps alone, at any step (Whitehouse and Archard, Proc. R. Soc. A 316, 1970; Greenwood, Proc. R. Soc. A 393,
//! 1984, doi 10.1098/rspa.1984.0042); as the step goes to zero they become those of Rice and Nayak. A translation of the
//! heights moves no peak.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use statrs::function::erf::{erfc, erfc_inv};

use super::face::FaceFinish;

/// Nodes of the integrals over the bend and the lean of three neighbours.
const BENDS: usize = 48;
const LEANS: usize = 16;
/// Nodes of the height of the middle point for the curvature of translated heights.
const MIDDLES: usize = 24;
/// Heights in standard deviations at which the summits are counted, and points of the lattice for each.
const LOWEST: f64 = -2.6;
const LEVELS: usize = 46;
const LEVEL_STEP: f64 = 0.2;
const LATTICE: usize = 1024;

/// Upper tail of the standard normal distribution.
pub(super) fn upper_tail(x: f64) -> f64 {
    0.5 * erfc(x * FRAC_1_SQRT_2)
}

/// Peaks of the profiles along one axis.
#[derive(Debug, Clone)]
pub(super) struct LinePeaks {
    /// Share of the points that are peaks.
    pub(super) share: f64,
    /// Mean curvature of their parabolas (1/m).
    pub(super) curvature: f64,
    /// Weight, mean and deviation of the normal distributions whose mixture the vertices' heights are, in standard normal
    /// values.
    parts: Vec<[f64; 2]>,
    deviation: f64,
}

impl LinePeaks {
    /// Along `axis` at a grid step (m).
    pub(super) fn new(face: &FaceFinish, axis: usize, step: f64) -> Self {
        let at = |k: f64| {
            let mut lag = [0.0; 2];
            lag[axis] = k * step;
            face.normal_correlation(lag)
        };
        let (r1, r2) = (at(1.0), at(2.0));
        // The bend 2 y0 - y1 - y2 and the lean y1 - y2 are independent, and so are the lean and the middle y0.
        let (bend, lean) = (6.0 - 8.0 * r1 + 2.0 * r2, 2.0 - 2.0 * r2);
        let slope = 2.0 * (1.0 - r1) / bend;
        let variance = 1.0 - slope * slope * bend;
        let deviation = variance.max(0.0).sqrt();
        let widest = (bend / lean).sqrt().atan();
        let (mut parts, mut curvature, mut all) = (Vec::with_capacity(BENDS * LEANS), 0.0, 0.0);
        for k in 0..BENDS {
            let width = 6.5 / BENDS as f64;
            let radius = (k as f64 + 0.5) * width;
            for l in 0..LEANS {
                let angle = (l as f64 + 0.5) * widest / LEANS as f64;
                let weight = radius * (-0.5 * radius * radius).exp();
                let (s, t) = (bend.sqrt() * radius * angle.cos(), lean.sqrt() * radius * angle.sin());
                let middle = slope * s;
                parts.push([weight, middle + t * t / (8.0 * s)]);
                all += weight;
                curvature += weight
                    * match face.translation().is_gaussian() {
                        true => face.rms() * s,
                        false => mean_bend(face, middle, deviation, [0.5 * (s + t), 0.5 * (s - t)]),
                    };
            }
        }
        for part in &mut parts {
            part[0] /= all;
        }
        Self {
            share: widest / PI,
            curvature: curvature / all / (step * step),
            parts,
            deviation,
        }
    }

    /// Variance of the bend given the height of the middle, over its mean squared at a height of one standard deviation:
    /// bandwidth less one, as the squared correlation of height and curvature is one over the bandwidth.
    pub(super) fn scatter(&self) -> f64 {
        let variance = self.deviation * self.deviation;
        variance / (1.0 - variance).max(f64::MIN_POSITIVE)
    }

    /// Share of the peaks above a standard normal value.
    pub(super) fn above(&self, y: f64) -> f64 {
        let tail = |&[weight, mean]: &[f64; 2]| weight * upper_tail((y - mean) / self.deviation);
        self.parts.iter().map(tail).sum()
    }
}

/// Mean of `2 z0 - z1 - z2` (m) of translated heights, over a normal middle and given falls to both sides.
fn mean_bend(face: &FaceFinish, mean: f64, deviation: f64, falls: [f64; 2]) -> f64 {
    let (mut sum, mut all) = (0.0, 0.0);
    for k in 0..MIDDLES {
        let x = -5.0 + 10.0 * (k as f64 + 0.5) / MIDDLES as f64;
        let weight = (-0.5 * x * x).exp();
        let y = mean + deviation * x;
        sum += weight * (2.0 * face.height(y) - face.height(y - falls[0]) - face.height(y - falls[1]));
        all += weight;
    }
    sum / all
}

/// Summits of the area: points above their eight neighbours.
#[derive(Debug, Clone)]
pub(super) struct Summits {
    /// Share of the points that are summits above each level, ascending levels.
    above: Vec<f64>,
}

impl Summits {
    /// On a grid of these steps (m).
    pub(super) fn new(face: &FaceFinish, step: [f64; 2]) -> Self {
        const AROUND: [[f64; 2]; 8] = [
            [1.0, 0.0],
            [-1.0, 0.0],
            [0.0, 1.0],
            [0.0, -1.0],
            [1.0, 1.0],
            [-1.0, -1.0],
            [1.0, -1.0],
            [-1.0, 1.0],
        ];
        let correlation =
            |a: [f64; 2], b: [f64; 2]| face.normal_correlation([(a[0] - b[0]) * step[0], (a[1] - b[1]) * step[1]]);
        let with_middle = AROUND.map(|a| correlation(a, [0.0; 2]));
        let root = cholesky(|i, j| correlation(AROUND[i], AROUND[j]) - with_middle[i] * with_middle[j]);
        let density = |y: f64| {
            let bounds = with_middle.map(|r| y * (1.0 - r));
            (-0.5 * y * y).exp() / TAU.sqrt() * below(&root, &bounds)
        };
        let densities: Vec<f64> = (0..LEVELS)
            .map(|k| density(LOWEST + (k as f64 + 0.5) * LEVEL_STEP))
            .collect();
        let mut above = vec![0.0; LEVELS + 1];
        for k in (0..LEVELS).rev() {
            above[k] = above[k + 1] + LEVEL_STEP * densities[k];
        }
        Self { above }
    }

    /// Share of the points that are summits.
    pub(super) fn share(&self) -> f64 {
        self.above[0]
    }

    /// Share of the points that are summits above a standard normal value.
    pub(super) fn above(&self, y: f64) -> f64 {
        let position = ((y - LOWEST) / LEVEL_STEP).clamp(0.0, LEVELS as f64 - 1.0);
        let k = position as usize;
        let [lower, upper] = [self.above[k], self.above[k + 1]].map(|share| share.max(1e-300).ln());
        (lower + (position - k as f64) * (upper - lower)).exp()
    }

    /// Standard normal value above which `number` of the summits of `points` points lie in the mean.
    pub(super) fn level(&self, points: f64, number: f64) -> f64 {
        let wanted = (number / points).min(self.share());
        let k = self
            .above
            .partition_point(|share| *share >= wanted)
            .clamp(1, LEVELS - 1);
        let [upper, lower] = [self.above[k], self.above[k - 1]].map(|share| share.max(1e-300).ln());
        let part = ((lower - wanted.ln()) / (lower - upper)).clamp(0.0, 1.0);
        LOWEST + (k as f64 - 1.0 + part) * LEVEL_STEP
    }
}

/// Lower triangular root; what round-off leaves below zero counts as a tiny variance.
fn cholesky(of: impl Fn(usize, usize) -> f64) -> [[f64; 8]; 8] {
    let mut root = [[0.0; 8]; 8];
    for j in 0..8 {
        let square: f64 = of(j, j) - (0..j).map(|k| root[j][k] * root[j][k]).sum::<f64>();
        root[j][j] = square.max(1e-15).sqrt();
        for i in j + 1..8 {
            let product: f64 = (0..j).map(|k| root[i][k] * root[j][k]).sum();
            root[i][j] = (of(i, j) - product) / root[j][j];
        }
    }
    root
}

/// Probability that eight normal values stay below their bounds, by separation of variables on a lattice (Genz, J. Comput.
/// Graph. Stat. 1, 1992, doi 10.1080/10618600.1992.10477010): smooth in the correlations.
fn below(root: &[[f64; 8]; 8], bounds: &[f64; 8]) -> f64 {
    const PRIMES: [f64; 7] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0];
    let mut sum = 0.0;
    for point in 0..LATTICE {
        let (mut product, mut values) = (1.0, [0.0; 8]);
        for i in 0..8 {
            let shift: f64 = (0..i).map(|k| root[i][k] * values[k]).sum();
            let share = upper_tail(-(bounds[i] - shift) / root[i][i]);
            product *= share;
            if i == 7 || product < 1e-30 {
                break;
            }
            let turn = ((point as f64 + 0.5) * PRIMES[i].sqrt()).fract();
            let probability = (share * (2.0 * turn - 1.0).abs()).max(1e-290);
            values[i] = -std::f64::consts::SQRT_2 * erfc_inv(2.0 * probability);
        }
        sum += product;
    }
    sum / LATTICE as f64
}
