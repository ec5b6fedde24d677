//! Harmonic balance: backbones of free motions, and what their residuals and Krylov steps cost.

use super::instruments::Instruments;
use super::solver::{Bench, fastest};
use analyses::prepare;
use anyhow::{Context, Result, anyhow};
use harmonic_balance::backbone::{Kind, Settings, follow};
use harmonic_balance::probe::Probe;
use harmonic_balance::{Effort, NewtonSettings, Sampling};
use joint_model::benchmark::RefinementLevel;
use joints::Options;
use serde_json::{Value, json};
use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;

/// Harmonics and samples as published backbones have them.
const SAMPLING: Sampling = Sampling {
    harmonics: 3,
    samples: 128,
    periods: 2,
};

/// Amplitudes of a backbone, from the first to the last, spaced in log (sqrt(kg) m).
const AMPLITUDES: (usize, f64, f64) = (25, 1e-7, 1e-3);

/// The meshes: name, refinement, points per direction.
const MESHES: [(&str, RefinementLevel, usize); 2] = [
    ("epmc", RefinementLevel::Default, 2),
    ("epmc_coarse", RefinementLevel::Quick, 1),
];

pub(super) fn figures(instruments: &Instruments<'_>) -> Result<(Value, String)> {
    let mut figures = json!({});
    let mut text = String::from("free periodic motions, 25 amplitudes, 3 harmonics, 128 samples\n");
    for (name, refinement, points) in MESHES {
        let mut scene = crate::paper_scene("bench")?;
        scene.model.refinement = refinement;
        scene.interfaces.points_per_direction = points;
        let prepared = prepare(&scene, &Options::default(), instruments.progress)?;
        let bench = Bench::try_new(&prepared)?;
        let line = bench.linearise()?;
        let (number, from, to) = AMPLITUDES;
        let ratio = (to / from).ln() / (number - 1) as f64;
        let amplitudes: Vec<f64> = (0..number).map(|i| from * (ratio * i as f64).exp()).collect();
        let settings = Settings {
            mode: 0,
            sampling: SAMPLING,
            accuracy: None,
            newton: NewtonSettings::default(),
        };
        let known = (instruments.forget_peak_memory)();
        let began = Instant::now();
        let found = follow(
            &line,
            &bench.force,
            Kind::Free,
            &amplitudes,
            &settings,
            Vec::new(),
            &mut |_| ControlFlow::Continue(()),
        )?;
        let backbone_s = began.elapsed().as_secs_f64();
        let memory = known.then(instruments.peak_memory).flatten();
        let mut effort = Effort::default();
        for point in &found {
            effort += point.effort;
            if let Err(failure) = &point.result {
                return Err(anyhow!("at {:e} sqrt(kg) m: {}", point.modal_amplitude, failure.reason));
            }
        }
        let last = found
            .last()
            .and_then(|point| point.result.as_ref().ok())
            .context("no motion")?;
        let row = bench.response();
        let probe = Probe::new(&line, &bench.force, &row, last, SAMPLING);
        let residual_ms = fastest(|| _ = black_box(probe.residual()));
        let contact_ms = fastest(|| _ = black_box(probe.contact()));
        let krylov_ms = fastest(|| _ = black_box(probe.krylov_step()));
        let derivative_ms = fastest(|| _ = black_box(probe.contact_derivative()));
        let stuck_ms = fastest(|| drop(black_box(probe.stuck_response())));
        text += &format!(
            "{name}: {} unknowns\n  backbone {backbone_s:8.2} s, {} Newton and {} Krylov steps\n  residual {residual_ms:8.2} ms, of which \
             contact {contact_ms:.2} ms\n  Krylov step {krylov_ms:5.2} ms, of which derivative of the contact {derivative_ms:.2} ms, stuck \
             responses {stuck_ms:.2} ms\n",
            last.displacement.values().len(),
            effort.iterations,
            effort.krylov_steps,
        );
        figures[name] = json!({
            "unknowns": last.displacement.values().len(),
            "backbone_s": backbone_s,
            "iterations": effort.iterations,
            "evaluations": effort.evaluations,
            "krylov_steps": effort.krylov_steps,
            "residual_ms": residual_ms,
            "contact_ms": contact_ms,
            "krylov_ms": krylov_ms,
            "derivative_ms": derivative_ms,
            "stuck_ms": stuck_ms,
            "peak_memory": memory,
        });
    }
    Ok((figures, text))
}
