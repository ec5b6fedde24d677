//! The solids of a VTK file, and the groups that integer arrays of its cells make.

use super::contents::{Kind, ours};
use super::document::{Array, Grid, Reader};
use crate::Error;
use crate::elements::Cell;
use crate::elements::Corners;
use crate::formats::solid_mesh::{Raw, Side};
use crate::mesh::Group;
use std::collections::{BTreeMap, BTreeSet};

/// How many values an array may have to make groups: numbers of cells and the like make none.
const MOST_VALUES: usize = 1000;

/// What the cells with one value make.
#[derive(Default)]
struct Groups {
    volume: Vec<u32>,
    surface: Vec<Side>,
    points: Vec<u32>,
}

impl<'a> Reader<'a> {
    pub(super) fn solid_mesh(&self, grid: &Grid<'a>) -> Result<Raw, Error> {
        self.check_piece(grid)?;
        let positions = self.coordinates(grid)?;
        let connectivity = self.connectivity(grid, positions.len())?;
        let cells = self.cells(grid, &connectivity)?;
        let mut raw = Raw {
            node_labels: (0..positions.len() as u64).collect(),
            ..Raw::default()
        };
        let (mut reversed, mut lower) = (0, 0);
        for (label, (kind, points)) in (0..).zip(&cells) {
            let Kind::Solid(row) = kind else {
                lower += 1;
                continue;
            };
            let (nodes, is_reversed) = ours(row, points, &positions);
            reversed += usize::from(is_reversed);
            raw.cells.push(Cell::of_type(row, &nodes));
            raw.cell_labels.push(label);
        }
        raw.positions = positions;
        if reversed > 0 {
            raw.notes.push(format!(
                "{reversed} wedges list their first triangle counter-clockwise from outside, as older versions of VTK do"
            ));
        }
        let integers = grid.arrays[3]
            .iter()
            .filter(|array| array.components == 1 && (array.kind.starts_with("Int") || array.kind.starts_with("UInt")));
        let mut names = Vec::new();
        for array in integers {
            if self.groups(grid, array, &cells, &mut raw)? {
                names.push(array.name.clone());
            }
        }
        if lower > 0 && names.is_empty() {
            raw.notes.push(format!(
                "{lower} points, lines and faces that are in no group are skipped"
            ));
        }
        if let [_] = names[..] {
            raw.array = names.pop();
        }
        Ok(raw)
    }

    /// The groups of an array, unless it has too many values.
    fn groups(
        &self,
        grid: &Grid<'a>,
        array: &Array<'a>,
        cells: &[(Kind, &[u32])],
        raw: &mut Raw,
    ) -> Result<bool, Error> {
        let values = self.exactly(grid, array, Some(grid.n_cells))?;
        let mut distinct = BTreeSet::new();
        for value in &values {
            distinct.insert(*value as i64);
            if distinct.len() > MOST_VALUES {
                raw.notes.push(format!(
                    "the cell array `{}` has more than {MOST_VALUES} values and makes no groups",
                    array.name
                ));
                return Ok(false);
            }
        }
        let mut groups: BTreeMap<i64, Groups> = BTreeMap::new();
        let mut solid = 0;
        for ((kind, points), value) in cells.iter().zip(&values) {
            let group = groups.entry(*value as i64).or_default();
            match kind {
                Kind::Solid(_) => {
                    group.volume.push(solid);
                    solid += 1;
                }
                Kind::Face(row) => group.surface.push(Side::Facet(Corners::new(&points[..row.n_corners]))),
                Kind::Nodes(_) => group.points.extend_from_slice(points),
            }
        }
        for (
            value,
            Groups {
                volume,
                surface,
                points,
            },
        ) in groups
        {
            let name = || format!("{}={value}", array.name);
            push(&mut raw.volumes, name, volume);
            push(&mut raw.surfaces, name, surface);
            push(&mut raw.points, name, points);
        }
        Ok(true)
    }
}

/// Adds a group that has members.
fn push<T>(groups: &mut Vec<Group<T>>, name: impl Fn() -> String, members: Vec<T>) {
    if !members.is_empty() {
        groups.push(Group { name: name(), members });
    }
}
