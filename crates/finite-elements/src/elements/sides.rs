//! Which cells have a face.

use super::{Cell, Face};
use rayon::slice::ParallelSliceMut;

/// The corners of a face, ascending: what tells faces apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Corners(
    /// Triangles have a number in the last place that no node has.
    [u32; 4],
);

impl Corners {
    /// Of three or four nodes.
    pub(crate) fn new(nodes: &[u32]) -> Self {
        let mut corners = [u32::MAX; 4];
        for (corner, node) in corners.iter_mut().zip(nodes) {
            *corner = *node;
        }
        corners.sort_unstable();
        Self(corners)
    }

    pub(crate) fn of_face(cell: &Cell, face: usize) -> Self {
        let (row, locals) = cell.element_type().faces[face];
        let nodes = cell.nodes();
        let mut corners = [u32::MAX; 4];
        for (corner, local) in corners.iter_mut().zip(&locals[..row.n_corners]) {
            *corner = nodes[*local];
        }
        corners.sort_unstable();
        Self(corners)
    }

    /// The same face with other numbers of its nodes, unless one has none.
    pub(crate) fn map(self, of: impl Fn(u32) -> Option<u32>) -> Option<Self> {
        let mut corners = self.0;
        for node in corners.iter_mut().filter(|node| **node != u32::MAX) {
            *node = of(*node)?;
        }
        corners.sort_unstable();
        Some(Self(corners))
    }
}

/// A face of a cell.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct FaceOf {
    corners: Corners,
    pub(crate) cell: u32,
    pub(crate) face: u8,
}

/// All faces of all cells, sorted by their corners.
pub(crate) struct Sides(Vec<FaceOf>);

impl Sides {
    pub(crate) fn of(cells: &[Cell]) -> Self {
        let count = cells.iter().map(|cell| cell.element_type().faces.len()).sum();
        let mut all = Vec::with_capacity(count);
        for (number, cell) in (0..).zip(cells) {
            for face in 0..cell.element_type().faces.len() {
                all.push(FaceOf {
                    corners: Corners::of_face(cell, face),
                    cell: number,
                    face: face as u8,
                });
            }
        }
        all.par_sort_unstable();
        Self(all)
    }

    /// The faces with these corners.
    pub(crate) fn with(&self, corners: Corners) -> &[FaceOf] {
        let start = self.0.partition_point(|side| side.corners < corners);
        let count = self.0[start..]
            .iter()
            .take_while(|side| side.corners == corners)
            .count();
        &self.0[start..start + count]
    }

    /// Cell and number of the faces that one cell alone has.
    pub(crate) fn alone(&self) -> impl Iterator<Item = (u32, u8)> {
        let shared = self.0.chunk_by(|a, b| a.corners == b.corners);
        shared.filter_map(|faces| match faces {
            [one] => Some((one.cell, one.face)),
            _ => None,
        })
    }

    /// These faces, outward, with their cells, in the order of the cells.
    pub(crate) fn boundary(&self, cells: &[Cell]) -> Vec<(Face, u32)> {
        let mut alone: Vec<(u32, u8)> = self.alone().collect();
        alone.sort_unstable();
        let face = |(cell, face): (u32, u8)| (cells[cell as usize].face(usize::from(face)), cell);
        alone.into_iter().map(face).collect()
    }
}
