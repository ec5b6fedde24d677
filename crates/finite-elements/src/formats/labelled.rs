//! What formats hand over whose nodes and elements go by numbers, in any order.

use super::solid_mesh::{Raw, Side};
use crate::Error;
use crate::elements::{Cell, Corners, ElementType};
use crate::mesh::Group;
use std::collections::HashMap;

/// What an element is to a mesh of solids.
#[derive(Clone, Copy)]
pub(super) enum Shape {
    /// A solid, with nodes in the order of the crate.
    Solid(&'static ElementType),
    /// A facet with so many corners, which come first.
    Facet(usize),
    /// Of anything else only the nodes count.
    Nodes,
}

/// Which face of a solid is meant.
pub(super) enum Which {
    /// The quadrilateral with these corners on its diagonal; of a tetrahedron the triangle that the second one is not on.
    Diagonal(u64, u64),
    /// The triangle with this corner.
    Triangle(u64),
    /// The face with these corners.
    Through([u64; 3]),
}

/// A number of a group that [`Labelled::group`] returned.
#[derive(Clone, Copy)]
pub(super) struct GroupId(usize);

struct Element {
    label: u64,
    /// Where it stands, in the numbers of the reader.
    at: u32,
    shape: Shape,
    first: usize,
    groups: [Option<GroupId>; 2],
}

struct FaceOf {
    at: u32,
    group: GroupId,
    element: u64,
    which: Which,
}

/// Nodes, elements and groups as a file numbers them.
#[derive(Default)]
pub(super) struct Labelled {
    positions: Vec<[f64; 3]>,
    node_labels: Vec<u64>,
    of_node: HashMap<u64, u32>,
    elements: Vec<Element>,
    connectivity: Vec<u64>,
    groups: Vec<String>,
    of_group: HashMap<String, GroupId>,
    sets: Vec<(GroupId, Vec<u64>)>,
    node_sets: Vec<(GroupId, Vec<u64>)>,
    faces: Vec<FaceOf>,
    pub(super) notes: Vec<String>,
}

/// Members of a group by their dimension.
#[derive(Clone, Default)]
struct Members {
    volume: Vec<u32>,
    surface: Vec<Side>,
    points: Vec<u32>,
}

/// Makes the error of a place, given in the numbers of the reader.
pub(super) type Refuse<'a> = dyn Fn(u32, String, &'static str) -> Error + 'a;

impl Labelled {
    /// Adds a node.
    pub(super) fn node(&mut self, at: u32, label: u64, position: [f64; 3], refuse: &Refuse<'_>) -> Result<(), Error> {
        let number = self.positions.len() as u32;
        if self.of_node.insert(label, number).is_some() {
            return Err(refuse(
                at,
                format!("node {label} is given twice"),
                "remove one of the two",
            ));
        }
        if let Some(value) = position.iter().find(|x| !x.is_finite()) {
            return Err(Error::NotFinite {
                place: format!("coordinates of node {label}"),
                value: *value,
            });
        }
        self.positions.push(position);
        self.node_labels.push(label);
        Ok(())
    }

    /// The group with this name, made where there is none.
    pub(super) fn group(&mut self, name: String) -> GroupId {
        if let Some(known) = self.of_group.get(&name) {
            return *known;
        }
        let id = GroupId(self.groups.len());
        self.groups.push(name.clone());
        self.of_group.insert(name, id);
        id
    }

    /// Gives a group another name.
    pub(super) fn rename(&mut self, old: &str, new: &str) {
        if !self.of_group.contains_key(new)
            && let Some(id) = self.of_group.remove(old)
        {
            new.clone_into(&mut self.groups[id.0]);
            self.of_group.insert(new.to_owned(), id);
        }
    }

    /// Adds an element. Numbers of elements may repeat while no set names them.
    pub(super) fn element(&mut self, at: u32, label: u64, shape: Shape, nodes: &[u64], groups: [Option<GroupId>; 2]) {
        self.elements.push(Element {
            label,
            at,
            shape,
            first: self.connectivity.len(),
            groups,
        });
        self.connectivity.extend_from_slice(nodes);
    }

    /// Adds elements to a group.
    pub(super) fn set(&mut self, group: GroupId, elements: Vec<u64>) {
        self.sets.push((group, elements));
    }

    /// Adds nodes to a group.
    pub(super) fn node_set(&mut self, group: GroupId, nodes: Vec<u64>) {
        self.node_sets.push((group, nodes));
    }

    /// Adds a face of a solid to a group.
    pub(super) fn face(&mut self, at: u32, group: GroupId, element: u64, which: Which) {
        self.faces.push(FaceOf {
            at,
            group,
            element,
            which,
        });
    }

    /// The mesh of all that was added.
    ///
    /// # Errors
    /// What `refuse` makes of nodes and elements that are not there, and of numbers given twice.
    pub(super) fn finish(self, refuse: &Refuse<'_>) -> Result<Raw, Error> {
        let mut raw = Raw {
            positions: self.positions,
            node_labels: self.node_labels,
            notes: self.notes,
            faces_of_points: true,
            ..Raw::default()
        };
        let mut members = vec![Members::default(); self.groups.len()];
        // What each number of an element stands for: a cell, a facet, or other nodes.
        let mut known: HashMap<u64, Member> = HashMap::new();
        let is_named = !self.sets.is_empty() || !self.faces.is_empty();
        let ends = self.elements.iter().skip(1).map(|element| element.first);
        let ends = ends.chain([self.connectivity.len()]);
        let mut nodes = Vec::new();
        for (element, end) in self.elements.iter().zip(ends) {
            nodes.clear();
            for label in &self.connectivity[element.first..end] {
                nodes.push(*self.of_node.get(label).ok_or_else(|| {
                    refuse(
                        element.at,
                        format!(
                            "element {} uses the node {label}, which is not in the file",
                            element.label
                        ),
                        "save the mesh with all its nodes",
                    )
                })?);
            }
            let member = match element.shape {
                Shape::Solid(row) => {
                    raw.cells.push(Cell::of_type(row, &nodes));
                    raw.cell_labels.push(element.label);
                    Member::Cell(raw.cells.len() as u32 - 1)
                }
                Shape::Facet(corners) => Member::Facet(Corners::new(&nodes[..corners])),
                Shape::Nodes => Member::Nodes(element.first, end),
            };
            for group in element.groups.into_iter().flatten() {
                members[group.0].add(&member, |_| nodes.clone());
            }
            if is_named && known.insert(element.label, member).is_some() {
                return Err(refuse(
                    element.at,
                    format!("element {} is given twice", element.label),
                    "remove one of the two, or number the elements anew",
                ));
            }
        }
        let of_nodes = |&(first, end): &(usize, usize)| -> Vec<u32> {
            let labels = self.connectivity[first..end].iter();
            labels.filter_map(|label| self.of_node.get(label).copied()).collect()
        };
        for (group, elements) in &self.sets {
            let found = elements.iter().filter_map(|label| known.get(label));
            let count = found.clone().count();
            found.for_each(|member| members[group.0].add(member, of_nodes));
            note_missing(&mut raw.notes, &self.groups[group.0], "elements", count, elements.len());
        }
        for (group, nodes) in &self.node_sets {
            let found: Vec<u32> = nodes
                .iter()
                .filter_map(|label| self.of_node.get(label).copied())
                .collect();
            note_missing(&mut raw.notes, &self.groups[group.0], "nodes", found.len(), nodes.len());
            members[group.0].points.extend(found);
        }
        for wanted in &self.faces {
            let side = match known.get(&wanted.element) {
                Some(Member::Cell(cell)) => {
                    let label = |node: u32| raw.node_labels[node as usize];
                    let face = wanted.which.of(&raw.cells[*cell as usize], label);
                    face.map(|face| Side::OfCell(*cell, face as u8))
                }
                _ => None,
            };
            let side = side.ok_or_else(|| {
                refuse(
                    wanted.at,
                    format!("the nodes given for element {} are no face of a solid", wanted.element),
                    "correct the nodes, or remove the line",
                )
            })?;
            members[wanted.group.0].surface.push(side);
        }
        for (name, members) in self.groups.into_iter().zip(members) {
            push(&mut raw.volumes, &name, members.volume);
            push(&mut raw.surfaces, &name, members.surface);
            push(&mut raw.points, &name, members.points);
        }
        Ok(raw)
    }
}

/// Notes members of a group that are not there.
fn note_missing(notes: &mut Vec<String>, group: &str, what: &str, found: usize, all: usize) {
    if found < all {
        notes.push(format!(
            "{} of the {all} {what} of the group `{group}` are not read from the file and left out of it",
            all - found,
        ));
    }
}

/// What the number of an element stands for.
enum Member {
    Cell(u32),
    Facet(Corners),
    /// The range of its nodes among all.
    Nodes(usize, usize),
}

impl Members {
    fn add(&mut self, member: &Member, of_nodes: impl Fn(&(usize, usize)) -> Vec<u32>) {
        match member {
            Member::Cell(cell) => self.volume.push(*cell),
            Member::Facet(corners) => self.surface.push(Side::Facet(*corners)),
            Member::Nodes(first, end) => self.points.extend(of_nodes(&(*first, *end))),
        }
    }
}

impl Which {
    /// The number of the face of a cell; none if it has no such face, or several.
    fn of(&self, cell: &Cell, label: impl Fn(u32) -> u64) -> Option<usize> {
        let row = cell.element_type();
        let is_meant = |face: &usize| {
            let (face_type, locals) = row.faces[*face];
            let corners: Vec<u64> = locals[..face_type.n_corners]
                .iter()
                .map(|local| label(cell.nodes()[*local]))
                .collect();
            match *self {
                Self::Triangle(a) => corners.len() == 3 && corners.contains(&a),
                Self::Through(all) => all.iter().all(|a| corners.contains(a)),
                Self::Diagonal(a, b) if row.faces.len() == 4 => corners.contains(&a) && !corners.contains(&b),
                Self::Diagonal(a, b) => {
                    (0..corners.len()).any(|i| corners.len() == 4 && corners[i] == a && corners[(i + 2) % 4] == b)
                }
            }
        };
        let mut found = (0..row.faces.len()).filter(is_meant);
        let first = found.next();
        found.next().is_none().then_some(first).flatten()
    }
}

/// Adds a group that has members.
fn push<T>(groups: &mut Vec<Group<T>>, name: &str, members: Vec<T>) {
    if !members.is_empty() {
        groups.push(Group {
            name: name.to_owned(),
            members,
        });
    }
}
