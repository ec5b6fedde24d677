//! Errors of this crate.

/// What can be wrong with a mesh, its connections or the matrices made of them.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A material constant is outside its admissible range.
    #[error("material `{material}`: {field} = {value} {unit} is not admissible; it must be {requirement}")]
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
    #[error("equation `{equation}` is redundant: all its coefficients vanish once the other constraints are inserted")]
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
    /// A spring to the ground that cannot be one.
    #[error("ground spring {spring}: {reason}")]
    Spring {
        /// Its number.
        spring: usize,
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
    /// The symbolic or dense factorisation ran out of memory or did not converge.
    #[error("{operation} of a matrix of size {size} failed: {reason}")]
    LinearAlgebra {
        /// What was attempted.
        operation: &'static str,
        /// Size.
        size: usize,
        /// Library's reason.
        reason: String,
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
}
