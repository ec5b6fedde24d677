//! Traction curves of asperity populations (eq. 6-14, 21-24).

use contact_laws::{ElasticPair, TangentialReading};

use crate::error::{SurfaceError, finite_samples, positive};
use crate::pair::PairAsperities;

/// Tractions against interference.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TractionCurves {
    /// Interference `u_n` (m), 0 where the tallest peaks touch.
    pub interference: Vec<f64>,
    /// Normal traction (Pa).
    pub normal: Vec<f64>,
    /// Tangential traction stiffness along x and y (Pa/m).
    pub tangential: [Vec<f64>; 2],
}

/// Traction curves of a population by sums over its heights.
///
/// With `delta = z_p - u_n` and `z_p` the tallest height, `t_n = (N/A) (2/3) E/(1-nu^2) sqrt(R) (1/N_s) sum_i
/// max(z_i - delta, 0)^(3/2)`. The mean runs over all `N_s` heights (partial expectation); `N` scales it.
/// Interferences `<= 0` give zero.
///
/// The tangential stiffness is `(N/A) 2E/((2-nu)(1+nu)) sqrt(R) (1/N_s) sum_i max(z_i - delta, 0)^(1/2)` along both
/// axes by [`TangentialReading::Mindlin`], and `(N/A) 4E/((2-nu)(1+nu)) R_q P(z > delta)` by
/// [`TangentialReading::Paper`] (eq. 22 with the missing factor N/A).
///
/// # Errors
/// An interference that is not finite, or a material that is not physical.
pub fn traction_curves(
    population: &PairAsperities,
    material: ElasticPair,
    reading: TangentialReading,
    interference: &[f64],
) -> Result<TractionCurves, SurfaceError> {
    let mut curves = curves_of(population, material, reading, interference, &[Sample::full(population)])?;
    Ok(curves.swap_remove(0))
}

/// The contact laws' requirements on the elastic constants, as errors of this crate.
pub(crate) fn check_material(material: &ElasticPair) -> Result<(), SurfaceError> {
    positive("youngs_modulus", material.youngs_modulus, "Pa")?;
    let nu = material.poisson_ratio;
    if nu > -1.0 && nu <= 0.5 {
        Ok(())
    } else {
        Err(SurfaceError::InvalidValue {
            field: "poisson_ratio",
            value: nu,
            unit: "1",
            requirement: "in (-1, 0.5]",
        })
    }
}

/// A weighted sample of a population's heights.
#[derive(Debug)]
pub(crate) struct Sample {
    /// Weight of each height, tallest first: a whole number.
    pub(crate) weights: Vec<f64>,
    pub(crate) total: f64,
    /// Depth of the height at which `u_n = 0`, below the population's own (m).
    pub(crate) start: f64,
}

impl Sample {
    fn full(population: &PairAsperities) -> Self {
        let n = population.heights().len();
        Self {
            weights: vec![1.0; n],
            total: n as f64,
            start: 0.0,
        }
    }
}

/// Curves of several samples at once: the powers of the penetrations are computed once per interference.
pub(crate) fn curves_of(
    population: &PairAsperities,
    material: ElasticPair,
    reading: TangentialReading,
    interference: &[f64],
    samples: &[Sample],
) -> Result<Vec<TractionCurves>, SurfaceError> {
    finite_samples("interference", interference, "m")?;
    check_material(&material)?;
    let z = population.heights();
    let depth: Vec<f64> = z.iter().map(|h| population.contact_height() - h).collect();
    let density = population.asperity_density();
    let root_radius = population.effective_radius().sqrt();
    // Equal elastic bodies: (2/3) E/(1 - nu^2) = (4/3) E*.
    let normal_scale = density * 4.0 / 3.0 * material.composite_modulus() * root_radius;
    let nu = material.poisson_ratio;
    let shear = 2.0 * material.youngs_modulus / ((2.0 - nu) * (1.0 + nu));
    let tangential_scale = match reading {
        TangentialReading::Mindlin => [density * shear * root_radius; 2],
        TangentialReading::Paper => population.radius().map(|r| 2.0 * density * shear * r),
    };
    let empty = || Vec::with_capacity(interference.len());
    let mut curves: Vec<_> = samples
        .iter()
        .map(|_| TractionCurves {
            interference: interference.to_vec(),
            normal: empty(),
            tangential: [empty(), empty()],
        })
        .collect();
    let (mut root, mut power) = (vec![0.0; z.len()], vec![0.0; z.len()]);
    for &u in interference {
        let mut reached = f64::NEG_INFINITY;
        let mut touching = 0;
        for (sample, curve) in samples.iter().zip(&mut curves) {
            let reach = if u > 0.0 { u + sample.start } else { 0.0 };
            if reach != reached {
                reached = reach;
                touching = depth.partition_point(|&s| s < reach);
                for k in 0..touching {
                    let w = reach - depth[k];
                    root[k] = w.sqrt();
                    power[k] = w * root[k];
                }
            }
            let weights = &sample.weights[..touching];
            curve
                .normal
                .push(normal_scale * dot(weights, &power[..touching]) / sample.total);
            let sum = match reading {
                TangentialReading::Mindlin => dot(weights, &root[..touching]),
                TangentialReading::Paper => weights.iter().sum(),
            };
            for q in 0..2 {
                curve.tangential[q].push(tangential_scale[q] * sum / sample.total);
            }
        }
    }
    Ok(curves)
}

/// Dot product in eight interleaved partial sums: vectorises, and its order is fixed.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a8, a_rest) = a.as_chunks::<8>();
    let (b8, b_rest) = b.as_chunks::<8>();
    for (x, y) in a8.iter().zip(b8) {
        for k in 0..8 {
            lanes[k] += x[k] * y[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    lanes.iter().sum::<f64>() + rest
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use contact_laws::{AsperitySumCurves, ContactCurves};
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    pub(crate) fn steel() -> ElasticPair {
        ElasticPair {
            youngs_modulus: 192.85e9,
            poisson_ratio: 0.29,
        }
    }

    pub(crate) fn population(heights: Vec<f64>) -> PairAsperities {
        PairAsperities::try_new(4e-6, 50.0, [1e-3, 4e-3], 2e-3, heights).unwrap()
    }

    pub(crate) fn uniform(rng: &mut Pcg64) -> f64 {
        ((rng.next_u64() >> 11) as f64 + 0.5) * 2f64.powi(-53)
    }

    #[test]
    fn one_height_gives_hertz_and_mindlin() {
        let u = [-1e-6, 0.0, 1e-6, 5e-6];
        let curves = traction_curves(&population(vec![3e-6]), steel(), TangentialReading::Mindlin, &u).unwrap();
        assert_eq!(
            (curves.normal[0], curves.normal[1], curves.tangential[0][1]),
            (0.0, 0.0, 0.0)
        );
        for k in 2..4 {
            // 4/3 E* sqrt(R) w^1.5 with E* = E/(2(1 - nu^2)) and 8 G* a with a = sqrt(R w) for equal bodies.
            let composite = 192.85e9 / (2.0 * (1.0 - 0.29f64.powi(2)));
            let force = 4.0 / 3.0 * composite * 2e-3f64.sqrt() * u[k].powf(1.5);
            assert!((curves.normal[k] / (50.0 / 4e-6 * force) - 1.0).abs() < 1e-13);
            let shear = 192.85e9 / (2.0 * 1.29);
            let stiffness = 8.0 * (shear / (2.0 * (2.0 - 0.29))) * (2e-3 * u[k]).sqrt();
            assert!((curves.tangential[0][k] / (50.0 / 4e-6 * stiffness) - 1.0).abs() < 1e-13);
            assert_eq!(curves.tangential[0][k], curves.tangential[1][k]);
        }
    }

    #[test]
    fn stiffness_ratio_is_mindlins() {
        let heights: Vec<f64> = (0..57).map(|k| 1e-7 * f64::from(k * k % 31)).collect();
        let h = 1e-10;
        // Away from the heights themselves, where the sums have a kink.
        let u = [2.04e-6 - h, 2.04e-6, 2.04e-6 + h];
        let c = traction_curves(&population(heights), steel(), TangentialReading::Mindlin, &u).unwrap();
        let normal_stiffness = (c.normal[2] - c.normal[0]) / (2.0 * h);
        let ratio = 2.0 * (1.0 - 0.29) / (2.0 - 0.29);
        assert!((c.tangential[0][1] / normal_stiffness / ratio - 1.0).abs() < 1e-6);
    }

    #[test]
    fn curves_agree_with_the_contact_laws_asperity_sum() {
        let mut rng = Pcg64::seed_from_u64(23);
        let pop = population((0..200).map(|_| -1e-6 * uniform(&mut rng).ln()).collect());
        let u: Vec<f64> = (0..30).map(|k| 0.03e-6 * 1.25f64.powi(k)).collect();
        for reading in [TangentialReading::Mindlin, TangentialReading::Paper] {
            let law = AsperitySumCurves::try_new(pop.law_population().unwrap(), steel(), reading).unwrap();
            let curves = traction_curves(&pop, steel(), reading, &u).unwrap();
            for (k, &u) in u.iter().enumerate() {
                assert!((curves.normal[k] / law.normal(u).0 - 1.0).abs() < 1e-12);
                for q in 0..2 {
                    assert!((curves.tangential[q][k] / law.tangential(u)[q].value - 1.0).abs() < 1e-12);
                }
            }
        }
        let bad = ElasticPair {
            youngs_modulus: 1.0,
            poisson_ratio: 0.6,
        };
        assert!(traction_curves(&pop, bad, TangentialReading::Mindlin, &u).is_err());
    }

    #[test]
    fn exponential_heights_follow_the_closed_form_within_sampling_error() {
        // E[(z - delta)_+^1.5] = s^1.5 Gamma(5/2) exp(-delta/s); the tallest of the sample fixes delta.
        let (s, n) = (0.8e-6, 200_000);
        let mut rng = Pcg64::seed_from_u64(11);
        let heights: Vec<f64> = (0..n).map(|_| -s * uniform(&mut rng).ln()).collect();
        let pop = population(heights);
        let tallest = pop.heights()[0];
        // Interferences that leave delta at 1, 2 and 3 scales.
        let u: Vec<f64> = [3.0, 2.0, 1.0].iter().map(|k| tallest - k * s).collect();
        let c = traction_curves(&pop, steel(), TangentialReading::Paper, &u).unwrap();
        let scale = 50.0 / 4e-6 * 2.0 / 3.0 * 192.85e9 / (1.0 - 0.29f64.powi(2)) * 2e-3f64.sqrt();
        for (k, delta) in [3.0f64, 2.0, 1.0].iter().enumerate() {
            let gamma = 0.75 * std::f64::consts::PI.sqrt();
            let expected = scale * s.powf(1.5) * gamma * (-delta).exp();
            // Relative standard error sqrt((Gamma(4) e^delta / Gamma(5/2)^2 - 1)/n), below 2 % here; 4 sigma.
            let sigma = ((6.0 * delta.exp() / (gamma * gamma) - 1.0) / f64::from(n)).sqrt();
            let error = c.normal[k] / expected - 1.0;
            assert!(error.abs() < 4.0 * sigma, "delta {delta}: {error} against {sigma}");
            let p = 4.0 * 50.0 / 4e-6 * 192.85e9 / (1.71 * 1.29) * (-delta).exp();
            let sigma_p = ((delta.exp() - 1.0) / f64::from(n)).sqrt();
            for (q, r) in [1e-3, 4e-3].iter().enumerate() {
                assert!((c.tangential[q][k] / (p * r) - 1.0).abs() < 4.0 * sigma_p);
            }
        }
    }

    #[test]
    fn measured_from_the_tallest_the_sums_follow_the_truncated_exponential() {
        // Given the tallest at depth 0, the other depths are exponential above exp(-v): with one tallest and v = u/s,
        // E[sum w^1.5] = s^1.5 (v^1.5 + e^v gamma(5/2, v)) and E[number touching] = e^v, for a large sample.
        let (s, n, draws) = (1.0f64, 400usize, 4000usize);
        let v = 2.0f64;
        let mut rng = Pcg64::seed_from_u64(5);
        let (mut sums, mut counts) = (Vec::new(), 0.0);
        let unit = ElasticPair {
            youngs_modulus: 1.5 * 0.75,
            poisson_ratio: 0.5,
        };
        for _ in 0..draws {
            let heights: Vec<f64> = (0..n).map(|_| -s * uniform(&mut rng).ln()).collect();
            let pop = PairAsperities::try_new(1.0, n as f64, [1.0; 2], 1.0, heights).unwrap();
            let c = traction_curves(&pop, unit, TangentialReading::Mindlin, &[v]).unwrap();
            sums.push(c.normal[0]);
            counts += pop.heights().iter().filter(|z| pop.heights()[0] - *z < v).count() as f64;
        }
        let mean = sums.iter().sum::<f64>() / draws as f64;
        let sigma = (sums.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (draws as f64).powi(2)).sqrt();
        // gamma(5/2, v) by Simpson's rule after t = r^2.
        let m = 2000;
        let h = v.sqrt() / f64::from(m);
        let f = |r: f64| 2.0 * r.powi(4) * (-r * r).exp();
        let gamma: f64 = (0..=m)
            .map(|k| {
                f(f64::from(k) * h)
                    * if k == 0 || k == m {
                        1.0
                    } else {
                        f64::from(2 + 2 * (k % 2))
                    }
            })
            .sum::<f64>()
            * h
            / 3.0;
        let expected = v.powf(1.5) + v.exp() * gamma;
        // The finite sample adds a bias of order e^v / n, about 2 %.
        assert!(
            (mean - expected).abs() < 4.0 * sigma + 0.02 * expected,
            "{mean} against {expected} +- {sigma}"
        );
        assert!(
            (counts / draws as f64 / v.exp() - 1.0).abs() < 0.06,
            "{}",
            counts / draws as f64
        );
    }
}
