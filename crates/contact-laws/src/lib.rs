//! Traction laws of rough and dry-friction contact at points, evaluated in batches with state and consistent tangent.
//!
//! The crate knows neither mesh nor solver: a caller hands in the jump at a batch of points and the state committed
//! last, and receives tractions, the state reached and, on request, the derivative of the tractions.
//!
//! - **Sign**: `jump = u_top - u_bottom`, the normal points from the top body into the bottom body, and the caller has
//!   already subtracted the gap, so `u_n > 0` is interference (m) and a point is in contact iff `u_n > 0`.
//! - **Units**: SI; jumps in m, tractions in Pa, tangents in Pa/m.
//! - **History**: evaluation is pure in the begin state. Whether the end state becomes the next begin state is the
//!   caller's decision: at load reversals, or at every converged step.
//! - **Totality**: parameters are validated when a law is made, evaluation never fails. A point whose input is not
//!   finite is counted as invalid and its tractions are NaN.
//!
//! | law | curves | module |
//! |---|---|---|
//! | [`AsperityLaw`] | sums over an asperity population | [`asperity_sum`] |
//! | [`RoughLaw`] | fitted curves, eqs. (28), (29) | [`rough`] |
//! | [`TableLaw`] | table made from any of the others | [`table`] |
//! | [`GreenwoodWilliamsonLaw`] | closed forms for exponential and Gaussian heights | [`greenwood_williamson`] |
//! | [`ElasticDryFriction`] | constant stiffnesses | [`elastic_dry_friction`] |
//! | [`MindlinIwan`] | any of the above, with microslip | [`mindlin_iwan`] |
//!
//! Equation numbers are those of the method paper listed in each law's [`LawInfo`].

#![cfg_attr(not(any(feature = "std", test)), no_std)]

extern crate alloc;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("contact-laws needs elementary functions: enable the feature `std` or the feature `libm`");

pub mod adhesion;
pub mod asperity_sum;
mod continuation;
pub mod curves;
pub mod elastic_dry_friction;
mod elementary;
mod error;
pub mod friction;
pub mod greenwood_williamson;
pub mod hertz;
pub mod law;
#[cfg(not(feature = "std"))]
mod math;
pub mod mindlin;
pub mod mindlin_iwan;
mod parameters;
mod return_map;
pub mod rough;
mod rough_points;
pub mod table;
#[cfg(any(test, feature = "testing"))]
pub mod testing;

mod vector;
#[cfg(feature = "testing")]
pub mod workload;

#[cfg(test)]
mod tests;

pub use adhesion::Adhesion;
pub use asperity_sum::{AsperityLaw, AsperityPopulation, AsperitySumCurves, GapDistribution, TangentialReading};
pub use curves::{ContactCurves, CurveBlock, CurvesInfo, Exponents, Jet, PointCurves};
pub use elastic_dry_friction::{ElasticCurves, ElasticDryFriction};
pub use elementary::Real;
pub use error::{Error, Place};
pub use friction::{FrictionalLaw, HistoryRule};
pub use greenwood_williamson::{
    GreenwoodWilliamsonCurves, GreenwoodWilliamsonLaw, GreenwoodWilliamsonSurface, HeightDistribution,
};
pub use hertz::ElasticPair;
pub use law::{
    Components, ComponentsMut, LawInfo, Quantity, Regime, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut,
    TractionLaw,
};
pub use mindlin_iwan::MindlinIwan;
pub use parameters::PointParameters;
pub use rough::{FittedCurves, NormalFit, RoughLaw, TangentialEnds, TangentialFit};
pub use rough_points::FittedPoints;
pub use table::{TableLaw, TableOptions, Tabulated};
pub use vector::instruction_set;
