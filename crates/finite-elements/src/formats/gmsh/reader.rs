//! The sections of a Gmsh file, as text or binary.

use super::listed::{Listed, ListedElement, MOST_GROUPS};
use super::parts::{Block, Kind, Parts};
use crate::Error;
use crate::elements;
use crate::error::Position;
use crate::formats::common::{find, line, quoted};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::str::FromStr;

/// Versions of the format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    Msh22,
    Msh41,
}

pub(super) struct Reader<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
    version: Version,
    binary: bool,
}

impl<'a> Reader<'a> {
    pub(super) fn new(file: &'a str, bytes: &'a [u8]) -> Self {
        Self {
            file,
            bytes,
            at: 0,
            version: Version::Msh41,
            binary: false,
        }
    }

    /// Where the file ends.
    pub(super) fn end_of_file(&self) -> usize {
        self.bytes.len()
    }

    fn position(&self, at: usize) -> Position {
        if self.binary {
            Position::Byte(at)
        } else {
            line(self.bytes, at)
        }
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

    /// Of a file without solids.
    pub(super) fn no_solids(&self) -> Error {
        self.contents(
            self.end_of_file(),
            "the file holds no solids".into(),
            "mesh in three dimensions (gmsh -3), and put the volumes into a physical group if there are groups at all, since Gmsh \
             saves nothing else then",
        )
    }

    pub(super) fn contents(&self, at: usize, problem: String, remedy: &'static str) -> Error {
        Error::MeshContents {
            file: self.file.into(),
            at: self.position(at),
            problem,
            remedy,
        }
    }

    fn skip_space(&mut self) {
        let space = self.bytes[self.at..]
            .iter()
            .take_while(|byte| byte.is_ascii_whitespace());
        self.at += space.count();
    }

    /// The rest of the line.
    fn line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|byte| *byte == b'\n');
        self.at += length.map_or(rest.len(), |length| length + 1);
        rest[..length.unwrap_or(rest.len())].trim_ascii()
    }

    /// The next word as a number.
    fn word<T: FromStr>(&mut self, expected: &str) -> Result<T, Error> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let word = &rest[..length];
        let number = str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        let number = number.ok_or_else(|| {
            let found = if word.is_empty() {
                "the end of the file".into()
            } else {
                quoted(word)
            };
            self.syntax(self.at, expected, found)
        })?;
        self.at += length;
        Ok(number)
    }

    fn raw<const N: usize>(&mut self, expected: &str) -> Result<[u8; N], Error> {
        let raw = self.bytes[self.at..].first_chunk().copied();
        let raw = raw.ok_or_else(|| self.syntax(self.at, expected, "the end of the file"))?;
        self.at += N;
        Ok(raw)
    }

    /// A count or tag. Version 2.2 keeps counts as text in binary files too, and tags in four bytes.
    fn size(&mut self, expected: &str) -> Result<u64, Error> {
        match (self.binary, self.version) {
            (true, Version::Msh41) => self.raw(expected).map(u64::from_le_bytes),
            (true, Version::Msh22) => self.raw(expected).map(|raw| u64::from(u32::from_le_bytes(raw))),
            (false, _) => self.word(expected),
        }
    }

    fn int(&mut self, expected: &str) -> Result<i32, Error> {
        if self.binary {
            self.raw(expected).map(i32::from_le_bytes)
        } else {
            self.word(expected)
        }
    }

    fn real(&mut self, expected: &str) -> Result<f64, Error> {
        if self.binary {
            self.raw(expected).map(f64::from_le_bytes)
        } else {
            self.word(expected)
        }
    }

    /// A number of things of which each takes at least `words` words or `bytes` bytes of the rest of the file.
    fn count(&mut self, what: &str, words: usize, bytes: usize) -> Result<usize, Error> {
        let at = self.at;
        let count = self.size(&format!("the number of {what}"))?;
        self.room(at, count, what, words, bytes)
    }

    /// A count in a line of its own, as version 2.2 has it: text in binary files too.
    fn count_line(&mut self, what: &str, words: usize, bytes: usize) -> Result<usize, Error> {
        let at = self.at;
        let count = self.word(&format!("the number of {what}"))?;
        self.line();
        self.room(at, count, what, words, bytes)
    }

    /// `count`, which stands at `at`, if the rest of the file has room for so many things.
    fn room(&self, at: usize, count: u64, what: &str, words: usize, bytes: usize) -> Result<usize, Error> {
        let left = self.bytes.len() - self.at;
        let room = if self.binary { left / bytes } else { left / (2 * words) };
        match usize::try_from(count) {
            Ok(count) if count <= room => Ok(count),
            _ => Err(self.contents(
                at,
                format!("{count} {what} are announced, but only {left} bytes follow"),
                "the file is damaged or cut short: save it again",
            )),
        }
    }

    pub(super) fn sections(&mut self, parts: &mut Parts) -> Result<(), Error> {
        self.format()?;
        loop {
            self.skip_space();
            let at = self.at;
            if at == self.bytes.len() {
                parts.groups_of_entities();
                return Ok(());
            }
            let head = self.line();
            let name = head
                .strip_prefix(b"$")
                .and_then(|name| str::from_utf8(name).ok())
                .ok_or_else(|| self.syntax(at, "the beginning of a section, as `$Nodes`", quoted(head)))?;
            match name {
                "PhysicalNames" => self.physical_names(parts)?,
                "Entities" => self.entities(parts)?,
                "Nodes" if self.version == Version::Msh22 => self.nodes_22(at, parts)?,
                "Elements" if self.version == Version::Msh22 => self.elements_22(at, parts)?,
                "Nodes" => self.nodes(at, parts)?,
                "Elements" => self.elements(at, parts)?,
                "ParametricNodes" => {
                    return Err(self.unsupported(
                        at,
                        "nodes with parametric coordinates (section $ParametricNodes)".into(),
                        "save without them (Mesh.SaveParametric = 0), or as version 4.1 (gmsh -format msh41)",
                    ));
                }
                "PartitionedEntities" | "GhostElements" => {
                    return Err(self.unsupported(
                        at,
                        format!("a partitioned mesh (section ${name})"),
                        "delete the partition (gmsh -part 0, or gmsh.model.mesh.unpartition) and save again",
                    ));
                }
                _ => {
                    let end = find(self.bytes, self.at, format!("$End{name}").as_bytes());
                    self.at = end
                        .ok_or_else(|| self.syntax(self.bytes.len(), format!("`$End{name}`"), "the end of the file"))?;
                    parts.skipped.insert(name.into());
                }
            }
            self.end(name)?;
        }
    }

    fn end(&mut self, section: &str) -> Result<(), Error> {
        self.skip_space();
        let (at, found) = (self.at, self.line());
        if found.strip_prefix(b"$End") == Some(section.as_bytes()) {
            return Ok(());
        }
        let found = if found.is_empty() {
            "the end of the file".into()
        } else {
            quoted(found)
        };
        Err(self.syntax(at, format!("`$End{section}`"), found))
    }

    fn format(&mut self) -> Result<(), Error> {
        self.skip_space();
        let (at, head) = (self.at, self.line());
        if head != b"$MeshFormat" {
            return Err(self.syntax(at, "`$MeshFormat`, with which Gmsh meshes begin", quoted(head)));
        }
        let (at, format) = (self.at, self.line());
        let text = String::from_utf8_lossy(format);
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let [version, kind, size] = words[..] else {
            return Err(self.syntax(
                at,
                "the version, `0` or `1` (binary) and the size of integers",
                quoted(format),
            ));
        };
        self.version = match version {
            "4.1" => Version::Msh41,
            // Versions 2, 2.0 and 2.1 differ in their names alone, which are refused where they have no dimension.
            "2" | "2.0" | "2.1" | "2.2" => Version::Msh22,
            _ => {
                return Err(self.unsupported(
                    at,
                    format!("MSH version {}", quoted(version.as_bytes())),
                    "save as version 4.1 (gmsh -format msh41, or the option Mesh.MshFileVersion = 4.1)",
                ));
            }
        };
        match (kind, size) {
            ("0", _) => {}
            ("1", "8") => {
                self.binary = true;
                let at = self.at;
                let one = self.int("the number 1 that tells the order of bytes")?;
                if one != 1 {
                    return Err(self.unsupported(
                        at,
                        "a file whose bytes have another order than little endian".into(),
                        "save as text (gmsh -format msh41 without -bin)",
                    ));
                }
            }
            _ => {
                return Err(self.unsupported(
                    at,
                    format!(
                        "a file of type {} with integers of {} bytes",
                        quoted(kind.as_bytes()),
                        quoted(size.as_bytes())
                    ),
                    "save as text, or as binary on a machine with integers of 8 bytes",
                ));
            }
        }
        self.end("MeshFormat")
    }

    /// Text in binary files too.
    fn physical_names(&mut self, parts: &mut Parts) -> Result<(), Error> {
        let count: usize = self.word("the number of physical names")?;
        self.line();
        let mut names = BTreeSet::new();
        for _ in 0..count {
            let (at, text) = (self.at, self.line());
            let (dimension, tag, name) = str::from_utf8(text).ok().and_then(physical_name).ok_or_else(|| {
                self.syntax(
                    at,
                    "a dimension 0-3, a physical tag and a name in double quotes",
                    quoted(text),
                )
            })?;
            if !names.insert((dimension, name)) || parts.names.insert((dimension, tag), name.into()).is_some() {
                return Err(self.contents(
                    at,
                    format!("a second physical group of dimension {dimension} has the tag {tag} or the name `{name}`"),
                    "give every group a name of its own",
                ));
            }
        }
        Ok(())
    }

    fn entities(&mut self, parts: &mut Parts) -> Result<(), Error> {
        let mut counts = [0; 4];
        for (count, what) in counts.iter_mut().zip(["points", "curves", "surfaces", "volumes"]) {
            *count = self.count(what, 5, 36)?;
        }
        for (dimension, count) in (0..).zip(counts) {
            for _ in 0..count {
                let at = self.at;
                let entity = self.int("the tag of an entity")?;
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    self.real("a coordinate of an entity or of its box")?;
                }
                let mut groups = BTreeSet::new();
                for _ in 0..self.count("physical tags", 1, 4)? {
                    groups.insert(self.int("a physical tag")?.unsigned_abs());
                }
                if groups.len() > MOST_GROUPS {
                    return Err(self.unsupported(
                        at,
                        format!(
                            "entity {entity} of dimension {dimension} in {} physical groups",
                            groups.len()
                        ),
                        "leave it in 16 at most",
                    ));
                }
                if dimension > 0 {
                    for _ in 0..self.count("bounding entities", 1, 4)? {
                        self.int("the tag of a bounding entity")?;
                    }
                }
                if parts.entities.insert((dimension, entity), groups).is_some() {
                    return Err(self.contents(
                        at,
                        format!("entity {entity} of dimension {dimension} is given twice"),
                        "the file is damaged: save it again",
                    ));
                }
            }
        }
        Ok(())
    }

    fn nodes(&mut self, section: usize, parts: &mut Parts) -> Result<(), Error> {
        let n_blocks = self.count("blocks of nodes", 4, 20)?;
        let total = self.count("nodes", 4, 32)?;
        self.size("the least node tag")?;
        self.size("the greatest node tag")?;
        let mut positions = Vec::new();
        let mut tags = Vec::new();
        for _ in 0..n_blocks {
            let at = self.at;
            let dimension = self.int("the dimension of an entity")?;
            self.int("the tag of an entity")?;
            let parametric = self.int("0, or 1 if there are parametric coordinates")?;
            let parameters = match (parametric, dimension) {
                (0, 0..=3) => 0,
                (1, 0..=3) => dimension as usize,
                _ => {
                    let found = format!("{dimension} and {parametric}");
                    return Err(self.syntax(at, "a dimension 0-3, a tag and 0 or 1", found));
                }
            };
            let count = self.count("nodes of the block", 4 + parameters, 32 + 8 * parameters)?;
            for _ in 0..count {
                let number = self.node_number(at, tags.len())?;
                tags.push((self.size("a node tag")?, number));
            }
            for _ in 0..count {
                let position = self.coordinates()?;
                for _ in 0..parameters {
                    self.real("a parametric coordinate")?;
                }
                positions.push(position);
            }
        }
        if positions.len() != total {
            return Err(self.contents(
                section,
                format!("{total} nodes are announced, but the blocks hold {}", positions.len()),
                "the file is damaged: save it again",
            ));
        }
        self.keep_nodes(section, positions, tags, parts)
    }

    fn nodes_22(&mut self, section: usize, parts: &mut Parts) -> Result<(), Error> {
        let count = self.count_line("nodes", 4, 28)?;
        let mut positions = Vec::with_capacity(count);
        let mut tags = Vec::with_capacity(count);
        for number in 0..count {
            let number = self.node_number(section, number)?;
            tags.push((self.size("a node tag")?, number));
            positions.push(self.coordinates()?);
        }
        self.keep_nodes(section, positions, tags, parts)
    }

    fn node_number(&self, at: usize, number: usize) -> Result<u32, Error> {
        u32::try_from(number)
            .map_err(|_| self.unsupported(at, "a mesh of more than 4294967295 nodes".into(), "use a coarser mesh"))
    }

    fn coordinates(&mut self) -> Result<[f64; 3], Error> {
        let mut position = [0.0; 3];
        for x in &mut position {
            let at = self.at;
            *x = self.real("a coordinate")?;
            if !x.is_finite() {
                let place = format!("{}, {}", self.file, self.position(at));
                return Err(Error::NotFinite { place, value: *x });
            }
        }
        Ok(position)
    }

    fn keep_nodes(
        &self,
        section: usize,
        positions: Vec<[f64; 3]>,
        mut tags: Vec<(u64, u32)>,
        parts: &mut Parts,
    ) -> Result<(), Error> {
        tags.sort_unstable();
        if let Some(pair) = tags.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(self.contents(
                section,
                format!("node tag {} is given twice", pair[0].0),
                "give every node a tag of its own (gmsh.model.mesh.renumberNodes)",
            ));
        }
        if parts.positions.replace(positions).is_some() {
            return Err(self.syntax(section, "one section of nodes", "a second `$Nodes`"));
        }
        parts.tags = tags;
        Ok(())
    }

    /// The number of the node whose tag stands here.
    fn node(&mut self, parts: &Parts) -> Result<u32, Error> {
        let at = self.at;
        let tag = self.size("a node tag")?;
        // Most files number their nodes from 1 without gaps.
        let guess = usize::try_from(tag.wrapping_sub(1)).unwrap_or(usize::MAX);
        let found = match parts.tags.get(guess) {
            Some((known, number)) if *known == tag => Some(*number),
            _ => {
                let found = parts.tags.binary_search_by_key(&tag, |(tag, _)| *tag);
                found.ok().map(|found| parts.tags[found].1)
            }
        };
        found.ok_or_else(|| {
            self.contents(
                at,
                format!("an element refers to node tag {tag}, which does not exist"),
                "the file is damaged: save it again",
            )
        })
    }

    fn kind(&self, at: usize, element_type: i32) -> Result<Kind, Error> {
        Kind::from_number(element_type).ok_or_else(|| {
            self.unsupported(
                at,
                format!("element type {element_type}"),
                format!(
                    "mesh with {} (Mesh.ElementOrder = 1, or 2 for tetrahedra)",
                    elements::descriptions()
                ),
            )
        })
    }

    /// Elements of version 2.2: each with its own tags, and once for each of its physical groups.
    fn elements_22(&mut self, section: usize, parts: &mut Parts) -> Result<(), Error> {
        if parts.positions.is_none() {
            return Err(self.syntax(section, "`$Nodes` before the elements", "`$Elements`"));
        }
        let total = self.count_line("elements", 4, 8)?;
        let mut listed = Listed::default();
        let mut number = 0;
        while number < total {
            let at = self.at;
            // In binary files elements of one type with as many tags share a head.
            let (element_type, count, n_tags, mut tag);
            if self.binary {
                element_type = self.int("an element type")?;
                count = self.size("the number of elements that follow")?;
                n_tags = self.size("the number of tags of an element")?;
                tag = 0;
            } else {
                tag = self.size("an element number")?;
                element_type = self.int("an element type")?;
                count = 1;
                n_tags = self.size("the number of tags of an element")?;
            }
            let kind = self.kind(at, element_type)?;
            let left = (total - number) as u64;
            if count == 0 || count > left {
                return Err(self.contents(
                    at,
                    format!("{count} elements are announced where {left} are left"),
                    "the file is damaged: save it again",
                ));
            }
            for _ in 0..count {
                if self.binary {
                    tag = self.size("an element number")?;
                }
                // The physical group and the entity; those of partitions follow.
                let mut first = [0; 2];
                for place in 0..n_tags {
                    let value = self.int("a tag of an element")?;
                    if let Some(known) = first.get_mut(place as usize) {
                        *known = value;
                    }
                }
                let nodes = listed.nodes.len();
                for _ in 0..kind.n_nodes() {
                    let node = self.node(parts)?;
                    listed.nodes.push(node);
                }
                let [group, entity] = [first[0].unsigned_abs(), first[1].unsigned_abs()];
                listed.elements.push(ListedElement {
                    at,
                    kind,
                    tag,
                    group,
                    entity,
                    nodes,
                });
                number += 1;
            }
        }
        let blocks = listed.blocks().map_err(|(at, tag)| {
            self.unsupported(
                at,
                format!("element {tag} in more than {MOST_GROUPS} physical groups"),
                "leave it in 16 at most",
            )
        })?;
        if parts.blocks.replace(blocks).is_some() {
            return Err(self.syntax(section, "one section of elements", "a second `$Elements`"));
        }
        Ok(())
    }

    fn elements(&mut self, section: usize, parts: &mut Parts) -> Result<(), Error> {
        if parts.positions.is_none() {
            return Err(self.syntax(section, "`$Nodes` before the elements", "`$Elements`"));
        }
        let n_blocks = self.count("blocks of elements", 4, 20)?;
        let total = self.count("elements", 2, 16)?;
        self.size("the least element tag")?;
        self.size("the greatest element tag")?;
        let mut tags = Vec::new();
        let mut blocks = Vec::new();
        for _ in 0..n_blocks {
            let at = self.at;
            let entity_dimension = self.int("the dimension of an entity")?;
            let entity = self.int("the tag of an entity")?;
            let element_type = self.int("an element type")?;
            let kind = self.kind(at, element_type)?;
            let (dimension, n_nodes) = (kind.dimension(), kind.n_nodes());
            if entity_dimension != dimension {
                let expected = format!("an entity of dimension {dimension} for element type {element_type}");
                return Err(self.syntax(at, expected, format!("dimension {entity_dimension}")));
            }
            let count = self.count("elements of the block", 1 + n_nodes, 8 + 8 * n_nodes)?;
            let mut nodes = Vec::new();
            for _ in 0..count {
                tags.push(self.size("an element tag")?);
                for _ in 0..n_nodes {
                    nodes.push(self.node(parts)?);
                }
            }
            blocks.push(Block {
                at,
                kind,
                entity,
                groups: BTreeSet::new(),
                tags: tags[tags.len() - count..].to_vec(),
                nodes,
            });
        }
        if tags.len() != total {
            return Err(self.contents(
                section,
                format!("{total} elements are announced, but the blocks hold {}", tags.len()),
                "the file is damaged: save it again",
            ));
        }
        tags.sort_unstable();
        if let Some(pair) = tags.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(self.contents(
                section,
                format!("element tag {} is given twice", pair[0]),
                "give every element a tag of its own (gmsh.model.mesh.renumberElements)",
            ));
        }
        if parts.blocks.replace(blocks).is_some() {
            return Err(self.syntax(section, "one section of elements", "a second `$Elements`"));
        }
        Ok(())
    }
}

/// Dimension, tag and name of a line of `$PhysicalNames`.
fn physical_name(text: &str) -> Option<(i32, u32, &str)> {
    let (numbers, name) = text.split_once('"')?;
    let name = name.strip_suffix('"')?;
    let mut numbers = numbers.split_ascii_whitespace();
    let dimension = numbers.next()?.parse().ok().filter(|d| (0..=3).contains(d))?;
    let tag: i32 = numbers.next()?.parse().ok()?;
    numbers
        .next()
        .is_none()
        // Names from MED files are filled up with blanks.
        .then_some((dimension, tag.unsigned_abs(), name.trim()))
}
