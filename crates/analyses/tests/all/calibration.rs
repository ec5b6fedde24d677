//! Numbers of scenes recovered from backbones that were made with others.
#![expect(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "what was measured, for those who look")]

use crate::common::points::{folder, read, scene, set, write};
use analyses::calibration::{Calibration, Measured, Noise, calibrate};
use analyses::comparison::{Backbone, Point};
use analyses::{Error, run};
use faer::Mat;
use joints::Options;
use joints::progress::Silent;
use modal_identification::backbone::identify;
use modal_identification::synthetic::add_noise;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use scenes::{Force, Length, Marginal, Parameter, RingDown, Scene, Shape};
use serde_json::{Value, json};
use std::f64::consts::TAU;

const NOISE: Noise = Noise {
    frequency_ln: 5e-4,
    damping_ln: 0.02,
};

/// The backbone of a run, with noise.
fn backbone(scene: &Scene, seed: u64) -> Backbone {
    let found = run(scene, &Options::default(), &Silent).unwrap();
    let mut random = Pcg64::seed_from_u64(seed);
    let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    let points = found.amplitudes().iter().filter_map(|amplitude| {
        let result = amplitude.point.result.as_ref().ok()?;
        Some(Point {
            amplitude: amplitude.fields.as_ref()?.response_motion,
            frequency_hz: result.harmonic_omega / TAU * (NOISE.frequency_ln * normal()).exp(),
            damping_ratio: result
                .is_resolved()
                .then(|| result.harmonic_zeta() * (NOISE.damping_ln * normal()).exp()),
        })
    });
    Backbone::try_new("synthetic", points.collect()).unwrap()
}

fn measured(backbone: Backbone) -> Vec<Measured> {
    vec![Measured {
        name: "synthetic".into(),
        mode: 1,
        backbone,
    }]
}

fn free(names: &[&str]) -> Vec<(Parameter, Option<Marginal>)> {
    names.iter().map(|name| (Parameter::new(*name), None)).collect()
}

fn go(
    scene: &Scene,
    parameters: &[(Parameter, Option<Marginal>)],
    measured: &[Measured],
) -> Result<Calibration, Error> {
    calibrate(scene, parameters, measured, NOISE, &Options::default(), &Silent)
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_friction_and_bolt_load_are_recovered_from_a_noisy_backbone() {
    let quick = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": "quick" },
        "interfaces": { "gap": "flat", "mu": 0.2, "law": { "friction": "lumped" } },
        "analyses": { "backbone": {
            "amplitudes": 8, "amplitude_from": "10 um", "amplitude_to": "0.6 mm", "vertices_per_quarter": 4,
        } },
    });
    let scene = read(&quick).unwrap();
    let mut truth = scene.clone();
    truth.interfaces.mu = 0.26;
    truth.bolts.load = Force::from_si(10e3);
    truth.analyses.backbone.amplitude_from = Length::from_si(2e-5);
    truth.analyses.backbone.amplitude_to = Length::from_si(4e-4);
    let found = go(
        &scene,
        &free(&["interfaces.mu", "bolts.load"]),
        &measured(backbone(&truth, 4)),
    )
    .unwrap();
    assert!(found.converged && found.unidentifiable.is_empty(), "{found:?}");
    for (estimate, value) in found.parameters.iter().zip([0.26, 10e3]) {
        let [low, high] = estimate.interval_95;
        let inside = (low..=high).contains(&value);
        let close = (estimate.estimate / value - 1.0).abs() < 0.05;
        assert!(close || inside, "{estimate:?} instead of {value}");
        assert!(estimate.standard_error < 0.1 * value, "{estimate:?}");
    }
    assert_eq!(
        (found.parameters[0].unit.as_str(), found.parameters[1].unit.as_str()),
        ("", "N")
    );
    assert!(found.reduced_chi_squared < 3.0, "{}", found.reduced_chi_squared);
    assert!((found.scene.interfaces.mu - found.parameters[0].estimate).abs() < 1e-12);
    assert!((found.scene.bolts.load.si() - found.parameters[1].estimate).abs() < 1e-6);
}

const MU: &str = "interfaces.surface.parameters.sets.0.mu";
const PRELOAD: &str = "interfaces.surface.parameters.sets.0.preload";

/// A mass on a spring with a slider of this friction.
fn slider(test: &str, mu: f64) -> Value {
    let path = folder(test).join("slider.npz");
    let of = |value: f64| Mat::from_fn(1, 1, |_, _| value);
    write(&path, &of(4e4), &of(2.0), &[(7, 1)]);
    let mut given = scene(&path, &[7], &[set([5e4, 5e4, 2e6], mu, 50.0)], &json!([[7, 1, 1.0]]));
    given["analyses"] = json!({
        "modes": { "number": 1 },
        "backbone": { "amplitudes": 8, "vertices_per_quarter": 32, "amplitude_from": 1e-4, "amplitude_to": 2e-3 },
    });
    given
}

#[test]
fn what_only_a_product_tells_is_named_and_a_prior_settles_it() {
    let scene = read(&slider("product", 0.2)).unwrap();
    let truth = read(&slider("truth", 0.25)).unwrap();
    let data = measured(backbone(&truth, 9));
    let found = go(&scene, &free(&[MU, PRELOAD]), &data).unwrap();
    let [direction] = found.unidentifiable.as_slice() else {
        panic!("{:?}", found.unidentifiable)
    };
    // Friction times preload: one may rise as the other falls.
    let [a, b] = [MU, PRELOAD].map(|name| direction.direction[name]);
    assert!(
        (a + b).abs() < 0.05 && (a.abs() - 0.5_f64.sqrt()).abs() < 0.03,
        "{direction:?}"
    );
    assert!(direction.singular_value < 1.0);
    let product = found.parameters[0].estimate * found.parameters[1].estimate;
    assert!((product / (0.25 * 50.0) - 1.0).abs() < 0.05, "{product}");
    assert!(found.correlation[0][1] < -0.99);

    let known = Marginal::try_new(Shape::Normal { mean: 50.0, sd: 1.0 }, None).unwrap();
    let bounds = Marginal::try_new(Shape::Uniform { low: 0.05, high: 0.6 }, None).unwrap();
    let parameters = [
        (Parameter::new(MU), Some(bounds)),
        (Parameter::new(PRELOAD), Some(known)),
    ];
    let found = go(&scene, &parameters, &data).unwrap();
    assert!(
        (found.parameters[0].estimate / 0.25 - 1.0).abs() < 0.05,
        "{:?}",
        found.parameters
    );
    let error = found.parameters[1].standard_error;
    assert!(
        (0.8..2.0).contains(&error),
        "that of the prior, or what the residuals make of it: {error}"
    );
    assert_eq!(
        found.parameters[0]
            .bounds
            .map(|[a, b]| [(a * 1e6).round(), (b * 1e6).round()]),
        Some([5e4, 6e5])
    );
}

#[test]
fn what_cannot_be_calibrated_is_refused() {
    let scene = read(&slider("refusals", 0.2)).unwrap();
    let data = measured(backbone(&scene, 1));
    let refused =
        |parameters: &[&str], measured: &[Measured]| go(&scene, &free(parameters), measured).unwrap_err().to_string();
    assert!(refused(&[], &data).contains("a parameter"));
    assert!(refused(&[MU, MU], &data).contains("twice"));
    assert!(refused(&["analyses.backbone.tolerance"], &data).contains("no number that the physics depends on"));
    let other = vec![Measured {
        mode: 2,
        ..data[0].clone()
    }];
    assert!(refused(&[MU], &other).contains("analyses.modes.followed"));
}

/// Masses in a row, held by springs and by equal contacts, of which those farther out slip first.
fn row(path: &std::path::Path, mu: f64, stiffness: f64) -> Scene {
    let n = 5;
    let springs = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 if i + 1 == n => 9e4,
        0 => 1.6e5,
        1 => -7e4,
        _ => 0.0,
    });
    let masses = Mat::from_fn(n, n, |i, j| if i == j { 0.4 } else { 0.0 });
    let nodes: Vec<u64> = (1..=n as u64).collect();
    let dofs: Vec<(i64, u32)> = nodes.iter().map(|node| (*node as i64, 1)).collect();
    write(path, &springs, &masses, &dofs);
    let mut given = scene(
        path,
        &nodes,
        &[set([stiffness, stiffness, 2e6], mu, 5.0)],
        &json!([[5, 1, 1.0]]),
    );
    given["interfaces"]["surface"]["parameters"]["per"] = json!("interface");
    given["background_damping"] = json!(3e-3);
    given["analyses"] = json!({
        "modes": { "number": 1 },
        "backbone": { "amplitudes": 8, "vertices_per_quarter": 16, "amplitude_from": 2e-5, "amplitude_to": 2e-3 },
    });
    read(&given).unwrap()
}

/// What a hammer test would give: a ring-down in time with noise, identified.
fn ring(truth: &Scene, random: &mut Pcg64) -> Vec<Measured> {
    let mut truth = truth.clone();
    truth.analyses.ring_down = Some(RingDown {
        release: Some(Length::from_si(2e-3)),
        periods: 150,
        steps_per_period: 60,
        other_damping: 0.05,
        ..RingDown::default()
    });
    let truth = truth.only(&["ring_down".into()]).unwrap();
    let run = run(&truth, &Options::default(), &Silent).unwrap();
    let ring = run.vibration.ring_down.unwrap().unwrap().motion;
    let mut signal = ring.signal();
    let largest = signal.samples.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
    add_noise(&mut signal.samples, 3e-3 * largest, random.random());
    let found = identify(&signal, &ring.identification()).unwrap();
    let points = found.backbone.iter().map(|point| Point {
        amplitude: point.amplitude,
        // The error of the time steps, which is known.
        frequency_hz: point.frequency_hz / ring.transient.algorithmic.frequency_ratio,
        damping_ratio: Some(point.damping_ratio),
    });
    let backbone = Backbone::try_new("ring-down", points.collect()).unwrap();
    measured(backbone.differentiated("ring-down", -2).unwrap())
}

/// Neither the method nor its assumptions are those of the truth: it moves in time, with inertia and decay, and is identified from noise.
#[test]
#[ignore = "half a minute; `.ci/run slow` runs it"]
fn slow_ninety_of_a_hundred_ring_downs_give_their_parameters_back() {
    let path = folder("row").join("row.npz");
    let mut random = Pcg64::seed_from_u64(2);
    let names = [
        "interfaces.surface.parameters.sets.0.mu",
        "interfaces.surface.parameters.sets.0.curves.elastic.tangential_stiffness.0",
    ];
    let guess = row(&path, 0.2, 4e3);
    let (mut found, mut covered) = (0, [0, 0]);
    for _ in 0..100 {
        let truth = [
            0.12 + 0.2 * random.random::<f64>(),
            2.5e3 + 3e3 * random.random::<f64>(),
        ];
        let data = ring(&row(&path, truth[0], truth[1]), &mut random);
        let calibration = go(&guess, &free(&names), &data).unwrap();
        let parameters = calibration.parameters.iter().zip(truth);
        let inside = parameters.clone().map(|(estimate, truth)| {
            let [low, high] = estimate.interval_95;
            (low..=high).contains(&truth)
        });
        let inside: Vec<bool> = inside.collect();
        let mut close = parameters.map(|(estimate, truth)| (estimate.estimate / truth - 1.0).abs() < 0.05);
        found += usize::from(close.all(|close| close));
        covered
            .iter_mut()
            .zip(inside)
            .for_each(|(sum, inside)| *sum += usize::from(inside));
    }
    println!("of 100: within 5 %: {found}; inside their intervals of 95 %: {covered:?}");
    assert!(
        found >= 90 && covered.iter().all(|covered| *covered >= 90),
        "{found} {covered:?}"
    );
}
