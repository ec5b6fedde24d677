//! Numbers cut to ranges, without branches.

use super::elementary::{max, min};

/// Cuts a number to `-bound..=bound`; what is no number becomes the bound.
#[inline(always)]
pub(crate) fn within(value: f64, bound: f64) -> f64 {
    max(min(value, bound), -bound)
}

/// Cuts a number so that the product of two such numbers is finite.
#[inline(always)]
pub(crate) fn bounded(value: f64) -> f64 {
    within(value, 1e150)
}

/// Whether all numbers are finite.
#[inline(always)]
pub(crate) fn is_finite<const N: usize>(values: [f64; N]) -> bool {
    let mut sum = 0.0;
    for value in values {
        sum += value * 0.0;
    }
    sum == 0.0
}
