//! Writing VTK files.

use super::field::{Encoding, Field, MATERIAL};
use crate::Error;
use crate::formats::common::{check, check_nodes, check_positions};
use crate::mesh::{Face, Mesh};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use quick_xml::escape::escape;
use std::collections::BTreeSet;
use std::fmt::{Debug, Write};

/// Writes a mesh with fields. What [`super::read`] makes of the result, given the same materials, is the same mesh to the last
/// bit, except for nodes without solids and for the formulation of hexahedra, which the format cannot carry.
///
/// # Errors
/// [`Error::Dangling`] and [`Error::NotFinite`] for broken meshes; [`Error::MeshUnwritable`] for fields of the wrong
/// length, for names that appear twice or hold control characters, and for infinities as text.
pub fn write(mesh: &Mesh, point_fields: &[Field], cell_fields: &[Field], encoding: Encoding) -> Result<String, Error> {
    check(mesh)?;
    let cells: Vec<Cell> = mesh
        .elements
        .iter()
        .map(|element| {
            let row = &element.cell.element_type().vtk;
            (row.number, row.to_file(element.cell.nodes()))
        })
        .collect();
    let materials: Vec<u16> = mesh.elements.iter().map(|element| element.material).collect();
    let fields = [point_fields, cell_fields];
    document(&mesh.nodes, &cells, Some(&materials), fields, encoding)
}

/// Writes a surface with fields of its nodes and faces: cell types 5, 9 and 22 (triangle, quadrilateral, quadratic
/// triangle). A plane surface has the third coordinate zero.
///
/// # Errors
/// [`Error::Dangling`] for faces that refer to missing nodes, [`Error::NotFinite`] for coordinates, and
/// [`Error::MeshUnwritable`] as for [`write()`].
pub fn write_surface(
    nodes: &[[f64; 3]],
    faces: &[Face],
    point_fields: &[Field],
    face_fields: &[Field],
    encoding: Encoding,
) -> Result<String, Error> {
    check_positions(nodes)?;
    for (number, face) in faces.iter().enumerate() {
        check_nodes(&format!("face {number}"), face.nodes(), nodes.len())?;
    }
    let cells: Vec<Cell> = faces
        .iter()
        .map(|face| (face.face_type().vtk, face.nodes().to_vec()))
        .collect();
    document(nodes, &cells, None, [point_fields, face_fields], encoding)
}

/// Cell type and points.
type Cell = (u8, Vec<u32>);

fn document(
    nodes: &[[f64; 3]],
    cells: &[Cell],
    materials: Option<&[u16]>,
    [point_fields, cell_fields]: [&[Field]; 2],
    encoding: Encoding,
) -> Result<String, Error> {
    check_fields(point_fields, "point", "Points", nodes.len(), encoding)?;
    check_fields(cell_fields, "cell", MATERIAL, cells.len(), encoding)?;
    let mut out = String::from("<?xml version=\"1.0\"?>\n");
    out += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
    out += "<UnstructuredGrid>\n";
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">",
        nodes.len(),
        cells.len()
    );
    let mut write = Arrays { out, encoding };
    write.out += "<PointData>\n";
    point_fields.iter().for_each(|field| write.field(field));
    write.out += "</PointData>\n<CellData>\n";
    if let Some(materials) = materials {
        write.array("UInt16", MATERIAL, 1, materials.iter().copied(), u16::to_le_bytes);
    }
    cell_fields.iter().for_each(|field| write.field(field));
    write.out += "</CellData>\n<Points>\n";
    let coordinates = nodes.iter().flatten().copied();
    write.array("Float64", "Points", 3, coordinates, f64::to_le_bytes);
    write.out += "</Points>\n<Cells>\n";
    let connectivity = cells.iter().flat_map(|(_, nodes)| nodes);
    let connectivity = connectivity.map(|node| i64::from(*node));
    write.array("Int64", "connectivity", 1, connectivity, i64::to_le_bytes);
    let offsets = cells.iter().scan(0_i64, |end, (_, nodes)| {
        *end += nodes.len() as i64;
        Some(*end)
    });
    write.array("Int64", "offsets", 1, offsets, i64::to_le_bytes);
    let types = cells.iter().map(|(cell_type, _)| *cell_type);
    write.array("UInt8", "types", 1, types, u8::to_le_bytes);
    write.out += "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    Ok(write.out)
}

/// Checks lengths, names and values; `reserved` is a name that the file itself uses.
fn check_fields(fields: &[Field], what: &str, reserved: &str, count: usize, encoding: Encoding) -> Result<(), Error> {
    let mut names = BTreeSet::from([reserved]);
    for field in fields {
        let right = field.components > 0 && field.components.checked_mul(count) == Some(field.values.len());
        let reason = if !right {
            format!(
                "it has {} values, but there are {count} {what}s of {} components",
                field.values.len(),
                field.components
            )
        } else if !names.insert(&field.name) {
            "another array has this name; names must differ".into()
        } else if field.name.chars().any(char::is_control) {
            "names must be free of control characters".into()
        } else if encoding == Encoding::Ascii && field.values.iter().any(|value| value.is_infinite()) {
            "it holds infinities, whose sign VTK loses in text; use base64".into()
        } else {
            continue;
        };
        return Err(Error::MeshUnwritable {
            what: format!("{what} field {:?}", field.name),
            reason,
        });
    }
    Ok(())
}

/// A file while its arrays are written.
struct Arrays {
    out: String,
    encoding: Encoding,
}

impl Arrays {
    fn field(&mut self, field: &Field) {
        let values = field.values.iter().copied();
        self.array("Float64", &field.name, field.components, values, f64::to_le_bytes);
    }

    /// Debug text is the shortest that reads back as the same number, with an exponent where that is shorter.
    fn array<T: Debug, const N: usize>(
        &mut self,
        kind: &str,
        name: &str,
        components: usize,
        values: impl Iterator<Item = T>,
        bytes: impl Fn(T) -> [u8; N],
    ) {
        let format = match self.encoding {
            Encoding::Ascii => "ascii",
            Encoding::Base64 => "binary",
        };
        let (out, name) = (&mut self.out, escape(name));
        let _ = writeln!(
            out,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"{format}\">"
        );
        match self.encoding {
            Encoding::Ascii => {
                for (number, value) in (1..).zip(values) {
                    let end = if number % components == 0 { '\n' } else { ' ' };
                    let _ = write!(out, "{value:?}{end}");
                }
            }
            Encoding::Base64 => {
                let mut raw = vec![0; 8];
                raw.extend(values.flat_map(bytes));
                let length = raw.len() as u64 - 8;
                raw[..8].copy_from_slice(&length.to_le_bytes());
                STANDARD.encode_string(&raw, out);
                out.push('\n');
            }
        }
        *out += "</DataArray>\n";
    }
}
