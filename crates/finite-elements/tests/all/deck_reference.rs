//! The public deck of the Brake-Reuss beam, found through the environment variable `BRB_REFERENCE`, against published
//! and independent frequencies.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests")]

use finite_elements::assemble::System;
use finite_elements::constraints::DofMap;
use finite_elements::eigen::{Modes, lowest_modes};
use finite_elements::elements::{Formulation, HEX8};
use finite_elements::formats::abaqus::{self, Choices, Deck, DeckModel, Includes};
use finite_elements::mesh::{Assembly, CouplingKind, Element, Material};
use std::collections::BTreeMap;

fn reference_deck() -> Option<Deck> {
    let path = test_support::reference_file("brb_deck/Job.inp")?;
    Some(abaqus::read(path, Includes::BelowTheDeck).unwrap())
}

fn material(youngs_modulus: f64, density: f64) -> Option<Material> {
    Some(Material {
        name: "steel".into(),
        youngs_modulus,
        poisson_ratio: 0.29,
        density,
    })
}

fn modes(assembly: &Assembly, count: usize) -> (System, Modes) {
    let system = System::try_new(assembly).unwrap();
    let modes = lowest_modes(&system.stiffness, &system.mass, &system.positions, count, 1e-6).unwrap();
    println!(
        "{} components, {} zero-energy modes, {:.2?} Hz",
        system.n_dofs(),
        modes.n_zero,
        modes.frequencies()
    );
    (system, modes)
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        let error = found / expected - 1.0;
        println!(
            "mode {}: {found:.3} Hz against {expected} Hz, {:+.3} %",
            i + 1,
            100.0 * error
        );
    }
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found} against {expected}");
    }
    assert!(found.len() >= expected.len());
}

#[test]
fn the_deck_is_read_completely() {
    let Some(deck) = reference_deck() else { return };
    assert_eq!(deck.nodes.len(), 40_657);
    assert_eq!(deck.elements.len(), 31_904);
    assert!(
        deck.elements
            .iter()
            .all(|e| e.cell.element_type() == &HEX8 && e.cell.formulation() == Formulation::Reduced)
    );
    assert_eq!(
        (deck.ties.len(), deck.couplings.len(), deck.equations.len()),
        (12, 6, 15)
    );
    assert_eq!(deck.node_sets["TOPS_NDS"].len(), deck.node_sets["BOTS_NDS"].len());
    let model = deck.assembly(&Choices::default()).unwrap();
    // The six reference nodes are no nodes of the mesh.
    assert_eq!(model.assembly.mesh.nodes.len(), 40_651);
    assert_eq!(model.assembly.supports.len(), 0);
    assert_eq!(model.step_supports[0].0, "Fixed-Int-Modal");
    let sides = deck.node_sets["TOPS_NDS"].len() + deck.node_sets["BOTS_NDS"].len();
    assert_eq!(model.step_supports[0].1.len(), 3 * sides);
    let bolts = &model.assembly.loads[model.load("HCBCMS/LCASE").unwrap()];
    assert_eq!(bolts.terms.len(), 6);
    let area = |name: &str| {
        let coupling = &model.assembly.couplings[model.reference(name).unwrap() as usize];
        match &coupling.kind {
            CouplingKind::Distributing(weights) => weights.iter().sum::<f64>(),
            CouplingKind::Kinematic(_) => f64::NAN,
        }
    };
    for bolt in 1..=3 {
        assert!(area(&format!("BPT-{bolt}_Set-1")) > 0.0 && area(&format!("NPT-{bolt}_Set-1")) > 0.0);
    }
    // Local coordinate systems: the two interfaces face each other in one plane.
    let z = |name: &str| {
        let nodes = model.node_set(name).unwrap();
        nodes
            .iter()
            .map(|&n| model.assembly.mesh.nodes[n as usize])
            .collect::<Vec<_>>()
    };
    let (top, bottom) = (z("TOPS_NDS"), z("BOTS_NDS"));
    for x in &top {
        let near = bottom
            .iter()
            .map(|y| (0..3).map(|i| (x[i] - y[i]).powi(2)).sum::<f64>().sqrt());
        assert!(near.fold(f64::INFINITY, f64::min) < 2e-6, "{x:?} faces nothing");
    }
    let ignored: Vec<&str> = deck.ignored.iter().map(|ignored| ignored.keyword.as_str()).collect();
    assert_eq!(
        ignored,
        [
            "HEADING",
            "PREPRINT",
            "RESTART",
            "OUTPUT",
            "NODE OUTPUT",
            "ENERGY OUTPUT"
        ]
    );
}

#[test]
fn the_default_tolerance_leaves_the_known_slaves_free_and_the_deck_survives_writing() {
    let Some(deck) = reference_deck() else { return };
    let model = deck.assembly(&Choices::default()).unwrap();
    let untied = DofMap::try_new(&model.assembly).unwrap().untied;
    // 16 nodes beneath each bolt head and each nut.
    assert_eq!(untied.len(), 96);
    let text = abaqus::write(&model.assembly, &[], &[]).unwrap();
    let back = abaqus::parse(&text, "written").unwrap();
    let back = back.assembly(&Choices::default()).unwrap().assembly;
    assert_eq!(back.mesh, model.assembly.mesh);
    assert_eq!(back.ties, model.assembly.ties);
}

/// The elements of a set alone.
fn part(model: &DeckModel, set: &str) -> Assembly {
    let mesh = &model.assembly.mesh;
    let mut part = Assembly::default();
    part.mesh.materials = mesh.materials.clone();
    let mut index: BTreeMap<u32, u32> = BTreeMap::new();
    for &element in model.element_set(set).unwrap() {
        let Element { cell, material } = mesh.elements[element as usize];
        let cell = cell.map_nodes(|node| {
            *index.entry(node).or_insert_with(|| {
                part.mesh.nodes.push(mesh.nodes[node as usize]);
                part.mesh.nodes.len() as u32 - 1
            })
        });
        part.mesh.elements.push(Element { cell, material });
    }
    part
}

#[test]
fn a_free_half_beam_agrees_with_an_independent_code() {
    let Some(deck) = reference_deck() else { return };
    let model = deck
        .assembly(&Choices {
            formulation: Some(Formulation::IncompatibleModes),
            material: material(192.85e9, 7857.8),
            ..Choices::default()
        })
        .unwrap();
    let (system, modes) = modes(&part(&model, "TOPBEAM_Set-1"), 7);
    assert!((system.total_mass - 1.8082).abs() < 1e-4, "{}", system.total_mass);
    assert_eq!(modes.n_zero, 6);
    let expected = [633.77, 787.63, 1453.35, 1920.5, 3065.1, 3618.0, 3766.5];
    assert_close(&modes.frequencies(), &expected, 1e-3);
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_the_unstressed_assembly_agrees_with_the_published_one() {
    let Some(deck) = reference_deck() else { return };
    let choices = Choices {
        material: material(200e9, 7800.0),
        tie_tolerance: Some(1e-4),
        ..Choices::default()
    };
    let model = deck.assembly(&choices).unwrap();
    let (system, modes) = modes(&model.assembly, 4);
    let mut free: BTreeMap<&str, usize> = BTreeMap::new();
    for &(tie, ..) in &system.dofs.untied {
        *free.entry(&model.assembly.ties[tie].name).or_default() += 1;
    }
    let slaves: BTreeMap<&str, usize> = model
        .assembly
        .ties
        .iter()
        .map(|tie| (tie.name.as_str(), tie.slave_nodes.len()))
        .collect();
    println!("left free {free:?} of {slaves:?}");
    for i in 1..=3 {
        let (head, nut) = (format!("BW-{i}"), format!("NW-{i}"));
        assert_eq!((slaves[&*head], free[&*head]), (48, 16));
        assert_eq!((slaves[&*nut], free[&*nut]), (51, 16));
    }
    assert_eq!(free.len(), 6);
    assert_eq!(
        modes.n_zero, 7,
        "six rigid motions and the sliding of the halves along the bolts"
    );
    assert_close(&modes.frequencies(), &[70.323, 151.26, 609.25], 1e-2);
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_with_all_slaves_tied_the_halves_can_only_part() {
    let Some(deck) = reference_deck() else { return };
    let choices = Choices {
        material: material(192.85e9, 7857.8),
        tie_tolerance: Some(1e-3),
        beyond: finite_elements::mesh::BeyondTolerance::Refuse,
        ..Choices::default()
    };
    let model = deck.assembly(&choices).unwrap();
    let (system, modes) = modes(&model.assembly, 4);
    assert!((system.total_mass - 3.7011).abs() < 1e-4, "{}", system.total_mass);
    assert!(system.dofs.untied.is_empty());
    assert_eq!(modes.n_zero, 7);
}
