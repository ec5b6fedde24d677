//! Which grid point belongs to which interface element.

use crate::error::SurfaceError;
use crate::topography::HeightMap;

/// Label of a point that lies in no element.
pub(crate) const OUTSIDE: u32 = u32::MAX;

/// Distance from an outer edge, relative to the element's extent, within which a point still counts as on it.
///
/// Grids and meshes often share their outline; this only absorbs the rounding of `origin + i dx`.
const EDGE_TOLERANCE: f64 = 1e-9;

/// The outlines of the interface elements: simple polygons of three to eight corners, convex or not. A curved edge stands here
/// as the two lines over its middle.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementOutlines {
    nodes: Vec<[f64; 2]>,
    elements: Vec<Vec<u32>>,
    areas: Vec<f64>,
}

impl ElementOutlines {
    /// Builds the outlines from `nodes` (m) and the node numbers around each element, in either sense.
    ///
    /// # Errors
    /// No elements, coordinates that are not finite, node numbers out of range or repeated, other than 3 to 8 nodes,
    /// no area, or edges that cross.
    pub fn try_new(nodes: Vec<[f64; 2]>, elements: Vec<Vec<u32>>) -> Result<Self, SurfaceError> {
        for (index, node) in nodes.iter().enumerate() {
            for &value in node {
                if !value.is_finite() {
                    return Err(SurfaceError::InvalidSample {
                        field: "nodes",
                        index,
                        value,
                        unit: "m",
                        requirement: "finite",
                    });
                }
            }
        }
        if elements.is_empty() || elements.len() >= OUTSIDE as usize {
            return Err(SurfaceError::LengthMismatch {
                field: "elements",
                found: elements.len(),
                expected: 1,
                remedy: "give at least one element and fewer than 2^32 - 1",
            });
        }
        let mut areas = Vec::with_capacity(elements.len());
        for (element, corners) in elements.iter().enumerate() {
            let invalid = |problem| SurfaceError::InvalidElement { element, problem };
            if !(3..=8).contains(&corners.len()) {
                return Err(invalid("it does not have 3 to 8 nodes"));
            }
            if corners.iter().any(|&n| n as usize >= nodes.len()) {
                return Err(invalid("it names a node that does not exist"));
            }
            if (1..corners.len()).any(|k| corners[..k].contains(&corners[k])) {
                return Err(invalid("it names a node twice"));
            }
            let p: Vec<[f64; 2]> = corners.iter().map(|&n| nodes[n as usize]).collect();
            let edge = |k: usize| [p[k], p[(k + 1) % p.len()]];
            if (0..p.len()).any(|k| (0..k).any(|other| cross_each_other(edge(k), edge(other)))) {
                return Err(invalid("its edges cross"));
            }
            let area = polygon_area(&p);
            let (low, high) = bounding_box(&p);
            if area.is_nan() || area <= 1e-12 * (high[0] - low[0]) * (high[1] - low[1]) {
                return Err(invalid("it has no area"));
            }
            areas.push(area);
        }
        Ok(Self { nodes, elements, areas })
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.elements.len()
    }

    /// Always false: at least one element is required at construction.
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// Area of an element (m^2). Panics when `element >= len()`.
    pub fn area(&self, element: usize) -> f64 {
        self.areas[element]
    }

    /// Corners of an element (m), in order. Panics when `element >= len()`.
    pub fn corners(&self, element: usize) -> impl ExactSizeIterator<Item = [f64; 2]> + '_ {
        self.elements[element].iter().map(|&n| self.nodes[n as usize])
    }

    /// Mean of an element's corners (m). Panics when `element >= len()`.
    pub fn middle(&self, element: usize) -> [f64; 2] {
        let n = self.corners(element).len() as f64;
        self.corners(element)
            .fold([0.0; 2], |m, p| [m[0] + p[0] / n, m[1] + p[1] / n])
    }

    /// Lower left and upper right corner of the rectangle around all elements (m).
    pub fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        (0..self.len()).map(|e| self.element_bounds(e)).fold(
            ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]),
            |(low, high), (l, h)| {
                (
                    [low[0].min(l[0]), low[1].min(l[1])],
                    [high[0].max(h[0]), high[1].max(h[1])],
                )
            },
        )
    }

    /// Lower left and upper right corner of the rectangle around one element (m).
    pub fn element_bounds(&self, element: usize) -> ([f64; 2], [f64; 2]) {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in self.corners(element) {
            for k in 0..2 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        (low, high)
    }

    /// Edges of an element, each with its lower end first so that both neighbours compute the same crossing.
    fn edges(&self, element: usize) -> Vec<[[f64; 2]; 2]> {
        let p: Vec<_> = self.corners(element).collect();
        (0..p.len())
            .map(|k| {
                let (a, b) = (p[k], p[(k + 1) % p.len()]);
                if (a[1], a[0]) <= (b[1], b[0]) { [a, b] } else { [b, a] }
            })
            .collect()
    }
}

/// The owner of every grid point of one map.
#[derive(Debug, Clone, PartialEq)]
pub struct Partition {
    labels: Vec<u32>,
    nx: usize,
    /// Points with data, per element.
    pub points: Vec<usize>,
    /// Points without data inside the outline, per element.
    pub missing: Vec<usize>,
    /// Points with data that lie in no element (bolt holes, beyond the outline): dropped.
    pub outside: usize,
}

impl Partition {
    /// Assigns each point of `map` to the one element that contains it.
    ///
    /// A point on an edge between two elements goes to exactly one of them (half-open rule: points on left and lower
    /// edges belong to the element); points on the outer outline are kept. Work is proportional to the number of
    /// points in the elements' bounding boxes.
    pub fn new(map: &HeightMap, elements: &ElementOutlines) -> Self {
        let (nx, ny) = (map.nx(), map.ny());
        let mut labels = vec![OUTSIDE; nx * ny];
        let mut claim = |inside: &dyn Fn([f64; 2]) -> bool, element: usize| {
            let (low, high) = elements.element_bounds(element);
            let slack = [0, 1].map(|k| EDGE_TOLERANCE * (high[k] - low[k]));
            let (i0, i1) = map.indices_within(0, low[0] - slack[0], high[0] + slack[0]);
            let (j0, j1) = map.indices_within(1, low[1] - slack[1], high[1] + slack[1]);
            for j in j0..j1 {
                for i in i0..i1 {
                    let label = &mut labels[j * nx + i];
                    if *label == OUTSIDE && inside(map.position(i, j)) {
                        *label = element as u32;
                    }
                }
            }
        };
        for element in 0..elements.len() {
            let edges = elements.edges(element);
            claim(&|p| is_inside(&edges, p), element);
        }
        for element in 0..elements.len() {
            let edges = elements.edges(element);
            let (low, high) = elements.element_bounds(element);
            let tolerance = EDGE_TOLERANCE * (high[0] - low[0]).hypot(high[1] - low[1]);
            claim(&|p| edges.iter().any(|e| distance(e, p) <= tolerance), element);
        }
        let mut partition = Self {
            labels,
            nx,
            points: vec![0; elements.len()],
            missing: vec![0; elements.len()],
            outside: 0,
        };
        for (index, &label) in partition.labels.iter().enumerate() {
            match (label, map.value(index).is_nan()) {
                (OUTSIDE, true) => {}
                (OUTSIDE, false) => partition.outside += 1,
                (e, true) => partition.missing[e as usize] += 1,
                (e, false) => partition.points[e as usize] += 1,
            }
        }
        partition
    }

    /// The element that owns point `(i, j)`, if any. Panics outside the grid.
    pub fn element(&self, i: usize, j: usize) -> Option<usize> {
        match self.labels[j * self.nx + i] {
            OUTSIDE => None,
            e => Some(e as usize),
        }
    }

    /// Whether `element` owns point `(i, j)`.
    #[inline]
    pub(crate) fn owns(&self, element: usize, i: usize, j: usize) -> bool {
        self.labels[j * self.nx + i] == element as u32
    }
}

/// Even-odd rule with half-open edges; each edge is given lower end first.
#[inline]
fn is_inside(edges: &[[[f64; 2]; 2]], p: [f64; 2]) -> bool {
    let mut inside = false;
    for [a, b] in edges {
        if a[1] <= p[1] && p[1] < b[1] && p[0] < a[0] + (p[1] - a[1]) * ((b[0] - a[0]) / (b[1] - a[1])) {
            inside = !inside;
        }
    }
    inside
}

/// Distance of `p` from a segment.
fn distance([a, b]: &[[f64; 2]; 2], p: [f64; 2]) -> f64 {
    let (e, r) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let s = ((e[0] * r[0] + e[1] * r[1]) / (e[0] * e[0] + e[1] * e[1])).clamp(0.0, 1.0);
    (r[0] - s * e[0]).hypot(r[1] - s * e[1])
}

fn polygon_area(p: &[[f64; 2]]) -> f64 {
    // Relative to the first corner: coordinates may be far from the origin.
    let r = |k: usize| [p[k][0] - p[0][0], p[k][1] - p[0][1]];
    let twice: f64 = (1..p.len() - 1)
        .map(|k| r(k)[0] * r(k + 1)[1] - r(k)[1] * r(k + 1)[0])
        .sum();
    0.5 * twice.abs()
}

fn bounding_box(p: &[[f64; 2]]) -> ([f64; 2], [f64; 2]) {
    let fold = |k: usize, f: fn(f64, f64) -> f64| p.iter().map(|q| q[k]).fold(p[0][k], f);
    (
        [fold(0, f64::min), fold(1, f64::min)],
        [fold(0, f64::max), fold(1, f64::max)],
    )
}

fn cross_each_other([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn map(nx: usize, ny: usize, step: [f64; 2], origin: [f64; 2]) -> HeightMap {
        HeightMap::try_new(nx, ny, step, origin, vec![0.0f32; nx * ny]).unwrap()
    }

    /// Independent reference: a point is in a polygon when the winding angle about it is a full turn.
    fn winding_inside(corners: &[[f64; 2]], p: [f64; 2]) -> bool {
        let turn: f64 = (0..corners.len())
            .map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
                let (u, v) = ([a[0] - p[0], a[1] - p[1]], [b[0] - p[0], b[1] - p[1]]);
                (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1])
            })
            .sum();
        turn.abs() > 3.0
    }

    #[test]
    fn convex_and_non_convex_elements_match_the_winding_number() {
        // A dart (non-convex), the triangle that fills its notch, and a skewed quadrilateral beside them.
        let nodes = vec![
            [0.013, 0.007],
            [1.021, 0.413],
            [0.037, 1.003],
            [0.311, 0.457],
            [2.017, 0.211],
            [1.913, 1.307],
        ];
        let outlines =
            ElementOutlines::try_new(nodes, vec![vec![0, 1, 2, 3], vec![2, 3, 0], vec![1, 4, 5, 2]]).unwrap();
        let map = map(211, 157, [0.01, 0.01], [-0.05, -0.05]);
        let partition = Partition::new(&map, &outlines);
        let mut counts = [0usize; 3];
        for j in 0..map.ny() {
            for i in 0..map.nx() {
                let p = map.position(i, j);
                let inside: Vec<usize> = (0..3)
                    .filter(|&e| winding_inside(&outlines.corners(e).collect::<Vec<_>>(), p))
                    .collect();
                assert!(inside.len() <= 1);
                assert_eq!(partition.element(i, j), inside.first().copied(), "{p:?}");
                if let Some(&e) = inside.first() {
                    counts[e] += 1;
                }
            }
        }
        assert_eq!(partition.points, counts);
        assert!(counts.iter().all(|&n| n > 500), "{counts:?}");
        assert_eq!(partition.outside, map.nx() * map.ny() - counts.iter().sum::<usize>());
    }

    #[test]
    fn shared_edges_and_outline_are_owned_exactly_once() {
        // Grid points fall exactly on every edge of this 4 x 3 mesh.
        let (cx, cy) = (4u32, 3u32);
        let nodes: Vec<[f64; 2]> = (0..=cy)
            .flat_map(|j| (0..=cx).map(move |i| [f64::from(i) * 0.3, f64::from(j) * 0.5]))
            .collect();
        let elements = (0..cy)
            .flat_map(|j| {
                (0..cx).map(move |i| {
                    let a = j * (cx + 1) + i;
                    vec![a, a + 1, a + cx + 2, a + cx + 1]
                })
            })
            .collect();
        let outlines = ElementOutlines::try_new(nodes, elements).unwrap();
        let map = map(41, 31, [0.03, 0.05], [0.0, 0.0]);
        let partition = Partition::new(&map, &outlines);
        assert_eq!(partition.outside, 0);
        assert_eq!(partition.points.iter().sum::<usize>(), 41 * 31);
        // Inner elements own their left and lower edge only.
        assert_eq!(partition.points[0], 100);
        assert_eq!(partition.element(0, 0), Some(0));
        assert_eq!(partition.element(40, 30), Some(11));
    }

    #[test]
    fn invalid_outlines_are_named() {
        let nodes = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.0]];
        let problem = |elements: Vec<Vec<u32>>| ElementOutlines::try_new(nodes.clone(), elements).unwrap_err();
        for elements in [
            vec![0, 1, 3, 2],
            vec![0, 1],
            vec![0, 1, 9],
            vec![0, 1, 1],
            vec![0, 1, 4],
        ] {
            assert!(matches!(
                problem(vec![vec![0, 1, 2], elements]),
                SurfaceError::InvalidElement { element: 1, .. }
            ));
        }
        // Eight corners are taken, in an order that crosses itself they are not.
        let around = [
            [0.0, 0.0],
            [0.5, -0.1],
            [1.0, 0.0],
            [1.1, 0.5],
            [1.0, 1.0],
            [0.5, 1.1],
            [0.0, 1.0],
            [-0.1, 0.5],
        ];
        let octagon = |order: Vec<u32>| ElementOutlines::try_new(around.to_vec(), vec![order]);
        assert!((octagon((0..8).collect()).unwrap().area(0) - 1.2).abs() < 1e-12);
        assert!(matches!(
            octagon(vec![0, 1, 2, 3, 6, 5, 4, 7]).unwrap_err(),
            SurfaceError::InvalidElement { element: 0, .. }
        ));
        assert!(matches!(problem(vec![]), SurfaceError::LengthMismatch { .. }));
        let bad = ElementOutlines::try_new(vec![[f64::NAN, 0.0]; 3], vec![vec![0, 1, 2]]);
        assert!(matches!(bad, Err(SurfaceError::InvalidSample { field: "nodes", .. })));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        /// Whatever the position of the inner node, four quads around it own every point of the square once.
        #[test]
        fn a_conforming_mesh_owns_every_point_once(x in 0.2f64..0.8, y in 0.2f64..0.8, n in 5usize..40) {
            let nodes = vec![
                [0.0, 0.0], [0.5, 0.0], [1.0, 0.0],
                [0.0, 0.5], [x, y], [1.0, 0.5],
                [0.0, 1.0], [0.5, 1.0], [1.0, 1.0],
            ];
            let quads = vec![vec![0, 1, 4, 3], vec![1, 2, 5, 4], vec![3, 4, 7, 6], vec![4, 5, 8, 7]];
            let outlines = ElementOutlines::try_new(nodes, quads).unwrap();
            prop_assert!(((0..4).map(|e| outlines.area(e)).sum::<f64>() - 1.0).abs() < 1e-12);
            let h = 1.0 / (n as f64 - 1.0);
            let map = map(n, n, [h, h], [0.0, 0.0]);
            let partition = Partition::new(&map, &outlines);
            prop_assert_eq!(partition.points.iter().sum::<usize>(), n * n);
            prop_assert_eq!(partition.outside, 0);
        }
    }
}
