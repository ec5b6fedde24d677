//! What a format hands over, and how a mesh is made of it.

use super::checks;
use super::mesh::{Defect, SolidMesh};
use crate::Error;
use crate::elements::Face;
use crate::elements::{Corners, Sides};
use crate::error::known_names;
use crate::formats::common::Kept;
use crate::mesh::{Cell, Group};
use std::collections::{BTreeMap, HashSet};

/// A member of a surface, as the file gives it.
#[derive(Clone, Copy, Debug)]
pub(in crate::formats) enum Side {
    /// A face of a cell, by its number from zero.
    OfCell(u32, u8),
    /// A facet element, by the file's nodes.
    Facet(Corners),
    /// A face of a cell, by the mesh's nodes.
    Listed(Corners),
}

/// The contents of a file, with all the nodes that it has.
#[derive(Default)]
pub(in crate::formats) struct Raw {
    pub(in crate::formats) positions: Vec<[f64; 3]>,
    pub(in crate::formats) node_labels: Vec<u64>,
    pub(in crate::formats) cells: Vec<Cell>,
    pub(in crate::formats) cell_labels: Vec<u64>,
    pub(in crate::formats) volumes: Vec<Group<u32>>,
    pub(in crate::formats) surfaces: Vec<Group<Side>>,
    /// Whether facets that are no faces of solids are an error, and not only where they are used.
    pub(in crate::formats) strict_facets: bool,
    pub(in crate::formats) points: Vec<Group<u32>>,
    pub(in crate::formats) notes: Vec<String>,
    /// Whether a group of nodes is also the surface of all faces whose nodes are in it. Some programs have no other groups.
    pub(in crate::formats) faces_of_points: bool,
    /// The one integer array of a VTU file.
    pub(in crate::formats) array: Option<String>,
}

impl Raw {
    /// Leaves out groups without members, such as names that a geometry gives to what is not meshed.
    fn drop_empty_groups(&mut self) {
        let mut empty = Vec::new();
        self.volumes.retain(|group| keep(group, "volume", &mut empty));
        self.surfaces.retain(|group| keep(group, "surface", &mut empty));
        self.points.retain(|group| keep(group, "group of nodes", &mut empty));
        self.notes.extend(empty);
    }

    /// Lists the nodes of these cells the other way round. Their faces are kept by their corners, since their numbers change.
    fn mirror(&mut self, mirrored: &[usize]) {
        if mirrored.is_empty() {
            return;
        }
        for side in self.surfaces.iter_mut().flat_map(|group| &mut group.members) {
            if let Side::OfCell(cell, face) = *side {
                *side = Side::Listed(Corners::of_face(&self.cells[cell as usize], usize::from(face)));
            }
        }
        for &cell in mirrored {
            self.cells[cell] = checks::mirrored(&self.cells[cell]);
        }
        self.notes.push(format!(
            "{} of {} solids list their nodes in mirrored order; they are read the other way round",
            mirrored.len(),
            self.cells.len()
        ));
    }

    pub(in crate::formats) fn finish(mut self, file: &str) -> Result<SolidMesh, Error> {
        let kept = Kept::new(
            self.positions.len(),
            self.cells.iter().flat_map(|cell| cell.nodes().iter().copied()),
        );
        let orphans = self.positions.len() - kept.old.len();
        let nodes: Vec<[f64; 3]> = kept.old.iter().map(|old| self.positions[*old as usize]).collect();
        let labels: Vec<u64> = kept.old.iter().map(|old| self.node_labels[*old as usize]).collect();
        for cell in &mut self.cells {
            // All nodes of cells are kept.
            *cell = cell.map_nodes(|node| kept.number(node).unwrap_or(node));
        }
        let mirrored = checks::check(file, &nodes, &self.cells, &self.cell_labels)?;
        self.mirror(&mirrored);
        if orphans > 0 {
            self.notes.push(match orphans {
                1 => "1 node that belongs to no solid is dropped".into(),
                _ => format!("{orphans} nodes that belong to no solid are dropped"),
            });
        }
        for group in &mut self.volumes {
            group.members.sort_unstable();
            group.members.dedup();
        }
        self.drop_empty_groups();
        for group in &mut self.points {
            let before = group.members.len();
            let mut members: Vec<u32> = group.members.iter().filter_map(|old| kept.number(*old)).collect();
            if members.len() < before {
                self.notes.push(format!(
                    "{} of the {before} nodes of the group `{}` belong to no solid and are left out of it",
                    before - members.len(),
                    group.name
                ));
            }
            members.sort_unstable();
            members.dedup();
            group.members = members;
        }
        self.points.retain(|group| !group.members.is_empty());
        let mut surfaces = Vec::new();
        let mut defects = BTreeMap::new();
        if !self.surfaces.is_empty() {
            let sides = Sides::of(&self.cells);
            for group in self.surfaces {
                match surface(&group.members, &self.cells, &sides, &kept) {
                    Ok(members) => surfaces.push(Group {
                        name: group.name,
                        members,
                    }),
                    Err(defect) if defect.interior == 0 && self.strict_facets => {
                        return Err(defect.error(file, &group.name));
                    }
                    Err(defect) => {
                        let problem = defect.problem();
                        self.notes
                            .push(format!("the group `{}` is no surface: {problem}", group.name));
                        defects.insert(group.name, defect);
                    }
                }
            }
        }
        if self.faces_of_points {
            let named: HashSet<&str> = surfaces.iter().map(|group: &Group<Face>| group.name.as_str()).collect();
            let unnamed = |group: &&Group<u32>| !named.contains(group.name.as_str());
            let made = faces_within(&self.cells, nodes.len(), self.points.iter().filter(unnamed));
            if !made.is_empty() {
                let names: Vec<&str> = made.iter().map(|group| group.name.as_str()).collect();
                self.notes.push(format!(
                    "groups of nodes that are also surfaces, of the faces with all their nodes in them: {}",
                    known_names(names.into_iter())
                ));
            }
            surfaces.extend(made);
        }
        Ok(SolidMesh {
            nodes,
            labels,
            cells: self.cells,
            volumes: self.volumes,
            surfaces,
            points: self.points,
            notes: self.notes,
            file: file.to_owned(),
            defects,
            array: self.array,
        })
    }
}

/// The surfaces of groups of nodes: faces of one cell only that have all their nodes in the group.
fn faces_within<'g>(cells: &[Cell], n_nodes: usize, groups: impl Iterator<Item = &'g Group<u32>>) -> Vec<Group<Face>> {
    let mut groups = groups.peekable();
    if groups.peek().is_none() {
        return Vec::new();
    }
    let boundary = Sides::of(cells).boundary(cells);
    // Each face is looked for at its first node alone, so that the work is that of the members.
    let mut at_node = vec![Vec::new(); n_nodes];
    for (number, (face, _)) in (0_u32..).zip(&boundary) {
        at_node[face.nodes()[0] as usize].push(number);
    }
    let mut is_member = vec![false; n_nodes];
    let made = groups.filter_map(|group| {
        group.members.iter().for_each(|node| is_member[*node as usize] = true);
        let near = group.members.iter().flat_map(|node| &at_node[*node as usize]);
        let faces = near.map(|number| boundary[*number as usize].0);
        let within = faces.filter(|face| face.nodes().iter().all(|node| is_member[*node as usize]));
        let members: Vec<Face> = within.collect();
        group.members.iter().for_each(|node| is_member[*node as usize] = false);
        (!members.is_empty()).then(|| Group {
            name: group.name.clone(),
            members,
        })
    });
    made.collect()
}

/// Whether a group has members; if not, this is noted.
fn keep<T>(group: &Group<T>, what: &str, notes: &mut Vec<String>) -> bool {
    if group.members.is_empty() {
        notes.push(format!("the {what} `{}` is empty and left out", group.name));
    }
    !group.members.is_empty()
}

/// The faces of a group, outward, each once.
fn surface(members: &[Side], cells: &[Cell], sides: &Sides, kept: &Kept) -> Result<Vec<Face>, Defect> {
    let (mut faces, mut seen) = (Vec::with_capacity(members.len()), HashSet::new());
    let mut defect = Defect {
        interior: 0,
        beside: 0,
        count: members.len(),
    };
    for side in members {
        let corners = match *side {
            Side::OfCell(cell, face) => Some(Corners::of_face(&cells[cell as usize], usize::from(face))),
            Side::Listed(corners) => Some(corners),
            Side::Facet(corners) => corners.map(|node| kept.number(node)),
        };
        match corners.map_or(&[][..], |corners| sides.with(corners)) {
            [] => defect.beside += 1,
            [one] => {
                if seen.insert((one.cell, one.face)) {
                    faces.push(cells[one.cell as usize].face(usize::from(one.face)));
                }
            }
            _ => defect.interior += 1,
        }
    }
    match defect {
        Defect {
            interior: 0, beside: 0, ..
        } => Ok(faces),
        _ => Err(defect),
    }
}
