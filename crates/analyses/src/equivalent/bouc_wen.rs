//! The Bouc-Wen element: Bouc (1967); Wen, "Method for random vibration of hysteretic systems", Journal of the Engineering Mechanics Division 102
//! (1976) 249-263.

use super::fit::{Columns, Family, Stiffnesses};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;
use std::sync::LazyLock;

/// `F = alpha k u + (1 - alpha) k z` with `dz/dt = du/dt (1 - |z/z_y|^n)` where `z du > 0`, and `dz/dt = du/dt` elsewhere: in Wen's equation `A = 1`
/// and `beta = gamma = 1 / (2 z_y^n)`, so that unloading begins with the initial stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoucWen {
    /// `k`: stiffness at small displacements.
    pub stiffness: f64,
    /// `alpha`: stiffness at large displacements over `k`.
    pub alpha: f64,
    /// `z_y`: largest hysteretic displacement.
    pub yield_displacement: f64,
    /// `n`: at small amplitudes dissipation grows with the power `n + 2`.
    pub n: f64,
}

/// Beyond this, `1 - e^-v` is one to the last digit.
const SATURATED: f64 = 40.0;

/// Shares of the way and weights of the double exponential rule of Takahasi and Mori (1974), which bears a power at either end.
static NODES: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| {
    const STEP: f64 = 1.0 / 16.0;
    let node = |k: i32| {
        let t = STEP * f64::from(k);
        let s = FRAC_PI_2 * t.sinh();
        // The distance from zero without cancellation.
        [
            1.0 / (1.0 + (-2.0 * s).exp()),
            0.5 * STEP * FRAC_PI_2 * t.cosh() / s.cosh().powi(2),
        ]
    };
    (-52..=52).map(node).collect()
});

/// Integral of `(1 - e^-v)^p` from zero to `end`.
fn integral(p: f64, end: f64) -> f64 {
    let bent = end.min(SATURATED);
    let terms = NODES
        .iter()
        .map(|[share, weight]| weight * (-(-bent * share).exp_m1()).powf(p));
    bent * terms.sum::<f64>() + (end - bent)
}

impl Family for BoucWen {
    const CHOICES: &'static [[bool; 3]] = &[[true, false, false], [true, true, false]];

    /// With `y` the largest `z` of the steady loop over `z_y`, and `y^n = 1 - e^-V`, the way from zero force to the reversal and half the way back give
    /// `u/z_y = y + I_1/2` and `D = 2 k z_y^2 I_2`, where `I_m = 1/n` times the integral of `(1 - e^-v)^(m/n)` from zero to `V`. A spring `alpha k`
    /// stands beside it.
    fn columns(u: f64, [largest, n]: [f64; 2]) -> Columns {
        let x = u / largest;
        let y = |v: f64| (-(-v).exp_m1()).powf(1.0 / n);
        // By Newton's steps in the logarithm of V, in which the way grows steadily; it begins where y would be x, or above.
        let way = |v: f64| y(v) + 0.5 * integral(1.0 / n, v) / n;
        let slope = |v: f64| y(v) / n * ((-v).exp() / -(-v).exp_m1() + 0.5);
        let mut v = if x < 0.5 {
            -(-x.powf(n)).ln_1p()
        } else {
            (2.0 * n * x).max(1.0)
        };
        for _ in 0..60 {
            let step = (way(v) - x) / (v * slope(v));
            v *= (-step.clamp(-2.0, 2.0)).exp();
            if step.abs() < 1e-14 {
                break;
            }
        }
        Columns {
            stiffness: [y(v) / x, 1.0, 0.0],
            dissipation: [2.0 * largest.powi(2) * integral(2.0 / n, v) / n, 0.0, 0.0],
        }
    }

    fn of([largest, n]: [f64; 2], [hysteretic, spring, _]: Stiffnesses) -> Self {
        Self {
            stiffness: hysteretic + spring,
            alpha: spring / (hysteretic + spring),
            yield_displacement: largest,
            n,
        }
    }

    fn apart(&self) -> ([f64; 2], Stiffnesses) {
        let spring = self.alpha * self.stiffness;
        (
            [self.yield_displacement, self.n],
            [self.stiffness - spring, spring, 0.0],
        )
    }
}
