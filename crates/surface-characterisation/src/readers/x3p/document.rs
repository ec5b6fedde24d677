//! The document of the archive: what its elements say.

use file_io::{Place, Source, quoted};
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::Event;
use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::error::FileError;
use crate::readers::bytes::{latin_or_utf8, malformed};
use crate::readers::text;

/// Name of the document in the archive.
pub(super) const MAIN: &str = "main.xml";

/// Names of the axes x, y and z.
pub(super) const AXES: [&str; 3] = ["CX", "CY", "CZ"];

/// Path of a point that the document lists.
const DATUM: &str = "Record3/DataList/Datum";

/// `main.xml`: texts of elements by their path below the root, and the points that it lists.
pub(super) struct Document<'a> {
    pub(super) file: &'a str,
    fields: BTreeMap<String, (String, usize)>,
    /// As many numbers for each point as there are absolute axes, NaN if missing.
    pub(super) datums: Vec<f64>,
    /// Number of absolute axes, known once points are listed: axes come before them.
    pub(super) listed: Option<usize>,
}

impl<'a> Document<'a> {
    pub(super) fn place(byte: usize) -> Place {
        Place::Inside {
            part: format!("`{MAIN}`"),
            byte,
        }
    }

    pub(super) fn malformed(&self, byte: usize, found: impl ToString, expected: impl ToString) -> FileError {
        malformed(self.file, Self::place(byte), found, expected)
    }

    pub(super) fn parse(file: &'a str, bytes: &[u8]) -> Result<Self, FileError> {
        let mut document = Self {
            file,
            fields: BTreeMap::new(),
            datums: Vec::new(),
            listed: None,
        };
        let decoded = text::decode(Source { name: file, bytes })?;
        let declared = decoded[..decoded.len().min(100)].to_ascii_lowercase();
        let latin = |name: &[u8]| declared.windows(name.len()).any(|w| w == name);
        let text = match str::from_utf8(&decoded) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) if latin(b"iso-8859-1") || latin(b"windows-1252") => Cow::Owned(latin_or_utf8(&decoded)),
            Err(e) => return Err(document.malformed(e.valid_up_to(), "bytes that are not UTF-8", "XML in UTF-8")),
        };
        let mut xml = quick_xml::Reader::from_str(&text);
        xml.config_mut().expand_empty_elements = true;
        // The path of the open element below the root, and its lengths before each element was opened.
        let (mut path, mut lengths) = (String::new(), Vec::new());
        let (mut content, mut leaf) = (String::new(), false);
        loop {
            let at = xml.buffer_position() as usize;
            let event = xml
                .read_event()
                .map_err(|e| document.malformed(xml.error_position() as usize, e, "well-formed XML"))?;
            match event {
                Event::Start(element) => {
                    let name = element.local_name();
                    let name: &str = name.as_ref();
                    if lengths.is_empty() && name != "ISO5436_2" {
                        return Err(document.malformed(at, quoted(name.as_bytes()), "the element `ISO5436_2`"));
                    }
                    lengths.push(path.len());
                    if lengths.len() > 1 {
                        if !path.is_empty() {
                            path.push('/');
                        }
                        path.push_str(name);
                    }
                    content.clear();
                    leaf = true;
                }
                Event::Text(part) if leaf => content.push_str(&part.into_inner()),
                Event::CData(part) if leaf => content.push_str(&part.into_inner()),
                Event::GeneralRef(name) if leaf => {
                    let character = name.resolve_char_ref().ok().flatten().map(String::from);
                    let known = character.or_else(|| resolve_predefined_entity(&name).map(str::to_owned));
                    match known {
                        Some(known) => content.push_str(&known),
                        // Entities that a document defines itself could grow without bound.
                        None if counts(&path) => {
                            return Err(document.malformed(at, format!("the entity `{}`", &*name), "text"));
                        }
                        None => {}
                    }
                }
                Event::End(_) => {
                    if std::mem::replace(&mut leaf, false) && counts(&path) {
                        document.leaf(&path, content.trim(), at)?;
                    }
                    path.truncate(lengths.pop().unwrap_or_default());
                }
                Event::Eof if lengths.is_empty() => return Ok(document),
                Event::Eof => return Err(document.malformed(at, "the end of the document", "its closing tags")),
                _ => {}
            }
        }
    }

    fn leaf(&mut self, path: &str, text: &str, at: usize) -> Result<(), FileError> {
        if path != DATUM {
            if self.fields.insert(path.into(), (text.into(), at)).is_some() {
                return Err(self.malformed(at, format!("a second element `{path}`"), "one"));
            }
            return Ok(());
        }
        let absolute = match self.listed {
            Some(absolute) => absolute,
            None => {
                let kind = |axis| self.text(&format!("Record1/Axes/{axis}/AxisType"));
                let absolute = AXES.into_iter().filter(|axis| kind(*axis) == Some("A")).count();
                self.listed = Some(absolute);
                absolute
            }
        };
        if text.is_empty() {
            self.datums.extend(std::iter::repeat_n(f64::NAN, absolute));
            return Ok(());
        }
        let before = self.datums.len();
        for number in text.split(';') {
            let value = number
                .trim()
                .parse()
                .map_err(|_| self.malformed(at, quoted(number.as_bytes()), "a number"))?;
            self.datums.push(value);
        }
        let found = self.datums.len() - before;
        if found != absolute {
            let expected = format!("{absolute}, one for each absolute axis");
            return Err(self.malformed(at, format!("{found} numbers"), expected));
        }
        Ok(())
    }

    /// Text of an element that is there and not empty.
    pub(super) fn text(&self, path: &str) -> Option<&str> {
        let (text, _) = self.fields.get(path)?;
        Some(text.as_str()).filter(|text| !text.is_empty())
    }

    pub(super) fn at(&self, path: &str) -> usize {
        self.fields.get(path).map_or(0, |(_, at)| *at)
    }

    pub(super) fn required(&self, path: &str) -> Result<&str, FileError> {
        let missing = || self.malformed(self.at(path), "nothing", format!("the element `{path}`"));
        self.text(path).ok_or_else(missing)
    }

    pub(super) fn real(&self, path: &str) -> Result<Option<f64>, FileError> {
        let Some(text) = self.text(path) else {
            return Ok(None);
        };
        let value = text.parse().ok().filter(|v: &f64| v.is_finite());
        let refused = || self.malformed(self.at(path), quoted(text.as_bytes()), format!("a number as `{path}`"));
        value.map(Some).ok_or_else(refused)
    }

    pub(super) fn count(&self, path: &str) -> Result<u64, FileError> {
        let text = self.required(path)?;
        let refused = |_| {
            self.malformed(
                self.at(path),
                quoted(text.as_bytes()),
                format!("a whole number as `{path}`"),
            )
        };
        text.parse().map_err(refused)
    }
}

fn counts(path: &str) -> bool {
    path.len() <= 64
        && ["Record1/", "Record3/", "Record4/"]
            .iter()
            .any(|record| path.starts_with(record))
}
