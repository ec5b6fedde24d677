//! The scene's material as bodies have it.

use crate::Error;
use finite_elements::mesh::Material;
use scenes::{Density, Model};

/// The material of the bodies; scenes whose bodies have another need not know its density.
///
/// # Errors
/// [`scenes::Error::NoMaterial`].
pub(super) fn material(model: &Model) -> Result<Material, Error> {
    let material = model.material()?;
    Ok(Material {
        name: "scene".into(),
        youngs_modulus: material.youngs_modulus.si(),
        poisson_ratio: material.poisson_ratio,
        density: material.density.map_or(f64::NAN, Density::si),
    })
}
