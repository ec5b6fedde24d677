//! Structures from mesh files: faces whose meshes do not match, in any place and in any order.

use crate::common::BENCHMARKS;
use analyses::warnings::{WarningKind, of_input};
use analyses::{Run, run};
use finite_elements::elements::{Cell, Formulation, HEX8};
use finite_elements::formats::gmsh;
use finite_elements::mesh::{Assembly, Dof, Element, Face, Group, Material, Mesh};
use joint_model::fit::Fit;
use joint_model::quadratic::raise_surfaces;
use joint_model::{Bodies, Sides};
use joints::Options;
use joints::progress::Silent;
use joints::structure::{LinearInterface, Spectrum, Structure};
use scenes::Scene;
use serde_json::{Value, json};
use std::path::Path;
use test_support::TemporaryFolder;

/// A box of hexahedra: numbers of elements, lowest corner and size (m).
#[derive(Clone, Copy)]
struct Box3 {
    cells: [usize; 3],
    origin: [f64; 3],
    size: [f64; 3],
}

impl Box3 {
    fn node(&self, i: usize, j: usize, k: usize) -> u32 {
        let [nx, ny, _] = self.cells;
        (i + (nx + 1) * (j + (ny + 1) * k)) as u32
    }

    /// Nodes and elements; `element` makes the cells of eight corners.
    fn add(&self, mesh: &mut Mesh, material: u16) -> u32 {
        let first = mesh.nodes.len() as u32;
        let [nx, ny, nz] = self.cells;
        for k in 0..=nz {
            for j in 0..=ny {
                for i in 0..=nx {
                    let at = [i, j, k];
                    mesh.nodes
                        .push([0, 1, 2].map(|c| self.origin[c] + self.size[c] * at[c] as f64 / self.cells[c] as f64));
                }
            }
        }
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let corner = |a, b, c| first + self.node(i + a, j + b, k + c);
                    let nodes = [
                        corner(0, 0, 0),
                        corner(1, 0, 0),
                        corner(1, 1, 0),
                        corner(0, 1, 0),
                        corner(0, 0, 1),
                        corner(1, 0, 1),
                        corner(1, 1, 1),
                        corner(0, 1, 1),
                    ];
                    let cell = Cell::try_new(&HEX8, Formulation::IncompatibleModes, &nodes).expect("a hexahedron");
                    mesh.elements.push(Element { cell, material });
                }
            }
        }
        first
    }

    /// Its lower or upper faces, outward, where `keep` holds for the position of their lowest corner along x.
    fn faces(&self, first: u32, upper: bool, keep: impl Fn(f64) -> bool) -> Vec<Face> {
        let [nx, ny, nz] = self.cells;
        let k = if upper { nz } else { 0 };
        let cells = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
        let kept = cells.filter(|&(i, _)| keep(self.origin[0] + self.size[0] * i as f64 / nx as f64));
        kept.map(|(i, j)| {
            let mut nodes = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| first + self.node(i + a, j + b, k));
            if !upper {
                nodes.reverse();
            }
            Face::quad4(nodes)
        })
        .collect()
    }
}

/// Two plates that overlap by 80 mm of their 120 mm, the upper one meshed with `upper` elements, the lower one with `lower`.
pub(crate) struct Lap {
    pub(crate) mesh: Mesh,
    pub(crate) faces: Vec<Group<Face>>,
}

pub(crate) fn lap(upper: [usize; 3], lower: [usize; 3]) -> Lap {
    let materials = ["upper", "lower"].map(|name| Material {
        name: name.into(),
        youngs_modulus: 1.0,
        poisson_ratio: 0.0,
        density: 1.0,
    });
    let mut mesh = Mesh {
        materials: materials.to_vec(),
        ..Mesh::default()
    };
    let size = [0.12, 0.03, 0.01];
    let top = Box3 {
        cells: upper,
        origin: [0.04, 0.0, 0.0],
        size,
    };
    let bottom = Box3 {
        cells: lower,
        origin: [0.0, 0.0, -0.01],
        size,
    };
    let (of_top, of_bottom) = (top.add(&mut mesh, 0), bottom.add(&mut mesh, 1));
    let group = |name: &str, members| Group {
        name: name.into(),
        members,
    };
    let seat = |x: f64| (0.06 - 1e-9..0.1 - 1e-9).contains(&x);
    let faces = vec![
        group("upper face", top.faces(of_top, false, |_| true)),
        group("lower face", bottom.faces(of_bottom, true, |_| true)),
        group("head", top.faces(of_top, true, seat)),
        group("nut", bottom.faces(of_bottom, false, seat)),
        group("foot", bottom.faces(of_bottom, false, |x| x < 0.02 - 1e-9)),
    ];
    Lap { mesh, faces }
}

impl Lap {
    pub(crate) fn write(&self, path: &Path) {
        let text = gmsh::write(&self.mesh, &self.faces, &[]).expect("a mesh");
        std::fs::write(path, text).expect("a temporary file");
    }
}

pub(crate) fn scene(path: &Path, interface: Value, change: impl Fn(&mut Value)) -> Scene {
    let value = document(path, interface, change);
    Scene::from_json(&value.to_string(), "lap.json", "lap", &BENCHMARKS).expect("a scene")
}

/// Its file.
pub(crate) fn document(path: &Path, interface: Value, change: impl Fn(&mut Value)) -> Value {
    let mut value = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "mesh": {
            "path": path,
            "interfaces": [interface],
            "bolts": [{ "head": "head", "nut": "nut" }],
            "response": { "nearest": [0.16, 0.0, 0.01], "direction": [0.0, 0.0, 1.0] },
        } },
        "model": {
            "element_order": "linear",
            "material": { "youngs_modulus": "200 GPa", "poisson_ratio": 0.3, "density": "7800 kg/m^3" },
        },
        "interfaces": {
            "points_per_direction": 2,
            "surface": { "parameters": { "per": "interface", "sets": [{ "curves": { "elastic": {
                "normal_stiffness": 4e13, "tangential_stiffness": [3e13, 3e13] } } }] } },
            "mu": 0.15,
        },
        "bolts": { "load": "8 kN" },
        "analyses": { "backbone": {
            "amplitudes": 5, "amplitude_from": 2e-6, "amplitude_to": 6e-5, "vertices_per_quarter": 8,
        } },
    });
    change(&mut value);
    value
}

pub(crate) fn named() -> Value {
    json!({ "top": "upper face", "bottom": "lower face" })
}

fn spectrum(structure: &Structure) -> Spectrum {
    let linear = LinearInterface {
        normal_stiffness: 4e13,
        tangential_stiffness: 3e13,
        points_per_direction: 2,
    };
    structure
        .describe(Some((6, Some(linear))), &Silent)
        .expect("modes")
        .spectrum
        .expect("modes were asked for")
}

/// Compares the modes with a linear interface and, within another bound, those with one that sticks.
fn compare(a: &Spectrum, b: &Spectrum, [linear, stuck]: [f64; 2], about: &str) {
    for (a, b, bound) in [(&a.stuck, &b.stuck, stuck), (&a.with_linear, &b.with_linear, linear)] {
        assert_eq!((a.zero_energy_modes, b.zero_energy_modes), (6, 6), "{about}");
        for (f, g) in a.frequencies_hz.iter().zip(&b.frequencies_hz) {
            assert!((f / g - 1.0).abs() < bound, "{about}: {f} {g}");
        }
    }
}

fn is_projected(structure: &Structure) -> bool {
    match &structure.joint.bodies {
        Bodies::Meshed(bodies) => matches!(bodies.sides, Sides::Projected(_)),
        Bodies::Imported(_) => panic!("a mesh"),
    }
}

#[test]
fn meshes_that_match_or_not_give_the_same_structure() {
    let folder = TemporaryFolder::new("lap-meshes");
    let path = folder.join("lap.msh");
    let structure = |lap: Lap, interface: Value| {
        lap.write(&path);
        Structure::try_new(&scene(&path, interface, |_| {}), &Silent).unwrap()
    };
    let area = |structure: &Structure| structure.describe(None, &Silent).unwrap().interface_area;
    let matching = structure(lap([24, 6, 2], [24, 6, 2]), json!({}));
    assert!(!is_projected(&matching));
    assert!((area(&matching) / 2.4e-3 - 1.0).abs() < 1e-12);
    let reference = spectrum(&matching);
    // Coarser below, and elements that are faced in part at the end of the overlap.
    for (lower, upper) in [
        ([24, 5, 2], [24, 7, 2]),
        ([23, 6, 2], [25, 6, 2]),
        ([26, 7, 2], [22, 5, 2]),
    ] {
        for interface in [json!({}), json!({ "between": ["upper", "lower"] }), named()] {
            let found = structure(lap(upper, lower), interface.clone());
            assert!(is_projected(&found));
            assert!((area(&found) / 2.4e-3 - 1.0).abs() < 2e-3, "{}", area(&found));
            // Where the edge of one body lies within elements of the other, all of their nodes stick: the overlap is longer by a
            // part of an element.
            let bounds = if lower[0] == upper[0] { [2e-3; 2] } else { [3e-3, 5e-2] };
            let about = format!("{lower:?} {upper:?} {interface}");
            compare(&spectrum(&found), &reference, bounds, &about);
        }
    }
}

/// The end of the lower plate, by a position beside it.
#[test]
fn a_face_is_held_by_a_position_on_it() {
    let folder = TemporaryFolder::new("lap-held");
    let path = folder.join("lap.msh");
    lap([12, 4, 2], [12, 4, 2]).write(&path);
    let structure = |support: Value| {
        let held = scene(&path, named(), |scene| {
            scene["structure"]["mesh"]["supports"] = json!([support])
        });
        Structure::try_new(&held, &Silent)
    };
    let found = structure(json!({ "face": ["-1 mm", 0.013, -0.004], "components": [true, false, true] })).unwrap();
    let Bodies::Meshed(bodies) = &found.joint.bodies else {
        panic!("a mesh")
    };
    let assembly = &bodies.assembly;
    let ends = (0..).zip(&assembly.mesh.nodes).filter(|(_, x)| x[0].abs() < 1e-9);
    let expected: Vec<Dof> = ends.flat_map(|(node, _)| [0, 2].map(|c| Dof::Node(node, c))).collect();
    assert_eq!((expected.len(), &assembly.supports), (2 * 15, &expected));
    let found = structure(json!({ "face": [0, 0.015, -0.005], "stiffness": "1000 GPa/m" })).unwrap();
    let Bodies::Meshed(bodies) = &found.joint.bodies else {
        panic!("a mesh")
    };
    let ground: f64 = bodies.assembly.springs.iter().map(|spring| spring.stiffness).sum();
    assert!((ground / (3.0 * 1e12 * 3e-4) - 1.0).abs() < 1e-12, "{ground}");
    for (support, told) in [
        (json!({ "face": [0, 15, -5] }), "more than the size of the mesh"),
        (
            json!({ "face": [0, 0, 0], "surface": "foot" }),
            "give one of `surface`, `face` and `points`",
        ),
        (json!({}), "give one of"),
    ] {
        let error = structure(support).unwrap_err().to_string();
        assert!(
            error.contains(told) && error.contains("structure.mesh.supports"),
            "{error}"
        );
    }
}

#[test]
fn place_names_and_numbers_do_not_matter() {
    let folder = TemporaryFolder::new("lap-places");
    let path = folder.join("lap.msh");
    let written = |lap: &Lap| {
        lap.write(&path);
        path.clone()
    };
    let base = lap([22, 5, 2], [25, 6, 2]);
    let structure =
        |path: &Path, interface: Value| Structure::try_new(&scene(path, interface, |_| {}), &Silent).unwrap();
    let reference = spectrum(&structure(&written(&base), named()));
    // Bodies exchanged.
    let swapped = structure(&path, json!({ "top": "lower face", "bottom": "upper face" }));
    compare(&spectrum(&swapped), &reference, [1e-9; 2], "swapped");
    // Turned about three axes and moved by metres.
    let mut turned = lap([22, 5, 2], [25, 6, 2]);
    let (a, b) = (0.7_f64, -0.4_f64);
    let turn = |x: &mut [f64; 3]| {
        let y = [x[0] * a.cos() - x[1] * a.sin(), x[0] * a.sin() + x[1] * a.cos(), x[2]];
        *x = [
            1.5 + y[0],
            -0.7 + y[1] * b.cos() - y[2] * b.sin(),
            0.3 + y[1] * b.sin() + y[2] * b.cos(),
        ];
    };
    turned.mesh.nodes.iter_mut().for_each(turn);
    let along = [a.cos(), a.sin() * b.cos(), a.sin() * b.sin()];
    let mut response = [0.16, 0.0, 0.01];
    turn(&mut response);
    let interface = json!({ "top": "upper face", "bottom": "lower face", "along": along });
    let turned = scene(&written(&turned), interface, |value| {
        value["structure"]["mesh"]["response"]["nearest"] = json!(response);
    });
    let found = Structure::try_new(&turned, &Silent).unwrap();
    compare(&spectrum(&found), &reference, [1e-9; 2], "turned");
    // Nodes in the opposite order.
    let mut renumbered = lap([22, 5, 2], [25, 6, 2]);
    let last = renumbered.mesh.nodes.len() as u32 - 1;
    renumbered.mesh.nodes.reverse();
    for element in &mut renumbered.mesh.elements {
        element.cell = element.cell.map_nodes(|node| last - node);
    }
    for face in renumbered.faces.iter_mut().flat_map(|group| &mut group.members) {
        *face = face.try_map_nodes(|node| Ok::<u32, ()>(last - node)).unwrap();
    }
    compare(
        &spectrum(&structure(&written(&renumbered), named())),
        &reference,
        [1e-9; 2],
        "renumbered",
    );
}

fn backbone(run: &Run) -> Vec<[f64; 2]> {
    let points = run.amplitudes().iter();
    points
        .map(|amplitude| {
            let found = amplitude.point.result.as_ref().expect("converged");
            [found.omega, found.zeta]
        })
        .collect()
}

#[test]
fn quadratic_and_finer_linear_hexahedra_have_the_same_modes() {
    let folder = TemporaryFolder::new("lap-tetrahedra");
    let path = folder.join("lap.msh");
    lap([48, 12, 4], [48, 12, 4]).write(&path);
    let hexahedra = Structure::try_new(&scene(&path, named(), |_| {}), &Silent).unwrap();
    let quadratic = |value: &mut Value| value["model"]["element_order"] = json!("quadratic");
    lap([24, 6, 2], [23, 5, 2]).write(&path);
    let raised = Structure::try_new(&scene(&path, named(), quadratic), &Silent).unwrap();
    assert!(is_projected(&raised));
    compare(&spectrum(&raised), &spectrum(&hexahedra), [1e-2; 2], "raised");
}

/// Uniform pressure over two blocks of the same cross-section, whose meshes do not match: the stress is uniform, and so is the jump.
///
/// Of linear elements: a seat of quadratic ones is loaded at the middles of its edges alone, which is no uniform pressure. With two layers of them the
/// pressure of meshes that match differs by 6 %, with six by 1.5 %.
#[test]
fn uniform_pressure_passes_the_interface() {
    let folder = TemporaryFolder::new("patch-blocks");
    let path = folder.join("blocks.msh");
    let size = [0.03, 0.02, 0.01];
    for distorted in [false, true] {
        let mut mesh = Mesh {
            materials: vec![Material {
                name: "steel".into(),
                youngs_modulus: 1.0,
                poisson_ratio: 0.0,
                density: 1.0,
            }],
            ..Mesh::default()
        };
        let top = Box3 {
            cells: [7, 5, 2],
            origin: [0.0; 3],
            size,
        };
        let bottom = Box3 {
            cells: [5, 3, 2],
            origin: [0.0, 0.0, -0.01],
            size,
        };
        let (of_top, of_bottom) = (top.add(&mut mesh, 0), bottom.add(&mut mesh, 0));
        if distorted {
            // Inside of the contact alone, so that the blocks stay blocks.
            for x in mesh.nodes.iter_mut().filter(|x| x[2] == 0.0) {
                let inner = |c: usize| (std::f64::consts::PI * x[c] / size[c]).sin();
                let way = 1.5e-3 * inner(0) * inner(1);
                x[0] += way;
                x[1] -= 0.5 * way;
            }
        }
        let group = |name: &str, members| Group {
            name: name.into(),
            members,
        };
        let faces = vec![
            group("upper face", top.faces(of_top, false, |_| true)),
            group("lower face", bottom.faces(of_bottom, true, |_| true)),
            group("head", top.faces(of_top, true, |_| true)),
            group("nut", bottom.faces(of_bottom, false, |_| true)),
        ];
        Lap { mesh, faces }.write(&path);
        let scene = scene(&path, named(), |value| {
            value["structure"]["mesh"]["response"]["nearest"] = json!([0.0, 0.0, 0.01]);
            value["analyses"]["backbone"] =
                json!({ "amplitudes": 2, "amplitude_from": 1e-9, "amplitude_to": 2e-9, "vertices_per_quarter": 8 });
        });
        assert!(is_projected(&Structure::try_new(&scene, &Silent).unwrap()));
        let run = run(&scene, &Options::default(), &Silent).unwrap();
        let pressure = 8e3 / (0.03 * 0.02);
        for found in &run.prestress.fields.traction[2] {
            assert!(
                (found / pressure - 1.0).abs() < 1e-8,
                "distorted {distorted}: {found} {pressure}"
            );
        }
        for found in run.prestress.fields.traction[..2].iter().flatten() {
            assert!(found.abs() < 1e-8 * pressure, "distorted {distorted}: {found}");
        }
    }
}

#[test]
fn backbones_agree_between_meshes_that_match_and_do_not() {
    let folder = TemporaryFolder::new("lap-backbones");
    let path = folder.join("lap.msh");
    let found = |lap: Lap| {
        lap.write(&path);
        run(&scene(&path, named(), |_| {}), &Options::default(), &Silent).unwrap()
    };
    let (matching, other) = (found(lap([24, 6, 2], [24, 6, 2])), found(lap([24, 6, 2], [24, 5, 2])));
    for (a, b) in backbone(&matching).into_iter().zip(backbone(&other)) {
        println!("{a:?} {b:?}");
        assert!((a[0] / b[0] - 1.0).abs() < 3e-3, "{a:?} {b:?}");
    }
}

#[test]
fn what_does_not_fit_the_mesh_is_refused_by_name() {
    let folder = TemporaryFolder::new("lap-refusals");
    let path = folder.join("lap.msh");
    lap([6, 2, 1], [6, 3, 1]).write(&path);
    let refused = |interface: Value, change: &dyn Fn(&mut Value)| {
        let scene = scene(&path, interface, change);
        Structure::try_new(&scene, &Silent).unwrap_err()
    };
    let message = refused(json!({ "top": "upper fase", "bottom": "lower face" }), &|_| {}).to_string();
    assert!(
        message.contains("upper fase") && message.contains("upper face"),
        "{message}"
    );
    let message = refused(json!({ "top": "upper face" }), &|_| {}).to_string();
    assert!(message.contains("structure.mesh.interfaces, number 1"), "{message}");
    let message = refused(named(), &|value| {
        value["structure"]["mesh"]["bolts"] = json!([{ "head": "head" }]);
    });
    assert!(
        message.to_string().contains("structure.mesh.bolts, number 1"),
        "{message}"
    );
    // The faces look away from one another.
    let error = refused(json!({ "top": "upper face", "bottom": "nut" }), &|_| {});
    assert!(
        matches!(error, joints::Error::Facing { .. } | joints::Error::Interface(_)),
        "{error}"
    );
}

/// Blocks of 20 x 20 x 10 mm with different meshes, at these positions along x and z (mm), and their faces.
fn blocks(places: &[[f64; 2]], sizes: &[[f64; 2]]) -> (Mesh, Vec<Group<Face>>) {
    let mut mesh = Mesh {
        materials: Vec::new(),
        ..Mesh::default()
    };
    let mut faces = Vec::new();
    for (number, (&[x, z], &[width, height])) in places.iter().zip(sizes).enumerate() {
        mesh.materials.push(Material {
            name: format!("block {number}"),
            youngs_modulus: 1.0,
            poisson_ratio: 0.0,
            density: 1.0,
        });
        let block = Box3 {
            cells: [4 + number % 2, 4, 2],
            origin: [1e-3 * x, 0.0, 1e-3 * z],
            size: [1e-3 * width, 0.02, 1e-3 * height],
        };
        let first = block.add(&mut mesh, number as u16);
        for (name, upper) in [("bottom", false), ("top", true)] {
            faces.push(Group {
                name: format!("{name} {number}"),
                members: block.faces(first, upper, |_| true),
            });
        }
    }
    (mesh, faces)
}

fn elastic(normal: f64) -> Value {
    json!({ "parameters": { "per": "interface", "sets": [{ "curves": { "elastic": {
        "normal_stiffness": normal, "tangential_stiffness": [normal, normal] } } }] } })
}

/// A run of blocks with these interfaces, and what each of them has of its own.
fn run_blocks(
    path: &Path,
    (mesh, faces): (Mesh, Vec<Group<Face>>),
    [interfaces, each]: [Value; 2],
    ends: [&str; 2],
) -> Run {
    Lap { mesh, faces }.write(path);
    let scene = scene(path, json!({}), |value| {
        value["structure"]["mesh"]["interfaces"] = interfaces.clone();
        value["interfaces"]["each"] = each.clone();
        value["structure"]["mesh"]["bolts"] = json!([{ "head": ends[0], "nut": ends[1] }]);
        value["structure"]["mesh"]["response"] = json!({ "nearest": [0.0, 0.0, 0.0], "direction": [0.6, 0.48, 0.64] });
        value["analyses"]["backbone"] =
            json!({ "amplitudes": 2, "amplitude_from": 1e-9, "amplitude_to": 2e-9, "vertices_per_quarter": 8 });
        value["model"]["modes"] = json!(10);
    });
    run(&scene, &Options::default(), &Silent).expect("a sound scene")
}

/// Whether one of the linearised frequencies is this one (Hz).
fn has(run: &Run, expected: f64) -> bool {
    run.frequencies.iter().any(|f| (f / expected - 1.0).abs() < 2e-3)
}

#[test]
fn interfaces_in_series_and_in_parallel_are_springs_in_series_and_in_parallel() {
    let folder = TemporaryFolder::new("several-interfaces");
    let path = folder.join("blocks.msh");
    // No square, whose modes would come in pairs of any direction.
    let area = 0.024 * 0.02;
    let mass = 7800.0 * area * 0.01;
    // Three blocks on one another, with different interfaces.
    let [lower, upper] = [2e10, 5e10];
    let stack = blocks(&[[0.0, 0.0], [0.0, 10.0], [0.0, 20.0]], &[[24.0, 10.0]; 3]);
    let interfaces = json!([
        { "name": "lower", "top": "bottom 1", "bottom": "top 0" },
        { "name": "upper", "top": "bottom 2", "bottom": "top 1" },
    ]);
    let each = json!([{ "surface": elastic(lower) }, { "surface": elastic(upper), "mu": 0.3 }]);
    let found = run_blocks(&path, stack, [interfaces, each], ["top 2", "bottom 0"]);
    assert_eq!(found.parts.len(), 2);
    assert_eq!((found.parts[0].name.as_str(), found.parts[1].mu), ("lower", 0.3));
    // The tension passes both.
    let pressure = 8e3 / area;
    for traction in &found.prestress.fields.traction[2] {
        assert!((traction / pressure - 1.0).abs() < 1e-6, "{traction} {pressure}");
    }
    // Two equal masses at the ends of a chain with one between them: the roots of its characteristic polynomial.
    let (a, b) = (lower * area / mass, upper * area / mass);
    let (sum, product) = (2.0 * (a + b), 3.0 * a * b);
    for sign in [-1.0, 1.0] {
        let expected = (0.5 * (sum + sign * (sum * sum - 4.0 * product).sqrt())).sqrt() / std::f64::consts::TAU;
        assert!(has(&found, expected), "{expected} is not among {:?}", found.frequencies);
    }

    // Asperities are judged over all interfaces, and not where the law of one is given by its parameters.
    let stack = || blocks(&[[0.0, 0.0], [0.0, 10.0], [0.0, 20.0]], &[[24.0, 10.0]; 3]);
    let measured = |other: Value| {
        let interfaces = json!([{ "top": "bottom 1", "bottom": "top 0" }, { "top": "bottom 2", "bottom": "top 1" }]);
        let each = json!([{ "surface": { "benchmark": "brake-reuss-beam" } }, { "surface": other }]);
        let found = run_blocks(&path, stack(), [interfaces, each], ["top 2", "bottom 0"]);
        found.backbones[0].validity.real_contact_area_fraction
    };
    let share = measured(json!({ "benchmark": "brake-reuss-beam" })).unwrap();
    assert!(share > 0.0 && share < 0.1, "{share}");
    assert_eq!(measured(elastic(upper)), None);

    // A block that stands on another with two feet of its own meshes, glued to it.
    let area = 0.02 * 0.02;
    let mass = 7800.0 * area * 0.01;
    let [left, right] = [3e10, 3e10];
    let places = [[0.0, 0.0], [0.0, 10.0], [40.0, 10.0], [0.0, 20.0]];
    let sizes = [[60.0, 10.0], [20.0, 10.0], [20.0, 10.0], [60.0, 10.0]];
    let bridge = blocks(&places, &sizes);
    Lap {
        mesh: bridge.0,
        faces: bridge.1,
    }
    .write(&path);
    let scene = scene(&path, json!({}), |value| {
        value["structure"]["mesh"]["interfaces"] =
            json!([{ "between": ["block 1", "block 0"] }, { "between": ["block 2", "block 0"] }]);
        value["interfaces"]["each"] = json!([{ "surface": elastic(left) }, { "surface": elastic(right) }]);
        value["structure"]["mesh"]["ties"] = json!([
            { "slave": "top 1", "master": "bottom 3" }, { "slave": "top 2", "master": "bottom 3" },
        ]);
        value["structure"]["mesh"]["bolts"] = json!([{ "head": "top 3", "nut": "bottom 0" }]);
        value["structure"]["mesh"]["response"] = json!({ "nearest": [0.0, 0.0, 0.0], "direction": [0.6, 0.48, 0.64] });
        value["model"]["material"]["youngs_modulus"] = json!("20000 GPa");
        value["analyses"]["backbone"] =
            json!({ "amplitudes": 2, "amplitude_from": 1e-9, "amplitude_to": 2e-9, "vertices_per_quarter": 8 });
    });
    let found = run(&scene, &Options::default(), &Silent).unwrap();
    assert_eq!(found.parts.len(), 2);
    let (below, above) = (3.0 * mass, 5.0 * mass);
    let expected = ((left + right) * area * (1.0 / below + 1.0 / above)).sqrt() / std::f64::consts::TAU;
    assert!(has(&found, expected), "{expected} is not among {:?}", found.frequencies);
}

#[test]
fn curved_interfaces_are_no_flat_ones_and_need_no_matching_meshes() {
    let folder = TemporaryFolder::new("lap-curved");
    let path = folder.join("lap.msh");
    let structure = |upper: [usize; 3], lower: [usize; 3], height: f64| {
        let mut lap = lap(upper, lower);
        for x in &mut lap.mesh.nodes {
            x[2] += height * (std::f64::consts::PI * (x[0] - 0.08) / 0.08).cos();
        }
        lap.write(&path);
        Structure::try_new(&scene(&path, json!({}), |_| {}), &Silent)
    };
    // A crown of 1 mm over 80 mm, inclined by 2.2 degrees at most.
    let flat = structure([24, 6, 2], [24, 6, 2], 0.0).unwrap();
    let matching = structure([24, 6, 2], [24, 6, 2], 1e-3).unwrap();
    assert!(flat.joint.node_frames.is_empty() && flat.interface().heights.is_empty());
    assert_eq!(matching.joint.node_frames.len(), matching.interface().nodes.len());
    assert!(!is_projected(&matching));
    let other = structure([24, 7, 2], [24, 5, 2], 1e-3).unwrap();
    assert!(is_projected(&other));
    let [flat, matching, other] = [&flat, &matching, &other].map(spectrum);
    compare(&other, &matching, [2e-3; 2], "curved");
    // Slopes change lengths and areas by their square.
    compare(&matching, &flat, [2e-2; 2], "curved and flat");
    assert!((matching.stuck.frequencies_hz[0] / flat.stuck.frequencies_hz[0] - 1.0).abs() > 1e-4);
    // Ends inclined by 60 degrees.
    let error = structure([24, 6, 2], [24, 6, 2], 45e-3).unwrap_err();
    assert!(
        matches!(error, joints::Error::Facing { .. }) && error.to_string().contains("degrees"),
        "{error}"
    );
}

#[test]
fn a_response_is_named_by_place_or_by_mode() {
    let folder = TemporaryFolder::new("lap-response");
    let path = folder.join("lap.msh");
    lap([12, 4, 2], [12, 3, 2]).write(&path);
    let response = |value: Value| {
        let scene = scene(&path, json!({}), |scene| {
            scene["structure"]["mesh"]["response"] = value.clone()
        });
        Structure::try_new(&scene, &Silent)
    };
    let at = |structure: &Structure| match &structure.joint.bodies {
        Bodies::Meshed(bodies) => (
            bodies.assembly.mesh.nodes[bodies.response_node as usize],
            bodies.response_direction,
        ),
        Bodies::Imported(_) => panic!("a mesh"),
    };
    let near = response(json!({ "nearest": [0.157, 0.001, 0.011], "direction": [0.0, 0.0, 1.0] })).unwrap();
    assert!(
        at(&near)
            .0
            .iter()
            .zip([0.16, 0.0, 0.01])
            .all(|(x, y)| (x - y).abs() < 1e-12)
    );
    // The first mode bends the lap: its ends move most, across the plates.
    let (place, direction) = at(&response(json!({ "mode": 1 })).unwrap());
    assert!(place[0] == 0.0 || (place[0] - 0.16).abs() < 1e-12, "{place:?}");
    assert!(direction[2].abs() > 0.9, "{direction:?}");
    for wrong in [
        json!({ "mode": 1, "direction": [0.0, 0.0, 1.0] }),
        json!({ "nearest": [0.0, 0.0, 0.0] }),
        json!({}),
    ] {
        let error = response(wrong).unwrap_err();
        assert!(error.to_string().contains("structure.mesh.response"), "{error}");
    }
}

/// A set of settings means those that fit the mesh.
#[test]
fn accuracy_takes_the_elements_of_a_mesh_that_is_not_linear_as_they_are() {
    #[derive(Default)]
    struct Notes(std::sync::Mutex<String>);
    impl joints::progress::Progress for Notes {
        fn note(&self, text: &str) {
            *self.0.lock().expect("one thread") += text;
        }
    }
    let folder = TemporaryFolder::new("lap-accuracy");
    let written = |lap: &Lap, name: &str| {
        lap.write(&folder.join(name));
        folder.join(name)
    };
    let linear = lap([6, 2, 1], [6, 2, 1]);
    let mut quadratic = lap([6, 2, 1], [6, 2, 1]);
    let mut assembly = Assembly {
        mesh: quadratic.mesh,
        ..Assembly::default()
    };
    let members = quadratic.faces.iter_mut().map(|group| &mut group.members);
    raise_surfaces(&mut assembly, members.collect()).expect("a linear mesh");
    quadratic.mesh = assembly.mesh;
    let mut mixed = Lap {
        mesh: quadratic.mesh.clone(),
        faces: quadratic.faces.clone(),
    };
    for element in mixed.mesh.elements.iter_mut().filter(|element| element.material == 1) {
        let corners = &element.cell.nodes()[..8];
        element.cell = Cell::try_new(&HEX8, Formulation::IncompatibleModes, corners).expect("a hexahedron");
    }
    for group in mixed
        .faces
        .iter_mut()
        .filter(|group| ["lower face", "nut"].contains(&group.name.as_str()))
    {
        for face in &mut group.members {
            *face = Face::from_nodes(face.corners()).expect("a face");
        }
    }
    let structure = |path: &Path, asked: Value| {
        let notes = Notes::default();
        let scene = scene(path, named(), |value| {
            value["model"]["element_order"] = Value::Null;
            let fields = value.as_object_mut().expect("an object");
            fields.extend(asked.as_object().expect("an object").clone());
        });
        let structure = Structure::try_new(&scene, &notes);
        (structure, notes.0.into_inner().expect("one thread"))
    };
    let (of_linear, _) = structure(&written(&linear, "linear.msh"), json!({ "accuracy": "standard" }));
    let reference = spectrum(&of_linear.unwrap());
    let (of_draft, _) = structure(&written(&linear, "linear.msh"), json!({ "accuracy": "draft" }));
    assert_eq!(of_draft.unwrap().describe(None, &Silent).unwrap().raised, None);
    for asked in [json!({}), json!({ "accuracy": "reference" })] {
        let (found, notes) = structure(&written(&quadratic, "quadratic.msh"), asked.clone());
        assert!(!notes.contains("quadratic"), "{notes}");
        compare(&spectrum(&found.unwrap()), &reference, [1e-9; 2], "already quadratic");
        let (found, notes) = structure(&written(&mixed, "mixed.msh"), asked);
        assert!(
            notes.contains("12 of 24 elements are linear") && notes.contains("stay as they are"),
            "{notes}"
        );
        assert_eq!(found.unwrap().describe(None, &Silent).unwrap().raised, None);
    }
    // What is asked for by name is refused where it does not fit.
    let path = folder.join("mixed.msh");
    let model = json!({ "element_order": "quadratic", "material": { "youngs_modulus": 2e11, "poisson_ratio": 0.3, "density": 7800.0 } });
    let error = structure(&path, json!({ "model": model })).0.unwrap_err();
    assert_eq!(error.field(), Some("model.element_order"), "{error}");
}

/// How the mesh in a file fits a scene of it, and what is warned of with its value.
fn fit(path: &Path, interface: Value, change: impl Fn(&mut Value)) -> (Fit, Vec<(WarningKind, f64)>) {
    let scene = scene(path, interface, change);
    let structure = Structure::try_new(&scene, &Silent).expect("a sound scene");
    let overview = structure.overview(&scene).expect("an overview");
    let told = overview.lines();
    assert!(told.iter().any(|line| line.contains("without a partner")), "{told:?}");
    let warnings = of_input(&overview).into_iter();
    let warnings = warnings.map(|warning| (warning.kind, warning.value)).collect();
    (overview.fit, warnings)
}

#[test]
fn faces_that_are_apart_or_shifted_are_told() {
    let folder = TemporaryFolder::new("lap-apart");
    let path = folder.join("lap.msh");
    // Meshes that match, that do not, and curved ones, as they should be.
    for (upper, lower, crown) in [
        ([24, 6, 2], [24, 6, 2], 0.0),
        ([25, 6, 2], [23, 7, 2], 0.0),
        ([24, 7, 2], [24, 5, 2], 1e-3),
    ] {
        let mut lap = lap(upper, lower);
        for x in &mut lap.mesh.nodes {
            x[2] += crown * (std::f64::consts::PI * (x[0] - 0.08) / 0.08).cos();
        }
        lap.write(&path);
        for interface in [json!({}), named()] {
            let (fit, warnings) = fit(&path, interface.clone(), |_| {});
            assert_eq!(warnings, [], "{upper:?} {lower:?} {interface}");
            assert_eq!((fit.faces.len(), fit.seats.len()), (1, 0));
            // The named faces are those of whole plates.
            let faces = &fit.faces[0];
            let third = if faces.named { 1.0 / 3.0 } else { 0.0 };
            for share in faces.without_partner {
                assert!((share - third).abs() < 0.05, "{faces:?}");
            }
            assert!(faces.representative().abs() < 5e-6, "{faces:?}");
        }
    }
    // The upper plate moved along the normal: by a tenth of a millimetre either way, and turned about y by as much at its ends.
    for (upper, lower) in [([24, 6, 2], [24, 6, 2]), ([25, 6, 2], [23, 7, 2])] {
        for (lift, slope) in [(1e-4, 0.0), (-1e-4, 0.0), (0.0, 2.5e-3)] {
            let mut lap = lap(upper, lower);
            let first = lap.mesh.elements.iter().filter(|element| element.material == 1);
            let first = first.map(|element| element.cell.nodes()[0]).min().unwrap() as usize;
            for x in &mut lap.mesh.nodes[..first] {
                x[2] += lift + slope * (x[0] - 0.08);
            }
            lap.write(&path);
            for interface in [json!({}), named()] {
                let about = format!("{upper:?} {lift} {slope} {interface}");
                let (fit, warnings) = fit(&path, interface, |_| {});
                let faces = &fit.faces[0];
                let [(WarningKind::FacesApart, value)] = warnings[..] else {
                    panic!("{about}: {warnings:?}");
                };
                assert!((faces.distance - lift).abs() < 4e-6, "{about}: {faces:?}");
                let expected = if slope == 0.0 { lift } else { 0.25 * slope * 0.08 };
                assert!(
                    (value.abs() - expected.abs()).abs() < 4e-6,
                    "{about}: {value} {faces:?}"
                );
                assert!(value * lift >= 0.0);
            }
        }
    }
    // One of two equal blocks moved by a tenth of its length in the plane.
    let (mesh, faces) = blocks(&[[0.0, 0.0], [3.0, 10.0]], &[[30.0, 10.0]; 2]);
    Lap { mesh, faces }.write(&path);
    let ends = |value: &mut Value| {
        value["structure"]["mesh"]["bolts"] = json!([{ "head": "top 1", "nut": "bottom 0" }]);
        value["structure"]["mesh"]["response"]["nearest"] = json!([0.0, 0.0, 0.0]);
    };
    let (of_named, warnings) = fit(&path, json!({ "top": "bottom 1", "bottom": "top 0" }), ends);
    let [(WarningKind::WithoutPartner, share)] = warnings[..] else {
        panic!("{warnings:?}");
    };
    assert!((share - 0.1).abs() < 1e-9, "{share}");
    assert!(
        of_named.faces[0]
            .without_partner
            .iter()
            .all(|share| (share - 0.1).abs() < 1e-9)
    );
    // Where faces are found, all that touch were meant: it is told, and no warning.
    let (found, warnings) = fit(&path, json!({}), ends);
    assert_eq!(warnings, []);
    assert!(
        found.faces[0]
            .without_partner
            .iter()
            .all(|share| (share - 0.1).abs() < 1e-9)
    );
    // Nothing of the faces is upon one another.
    let (mesh, faces) = blocks(&[[0.0, 0.0], [31.0, 10.0]], &[[30.0, 10.0]; 2]);
    Lap { mesh, faces }.write(&path);
    let refused = Structure::try_new(
        &scene(&path, json!({ "top": "bottom 1", "bottom": "top 0" }), ends),
        &Silent,
    );
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("structure.mesh.interfaces, number 1"), "{message}");
}

/// The plates with a square hole of 10 mm at x = 80 mm.
fn lap_with_hole() -> Lap {
    let mut lap = lap([24, 6, 2], [24, 6, 2]);
    let nodes = lap.mesh.nodes.clone();
    let is_hole = |corners: &[u32]| {
        let middle =
            |axis: usize| corners.iter().map(|&node| nodes[node as usize][axis]).sum::<f64>() / corners.len() as f64;
        (middle(0) - 0.08).abs() < 5e-3 && (middle(1) - 0.015).abs() < 5e-3
    };
    lap.mesh.elements.retain(|element| !is_hole(element.cell.nodes()));
    for group in &mut lap.faces {
        group.members.retain(|face| !is_hole(face.corners()));
    }
    lap
}

#[test]
fn bolts_that_do_not_fit_the_mesh_are_told_or_refused() {
    let folder = TemporaryFolder::new("lap-seats");
    let path = folder.join("lap.msh");
    let bolt =
        |x: f64, size: &str| json!({ "axis": [[x, 0.015, 0.01], [x, 0.015, -0.01]], "size": size, "washers": true });
    let with = |bolts: Vec<Value>| move |value: &mut Value| value["structure"]["mesh"]["bolts"] = json!(bolts);
    lap_with_hole().write(&path);
    let (sound, warnings) = fit(&path, json!({}), with(vec![bolt(0.08, "M10")]));
    assert_eq!(warnings, []);
    let sides: Vec<(usize, &str)> = sound.seats.iter().map(|seat| (seat.bolt, seat.side.as_str())).collect();
    assert_eq!(sides, [(1, "head"), (1, "nut")]);
    // Four corners and four middles of edges.
    let diameter = 5e-3 * (1.0 + std::f64::consts::SQRT_2);
    for seat in &sound.seats {
        let hole = seat.hole.unwrap();
        assert!(
            hole.offset < 1e-12 && (hole.diameter - diameter).abs() < 1e-12,
            "{seat:?}"
        );
        assert!(seat.covered > 0.9 && seat.neighbour.is_none(), "{seat:?}");
    }
    // Two millimetres beside the hole, which both seats show.
    let (off, warnings) = fit(&path, json!({}), with(vec![bolt(0.082, "M10")]));
    let kinds: Vec<WarningKind> = warnings.iter().map(|(kind, _)| *kind).collect();
    assert_eq!(kinds, [WarningKind::BoltOffHole; 2]);
    assert!(
        warnings.iter().all(|(_, value)| (value - 2e-3).abs() < 1e-9),
        "{warnings:?}"
    );
    assert!((off.seats[1].hole.unwrap().diameter - diameter).abs() < 1e-12);
    // Thicker than the hole.
    let (_, warnings) = fit(&path, json!({}), with(vec![bolt(0.08, "M20")]));
    assert!(warnings.contains(&(WarningKind::HoleTooNarrow, 0.02)), "{warnings:?}");

    lap([24, 6, 2], [24, 6, 2]).write(&path);
    // No hole is no contradiction.
    let (none, warnings) = fit(&path, json!({}), with(vec![bolt(0.07, "M8"), bolt(0.09, "M8")]));
    assert_eq!(warnings, []);
    assert!(none.seats.iter().all(|seat| seat.hole.is_none()), "{none:?}");
    assert!((none.seats[0].neighbour.unwrap().room() - 4e-3).abs() < 1e-9);
    // A washer of 115 mm on a plate of 30 mm.
    let (_, warnings) = fit(&path, json!({}), with(vec![bolt(0.08, "M64")]));
    let kinds: Vec<WarningKind> = warnings.iter().map(|(kind, _)| *kind).collect();
    assert_eq!(kinds, [WarningKind::SeatBeyondFace; 2]);
    // Washers of 16 mm 12 mm apart.
    let (_, warnings) = fit(&path, json!({}), with(vec![bolt(0.074, "M8"), bolt(0.086, "M8")]));
    let kinds: Vec<WarningKind> = warnings.iter().map(|(kind, _)| *kind).collect();
    assert_eq!(kinds, [WarningKind::SeatsOverlap; 2]);
    assert!(
        warnings.iter().all(|(_, value)| (value - 0.012).abs() < 1e-9),
        "{warnings:?}"
    );

    // Shanks in one another's place, whichever way they point, and forces on the same faces.
    let reversed = json!({ "axis": [[0.081, 0.015, -0.01], [0.081, 0.015, 0.01]], "size": "M8", "washers": true });
    let forces = json!({ "head": "head", "nut": "nut" });
    for (first, second) in [
        (bolt(0.08, "M8"), bolt(0.08, "M8")),
        (bolt(0.08, "M8"), bolt(0.087, "M8")),
        (bolt(0.08, "M8"), reversed),
        (bolt(0.08, "M8"), forces.clone()),
        (forces.clone(), forces),
    ] {
        let bolts = [bolt(0.05, "M8"), first.clone(), second.clone()];
        let error = Structure::try_new(&scene(&path, json!({}), with(bolts.into())), &Silent).unwrap_err();
        assert_eq!(
            error.field(),
            Some("structure.mesh.bolts, number 3"),
            "{first} {second}: {error}"
        );
        let message = error.to_string();
        assert!(message.contains("bolt 2") && message.contains("mm"), "{message}");
        assert!(
            error.remedy().is_some_and(|remedy| remedy.contains("leave one")),
            "{message}"
        );
    }
}
