//! Files that other programs wrote, with the numbers that were put into them.
//!
//! `make_scipy.py` made those of NumPy and SciPy, `make_octave.m` those of Octave, `make_ansys.py` that of Ansys. CalculiX 2.20 made
//! `two_hexes.sti`, `.mas` and `.dof` from `two_hexes.inp`, and `two_hexes.mtx` from `two_hexes_substructure.inp`.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use crate::nastran::fixture;
use file_io::Source;
use matrix_files::value::{Array, Assembled, Collection, Dense, Dof};
use matrix_files::{Error, abaqus, ansys, calculix, mat, matrix_market, npz};
use sprs::CsMat;
use test_support::TemporaryFolder;

fn dense(rows: usize, columns: usize, by_rows: &[f64]) -> Array {
    Array::Dense(Dense::try_from_rows(rows, columns, by_rows.to_vec()).unwrap())
}

fn integers(rows: usize, columns: usize, by_rows: &[i64]) -> Array {
    Array::Integers(Dense::try_from_rows(rows, columns, by_rows.to_vec()).unwrap())
}

fn text(text: &str) -> Array {
    Array::Text(text.into())
}

/// `K` of `make_scipy.py`.
fn stiffness() -> Array {
    let values = vec![4.0, -1.5, -1.5, 3.0, 1e-3, 1e-3, 2.5e9];
    Array::Sparse(CsMat::new((3, 3), vec![0, 2, 5, 7], vec![0, 1, 0, 1, 2, 1, 2], values))
}

/// `M` of `make_scipy.py`.
fn matrix() -> Array {
    dense(2, 3, &[1.0, 2.0, 3.0, 0.5, -6.25, 1e-300])
}

fn assert_arrays(found: &Collection, expected: &[(&str, Array)], skipped: &[&str]) {
    let expected: BTreeMap<String, Array> = expected.iter().map(|(k, v)| ((*k).into(), v.clone())).collect();
    for (name, array) in &expected {
        assert_eq!(found.arrays.get(name), Some(array), "{name}");
    }
    assert!(found.arrays.keys().eq(expected.keys()), "{:?}", found.arrays.keys());
    let mut names: Vec<&str> = found.skipped.iter().map(|s| s.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, skipped);
}

#[test]
fn matlab_files_of_scipy() {
    for name in ["plain.mat", "compressed.mat"] {
        assert_arrays(
            &mat::read(&fixture(name)).unwrap(),
            &[
                ("K", stiffness()),
                ("M", matrix()),
                ("dofs", integers(3, 2, &[11, 1, 12, 3, -1, 1])),
                ("single", dense(1, 2, &[0.5, -2.0])),
                ("small", dense(2, 1, &[1.0, 200.0])),
                ("fixed", integers(1, 2, &[1, 0])),
                ("note", text("joint µ")),
                ("lines", text("top\nbottom")),
                ("model.K", dense(2, 2, &[1.0, 0.0, 0.0, 1.0])),
                ("model.info.units", text("SI")),
                ("empty", dense(0, 3, &[])),
            ],
            &["parts", "response", "waves"],
        );
    }
}

#[test]
fn matlab_files_of_octave() {
    for name in ["octave_v6.mat", "octave_v7.mat"] {
        assert_arrays(
            &mat::read(&fixture(name)).unwrap(),
            &[
                ("K", stiffness()),
                ("M", matrix()),
                (
                    "R",
                    Array::Sparse(CsMat::new((2, 4), vec![0, 1, 1], vec![2], vec![-2.0])),
                ),
                ("dofs", integers(3, 2, &[11, 1, 12, 3, -1, 1])),
                ("single_precision", dense(1, 2, &[0.5, -2.0])),
                ("fixed", integers(1, 2, &[1, 0])),
                ("note", text("joint")),
                ("lines", text("top\nbottom")),
                ("model.K", dense(2, 2, &[1.0, 0.0, 0.0, 1.0])),
                ("model.units", text("SI")),
                ("model.count", integers(1, 1, &[7])),
                ("range", dense(1, 4, &[1.0, 2.0, 3.0, 4.0])),
                ("nothing", dense(0, 0, &[])),
            ],
            &["parts", "response"],
        );
    }
}

#[test]
fn matlab_files_in_hdf5() {
    assert_arrays(
        &mat::read(&fixture("v73.mat")).unwrap(),
        &[
            ("K", stiffness()),
            ("Z", Array::Sparse(CsMat::zero((2, 4)))),
            ("M", matrix()),
            ("dofs", integers(3, 2, &[11, 1, 12, 3, -1, 1])),
            ("single", dense(1, 2, &[0.5, -2.0])),
            ("fixed", integers(1, 2, &[1, 0])),
            ("note", text("joint µ")),
            ("lines", text("top\nbottom")),
            ("model.K", dense(2, 2, &[1.0, 0.0, 0.0, 1.0])),
            ("model.info.units", text("SI")),
            ("empty", dense(0, 3, &[])),
        ],
        &["parts", "response", "waves"],
    );
    let stored = mat::read(&fixture("storage.mat")).unwrap();
    assert_eq!(stored.arrays["M"], matrix());
    assert_eq!(stored.arrays["note"], text("joint"));
    let cut = mat::parse(file_io::Source {
        name: "cut.mat",
        bytes: &std::fs::read(fixture("storage.mat")).unwrap()[..3430],
    });
    assert!(cut.unwrap_err().to_string().contains("as many bytes as it states"));
    // Rows that do not ascend in a column.
    let bytes = std::fs::read(fixture("v73.mat")).unwrap();
    let rows: Vec<u8> = [0_u64, 1, 0, 1, 2, 1, 2]
        .iter()
        .flat_map(|row| row.to_le_bytes())
        .collect();
    let at = bytes.windows(rows.len()).position(|found| found == rows).unwrap();
    let mut damaged = bytes.clone();
    damaged[at] = 1;
    let refused = mat::parse(file_io::Source {
        name: "damaged.mat",
        bytes: &damaged,
    });
    let refused = refused.unwrap_err().to_string();
    assert!(
        refused.contains("the variable `K`") && refused.contains("do not fit"),
        "{refused}"
    );
}

#[test]
fn numpy_archives() {
    for name in ["plain.npz", "compressed.npz"] {
        assert_arrays(
            &npz::read(&fixture(name)).unwrap(),
            &[
                ("M", matrix()),
                ("M_by_columns", matrix()),
                ("single", dense(2, 1, &[0.5, -2.0])),
                ("big_endian", dense(2, 1, &[1.5, -2.5])),
                ("dofs", integers(3, 2, &[11, 1, 12, 3, -1, 1])),
                ("counts", integers(2, 1, &[1, 200])),
                ("fixed", integers(2, 1, &[1, 0])),
                ("mu", dense(1, 1, &[0.2])),
                ("note", text("joint µ")),
                ("lines", text("top\nbottom")),
                ("empty", dense(0, 3, &[])),
            ],
            &["parts", "record", "response", "waves"],
        );
    }
}

#[test]
fn sparse_archives_of_scipy() {
    let alone = |array| [(npz::MATRIX, array)];
    assert_arrays(&npz::read(&fixture("csc.npz")).unwrap(), &alone(stiffness()), &[]);
    // Columns out of order; 0.25 and 0.5 stand at the same place.
    let summed = CsMat::new((2, 3), vec![0, 2, 3], vec![0, 2, 1], vec![1.0, 3.0, 0.75]);
    assert_arrays(
        &npz::read(&fixture("csr.npz")).unwrap(),
        &alone(Array::Sparse(summed)),
        &[],
    );
    let refused = npz::read(&fixture("coo.npz")).unwrap_err();
    assert!(matches!(refused, Error::Unsupported { .. }), "{refused}");
    assert!(refused.to_string().contains(".tocsr()"), "{refused}");
}

#[test]
fn matrix_market_files_of_scipy() {
    assert_eq!(matrix_market::read(&fixture("symmetric.mtx")).unwrap(), stiffness());
    assert_eq!(matrix_market::read(&fixture("array.mtx")).unwrap(), matrix());
    assert_eq!(
        matrix_market::read(&fixture("integer.mtx")).unwrap(),
        integers(2, 2, &[1, 2, 2, -5])
    );
}

#[test]
fn matrices_of_calculix() {
    let model = calculix::read(&fixture("two_hexes.sti")).unwrap();
    let (nodes, components) = ([11, 12, 13, 14, 21, 22, 23, 24], [1, 2, 3]);
    let expected: Vec<Dof> = nodes
        .iter()
        .flat_map(|&node| components.map(|component| Dof::Nodal { node, component }))
        .collect();
    assert_eq!(model.dofs, expected);
    let (stiffness, mass) = (&model.matrices[Assembled::STIFFNESS], &model.matrices[Assembled::MASS]);
    for m in [stiffness, mass] {
        assert_eq!((m.shape(), m.nnz(), m.is_csr()), ((24, 24), 24 * 24, true));
        assert!(m.iter().all(|(value, (i, j))| m.get(j, i) == Some(value)));
    }

    // Consistent mass of two bar elements without the clamped end: rho A l [4 1; 1 2] / 6.
    let along: f64 = mass
        .iter()
        .filter(|(_, (i, j))| i % 3 == 0 && j % 3 == 0)
        .map(|(m, _)| m)
        .sum();
    assert!(
        (along / (7800.0 * 1e-4 * 0.01 * (4.0 + 1.0 + 1.0 + 2.0) / 6.0) - 1.0).abs() < 1e-12,
        "{along}"
    );
    assert!(mass.iter().all(|(m, (i, j))| i % 3 == j % 3 || *m == 0.0));

    // Displacements (m) that the same program prints for 100 N in x at each node of the free end.
    let (middle, end) = ([1.783246e-7, 3.471204e-8], [3.811518e-7, 2.858639e-8]);
    let signs = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    let at = |u: [f64; 2]| signs.iter().flat_map(move |s| [u[0], s[0] * u[1], s[1] * u[1]]);
    let u: Vec<f64> = at(middle).chain(at(end)).collect();
    for (dof, row) in stiffness.outer_iterator().enumerate() {
        let force: f64 = row.iter().map(|(j, k)| k * u[j]).sum();
        let applied = if dof >= 12 && dof % 3 == 0 { 100.0 } else { 0.0 };
        assert!(
            (force - applied).abs() < 1e-4,
            "component {dof}: {force} N, not {applied} N"
        );
    }
}

#[test]
fn substructure_file_of_calculix() {
    let found = abaqus::read_substructure(&fixture("two_hexes.mtx")).unwrap();
    let dof = |node, component| Dof::Nodal { node, component };
    let retained = [
        (1, 1),
        (1, 2),
        (1, 3),
        (3, 1),
        (3, 2),
        (21, 1),
        (21, 2),
        (21, 3),
        (23, 1),
    ];
    assert_eq!(found.dofs, retained.map(|(node, component)| dof(node, component)));
    assert!(found.matrices.keys().eq(["STIFFNESS"]) && found.loads.is_empty() && found.recovery.is_none());
    assert_eq!(found.skipped, []);
    let k = &found.matrices["STIFFNESS"];
    assert_eq!((k.rows(), k.columns()), (9, 9));
    for (i, j, value) in [
        (0, 0, 0.4700854700855e9),
        (4, 1, -0.1709401709402e9),
        (8, 7, -0.1602564102564e8),
        (8, 0, 0.0),
    ] {
        assert_eq!((k[(i, j)], k[(j, i)]), (value, value));
    }
}

#[test]
fn other_versions_are_refused_with_the_way_out() {
    let level4 = std::fs::read(fixture("level4.mat")).unwrap();
    let refused = mat::parse(Source {
        name: "model.mat",
        bytes: &level4,
    })
    .unwrap_err();
    assert!(matches!(refused, Error::Unsupported { .. }), "{refused}");
    let message = refused.to_string();
    assert!(
        message.contains("level 4") && message.contains("'-v7'") && message.contains("model.mat"),
        "{message}"
    );
}

/// The example that the README shows is the one that is compiled.
#[test]
fn readme_shows_the_example() {
    let example = include_str!("../../examples/convert.rs");
    let code = example.split_once("\nuse std").unwrap().1;
    assert!(include_str!("../../README.md").contains(code));
}

#[test]
fn the_file_that_is_missing_is_named() {
    let folder = TemporaryFolder::new("matrix-files");
    for name in ["two_hexes.sti", "two_hexes.mas"] {
        std::fs::copy(fixture(name), folder.join(name)).unwrap();
    }
    let refused = calculix::read(&folder.join("two_hexes")).unwrap_err();
    assert!(matches!(refused, Error::NoDofMap { .. }), "{refused}");
    assert!(refused.to_string().contains("two_hexes.dof"), "{refused}");
    assert!(matches!(
        mat::read(&fixture("none.mat")),
        Err(Error::File(file_io::input::Error::Unreadable { .. }))
    ));
}

#[test]
fn matrices_of_ansys() {
    let found = ansys::read(&fixture("small.full")).unwrap();
    // The y of node 3 is held.
    let dofs = [(7, 1), (7, 2), (7, 3), (3, 1), (5, 3)].map(|(node, component)| Dof::new(node, component));
    assert_eq!(found.dofs, dofs);
    let entries = |name: &str| -> Vec<(usize, usize, f64)> {
        let matrix = &found.matrices[name];
        assert_eq!(matrix.shape(), (5, 5));
        matrix
            .iter()
            .map(|(v, (i, j))| (i, j, *v))
            .filter(|(.., v)| *v != 0.0)
            .collect()
    };
    let stiffness = [
        (0, 0, 4.0),
        (0, 1, -1.5),
        (0, 4, 0.25),
        (1, 0, -1.5),
        (1, 1, 3.0),
        (1, 2, 1e-3),
        (2, 1, 1e-3),
        (2, 2, 2.5e9),
        (2, 3, 7.0),
        (3, 2, 7.0),
        (3, 3, 9.0),
        (3, 4, -1.0),
        (4, 0, 0.25),
        (4, 3, -1.0),
        (4, 4, 5.0),
    ];
    assert_eq!(entries(Assembled::STIFFNESS), stiffness);
    let mass = [1.0, 2.0, 3.0, 4.0, 1.0 / 3.0];
    assert_eq!(
        entries(Assembled::MASS),
        mass.iter().enumerate().map(|(i, m)| (i, i, *m)).collect::<Vec<_>>()
    );
    assert_eq!(entries(Assembled::DAMPING), [(0, 0, 0.1), (3, 3, 0.2)]);
}
