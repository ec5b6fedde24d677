//! The mesh and the groups that the sections of a Gmsh file make.

use super::parts::{Block, Contents, Kind, Parts};
use super::reader::Reader;
use crate::Error;
use crate::elements::{Cell, ElementType, Face};
use crate::formats::common::Kept;
use crate::mesh::{Element, Group, Material, Mesh};
use std::collections::{BTreeMap, BTreeSet};

impl Parts {
    pub(super) fn name(&self, dimension: i32, group: u32) -> String {
        let name = self.names.get(&(dimension, group));
        name.cloned().unwrap_or_else(|| group.to_string())
    }

    /// The groups of a dimension with elements of it or a name, still empty.
    pub(super) fn empty_groups<T>(&self, dimension: i32) -> BTreeMap<u32, Group<T>> {
        let named = self
            .names
            .keys()
            .filter(|(d, _)| *d == dimension)
            .map(|(_, group)| *group);
        let blocks = self.blocks.iter().flatten();
        let used = blocks.filter(|block| block.kind.dimension() == dimension);
        named
            .chain(used.flat_map(|block| block.groups.iter().copied()))
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
        let names: Vec<String> = block.groups.iter().map(|&group| self.name(3, group)).collect();
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

    pub(super) fn assemble(
        &self,
        reader: &Reader,
        materials: &[Material],
        fallback: Option<&Material>,
    ) -> Result<Contents, Error> {
        let end = reader.end_of_file();
        let (Some(positions), Some(blocks)) = (&self.positions, &self.blocks) else {
            return Err(reader.syntax(end, "the sections $Nodes and $Elements", "the end of the file"));
        };
        let solids = blocks.iter().filter(|block| block.kind.dimension() == 3);
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
            let groups = block.groups.iter();
            let dimension = block.kind.dimension();
            if block.groups.is_empty() && dimension < 3 {
                ignored_elements += block.nodes.len() / block.kind.n_nodes();
                continue;
            }
            match block.kind {
                Kind::Solid(row) => {
                    let material = self.material(reader, block, materials, fallback_number)?;
                    if usize::from(material) == mesh.materials.len() {
                        mesh.materials.extend(fallback.cloned());
                    }
                    mesh.elements.extend(solid_elements(block, row, &kept, material));
                }
                Kind::Face(_) => {
                    let members = faces_of(reader, block, &kept)?;
                    for group in groups {
                        if let Some(group) = faces.get_mut(group) {
                            group.members.extend(&members);
                        }
                    }
                }
                Kind::Nodes { .. } => {
                    let lists = &mut nodes[usize::from(dimension == 1)];
                    for group in groups {
                        if let Some(group) = lists.get_mut(group) {
                            let members = block.nodes.iter().filter_map(|node| kept.number(*node));
                            group.members.extend(members);
                        }
                    }
                }
            }
        }
        if mesh.elements.is_empty() {
            return Err(reader.no_solids());
        }
        Ok(Contents {
            orphan_nodes: positions.len() - mesh.nodes.len(),
            mesh,
            faces: faces.into_values().collect(),
            nodes: nodes.into_iter().flat_map(ascending).collect(),
            ignored_elements,
            skipped_sections: self.skipped.clone(),
        })
    }
}

/// The groups of a dimension, each with ascending members that differ.
pub(super) fn ascending(groups: BTreeMap<u32, Group<u32>>) -> impl Iterator<Item = Group<u32>> {
    groups.into_values().map(|mut group| {
        group.members.sort_unstable();
        group.members.dedup();
        group
    })
}

/// The elements of a block of solids, whose nodes are all kept.
fn solid_elements<'b>(
    block: &'b Block,
    row: &'static ElementType,
    kept: &'b Kept,
    material: u16,
) -> impl Iterator<Item = Element> + 'b {
    block.nodes.chunks_exact(row.n_nodes()).filter_map(move |old| {
        let new: Vec<u32> = old.iter().filter_map(|node| kept.number(*node)).collect();
        let cell = Cell::try_new(row, row.default_formulation(), &row.gmsh.ours(&new))?;
        Some(Element { cell, material })
    })
}

/// The faces of a block, all of which must belong to solids.
fn faces_of(reader: &Reader, block: &Block, kept: &Kept) -> Result<Vec<Face>, Error> {
    let mut members = Vec::new();
    for old in block.nodes.chunks_exact(block.kind.n_nodes()) {
        let new: Vec<u32> = old.iter().filter_map(|node| kept.number(*node)).collect();
        if new.len() < old.len() {
            return Err(reader.contents(
                block.at,
                format!(
                    "a face of surface {}, which is in a physical group, belongs to no solid",
                    block.entity
                ),
                "mesh the volume beside the surface and put it into a physical volume, or ungroup the surface",
            ));
        }
        members.extend(Face::from_nodes(&new));
    }
    Ok(members)
}
