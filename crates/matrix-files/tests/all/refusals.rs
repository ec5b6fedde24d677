//! Files that are wrong are refused with their name, the place, what stands there and what to do.

#![allow(clippy::unwrap_used)]

use file_io::{Place, Source};
use matrix_files::abaqus::{parse_assembled, parse_substructure};
use matrix_files::value::{Array, Collection, Dof};
use matrix_files::{Error, ansys, calculix, mat, matrix_market, npz};

pub(crate) fn source(bytes: &[u8]) -> Source<'_> {
    Source {
        name: "the file",
        bytes,
    }
}

pub(crate) fn refused<T: std::fmt::Debug>(result: Result<T, Error>, expected: &str) {
    let message = result.expect_err(expected).to_string();
    assert!(
        message.contains(expected) && message.contains("the file"),
        "{message}\nshould say: {expected}"
    );
}

#[test]
fn matrix_market_files() {
    const BANNER: &str = "%%MatrixMarket matrix coordinate real ";
    for (text, expected) in [
        ("", "line 1: found ``, expected `%%MatrixMarket"),
        ("%%MatrixMarket matrix coordinate pattern general\n", "without values"),
        ("%%MatrixMarket matrix coordinate complex hermitian\n", "complex"),
        (
            "%%MatrixMarket matrix coordinate real skew-symmetric\n",
            "skew-symmetric",
        ),
        ("%%MatrixMarket vector coordinate real general\n", "line 1"),
        ("%%MatrixMarket matrix array real general\n% note\n", "line of sizes"),
        (
            "%%MatrixMarket matrix array real general\n2 2\n1\n2\n3\n",
            "3 entries, expected 4",
        ),
        (
            "%%MatrixMarket matrix array real general\n1 1\n1\n2\n",
            "line 4: found `2`",
        ),
        (
            "%%MatrixMarket matrix array real general\n1 1\n1e999\n",
            "inf is not a finite number",
        ),
        (
            "%%MatrixMarket matrix array real general\n1000000000 1000000000\n1\n",
            "line 2: the number of entries",
        ),
        (
            "%%MatrixMarket matrix array integer general\n1 1\n1.5\n",
            "expected an integer",
        ),
        (
            "%%MatrixMarket matrix array real symmetric\n1 2\n1\n",
            "as many rows as columns",
        ),
        (
            "general\n1000000000 1000000000 1\n1 1 1.0\n",
            "line 2: the number of rows",
        ),
        ("general\n2 2 1000000000\n1 1 1.0\n", "line 2: the number of entries"),
        ("general\n2 2 2\n1 1 1.0\n", "1 entries, expected 2"),
        ("general\n2 2 1\n3 1 1.0\n", "line 3: the row 3 is outside 1 to 2"),
        ("general\n2 2 1\n1 0 1.0\n", "the column 0 is outside 1 to 2"),
        ("general\n2 2 1\n1 1 nan\n", "NaN"),
        ("general\n2 2 1\n1 1 1.0 2.0\n", "row, column and value"),
        (
            "general\n2 2 2\n1 1 1.0\n1 1 1.0\n",
            "line 4: the entry of row 1, column 1 is given twice",
        ),
        ("symmetric\n2 2 2\n2 1 1.0\n1 2 1.5\n", "1.5e0 the other way round"),
        ("symmetric\n2 2 2\n2 1 1.0\n1 2 1.0\n", "given twice"),
    ] {
        let text = if text.starts_with(['%']) || text.is_empty() {
            text.to_owned()
        } else {
            format!("{BANNER}{text}")
        };
        refused(matrix_market::parse(source(text.as_bytes())), expected);
    }
    // A short file of a long vector is no attack.
    let vector = matrix_market::parse(source(format!("{BANNER}general\n225000 1 1\n700 1 2.5\n").as_bytes())).unwrap();
    assert!(matches!(vector, Array::Sparse(m) if m.get(699, 0) == Some(&2.5) && m.rows() == 225_000));
}

#[test]
fn calculix_files() {
    let parse = |sti: &str, dof: &str| {
        calculix::parse(calculix::Files {
            stiffness: source(sti.as_bytes()),
            mass: source(b"1 1 1.0\n2 2 1.0\n"),
            dofs: source(dof.as_bytes()),
        })
    };
    const DOFS: &str = "4.1\n4.2\n";
    for (sti, dof, expected) in [
        ("1 1 1.0\n", "", "every line `node.direction` is missing"),
        ("1 1 1.0\n", "4,1\n", "line 1: found `4,1`, expected `node.direction`"),
        (
            "1 1 1.0\n",
            "4.1\n4.1\n",
            "line 2: found `4.1`, expected each component",
        ),
        ("3 3 1.0\n", DOFS, "line 1: the row 3 is outside 1 to 2"),
        ("1 1\n", DOFS, "row, column and value"),
        (
            "1 1 1.0\n1 1 2.0\n",
            DOFS,
            "line 2: the entry of row 1, column 1 is given twice",
        ),
        ("1 2 1.0\n2 1 2.0\n", DOFS, "the other way round"),
        ("1 2 -inf\n", DOFS, "-inf is not a finite number"),
    ] {
        refused(parse(sti, dof), expected);
    }
    // Either triangle, or both.
    let upper = parse("1 1 1.0\n1 2 0.5\n", DOFS).unwrap();
    assert_eq!(parse("1 1 1.0\n2 1 0.5\n", DOFS).unwrap(), upper);
    assert_eq!(parse("1 1 1.0\n2 1 0.5\n1 2 0.5\n", DOFS).unwrap(), upper);
}

/// A substructure with a node, a retained mode and all sections, as documented and as others describe real files.
const SUBSTRUCTURE: &str = "\
**
** SUBSTRUCTURE Z1
*USER ELEMENT,NODES=          2,LINEAR
** ELEMENT NODES
**        11,        -1,
 1, 3
 2, 1
*MATRIX,TYPE=STIFFNESS
 2.0,
-1.0, 3.0,
 0.0, 0.0, 0.25D+03,
** SUBSTRUCTURE LOAD CASE VECTOR. SLOAD CASE  Bolt-1
***CLOAD
** 1, 3, 12.5
** 2, 1, -4.
**
*MATRIX, TYPE=MASS
1.0, 0.0, 1.0
0.0, 0.5, 1.0
** GRAVITY LOAD VECTOR
** 1, 1, 9.81
** RECOVERY MATRIX
** NUMBER OF NODES    1
** 77,
** SUBSTRUCTURE RECOVERY VECTOR CORRESPONDING TO RETAINED DOFS NUMBER     1
** 1.0, 2.0,
** SUBSTRUCTURE RECOVERY VECTOR CORRESPONDING TO RETAINED DOFS NUMBER     2
** 3.0, 4.0,
** SUBSTRUCTURE RECOVERY VECTOR CORRESPONDING TO RETAINED DOFS NUMBER     3
** 5.0,
** 6.0,
";

#[test]
fn substructure_with_all_sections() {
    let found = parse_substructure(source(SUBSTRUCTURE.as_bytes())).unwrap();
    let dofs = [(11, 1), (11, 3), (-1, 1)].map(|(label, component)| Dof::new(label, component));
    assert_eq!(found.dofs, dofs);
    assert_eq!(
        dofs[2],
        Dof::Generalised {
            label: -1,
            component: 1
        }
    );
    assert_eq!(
        found.matrices["STIFFNESS"].data(),
        [2.0, -1.0, 0.0, -1.0, 3.0, 0.0, 0.0, 0.0, 250.0]
    );
    assert_eq!(
        found.matrices["MASS"].data(),
        [1.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.0, 0.5, 1.0]
    );
    assert_eq!(found.loads["Bolt-1"], [0.0, 12.5, -4.0]);
    let recovery = found.recovery.unwrap();
    assert_eq!(
        (recovery.matrix.rows(), recovery.matrix.data()),
        (2, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0][..])
    );
    assert_eq!(recovery.heading, ["** NUMBER OF NODES    1", "** 77,"]);
    assert_eq!(found.skipped.len(), 1);
    assert_eq!(found.skipped[0].name, "GRAVITY LOAD VECTOR");
}

#[test]
fn substructure_files() {
    let with = |from: &str, to: &str| {
        assert!(SUBSTRUCTURE.contains(from), "{from}");
        parse_substructure(source(SUBSTRUCTURE.replacen(from, to, 1).as_bytes()))
    };
    for (from, to, expected) in [
        (
            "** ELEMENT NODES",
            "**",
            "the list of nodes after `** ELEMENT NODES` before line 6 is missing",
        ),
        (" 1, 3\n 2, 1\n", "", "the list of components"),
        ("*USER ELEMENT,NODES=          2,LINEAR\n", "", "line 5"),
        ("NODES=          2", "NODES=          3", "2 node labels, expected 3"),
        ("NODES=          2", "NODES=2,UNSYMM", "unsymmetric"),
        (" 1, 3\n", " 1, 1\n", "components, each once"),
        (
            " 2, 1\n",
            " 3, 1\n",
            "line 7: the position of the node 3 is outside 1 to 2",
        ),
        ("11,        -1", "11,        11", "component 1 of node 11 twice"),
        ("-1.0, 3.0,", "-1.0,", "5 entries of the STIFFNESS, expected 6"),
        ("-1.0, 3.0,", "-1.0, 3.0, 7.0", "the end after 6 entries"),
        ("-1.0, 3.0,", "-1.0, NaN,", "line 10: the entry NaN"),
        ("-1.0, 3.0,", "** 1.0, 3.0,", "without `**`"),
        ("TYPE=MASS", "TYPE=STIFFNESS", "not given before"),
        ("** 1, 3, 12.5", "** 1, 2, 12.5", "a retained degree of freedom"),
        ("** 2, 1, -4.", "** 1, 3, -4.", "each retained degree of freedom once"),
        ("** 2, 1, -4.", "** 2, 1, -1e400", "-inf"),
        ("***CLOAD", "***CLOAD, IMAGINARY", "imaginary"),
        ("NUMBER     3\n", "NUMBER     4\n", "4 is outside 1 to 3"),
        (
            "NUMBER     3\n",
            "NUMBER     2\n",
            "each retained degree of freedom once",
        ),
        ("** 6.0,\n", "", "1 entries in column 3"),
        ("*MATRIX, TYPE=MASS", "*STEP", "*USER ELEMENT, *MATRIX or a comment"),
        ("*MATRIX, TYPE=MASS", "*USER ELEMENT,NODES=2", "a second element"),
    ] {
        refused(with(from, to), expected);
    }
    refused(parse_substructure(source(b"1,1,1,1,2.5\n")), "*MATRIX OUTPUT");
    let huge = SUBSTRUCTURE.replacen(
        " 1, 3\n 2, 1\n",
        &format!(" {}\n", (1..99).map(|i| format!("{i},")).collect::<String>()),
        1,
    );
    refused(
        parse_substructure(source(huge.as_bytes())),
        "the number of degrees of freedom is stated as 196",
    );
}

#[test]
fn assembled_matrices() {
    let one = |text: &str| parse_assembled(&[("STIFFNESS", source(text.as_bytes()))]);
    for (text, expected) in [
        ("", "every entry is missing"),
        (
            "1, 1, 2.5\n",
            "the node and component of each entry (line 1 has three numbers) is missing",
        ),
        ("1,1, 1,1, 2.0\n1,1, 2.0\n", "line 2"),
        ("*MATRIX INPUT, TYPE=UNSYMMETRIC\n1,1, 1,1, 2.0\n", "unsymmetric"),
        ("*STEP\n", "*MATRIX or a comment"),
        (
            "1,1, 1,1, 2.0\n1,1, 1,1, 2.0\n",
            "line 2: the entry of row 1, column 1 is given twice",
        ),
        ("1,1, 2,1, 2.0\n2,1, 1,1, 2.5\n", "2.5e0"),
        // Both triangles for one pair, one triangle for another.
        (
            "1,1, 2,1, 2.0\n2,1, 1,1, 2.0\n3,1, 1,1, 7.0\n",
            "line 3: row 3, column 1 is 7e0, but 0e0",
        ),
        ("1,1, 1,1, infinity\n", "inf"),
    ] {
        refused(one(text), expected);
    }
    // The mass knows a node that the stiffness does not; internal variables come last.
    let found = parse_assembled(&[
        ("STIFFNESS", source(b"** note\n5,2, 5,2, 2.0\n-1,1, 5,2, -1.0\n")),
        ("MASS", source(b"3,1, 3,1, 4.0\n")),
    ])
    .unwrap();
    assert_eq!(
        found.dofs,
        [(3, 1), (5, 2), (-1, 1)].map(|(label, component)| Dof::new(label, component))
    );
    let (stiffness, mass) = (&found.matrices["STIFFNESS"], &found.matrices["MASS"]);
    assert_eq!((stiffness.get(1, 2), stiffness.get(2, 1)), (Some(&-1.0), Some(&-1.0)));
    assert_eq!((mass.shape(), mass.get(0, 0), mass.nnz()), ((3, 3), Some(&4.0), 1));
}

/// An element of a MATLAB file.
fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut out = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
    out
}

fn words(values: &[i32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn matlab(inside: &[Vec<u8>]) -> Vec<u8> {
    let mut file = vec![b' '; 124];
    file.extend([0, 1, b'I', b'M']);
    file.extend(element(14, &inside.concat()));
    file
}

/// A sparse matrix `K` with these indices.
fn sparse(size: [i32; 2], rows: &[i32], starts: &[i32], values: &[f64]) -> Vec<u8> {
    let values: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    matlab(&[
        element(6, &words(&[5, 1])),
        element(5, &words(&size)),
        element(1, b"K"),
        element(5, &words(rows)),
        element(5, &words(starts)),
        element(9, &values),
    ])
}

fn full(size: [i32; 2], values: &[f64]) -> Vec<u8> {
    let values: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    matlab(&[
        element(6, &words(&[6, 0])),
        element(5, &words(&size)),
        element(1, b"M"),
        element(9, &values),
    ])
}

#[test]
fn matlab_files() {
    let good = sparse([3, 2], &[0, 2, 1], &[0, 2, 3], &[1.0, 2.0, 3.0]);
    let Collection { arrays, .. } = mat::parse(source(&good)).unwrap();
    assert!(matches!(&arrays["K"], Array::Sparse(m) if m.is_csr() && m.get(2, 0) == Some(&2.0) && m.nnz() == 3));
    for (file, expected) in [
        (
            sparse([1_000_000_000, 1_000_000_000], &[0], &[0, 1], &[1.0]),
            "byte 184: the number of rows or columns",
        ),
        (
            sparse([3, 9], &[0, 2, 1], &[0, 2, 3], &[1.0; 3]),
            "the number of indices is stated as 10",
        ),
        (
            sparse([3, 2], &[0, 2, 1], &[0, 2, 9], &[1.0; 3]),
            "the number of indices is stated as 9",
        ),
        (
            sparse([3, 2], &[0, 3, 1], &[0, 2, 3], &[1.0; 3]),
            "the row (from zero) 3 is outside 0 to 2",
        ),
        (sparse([3, 2], &[2, 0, 1], &[0, 2, 3], &[1.0; 3]), "do not ascend"),
        (sparse([3, 2], &[0, 0, 1], &[0, 2, 3], &[1.0; 3]), "do not ascend"),
        (
            sparse([3, 2], &[0, 2, 1], &[0, 4, 3], &[1.0; 3]),
            "starts of columns that descend",
        ),
        (
            sparse([3, 2], &[0, -2, 1], &[0, 2, 3], &[1.0; 3]),
            "found -2, expected no negative number",
        ),
        (sparse([3, 2], &[0, 2, 1], &[0, 2, 3], &[1.0; 2]), "2 values"),
        (
            sparse([3, 2], &[0, 2, 1], &[0, 2, 3], &[1.0, f64::NAN, 1.0]),
            "byte 248: the entry NaN",
        ),
        (
            full([1_000_000_000, 1_000_000_000], &[1.0]),
            "1 entries, expected 1000000000 x 1000000000",
        ),
        (full([1, 1], &[f64::INFINITY]), "inf"),
        (good[..200].to_vec(), "the number of bytes of an element"),
        (good[..100].to_vec(), "byte 100: found the end of the file"),
        ([&good[..128], &element(9, &[0; 8])].concat(), "expected an array"),
        ([&good[..128], &element(15, &[1; 16])].concat(), "do not unpack"),
        ([&good[..], &good[128..]].concat(), "a second `K`"),
    ] {
        refused(mat::parse(source(&file)), expected);
    }
}

#[test]
fn matlab_files_with_the_highest_byte_first() {
    let mut file = vec![b' '; 124];
    file.extend([1, 0, b'M', b'I']);
    let tag = |kind: u32, size: u32| [kind.to_be_bytes(), size.to_be_bytes()].concat();
    let flags = [tag(6, 8), 6_u32.to_be_bytes().to_vec(), vec![0; 4]].concat();
    let dimensions = [tag(5, 8), 1_i32.to_be_bytes().to_vec(), 2_i32.to_be_bytes().to_vec()].concat();
    // A name and two numbers small enough for the tags.
    let name = [0, 1, 0, 1, b'M', 0, 0, 0].to_vec();
    let numbers = [
        [0, 4, 0, 3].to_vec(),
        (-2_i16).to_be_bytes().to_vec(),
        300_i16.to_be_bytes().to_vec(),
    ]
    .concat();
    let body = [flags, dimensions, name, numbers].concat();
    file.extend(tag(14, body.len() as u32));
    file.extend(body);
    let found = mat::parse(source(&file)).unwrap();
    assert!(matches!(&found.arrays["M"], Array::Dense(m) if m.data() == [-2.0, 300.0] && m.rows() == 1));
}

#[test]
fn numpy_files() {
    refused(npz::parse(source(b"PK")), "a ZIP archive");
    let number = |value: f64| {
        let m = matrix_files::value::Dense::try_new(1, 1, vec![value]).unwrap();
        npz::to_bytes(&[("M".to_owned(), Array::Dense(m))].into()).unwrap()
    };
    // Same length, and the checksum repaired where it is not what is tested.
    let altered = |from: &[u8], to: &[u8], checked: bool| {
        let mut file = number(1.5);
        let at = file.windows(from.len()).position(|w| w == from).unwrap();
        let begin = file.windows(6).position(|w| w == b"\x93NUMPY").unwrap();
        let end = begin + 128 + 8;
        let before = checksum(&file[begin..end]);
        file[at..at + to.len()].copy_from_slice(to);
        let after = checksum(&file[begin..end]);
        if checked {
            for at in 0..file.len() - 4 {
                if file[at..at + 4] == before.to_le_bytes() {
                    file[at..at + 4].copy_from_slice(&after.to_le_bytes());
                }
            }
        }
        file
    };
    let at_data = 1.5_f64.to_le_bytes();
    for (file, expected) in [
        (
            altered(&at_data, &f64::NAN.to_le_bytes(), true),
            "byte 128 of `M.npy`: the entry NaN",
        ),
        (altered(&at_data, &2.5_f64.to_le_bytes(), false), "checksum"),
        (
            altered(b"(1, 1)", b"(1e9,)", true),
            "`descr`, `fortran_order` and `shape`",
        ),
        (
            altered(b"(1, 1)", b"(9, 9)", true),
            "the number of bytes of the entries is stated as 648",
        ),
        (altered(b"(1, 1)", b"(0, 1)", true), "8 bytes of entries, expected 0"),
        (altered(b"\x93NUMPY", b"\x93NUMPI", true), "expected `\\x93NUMPY`"),
        (
            altered(b"v\x00{", b"v\xff{", true),
            "the number of bytes of the header is stated as 65398",
        ),
    ] {
        refused(npz::parse(source(&file)), expected);
    }
    let mut twice = std::fs::read(format!("{}/tests/fixtures/plain.npz", env!("CARGO_MANIFEST_DIR"))).unwrap();
    for at in 0..twice.len() - 10 {
        if twice[at..].starts_with(b"counts.npy") {
            twice[at..at + 6].copy_from_slice(b"single");
        }
    }
    refused(npz::parse(source(&twice)), "two members of the same name");
    let found = npz::parse(source(&altered(b"<f8", b"<c8", true))).unwrap();
    assert_eq!((found.arrays.len(), found.skipped[0].name.as_str()), (0, "M"));

    // In measurements NaN marks what is missing.
    let missing = altered(&at_data, &f64::NAN.to_le_bytes(), true);
    let nan = |array: &Array| matches!(array, Array::Dense(m) if m.data()[0].is_nan());
    assert!(nan(&npz::parse_measured(source(&missing)).unwrap().arrays["M"]));
    let begin = missing.windows(6).position(|w| w == b"\x93NUMPY").unwrap();
    let alone = &missing[begin..begin + 128 + 8];
    assert!(nan(&npz::parse_measured_array(source(alone)).unwrap()));
    refused(
        npz::parse_measured_array(source(&alone[..130])),
        "byte 128: the number of bytes of the entries is stated as 8",
    );
    refused(npz::parse_measured_array(source(&missing)), "expected `\\x93NUMPY`");
}

/// CRC-32 of ZIP files.
fn checksum(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc: u32, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

#[test]
fn errors_carry_numbers_too() {
    let refused = matrix_market::parse(source(
        b"%%MatrixMarket matrix coordinate real general\n2 2 1\n1 5 1.0\n",
    ));
    assert!(matches!(
        refused,
        Err(Error::OutOfRange {
            place: Place::Line(3),
            index: 5,
            first: 1,
            last: 2,
            ..
        })
    ));
}

#[test]
fn files_of_ansys() {
    let sound = std::fs::read(crate::nastran::fixture("small.full")).unwrap();
    // The second head begins after 103 words, and its numbers two words later.
    const HEAD: usize = 105;
    let altered = |word: usize, to: i32| {
        let mut bytes = sound.clone();
        bytes[4 * word..4 * word + 4].copy_from_slice(&to.to_le_bytes());
        bytes
    };
    let word = |at: usize| i32::from_le_bytes(sound[4 * at..4 * at + 4].try_into().unwrap());
    let [stiffness, components, scale] = [18, 35, 59].map(|index| word(HEAD + index) as usize);
    let mut scaled = sound.clone();
    scaled[4 * (scale + 6)..4 * (scale + 8)].copy_from_slice(&2.0_f64.to_le_bytes());
    for (bytes, expected) in [
        (
            altered(2, 8),
            "a file of a superelement is not supported; read it in Ansys by *SMAT",
        ),
        (altered(2, 12), "found the number 12, expected 4"),
        (altered(HEAD, 4), "the frontal solver"),
        (altered(HEAD + 10, 1), "a lumped mass is not supported"),
        (altered(HEAD + 13, 1), "an unsymmetric matrix"),
        (altered(HEAD + 20, 2), "constraint equations"),
        (altered(HEAD + 62, 1), "one process of several"),
        (
            altered(HEAD + 1, i32::MAX),
            "the number of equations is stated as 2147483647",
        ),
        (
            altered(HEAD + 1, 5),
            "found a record that breaks off, expected all of its numbers",
        ),
        (altered(HEAD + 18, 1 << 28), "expected more bytes"),
        (
            altered(components + 4, 4),
            "found more degrees of freedom at nodes, expected 6",
        ),
        (
            altered(components + 4, 2),
            "found 6 equations, expected nodes for all of them",
        ),
        (altered(components + 14, 7), "the degree of freedom 7 of node 7"),
        (altered(components + 10, 99), "expected all of its numbers"),
        (scaled, "a scaled matrix"),
        (
            altered(stiffness, 1 << 20),
            "the number of words of a record is stated as 1048576",
        ),
        (altered(stiffness + 1, 0x20 << 24), "a packed record is not supported"),
        (altered(stiffness + 2, 7), "the column 7 is outside 1 to 6"),
        (altered(stiffness + 2, 1), "is given twice"),
        (altered(stiffness + 5, 1), "expected their number at its end"),
        (
            sound[..300].to_vec(),
            "the number of words of a record is stated as 100",
        ),
        (Vec::new(), "byte 0: found the end of the file"),
    ] {
        refused(ansys::parse(source(&bytes)), expected);
    }
}
