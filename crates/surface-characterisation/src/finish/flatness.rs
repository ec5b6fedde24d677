//! Random form of a face within its flatness tolerance.

use crate::random::{NormalDeviates, mix};

/// Highest order of the Legendre polynomials along each axis.
const ORDER: usize = 3;
/// Points per side of the grid over which a form fills its tolerance.
const GRID: usize = 65;

/// A random smooth form over a rectangle, which fills a tolerance from its lowest to its highest point.
///
/// `sum c_ij P_i(x) P_j(y)` with Legendre polynomials of orders up to 3 along each side, from order 2 on together: without the
/// plane, as the zone of ISO 1101 turns with the face. The `c_ij` are normal with deviations `1/(i + j)^2`, so that long waves
/// prevail.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatnessForm {
    low: [f64; 2],
    high: [f64; 2],
    coefficients: [[f64; ORDER + 1]; ORDER + 1],
}

impl FlatnessForm {
    /// Over the rectangle between two corners (m), for a tolerance (m); the same seed and side give the same shape.
    pub fn new(low: [f64; 2], high: [f64; 2], tolerance: f64, seed: u64, side: u64) -> Self {
        let mut normal = NormalDeviates::new(mix(seed, side, 3));
        let mut form = Self {
            low,
            high,
            coefficients: [[0.0; ORDER + 1]; ORDER + 1],
        };
        for (i, row) in form.coefficients.iter_mut().enumerate() {
            for (j, c) in row.iter_mut().enumerate() {
                let order = i + j;
                let value = normal.next();
                *c = if order < 2 { 0.0 } else { value / (order * order) as f64 };
            }
        }
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..GRID * GRID {
            let at = [k % GRID, k / GRID].map(|index| 2.0 * index as f64 / (GRID - 1) as f64 - 1.0);
            let z = form.value(at);
            (least, greatest) = (least.min(z), greatest.max(z));
        }
        let scale = tolerance / (greatest - least);
        form.coefficients.iter_mut().flatten().for_each(|c| *c *= scale);
        form
    }

    /// Height (m) at a position (m).
    pub fn height(&self, position: [f64; 2]) -> f64 {
        self.value([0, 1].map(|k| {
            let width = self.high[k] - self.low[k];
            if width > 0.0 {
                2.0 * (position[k] - self.low[k]) / width - 1.0
            } else {
                0.0
            }
        }))
    }

    fn value(&self, at: [f64; 2]) -> f64 {
        let legendre = |x: f64| [1.0, x, 0.5 * (3.0 * x * x - 1.0), 0.5 * (5.0 * x * x - 3.0) * x];
        let [along, across] = at.map(legendre);
        let rows = self.coefficients.iter().zip(along);
        rows.map(|(row, x)| x * row.iter().zip(across).map(|(c, y)| c * y).sum::<f64>())
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_fill_their_tolerance_scale_with_it_and_have_no_plane() {
        let form = |tolerance, seed, side| FlatnessForm::new([-0.06, -0.0127], [0.06, 0.0127], tolerance, seed, side);
        for seed in 0..20 {
            let f = form(5e-6, seed, 0);
            let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
            let (mut mean, mut slope) = (0.0, [0.0; 2]);
            let n = 200;
            for i in 0..n {
                for j in 0..n {
                    let at = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n) * 2.0 - 1.0);
                    let z = f.height([0.06 * at[0], 0.0127 * at[1]]);
                    (least, greatest) = (least.min(z), greatest.max(z));
                    mean += z;
                    (slope[0], slope[1]) = (slope[0] + z * at[0], slope[1] + z * at[1]);
                }
            }
            assert!(
                (greatest - least) / 5e-6 > 0.95 && (greatest - least) / 5e-6 < 1.001,
                "{seed}"
            );
            for sum in [mean, slope[0], slope[1]] {
                assert!((sum / f64::from(n * n)).abs() < 1e-3 * 5e-6);
            }
            let double = form(10e-6, seed, 0);
            assert!((double.height([0.01, 0.002]) / f.height([0.01, 0.002]) - 2.0).abs() < 1e-12);
        }
        assert_ne!(form(5e-6, 1, 0), form(5e-6, 1, 1));
        assert_ne!(form(5e-6, 1, 0), form(5e-6, 2, 0));
    }
}
