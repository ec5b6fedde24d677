//! Does adhesion matter, and where does yield begin (eq. 45)? Both compare an interference with the critical one of an
//! asperity. Source of the critical interference: Chang, Etsion and Bogy, 1987.

use crate::hertz::ElasticPair;

/// Hardness coefficient `K = 0.454 + 0.41 nu`.
pub fn hardness_coefficient(poisson_ratio: f64) -> f64 {
    0.454 + 0.41 * poisson_ratio
}

/// Critical interference `omega_c = (pi K H / (2 E*))^2 R` (m) at which an asperity begins to yield, from the hardness
/// `H` (Pa) and the effective radius `R` (m).
pub fn critical_interference(material: &ElasticPair, hardness: f64, radius: f64) -> f64 {
    let k = hardness_coefficient(material.poisson_ratio);
    let strain = core::f64::consts::PI * k * hardness / (2.0 * material.composite_modulus());
    strain * strain * radius
}
