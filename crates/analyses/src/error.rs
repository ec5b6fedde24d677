//! Errors of this crate.

use scenes::behind_semicolon;
use std::path::PathBuf;

/// Why a scene cannot be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene.
    #[error(transparent)]
    Scene(#[from] scenes::Error),
    /// The joint.
    #[error(transparent)]
    Joint(joints::Error),
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
    /// Derivatives that do not exist, or cannot be told.
    #[error("there are no derivatives of {of}; leave `sensitivities` out")]
    Derivatives {
        /// Of what, and why.
        of: &'static str,
    },
    /// A calibration that cannot be done.
    #[error("calibration: {reason}")]
    Calibration {
        /// Why, and what can be done.
        reason: String,
    },
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
    /// A random load that cannot be followed in time.
    #[error("analyses.random: {reason}")]
    Random {
        /// What is wrong, and what would be right.
        reason: String,
    },
    /// Levels that no element can be fitted to.
    #[error("equivalent element: {reason}")]
    Equivalent {
        /// What is wrong, and what would be right.
        reason: String,
    },
    /// A shock that cannot be followed.
    #[error("analyses.shock: {reason}")]
    Shock {
        /// What is wrong, and what would be right.
        reason: String,
    },
    /// A sweep that would take too long.
    #[error(
        "a sweep in time would take {steps:.3e} steps, and at most 1e7 are taken; sweep faster, or over fewer frequencies"
    )]
    Sweep {
        /// Steps of time.
        steps: f64,
    },
    /// A preload that has opened wherever it was.
    #[error(
        "nothing is in contact under prestress: the preload has pushed the faces apart, as nothing holds them together; give a \
         structure that does, or bolts with a load"
    )]
    NothingInContact,
    /// A step of tightening without equilibrium.
    #[error(
        "no equilibrium was found while bolt {bolt} was tightened in pass {pass} (residuals {history:?}): {reason}; tighten in more passes, \
         such as \"passes\": [0.3, 0.6, 1.0], or in more increments per step, \"increments\": 4, of analyses.tightening"
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
    /// A place for loops that is not on the interface.
    #[error("analyses.backbone.loops_at, number {number}: {reason}")]
    LoopPlace {
        /// From 1 on.
        number: usize,
        /// What is wrong, and what would be accepted.
        reason: String,
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
         where at most {limit:.0e} is accepted; ask for a smaller `analyses.backbone.tolerance`, or make a contact that is far stiffer than the \
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
         motion's share); choose a response point or direction that moves in it, or follow another mode"
    )]
    NoResponse {
        /// Mode, counted from 1.
        mode: usize,
        /// Its frequency (Hz).
        frequency: f64,
        /// Response of the mass-normalised mode times the root of the total mass.
        participation: f64,
    },
    /// Identification of a computed motion.
    #[error(transparent)]
    Identification(Box<modal_identification::Error>),
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
            Self::Scene(error) => error.field(),
            Self::Joint(error) => error.field(),
            Self::Derivatives { .. } => Some("sensitivities"),
            Self::BoltLoads { .. } => Some("bolts.loads"),
            Self::Tightening { .. } => Some("analyses.tightening"),
            Self::NoResponse { .. } => Some("analyses.modes.followed"),
            Self::Random { .. } => Some("analyses.random"),
            Self::Shock { .. } => Some("analyses.shock"),
            _ => None,
        }
    }

    /// Whether the run was stopped by who started it.
    pub fn is_interruption(&self) -> bool {
        match self {
            Self::Solver(cqsma_solver::Error::Interrupted) | Self::Periodic(harmonic_balance::Error::Interrupted) => {
                true
            }
            Self::Joint(error) => error.is_interruption(),
            _ => false,
        }
    }

    /// The value that is not admissible, with its unit, where it is a number.
    pub fn value(&self) -> Option<(f64, &'static str)> {
        match *self {
            Self::Scene(ref error) => error.value(),
            Self::Joint(ref error) => error.value(),
            Self::BoltLoads { given, .. } => Some((given as f64, "(values)")),
            Self::NoResponse { mode, .. } => Some((mode as f64, "")),
            _ => None,
        }
    }

    /// What can be done about it, where the message says so: what would be accepted, or the part behind the semicolon.
    pub fn remedy(&self) -> Option<String> {
        match self {
            Self::Scene(error) => error.remedy(),
            Self::Joint(error) => error.remedy(),
            Self::Prestress { .. } => None,
            _ => behind_semicolon(&self.to_string()),
        }
    }
}

impl From<joints::Error> for Error {
    fn from(error: joints::Error) -> Self {
        match error {
            joints::Error::Scene(error) => Self::Scene(error),
            // Whoever was asked, the same has happened.
            joints::Error::Interrupted => Self::Solver(cqsma_solver::Error::Interrupted),
            error => Self::Joint(error),
        }
    }
}

/// What the parts of a joint report is reported as an error of the joint.
macro_rules! of_the_joint {
    ($($error:ty),*) => {$(
        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                joints::Error::from(error).into()
            }
        }
    )*};
}

of_the_joint!(
    file_io::input::Error,
    finite_elements::Error,
    reduction::Error,
    matrix_files::Error,
    contact_laws::Error,
    surface_characterisation::SurfaceError,
    surface_characterisation::FileError,
    zte_assembly::Error
);

impl From<modal_identification::Error> for Error {
    fn from(error: modal_identification::Error) -> Self {
        Self::Identification(Box::new(error))
    }
}
