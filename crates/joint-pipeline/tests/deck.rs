//! A public input deck of the Brake-Reuss beam against figures of other codes. The deck is read from
//! `$BRB_REFERENCE/brb_deck/Job.inp`; without it the tests pass and say so. They take minutes:
//! `cargo test --release -p joint-pipeline --test deck -- --ignored --nocapture`.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests")]

mod common;

use common::BENCHMARKS;
use joint_pipeline::joint::Bodies;
use joint_pipeline::progress::Silent;
use joint_pipeline::scene::{ContactStiffness, Force, Length};
use joint_pipeline::scene::{Curves, Elastic, ParameterSet, Parameters, Per, Surface};
use joint_pipeline::structure::{Description, LinearInterface, Spectrum, Structure};
use joint_pipeline::{Options, Scene, run};
use serde_json::json;
use std::path::PathBuf;
use substructure::mesh::GroundSpring;

fn deck() -> Option<PathBuf> {
    let path = std::env::var_os("BRB_REFERENCE").map(|folder| PathBuf::from(folder).join("brb_deck/Job.inp"));
    let found = path.filter(|path| path.exists());
    if found.is_none() {
        println!("skipped: no deck at $BRB_REFERENCE/brb_deck/Job.inp");
    }
    found
}

/// The deck with a material (Pa, kg/m^3), hexahedra of one formulation and ties of a tolerance (m).
fn scene(deck: &PathBuf, [youngs_modulus, density]: [f64; 2], formulation: &str, tolerance: f64) -> Scene {
    let bolts: Vec<_> = (1..=3)
        .map(|i| json!({ "top": format!("BPT-{i}_Set-1"), "bottom": format!("NPT-{i}_Set-1") }))
        .collect();
    let text = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "deck": {
            "path": deck,
            "top_surface": "TOPBEAM_INSURF",
            "bottom_surface": "BOTBEAM_INSURF",
            "bolts": bolts,
            "response": { "node": "OutNodes", "direction": [0.0, 0.0, 1.0] },
            "tie_tolerance": tolerance,
            "untied": "free",
            "materials": "scene",
        } },
        "model": {
            "material": { "youngs_modulus": youngs_modulus, "poisson_ratio": 0.29, "density": density },
            "formulation": formulation,
        },
        "surface": { "benchmark": "brake-reuss-beam" },
        "bolts": { "load": 12845.0 },
        "mu": 0.2,
    });
    Scene::from_json(&text.to_string(), "the test's scene", "deck", &BENCHMARKS).unwrap()
}

/// Penalty that stands for hard contact (Pa/m): a hundred times the stiffness of a layer of elements.
const HARD: f64 = 1e16;

/// Linearised frequencies about the prestress with hard contact that sticks where it is closed, or slides freely.
fn hard_contact(scene: &Scene, bolt_load: f64, penalty: f64, sticking: bool) -> Vec<f64> {
    let mut scene = scene.clone();
    scene.bolts.load = Force::from_si(bolt_load);
    scene.cqsma.amplitudes = 0;
    scene.mu = if sticking { 1e3 } else { 0.0 };
    scene.surface = Surface::Parameters(Parameters {
        per: Per::Interface,
        sets: vec![ParameterSet {
            curves: Curves::Elastic(Elastic {
                normal_stiffness: ContactStiffness::from_si(penalty),
                tangential_stiffness: [ContactStiffness::from_si(if sticking { penalty } else { 0.0 }); 2],
            }),
            mu: None,
            gap: Length::from_si(0.0),
        }],
    });
    // The structure is reduced once for all contacts.
    let options = Options::cached(std::env::temp_dir().join("joint-pipeline-deck"));
    let run = run(&scene, &options, &Silent).unwrap();
    run.checkpoints.remove();
    let area = run.validity().contact_area_fraction_by_points;
    println!("{:.1} % of the interface closed", 100.0 * area);
    run.frequencies
}

fn describe(scene: &Scene, linear: Option<LinearInterface>) -> (Description, Spectrum) {
    let structure = Structure::try_new(scene, &Silent).unwrap();
    let mut found = structure.describe(Some((10, linear)), &Silent).unwrap();
    let spectrum = found.spectrum.take().unwrap();
    (found, spectrum)
}

fn compare(name: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    let differences: Vec<String> = found
        .iter()
        .zip(expected)
        .map(|(f, e)| format!("{f:.2} ({:+.3} %)", 100.0 * (f / e - 1.0)))
        .collect();
    println!("{name}: {}", differences.join(", "));
    assert!(found.len() >= expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f / e - 1.0).abs() < tolerance, "{name}: {f} instead of {e}");
    }
}

const PAPER: [f64; 2] = [192.85e9, 7857.8];
const TUTORIAL: [f64; 2] = [200e9, 7800.0];

#[test]
#[ignore = "a minute"]
fn stuck_modes_are_those_of_an_independent_code() {
    let Some(path) = deck() else { return };
    let (all, spectrum) = describe(&scene(&path, PAPER, "incompatible-modes", 1e-3), None);
    assert_eq!((all.n_nodes, all.n_elements), (Some(40_651), Some(31_904)));
    assert_eq!((all.n_interface_elements, all.n_untied_slaves), (600, 0));
    assert_eq!(spectrum.unstressed.zero_energy_modes, 7);
    assert_eq!(spectrum.stuck.zero_energy_modes, 6);
    let expected = [
        201.43, 233.66, 624.97, 665.12, 1238.4, 1280.3, 1825.4, 1899.3, 2055.3, 3032.9,
    ];
    compare(
        "stuck, incompatible modes",
        &spectrum.stuck.frequencies_hz,
        &expected,
        1e-3,
    );
}

#[test]
#[ignore = "a minute"]
fn reduced_integration_gives_the_published_unstressed_and_penalty_modes() {
    let Some(path) = deck() else { return };
    let scene = scene(&path, TUTORIAL, "reduced", 1e-4);
    // 5e6 N/m for each of 600 elements at their one integration point.
    let linear = LinearInterface {
        normal_stiffness: 5e6 * 600.0 / 2.879_702_8e-3,
        tangential_stiffness: 0.0,
        points_per_direction: 1,
    };
    let (all, spectrum) = describe(&scene, Some(linear));
    println!("{} slaves left free", all.n_untied_slaves);
    let unstressed = [70.323, 151.26, 609.25];
    compare("unstressed", &spectrum.unstressed.frequencies_hz, &unstressed, 1e-2);
    let penalty = [
        143.74, 151.3, 575.08, 642.81, 870.59, 945.37, 1130.3, 1476.4, 1701.3, 1893.6,
    ];
    // The fifth is 1.1 % low, with four points per element as with one.
    compare("normal penalty", &spectrum.with_linear.frequencies_hz, &penalty, 1.2e-2);
}

#[test]
#[ignore = "a minute"]
fn stuck_modes_with_reduced_integration_are_those_of_an_independent_code() {
    let Some(path) = deck() else { return };
    let (_, spectrum) = describe(&scene(&path, PAPER, "reduced", 1e-4), None);
    let expected = [
        197.43, 232.16, 618.05, 661.44, 1228.27, 1274.18, 1797.09, 1860.45, 2041.92, 3006.51,
    ];
    compare("stuck, reduced", &spectrum.stuck.frequencies_hz, &expected, 5e-3);
}

#[test]
#[ignore = "a minute"]
fn hard_contact_without_friction_gives_the_published_modes() {
    let Some(path) = deck() else { return };
    let scene = scene(&path, TUTORIAL, "reduced", 1e-4);
    let found = hard_contact(&scene, 12e3, HARD, false);
    compare(
        "hard contact, no friction",
        &found,
        &[141.10, 152.42, 570.33, 643.49],
        1e-2,
    );
}

#[test]
#[ignore = "two minutes"]
fn hard_contact_with_friction_against_the_method_paper() {
    let Some(path) = deck() else { return };
    let scene = scene(&path, PAPER, "incompatible-modes", 1e-3);
    let published = [
        167.42, 227.31, 585.22, 666.10, 1194.7, 1272.5, 1608.0, 1685.1, 2030.8, 2862.6,
    ];
    for penalty in [1e14, 1e15] {
        let found = hard_contact(&scene, 12_845.0, penalty, true);
        compare(
            &format!("contact of {penalty:.0e} Pa/m that sticks (Table 3)"),
            &found,
            &published,
            1.6e-2,
        );
    }
}

#[test]
#[ignore = "two minutes"]
fn bungees_do_not_change_two_decimals() {
    let Some(path) = deck() else { return };
    let scene = scene(&path, PAPER, "incompatible-modes", 1e-3);
    let mut structure = Structure::try_new(&scene, &Silent).unwrap();
    // With the springs the six rigid motions are modes too.
    let mut frequencies = |count| {
        let spectrum = structure
            .describe(Some((count, None)), &Silent)
            .unwrap()
            .spectrum
            .unwrap();
        let elastic = spectrum.with_linear.frequencies_hz.into_iter().filter(|f| *f > 10.0);
        let found: Vec<f64> = elastic.take(10).collect();
        let Bodies::Meshed(bodies) = &mut structure.joint.bodies else {
            panic!("a deck gives a mesh");
        };
        let nodes = &bodies.assembly.mesh.nodes;
        let ends = [1.0, -1.0].map(|sign| {
            let at = |node: &usize| sign * nodes[*node][0];
            (0..nodes.len()).max_by(|a, b| at(a).total_cmp(&at(b))).unwrap() as u32
        });
        bodies.assembly.springs = ends
            .into_iter()
            .flat_map(|node| (0..3).map(move |component| (node, component)))
            .map(|(node, component)| GroundSpring {
                node,
                component,
                stiffness: 30.0,
            })
            .collect();
        found
    };
    let (free, hung) = (frequencies(10), frequencies(16));
    assert_eq!((free.len(), hung.len()), (10, 10));
    for (free, hung) in free.iter().zip(&hung) {
        println!("{free:.4} Hz free, {hung:.4} Hz hung");
        assert!((free - hung).abs() < 5e-3, "{free} {hung}");
    }
    assert!(hung[0] > free[0]);
}
