//! Results as programs read them.

pub mod answer;
pub mod provenance;
pub mod summary;
pub mod trends;
