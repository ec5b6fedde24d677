//! What is kept between runs: reduced models, and the finished parts of a run under way.

pub mod cache;
pub mod checkpoint;
pub mod key;
mod options;

pub use options::Options;
