//! Hertz contact of one asperity pair: two elastic bodies of equal material with the effective radius `R` of the pair,
//! `1/R = 1/R_1 + 1/R_2`, pressed together by the interference `w`. Source: K. L. Johnson, *Contact Mechanics*, 1985,
//! section 4.2; eq. (8) of the method paper, whose exponent 2/3 is a misprint for 3/2.

use crate::error::{Error, Place, require, require_positive};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

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
        require_positive("youngs_modulus", self.youngs_modulus, "Pa")?;
        let nu = self.poisson_ratio;
        require(
            nu > -1.0 && nu <= 0.5,
            "poisson_ratio",
            nu,
            "(no unit)",
            Place::Whole,
            "above -1 and at most 0.5",
        )
    }

    /// Composite modulus `E* = E / (2 (1 - nu^2))` (Pa).
    pub fn composite_modulus(&self) -> f64 {
        self.youngs_modulus / (2.0 * (1.0 - self.poisson_ratio.powi(2)))
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
