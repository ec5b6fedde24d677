//! Errors of this crate.

use std::fmt;

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Position {
    /// Line of a text file, from 1.
    Line(usize),
    /// Byte of a binary file, from 0.
    Byte(usize),
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// What can be wrong with a mesh, its connections or the matrices made of them.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A factorisation that would take more memory than there is.
    #[error(
        "the factorisation of the {matrix} would take about {:.0} MB, and {:.0} MB are free for it; take a coarser mesh, or half of a \
         symmetric structure, or allow more memory", *needed as f64 / 1e6, *limit as f64 / 1e6
    )]
    Memory {
        /// What was to be factored.
        matrix: &'static str,
        /// Estimate (bytes).
        needed: u64,
        /// What it may take (bytes).
        limit: u64,
    },
    /// Whoever asked for the work has ended it.
    #[error("the run was interrupted")]
    Interrupted,
    /// A material constant is outside its admissible range.
    #[error("material `{material}`: {field} = {} is not admissible; it must be {requirement}", format!("{value} {unit}").trim_end())]
    Material {
        /// Material name.
        material: String,
        /// Constant.
        field: &'static str,
        /// Its value.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// A reference to something that does not exist.
    #[error("{place} refers to {what} {index}, but there are only {count}")]
    Dangling {
        /// Where the reference stands.
        place: String,
        /// What is referred to.
        what: &'static str,
        /// The number referred to.
        index: usize,
        /// How many exist.
        count: usize,
    },
    /// A coordinate or coefficient is NaN or infinite.
    #[error("{place}: {value} is not a finite number")]
    NotFinite {
        /// Where it stands.
        place: String,
        /// The value.
        value: f64,
    },
    /// An element is inverted or degenerate.
    #[error(
        "element {element}: Jacobian determinant {determinant:.3e} m^3 at integration point {point} is not positive; \
         check the node order (first face, then the face above it) and the node positions"
    )]
    InvertedElement {
        /// Element number.
        element: usize,
        /// Integration point.
        point: usize,
        /// Determinant (m^3).
        determinant: f64,
    },
    /// A node that nothing holds.
    #[error(
        "node {node} belongs to no element, and no constraint holds its component {component}; remove it from the mesh, or \
         give the elements that coincide with it there this node"
    )]
    LooseNode {
        /// Node.
        node: usize,
        /// Component 0..3.
        component: u8,
    },
    /// A slave node is too far from the surface it is tied to.
    #[error(
        "tie `{tie}`: slave node {node} is {distance:.3e} m from the master surface, beyond the position tolerance \
         {tolerance:.3e} m; move the node, or widen the tolerance"
    )]
    TieTooFar {
        /// Tie name.
        tie: String,
        /// Slave node.
        node: u32,
        /// Distance (m).
        distance: f64,
        /// Tolerance (m).
        tolerance: f64,
    },
    /// A displacement component is made dependent twice.
    #[error(
        "`{place}` makes component {component} of node {node} dependent, but it already is; remove one of the constraints"
    )]
    DependentTwice {
        /// Constraint name.
        place: String,
        /// Node.
        node: u32,
        /// Component 0..3.
        component: u8,
    },
    /// An equation adds nothing to the others, or constrains nothing.
    #[error(
        "equation `{equation}` is redundant: all its coefficients vanish once the other constraints are inserted; remove it, or the \
         support, tie, coupling or equation that holds its nodes already"
    )]
    RedundantEquation {
        /// Equation name.
        equation: String,
    },
    /// Constraints refer to one another in a circle.
    #[error("the constraints on component {component} of node {node} refer to themselves in a circle")]
    CircularConstraint {
        /// Node.
        node: u32,
        /// Component 0..3.
        component: u8,
    },
    /// A coupling whose weights or nodes cannot define a rigid motion.
    #[error("coupling `{coupling}`: {reason}")]
    Coupling {
        /// Coupling name.
        coupling: String,
        /// What is wrong.
        reason: &'static str,
    },
    /// A superelement that is no body, or does not fit the mesh.
    #[error("superelement `{superelement}`: {reason}")]
    Superelement {
        /// Its name.
        superelement: String,
        /// What is wrong.
        reason: String,
    },
    /// An element that cannot become quadratic.
    #[error("element {element} is a {element_type}; only linear elements (Hex8, Wedge6, Tet4) can be made quadratic")]
    NotLinear {
        /// Its number.
        element: usize,
        /// Its type.
        element_type: &'static str,
    },
    /// Part of an assembly whose meaning on quadratic elements is not known.
    #[error("{place} cannot be carried over to quadratic elements: {reason}")]
    NotRaisable {
        /// Which part.
        place: String,
        /// Why, and what to do.
        reason: &'static str,
    },
    /// A spring to the ground that cannot be one.
    #[error("ground spring {spring}: {reason}")]
    Spring {
        /// Its number.
        spring: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// A mass at a node that cannot be one.
    #[error("point mass {mass}: {reason}")]
    PointMass {
        /// Its number.
        mass: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// A shank that cannot be one.
    #[error("shank `{shank}`: {reason}")]
    Shank {
        /// Its name.
        shank: String,
        /// What is wrong.
        reason: &'static str,
    },
    /// A cut through a bolt that cannot be one.
    #[error("cut `{cut}`: {reason}")]
    Cut {
        /// Its name.
        cut: String,
        /// What is wrong.
        reason: &'static str,
    },
    /// A rigid body at a reference point that cannot be one.
    #[error("rigid mass {mass}: {reason}")]
    RigidMass {
        /// Its number.
        mass: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// A matrix that must be positive definite is not.
    #[error(
        "the {matrix} is not positive definite (pivot {pivot} of {size}); an unconnected part or a missing support \
         leaves it singular"
    )]
    NotPositiveDefinite {
        /// Which matrix.
        matrix: &'static str,
        /// Pivot at which the factorisation stopped.
        pivot: usize,
        /// Size.
        size: usize,
    },
    /// The eigensolver did not reach its tolerance.
    #[error(
        "{converged} of {wanted} eigenpairs reached the residual tolerance {tolerance:.1e} with {vectors} vectors \
         (worst residual {worst:.1e}); ask for fewer modes or allow more vectors"
    )]
    EigenNotConverged {
        /// Pairs converged.
        converged: usize,
        /// Pairs asked for.
        wanted: usize,
        /// Tolerance.
        tolerance: f64,
        /// Size of the subspace at the end.
        vectors: usize,
        /// Largest residual among the wanted.
        worst: f64,
    },
    /// A small dense problem inside the eigensolver failed.
    #[error(transparent)]
    Dense(#[from] dense_algebra::Error),
    /// The file of a deck or mesh cannot be read, is not a regular file, or is too large.
    #[error(transparent)]
    InputFile(#[from] file_io::input::Error),
    /// A deck cannot be understood, or holds what is not supported.
    #[error("{file}:{line}: {problem}")]
    Deck {
        /// File name.
        file: String,
        /// Line number, from one.
        line: u32,
        /// What is wrong there.
        problem: DeckProblem,
    },
    /// A name that a deck does not define.
    #[error("the deck has no {what} `{name}`; it has {known}")]
    NotInDeck {
        /// Kind of thing.
        what: &'static str,
        /// Name asked for.
        name: String,
        /// Some of the names it has.
        known: String,
    },
    /// An assembly that no deck can express.
    #[error("{place} cannot be written to a deck: {reason}")]
    NotWritable {
        /// Which part of it.
        place: String,
        /// Why, and what to do.
        reason: &'static str,
    },
    /// A mesh file breaks its format.
    #[error("{file}, {at}: expected {expected}, found {found}; save the mesh again, or correct it there")]
    MeshSyntax {
        /// File name.
        file: String,
        /// Where.
        at: Position,
        /// What the format asks for.
        expected: String,
        /// What stands there.
        found: String,
    },
    /// A mesh file holds what cannot be read and must not be dropped.
    #[error("{file}, {at}: {what} cannot be read; {remedy}")]
    MeshUnsupported {
        /// File name.
        file: String,
        /// Where.
        at: Position,
        /// What it holds.
        what: String,
        /// How to avoid it.
        remedy: std::borrow::Cow<'static, str>,
    },
    /// A mesh file contradicts itself or what it is read with.
    #[error("{file}, {at}: {problem}; {remedy}")]
    MeshContents {
        /// File name.
        file: String,
        /// Where.
        at: Position,
        /// What is wrong.
        problem: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A mesh file has another format than those that are read, or cannot be read in one whose places have no numbers.
    #[error("{file}: {problem}; {remedy}")]
    MeshFormat {
        /// File.
        file: String,
        /// What it is.
        problem: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Solids of a mesh file that no structure can be made of.
    #[error("{file}: elements {cells} {problem}; {remedy}")]
    MeshCells {
        /// File name.
        file: String,
        /// The file's numbers of the first of them, and how many more there are.
        cells: String,
        /// What is wrong with them.
        problem: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A named group of a mesh file that is not what it is used as.
    #[error("{file}, group `{group}`: {problem}; {remedy}")]
    MeshGroup {
        /// File name.
        file: String,
        /// Name of the group.
        group: String,
        /// What is wrong with it.
        problem: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A name that a mesh file does not define.
    #[error("{file} has no {what} `{name}`; it has {known}")]
    NotInMesh {
        /// File name.
        file: String,
        /// Kind of thing.
        what: &'static str,
        /// Name asked for.
        name: String,
        /// Some of the names it has.
        known: String,
    },
    /// A mesh file cannot carry what is to be written.
    #[error("{what} cannot be written: {reason}")]
    MeshUnwritable {
        /// What.
        what: String,
        /// Why, and what would be accepted.
        reason: String,
    },
}

/// The first of the names that there are, for messages.
pub(crate) fn known_names<'n>(names: impl ExactSizeIterator<Item = &'n str>) -> String {
    const SHOWN: usize = 12;
    let count = names.len();
    let mut known: Vec<&str> = names.take(SHOWN).collect();
    match count {
        0 => known.push("none"),
        1..=SHOWN => {}
        _ => known.push("..."),
    }
    known.join(", ")
}

/// What can be wrong at a line of a deck.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DeckProblem {
    /// The line does not follow the rules of decks.
    #[error("`{found}`: {reason}")]
    Syntax {
        /// The line, or the part of it.
        found: String,
        /// What is wrong.
        reason: &'static str,
    },
    /// An included file cannot be taken in.
    #[error("*INCLUDE of `{path}`: {reason}")]
    Include {
        /// The file.
        path: String,
        /// Why not.
        reason: String,
    },
    /// A line of a file outside the deck's folder. What is wrong with it is not said, because that would show the line.
    #[error(
        "the line is not one that a deck may hold there; the file is outside the deck's folder, so that nothing of it is \
         quoted: copy it into the folder for a full message"
    )]
    NotQuoted,
    /// A keyword that changes the mechanics and is not supported, or stands where it may not.
    #[error("*{keyword} is not supported here: {remedy}")]
    Keyword {
        /// The keyword.
        keyword: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A parameter, or its value, that is not supported.
    #[error("*{keyword}: parameter `{parameter}` is not supported: {remedy}")]
    Parameter {
        /// The keyword.
        keyword: String,
        /// The parameter, with its value if any.
        parameter: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A parameter is missing.
    #[error("*{keyword} needs the parameter {parameter}")]
    MissingParameter {
        /// The keyword.
        keyword: String,
        /// The parameter.
        parameter: &'static str,
    },
    /// An element type that is not supported.
    #[error("element type `{found}` is not supported; use one of {known} (MASS, SPRING1, DCOUP3D)")]
    ElementType {
        /// The type.
        found: String,
        /// Types of solids that are supported.
        known: String,
    },
    /// A constraint type that is not supported.
    #[error("*MPC type `{found}` is not supported; use BEAM, LINK, PIN or TIE, or *EQUATION")]
    MpcType {
        /// The type.
        found: String,
    },
    /// An entry that is not what is expected.
    #[error("{what} = `{found}` is not admissible; it must be {requirement}")]
    Value {
        /// Which entry.
        what: &'static str,
        /// The entry.
        found: String,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// A wrong number of things.
    #[error("{what}: {found} given, {expected} needed")]
    Count {
        /// What is counted.
        what: String,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// Something is named that the deck does not define.
    #[error("{what} `{name}` is not defined; define it, or correct the name")]
    Undefined {
        /// Kind of thing.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// Something is defined, or made dependent, twice.
    #[error("{what} `{name}` appeared before, at {first}; remove one of the two")]
    Duplicate {
        /// Kind of thing.
        what: &'static str,
        /// Its name.
        name: String,
        /// Where it stood first.
        first: String,
    },
    /// A set or surface holds nothing.
    #[error("{what} `{name}` is empty; fill it, or remove it with its uses")]
    Empty {
        /// Kind of thing.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// A node follows two constraints.
    #[error(
        "component {component} of node {node} follows both {second} and {first}; take the node out of one of the two"
    )]
    DependentTwice {
        /// The node.
        node: String,
        /// Displacement component, from one.
        component: u8,
        /// The earlier constraint and its place.
        first: String,
        /// The later one.
        second: String,
    },
    /// An element that cannot become quadratic.
    #[error(
        "element {element} is a {element_type}; only linear elements can be made quadratic: mesh all bodies with linear elements, or all with quadratic ones"
    )]
    NotLinear {
        /// The element.
        element: String,
        /// What decks call its type.
        element_type: &'static str,
    },
    /// An element belongs to no section.
    #[error("element {element} has no *SOLID SECTION; give its element set one")]
    NoSection {
        /// The element.
        element: String,
    },
    /// A component is used that a node does not have.
    #[error("node {node} has no component {component} to use in {place}: {reason}")]
    NoSuchComponent {
        /// The node.
        node: String,
        /// Component, from one.
        component: u8,
        /// What uses it.
        place: &'static str,
        /// Why it has none.
        reason: &'static str,
    },
    /// Sets and copies hold far more than the text suggests.
    #[error("sets, surfaces and copies hold more than {limit} members by this line, too many for a deck of this size")]
    TooLarge {
        /// The limit.
        limit: usize,
    },
}
