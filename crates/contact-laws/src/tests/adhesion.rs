//! Adhesive force and traction against direct integration, limits and the method paper's statements.

use super::{STEEL, measured_population, population, relative};
use crate::*;
use std::f64::consts::PI;

/// Low-carbon steel on itself, section 3.2.1 of the method paper.
fn paper() -> Adhesion {
    Adhesion::try_new(2.5, 0.4e-9).unwrap()
}

/// Composite five-point Gauss rule.
fn integrate(f: impl Fn(f64) -> f64, from: f64, to: f64, n: u32) -> f64 {
    let r = (10.0_f64 / 7.0).sqrt();
    let (inner, outer) = ((5.0 - 2.0 * r).sqrt() / 3.0, (5.0 + 2.0 * r).sqrt() / 3.0);
    let (w_inner, w_outer) = (
        (322.0 + 13.0 * 70.0_f64.sqrt()) / 900.0,
        (322.0 - 13.0 * 70.0_f64.sqrt()) / 900.0,
    );
    let half = 0.5 * (to - from) / f64::from(n);
    let rule = [
        (0.0, 128.0 / 225.0),
        (inner, w_inner),
        (-inner, w_inner),
        (outer, w_outer),
        (-outer, w_outer),
    ];
    (0..n)
        .map(|i| from + half * f64::from(2 * i + 1))
        .flat_map(|middle| rule.map(|(x, w)| half * w * f(middle + half * x)))
        .sum()
}

/// The work of separating two planes from `epsilon` is the work of adhesion.
#[test]
fn planes_cost_the_work_of_adhesion() {
    let adhesion = paper();
    let epsilon = adhesion.intermolecular_distance();
    assert_eq!((adhesion.work(), adhesion.traction(epsilon)), (2.5, 0.0));
    // With Z = epsilon/v, dZ = epsilon/v^2 dv.
    let work = integrate(|v| adhesion.traction(epsilon / v) * epsilon / (v * v), 0.0, 1.0, 200);
    assert!(relative(work, 2.5) < 1e-12, "{work}");
    assert!(adhesion.traction(0.9 * epsilon) < 0.0 && adhesion.traction(1.1 * epsilon) > 0.0);
}

/// Sums of the Lennard-Jones traction over the undeformed paraboloid and over Hertz's profile in its own coordinates.
#[test]
fn forces_are_integrals_over_the_profile() {
    let adhesion = paper();
    let (epsilon, radius) = (adhesion.intermolecular_distance(), 1.4e-3);
    let mut worst = [0.0_f64; 2];
    for gap in [0.0, 0.03, 0.5, 1.0, 7.0, 300.0] {
        // r^2 = 2 R epsilon (1 + gap) (1/v - 1).
        let scale = epsilon * (1.0 + gap);
        let direct = integrate(
            |v| 2.0 * PI * adhesion.traction(scale / v) * radius * scale / (v * v),
            0.0,
            1.0,
            200,
        );
        worst[0] = worst[0].max(relative(adhesion.asperity_force(radius, -gap * epsilon), direct));
    }
    for l in [1e-6, 1e-3, 0.1, 1.0, 30.0, 1e3, 1e5] {
        let omega: f64 = l * epsilon;
        let a = (radius * omega).sqrt();
        let gap = |r: f64| {
            // r - a small: the terms cancel; they do so by 1e-16 of R omega only.
            (a * (r * r - a * a).sqrt() + (r * r - 2.0 * a * a) * (a / r).acos()) / (PI * radius)
        };
        // r = a + c t^2/(1 - t), c the width of the ring that attracts.
        let c = (a * (epsilon / omega).powf(2.0 / 3.0)).max((2.0 * radius * epsilon).sqrt());
        let direct = integrate(
            |t| {
                let r = a + c * t * t / (1.0 - t);
                let dr = c * t * (2.0 - t) / ((1.0 - t) * (1.0 - t));
                2.0 * PI * adhesion.traction(epsilon + gap(r).max(0.0)) * r * dr
            },
            0.0,
            1.0,
            20_000,
        );
        let error = relative(adhesion.asperity_force(radius, omega), direct);
        println!("omega/epsilon = {l:e}: {error:.1e}");
        worst[1] = worst[1].max(error);
    }
    println!("open {:.1e}, closed {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-12 && worst[1] < 1e-9);
}

/// Pull-off of a point contact, the limits of distant and of large contacts, and the fits' power of 1/3.
#[test]
fn limits_of_the_force() {
    let adhesion = paper();
    let (epsilon, radius) = (adhesion.intermolecular_distance(), 1.4e-3);
    let point = 2.0 * PI * radius * 2.5;
    let force = |l: f64| adhesion.asperity_force(radius, l * epsilon) / point;
    for l in [0.0, -0.0, 1e-300, -1e-300, 1e-12, 1e-10] {
        assert!((force(l) - 1.0).abs() < 1e-14, "{l:e}");
    }
    assert!(relative(force(-1e6), 4.0 / 3.0 * 1e-12) < 1e-5);
    // (16/9) c^(-2/3) (B(2/3, 7/3) - B(2/3, 25/3)), c = 8 sqrt(2)/(3 pi), from the profile near the contact's rim;
    // B by integration with v = y^3.
    let beta = |p: f64| integrate(|y| 3.0 * y * (1.0 - y * y * y).powf(p - 1.0), 0.0, 1.0, 2000);
    let c = 8.0 * 2.0_f64.sqrt() / (3.0 * PI);
    let slope = 16.0 / 9.0 * c.powf(-2.0 / 3.0) * (beta(7.0 / 3.0) - beta(25.0 / 3.0));
    println!("F/(2 pi R w) = {slope:.4} (omega/epsilon)^(1/3)");
    assert!((slope - 0.7434).abs() < 5e-4);
    for (l, tolerance) in [(1e6_f64, 1e-3), (1e12, 1e-7), (1e18, 1e-9)] {
        assert!(relative(force(l), slope * l.cbrt()) < tolerance, "{l:e} {}", force(l));
    }
    // It rises throughout, and is finite for any finite interference.
    let mut before = 0.0;
    for i in 0..2000 {
        let l = if i < 1000 {
            -(10.0_f64.powf(6.0 - 0.012 * f64::from(i)))
        } else {
            10.0_f64.powf(0.012 * f64::from(i) - 18.0)
        };
        assert!(force(l) >= before * (1.0 - 1e-13), "{l:e}");
        before = force(l);
    }
    for u in [f64::MAX, f64::MIN, f64::MIN_POSITIVE, 1e300, -1e300] {
        assert!(adhesion.asperity_force(radius, u).is_finite(), "{u:e}");
        assert!(adhesion.mean_traction(&population(), u).is_finite(), "{u:e}");
    }
}

/// Where adhesion changes the profile (large Tabor parameter), Johnson, Kendall and Roberts' solution attracts less at
/// the same interference: from (4/3) pi R w at zero down to pi R w.
#[test]
fn the_force_is_an_upper_estimate() {
    let (adhesion, radius) = (paper(), 1.4e-3);
    let tabor = adhesion.tabor_parameter(&STEEL, radius);
    println!("Tabor parameter {tabor:.1}");
    assert!((20.0..30.0).contains(&tabor));
    let (w, e) = (adhesion.work(), STEEL.composite_modulus());
    let mut before = 1.34;
    for interference in [1e-12, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5] {
        let depth = |a: f64| a * a / radius - (2.0 * PI * w * a / e).sqrt();
        let (mut low, mut high) = ((radius * interference).sqrt(), 1e-2);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if depth(middle) < interference {
                low = middle
            } else {
                high = middle
            }
        }
        let load = 4.0 / 3.0 * e * low.powi(3) / radius - (8.0 * PI * w * e * low.powi(3)).sqrt();
        let jkr = (hertz::force(&STEEL, radius, interference) - load) / (PI * radius * w);
        let here = adhesion.asperity_force(radius, interference) / (PI * radius * w);
        println!("{interference:e} m: JKR {jkr:.3}, here {here:.3} pi R w");
        assert!(jkr > 0.999 && jkr < before && here > jkr);
        before = jkr;
    }
}

/// The mean over uniform pieces is that over as many samples of them, and at every sign of the interference.
#[test]
fn mean_traction_is_the_mean_force() {
    let adhesion = paper();
    let (density, radius) = (1.4e6, 1.4e-3);
    let mean = |gaps| {
        let population = AsperityPopulation::try_new(gaps, density, [radius; 2]).unwrap();
        move |u: f64| adhesion.mean_traction(&population, u)
    };
    let samples = vec![0.0, 1e-9, 4e-9, 3e-7];
    let sampled = mean(GapDistribution::try_from_samples(samples.clone()).unwrap());
    for u in [-1e-8, -1e-10, 0.0, 2e-9, 1e-6] {
        let direct: f64 = samples
            .iter()
            .map(|s| adhesion.asperity_force(radius, u - s))
            .sum::<f64>()
            / 4.0
            * density;
        assert!(relative(sampled(u), direct) < 1e-14, "{u:e}");
    }
    // Pieces much wider than epsilon, comparable to it, and narrow ones; the interference inside and outside.
    for (start, width) in [(0.0, 1e-6), (1e-8, 3e-10), (1e-7, 2e-9), (5e-9, 1e-12), (5e-9, 0.0)] {
        let piece = mean(GapDistribution::try_from_quantiles(&[0.0, 1.0], &[start, start + width]).unwrap());
        for u in [
            -3e-9,
            start,
            start + 0.37 * width,
            start + width,
            start + width + 1e-9,
            3e-6,
        ] {
            let (low, high) = (u - start - width, u - start);
            let force = |omega: f64| adhesion.asperity_force(radius, omega);
            // From zero, where the force has a kink; cubed because it varies over epsilon there.
            let from_zero = |to: f64| integrate(|v| force(to * v.powi(3)) * 3.0 * v * v * to, 0.0, 1.0, 1500);
            let direct = if low < 0.0 && high > 0.0 || width > 1e-9 {
                from_zero(high) - from_zero(low)
            } else {
                integrate(force, low, high, 1500)
            };
            let direct = if width > 0.0 { direct / width } else { force(high) };
            let error = relative(piece(u), density * direct);
            assert!(error < 1e-8, "{start:e} {width:e} {u:e}: {error:e}");
        }
    }
}

/// In millimetres, tonnes and seconds the same force and traction.
#[test]
fn adhesion_does_not_depend_on_the_unit() {
    let si = paper();
    // J/m^2 = N/m = 1e-3 N/mm.
    let mm = Adhesion::try_new(2.5e-3, 0.4e-6).unwrap();
    let make = |length: f64| {
        let gaps = GapDistribution::try_from_quantiles(&[0.0, 0.4, 1.0], &[0.0, 3e-6 * length, 2e-5 * length]).unwrap();
        AsperityPopulation::try_new(gaps, 1e6 / (length * length), [1e-3 * length; 2]).unwrap()
    };
    for u in [-1e-6, -1e-10, 1e-12, 1e-9, 2e-6, 1e-4] {
        let (a, b) = (si.asperity_force(1e-3, u), mm.asperity_force(1.0, 1e3 * u));
        assert!(relative(a, b) < 1e-12, "{u:e}");
        let (a, b) = (
            si.mean_traction(&make(1.0), u),
            mm.mean_traction(&make(1e3), 1e3 * u) * 1e6,
        );
        assert!(relative(a, b) < 1e-12, "{u:e} {a:e} {b:e}");
    }
    let stiff = ElasticPair::new(STEEL.youngs_modulus * 1e-6, STEEL.poisson_ratio);
    assert!(relative(si.tabor_parameter(&STEEL, 1e-3), mm.tabor_parameter(&stiff, 1.0)) < 1e-14);
}

/// Section 3.2.1 with the measured population: `epsilon/omega_c` below 0.1 %, a threshold below which adhesion may not
/// be neglected, and more than an order of magnitude between the tractions from about a micron on.
#[test]
fn adhesion_is_small_at_working_interference() {
    let Some(population) = measured_population() else {
        return;
    };
    let radius = population.effective_radius();
    let adhesion = paper();

    let omega_c = adhesion::critical_interference(&STEEL, 9.47e9, radius);
    let relative_distance = adhesion.relative_distance(omega_c);
    println!("omega_c = {omega_c:.3e} m, epsilon/omega_c = {relative_distance:.2e}");
    assert!(relative_distance < 1e-3);

    let curves = AsperitySumCurves::try_new(population.clone(), STEEL, TangentialReading::Mindlin).unwrap();
    let ratio = |u: f64| curves.normal(u).0 / adhesion.mean_traction(&population, u);
    for u in [-1e-9, 1e-9, 1e-8, 1e-7, 1e-6, 2e-6, 5e-6, 1e-5] {
        let (elastic, adhesive) = (curves.normal(u).0, adhesion.mean_traction(&population, u));
        println!("u_n = {u:8.0e} m: elastic {elastic:.3e} Pa, adhesive {adhesive:.3e} Pa");
    }
    let (mut low, mut high) = (1e-9_f64, 1e-6_f64);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if ratio(middle) < 1.0 {
            low = middle
        } else {
            high = middle
        }
    }
    println!("adhesion prevails below u_n = {low:.2e} m");
    assert!(ratio(1e-8) < 1.0 && (1e-8..3e-7).contains(&low));
    assert!([1e-6, 2e-6, 5e-6, 1e-5].iter().all(|&u| ratio(u) > 10.0));
}
