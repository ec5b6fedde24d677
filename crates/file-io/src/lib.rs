#![doc = include_str!("../README.md")]

pub mod durable;
pub mod input;
mod source;

pub use source::{Place, Source, quoted};
