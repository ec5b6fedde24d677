//! Two surfaces of a mesh that lie upon one another, as an interface.
//!
//! Where both have the same nodes, these are paired. Otherwise the finer side carries the jump, and what faces its nodes follows from the
//! intersection of both meshes ([`zte_assembly::mortar`]).

use super::touching;
use crate::Error;
use finite_elements::mesh::Face;
use finite_elements::sparse::submatrix;
use joint_model::benchmark::ElementOrder;
use joint_model::fit::FacesFit;
use joint_model::{MovedPairs, ProjectedSide, Sides};
use nalgebra::Vector3;
use sprs::CsMat;
use std::collections::{BTreeMap, BTreeSet};
use zte_assembly::{Covered, Element, InterfaceMesh, Mortar, Operators, Rise};

/// How far nodes that face one another may be apart, relative to the shortest edge of the interface.
const COINCIDENCE: f64 = 1e-3;

/// Sine of the angle, and height relative to the extent, up to which an interface counts as flat: coordinates of files are rounded.
const FLATNESS: f64 = 1e-3;

/// Largest angle (degrees) between the normal of a face and the mean normal: the plane onto which faces are projected must see them.
const LARGEST_ANGLE: f64 = 45.0;

/// Largest angle (degrees) between the normals at the nodes of one element. Components of the jump along axes that turn are
/// interpolated, which at this angle is an error of 1 % in its size.
const LARGEST_TURN: f64 = 15.0;

/// How far faces of different meshes may be apart along the normal by default, relative to the mean edge.
const REACH: f64 = 0.05;

/// Two surfaces that lie upon one another.
#[derive(Debug)]
pub(crate) struct Facing {
    pub interface: InterfaceMesh,
    pub sides: Sides,
    /// Mean axes: x and y in the plane, and the normal from the top body into the bottom one.
    pub frame: [[f64; 3]; 3],
    /// Axes at each node where the interface is curved; empty where it is flat.
    pub node_frames: Vec<[[f64; 3]; 3]>,
    /// Pairs whose nodes were moved.
    pub moved: Option<MovedPairs>,
    /// What was found where the meshes do not match.
    pub projected: Option<Projected>,
    /// Largest angle between the normal at a node and the mean normal (degrees); zero where the interface is flat.
    pub angle: f64,
    /// How the faces lay upon one another before nodes were moved.
    pub fit: FacesFit,
}

/// What was found where the meshes of two faces do not match.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projected {
    /// Whether the top side carries the jump.
    pub own_is_top: bool,
    /// Largest move of a node onto the other side (m).
    pub largest_move: f64,
    /// Elements of which the other side faces a part only.
    pub partly: usize,
    /// Elements left out because too little of them is faced.
    pub left_out: usize,
    /// Largest error of the nodal forces of a uniform traction on the other side, relative to their mean; none where the two sides do
    /// not cover the same area.
    pub patch_error: Option<f64>,
}

/// Two surfaces as they are found in a file, and how they shall be joined.
pub(crate) struct Surfaces<'a> {
    pub top: &'a [Face],
    pub bottom: &'a [Face],
    /// First axis of the frame, as far as it lies in the plane.
    pub along: [f64; 3],
    /// Nodes that do not coincide, but are within this distance of one another in the plane (m), are paired and moved to their midpoint there.
    pub pair_tolerance: Option<f64>,
    /// How far faces of different meshes may be apart along the normal (m).
    pub within: Option<f64>,
    /// The order that the faces have or will have.
    pub order: ElementOrder,
    /// Name of a node in messages.
    pub label: &'a dyn Fn(u32) -> String,
}

impl Facing {
    /// Joins two surfaces; nodes are moved in `coordinates`.
    ///
    /// # Errors
    /// [`Error::Facing`] naming the node or face; those of the projection.
    pub(crate) fn try_new(coordinates: &mut [[f64; 3]], surfaces: &Surfaces<'_>) -> Result<Self, Error> {
        let fail = |reason: String| Err(Error::Facing { reason });
        let label = surfaces.label;
        let at = |node: u32| Vector3::from(coordinates[node as usize]);
        let mut normal = Vector3::zeros();
        let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
        for (face, sign) in both(surfaces) {
            let nodes = face.nodes();
            let Some(element) = Element::from_nodes(nodes) else {
                return fail(format!(
                    "the face at node {} has {} nodes; interfaces take triangles with three or six and quadrilaterals with four, \
                     eight or nine",
                    label(nodes[0]),
                    nodes.len()
                ));
            };
            if sign > 0.0 {
                normal += area_vector(face, coordinates);
            }
            let outline = element.outline();
            for (i, &node) in outline.iter().enumerate() {
                let edge = (at(outline[(i + 1) % outline.len()]) - at(node)).norm();
                longest = longest.max(edge);
                if sign > 0.0 {
                    shortest = shortest.min(edge);
                }
            }
        }
        let Some(normal) = normal.try_normalize(0.0) else {
            return fail("the top surface has no faces, or they enclose something".into());
        };
        for (face, sign) in both(surfaces) {
            let area = sign * area_vector(face, coordinates);
            let angle = degrees(&area, &normal);
            // `!(a <= b)` also catches NaN.
            if !(angle <= LARGEST_ANGLE) {
                return fail(format!(
                    "the face of the {} surface at node {} is inclined by {angle:.1} degrees to the mean normal of the top surface; interfaces \
                     may be curved by {LARGEST_ANGLE} degrees: divide them, or name the faces that touch alone",
                    if sign > 0.0 { "top" } else { "bottom" },
                    label(face.nodes()[0])
                ));
            }
        }
        let along = Vector3::from(surfaces.along);
        let Some(first) = (along - normal * along.dot(&normal)).try_normalize(1e-6 * along.norm()) else {
            return fail(format!(
                "its first direction `along` {:?} is perpendicular to it; give one that lies in it",
                surfaces.along
            ));
        };
        let second = normal.cross(&first);
        let frame = [first, second, normal];
        let (top_nodes, of_bottom) = (touching::nodes(surfaces.top), touching::nodes(surfaces.bottom));
        let pairs = Pairs {
            coordinates,
            first,
            normal,
            reach: COINCIDENCE * shortest,
            tolerance: surfaces.pair_tolerance,
        };
        let same_number = of_bottom.len() == top_nodes.len();
        let paired = match (same_number, surfaces.pair_tolerance) {
            // Pairs that shall be moved must be found.
            (true, Some(_)) => Some(pairs.partners(&top_nodes, of_bottom, label)?),
            (true, None) => pairs.partners(&top_nodes, of_bottom, label).ok(),
            (false, Some(_)) => {
                return fail(format!(
                    "the surfaces have {} and {} nodes, which cannot be paired; leave structure.deck.pair_tolerance out to join \
                     meshes that do not match",
                    top_nodes.len(),
                    of_bottom.len()
                ));
            }
            (false, None) => None,
        };
        let matching = paired.filter(|bottom_nodes| {
            let sides = [top_nodes.as_slice(), bottom_nodes.as_slice()];
            quadratic_faces_match([surfaces.top, surfaces.bottom], sides, surfaces.order)
        });
        match matching {
            Some(bottom_nodes) => {
                let moves = pairs.moves(&top_nodes, &bottom_nodes);
                let mut apart = Rise::default();
                for (&top, &bottom) in top_nodes.iter().zip(&bottom_nodes) {
                    apart.add(1.0, pairs.way(top, bottom).1);
                }
                let moved = moves.iter().map(|(_, way)| 2.0 * way.norm()).reduce(f64::max);
                let moved = moved.map(|largest_distance| MovedPairs {
                    count: moves.len() / 2,
                    largest_distance,
                });
                for (node, way) in moves {
                    let place = &mut coordinates[node as usize];
                    *place = (Vector3::from(*place) + way).into();
                }
                let elements = plane_elements(surfaces.top, &top_nodes, false);
                let plane = Plane::new(coordinates, &top_nodes, frame);
                let (interface, node_frames, angle) = plane.curved(elements, surfaces.top, 1.0, label)?;
                let sides = Sides::Pairs {
                    top: top_nodes,
                    bottom: bottom_nodes,
                };
                Ok(Self {
                    interface,
                    sides,
                    frame: frame.map(Into::into),
                    node_frames,
                    moved,
                    projected: None,
                    angle,
                    fit: fit(apart, [0.0; 2], angle),
                })
            }
            None => project(
                coordinates,
                surfaces,
                frame,
                [top_nodes, touching::nodes(surfaces.bottom)],
                longest,
            ),
        }
    }
}

impl Facing {
    /// What a user should know of it, one sentence each.
    pub(crate) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(moved) = self.moved {
            notes.push(format!(
                "{} pairs of interface nodes do not coincide, by {:.2e} m at most, and were moved to their midpoints",
                moved.count, moved.largest_distance
            ));
        }
        if let Some(found) = self.projected {
            let side = if found.own_is_top { "top" } else { "bottom" };
            let patch = match found.patch_error {
                Some(error) => format!("; a uniform traction arrives on the other side with an error of {error:.1e}"),
                None => String::new(),
            };
            notes.push(format!(
                "the meshes of the two faces do not match: the jump is carried by the {} nodes of the {side} side, which were moved by \
                 {:.2e} m at most onto the other side{patch}",
                self.interface.nodes.len(),
                found.largest_move
            ));
            if found.partly + found.left_out > 0 {
                notes.push(format!(
                    "{} elements of the interface are faced in part, and {} too little to be kept",
                    found.partly, found.left_out
                ));
            }
        }
        if self.angle > 0.0 {
            notes.push(format!(
                "the interface is curved: its normal turns by up to {:.2} degrees from the mean one",
                self.angle
            ));
        }
        notes
    }
}

/// Faces that are `apart` along the normal from the top body into the bottom one.
fn fit(apart: Rise, without_partner: [f64; 2], angle: f64) -> FacesFit {
    FacesFit {
        curved: angle > 0.0,
        without_partner,
        distance: apart.mean,
        distance_size: apart.mean_size,
        distance_range: apart.range,
        ..FacesFit::default()
    }
}

/// All faces, with 1 for those of the top surface and -1 for those of the bottom one.
fn both<'a>(surfaces: &Surfaces<'a>) -> impl Iterator<Item = (&'a Face, f64)> {
    let top = surfaces.top.iter().map(|face| (face, 1.0));
    top.chain(surfaces.bottom.iter().map(|face| (face, -1.0)))
}

/// Angle between two directions (degrees).
fn degrees(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b)).to_degrees()
}

/// Faces as elements over the positions of their nodes in `nodes`, in the opposite sense on request.
fn plane_elements(faces: &[Face], nodes: &[u32], reversed: bool) -> Vec<Element> {
    let number: BTreeMap<u32, u32> = nodes.iter().zip(0..).map(|(&node, i)| (node, i)).collect();
    let of_face = |face: &Face| {
        let mut list: Vec<u32> = face.nodes().iter().map(|node| number[node]).collect();
        if reversed {
            let n = face.corners().len();
            list[1..n].reverse();
            // The middle between the first two corners is the former last one.
            let middles = n..(2 * n).min(list.len());
            list[middles].reverse();
        }
        Element::from_nodes(&list)
    };
    // Shapes that no interface element has were refused before.
    faces.iter().filter_map(of_face).collect()
}

/// Axes x, y, n as rows.
type Axes = [[f64; 3]; 3];

/// An interface mesh, axes at its nodes if it is not flat, and the largest angle between a normal and the mean one (degrees).
type Curved = (InterfaceMesh, Vec<Axes>, f64);

/// Nodes seen in the plane of an interface.
struct Plane<'a> {
    nodes: &'a [u32],
    places: Vec<Vector3<f64>>,
    frame: [Vector3<f64>; 3],
}

impl<'a> Plane<'a> {
    fn new(coordinates: &[[f64; 3]], nodes: &'a [u32], frame: [Vector3<f64>; 3]) -> Self {
        Self {
            nodes,
            places: nodes.iter().map(|&node| coordinates[node as usize].into()).collect(),
            frame,
        }
    }

    fn along(&self, axis: usize) -> impl Iterator<Item = f64> {
        self.places.iter().map(move |x| x.dot(&self.frame[axis]))
    }

    /// Heights above the mean.
    fn heights(&self, mean: f64) -> Vec<f64> {
        self.along(2).map(|height| height - mean).collect()
    }

    fn mean_height(&self) -> f64 {
        self.along(2).sum::<f64>() / self.places.len() as f64
    }

    fn mesh(&self, elements: Vec<Element>, heights: Vec<f64>) -> InterfaceMesh {
        let nodes = self.along(0).zip(self.along(1)).map(|(x, y)| [x, y]).collect();
        InterfaceMesh {
            heights,
            ..InterfaceMesh::flat(nodes, elements)
        }
    }

    /// The mesh with heights and axes at the nodes if it is not flat, and the largest angle to the mean normal (degrees). `outward` is
    /// 1 where the normals of the `faces` point along that of the frame, -1 where against it.
    fn curved(
        &self,
        elements: Vec<Element>,
        faces: &[Face],
        outward: f64,
        label: &dyn Fn(u32) -> String,
    ) -> Result<Curved, Error> {
        let heights = self.heights(self.mean_height());
        let extent = |axis: usize| {
            let (low, high) = self
                .along(axis)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            high - low
        };
        let highest = heights.iter().fold(0.0_f64, |m, h| m.max(h.abs()));
        let normals = self.normals(faces, outward);
        let [first, _, mean] = self.frame;
        let angle = normals.iter().map(|normal| degrees(normal, &mean)).fold(0.0, f64::max);
        if angle.to_radians() <= FLATNESS && highest <= FLATNESS * extent(0).hypot(extent(1)) {
            return Ok((self.mesh(elements, Vec::new()), Vec::new(), 0.0));
        }
        for element in &elements {
            let of_element: Vec<Vector3<f64>> = element.nodes().iter().map(|&node| normals[node as usize]).collect();
            let turns = of_element
                .iter()
                .flat_map(|a| of_element.iter().map(move |b| degrees(a, b)));
            let turn = turns.fold(0.0, f64::max);
            // `!(a <= b)` also catches NaN.
            if !(turn <= LARGEST_TURN) {
                let node = self.nodes[element.nodes()[0] as usize];
                return Err(Error::Facing {
                    reason: format!(
                        "the normal turns by {turn:.1} degrees within the face at node {}; up to {LARGEST_TURN} degrees are resolved: give the \
                         interface a finer mesh there",
                        label(node)
                    ),
                });
            }
        }
        let frames = normals.iter().map(|normal| {
            let x = (first - normal * first.dot(normal)).normalize();
            [x, normal.cross(&x), *normal].map(Into::into)
        });
        let frames = frames.collect();
        Ok((self.mesh(elements, heights), frames, angle))
    }

    /// Unit normals at the nodes: the sum of those of the faces there, by their areas.
    fn normals(&self, faces: &[Face], outward: f64) -> Vec<Vector3<f64>> {
        let mut normals = vec![Vector3::zeros(); self.nodes.len()];
        for element in plane_elements(faces, self.nodes, false) {
            let nodes = element.nodes();
            for (local, xi) in reference_nodes(&element).into_iter().enumerate() {
                let (_, derivatives) = element.shape().functions(xi);
                let tangent = |axis: usize| {
                    let terms = nodes.iter().zip(&derivatives);
                    terms.fold(Vector3::zeros(), |sum, (&node, d)| {
                        sum + self.places[node as usize] * d[axis]
                    })
                };
                normals[nodes[local] as usize] += tangent(0).cross(&tangent(1)) * outward;
            }
        }
        let unit = |normal: Vector3<f64>| normal.try_normalize(0.0).unwrap_or(self.frame[2]);
        normals.into_iter().map(unit).collect()
    }
}

/// Natural coordinates of the nodes of an element.
fn reference_nodes(element: &Element) -> Vec<[f64; 2]> {
    let corners: &[[f64; 2]] = match element.corners().len() {
        3 => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        _ => &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
    };
    let n = corners.len();
    let middle = |i: usize| [0, 1].map(|c| 0.5 * (corners[i][c] + corners[(i + 1) % n][c]));
    let all = corners.iter().copied().chain((0..n).map(middle)).chain([[0.0; 2]]);
    all.take(element.nodes().len()).collect()
}

/// Joins faces whose meshes do not match: nodes of the finer side carry the jump, and are moved onto the other side.
fn project(
    coordinates: &mut [[f64; 3]],
    surfaces: &Surfaces<'_>,
    frame: [Vector3<f64>; 3],
    [top_nodes, bottom_nodes]: [Vec<u32>; 2],
    longest: f64,
) -> Result<Facing, Error> {
    let mean_area = |faces: &[Face]| {
        let total: f64 = faces.iter().map(|face| area_vector(face, coordinates).norm()).sum();
        total / faces.len() as f64
    };
    // What decides must not depend on which body is called the top one.
    let centre = |nodes: &[u32]| {
        let sum = nodes.iter().fold(Vector3::zeros(), |sum, &node| {
            sum + Vector3::from(coordinates[node as usize])
        });
        sum / nodes.len() as f64
    };
    let (of_top, of_bottom) = (mean_area(surfaces.top), mean_area(surfaces.bottom));
    let own_is_top = match (of_top / of_bottom - 1.0).abs() > 1e-6 {
        true => of_top < of_bottom,
        false => {
            let (a, b) = (centre(&top_nodes), centre(&bottom_nodes));
            a.iter().partial_cmp(b.iter()) != Some(std::cmp::Ordering::Greater)
        }
    };
    let (own_faces, other_faces, own, other) = match own_is_top {
        true => (surfaces.top, surfaces.bottom, top_nodes, bottom_nodes),
        false => (surfaces.bottom, surfaces.top, bottom_nodes, top_nodes),
    };
    let outward = if own_is_top { 1.0 } else { -1.0 };
    let (own_plane, other_plane) = (
        Plane::new(coordinates, &own, frame),
        Plane::new(coordinates, &other, frame),
    );
    let mean = own_plane.mean_height();
    let own_mesh = own_plane.mesh(plane_elements(own_faces, &own, !own_is_top), own_plane.heights(mean));
    let other_mesh = other_plane.mesh(
        plane_elements(other_faces, &other, own_is_top),
        other_plane.heights(mean),
    );
    let reach = surfaces.within.unwrap_or(REACH * longest);
    let mortar = Mortar::try_new(&own_mesh, &other_mesh, reach)?;
    let mut without_partner = mortar.areas.map(|area| (1.0 - mortar.rise.area / area).max(0.0));
    let mut apart = mortar.rise;
    if !own_is_top {
        without_partner.reverse();
        apart = apart.reversed();
    }
    // Nodes of elements that are faced, with new numbers.
    let elements = mortar.elements.iter().map(|&index| own_mesh.elements[index]);
    let used: BTreeSet<u32> = elements.clone().flat_map(|element| element.nodes().to_vec()).collect();
    let used: Vec<u32> = used.into_iter().collect();
    let number: BTreeMap<u32, u32> = used.iter().zip(0..).map(|(&node, i)| (node, i)).collect();
    let renumber = |element: Element| element.try_map_nodes(|node| number.get(&node).copied().ok_or(()));
    let elements: Vec<Element> = elements.filter_map(|element| renumber(element).ok()).collect();
    let kept_faces: Vec<Face> = mortar.elements.iter().map(|&index| own_faces[index]).collect();
    let rows: Vec<usize> = used.iter().map(|&node| node as usize).collect();
    let all: Vec<Option<usize>> = (0..other.len()).map(Some).collect();
    let projection = submatrix(&mortar.projection, &rows, &all, other.len());
    let own: Vec<u32> = used.iter().map(|&node| own[node as usize]).collect();
    let mut largest_move = 0.0_f64;
    for (row, &node) in projection.outer_iterator().zip(&own) {
        let mut onto = Vector3::zeros();
        for (column, &weight) in row.iter() {
            onto += Vector3::from(coordinates[other[column] as usize]) * weight;
        }
        largest_move = largest_move.max((onto - Vector3::from(coordinates[node as usize])).norm());
        coordinates[node as usize] = onto.into();
    }
    let own_plane = Plane::new(coordinates, &own, frame);
    let (mut interface, node_frames, angle) = own_plane.curved(elements, &kept_faces, outward, surfaces.label)?;
    let place_of: BTreeMap<usize, usize> = mortar.elements.iter().zip(0..).map(|(&e, i)| (e, i)).collect();
    interface.covered = mortar
        .covered
        .iter()
        .map(|part| Covered {
            element: place_of[&part.element],
            ..*part
        })
        .collect();
    let patch_error = patch_error(&interface, &projection, &other_mesh);
    let projected = Projected {
        own_is_top,
        largest_move,
        partly: mortar.covered.len(),
        left_out: mortar.dropped.iter().filter(|(_, share)| *share > 0.0).count(),
        patch_error: patch_error?,
    };
    Ok(Facing {
        interface,
        sides: Sides::Projected(vec![ProjectedSide {
            own,
            own_is_top,
            own_faces: kept_faces,
            other,
            other_faces: other_faces.to_vec(),
            projection,
        }]),
        frame: frame.map(Into::into),
        node_frames,
        moved: None,
        projected: Some(projected),
        angle,
        fit: fit(apart, without_partner, angle),
    })
}

/// The patch test: a uniform traction on the interface, brought to the other side, against that side's own consistent forces, relative to
/// their mean. None where the two sides do not cover the same area.
fn patch_error(
    interface: &InterfaceMesh,
    projection: &CsMat<f64>,
    other: &InterfaceMesh,
) -> Result<Option<f64>, Error> {
    let of_own = Operators::try_new(interface, 4)?;
    let of_other = Operators::try_new(other, 4)?;
    if (of_own.area() / of_other.area() - 1.0).abs() > 1e-9 {
        return Ok(None);
    }
    let sums = |operators: &Operators| -> Vec<f64> {
        let rows = operators.integration.outer_iterator();
        rows.map(|row| row.data().iter().sum()).collect()
    };
    let mut arrived = vec![0.0; other.nodes.len()];
    for (row, force) in projection.outer_iterator().zip(sums(&of_own)) {
        row.iter()
            .for_each(|(column, weight)| arrived[column] += weight * force);
    }
    let mean = of_own.area() / arrived.len() as f64;
    let errors = arrived.iter().zip(sums(&of_other)).map(|(a, b)| (a - b).abs() / mean);
    Ok(Some(errors.fold(0.0, f64::max)))
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

/// Whether all quadratic faces face one with the same corners and middles: otherwise the jump between them would not be that of either.
/// Linear faces that stay linear may differ, such as in the diagonals of their triangles.
fn quadratic_faces_match(
    [top, bottom]: [&[Face]; 2],
    [top_nodes, bottom_nodes]: [&[u32]; 2],
    order: ElementOrder,
) -> bool {
    let is_quadratic = |face: &&Face| order == ElementOrder::Quadratic || face.nodes().len() > face.corners().len();
    let partner: BTreeMap<u32, u32> = bottom_nodes.iter().zip(top_nodes).map(|(&b, &t)| (b, t)).collect();
    let corners_and_others = |face: &Face, of: &dyn Fn(u32) -> u32| {
        let (corners, others) = face.nodes().split_at(face.corners().len());
        [corners, others].map(|nodes| nodes.iter().map(|&node| of(node)).collect::<BTreeSet<u32>>())
    };
    let of_top = top
        .iter()
        .filter(is_quadratic)
        .map(|face| corners_and_others(face, &|n| n));
    let of_bottom = bottom
        .iter()
        .filter(is_quadratic)
        .map(|face| corners_and_others(face, &|n| partner[&n]));
    of_top.collect::<BTreeSet<_>>() == of_bottom.collect::<BTreeSet<_>>()
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
