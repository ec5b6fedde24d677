//! Values of functions of the interference with their derivatives.

#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use core::ops::{Add, Mul, Sub};

/// A function's value and its first two derivatives with respect to the interference.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jet {
    /// Value, in the function's own unit.
    pub value: f64,
    /// First derivative (unit/m).
    pub slope: f64,
    /// Second derivative (unit/m^2).
    pub curvature: f64,
}

impl Jet {
    /// From the log-slope `g = d ln f / d ln u` and its change `d g / d ln u` at `u > 0`.
    #[inline]
    pub(crate) fn from_log(u: f64, value: f64, log_slope: f64, log_slope_change: f64) -> Self {
        // Divided by u twice: u^2 would underflow first. Kept finite: a log-slope of zero must give zero.
        let per_u = (value / u).min(f64::MAX);
        let per_u2 = (per_u / u).min(f64::MAX);
        Self {
            value,
            slope: per_u * log_slope,
            curvature: per_u2 * (log_slope * log_slope - log_slope + log_slope_change),
        }
    }

    /// The variable itself.
    pub(crate) fn variable(value: f64) -> Self {
        Self {
            value,
            slope: 1.0,
            curvature: 0.0,
        }
    }

    /// A value that changes along a direction; the curvature of what is made of it means nothing.
    pub(crate) fn along(value: f64, change: f64) -> Self {
        Self {
            value,
            slope: change,
            curvature: 0.0,
        }
    }

    pub(crate) fn constant(value: f64) -> Self {
        Self {
            value,
            ..Self::default()
        }
    }

    /// `f(self)` from `f` and its first two derivatives.
    fn apply(self, [value, slope, curvature]: [f64; 3]) -> Self {
        Self {
            value,
            slope: slope * self.slope,
            curvature: curvature * self.slope * self.slope + slope * self.curvature,
        }
    }

    pub(crate) fn exp(self) -> Self {
        self.apply([self.value.exp(); 3])
    }

    pub(crate) fn ln(self) -> Self {
        let x = self.value;
        self.apply([x.ln(), 1.0 / x, -1.0 / (x * x)])
    }

    pub(crate) fn cos(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.apply([cos, -sin, -cos])
    }

    pub(crate) fn power(self, p: f64) -> Self {
        let x = self.value;
        let value = match p {
            0.5 => x.sqrt(),
            1.5 => x * x.sqrt(),
            _ => x.powf(p),
        };
        self.apply([value, p * value / x, p * (p - 1.0) * value / x / x])
    }

    /// Constant beyond a bound.
    pub(crate) fn at_most(self, bound: f64) -> Self {
        if self.value > bound {
            Self::constant(bound)
        } else {
            self
        }
    }
}

impl Add for Jet {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            slope: self.slope + other.slope,
            curvature: self.curvature + other.curvature,
        }
    }
}

impl Sub for Jet {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl Mul<f64> for Jet {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            slope: self.slope * factor,
            curvature: self.curvature * factor,
        }
    }
}

impl Mul for Jet {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            slope: self.slope * other.value + self.value * other.slope,
            curvature: self.curvature * other.value + 2.0 * self.slope * other.slope + self.value * other.curvature,
        }
    }
}
