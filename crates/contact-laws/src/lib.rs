//! Traction laws of rough and dry-friction contact at points, evaluated in batches with state and consistent tangent.
//!
//! The crate knows neither mesh nor solver: a caller hands in the jump at a batch of points and the state committed
//! last, and receives tractions, the state reached and, on request, the derivative of the tractions.
//!
//! - **Sign**: `jump = u_top - u_bottom`, the normal points from the top body into the bottom body, and the caller has
//!   already subtracted the gap, so `u_n > 0` is interference (m) and a point is in contact iff `u_n > 0`.
//! - **Units**: SI; jumps in m, tractions in Pa, tangents in Pa/m.
//! - **State**: as many numbers per point as the law says, [`LawInfo::n_state`], stored `[component][point]`; zeros are
//!   a point that touches nothing and carries nothing ([`LinearisedContact`]: its static state).
//! - **History**: evaluation is pure in the begin state. Whether the end state becomes the next begin state is the
//!   caller's decision: at load reversals, or at every converged step. How the begin state enters is the law's
//!   [`HistoryRule`].
//! - **Totality**: parameters are validated when a law is made, evaluation never fails and never allocates; finite
//!   input gives finite output. A point whose input is not finite is counted as invalid and its tractions are NaN.
//!
//! | law | normal and tangential curves | made from | page |
//! |---|---|---|---|
//! | [`AsperityLaw`] | sums over asperities (Hertz, Mindlin), no fit | gaps, density, radii | [`curves::asperity_sum`] |
//! | [`GreenwoodWilliamsonLaw`] | closed forms | heights, density, radii | [`curves::greenwood_williamson`] |
//! | [`TableLaw`] | monotone C1 table of known error | any other curves | [`curves::table`] |
//! | [`curves::sampled`] | through points, such as of boundary elements | interferences, tractions, areas | [`curves::sampled`] |
//! | [`RoughLaw`] | fitted, eqs. (28), (29) | fit parameters | [`curves::fitted`] |
//! | [`ElasticDryFriction`] | constant stiffnesses | `k_n`, `k_x`, `k_y` | [`curves::elastic`] |
//! | [`FoundationLaw`] | any of the above whose stiffness does not fall, with partial slip | curves, number of springs | [`friction::foundation`] |
//! | [`ResolvedLaw`] | asperities one by one, elastic or with yield | bins of gaps | [`friction::resolved`] |
//! | [`LinearisedContact`] | constant stiffnesses and slip limit | any law's static state | [`friction::linearised`] |
//!
//! All carry Coulomb friction; all but the last three are a [`FrictionalLaw`]: contact curves ([`curves`]) and a
//! [`HistoryRule`] ([`friction`]). Curves of one's own implement [`ContactCurves`]. Beside the laws stand single contacts ([`hertz`], [`mindlin`]), onset of yield and
//! [`adhesion`].
//!
//! Equation numbers are those of N. N. Balaji, W. Chen and M. R. W. Brake, *Traction-based multi-scale nonlinear
//! dynamic modeling of bolted joints: formulation, application, and trends in micro-scale interface evolution*, Mech.
//! Syst. Signal Process. 139, 2020, 106615 ("the method paper"), unless a page names another source.
//!
//! # Reproducibility
//! Friction and fitted curves are evaluated in blocks that fill vector registers, with AVX-512 or AVX2 and FMA where
//! the processor has them ([`instruction_set`]). On one kind of processor a point's result has the same bits in any
//! chunk and order. With and without FMA the fitted curves differ in the last bits; everything else is bitwise the
//! same.
//!
//! # Features
//! - `std` (default): elementary functions and processor detection from the standard library.
//! - `libm`: elementary functions in pure Rust. Without `std` this one is needed, and the crate is `no_std` with
//!   `alloc`: `default-features = false, features = ["libm"]`.
//! - `serde`: parameter structs can be read and written.
//! - `testing` (needs `std`): a tangent checker and proptest strategies, for tests of other laws.

#![cfg_attr(not(any(feature = "std", test)), no_std)]

extern crate alloc;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("contact-laws needs elementary functions: enable the feature `std` or the feature `libm`");

pub mod choice;
pub mod curves;
mod error;
pub mod friction;
mod jet;
pub mod law;
#[cfg(not(feature = "std"))]
mod math;
mod parameters;
mod physics;
mod simd;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
mod transposed;
mod views;

#[cfg(test)]
mod tests;

/// What the README shows compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

pub use choice::Choice;
pub use curves::asperity_sum::{AsperitySumCurves, TangentialReading};
pub use curves::elastic::ElasticCurves;
pub use curves::fitted::{FittedCurves, NormalFit, TangentialEnds, TangentialFit};
pub use curves::fitted_points::FittedPoints;
pub use curves::greenwood_williamson::{GreenwoodWilliamsonCurves, GreenwoodWilliamsonSurface};
pub use curves::sampled::SampledCurves;
pub use curves::table::{TableOptions, Tabulated};
pub use curves::{CURVES, ContactCurves, CurveBlock, CurveFactors, CurvesInfo, Exponents, PointCurves};
pub use error::{Error, Place};
pub use friction::foundation::{Foundation, FoundationLaw, Growth};
pub use friction::linearised::{LinearisedContact, StaticPoint};
pub use friction::radii::Radii;
pub use friction::resolved::{AsperityFriction, ResolvedLaw};
pub use friction::similarity::{PointSums, Scaling, Similarity};
pub use friction::{
    AsperityLaw, Cone, ElasticDryFriction, FrictionalLaw, GreenwoodWilliamsonLaw, HISTORY_RULES, HistoryRule,
    HistoryRuleInfo, RoughLaw, TableLaw,
};
pub use jet::Jet;
pub use law::{
    Components, ComponentsMut, LawInfo, Quantity, Regime, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut,
    TractionLaw, along_path,
};
pub use parameters::{Bounds, Parameter, PointParameters};
pub use physics::adhesion::Adhesion;
pub use physics::bins::{AsperityBins, MAX_BINS};
pub use physics::elastic_plastic::{Asperity, Contact, Dent, Unloading, Yield, YieldCurves};
pub use physics::heights::HeightDistribution;
pub use physics::hertz::ElasticPair;
pub use physics::population::{AsperityPopulation, GapDistribution};
pub use physics::slip_limit::AsperityLimit;
pub use physics::{adhesion, elastic_plastic, hertz, mindlin, slip_limit};
pub use simd::elementary::Real;
pub use simd::instruction_set;
pub use transposed::{Adjoint, WayBack};
