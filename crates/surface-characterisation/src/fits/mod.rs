//! Fits of eq. (28) and (29) to traction curves, by variable projection and a robust polish.

mod polish;
mod samples;

use contact_laws::{NormalFit, TangentialEnds, TangentialFit};

use self::polish::{Bounds, FREE, polish};
use self::samples::Samples;
use crate::error::SurfaceError;

/// Log-slope of eq. (28) at `x = ln U` for parameters `[a, b, c, d, e]`.
fn normal_slope(p: &[f64; 5], x: f64) -> f64 {
    p[1] - p[2] * (x + p[3]) / (p[4] * p[4]) * gauss(p, x)
}

fn normal_value(p: &[f64; 5], x: f64) -> f64 {
    p[0] + p[1] * x + p[2] * gauss(p, x)
}

fn gauss(p: &[f64; 5], x: f64) -> f64 {
    (-0.5 * ((x + p[3]) / p[4]).powi(2)).exp()
}

/// Whether eq. (28) rises strictly over `[low, high]` in ln U. The slope is extreme at the ends of the range and one
/// width to either side of the Gaussian's centre.
fn rises(p: &[f64; 5], [low, high]: [f64; 2]) -> bool {
    [low, high, -p[3] - p[4], -p[3] + p[4]]
        .into_iter()
        .all(|x| x < low || x > high || normal_slope(p, x) > LEAST_SLOPE)
}

/// Why a fit is not the full form over the given samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
pub enum FitFallback {
    /// No strictly rising form of eq. (28) was found: the best power law (c = 0) is given.
    PowerLaw,
    /// No form of eq. (29) stays within the range of numbers: the mean of the logarithms is given.
    Constant,
    /// The element has too few peaks: all asperities at one height, `t_n ~ u^(3/2)`.
    SingleAsperity,
}

/// A fit and what is known of its quality.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FitReport<P> {
    /// The fitted parameters, with the range of the non-zero samples.
    pub parameters: P,
    /// Root mean square residual of the logarithms.
    pub rms: f64,
    /// Largest absolute residual of the logarithms.
    pub max_residual: f64,
    /// Samples used.
    pub samples: usize,
    /// Samples left out because they are zero, which has no logarithm.
    pub zero_samples: usize,
    /// Set when the result is a declared fallback.
    pub fallback: Option<FitFallback>,
}

/// Fit of eq. (28).
pub type NormalFitReport = FitReport<NormalFit>;
/// Fit of eq. (29).
pub type TangentialFitReport = FitReport<TangentialFit>;

const B_BOUNDS: [f64; 2] = [0.5, 8.0];
const E_BOUNDS: [f64; 2] = [0.15, 5.0];
/// Steepness of eq. (29). At the lower bound the form is a power law over any practical range; at the upper, a step.
const D_BOUNDS: [f64; 2] = [0.02, 20.0];
/// Least log-log slope that counts as rising.
const LEAST_SLOPE: f64 = 1e-6;
/// Least b of eq. (29): keeps it positive on constant curves.
const LEAST_STEP: f64 = 1e-9;
/// Largest logarithm of a stiffness that is a number with room to spare.
const LARGEST_LN: f64 = 700.0;
/// Starts that are polished.
const STARTS: usize = 4;
const NORMAL_BOUNDS: [Bounds; 5] = [FREE, B_BOUNDS, FREE, FREE, E_BOUNDS];
const TANGENTIAL_BOUNDS: [Bounds; 4] = [FREE, [LEAST_STEP, f64::INFINITY], FREE, D_BOUNDS];

/// Fits eq. (28) to normal tractions `traction` (Pa) at interferences `interference` (m, > 0).
///
/// For fixed d and e the form is linear in a, b and c: a grid over (d, e) is solved exactly, its best local minima are
/// polished by Levenberg-Marquardt with a pseudo-Huber loss, and the strictly rising result with the least rms is
/// taken. Where none rises over the fitted range, the best power law is returned and declared.
///
/// # Errors
/// Arrays of different length, samples that are not finite, interferences that are not positive, negative tractions,
/// a reference that is not positive, or fewer than 8 non-zero samples at different interferences.
pub fn fit_normal(interference: &[f64], traction: &[f64], u_ref: f64) -> Result<NormalFitReport, SurfaceError> {
    let samples = Samples::try_new("normal traction", "Pa", interference, traction, u_ref)?;
    let [low, high] = samples.bounds();
    let span = high - low;
    let centres = grid(low - 0.5 * span, high + 0.5 * span, 33);
    let widths = log_grid(E_BOUNDS, 15);
    let candidates = grid_minima(centres.len(), widths.len(), |i, k| {
        let (m, e) = (centres[i], widths[k]);
        let (linear, rss) = samples.project(|x| (-0.5 * ((x - m) / e).powi(2)).exp(), B_BOUNDS)?;
        Some(([linear[0], linear[1], linear[2], -m, e], rss))
    });

    let mut best: Option<([f64; 5], f64)> = None;
    for start in candidates {
        let polished = polish(&samples, start, &NORMAL_BOUNDS, |p, x, gradient| {
            let s = (x + p[3]) / p[4];
            let g = (-0.5 * s * s).exp();
            *gradient = [1.0, x, g, -p[2] * g * s / p[4], p[2] * g * s * s / p[4]];
            p[0] + p[1] * x + p[2] * g
        });
        for p in [start, polished] {
            let rss = samples.rss(|x| normal_value(&p, x));
            if rss.is_finite() && rises(&p, [low, high]) && best.is_none_or(|(_, least)| rss < least) {
                best = Some((p, rss));
            }
        }
    }
    let (p, fallback) = match best {
        Some((p, _)) => (p, None),
        None => {
            let [a, b] = samples.power_law(B_BOUNDS);
            ([a, b, 0.0, 0.0, 1.0], Some(FitFallback::PowerLaw))
        }
    };
    let [a, b, c, d, e] = p;
    let parameters = NormalFit {
        a: a + samples.offset,
        b,
        c,
        d,
        e,
        u_ref,
        t_ref: 1.0,
        range: Some(samples.range),
    };
    Ok(report(&samples, |x| normal_value(&p, x), parameters, fallback))
}

/// Fits eq. (29) to tangential traction stiffnesses `stiffness` (Pa/m) at interferences `interference` (m, > 0).
///
/// Variable projection as in [`fit_normal`]: linear in a and b for fixed c and d. The form rises by construction
/// (b, d > 0). It is bounded, so it follows a power law such as Mindlin's only over a part of its range: judge it by
/// its rms. `ends` says how the law goes on outside the samples.
///
/// # Errors
/// As [`fit_normal`].
pub fn fit_tangential(
    interference: &[f64],
    stiffness: &[f64],
    u_ref: f64,
    ends: TangentialEnds,
) -> Result<TangentialFitReport, SurfaceError> {
    let samples = Samples::try_new("tangential stiffness", "Pa/m", interference, stiffness, u_ref)?;
    let [low, high] = samples.bounds();
    let span = high - low;
    let value = |p: &[f64; 4], x: f64| p[0] + p[1] * (p[3] * (x - p[2])).tanh();

    let centres = grid(low - span, high + span, 33);
    let steepness = log_grid(D_BOUNDS, 21);
    let candidates = grid_minima(centres.len(), steepness.len(), |i, k| {
        let (c, d) = (centres[i], steepness[k]);
        let (linear, rss) = samples.project_step(|x| (d * (x - c)).tanh(), LEAST_STEP)?;
        Some(([linear[0], linear[1], c, d], rss))
    });
    let mut best: Option<([f64; 4], f64)> = None;
    for start in candidates {
        let polished = polish(&samples, start, &TANGENTIAL_BOUNDS, |p, x, gradient| {
            let h = (p[3] * (x - p[2])).tanh();
            let slope = p[1] * (1.0 - h * h);
            *gradient = [1.0, h, -slope * p[3], slope * (x - p[2])];
            p[0] + p[1] * h
        });
        for p in [start, polished] {
            let rss = samples.rss(|x| value(&p, x));
            // Both plateaus of the form must be numbers, however far from the samples.
            let in_range = (p[0] + samples.offset).abs() + p[1] < LARGEST_LN;
            if in_range && rss.is_finite() && best.is_none_or(|(_, least)| rss < least) {
                best = Some((p, rss));
            }
        }
    }
    let (p, fallback) = match best {
        Some((p, _)) => (p, None),
        None => ([0.0, LEAST_STEP, 0.5 * (low + high), 1.0], Some(FitFallback::Constant)),
    };
    let [a, b, c, d] = p;
    let parameters = TangentialFit {
        a: a + samples.offset,
        b,
        c,
        d,
        u_ref,
        k_ref: 1.0,
        range: Some(samples.range),
        ends,
    };
    Ok(report(&samples, |x| value(&p, x), parameters, fallback))
}

/// The fit of `value`, and its residuals.
fn report<P>(
    samples: &Samples,
    value: impl Fn(f64) -> f64,
    parameters: P,
    fallback: Option<FitFallback>,
) -> FitReport<P> {
    let largest = samples
        .x
        .iter()
        .zip(&samples.y)
        .map(|(&x, y)| (value(x) - y).abs())
        .fold(0.0, f64::max);
    FitReport {
        parameters,
        rms: (samples.rss(&value) / samples.x.len() as f64).sqrt(),
        max_residual: largest,
        samples: samples.x.len(),
        zero_samples: samples.zero_samples,
        fallback,
    }
}

/// `n` values from `low` to `high`, both included.
fn grid(low: f64, high: f64, n: usize) -> Vec<f64> {
    (0..n).map(|k| low + (high - low) * k as f64 / (n - 1) as f64).collect()
}

/// `n` values from `low` to `high`, equidistant in their logarithm and not beyond the ends by rounding.
fn log_grid([low, high]: Bounds, n: usize) -> Vec<f64> {
    grid(low.ln(), high.ln(), n)
        .into_iter()
        .map(|x| x.exp().clamp(low, high))
        .collect()
}

/// The best few local minima of a residual over a grid; points without a solution are left out.
fn grid_minima<P: Copy>(ni: usize, nk: usize, solve: impl Fn(usize, usize) -> Option<(P, f64)>) -> Vec<P> {
    let all: Vec<Option<(P, f64)>> = (0..ni * nk).map(|n| solve(n / nk, n % nk)).collect();
    let rss = |i: usize, k: usize| all[i * nk + k].map_or(f64::INFINITY, |(_, r)| r);
    let mut minima = Vec::new();
    for i in 0..ni {
        for k in 0..nk {
            if let Some((p, r)) = all[i * nk + k] {
                let least = (i == 0 || r <= rss(i - 1, k))
                    && (i + 1 == ni || r <= rss(i + 1, k))
                    && (k == 0 || r <= rss(i, k - 1))
                    && (k + 1 == nk || r <= rss(i, k + 1));
                if least {
                    minima.push((p, r));
                }
            }
        }
    }
    minima.sort_by(|a, b| a.1.total_cmp(&b.1));
    minima.truncate(STARTS);
    minima.into_iter().map(|(p, _)| p).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn known_normal_parameters_are_recovered() {
        let u = log_grid([0.1e-6, 20e-6], 64);
        for (b, c, d, e) in [
            (2.1, -0.8, -0.5, 0.9),
            (1.6, 0.4, 0.6, 0.5),
            (3.0, -2.0, 1.0, 1.5),
            (2.5, -0.7, -1.2, 0.4),
        ] {
            let truth = NormalFit {
                a: 13.0,
                b,
                c,
                d,
                e,
                u_ref: 1e-6,
                t_ref: 1.0,
                range: None,
            };
            let t: Vec<f64> = u
                .iter()
                .map(|u| normal_value(&[13.0, b, c, d, e], (u / 1e-6f64).ln()).exp())
                .collect();
            let fit = fit_normal(&u, &t, 1e-6).unwrap();
            let p = fit.parameters;
            for (got, want) in [(p.a, 13.0), (p.b, b), (p.c, c), (p.d, d), (p.e, e)] {
                assert!((got - want).abs() < 1e-6, "{p:?} against {truth:?}");
            }
            assert!(fit.rms < 1e-9 && fit.fallback.is_none());
            assert_eq!((fit.samples, fit.zero_samples), (64, 0));
        }
    }

    #[test]
    fn known_tangential_parameters_are_recovered() {
        let u = log_grid([0.1e-6, 20e-6], 64);
        for (b, c, d) in [(1.5, 0.3, 0.8), (0.4, -1.0, 3.0), (3.0, 1.5, 0.4)] {
            let truth = [28.0, b, c, d];
            let k: Vec<f64> = u
                .iter()
                .map(|u| (28.0 + b * (d * ((u / 1e-6f64).ln() - c)).tanh()).exp())
                .collect();
            let p = fit_tangential(&u, &k, 1e-6, TangentialEnds::Mindlin)
                .unwrap()
                .parameters;
            for (got, want) in [(p.a, 28.0), (p.b, b), (p.c, c), (p.d, d)] {
                assert!((got - want).abs() < 1e-6, "{p:?} against {truth:?}");
            }
        }
    }

    #[test]
    fn units_shift_a_and_leave_the_rest() {
        let u = log_grid([0.1e-6, 20e-6], 64);
        let t: Vec<f64> = u
            .iter()
            .map(|u| 1e12 * u.powf(1.7) * (1.0 + (u / 2e-6).powi(2)).sqrt())
            .collect();
        let si = fit_normal(&u, &t, 1e-6).unwrap();
        let (u_mm, t_mpa): (Vec<f64>, Vec<f64>) = (
            u.iter().map(|u| u * 1e3).collect(),
            t.iter().map(|t| t * 1e-6).collect(),
        );
        let mm = fit_normal(&u_mm, &t_mpa, 1e-3).unwrap();
        assert!((si.parameters.a - mm.parameters.a - 1e6f64.ln()).abs() < 1e-10);
        let all = |p: NormalFit| [p.a, p.b, p.c, p.d, p.e];
        for (k, (p, q)) in all(si.parameters).iter().zip(all(mm.parameters)).enumerate().skip(1) {
            assert!((p - q).abs() < 1e-10, "{k}: {p} {q}");
        }
        assert!((si.rms / mm.rms - 1.0).abs() < 1e-10);
    }

    #[test]
    fn a_power_law_and_a_constant_are_followed() {
        let u = log_grid([0.1e-6, 20e-6], 64);
        let t: Vec<f64> = u.iter().map(|u| 3e14 * u.powf(1.5)).collect();
        let fit = fit_normal(&u, &t, 1e-6).unwrap();
        assert!(fit.rms < 1e-9, "{fit:?}");
        let half: Vec<f64> = u.iter().map(|u| 3e14 * u.powf(0.5)).collect();
        let fit = fit_tangential(&u, &half, 1e-6, TangentialEnds::Mindlin).unwrap();
        assert!(fit.rms < 1e-3, "{fit:?}");
        let fit = fit_tangential(&u, &[5e12; 64], 1e-6, TangentialEnds::Mindlin).unwrap();
        assert!(fit.rms < 1e-6 && fit.parameters.b > 0.0, "{fit:?}");
    }

    #[test]
    fn a_falling_curve_ends_in_the_declared_power_law() {
        let u = log_grid([0.1e-6, 20e-6], 64);
        let t: Vec<f64> = u.iter().map(|u| 1e5 / (1.0 + u / 1e-6)).collect();
        let fit = fit_normal(&u, &t, 1e-6).unwrap();
        let p = fit.parameters;
        assert!(rises(&[p.a, p.b, p.c, p.d, p.e], [0.1f64.ln(), 20f64.ln()]), "{fit:?}");
        assert!(fit.parameters.b >= 0.5 && fit.rms > 0.5);
    }

    #[test]
    fn a_stiffness_beyond_the_range_of_numbers_is_a_declared_constant() {
        let u = log_grid([0.1e-6, 20e-6], 64);
        let k: Vec<f64> = u.iter().map(|u| (u / 1e-6).powi(60)).collect();
        let fit = fit_tangential(&u, &k, 1e-6, TangentialEnds::Mindlin).unwrap();
        let p = fit.parameters;
        assert!(p.a.abs() + p.b < 700.0 && p.b > 0.0);
        assert!(contact_laws::FittedCurves::try_new(fit_normal(&u, &u, 1e-6).unwrap().parameters, [p, p]).is_ok());
    }

    #[test]
    fn zeros_are_counted_and_bad_samples_named() {
        let u = log_grid([0.1e-6, 20e-6], 20);
        let mut t: Vec<f64> = u.iter().map(|u| 1e12 * u.powf(2.0)).collect();
        t[..5].fill(0.0);
        let fit = fit_normal(&u, &t, 1e-6).unwrap();
        assert_eq!((fit.samples, fit.zero_samples), (15, 5));
        assert!((fit.parameters.range.unwrap()[0] / u[5] - 1.0).abs() < 1e-14);
        assert!(matches!(
            fit_normal(&u, &t[1..], 1e-6),
            Err(SurfaceError::LengthMismatch { .. })
        ));
        assert!(matches!(
            fit_normal(&u, &t, 0.0),
            Err(SurfaceError::InvalidValue { field: "u_ref", .. })
        ));
        t[7] = -1.0;
        assert!(matches!(
            fit_normal(&u, &t, 1e-6),
            Err(SurfaceError::InvalidSample { index: 7, .. })
        ));
        assert!(matches!(
            fit_normal(&u, &[0.0; 20], 1e-6),
            Err(SurfaceError::TooFewSamples { found: 0, .. })
        ));
        assert!(matches!(
            fit_tangential(&[1e-6; 20], &[1.0; 20], 1e-6, TangentialEnds::Mindlin),
            Err(SurfaceError::TooFewSamples { found: 1, .. })
        ));
        assert!(fit_normal(&[-1.0; 20], &[1.0; 20], 1e-6).is_err());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        /// Sums of Hertzian contacts at random depths: the fit rises over its range and stays within bounds.
        #[test]
        fn fits_of_asperity_sums_rise(depths in prop::collection::vec(0.0f64..30.0, 4..60)) {
            let u = log_grid([0.1e-6, 20e-6], 64);
            let t: Vec<f64> = u.iter().map(|&u| {
                let hertz = |s: f64| (u / 1e-6 - s).max(0.0).powf(1.5);
                1e6 * (hertz(0.0) + depths.iter().map(|&s| hertz(s)).sum::<f64>())
            }).collect();
            let fit = fit_normal(&u, &t, 1e-6).unwrap();
            prop_assert!(fit.fallback.is_none(), "{fit:?}");
            let p = fit.parameters;
            let all = [p.a, p.b, p.c, p.d, p.e];
            let mut previous = f64::NEG_INFINITY;
            for u in &u {
                let y = normal_value(&all, (u / 1e-6).ln());
                prop_assert!(y > previous, "{fit:?}");
                previous = y;
            }
            // The contact laws accept every fit.
            let k: Vec<f64> = t.iter().map(|t| t.cbrt()).collect();
            let k = fit_tangential(&u, &k, 1e-6, TangentialEnds::Mindlin).unwrap().parameters;
            let accepted = contact_laws::FittedCurves::try_new(p, [k, k]);
            prop_assert!(accepted.is_ok(), "{accepted:?} {p:?} {k:?}");
            prop_assert!((0.5..=8.0).contains(&p.b) && (0.15..=5.0).contains(&p.e));
            prop_assert!(fit.rms < 0.3, "{fit:?}");
        }
    }
}
