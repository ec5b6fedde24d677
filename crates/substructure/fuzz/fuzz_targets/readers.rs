//! All readers on the same bytes: `cargo +nightly fuzz run readers`, with the files of `tests/meshes` as seeds.
#![no_main]

use libfuzzer_sys::fuzz_target;
use substructure::formats::abaqus::{self, Choices};
use substructure::formats::{gmsh, vtu};
use substructure::mesh::Material;

fuzz_target!(|bytes: &[u8]| {
    let steel = Material {
        name: "steel".into(),
        youngs_modulus: 2e11,
        poisson_ratio: 0.3,
        density: 7800.0,
    };
    if let Ok(deck) = abaqus::parse(&String::from_utf8_lossy(bytes), "fuzzed") {
        let _ = deck.assembly(&Choices::default());
    }
    let _ = gmsh::read("fuzzed", bytes, &[], Some(&steel));
    let _ = vtu::read("fuzzed", bytes, &[steel]);
});
