//! Floquet multipliers: against closed forms, monodromy matrices and motions in time.

use crate::common::{Element, Elements, chain, linearised};
use crate::forced_responses::{go, settings};
use faer::Mat;
use harmonic_balance::Load;
use harmonic_balance::forced::{Held, Point, Settings, follow};
use harmonic_balance::points::Finder;
use harmonic_balance::stability::{Bifurcation, Exponent, bifurcation, is_stable};
use std::f64::consts::TAU;

/// A curve and the exponents of its points.
fn judged(
    [stiffness, mass]: [&Mat<f64>; 2],
    law: &Elements,
    row: &[f64],
    force: f64,
    settings: &Settings,
) -> Vec<(Point, Vec<Exponent>)> {
    let line = linearised(stiffness, mass, law, stiffness.nrows());
    let held = Held::Force(force);
    let load = Load::force(row);
    let curve = follow(&line, law, &load, held, settings, &mut go).expect("sizes fit");
    assert!(curve.failure.is_none(), "{:?}", curve.failure);
    let finder = Finder::try_new(&line, law, &load, held, settings).expect("sizes fit");
    let found = finder.exponents(&curve, &mut |_| go(&())).expect("not interrupted");
    let found = found.into_iter().map(|point| point.expect("the exponents are found"));
    curve.points.into_iter().zip(found).collect()
}

/// Multipliers of a real matrix from the sum of its eigenvalues and that of their products, of which only two are not zero: real and imaginary part, of a pair
/// the upper one.
fn two_multipliers(trace: f64, minors: f64) -> Vec<[f64; 2]> {
    let square = 0.25 * trace * trace - minors;
    match square >= 0.0 {
        true => vec![[0.5 * trace + square.sqrt(), 0.0], [0.5 * trace - square.sqrt(), 0.0]],
        false => vec![[0.5 * trace, (-square).sqrt()]],
    }
}

/// Multipliers of `d'' + damping d' + stiffness(t) d = 0` over a period, by the classical Runge-Kutta method.
fn monodromy(omega: f64, damping: f64, stiffness: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let steps = 4000;
    let h = TAU / omega / steps as f64;
    let run = |start: [f64; 2]| {
        let mut x = start;
        for step in 0..steps {
            let t = step as f64 * h;
            let rate = |t: f64, x: [f64; 2]| [x[1], -damping * x[1] - stiffness(t) * x[0]];
            let moved = |k: [f64; 2], by: f64| [x[0] + by * k[0], x[1] + by * k[1]];
            let a = rate(t, x);
            let b = rate(t + 0.5 * h, moved(a, 0.5 * h));
            let c = rate(t + 0.5 * h, moved(b, 0.5 * h));
            let d = rate(t + h, moved(c, h));
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        }
        x
    };
    let ([a, c], [b, d]) = (run([1.0, 0.0]), run([0.0, 1.0]));
    two_multipliers(a + d, a * d - b * c)
}

/// The largest distance of a multiplier expected from the nearest one found.
fn difference(found: &[Exponent], omega: f64, expected: &[[f64; 2]]) -> f64 {
    let found: Vec<[f64; 2]> = found.iter().map(|exponent| exponent.multiplier(omega)).collect();
    let nearest = |e: &[f64; 2]| {
        let distance = |f: &[f64; 2]| (f[0] - e[0]).hypot(f[1].abs() - e[1].abs());
        found.iter().map(distance).fold(f64::INFINITY, f64::min)
    };
    expected.iter().map(nearest).fold(0.0, f64::max)
}

/// Value of a displacement at a time.
fn at(point: &Point, row: &[f64], t: f64) -> f64 {
    let along = point.displacement.along(row);
    let of = |h: usize| {
        let (s, c) = (h as f64 * point.omega * t).sin_cos();
        along[2 * h - 1] * c + along[2 * h] * s
    };
    along[0] + (1..=point.displacement.count()).map(of).sum::<f64>()
}

#[test]
fn multipliers_of_a_duffing_oscillator_are_those_of_its_monodromy_matrix_and_one_is_1_where_the_curve_turns() {
    let (cubic, beta) = (0.5, 0.02);
    let (stiffness, mass) = (Mat::full(1, 1, 1.0), Mat::full(1, 1, 1.0));
    let law = Elements::new(vec![Element::Cubic { coefficient: cubic }]);
    let points = judged([&stiffness, &mass], &law, &[1.0], 0.1, &settings([0.6, 2.0], 9, beta));
    let mut unstable = 0;
    for (point, exponents) in &points {
        let tangent = |t: f64| 1.0 + 3.0 * cubic * at(point, &[1.0], t).powi(2);
        let expected = monodromy(point.omega, 2.0 * beta, tangent);
        let error = difference(exponents, point.omega, &expected);
        assert!(error < 1e-6, "{}: {error:e}, {exponents:?}", point.omega);
        let stable = expected.iter().all(|[re, im]| re.hypot(*im) < 1.0);
        assert_eq!(is_stable(exponents), Some(stable), "{}", point.omega);
        unstable += usize::from(!stable);
    }
    assert!(unstable > 5);
    // Stability changes where the curve turns, and nowhere else.
    let mut folds = 0;
    for pair in points.windows(2) {
        let [(one, before), (other, after)] = pair else {
            continue;
        };
        if let Some(kind) = bifurcation((one.omega, before), (other.omega, after)) {
            assert_eq!(kind, Bifurcation::Fold);
            assert!(one.turns || other.turns, "{}", one.omega);
            folds += 1;
        }
    }
    assert_eq!(folds, 2);
}

/// Two masses on springs of 1 N/m with an element each, joined by a spring.
fn twins(coupling: f64, element: Element) -> (Mat<f64>, Mat<f64>, Elements) {
    let stiffness = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 + coupling } else { -coupling });
    (
        stiffness,
        Mat::identity(2, 2),
        Elements::new(vec![element.clone(), element]),
    )
}

#[test]
fn twins_that_move_alike_are_excited_against_one_another_as_mathieu_says() {
    // Quadratic springs: the difference of the two sees a stiffness that swings with the motion.
    let (quadratic, coupling, beta, force) = (0.3, -0.2, 0.01, 0.08);
    let (stiffness, mass, law) = twins(coupling, Element::Quadratic { coefficient: quadratic });
    let of_difference = 1.0 + 2.0 * coupling;
    let twice = 2.0 * f64::sqrt(of_difference);
    let settings = settings([1.2 * twice, 0.85 * twice], 9, beta);
    let points = judged([&stiffness, &mass], &law, &[1.0, 1.0], force, &settings);
    let mut kinds = Vec::new();
    let mut before: Option<(f64, &[Exponent])> = None;
    for (point, exponents) in &points {
        let tangent = |t: f64| of_difference + 2.0 * quadratic * at(point, &[1.0, 0.0], t);
        let expected = monodromy(point.omega, 2.0 * beta * of_difference.sqrt(), tangent);
        let error = difference(exponents, point.omega, &expected);
        assert!(error < 1e-6, "{}: {error:e} {expected:?} {exponents:?}", point.omega);
        kinds.extend(before.and_then(|before| bifurcation(before, (point.omega, exponents))));
        before = Some((point.omega, exponents));
    }
    assert_eq!(kinds, [Bifurcation::PeriodDoubling; 2]);
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_multipliers_of_a_sliding_oscillator_are_those_of_its_motion_in_time() {
    let (slider, limit, beta, force) = (0.4, 0.3, 0.01, 0.5);
    let (stiffness, mass) = (Mat::full(1, 1, 1.0), Mat::full(1, 1, 1.0));
    let law = Elements::new(vec![Element::Jenkins {
        stiffness: slider,
        limit,
    }]);
    let mut settings = settings([0.9, 1.2], 15, beta);
    settings.sampling.samples = 4096;
    let points = judged([&stiffness, &mass], &law, &[1.0], force, &settings);
    let damping = 2.0 * beta * f64::sqrt(1.0 + slider);
    for (point, exponents) in points.iter().step_by(3) {
        let steps = 100_000;
        let h = TAU / point.omega / steps as f64;
        // Displacement, velocity and force of the slider after a period.
        let run = |mut x: [f64; 3]| {
            for step in 0..steps {
                let acceleration = |t: f64, x: [f64; 3]| force * (point.omega * t).cos() - x[0] - x[2] - damping * x[1];
                let t = step as f64 * h;
                let a = acceleration(t, x);
                let moved = h * x[1] + 0.5 * h * h * a;
                let mut next = [x[0] + moved, x[1] + h * a, (x[2] + slider * moved).clamp(-limit, limit)];
                next[1] = x[1] + 0.5 * h * (a + acceleration(t + h, next));
                x = next;
            }
            x
        };
        // The periodic motion, by Newton's method from that of harmonic balance.
        let rate = |t: f64| (at(point, &[1.0], t + 1e-6) - at(point, &[1.0], t - 1e-6)) / 2e-6;
        let mut x = [at(point, &[1.0], 0.0), rate(0.0), 0.0];
        for _ in 0..2 {
            x[2] = run(x)[2];
        }
        let columns = |x: [f64; 3]| -> [[f64; 3]; 3] {
            let end = run(x);
            std::array::from_fn(|j| {
                let step = 1e-5;
                let mut moved = x;
                moved[j] += step;
                let moved = run(moved);
                std::array::from_fn(|i| (moved[i] - end[i]) / step)
            })
        };
        for _ in 0..3 {
            let end = run(x);
            let m = columns(x);
            let jacobian = Mat::from_fn(3, 3, |i, j| m[j][i] - if i == j { 1.0 } else { 0.0 });
            let rest = Mat::from_fn(3, 1, |i, _| x[i] - end[i]);
            let change = faer::linalg::solvers::Solve::solve(&jacobian.partial_piv_lu(), &rest);
            x = std::array::from_fn(|i| x[i] + change[(i, 0)]);
        }
        let m = columns(x);
        let minor = |i: usize, j: usize| m[i][i] * m[j][j] - m[i][j] * m[j][i];
        let expected = two_multipliers(m[0][0] + m[1][1] + m[2][2], minor(0, 1) + minor(0, 2) + minor(1, 2));
        let error = difference(exponents, point.omega, &expected);
        // What harmonics and samples leave; with 41 harmonics and four times as many samples it is at most 1.7e-4.
        assert!(error < 7e-4, "{}: {error:e} {expected:?} {exponents:?}", point.omega);
        assert!(
            exponents.iter().all(|e| e.error < 0.2 * e.growth.abs()),
            "{exponents:?}"
        );
    }
}

#[test]
fn a_linear_chain_decays_as_its_modes_do() {
    let (stiffness, mass) = chain(3, 1e4);
    let law = Elements::new(vec![Element::Cubic { coefficient: 0.0 }; 3]);
    let line = linearised(&stiffness, &mass, &law, 3);
    let beta = 0.013;
    let points = judged(
        [&stiffness, &mass],
        &law,
        &[1.0, 0.0, 0.0],
        1.0,
        &settings([40.0, 60.0], 5, beta),
    );
    for (point, exponents) in &points {
        assert_eq!(exponents.len(), 3);
        for lambda in &line.eigenvalues {
            let omega = lambda.sqrt();
            let (growth, detuning) = (-beta * omega, omega * f64::sqrt(1.0 - beta * beta));
            let folded = (detuning / point.omega - (detuning / point.omega).round()).abs() * point.omega;
            let error = |e: &Exponent| (e.growth - growth).hypot(e.detuning - folded) / omega;
            let least = exponents.iter().map(error).fold(f64::INFINITY, f64::min);
            assert!(least < 1e-10, "{}: {least:e}", point.omega);
        }
    }
}
