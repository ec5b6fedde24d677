//! Damaged mesh files: errors, no panics, and memory in proportion to the file.

use finite_elements::formats::solid_mesh::{Format, SolidMesh};
use std::path::Path;
use test_support::memory::Counting;
use test_support::{Damage, Sample};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const FILES: [&str; 22] = [
    "tet4.msh",
    "tet4-binary.msh",
    "hex20-22.msh",
    "tet4-22-binary.msh",
    "tet4.inp",
    "meshio.inp",
    "prepomax.inp",
    "tet4.vtu",
    "wedge6.vtu",
    "vtk-appended.vtu",
    "vtk-base64.vtu",
    "meshio-text.vtu",
    "tet4.bdf",
    "tet4-free.bdf",
    "tet4-large.bdf",
    "coordinates.bdf",
    "hex8.cdb",
    "wedge15.cdb",
    "hex8.unv",
    "tet4.exo",
    "tet10.exo",
    "hex8.med",
];

#[test]
fn damaged_files_are_read_or_refused_within_bounds() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let mut damage = Damage::new(
        31,
        &[
            b" 0 ",
            b"18446744073709551615",
            b"4294967296",
            b"$End",
            b"*ELEMENT, TYPE=S4\n",
            b"</Cells>",
            b"=",
            b"CORD1R,1,2,3,4\n",
            b" -99999999",
            b"    -1\n",
        ],
    );
    for name in FILES {
        let sound = std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let Ok(format) = Format::of(Path::new(name)) else {
            panic!("{name}")
        };
        let whole = SolidMesh::from_bytes(name, format, &sound).unwrap_or_else(|error| panic!("{error}"));
        let end = sound.trim_ascii_end().len();
        for length in (0..end).step_by(50) {
            match SolidMesh::from_bytes(name, format, &sound[..length]) {
                Err(error) => assert!(error.to_string().starts_with(name), "{error}"),
                // Some formats have no end that could be missing: cut between two lines they are a smaller mesh.
                Ok(cut) => {
                    let between = sound[length - 1] == b'\n' || !data_line(&sound[..length]);
                    assert!(
                        !matches!(format, Format::Gmsh | Format::Vtu | Format::Exodus | Format::Med)
                            && between
                            && cut.cells.len() <= whole.cells.len(),
                        "{name}: {length}"
                    );
                }
            }
        }
        let sample = Sample {
            name,
            sound: &sound,
            memory: [300, 8 << 20],
            copies: 400,
        };
        let tally = damage.trial(
            &sample,
            <[u8]>::to_vec,
            |bytes| SolidMesh::from_bytes(name, format, bytes),
            |mesh, _| {
                assert_eq!(mesh.bodies().len(), mesh.cells.len());
                for (face, cell) in mesh.boundary() {
                    assert!(mesh.cells[cell as usize].nodes().contains(&face.nodes()[0]));
                }
            },
        );
        assert!(tally.refused > 50, "{name}: {tally:?}");
    }
}

/// Whether the last line is no keyword and no comment.
fn data_line(bytes: &[u8]) -> bool {
    let line = bytes.rsplit(|byte| *byte == b'\n').next().unwrap_or_default();
    !line.starts_with(b"*")
}
