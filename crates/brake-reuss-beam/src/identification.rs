//! Young's modulus and density from a weighed and tapped half-beam (section 4.1 of the method paper).

use crate::geometry::Geometry;
use crate::mesh::{Refinement, half_beam};
use crate::{Error, Result};
use finite_elements::assemble::System;
use finite_elements::eigen::lowest_modes;
use finite_elements::mesh::{Assembly, Material};

/// Residual of the modes; the error of their frequencies is of the order of its square.
const TOLERANCE: f64 = 1e-6;

/// The material of which a free half-beam has this mass (kg) and this first flexible frequency (Hz): the volume of the
/// mesh gives the density, and frequencies grow as `sqrt(E / rho)`.
///
/// # Errors
/// A mass or frequency that is not positive and finite; those of the mesher and the finite elements.
pub fn material_of_half_beam(
    geometry: &Geometry,
    refinement: &Refinement,
    poisson_ratio: f64,
    mass: f64,
    frequency: f64,
) -> Result<Material> {
    for (field, value, unit) in [("mass", mass, "kg"), ("frequency", frequency, "Hz")] {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::Value {
                place: "half-beam",
                field,
                value,
                unit,
                requirement: "positive and finite",
            });
        }
    }
    let trial = Material {
        name: "half-beam".to_owned(),
        youngs_modulus: 200e9,
        poisson_ratio,
        density: 8000.0,
    };
    let assembly = Assembly {
        mesh: half_beam(geometry, refinement, &trial)?,
        ..Assembly::default()
    };
    let system = System::try_new(&assembly)?;
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, 1, TOLERANCE)?;
    let density = trial.density * mass / system.total_mass;
    let ratio = modes.frequencies().first().map_or(f64::NAN, |first| frequency / first);
    Ok(Material {
        youngs_modulus: trial.youngs_modulus * density / trial.density * ratio * ratio,
        density,
        ..trial
    })
}
