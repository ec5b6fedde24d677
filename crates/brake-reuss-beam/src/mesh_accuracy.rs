//! Errors of the beam's meshes against the limit of the mesh, as measured (`docs/accuracy.md`, "Mesh").

use joint_pipeline::joint::benchmark::{LimitWeight, MeshAccuracy, MeshError, RefinementLevel};
use substructure::elements::Formulation::{self, IncompatibleModes, Reduced};

/// Of the first mode.
pub(crate) const MESH_ACCURACY: MeshAccuracy = MeshAccuracy {
    mode: 1,
    errors: &[
        error(RefinementLevel::Quick, IncompatibleModes, 2.5e-2, 0.058),
        error(RefinementLevel::Quick, Reduced, 2.3e-2, 0.084),
        error(RefinementLevel::Coarse, IncompatibleModes, 1.9e-2, 0.044),
        error(RefinementLevel::Coarse, Reduced, 1.1e-2, 0.065),
        error(RefinementLevel::Default, IncompatibleModes, 1.4e-2, 0.028),
        error(RefinementLevel::Default, Reduced, 5.1e-3, 0.037),
        error(RefinementLevel::Fine, IncompatibleModes, 8.2e-3, 0.018),
        error(RefinementLevel::Fine, Reduced, 2.8e-3, 0.021),
        error(RefinementLevel::Finest, IncompatibleModes, 5.7e-3, 0.017),
        error(RefinementLevel::Finest, Reduced, 1.0e-3, 0.018),
    ],
    limits: &[
        limit(RefinementLevel::Quick, 0.54, 0.07),
        limit(RefinementLevel::Coarse, 0.68, 0.08),
        limit(RefinementLevel::Default, 0.77, 0.07),
        limit(RefinementLevel::Fine, 0.79, 0.07),
        limit(RefinementLevel::Finest, 0.93, 0.06),
    ],
    source: "measured for the first mode of the Brake-Reuss beam against the extrapolated limit of its block mesh, flat and with \
             the measured gap, mu 0.2, 12.845 kN, frequencies up to 0.6 mm, damping at 0.2 and 0.6 mm (at the onset of slip it is \
             less certain, see Mesh in docs/accuracy.md)",
};

/// Relative uncertainty of the limit of the first frequency.
const LIMIT_UNCERTAINTY: f64 = 6e-4;

const fn error(refinement: RefinementLevel, hexahedra: Formulation, frequency: f64, damping: f64) -> MeshError {
    MeshError {
        refinement,
        hexahedra,
        frequency,
        damping,
    }
}

const fn limit(refinement: RefinementLevel, weight: f64, spread: f64) -> LimitWeight {
    LimitWeight {
        refinement,
        weight,
        spread,
        limit_uncertainty: LIMIT_UNCERTAINTY,
    }
}
