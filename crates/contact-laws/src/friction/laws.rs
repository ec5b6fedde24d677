//! The laws that have names of their own: one row per set of contact curves.

use super::FrictionalLaw;
use crate::curves::asperity_sum::AsperitySumCurves;
use crate::curves::elastic::ElasticCurves;
use crate::curves::fitted_points::FittedPoints;
use crate::curves::greenwood_williamson::GreenwoodWilliamsonCurves;
use crate::curves::table::Tabulated;
use crate::parameters::PointParameters;

/// Rough contact by direct asperity sums with friction: the reference for fits and tables.
pub type AsperityLaw = FrictionalLaw<PointParameters<AsperitySumCurves>>;
/// Elastic dry friction.
pub type ElasticDryFriction = FrictionalLaw<PointParameters<ElasticCurves>>;
/// Greenwood-Williamson contact with friction.
pub type GreenwoodWilliamsonLaw = FrictionalLaw<PointParameters<GreenwoodWilliamsonCurves>>;
/// Rough contact by fitted curves with friction, evaluated in vector registers.
pub type RoughLaw = FrictionalLaw<FittedPoints>;
/// Tabulated contact curves with friction.
pub type TableLaw<C> = FrictionalLaw<PointParameters<Tabulated<C>>>;
