//! Matrices with contact at single nodes, preloaded without bolts: elastic dry friction of benchmarks.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::BENCHMARKS;
use crate::common::points::{Slider, folder, read, scene, set, solve, try_run, write};
use analyses::Error;
use analyses::results::summary::Summary;
use faer::Mat;
use joints::interface::SceneInterface;
use joints::progress::Silent;
use joints::structure::{Structure, export};
use matrix_files::npz;
use scenes::Scene;
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::path::Path;

fn refused(scene: &Value) -> String {
    try_run(scene).unwrap_err().to_string()
}

#[test]
fn a_point_of_constant_pressure_follows_the_closed_form_of_a_jenkins_element() {
    let folder = folder("jenkins");
    let path = folder.join("oscillator.npz");
    // Ground, spring, mass with the contact, spring, mass: only motion along x.
    let (ground, spring, masses) = (4e4, 6e4, [1.0, 2.0]);
    let stiffness = Mat::from_fn(2, 2, |i, j| match (i, j) {
        (0, 0) => ground + spring,
        (1, 1) => spring,
        _ => -spring,
    });
    let mass = Mat::from_fn(2, 2, |i, j| if i == j { masses[i] } else { 0.0 });
    write(&path, &stiffness, &mass, &[(7, 1), (-1, 1)]);
    let (k, mu, preload) = (5e4, 0.2, 50.0);
    let limit = mu * preload;
    let mut given = scene(&path, &[7], &[set([k, k, 2e6], mu, preload)], &json!([[-1, 1, 1.0]]));
    for mode in [1, 2] {
        // Modes of the stuck structure.
        let (a, b) = (stiffness[(0, 0)] + k, stiffness[(1, 1)]);
        let (p, q) = (
            a / masses[0] + b / masses[1],
            (a * b - spring * spring) / (masses[0] * masses[1]),
        );
        let sign = if mode == 1 { -1.0 } else { 1.0 };
        let eigenvalue = 0.5 * (p + sign * (p * p - 4.0 * q).sqrt());
        let shape = [b - eigenvalue * masses[1], spring];
        let norm = (masses[0] * shape[0] * shape[0] + masses[1] * shape[1] * shape[1]).sqrt();
        let shape = shape.map(|x| x / norm);
        // The second mass condensed: (own) u + F(u) = alpha share.
        let load = [0, 1].map(|i| masses[i] * shape[i]);
        let own = stiffness[(0, 0)] - spring * spring / b;
        let share = load[0] + spring / b * load[1];
        let onset = limit * (own + k) / (k * share.abs());
        // Forces of which the corner of the loop is a vertex: no polygon cuts it.
        let response = |alpha: f64| alpha * shape[1] / eigenvalue;
        given["analyses"] = json!({
            "modes": { "followed": [mode], "number": 2 },
            "backbone": {
                "amplitudes": 5, "vertices_per_quarter": 16, "tolerance": 1e-12,
                "amplitude_from": response(0.5 * onset), "amplitude_to": response(8.0 * onset),
            },
        });
        let found = try_run(&given).unwrap();
        // At rest the friction has no load, and the pressure nothing that it could move.
        assert!(found.prestress.solution.displacement.iter().all(|u| *u == 0.0));
        assert_eq!(
            (found.prestress.residual_ratio, found.prestress.equilibrium_error),
            (0.0, 0.0)
        );
        assert!((found.prestress.fields.traction[2][0] / preload - 1.0).abs() < 1e-12);
        assert!((found.law().mean_pressure / preload - 1.0).abs() < 1e-12);
        assert_eq!(found.frequencies.len(), 2);
        let frequency = found.frequencies[mode - 1];
        assert!((frequency / (eigenvalue.sqrt() / (2.0 * PI)) - 1.0).abs() < 1e-10);
        for (index, amplitude) in found.amplitudes().iter().enumerate() {
            let alpha = onset * 2.0_f64.powi(index as i32 - 1);
            let contact = match index {
                0 | 1 => alpha * share.abs() / (own + k),
                _ => (alpha * share.abs() - limit) / own,
            } * share.signum();
            let other = (alpha * load[1] + spring * contact) / b;
            let motion = load[0] * contact + load[1] * other;
            let area = 4.0 * limit * (contact.abs() - limit / k).max(0.0);
            let result = amplitude.point.result.as_ref().unwrap();
            let omega = (alpha / motion).sqrt();
            assert!(
                (result.omega / omega - 1.0).abs() < 1e-8,
                "{mode} {index}: {} {omega}",
                result.omega
            );
            let zeta = area / (2.0 * PI * alpha * motion);
            assert!(
                (result.zeta - zeta).abs() < 1e-8 + 1e-7 * zeta,
                "{mode} {index}: {} {zeta}",
                result.zeta
            );
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}

/// A structure with sliders, moved step by step.
struct Stepper<'a> {
    stiffness: &'a Mat<f64>,
    sliders: &'a [Slider],
    u: Vec<f64>,
    friction: Vec<[f64; 2]>,
    /// Whether any point slipped, and any opened.
    seen: [bool; 2],
}

impl<'a> Stepper<'a> {
    fn new(stiffness: &'a Mat<f64>, sliders: &'a [Slider]) -> Self {
        Self {
            stiffness,
            sliders,
            u: vec![0.0; stiffness.nrows()],
            friction: vec![[0.0; 2]; sliders.len()],
            seen: [false; 2],
        }
    }

    fn residual(&self, u: &[f64], load: &[f64]) -> Vec<f64> {
        let n = u.len();
        let mut residual: Vec<f64> = (0..n)
            .map(|i| (0..n).map(|j| self.stiffness[(i, j)] * u[j]).sum::<f64>() - load[i])
            .collect();
        for (slider, friction) in self.sliders.iter().zip(&self.friction) {
            let at = |u: &[f64]| [0, 1, 2].map(|c| u[slider.first + c]);
            let force = slider.force(at(u), at(&self.u), *friction);
            (0..3).for_each(|c| residual[slider.first + c] += force[c]);
        }
        residual
    }

    /// Newton's method with differences, and a commit.
    fn step(&mut self, load: &[f64]) {
        let mut u = self.u.clone();
        let n = u.len();
        let size = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>().sqrt();
        for _ in 0..200 {
            let residual = self.residual(&u, load);
            if size(&residual) < 1e-10 {
                break;
            }
            let column = |j: usize| {
                let h = 1e-9;
                let mut moved = u.clone();
                moved[j] += h;
                let changed = self.residual(&moved, load);
                changed
                    .iter()
                    .zip(&residual)
                    .map(|(a, b)| (a - b) / h)
                    .collect::<Vec<f64>>()
            };
            let columns: Vec<Vec<f64>> = (0..n).map(column).collect();
            let rows = (0..n).map(|i| (0..n).map(|j| columns[j][i]).collect()).collect();
            let step = solve(rows, residual.clone());
            let mut part = 1.0;
            let next = loop {
                let next: Vec<f64> = u.iter().zip(&step).map(|(u, s)| u - part * s).collect();
                if size(&self.residual(&next, load)) < size(&residual) || part < 1e-3 {
                    break next;
                }
                part *= 0.5;
            };
            u = next;
        }
        assert!(size(&self.residual(&u, load)) < 1e-8);
        for (slider, friction) in self.sliders.iter().zip(&mut self.friction) {
            let at = |u: &[f64]| [0, 1, 2].map(|c| u[slider.first + c]);
            let [x, y, n] = slider.force(at(&u), at(&self.u), *friction);
            self.seen[0] |= n > 0.0 && x.hypot(y) > (1.0 - 1e-9) * slider.mu * n;
            self.seen[1] |= n == 0.0;
            *friction = [x, y];
        }
        self.u = u;
    }
}

/// Prestress, and frequency and damping of mode `mode` at amplitudes of the response: by steps here and by the crate.
fn compare(test: &str, dofs: &[(i64, u32)], stiffness: &Mat<f64>, nodes: &[u64], sliders: &[Slider]) {
    let folder = folder(test);
    let path = folder.join("structure.npz");
    let n = dofs.len();
    let mass = Mat::from_fn(n, n, |i, j| if i == j { 0.5 + 0.2 * i as f64 } else { 0.0 });
    write(&path, stiffness, &mass, dofs);
    let (label, component) = dofs[n - 1];
    let sets: Vec<Value> = sliders.iter().map(|s| set(s.stiffness, s.mu, s.preload)).collect();
    let mut given = scene(&path, nodes, &sets, &json!([[label, component, 1.0]]));
    let (vertices, cycles) = (12, 3);
    given["analyses"] = json!({
        "modes": { "followed": [2], "number": n },
        "backbone": {
            "amplitudes": 6, "vertices_per_quarter": vertices, "cycles": cycles, "tolerance": 1e-12,
            "amplitude_from": 5e-6, "amplitude_to": 2e-3,
        },
    });
    let found = try_run(&given).unwrap();

    let mut static_state = Stepper::new(stiffness, sliders);
    static_state.step(&vec![0.0; n]);
    // The crate has the jump first.
    let jump: Vec<usize> = sliders.iter().flat_map(|s| s.first..s.first + 3).collect();
    let largest = static_state.u.iter().fold(0.0_f64, |a, u| a.max(u.abs()));
    assert!(largest > 0.0);
    for (&row, u) in jump.iter().zip(&found.prestress.solution.displacement) {
        assert!(
            (static_state.u[row] - u).abs() < 1e-9 * largest,
            "{row}: {} {u}",
            static_state.u[row]
        );
    }
    assert!(found.prestress.residual_ratio < 1e-9 && found.prestress.equilibrium_error < 1e-9);
    let summary = Summary::new(&found, Default::default(), None);
    assert_eq!((summary.prestress.bolt_load, found.model.reduced.loads.len()), (0.0, 0));

    let mut stuck = stiffness.clone();
    for slider in sliders {
        (0..3).for_each(|c| stuck[(slider.first + c, slider.first + c)] += slider.stiffness[c]);
    }
    let (values, shapes) = dense_algebra::symmetric_pair(stuck.as_ref(), mass.as_ref()).unwrap();
    let shape: Vec<f64> = (0..n).map(|i| shapes[(i, 1)] * shapes[(n - 1, 1)].signum()).collect();
    let momentum: Vec<f64> = (0..n).map(|i| mass[(i, i)] * shape[i]).collect();
    let mut seen = [false; 2];
    for (index, amplitude) in found.amplitudes().iter().enumerate() {
        let x = 5e-6 * 400.0_f64.powf(index as f64 / 5.0);
        let peak = values[1] * x / shape[n - 1];
        let mut stepper = Stepper::new(stiffness, sliders);
        stepper.step(&vec![0.0; n]);
        let rest = stepper.u.clone();
        let mut track = Vec::new();
        let branches = std::iter::once((0.0, 1.0, vertices)).chain(
            [(1.0, -1.0), (-1.0, 1.0)]
                .repeat(cycles)
                .into_iter()
                .map(|(from, to)| (from, to, 2 * vertices)),
        );
        for (from, to, steps) in branches {
            for step in 1..=steps {
                let alpha = peak * (from + (to - from) * step as f64 / steps as f64);
                stepper.step(&momentum.iter().map(|m| alpha * m).collect::<Vec<f64>>());
                let q: f64 = (0..n).map(|i| momentum[i] * (stepper.u[i] - rest[i])).sum();
                track.push((alpha, q));
            }
        }
        let last = &track[track.len() - 4 * vertices - 1..];
        let (low, high) = last
            .iter()
            .fold((f64::MAX, f64::MIN), |(l, h), p| (p.1.min(l), p.1.max(h)));
        let polygon = |every: usize| -> f64 {
            let vertices: Vec<_> = last.iter().step_by(every).chain(&last[..1]).collect();
            let edges = vertices.windows(2).map(|pair| (pair[0], pair[1]));
            edges.map(|(a, b)| 0.5 * (a.0 + b.0) * (b.1 - a.1)).sum()
        };
        // Simpson's rule.
        let area = (4.0 * polygon(1) - polygon(2)) / 3.0;
        let (omega, zeta) = ((2.0 * peak / (high - low)).sqrt(), area / (PI * (high - low) * peak));
        let result = amplitude.point.result.as_ref().unwrap();
        assert!(
            (result.omega / omega - 1.0).abs() < 1e-7,
            "{test} {index}: {} {omega}",
            result.omega
        );
        assert!(
            (result.zeta - zeta).abs() < 1e-7 + 1e-6 * zeta,
            "{test} {index}: {} {zeta}",
            result.zeta
        );
        seen = [0, 1].map(|i| seen[i] || stepper.seen[i]);
    }
    assert_eq!(seen, [true; 2], "{test}: points slip, and points open");
    std::fs::remove_dir_all(folder).unwrap();
}

/// A spring to the ground at every coordinate, and springs between all of them that couple normal and tangential motion.
fn springs(n: usize) -> Mat<f64> {
    let between = |i: usize, j: usize| 2e4 * (1.0 + 0.9 * ((i * j + i + j) as f64).sin());
    Mat::from_fn(n, n, |i, j| match i == j {
        true => 3e4 + (0..n).filter(|&k| k != i).map(|k| between(i, k)).sum::<f64>(),
        false => between(i, j) * if (i + j) % 2 == 0 { 1.0 } else { -1.0 },
    })
}

#[test]
fn a_point_of_changing_pressure_follows_an_independent_stepping() {
    let dofs = [(3, 1), (3, 2), (3, 3), (-1, 1), (-2, 1)];
    let slider = Slider {
        first: 0,
        stiffness: [8e4, 8e4, 2e5],
        mu: 0.3,
        preload: 60.0,
    };
    compare("changing", &dofs, &springs(5), &[3], &[slider]);
}

#[test]
fn two_points_have_parameters_of_their_own() {
    // Labels as a mesh has them, not in the order of the points.
    let dofs = [(12, 1), (12, 2), (12, 3), (5, 1), (5, 2), (5, 3), (-1, 1)];
    let sliders = [
        Slider {
            first: 3,
            stiffness: [5e4, 7e4, 1e5],
            mu: 0.2,
            preload: 80.0,
        },
        Slider {
            first: 0,
            stiffness: [1.2e5, 9e4, 3e5],
            mu: 0.5,
            preload: 30.0,
        },
    ];
    compare("two", &dofs, &springs(7), &[5, 12], &sliders);
}

/// A scene with two points whose structure all tests below change a little.
fn two_points(folder: &Path) -> Value {
    let path = folder.join("two.npz");
    let dofs = [(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (2, 3)];
    write(&path, &springs(6), &Mat::identity(6, 6), &dofs);
    let sets = [set([5e4, 5e4, 1e5], 0.3, 40.0), set([5e4, 5e4, 1e5], 0.3, 40.0)];
    let mut scene = scene(&path, &[1, 2], &sets, &json!([[1, 1, 1.0]]));
    scene["analyses"] = json!({
        "modes": { "number": 3 },
        "backbone": { "amplitudes": 3, "amplitude_from": 1e-5, "amplitude_to": 1e-3 },
    });
    scene
}

#[test]
fn points_over_both_sides_are_those_over_the_jump() {
    let folder = folder("sides");
    let over_jump = two_points(&folder);
    let direct = try_run(&over_jump).unwrap();
    // The top nodes 11 and 12 stand on bottom nodes 21 and 22 of their own: x_top = jump + x_bottom.
    let (jump, ground) = (springs(6), 7e4);
    let both = Mat::from_fn(12, 12, |i, j| {
        let sign = if (i < 6) == (j < 6) { 1.0 } else { -1.0 };
        sign * jump[(i % 6, j % 6)] + if i == j && i >= 6 { ground } else { 0.0 }
    });
    let mass = Mat::from_fn(12, 12, |i, j| match (i % 6 == j % 6, i < 6, j < 6) {
        (true, true, true) => 1.0,
        (true, false, false) => 3.0,
        (true, ..) => -1.0,
        _ => 0.0,
    });
    let dofs: Vec<(i64, u32)> = [11, 12, 21, 22]
        .into_iter()
        .flat_map(|node| [1, 2, 3].map(|c| (node, c)))
        .collect();
    let path = folder.join("both.npz");
    write(&path, &both, &mass, &dofs);
    let mut given = over_jump.clone();
    given["structure"]["matrices"] = json!({
        "path": path,
        "coordinates": { "both-sides": {
            "top": [12, 11], "bottom": [22, 21], "frame": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        } },
        "points": [{ "node": 11 }, { "node": 12 }],
        "response": { "terms": [[11, 1, 1.0], [21, 1, -1.0]] },
        "zero_energy_modes": 0,
    });
    // The bottom sides move by themselves alone, so that the modes of the jump are among those of the whole, above the others.
    given["analyses"]["modes"] = json!({ "number": 12, "followed": [7] });
    let whole = try_run(&given).unwrap();
    let pairs = direct
        .prestress
        .solution
        .displacement
        .iter()
        .zip(&whole.prestress.solution.displacement);
    for (a, b) in pairs.take(6) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
    for (a, b) in direct.frequencies.iter().zip(&whole.frequencies[6..]) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
    for (a, b) in direct.amplitudes().iter().zip(whole.amplitudes()) {
        let (a, b) = (a.point.result.as_ref().unwrap(), b.point.result.as_ref().unwrap());
        assert!((a.omega / b.omega - 1.0).abs() < 1e-8 && (a.zeta - b.zeta).abs() < 1e-8);
    }
    let mut wrong = given.clone();
    wrong["structure"]["matrices"]["points"] = json!([{ "node": 11 }, { "node": 22 }]);
    assert!(refused(&wrong).contains("point of contact 2 is at node 22, which faces no other"));
    wrong["structure"]["matrices"]["points"] = json!([{ "node": 11 }]);
    wrong["interfaces"]["surface"]["parameters"]["sets"]
        .as_array_mut()
        .unwrap()
        .pop();
    assert!(refused(&wrong).contains("top node 12 has no point of contact"));
    wrong["structure"]["matrices"]["coordinates"]["both-sides"]["top"] = json!([11, 11]);
    assert!(refused(&wrong).contains("the top side names 2 nodes, of which 1 differ, and the bottom side 2"));
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn areas_scale_what_is_given_per_area() {
    let folder = folder("areas");
    let reference = try_run(&two_points(&folder)).unwrap();
    let mut scaled = two_points(&folder);
    scaled["structure"]["matrices"]["points"] = json!([{ "node": 1 }, { "node": 2, "area": "4 cm^2" }]);
    let per_area = 1.0 / 4e-4;
    scaled["interfaces"]["surface"]["parameters"]["sets"][1] =
        set([5e4 * per_area, 5e4 * per_area, 1e5 * per_area], 0.3, 40.0 * per_area);
    let scaled = try_run(&scaled).unwrap();
    assert!((scaled.interface.operators().area() / 1.0004 - 1.0).abs() < 1e-15);
    for (a, b) in reference.amplitudes().iter().zip(scaled.amplitudes()) {
        let (a, b) = (a.point.result.as_ref().unwrap(), b.point.result.as_ref().unwrap());
        assert!((a.omega / b.omega - 1.0).abs() < 1e-9);
        assert!((a.zeta - b.zeta).abs() < 1e-9 + 1e-6 * a.zeta);
    }
    // The summary's scene is one, and says the same.
    let text = serde_json::to_string(&scaled.scene).unwrap();
    assert_eq!(
        Scene::from_json(&text, "summary", "", &BENCHMARKS).unwrap(),
        scaled.scene
    );
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn massless_contact_nodes_have_no_modes_of_their_own() {
    let folder = folder("massless");
    let mut given = two_points(&folder);
    let path = folder.join("massless.npz");
    let dofs: Vec<(i64, u32)> = [1, 2]
        .into_iter()
        .flat_map(|node| [1, 2, 3].map(|c| (node, c)))
        .chain([(-1, 1), (-2, 1)])
        .collect();
    let mass = |light: f64| {
        Mat::from_fn(8, 8, |i, j| {
            if i != j {
                0.0
            } else if i < 6 {
                light
            } else {
                2.0
            }
        })
    };
    given["structure"]["matrices"]["path"] = json!(path);
    given["structure"]["matrices"]["response"] = json!({ "terms": [[-1, 1, 1.0]] });
    given["analyses"] = json!({ "backbone": {
        "amplitudes": 3, "amplitude_from": 1e-5, "amplitude_to": 1e-3, "vertices_per_quarter": 8,
    } });
    let of = |light: f64| {
        write(&path, &springs(8), &mass(light), &dofs);
        try_run(&given).unwrap()
    };
    let (massless, light) = (of(0.0), of(1e-6));
    assert_eq!((massless.frequencies.len(), light.frequencies.len()), (2, 8));
    for (a, b) in massless.frequencies.iter().zip(&light.frequencies) {
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    }
    for (a, b) in massless.amplitudes().iter().zip(light.amplitudes()) {
        let (a, b) = (a.point.result.as_ref().unwrap(), b.point.result.as_ref().unwrap());
        assert!((a.omega / b.omega - 1.0).abs() < 1e-5 && (a.zeta - b.zeta).abs() < 1e-5);
    }
    given["analyses"]["modes"]["followed"] = json!([3]);
    write(&path, &springs(8), &mass(0.0), &dofs);
    let message = refused(&given);
    assert!(
        message.contains("analyses.modes.followed = 3") && message.contains("coordinates with a mass"),
        "{message}"
    );
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn curves_of_any_kind_are_preloaded() {
    let folder = folder("curves");
    let mut given = two_points(&folder);
    let curves = json!({ "greenwood-williamson": {
        "heights": { "exponential": 1e-6 }, "reference_height": 5e-6, "asperity_density": 1e2, "radii": [1e-4, 1e-4],
    } });
    for set in given["interfaces"]["surface"]["parameters"]["sets"]
        .as_array_mut()
        .unwrap()
    {
        set["curves"] = curves.clone();
    }
    given["interfaces"]["surface"]["parameters"]["sets"][1]["preload"] = json!(60.0);
    let scene = read(&given).unwrap();
    let structure = Structure::try_new(&scene, &Silent).unwrap();
    let built = SceneInterface::try_new(&scene, structure.interface(), &[], 0.0).unwrap();
    let interface = &built.interface;
    let (state, rest) = (interface.initial_state(), vec![0.0; 6]);
    let (mut end, mut workspace, mut force) = (state.clone(), interface.workspace(), vec![0.0; 6]);
    interface.evaluate(
        &rest,
        contact_laws::Sticking::Coulomb,
        &state,
        &mut end,
        &mut workspace,
        &mut force,
        None,
    );
    for (force, preload) in [force[2], force[5]].into_iter().zip([40.0, 60.0]) {
        assert!((force / preload - 1.0_f64).abs() < 1e-12, "{force} {preload}");
    }
    assert_eq!(built.reports().unwrap()[0].law.mean_pressure, 50.0);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn what_is_no_contact_is_refused() {
    let folder = folder("refusals");
    let good = two_points(&folder);
    try_run(&good).unwrap();
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut scene = good.clone();
        change(&mut scene);
        refused(&scene)
    };
    let points = |points: Value| changed(&|scene| scene["structure"]["matrices"]["points"] = points.clone());
    let without_preload = |scene: &mut Value| {
        for set in scene["interfaces"]["surface"]["parameters"]["sets"]
            .as_array_mut()
            .unwrap()
        {
            set.as_object_mut().unwrap().remove("preload");
        }
    };
    for (message, said) in [
        (
            points(json!([{ "node": 1 }, { "node": 9 }])),
            "point of contact 2 is at node 9, which is not in its map of degrees of freedom",
        ),
        (
            points(json!([{ "node": 2 }, { "node": 2 }])),
            "points of contact 1 and 2 are both at node 2",
        ),
        (points(json!([])), "no elements"),
        (points(json!([{ "node": 1 }])), "2 sets are given for 1 points"),
        (points(json!([{ "label": 1 }])), "label"),
        (
            points(json!([{ "node": 1 }, { "node": 2, "area": 0.0 }])),
            "structure.matrices.points, number 2: area = 0 m^2 is not admissible; it must be positive",
        ),
        (
            points(json!([{ "node": 1, "area": -1.0 }, { "node": 2 }])),
            "number 1: area = -1 m^2",
        ),
        (
            changed(&|scene| scene["interfaces"]["surface"]["parameters"]["sets"][1]["preload"] = json!(-1.0)),
            "sets, number 2: preload = -1 Pa",
        ),
        (
            changed(&|scene| scene["interfaces"]["surface"]["parameters"]["sets"][1]["gap"] = json!(1e-6)),
            "left out where the set has a gap",
        ),
        // Nothing loads the contact, with and without saying so.
        (changed(&without_preload), "bolts.load is missing"),
        (
            changed(&|scene| {
                without_preload(scene);
                scene["bolts"] = json!({ "load": 0.0 });
            }),
            "a set of interfaces.surface.parameters must have a preload",
        ),
        (
            changed(&|scene| scene["bolts"] = json!({ "load": 10.0 })),
            "it has no bolt loads",
        ),
        (
            changed(&|scene| scene["bolts"] = json!({ "behaviour": "locked" })),
            "it has no bolt loads",
        ),
        (
            changed(&|scene| {
                scene["interfaces"]["surface"] = json!({ "synthetic-scan": {} });
                scene["bolts"] = json!({ "load": 10.0 });
            }),
            "give the parameters of their law as interfaces.surface.parameters",
        ),
        (
            changed(&|scene| {
                scene["structure"]["matrices"]["interface"] = json!({ "nodes": [[0.0, 0.0]], "elements": [[1]] });
            }),
            "structure.matrices.interface belongs to interface meshes",
        ),
        (
            changed(&|scene| scene["interfaces"]["points_per_direction"] = json!(2)),
            "interfaces.points_per_direction belongs to interface meshes",
        ),
    ] {
        assert!(message.contains(said), "{message}\n instead of\n {said}");
    }
    // Preload pushes apart what nothing holds together.
    let path = folder.join("free.npz");
    write(
        &path,
        &Mat::zeros(3, 3),
        &Mat::identity(3, 3),
        &[(1, 1), (1, 2), (1, 3)],
    );
    let free = scene(&path, &[1], &[set([5e4, 5e4, 1e5], 0.3, 40.0)], &json!([[1, 3, 1.0]]));
    let error = try_run(&free).unwrap_err();
    assert!(matches!(error, Error::NothingInContact), "{error}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn exported_points_come_back_the_same() {
    let folder = folder("export");
    let mut given = two_points(&folder);
    // The second node moves along x and the normal only.
    let path = folder.join("lacking.npz");
    write(
        &path,
        &springs(5),
        &Mat::identity(5, 5),
        &[(1, 1), (1, 2), (1, 3), (2, 1), (2, 3)],
    );
    given["structure"]["matrices"]["path"] = json!(path);
    let direct = try_run(&given).unwrap();
    assert_eq!(direct.joint.mesh.held(), [4]);
    let scene = read(&given).unwrap();
    let structure = Structure::try_new(&scene, &Silent).unwrap();
    let arrays = export::arrays(&direct.model, &structure.joint).unwrap();
    let names: Vec<&str> = arrays.keys().map(String::as_str).collect();
    assert_eq!(names, ["K", "M", "R", "about", "dofs", "frame"]);
    std::fs::write(&path, npz::to_bytes(&arrays).unwrap()).unwrap();
    given["structure"]["matrices"]["response"] = json!({ "number": 1 });
    let again = try_run(&given).unwrap();
    for (a, b) in direct.amplitudes().iter().zip(again.amplitudes()) {
        let (a, b) = (a.point.result.as_ref().unwrap(), b.point.result.as_ref().unwrap());
        assert!((a.omega / b.omega - 1.0).abs() < 1e-9 && (a.zeta - b.zeta).abs() < 1e-9);
    }
    std::fs::remove_dir_all(folder).unwrap();
}
