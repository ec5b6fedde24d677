//! The fitted curves of many points at once: the formulas of [`FittedCurves`] as loops over blocks of points that fill
//! vector registers, with elementary functions of their own.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use crate::curves::fitted::{FittedCurves, INFO, TangentialEnds};
use crate::curves::{CurveBlock, CurvesInfo, PointCurves};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::PointParameters;
use crate::simd::elementary::{Real, ln_pair, max, min};
use crate::simd::{BLOCK, Lanes, Pass, run};

/// Fitted curves of the points of a law, one column per parameter. `R` is the precision in which the formulas are
/// evaluated, `f64` or `f32`; interferences, values and slopes are `f64` with either.
///
/// Interferences outside `1e-150 u_ref` to `1e150 u_ref` (`1e-37` to `1e37` for `f32`) are taken as these.
/// Tractions and stiffnesses are held between `e^-700` and `e^700` (`e^-87` and `e^87` for `f32`) times `t_ref e^a` and
/// `k_ref e^a`. In `f32` they are right to about 2e-6 for usual fits; exponents rounded at their own size bring it to
/// 4e-5 where `t_n` is that far from `t_ref e^a`.
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
    type Workspace<const B: usize> = Workspace<R, B>;

    fn info(&self) -> Option<&'static CurvesInfo> {
        Some(&INFO)
    }

    fn len(&self) -> usize {
        self.n_points
    }

    fn evaluate<const B: usize>(
        &self,
        first: usize,
        u_n: &[f64],
        middle: &[f64],
        curvature: bool,
        workspace: &mut Workspace<R, B>,
        out: &mut CurveBlock<B>,
    ) {
        let start = if self.uniform { 0 } else { first };
        let at = start..start + u_n.len();
        macro_rules! formulas {
            ($curvature:literal, $isotropic:literal) => {
                run(Formulas::<R, $curvature, $isotropic, B> {
                    points: self,
                    at,
                    u_n,
                    middle,
                    workspace,
                    out,
                })
            };
        }
        match (curvature, self.isotropic) {
            (false, false) => formulas!(false, false),
            (false, true) => formulas!(false, true),
            (true, false) => formulas!(true, false),
            (true, true) => formulas!(true, true),
        }
    }
}

/// Both formulas at the points of a block, with or without second derivatives, with stiffnesses along x and y that
/// differ or not.
struct Formulas<'a, R, const CURVATURE: bool, const ISOTROPIC: bool, const B: usize> {
    points: &'a FittedPoints<R>,
    /// The block in the columns.
    at: Range<usize>,
    u_n: &'a [f64],
    middle: &'a [f64],
    workspace: &'a mut Workspace<R, B>,
    out: &'a mut CurveBlock<B>,
}

/// Numbers between the passes over a block. Of three arrays, the first belongs to the normal traction, the others to
/// the stiffnesses along x and y; of two, the first to the normal traction, the second to both stiffnesses.
#[derive(Debug)]
pub struct Workspace<R, const B: usize> {
    /// `U = u per_u_ref`, its reciprocal and its logarithm.
    ratio: [Lanes<R, B>; 2],
    per_ratio: [Lanes<f64, B>; 2],
    ln: [Lanes<R, B>; 2],
    /// `ln U` held within the fitted range.
    held: [Lanes<R, B>; 3],
    /// Arguments of exponentials, then their values: first those within the formulas, then the results over their
    /// scale.
    exponential: [Lanes<R, B>; 3],
    /// `y` of eq. (28) and `z` of eq. (29), then the log-slopes.
    inner: [Lanes<R, B>; 3],
    /// Changes of the log-slopes along x and y with `ln U`.
    slope_change: [Lanes<R, B>; 2],
}

impl<R: Real, const B: usize> Default for Workspace<R, B> {
    fn default() -> Self {
        let zero = Lanes([R::of(0.0); B]);
        Self {
            ratio: [zero; 2],
            per_ratio: [Lanes([0.0; B]); 2],
            ln: [zero; 2],
            held: [zero; 3],
            exponential: [zero; 3],
            inner: [zero; 3],
            slope_change: [zero; 2],
        }
    }
}

impl<R: Real, const CURVATURE: bool, const ISOTROPIC: bool, const B: usize> Pass
    for Formulas<'_, R, CURVATURE, ISOTROPIC, B>
{
    /// A few loops of about a hundred instructions: the processor overlaps several turns of such a loop, but not of a
    /// much longer one, and every loop has a beginning and an end.
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
        let (normal, [x, y]) = (&points.normal, &points.tangential);
        arguments::<R, FMA, B>(u_n, middle, per_u_ref, workspace);
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
        let (held_n, held_x, held_y) = if points.ranged {
            beyond |= normal.range.hold(&at, u_n, ln_n, held_n);
            beyond |= x.range.hold(&at, u_n, ln_t, held_x);
            if !ISOTROPIC {
                beyond |= y.range.hold(&at, u_n, ln_t, held_y);
            }
            (&*held_n, &*held_x, &*held_y)
        } else {
            (&*ln_n, &*ln_t, &*ln_t)
        };
        let (for_n, for_x, for_y) = (normal.fit(&at, n), x.fit(&at, n), y.fit(&at, n));
        inner::<R, ISOTROPIC, B>(
            n, &for_n, &for_x, &for_y, held_n, held_x, held_y, y_n, z_x, z_y, e_n, e_x, e_y,
        );
        exponentials::<R, FMA, ISOTROPIC, B>(n, e_n, e_x, e_y);
        outer::<R, CURVATURE, ISOTROPIC, B>(
            n, &for_n, &for_x, &for_y, held_n, y_n, z_x, z_y, e_n, e_x, e_y, change_x, change_y,
        );
        if beyond {
            normal.continuation(&at, n, ratio_n, ln_n, y_n, e_n);
            x.continuation::<CURVATURE, B>(&at, n, ratio_t, per_ratio_t, ln_t, z_x, e_x, change_x);
            if !ISOTROPIC {
                y.continuation::<CURVATURE, B>(&at, n, ratio_t, per_ratio_t, ln_t, z_y, e_y, change_y);
            }
        }
        exponentials::<R, FMA, ISOTROPIC, B>(n, e_n, e_x, e_y);
        let CurveBlock {
            normal: t,
            normal_slope: slope_t,
            tangential: [k_x, k_y],
            tangential_slope: [slope_x, slope_y],
            tangential_curvature: [curvature_x, curvature_y],
        } = out;
        values::<R, ISOTROPIC, B>(
            per_u_ref,
            per_ratio_n,
            per_ratio_t,
            &for_n,
            &for_x,
            &for_y,
            e_n,
            e_x,
            e_y,
            y_n,
            z_x,
            z_y,
            t,
            slope_t,
            k_x,
            slope_x,
            k_y,
            slope_y,
        );
        if CURVATURE {
            curvatures(per_u_ref, per_ratio_t, k_x, z_x, change_x, curvature_x);
        }
        if ISOTROPIC {
            (*k_y, *slope_y, *curvature_y) = (*k_x, *slope_x, *curvature_x);
        } else if CURVATURE {
            curvatures(per_u_ref, per_ratio_t, k_y, z_y, change_y, curvature_y);
        }
    }
}

/// Interferences over their reference, with logarithm and reciprocal.
#[inline(always)]
fn arguments<R: Real, const FMA: bool, const B: usize>(
    u_n: &[f64],
    middle: &[f64],
    per_u_ref: &[f64],
    workspace: &mut Workspace<R, B>,
) {
    let n = u_n.len().min(B);
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

/// Columns of eq. (28) at a block.
struct NormalBlock<'a, R> {
    scale: &'a [f64],
    b: &'a [R],
    c: &'a [R],
    d: &'a [R],
    per_e: &'a [R],
}

/// Columns of eq. (29) at a block.
struct TangentialBlock<'a, R> {
    scale: &'a [f64],
    b: &'a [R],
    c: &'a [R],
    d: &'a [R],
}

/// `y` and the exponent of the bell of eq. (28), `z = d (ln U - c)` and `-2 |z|` of eq. (29).
#[inline(always)]
fn inner<R: Real, const ISOTROPIC: bool, const B: usize>(
    n: usize,
    normal: &NormalBlock<'_, R>,
    x: &TangentialBlock<'_, R>,
    y: &TangentialBlock<'_, R>,
    held_n: &Lanes<R, B>,
    held_x: &Lanes<R, B>,
    held_y: &Lanes<R, B>,
    y_n: &mut Lanes<R, B>,
    z_x: &mut Lanes<R, B>,
    z_y: &mut Lanes<R, B>,
    e_n: &mut Lanes<R, B>,
    e_x: &mut Lanes<R, B>,
    e_y: &mut Lanes<R, B>,
) {
    let n = n.min(B);
    let (d, per_e) = (&normal.d[..n], &normal.per_e[..n]);
    let (c_x, d_x, c_y, d_y) = (&x.c[..n], &x.d[..n], &y.c[..n], &y.d[..n]);
    for i in 0..n {
        let bell = (held_n.0[i] + d[i]) * per_e[i];
        y_n.0[i] = bell;
        e_n.0[i] = bell * bell * R::of(-0.5);
        let z = d_x[i] * (held_x.0[i] - c_x[i]);
        z_x.0[i] = z;
        e_x.0[i] = z.magnitude() * R::of(-2.0);
        if !ISOTROPIC {
            let z = d_y[i] * (held_y.0[i] - c_y[i]);
            z_y.0[i] = z;
            e_y.0[i] = z.magnitude() * R::of(-2.0);
        }
    }
}

/// `ln(t_n / scale)` in place of the bell and its log-slope in place of `y`; `ln(k / scale)` in place of `exp(-2 |z|)`
/// and its log-slope in place of `z`.
#[inline(always)]
fn outer<R: Real, const CURVATURE: bool, const ISOTROPIC: bool, const B: usize>(
    n: usize,
    normal: &NormalBlock<'_, R>,
    x: &TangentialBlock<'_, R>,
    y: &TangentialBlock<'_, R>,
    held_n: &Lanes<R, B>,
    y_n: &mut Lanes<R, B>,
    z_x: &mut Lanes<R, B>,
    z_y: &mut Lanes<R, B>,
    e_n: &mut Lanes<R, B>,
    e_x: &mut Lanes<R, B>,
    e_y: &mut Lanes<R, B>,
    change_x: &mut Lanes<R, B>,
    change_y: &mut Lanes<R, B>,
) {
    let n = n.min(B);
    let (b, c, per_e) = (&normal.b[..n], &normal.c[..n], &normal.per_e[..n]);
    let (b_x, d_x, b_y, d_y) = (&x.b[..n], &x.d[..n], &y.b[..n], &y.d[..n]);
    for i in 0..n {
        let bell = e_n.0[i] * c[i];
        e_n.0[i] = b[i] * held_n.0[i] + bell;
        y_n.0[i] = b[i] - bell * y_n.0[i] * per_e[i];
        let step = Step::new(b_x[i], d_x[i], z_x.0[i], e_x.0[i]);
        (e_x.0[i], z_x.0[i]) = (step.value, step.slope);
        if CURVATURE {
            change_x.0[i] = step.slope_change;
        }
        if !ISOTROPIC {
            let step = Step::new(b_y[i], d_y[i], z_y.0[i], e_y.0[i]);
            (e_y.0[i], z_y.0[i]) = (step.value, step.slope);
            if CURVATURE {
                change_y.0[i] = step.slope_change;
            }
        }
    }
}

/// `b tanh(z)` with its derivative with respect to `ln U` and that one's.
struct Step<R> {
    value: R,
    slope: R,
    slope_change: R,
}

impl<R: Real> Step<R> {
    /// From `decay = exp(-2 |z|)`.
    #[inline(always)]
    fn new(b: R, d: R, z: R, decay: R) -> Self {
        let one = R::of(1.0);
        let per_sum = one / (one + decay);
        let step = ((one - decay) * per_sum).with_sign(z);
        let slope = b * d * (R::of(4.0) * decay * per_sum * per_sum);
        Self {
            value: b * step,
            slope,
            slope_change: R::of(-2.0) * d * step * slope,
        }
    }
}

/// Exponentials in place.
#[inline(always)]
fn exponentials<R: Real, const FMA: bool, const ISOTROPIC: bool, const B: usize>(
    n: usize,
    e_n: &mut Lanes<R, B>,
    e_x: &mut Lanes<R, B>,
    e_y: &mut Lanes<R, B>,
) {
    let most = R::of(R::LARGEST_EXPONENT);
    for i in 0..n.min(B) {
        e_n.0[i] = min(e_n.0[i], most).natural_exp::<FMA>();
        e_x.0[i] = min(e_x.0[i], most).natural_exp::<FMA>();
        if !ISOTROPIC {
            e_y.0[i] = min(e_y.0[i], most).natural_exp::<FMA>();
        }
    }
}

/// Values and slopes from values over the scale and log-slopes.
#[inline(always)]
fn values<R: Real, const ISOTROPIC: bool, const B: usize>(
    per_u_ref: &[f64],
    per_ratio_n: &Lanes<f64, B>,
    per_ratio_t: &Lanes<f64, B>,
    normal: &NormalBlock<'_, R>,
    x: &TangentialBlock<'_, R>,
    y: &TangentialBlock<'_, R>,
    e_n: &Lanes<R, B>,
    e_x: &Lanes<R, B>,
    e_y: &Lanes<R, B>,
    log_slope_n: &Lanes<R, B>,
    log_slope_x: &Lanes<R, B>,
    log_slope_y: &Lanes<R, B>,
    t_n: &mut Lanes<f64, B>,
    slope_n: &mut Lanes<f64, B>,
    k_x: &mut Lanes<f64, B>,
    slope_x: &mut Lanes<f64, B>,
    k_y: &mut Lanes<f64, B>,
    slope_y: &mut Lanes<f64, B>,
) {
    let n = per_u_ref.len().min(B);
    let (per_u_ref, scale_n, scale_x, scale_y) = (&per_u_ref[..n], &normal.scale[..n], &x.scale[..n], &y.scale[..n]);
    for i in 0..n {
        let value = bounded(scale_n[i] * e_n.0[i].double());
        t_n.0[i] = value;
        slope_n.0[i] = value * bounded(per_ratio_n.0[i] * per_u_ref[i]) * log_slope_n.0[i].double();
        let per_u = bounded(per_ratio_t.0[i] * per_u_ref[i]);
        let value = bounded(scale_x[i] * e_x.0[i].double());
        k_x.0[i] = value;
        slope_x.0[i] = value * per_u * log_slope_x.0[i].double();
        if !ISOTROPIC {
            let value = bounded(scale_y[i] * e_y.0[i].double());
            k_y.0[i] = value;
            slope_y.0[i] = value * per_u * log_slope_y.0[i].double();
        }
    }
}

impl<R: Real> RangeColumns<R> {
    /// Holds `ln U` within the range; true when a closed point lies beyond.
    #[inline(always)]
    fn hold<const B: usize>(&self, at: &Range<usize>, u_n: &[f64], ln: &Lanes<R, B>, held: &mut Lanes<R, B>) -> bool {
        let n = u_n.len().min(B);
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
    #[inline(always)]
    fn fit(&self, at: &Range<usize>, n: usize) -> NormalBlock<'_, R> {
        NormalBlock {
            scale: &self.scale[at.clone()][..n],
            b: &self.b[at.clone()][..n],
            c: &self.c[at.clone()][..n],
            d: &self.d[at.clone()][..n],
            per_e: &self.per_e[at.clone()][..n],
        }
    }

    /// Beyond the range: the log-slope moves to 3/2 below and stays above.
    #[inline(always)]
    fn continuation<const B: usize>(
        &self,
        at: &Range<usize>,
        n: usize,
        ratio: &Lanes<R, B>,
        ln: &Lanes<R, B>,
        log_slope: &mut Lanes<R, B>,
        value: &mut Lanes<R, B>,
    ) {
        let n = n.min(B);
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
    #[inline(always)]
    fn fit(&self, at: &Range<usize>, n: usize) -> TangentialBlock<'_, R> {
        TangentialBlock {
            scale: &self.scale[at.clone()][..n],
            b: &self.b[at.clone()][..n],
            c: &self.c[at.clone()][..n],
            d: &self.d[at.clone()][..n],
        }
    }

    /// Beyond the range: the log-slope moves to the lower exponent below, and stays or moves to zero above.
    #[inline(always)]
    fn continuation<const CURVATURE: bool, const B: usize>(
        &self,
        at: &Range<usize>,
        n: usize,
        ratio: &Lanes<R, B>,
        per_ratio: &Lanes<f64, B>,
        ln: &Lanes<R, B>,
        log_slope: &mut Lanes<R, B>,
        value: &mut Lanes<R, B>,
        slope_change: &mut Lanes<R, B>,
    ) {
        let n = n.min(B);
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

/// Second derivatives from values, log-slopes and their changes.
#[inline(always)]
fn curvatures<R: Real, const B: usize>(
    per_u_ref: &[f64],
    per_ratio: &Lanes<f64, B>,
    value: &Lanes<f64, B>,
    log_slope: &Lanes<R, B>,
    slope_change: &Lanes<R, B>,
    curvature: &mut Lanes<f64, B>,
) {
    let n = per_u_ref.len().min(B);
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
