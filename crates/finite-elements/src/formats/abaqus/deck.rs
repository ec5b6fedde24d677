//! What a deck says, with all names resolved.

use crate::Error;
use crate::elements;
use crate::error::DeckProblem;
use crate::mesh::{Cell, Section};
use std::collections::BTreeMap;

/// A line of one of a deck's files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Line {
    /// Index into [`Deck::files`].
    pub file: u32,
    /// Line number, from one.
    pub number: u32,
}

/// A node or element number, and the instance it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Label {
    /// Index into [`Deck::instances`].
    pub instance: u32,
    /// Number in the deck.
    pub number: u32,
}

/// A node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Its name.
    pub label: Label,
    /// Global coordinates (m).
    pub at: [f64; 3],
    /// Where it is defined.
    pub line: Line,
}

/// A solid element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Its name.
    pub label: Label,
    /// Shape, and indices into [`Deck::nodes`].
    pub cell: Cell,
    /// Index into [`Deck::materials`], if a section gives it one.
    pub material: Option<u16>,
    /// Where it is defined.
    pub line: Line,
}

/// A beam.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckBeam {
    /// Its name.
    pub label: Label,
    /// Indices into [`Deck::nodes`], two or three, one behind the other.
    pub nodes: Vec<u32>,
    /// Its section, if it has one.
    pub section: Option<DeckBeamSection>,
    /// Where it is defined.
    pub line: Line,
}

/// Section of a beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckBeamSection {
    /// Shape and sizes (m).
    pub shape: Section,
    /// Index into [`Deck::materials`].
    pub material: u16,
    /// Direction of the first local axis.
    pub first: [f64; 3],
}

/// A pretension section.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckPretension {
    /// The node whose first component is the overlap at the section: index into [`Deck::nodes`].
    pub node: u32,
    /// What is cut.
    pub through: PretensionOf,
    /// Direction along which it is cut; by default that of the beam, or the mean normal of the surface.
    pub direction: Option<[f64; 3]>,
    /// Where it is defined.
    pub line: Line,
}

/// What a pretension section cuts.
#[derive(Clone, Debug, PartialEq)]
pub enum PretensionOf {
    /// A beam: index into [`Deck::beams`].
    Beam(u32),
    /// Solids at a surface of faces, named in [`Deck::surfaces`]. The direction points away from the elements of the faces.
    Surface(String),
}

/// A surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// What it is made of.
    pub members: Members,
    /// Where it is defined.
    pub line: Line,
}

/// What a surface is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Members {
    /// Indices into [`Deck::elements`], and face numbers from zero (`S1` is 0).
    Faces(Vec<(u32, u8)>),
    /// Indices into [`Deck::nodes`], and weights.
    Nodes(Vec<(u32, f64)>),
}

/// A material; what it lacks matters only if a section uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckMaterial {
    /// Name.
    pub name: String,
    /// Young's modulus (Pa) and Poisson ratio.
    pub elastic: Option<[f64; 2]>,
    /// Mass density (kg/m^3).
    pub density: Option<f64>,
    /// Where it is defined.
    pub line: Line,
}

/// A tie between two surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckTie {
    /// Name.
    pub name: String,
    /// Names of the slave and the master surface in [`Deck::surfaces`].
    pub surfaces: [String; 2],
    /// `POSITION TOLERANCE` (m).
    pub tolerance: Option<f64>,
    /// Whether slaves are moved onto the master surface.
    pub adjust: bool,
    /// Where it is defined.
    pub line: Line,
}

/// A coupling of a reference node.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckCoupling {
    /// Name.
    pub name: String,
    /// Reference node: index into [`Deck::nodes`].
    pub reference: u32,
    /// Cloud: indices into [`Deck::nodes`], and weights.
    pub nodes: Vec<(u32, f64)>,
    /// Who follows whom.
    pub kind: DeckCouplingKind,
    /// Where it is defined.
    pub line: Line,
}

/// Who follows whom in a coupling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeckCouplingKind {
    /// The reference node follows the weighted mean, except in the rotations that are `true`, which are free.
    Distributing([bool; 3]),
    /// The displacement components of the cloud that are `true` follow the reference node.
    Kinematic([bool; 3]),
}

/// Type of a rigid link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkKind {
    /// Displacement and rotation follow as if a rigid beam lay between.
    Beam,
    /// The distance stays.
    Link,
    /// Displacements are equal.
    Pin,
    /// All components are equal.
    Tie,
}

/// A line of `*MPC`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// Type.
    pub kind: LinkKind,
    /// The dependent node, then the other: indices into [`Deck::nodes`].
    pub nodes: [u32; 2],
    /// Where it is defined.
    pub line: Line,
}

/// A homogeneous equation.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckEquation {
    /// Node (index into [`Deck::nodes`]), component 0..6, coefficient.
    pub terms: Vec<(u32, u8, f64)>,
    /// Where it is defined.
    pub line: Line,
}

/// A spring to the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckSpring {
    /// Node: index into [`Deck::nodes`].
    pub node: u32,
    /// Displacement component 0..3.
    pub component: u8,
    /// Stiffness (N/m).
    pub stiffness: f64,
    /// Where its stiffness is given.
    pub line: Line,
}

/// A mass at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckMass {
    /// Node: index into [`Deck::nodes`].
    pub node: u32,
    /// Mass (kg).
    pub mass: f64,
    /// Where it is given.
    pub line: Line,
}

/// Inertia of rotation at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckInertia {
    /// Node: index into [`Deck::nodes`].
    pub node: u32,
    /// About the node in global axes (kg m^2).
    pub inertia: [[f64; 3]; 3],
    /// Where it is given.
    pub line: Line,
}

/// Values at nodes (indices into [`Deck::nodes`]) and components 0..6.
pub type AtComponents<T> = BTreeMap<(u32, u8), T>;

/// Loads: forces (N) or moments (N m), with the line that gives each.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadCase {
    /// Name of the substructure load case or load case; `None` for the step itself.
    pub name: Option<String>,
    /// Loads.
    pub loads: AtComponents<(f64, Line)>,
}

/// A step.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Name, or `Step-1` and so on.
    pub name: String,
    /// Keywords that choose the analysis. They are not run.
    pub procedures: Vec<Ignored>,
    /// Components that the step supports.
    pub supports: AtComponents<Line>,
    /// Loads.
    pub cases: Vec<LoadCase>,
    /// Where it begins.
    pub line: Line,
}

/// A keyword without influence on the model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ignored {
    /// Keyword in capitals.
    pub keyword: String,
    /// How often it occurs.
    pub count: usize,
    /// Where it occurs first.
    pub first_line: Line,
}

/// What a deck says, with all names resolved. Names of sets and surfaces are in capitals, those of instances
/// `INSTANCE.NAME`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deck {
    /// Names of the files: the deck, then those it includes.
    pub files: Vec<String>,
    /// Names of the instances in capitals; the first is empty and stands for the model itself.
    pub instances: Vec<String>,
    /// Nodes.
    pub nodes: Vec<Node>,
    /// Elements.
    pub elements: Vec<Solid>,
    /// Node sets: indices into `nodes`.
    pub node_sets: BTreeMap<String, Vec<u32>>,
    /// Element sets: indices into `elements`.
    pub element_sets: BTreeMap<String, Vec<u32>>,
    /// Surfaces.
    pub surfaces: BTreeMap<String, Surface>,
    /// Materials.
    pub materials: Vec<DeckMaterial>,
    /// Springs to the ground.
    pub springs: Vec<DeckSpring>,
    /// Masses at nodes.
    pub masses: Vec<DeckMass>,
    /// Inertia of rotation at nodes.
    pub inertias: Vec<DeckInertia>,
    /// Beams.
    pub beams: Vec<DeckBeam>,
    /// Pretension sections.
    pub pretensions: Vec<DeckPretension>,
    /// Ties.
    pub ties: Vec<DeckTie>,
    /// Couplings.
    pub couplings: Vec<DeckCoupling>,
    /// Rigid links.
    pub links: Vec<Link>,
    /// Equations.
    pub equations: Vec<DeckEquation>,
    /// Components that the model supports.
    pub supports: AtComponents<Line>,
    /// Steps.
    pub steps: Vec<Step>,
    /// Keywords that only ask for output, or act on what the model does not have.
    pub ignored: Vec<Ignored>,
    /// What else a user should know.
    pub notes: Vec<String>,
}

impl Deck {
    /// `12`, or `INSTANCE.12`.
    pub fn name(&self, label: Label) -> String {
        qualified(&self.instances[label.instance as usize], &label.number.to_string())
    }

    /// Checks that [`Quadratic`](crate::Quadratic) takes all elements.
    ///
    /// # Errors
    /// [`Error::Deck`] with [`DeckProblem::NotLinear`], of the first that is not linear.
    pub fn require_linear(&self) -> Result<(), Error> {
        let is_linear = |element: &&Solid| element.cell.element_type().quadratic().is_some();
        self.elements
            .iter()
            .find(|element| !is_linear(element))
            .map_or(Ok(()), |element| {
                let row = element.cell.element_type();
                let problem = DeckProblem::NotLinear {
                    element: self.name(element.label),
                    element_type: elements::to_abaqus(row, element.cell.formulation()).unwrap_or(row.name),
                };
                Err(self.error(element.line, problem))
            })
    }

    /// `file:line`.
    pub fn place(&self, line: Line) -> String {
        format!("{}:{}", self.files[line.file as usize], line.number)
    }

    pub(super) fn error(&self, line: Line, problem: DeckProblem) -> Error {
        Error::Deck {
            file: self.files[line.file as usize].clone(),
            line: line.number,
            problem,
        }
    }

    pub(super) fn node_name(&self, node: u32) -> String {
        self.name(self.nodes[node as usize].label)
    }
}

/// `NAME`, or `INSTANCE.NAME`.
pub(super) fn qualified(instance: &str, name: &str) -> String {
    match instance {
        "" => name.to_ascii_uppercase(),
        _ => format!("{instance}.{}", name.to_ascii_uppercase()),
    }
}
