//! Rough contact by fitted curves, eqs. (28) and (29).
//!
//! With `U = u_n/u_ref` and natural logarithms, the normal traction and the tangential stiffnesses along `q` in {x, y}
//! are
//! <div>
//! $$ \ln \frac{t_n}{t_\text{ref}} = a + b \ln U + c
//! \exp\left( -\frac{1}{2} \left( \frac{\ln U + d}{e} \right)^2 \right) \qquad (28) $$
//! </div>
//! <div>
//! $$ \ln \frac{k_q}{k_\text{ref}} = a_q + b_q \tanh\left( d_q \, (\ln U - c_q) \right) \qquad (29) $$
//! </div>
//!
//! The logarithms are those of ratios: `u_ref`, `t_ref` and `k_ref` belong to the fit and carry its units. A fit to
//! numbers in Pa and Pa/m, as published, has `t_ref` = 1 Pa and `k_ref` = 1 Pa/m; give the same quantities in other
//! units (in MPa 1e-6) and `a` stays what it is.
//!
//! # Outside the fitted range
//! The formulas are not extrapolated; the curves go on C1. At an end `u_e` of the range a curve has the value `f_e` and
//! the log-slope `g = d ln f / d ln u_n`. With `v = u_n/u_e`
//! <div>
//! $$ f = f_e \, v^{p} \, e^{(g - p)(v - 1)} \quad (v < 1), \qquad
//! f = f_e \, v^{g} \quad \text{or} \quad f = f_e \, e^{g (1 - 1/v)} \quad (v > 1) : $$
//! </div>
//!
//! | curve | below, log-slope towards `p` as `u_n -> 0` | above |
//! |---|---|---|
//! | normal traction | `p = 3/2`, as a Hertz contact | log-slope stays `g` |
//! | stiffness, [`TangentialEnds::Mindlin`] | `p = 1/2`, as a Mindlin contact | log-slope stays `g` |
//! | stiffness, [`TangentialEnds::Constant`] | `p = 0`, a constant | towards the constant `f_e exp(g)` |
//!
//! Without a range the formulas hold everywhere.
//!
//! # Parameters
//! | parameter | unit | bounds |
//! |---|---|---|
//! | normal `a, b, d` | 1 | magnitude up to 1e6; `t_n` must rise in the whole range |
//! | normal `c` | 1 | magnitude up to 1e100, since a fit may use the far tail of the third term |
//! | normal `e` | 1 | 1e-6 to 1e6 |
//! | tangential `a, c` (per direction) | 1 | magnitude up to 1e6 |
//! | tangential `b, d` (per direction) | 1 | 0 to 1e6 |
//! | `u_ref` (per fit) | m | 1e-150 to 1e150 |
//! | `t_ref`, `k_ref` | Pa, Pa/m | above 0 |
//! | `range` (per fit) | m | above 0, ascending, or none |
//! | friction coefficient `mu` | 1 | not negative |
//!
//! # Two ways to evaluate
//! - [`RoughLaw`](crate::RoughLaw), on [`FittedPoints`](crate::FittedPoints): the points of a block in vector
//!   registers, with elementary functions made of additions, multiplications and a division. `FittedPoints<f64>` is the
//!   default; `FittedPoints<f32>` evaluates the formulas in single precision, everything else in double.
//! - `FrictionalLaw<PointParameters<FittedCurves>>`: point by point with the elementary functions of the standard
//!   library (or of `libm`). It is the reference for the other.
//!
//! Values and slopes agree to 1e-13 relative in `f64` and to about 1e-6 in `f32`. Largest deviations found in 4000
//! random fits from `u_ref/100` to `100 u_ref`: 9e-15, and with `f32` 3e-6 of `t_n` and 6e-7 of `k_q`.
//!
//! Source: N. N. Balaji, W. Chen and M. R. W. Brake, *Traction-based multi-scale nonlinear dynamic modeling of bolted
//! joints: formulation, application, and trends in micro-scale interface evolution*, Mech. Syst. Signal Process. 139,
//! 2020, 106615. The continuation outside the range is this crate's own.
//!
//! # Example
//! Two points with fits of their own, evaluated in all three ways.
//! ```
//! use contact_laws::*;
//!
//! let range = Some([1e-7, 1e-5]);
//! let curves = |a| {
//!     let normal = NormalFit { a, b: 2.2, c: 0.4, d: 0.5, e: 1.2, u_ref: 1e-6, t_ref: 1.0, range };
//!     let tangential = TangentialFit {
//!         a: 28.0,
//!         b: 1.5,
//!         c: 0.3,
//!         d: 0.6,
//!         u_ref: 1e-6,
//!         k_ref: 1.0,
//!         range,
//!         ends: TangentialEnds::Mindlin,
//!     };
//!     FittedCurves::try_new(normal, [tangential; 2])
//! };
//! let curves = PointParameters::per_point(vec![curves(13.0)?, curves(13.5)?]);
//! let (mu, history) = (PointParameters::uniform(0.2, 2), HistoryRule::Incremental);
//! let double = RoughLaw::try_new(FittedPoints::new(&curves), mu.clone(), history)?;
//! let single = FrictionalLaw::try_new(FittedPoints::<f32>::new(&curves), mu.clone(), history)?;
//! let scalar = FrictionalLaw::try_new(curves, mu, history)?;
//!
//! // Within the range and beyond both ends, slightly sheared from rest.
//! for u_n in [2e-8, 2e-6, 3e-5] {
//!     let begin = [0.0, 0.0, 0.0, 0.0, u_n, u_n, 0.0, 0.0, 0.0, 0.0];
//!     let tractions = |law: &dyn TractionLaw| {
//!         let (mut end, [mut t_x, mut t_y, mut t_n]) = ([0.0; 10], [[0.0; 2]; 3]);
//!         law.evaluate(
//!             0..2,
//!             Sticking::Coulomb,
//!             Components::new(&[1e-10; 2], &[0.0; 2], &[u_n; 2]),
//!             StateView::new(&begin, 2, 0),
//!             StateViewMut::new(&mut end, 2, 0),
//!             ComponentsMut::new(&mut t_x, &mut t_y, &mut t_n),
//!             None,
//!             None,
//!         );
//!         [t_x[0], t_x[1], t_n[0], t_n[1]]
//!     };
//!     let (reference, double, single) = (tractions(&scalar), tractions(&double), tractions(&single));
//!     for i in 0..4 {
//!         assert!((double[i] / reference[i] - 1.0).abs() < 1e-13);
//!         assert!((single[i] / reference[i] - 1.0).abs() < 5e-6);
//!     }
//! }
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

use crate::choice::choices;
use crate::curves::continuation::End;
use crate::curves::{ContactCurves, CurveFactors, CurvesInfo, Exponents};
use crate::error::{Error, Place, require};
use crate::jet::Jet;
use crate::law::PAPER_DOI;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::{Bounds, Parameter, require_positive};

// Magnitudes far beyond any fit, for which products stay exact enough; of the third term a fit may use no more than the far tail.
const NORMAL_A: Parameter = Parameter::new("normal a", "1", Bounds::Within([-1e6, 1e6], "between -1e6 and 1e6"));
const NORMAL_C: Parameter = Parameter::new(
    "normal c",
    "1",
    Bounds::Within([-1e100, 1e100], "between -1e100 and 1e100"),
);
const NORMAL_E: Parameter = Parameter::new("normal e", "1", Bounds::Within([1e-6, 1e6], "between 1e-6 and 1e6"));
const TANGENTIAL_A: Parameter = NORMAL_A.named("tangential a");
const TANGENTIAL_B: Parameter = Parameter::new("tangential b", "1", Bounds::Within([0.0, 1e6], "between 0 and 1e6"));
const U_REF: Parameter = Parameter::new(
    "u_ref",
    "m",
    Bounds::Within([1e-150, 1e150], "between 1e-150 and 1e150"),
);
const T_REF: Parameter = Parameter::new("t_ref", "Pa", Bounds::Positive);
const K_REF: Parameter = Parameter::new("k_ref", "Pa/m", Bounds::Positive);

pub(crate) static INFO: CurvesInfo = CurvesInfo {
    name: "rough contact, fitted curves",
    reference: PAPER_DOI,
    page: "fitted.md",
    parameters: &[
        NORMAL_A,
        NORMAL_A.named("normal b"),
        NORMAL_C,
        NORMAL_A.named("normal d"),
        NORMAL_E,
        TANGENTIAL_A,
        TANGENTIAL_B,
        TANGENTIAL_A.named("tangential c"),
        TANGENTIAL_B.named("tangential d"),
        U_REF,
        T_REF,
        K_REF,
    ],
};

/// Parameters of eq. (28).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct NormalFit {
    /// `ln(t_n / t_ref)` at `u_ref` without the third term.
    pub a: f64,
    /// Log-slope away from the third term.
    pub b: f64,
    /// Height of the third term.
    pub c: f64,
    /// Negative centre of the third term in `ln U`.
    pub d: f64,
    /// Width of the third term in `ln U`, above zero.
    pub e: f64,
    /// Reference interference (m).
    pub u_ref: f64,
    /// Reference traction `t_ref` (Pa), 1 Pa in files that do not give it.
    #[cfg_attr(feature = "serde", serde(default = "one"))]
    pub t_ref: f64,
    /// Fitted range of `u_n` (m); the formula holds everywhere if absent.
    pub range: Option<[f64; 2]>,
}

/// Parameters of eq. (29) for one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct TangentialFit {
    /// `ln(k_t / k_ref)` at the middle of the step.
    pub a: f64,
    /// Half height of the step, not negative.
    pub b: f64,
    /// Place of the step in `ln U`.
    pub c: f64,
    /// Steepness, not negative.
    pub d: f64,
    /// Reference interference (m).
    pub u_ref: f64,
    /// Reference stiffness `k_ref` (Pa/m), 1 Pa/m in files that do not give it.
    #[cfg_attr(feature = "serde", serde(default = "one"))]
    pub k_ref: f64,
    /// Fitted range of `u_n` (m); the formula holds everywhere if absent.
    pub range: Option<[f64; 2]>,
    /// How the curve goes on outside the range.
    pub ends: TangentialEnds,
}

#[cfg(feature = "serde")]
fn one() -> f64 {
    1.0
}

choices! {
    /// How a fitted tangential stiffness goes on outside its range.
    pub enum TangentialEnds, "ENDS", "Fitted tangential stiffness outside its range" {
        Mindlin = "mindlin", 0, "Log-slope towards 1/2 below, kept above: for fits to Mindlin stiffnesses.";
        Constant = "constant", 1, "Towards constants on both sides: for fits to the published, bounded stiffness.";
    }
}

impl NormalFit {
    /// Eq. (28): value and log-slope.
    #[inline]
    fn formula(&self, u_n: f64) -> (f64, f64) {
        let ln_u = ln_ratio(u_n, self.u_ref);
        let y = (ln_u + self.d) / self.e;
        let bell = self.c * (-0.5 * y * y).exp();
        (
            self.t_ref * (self.a + self.b * ln_u + bell).exp(),
            self.b - bell * y / self.e,
        )
    }

    fn validate(&self) -> Result<(), Error> {
        NORMAL_A.check(self.a)?;
        NORMAL_A.named("normal b").check(self.b)?;
        NORMAL_A.named("normal d").check(self.d)?;
        NORMAL_C.check(self.c)?;
        NORMAL_E.check(self.e)?;
        U_REF.named("normal u_ref").check(self.u_ref)?;
        T_REF.named("normal t_ref").check(self.t_ref)?;
        validate_range("normal range", self.range)?;

        // The log-slope is extreme at y = -1 and y = 1, so it is least there or at the ends of the range.
        let [lower, upper] = match self.range {
            Some(range) => range.map(|u| (u / self.u_ref).ln()),
            None => [f64::NEG_INFINITY, f64::INFINITY],
        };
        let extremes = [-self.d - self.e, -self.d + self.e]
            .into_iter()
            .filter(|x| (lower..=upper).contains(x));
        let ends = [lower, upper].into_iter().filter(|x| x.is_finite());
        for x in extremes.chain(ends) {
            let interference = x.exp() * self.u_ref;
            let log_slope = self.formula(interference).1;
            if !(log_slope > 0.0) {
                return Err(Error::NotMonotone {
                    curve: "normal traction, eq. (28)",
                    interference,
                    log_slope,
                });
            }
        }
        if self.range.is_none() {
            require_positive("normal b", self.b, "(no unit)")?;
        }
        let ends = self.range.unwrap_or([self.u_ref; 2]).map(|u| self.formula(u).0);
        for value in ends.into_iter().chain([self.t_ref * self.a.exp()]) {
            require_positive(
                "normal traction of eq. (28) at the ends of its range or at u_ref",
                value,
                "Pa",
            )?;
        }
        Ok(())
    }
}

impl TangentialFit {
    /// `ln U`.
    #[inline]
    fn ln_ratio(&self, u_n: f64) -> f64 {
        ln_ratio(u_n, self.u_ref)
    }

    /// Eq. (29) at `u_n` and its `ln U`.
    #[inline]
    fn formula(&self, u_n: f64, ln_u: f64) -> Jet {
        // tanh and 1 - tanh^2 from one exponential that cannot overflow, the second without cancellation.
        let x = self.d * (ln_u - self.c);
        let decay = (-2.0 * x.abs()).exp();
        let per_sum = 1.0 / (1.0 + decay);
        let step = ((1.0 - decay) * per_sum).copysign(x);
        let log_slope = self.b * self.d * 4.0 * decay * per_sum * per_sum;
        Jet::from_log(
            u_n,
            self.k_ref * (self.a + self.b * step).exp(),
            log_slope,
            -2.0 * self.d * step * log_slope,
        )
    }

    fn validate(&self) -> Result<(), Error> {
        TANGENTIAL_A.check(self.a)?;
        TANGENTIAL_A.named("tangential c").check(self.c)?;
        TANGENTIAL_B.check(self.b)?;
        TANGENTIAL_B.named("tangential d").check(self.d)?;
        U_REF.named("tangential u_ref").check(self.u_ref)?;
        K_REF.named("tangential k_ref").check(self.k_ref)?;
        validate_range("tangential range", self.range)?;
        for value in [self.a - self.b, self.a + self.b].map(|ln_k| self.k_ref * ln_k.exp()) {
            require_positive("tangential stiffness of eq. (29)", value, "Pa/m")?;
        }
        Ok(())
    }
}

/// `ln(u_n / u_ref)`, of ratios so far out that nothing is left of a contact or of its linear theory that of 1e-150 or
/// 1e150.
#[inline]
fn ln_ratio(u_n: f64, u_ref: f64) -> f64 {
    (u_n / u_ref).clamp(1e-150, 1e150).ln()
}

fn validate_range(name: &'static str, range: Option<[f64; 2]>) -> Result<(), Error> {
    let Some([lower, upper]) = range else {
        return Ok(());
    };
    require_positive(name, lower, "m")?;
    let ok = upper.is_finite() && upper > lower;
    require(
        ok,
        name,
        upper,
        "m (upper end)",
        Place::Whole,
        "finite and above the lower end",
    )
}

/// The curves of one point or element by eqs. (28) and (29).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedCurves {
    normal: NormalFit,
    tangential: [TangentialFit; 2],
    normal_ends: Option<[End; 2]>,
    tangential_ends: [Option<[End; 2]>; 2],
}

impl FittedCurves {
    /// From the normal fit and the tangential fits along x and y.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a parameter is not finite or outside its bounds, [`Error::NotMonotone`] when eq. (28)
    /// falls somewhere in its range.
    pub fn try_new(normal: NormalFit, tangential: [TangentialFit; 2]) -> Result<Self, Error> {
        normal.validate()?;
        let normal_ends = normal.range.map(|range| {
            range.map(|u| {
                let (value, log_slope) = normal.formula(u);
                End { u, value, log_slope }
            })
        });
        let mut tangential_ends = [None; 2];
        for (fit, ends) in tangential.iter().zip(&mut tangential_ends) {
            fit.validate()?;
            *ends = fit.range.map(|range| {
                range.map(|u| {
                    let k = fit.formula(u, fit.ln_ratio(u));
                    End::new(u, k.value, k.slope)
                })
            });
        }
        Ok(Self {
            normal,
            tangential,
            normal_ends,
            tangential_ends,
        })
    }

    /// These curves with interferences and values multiplied by factors: `t_n(u_n) = f_n t_n0(u_n / f_u)`, and so on.
    ///
    /// # Errors
    /// [`Error::Parameter`] for factors that are not positive and finite, or that lead out of the bounds of the references.
    pub fn scaled(&self, factors: CurveFactors) -> Result<Self, Error> {
        factors.validate()?;
        let by = |range: Option<[f64; 2]>| range.map(|range| range.map(|u| u * factors.interference));
        let normal = NormalFit {
            u_ref: self.normal.u_ref * factors.interference,
            t_ref: self.normal.t_ref * factors.normal,
            range: by(self.normal.range),
            ..self.normal
        };
        let tangential = core::array::from_fn(|q| TangentialFit {
            u_ref: self.tangential[q].u_ref * factors.interference,
            k_ref: self.tangential[q].k_ref * factors.tangential[q],
            range: by(self.tangential[q].range),
            ..self.tangential[q]
        });
        Self::try_new(normal, tangential)
    }

    /// The normal fit.
    pub fn normal_fit(&self) -> &NormalFit {
        &self.normal
    }

    /// The tangential fits along x and y.
    pub fn tangential_fits(&self) -> &[TangentialFit; 2] {
        &self.tangential
    }
}

impl ContactCurves for FittedCurves {
    fn info(&self) -> &'static CurvesInfo {
        &INFO
    }

    #[inline]
    fn normal(&self, u_n: f64) -> (f64, f64) {
        if let Some([lower, upper]) = &self.normal_ends {
            if u_n < lower.u {
                let t = lower.below(u_n, 1.5);
                return (t.value, t.slope);
            }
            if u_n > upper.u {
                let t = upper.above(u_n);
                return (t.value, t.slope);
            }
        }
        let (value, log_slope) = self.normal.formula(u_n);
        (value, value / u_n * log_slope)
    }

    #[inline]
    fn tangential(&self, u_n: f64) -> [Jet; 2] {
        let [x, y] = &self.tangential;
        let ln_x = x.ln_ratio(u_n);
        let ln_ratios = [ln_x, if x.u_ref == y.u_ref { ln_x } else { y.ln_ratio(u_n) }];
        core::array::from_fn(|q| {
            let fit = &self.tangential[q];
            if let Some([lower, upper]) = &self.tangential_ends[q] {
                if u_n < lower.u {
                    return lower.below(u_n, self.tangential_exponent(q));
                }
                if u_n > upper.u {
                    return match fit.ends {
                        TangentialEnds::Mindlin => upper.above(u_n),
                        TangentialEnds::Constant => upper.above_to_constant(u_n),
                    };
                }
            }
            fit.formula(u_n, ln_ratios[q])
        })
    }

    fn exponents(&self) -> Exponents {
        Exponents {
            normal: if self.normal.range.is_some() {
                1.5
            } else {
                self.normal.b
            },
            tangential: [self.tangential_exponent(0), self.tangential_exponent(1)],
        }
    }
}

impl FittedCurves {
    /// Log-slope of the tangential stiffness towards zero interference.
    #[inline]
    fn tangential_exponent(&self, q: usize) -> f64 {
        match (self.tangential[q].range, self.tangential[q].ends) {
            (Some(_), TangentialEnds::Mindlin) => 0.5,
            _ => 0.0,
        }
    }
}
