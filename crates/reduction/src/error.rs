//! Errors of this crate.

/// What can go wrong between a finite-element system and its reduced model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The two sides of the interface do not pair up.
    #[error(
        "the interface pairs {top} top nodes with {bottom} bottom nodes; every pair needs one of each, at least one pair"
    )]
    PairCount {
        /// Top nodes.
        top: usize,
        /// Bottom nodes.
        bottom: usize,
    },
    /// The nodes of a pair do not coincide.
    #[error(
        "interface pair {pair}: top node {top} and bottom node {bottom} are {distance:.3e} m apart, more than 1e-6 of the \
         interface's size; pair coinciding nodes"
    )]
    PairApart {
        /// Pair number.
        pair: usize,
        /// Top node.
        top: u32,
        /// Bottom node.
        bottom: u32,
        /// Distance (m).
        distance: f64,
    },
    /// What faces a node is not where the node is.
    #[error(
        "interface node {node} (number {pair} of the interface) is {distance:.3e} m from what faces it, and the weights of that sum \
         to {total}; they must sum to one and reproduce its place, within 1e-6 of the interface's size"
    )]
    FacingApart {
        /// Number of the node in the interface.
        pair: usize,
        /// Node.
        node: u32,
        /// Distance (m).
        distance: f64,
        /// Sum of the weights.
        total: f64,
    },
    /// A node belongs to two pairs, or to both sides.
    #[error(
        "interface pair {pair}: node {node} stands in an earlier pair or on both sides already; merge coinciding nodes of the \
         interface, and give every node once"
    )]
    PairTwice {
        /// Pair number.
        pair: usize,
        /// Node.
        node: u32,
    },
    /// An interface component depends on others through a constraint.
    #[error(
        "component {component} of interface node {node} is missing or made dependent by a support, tie, coupling or equation; \
         interface nodes must be free: take them out of it"
    )]
    DependentInterface {
        /// Node.
        node: u32,
        /// Component 0..3.
        component: u8,
    },
    /// Interface nodes are fixed in a direction that is no axis of the jump, or all of them in all directions.
    #[error(
        "component {component} of both nodes of interface pair {pair} is fixed, which leaves no jump to compute; interface \
         nodes may be fixed along axes of the interface's frame, and not all of them in all directions"
    )]
    FixedInterface {
        /// Pair number.
        pair: usize,
        /// Component 0..3.
        component: usize,
    },
    /// The local axes are not orthonormal.
    #[error("the interface axes are not orthonormal: their products differ from the identity by {deviation:.1e}")]
    Frame {
        /// Largest deviation.
        deviation: f64,
    },
    /// Matrices and vectors that do not belong together.
    #[error(
        "the {what} has {rows} rows and {columns} columns, but the stiffness has {n} rows; all must be square or vectors of \
         its size, with three jump coordinates per node of the interface"
    )]
    MatrixShape {
        /// Which.
        what: &'static str,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// Rows of the stiffness.
        n: usize,
    },
    /// A row of the matrices that cannot be an interface component.
    #[error(
        "row {row} is named twice as a component of the interface, or there are no more than {n} rows; name every row once"
    )]
    InterfaceRow {
        /// Row, counted from 0.
        row: usize,
        /// Rows that there are.
        n: usize,
    },
    /// Combinations of coordinates that cannot be the jump.
    #[error("the {rows} rows that give the jump depend on one another, so the jump cannot be a coordinate")]
    DependentJump {
        /// Rows.
        rows: usize,
    },
    /// The stuck structure has another number of zero-energy modes than the scene expects.
    #[error(
        "with the interface stuck the structure has {found} zero-energy modes, but {expected} were expected; more means an \
         unconnected part or a mechanism, fewer means a support"
    )]
    ZeroEnergyModes {
        /// Found.
        found: usize,
        /// Expected.
        expected: usize,
    },
    /// A load that would accelerate the free structure.
    #[error(
        "load `{load}` is not in equilibrium: {fraction:.1e} of it acts on the rigid-body motions of the free structure; \
         apply equal and opposite forces, or support the structure"
    )]
    UnbalancedLoad {
        /// Load name or number.
        load: String,
        /// Unbalanced part, relative.
        fraction: f64,
    },
    /// A load whose displacement cannot be held on its own.
    #[error(
        "load {load} does not deform the structure with a stuck interface independently of the other loads and the \
         retained modes, so its displacement cannot be locked; remove loads that repeat others or act on the interface \
         alone, or retain fewer modes"
    )]
    DependentLoad {
        /// Load number, counted from 0.
        load: usize,
    },
    /// A model without the flexibility at its loads.
    #[error(
        "the reduced model has {loads} loads but {attachment} attachment modes; locking the loads' displacements needs \
         one each: reduce with `attachment_modes`"
    )]
    NoAttachmentModes {
        /// Loads.
        loads: usize,
        /// Attachment modes.
        attachment: usize,
    },
    /// A model that was not made of the system and the settings given with it.
    #[error(
        "what the reduced model recovers differs by {deviation:.1e} from what the displacements of its system give; it was made of another \
         system or with other settings"
    )]
    OtherModel {
        /// Largest difference over the size of the terms that are summed.
        deviation: f64,
    },
    /// Columns of the reduced matrices from condensation and from solves differ, so neither is accurate enough.
    #[error(
        "columns of the reduced {matrix} from condensation and from solves differ by {asymmetry:.1e} of its largest entry; make \
         model.coupling_tolerance smaller if there is one, otherwise the model is too ill-conditioned"
    )]
    Asymmetry {
        /// Which matrix.
        matrix: &'static str,
        /// Relative asymmetry.
        asymmetry: f64,
    },
    /// A dense factorisation or eigenvalue decomposition of the reduced model failed.
    #[error("the reduced model: {0}")]
    Dense(#[from] dense_algebra::Error),
    /// The finite-element system.
    #[error(transparent)]
    Substructure(#[from] finite_elements::Error),
}
