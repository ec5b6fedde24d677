//! Contact linearised about a static state: constant stiffnesses, and a slip limit that pressure no longer moves.
//!
//! What quasi-static modal analysis (QSMA) before CQSMA makes of the normal contact (eq. 34): its first-order Taylor
//! expansion about the static state `u*`, `t*`. With it the tangential stiffnesses and the slip limit are those of the
//! static state, too. At a point that is closed there
//! <div>
//! $$ t_n = t_n^* + k_n (u_n - u_n^*), \qquad
//! t_q^{\text{trial}} = t_{q0} + k_q (u_q - u_{q0}), \qquad
//! |\boldsymbol{t}_t| \le l = \mu t_n^* , $$
//! </div>
//!
//! with slip along the trial, as on the [cone](crate::friction). The contact is bilateral: a closed point stays closed
//! and may pull, an open one stays open and carries nothing. Normal motion does not
//! reach the tangential tractions: closed collinear cycles obey Masing's rule.
//!
//! Tangent: `diag(k_x, k_y, k_n)` when stuck, in slip along the surface
//! <div>
//! $$ \frac{l}{|\boldsymbol{t}^{\text{trial}}|}
//! \left( \boldsymbol{I} - \boldsymbol{s} \boldsymbol{s}^{\mathsf{T}} \right) \operatorname{diag}(k_x, k_y),
//! \qquad \boldsymbol{s} = \boldsymbol{t}^{\text{trial}} / |\boldsymbol{t}^{\text{trial}}| . $$
//! </div>
//!
//! Where the slip limit is zero every closed point slips.
//!
//! # Parameters and state
//! | quantity | unit |
//! |---|---|
//! | stiffnesses `k_n`, `k_x`, `k_y`, not negative | Pa/m |
//! | slip limit, not negative | Pa |
//! | state `d_x, d_y`: displacement from the static state at the last commit | m |
//! | state `s_x, s_y`: traction beyond that of the static state at the last commit | Pa |
//!
//! **A state of zeros is the static state**, slip history included, not a point that touches nothing.
//!
//! Source: N. N. Balaji, W. Chen and M. R. W. Brake, *Traction-based multi-scale nonlinear dynamic modeling of bolted
//! joints: formulation, application, and trends in micro-scale interface evolution*, Mech. Syst. Signal Process. 139,
//! 2020, 106615, eqs. (34)-(36).
//!
//! # Example
//! ```
//! use contact_laws::*;
//!
//! // A Hertzian interface pressed by 1 um: t_n* = 2 MPa, 3 TPa/m there; k_t* = 1.5 TPa/m, mu = 0.3.
//! let point = StaticPoint {
//!     jump: [0.0, 0.0, 1e-6],
//!     traction: [0.0, 0.0, 2e6],
//!     stiffness: [1.5e12, 1.5e12, 3e12],
//!     slip_limit: 0.3 * 2e6,
//! };
//! let law = LinearisedContact::try_new(vec![Some(point)])?;
//! // Lifted beyond first touch it pulls, and still slips at 0.6 MPa.
//! let (begin, mut end, [mut t_x, mut t_y, mut t_n]) = ([0.0; 4], [0.0; 4], [[0.0]; 3]);
//! law.evaluate(
//!     0..1,
//!     Sticking::Coulomb,
//!     Components::new(&[1e-6], &[0.0], &[-0.5e-6]),
//!     StateView::new(&begin, 1, 0),
//!     StateViewMut::new(&mut end, 1, 0),
//!     ComponentsMut::new(&mut t_x, &mut t_y, &mut t_n),
//!     None,
//!     None,
//! );
//! assert!((t_n[0] + 2.5e6).abs() < 1e-3 && (t_x[0] - 0.6e6).abs() < 1e-3);
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

use alloc::vec;
use alloc::vec::Vec;

use core::ops::Range;

use crate::error::{Error, Place, require};
use crate::law::{
    Along, Components, ComponentsMut, LawInfo, PAPER_DOI, Quantity, Regime, RegimeCounts, StateView, StateViewMut,
    Sticking, TangentMut, TractionLaw, evaluates_by,
};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// Number of state components.
const N_STATE: usize = 4;

/// The static state of a closed point, and the stiffness about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticPoint {
    /// Jump `u*` along x, y, n (m).
    pub jump: [f64; 3],
    /// Traction `t*` along x, y, n (Pa).
    pub traction: [f64; 3],
    /// Stiffness per area along x, y, n (Pa/m).
    pub stiffness: [f64; 3],
    /// Largest tangential traction (Pa), at least that of the static state.
    pub slip_limit: f64,
}

/// Contact linearised about a static state. State per point: `d_x, d_y` (m) and `s_x, s_y` (Pa), zero at the static
/// state.
#[derive(Debug, Clone)]
pub struct LinearisedContact {
    points: Vec<Option<StaticPoint>>,
    info: LawInfo,
}

impl LinearisedContact {
    /// From the closed points; `None` is a point that stays open.
    ///
    /// # Errors
    /// [`Error::Parameter`] with the point when a value is not finite, a stiffness is negative, or a slip limit is
    /// below the tangential traction.
    pub fn try_new(points: Vec<Option<StaticPoint>>) -> Result<Self, Error> {
        for (i, point) in points.iter().enumerate() {
            let Some(p) = point else { continue };
            let place = Place::Point(i);
            for value in p.jump {
                require(value.is_finite(), "jump", value, "m", place, "finite")?;
            }
            for value in p.traction {
                require(value.is_finite(), "traction", value, "Pa", place, "finite")?;
            }
            for (name, k) in ["k_x", "k_y", "k_n"].into_iter().zip(p.stiffness) {
                let ok = k.is_finite() && k >= 0.0;
                require(ok, name, k, "Pa/m", place, "finite and not negative")?;
            }
            let (limit, carried) = (p.slip_limit, p.traction[0].hypot(p.traction[1]));
            require(
                limit.is_finite() && limit >= carried,
                "slip_limit",
                limit,
                "Pa",
                place,
                "finite and not below the tangential traction",
            )?;
        }
        Ok(Self {
            points,
            info: LawInfo {
                name: "contact linearised about a static state",
                reference: PAPER_DOI,
                state: vec![
                    Quantity::new("d_x", "m"),
                    Quantity::new("d_y", "m"),
                    Quantity::new("s_x", "Pa"),
                    Quantity::new("s_y", "Pa"),
                ],
                parameters: vec![
                    Quantity::new("k_x", "Pa/m"),
                    Quantity::new("k_y", "Pa/m"),
                    Quantity::new("k_n", "Pa/m"),
                    Quantity::new("slip_limit", "Pa"),
                ],
            },
        })
    }

    /// Any law, linearised about the static state with the jumps `jump` (m) and the committed history `state`:
    /// tractions with friction, stiffnesses from the diagonal of the stuck tangent, slip limits `mu t_n`.
    ///
    /// With [`HistoryRule::Potential`](crate::HistoryRule::Potential) the stuck tangent couples normal and tangential
    /// motion, and that part is left out; the limit is then slightly above the law's own.
    ///
    /// # Errors
    /// [`Error::Length`] when a list does not fit the law, [`Error::Combination`] for a law without
    /// [friction coefficient](TractionLaw::friction_coefficient), and as [`Self::try_new`] when the state is not finite.
    pub fn about(law: &dyn TractionLaw, jump: Components<'_>, state: StateView<'_>) -> Result<Self, Error> {
        let (n, n_state) = (law.len(), law.info().n_state());
        let needed = state.offset + n_state.saturating_sub(1) * state.stride + n;
        for (list, expected, found) in [
            ("jump.x", n, jump.x.len()),
            ("jump.y", n, jump.y.len()),
            ("jump.n", n, jump.n.len()),
            ("state", needed, state.data.len().min(needed)),
        ] {
            if found != expected {
                return Err(Error::Length { list, expected, found });
            }
        }
        let mut end = vec![0.0; n * n_state];
        let mut regimes = vec![Regime::Open; n];
        let [mut x, mut y, mut normal] = [(); 3].map(|()| vec![0.0; n]);
        let mut tangent: [Vec<f64>; 9] = core::array::from_fn(|_| vec![0.0; n]);
        // The last evaluation leaves the tractions, those with friction.
        for sticking in [Sticking::Full, Sticking::Coulomb] {
            let stuck = sticking == Sticking::Full;
            law.evaluate(
                0..n,
                sticking,
                jump,
                state,
                StateViewMut::new(&mut end, n, 0),
                ComponentsMut::new(&mut x, &mut y, &mut normal),
                stuck.then(|| TangentMut::from_entries(tangent.each_mut().map(Vec::as_mut_slice))),
                Some(&mut regimes),
            );
        }
        let mu = (0..n).map(|i| {
            law.friction_coefficient(i).ok_or(Error::Combination {
                first: "slip limits that are no constant share of the normal traction",
                second: "linearised contact",
                remedy: "take Coulomb's limit, or a method that does not linearise the contact",
            })
        });
        let mu = mu.collect::<Result<Vec<f64>, Error>>()?;
        let points = (0..n).map(|i| {
            let closed = StaticPoint {
                jump: [jump.x[i], jump.y[i], jump.n[i]],
                traction: [x[i], y[i], normal[i]],
                stiffness: [tangent[0][i], tangent[4][i], tangent[8][i]],
                // A point that slips carries its limit to the last bit.
                slip_limit: (mu[i] * normal[i]).max(x[i].hypot(y[i])),
            };
            (regimes[i] != Regime::Open).then_some(closed)
        });
        Self::try_new(points.collect())
    }

    /// The closed points; `None` is an open one.
    pub fn points(&self) -> &[Option<StaticPoint>] {
        &self.points
    }
}

/// What a point answers: tractions along x, y, n, their derivatives, and state reached.
struct Response {
    regime: Regime,
    traction: [f64; 3],
    /// Derivatives of the tangential traction with respect to its trial: `xx, xy, yy`.
    passed: [f64; 3],
    /// Stiffness along x, y, n (Pa/m): derivative of the trial and of the normal traction.
    stiffness: [f64; 3],
    end: [f64; N_STATE],
}

impl Response {
    fn uniform(value: f64, regime: Regime) -> Self {
        Self {
            regime,
            traction: [value; 3],
            passed: [value; 3],
            stiffness: [value; 3],
            end: [value; N_STATE],
        }
    }

    /// Of an open, closed or invalid point.
    fn new(point: Option<&StaticPoint>, sticking: Sticking, u: [f64; 3], begin: [f64; N_STATE]) -> Self {
        let finite = u.iter().chain(&begin).all(|v| v.is_finite());
        match point {
            _ if !finite => Self::uniform(f64::NAN, Regime::Invalid),
            None => Self::uniform(0.0, Regime::Open),
            Some(point) => point.respond(sticking, u, begin),
        }
    }

    /// `xx, xy, yx, yy, nn` of the tangent; the other entries are zero.
    fn tangent(&self) -> [f64; 5] {
        let ([xx, xy, yy], [k_x, k_y, k_n]) = (self.passed, self.stiffness);
        [xx * k_x, xy * k_y, xy * k_x, yy * k_y, k_n]
    }

    /// Derivatives of the tractions and of the state reached along a direction.
    fn change(&self, d: [f64; 3], d_begin: [f64; N_STATE]) -> ([f64; 3], [f64; N_STATE]) {
        let finite = d.iter().chain(&d_begin).all(|v| v.is_finite());
        match self.regime {
            Regime::Invalid => return ([f64::NAN; 3], [f64::NAN; N_STATE]),
            _ if !finite => return ([f64::NAN; 3], [f64::NAN; N_STATE]),
            Regime::Open => return ([0.0; 3], [0.0; N_STATE]),
            Regime::Stick | Regime::Slip => {}
        }
        let ([xx, xy, yy], k) = (self.passed, self.stiffness);
        let trial: [f64; 2] = core::array::from_fn(|q| d_begin[2 + q] + k[q] * (d[q] - d_begin[q]));
        let [x, y] = [xx * trial[0] + xy * trial[1], xy * trial[0] + yy * trial[1]];
        ([x, y, k[2] * d[2]], [d[0], d[1], x, y])
    }
}

impl StaticPoint {
    fn respond(&self, sticking: Sticking, u: [f64; 3], begin: [f64; N_STATE]) -> Response {
        let d: [f64; 3] = core::array::from_fn(|q| u[q] - self.jump[q]);
        let k = self.stiffness;
        // Beyond the static traction, so that small motions keep their digits.
        let beyond: [f64; 2] = core::array::from_fn(|q| begin[2 + q] + k[q] * (d[q] - begin[q]));
        let trial: [f64; 2] = core::array::from_fn(|q| self.traction[q] + beyond[q]);
        let length = trial[0].hypot(trial[1]);
        let t_n = self.traction[2] + k[2] * d[2];
        let slip_limit = match sticking {
            Sticking::Frictionless => 0.0,
            Sticking::Coulomb | Sticking::Full => self.slip_limit,
        };
        if sticking == Sticking::Full || (length <= slip_limit && slip_limit > 0.0) {
            return Response {
                regime: Regime::Stick,
                traction: [trial[0], trial[1], t_n],
                passed: [1.0, 0.0, 1.0],
                stiffness: k,
                end: [d[0], d[1], beyond[0], beyond[1]],
            };
        }
        // A trial of no length has no direction to slip in.
        let (s, share) = match length > 0.0 {
            true => (trial.map(|t| t / length), slip_limit / length),
            false => ([0.0; 2], 0.0),
        };
        let t = s.map(|s| slip_limit * s);
        let across = share * s[0] * s[1];
        Response {
            regime: Regime::Slip,
            traction: [t[0], t[1], t_n],
            passed: [share * s[1] * s[1], -across, share * s[0] * s[0]],
            stiffness: k,
            end: [d[0], d[1], t[0] - self.traction[0], t[1] - self.traction[1]],
        }
    }
}

impl LinearisedContact {
    fn answer(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        mut tangent: Option<TangentMut<'_>>,
        mut regimes: Option<&mut [Regime]>,
        along: Option<Along<'_>>,
    ) -> RegimeCounts {
        let n = points.len();
        let begin = begin.components::<N_STATE>(n);
        let mut end = end.components::<N_STATE>(n);
        let mut along = along.map(|along| {
            let (d_begin, d_end) = (
                along.d_begin.components::<N_STATE>(n),
                along.d_end.components::<N_STATE>(n),
            );
            (along.d_jump, d_begin, d_end, along.d_traction)
        });
        let mut counts = RegimeCounts::default();
        for (i, point) in self.points[points].iter().enumerate() {
            let u = [jump.x[i], jump.y[i], jump.n[i]];
            let begin = begin.map(|component| component[i]);
            let response = Response::new(point.as_ref(), sticking, u, begin);
            [traction.x[i], traction.y[i], traction.n[i]] = response.traction;
            for (component, value) in end.iter_mut().zip(response.end) {
                component[i] = value;
            }
            if let Some((d_jump, d_begin, d_end, d_traction)) = &mut along {
                let d = [d_jump.x[i], d_jump.y[i], d_jump.n[i]];
                let (change, end_change) = response.change(d, d_begin.map(|component| component[i]));
                [d_traction.x[i], d_traction.y[i], d_traction.n[i]] = change;
                for (component, value) in d_end.iter_mut().zip(end_change) {
                    component[i] = value;
                }
            }
            if let Some(out) = tangent.as_mut() {
                [out.xx[i], out.xy[i], out.yx[i], out.yy[i], out.nn[i]] = response.tangent();
                let nothing = if response.regime == Regime::Invalid {
                    f64::NAN
                } else {
                    0.0
                };
                for entry in [&mut out.xn, &mut out.yn, &mut out.nx, &mut out.ny] {
                    entry[i] = nothing;
                }
            }
            if let Some(out) = regimes.as_mut() {
                out[i] = response.regime;
            }
            counts.count(response.regime);
        }
        counts
    }
}

impl TractionLaw for LinearisedContact {
    fn info(&self) -> &LawInfo {
        &self.info
    }

    fn len(&self) -> usize {
        self.points.len()
    }

    evaluates_by!(answer);
}
