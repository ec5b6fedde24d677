//! Rough contact as the sum over a population of asperities (eqs. 6-14 and 21-24), without any fit.
//!
//! The population is described by the gap `s >= 0` of each asperity pair at the moment when the surfaces just touch
//! (`s = 0` for the first pair), by the number of pairs per area `n_A`, and by the pairs' effective radii. With the
//! partial expectations over all asperities, the unloaded ones counting as zero,
//! <div>
//! $$ M_n(u) = \mathrm{E}\left[ (u - s)_+^n \right], \qquad \beta = \sqrt{\beta_x \beta_y}, \qquad
//! t_n = n_A \, \frac{2}{3} \frac{E}{1 - \nu^2} \sqrt{\beta} \, M_{3/2}(u_n), \qquad
//! \frac{A_r}{A} = n_A \, \pi \beta \, M_1(u_n) . $$
//! </div>
//!
//! `A_r/A` is the real contact area per nominal area. The tangential stiffness has two [readings](TangentialReading):
//! <div>
//! $$ k_x = k_y = n_A \, \frac{2 E}{(2 - \nu)(1 + \nu)} \sqrt{\beta} \, M_{1/2}(u_n) \quad \text{(Mindlin)}, \qquad
//! k_q = n_A \, \frac{4 E}{(2 - \nu)(1 + \nu)} \, \beta_q \, M_0(u_n) \quad \text{(Paper)} . $$
//! </div>
//!
//! `Paper` is eq. (22) with the factor `n_A` that its unit asks for. With `Mindlin` the ratio of `k_t` to
//! `d t_n / d u_n` is `2 (1 - nu)/(2 - nu)`, as at each contact of its own.
//!
//! # Gap distribution
//! [`GapDistribution`](crate::GapDistribution) is made of pieces of uniform density between quantiles, or of single
//! samples, the limit of zero width. The moments are sums over the pieces in closed form, without cancellation.
//! `M_{1/2}` begins as a square root at each sample and is C1 where a piece of finite width begins. With `Paper` `k_q`
//! jumps at each sample, and its slope is taken as zero there.
//!
//! # Parameters
//! | parameter | unit |
//! |---|---|
//! | asperity gaps `s`, samples or quantiles | m |
//! | asperity density `n_A` | 1/m^2 |
//! | effective radii `beta_x`, `beta_y` | m |
//! | Young's modulus `E`, Poisson's ratio `nu` | Pa, 1 |
//! | friction coefficient `mu` | 1 |
//!
//! An evaluation costs a square root or two per loaded piece: for many pieces or points make a
//! [table](crate::curves::table) once.
//!
//! Sources: N. N. Balaji, W. Chen and M. R. W. Brake, *Traction-based multi-scale nonlinear dynamic modeling of bolted
//! joints: formulation, application, and trends in micro-scale interface evolution*, Mech. Syst. Signal Process. 139,
//! 2020, 106615; the sum over Hertz contacts: J. A. Greenwood and J. B. P. Williamson, *Contact of nominally flat
//! surfaces*, Proc. R. Soc. Lond. A 295, 1966.
//!
//! # Example
//! ```
//! use contact_laws::*;
//!
//! let gaps = GapDistribution::try_from_quantiles(&[0.0, 0.1, 0.5, 1.0], &[0.0, 8e-6, 14e-6, 28e-6])?;
//! let population = AsperityPopulation::try_new(gaps, 1.4e6, [1.4e-3; 2])?;
//! let steel = ElasticPair::new(192.85e9, 0.29);
//! let curves = AsperitySumCurves::try_new(population, steel, TangentialReading::Mindlin)?;
//! let (t_n, k_n) = curves.normal(5e-6);
//! let [k_x, k_y] = curves.tangential(5e-6).map(|k| k.value);
//! assert!(k_x == k_y && (k_x / k_n / steel.mindlin_ratio() - 1.0).abs() < 1e-12);
//!
//! let (curves, mu) = (PointParameters::uniform(curves, 3), PointParameters::uniform(0.2, 3));
//! let law = AsperityLaw::try_new(curves, mu, HistoryRule::Incremental)?;
//! let area = law.contact_area_ratio(0, 5e-6).expect("asperities have an area");
//! println!("{t_n:.3e} Pa on {area:.1e} of the area, {k_n:.3e} and {k_x:.3e} Pa/m");
//! assert!(area < 0.01);
//! # Ok::<(), Error>(())
//! ```
#![doc = include_str!("../../katex.html")]

use crate::choice::choices;
use crate::curves::{ContactCurves, CurveFactors, CurvesInfo, Exponents};
use crate::error::{Error, Place, require};
use crate::jet::Jet;
use crate::law::PAPER_DOI;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::{Bounds, Parameter};
use crate::physics::hertz::ElasticPair;
use crate::physics::hertz::{POISSON_RATIO, YOUNGS_MODULUS};
use crate::physics::population::AsperityPopulation;
use crate::physics::population::{BETA_X, BETA_Y, DENSITY};

pub(super) static INFO: CurvesInfo = CurvesInfo {
    name: "rough contact, asperity sum",
    reference: PAPER_DOI,
    page: "asperity-sum.md",
    parameters: &[
        DENSITY,
        BETA_X,
        BETA_Y,
        Parameter::new("asperity gaps", "m", Bounds::Other("not negative, in a distribution")),
        YOUNGS_MODULUS,
        POISSON_RATIO,
    ],
};

choices! {
    /// Which tangential stiffness the asperities have; see the [module](self).
    pub enum TangentialReading, "READING", "Tangential stiffness of an asperity" {
        Mindlin = "mindlin", 0,
            "Mindlin's stiffness of each Hertz contact: proportional to its contact radius, equal in all directions.";
        Paper = "paper", 1, "As published: every loaded asperity has the same stiffness.";
    }
}

/// The curves of an asperity population.
#[derive(Debug, Clone, PartialEq)]
pub struct AsperitySumCurves {
    population: AsperityPopulation,
    material: ElasticPair,
    reading: TangentialReading,
    /// Factor of `M_{3/2}` (Pa/m^(3/2)).
    normal_factor: f64,
    /// Factor of `M_{1/2}` (Pa/m^(3/2)) or `M_0` (Pa/m) per direction.
    tangential_factors: [f64; 2],
}

impl AsperitySumCurves {
    /// From a population of asperities of two equal elastic bodies.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the material is not physical.
    pub fn try_new(
        population: AsperityPopulation,
        material: ElasticPair,
        reading: TangentialReading,
    ) -> Result<Self, Error> {
        material.validate()?;
        let root = population.effective_radius().sqrt();
        let normal_factor = population.density() * 4.0 / 3.0 * material.composite_modulus() * root;
        let shear = material.mindlin_modulus();
        let tangential_factors = match reading {
            TangentialReading::Mindlin => [population.density() * shear * root; 2],
            TangentialReading::Paper => population.radii().map(|beta| 2.0 * population.density() * shear * beta),
        };
        let factors = [
            ("normal stiffness of the asperities", normal_factor),
            ("tangential stiffness of the asperities along x", tangential_factors[0]),
            ("tangential stiffness of the asperities along y", tangential_factors[1]),
        ];
        for (name, factor) in factors {
            let requirement = "a number that the floating-point format holds in full";
            require(factor.is_normal(), name, factor, "(SI)", Place::Whole, requirement)?;
        }
        Ok(Self {
            population,
            material,
            reading,
            normal_factor,
            tangential_factors,
        })
    }

    /// Factors from these curves to those of the same reading whose population has its gaps multiplied by `gaps`, and may have other
    /// densities, radii and materials.
    pub fn factors_to(&self, other: &Self, gaps: f64) -> CurveFactors {
        let power = match self.reading {
            TangentialReading::Mindlin => gaps.sqrt(),
            TangentialReading::Paper => 1.0,
        };
        CurveFactors {
            interference: gaps,
            normal: other.normal_factor / self.normal_factor * gaps * gaps.sqrt(),
            tangential: core::array::from_fn(|q| other.tangential_factors[q] / self.tangential_factors[q] * power),
        }
    }

    /// The population.
    pub fn population(&self) -> &AsperityPopulation {
        &self.population
    }

    /// The material.
    pub fn material(&self) -> &ElasticPair {
        &self.material
    }

    /// The reading of the tangential stiffness.
    pub fn reading(&self) -> TangentialReading {
        self.reading
    }
}

impl ContactCurves for AsperitySumCurves {
    fn info(&self) -> &'static CurvesInfo {
        &INFO
    }

    #[inline]
    fn normal(&self, u_n: f64) -> (f64, f64) {
        let (high, low) = self.population.gaps().three_halves_moment(u_n);
        (self.normal_factor * high, self.normal_factor * 1.5 * low)
    }

    #[inline]
    fn tangential(&self, u_n: f64) -> [Jet; 2] {
        let gaps = self.population.gaps();
        let moment = match self.reading {
            TangentialReading::Mindlin => gaps.half_moment(u_n),
            TangentialReading::Paper => Jet {
                value: gaps.loaded_fraction(u_n),
                slope: gaps.density_at(u_n),
                curvature: 0.0,
            },
        };
        self.tangential_factors.map(|factor| Jet {
            value: factor * moment.value,
            slope: factor * moment.slope,
            curvature: factor * moment.curvature,
        })
    }

    /// A first piece of finite width, touching from `u_n = 0`, raises the single asperity's exponents by one.
    fn exponents(&self) -> Exponents {
        let rise = if self.population.gaps().begins_with_a_width() {
            1.0
        } else {
            0.0
        };
        let tangential = match self.reading {
            TangentialReading::Mindlin => 0.5,
            TangentialReading::Paper => 0.0,
        };
        Exponents {
            normal: 1.5 + rise,
            tangential: [tangential + rise; 2],
        }
    }

    fn contact_area_ratio(&self, u_n: f64) -> Option<f64> {
        let beta = self.population.effective_radius();
        Some(self.population.density() * core::f64::consts::PI * beta * self.population.gaps().mean_interference(u_n))
    }

    fn yielded_fraction(&self, u_n: f64, omega_c: f64) -> Option<f64> {
        let gaps = self.population.gaps();
        let loaded = gaps.loaded_fraction(u_n);
        Some(if loaded > 0.0 {
            gaps.loaded_fraction(u_n - omega_c.max(0.0)) / loaded
        } else {
            0.0
        })
    }
}
