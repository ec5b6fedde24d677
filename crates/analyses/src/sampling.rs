//! Samples of uncertain inputs.

use crate::Error;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use scenes::distribution::{cholesky, standard_normal};
use scenes::{SamplingMethod, Scene, Uncertain};

/// Half the distance between neighbouring points of the sequence along a direction, which has 24 bits: points lie in the middle of their
/// intervals, so that none is 0.
const HALF: f64 = 1.0 / 33_554_432.0;

/// Points of the sequence that the direction numbers are for.
const LONGEST: usize = 65_536;

/// Points in the unit cube, point by point.
///
/// # Errors
/// More points or directions than Sobol's sequence has, in words.
pub fn unit_cube(method: SamplingMethod, seed: u64, points: usize, dimensions: usize) -> Result<Vec<Vec<f64>>, String> {
    let directions = sobol_burley::NUM_DIMENSIONS as usize;
    if method == SamplingMethod::Sobol && (dimensions > directions || points > LONGEST) {
        return Err(format!(
            "Sobol's sequence has {LONGEST} points in {directions} directions here, and {points} in {dimensions} are needed; take \
             \"latin-hypercube\""
        ));
    }
    Ok(match method {
        SamplingMethod::LatinHypercube => latin_hypercube(seed, points, dimensions),
        SamplingMethod::Sobol => {
            // Both halves of the seed count.
            let seed = (seed ^ (seed >> 32)) as u32;
            let coordinate =
                |point: usize, axis: usize| f64::from(sobol_burley::sample(point as u32, axis as u32, seed)) + HALF;
            let point = |point: usize| (0..dimensions).map(|axis| coordinate(point, axis)).collect();
            (0..points).map(point).collect()
        }
    })
}

fn latin_hypercube(seed: u64, points: usize, dimensions: usize) -> Vec<Vec<f64>> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut cube = vec![vec![0.0; dimensions]; points];
    let mut intervals: Vec<usize> = (0..points).collect();
    for axis in 0..dimensions {
        intervals.shuffle(&mut random);
        for (point, interval) in cube.iter_mut().zip(&intervals) {
            let within: f64 = random.random();
            point[axis] = (*interval as f64 + within.max(HALF)) / points as f64;
        }
    }
    cube
}

/// Two sets of samples that are independent of each other, each sample a value (SI) per parameter of `uncertain`. The first one is the same
/// whether the second is asked for or not.
///
/// # Errors
/// Those of a scene with such inputs.
pub(crate) fn samples(
    uncertain: &Uncertain,
    scene: &Scene,
    seed: u64,
    number: usize,
    second: bool,
) -> Result<[Vec<Vec<f64>>; 2], Error> {
    let marginals = uncertain.marginals(scene)?;
    let factor = cholesky(&uncertain.correlation()?).map_err(|reason| scenes::Error::Uncertain {
        field: "correlations".into(),
        reason,
    })?;
    let k = marginals.len();
    let sets = if second { 2 } else { 1 };
    let cube = unit_cube(uncertain.method, seed, number, sets * k).map_err(|reason| scenes::Error::Uncertain {
        field: "method".into(),
        reason,
    })?;
    let shaped = |point: &[f64]| -> Vec<f64> {
        let normal: Vec<f64> = point.iter().map(|p| standard_normal(*p)).collect();
        let correlated = factor
            .iter()
            .map(|row| row.iter().zip(&normal).map(|(l, z)| l * z).sum::<f64>());
        marginals
            .iter()
            .zip(correlated)
            .map(|(marginal, z)| marginal.at(z))
            .collect()
    };
    let set = |first: usize| cube.iter().map(|point| shaped(&point[first..first + k])).collect();
    Ok([set(0), if second { set(k) } else { Vec::new() }])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_interval_of_a_latin_hypercube_has_one_sample() {
        for points in [1, 7, 100] {
            let cube = unit_cube(SamplingMethod::LatinHypercube, 3, points, 4).unwrap();
            for axis in 0..4 {
                let mut intervals: Vec<usize> = cube.iter().map(|p| (p[axis] * points as f64) as usize).collect();
                intervals.sort_unstable();
                assert_eq!(intervals, (0..points).collect::<Vec<_>>(), "axis {axis}");
            }
        }
        let [a, b] = [3, 4].map(|seed| unit_cube(SamplingMethod::LatinHypercube, seed, 50, 2).unwrap());
        assert_ne!(a, b);
        // Axes are independent.
        let covariance = a.iter().map(|p| (p[0] - 0.5) * (p[1] - 0.5)).sum::<f64>() / 50.0;
        assert!(covariance.abs() < 3.0 / 12.0 / 50_f64.sqrt(), "{covariance}");
    }

    #[test]
    fn sobols_sequence_is_a_net_in_every_pair_of_its_first_directions() {
        // 64 points: one in each of the 64 intervals of every direction, and 16 in each quarter of the first pair.
        let cube = unit_cube(SamplingMethod::Sobol, 5, 64, 6).unwrap();
        for axis in 0..6 {
            let mut intervals: Vec<usize> = cube.iter().map(|p| (p[axis] * 64.0) as usize).collect();
            intervals.sort_unstable();
            assert_eq!(intervals, (0..64).collect::<Vec<_>>(), "axis {axis}");
        }
        let quarter = cube.iter().filter(|p| p[0] < 0.5 && p[1] < 0.5).count();
        assert_eq!(quarter, 16);
        // The integral of a product of all is far more exact than that of as many random points.
        let points = unit_cube(SamplingMethod::Sobol, 5, 4096, 3).unwrap();
        let integral = points.iter().map(|p| 8.0 * p[0] * p[1] * p[2]).sum::<f64>() / 4096.0;
        assert!((integral - 1.0).abs() < 2e-3, "{integral}");
    }

    #[test]
    fn samples_have_the_correlations_asked_for() {
        use scenes::{Distribution, Normal, NumberOrText, Parameter};
        use std::collections::BTreeMap;
        let text = serde_json::json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "matrices": {
                "path": "K.mtx", "coordinates": "jump",
                "points": [{ "node": 1 }],
                "response": { "terms": [] }
            } },
            "model": { "material": { "youngs_modulus": 2e11, "poisson_ratio": 0.3 } },
            "interfaces": { "mu": 0.2, "surface": { "parameters": { "per": "interface", "sets": [{
                "curves": { "elastic": { "normal_stiffness": 1e13, "tangential_stiffness": [7e12, 7e12] } } }] } } },
            "bolts": { "load": 1000.0 }
        });
        let scene = Scene::from_summary(&text, &[]).unwrap();
        let normal = |mean: f64, sd: f64| Distribution {
            normal: Some(Normal {
                mean: Some(NumberOrText::Number(mean)),
                sd: Some(NumberOrText::Number(sd)),
                cov: None,
            }),
            ..Distribution::default()
        };
        let [mu, load] = ["interfaces.mu", "bolts.load"].map(Parameter::new);
        let mut uncertain = Uncertain {
            parameters: BTreeMap::from([(mu.clone(), normal(0.2, 0.02)), (load.clone(), normal(1000.0, 50.0))]),
            correlations: vec![(mu, load, 0.5)],
            method: SamplingMethod::Sobol,
            seed: 1,
            confidence: 0.9,
            sobol_indices: false,
            law_error: None,
        };
        for method in [SamplingMethod::Sobol, SamplingMethod::LatinHypercube] {
            uncertain.method = method;
            let [first, second] = samples(&uncertain, &scene, 1, 4096, true).unwrap();
            assert_eq!(first, samples(&uncertain, &scene, 1, 4096, false).unwrap()[0]);
            for set in [&first, &second] {
                let n = set.len() as f64;
                let mean = |axis: usize| set.iter().map(|s| s[axis]).sum::<f64>() / n;
                let of = |i: usize, j: usize| set.iter().map(|s| (s[i] - mean(i)) * (s[j] - mean(j))).sum::<f64>() / n;
                // The load comes first: parameters are in the order of their paths.
                assert!((mean(0) / 1000.0 - 1.0).abs() < 1e-3 && (mean(1) / 0.2 - 1.0).abs() < 2e-3);
                assert!((of(0, 0).sqrt() / 50.0 - 1.0).abs() < 0.02 && (of(1, 1).sqrt() / 0.02 - 1.0).abs() < 0.02);
                let correlation = of(0, 1) / (of(0, 0) * of(1, 1)).sqrt();
                assert!((correlation - 0.5).abs() < 0.03, "{method:?} {correlation}");
            }
            let cross = first
                .iter()
                .zip(&second)
                .map(|(a, b)| (a[1] - 0.2) * (b[1] - 0.2))
                .sum::<f64>()
                / 4096.0;
            assert!((cross / 0.02_f64.powi(2)).abs() < 0.06);
        }
    }
}
