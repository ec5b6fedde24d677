#![doc = include_str!("../README.md")]

mod case;
mod design;
mod error;
mod parquet_table;
mod plan;
mod report;
mod run;
pub mod slurm;
mod store;
mod study;
mod table;
mod training;

pub use case::Part;
pub use design::{Column, Kind};
pub use error::Error;
pub use plan::{Base, Design, HyperReduction, Listed, Parameter, Plan, Sample, Spacing, schema};
pub use report::outputs;
pub use run::{Machine, Memory, Tally, run};
pub use store::{Record, Store};
pub use study::{BaseScene, Counts, Study};
pub use table::{CSV, PARQUET};
