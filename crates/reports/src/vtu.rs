//! Interface meshes with element fields as VTK XML files.

use crate::fields::CellField;
use crate::markup::escape;
use std::fmt::{Display, Write};
use zte_assembly::InterfaceMesh;

/// The interface as an ASCII unstructured grid with the given cell data.
pub fn document(mesh: &InterfaceMesh, cells: &[CellField]) -> String {
    let (nodes, elements) = (&mesh.nodes, &mesh.elements);
    let mut out = String::from("<?xml version=\"1.0\"?>\n");
    out += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
    out += "<UnstructuredGrid>\n";
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">",
        nodes.len(),
        elements.len()
    );
    out += "<Points>\n";
    let coordinates = nodes.iter().map(|[x, y]| format!("{x:e} {y:e} 0"));
    array(&mut out, "Float64", "Points", " NumberOfComponents=\"3\"", coordinates);
    out += "</Points>\n<Cells>\n";
    let connectivity = elements
        .iter()
        .map(|e| e.nodes().iter().map(u32::to_string).collect::<Vec<_>>().join(" "));
    array(&mut out, "Int64", "connectivity", "", connectivity);
    let offsets = elements.iter().scan(0, |end, e| {
        *end += e.nodes().len();
        Some(*end)
    });
    array(&mut out, "Int64", "offsets", "", offsets);
    // VTK_TRIANGLE and VTK_QUAD.
    array(
        &mut out,
        "UInt8",
        "types",
        "",
        elements.iter().map(|e| if e.nodes().len() == 3 { 5 } else { 9 }),
    );
    out += "</Cells>\n<CellData>\n";
    for cell in cells {
        array(
            &mut out,
            "Float64",
            cell.name,
            "",
            cell.values.iter().map(|v| format!("{v:e}")),
        );
    }
    out += "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    out
}

fn array<T: Display>(out: &mut String, kind: &str, name: &str, more: &str, values: impl Iterator<Item = T>) {
    let _ = writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{}\"{more} format=\"ascii\">",
        escape(name)
    );
    for value in values {
        let _ = writeln!(out, "{value}");
    }
    *out += "</DataArray>\n";
}
