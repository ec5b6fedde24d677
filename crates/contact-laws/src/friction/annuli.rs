//! The annuli of the asperities of a bin, eight points at a time: what belongs to the asperity stays in registers from annulus to annulus.
//!
//! The numbers are those of [`Block`](super::return_map::Block) with a share of the asperity's curves, for a circular cone and rules that remember
//! tractions. The trial of such a rule is linear in the stiffness, so that the annuli share what the tangent takes from it.
//!
//! Squares of trials and limits are compared. Where these could overflow or vanish, which is far from what is physical, all is done again with powers
//! of two taken off, and with the same bits for those that need none.

use super::block_start::States;
use super::return_map::{CLOSED, SLIP, STICK, TRACTION, jet, limit_slope, path, scaled, share_of};
use super::rule::{FrictionRule, Path, PathChange, StiffnessAt, StiffnessChange};
use crate::curves::CurveBlock;
use crate::jet::Jet;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::simd::bounds::{bounded, within};
use crate::simd::elementary::{max, min};
use crate::simd::{Lanes, Pass, WIDTH, lanes};
use crate::transposed::WayBack;
use alloc::vec;
use alloc::vec::Vec;

/// What the annuli of a bin answer from, and where it goes.
pub(crate) struct Annuli<'a, const B: usize> {
    /// Shares of slip limit and stiffness.
    pub(crate) shares: &'a [[f64; 2]],
    /// Jump and the one at the begin state, along the normal those of the asperities.
    pub(crate) jump: [&'a [f64]; 3],
    pub(crate) begin: [&'a [f64]; 3],
    /// Whether a closed point was open at its begin state.
    pub(crate) reclosed: bool,
    /// As in [`Block`](super::return_map::Block).
    pub(crate) mu: &'a [f64],
    pub(crate) mu_slope: &'a [f64],
    pub(crate) u_n: &'a Lanes<f64, B>,
    /// Of the asperity.
    pub(crate) curves: &'a CurveBlock<B>,
    pub(crate) unlimited: bool,
    /// What annuli remember, from the component of the first one on.
    pub(crate) memory: States<&'a [f64]>,
    pub(crate) end: States<&'a mut [f64]>,
    /// Of one asperity.
    pub(crate) traction: &'a mut [Lanes<f64, B>; 3],
    /// Row by row; those of the normal traction along the surface are not written.
    pub(crate) tangent: Option<&'a mut [Lanes<f64, B>; 9]>,
    /// Those of all annuli, bit by bit.
    pub(crate) regimes: &'a mut Lanes<u64, B>,
    /// For what the way back needs; then nothing else is written.
    pub(crate) slopes: Option<&'a mut Slopes<B>>,
}

/// Annuli with their rule.
pub(crate) struct Ruled<'a, R, const B: usize>(pub(crate) Annuli<'a, B>, pub(crate) R);

impl<R: FrictionRule, const B: usize> Pass for Ruled<'_, R, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self(mut annuli, rule) = self;
        macro_rules! answer {
            ($tangent:literal, $back:literal) => {
                if !all::<R, $tangent, $back, false, B>(rule, &mut annuli) {
                    all::<R, $tangent, $back, true, B>(rule, &mut annuli);
                }
            };
        }
        match (annuli.tangent.is_some(), annuli.slopes.is_some()) {
            (_, true) => answer!(false, true),
            (true, false) => answer!(true, false),
            (false, false) => answer!(false, false),
        }
    }
}

/// Squares between these bounds are as exact as others.
const LEAST: f64 = 1e-280;
const LARGEST: f64 = 1e280;

/// All points; whether no square was out of bounds.
#[inline(always)]
fn all<R: FrictionRule, const TANGENT: bool, const BACK: bool, const SCALED: bool, const B: usize>(
    rule: R,
    annuli: &mut Annuli<'_, B>,
) -> bool {
    let m = annuli.mu.len().min(B);
    let wide = m - m % WIDTH;
    let mut is_moderate = true;
    for first in (0..wide).step_by(WIDTH) {
        is_moderate &= some::<R, TANGENT, BACK, SCALED, WIDTH, B>(rule, annuli, first);
    }
    for first in wide..m {
        is_moderate &= some::<R, TANGENT, BACK, SCALED, 1, B>(rule, annuli, first);
    }
    is_moderate
}

/// `W` points from one on.
#[inline(always)]
fn some<R: FrictionRule, const TANGENT: bool, const BACK: bool, const SCALED: bool, const W: usize, const B: usize>(
    rule: R,
    annuli: &mut Annuli<'_, B>,
    first: usize,
) -> bool {
    let zero = [0.0; W];
    // Macros, since closures are calls here.
    macro_rules! at {
        ($values:expr) => {
            lanes::<W>(&$values[first..])
        };
    }
    let ([jump_x, jump_y, jump_n], [begin_x, begin_y, begin_n]) = (annuli.jump, annuli.begin);
    let (u_x, u_y, w) = (at!(jump_x), at!(jump_y), at!(jump_n));
    let (x_0, y_0, w_0) = (at!(begin_x), at!(begin_y), at!(begin_n));
    let (mu, u_n) = (at!(annuli.mu), at!(annuli.u_n.0));
    let CurveBlock {
        normal,
        normal_slope,
        tangential: [k_x, k_y],
        tangential_slope: [slope_x, slope_y],
        tangential_curvature: [curvature_x, curvature_y],
    } = annuli.curves;
    let (normal, k_x, k_y) = (at!(normal.0), at!(k_x.0), at!(k_y.0));
    let (slope_x, slope_y) = (at!(slope_x.0), at!(slope_y.0));
    let (curvature_x, curvature_y) = match R::CURVATURE {
        true => (at!(curvature_x.0), at!(curvature_y.0)),
        false => (zero, zero),
    };
    let (mut share, mut share_slope) = ([CLOSED[0]; W], [CLOSED[1]; W]);
    if annuli.reclosed {
        for i in 0..W {
            [share[i], share_slope[i]] = share_of(w[i], w_0[i]);
        }
    }
    // Stuck trials at one of the points, from what is remembered and a share of the stiffness.
    macro_rules! trial {
        ($i:expr, $u:expr, $u_0:expr, $memory:expr, $share:expr, $k:expr, $slope:expr, $curvature:expr) => {{
            let i = $i;
            let path = path([$u[i], $u_0[i]], [w[i], w_0[i]], 0.0, [share[i], share_slope[i]]);
            let k = jet($k[i], $slope[i], $curvature[i]);
            let k = Jet {
                value: $share * k.value,
                slope: $share * k.slope,
                curvature: $share * k.curvature,
            };
            let traction = $memory;
            rule.trial(Path { traction, ..path }, k)
        }};
    }
    // Pairs of rows, with one bound to look at each.
    let States {
        data,
        stride,
        first: place,
    } = &annuli.memory;
    let place = place + first;
    let memories = data.chunks(2 * stride);
    let ends = &mut annuli.end;
    let (end_place, end_stride) = (ends.first + first, ends.stride);
    let mut ends = ends.data.chunks_mut((2 * end_stride).max(1));
    let (mut sum_x, mut sum_y, mut sum_n, mut stuck) = (zero, zero, zero, zero);
    let (mut across_x, mut across_y, mut mixed) = (zero, zero, zero);
    let (mut towards_x, mut towards_y) = (zero, zero);
    let mut is_moderate = [true; W];
    for (annulus, (&[of_limit, of_stiffness], memory)) in annuli.shares.iter().zip(memories).enumerate() {
        let (m_x, m_y): ([f64; W], [f64; W]) = (lanes(&memory[place..]), lanes(&memory[place + stride..]));
        let (mut x, mut y, mut limit, mut square) = (zero, zero, zero, zero);
        let mut sticks = [true; W];
        for i in 0..W {
            let closed = u_n[i] > 0.0;
            // Zero, or NaN where the input is no number.
            let fill = 0.0 * u_n[i];
            let kept_x = if SCALED { within(m_x[i], TRACTION) } else { m_x[i] };
            let kept_y = if SCALED { within(m_y[i], TRACTION) } else { m_y[i] };
            let trial_x = trial!(i, u_x, x_0, kept_x, of_stiffness, k_x, slope_x, curvature_x);
            let trial_y = trial!(i, u_y, y_0, kept_y, of_stiffness, k_y, slope_y, curvature_y);
            x[i] = if closed { trial_x.traction } else { fill };
            y[i] = if closed { trial_y.traction } else { fill };
            let pressed = of_limit * bounded(normal[i]);
            sum_n[i] += pressed;
            // Finite, so that it can be multiplied by zero.
            let coulomb = min(mu[i] * pressed, f64::MAX);
            let own = if annuli.unlimited { f64::MAX } else { coulomb };
            limit[i] = if closed { own } else { 0.0 };
            let (scaled_x, scaled_y, scale) = if SCALED { scaled(x[i], y[i]) } else { (x[i], y[i], 1.0) };
            square[i] = scaled_x * scaled_x + scaled_y * scaled_y;
            let bound = (limit[i] * scale) * (limit[i] * scale);
            sticks[i] = ((square[i] <= bound) & (limit[i] > 0.0)) | !closed;
            is_moderate[i] &= (square[i] < LARGEST) & ((bound > LEAST) | (limit[i] == 0.0));
        }
        // Factors in the place of choices, of which the compiler would make branches.
        let (mut stays, mut per_length) = (zero, zero);
        for i in 0..W {
            stays[i] = if sticks[i] { 1.0 } else { 0.0 };
        }
        let all_stick = sticks == [true; W];
        if !all_stick {
            for i in 0..W {
                // A limit of zero leaves nothing to differentiate and needs no direction.
                let directed = if limit[i] > 0.0 { 1.0 - stays[i] } else { 0.0 };
                per_length[i] = directed / max(square[i], f64::MIN_POSITIVE).sqrt();
            }
        }
        if let (true, Some(slopes)) = (BACK, annuli.slopes.as_deref_mut()) {
            let (mut left, mut d_x, mut d_y) = (zero, zero, zero);
            for i in 0..W {
                let (scaled_x, scaled_y, scale) = if SCALED { scaled(x[i], y[i]) } else { (x[i], y[i], 1.0) };
                let closed = u_n[i] > 0.0;
                (d_x[i], d_y[i]) = (scaled_x * per_length[i], scaled_y * per_length[i]);
                let own = stays[i] + limit[i] * per_length[i] * scale;
                left[i] = if closed { own } else { 0.0 * u_n[i] };
            }
            let Slip {
                left: into,
                direction: [into_x, into_y],
            } = &mut slopes.annuli[annulus];
            into.0[first..][..W].copy_from_slice(&left);
            into_x.0[first..][..W].copy_from_slice(&d_x);
            into_y.0[first..][..W].copy_from_slice(&d_y);
            continue;
        }
        if all_stick {
            // What the other loop gives, to the last bit.
            for i in 0..W {
                x[i] += 0.0;
                y[i] += 0.0;
                sum_x[i] += x[i];
                sum_y[i] += y[i];
                stuck[i] += 1.0;
                if TANGENT {
                    across_x[i] += of_stiffness;
                    across_y[i] += of_stiffness;
                }
            }
        } else {
            for i in 0..W {
                let (scaled_x, scaled_y, scale) = if SCALED { scaled(x[i], y[i]) } else { (x[i], y[i], 1.0) };
                let (d_x, d_y) = (scaled_x * per_length[i], scaled_y * per_length[i]);
                x[i] = stays[i] * x[i] + limit[i] * d_x + 0.0;
                y[i] = stays[i] * y[i] + limit[i] * d_y + 0.0;
                sum_x[i] += x[i];
                sum_y[i] += y[i];
                stuck[i] += stays[i];
                if TANGENT {
                    let left = of_stiffness * (limit[i] * per_length[i] * scale);
                    let held = of_stiffness * stays[i];
                    across_x[i] += held + left * d_y * d_y;
                    across_y[i] += held + left * d_x * d_x;
                    mixed[i] -= left * d_x * d_y;
                    towards_x[i] += of_limit * d_x;
                    towards_y[i] += of_limit * d_y;
                }
            }
        }
        if let Some(end) = ends.next() {
            end[end_place..][..W].copy_from_slice(&x);
            end[end_place + end_stride..][..W].copy_from_slice(&y);
        }
    }
    if let (true, Some(slopes)) = (BACK, annuli.slopes.as_deref_mut()) {
        let (mu_slope, normal_slope) = (at!(annuli.mu_slope), at!(normal_slope.0));
        macro_rules! along {
            ($q:literal, $u:expr, $u_0:expr, $k:expr, $slope:expr, $curvature:expr) => {{
                let mut slopes_of = [zero; 4];
                for i in 0..W {
                    let stuck = trial!(i, $u, $u_0, 0.0, 1.0, $k, $slope, $curvature);
                    let reopened = w_0[i] < 0.0;
                    let path = path([$u[i], $u_0[i]], [w[i], w_0[i]], 0.0, [share[i], share_slope[i]]);
                    let k = jet($k[i], $slope[i], $curvature[i]);
                    let halfway = match R::STIFFNESS {
                        StiffnessAt::Middle => 0.5,
                        StiffnessAt::End => 0.0,
                    };
                    let moved = if reopened { 0.0 } else { halfway };
                    let begun = PathChange {
                        u: 0.0,
                        du: -1.0,
                        du_n: 0.0,
                        share: 0.0,
                        traction: 0.0,
                        stretch: 0.0,
                    };
                    let still = StiffnessChange {
                        value: 0.0,
                        slope: 0.0,
                    };
                    let reclosing = PathChange {
                        du: 0.0,
                        du_n: -1.0,
                        share: if reopened {
                            bounded(share[i] / (w[i] - w_0[i]))
                        } else {
                            0.0
                        },
                        ..begun
                    };
                    let stiffening = StiffnessChange {
                        value: moved * k.slope,
                        slope: moved * k.curvature,
                    };
                    let found = [
                        stuck.along,
                        stuck.closing,
                        rule.trial_change(path, k, begun, still),
                        rule.trial_change(path, k, reclosing, stiffening),
                    ];
                    for (values, found) in slopes_of.iter_mut().zip(found) {
                        values[i] = if u_n[i] > 0.0 { found } else { 0.0 };
                    }
                }
                for (into, values) in slopes.trial[$q].iter_mut().zip(&slopes_of) {
                    into.0[first..][..W].copy_from_slice(values);
                }
            }};
        }
        along!(0, u_x, x_0, k_x, slope_x, curvature_x);
        along!(1, u_y, y_0, k_y, slope_y, curvature_y);
        let (mut of_limit, mut of_normal) = (zero, zero);
        for i in 0..W {
            let closed = u_n[i] > 0.0;
            of_limit[i] = limit_slope(mu_slope[i], normal_slope[i]);
            of_normal[i] = if closed { bounded(normal_slope[i]) } else { 0.0 };
        }
        slopes.limit.0[first..][..W].copy_from_slice(&of_limit);
        slopes.normal.0[first..][..W].copy_from_slice(&of_normal);
        return SCALED | (is_moderate == [true; W]);
    }
    let n_annuli = annuli.shares.len() as f64;
    let mut regimes = [0; W];
    for i in 0..W {
        let closed = u_n[i] > 0.0;
        let fill = 0.0 * u_n[i];
        sum_n[i] = if closed { sum_n[i] } else { fill };
        let (sticks, slips) = (closed & (stuck[i] > 0.0), closed & (stuck[i] < n_annuli));
        regimes[i] = u64::from(sticks) * STICK + u64::from(slips) * SLIP;
    }
    for (traction, sum) in annuli.traction.iter_mut().zip([&sum_x, &sum_y, &sum_n]) {
        traction.0[first..][..W].copy_from_slice(sum);
    }
    annuli.regimes.0[first..][..W].copy_from_slice(&regimes);
    if let (true, Some([xx, xy, xn, yx, yy, yn, _, _, nn])) = (TANGENT, annuli.tangent.as_deref_mut()) {
        let (mu_slope, normal_slope) = (at!(annuli.mu_slope), at!(normal_slope.0));
        let mut rows = [zero; 7];
        for i in 0..W {
            let stuck_x = trial!(i, u_x, x_0, 0.0, 1.0, k_x, slope_x, curvature_x);
            let stuck_y = trial!(i, u_y, y_0, 0.0, 1.0, k_y, slope_y, curvature_y);
            let slip_slope = limit_slope(mu_slope[i], normal_slope[i]);
            let closed = u_n[i] > 0.0;
            let fill = 0.0 * u_n[i];
            let closing_x = across_x[i] * stuck_x.closing + mixed[i] * stuck_y.closing + slip_slope * towards_x[i];
            let closing_y = mixed[i] * stuck_x.closing + across_y[i] * stuck_y.closing + slip_slope * towards_y[i];
            rows[0][i] = if closed { across_x[i] * stuck_x.along } else { fill };
            rows[1][i] = if closed { mixed[i] * stuck_y.along } else { fill };
            rows[2][i] = if closed { closing_x } else { fill };
            rows[3][i] = if closed { mixed[i] * stuck_x.along } else { fill };
            rows[4][i] = if closed { across_y[i] * stuck_y.along } else { fill };
            rows[5][i] = if closed { closing_y } else { fill };
            rows[6][i] = if closed { bounded(normal_slope[i]) } else { fill };
        }
        for (entry, row) in [xx, xy, xn, yx, yy, yn, nn].into_iter().zip(&rows) {
            entry.0[first..][..W].copy_from_slice(row);
        }
    }
    SCALED | (is_moderate == [true; W])
}

/// Derivatives of what an asperity and its annuli do, at the points of a block.
pub(crate) struct Slopes<const B: usize> {
    annuli: Vec<Slip<B>>,
    /// Of the stuck trial of the asperity along x and y: by the jump along it, by the interference, and by both at the begin state.
    trial: [[Lanes<f64, B>; 4]; 2],
    /// Of slip limit and normal force by the interference.
    limit: Lanes<f64, B>,
    normal: Lanes<f64, B>,
}

/// How an annulus slips.
#[derive(Clone)]
struct Slip<const B: usize> {
    /// What is left of a change of the trial across the direction: 1 where it sticks, zero where it is open.
    left: Lanes<f64, B>,
    /// Zero without slip.
    direction: [Lanes<f64, B>; 2],
}

impl<const B: usize> Slopes<B> {
    pub(crate) fn new(n_annuli: usize) -> Self {
        let zero = Lanes([0.0; B]);
        let slip = Slip {
            left: zero,
            direction: [zero; 2],
        };
        Self {
            annuli: vec![slip; n_annuli],
            trial: [[zero; 4]; 2],
            limit: zero,
            normal: zero,
        }
    }
}

/// The annuli of a bin on the way back through a step, for one adjoint.
pub(crate) struct AnnuliBack<'a, const B: usize> {
    pub(crate) way: WayBack,
    /// As in [`Annuli`].
    pub(crate) shares: &'a [[f64; 2]],
    pub(crate) slopes: &'a Slopes<B>,
    /// Asperities per area.
    pub(crate) density: &'a Lanes<f64, B>,
    /// Adjoints of the tractions, and of what annuli remember, as in [`Annuli`].
    pub(crate) traction: [&'a [f64]; 3],
    pub(crate) history: (&'a mut [f64], usize),
    /// What is added to the adjoints of the jump and of that of the begin state.
    pub(crate) sums: &'a mut [Lanes<f64, B>; 6],
}

impl<const B: usize> Pass for AnnuliBack<'_, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self {
            way,
            shares,
            slopes,
            density,
            traction: [t_x, t_y, t_n],
            history: (history, stride),
            sums: [to_x, to_y, to_n, to_begin_x, to_begin_y, to_begin_n],
        } = self;
        let m = t_x.len().min(B);
        // Adjoints of the stuck trial and, of the slip limit, what it moves along the directions.
        let [mut trial_x, mut trial_y, mut limit] = [Lanes([0.0; B]); 3];
        // Row by row, in the order in which histories lie in memory.
        for ((slip, share), history) in slopes.annuli.iter().zip(shares).zip(history.chunks_mut(2 * stride)) {
            let (history_x, history_y) = history.split_at_mut(stride);
            let (history_x, history_y) = (&mut history_x[..m], &mut history_y[..m]);
            let [d_x, d_y] = &slip.direction;
            macro_rules! back {
                ($way:ident) => {
                    annulus_back(
                        // Known where the loop is compiled.
                        WayBack::$way,
                        *share,
                        &slip.left,
                        d_x,
                        d_y,
                        density,
                        t_x,
                        t_y,
                        history_x,
                        history_y,
                        &mut trial_x,
                        &mut trial_y,
                        &mut limit,
                    )
                };
            }
            match way {
                WayBack::Committed => back!(Committed),
                WayBack::Passed => back!(Passed),
                WayBack::JumpAlone => back!(JumpAlone),
            }
        }
        let [[x_by_u, x_by_n, x_by_u0, x_by_n0], [y_by_u, y_by_n, y_by_u0, y_by_n0]] = &slopes.trial;
        for i in 0..m {
            let (x, y) = (trial_x.0[i], trial_y.0[i]);
            let pressing = slopes.limit.0[i] * limit.0[i] + density.0[i] * slopes.normal.0[i] * t_n[i];
            to_x.0[i] += x_by_u.0[i] * x;
            to_y.0[i] += y_by_u.0[i] * y;
            to_n.0[i] += x_by_n.0[i] * x + y_by_n.0[i] * y + pressing;
            to_begin_x.0[i] += x_by_u0.0[i] * x;
            to_begin_y.0[i] += y_by_u0.0[i] * y;
            to_begin_n.0[i] += x_by_n0.0[i] * x + y_by_n0.0[i] * y;
        }
    }
}

/// One annulus of [`AnnuliBack`]. Every array is an argument of its own, because that alone tells the compiler that they do not overlap.
#[inline(always)]
fn annulus_back<const B: usize>(
    way: WayBack,
    [of_limit, of_stiffness]: [f64; 2],
    left: &Lanes<f64, B>,
    d_x: &Lanes<f64, B>,
    d_y: &Lanes<f64, B>,
    density: &Lanes<f64, B>,
    t_x: &[f64],
    t_y: &[f64],
    history_x: &mut [f64],
    history_y: &mut [f64],
    trial_x: &mut Lanes<f64, B>,
    trial_y: &mut Lanes<f64, B>,
    limit: &mut Lanes<f64, B>,
) {
    let m = t_x.len().min(B);
    let (t_x, t_y) = (&t_x[..m], &t_y[..m]);
    let (history_x, history_y) = (&mut history_x[..m], &mut history_y[..m]);
    for i in 0..m {
        let force_x = way.of_end(history_x[i]) + density.0[i] * t_x[i];
        let force_y = way.of_end(history_y[i]) + density.0[i] * t_y[i];
        let along = d_x.0[i] * force_x + d_y.0[i] * force_y;
        let through_x = left.0[i] * (force_x - along * d_x.0[i]);
        let through_y = left.0[i] * (force_y - along * d_y.0[i]);
        trial_x.0[i] += of_stiffness * through_x;
        trial_y.0[i] += of_stiffness * through_y;
        limit.0[i] += of_limit * along;
        if way != WayBack::JumpAlone {
            history_x[i] = way.before(history_x[i], through_x);
            history_y[i] = way.before(history_y[i], through_y);
        }
    }
}
