//! The solids, sets and surfaces of a deck.

use super::deck::{Ignored, Members};
use super::reader::Reader;
use crate::Error;
use crate::elements::Corners;
use crate::error::Position;
use crate::formats::solid_mesh::{Raw, Side};
use crate::mesh::Group;
use std::collections::BTreeMap;

impl Reader<'_> {
    pub(super) fn solid_mesh(self) -> Result<Raw, Error> {
        let Self {
            source,
            deck,
            facets,
            left_out,
            ..
        } = self;
        if deck.elements.is_empty() {
            let at = source.last_line();
            // An empty file has no line.
            let line = at.number.max(1) as usize;
            return Err(Error::MeshContents {
                file: source.files[at.file as usize].clone(),
                at: Position::Line(line),
                // What was left out may be why: a part without an instance, say.
                problem: format!(
                    "the file holds no solids{}",
                    deck.notes.first().map_or_else(String::new, |note| format!(" ({note})"))
                ),
                remedy: "mesh in three dimensions, and save elements of types C3D4, C3D10, C3D6, C3D15, C3D8 or C3D20",
            });
        }
        let mut notes = deck.notes;
        notes.extend(facets.note("are skipped"));
        if !left_out.is_empty() {
            let counts: Vec<String> = left_out
                .iter()
                .map(|Ignored { keyword, count, .. }| format!("{count} *{keyword}"))
                .collect();
            notes.push(format!(
                "{} are not read from a mesh; use structure.deck to keep them",
                counts.join(", ")
            ));
        }
        let ignored: Vec<String> = deck
            .ignored
            .iter()
            .filter(|ignored| ignored.keyword != "HEADING")
            .map(|ignored| format!("*{}", ignored.keyword))
            .collect();
        if !ignored.is_empty() {
            notes.push(format!("{} are ignored, as in decks", ignored.join(", ")));
        }
        let mut surfaces: BTreeMap<String, Vec<Side>> = BTreeMap::new();
        let mut points = deck.node_sets;
        for (name, surface) in deck.surfaces {
            match surface.members {
                Members::Faces(faces) => {
                    let sides = faces.into_iter().map(|(cell, face)| Side::OfCell(cell, face));
                    surfaces.insert(name, sides.collect());
                }
                Members::Nodes(nodes) => {
                    let nodes = nodes.into_iter().map(|(node, _)| node);
                    add(&mut points, name, nodes.collect(), "*SURFACE of nodes", &mut notes);
                }
            }
        }
        let side = |facet: &u32| {
            let corners = facets.all[*facet as usize].corners();
            corners.map(|corners| Side::Facet(Corners::new(corners)))
        };
        for (name, members) in &facets.surfaces {
            let sides = members.iter().filter_map(side);
            surfaces.entry(name.clone()).or_default().extend(sides);
        }
        for (name, members) in &facets.sets {
            let sides: Vec<Side> = members.iter().filter_map(side).collect();
            add(&mut surfaces, name.clone(), sides, "*ELSET of facets", &mut notes);
            let lines = members.iter().map(|facet| &facets.all[*facet as usize]);
            let lines = lines.filter(|line| line.corners().is_none());
            let nodes: Vec<u32> = lines.flat_map(|line| line.nodes()).copied().collect();
            // A set of nodes and one of lines with one name are the same group, as Gmsh writes it.
            if !points.contains_key(name) {
                add(&mut points, name.clone(), nodes, "*ELSET of lines", &mut notes);
            }
        }
        Ok(Raw {
            positions: deck.nodes.iter().map(|node| node.at).collect(),
            node_labels: deck.nodes.iter().map(|node| node.label.number.into()).collect(),
            cells: deck.elements.iter().map(|element| element.cell).collect(),
            cell_labels: deck
                .elements
                .iter()
                .map(|element| element.label.number.into())
                .collect(),
            volumes: groups(deck.element_sets),
            surfaces: groups(surfaces),
            points: groups(points),
            notes,
            ..Raw::default()
        })
    }
}

fn groups<T>(sets: BTreeMap<String, Vec<T>>) -> Vec<Group<T>> {
    let group = |(name, members)| Group { name, members };
    sets.into_iter().map(group).collect()
}

/// Adds a group that has members, unless the name is taken.
fn add<T>(groups: &mut BTreeMap<String, Vec<T>>, name: String, members: Vec<T>, what: &str, notes: &mut Vec<String>) {
    if members.is_empty() {
        return;
    }
    if groups.contains_key(&name) {
        notes.push(format!(
            "the {what} `{name}` is left out, since another group has its name"
        ));
        return;
    }
    groups.insert(name, members);
}
