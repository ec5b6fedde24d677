//! All readers on the same bytes: `cargo +nightly fuzz run readers`, with the files of `tests/fixtures` as seeds.
#![no_main]

use libfuzzer_sys::fuzz_target;
use file_io::Source;
use matrix_files::{abaqus, ansys, calculix, dmig, mat, matrix_market, npz, op2, op4};

fuzz_target!(|bytes: &[u8]| {
    let source = Source { name: "fuzzed", bytes };
    let _ = mat::parse(source);
    let _ = npz::parse(source);
    let _ = matrix_market::parse(source);
    let _ = op4::parse(source);
    let _ = op2::parse(source);
    let _ = ansys::parse(source);
    let _ = dmig::parse(source);
    let _ = abaqus::parse_substructure(source);
    let _ = abaqus::parse_assembled(&[("STIFFNESS", source)]);
    let dofs = Source {
        name: "sound",
        bytes: b"7.1\n7.2\n",
    };
    for files in [
        calculix::Files {
            stiffness: source,
            mass: source,
            dofs,
        },
        calculix::Files {
            stiffness: dofs,
            mass: dofs,
            dofs: source,
        },
    ] {
        let _ = calculix::parse(files);
    }
});
