//! Structures whose loops are known in closed form.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use cqsma_solver::cqsma::{Cycles, Settings, run};
use cqsma_solver::newton::NewtonSettings;
use cqsma_solver::test_problems::{Jenkins, JenkinsChain};
use cqsma_solver::{HystereticForce, NoObserver, modes, prestress};
use faer::Mat;

/// Prestresses, linearises and runs; returns `(alpha, omega, zeta, q, area, iterations)` per amplitude.
fn backbone(
    stiffness: &Mat<f64>,
    mass: &Mat<f64>,
    force: &Jenkins,
    load: &[f64],
    forces: &[f64],
    settings: &Settings,
) -> Vec<(f64, f64, f64, f64, f64)> {
    let start = vec![0.0; stiffness.nrows()];
    let rest = prestress::solve(stiffness.as_ref(), force, load, &start, &NewtonSettings::default())
        .unwrap()
        .unwrap();
    let mut line = modes::linearise(
        stiffness.as_ref(),
        mass.as_ref(),
        force,
        rest.displacement,
        rest.state,
        1,
    )
    .unwrap();
    line.orient(&vec![1.0; start.len()]).unwrap();
    run(&line, force, forces, settings, |_| NoObserver)
        .unwrap()
        .into_iter()
        .map(|(point, _)| {
            let r = point.result.unwrap();
            (point.modal_force, r.omega, r.zeta, r.modal_amplitude, r.loop_area)
        })
        .collect()
}

#[test]
fn one_jenkins_element_follows_its_closed_form() {
    let (spring, k, limit, m) = (1000.0, 500.0, 2.0, 3.0_f64);
    let force = Jenkins::new(vec![(k, limit)]);
    let stiffness = Mat::from_fn(1, 1, |_, _| spring);
    let mass = Mat::from_fn(1, 1, |_, _| m);
    let stuck = ((spring + k) / m).sqrt();
    let forces: Vec<f64> = [1.0, 5.9, 6.1, 12.0, 100.0, 1e4].iter().map(|p| p / m.sqrt()).collect();
    for (alpha, omega, zeta, q, area) in backbone(&stiffness, &mass, &force, &[0.0], &forces, &Settings::default()) {
        let peak = alpha * m.sqrt();
        let stick = peak <= limit * (spring + k) / k;
        let x = if stick {
            peak / (spring + k)
        } else {
            (peak - limit) / spring
        };
        let exact_area = if stick { 0.0 } else { 4.0 * limit * (x - limit / k) };
        let exact_omega = (peak / (m * x)).sqrt();
        assert!((q / (x * m.sqrt()) - 1.0).abs() < 1e-8, "{peak}");
        assert!((omega / exact_omega - 1.0).abs() < 1e-8);
        assert!(omega <= stuck * (1.0 + 1e-8));
        // The corner of the loop falls between vertices: the polygon cuts at most one edge's triangle at each.
        let edge = peak / 4.0;
        assert!(
            (area - exact_area).abs() <= 0.5 * edge * edge / spring + 1e-9 * peak * x,
            "{area} {exact_area}"
        );
        assert!((zeta - area / (2.0 * std::f64::consts::PI * peak * x)).abs() < 1e-9);
    }
}

#[test]
fn the_area_of_a_loop_with_corners_converges_with_second_order_in_the_vertices() {
    let force = Jenkins::new(vec![(500.0, 2.0)]);
    let stiffness = Mat::from_fn(1, 1, |_, _| 1000.0);
    let mass = Mat::identity(1, 1);
    let exact = 4.0 * 2.0 * (0.018 - 2.0 / 500.0);
    let errors: Vec<f64> = [4, 8, 16, 32, 64]
        .iter()
        .map(|&n| {
            let settings = Settings {
                vertices_per_quarter: n,
                ..Settings::default()
            };
            (backbone(&stiffness, &mass, &force, &[0.0], &[20.0], &settings)[0].4 - exact).abs()
        })
        .collect();
    // The corner moves through the edges, so the order shows over several refinements only.
    assert!(errors[4] < errors[0] / 30.0, "{errors:?}");
    assert!(errors[4] < 2e-3 * exact, "{errors:?}");
}

#[test]
fn a_chain_dissipates_what_its_sliders_do_and_masing_holds() {
    let chain = JenkinsChain::new(12, 2000.0, (400.0, 1.0));
    let mut load = vec![0.0; 12];
    load[11] = 3.0;
    let settings = Settings {
        vertices_per_quarter: 64,
        ..Settings::default()
    };
    let forces: Vec<f64> = (0..9).map(|i| 0.3 * 2.0_f64.powi(i)).collect();
    let points = backbone(&chain.stiffness, &chain.mass, &chain.force, &load, &forces, &settings);
    for pair in points.windows(2) {
        assert!(pair[1].1 <= pair[0].1 * (1.0 + 1e-9), "frequency falls: {pair:?}");
        assert!(
            pair[1].4 >= pair[0].4 * (1.0 - 1e-9) - 1e-12,
            "dissipation rises: {pair:?}"
        );
    }
    assert!(points[0].2.abs() < 1e-8, "all stuck: {:?}", points[0]);
    // Masing: the loop's area from the initial loading curve of an unloaded chain, 8 int f dx - 4 f x.
    let peak = forces[6];
    let cold = backbone(
        &chain.stiffness,
        &chain.mass,
        &chain.force,
        &[0.0; 12],
        &[peak],
        &settings,
    )[0];
    let n = 400;
    let loading: Vec<f64> = (1..=n)
        .map(|i| {
            let a = peak * f64::from(i) / f64::from(n);
            let one = Settings {
                vertices_per_quarter: 1,
                cycles: Cycles::Fixed(1),
                ..settings
            };
            let p = backbone(&chain.stiffness, &chain.mass, &chain.force, &[0.0; 12], &[a], &one)[0];
            // Symmetric loop: the amplitude is the displacement of the initial loading curve.
            p.3
        })
        .collect();
    let mut integral = 0.0;
    let mut last = (0.0, 0.0);
    for (i, q) in loading.iter().enumerate() {
        let a = peak * (i + 1) as f64 / f64::from(n);
        integral += 0.5 * (a + last.0) * (q - last.1);
        last = (a, *q);
    }
    let masing = 8.0 * integral - 4.0 * peak * last.1;
    assert!((cold.4 / masing - 1.0).abs() < 1e-3, "{} {masing}", cold.4);
}

#[test]
fn prestress_slip_contaminates_the_first_cycle_only() {
    let chain = JenkinsChain::new(6, 2000.0, (400.0, 1.0));
    let mut load = vec![0.0; 6];
    // Pulled backwards, so that the first cycle slips on its way back only.
    load[5] = -10.0;
    let area = |cycles| {
        let settings = Settings {
            cycles: Cycles::Fixed(cycles),
            ..Settings::default()
        };
        backbone(&chain.stiffness, &chain.mass, &chain.force, &load, &[8.0], &settings)[0].4
    };
    // Its loop is open: it has not gone back to where the static load left it.
    let [first, second, third] = [1, 2, 3].map(area);
    assert!((first / third - 1.0).abs() > 1e-3, "{first} {third}");
    assert!((second / third - 1.0).abs() < 1e-6, "{second} {third}");
}

#[test]
fn bad_settings_and_loose_structures_are_refused() {
    let force = Jenkins::new(vec![(0.0, 1.0)]);
    let loose = Mat::<f64>::zeros(1, 1);
    let newton = NewtonSettings::default();
    assert!(prestress::solve(loose.as_ref(), &force, &[1.0], &[0.0], &newton).is_err());
    assert!(prestress::solve(loose.as_ref(), &force, &[1.0, 2.0], &[0.0], &newton).is_err());
    let firm = Mat::<f64>::identity(1, 1);
    let state = force.initial_state();
    let line = modes::linearise(firm.as_ref(), firm.as_ref(), &force, vec![0.0], state, 1).unwrap();
    for (forces, settings) in [
        (vec![-1.0], Settings::default()),
        (vec![f64::NAN], Settings::default()),
        (
            vec![1.0],
            Settings {
                mode: 4,
                ..Settings::default()
            },
        ),
        (
            vec![1.0],
            Settings {
                cycles: Cycles::Fixed(0),
                ..Settings::default()
            },
        ),
        (
            vec![1.0],
            Settings {
                vertices_per_quarter: 0,
                ..Settings::default()
            },
        ),
    ] {
        assert!(run(&line, &force, &forces, &settings, |_| NoObserver).is_err());
    }
}

#[test]
fn linearised_modes_of_the_stuck_chain_are_the_closed_form() {
    // Fixed-free chain with equal springs c and a stuck slider k on every mass: omega_j^2 = k + 2 c (1 - cos theta_j),
    // theta_j = (2 j - 1) pi / (2 n + 1).
    let (n, c, k) = (40, 2000.0, 400.0);
    let chain = JenkinsChain::new(n, c, (k, 1.0));
    let state = chain.force.initial_state();
    let line = modes::linearise(
        chain.stiffness.as_ref(),
        chain.mass.as_ref(),
        &chain.force,
        vec![0.0; n],
        state,
        6,
    )
    .unwrap();
    for (j, value) in line.eigenvalues.iter().enumerate() {
        let theta = (2 * j + 1) as f64 * std::f64::consts::PI / (2 * n + 1) as f64;
        let exact = k + 2.0 * c * (1.0 - theta.cos());
        assert!((value / exact - 1.0).abs() < 1e-11, "{j}: {value} {exact}");
        // The shapes are sines with unit modal mass.
        let norm: f64 = (1..=n).map(|i| (theta * i as f64).sin().powi(2)).sum::<f64>().sqrt();
        let overlap: f64 = (1..=n)
            .map(|i| (theta * i as f64).sin() / norm * line.shapes[(i - 1, j)])
            .sum::<f64>()
            .abs();
        assert!((overlap - 1.0).abs() < 1e-10, "{j}: {overlap}");
    }
}
