//! The solids and groups of a Gmsh file.

use super::assemble::ascending;
use super::parts::{Kind, Parts};
use super::reader::Reader;
use crate::Error;
use crate::elements::Cell;
use crate::elements::Corners;
use crate::formats::solid_mesh::{Raw, Side};

impl Parts {
    pub(super) fn solids(self, reader: &Reader) -> Result<Raw, Error> {
        let (mut volumes, mut surfaces) = (self.empty_groups(3), self.empty_groups(2));
        let mut points = [self.empty_groups(0), self.empty_groups(1)];
        let end = reader.end_of_file();
        let (Some(positions), Some(blocks)) = (self.positions, self.blocks) else {
            return Err(reader.syntax(end, "the sections $Nodes and $Elements", "the end of the file"));
        };
        let mut raw = Raw {
            node_labels: vec![0; positions.len()],
            positions,
            strict_facets: true,
            ..Raw::default()
        };
        for (tag, number) in self.tags {
            raw.node_labels[number as usize] = tag;
        }
        let mut skipped = 0;
        for block in blocks {
            let dimension = block.kind.dimension();
            if block.groups.is_empty() && dimension < 3 {
                skipped += block.tags.len();
                continue;
            }
            match block.kind {
                Kind::Solid(row) => {
                    let first = raw.cells.len() as u32;
                    let elements = block.nodes.chunks_exact(row.n_nodes());
                    raw.cells
                        .extend(elements.map(|nodes| Cell::of_type(row, &row.gmsh.ours(nodes))));
                    raw.cell_labels.extend(block.tags);
                    for group in &block.groups {
                        if let Some(group) = volumes.get_mut(group) {
                            group.members.extend(first..raw.cells.len() as u32);
                        }
                    }
                }
                Kind::Face(row) => {
                    let faces = block.nodes.chunks_exact(row.n_nodes);
                    let sides: Vec<Side> = faces
                        .map(|nodes| Side::Facet(Corners::new(&nodes[..row.n_corners])))
                        .collect();
                    for group in &block.groups {
                        if let Some(group) = surfaces.get_mut(group) {
                            group.members.extend(&sides);
                        }
                    }
                }
                Kind::Nodes { .. } => {
                    for group in &block.groups {
                        if let Some(group) = points[usize::from(dimension == 1)].get_mut(group) {
                            group.members.extend(&block.nodes);
                        }
                    }
                }
            }
        }
        if raw.cells.is_empty() {
            return Err(reader.no_solids());
        }
        if skipped > 0 {
            raw.notes.push(format!(
                "{skipped} points, lines and faces that are in no physical group are skipped"
            ));
        }
        if !self.skipped.is_empty() {
            let sections: Vec<String> = self.skipped.iter().map(|name| format!("${name}")).collect();
            raw.notes
                .push(format!("the sections {} are not read", sections.join(", ")));
        }
        raw.volumes = volumes.into_values().collect();
        raw.surfaces = surfaces.into_values().collect();
        raw.points = points.into_iter().flat_map(ascending).collect();
        Ok(raw)
    }
}
