//! All readers on the same bytes: `cargo +nightly fuzz run readers`, with the files of `tests/meshes` and `tests/data` as seeds.
#![no_main]

use libfuzzer_sys::fuzz_target;
use finite_elements::formats::abaqus::{self, Choices};
use finite_elements::formats::solid_mesh::{Format, SolidMesh};
use finite_elements::formats::{gmsh, vtu};
use finite_elements::mesh::Material;

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
    for format in [
        Format::Gmsh,
        Format::Abaqus,
        Format::Vtu,
        Format::Nastran,
        Format::Ansys,
        Format::Universal,
        Format::Exodus,
        Format::Med,
    ] {
        if let Ok(mesh) = SolidMesh::from_bytes("fuzzed", format, bytes) {
            let _ = (mesh.bodies(), mesh.boundary());
        }
    }
    let _ = gmsh::read("fuzzed", bytes, &[], Some(&steel));
    let _ = vtu::read("fuzzed", bytes, &[steel]);
    let _ = vtu::read_surface("fuzzed", bytes);
});
