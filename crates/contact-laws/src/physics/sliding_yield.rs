//! First yield of a sphere in full sliding; [`slip_limit`](crate::slip_limit) has equations and sources.

#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// `C_f` of the limit [`AsperityLimit::Ceb`](crate::AsperityLimit::Ceb).
pub(crate) fn ceb_factor(poisson_ratio: f64) -> f64 {
    let around = |zeta: f64| zeta * (1.0 / zeta).atan();
    let difference = |zeta: f64| 1.5 / (1.0 + zeta * zeta) - (1.0 + poisson_ratio) * (1.0 - around(zeta));
    // One maximum, at 0.38 to 0.55: the golden section keeps it between the ends.
    let (mut low, mut high) = (0.2, 0.8);
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..60 {
        let (left, right) = (high - golden * (high - low), low + golden * (high - low));
        if difference(left) > difference(right) {
            high = right;
        } else {
            low = left;
        }
    }
    let zeta = 0.5 * (low + high);
    let shear = 1.0 - 1.5 * around(zeta) + 0.5 * zeta * zeta / (1.0 + zeta * zeta);
    difference(zeta) / (3.0_f64.sqrt() * shear)
}
