//! Shares of the annuli of a contact circle in its stiffness and its slip limit.
//!
//! Under constant normal force a Hertz contact slips from its rim inwards; its first loading is (Cattaneo 1938, Mindlin 1949; [`crate::mindlin`])
//! <div>
//! $$ t = \mu t_n \left(1 - (1 - x)^{3/2}\right), \qquad x = \frac{|u_t|}{d}, \qquad d = \frac{3 \mu t_n}{2 k_t} $$
//! </div>
//!
//! and unloading and reloading follow by Masing's rule. Elastic, perfectly plastic sliders in parallel (Iwan 1966) obey that rule by
//! construction, and they follow this curve when the share `dp` of the stiffness yields at `x(p) = 2 p - p^2`, `p` from 0 to 1. `N` sliders
//! divide `p` at `p_0 = 0 < p_1 < ... < p_N = 1`, and each takes over the stiffness and the slip limit of its part,
//! <div>
//! $$ w_i = p_i - p_{i-1}, \qquad
//!    s_i = \frac{3}{2} \int_{p_{i-1}}^{p_i} x(p)\, dp
//!        = \left[\tfrac{3}{2} p^2 - \tfrac{1}{2} p^3\right]_{p_{i-1}}^{p_i},
//!    \qquad \sum_i w_i = \sum_i s_i = 1, $$
//! </div>
//!
//! so that the stiffness of small displacements is exactly `k_t` and gross slip carries exactly `mu t_n`, whatever `N`: the loading curve is a
//! polygon of tangents to the exact one.
//!
//! # How many
//! The limits are graded, `p_j = (exp(6 j/N) - 1)/(exp(6) - 1)`: among power laws and exponentials in `p` and in `x`, measured for 2 to 64 sliders,
//! this one or one next to it has the smallest largest error of the loop area over amplitudes `x` from 0.01 to 2. The errors below are the largest
//! over the range: of the loading curve relative to `mu t_n`, of the loop area relative to the closed form. Below `x_1`, where the first slider
//! slips, nothing dissipates.
//!
//! | `N` | `x_1` | loading curve | loop area, `x` in 0.1..2 | loop area, `x` in 0.01..2 |
//! |---|---|---|---|---|
//! | 1 | 0.67 | 0.19 | 1 | 1 |
//! | 2 | 0.047 | 0.17 | 0.96 | 1 |
//! | 4 | 0.0086 | 0.091 | 0.68 | 0.78 |
//! | 8 | 0.0028 | 0.028 | 0.28 | 0.46 |
//! | 16 | 0.0011 | 0.0073 | 0.078 | 0.13 |
//! | 32 | 0.00051 | 0.0019 | 0.021 | 0.036 |
//!
//! Sources: R. D. Mindlin, *Compliance of elastic bodies in contact*, J. Appl. Mech. 16 (1949) 259-268; W. D. Iwan, *A distributed-element model
//! for hysteresis and its steady-state dynamic response*, J. Appl. Mech. 33 (1966) 893-900.

#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::{Bounds, Parameter};
use alloc::vec::Vec;

/// Most annuli of an asperity.
pub const MAX_ANNULI: usize = 256;

pub(super) const N_ANNULI: Parameter =
    Parameter::new("annuli", "1", Bounds::Within([1.0, MAX_ANNULI as f64], "from 1 to 256"));

/// Exponent of the grading, see the [module](self).
const GRADING: f64 = 6.0;

/// Shares of the slip limit and of the stiffness of `n` annuli.
pub(super) fn shares(n: usize) -> Vec<[f64; 2]> {
    let node = |j: usize| (GRADING * j as f64 / n as f64).exp_m1() / GRADING.exp_m1();
    // The last one takes what is left of 1, so that the sums, taken in this order, are 1 to the last bit.
    let (mut stiffness_sum, mut limit_sum) = (0.0, 0.0);
    (1..=n)
        .map(|j| {
            let (a, b) = (node(j - 1), node(j));
            let (stiffness, limit) = if j < n {
                let stiffness = b - a;
                (stiffness, stiffness * (1.5 * (a + b) - 0.5 * (a * a + a * b + b * b)))
            } else {
                (1.0 - stiffness_sum, 1.0 - limit_sum)
            };
            stiffness_sum += stiffness;
            limit_sum += limit;
            [limit, stiffness]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::shares;
    use crate::mindlin;

    /// The table of the module's page.
    const DOCUMENTED: [(usize, [f64; 4]); 6] = [
        (1, [0.67, 0.19, 1.0, 1.0]),
        (2, [0.047, 0.17, 0.96, 1.0]),
        (4, [0.0086, 0.091, 0.68, 0.78]),
        (8, [0.0028, 0.028, 0.28, 0.46]),
        (16, [0.0011, 0.0073, 0.078, 0.13]),
        (32, [0.00051, 0.0019, 0.021, 0.036]),
    ];

    #[test]
    fn errors_against_the_closed_forms() {
        // A limit of 1 and a stiffness of 3/2, so that all slips at a displacement of 1.
        for (n, documented) in DOCUMENTED {
            let shares = shares(n);
            let sum = |q: usize| shares.iter().map(|share| share[q]).sum::<f64>();
            assert_eq!([sum(0), sum(1)], [1.0; 2]);
            let force = |x: f64| shares.iter().map(|[s, w]| (1.5 * w * x).min(*s)).sum::<f64>();
            let first = shares.iter().map(|[s, w]| s / (1.5 * w)).fold(f64::INFINITY, f64::min);
            let loading = (0..=1500).map(|i| f64::from(i) / 1000.0);
            let loading = loading
                .map(|x| force(x) - mindlin::loading_force(1.0, 1.5, x))
                .fold(0.0, f64::max);
            // An elastic, perfectly plastic slider takes 4 s (x - s/(1.5 w)) of a cycle.
            let area = |x: f64| {
                let of_each = shares.iter().map(|[s, w]| 4.0 * s * (x - s / (1.5 * w)).max(0.0));
                (of_each.sum::<f64>() / mindlin::loop_area(1.0, 1.5, x) - 1.0).abs()
            };
            let worst = |from: f64, to: f64| {
                let at = |i: u32| from * (to / from).powf(f64::from(i) / 400.0);
                (0..=400).map(|i| area(at(i))).fold(0.0, f64::max)
            };
            let large = worst(0.1, 2.0);
            let found = [first, loading, large, large.max(worst(0.01, 0.1))];
            println!("{n}: {}", found.map(|v| format!("{v:.1e}")).join("  "));
            for (found, documented) in found.iter().zip(documented) {
                assert!((found / documented - 1.0).abs() < 0.06, "{n} {found:e} {documented:e}");
            }
        }
    }
}
