//! Results as programs read them.

mod amplitudes;
pub mod answer;
pub mod provenance;
pub mod summary;
pub mod trends;
pub mod work;
