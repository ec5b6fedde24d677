//! The XML of a VTK file: which arrays there are, and where their numbers stand.

use crate::Error;
use crate::error::Position;
use crate::formats::common::{find, line, quoted};
use quick_xml::events::{BytesStart, Event};
use std::borrow::Cow;

/// Where the numbers of an array are.
pub(super) enum Source<'a> {
    Ascii(Cow<'a, str>),
    Base64(Cow<'a, str>),
    Appended(usize),
}

pub(super) struct Array<'a> {
    pub(super) at: usize,
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) components: usize,
    pub(super) source: Source<'a>,
}

/// What follows the underscore of the appended data.
pub(super) struct Appended<'a> {
    pub(super) data: &'a [u8],
    pub(super) base64: bool,
}

/// The arrays of a file, not yet decoded.
#[derive(Default)]
pub(super) struct Grid<'a> {
    pub(super) at: usize,
    pub(super) n_points: usize,
    pub(super) n_cells: usize,
    pub(super) big_endian: bool,
    pub(super) header_64: bool,
    pub(super) compressor: Option<String>,
    /// Of the sections [`SECTIONS`].
    pub(super) arrays: [Vec<Array<'a>>; 4],
    pub(super) appended: Option<Appended<'a>>,
}

pub(super) const SECTIONS: [&str; 4] = ["Points", "Cells", "PointData", "CellData"];

pub(super) struct Reader<'a> {
    file: &'a str,
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(super) fn new(file: &'a str, bytes: &'a [u8]) -> Self {
        Self { file, bytes }
    }

    /// Where the file ends.
    pub(super) fn end_of_file(&self) -> usize {
        self.bytes.len()
    }

    /// A place in the file, for messages.
    pub(super) fn place(&self, at: usize) -> String {
        format!("{}, {}", self.file, self.position(at))
    }

    fn position(&self, at: usize) -> Position {
        line(self.bytes, at)
    }

    pub(super) fn syntax(&self, at: usize, expected: impl Into<String>, found: impl Into<String>) -> Error {
        Error::MeshSyntax {
            file: self.file.into(),
            at: self.position(at),
            expected: expected.into(),
            found: found.into(),
        }
    }

    pub(super) fn unsupported(&self, at: usize, what: String, remedy: impl Into<Cow<'static, str>>) -> Error {
        Error::MeshUnsupported {
            file: self.file.into(),
            at: self.position(at),
            what,
            remedy: remedy.into(),
        }
    }

    pub(super) fn inconsistent(&self, at: usize, problem: String, remedy: &'static str) -> Error {
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
    pub(super) fn document(&self, grid: &mut Grid<'a>) -> Result<(), Error> {
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
                if let Some(section) = section(path) {
                    grid.arrays[section].push(self.array(at, element)?);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn array(&self, at: usize, element: &BytesStart) -> Result<Array<'a>, Error> {
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
        Ok(Array {
            at,
            name: self.attribute(at, element, "Name")?.unwrap_or_default(),
            kind: self.attribute(at, element, "type")?.unwrap_or_default(),
            components: self.count(at, element, "NumberOfComponents", Some(1))?,
            source,
        })
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
}

/// The section of [`SECTIONS`] that the elements of `path` lead into.
fn section(path: &[Cow<str>]) -> Option<usize> {
    let [_, grid, piece, section, ..] = path else {
        return None;
    };
    let name = SECTIONS.iter().position(|name| name == section);
    name.filter(|_| grid == "UnstructuredGrid" && piece == "Piece")
}
