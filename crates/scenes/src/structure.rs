//! The structure of a scene: where it comes from, and how it is meshed and reduced.

use super::material::Material;
use super::mesh::{MeshFile, along_x};
use super::units::{Area, Length, Mass, Units};
use crate::BenchmarkRef;
use crate::Error;
use finite_elements::elements::Formulation;
use finite_elements::formats::abaqus::Includes;
use joint_model::benchmark::{ElementOrder, RefinementLevel, Symmetry};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use zte_assembly::InterfaceMesh;

/// Where the structure comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum StructureSource {
    /// A benchmark structure by its name.
    Benchmark(BenchmarkRef),
    /// An input deck of Abaqus or CalculiX.
    Deck(Box<Deck>),
    /// A mesh file.
    Mesh(Box<MeshFile>),
    /// Matrices of another program.
    Matrices(Box<Matrices>),
}

/// The structure of a scene: its source, and what is added to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "StructureFields")]
pub struct StructureBlock {
    /// Where it comes from.
    #[serde(flatten)]
    pub source: StructureSource,
    /// Masses at nodes, beside those of the source. Matrices take none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub point_masses: Vec<PointMass>,
}

impl StructureBlock {
    /// The benchmark, if it is one.
    pub fn benchmark(&self) -> Option<BenchmarkRef> {
        match &self.source {
            StructureSource::Benchmark(benchmark) => Some(*benchmark),
            StructureSource::Deck(_) | StructureSource::Mesh(_) | StructureSource::Matrices(_) => None,
        }
    }

    /// The matrices, if it consists of them.
    pub fn matrices(&self) -> Option<&Matrices> {
        match &self.source {
            StructureSource::Matrices(matrices) => Some(matrices),
            StructureSource::Benchmark(_) | StructureSource::Deck(_) | StructureSource::Mesh(_) => None,
        }
    }

    /// The deck, if it comes from one.
    pub fn deck(&self) -> Option<&Deck> {
        match &self.source {
            StructureSource::Deck(deck) => Some(deck),
            StructureSource::Benchmark(_) | StructureSource::Mesh(_) | StructureSource::Matrices(_) => None,
        }
    }

    /// The mesh file, if it comes from one.
    pub fn mesh(&self) -> Option<&MeshFile> {
        match &self.source {
            StructureSource::Mesh(mesh) => Some(mesh),
            StructureSource::Benchmark(_) | StructureSource::Deck(_) | StructureSource::Matrices(_) => None,
        }
    }
}

impl From<StructureSource> for StructureBlock {
    /// The source as it is.
    fn from(source: StructureSource) -> Self {
        Self {
            source,
            point_masses: Vec::new(),
        }
    }
}

/// The structure of a scene as files have it: one of the sources by its name, and what is added to it.
#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(transform = one_source))]
#[serde(deny_unknown_fields)]
struct StructureFields {
    /// A benchmark structure by its name.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "BenchmarkRef"))]
    benchmark: Option<BenchmarkRef>,
    /// An input deck of Abaqus or CalculiX.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "Deck"))]
    deck: Option<Box<Deck>>,
    /// A mesh file.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "MeshFile"))]
    mesh: Option<Box<MeshFile>>,
    /// Matrices of another program.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "Matrices"))]
    matrices: Option<Box<Matrices>>,
    /// Masses at nodes, beside those of the source. Matrices take none.
    #[serde(default)]
    point_masses: Vec<PointMass>,
}

/// Requires exactly one of the sources.
#[cfg(feature = "schema")]
fn one_source(schema: &mut schemars::Schema) {
    let sources = ["benchmark", "deck", "mesh", "matrices"].map(|source| serde_json::json!({ "required": [source] }));
    schema.insert("oneOf".into(), sources.to_vec().into());
}

impl TryFrom<StructureFields> for StructureBlock {
    type Error = String;

    fn try_from(fields: StructureFields) -> Result<Self, String> {
        let sources = [
            fields.benchmark.map(StructureSource::Benchmark),
            fields.deck.map(StructureSource::Deck),
            fields.mesh.map(StructureSource::Mesh),
            fields.matrices.map(StructureSource::Matrices),
        ];
        let mut given = sources.into_iter().flatten();
        let (Some(source), None) = (given.next(), given.next()) else {
            return Err("exactly one of `benchmark`, `deck`, `mesh` and `matrices` must be given".into());
        };
        for (number, mass) in (1..).zip(&fields.point_masses) {
            mass.suits(&source)
                .map_err(|reason| format!("point_masses, number {number}: {reason}"))?;
        }
        Ok(Self {
            source,
            point_masses: fields.point_masses,
        })
    }
}

/// A mass at a node, in all three directions and without inertia of rotation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PointMass {
    /// Of a benchmark or a mesh: a position, for the node nearest to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[Length; 3]>,
    /// How far that node may be from the position; by default a hundredth of the largest extent of the structure along an
    /// axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<Length>,
    /// Of a deck: node label, or a set of one node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// Mass.
    pub mass: Mass,
}

impl PointMass {
    /// Whether it names its node in the way of the source; if not, why.
    fn suits(&self, source: &StructureSource) -> Result<(), &'static str> {
        match (source, &self.at, &self.node, self.within) {
            (StructureSource::Matrices(_), ..) => {
                Err("matrices show no nodes that a mass could be at; add it to the mass matrix")
            }
            (StructureSource::Benchmark(_) | StructureSource::Mesh(_), Some(_), None, _) => Ok(()),
            (StructureSource::Mesh(_), ..) => Err("on a mesh give the position of the mass, `at`, and no `node`"),
            (StructureSource::Benchmark(_), ..) => {
                Err("on a benchmark give the position of the mass, `at`, and no `node`")
            }
            (StructureSource::Deck(_), None, Some(_), None) => Ok(()),
            (StructureSource::Deck(_), ..) => Err("in a deck name the `node` of the mass, without `at` and `within`"),
        }
    }
}

/// How the structure is meshed and reduced.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// How finely a benchmark is meshed; on the Brake-Reuss beam 132, 184, 272, 828 and 1200 interface elements, with an `element_order`
    /// of `linear` 148, 300, 588, 1196 and 2352. By default that of `accuracy`; `default` where `element_order` is not that of `accuracy`.
    #[serde(default)]
    pub refinement: RefinementLevel,
    /// Layers of elements along each arm of a benchmark, if they shall not be those of the refinement.
    #[serde(default)]
    pub arm_layers: Option<usize>,
    /// Which part of a benchmark is modelled.
    #[serde(default)]
    pub symmetry: Symmetry,
    /// Order of the elements. By default, on a benchmark that of `accuracy`; a mesh file of linear elements becomes quadratic, and one that
    /// has others as well stays as it is; a deck stays as it is. With `linear` a mesh or a deck stays as it is, with `quadratic` its linear
    /// elements become quadratic, or are refused where that cannot be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub element_order: Option<ElementOrder>,
    /// Formulation of all hexahedra; by default reduced integration of quadratic and incompatible modes of linear ones, in a deck that of
    /// their element type. Quadratic hexahedra have `reduced` and `full` alone.
    #[serde(default)]
    pub formulation: Option<Formulation>,
    /// Material of all parts, unless a deck has its own, and of the asperities; left out where nothing depends on it
    /// ([`Scene::needs_material`](super::Scene::needs_material)).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<Material>,
    /// Stuck-interface modes retained by the reduction, 1 to 200, 20 by default; all that there are of matrices over the jump. With
    /// `reduction_error` the most that may be retained, 60 by default.
    #[serde(default)]
    pub modes: Option<usize>,
    /// Largest relative error that the reduction may bring into the ten frequencies it is checked by (with a uniform
    /// linear interface), 1e-9 to below 1: as few modes are retained as that allows.
    #[serde(default)]
    pub reduction_error: Option<f64>,
    /// For a structure of several interfaces: what may be left out of the coupling between one and all others, relative to the largest, 0 to 1e-6. The
    /// reduced matrices are then blocks of the interfaces, coupled through few combinations of each, which cost the sum of the squares of the interfaces and
    /// not the square of their sum. With 0 they are dense. By default 1e-7 where there are more than 3000 coordinates across all interfaces and blocks
    /// take fewer numbers, and 0 otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coupling_tolerance: Option<f64>,
}

impl Model {
    /// The material.
    ///
    /// # Errors
    /// [`Error::NoMaterial`].
    pub fn material(&self) -> Result<&Material, Error> {
        self.material.as_ref().ok_or(Error::NoMaterial)
    }

    /// Modes computed for the reduction.
    pub fn n_modes(&self) -> usize {
        self.modes
            .unwrap_or(if self.reduction_error.is_some() { 60 } else { 20 })
    }
}

/// A structure from an Abaqus or CalculiX input deck, in the scene's units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Deck {
    /// The file; in a scene file relative to its folder.
    pub path: PathBuf,
    /// Which files it may include. Whoever runs a scene decides it, not the scene.
    #[serde(skip)]
    pub includes: Includes,
    /// Its units; by default those of the scene.
    #[serde(default = "Units::in_use")]
    pub units: Units,
    /// Surface of one body at the interface.
    pub top_surface: String,
    /// Surface of the other; both have the same nodes.
    pub bottom_surface: String,
    /// How far the two nodes of a pair may be apart in the plane of the interface (length): such pairs are moved to their
    /// midpoints. By default a thousandth of the shortest edge, and nothing is moved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pair_tolerance: Option<Length>,
    /// First direction in the interface.
    #[serde(default = "along_x")]
    pub along: [f64; 3],
    /// Bolts, at least one: reference nodes `top` and `bottom`, or the node `pretension` of a pretension section.
    pub bolts: Vec<DeckBolt>,
    /// Where amplitudes are measured.
    pub response: DeckResponse,
    /// How far the slaves of ties may be from their master (length); by default what the deck says.
    #[serde(default)]
    pub tie_tolerance: Option<Length>,
    /// What becomes of slaves farther away.
    #[serde(default)]
    pub untied: Untied,
    /// Whose materials the bodies have.
    #[serde(default)]
    pub materials: MaterialSource,
    /// By how much the bodies can slide before a shank touches its hole (length), if it is known.
    #[serde(default)]
    pub bolt_hole_clearance: Option<Length>,
}

/// A bolt of a deck. Nodes are named by their labels, or by sets of one node.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, try_from = "DeckBoltFields")]
pub enum DeckBolt {
    /// The two reference nodes that it pulls towards one another.
    References {
        /// The one on the side of the top body: tension pulls it in the direction from the top body into the bottom one.
        top: String,
        /// The one on the side of the bottom body.
        bottom: String,
    },
    /// A pretension section.
    Pretension {
        /// Its node.
        pretension: String,
    },
}

/// A bolt of a deck as files have it: `top` and `bottom`, or `pretension`.
#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct DeckBoltFields {
    /// Reference node on the side of the top body: tension pulls it in the direction from the top body into the bottom one.
    #[serde(default)]
    top: Option<String>,
    /// Reference node on the side of the bottom body.
    #[serde(default)]
    bottom: Option<String>,
    /// Node of a pretension section.
    #[serde(default)]
    pretension: Option<String>,
}

impl TryFrom<DeckBoltFields> for DeckBolt {
    type Error = &'static str;

    fn try_from(fields: DeckBoltFields) -> Result<Self, Self::Error> {
        match (fields.top, fields.bottom, fields.pretension) {
            (Some(top), Some(bottom), None) => Ok(Self::References { top, bottom }),
            (None, None, Some(pretension)) => Ok(Self::Pretension { pretension }),
            _ => Err(
                "a bolt has either `top` and `bottom`, two reference nodes, or `pretension`, the node of its pretension section",
            ),
        }
    }
}

/// Where and in which direction amplitudes are measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DeckResponse {
    /// Node label, or a set of one node.
    pub node: String,
    /// Unit vector.
    pub direction: [f64; 3],
}

/// A structure as matrices of another program.
///
/// | path | what is read |
/// |---|---|
/// | `.npz`, `.mat` | arrays `M`, `K`, `dofs`, and where they are there `C` (viscous damping), `Fv`, `R`, `L`, `frame`, `interface_nodes`, `interface_elements` |
/// | a folder | the same, each from a Matrix Market file such as `M.mtx` |
/// | `.mtx` | a substructure of Abaqus: mass, stiffness, load cases, recovery |
/// | `.sti` | stiffness and mass of CalculiX, with `.mas` and `.dof` beside it |
/// | `.full` | assembled stiffness, mass and damping of Ansys, without the degrees of freedom that are held |
/// | `.op4` | matrices of Nastran's `OUTPUT4` with the names of the arrays; `INTNODES` and `INTELEMS` are `interface_nodes` and `interface_elements` |
/// | `.op2` | tables `DMIG` of Nastran's `OUTPUT2` as for `.pch`, stiffness, mass and damping also as `MATK`, `MATM`, `MATB`; else its matrices as for `.op4` |
/// | `.pch`, `.bdf`, `.dat` | entries `DMIG` of Nastran: `K` or `KAAX`, `M` or `MAAX`, `B` or `BAAX`, and as numbered columns `FV` and the transpose of `R`; the grid points and scalar points (component 0) are the map |
///
/// `dofs` has a row `label, component` for each coordinate, or for each row of `L` if there is one, which maps the
/// coordinates of the matrices to those. Over the jump, label `k` is node `k` of the interface mesh, counted from 1, and
/// components 1, 2, 3 are x, y and the normal; labels that are not positive are other coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Matrices {
    /// The file, or a folder; in a scene file relative to its folder.
    pub path: PathBuf,
    /// Units of matrices and interface mesh; by default those of the scene.
    #[serde(default = "Units::in_use")]
    pub units: Units,
    /// What the coordinates are.
    pub coordinates: Coordinates,
    /// The interface mesh; by default what the file holds.
    #[serde(default)]
    pub interface: Option<PlaneMesh>,
    /// Points of contact in the place of an interface mesh; they need `interfaces.surface.parameters`, as they have no faces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<ContactPoint>>,
    /// Loads of unit tension, one per bolt; by default all that the file holds, or none where bolts have no load.
    #[serde(default)]
    pub bolts: Option<Vec<MatrixVector>>,
    /// The displacement at which amplitudes are measured.
    #[serde(default = "first")]
    pub response: MatrixVector,
    /// Motions without energy of the structure with a stuck interface; by default none over the jump, six over both
    /// sides.
    #[serde(default)]
    pub zero_energy_modes: Option<usize>,
    /// By how much the bodies can slide before a shank touches its hole (length), if it is known.
    #[serde(default)]
    pub bolt_hole_clearance: Option<Length>,
}

/// What the coordinates of matrices are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Coordinates {
    /// The jump at the interface (top less bottom, normal from the top body into the bottom one) and whatever else.
    Jump,
    /// Displacements of both sides, and whatever else.
    BothSides(Sides),
}

/// Which nodes face one another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Sides {
    /// Labels of the nodes of the top side, in the order of the interface mesh.
    pub top: Vec<u64>,
    /// Labels of those of the bottom side, in the same order.
    pub bottom: Vec<u64>,
    /// Unit vectors as rows: x and y of the interface mesh, and the normal from the top body into the bottom one.
    pub frame: [[f64; 3]; 3],
}

/// An interface mesh in its plane, in the units of the matrices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PlaneMesh {
    /// Coordinates x, y (length).
    pub nodes: Vec<[f64; 2]>,
    /// Quadrilaterals of 4, 8 or 9 nodes and triangles of 3 or 6: node numbers from 1, the corners counter-clockwise, then the
    /// middles of the edges from each corner to the next, then the centre.
    pub elements: Vec<Vec<u32>>,
}

impl PlaneMesh {
    /// The mesh for a unit of `length` (m).
    ///
    /// # Errors
    /// Nodes that do not exist, coincide or are not used, elements that are no simple triangles or quadrilaterals or occur
    /// twice; elements and nodes are counted from 0 there.
    pub fn interface(&self, length: f64) -> Result<InterfaceMesh, zte_assembly::Error> {
        let nodes = self.nodes.iter().map(|x| x.map(|x| x * length)).collect();
        // Number 0, which no node may have, becomes one that no mesh has.
        let from_zero = |list: &Vec<u32>| list.iter().map(|n| n.wrapping_sub(1)).collect::<Vec<u32>>();
        InterfaceMesh::try_from_lists(nodes, self.elements.iter().map(from_zero))
    }
}

/// Contact at a single node of matrices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ContactPoint {
    /// Label of the node; over both sides that of the top one. Over the jump, components 1, 2, 3 are x, y and the normal, and those
    /// that the matrices do not have are held at zero.
    pub node: u64,
    /// Area that it stands for (length^2), by default one unit: then stiffnesses per area and pressures are those of the point.
    #[serde(default = "one_unit_of_area")]
    pub area: Area,
    /// Coordinates x, y in the plane (length), for friction zones and files of fields.
    #[serde(default)]
    pub position: [Length; 2],
}

/// One in the units of the file.
fn one_unit_of_area() -> Area {
    Area::in_units(1.0)
}

/// A vector that goes with matrices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum MatrixVector {
    /// Column of `Fv` or row of `R`, or of the recovery matrix, counted from 1.
    Number(usize),
    /// Load case of a substructure.
    LoadCase(String),
    /// Factors of coordinates: label, component, factor.
    Terms(Vec<(i64, u32, f64)>),
}

/// What becomes of the slaves of a tie that are beyond its tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Untied {
    /// They are an error.
    #[default]
    Refuse,
    /// They stay free, as in Abaqus; their number is reported.
    Free,
}

/// Whose materials a structure from a file has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum MaterialSource {
    /// The file's.
    #[default]
    Deck,
    /// The scene's, in all parts.
    Scene,
}

fn first() -> MatrixVector {
    MatrixVector::Number(1)
}
