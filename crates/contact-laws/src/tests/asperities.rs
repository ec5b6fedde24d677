//! Asperity sums against closed forms for exponential and Gaussian heights and against single contacts.

use super::{STEEL, asperities, exponential_gaps, relative};
use crate::*;

fn single(gap: f64, density: f64, radii: [f64; 2], reading: TangentialReading) -> AsperitySumCurves {
    let gaps = GapDistribution::try_from_samples(vec![gap]).unwrap();
    AsperitySumCurves::try_new(
        AsperityPopulation::try_new(gaps, density, radii).unwrap(),
        STEEL,
        reading,
    )
    .unwrap()
}

#[test]
fn one_asperity_is_one_hertz_and_mindlin_contact() {
    let (density, radius, w) = (3e6, 2e-3, 4e-7);
    let curves = single(1e-7, density, [radius; 2], TangentialReading::Mindlin);
    let (t, slope) = curves.normal(1e-7 + w);
    assert!(relative(t, density * hertz::force(&STEEL, radius, w)) < 1e-14);
    assert!(relative(slope, density * hertz::stiffness(&STEEL, radius, w)) < 1e-14);
    let [x, y] = curves.tangential(1e-7 + w);
    assert!(relative(x.value, density * mindlin::stiffness(&STEEL, radius, w)) < 1e-14);
    assert_eq!(x, y);
    let area = std::f64::consts::PI * hertz::contact_radius(radius, w).powi(2) * density;
    assert!(relative(curves.contact_area_ratio(1e-7 + w).unwrap(), area) < 1e-14);
    // Nothing touches before the gap is closed.
    assert_eq!(
        (curves.normal(1e-7), curves.tangential(5e-8)[0]),
        ((0.0, 0.0), Jet::default())
    );
    assert_eq!(curves.contact_area_ratio(5e-8), Some(0.0));

    // As published: 4 E beta_q / ((2 - nu)(1 + nu)) per asperity, here with different radii.
    let paper = single(1e-7, density, [1e-3, 2e-3], TangentialReading::Paper);
    let [x, y] = paper.tangential(1e-7 + w);
    assert!(relative(x.value, density * 4.0 * 192.85e9 * 1e-3 / (1.71 * 1.29)) < 1e-14);
    assert_eq!(y.value, 2.0 * x.value);
}

/// Exponential heights: `integral (z - delta)^n phi dz = sigma^n Gamma(n + 1) exp(-delta/sigma)`. The pieces of uniform
/// density approach it with the square of their width.
#[test]
fn exponential_heights() {
    let sigma = 2e-6;
    let moments = |n: usize, delta: f64| {
        let gaps = exponential_gaps(sigma, n);
        let u = (30.0 - delta) * sigma;
        let ((m32, m12), half) = (gaps.three_halves_moment(u), gaps.half_moment(u));
        assert!(relative(m12, half.value) < 1e-14);
        [
            m32,
            m12,
            gaps.mean_interference(u),
            gaps.loaded_fraction(u),
            2.0 * half.slope,
        ]
    };
    let root_pi = std::f64::consts::PI.sqrt();
    for delta in [3.0_f64, 8.0] {
        let scale = -(-delta).exp() / (-30.0_f64).exp_m1();
        let exact = [
            sigma.powf(1.5) * 0.75 * root_pi,
            sigma.sqrt() * 0.5 * root_pi,
            sigma,
            1.0,
            // Gamma(1/2) sigma^(-1/2)
            root_pi / sigma.sqrt(),
        ]
        .map(|m| m * scale);
        let (coarse, fine) = (moments(3000, delta), moments(12_000, delta));
        for i in 0..5 {
            let errors = [relative(coarse[i], exact[i]), relative(fine[i], exact[i])];
            println!("delta/sigma = {delta}, moment {i}: {errors:?}");
            // Second order, but 3/2 for the least smooth moment and nothing to gain for the probability.
            let (largest, gain) = [(1e-6, 15.0), (1e-6, 15.0), (1e-6, 15.0), (1e-9, 0.0), (1e-4, 7.0)][i];
            assert!(errors[1] < largest && errors[0] >= gain * errors[1], "{i} {errors:?}");
        }
    }
}

/// The same through samples, spread evenly in probability.
#[test]
fn exponential_heights_from_samples() {
    let (sigma, n) = (2e-6, 200_000);
    let heights: Vec<f64> = (0..n)
        .map(|i| -sigma * ((f64::from(i) + 0.5) / f64::from(n)).ln())
        .collect();
    let tallest = heights[0];
    let gaps = GapDistribution::try_from_samples(heights.iter().map(|z| tallest - z).collect()).unwrap();
    assert_eq!(
        (gaps.smallest(), gaps.largest()),
        (0.0, tallest - heights[n as usize - 1])
    );
    let delta: f64 = 2.0;
    let (m32, m12) = gaps.three_halves_moment(tallest - delta * sigma);
    let root_pi = std::f64::consts::PI.sqrt();
    assert!(relative(m32, sigma.powf(1.5) * 0.75 * root_pi * (-delta).exp()) < 1e-3);
    assert!(relative(m12, sigma.sqrt() * 0.5 * root_pi * (-delta).exp()) < 1e-3);
    assert!(relative(gaps.mean_interference(tallest - delta * sigma), sigma * (-delta).exp()) < 1e-3);
    assert!(relative(gaps.loaded_fraction(tallest - delta * sigma), (-delta).exp()) < 1e-3);
}

/// Gaussian heights: `F_n(h) = integral from h of (t - h)^n phi(t) dt`. At `h = 0` this is
/// `2^(n/2 - 1) Gamma((n + 1)/2)/sqrt(pi)`: `F_{3/2} = 0.43002`, `F_{1/2} = 0.41109`, `F_1 = 1/sqrt(2 pi)`.
#[test]
fn gaussian_heights() {
    let (n, tallest) = (16_000, 8.0);
    let gaps: Vec<f64> = (0..=n).map(|i| 2.0 * tallest * f64::from(i) / f64::from(n)).collect();
    // Probabilities by the midpoint rule over each piece, then made to end at 1.
    let width = gaps[1];
    let mut sum = 0.0;
    let mut probabilities = vec![0.0];
    for s in &gaps[..n as usize] {
        let z = tallest - s - 0.5 * width;
        sum += width * (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
        probabilities.push(sum);
    }
    assert!((sum - 1.0).abs() < 1e-9);
    let probabilities: Vec<f64> = probabilities.iter().map(|p| p / sum).collect();
    let gaps = GapDistribution::try_from_quantiles(&probabilities, &gaps).unwrap();
    let ((f32_, f12), f1) = (gaps.three_halves_moment(tallest), gaps.mean_interference(tallest));
    println!("F_3/2(0) = {f32_}, F_1/2(0) = {f12}, F_1(0) = {f1}");
    assert!((f32_ - 0.43002).abs() < 1e-5);
    assert!((f12 - 0.41109).abs() < 1e-4);
    assert!(relative(f1, 1.0 / (2.0 * std::f64::consts::PI).sqrt()) < 1e-6);
    assert!((gaps.loaded_fraction(tallest) - 0.5).abs() < 1e-9);
}

/// Pieces much narrower than the interference, down to zero width, lose no digits: they are samples.
#[test]
fn narrow_pieces_are_samples() {
    let samples = GapDistribution::try_from_samples(vec![1e-6, 2e-6]).unwrap();
    for width in [0.0, 1e-18, 1e-14] {
        let values = [
            1e-6 - 0.5 * width,
            1e-6 + 0.5 * width,
            2e-6 - 0.5 * width,
            2e-6 + 0.5 * width,
        ];
        let pieces = GapDistribution::try_from_quantiles(&[0.0, 0.5, 0.5, 1.0], &values).unwrap();
        for u in [2.5e-6, 1e-5, 1e-2] {
            let (a, b) = (samples.three_halves_moment(u), pieces.three_halves_moment(u));
            assert!(
                relative(a.0, b.0) < 3e-15 && relative(a.1, b.1) < 3e-15,
                "{width:e} {u:e} {a:?} {b:?}"
            );
            assert!(relative(samples.half_moment(u).curvature, pieces.half_moment(u).curvature) < 1e-13);
        }
    }
}

/// Derivatives returned are those of the values.
#[test]
fn curves_and_their_derivatives_agree() {
    for reading in [TangentialReading::Mindlin, TangentialReading::Paper] {
        let curves = asperities(reading);
        for u in [1.3e-8, 3.31e-7, 4.07e-6, 1.21e-5, 1.6e-5] {
            let h = 1e-5 * u;
            let (low, high) = (curves.normal(u - h), curves.normal(u + h));
            assert!(
                relative((high.0 - low.0) / (2.0 * h), curves.normal(u).1) < 1e-7,
                "{u:e}"
            );
            let (low, high) = (curves.tangential(u - h)[0], curves.tangential(u + h)[0]);
            let here = curves.tangential(u)[0];
            assert!(
                relative((high.value - low.value) / (2.0 * h), here.slope) < 1e-5,
                "{u:e}"
            );
            if reading == TangentialReading::Mindlin {
                let difference = (high.slope - low.slope) / (2.0 * h);
                assert!((difference - here.curvature).abs() < 1e-3 * here.slope / u, "{u:e}");
            }
        }
    }
}

/// `dt_n/du_n` and Mindlin's `k_t` are in the ratio of single contacts.
#[test]
fn stiffness_ratio_is_mindlins() {
    let curves = asperities(TangentialReading::Mindlin);
    for u in [1e-9, 1e-7, 1e-5, 1e-3] {
        let ratio = curves.tangential(u)[1].value / curves.normal(u).1;
        assert!(relative(ratio, 2.0 * 0.71 / 1.71) < 1e-13);
    }
}

#[test]
fn yield_is_a_fraction_of_the_loaded_asperities() {
    // Gaps 0, 1, 2, 3 um under 2.5 um: interferences 2.5, 1.5, 0.5 um.
    let gaps = GapDistribution::try_from_samples(vec![3e-6, 0.0, 2e-6, 1e-6]).unwrap();
    let population = AsperityPopulation::try_new(gaps, 1e6, [1e-3; 2]).unwrap();
    let curves = AsperitySumCurves::try_new(population, STEEL, TangentialReading::Mindlin).unwrap();
    let yielded = |omega_c| curves.yielded_fraction(2.5e-6, omega_c).unwrap();
    assert!(relative(yielded(1e-6), 2.0 / 3.0) < 1e-15);
    assert_eq!((yielded(0.0), yielded(3e-6)), (1.0, 0.0));
    assert_eq!(curves.yielded_fraction(0.0, 1e-6), Some(0.0));
}
