//! Distributions of single numbers, and their dependence by a Gaussian copula.

use nalgebra::{Cholesky, DMatrix};
use statrs::function::erf::{erfc, erfc_inv};
use std::f64::consts::{PI, SQRT_2};

/// Ends and steps per unit of the trapezoidal rule over a standard normal variable. Its error for smooth functions is round-off, and that of
/// the tails beyond is 1e-15.
const TAIL: i32 = 8;
const STEPS: i32 = 32;
/// The same in two dimensions.
const PAIR_STEPS: i32 = 8;

/// A distribution before it is truncated (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Normal.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        sd: f64,
    },
    /// Lognormal.
    Lognormal {
        /// Median.
        median: f64,
        /// Standard deviation of the natural logarithm (-).
        sd_of_log: f64,
    },
    /// Uniform.
    Uniform {
        /// Smallest value.
        low: f64,
        /// Largest value.
        high: f64,
    },
    /// Triangular.
    Triangular {
        /// Smallest value.
        low: f64,
        /// Most likely value.
        mode: f64,
        /// Largest value.
        high: f64,
    },
}

/// A distribution of a number, perhaps truncated (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marginal {
    shape: Shape,
    /// Bounds, and the probabilities of the whole shape below them.
    between: Option<([f64; 2], [f64; 2])>,
}

/// Probability that a standard normal variable is below `z`.
pub fn probability(z: f64) -> f64 {
    0.5 * erfc(-z / SQRT_2)
}

/// The value that a standard normal variable is below with a probability.
pub fn standard_normal(probability: f64) -> f64 {
    -SQRT_2 * erfc_inv(2.0 * probability)
}

impl Shape {
    /// Probability of values below `x`.
    fn cdf(self, x: f64) -> f64 {
        match self {
            Self::Normal { mean, sd } => probability((x - mean) / sd),
            Self::Lognormal { .. } if x <= 0.0 => 0.0,
            Self::Lognormal { median, sd_of_log } => probability((x / median).ln() / sd_of_log),
            Self::Uniform { low, high } => ((x - low) / (high - low)).clamp(0.0, 1.0),
            Self::Triangular { low, mode, high } => {
                let width = high - low;
                if x <= low {
                    0.0
                } else if x >= high {
                    1.0
                } else if x < mode {
                    (x - low).powi(2) / (width * (mode - low))
                } else {
                    1.0 - (high - x).powi(2) / (width * (high - mode))
                }
            }
        }
    }

    fn quantile(self, p: f64) -> f64 {
        match self {
            Self::Normal { .. } | Self::Lognormal { .. } => self.at(standard_normal(p)),
            Self::Uniform { low, high } => low + p * (high - low),
            Self::Triangular { low, mode, high } => {
                let width = high - low;
                if p * width < mode - low {
                    low + (p * width * (mode - low)).sqrt()
                } else {
                    high - ((1.0 - p) * width * (high - mode)).sqrt()
                }
            }
        }
    }

    /// The value that has the same probability below it as `z` of a standard normal variable.
    fn at(self, z: f64) -> f64 {
        match self {
            Self::Normal { mean, sd } => mean + sd * z,
            Self::Lognormal { median, sd_of_log } => median * (sd_of_log * z).exp(),
            other => other.quantile(probability(z)),
        }
    }

    fn check(self) -> Result<(), String> {
        let rising =
            |values: &[f64]| values.windows(2).all(|pair| pair[0] <= pair[1]) && values.first() < values.last();
        match self {
            Self::Normal { sd, .. } if !(sd > 0.0 && sd.is_finite()) => {
                Err(format!("its standard deviation of {sd} must be positive and finite"))
            }
            Self::Lognormal { median, .. } if !(median > 0.0) => {
                Err(format!("its median of {median} must be positive"))
            }
            Self::Lognormal { sd_of_log, .. } if !(sd_of_log > 0.0 && sd_of_log.is_finite()) => {
                Err("its cov must be positive and finite".into())
            }
            Self::Uniform { low, high } if !rising(&[low, high]) => {
                Err(format!("[{low}, {high}] does not rise; give the smallest value first"))
            }
            Self::Triangular { low, mode, high } if !rising(&[low, mode, high]) => Err(format!(
                "[{low}, {mode}, {high}] does not rise; give the smallest, the most likely and the largest value"
            )),
            _ => Ok(()),
        }
    }
}

impl Marginal {
    /// Truncates a shape at bounds.
    ///
    /// # Errors
    /// What is wrong with its numbers.
    pub fn try_new(shape: Shape, between: Option<[f64; 2]>) -> Result<Self, String> {
        shape.check()?;
        let between = match between {
            None => None,
            Some(bounds) => {
                let probabilities = bounds.map(|bound| shape.cdf(bound));
                if !(probabilities[1] - probabilities[0] > 1e-6) {
                    let [low, high] = bounds;
                    return Err(format!(
                        "it has no values between {low} and {high}; move the bounds apart or to its values"
                    ));
                }
                Some((bounds, probabilities))
            }
        };
        Ok(Self { shape, between })
    }

    /// What it is, before it is truncated.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Smallest and largest value, where they are finite.
    pub fn support(&self) -> Option<[f64; 2]> {
        match (self.between, self.shape) {
            (Some(_), _) => Some([0.0, 1.0].map(|p| self.quantile(p))),
            (None, Shape::Uniform { low, high } | Shape::Triangular { low, high, .. }) => Some([low, high]),
            _ => None,
        }
    }

    /// The value that is not exceeded with a probability between 0 and 1.
    pub fn quantile(&self, p: f64) -> f64 {
        match self.between {
            None => self.shape.quantile(p),
            Some(([low, high], [from, to])) => self.shape.quantile(from + p * (to - from)).clamp(low, high),
        }
    }

    /// The value that has the same probability below it as `z` of a standard normal variable.
    pub fn at(&self, z: f64) -> f64 {
        match self.between {
            None => self.shape.at(z),
            Some(_) => self.quantile(probability(z)),
        }
    }

    /// Mean and standard deviation.
    pub fn moments(&self) -> [f64; 2] {
        let over = |of: &dyn Fn(f64) -> f64| nodes(STEPS).map(|(z, weight)| weight * of(z)).sum::<f64>();
        let mean = over(&|z| self.at(z));
        [mean, over(&|z| (self.at(z) - mean).powi(2)).sqrt()]
    }

    /// Covariance with another number, where the Gaussian copula of the two has a correlation.
    pub fn covariance(&self, other: &Self, correlation: f64) -> f64 {
        let (mean, other_mean) = (self.moments()[0], other.moments()[0]);
        let rest = (1.0 - correlation * correlation).sqrt();
        let row = |(z, weight): (f64, f64)| {
            let along = nodes(PAIR_STEPS).map(|(own, weight)| {
                let value = other.at((correlation * z + rest * own).clamp(-f64::from(TAIL), f64::from(TAIL)));
                weight * (value - other_mean)
            });
            weight * (self.at(z) - mean) * along.sum::<f64>()
        };
        nodes(PAIR_STEPS).map(row).sum()
    }
}

/// Nodes and weights of the expectation over a standard normal variable.
fn nodes(steps: i32) -> impl Iterator<Item = (f64, f64)> {
    (-TAIL * steps..=TAIL * steps).map(move |k| {
        let z = f64::from(k) / f64::from(steps);
        (z, (-0.5 * z * z).exp() / (2.0 * PI).sqrt() / f64::from(steps))
    })
}

/// Lower triangular factor of a correlation matrix, row by row.
///
/// # Errors
/// What is wrong with a matrix that is not positive definite.
pub fn cholesky(matrix: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, String> {
    let n = matrix.len();
    let dense = DMatrix::from_fn(n, n, |i, j| matrix[i][j]);
    let least = dense.symmetric_eigenvalues().min();
    let factor = (least > 1e-10).then(|| Cholesky::new(dense)).flatten();
    let factor = factor.ok_or_else(|| {
        format!(
            "no numbers have these correlations together: their matrix has the eigenvalue {least:.3}, and all must be positive; lower \
             their sizes"
        )
    })?;
    let lower = factor.l();
    Ok((0..n).map(|i| (0..n).map(|j| lower[(i, j)]).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marginal(shape: Shape, between: Option<[f64; 2]>) -> Marginal {
        Marginal::try_new(shape, between).unwrap()
    }

    #[test]
    fn moments_and_quantiles_are_the_closed_forms() {
        let close = |found: f64, expected: f64, tolerance: f64| {
            assert!(
                (found - expected).abs() < tolerance * expected.abs().max(1e-3),
                "{found} {expected}"
            );
        };
        let normal = marginal(Shape::Normal { mean: 3.0, sd: 0.5 }, None);
        let [mean, sd] = normal.moments();
        close(mean, 3.0, 1e-12);
        close(sd, 0.5, 1e-10);
        close(normal.quantile(0.975), 3.0 + 0.5 * 1.959_963_984_540_054, 1e-12);
        close(normal.quantile(0.05), 3.0 - 0.5 * 1.644_853_626_951_472_7, 1e-12);
        let lognormal = marginal(
            Shape::Lognormal {
                median: 2.0,
                sd_of_log: 0.4,
            },
            None,
        );
        let [mean, sd] = lognormal.moments();
        close(mean, 2.0 * 0.08_f64.exp(), 1e-10);
        close(sd, mean * 0.16_f64.exp_m1().sqrt(), 1e-9);
        close(lognormal.quantile(0.5), 2.0, 1e-12);
        let uniform = marginal(Shape::Uniform { low: 0.8, high: 1.25 }, None);
        let [mean, sd] = uniform.moments();
        close(mean, 1.025, 1e-10);
        close(sd, 0.45 / 12_f64.sqrt(), 1e-6);
        let (low, mode, high) = (1.0, 2.0, 4.0);
        let triangular = marginal(Shape::Triangular { low, mode, high }, None);
        let [mean, sd] = triangular.moments();
        close(mean, (low + mode + high) / 3.0, 1e-6);
        let squares = low * low + mode * mode + high * high - low * mode - low * high - mode * high;
        close(sd, (squares / 18.0).sqrt(), 1e-5);
        close(triangular.quantile(1.0 / 3.0), mode, 1e-12);
        // Of a half-normal distribution.
        let half = marginal(Shape::Normal { mean: 0.0, sd: 1.0 }, Some([0.0, 30.0]));
        let [mean, sd] = half.moments();
        close(mean, (2.0 / PI).sqrt(), 1e-6);
        close(sd, (1.0 - 2.0 / PI).sqrt(), 1e-5);
        close(half.quantile(0.5), 0.674_489_750_196_081_7, 1e-9);
    }

    #[test]
    fn covariances_are_those_of_the_copula() {
        let normal = marginal(Shape::Normal { mean: 3.0, sd: 0.5 }, None);
        let other = marginal(Shape::Normal { mean: 1.0, sd: 2.0 }, None);
        assert!((normal.covariance(&other, 0.6) - 0.6).abs() < 1e-10);
        // Of lognormal numbers: exp(rho s t) - 1, times the means.
        let a = marginal(
            Shape::Lognormal {
                median: 1.0,
                sd_of_log: 0.3,
            },
            None,
        );
        let b = marginal(
            Shape::Lognormal {
                median: 1.0,
                sd_of_log: 0.2,
            },
            None,
        );
        let expected = (0.5 * (0.09_f64 + 0.04)).exp() * (-0.5_f64 * 0.06).exp_m1();
        assert!((a.covariance(&b, -0.5) - expected).abs() < 1e-9);
        assert!((a.covariance(&b, 0.0)).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_distribution_is_refused() {
        for shape in [
            Shape::Normal { mean: 1.0, sd: 0.0 },
            Shape::Lognormal {
                median: -1.0,
                sd_of_log: 0.1,
            },
            Shape::Lognormal {
                median: 1.0,
                sd_of_log: -0.1,
            },
            Shape::Uniform { low: 2.0, high: 1.0 },
            Shape::Triangular {
                low: 1.0,
                mode: 5.0,
                high: 2.0,
            },
        ] {
            assert!(Marginal::try_new(shape, None).is_err(), "{shape:?}");
        }
        let shape = Shape::Normal { mean: 1.0, sd: 0.1 };
        assert!(Marginal::try_new(shape, Some([3.0, 4.0])).is_err());
        let wrong = vec![vec![1.0, 0.9, -0.9], vec![0.9, 1.0, 0.9], vec![-0.9, 0.9, 1.0]];
        assert!(cholesky(&wrong).unwrap_err().contains("eigenvalue -0.8"));
    }
}
