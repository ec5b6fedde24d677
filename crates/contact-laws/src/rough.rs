//! Rough contact by fitted curves: with `U = u_n / u_ref` and natural logarithms,
//!
//! - eq. (28): `ln(t_n / t_ref) = a + b ln U + c exp(-((ln U + d)/e)^2 / 2)`,
//! - eq. (29): `ln(k_t / k_ref) = a + b tanh(d (ln U - c))`, for x and y separately.
//!
//! Outside the fitted range the formulas are not extrapolated; the curves go on C1. Below, the log-slope of the normal
//! traction moves to 3/2 (Hertz) as `u_n -> 0`; above, it keeps its end value. The tangential stiffness follows its
//! [`TangentialEnds`].

use crate::continuation::End;
use crate::curves::{ContactCurves, CurvesInfo, Exponents, Jet};
use crate::error::{Error, Place, require, require_positive};
use crate::friction::{FrictionalLaw, PAPER_DOI};
use crate::law::Quantity;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::rough_points::FittedPoints;

/// Rough contact by fitted curves with friction, evaluated in vector registers.
pub type RoughLaw = FrictionalLaw<FittedPoints>;

pub(crate) static INFO: CurvesInfo = CurvesInfo {
    name: "rough contact, fitted curves",
    reference: PAPER_DOI,
    parameters: &[
        Quantity::new("normal a", "ln Pa"),
        Quantity::new("normal b", "1"),
        Quantity::new("normal c", "1"),
        Quantity::new("normal d", "1"),
        Quantity::new("normal e", "1"),
        Quantity::new("tangential a", "ln Pa/m"),
        Quantity::new("tangential b", "1"),
        Quantity::new("tangential c", "1"),
        Quantity::new("tangential d", "1"),
        Quantity::new("u_ref", "m"),
    ],
};

/// Largest magnitude of the parameters without unit: far beyond any fit, and products of them stay exact enough.
const LARGEST: f64 = 1e6;

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

/// How a fitted tangential stiffness goes on outside its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum TangentialEnds {
    /// Log-slope towards 1/2 below, kept above: for fits to Mindlin stiffnesses.
    Mindlin,
    /// Towards constants on both sides: for fits to the published, bounded stiffness.
    Constant,
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
        for (name, v) in [
            ("normal a", self.a),
            ("normal b", self.b),
            ("normal c", self.c),
            ("normal d", self.d),
        ] {
            require(
                v.abs() <= LARGEST,
                name,
                v,
                "(no unit)",
                Place::Whole,
                "between -1e6 and 1e6",
            )?;
        }
        let ok = (1.0 / LARGEST..=LARGEST).contains(&self.e);
        require(
            ok,
            "normal e",
            self.e,
            "(no unit)",
            Place::Whole,
            "between 1e-6 and 1e6",
        )?;
        validate_reference("normal u_ref", self.u_ref)?;
        require_positive("normal t_ref", self.t_ref, "Pa")?;
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
            let ok = value.is_finite() && value > 0.0;
            require(
                ok,
                "normal traction of eq. (28) at the ends of its range or at u_ref",
                value,
                "Pa",
                Place::Whole,
                "finite and above zero",
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
        for (name, v) in [("tangential a", self.a), ("tangential c", self.c)] {
            require(
                v.abs() <= LARGEST,
                name,
                v,
                "(no unit)",
                Place::Whole,
                "between -1e6 and 1e6",
            )?;
        }
        for (name, v) in [("tangential b", self.b), ("tangential d", self.d)] {
            let ok = (0.0..=LARGEST).contains(&v);
            require(ok, name, v, "(no unit)", Place::Whole, "between 0 and 1e6")?;
        }
        validate_reference("tangential u_ref", self.u_ref)?;
        require_positive("tangential k_ref", self.k_ref, "Pa/m")?;
        validate_range("tangential range", self.range)?;
        for value in [self.a - self.b, self.a + self.b].map(|ln_k| self.k_ref * ln_k.exp()) {
            let ok = value.is_finite() && value > 0.0;
            require(
                ok,
                "tangential stiffness of eq. (29)",
                value,
                "Pa/m",
                Place::Whole,
                "finite and above zero",
            )?;
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

fn validate_reference(name: &'static str, u_ref: f64) -> Result<(), Error> {
    let ok = (1e-150..=1e150).contains(&u_ref);
    require(ok, name, u_ref, "m", Place::Whole, "between 1e-150 and 1e150")
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
