//! A small bolted joint: two bars that overlap, as a mesh and as an input deck.

use anyhow::{Context, Result};
use finite_elements::elements::{Cell, Formulation, HEX8};
use finite_elements::formats::{abaqus, gmsh};
use finite_elements::mesh::{Assembly, Coupling, CouplingKind, Element, Face, Group, Material, Mesh};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The faces in contact, along x and y (m), about the origin.
pub(super) const OVERLAP: [f64; 2] = [18e-3, 12e-3];

/// Edges of elements in the plane (m).
const EDGE: f64 = 3e-3;

/// Elements of a bar along x, y and z.
const CELLS: [usize; 3] = [20, 4, 2];

/// Thickness of a bar (m).
const THICKNESS: f64 = 6e-3;

/// Half of the square that the bolt presses on (m).
const SEAT: f64 = 3e-3;

/// The bars, with their faces and the node of the response.
struct Joint {
    mesh: Mesh,
    faces: Vec<Group<Face>>,
    tip: Group<u32>,
}

fn joint() -> Result<Joint> {
    let material = |name: &str| Material {
        name: name.into(),
        youngs_modulus: 192.85e9,
        poisson_ratio: 0.29,
        density: 7857.8,
    };
    let mut mesh = Mesh {
        materials: vec![material("upper"), material("lower")],
        ..Mesh::default()
    };
    let length = EDGE * CELLS[0] as f64;
    // The upper bar ends where the overlap begins, the lower one where it ends.
    add_bar(&mut mesh, 0, [-0.5 * OVERLAP[0], 0.0]).context("the upper bar")?;
    add_bar(&mut mesh, 1, [0.5 * OVERLAP[0] - length, -THICKNESS]).context("the lower bar")?;
    let boundary = mesh.boundary();
    let n = mesh.nodes.len() as u32 / 2;
    let faces = |name: &str, is_upper: bool, height: f64, reach: [f64; 2]| Group {
        name: name.into(),
        members: boundary
            .iter()
            .filter(|face| {
                face.nodes().iter().all(|&node| {
                    let [x, y, z] = mesh.nodes[node as usize];
                    let inside = x.abs() < reach[0] + 1e-9 && y.abs() < reach[1] + 1e-9;
                    (node < n) == is_upper && (z - height).abs() < 1e-9 && inside
                })
            })
            .copied()
            .collect(),
    };
    let overlap = OVERLAP.map(|size| 0.5 * size);
    let faces = vec![
        faces("TOP", true, 0.0, overlap),
        faces("BOTTOM", false, 0.0, overlap),
        faces("HEAD", true, THICKNESS, [SEAT; 2]),
        faces("NUT", false, -THICKNESS, [SEAT; 2]),
    ];
    // The last node of the upper bar is a corner of its free end.
    let tip = Group {
        name: "TIP".into(),
        members: vec![n - 1],
    };
    Ok(Joint { mesh, faces, tip })
}

/// Adds a bar from x and z (m) on, in the middle of y.
fn add_bar(mesh: &mut Mesh, material: u16, [x, z]: [f64; 2]) -> Option<()> {
    let first = mesh.nodes.len() as u32;
    let [nx, ny, nz] = CELLS;
    let step = [EDGE, EDGE, THICKNESS / nz as f64];
    let origin = [x, -0.5 * EDGE * ny as f64, z];
    let grid = |[nx, ny, nz]: [usize; 3]| {
        (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
    };
    let places = grid([nx + 1, ny + 1, nz + 1]).map(|at| [0, 1, 2].map(|c| origin[c] + step[c] * at[c] as f64));
    mesh.nodes.extend(places);
    let node = |i: usize, j: usize, k: usize| first + (i + (nx + 1) * (j + (ny + 1) * k)) as u32;
    for [i, j, k] in grid(CELLS) {
        let ring = [[0, 0], [1, 0], [1, 1], [0, 1]];
        let corners: Vec<u32> = [k, k + 1]
            .into_iter()
            .flat_map(|k| ring.map(|[a, b]| node(i + a, j + b, k)))
            .collect();
        let cell = Cell::try_new(&HEX8, Formulation::IncompatibleModes, &corners)?;
        mesh.elements.push(Element { cell, material });
    }
    Some(())
}

/// The joint for Gmsh.
pub(super) fn gmsh() -> Result<String> {
    let Joint { mesh, faces, tip } = joint()?;
    Ok(gmsh::write(&mesh, &faces, &[tip])?)
}

/// The joint as a deck whose bolt is a force between two reference nodes.
pub(super) fn deck() -> Result<String> {
    let Joint { mesh, faces, tip } = joint()?;
    let couplings = faces[2..].iter().map(|seat| {
        let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
        for (node, area) in seat.members.iter().flat_map(|face| face.node_areas(&mesh.nodes)) {
            *areas.entry(node).or_insert(0.0) += area;
        }
        let height = if seat.name == "HEAD" { THICKNESS } else { -THICKNESS };
        Coupling {
            name: seat.name.clone(),
            reference: [0.0, 0.0, height],
            nodes: areas.keys().copied().collect(),
            kind: CouplingKind::Distributing(areas.into_values().collect()),
        }
    });
    let assembly = Assembly {
        couplings: couplings.collect(),
        mesh,
        ..Assembly::default()
    };
    Ok(abaqus::write(&assembly, &faces[..2], &[tip])?)
}

/// The scene on the deck. Reference nodes are numbered after the nodes of both bars.
pub(super) fn deck_scene() -> String {
    let [nx, ny, nz] = CELLS;
    let nodes = 2 * (nx + 1) * (ny + 1) * (nz + 1);
    include_str!("joint-deck.json")
        .replace("HEAD", &(nodes + 1).to_string())
        .replace("NUT", &(nodes + 2).to_string())
}

/// The interface alone, as `characterise --mesh` takes it (mm).
pub(super) fn patch() -> Value {
    let [nx, ny] = OVERLAP.map(|size| (size / EDGE).round() as usize);
    let places = (0..=ny).flat_map(|j| (0..=nx).map(move |i| [i, j]));
    let nodes: Vec<[f64; 2]> = places
        .map(|at| [0, 1].map(|c| 1e3 * (EDGE * at[c] as f64 - 0.5 * OVERLAP[c])))
        .collect();
    let elements: Vec<[usize; 4]> = (0..ny)
        .flat_map(|j| (0..nx).map(move |i| i + j * (nx + 1) + 1))
        .map(|a| [a, a + 1, a + nx + 2, a + nx + 1])
        .collect();
    json!({ "nodes": nodes, "elements": elements })
}
