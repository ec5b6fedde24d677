//! Periodic motions of the coarse beam: against motions in time, for any number of threads, after interruptions.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::beam;
use analyses::{Prepared, Run, prepare, run};
use cqsma_solver::transient::{self, Start};
use cqsma_solver::{Linearisation, NewtonSettings, modes, prestress};
use harmonic_balance::backbone::Motion;
use harmonic_balance::{Harmonics, Load, Sampling, forced};
use joint_model::benchmark::RefinementLevel;
use joints::Options;
use joints::interface::InterfaceForce;
use joints::progress::{Progress, Silent, Stage};
use scenes::{Amplitudes, Epmc, ModalAmplitude, SamplingAccuracy, Scene};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use test_support::TemporaryFolder;
use zte_assembly::State;

fn quick() -> Scene {
    let mut scene = beam("quick");
    scene.model.refinement = RefinementLevel::Quick;
    scene.analyses.backbone.amplitudes = 0;
    scene
}

fn linearised<'a>(prepared: &'a Prepared, force: &InterfaceForce<'_>) -> Linearisation<'a, State> {
    let reduced = &prepared.model().reduced;
    let (stiffness, mass) = (reduced.stiffness.as_ref(), reduced.mass.as_ref());
    let (load, start) = (prepared.static_load(), prepared.start());
    let rest = prestress::solve(stiffness, force, &load, &start, &NewtonSettings::default())
        .unwrap()
        .unwrap();
    modes::linearise(stiffness, mass, force, rest.displacement, rest.state, 10).unwrap()
}

/// Displacement and its derivatives at time zero.
fn at_zero(motion: &Harmonics, omega: f64) -> [Vec<f64>; 3] {
    let n = motion.size();
    let mut parts = [motion.column(0).to_vec(), vec![0.0; n], vec![0.0; n]];
    for h in 1..=motion.count() {
        let ([c, s], rate) = (motion.pair(h), h as f64 * omega);
        for i in 0..n {
            parts[0][i] += c[i];
            parts[1][i] += rate * s[i];
            parts[2][i] -= rate * rate * c[i];
        }
    }
    parts
}

/// Cosine and sine of the first harmonic of samples, by least squares with the mean and harmonics up to the fifth.
fn first_harmonic(samples: &[(f64, f64)], omega: f64) -> [f64; 2] {
    let columns = 11;
    let row = |t: f64| -> Vec<f64> {
        let harmonics = (1..=5).flat_map(|h| [(f64::from(h) * omega * t).cos(), (f64::from(h) * omega * t).sin()]);
        std::iter::once(1.0).chain(harmonics).collect()
    };
    let rows: Vec<Vec<f64>> = samples.iter().map(|(t, _)| row(*t)).collect();
    let normal = faer::Mat::from_fn(columns, columns, |i, j| rows.iter().map(|r| r[i] * r[j]).sum::<f64>());
    let right: Vec<f64> = (0..columns)
        .map(|i| rows.iter().zip(samples).map(|(r, (_, y))| r[i] * y).sum())
        .collect();
    let found = dense_algebra::solve_general(normal, &right).unwrap();
    [found[1], found[2]]
}

/// Differences of the first harmonic between forced responses and motions in time of so many periods that begin with them, below the resonance, at it, and
/// above.
///
/// Fast motions, which the start excites and nothing else damps, would shake the friction loose: without numerical damping the difference grows to 1e-2
/// within 80 periods. The scheme makes frequencies smaller by a known ratio, which counts 1 / (2 zeta) times at the resonance: it is driven so much
/// more slowly.
fn differences_in_time(periods: usize) -> Vec<f64> {
    let prepared = prepare(&quick(), &Options::default(), &Silent).unwrap();
    let force = InterfaceForce::new(&prepared.interface().interface);
    let line = linearised(&prepared, &force);
    let row: Vec<f64> = prepared.model().reduced.recovery.row(0).iter().copied().collect();
    let (level, background) = (4.0, 5e-3);
    let (steps, radius) = (400, 0.5);
    let mut differences = Vec::new();
    for hertz in [163.0, 167.0, 171.0] {
        let settings = forced::Settings {
            range: [TAU * hertz, TAU * (hertz + 0.01)],
            sampling: Sampling {
                harmonics: 7,
                samples: 512,
                periods: 2,
            },
            background,
            ..forced::Settings::default()
        };
        let curve = forced::follow(
            &line,
            &force,
            &Load::force(&row),
            forced::Held::Force(level),
            &settings,
            &mut |_| ControlFlow::Continue(()),
        )
        .unwrap();
        let point = &curve.points[0];
        let omega = point.omega * transient::algorithmic_error(radius, steps as f64).frequency_ratio;
        let start = Start::Driven {
            amplitude: level,
            omega,
            point: row.clone(),
            motion: at_zero(&point.displacement, omega),
        };
        let settings = transient::Settings {
            steps_per_period: steps,
            periods,
            spectral_radius: radius,
            background_damping: background,
            ..transient::Settings::default()
        };
        let found = transient::run(&line, &force, &row, &start, &settings, &mut |_| {
            ControlFlow::Continue(())
        })
        .unwrap();
        assert!(found.failure.is_none());
        let last: Vec<(f64, f64)> = found.samples[(periods - 3) * steps..]
            .iter()
            .map(|s| (s.time, s.displacement))
            .collect();
        let [c, s] = first_harmonic(&last, omega);
        let along = point.displacement.along(&row);
        let difference = (c - along[1]).hypot(s - along[2]) / along[1].hypot(along[2]);
        differences.push(difference);
    }
    differences
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_forced_responses_are_those_of_the_motion_in_time() {
    // The small difference at the start still beats with the frequency of the force.
    let found = differences_in_time(8);
    assert!(found.iter().all(|difference| *difference < 5e-3), "{found:?}");
}

#[test]
#[ignore = "a minute; `.ci/run slow` runs it"]
fn slow_forced_responses_are_those_of_the_stationary_motion_in_time() {
    let found = differences_in_time(80);
    assert!(found.iter().all(|difference| *difference < 1e-3), "{found:?}");
}

fn with_epmc(epmc: Epmc) -> Scene {
    let mut scene = quick();
    scene.analyses.epmc = Some(epmc);
    scene
}

fn amplitudes(values: &[f64]) -> Option<Amplitudes> {
    Some(Amplitudes::List(
        values.iter().map(|q| ModalAmplitude::from_si(*q)).collect(),
    ))
}

fn motions(run: &Run) -> Vec<Motion> {
    let epmc = run.first().epmc.as_ref().unwrap();
    epmc.points.iter().map(|p| p.result.clone().unwrap()).collect()
}

/// Stops a run after some periodic motions.
struct StopAfter(usize, AtomicUsize);

impl Progress for StopAfter {
    fn fraction(&self, stage: Stage, _done: f64) {
        if stage == Stage::Epmc {
            self.1.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn interrupted(&self) -> bool {
        self.1.load(Ordering::Relaxed) >= self.0
    }
}

#[test]
fn threads_and_interruptions_change_no_bit_of_periodic_motions() {
    let scene = with_epmc(Epmc {
        modal_amplitudes: amplitudes(&[1e-5, 1e-4, 2e-4, 4e-4]),
        ..Epmc::default()
    });
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    let whole = pool(1).install(|| motions(&run(&scene, &Options::default(), &Silent).unwrap()));
    let more = pool(3).install(|| motions(&run(&scene, &Options::default(), &Silent).unwrap()));
    assert!(whole == more, "one thread and three");
    let folder = TemporaryFolder::new("periodic");
    let options = Options {
        cache: Some(folder.to_path_buf()),
        ..Options::default()
    };
    let stopped = run(&scene, &options, &StopAfter(2, AtomicUsize::new(0)));
    assert!(stopped.is_err());
    // Two of the four are not computed again.
    let progress = StopAfter(usize::MAX, AtomicUsize::new(0));
    let resumed = run(&scene, &options, &progress).unwrap();
    assert!(whole == motions(&resumed), "resumed");
    assert_eq!(progress.1.load(Ordering::Relaxed), 2);
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_harmonics_and_samples_follow_from_an_error_target() {
    let amplitude = 3e-4;
    let found = |epmc: Epmc| motions(&run(&with_epmc(epmc), &Options::default(), &Silent).unwrap()).remove(0);
    let fine = found(Epmc {
        modal_amplitudes: amplitudes(&[amplitude]),
        harmonics: 15,
        samples: 1024,
        ..Epmc::default()
    });
    let target = SamplingAccuracy {
        frequency: 1e-5,
        damping: 1e-3,
    };
    let chosen = found(Epmc {
        modal_amplitudes: amplitudes(&[amplitude]),
        harmonics: 1,
        samples: 16,
        accuracy: Some(target),
        ..Epmc::default()
    });
    let errors = chosen.errors.unwrap();
    println!("{:?} {errors:?}", chosen.sampling);
    assert!(chosen.sampling.harmonics > 1 && chosen.sampling.samples > 16);
    assert!(errors.frequency.iter().all(|e| *e <= target.frequency));
    let zeta = fine.zeta.unwrap();
    assert!(
        (chosen.omega / fine.omega - 1.0).abs() < 3.0 * target.frequency,
        "{} {}",
        chosen.omega,
        fine.omega
    );
    assert!(
        (chosen.zeta.unwrap() / zeta - 1.0).abs() < 5.0 * target.damping,
        "{:?} {zeta}",
        chosen.zeta
    );
}
