//! The native half of the Python package `microslip`. What users see is the Python half, in `python/microslip`.

#![cfg(feature = "extension")]

mod analyses;
mod arrays;
mod error;
mod formats;
mod laws;
mod records;
mod run;
mod scene;
mod surfaces;
mod work;

use pyo3::prelude::*;

/// Functions and classes that the Python modules of the package are made of.
#[pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::analyses::{Structure, run_cqsma, run_epmc, run_transient};
    #[pymodule_export]
    use crate::formats::{read_matrices, read_mesh, reduced_model, write_matrices, write_mesh};
    #[pymodule_export]
    use crate::laws::{Curves, Law, time_law};
    #[pymodule_export]
    use crate::records::{identify, misfit, read_record, synthetic_ring_down};
    #[pymodule_export]
    use crate::run::{Run, run};
    #[pymodule_export]
    use crate::scene::{Scene, benchmarks};
    #[pymodule_export]
    use crate::surfaces::{characterise, press, read_scan, synthetic_face, write_scan};

    /// The version of the package.
    #[pyfunction]
    fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }

    #[pymodule_init]
    fn init(_module: &Bound<'_, PyModule>) -> PyResult<()> {
        // Amplitudes and elements already run in parallel; threads within matrix kernels would only compete with them.
        faer::set_global_parallelism(faer::Par::Seq);
        Ok(())
    }
}
