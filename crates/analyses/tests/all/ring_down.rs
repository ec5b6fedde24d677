//! The ring-down of the beam in time against its quasi-static backbone.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::beam;
use analyses::ring_down::RingDown as Found;
use analyses::{Run, run};
use joint_model::benchmark::RefinementLevel;
use joints::Options;
use joints::progress::Silent;
use scenes::{Epmc, Force, Length, Method, RingDown, Strike};
use std::sync::OnceLock;

const AMPLITUDE: f64 = 2e-3;

fn quick() -> &'static Run {
    static RUN: OnceLock<Run> = OnceLock::new();
    RUN.get_or_init(|| {
        let mut scene = beam("quick");
        scene.model.refinement = RefinementLevel::Quick;
        let backbone = &mut scene.analyses.backbone;
        backbone.amplitude_from = Length::from_si(AMPLITUDE / 80.0);
        backbone.amplitude_to = Length::from_si(AMPLITUDE);
        backbone.amplitudes = 24;
        backbone.methods = vec![Method::Rqnma];
        scene.analyses.epmc = Some(Epmc::default());
        scene.analyses.ring_down = Some(RingDown {
            release: Some(Length::from_si(AMPLITUDE)),
            periods: 90,
            steps_per_period: 60,
            // What a release from gross slip excites besides changes the damping by 10 %.
            other_damping: 0.05,
            ..RingDown::default()
        });
        run(&scene, &Options::default(), &Silent).unwrap()
    })
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_ring_down_and_quasi_static_backbone_agree_within_what_was_measured() {
    let Found { motion, identified } = quick().vibration.ring_down.as_ref().unwrap().as_ref().unwrap();
    let ring = identified.as_ref().unwrap();
    let transient = &motion.transient;
    assert_eq!(transient.samples.len(), 90 * 60 + 1);
    assert_eq!(transient.halved_steps, 0);
    assert!(transient.energy_error() < 1e-4, "{}", transient.energy_error());
    let measured = &ring.backbone;
    let smallest = ring
        .identification
        .backbone
        .iter()
        .map(|p| p.damping_ratio)
        .fold(f64::INFINITY, f64::min);
    assert!(
        transient.algorithmic.damping_ratio.abs() < 1e-3 * smallest,
        "{:?} {smallest}",
        transient.algorithmic
    );
    for (name, theory) in &ring.theories {
        let misfit = theory.misfit(measured).unwrap();
        let damping = misfit.damping_ln.unwrap();
        eprintln!("{name}: {misfit:?}");
        assert!(misfit.amplitudes[1] > 5.0 * misfit.amplitudes[0]);
        // RQNMA damps too much at the onset of slip.
        let bound = if name == "rqnma" { 0.2 } else { 0.06 };
        assert!(misfit.frequency_percent.rms < 0.25, "{name}: {misfit:?}");
        assert!(damping.rms < bound, "{name}: {damping:?}");
        if name == "cqsma" {
            let own = ring.own_error.unwrap();
            assert!(own.frequency_percent.rms < 0.06, "{own:?}");
            assert!(own.damping_ln.unwrap().rms < 0.02, "{own:?}");
        }
    }
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_an_impact_rings_at_the_frequency_of_the_linearised_mode() {
    // Too weak to make anything slip: five periods suffice to count zeros.
    let settings = RingDown {
        strike: Some(Strike {
            // An impulse of 1e-5 N s.
            force: Force::from_si(1e-2 * std::f64::consts::FRAC_PI_2),
            contact_time_s: 1e-3,
        }),
        periods: 6,
        steps_per_period: 60,
        other_damping: 0.5,
        ..RingDown::default()
    };
    let mut scene = quick().scene.clone();
    scene.analyses.ring_down = Some(settings);
    let scene = scene.only(&["ring_down".into()]).unwrap();
    let found = run(&scene, &Options::default(), &Silent).unwrap();
    assert!(found.amplitudes().is_empty() && found.first().epmc.is_none());
    // Too short for a backbone to be identified, which leaves the motion.
    let found = found.vibration.ring_down.unwrap().unwrap();
    assert!(found.identified.is_err());
    let ring = found.motion;
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
    let released = RingDown {
        release: Some(Length::from_si(1e-6)),
        ..RingDown::default()
    };
    let strike = |force: f64| {
        Some(Strike {
            force: Force::from_si(force),
            contact_time_s: 1e-3,
        })
    };
    let refused = [
        (RingDown::default(), "analyses.ring_down = 0 (of release and strike)"),
        (
            RingDown {
                strike: strike(1.0),
                ..released.clone()
            },
            "analyses.ring_down = 2",
        ),
        (
            RingDown {
                release: Some(Length::from_si(-1.0)),
                ..released.clone()
            },
            "analyses.ring_down.release = -1 m",
        ),
        (
            RingDown {
                release: None,
                strike: strike(-1.0),
                ..released.clone()
            },
            "analyses.ring_down.strike.force = -1 N",
        ),
        (
            RingDown {
                periods: 0,
                ..released.clone()
            },
            "analyses.ring_down.periods = 0",
        ),
        (
            RingDown {
                periods: 1 << 40,
                ..released.clone()
            },
            "1e7 steps",
        ),
        (
            RingDown {
                spectral_radius: 1.5,
                ..released
            },
            "analyses.ring_down.spectral_radius = 1.5",
        ),
    ];
    for (settings, part) in refused {
        let mut scene = beam("quick");
        scene.analyses.ring_down = Some(settings);
        let text = scene.validate("joint").unwrap_err().to_string();
        assert!(text.contains(part), "{text}");
    }
}
