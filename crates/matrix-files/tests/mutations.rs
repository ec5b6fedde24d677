//! Damaged files: whatever the bytes, every reader answers, and memory stays within a multiple of the file's size.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::collections::BTreeMap;
use std::io::{Cursor, Read, Write};

use file_io::Source;
use matrix_files::abaqus::{self, Substructure};
use matrix_files::{Error, ansys, calculix, dmig, mat, matrix_market, npz, op2, op4};
use test_support::memory::Counting;
use test_support::{Damage, Sample, Tally};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

type Reader = fn(Source<'_>) -> Result<(), Error>;

fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// The three files of CalculiX, one of which is damaged.
fn calculix_with(role: usize, source: Source<'_>) -> Result<(), Error> {
    let sound = [
        &b"1 1 2.0\n1 2 -1.0\n2 2 3.0\n"[..],
        b"1 1 1.0\n2 2 1.0\n",
        b"7.1\n7.2\n",
    ];
    let file = |i: usize| {
        let bytes = if i == role { source.bytes } else { sound[i] };
        Source {
            name: source.name,
            bytes,
        }
    };
    let files = calculix::Files {
        stiffness: file(0),
        mass: file(1),
        dofs: file(2),
    };
    calculix::parse(files).map(drop)
}

/// A file of NumPy with a member that is damaged but true to its checksum; all others are those of `csc.npz`.
fn numpy_with(member: &str, source: Source<'_>) -> Result<(), Error> {
    let mut sound = zip::ZipArchive::new(Cursor::new(fixture("csc.npz"))).unwrap();
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..sound.len() {
        let mut file = sound.by_index(index).unwrap();
        let name = file.name().unwrap().into_owned();
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).unwrap();
        let bytes = if name == member { source.bytes } else { &bytes };
        let stored = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
        archive.start_file(name, stored).unwrap();
        archive.write_all(bytes).unwrap();
    }
    let bytes = archive.finish().unwrap().into_inner();
    npz::parse(Source {
        name: source.name,
        bytes: &bytes,
    })
    .map(drop)
}

/// A member of `csc.npz`.
fn member(name: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut archive = zip::ZipArchive::new(Cursor::new(fixture("csc.npz"))).unwrap();
    archive.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

/// A file of MATLAB with one compressed element that is damaged but true to its checksum.
fn matlab_around(source: Source<'_>) -> Result<(), Error> {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(source.bytes).unwrap();
    let packed = packer.finish().unwrap();
    let mut bytes = fixture("plain.mat")[..128].to_vec();
    bytes.extend([15_u32.to_le_bytes(), (packed.len() as u32).to_le_bytes()].concat());
    bytes.extend(packed);
    mat::parse(Source {
        name: source.name,
        bytes: &bytes,
    })
    .map(drop)
}

#[test]
fn damaged_files_are_answered_within_bounds() {
    let substructure = || {
        abaqus::parse_substructure(Source {
            name: "",
            bytes: &fixture("two_hexes.mtx"),
        })
        .unwrap()
    };
    let size = substructure().dofs.len();
    let full = Substructure {
        loads: BTreeMap::from([("BOLT".to_owned(), vec![1.5; size])]),
        recovery: Some(abaqus::Recovery {
            matrix: matrix_files::value::Dense::try_new(2, size, vec![0.5; 2 * size]).unwrap(),
            heading: vec!["** 77, 78".into()],
        }),
        ..substructure()
    };
    let matlab: Reader = |s| mat::parse(s).map(drop);
    let numpy: Reader = |s| npz::parse(s).map(drop);
    let market: Reader = |s| matrix_market::parse(s).map(drop);
    let output4: Reader = |s| op4::parse(s).map(drop);
    let output2: Reader = |s| op2::parse(s).map(drop);
    let assembled: Reader = |s| ansys::parse(s).map(drop);
    let points: Reader = |s| dmig::parse(s).map(drop);
    let reduced: Reader = |s| abaqus::parse_substructure(s).map(drop);
    // What a byte of the file may become: compressed files hold up to 1032 bytes in one.
    const PLAIN: usize = 64;
    const COMPRESSED: usize = 64 * 1032;
    // What may come on top: messages; buffers for unpacking, and starts for 2^20 rows, which even a short file may
    // have.
    const LITTLE: usize = 1 << 12;
    const SPARSE: usize = (1 << 18) + 2 * 8 * (1 << 20);
    let files: [(&str, Vec<u8>, usize, usize, Reader); 38] = [
        ("plain.mat", fixture("plain.mat"), PLAIN, SPARSE, matlab),
        ("compressed.mat", fixture("compressed.mat"), COMPRESSED, SPARSE, matlab),
        ("v73.mat", fixture("v73.mat"), COMPRESSED, SPARSE, matlab),
        ("octave_v6.mat", fixture("octave_v6.mat"), PLAIN, SPARSE, matlab),
        ("plain.npz", fixture("plain.npz"), PLAIN, SPARSE, numpy),
        ("compressed.npz", fixture("compressed.npz"), COMPRESSED, SPARSE, numpy),
        ("csc.npz", fixture("csc.npz"), PLAIN, SPARSE, numpy),
        ("csr.npz", fixture("csr.npz"), COMPRESSED, SPARSE, numpy),
        (
            "sparse element",
            fixture("plain.mat")[128..304].to_vec(),
            PLAIN,
            2 * SPARSE,
            matlab_around,
        ),
        (
            "structure element",
            fixture("plain.mat")[848..1152].to_vec(),
            PLAIN,
            2 * SPARSE,
            matlab_around,
        ),
        ("shape.npy", member("shape.npy"), PLAIN, SPARSE, |s| {
            numpy_with("shape.npy", s)
        }),
        ("indptr.npy", member("indptr.npy"), PLAIN, SPARSE, |s| {
            numpy_with("indptr.npy", s)
        }),
        ("indices.npy", member("indices.npy"), PLAIN, SPARSE, |s| {
            numpy_with("indices.npy", s)
        }),
        ("format.npy", member("format.npy"), PLAIN, SPARSE, |s| {
            numpy_with("format.npy", s)
        }),
        ("symmetric.mtx", fixture("symmetric.mtx"), PLAIN, SPARSE, market),
        ("array.mtx", fixture("array.mtx"), PLAIN, LITTLE, market),
        ("integer.mtx", fixture("integer.mtx"), PLAIN, LITTLE, market),
        ("two_hexes.mtx", fixture("two_hexes.mtx"), PLAIN, LITTLE, reduced),
        (
            "all sections",
            abaqus::substructure_to_bytes(&full).unwrap(),
            PLAIN,
            LITTLE,
            reduced,
        ),
        (
            "assembled",
            b"1,1, 1,1, 2.5\n2,3, 1,1, -1.0E+5\n-1,1, -1,1, 7.\n".to_vec(),
            PLAIN,
            LITTLE,
            |s| abaqus::parse_assembled(&[("STIFFNESS", s)]).map(drop),
        ),
        ("sti", b"1 1 2.0\n1 2 -1.0\n2 2 3.0\n".to_vec(), PLAIN, LITTLE, |s| {
            calculix_with(0, s)
        }),
        ("mas", b"1 1 2.0\n1 2 -1.0\n2 2 3.0\n".to_vec(), PLAIN, LITTLE, |s| {
            calculix_with(1, s)
        }),
        ("dof", b"7.1\n7.2\n".to_vec(), PLAIN, LITTLE, |s| calculix_with(2, s)),
        ("dense.op4", fixture("dense.op4"), PLAIN, SPARSE, output4),
        ("bigmat.op4", fixture("bigmat.op4"), PLAIN, SPARSE, output4),
        ("strings.op4", fixture("strings.op4"), PLAIN, SPARSE, output4),
        ("dense_be.op4", fixture("dense_be.op4"), PLAIN, SPARSE, output4),
        ("bigmat_be.op4", fixture("bigmat_be.op4"), PLAIN, SPARSE, output4),
        ("strings_le.op4", fixture("strings_le.op4"), PLAIN, SPARSE, output4),
        ("wide_le.op4", fixture("wide_le.op4"), PLAIN, SPARSE, output4),
        ("blocks_le.op2", fixture("blocks_le.op2"), PLAIN, SPARSE, output2),
        ("blocks_be.op2", fixture("blocks_be.op2"), PLAIN, SPARSE, output2),
        ("blocks_wide.op2", fixture("blocks_wide.op2"), PLAIN, SPARSE, output2),
        ("tables.op2", fixture("tables.op2"), PLAIN, SPARSE, output2),
        ("external.op2", fixture("external.op2"), PLAIN, SPARSE, output2),
        ("small.full", fixture("small.full"), PLAIN, SPARSE, assembled),
        ("pyyeti.pch", fixture("pyyeti.pch"), PLAIN, SPARSE, points),
        ("pynastran.bdf", fixture("pynastran.bdf"), PLAIN, SPARSE, points),
    ];
    let fragments: [&[u8]; 5] = [
        b"*MATRIX,TYPE=MASS\n",
        b"** ",
        b"DMIG,A,0,9,1,,,,3\n",
        b",9,1,2.0,",
        &[24, 0, 0, 0],
    ];
    let mut damage = Damage::new(5, &fragments);
    for (name, sound, factor, base, read) in files {
        let sample = Sample {
            name,
            sound: &sound,
            memory: [factor, base],
            copies: 3000,
        };
        let read = |bytes: &[u8]| read(Source { name, bytes });
        let Tally { refused, accepted } = damage.trial(&sample, <[u8]>::to_vec, read, |(), _| {});
        // The damage is neither always fatal nor never.
        assert!(
            refused > accepted / 10 && accepted > 0,
            "{name}: {refused} refused, {accepted} read"
        );
    }
}
