//! Results as programs read them.

pub mod summary;
pub mod trends;
