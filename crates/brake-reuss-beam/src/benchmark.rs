//! The beam as a benchmark that scenes can name.

use crate::geometry::Geometry;
use crate::mesh::{Refinement, build};
use crate::mesh_accuracy::MESH_ACCURACY;
use crate::published;
use joint_model::benchmark::{
    Benchmark, BenchmarkError, Bounds, MeasuredSurface, MeshAccuracy, MeshSettings, Symmetry,
};
use joint_model::fit::Fit;
use joint_model::{Bodies, Joint, MeshedBodies, Sides};
use serde_json::{Value, json};

/// The Brake-Reuss beam of the method paper, as `{ "benchmark": "brake-reuss-beam" }` in scenes.
#[derive(Clone, Copy, Debug)]
pub struct BrakeReussBenchmark;

/// Friction coefficient of the paper's reference simulations (-).
const FRICTION_COEFFICIENT: f64 = 0.2;

/// Mass of the block mesh with the paper's material (kg).
const MESH_MASS: f64 = 3.70;

/// A quantity as scenes write it, which reads back bit by bit.
fn quantity(value: f64, unit: &str) -> String {
    format!("{value:?} {unit}")
}

impl Benchmark for BrakeReussBenchmark {
    fn name(&self) -> &'static str {
        "brake-reuss-beam"
    }

    fn short_name(&self) -> &'static str {
        "brb"
    }

    fn title(&self) -> &'static str {
        "Brake-Reuss beam"
    }

    fn defaults(&self) -> Value {
        let steel = published::steel();
        let figures = published::ADHESION;
        json!({
            "model": { "material": {
                "youngs_modulus": quantity(steel.youngs_modulus, "Pa"),
                "poisson_ratio": steel.poisson_ratio,
                "density": quantity(steel.density, "kg/m^3"),
                "hardness": quantity(figures.hardness, "Pa"),
                "work_of_adhesion": quantity(figures.work_of_adhesion, "J/m^2"),
            } },
            "bolts": { "load": quantity(published::BOLT_TENSION, "N") },
            "interfaces": { "surface": "measured", "mu": FRICTION_COEFFICIENT },
        })
    }

    fn scenes(&self) -> &'static [(&'static str, &'static str)] {
        &[
            ("brb-flat", include_str!("../scenes/brb-flat.json")),
            ("brb-topography", include_str!("../scenes/brb-topography.json")),
            ("brb-paper-flat", include_str!("../scenes/brb-paper-flat.json")),
            (
                "brb-paper-topography",
                include_str!("../scenes/brb-paper-topography.json"),
            ),
            ("brb-synthetic-scan", include_str!("../scenes/brb-synthetic-scan.json")),
            ("brb-quick", include_str!("../scenes/brb-quick.json")),
            ("brb-deck", include_str!("../scenes/brb-deck.json")),
            ("brb-predictive", include_str!("../scenes/brb-predictive.json")),
            ("brb-from-drawing", include_str!("../scenes/brb-from-drawing.json")),
            (
                "published-epmc-flat",
                include_str!("../scenes/published-epmc-flat.json"),
            ),
            (
                "published-epmc-topography",
                include_str!("../scenes/published-epmc-topography.json"),
            ),
        ]
    }

    fn joint(&self, mesh: &MeshSettings) -> Result<Joint, BenchmarkError> {
        let mut refinement = Refinement::level(mesh.refinement, mesh.element_order);
        if let Some(layers) = mesh.arm_layers {
            refinement.arm_layers = layers;
        }
        Ok(joint(&refinement, mesh)?)
    }

    fn surface(&self) -> Option<MeasuredSurface> {
        Some(MeasuredSurface {
            gap_quantiles: &published::ASPERITY_GAP_QUANTILES,
            asperities_per_area: published::ASPERITIES_PER_AREA,
            effective_radius: published::EFFECTIVE_RADIUS,
            gap: |[x, y]| published::mesoscale_gap(x, y),
        })
    }

    fn is_void(&self, [x, y]: [f64; 2]) -> bool {
        let geometry = Geometry::default();
        let radius = 0.5 * geometry.hole_diameter;
        geometry
            .hole_positions()
            .iter()
            .any(|hole| (x - hole).hypot(y) < radius)
    }

    fn bounds(&self) -> Bounds {
        let geometry = Geometry::default();
        let holes = geometry.hole_positions().len() as f64;
        let hole = 0.25 * std::f64::consts::PI * geometry.hole_diameter * geometry.hole_diameter;
        Bounds {
            mass: MESH_MASS,
            density: published::steel().density,
            interface_area: geometry.lap_length * geometry.width - holes * hole,
            zero_energy_modes: [6, 7],
        }
    }

    fn mesh_accuracy(&self) -> Option<MeshAccuracy> {
        Some(MESH_ACCURACY)
    }
}

/// The beam, or its half `y >= 0`, with a refinement of one's own; that of `mesh` is without effect.
///
/// # Errors
/// Those of the mesher.
pub fn joint(refinement: &Refinement, mesh: &MeshSettings) -> crate::Result<Joint> {
    let geometry = Geometry::default();
    let mut beam = build(&geometry, refinement, mesh.element_order, &mesh.material, 1.0)?;
    if mesh.symmetry == Symmetry::Half {
        beam = beam.half()?;
    }
    beam.assembly.mesh.set_formulation(mesh.hexahedra);
    let bodies = MeshedBodies {
        assembly: beam.assembly,
        sides: Sides::Pairs {
            top: beam.top_nodes,
            bottom: beam.bottom_nodes,
        },
        response_node: beam.response_node,
        response_direction: beam.response_direction,
        excitations: Vec::new(),
        moved_pairs: None,
        raised: None,
        rigid_motions: 6,
    };
    Ok(Joint {
        positions: Some(bodies.interface_positions()),
        bodies: Bodies::Meshed(bodies),
        interface: beam.interface,
        frame: beam.frame,
        node_frames: Vec::new(),
        parts: Vec::new(),
        clearance: Some(0.5 * (geometry.hole_diameter - geometry.shank_diameter)),
        response: "the beam's end, edge middle, in bending direction".into(),
        fit: Fit::default(),
    })
}
