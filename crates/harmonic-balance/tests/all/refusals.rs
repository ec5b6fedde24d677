//! What cannot be started is refused by name, and what does not converge is a status.

use crate::common::{Element, Elements, chain, linearised};
use harmonic_balance::backbone::{self, Accuracy, Kind};
use harmonic_balance::forced::{self, Held, follow};
use harmonic_balance::{Error, Load, NewtonSettings, Reason, Sampling};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

const SAMPLING: Sampling = Sampling {
    harmonics: 3,
    samples: 64,
    periods: 2,
};

fn settings() -> backbone::Settings {
    backbone::Settings {
        mode: 0,
        sampling: SAMPLING,
        accuracy: None,
        newton: NewtonSettings::default(),
    }
}

fn sliders(n: usize) -> Elements {
    Elements::new(vec![
        Element::Jenkins {
            stiffness: 1e3,
            limit: 1.0
        };
        n
    ])
}

#[test]
fn inadmissible_settings_of_backbones_are_named() {
    let (stiffness, mass) = chain(2, 1e4);
    let force = sliders(2);
    let line = linearised(&stiffness, &mass, &force, 2);
    let with = |change: &dyn Fn(&mut backbone::Settings)| {
        let mut settings = settings();
        change(&mut settings);
        settings
    };
    for (name, kind, amplitudes, settings) in [
        ("mode", Kind::Free, vec![1e-3], with(&|s| s.mode = 2)),
        ("harmonics", Kind::Free, vec![1e-3], with(&|s| s.sampling.harmonics = 0)),
        ("samples", Kind::Free, vec![1e-3], with(&|s| s.sampling.samples = 6)),
        ("samples", Kind::Free, vec![1e-3], with(&|s| s.sampling.harmonics = 32)),
        ("periods", Kind::Free, vec![1e-3], with(&|s| s.sampling.periods = 0)),
        ("modal_amplitude", Kind::Free, vec![1e-3, 1e-3], settings()),
        ("modal_amplitude", Kind::Free, vec![f64::NAN], settings()),
        ("modal_amplitude", Kind::Free, vec![-1.0], settings()),
    ] {
        let found = backbone::follow(&line, &force, kind, &amplitudes, &settings, Vec::new(), &mut |_| {
            ControlFlow::Continue(())
        });
        let error = found.expect_err("refused");
        assert!(
            matches!(error, Error::Setting { field, .. } if field == name),
            "{name}: {error}"
        );
    }
    let kind = Kind::PhaseResonance {
        row: &[1.0],
        background: 0.0,
    };
    let found = backbone::follow(&line, &force, kind, &[1e-3], &settings(), Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    });
    assert!(matches!(found, Err(Error::Size { .. })));
    let found = backbone::follow(
        &line,
        &force,
        Kind::Free,
        &[1e-3, 2e-3],
        &settings(),
        Vec::new(),
        &mut |_| ControlFlow::Break(()),
    );
    assert!(matches!(found, Err(Error::Interrupted)));
}

#[test]
fn inadmissible_settings_of_forced_responses_are_named() {
    let (stiffness, mass) = chain(2, 1e4);
    let force = sliders(2);
    let line = linearised(&stiffness, &mass, &force, 2);
    let good = forced::Settings {
        range: [50.0, 60.0],
        sampling: SAMPLING,
        ..forced::Settings::default()
    };
    for (name, level, settings) in [
        ("force", 0.0, good),
        ("force", f64::INFINITY, good),
        (
            "frequency",
            1.0,
            forced::Settings {
                range: [0.0, 1.0],
                ..good
            },
        ),
        (
            "frequency",
            1.0,
            forced::Settings {
                range: [5.0, 5.0],
                ..good
            },
        ),
        (
            "amplitude_step",
            1.0,
            forced::Settings {
                amplitude_step: 0.0,
                ..good
            },
        ),
        (
            "frequency_step",
            1.0,
            forced::Settings {
                frequency_step: 2.0,
                ..good
            },
        ),
    ] {
        let found = follow(
            &line,
            &force,
            &Load::force(&[1.0, 0.0]),
            Held::Force(level),
            &settings,
            &mut |_| ControlFlow::Continue(()),
        );
        let error = found.expect_err("refused");
        assert!(
            matches!(error, Error::Setting { field, .. } if field == name),
            "{name}: {error}"
        );
    }
    let found = follow(
        &line,
        &force,
        &Load::force(&[1.0]),
        Held::Force(1.0),
        &good,
        &mut |_| ControlFlow::Continue(()),
    );
    assert!(matches!(found, Err(Error::Size { .. })));
    // A curve that may have one point alone says that it ends early.
    let few = forced::Settings { max_points: 3, ..good };
    let found = follow(
        &line,
        &force,
        &Load::force(&[1.0, 0.0]),
        Held::Force(1.0),
        &few,
        &mut |_| ControlFlow::Continue(()),
    )
    .expect("a curve");
    assert_eq!(found.points.len(), 3);
    assert_eq!(found.failure.expect("it ends early").reason, Reason::IterationLimit);
}

#[test]
fn motions_that_cannot_be_reached_are_a_status_with_its_history() {
    let (stiffness, mass) = chain(2, 1e4);
    let force = sliders(2);
    let line = linearised(&stiffness, &mass, &force, 2);
    let hopeless = backbone::Settings {
        newton: NewtonSettings {
            tolerance: 1e-300,
            ..NewtonSettings::default()
        },
        ..settings()
    };
    let points = backbone::follow(&line, &force, Kind::Free, &[3e-3], &hopeless, Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    })
    .expect("the settings are admissible");
    let failure = points[0].result.as_ref().expect_err("nothing is that small");
    assert!(!failure.history.is_empty());
}

#[test]
fn a_backbone_out_of_reach_ends_within_its_budget() {
    let (stiffness, mass) = chain(5, 1e4);
    let force = sliders(5);
    let line = linearised(&stiffness, &mass, &force, 5);
    let hopeless = backbone::Settings {
        newton: NewtonSettings {
            tolerance: 1e-300,
            ..NewtonSettings::default()
        },
        ..settings()
    };
    let amplitudes: Vec<f64> = (1..=1000).map(|k| 3e-3 * f64::from(k)).collect();
    let points = backbone::follow(
        &line,
        &force,
        Kind::Free,
        &amplitudes,
        &hopeless,
        Vec::new(),
        &mut |_| ControlFlow::Continue(()),
    )
    .expect("the settings are admissible");
    let failures: Vec<_> = points
        .iter()
        .map(|p| p.result.as_ref().expect_err("too small"))
        .collect();
    assert_ne!(failures[0].reason, Reason::Budget);
    assert_eq!(failures[999].reason, Reason::Budget);
    let spent: usize = points
        .iter()
        .map(|p| p.effort.evaluations + p.effort.krylov_steps)
        .sum();
    // 10 000, what an iteration takes beyond it, and one look at each of the amplitudes left.
    assert!((10_000..12_000).contains(&spent), "{spent}");
}

#[test]
fn periodic_motions_end_where_their_line_is_told_to() {
    let (stiffness, mass) = chain(2, 1e4);
    let force = sliders(2);
    let mut line = linearised(&stiffness, &mass, &force, 2);
    let asked = AtomicUsize::new(0);
    let stop = || asked.fetch_add(1, Ordering::Relaxed) >= 3;
    line.limits = line.limits.until(&stop);
    let mut heard = 0;
    let found = backbone::follow(&line, &force, Kind::Free, &[3e-3], &settings(), Vec::new(), &mut |_| {
        heard += 1;
        ControlFlow::Continue(())
    });
    assert!(matches!(found, Err(Error::Interrupted)), "{found:?}");
    assert_eq!(heard, 0, "within the first amplitude");
    asked.store(0, Ordering::Relaxed);
    let settings = forced::Settings {
        range: [50.0, 60.0],
        ..forced::Settings::default()
    };
    let curve = follow(
        &line,
        &force,
        &Load::force(&[1.0, 0.0]),
        Held::Force(1.0),
        &settings,
        &mut |_| ControlFlow::Continue(()),
    );
    assert!(matches!(curve, Err(Error::Interrupted)));
}

#[test]
fn phase_resonances_meet_an_error_target_too() {
    let (stiffness, mass) = chain(2, 1e4);
    let force = sliders(2);
    let line = linearised(&stiffness, &mass, &force, 2);
    let kind = Kind::PhaseResonance {
        row: &[1.0, 0.0],
        background: 1e-3,
    };
    let target = backbone::Settings {
        sampling: Sampling {
            harmonics: 1,
            samples: 16,
            periods: 2,
        },
        accuracy: Some(Accuracy {
            frequency: 1e-4,
            damping: 1e-2,
            damping_floor: 0.0,
            max_harmonics: 15,
            max_samples: 1024,
        }),
        ..settings()
    };
    let points = backbone::follow(&line, &force, kind, &[1e-3, 3e-3], &target, Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    })
    .expect("the settings are admissible");
    for point in points {
        let motion = point.result.expect("it converges");
        let errors = motion.errors.expect("a target was given");
        assert!(errors.frequency.iter().all(|e| *e <= 1e-4) && errors.damping.iter().all(|e| *e <= 1e-2));
        assert!(motion.force.is_some_and(|force| force > 0.0) && motion.zeta.is_none());
        assert!(motion.energy_error < 1e-8 && motion.residual < 1e-7);
    }
}
