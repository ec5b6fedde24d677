//! Derivatives of loops against central differences of whole analyses, and against a closed form.
#![allow(clippy::unwrap_used, reason = "a test that fails may panic")]

use cqsma_solver::cqsma::{self, Cycles, Settings};
use cqsma_solver::prestress::{self, Prestress};
use cqsma_solver::sensitivity::{Change, Derivatives, LoopRate, static_rates};
use cqsma_solver::test_problems::{FrictionalBar, Jenkins, JenkinsChain};
use cqsma_solver::{LoopResult, NewtonSettings, NoObserver, modes};
use faer::Mat;

const N: usize = 6;
/// The mode shapes of neighbouring chains have the same sign there.
const FIRST: [f64; N] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];

/// A chain whose springs, masses, sliders and static load depend on one parameter each.
struct Chain {
    stiffness: Mat<f64>,
    mass: Mat<f64>,
    force: Jenkins,
    load: Vec<f64>,
}

/// Parameters: spring, mass, stiffness and limit of the sliders, load.
fn chain([spring, mass, stiffness, limit, load]: [f64; 5]) -> Chain {
    let chain = JenkinsChain::new(N, spring, (stiffness, limit));
    let sliders = (0..N).map(|i| (stiffness * (1.0 + 0.1 * i as f64), limit * (0.3 + 0.2 * i as f64)));
    Chain {
        stiffness: chain.stiffness,
        mass: Mat::from_fn(N, N, |i, j| if i == j { mass * (1.0 + 0.05 * i as f64) } else { 0.0 }),
        force: Jenkins::new(sliders.collect()),
        load: (0..N).map(|i| load * i as f64).collect(),
    }
}

const MIDDLE: [f64; 5] = [2.0, 1.3, 1.5, 1.0, 0.05];

fn settings() -> Settings {
    Settings {
        vertices_per_quarter: 5,
        cycles: Cycles::Fixed(2),
        newton: NewtonSettings {
            tolerance: 1e-12,
            ..NewtonSettings::default()
        },
        ..Settings::default()
    }
}

fn at_rest(chain: &Chain) -> Prestress<<Jenkins as cqsma_solver::HystereticForce>::State> {
    let start = vec![0.0; N];
    let newton = settings().newton;
    let found = prestress::solve(chain.stiffness.as_ref(), &chain.force, &chain.load, &start, &newton);
    found.unwrap().unwrap()
}

fn backbone(chain: &Chain, forces: &[f64]) -> Vec<LoopResult> {
    let rest = at_rest(chain);
    let mut line = modes::linearise(
        chain.stiffness.as_ref(),
        chain.mass.as_ref(),
        &chain.force,
        rest.displacement,
        rest.state,
        3,
    )
    .unwrap();
    line.orient(&FIRST).unwrap();
    let points = cqsma::run(&line, &chain.force, forces, &settings(), |_| NoObserver).unwrap();
    points.into_iter().map(|(point, _)| point.result.unwrap()).collect()
}

/// Derivatives of the loops at `forces` with respect to all parameters.
fn rates(forces: &[f64]) -> Vec<Vec<LoopRate>> {
    let middle = chain(MIDDLE);
    let rest = at_rest(&middle);
    let mut line = modes::linearise(
        middle.stiffness.as_ref(),
        middle.mass.as_ref(),
        &middle.force,
        rest.displacement.clone(),
        rest.state.clone(),
        3,
    )
    .unwrap();
    line.orient(&FIRST).unwrap();
    let step = 1e-4;
    let neighbours: Vec<[Chain; 2]> = (0..5)
        .map(|which| [step, -step].map(|by| chain(shifted(which, by))))
        .collect();
    let quotient = |a: &Mat<f64>, b: &Mat<f64>| Mat::from_fn(N, N, |i, j| (a[(i, j)] - b[(i, j)]) / (2.0 * step));
    let matrices: Vec<[Mat<f64>; 2]> = neighbours
        .iter()
        .map(|[a, b]| [quotient(&a.stiffness, &b.stiffness), quotient(&a.mass, &b.mass)])
        .collect();
    let loads: Vec<Vec<f64>> = neighbours
        .iter()
        .map(|[a, b]| {
            a.load
                .iter()
                .zip(&b.load)
                .map(|(a, b)| (a - b) / (2.0 * step))
                .collect()
        })
        .collect();
    let of_sliders = |stiffness: f64, limit: f64| -> Option<Vec<(f64, f64)>> {
        let of = |i: usize| (stiffness * (1.0 + 0.1 * i as f64), limit * (0.3 + 0.2 * i as f64));
        Some((0..N).map(of).collect())
    };
    let sliders = [None, None, of_sliders(1.0, 0.0), of_sliders(0.0, 1.0), None];
    let changes = || -> Vec<Change<'_, Jenkins>> {
        (0..5)
            .map(|which| Change {
                step,
                force: sliders[which].as_ref(),
                stiffness: vec![(1.0, matrices[which][0].as_ref().into())],
                mass: vec![(1.0, matrices[which][1].as_ref().into())],
                load: Some(&loads[which]),
            })
            .collect()
    };
    let statics = static_rates(middle.stiffness.as_ref(), &middle.force, &rest, &changes()).unwrap();
    let derivatives = Derivatives::try_new(&line, &middle.force, 0, changes(), &statics)
        .unwrap()
        .unwrap();
    let points = cqsma::run_differentiated(&line, &middle.force, forces, &settings(), &derivatives, |_| NoObserver);
    let points = points.unwrap().into_iter();
    points.map(|(point, _)| point.result.unwrap().rates.unwrap()).collect()
}

fn shifted(which: usize, by: f64) -> [f64; 5] {
    let mut shifted = MIDDLE;
    shifted[which] += by;
    shifted
}

/// Loops of neighbouring chains at the modal amplitude of the middle one: the modal force is found by the secant method.
#[test]
fn derivatives_are_those_of_whole_analyses_at_the_same_amplitude() {
    let forces = [0.05, 0.4, 0.9, 1.7, 4.0];
    let found = rates(&forces);
    let middle = backbone(&chain(MIDDLE), &forces);
    for (which, name) in ["spring", "mass", "slider", "limit", "load"].iter().enumerate() {
        for (i, target) in middle.iter().enumerate() {
            let step = 1e-5;
            let at = |by: f64| -> LoopResult {
                let varied = chain(shifted(which, by));
                let goal = target.modal_amplitude.ln();
                let [mut a, mut b] = [forces[i], forces[i] * 1.0001];
                let of = |force: f64| backbone(&varied, &[force]).remove(0);
                let mut last = of(a);
                for _ in 0..30 {
                    let next = of(b);
                    let (fa, fb) = (last.modal_amplitude.ln() - goal, next.modal_amplitude.ln() - goal);
                    last = next;
                    if fb.abs() < 1e-13 || fa == fb {
                        break;
                    }
                    let c = b - fb * (b - a) / (fb - fa);
                    (a, b) = (b, c);
                }
                last
            };
            let (above, below) = (at(step), at(-step));
            let central = |of: &dyn Fn(&LoopResult) -> f64| (of(&above).ln() - of(&below).ln()) / (2.0 * step);
            let rate = &found[i][which];
            let omega = central(&|l| l.omega);
            assert!(
                (rate.ln_omega - omega).abs() < 1e-5 * omega.abs().max(1e-3),
                "{name}, force {}: {} against {omega}",
                forces[i],
                rate.ln_omega
            );
            let harmonic = central(&|l| l.harmonic_omega);
            assert!(
                (rate.ln_harmonic_omega - harmonic).abs() < 1e-5 * harmonic.abs().max(1e-3),
                "{name}, force {}: first harmonic {} against {harmonic}",
                forces[i],
                rate.ln_harmonic_omega
            );
            if target.is_resolved() {
                let zeta = central(&|l| l.harmonic_zeta());
                let own = rate.ln_harmonic_zeta.unwrap();
                assert!(
                    (own - zeta).abs() < 1e-5 * zeta.abs().max(1e-2),
                    "{name}: first harmonic {own} against {zeta}"
                );
                let zeta = central(&|l| l.zeta);
                let [own, dissipated] = [rate.ln_zeta, rate.ln_dissipation].map(Option::unwrap);
                assert!(
                    (own - zeta).abs() < 1e-5 * zeta.abs().max(1e-2),
                    "{name}, force {}: {} against {zeta}",
                    forces[i],
                    own
                );
                let work = central(&|l| l.loop_area);
                assert!((dissipated - work).abs() < 1e-5 * work.abs().max(1e-2));
            }
        }
    }
}

/// Of a bar whose friction is limited everywhere by `f`, all results are functions of the force over `f`.
#[test]
fn the_limit_of_a_frictional_bar_scales_its_amplitude() {
    let limit = 3.0;
    let bar = |limit: f64| FrictionalBar::new(600, 4.0, 2.0, (5.0, limit), 1.7);
    let middle = bar(limit);
    let n = middle.stiffness.nrows();
    let force = middle.modal_force(1.6 * middle.onset_force());
    let newton = settings().newton;
    let zero = vec![0.0; n];
    let rest = prestress::solve(middle.stiffness.as_ref(), &middle.force, &zero, &zero, &newton);
    let rest = rest.unwrap().unwrap();
    let line = modes::linearise(
        middle.stiffness.as_ref(),
        middle.mass.as_ref(),
        &middle.force,
        rest.displacement.clone(),
        rest.state.clone(),
        1,
    )
    .unwrap();
    let step = 1e-6 * limit;
    let share = |i: usize| if i == 0 || i + 1 == n { 0.5 } else { 1.0 };
    let by_limit: Vec<(f64, f64)> = (0..n).map(|i| (0.0, 4.0 / 600.0 * share(i))).collect();
    let changes = || {
        vec![Change {
            step,
            force: Some(&by_limit),
            stiffness: Vec::new(),
            mass: Vec::new(),
            load: None,
        }]
    };
    let statics = static_rates(middle.stiffness.as_ref(), &middle.force, &rest, &changes()).unwrap();
    let derivatives = Derivatives::try_new(&line, &middle.force, 0, changes(), &statics)
        .unwrap()
        .unwrap();
    let points = cqsma::run_differentiated(&line, &middle.force, &[force], &settings(), &derivatives, |_| {
        NoObserver
    });
    let found = points.unwrap().remove(0).0.result.unwrap();
    let rate = found.rates.unwrap()[0];
    // omega = omega(Q / f), so that d ln omega / d ln f = -d ln omega / d ln Q, which the closed form gives.
    let of = |end_force: f64| {
        (
            middle.omega(end_force).ln(),
            middle.zeta(end_force).ln(),
            middle.end_displacement(end_force).ln(),
        )
    };
    let p = 1.6 * middle.onset_force();
    let ((omega_a, zeta_a, q_a), (omega_b, zeta_b, q_b)) = (of(1.001 * p), of(0.999 * p));
    let (omega, zeta) = (-(omega_a - omega_b) / (q_a - q_b), -(zeta_a - zeta_b) / (q_a - q_b));
    assert!(
        (limit * rate.ln_omega - omega).abs() < 1e-2 * omega.abs(),
        "{} {omega}",
        limit * rate.ln_omega
    );
    assert!(
        (limit * rate.ln_zeta.unwrap() - zeta).abs() < 2e-2 * zeta.abs(),
        "{} {zeta}",
        limit * rate.ln_zeta.unwrap()
    );
}
