//! The hole that a bolt passes, as the faces around it show it, and bolts that are in one another's place.

use finite_elements::mesh::Face;
use joint_model::fit::Hole;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Largest angle between a seat and the plane at a right angle to the axis (degrees).
pub(super) const TILT: f64 = 10.0;

/// Largest over least distance of a rim from its centre up to which it counts as round: a square has 1.42, a slot more.
const ROUND: f64 = 1.5;

/// Distance of axes that are the same, relative to what they clamp, where no diameter is known.
const SAME: f64 = 1e-3;

/// Of the round holes among faces of one plane that look `outward`, the one nearest to the axis through `centre`, up to `reach` (m).
pub(super) fn nearest_hole(
    nodes: &[[f64; 3]],
    faces: &[&Face],
    centre: Vector3<f64>,
    outward: Vector3<f64>,
    reach: f64,
) -> Option<Hole> {
    let at = |node: u32| Vector3::from(nodes[node as usize]) - centre;
    let holes = rims(faces).into_iter().filter_map(|rim| {
        let points: Vec<Vector3<f64>> = rim.into_iter().map(at).collect();
        let origin = points[0];
        // Twice the area towards the outside: negative around a hole, as faces have their corners counter-clockwise.
        let fan = points.windows(2).map(|edge| {
            let double = (edge[0] - origin).cross(&(edge[1] - origin)).dot(&outward);
            (double, (origin + edge[0] + edge[1]) / 3.0)
        });
        let (area, moment) = fan.fold((0.0, Vector3::zeros()), |(area, moment), (part, middle)| {
            (area + part, moment + middle * part)
        });
        if !(area < 0.0) {
            return None;
        }
        let middle: Vector3<f64> = moment / area;
        let distances = points.iter().map(|x| (x - middle).norm());
        let (least, largest, sum) = distances.fold((f64::INFINITY, 0.0_f64, 0.0), |(least, largest, sum), d| {
            (least.min(d), largest.max(d), sum + d)
        });
        let offset = (middle - outward * middle.dot(&outward)).norm();
        (largest <= ROUND * least && offset <= reach).then_some(Hole {
            diameter: 2.0 * sum / points.len() as f64,
            offset,
        })
    });
    holes.min_by(|a, b| a.offset.total_cmp(&b.offset))
}
/// Closed rims of faces, in the sense of the faces; those that cross themselves are left out.
fn rims(faces: &[&Face]) -> Vec<Vec<u32>> {
    let mut open: BTreeSet<[u32; 2]> = BTreeSet::new();
    for face in faces {
        let corners = face.corners();
        for (i, &from) in corners.iter().enumerate() {
            let to = corners[(i + 1) % corners.len()];
            if !open.remove(&[to, from]) {
                open.insert([from, to]);
            }
        }
    }
    let mut next: BTreeMap<u32, Option<u32>> = BTreeMap::new();
    for [from, to] in open {
        // A node with two ways on has none.
        next.entry(from).and_modify(|way| *way = None).or_insert(Some(to));
    }
    let mut rims = Vec::new();
    while let Some((&start, _)) = next.first_key_value() {
        let mut rim = vec![start];
        let mut node = start;
        while let Some(Some(to)) = next.remove(&node) {
            if to == start {
                rims.push(std::mem::take(&mut rim));
                break;
            }
            rim.push(to);
            node = to;
        }
    }
    rims
}

/// Whether a face lies in the plane through `centre`, within `tolerance` (m), and looks along `outward`.
pub(super) fn is_in_plane(
    area: Vector3<f64>,
    middle: Vector3<f64>,
    centre: Vector3<f64>,
    outward: Vector3<f64>,
    tolerance: f64,
) -> bool {
    area.dot(&outward) >= TILT.to_radians().cos() * area.norm() && (middle - centre).dot(&outward).abs() <= tolerance
}

/// A bolt where it clamps.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Where head and nut press (m).
    pub ends: [Vector3<f64>; 2],
    /// Diameter of the shank (m); zero where there is none.
    pub shank: f64,
}

impl Placed {
    /// Distance of the axes (m), if both bolts cannot be: their axes are parallel and nearer than shanks have room, along a common part.
    pub fn collision(&self, other: &Self) -> Option<f64> {
        let [a, b] = [self, other].map(|bolt| bolt.ends[1] - bolt.ends[0]);
        let axis = a.try_normalize(0.0)?;
        if b.cross(&axis).norm() > TILT.to_radians().sin() * b.norm() {
            return None;
        }
        let way = 0.5 * (other.ends[0] + other.ends[1]) - self.ends[0];
        let distance = (way - axis * way.dot(&axis)).norm();
        let room = (0.5 * (self.shank + other.shank)).max(SAME * a.norm());
        let along = other.ends.map(|end| (end - self.ends[0]).dot(&axis));
        let common = along[0].max(along[1]).min(a.norm()) - along[0].min(along[1]).max(0.0);
        // `SAME` is room for bolts that end where another begins.
        (distance < room && common > SAME * a.norm()).then_some(distance)
    }

    /// Distance of two ends (m) in one plane at a right angle to the axis, within `tolerance` (m).
    pub fn beside(&self, end: usize, other: Vector3<f64>, tolerance: f64) -> Option<f64> {
        let axis = (self.ends[1] - self.ends[0]).try_normalize(0.0)?;
        let way = other - self.ends[end];
        let along = way.dot(&axis);
        (along.abs() <= tolerance).then(|| (way - axis * along).norm())
    }
}
