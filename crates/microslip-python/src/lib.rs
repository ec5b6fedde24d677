//! The native half of the Python package `microslip`. What users see is the Python half, in `python/microslip`.

#![cfg(feature = "extension")]

use pyo3::prelude::*;

/// Functions and classes that the Python modules of the package are made of.
#[pymodule]
mod _native {
    use pyo3::prelude::*;

    /// The version of the package.
    #[pyfunction]
    fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }
}
