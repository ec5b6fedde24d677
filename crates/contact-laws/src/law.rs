//! The contract between a traction law and the code that calls it: the [`TractionLaw`] trait.

use alloc::borrow::Cow;
use alloc::vec::Vec;
use core::ops::{AddAssign, Range};

use crate::choice::choices;
use crate::transposed::{self, Adjoint, Input, N_JUMP, Part, WHOLE, WayBack};
pub(crate) use crate::views::Along;
pub use crate::views::{Components, ComponentsMut, StateView, StateViewMut, along_path};

/// The method paper, where eqs. (18)-(20), (28), (29), (45) are from.
pub(crate) const PAPER_DOI: &str = "10.1016/j.ymssp.2020.106615";

/// Derivatives of the traction with respect to the jump (Pa/m), one slice per entry: `xn` is `d t_x / d u_n`.
#[derive(Debug)]
pub struct TangentMut<'a> {
    /// `d t_x / d u_x`.
    pub xx: &'a mut [f64],
    /// `d t_x / d u_y`.
    pub xy: &'a mut [f64],
    /// `d t_x / d u_n`.
    pub xn: &'a mut [f64],
    /// `d t_y / d u_x`.
    pub yx: &'a mut [f64],
    /// `d t_y / d u_y`.
    pub yy: &'a mut [f64],
    /// `d t_y / d u_n`.
    pub yn: &'a mut [f64],
    /// `d t_n / d u_x`.
    pub nx: &'a mut [f64],
    /// `d t_n / d u_y`.
    pub ny: &'a mut [f64],
    /// `d t_n / d u_n`.
    pub nn: &'a mut [f64],
}

impl<'a> TangentMut<'a> {
    /// From the entries row by row, which must have the same length.
    pub fn from_entries([xx, xy, xn, yx, yy, yn, nx, ny, nn]: [&'a mut [f64]; 9]) -> Self {
        Self {
            xx,
            xy,
            xn,
            yx,
            yy,
            yn,
            nx,
            ny,
            nn,
        }
    }

    /// The entries row by row.
    pub(crate) fn into_entries(self) -> [&'a mut [f64]; 9] {
        [
            self.xx, self.xy, self.xn, self.yx, self.yy, self.yn, self.nx, self.ny, self.nn,
        ]
    }
}

/// Contact regime of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Regime {
    /// In contact below the slip limit.
    Stick,
    /// In contact at the slip limit.
    Slip,
    /// No contact: `u_n <= 0`.
    #[default]
    Open,
    /// Jump or begin state not finite: the tractions are NaN.
    Invalid,
}

/// Number of points in each regime.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RegimeCounts {
    /// Sticking points.
    pub stick: usize,
    /// Slipping points.
    pub slip: usize,
    /// Open points.
    pub open: usize,
    /// Points with input that is not finite.
    pub invalid: usize,
}

impl RegimeCounts {
    /// Counts one point.
    #[inline]
    pub fn count(&mut self, regime: Regime) {
        match regime {
            Regime::Stick => self.stick += 1,
            Regime::Slip => self.slip += 1,
            Regime::Open => self.open += 1,
            Regime::Invalid => self.invalid += 1,
        }
    }

    /// All points.
    pub fn total(&self) -> usize {
        self.stick + self.slip + self.open + self.invalid
    }
}

impl AddAssign for RegimeCounts {
    fn add_assign(&mut self, other: Self) {
        self.stick += other.stick;
        self.slip += other.slip;
        self.open += other.open;
        self.invalid += other.invalid;
    }
}

choices! {
    /// Whether friction limits the tangential traction.
    pub enum Sticking, "STICKING", "Sticking" {
        Coulomb = "coulomb", 0, "Points slip at the Coulomb limit.";
        /// For the first guess of a prestress, and for the stuck tangent about a state.
        Full = "full", 1, "Every closed point sticks, whatever its traction; open points still carry none.";
        /// For joints that are assembled without friction.
        Frictionless = "frictionless", 2, "No point carries a tangential traction, as with `mu = 0`.";
    }
}

/// Name and SI unit of a state component or a parameter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Quantity {
    /// Name, unique within a law's state or parameters.
    pub name: Cow<'static, str>,
    /// Unit.
    pub unit: &'static str,
}

impl Quantity {
    /// A quantity with a fixed name.
    pub const fn new(name: &'static str, unit: &'static str) -> Self {
        Self {
            name: Cow::Borrowed(name),
            unit,
        }
    }
}

/// What a calling code needs to know to size its arrays and label its output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LawInfo {
    /// Name of the law.
    pub name: &'static str,
    /// Where the law is described.
    pub reference: &'static str,
    /// State components in their order of storage.
    pub state: Vec<Quantity>,
    /// Parameters.
    pub parameters: Vec<Quantity>,
}

impl LawInfo {
    /// Number of state components per point.
    pub fn n_state(&self) -> usize {
        self.state.len()
    }
}

/// [`TractionLaw::evaluate`] and [`TractionLaw::derivative`] by one method of the law, which takes the arguments of the
/// first and a direction, if there is one: `evaluates_by!(method)`, or `evaluates_by!(method in blocks)` for a method
/// that is compiled for each size of blocks.
macro_rules! evaluates_by {
    ($($method:tt)+) => {
        fn evaluate(
            &self,
            points: core::ops::Range<usize>,
            sticking: $crate::law::Sticking,
            jump: $crate::law::Components<'_>,
            begin: $crate::law::StateView<'_>,
            end: $crate::law::StateViewMut<'_>,
            traction: $crate::law::ComponentsMut<'_>,
            tangent: Option<$crate::law::TangentMut<'_>>,
            regimes: Option<&mut [$crate::law::Regime]>,
        ) -> $crate::law::RegimeCounts {
            $crate::law::check_points(&points, self);
            $crate::law::evaluated!(
                self, $($method)+, points, sticking, jump, begin, end, traction, tangent, regimes, None
            )
        }

        fn derivative(
            &self,
            points: core::ops::Range<usize>,
            sticking: $crate::law::Sticking,
            jump: $crate::law::Components<'_>,
            begin: $crate::law::StateView<'_>,
            d_jump: $crate::law::Components<'_>,
            d_begin: $crate::law::StateView<'_>,
            end: $crate::law::StateViewMut<'_>,
            d_end: $crate::law::StateViewMut<'_>,
            traction: $crate::law::ComponentsMut<'_>,
            d_traction: $crate::law::ComponentsMut<'_>,
        ) -> $crate::law::RegimeCounts {
            $crate::law::check_points(&points, self);
            let along = Some($crate::law::Along {
                d_jump,
                d_begin,
                d_end,
                d_traction,
                parts: None,
            });
            $crate::law::evaluated!(
                self, $($method)+, points, sticking, jump, begin, end, traction, None, None, along
            )
        }
    };
}
pub(crate) use evaluates_by;

/// The call of [`evaluates_by`].
macro_rules! evaluated {
    ($law:ident, $method:ident in blocks, $points:ident, $($argument:expr),+) => {
        if $points.len() <= $crate::simd::SHORT_BLOCK {
            $law.$method::<{ $crate::simd::SHORT_BLOCK }>($points, $($argument),+)
        } else {
            $law.$method::<{ $crate::simd::BLOCK }>($points, $($argument),+)
        }
    };
    ($law:ident, $method:ident, $($argument:expr),+) => {
        $law.$method($($argument),+)
    };
}
pub(crate) use evaluated;

/// Panics when `points` exceeds the law, as [`TractionLaw::evaluate`] promises.
pub(crate) fn check_points(points: &Range<usize>, law: &impl TractionLaw) {
    let count = law.len();
    assert!(points.end <= count, "points {points:?} exceed the law's {count} points");
}

/// What [`TractionLaw::follow`] demands of its arguments.
pub(crate) fn check_path<L: TractionLaw + ?Sized>(
    points: &Range<usize>,
    law: &L,
    path: &[f64],
    state: &[f64],
    traction: &[f64],
) {
    let n = points.len();
    assert!(n > 0, "a path of no points");
    assert_eq!(state.len(), law.info().n_state() * n, "length of the state");
    assert_eq!(path.len() % (3 * n), 0, "length of the path");
    assert_eq!(traction.len(), path.len(), "length of the tractions");
}

/// [`TractionLaw::follow`] by [`TractionLaw::evaluate`].
pub(crate) fn step_by_step<L: TractionLaw + ?Sized>(
    law: &L,
    points: Range<usize>,
    sticking: Sticking,
    path: &[f64],
    state: &mut [f64],
    room: &mut [f64],
    traction: &mut [f64],
) {
    check_path(&points, law, path, state, traction);
    along_path(
        points.len(),
        path,
        state,
        room,
        traction,
        |jump, begin, end, traction| {
            law.evaluate(points.clone(), sticking, jump, begin, end, traction, None, None);
        },
    );
}

/// A traction law over a set of points with fixed parameters.
///
/// A law is independent of the rate: [`Self::evaluate`] is given where a point is and where it was at the commit, but not
/// the time between the two. A law that depends on the velocity of sliding cannot be written with it.
pub trait TractionLaw: Send + Sync {
    /// Description, with the names and units of state and parameters.
    fn info(&self) -> &LawInfo;

    /// Number of points.
    fn len(&self) -> usize;

    /// True when there is no point.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Tractions, end state and, on request, tangent and regimes of `points`.
    ///
    /// - `jump` (m): `jump.n` is the interference, the gap already subtracted.
    /// - `begin`: state committed last, `info().n_state()` components. A state of zeros is a point that touches
    ///   nothing and carries nothing. Never changed: calling again gives the same result.
    /// - `end`: state reached; it becomes `begin` of later calls when the caller commits it.
    /// - `traction` (Pa), `tangent` (Pa/m) (consistent with the tractions; at a kink the one-sided derivative of the
    ///   branch taken).
    /// - All slices, and the parts of the states in view, have the length of `points`.
    ///
    /// Never fails and never allocates. Finite input gives finite output. A point whose jump or begin state is not
    /// finite is counted as invalid; its tractions, tangent and end state are NaN.
    ///
    /// # Panics
    /// When `points` exceeds the law or a slice is shorter than `points`.
    fn evaluate(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        tangent: Option<TangentMut<'_>>,
        regimes: Option<&mut [Regime]>,
    ) -> RegimeCounts;

    /// What [`Self::evaluate`] gives, and its derivative along a direction: `d_traction` and `d_end` are the changes of
    /// tractions and of the end state per unit of a change `d_jump` of the jump and `d_begin` of the begin state.
    ///
    /// - One-sided at kinks: the derivative of the branch taken.
    /// - Units: those of traction and state over the unit of the direction's parameter. With `d_begin` of zeros,
    ///   `d_traction` is the tangent times `d_jump`.
    /// - Chained over the steps of a path, with `d_end` as the next `d_begin`, it gives the derivative of the path.
    /// - All slices, and the parts of the states in view, have the length of `points`.
    ///
    /// Never fails and never allocates. Finite input gives finite output. Tractions and end state have the bits that
    /// [`Self::evaluate`] gives. Where the jump or the begin state of a point is not finite, the derivatives are NaN as
    /// well; where its direction is not finite, the derivatives alone are NaN.
    ///
    /// # Panics
    /// When `points` exceeds the law or a slice is shorter than `points`.
    fn derivative(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        d_jump: Components<'_>,
        d_begin: StateView<'_>,
        end: StateViewMut<'_>,
        d_end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        d_traction: ComponentsMut<'_>,
    ) -> RegimeCounts;

    /// Tractions of points along a path: as [`Self::evaluate`] from step to step, each from the end state of the one before, to rounding.
    ///
    /// - `path` (m) and `traction` (Pa): `[step][component][point]`.
    /// - `state`: `[component][point]`, that at the begin of the path, which becomes that at its end.
    /// - `room`: as many numbers as the state has.
    ///
    /// # Panics
    /// When `points` exceeds the law or is empty, or a slice has another length.
    fn follow(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        path: &[f64],
        state: &mut [f64],
        room: &mut [f64],
        traction: &mut [f64],
    ) {
        step_by_step(self, points, sticking, path, state, room, traction);
    }

    /// The way back through a step under friction: what the product of adjoints `l` of the end state and `m` of the tractions with these grows by,
    /// per unit of the jump, `(d end/d jump)^T l + (d traction/d jump)^T m`, and likewise of the begin state.
    ///
    /// - Of the branch taken, as [`Self::derivative`].
    /// - All slices, and the parts of the states in view, have the length of `points`.
    ///
    /// By default one derivative for each number of jump and state.
    ///
    /// # Panics
    /// As [`Self::derivative`].
    fn transposed(
        &self,
        points: Range<usize>,
        jump: Components<'_>,
        begin: StateView<'_>,
        way: WayBack,
        adjoints: &mut [Adjoint<'_>],
    ) {
        let n_state = self.info().n_state();
        let all = [Part {
            input: 0..N_JUMP + n_state,
            end: 0..n_state,
            tractions: WHOLE,
        }];
        let input = Input { points, jump, begin };
        transposed::transposed(&input, 0, &[&all], way, adjoints, |of, end, traction, along| {
            let Along {
                d_jump,
                d_begin,
                d_end,
                d_traction,
                ..
            } = along;
            let Input { points, jump, begin } = of;
            self.derivative(
                points,
                Sticking::Coulomb,
                jump,
                begin,
                d_jump,
                d_begin,
                end,
                d_end,
                traction,
                d_traction,
            );
        });
    }

    /// Whether friction can take energy. If not, tractions under Coulomb's law depend on the jump alone: a path back gives what
    /// the path there gave.
    fn dissipates(&self) -> bool {
        true
    }

    /// Coulomb's friction coefficient at a point. `None` where the slip limit is no constant share of the normal traction.
    fn friction_coefficient(&self, _point: usize) -> Option<f64> {
        None
    }

    /// Whether a point can slip in parts, so that [`Regime::Stick`] does not say that nothing slips there.
    fn slips_in_parts(&self) -> bool {
        false
    }

    /// Real contact area per nominal area at `point` under the interference `u_n` (m); none for laws without
    /// asperities.
    fn contact_area_ratio(&self, _point: usize, _u_n: f64) -> Option<f64> {
        None
    }

    /// Fraction of the loaded asperities at `point` that are pressed in by more than `omega_c` (m), the onset of yield
    /// ([`crate::adhesion::critical_interference`]); none for laws without asperities.
    fn yielded_fraction(&self, _point: usize, _u_n: f64, _omega_c: f64) -> Option<f64> {
        None
    }
}
