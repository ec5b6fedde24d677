//! What the tests of the workspace share.
#![doc = include_str!("../README.md")]

mod damage;
mod documents;
mod folders;
pub mod memory;

pub use damage::{Damage, Sample, Tally};
pub use documents::Changes;
pub use folders::{TemporaryFolder, reference_file};
