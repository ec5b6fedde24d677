//! The commands of the program: arguments in, files out.
pub(crate) mod bench;
pub(crate) mod dist;
pub(crate) mod extremes;
pub(crate) mod paper;
pub(crate) mod tested;
pub(crate) mod trade;
pub(crate) mod validate;
