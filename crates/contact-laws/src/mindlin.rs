//! Tangential loading of one Hertz contact at constant normal force (Cattaneo 1938, Mindlin 1949; Johnson, *Contact
//! Mechanics*, 1985, sections 7.2 and 7.4): partial slip grows inwards from the contact's rim.

use crate::hertz::{self, ElasticPair};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// Tangential stiffness without slip `2 E a / ((2 - nu)(1 + nu))` (N/m) with the contact radius `a = sqrt(R w)`.
pub fn stiffness(material: &ElasticPair, radius: f64, interference: f64) -> f64 {
    material.mindlin_ratio() * hertz::stiffness(material, radius, interference)
}

/// Displacement `3 mu N / (2 k)` (m) at which the whole contact slips, from the slip limit `mu N` (N) and the stiffness
/// without slip `k` (N/m).
pub fn full_slip_displacement(slip_limit: f64, stiffness: f64) -> f64 {
    1.5 * slip_limit / stiffness
}

/// Tangential force (N) at first loading to `displacement` (m): `mu N (1 - (1 - x)^(3/2))`, `x = displacement /
/// full_slip_displacement`; odd in the displacement.
pub fn loading_force(slip_limit: f64, stiffness: f64, displacement: f64) -> f64 {
    let x = (displacement.abs() / full_slip_displacement(slip_limit, stiffness)).min(1.0);
    // 1 - (1 - x)^(3/2) without cancellation for small x.
    (-(1.5 * (-x).ln_1p()).exp_m1() * slip_limit).copysign(displacement)
}

/// Energy (J) dissipated in one cycle between `-amplitude` and `amplitude` (m) at constant normal force.
///
/// By Masing's rule `8 integral of T - 4 T_m amplitude` over first loading; with `x` as in [`loading_force`] and `d` the
/// full-slip displacement this is `mu N d (8 (x - (2/5)(1 - (1-x)^(5/2))) - 4 x (1 - (1-x)^(3/2)))` for `x <= 1` and
/// `mu N d (4 x - 16/5)` beyond.
pub fn loop_area(slip_limit: f64, stiffness: f64, amplitude: f64) -> f64 {
    let d = full_slip_displacement(slip_limit, stiffness);
    let x = amplitude.abs() / d;
    let shape = if x >= 1.0 {
        4.0 * x - 3.2
    } else if x > 0.1 {
        let y = 1.0 - x;
        8.0 * (x - 0.4 * (1.0 - y * y * y.sqrt())) - 4.0 * x * (1.0 - y * y.sqrt())
    } else {
        // The terms above cancel down to x^3/2. Series: T = sum t_k x^k with t_k = -(-1)^k binomial(3/2, k) gives
        // sum t_k x^(k+1) (8/(k+1) - 4).
        let (mut sum, mut term) = (0.0, 1.5 * x);
        for k in 2..20 {
            let k = f64::from(k);
            term *= -x * (2.5 - k) / k;
            sum += term * x * (8.0 / (k + 1.0) - 4.0);
        }
        sum
    };
    slip_limit * d * shape
}
