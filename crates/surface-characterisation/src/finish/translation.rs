//! Heights of prescribed skewness and kurtosis as a rising function of Gaussian ones (a translation process).

use super::error::FinishError;

/// Nodes of the integrals over the standard normal distribution: equidistant on `[-RANGE, RANGE]`, for which the
/// trapezoidal rule converges exponentially.
const RANGE: f64 = 12.0;
const NODES: usize = 240;
/// Terms of the Hermite expansion that carries correlations through the translation.
const TERMS: usize = 16;

/// Sinh-arcsinh translation `g(y) = (sinh((asinh(y) + e)/d) - mean)/deviation` of a standard normal `y`, with zero mean and
/// unit variance (Jones and Pewsey, Biometrika 96, 2009, doi 10.1093/biomet/asp053).
///
/// `e` gives skewness, `d < 1` heavier tails than Gaussian, `d > 1` lighter ones. The function rises everywhere and is the
/// identity at `e = 0`, `d = 1`, so that it is smooth in its moments there, which families of several types (Johnson's) are
/// not.
#[derive(Debug, Clone, PartialEq)]
pub struct Translation {
    shift: f64,
    tail: f64,
    mean: f64,
    deviation: f64,
    /// Squares of the Hermite coefficients of orders 1, 2, ..., which sum to one: `rho_z = sum c_k rho_y^k`.
    hermite: [f64; TERMS],
    is_gaussian: bool,
}

/// Density-weighted nodes of the standard normal distribution.
fn normal_nodes() -> impl Iterator<Item = (f64, f64)> {
    let step = 2.0 * RANGE / NODES as f64;
    (0..=NODES).map(move |k| {
        let y = -RANGE + k as f64 * step;
        (y, step * (-0.5 * y * y).exp() / std::f64::consts::TAU.sqrt())
    })
}

fn raw(y: f64, shift: f64, tail: f64) -> f64 {
    ((y.asinh() + shift) / tail).sinh()
}

/// Mean, deviation, skewness and kurtosis of the untranslated family.
fn moments(shift: f64, tail: f64) -> [f64; 4] {
    let mean: f64 = normal_nodes().map(|(y, w)| w * raw(y, shift, tail)).sum();
    let mut central = [0.0; 3];
    for (y, w) in normal_nodes() {
        let z = raw(y, shift, tail) - mean;
        for (sum, power) in central.iter_mut().zip([z * z, z * z * z, z * z * z * z]) {
            *sum += w * power;
        }
    }
    let [m2, m3, m4] = central;
    [mean, m2.sqrt(), m3 / m2.powf(1.5), m4 / (m2 * m2)]
}

impl Translation {
    /// The translation whose heights have this skewness and kurtosis (3 for a Gaussian surface).
    ///
    /// # Errors
    /// Values that are not finite, a kurtosis that no distribution has, moments that the family does not reach.
    pub fn try_new(skewness: f64, kurtosis: f64) -> Result<Self, FinishError> {
        for (field, value) in [("skewness", skewness), ("kurtosis", kurtosis)] {
            if !value.is_finite() {
                return Err(FinishError::Value {
                    field,
                    value,
                    unit: "",
                    requirement: "finite",
                });
            }
        }
        if !(kurtosis > skewness * skewness + 1.0) {
            return Err(FinishError::Kurtosis { skewness, kurtosis });
        }
        let is_gaussian = skewness == 0.0 && kurtosis == 3.0;
        let (shift, tail) = match is_gaussian {
            true => (0.0, 1.0),
            false => solve(skewness, kurtosis).ok_or(FinishError::Translation { skewness, kurtosis })?,
        };
        let [mean, deviation, ..] = moments(shift, tail);
        let mut translation = Self {
            shift,
            tail,
            mean,
            deviation,
            hermite: [0.0; TERMS],
            is_gaussian,
        };
        translation.hermite = translation.expand();
        Ok(translation)
    }

    /// Whether heights stay Gaussian.
    pub fn is_gaussian(&self) -> bool {
        self.is_gaussian
    }

    /// Height of unit variance of a standard normal value.
    pub fn height(&self, y: f64) -> f64 {
        match self.is_gaussian {
            true => y,
            false => (raw(y, self.shift, self.tail) - self.mean) / self.deviation,
        }
    }

    /// The standard normal value of a height of unit variance.
    pub fn normal(&self, height: f64) -> f64 {
        match self.is_gaussian {
            true => height,
            false => (self.tail * (self.mean + self.deviation * height).asinh() - self.shift).sinh(),
        }
    }

    /// Mean absolute height, Ra over Rq: `sqrt(2/pi)` of a Gaussian surface.
    pub fn mean_absolute(&self) -> f64 {
        // Twice the part above the mean, from where the integrand vanishes on: the kink of an absolute value is at no node.
        const PARTS: usize = 4000;
        let first = self.normal(0.0);
        let width = (RANGE - first) / PARTS as f64;
        let parts = (0..PARTS).map(|k| first + (k as f64 + 0.5) * width);
        let sum: f64 = parts.map(|y| self.height(y) * (-0.5 * y * y).exp()).sum();
        2.0 * width * sum / std::f64::consts::TAU.sqrt()
    }

    /// `k! a_k^2` of the expansion `g = sum a_k He_k` (Mehler), what is cut off given to the last term.
    fn expand(&self) -> [f64; TERMS] {
        let mut coefficients = [0.0; TERMS];
        for (y, w) in normal_nodes() {
            let z = self.height(y);
            // He_k / sqrt(k!): h_{k+1} = (y h_k - sqrt(k) h_{k-1})/sqrt(k + 1).
            let (mut before, mut now) = (1.0, y);
            for (k, c) in coefficients.iter_mut().enumerate() {
                *c += w * z * now;
                let order = (k + 1) as f64;
                let next = (y * now - order.sqrt() * before) / (order + 1.0).sqrt();
                (before, now) = (now, next);
            }
        }
        let mut squares = coefficients.map(|c| c * c);
        let rest = 1.0 - squares.iter().sum::<f64>();
        squares[TERMS - 1] += rest.max(0.0);
        squares
    }

    /// Correlation of the heights where the normal values have correlation `rho`.
    pub fn correlation(&self, rho: f64) -> f64 {
        self.polynomial(rho).0
    }

    fn polynomial(&self, rho: f64) -> (f64, f64) {
        let (mut value, mut slope) = (0.0, 0.0);
        for c in self.hermite.iter().rev() {
            slope = slope * rho + value;
            value = value * rho + c;
        }
        // sum c_k rho^(k + 1).
        (value * rho, slope * rho + value)
    }

    /// Correlation of the normal values that gives the heights the correlation `wanted`; the nearest one below what can be
    /// reached.
    pub fn normal_correlation(&self, wanted: f64) -> f64 {
        if self.is_gaussian || wanted >= 1.0 {
            return wanted.min(1.0);
        }
        let mut rho = wanted;
        for _ in 0..50 {
            let (value, slope) = self.polynomial(rho);
            let next = (rho - (value - wanted) / slope.max(0.05)).clamp(-1.0, 1.0);
            if (next - rho).abs() < 1e-15 {
                return next;
            }
            rho = next;
        }
        rho
    }
}

/// Shift and tail of the family with these moments, by Newton's method along a straight path from the Gaussian moments.
fn solve(skewness: f64, kurtosis: f64) -> Option<(f64, f64)> {
    const STEPS: usize = 16;
    // The logarithm of the tail: positive, and nearly linear in the logarithm of the excess over the bound.
    let residual = |x: [f64; 2], goal: [f64; 2]| {
        let [_, _, s, k] = moments(x[0], x[1].exp());
        [s - goal[0], (k - s * s - 1.0).ln() - goal[1]]
    };
    let mut x = [0.0; 2];
    for step in 1..=STEPS {
        let part = step as f64 / STEPS as f64;
        let s = part * skewness;
        let k = 3.0 + part * (kurtosis - 3.0);
        // A straight path from (0, 3) stays above the parabola k = s^2 + 1, which is convex.
        let goal = [s, (k - s * s - 1.0).ln()];
        let mut last = residual(x, goal);
        let mut converged = false;
        for _ in 0..40 {
            if last[0].abs().max(last[1].abs()) < 1e-11 {
                converged = true;
                break;
            }
            let h = 1e-6;
            let columns = [0, 1].map(|axis| {
                let (mut up, mut down) = (x, x);
                up[axis] += h;
                down[axis] -= h;
                let (up, down) = (residual(up, goal), residual(down, goal));
                [0, 1].map(|k| (up[k] - down[k]) / (2.0 * h))
            });
            let determinant = columns[0][0] * columns[1][1] - columns[1][0] * columns[0][1];
            let mut move_by = [
                -(last[0] * columns[1][1] - last[1] * columns[1][0]) / determinant,
                -(last[1] * columns[0][0] - last[0] * columns[0][1]) / determinant,
            ];
            let largest = move_by[0].abs().max(move_by[1].abs());
            if !largest.is_finite() {
                return None;
            }
            if largest > 0.3 {
                move_by = move_by.map(|m| 0.3 * m / largest);
            }
            let size = |r: [f64; 2]| r[0].hypot(r[1]);
            let mut scale = 1.0;
            loop {
                let trial = [x[0] + scale * move_by[0], x[1] + scale * move_by[1]];
                let found = residual(trial, goal);
                if size(found) < size(last) {
                    (x, last) = (trial, found);
                    break;
                }
                scale *= 0.5;
                if scale < 1e-6 {
                    // No descent: at round-off, or beyond the family.
                    converged = size(last) < 1e-8;
                    break;
                }
            }
            if scale < 1e-6 {
                break;
            }
        }
        if !converged {
            return None;
        }
    }
    Some((x[0], x[1].exp()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_have_the_moments_asked_for() {
        for (s, k) in [
            (0.0, 3.0),
            (0.0, 2.7),
            (-0.8, 4.0),
            (0.5, 3.2),
            (-1.5, 7.0),
            (0.0, 6.0),
            (1.0, 5.0),
            (-2.0, 10.0),
        ] {
            let g = Translation::try_new(s, k).unwrap();
            let moment = |n: i32| normal_nodes().map(|(y, w)| w * g.height(y).powi(n)).sum::<f64>();
            assert!(moment(1).abs() < 1e-10 && (moment(2) - 1.0).abs() < 1e-10, "{s} {k}");
            assert!(
                (moment(3) - s).abs() < 1e-7 && (moment(4) - k).abs() < 1e-6,
                "{s} {k}: {} {}",
                moment(3),
                moment(4)
            );
            for y in [-4.0, -0.3, 0.0, 2.0] {
                assert!((g.normal(g.height(y)) - y).abs() < 1e-9);
                assert!(g.height(y) < g.height(y + 1e-3));
            }
            for rho in [-0.2, 0.0, 0.3, 0.9, 0.99] {
                let back = g.normal_correlation(g.correlation(rho));
                assert!((back - rho).abs() < 1e-9, "{s} {k}: {rho} {back}");
            }
            assert!((g.correlation(1.0) - 1.0).abs() < 1e-9);
        }
        let gauss = Translation::try_new(0.0, 3.0).unwrap();
        assert!((gauss.mean_absolute() - (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-5);
        // The other half is as large.
        let skewed = Translation::try_new(-1.0, 5.0).unwrap();
        let below: f64 = (0..40_000)
            .map(|k| -12.0 + 6e-4 * f64::from(k) + 3e-4)
            .map(|y| 6e-4 * skewed.height(y).min(0.0) * (-0.5 * y * y).exp() / std::f64::consts::TAU.sqrt())
            .sum();
        assert!((skewed.mean_absolute() + 2.0 * below).abs() < 1e-5);
    }

    #[test]
    fn a_gaussian_surface_is_the_limit_and_no_special_case() {
        let near = Translation::try_new(1e-6, 3.0 - 1e-6).unwrap();
        for y in [-4.0, -1.0, 0.5, 3.0] {
            assert!((near.height(y) - y).abs() < 1e-4);
        }
    }

    #[test]
    fn impossible_moments_are_refused() {
        assert!(matches!(
            Translation::try_new(1.0, 2.0),
            Err(FinishError::Kurtosis { .. })
        ));
        assert!(matches!(
            Translation::try_new(0.0, -3.0),
            Err(FinishError::Kurtosis { .. })
        ));
        assert!(matches!(
            Translation::try_new(f64::NAN, 3.0),
            Err(FinishError::Value { .. })
        ));
        let error = Translation::try_new(0.0, 1.05).unwrap_err();
        assert!(matches!(error, FinishError::Translation { .. }), "{error:?}");
    }
}
