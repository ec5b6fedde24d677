//! An annulus of the asperities of a bin in two loops over the points of a block.
//!
//! The numbers are those of [`Block`](super::return_map::Block), with a share of the asperity's curves, added up by the densities, and to the last bit: the
//! same operations without the arrays between some fifteen passes, for points that were closed before, a circular cone and rules that remember tractions.

use super::return_map::{CLOSED, SLIP, STICK, Slip, count, jet, limit_slope, path, regime_of, rows_of, slip_of};
use super::rule::FrictionRule;
use crate::curves::CurveBlock;
use crate::simd::bounds::{bounded, within};
use crate::simd::{Lanes, Pass};

/// What an annulus answers from, and where it goes.
pub(crate) struct Annulus<'a, const B: usize> {
    /// Shares of slip limit and stiffness.
    pub(crate) shares: [f64; 2],
    /// Jump and the one at the begin state, along the normal those of the asperities.
    pub(crate) jump: [&'a [f64]; 3],
    pub(crate) begin: [&'a [f64]; 3],
    pub(crate) memory: [&'a [f64]; 2],
    /// As in [`Block`](super::return_map::Block).
    pub(crate) mu: &'a [f64],
    pub(crate) mu_slope: &'a [f64],
    pub(crate) u_n: &'a Lanes<f64, B>,
    /// Of the asperity.
    pub(crate) curves: &'a CurveBlock<B>,
    pub(crate) density: &'a Lanes<f64, B>,
    pub(crate) unlimited: bool,
    /// Bound of what is added.
    pub(crate) largest: f64,
    pub(crate) with_tangent: bool,
    pub(crate) room: &'a mut Room<B>,
    pub(crate) end: [&'a mut [f64]; 2],
    pub(crate) traction: &'a mut [Lanes<f64, B>; 3],
    /// Row by row; those of the normal traction along the surface are zero.
    pub(crate) tangent: &'a mut [Lanes<f64, B>; 9],
    pub(crate) regimes: &'a mut Lanes<u64, B>,
}

/// Numbers between the two loops.
pub(crate) struct Room<const B: usize> {
    trial: [Lanes<f64, B>; 2],
    along: [Lanes<f64, B>; 2],
    closing: [Lanes<f64, B>; 2],
    regime: Lanes<u64, B>,
}

impl<const B: usize> Room<B> {
    pub(crate) fn new() -> Self {
        let zero = Lanes([0.0; B]);
        Self {
            trial: [zero; 2],
            along: [zero; 2],
            closing: [zero; 2],
            regime: Lanes([0; B]),
        }
    }
}

/// An annulus with its rule.
pub(crate) struct Ruled<'a, R, const B: usize>(pub(crate) Annulus<'a, B>, pub(crate) R);

impl<R: FrictionRule, const B: usize> Pass for Ruled<'_, R, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self(annulus, rule) = self;
        let Annulus {
            shares: [of_limit, of_stiffness],
            jump: [jump_x, jump_y, jump_n],
            begin: [begin_x, begin_y, begin_n],
            memory: [memory_x, memory_y],
            mu,
            mu_slope,
            u_n,
            curves,
            density,
            unlimited,
            largest,
            with_tangent,
            room,
            end: [end_x, end_y],
            traction: [traction_x, traction_y, traction_n],
            tangent: [xx, xy, xn, yx, yy, yn, _, _, nn],
            regimes,
        } = annulus;
        let Room {
            trial: [trial_x, trial_y],
            along: [along_x, along_y],
            closing: [closing_x, closing_y],
            regime,
        } = room;
        let slips = trials(
            rule,
            [of_limit, of_stiffness],
            unlimited,
            jump_x,
            jump_y,
            jump_n,
            begin_x,
            begin_y,
            begin_n,
            memory_x,
            memory_y,
            mu,
            u_n,
            curves,
            trial_x,
            trial_y,
            along_x,
            along_y,
            closing_x,
            closing_y,
            regime,
        );
        macro_rules! answer {
            ($slips:literal, $tangent:literal) => {
                answers::<$slips, $tangent, B>(
                    of_limit, unlimited, largest, mu, mu_slope, u_n, curves, density, trial_x, trial_y, along_x,
                    along_y, closing_x, closing_y, regime, end_x, end_y, traction_x, traction_y, traction_n, xx, xy,
                    xn, yx, yy, yn, nn, regimes,
                )
            };
        }
        match (slips, with_tangent) {
            (false, false) => answer!(false, false),
            (false, true) => answer!(false, true),
            (true, false) => answer!(true, false),
            (true, true) => answer!(true, true),
        }
    }
}

/// Stuck trials and regimes; whether any point slips.
#[inline(always)]
fn trials<R: FrictionRule, const B: usize>(
    rule: R,
    [of_limit, of_stiffness]: [f64; 2],
    unlimited: bool,
    jump_x: &[f64],
    jump_y: &[f64],
    jump_n: &[f64],
    begin_x: &[f64],
    begin_y: &[f64],
    begin_n: &[f64],
    memory_x: &[f64],
    memory_y: &[f64],
    mu: &[f64],
    u_n: &Lanes<f64, B>,
    curves: &CurveBlock<B>,
    trial_x: &mut Lanes<f64, B>,
    trial_y: &mut Lanes<f64, B>,
    along_x: &mut Lanes<f64, B>,
    along_y: &mut Lanes<f64, B>,
    closing_x: &mut Lanes<f64, B>,
    closing_y: &mut Lanes<f64, B>,
    regime: &mut Lanes<u64, B>,
) -> bool {
    let n = mu.len().min(B);
    let (jump_x, jump_y, jump_n) = (&jump_x[..n], &jump_y[..n], &jump_n[..n]);
    let (begin_x, begin_y, begin_n) = (&begin_x[..n], &begin_y[..n], &begin_n[..n]);
    let (memory_x, memory_y, mu) = (&memory_x[..n], &memory_y[..n], &mu[..n]);
    let [k_x, k_y] = &curves.tangential;
    let [slope_x, slope_y] = &curves.tangential_slope;
    let [curvature_x, curvature_y] = &curves.tangential_curvature;
    let mut sum = 0;
    for i in 0..n {
        let k =
            |k: f64, slope: f64, curvature: f64| jet(of_stiffness * k, of_stiffness * slope, of_stiffness * curvature);
        let along = k(k_x.0[i], slope_x.0[i], curvature_x.0[i]);
        let normal = [jump_n[i], begin_n[i]];
        let stuck_x = rule.trial(path([jump_x[i], begin_x[i]], normal, memory_x[i], CLOSED), along);
        let along = k(k_y.0[i], slope_y.0[i], curvature_y.0[i]);
        let stuck_y = rule.trial(path([jump_y[i], begin_y[i]], normal, memory_y[i], CLOSED), along);
        (trial_x.0[i], trial_y.0[i]) = (stuck_x.traction, stuck_y.traction);
        (along_x.0[i], along_y.0[i]) = (stuck_x.along, stuck_y.along);
        (closing_x.0[i], closing_y.0[i]) = (stuck_x.closing, stuck_y.closing);
        let limit = mu[i] * bounded(of_limit * curves.normal.0[i]);
        let limit = if unlimited { f64::MAX } else { limit };
        let code = regime_of(stuck_x.traction, stuck_y.traction, limit, u_n.0[i]);
        regime.0[i] = code;
        sum += code;
    }
    count(sum, SLIP) > 0
}

/// Tractions, what is remembered of them, and the tangent.
#[inline(always)]
fn answers<const SLIPS: bool, const TANGENT: bool, const B: usize>(
    of_limit: f64,
    unlimited: bool,
    largest: f64,
    mu: &[f64],
    mu_slope: &[f64],
    u_n: &Lanes<f64, B>,
    curves: &CurveBlock<B>,
    density: &Lanes<f64, B>,
    trial_x: &Lanes<f64, B>,
    trial_y: &Lanes<f64, B>,
    along_x: &Lanes<f64, B>,
    along_y: &Lanes<f64, B>,
    closing_x: &Lanes<f64, B>,
    closing_y: &Lanes<f64, B>,
    regime: &Lanes<u64, B>,
    end_x: &mut [f64],
    end_y: &mut [f64],
    traction_x: &mut Lanes<f64, B>,
    traction_y: &mut Lanes<f64, B>,
    traction_n: &mut Lanes<f64, B>,
    xx: &mut Lanes<f64, B>,
    xy: &mut Lanes<f64, B>,
    xn: &mut Lanes<f64, B>,
    yx: &mut Lanes<f64, B>,
    yy: &mut Lanes<f64, B>,
    yn: &mut Lanes<f64, B>,
    nn: &mut Lanes<f64, B>,
    regimes: &mut Lanes<u64, B>,
) {
    let n = mu.len().min(B);
    let (mu, mu_slope) = (&mu[..n], &mu_slope[..n]);
    let (end_x, end_y) = (&mut end_x[..n], &mut end_y[..n]);
    for i in 0..n {
        let (x, y) = (trial_x.0[i], trial_y.0[i]);
        let normal = bounded(of_limit * curves.normal.0[i]);
        let limit = mu[i] * normal;
        let sticks = regime.0[i] == STICK;
        let slip = if SLIPS {
            slip_of(x, y, limit, regime.0[i])
        } else {
            Slip::NONE
        };
        let [d_x, d_y] = slip.direction;
        let held = if unlimited { 0.0 } else { limit };
        let t_x = if sticks { x } else { held * d_x };
        let t_y = if sticks { y } else { held * d_y };
        let closed = u_n.0[i] > 0.0;
        // Zero, or NaN where the input is no number.
        let fill = 0.0 * u_n.0[i];
        let weight = density.0[i];
        let add = |sum: &mut f64, value: f64| *sum += within(weight * if closed { value } else { fill }, largest);
        end_x[i] = if closed { t_x } else { fill };
        end_y[i] = if closed { t_y } else { fill };
        add(&mut traction_x.0[i], t_x);
        add(&mut traction_y.0[i], t_y);
        add(&mut traction_n.0[i], normal);
        if TANGENT {
            let normal_slope = of_limit * curves.normal_slope.0[i];
            let rows = rows_of(
                sticks,
                slip.direction,
                slip.ratio,
                [along_x.0[i], along_y.0[i]],
                [closing_x.0[i], closing_y.0[i]],
                limit_slope(mu_slope[i], normal_slope),
            );
            add(&mut xx.0[i], rows[0]);
            add(&mut xy.0[i], rows[1]);
            add(&mut xn.0[i], rows[2]);
            add(&mut yx.0[i], rows[3]);
            add(&mut yy.0[i], rows[4]);
            add(&mut yn.0[i], rows[5]);
            add(&mut nn.0[i], bounded(normal_slope));
        }
        regimes.0[i] |= if weight > 0.0 { regime.0[i] } else { 0 };
    }
}
