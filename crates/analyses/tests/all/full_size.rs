//! The benchmark at full size against independent figures. A few minutes, therefore on request:
//! `cargo test --release -p analyses --test all full_size:: -- --ignored --nocapture`.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::beam;
use analyses::{Run, run};
use brake_reuss_beam::published::STUCK_FREQUENCIES;
use contact_laws::TangentialReading;
use joints::Options;
use joints::progress::Silent;
use scenes::{Gap, Scene};

/// Low-amplitude first frequencies of an independent computation on another mesh of the same beam (Hz): measured
/// asperity statistics, Mindlin stiffness unless said otherwise.
const FLAT: f64 = 168.29;
const TOPOGRAPHY: f64 = 181.53;
const FLAT_PAPER_READING: f64 = 179.65;

/// One run at a time: the first makes the reduced model that the others find in the cache.
static TURN: std::sync::Mutex<()> = std::sync::Mutex::new(());

fn go(scene: &Scene) -> Run {
    let _turn = TURN.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let cache = std::env::temp_dir().join("analyses-full-size");
    let run = run(scene, &Options::cached(cache), &Silent).unwrap();
    run.checkpoints.remove();
    run
}

#[test]
#[ignore = "minutes; see the head of this file"]
fn stuck_frequencies_and_reduction() {
    let mut scene = beam("flat");
    scene.analyses.backbone.amplitudes = 1;
    let run = go(&scene);
    for (ours, reference) in run.model.reduced.stuck_frequencies.iter().zip(STUCK_FREQUENCIES) {
        println!(
            "stuck {ours:10.3} Hz, reference {reference:10.3} Hz, {:+.3} %",
            100.0 * (ours / reference - 1.0)
        );
        assert!((ours / reference - 1.0).abs() < 0.01);
    }
    println!(
        "reduced against full with a uniform penalty: {:.2e}",
        run.model.facts.penalty_error
    );
    println!("asymmetry of the reduced matrices: {:.2e}", run.model.reduced.asymmetry);
    assert!(run.model.facts.penalty_error < 1e-4);
    assert_eq!(run.interface.operators().n_elements(), 588);
}

#[test]
#[ignore = "minutes; see the head of this file"]
fn low_amplitude_frequencies() {
    for (name, gap, reading, reference) in [
        ("flat", Gap::Flat, TangentialReading::Mindlin, FLAT),
        ("topography", Gap::Measured, TangentialReading::Mindlin, TOPOGRAPHY),
        (
            "flat, paper reading",
            Gap::Flat,
            TangentialReading::Paper,
            FLAT_PAPER_READING,
        ),
    ] {
        let mut scene = beam(name);
        scene.interfaces.gap = gap;
        scene.interfaces.law.tangential = reading;
        scene.analyses.backbone.amplitudes = 1;
        let f = go(&scene).frequencies[0];
        println!(
            "{name}: {f:.3} Hz, reference {reference:.2} Hz, {:+.3} %",
            100.0 * (f / reference - 1.0)
        );
        assert!((f / reference - 1.0).abs() < 0.01, "{name}: {f}");
    }
}

#[test]
#[ignore = "minutes; see the head of this file"]
fn backbones_fall_and_damping_rises_over_decades() {
    let mut onsets = Vec::new();
    for mu in [0.05, 0.2, 0.6] {
        let mut scene = beam("flat");
        scene.interfaces.mu = mu;
        scene.analyses.backbone.amplitudes = 13;
        let run = go(&scene);
        let points: Vec<_> = run
            .amplitudes()
            .iter()
            .map(|a| a.point.result.as_ref().unwrap())
            .collect();
        for (a, p) in run.amplitudes().iter().zip(&points) {
            let x = a.response_displacement.unwrap();
            println!(
                "mu {mu}: {x:.3e} m, {:.3} Hz, zeta {:.3e}",
                p.omega / std::f64::consts::TAU,
                p.zeta
            );
        }
        for pair in points.windows(2) {
            assert!(pair[1].omega <= pair[0].omega * (1.0 + 1e-8), "mu {mu}");
        }
        onsets.push(points.iter().position(|p| p.zeta > 3e-4).unwrap());
    }
    assert!(onsets[0] < onsets[1] && onsets[1] < onsets[2], "{onsets:?}");
}
