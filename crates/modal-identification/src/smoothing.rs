//! Savitzky-Golay smoothing: a polynomial is fitted to each window of equally spaced values by least squares and
//! evaluated in its middle; within half a window of either end the outermost fit is evaluated off its middle.
//!
//! Weights by Gram polynomials: P. A. Gorry, *Analytical Chemistry* 62 (1990) 570.

use crate::Error;
use crate::error::Setting;

/// Degree of the polynomials.
pub const DEGREE: usize = 3;

/// A smoother for windows of one length.
#[derive(Clone, Debug)]
pub struct SavitzkyGolay {
    /// Values and slopes of the Gram polynomials over the window, each scaled to unit length.
    polynomials: [Vec<f64>; DEGREE + 1],
    slopes: [Vec<f64>; DEGREE + 1],
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
        let at = |i: usize| (i as f64 - half) / half;
        let mut polynomials: [Vec<f64>; DEGREE + 1] = Default::default();
        let mut slopes: [Vec<f64>; DEGREE + 1] = Default::default();
        for degree in 0..=DEGREE {
            let below = degree.saturating_sub(1);
            let (mut p, mut s): (Vec<f64>, Vec<f64>) = match degree {
                0 => (vec![1.0; window], vec![0.0; window]),
                _ => {
                    let (p, s) = (&polynomials[below], &slopes[below]);
                    let values = (0..window).map(|i| at(i) * p[i]).collect();
                    (values, (0..window).map(|i| p[i] / half + at(i) * s[i]).collect())
                }
            };
            for lower in 0..degree {
                let share: f64 = p.iter().zip(&polynomials[lower]).map(|(a, b)| a * b).sum();
                for i in 0..window {
                    p[i] -= share * polynomials[lower][i];
                    s[i] -= share * slopes[lower][i];
                }
            }
            let length = p.iter().map(|v| v * v).sum::<f64>().sqrt();
            polynomials[degree] = p.into_iter().map(|v| v / length).collect();
            slopes[degree] = s.into_iter().map(|v| v / length).collect();
        }
        Ok(Self {
            polynomials,
            slopes,
            window,
        })
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
        self.evaluate(values, &self.polynomials)
    }

    /// Slope per step of the smoothed values; zeros for fewer than a window.
    pub fn slope(&self, values: &[f64]) -> Vec<f64> {
        if values.len() < self.window {
            return vec![0.0; values.len()];
        }
        self.evaluate(values, &self.slopes)
    }

    fn evaluate(&self, values: &[f64], basis: &[Vec<f64>; DEGREE + 1]) -> Vec<f64> {
        let half = self.window / 2;
        let last = values.len() - self.window;
        let value = |i: usize| {
            let from = i.saturating_sub(half).min(last);
            let window = &values[from..from + self.window];
            let terms = self.polynomials.iter().zip(basis).map(|(p, b)| {
                let coefficient: f64 = window.iter().zip(p).map(|(v, p)| v * p).sum();
                coefficient * b[i - from]
            });
            terms.sum()
        };
        (0..values.len()).map(value).collect()
    }
}
