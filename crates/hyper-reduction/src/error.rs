//! Errors of this crate.

/// Why a joint cannot be hyper-reduced.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No loop of the training dissipates: there is nothing to learn from.
    #[error(
        "none of the {loops} training loops dissipates; take amplitudes at which parts of the joint slip, or run the cases without \
         hyper-reduction"
    )]
    NothingSlips {
        /// Loops of the training.
        loops: usize,
    },
    /// The points allowed do not represent the training.
    #[error(
        "{points} of {of} quadrature points represent the forces of the training with a relative error of {reached:.1e}, beyond \
         {wanted:.0e}; train on cases that are more alike, or run them without hyper-reduction"
    )]
    TooFewPoints {
        /// Points selected.
        points: usize,
        /// Points of the interface.
        of: usize,
        /// Relative error reached.
        reached: f64,
        /// Relative error wanted.
        wanted: f64,
    },
    /// Loops that are followed in another way than the estimates of their errors assume.
    #[error(
        "errors are estimated for loops that are followed until they close, with their history committed at every vertex; leave cycles and commit as they are by default, or run the cases without hyper-reduction"
    )]
    Loops,
    /// A mode that was not learned.
    #[error("mode {mode} was not learned; learn from cases that follow it")]
    Mode {
        /// The mode, counted from 1.
        mode: usize,
    },
    /// Training modes or joints of another size.
    #[error("{what} has size {found}, but the joint needs {expected}")]
    Size {
        /// What.
        what: &'static str,
        /// Its size.
        found: usize,
        /// Size needed.
        expected: usize,
    },
    /// Of the loops.
    #[error(transparent)]
    Solver(#[from] cqsma_solver::Error),
}

impl From<dense_algebra::Error> for Error {
    fn from(error: dense_algebra::Error) -> Self {
        Self::Solver(error.into())
    }
}
