//! Archives of Ansys Mechanical APDL (`.cdb`), as `CDWRITE` and Workbench write them: the mesh and its components.
//!
//! | command | read |
//! |---|---|
//! | `NBLOCK` | nodes |
//! | `EBLOCK` | elements, with and without `SOLID` |
//! | `ET`, `ETBLOCK`, `*SET` | types of elements, also by the parameters that Workbench uses |
//! | `CMBLOCK` | components of nodes and of elements |
//! | `MPDATA` | a note says what the file gives for each material |
//!
//! Solids are SOLID185, 45 and 190 (8 nodes), 186 and 95 (20), 187 and 92 (10), 285 (4), also collapsed to wedges and tetrahedra.
//! Contact, target, surface-effect and shell elements are facets. The elements of each type `N` are the group `TYPE=N`, the
//! solids of each material the group `MAT=N`. Other elements are named in a note, other commands are not: an archive has
//! hundreds of settings of its program.
//!
//! Format: Ansys Mechanical APDL documentation, commands `NBLOCK`, `EBLOCK` and `CMBLOCK`.

use super::labelled::{GroupId, Labelled, Shape};
use super::lines::{Text, real};
use super::solid_mesh::SolidMesh;
use crate::Error;
use crate::elements::{ElementType, HEX8, HEX20, TET4, TET10, WEDGE6, WEDGE15};
use std::collections::{BTreeMap, HashMap};

/// Elements that lie on faces of solids or are shells.
const FACETS: [u64; 13] = [28, 41, 43, 63, 93, 131, 152, 154, 170, 173, 174, 181, 281];
/// Elements that are neither: rods, beams, pipes, springs, masses, joints, pretension, contact at nodes and along lines.
const OTHERS: [u64; 47] = [
    1, 3, 4, 7, 8, 9, 10, 11, 14, 16, 18, 20, 21, 23, 24, 27, 34, 37, 38, 39, 40, 44, 50, 54, 59, 60, 151, 153, 156,
    169, 171, 172, 175, 176, 177, 178, 179, 180, 184, 188, 189, 201, 214, 250, 288, 289, 290,
];
/// Elements that are for meshing alone.
const MESH_ONLY: u64 = 200;

/// The solids, facets and components of an archive.
pub(super) fn solid_mesh(file: &str, bytes: &[u8]) -> Result<SolidMesh, Error> {
    let text = String::from_utf8_lossy(bytes);
    Reader {
        text: Text::new(file, &text),
        at: 0,
        mesh: Labelled::default(),
        types: HashMap::new(),
        parameters: HashMap::new(),
        materials: BTreeMap::new(),
        left_out: BTreeMap::new(),
        solids: 0,
    }
    .read()
}

struct Reader<'a> {
    text: Text<'a>,
    /// The next line, from zero.
    at: usize,
    mesh: Labelled,
    /// The number of the element behind each type.
    types: HashMap<u64, u64>,
    parameters: HashMap<String, u64>,
    /// Properties of each material, as they are written.
    materials: BTreeMap<u64, Vec<String>>,
    /// Elements that are not read, by the number of the element.
    left_out: BTreeMap<u64, usize>,
    solids: usize,
}

/// The columns of a Fortran format such as `(3i9,6e21.13e3)`: how many of which width.
struct Columns {
    integers: (usize, usize),
    reals: (usize, usize),
}

impl<'a> Reader<'a> {
    fn read(mut self) -> Result<SolidMesh, Error> {
        while let Some(line) = self.text.lines.get(self.at) {
            let at = self.at;
            self.at += 1;
            let mut words = line.split(',').map(str::trim);
            let command = words.next().unwrap_or("").to_ascii_uppercase();
            match command.as_str() {
                "*SET" => {
                    if let (Some(name), Some(Ok(value))) = (words.next(), words.next().map(str::parse)) {
                        self.parameters.insert(name.to_ascii_lowercase(), value);
                    }
                }
                "ET" => {
                    let (number, name) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
                    let number = self.value(number);
                    let digits = name.trim_start_matches(|c: char| !c.is_ascii_digit());
                    match (number, digits.parse()) {
                        (Some(number), Ok(element)) => drop(self.types.insert(number, element)),
                        _ => {
                            return Err(self
                                .text
                                .syntax(at, "ET with the number of a type and an element", line));
                        }
                    }
                }
                "ETBLOCK" => {
                    let Columns { integers, .. } = self.columns()?;
                    while let Some(line) = self.text.lines.get(self.at).filter(|line| line.trim() != "-1") {
                        match self.integers(self.at, integers)?[..] {
                            [number, element, ..] => drop(self.types.insert(number, element)),
                            _ => return Err(self.text.syntax(self.at, "the number of a type and an element", line)),
                        }
                        self.at += 1;
                    }
                    self.at += 1;
                }
                "NBLOCK" => self.nodes()?,
                "EBLOCK" => {
                    let is_solid = words.nth(1).is_some_and(|key| key.eq_ignore_ascii_case("SOLID"));
                    self.elements(is_solid)?;
                }
                "CMBLOCK" => {
                    let (name, kind) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
                    let count = words.next().unwrap_or("").split('!').next().unwrap_or("").trim();
                    let count = count.parse::<usize>().ok().filter(|_| !name.is_empty());
                    let count = count.ok_or_else(|| self.text.syntax(at, "CMBLOCK with name, kind and count", line))?;
                    self.component(name, kind, count)?;
                }
                "MPDATA" => {
                    // Version, count, label, material, place, values; the version is left out at times.
                    let words: Vec<&str> = words.collect();
                    let first = usize::from(words.first().is_some_and(|word| word.starts_with(['R', 'r']))) + 1;
                    if let [label, material, _, value, ..] = words.get(first..).unwrap_or_default()
                        && let Ok(material) = material.parse()
                    {
                        let property = format!("{} {value}", label.to_ascii_uppercase());
                        self.materials.entry(material).or_default().push(property);
                    }
                }
                "N" | "E" | "EN" if !line.contains("R5") && words.next().is_some() => {
                    return Err(self.text.unsupported(
                        at,
                        format!("the command {command} for a single node or element"),
                        "write the archive in blocks (CDWRITE, ..., BLOCKED)",
                    ));
                }
                _ => {}
            }
        }
        self.finish()
    }

    fn finish(mut self) -> Result<SolidMesh, Error> {
        let last = self.text.lines.len().saturating_sub(1) as u32;
        if self.solids == 0 {
            return Err(self.text.contents(
                last,
                "the file holds no solids".into(),
                "write an archive of a meshed solid with its element types (CDWRITE, DB)",
            ));
        }
        if !self.left_out.is_empty() {
            let counts: Vec<String> = self
                .left_out
                .iter()
                .map(|(element, count)| format!("{count} of element {element}"))
                .collect();
            self.mesh.notes.push(format!(
                "elements that are no solids and on no face of one are no part of the mesh: {}; bolts, masses, springs and supports are given by the scene",
                counts.join(", ")
            ));
        }
        for (material, properties) in std::mem::take(&mut self.materials) {
            self.mesh.notes.push(format!(
                "the file gives for `MAT={material}`, in its units, {}; materials are those of the scene",
                properties.join(", ")
            ));
        }
        let Self { text, mesh, .. } = self;
        mesh.finish(&|at, problem, remedy| text.contents(at, problem, remedy))?
            .finish(text.file)
    }

    /// A whole number, or the parameter with this name.
    fn value(&self, text: &str) -> Option<u64> {
        let of_parameter = || self.parameters.get(&text.to_ascii_lowercase()).copied();
        text.parse().ok().or_else(of_parameter)
    }

    /// The format line of a block.
    fn columns(&mut self) -> Result<Columns, Error> {
        let line = self.text.lines.get(self.at).copied().unwrap_or("").trim();
        let parsed = columns(&line.to_ascii_lowercase());
        let columns = parsed.ok_or_else(|| {
            self.text
                .syntax(self.at, "the columns of the block, such as (3i9,6e21.13e3)", line)
        })?;
        self.at += 1;
        Ok(columns)
    }

    fn nodes(&mut self) -> Result<(), Error> {
        let Columns { integers, reals } = self.columns()?;
        if reals.1 == 0 {
            return Err(self.text.syntax(self.at - 1, "columns of real numbers", "none"));
        }
        loop {
            let at = self.at;
            let line = self.text.lines.get(at).copied().unwrap_or("");
            let start = line.trim_start();
            self.at += 1;
            if start.starts_with("-1") || start.starts_with(['N', 'n']) {
                return Ok(());
            }
            let label = field(line, 0, integers.1).and_then(|text| text.parse().ok());
            let label = label.ok_or_else(|| {
                self.text
                    .syntax(at, "the number of a node, or the end of the block", start)
            })?;
            let first = integers.0 * integers.1;
            let mut position = [0.0; 3];
            for (number, x) in position.iter_mut().enumerate() {
                // Zeros at the end of the line are left out.
                let text = field(line, first + number * reals.1, reals.1).unwrap_or("");
                if !text.is_empty() {
                    let value = real(text);
                    *x = value.ok_or_else(|| self.text.syntax(at, "a coordinate", text))?;
                }
            }
            let refuse = |at, problem, remedy| self.text.contents(at, problem, remedy);
            self.mesh.node(at as u32, label, position, &refuse)?;
        }
    }

    /// The whole numbers of a line in columns; zeros at its end may be left out.
    fn integers(&self, at: usize, (count, width): (usize, usize)) -> Result<Vec<u64>, Error> {
        let line = self.text.lines.get(at).copied().unwrap_or("");
        let mut values = Vec::with_capacity(count.min(line.len()));
        for number in 0..count {
            match field(line, number * width, width) {
                None | Some("") => break,
                Some(text) => {
                    let value = text.parse();
                    values.push(value.map_err(|_| self.text.syntax(at, "a whole number that is not negative", text))?);
                }
            }
        }
        match values.is_empty() {
            true => Err(self.text.syntax(
                at,
                "whole numbers in columns, or -1 at the end of the block",
                line.trim(),
            )),
            false => Ok(values),
        }
    }

    fn elements(&mut self, is_solid: bool) -> Result<(), Error> {
        let Columns { integers, .. } = self.columns()?;
        loop {
            let at = self.at;
            let line = self.text.lines.get(at).copied().unwrap_or("");
            self.at += 1;
            if line.trim() == "-1" {
                return Ok(());
            }
            let mut values = self.integers(at, integers)?;
            let (label, element_type, material, nodes) = if is_solid {
                let [material, element_type, .., count, _, label] = *values.first_chunk::<11>().ok_or_else(|| {
                    self.text
                        .syntax(at, "the eleven numbers that begin an element", line.trim())
                })?;
                if count > 20 {
                    return Err(self.text.syntax(at, "at most 20 nodes of an element", line.trim()));
                }
                let all = 11 + count as usize;
                for _ in 1..all.div_ceil(integers.0.max(1)) {
                    let more = self.integers(self.at, integers)?;
                    values.extend(more);
                    self.at += 1;
                }
                // Zeros at the end of a line may be left out.
                values.resize(all, 0);
                (label, element_type, Some(material), &values[11..])
            } else {
                let [label, element_type, _, _, _] = *values.first_chunk::<5>().ok_or_else(|| {
                    self.text
                        .syntax(at, "the five numbers that begin an element", line.trim())
                })?;
                (label, element_type, None, &values[5..])
            };
            let known = self.types.get(&element_type).copied();
            let element = known.ok_or_else(|| {
                self.text.contents(
                    at as u32,
                    format!("element {label} has the type {element_type}, which no ET or ETBLOCK defines"),
                    "write the archive with its element types (CDWRITE, DB)",
                )
            })?;
            let nodes = nodes.to_vec();
            self.element(at, label, (element_type, element), material, &nodes)?;
        }
    }

    fn element(
        &mut self,
        at: usize,
        label: u64,
        (element_type, element): (u64, u64),
        material: Option<u64>,
        nodes: &[u64],
    ) -> Result<(), Error> {
        let shape = match element {
            45 | 185 | 190 | 95 | 186 | 92 | 187 | 285 => {
                let solid = solid(nodes).ok_or_else(|| {
                    self.text.unsupported(
                        at,
                        format!("element {label}, a pyramid or a solid without some of its middle nodes,"),
                        "mesh solids as tetrahedra, wedges or hexahedra, with all middle nodes or none",
                    )
                })?;
                self.solids += 1;
                Some(solid)
            }
            _ if FACETS.contains(&element) && nodes.len() >= 3 => facet(nodes),
            MESH_ONLY => None,
            _ if FACETS.contains(&element) || OTHERS.contains(&element) => None,
            _ => {
                return Err(self.text.unsupported(
                    at,
                    format!("element {label} of type {element}"),
                    "mesh solids by SOLID185, 186, 187 or 285, or leave other elements out of the archive",
                ));
            }
        };
        let Some((shape, nodes)) = shape else {
            *self.left_out.entry(element).or_default() += 1;
            return Ok(());
        };
        let of_type = Some(self.mesh.group(format!("TYPE={element_type}")));
        let of_material: Option<GroupId> = match (shape, material) {
            (Shape::Solid(_), Some(material)) => Some(self.mesh.group(format!("MAT={material}"))),
            _ => None,
        };
        self.mesh
            .element(at as u32, label, shape, &nodes, [of_type, of_material]);
        Ok(())
    }

    fn component(&mut self, name: &str, kind: &str, count: usize) -> Result<(), Error> {
        let Columns {
            integers: (columns, width),
            ..
        } = self.columns()?;
        let is_nodes = match kind.get(..4).map(str::to_ascii_uppercase).as_deref() {
            Some("NODE") => true,
            Some("ELEM") => false,
            _ => return Err(self.text.syntax(self.at, "a component of NODE or ELEM", kind)),
        };
        let mut members: Vec<u64> = Vec::new();
        let (mut found, mut ranges) = (0, 0);
        while found < count {
            let line = self.text.lines.get(self.at).copied().unwrap_or("");
            let before = found;
            for number in 0..columns {
                let Some(text) = field(line, number * width, width).filter(|text| !text.is_empty()) else {
                    break;
                };
                let value: i64 = text
                    .parse()
                    .map_err(|_| self.text.syntax(self.at, "members of a component", text))?;
                // A negative number ends a range that the number before it begins.
                match (value < 0, members.last().copied()) {
                    (false, _) => members.push(value as u64),
                    (true, Some(first)) if value.unsigned_abs() > first => {
                        ranges += value.unsigned_abs() - first;
                        if ranges > self.text.lines.len() as u64 {
                            return Err(self.text.contents(
                                self.at as u32,
                                format!("the component `{name}` has more members than the file has lines"),
                                "write the archive again",
                            ));
                        }
                        members.extend(first + 1..=value.unsigned_abs());
                    }
                    (true, _) => return Err(self.text.syntax(self.at, "the end of a range", text)),
                }
                found += 1;
            }
            if found == before {
                return Err(self.text.syntax(self.at, "members of a component", line.trim()));
            }
            self.at += 1;
        }
        let group = self.mesh.group(name.to_owned());
        match is_nodes {
            true => self.mesh.node_set(group, members),
            false => self.mesh.set(group, members),
        }
        Ok(())
    }
}

/// The text in columns of a line, without blanks around it; none where the line ends before.
fn field(line: &str, first: usize, width: usize) -> Option<&str> {
    let end = (first + width).min(line.len());
    (first < line.len()).then(|| line.get(first..end).unwrap_or("?").trim())
}

fn columns(line: &str) -> Option<Columns> {
    let inner = line.strip_prefix('(')?.strip_suffix(')')?;
    let mut columns = Columns {
        integers: (0, 0),
        reals: (0, 0),
    };
    for part in inner.split(',') {
        let letter = part.find(['i', 'e', 'f', 'g', 'a'])?;
        let width = part[letter + 1..].split('.').next()?;
        let found = (part[..letter].parse().ok()?, width.parse().ok()?);
        // Lines are not longer than a few hundred characters.
        if found.0 > 100 || found.1 > 100 || found.1 == 0 {
            return None;
        }
        match &part[letter..=letter] {
            "i" => columns.integers = found,
            "a" => {}
            _ => columns.reals = found,
        }
    }
    (columns.integers.1 > 0).then_some(columns)
}

/// Type and nodes of a solid, which may be a hexahedron with corners that coincide; none for pyramids, and where some middle
/// nodes are missing.
fn solid(nodes: &[u64]) -> Option<(Shape, Vec<u64>)> {
    let take = |row: &'static ElementType, places: &[usize]| {
        let taken = places.iter().map(|place| nodes[*place]);
        Some((Shape::Solid(row), taken.collect()))
    };
    let has_middles = |corners: usize| nodes.len() > corners && nodes[corners..].iter().any(|node| *node != 0);
    match nodes.len() {
        4 => return take(&TET4, &[0, 1, 2, 3]),
        10 => {
            return match (has_middles(4), nodes.contains(&0)) {
                (false, _) => take(&TET4, &[0, 1, 2, 3]),
                (true, false) => take(&TET10, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]),
                (true, true) => None,
            };
        }
        8 | 20 => {}
        _ => return None,
    }
    let same = |a: usize, b: usize| nodes[a] == nodes[b];
    let top_is_point = same(4, 5) && same(5, 6) && same(6, 7);
    // Types without and with nodes in the middles of edges, and for each of their nodes its place in the file.
    let (linear, quadratic, corners, middles): (_, _, &[usize], &[usize]) = match (same(2, 3), same(6, 7), top_is_point)
    {
        (true, _, true) => (&TET4, &TET10, &[0, 1, 2, 4], &[8, 9, 11, 16, 17, 18]),
        (true, true, false) => (
            &WEDGE6,
            &WEDGE15,
            &[0, 1, 2, 4, 5, 6],
            &[8, 9, 11, 12, 13, 15, 16, 17, 18],
        ),
        (false, false, false) => (
            &HEX8,
            &HEX20,
            &[0, 1, 2, 3, 4, 5, 6, 7],
            &[8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19],
        ),
        _ => return None,
    };
    match has_middles(8) {
        false => take(linear, corners),
        true if middles.iter().all(|place| nodes[*place] != 0) => take(quadratic, &[corners, middles].concat()),
        true => None,
    }
}

/// Shape and corners of a facet; none for what has fewer than three.
fn facet(nodes: &[u64]) -> Option<(Shape, Vec<u64>)> {
    let count = if matches!(nodes.len(), 3 | 6) { 3 } else { 4 };
    let mut corners = nodes.get(..count)?.to_vec();
    corners.dedup();
    (corners.len() >= 3 && !corners.contains(&0)).then_some((Shape::Facet(corners.len()), corners))
}
