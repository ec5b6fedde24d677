//! Extrema of an oscillation, and more samples per cycle where there are too few for them.

use std::f64::consts::PI;

/// Fewer samples per cycle than this are interpolated first: three samples about an extremum of a sine then give its time
/// within 1e-5 of a cycle.
pub const SAMPLES_PER_CYCLE: f64 = 40.0;

/// Samples on either side that the interpolation uses.
pub(crate) const REACH: usize = 24;

/// Shape of the Kaiser window: images lie 118 dB lower.
const SHAPE: f64 = 12.0;

/// An extremum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Place, in samples from the first.
    pub position: f64,
    /// Value: positive at maxima, negative at minima.
    pub value: f64,
}

/// Maxima above zero and minima below it, each the vertex of the parabola through the three samples about it.
pub fn peaks(samples: &[f64]) -> Vec<Peak> {
    let extremum = |(i, w): (usize, &[f64])| {
        let [a, b, c] = [w[0], w[1], w[2]];
        let sign = b.signum();
        // Of two equal samples the first counts.
        let found = b != 0.0 && sign * b > sign * a && sign * b >= sign * c;
        found.then(|| {
            let (slope, bend) = (0.5 * (c - a), a - 2.0 * b + c);
            let offset = -slope / bend;
            Peak {
                position: (i + 1) as f64 + offset,
                value: b + 0.5 * slope * offset,
            }
        })
    };
    samples.windows(3).enumerate().filter_map(extremum).collect()
}

/// `factor` times as many samples of the band-limited signal through the given ones (content up to 0.4 of the sample
/// rate), by a sinc under a Kaiser window. Sample `i` becomes sample `i * factor`; beyond the ends the signal counts as zero.
pub fn upsample(samples: &[f64], factor: usize) -> Vec<f64> {
    let weight = |x: f64| {
        let inside = 1.0 - (x / REACH as f64).powi(2);
        if x == 0.0 {
            1.0
        } else if inside <= 0.0 {
            0.0
        } else {
            (PI * x).sin() / (PI * x) * bessel(SHAPE * inside.sqrt()) / bessel(SHAPE)
        }
    };
    // For each phase the weights of samples i - REACH + 1 ..= i + REACH.
    let phases: Vec<Vec<f64>> = (0..factor)
        .map(|phase| {
            let part = phase as f64 / factor as f64;
            let weights: Vec<f64> = (0..2 * REACH)
                .map(|k| weight(part + REACH as f64 - 1.0 - k as f64))
                .collect();
            // Constants stay what they are.
            let sum: f64 = weights.iter().sum();
            weights.into_iter().map(|w| w / sum).collect()
        })
        .collect();
    let mut out = Vec::with_capacity(samples.len() * factor);
    for i in 0..samples.len() {
        let (from, skipped) = match (i + 1).checked_sub(REACH) {
            Some(from) => (from, 0),
            None => (0, REACH - 1 - i),
        };
        let window = &samples[from..samples.len().min(i + 1 + REACH)];
        for weights in &phases {
            out.push(window.iter().zip(&weights[skipped..]).map(|(s, w)| s * w).sum());
        }
    }
    out
}

/// Modified Bessel function of the first kind and order zero.
fn bessel(x: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..60 {
        term *= (x / (2.0 * f64::from(k))).powi(2);
        sum += term;
    }
    sum
}
