//! Sweeps: against the equations of a linear structure in time, and against steady motions.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::points::{folder, try_run};
use crate::excitations::{oscillator, summary};
use analyses::forced::ForcedSummary;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::path::Path;

fn swept(path: &Path, mu: f64, level: f64, [from, to]: [f64; 2], sweep: Value) -> ForcedSummary {
    let forced = json!({
        "terms": [[7, 1, 1.0]], "levels": [level], "from_hz": from, "to_hz": to, "harmonics": 3, "tolerance": 1e-10, "sweep": sweep,
    });
    let run = try_run(&oscillator(path, mu, json!({ "forced": forced }))).unwrap();
    summary(&run).forced.remove(0)
}

/// Largest amplitude of the first harmonic, and its frequency, of the two masses with the contact stuck: their modes by Runge and Kutta.
fn of_modes(level: f64, [from, to]: [f64; 2], rate: f64) -> [f64; 2] {
    // Stiffness [[15e4, -6e4], [-6e4, 6e4]], masses 1 and 2: eigenvalues of [[15e4, -6e4], [-3e4, 3e4]].
    let (sum, product) = (18e4_f64, 15e4 * 3e4 - 6e4 * 3e4);
    let root = (0.25 * sum * sum - product).sqrt();
    let modes = [0.5 * sum - root, 0.5 * sum + root].map(|eigenvalue| {
        // (15e4 - w2) a = 6e4 b.
        let shape = [6e4, 15e4 - eigenvalue];
        let norm = (shape[0] * shape[0] + 2.0 * shape[1] * shape[1]).sqrt();
        (eigenvalue.sqrt(), shape.map(|x| x / norm))
    });
    let sign = (to - from).signum();
    let step = 2e-5;
    let phase = |t: f64| TAU * (from + 0.5 * sign * rate * t) * t;
    let mut q = [[0.0_f64; 2]; 2];
    let (mut period, mut parts, mut best) = (0.0, [0.0_f64; 2], [0.0_f64; 2]);
    for k in 0..((to - from).abs() / rate / step) as usize {
        let t = k as f64 * step;
        for (q, (omega, shape)) in q.iter_mut().zip(&modes) {
            let slope = |t: f64, [x, v]: [f64; 2]| {
                [
                    v,
                    level * shape[0] * phase(t).sin() - 0.02 * omega * v - omega * omega * x,
                ]
            };
            let ahead = |by: f64, k: [f64; 2]| [q[0] + by * k[0], q[1] + by * k[1]];
            let a = slope(t, *q);
            let b = slope(t + 0.5 * step, ahead(0.5 * step, a));
            let c = slope(t + 0.5 * step, ahead(0.5 * step, b));
            let d = slope(t + step, ahead(step, c));
            *q = [0, 1].map(|i| q[i] + step / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        }
        let now = phase(t + step);
        let x: f64 = q.iter().zip(&modes).map(|(q, (_, shape))| q[0] * shape[1]).sum();
        let turned = now - phase(t);
        parts = [parts[0] + x * now.cos() * turned, parts[1] + x * now.sin() * turned];
        if (now / TAU).floor() > period {
            period += 1.0;
            let amplitude = 2.0 / TAU * parts[0].hypot(parts[1]);
            if amplitude > best[1] {
                // In the middle of the period.
                best = [from + sign * rate * (t - 0.5 / (now / TAU / t)), amplitude];
            }
            parts = [0.0; 2];
        }
    }
    best
}

#[test]
fn a_fast_sweep_of_a_linear_structure_is_that_of_its_modes_and_a_slow_one_finds_steady_motions() {
    let folder = folder("sweeps");
    let path = folder.join("oscillator.npz");
    let frequency = (9e4_f64 - (81e8_f64 - 27e8).sqrt()).sqrt() / TAU;
    let limit = 2.0 * (0.01 * frequency).powi(2);
    for (ends, rate) in [([17.0, 26.0], 2.0), ([26.0, 17.0], 2.0), ([19.0, 22.0], 0.5)] {
        let found = swept(&path, 10.0, 1.0, ends, json!({ "hz_per_s": rate }))
            .sweep
            .unwrap();
        let [at] = found.resonances.as_slice() else {
            panic!("{:?}", found.resonances)
        };
        assert!(
            (at.frequency_hz / frequency - 1.0).abs() < 3e-4,
            "{} {frequency}",
            at.frequency_hz
        );
        assert!((at.damping_ratio / 0.01 - 1.0).abs() < 1e-3, "{}", at.damping_ratio);
        assert!((at.limit_hz_per_s / limit - 1.0).abs() < 3e-3);
        assert!(!found.is_slow && found.jumps.is_empty());
        let found = found.in_time.unwrap();
        assert_eq!(found.failure, None);
        let [f, a] = found.peak.unwrap();
        let [f_modes, a_modes] = of_modes(1.0, ends, rate);
        assert!((f / f_modes - 1.0).abs() < 2e-3, "{rate} Hz/s: {f} Hz, {f_modes} Hz");
        assert!((a / a_modes - 1.0).abs() < 5e-3, "{rate} Hz/s: {a:e} m, {a_modes:e} m");
        assert!(found.frequency_hz.iter().all(|f| (16.9..26.1).contains(f)));
    }
    // At the limit the largest amplitude is nearly that of steady motions, and below it nothing is followed in time.
    let at_limit = swept(&path, 10.0, 1.0, [20.0, 21.6], json!({ "hz_per_s": 1.001 * limit }));
    let [_, steady] = at_limit.peak.unwrap();
    let [_, passed] = at_limit.sweep.unwrap().in_time.unwrap().peak.unwrap();
    assert!((passed / steady - 1.0).abs() < 0.03, "{}", passed / steady - 1.0);
    let octaves = 0.9 * limit / frequency / std::f64::consts::LN_2 * 60.0;
    let slow = swept(&path, 10.0, 1.0, [20.0, 21.6], json!({ "octaves_per_minute": octaves }));
    let slow = slow.sweep.unwrap();
    assert!(slow.is_slow && slow.in_time.is_none());
    assert!((slow.resonances[0].rate_hz_per_s / (0.9 * limit) - 1.0).abs() < 1e-3);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn with_friction_a_sweep_at_the_limit_follows_the_steady_motions_too() {
    let folder = folder("sweeps-friction");
    let path = folder.join("oscillator.npz");
    let steady = swept(&path, 0.2, 6.0, [15.0, 25.0], json!({ "hz_per_s": 0.001 }));
    let found = steady.sweep.as_ref().unwrap();
    assert!(found.is_slow);
    let [at] = found.resonances.as_slice() else {
        panic!("{:?}", found.resonances)
    };
    assert!(at.damping_ratio > 0.02, "{}", at.damping_ratio);
    let rate = 1.001 * at.limit_hz_per_s;
    let ends = [14.0, 28.0];
    let found = swept(&path, 0.2, 6.0, ends, json!({ "hz_per_s": rate })).sweep.unwrap();
    let [_, a] = found.in_time.unwrap().peak.unwrap();
    let [_, largest] = steady.peak.unwrap();
    assert!((a / largest - 1.0).abs() < 0.01, "{}", a / largest - 1.0);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn sweeps_that_cannot_be_are_refused_with_their_field() {
    let folder = folder("sweeps-refused");
    let path = folder.join("oscillator.npz");
    let refused = |sweep: Value, more: Value| {
        let mut forced =
            json!({ "terms": [[7, 1, 1.0]], "levels": [1.0], "from_hz": 15.0, "to_hz": 25.0, "sweep": sweep });
        forced
            .as_object_mut()
            .unwrap()
            .extend(more.as_object().unwrap().clone());
        try_run(&oscillator(&path, 0.2, json!({ "forced": forced })))
            .unwrap_err()
            .to_string()
    };
    for (sweep, more, field) in [
        (json!({}), json!({}), "analyses.forced.sweep"),
        (
            json!({ "hz_per_s": 1.0, "octaves_per_minute": 1.0 }),
            json!({}),
            "analyses.forced.sweep",
        ),
        (json!({ "hz_per_s": 0.0 }), json!({}), "analyses.forced.sweep.hz_per_s"),
        (
            json!({ "octaves_per_minute": -1.0 }),
            json!({}),
            "analyses.forced.sweep.octaves_per_minute",
        ),
        (
            json!({ "hz_per_s": 1.0 }),
            json!({ "rayleigh": { "mass": 1.0 } }),
            "analyses.forced.sweep",
        ),
    ] {
        let message = refused(sweep, more);
        assert!(message.contains(field), "{field}: {message}");
    }
    // One that would take too long is no reason to lose the steady motions.
    let found = swept(&path, 0.2, 6.0, [15.0, 25.0], json!({ "hz_per_s": 1e-9 }))
        .sweep
        .unwrap();
    assert!(found.is_slow);
    std::fs::remove_dir_all(folder).unwrap();
}
