//! From height maps of two faces to asperity populations, gaps and traction laws per interface element.
//!
//! The steps are `height map -> plane removed -> points of each element -> bilinear form and roughness -> peaks ->
//! asperities -> traction curves -> fits (28), (29)`. [`characterise()`] does all of them; each step is public on its
//! own. Equation numbers are those of Balaji, Chen and Brake, "Traction-based multi-scale nonlinear dynamic modeling
//! of bolted joints" (2020, doi 10.1016/j.ymssp.2020.106615), which describes the method. Where the published
//! form is one of several readings, the option enums list them, the default first.
//!
//! All quantities are SI. x runs along the interface, y across; heights point out of each body towards its mate.
#![doc = include_str!("../README.md")]

mod areal;
mod bootstrap;
mod boundary_elements;
mod characterise;
mod detrend;
mod error;
mod evolution;
mod face;
pub mod finish;
mod fits;
mod gap;
mod noise;
mod options;
mod pair;
mod partition;
mod peaks;
mod random;
pub mod readers;
mod registration;
mod registration_study;
mod resolution;
mod response;
mod scan;
mod statistics;
mod synthetic;
mod topography;
pub mod writers;

pub use areal::{ArealParameters, ArealPatch};
pub use bootstrap::{Bootstrap, CurveBands, TallestPeak, bootstrap_bands, realisation};
pub use boundary_elements::{BoundaryElements, Pressed, PressedElement};
pub use characterise::{Characterisation, ElementSurface, Summary, characterise, characterise_until};
pub use detrend::{Detrend, Plane, fit_plane, trend};
pub use error::{FileError, SurfaceError};
pub use evolution::{
    Correlation, CorrelationOptions, ElementField, Evolution, benjamini_hochberg, changes, correlate, p_as89,
    p_student, spearman,
};
pub use face::{AsperityCount, FaceAsperities, PackingHeight, packing_count};
pub use fits::{FitFallback, FitReport, NormalFitReport, TangentialFitReport, fit_normal, fit_tangential};
pub use gap::Bilinear;
pub use noise::{NoiseHandling, OutlierRule, gaussian_s_filter, without_outliers};
pub use options::{InterferenceRange, Options};
pub use pair::{HeightCombination, HeightFamily, PairAsperities, PairRadius};
pub use partition::{ElementOutlines, Partition};
pub use peaks::{LinePeak, RadiusStatistic, Summit, line_peaks, summits};
pub use registration::{Alignment, Registration, align};
pub use registration_study::{GapChange, registration_study};
pub use resolution::Resolution;
pub use response::{TractionCurves, traction_curves};
pub use scan::FaceSummary;
pub use statistics::median;
pub use synthetic::{SyntheticFace, Waviness};
pub use topography::{HeightData, HeightMap};
