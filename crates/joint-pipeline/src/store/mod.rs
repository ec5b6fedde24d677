//! What is kept between runs: reduced models, and the finished parts of a run under way.

pub(crate) mod cache;
pub(crate) mod checkpoint;
pub(crate) mod key;
mod options;

pub use options::Options;
