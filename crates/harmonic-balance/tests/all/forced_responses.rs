//! Forced responses: against closed forms, through turning points, and their resonances on backbones.

use crate::common::{Element, Elements, chain, linearised};
use cqsma_solver::Linearisation;
use faer::Mat;
use harmonic_balance::backbone::{self, Kind};
use harmonic_balance::forced::{Curve, Held, Point, Settings, follow};
use harmonic_balance::points::{Between, Finder};
use harmonic_balance::{Failure, Load, NewtonSettings, Sampling, synthesis};
use std::ops::ControlFlow;

pub(crate) fn settings(range: [f64; 2], harmonics: usize, background: f64) -> Settings {
    Settings {
        range,
        sampling: Sampling {
            harmonics,
            samples: 256,
            periods: 2,
        },
        background,
        newton: NewtonSettings {
            tolerance: 1e-10,
            ..NewtonSettings::default()
        },
        ..Settings::default()
    }
}

fn resonances(
    line: &Linearisation<'_, Vec<[f64; 2]>>,
    law: &Elements,
    load: &Load,
    held: Held<'_>,
    curve: &Curve,
    settings: &Settings,
) -> Vec<Point> {
    let mut finder = Finder::try_new(line, law, load, held, settings).expect("sizes fit");
    let found = finder.resonances(curve).expect("not interrupted");
    let point = |found: Result<Between, Failure>| found.expect("the resonance is found").point;
    found.into_iter().map(point).collect()
}

pub(crate) fn go<T>(_: &T) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn a_duffing_oscillator_is_followed_through_both_turning_points() {
    // One harmonic: (k - m w^2 + 3/4 c A^2)^2 A^2 + (d w A)^2 = F^2.
    let (k, m, cubic, beta, force) = (1.0, 1.0, 0.5, 0.02, 0.1);
    let (stiffness, mass) = (Mat::full(1, 1, k), Mat::full(1, 1, m));
    let law = Elements::new(vec![Element::Cubic { coefficient: cubic }]);
    let line = linearised(&stiffness, &mass, &law, 1);
    let load = Load::force(&[1.0]);
    let curve = follow(
        &line,
        &law,
        &load,
        Held::Force(force),
        &settings([0.5, 2.0], 1, beta),
        &mut go,
    )
    .unwrap();
    assert!(curve.failure.is_none(), "{:?}", curve.failure);
    assert_eq!(curve.points.iter().filter(|point| point.turns).count(), 2);
    for point in &curve.points {
        let along = point.displacement.along(&[1.0]);
        let amplitude = along[1].hypot(along[2]);
        let w = point.omega;
        let stiff = (k - m * w * w + 0.75 * cubic * amplitude * amplitude) * amplitude;
        let viscous = 2.0 * beta * w * amplitude;
        assert!((stiff.hypot(viscous) / force - 1.0).abs() < 1e-8, "{w}: {amplitude}");
    }
    let settings = settings([0.5, 2.0], 1, beta);
    let found = resonances(&line, &law, &load, Held::Force(force), &curve, &settings);
    let [resonance] = found.as_slice() else {
        panic!("{found:?}");
    };
    let amplitude = resonance.displacement.along(&[1.0])[2];
    assert!((amplitude * 2.0 * beta * resonance.omega / force - 1.0).abs() < 1e-8);
    let highest = curve
        .points
        .iter()
        .map(|p| p.displacement.along(&[1.0])[2])
        .fold(0.0, f64::max);
    assert!((highest / amplitude - 1.0).abs() < 1e-2);
}

#[test]
fn a_duffing_oscillator_at_a_given_response_needs_the_force_of_the_closed_form_and_does_not_turn_back() {
    let (k, m, cubic, beta, amplitude) = (1.0, 1.0, 0.5, 0.02, 1.5);
    let (stiffness, mass) = (Mat::full(1, 1, k), Mat::full(1, 1, m));
    let law = Elements::new(vec![Element::Cubic { coefficient: cubic }]);
    let line = linearised(&stiffness, &mass, &law, 1);
    let load = Load::force(&[1.0]);
    let held = Held::Response { row: &[1.0], amplitude };
    let settings = settings([0.5, 2.0], 1, beta);
    let curve = follow(&line, &law, &load, held, &settings, &mut go).unwrap();
    assert!(curve.failure.is_none(), "{:?}", curve.failure);
    assert!(curve.points.iter().all(|point| !point.turns));
    let stiff = k + 0.75 * cubic * amplitude * amplitude;
    for point in &curve.points {
        let w = point.omega;
        let expected = amplitude * (stiff - m * w * w).hypot(2.0 * beta * w);
        assert!(
            (point.force / expected - 1.0).abs() < 1e-7,
            "{w}: {} for {expected}",
            point.force
        );
        let along = point.displacement.along(&[1.0]);
        assert!((along[1].hypot(along[2]) / amplitude - 1.0).abs() < 1e-9);
        assert!(point.energy_error < 1e-9);
    }
    let found = resonances(&line, &law, &load, held, &curve, &settings);
    let [resonance] = found.as_slice() else {
        panic!("{found:?}");
    };
    assert!((resonance.omega * resonance.omega / stiff - 1.0).abs() < 1e-9);
    assert!((resonance.force / (2.0 * beta * stiff.sqrt() * amplitude) - 1.0).abs() < 1e-8);
}

#[test]
fn at_the_response_of_a_resonance_the_force_is_that_which_led_to_it() {
    let (stiffness, mass, law) = sliders();
    let line = linearised(&stiffness, &mass, &law, 3);
    let (row, tip) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let load = Load::force(&row);
    let omega = line.eigenvalues[0].sqrt();
    let settings = settings([0.85 * omega, 1.1 * omega], 3, 2e-3);
    for force in [0.05, 2.0] {
        let held = Held::Force(force);
        let curve = follow(&line, &law, &load, held, &settings, &mut go).unwrap();
        let by_force = resonances(&line, &law, &load, held, &curve, &settings).remove(0);
        let along = by_force.displacement.along(&tip);
        let held = Held::Response {
            row: &tip,
            amplitude: along[1].hypot(along[2]),
        };
        let curve = follow(&line, &law, &load, held, &settings, &mut go).unwrap();
        assert!(curve.failure.is_none(), "{force}: {:?}", curve.failure);
        let found = resonances(&line, &law, &load, held, &curve, &settings).remove(0);
        assert!((found.force / force - 1.0).abs() < 1e-7, "{force}: {}", found.force);
        assert!((found.omega / by_force.omega - 1.0).abs() < 1e-8);
    }
}

/// Three masses with sliders to the ground, driven at the first.
fn sliders() -> (Mat<f64>, Mat<f64>, Elements) {
    let (stiffness, mass) = chain(3, 2e4);
    let slider = |stiffness, limit| Element::Jenkins { stiffness, limit };
    let law = Elements::new(vec![slider(1e3, 2.0), slider(2e3, 1.0), slider(500.0, 0.5)]);
    (stiffness, mass, law)
}

fn peak(curve: &Curve, row: &[f64]) -> (f64, f64) {
    let amplitude = |p: &Point| {
        let along = p.displacement.along(row);
        along[1].hypot(along[2])
    };
    curve
        .points
        .iter()
        .map(|p| (p.omega, amplitude(p)))
        .fold((0.0, 0.0), |best, next| if next.1 > best.1 { next } else { best })
}

#[test]
fn resonances_lie_on_the_backbone_of_phase_resonances_and_near_that_of_free_motions() {
    let (stiffness, mass, law) = sliders();
    let line = linearised(&stiffness, &mass, &law, 3);
    let row = [1.0, 0.0, 0.0];
    let load = Load::force(&row);
    let omega = line.eigenvalues[0].sqrt();
    let beta = 2e-3;
    let settings = settings([0.85 * omega, 1.1 * omega], 3, beta);
    let backbone_settings = backbone::Settings {
        mode: 0,
        sampling: settings.sampling,
        accuracy: None,
        newton: settings.newton,
    };
    let amplitudes: Vec<f64> = (0..40).map(|i| 1e-4 * 10_f64.powf(i as f64 / 13.0)).collect();
    let kind = Kind::PhaseResonance {
        row: &row,
        background: beta,
    };
    let free = backbone::follow(
        &line,
        &law,
        Kind::Free,
        &amplitudes,
        &backbone_settings,
        Vec::new(),
        &mut go,
    )
    .unwrap();
    let free: Vec<_> = free.into_iter().map(|p| p.result.unwrap()).collect();
    for force in [0.05, 0.5, 2.0] {
        let curve = follow(&line, &law, &load, Held::Force(force), &settings, &mut go).unwrap();
        assert!(curve.failure.is_none(), "{force}: {:?}", curve.failure);
        let found = resonances(&line, &law, &load, Held::Force(force), &curve, &settings);
        let resonance = &found[0];
        // The backbone at the amplitude of the resonance has its frequency, and needs its force.
        let [c, s] = resonance.displacement.pair(1);
        let q = c.iter().chain(s).map(|v| v * v).sum::<f64>().sqrt();
        let way = [0.25 * q, 0.5 * q, q];
        let points = backbone::follow(&line, &law, kind, &way, &backbone_settings, Vec::new(), &mut go).unwrap();
        let on_backbone = points[2].result.as_ref().unwrap();
        assert!((resonance.omega / on_backbone.omega - 1.0).abs() < 1e-8, "{force}");
        assert!((on_backbone.force.unwrap() / force - 1.0).abs() < 1e-8, "{force}");
        assert!(on_backbone.energy_error < 1e-10);
        let amplitude = resonance.displacement.along(&row)[2];
        let (peak_omega, highest) = peak(&curve, &row);
        assert!(
            (highest / amplitude - 1.0).abs() < 0.02,
            "{force}: {highest} {amplitude}"
        );
        // Points are up to 2 % of the frequency apart.
        assert!((peak_omega / resonance.omega - 1.0).abs() < 2e-2);
        // The mode alone. With 6 % of damping its tip is 4e-3 below the phase resonance, as zeta^2 says.
        let motions: Vec<_> = free.iter().collect();
        let alone = synthesis::response(&motions, &load, &row, force, beta, 8);
        let top = alone
            .iter()
            .max_by(|a, b| a.displacement.total_cmp(&b.displacement))
            .unwrap();
        assert!(
            (top.omega / resonance.omega - 1.0).abs() < 6e-3,
            "{force}: {} {}",
            top.omega,
            resonance.omega
        );
        assert!(
            (top.displacement / amplitude - 1.0).abs() < 0.03,
            "{force}: {} {amplitude}",
            top.displacement
        );
    }
}

#[test]
fn harmonics_beyond_the_first_resonate_below_the_mode() {
    // A cubic spring driven near a third of its mode: the third harmonic peaks there.
    let (stiffness, mass) = (Mat::full(1, 1, 1.0), Mat::full(1, 1, 1.0));
    let law = Elements::new(vec![Element::Cubic { coefficient: 0.3 }]);
    let line = linearised(&stiffness, &mass, &law, 1);
    let load = Load::force(&[1.0]);
    let settings = settings([0.2, 0.6], 7, 0.02);
    let held = Held::Force(0.3);
    let mut curve = follow(&line, &law, &load, held, &settings, &mut go).unwrap();
    assert!(curve.failure.is_none());
    let third = |p: &Point| {
        let along = p.displacement.along(&[1.0]);
        along[5].hypot(along[6]) / along[1].hypot(along[2])
    };
    let top = |curve: &Curve| {
        let points = curve.points.iter().map(|p| (p.omega, third(p)));
        points.fold((0.0, 0.0), |best, next| if next.1 > best.1 { next } else { best })
    };
    let coarse = top(&curve);
    let before = curve.points.len();
    let mut finder = Finder::try_new(&line, &law, &load, held, &settings).unwrap();
    assert_eq!(finder.resolve_peaks(&mut curve, &[1.0]).unwrap(), []);
    let found = top(&curve);
    assert!(found.1 > 0.1 && (found.0 * 3.0 - 1.0).abs() < 0.1, "{found:?}");
    // Against steps a hundred times as short.
    let fine = Settings {
        range: [found.0 - 0.01, found.0 + 0.01],
        frequency_step: 2e-4,
        amplitude_step: 2e-3,
        ..settings
    };
    let known = top(&follow(&line, &law, &load, held, &fine, &mut go).unwrap());
    assert!((found.1 / known.1 - 1.0).abs() < 1e-3, "{coarse:?} {found:?} {known:?}");
    assert!((found.0 / known.0 - 1.0).abs() < 1e-3, "{coarse:?} {found:?} {known:?}");
    assert!(found.1 > coarse.1 && curve.points.len() <= before + 12);
    // Points stay in the order of the curve.
    assert!(curve.points.windows(2).all(|pair| pair[0].omega < pair[1].omega));
}

#[test]
fn a_curve_gives_its_points_at_given_frequencies_on_every_branch() {
    let (cubic, beta, force) = (0.5, 0.02, 0.1);
    let (stiffness, mass) = (Mat::full(1, 1, 1.0), Mat::full(1, 1, 1.0));
    let law = Elements::new(vec![Element::Cubic { coefficient: cubic }]);
    let line = linearised(&stiffness, &mass, &law, 1);
    let load = Load::force(&[1.0]);
    let held = Held::Force(force);
    let settings = settings([0.5, 2.0], 1, beta);
    let curve = follow(&line, &law, &load, held, &settings, &mut go).unwrap();
    let mut finder = Finder::try_new(&line, &law, &load, held, &settings).unwrap();
    let turns: Vec<f64> = curve.points.iter().filter(|p| p.turns).map(|p| p.omega).collect();
    let between = 0.5 * (turns[0] + turns[1]);
    for (omega, branches) in [(0.5, 1), (0.8, 1), (between, 3), (1.9, 1), (2.0, 1)] {
        let found = finder.at(&curve, omega).unwrap();
        assert_eq!(found.len(), branches, "{omega}");
        let mut amplitudes = Vec::new();
        for found in found {
            let point = found.unwrap().point;
            assert!((point.omega / omega - 1.0).abs() < 1e-14);
            let along = point.displacement.along(&[1.0]);
            let amplitude = along[1].hypot(along[2]);
            let stiff = (1.0 - omega * omega + 0.75 * cubic * amplitude * amplitude) * amplitude;
            assert!((stiff.hypot(2.0 * beta * omega * amplitude) / force - 1.0).abs() < 1e-8);
            amplitudes.push(amplitude);
        }
        amplitudes.sort_by(f64::total_cmp);
        assert!(
            amplitudes.windows(2).all(|pair| pair[1] > 1.01 * pair[0]),
            "{amplitudes:?}"
        );
    }
}

#[test]
fn forces_with_phases_and_a_rotating_unbalance_drive_a_linear_structure_as_the_closed_form_says() {
    // (K - w^2 M + i w C) U = F with complex F, C that of the modes.
    let (stiffness, mass) = chain(2, 1e4);
    let law = Elements::new(vec![Element::Cubic { coefficient: 0.0 }; 2]);
    let line = linearised(&stiffness, &mass, &law, 2);
    let beta = 0.01;
    let settings = settings([50.0, 75.0], 1, beta);
    let (phase, level) = (0.7_f64, 3e-4);
    for is_unbalance in [false, true] {
        // The second coordinate is ahead by a phase.
        let load = Load {
            cosine: vec![1.0, 2.0 * phase.cos()],
            sine: vec![0.0, -2.0 * phase.sin()],
            is_unbalance,
        };
        let curve = follow(&line, &law, &load, Held::Force(level), &settings, &mut go).unwrap();
        assert!(curve.failure.is_none());
        for point in &curve.points {
            let w = point.omega;
            let [c, s] = point.displacement.pair(1);
            let force = level * if is_unbalance { w * w } else { 1.0 };
            let mut expected = [[0.0; 2]; 2];
            for (mode, lambda) in line.eigenvalues.iter().enumerate() {
                let shape = line.shapes.col_as_slice(mode);
                // X - i Y, divided by the dynamic stiffness.
                let along = |row: &[f64]| force * (shape[0] * row[0] + shape[1] * row[1]);
                let (x, y) = (along(&load.cosine), along(&load.sine));
                let (re, im) = (lambda - w * w, 2.0 * beta * lambda.sqrt() * w);
                let square = re * re + im * im;
                let (q_c, q_s) = ((x * re - y * im) / square, (y * re + x * im) / square);
                for i in 0..2 {
                    expected[i][0] += shape[i] * q_c;
                    expected[i][1] += shape[i] * q_s;
                }
            }
            let size = expected.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
            for i in 0..2 {
                assert!((c[i] - expected[i][0]).abs() < 1e-8 * size, "{w}");
                assert!((s[i] - expected[i][1]).abs() < 1e-8 * size, "{w}");
            }
            assert!(point.energy_error < 1e-9, "{}", point.energy_error);
        }
        // At the resonance nothing is in phase with the load.
        let found = resonances(&line, &law, &load, Held::Force(level), &curve, &settings);
        assert_eq!(found.len(), 1);
        let [ahead, behind] = load.along(&found[0].displacement);
        assert!(ahead.abs() < 1e-8 * behind);
    }
}

#[test]
fn proportional_damping_is_that_of_the_linear_structure() {
    // A linear chain: (K - w^2 M + i w (c_m M + c_k K)) U = F.
    let (stiffness, mass) = chain(2, 1e4);
    let law = Elements::new(vec![Element::Cubic { coefficient: 0.0 }; 2]);
    let line = linearised(&stiffness, &mass, &law, 2);
    let (of_mass, of_stiffness) = (0.7, 3e-4);
    let with = Settings {
        rayleigh: [of_mass, of_stiffness],
        ..settings([50.0, 75.0], 1, 0.0)
    };
    let curve = follow(&line, &law, &Load::force(&[1.0, 0.0]), Held::Force(2.0), &with, &mut go).unwrap();
    assert!(curve.failure.is_none());
    for point in &curve.points {
        let w = point.omega;
        let [c, s] = point.displacement.pair(1);
        for i in 0..2 {
            let product = |matrix: &Mat<f64>, x: &[f64]| (0..2).map(|j| matrix[(i, j)] * x[j]).sum::<f64>();
            let [kc, ks, mc, ms] = [
                product(&stiffness, c),
                product(&stiffness, s),
                product(&mass, c),
                product(&mass, s),
            ];
            let cosine = kc - w * w * mc + w * (of_mass * ms + of_stiffness * ks);
            let sine = ks - w * w * ms - w * (of_mass * mc + of_stiffness * kc);
            let force = if i == 0 { 2.0 } else { 0.0 };
            assert!(
                (cosine - force).abs() < 1e-8 && sine.abs() < 1e-8,
                "{w}: {cosine} {sine}"
            );
        }
    }
}
