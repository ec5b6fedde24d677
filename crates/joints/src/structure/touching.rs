//! Which faces of two bodies touch.

use finite_elements::mesh::Face;
use finite_elements::sets::DisjointSets;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// How far faces may be apart that touch by default, relative to the longest edge of the smaller one.
const REACH: f64 = 0.05;

/// Largest cosine between the outward normals of faces that look at one another.
const OPPOSED: f64 = -0.7;

/// How far sample points of a face are from its centre, relative to its corners.
const INSIDE: f64 = 0.98;

/// The nodes of faces, ascending.
pub(super) fn nodes(faces: &[Face]) -> Vec<u32> {
    let nodes: BTreeSet<u32> = faces.iter().flat_map(|face| face.nodes().to_vec()).collect();
    nodes.into_iter().collect()
}

/// Patches of faces of two bodies that lie upon one another `within` a distance along their normals (m), in the order of the first
/// body's faces. Faces of a patch are connected by common nodes, on either body, or by touching.
pub(super) fn patches(coordinates: &[[f64; 3]], bodies: &[Vec<Face>; 2], within: Option<f64>) -> Vec<[Vec<Face>; 2]> {
    let seen = bodies.each_ref().map(|faces| {
        faces
            .iter()
            .map(|face| FaceGeometry::new(face, coordinates))
            .collect::<Vec<_>>()
    });
    let [first, second] = &seen;
    // With cells as large as the longest face none has a part in many of them.
    let size = first
        .iter()
        .chain(second)
        .map(|face| face.longest)
        .fold(0.0, f64::max)
        .max(within.unwrap_or(0.0));
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let cell_of = |x: f64| (x / size).floor() as i64;
    let range = |face: &FaceGeometry, margin: f64| {
        let low = face.low.map(|x| cell_of(x - margin));
        let high = face.high.map(|x| cell_of(x + margin));
        let along = move |axis: usize| low[axis]..=high[axis];
        along(0).flat_map(move |i| along(1).flat_map(move |j| along(2).map(move |k| [i, j, k])))
    };
    for (index, face) in second.iter().enumerate() {
        range(face, 0.0).for_each(|cell| cells.entry(cell).or_default().push(index));
    }
    let mut touches: Vec<[usize; 2]> = Vec::new();
    for (a, face) in first.iter().enumerate() {
        let margin = within.unwrap_or(REACH * face.longest);
        let near: BTreeSet<usize> = range(face, margin)
            .filter_map(|cell| cells.get(&cell))
            .flatten()
            .copied()
            .collect();
        let touched = near.into_iter().filter(|&b| face.touches(&second[b], within));
        touches.extend(touched.map(|b| [a, b]));
    }
    // Faces that touch and share nodes form sets; those of the second body are counted after those of the first.
    let n = first.len();
    let touching: BTreeSet<usize> = touches.iter().flat_map(|&[a, b]| [a, n + b]).collect();
    let mut sets = DisjointSets::new(n + second.len());
    touches.iter().for_each(|&[a, b]| sets.join(a as u32, (n + b) as u32));
    let face = |index: usize| match index.checked_sub(n) {
        None => &bodies[0][index],
        Some(index) => &bodies[1][index],
    };
    let mut of_node: HashMap<u32, usize> = HashMap::new();
    for &index in &touching {
        for &node in face(index).corners() {
            let other = *of_node.entry(node).or_insert(index);
            sets.join(index as u32, other as u32);
        }
    }
    let mut patches: BTreeMap<u32, [Vec<Face>; 2]> = BTreeMap::new();
    for &index in &touching {
        let patch = patches.entry(sets.root(index as u32)).or_default();
        patch[usize::from(index >= n)].push(*face(index));
    }
    patches.into_values().collect()
}

/// A face with what decides whether it touches another.
struct FaceGeometry {
    corners: Vec<Vector3<f64>>,
    centre: Vector3<f64>,
    normal: Vector3<f64>,
    longest: f64,
    low: [f64; 3],
    high: [f64; 3],
}

impl FaceGeometry {
    fn new(face: &Face, coordinates: &[[f64; 3]]) -> Self {
        let corners: Vec<Vector3<f64>> = face
            .corners()
            .iter()
            .map(|&node| coordinates[node as usize].into())
            .collect();
        let n = corners.len();
        let centre = corners.iter().sum::<Vector3<f64>>() / n as f64;
        let ends = |i: usize| (corners[i], corners[(i + 1) % n]);
        let area = (0..n).map(|i| (ends(i).0 - centre).cross(&(ends(i).1 - centre)));
        let extreme =
            |of: fn(f64, f64) -> f64, start: f64| [0, 1, 2].map(|axis| corners.iter().map(|x| x[axis]).fold(start, of));
        Self {
            normal: area.sum::<Vector3<f64>>().try_normalize(0.0).unwrap_or_default(),
            longest: (0..n).map(|i| (ends(i).1 - ends(i).0).norm()).fold(0.0, f64::max),
            low: extreme(f64::min, f64::INFINITY),
            high: extreme(f64::max, f64::NEG_INFINITY),
            centre,
            corners,
        }
    }

    fn touches(&self, other: &Self, within: Option<f64>) -> bool {
        let reach = within.unwrap_or(REACH * self.longest.min(other.longest));
        self.normal.dot(&other.normal) < OPPOSED && (self.covers(other, reach) || other.covers(self, reach))
    }

    /// Whether a sample point of the other face lies upon this one.
    fn covers(&self, other: &Self, reach: f64) -> bool {
        let n = other.corners.len();
        let corners = other.corners.iter().map(|x| other.centre + (x - other.centre) * INSIDE);
        let middles = (0..n).map(|i| {
            let middle = (other.corners[i] + other.corners[(i + 1) % n]) * 0.5;
            other.centre + (middle - other.centre) * INSIDE
        });
        corners.chain(middles).chain([other.centre]).any(|point| {
            let height = (point - self.centre).dot(&self.normal);
            let inside = (0..self.corners.len()).all(|i| {
                let (a, b) = (self.corners[i], self.corners[(i + 1) % self.corners.len()]);
                (b - a).cross(&(point - a)).dot(&self.normal) >= 0.0
            });
            inside && height.abs() <= reach
        })
    }
}
