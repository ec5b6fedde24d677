//! Analyses of structures that are given as matrices: `microslip.reduce`, `cqsma`, `epmc` and `transient`.

mod backbones;
mod matrices;
mod structure;
mod transient;

pub(crate) use backbones::{run_cqsma, run_epmc};
pub(crate) use structure::Structure;
pub(crate) use transient::run_transient;
