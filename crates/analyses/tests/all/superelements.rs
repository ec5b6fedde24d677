//! Bodies of a mesh that come as matrices of another program.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::meshes::{document, lap, named};
use analyses::results::provenance::inputs_of;
use analyses::{Run, run};
use finite_elements::assemble::System;
use finite_elements::elements::{Cell, Formulation, HEX8};
use finite_elements::mesh::{Assembly, Element, Face, Group, Mesh};
use joints::Options;
use joints::progress::Silent;
use joints::structure::Structure;
use matrix_files::npz;
use matrix_files::value::{Array, Collection, Dof};
use scenes::Scene;
use serde_json::{Value, json};
use std::path::Path;
use test_support::TemporaryFolder;

use crate::common::BENCHMARKS;

/// Where the upper plate is cut (m).
const CUT: f64 = 0.13;

/// The elements of a mesh that `keeps` takes, with their nodes numbered anew, and the old number of each.
fn part(mesh: &Mesh, keeps: impl Fn(&Element) -> bool) -> (Mesh, Vec<u32>) {
    let elements: Vec<Element> = mesh.elements.iter().copied().filter(keeps).collect();
    let mut kept: Vec<u32> = elements
        .iter()
        .flat_map(|element| element.cell.nodes().to_vec())
        .collect();
    kept.sort_unstable();
    kept.dedup();
    let number = |node: &u32| kept.binary_search(node).unwrap() as u32;
    let elements = elements.into_iter().map(|element| {
        let nodes: Vec<u32> = element.cell.nodes().iter().map(number).collect();
        let cell = Cell::try_new(&HEX8, Formulation::IncompatibleModes, &nodes).unwrap();
        Element { cell, ..element }
    });
    let own = Mesh {
        nodes: kept.iter().map(|&node| mesh.nodes[node as usize]).collect(),
        elements: elements.collect(),
        materials: mesh.materials.clone(),
    };
    (own, kept)
}

/// Writes two plates, the upper one without its free end, and the matrices of that end in units of t, with `offset` taken from the labels of its nodes; and the
/// whole.
fn write(folder: &Path, offset: i64) {
    let whole = lap([12, 3, 1], [6, 2, 1]);
    whole.write(&folder.join("whole.msh"));
    let beyond = |element: &Element| {
        let nodes = element.cell.nodes();
        let x = nodes
            .iter()
            .map(|&node| whole.mesh.nodes[node as usize][0])
            .sum::<f64>()
            / nodes.len() as f64;
        x > CUT
    };
    let (mut end, of_end) = part(&whole.mesh, beyond);
    let (rest, of_rest) = part(&whole.mesh, |element| !beyond(element));
    let number = |node: u32| of_rest.binary_search(&node).ok();
    let faces = whole.faces.iter().map(|group| Group {
        name: group.name.clone(),
        members: group
            .members
            .iter()
            .filter_map(|face| renumbered(face, &number))
            .collect(),
    });
    let faces: Vec<Group<Face>> = faces.collect();
    crate::meshes::Lap { mesh: rest, faces }.write(&folder.join("rest.msh"));
    for material in &mut end.materials {
        (material.youngs_modulus, material.poisson_ratio, material.density) = (2e11, 0.3, 7800.0);
    }
    let assembly = Assembly {
        mesh: end,
        ..Assembly::default()
    };
    let system = System::try_new(&assembly).unwrap();
    let dofs: Vec<Dof> = (system.dofs.independent.iter())
        .map(|full| {
            let node = of_end[full / 3];
            // Nodes that the mesh lacks have labels beyond its own.
            let label = number(node).map_or(1_000_000 + i64::from(node), |node| node as i64 + 1);
            Dof::new(label - offset, (full % 3) as u32 + 1)
        })
        .collect();
    let arrays = [
        ("K".to_owned(), Array::Sparse(system.stiffness.map(|value| value / 1e3))),
        ("M".to_owned(), Array::Sparse(system.mass.map(|value| value / 1e3))),
        ("dofs".to_owned(), Dof::table(&dofs)),
    ];
    let arrays = Collection {
        arrays: arrays.into(),
        skipped: Vec::new(),
    };
    std::fs::write(folder.join("end.npz"), npz::to_bytes(&arrays.arrays).unwrap()).unwrap();
}

fn renumbered(face: &Face, number: &impl Fn(u32) -> Option<usize>) -> Option<Face> {
    let corners: Option<Vec<u32>> = face.nodes().iter().map(|&node| Some(number(node)? as u32)).collect();
    Some(Face::quad4(corners?.try_into().ok()?))
}

fn scene(folder: &Path, mesh: &str, superelements: &Value, change: impl Fn(&mut Value)) -> Scene {
    let value = document(&folder.join(mesh), named(), |value| {
        value["structure"]["mesh"]["response"]["nearest"] = json!([0.0, 0.0, -0.01]);
        value["analyses"]["backbone"]["amplitudes"] = json!(2);
        if superelements != &json!([]) {
            value["structure"]["mesh"]["superelements"] = superelements.clone();
        }
        change(value);
    });
    Scene::from_json(&value.to_string(), "lap.json", "lap", &BENCHMARKS).unwrap()
}

#[test]
fn a_joint_whose_end_comes_as_matrices_is_the_joint_of_the_whole_mesh() {
    let folder = TemporaryFolder::new("superelements");
    write(&folder, -700);
    let of_end = json!([{ "path": folder.join("end.npz"), "units": { "length": "m", "mass": "t", "time": "s" }, "label_offset": -700 }]);
    let own = scene(&folder, "rest.msh", &of_end, |_| ());
    let found = |scene: &Scene| -> Run { run(scene, &Options::default(), &Silent).unwrap() };
    let (own_run, whole) = (found(&own), found(&scene(&folder, "whole.msh", &json!([]), |_| ())));
    assert!((own_run.model.facts.mass.unwrap() / whole.model.facts.mass.unwrap() - 1.0).abs() < 1e-12);
    for (a, b) in own_run.frequencies.iter().zip(&whole.frequencies) {
        assert!((a / b - 1.0).abs() < 1e-8, "{a} Hz against {b}");
    }
    for (a, b) in own_run.first().amplitudes.iter().zip(&whole.first().amplitudes) {
        let [a, b] = [a, b].map(|amplitude| amplitude.point.result.as_ref().unwrap());
        assert!((a.omega / b.omega - 1.0).abs() < 1e-8);
        assert!((a.zeta / b.zeta - 1.0).abs() < 1e-5, "{} against {}", a.zeta, b.zeta);
    }
    // The matrices are an input, and belong to the key of the reduced model.
    assert!(
        inputs_of(&own)
            .unwrap()
            .iter()
            .any(|input| input.path.ends_with("end.npz"))
    );
    let key = |scene: &Scene| Structure::try_new(scene, &Silent).unwrap().hash(None).finish();
    let before = key(&own);
    write(&folder, -700);
    assert_eq!(key(&own), before);
    let mut lighter = of_end.clone();
    lighter[0]["units"]["mass"] = json!("kg");
    assert_ne!(key(&scene(&folder, "rest.msh", &lighter, |_| ())), before);
}

#[test]
fn superelements_that_do_not_fit_are_refused_with_a_remedy() {
    let folder = TemporaryFolder::new("superelements-refused");
    write(&folder, 0);
    let refusal = |body: Value, change: &dyn Fn(&mut Value)| {
        let scene = scene(&folder, "rest.msh", &json!([body]), change);
        Structure::try_new(&scene, &Silent).map(|_| ()).unwrap_err().to_string()
    };
    let path = folder.join("end.npz");
    // Labels beyond those of the mesh.
    let nowhere = refusal(json!({ "path": path, "label_offset": 500 }), &|_| ());
    assert!(nowhere.contains("label_offset"), "{nowhere}");
    // Labels of other nodes.
    let elsewhere = refusal(json!({ "path": path, "label_offset": 7 }), &|_| ());
    assert!(elsewhere.contains("other labels"), "{elsewhere}");
    let raised = refusal(json!({ "path": path }), &|value| {
        value["model"]["element_order"] = json!("quadratic");
    });
    assert!(raised.contains("element_order"), "{raised}");
}
