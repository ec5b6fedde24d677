//! Errors of this crate: what cannot be started. Non-convergence is a status, not an error.

/// Why an analysis cannot be set up.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Vectors that do not fit together.
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
    /// An observer stopped the run.
    #[error("the run was interrupted before all points were done")]
    Interrupted,
}

pub(crate) fn require(ok: bool, field: &'static str, value: f64, requirement: &'static str) -> Result<(), Error> {
    if ok {
        Ok(())
    } else {
        Err(Error::Setting {
            field,
            value,
            requirement,
        })
    }
}
