//! Asperities of one face, and the population of a pair of faces.

use contact_laws::{AsperityPopulation, GapDistribution, GreenwoodWilliamsonSurface, HeightDistribution};
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::areal::ArealParameters;
use crate::error::{SurfaceError, not_negative, positive};
use crate::gap::Bilinear;
use crate::resolution::Resolution;
use crate::response::{Realisation, draw, mix};

/// Peak height that enters the half-axes `w_q` of the packing estimate (eq. 26).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum PackingHeight {
    /// The element's total roughness R_t, as published.
    #[default]
    TotalRoughness,
    /// Mean height of the peaks above the lowest one (R_t where that vanishes: a single peak).
    MeanPeak,
}

/// Where the number of asperities comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum AsperityCount {
    /// Ellipses packed on the element's area (eq. 27).
    #[default]
    Packing,
    /// Measured summits (8 neighbours), at least one.
    Summits,
}

/// How the radii of two faces combine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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

/// How the peak heights of two faces combine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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

/// What one face shows over one element.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FaceAsperities {
    /// Points with data inside the element.
    pub points: usize,
    /// Points without data inside the element.
    pub missing: usize,
    /// Bilinear form of the de-trended heights; everything below is measured from it.
    pub plane: Bilinear,
    /// Areal parameters of the residual heights.
    pub areal: ArealParameters,
    /// Peaks found along x lines and along y lines.
    pub peaks: [usize; 2],
    /// Summits (8 neighbours).
    pub summits: usize,
    /// Radius along x and along y by the chosen statistic (m); `None` without a peak along that direction.
    pub radius: [Option<f64>; 2],
    /// What the instrument resolves of all this.
    pub resolution: Resolution,
    /// Peak heights above the lowest peak (m), both directions, in scan order. Not written out: the population of the pair
    /// is.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub heights: Vec<f64>,
    /// Height of the tallest peak (of the tallest point where there is no peak) above the plane (m).
    pub tallest: f64,
    /// Highest point or peak above the de-trended datum of the whole face (m).
    pub summit_level: f64,
    /// Number of asperities by the chosen count; `None` without peaks.
    pub asperity_count: Option<f64>,
}

impl FaceAsperities {
    /// Total roughness R_t, highest minus lowest residual height (m): Sz.
    pub fn total_roughness(&self) -> f64 {
        self.areal.sz
    }
}

/// Number of ellipses packed on an area (eq. 27): `eta A / (pi w_x w_y)` with `w_q = sqrt(z (2 R_q - z))` (eq. 26).
///
/// `area` (m^2), `height` z (m), single-face radii `radius` (m), packing efficiency `efficiency` (0.5 for peaks and
/// valleys alike). z is cut at `R_q`: beyond it the published form shrinks again and beyond `2 R_q` is imaginary.
///
/// # Errors
/// An argument that is not positive and finite.
pub fn packing_count(area: f64, height: f64, radius: [f64; 2], efficiency: f64) -> Result<f64, SurfaceError> {
    positive("area", area, "m^2")?;
    positive("height", height, "m")?;
    positive("packing efficiency", efficiency, "1")?;
    let mut axes = 1.0;
    for r in radius {
        let z = height.min(positive("radius", r, "m")?);
        axes *= (z * (2.0 * r - z)).sqrt();
    }
    Ok(efficiency * area / (std::f64::consts::PI * axes))
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
        if let Some(index) = heights.iter().position(|z| !z.is_finite()) {
            return Err(SurfaceError::InvalidSample {
                field: "heights",
                index,
                value: heights[index],
                unit: "m",
                requirement: "finite",
            });
        }
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

    /// The same asperities with the heights drawn from this population by `realisation`.
    pub(crate) fn redrawn(&self, realisation: &Realisation) -> Self {
        let drawn = self.heights.iter().zip(&realisation.weights);
        Self {
            heights: drawn.flat_map(|(z, w)| std::iter::repeat_n(*z, *w as usize)).collect(),
            contact_height: self.contact_height - realisation.start,
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
    let radius = curvature.map(|c| 1.0 / c);
    let effective = match options.radius {
        PairRadius::PerDirection => (radius[0] * radius[1]).sqrt(),
        PairRadius::Eq6Literal => 1.0 / (curvature[0] + curvature[1]),
    };
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

/// Asperity count of one face by the chosen readings; `None` without peaks.
pub(crate) fn face_count(
    face: &FaceAsperities,
    area: f64,
    count: AsperityCount,
    height: PackingHeight,
    efficiency: f64,
) -> Result<Option<f64>, SurfaceError> {
    let radius = match face.radius {
        [Some(x), Some(y)] => [x, y],
        [Some(r), None] | [None, Some(r)] => [r, r],
        [None, None] => return Ok(None),
    };
    let mean_peak = face.heights.iter().sum::<f64>() / face.heights.len() as f64;
    not_negative("mean peak height", mean_peak, "m")?;
    let height = match height {
        PackingHeight::MeanPeak if mean_peak > 0.0 => mean_peak,
        _ => face.total_roughness(),
    };
    Ok(Some(match count {
        AsperityCount::Packing => packing_count(area, height, radius, efficiency)?,
        AsperityCount::Summits => face.summits.max(1) as f64,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face(radius: [Option<f64>; 2], heights: Vec<f64>, count: Option<f64>) -> FaceAsperities {
        FaceAsperities {
            points: 100,
            missing: 0,
            plane: Bilinear {
                centre: [0.0; 2],
                half_width: [1.0; 2],
                coefficients: [0.0; 4],
            },
            areal: ArealParameters {
                points: 100,
                sa: 0.8e-6,
                sq: 1e-6,
                sz: 4e-6,
                ssk: None,
                sku: None,
                sdq: None,
                peaks: 0,
                spd: 0.0,
                spc: None,
            },
            peaks: [heights.len(), 0],
            summits: 0,
            radius,
            resolution: Resolution {
                height_step: None,
                lateral_step: [1e-5; 2],
                least_curvature: None,
                curvature: [None; 2],
                curvature_at_double_step: [None; 2],
                samples_per_peak: [None; 2],
            },
            heights,
            tallest: 2e-6,
            summit_level: 2e-6,
            asperity_count: count,
        }
    }

    #[test]
    fn packing_of_spheres_and_its_cut() {
        // z = R: the ellipse is the great circle.
        let n = packing_count(1e-6, 1e-4, [1e-4, 1e-4], 0.5).unwrap();
        assert!((n - 0.5 * 1e-6 / (std::f64::consts::PI * 1e-8)).abs() < 1e-9);
        // Beyond the radius nothing changes: the published form would be imaginary at z = 2.5 R.
        assert_eq!(packing_count(1e-6, 2.5e-4, [1e-4, 1e-4], 0.5).unwrap(), n);
        let flat = packing_count(1e-6, 1e-6, [1e-3, 2e-3], 0.5).unwrap();
        let axes = (1e-6f64 * (2e-3 - 1e-6)).sqrt() * (1e-6f64 * (4e-3 - 1e-6)).sqrt();
        assert!((flat * std::f64::consts::PI * axes / 0.5e-6 - 1.0).abs() < 1e-14);
        assert!(packing_count(1e-6, 0.0, [1e-3, 2e-3], 0.5).is_err());
    }

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
    fn counts_by_each_reading() {
        let mut f = face([Some(1e-3), None], vec![0.0, 2e-6], None);
        let count = |f: &FaceAsperities, c, h| face_count(f, 1e-6, c, h, 0.5).unwrap().unwrap();
        let total = count(&f, AsperityCount::Packing, PackingHeight::TotalRoughness);
        let mean = count(&f, AsperityCount::Packing, PackingHeight::MeanPeak);
        // 4 um against 1 um: the packed area goes with z, so the count goes with 1/z.
        assert!((mean / total - 4.0).abs() < 0.01, "{}", mean / total);
        assert_eq!(count(&f, AsperityCount::Summits, PackingHeight::TotalRoughness), 1.0);
        f.summits = 7;
        assert_eq!(count(&f, AsperityCount::Summits, PackingHeight::TotalRoughness), 7.0);
        f.heights = vec![0.0];
        assert_eq!(count(&f, AsperityCount::Packing, PackingHeight::MeanPeak), total);
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
