//! The population of asperities of a pair of faces.

use contact_laws::{AsperityPopulation, GapDistribution, GreenwoodWilliamsonSurface, HeightDistribution};
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::error::{SurfaceError, finite_samples, positive};
use crate::face::FaceAsperities;
use crate::random::{draw, mix};

/// How the radii of two faces combine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum PairRadius {
    /// `1/R_q = 1/R_1q + 1/R_2q` per direction, effective radius `sqrt(R_x R_y)`.
    #[default]
    PerDirection,
    /// Effective radius `1 / (1/R_1x + 1/R_1y + 1/R_2x + 1/R_2y)`, eq. (6) as printed: half of
    /// Hertz's for equal spheres.
    Eq6Literal,
}

impl PairRadius {
    /// Pair radii along x and y and the effective radius (m) of the sums of both faces' curvatures (1/m).
    pub(crate) fn of(self, curvature: [f64; 2]) -> ([f64; 2], f64) {
        let radius = curvature.map(|c| 1.0 / c);
        let effective = match self {
            Self::PerDirection => (radius[0] * radius[1]).sqrt(),
            Self::Eq6Literal => 1.0 / (curvature[0] + curvature[1]),
        };
        (radius, effective)
    }
}

/// How the peak heights of two faces combine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum HeightCombination {
    /// The peaks of both faces in one sample.
    #[default]
    Pooled,
    /// Each peak on a random peak of the other face (seeded): the heights of two independent rough faces add.
    Summed,
}

/// Closed form that may stand in for sampled heights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeightFamily {
    /// Exponential heights, the textbook form of a tail.
    Exponential,
    /// Gaussian heights.
    Gaussian,
}

/// The asperities of a pair of faces over one element: what the asperity sums need.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PairAsperities {
    area: f64,
    count: f64,
    radius: [f64; 2],
    effective_radius: f64,
    heights: Vec<f64>,
    contact_height: f64,
}

impl PairAsperities {
    /// Builds a population of `count` asperities over `area` (m^2) with pair radii `radius` along x and y (m), the
    /// effective radius (m) of their Hertzian contacts, and a sample of their heights (m, any order, any datum).
    ///
    /// # Errors
    /// No heights, heights that are not finite, or any other number that is not positive and finite.
    pub fn try_new(
        area: f64,
        count: f64,
        radius: [f64; 2],
        effective_radius: f64,
        mut heights: Vec<f64>,
    ) -> Result<Self, SurfaceError> {
        positive("area", area, "m^2")?;
        positive("asperity count", count, "1")?;
        positive("radius x", radius[0], "m")?;
        positive("radius y", radius[1], "m")?;
        positive("effective radius", effective_radius, "m")?;
        if heights.is_empty() {
            return Err(SurfaceError::LengthMismatch {
                field: "heights",
                found: 0,
                expected: 1,
                remedy: "give the height of at least one asperity",
            });
        }
        finite_samples("heights", &heights, "m")?;
        heights.sort_by(|a, b| b.total_cmp(a));
        Ok(Self {
            area,
            count,
            radius,
            effective_radius,
            contact_height: heights[0],
            heights,
        })
    }

    /// Area of the element (m^2).
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Number of asperities on that area (an estimate, not an integer).
    pub fn count(&self) -> f64 {
        self.count
    }

    /// Asperities per area (1/m^2).
    pub fn asperity_density(&self) -> f64 {
        self.count / self.area
    }

    /// Pair radii along x and y (m).
    pub fn radius(&self) -> [f64; 2] {
        self.radius
    }

    /// Effective radius of the Hertzian contacts (m).
    pub fn effective_radius(&self) -> f64 {
        self.effective_radius
    }

    /// Sampled heights (m), tallest first.
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }

    /// Height `z_p` (m) at which `u_n = 0`: the tallest of the population, or of the one it was drawn from.
    pub fn contact_height(&self) -> f64 {
        self.contact_height
    }

    /// The same asperities with each height as many times as its weight says (a whole number), and the contact height
    /// `start` (m) deeper.
    pub(crate) fn redrawn(&self, weights: &[f64], start: f64) -> Self {
        let drawn = self.heights.iter().zip(weights);
        Self {
            heights: drawn.flat_map(|(z, w)| std::iter::repeat_n(*z, *w as usize)).collect(),
            contact_height: self.contact_height - start,
            ..*self
        }
    }

    /// The population as the contact laws take it: gaps `z_p - z_i` at first touch, asperities per area, pair radii.
    ///
    /// The laws use `sqrt(R_x R_y)` as effective radius; where this population has another one
    /// ([`PairRadius::Eq6Literal`]), both radii are scaled alike to give it, which is exact for Mindlin stiffnesses.
    ///
    /// # Errors
    /// The contact laws' own, for radii or densities that underflow.
    pub fn law_population(&self) -> Result<AsperityPopulation, contact_laws::Error> {
        let gaps = self.heights.iter().map(|z| self.contact_height - z).collect();
        self.with_gaps(GapDistribution::try_from_samples(gaps)?)
    }

    /// The population with the measured quantile function of its gaps, linear between `levels + 1` equidistant
    /// probabilities, in place of the samples: smooth where [`PairAsperities::law_population`] has a kink per peak.
    ///
    /// # Errors
    /// The contact laws' own; no levels, among others.
    pub fn quantile_population(&self, levels: usize) -> Result<AsperityPopulation, contact_laws::Error> {
        let last = self.heights.len() - 1;
        let probabilities: Vec<f64> = (0..=levels).map(|k| k as f64 / levels as f64).collect();
        let mut least = 0.0;
        let gaps: Vec<f64> = (0..=levels)
            .map(|k| {
                // Whole numbers, so that a level on an order statistic gives it to the last bit.
                let (below, part) = match levels {
                    0 => (0, 0.0),
                    levels => (k * last / levels, (k * last % levels) as f64 / levels as f64),
                };
                let above = (below + 1).min(last);
                let height = self.heights[below] + part * (self.heights[above] - self.heights[below]);
                // Rounding between equal heights must not make gaps descend.
                least = f64::max(least, self.contact_height - height);
                least
            })
            .collect();
        self.with_gaps(GapDistribution::try_from_quantiles(&probabilities, &gaps)?)
    }

    /// The population with the distribution of its gaps linear between order statistics, for tables: without the kinks of
    /// square-root type at every height, which no table follows.
    ///
    /// Equal heights (as in a [`crate::realisation`]) count once, in the middle of their ranks. Beyond the 64th tallest, a
    /// height counts where its rank is 1/64 above that of the one before: what lies between moves the tractions of 4000
    /// heights by less than 1e-3 at any interference. A sample of one height stays as it is.
    ///
    /// # Errors
    /// The contact laws' own, for radii or densities that underflow.
    pub fn interpolated_population(&self) -> Result<AsperityPopulation, contact_laws::Error> {
        let last = self.heights.len() - 1;
        let (mut probabilities, mut gaps) = (Vec::new(), Vec::new());
        let (mut first, mut least) = (0, 0.0);
        for group in self.heights.chunk_by(|a, b| a == b) {
            let end = first + group.len() - 1;
            let rank = match (first, end) {
                (0, _) => 0.0,
                (_, end) if end == last => last as f64,
                (first, end) => 0.5 * (first + end) as f64,
            };
            if rank >= least || end == last {
                probabilities.push(rank / last as f64);
                gaps.push(self.contact_height - group[0]);
                least = rank * (1.0 + 1.0 / 64.0);
            }
            first = end + 1;
        }
        if gaps.len() < 2 {
            return self.law_population();
        }
        self.with_gaps(GapDistribution::try_from_quantiles(&probabilities, &gaps)?)
    }

    /// The same asperities with `u_n = 0` at their own tallest, and by how much it lies deeper than before (m): what a
    /// realisation without the tallest peak adds to the gap.
    #[must_use]
    pub fn from_own_tallest(&self) -> (Self, f64) {
        let depth = self.contact_height - self.heights[0];
        let population = Self {
            contact_height: self.heights[0],
            ..self.clone()
        };
        (population, depth)
    }

    /// The population with heights of a closed form that has the sample's mean and standard deviation; `u_n = 0` stays
    /// where it is. `None` where all heights are equal.
    ///
    /// Joints are carried by the tallest few of a hundred peaks, where the form decides and the moments do not: compare
    /// with the sums before use.
    pub fn closed_form(&self, family: HeightFamily) -> Option<GreenwoodWilliamsonSurface> {
        let n = self.heights.len() as f64;
        let mean = self.heights.iter().sum::<f64>() / n;
        let deviation = (self.heights.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / n).sqrt();
        let (heights, zero) = match family {
            HeightFamily::Exponential => (HeightDistribution::Exponential { scale: deviation }, mean - deviation),
            HeightFamily::Gaussian => (
                HeightDistribution::Gaussian {
                    standard_deviation: deviation,
                },
                mean,
            ),
        };
        (deviation > 0.0).then(|| GreenwoodWilliamsonSurface {
            heights,
            reference_height: self.contact_height - zero,
            asperity_density: self.asperity_density(),
            radii: self.law_radii(),
        })
    }

    fn with_gaps(&self, gaps: GapDistribution) -> Result<AsperityPopulation, contact_laws::Error> {
        AsperityPopulation::try_new(gaps, self.asperity_density(), self.law_radii())
    }

    /// Radii whose geometric mean is the effective radius.
    fn law_radii(&self) -> [f64; 2] {
        let scale = self.effective_radius / (self.radius[0].sqrt() * self.radius[1].sqrt());
        self.radius.map(|r| r * scale)
    }

    /// The same asperities all of one height: the closed single-asperity form.
    #[must_use]
    pub fn uniform(&self) -> Self {
        Self {
            heights: vec![self.heights[0]],
            ..self.clone()
        }
    }
}

/// How two faces become one population.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct PairOptions {
    pub(crate) radius: PairRadius,
    pub(crate) heights: HeightCombination,
    pub(crate) seed: u64,
}

/// Combines both faces of `element`: radii by the pair rule, counts averaged, heights pooled or summed.
///
/// A face without peaks along a direction counts as flat there (zero curvature); where neither face has a peak along
/// one direction, the radius of the other direction serves both.
pub(crate) fn combine(
    element: usize,
    area: f64,
    faces: [&FaceAsperities; 2],
    options: PairOptions,
) -> Result<PairAsperities, SurfaceError> {
    let curvature = [0, 1].map(|q| faces.iter().filter_map(|f| f.radius[q]).map(|r| 1.0 / r).sum::<f64>());
    let counts: Vec<f64> = faces.iter().filter_map(|f| f.asperity_count).collect();
    if counts.is_empty() {
        return Err(SurfaceError::NoPeaks {
            element,
            points_top: faces[0].points,
            points_bottom: faces[1].points,
        });
    }
    let curvature = [0, 1].map(|q| {
        if curvature[q] > 0.0 {
            curvature[q]
        } else {
            curvature[1 - q]
        }
    });
    let (radius, effective) = options.radius.of(curvature);
    let [top, bottom] = faces.map(|f| f.heights.as_slice());
    let heights = match options.heights {
        HeightCombination::Pooled => [top, bottom].concat(),
        HeightCombination::Summed if top.is_empty() || bottom.is_empty() => [top, bottom].concat(),
        HeightCombination::Summed => {
            let mut rng = Pcg64::seed_from_u64(mix(options.seed, element as u64, u64::MAX));
            let (long, short) = if top.len() >= bottom.len() {
                (top, bottom)
            } else {
                (bottom, top)
            };
            long.iter().map(|z| z + short[draw(&mut rng, short.len())]).collect()
        }
    };
    PairAsperities::try_new(
        area,
        counts.iter().sum::<f64>() / counts.len() as f64,
        radius,
        effective,
        heights,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::face::tests::face;

    #[test]
    fn equal_spheres_give_half_the_radius_and_the_literal_equation_a_quarter() {
        let f = face([Some(2e-3); 2], vec![0.0, 1e-6], Some(10.0));
        let pair = |radius| {
            combine(
                3,
                1e-6,
                [&f, &f],
                PairOptions {
                    radius,
                    ..PairOptions::default()
                },
            )
            .unwrap()
        };
        assert!((pair(PairRadius::PerDirection).effective_radius() - 1e-3).abs() < 1e-18);
        assert!((pair(PairRadius::Eq6Literal).effective_radius() - 0.5e-3).abs() < 1e-18);
    }

    #[test]
    fn flat_faces_and_flat_directions() {
        let rough = face([Some(2e-3), None], vec![0.0, 1e-6], Some(10.0));
        let flat = face([None, None], vec![], None);
        let pair = combine(3, 1e-6, [&rough, &flat], PairOptions::default()).unwrap();
        assert_eq!((pair.radius(), pair.count()), ([2e-3, 2e-3], 10.0));
        assert_eq!(
            combine(3, 1e-6, [&flat, &flat], PairOptions::default()),
            Err(SurfaceError::NoPeaks {
                element: 3,
                points_top: 100,
                points_bottom: 100
            })
        );
    }

    #[test]
    fn pooled_and_summed_heights() {
        let a = face([Some(2e-3); 2], vec![1.0, 0.0, 2.0], Some(10.0));
        let b = face([Some(2e-3); 2], vec![0.0, 10.0], Some(20.0));
        let pooled = combine(0, 1.0, [&a, &b], PairOptions::default()).unwrap();
        assert_eq!(pooled.heights(), [10.0, 2.0, 1.0, 0.0, 0.0]);
        assert_eq!(pooled.count(), 15.0);
        let summed = PairOptions {
            heights: HeightCombination::Summed,
            seed: 5,
            ..PairOptions::default()
        };
        let first = combine(0, 1.0, [&a, &b], summed).unwrap();
        assert_eq!(first.heights().len(), 3);
        for z in first.heights() {
            assert!([0.0, 1.0, 2.0, 10.0, 11.0, 12.0].contains(z));
        }
        assert_eq!(first, combine(0, 1.0, [&a, &b], summed).unwrap());
    }

    #[test]
    fn closed_forms_and_quantiles_stand_in_for_their_own_samples() {
        use contact_laws::{
            AsperitySumCurves, ContactCurves, ElasticPair, GreenwoodWilliamsonCurves, TangentialReading,
        };
        let steel = ElasticPair {
            youngs_modulus: 192.85e9,
            poisson_ratio: 0.29,
        };
        // Quantiles of both families at (k + 1/2)/n: samples without scatter.
        let n = 40_000;
        let probabilities = || (0..n).map(|k| (f64::from(k) + 0.5) / f64::from(n));
        let exponential = probabilities().map(|p| -0.8e-6 * p.ln()).collect();
        let gaussian = probabilities()
            .map(|p| -1.2e-6 * std::f64::consts::SQRT_2 * statrs::function::erf::erfc_inv(2.0 - 2.0 * p))
            .collect();
        for (family, heights) in [
            (HeightFamily::Exponential, exponential),
            (HeightFamily::Gaussian, gaussian),
        ] {
            let pair = PairAsperities::try_new(1e-6, 30.0, [1e-3, 2e-3], 1e-3, heights).unwrap();
            let reading = TangentialReading::Mindlin;
            let sums = AsperitySumCurves::try_new(pair.law_population().unwrap(), steel, reading).unwrap();
            let closed = GreenwoodWilliamsonCurves::try_new(pair.closed_form(family).unwrap(), steel, reading).unwrap();
            let quantiles =
                AsperitySumCurves::try_new(pair.quantile_population(n as usize - 1).unwrap(), steel, reading).unwrap();
            // From where a thousand of the samples carry.
            for share in [0.7, 0.8, 0.95] {
                let u = share * (pair.contact_height() - pair.heights()[n as usize / 2]);
                let expected = (sums.normal(u).0, sums.tangential(u)[0].value);
                for found in [
                    (closed.normal(u).0, closed.tangential(u)[0].value),
                    (quantiles.normal(u).0, quantiles.tangential(u)[0].value),
                ] {
                    assert!(
                        (found.0 / expected.0 - 1.0).abs() < 0.01,
                        "{family:?} {share}: {found:?} {expected:?}"
                    );
                    assert!(
                        (found.1 / expected.1 - 1.0).abs() < 0.01,
                        "{family:?} {share}: {found:?} {expected:?}"
                    );
                }
            }
            assert!(pair.uniform().closed_form(family).is_none());
            assert!(pair.quantile_population(0).is_err());
        }
    }

    #[test]
    fn invalid_populations_are_named() {
        let new = |area, count, r, h| PairAsperities::try_new(area, count, [r, 1.0], 1.0, h);
        assert!(new(0.0, 1.0, 1.0, vec![1.0]).is_err());
        assert!(new(1.0, f64::NAN, 1.0, vec![1.0]).is_err());
        assert!(new(1.0, 1.0, -1.0, vec![1.0]).is_err());
        assert!(matches!(
            new(1.0, 1.0, 1.0, vec![]),
            Err(SurfaceError::LengthMismatch { .. })
        ));
        assert!(matches!(
            new(1.0, 1.0, 1.0, vec![1.0, f64::NAN]),
            Err(SurfaceError::InvalidSample { index: 1, .. })
        ));
        assert_eq!(new(1.0, 1.0, 1.0, vec![1.0, 3.0]).unwrap().uniform().heights(), [3.0]);
    }
}
