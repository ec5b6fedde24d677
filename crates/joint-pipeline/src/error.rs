//! Errors of this crate.

use std::path::PathBuf;

/// Why a scene cannot be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read, is not a regular file, or is too large.
    #[error(transparent)]
    InputFile(#[from] file_io::input::Error),
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
    /// An input is not the one that a run read.
    #[error(
        "{}: is not the file that the results were computed from (SHA-256 {found} instead of {expected}); restore it, or run the \
         scene again", path.display()
    )]
    InputChanged {
        /// File.
        path: PathBuf,
        /// Its SHA-256 then.
        expected: String,
        /// Its SHA-256 now.
        found: String,
    },
    /// A scene is not valid JSON, misses a mandatory block or has an unknown field.
    #[error("{place}: {message}")]
    Syntax {
        /// File name of the scene.
        place: String,
        /// Field with its path, where it is one that is wrong.
        field: Option<String>,
        /// Message with line and column, naming the field.
        message: String,
    },
    /// A value of a scene is outside its range.
    #[error("{place}: {field} = {} is not admissible; it must be {requirement}", quantity(*value, unit))]
    Value {
        /// File name of the scene.
        place: String,
        /// Field with its path.
        field: &'static str,
        /// Value as given.
        value: f64,
        /// Unit.
        unit: &'static str,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// A path that is asked for as a parameter is no number of the scene that can be varied.
    #[error("{path} is not a parameter of this scene: {reason}")]
    Parameter {
        /// The path.
        path: String,
        /// Why, and what can be done.
        reason: String,
    },
    /// Derivatives that do not exist, or cannot be told.
    #[error("there are no derivatives of {of}; leave `sensitivities` out")]
    Derivatives {
        /// Of what, and why.
        of: &'static str,
    },
    /// Uncertain inputs that cannot be sampled.
    #[error("uncertain.{field}: {reason}")]
    Uncertain {
        /// Field within `uncertain`.
        field: String,
        /// Why, and what can be done.
        reason: String,
    },
    /// A calibration that cannot be done.
    #[error("calibration: {reason}")]
    Calibration {
        /// Why, and what can be done.
        reason: String,
    },
    /// Shapes of a structure without a mesh.
    #[error(
        "mode shapes and deformed bodies need a mesh, and matrices have none; give the structure as a mesh, a deck or a benchmark"
    )]
    NoMesh,
    /// Bodies or asperities of a material that nothing says anything about.
    #[error(
        "model.material is missing, and bodies or asperities are made of it; add for example \"model\": {{ \"material\": {{ \
         \"youngs_modulus\": \"200 GPa\", \"poisson_ratio\": 0.3, \"density\": \"7850 kg/m^3\" }} }}"
    )]
    NoMaterial,
    /// The scene is as fine as the finest measured settings.
    #[error(
        "no measured set of settings is finer than the scene's, so that its error cannot be estimated; choose a coarser mesh, fewer \
         modes or fewer vertices"
    )]
    NothingFiner,
    /// A structure whose mesh cannot be judged by a second formulation of its elements.
    #[error(
        "{place}: the error of the mesh cannot be estimated from two formulations: {what}; --estimate-error settings \
         compares with finer settings instead"
    )]
    OneFormulation {
        /// Name of the scene.
        place: String,
        /// What stands in the way, and what can be done about it.
        what: &'static str,
    },
    /// A formulation that the hexahedra of an order do not have.
    #[error(
        "{place}: model.formulation = {formulation} is none of hexahedra with model.element_order = {order}; choose one of {offered}, \
         or leave it out"
    )]
    NoSuchFormulation {
        /// File name of the scene.
        place: String,
        /// Order of the elements.
        order: String,
        /// Formulation asked for.
        formulation: String,
        /// Formulations on offer.
        offered: String,
    },
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
    /// Half of a scene that need not be symmetric.
    #[error(
        "{place}: {what} need not be symmetric about y = 0, so that the half cannot stand for the whole; leave out \
         model.symmetry = half, or take the block mesh with flat faces and one law everywhere"
    )]
    Symmetry {
        /// File name of the scene.
        place: String,
        /// What need not be symmetric.
        what: &'static str,
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
    /// Points of contact whose law would follow from faces.
    #[error(
        "{place}: points of contact have no faces whose asperities could be known; give the parameters of their law as \
         surface.parameters"
    )]
    PointsWithoutParameters {
        /// Scene.
        place: String,
    },
    /// A preload that has opened wherever it was.
    #[error(
        "nothing is in contact under prestress: the preload has pushed the faces apart, as nothing holds them together; give a \
         structure that does, or bolts with a load"
    )]
    NothingInContact,
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
    /// A step of tightening without equilibrium.
    #[error(
        "no equilibrium was found while bolt {bolt} was tightened in pass {pass} (residuals {history:?}): {reason}; tighten in more passes, \
         such as \"passes\": [0.3, 0.6, 1.0], or in more increments per step, \"increments\": 4, of bolts.tightening"
    )]
    Tightening {
        /// Pass, counted from 1.
        pass: usize,
        /// Bolt, counted from 1.
        bolt: usize,
        /// Why the solve gave up.
        reason: cqsma_solver::Reason,
        /// Residuals relative to the load.
        history: Vec<f64>,
    },
    /// Bolts of which nothing gives way.
    #[error(
        "{} forces without a bolt between them: no elongation can be held while other bolts are tightened, because only that of the clamped \
         parts is known; give it a shank with axial compliance (structure.mesh.bolts with `axis` and `size`, or a bolt in the mesh), or leave \
         out bolts.tightening", bolt.map_or_else(|| "a bolt is a pair of".to_owned(), |bolt| format!("bolt {bolt} is a pair of"))
    )]
    NoElongation {
        /// The bolt, counted from 1, where it is known.
        bolt: Option<usize>,
    },
    /// Bolts of a sequence that are not those of the structure.
    #[error("bolts.tightening.order {reason}; the structure has {bolts} bolts, so write for example \"order\": {}", in_turn(*bolts))]
    TighteningOrder {
        /// What is wrong.
        reason: String,
        /// Bolts there are.
        bolts: usize,
    },
    /// Another number of bolts than the structure has.
    #[error(
        "bolts.loads has {given} values, and the structure has {bolts} bolts; give one for each, in their order, or bolts.load for all"
    )]
    BoltLoads {
        /// Values given.
        given: usize,
        /// Bolts there are.
        bolts: usize,
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
    /// A bolt that does not fit the mesh.
    #[error("bolt `{bolt}`: {reason}")]
    Bolt {
        /// Its name.
        bolt: String,
        /// What is wrong, and what would be accepted.
        reason: String,
    },
    /// A size of bolts that is not in the table.
    #[error("`{name}` is no size of metric bolts: {reason}")]
    BoltSize {
        /// What was given.
        name: String,
        /// What would be accepted.
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
    #[error("surface.parameters: {reason}")]
    Parameters {
        /// What is wrong, and where.
        reason: String,
    },
    /// A place for loops that is not on the interface.
    #[error("cqsma.loops_at, number {number}: {reason}")]
    LoopPlace {
        /// From 1 on.
        number: usize,
        /// What is wrong, and what would be accepted.
        reason: String,
    },
    /// A zone of friction that does not fit the interface.
    #[error("friction_zones, number {number}: {reason}")]
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
    /// The prestress did not converge; there is nothing to linearise about.
    #[error("the prestress did not converge: {reason}; relative residuals {history:?}")]
    Prestress {
        /// Why it gave up.
        reason: cqsma_solver::Reason,
        /// Residuals per iteration.
        history: Vec<f64>,
    },
    /// The forces of the prestress, evaluated anew, are out of balance: nothing that follows from it can be believed.
    #[error(
        "the prestress is out of balance: the residual forces at the interface add up to {residual_ratio:.1e} of the loads there, \
         where at most {limit:.0e} is accepted; ask for a smaller `cqsma.tolerance`, or make a contact that is far stiffer than the \
         structure softer"
    )]
    Unbalanced {
        /// Sum of the magnitudes of the residual forces over that of the loads.
        residual_ratio: f64,
        /// Largest that is accepted.
        limit: f64,
    },
    /// The mode does not move the response point, so amplitudes there say nothing about it.
    #[error(
        "mode {mode} ({frequency:.2} Hz) hardly moves the response point in its direction ({participation:.1e} of a rigid \
         motion's share); follow another mode"
    )]
    NoResponse {
        /// Mode, counted from 1.
        mode: usize,
        /// Its frequency (Hz).
        frequency: f64,
        /// Response of the mass-normalised mode times the root of the total mass.
        participation: f64,
    },
    /// Roughness parameters that describe no face, or a pair of faces of which no patch can be made.
    #[error("{place}: {field}: {source}")]
    Finish {
        /// File name of the scene.
        place: String,
        /// Face, or the pair.
        field: String,
        /// What is wrong with it.
        source: Box<surface_characterisation::finish::FinishError>,
    },
    /// Samples of heights are asked for of a surface that has none.
    #[error(
        "the surface has no samples of heights to draw from: measured quantiles, roughness parameters and given parameters of the \
         law have none; describe it by surface.scans or surface.synthetic-scan"
    )]
    NoSamples,
    /// No number of bins is exact enough.
    #[error(
        "law.bins.error = {target:e}: 128 bins reach {reached:.1e}; ask for less, or give their number with \
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
        source: crate::joint::benchmark::BenchmarkError,
    },
    /// A measured surface is asked for where none is known.
    #[error(
        "{place}: {field} asks for a measured surface, and the structure has none; name the benchmark whose surface is meant, \
         {{ \"benchmark\": NAME }}, or describe the faces by scans or parameters"
    )]
    NoMeasuredSurface {
        /// File name of the scene.
        place: String,
        /// Field of the scene.
        field: &'static str,
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
    /// Identification of a computed motion.
    #[error(transparent)]
    Identification(Box<modal_identification::Error>),
    /// A setting of a computed motion outside its range.
    #[error("{field} = {} is not admissible; it must be {requirement}", quantity(*value, unit))]
    Motion {
        /// Setting.
        field: &'static str,
        /// Value.
        value: f64,
        /// Unit.
        unit: &'static str,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// A motion that could not be followed to where it was to be identified.
    #[error(
        "the motion could not be followed beyond {time:.4e} s of {wanted:.4e} s: {reason}; relative residuals {history:?}; take more steps per period"
    )]
    Transient {
        /// Time reached (s).
        time: f64,
        /// Time asked for (s).
        wanted: f64,
        /// Why it ended.
        reason: cqsma_solver::Reason,
        /// Residuals of the last attempt.
        history: Vec<f64>,
    },
    /// Backbones that cannot be compared.
    #[error("{what}")]
    Comparison {
        /// What is wrong, and what would be right.
        what: String,
    },
    /// Solver.
    #[error(transparent)]
    Solver(#[from] cqsma_solver::Error),
    /// Joints with few coordinates and few points.
    #[error(transparent)]
    HyperReduction(#[from] hyper_reduction::Error),
    /// Harmonic balance.
    #[error(transparent)]
    Periodic(#[from] harmonic_balance::Error),
}

impl Error {
    /// The field of the scene that is wrong, with its path, where it is one.
    pub fn field(&self) -> Option<&str> {
        match self {
            Self::Syntax { field, .. } => field.as_deref(),
            Self::MeshScene { field, .. } => Some(field),
            Self::Parameter { path, .. } => Some(path),
            Self::Derivatives { .. } => Some("sensitivities"),
            Self::Uncertain { field, .. } => Some(field),
            Self::Value { field, .. }
            | Self::NodeSet { field, .. }
            | Self::NoMeasuredSurface { field, .. }
            | Self::Motion { field, .. } => Some(field),
            Self::NoSuchFormulation { .. } => Some("model.formulation"),
            Self::NotRaisable { .. } => Some("model.element_order"),
            Self::Symmetry { .. } => Some("model.symmetry"),
            Self::PointsWithoutParameters { .. } | Self::Parameters { .. } => Some("surface.parameters"),
            Self::Bolt { .. } => Some("structure.mesh.bolts"),
            Self::BoltLoads { .. } => Some("bolts.loads"),
            Self::Tightening { .. } | Self::NoElongation { .. } => Some("bolts.tightening"),
            Self::TighteningOrder { .. } => Some("bolts.tightening.order"),
            Self::FrictionZone { .. } => Some("friction_zones"),
            Self::NoNodeNear { .. } => Some("structure.point_masses"),
            Self::ReductionTarget { .. } => Some("model.reduction_error"),
            Self::Bins { .. } => Some("law.bins.error"),
            Self::NoSamples => Some("surface"),
            Self::NoMaterial => Some("model.material"),
            Self::Finish { field, .. } => Some(field),
            Self::NoResponse { .. } => Some("cqsma.mode"),
            _ => None,
        }
    }

    /// Whether the run was stopped by who started it.
    pub fn is_interruption(&self) -> bool {
        matches!(
            self,
            Self::Solver(cqsma_solver::Error::Interrupted)
                | Self::Periodic(harmonic_balance::Error::Interrupted)
                | Self::Surface(surface_characterisation::SurfaceError::Interrupted)
                | Self::Substructure(finite_elements::Error::Interrupted)
                | Self::Reduction(reduction::Error::Substructure(finite_elements::Error::Interrupted))
        )
    }

    /// The value that is not admissible, with its unit, where it is a number.
    pub fn value(&self) -> Option<(f64, &'static str)> {
        match *self {
            Self::Value { value, unit, .. } | Self::Motion { value, unit, .. } => Some((value, unit)),
            Self::BoltLoads { given, .. } => Some((given as f64, "(values)")),
            Self::NoResponse { mode, .. } => Some((mode as f64, "")),
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
            Self::Value { requirement, .. } | Self::Motion { requirement, .. } => {
                Some(format!("it must be {requirement}"))
            }
            Self::Prestress { .. } => None,
            _ => {
                let message = self.to_string();
                message.split_once("; ").map(|(_, remedy)| remedy.to_owned())
            }
        }
    }
}

/// The numbers of all bolts.
fn in_turn(bolts: usize) -> String {
    format!("{:?}", (1..=bolts).collect::<Vec<_>>())
}

/// A value with its unit, if it has one, in a few digits.
fn quantity(value: f64, unit: &str) -> String {
    let number = match value.abs() {
        size if size >= 1e12 && size.is_finite() => format!("{value:e}"),
        _ => value.to_string(),
    };
    format!("{number} {unit}").trim_end().to_owned()
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

impl From<modal_identification::Error> for Error {
    fn from(error: modal_identification::Error) -> Self {
        Self::Identification(Box::new(error))
    }
}

impl From<matrix_files::Error> for Error {
    fn from(error: matrix_files::Error) -> Self {
        Self::MatrixFile(Box::new(error))
    }
}
