//! The ring-down of the beam in time against its quasi-static backbone.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::beam;
use analyses::transient::{Excitation, Settings, backbones, ring_down, scene_for};
use analyses::{Error, Run, run};
use joint_model::benchmark::RefinementLevel;
use joints::Options;
use joints::progress::Silent;
use std::sync::OnceLock;

const AMPLITUDE: f64 = 2e-3;

fn quick() -> &'static Run {
    static RUN: OnceLock<Run> = OnceLock::new();
    RUN.get_or_init(|| {
        let mut scene = beam("quick");
        scene.model.refinement = RefinementLevel::Quick;
        run(&scene_for(scene, AMPLITUDE), &Options::default(), &Silent).unwrap()
    })
}

#[test]
fn ring_down_and_quasi_static_backbone_agree_within_what_was_measured() {
    let settings = Settings {
        excitation: Excitation::Release(AMPLITUDE),
        periods: 90,
        steps_per_period: 60,
        // What a release from gross slip excites besides changes the damping by 10 %.
        other_damping: 0.05,
        ..Settings::default()
    };
    let ring = ring_down(quick(), &settings, &Silent).unwrap();
    let transient = &ring.transient;
    assert_eq!(transient.samples.len(), 90 * 60 + 1);
    assert_eq!(transient.halved_steps, 0);
    assert!(transient.energy_error() < 1e-4, "{}", transient.energy_error());
    let (found, measured) = ring.identify(&ring.identification()).unwrap();
    let smallest = found
        .backbone
        .iter()
        .map(|p| p.damping_ratio)
        .fold(f64::INFINITY, f64::min);
    assert!(
        transient.algorithmic.damping_ratio.abs() < 1e-3 * smallest,
        "{:?} {smallest}",
        transient.algorithmic
    );
    for (name, theory) in backbones(quick()).unwrap() {
        let misfit = theory.misfit(&measured).unwrap();
        let damping = misfit.damping_ln.unwrap();
        eprintln!("{name}: {misfit:?}");
        assert!(misfit.amplitudes[1] > 5.0 * misfit.amplitudes[0]);
        // RQNMA damps too much at the onset of slip.
        let bound = if name == "rqnma" { 0.2 } else { 0.06 };
        assert!(misfit.frequency_percent.rms < 0.25, "{name}: {misfit:?}");
        assert!(damping.rms < bound, "{name}: {damping:?}");
        if name == "cqsma" {
            let own = ring
                .identified_again(&theory, &ring.identification())
                .unwrap()
                .misfit(&theory)
                .unwrap();
            assert!(own.frequency_percent.rms < 0.06, "{own:?}");
            assert!(own.damping_ln.unwrap().rms < 0.02, "{own:?}");
        }
    }
}

#[test]
fn an_impact_rings_at_the_frequency_of_the_linearised_mode() {
    // Too weak to make anything slip: five periods suffice to count zeros.
    let settings = Settings {
        excitation: Excitation::Impact {
            impulse: 1e-5,
            duration: 1e-3,
        },
        periods: 6,
        steps_per_period: 60,
        other_damping: 0.5,
        ..Settings::default()
    };
    let ring = ring_down(quick(), &settings, &Silent).unwrap();
    assert!(
        ring.transient.energy_error() < 1e-3,
        "{}",
        ring.transient.energy_error()
    );
    let samples = &ring.transient.samples;
    let late: Vec<_> = samples.iter().filter(|s| s.time > 0.5 / ring.frequency_hz).collect();
    let zeros: Vec<f64> = late
        .windows(2)
        .filter(|w| w[0].displacement < 0.0 && w[1].displacement >= 0.0)
        .map(|w| w[0].time - w[0].displacement / (w[1].displacement - w[0].displacement) * (w[1].time - w[0].time))
        .collect();
    let periods = (zeros.len() - 1) as f64;
    let frequency = periods / (zeros[zeros.len() - 1] - zeros[0]) / ring.transient.algorithmic.frequency_ratio;
    assert!(
        (frequency / ring.frequency_hz - 1.0).abs() < 2e-3,
        "{frequency} {}",
        ring.frequency_hz
    );
}

#[test]
fn inadmissible_motions_are_named() {
    let with = |excitation, periods| Settings {
        excitation,
        periods,
        ..Settings::default()
    };
    for (settings, name) in [
        (with(Excitation::Release(f64::NAN), 10), "amplitude"),
        (with(Excitation::Release(1e-6), 0), "periods"),
        (
            with(
                Excitation::Impact {
                    impulse: -1.0,
                    duration: 1e-3,
                },
                10,
            ),
            "impulse",
        ),
    ] {
        let error: Error = ring_down(quick(), &settings, &Silent).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    }
}
