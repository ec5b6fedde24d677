//! Two surfaces of a mesh that lie upon one another, as an interface.

use crate::Error;
use crate::joint::MovedPairs;
use crate::joint::benchmark::ElementOrder;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};
use substructure::mesh::Face;
use zte_assembly::{Element, InterfaceMesh};

/// How far nodes that face one another may be apart, relative to the shortest edge of the interface.
const COINCIDENCE: f64 = 1e-3;

/// Least cosine between the normal of a face and the mean normal.
const FLATNESS: f64 = 0.99;

/// Two surfaces that lie upon one another, node by node.
#[derive(Debug)]
pub(crate) struct Facing {
    pub(crate) interface: InterfaceMesh,
    pub(crate) top_nodes: Vec<u32>,
    pub(crate) bottom_nodes: Vec<u32>,
    pub(crate) frame: [[f64; 3]; 3],
    /// Pairs whose nodes were moved.
    pub(crate) moved: Option<MovedPairs>,
}

impl Facing {
    /// Pairs the nodes of two surfaces; the first axis of the frame is `along` as far as it lies in the plane. Nodes that do
    /// not coincide, but are within `tolerance` of one another in the plane (m), are moved to their midpoint there. `order` is
    /// the one that the faces have or will have. `label` names a node in messages.
    ///
    /// # Errors
    /// [`Error::Facing`] naming the node or face.
    pub(crate) fn try_new(
        coordinates: &mut [[f64; 3]],
        top: &[Face],
        bottom: &[Face],
        along: [f64; 3],
        tolerance: Option<f64>,
        order: ElementOrder,
        label: &dyn Fn(u32) -> String,
    ) -> Result<Self, Error> {
        let fail = |reason: String| Err(Error::Facing { reason });
        let at = |node: u32| Vector3::from(coordinates[node as usize]);
        let mut normal = Vector3::zeros();
        let mut shortest = f64::INFINITY;
        for face in top {
            let nodes = face.nodes();
            let Some(element) = Element::from_nodes(nodes) else {
                return fail(format!(
                    "the face at node {} has {} nodes; interfaces take triangles with three or six and quadrilaterals with four, \
                     eight or nine",
                    label(nodes[0]),
                    nodes.len()
                ));
            };
            normal += area_vector(face, coordinates);
            let outline = element.outline();
            for (i, &node) in outline.iter().enumerate() {
                shortest = shortest.min((at(outline[(i + 1) % outline.len()]) - at(node)).norm());
            }
        }
        let Some(normal) = normal.try_normalize(0.0) else {
            return fail("the top surface has no faces, or they enclose something".into());
        };
        if let Some(face) = top.iter().find(|face| {
            let area = area_vector(face, coordinates);
            area.dot(&normal) < FLATNESS * area.norm()
        }) {
            return fail(format!(
                "the face of the top surface at node {} is not in one plane with the others",
                label(face.nodes()[0])
            ));
        }
        if let Some(face) = top.iter().find(|face| leaves_the_plane(face, &normal, coordinates)) {
            return fail(format!(
                "the face of the top surface at node {} is curved out of the plane of the others; interfaces are flat",
                label(face.nodes()[0])
            ));
        }
        let along = Vector3::from(along);
        let Some(first) = (along - normal * along.dot(&normal)).try_normalize(1e-6 * along.norm()) else {
            return fail("the direction along the interface is perpendicular to it".into());
        };
        let second = normal.cross(&first);

        let unique = |faces: &[Face]| {
            let mut nodes: Vec<u32> = faces.iter().flat_map(|f| f.nodes().to_vec()).collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        };
        let (top_nodes, of_bottom) = (unique(top), unique(bottom));
        if of_bottom.len() != top_nodes.len() {
            return fail(format!(
                "the surfaces have {} and {} nodes; both must have the same mesh",
                top_nodes.len(),
                of_bottom.len()
            ));
        }
        let pairs = Pairs {
            coordinates,
            first,
            normal,
            reach: COINCIDENCE * shortest,
            tolerance,
        };
        let bottom_nodes = pairs.partners(&top_nodes, of_bottom, label)?;
        refuse_other_faces([top, bottom], [&top_nodes, &bottom_nodes], order, label)?;
        let moves = pairs.moves(&top_nodes, &bottom_nodes);
        let moved = moves.iter().map(|(_, way)| 2.0 * way.norm()).reduce(f64::max);
        let moved = moved.map(|largest_distance| MovedPairs {
            count: moves.len() / 2,
            largest_distance,
        });
        for (node, way) in moves {
            let place = &mut coordinates[node as usize];
            *place = (Vector3::from(*place) + way).into();
        }
        let at = |node: u32| Vector3::from(coordinates[node as usize]);
        let number: BTreeMap<u32, u32> = top_nodes.iter().zip(0..).map(|(&node, i)| (node, i)).collect();
        let elements = top
            .iter()
            .filter_map(|face| {
                let nodes: Vec<u32> = face.nodes().iter().map(|node| number[node]).collect();
                // Shapes that no interface element has were refused above.
                Element::from_nodes(&nodes)
            })
            .collect();
        Ok(Self {
            interface: InterfaceMesh {
                nodes: top_nodes
                    .iter()
                    .map(|&n| [at(n).dot(&first), at(n).dot(&second)])
                    .collect(),
                elements,
            },
            top_nodes,
            bottom_nodes,
            frame: [first.into(), second.into(), normal.into()],
            moved,
        })
    }
}

/// Which nodes of two surfaces face one another.
struct Pairs<'a> {
    coordinates: &'a [[f64; 3]],
    /// A direction in the plane, along which nodes are sorted.
    first: Vector3<f64>,
    normal: Vector3<f64>,
    /// Distance up to which nodes coincide (m).
    reach: f64,
    /// Distance in the plane up to which nodes that do not coincide are a pair (m).
    tolerance: Option<f64>,
}

impl Pairs<'_> {
    fn position(&self, node: u32) -> f64 {
        Vector3::from(self.coordinates[node as usize]).dot(&self.first)
    }

    /// From one node to another: the part in the plane, and how far along the normal.
    fn way(&self, from: u32, to: u32) -> (Vector3<f64>, f64) {
        let way = Vector3::from(self.coordinates[to as usize]) - Vector3::from(self.coordinates[from as usize]);
        let along = way.dot(&self.normal);
        (way - self.normal * along, along)
    }

    fn coincide(&self, a: u32, b: u32) -> bool {
        let (in_plane, along) = self.way(a, b);
        in_plane.norm().hypot(along) <= self.reach
    }

    fn may_pair(&self, a: u32, b: u32) -> bool {
        let (in_plane, along) = self.way(a, b);
        let within = self.tolerance.is_some_and(|tolerance| in_plane.norm() <= tolerance);
        self.coincide(a, b) || (within && along.abs() <= self.reach)
    }

    /// Of nodes in ascending order of [`Self::position`], the nearest that may pair with a node.
    fn nearest(&self, node: u32, sorted: &[u32]) -> Option<u32> {
        let reach = self.tolerance.unwrap_or(0.0).max(self.reach);
        let at = self.position(node);
        let start = sorted.partition_point(|&other| self.position(other) < at - reach);
        let near = sorted[start..]
            .iter()
            .copied()
            .take_while(|&other| self.position(other) <= at + reach);
        let distance = |other: &u32| self.way(node, *other).0.norm();
        near.filter(|&other| self.may_pair(node, other))
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// The node of the bottom for each of the top. The two of a pair are nearest to one another.
    fn partners(&self, top: &[u32], mut bottom: Vec<u32>, label: &dyn Fn(u32) -> String) -> Result<Vec<u32>, Error> {
        let fail = |reason: String| Err(Error::Facing { reason });
        let by_position = |a: &u32, b: &u32| self.position(*a).total_cmp(&self.position(*b));
        let mut sorted = top.to_vec();
        sorted.sort_by(by_position);
        bottom.sort_by(by_position);
        let mut partners = Vec::with_capacity(top.len());
        for &node in top {
            let Some(partner) = self.nearest(node, &bottom) else {
                let ways = bottom.iter().map(|&other| self.way(node, other));
                let [in_plane, along] = ways
                    .map(|(in_plane, along)| [in_plane.norm(), along.abs()])
                    .min_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])))
                    .unwrap_or([f64::INFINITY; 2]);
                return fail(format!(
                    "node {} of the top surface has no node of the bottom surface within {:.3e} m (the nearest is {in_plane:.3e} m \
                     away in the plane and {along:.3e} m along the normal); both must have the same mesh there, or pairs be \
                     allowed by structure.deck.pair_tolerance and lie within {:.3e} m along the normal",
                    label(node),
                    self.tolerance.unwrap_or(self.reach),
                    self.reach
                ));
            };
            match self.nearest(partner, &sorted) {
                Some(nearest) if nearest != node => {
                    return fail(format!(
                        "node {} of the bottom surface is the nearest one to node {} of the top surface, but nearer to node {}; \
                         correct the mesh, or give a smaller structure.deck.pair_tolerance",
                        label(partner),
                        label(node),
                        label(nearest)
                    ));
                }
                _ => partners.push(partner),
            }
        }
        Ok(partners)
    }

    /// The nodes of pairs that do not coincide, top and bottom in turn, with the way to their midpoint in the plane (m).
    fn moves(&self, top: &[u32], bottom: &[u32]) -> Vec<(u32, Vector3<f64>)> {
        let apart = top.iter().zip(bottom).filter(|&(&a, &b)| !self.coincide(a, b));
        apart
            .flat_map(|(&a, &b)| {
                let half = 0.5 * self.way(a, b).0;
                [(a, half), (b, -half)]
            })
            .collect()
    }
}

/// Whether a middle lies so far out of the plane that the way to a corner turns as much as [`FLATNESS`] allows faces to.
fn leaves_the_plane(face: &Face, normal: &Vector3<f64>, coordinates: &[[f64; 3]]) -> bool {
    let at = |node: u32| Vector3::from(coordinates[node as usize]);
    let (corners, middles) = face.nodes().split_at(face.corners().len());
    let sine = (1.0 - FLATNESS * FLATNESS).sqrt();
    middles.iter().any(|&middle| {
        corners.iter().any(|&corner| {
            let way = at(middle) - at(corner);
            way.dot(normal).abs() > sine * way.norm()
        })
    })
}

/// Refuses quadratic faces whose partners on the other side are not faces of the same nodes: the jump between them would not be
/// that of either. Linear faces that stay linear may differ, such as in the diagonals of their triangles.
fn refuse_other_faces(
    [top, bottom]: [&[Face]; 2],
    [top_nodes, bottom_nodes]: [&[u32]; 2],
    order: ElementOrder,
    label: &dyn Fn(u32) -> String,
) -> Result<(), Error> {
    let is_quadratic = |face: &&Face| order == ElementOrder::Quadratic || face.nodes().len() > face.corners().len();
    let partner: BTreeMap<u32, u32> = bottom_nodes.iter().zip(top_nodes).map(|(&b, &t)| (b, t)).collect();
    let corners_and_others = |face: &Face, of: &dyn Fn(u32) -> u32| {
        let (corners, others) = face.nodes().split_at(face.corners().len());
        [corners, others].map(|nodes| nodes.iter().map(|&node| of(node)).collect::<BTreeSet<u32>>())
    };
    let quadratic_top = top
        .iter()
        .filter(is_quadratic)
        .map(|face| (corners_and_others(face, &|n| n), face));
    let quadratic_bottom = bottom.iter().filter(is_quadratic);
    let quadratic_bottom = quadratic_bottom.map(|face| (corners_and_others(face, &|n| partner[&n]), face));
    let (of_top, of_bottom): (BTreeMap<_, _>, BTreeMap<_, _>) = (quadratic_top.collect(), quadratic_bottom.collect());
    let alone = |of: &BTreeMap<[BTreeSet<u32>; 2], &Face>, others: &BTreeMap<[BTreeSet<u32>; 2], &Face>| {
        let alone = of.iter().find(|(nodes, _)| !others.contains_key(*nodes));
        alone.map(|(_, face)| face.nodes()[0])
    };
    let found = alone(&of_top, &of_bottom).map(|node| ("top", "bottom", node));
    match found.or_else(|| alone(&of_bottom, &of_top).map(|node| ("bottom", "top", node))) {
        None => Ok(()),
        Some((side, other, node)) => Err(Error::Facing {
            reason: format!(
                "the quadratic face of the {side} surface at node {} has no face of the {other} surface with the same corners and \
                 middles; both must have the same mesh, also where model.element_order makes faces quadratic",
                label(node)
            ),
        }),
    }
}

/// Area times outward normal.
fn area_vector(face: &Face, coordinates: &[[f64; 3]]) -> Vector3<f64> {
    let at = |node: u32| Vector3::from(coordinates[node as usize]);
    let corners: Vec<Vector3<f64>> = face.corners().iter().map(|&node| at(node)).collect();
    match corners[..] {
        [a, b, c, d] => (c - a).cross(&(d - b)) * 0.5,
        [a, b, c, ..] => (b - a).cross(&(c - a)) * 0.5,
        _ => Vector3::zeros(),
    }
}
