//! The search for interface elements that cover the same area.

use crate::clip::{Cut, Polygon, area};
use crate::element::Element;
use crate::tree::{Bounded, Tree};

/// Part of the smaller element's area that two elements may share: coordinates of files are rounded, and where meshes
/// have hanging nodes neighbours then overlap by slivers.
pub(crate) const TOLERANCE: f64 = 1e-4;

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
pub(crate) fn find(nodes: &[[f64; 2]], elements: &[Element]) -> Option<Overlap> {
    let polygons = elements.iter().enumerate().filter_map(|(number, element)| {
        let corners = element.corners().iter().map(|&node| nodes[node as usize]);
        Polygon::try_new(number, corners)
    });
    let tree = Tree::new(polygons.collect());
    let mut found: Option<Overlap> = None;
    let mut cut = Cut::default();
    for polygon in tree.items() {
        tree.visit(polygon.bounds(), &mut |other: &Polygon| {
            let pair = (polygon.element, other.element);
            let known = found.as_ref().is_some_and(|known| (known.element, known.first) <= pair);
            if pair.1 >= pair.0 || known {
                return;
            }
            let shared = area(polygon.shared(other, &mut cut));
            if shared > TOLERANCE * polygon.area.min(other.area) {
                let (element, first) = pair;
                found = Some(Overlap { element, first, shared });
            }
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::InterfaceMesh;

    /// `nx x ny` squares of unit edge, turned by an angle about the origin, without common nodes.
    fn loose_squares(nx: usize, ny: usize, angle: f64) -> InterfaceMesh {
        let (sine, cosine) = angle.sin_cos();
        let mut mesh = InterfaceMesh::flat(Vec::new(), Vec::new());
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
            assert_eq!(find(&mesh.nodes, &mesh.elements), None, "{nx} x {ny}");
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
        let overlap = find(&mesh.nodes, &mesh.elements).unwrap();
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
                let mesh = InterfaceMesh::flat(
                    [square(0.0, size), square(start, small)].concat(),
                    vec![Element::quad4([0, 1, 2, 3]), Element::quad4([4, 5, 6, 7])],
                );
                let found = find(&mesh.nodes, &mesh.elements);
                assert_eq!(found.is_some(), refused, "{size} {depth}: {found:?}");
            }
        }
    }
}
