//! Tangential loading of one Hertz contact at constant normal force: partial slip grows inwards from the contact's rim.
//!
//! With the slip limit `mu N`, the stiffness without slip `k` and the displacement `d` at which the whole contact
//! slips, the force at first loading to the displacement `u` is
//! <div>
//! $$ T = \mu N \left( 1 - (1 - x)^{3/2} \right), \qquad x = \min\left( \frac{u}{d}, 1 \right), \qquad
//! d = \frac{3 \mu N}{2 k}, \qquad k = \frac{2 E a}{(2 - \nu)(1 + \nu)}, \qquad a = \sqrt{R w} . $$
//! </div>
//!
//! Unloading and reloading follow by Masing's rule. A cycle between `-u` and `u` dissipates, with `x = u/d`,
//! <div>
//! $$ D = \mu N d \begin{cases}
//! 8 \left( x - \tfrac{2}{5} \left( 1 - (1 - x)^{5/2} \right) \right) - 4 x \left( 1 - (1 - x)^{3/2} \right)
//! & x \le 1 \\
//! 4 x - \tfrac{16}{5} & x > 1
//! \end{cases} $$
//! </div>
//!
//! which begins as `x^3/2`: the third power of the amplitude, as measured on joints in partial slip.
//!
//! # Parameters
//! | parameter | unit |
//! |---|---|
//! | slip limit `mu N` | N |
//! | stiffness without slip `k` | N/m |
//! | displacement `u` | m |
//! | Young's modulus `E`, Poisson's ratio `nu` | Pa, 1 |
//! | effective radius `R`, interference `w` | m |
//!
//! The functions check nothing. [`FoundationLaw`](crate::FoundationLaw) follows this curve at points.
//!
//! Source: C. Cattaneo, *Sul contatto di due corpi elastici: distribuzione locale degli sforzi*, Rend. Accad. Naz.
//! Lincei 27, 1938; R. D. Mindlin, *Compliance of elastic bodies in contact*, J. Appl. Mech. 16, 1949; K. L. Johnson,
//! *Contact Mechanics*, 1985, sections 7.2 and 7.4.
//!
//! # Example
//! ```
//! use contact_laws::{ElasticPair, hertz, mindlin};
//!
//! let steel = ElasticPair::new(192.85e9, 0.29);
//! let (radius, w) = (1.4e-3, 1e-7);
//! let limit = 0.2 * hertz::force(&steel, radius, w);
//! let k = mindlin::stiffness(&steel, radius, w);
//! let d = mindlin::full_slip_displacement(limit, k);
//! assert!((mindlin::loading_force(limit, k, 0.5 * d) / limit - (1.0 - 0.5_f64.powf(1.5))).abs() < 1e-12);
//! // Small cycles dissipate as the cube of the amplitude.
//! let area = |x: f64| mindlin::loop_area(limit, k, x * d);
//! assert!((area(2e-3) / area(1e-3) / 8.0 - 1.0).abs() < 1e-3);
//! ```
#![doc = include_str!("../../katex.html")]

#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::physics::hertz::{self, ElasticPair};

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
/// By Masing's rule `8 integral of T - 4 T_m amplitude` over first loading; closed form in the [module](self).
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
