//! Structures that come as matrices, from other programs and from this one.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::common::{BENCHMARKS, beam, fixture, lap, material};
use analyses::results::provenance::{InputRole, inputs_of};
use analyses::{Error, Run, run};
use brake_reuss_beam::BrakeReussBenchmark;
use finite_elements::assemble::System;
use finite_elements::formats::abaqus::{self as deck, Choices, Includes};
use joint_model::Bodies;
use joint_model::benchmark::RefinementLevel;
use joints::Options;
use joints::interface::SceneInterface;
use joints::progress::Silent;
use joints::structure::export::{ABOUT_POINTS, arrays, groups, point_matrices, with_short_names};
use joints::structure::{StructuralModel, Structure, export};
use matrix_files::dmig::{self, PointMatrices};
use matrix_files::value::{Array, Assembled, Dense, Dof};
use matrix_files::{abaqus, calculix, mat, matrix_market, npz, op4};
use scenes::{BenchmarkRef, Coordinates, Length, MaterialSource, Scene, Sides, StructureSource, Surface};
use serde_json::{Value, json};
use sprs::CsMat;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A folder of the test's own.
fn folder(test: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("analyses-matrices-{test}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

pub(crate) fn read(scene: &Value) -> Scene {
    Scene::from_json(&scene.to_string(), "the test's scene", "lap", &BENCHMARKS).unwrap()
}

pub(crate) fn go(scene: &Value) -> Run {
    run(&read(scene), &Options::default(), &Silent).unwrap()
}

pub(crate) fn refused(scene: &Value) -> String {
    run(&read(scene), &Options::default(), &Silent).unwrap_err().to_string()
}

/// Largest relative differences of frequency and damping.
fn difference(a: &Run, b: &Run) -> [f64; 2] {
    assert_eq!(a.amplitudes().len(), b.amplitudes().len());
    let pairs = a.amplitudes().iter().zip(b.amplitudes());
    pairs.fold([0.0; 2], |worst, (a, b)| {
        let (a, b) = (a.point.result.as_ref().unwrap(), b.point.result.as_ref().unwrap());
        let found = [
            (a.omega / b.omega - 1.0).abs(),
            (a.zeta - b.zeta).abs() / a.zeta.abs().max(1e-4),
        ];
        [worst[0].max(found[0]), worst[1].max(found[1])]
    })
}

pub(crate) fn dense(matrix: &CsMat<f64>) -> Dense<f64> {
    let full = matrix.to_dense();
    let columns = (0..matrix.cols()).flat_map(|j| full.column(j).to_vec());
    Dense::try_new(matrix.rows(), matrix.cols(), columns.collect()).unwrap()
}

#[test]
fn the_stiffness_of_calculix_is_that_of_the_same_deck_here() {
    let theirs = calculix::read(&fixture("lap.sti")).unwrap();
    let deck = deck::read(fixture("lap.inp"), Includes::BelowTheDeck)
        .unwrap()
        .assembly(&Choices::default())
        .unwrap();
    let own = System::try_new(&deck.assembly).unwrap();
    let other = &theirs.matrices[Assembled::STIFFNESS];
    let largest = own.stiffness.data().iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    let rows: Vec<usize> = theirs
        .dofs
        .iter()
        .map(|dof| {
            let node = deck.node(&dof.label().to_string()).unwrap();
            own.dofs.independent_index(node, dof.component() as u8 - 1).unwrap()
        })
        .collect();
    assert_eq!(rows.len(), own.n_dofs());
    for (i, &a) in rows.iter().enumerate() {
        for (j, &b) in rows.iter().enumerate() {
            let [mine, his] = [own.stiffness.get(a, b), other.get(i, j)].map(|v| v.copied().unwrap_or(0.0));
            assert!((mine - his).abs() < 1e-12 * largest, "{i} {j}: {mine} {his}");
        }
    }
    // It integrates the mass of these elements at one point, which leaves motions without mass.
    let total = theirs.matrices[Assembled::MASS].data().iter().sum::<f64>();
    assert!((total / (3.0 * own.total_mass) - 1.0).abs() < 1e-12);
}

#[test]
fn all_files_of_the_matrices_are_inputs() {
    let names = |path: &Path| {
        let inputs = inputs_of(&read(&lap(path, 1.0, &json!({})))).unwrap();
        assert!(inputs.iter().all(|input| input.role == InputRole::Matrices));
        let names = inputs
            .iter()
            .map(|input| input.path.rsplit('/').next().unwrap().to_owned());
        names.collect::<Vec<_>>()
    };
    assert_eq!(names(&fixture("lap.sti")), ["lap.sti", "lap.mas", "lap.dof"]);
    let folder = folder("inputs");
    for name in ["K.mtx", "M.mtx", "notes.txt"] {
        std::fs::write(folder.join(name), name).unwrap();
    }
    assert_eq!(names(&folder), ["M.mtx", "K.mtx"]);
    let input = inputs_of(&read(&lap(&folder, 1.0, &json!({})))).unwrap().remove(0);
    input.check(&folder).unwrap();
    std::fs::write(folder.join("M.mtx"), "other").unwrap();
    let error = input.check(&folder).unwrap_err();
    assert!(
        matches!(&error, Error::InputChanged { path, .. } if path.ends_with("M.mtx")),
        "{error}"
    );
}

#[test]
fn matrices_run_from_every_format_and_in_every_order_and_unit() {
    let folder = folder("formats");
    let reference = go(&lap(&fixture("lap.sti"), 1.0, &json!({})));
    // Two blocks of 60 x 20 x 10 mm.
    assert!((reference.model.facts.mass.unwrap() / (2.0 * 0.06 * 0.02 * 0.01 * 7800.0) - 1.0).abs() < 1e-9);
    assert_eq!(
        (reference.model.reduced.zem_stuck, reference.model.facts.zem_unstressed),
        (6, 12)
    );
    assert!(reference.prestress.equilibrium_error < 1e-9);
    let zeta = |at: usize| reference.amplitudes()[at].point.result.as_ref().unwrap().zeta;
    assert!(zeta(4) > 1e-3 && zeta(0) < 1e-6, "{} {}", zeta(4), zeta(0));

    let Assembled { dofs, matrices } = calculix::read(&fixture("lap.sti")).unwrap();
    let [stiffness, mass] = [Assembled::STIFFNESS, Assembled::MASS].map(|name| &matrices[name]);
    let n = dofs.len();
    // Rows in another order.
    let order: Vec<usize> = (0..n).map(|i| (i * 35 + 11) % n).collect();
    let turned = |matrix: &CsMat<f64>, unit: f64| {
        let full = dense(matrix);
        let columns = order.iter().flat_map(|&j| order.iter().map(move |&i| (i, j)));
        Dense::try_new(n, n, columns.map(|at| full[at] / unit).collect()).unwrap()
    };
    let turned_dofs: Vec<Dof> = order.iter().map(|&i| dofs[i]).collect();
    let written = |unit: f64| -> BTreeMap<String, Array> {
        [
            ("K", Array::Dense(turned(stiffness, unit))),
            ("M", Array::Dense(turned(mass, unit))),
            ("dofs", Dof::table(&turned_dofs)),
        ]
        .map(|(name, array)| (name.to_owned(), array))
        .into()
    };
    std::fs::write(folder.join("si.npz"), npz::to_bytes(&written(1.0)).unwrap()).unwrap();
    std::fs::write(folder.join("mm.mat"), mat::to_bytes(&written(1e3)).unwrap()).unwrap();
    let mut substructure = abaqus::Substructure {
        dofs: turned_dofs.clone(),
        ..abaqus::Substructure::default()
    };
    substructure.matrices.insert("STIFFNESS".into(), turned(stiffness, 1.0));
    substructure.matrices.insert("MASS".into(), turned(mass, 1.0));
    let scene = lap(
        &folder.join("abaqus.mtx"),
        1.0,
        &json!({ "bolts": [{ "load-case": "BOLT" }] }),
    );
    let terms = &lap(Path::new(""), 1.0, &json!({}))["structure"]["matrices"]["bolts"][0]["terms"];
    let mut load = vec![0.0; n];
    for term in terms.as_array().unwrap() {
        let dof = Dof::new(term[0].as_i64().unwrap(), 3);
        load[turned_dofs.iter().position(|d| *d == dof).unwrap()] = term[2].as_f64().unwrap();
    }
    substructure.loads.insert("BOLT".into(), load);
    let bytes = abaqus::substructure_to_bytes(&substructure).unwrap();
    std::fs::write(folder.join("abaqus.mtx"), bytes).unwrap();

    let mut named = written(1.0);
    // Capitals do not matter; what has another name is not needed.
    named.insert("KX".into(), Array::Integers(Dense::default()));
    std::fs::write(folder.join("si.op4"), op4::to_bytes(&named).unwrap()).unwrap();
    let points = PointMatrices {
        dofs: dofs.clone(),
        matrices: [("KAAX", stiffness), ("MAAX", mass)]
            .map(|(name, matrix)| (name.to_owned(), matrix.clone()))
            .into(),
        ..PointMatrices::default()
    };
    std::fs::write(folder.join("si.pch"), dmig::to_bytes(&points, "").unwrap()).unwrap();

    std::fs::write(folder.join("si.op2"), tables(&points)).unwrap();
    std::fs::write(folder.join("si.full"), assembled(&dofs, [stiffness, mass])).unwrap();

    let runs = [
        ("op2", go(&lap(&folder.join("si.op2"), 1.0, &json!({})))),
        ("full", go(&lap(&folder.join("si.full"), 1.0, &json!({})))),
        ("op4", go(&lap(&folder.join("si.op4"), 1.0, &json!({})))),
        ("pch", go(&lap(&folder.join("si.pch"), 1.0, &json!({})))),
        ("npz", go(&lap(&folder.join("si.npz"), 1.0, &json!({})))),
        ("mat", go(&lap(&folder.join("mm.mat"), 1e-3, &json!({})))),
        ("Abaqus", go(&scene)),
    ];
    for (name, other) in &runs {
        let [omega, zeta] = difference(&reference, other);
        assert!(omega < 1e-9 && zeta < 1e-6, "{name}: {omega:e} {zeta:e}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}

/// `OUTPUT2` with a table of entries `DMIG` for each matrix.
fn tables(points: &PointMatrices) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut record = |words: &[i32]| {
        let length = (4 * words.len() as i32).to_le_bytes();
        let words = words.iter().flat_map(|word| word.to_le_bytes());
        bytes.extend(length.into_iter().chain(words).chain(length));
    };
    let point = |dof: &Dof| [dof.label() as i32, dof.component() as i32];
    for (name, matrix) in &points.matrices {
        let name: Vec<i32> = format!("{name:<8}")
            .as_bytes()
            .chunks(4)
            .map(|word| i32::from_le_bytes(word.try_into().unwrap()))
            .collect();
        let mut words = vec![114, 1, 120, name[0], name[1], 0, 1, 2, 2, 0, 0, 0];
        // By rows, as the matrix is symmetric.
        for (row, dof) in matrix.outer_iterator().zip(&points.dofs) {
            words.extend(point(dof));
            for (column, value) in row.iter() {
                words.extend(point(&points.dofs[column]));
                let bits = value.to_bits();
                words.extend([bits as u32, (bits >> 32) as u32].map(u32::cast_signed));
            }
            words.extend([-1, -1]);
        }
        words.extend([-1, -1]);
        record(&[2]);
        record(&name);
        record(&[-1]);
        record(&[7]);
        record(&[101, 0, 0, 0, 0, 0, 0]);
        [-2, 1, 0, 2].iter().for_each(|key| record(&[*key]));
        record(&name);
        [-3, 1, 0, words.len() as i32].iter().for_each(|key| record(&[*key]));
        record(&words);
        [-4, 1, 0, 0].iter().for_each(|key| record(&[*key]));
    }
    bytes
}

/// A file FULL of Ansys with stiffness and mass.
fn assembled(dofs: &[Dof], matrices: [&CsMat<f64>; 2]) -> Vec<u8> {
    fn record(words: &[u8], flags: u32) -> Vec<u8> {
        let length = (words.len() as u32 / 4).to_le_bytes();
        [&length, &flags.to_le_bytes(), words, &length].concat()
    }
    let integers = |list: &[i32]| {
        let bytes: Vec<u8> = list.iter().flat_map(|v| v.to_le_bytes()).collect();
        record(&bytes, 1 << 31)
    };
    // A node for each row.
    let n = dofs.len();
    let nodes: Vec<i32> = dofs.iter().map(|dof| dof.label() as i32).collect();
    let components: Vec<i32> = dofs.iter().map(|dof| dof.component() as i32).collect();
    let mut head = vec![0; 100];
    (head[0], head[1], head[32], head[8], head[33]) = (-4, n as i32, n as i32, 1, 1);
    let mut standard = vec![0; 100];
    standard[0] = 4;
    let ahead = |head: &[i32]| {
        [
            integers(&standard),
            integers(head),
            integers(&[1, 2, 3]),
            integers(&nodes),
        ]
        .concat()
    };
    let start = ahead(&head).len();
    let mut rest = [integers(&vec![1; n]), integers(&components)].concat();
    head[35] = start as i32 / 4;
    for (matrix, pointer) in matrices.into_iter().zip([18, 26]) {
        head[pointer] = (start + rest.len()) as i32 / 4;
        for (i, row) in matrix.outer_iterator().enumerate() {
            let upper: Vec<(usize, f64)> = row.iter().map(|(j, v)| (j, *v)).filter(|(j, _)| *j >= i).collect();
            let columns: Vec<i32> = upper.iter().map(|(j, _)| *j as i32 + 1).collect();
            let values: Vec<u8> = upper.iter().flat_map(|(_, v)| v.to_le_bytes()).collect();
            rest.extend([integers(&columns), record(&values, 0)].concat());
        }
    }
    [ahead(&head), rest].concat()
}

/// Writes a reduced model in all formats; returns the paths.
pub(crate) fn export(scene: &Scene, folder: &Path) -> (BTreeMap<String, Array>, [PathBuf; 4]) {
    let structure = Structure::try_new(scene, &Silent).unwrap();
    let model = structure.reduce(&Options::default(), &Silent).unwrap();
    let arrays = arrays(&model, &structure.joint).unwrap();
    let paths = [
        folder.join("reduced.npz"),
        folder.join("reduced.mat"),
        folder.join("mtx"),
        folder.join("reduced.op4"),
    ];
    std::fs::write(&paths[0], npz::to_bytes(&arrays).unwrap()).unwrap();
    std::fs::write(&paths[1], mat::to_bytes(&arrays).unwrap()).unwrap();
    let short = with_short_names(arrays.clone());
    std::fs::write(&paths[3], op4::to_bytes(&short).unwrap()).unwrap();
    std::fs::create_dir_all(&paths[2]).unwrap();
    for (name, array) in arrays.iter().filter(|(_, array)| !matches!(array, Array::Text(_))) {
        let bytes = matrix_market::to_bytes(array).unwrap();
        std::fs::write(paths[2].join(format!("{name}.mtx")), bytes).unwrap();
    }
    (arrays, paths)
}

/// The mesh of the interface as a scene gives it.
fn plane(arrays: &BTreeMap<String, Array>) -> Value {
    let (Array::Dense(nodes), Array::Integers(elements)) = (&arrays["interface_nodes"], &arrays["interface_elements"])
    else {
        panic!("a mesh")
    };
    let nodes: Vec<[f64; 2]> = (0..nodes.rows()).map(|i| [nodes[(i, 0)], nodes[(i, 1)]]).collect();
    let corners = |i: usize| (0..elements.columns()).map(move |j| elements[(i, j)]);
    let elements: Vec<Vec<i64>> = (0..elements.rows()).map(|i| corners(i).collect()).collect();
    json!({ "nodes": nodes, "elements": elements })
}

/// A scene on matrices over the jump, with all else from another one.
pub(crate) fn on_jump(scene: &Value, path: &Path) -> Value {
    let mut scene = scene.clone();
    scene["structure"] = json!({ "matrices": { "path": path, "coordinates": "jump" } });
    scene["model"] = json!({ "material": material() });
    scene
}

#[test]
fn exported_models_come_back_the_same() {
    let folder = folder("exported");
    let mut scene = lap(&fixture("lap.sti"), 1.0, &json!({}));
    for behaviour in ["dead-load", "locked"] {
        scene["bolts"]["behaviour"] = json!(behaviour);
        let direct = go(&scene);
        let (arrays, paths) = export(&read(&scene), &folder);
        for path in &paths {
            let again = go(&on_jump(&scene, path));
            let [omega, zeta] = difference(&direct, &again);
            assert!(omega < 1e-9 && zeta < 1e-6, "{}: {omega:e} {zeta:e}", path.display());
        }
        // As entries DMIG, which have no place for the mesh of the interface.
        let path = folder.join("reduced.pch");
        let points = point_matrices(&arrays);
        assert!(points.dofs.iter().all(|dof| matches!(dof, Dof::Nodal { .. })));
        std::fs::write(&path, dmig::to_bytes(&points, ABOUT_POINTS).unwrap()).unwrap();
        let mut on_points = on_jump(&scene, &path);
        on_points["structure"]["matrices"]["interface"] = plane(&arrays);
        let again = go(&on_points);
        let [omega, zeta] = difference(&direct, &again);
        assert!(omega < 1e-9 && zeta < 1e-6, "DMIG: {omega:e} {zeta:e}");

        // In coordinates x with q = L x, as null-space projections give them.
        let (n, q) = match &arrays["K"] {
            Array::Dense(k) => (k.rows(), |k: &Array| match k {
                Array::Dense(k) => k.clone(),
                _ => unreachable!(),
            }),
            _ => unreachable!(),
        };
        // Unit diagonal, and a little of everything: well conditioned.
        let lift = Dense::try_new(
            n,
            n,
            (0..n * n)
                .map(|at| f64::from(u8::from(at / n == at % n)) + ((at as f64 * 0.7).sin()) / n as f64)
                .collect(),
        )
        .unwrap();
        let times = |a: &Dense<f64>, b: &Dense<f64>, transposed: bool| {
            let entry = |i: usize, j: usize| -> f64 {
                (0..a.rows())
                    .map(|k| if transposed { a[(k, i)] } else { a[(i, k)] } * b[(k, j)])
                    .sum()
            };
            let rows = if transposed { a.columns() } else { a.rows() };
            let columns = (0..b.columns()).flat_map(|j| (0..rows).map(move |i| (i, j)));
            Dense::try_new(rows, b.columns(), columns.map(|(i, j)| entry(i, j)).collect()).unwrap()
        };
        let mut other = arrays.clone();
        for name in ["K", "M"] {
            let right = times(&q(&arrays[name]), &lift, false);
            other.insert(name.into(), Array::Dense(times(&lift, &right, true)));
        }
        other.insert("Fv".into(), Array::Dense(times(&lift, &q(&arrays["Fv"]), true)));
        // A row vector from the left.
        let r = q(&arrays["R"]);
        let row: Vec<f64> = (0..n).map(|j| (0..n).map(|k| r[(0, k)] * lift[(k, j)]).sum()).collect();
        other.insert("R".into(), Array::Dense(Dense::try_new(1, n, row).unwrap()));
        other.insert("L".into(), Array::Dense(lift));
        let path = folder.join("lifted.npz");
        std::fs::write(&path, npz::to_bytes(&other).unwrap()).unwrap();
        let again = go(&on_jump(&scene, &path));
        let [omega, zeta] = difference(&direct, &again);
        assert!(omega < 1e-8 && zeta < 1e-5, "L: {omega:e} {zeta:e}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn the_exported_beam_gives_the_same_backbone() {
    let folder = folder("beam");
    let mut scene = beam("quick");
    scene.model.refinement = RefinementLevel::Quick;
    scene.analyses.backbone.amplitudes = 4;
    scene.analyses.backbone.amplitude_from = Length::from_si(1e-6);
    scene.analyses.backbone.vertices_per_quarter = 4;
    let direct = run(&scene, &Options::default(), &Silent).unwrap();
    let (_, paths) = export(&scene, &folder);
    let mut on_matrices = on_jump(&serde_json::to_value(&scene).unwrap(), &paths[0]);
    on_matrices["interfaces"]["surface"] = json!({ "benchmark": "brake-reuss-beam" });
    let again = go(&on_matrices);
    let [omega, zeta] = difference(&direct, &again);
    assert!(omega < 1e-9 && zeta < 1e-6, "{omega:e} {zeta:e}");
    // The scene in the summary is one, and says the same.
    let repeated = Scene::from_json(
        &serde_json::to_string(&again.scene).unwrap(),
        "summary",
        "",
        &BENCHMARKS,
    )
    .unwrap();
    assert_eq!(repeated, again.scene);
    // Reduced once, it is not reduced again.
    assert_eq!(again.model.reduced.size(), direct.model.reduced.size());
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn the_deck_of_the_beam_gives_the_same_structure() {
    let folder = folder("deck");
    let mut scene = beam("quick");
    scene.model.refinement = RefinementLevel::Quick;
    let structure = Structure::try_new(&scene, &Silent).unwrap();
    let Bodies::Meshed(bodies) = &structure.joint.bodies else {
        panic!("the beam is meshed");
    };
    let (faces, nodes) = groups(&structure.joint, bodies);
    let path = folder.join("structure.inp");
    std::fs::write(&path, deck::write(&bodies.assembly, &faces, &nodes).unwrap()).unwrap();
    scene.structure = StructureSource::Deck(Box::new(export::deck(
        &structure.joint,
        bodies,
        &path,
        MaterialSource::Scene,
    )))
    .into();
    (scene.model.refinement, scene.interfaces.surface) = (
        RefinementLevel::Default,
        Surface::Benchmark(BenchmarkRef(&BrakeReussBenchmark)),
    );
    let again = Structure::try_new(&scene, &Silent).unwrap();
    let [direct, read] = [&structure, &again].map(|structure| structure.reduce(&Options::default(), &Silent).unwrap());
    assert_eq!(direct.facts.mass, read.facts.mass);
    let frequencies = |model: &StructuralModel| {
        let facts = &model.facts;
        [
            &facts.unstressed_frequencies_hz[..],
            &facts.penalty_frequencies_hz,
            &model.reduced.stuck_frequencies,
        ]
        .concat()
    };
    for (a, b) in frequencies(&direct).iter().zip(frequencies(&read)) {
        assert!((a / b - 1.0).abs() < 1e-8, "{a} {b}");
    }
    // Bolts and response act on the same places; nodes of the interface may be numbered otherwise.
    let sums = |model: &StructuralModel| -> Vec<f64> {
        let work = |load: &[f64]| {
            load.iter()
                .take(model.reduced.n_relative)
                .skip(2)
                .step_by(3)
                .sum::<f64>()
        };
        let response: Vec<f64> = model.reduced.recovery.row(0).iter().copied().collect();
        let loads = model.reduced.loads.iter().map(|load| work(load));
        loads.chain([work(&response)]).collect()
    };
    for (a, b) in sums(&direct).iter().zip(sums(&read)) {
        assert!((a - b).abs() < 1e-8 * (1.0 + a.abs()), "{a} {b}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn flipped_contact_is_refused() {
    let path = fixture("lap.sti");
    let sti = |matrices: &Value| lap(&path, 1.0, matrices);
    let good = sti(&json!({}));
    let matrices = &good["structure"]["matrices"];
    // The normal from the bottom body into the top one; the sides exchanged; the bolt pushing.
    let mut frame = matrices["coordinates"].clone();
    frame["both-sides"]["frame"][2][2] = json!(1.0);
    let mut sides = matrices["coordinates"].clone();
    let (top, bottom) = (sides["both-sides"]["top"].take(), sides["both-sides"]["bottom"].take());
    (sides["both-sides"]["top"], sides["both-sides"]["bottom"]) = (bottom, top);
    let mut bolt = matrices["bolts"].clone();
    for term in bolt[0]["terms"].as_array_mut().unwrap() {
        term[2] = json!(-term[2].as_f64().unwrap());
    }
    // Components in another order.
    let mut turned = matrices["coordinates"].clone();
    turned["both-sides"]["frame"] = json!([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    for changed in [
        json!({ "coordinates": frame }),
        json!({ "coordinates": sides }),
        json!({ "bolts": bolt }),
        json!({ "coordinates": turned }),
    ] {
        let message = refused(&sti(&changed));
        assert!(message.contains("bolt 1 does not close the interface"), "{message}");
        assert!(message.contains("exchange its two ends or the two sides"), "{message}");
    }
    // Nodes that do not face one another: turning the structure would make them slide.
    let mut shuffled = matrices["coordinates"].clone();
    shuffled["both-sides"]["bottom"].as_array_mut().unwrap().rotate_left(1);
    let message = refused(&sti(&json!({ "coordinates": shuffled })));
    assert!(message.contains("zero-energy modes, but 6 were expected"), "{message}");
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let folder = folder("refusals");
    let scene = lap(&fixture("lap.sti"), 1.0, &json!({}));
    let (good, _) = export(&read(&scene), &folder);
    let path = folder.join("changed.npz");
    let changed = |name: &str, array: Option<Array>| {
        let mut arrays = good.clone();
        match array {
            Some(array) => arrays.insert(name.into(), array),
            None => arrays.remove(name),
        };
        std::fs::write(&path, npz::to_bytes(&arrays).unwrap()).unwrap();
        refused(&on_jump(&scene, &path))
    };
    let Array::Dense(stiffness) = &good["K"] else {
        unreachable!()
    };
    let n = stiffness.rows();
    let mut unsymmetric = stiffness.data().to_vec();
    unsymmetric[1] += 1e-3 * unsymmetric[0];
    let table = |dofs: &dyn Fn(i64) -> (i64, u32)| {
        let dofs: Vec<Dof> = (0..n as i64).map(dofs).map(|(l, c)| Dof::new(l, c)).collect();
        Some(Dof::table(&dofs))
    };
    let column = |rows: usize| Some(Array::Dense(Dense::try_new(rows, 1, vec![1.0; rows]).unwrap()));
    // One entry at the end of a matrix far larger than the file.
    let sparse = |rows: usize, columns: usize| {
        let mut entries = sprs::TriMat::new((rows, columns));
        entries.add_triplet(rows - 1, columns - 1, 1.0);
        Some(Array::Sparse(entries.to_csr()))
    };
    for (name, array, said) in [
        ("dofs", None, "add an array `dofs` with a row `label, component`"),
        ("K", None, "it has no stiffness K"),
        ("M", None, "it has no mass M"),
        ("Fv", None, "name them as structure.matrices.bolts"),
        ("R", None, "it has no row of the recovery R number 1"),
        ("interface_nodes", None, "give structure.matrices.interface"),
        (
            "K",
            Some(Array::Dense(Dense::try_new(n, n, unsymmetric).unwrap())),
            "entries (1, 2) and (2, 1) differ by",
        ),
        ("Fv", column(n - 1), "but its loads Fv over"),
        ("Fv", sparse(1 << 20, 1 << 20), "but its loads Fv over 1048576"),
        (
            "Fv",
            sparse(n, 1 << 20),
            "name those of the bolts as structure.matrices.bolts",
        ),
        ("R", sparse(1 << 20, 1 << 20), "but its recovery R over 1048576"),
        ("M", sparse(1 << 20, 1 << 20), "but its mass over 1048576"),
        ("L", sparse(1 << 20, 1 << 20), "but its L over 1048576"),
        ("frame", sparse(1 << 20, 1 << 20), "`frame` is not 3 x 3"),
        ("dofs", sparse(1 << 20, 1 << 20), "not a full matrix of whole numbers"),
        ("dofs", table(&|_| (1, 1)), "names one twice"),
        ("dofs", table(&|i| (i + 100, 1)), "component 1 of 1 is not in its map"),
        ("dofs", column(n), "two columns"),
        ("frame", column(3), "`frame` is not 3 x 3"),
        ("K", Some(Array::Text("K".into())), "not a matrix of numbers"),
    ] {
        let message = changed(name, array);
        assert!(message.contains(said), "{name}: {message}");
        assert!(message.contains("changed.npz"), "{message}");
    }
    // A row of a large recovery is one vector, whatever the others would need.
    let mut rows = sprs::TriMat::new((1 << 20, n));
    rows.add_triplet(0, n - 1, 1.0);
    let mut arrays = good.clone();
    arrays.insert("R".into(), Array::Sparse(rows.to_csr()));
    std::fs::write(&path, npz::to_bytes(&arrays).unwrap()).unwrap();
    go(&on_jump(&scene, &path));
    // The sign of the load, as the file has it.
    let Array::Dense(load) = &good["Fv"] else {
        unreachable!()
    };
    let flipped = load.data().iter().map(|v| -v).collect();
    let message = changed("Fv", Some(Array::Dense(Dense::try_new(n, 1, flipped).unwrap())));
    assert!(message.contains("does not close the interface"), "{message}");
    let missing = refused(&on_jump(&scene, &folder.join("nothing.sti")));
    assert!(missing.contains("nothing"), "{missing}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn given_parameters_belong_to_interface_elements_or_points() {
    let mut scene = lap(&fixture("lap.sti"), 1.0, &json!({}));
    scene["interfaces"]["points_per_direction"] = json!(2);
    let reference = go(&scene);
    let set = scene["interfaces"]["surface"]["parameters"]["sets"][0].clone();
    // Three elements of 2 x 2 points.
    for (per, count) in [("element", 3), ("point", 12)] {
        scene["interfaces"]["surface"]["parameters"] = json!({ "per": per, "sets": vec![set.clone(); count] });
        assert_eq!(difference(&reference, &go(&scene)), [0.0, 0.0], "{per}");
        scene["interfaces"]["surface"]["parameters"]["sets"]
            .as_array_mut()
            .unwrap()
            .pop();
        let message = refused(&scene);
        assert!(
            message.contains(&format!("{} sets are given for {count}", count - 1)),
            "{message}"
        );
    }
    // One element without friction carries its share of the load all the same, another is out of reach.
    let mut sets = vec![set; 3];
    sets[0]["mu"] = json!(0.0);
    sets[2]["gap"] = json!(1e-3);
    scene["interfaces"]["surface"]["parameters"] = json!({ "per": "element", "sets": sets });
    let changed = go(&scene);
    assert!(changed.prestress.equilibrium_error < 1e-9);
    let open = |p: usize| changed.prestress.fields.jump[2][p] < 0.0;
    assert!((8..12).all(open) && !(0..8).all(open));
    scene["interfaces"]["surface"]["parameters"]["sets"][1]["curves"] = json!({ "fitted": {
        "normal": [13.0, 2.2, 0.4, 0.5, 1.2], "tangential": [[28.0, 1.5, 0.3, 0.6], [28.0, 1.5, 0.3, 0.6]], "u_ref": 1e-6,
    } });
    assert!(refused(&scene).contains("set 2 has other curves than the first"));
    let sets = scene["interfaces"]["surface"]["parameters"]["sets"]
        .as_array_mut()
        .unwrap();
    let fitted = sets[1].clone();
    sets.fill(fitted);
    let fitted = go(&scene);
    assert_eq!(fitted.law().kind, "fitted");
    assert!(fitted.law().asperities.is_none());
    for (field, value) in [("mu", -0.1), ("gap", -1e-6)] {
        let mut wrong = scene.clone();
        wrong["interfaces"]["surface"]["parameters"]["sets"][2][field] = json!(value);
        let error = Scene::from_json(&wrong.to_string(), "wrong", "", &BENCHMARKS)
            .unwrap_err()
            .to_string();
        assert!(error.contains("number 3") && error.contains(field), "{error}");
    }
    let mut idle = scene.clone();
    idle["interfaces"]["law"] = json!({ "kind": "asperity-sum" });
    let error = Scene::from_json(&idle.to_string(), "idle", "", &BENCHMARKS)
        .unwrap_err()
        .to_string();
    assert!(error.contains("interfaces.law.kind belongs to asperities"), "{error}");
}

/// Two cubes of 20 mm upon one another; the bolt pulls at reference nodes of kinematic couplings.
const TWO_CUBES: &str = "\
*NODE
1, 0., 0., 0.
2, 0.02, 0., 0.
3, 0.02, 0.02, 0.
4, 0., 0.02, 0.
5, 0., 0., 0.02
6, 0.02, 0., 0.02
7, 0.02, 0.02, 0.02
8, 0., 0.02, 0.02
11, 0., 0., 0.02
12, 0.02, 0., 0.02
13, 0.02, 0.02, 0.02
14, 0., 0.02, 0.02
15, 0., 0., 0.04
16, 0.02, 0., 0.04
17, 0.02, 0.02, 0.04
18, 0., 0.02, 0.04
100, 0.01, 0.01, 0.
101, 0.01, 0.01, 0.04
*ELEMENT, TYPE=C3D8I, ELSET=ALL
1, 1, 2, 3, 4, 5, 6, 7, 8
2, 11, 12, 13, 14, 15, 16, 17, 18
*SOLID SECTION, ELSET=ALL, MATERIAL=ALUMINIUM
,
*MATERIAL, NAME=ALUMINIUM
*ELASTIC
70E9, 0.33
*DENSITY
2700.,
*SURFACE, NAME=LOWER
1, S2
*SURFACE, NAME=UPPER
2, S1
*SURFACE, NAME=FOOT
1, S1
*SURFACE, NAME=HEAD
2, S2
*COUPLING, CONSTRAINT NAME=NUT, REF NODE=100, SURFACE=FOOT
*KINEMATIC
*COUPLING, CONSTRAINT NAME=BOLT, REF NODE=101, SURFACE=HEAD
*KINEMATIC
";

#[test]
fn bodies_have_the_material_of_their_deck_unless_the_scenes_is_asked_for() {
    let folder = folder("material");
    let path = folder.join("cubes.inp");
    std::fs::write(&path, TWO_CUBES).unwrap();
    let mut scene = lap(&path, 1.0, &json!({}));
    scene["structure"] = json!({ "deck": {
        "path": path,
        "top_surface": "UPPER",
        "bottom_surface": "LOWER",
        "bolts": [{ "top": "101", "bottom": "100" }],
        "response": { "node": "18", "direction": [0.0, 0.0, 1.0] },
    } });
    let mass_and_material = |scene: &Value| {
        let structure = Structure::try_new(&read(scene), &Silent).unwrap();
        let Bodies::Meshed(bodies) = &structure.joint.bodies else {
            unreachable!()
        };
        let system = System::try_new(&bodies.assembly).unwrap();
        // Unit tension at the two reference nodes.
        assert_eq!(system.loads[0].iter().map(|f| f.abs()).sum::<f64>(), 2.0);
        let [material] = &bodies.assembly.mesh.materials[..] else {
            panic!("one material")
        };
        (system.total_mass, material.youngs_modulus, material.poisson_ratio)
    };
    let volume = 2.0 * 0.02_f64.powi(3);
    let (mass, modulus, ratio) = mass_and_material(&scene);
    assert!((mass / (2700.0 * volume) - 1.0).abs() < 1e-12, "{mass}");
    assert_eq!((modulus, ratio), (70e9, 0.33));
    scene["structure"]["deck"]["materials"] = json!("scene");
    scene["model"]["material"]["density"] = json!(7850.0);
    let (mass, modulus, ratio) = mass_and_material(&scene);
    assert!((mass / (7850.0 * volume) - 1.0).abs() < 1e-12, "{mass}");
    assert_eq!((modulus, ratio), (192.85e9, 0.29));
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn gaps_of_any_size_are_closed_or_refused() {
    let mut scene = lap(&fixture("lap.sti"), 1.0, &json!({}));
    // Up to the size of the faces, 63 mm, the bracket of the closure grows; beyond, the gap is refused.
    for gap in [1e-6, 1e-3, 0.06] {
        scene["interfaces"]["surface"]["parameters"]["sets"][0]["gap"] = json!(gap);
        let structure = Structure::try_new(&read(&scene), &Silent).unwrap();
        let interface = SceneInterface::try_new(&read(&scene), &structure.joint.interface, &[], 2000.0).unwrap();
        assert!(interface.closure > gap && interface.closure < gap + 1e-6, "{gap}");
    }
    for gap in [0.07, 1.7e7, 1e16, 1e300] {
        scene["interfaces"]["surface"]["parameters"]["sets"][0]["gap"] = json!(gap);
        let error = run(&read(&scene), &Options::default(), &Silent).unwrap_err();
        assert!(
            matches!(error, Error::Joint(joints::Error::GapBeyondFaces { .. })),
            "{gap}: {error}"
        );
    }
}

#[test]
fn coordinates_are_named_as_documented() {
    let sides = Coordinates::BothSides(Sides {
        top: vec![1],
        bottom: vec![2],
        frame: [[0.0; 3]; 3],
    });
    assert_eq!(serde_json::to_value(Coordinates::Jump).unwrap(), json!("jump"));
    assert!(serde_json::to_value(sides).unwrap()["both-sides"]["top"].is_array());
    let error = Structure::try_new(
        &read(&on_jump(&lap(Path::new("x"), 1.0, &json!({})), Path::new("absent.hdf"))),
        &Silent,
    )
    .unwrap_err();
    assert!(matches!(error, joints::Error::Matrices { .. }), "{error}");
}
