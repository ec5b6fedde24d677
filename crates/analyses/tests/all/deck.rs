//! Structures from input decks: pairs of nodes and point masses on a small deck, and a public deck of the Brake-Reuss beam
//! against figures of other codes. The public one is read from `$BRB_REFERENCE/brb_deck/Job.inp`; without it its tests pass
//! and say so. They take minutes:
//! `cargo test --release -p analyses --test all deck:: -- --ignored --nocapture`.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests")]

use crate::common::{BENCHMARKS, fixture};
use analyses::mesh_error::Partner;
use analyses::{Error, run};
use finite_elements::elements::Formulation;
use finite_elements::formats::abaqus;
use finite_elements::mesh::GroundSpring;
use joint_model::{Bodies, MeshedBodies, MovedPairs, Sides};
use joints::Options;
use joints::progress::Silent;
use joints::structure::{Description, LinearInterface, Spectrum, Structure, export};
use scenes::{
    ContactStiffness, Curves, Elastic, Force, Length, MaterialSource, ParameterSet, Parameters, Per, Scene, Stress,
    StructureSource, Surface,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use test_support::TemporaryFolder;

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
        "interfaces": { "surface": { "benchmark": "brake-reuss-beam" }, "mu": 0.2 },
        "bolts": { "load": 12845.0 },
    });
    Scene::from_json(&text.to_string(), "the test's scene", "deck", &BENCHMARKS).unwrap()
}

/// Penalty that stands for hard contact (Pa/m): a hundred times the stiffness of a layer of elements.
const HARD: f64 = 1e16;

/// Linearised frequencies about the prestress with hard contact that sticks where it is closed, or slides freely.
fn hard_contact(scene: &Scene, bolt_load: f64, penalty: f64, sticking: bool) -> Vec<f64> {
    let mut scene = scene.clone();
    scene.bolts.load = Force::from_si(bolt_load);
    scene.analyses.backbone.amplitudes = 0;
    scene.interfaces.mu = if sticking { 1e3 } else { 0.0 };
    scene.interfaces.surface = Surface::Parameters(Parameters {
        per: Per::Interface,
        sets: vec![ParameterSet {
            curves: Curves::Elastic(Elastic {
                normal_stiffness: ContactStiffness::from_si(penalty),
                tangential_stiffness: [ContactStiffness::from_si(if sticking { penalty } else { 0.0 }); 2],
            }),
            mu: None,
            gap: Length::from_si(0.0),
            preload: Stress::default(),
        }],
    });
    // The structure is reduced once for all contacts.
    let options = Options::cached(std::env::temp_dir().join("analyses-deck"));
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

/// The nodes of pairs, of the top and of the bottom body.
fn pairs(bodies: &MeshedBodies) -> [&[u32]; 2] {
    match &bodies.sides {
        Sides::Pairs { top, bottom } => [top, bottom],
        Sides::Projected(_) => panic!("the sides match"),
    }
}

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

/// Table 3 of the method paper (Hz).
const TABLE_3: [f64; 10] = [
    167.42, 227.31, 585.22, 666.10, 1194.7, 1272.5, 1608.0, 1685.1, 2030.8, 2862.6,
];

#[test]
#[ignore = "a minute"]
fn one_factor_of_modulus_over_density_brings_reduced_integration_to_the_method_paper() {
    let Some(path) = deck() else { return };
    // Frequencies with hard contact are proportional to the root of E/rho.
    let fitted = |formulation: &str| {
        let found = hard_contact(&scene(&path, PAPER, formulation, 1e-3), 12_845.0, 1e15, true);
        let ratios = found.iter().zip(TABLE_3).map(|(f, paper)| f / paper);
        let (least, most) = ratios.fold((f64::INFINITY, 0.0_f64), |(a, b), r| (a.min(r), b.max(r)));
        let factor = 2.0 / (least + most);
        println!(
            "{formulation}: {:+.2} to {:+.2} %, E/rho times {:.4} leaves {:.2} %",
            100.0 * (least - 1.0),
            100.0 * (most - 1.0),
            factor * factor,
            100.0 * (most * factor - 1.0)
        );
        (factor * factor, most * factor - 1.0)
    };
    let (factor, left) = fitted("reduced");
    assert!((factor - 1.031).abs() < 2e-3 && left < 5e-3, "{factor} {left}");
    // With the other elements no factor does.
    assert!(fitted("incompatible-modes").1 > 9e-3);
}

#[test]
#[ignore = "two minutes"]
fn hard_contact_with_friction_against_the_method_paper() {
    let Some(path) = deck() else { return };
    let scene = scene(&path, PAPER, "incompatible-modes", 1e-3);
    for penalty in [1e14, 1e15] {
        let found = hard_contact(&scene, 12_845.0, penalty, true);
        compare(
            &format!("contact of {penalty:.0e} Pa/m that sticks (Table 3)"),
            &found,
            &TABLE_3,
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

/// Numbers from -1 to 1, always the same.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// In the plane, of a length between the two.
    fn way(&mut self, from: f64, to: f64) -> [f64; 3] {
        let (sin, cos) = (std::f64::consts::PI * self.next()).sin_cos();
        let length = from + (to - from) * 0.5 * (1.0 + self.next());
        [length * cos, length * sin, 0.0]
    }
}

/// Two bricks whose lower nodes at the interface, 25 to 32, are where `place` puts them.
fn bricks(folder: &Path, name: &str, place: &dyn Fn(usize, &mut [f64; 3])) -> PathBuf {
    let deck = std::fs::read_to_string(fixture("bricks.inp")).unwrap();
    let lines = deck.lines().map(|line| {
        let numbers: Vec<f64> = line.split(',').map_while(|text| text.trim().parse().ok()).collect();
        match numbers[..] {
            [label, x, y, z] if (25.0..33.0).contains(&label) => {
                let mut at = [x, y, z];
                place(label as usize - 25, &mut at);
                format!("{label}, {:?}, {:?}, {:?}", at[0], at[1], at[2])
            }
            _ => line.to_owned(),
        }
    });
    let path = folder.join(name);
    std::fs::write(&path, lines.collect::<Vec<_>>().join("\n")).unwrap();
    path
}

fn on_bricks(path: &PathBuf, tolerance: Value, masses: Value) -> Scene {
    let text = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": {
            "deck": {
                "path": path,
                "top_surface": "TOP",
                "bottom_surface": "BOTTOM",
                "pair_tolerance": tolerance,
                "bolts": [{ "top": "HEAD", "bottom": "NUT" }],
                "response": { "node": "TIP", "direction": [0.0, 0.0, 1.0] },
            },
            "point_masses": masses,
        },
        "model": { "material": { "youngs_modulus": 2e11, "poisson_ratio": 0.3 } },
        "interfaces": { "surface": { "benchmark": "brake-reuss-beam" }, "mu": 0.2 },
        "bolts": { "load": 1e3 },
    });
    Scene::from_json(&text.to_string(), "bricks.json", "bricks", &BENCHMARKS).unwrap()
}

#[test]
fn pairs_that_do_not_coincide_meet_at_their_midpoints() {
    let folder = TemporaryFolder::new("moved-pairs");
    let mut numbers = Numbers(1);
    let ways: Vec<[f64; 3]> = (0..8).map(|_| numbers.way(30e-6, 84e-6)).collect();
    // Of eight pairs, two stay as they are.
    let is_moved = |i: usize| i != 2 && i != 5;
    let path = bricks(&folder, "moved.inp", &|i, at| {
        if is_moved(i) {
            at.iter_mut().zip(ways[i]).for_each(|(x, way)| *x += way);
        }
    });
    let exact = bricks(&folder, "exact.inp", &|_, _| {});
    let structure = |path, tolerance| Structure::try_new(&on_bricks(path, tolerance, json!([])), &Silent);
    for (path, tolerance) in [(&path, json!(10e-6)), (&path, json!("60 um"))] {
        let Err(error) = structure(path, tolerance) else {
            panic!("pairs beyond the tolerance were accepted");
        };
        let message = error.to_string();
        assert!(
            message.contains("pair_tolerance") && message.contains("the nearest is"),
            "{message}"
        );
    }
    let found = structure(&path, json!("84 um")).unwrap();
    let reference = structure(&exact, Value::Null).unwrap();
    // A tolerance beyond the edges leaves pairs that coincide alone.
    let wide = structure(&exact, json!(0.05)).unwrap();
    assert_eq!(wide.interface().nodes, reference.interface().nodes);
    assert_eq!((wide.joint.moved_pairs(), reference.joint.moved_pairs()), (None, None));

    let Some(MovedPairs {
        count,
        largest_distance,
    }) = found.joint.moved_pairs()
    else {
        panic!("pairs were moved");
    };
    let size = |way: &[f64; 3]| way[0].hypot(way[1]);
    let largest = (0..8)
        .filter(|&i| is_moved(i))
        .map(|i| size(&ways[i]))
        .fold(0.0, f64::max);
    assert_eq!(count, 6);
    assert!(
        (largest_distance / largest - 1.0).abs() < 1e-9,
        "{largest_distance} {largest}"
    );
    let (Bodies::Meshed(bodies), Bodies::Meshed(before)) = (&found.joint.bodies, &reference.joint.bodies) else {
        panic!("a deck gives a mesh");
    };
    let ([tops, bottoms], paired_before) = (pairs(bodies), pairs(before));
    assert_eq!([tops, bottoms], paired_before);
    for (i, (&top, &bottom)) in tops.iter().zip(bottoms).enumerate() {
        let half = if is_moved(i) {
            ways[i].map(|x| 0.5 * x)
        } else {
            [0.0; 3]
        };
        for node in [top, bottom].map(|node| node as usize) {
            let (at, was) = (bodies.assembly.mesh.nodes[node], before.assembly.mesh.nodes[node]);
            for c in 0..3 {
                assert!((at[c] - was[c] - half[c]).abs() < 1e-15, "pair {i}: {at:?} {was:?}");
            }
        }
    }
    // Without a tolerance the meshes count as different ones, and are projected as they are.
    let projected = structure(&path, Value::Null).unwrap();
    let Bodies::Meshed(bodies) = &projected.joint.bodies else {
        panic!("a deck gives a mesh");
    };
    assert!(matches!(bodies.sides, Sides::Projected(_)));
    let stuck = |structure: &Structure| structure.describe(Some((3, None)), &Silent).unwrap();
    let (found, reference, projected) = (stuck(&found), stuck(&reference), stuck(&projected));
    assert_eq!(found.moved_pairs.unwrap().count, 6);
    let [found, reference, projected] =
        [found, reference, projected].map(|of| of.spectrum.unwrap().stuck.frequencies_hz);
    for ((f, p), e) in found.iter().zip(&projected).zip(&reference) {
        assert!((f / e - 1.0).abs() < 5e-3 && (p / e - 1.0).abs() < 5e-3, "{f} {p} {e}");
    }
}

#[test]
fn nodes_apart_along_the_normal_or_nearer_to_others_are_no_pairs() {
    let folder = TemporaryFolder::new("no-pairs");
    let refused = |path: &PathBuf, tolerance: Value| {
        let scene = on_bricks(path, tolerance, json!([]));
        let Err(error) = Structure::try_new(&scene, &Silent) else {
            panic!("pairs were accepted");
        };
        assert!(matches!(error, joints::Error::Facing { .. }));
        error.to_string()
    };
    let path = bricks(&folder, "normal.inp", &|i, at| {
        at[2] -= if i == 3 { 50e-6 } else { 0.0 }
    });
    let message = refused(&path, json!(84e-6));
    assert!(message.contains("along the normal"), "{message}");
    // Node 26 next to node 25, so that both are nearest to node 1.
    let path = bricks(&folder, "shared.inp", &|i, at| {
        at[0] -= if i == 1 { 0.015 } else { 0.0 }
    });
    let message = refused(&path, json!(0.016));
    assert!(message.contains("nearer to node"), "{message}");
}

#[test]
fn two_formulations_need_hexahedra_that_have_them() {
    let refused = |scene: &Scene| {
        let error = Partner::try_new(scene).unwrap_err();
        assert!(matches!(error, Error::OneFormulation { .. }), "{error}");
        error.to_string()
    };
    // C3D8 above, C3D8I below.
    let mut mixed = on_bricks(&fixture("bricks.inp"), Value::Null, json!([]));
    let message = refused(&mixed);
    assert!(
        message.contains("several formulations") && message.contains("model.formulation"),
        "{message}"
    );
    for (own, other) in [
        (Formulation::IncompatibleModes, Formulation::Reduced),
        (Formulation::Full, Formulation::Reduced),
        (Formulation::Reduced, Formulation::IncompatibleModes),
    ] {
        mixed.model.formulation = Some(own);
        let partner = Partner::try_new(&mixed).unwrap().scene;
        assert_eq!(partner.model.formulation, Some(other));
    }

    // Every hexahedron as two wedges.
    let folder = TemporaryFolder::new("wedges");
    let deck = std::fs::read_to_string(fixture("bricks.inp")).unwrap();
    let lines = deck.lines().map(|line| {
        let numbers: Vec<u32> = line.split(',').map_while(|text| text.trim().parse().ok()).collect();
        match numbers[..] {
            [label, a, b, c, d, e, f, g, h] => format!(
                "{label}, {a}, {b}, {c}, {e}, {f}, {g}\n{}, {a}, {c}, {d}, {e}, {g}, {h}",
                label + 1000
            ),
            _ if line.starts_with("*ELEMENT") => line.replace("C3D8I", "C3D6").replace("C3D8", "C3D6"),
            _ => line.to_owned(),
        }
    });
    let path = folder.join("wedges.inp");
    std::fs::write(&path, lines.collect::<Vec<_>>().join("\n")).unwrap();
    let message = refused(&on_bricks(&path, Value::Null, json!([])));
    assert!(
        message.contains("bricks:") && message.contains("only hexahedra of eight or twenty nodes"),
        "{message}"
    );
}

#[test]
fn masses_of_scenes_on_decks_are_at_the_named_nodes() {
    let path = fixture("bricks.inp");
    let masses = |masses: Value| Structure::try_new(&on_bricks(&path, Value::Null, masses), &Silent);
    let mass = |structure: Structure| structure.describe(None, &Silent).unwrap().mass.unwrap();
    let bare = mass(masses(json!([])).unwrap());
    let heavy = masses(json!([{ "node": "TIP", "mass": "0.8 g" }, { "node": "13", "mass": 0.01 }])).unwrap();
    let Bodies::Meshed(bodies) = &heavy.joint.bodies else {
        panic!("a deck gives a mesh");
    };
    let at: Vec<_> = bodies
        .assembly
        .masses
        .iter()
        .map(|point| (point.node, point.mass))
        .collect();
    assert_eq!(at, [(3, 8e-4), (12, 0.01)]);
    assert!((mass(heavy) - bare - 0.0108).abs() < 1e-12);
    let set = masses(json!([{ "node": "ALL", "mass": 1.0 }])).unwrap_err().to_string();
    assert!(set.contains("structure.point_masses") && set.contains("`ALL`"), "{set}");
    assert!(
        masses(json!([{ "node": "NONE", "mass": 1.0 }]))
            .unwrap_err()
            .to_string()
            .contains("NONE")
    );
}

#[test]
#[ignore = "a minute"]
fn a_public_deck_whose_nodes_do_not_coincide_has_nearly_the_same_modes() {
    let Some(path) = deck() else { return };
    let mut scene = scene(&path, PAPER, "incompatible-modes", 1e-3);
    let structure = Structure::try_new(&scene, &Silent).unwrap();
    assert_eq!(structure.joint.moved_pairs(), None, "all pairs of the deck coincide");
    let stuck = |structure: &Structure| {
        let found = structure.describe(Some((10, None)), &Silent).unwrap();
        found.spectrum.unwrap().stuck.frequencies_hz
    };
    let expected = stuck(&structure);

    let mut joint = structure.joint.clone();
    let Bodies::Meshed(bodies) = &mut joint.bodies else {
        panic!("a deck gives a mesh");
    };
    // Every third pair, as in a deck that was published: up to 84 um apart.
    let mut numbers = Numbers(7);
    let of_bottom = pairs(bodies)[1].to_vec();
    for &node in of_bottom.iter().step_by(3) {
        let way = numbers.way(2e-6, 84e-6);
        let place = &mut bodies.assembly.mesh.nodes[node as usize];
        let frame = joint.frame;
        for c in 0..3 {
            place[c] += way[0] * frame[0][c] + way[1] * frame[1][c];
        }
    }
    let bodies = bodies.clone();
    let (faces, nodes) = export::groups(&joint, &bodies);
    let folder = TemporaryFolder::new("public-deck");
    let path = folder.join("apart.inp");
    std::fs::write(&path, abaqus::write(&bodies.assembly, &faces, &nodes).unwrap()).unwrap();
    scene.structure =
        StructureSource::Deck(Box::new(export::deck(&joint, &bodies, &path, MaterialSource::Scene))).into();
    let apart = Structure::try_new(&scene, &Silent).unwrap();
    assert_eq!(
        apart.joint.moved_pairs(),
        None,
        "meshes that do not match are projected"
    );
    compare("projected, stuck", &stuck(&apart), &expected, 1e-3);
    let StructureSource::Deck(deck) = &mut scene.structure.source else {
        panic!("the scene is on a deck");
    };
    deck.pair_tolerance = Some(Length::from_si(84e-6));
    let moved = Structure::try_new(&scene, &Silent).unwrap();
    println!("{:?}", moved.joint.moved_pairs());
    assert_eq!(moved.joint.moved_pairs().unwrap().count, of_bottom.len().div_ceil(3));
    compare("moved pairs, stuck", &stuck(&moved), &expected, 1e-3);
}
