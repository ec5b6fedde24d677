//! Savitzky-Golay smoothing: a polynomial is fitted to each window of equally spaced values by least squares and
//! evaluated in its middle; within half a window of either end the outermost fit is evaluated off its middle.
//!
//! Weights by Gram polynomials: P. A. Gorry, *Analytical Chemistry* 62 (1990) 570.

use crate::Error;
use crate::error::Setting;

/// Degree of the polynomials.
pub const DEGREE: usize = 3;

/// Values and slopes of one polynomial over a window.
type Derivatives = [Vec<f64>; 2];

/// A smoother for windows of one length.
#[derive(Clone, Debug)]
pub struct SavitzkyGolay {
    /// The Gram polynomials over the window, each scaled to unit length.
    polynomials: [Derivatives; DEGREE + 1],
    window: usize,
}

impl SavitzkyGolay {
    /// The smoother over `window` values.
    ///
    /// # Errors
    /// [`Error::Setting`] for windows that are even or shorter than five.
    pub fn try_new(window: usize) -> Result<Self, Error> {
        if window.is_multiple_of(2) || window < DEGREE + 2 {
            return Err(Error::Setting(Setting {
                name: "smoothing window",
                value: window as f64,
                unit: "points",
                allowed: format!("odd and at least {}", DEGREE + 2),
            }));
        }
        let half = (window / 2) as f64;
        let mut polynomials: [Derivatives; DEGREE + 1] = Default::default();
        polynomials[0] = [vec![1.0; window], vec![0.0; window]];
        for degree in 0..=DEGREE {
            if degree > 0 {
                // The next power, by the product rule.
                let [value, slope] = polynomials[degree - 1].clone();
                let of = |term: &dyn Fn(f64, usize) -> f64| -> Vec<f64> {
                    (0..window).map(|i| term((i as f64 - half) / half, i)).collect()
                };
                polynomials[degree] = [of(&|x, i| x * value[i]), of(&|x, i| x * slope[i] + value[i] / half)];
            }
            let (lower, rest) = polynomials.split_at_mut(degree);
            for other in &*lower {
                let share: f64 = rest[0][0].iter().zip(&other[0]).map(|(a, b)| a * b).sum();
                for (row, subtracted) in rest[0].iter_mut().zip(other) {
                    row.iter_mut().zip(subtracted).for_each(|(a, b)| *a -= share * b);
                }
            }
            let length = rest[0][0].iter().map(|v| v * v).sum::<f64>().sqrt();
            rest[0].iter_mut().flatten().for_each(|v| *v /= length);
        }
        Ok(Self { polynomials, window })
    }

    /// Number of values in a window.
    pub fn window(&self) -> usize {
        self.window
    }

    /// Smoothed values; fewer than a window are returned as they are.
    pub fn smooth(&self, values: &[f64]) -> Vec<f64> {
        if values.len() < self.window {
            return values.to_vec();
        }
        self.derivative(values, 0)
    }

    /// Slope per step of the smoothed values; zeros for fewer than a window.
    pub fn slope(&self, values: &[f64]) -> Vec<f64> {
        self.derivative(values, 1)
    }

    fn derivative(&self, values: &[f64], order: usize) -> Vec<f64> {
        let Some(last) = values.len().checked_sub(self.window) else {
            return vec![0.0; values.len()];
        };
        let half = self.window / 2;
        let value = |i: usize| {
            let from = i.saturating_sub(half).min(last);
            let window = &values[from..from + self.window];
            let terms = self.polynomials.iter().map(|polynomial| {
                let coefficient: f64 = window.iter().zip(&polynomial[0]).map(|(v, p)| v * p).sum();
                coefficient * polynomial[order][i - from]
            });
            terms.sum()
        };
        (0..values.len()).map(value).collect()
    }
}
