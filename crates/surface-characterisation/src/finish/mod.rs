//! From what a drawing or a roughness report says of two faces to asperities and traction laws, without a scan.
//!
//! A [`FaceReport`] (Ra, Rq, Rsm, skewness, ...) stands for a random face, [`FaceFinish`]; two of them and a patch are a
//! [`PairFinish`]. Two routes lead on:
//!
//! - the ensemble ([`PairFinish::characterised`]): synthesised pairs of patches go through [`crate::characterise()`] like scans;
//! - the theory ([`Theory`]): the same population in expectation, from the correlation at one and two grid steps.
//!
//! Either gives populations of realisations, and they a [`LawInterval`]. [`SpectralMoments`] are those of Nayak, with the
//! parameters of Greenwood and Williamson after McCool for comparison.

mod ensemble;
mod error;
mod face;
mod flatness;
mod interval;
mod sampled;
mod spectrum;
mod synthesis;
mod theory;
mod translation;

pub use ensemble::{PairFinish, patch_of_element};
pub use error::FinishError;
pub use face::{FaceFinish, FaceReport, Process};
pub use flatness::FlatnessForm;
pub use interval::{LEAST_REALISATIONS, LawInterval, PERCENTILES};
pub use spectrum::{IsotropicMoments, RSM_PER_LENGTH, SpectralMoments, Spectrum};
pub use synthesis::Synthesis;
pub use theory::Theory;
pub use translation::Translation;
