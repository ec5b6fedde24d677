//! Errors of this crate: what cannot be started. Non-convergence is a status, not an error.

/// Why an analysis cannot be set up.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Matrices or vectors that do not fit together.
    #[error("{what} has size {found}, but the structure needs {expected}")]
    Size {
        /// What.
        what: &'static str,
        /// Its size.
        found: usize,
        /// Size needed.
        expected: usize,
    },
    /// A setting outside its range.
    #[error("{field} = {value} is not admissible; it must be {requirement}")]
    Setting {
        /// Setting.
        field: &'static str,
        /// Value.
        value: f64,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// The stuck structure is not positive definite, or its modes cannot be computed.
    #[error(
        "the stiffness with the stuck interface: {0}; if it is not positive definite, the structure can move freely or the \
         interface is open where it must carry the load"
    )]
    Dense(#[from] dense_algebra::Error),
    /// An observer stopped the run.
    #[error("the run was interrupted before all amplitudes were done")]
    Interrupted,
}

pub(crate) fn check_size(what: &'static str, found: usize, expected: usize) -> Result<(), Error> {
    if found == expected {
        Ok(())
    } else {
        Err(Error::Size { what, found, expected })
    }
}
