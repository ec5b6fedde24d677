//! Linear isotropic elastic materials.

use crate::Error;

/// Linear isotropic elastic material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name used in messages.
    pub name: String,
    /// Young's modulus (Pa).
    pub youngs_modulus: f64,
    /// Poisson ratio (-).
    pub poisson_ratio: f64,
    /// Mass density (kg/m^3).
    pub density: f64,
}

impl Material {
    /// Lame's constants `[lambda, mu]` (Pa).
    pub(crate) fn lame(&self) -> [f64; 2] {
        let (e, nu) = (self.youngs_modulus, self.poisson_ratio);
        [e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), 0.5 * e / (1.0 + nu)]
    }

    /// Checks the constants.
    ///
    /// # Errors
    /// [`Error::Material`] naming the constant.
    pub fn validate(&self) -> Result<(), Error> {
        let fail = |field, value, unit, requirement| {
            Err(Error::Material {
                material: self.name.clone(),
                field,
                value,
                unit,
                requirement,
            })
        };
        if !(self.youngs_modulus.is_finite() && self.youngs_modulus > 0.0) {
            return fail("youngs_modulus", self.youngs_modulus, "Pa", "positive and finite");
        }
        if !(self.poisson_ratio > -1.0 && self.poisson_ratio < 0.5) {
            return fail(
                "poisson_ratio",
                self.poisson_ratio,
                "",
                "between -1 and 0.5 (both excluded)",
            );
        }
        if !(self.density.is_finite() && self.density > 0.0) {
            return fail("density", self.density, "kg/m^3", "positive and finite");
        }
        Ok(())
    }
}
