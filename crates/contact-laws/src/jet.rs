//! Values of functions of the interference with their derivatives.

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
}
