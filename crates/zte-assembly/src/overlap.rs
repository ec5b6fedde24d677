//! The search for interface elements that cover the same area.

use crate::mesh::InterfaceMesh;

/// Part of the smaller element's area that two elements may share: coordinates of files are rounded, and where meshes
/// have hanging nodes neighbours then overlap by slivers.
pub(crate) const TOLERANCE: f64 = 1e-4;

/// Most elements of a leaf of the tree.
const LEAF: usize = 8;

/// Two elements that share area.
#[derive(Debug, PartialEq)]
pub(crate) struct Overlap {
    /// The later element.
    pub(crate) element: usize,
    /// The earlier one.
    pub(crate) first: usize,
    /// Area that both cover (m^2).
    pub(crate) shared: f64,
}

/// The first element that shares more than [`TOLERANCE`] of its area, or of the other's, with an earlier one.
///
/// Edges count as the lines between their corners: elements that share a curved edge share that line too.
///
/// Elements that are not convex or not counter-clockwise are left out: they are refused where their area density is
/// known. A tree of bounding boxes makes this `n log n` also for meshes that are graded or lie along one line.
pub(crate) fn find(mesh: &InterfaceMesh) -> Option<Overlap> {
    let mut polygons: Vec<Polygon> = mesh
        .elements
        .iter()
        .enumerate()
        .filter_map(|(element, nodes)| {
            let corners = nodes.corners().iter().map(|&node| mesh.nodes[node as usize]);
            Polygon::try_new(element, corners)
        })
        .collect();
    let n = polygons.len();
    let mut tree = Tree {
        boxes: vec![Bounds::EMPTY; (2 * n.next_power_of_two()).max(2)],
    };
    tree.build(1, &mut polygons);
    let mut found: Option<Overlap> = None;
    for polygon in &polygons {
        tree.visit(1, &polygons, polygon, &mut found);
    }
    found
}

#[derive(Clone, Copy)]
struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

impl Bounds {
    const EMPTY: Self = Self {
        low: [f64::INFINITY; 2],
        high: [f64::NEG_INFINITY; 2],
    };

    fn include(&mut self, other: &Self) {
        for axis in 0..2 {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
    }

    /// Boxes that only touch share nothing.
    fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.low[axis] < other.high[axis] && other.low[axis] < self.high[axis])
    }
}

/// A convex element.
struct Polygon {
    element: usize,
    corners: Vec<[f64; 2]>,
    area: f64,
    bounds: Bounds,
}

impl Polygon {
    fn try_new(element: usize, corners: impl Iterator<Item = [f64; 2]>) -> Option<Self> {
        let corners: Vec<[f64; 2]> = corners.collect();
        let n = corners.len();
        let convex = (0..n).all(|i| side(corners[i], corners[(i + 1) % n], corners[(i + 2) % n]) > 0.0);
        let mut bounds = Bounds::EMPTY;
        for &corner in &corners {
            bounds.include(&Bounds {
                low: corner,
                high: corner,
            });
        }
        convex.then(|| Self {
            element,
            area: area(&corners),
            corners,
            bounds,
        })
    }

    /// Area that both cover: this polygon cut along the edges of the other.
    fn shared(&self, other: &Self, cut: &mut [Vec<[f64; 2]>; 2]) -> f64 {
        let [rest, next] = cut;
        rest.clone_from(&self.corners);
        let n = other.corners.len();
        for i in 0..n {
            let (from, to) = (other.corners[i], other.corners[(i + 1) % n]);
            next.clear();
            for (j, &a) in rest.iter().enumerate() {
                let b = rest[(j + 1) % rest.len()];
                let (inside_a, inside_b) = (side(from, to, a), side(from, to, b));
                if inside_a >= 0.0 {
                    next.push(a);
                }
                if (inside_a > 0.0 && inside_b < 0.0) || (inside_a < 0.0 && inside_b > 0.0) {
                    let part = inside_a / (inside_a - inside_b);
                    next.push([0, 1].map(|axis| a[axis] + part * (b[axis] - a[axis])));
                }
            }
            std::mem::swap(rest, next);
        }
        area(rest)
    }
}

/// Positive where `x` is to the left of the line.
fn side(from: [f64; 2], to: [f64; 2], x: [f64; 2]) -> f64 {
    (to[0] - from[0]) * (x[1] - from[1]) - (to[1] - from[1]) * (x[0] - from[0])
}

/// About the first corner, so that the distance from the origin costs no digits.
fn area(corners: &[[f64; 2]]) -> f64 {
    let fan = corners.windows(2).skip(1);
    0.5 * fan.map(|edge| side(corners[0], edge[0], edge[1])).sum::<f64>()
}

/// Bounding boxes of halves, quarters, ... of the elements: the halves of box `i` are `2 i` and `2 i + 1`.
struct Tree {
    boxes: Vec<Bounds>,
}

impl Tree {
    /// Sorts the polygons so that each box holds neighbours.
    fn build(&mut self, index: usize, polygons: &mut [Polygon]) {
        let mut all = Bounds::EMPTY;
        polygons.iter().for_each(|polygon| all.include(&polygon.bounds));
        self.boxes[index] = all;
        if polygons.len() <= LEAF {
            return;
        }
        let axis = usize::from(all.high[1] - all.low[1] > all.high[0] - all.low[0]);
        let middle = polygons.len() / 2;
        let centre = |polygon: &Polygon| polygon.bounds.low[axis] + polygon.bounds.high[axis];
        polygons.select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)));
        let (low, high) = polygons.split_at_mut(middle);
        self.build(2 * index, low);
        self.build(2 * index + 1, high);
    }

    /// Compares one polygon with those of a box that come before it in the mesh; keeps the first pair of the mesh.
    fn visit(&self, index: usize, polygons: &[Polygon], polygon: &Polygon, found: &mut Option<Overlap>) {
        if !self.boxes[index].overlaps(&polygon.bounds) {
            return;
        }
        if polygons.len() > LEAF {
            let (low, high) = polygons.split_at(polygons.len() / 2);
            self.visit(2 * index, low, polygon, found);
            self.visit(2 * index + 1, high, polygon, found);
            return;
        }
        let mut cut = [Vec::new(), Vec::new()];
        for other in polygons {
            let pair = (polygon.element, other.element);
            let known = found.as_ref().is_some_and(|known| (known.element, known.first) <= pair);
            if pair.1 >= pair.0 || known || !other.bounds.overlaps(&polygon.bounds) {
                continue;
            }
            let shared = polygon.shared(other, &mut cut);
            if shared > TOLERANCE * polygon.area.min(other.area) {
                let (element, first) = pair;
                *found = Some(Overlap { element, first, shared });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Element;

    /// `nx x ny` squares of unit edge, turned by an angle about the origin, without common nodes.
    fn loose_squares(nx: usize, ny: usize, angle: f64) -> InterfaceMesh {
        let (sine, cosine) = angle.sin_cos();
        let mut mesh = InterfaceMesh {
            nodes: Vec::new(),
            elements: Vec::new(),
        };
        for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
            let first = mesh.nodes.len() as u32;
            for [a, b] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
                let (x, y) = ((i + a) as f64, (j + b) as f64);
                mesh.nodes.push([cosine * x - sine * y, sine * x + cosine * y]);
            }
            mesh.elements.push(Element::quad4([0, 1, 2, 3].map(|k| first + k)));
        }
        mesh
    }

    #[test]
    fn a_hundred_thousand_elements_cost_no_more_than_their_neighbours() {
        for (nx, ny, angle) in [(316, 317, 0.0), (100_000, 1, 0.3), (1, 100_000, 0.0), (316, 317, 0.7)] {
            let mesh = loose_squares(nx, ny, angle);
            let begin = std::time::Instant::now();
            assert_eq!(find(&mesh), None, "{nx} x {ny}");
            // Tens of milliseconds; all pairs would be 5e9.
            assert!(begin.elapsed().as_secs() < 5, "{nx} x {ny}: {:?}", begin.elapsed());
        }
    }

    #[test]
    fn elements_of_all_sizes_are_compared() {
        // One element below all others, far larger, and last.
        let mut mesh = loose_squares(300, 300, 0.1);
        mesh.nodes.extend([[-1e4, -1e4], [1e4, -1e4], [0.0, 1e4]]);
        let first = mesh.nodes.len() as u32 - 3;
        mesh.elements.push(Element::tri3([first, first + 1, first + 2]));
        let overlap = find(&mesh).unwrap();
        assert_eq!((overlap.element, overlap.first), (90_000, 0));
        assert!((overlap.shared - 1.0).abs() < 1e-9, "{overlap:?}");
    }

    #[test]
    fn the_tolerance_is_a_part_of_the_smaller_area() {
        for size in [1e-9, 1.0, 1e6] {
            for (depth, refused) in [(0.0, false), (0.9e-4, false), (1.1e-4, true), (0.5, true), (1.0, true)] {
                // A square, and one ten times smaller that reaches into it by a part of its own size.
                let small = 0.1 * size;
                let start = size - depth * small;
                let square = |x: f64, size: f64| [[x, 0.0], [x + size, 0.0], [x + size, size], [x, size]];
                let mesh = InterfaceMesh {
                    nodes: [square(0.0, size), square(start, small)].concat(),
                    elements: vec![Element::quad4([0, 1, 2, 3]), Element::quad4([4, 5, 6, 7])],
                };
                let found = find(&mesh);
                assert_eq!(found.is_some(), refused, "{size} {depth}: {found:?}");
            }
        }
    }
}
