//! What a rough contact shows at one point before friction limits it: normal traction and tangential stiffnesses as
//! functions of the interference.

pub mod asperity_sum;
mod contact_curves;
mod continuation;
pub mod elastic;
pub mod fitted;
pub(crate) mod fitted_points;
pub mod greenwood_williamson;
pub mod sampled;
pub mod table;

pub use contact_curves::{ContactCurves, CurveBlock, CurveFactors, CurvesInfo, Exponents, PointCurves};

/// The registry of curves: a row for each file of this folder that has some. Tests compare the pages with it.
pub static CURVES: &[&CurvesInfo] = &[
    &asperity_sum::INFO,
    &elastic::INFO,
    &fitted::INFO,
    &greenwood_williamson::INFO,
    &sampled::INFO,
    &table::INFO,
];
