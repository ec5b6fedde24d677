//! Meshes of Nastran, Ansys and I-DEAS: written by Gmsh, pyNastran and mapdl-archive (`data/generate_meshes.py`).

use crate::solid_mesh::{SHAPES, area, assert_near, geometry, mesh, message, names, parse, path, text, volume, with};
use finite_elements::formats::solid_mesh::{Format, SolidMesh};
use std::collections::BTreeSet;
use test_support::TemporaryFolder;

/// The names of both bodies, of their faces and of an edge, in the files of a format.
fn groups(extension: &str) -> [&'static str; 5] {
    match extension {
        "med" => ["lower", "upper", "lower face", "upper face", "edge"],
        "unv" => ["lower", "upper", "lower_face", "upper_face", "edge"],
        "cdb" => ["LOWER", "MAT=2", "LOWER_FACE", "UPPER_FACE", "EDGE"],
        // Gmsh writes no names: numbers are those of its volumes and surfaces.
        _ => ["PSOLID=1", "PSOLID=2", "", "", "CBAR=9"],
    }
}

/// Positions of the nodes of every cell in any order.
fn unordered(mesh: &SolidMesh) -> BTreeSet<BTreeSet<[i64; 3]>> {
    let cells = geometry(mesh).into_iter();
    cells.map(|nodes| nodes.into_iter().collect()).collect()
}

/// Checks that middle nodes are in the middle of the corners that the element's type says.
fn assert_middles(file: &str, mesh: &SolidMesh) {
    for cell in &mesh.cells {
        let at = |local: usize| mesh.nodes[cell.nodes()[local] as usize];
        let row = cell.element_type();
        let corners = row.n_nodes() - row.middles.len();
        for (middle, ends) in (corners..).zip(row.middles) {
            for axis in 0..3 {
                let mean = 0.5 * (at(ends[0])[axis] + at(ends[1])[axis]);
                assert!((at(middle)[axis] - mean).abs() < 1e-6, "{file}");
            }
        }
    }
}

#[test]
fn every_element_is_read_as_from_the_mesh_that_it_came_from() {
    for (name, row) in SHAPES.into_iter().filter(|(name, _)| *name != "hex27") {
        let first = mesh(&format!("{name}.msh"));
        for extension in ["unv", "cdb", "bdf", "med"] {
            let file = format!("{name}.{extension}");
            let read = mesh(&file);
            assert!(read.cells.iter().all(|cell| cell.element_type() == row), "{file}");
            if extension == "cdb" && name.starts_with("wedge") {
                // The writer begins wedges at another corner.
                assert_eq!(unordered(&read), unordered(&first), "{file}");
            } else {
                assert_eq!(geometry(&read), geometry(&first), "{file}");
            }
            assert_middles(&file, &read);
            let [lower, upper, lower_face, upper_face, edge] = groups(extension);
            let of = |name| volume(&read, read.volume(name).unwrap().iter().copied());
            assert_near(&file, &[of(lower), of(upper)], &[1000.0, 800.0]);
            if !lower_face.is_empty() {
                let of = |name| area(&read, read.surface(name).unwrap());
                assert_near(&file, &of(lower_face), &[0.0, 0.0, 200.0]);
                assert_near(&file, &of(upper_face), &[0.0, 0.0, -200.0]);
            }
            // Wedges have another edge of this number.
            if extension != "bdf" || name.starts_with("tet") {
                let nodes = read.points(edge).unwrap();
                assert!(nodes.len() >= 3, "{file}");
                assert!(
                    nodes.iter().all(|node| read.nodes[*node as usize][1..] == [0.0; 2]),
                    "{file}"
                );
            }
        }
    }
}

#[test]
fn mirrored_solids_of_every_type_keep_their_middle_nodes() {
    for (name, _) in SHAPES.into_iter().filter(|(name, _)| *name != "hex27") {
        let upside_down: String = text(&format!("{name}.bdf"))
            .lines()
            .map(|line| match line.starts_with("GRID") {
                false => format!("{line}\n"),
                true => format!("{}{:>8.4}\n", &line[..40], -line[40..].trim().parse::<f64>().unwrap()),
            })
            .collect();
        let read = parse(Format::Nastran, &upside_down).unwrap();
        assert!(read.notes.iter().any(|note| note.contains("mirrored order")), "{name}");
        let of = |name| volume(&read, read.volume(name).unwrap().iter().copied());
        assert_near(name, &[of("PSOLID=1"), of("PSOLID=2")], &[1000.0, 800.0]);
        assert_middles(name, &read);
    }
}

#[test]
fn blocks_and_sets_of_exodus_are_read_from_both_kinds_of_netcdf() {
    for name in ["tet4", "tet10", "wedge15", "hex20", "hex27"] {
        let file = format!("{name}.exo");
        let read = mesh(&file);
        assert_eq!(geometry(&read), geometry(&mesh(&format!("{name}.msh"))), "{file}");
        let of = |name| volume(&read, read.volume(name).unwrap().iter().copied());
        // The second block has no name.
        assert_near(&file, &[of("lower"), of("BLOCK=20")], &[1000.0, 800.0]);
        let of = |name| area(&read, read.surface(name).unwrap());
        assert_near(&file, &of("SIDESET=4"), &[0.0, 0.0, 200.0]);
        assert_near(&file, &of("SIDESET=5"), &[0.0, 0.0, -200.0]);
        assert!(read.points("NODESET=6").unwrap().len() >= 3, "{file}");
    }
    let error = message(SolidMesh::from_bytes("mesh.exo", Format::Exodus, b"CDF\x07"));
    assert!(
        error.starts_with("mesh.exo") && error.contains("no netCDF file"),
        "{error}"
    );
    let bytes = std::fs::read(path("tet4.exo")).unwrap();
    let at = bytes.windows(6).position(|found| found == b"TETRA4").unwrap();
    let mut pyramids = bytes.clone();
    pyramids[at..at + 6].copy_from_slice(b"PYRAM5");
    let error = message(SolidMesh::from_bytes("mesh.exo", Format::Exodus, &pyramids));
    assert!(
        error.contains("the block `lower` of elements `PYRAM5` with 4 nodes cannot be read"),
        "{error}"
    );
}

#[test]
fn small_free_and_large_fields_are_the_same_mesh() {
    let small = mesh("tet4.bdf");
    for name in ["tet4-free.bdf", "tet4-large.bdf"] {
        let other = mesh(name);
        assert_eq!(other.cells, small.cells, "{name}");
        assert_eq!(other.nodes, small.nodes, "{name}");
        assert_eq!(other.surfaces, small.surfaces, "{name}");
    }
    // Facets of a property are a surface.
    assert_near(
        "tet4.bdf",
        &area(&small, small.surface("PSHELL=6").unwrap()),
        &[0.0, 0.0, 200.0],
    );
}

#[test]
fn nodes_in_any_coordinate_system_are_where_they_are_in_the_global_one() {
    let read = mesh("coordinates.bdf");
    assert_eq!(geometry(&read), geometry(&mesh("hex20.bdf")));
    // The file has ten digits.
    let area = |name| area(&read, read.surface(name).unwrap()).map(|a| (a * 1e6).round() / 1e6 + 0.0);
    assert_eq!(area("PLOAD4=1"), [0.0, 0.0, 200.0]);
    assert_eq!(area("PLOAD4=2"), [0.0, 0.0, -200.0]);
    assert_eq!(read.points("SPC=10").unwrap().len(), 3);
    let notes = read.notes.join("\n");
    for part in ["`PSOLID=1`", "E 210000.", "NU .3", "1 CONM2", "given by the scene"] {
        assert!(notes.contains(part), "{part}: {notes}");
    }
}

#[test]
fn names_in_comments_of_preprocessors_name_the_groups() {
    let named = format!(
        "$HMNAME PROP                   1\"beam, lower\" 4\n$ Femap Property 2 : upper\n{}",
        text("hex8.bdf")
    );
    let read = parse(Format::Nastran, &named).unwrap();
    assert!(read.volume("beam, lower").is_ok() && read.volume("Upper").is_ok());
    assert!(read.volume("PSOLID=1").is_err());
}

#[test]
fn case_control_is_skipped_and_the_data_end_where_they_say() {
    let whole = format!(
        "SOL 103\nCEND\nSPC = 1\nBEGIN BULK\n{}ENDDATA\nGRID,1,,0.,0.,0.\n",
        text("hex8.bdf")
    );
    assert_eq!(parse(Format::Nastran, &whole).unwrap().nodes, mesh("hex8.bdf").nodes);
}

#[test]
fn bulk_data_may_include_the_files_of_their_folder() {
    let folder = TemporaryFolder::new("nastran-includes");
    let whole = text("hex8.bdf");
    let (nodes, elements): (Vec<&str>, Vec<&str>) = whole.lines().partition(|line| line.starts_with("GRID"));
    std::fs::write(folder.join("nodes.bdf"), nodes.join("\n")).unwrap();
    let main = format!("INCLUDE 'nodes.bdf'\n{}\n", elements.join("\n"));
    let file = folder.join("main.bdf");
    std::fs::write(&file, &main).unwrap();
    assert_eq!(SolidMesh::read(&file).unwrap().nodes, mesh("hex8.bdf").nodes);
    assert_eq!(SolidMesh::files(&file).unwrap().len(), 2);
    let error = message(parse(Format::Nastran, &main));
    assert!(
        error.starts_with("mesh, line 1: ") && error.contains("includes another"),
        "{error}"
    );
    std::fs::write(folder.join("nodes.bdf"), "INCLUDE '../elsewhere.bdf'\n").unwrap();
    let error = message(SolidMesh::read(&file));
    assert!(
        error.starts_with("nodes.bdf, line 1: ") && error.contains("outside"),
        "{error}"
    );
}

#[test]
fn damaged_bulk_data_name_the_line_and_the_field() {
    let whole = text("hex8.bdf");
    let node = whole.lines().find(|line| line.starts_with("GRID    2 ")).unwrap();
    let solid = whole.lines().find(|line| line.starts_with("CHEXA")).unwrap();
    let cases = [
        (
            node,
            "GRID    2       0       x       0.      0.".to_owned(),
            "line 3: expected a real number in field 4 of GRID, found `x`",
        ),
        (
            node,
            "GRID    2       9       1.      0.      0.".to_owned(),
            "line 3: the coordinate system 9 is not in the file",
        ),
        (
            node,
            "GRID    1       0       1.      0.      0.".to_owned(),
            "line 3: node 1 is given twice",
        ),
        (
            node,
            "GRID,2,0,1.,0.,0.,,,,,7".to_owned(),
            "line 3: expected at most eight fields",
        ),
        (
            solid,
            solid.replacen("CHEXA  ", "CPYRAM ", 1),
            "a pyramid cannot be read; mesh solids as",
        ),
        (solid, format!("=,*1,==\n{solid}"), "repeats the one before it"),
        (
            node,
            "CORD2R  5       6       0.      0.      0.      0.      0.      1.\n+       1.      0.      0.\n\
             CORD2R  6       5       0.      0.      0.      0.      0.      1.\n+       1.      0.      0.\n\
             GRID    2       5       1.      0.      0."
                .to_owned(),
            "depends on itself",
        ),
        (
            node,
            "CORD2R  5       0       0.      0.      0.      0.      0.      1.\n+       0.      0.      2.\n\
             GRID    2       5       1.      0.      0."
                .to_owned(),
            "lie on one line",
        ),
    ];
    for (old, new, expected) in cases {
        let error = message(parse(Format::Nastran, &with(&whole, old, &new)));
        assert!(error.contains(expected), "{expected}: {error}");
    }
    let without = with(&whole, &format!("{node}\n"), "");
    let error = message(parse(Format::Nastran, &without));
    assert!(error.contains("uses the node 2, which is not in the file"), "{error}");
    let error = message(parse(Format::Nastran, "GRID,1,,0.,0.,0.\n"));
    assert!(error.contains("line 1: the file holds no solids"), "{error}");
    let pressure = format!(
        "PLOAD4  1       {}1.                              1       2\nENDDATA",
        &solid[8..16]
    );
    let pressed = with(&whole, "ENDDATA", &pressure);
    let error = message(parse(Format::Nastran, &pressed));
    assert!(error.contains("are no face of a solid"), "{error}");
}

#[test]
fn collapsed_hexahedra_of_ansys_are_wedges_and_tetrahedra() {
    let nodes = "NBLOCK,6,SOLID,6,6\n(3i9,6e21.13e3)\n        1\n        2        0        0 1.0000000000000E+000\n\
                 \u{20}       3        0        0 0.0000000000000E+000 1.0000000000000E+000\n\
                 \u{20}       4        0        0 0.0000000000000E+000 0.0000000000000E+000 1.0000000000000E+000\n\
                 \u{20}       5        0        0 1.0000000000000E+000 0.0000000000000E+000 1.0000000000000E+000\n\
                 \u{20}       6        0        0 0.0000000000000E+000 1.0000000000000E+000 1.0000000000000E+000\n\
                 N,R5.3,LOC,       -1,\n";
    let archive = |nodes_of: [u64; 8]| {
        let row: Vec<String> = [1, 1, 1, 1, 0, 0, 0, 0, 8, 0, 1]
            .iter()
            .chain(&nodes_of)
            .map(|value| format!("{value:9}"))
            .collect();
        format!(
            "*SET,kind,1\nET,kind,SOLID185\n{nodes}EBLOCK,19,SOLID,1,1\n(19i9)\n{}\n       -1\n",
            row.concat()
        )
    };
    for (nodes, kind, expected) in [
        ([1, 2, 3, 3, 4, 4, 4, 4], "Tet4", 1.0 / 6.0),
        ([1, 2, 3, 3, 4, 5, 6, 6], "Wedge6", 0.5),
    ] {
        let read = parse(Format::Ansys, &archive(nodes)).unwrap();
        assert_eq!(read.cells[0].element_type().name, kind);
        assert_near(kind, &[volume(&read, [0])], &[expected]);
    }
    let error = message(parse(Format::Ansys, &archive([1, 2, 5, 4, 6, 6, 6, 6])));
    assert!(error.contains("line 14") && error.contains("a pyramid"), "{error}");
    let unknown = archive([1, 2, 3, 3, 4, 4, 4, 4]).replace("SOLID185", "SOLID226");
    let error = message(parse(Format::Ansys, &unknown));
    assert!(error.contains("element 1 of type 226 cannot be read"), "{error}");
    let error = message(parse(Format::Ansys, &unknown.replace("ET,kind", "ET,7")));
    assert!(error.contains("the type 1, which no ET or ETBLOCK defines"), "{error}");
}

#[test]
fn blocks_without_solid_are_facets_with_the_type_of_their_second_column() {
    let whole = text("hex8.cdb");
    // The corners of a face that the component names.
    let read = mesh("hex8.cdb");
    let face = read.surface("LOWER_FACE").unwrap()[0];
    let corners: String = face
        .corners()
        .iter()
        .map(|node| format!("{:9}", read.labels[*node as usize]))
        .collect();
    let block = format!(
        "*set,cid,9\net,cid,174\neblock,10,,,1\n(15i9)\n      900        9        9        9       12{corners}\n-1\n"
    );
    let with_contact = parse(Format::Ansys, &format!("{whole}{block}")).unwrap();
    assert_eq!(with_contact.surface("TYPE=9").unwrap(), [face]);
}

#[test]
fn types_in_a_block_and_byte_order_marks_and_tabs_are_read() {
    let whole = text("hex8.cdb");
    let types: Vec<&str> = whole.lines().filter(|line| line.starts_with("ET,")).collect();
    let block = "ETBLOCK,        2,        2\n(2i9,19a9)\n        3      185        0        0\n        1      186        0\n       -1\n";
    let without = types
        .iter()
        .skip(1)
        .fold(whole.clone(), |text, line| with(&text, &format!("{line}\n"), ""));
    let read = parse(Format::Ansys, &with(&without, &format!("{}\n", types[0]), block)).unwrap();
    assert_eq!(read.cells, mesh("hex8.cdb").cells);

    let small = text("hex8.bdf");
    let tabbed: String = small
        .lines()
        .map(|line| match line.starts_with("GRID") {
            false => format!("{line}\n"),
            true => {
                let fields: Vec<&str> = line
                    .as_bytes()
                    .chunks(8)
                    .map(|f| str::from_utf8(f).unwrap().trim())
                    .collect();
                // A field of eight characters ends where the next one begins.
                let fields = fields
                    .iter()
                    .map(|f| format!("{f}{}", if f.len() < 8 { "\t" } else { "" }));
                fields.collect::<String>() + "\n"
            }
        })
        .collect();
    assert_eq!(parse(Format::Nastran, &tabbed).unwrap().nodes, mesh("hex8.bdf").nodes);
    let marked = format!("\u{feff}{}", text("hex8.inp"));
    assert_eq!(parse(Format::Abaqus, &marked).unwrap().nodes, mesh("hex8.inp").nodes);

    let groups = "    -1\n  2467\n         9         0         0         0         0         0         0         0\nnothing\n\n    -1\n";
    let read = parse(Format::Universal, &format!("{}{groups}", text("hex8.unv"))).unwrap();
    assert_eq!(read.volumes, mesh("hex8.unv").volumes);
}

#[test]
fn what_an_archive_or_universal_file_lacks_is_said() {
    let whole = text("hex8.cdb");
    for (old, new, expected) in [
        ("(3i8,6e20.13)", "(3a8)", "expected the columns of the block"),
        (
            "NBLOCK,6,SOLID",
            "N,1,0.0\nNBLOCK,6,SOLID",
            "write the archive in blocks",
        ),
        ("CMBLOCK,EDGE,NODE", "CMBLOCK,EDGE,AREA", "a component of NODE or ELEM"),
    ] {
        let error = message(parse(Format::Ansys, &with(&whole, old, new)));
        assert!(error.contains(expected), "{expected}: {error}");
    }
    let whole = text("hex8.unv");
    for (old, new, expected) in [
        (
            "  2411\n         1         1",
            "  2411\n         1         2",
            "nodes in 2 coordinate systems",
        ),
        ("D+00", "D+x0", "expected three coordinates"),
        (
            "    -1\n  2411",
            "  2411",
            "line 1: expected a line with -1 before a dataset",
        ),
    ] {
        let error = message(parse(Format::Universal, &with(&whole, old, new)));
        assert!(error.contains(expected), "{expected}: {error}");
    }
    let units = "    -1\n   164\n         5mm (milli-newton)         2\n  1.0  1.0  1.0\n  273.15\n    -1\n    -1\n  2414\n 1\n    -1\n";
    let read = parse(Format::Universal, &format!("{units}{whole}")).unwrap();
    assert!(
        read.notes.iter().any(|note| note.contains("millimetre, millinewton")),
        "{:?}",
        read.notes
    );
    assert!(
        read.notes.iter().any(|note| note.contains("datasets 2414")),
        "{:?}",
        read.notes
    );
    assert_eq!(names(&read.volumes)[..3], names(&mesh("hex8.unv").volumes)[..3]);
}

#[test]
fn other_extensions_are_told_what_to_do() {
    for (name, part) in [
        ("x.dat", "call it .bdf"),
        ("x.cgns", "convert it by Gmsh"),
        ("x.xdmf", "ParaView"),
    ] {
        let error = message(SolidMesh::read(&path(name)));
        assert!(error.contains(part), "{name}: {error}");
    }
}
