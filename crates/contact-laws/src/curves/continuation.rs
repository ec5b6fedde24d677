//! How a curve goes on beyond the range in which it is known: C1, positive, and with a stated limit.

use crate::jet::Jet;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// The end of a known range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct End {
    /// Interference (m).
    pub(crate) u: f64,
    /// Value there; a curve that ends in zero goes on as zero.
    pub(crate) value: f64,
    /// `d ln f / d ln u` there.
    pub(crate) log_slope: f64,
}

impl End {
    /// An end where a curve has the given value and slope.
    pub(crate) fn new(u: f64, value: f64, slope: f64) -> Self {
        let log_slope = if value > 0.0 { slope * u / value } else { 0.0 };
        Self { u, value, log_slope }
    }

    /// The end of the curve `value * f(u / interference)`.
    pub(crate) fn scaled(self, interference: f64, value: f64) -> Self {
        Self {
            u: self.u * interference,
            value: self.value * value,
            ..self
        }
    }

    /// Below the range: with `v = u / u_end`, the log-slope moves linearly in `v` from its end value to `exponent`,
    /// so `f = f_end v^exponent exp((log_slope - exponent) (v - 1))`.
    #[inline]
    pub(crate) fn below(&self, u: f64, exponent: f64) -> Jet {
        let v = u / self.u;
        let change = (self.log_slope - exponent) * v;
        let value = self.value * v.powf(exponent) * ((self.log_slope - exponent) * (v - 1.0)).exp();
        Jet::from_log(u, value, exponent + change, change)
    }

    /// Above the range with the end's log-slope.
    #[inline]
    pub(crate) fn above(&self, u: f64) -> Jet {
        Jet::from_log(u, self.value * (u / self.u).powf(self.log_slope), self.log_slope, 0.0)
    }

    /// Above the range towards a constant: the log-slope falls as `1/v`, so `f = f_end exp(log_slope (1 - 1/v))`.
    #[inline]
    pub(crate) fn above_to_constant(&self, u: f64) -> Jet {
        let g = self.log_slope * self.u / u;
        Jet::from_log(u, self.value * (self.log_slope - g).exp(), g, -g)
    }
}
