//! Joints of quadratic solids: two stacked bars against finer meshes of linear ones, from the deck to the backbone, and what
//! interfaces of quadratic faces refuse.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests")]

use crate::common::{BENCHMARKS, material};
use analyses::error_bar::ErrorBar;
use analyses::results::summary::Summary;
use analyses::{Run, run};
use finite_elements::assemble::System;
use finite_elements::elements::{CORNERS, ElementType, Formulation, HEX8, HEX20, WEDGE6, WEDGE15};
use finite_elements::formats::abaqus;
use joint_model::benchmark::ElementOrder;
use joint_model::{Bodies, MeshedBodies, Sides};
use joints::Options;
use joints::interface::ScannedSurface;
use joints::progress::Silent;
use joints::structure::export::{arrays, deck, groups};
use joints::structure::{LinearInterface, Structure};
use matrix_files::npz;
use matrix_files::value::Array;
use scenes::{DeckBolt, Length, MaterialSource, Scene, StructureSource, Surface, SyntheticScan};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use test_support::TemporaryFolder;
use zte_assembly::shape::{QUAD8, TRI6};
use zte_assembly::{Element, InterfaceMesh};

/// Length, width and height of each bar (m).
const SIZE: [f64; 3] = [0.08, 0.02, 0.01];

/// Two bars that lie upon one another, each of `cells` boxes of elements of the type `kinds` (upper, lower), clamped together by
/// forces over their outer faces. Each box has two wedges, cut along one diagonal or (`C3D15X`) the other. `bend` moves nodes.
fn bars(kinds: [&str; 2], cells: [usize; 3], bend: &dyn Fn(&mut [f64; 3])) -> String {
    let (mut nodes, mut elements, mut numbers) = (String::from("*NODE, NSET=ALL\n"), String::new(), BTreeMap::new());
    let mut n_elements = 0;
    for (bar, kind) in kinds.into_iter().enumerate() {
        let (row, parts): (&ElementType, &[&[usize]]) = match kind {
            "C3D8I" => (&HEX8, &[&[0, 1, 2, 3, 4, 5, 6, 7]]),
            "C3D6" => (&WEDGE6, &[&[0, 1, 2, 4, 5, 6], &[0, 2, 3, 4, 6, 7]]),
            "C3D6X" => (&WEDGE6, &[&[0, 1, 3, 4, 5, 7], &[1, 2, 3, 5, 6, 7]]),
            "C3D15" => (&WEDGE15, &[&[0, 1, 2, 4, 5, 6], &[0, 2, 3, 4, 6, 7]]),
            "C3D15X" => (&WEDGE15, &[&[0, 1, 3, 4, 5, 7], &[1, 2, 3, 5, 6, 7]]),
            _ => (&HEX20, &[&[0, 1, 2, 3, 4, 5, 6, 7]]),
        };
        let name = ["UPPER", "LOWER"][bar];
        let boxes = (0..cells[2]).flat_map(|k| (0..cells[1]).flat_map(move |j| (0..cells[0]).map(move |i| [i, j, k])));
        for (cell, part) in boxes.flat_map(|cell| parts.iter().map(move |part| (cell, part))) {
            // Places in half cells.
            let corner = |local: usize| [0, 1, 2].map(|c| 2 * cell[c] + usize::from(CORNERS[part[local]][c] > 0.0) * 2);
            let between = |ends: &[usize]| [0, 1, 2].map(|c| ends.iter().map(|&e| corner(e)[c]).sum::<usize>() / 2);
            let places = (0..part.len())
                .map(corner)
                .chain(row.middles.iter().map(|ends| between(ends)));
            let list = places.map(|at| {
                let next = numbers.len() + 1;
                let number = *numbers.entry((bar, at)).or_insert_with(|| {
                    let mut x = [0, 1, 2].map(|c| SIZE[c] * at[c] as f64 / (2 * cells[c]) as f64);
                    x[2] -= SIZE[2] * bar as f64;
                    bend(&mut x);
                    writeln!(nodes, "{next}, {:?}, {:?}, {:?}", x[0], x[1], x[2]).unwrap();
                    next
                });
                number.to_string()
            });
            let list: Vec<String> = list.collect();
            n_elements += 1;
            writeln!(
                elements,
                "*ELEMENT, TYPE={}, ELSET={name}\n{n_elements}, {}\n*ELSET, ELSET={name}-{}{}\n{n_elements}",
                kind.trim_end_matches('X'),
                list.chunks(10)
                    .map(|part| part.join(", "))
                    .collect::<Vec<_>>()
                    .join(",\n"),
                u8::from(cell[2] == 0),
                u8::from(cell[2] + 1 == cells[2])
            )
            .unwrap();
        }
    }
    let tip = numbers[&(0, [2 * cells[0], 2 * cells[1], 0])];
    // The layers that touch below, above, or both.
    let sets = |name: &str, below: bool| {
        let only = if below { "10" } else { "01" };
        let flags = if cells[2] == 1 { "11" } else { only };
        format!("{name}-{flags}, {}", if below { "S1" } else { "S2" })
    };
    format!(
        "{nodes}9001, 0.04, 0.01, 0.02\n9002, 0.04, 0.01, -0.02\n{elements}*NSET, NSET=TIP\n{tip}\n*NSET, NSET=HEAD\n9001\n\
         *NSET, NSET=NUT\n9002\n*SURFACE, NAME=TOP\n{}\n*SURFACE, NAME=UP\n{}\n*SURFACE, NAME=BOTTOM\n{}\n*SURFACE, NAME=DOWN\n{}\n\
         *COUPLING, CONSTRAINT NAME=A, REF NODE=9001, SURFACE=UP\n*DISTRIBUTING\n\
         *COUPLING, CONSTRAINT NAME=B, REF NODE=9002, SURFACE=DOWN\n*DISTRIBUTING\n*MATERIAL, NAME=STEEL\n\
         *ELASTIC\n2.0E11, 0.3\n*DENSITY\n7800.\n*SOLID SECTION, ELSET=UPPER, MATERIAL=STEEL\n\
         *SOLID SECTION, ELSET=LOWER, MATERIAL=STEEL\n",
        sets("UPPER", true),
        sets("UPPER", false),
        sets("LOWER", false),
        sets("LOWER", true),
    )
}

fn scene(structure: Value, points: usize) -> Scene {
    let mut model = material();
    model["poisson_ratio"] = json!(0.3);
    let text = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": structure,
        "model": { "material": model },
        "interfaces": {
            "points_per_direction": points,
            "surface": { "parameters": { "per": "interface", "sets": [{
                "curves": { "elastic": { "normal_stiffness": 1e13, "tangential_stiffness": [7e12, 7e12] } },
            }] } },
            "mu": 0.2,
        },
        "bolts": { "load": 2e3 },
        "analyses": { "backbone": {
            "amplitudes": 3, "amplitude_from": 5e-7, "amplitude_to": 8e-6, "vertices_per_quarter": 6,
        } },
    });
    Scene::from_json(&text.to_string(), "the test's scene", "bars", &BENCHMARKS).unwrap()
}

fn on_deck(path: &Path, points: usize) -> Scene {
    let deck = json!({
        "path": path,
        "top_surface": "TOP",
        "bottom_surface": "BOTTOM",
        "bolts": [{ "top": "HEAD", "bottom": "NUT" }],
        "response": { "node": "TIP", "direction": [0.0, 0.0, 1.0] },
    });
    scene(json!({ "deck": deck }), points)
}

fn written(folder: &TemporaryFolder, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Six linearised frequencies (Hz), then frequency (Hz) and damping ratio at each amplitude.
fn results(run: &Run) -> ([f64; 6], Vec<[f64; 2]>) {
    let backbone = run.amplitudes().iter().map(|amplitude| {
        let point = amplitude.point.result.as_ref().unwrap();
        [point.omega / std::f64::consts::TAU, point.zeta]
    });
    (run.frequencies[..6].try_into().unwrap(), backbone.collect())
}

fn run_bars(folder: &TemporaryFolder, kind: &str, cells: [usize; 3], points: usize) -> ([f64; 6], Vec<[f64; 2]>) {
    let path = written(folder, "bars.inp", &bars([kind; 2], cells, &|_| {}));
    let found = run(&on_deck(&path, points), &Options::default(), &Silent).unwrap();
    assert!((found.model.facts.mass.unwrap() / (2.0 * 0.08 * 0.02 * 0.01 * 7800.0) - 1.0).abs() < 1e-9);
    assert!((found.interface.operators().area() / 1.6e-3 - 1.0).abs() < 1e-12);
    // Bolt load over the area at each point: contact is complete.
    let resultant: f64 = found.prestress.fields.traction[2]
        .iter()
        .zip(&found.interface.operators().weights)
        .map(|(t, w)| t * w)
        .sum();
    assert!((resultant / 2e3 - 1.0).abs() < 1e-6, "{resultant}");
    let (frequencies, backbone) = results(&found);
    println!("{kind} {cells:?}, {points} points: {frequencies:.1?} {backbone:?}");
    (frequencies, backbone)
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_quadratic_bars_agree_with_finer_linear_ones() {
    let folder = TemporaryFolder::new("quadratic-bars");
    let [coarse, fine] = [[16, 4, 2], [32, 8, 4]].map(|cells| run_bars(&folder, "C3D8I", cells, 2));
    let reference = run_bars(&folder, "C3D20R", [16, 4, 4], 3);
    // 64 boxes in place of 2048; nearer to the finest mesh, but for the wedges.
    for (kind, points, bounds) in [
        ("C3D20R", 3, [3e-3, 3e-2]),
        ("C3D20R", 2, [3e-3, 6e-2]),
        ("C3D20", 3, [7e-3, 8e-2]),
        ("C3D15", 3, [9e-3, 0.12]),
    ] {
        let found = run_bars(&folder, kind, [8, 2, 2], points);
        for mode in 0..6 {
            let [coarse, fine, limit, found] = [&coarse, &fine, &reference, &found].map(|of| of.0[mode]);
            println!(
                "mode {}: {:+.3} %, C3D8I {:+.3} %",
                mode + 1,
                100.0 * (found / limit - 1.0),
                100.0 * (fine / limit - 1.0)
            );
            assert!(
                (found / limit - 1.0).abs() < bounds[0],
                "{kind}, mode {}: {found} {limit}",
                mode + 1
            );
            assert!(coarse > fine && fine > limit, "{kind}, mode {}", mode + 1);
        }
        for ((found, fine), limit) in found.1.iter().zip(&fine.1).zip(&reference.1) {
            let [frequency, damping] = [0, 1].map(|i| found[i] / limit[i] - 1.0);
            let of_fine = [0, 1].map(|i| fine[i] / limit[i] - 1.0);
            println!("{frequency:+.2e} {damping:+.2e}, C3D8I {of_fine:+.2?}");
            assert!(
                frequency.abs() < bounds[0] && damping.abs() < bounds[1],
                "{kind}: {frequency:e} {damping:e}"
            );
        }
    }
}

#[test]
fn edges_may_be_curved_within_the_plane() {
    let folder = TemporaryFolder::new("curved-bars");
    // Nodes move along the bars, most in the middle; the outside stays as it is.
    let bend = |x: &mut [f64; 3]| {
        let [p, q] = [0, 1].map(|c| (std::f64::consts::PI * x[c] / SIZE[c]).sin());
        x[0] += 2e-3 * p * q;
        x[1] += 1e-3 * p * q;
    };
    for (kind, shape) in [("C3D20R", &QUAD8), ("C3D15", &TRI6)] {
        let straight = written(&folder, "straight.inp", &bars([kind; 2], [8, 2, 2], &|_| {}));
        let curved = written(&folder, "curved.inp", &bars([kind; 2], [8, 2, 2], &bend));
        let [straight, curved] =
            [straight, curved].map(|path| Structure::try_new(&on_deck(&path, 3), &Silent).unwrap());
        assert!(
            curved
                .interface()
                .elements
                .iter()
                .all(|element| element.shape() == shape)
        );
        let linear = LinearInterface {
            normal_stiffness: 1e13,
            tangential_stiffness: 7e12,
            points_per_direction: 3,
        };
        let spectrum = |structure: &Structure| {
            let found = structure.describe(Some((6, Some(linear))), &Silent).unwrap();
            assert!((found.interface_area / 1.6e-3 - 1.0).abs() < 1e-12);
            found.spectrum.unwrap()
        };
        let (straight, curved) = (spectrum(&straight), spectrum(&curved));
        for (a, b) in [
            (&straight.stuck, &curved.stuck),
            (&straight.with_linear, &curved.with_linear),
        ] {
            assert_eq!((a.zero_energy_modes, b.zero_energy_modes), (6, 6));
            for (a, b) in a.frequencies_hz.iter().zip(&b.frequencies_hz) {
                println!("{kind}: {a:.1} {b:.1}");
                assert!((a / b - 1.0).abs() < 5e-3, "{kind}: {a} {b}");
            }
        }
    }
}

#[test]
fn exported_models_keep_their_quadratic_interface() {
    let folder = TemporaryFolder::new("exported-bars");
    for (kind, places) in [("C3D20R", 8), ("C3D15", 6)] {
        let deck = on_deck(&written(&folder, "bars.inp", &bars([kind; 2], [4, 2, 1], &|_| {})), 3);
        let structure = Structure::try_new(&deck, &Silent).unwrap();
        let model = structure.reduce(&Options::default(), &Silent).unwrap();
        let arrays = arrays(&model, &structure.joint).unwrap();
        let Array::Integers(elements) = &arrays["interface_elements"] else {
            panic!("whole numbers");
        };
        assert_eq!(elements.columns(), places);
        let path = folder.join("bars.npz");
        std::fs::write(&path, npz::to_bytes(&arrays).unwrap()).unwrap();
        let jump = scene(json!({ "matrices": { "path": path, "coordinates": "jump" } }), 3);
        let [direct, again] = [&deck, &jump].map(|scene| run(scene, &Options::default(), &Silent).unwrap());
        assert_eq!(direct.joint.mesh.elements, again.joint.mesh.elements);
        for (a, b) in results(&direct).1.iter().zip(results(&again).1) {
            assert!(
                (a[0] / b[0] - 1.0).abs() < 1e-9 && (a[1] / b[1] - 1.0).abs() < 1e-6,
                "{a:?} {b:?}"
            );
        }
    }
}

#[test]
fn scans_are_characterised_within_the_outlines_of_quadratic_elements() {
    let folder = TemporaryFolder::new("scanned-bars");
    let mut scene = on_deck(
        &written(&folder, "bars.inp", &bars(["C3D20R"; 2], [8, 2, 1], &|_| {})),
        3,
    );
    scene.interfaces.surface = Surface::SyntheticScan(SyntheticScan {
        step: [1e-4; 2].map(Length::from_si),
        bootstrap: 0,
        ..SyntheticScan::default()
    });
    let structure = Structure::try_new(&scene, &Silent).unwrap();
    let quadratic = structure.interface();
    assert!(quadratic.elements.iter().all(|element| element.shape() == &QUAD8));
    let corners = quadratic
        .elements
        .iter()
        .map(|e| Element::from_nodes(e.corners()).unwrap());
    let linear = InterfaceMesh::flat(quadratic.nodes.clone(), corners.collect());
    // Straight edges enclose the same samples, with and without their middles.
    let [a, b] = [quadratic, &linear].map(|mesh| ScannedSurface::try_new(&scene, mesh).unwrap().found);
    assert_eq!(a.elements.len(), 16);
    for (a, b) in a.elements.iter().zip(&b.elements) {
        let (a, b) = (&a.population, &b.population);
        assert!((a.area() / b.area() - 1.0).abs() < 1e-12);
        assert!(
            (a.count() / b.count() - 1.0).abs() < 1e-9,
            "{} {}",
            a.count(),
            b.count()
        );
        assert!((a.effective_radius() / b.effective_radius() - 1.0).abs() < 1e-9);
    }
    let found = run(&scene, &Options::default(), &Silent).unwrap();
    assert!(
        found
            .amplitudes()
            .iter()
            .all(|amplitude| amplitude.point.result.is_ok())
    );
}

#[test]
fn quadratic_faces_that_do_not_fit_are_projected_onto_one_another() {
    let folder = TemporaryFolder::new("projected-bars");
    let spectrum = |kinds: [&str; 2]| {
        let path = written(&folder, "bars.inp", &bars(kinds, [8, 2, 2], &|_| {}));
        let structure = Structure::try_new(&on_deck(&path, 3), &Silent).unwrap();
        let Bodies::Meshed(bodies) = &structure.joint.bodies else {
            panic!("a deck gives a mesh");
        };
        let projected = matches!(bodies.sides, Sides::Projected(_));
        (projected, structure.describe(Some((6, None)), &Silent).unwrap())
    };
    let (projected, paired) = spectrum(["C3D20R"; 2]);
    assert!(!projected);
    // The middles of both diagonals are at the same places.
    for kinds in [["C3D20R", "C3D8I"], ["C3D15", "C3D15X"], ["C3D15X", "C3D15"]] {
        let (projected, found) = spectrum(kinds);
        assert!(projected, "{kinds:?}");
        assert!((found.interface_area / 1.6e-3 - 1.0).abs() < 1e-12);
        let [found, paired] = [&found, &paired].map(|of| of.spectrum.as_ref().unwrap());
        for (a, b) in [(&found.stuck, &paired.stuck), (&found.with_linear, &paired.with_linear)] {
            assert_eq!((a.zero_energy_modes, b.zero_energy_modes), (6, 6));
            for (f, g) in a.frequencies_hz.iter().zip(&b.frequencies_hz) {
                // The elements differ too: the coarse linear ones alone are 2 to 4 % stiffer.
                assert!((f / g - 1.0).abs() < 0.05, "{kinds:?}: {f} {g}");
            }
        }
    }
}

#[test]
fn interfaces_that_turn_too_much_within_an_element_are_refused() {
    let folder = TemporaryFolder::new("refused-bars");
    // Middles of edges along the bars, 2 mm above their corners 10 mm away.
    let path = written(
        &folder,
        "bars.inp",
        &bars(["C3D20R"; 2], [4, 2, 1], &|x| {
            if x[2] == 0.0 && (x[0] / 0.01).round() % 2.0 == 1.0 {
                x[2] += 2e-3;
            }
        }),
    );
    let error = Structure::try_new(&on_deck(&path, 3), &Silent).unwrap_err();
    assert!(matches!(error, joints::Error::Facing { .. }), "{error}");
    assert!(error.to_string().contains("the normal turns by"), "{error}");
}

#[test]
fn a_benchmark_in_quadratic_elements_runs_from_scene_to_backbone() {
    let on_beam = |order: &str| {
        let text = json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "benchmark": "brake-reuss-beam" },
            "model": { "refinement": "quick", "symmetry": "half", "element_order": order },
            "interfaces": { "law": { "friction": "lumped" } },
            "analyses": { "backbone": {
                "amplitudes": 2, "amplitude_from": "0.2 mm", "amplitude_to": "0.6 mm", "vertices_per_quarter": 4,
            } },
        });
        let scene = Scene::from_json(&text.to_string(), "a test", "a test", &BENCHMARKS).unwrap();
        let run = run(&scene, &Options::default(), &Silent).unwrap();
        let (frequencies, backbone) = results(&run);
        println!("{order}: {frequencies:.3?} {backbone:.5?}");
        (run, frequencies[0], backbone)
    };
    // Limit of the mesh of the first frequency (docs/validation.md).
    let limit = 166.30;
    let [(run_of_linear, linear, of_linear), (run, quadratic, of_quadratic)] = ["linear", "quadratic"].map(on_beam);
    assert!(run.joint.mesh.elements.iter().all(|element| element.shape() == &QUAD8));
    assert!((quadratic / limit - 1.0).abs() < 0.25 * (linear / limit - 1.0_f64).abs());
    for (run, frequency) in [(&run_of_linear, linear), (&run, quadratic)] {
        let bar = ErrorBar::of(&run.scene).frequency_relative.unwrap();
        assert!(
            (frequency / limit - 1.0).abs() < bar,
            "{frequency} Hz for {limit} Hz +- {bar}"
        );
    }
    // Slip lowers the frequency of both alike; damping differs by what the meshes' error bars allow.
    for (a, b) in of_linear.iter().zip(&of_quadratic) {
        let [fall, of_other] = [a[0] / linear, b[0] / quadratic];
        assert!(fall < 0.98 && (fall / of_other - 1.0).abs() < 2e-3, "{fall} {of_other}");
        assert!((a[1] / b[1]).ln().abs() < 0.06, "{a:?} {b:?}");
    }
}

/// Layers of one's own take the beam out of the table, so that its error is estimated.
#[test]
fn the_error_of_a_mesh_is_estimated_where_it_was_not_measured() {
    let limit = 166.30;
    for order in ["linear", "quadratic"] {
        let text = json!({
            "units": { "length": "m", "mass": "kg", "time": "s" },
            "structure": { "benchmark": "brake-reuss-beam" },
            "model": { "refinement": "quick", "symmetry": "half", "element_order": order, "arm_layers": 14 },
            "interfaces": { "law": { "friction": "lumped" }, "points_per_direction": 2 },
            "analyses": { "backbone": {
                "amplitudes": 3, "amplitude_from": "0.1 mm", "amplitude_to": "0.6 mm", "vertices_per_quarter": 4,
            } },
        });
        let scene = Scene::from_json(&text.to_string(), "a test", "a test", &BENCHMARKS).unwrap();
        let run = run(&scene, &Options::default(), &Silent).unwrap();
        let bar = run.estimated_error.as_ref().unwrap();
        let error = (run.frequencies[0] / limit - 1.0).abs();
        let effectivity = bar.frequency_relative.unwrap() / error;
        assert!((0.5..3.0).contains(&effectivity), "{order}: {effectivity}");
        // As measured: 0.059 and 0.009.
        let damping = bar.damping_ln.unwrap();
        assert!((0.005..0.1).contains(&damping), "{order}: {damping}");
        assert_eq!(bar.worst.len(), 5);
        assert!((bar.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(bar.shares[bar.worst[0].element - 1], bar.worst[0].share);
        // The stiffness lacks most at the ends of the lap and at the holes.
        assert!(
            bar.worst
                .iter()
                .all(|place| place.at[0].abs() < 0.07 && place.share < 0.1)
        );
        let summary = Summary::new(&run, BTreeMap::new(), None);
        assert_eq!(summary.model.error_bar, *bar);
        assert!(bar.source.contains("estimated"));
    }
}

/// A scene on a deck of linear elements that are made quadratic.
fn raised(path: &Path, points: usize) -> Scene {
    let mut scene = on_deck(path, points);
    scene.model.element_order = Some(ElementOrder::Quadratic);
    scene
}

fn bodies(structure: &Structure) -> &MeshedBodies {
    let Bodies::Meshed(bodies) = &structure.joint.bodies else {
        panic!("meshed bodies");
    };
    bodies
}

#[test]
fn decks_of_linear_elements_are_made_quadratic_ones() {
    let folder = TemporaryFolder::new("raised-bars");
    let deck = |kind: &str| written(&folder, &format!("{kind}.inp"), &bars([kind; 2], [6, 2, 2], &|_| {}));
    for (linear, quadratic, formulation, shape) in [
        ("C3D8I", "C3D20R", None, &QUAD8),
        ("C3D8I", "C3D20", Some(Formulation::Full), &QUAD8),
        ("C3D6", "C3D15", None, &TRI6),
    ] {
        let mut scene = raised(&deck(linear), 3);
        scene.model.formulation = formulation;
        let structure = Structure::try_new(&scene, &Silent).unwrap();
        let elements = &structure.interface().elements;
        assert!(elements.iter().all(|element| element.shape() == shape));
        let own = Structure::try_new(&on_deck(&deck(quadratic), 3), &Silent).unwrap();
        assert_eq!(own.joint.raised(), None);
        let [found, expected] = [&structure, &own].map(|structure| &bodies(structure).assembly.mesh);
        assert_eq!(found.nodes.len(), expected.nodes.len());
        for (a, b) in found.elements.iter().zip(&expected.elements) {
            assert_eq!(a.cell.element_type(), b.cell.element_type());
            assert_eq!(a.cell.formulation(), b.cell.formulation());
        }
        let added = structure.joint.raised().unwrap();
        assert_eq!(added.elements, found.elements.len());
        let n_linear = bodies(&Structure::try_new(&on_deck(&deck(linear), 3), &Silent).unwrap())
            .assembly
            .mesh
            .nodes
            .len();
        assert_eq!(added.added_nodes, found.nodes.len() - n_linear);

        // The same mesh but for the numbers of its nodes: the same results to round-off.
        let [found, expected] =
            [&scene, &on_deck(&deck(quadratic), 3)].map(|scene| run(scene, &Options::default(), &Silent).unwrap());
        assert_eq!(found.joint.raised, Some(added));
        let (found, expected) = (results(&found), results(&expected));
        println!("{linear}: {:?}", found.0);
        for (a, b) in found.0.iter().zip(&expected.0) {
            assert!((a / b - 1.0).abs() < 1e-8, "{linear}: {a} {b}");
        }
        for (a, b) in found.1.iter().zip(&expected.1) {
            assert!(
                (a[0] / b[0] - 1.0).abs() < 1e-7 && (a[1] / b[1] - 1.0).abs() < 1e-4,
                "{linear}: {a:?} {b:?}"
            );
        }
    }
}

#[test]
fn the_tension_of_a_thin_beam_clamps_as_forces_between_its_ends() {
    let folder = TemporaryFolder::new("beam-bolt");
    let forces = bars(["C3D8I"; 2], [8, 2, 2], &|_| {});
    let beam = format!(
        "{forces}*NODE, NSET=TENSION\n9003, 0., 0., 0.\n*ELEMENT, TYPE=B31, ELSET=BOLT\n9999, 9001, 9002\n\
         *BEAM SECTION, ELSET=BOLT, MATERIAL=STEEL, SECTION=CIRC\n1e-4\n*PRE-TENSION SECTION, ELEMENT=9999, NODE=TENSION\n"
    );
    let of_forces = written(&folder, "forces.inp", &forces);
    let of_beam = written(&folder, "beam.inp", &beam);
    for make in [on_deck, raised] {
        let expected = run(&make(&of_forces, 2), &Options::default(), &Silent).unwrap();
        let mut scene = make(&of_beam, 2);
        let StructureSource::Deck(deck) = &mut scene.structure.source else {
            panic!("a deck");
        };
        deck.bolts = vec![serde_json::from_value(json!({ "pretension": "TENSION" })).unwrap()];
        let found = run(&scene, &Options::default(), &Silent).unwrap();
        let [found, expected] = [&found, &expected].map(results);
        println!("{found:?} {expected:?}");
        // The tension is held, so that only the bending and the mass of 0.2 mm act.
        for (found, expected) in found.0.iter().zip(expected.0) {
            assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
        }
        for (found, expected) in found.1.iter().zip(&expected.1) {
            let off = [0, 1].map(|i| (found[i] / expected[i] - 1.0).abs());
            assert!(off[0] < 1e-5 && off[1] < 1e-3, "{off:?}");
        }
    }
    for wrong in [
        json!({ "top": "HEAD" }),
        json!({ "top": "A", "bottom": "B", "pretension": "C" }),
        json!({}),
    ] {
        let error = serde_json::from_value::<DeckBolt>(wrong).unwrap_err().to_string();
        assert!(error.contains("either `top` and `bottom`"), "{error}");
    }
}

#[test]
fn orders_do_not_share_a_reduced_model() {
    let folder = TemporaryFolder::new("cached-orders");
    let path = written(&folder, "bars.inp", &bars(["C3D8I"; 2], [4, 2, 1], &|_| {}));
    let options = Options {
        cache: Some(folder.join("cache")),
        ..Options::default()
    };
    let unknowns = |scene: &Scene| {
        let structure = Structure::try_new(scene, &Silent).unwrap();
        structure.reduce(&options, &Silent).unwrap().facts.n_dofs
    };
    let mut full = raised(&path, 3);
    full.model.formulation = Some(Formulation::Full);
    let scenes = [on_deck(&path, 3), raised(&path, 3), full];
    let [linear, quadratic, _] = [0, 1, 2].map(|index| unknowns(&scenes[index]));
    assert!(2 * quadratic > 5 * linear, "{linear} {quadratic}");
    // Of each a model and its modes.
    let files = || std::fs::read_dir(folder.join("cache")).unwrap().count();
    assert_eq!(files(), 6);
    // Each is found again.
    assert_eq!([0, 1].map(|index| unknowns(&scenes[index])), [linear, quadratic]);
    assert_eq!(files(), 6);
}

#[test]
fn decks_that_cannot_be_made_quadratic_are_refused() {
    let folder = TemporaryFolder::new("not-raised");
    let refused = |name: &str, text: &str| {
        let path = written(&folder, name, text);
        let Err(error) = Structure::try_new(&raised(&path, 3), &Silent) else {
            panic!("{name} was accepted");
        };
        error
    };
    // Elements that are quadratic already, all of them or those of one body.
    let line = |text: &str| 1 + text.lines().position(|line| line.contains("TYPE=C3D20R")).unwrap() + 1;
    for kinds in [["C3D20R"; 2], ["C3D8I", "C3D20R"]] {
        let text = bars(kinds, [4, 2, 1], &|_| {});
        let error = refused("quadratic.inp", &text);
        assert!(matches!(error, joints::Error::NotRaisable { .. }), "{error}");
        let message = error.to_string();
        let element = if kinds[0] == "C3D20R" { 1 } else { 9 };
        for part in [
            format!("quadratic.inp:{}", line(&text)),
            format!("element {element} is a C3D20R"),
            "leave out model.element_order".into(),
        ] {
            assert!(message.contains(&part), "{message} has no {part}");
        }
    }
    // What an equation says of corners it does not say of the middles between them.
    let mut linked = bars(["C3D8I"; 2], [4, 2, 1], &|_| {});
    linked += "*EQUATION\n2\n1, 1, 1.0, 2, 1, -1.0\n";
    let place = format!("linked.inp:{}", linked.lines().count() - 1);
    let error = refused("linked.inp", &linked);
    assert!(matches!(error, joints::Error::NotRaisable { .. }), "{error}");
    assert!(error.to_string().contains(&place), "{error} has no {place}");
    // Triangles cut along the other diagonal do not match once they are quadratic, and are projected.
    let crossed = bars(["C3D6", "C3D6X"], [4, 2, 1], &|_| {});
    let path = written(&folder, "crossed.inp", &crossed);
    let linear = Structure::try_new(&on_deck(&path, 3), &Silent).unwrap();
    let mut scene = on_deck(&path, 3);
    scene.model.element_order = Some(ElementOrder::Quadratic);
    let raised = Structure::try_new(&scene, &Silent).unwrap();
    for (structure, is_projected) in [(linear, false), (raised, true)] {
        let Bodies::Meshed(bodies) = &structure.joint.bodies else {
            panic!("a deck gives a mesh");
        };
        assert_eq!(matches!(bodies.sides, Sides::Projected(_)), is_projected);
    }
}

#[test]
fn decks_of_raised_elements_are_read_back_as_the_same_matrices() {
    let folder = TemporaryFolder::new("written-bars");
    for (kind, name) in [("C3D8I", "C3D20R"), ("C3D6", "C3D15")] {
        let path = written(&folder, "bars.inp", &bars([kind; 2], [4, 2, 1], &|_| {}));
        let scene = raised(&path, 3);
        let structure = Structure::try_new(&scene, &Silent).unwrap();
        let before = bodies(&structure);
        let (faces, sets) = groups(&structure.joint, before);
        let text = abaqus::write(&before.assembly, &faces, &sets).unwrap();
        assert!(text.contains(&format!("*ELEMENT, TYPE={name}\n")));
        let again = written(&folder, "again.inp", &text);
        let mut on_again = scene.clone();
        on_again.structure =
            scenes::StructureSource::Deck(Box::new(deck(&structure.joint, before, &again, MaterialSource::Deck)))
                .into();
        on_again.model.element_order = Some(ElementOrder::Linear);
        let read = Structure::try_new(&on_again, &Silent).unwrap();
        let [a, b] = [before, bodies(&read)].map(|bodies| System::try_new(&bodies.assembly).unwrap());
        assert!(a.stiffness == b.stiffness && a.mass == b.mass, "{kind}");
        assert_eq!(structure.interface().elements.len(), read.interface().elements.len());
        let linear = LinearInterface {
            normal_stiffness: 1e13,
            tangential_stiffness: 7e12,
            points_per_direction: 3,
        };
        let [a, b] = [&structure, &read].map(|structure| structure.frequencies(linear, |_| true, 6).unwrap());
        for (a, b) in a.frequencies_hz.iter().zip(&b.frequencies_hz) {
            assert!((a / b - 1.0).abs() < 1e-9, "{kind}: {a} {b}");
        }
    }
}
