//! The friction of [`crate::FrictionalLaw`] at the points of a block: stuck trial, slip limit, tractions, end state and
//! consistent tangent, without branches on the values. What differs from rule to rule is asked of a [`FrictionRule`].
//!
//! No physical number comes near 1e75. Numbers beyond are cut to bounds between which neither sums nor products of the
//! few factors that meet here can overflow, so finite input gives finite output.

use super::block_start::Present;
use super::rule::{FrictionRule, Memory, Path, PathChange, StiffnessChange};
use crate::curves::CurveBlock;
use crate::jet::Jet;
use crate::law::{Regime, RegimeCounts, Sticking};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::simd::bounds::{bounded, within};
use crate::simd::elementary::max;
use crate::simd::{Lanes, Pass, run};

/// A block of points. Every slice has the block's length.
pub(crate) struct Block<'a, const B: usize> {
    pub(crate) jump: [&'a [f64]; 3],
    pub(crate) begin: [&'a [f64]; 5],
    /// Slip limit over the normal traction of the curves, not negative.
    pub(crate) mu: &'a [f64],
    /// Its derivative over that of the normal traction: with Coulomb's limit the same.
    pub(crate) mu_slope: &'a [f64],
    /// Interferences from [`Start`](super::block_start::Start).
    pub(crate) u_n: &'a Lanes<f64, B>,
    pub(crate) present: Present,
    pub(crate) curves: &'a CurveBlock<B>,
    pub(crate) sticking: Sticking,
    pub(crate) workspace: &'a mut Workspace<B>,
    /// What the end state remembers beside the jump.
    pub(crate) memory: [&'a mut [f64]; 2],
    pub(crate) traction: [&'a mut [f64]; 3],
    /// Row by row.
    pub(crate) tangent: Option<[&'a mut [f64]; 9]>,
    pub(crate) regimes: Option<&'a mut [Regime]>,
    pub(crate) derivative: Option<Derivative<'a, B>>,
}

/// A direction of the input of a block, and where the derivatives along it go. Every slice has the block's length.
pub(crate) struct Derivative<'a, const B: usize> {
    /// Changes of what [`Block`] has of the same name.
    pub(crate) jump: [&'a [f64]; 3],
    pub(crate) begin: [&'a [f64]; 5],
    pub(crate) curves: &'a CurveChange<B>,
    pub(crate) memory: [&'a mut [f64]; 2],
    pub(crate) traction: [&'a mut [f64]; 3],
}

/// Changes of contact curves at the points of a block along a direction. Numbers are finite at closed points.
#[derive(Debug)]
pub(crate) struct CurveChange<const B: usize> {
    /// Normal traction.
    pub(crate) normal: Lanes<f64, B>,
    /// Slip limit.
    pub(crate) limit: Lanes<f64, B>,
    /// Tangential stiffnesses and their slopes, along x and y.
    pub(crate) tangential: [Lanes<f64, B>; 2],
    pub(crate) tangential_slope: [Lanes<f64, B>; 2],
    /// Zero, or NaN where the direction is not finite.
    pub(crate) fill: Lanes<f64, B>,
}

impl<const B: usize> CurveChange<B> {
    pub(crate) fn new() -> Self {
        let zero = Lanes([0.0; B]);
        Self {
            normal: zero,
            limit: zero,
            tangential: [zero; 2],
            tangential_slope: [zero; 2],
            fill: zero,
        }
    }
}

/// Numbers between the passes over a block.
pub(crate) struct Workspace<const B: usize> {
    /// Stuck trial along x and y with its derivatives along the direction itself and along `u_n`.
    trial: [Lanes<f64, B>; 2],
    along: [Lanes<f64, B>; 2],
    closing: [Lanes<f64, B>; 2],
    /// Share of the path that is closed, and its derivative along `u_n`.
    share: Lanes<f64, B>,
    share_slope: Lanes<f64, B>,
    /// Elastic stretch that sticking would leave, and its derivative along `u_n`. Only for rules that remember it.
    stretch: [Lanes<f64, B>; 2],
    stretch_slope: [Lanes<f64, B>; 2],
    /// Direction of slip, zero without slip.
    direction: [Lanes<f64, B>; 2],
    /// Traction over trial, and one over the length of the trial.
    ratio: Lanes<f64, B>,
    per_trial: Lanes<f64, B>,
    pub(super) regime: Lanes<u64, B>,
    /// Sum of the regimes.
    pub(super) sum: u64,
}

impl<const B: usize> Workspace<B> {
    pub(crate) fn new() -> Self {
        let zero = Lanes([0.0; B]);
        Self {
            trial: [zero; 2],
            along: [zero; 2],
            closing: [zero; 2],
            share: zero,
            share_slope: zero,
            stretch: [zero; 2],
            stretch_slope: [zero; 2],
            direction: [zero; 2],
            ratio: zero,
            per_trial: zero,
            regime: Lanes([0; B]),
            sum: 0,
        }
    }
}

impl<const B: usize> Block<'_, B> {
    /// Tractions and all else of the block.
    pub(crate) fn respond<R: FrictionRule>(mut self, rule: R) -> RegimeCounts {
        let n = self.mu.len();
        run(StuckTrials(&mut self, rule));
        run(SlipLimits(&mut self, rule));
        if self.tangent.is_some() {
            run(Tangents(&mut self, rule));
        }
        if let Some(mut derivative) = self.derivative.take() {
            run(Changes(&self, &mut derivative, rule));
        }
        self.workspace.report(n, self.regimes)
    }
}

impl<const B: usize> Workspace<B> {
    /// Regimes of the first `n` points and their counts.
    pub(super) fn report(&self, n: usize, regimes: Option<&mut [Regime]>) -> RegimeCounts {
        let codes = &self.regime.0[..n];
        if let Some(regimes) = regimes {
            for (regime, &code) in regimes.iter_mut().zip(codes) {
                *regime = if code == STICK {
                    Regime::Stick
                } else if code == SLIP {
                    Regime::Slip
                } else if code == OPEN {
                    Regime::Open
                } else {
                    Regime::Invalid
                };
            }
        }
        RegimeCounts {
            stick: count(self.sum, STICK),
            slip: count(self.sum, SLIP),
            open: count(self.sum, OPEN),
            invalid: count(self.sum, INVALID),
        }
    }
}

/// Regimes as numbers that add up to the counts of a block: one digit of base 2^16 for each.
pub(super) const STICK: u64 = 1;
pub(super) const SLIP: u64 = 1 << 16;
pub(super) const OPEN: u64 = 1 << 32;
const INVALID: u64 = 1 << 48;

/// How many points of one regime are in a sum of regimes.
pub(super) fn count(sum: u64, regime: u64) -> usize {
    (sum / regime % (1 << 16)) as usize
}

/// The regimes of a block's points from those of their parts, merged bit by bit; `fill` is NaN where the input of a point is no number.
pub(super) fn of_parts<const B: usize>(
    merged: &Lanes<u64, B>,
    fill: &Lanes<f64, B>,
    m: usize,
    mut into: Option<&mut [Regime]>,
) -> RegimeCounts {
    let mut counts = RegimeCounts::default();
    for (i, (merged, fill)) in merged.0.iter().zip(&fill.0).take(m).enumerate() {
        let regime = if fill.is_nan() {
            Regime::Invalid
        } else if merged & STICK > 0 {
            Regime::Stick
        } else if merged & SLIP > 0 {
            Regime::Slip
        } else {
            Regime::Open
        };
        counts.count(regime);
        if let Some(regimes) = &mut into {
            regimes[i] = regime;
        }
    }
    counts
}

/// Whether a rule remembers the stretch, known where its loops are compiled.
const fn stretches<R: FrictionRule>() -> bool {
    matches!(R::MEMORY, Memory::Stretch)
}

/// Stuck trials.
struct StuckTrials<'a, 'b, R, const B: usize>(&'a mut Block<'b, B>, R);

impl<R: FrictionRule, const B: usize> Pass for StuckTrials<'_, '_, R, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self(block, rule) = self;
        if block.present.reclosed {
            let ([_, _, u_n], [_, _, u_n0, ..]) = (block.jump, block.begin);
            shares(u_n, u_n0, &mut block.workspace.share, &mut block.workspace.share_slope);
            both_trials::<R, true, B>(rule, block);
        } else {
            if stretches::<R>() {
                block.workspace.share.0 = [1.0; B];
            }
            both_trials::<R, false, B>(rule, block);
        }
    }
}

/// Stuck trials along x and y.
#[inline(always)]
fn both_trials<R: FrictionRule, const REOPENS: bool, const B: usize>(rule: R, block: &mut Block<'_, B>) {
    let (u_n, u_n0, curves) = (block.jump[2], block.begin[2], block.curves);
    let workspace = &mut *block.workspace;
    for q in 0..2 {
        trials::<R, REOPENS, B>(
            rule,
            block.jump[q],
            block.begin[q],
            u_n,
            u_n0,
            block.begin[3 + q],
            &curves.tangential[q],
            &curves.tangential_slope[q],
            &curves.tangential_curvature[q],
            &workspace.share,
            &workspace.share_slope,
            &mut workspace.trial[q],
            &mut workspace.along[q],
            &mut workspace.closing[q],
            &mut workspace.stretch[q],
            &mut workspace.stretch_slope[q],
        );
    }
}

/// Share of each path that is closed, and its derivative with respect to `u_n`.
#[inline(always)]
fn shares<const B: usize>(u_n: &[f64], u_n0: &[f64], share: &mut Lanes<f64, B>, share_slope: &mut Lanes<f64, B>) {
    let n = u_n.len().min(B);
    let (u_n, u_n0) = (&u_n[..n], &u_n0[..n]);
    for i in 0..n {
        [share.0[i], share_slope.0[i]] = share_of(u_n[i], u_n0[i]);
    }
}

/// The same of one path.
#[inline(always)]
pub(super) fn share_of(u_n: f64, u_n0: f64) -> [f64; 2] {
    let (path, reopened) = (u_n - u_n0, u_n0 < 0.0);
    let closed = u_n / path;
    let slope = bounded((1.0 - closed) / path);
    if reopened { [closed, slope] } else { CLOSED }
}

/// Stuck trials along one direction.
#[inline(always)]
fn trials<R: FrictionRule, const REOPENS: bool, const B: usize>(
    rule: R,
    u: &[f64],
    u_0: &[f64],
    u_n: &[f64],
    u_n0: &[f64],
    memory: &[f64],
    k: &Lanes<f64, B>,
    k_slope: &Lanes<f64, B>,
    k_curvature: &Lanes<f64, B>,
    share: &Lanes<f64, B>,
    share_slope: &Lanes<f64, B>,
    trial: &mut Lanes<f64, B>,
    along: &mut Lanes<f64, B>,
    closing: &mut Lanes<f64, B>,
    stretch: &mut Lanes<f64, B>,
    stretch_slope: &mut Lanes<f64, B>,
) {
    let n = u.len().min(B);
    let (u, u_0, u_n, u_n0, memory) = (&u[..n], &u_0[..n], &u_n[..n], &u_n0[..n], &memory[..n]);
    for i in 0..n {
        let share = if REOPENS {
            [share.0[i], share_slope.0[i]]
        } else {
            CLOSED
        };
        let path = path([u[i], u_0[i]], [u_n[i], u_n0[i]], memory[i], share);
        let stuck = rule.trial(path, jet(k.0[i], k_slope.0[i], k_curvature.0[i]));
        trial.0[i] = stuck.traction;
        along.0[i] = stuck.along;
        closing.0[i] = stuck.closing;
        if stretches::<R>() {
            stretch.0[i] = path.stretch;
            stretch_slope.0[i] = path.stretch_slope;
        }
    }
}

/// Share of the path of a point that was closed before, and its derivative.
pub(super) const CLOSED: [f64; 2] = [1.0, 0.0];

/// The path of a point along a direction, from now and before.
#[inline(always)]
pub(super) fn path(u: [f64; 2], u_n: [f64; 2], memory: f64, [share, share_slope]: [f64; 2]) -> Path {
    let du = bounded(u[0] - u[1]);
    Path {
        u: bounded(u[0]),
        du,
        du_n: bounded(u_n[0] - u_n[1]),
        share,
        share_slope,
        traction: within(memory, TRACTION),
        stretch: within(memory + share * du, STRETCH),
        stretch_slope: within(share_slope * du, STRETCH),
    }
}

/// A stiffness with its derivatives, cut to what may be multiplied.
#[inline(always)]
pub(super) fn jet(value: f64, slope: f64, curvature: f64) -> Jet {
    Jet {
        value: bounded(value),
        slope: bounded(slope),
        curvature: bounded(curvature),
    }
}

/// Slip limit, tractions and end state.
struct SlipLimits<'a, 'b, R, const B: usize>(&'a mut Block<'b, B>, R);

impl<R: FrictionRule, const B: usize> Pass for SlipLimits<'_, '_, R, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self(block, rule) = self;
        let unlimited = block.sticking == Sticking::Full;
        let [end_1, end_2] = &mut block.memory;
        let [traction_x, traction_y, traction_n] = &mut block.traction;
        let Workspace {
            trial: [trial_x, trial_y],
            stretch: [stretch_x, stretch_y],
            direction: [direction_x, direction_y],
            ratio,
            per_trial,
            regime,
            sum,
            ..
        } = &mut *block.workspace;
        *sum = limits(
            unlimited,
            block.mu,
            block.u_n,
            &block.curves.normal,
            trial_x,
            trial_y,
            direction_x,
            direction_y,
            ratio,
            per_trial,
            regime,
        );
        tractions(
            rule,
            unlimited,
            block.mu,
            block.u_n,
            block.curves,
            trial_x,
            trial_y,
            stretch_x,
            stretch_y,
            direction_x,
            direction_y,
            ratio,
            regime,
            traction_x,
            traction_y,
            traction_n,
            end_1,
            end_2,
        );
    }
}

/// Regimes, and where points slip the direction and what is left of the trial, eq. (20).
#[inline(always)]
fn limits<const B: usize>(
    unlimited: bool,
    mu: &[f64],
    u_n: &Lanes<f64, B>,
    normal: &Lanes<f64, B>,
    trial_x: &Lanes<f64, B>,
    trial_y: &Lanes<f64, B>,
    direction_x: &mut Lanes<f64, B>,
    direction_y: &mut Lanes<f64, B>,
    ratio: &mut Lanes<f64, B>,
    per_trial: &mut Lanes<f64, B>,
    regime: &mut Lanes<u64, B>,
) -> u64 {
    let n = mu.len().min(B);
    let mu = &mu[..n];
    let mut sum = 0;
    for i in 0..n {
        let limit = mu[i] * bounded(normal.0[i]);
        let limit = if unlimited { f64::MAX } else { limit };
        let code = regime_of(trial_x.0[i], trial_y.0[i], limit, u_n.0[i]);
        regime.0[i] = code;
        sum += code;
        direction_x.0[i] = 0.0;
        direction_y.0[i] = 0.0;
        per_trial.0[i] = 0.0;
        ratio.0[i] = 1.0;
    }
    if count(sum, SLIP) == 0 {
        return sum;
    }
    for i in 0..n {
        let limit = mu[i] * bounded(normal.0[i]);
        let slip = slip_of(trial_x.0[i], trial_y.0[i], limit, regime.0[i]);
        [direction_x.0[i], direction_y.0[i]] = slip.direction;
        (per_trial.0[i], ratio.0[i]) = (slip.per_trial, slip.ratio);
    }
    sum
}

/// Regime of a point with a stuck trial.
#[inline(always)]
fn regime_of(trial_x: f64, trial_y: f64, limit: f64, u_n: f64) -> u64 {
    let (x, y, scale) = scaled(trial_x, trial_y);
    let sticks = (x * x + y * y <= (limit * scale) * (limit * scale)) & (limit > 0.0);
    let code = if sticks { STICK } else { SLIP };
    let code = if u_n > 0.0 { code } else { OPEN };
    if u_n.is_nan() { INVALID } else { code }
}

/// How a point slips.
#[derive(Clone, Copy)]
struct Slip {
    /// Zero without slip.
    direction: [f64; 2],
    /// Traction over trial, and one over the length of the trial.
    ratio: f64,
    per_trial: f64,
}

/// Where a point slips the direction and what is left of the trial, eq. (20).
#[inline(always)]
fn slip_of(trial_x: f64, trial_y: f64, limit: f64, regime: u64) -> Slip {
    let (x, y, scale) = scaled(trial_x, trial_y);
    // A limit of zero leaves nothing to differentiate and needs no direction.
    let directed = (regime == SLIP) & (limit > 0.0);
    let length = (x * x + y * y).sqrt();
    let per_length = if directed { 1.0 / length } else { 0.0 };
    let slipping = limit * scale * per_length;
    Slip {
        direction: [
            if directed { x * per_length } else { 0.0 },
            if directed { y * per_length } else { 0.0 },
        ],
        ratio: if regime == SLIP { slipping } else { 1.0 },
        per_trial: per_length * scale,
    }
}

/// A trial in a power of two of its unit in which squares neither overflow nor underflow, and that power.
#[inline(always)]
pub(super) fn scaled(x: f64, y: f64) -> (f64, f64, f64) {
    let largest = max(x.abs(), y.abs());
    let small = if largest < 1e-140 { UP } else { 1.0 };
    let scale = if largest > 1e140 { DOWN } else { small };
    (x * scale, y * scale, scale)
}

/// Tractions and what the end state remembers of them.
#[inline(always)]
fn tractions<R: FrictionRule, const B: usize>(
    rule: R,
    unlimited: bool,
    mu: &[f64],
    u_n: &Lanes<f64, B>,
    curves: &CurveBlock<B>,
    trial_x: &Lanes<f64, B>,
    trial_y: &Lanes<f64, B>,
    stretch_x: &Lanes<f64, B>,
    stretch_y: &Lanes<f64, B>,
    direction_x: &Lanes<f64, B>,
    direction_y: &Lanes<f64, B>,
    ratio: &Lanes<f64, B>,
    regime: &Lanes<u64, B>,
    traction_x: &mut [f64],
    traction_y: &mut [f64],
    traction_n: &mut [f64],
    end_1: &mut [f64],
    end_2: &mut [f64],
) {
    let n = mu.len().min(B);
    let mu = &mu[..n];
    let (traction_x, traction_y, traction_n) = (&mut traction_x[..n], &mut traction_y[..n], &mut traction_n[..n]);
    let (end_1, end_2) = (&mut end_1[..n], &mut end_2[..n]);
    let [k_x, k_y] = &curves.tangential;
    let [slope_x, slope_y] = &curves.tangential_slope;
    let [curvature_x, curvature_y] = &curves.tangential_curvature;
    for i in 0..n {
        let normal = bounded(curves.normal.0[i]);
        let limit = mu[i] * normal;
        let limit = if unlimited { 0.0 } else { limit };
        let sticks = regime.0[i] == STICK;
        // Zero has no sign.
        let t_x = if sticks { trial_x.0[i] } else { limit * direction_x.0[i] } + 0.0;
        let t_y = if sticks { trial_y.0[i] } else { limit * direction_y.0[i] } + 0.0;
        let (mut t_n, mut memory_1, mut memory_2) = (normal, t_x, t_y);
        if stretches::<R>() {
            memory_1 = ratio.0[i] * stretch_x.0[i];
            memory_2 = ratio.0[i] * stretch_y.0[i];
            let addition = rule.normal_addition(
                [memory_1, memory_2],
                [
                    jet(k_x.0[i], slope_x.0[i], curvature_x.0[i]),
                    jet(k_y.0[i], slope_y.0[i], curvature_y.0[i]),
                ],
            );
            t_n = within(normal + addition.value, TRACTION);
        }
        let closed = u_n.0[i] > 0.0;
        // Zero, or NaN where the input is no number.
        let fill = 0.0 * u_n.0[i];
        traction_x[i] = if closed { t_x } else { fill };
        traction_y[i] = if closed { t_y } else { fill };
        traction_n[i] = if closed { t_n } else { fill };
        end_1[i] = if closed { memory_1 } else { fill };
        end_2[i] = if closed { memory_2 } else { fill };
    }
}

/// Consistent tangent: with the direction of slip `d`, `t = limit d`, so
/// `dt = (limit/|trial|) (I - d d) d(trial) + limit' d du_n`.
struct Tangents<'a, 'b, R, const B: usize>(&'a mut Block<'b, B>, R);

impl<R: FrictionRule, const B: usize> Pass for Tangents<'_, '_, R, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self(block, rule) = self;
        let Some([xx, xy, xn, yx, yy, yn, nx, ny, nn]) = &mut block.tangent else {
            return;
        };
        tangential_rows(
            block.mu_slope,
            block.u_n,
            block.curves,
            block.workspace,
            xx,
            xy,
            xn,
            yx,
            yy,
            yn,
        );
        normal_row(
            rule,
            block.mu_slope,
            block.u_n,
            block.curves,
            block.workspace,
            nx,
            ny,
            nn,
        );
    }
}

/// Derivative of the slip limit with respect to the interference.
#[inline(always)]
pub(super) fn limit_slope(mu_slope: f64, normal_slope: f64) -> f64 {
    within(mu_slope * bounded(normal_slope), TRACTION)
}

/// Rows of the tangential tractions.
#[inline(always)]
fn tangential_rows<const B: usize>(
    mu_slope: &[f64],
    u_n: &Lanes<f64, B>,
    curves: &CurveBlock<B>,
    workspace: &Workspace<B>,
    xx: &mut [f64],
    xy: &mut [f64],
    xn: &mut [f64],
    yx: &mut [f64],
    yy: &mut [f64],
    yn: &mut [f64],
) {
    let n = mu_slope.len().min(B);
    let mu_slope = &mu_slope[..n];
    let (xx, xy, xn) = (&mut xx[..n], &mut xy[..n], &mut xn[..n]);
    let (yx, yy, yn) = (&mut yx[..n], &mut yy[..n], &mut yn[..n]);
    let ([along_x, along_y], [closing_x, closing_y]) = (&workspace.along, &workspace.closing);
    let [direction_x, direction_y] = &workspace.direction;
    for i in 0..n {
        let rows = rows_of(
            workspace.regime.0[i] == STICK,
            [direction_x.0[i], direction_y.0[i]],
            workspace.ratio.0[i],
            [along_x.0[i], along_y.0[i]],
            [closing_x.0[i], closing_y.0[i]],
            limit_slope(mu_slope[i], curves.normal_slope.0[i]),
        );
        let closed = u_n.0[i] > 0.0;
        let fill = 0.0 * u_n.0[i];
        xx[i] = if closed { rows[0] } else { fill };
        xy[i] = if closed { rows[1] } else { fill };
        xn[i] = if closed { rows[2] } else { fill };
        yx[i] = if closed { rows[3] } else { fill };
        yy[i] = if closed { rows[4] } else { fill };
        yn[i] = if closed { rows[5] } else { fill };
    }
}

/// Rows of the tangential tractions of a closed point, from the derivatives of the trial along each direction and along `u_n`.
#[inline(always)]
fn rows_of(
    sticks: bool,
    [d_x, d_y]: [f64; 2],
    ratio: f64,
    [along_x, along_y]: [f64; 2],
    [closing_x, closing_y]: [f64; 2],
    slip_slope: f64,
) -> [f64; 6] {
    let across_x = if sticks { 1.0 } else { ratio * d_y * d_y };
    let across_y = if sticks { 1.0 } else { ratio * d_x * d_x };
    let mixed = -(ratio * d_x * d_y);
    [
        across_x * along_x,
        mixed * along_y,
        across_x * closing_x + mixed * closing_y + slip_slope * d_x,
        mixed * along_x,
        across_y * along_y,
        mixed * closing_x + across_y * closing_y + slip_slope * d_y,
    ]
}

/// Row of the normal traction.
#[inline(always)]
fn normal_row<R: FrictionRule, const B: usize>(
    rule: R,
    mu_slope: &[f64],
    u_n: &Lanes<f64, B>,
    curves: &CurveBlock<B>,
    workspace: &Workspace<B>,
    nx: &mut [f64],
    ny: &mut [f64],
    nn: &mut [f64],
) {
    let n = mu_slope.len().min(B);
    let mu_slope = &mu_slope[..n];
    let (nx, ny, nn) = (&mut nx[..n], &mut ny[..n], &mut nn[..n]);
    let ([along_x, along_y], [closing_x, closing_y]) = (&workspace.along, &workspace.closing);
    let ([stretch_x, stretch_y], [direction_x, direction_y]) = (&workspace.stretch, &workspace.direction);
    let [stretch_slope_x, stretch_slope_y] = &workspace.stretch_slope;
    let [k_x, k_y] = &curves.tangential;
    let [slope_x, slope_y] = &curves.tangential_slope;
    let [curvature_x, curvature_y] = &curves.tangential_curvature;
    for i in 0..n {
        let slope = bounded(curves.normal_slope.0[i]);
        let (mut row_x, mut row_y, mut row_n) = (0.0, 0.0, slope);
        if stretches::<R>() {
            // The held stretch is `ratio` times the trial's; `ratio` changes with the limit and with |trial|.
            let (ratio, share, per_trial) = (workspace.ratio.0[i], workspace.share.0[i], workspace.per_trial.0[i]);
            let (d_x, d_y) = (direction_x.0[i], direction_y.0[i]);
            let (held_x, held_y) = (ratio * stretch_x.0[i], ratio * stretch_y.0[i]);
            let addition = rule.normal_addition(
                [held_x, held_y],
                [
                    jet(k_x.0[i], slope_x.0[i], curvature_x.0[i]),
                    jet(k_y.0[i], slope_y.0[i], curvature_y.0[i]),
                ],
            );
            let [weight_x, weight_y] = addition.along;
            let turn = weight_x * stretch_x.0[i] + weight_y * stretch_y.0[i];
            let limit_slope = if workspace.regime.0[i] == STICK {
                0.0
            } else {
                limit_slope(mu_slope[i], curves.normal_slope.0[i])
            };
            let along_slip = ratio * (d_x * closing_x.0[i] + d_y * closing_y.0[i]);
            let stretching = ratio * (weight_x * stretch_slope_x.0[i] + weight_y * stretch_slope_y.0[i]);
            row_x = ratio * share * weight_x - turn * bounded(ratio * d_x * along_x.0[i] * per_trial);
            row_y = ratio * share * weight_y - turn * bounded(ratio * d_y * along_y.0[i] * per_trial);
            row_n += addition.closing + stretching + turn * bounded((limit_slope - along_slip) * per_trial);
            row_x = within(row_x, TRACTION);
            row_y = within(row_y, TRACTION);
            row_n = within(row_n, TRACTION);
        }
        let closed = u_n.0[i] > 0.0;
        let fill = 0.0 * u_n.0[i];
        nx[i] = if closed { row_x } else { fill };
        ny[i] = if closed { row_y } else { fill };
        nn[i] = if closed { row_n } else { fill };
    }
}

/// Changes along a direction: with the notation of [`Tangents`], `dt = d(trial)` where a point sticks and
/// `dt = (limit/|trial|) (I - d d) d(trial) + d(limit) d` where it slips.
struct Changes<'a, 'b, 'c, R, const B: usize>(&'a Block<'b, B>, &'a mut Derivative<'c, B>, R);

impl<R: FrictionRule, const B: usize> Pass for Changes<'_, '_, '_, R, B> {
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self(block, derivative, rule) = self;
        let mut trial = [Lanes([0.0; B]); 2];
        let mut stretch = [Lanes([0.0; B]); 2];
        if block.present.reclosed {
            both_trial_changes::<R, true, B>(rule, block, derivative, &mut trial, &mut stretch);
        } else {
            both_trial_changes::<R, false, B>(rule, block, derivative, &mut trial, &mut stretch);
        }
        let Derivative {
            jump: [_, _, change_n],
            curves,
            memory: [end_1, end_2],
            traction: [traction_x, traction_y, traction_n],
            ..
        } = derivative;
        let ([trial_x, trial_y], [stretch_x, stretch_y]) = (&trial, &stretch);
        changes(
            rule,
            change_n,
            block.u_n,
            block.curves,
            curves,
            block.workspace,
            trial_x,
            trial_y,
            stretch_x,
            stretch_y,
            traction_x,
            traction_y,
            traction_n,
            end_1,
            end_2,
        );
    }
}

/// Changes of the stuck trials along x and y, and of the stretches that sticking would leave.
#[inline(always)]
fn both_trial_changes<R: FrictionRule, const REOPENS: bool, const B: usize>(
    rule: R,
    block: &Block<'_, B>,
    derivative: &Derivative<'_, B>,
    trial: &mut [Lanes<f64, B>; 2],
    stretch: &mut [Lanes<f64, B>; 2],
) {
    let (jump, begin) = (block.jump, block.begin);
    let (curves, changes) = (block.curves, derivative.curves);
    for q in 0..2 {
        trial_changes::<R, REOPENS, B>(
            rule,
            jump[q],
            begin[q],
            jump[2],
            begin[2],
            begin[3 + q],
            derivative.jump[q],
            derivative.begin[q],
            derivative.jump[2],
            derivative.begin[2],
            derivative.begin[3 + q],
            &curves.tangential[q],
            &curves.tangential_slope[q],
            &changes.tangential[q],
            &changes.tangential_slope[q],
            &mut trial[q],
            &mut stretch[q],
        );
    }
}

/// Changes of the stuck trials along one direction of the surface.
#[inline(always)]
fn trial_changes<R: FrictionRule, const REOPENS: bool, const B: usize>(
    rule: R,
    u: &[f64],
    u_0: &[f64],
    u_n: &[f64],
    u_n0: &[f64],
    memory: &[f64],
    change: &[f64],
    change_0: &[f64],
    change_n: &[f64],
    change_n0: &[f64],
    change_memory: &[f64],
    k: &Lanes<f64, B>,
    k_slope: &Lanes<f64, B>,
    k_change: &Lanes<f64, B>,
    slope_change: &Lanes<f64, B>,
    trial: &mut Lanes<f64, B>,
    stretch: &mut Lanes<f64, B>,
) {
    let n = u.len().min(B);
    let (u, u_0, u_n, u_n0, memory) = (&u[..n], &u_0[..n], &u_n[..n], &u_n0[..n], &memory[..n]);
    let (change, change_0, change_memory) = (&change[..n], &change_0[..n], &change_memory[..n]);
    let (change_n, change_n0) = (&change_n[..n], &change_n0[..n]);
    for i in 0..n {
        let du = bounded(u[i] - u_0[i]);
        let du_change = bounded(change[i] - change_0[i]);
        let (share, share_change) = if REOPENS {
            let (length, reopened) = (u_n[i] - u_n0[i], u_n0[i] < 0.0);
            let closed = u_n[i] / length;
            let by_end = bounded((1.0 - closed) / length) * bounded(change_n[i]);
            let by_begin = bounded(closed / length) * bounded(change_n0[i]);
            (
                if reopened { closed } else { 1.0 },
                if reopened { bounded(by_end + by_begin) } else { 0.0 },
            )
        } else {
            (1.0, 0.0)
        };
        let path = path([u[i], u_0[i]], [u_n[i], u_n0[i]], memory[i], [share, 0.0]);
        let path_change = PathChange {
            u: bounded(change[i]),
            du: du_change,
            du_n: bounded(change_n[i] - change_n0[i]),
            share: share_change,
            traction: within(change_memory[i], TRACTION),
            stretch: within(change_memory[i] + share_change * du + share * du_change, STRETCH),
        };
        let k_change = StiffnessChange {
            value: bounded(k_change.0[i]),
            slope: bounded(slope_change.0[i]),
        };
        let changed = rule.trial_change(path, jet(k.0[i], k_slope.0[i], 0.0), path_change, k_change);
        trial.0[i] = within(changed, TRACTION);
        if stretches::<R>() {
            stretch.0[i] = path_change.stretch;
        }
    }
}

/// Changes of the tractions and of what the end state remembers of them.
#[inline(always)]
fn changes<R: FrictionRule, const B: usize>(
    rule: R,
    change_n: &[f64],
    u_n: &Lanes<f64, B>,
    curves: &CurveBlock<B>,
    curve_change: &CurveChange<B>,
    workspace: &Workspace<B>,
    trial_x: &Lanes<f64, B>,
    trial_y: &Lanes<f64, B>,
    stretch_x: &Lanes<f64, B>,
    stretch_y: &Lanes<f64, B>,
    traction_x: &mut [f64],
    traction_y: &mut [f64],
    traction_n: &mut [f64],
    end_1: &mut [f64],
    end_2: &mut [f64],
) {
    let n = change_n.len().min(B);
    let change_n = &change_n[..n];
    let (traction_x, traction_y, traction_n) = (&mut traction_x[..n], &mut traction_y[..n], &mut traction_n[..n]);
    let (end_1, end_2) = (&mut end_1[..n], &mut end_2[..n]);
    let ([held_x, held_y], [direction_x, direction_y]) = (&workspace.stretch, &workspace.direction);
    let [k_x, k_y] = &curves.tangential;
    let [slope_x, slope_y] = &curves.tangential_slope;
    let [curvature_x, curvature_y] = &curves.tangential_curvature;
    for i in 0..n {
        let (trial_x, trial_y) = (trial_x.0[i], trial_y.0[i]);
        let (d_x, d_y, ratio) = (direction_x.0[i], direction_y.0[i], workspace.ratio.0[i]);
        let sticks = workspace.regime.0[i] == STICK;
        let across_x = if sticks { 1.0 } else { ratio * d_y * d_y };
        let across_y = if sticks { 1.0 } else { ratio * d_x * d_x };
        let mixed = -(ratio * d_x * d_y);
        let limit = within(curve_change.limit.0[i], TRACTION);
        let t_x = across_x * trial_x + mixed * trial_y + limit * d_x;
        let t_y = mixed * trial_x + across_y * trial_y + limit * d_y;
        let (mut t_n, mut memory_1, mut memory_2) = (within(curve_change.normal.0[i], TRACTION), t_x, t_y);
        if stretches::<R>() {
            let beyond = limit - ratio * (d_x * trial_x + d_y * trial_y);
            let turn = bounded(if sticks { 0.0 } else { beyond } * workspace.per_trial.0[i]);
            memory_1 = ratio * stretch_x.0[i] + turn * held_x.0[i];
            memory_2 = ratio * stretch_y.0[i] + turn * held_y.0[i];
            let addition = rule.normal_addition(
                [ratio * held_x.0[i], ratio * held_y.0[i]],
                [
                    jet(k_x.0[i], slope_x.0[i], curvature_x.0[i]),
                    jet(k_y.0[i], slope_y.0[i], curvature_y.0[i]),
                ],
            );
            let [along_x, along_y] = addition.along;
            let stretching = bounded(along_x) * bounded(memory_1) + bounded(along_y) * bounded(memory_2);
            t_n = within(
                t_n + stretching + bounded(addition.closing) * bounded(change_n[i]),
                TRACTION,
            );
        }
        let closed = u_n.0[i] > 0.0;
        // Zero, or NaN where the input is no number.
        let fill = 0.0 * u_n.0[i];
        let spoilt = curve_change.fill.0[i];
        traction_x[i] = spoilt + if closed { t_x } else { fill };
        traction_y[i] = spoilt + if closed { t_y } else { fill };
        traction_n[i] = spoilt + if closed { t_n } else { fill };
        end_1[i] = spoilt + if closed { memory_1 } else { fill };
        end_2[i] = spoilt + if closed { memory_2 } else { fill };
    }
}

/// 2^-600 and 2^600.
const DOWN: f64 = f64::from_bits((1023 - 600) << 52);
const UP: f64 = f64::from_bits((1023 + 600) << 52);

/// Bounds of tractions (Pa) and of stretches (m).
pub(super) const TRACTION: f64 = 1e300;
const STRETCH: f64 = 1e75;
