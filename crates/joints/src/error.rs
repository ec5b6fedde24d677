//! Errors of this crate.

use scenes::behind_semicolon;
use std::path::PathBuf;

/// Why a structure with its interface cannot be prepared.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene.
    #[error(transparent)]
    Scene(#[from] scenes::Error),
    /// The run was stopped by who started it.
    #[error("{}", cqsma_solver::Error::Interrupted)]
    Interrupted,
    /// A file could not be written.
    #[error("{}: {operation} failed", path.display())]
    File {
        /// File.
        path: PathBuf,
        /// What was attempted.
        operation: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
    /// A file could not be replaced safely.
    #[error(transparent)]
    Store(#[from] file_io::durable::Error),
    /// Shapes of a structure without a mesh.
    #[error(
        "mode shapes and deformed bodies need a mesh, and matrices have none; give the structure as a mesh, a deck or a benchmark"
    )]
    NoMesh,
    /// A deck whose elements cannot be made quadratic.
    #[error(
        "{}: its elements cannot be made quadratic: {source}; leave out model.element_order to take the elements as the deck has \
         them", deck.display()
    )]
    NotRaisable {
        /// The deck.
        deck: PathBuf,
        /// What stands in the way, and where.
        source: Box<finite_elements::Error>,
    },
    /// More memory than there is.
    #[error(
        "a reduced model of {coordinates} coordinates takes about {:.0} MB, and {:.0} MB are free for it; take a coarser mesh of the \
         interface, or allow more memory (`--memory`)", *needed as f64 / 1e6, *limit as f64 / 1e6
    )]
    Memory {
        /// Size of the reduced model.
        coordinates: usize,
        /// Estimate (bytes).
        needed: u64,
        /// What it may take (bytes).
        limit: u64,
    },
    /// The bolts cannot close the interface.
    #[error(
        "the bolt load of {load:.4e} N cannot be carried by the interface: even a closure of {closure:.3e} m carries only \
         {carried:.4e} N; check the gap, the law and the units"
    )]
    NoContact {
        /// Total bolt load (N).
        load: f64,
        /// Largest closure tried (m).
        closure: f64,
        /// Force carried there (N).
        carried: f64,
    },
    /// Faces that are nowhere near one another.
    #[error(
        "the smallest gap of the interface is {smallest:.3e} m, more than the interface's own size of {extent:.3e} m; check the \
         gap and its unit"
    )]
    GapBeyondFaces {
        /// Smallest gap (m).
        smallest: f64,
        /// Diagonal of the interface (m).
        extent: f64,
    },
    /// Two surfaces that cannot be an interface.
    #[error("the surfaces of the interface do not fit: {reason}")]
    Facing {
        /// What is wrong, and where.
        reason: String,
    },
    /// What a scene says of a mesh does not fit it.
    #[error("{}: {field}: {reason}", path.display())]
    MeshScene {
        /// The mesh.
        path: PathBuf,
        /// Field of the scene.
        field: String,
        /// What is wrong, and what would be accepted.
        reason: String,
    },
    /// Bolts of which nothing gives way.
    #[error(
        "{} forces without a bolt between them: no elongation can be held while other bolts are tightened, because only that of the clamped \
         parts is known; give it a shank with axial compliance (structure.mesh.bolts with `axis` and `size`, or a bolt in the mesh), or leave \
         out analyses.tightening", bolt.map_or_else(|| "a bolt is a pair of".to_owned(), |bolt| format!("bolt {bolt} is a pair of"))
    )]
    NoElongation {
        /// The bolt, counted from 1, where it is known.
        bolt: Option<usize>,
    },
    /// Parts of a structure that nothing connects.
    #[error(
        "the structure has {found} rigid motions with its interface stuck, and a connected one has six at most: tie its parts, add bolts or \
         interfaces between them, or remove what does not belong to it"
    )]
    Disconnected {
        /// Rigid motions.
        found: usize,
    },
    /// A base is to move that does not hold the structure.
    #[error(
        "{field} moves the supports, but {rigid_motions} rigid motions of the structure are free of them; hold it (structure.mesh.supports, \
         *BOUNDARY in a deck), or ask for a force"
    )]
    FreeBase {
        /// Field that asks for it.
        field: &'static str,
        /// Rigid motions.
        rigid_motions: usize,
    },
    /// A bolt that does not fit the mesh.
    #[error("bolt `{bolt}`: {reason}")]
    Bolt {
        /// Its name.
        bolt: String,
        /// What is wrong, and what would be accepted.
        reason: String,
    },
    /// Matrices that cannot be a structure with an interface.
    #[error("{}: {reason}", path.display())]
    Matrices {
        /// File or folder.
        path: PathBuf,
        /// What is wrong, and what would be right.
        reason: String,
    },
    /// Parameters of the law that do not fit the interface.
    #[error("interfaces.surface.parameters: {reason}")]
    Parameters {
        /// What is wrong, and where.
        reason: String,
    },
    /// A zone of friction that does not fit the interface.
    #[error("interfaces.friction_zones, number {number}: {reason}")]
    FrictionZone {
        /// From 1 on.
        number: usize,
        /// What is wrong, and where.
        reason: String,
    },
    /// A set that cannot name one node.
    #[error("{field} is one node, but the set `{set}` has {count}; name a node or a set of one")]
    NodeSet {
        /// Field of the scene.
        field: &'static str,
        /// Set.
        set: String,
        /// Its nodes.
        count: usize,
    },
    /// A position that no node is near.
    #[error(
        "structure.point_masses, number {number}: the node nearest to {position:?} m is at {nearest:?} m, {distance:.3e} m away and not \
         within {within:.3e} m; move the mass there, or allow the distance by `within`"
    )]
    NoNodeNear {
        /// Number of the mass, from 1.
        number: usize,
        /// Position given (m).
        position: [f64; 3],
        /// Position of the nearest node (m).
        nearest: [f64; 3],
        /// Distance between them (m).
        distance: f64,
        /// Distance allowed (m).
        within: f64,
    },
    /// A bolt that pulls the bodies apart, or acts along the interface.
    #[error(
        "bolt {bolt} does not close the interface: unit tension acts with {closing:.3e} N on a uniform closure, which should be \
         about 1, and with {sliding:.3e} N on a uniform sliding; exchange its two ends or the two sides, or correct the order \
         and signs of the components (x, y, normal from the top body into the bottom one)"
    )]
    OpeningLoad {
        /// Bolt, counted from 1.
        bolt: usize,
        /// Generalised force on a uniform closure at unit tension (-).
        closing: f64,
        /// The same on a uniform sliding.
        sliding: f64,
    },
    /// The modes that may be retained do not make the reduced model as accurate as asked for.
    #[error(
        "with {modes} modes the reduced model is within {error:.1e} of the full one, not within model.reduction_error = \
         {target:.1e}; raise model.modes or model.reduction_error"
    )]
    ReductionTarget {
        /// Error asked for.
        target: f64,
        /// Error reached.
        error: f64,
        /// Modes retained.
        modes: usize,
    },
    /// Samples of heights are asked for of a surface that has none.
    #[error(
        "the surface has no samples of heights to draw from: measured quantiles, roughness parameters and given parameters of the \
         law have none; describe it by interfaces.surface.scans or interfaces.surface.synthetic-scan"
    )]
    NoSamples,
    /// Boundary elements are asked for where they have no meaning.
    #[error("interfaces.law.kind = \"boundary-elements\" {reason}")]
    BoundaryElements {
        /// Why, and what to do.
        reason: &'static str,
    },
    /// No number of bins is exact enough.
    #[error(
        "interfaces.law.bins.error = {target:e}: 128 bins reach {reached:.1e}; ask for less, or give their number with \
         \"bins\": {{ \"gauss\": N }}"
    )]
    Bins {
        /// Relative error asked for.
        target: f64,
        /// Smallest error reached.
        reached: f64,
    },
    /// A scan that cannot be brought onto the interface.
    #[error("{}: {source}", path.display())]
    ScannedFace {
        /// File.
        path: PathBuf,
        /// Why not.
        source: surface_characterisation::SurfaceError,
    },
    /// A scan that cannot be read.
    #[error(transparent)]
    ScanFile(Box<surface_characterisation::FileError>),
    /// A benchmark that cannot be meshed as the scene asks for.
    #[error("{benchmark} cannot be meshed as the scene asks")]
    Benchmark {
        /// Name of the benchmark.
        benchmark: &'static str,
        /// Why not.
        source: joint_model::benchmark::BenchmarkError,
    },
    /// Finite elements.
    #[error(transparent)]
    Substructure(#[from] finite_elements::Error),
    /// Reduction.
    #[error(transparent)]
    Reduction(reduction::Error),
    /// A factorisation that would take more memory than there is.
    #[error("{0} (`--memory`)")]
    FactorMemory(finite_elements::Error),
    /// Matrix files.
    #[error(transparent)]
    MatrixFile(Box<matrix_files::Error>),
    /// Contact laws.
    #[error(transparent)]
    Law(#[from] contact_laws::Error),
    /// Surface characterisation.
    #[error(transparent)]
    Surface(#[from] surface_characterisation::SurfaceError),
    /// Interface elements.
    #[error(transparent)]
    Interface(#[from] zte_assembly::Error),
}

impl Error {
    /// The field of the scene that is wrong, with its path, where it is one.
    pub fn field(&self) -> Option<&str> {
        match self {
            Self::Scene(error) => error.field(),
            Self::MeshScene { field, .. } => Some(field),
            Self::Facing { reason } if reason.starts_with("structure.mesh.interfaces") => {
                Some("structure.mesh.interfaces")
            }
            Self::NodeSet { field, .. } | Self::FreeBase { field, .. } => Some(field),
            Self::NotRaisable { .. } => Some("model.element_order"),
            Self::Parameters { .. } => Some("interfaces.surface.parameters"),
            Self::Bolt { .. } => Some("structure.mesh.bolts"),
            Self::NoElongation { .. } => Some("analyses.tightening"),
            Self::FrictionZone { .. } => Some("interfaces.friction_zones"),
            Self::NoNodeNear { .. } => Some("structure.point_masses"),
            Self::ReductionTarget { .. } => Some("model.reduction_error"),
            Self::Bins { .. } => Some("interfaces.law.bins.error"),
            Self::NoSamples => Some("interfaces.surface"),
            Self::BoundaryElements { .. } => Some("interfaces.law.kind"),
            _ => None,
        }
    }

    /// Whether the run was stopped by who started it.
    pub fn is_interruption(&self) -> bool {
        matches!(
            self,
            Self::Interrupted
                | Self::Surface(surface_characterisation::SurfaceError::Interrupted)
                | Self::Substructure(finite_elements::Error::Interrupted)
                | Self::Reduction(reduction::Error::Substructure(finite_elements::Error::Interrupted))
        )
    }

    /// The value that is not admissible, with its unit, where it is a number.
    pub fn value(&self) -> Option<(f64, &'static str)> {
        match *self {
            Self::Scene(ref error) => error.value(),
            Self::ReductionTarget { target, .. } | Self::Bins { target, .. } => Some((target, "")),
            Self::GapBeyondFaces { smallest, .. } => Some((smallest, "m")),
            Self::Memory { needed, .. } => Some((needed as f64, "bytes")),
            Self::NoContact { load, .. } => Some((load, "N")),
            _ => None,
        }
    }

    /// What can be done about it, where the message says so: what would be accepted, or the part behind the semicolon.
    pub fn remedy(&self) -> Option<String> {
        match self {
            Self::Scene(error) => error.remedy(),
            _ => behind_semicolon(&self.to_string()),
        }
    }
}

impl From<file_io::input::Error> for Error {
    fn from(error: file_io::input::Error) -> Self {
        Self::Scene(error.into())
    }
}

impl From<surface_characterisation::FileError> for Error {
    fn from(error: surface_characterisation::FileError) -> Self {
        Self::ScanFile(Box::new(error))
    }
}

impl From<reduction::Error> for Error {
    fn from(error: reduction::Error) -> Self {
        match error {
            reduction::Error::Substructure(error @ finite_elements::Error::Memory { .. }) => Self::FactorMemory(error),
            error => Self::Reduction(error),
        }
    }
}

impl From<matrix_files::Error> for Error {
    fn from(error: matrix_files::Error) -> Self {
        Self::MatrixFile(Box::new(error))
    }
}
