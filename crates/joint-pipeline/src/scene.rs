//! Scene files: JSON with a mandatory `units` block and a default for everything else.
//!
//! Quantities are given in the scene's units and converted to SI once, by [`Scene::from_json`]; all other code sees SI.

use crate::Error;
use crate::accuracy::Accuracy;
pub use crate::scans::{Place, Readings, ScanFile, Scans};
use contact_laws::{HistoryRule, TangentialReading};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use surface_characterisation::Registration;

/// Units of all quantities in the file. Force is mass times length per second squared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Unit of length.
    pub length: LengthUnit,
    /// Unit of mass.
    pub mass: MassUnit,
    /// Unit of time.
    pub time: TimeUnit,
}

impl Units {
    /// Unit of length (m).
    pub fn length_in_si(&self) -> f64 {
        match self.length {
            LengthUnit::Metre => 1.0,
            LengthUnit::Millimetre => 1e-3,
        }
    }

    /// Unit of mass (kg).
    pub fn mass_in_si(&self) -> f64 {
        match self.mass {
            MassUnit::Kilogram => 1.0,
            MassUnit::Tonne => 1e3,
        }
    }
}

/// Unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LengthUnit {
    /// Metre.
    #[serde(rename = "m")]
    Metre,
    /// Millimetre.
    #[serde(rename = "mm")]
    Millimetre,
}

/// Unit of mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum MassUnit {
    /// Kilogram.
    #[serde(rename = "kg")]
    Kilogram,
    /// Tonne, which makes mm-t-s consistent with newtons.
    #[serde(rename = "t")]
    Tonne,
}

/// Unit of time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum TimeUnit {
    /// Second.
    #[serde(rename = "s")]
    Second,
}

/// A scene: what is modelled, and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Units of the file.
    pub units: Units,
    /// Name of the scene; the file's name by default.
    #[serde(default)]
    pub name: String,
    /// How exact the result shall be: settings that the scene does not give are those of the cheapest set that is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// Structure.
    #[serde(default)]
    pub model: Model,
    /// What the traction law follows from.
    #[serde(default)]
    pub surface: Surface,
    /// Gap between the faces before they are loaded.
    #[serde(default)]
    pub gap: Gap,
    /// Traction law.
    #[serde(default)]
    pub law: Law,
    /// Friction coefficient (-).
    #[serde(default = "defaults::mu")]
    pub mu: f64,
    /// Gauss points per direction of each interface element: 1, 2, 3, 4 or 5.
    #[serde(default = "defaults::points_per_direction")]
    pub points_per_direction: usize,
    /// Bolts.
    #[serde(default)]
    pub bolts: Bolts,
    /// Coupled quasi-static modal analysis.
    #[serde(default)]
    pub cqsma: Cqsma,
    /// Viscous modal damping ratio that is added to the total, apart from friction (-).
    #[serde(default)]
    pub background_damping: f64,
    /// Methods beside CQSMA, at the same amplitudes.
    #[serde(default)]
    pub methods: Vec<Method>,
    /// Which results are stored as fields.
    #[serde(default)]
    pub output: Output,
}

/// Methods beside CQSMA.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Loops with the contact linearised about the static state (eqs. 34-36).
    Qsma,
    /// The same with the contact as it is instead of linearised, beside the normal stiffness that linearising it gave: the
    /// mistake that the method paper warns of, to see how much too stiff it makes a joint.
    QsmaTwice,
    /// Masing's rule on one initial loading curve.
    Masing,
    /// Rayleigh-quotient nonlinear modal analysis, with Masing's rule.
    Rqnma,
}

impl Method {
    /// Name as used in scenes and outputs.
    pub fn name(self) -> &'static str {
        match self {
            Method::Qsma => "qsma",
            Method::QsmaTwice => "qsma-twice",
            Method::Masing => "masing",
            Method::Rqnma => "rqnma",
        }
    }
}

/// The structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Model {
    /// Named refinement of the block mesh.
    pub refinement: RefinementName,
    /// A structure in the place of the block mesh.
    pub deck: Option<Deck>,
    /// Matrices in the place of any mesh.
    pub matrices: Option<Matrices>,
    /// Layers of elements along each arm of the block mesh, if they shall not be those of the refinement.
    pub arm_layers: Option<usize>,
    /// Which part of the block mesh is modelled.
    pub symmetry: Symmetry,
    /// Formulation of all hexahedra; by default incompatible modes, in a deck that of their element type.
    pub formulation: Option<FormulationName>,
    /// Material of all parts, and of the asperities.
    pub material: Material,
    /// Stuck-interface modes retained by the reduction, 20 by default; all that there are of matrices over the jump. With
    /// `reduction_error` the most that may be retained, 60 by default.
    pub modes: Option<usize>,
    /// Largest relative error that the reduction may bring into the ten frequencies it is checked by (with a uniform
    /// linear interface): as few modes are retained as that allows.
    pub reduction_error: Option<f64>,
}

impl Model {
    /// Modes computed for the reduction.
    pub fn n_modes(&self) -> usize {
        self.modes
            .unwrap_or(if self.reduction_error.is_some() { 60 } else { 20 })
    }
}

/// A structure from an Abaqus or CalculiX input deck, in the scene's units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Deck {
    /// The file; in a scene file relative to its folder.
    pub path: PathBuf,
    /// Its units; by default those of the scene.
    #[serde(default)]
    pub units: Option<Units>,
    /// Surface of one body at the interface.
    pub top_surface: String,
    /// Surface of the other; both have the same nodes.
    pub bottom_surface: String,
    /// First direction in the interface.
    #[serde(default = "defaults::along")]
    pub along: [f64; 3],
    /// Bolts.
    pub bolts: Vec<DeckBolt>,
    /// Where amplitudes are measured.
    pub response: DeckResponse,
    /// How far the slaves of ties may be from their master (length); by default what the deck says.
    #[serde(default)]
    pub tie_tolerance: Option<f64>,
    /// What becomes of slaves farther away.
    #[serde(default)]
    pub untied: Untied,
    /// Whose materials the bodies have.
    #[serde(default)]
    pub materials: MaterialSource,
    /// By how much the bodies can slide before a shank touches its hole (length), if it is known.
    #[serde(default)]
    pub bolt_hole_clearance: Option<f64>,
}

/// The two reference nodes that a bolt pulls towards one another: node labels, or sets of one node.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeckBolt {
    /// The one on the side of the top body: tension pulls it in the direction from the top body into the bottom one.
    pub top: String,
    /// The one on the side of the bottom body.
    pub bottom: String,
}

/// Where and in which direction amplitudes are measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
/// | `.npz`, `.mat` | arrays `M`, `K`, `dofs`, and where they are there `Fv`, `R`, `L`, `frame`, `interface_nodes`, `interface_elements` |
/// | a folder | the same, each from a Matrix Market file such as `M.mtx` |
/// | `.mtx` | a substructure of Abaqus: mass, stiffness, load cases, recovery |
/// | `.sti` | stiffness and mass of CalculiX, with `.mas` and `.dof` beside it |
///
/// `dofs` has a row `label, component` for each coordinate, or for each row of `L` if there is one, which maps the
/// coordinates of the matrices to those. Over the jump, label `k` is node `k` of the interface mesh, counted from 1, and
/// components 1, 2, 3 are x, y and the normal; labels that are not positive are other coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Matrices {
    /// The file, or a folder; in a scene file relative to its folder.
    pub path: PathBuf,
    /// Units of matrices and interface mesh; by default those of the scene.
    #[serde(default)]
    pub units: Option<Units>,
    /// What the coordinates are.
    pub coordinates: Coordinates,
    /// The interface mesh; by default what the file holds.
    #[serde(default)]
    pub interface: Option<PlaneMesh>,
    /// Loads of unit tension, one per bolt; by default all that the file holds.
    #[serde(default)]
    pub bolts: Option<Vec<MatrixVector>>,
    /// The displacement at which amplitudes are measured.
    #[serde(default = "defaults::first")]
    pub response: MatrixVector,
    /// Motions without energy of the structure with a stuck interface; by default none over the jump, six over both
    /// sides.
    #[serde(default)]
    pub zero_energy_modes: Option<usize>,
    /// By how much the bodies can slide before a shank touches its hole (length), if it is known.
    #[serde(default)]
    pub bolt_hole_clearance: Option<f64>,
}

/// What the coordinates of matrices are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coordinates {
    /// The jump at the interface (top less bottom, normal from the top body into the bottom one) and whatever else.
    Jump,
    /// Displacements of both sides, and whatever else.
    BothSides(Sides),
}

/// Which nodes face one another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sides {
    /// Labels of the nodes of the top side, in the order of the interface mesh.
    pub top: Vec<u64>,
    /// Labels of those of the bottom side, in the same order.
    pub bottom: Vec<u64>,
    /// Unit vectors as rows: x and y of the interface mesh, and the normal from the top body into the bottom one.
    pub frame: [[f64; 3]; 3],
}

/// An interface mesh in its plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneMesh {
    /// Coordinates x, y (length).
    pub nodes: Vec<[f64; 2]>,
    /// Quadrilaterals and triangles, node numbers from 1, counter-clockwise.
    pub elements: Vec<Vec<u32>>,
}

/// A vector that goes with matrices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[serde(rename_all = "kebab-case")]
pub enum MaterialSource {
    /// The scene's, in all parts.
    #[default]
    Scene,
    /// The file's.
    Deck,
}

impl Default for Model {
    fn default() -> Self {
        Self {
            refinement: RefinementName::Default,
            arm_layers: None,
            deck: None,
            matrices: None,
            symmetry: Symmetry::None,
            formulation: None,
            material: Material::default(),
            modes: None,
            reduction_error: None,
        }
    }
}

/// Refinements of the block mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RefinementName {
    /// About 150 interface elements.
    Quick,
    /// About 300.
    Coarse,
    /// 588, as the method paper.
    Default,
    /// About 1200.
    Fine,
    /// About 2400.
    Finest,
}

/// Which part of the structure is modelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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

/// Element formulations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FormulationName {
    /// `C3D8I`.
    IncompatibleModes,
    /// `C3D8`: mean volumetric strain.
    BBar,
    /// Full integration without remedies.
    Full,
    /// `C3D8R`: one point and hourglass control, lumped mass.
    Reduced,
}

/// Elastic material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Material {
    /// Young's modulus (force/length^2).
    pub youngs_modulus: f64,
    /// Poisson ratio (-).
    pub poisson_ratio: f64,
    /// Density (mass/length^3).
    pub density: f64,
    /// Hardness, for the onset of yield (force/length^2).
    pub hardness: f64,
}

impl Default for Material {
    fn default() -> Self {
        let steel = brake_reuss_beam::published::steel();
        Self {
            youngs_modulus: steel.youngs_modulus,
            poisson_ratio: steel.poisson_ratio,
            density: steel.density,
            // Section 3.2.1 of the method paper.
            hardness: 9.47e9,
        }
    }
}

/// What the traction law follows from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Surface {
    /// Measured statistics of a real interface pair, the same everywhere.
    #[default]
    Measured,
    /// Two seeded synthetic scans, characterised element by element.
    SyntheticScan(SyntheticScan),
    /// Two scans from files, characterised element by element.
    Scans(Box<Scans>),
    /// No asperities: the parameters of the law themselves.
    Parameters(Parameters),
}

impl Surface {
    /// Whether there are samples of heights.
    pub fn is_scanned(&self) -> bool {
        matches!(self, Self::SyntheticScan(_) | Self::Scans(_))
    }

    /// Motion of the bottom face against the top one, of surfaces that are scanned.
    pub fn registration(&mut self) -> Option<&mut Registration> {
        match self {
            Self::SyntheticScan(scan) => Some(&mut scan.registration),
            Self::Scans(scans) => Some(&mut scans.registration),
            Self::Measured | Self::Parameters(_) => None,
        }
    }
}

/// Parameters of the traction law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// What each set belongs to.
    pub per: Per,
    /// One set for the interface, for each element, or for each integration point (element by element).
    pub sets: Vec<ParameterSet>,
}

/// What a set of parameters belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Per {
    /// The whole interface.
    Interface,
    /// An element.
    Element,
    /// An integration point.
    Point,
}

/// One set of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterSet {
    /// Traction and stiffness against interference; of the same kind in all sets.
    pub curves: Curves,
    /// Friction coefficient (-); by default that of the scene.
    #[serde(default)]
    pub mu: Option<f64>,
    /// Gap before the faces are loaded (length).
    #[serde(default)]
    pub gap: f64,
}

/// Traction and stiffness against interference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Curves {
    /// Constant stiffnesses.
    Elastic(Elastic),
    /// Eqs. (28) and (29).
    Fitted(Fitted),
}

/// Constant stiffnesses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Elastic {
    /// Per area (force/length^3).
    pub normal_stiffness: f64,
    /// Per area along x and y (force/length^3).
    pub tangential_stiffness: [f64; 2],
}

/// Coefficients of eqs. (28) and (29).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fitted {
    /// `a, b, c, d, e` of eq. (28) (-).
    pub normal: [f64; 5],
    /// `a, b, c, d` of eq. (29) along x and y (-).
    pub tangential: [[f64; 4]; 2],
    /// Interference that the logarithms refer to (length).
    pub u_ref: f64,
    /// Traction that they refer to (force/length^2); by default one unit.
    #[serde(default = "defaults::one")]
    pub t_ref: f64,
    /// Stiffness that they refer to (force/length^3); by default one unit.
    #[serde(default = "defaults::one")]
    pub k_ref: f64,
    /// Interferences between which the fits hold (length); everywhere by default.
    #[serde(default)]
    pub range: Option<[f64; 2]>,
}

/// Two synthetic faces on the grid of a profilometer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SyntheticScan {
    /// Seed of the top face; the bottom one uses the next number.
    pub seed: u64,
    /// Grid steps along x and y (length).
    pub step: [f64; 2],
    /// Height step of the instrument (length).
    pub height_step: f64,
    /// Rms roughness of each face (length).
    pub rms: f64,
    /// Correlation lengths along x and y (length).
    pub correlation_length: [f64; 2],
    /// Amplitude of the waviness of each face (length).
    pub waviness: f64,
    /// Wavelength of the waviness along the beam (length).
    pub wavelength: f64,
    /// Tilt of the raw scans, taken out again by de-trending (-).
    pub tilt: [f64; 2],
    /// Bootstrap draws for the bands of the curves.
    pub bootstrap: usize,
    /// Motion of the bottom face against the top one (length, and slopes without unit).
    pub registration: Registration,
}

impl Default for SyntheticScan {
    fn default() -> Self {
        Self {
            seed: 1,
            step: [30e-6, 50e-6],
            height_step: 0.5e-6,
            rms: 2.5e-6,
            correlation_length: [150e-6, 200e-6],
            waviness: 1e-6,
            wavelength: 0.2,
            tilt: [1e-4, -2e-4],
            bootstrap: 30,
            registration: Registration::default(),
        }
    }
}

/// Gap between the faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gap {
    /// No gap.
    #[default]
    Flat,
    /// The measured mesoscale gap of the interface pair whose statistics are used.
    Measured,
    /// The gap of the scans.
    Scan,
}

/// Traction law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Law {
    /// How the asperity sums are evaluated.
    pub kind: LawKind,
    /// Tangential stiffness of an asperity.
    pub tangential: TangentialReading,
    /// How the stuck traction follows from the last committed state.
    pub history: HistoryRule,
}

impl Default for Law {
    fn default() -> Self {
        Self {
            kind: LawKind::Tabulated,
            tangential: TangentialReading::Mindlin,
            history: HistoryRule::Incremental,
        }
    }
}

/// How the asperity sums are evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LawKind {
    /// Monotone table with a measured error bound. Of scans, the empirical distribution of the heights is interpolated
    /// linearly between its order statistics ([`surface_characterisation::PairAsperities::interpolated_population`]).
    Tabulated,
    /// Curves fitted with eqs. (28) and (29).
    Fitted,
    /// The sums themselves.
    AsperitySum,
}

/// Bolts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Bolts {
    /// Tension of each bolt (force).
    pub load: f64,
    /// What the bolts do in vibration.
    pub behaviour: BoltBehaviour,
}

/// What bolts do once they are tightened to their load. The prestress is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoltBehaviour {
    /// Constant opposite forces on bolt and nut at all times, as in the method paper: their tension never changes, and
    /// their axial stiffness does not act.
    #[default]
    DeadLoad,
    /// The axial motion of bolt and nut relative to one another is locked in the prestressed state, as by the thread of
    /// a tightened nut: tension changes in vibration, and the bolts' axial stiffness acts.
    Locked,
}

impl Default for Bolts {
    fn default() -> Self {
        Self {
            load: brake_reuss_beam::published::BOLT_LOAD,
            behaviour: BoltBehaviour::DeadLoad,
        }
    }
}

/// Settings of the analysis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Cqsma {
    /// Mode followed, counted from 1.
    pub mode: usize,
    /// Linearised modes computed.
    pub modes: usize,
    /// Smallest displacement at the response point, by linear estimate (length).
    pub amplitude_from: f64,
    /// Largest displacement at the response point, by linear estimate (length).
    pub amplitude_to: f64,
    /// Amplitudes, spaced in log; 0 for prestress and linearised modes alone.
    pub amplitudes: usize,
    /// Vertices per quarter loop.
    pub vertices_per_quarter: usize,
    /// Cycles walked, the last of which is measured; by default as many as it takes until the loop closes.
    pub cycles: Option<usize>,
    /// Distance between the ends of a loop, relative to the motion there (energy norm), at which it counts as closed;
    /// 1e-4 by default. Not together with `cycles`.
    pub until_closed: Option<f64>,
    /// When the friction history is committed.
    pub commit: CommitName,
    /// Residual relative to the load, in the energy norm.
    pub tolerance: f64,
}

/// When the friction history is committed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CommitName {
    /// At load reversals, as published.
    #[default]
    AtReversals,
    /// At every converged vertex.
    AtEveryVertex,
}

impl Default for Cqsma {
    fn default() -> Self {
        Self {
            mode: 1,
            modes: 10,
            amplitude_from: 1e-7,
            amplitude_to: 1e-3,
            amplitudes: 20,
            vertices_per_quarter: 8,
            cycles: None,
            until_closed: None,
            commit: CommitName::AtReversals,
            tolerance: 1e-9,
        }
    }
}

/// Stored fields.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Output {
    /// Numbers of the amplitudes (from 1) whose interface fields are stored; by default the first, the last and two
    /// between. The prestress is always stored.
    pub fields_at: Option<Vec<usize>>,
}

mod defaults {
    pub(super) fn along() -> [f64; 3] {
        [1.0, 0.0, 0.0]
    }
    pub(super) fn first() -> super::MatrixVector {
        super::MatrixVector::Number(1)
    }
    pub(super) fn one() -> f64 {
        1.0
    }
    pub(super) fn mu() -> f64 {
        0.2
    }
    pub(super) fn points_per_direction() -> usize {
        2
    }
}

impl Scene {
    /// Reads a scene file and converts it to SI.
    ///
    /// # Errors
    /// [`Error::File`], or those of [`Scene::from_json`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path).map_err(|source| Error::File {
            path: path.to_owned(),
            operation: "reading the scene",
            source,
        })?;
        let stem = path
            .file_stem()
            .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let mut scene = Self::from_json(&text, &path.display().to_string(), &stem)?;
        if let Some(folder) = path.parent() {
            let deck = scene.model.deck.as_mut().map(|deck| &mut deck.path);
            let matrices = scene.model.matrices.as_mut().map(|matrices| &mut matrices.path);
            let scans = match &mut scene.surface {
                Surface::Scans(scans) => vec![&mut scans.top.path, &mut scans.bottom.path],
                _ => Vec::new(),
            };
            deck.into_iter()
                .chain(matrices)
                .chain(scans)
                .for_each(|path| *path = folder.join(&*path));
        }
        Ok(scene)
    }

    /// Parses and validates a scene; `place` is named in errors, `name` is used if the scene has none.
    ///
    /// # Errors
    /// [`Error::Syntax`] for malformed JSON and unknown fields, [`Error::Value`] for values outside their range.
    pub fn from_json(text: &str, place: &str, name: &str) -> Result<Self, Error> {
        let syntax = |message: String| Error::Syntax {
            place: place.into(),
            message,
        };
        let value: serde_json::Value = serde_json::from_str(text).map_err(|e| syntax(e.to_string()))?;
        let mut scene: Self = serde_json::from_str(text).map_err(|e| syntax(e.to_string()))?;
        scene.refuse_idle(&value).map_err(syntax)?;
        if let Some(accuracy) = scene.accuracy {
            let mut filled = value.clone();
            accuracy.rung().map_err(syntax)?.fill(&mut filled);
            scene = serde_json::from_value(filled).map_err(|e| syntax(e.to_string()))?;
        }
        // Defaults are in SI; quantities given in the file are converted where they stand.
        scene.convert(&value);
        if scene.name.is_empty() {
            scene.name = name.into();
        }
        scene.validate(place)?;
        Ok(scene)
    }

    /// The default scene in SI.
    pub fn new(name: &str) -> Self {
        Self {
            units: Units {
                length: LengthUnit::Metre,
                mass: MassUnit::Kilogram,
                time: TimeUnit::Second,
            },
            name: name.into(),
            accuracy: None,
            model: Model::default(),
            surface: Surface::default(),
            gap: Gap::default(),
            law: Law::default(),
            mu: defaults::mu(),
            points_per_direction: defaults::points_per_direction(),
            bolts: Bolts::default(),
            cqsma: Cqsma::default(),
            background_damping: 0.0,
            methods: Vec::new(),
            output: Output::default(),
        }
    }

    /// Numbers of the amplitudes (from 1) whose fields are stored, ascending.
    pub fn fields_at(&self) -> Vec<usize> {
        let last = self.cqsma.amplitudes;
        let mut numbers = self.output.fields_at.clone().unwrap_or_else(|| match last {
            0 => Vec::new(),
            _ => vec![1, last.div_ceil(2), (3 * last).div_ceil(4), last],
        });
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }

    /// Refuses what is given, other than by default, but would be without effect.
    fn refuse_idle(&self, given: &serde_json::Value) -> Result<(), String> {
        let default = serde_json::to_value(Self::new("")).unwrap_or_default();
        let model = &self.model;
        let over_jump = (model.matrices.as_ref()).is_some_and(|matrices| matrices.coordinates == Coordinates::Jump);
        let (deck, matrices) = (model.deck.is_some(), model.matrices.is_some());
        let parameters = matches!(self.surface, Surface::Parameters(_));
        // What replaces, what has no effect then, and what that belongs to.
        let idle = [
            (deck, "/model/refinement", "the block mesh, which model.deck replaces"),
            (
                matrices,
                "/model/refinement",
                "the block mesh, which model.matrices replaces",
            ),
            (deck, "/model/arm_layers", "the block mesh, which model.deck replaces"),
            (
                matrices,
                "/model/arm_layers",
                "the block mesh, which model.matrices replaces",
            ),
            (matrices, "/model/formulation", "meshes, which model.matrices replaces"),
            (matrices, "/model/deck", "meshes, which model.matrices replaces"),
            (deck, "/model/symmetry", "the block mesh, which model.deck replaces"),
            (
                matrices,
                "/model/symmetry",
                "the block mesh, which model.matrices replaces",
            ),
            (
                over_jump,
                "/model/modes",
                "reductions, and matrices over the jump are reduced",
            ),
            (
                over_jump,
                "/model/reduction_error",
                "reductions, and matrices over the jump are reduced",
            ),
            (parameters, "/law/kind", "asperities, which surface.parameters replaces"),
            (
                parameters,
                "/law/tangential",
                "asperities, which surface.parameters replaces",
            ),
            (
                parameters,
                "/gap",
                "surfaces; surface.parameters has a gap in each of its sets",
            ),
        ];
        let differs = |path| {
            given
                .pointer(path)
                .is_some_and(|value| default.pointer(path) != Some(value))
        };
        match idle.iter().find(|(replaced, path, _)| *replaced && differs(path)) {
            Some((_, path, owner)) => Err(format!(
                "{} belongs to {owner}; leave one of them out",
                path[1..].replace('/', ".")
            )),
            None => Ok(()),
        }
    }

    fn convert(&mut self, given: &serde_json::Value) {
        let (length, mass) = (self.units.length_in_si(), self.units.mass_in_si());
        let (force, stress) = (mass * length, mass / length);
        let scale = |path: &str, value: &mut f64, factor: f64| {
            if given.pointer(path).is_some() {
                *value *= factor;
            }
        };
        let material = &mut self.model.material;
        scale("/model/material/youngs_modulus", &mut material.youngs_modulus, stress);
        scale("/model/material/hardness", &mut material.hardness, stress);
        scale("/model/material/density", &mut material.density, mass / length.powi(3));
        scale("/bolts/load", &mut self.bolts.load, force);
        if let Some(deck) = &mut self.model.deck {
            deck.units.get_or_insert(self.units);
            for value in [&mut deck.tie_tolerance, &mut deck.bolt_hole_clearance] {
                *value = value.map(|length_given| length_given * length);
            }
        }
        if let Some(matrices) = &mut self.model.matrices {
            matrices.units.get_or_insert(self.units);
            matrices.bolt_hole_clearance = matrices.bolt_hole_clearance.map(|given| given * length);
        }
        if let Surface::Parameters(parameters) = &mut self.surface {
            for set in &mut parameters.sets {
                set.gap *= length;
                match &mut set.curves {
                    Curves::Elastic(elastic) => {
                        elastic.normal_stiffness *= stress / length;
                        elastic
                            .tangential_stiffness
                            .iter_mut()
                            .for_each(|k| *k *= stress / length);
                    }
                    Curves::Fitted(fitted) => {
                        fitted.u_ref *= length;
                        fitted.t_ref *= stress;
                        fitted.k_ref *= stress / length;
                        fitted.range.iter_mut().flatten().for_each(|u| *u *= length);
                    }
                }
            }
        }
        scale("/cqsma/amplitude_from", &mut self.cqsma.amplitude_from, length);
        scale("/cqsma/amplitude_to", &mut self.cqsma.amplitude_to, length);
        if let Surface::Scans(scans) = &mut self.surface {
            scans.scale(length);
        }
        if let Surface::SyntheticScan(scan) = &mut self.surface {
            let at = |field: &str| format!("/surface/synthetic-scan/{field}");
            for (field, value) in [
                ("height_step", &mut scan.height_step),
                ("rms", &mut scan.rms),
                ("waviness", &mut scan.waviness),
                ("wavelength", &mut scan.wavelength),
            ] {
                scale(&at(field), value, length);
            }
            for axis in 0..2 {
                scale(&at("registration/shift"), &mut scan.registration.shift[axis], length);
                scale(&at("step"), &mut scan.step[axis], length);
                scale(&at("correlation_length"), &mut scan.correlation_length[axis], length);
            }
        }
        self.units = Units {
            length: LengthUnit::Metre,
            mass: MassUnit::Kilogram,
            time: TimeUnit::Second,
        };
    }

    /// Checks what the crates below do not check themselves.
    ///
    /// # Errors
    /// [`Error::Value`].
    pub fn validate(&self, place: &str) -> Result<(), Error> {
        let check = |ok: bool, field, value: f64, unit, requirement| {
            if ok {
                Ok(())
            } else {
                Err(Error::Value {
                    place: place.into(),
                    field,
                    value,
                    unit,
                    requirement,
                })
            }
        };
        let positive = |v: f64| v.is_finite() && v > 0.0;
        let c = &self.cqsma;
        check(
            self.mu.is_finite() && self.mu >= 0.0,
            "mu",
            self.mu,
            "",
            "finite and not negative",
        )?;
        check(
            positive(self.bolts.load),
            "bolts.load",
            self.bolts.load,
            "N",
            "positive and finite",
        )?;
        let hardness = self.model.material.hardness;
        check(
            positive(hardness),
            "model.material.hardness",
            hardness,
            "Pa",
            "positive and finite",
        )?;
        check(
            (1..=200).contains(&self.model.n_modes()),
            "model.modes",
            self.model.n_modes() as f64,
            "",
            "between 1 and 200",
        )?;
        let target = self.model.reduction_error.unwrap_or(1e-4);
        check(
            (1e-9..1.0).contains(&target),
            "model.reduction_error",
            target,
            "",
            "at least 1e-9 (the accuracy of the check) and below 1",
        )?;
        if let Some(deck) = &self.model.deck {
            let tolerance = deck.tie_tolerance.unwrap_or(0.0);
            check(
                tolerance.is_finite() && tolerance >= 0.0,
                "model.deck.tie_tolerance",
                tolerance,
                "m",
                "finite and not negative",
            )?;
            let size = |v: &[f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
            check(
                positive(size(&deck.along)),
                "model.deck.along",
                size(&deck.along),
                "(length of the vector)",
                "positive and finite",
            )?;
            let direction = size(&deck.response.direction);
            check(
                (direction - 1.0).abs() < 1e-6,
                "model.deck.response.direction",
                direction,
                "(length of the vector)",
                "a unit vector",
            )?;
            check(
                !deck.bolts.is_empty(),
                "model.deck.bolts",
                0.0,
                "(number of bolts)",
                "at least one",
            )?;
        }
        if self.model.symmetry == Symmetry::Half {
            let of_parts = match &self.surface {
                Surface::Measured => false,
                Surface::SyntheticScan(_) | Surface::Scans(_) => true,
                Surface::Parameters(parameters) => parameters.per != Per::Interface,
            };
            let asymmetric = [
                (self.model.deck.is_some(), "model.deck"),
                (self.model.matrices.is_some(), "model.matrices"),
                (of_parts, "the surface"),
                (self.gap != Gap::Flat, "the gap"),
            ];
            if let Some((_, what)) = asymmetric.into_iter().find(|(found, _)| *found) {
                return Err(Error::Symmetry {
                    place: place.into(),
                    what,
                });
            }
        }
        if let Surface::Parameters(Parameters { sets, .. }) = &self.surface {
            for (index, set) in sets.iter().enumerate() {
                let (mu, gap) = (set.mu.unwrap_or(0.0), set.gap);
                let at = format!("{place}: surface.parameters.sets, number {}", index + 1);
                let value = |field, value, unit| Error::Value {
                    place: at.clone(),
                    field,
                    value,
                    unit,
                    requirement: "finite and not negative",
                };
                if !(mu.is_finite() && mu >= 0.0) {
                    return Err(value("mu", mu, ""));
                }
                if !(gap.is_finite() && gap >= 0.0) {
                    return Err(value("gap", gap, "m"));
                }
            }
        }
        let damping = self.background_damping;
        check(
            (0.0..1.0).contains(&damping),
            "background_damping",
            damping,
            "",
            "at least 0 and below 1",
        )?;
        check(
            positive(c.amplitude_from),
            "cqsma.amplitude_from",
            c.amplitude_from,
            "m",
            "positive and finite",
        )?;
        check(
            c.amplitude_to.is_finite() && c.amplitude_to >= c.amplitude_from,
            "cqsma.amplitude_to",
            c.amplitude_to,
            "m",
            "finite and not below amplitude_from",
        )?;
        check(
            c.amplitudes <= 10_000,
            "cqsma.amplitudes",
            c.amplitudes as f64,
            "",
            "at most 10000",
        )?;
        check(
            (1..=100).contains(&c.modes),
            "cqsma.modes",
            c.modes as f64,
            "",
            "between 1 and 100",
        )?;
        check(
            (1..=c.modes).contains(&c.mode),
            "cqsma.mode",
            c.mode as f64,
            "",
            "between 1 and cqsma.modes",
        )?;
        let vertices = c.vertices_per_quarter;
        check(
            (1..=4096).contains(&vertices),
            "cqsma.vertices_per_quarter",
            vertices as f64,
            "",
            "between 1 and 4096",
        )?;
        if let Some(cycles) = c.cycles {
            check(
                (1..=1000).contains(&cycles),
                "cqsma.cycles",
                cycles as f64,
                "",
                "between 1 and 1000",
            )?;
        }
        if let Some(tolerance) = c.until_closed {
            check(
                (1e-12..=1.0).contains(&tolerance),
                "cqsma.until_closed",
                tolerance,
                "",
                "between 1e-12 (round-off) and 1",
            )?;
            check(
                c.cycles.is_none(),
                "cqsma.until_closed",
                tolerance,
                "",
                "left out where cqsma.cycles is given",
            )?;
        }
        check(
            (1e-13..=1e-2).contains(&c.tolerance),
            "cqsma.tolerance",
            c.tolerance,
            "",
            "between 1e-13 (round-off) and 1e-2",
        )?;
        for (index, method) in self.methods.iter().enumerate() {
            check(
                !self.methods[..index].contains(method),
                "methods",
                (index + 1) as f64,
                "(number in the list)",
                "different from the methods before it",
            )?;
        }
        for number in self.fields_at() {
            let ok = (1..=c.amplitudes).contains(&number);
            check(
                ok,
                "output.fields_at",
                number as f64,
                "",
                "numbers of amplitudes, between 1 and cqsma.amplitudes",
            )?;
        }
        if let Surface::Scans(scans) = &self.surface {
            for (field, value, unit, requirement, ok) in scans.requirements() {
                check(ok, field, value, unit, requirement)?;
            }
        }
        check(
            self.surface.is_scanned() || self.gap != Gap::Scan,
            "gap",
            f64::NAN,
            "(scan)",
            "`flat` or `measured` unless the surface is scanned",
        )
    }
}
