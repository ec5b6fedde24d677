//! The elastic material of bodies and asperities.

use super::units::{Density, Stress, SurfaceEnergy};
use serde::{Deserialize, Serialize};

/// Elastic material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus (force/length^2).
    pub youngs_modulus: Stress,
    /// Poisson ratio (-), above -1 and below 0.5.
    pub poisson_ratio: f64,
    /// Density (mass/length^3); needed where the bodies have this material.
    #[serde(default)]
    pub density: Option<Density>,
    /// Hardness (force/length^2), for the onset of yield, which is not judged without it.
    #[serde(default)]
    pub hardness: Option<Stress>,
    /// Work of adhesion of the material on itself (energy/length^2), for the share of adhesion in the contact, which is not
    /// judged without it.
    #[serde(default)]
    pub work_of_adhesion: Option<SurfaceEnergy>,
}
