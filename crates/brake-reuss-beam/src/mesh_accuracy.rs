//! Errors of the beam's meshes against the limit of the mesh, as measured (`docs/validation.md`, "Mesh").

use finite_elements::elements::Formulation::{self, Full, IncompatibleModes, Reduced};
use joint_model::benchmark::{ElementOrder, LimitWeight, MeshAccuracy, MeshError, RefinementLevel};

/// Of the first mode.
pub(crate) const MESH_ACCURACY: MeshAccuracy = MeshAccuracy {
    mode: 1,
    errors: &[
        linear(RefinementLevel::Quick, IncompatibleModes, 2.6e-2, 0.084),
        linear(RefinementLevel::Quick, Reduced, 2.4e-2, 0.083),
        linear(RefinementLevel::Coarse, IncompatibleModes, 1.9e-2, 0.067),
        linear(RefinementLevel::Coarse, Reduced, 1.1e-2, 0.064),
        linear(RefinementLevel::Default, IncompatibleModes, 1.4e-2, 0.047),
        linear(RefinementLevel::Default, Reduced, 5.2e-3, 0.036),
        linear(RefinementLevel::Fine, IncompatibleModes, 8.1e-3, 0.019),
        linear(RefinementLevel::Fine, Reduced, 3.0e-3, 0.018),
        linear(RefinementLevel::Finest, IncompatibleModes, 5.5e-3, 0.013),
        linear(RefinementLevel::Finest, Reduced, 1.1e-3, 0.013),
        quadratic(RefinementLevel::Quick, Full, 8.9e-3, 0.010),
        quadratic(RefinementLevel::Quick, Reduced, 4.9e-3, 0.029),
        quadratic(RefinementLevel::Coarse, Full, 5.4e-3, 0.016),
        quadratic(RefinementLevel::Coarse, Reduced, 2.6e-3, 0.0089),
        quadratic(RefinementLevel::Default, Full, 4.7e-3, 0.014),
        quadratic(RefinementLevel::Default, Reduced, 1.5e-3, 0.021),
        quadratic(RefinementLevel::Fine, Reduced, 1.0e-3, 0.0045),
    ],
    limits: &[
        limit(ElementOrder::Linear, RefinementLevel::Quick, 0.54, 0.07),
        limit(ElementOrder::Linear, RefinementLevel::Coarse, 0.67, 0.08),
        limit(ElementOrder::Linear, RefinementLevel::Default, 0.77, 0.07),
        limit(ElementOrder::Linear, RefinementLevel::Fine, 0.78, 0.07),
        limit(ElementOrder::Linear, RefinementLevel::Finest, 0.91, 0.07),
        limit(ElementOrder::Quadratic, RefinementLevel::Quick, 2.18, 0.37),
        limit(ElementOrder::Quadratic, RefinementLevel::Coarse, 1.73, 0.26),
        limit(ElementOrder::Quadratic, RefinementLevel::Default, 1.27, 0.13),
    ],
    source: "measured for the first mode of the Brake-Reuss beam against the extrapolated limit of its block mesh, flat and with \
             the measured gap, mu 0.2, 12.845 kN, frequencies up to 0.6 mm, damping at 0.2 and 0.6 mm; C3D8I and C3D20R from quick to \
             default also with mu 0.1 to 0.6 and 6 to 16 kN, where the damping ratio is above 0.5 % (at the onset of slip \
             damping is less certain, see Mesh in docs/validation.md)",
};

/// Relative uncertainty of the limit of the first frequency.
const LIMIT_UNCERTAINTY: f64 = 3e-4;

const fn linear(refinement: RefinementLevel, hexahedra: Formulation, frequency: f64, damping: f64) -> MeshError {
    error(ElementOrder::Linear, refinement, hexahedra, frequency, damping)
}

const fn quadratic(refinement: RefinementLevel, hexahedra: Formulation, frequency: f64, damping: f64) -> MeshError {
    error(ElementOrder::Quadratic, refinement, hexahedra, frequency, damping)
}

const fn error(
    element_order: ElementOrder,
    refinement: RefinementLevel,
    hexahedra: Formulation,
    frequency: f64,
    damping: f64,
) -> MeshError {
    MeshError {
        element_order,
        refinement,
        hexahedra,
        frequency,
        damping,
    }
}

const fn limit(element_order: ElementOrder, refinement: RefinementLevel, weight: f64, spread: f64) -> LimitWeight {
    LimitWeight {
        element_order,
        refinement,
        weight,
        spread,
        limit_uncertainty: LIMIT_UNCERTAINTY,
    }
}
