//! The bar on a frictional layer against its closed form, and what the loops cost.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use cqsma_solver::cqsma::{Commit, Settings, run};
use cqsma_solver::hysteresis::Loop;
use cqsma_solver::newton::Effort;
use cqsma_solver::test_problems::{FrictionalBar, Jenkins, JenkinsChain};
use cqsma_solver::{BackbonePoint, Error, HystereticForce, LoopResult, NoObserver, modes, prestress};
use faer::Mat;

/// Static load, one mode, one loop per modal force.
fn loops(
    stiffness: &Mat<f64>,
    mass: &Mat<f64>,
    force: &Jenkins,
    load: &[f64],
    modal_forces: &[f64],
    settings: &Settings,
) -> Vec<BackbonePoint> {
    let start = vec![0.0; load.len()];
    let (stiffness, mass) = (stiffness.as_ref(), mass.as_ref());
    let rest = prestress::solve(stiffness, force, load, &start, &settings.newton)
        .unwrap()
        .unwrap();
    let mut line = modes::linearise(stiffness, mass, force, rest.displacement, rest.state, 1).unwrap();
    line.orient(&vec![1.0; load.len()]).unwrap();
    let points = run(&line, force, modal_forces, settings, |_| NoObserver).unwrap();
    points.into_iter().map(|(point, _)| point).collect()
}

/// `lambda = sqrt(layer stiffness / EA)` of the bar below (1/m).
const LAMBDA: f64 = 8.0;
const END_MASS: f64 = 3.0;

/// Elements over `lambda_length / lambda` (m).
fn bar(elements: usize, lambda_length: f64) -> FrictionalBar {
    let axial = 2e7;
    let layer = (LAMBDA * LAMBDA * axial, 4e4);
    FrictionalBar::new(elements, lambda_length / LAMBDA, axial, layer, END_MASS)
}

/// Loops with end forces of amplitude `p P_y` about a mean force of `mean P_y`.
fn bar_loops(bar: &FrictionalBar, mean: f64, p: &[f64], vertices_per_quarter: usize) -> Vec<BackbonePoint> {
    let mut load = vec![0.0; bar.mass.nrows()];
    load[0] = mean * bar.onset_force();
    let modal: Vec<f64> = p.iter().map(|p| bar.modal_force(p * bar.onset_force())).collect();
    let mut settings = Settings {
        vertices_per_quarter,
        ..Settings::default()
    };
    // So that what is left of an error belongs to the mesh or the method.
    settings.newton.tolerance = 1e-12;
    loops(&bar.stiffness, &bar.mass, &bar.force, &load, &modal, &settings)
}

fn bar_loop(bar: &FrictionalBar, mean: f64, p: f64, vertices_per_quarter: usize) -> LoopResult {
    bar_loops(bar, mean, &[p], vertices_per_quarter)
        .remove(0)
        .result
        .unwrap()
}

/// End displacement over `u_y` of the mesh: chords between the forces that start the next node.
fn mesh_displacement(p: f64, step: f64) -> f64 {
    let first = (1.0 + 0.25 * step * step).sqrt();
    let at = |p: f64| 0.5 * (1.0 + p * p) - 0.125 * step * step;
    if p <= first {
        return p / first;
    }
    let lower = first + step * ((p - first) / step).floor();
    let upper = lower + step;
    at(lower) + (p - lower) / step * (at(upper) - at(lower))
}

#[test]
fn the_mesh_follows_its_own_closed_form_to_the_solver_tolerance() {
    // Steps for which the onset lies a whole number of steps above zero, so that every corner of the loop is a vertex.
    for per_onset in [2_usize, 5, 11] {
        let step = 1.0 / ((per_onset * per_onset) as f64 - 0.25).sqrt();
        for slipping in [1, 3, 20] {
            let elements = slipping + 2;
            let bar = bar(elements, step * elements as f64);
            let corners = slipping + per_onset;
            let p = step * corners as f64;
            let r = bar_loop(&bar, 0.0, p, corners);
            let q = mesh_displacement(p, step) * bar.onset_displacement() * END_MASS.sqrt();
            assert!(
                (r.modal_amplitude / q - 1.0).abs() < 1e-9,
                "{per_onset} {slipping}: {r:?}"
            );
            // Masing's rule on the chords of the mesh.
            let first = step * per_onset as f64;
            let mut work = 0.5 * first;
            for j in 0..slipping {
                let (a, b) = (first + step * j as f64, first + step * (j + 1) as f64);
                work += 0.5 * (a + b) * (mesh_displacement(b, step) - mesh_displacement(a, step));
            }
            let unit = bar.onset_force() * bar.onset_displacement();
            let area = unit * (8.0 * work - 4.0 * p * mesh_displacement(p, step));
            let error = r.loop_area / area - 1.0;
            assert!(error.abs() < 1e-8, "{per_onset} {slipping}: {error:.1e}");
            assert!(r.shape_deviation < 1e-12, "the mass sees the end alone");
        }
    }
}

#[test]
fn any_amplitude_on_any_mesh_lies_where_the_closed_form_of_the_mesh_says() {
    for elements in [16, 37, 128] {
        let bar = bar(elements, 4.0);
        let step = 4.0 / elements as f64;
        let amplitudes: Vec<f64> = (0..30).map(|i| 0.2 + 0.157 * f64::from(i)).collect();
        for (p, point) in amplitudes.iter().zip(bar_loops(&bar, 0.0, &amplitudes, 2)) {
            let end_force = p * bar.onset_force();
            let u = point.result.unwrap().modal_amplitude / END_MASS.sqrt();
            let mesh = bar.onset_displacement() * mesh_displacement(*p, step);
            assert!(
                (u / mesh - 1.0).abs() < 1e-8,
                "{elements} elements, p = {p}: {u} {mesh}"
            );
            let below = (bar.end_displacement(end_force) - u) / (bar.onset_displacement() * step * step / 8.0);
            assert!(
                (-1e-6..=1.0 + 1e-6).contains(&below),
                "{elements} elements, p = {p}: {below}"
            );
        }
    }
}

#[test]
fn frequency_and_damping_converge_with_second_order() {
    // The front rests on a node of every mesh, and two edges of the loop fall on each element that slips, so that the
    // loop's edges follow the chords of the mesh, and the polygon is the loop of the mesh.
    for (name, slip, lambda_length) in [("micro-slip", 0.25, 0.5), ("long slip", 3.0, 4.0)] {
        let p = 1.0 + slip;
        let meshes = [16, 32, 64, 128, 256];
        let errors: Vec<[f64; 2]> = meshes
            .iter()
            .map(|&elements| {
                let bar = bar(elements, lambda_length);
                let end_force = p * bar.onset_force();
                assert!((bar.slip_length(end_force) * LAMBDA / slip - 1.0).abs() < 1e-12);
                let vertices = (p * elements as f64 / lambda_length).round() as usize;
                let r = bar_loop(&bar, 0.0, p, vertices);
                let Loop { force, amplitude } = &r.hysteresis;
                let edges = force.windows(2).zip(amplitude.windows(2));
                let area: f64 = edges.map(|(f, q)| 0.5 * (f[0] + f[1]) * (q[1] - q[0])).sum();
                let zeta = r.zeta * area / r.loop_area;
                [r.omega / bar.omega(end_force) - 1.0, zeta / bar.zeta(end_force) - 1.0]
            })
            .collect();
        // Leading terms, in (lambda h)^2: the displacement lies 1/8 below; Masing's rule on the chords gives a
        // dissipation that lies (p - 1) / 6 below.
        let displacement = 0.125 / (0.5 * (1.0 + p * p));
        let leading = [0.5 * displacement, displacement - 0.25 / ((p - 1.0) * (p + 2.0))];
        for (quantity, what) in ["frequency", "damping"].into_iter().enumerate() {
            let rates: Vec<f64> = errors
                .windows(2)
                .map(|pair| (pair[0][quantity] / pair[1][quantity]).log2())
                .collect();
            let shown: Vec<String> = errors.iter().map(|e| format!("{:.2e}", e[quantity])).collect();
            println!("{name}, {what}: errors {shown:?}, rates {rates:.3?}");
            assert!(
                (rates[3] - 2.0).abs() < 0.05,
                "{name}, {what}: {shown:?}, rates {rates:.3?}"
            );
            assert!(
                (rates[2] - 2.0).abs() < 0.1,
                "{name}, {what}: {shown:?}, rates {rates:.3?}"
            );
            let expected = leading[quantity] * (lambda_length / 256.0).powi(2);
            let ratio = errors[4][quantity] / expected;
            assert!(
                (ratio - 1.0).abs() < 0.05,
                "{name}, {what}: {shown:?}, {ratio} of the leading term"
            );
        }
    }
}

#[test]
fn stuck_bars_do_not_dissipate() {
    for mean in [0.0, 0.7, 2.5] {
        let bar = bar(64, 4.0);
        for point in bar_loops(&bar, mean, &[1e-6, 0.1, 0.9, 1.0], 8) {
            let r = point.result.unwrap();
            assert!(r.zeta.abs() < 1e-9, "mean {mean}: {r:?}");
            // The mesh's stuck stiffness is the bar's times sqrt(1 + (lambda h)^2 / 4).
            let stuck = bar.omega(0.5 * bar.onset_force()) * (1.0 + 0.25 / 256.0_f64).powf(0.25);
            assert!((r.omega / stuck - 1.0).abs() < 1e-9, "mean {mean}: {} {stuck}", r.omega);
        }
    }
}

#[test]
fn dissipation_starts_with_the_square_of_the_excess_and_ends_with_the_cube_of_the_force() {
    let slopes = |bar: &FrictionalBar, p: &[f64], measure: &dyn Fn(f64) -> f64, vertices| -> Vec<f64> {
        let areas: Vec<f64> = bar_loops(bar, 0.0, p, vertices)
            .into_iter()
            .map(|point| point.result.unwrap().loop_area)
            .collect();
        for (area, p) in areas.iter().zip(p) {
            let exact = bar.dissipation(p * bar.onset_force());
            assert!((area / exact - 1.0).abs() < 5e-3, "p = {p}: {area} {exact}");
        }
        let pairs = p.windows(2).zip(areas.windows(2));
        pairs
            .map(|(p, d)| (d[1] / d[0]).ln() / (measure(p[1]) / measure(p[0])).ln())
            .collect()
    };
    let onset = slopes(&bar(200, 0.2), &[1.01, 1.02, 1.04, 1.08], &|p| p - 1.0, 1200);
    println!("slopes from the onset: {onset:.4?}");
    assert!((onset[0] - 2.0).abs() < 0.01, "{onset:?}");
    assert!(onset.iter().all(|slope| (slope - 2.0).abs() < 0.03), "{onset:?}");
    let long = slopes(&bar(256, 64.0), &[15.0, 30.0, 60.0], &|p| p, 64);
    println!("slopes with long slip: {long:.4?}");
    assert!(long[0] > 3.0 && (long[1] - 3.0).abs() < 0.02, "{long:?}");
}

#[test]
fn a_mean_load_leaves_the_closed_loop_as_it_is() {
    let bar = bar(64, 8.0);
    let amplitudes = [0.9, 1.3, 2.5, 4.0];
    let cold = bar_loops(&bar, 0.0, &amplitudes, 32);
    // Stuck at rest, at the onset, and deep in slip; pulled and pushed.
    for mean in [0.5, 1.0, 3.0, -3.0] {
        for (point, cold) in bar_loops(&bar, mean, &amplitudes, 32).into_iter().zip(&cold) {
            let (r, cold) = (point.result.unwrap(), cold.result.as_ref().unwrap());
            assert!(
                (r.omega / cold.omega - 1.0).abs() < 1e-9,
                "mean {mean}: {} {}",
                r.omega,
                cold.omega
            );
            assert!(
                (r.zeta - cold.zeta).abs() < 1e-8 * cold.zeta + r.zeta_floor + cold.zeta_floor,
                "mean {mean}: {} {}",
                r.zeta,
                cold.zeta
            );
            assert!(r.closure < 1e-8, "mean {mean}: {}", r.closure);
        }
    }
}

#[test]
fn a_massless_bar_has_as_many_modes_as_masses() {
    let bar = bar(32, 4.0);
    let n = bar.mass.nrows();
    let linearise = |mass: &Mat<f64>, n_modes| {
        modes::linearise(
            bar.stiffness.as_ref(),
            mass.as_ref(),
            &bar.force,
            vec![0.0; n],
            bar.force.initial_state(),
            n_modes,
        )
        .map(|line| (line.eigenvalues, line.shapes))
    };
    let (eigenvalues, shapes) = linearise(&bar.mass, 1).unwrap();
    let stuck = bar.omega(bar.onset_force()).powi(2) * (1.0 + 0.25 / 64.0_f64).sqrt();
    assert!((eigenvalues[0] / stuck - 1.0).abs() < 1e-12, "{eigenvalues:?} {stuck}");
    assert!((shapes[(0, 0)].abs() * END_MASS.sqrt() - 1.0).abs() < 1e-12);
    let refused = |mass: &Mat<f64>, n_modes| {
        let error = linearise(mass, n_modes).map(|(eigenvalues, _)| eigenvalues);
        assert!(
            matches!(error, Err(Error::Setting { field: "n_modes", .. })),
            "{error:?}"
        );
    };
    refused(&bar.mass, 2);
    refused(&Mat::zeros(n, n), 1);
    refused(&Mat::from_fn(n, n, |_, _| f64::NAN), 1);
    refused(&Mat::from_fn(n, n, |i, j| if i == j { -1.0 } else { 0.0 }), 1);
    // With a second mass, the sum of 1 / omega^2 is that of either mass alone: the trace of flexibility times mass.
    let far = Mat::from_fn(
        n,
        n,
        |i, j| if i == n - 1 && j == n - 1 { 1e-3 * END_MASS } else { 0.0 },
    );
    let two = &bar.mass + &far;
    let sum = |mass: &Mat<f64>, n_modes| -> f64 { linearise(mass, n_modes).unwrap().0.iter().map(|v| v.recip()).sum() };
    assert!((sum(&two, 2) / (sum(&bar.mass, 1) + sum(&far, 1)) - 1.0).abs() < 1e-12);
    refused(&two, 3);
}

/// What all loops of one problem cost together.
fn total(points: &[BackbonePoint]) -> Effort {
    points.iter().fold(Effort::default(), |mut sum, point| {
        assert!(point.result.is_ok(), "{point:?}");
        sum += point.effort;
        sum
    })
}

#[test]
fn the_loops_cost_what_they_did() {
    let settings = |commit| Settings {
        vertices_per_quarter: 16,
        commit,
        ..Settings::default()
    };
    let chain = |commit| {
        let chain = JenkinsChain::new(12, 2000.0, (400.0, 1.0));
        let mut load = vec![0.0; 12];
        load[11] = 3.0;
        let forces: Vec<f64> = (0..9).map(|i| 0.3 * 2.0_f64.powi(i)).collect();
        total(&loops(
            &chain.stiffness,
            &chain.mass,
            &chain.force,
            &load,
            &forces,
            &settings(commit),
        ))
    };
    let bar = |commit| {
        let bar = bar(64, 8.0);
        let mut load = vec![0.0; bar.mass.nrows()];
        load[0] = 0.8 * bar.onset_force();
        let forces: Vec<f64> = (0..9)
            .map(|i| bar.modal_force(0.5 * 2.0_f64.powf(0.5 * f64::from(i)) * bar.onset_force()))
            .collect();
        total(&loops(
            &bar.stiffness,
            &bar.mass,
            &bar.force,
            &load,
            &forces,
            &settings(commit),
        ))
    };
    // Newton iterations, evaluations of the force, Krylov steps, factorisations. A change that costs more than a tenth
    // more is a regression; one that saves more than a quarter is worth recording, or the next loss goes unseen.
    let table = [
        ("chain", chain(Commit::AtReversals), [321, 1772, 1199, 0]),
        (
            "chain, commits at every vertex",
            chain(Commit::AtEveryVertex),
            [321, 1169, 1199, 0],
        ),
        ("bar", bar(Commit::AtReversals), [775, 2194, 2523, 0]),
        (
            "bar, commits at every vertex",
            bar(Commit::AtEveryVertex),
            [775, 1591, 2523, 0],
        ),
    ];
    let mut found = String::new();
    let mut kept = true;
    for (name, effort, recorded) in table {
        let now = [
            effort.iterations,
            effort.evaluations,
            effort.krylov_steps,
            effort.factorisations,
        ];
        found += &format!("\n{name}: found {now:?}, recorded {recorded:?}");
        kept &= now
            .iter()
            .zip(recorded)
            .all(|(&now, then)| 10 * now <= 11 * then && 4 * now >= 3 * then);
    }
    println!("{found}");
    assert!(
        kept,
        "Newton iterations, evaluations, Krylov steps, factorisations:{found}"
    );
}
