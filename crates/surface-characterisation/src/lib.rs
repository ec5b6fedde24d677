//! From height maps of two faces to asperity populations, gaps and traction laws per interface element.
//!
//! The road is `height map -> plane removed -> points of each element -> bilinear form and roughness -> peaks ->
//! asperities -> traction curves -> fits (28), (29)`. [`characterise`] walks all of it; each step is public on its
//! own. Equation numbers are those of Balaji, Chen and Brake, "Traction-based multi-scale nonlinear dynamic modeling
//! of bolted joints" (2020, doi 10.1016/j.ymssp.2020.106615), where the road was laid; where the published
//! form is one of several readings, the option enums list them, the default first.
//!
//! All quantities are SI. x runs along the interface, y across; heights point out of each body towards its mate.
#![doc = include_str!("../README.md")]

mod areal;
mod asperities;
mod characterise;
mod detrend;
mod error;
mod evolution;
mod fits;
mod gap;
mod noise;
mod partition;
mod peaks;
pub mod readers;
mod registration;
mod resolution;
mod response;
mod scan;
mod synthetic;
mod topography;
pub mod writers;

pub use areal::{ArealParameters, ArealPatch};
pub use asperities::{
    AsperityCount, FaceAsperities, HeightCombination, HeightFamily, PackingHeight, PairAsperities, PairRadius,
    packing_count,
};
pub use characterise::{Characterisation, ElementSurface, InterferenceRange, Options, Summary, characterise};
pub use detrend::{Detrend, Plane, fit_plane, trend};
pub use error::{FileError, SurfaceError};
pub use evolution::{
    Correlation, CorrelationOptions, ElementField, Evolution, benjamini_hochberg, changes, correlate, p_as89,
    p_student, spearman,
};
pub use fits::{FitFallback, FitReport, NormalFitReport, TangentialFitReport, fit_normal, fit_tangential};
pub use gap::Bilinear;
pub use noise::{NoiseHandling, OutlierRule, gaussian_s_filter, without_outliers};
pub use partition::{ElementOutlines, Partition};
pub use peaks::{LinePeak, RadiusStatistic, Summit, line_peaks, summits};
pub use registration::{Alignment, GapChange, Registration, align, registration_study};
pub use resolution::Resolution;
pub use response::{Bootstrap, CurveBands, TallestPeak, TractionCurves, bootstrap_bands, realisation, traction_curves};
pub use scan::FaceSummary;
pub use synthetic::{SyntheticFace, Waviness};
pub use topography::{HeightData, HeightMap};
