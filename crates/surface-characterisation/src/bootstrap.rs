//! Bootstrap of asperity populations: realisations, and bands of the traction curves.

use contact_laws::{ElasticPair, TangentialReading};
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::error::SurfaceError;
use crate::pair::PairAsperities;
use crate::random::{draw, mix};
use crate::response::{Sample, TractionCurves, curves_of};
use crate::statistics::percentile;

/// What the resampling does with the tallest peak, which sets where contact begins.
///
/// A resample misses the tallest peak in 37 % of the draws, and the ordinary bootstrap of a maximum is inconsistent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum TallestPeak {
    /// `u_n = 0` stays at the sample's own tallest peak; realisations that lack it have zero traction at first.
    #[default]
    Fixed,
    /// `m` out of `n`: each realisation draws `m = n^exponent` heights and starts at its own tallest peak.
    MOutOfN {
        /// Exponent in (0, 1).
        exponent: f64,
    },
}

/// How the sampling uncertainty of an element's curves is estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Bootstrap {
    /// Number of realisations; 0 for no bands.
    pub realisations: usize,
    /// Seed. Each element and realisation derives its own from it, so nothing depends on the order of evaluation.
    pub seed: u64,
    /// Treatment of the tallest peak.
    pub tallest: TallestPeak,
}

impl Default for Bootstrap {
    /// 30 realisations, seed 0, tallest peak fixed.
    fn default() -> Self {
        Self {
            realisations: 30,
            seed: 0,
            tallest: TallestPeak::Fixed,
        }
    }
}

/// 95 % percentile bands of the curves, `[lower, upper]`, at the same interferences.
///
/// Percentiles of 30 realisations under-cover: about 75 % instead of 95 % at small interference, where few peaks
/// carry the load. More realisations narrow the shortfall but do not remove it.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CurveBands {
    /// Number of realisations behind the percentiles.
    pub realisations: usize,
    /// Normal traction (Pa).
    pub normal: [Vec<f64>; 2],
    /// Tangential traction stiffness along x and y (Pa/m).
    pub tangential: [[Vec<f64>; 2]; 2],
}

/// Bands of the traction curves by resampling the heights of `element`'s population; `None` for 0 realisations.
///
/// # Errors
/// An interference that is not finite, or an exponent outside (0, 1).
pub fn bootstrap_bands(
    population: &PairAsperities,
    material: ElasticPair,
    reading: TangentialReading,
    interference: &[f64],
    bootstrap: Bootstrap,
    element: usize,
) -> Result<Option<CurveBands>, SurfaceError> {
    if bootstrap.realisations == 0 {
        return Ok(None);
    }
    let samples = (0..bootstrap.realisations)
        .map(|k| drawn(population, bootstrap, element, k))
        .collect::<Result<Vec<_>, _>>()?;
    let curves = curves_of(population, material, reading, interference, &samples)?;
    let band = |of: &dyn Fn(&TractionCurves) -> &Vec<f64>| {
        let mut bounds = [
            Vec::with_capacity(interference.len()),
            Vec::with_capacity(interference.len()),
        ];
        for k in 0..interference.len() {
            let mut values: Vec<f64> = curves.iter().map(|c| of(c)[k]).collect();
            values.sort_by(f64::total_cmp);
            bounds[0].push(percentile(&values, 0.025));
            bounds[1].push(percentile(&values, 0.975));
        }
        bounds
    };
    Ok(Some(CurveBands {
        realisations: bootstrap.realisations,
        normal: band(&|c| &c.normal),
        tangential: [band(&|c| &c.tangential[0]), band(&|c| &c.tangential[1])],
    }))
}

/// The sample behind realisation `k` of `element`.
fn drawn(population: &PairAsperities, bootstrap: Bootstrap, element: usize, k: usize) -> Result<Sample, SurfaceError> {
    let z = population.heights();
    let (size, fixed) = match bootstrap.tallest {
        TallestPeak::Fixed => (z.len(), true),
        TallestPeak::MOutOfN { exponent } if exponent > 0.0 && exponent < 1.0 => (
            ((z.len() as f64).powf(exponent).ceil() as usize).clamp(1, z.len()),
            false,
        ),
        TallestPeak::MOutOfN { exponent } => {
            return Err(SurfaceError::InvalidValue {
                field: "m-out-of-n exponent",
                value: exponent,
                unit: "1",
                requirement: "in (0, 1)",
            });
        }
    };
    let mut rng = Pcg64::seed_from_u64(mix(bootstrap.seed, element as u64, k as u64));
    let mut weights = vec![0.0; z.len()];
    for _ in 0..size {
        weights[draw(&mut rng, z.len())] += 1.0;
    }
    let tallest = weights.iter().position(|&w| w > 0.0).unwrap_or(0);
    Ok(Sample {
        weights,
        total: size as f64,
        start: if fixed {
            0.0
        } else {
            population.contact_height() - z[tallest]
        },
    })
}

/// Bootstrap realisation `k` of `element`'s population: the sample behind the `k`-th curve of [`bootstrap_bands`].
///
/// Heights are drawn with replacement; area, count and radii stay. With [`TallestPeak::Fixed`] the contact height is
/// the population's, which the drawn heights need not reach. Depends on nothing but its arguments.
///
/// # Errors
/// An exponent outside (0, 1).
pub fn realisation(
    population: &PairAsperities,
    bootstrap: Bootstrap,
    element: usize,
    k: usize,
) -> Result<PairAsperities, SurfaceError> {
    let sample = drawn(population, bootstrap, element, k)?;
    Ok(population.redrawn(&sample.weights, sample.start))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::tests::{population, steel, uniform};
    use crate::response::traction_curves;

    #[test]
    fn bands_enclose_the_sample_are_seeded_and_differ_between_elements() {
        let mut rng = Pcg64::seed_from_u64(3);
        let pop = population((0..300).map(|_| -1e-6 * uniform(&mut rng).ln()).collect());
        let u: Vec<f64> = (1..40).map(|k| 0.2e-6 * f64::from(k)).collect();
        let bands = |seed, element, tallest| {
            let b = Bootstrap {
                realisations: 200,
                seed,
                tallest,
            };
            bootstrap_bands(&pop, steel(), TangentialReading::Mindlin, &u, b, element)
                .unwrap()
                .unwrap()
        };
        let curves = traction_curves(&pop, steel(), TangentialReading::Mindlin, &u).unwrap();
        let first = bands(1, 7, TallestPeak::Fixed);
        for k in 0..u.len() {
            assert!(
                first.normal[0][k] <= curves.normal[k] && curves.normal[k] <= first.normal[1][k],
                "{k}"
            );
            assert!(first.tangential[0][0][k] <= first.tangential[0][1][k]);
        }
        // Realisations without the tallest peak carry nothing at first.
        assert_eq!(first.normal[0][0], 0.0);
        assert_eq!(first, bands(1, 7, TallestPeak::Fixed));
        assert_ne!(first, bands(1, 8, TallestPeak::Fixed));
        assert_ne!(first, bands(2, 7, TallestPeak::Fixed));
        let subsampled = bands(1, 7, TallestPeak::MOutOfN { exponent: 0.75 });
        assert!(subsampled.normal[0][0] > 0.0);
        let none = Bootstrap {
            realisations: 0,
            ..Bootstrap::default()
        };
        assert_eq!(
            bootstrap_bands(&pop, steel(), TangentialReading::Mindlin, &u, none, 0),
            Ok(None)
        );
        let bad = Bootstrap {
            tallest: TallestPeak::MOutOfN { exponent: 1.5 },
            ..Bootstrap::default()
        };
        assert!(bootstrap_bands(&pop, steel(), TangentialReading::Mindlin, &u, bad, 0).is_err());
    }

    #[test]
    fn resampled_normal_traction_scatters_as_theory_says() {
        // Gaussian heights: relative rms sqrt((F_3/F_1.5^2 - 1)/n) at delta = 0, F_1.5(0) = 0.43002, F_3(0) = 2 phi(0).
        let n = 400;
        let mut rng = Pcg64::seed_from_u64(17);
        let heights: Vec<f64> = (0..n)
            .map(|_| (-2.0 * uniform(&mut rng).ln()).sqrt() * (std::f64::consts::TAU * uniform(&mut rng)).cos())
            .collect();
        let pop = population(heights);
        let u = [pop.heights()[0]];
        let b = Bootstrap {
            realisations: 2000,
            ..Bootstrap::default()
        };
        let bands = bootstrap_bands(&pop, steel(), TangentialReading::Mindlin, &u, b, 0)
            .unwrap()
            .unwrap();
        let mean = traction_curves(&pop, steel(), TangentialReading::Mindlin, &u)
            .unwrap()
            .normal[0];
        let width = (bands.normal[1][0] - bands.normal[0][0]) / mean;
        let rms = ((2.0 * 0.398942 / 0.43002f64.powi(2) - 1.0) / f64::from(n)).sqrt();
        assert!((width / (2.0 * 1.96 * rms) - 1.0).abs() < 0.15, "{width} {rms}");
    }
}
