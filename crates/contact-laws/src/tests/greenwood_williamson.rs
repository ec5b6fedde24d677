//! Closed forms of exponential and Gaussian heights against quadrature, asperity sums and sampling.

use super::{STEEL, relative};
use crate::physics::heights::HalfMoments;
use crate::*;
use std::f64::consts::{PI, TAU};

const EXPONENTIAL: HeightDistribution = HeightDistribution::Exponential { scale: 2e-6 };
const GAUSSIAN: HeightDistribution = HeightDistribution::Gaussian {
    standard_deviation: 2e-6,
};
const SCALE: f64 = 2e-6;

fn surface(heights: HeightDistribution) -> GreenwoodWilliamsonSurface {
    GreenwoodWilliamsonSurface {
        heights,
        reference_height: match heights {
            HeightDistribution::Exponential { .. } => 7.0 * SCALE,
            HeightDistribution::Gaussian { .. } => 3.5 * SCALE,
        },
        asperity_density: 1.4e6,
        radii: [1.2e-3, 1.5e-3],
    }
}

fn curves(heights: HeightDistribution, reading: TangentialReading) -> GreenwoodWilliamsonCurves {
    GreenwoodWilliamsonCurves::try_new(surface(heights), STEEL, reading).unwrap()
}

/// `integral from 0 to infinity of s^n f(s) ds` by the double-exponential rule: independent of how the curves are made.
fn integrate(n: f64, width: f64, f: impl Fn(f64) -> f64) -> f64 {
    let step = 1.0 / 128.0;
    (-1100..=1100)
        .map(|k| {
            let t = step * f64::from(k);
            let log = 0.5 * PI * t.sinh();
            let s = width * log.exp();
            let weight = s.powf(n + 1.0) * 0.5 * PI * t.cosh() * f(s);
            if weight.is_finite() { step * weight } else { 0.0 }
        })
        .sum()
}

/// `F_n(h) e^(max(h, 0)^2/2)` for `n = 3/2, 1/2, -1/2, 0, 1`, split at the density's peak where it lies inside.
fn gaussian_integral(n: f64, h: f64) -> f64 {
    if h >= 0.0 {
        let width = 1.0 / (h + 1.0);
        return integrate(n, width, |s| (-s * (h + 0.5 * s)).exp() / TAU.sqrt());
    }
    // The part below the peak with t = h (1 - r), r = y/(1 + y): the root's singularity is at y = 0.
    let above = integrate(0.0, 1.0, |t| (t - h).powf(n) * (-0.5 * t * t).exp() / TAU.sqrt());
    let below = integrate(n, 1.0, |y| {
        let r = y / (1.0 + y);
        let t = h * (1.0 - r);
        // (t - h)^n dt without the factor y^n that the rule supplies.
        (-h).powf(n + 1.0) * (1.0 + y).powf(-n - 2.0) * (-0.5 * t * t).exp() / TAU.sqrt()
    });
    above + below
}

fn separations() -> impl Iterator<Item = f64> {
    (-240..=240)
        .map(|i| f64::from(i) / 8.0)
        .chain([-1e-9, 1e-9, -11.999, -12.001, 0.031])
}

#[test]
fn gaussian_moments_agree_with_quadrature() {
    let mut worst = [0.0_f64; 6];
    for h in separations() {
        let outside = (-0.5 * h.max(0.0) * h.max(0.0)).exp();
        let exact = [1.5, 0.5, -0.5, 0.0, 1.0].map(|n| outside * gaussian_integral(n, h));
        let HalfMoments { three_halves, half } = GAUSSIAN.half_moments(h);
        let errors = [
            relative(three_halves, exact[0]),
            relative(half.value, exact[1]),
            relative(2.0 * half.slope, exact[2]),
            relative(GAUSSIAN.loaded_fraction(h).value, exact[3]),
            relative(GAUSSIAN.first_moment(h), exact[4]),
            // By the recurrence F_{3/2} = F_{-1/2}/2 - h F_{1/2}, relative to its terms.
            (three_halves - half.slope + h * half.value).abs() / (half.slope + (h * half.value).abs()),
        ];
        worst = std::array::from_fn(|i| worst[i].max(errors[i]));
    }
    println!("F_3/2, F_1/2, F_-1/2, Q, F_1, recurrence: {worst:?}");
    assert!(worst.iter().all(|&e| e < 1e-12), "{worst:?}");
    // 2^(n/2 - 1) Gamma((n + 1)/2)/sqrt(pi), Gamma(5/4) = 0.9064024770554770780.
    let exact = 2.0_f64.powf(-0.25) * 0.906_402_477_055_477_1 / PI.sqrt();
    assert!(relative(GAUSSIAN.half_moments(0.0).three_halves, exact) < 1e-14 && (exact - 0.43002).abs() < 5e-6);
    assert!(relative(GAUSSIAN.first_moment(0.0), 1.0 / TAU.sqrt()) < 1e-14);
    assert_eq!(GAUSSIAN.loaded_fraction(0.0).value, 0.5);
}

/// `F_{3/2}(h) = sqrt(h) e^(-h^2/4) [(h^2 + 1) K_{1/4}(h^2/4) - h^2 K_{3/4}(h^2/4)]/(4 sqrt(pi))`.
#[test]
fn gaussian_moments_agree_with_bessel_functions() {
    // K_nu(x) = integral over t >= 0 of exp(-x cosh t) cosh(nu t); its trapezoidal rule converges exponentially.
    let bessel = |nu: f64, x: f64| {
        let term = |t: f64| (-x * t.cosh()).exp() * (nu * t).cosh();
        let step = 1.0 / 64.0;
        step * (0.5 * term(0.0) + (1..2000).map(|k| term(step * f64::from(k))).sum::<f64>())
    };
    for h in [0.2_f64, 0.5, 1.0, 1.7, 2.5, 4.0] {
        let x = 0.25 * h * h;
        let bracket = (h * h + 1.0) * bessel(0.25, x) - h * h * bessel(0.75, x);
        let exact = h.sqrt() * (-x).exp() * bracket / (4.0 * PI.sqrt());
        // The bracket cancels as h^4.
        assert!(
            relative(GAUSSIAN.half_moments(h).three_halves, exact) < 1e-14 * (1.0 + h.powi(4)),
            "{h}"
        );
    }
}

#[test]
fn exponential_moments_agree_with_quadrature() {
    let root_pi = PI.sqrt();
    let mut worst = [0.0_f64; 4];
    for h in separations().chain([-1e-14, -200.0, -1e5]) {
        // exp(-max(h, 0)) outside; below the support s = t - h begins at -h.
        let (outside, c) = ((-h.max(0.0)).exp(), (-h).max(0.0));
        let shifted = |n: f64| integrate(0.0, 1.0, |z| (z + c).powf(n) * (-z).exp());
        let HalfMoments { three_halves, half } = EXPONENTIAL.half_moments(h);
        let exact = if h < 0.0 {
            // With s = c + z; d/dc of E[(Z + c)^n] = n E[(Z + c)^(n-1)] also for n - 1 < -1.
            [shifted(1.5), shifted(0.5), 0.5 * shifted(-0.5), -0.25 * shifted(-1.5)]
        } else {
            [0.75 * root_pi, 0.5 * root_pi, 0.5 * root_pi, 0.5 * root_pi]
        };
        let found = [three_halves, half.value, half.slope, half.curvature];
        worst = std::array::from_fn(|i| worst[i].max(relative(found[i], outside * exact[i])));
        assert_eq!(EXPONENTIAL.loaded_fraction(h).value, outside);
        assert!(relative(EXPONENTIAL.first_moment(h), outside + c) < 1e-15);
    }
    println!("moments 3/2, 1/2 and its derivatives: {worst:?}");
    assert!(worst.iter().all(|&e| e < 1e-12), "{worst:?}");
}

/// Asperity sums over ever finer pieces of the same distribution.
#[test]
fn asperity_sums_converge_to_the_closed_forms() {
    for heights in [EXPONENTIAL, GAUSSIAN] {
        // Far enough in the tail that next to nothing is taller.
        let tallest = match heights {
            HeightDistribution::Exponential { .. } => 32.0,
            HeightDistribution::Gaussian { .. } => 8.0,
        };
        let lowest = match heights {
            HeightDistribution::Exponential { .. } => 0.0,
            HeightDistribution::Gaussian { .. } => -8.0,
        };
        let surface = GreenwoodWilliamsonSurface {
            reference_height: tallest * SCALE,
            ..surface(heights)
        };
        let closed = GreenwoodWilliamsonCurves::try_new(surface, STEEL, TangentialReading::Mindlin).unwrap();
        let errors = |n: u32, delta: f64| {
            let gaps: Vec<f64> = (0..=n)
                .map(|i| (tallest - lowest) * f64::from(i) / f64::from(n))
                .collect();
            let mut probabilities: Vec<f64> = gaps
                .iter()
                .map(|s| heights.loaded_fraction(tallest - s).value)
                .collect();
            (probabilities[0], probabilities[n as usize]) = (0.0, 1.0);
            let gaps: Vec<f64> = gaps.iter().map(|s| s * SCALE).collect();
            let gaps = GapDistribution::try_from_quantiles(&probabilities, &gaps).unwrap();
            let population = AsperityPopulation::try_new(gaps, surface.asperity_density, surface.radii).unwrap();
            let sums = AsperitySumCurves::try_new(population, STEEL, TangentialReading::Mindlin).unwrap();
            let u = (tallest - delta) * SCALE;
            let (t, t_closed) = (sums.normal(u), closed.normal(u));
            let (k, k_closed) = (sums.tangential(u)[1], closed.tangential(u)[1]);
            [
                relative(t.0, t_closed.0),
                relative(t.1, t_closed.1),
                relative(k.value, k_closed.value),
                relative(
                    sums.contact_area_ratio(u).unwrap(),
                    closed.contact_area_ratio(u).unwrap(),
                ),
                relative(
                    sums.yielded_fraction(u, SCALE).unwrap(),
                    closed.yielded_fraction(u, SCALE).unwrap(),
                ),
                relative(k.slope, k_closed.slope),
            ]
        };
        for delta in [3.0, 0.5, -1.0, -3.0] {
            let (coarse, fine) = (errors(2000, delta), errors(8000, delta));
            println!("{heights:?} h = {delta}: {coarse:?} {fine:?}");
            // Second order; 3/2 for the slope of k_t; the fraction is exact up to the shared tail.
            for i in 0..4 {
                assert!(
                    fine[i] < 6e-6 && (coarse[i] > 14.0 * fine[i] || fine[i] < 1e-12),
                    "{i} {delta}"
                );
            }
            assert!(fine[4] < 1e-12 && fine[5] < 2e-4, "{delta}");
        }
    }
}

/// Tractions of drawn populations scatter with the relative rms `sqrt((F_3/F_{3/2}^2 - 1)/N_s)`.
#[test]
fn samples_scatter_as_predicted() {
    let mut state = 20_u64;
    let mut uniform = move || {
        // SplitMix64.
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut normal = move || (-2.0 * (1.0 - uniform()).ln()).sqrt() * (TAU * uniform()).cos();
    let closed = curves(GAUSSIAN, TangentialReading::Mindlin);
    let (n_samples, n_draws) = (200, 4000);
    for h in [0.0, 1.0] {
        let tractions: Vec<f64> = (0..n_draws)
            .map(|_| {
                let heights: Vec<f64> = (0..n_samples).map(|_| normal()).collect();
                let tallest = heights.iter().fold(f64::MIN, |m, z| m.max(*z));
                let gaps = heights.iter().map(|z| (tallest - z) * SCALE).collect();
                let gaps = GapDistribution::try_from_samples(gaps).unwrap();
                let population = AsperityPopulation::try_new(gaps, 1.4e6, [1.2e-3, 1.5e-3]).unwrap();
                let sums = AsperitySumCurves::try_new(population, STEEL, TangentialReading::Mindlin).unwrap();
                sums.normal((tallest - h) * SCALE).0
            })
            .collect();
        let expected = closed.normal(closed.surface().reference_height - h * SCALE).0;
        let mean = tractions.iter().sum::<f64>() / f64::from(n_draws);
        let rms = tractions.iter().map(|t| (t / expected - 1.0).powi(2)).sum::<f64>() / f64::from(n_draws);
        // F_2 = Q - h F_1, F_3 = 2 F_1 - h F_2.
        let (q, f1) = (GAUSSIAN.loaded_fraction(h).value, GAUSSIAN.first_moment(h));
        let f3 = 2.0 * f1 - h * (q - h * f1);
        let f32_ = GAUSSIAN.half_moments(h).three_halves;
        let predicted = ((f3 / (f32_ * f32_) - 1.0) / f64::from(n_samples)).sqrt();
        println!(
            "h = {h}: mean {:.4}, rms {:.4}, predicted {predicted:.4}",
            mean / expected,
            rms.sqrt()
        );
        assert!((mean / expected - 1.0).abs() < 4.0 * predicted / f64::from(n_draws).sqrt());
        // The rms of 4000 draws is itself known to 1/sqrt(8000) and a little more, for heavier tails.
        assert!((rms.sqrt() / predicted - 1.0).abs() < 0.05);
    }
}

fn sweep(range: [f64; 2], n: u32) -> impl Iterator<Item = f64> {
    (0..=n).map(move |i| range[0] * (range[1] / range[0]).powf(f64::from(i) / f64::from(n)))
}

#[test]
fn curves_rise_and_their_derivatives_are_theirs() {
    for heights in [EXPONENTIAL, GAUSSIAN] {
        for reading in [TangentialReading::Mindlin, TangentialReading::Paper] {
            let curves = curves(heights, reading);
            let (mut before, mut worst) = ((0.0, 0.0, 0.0), [0.0_f64; 3]);
            // Exponential heights begin with a jump of their density: k_t has a kink there.
            let kinks = [curves.joint(), curves.surface().reference_height];
            for u in sweep([1e-13, 1e-2], 5000) {
                let ((t, slope), [x, y]) = (curves.normal(u), curves.tangential(u));
                let area = curves.contact_area_ratio(u).unwrap();
                // The published stiffness saturates when all asperities are loaded.
                let rounding = 1.0 - 1e-15;
                assert!(
                    t > before.0 && x.value >= rounding * before.1 && area > before.2,
                    "{heights:?} {u:e}"
                );
                assert!(slope > 0.0 && x.slope >= 0.0 && y.value >= x.value, "{u:e}");
                before = (t, x.value, area);

                let h = 3e-6 * u.min(SCALE);
                if kinks.iter().any(|kink| (u - kink).abs() < 1e3 * h) {
                    continue;
                }
                let ((t_low, _), (t_high, _)) = (curves.normal(u - h), curves.normal(u + h));
                let ([low, _], [high, _]) = (curves.tangential(u - h), curves.tangential(u + h));
                let step = (u + h) - (u - h);
                let length = u.min(SCALE);
                let errors = [
                    ((t_high - t_low) / step - slope) / slope,
                    ((high.value - low.value) / step - x.slope) * length / x.value,
                    ((high.slope - low.slope) / step - x.curvature) * length * length / x.value,
                ];
                worst = std::array::from_fn(|i| worst[i].max(errors[i].abs()));
            }
            println!("{heights:?} {reading:?}: {worst:?}");
            // A difference of two values over 3e-6 of a length, which far away are 1e4 or more times their change.
            assert!(worst.iter().all(|&e| e < 2e-5), "{worst:?}");
        }
    }
}

/// C1 where the closed forms begin, the exponents of single contacts below, and how much that changes.
#[test]
fn curves_vanish_at_first_touch() {
    for heights in [EXPONENTIAL, GAUSSIAN] {
        let curves = curves(heights, TangentialReading::Mindlin);
        let joint = curves.joint();
        assert_eq!(joint, SCALE / 16.0);
        let [a, b] = [joint * (1.0 - 1e-13), joint].map(|u| (curves.normal(u), curves.tangential(u)));
        assert!(relative(a.0.0, b.0.0) < 1e-12 && relative(a.0.1, b.0.1) < 1e-11);
        for q in 0..2 {
            assert!(relative(a.1[q].value, b.1[q].value) < 1e-12 && relative(a.1[q].slope, b.1[q].slope) < 1e-11);
        }
        let area = |u| curves.contact_area_ratio(u).unwrap();
        assert!(relative(area(joint * (1.0 - 1e-13)), area(joint)) < 1e-12);
        let slope = |u: f64| (area(u * (1.0 + 1e-6)) - area(u * (1.0 - 1e-6))) / (2e-6 * u);
        assert!(relative(slope((1.0 - 1e-5) * joint), slope((1.0 + 1e-5) * joint)) < 1e-3);

        let u = 1e-9 * joint;
        let (t, k) = (curves.normal(u), curves.tangential(u)[0]);
        assert!((t.1 * u / t.0 - 1.5).abs() < 1e-8 && (k.slope * u / k.value - 0.5).abs() < 1e-8);
        assert!((curves.exponents().normal, curves.exponents().tangential) == (1.5, [0.5; 2]));
        assert_eq!((area(0.0), area(-1e-6)), (0.0, 0.0));
        assert_eq!(curves.yielded_fraction(0.0, 0.0), Some(0.0));
        assert_eq!(curves.yielded_fraction(1e-9, 0.0), Some(1.0));

        // The closed form below the joint is that of a population of the same asperities with a longer way to go.
        let moment = |u: f64| {
            heights
                .half_moments((curves.surface().reference_height - u) / SCALE)
                .three_halves
        };
        let end = curves.normal(joint).0;
        let closed = |u: f64| end * moment(u) / moment(joint);
        let n = 2000;
        let (mut largest, mut work) = (0.0_f64, 0.0);
        for i in 0..n {
            let u = joint * (f64::from(i) + 0.5) / f64::from(n);
            let change = closed(u) - curves.normal(u).0;
            assert!(change >= 0.0);
            largest = largest.max(change);
            work += change / f64::from(n);
        }
        let far = curves.surface().reference_height - SCALE / 2.0;
        println!(
            "{heights:?}: change {:.3}, work {:.3} of joint; joint/t_n(scale) {:.4}, joint/t_n({:.1} scales) {:.1e}",
            largest / end,
            work / end,
            end / curves.normal(SCALE).0,
            far / SCALE,
            end / curves.normal(far).0,
        );
        assert!(largest <= end && work < 0.35 * end);
    }
}

#[test]
fn stiffness_ratio_is_mindlins() {
    for heights in [EXPONENTIAL, GAUSSIAN] {
        let curves = curves(heights, TangentialReading::Mindlin);
        for u in sweep([curves.joint(), 1e-3], 200) {
            let ratio = curves.tangential(u)[1].value / curves.normal(u).1;
            assert!(relative(ratio, 2.0 * 0.71 / 1.71) < 1e-13, "{u:e}");
        }
    }
}

/// When every asperity is loaded, the published stiffness of each is all there is: 4 E beta_q/((2 - nu)(1 + nu)).
#[test]
fn published_stiffness_saturates() {
    for heights in [EXPONENTIAL, GAUSSIAN] {
        let curves = curves(heights, TangentialReading::Paper);
        let [x, y] = curves.tangential(1e-3);
        let all = 1.4e6 * 4.0 * STEEL.youngs_modulus / (1.71 * 1.29);
        assert!(relative(x.value, all * 1.2e-3) < 1e-14 && relative(y.value, all * 1.5e-3) < 1e-14);
        assert_eq!((x.slope, x.curvature), (0.0, 0.0));
        let fraction = heights
            .loaded_fraction(curves.surface().reference_height / SCALE - 1.0)
            .value;
        assert!(relative(curves.tangential(SCALE)[0].value, all * 1.2e-3 * fraction) < 1e-13);
    }
}

/// In millimetres, tonnes and seconds the same to rounding; with lengths in units of powers of two, bit by bit.
#[test]
fn curves_do_not_depend_on_the_unit() {
    let make = |heights: HeightDistribution, length: f64, pressure: f64| {
        let surface = surface(heights);
        let heights = match heights {
            HeightDistribution::Exponential { scale } => HeightDistribution::Exponential { scale: scale * length },
            HeightDistribution::Gaussian { standard_deviation } => HeightDistribution::Gaussian {
                standard_deviation: standard_deviation * length,
            },
        };
        let surface = GreenwoodWilliamsonSurface {
            heights,
            reference_height: surface.reference_height * length,
            asperity_density: surface.asperity_density / (length * length),
            radii: surface.radii.map(|r| r * length),
        };
        let material = ElasticPair::new(STEEL.youngs_modulus * pressure, STEEL.poisson_ratio);
        GreenwoodWilliamsonCurves::try_new(surface, material, TangentialReading::Mindlin).unwrap()
    };
    let numbers = |curves: &GreenwoodWilliamsonCurves, u: f64, length: f64, pressure: f64| {
        let ((t, slope), [x, y]) = (curves.normal(u * length), curves.tangential(u * length));
        let si = 1.0 / pressure;
        [
            t * si,
            slope * length * si,
            x.value * length * si,
            x.slope * length * length * si,
            y.curvature * length * length * length * si,
            curves.contact_area_ratio(u * length).unwrap(),
            curves.yielded_fraction(u * length, 1e-6 * length).unwrap(),
        ]
    };
    for heights in [EXPONENTIAL, GAUSSIAN] {
        let (si, mm, octaves) = (
            make(heights, 1.0, 1.0),
            make(heights, 1e3, 1e-6),
            make(heights, 2048.0, 1.0),
        );
        for u in sweep([1e-10, 1e-4], 500) {
            let a = numbers(&si, u, 1.0, 1.0);
            let b = numbers(&mm, u, 1e3, 1e-6);
            // Curvatures pass through zero: relative to what they are made of.
            let of = a[2] / u.min(SCALE).powi(2);
            assert!((a[4] - b[4]).abs() < 1e-12 * of.max(a[4].abs()), "{u:e}");
            for i in [0, 1, 2, 3, 5, 6] {
                assert!(
                    relative(a[i], b[i]) < 1e-12,
                    "{heights:?} {u:e} {i} {:e}",
                    relative(a[i], b[i])
                );
            }
            assert_eq!(a, numbers(&octaves, u, 2048.0, 1.0), "{u:e}");
        }
    }
}

/// Tables reach the default tolerances at once, over the joint and the kink of exponential heights.
#[test]
fn tables_meet_the_default_tolerances() {
    for heights in [EXPONENTIAL, GAUSSIAN] {
        for reading in [TangentialReading::Mindlin, TangentialReading::Paper] {
            let curves = curves(heights, reading);
            // There, the published stiffness has a corner where the last exponential height is loaded.
            let corner = (heights, reading) == (EXPONENTIAL, TangentialReading::Paper);
            let options = TableOptions {
                tolerance_tangential: if corner { 1e-3 } else { 1e-4 },
                ..TableOptions::default()
            };
            let table = match Tabulated::try_new(curves, [1e-9, 1e-4], options) {
                Ok(table) => table,
                Err(error) => panic!("{heights:?} {reading:?}: {error}"),
            };
            println!(
                "{heights:?} {reading:?}: {} knots, {:.1e}, {:.1e}",
                table.n_knots(),
                table.max_relative_error_normal(),
                table.max_relative_error_tangential()
            );
            for u in sweep([1e-9, 1e-4], 3001) {
                assert!(relative(table.normal(u).0, curves.normal(u).0) < 1.5e-5, "{u:e}");
                assert!(
                    relative(table.tangential(u)[1].value, curves.tangential(u)[1].value)
                        < 1.5 * options.tolerance_tangential,
                    "{u:e}"
                );
            }
        }
    }
}

#[test]
fn finite_interferences_give_numbers() {
    for heights in [EXPONENTIAL, GAUSSIAN] {
        for reading in [TangentialReading::Mindlin, TangentialReading::Paper] {
            let curves = curves(heights, reading);
            for u in [
                f64::from_bits(1),
                f64::MIN_POSITIVE,
                1e-100,
                1e-12,
                1e-2,
                1e10,
                1e100,
                1e300,
                f64::MAX,
            ] {
                let (t, slope) = curves.normal(u);
                let [x, y] = curves.tangential(u);
                let area = curves.contact_area_ratio(u).unwrap();
                let yielded = curves.yielded_fraction(u, 1e-6).unwrap();
                let all = [
                    t,
                    slope,
                    x.value,
                    x.slope,
                    x.curvature,
                    y.value,
                    y.slope,
                    y.curvature,
                    area,
                    yielded,
                ];
                assert!(all.iter().all(|v| !v.is_nan()), "{heights:?} {u:e} {all:?}");
                assert!((0.0..=1.0).contains(&yielded));
            }
        }
    }
}
