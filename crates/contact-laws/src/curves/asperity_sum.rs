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
//! [`GapDistribution`] is made of pieces of uniform density between quantiles, or of single samples, the limit of zero
//! width. The moments are sums over the pieces in closed form, without cancellation. `M_{1/2}` begins as a square root
//! at each sample and is C1 where a piece of finite width begins. With `Paper` `k_q` jumps at each sample, and its
//! slope is taken as zero there.
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
//! An evaluation costs a square root or two per loaded piece: for many pieces or points make a [table](crate::curves::table)
//! once.
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

use alloc::vec::Vec;

use crate::curves::{ContactCurves, CurvesInfo, Exponents, Jet};
use crate::error::{Error, Place, require, require_positive};
use crate::friction::{FrictionalLaw, PAPER_DOI};
use crate::law::Quantity;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::parameters::PointParameters;
use crate::physics::hertz::ElasticPair;

/// Rough contact by direct asperity sums with friction: the reference for fits and tables.
pub type AsperityLaw = FrictionalLaw<PointParameters<AsperitySumCurves>>;

static INFO: CurvesInfo = CurvesInfo {
    name: "rough contact, asperity sum",
    reference: PAPER_DOI,
    parameters: &[
        Quantity::new("asperity_density", "1/m^2"),
        Quantity::new("beta_x", "m"),
        Quantity::new("beta_y", "m"),
        Quantity::new("asperity gaps", "m"),
        Quantity::new("youngs_modulus", "Pa"),
        Quantity::new("poisson_ratio", "1"),
    ],
};

/// Distribution of the asperities' initial gaps `s` (m): pieces of uniform density, of which single samples are the
/// limit of zero width.
#[derive(Debug, Clone, PartialEq)]
pub struct GapDistribution {
    /// Ascending and without overlap.
    pieces: Vec<Piece>,
    /// Probability of all pieces before each piece.
    before: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    start: f64,
    width: f64,
    probability: f64,
}

impl GapDistribution {
    /// Equally weighted samples `s >= 0` (m) in any order.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a sample is negative or not finite, [`Error::Length`] when there is none.
    pub fn try_from_samples(mut samples: Vec<f64>) -> Result<Self, Error> {
        if samples.is_empty() {
            return Err(Error::Length {
                list: "asperity gap samples",
                expected: 1,
                found: 0,
            });
        }
        for (i, &s) in samples.iter().enumerate() {
            require_gap(s, i)?;
        }
        samples.sort_by(f64::total_cmp);
        let probability = 1.0 / samples.len() as f64;
        Ok(Self::from_pieces(
            samples
                .into_iter()
                .map(|start| Piece {
                    start,
                    width: 0.0,
                    probability,
                })
                .collect(),
        ))
    }

    /// Quantile function, linear between the given `probabilities` (ascending from 0 to 1) with the gaps `values` (m)
    /// (ascending, not negative). Equal neighbouring values put the probability between them on one gap.
    ///
    /// # Errors
    /// [`Error::Length`] when the lists differ in length or have fewer than two entries, [`Error::Parameter`] when an
    /// entry is not finite or out of order.
    pub fn try_from_quantiles(probabilities: &[f64], values: &[f64]) -> Result<Self, Error> {
        let n = probabilities.len();
        if n < 2 {
            return Err(Error::Length {
                list: "probabilities of the asperity gaps",
                expected: 2,
                found: n,
            });
        }
        if values.len() != n {
            return Err(Error::Length {
                list: "values of the asperity gaps",
                expected: n,
                found: values.len(),
            });
        }
        let (first, last) = (probabilities[0], probabilities[n - 1]);
        require(
            first == 0.0,
            "probability",
            first,
            "(no unit)",
            Place::Entry(0),
            "0 for the first entry",
        )?;
        require(
            last == 1.0,
            "probability",
            last,
            "(no unit)",
            Place::Entry(n - 1),
            "1 for the last entry",
        )?;
        require_gap(values[0], 0)?;
        let mut pieces = Vec::with_capacity(n - 1);
        for i in 1..n {
            require_gap(values[i], i)?;
            let (width, probability) = (values[i] - values[i - 1], probabilities[i] - probabilities[i - 1]);
            let requirement = "not below the entry before";
            require(
                width >= 0.0,
                "asperity gap",
                values[i],
                "m",
                Place::Entry(i),
                requirement,
            )?;
            require(
                probability >= 0.0,
                "probability",
                probabilities[i],
                "(no unit)",
                Place::Entry(i),
                requirement,
            )?;
            if probability > 0.0 {
                pieces.push(Piece {
                    start: values[i - 1],
                    width,
                    probability,
                });
            }
        }
        Ok(Self::from_pieces(pieces))
    }

    fn from_pieces(pieces: Vec<Piece>) -> Self {
        let before = pieces
            .iter()
            .scan(0.0, |sum, piece| {
                let before = *sum;
                *sum += piece.probability;
                Some(before)
            })
            .collect();
        Self { pieces, before }
    }

    /// Gap of the first asperity to touch (m).
    pub fn smallest(&self) -> f64 {
        self.pieces[0].start
    }

    /// Gap of the last asperity to touch (m).
    pub fn largest(&self) -> f64 {
        let last = self.pieces[self.pieces.len() - 1];
        last.start + last.width
    }

    /// `M_0(u)`: probability of a gap below `u`.
    pub fn loaded_fraction(&self, u: f64) -> f64 {
        match self.n_loaded(u) {
            0 => 0.0,
            n => self.before[n - 1] + Loaded::new(&self.pieces[n - 1], u).share,
        }
    }

    /// `M_1(u) = E[(u - s)_+]` (m).
    pub fn mean_interference(&self, u: f64) -> f64 {
        self.loaded(u).map(|l| 0.5 * l.share * (l.a * l.a + l.b * l.b)).sum()
    }

    /// `M_{3/2}(u)` (m^(3/2)) and `M_{1/2}(u)` (m^(1/2)).
    pub fn three_halves_moment(&self, u: f64) -> (f64, f64) {
        self.loaded(u).fold((0.0, 0.0), |(high, low), l| {
            let (aa, ab, bb, sum) = (l.a * l.a, l.a * l.b, l.b * l.b, l.a + l.b);
            let quintic = aa * aa + ab * (aa + ab + bb) + bb * bb;
            (
                high + 0.4 * l.share * quintic / sum,
                low + 2.0 / 3.0 * l.share * (aa + ab + bb) / sum,
            )
        })
    }

    /// `M_{1/2}(u)` with its first two derivatives with respect to `u`.
    pub fn half_moment(&self, u: f64) -> Jet {
        self.loaded(u).fold(Jet::default(), |jet, l| {
            let sum = l.a + l.b;
            let bend = if l.partly {
                -l.density / l.a
            } else {
                l.share / (l.a * l.b * sum)
            };
            Jet {
                value: jet.value + 2.0 / 3.0 * l.share * (l.a * l.a + l.a * l.b + l.b * l.b) / sum,
                slope: jet.slope + l.share / sum,
                curvature: jet.curvature - 0.5 * bend,
            }
        })
    }

    /// Probability density of the gaps at `u` (1/m); zero between samples.
    fn density(&self, u: f64) -> f64 {
        match self.n_loaded(u) {
            0 => 0.0,
            n => Some(Loaded::new(&self.pieces[n - 1], u))
                .filter(|l| l.partly)
                .map_or(0.0, |l| l.density),
        }
    }

    /// Start (m), width (m) and probability of every piece, ascending.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        self.pieces
            .iter()
            .map(|piece| (piece.start, piece.width, piece.probability))
    }

    /// Number of pieces that begin below `u`.
    fn n_loaded(&self, u: f64) -> usize {
        self.pieces.partition_point(|piece| piece.start < u)
    }

    fn loaded(&self, u: f64) -> impl Iterator<Item = Loaded> + '_ {
        self.pieces[..self.n_loaded(u)]
            .iter()
            .map(move |piece| Loaded::new(piece, u))
    }
}

/// The part of a piece with gaps below `u`, from interference `b^2` to `a^2`.
///
/// Over it, `integral (u - s)^n ds = (a^(2n+2) - b^(2n+2))/(n + 1)`. Divided by the width `a^2 - b^2 = (a - b)(a + b)`,
/// the differences become sums of positive terms: no cancellation, and the limit of zero width is included.
struct Loaded {
    a: f64,
    b: f64,
    /// Probability of the part.
    share: f64,
    /// The piece reaches beyond `u`.
    partly: bool,
    /// Probability per gap, if `partly`.
    density: f64,
}

impl Loaded {
    #[inline]
    fn new(piece: &Piece, u: f64) -> Self {
        let interference = u - piece.start;
        let a = interference.sqrt();
        if interference <= piece.width {
            let density = piece.probability / piece.width;
            Self {
                a,
                b: 0.0,
                share: density * interference,
                partly: true,
                density,
            }
        } else {
            let b = (interference - piece.width).sqrt();
            Self {
                a,
                b,
                share: piece.probability,
                partly: false,
                density: 0.0,
            }
        }
    }
}

fn require_gap(s: f64, entry: usize) -> Result<(), Error> {
    let ok = s.is_finite() && s >= 0.0;
    require(
        ok,
        "asperity gap",
        s,
        "m",
        Place::Entry(entry),
        "finite and not negative: measure it from first touch",
    )
}

/// Asperity pairs of an area.
#[derive(Debug, Clone, PartialEq)]
pub struct AsperityPopulation {
    gaps: GapDistribution,
    density: f64,
    radii: [f64; 2],
}

impl AsperityPopulation {
    /// From the distribution of the initial gaps, the number of pairs per area `n_A` (1/m^2) and the pairs' effective
    /// radii `beta_x`, `beta_y` (m).
    ///
    /// # Errors
    /// [`Error::Parameter`] when density or radii are not above zero.
    pub fn try_new(gaps: GapDistribution, density: f64, radii: [f64; 2]) -> Result<Self, Error> {
        require_positive("asperity_density", density, "1/m^2")?;
        require_positive("beta_x", radii[0], "m")?;
        require_positive("beta_y", radii[1], "m")?;
        Ok(Self { gaps, density, radii })
    }

    /// Distribution of the initial gaps.
    pub fn gaps(&self) -> &GapDistribution {
        &self.gaps
    }

    /// Pairs per area (1/m^2).
    pub fn density(&self) -> f64 {
        self.density
    }

    /// Effective radii along x and y (m).
    pub fn radii(&self) -> [f64; 2] {
        self.radii
    }

    /// `beta = sqrt(beta_x beta_y)` (m).
    pub fn effective_radius(&self) -> f64 {
        self.radii[0].sqrt() * self.radii[1].sqrt()
    }
}

/// Which tangential stiffness the asperities have; see the [module](self).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum TangentialReading {
    /// Mindlin's stiffness of each Hertz contact: proportional to its contact radius, equal in all directions.
    #[default]
    Mindlin,
    /// As published: every loaded asperity has the same stiffness.
    Paper,
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
        let normal_factor = population.density * 4.0 / 3.0 * material.composite_modulus() * root;
        let nu = material.poisson_ratio;
        let shear = 2.0 * material.youngs_modulus / ((2.0 - nu) * (1.0 + nu));
        let tangential_factors = match reading {
            TangentialReading::Mindlin => [population.density * shear * root; 2],
            TangentialReading::Paper => population.radii.map(|beta| 2.0 * population.density * shear * beta),
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
        let (high, low) = self.population.gaps.three_halves_moment(u_n);
        (self.normal_factor * high, self.normal_factor * 1.5 * low)
    }

    #[inline]
    fn tangential(&self, u_n: f64) -> [Jet; 2] {
        let gaps = &self.population.gaps;
        let moment = match self.reading {
            TangentialReading::Mindlin => gaps.half_moment(u_n),
            TangentialReading::Paper => Jet {
                value: gaps.loaded_fraction(u_n),
                slope: gaps.density(u_n),
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
        let first = self.population.gaps.pieces[0];
        let rise = if first.width > 0.0 { 1.0 } else { 0.0 };
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
        Some(self.population.density * core::f64::consts::PI * beta * self.population.gaps.mean_interference(u_n))
    }

    fn yielded_fraction(&self, u_n: f64, omega_c: f64) -> Option<f64> {
        let gaps = &self.population.gaps;
        let loaded = gaps.loaded_fraction(u_n);
        Some(if loaded > 0.0 {
            gaps.loaded_fraction(u_n - omega_c.max(0.0)) / loaded
        } else {
            0.0
        })
    }
}
