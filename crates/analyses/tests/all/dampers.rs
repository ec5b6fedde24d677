//! Damping matrices: against proportional damping, in motions and beside friction.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::points::{folder, try_run};
use crate::common::{fixture, lap};
use crate::excitations::{oscillator, summary};
use crate::matrices::{dense, export, go, on_jump, read, refused};
use analyses::Run;
use analyses::forced::ForcedSummary;
use matrix_files::value::{Array, Assembled, Dense};
use matrix_files::{calculix, npz};
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::path::Path;

/// Adds the damping `of_mass M + of_stiffness K + more` to a file of matrices.
fn damp(path: &Path, [of_mass, of_stiffness]: [f64; 2], more: &dyn Fn(usize, usize) -> f64) {
    let mut arrays = npz::read(path).unwrap().arrays;
    let [mass, stiffness] = ["M", "K"].map(|name| match &arrays[name] {
        Array::Dense(matrix) => matrix.clone(),
        other => panic!("{other:?}"),
    });
    let n = mass.rows();
    let columns = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    let entry = |(i, j)| of_mass * mass[(i, j)] + of_stiffness * stiffness[(i, j)] + more(i, j);
    let damping = Dense::try_new(n, n, columns.map(entry).collect()).unwrap();
    arrays.insert("C".to_owned(), Array::Dense(damping));
    std::fs::write(path, npz::to_bytes(&arrays).unwrap()).unwrap();
}

fn nothing(_: usize, _: usize) -> f64 {
    0.0
}

/// Refuses forced responses that differ.
fn same(a: &ForcedSummary, b: &ForcedSummary, tolerance: f64) {
    assert_eq!([a.failure.as_deref(), b.failure.as_deref()], [None; 2]);
    assert!(a.at_frequencies.len() > 2 && a.at_frequencies.len() == b.at_frequencies.len());
    for (a, b) in a.at_frequencies.iter().zip(&b.at_frequencies) {
        let apart = a.amplitude.unwrap() / b.amplitude.unwrap() - 1.0;
        assert!(apart.abs() < tolerance, "{apart:e}");
        assert!((a.phase.unwrap() - b.phase.unwrap()).abs() < 100.0 * tolerance);
    }
    for found in [a, b] {
        assert!(found.energy_error.iter().all(|error| *error < 1e-9));
    }
}

#[test]
fn a_damping_matrix_of_mass_and_stiffness_is_proportional_damping() {
    let folder = folder("dampers");
    let path = folder.join("oscillator.npz");
    let factors = [3.0, 2e-4];
    let run = |mut forced: Value, is_matrix: bool| -> ForcedSummary {
        if !is_matrix {
            forced["rayleigh"] = json!({ "mass": factors[0], "stiffness": factors[1] });
        }
        let scene = oscillator(&path, 0.2, json!({ "forced": forced }));
        if is_matrix {
            damp(&path, factors, &nothing);
        }
        summary(&try_run(&scene).unwrap()).forced.remove(0)
    };
    let forced = json!({
        "harmonics": 3, "tolerance": 1e-11, "frequencies_hz": [16.0, 19.0, 20.0, 21.0, 24.0, 29.0], "levels": [12.0],
        "terms": [[7, 1, 1.0]], "stability": true,
    });
    let [with, without] = [true, false].map(|is_matrix| run(forced.clone(), is_matrix));
    same(&with, &without, 1e-8);
    let [a, b] = [&with, &without].map(|found| found.floquet.as_ref().unwrap());
    assert_eq!(a.stable, b.stable);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn the_damping_of_a_mode_has_that_of_the_structure_beside_friction() {
    let folder = folder("dampers-modes");
    let path = folder.join("oscillator.npz");
    let of_mass = 4.0;
    let run = |mu: f64, analyses: Value, damped: bool| -> Run {
        let scene = oscillator(&path, mu, analyses);
        if damped {
            damp(&path, [of_mass, 0.0], &nothing);
        }
        try_run(&scene).unwrap()
    };
    let backbone = json!({
        "backbone": { "amplitudes": 4, "amplitude_from": 2e-4, "amplitude_to": 2e-3, "methods": ["rqnma"] }, "epmc": {},
    });
    let runs = [true, false].map(|damped| run(0.2, backbone.clone(), damped));
    let mode = of_mass / (2.0 * TAU * runs[0].frequencies[0]);
    let [with, without] = runs.map(|run| summary(&run));
    let mut resolved = 0;
    for (with, without) in with.backbone.iter().zip(&without.backbone) {
        let (Some(with), Some(without)) = (with.damping_ratio, without.damping_ratio) else {
            continue;
        };
        resolved += 1;
        assert!((with - without - mode).abs() < 1e-9, "{with} {without} {mode}");
    }
    assert!(resolved > 1);
    for method in ["rqnma", "epmc"] {
        let pairs = with.methods[method].iter().zip(&without.methods[method]);
        let differences = pairs.filter_map(|(with, without)| Some(with.damping_ratio? - without.damping_ratio?));
        let differences: Vec<f64> = differences.collect();
        assert!(!differences.is_empty());
        assert!(
            differences.iter().all(|d| (d - mode).abs() < 1e-9),
            "{method}: {differences:?}"
        );
    }
    // A motion in time without slip decays so.
    let decay =
        json!({ "ring_down": { "release": 1e-6, "periods": 40, "spectral_radius": 1.0, "other_damping": 0.3 } });
    let decay = summary(&run(10.0, decay, true)).ring_down.unwrap();
    assert!(decay.backbone.len() > 5);
    for point in &decay.backbone {
        let off = point.damping_ratio / (0.01 + mode) - 1.0;
        assert!(off.abs() < 5e-3, "{off:e}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_damping_matrix_over_both_sides_is_reduced_and_exported_with_them() {
    let folder = folder("dampers-sides");
    let path = folder.join("lap.npz");
    let found = calculix::read(&fixture("lap.sti")).unwrap();
    let arrays = [
        ("K", Array::Dense(dense(&found.matrices[Assembled::STIFFNESS]))),
        ("M", Array::Dense(dense(&found.matrices[Assembled::MASS]))),
        ("dofs", matrix_files::value::Dof::table(&found.dofs)),
    ];
    let write = || {
        let arrays = arrays.clone().map(|(name, array)| (name.to_owned(), array)).into();
        std::fs::write(&path, npz::to_bytes(&arrays).unwrap()).unwrap();
    };
    write();
    let mut scene = lap(&path, 1.0, &json!({}));
    scene["analyses"] = json!({ "modes": { "number": 6 } });
    let first = go(&scene).frequencies[0];
    let of_mass = 0.02 * TAU * first;
    let forced = json!({
        "harmonics": 1, "tolerance": 1e-11, "levels": [20.0], "frequencies_hz": [0.97 * first, 0.99 * first, first, 1.02 * first],
    });
    scene["analyses"]["forced"] = forced.clone();
    scene["analyses"]["forced"]["rayleigh"] = json!({ "mass": of_mass, "stiffness": 0.0 });
    let proportional = summary(&go(&scene)).forced.remove(0);
    scene["analyses"]["forced"] = forced;
    damp(&path, [of_mass, 0.0], &nothing);
    same(&summary(&go(&scene)).forced[0], &proportional, 1e-7);
    // A damper between two coordinates, far from proportional; what is exported has it too.
    let damper = |i: usize, j: usize| match (i, j) {
        (4, 4) | (70, 70) => 50.0,
        (4, 70) | (70, 4) => -50.0,
        _ => 0.0,
    };
    write();
    damp(&path, [0.0, 0.0], &damper);
    let with_one = summary(&go(&scene)).forced.remove(0);
    assert!(
        (with_one.at_frequencies[2].amplitude.unwrap() / proportional.at_frequencies[2].amplitude.unwrap() - 1.0).abs()
            > 0.01
    );
    let (exported, paths) = export(&read(&scene), &folder);
    assert!(exported.contains_key("C"));
    for path in &paths {
        let again = summary(&go(&on_jump(&scene, path))).forced.remove(0);
        same(&again, &with_one, 1e-7);
    }
    // Energy that would be gained, and sizes that do not match.
    let gains = |i: usize, j: usize| if (i, j) == (4, 4) { -1.0 } else { damper(i, j) };
    damp(&path, [0.0, 0.0], &gains);
    let message = refused(&scene);
    assert!(
        message.contains("its damping C is not positive semi-definite") && message.contains("component"),
        "{message}"
    );
    damp(&path, [0.0, 0.0], &|i, j| f64::from(u8::from((i, j) == (0, 1))));
    let message = refused(&scene);
    assert!(message.contains("damping C is unsymmetric"), "{message}");
    std::fs::remove_dir_all(folder).unwrap();
}
