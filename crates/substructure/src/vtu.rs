//! VTK unstructured grids (`.vtu`): solids with a material number per cell, and fields of points and cells.
//!
//! Cell types are 10, 12, 13 and 24 (tetrahedron, hexahedron, wedge, quadratic tetrahedron); the cell array
//! [`MATERIAL`] is the index into the materials. Node orders (VTK file formats, "Cell types") are this crate's. Only
//! the first triangle of a wedge is a matter of version: VTK 9.7 takes it counter-clockwise seen from within, as here; its
//! manual and VTK 9.3 take it from outside. Both are read, and the one with a positive volume is meant. VTK knows no
//! units: lengths are taken as metres.

use crate::Error;
use crate::error::Position;
use crate::interchange::{Kept, cell, check, find, line, quoted};
use crate::mesh::{Cell, Element, Material, Mesh};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nalgebra::Vector3;
use quick_xml::escape::escape;
use quick_xml::events::{BytesStart, Event};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::{Debug, Write};

/// Name of the cell array with the material numbers.
pub const MATERIAL: &str = "material";

/// Numbers at points or cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name.
    pub name: String,
    /// Numbers per point or cell.
    pub components: usize,
    /// `values[components * i + c]` at point or cell `i`.
    pub values: Vec<f64>,
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// As text, with as many digits as it takes to read the same numbers.
    Ascii,
    /// As base64.
    Base64,
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// Solids, with the materials that were passed in.
    pub mesh: Mesh,
    /// Fields at the nodes of the mesh.
    pub point_fields: Vec<Field>,
    /// Fields at its elements, but for [`MATERIAL`].
    pub cell_fields: Vec<Field>,
    /// Points that belong to no solid: they are dropped, since nothing would hold them.
    pub orphan_nodes: usize,
    /// Cells of dimension 0-2, which are dropped.
    pub ignored_cells: usize,
    /// Wedges whose first triangle was counter-clockwise seen from outside.
    pub reversed_wedges: usize,
    /// Arrays of points and cells that are not numbers.
    pub skipped_arrays: usize,
}

/// Dimension and number of nodes of a cell type.
fn shape(cell_type: f64) -> Option<(i32, usize)> {
    let whole = Some(cell_type as u8).filter(|whole| f64::from(*whole) == cell_type);
    Some(match whole? {
        1 => (0, 1),
        3 => (1, 2),
        21 => (1, 3),
        5 => (2, 3),
        9 => (2, 4),
        22 => (2, 6),
        10 => (3, 4),
        12 => (3, 8),
        13 => (3, 6),
        24 => (3, 10),
        _ => return None,
    })
}

fn cell_type(cell: &Cell) -> u8 {
    match cell {
        Cell::Tet4(_) => 10,
        Cell::Hex8(..) => 12,
        Cell::Wedge6(_) => 13,
        Cell::Tet10(_) => 24,
    }
}

/// Writes a mesh with fields. What [`read`] makes of the result, given the same materials, is the same mesh to the last
/// bit, except for nodes without solids and for the formulation of hexahedra, which the format cannot carry.
///
/// # Errors
/// [`Error::Dangling`] and [`Error::NotFinite`] for broken meshes; [`Error::MeshUnwritable`] for fields of the wrong
/// length, for names that appear twice or hold control characters, and for infinities as text.
pub fn write(mesh: &Mesh, point_fields: &[Field], cell_fields: &[Field], encoding: Encoding) -> Result<String, Error> {
    check(mesh)?;
    for (fields, what, count) in [
        (point_fields, "point", mesh.nodes.len()),
        (cell_fields, "cell", mesh.elements.len()),
    ] {
        let mut names = BTreeSet::from([if what == "cell" { MATERIAL } else { "Points" }]);
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
    }

    let mut out = String::from("<?xml version=\"1.0\"?>\n");
    out += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
    out += "<UnstructuredGrid>\n";
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">",
        mesh.nodes.len(),
        mesh.elements.len()
    );
    let field = |out: &mut String, field: &Field| {
        let Field {
            name,
            components,
            values,
        } = field;
        array(out, encoding, "Float64", name, *components, values.iter(), |x| {
            x.to_le_bytes()
        });
    };
    out += "<PointData>\n";
    for f in point_fields {
        field(&mut out, f);
    }
    out += "</PointData>\n<CellData>\n";
    let materials = mesh.elements.iter().map(|e| e.material);
    array(&mut out, encoding, "UInt16", MATERIAL, 1, materials, |x| {
        x.to_le_bytes()
    });
    for f in cell_fields {
        field(&mut out, f);
    }
    out += "</CellData>\n<Points>\n";
    let coordinates = mesh.nodes.iter().flatten();
    array(&mut out, encoding, "Float64", "Points", 3, coordinates, |x| {
        x.to_le_bytes()
    });
    out += "</Points>\n<Cells>\n";
    let connectivity = mesh.elements.iter().flat_map(|e| e.cell.nodes());
    array(
        &mut out,
        encoding,
        "Int64",
        "connectivity",
        1,
        connectivity.map(|node| i64::from(*node)),
        |x| x.to_le_bytes(),
    );
    let offsets = mesh.elements.iter().scan(0_i64, |end, e| {
        *end += e.cell.nodes().len() as i64;
        Some(*end)
    });
    array(&mut out, encoding, "Int64", "offsets", 1, offsets, |x| x.to_le_bytes());
    let types = mesh.elements.iter().map(|e| cell_type(&e.cell));
    array(&mut out, encoding, "UInt8", "types", 1, types, |x| x.to_le_bytes());
    out += "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    Ok(out)
}

/// Debug text is the shortest that reads back as the same number, with an exponent where that is shorter.
fn array<T: Debug, const N: usize>(
    out: &mut String,
    encoding: Encoding,
    kind: &str,
    name: &str,
    components: usize,
    values: impl Iterator<Item = T>,
    bytes: impl Fn(T) -> [u8; N],
) {
    let format = match encoding {
        Encoding::Ascii => "ascii",
        Encoding::Base64 => "binary",
    };
    let name = escape(name);
    let _ = writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"{format}\">"
    );
    match encoding {
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

/// Reads `bytes`; `file` is its name in messages. Arrays may be text, base64 or appended, little endian, uncompressed.
///
/// Without an array [`MATERIAL`] all cells have material 0, if it is the only one. Hexahedra get the default
/// formulation.
///
/// # Errors
/// [`Error::MeshSyntax`] where the format is broken; [`Error::MeshUnsupported`] for other data sets, several pieces,
/// compression, big-endian numbers and other cells; [`Error::MeshContents`] for indices without a target and files
/// without solids; [`Error::NotFinite`] for coordinates.
pub fn read(file: &str, bytes: &[u8], materials: &[Material]) -> Result<Contents, Error> {
    let reader = Reader { file, bytes };
    let mut grid = Grid::default();
    reader.document(&mut grid)?;
    reader.contents(&grid, materials)
}

/// Where the numbers of an array are.
enum Source<'a> {
    Ascii(Cow<'a, str>),
    Base64(Cow<'a, str>),
    Appended(usize),
}

struct Array<'a> {
    at: usize,
    name: String,
    kind: String,
    components: usize,
    source: Source<'a>,
}

/// What follows the underscore of the appended data.
struct Appended<'a> {
    data: &'a [u8],
    base64: bool,
}

/// The arrays of a file, not yet decoded.
#[derive(Default)]
struct Grid<'a> {
    at: usize,
    n_points: usize,
    n_cells: usize,
    big_endian: bool,
    header_64: bool,
    compressor: Option<String>,
    /// Of the sections [`SECTIONS`].
    arrays: [Vec<Array<'a>>; 4],
    appended: Option<Appended<'a>>,
}

const SECTIONS: [&str; 4] = ["Points", "Cells", "PointData", "CellData"];

struct Reader<'a> {
    file: &'a str,
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn position(&self, at: usize) -> Position {
        line(self.bytes, at)
    }

    fn syntax(&self, at: usize, expected: impl Into<String>, found: impl Into<String>) -> Error {
        Error::MeshSyntax {
            file: self.file.into(),
            at: self.position(at),
            expected: expected.into(),
            found: found.into(),
        }
    }

    fn unsupported(&self, at: usize, what: String, remedy: &'static str) -> Error {
        Error::MeshUnsupported {
            file: self.file.into(),
            at: self.position(at),
            what,
            remedy,
        }
    }

    fn inconsistent(&self, at: usize, problem: String, remedy: &'static str) -> Error {
        Error::MeshContents {
            file: self.file.into(),
            at: self.position(at),
            problem,
            remedy,
        }
    }

    fn attribute(&self, at: usize, element: &BytesStart, name: &str) -> Result<Option<String>, Error> {
        let expected = || format!("attributes as in `{name}=\"...\"`");
        let attribute = element
            .try_get_attribute(name)
            .map_err(|error| self.syntax(at, expected(), error.to_string()))?;
        attribute
            .map(|attribute| attribute.normalized_value(quick_xml::XmlVersion::Implicit1_0))
            .transpose()
            .map(|value| value.map(Cow::into_owned))
            .map_err(|error| self.syntax(at, expected(), error.to_string()))
    }

    fn count(&self, at: usize, element: &BytesStart, name: &str, default: Option<usize>) -> Result<usize, Error> {
        match (self.attribute(at, element, name)?, default) {
            (None, Some(default)) => Ok(default),
            (None, None) => Err(self.syntax(at, format!("the attribute `{name}`"), "none")),
            (Some(text), _) => text
                .trim()
                .parse()
                .map_err(|_| self.syntax(at, format!("a whole number as `{name}`"), quoted(text.as_bytes()))),
        }
    }

    /// Finds all arrays. The XML ends where appended data begins, since these need not be text.
    fn document(&self, grid: &mut Grid<'a>) -> Result<(), Error> {
        let appended = find(self.bytes, 0, b"<AppendedData");
        let head = &self.bytes[..appended.unwrap_or(self.bytes.len())];
        let head =
            str::from_utf8(head).map_err(|error| self.syntax(error.valid_up_to(), "text in UTF-8", "other bytes"))?;
        let mut xml = quick_xml::Reader::from_str(head);
        let mut path: Vec<Cow<'a, str>> = Vec::new();
        loop {
            let at = xml.buffer_position() as usize;
            let event = xml
                .read_event()
                .map_err(|error| self.syntax(xml.error_position() as usize, "well-formed XML", error.to_string()))?;
            match event {
                Event::Start(element) => {
                    self.element(at, &path, &element, grid)?;
                    path.push(Cow::Owned(element.name().as_ref().into()));
                }
                Event::Empty(element) => self.element(at, &path, &element, grid)?,
                Event::End(_) => {
                    path.pop();
                }
                Event::Text(text) => Self::text(&path, text.into_inner(), grid),
                Event::CData(text) => Self::text(&path, text.into_inner(), grid),
                Event::GeneralRef(_) if section(&path).is_some() => {
                    return Err(self.syntax(at, "numbers", "an entity reference"));
                }
                Event::Eof => break,
                _ => {}
            }
        }
        let open = usize::from(appended.is_some());
        if path.len() != open {
            let expected = path
                .last()
                .map_or("the element VTKFile".into(), |name| format!("`</{name}>`"));
            return Err(self.syntax(head.len(), expected, "the end of the file"));
        }
        if let Some(at) = appended {
            grid.appended = Some(self.appended(at)?);
        }
        Ok(())
    }

    fn appended(&self, at: usize) -> Result<Appended<'a>, Error> {
        let end = find(self.bytes, at, b">").map_or(self.bytes.len(), |end| end + 1);
        let tag = str::from_utf8(&self.bytes[at..end]).unwrap_or_default();
        let encoding = match quick_xml::Reader::from_str(tag).read_event() {
            Ok(Event::Start(element)) => self.attribute(at, &element, "encoding")?,
            _ => None,
        };
        let base64 = match encoding.as_deref() {
            Some("raw") => false,
            Some("base64") => true,
            other => {
                let found = other.map_or("none".into(), |other| quoted(other.as_bytes()));
                return Err(self.syntax(at, "the encoding `raw` or `base64`", found));
            }
        };
        let data = self.bytes[end..].trim_ascii_start();
        match data.strip_prefix(b"_") {
            Some(data) => Ok(Appended { data, base64 }),
            None => Err(self.syntax(end, "an underscore before the data", quoted(data))),
        }
    }

    fn element(
        &self,
        at: usize,
        path: &[Cow<'a, str>],
        element: &BytesStart,
        grid: &mut Grid<'a>,
    ) -> Result<(), Error> {
        let name = element.name();
        match (path.len(), name.as_ref()) {
            (0, "VTKFile") => {
                let kind = self.attribute(at, element, "type")?.unwrap_or_default();
                if kind != "UnstructuredGrid" {
                    return Err(self.unsupported(
                        at,
                        format!("a data set of type {}", quoted(kind.as_bytes())),
                        "save it as UnstructuredGrid in one file (.vtu)",
                    ));
                }
                grid.big_endian = self.attribute(at, element, "byte_order")?.as_deref() == Some("BigEndian");
                grid.compressor = self
                    .attribute(at, element, "compressor")?
                    .filter(|name| !name.is_empty());
                grid.header_64 = match self.attribute(at, element, "header_type")?.as_deref() {
                    None | Some("UInt32") => false,
                    Some("UInt64") => true,
                    Some(other) => {
                        let found = quoted(other.as_bytes());
                        return Err(self.syntax(at, "the header type `UInt32` or `UInt64`", found));
                    }
                };
            }
            (0, other) => return Err(self.syntax(at, "the element VTKFile", quoted(other.as_bytes()))),
            (2, "Piece") => {
                if grid.at > 0 {
                    return Err(self.unsupported(
                        at,
                        "a second piece".into(),
                        "merge the pieces (in ParaView: Merge Blocks, or Clean to Grid) and save again",
                    ));
                }
                grid.at = at;
                grid.n_points = self.count(at, element, "NumberOfPoints", None)?;
                grid.n_cells = self.count(at, element, "NumberOfCells", None)?;
            }
            (4, "DataArray" | "Array") => {
                let Some(section) = section(path) else {
                    return Ok(());
                };
                let format = self.attribute(at, element, "format")?;
                let source = match format.as_deref() {
                    None | Some("ascii") => Source::Ascii(Cow::Borrowed("")),
                    Some("binary") => Source::Base64(Cow::Borrowed("")),
                    Some("appended") => Source::Appended(self.count(at, element, "offset", None)?),
                    Some(other) => {
                        let found = quoted(other.as_bytes());
                        return Err(self.syntax(at, "the format `ascii`, `binary` or `appended`", found));
                    }
                };
                let array = Array {
                    at,
                    name: self.attribute(at, element, "Name")?.unwrap_or_default(),
                    kind: self.attribute(at, element, "type")?.unwrap_or_default(),
                    components: self.count(at, element, "NumberOfComponents", Some(1))?,
                    source,
                };
                grid.arrays[section].push(array);
            }
            _ => {}
        }
        Ok(())
    }

    fn text(path: &[Cow<'a, str>], text: Cow<'a, str>, grid: &mut Grid<'a>) {
        let Some(section) = section(path).filter(|_| path.len() == 5 && path[4].ends_with("Array")) else {
            return;
        };
        if let Some(Source::Ascii(all) | Source::Base64(all)) =
            grid.arrays[section].last_mut().map(|array| &mut array.source)
        {
            if all.is_empty() {
                *all = text;
            } else {
                all.to_mut().push_str(&text);
            }
        }
    }

    /// All numbers of an array.
    fn numbers(&self, grid: &Grid, array: &Array) -> Result<Vec<f64>, Error> {
        let what = format!("numbers of type {} in the array `{}`", array.kind, array.name);
        let width = match array.kind.as_str() {
            "Int8" | "UInt8" => 1,
            "Int16" | "UInt16" => 2,
            "Int32" | "UInt32" | "Float32" => 4,
            "Int64" | "UInt64" | "Float64" => 8,
            _ => return Err(self.unsupported(array.at, what, "save integers or floating-point numbers")),
        };
        let float = array.kind.starts_with("Float");
        let exact = |integer: i128| {
            let real = integer as f64;
            (real as i128 == integer).then_some(real).ok_or_else(|| {
                self.unsupported(
                    array.at,
                    format!("the integer {integer} in the array `{}`", array.name),
                    "leave out integers beyond 2^53",
                )
            })
        };
        if let Source::Ascii(text) = &array.source {
            return text
                .split_ascii_whitespace()
                .map(|word| {
                    let wrong = || self.syntax(array.at, &*what, quoted(word.as_bytes()));
                    if float {
                        word.parse().map_err(|_| wrong())
                    } else {
                        exact(word.parse().map_err(|_| wrong())?)
                    }
                })
                .collect();
        }
        let raw = self.raw(grid, array)?;
        if raw.len() % width != 0 {
            return Err(self.syntax(array.at, what, format!("{} bytes", raw.len())));
        }
        raw.chunks_exact(width)
            .map(|bytes| {
                let mut wide = [0; 8];
                wide[..width].copy_from_slice(bytes);
                let unsigned = u64::from_le_bytes(wide);
                // Two's complement of the array's width.
                let unused = 64 - 8 * width as u32;
                let signed = (unsigned << unused) as i64 >> unused;
                match (float, width) {
                    (true, 4) => Ok(f32::from_bits(unsigned as u32).into()),
                    (true, _) => Ok(f64::from_bits(unsigned)),
                    (false, _) if array.kind.starts_with('U') => exact(unsigned.into()),
                    _ => exact(signed.into()),
                }
            })
            .collect()
    }

    /// The bytes of an array that is not text, without the header that tells their number.
    fn raw(&self, grid: &Grid, array: &Array) -> Result<Vec<u8>, Error> {
        let what = format!("the array `{}`", array.name);
        if let Some(compressor) = &grid.compressor {
            return Err(self.unsupported(
                array.at,
                format!("data compressed with {}", quoted(compressor.as_bytes())),
                "save without compression (in ParaView: Compressor Type None; in meshio: compression=None), or as text",
            ));
        }
        if grid.big_endian {
            return Err(self.unsupported(
                array.at,
                "data in big-endian order".into(),
                "save as text, or in little-endian order",
            ));
        }
        let header = if grid.header_64 { 8 } else { 4 };
        let length = |bytes: &[u8]| {
            let mut wide = [0; 8];
            wide[..header].copy_from_slice(bytes.get(..header)?);
            usize::try_from(u64::from_le_bytes(wide)).ok()
        };
        let short = || self.syntax(array.at, format!("all bytes of {what}"), "fewer");
        let broken = |error: base64::DecodeError| self.syntax(array.at, format!("{what} in base64"), error.to_string());
        match (&array.source, &grid.appended) {
            (Source::Ascii(text) | Source::Base64(text), _) => {
                let text: Vec<u8> = text.bytes().filter(|byte| !byte.is_ascii_whitespace()).collect();
                let mut bytes = Vec::new();
                // Some programs encode the header by itself: then padding stands in the middle.
                for part in text.split_inclusive(|byte| *byte == b'=') {
                    if part != b"=" {
                        let padding = (4 - part.len() % 4) % 4;
                        let padded = [part, &b"=="[..padding.min(2)]].concat();
                        STANDARD.decode_vec(padded, &mut bytes).map_err(broken)?;
                    }
                }
                let announced = length(&bytes).ok_or_else(short)?;
                if bytes.len() - header != announced {
                    let found = format!("{} bytes", bytes.len() - header);
                    return Err(self.syntax(array.at, format!("{announced} bytes of {what}"), found));
                }
                bytes.drain(..header);
                Ok(bytes)
            }
            (Source::Appended(_), None) => Err(self.syntax(array.at, "appended data", "none")),
            (Source::Appended(offset), Some(appended)) => {
                let data = appended.data.get(*offset..).ok_or_else(short)?;
                if appended.base64 {
                    let characters = |bytes: usize| bytes.div_ceil(3).checked_mul(4);
                    let head = data.get(..4 * header.div_ceil(3)).ok_or_else(short)?;
                    let head = STANDARD.decode(head).map_err(broken)?;
                    let end = length(&head).and_then(|n| n.checked_add(header)).and_then(characters);
                    let all = data.get(..end.ok_or_else(short)?).ok_or_else(short)?;
                    let mut bytes = STANDARD.decode(all).map_err(broken)?;
                    bytes.drain(..header);
                    Ok(bytes)
                } else {
                    let end = length(data).and_then(|n| n.checked_add(header));
                    let all = data.get(header..end.ok_or_else(short)?).ok_or_else(short)?;
                    Ok(all.to_vec())
                }
            }
        }
    }

    /// Numbers of an array that must have `count` of them.
    fn exactly(&self, grid: &Grid, array: &Array, count: Option<usize>) -> Result<Vec<f64>, Error> {
        let numbers = self.numbers(grid, array)?;
        if count == Some(numbers.len()) {
            return Ok(numbers);
        }
        let expected = count.map_or("fewer".into(), |count| count.to_string());
        let expected = format!("{expected} numbers in the array `{}`", array.name);
        Err(self.syntax(array.at, expected, numbers.len().to_string()))
    }

    fn cells_array<'g>(&self, grid: &'g Grid<'a>, name: &str) -> Result<&'g Array<'a>, Error> {
        let array = grid.arrays[1].iter().find(|array| array.name == name);
        array.ok_or_else(|| self.syntax(grid.at, format!("the array `{name}` in `Cells`"), "none"))
    }

    fn contents(&self, grid: &Grid<'a>, materials: &[Material]) -> Result<Contents, Error> {
        if grid.at == 0 {
            return Err(self.syntax(self.bytes.len(), "the element Piece", "none"));
        }
        for (name, arrays) in SECTIONS.iter().zip(&grid.arrays) {
            let mut names = BTreeSet::new();
            if let Some(array) = arrays.iter().find(|array| !names.insert(&array.name)) {
                let problem = format!("`{name}` has two arrays `{}`", array.name);
                return Err(self.inconsistent(array.at, problem, "remove or rename one"));
            }
        }
        let points = grid.arrays[0].first();
        let points = points.ok_or_else(|| self.syntax(grid.at, "an array in `Points`", "none"))?;
        if points.components != 3 {
            let found = points.components.to_string();
            return Err(self.syntax(points.at, "3 components of `Points`", found));
        }
        let coordinates = self.exactly(grid, points, grid.n_points.checked_mul(3))?;
        if let Some(&value) = coordinates.iter().find(|x| !x.is_finite()) {
            let place = format!("{}, {}: coordinates", self.file, self.position(points.at));
            return Err(Error::NotFinite { place, value });
        }
        let coordinates: Vec<[f64; 3]> = coordinates.as_chunks().0.to_vec();
        u32::try_from(coordinates.len()).map_err(|_| {
            self.unsupported(
                points.at,
                "a mesh of more than 4294967295 nodes".into(),
                "use a coarser mesh",
            )
        })?;

        let connectivity = self.cells_array(grid, "connectivity")?;
        let nodes = self.numbers(grid, connectivity)?;
        // NaN and negative numbers fail too.
        if let Some(node) = nodes
            .iter()
            .find(|&&node| !(node >= 0.0 && node < coordinates.len() as f64 && node.fract() == 0.0))
        {
            let problem = format!(
                "a cell refers to point {node}, but there are only {}",
                coordinates.len()
            );
            return Err(self.inconsistent(connectivity.at, problem, "the file is damaged: save it again"));
        }
        let nodes: Vec<u32> = nodes.into_iter().map(|node| node as u32).collect();

        let [offsets, types] = [self.cells_array(grid, "offsets")?, self.cells_array(grid, "types")?];
        let ends = self.exactly(grid, offsets, Some(grid.n_cells))?;
        let cell_types = self.exactly(grid, types, Some(grid.n_cells))?;
        let material_array = grid.arrays[3].iter().find(|array| array.name == MATERIAL);
        let numbers = match material_array {
            Some(array) => self.exactly(grid, array, Some(grid.n_cells))?,
            None if materials.len() == 1 => vec![0.0; cell_types.len()],
            None => {
                return Err(self.inconsistent(
                    grid.at,
                    format!(
                        "the cells have no array `{MATERIAL}`, and there are {} materials",
                        materials.len()
                    ),
                    "add the array with the number of each cell's material, or pass one material for all",
                ));
            }
        };

        let mut solids = Vec::new();
        let mut start = 0;
        for (number, (cell_type, end)) in cell_types.iter().zip(&ends).enumerate() {
            let Some((dimension, n_nodes)) = shape(*cell_type) else {
                return Err(self.unsupported(
                    types.at,
                    format!("VTK cell type {cell_type} of cell {number}"),
                    "save hexahedra of 8 nodes, wedges of 6 or tetrahedra of 4 or 10",
                ));
            };
            let of_cell = nodes.get(start..start + n_nodes);
            let (Some(of_cell), true) = (of_cell, *end == (start + n_nodes) as f64) else {
                let expected = format!("offset {} after cell {number} of {n_nodes} nodes", start + n_nodes);
                return Err(self.syntax(offsets.at, expected, format!("{end} of {} indices", nodes.len())));
            };
            start += n_nodes;
            if dimension < 3 {
                continue;
            }
            let material = numbers[number];
            let known = materials.len().min(usize::from(u16::MAX) + 1);
            if !(material >= 0.0 && material < known as f64 && material.fract() == 0.0) {
                return Err(self.inconsistent(
                    material_array.unwrap_or(types).at,
                    format!("cell {number} has material {material}, but there are only {known}"),
                    "pass as many materials as the file refers to; numbers begin with 0",
                ));
            }
            solids.push((number, of_cell, material as u16));
        }
        if start != nodes.len() {
            let found = format!("{} indices", nodes.len());
            return Err(self.syntax(connectivity.at, format!("{start} indices of nodes"), found));
        }
        if solids.is_empty() {
            return Err(self.inconsistent(
                grid.at,
                "the file holds no solids".into(),
                "save a mesh of hexahedra, wedges or tetrahedra",
            ));
        }

        let kept = Kept::new(
            coordinates.len(),
            solids.iter().flat_map(|solid| solid.1.iter().copied()),
        );
        let mut mesh = Mesh {
            nodes: kept.old.iter().map(|old| coordinates[*old as usize]).collect(),
            materials: materials.to_vec(),
            ..Mesh::default()
        };
        let mut reversed_wedges = 0;
        for (_, old, material) in &solids {
            let mut new: Vec<u32> = old.iter().filter_map(|node| kept.number(*node)).collect();
            if new.len() == 6 && signed_volume(&mesh.nodes, &new) < 0.0 {
                reversed_wedges += 1;
                new.swap(1, 2);
                new.swap(4, 5);
            }
            let material = *material;
            mesh.elements.extend(cell(&new).map(|cell| Element { cell, material }));
        }

        let mut skipped_arrays = 0;
        let mut fields = |section: usize, count: usize, rows: &mut dyn Iterator<Item = usize>| {
            let rows: Vec<usize> = rows.collect();
            let mut fields = Vec::new();
            for array in &grid.arrays[section] {
                if array.name == MATERIAL && section == 3 {
                    continue;
                }
                if array.kind == "String" || array.kind == "Bit" {
                    skipped_arrays += 1;
                    continue;
                }
                let components = array.components;
                let all = self.exactly(grid, array, count.checked_mul(components))?;
                let values = rows
                    .iter()
                    .flat_map(|row| &all[row * components..(row + 1) * components]);
                fields.push(Field {
                    name: array.name.clone(),
                    components,
                    values: values.copied().collect(),
                });
            }
            Ok::<_, Error>(fields)
        };
        let point_fields = fields(2, grid.n_points, &mut kept.old.iter().map(|old| *old as usize))?;
        let cell_fields = fields(3, grid.n_cells, &mut solids.iter().map(|solid| solid.0))?;
        Ok(Contents {
            orphan_nodes: coordinates.len() - mesh.nodes.len(),
            ignored_cells: grid.n_cells - solids.len(),
            reversed_wedges,
            skipped_arrays,
            mesh,
            point_fields,
            cell_fields,
        })
    }
}

/// The section of [`SECTIONS`] that the elements of `path` lead into.
fn section(path: &[Cow<str>]) -> Option<usize> {
    let [_, grid, piece, section, ..] = path else {
        return None;
    };
    let name = SECTIONS.iter().position(|name| name == section);
    name.filter(|_| grid == "UnstructuredGrid" && piece == "Piece")
}

/// Six times the volume of a wedge, cut into tetrahedra (m^3): positive in this crate's order.
fn signed_volume(nodes: &[[f64; 3]], wedge: &[u32]) -> f64 {
    let at = |i: usize| Vector3::from(nodes[wedge[i] as usize]);
    let tetrahedron = |a, b, c| (at(a) - at(0)).dot(&(at(b) - at(0)).cross(&(at(c) - at(0))));
    tetrahedron(1, 2, 5) + tetrahedron(1, 5, 4) + tetrahedron(3, 4, 5)
}
