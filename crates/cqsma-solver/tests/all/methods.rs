//! The Masing shortcut and RQNMA against closed loops and closed forms.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use cqsma_solver::cqsma::{self, Cycles};
use cqsma_solver::loading::Settings;
use cqsma_solver::test_problems::{Jenkins, JenkinsChain};
use cqsma_solver::{
    Error, HystereticForce, LinearSolver, Linearisation, LoadingResult, LoopResult, NewtonSettings, NoObserver, Reason,
    Sticking, masing, modes, rqnma,
};
use faer::Mat;
use std::f64::consts::PI;

type State = <Jenkins as HystereticForce>::State;

/// Linearised about rest.
fn at_rest<'a>(stiffness: &'a Mat<f64>, mass: &'a Mat<f64>, force: &Jenkins) -> Linearisation<'a, State> {
    let n = stiffness.nrows();
    let state = force.initial_state();
    let (stiffness, mass) = (stiffness.as_ref(), mass.as_ref());
    let mut line = modes::linearise(stiffness, mass, force, vec![0.0; n], state, 2).unwrap();
    line.orient(&vec![1.0; n]).unwrap();
    line
}

fn chain() -> JenkinsChain {
    JenkinsChain::new(12, 2000.0, (400.0, 1.0))
}

fn closed_loop(line: &Linearisation<'_, State>, force: &Jenkins, alpha: f64, vertices: usize) -> LoopResult {
    let settings = cqsma::Settings {
        vertices_per_quarter: vertices,
        cycles: Cycles::Fixed(2),
        ..cqsma::Settings::default()
    };
    let mut points = cqsma::run(line, force, &[alpha], &settings, |_| NoObserver).unwrap();
    points.remove(0).0.result.unwrap()
}

fn edges(edges: usize) -> Settings {
    Settings {
        edges,
        ..Settings::default()
    }
}

fn all(points: Vec<cqsma_solver::LoadingPoint>) -> Vec<LoadingResult> {
    points.into_iter().map(|p| p.result.unwrap()).collect()
}

#[test]
fn where_masings_rule_holds_the_shortcut_is_the_closed_loop_vertex_by_vertex() {
    let chain = chain();
    let line = at_rest(&chain.stiffness, &chain.mass, &chain.force);
    for alpha in [0.5, 4.0, 9.0, 30.0, 300.0] {
        let closed = closed_loop(&line, &chain.force, alpha, 16);
        let short = &all(masing::run(&line, &chain.force, &[alpha], &edges(32)).unwrap())[0];
        assert!((short.omega / closed.omega - 1.0).abs() < 1e-8, "{alpha}");
        assert!(
            (short.modal_amplitude / closed.modal_amplitude - 1.0).abs() < 1e-8,
            "{alpha}"
        );
        assert!(
            (short.zeta - closed.zeta).abs() < 1e-8,
            "{alpha}: {} {}",
            short.zeta,
            closed.zeta
        );
        assert_eq!(
            short.is_resolved(),
            alpha > 1.0,
            "{alpha}: {} {}",
            short.zeta,
            short.zeta_floor
        );
    }
}

#[test]
fn one_sweep_through_all_amplitudes_is_as_good_as_one_each() {
    let chain = chain();
    let line = at_rest(&chain.stiffness, &chain.mass, &chain.force);
    let forces: Vec<f64> = (0..7).map(|i| 1.5 * 2.0_f64.powi(i)).collect();
    let sweep = all(masing::run(&line, &chain.force, &forces, &edges(64)).unwrap());
    for (alpha, found) in forces.iter().zip(&sweep) {
        let alone = &all(masing::run(&line, &chain.force, &[*alpha], &edges(1000)).unwrap())[0];
        assert!((found.omega / alone.omega - 1.0).abs() < 1e-8);
        assert!((found.modal_force / alpha - 1.0).abs() < 1e-14);
        assert!(
            (found.zeta - alone.zeta).abs() < 2e-4 * (alone.zeta + 1e-3),
            "{} {}",
            found.zeta,
            alone.zeta
        );
    }
}

#[test]
fn one_mass_has_one_shape_and_rqnma_is_the_closed_loop() {
    let (spring, k, limit, m) = (1000.0, 500.0, 2.0, 3.0_f64);
    let force = Jenkins::new(vec![(k, limit)]);
    let (stiffness, mass) = (Mat::from_fn(1, 1, |_, _| spring), Mat::from_fn(1, 1, |_, _| m));
    let line = at_rest(&stiffness, &mass, &force);
    for alpha in [1.0, 5.0, 12.0, 100.0] {
        let closed = closed_loop(&line, &force, alpha, 400);
        let found = &all(rqnma::run(&line, &force, &[closed.modal_amplitude], &edges(800)).unwrap())[0];
        // As close as the tolerance of the residuals.
        assert!((found.omega / closed.omega - 1.0).abs() < 1e-9, "{alpha}");
        let x = closed.modal_amplitude / m.sqrt();
        let exact = if x > limit / k {
            4.0 * limit * (x - limit / k)
        } else {
            0.0
        };
        let energy = 2.0 * PI * (found.modal_amplitude * found.omega).powi(2);
        assert!(
            (found.dissipation - exact).abs() <= 2e-5 * exact + (found.zeta_floor + 1e-12) * energy,
            "{} {exact}",
            found.dissipation
        );
        assert!((found.zeta - found.dissipation / energy).abs() < 1e-15);
    }
}

#[test]
fn rqnma_goes_from_the_mode_with_everything_stuck_to_that_with_everything_sliding() {
    let chain = chain();
    let n = chain.stiffness.nrows();
    let line = at_rest(&chain.stiffness, &chain.mass, &chain.force);
    let amplitudes = [1e-6, 1e-3, 2e-2, 0.1, 1.0, 1e5];
    let points = all(rqnma::run(&line, &chain.force, &amplitudes, &edges(4)).unwrap());

    let small = &points[0];
    assert!((small.omega.powi(2) / line.eigenvalues[0] - 1.0).abs() < 1e-12);
    assert!(!small.is_resolved());
    for i in 0..n {
        assert!((small.displacement[i] / amplitudes[0] - line.shapes[(i, 0)]).abs() < 1e-8);
    }
    // Friction of a bounded force does not matter any more: omega^2 of the bare chain.
    let bare = 2.0 * 2000.0 * (1.0 - (PI / (2 * n + 1) as f64).cos());
    assert!((points[5].omega.powi(2) / bare - 1.0).abs() < 1e-5);

    let state = chain.force.initial_state();
    for (point, q) in points.iter().zip(amplitudes) {
        let v = &point.displacement;
        let (mut end, mut contact) = (state.clone(), vec![0.0; n]);
        chain
            .force
            .evaluate(v, Sticking::Coulomb, &state, &mut end, &mut (), &mut contact, None);
        let square: f64 = v.iter().map(|v| v * v).sum();
        assert!((square.sqrt() / q - 1.0).abs() < 1e-12);
        // K v + F = omega^2 M v, with unit masses.
        for i in 0..n {
            let elastic: f64 = (0..n).map(|j| chain.stiffness[(i, j)] * v[j]).sum();
            let inertia = point.omega.powi(2) * v[i];
            assert!(
                (elastic + contact[i] - inertia).abs() < 1e-7 * point.omega.powi(2) * q,
                "{q} {i}"
            );
        }
    }
    for pair in points.windows(2) {
        assert!(pair[1].omega <= pair[0].omega * (1.0 + 1e-12));
    }
    // The load of the loops keeps the stuck mode's shape, which costs no less energy than the best shape.
    let loops = closed_loop(&line, &chain.force, points[3].modal_force, 8);
    assert!((loops.omega / points[3].omega - 1.0).abs() < 0.05);
}

#[test]
fn both_roads_of_the_bordered_system_agree_also_for_a_higher_mode() {
    let chain = chain();
    let line = at_rest(&chain.stiffness, &chain.mass, &chain.force);
    for mode in [0, 1] {
        let run = |solver| {
            let settings = Settings {
                mode,
                solver,
                ..Settings::default()
            };
            rqnma::run(&line, &chain.force, &[0.02, 0.05, 0.2], &settings).unwrap()
        };
        let (krylov, direct) = (run(LinearSolver::Krylov), run(LinearSolver::Direct));
        assert!(krylov.iter().all(|p| p.effort.factorisations == 0));
        assert!(direct.iter().any(|p| p.effort.factorisations > 0));
        for (a, b) in all(krylov).iter().zip(&all(direct)) {
            assert!((a.omega / b.omega - 1.0).abs() < 1e-9, "{} {}", a.omega, b.omega);
            assert!((a.zeta - b.zeta).abs() < 1e-8);
        }
    }
}

#[test]
fn a_sweep_that_fails_says_why_and_has_no_results_beyond() {
    let chain = chain();
    let line = at_rest(&chain.stiffness, &chain.mass, &chain.force);
    let settings = Settings {
        newton: NewtonSettings {
            max_iterations: 0,
            ..NewtonSettings::default()
        },
        ..Settings::default()
    };
    let forces = [0.1, 0.2, 30.0, 60.0];
    let amplitudes = forces.map(|alpha| alpha / line.eigenvalues[0]);
    for points in [
        masing::run(&line, &chain.force, &forces, &settings).unwrap(),
        rqnma::run(&line, &chain.force, &amplitudes, &settings).unwrap(),
    ] {
        // Without slip the prediction is the solution.
        assert!(points[0].result.is_ok() && points[1].result.is_ok());
        for point in &points[2..] {
            let failure = point.result.as_ref().unwrap_err();
            assert_eq!(failure.reason, Reason::IterationLimit);
            assert!(!failure.history.is_empty());
        }
        assert_eq!(points[3].effort.evaluations, 0);
    }
}

#[test]
fn settings_and_targets_outside_their_range_are_refused_by_name() {
    let chain = chain();
    let line = at_rest(&chain.stiffness, &chain.mass, &chain.force);
    let refused = |targets: &[f64], settings: Settings, name: [&str; 2]| {
        for (result, name) in [
            (masing::run(&line, &chain.force, targets, &settings), name[0]),
            (rqnma::run(&line, &chain.force, targets, &settings), name[1]),
        ] {
            assert!(matches!(result, Err(Error::Setting { field, .. }) if field == name));
        }
    };
    let targets = ["modal_force", "modal_amplitude"];
    refused(&[1.0], edges(0), ["edges"; 2]);
    refused(&[0.0], edges(1), targets);
    refused(&[1.0, 1.0], edges(1), targets);
    refused(&[2.0, 1.0], edges(1), targets);
    refused(&[1.0, f64::NAN], edges(1), targets);
    refused(&[f64::INFINITY], edges(1), targets);
    let settings = Settings {
        mode: 2,
        ..Settings::default()
    };
    refused(&[1.0], settings, ["mode"; 2]);
}
