//! Coulomb friction on top of contact curves (eqs. 18-20): stick from the state committed last, slip on the circular
//! cone `|t_t| <= mu t_n`, no traction when open.
//!
//! With the begin state `(u_0, t_0)` and the curves `t_n(u_n)`, `k_q(u_n)`, `q` in {x, y}, the stuck trial is, by
//! [`HistoryRule`]:
//!
//! - `Incremental`: `t_q = t_q0 + f k_q(m) (u_q - u_q0)`, the midpoint rule on the closed part of the straight path from
//!   the begin state: `l = max(u_n0, 0)`, `m = (u_n + l)/2`, and `f = (u_n - l)/(u_n - u_n0)` the share of the path that
//!   is closed (1 when the point was closed before). A re-contacting point sticks from where its path meets `u_n = 0`.
//!   The result does not depend on the origin of the displacements.
//! - `Paper`: `t_q = t_q0 + k_q(u_n) (u_q - u_q0) + k_q'(u_n) (u_n - u_n0) u_q`, as published. It depends on the total
//!   displacement, so on slip in the past.
//!
//! - `Potential`: the stored energy per area is `psi = psi_n(u_n) + (k_x e_x^2 + k_y e_y^2)/2` with the elastic stretch
//!   `e` as state, so `t_q = k_q(u_n) e_q` and `t_n = psi_n'(u_n) + (k_x' e_x^2 + k_y' e_y^2)/2`: the normal traction
//!   answers the change of the tangential stiffness. The stuck trial is `e_q = e_q0 + f (u_q - u_q0)`, slip shortens the
//!   stretch to the cone `|t_t| = mu psi_n'`, an open point has none.
//!
//! Beyond the cone the trial is scaled back to it. Where the slip limit is zero (`mu = 0`) every closed point slips and
//! the tangential tangent is zero in all directions, also for a trial of zero length.
//!
//! With `Potential` and a commit at every step no closed path gains energy: in every step the traction along the slip,
//! `t_t . (du - de)`, is not negative. The other two rules do not derive from a potential, so a stuck cycle along which
//! `u_n` changes may gain or lose a little energy. At constant `u_n` closed collinear cycles dissipate and obey Masing's
//! rule with all three.

use core::ops::Range;

use crate::curves::{CurveBlock, PointCurves};
use crate::error::{Error, Place, require};
use crate::law::{
    Components, ComponentsMut, LawInfo, Quantity, Regime, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut,
    TractionLaw,
};
use crate::parameters::PointParameters;
use crate::return_map::{Block, INCREMENTAL, PAPER, POTENTIAL, Start, Workspace};
use crate::vector::{BLOCK, Lanes, SHORT_BLOCK, run};

/// Reference of eqs. (18)-(20), (28), (29), (45).
pub(crate) const PAPER_DOI: &str = "10.1016/j.ymssp.2020.106615";

/// State of the laws of this crate: first the jump committed last.
pub(crate) const JUMP: [Quantity; 3] = [
    Quantity::new("u_x", "m"),
    Quantity::new("u_y", "m"),
    Quantity::new("u_n", "m"),
];
const TRACTION: [Quantity; 2] = [Quantity::new("t_x", "Pa"), Quantity::new("t_y", "Pa")];
const STRETCH: [Quantity; 2] = [Quantity::new("e_x", "m"), Quantity::new("e_y", "m")];

/// Friction coefficient, as it appears in every law's parameters.
pub(crate) const MU: Quantity = Quantity::new("mu", "1");

/// How the stuck traction follows from the state committed last; see the [module](self).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum HistoryRule {
    /// Midpoint rule along the closed part of the path.
    #[default]
    Incremental,
    /// As published: linearised about the end point, with the total displacement.
    Paper,
    /// From a potential, with the elastic stretch as state.
    Potential,
}

/// Contact curves with Coulomb friction. State per point: `u_x, u_y, u_n` (m) and `t_x, t_y` (Pa), or with
/// [`HistoryRule::Potential`] `e_x, e_y` (m).
#[derive(Debug, Clone)]
pub struct FrictionalLaw<C> {
    curves: C,
    mu: PointParameters<f64>,
    history: HistoryRule,
    info: LawInfo,
}

impl<C: PointCurves> FrictionalLaw<C> {
    /// A law over `curves.len()` points with the friction coefficient `mu` per point.
    ///
    /// # Errors
    /// [`Error::Length`] when `mu` has another number of points, [`Error::Parameter`] when a coefficient is negative or
    /// not finite.
    pub fn try_new(curves: C, mu: PointParameters<f64>, history: HistoryRule) -> Result<Self, Error> {
        require_friction(&mu, curves.len())?;
        let (name, reference, parameters) = match curves.info() {
            None => ("no points", PAPER_DOI, &[][..]),
            Some(info) => (info.name, info.reference, info.parameters),
        };
        let memory = match history {
            HistoryRule::Incremental | HistoryRule::Paper => TRACTION,
            HistoryRule::Potential => STRETCH,
        };
        let info = LawInfo {
            name,
            reference,
            state: JUMP.into_iter().chain(memory).collect(),
            parameters: parameters.iter().cloned().chain([MU]).collect(),
        };
        Ok(Self {
            curves,
            mu,
            history,
            info,
        })
    }

    /// The curves of every point.
    pub fn curves(&self) -> &C {
        &self.curves
    }

    /// The friction coefficients.
    pub fn mu(&self) -> &PointParameters<f64> {
        &self.mu
    }

    /// The history rule.
    pub fn history(&self) -> HistoryRule {
        self.history
    }

    /// [`TractionLaw::evaluate`] in blocks of `B` points.
    fn evaluate_blocks<const B: usize>(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        tangent: Option<TangentMut<'_>>,
        mut regimes: Option<&mut [Regime]>,
    ) -> RegimeCounts {
        let n = points.len();
        let (jump, begin) = ([jump.x, jump.y, jump.n], begin.components::<5>(n));
        let (mut end, mut traction) = (end.components::<5>(n), [traction.x, traction.y, traction.n]);
        let mut tangent = tangent.map(TangentMut::into_entries);
        let (mut for_curves, mut curves, mut workspace) = (
            C::Workspace::<B>::default(),
            CurveBlock::<B>::new(),
            Workspace::<B>::new(),
        );
        let (mut u_n, mut middle, mut mu) = (Lanes([0.0; B]), Lanes([0.0; B]), Lanes([0.0; B]));
        let mut counts = RegimeCounts::default();
        let (mut block, mut reopens) = (0..0, false);
        while block.end < n {
            block = block.end..n.min(block.end + B);
            let (jump, begin) = (part(&jump, &block), part(&begin, &block));
            let [end_x, end_y, end_n, end_1, end_2] = part_mut(&mut end, &block);
            run(Start {
                jump,
                begin,
                halfway: self.history == HistoryRule::Incremental,
                u_n: &mut u_n,
                middle: &mut middle,
                end: [end_x, end_y, end_n],
                reopens: &mut reopens,
            });
            let curvature = tangent.is_some() && self.history != HistoryRule::Incremental;
            let (m, first) = (block.len(), points.start + block.start);
            self.curves.evaluate(
                first,
                &u_n.0[..m],
                &middle.0[..m],
                curvature,
                &mut for_curves,
                &mut curves,
            );
            let mu = &mut mu.0[..m];
            self.mu.copy_to(first, mu);
            let block = Block {
                jump,
                begin,
                mu,
                u_n: &u_n,
                reopens,
                curves: &curves,
                sticking,
                workspace: &mut workspace,
                memory: [end_1, end_2],
                traction: part_mut(&mut traction, &block),
                tangent: tangent.as_mut().map(|tangent| part_mut(tangent, &block)),
                regimes: regimes.as_mut().map(|regimes| &mut regimes[block.clone()]),
            };
            counts += match self.history {
                HistoryRule::Incremental => block.respond::<INCREMENTAL>(),
                HistoryRule::Paper => block.respond::<PAPER>(),
                HistoryRule::Potential => block.respond::<POTENTIAL>(),
            };
        }
        counts
    }
}

impl<C: PointCurves> TractionLaw for FrictionalLaw<C> {
    fn info(&self) -> &LawInfo {
        &self.info
    }

    fn len(&self) -> usize {
        self.curves.len()
    }

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
    ) -> RegimeCounts {
        assert!(
            points.end <= self.len(),
            "points {points:?} exceed the law's {} points",
            self.len()
        );
        if points.len() <= SHORT_BLOCK {
            self.evaluate_blocks::<SHORT_BLOCK>(points, sticking, jump, begin, end, traction, tangent, regimes)
        } else {
            self.evaluate_blocks::<BLOCK>(points, sticking, jump, begin, end, traction, tangent, regimes)
        }
    }

    fn contact_area_ratio(&self, point: usize, u_n: f64) -> Option<f64> {
        self.curves.contact_area_ratio(point, u_n)
    }

    fn yielded_fraction(&self, point: usize, u_n: f64, omega_c: f64) -> Option<f64> {
        self.curves.yielded_fraction(point, u_n, omega_c)
    }
}

/// Refuses friction coefficients that are negative or not finite, or not one per point.
pub(crate) fn require_friction(mu: &PointParameters<f64>, n_points: usize) -> Result<(), Error> {
    if mu.len() != n_points {
        return Err(Error::Length {
            list: "mu",
            expected: n_points,
            found: mu.len(),
        });
    }
    // A uniform value needs to be looked at once only.
    for point in 0..if mu.is_uniform() { n_points.min(1) } else { n_points } {
        let value = *mu.at(point);
        let ok = value.is_finite() && value >= 0.0;
        require(
            ok,
            "mu",
            value,
            "(no unit)",
            Place::Point(point),
            "finite and not negative",
        )?;
    }
    Ok(())
}

/// The numbers of a block in each slice.
#[inline]
fn part<'a, const N: usize>(slices: &[&'a [f64]; N], block: &Range<usize>) -> [&'a [f64]; N] {
    let mut parts: [&[f64]; N] = [&[]; N];
    for (part, slice) in parts.iter_mut().zip(slices) {
        *part = &slice[block.clone()];
    }
    parts
}

/// Like [`part`], to be written.
#[inline]
fn part_mut<'a, const N: usize>(slices: &'a mut [&mut [f64]; N], block: &Range<usize>) -> [&'a mut [f64]; N] {
    let mut parts: [&mut [f64]; N] = core::array::from_fn(|_| -> &mut [f64] { &mut [] });
    for (part, slice) in parts.iter_mut().zip(slices) {
        *part = &mut slice[block.clone()];
    }
    parts
}
