//! What a history rule says at one point. [`super::return_map`] applies it to blocks of points.

use crate::jet::Jet;
use crate::law::Quantity;

/// How the tangential traction of a point follows from its history.
///
/// The functions are called in loops over the points of a block, compiled once per rule. To keep these loops in vector
/// registers an implementation
/// - is `#[inline(always)]` and takes and returns numbers by value: a reference would hide which arrays overlap;
/// - has no branch on a value: it computes both and selects one with `if`;
/// - calls nothing but arithmetic, [`crate::simd::elementary`] and [`crate::simd::bounds`].
///
/// Numbers handed in are finite and at most 1e150, stretches 1e75 and tractions 1e300, so that the product of two is
/// finite except that of a traction; where three are multiplied, [`bounded`](crate::simd::bounds::bounded) cuts the
/// product of the first two. What is returned for a point that is open or whose input is not finite is not used.
pub(crate) trait FrictionRule: Copy {
    /// What the state remembers beside the jump.
    const MEMORY: Memory;
    /// Where on the path the tangential stiffnesses are taken.
    const STIFFNESS: StiffnessAt;
    /// Whether the tangent needs second derivatives of the tangential stiffnesses.
    const CURVATURE: bool;

    /// Traction that sticking would leave along one direction, from the path and the tangential stiffness
    /// (Pa/m, with derivatives with respect to the interference at which it is taken). For rules with [`Memory::Traction`] it is what is remembered
    /// and a part that is linear in the stiffness and its derivatives.
    fn trial(self, path: Path, k: Jet) -> Trial;

    /// Change of the trial's traction along a direction, from the changes of the path and of the tangential stiffness.
    fn trial_change(self, path: Path, k: Jet, path_change: PathChange, k_change: StiffnessChange) -> f64;

    /// What the elastic stretch (m), after slip, adds to the normal traction of the curves, from the stretch and the
    /// tangential stiffnesses along x and y. Nothing unless the rule says so, and only asked of a rule that remembers
    /// the stretch.
    #[inline(always)]
    fn normal_addition(self, _stretch: [f64; 2], _k: [Jet; 2]) -> NormalAddition {
        NormalAddition {
            value: 0.0,
            along: [0.0; 2],
            closing: 0.0,
        }
    }

    /// [`Self::trial`] a second time, from the description alone and with derivatives by dual numbers: what the tests of all
    /// rules compare it with.
    #[cfg(test)]
    fn described(path: &crate::tests::described::Described<'_>) -> crate::tests::described::Quantity3;
}

/// Two numbers per point beside the jump.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Memory {
    /// Tangential traction.
    Traction,
    /// Elastic stretch: the part of the tangential jump that slip has not taken.
    Stretch,
}

impl Memory {
    /// Name and unit of both numbers.
    pub(crate) const fn quantities(self) -> [Quantity; 2] {
        match self {
            Self::Traction => [Quantity::new("t_x", "Pa"), Quantity::new("t_y", "Pa")],
            Self::Stretch => [Quantity::new("e_x", "m"), Quantity::new("e_y", "m")],
        }
    }
}

/// Where on the path the tangential stiffnesses are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StiffnessAt {
    /// Halfway along the closed part of the path.
    Middle,
    /// At the interference reached.
    End,
}

/// The straight path of a point from its begin state, along one tangential direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Path {
    /// Tangential jump reached (m).
    pub(crate) u: f64,
    /// Its change (m).
    pub(crate) du: f64,
    /// Change of the interference (m).
    pub(crate) du_n: f64,
    /// Share of the path that is closed: 1 for a point that was closed before.
    pub(crate) share: f64,
    /// Derivative of the share with respect to the interference reached (1/m).
    pub(crate) share_slope: f64,
    /// Traction remembered (Pa); for rules with [`Memory::Traction`].
    pub(crate) traction: f64,
    /// Stretch that sticking leaves: the stretch remembered and the closed share of the path (m). For rules with
    /// [`Memory::Stretch`].
    pub(crate) stretch: f64,
    /// Derivative of the stretch with respect to the interference reached.
    pub(crate) stretch_slope: f64,
}

/// Change of a [`Path`] along a direction of jump and begin state, in the units of the path per unit of the direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PathChange {
    pub(crate) u: f64,
    pub(crate) du: f64,
    pub(crate) du_n: f64,
    pub(crate) share: f64,
    pub(crate) traction: f64,
    pub(crate) stretch: f64,
}

/// Change of a tangential stiffness and of its slope along a direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StiffnessChange {
    pub(crate) value: f64,
    pub(crate) slope: f64,
}

/// Traction that sticking would leave along one direction, with its derivatives with respect to the jump.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trial {
    /// Traction (Pa).
    pub(crate) traction: f64,
    /// Derivative along the direction itself (Pa/m).
    pub(crate) along: f64,
    /// Derivative along the normal (Pa/m).
    pub(crate) closing: f64,
}

/// Addition to the normal traction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NormalAddition {
    /// Value (Pa).
    pub(crate) value: f64,
    /// Derivatives with respect to the stretch along x and y (Pa/m).
    pub(crate) along: [f64; 2],
    /// Derivative with respect to the interference at constant stretch (Pa/m).
    pub(crate) closing: f64,
}
