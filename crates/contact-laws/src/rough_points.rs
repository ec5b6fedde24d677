//! The fitted curves of many points at once: the formulas of [`FittedCurves`] as loops over blocks of points that fill
//! vector registers, with elementary functions of their own.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use crate::curves::{CurveBlock, CurvesInfo, PointCurves};
use crate::elementary::{Real, ln_pair, max, min};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::PointParameters;
use crate::rough::{FittedCurves, INFO, TangentialEnds};
use crate::vector::{BLOCK, Lanes, Pass, run};

/// Fitted curves of the points of a law, one column per parameter. `R` is the precision in which the formulas are
/// evaluated, `f64` or `f32`; interferences, values and slopes are `f64` with either.
///
/// Interferences outside `1e-150 u_ref` to `1e150 u_ref` (`1e-37` to `1e37` for `f32`) are taken as these.
#[derive(Debug, Clone)]
pub struct FittedPoints<R = f64> {
    n_points: usize,
    /// All points share the same curves: the columns are one block long and serve every block.
    uniform: bool,
    /// Some point has a fitted range.
    ranged: bool,
    /// Every point has the same stiffness along x and y.
    isotropic: bool,
    per_u_ref: Vec<f64>,
    normal: NormalColumns<R>,
    tangential: [TangentialColumns<R>; 2],
}

/// Eq. (28) as `t_n = scale exp(b x + c exp(-((x + d) per_e)^2 / 2))`, `x = ln(u_n per_u_ref)`.
#[derive(Debug, Clone, Default)]
struct NormalColumns<R> {
    scale: Vec<f64>,
    b: Vec<R>,
    c: Vec<R>,
    d: Vec<R>,
    per_e: Vec<R>,
    range: RangeColumns<R>,
}

/// Eq. (29) as `k = scale exp(b tanh(d (x - c)))`.
#[derive(Debug, Clone, Default)]
struct TangentialColumns<R> {
    scale: Vec<f64>,
    b: Vec<R>,
    c: Vec<R>,
    d: Vec<R>,
    range: RangeColumns<R>,
    /// Upper end of the range as `u_n per_u_ref`.
    upper: Vec<R>,
    /// Log-slope towards zero interference: 1/2 for ends after Mindlin, 0 for constant ends.
    exponent: Vec<R>,
}

/// Fitted range; infinite where there is none.
#[derive(Debug, Clone, Default)]
struct RangeColumns<R> {
    /// Ends as `ln(u_n per_u_ref)`.
    ln_lower: Vec<R>,
    ln_upper: Vec<R>,
    /// Reciprocal of the lower end as `u_n per_u_ref`.
    per_lower: Vec<R>,
}

impl<R: Real> RangeColumns<R> {
    fn push(&mut self, range: Option<[f64; 2]>, per_u_ref: f64) {
        let [lower, upper] = range.map_or([0.0, f64::INFINITY], |range| range.map(|u| u * per_u_ref));
        self.ln_lower.push(R::of(lower.ln()));
        self.ln_upper.push(R::of(upper.ln()));
        self.per_lower.push(R::of(1.0 / lower));
    }
}

impl<R: Real> FittedPoints<R> {
    /// From the curves of every point.
    pub fn new(curves: &PointParameters<FittedCurves>) -> Self {
        let (n_points, uniform) = (curves.len(), curves.is_uniform());
        let mut points = Self {
            n_points,
            uniform,
            ranged: false,
            isotropic: true,
            per_u_ref: vec![],
            normal: NormalColumns::default(),
            tangential: <[TangentialColumns<R>; 2]>::default(),
        };
        for i in 0..if uniform { n_points.min(BLOCK) } else { n_points } {
            points.push(curves.at(i));
        }
        points
    }

    fn push(&mut self, curves: &FittedCurves) {
        let fit = curves.normal_fit();
        let per_u_ref = 1.0 / fit.u_ref;
        self.per_u_ref.push(per_u_ref);
        self.ranged |= fit.range.is_some();
        self.normal.scale.push(fit.t_ref * fit.a.exp());
        self.normal.b.push(R::of(fit.b));
        self.normal.c.push(R::of(fit.c));
        self.normal.d.push(R::of(fit.d));
        self.normal.per_e.push(R::of(1.0 / fit.e));
        self.normal.range.push(fit.range, per_u_ref);
        let [x, y] = curves.tangential_fits();
        self.isotropic &= x == y;
        for (columns, fit) in self.tangential.iter_mut().zip(curves.tangential_fits()) {
            self.ranged |= fit.range.is_some();
            columns.scale.push(fit.k_ref * fit.a.exp());
            columns.b.push(R::of(fit.b));
            // All curves of a point use the normal traction's reference, so that their logarithms are shared.
            columns.c.push(R::of(fit.c + (fit.u_ref * per_u_ref).ln()));
            columns.d.push(R::of(fit.d));
            columns.range.push(fit.range, per_u_ref);
            let upper = fit.range.map_or(f64::INFINITY, |[_, upper]| upper * per_u_ref);
            columns.upper.push(R::of(upper));
            columns.exponent.push(R::of(match fit.ends {
                TangentialEnds::Mindlin => 0.5,
                TangentialEnds::Constant => 0.0,
            }));
        }
    }
}

impl<R: Real> PointCurves for FittedPoints<R> {
    type Workspace = Workspace<R>;

    fn info(&self) -> Option<&'static CurvesInfo> {
        Some(&INFO)
    }

    fn len(&self) -> usize {
        self.n_points
    }

    fn evaluate(
        &self,
        first: usize,
        u_n: &[f64],
        middle: &[f64],
        curvature: bool,
        workspace: &mut Workspace<R>,
        out: &mut CurveBlock,
    ) {
        let start = if self.uniform { 0 } else { first };
        let at = start..start + u_n.len();
        if curvature {
            run(Formulas::<R, true> {
                points: self,
                at,
                u_n,
                middle,
                workspace,
                out,
            });
        } else {
            run(Formulas::<R, false> {
                points: self,
                at,
                u_n,
                middle,
                workspace,
                out,
            });
        }
    }

    fn contact_area_ratio(&self, _point: usize, _u_n: f64) -> Option<f64> {
        None
    }

    fn yielded_fraction(&self, _point: usize, _u_n: f64, _omega_c: f64) -> Option<f64> {
        None
    }
}

/// Both formulas at the points of a block, with or without second derivatives.
struct Formulas<'a, R, const CURVATURE: bool> {
    points: &'a FittedPoints<R>,
    /// The block in the columns.
    at: Range<usize>,
    u_n: &'a [f64],
    middle: &'a [f64],
    workspace: &'a mut Workspace<R>,
    out: &'a mut CurveBlock,
}

/// Numbers between the passes over a block. Of three arrays, the first belongs to the normal traction, the others to the
/// stiffnesses along x and y; of two, the first to the normal traction, the second to both stiffnesses.
#[derive(Debug)]
pub struct Workspace<R> {
    /// `U = u per_u_ref`, its reciprocal and its logarithm.
    ratio: [Lanes<R>; 2],
    per_ratio: [Lanes<f64>; 2],
    ln: [Lanes<R>; 2],
    /// `ln U` held within the fitted range.
    held: [Lanes<R>; 3],
    /// Arguments of exponentials, then their values: first those within the formulas, then the results over their scale.
    exponential: [Lanes<R>; 3],
    /// `y` of eq. (28) and `z` of eq. (29), then the log-slopes.
    inner: [Lanes<R>; 3],
    /// Changes of the log-slopes along x and y with `ln U`.
    slope_change: [Lanes<R>; 2],
}

impl<R: Real> Default for Workspace<R> {
    fn default() -> Self {
        let zero = Lanes([R::of(0.0); BLOCK]);
        Self {
            ratio: [zero; 2],
            per_ratio: [Lanes([0.0; BLOCK]); 2],
            ln: [zero; 2],
            held: [zero; 3],
            exponential: [zero; 3],
            inner: [zero; 3],
            slope_change: [zero; 2],
        }
    }
}

impl<R: Real, const CURVATURE: bool> Pass for Formulas<'_, R, CURVATURE> {
    /// Loops of a few dozen instructions: the processor overlaps several turns of such a loop, but not of a long one.
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self {
            points,
            at,
            u_n,
            middle,
            workspace,
            out,
        } = self;
        let n = u_n.len();
        let per_u_ref = &points.per_u_ref[at.clone()];
        let (normal, [x, y], isotropic) = (&points.normal, &points.tangential, points.isotropic);
        arguments::<R, FMA>(u_n, middle, per_u_ref, workspace);
        let Workspace {
            ratio: [ratio_n, ratio_t],
            per_ratio: [per_ratio_n, per_ratio_t],
            ln: [ln_n, ln_t],
            held: [held_n, held_x, held_y],
            exponential: [e_n, e_x, e_y],
            inner: [y_n, z_x, z_y],
            slope_change: [change_x, change_y],
        } = workspace;
        let mut beyond = false;
        if points.ranged {
            beyond |= normal.range.hold(&at, u_n, ln_n, held_n);
            beyond |= x.range.hold(&at, u_n, ln_t, held_x);
            beyond |= !isotropic && y.range.hold(&at, u_n, ln_t, held_y);
        } else {
            (*held_n, *held_x, *held_y) = (*ln_n, *ln_t, *ln_t);
        }
        normal.inner(&at, n, held_n, y_n, e_n);
        x.inner(&at, n, held_x, z_x, e_x);
        if !isotropic {
            y.inner(&at, n, held_y, z_y, e_y);
        }
        exponentials::<R, FMA>(n, e_n, e_x, (!isotropic).then_some(&mut *e_y));
        normal.outer(&at, n, held_n, y_n, e_n);
        x.outer::<CURVATURE>(&at, n, z_x, e_x, change_x);
        if !isotropic {
            y.outer::<CURVATURE>(&at, n, z_y, e_y, change_y);
        }
        if beyond {
            normal.continuation(&at, n, ratio_n, ln_n, y_n, e_n);
            x.continuation::<CURVATURE>(&at, n, ratio_t, per_ratio_t, ln_t, z_x, e_x, change_x);
            if !isotropic {
                y.continuation::<CURVATURE>(&at, n, ratio_t, per_ratio_t, ln_t, z_y, e_y, change_y);
            }
        }
        exponentials::<R, FMA>(n, e_n, e_x, (!isotropic).then_some(&mut *e_y));
        let CurveBlock {
            normal: t,
            normal_slope: slope_t,
            tangential: [k_x, k_y],
            tangential_slope: [slope_x, slope_y],
            tangential_curvature: [curvature_x, curvature_y],
        } = out;
        values(&normal.scale[at.clone()], per_u_ref, per_ratio_n, e_n, y_n, t, slope_t);
        values(&x.scale[at.clone()], per_u_ref, per_ratio_t, e_x, z_x, k_x, slope_x);
        if CURVATURE {
            curvatures(per_u_ref, per_ratio_t, k_x, z_x, change_x, curvature_x);
        }
        if isotropic {
            (*k_y, *slope_y, *curvature_y) = (*k_x, *slope_x, *curvature_x);
            return;
        }
        values(&y.scale[at], per_u_ref, per_ratio_t, e_y, z_y, k_y, slope_y);
        if CURVATURE {
            curvatures(per_u_ref, per_ratio_t, k_y, z_y, change_y, curvature_y);
        }
    }
}

/// Interferences over their reference, with logarithm and reciprocal.
#[inline(always)]
fn arguments<R: Real, const FMA: bool>(u_n: &[f64], middle: &[f64], per_u_ref: &[f64], workspace: &mut Workspace<R>) {
    let n = u_n.len().min(BLOCK);
    let (u_n, middle, per_u_ref) = (&u_n[..n], &middle[..n], &per_u_ref[..n]);
    let ([ratio_n, ratio_t], [ln_n, ln_t]) = (&mut workspace.ratio, &mut workspace.ln);
    let [per_ratio_n, per_ratio_t] = &mut workspace.per_ratio;
    let [smallest, largest] = R::RANGE;
    for i in 0..n {
        // Open points are not used: any number that costs no more than others will do.
        let closed = u_n[i] > 0.0;
        let u = if closed {
            max(min(u_n[i] * per_u_ref[i], 1e150), 1e-150)
        } else {
            1.0
        };
        let m = if closed {
            max(min(middle[i] * per_u_ref[i], 1e150), 1e-150)
        } else {
            1.0
        };
        let per_both = 1.0 / (u * m);
        per_ratio_n.0[i] = m * per_both;
        per_ratio_t.0[i] = u * per_both;
        ratio_n.0[i] = R::of(max(min(u, largest), smallest));
        ratio_t.0[i] = R::of(max(min(m, largest), smallest));
    }
    for i in 0..n {
        let (of_n, of_t) = ln_pair::<R, FMA>(ratio_n.0[i], ratio_t.0[i]);
        ln_n.0[i] = of_n;
        ln_t.0[i] = of_t;
    }
}

/// Exponentials in place, of all arrays at a time: what they share is loaded once.
#[inline(always)]
fn exponentials<R: Real, const FMA: bool>(n: usize, a: &mut Lanes<R>, b: &mut Lanes<R>, c: Option<&mut Lanes<R>>) {
    let (n, most) = (n.min(BLOCK), R::of(R::LARGEST_EXPONENT));
    let Some(c) = c else {
        for i in 0..n {
            a.0[i] = min(a.0[i], most).natural_exp::<FMA>();
            b.0[i] = min(b.0[i], most).natural_exp::<FMA>();
        }
        return;
    };
    for i in 0..n {
        a.0[i] = min(a.0[i], most).natural_exp::<FMA>();
        b.0[i] = min(b.0[i], most).natural_exp::<FMA>();
        c.0[i] = min(c.0[i], most).natural_exp::<FMA>();
    }
}

impl<R: Real> RangeColumns<R> {
    /// Holds `ln U` within the range; true when a closed point lies beyond.
    #[inline(always)]
    fn hold(&self, at: &Range<usize>, u_n: &[f64], ln: &Lanes<R>, held: &mut Lanes<R>) -> bool {
        let n = u_n.len().min(BLOCK);
        let (lower, upper) = (&self.ln_lower[at.clone()][..n], &self.ln_upper[at.clone()][..n]);
        let mut n_beyond = 0_u64;
        for i in 0..n {
            let x = ln.0[i];
            let within = max(min(x, upper[i]), lower[i]);
            held.0[i] = within;
            n_beyond += u64::from((within != x) & (u_n[i] > 0.0));
        }
        n_beyond > 0
    }
}

impl<R: Real> NormalColumns<R> {
    /// `y` and the exponent of the bell.
    #[inline(always)]
    fn inner(&self, at: &Range<usize>, n: usize, x: &Lanes<R>, y: &mut Lanes<R>, exponent: &mut Lanes<R>) {
        let n = n.min(BLOCK);
        let (d, per_e) = (&self.d[at.clone()][..n], &self.per_e[at.clone()][..n]);
        for i in 0..n {
            let y_i = (x.0[i] + d[i]) * per_e[i];
            y.0[i] = y_i;
            exponent.0[i] = y_i * y_i * R::of(-0.5);
        }
    }

    /// `ln(t_n / scale)` in place of the bell, the log-slope in place of `y`.
    #[inline(always)]
    fn outer(&self, at: &Range<usize>, n: usize, x: &Lanes<R>, y: &mut Lanes<R>, bell: &mut Lanes<R>) {
        let n = n.min(BLOCK);
        let (b, c, per_e) = (
            &self.b[at.clone()][..n],
            &self.c[at.clone()][..n],
            &self.per_e[at.clone()][..n],
        );
        for i in 0..n {
            let bell_i = bell.0[i] * c[i];
            y.0[i] = b[i] - bell_i * y.0[i] * per_e[i];
            bell.0[i] = b[i] * x.0[i] + bell_i;
        }
    }

    /// Beyond the range: the log-slope moves to 3/2 below and stays above.
    #[inline(always)]
    fn continuation(
        &self,
        at: &Range<usize>,
        n: usize,
        ratio: &Lanes<R>,
        ln: &Lanes<R>,
        log_slope: &mut Lanes<R>,
        value: &mut Lanes<R>,
    ) {
        let n = n.min(BLOCK);
        let (lower, upper) = (
            &self.range.ln_lower[at.clone()][..n],
            &self.range.ln_upper[at.clone()][..n],
        );
        let per_lower = &self.range.per_lower[at.clone()][..n];
        let (zero, one, exponent) = (R::of(0.0), R::of(1.0), R::of(1.5));
        for i in 0..n {
            let (x, slope) = (ln.0[i], log_slope.0[i]);
            let from_exponent = slope - exponent;
            let v = min(ratio.0[i] * per_lower[i], one);
            let below = exponent * (x - lower[i]) + from_exponent * (v - one);
            let above = slope * (x - upper[i]);
            let is_below = x < lower[i];
            let change = if x > upper[i] { above } else { zero };
            value.0[i] = value.0[i] + if is_below { below } else { change };
            log_slope.0[i] = if is_below { exponent + from_exponent * v } else { slope };
        }
    }
}

impl<R: Real> TangentialColumns<R> {
    /// `z = d (ln U - c)` and `-2 |z|`.
    #[inline(always)]
    fn inner(&self, at: &Range<usize>, n: usize, x: &Lanes<R>, z: &mut Lanes<R>, exponent: &mut Lanes<R>) {
        let n = n.min(BLOCK);
        let (c, d) = (&self.c[at.clone()][..n], &self.d[at.clone()][..n]);
        for i in 0..n {
            let z_i = d[i] * (x.0[i] - c[i]);
            z.0[i] = z_i;
            exponent.0[i] = z_i.magnitude() * R::of(-2.0);
        }
    }

    /// `ln(k / scale)` in place of `exp(-2 |z|)`, the log-slope in place of `z`.
    #[inline(always)]
    fn outer<const CURVATURE: bool>(
        &self,
        at: &Range<usize>,
        n: usize,
        z: &mut Lanes<R>,
        decay: &mut Lanes<R>,
        slope_change: &mut Lanes<R>,
    ) {
        let n = n.min(BLOCK);
        let (b, d) = (&self.b[at.clone()][..n], &self.d[at.clone()][..n]);
        let one = R::of(1.0);
        for i in 0..n {
            let per_sum = one / (one + decay.0[i]);
            let step = ((one - decay.0[i]) * per_sum).with_sign(z.0[i]);
            let slope = b[i] * d[i] * (R::of(4.0) * decay.0[i] * per_sum * per_sum);
            decay.0[i] = b[i] * step;
            z.0[i] = slope;
            if CURVATURE {
                slope_change.0[i] = R::of(-2.0) * d[i] * step * slope;
            }
        }
    }

    /// Beyond the range: the log-slope moves to the lower exponent below, and stays or moves to zero above.
    #[inline(always)]
    fn continuation<const CURVATURE: bool>(
        &self,
        at: &Range<usize>,
        n: usize,
        ratio: &Lanes<R>,
        per_ratio: &Lanes<f64>,
        ln: &Lanes<R>,
        log_slope: &mut Lanes<R>,
        value: &mut Lanes<R>,
        slope_change: &mut Lanes<R>,
    ) {
        let n = n.min(BLOCK);
        let (lower, upper) = (
            &self.range.ln_lower[at.clone()][..n],
            &self.range.ln_upper[at.clone()][..n],
        );
        let (per_lower, at_upper) = (&self.range.per_lower[at.clone()][..n], &self.upper[at.clone()][..n]);
        let exponent = &self.exponent[at.clone()][..n];
        let (zero, one) = (R::of(0.0), R::of(1.0));
        for i in 0..n {
            let (x, slope, exponent) = (ln.0[i], log_slope.0[i], exponent[i]);
            let (is_below, is_above, to_constant) = (x < lower[i], x > upper[i], exponent == zero);
            let from_exponent = slope - exponent;
            let v = min(ratio.0[i] * per_lower[i], one);
            let w = min(at_upper[i] * R::of(per_ratio.0[i]), one);
            let below = exponent * (x - lower[i]) + from_exponent * (v - one);
            let (to_there, on_and_on) = (slope * (one - w), slope * (x - upper[i]));
            let above = if to_constant { to_there } else { on_and_on };
            let above = if is_above { above } else { zero };
            value.0[i] = value.0[i] + if is_below { below } else { above };
            let slope_above = if to_constant & is_above { slope * w } else { slope };
            log_slope.0[i] = if is_below {
                exponent + from_exponent * v
            } else {
                slope_above
            };
            if CURVATURE {
                let change_above = if to_constant { -slope_above } else { zero };
                let change = if is_above { change_above } else { slope_change.0[i] };
                slope_change.0[i] = if is_below { from_exponent * v } else { change };
            }
        }
    }
}

/// Values and slopes from values over the scale and log-slopes.
#[inline(always)]
fn values<R: Real>(
    scale: &[f64],
    per_u_ref: &[f64],
    per_ratio: &Lanes<f64>,
    over_scale: &Lanes<R>,
    log_slope: &Lanes<R>,
    value: &mut Lanes<f64>,
    slope: &mut Lanes<f64>,
) {
    let n = per_u_ref.len().min(BLOCK);
    let (scale, per_u_ref) = (&scale[..n], &per_u_ref[..n]);
    for i in 0..n {
        let v = bounded(scale[i] * over_scale.0[i].double());
        value.0[i] = v;
        slope.0[i] = v * bounded(per_ratio.0[i] * per_u_ref[i]) * log_slope.0[i].double();
    }
}

/// Second derivatives from values, log-slopes and their changes.
#[inline(always)]
fn curvatures<R: Real>(
    per_u_ref: &[f64],
    per_ratio: &Lanes<f64>,
    value: &Lanes<f64>,
    log_slope: &Lanes<R>,
    slope_change: &Lanes<R>,
    curvature: &mut Lanes<f64>,
) {
    let n = per_u_ref.len().min(BLOCK);
    let per_u_ref = &per_u_ref[..n];
    for i in 0..n {
        let per_u = bounded(per_ratio.0[i] * per_u_ref[i]);
        let (g, change) = (log_slope.0[i].double(), slope_change.0[i].double());
        curvature.0[i] = bounded(value.0[i] * per_u) * per_u * (g * g - g + change);
    }
}

/// Keeps products of two such values finite, so that none of them times zero can be anything but zero.
#[inline(always)]
fn bounded(value: f64) -> f64 {
    min(value, 1e150)
}
