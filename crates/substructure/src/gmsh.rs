//! Gmsh meshes: MSH files of version 4.1, read as text or binary, written as text.
//!
//! | Gmsh | here |
//! |---|---|
//! | elements of type 4, 5, 6, 11 (tetrahedron, hexahedron, prism, 10-node tetrahedron) | elements of the mesh |
//! | physical group of dimension 3 | material, by name |
//! | elements of type 2, 3, 9 (triangle, quadrangle, 6-node triangle) in a group of dimension 2 | list of faces |
//! | points and lines in a group of dimension 0 or 1 | list of nodes |
//!
//! Node orders (Gmsh reference manual, section "Node ordering") are this crate's but for the last two edges of the
//! 10-node tetrahedron, which are swapped. Faces keep the order of the file, whose normals are those of the geometry
//! and not necessarily outward; the sign of a physical tag is ignored. Gmsh knows no units: lengths are taken as metres.

use crate::Error;
use crate::error::Position;
use crate::interchange::{Kept, cell, check, check_nodes, face, find, line, quoted};
use crate::mesh::{Element, Face, Group, Material, Mesh};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::str::FromStr;

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// Solids. Its materials are those that were passed in, then the fallback if it was needed and is not among them.
    pub mesh: Mesh,
    /// Lists of faces, by ascending physical tag.
    pub faces: Vec<Group<Face>>,
    /// Lists of nodes, by dimension, then ascending physical tag; members ascend.
    pub nodes: Vec<Group<u32>>,
    /// Nodes that belong to no solid: they are dropped, since nothing would hold them.
    pub orphan_nodes: usize,
    /// Points, lines and faces that belong to no physical group.
    pub ignored_elements: usize,
    /// Sections that were not read.
    pub skipped_sections: BTreeSet<String>,
}

/// Reads `bytes`; `file` is its name in messages.
///
/// A physical group of dimension 3 without a name goes by its tag. A volume takes the material that has the name of one
/// of its groups, or else `fallback`. Hexahedra get the default formulation.
///
/// # Errors
/// [`Error::MeshSyntax`] where the format is broken; [`Error::MeshUnsupported`] for other versions, partitioned
/// meshes and other elements; [`Error::MeshContents`] for counts that the file cannot hold, tags given twice or
/// missing, files without solids, faces in groups that belong to no solid, volumes with no material or several;
/// [`Error::NotFinite`] for coordinates.
pub fn read(file: &str, bytes: &[u8], materials: &[Material], fallback: Option<&Material>) -> Result<Contents, Error> {
    let mut reader = Reader {
        file,
        bytes,
        at: 0,
        binary: false,
    };
    let mut parts = Parts::default();
    reader.sections(&mut parts)?;
    parts.assemble(&reader, materials, fallback)
}

/// How many groups an entity may be in: the lists made of a file stay as small as it is.
const MOST_GROUPS: usize = 16;

/// Dimension and number of nodes of an element type.
fn shape(element_type: i32) -> Option<(i32, usize)> {
    Some(match element_type {
        15 => (0, 1),
        1 => (1, 2),
        8 => (1, 3),
        26 => (1, 4),
        27 => (1, 5),
        28 => (1, 6),
        2 => (2, 3),
        3 => (2, 4),
        9 => (2, 6),
        4 => (3, 4),
        5 => (3, 8),
        6 => (3, 6),
        11 => (3, 10),
        _ => return None,
    })
}

/// Elements of one type on one entity.
struct Block {
    at: usize,
    dimension: i32,
    entity: i32,
    n_nodes: usize,
    /// Nodes of all elements in Gmsh's order, zero based, `n_nodes` per element.
    nodes: Vec<u32>,
}

/// The sections of a file.
#[derive(Default)]
struct Parts {
    /// By dimension and physical tag.
    names: BTreeMap<(i32, u32), String>,
    /// Physical tags by dimension and entity.
    entities: BTreeMap<(i32, i32), BTreeSet<u32>>,
    positions: Option<Vec<[f64; 3]>>,
    /// Tags of the nodes, ascending, with their numbers.
    tags: Vec<(u64, u32)>,
    blocks: Option<Vec<Block>>,
    skipped: BTreeSet<String>,
}

struct Reader<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
    binary: bool,
}

impl<'a> Reader<'a> {
    fn position(&self, at: usize) -> Position {
        if self.binary {
            Position::Byte(at)
        } else {
            line(self.bytes, at)
        }
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

    fn contents(&self, at: usize, problem: String, remedy: &'static str) -> Error {
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

    fn size(&mut self, expected: &str) -> Result<u64, Error> {
        if self.binary {
            self.raw(expected).map(u64::from_le_bytes)
        } else {
            self.word(expected)
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

    fn sections(&mut self, parts: &mut Parts) -> Result<(), Error> {
        self.format()?;
        loop {
            self.skip_space();
            let at = self.at;
            if at == self.bytes.len() {
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
                "Nodes" => self.nodes(at, parts)?,
                "Elements" => self.elements(at, parts)?,
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
        if version != "4.1" {
            return Err(self.unsupported(
                at,
                format!("MSH version {}", quoted(version.as_bytes())),
                "save as version 4.1 (gmsh -format msh41, or the option Mesh.MshFileVersion = 4.1)",
            ));
        }
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
                let number = u32::try_from(tags.len()).map_err(|_| {
                    self.unsupported(at, "a mesh of more than 4294967295 nodes".into(), "use a coarser mesh")
                })?;
                tags.push((self.size("a node tag")?, number));
            }
            for _ in 0..count {
                let mut position = [0.0; 3];
                for x in &mut position {
                    let at = self.at;
                    *x = self.real("a coordinate")?;
                    if !x.is_finite() {
                        let place = format!("{}, {}", self.file, self.position(at));
                        return Err(Error::NotFinite { place, value: *x });
                    }
                }
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
            let Some((dimension, n_nodes)) = shape(element_type) else {
                return Err(self.unsupported(
                    at,
                    format!("element type {element_type}"),
                    "mesh with hexahedra of 8 nodes, prisms of 6 or tetrahedra of 4 or 10 (Mesh.ElementOrder = 1, or 2 \
                     for tetrahedra)",
                ));
            };
            if entity_dimension != dimension {
                let expected = format!("an entity of dimension {dimension} for element type {element_type}");
                return Err(self.syntax(at, expected, format!("dimension {entity_dimension}")));
            }
            let count = self.count("elements of the block", 1 + n_nodes, 8 + 8 * n_nodes)?;
            let mut nodes = Vec::new();
            for _ in 0..count {
                tags.push(self.size("an element tag")?);
                for _ in 0..n_nodes {
                    let at = self.at;
                    let tag = self.size("a node tag")?;
                    let found = parts.tags.binary_search_by_key(&tag, |(tag, _)| *tag);
                    let found = found.map_err(|_| {
                        self.contents(
                            at,
                            format!("an element refers to node tag {tag}, which does not exist"),
                            "the file is damaged: save it again",
                        )
                    })?;
                    nodes.push(parts.tags[found].1);
                }
            }
            blocks.push(Block {
                at,
                dimension,
                entity,
                n_nodes,
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
        .then_some((dimension, tag.unsigned_abs(), name))
}

impl Parts {
    fn groups(&self, block: &Block) -> impl Iterator<Item = u32> + Clone {
        let groups = self.entities.get(&(block.dimension, block.entity));
        groups.into_iter().flatten().copied()
    }

    fn name(&self, dimension: i32, group: u32) -> String {
        let name = self.names.get(&(dimension, group));
        name.cloned().unwrap_or_else(|| group.to_string())
    }

    /// The groups of a dimension with elements of it or a name, still empty.
    fn empty_groups<T>(&self, dimension: i32) -> BTreeMap<u32, Group<T>> {
        let named = self
            .names
            .keys()
            .filter(|(d, _)| *d == dimension)
            .map(|(_, group)| *group);
        let used = self.entities.iter().filter(|((d, _), _)| *d == dimension);
        named
            .chain(used.flat_map(|(_, groups)| groups.iter().copied()))
            .map(|group| {
                let name = self.name(dimension, group);
                let members = Vec::new();
                (group, Group { name, members })
            })
            .collect()
    }

    /// Number of the material of a volume.
    fn material(
        &self,
        reader: &Reader,
        block: &Block,
        materials: &[Material],
        fallback: Option<usize>,
    ) -> Result<u16, Error> {
        let names: Vec<String> = self.groups(block).map(|group| self.name(3, group)).collect();
        let of_name = |name: &String| materials.iter().position(|material| material.name == *name);
        let found: BTreeSet<usize> = names.iter().filter_map(of_name).collect();
        let place = || format!("volume {} in the physical groups {names:?}", block.entity);
        let number = match (found.len(), found.first(), fallback) {
            (1, Some(&number), _) | (0, _, Some(number)) => number,
            (0, _, None) => {
                let known: Vec<&str> = materials.iter().map(|material| material.name.as_str()).collect();
                return Err(reader.contents(
                    block.at,
                    format!("{} has none of the materials {known:?}", place()),
                    "put it into a physical volume with the name of a material, or name a material for all others",
                ));
            }
            _ => {
                return Err(reader.contents(
                    block.at,
                    format!("{} has several materials", place()),
                    "leave it in one of these groups only",
                ));
            }
        };
        u16::try_from(number).map_err(|_| {
            reader.unsupported(
                block.at,
                format!("material number {number}"),
                "pass at most 65536 materials",
            )
        })
    }

    fn assemble(
        &self,
        reader: &Reader,
        materials: &[Material],
        fallback: Option<&Material>,
    ) -> Result<Contents, Error> {
        let end = reader.bytes.len();
        let (Some(positions), Some(blocks)) = (&self.positions, &self.blocks) else {
            return Err(reader.syntax(end, "the sections $Nodes and $Elements", "the end of the file"));
        };
        let solids = blocks.iter().filter(|block| block.dimension == 3);
        let kept = Kept::new(positions.len(), solids.flat_map(|block| block.nodes.iter().copied()));
        let mut mesh = Mesh {
            nodes: kept.old.iter().map(|old| positions[*old as usize]).collect(),
            materials: materials.to_vec(),
            ..Mesh::default()
        };
        let mut faces = self.empty_groups(2);
        let mut nodes = [self.empty_groups(0), self.empty_groups(1)];
        // A fallback that is one of the materials is not added again.
        let fallback_number = fallback.map(|fallback| {
            let known = materials.iter().position(|material| material == fallback);
            known.unwrap_or(materials.len())
        });
        let mut ignored_elements = 0;
        for block in blocks {
            let groups = self.groups(block);
            if groups.clone().next().is_none() && block.dimension < 3 {
                ignored_elements += block.nodes.len() / block.n_nodes;
                continue;
            }
            match block.dimension {
                3 => {
                    let material = self.material(reader, block, materials, fallback_number)?;
                    if usize::from(material) == mesh.materials.len() {
                        mesh.materials.extend(fallback.cloned());
                    }
                    for old in block.nodes.chunks_exact(block.n_nodes) {
                        let mut new: Vec<u32> = old.iter().filter_map(|node| kept.number(*node)).collect();
                        if new.len() == 10 {
                            new.swap(8, 9);
                        }
                        mesh.elements.extend(cell(&new).map(|cell| Element { cell, material }));
                    }
                }
                2 => {
                    let mut members = Vec::new();
                    for old in block.nodes.chunks_exact(block.n_nodes) {
                        let new: Vec<u32> = old.iter().filter_map(|node| kept.number(*node)).collect();
                        if new.len() < old.len() {
                            return Err(reader.contents(
                                block.at,
                                format!(
                                    "a face of surface {}, which is in a physical group, belongs to no solid",
                                    block.entity
                                ),
                                "mesh the volume beside the surface and put it into a physical volume, or ungroup the \
                                 surface",
                            ));
                        }
                        members.extend(face(&new));
                    }
                    for group in groups {
                        if let Some(group) = faces.get_mut(&group) {
                            group.members.extend(&members);
                        }
                    }
                }
                dimension => {
                    let lists = &mut nodes[usize::from(dimension == 1)];
                    for group in groups {
                        if let Some(group) = lists.get_mut(&group) {
                            let members = block.nodes.iter().filter_map(|node| kept.number(*node));
                            group.members.extend(members);
                        }
                    }
                }
            }
        }
        if mesh.elements.is_empty() {
            return Err(reader.contents(
                end,
                "the file holds no solids".into(),
                "mesh in three dimensions (gmsh -3), and put the volumes into a physical group if there are groups at \
                 all, since Gmsh saves nothing else then",
            ));
        }
        let mut nodes: Vec<Group<u32>> = nodes.into_iter().flat_map(BTreeMap::into_values).collect();
        for group in &mut nodes {
            group.members.sort_unstable();
            group.members.dedup();
        }
        Ok(Contents {
            orphan_nodes: positions.len() - mesh.nodes.len(),
            mesh,
            faces: faces.into_values().collect(),
            nodes,
            ignored_elements,
            skipped_sections: self.skipped.clone(),
        })
    }
}

/// Writes a mesh as text: one volume per material, one surface per list of faces, one point per list of nodes, all with
/// a physical group of the same name. Nodes and solids have the tags `number + 1`. What [`read`] makes of the result,
/// given the same materials, is the same mesh to the last bit, except for nodes without solids and for the
/// formulation of hexahedra, which the format cannot carry.
///
/// # Errors
/// [`Error::Dangling`] and [`Error::NotFinite`] for broken meshes and lists; [`Error::MeshUnwritable`] for names that
/// appear twice or that quotes cannot hold.
pub fn write(mesh: &Mesh, faces: &[Group<Face>], nodes: &[Group<u32>]) -> Result<String, Error> {
    check(mesh)?;
    for group in faces {
        let place = format!("list of faces `{}`", group.name);
        for face in &group.members {
            check_nodes(&place, face.nodes(), mesh.nodes.len())?;
        }
    }
    for group in nodes {
        check_nodes(
            &format!("list of nodes `{}`", group.name),
            &group.members,
            mesh.nodes.len(),
        )?;
    }

    let names: [Vec<&str>; 4] = [
        nodes.iter().map(|group| group.name.as_str()).collect(),
        Vec::new(),
        faces.iter().map(|group| group.name.as_str()).collect(),
        mesh.materials.iter().map(|material| material.name.as_str()).collect(),
    ];
    let mut out = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n");
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{}", names.iter().map(Vec::len).sum::<usize>());
    for (dimension, names) in names.iter().enumerate() {
        let mut before = BTreeSet::new();
        for (number, name) in names.iter().enumerate() {
            let reason = if !before.insert(name) {
                "another has the same name; names must differ"
            } else if name.contains(|c: char| c == '"' || c.is_control()) || name.trim() != *name {
                "names must be free of double quotes, control characters and outer blanks"
            } else {
                let _ = writeln!(out, "{dimension} {} \"{name}\"", number + 1);
                continue;
            };
            return Err(Error::MeshUnwritable {
                what: format!("physical group {name:?} of dimension {dimension}"),
                reason: reason.into(),
            });
        }
    }
    out += "$EndPhysicalNames\n$Entities\n";
    let _ = writeln!(out, "{} 0 {} {}", nodes.len(), faces.len(), mesh.materials.len());
    for (number, group) in (1..).zip(nodes) {
        let [x, y, z] = group
            .members
            .first()
            .map_or([0.0; 3], |node| mesh.nodes[*node as usize]);
        let _ = writeln!(out, "{number} {x:e} {y:e} {z:e} 1 {number}");
    }
    for (number, group) in (1..).zip(faces) {
        let nodes = group.members.iter().flat_map(|face| face.nodes());
        bounded_entity(&mut out, number, nodes.map(|node| &mesh.nodes[*node as usize]));
    }
    for number in 0..mesh.materials.len() {
        let elements = mesh.elements.iter().filter(|e| usize::from(e.material) == number);
        let nodes = elements.flat_map(|e| e.cell.nodes());
        bounded_entity(&mut out, number + 1, nodes.map(|node| &mesh.nodes[*node as usize]));
    }
    out += "$EndEntities\n$Nodes\n";
    let n = mesh.nodes.len();
    if n == 0 {
        out += "0 0 0 0\n";
    } else {
        let _ = writeln!(out, "1 {n} 1 {n}\n3 1 0 {n}");
    }
    for tag in 1..=n {
        let _ = writeln!(out, "{tag}");
    }
    for [x, y, z] in &mesh.nodes {
        let _ = writeln!(out, "{x:e} {y:e} {z:e}");
    }
    out += "$EndNodes\n$Elements\n";

    let solids = mesh.elements.iter().map(|element| {
        let mut nodes = element.cell.nodes().to_vec();
        if nodes.len() == 10 {
            nodes.swap(8, 9);
        }
        (3, usize::from(element.material) + 1, nodes)
    });
    let faces = (1..).zip(faces).flat_map(|(number, group)| {
        let members = group.members.iter();
        members.map(move |face| (2, number, face.nodes().to_vec()))
    });
    let points = (1..).zip(nodes).flat_map(|(number, group)| {
        let members = group.members.iter();
        members.map(move |node| (0, number, vec![*node]))
    });
    let elements: Vec<(i32, usize, Vec<u32>)> = solids.chain(faces).chain(points).collect();
    // Runs of elements of one kind: the order of the elements is kept.
    let blocks: Vec<_> = elements
        .chunk_by(|a, b| (a.0, a.1, a.2.len()) == (b.0, b.1, b.2.len()))
        .collect();
    let n = elements.len();
    let _ = writeln!(out, "{} {n} {} {n}", blocks.len(), n.min(1));
    let mut tag = 0;
    for block in blocks {
        let (dimension, entity, nodes) = &block[0];
        let kinds = [1, 2, 3, 4, 5, 6, 8, 9, 11, 15].into_iter();
        let kind = kinds.filter(|kind| shape(*kind) == Some((*dimension, nodes.len())));
        let _ = writeln!(out, "{dimension} {entity} {} {}", kind.sum::<i32>(), block.len());
        for (_, _, nodes) in block {
            tag += 1;
            let _ = write!(out, "{tag}");
            for node in nodes {
                let _ = write!(out, " {}", u64::from(*node) + 1);
            }
            out.push('\n');
        }
    }
    out += "$EndElements\n";
    Ok(out)
}

/// An entity with a box round its nodes, one physical tag and no boundary.
fn bounded_entity<'a>(out: &mut String, number: usize, nodes: impl Iterator<Item = &'a [f64; 3]>) {
    let empty = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let (low, high) = nodes.fold(empty, |(low, high), x| {
        let corner = |f: fn(f64, f64) -> f64, a: [f64; 3]| std::array::from_fn(|i| f(a[i], x[i]));
        (corner(f64::min, low), corner(f64::max, high))
    });
    let _ = write!(out, "{number}");
    for x in low.into_iter().chain(high) {
        let _ = write!(out, " {:e}", if x.is_finite() { x } else { 0.0 });
    }
    let _ = writeln!(out, " 1 {number} 0");
}
