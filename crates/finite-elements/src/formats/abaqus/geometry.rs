//! Nodes, elements, sets and surfaces.

use super::deck::{DeckBeam, Label, Line, Members, Node, Solid, Surface};
use super::facets::{self, Facet};
use super::keywords::Extent;
use super::reader::{Point, Reader};
use super::text::{Block, Data, excerpt};
use crate::elements::{self, Cell, ElementType, Formulation};
use crate::error::{DeckProblem, Error};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::collections::HashSet;

/// What a type of `*ELEMENT` is.
#[derive(Clone, Copy)]
enum Kind {
    Solid(&'static ElementType, Formulation),
    /// An element of one node.
    Point(Point),
    /// A facet or line: number of nodes, and of corners.
    Facet(usize, usize),
    /// An element of which no nodes are kept.
    Unread,
    /// A beam of so many nodes.
    Beam(usize),
}

impl Kind {
    fn n_nodes(self) -> usize {
        match self {
            Self::Solid(row, _) => row.n_nodes(),
            Self::Point(_) => 1,
            Self::Facet(n_nodes, _) => n_nodes,
            Self::Unread => 0,
            Self::Beam(count) => count,
        }
    }
}

/// The type of `C3D10MH` and the like, whose suffix says nothing of the shape. The order of 27 nodes differs between codes.
fn variant(name: &str) -> Option<(&'static ElementType, Formulation)> {
    let rest = name.strip_prefix("C3D")?;
    let digits = rest.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let n_nodes: usize = digits.parse().ok().filter(|n| *n != 27)?;
    let row = elements::ELEMENT_TYPES
        .into_iter()
        .find(|row| row.n_nodes() == n_nodes)?;
    Some((row, row.default_formulation()))
}

impl Reader<'_> {
    /// `system` is the local coordinate system in force.
    pub(super) fn geometry(
        &mut self,
        instance: u32,
        system: &mut Isometry3<f64>,
        block: &Block<'_>,
    ) -> Result<(), Error> {
        match block.key.as_str() {
            "SYSTEM" => {
                *system = self.system(block)?;
                Ok(())
            }
            "NODE" => self.nodes(instance, system, block),
            _ => self.elements(instance, block),
        }
    }

    /// A local system: origin, a point on its first axis, a point in its first plane. Without the third point the
    /// z-axis stays and the first axis is projected onto the xy-plane; without lines the global system is restored.
    fn system(&self, block: &Block<'_>) -> Result<Isometry3<f64>, Error> {
        block.allow(self.source, &[])?;
        let Some(line) = block.data.first() else {
            return Ok(Isometry3::identity());
        };
        let [ax, ay, az, bx, by, bz] = line.columns::<6>(self.source)?;
        let origin = self.vector(line, "origin", [ax, ay, az])?;
        let translation = Translation3::from(origin);
        if [bx, by, bz].iter().all(|text| text.is_empty()) {
            return Ok(Isometry3::from_parts(translation, UnitQuaternion::identity()));
        }
        let mut x = self.vector(line, "point on the first axis", [bx, by, bz])? - origin;
        let z = match block.data.get(1) {
            Some(line) => {
                let c = self.vector(line, "point in the first plane", line.columns::<3>(self.source)?)?;
                // Of unit vectors, so that lengths in any unit make the same test.
                let [x, c] = [x, c - origin].map(|v| v.try_normalize(0.0).unwrap_or_default());
                x.cross(&c)
            }
            None => {
                x.z = 0.0;
                Vector3::z()
            }
        };
        let straight = || line.invalid(self.source, "system", line.text, "three points that span a plane");
        let x = x.try_normalize(0.0).ok_or_else(straight)?;
        let z = z.try_normalize(1e-12).ok_or_else(straight)?;
        let axes = Matrix3::from_columns(&[x, z.cross(&x), z]);
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        Ok(Isometry3::from_parts(translation, turn))
    }

    fn nodes(&mut self, instance: u32, system: &Isometry3<f64>, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["NSET", "SYSTEM"])?;
        let kind = block.choice(self.source, "SYSTEM", &["R", "C", "S"])?;
        let frame = self.frames[instance as usize].0 * system;
        let first = self.deck.nodes.len() as u32;
        for line in &block.data {
            self.spend(1, line.at)?;
            // Normals may follow the coordinates; solids have no use for them.
            let [number, a, b, c, ..] = line.columns::<7>(self.source)?;
            let label = Label {
                instance,
                number: line.label(self.source, "node", number)?,
            };
            let [a, b, c]: [f64; 3] = self.vector(line, "coordinate", [a, b, c])?.into();
            let local = match kind {
                "C" => {
                    let (sin, cos) = b.to_radians().sin_cos();
                    [a * cos, a * sin, c]
                }
                "S" => {
                    let ((sin, cos), (sin_up, cos_up)) = (b.to_radians().sin_cos(), c.to_radians().sin_cos());
                    [a * cos_up * cos, a * cos_up * sin, a * sin_up]
                }
                _ => [a, b, c],
            };
            let at = match frame == Isometry3::identity() {
                true => local,
                false => (frame * nalgebra::Point3::from(local)).coords.into(),
            };
            if !at.iter().all(|x: &f64| x.is_finite()) {
                return Err(line.invalid(self.source, "coordinate", line.text, "within the range of numbers"));
            }
            let index = self.deck.nodes.len() as u32;
            if let Some(known) = self.nodes.insert(label, index) {
                let first = self.deck.nodes[known as usize].line;
                return Err(self.duplicate(line.at, "node", self.deck.name(label), first));
            }
            self.deck.nodes.push(Node {
                label,
                at,
                line: line.at,
            });
        }
        match block.optional("NSET") {
            Some(name) => {
                let name = self.named(instance, name, block)?;
                self.add_nodes(name, block, (first..self.deck.nodes.len() as u32).collect())
            }
            None => Ok(()),
        }
    }

    fn element_kind(&self, block: &Block<'_>) -> Result<Kind, Error> {
        let name = block.required(self.source, "TYPE")?.to_ascii_uppercase();
        let of_mesh = self.extent == Extent::Mesh;
        match name.as_str() {
            _ if of_mesh && facets::is_connector(&name) => Ok(Kind::Unread),
            "MASS" => Ok(Kind::Point(Point::Mass)),
            "SPRING1" => Ok(Kind::Point(Point::Spring)),
            "DCOUP3D" => Ok(Kind::Point(Point::Coupling)),
            "ROTARYI" => Ok(Kind::Point(Point::RotaryInertia)),
            "B31" | "B31R" if !of_mesh => Ok(Kind::Beam(2)),
            "B32" | "B32R" if !of_mesh => Ok(Kind::Beam(3)),
            _ => elements::from_abaqus(&name)
                .or_else(|| of_mesh.then(|| variant(&name))?)
                .map(|(row, formulation)| Kind::Solid(row, formulation))
                .or_else(|| facets::shape(&name).map(|(nodes, corners)| Kind::Facet(nodes, corners)))
                .ok_or_else(|| {
                    let (found, known) = (excerpt(&name), elements::abaqus_names());
                    self.error(block.at, DeckProblem::ElementType { found, known })
                }),
        }
    }

    fn elements(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["TYPE", "ELSET"])?;
        let kind = self.element_kind(block)?;
        let set = block.optional("ELSET");
        let set = set.map(|name| self.named(instance, name, block)).transpose()?;
        let first = self.deck.elements.len() as u32;
        if matches!(kind, Kind::Facet(..) | Kind::Unread) {
            return self.facets(instance, block, kind, set.as_deref());
        }
        let mut lines = block.data.iter();
        while let Some(line) = lines.next() {
            self.spend(1, line.at)?;
            let (label, nodes) = self.element_line(instance, line, &mut lines, kind.n_nodes())?;
            self.refuse_known(line.at, label)?;
            let (row, formulation) = match kind {
                Kind::Solid(row, formulation) => (row, formulation),
                Kind::Point(_) | Kind::Beam(_) => {
                    let point = match kind {
                        Kind::Point(point) => (point, nodes[0], line.at),
                        _ => (Point::Beam, self.add_beam(label, nodes, line)?, line.at),
                    };
                    self.points.insert(label, point);
                    if let Some(set) = &set {
                        self.point_sets.entry(set.clone()).or_default().push(label);
                    }
                    continue;
                }
                Kind::Facet(..) | Kind::Unread => continue,
            };
            if let Some(a) = (1..nodes.len()).find(|&a| nodes[..a].contains(&nodes[a])) {
                return Err(self.error(
                    line.at,
                    DeckProblem::Value {
                        what: "nodes of the element",
                        found: self.deck.node_name(nodes[a]),
                        requirement: "different from one another (use C3D6 for collapsed hexahedra)",
                    },
                ));
            }
            let Some(cell) = Cell::try_new(row, formulation, &nodes) else {
                return Err(self.node_count(line.at, label, nodes.len(), row.n_nodes()));
            };
            self.elements.insert(label, self.deck.elements.len() as u32);
            self.deck.elements.push(Solid {
                label,
                cell,
                material: None,
                line: line.at,
            });
        }
        match (set, kind) {
            (Some(name), Kind::Solid(..)) => {
                self.add_elements(name, block, (first..self.deck.elements.len() as u32).collect())
            }
            _ => Ok(()),
        }
    }

    /// Refuses a second element of one label.
    fn refuse_known(&self, at: Line, label: Label) -> Result<(), Error> {
        let known = self.elements.get(&label).map(|&e| self.deck.elements[e as usize].line);
        let known = known.or_else(|| self.points.get(&label).map(|(_, _, line)| *line));
        match known.or_else(|| {
            self.facets
                .index
                .get(&label)
                .map(|&facet| self.facets.all[facet as usize].line)
        }) {
            Some(first) => Err(self.duplicate(at, "element", self.deck.name(label), first)),
            None => Ok(()),
        }
    }

    /// Elements that are no solids.
    fn facets(&mut self, instance: u32, block: &Block<'_>, kind: Kind, set: Option<&str>) -> Result<(), Error> {
        let first = self.facets.all.len() as u32;
        let mut lines = block.data.iter();
        while let Some(line) = lines.next() {
            self.spend(1, line.at)?;
            let (label, facet) = match kind {
                Kind::Facet(n_nodes, n_corners) => {
                    let (label, nodes) = self.element_line(instance, line, &mut lines, n_nodes)?;
                    (label, Facet::new(&nodes, n_corners, line.at))
                }
                _ => {
                    let number = line.label(self.source, "element", line.entries().next().unwrap_or(""))?;
                    let mut last = line;
                    while last.text.ends_with(',')
                        && let Some(next) = lines.next()
                    {
                        last = next;
                    }
                    (Label { instance, number }, Facet::new(&[], 0, line.at))
                }
            };
            self.refuse_known(line.at, label)?;
            self.facets.index.insert(label, self.facets.all.len() as u32);
            self.facets.all.push(facet);
        }
        let last = self.facets.all.len() as u32;
        let name = block.required(self.source, "TYPE")?.to_ascii_uppercase();
        *self.facets.types.entry(excerpt(&name)).or_default() += (last - first) as usize;
        if let Some(set) = set {
            self.facets.add(set, (first..last).collect());
        }
        Ok(())
    }

    /// Adds a beam; returns its number.
    fn add_beam(&mut self, label: Label, nodes: Vec<u32>, line: &Data<'_>) -> Result<u32, Error> {
        let same = |pair: &&[u32]| self.deck.nodes[pair[0] as usize].at == self.deck.nodes[pair[1] as usize].at;
        if let Some(pair) = nodes.windows(2).find(same) {
            let node = self.deck.node_name(pair[1]);
            return Err(line.invalid(self.source, "nodes of the beam", &node, "at different positions"));
        }
        self.deck.beams.push(DeckBeam {
            label,
            nodes,
            section: None,
            line: line.at,
        });
        Ok(self.deck.beams.len() as u32 - 1)
    }

    /// Label and nodes of an element, whose lines continue while they end in a comma.
    fn element_line<'t>(
        &self,
        instance: u32,
        line: &Data<'t>,
        lines: &mut std::slice::Iter<'_, Data<'t>>,
        count: usize,
    ) -> Result<(Label, Vec<u32>), Error> {
        let (mut nodes, mut found) = (Vec::with_capacity(count), 0);
        let mut entries = line.entries();
        let label = Label {
            instance,
            number: line.label(self.source, "element", entries.next().unwrap_or(""))?,
        };
        let mut current = line;
        loop {
            for entry in entries {
                let node = Label {
                    instance,
                    number: current.label(self.source, "node", entry)?,
                };
                if found < count {
                    nodes.push(self.node(current.at, node)?);
                }
                found += 1;
            }
            if found >= count || !current.text.ends_with(',') {
                break;
            }
            let Some(next) = lines.next() else { break };
            (current, entries) = (next, next.entries());
        }
        if found != count {
            return Err(self.node_count(line.at, label, found, count));
        }
        Ok((label, nodes))
    }

    fn node_count(&self, at: Line, label: Label, found: usize, expected: usize) -> Error {
        let what = format!("nodes of element {}", self.deck.name(label));
        self.error(at, DeckProblem::Count { what, found, expected })
    }

    /// `*NSET` or `*ELSET`.
    pub(super) fn set(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        let of_nodes = block.key == "NSET";
        let (parameter, what) = if of_nodes {
            ("NSET", "node set")
        } else {
            ("ELSET", "element set")
        };
        let text = block.required(self.source, parameter)?;
        let name = self.named(instance, text, block)?;
        let instance = self.instance_of(instance, block)?;
        let (mut members, mut facets, mut missing) = (Vec::new(), Vec::new(), 0_usize);
        if of_nodes {
            let known = ["NSET", "ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"];
            block.allow(self.source, &known)?;
            if let Some(elements) = block.optional("ELSET") {
                let (solids, facets) = self.element_set(instance, block.at, elements)?;
                for &element in solids {
                    members.extend_from_slice(self.deck.elements[element as usize].cell.nodes());
                }
                for &facet in facets {
                    members.extend_from_slice(self.facets.all[facet as usize].nodes());
                }
                members.sort_unstable();
                members.dedup();
            }
        } else {
            block.allow(self.source, &["ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"])?;
        }
        for line in &block.data {
            if block.flag("GENERATE") {
                let before = members.len() + facets.len();
                let set = (!of_nodes).then_some(name.as_str());
                self.generate(instance, line, set, &mut members, &mut facets)?;
                self.spend(members.len() + facets.len() - before, line.at)?;
                continue;
            }
            for entry in line.entries().filter(|entry| !entry.is_empty()) {
                if let (false, Some(point)) = (of_nodes, self.point(instance, line, entry)) {
                    self.point_sets.entry(name.clone()).or_default().push(point);
                    continue;
                }
                let found = match of_nodes {
                    true => self.node_list(instance, line, entry).map(|nodes| (nodes, Vec::new())),
                    false => self.element_list(instance, line, entry),
                };
                let (more, more_facets) = match found {
                    // Of a mesh only what is used must be whole.
                    Err(Error::Deck {
                        problem: DeckProblem::Undefined { .. },
                        ..
                    }) if self.extent == Extent::Mesh => {
                        missing += 1;
                        continue;
                    }
                    found => found?,
                };
                self.spend(more.len() + more_facets.len(), line.at)?;
                members.extend(more);
                facets.extend(more_facets);
            }
        }
        if missing > 0 {
            self.deck.notes.push(format!(
                "{missing} entries of the {what} `{}` are not in the file and left out of it",
                excerpt(text)
            ));
        }
        let is_empty = members.is_empty() && facets.is_empty();
        self.facets.add(&name, facets);
        if is_empty && self.extent == Extent::Mesh {
            self.deck.notes.push(format!("the {what} `{}` is empty", excerpt(text)));
            return Ok(());
        }
        if is_empty && !self.point_sets.contains_key(&name) {
            let name = excerpt(text);
            return Err(self.error(block.at, DeckProblem::Empty { what, name }));
        }
        match of_nodes {
            true => self.add_nodes(name, block, members),
            false if members.is_empty() => Ok(()),
            false => self.add_elements(name, block, members),
        }
    }

    /// Members of a generated set, all of which must exist; in one of elements those that are no solids go to the set of that
    /// name.
    fn generate(
        &mut self,
        instance: u32,
        line: &Data<'_>,
        element_set: Option<&str>,
        members: &mut Vec<u32>,
        facets: &mut Vec<u32>,
    ) -> Result<(), Error> {
        let [first, last, step] = line.columns::<3>(self.source)?;
        let first = line.label(self.source, "first label", first)?;
        let last = line.label(self.source, "last label", last)?;
        let step = match step {
            "" => 1,
            text => line.label(self.source, "increment", text)?,
        };
        if last < first || (last - first) % step != 0 {
            return Err(line.invalid(
                self.source,
                "generated range",
                line.text,
                "`first, last, increment` that leads from the first label to the last",
            ));
        }
        for number in (first..=last).step_by(step as usize) {
            let label = Label { instance, number };
            if let Some(set) = element_set.filter(|_| self.points.contains_key(&label)) {
                self.point_sets.entry(set.to_owned()).or_default().push(label);
                continue;
            }
            let (index, what) = match element_set {
                None => (&self.nodes, "node"),
                Some(_) => (&self.elements, "element"),
            };
            match (index.get(&label), self.facets.index.get(&label)) {
                (Some(&member), _) => members.push(member),
                (None, Some(&facet)) if element_set.is_some() => facets.push(facet),
                _ => return Err(self.undefined(line.at, what, &self.deck.name(label))),
            }
        }
        Ok(())
    }

    /// The qualified name of a new set or surface of `instance`.
    fn named(&self, instance: u32, name: &str, block: &Block<'_>) -> Result<String, Error> {
        let full = self.full_name(instance, name);
        let prefix = name.split_once('.').map_or("", |(first, _)| first);
        if self.instance_named(prefix).is_some() {
            return Err(self.error(
                block.at,
                DeckProblem::Syntax {
                    found: excerpt(name),
                    reason: "a new name may not begin with the name of an instance and a dot",
                },
            ));
        }
        Ok(full)
    }

    /// Adds to a node set, new or old.
    fn add_nodes(&mut self, name: String, block: &Block<'_>, members: Vec<u32>) -> Result<(), Error> {
        self.spend(members.len(), block.at)?;
        let set = self.deck.node_sets.entry(name.clone()).or_default();
        if block.flag("UNSORTED") && !self.unsorted.contains_key(&name) {
            self.unsorted.insert(name.clone(), set.iter().copied().collect());
        }
        if let Some(seen) = self.unsorted.get_mut(&name) {
            set.extend(members.into_iter().filter(|node| seen.insert(*node)));
            return Ok(());
        }
        let nodes = &self.deck.nodes;
        merge(set, members, |node| nodes[node as usize].label);
        Ok(())
    }

    /// Adds to an element set, new or old.
    fn add_elements(&mut self, name: String, block: &Block<'_>, members: Vec<u32>) -> Result<(), Error> {
        self.spend(members.len(), block.at)?;
        let elements = &self.deck.elements;
        let set = self.deck.element_sets.entry(name).or_default();
        merge(set, members, |element| elements[element as usize].label);
        Ok(())
    }

    /// The solids of a set, and its elements that are no solids.
    fn element_set(&self, instance: u32, at: Line, text: &str) -> Result<(&[u32], &[u32]), Error> {
        let name = self.full_name(instance, text);
        match (self.deck.element_sets.get(&name), self.facets.sets.get(&name)) {
            (None, None) => Err(self.undefined(at, "element set", &name)),
            (solids, facets) => Ok((
                solids.map_or(&[][..], Vec::as_slice),
                facets.map_or(&[][..], Vec::as_slice),
            )),
        }
    }

    /// The element with this label that is no solid.
    fn point(&self, instance: u32, line: &Data<'_>, text: &str) -> Option<Label> {
        let number = line.label(self.source, "element", text).ok()?;
        let label = Label { instance, number };
        self.points.contains_key(&label).then_some(label)
    }

    /// The element with this label, or the elements of this set: solids, and those that are none.
    pub(super) fn element_list(
        &self,
        instance: u32,
        line: &Data<'_>,
        text: &str,
    ) -> Result<(Vec<u32>, Vec<u32>), Error> {
        let (scope, rest) = self.scope(instance, text);
        if !rest.is_empty() && rest.bytes().all(|c| c.is_ascii_digit()) {
            let label = Label {
                instance: scope,
                number: line.label(self.source, "element", rest)?,
            };
            return match (self.elements.get(&label), self.facets.index.get(&label)) {
                (Some(&element), _) => Ok((vec![element], Vec::new())),
                (None, Some(&facet)) => Ok((Vec::new(), vec![facet])),
                (None, None) => Err(self.undefined(line.at, "element", &self.deck.name(label))),
            };
        }
        let (solids, facets) = self.element_set(instance, line.at, text)?;
        Ok((solids.to_vec(), facets.to_vec()))
    }

    pub(super) fn surface(&mut self, instance: u32, block: &Block<'_>) -> Result<(), Error> {
        block.allow(self.source, &["NAME", "TYPE", "INTERNAL"])?;
        let of_elements = block.choice(self.source, "TYPE", &["ELEMENT", "NODE"])? == "ELEMENT";
        let text = block.required(self.source, "NAME")?;
        let name = self.named(instance, text, block)?;
        if let Some(known) = self.deck.surfaces.get(&name) {
            return Err(self.duplicate(block.at, "surface", name.clone(), known.line));
        }
        let (mut faces, mut nodes, mut facets) = (Vec::new(), Vec::new(), Vec::new());
        for line in &block.data {
            let [of, second] = line.columns::<2>(self.source)?;
            if of_elements {
                let (elements, more) = self.element_list(instance, line, of)?;
                self.spend(elements.len() + more.len(), line.at)?;
                if !more.is_empty() && self.extent == Extent::Structure {
                    return Err(line.invalid(
                        self.source,
                        "member of the surface",
                        of,
                        "a solid or a set of solids: elements without section have no faces",
                    ));
                }
                facets.extend(more);
                for element in elements {
                    faces.push((element, self.face(line, element, second)?));
                }
            } else {
                let weight = match second {
                    "" => 1.0,
                    text => line.number(self.source, "weight", text)?,
                };
                let list = self.node_list(instance, line, of)?;
                self.spend(list.len(), line.at)?;
                nodes.extend(list.into_iter().map(|node| (node, weight)));
            }
        }
        let members = if of_elements {
            Members::Faces(faces)
        } else {
            Members::Nodes(nodes)
        };
        let (count, distinct) = match &members {
            Members::Faces(faces) => (faces.len(), faces.iter().collect::<HashSet<_>>().len()),
            Members::Nodes(nodes) => (
                nodes.len(),
                nodes.iter().map(|(node, _)| node).collect::<HashSet<_>>().len(),
            ),
        };
        if !facets.is_empty() {
            self.facets.surfaces.insert(name.clone(), facets);
            if count == 0 {
                return Ok(());
            }
        }
        if count == 0 && self.extent == Extent::Mesh {
            self.deck
                .notes
                .push(format!("the surface `{}` is empty", excerpt(text)));
            return Ok(());
        }
        if count == 0 {
            let (what, name) = ("surface", excerpt(text));
            return Err(self.error(block.at, DeckProblem::Empty { what, name }));
        }
        if count != distinct {
            return Err(self.error(
                block.at,
                DeckProblem::Count {
                    what: format!("different members of surface `{}`", excerpt(text)),
                    found: distinct,
                    expected: count,
                },
            ));
        }
        self.deck.surfaces.insert(
            name,
            Surface {
                members,
                line: block.at,
            },
        );
        Ok(())
    }

    /// Number from zero of the face `S1`, `S2`... of an element.
    fn face(&self, line: &Data<'_>, element: u32, text: &str) -> Result<u8, Error> {
        let count = self.deck.elements[element as usize].cell.element_type().faces.len();
        text.strip_prefix(['S', 's'])
            .and_then(|digits| digits.parse::<u8>().ok())
            .filter(|face| (1..=count).contains(&usize::from(*face)))
            .map(|face| face - 1)
            .ok_or_else(|| {
                line.invalid(
                    self.source,
                    "face",
                    text,
                    "S1 to S6, as far as the element has that many faces",
                )
            })
    }
}

/// Adds members to a set that is sorted by label and has none twice. What continues the set costs nothing for the members
/// that it has, so that sets may grow member by member.
fn merge(set: &mut Vec<u32>, members: Vec<u32>, label: impl Fn(u32) -> Label) {
    let last = set.len().saturating_sub(1);
    set.extend(members);
    if set[last..].windows(2).any(|pair| label(pair[0]) >= label(pair[1])) {
        set.sort_unstable_by_key(|member| label(*member));
        set.dedup();
    }
}
