//! Hertz contact of one asperity pair: two elastic bodies of equal material, pressed together by the interference `w`.
//!
//! With the effective radius `R` of the pair, `1/R = 1/R_1 + 1/R_2`, the normal force, its stiffness and the radius of
//! the contact circle are
//! <div>
//! $$ N = \frac{4}{3} E^* \sqrt{R} \, w^{3/2}, \qquad \frac{\mathrm{d} N}{\mathrm{d} w} = 2 E^* a, \qquad
//! a = \sqrt{R w}, \qquad E^* = \frac{E}{2 (1 - \nu^2)} . $$
//! </div>
//!
//! All are zero for `w <= 0`.
//!
//! # Parameters
//! | parameter | unit | bounds |
//! |---|---|---|
//! | Young's modulus `E` | Pa | above 0 |
//! | Poisson's ratio `nu` | 1 | above -1, at most 1/2 |
//! | effective radius `R` | m | above 0 |
//! | interference `w` | m | |
//!
//! The functions check nothing; [`ElasticPair::validate`] does, and the laws made from it call it.
//!
//! Source: K. L. Johnson, *Contact Mechanics*, 1985, section 4.2; eq. (8) of the method paper, whose exponent 2/3 is a
//! misprint for 3/2.
//!
//! # Example
//! ```
//! use contact_laws::{ElasticPair, hertz};
//!
//! let steel = ElasticPair::new(192.85e9, 0.29);
//! // Radius 1.4 mm, pressed in by 0.1 um.
//! let (n, k, a) = (
//!     hertz::force(&steel, 1.4e-3, 1e-7),
//!     hertz::stiffness(&steel, 1.4e-3, 1e-7),
//!     hertz::contact_radius(1.4e-3, 1e-7),
//! );
//! println!("{n:.4} N, {k:.3e} N/m, {a:.3e} m");
//! // N = (2/3) w dN/dw.
//! assert!((n / (2.0 / 3.0 * 1e-7 * k) - 1.0).abs() < 1e-12);
//! ```
#![doc = include_str!("../../katex.html")]

use crate::error::Error;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::{Bounds, Parameter};

pub(crate) const YOUNGS_MODULUS: Parameter = Parameter::new("youngs_modulus", "Pa", Bounds::Positive);
pub(crate) const POISSON_RATIO: Parameter = Parameter::new(
    "poisson_ratio",
    "1",
    Bounds::Within([(-1.0_f64).next_up(), 0.5], "above -1 and at most 0.5"),
);

/// The material of two equal elastic bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct ElasticPair {
    /// Young's modulus E (Pa).
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
}

impl ElasticPair {
    /// From Young's modulus (Pa) and Poisson's ratio, not yet checked.
    pub fn new(youngs_modulus: f64, poisson_ratio: f64) -> Self {
        Self {
            youngs_modulus,
            poisson_ratio,
        }
    }

    /// Checks `E > 0` and `-1 < nu <= 1/2`.
    ///
    /// # Errors
    /// [`Error::Parameter`] with the value.
    pub fn validate(&self) -> Result<(), Error> {
        YOUNGS_MODULUS.check(self.youngs_modulus)?;
        POISSON_RATIO.check(self.poisson_ratio)
    }

    /// Composite modulus `E* = E / (2 (1 - nu^2))` (Pa).
    pub fn composite_modulus(&self) -> f64 {
        self.youngs_modulus / (2.0 * (1.0 - self.poisson_ratio.powi(2)))
    }

    /// Mindlin's modulus `2 E / ((2 - nu)(1 + nu))` (Pa): the tangential stiffness of a contact over its radius.
    pub(crate) fn mindlin_modulus(&self) -> f64 {
        2.0 * self.youngs_modulus / ((2.0 - self.poisson_ratio) * (1.0 + self.poisson_ratio))
    }

    /// `k_t / (dN/dw) = 2 (1 - nu)/(2 - nu)`, Mindlin's ratio of the tangential to the normal stiffness.
    pub fn mindlin_ratio(&self) -> f64 {
        2.0 * (1.0 - self.poisson_ratio) / (2.0 - self.poisson_ratio)
    }
}

/// Normal force `(2/3) E/(1-nu^2) sqrt(R) w^(3/2)` (N); zero for `w <= 0`.
pub fn force(material: &ElasticPair, radius: f64, interference: f64) -> f64 {
    let w = interference.max(0.0);
    4.0 / 3.0 * material.composite_modulus() * radius.sqrt() * w * w.sqrt()
}

/// Normal stiffness `dN/dw = E/(1-nu^2) sqrt(R w)` (N/m).
pub fn stiffness(material: &ElasticPair, radius: f64, interference: f64) -> f64 {
    2.0 * material.composite_modulus() * contact_radius(radius, interference)
}

/// Radius of the contact circle `sqrt(R w)` (m).
pub fn contact_radius(radius: f64, interference: f64) -> f64 {
    (radius * interference.max(0.0)).sqrt()
}
