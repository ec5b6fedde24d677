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
//! Beyond the cone the trial is scaled back to it. Where the slip limit is zero (`mu = 0`) every closed point slips and
//! the tangential tangent is zero in all directions, also for a trial of zero length.
//!
//! Neither rule derives from a potential: the normal traction has no term that answers the change of the tangential
//! stiffness with `u_n`, so a stuck cycle along which `u_n` changes may gain or lose a little energy. At constant `u_n`
//! closed collinear cycles dissipate and obey Masing's rule.

use core::ops::Range;

use crate::curves::ContactCurves;
use crate::error::{Error, Place, require};
use crate::law::{
    Components, ComponentsMut, LawInfo, Quantity, Regime, RegimeCounts, StateView, StateViewMut, Sticking, TangentMut,
    TractionLaw,
};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::PointParameters;

/// Reference of eqs. (18)-(20), (28), (29), (45).
pub(crate) const PAPER_DOI: &str = "10.1016/j.ymssp.2020.106615";

/// State of [`FrictionalLaw`]: jump and tangential traction of the last committed point.
pub(crate) const STATE: [Quantity; 5] = [
    Quantity::new("u_x", "m"),
    Quantity::new("u_y", "m"),
    Quantity::new("u_n", "m"),
    Quantity::new("t_x", "Pa"),
    Quantity::new("t_y", "Pa"),
];

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
}

/// Contact curves with Coulomb friction. State per point: `u_x, u_y, u_n` (m), `t_x, t_y` (Pa).
#[derive(Debug, Clone)]
pub struct FrictionalLaw<C> {
    curves: PointParameters<C>,
    mu: PointParameters<f64>,
    history: HistoryRule,
    info: LawInfo,
}

impl<C: ContactCurves> FrictionalLaw<C> {
    /// A law over `curves.len()` points with the friction coefficient `mu` per point.
    ///
    /// # Errors
    /// [`Error::Length`] when `mu` has another number of points, [`Error::Parameter`] when a coefficient is negative or
    /// not finite.
    pub fn try_new(curves: PointParameters<C>, mu: PointParameters<f64>, history: HistoryRule) -> Result<Self, Error> {
        if mu.len() != curves.len() {
            return Err(Error::Length {
                list: "mu",
                expected: curves.len(),
                found: mu.len(),
            });
        }
        for point in 0..mu.len() {
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
        let (name, reference, parameters) = match curves.is_empty() {
            true => ("no points", PAPER_DOI, &[][..]),
            false => {
                let info = curves.at(0).info();
                (info.name, info.reference, info.parameters)
            }
        };
        let info = LawInfo {
            name,
            reference,
            state: STATE.to_vec(),
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
    pub fn curves(&self) -> &PointParameters<C> {
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

    /// The loop over the points. Compiled apart for each rule and with and without tangent, so that the derivatives a
    /// call does not need cost nothing.
    fn run<const PAPER: bool, const TANGENT: bool>(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        mut tangent: Option<TangentMut<'_>>,
        mut regimes: Option<&mut [Regime]>,
    ) -> RegimeCounts {
        let n = points.len();
        debug_assert!(jump.x.len() == n && jump.y.len() == n && jump.n.len() == n);
        debug_assert!(traction.x.len() == n && traction.y.len() == n && traction.n.len() == n);
        let (jump_x, jump_y, jump_n) = (&jump.x[..n], &jump.y[..n], &jump.n[..n]);
        let [begin_x, begin_y, begin_n, begin_tx, begin_ty] = core::array::from_fn(|c| begin.component(c, n));
        let [end_x, end_y, end_n, end_tx, end_ty] = end.components::<5>(n);
        let (traction_x, traction_y, traction_n) = (&mut traction.x[..n], &mut traction.y[..n], &mut traction.n[..n]);

        let mut counts = RegimeCounts::default();
        for (i, point) in points.enumerate() {
            let u = [jump_x[i], jump_y[i], jump_n[i]];
            let u_begin = [begin_x[i], begin_y[i], begin_n[i]];
            let t_begin = [begin_tx[i], begin_ty[i]];
            let response =
                respond::<C, PAPER>(self.curves.at(point), *self.mu.at(point), sticking, u, u_begin, t_begin);

            (end_x[i], end_y[i], end_n[i]) = (u[0], u[1], u[2]);
            (end_tx[i], end_ty[i]) = (response.t[0], response.t[1]);
            (traction_x[i], traction_y[i], traction_n[i]) = (response.t[0], response.t[1], response.t[2]);
            if TANGENT && let Some(out) = tangent.as_mut() {
                let [x, y] = response.tangential;
                (out.xx[i], out.xy[i], out.xn[i]) = (x[0], x[1], x[2]);
                (out.yx[i], out.yy[i], out.yn[i]) = (y[0], y[1], y[2]);
                let across = if response.regime == Regime::Invalid {
                    f64::NAN
                } else {
                    0.0
                };
                (out.nx[i], out.ny[i], out.nn[i]) = (across, across, response.normal);
            }
            if let Some(out) = regimes.as_mut() {
                out[i] = response.regime;
            }
            counts.count(response.regime);
        }
        counts
    }
}

impl<C: ContactCurves> TractionLaw for FrictionalLaw<C> {
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
        let run = match (self.history, tangent.is_some()) {
            (HistoryRule::Incremental, false) => Self::run::<false, false>,
            (HistoryRule::Incremental, true) => Self::run::<false, true>,
            (HistoryRule::Paper, false) => Self::run::<true, false>,
            (HistoryRule::Paper, true) => Self::run::<true, true>,
        };
        run(self, points, sticking, jump, begin, end, traction, tangent, regimes)
    }

    fn contact_area_ratio(&self, point: usize, u_n: f64) -> Option<f64> {
        self.curves.at(point).contact_area_ratio(u_n)
    }

    fn yielded_fraction(&self, point: usize, u_n: f64, omega_c: f64) -> Option<f64> {
        self.curves.at(point).yielded_fraction(u_n, omega_c)
    }
}

/// Tractions of one point with the entries of the tangent that can differ from zero.
struct Response {
    t: [f64; 3],
    /// Rows x and y.
    tangential: [[f64; 3]; 2],
    /// `d t_n / d u_n`.
    normal: f64,
    regime: Regime,
}

#[inline(always)]
fn respond<C: ContactCurves, const PAPER: bool>(
    curves: &C,
    mu: f64,
    sticking: Sticking,
    u: [f64; 3],
    u_begin: [f64; 3],
    t_begin: [f64; 2],
) -> Response {
    let [_, _, u_n] = u;
    if !(u.iter().chain(&u_begin).chain(&t_begin).all(|v| v.is_finite())) {
        let nan = f64::NAN;
        return Response {
            t: [nan; 3],
            tangential: [[nan; 3]; 2],
            normal: nan,
            regime: Regime::Invalid,
        };
    }
    if u_n <= 0.0 {
        return Response {
            t: [0.0; 3],
            tangential: [[0.0; 3]; 2],
            normal: 0.0,
            regime: Regime::Open,
        };
    }

    let (t_n, slope_n) = curves.normal(u_n);
    let (t_n, slope_n) = (bounded(t_n), bounded(slope_n));
    let (trial, d_trial) = if PAPER {
        paper_trial(curves, u, u_begin, t_begin)
    } else {
        incremental_trial(curves, u, u_begin, t_begin)
    };

    let limit = match sticking {
        Sticking::Coulomb => mu * t_n,
        Sticking::Full => f64::INFINITY,
    };
    let length = length(trial);
    if length <= limit && limit > 0.0 {
        let [x, y] = [[d_trial[0][0], 0.0, d_trial[0][1]], [0.0, d_trial[1][0], d_trial[1][1]]];
        return Response {
            t: [trial[0], trial[1], t_n],
            tangential: [x, y],
            normal: slope_n,
            regime: Regime::Stick,
        };
    }

    // eq. 20: t = limit n with n = trial/|trial|, so dt = (limit/|trial|) (I - n n) d(trial) + mu t_n' n du_n. A limit of
    // zero leaves nothing to differentiate and needs no direction.
    let (n, ratio) = if limit > 0.0 {
        ([trial[0] / length, trial[1] / length], limit / length)
    } else {
        ([0.0; 2], 0.0)
    };
    let slip_slope = bounded(mu * slope_n);
    let row = |q: usize| {
        let across = [n[1] * n[1], n[0] * n[0]][q];
        let mixed = -n[0] * n[1];
        let p = 1 - q;
        let mut row = [0.0; 3];
        row[q] = ratio * across * d_trial[q][0];
        row[p] = ratio * mixed * d_trial[p][0];
        row[2] = ratio * (across * d_trial[q][1] + mixed * d_trial[p][1]) + slip_slope * n[q];
        row
    };
    Response {
        t: [limit * n[0], limit * n[1], t_n],
        tangential: [row(0), row(1)],
        normal: slope_n,
        regime: Regime::Slip,
    }
}

/// Stuck trial of [`HistoryRule::Incremental`], with `[d t_q / d u_q, d t_q / d u_n]` per direction.
#[inline(always)]
fn incremental_trial<C: ContactCurves>(
    curves: &C,
    u: [f64; 3],
    u_begin: [f64; 3],
    t_begin: [f64; 2],
) -> ([f64; 2], [[f64; 2]; 2]) {
    let (u_n, u_n0) = (u[2], u_begin[2]);
    let lower = u_n0.max(0.0);
    // The mean of two positive numbers: halves first, their sum could overflow; but a halved denormal could vanish.
    let middle = (0.5 * u_n + 0.5 * lower).max(f64::from_bits(1));
    let k = curves.tangential(middle);
    let path = u_n - u_n0;
    let share = if u_n0 < 0.0 { u_n / path } else { 1.0 };
    let mut trial = [0.0; 2];
    let mut d_trial = [[0.0; 2]; 2];
    for q in 0..2 {
        let du = bounded(u[q] - u_begin[q]);
        let (value, slope) = (bounded(k[q].value), bounded(k[q].slope));
        // d share / d u_n = (1 - share)/path, and the middle moves by half.
        let share_term = if u_n0 < 0.0 {
            bounded(value / path) * (1.0 - share)
        } else {
            0.0
        };
        trial[q] = bounded(t_begin[q] + share * value * du);
        d_trial[q] = [share * value, bounded((share_term + 0.5 * share * slope) * du)];
    }
    (trial, d_trial)
}

/// Stuck trial of [`HistoryRule::Paper`], with `[d t_q / d u_q, d t_q / d u_n]` per direction.
#[inline(always)]
fn paper_trial<C: ContactCurves>(
    curves: &C,
    u: [f64; 3],
    u_begin: [f64; 3],
    t_begin: [f64; 2],
) -> ([f64; 2], [[f64; 2]; 2]) {
    let du_n = bounded(u[2] - u_begin[2]);
    let k = curves.tangential(u[2]);
    let mut trial = [0.0; 2];
    let mut d_trial = [[0.0; 2]; 2];
    for q in 0..2 {
        let (total, du) = (bounded(u[q]), bounded(u[q] - u_begin[q]));
        let (value, slope, curvature) = (bounded(k[q].value), bounded(k[q].slope), bounded(k[q].curvature));
        let normal_part = bounded(slope * du_n);
        trial[q] = bounded(t_begin[q] + bounded(value * du) + bounded(normal_part * total));
        d_trial[q] = [
            bounded(value + normal_part),
            bounded(bounded(slope * (du + total)) + bounded(bounded(curvature * du_n) * total)),
        ];
    }
    (trial, d_trial)
}

/// Brings what overflowed back into a range where sums and products of a few such values stay finite or at least
/// never turn into NaN. No physical value comes near it.
#[inline(always)]
fn bounded(value: f64) -> f64 {
    const LARGEST: f64 = 1e300;
    value.clamp(-LARGEST, LARGEST)
}

/// Euclidean length; the plain form where its squares neither overflow nor underflow.
#[inline(always)]
fn length(t: [f64; 2]) -> f64 {
    let square = t[0] * t[0] + t[1] * t[1];
    if square > 1e-280 && square < 1e280 {
        square.sqrt()
    } else {
        t[0].hypot(t[1])
    }
}
