//! What the writers write comes back from the readers.

#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};

use file_io::Source;
use matrix_files::abaqus::{self, Recovery, Substructure};
use matrix_files::value::{Array, Dense, Dof};
use matrix_files::{Error, mat, matrix_market, npz};
use proptest::prelude::*;
use sprs::CsMat;

fn source(bytes: &[u8]) -> Source<'_> {
    Source { name: "written", bytes }
}

/// Finite numbers of all sizes, both zeros among them.
fn number() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![
        3 => proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO,
        1 => (-100..100_i32).prop_map(f64::from),
    ]
}

fn dense<T: std::fmt::Debug>(entry: impl Strategy<Value = T> + Clone) -> impl Strategy<Value = Dense<T>> {
    (0..6_usize, 0..6_usize).prop_flat_map(move |(rows, columns)| {
        proptest::collection::vec(entry.clone(), rows * columns)
            .prop_map(move |data| Dense::try_new(rows, columns, data).unwrap())
    })
}

fn sparse() -> impl Strategy<Value = CsMat<f64>> {
    (1..7_usize, 1..7_usize, any::<bool>()).prop_flat_map(|(rows, columns, symmetric)| {
        proptest::collection::btree_map((0..rows, 0..columns), number(), 0..20).prop_map(move |mut entries| {
            let mut columns = columns;
            if symmetric {
                columns = rows;
                entries = entries
                    .into_iter()
                    .filter(|((i, j), _)| *j <= *i)
                    .flat_map(|((i, j), v)| [((i, j), v), ((j, i), v)])
                    .collect();
            }
            let mut starts = vec![0; rows + 1];
            entries.keys().for_each(|(i, _)| starts[i + 1] += 1);
            (0..rows).for_each(|i| starts[i + 1] += starts[i]);
            let indices = entries.keys().map(|(_, j)| *j).collect();
            CsMat::new((rows, columns), starts, indices, entries.into_values().collect())
        })
    })
}

fn array() -> impl Strategy<Value = Array> {
    prop_oneof![
        dense(number()).prop_map(Array::Dense),
        sparse().prop_map(Array::Sparse),
        dense(any::<i64>()).prop_map(Array::Integers),
        "[^\0]{0,8}".prop_map(Array::Text),
    ]
}

fn arrays() -> impl Strategy<Value = BTreeMap<String, Array>> {
    proptest::collection::btree_map("[A-Za-z][A-Za-z0-9_]{0,8}", array(), 0..5)
}

/// Equal to the last bit, so that the sign of zero counts.
fn same_bits(a: &Array, b: &Array) -> bool {
    let bits = |array: &Array| match array {
        Array::Dense(m) => m.data().iter().map(|v| v.to_bits()).collect(),
        Array::Sparse(m) => m.data().iter().map(|v| v.to_bits()).collect(),
        _ => Vec::new(),
    };
    a == b && bits(a) == bits(b)
}

fn substructure() -> impl Strategy<Value = Substructure> {
    let nodes = proptest::collection::btree_map(-9..30_i64, proptest::collection::btree_set(1..7_u32, 1..4), 1..5);
    nodes.prop_flat_map(|nodes: BTreeMap<i64, BTreeSet<u32>>| {
        let dofs: Vec<Dof> = nodes
            .iter()
            .flat_map(|(label, set)| set.iter().map(|c| Dof::new(*label, *c)))
            .collect();
        let n = dofs.len();
        let symmetric = proptest::collection::vec(number(), n * n).prop_map(move |mut v| {
            (0..n).for_each(|j| (0..j).for_each(|i| v[i + j * n] = v[j + i * n]));
            Dense::try_new(n, n, v).unwrap()
        });
        let recovery = (1..4_usize).prop_flat_map(move |rows| {
            let matrix =
                proptest::collection::vec(number(), rows * n).prop_map(move |v| Dense::try_new(rows, n, v).unwrap());
            let heading = proptest::collection::vec("\\*\\* [0-9, ]{0,9}NODES", 0..3);
            (matrix, heading).prop_map(|(matrix, heading)| Recovery { matrix, heading })
        });
        (
            proptest::collection::btree_map("STIFFNESS|MASS|VISCOUS DAMPING", symmetric, 1..3),
            proptest::collection::btree_map("[A-Z][A-Z0-9_-]{0,7}", proptest::collection::vec(number(), n), 0..2),
            proptest::option::of(recovery),
        )
            .prop_map(move |(matrices, loads, recovery)| Substructure {
                dofs: dofs.clone(),
                matrices,
                loads,
                recovery,
                skipped: Vec::new(),
            })
    })
}

proptest! {
    #[test]
    fn matrix_market(array in array()) {
        match matrix_market::to_bytes(&array) {
            Ok(bytes) => {
                let back = matrix_market::parse(source(&bytes)).unwrap();
                prop_assert!(same_bits(&back, &array), "{}", String::from_utf8_lossy(&bytes));
            }
            Err(error) => prop_assert!(matches!(array, Array::Text(_)), "{error}"),
        }
    }

    #[test]
    fn matlab(arrays in arrays()) {
        let back = mat::parse(source(&mat::to_bytes(&arrays).unwrap())).unwrap();
        prop_assert_eq!(&back.arrays, &arrays);
        prop_assert!(back.skipped.is_empty() && back.arrays.iter().all(|(name, a)| same_bits(a, &arrays[name])));
    }

    #[test]
    fn numpy(arrays in arrays(), alone in sparse()) {
        let back = npz::parse(source(&npz::to_bytes(&arrays).unwrap())).unwrap();
        prop_assert_eq!(&back.arrays, &arrays);
        prop_assert!(back.skipped.is_empty() && back.arrays.iter().all(|(name, a)| same_bits(a, &arrays[name])));
        let alone = BTreeMap::from([(npz::MATRIX.to_owned(), Array::Sparse(alone))]);
        prop_assert_eq!(npz::parse(source(&npz::to_bytes(&alone).unwrap())).unwrap().arrays, alone);
    }

    #[test]
    fn substructures(model in substructure()) {
        let bytes = abaqus::substructure_to_bytes(&model).unwrap();
        prop_assert_eq!(abaqus::parse_substructure(source(&bytes)).unwrap(), model);
    }

    #[test]
    fn dof_tables(labels in proptest::collection::vec((any::<i64>(), any::<u32>()), 0..9)) {
        let dofs: Vec<Dof> = labels.iter().map(|(label, component)| Dof::new(*label, *component)).collect();
        let Array::Integers(table) = Dof::table(&dofs) else { panic!("a table of integers") };
        prop_assert_eq!((table.rows(), table.columns()), (dofs.len(), 2));
        prop_assert_eq!(Dof::from_table(&table), Some(dofs));
    }
}

#[test]
fn what_cannot_be_written_is_refused() {
    let one = |name: &str, array: Array| BTreeMap::from([(name.to_owned(), array)]);
    let number = |value| Array::Dense(Dense::try_new(1, 1, vec![value]).unwrap());
    let refused = |result: Result<Vec<u8>, Error>, expected: &str| {
        let error = result.unwrap_err();
        assert!(
            matches!(error, Error::Unwritable { .. }) && error.to_string().contains(expected),
            "{error}"
        );
    };
    for value in [f64::NAN, f64::INFINITY] {
        refused(mat::to_bytes(&one("K", number(value))), "finite");
        refused(npz::to_bytes(&one("K", number(value))), "finite");
        refused(matrix_market::to_bytes(&number(value)), "finite");
    }
    for name in ["", "1K", "a.b", "K µ", &"K".repeat(64)] {
        refused(mat::to_bytes(&one(name, number(1.0))), "begin with a letter");
    }
    for name in ["", "../K", "a\nb"] {
        refused(npz::to_bytes(&one(name, number(1.0))), "no name of a file");
    }
    refused(npz::to_bytes(&one("note", Array::Text("a\0".into()))), "zeros");
    refused(matrix_market::to_bytes(&Array::Text("a".into())), "text");
    let mut clash = one("K", Array::Sparse(CsMat::zero((1, 1))));
    clash.insert("K.data".into(), number(1.0));
    refused(npz::to_bytes(&clash), "rename");

    let dofs = vec![Dof::new(7, 1), Dof::new(7, 2)];
    let model = |kind: &str, data: [f64; 4]| Substructure {
        dofs: dofs.clone(),
        matrices: BTreeMap::from([(kind.into(), Dense::try_new(2, 2, data.to_vec()).unwrap())]),
        ..Substructure::default()
    };
    refused(
        abaqus::substructure_to_bytes(&model("MASS", [1.0, 2.0, 3.0, 4.0])),
        "not symmetric",
    );
    refused(
        abaqus::substructure_to_bytes(&model("MASS", [1.0, 2.0, 2.0, f64::NAN])),
        "finite",
    );
    refused(
        abaqus::substructure_to_bytes(&model("mass", [1.0, 2.0, 2.0, 4.0])),
        "capitals",
    );
    let mut twice = model("MASS", [1.0, 2.0, 2.0, 4.0]);
    twice.dofs[1] = twice.dofs[0];
    refused(abaqus::substructure_to_bytes(&twice), "twice");
    let mut short = model("MASS", [1.0, 2.0, 2.0, 4.0]);
    short.loads.insert("BOLT".into(), vec![1.0]);
    refused(abaqus::substructure_to_bytes(&short), "1 rows");
    assert!(matches!(
        Dense::try_new(2, 2, vec![0.0; 3]),
        Err(Error::Shape { entries: 3, .. })
    ));
}
