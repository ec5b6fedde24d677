//! Benchmark structures: joints with a name, of which geometry, mesh and surface are known.
//!
//! This crate knows no benchmark. Programs hand a list of them to the reader of scenes.

use super::Joint;
use finite_elements::elements::{Formulation, HEX8, HEX20};
use finite_elements::mesh::Material;
use serde::{Deserialize, Serialize};
use zte_assembly::{InterfaceMesh, Operators};

/// A benchmark structure.
pub trait Benchmark: Sync {
    /// Name in scenes, such as `brake-reuss-beam`.
    fn name(&self) -> &'static str;

    /// What it is called for short: `SHORT-quick` is its scaled-down scene.
    fn short_name(&self) -> &'static str;

    /// Name in reports.
    fn title(&self) -> &'static str;

    /// What a scene on the benchmark may leave out, as a scene file in SI without `units`, and what it says then: material,
    /// bolt load, friction coefficient, surface.
    fn defaults(&self) -> serde_json::Value;

    /// Scenes that come with the benchmark: names, and texts of scene files. The first is the one to begin with.
    fn scenes(&self) -> &'static [(&'static str, &'static str)];

    /// Text of the scene of a name.
    fn scene(&self, name: &str) -> Option<&'static str> {
        let mut scenes = self.scenes().iter();
        scenes.find_map(|(own, text)| (*own == name).then_some(*text))
    }

    /// Meshes the benchmark; bolts are loaded by unit tension.
    ///
    /// # Errors
    /// What the mesher refuses.
    fn joint(&self, mesh: &MeshSettings) -> Result<Joint, BenchmarkError>;

    /// The measured surface that `surface: measured` and `gap: measured` stand for, if there is one.
    fn surface(&self) -> Option<MeasuredSurface>;

    /// Whether a position in the plane of the interface (m) lies in a hole, where a profilometer finds nothing.
    fn is_void(&self, position: [f64; 2]) -> bool;

    /// What every sound run of the benchmark satisfies.
    fn bounds(&self) -> Bounds;

    /// The measured errors of its meshes, if they were measured.
    fn mesh_accuracy(&self) -> Option<MeshAccuracy>;
}

/// Why a benchmark could not be meshed.
pub type BenchmarkError = Box<dyn std::error::Error + Send + Sync>;

/// Benchmarks that scenes may name.
pub type Benchmarks<'a> = &'a [&'static dyn Benchmark];

/// Statistics of a measured pair of faces.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredSurface {
    /// Distances of the asperities from the tallest one at equally spaced probabilities from 0 to 1 (m).
    pub gap_quantiles: &'static [f64],
    /// Asperities per area (1/m^2).
    pub asperities_per_area: f64,
    /// Effective radius of a pair of asperities (m).
    pub effective_radius: f64,
    /// Gap at a position in the plane of the interface (m).
    pub gap: fn([f64; 2]) -> f64,
}

/// How a benchmark is meshed.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshSettings {
    /// How finely.
    pub refinement: RefinementLevel,
    /// Layers of elements along each arm, if they shall not be those of the refinement.
    pub arm_layers: Option<usize>,
    /// Which part of it.
    pub symmetry: Symmetry,
    /// Order of all elements.
    pub element_order: ElementOrder,
    /// Formulation of all hexahedra.
    pub hexahedra: Formulation,
    /// Material of all parts.
    pub material: Material,
}

/// How finely a benchmark is meshed; what a level means in elements is up to the benchmark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum RefinementLevel {
    /// For a look in seconds: of the Brake-Reuss beam about 150 interface elements.
    Quick,
    /// About 300.
    #[default]
    Coarse,
    /// 588, as the method paper.
    Default,
    /// About 1200.
    Fine,
    /// About 2400.
    Finest,
}

/// Order of the shape functions of solids and interface elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ElementOrder {
    /// Hexahedra of 8 nodes, quadrilaterals of 4.
    Linear,
    /// Serendipity hexahedra of 20 nodes (`C3D20R` with reduced, `C3D20` with full integration), quadrilaterals of 8. Edges of a
    /// benchmark on circles are curved, those of a deck whose order is raised are straight.
    Quadratic,
}

impl ElementOrder {
    /// Formulations of its hexahedra, the default first.
    pub fn formulations(self) -> impl Iterator<Item = Formulation> {
        let row = match self {
            Self::Linear => &HEX8,
            Self::Quadratic => &HEX20,
        };
        row.formulations.iter().map(|(formulation, _)| *formulation)
    }
}

/// Which part of the structure is modelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Symmetry {
    /// All of it.
    #[default]
    None,
    /// The half `y >= 0`, with half the unknowns, of a scene that is symmetric about `y = 0`: flat faces with one law
    /// everywhere. Results are those of the whole, in motions that are symmetric too; modes that are not, such as bending
    /// in the plane of the interface and torsion, are not in it, and modes are numbered without them.
    Half,
}

impl Symmetry {
    /// Geometry and quadrature of the interface of which `mesh` is all or half.
    ///
    /// # Errors
    /// Those of [`Operators::try_new`].
    pub fn operators(
        self,
        mesh: &InterfaceMesh,
        points_per_direction: usize,
    ) -> Result<Operators, zte_assembly::Error> {
        match self {
            Self::None => Operators::try_new(mesh, points_per_direction),
            Self::Half => Operators::try_new_mirrored(mesh, points_per_direction),
        }
    }
}

/// Errors of the meshes of a benchmark, measured on a family of refinements.
#[derive(Clone, Copy, Debug)]
pub struct MeshAccuracy {
    /// Mode that it holds for, counted from 1.
    pub mode: usize,
    /// One row per mesh that was measured.
    pub errors: &'static [MeshError],
    /// How frequencies of two formulations lead to the limit of the mesh: one row per refinement on which that was calibrated.
    pub limits: &'static [LimitWeight],
    /// What was measured, in words: scenes, family, reference.
    pub source: &'static str,
}

impl MeshAccuracy {
    /// The meshes of elements of this order and formulation.
    pub fn of(&self, element_order: ElementOrder, hexahedra: Formulation) -> impl Iterator<Item = &'static MeshError> {
        let rows = self.errors.iter();
        rows.filter(move |row| (row.element_order, row.hexahedra) == (element_order, hexahedra))
    }
}

/// Largest differences of the results on one mesh to the limit of the mesh, the uncertainty of the limit included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshError {
    /// Order of its elements.
    pub element_order: ElementOrder,
    /// How fine the mesh is.
    pub refinement: RefinementLevel,
    /// Formulation of its hexahedra.
    pub hexahedra: Formulation,
    /// Relative, of frequencies.
    pub frequency: f64,
    /// Of the logarithm of damping ratios.
    pub damping: f64,
}

/// The limit of a frequency from the same mesh in two formulations: `f_S - weight (f_S - f_R)`, where `f_R` belongs to reduced
/// integration and `f_S` to the stiffer formulation: incompatible modes of linear elements, full integration of quadratic ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitWeight {
    /// Order of its elements.
    pub element_order: ElementOrder,
    /// How fine the mesh is.
    pub refinement: RefinementLevel,
    /// Weight (-).
    pub weight: f64,
    /// Largest deviation from it among the scenes and amplitudes that it was calibrated on.
    pub spread: f64,
    /// Relative uncertainty of the limit that it was calibrated against.
    pub limit_uncertainty: f64,
}

/// Bounds that hold for every sound run of a benchmark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Mass (kg) at the density below, within half a per cent.
    pub mass: f64,
    /// Density that the mass belongs to (kg/m^3).
    pub density: f64,
    /// Area of the interface (m^2), within a tenth of a per cent.
    pub interface_area: f64,
    /// Zero-energy modes of the whole with the interface stuck and without contact.
    pub zero_energy_modes: [usize; 2],
}
