#![doc = include_str!("../README.md")]

pub mod bench;
mod elements;
pub mod extremes;
pub mod paper;
mod progress;
pub mod trade;

pub use progress::Display;
