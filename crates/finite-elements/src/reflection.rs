//! Reflections that take a mesh to itself.

use crate::constraints::DofMap;
use crate::mesh::Mesh;
use crate::sets::DisjointSets;
use crate::sparse::from_unsorted_rows;
use sprs::CsMat;
use std::collections::{BTreeMap, HashMap};

/// Distance between a node and the image of another that are the same, relative to the size of the mesh.
const SAME_PLACE: f64 = 1e-8;

/// A reflection at the plane across a coordinate axis through the middle of a mesh.
#[derive(Clone, Debug)]
pub struct Reflection {
    /// 0, 1 or 2.
    pub axis: usize,
    /// Where the plane cuts the axis (m).
    pub centre: f64,
    /// The reflected displacement over the independent components: `u_reflected = matrix * u`, `n x n`.
    pub matrix: CsMat<f64>,
}

impl Reflection {
    /// The reflections that take each node to a node. Whether they change stiffness, mass and constraints is not known.
    pub(crate) fn of(mesh: &Mesh, dofs: &DofMap) -> Vec<Self> {
        let n_nodal = 3 * dofs.coordinates.len();
        // Motions of reference points are not those of nodes.
        if dofs.independent.iter().any(|&full| full >= n_nodal) {
            return Vec::new();
        }
        let Some(places) = Places::try_new(&dofs.coordinates) else {
            return Vec::new();
        };
        let cells = mesh.elements.iter().map(|element| element.cell.nodes());
        let mut sets = DisjointSets::of_groups(dofs.coordinates.len(), cells);
        let bodies: Vec<u32> = (0..dofs.coordinates.len() as u32).map(|node| sets.root(node)).collect();
        let found = (0..3).filter_map(|axis| {
            let images = places.images(&bodies, axis)?;
            let matrix = from_unsorted_rows((dofs.independent.len(), dofs.independent.len()), |row| {
                let (node, component) = (dofs.independent[row] / 3, dofs.independent[row] % 3);
                let sign = if component == axis { -1.0 } else { 1.0 };
                let image = dofs.row(3 * images[node] + component);
                image.map(move |(column, value)| (column, sign * value))
            });
            Some(Self {
                axis,
                centre: places.centre(axis),
                matrix,
            })
        });
        found.collect()
    }
}

/// Nodes, found by where they are.
#[derive(Clone, Debug)]
pub struct Places<'a> {
    positions: &'a [[f64; 3]],
    /// Lowest and highest value of each component.
    extents: [[f64; 2]; 3],
    cell: f64,
    tolerance: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
}

impl<'a> Places<'a> {
    /// None where all nodes are at the same place.
    pub fn try_new(positions: &'a [[f64; 3]]) -> Option<Self> {
        let extents = [0, 1, 2].map(|c| {
            let none = [f64::INFINITY, f64::NEG_INFINITY];
            positions
                .iter()
                .fold(none, |[low, high], x| [low.min(x[c]), high.max(x[c])])
        });
        let size = extents.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
        // Also catches NaN.
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let mut places = Self {
            positions,
            extents,
            // About one node in each.
            cell: size / (positions.len() as f64).cbrt(),
            tolerance: SAME_PLACE * size,
            cells: HashMap::new(),
        };
        for (node, &x) in positions.iter().enumerate() {
            places.cells.entry(places.key(x)).or_default().push(node);
        }
        Some(places)
    }

    /// The middle along an axis (m).
    ///
    /// # Panics
    /// If the axis is not 0, 1 or 2.
    pub fn centre(&self, axis: usize) -> f64 {
        0.5 * (self.extents[axis][0] + self.extents[axis][1])
    }

    /// The image of each node in the plane through the middle across an axis, if each has one alone. Where `bodies` touch, whose numbers there are for each
    /// node, it is that in the image of its body.
    ///
    /// # Panics
    /// If the axis is not 0, 1 or 2, or a node has no body.
    pub fn images(&self, bodies: &[u32], axis: usize) -> Option<Vec<usize>> {
        let centre = self.centre(axis);
        let mut body_images = BTreeMap::new();
        let mut candidates = Vec::with_capacity(bodies.len());
        for (node, &position) in self.positions.iter().enumerate() {
            let mut image = position;
            image[axis] = 2.0 * centre - image[axis];
            let found: Vec<usize> = self.near(image).collect();
            match found[..] {
                [] => return None,
                [only] if *body_images.entry(bodies[node]).or_insert(bodies[only]) != bodies[only] => return None,
                _ => candidates.push(found),
            }
        }
        let image = |(node, found): (usize, Vec<usize>)| {
            let body = body_images.get(&bodies[node])?;
            let mut inside = found.into_iter().filter(|&other| bodies[other] == *body);
            let first = inside.next()?;
            inside.next().is_none().then_some(first)
        };
        candidates.into_iter().enumerate().map(image).collect()
    }

    fn key(&self, x: [f64; 3]) -> [i64; 3] {
        [0, 1, 2].map(|c| ((x[c] - self.extents[c][0]) / self.cell).floor() as i64)
    }

    /// The nodes at `x`.
    fn near(&self, x: [f64; 3]) -> impl Iterator<Item = usize> {
        let [low, high] = [-self.tolerance, self.tolerance].map(|d| self.key(x.map(|v| v + d)));
        let plane = move |a| (low[1]..=high[1]).flat_map(move |b| (low[2]..=high[2]).map(move |c| [a, b, c]));
        let keys = (low[0]..=high[0]).flat_map(plane);
        let all = keys.filter_map(|key| self.cells.get(&key)).flatten().copied();
        all.filter(move |&j| (0..3).all(|c| (self.positions[j][c] - x[c]).abs() <= self.tolerance))
    }
}
