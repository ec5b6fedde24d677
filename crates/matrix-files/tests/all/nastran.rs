//! Files of Nastran's formats: those of other programs, what comes back, and what is refused.
//!
//! `make_nastran.py` made those that are read, with pyYeti 1.4.7 and pyNastran 1.4.1, and checks that these read
//! `written.op4` and `written.pch`. `MATRIX_FILES_WRITE=1` writes these two anew.

#![allow(clippy::unwrap_used)]

use crate::refusals::{refused, source};
use std::collections::BTreeMap;
use std::path::PathBuf;

use matrix_files::dmig::{self, PointMatrices};
use matrix_files::value::{Array, Dense, Dof};
use matrix_files::{Error, op2, op4};
use proptest::prelude::*;
use sprs::CsMat;

pub(crate) fn fixture(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests", "fixtures", name].iter().collect()
}

/// Rows and columns, and the entries that are not zero by rows.
type Entries = ((usize, usize), Vec<(usize, usize, f64)>);

fn entries(array: &Array) -> Entries {
    match array {
        Array::Dense(m) => {
            let places = (0..m.rows()).flat_map(|i| (0..m.columns()).map(move |j| (i, j)));
            let entries = places.map(|at| (at.0, at.1, m[at])).filter(|(.., v)| *v != 0.0);
            ((m.rows(), m.columns()), entries.collect())
        }
        Array::Sparse(m) => (m.shape(), m.iter().map(|(v, (i, j))| (i, j, *v)).collect()),
        other => panic!("{other:?}"),
    }
}

fn sparse(shape: (usize, usize), entries: &[(usize, usize, f64)]) -> CsMat<f64> {
    let mut triplets = sprs::TriMat::new(shape);
    entries.iter().for_each(|&(i, j, v)| triplets.add_triplet(i, j, v));
    triplets.to_csr()
}

const K: [(usize, usize, f64); 7] = [
    (0, 0, 4.0),
    (0, 1, -1.5),
    (1, 0, -1.5),
    (1, 1, 3.0),
    (1, 2, 1e-3),
    (2, 1, 1e-3),
    (2, 2, 2.5e9),
];
const M: [(usize, usize, f64); 6] = [
    (0, 0, 1.0),
    (0, 1, 2.0),
    (0, 2, 3.0),
    (1, 0, 0.5),
    (1, 1, -6.25),
    (1, 2, 1e-300),
];
const S: [(usize, usize, f64); 4] = [(1, 1, 1.0 / 3.0), (2, 1, -2.0), (5, 1, 0.1), (6, 3, 7.0)];

#[test]
fn output4_of_other_programs() {
    for (name, is_sparse, all) in [
        ("dense.op4", false, true),
        ("dense9.op4", false, true),
        ("dense_le.op4", false, true),
        ("dense_be.op4", false, true),
        ("bigmat.op4", true, true),
        ("strings.op4", true, true),
        ("bigmat_be.op4", true, true),
        ("strings_le.op4", true, true),
        ("pynastran.op4", false, false),
    ] {
        let found = op4::read(&fixture(name)).unwrap();
        let names: Vec<&str> = found.arrays.keys().map(String::as_str).collect();
        assert_eq!(
            names,
            if all {
                vec!["K", "M", "S", "ZERO"]
            } else {
                vec!["K", "M"]
            },
            "{name}"
        );
        assert!(found.skipped.is_empty());
        for (array, expected) in [("K", ((3, 3), K.to_vec())), ("M", ((2, 3), M.to_vec()))] {
            let array = &found.arrays[array];
            assert_eq!(entries(array), expected, "{name}");
            assert_eq!(matches!(array, Array::Sparse(_)), is_sparse, "{name}");
        }
        if all {
            let mut expected = S.to_vec();
            if name == "dense9.op4" {
                expected[0].2 = 0.333_333_333_3;
            }
            assert_eq!(entries(&found.arrays["S"]), ((7, 4), expected), "{name}");
            assert_eq!(entries(&found.arrays["ZERO"]), ((2, 3), Vec::new()), "{name}");
        }
    }
    let wide = op4::read(&fixture("wide_le.op4")).unwrap().arrays;
    let single = op4::read(&fixture("single_be.op4")).unwrap().arrays;
    let narrow = |(i, j, v): (usize, usize, f64)| (i, j, f64::from(v as f32));
    assert_eq!(entries(&wide["M"]), ((2, 3), M.to_vec()));
    assert_eq!(entries(&wide["S"]), ((7, 4), S.to_vec()));
    let nonzero = |list: &[(usize, usize, f64)]| list.iter().copied().map(narrow).filter(|e| e.2 != 0.0).collect();
    assert_eq!(entries(&single["M"]), ((2, 3), nonzero(&M)));
    assert_eq!(entries(&single["S"]), ((7, 4), nonzero(&S)));
    let complex = op4::read(&fixture("complex.op4")).unwrap_err();
    assert!(
        matches!(&complex, Error::Unsupported { found, .. } if found.contains("complex matrix `C`")),
        "{complex}"
    );
}

fn nodal(list: &[(u64, u32)]) -> Vec<Dof> {
    let dof = |&(node, component): &(u64, u32)| Dof::Nodal { node, component };
    list.iter().map(dof).collect()
}

#[test]
fn output2_as_pyyeti_reads_it() {
    for name in ["blocks_le.op2", "blocks_be.op2", "blocks_wide.op2"] {
        let op2::Contents { arrays, points } = op2::read(&fixture(name)).unwrap();
        assert_eq!(points, PointMatrices::default());
        let stored = |list: &[(usize, usize, f64)]| -> Vec<(usize, usize, f64)> {
            let narrow = |(i, j, v): &(usize, usize, f64)| match name {
                "blocks_be.op2" => (*i, *j, f64::from(*v as f32)),
                _ => (*i, *j, *v),
            };
            list.iter().map(narrow).filter(|entry| entry.2 != 0.0).collect()
        };
        assert!(
            arrays.arrays.keys().eq(["K", "M", "S"]),
            "{name}: {:?}",
            arrays.arrays.keys()
        );
        for (array, shape, expected, is_sparse) in [
            ("K", (3, 3), &K[..], true),
            ("M", (2, 3), &M, false),
            ("S", (7, 4), &S, true),
        ] {
            let array = &arrays.arrays[array];
            let of = entries(array);
            assert_eq!((of.0, stored(&of.1)), (shape, stored(expected)), "{name}");
            assert_eq!(matches!(array, Array::Sparse(_)), is_sparse, "{name}");
        }
        let skipped: Vec<_> = arrays
            .skipped
            .iter()
            .map(|s| format!("{}: {}", s.name, s.reason))
            .collect();
        assert_eq!(
            skipped,
            [
                "CASECC: a table",
                "C: a complex matrix",
                "GIVEN: several blocks have this name"
            ]
        );
    }

    let m = |m: &CsMat<f64>| entries(&Array::Sparse(m.clone()));
    let upper = K.iter().filter(|(i, j, _)| i <= j);
    let upper: Vec<_> = upper
        .map(|&(i, j, v)| (i, j, if i == j { v + 1.0 } else { v }))
        .collect();
    let found = op2::read(&fixture("tables.op2")).unwrap();
    assert_eq!(found.arrays, matrix_files::value::Collection::default());
    assert_eq!(found.points.dofs, nodal(&[(11, 1), (12, 3), (101, 0)]));
    assert!(found.points.matrices.keys().eq(["B", "KAAX"]) && found.points.numbered.keys().eq(["FV"]));
    let square = |name: &str| m(&found.points.matrices[name]);
    let nonzero = |(shape, list): Entries| {
        (
            shape,
            list.into_iter().filter(|entry| entry.2 != 0.0).collect::<Vec<_>>(),
        )
    };
    assert_eq!(square("KAAX"), ((3, 3), K.to_vec()));
    assert_eq!(nonzero(square("B")), ((3, 3), upper.clone()));
    let turned: Vec<_> = (0..3)
        .flat_map(|i| (0..2).map(move |j| (i, j, M[3 * j + i].2)))
        .collect();
    assert_eq!(m(&found.points.numbered["FV"]), ((3, 2), turned));

    let external = op2::read(&fixture("external.op2")).unwrap();
    assert!(external.points.matrices.keys().eq(["MATK", "MATM"]));
    assert_eq!(m(&external.points.matrices["MATK"]), ((3, 3), K.to_vec()));
    assert_eq!(nonzero(m(&external.points.matrices["MATM"])), ((3, 3), upper));
    let skipped: Vec<&str> = external.arrays.skipped.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(skipped, ["XSOP2DIR", "GEOM1EX"]);
}

#[test]
fn output2_refusals() {
    let refused = |result: Result<op2::Contents, Error>, expected: &str| refused(result.map(|_| ()), expected);
    refused(
        op2::parse(source(b"")),
        "byte 0: a file that begins with no key of `OUTPUT2` is not supported",
    );
    let read = |name: &str| std::fs::read(fixture(name)).unwrap();
    // In words of four bytes: a key takes three.
    let altered = |name: &str, word: usize, to: i32| {
        let mut bytes = read(name);
        bytes[4 * word..4 * word + 4].copy_from_slice(&to.to_le_bytes());
        bytes
    };
    let words: Vec<i32> = read("blocks_le.op2")
        .chunks(4)
        .map(|w| i32::from_le_bytes(w.try_into().unwrap()))
        .collect();
    let table: Vec<i32> = read("tables.op2")
        .chunks(4)
        .map(|w| i32::from_le_bytes(w.try_into().unwrap()))
        .collect();
    // The first column of K: its row, one, and two entries.
    let column = words.windows(3).position(|w| w == [20, 1, 0]).unwrap();
    let of = |name: &str, list: &[i32]| {
        let all = if name == "tables.op2" { &table } else { &words };
        all.windows(list.len()).position(|w| w == list).unwrap()
    };
    let description = of("blocks_le.op2", &[28, 101, 3, 3, 6, 2]);
    let header = of("tables.op2", &[0, 6, 2, 2, 0, 0, 3]);
    for (bytes, expected) in [
        (
            altered("blocks_le.op2", column + 1, 0),
            "found row 0 of column 1, expected rows that ascend",
        ),
        (altered("blocks_le.op2", column + 1, 3), "the row 4 is outside 1 to 3"),
        (altered("blocks_le.op2", column + 1, -1), "found -1, expected a row"),
        (altered("blocks_le.op2", column, 16), "the same length at both ends"),
        (
            altered("blocks_le.op2", description + 2, 2),
            "the column 3 is outside 1 to 2",
        ),
        (
            altered("blocks_le.op2", description + 3, 1 << 30),
            "the number of rows or columns is stated as 1073741824",
        ),
        (
            altered("blocks_le.op2", description - 5, -7),
            "found the key -7, expected -1",
        ),
        (
            read("blocks_le.op2")[..600].to_vec(),
            "byte 596: the number of bytes of a record",
        ),
        (altered("tables.op2", header + 7, 0), "found point 0, component 1"),
        (altered("tables.op2", header + 8, 7), "found point 11, component 7"),
        (altered("tables.op2", header + 17, 5), "found point 5, component -1"),
    ] {
        refused(op2::parse(source(&bytes)), expected);
    }
    // What is of another kind is passed over.
    for (at, to, expected) in [
        (1, 3, "the form 3"),
        (2, 4, "the complex matrix"),
        (4, 1, "the complex matrix"),
    ] {
        let found = op2::parse(source(&altered("tables.op2", header + at, to))).unwrap();
        assert!(found.points.matrices.keys().eq(["B"]));
        assert!(
            found.arrays.skipped[0].reason.contains(expected),
            "{:?}",
            found.arrays.skipped
        );
    }
}

#[test]
fn entries_dmig_of_other_programs() {
    let found = dmig::read(&fixture("pyyeti.pch")).unwrap();
    assert_eq!(found.dofs, nodal(&[(11, 1), (12, 3), (101, 0)]));
    assert!(found.matrices.keys().eq(["B", "KAAX"]) && found.numbered.keys().eq(["FV"]));
    let m = |m: &CsMat<f64>| entries(&Array::Sparse(m.clone()));
    assert_eq!(m(&found.matrices["KAAX"]), ((3, 3), K.to_vec()));
    let upper = K.iter().filter(|(i, j, _)| i <= j);
    let upper = upper.map(|&(i, j, v)| (i, j, if i == j { v + 1.0 } else { v }));
    assert_eq!(m(&found.matrices["B"]), ((3, 3), upper.collect()));
    let mut transposed: Vec<_> = M.iter().map(|&(i, j, v)| (j, i, v)).collect();
    transposed.sort_by_key(|e| (e.0, e.1));
    assert_eq!(m(&found.numbered["FV"]), ((3, 2), transposed));
    assert!(found.skipped.is_empty());

    let found = dmig::read(&fixture("pynastran.bdf")).unwrap();
    assert_eq!(found.dofs, nodal(&[(11, 3), (12, 3), (13, 3)]));
    assert_eq!(m(&found.matrices["KS"]), ((3, 3), K.to_vec()));
    assert_eq!(m(&found.matrices["KD"]), ((3, 3), K.to_vec()));
    let skipped: Vec<_> = found
        .skipped
        .iter()
        .map(|s| (s.name.as_str(), s.reason.as_str()))
        .collect();
    assert_eq!(skipped, [("GRID", "3 entries that are no DMIG")]);
}

/// What `make_nastran.py` reads with the other programs.
#[test]
fn files_for_other_programs_are_those_that_were_checked() {
    let dofs = nodal(&[(11, 1), (12, 3), (101, 0)]);
    let dense = [1.0, 0.5, 2.0, -6.25, 3.0, 1e-300];
    let arrays = [
        ("K", Array::Sparse(sparse((3, 3), &K))),
        ("M", Array::Dense(Dense::try_new(2, 3, dense.to_vec()).unwrap())),
        ("S", Array::Sparse(sparse((7, 4), &S))),
        ("DOFS", Dof::table(&dofs)),
    ];
    let arrays: BTreeMap<String, Array> = arrays.map(|(name, array)| (name.to_owned(), array)).into();
    let third: Vec<_> = K
        .iter()
        .filter(|(i, j, _)| i <= j)
        .map(|&(i, j, v)| (i, j, v / 3.0))
        .collect();
    let across: Vec<_> = M.iter().map(|&(i, j, v)| (j, i, v)).collect();
    let points = PointMatrices {
        dofs,
        matrices: [("K", sparse((3, 3), &K)), ("B", sparse((3, 3), &third))]
            .map(|(name, m)| (name.to_owned(), m))
            .into(),
        numbered: [("FV".to_owned(), sparse((3, 2), &across))].into(),
        skipped: Vec::new(),
    };
    for (name, bytes) in [
        ("written.op4", op4::to_bytes(&arrays).unwrap()),
        ("written.pch", dmig::to_bytes(&points, "units: N, m").unwrap()),
    ] {
        if std::env::var_os("MATRIX_FILES_WRITE").is_some() {
            std::fs::write(fixture(name), &bytes).unwrap();
        }
        assert!(std::fs::read(fixture(name)).unwrap() == bytes, "{name}");
    }
}

#[test]
fn forms_of_output4() {
    // Columns, rows, form; a column of two entries; the end.
    let text = |head: &str, body: &str, columns: usize| {
        format!(
            "{head}       2A       1P,2E12.5\n{body}{:8}       1       1\n 1.00000E+00\n",
            columns + 1
        )
    };
    let parse = |text: &str| op4::parse(source(text.as_bytes())).map(|found| entries(&found.arrays["A"]));
    const COLUMN: &str = "       1       1       2\n 2.00000E+00-3.00000D+00\n";
    const LOWER: &str = "       1       2       1\n 2.00000E+00\n";
    let vector = text("       1       2       3", COLUMN, 1);
    assert_eq!(parse(&vector).unwrap(), ((2, 2), vec![(0, 0, 2.0), (1, 1, -3.0)]));
    let row = "       1       1       1\n 2.0\n       2       1       1\n -3.0\n";
    let row = text("       2       1       3", row, 2);
    assert_eq!(parse(&row).unwrap(), ((2, 2), vec![(0, 0, 2.0), (1, 1, -3.0)]));
    let identity = text("       2       2       8", "", 2);
    assert_eq!(parse(&identity).unwrap(), ((2, 2), vec![(0, 0, 1.0), (1, 1, 1.0)]));
    let square = text("       2       2       1", LOWER, 2);
    assert_eq!(parse(&square).unwrap(), ((2, 2), vec![(1, 0, 2.0)]));
    // Long counts, and no format, which is 5E16.9.
    let long = format!(
        "{:16}{:16}{:8}{:8}{:8}|I16\n{:8}{:8}{:8}\n{:>16}\n{:8}{:8}{:8}\n{:16}\n",
        1, 2, 2, 1, "A", 1, 2, 1, "2.5E+00", 2, 1, 1, 0
    );
    assert_eq!(parse(&long).unwrap(), ((2, 1), vec![(1, 0, 2.5)]));
    // Fields that touch, and a dense matrix of which so much is left out that it is sparse.
    let long = "       1-1000000       2       1A       1P,2E12.5\n       1       0       3\n       21000000\n 5.0\n       2       1       1\n 1.0\n";
    assert_eq!(parse(long).unwrap(), ((1_000_000, 1), vec![(999_999, 0, 5.0)]));
    let few = text("   50000   50000       2", LOWER, 50_000);
    assert_eq!(parse(&few).unwrap(), ((50_000, 50_000), vec![(1, 0, 2.0)]));

    for (text, expected) in [
        (
            text("       2       2       3", LOWER, 2),
            "line 1: found 2 rows and 2 columns of form 3, expected entries on the diagonal",
        ),
        (
            text("       2       2       6", LOWER, 2),
            "line 1: the symmetric matrix `A` with entries on one side",
        ),
        (
            text("       1       2       6", LOWER, 1),
            "expected as many rows as columns",
        ),
        (
            text("       2       2      13", LOWER, 2),
            "the form 13 of the matrix `A` is not supported",
        ),
    ] {
        refused(parse(&text), expected);
    }
}

#[test]
fn output4_refusals() {
    const HEAD: &str = "       2       3       2       2A       1P,2E12.5\n";
    const END: &str = "       3       1       1\n 1.00000E+00\n";
    const ONE: &str = "       1       2       1\n 2.00000E+00\n";
    let head = |old: &str, new: &str| HEAD.replacen(old, new, 1) + ONE + END;
    for (text, expected) in [
        (String::new(), "line 1: found the end of the file, expected a matrix"),
        ("K\n".into(), "line 1: found `K`, expected columns, rows"),
        (
            head("1P,2E12.5", "1P,2I12"),
            "expected columns, rows, form, type, name and a format",
        ),
        (head("1P,2E12.5", "1P,2E2.0"), "and a format such as"),
        (
            head("2A", "4A"),
            "line 1: the complex matrix `A` is not supported; write its real part",
        ),
        (head("2A", "5A"), "columns of type 5"),
        (head("2A ", "2  "), "the name ``"),
        (
            head("       2", "20000000"),
            "line 1: the number of rows or columns is stated as 20000000",
        ),
        (
            HEAD.to_owned() + ONE,
            "line 3: found the end of the file, expected column, row",
        ),
        (
            HEAD.to_owned() + ONE + ONE + END,
            "line 4: found column 1, expected columns that ascend, each once, here 2",
        ),
        (
            HEAD.to_owned() + "       4       1       1\n 1.0\n",
            "line 2: the column 4 is outside 1 to 3",
        ),
        (
            HEAD.to_owned() + "       1       3       2\n",
            "line 2: the row 4 is outside 1 to 3",
        ),
        (
            HEAD.to_owned() + "       1       1       2\n 1.00000E+00\n",
            "line 3: found ` 1.00000E+00`, expected 2 numbers of 12",
        ),
        (
            HEAD.to_owned() + "       1       1       1\n NaN\n",
            "line 3: the entry NaN is not a finite number",
        ),
        (
            HEAD.to_owned() + "       1       1       1\n 1E+999\n",
            "line 3: the entry inf",
        ),
        (
            HEAD.to_owned() + "       1       1       1\n 1..0\n",
            "line 3: found `1..0`, expected a number",
        ),
    ] {
        refused(op4::parse(source(text.as_bytes())), expected);
    }
    let strings = |words: usize, body: &str| format!("{HEAD}       1       0{words:8}\n{body}");
    let string = |words: usize, row: usize| format!("{:11}\n 1.00000E+00\n", (words << 16) + row);
    for (text, expected) in [
        (
            strings(6, &(string(3, 2) + &string(3, 2))),
            "line 5: found row 2 of column 1, expected rows that ascend, each once, here 3",
        ),
        (strings(3, &string(3, 0)), "found row 0 of column 1"),
        (strings(3, &string(3, 4)), "line 3: the row 4 is outside 1 to 3"),
        (strings(2, &string(3, 1)), "a string of 3 words, expected up to 2"),
        (strings(3, &string(1, 1)), "a string of 1 words"),
        (
            strings(3, &string(2, 1)),
            "found 1 words of entries, expected 2 for each",
        ),
        (format!("{HEAD}{ONE}{END}{HEAD}"), "line 6: found a second `A`"),
    ] {
        refused(op4::parse(source(text.as_bytes())), expected);
    }

    let sound = std::fs::read(fixture("dense_le.op4")).unwrap();
    let altered = |at: usize, to: i32| {
        let mut bytes = sound.clone();
        bytes[at..at + 4].copy_from_slice(&to.to_le_bytes());
        bytes
    };
    let mut not_finite = sound.clone();
    not_finite[48..56].copy_from_slice(&f64::NAN.to_le_bytes());
    for (bytes, expected) in [
        (
            altered(28, 20),
            "byte 0: found a record of 24 bytes that ends as one of 20",
        ),
        (
            altered(32, 1 << 30),
            "byte 32: the number of bytes of a record is stated as 1073741824",
        ),
        (
            altered(44, 2),
            "byte 48: found 2 words in a column, expected a record of three words more, not of 28 bytes",
        ),
        (altered(36, -1), "byte 40: found -1, expected no negative number"),
        (not_finite, "byte 48: the entry NaN"),
        (sound[..64].to_vec(), "the number of bytes of a record is stated as 28"),
        (sound[..70].to_vec(), "byte 68"),
    ] {
        refused(op4::parse(source(&bytes)), expected);
    }
}

#[test]
fn entries_dmig_in_every_layout() {
    let parse = |text: &str| dmig::parse(source(text.as_bytes())).unwrap();
    let small = parse(
        "DMIG    K       0       6       2\n\
         DMIG    K       7       1               7       1       2.0             A1\n\
         +1      9               -1.5-1\n\
         DMIG    K       9                       9               3.+2            $ a scalar point\n",
    );
    assert_eq!(small.dofs, nodal(&[(7, 1), (9, 0)]));
    let expected = sparse((2, 2), &[(0, 0, 2.0), (0, 1, -0.15), (1, 0, -0.15), (1, 1, 300.0)]);
    assert_eq!(small.matrices["K"], expected);
    let free = "dmig,k,7,1,,7,1,2.0\n,9,0,-1.5D-1,,,,,,+A\nDMIG*,K,9,0,\n*,9,0,300.0,0.0\nDMIG,K,0,6,1,0\n";
    assert_eq!(parse(free), small);
    let deck = parse(&format!(
        "SOL 103\nCEND\nBEGIN BULK\nGRID,7\n{free}PARAM,POST,\n+,-1\nENDDATA\nmore\n"
    ));
    assert_eq!(deck.matrices, small.matrices);
    let skipped: Vec<_> = deck
        .skipped
        .iter()
        .map(|s| format!("{}: {}", s.name, s.reason))
        .collect();
    let expected = [
        "BEGIN BULK: 2 lines outside the bulk data",
        "ENDDATA: 1 lines outside the bulk data",
        "GRID: 1 entries that are no DMIG",
        "PARAM: 1 entries that are no DMIG",
    ];
    assert_eq!(skipped, expected);

    // Rectangular: columns by points, by numbers, and by the order of their points.
    let columns = |head: &str| {
        parse(&format!(
            "{head}\nDMIG,A,30,,,7,1,2.0\nDMIG,A,2,5,,8,1,4.0\nDMIG,Z,0,6,1\n"
        ))
    };
    let by_points = columns("DMIG,A,0,2,1");
    assert_eq!(by_points.dofs, nodal(&[(2, 5), (7, 1), (8, 1), (30, 0)]));
    assert_eq!(by_points.matrices["A"], sparse((4, 4), &[(1, 3, 2.0), (2, 0, 4.0)]));
    assert_eq!(by_points.matrices["Z"].nnz(), 0);
    let by_numbers = columns("DMIG,A,0,9,1,,,,31");
    assert_eq!(by_numbers.numbered["A"], sparse((2, 31), &[(0, 29, 2.0), (1, 1, 4.0)]));
    assert_eq!(
        columns("DMIG,A,0,9,1").numbered["A"],
        sparse((2, 2), &[(0, 1, 2.0), (1, 0, 4.0)])
    );
}

#[test]
fn entries_dmig_that_are_refused() {
    for (text, expected) in [
        ("", "line 1: found the end of the bulk data, expected entries DMIG"),
        ("GRID,1\n", "expected entries DMIG"),
        (
            "+,1\n",
            "line 1: found `+,1`, expected an entry before its continuation",
        ),
        ("DMIG\tK\n", "line 1: found a tabulator"),
        (
            "DMIG,K,0,6,1\n#x,1\n",
            "line 2: found `#x,1`, expected an entry of bulk data",
        ),
        ("DMIG,K,1,1,,1,1,2.0,,4.0\n", "at most 8 fields after the first"),
        ("DMIG,2K,0,6,1\n", "found `2K`, expected a name"),
        (
            "DMIG,K,0,4,1\n",
            "line 1: the form 4 of the matrix `K` is not supported",
        ),
        ("DMIG,K,0,6,3\n", "a complex matrix is not supported"),
        ("DMIG,K,0,6,2,4\n", "a complex matrix is not supported"),
        ("DMIG,K,0,6,2,5\n", "found type 5"),
        ("DMIG,K,0,6,2,,1\n", "amplitudes and phases"),
        ("DMIG,K,0,6,2,,,1\n", "found `1`, expected an empty field before NCOL"),
        (
            "DMIG,K,0,6,2,,,,2\n,1\n",
            "line 2: found `,1`, expected the end of the header",
        ),
        ("DMIG,K,0,6,1\nDMIG,K,0,6,1\n", "line 2: found a second header of `K`"),
        (
            "DMIG,K,1,1,,1,1,2.0\n",
            "line 1: found columns of `K`, expected a header",
        ),
        ("DMIG,K,1,1,5,1,1,2.0\n", "found `5`, expected an empty field"),
        ("DMIG,K,1,7,,1,1,2.0\n", "found component 7"),
        ("DMIG,K,-1,1,,1,1,2.0\n", "found `-1`, expected 0 or a point"),
        (
            "DMIG,K,1,1,,0,1,2.0\n",
            "found `0`, expected the positive number of a point",
        ),
        ("DMIG,K,1,1,,1,1\n", "found ``, expected a number"),
        ("DMIG,K,1,1,,1,1,inf\n", "inf is not a finite number"),
        ("DMIG,K,1,1,,1,1,2.0,1.0\n", "an imaginary part"),
        (
            "DMIG,K,0,6,1\nDMIG,K,1,1,,2,1,2.0\nDMIG,K,2,1,,1,1,2.0\n",
            "line 3: the entry of row 1, column 2 is given twice",
        ),
        (
            "DMIG,K,0,6,1\nDMIG,K,1,1,,2,1,2.0\nDMIG,K,2,1,,1,1,3.0\n",
            "the other way round",
        ),
        (
            "DMIG,K,0,1,1\nDMIG,K,1,1,,2,1,2.0\nDMIG,K,1,1,,2,1,2.0\n",
            "line 3: the entry of row 2, column 1 is given twice",
        ),
        (
            "DMIG,K,0,9,1,,,,2\nDMIG,K,3,,,2,1,2.0\n",
            "line 2: the column 3 is outside 1 to 2",
        ),
        ("DMIG,K,0,9,1,,,,9999999\n", "line 1: NCOL is stated as 9999999"),
        (
            "DMIG,K,0,9,1\nDMIG,K,3,,,2,1,2.0\nDMIG,K,3,,,1,1,2.0\n",
            "2 entries of 1 columns without NCOL",
        ),
    ] {
        refused(dmig::parse(source(text.as_bytes())), expected);
    }
    let long = format!("{:80}x\n", "DMIG    K       0       6       2");
    refused(
        dmig::parse(source(long.as_bytes())),
        "found `x`, expected nothing beyond column 80",
    );
    let headers: String = (0..999).map(|i| format!("DMIG,A{i},0,6,1\n")).collect();
    let points: String = (1..1200).map(|i| format!("DMIG,A,{i},1\n")).collect();
    let many = format!("DMIG,A,0,6,1\n{headers}{points}");
    refused(
        dmig::parse(source(many.as_bytes())),
        "the number of rows of all is stated as 1199000",
    );
}

fn number() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![
        3 => proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO,
        1 => (-100..100_i32).prop_map(f64::from),
    ]
}

/// Entries by place, mirrored on demand.
fn square(n: usize) -> impl Strategy<Value = CsMat<f64>> {
    let entries = proptest::collection::btree_map((0..n, 0..n), number(), 1..12);
    (entries, any::<bool>()).prop_map(move |(entries, symmetric)| {
        let all: BTreeMap<(usize, usize), f64> = match symmetric {
            true => entries
                .iter()
                .flat_map(|(&(i, j), &v)| [((i.max(j), i.min(j)), v), ((i.min(j), i.max(j)), v)])
                .collect(),
            false => entries,
        };
        let list: Vec<_> = all.into_iter().map(|((i, j), v)| (i, j, v)).collect();
        sparse((n, n), &list)
    })
}

proptest! {
    #[test]
    fn output4(dense in proptest::collection::vec(number(), 12), sparse in square(5), rows in 1..13_usize) {
        let columns = 12 / rows;
        let dense = Dense::try_new(rows, columns, dense[..rows * columns].to_vec()).unwrap();
        let arrays: BTreeMap<String, Array> =
            [("A1".to_owned(), Array::Dense(dense)), ("B".to_owned(), Array::Sparse(sparse))].into();
        let bytes = op4::to_bytes(&arrays);
        // One triangle alone is refused from a matrix that is stated as symmetric, which this one is not.
        let back = op4::parse(source(&bytes.unwrap())).unwrap();
        let bits = |array: &Array| -> Vec<u64> {
            match array {
                Array::Dense(m) => m.data().iter().map(|v| v.to_bits()).collect(),
                Array::Sparse(m) => m.data().iter().map(|v| v.to_bits()).collect(),
                _ => Vec::new(),
            }
        };
        prop_assert_eq!(&back.arrays, &arrays);
        prop_assert!(back.arrays.iter().all(|(name, array)| bits(array) == bits(&arrays[name])));
    }

    #[test]
    fn entries_dmig(k in square(4), m in square(4)) {
        let dofs = nodal(&[(3, 1), (3, 6), (12_345_678, 2), (99_999_999, 0)]);
        // Every coordinate has an entry.
        let diagonal: CsMat<f64> = CsMat::eye(4);
        let model = PointMatrices {
            dofs,
            matrices: [("K".to_owned(), k), ("M".to_owned(), m), ("MODAL".to_owned(), diagonal)].into(),
            ..PointMatrices::default()
        };
        let bytes = dmig::to_bytes(&model, "one\ntwo").unwrap();
        let back = dmig::parse(source(&bytes)).unwrap();
        prop_assert_eq!(&back.dofs, &model.dofs);
        for (name, m) in &model.matrices {
            let found = &back.matrices[name];
            prop_assert_eq!(found.indices(), m.indices());
            let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-8 * b.abs() || a.is_subnormal();
            prop_assert!(found.data().iter().zip(m.data()).all(near));
        }
        // What was rounded once stays.
        prop_assert_eq!(dmig::parse(source(&dmig::to_bytes(&back, "").unwrap())).unwrap(), back);
    }
}

#[test]
fn what_cannot_be_written_is_refused() {
    let refused = |result: Result<Vec<u8>, Error>, expected: &str| {
        let error = result.unwrap_err();
        let is_unwritable = matches!(error, Error::Unwritable { .. });
        assert!(is_unwritable && error.to_string().contains(expected), "{error}");
    };
    let one = |name: &str, array: Array| op4::to_bytes(&[(name.to_owned(), array)].into());
    let number = |v: f64| Array::Dense(Dense::try_new(1, 1, vec![v]).unwrap());
    for name in ["", "1K", "K_1", "ninechars"] {
        refused(one(name, number(1.0)), "begin with a letter");
    }
    refused(one("K", number(f64::NAN)), "finite");
    refused(one("K", Array::Text("K".into())), "text");
    refused(
        one("K", Array::Integers(Dense::try_new(1, 1, vec![i64::MAX]).unwrap())),
        "integers",
    );

    let model = |dofs: &[Dof], name: &str, m: CsMat<f64>| {
        let model = PointMatrices {
            dofs: dofs.to_vec(),
            matrices: [(name.to_owned(), m)].into(),
            ..PointMatrices::default()
        };
        dmig::to_bytes(&model, "")
    };
    let dofs = nodal(&[(1, 1), (2, 0)]);
    refused(model(&dofs, "k", CsMat::eye(2)), "capitals");
    refused(model(&dofs, "K", CsMat::eye(3)), "3 rows and 3 columns for 2");
    refused(
        model(&dofs, "K", sparse((2, 2), &[(0, 0, 1.0)])),
        "no matrix has an entry of point 2, component 0",
    );
    refused(model(&dofs, "K", sparse((2, 2), &[(0, 0, f64::INFINITY)])), "finite");
    for wrong in [
        Dof::new(-1, 1),
        Dof::new(1, 7),
        Dof::new(1, 1),
        Dof::new(100_000_000, 1),
    ] {
        refused(model(&[dofs[0], wrong], "K", CsMat::eye(2)), "scalar points");
    }
}
