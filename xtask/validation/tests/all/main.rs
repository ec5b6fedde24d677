//! The tests of the public interface, in one program: one file for each subject.

#[path = "../../../../crates/microslip/tests/all/common/mod.rs"]
mod common;

mod dist;
mod documents;
mod extremes;
mod layering;
mod paper;
mod trade;

/// The program that they run.
const PROGRAM: &str = env!("CARGO_BIN_EXE_validation");
