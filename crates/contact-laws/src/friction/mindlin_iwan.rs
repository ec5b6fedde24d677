//! Microslip: parallel sliders (Iwan) that follow the Cattaneo-Mindlin loading curve on top of any contact curves.
//!
//! [`FrictionalLaw`](crate::FrictionalLaw) sticks until it slips as a whole, so it dissipates nothing below the slip
//! limit. A Hertz contact slips from its rim inwards at any load; under constant normal force its first loading is
//! (Cattaneo 1938, Mindlin 1949; [`crate::mindlin`])
//! <div>
//! $$ t = \mu t_n \left(1 - (1 - x)^{3/2}\right), \qquad x = \frac{|u_t|}{d}, \qquad d = \frac{3 \mu t_n}{2 k_t} $$
//! </div>
//!
//! and unloading and reloading follow by Masing's rule. Elastic, perfectly plastic sliders in parallel (Iwan 1966) obey
//! Masing's rule by construction, and they follow this curve when the share `dp` of the stiffness yields at
//! `x(p) = 2 p - p^2`, `p` from 0 to 1:
//! <div>
//! $$ \frac{t}{\mu t_n} = \frac{3}{2} \int_0^1 \min\left(x,\, x(p)\right) dp, \qquad
//!    x(p) = 2 p - p^2 $$
//! </div>
//!
//! `N` sliders divide `p` at `p_0 = 0 < p_1 < ... < p_N = 1`. Slider `i` takes over the stiffness and the slip limit of
//! its part,
//! <div>
//! $$ w_i = p_i - p_{i-1}, \qquad
//!    s_i = \frac{3}{2} \int_{p_{i-1}}^{p_i} x(p)\, dp
//!        = \left[\tfrac{3}{2} p^2 - \tfrac{1}{2} p^3\right]_{p_{i-1}}^{p_i},
//!    \qquad \sum_i w_i = \sum_i s_i = 1, $$
//! </div>
//!
//! so that the stiffness of small displacements is exactly `k_t` and gross slip carries exactly `mu t_n`, whatever `N`:
//! the loading curve is a polygon of tangents to the exact one. One slider is elastic dry friction.
//!
//! # At a point
//! The state of slider `i` is its elastic stretch `e_i` (m). From the jump and the stretches of the begin state,
//! <div>
//! $$ \begin{aligned}
//!    e_{iq} &= e_{iq,0} + f (u_q - u_{q,0}), \qquad q \in \{x, y\}, \\
//!    t_{iq} &= w_i k_q(u_n)\, e_{iq} \quad \text{if its length is at most } s_i \mu t_n(u_n), \\
//!    t_i &= s_i \mu t_n(u_n)\, \frac{t_i^{\text{trial}}}{|t_i^{\text{trial}}|} \quad \text{otherwise},
//!    \qquad t_q = \sum_i t_{iq},
//!    \end{aligned} $$
//! </div>
//!
//! where slip shortens both components of `e_i` by the ratio that shortens the traction, also with `k_x` unlike `k_y`.
//! `f` is the share of the straight path from the begin state that is closed, `u_n / (u_n - u_n0)` for a point that was
//! open and 1 for one that was closed: sliders start where the path meets `u_n = 0`. Open points have no stretch and no
//! traction.
//!
//! - The stretch is stored rather than the position where a slider grips: a stretch keeps its digits when it is small
//!   against the displacements, a position minus a displacement does not.
//! - At changing `u_n` a sticking slider keeps its stretch, so its traction follows `k_q(u_n)`. The normal traction has
//!   no term that answers this: a stuck cycle along which `u_n` changes may gain or lose a little energy. At constant
//!   `u_n`, with a commit at every step, no path gives back more than was put in.
//! - [`Regime::Slip`] is gross slip: no slider sticks. [`Regime::Stick`] is everything else in contact, partial slip
//!   included: the traction can still grow. With `mu = 0` every closed point slips.
//! - [`Sticking::Full`] lets no slider slip.
//!
//! # Parameters and state
//! | quantity | unit |
//! |---|---|
//! | parameters of the curves | |
//! | friction coefficient `mu`, not negative, per point | 1 |
//! | number of sliders `N`, 1 to 256 | 1 |
//! | state `u_x, u_y, u_n` of the point committed last | m |
//! | state `e_x_i, e_y_i` of every slider: `3 + 2 N` numbers in all | m |
//!
//! # Derivative along a direction
//! [`TractionLaw::derivative`] adds up `dt_i = w_i d(k e_i)` over the sliders that stick. For one that slips, with the
//! direction `n` of its trial and the ratio `r` by which slip shortens it,
//! `dt_i = w_i r (I - n n) d(k e_i) + s_i d(mu t_n) n`, and its stretch changes by `d(r e_i)`.
//!
//! # How many sliders
//! Where the sliders yield is graded, `p_j = (exp(6 j/N) - 1)/(exp(6) - 1)`: among power laws and exponentials in `p`
//! and in `x`, measured for 2 to 64 sliders, this one or one next to it has the smallest largest error of the loop
//! area over amplitudes `x` from 0.01 to 2. The errors below are the largest over the range: of the loading curve
//! relative to `mu t_n`, of the loop area relative to the closed form. Below `x_1`, where the first slider slips,
//! nothing dissipates and the error of the loop area is 1.
//!
//! | `N` | `x_1` | loading curve | loop area, `x` in 0.1..2 | loop area, `x` in 0.01..2 | cost |
//! |---|---|---|---|---|---|
//! | 1 | 0.67 | 0.19 | 1 | 1 | 1.2 |
//! | 2 | 0.047 | 0.17 | 0.96 | 1 | 1.4 |
//! | 4 | 0.0086 | 0.091 | 0.68 | 0.78 | 1.6 |
//! | 8 | 0.0028 | 0.028 | 0.28 | 0.46 | 2.1 |
//! | 16 | 0.0011 | 0.0073 | 0.078 | 0.13 | 2.8 |
//! | 32 | 0.00051 | 0.0019 | 0.021 | 0.036 | 4.2 |
//!
//! Cost: time per point with tangent relative to [`FrictionalLaw`](crate::FrictionalLaw) on the same scalar curves
//! (interleaved in one run, 15 000 points in a mix of partial slip, gross slip and open).
//!
//! Sources: R. D. Mindlin, *Compliance of elastic bodies in contact*, J. Appl. Mech. 16 (1949) 259-268; W. D. Iwan, *A
//! distributed-element model for hysteresis and its steady-state dynamic response*, J. Appl. Mech. 33 (1966) 893-900.
//!
//! # Example
//! ```
//! use contact_laws::*;
//!
//! // k_n, k_x = k_y (Pa/m) at one point, mu = 0.2, 16 sliders.
//! let curves = PointParameters::uniform(ElasticCurves::try_new(2e12, [1.5e12; 2])?, 1);
//! let law = MindlinIwan::try_new(curves, PointParameters::uniform(0.2, 1), 16)?;
//!
//! // Closed by 5 um: t_n = 10 MPa, gross slip at 2 MPa, which is reached at d = 2 um.
//! let mut begin = vec![0.0; law.info().n_state()];
//! begin[2] = 5e-6;
//! let mut end = begin.clone();
//! for (u_x, exact) in [(0.5e-6, 0.7010e6), (1e-6, 1.2929e6), (3e-6, 2e6)] {
//!     let [mut t_x, mut t_y, mut t_n] = [[0.0]; 3];
//!     law.evaluate(
//!         0..1,
//!         Sticking::Coulomb,
//!         Components::new(&[u_x], &[0.0], &[5e-6]),
//!         StateView::new(&begin, 1, 0),
//!         StateViewMut::new(&mut end, 1, 0),
//!         ComponentsMut::new(&mut t_x, &mut t_y, &mut t_n),
//!         None,
//!         None,
//!     );
//!     assert!((t_x[0] - exact).abs() < 0.01 * 2e6);
//! }
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

use alloc::borrow::Cow;
use alloc::format;
use alloc::vec::Vec;

use core::ops::Range;

use crate::curves::ContactCurves;
use crate::error::Error;
use crate::friction::{JUMP, MU, require_friction};
use crate::law::{
    Along, Components, ComponentsMut, LawInfo, Quantity, Regime, RegimeCounts, StateView, StateViewMut, Sticking,
    TangentMut, TractionLaw, evaluates_by,
};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::{Bounds, Parameter, PointParameters};

/// Most sliders that a [`MindlinIwan`] takes.
pub const MAX_SLIDERS: usize = 256;

pub(super) const N_SLIDERS: Parameter = Parameter::new(
    "n_sliders",
    "1",
    Bounds::Within([1.0, MAX_SLIDERS as f64], "from 1 to 256"),
);

/// Exponent of the grading of the sliders, see the [module](self).
const GRADING: f64 = 6.0;

/// State components before the sliders' stretches: the jump.
const N_JUMP: usize = 3;

/// Contact curves with parallel sliders. State per point: `u_x, u_y, u_n` (m), then `e_x, e_y` (m) of every slider.
#[derive(Debug, Clone)]
pub struct MindlinIwan<C> {
    curves: PointParameters<C>,
    mu: PointParameters<f64>,
    sliders: Vec<Slider>,
    info: LawInfo,
}

/// One of the parallel sliders.
#[derive(Debug, Clone, Copy)]
struct Slider {
    /// Share of the stiffness, `w_i`.
    stiffness: f64,
    /// Share of the slip limit, `s_i`.
    limit: f64,
    /// `s_i / w_i`.
    limit_per_stiffness: f64,
}

impl<C: ContactCurves> MindlinIwan<C> {
    /// A law over `curves.len()` points with the friction coefficient `mu` per point and `n_sliders` from 1 to
    /// [`MAX_SLIDERS`] at every point.
    ///
    /// # Errors
    /// [`Error::Length`] when `mu` has another number of points, [`Error::Parameter`] when a coefficient is negative or
    /// not finite or when the number of sliders is out of bounds.
    pub fn try_new(curves: PointParameters<C>, mu: PointParameters<f64>, n_sliders: usize) -> Result<Self, Error> {
        require_friction(&mu, curves.len())?;
        N_SLIDERS.check(n_sliders as f64)?;

        let stretches = (1..=n_sliders).flat_map(|i| {
            ["x", "y"].map(|q| Quantity {
                name: Cow::Owned(format!("e_{q}_{i}")),
                unit: "m",
            })
        });
        let parameters = match curves.is_empty() {
            true => &[][..],
            false => curves.at(0).info().parameters,
        };
        let info = LawInfo {
            name: "Mindlin-Iwan friction",
            reference: "10.1115/1.3625199",
            state: JUMP.into_iter().chain(stretches).collect(),
            parameters: parameters.iter().map(Parameter::quantity).chain([MU]).collect(),
        };
        Ok(Self {
            curves,
            mu,
            sliders: sliders(n_sliders),
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

    /// Number of sliders at every point.
    pub fn n_sliders(&self) -> usize {
        self.sliders.len()
    }

    fn answer(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        tangent: Option<TangentMut<'_>>,
        regimes: Option<&mut [Regime]>,
        along: Option<Along<'_>>,
    ) -> RegimeCounts {
        let run = match (tangent.is_some(), along.is_some()) {
            (_, true) => Self::run::<false, true>,
            (true, false) => Self::run::<true, false>,
            (false, false) => Self::run::<false, false>,
        };
        run(
            self, points, sticking, jump, begin, end, traction, tangent, regimes, along,
        )
    }

    /// The loop over the points, compiled apart with and without tangent and along a direction.
    fn run<const TANGENT: bool, const ALONG: bool>(
        &self,
        points: Range<usize>,
        sticking: Sticking,
        jump: Components<'_>,
        begin: StateView<'_>,
        end: StateViewMut<'_>,
        traction: ComponentsMut<'_>,
        mut tangent: Option<TangentMut<'_>>,
        mut regimes: Option<&mut [Regime]>,
        mut along: Option<Along<'_>>,
    ) -> RegimeCounts {
        let n = points.len();
        let n_state = self.info.n_state();
        debug_assert!(jump.x.len() == n && jump.y.len() == n && jump.n.len() == n);
        debug_assert!(traction.x.len() == n && traction.y.len() == n && traction.n.len() == n);

        let mut counts = RegimeCounts::default();
        for (i, point) in points.enumerate() {
            let u = [jump.x[i], jump.y[i], jump.n[i]];
            let begin_at = |c: usize| begin.data[c * begin.stride + begin.offset + i];
            let end_index = |c: usize| c * end.stride + end.offset + i;

            let mut change = [0.0; 3];
            let finite = u.iter().all(|v| v.is_finite()) && (0..n_state).all(|c| begin_at(c).is_finite());
            let response = if !finite {
                (0..n_state).for_each(|c| end.data[end_index(c)] = f64::NAN);
                Response::uniform(f64::NAN, Regime::Invalid)
            } else {
                (0..N_JUMP).for_each(|c| end.data[end_index(c)] = u[c]);
                if u[2] <= 0.0 {
                    (N_JUMP..n_state).for_each(|c| end.data[end_index(c)] = 0.0);
                    Response::uniform(0.0, Regime::Open)
                } else {
                    let u_begin = [begin_at(0), begin_at(1), begin_at(2)];
                    let mut sum = Sum::new(self.curves.at(point), *self.mu.at(point), sticking, u, u_begin);
                    let mut changes = match &along {
                        Some(along) if ALONG => Change::new(&sum, u, u_begin, along.jump(i), along.begin(0, i)),
                        _ => Change::default(),
                    };
                    for (slider, c) in self.sliders.iter().zip((N_JUMP..).step_by(2)) {
                        let begin = [begin_at(c), begin_at(c + 1)];
                        let stretch = sum.add::<TANGENT>(slider, begin);
                        (end.data[end_index(c)], end.data[end_index(c + 1)]) = (stretch[0], stretch[1]);
                        if ALONG && let Some(along) = along.as_mut() {
                            let change = changes.add(&sum, slider, begin, along.begin(c, i));
                            along.set_end(c, i, change);
                        }
                    }
                    change = [changes.traction[0], changes.traction[1], changes.normal];
                    sum.response()
                }
            };

            (traction.x[i], traction.y[i], traction.n[i]) = (response.t[0], response.t[1], response.t[2]);
            if ALONG && let Some(along) = along.as_mut() {
                let d = along.jump(i);
                let directed =
                    d.iter().all(|v| v.is_finite()) && (0..n_state).all(|c| along.begin::<1>(c, i)[0].is_finite());
                if !(finite && directed) {
                    change = [f64::NAN; 3];
                    (0..n_state).for_each(|c| along.set_end(c, i, [f64::NAN]));
                } else {
                    along.set_end(0, i, d);
                    if response.regime == Regime::Open {
                        (N_JUMP..n_state).for_each(|c| along.set_end(c, i, [0.0]));
                    }
                }
                let out = &mut along.d_traction;
                [out.x[i], out.y[i], out.n[i]] = change;
            }
            if TANGENT && let Some(out) = tangent.as_mut() {
                let [x, y, n] = response.tangent;
                (out.xx[i], out.xy[i], out.xn[i]) = (x[0], x[1], x[2]);
                (out.yx[i], out.yy[i], out.yn[i]) = (y[0], y[1], y[2]);
                (out.nx[i], out.ny[i], out.nn[i]) = (n[0], n[1], n[2]);
            }
            if let Some(out) = regimes.as_mut() {
                out[i] = response.regime;
            }
            counts.count(response.regime);
        }
        counts
    }
}

impl<C: ContactCurves> TractionLaw for MindlinIwan<C> {
    fn info(&self) -> &LawInfo {
        &self.info
    }

    fn len(&self) -> usize {
        self.curves.len()
    }

    evaluates_by!(answer);

    fn friction_coefficient(&self, point: usize) -> Option<f64> {
        Some(*self.mu.at(point))
    }

    fn slips_in_parts(&self) -> bool {
        true
    }

    fn contact_area_ratio(&self, point: usize, u_n: f64) -> Option<f64> {
        self.curves.at(point).contact_area_ratio(u_n)
    }

    fn yielded_fraction(&self, point: usize, u_n: f64, omega_c: f64) -> Option<f64> {
        self.curves.at(point).yielded_fraction(u_n, omega_c)
    }
}

/// The sliders for parts of `p` whose widths grow exponentially.
fn sliders(n: usize) -> Vec<Slider> {
    let node = |j: usize| (GRADING * j as f64 / n as f64).exp_m1() / GRADING.exp_m1();
    // The last one takes what is left of 1, so that the sums, taken in this order, are 1 to the last bit.
    let (mut stiffness_sum, mut limit_sum) = (0.0, 0.0);
    (1..=n)
        .map(|j| {
            let (a, b) = (node(j - 1), node(j));
            let (stiffness, limit) = if j < n {
                let stiffness = b - a;
                (stiffness, stiffness * (1.5 * (a + b) - 0.5 * (a * a + a * b + b * b)))
            } else {
                (1.0 - stiffness_sum, 1.0 - limit_sum)
            };
            stiffness_sum += stiffness;
            limit_sum += limit;
            Slider {
                stiffness,
                limit,
                limit_per_stiffness: limit / stiffness,
            }
        })
        .collect()
}

/// Shares of the slip limit and of the stiffness of `n` sliders.
pub(super) fn shares(n: usize) -> Vec<[f64; 2]> {
    sliders(n)
        .iter()
        .map(|slider| [slider.limit, slider.stiffness])
        .collect()
}

/// What one point answers.
struct Response {
    t: [f64; 3],
    tangent: [[f64; 3]; 3],
    regime: Regime,
}

impl Response {
    /// The same value everywhere.
    fn uniform(value: f64, regime: Regime) -> Self {
        Self {
            t: [value; 3],
            tangent: [[value; 3]; 3],
            regime,
        }
    }
}

/// Sum over the sliders of a closed point.
struct Sum {
    /// `t_n` and its derivative.
    normal: [f64; 2],
    /// `mu t_n` and its derivative.
    grip: [f64; 2],
    /// `mu t_n`, or infinity where nothing slips.
    limit: f64,
    /// `k_q(u_n)`.
    k: [f64; 2],
    /// `d k_q / d u_n`.
    k_slope: [f64; 2],
    /// Share of the path that is closed.
    closed: f64,
    /// Stretch added since the begin state.
    step: [f64; 2],
    /// `k_q d step_q / d u_n`.
    k_d_step: [f64; 2],

    /// Traction of the sliders that stick.
    stuck: [f64; 2],
    /// Traction of the sliders that slip, per `mu t_n`.
    slipping: [f64; 2],
    /// With `J = I` for sliders that stick and `J = (s_i mu t_n / |t_i|) (I - n n)` for those that slip: sum of `w_i J`
    /// (xx, yy, xy), by which a change of `k_q u_q` reaches the traction.
    passed: [f64; 3],
    /// Sum of `w_i J` times the change of `k_q e_iq` with `u_n`.
    passed_closing: [f64; 2],
    n_stuck: usize,
}

impl Sum {
    #[inline(always)]
    fn new<C: ContactCurves>(curves: &C, mu: f64, sticking: Sticking, u: [f64; 3], u_begin: [f64; 3]) -> Self {
        let (u_n, u_n0) = (u[2], u_begin[2]);
        let (t_n, slope_n) = curves.normal(u_n);
        let normal = [bounded(t_n), bounded(slope_n)];
        let mu = if sticking == Sticking::Frictionless { 0.0 } else { mu };
        let grip = normal.map(|v| bounded(mu * v));
        let limit = match sticking {
            Sticking::Coulomb | Sticking::Frictionless => grip[0],
            Sticking::Full => f64::INFINITY,
        };
        let jets = curves.tangential(u_n);
        let k = jets.map(|jet| bounded(jet.value));
        let k_slope = jets.map(|jet| bounded(jet.slope));
        let moved = [u[0] - u_begin[0], u[1] - u_begin[1]].map(bounded);
        let (closed, k_d_step) = if u_n0 < 0.0 {
            let path = u_n - u_n0;
            let closed = u_n / path;
            // d closed / d u_n = (1 - closed)/path.
            let per_path = |q: usize| bounded(bounded(k[q] / path) * (1.0 - closed) * moved[q]);
            (closed, [per_path(0), per_path(1)])
        } else {
            (1.0, [0.0; 2])
        };
        Self {
            normal,
            grip,
            limit,
            k,
            k_slope,
            closed,
            step: moved.map(|v| closed * v),
            k_d_step,
            stuck: [0.0; 2],
            slipping: [0.0; 2],
            passed: [0.0; 3],
            passed_closing: [0.0; 2],
            n_stuck: 0,
        }
    }

    /// What sticking would make of a slider that had the stretch `begin`.
    #[inline(always)]
    fn trial(&self, slider: &Slider, begin: [f64; 2]) -> Trial {
        let stretch = [bounded(begin[0] + self.step[0]), bounded(begin[1] + self.step[1])];
        let trial = [bounded(self.k[0] * stretch[0]), bounded(self.k[1] * stretch[1])];
        Trial {
            stretch,
            trial,
            limit: slider.limit_per_stiffness * self.limit,
            length: length(trial),
        }
    }

    /// Adds a slider that had the stretch `begin`, and returns the stretch it reaches.
    #[inline(always)]
    fn add<const TANGENT: bool>(&mut self, slider: &Slider, begin: [f64; 2]) -> [f64; 2] {
        let w = slider.stiffness;
        let Trial {
            stretch,
            trial,
            limit,
            length,
        } = self.trial(slider, begin);
        let closing = |q: usize| bounded(bounded(self.k_slope[q] * stretch[q]) + self.k_d_step[q]);

        if length <= limit && self.limit > 0.0 {
            self.stuck[0] += w * trial[0];
            self.stuck[1] += w * trial[1];
            self.n_stuck += 1;
            if TANGENT {
                self.passed[0] += w;
                self.passed[1] += w;
                self.passed_closing[0] += w * closing(0);
                self.passed_closing[1] += w * closing(1);
            }
            return stretch;
        }
        // Without a limit nothing is left, and no direction is needed.
        if !(self.limit > 0.0) {
            return [0.0; 2];
        }
        let n = [trial[0] / length, trial[1] / length];
        let ratio = limit / length;
        self.slipping[0] += slider.limit * n[0];
        self.slipping[1] += slider.limit * n[1];
        if TANGENT {
            let scale = w * ratio;
            let [xx, yy, xy] = [scale * n[1] * n[1], scale * n[0] * n[0], -scale * n[0] * n[1]];
            self.passed[0] += xx;
            self.passed[1] += yy;
            self.passed[2] += xy;
            let [x, y] = [closing(0), closing(1)];
            self.passed_closing[0] += xx * x + xy * y;
            self.passed_closing[1] += xy * x + yy * y;
        }
        [ratio * stretch[0], ratio * stretch[1]]
    }

    #[inline(always)]
    fn response(&self) -> Response {
        let [grip, grip_slope] = self.grip;
        let [t_n, slope_n] = self.normal;
        let [k_x, k_y] = self.k.map(|k| k * self.closed);
        let [xx, yy, xy] = self.passed;
        let t = |q: usize| self.stuck[q] + grip * self.slipping[q];
        let closing = |q: usize| self.passed_closing[q] + grip_slope * self.slipping[q];
        Response {
            t: [t(0), t(1), t_n],
            tangent: [
                [xx * k_x, xy * k_y, closing(0)],
                [xy * k_x, yy * k_y, closing(1)],
                [0.0, 0.0, slope_n],
            ],
            regime: if self.n_stuck > 0 { Regime::Stick } else { Regime::Slip },
        }
    }
}

/// A slider that sticks.
struct Trial {
    stretch: [f64; 2],
    /// Traction per share of the stiffness, its limit and its length.
    trial: [f64; 2],
    limit: f64,
    length: f64,
}

impl Along<'_> {
    fn jump(&self, i: usize) -> [f64; 3] {
        [self.d_jump.x[i], self.d_jump.y[i], self.d_jump.n[i]]
    }

    /// `N` components of the begin state's change at a point, from one component on.
    fn begin<const N: usize>(&self, component: usize, i: usize) -> [f64; N] {
        let StateView { data, stride, offset } = self.d_begin;
        core::array::from_fn(|c| data[(component + c) * stride + offset + i])
    }

    fn set_end<const N: usize>(&mut self, component: usize, i: usize, values: [f64; N]) {
        let StateViewMut { data, stride, offset } = &mut self.d_end;
        for (c, value) in values.into_iter().enumerate() {
            data[(component + c) * *stride + *offset + i] = value;
        }
    }
}

/// Derivative of a [`Sum`] along a direction.
#[derive(Default)]
struct Change {
    normal: f64,
    /// `mu t_n`.
    grip: f64,
    /// `k_q(u_n)`.
    k: [f64; 2],
    /// Stretch added since the begin state.
    step: [f64; 2],
    /// Tangential traction of the sliders so far.
    traction: [f64; 2],
}

impl Change {
    #[inline(always)]
    fn new(sum: &Sum, u: [f64; 3], u_begin: [f64; 3], d: [f64; 3], d_begin: [f64; 3]) -> Self {
        let d_n = bounded(d[2]);
        let closed = if u_begin[2] < 0.0 {
            let path = u[2] - u_begin[2];
            let [by_end, by_begin] = [1.0 - sum.closed, sum.closed].map(|share| share / path);
            bounded(bounded(bounded(by_end) * d_n) + bounded(bounded(by_begin) * d_begin[2]))
        } else {
            0.0
        };
        Self {
            normal: bounded(sum.normal[1] * d_n),
            grip: bounded(sum.grip[1] * d_n),
            k: sum.k_slope.map(|slope| bounded(slope * d_n)),
            step: core::array::from_fn(|q| {
                bounded(bounded(closed * bounded(u[q] - u_begin[q])) + bounded(sum.closed * bounded(d[q] - d_begin[q])))
            }),
            traction: [0.0; 2],
        }
    }

    /// Adds a slider that had the stretch `begin`, and returns the change of the stretch it reaches.
    #[inline(always)]
    fn add(&mut self, sum: &Sum, slider: &Slider, begin: [f64; 2], d_begin: [f64; 2]) -> [f64; 2] {
        let w = slider.stiffness;
        let Trial {
            stretch,
            trial,
            limit,
            length,
        } = sum.trial(slider, begin);
        let moved: [f64; 2] = core::array::from_fn(|q| bounded(d_begin[q] + self.step[q]));
        let d: [f64; 2] =
            core::array::from_fn(|q| bounded(bounded(self.k[q] * stretch[q]) + bounded(sum.k[q] * moved[q])));
        if length <= limit && sum.limit > 0.0 {
            self.traction[0] += w * d[0];
            self.traction[1] += w * d[1];
            return moved;
        }
        if !(sum.limit > 0.0) {
            return [0.0; 2];
        }
        let per_length = bounded(1.0 / length);
        let n = [trial[0] / length, trial[1] / length];
        let ratio = limit / length;
        let across = ratio * (n[0] * d[1] - n[1] * d[0]);
        let grip = slider.limit_per_stiffness * self.grip;
        self.traction[0] += w * (grip * n[0] - across * n[1]);
        self.traction[1] += w * (grip * n[1] + across * n[0]);
        let turn = bounded((grip - ratio * (n[0] * d[0] + n[1] * d[1])) * per_length);
        core::array::from_fn(|q| bounded(bounded(turn * stretch[q]) + ratio * moved[q]))
    }
}

/// Brings what overflowed back into a range where the sums over the sliders stay finite. No physical value comes near.
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
