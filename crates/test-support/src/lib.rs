//! What the tests of the workspace share.
#![doc = include_str!("../README.md")]

mod damage;
mod folders;
pub mod memory;

pub use damage::{Damage, Sample, Tally};
pub use folders::{TemporaryFolder, reference_file};
