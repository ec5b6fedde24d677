#![doc = include_str!("../README.md")]

mod error;
pub mod interface;
pub mod progress;
pub mod store;
pub mod structure;

pub use error::Error;
pub use store::Options;
