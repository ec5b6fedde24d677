//! Solid meshes of all formats. `data/generate_meshes.py` tells how the files were made: two boxes of 20 x 10 x 5 and
//! 20 x 10 x 4 that touch at z = 5, each with nodes of its own.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use finite_elements::Error;
use finite_elements::elements::{ElementType, HEX8, HEX20, HEX27, TET4, TET10, WEDGE6, WEDGE15, matrices};
use finite_elements::formats::abaqus::{self, Choices};
use finite_elements::formats::solid_mesh::{Format, SolidMesh};
use finite_elements::mesh::{Cell, Face, Material};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use test_support::TemporaryFolder;

pub(crate) const SHAPES: [(&str, &ElementType); 7] = [
    ("tet4", &TET4),
    ("tet10", &TET10),
    ("wedge6", &WEDGE6),
    ("wedge15", &WEDGE15),
    ("hex8", &HEX8),
    ("hex20", &HEX20),
    ("hex27", &HEX27),
];

pub(crate) fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

pub(crate) fn mesh(name: &str) -> SolidMesh {
    SolidMesh::read(&path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

pub(crate) fn text(name: &str) -> String {
    std::fs::read_to_string(path(name)).unwrap()
}

pub(crate) fn parse(format: Format, text: &str) -> Result<SolidMesh, Error> {
    SolidMesh::from_bytes("mesh", format, text.as_bytes())
}

pub(crate) fn message(result: Result<SolidMesh, Error>) -> String {
    result.unwrap_err().to_string()
}

pub(crate) fn with(text: &str, old: &str, new: &str) -> String {
    assert!(text.contains(old), "{old}");
    text.replacen(old, new, 1)
}

pub(crate) fn volume(mesh: &SolidMesh, cells: impl IntoIterator<Item = u32>) -> f64 {
    let unit = Material {
        name: "unit".into(),
        youngs_modulus: 1.0,
        poisson_ratio: 0.0,
        density: 1.0,
    };
    let of_cell = |cell: u32| {
        let cell = &mesh.cells[cell as usize];
        let x: Vec<[f64; 3]> = cell.nodes().iter().map(|node| mesh.nodes[*node as usize]).collect();
        // Fails on Jacobians that are not positive.
        matrices(0, cell, &x, &unit).unwrap().mass.iter().sum::<f64>()
    };
    cells.into_iter().map(of_cell).sum()
}

/// Vector area of plane faces.
pub(crate) fn area(mesh: &SolidMesh, faces: &[Face]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for face in faces {
        let x: Vec<[f64; 3]> = face.corners().iter().map(|node| mesh.nodes[*node as usize]).collect();
        for (i, a) in x.iter().enumerate() {
            let b = x[(i + 1) % x.len()];
            for c in 0..3 {
                let (d, e) = ((c + 1) % 3, (c + 2) % 3);
                sum[c] += 0.5 * (a[d] * b[e] - a[e] * b[d]);
            }
        }
    }
    sum
}

pub(crate) fn assert_near(name: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{name}");
    for (a, b) in found.iter().zip(expected) {
        assert!(
            (a - b).abs() < 1e-9 * (1.0 + b.abs()),
            "{name}: {found:?} is not {expected:?}"
        );
    }
}

/// Positions of the nodes of every cell in the cell's order, whatever the numbering; rounded, since formats differ in digits.
pub(crate) fn geometry(mesh: &SolidMesh) -> BTreeSet<Vec<[i64; 3]>> {
    let at = |node: &u32| mesh.nodes[*node as usize].map(|x| (x * 1e6).round() as i64);
    mesh.cells
        .iter()
        .map(|cell| cell.nodes().iter().map(at).collect())
        .collect()
}

pub(crate) fn names<T>(groups: &[finite_elements::mesh::Group<T>]) -> Vec<&str> {
    groups.iter().map(|group| group.name.as_str()).collect()
}

#[test]
fn every_element_is_read_alike_from_every_format() {
    for (name, row) in SHAPES {
        let first = mesh(&format!("{name}.msh"));
        let mut others = vec![format!("{name}-22.msh")];
        if name != "hex27" {
            others.push(format!("{name}.inp"));
        }
        if name != "wedge15" {
            others.push(format!("{name}.vtu"));
        }
        for file in [format!("{name}.msh")].into_iter().chain(others) {
            let mesh = mesh(&file);
            assert!(mesh.cells.iter().all(|cell| cell.element_type() == row), "{file}");
            assert_eq!(mesh.labels.len(), mesh.nodes.len(), "{file}");
            assert_eq!(mesh.nodes.len(), first.nodes.len(), "{file}");
            assert_eq!(mesh.cells.len(), first.cells.len(), "{file}");
            assert_eq!(geometry(&mesh), geometry(&first), "{file}");
            let bodies = mesh.bodies();
            assert_eq!(bodies[0], 0, "{file}");
            let of_body = |body: u32| (0..mesh.cells.len() as u32).filter(move |cell| bodies[*cell as usize] == body);
            let of_bodies =
                [of_body.clone()(0), of_body.clone()(1), of_body.clone()(2)].map(|body| volume(&mesh, body));
            assert_near(&file, &of_bodies, &[1000.0, 800.0, 0.0]);

            let boundary: Vec<Face> = mesh.boundary().into_iter().map(|(face, _)| face).collect();
            assert_near(&file, &area(&mesh, &boundary), &[0.0; 3]);
            let size = |face: &Face| area(&mesh, &[*face]).iter().map(|a| a * a).sum::<f64>().sqrt();
            let total: f64 = boundary.iter().map(size).sum();
            assert_near(
                &file,
                &[total],
                &[2.0 * (200.0 + 100.0 + 50.0) + 2.0 * (200.0 + 80.0 + 40.0)],
            );
            for (face, cell) in mesh.boundary() {
                assert!(mesh.cells[cell as usize].faces().any(|known| known == face), "{file}");
            }

            // Volumes, surfaces and points by name, in any case; meshio knows the numbers of Gmsh.
            let vtu = file.ends_with(".vtu");
            let known = |name: &str, tag: u32| match vtu {
                true => format!("gmsh:physical={tag}"),
                false if file.ends_with(".inp") => name.replace(' ', "_"),
                false => name.to_owned(),
            };
            let lower = mesh.volume(&known("lower", 1)).unwrap();
            assert_near(&file, &[volume(&mesh, lower.iter().copied())], &[1000.0]);
            assert!(lower.windows(2).all(|pair| pair[0] < pair[1]), "{file}");
            if !vtu {
                let both = mesh.volume("both").unwrap();
                assert_eq!(both.len(), mesh.cells.len(), "{file}");
                assert_eq!(both, mesh.volume("BOTH").unwrap());
            }
            let faces = mesh.surface(&known("lower face", 4)).unwrap();
            assert_near(&file, &area(&mesh, faces), &[0.0, 0.0, 200.0]);
            let faces = mesh.surface(&known("upper face", 5)).unwrap();
            assert_near(&file, &area(&mesh, faces), &[0.0, 0.0, -200.0]);
            assert!(faces.iter().all(|face| boundary.contains(face)), "{file}");
            let edge = mesh.points(&known("edge", 6)).unwrap();
            assert!(edge.len() >= 3, "{file}");
            assert!(
                edge.iter().all(|node| mesh.nodes[*node as usize][1..] == [0.0; 2]),
                "{file}"
            );
            let corner = mesh.points(&known("corner", 7)).unwrap();
            assert_eq!(
                corner.iter().map(|node| mesh.nodes[*node as usize]).collect::<Vec<_>>(),
                [[0.0; 3]]
            );
        }
    }
}

#[test]
fn versions_and_encodings_of_gmsh_are_the_same_mesh() {
    for name in ["tet4", "hex20"] {
        let first = mesh(&format!("{name}.msh"));
        assert_eq!(names(&first.volumes), ["lower", "upper", "both"]);
        assert_eq!(names(&first.surfaces), ["lower face", "upper face"]);
        assert_eq!(names(&first.points), ["corner", "edge"]);
        assert!(first.notes.is_empty(), "{:?}", first.notes);
        for other in ["-binary", "-22", "-22-binary"] {
            let other = mesh(&format!("{name}{other}.msh"));
            assert_eq!(other.cells, first.cells);
            assert_eq!(other.labels, first.labels);
            for (a, b) in other.nodes.iter().flatten().zip(first.nodes.iter().flatten()) {
                assert!((a - b).abs() < 1e-12);
            }
            assert_eq!((&other.volumes, &other.points), (&first.volumes, &first.points));
            assert_eq!(other.surfaces, first.surfaces);
        }
    }
}

#[test]
fn files_without_groups_are_solids_alone() {
    for name in ["no-groups.msh", "no-groups-22.msh"] {
        let read = mesh(name);
        assert_eq!(geometry(&read), geometry(&mesh("tet4.msh")), "{name}");
        assert!(
            read.volumes.is_empty() && read.surfaces.is_empty() && read.points.is_empty(),
            "{name}"
        );
        assert!(read.notes[0].ends_with("points, lines and faces that are in no physical group are skipped"));
        let error = read.surface("top").unwrap_err().to_string();
        assert_eq!(error, format!("{name} has no surface `top`; it has none"));
    }
}

#[test]
fn names_that_are_not_there_are_answered_with_those_that_are() {
    let error = mesh("tet4.msh").surface("lower").unwrap_err().to_string();
    assert_eq!(error, "tet4.msh has no surface `lower`; it has lower face, upper face");
    let error = mesh("tet4.inp").volume("top").unwrap_err().to_string();
    assert!(
        error.contains("no volume `top`; it has BOTH, LOWER, UPPER, VOLUME1"),
        "{error}"
    );
    // The same name of a point and a curve.
    let twice = with(&text("tet4.msh"), "\"corner\"", "\"edge\"");
    let error = parse(Format::Gmsh, &twice)
        .unwrap()
        .points("edge")
        .unwrap_err()
        .to_string();
    assert!(error.contains("group `edge`: 2 groups have this name; give"), "{error}");
}

#[test]
fn a_name_as_it_stands_comes_before_one_in_another_case() {
    let file = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"Top\"\n2 2 \"top\"\n$EndPhysicalNames\n\
                $Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n$EndNodes\n$Elements\n4\n\
                1 2 2 1 1 1 2 3\n2 2 2 2 2 1 2 4\n3 4 2 0 1 1 2 3 4\n4 4 2 0 1 1 3 2 5\n$EndElements\n";
    let read = parse(Format::Gmsh, file).unwrap();
    assert_eq!(read.surface("top").unwrap().len(), 1);
    assert_eq!(read.surface("TOP").unwrap().len(), 1);
    let error = read.surface("Top").unwrap_err().to_string();
    assert!(
        error.contains("group `Top`: 1 of its 1 faces lie between two solids"),
        "{error}"
    );
}

#[test]
fn empty_groups_are_left_out_with_a_note() {
    let named = text("tet4.msh").replace("$PhysicalNames\n7\n", "$PhysicalNames\n8\n2 9 \"top \"\n");
    let read = parse(Format::Gmsh, &named).unwrap();
    assert_eq!(read.notes, ["the surface `top` is empty and left out"]);
    assert_eq!(names(&read.surfaces), ["lower face", "upper face"]);
    let set = with(
        &text("prepomax.inp"),
        "*Nset, Nset=Clamp",
        "*Elset, Elset=None\n*Nset, Nset=Clamp",
    );
    let read = parse(Format::Abaqus, &set).unwrap();
    assert_eq!(read.notes[0], "the element set `None` is empty");
    assert!(read.volume("none").is_err());
    assert!(read.points("Reference_point-1").is_err());
}

#[test]
fn decks_may_include_the_files_of_their_folder() {
    let folder = TemporaryFolder::new("solid-mesh-includes");
    let (nodes, rest) = text("prepomax.inp")
        .split_once("*Element, Type=C3D8, Elset=Lower")
        .map_or_else(
            || panic!("no elements"),
            |(nodes, rest)| (nodes.to_owned(), rest.to_owned()),
        );
    std::fs::write(folder.join("nodes.inp"), nodes).unwrap();
    let main = format!("*Include, Input=nodes.inp\n*Element, Type=C3D8, Elset=Lower{rest}");
    std::fs::write(folder.join("main.inp"), &main).unwrap();
    let read = SolidMesh::read(&folder.join("main.inp")).unwrap();
    assert_eq!(
        (&read.nodes, &read.notes),
        (&mesh("prepomax.inp").nodes, &mesh("prepomax.inp").notes)
    );
    let error = message(parse(Format::Abaqus, &main));
    assert!(error.contains("has no folder to look in"), "{error}");
}

#[test]
fn a_face_between_two_solids_is_no_surface() {
    for (name, group) in [
        ("shared.msh", "interface"),
        ("shared.inp", "interface"),
        ("shared.vtu", "gmsh:physical=4"),
    ] {
        let mesh = mesh(name);
        assert!(mesh.bodies().iter().all(|body| *body == 0), "{name}");
        assert!(
            mesh.surfaces
                .iter()
                .all(|known| !known.name.eq_ignore_ascii_case(group)),
            "{name}"
        );
        assert!(
            mesh.notes.iter().any(|note| note.contains("is no surface")),
            "{:?}",
            mesh.notes
        );
        let error = mesh.surface(group).unwrap_err().to_string();
        for part in [
            name,
            "between two solids that share their nodes",
            "do not fragment",
            "Coherence",
            "duplicate",
        ] {
            assert!(error.contains(part), "{name}: {error}");
        }
        let boundary: Vec<Face> = mesh.boundary().into_iter().map(|(face, _)| face).collect();
        assert_near(name, &area(&mesh, &boundary), &[0.0; 3]);
    }
}

#[test]
fn a_face_beside_all_solids_is_refused() {
    // The facets of another body's surface.
    let file = text("hex8-22.msh");
    let elements = file.split_once("$Elements\n").unwrap().1;
    let facet = elements.lines().find(|line| line.contains(" 3 2 4 ")).unwrap();
    let (head, last) = facet.rsplit_once(' ').unwrap();
    let other = if last == "1" { "2" } else { "1" };
    let error = message(parse(Format::Gmsh, &with(&file, facet, &format!("{head} {other}"))));
    assert!(
        error.contains("group `lower face`: 1 of its 4 faces belong to no solid; mesh the solid beside")
            || error.contains("belong to no solid"),
        "{error}"
    );
    // Of a deck it matters where the set is used.
    let file = text("prepomax.inp");
    let read = parse(Format::Abaqus, &with(&file, "3, 15, 18, 17, 16", "3, 15, 18, 17, 5")).unwrap();
    let error = read.surface("skin").unwrap_err().to_string();
    assert!(
        error.contains("group `SKIN`: 1 of its 1 faces belong to no solid"),
        "{error}"
    );
}

#[test]
fn decks_of_gmsh_and_meshio_are_meshes() {
    let gmsh = mesh("tet4.inp");
    assert_eq!(
        names(&gmsh.surfaces),
        ["LOWER_FACE", "SURFACE11", "SURFACE6", "UPPER_FACE"]
    );
    assert_eq!(
        gmsh.notes,
        ["elements that are no solids are skipped: 16 of type CPS3, 2 of type T3D2"]
    );
    // Labels of the file: points of the geometry come first.
    assert_eq!(gmsh.labels[..3], [1, 2, 3]);
    let meshio = mesh("meshio.inp");
    assert_eq!(geometry(&meshio), geometry(&gmsh));
    assert_eq!(meshio.volume("Both").unwrap().len(), meshio.cells.len());
    assert_near(
        "meshio",
        &area(&meshio, meshio.surface("lower face").unwrap()),
        &[0.0, 0.0, 200.0],
    );
    assert_eq!(meshio.points("edge").unwrap().len(), 3);
    // What meshio calls tetrahedra of 10 nodes.
    let renamed = text("tet10.inp").replace("C3D10", "C3D10MH");
    assert_eq!(
        geometry(&parse(Format::Abaqus, &renamed).unwrap()),
        geometry(&mesh("tet10.inp"))
    );
}

#[test]
fn what_a_mesh_cannot_carry_of_a_deck_is_listed() {
    let mesh = mesh("prepomax.inp");
    assert_eq!(names(&mesh.surfaces), ["LOWER_FACE", "SKIN", "UPPER_FACE"]);
    assert_near(
        "prepomax",
        &area(&mesh, mesh.surface("Lower_face").unwrap()),
        &[0.0, 0.0, 200.0],
    );
    assert_near(
        "prepomax",
        &area(&mesh, mesh.surface("Upper_face").unwrap()),
        &[0.0, 0.0, -200.0],
    );
    // Listed inwards in the file.
    assert_near(
        "prepomax",
        &area(&mesh, mesh.surface("Skin").unwrap()),
        &[0.0, 0.0, 200.0],
    );
    assert_eq!(mesh.points("clamp").unwrap().len(), 4);
    assert_eq!(mesh.points("clamp_nodes").unwrap(), mesh.points("clamp").unwrap());
    assert_eq!(mesh.labels[8], 11);
    assert_eq!(
        mesh.notes,
        [
            "elements that are no solids are skipped: 1 of type S4, 1 of type SPRING1",
            "1 *MATERIAL, 1 *DENSITY, 1 *ELASTIC, 2 *SOLID SECTION, 1 *SHELL SECTION, 1 *SPRING, 1 *TIE, 1 *RIGID BODY, \
             1 *STEP, 1 *STATIC, 2 *BOUNDARY, 2 *CLOAD are not read from a mesh; use structure.deck to keep them",
            "*EXPANSION, *OUTPUT, *NODE FILE, *EL FILE are ignored, as in decks",
            "1 node that belongs to no solid is dropped",
            "1 of the 1 nodes of the group `REFERENCE_POINT-1` belong to no solid and are left out of it",
        ]
    );
}

#[test]
fn decks_that_make_their_mesh_are_refused() {
    let file = text("prepomax.inp");
    for (old, new, expected) in [
        (
            "*Nset, Nset=Clamp",
            "*Ngen\n1, 4\n*Nset, Nset=Clamp",
            "*NGEN is not supported here: let the",
        ),
        (
            "Type=C3D8, Elset=Upper",
            "Type=C3D5, Elset=Upper",
            "element type `C3D5` is not supported",
        ),
        ("Internal-1_Lower_face_S2, S2", "Internal-1_Lower_face_S2, S7", "face"),
        (
            "C3D8, Elset=Lower",
            "S4, Elset=Lower",
            "nodes of element 1: 8 given, 4 needed",
        ),
    ] {
        let error = message(parse(Format::Abaqus, &with(&file, old, new)));
        assert!(error.starts_with("mesh:") && error.contains(expected), "{new}: {error}");
    }
    let facets = file.replace("C3D8", "S8");
    let error = message(parse(
        Format::Abaqus,
        &facets.replace(", S2", ", SPOS").replace(", S1\n", ", SPOS\n"),
    ));
    assert!(
        error.contains("the file holds no solids; mesh in three dimensions"),
        "{error}"
    );
    let cut = &file[..file.find("17, 18").unwrap() + 5];
    let error = message(parse(Format::Abaqus, cut));
    assert!(error.contains("ends in the middle of this line"), "{error}");
}

#[test]
fn decks_leave_out_facets_without_section() {
    let solids = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4,ELSET=S\n1,1,2,3,4\n\
                  *MATERIAL,NAME=M\n*ELASTIC\n2e11,0.3\n*DENSITY\n7800\n*SOLID SECTION,ELSET=S,MATERIAL=M\n";
    let facets = "*ELEMENT,TYPE=CPS3,ELSET=F\n2,1,2,3\n*ELEMENT,TYPE=T3D2,ELSET=L\n3,1,2\n4,2,3\n*ELSET,ELSET=ALL\n1,2,3\n\
                  *NSET,NSET=ON,ELSET=F\n";
    let plain = abaqus::parse(solids, "deck").unwrap();
    let deck = abaqus::parse(&[solids, facets].concat(), "deck").unwrap();
    assert_eq!(deck.elements.len(), 1);
    assert_eq!(
        deck.notes,
        ["elements that are no solids have no section and are left out: 1 of type CPS3, 2 of type T3D2"]
    );
    assert_eq!(deck.element_sets["ALL"], [0]);
    assert_eq!(deck.node_sets["ON"], [0, 1, 2]);
    let choices = Choices::default();
    assert_eq!(
        deck.assembly(&choices).unwrap().assembly,
        plain.assembly(&choices).unwrap().assembly
    );
    for (more, expected) in [
        (
            "*SOLID SECTION,ELSET=F,MATERIAL=M\n",
            "its set holds elements that are no solids",
        ),
        (
            "*SOLID SECTION,ELSET=ALL,MATERIAL=M\n",
            "its set holds elements that are no solids",
        ),
        (
            "*SHELL SECTION,ELSET=F,MATERIAL=M\n1\n",
            "*SHELL SECTION is not supported",
        ),
        (
            "*BEAM SECTION,ELSET=L,MATERIAL=M,SECTION=CIRC\n1\n",
            "set of B31 or B32 elements",
        ),
        ("*SURFACE,NAME=T\nF,SPOS\n", "elements without section have no faces"),
        (
            "*ELEMENT,TYPE=C3D4\n2,1,2,3,4\n",
            "element `2` appeared before, at deck:15",
        ),
        ("*ELEMENT,TYPE=S3\n1,1,2,3\n", "element `1` appeared before, at deck:7"),
        (
            "*ELEMENT,TYPE=SC8R\n5,1,2,3,4\n",
            "element type `SC8R` is not supported",
        ),
        (
            "*ELEMENT,TYPE=CONN3D2\n5,1,2\n",
            "element type `CONN3D2` is not supported",
        ),
    ] {
        let error = abaqus::parse(&[solids, facets, more].concat(), "deck")
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected), "{more}: {error}");
    }
}

#[test]
fn encodings_of_vtu_are_the_same_mesh() {
    let first = mesh("tet4.vtu");
    for name in ["meshio-text.vtu", "vtk-appended.vtu", "vtk-base64.vtu", "vtk-text.vtu"] {
        let other = mesh(name);
        assert_eq!((&other.cells, &other.labels), (&first.cells, &first.labels), "{name}");
        assert_eq!(geometry(&other), geometry(&first), "{name}");
        assert_eq!(
            (&other.volumes, &other.surfaces),
            (&first.volumes, &first.surfaces),
            "{name}"
        );
        assert_eq!(other.points, first.points, "{name}");
    }
    assert_eq!(names(&first.volumes)[..2], ["gmsh:physical=1", "gmsh:physical=2"],);
}

#[test]
fn a_value_alone_names_a_group_of_the_only_array() {
    let file = text("meshio-text.vtu");
    let two = parse(Format::Vtu, &file).unwrap();
    assert!(matches!(two.volume("1"), Err(Error::NotInMesh { .. })));
    // Arrays that are no integers make no groups.
    let at = file.find("Name=\"gmsh:geometrical\"").unwrap();
    let start = file[..at].rfind("<DataArray type=\"").unwrap();
    let kind = file[start + 17..].split('"').next().unwrap();
    let one = format!(
        "{}{}",
        &file[..start + 17],
        file[start + 17..].replacen(kind, "Float64", 1)
    );
    let one = parse(Format::Vtu, &one).unwrap();
    assert_eq!(one.volume("1").unwrap(), two.volume("gmsh:physical=1").unwrap());
    assert_eq!(one.surface("4").unwrap(), two.surface("GMSH:PHYSICAL=4").unwrap());
    assert_eq!(one.points("7").unwrap().len(), 1);
    assert_eq!(one.volumes.len(), 2);
    let error = one.surface("9").unwrap_err().to_string();
    assert!(
        error.contains("no surface `9`; it has gmsh:physical=4, gmsh:physical=5"),
        "{error}"
    );
    // Without arrays the facets are skipped with a note.
    let none = file
        .replace("Int64\" Name=\"gmsh", "Float64\" Name=\"gmsh")
        .replace("Int32\" Name=\"gmsh", "Float64\" Name=\"gmsh");
    let none = parse(Format::Vtu, &none).unwrap();
    assert_eq!(
        none.notes,
        ["19 points, lines and faces that are in no group are skipped"]
    );
}

/// A tetrahedron in a VTU file, with an array of cells.
fn tetrahedron(nodes: &str, array: &str) -> String {
    format!(
        "<VTKFile type=\"UnstructuredGrid\" compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid>\
         <Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\
         <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>\
         <Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">{nodes}</DataArray>\
         <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4</DataArray>\
         <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells>\
         <CellData>{array}</CellData></Piece></UnstructuredGrid></VTKFile>"
    )
}

#[test]
fn compressed_arrays_stay_in_bounds() {
    let array = |words: &[u32]| {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let array = STANDARD.encode(bytes);
        tetrahedron(
            "0 1 2 3",
            &format!("<DataArray type=\"Int32\" Name=\"a\" format=\"binary\">{array}</DataArray>"),
        )
    };
    for (words, expected) in [
        (&[1, 0x7fff_ffff, 0, 4, 0][..], "the array `a` of more than"),
        (&[0xffff_ffff, 1, 0, 4][..], "fewer"),
        (&[0xffff_ffff, 0xffff_ffff, 0xffff_ffff][..], "fewer"),
        (&[1, 4, 0, 4, 0][..], "4 bytes in block 0 of the array `a`"),
        (&[1, 4, 0, 400, 0][..], "fewer"),
        (&[0, 0, 0, 0][..], "12 bytes"),
        (&[0, 0, 0][..], "expected 1 numbers in the array `a`, found 0"),
        (&[1][..], "fewer"),
    ] {
        let error = message(parse(Format::Vtu, &array(words)));
        assert!(error.contains(expected), "{words:?}: {error}");
    }
    let other = with(&array(&[1]), "vtkZLib", "vtkLZ4");
    let error = message(parse(Format::Vtu, &other));
    assert!(
        error.contains("compressed with `vtkLZ4DataCompressor` cannot be read; save with zlib"),
        "{error}"
    );
}

#[test]
fn cells_that_no_structure_can_be_made_of_are_refused() {
    assert!(parse(Format::Vtu, &tetrahedron("0 1 2 3", "")).is_ok());
    let error = message(parse(Format::Vtu, &tetrahedron("0 1 2 2", "")));
    assert!(error.contains("elements 0 use a node twice; mesh collapsed"), "{error}");
    // A middle node of an edge near its corner.
    let file = text("tet10.inp");
    let first = file
        .split_once("TYPE=C3D10")
        .or(file.split_once("type=C3D10"))
        .unwrap()
        .1;
    let element: Vec<&str> = first.lines().nth(1).unwrap().split(',').map(str::trim).collect();
    let line = |node: &str| {
        let start = format!("\n{node}, ");
        let at = file.find(&start).unwrap();
        file[at + 1..].lines().next().unwrap().to_owned()
    };
    let [corner, middle] = [element[1], element[5]].map(line);
    let numbers = |line: &str| -> Vec<f64> { line.split(',').skip(1).map(|x| x.trim().parse().unwrap()).collect() };
    let near: Vec<String> = numbers(&corner)
        .iter()
        .zip(numbers(&middle))
        .map(|(corner, middle)| (corner + 0.05 * (middle - corner)).to_string())
        .collect();
    let near = format!("{}, {}", middle.split(',').next().unwrap(), near.join(", "));
    let error = message(parse(
        Format::Abaqus,
        &with(&file, &format!("\n{middle}\n"), &format!("\n{near}\n")),
    ));
    assert!(
        error.contains("are inverted or flat") && error.contains("Mesh.HighOrderOptimize"),
        "{error}"
    );
    assert!(error.contains(&format!("elements {}", element[0])), "{error}");
    // The same element twice.
    let twice = with(
        &text("prepomax.inp"),
        "2, 11, 12,",
        "9, 1, 2, 3, 4, 5, 6, 7, 8\n2, 11, 12,",
    );
    let error = message(parse(Format::Abaqus, &twice));
    assert!(
        error.contains("elements 9 have the same corners as another solid"),
        "{error}"
    );
    // All of a file.
    let mirrored = text("hex8-22.msh");
    let (head, elements) = mirrored.split_once("$Elements\n").unwrap();
    let turned: Vec<String> = elements
        .lines()
        .map(|line| {
            let words: Vec<&str> = line.split(' ').collect();
            if words.len() < 12 || words[1] != "5" {
                return line.to_owned();
            }
            let n = &words[5..];
            [&words[..5], &[n[4], n[5], n[6], n[7], n[0], n[1], n[2], n[3]]]
                .concat()
                .join(" ")
        })
        .collect();
    let read = parse(Format::Gmsh, &format!("{head}$Elements\n{}\n", turned.join("\n"))).unwrap();
    assert_near("turned", &[volume(&read, 0..8)], &[1800.0]);
    assert_near(
        "turned",
        &area(&read, read.surface("lower face").unwrap()),
        &[0.0, 0.0, 200.0],
    );
    assert_eq!(
        read.notes,
        ["8 of 8 solids list their nodes in mirrored order; they are read the other way round"]
    );
}

#[test]
fn sets_of_a_mesh_may_name_what_is_not_there_and_parts_without_instance_are_named() {
    let deck = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4,ELSET=E\n1,1,2,3,4\n*NSET,NSET=REF\n1,99\n\
                *SURFACE,NAME=NONE\n";
    let read = parse(Format::Abaqus, deck).unwrap();
    assert_eq!(read.points("REF").unwrap(), [0]);
    for said in [
        "1 entries of the node set `REF` are not in the file and left out of it",
        "the surface `NONE` is empty",
    ] {
        assert!(read.notes.iter().any(|note| note == said), "{said}: {:?}", read.notes);
    }
    let part = format!("*PART,NAME=P\n{}*END PART\n", deck.split("*NSET").next().unwrap());
    let error = message(parse(Format::Abaqus, &part));
    assert!(
        error.contains("holds no solids (part `P`") && error.contains("has no instance"),
        "{error}"
    );
}

#[test]
fn solids_in_mirrored_order_are_read_the_other_way_round() {
    let sound = parse(Format::Vtu, &tetrahedron("0 1 2 3", "")).unwrap();
    let read = parse(Format::Vtu, &tetrahedron("0 2 1 3", "")).unwrap();
    assert_near("mirrored", &[volume(&read, [0])], &[volume(&sound, [0])]);
    assert_eq!(
        read.notes,
        ["1 of 1 solids list their nodes in mirrored order; they are read the other way round"]
    );
    // Faces go by numbers of the order in the file: S2 is that of the last nodes of the list.
    let deck = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n\
                *ELEMENT,TYPE=C3D8R,ELSET=E\n1,5,6,7,8,1,2,3,4\n*SURFACE,NAME=FLOOR\nE,S2\n";
    let read = parse(Format::Abaqus, deck).unwrap();
    assert_near("floor", &area(&read, read.surface("floor").unwrap()), &[0.0, 0.0, -1.0]);
    assert_near("box", &[volume(&read, [0])], &[1.0]);
}

#[test]
fn other_formats_are_refused_with_a_way_to_convert_them() {
    for (name, expected) in [
        (
            "a.cgns",
            "a.cgns: files `.cgns` are not read; convert it by Gmsh: gmsh IN -save -format msh41 -o OUT.msh",
        ),
        ("a.MESH", "files `.mesh` are not read; convert it by Gmsh"),
        ("a.vtk", "save it as one unstructured grid (.vtu)"),
        ("a.step", "is a geometry, not a mesh; mesh it by Gmsh: gmsh IN -3"),
        (
            "a",
            "give a mesh of Gmsh (.msh), Abaqus or CalculiX (.inp), Nastran (.bdf)",
        ),
    ] {
        let error = message(SolidMesh::read(Path::new(name)));
        assert!(error.contains(expected), "{error}");
    }
    let error = message(SolidMesh::read(&path("version-40.msh")));
    assert!(
        error.contains("MSH version `4` cannot be read; save as version 4.1 (gmsh -format msh41"),
        "{error}"
    );
    let error = message(SolidMesh::read(&path("missing.msh")));
    assert!(error.contains("missing.msh") && !error.contains("deck"), "{error}");
}

#[test]
fn counts_that_a_file_cannot_hold_are_refused() {
    let [new, old] = ["tet4.msh", "tet4-22.msh"].map(text);
    for (file, before, more, expected) in [
        (&old, "$Nodes\n", "9", "nodes are announced, but only"),
        (&old, "$Elements\n", "9", "elements are announced, but only"),
        (&new, "$Entities\n", "99", "points are announced, but only"),
    ] {
        let at = file.find(before).unwrap() + before.len();
        let more = format!("{}{}{}", &file[..at], more.repeat(5), &file[at..]);
        let error = message(parse(Format::Gmsh, &more));
        assert!(error.contains(expected), "{error}");
    }
    let binary = std::fs::read(path("tet4-22-binary.msh")).unwrap();
    let at = binary.windows(10).position(|window| window == b"$Elements\n").unwrap() + 10;
    let at = at + binary[at..].iter().position(|byte| *byte == b'\n').unwrap() + 1;
    for (offset, bytes, expected) in [
        (
            4,
            [0xff, 0xff, 0xff, 0x7f],
            "2147483647 elements are announced where 187 are left",
        ),
        (4, [0; 4], "0 elements are announced"),
        (8, [0xff, 0xff, 0xff, 0x7f], "end of the file"),
        (0, [99, 0, 0, 0], "element type 99 cannot be read"),
    ] {
        let mut bad = binary.clone();
        bad[at + offset..at + offset + 4].copy_from_slice(&bytes);
        let error = message(SolidMesh::from_bytes("mesh", Format::Gmsh, &bad));
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn bodies_are_numbered_by_their_first_cells() {
    // Chains that meet late: the union must not depend on the order.
    let mut read = mesh("hex8.msh");
    let first = read.bodies();
    read.cells.reverse();
    let reversed = read.bodies();
    let other: Vec<u32> = first.iter().rev().map(|body| 1 - body).collect();
    assert_eq!(reversed, other);
    read.cells = vec![
        Cell::tet4([0, 1, 2, 3]),
        Cell::tet4([7, 6, 5, 4]),
        Cell::tet4([8, 9, 3, 5]),
    ];
    assert_eq!(read.bodies(), [0, 0, 0]);
}
