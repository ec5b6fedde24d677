//! What a mesh holds that a scene can name: its bodies, where they touch, and holes that bolts may pass.

use super::touching;
use crate::Error;
use finite_elements::formats::solid_mesh::SolidMesh;
use finite_elements::mesh::{Cell, Face, Group};
use finite_elements::sets::DisjointSets;
use nalgebra::{Matrix2, Matrix3, SymmetricEigen, Vector2, Vector3};
use scenes::metric::Metric;
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;
use std::path::Path;

/// Largest angle between neighbouring faces of a smooth surface (degrees): a hole of eight faces has 45.
const SMOOTH: f64 = 46.0;

/// How far corners of a hole may be from its mean radius, relative to it.
const ROUND: f64 = 0.05;

/// Widest part of a hole's circumference without a corner (rad).
const WIDEST_GAP: f64 = 0.45 * PI;

/// How far from one axis and from one radius holes of one bolt may be, relative to the radius.
const COAXIAL: f64 = 0.1;
const SAME_RADIUS: f64 = 0.3;

/// Least length of the mean normal of faces that look one way.
const FLAT: f64 = 0.7;

/// Least width of a body around a hole in its middle, relative to the hole: a wider hole is a bore. Rules for distances to
/// edges ask for 2.4.
const LEAST_WIDTH: f64 = 2.2;

/// How far from the middle of a body a hole is in its middle, relative to the body's width.
const MIDDLE: f64 = 0.05;

/// Most bodies among which faces that touch are looked for.
const MOST_BODIES: usize = 1000;

/// What a mesh holds. Lengths are in the unit of the file.
#[derive(Debug)]
pub struct Survey {
    /// Number of its nodes.
    pub n_nodes: usize,
    /// Its bodies: solids that share nodes.
    pub bodies: Vec<Body>,
    /// Pairs of bodies that touch.
    pub touching: Vec<Touching>,
    /// Round holes through bodies.
    pub holes: Vec<Hole>,
    /// Holes in a row, of two bodies at least.
    pub bolts: Vec<ProposedBolt>,
    /// Names of groups of solids, of faces and of nodes, with the number of members.
    pub groups: [Vec<(String, usize)>; 3],
    /// What was skipped or is noteworthy.
    pub notes: Vec<String>,
}

/// Solids that share nodes.
#[derive(Debug)]
pub struct Body {
    /// What a scene calls it: a group of exactly its solids, or `body N`.
    pub name: String,
    /// Number of its solids by their type.
    pub elements: BTreeMap<&'static str, usize>,
    /// Corners of the box about it.
    pub low: [f64; 3],
    /// The other corner.
    pub high: [f64; 3],
}

/// Two bodies that touch.
#[derive(Debug)]
pub struct Touching {
    /// Their numbers from zero, that of the upper one first.
    pub bodies: [usize; 2],
    /// Numbers of faces of either.
    pub faces: [usize; 2],
    /// Number of patches that lie apart.
    pub patches: usize,
    /// Area of the first body's faces.
    pub area: f64,
    /// Mean normal from the first body into the second, of length 1 where the faces are plane.
    pub normal: [f64; 3],
    /// The faces of both.
    pub on: Vec<Face>,
}

/// A round hole.
#[derive(Debug)]
pub struct Hole {
    /// Number of its body, from zero.
    pub body: usize,
    /// Diameter through the corners of its faces.
    pub diameter: f64,
    /// Where it begins and ends on its axis.
    pub ends: [[f64; 3]; 2],
}

/// A bolt that holes in a row have room for.
#[derive(Debug)]
pub struct ProposedBolt {
    /// Numbers of its holes.
    pub holes: Vec<usize>,
    /// Ends of the row on the axis; the first is the one further along the positive axis that is nearest.
    pub axis: [[f64; 3]; 2],
    /// Diameter of the narrowest hole.
    pub diameter: f64,
    /// Number of the body that fills the holes, if there is one: a bolt that is in the mesh.
    pub filled_by: Option<usize>,
}

impl Touching {
    /// Whether the faces look one way, more or less; those of a thread or a pin do not.
    pub fn is_flat(&self) -> bool {
        Vector3::from(self.normal).norm() >= FLAT
    }
}

impl ProposedBolt {
    /// The metric size for such a hole, with a unit of length of the file in metres; none if there is no such size.
    pub fn size(&self, unit: f64) -> Option<String> {
        Metric::for_hole(self.diameter * unit)
    }
}

/// A name for a body without a group of its own, by its number from zero.
pub(super) fn body_name(number: usize) -> String {
    format!("body {}", number + 1)
}

impl Survey {
    /// That of a mesh file or of the mesh of an input deck.
    ///
    /// # Errors
    /// Those of the file.
    pub fn of_file(path: &Path) -> Result<Self, Error> {
        Ok(Self::of(&read(path)?))
    }

    /// That of a mesh as [`read`] gives it.
    pub(super) fn of(mesh: &SolidMesh) -> Self {
        let largest = largest(mesh);
        let of_cell = mesh.bodies();
        let bodies = bodies(mesh, &of_cell);
        let mut notes = mesh.notes.clone();
        let mut sides: Vec<Vec<Face>> = vec![Vec::new(); bodies.len()];
        for (face, cell) in mesh.boundary() {
            sides[of_cell[cell as usize] as usize].push(face);
        }
        let touching = match bodies.len() {
            0..=MOST_BODIES => touching_bodies(mesh, &bodies, &sides),
            count => {
                notes.push(format!(
                    "faces that touch are looked for among {MOST_BODIES} bodies at most, and there are {count}"
                ));
                Vec::new()
            }
        };
        let mut holes: Vec<Hole> = sides
            .iter()
            .enumerate()
            .flat_map(|(body, faces)| holes(&mesh.nodes, body, faces))
            .collect();
        let ends = holes.iter_mut().flat_map(|hole| &mut hole.ends);
        ends.flatten().for_each(|x| *x = rounded(*x, largest));
        let mut bolts = bolts(&holes, largest);
        bolts.retain(|bolt| bolt.holes.iter().any(|&hole| has_room(&bodies[holes[hole].body], bolt)));
        for bolt in &mut bolts {
            bolt.filled_by = filled_by(mesh, &of_cell, bolt.axis.map(Vector3::from));
        }
        let groups = [sizes(&mesh.volumes), sizes(&mesh.surfaces), sizes(&mesh.points)];
        Self {
            n_nodes: mesh.nodes.len(),
            bodies,
            touching,
            holes,
            bolts,
            groups,
            notes,
        }
    }
}

/// The largest coordinate of a mesh.
fn largest(mesh: &SolidMesh) -> f64 {
    mesh.nodes.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// A mesh, without the round-off of the program that made it, which would be shown as digits.
pub(super) fn read(path: &Path) -> Result<SolidMesh, Error> {
    let mut mesh = SolidMesh::read(path)?;
    let largest = largest(&mesh);
    mesh.nodes.iter_mut().flatten().for_each(|x| *x = rounded(*x, largest));
    Ok(mesh)
}

/// A position to a billionth of the largest one.
fn rounded(x: f64, largest: f64) -> f64 {
    let step = 1e-9 * largest;
    if step > 0.0 { (x / step).round() * step + 0.0 } else { x }
}

/// Names of groups with their numbers of members.
fn sizes<T>(groups: &[Group<T>]) -> Vec<(String, usize)> {
    let sizes = groups.iter().map(|group| (group.name.clone(), group.members.len()));
    sizes.collect()
}

fn bodies(mesh: &SolidMesh, of_cell: &[u32]) -> Vec<Body> {
    let count = of_cell.iter().max().map_or(0, |last| *last as usize + 1);
    let mut bodies: Vec<Body> = (0..count)
        .map(|number| Body {
            name: body_name(number),
            elements: BTreeMap::new(),
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
        })
        .collect();
    for (cell, body) in mesh.cells.iter().zip(of_cell) {
        let body = &mut bodies[*body as usize];
        *body.elements.entry(cell.element_type().name).or_default() += 1;
        for node in cell.nodes() {
            for (axis, x) in mesh.nodes[*node as usize].iter().enumerate() {
                body.low[axis] = body.low[axis].min(*x);
                body.high[axis] = body.high[axis].max(*x);
            }
        }
    }
    // A group that holds all of a body and nothing else is its name, the first one in the file.
    for group in mesh.volumes.iter().rev() {
        let Some(number) = group.members.first().map(|cell| of_cell[*cell as usize]) else {
            continue;
        };
        let body = &mut bodies[number as usize];
        let is_all = group.members.len() == body.elements.values().sum::<usize>()
            && group.members.iter().all(|cell| of_cell[*cell as usize] == number);
        // The name must be the group's alone.
        if is_all && mesh.volume(&group.name).is_ok_and(|cells| cells == group.members) {
            body.name.clone_from(&group.name);
        }
    }
    bodies
}

fn touching_bodies(mesh: &SolidMesh, bodies: &[Body], sides: &[Vec<Face>]) -> Vec<Touching> {
    let mut found = Vec::new();
    let longest: Vec<f64> = sides.iter().map(|faces| longest_edge(&mesh.nodes, faces)).collect();
    for a in 0..bodies.len() {
        for b in a + 1..bodies.len() {
            let reach = longest[a].max(longest[b]);
            let apart = (0..3).any(|axis| {
                bodies[a].low[axis] > bodies[b].high[axis] + reach || bodies[b].low[axis] > bodies[a].high[axis] + reach
            });
            if apart {
                continue;
            }
            let pair = [sides[a].clone(), sides[b].clone()];
            let patches = touching::patches(&mesh.nodes, &pair, None);
            if patches.is_empty() {
                continue;
            }
            let faces = [0, 1].map(|side| patches.iter().map(|patch| patch[side].len()).sum());
            let areas = patches
                .iter()
                .flat_map(|patch| &patch[0])
                .map(|face| vector_area(&mesh.nodes, face));
            let (sum, area) = areas.fold((Vector3::zeros(), 0.0), |(sum, area), part: Vector3<f64>| {
                (sum + part, area + part.norm())
            });
            let mut touching = Touching {
                bodies: [a, b],
                faces,
                patches: patches.len(),
                area,
                normal: (sum / f64::max(area, f64::MIN_POSITIVE))
                    .map(|x| rounded(x, 1.0))
                    .into(),
                on: patches.into_iter().flatten().flatten().collect(),
            };
            // The upper body looks down along the axis that the normal is nearest to.
            if touching.normal[sum.iamax()] > 0.0 {
                touching.bodies.reverse();
                touching.faces.reverse();
                touching.normal = touching.normal.map(|x| -x);
            }
            found.push(touching);
        }
    }
    found
}

fn longest_edge(nodes: &[[f64; 3]], faces: &[Face]) -> f64 {
    let at = |node: u32| Vector3::from(nodes[node as usize]);
    let edges = faces.iter().flat_map(|face| {
        let corners = face.corners();
        (0..corners.len()).map(move |i| (at(corners[i]) - at(corners[(i + 1) % corners.len()])).norm())
    });
    edges.fold(0.0, f64::max)
}

/// Area times the normal of a face through its corners.
fn vector_area(nodes: &[[f64; 3]], face: &Face) -> Vector3<f64> {
    let corners = face.corners();
    let at = |i: usize| Vector3::from(nodes[corners[i % corners.len()] as usize]);
    let fan = (1..corners.len() - 1).map(|i| (at(i) - at(0)).cross(&(at(i + 1) - at(0))));
    fan.sum::<Vector3<f64>>() * 0.5
}

/// Smooth surfaces: faces of bodies, by their numbers, that go over into one another without a sharp edge.
pub(super) fn smooth(nodes: &[[f64; 3]], faces: &[Face]) -> Vec<Vec<usize>> {
    let areas: Vec<Vector3<f64>> = faces.iter().map(|face| vector_area(nodes, face)).collect();
    let mut sets = DisjointSets::new(faces.len());
    let mut at_edge: HashMap<[u32; 2], usize> = HashMap::new();
    let limit = SMOOTH.to_radians().cos();
    for (number, face) in faces.iter().enumerate() {
        let corners = face.corners();
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let Some(other) = at_edge.insert([a.min(b), a.max(b)], number) else {
                continue;
            };
            let [n, m] = [areas[number], areas[other]];
            if n.dot(&m) >= limit * n.norm() * m.norm() {
                sets.join(number as u32, other as u32);
            }
        }
    }
    let mut patches: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for number in 0..faces.len() {
        patches.entry(sets.root(number as u32)).or_default().push(number);
    }
    patches.into_values().collect()
}

/// The round holes of a body.
fn holes(nodes: &[[f64; 3]], body: usize, faces: &[Face]) -> Vec<Hole> {
    let found = smooth(nodes, faces).into_iter().filter_map(|patch| {
        let of_patch: Vec<(&Face, Vector3<f64>)> = patch
            .iter()
            .map(|&face| (&faces[face], vector_area(nodes, &faces[face])))
            .collect();
        hole(nodes, body, &of_patch)
    });
    found.collect()
}

/// A smooth surface as a hole, if it is round, closed around its axis, and looks at it.
fn hole(nodes: &[[f64; 3]], body: usize, faces: &[(&Face, Vector3<f64>)]) -> Option<Hole> {
    if faces.len() < 5 {
        return None;
    }
    let total: f64 = faces.iter().map(|(_, area)| area.norm()).sum();
    let unit = |area: &Vector3<f64>| area.try_normalize(0.0).unwrap_or_default();
    let spread: Matrix3<f64> = faces
        .iter()
        .map(|(_, area)| unit(area) * area.transpose() / total)
        .sum();
    // Normals of a cylinder have no part along its axis.
    let eigen = SymmetricEigen::new(spread);
    let along = eigen.eigenvalues.imin();
    if eigen.eigenvalues[along] > 0.01 {
        return None;
    }
    let axis: Vector3<f64> = eigen.eigenvectors.column(along).into();
    let first: Vector3<f64> = eigen.eigenvectors.column((along + 1) % 3).into();
    let plane = [first, axis.cross(&first)];
    let flat = |x: &Vector3<f64>| Vector2::new(x.dot(&plane[0]), x.dot(&plane[1]));
    let at = |node: &u32| Vector3::from(nodes[*node as usize]);
    let centre_of = |face: &Face| {
        let corners = face.corners();
        corners.iter().map(at).sum::<Vector3<f64>>() / corners.len() as f64
    };
    // The point that the lines along the normals pass nearest to.
    let (mut matrix, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for (face, area) in faces {
        let normal = flat(&unit(area));
        let across = (Matrix2::identity() - normal * normal.transpose()) * area.norm();
        matrix += across;
        right += across * flat(&centre_of(face));
    }
    let centre = matrix.try_inverse()? * right;
    let mut inwards = 0.0;
    for (face, area) in faces {
        inwards += flat(area).dot(&(centre - flat(&centre_of(face))));
    }
    if !(inwards > 0.0) {
        return None;
    }
    let corners: Vec<Vector3<f64>> = faces.iter().flat_map(|(face, _)| face.corners()).map(at).collect();
    let distances: Vec<f64> = corners.iter().map(|x| (flat(x) - centre).norm()).collect();
    let radius = distances.iter().sum::<f64>() / distances.len() as f64;
    if distances
        .iter()
        .any(|distance| (distance - radius).abs() > ROUND * radius)
    {
        return None;
    }
    let mut angles: Vec<f64> = corners
        .iter()
        .map(|x| flat(x) - centre)
        .map(|x| x[1].atan2(x[0]))
        .collect();
    angles.sort_unstable_by(f64::total_cmp);
    let gaps = angles.windows(2).map(|pair| pair[1] - pair[0]);
    let around = angles[0] + 2.0 * PI - angles[angles.len() - 1];
    if gaps.chain([around]).any(|gap| gap > WIDEST_GAP) {
        return None;
    }
    let heights = corners.iter().map(|x| x.dot(&axis));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let on_axis = |height: f64| plane[0] * centre[0] + plane[1] * centre[1] + axis * height;
    Some(Hole {
        body,
        diameter: 2.0 * radius,
        ends: [on_axis(low).into(), on_axis(high).into()],
    })
}

/// Whether a hole is no bore of a body: the body is wide around it, or elsewhere.
fn has_room(body: &Body, bolt: &ProposedBolt) -> bool {
    let along = (Vector3::from(bolt.axis[1]) - Vector3::from(bolt.axis[0])).iamax();
    let mut across = (0..3).filter(|axis| *axis != along);
    across.any(|axis| {
        let width = body.high[axis] - body.low[axis];
        let off = bolt.axis[0][axis] - 0.5 * (body.high[axis] + body.low[axis]);
        width >= LEAST_WIDTH * bolt.diameter || off.abs() > MIDDLE * width
    })
}

/// The body that holds the middle of an axis: the box of one of its solids does.
fn filled_by(mesh: &SolidMesh, of_cell: &[u32], axis: [Vector3<f64>; 2]) -> Option<usize> {
    let middle = (axis[0] + axis[1]) * 0.5;
    let holds = |cell: &Cell| {
        (0..3).all(|i| {
            let along = cell.nodes().iter().map(|node| mesh.nodes[*node as usize][i]);
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            (low..=high).contains(&middle[i])
        })
    };
    let cell = mesh.cells.iter().position(holds)?;
    Some(of_cell[cell] as usize)
}

/// Holes of different bodies on one axis, one after the other.
fn bolts(holes: &[Hole], largest: f64) -> Vec<ProposedBolt> {
    let ends = |hole: &Hole| hole.ends.map(Vector3::from);
    let mut sets = DisjointSets::new(holes.len());
    for (number, hole) in holes.iter().enumerate() {
        let [a, b] = ends(hole);
        let Some(axis) = (b - a).try_normalize(0.0) else {
            continue;
        };
        let radius = 0.5 * hole.diameter;
        for (other, beside) in holes.iter().enumerate().skip(number + 1) {
            let [c, d] = ends(beside);
            let off = |x: Vector3<f64>| (x - a - axis * (x - a).dot(&axis)).norm();
            let is_coaxial = off(c).max(off(d)) <= COAXIAL * radius;
            let is_as_wide =
                (beside.diameter - hole.diameter).abs() <= SAME_RADIUS * hole.diameter.min(beside.diameter);
            let along = [c, d].map(|x| (x - a).dot(&axis));
            let length = (b - a).norm();
            let gap = along[0].min(along[1]).max(0.0) - along[0].max(along[1]).min(length);
            if is_coaxial && is_as_wide && gap <= COAXIAL * radius {
                sets.join(number as u32, other as u32);
            }
        }
    }
    let mut rows: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for number in 0..holes.len() {
        rows.entry(sets.root(number as u32)).or_default().push(number);
    }
    let rows = rows
        .into_values()
        .filter(|row| row.iter().any(|&hole| holes[hole].body != holes[row[0]].body));
    rows.map(|row| {
        let [a, b] = ends(&holes[row[0]]);
        let mut axis = (b - a).normalize();
        if axis[axis.iamax()] < 0.0 {
            axis = -axis;
        }
        let heights = row
            .iter()
            .flat_map(|&hole| ends(&holes[hole]))
            .map(|x| (x - a).dot(&axis));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        ProposedBolt {
            axis: [high, low].map(|height| (a + axis * height).map(|x| rounded(x, largest)).into()),
            filled_by: None,
            diameter: row
                .iter()
                .map(|&hole| holes[hole].diameter)
                .fold(f64::INFINITY, f64::min),
            holes: row,
        }
    })
    .collect()
}
