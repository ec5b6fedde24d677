//! Rough contact after Greenwood and Williamson: asperities of equal radius whose heights follow a distribution, with
//! exponential or Gaussian heights, in closed form.
//!
//! With `delta = reference_height - u_n`, the distance from the zero of the heights to the opposite plane, and the
//! partial moments of the heights `z` beyond it,
//!
//! <div>
//! $$ M_n = \int_{\delta}^{\infty} (z - \delta)^n \, \phi(z) \, dz, \qquad
//! t_n = n_A \, \frac{2}{3} \frac{E}{1 - \nu^2} \sqrt{\beta} \, M_{3/2}, \qquad
//! k_t = n_A \, \frac{2 E}{(2 - \nu)(1 + \nu)} \sqrt{\beta} \, M_{1/2}, \qquad
//! \frac{A_r}{A} = n_A \pi \beta M_1 . $$
//! </div>
//!
//! [`TangentialReading::Paper`] takes `k_q = n_A 4 E beta_q M_0 / ((2 - nu)(1 + nu))` instead, as in
//! [`asperity_sum`](crate::curves::asperity_sum). With `h = delta/s` for exponential heights of scale `s` (they begin at
//! zero, so `M_0 = 1` beyond) and `h = delta/sigma` for Gaussian heights of standard deviation `sigma` about zero:
//!
//! <div>
//! $$ M_n = s^n \begin{cases} \Gamma(n + 1) \, e^{-h} & h \ge 0 \\ e^{-h} \, \Gamma(n + 1, -h) & h < 0 \end{cases}
//! \qquad \text{or} \qquad
//! M_n = \sigma^n F_n(h), \quad F_n(h) = \int_h^{\infty} (t - h)^n \frac{e^{-t^2/2}}{\sqrt{2 \pi}} \, dt . $$
//! </div>
//!
//! `F_{3/2}` and `F_{1/2}` are parabolic cylinder functions (for `h > 0` modified Bessel functions of order 1/4 and
//! 3/4), `F_1 = phi(h) - h Q(h)`. They are evaluated without cancellation for `h` of either sign, to better than 1e-12
//! relative to an independent quadrature for `h` from -30 to 30.
//!
//! # First touch
//! Heights without upper end have no first touch: at `u_n = 0` the moments are small, not zero. `reference_height` says
//! where `u_n = 0` lies; the natural choice is the height that one asperity of the area exceeds on average (for
//! exponential heights `s ln N`). So that the law vanishes continuously, below `u_n = scale/16` the curves go on C1 to
//! the exponents of single contacts, 3/2 for `t_n`, 1/2 for `k_t`, 1 for the contact area. There the traction falls
//! short of the closed form by less than its value at the joint, `t_n(scale/16)`, and the work of closing the contact
//! by less than `0.35 t_n(scale/16) scale/16`. How little that is depends on the reference height: with 3.5 standard
//! deviations the traction at the joint is 2.5e-4 of that at `u_n = 3` standard deviations, with 7 exponential scales
//! 1.6e-3 of that at 6.5 scales.
//!
//! # Parameters
//! | parameter | unit |
//! |---|---|
//! | scale or standard deviation of the heights | m |
//! | `reference_height` | m |
//! | `asperity_density` `n_A` | 1/m^2 |
//! | effective radii `beta_x`, `beta_y`; `beta = sqrt(beta_x beta_y)` | m |
//! | Young's modulus, Poisson's ratio | Pa, 1 |
//!
//! # Cost
//! With Gaussian heights a curve takes 48 exponentials, about 0.4 us per point on one core (0.01 us with exponential
//! heights). The curves are meant to be tabulated once ([`Tabulated`](crate::Tabulated)): 530 knots keep the default
//! tolerances from 1e-9 m to 1e-4 m. Exponential heights begin with a jump of their density, so at
//! `u_n = reference_height` the stiffness `k_t` has a jump of slope as published, of curvature after Mindlin: the
//! former is tabulated to 6e-4 across it, no better.
//!
//! Source: J. A. Greenwood and J. B. P. Williamson, *Contact of nominally flat surfaces*, Proc. R. Soc. Lond. A 295,
//! 1966. Tangential stiffness: R. D. Mindlin, *Compliance of elastic bodies in contact*, J. Appl. Mech. 16, 1949.
//!
//! # Example
//! ```
//! use contact_laws::*;
//!
//! let surface = GreenwoodWilliamsonSurface {
//!     heights: HeightDistribution::Gaussian { standard_deviation: 2e-6 },
//!     reference_height: 7e-6,
//!     asperity_density: 1.4e6,
//!     radii: [1.4e-3; 2],
//! };
//! let steel = ElasticPair::new(192.85e9, 0.29);
//! let curves = GreenwoodWilliamsonCurves::try_new(surface, steel, TangentialReading::Mindlin)?;
//! let table = Tabulated::try_new(curves, [1e-8, 2e-5], TableOptions::default())?;
//! let (t_n, k_n) = table.normal(5e-6);
//! let k_t = table.tangential(5e-6)[0].value;
//! assert!((k_t / k_n / steel.mindlin_ratio() - 1.0).abs() < 1e-3);
//! println!("{t_n:.3e} Pa, {k_n:.3e} and {k_t:.3e} Pa/m");
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

use core::f64::consts::PI;

use crate::curves::asperity_sum::TangentialReading;
use crate::curves::continuation::End;
use crate::curves::{ContactCurves, CurvesInfo, Exponents};
use crate::error::{Error, Place, require};
use crate::jet::Jet;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::{Bounds, Parameter};
use crate::physics::heights::HeightDistribution;
use crate::physics::heights::SCALE;
use crate::physics::hertz::ElasticPair;
use crate::physics::hertz::{POISSON_RATIO, YOUNGS_MODULUS};
use crate::physics::population::{BETA_X, BETA_Y, DENSITY};

const REFERENCE_HEIGHT: Parameter = Parameter::new("reference_height", "m", Bounds::Positive);

pub(super) static INFO: CurvesInfo = CurvesInfo {
    name: "rough contact, Greenwood-Williamson",
    reference: "https://doi.org/10.1098/rspa.1966.0242",
    page: "greenwood-williamson.md",
    parameters: &[
        SCALE,
        REFERENCE_HEIGHT,
        DENSITY,
        BETA_X,
        BETA_Y,
        YOUNGS_MODULUS,
        POISSON_RATIO,
    ],
};

/// Where the closed forms begin, as a fraction of the heights' scale.
const JOINT: f64 = 1.0 / 16.0;

/// Asperities of an area, whose heights follow a distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct GreenwoodWilliamsonSurface {
    /// Distribution of the heights.
    pub heights: HeightDistribution,
    /// Distance of the opposite plane from the zero of the heights at `u_n = 0` (m), above zero.
    pub reference_height: f64,
    /// Asperities per area (1/m^2).
    pub asperity_density: f64,
    /// Effective radii along x and y (m).
    pub radii: [f64; 2],
}

/// The curves of a [`GreenwoodWilliamsonSurface`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GreenwoodWilliamsonCurves {
    surface: GreenwoodWilliamsonSurface,
    material: ElasticPair,
    reading: TangentialReading,
    /// Factor of the moment of order 3/2 in units of the scale (Pa).
    normal_factor: f64,
    /// Factor of the moment of order 1/2, or 0, in units of the scale (Pa/m).
    tangential_factors: [f64; 2],
    /// Factor of the first moment in units of the scale.
    area_factor: f64,
    joint: f64,
    normal_end: End,
    tangential_ends: [End; 2],
    area_end: End,
}

impl GreenwoodWilliamsonCurves {
    /// From the asperities of two equal elastic bodies.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a length or density that is not above zero, a material that is not physical, and a
    /// reference height so far above the heights that the traction underflows.
    pub fn try_new(
        surface: GreenwoodWilliamsonSurface,
        material: ElasticPair,
        reading: TangentialReading,
    ) -> Result<Self, Error> {
        let GreenwoodWilliamsonSurface {
            heights,
            reference_height,
            asperity_density: density,
            radii,
        } = surface;
        heights.validate()?;
        REFERENCE_HEIGHT.check(reference_height)?;
        DENSITY.check(density)?;
        BETA_X.check(radii[0])?;
        BETA_Y.check(radii[1])?;
        material.validate()?;

        let scale = heights.scale();
        let beta = radii[0] * (radii[1] / radii[0]).sqrt();
        // One root of a product of two lengths: powers of two in the unit of length stay exact.
        let root = (beta * scale).sqrt();
        let shear = material.mindlin_modulus();
        let none = End::new(1.0, 0.0, 0.0);
        let mut curves = Self {
            surface,
            material,
            reading,
            normal_factor: density * 4.0 / 3.0 * material.composite_modulus() * root * scale,
            tangential_factors: match reading {
                TangentialReading::Mindlin => [density * shear * root; 2],
                TangentialReading::Paper => radii.map(|beta| 2.0 * density * shear * beta),
            },
            area_factor: density * PI * beta * scale,
            joint: JOINT * scale,
            normal_end: none,
            tangential_ends: [none; 2],
            area_end: none,
        };

        let factors = [
            curves.normal_factor,
            curves.normal_factor / scale,
            curves.tangential_factors[0] / scale / scale,
            curves.tangential_factors[1] / scale / scale,
            curves.area_factor,
        ];
        require(
            factors.iter().all(|factor| factor.is_normal()),
            "asperity_density",
            density,
            "1/m^2",
            Place::Whole,
            "such that tractions and their derivatives neither overflow nor underflow with these lengths",
        )?;
        let joint = curves.joint;
        let (value, slope) = curves.closed_normal(joint);
        require(
            value.is_normal() && slope.is_normal(),
            "reference_height",
            reference_height,
            "m",
            Place::Whole,
            "within reach of the heights: at u_n = 0 the traction must be a positive number (below about 37 standard \
             deviations or 700 scales)",
        )?;
        curves.normal_end = End::new(joint, value, slope);
        curves.tangential_ends = curves
            .closed_tangential(joint)
            .map(|k| End::new(joint, k.value, k.slope));
        let h = curves.separation(joint);
        curves.area_end = End::new(
            joint,
            curves.area_factor * heights.first_moment(h),
            curves.area_factor * heights.loaded_fraction(h).value / scale,
        );
        Ok(curves)
    }

    /// The asperities.
    pub fn surface(&self) -> &GreenwoodWilliamsonSurface {
        &self.surface
    }

    /// The material.
    pub fn material(&self) -> &ElasticPair {
        &self.material
    }

    /// The reading of the tangential stiffness.
    pub fn reading(&self) -> TangentialReading {
        self.reading
    }

    /// Interference (m) above which the closed forms hold: 1/16 of the scale of the heights.
    pub fn joint(&self) -> f64 {
        self.joint
    }

    /// `h`: distance of the opposite plane in units of the scale, bounded so that powers of it are finite.
    #[inline]
    fn separation(&self, u_n: f64) -> f64 {
        ((self.surface.reference_height - u_n) / self.surface.heights.scale()).max(-1e200)
    }

    #[inline]
    fn closed_normal(&self, u_n: f64) -> (f64, f64) {
        let moments = self.surface.heights.half_moments(self.separation(u_n));
        let slope = 1.5 * self.normal_factor / self.surface.heights.scale();
        (self.normal_factor * moments.three_halves, slope * moments.half.value)
    }

    #[inline]
    fn closed_tangential(&self, u_n: f64) -> [Jet; 2] {
        let heights = &self.surface.heights;
        let (h, scale) = (self.separation(u_n), heights.scale());
        let moment = match self.reading {
            TangentialReading::Mindlin => heights.half_moments(h).half,
            TangentialReading::Paper => heights.loaded_fraction(h),
        };
        self.tangential_factors.map(|factor| Jet {
            value: factor * moment.value,
            slope: factor * moment.slope / scale,
            curvature: factor * moment.curvature / scale / scale,
        })
    }
}

impl ContactCurves for GreenwoodWilliamsonCurves {
    fn info(&self) -> &'static CurvesInfo {
        &INFO
    }

    #[inline]
    fn normal(&self, u_n: f64) -> (f64, f64) {
        if u_n < self.joint {
            let t = self.normal_end.below(u_n, self.exponents().normal);
            (t.value, t.slope)
        } else {
            self.closed_normal(u_n)
        }
    }

    #[inline]
    fn tangential(&self, u_n: f64) -> [Jet; 2] {
        if u_n < self.joint {
            let exponents = self.exponents().tangential;
            core::array::from_fn(|q| self.tangential_ends[q].below(u_n, exponents[q]))
        } else {
            self.closed_tangential(u_n)
        }
    }

    #[inline]
    fn exponents(&self) -> Exponents {
        let tangential = match self.reading {
            TangentialReading::Mindlin => 0.5,
            TangentialReading::Paper => 0.0,
        };
        Exponents {
            normal: 1.5,
            tangential: [tangential; 2],
        }
    }

    fn contact_area_ratio(&self, u_n: f64) -> Option<f64> {
        Some(if u_n <= 0.0 {
            0.0
        } else if u_n < self.joint {
            self.area_end.below(u_n, 1.0).value
        } else {
            self.area_factor * self.surface.heights.first_moment(self.separation(u_n))
        })
    }

    /// By the closed forms at every `u_n > 0`.
    fn yielded_fraction(&self, u_n: f64, omega_c: f64) -> Option<f64> {
        let heights = &self.surface.heights;
        let loaded = |u: f64| heights.loaded_fraction(self.separation(u)).value;
        let all = loaded(u_n);
        Some(if u_n > 0.0 && all > 0.0 {
            loaded(u_n - omega_c.max(0.0)) / all
        } else {
            0.0
        })
    }
}
