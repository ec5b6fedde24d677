//! Distributions of asperity heights and their partial moments in closed form.

use core::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use crate::error::Error;
use crate::jet::Jet;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::{Bounds, Parameter};

pub(crate) const SCALE: Parameter = Parameter::new("scale of the heights", "m", Bounds::Positive);

/// Distribution of the asperity heights.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub enum HeightDistribution {
    /// Density `exp(-z/scale)/scale` for `z >= 0`.
    Exponential {
        /// Scale, which is both mean and standard deviation (m).
        scale: f64,
    },
    /// Normal distribution about `z = 0`.
    Gaussian {
        /// Standard deviation (m).
        standard_deviation: f64,
    },
}

/// Partial moments of heights in units of their scale, as functions of `-h`.
pub(crate) struct HalfMoments {
    pub(crate) three_halves: f64,
    pub(crate) half: Jet,
}

impl HeightDistribution {
    pub(crate) fn scale(&self) -> f64 {
        match *self {
            Self::Exponential { scale } => scale,
            Self::Gaussian { standard_deviation } => standard_deviation,
        }
    }

    pub(crate) fn validate(&self) -> Result<(), Error> {
        match *self {
            Self::Exponential { scale } => SCALE.check(scale),
            Self::Gaussian { standard_deviation } => SCALE
                .named("standard_deviation of the heights")
                .check(standard_deviation),
        }
    }

    /// `M_{3/2}`, and `M_{1/2}` with its derivatives with respect to `-h`.
    #[inline]
    pub(crate) fn half_moments(&self, h: f64) -> HalfMoments {
        match self {
            Self::Exponential { .. } => exponential_half_moments(h),
            Self::Gaussian { .. } => gaussian_half_moments(h),
        }
    }

    /// `M_0` with its derivatives with respect to `-h`.
    pub(crate) fn loaded_fraction(&self, h: f64) -> Jet {
        match self {
            Self::Exponential { .. } if h >= 0.0 => {
                let e = (-h).exp();
                Jet {
                    value: e,
                    slope: e,
                    curvature: e,
                }
            }
            Self::Exponential { .. } => Jet {
                value: 1.0,
                slope: 0.0,
                curvature: 0.0,
            },
            Self::Gaussian { .. } => {
                let upper = 0.5 * (-0.5 * h * h).exp() * ScaledErfc::at(h.abs() * FRAC_1_SQRT_2).value;
                let density = gaussian_density(h);
                Jet {
                    value: if h < 0.0 { 1.0 - upper } else { upper },
                    slope: density,
                    curvature: h * density,
                }
            }
        }
    }

    /// `M_1`.
    pub(crate) fn first_moment(&self, h: f64) -> f64 {
        match self {
            Self::Exponential { .. } if h >= 0.0 => (-h).exp(),
            Self::Exponential { .. } => 1.0 - h,
            // F_1(-h) = F_1(h) + h.
            Self::Gaussian { .. } => {
                gaussian_density(h) * ScaledErfc::at(h.abs() * FRAC_1_SQRT_2).remainder + (-h).max(0.0)
            }
        }
    }
}

fn gaussian_density(h: f64) -> f64 {
    (-0.5 * h * h).exp() / TAU.sqrt()
}

fn exponential_half_moments(h: f64) -> HalfMoments {
    let root_pi = PI.sqrt();
    if h >= 0.0 {
        let half = 0.5 * root_pi * (-h).exp();
        return HalfMoments {
            three_halves: 1.5 * half,
            half: Jet {
                value: half,
                slope: half,
                curvature: half,
            },
        };
    }
    // With c = -h and G_n = e^c Gamma(n + 1, c): G_{-1/2} = sqrt(pi) e^c erfc(sqrt c), G_n = c^n + n G_{n-1}.
    let c = -h;
    let root = c.sqrt();
    let erfc = ScaledErfc::at(root);
    let minus_half = root_pi * erfc.value;
    let half = root + 0.5 * minus_half;
    HalfMoments {
        three_halves: c * root + 1.5 * half,
        half: Jet {
            value: half,
            slope: 0.5 * minus_half,
            // (G_{-1/2} - c^(-1/2))/2.
            curvature: -0.5 * erfc.remainder / root,
        },
    }
}

/// Below this `h` the heights cut off by it (1e-32 of all) are left out.
const FAR_BELOW: f64 = -12.0;

fn gaussian_half_moments(h: f64) -> HalfMoments {
    if h < FAR_BELOW {
        let c = -h;
        let root = c.sqrt();
        // Factors p (p - 1) ... of the derivatives of (t + c)^p.
        return HalfMoments {
            three_halves: c * root * far_series(1.5, c),
            half: Jet {
                value: root * far_series(0.5, c),
                slope: 0.5 / root * far_series(-0.5, c),
                curvature: -0.25 / (c * root) * far_series(-1.5, c),
            },
        };
    }
    // With t - h = v^2, F_n = integral over all real v of v^(2n + 1) exp(-(v^2 + h)^2/2)/sqrt(2 pi): even and entire
    // for n = -1/2, 1/2, 3/2, so that the trapezoidal rule converges faster than any power; every term is positive.
    const N_NODES: u32 = 48;
    // Exponent at the last node, relative to the largest.
    const LAST: f64 = 42.0;
    let end = if h > 0.0 {
        2.0 * LAST / (h + (h * h + 2.0 * LAST).sqrt())
    } else {
        (2.0 * LAST).sqrt() - h
    };
    let step = end.sqrt() / f64::from(N_NODES);
    let outside = h.min(0.0);
    let mut sums = [0.5 * (-0.5 * outside * outside).exp(), 0.0, 0.0];
    for k in 1..=N_NODES {
        let v = f64::from(k) * step;
        let vv = v * v;
        // For h > 0 without exp(-h^2/2), which would underflow first.
        let exponent = if h > 0.0 {
            vv * (h + 0.5 * vv)
        } else {
            0.5 * (vv + h) * (vv + h)
        };
        let weight = (-exponent).exp();
        sums[0] += weight;
        sums[1] += weight * vv;
        sums[2] += weight * vv * vv;
    }
    let factor = 2.0 * step * gaussian_density(h.max(0.0));
    let [minus_half, half, three_halves] = sums.map(|sum| factor * sum);
    HalfMoments {
        three_halves,
        half: Jet {
            value: half,
            slope: 0.5 * minus_half,
            // The derivative of F_{-1/2} is -(h F_{-1/2} + F_{1/2}), by parts.
            curvature: 0.5 * (h * minus_half + half),
        },
    }
}

/// `E[(1 + T/c)^p]` for a standard normal `T` and large `c`: `sum binomial(p, 2k) (2k - 1)!! c^(-2k)`, asymptotic, with
/// its smallest term below 1e-17 here.
fn far_series(p: f64, c: f64) -> f64 {
    let (mut sum, mut term) = (1.0, 1.0);
    for k in 0..20 {
        let j = f64::from(2 * k);
        term *= (p - j) / c * ((p - j - 1.0) / c) / (j + 2.0);
        sum += term;
    }
    sum
}

/// `e^(x^2) erfc(x)` for `x >= 0`, and what it lacks of its asymptote: `1 - sqrt(pi) x e^(x^2) erfc(x)`.
struct ScaledErfc {
    value: f64,
    remainder: f64,
}

impl ScaledErfc {
    /// Midpoint rule of step 1/2 for `erfc x = (x/pi) e^(-x^2) integral of e^(-t^2)/(t^2 + x^2)`, with the residues of
    /// the poles `t = +-i x` where they lie in the strip that the rule's error depends on: error 1e-17 (C. Chiarella
    /// and A. Reichel, *On the evaluation of integrals related to the error function*, Math. Comp. 22, 1968).
    fn at(x: f64) -> Self {
        let (mut tail, mut remainder) = (0.0, 0.0);
        for k in 0..13 {
            let t = 0.5 * f64::from(k) + 0.25;
            let weight = (-t * t).exp() / (t * t + x * x);
            tail += weight;
            remainder += weight * t * t;
        }
        let pole = if x < TAU {
            2.0 * (x * x).exp() / (1.0 + (2.0 * TAU * x).exp())
        } else {
            0.0
        };
        let root_pi = PI.sqrt();
        Self {
            value: x * tail / PI + pole,
            remainder: remainder / root_pi - root_pi * x * pole,
        }
    }
}
