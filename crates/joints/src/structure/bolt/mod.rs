//! A bolt as engineers describe it, in a mesh that does not model it: two seats, a shank between them, and its tension.
//!
//! The seats are found in the mesh: on either side of the clamped parts, the faces under head and nut (or their washers). Each
//! seat is the cloud of a coupling whose reference point lies on the axis where the bolt's head or nut bears. The two
//! reference points are joined by a [`Shank`] with the compliance of VDI 2230 ([`Compliance`]): head, shank, threads and nut
//! together, so that only the parts are meshed. Washers are taken to be rigid.

mod compliance;
mod hole;

pub use compliance::{Compliance, Engagement, Term};
pub use hole::Placed;

use hole::{TILT, nearest_hole};
use joint_model::fit::Hole;
use scenes::metric::{Hexagon, Metric, Thread, Washer};

use crate::Error;
use finite_elements::mesh::{Assembly, Coupling, CouplingKind, Face, LoadPattern, Material, RigidMass, Section, Shank};
use nalgebra::{Matrix3, Vector3};
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;

/// Sub-triangles along an edge by which the part of a face inside of a seat is measured.
const SAMPLES: usize = 8;

/// A bolt through clamped parts, with a nut.
#[derive(Clone, Debug, PartialEq)]
pub struct BoltGeometry {
    /// Name used in messages and of its load.
    pub name: String,
    /// Two points on the axis (m), the one on the side of the head first. Beyond them the bolt clamps what lies on what is between them, without a gap.
    pub axis: [[f64; 3]; 2],
    /// The thread.
    pub thread: Thread,
    /// Under the head, then under the nut.
    pub seats: [Seat; 2],
    /// Material of bolt and nut.
    pub material: Material,
    /// How the seats follow head and nut.
    pub contact: HeadContact,
    /// Length of the shank without thread (m), from the head; `None` for a bolt threaded up to the head (ISO 4017).
    pub unthreaded: Option<f64>,
}

/// What a bolt bears on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seat {
    /// Inner diameter of the annulus that is pressed (m): of the hole or of the washer, whichever is larger.
    pub inner: f64,
    /// Outer diameter (m): of the face under the head, or of the washer.
    pub outer: f64,
    /// Washer, for its thickness and mass.
    pub washer: Option<Washer>,
    /// Head or nut, for its mass; `None` for one without mass.
    pub hexagon: Option<Hexagon>,
}

/// How the annulus under a head follows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeadContact {
    /// As a rigid body.
    Tied,
    /// On average: the pressure is uniform and the parts deform freely under it.
    Distributing,
}

impl BoltGeometry {
    /// A bolt of a metric size, with washers or without.
    pub fn metric(name: &str, size: &Metric, axis: [[f64; 3]; 2], washers: bool, material: Material) -> Self {
        let seat = |hexagon| Seat {
            inner: if washers {
                size.hole.max(size.washer.inner)
            } else {
                size.hole
            },
            outer: if washers { size.washer.outer } else { size.face },
            washer: washers.then_some(size.washer),
            hexagon: Some(hexagon),
        };
        Self {
            name: name.to_owned(),
            axis,
            thread: size.thread,
            seats: [seat(size.head), seat(size.nut)],
            material,
            contact: HeadContact::Tied,
            unthreaded: None,
        }
    }

    fn fail(&self, reason: String) -> Error {
        Error::Bolt {
            bolt: self.name.clone(),
            reason,
        }
    }

    fn validate(&self) -> Result<(), Error> {
        let admissible = |value: f64| value.is_finite() && value > 0.0;
        let Thread { diameter, pitch } = self.thread;
        if !(admissible(diameter) && admissible(pitch) && self.thread.core_diameter() > 0.0) {
            return Err(self.fail(format!(
                "diameter {diameter} m and pitch {pitch} m are no thread: both must be positive, and the pitch less than 0.8 of the \
                 diameter"
            )));
        }
        for (seat, side) in self.seats.iter().zip(SIDES) {
            if !(seat.inner.is_finite() && seat.inner >= 0.0 && admissible(seat.outer) && seat.outer > seat.inner) {
                return Err(self.fail(format!(
                    "the seat under the {side} has diameters {} m and {} m; the outer one must be larger than the inner one",
                    seat.inner, seat.outer
                )));
            }
            let sizes = seat
                .washer
                .map_or([1.0; 3], |w| [w.outer - w.inner, w.outer, w.thickness]);
            let hexagon = seat.hexagon.map_or([1.0; 2], |h| [h.across_flats, h.height]);
            if !sizes.into_iter().chain(hexagon).all(admissible) {
                return Err(self.fail(format!("sizes of washer and {side} must be positive (m)")));
            }
        }
        self.material.validate()?;
        Ok(())
    }
}

/// What messages call the two ends.
pub const SIDES: [&str; 2] = ["head", "nut"];

/// A bolt in a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Bolt {
    /// Under the head, then under the nut.
    pub couplings: [Coupling; 2],
    /// Between the reference points of both; its `ends` count these two.
    pub shank: Shank,
    /// Head and nut with their washers; `coupling` counts these two.
    pub masses: Vec<RigidMass>,
    /// What was found and computed.
    pub facts: BoltFacts,
}

/// What a bolt has become.
#[derive(Clone, Debug, PartialEq)]
pub struct BoltFacts {
    /// Distance of the seats (m).
    pub clamped: f64,
    /// Distance of the reference points: the clamped length and the washers (m).
    pub grip: f64,
    /// Under the head, then under the nut.
    pub seats: [SeatFacts; 2],
    /// By parts.
    pub compliance: Compliance,
    /// Mass of the bolt with head, nut and washers (kg).
    pub mass: f64,
}

/// A seat in a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeatFacts {
    /// Nodes that follow.
    pub nodes: usize,
    /// Share of the annulus that faces of the mesh cover; less than one at an edge, above one for polygons around a round hole.
    pub covered: f64,
    /// Largest angle between its faces and the plane at a right angle to the axis (degrees).
    pub tilt: f64,
    /// Where the axis meets its plane (m).
    pub centre: [f64; 3],
    /// The round hole in its plane whose centre is under head, nut or washer; none in a mesh without holes.
    pub hole: Option<Hole>,
}

impl SeatFacts {
    /// How far faces of one seat may be from its plane (m), under a head, nut or washer of this diameter.
    pub fn depth(outer: f64) -> f64 {
        0.01 * outer
    }
}

impl Bolt {
    /// Finds the seats among `boundary` ([`Mesh::boundary`](finite_elements::mesh::Mesh::boundary)) and computes the shank.
    ///
    /// A node of a seat is one of its faces' within the annulus. Its weight is its share of the area of these faces, each multiplied by
    /// the part of the face that lies inside of the annulus.
    ///
    /// # Errors
    /// [`Error::Bolt`] naming the seat and what would be accepted.
    pub fn try_new(nodes: &[[f64; 3]], boundary: &[Face], geometry: &BoltGeometry) -> Result<Self, Error> {
        geometry.validate()?;
        let [a, b] = geometry.axis.map(Vector3::from);
        let axis = (b - a)
            .try_normalize(1e-12 * a.amax().max(b.amax()))
            .filter(|axis| axis.iter().all(|v| v.is_finite()))
            .ok_or_else(|| {
                geometry.fail(format!(
                    "the points {a:?} and {b:?} define no axis; give two different points (m)"
                ))
            })?;
        let ends = [(0, a, axis), (1, a, -axis)];
        let [head, nut] =
            ends.map(|(end, origin, inward)| FoundSeat::try_new(nodes, boundary, geometry, end, origin, inward));
        let (head, nut) = (head?, nut?);
        // Along the axis from head to nut.
        let (first, last) = (head.height, -nut.height);
        let clamped = last - first;
        let thickness = geometry
            .seats
            .map(|seat| seat.washer.map_or(0.0, |washer| washer.thickness));
        let grip = clamped + thickness[0] + thickness[1];
        if !(clamped > 0.0) {
            return Err(
                geometry.fail("its seats do not lie one behind the other; exchange the points of its axis".into())
            );
        }
        // As long as the grip, but for round-off.
        let unthreaded = geometry.unthreaded.unwrap_or(0.0);
        if !(unthreaded >= 0.0 && unthreaded <= grip * (1.0 + 1e-9)) {
            return Err(geometry.fail(format!(
                "the shank without thread, {unthreaded:.4e} m long, does not fit into the grip of {grip:.4e} m"
            )));
        }
        let unthreaded = unthreaded.min(grip);
        let heights = [first - thickness[0], last + thickness[1]];
        let seats = [head.facts, nut.facts];
        let mut found = [head, nut]
            .into_iter()
            .zip(heights)
            .zip(SIDES)
            .map(|((seat, height), side)| Coupling {
                name: format!("{} under the {side}", geometry.name),
                reference: (a + axis * height).into(),
                nodes: seat.weights.keys().copied().collect(),
                kind: match geometry.contact {
                    HeadContact::Tied => CouplingKind::Kinematic([true; 3]),
                    HeadContact::Distributing => CouplingKind::Distributing(seat.weights.into_values().collect()),
                },
            });
        let (Some(head), Some(nut)) = (found.next(), found.next()) else {
            return Err(geometry.fail("a seat is missing".into()));
        };
        let couplings = [head, nut];
        let modulus = geometry.material.youngs_modulus;
        let compliance = Compliance::new(&geometry.thread, grip, unthreaded, modulus, Engagement::Nut(modulus));
        let shank = shank(geometry, axis, grip, unthreaded, &compliance);
        let masses: Vec<RigidMass> = (0_u32..)
            .zip(&geometry.seats)
            .zip([-axis, axis])
            .filter_map(|((end, seat), outward)| ends_mass(seat, geometry.material.density, outward, end))
            .collect();
        let mass = shank.mass * grip + masses.iter().map(|body| body.mass).sum::<f64>();
        Ok(Self {
            couplings,
            shank,
            masses,
            facts: BoltFacts {
                clamped,
                grip,
                seats,
                compliance,
                mass,
            },
        })
    }

    /// Puts the bolt into an assembly, with a load of unit tension.
    pub fn join(self, assembly: &mut Assembly) -> BoltFacts {
        let first = assembly.couplings.len() as u32;
        assembly.couplings.extend(self.couplings);
        let mut shank = self.shank;
        shank.ends = shank.ends.map(|end| first + end);
        let name = shank.name.clone();
        let overlap = assembly.add_shank(shank);
        assembly.loads.push(LoadPattern {
            name,
            terms: vec![(overlap, 1.0)],
        });
        let masses = self.masses.into_iter().map(|body| RigidMass {
            coupling: first + body.coupling,
            ..body
        });
        assembly.rigid_masses.extend(masses);
        self.facts
    }
}

/// A beam between the reference points that is as compliant as the bolt: `EI = grip / beta_S`, `GJ = EI / (1 + nu)`, and the shear stiffness
/// of the grip's own sections one behind the other.
fn shank(geometry: &BoltGeometry, axis: Vector3<f64>, grip: f64, unthreaded: f64, compliance: &Compliance) -> Shank {
    let Material {
        youngs_modulus,
        poisson_ratio: nu,
        density,
        ..
    } = geometry.material;
    let (nominal, core) = (geometry.thread.diameter, geometry.thread.core_diameter());
    let between = |of: [f64; 2]| (unthreaded * of[0] + (grip - unthreaded) * of[1]) / grip;
    let areas = [nominal, core].map(|d| Section::Circle(d).area());
    let shear_modulus = 0.5 * youngs_modulus / (1.0 + nu);
    // Cowper's coefficient of circles.
    let coefficient = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu);
    let shear = coefficient * shear_modulus / between(areas.map(f64::recip));
    let bending = grip / compliance.bending();
    // Threads weigh as much as a cylinder of their stress diameter.
    let sections = [nominal, geometry.thread.stress_diameter()].map(Section::Circle);
    let second_moment = between(sections.map(|section| section.second_moments()[0]));
    let tilt = density * second_moment;
    Shank {
        name: geometry.name.clone(),
        ends: [0, 1],
        axial: 1.0 / compliance.axial(),
        bending: [bending; 2],
        shear: [shear; 2],
        torsion: bending / (1.0 + nu),
        mass: density * between(sections.map(|section| section.area())),
        inertia: [2.0 * tilt, tilt, tilt],
        transverse: Vector3::ith(axis.iamin(), 1.0).into(),
    }
}

/// Head or nut with its washer, about the point where it bears on the washer.
fn ends_mass(seat: &Seat, density: f64, outward: Vector3<f64>, coupling: u32) -> Option<RigidMass> {
    // Mass, radii of gyration squared about the axis and across it about the own centre, and the centre along the axis.
    let hexagon = seat.hexagon.map(
        |Hexagon {
             across_flats: s,
             height,
         }| {
            // Regular hexagon: A = sqrt(3)/2 s^2, I = 5/72 s^2 A about any axis in its plane.
            let tilt = 5.0 / 72.0 * s * s;
            (
                density * 0.75_f64.sqrt() * s * s * height,
                2.0 * tilt,
                tilt + height * height / 12.0,
                0.5 * height,
            )
        },
    );
    let washer = seat.washer.map(
        |Washer {
             inner,
             outer,
             thickness,
         }| {
            let spin = (inner * inner + outer * outer) / 8.0;
            let mass = density * PI / 4.0 * (outer * outer - inner * inner) * thickness;
            (mass, spin, 0.5 * spin + thickness * thickness / 12.0, -0.5 * thickness)
        },
    );
    let along = outward * outward.transpose();
    let across = Matrix3::identity() - along;
    let (mut total, mut inertia) = (0.0, Matrix3::zeros());
    for (mass, spin, tilt, centre) in hexagon.into_iter().chain(washer) {
        total += mass;
        inertia += (along * spin + across * (tilt + centre * centre)) * mass;
    }
    (total > 0.0).then(|| RigidMass {
        coupling,
        mass: total,
        inertia: [0, 1, 2].map(|i| [0, 1, 2].map(|j| inertia[(i, j)])),
    })
}

/// A seat in the mesh.
struct FoundSeat {
    /// Of its nodes (m^2).
    weights: BTreeMap<u32, f64>,
    /// Position of its plane along the axis inwards (m).
    height: f64,
    facts: SeatFacts,
}

/// A face that looks out of the clamped parts and lies in the annulus, at least in part.
struct Candidate<'f> {
    face: &'f Face,
    /// Area vector (m^2).
    area: Vector3<f64>,
    /// Of its middle along the axis (m).
    height: f64,
    /// Part inside of the annulus.
    inside: f64,
}

impl FoundSeat {
    fn try_new(
        nodes: &[[f64; 3]],
        boundary: &[Face],
        geometry: &BoltGeometry,
        end: usize,
        origin: Vector3<f64>,
        inward: Vector3<f64>,
    ) -> Result<Self, Error> {
        let (seat, side) = (&geometry.seats[end], SIDES[end]);
        let radii = [0.5 * seat.inner, 0.5 * seat.outer];
        let from_axis = |x: Vector3<f64>| (x - origin - inward * inward.dot(&(x - origin))).norm();
        let mut nearest = f64::INFINITY;
        let mut candidates = Vec::new();
        // Where solids end that begin farther out.
        let mut backs: Vec<f64> = Vec::new();
        for face in boundary {
            let corners: Vec<Vector3<f64>> = face.corners().iter().map(|&n| nodes[n as usize].into()).collect();
            let middle = corners.iter().sum::<Vector3<f64>>() / corners.len() as f64;
            let reach = corners.iter().map(|x| (x - middle).norm()).fold(0.0, f64::max);
            let distance = from_axis(middle);
            nearest = nearest.min((distance - reach).max(0.0));
            if distance > radii[1] + reach || distance + reach < radii[0] {
                continue;
            }
            let area = area_vector(&corners);
            // Walls of holes stand upright.
            let is_upright = area.dot(&inward).abs() < 0.5 * area.norm();
            let inside = match is_upright {
                true => 0.0,
                false => part_inside(&corners, middle, |x| (radii[0]..=radii[1]).contains(&from_axis(x))),
            };
            let height = inward.dot(&(middle - origin));
            if inside > 0.0 && area.dot(&inward) > 0.0 {
                backs.push(height);
            } else if inside > 0.0 {
                candidates.push(Candidate {
                    face,
                    area,
                    height,
                    inside,
                });
            }
        }
        let depth = SeatFacts::depth(seat.outer);
        // What lies beyond a gap from the point given is not clamped.
        let given = inward.dot(&(Vector3::from(geometry.axis[end]) - origin));
        let gap = (backs.into_iter())
            .filter(|back| *back <= given + depth && !candidates.iter().any(|c| (c.height - back).abs() <= depth))
            .fold(f64::NEG_INFINITY, f64::max);
        candidates.retain(|candidate| candidate.height > gap);
        let outermost = candidates.iter().map(|c| c.height).fold(f64::INFINITY, f64::min);
        if candidates.is_empty() {
            return Err(geometry.fail(format!(
                "no face of the mesh lies under the {side}, {:.4e} to {:.4e} m from the axis and facing outwards; the nearest face is \
                 {nearest:.4e} m from the axis: check the axis, the diameters and the unit of length",
                radii[0], radii[1]
            )));
        }
        let members = grown(&candidates, outermost + depth);
        let tilt = |c: &&Candidate<'_>| {
            (-c.area.dot(&inward) / c.area.norm())
                .clamp(-1.0, 1.0)
                .acos()
                .to_degrees()
        };
        let tilt = members.iter().map(tilt).fold(0.0, f64::max);
        if tilt > TILT {
            return Err(geometry.fail(format!(
                "a face under the {side} is tilted by {tilt:.1} degrees against the axis, of at most {TILT}: correct the axis, or let \
                 the seat begin beyond the chamfer or fillet of the hole"
            )));
        }
        let tolerance = 1e-6 * seat.outer;
        let mut weights: BTreeMap<u32, f64> = BTreeMap::new();
        let (mut area, mut moment) = (0.0, 0.0);
        for member in &members {
            for (node, share) in member.face.areas(nodes) {
                let distance = from_axis(nodes[node as usize].into());
                if distance >= radii[0] - tolerance && distance <= radii[1] + tolerance {
                    *weights.entry(node).or_default() += member.inside * share;
                }
            }
            let part = member.inside * member.area.norm();
            area += part;
            moment += part * member.height;
        }
        weights.retain(|_, weight| *weight > 0.0);
        if !spread(nodes, &weights) {
            return Err(geometry.fail(format!(
                "only {} nodes of the mesh lie under the {side}, {:.4e} to {:.4e} m from the axis, or all on one line; at least three are \
                 needed: mesh the seat with elements of {:.1e} m or less",
                weights.len(),
                radii[0],
                radii[1],
                0.5 * (radii[1] - radii[0])
            )));
        }
        let height = moment / area;
        let centre = origin + inward * height;
        let in_plane = boundary.iter().filter(|face| {
            let corners: Vec<Vector3<f64>> = face.corners().iter().map(|&n| nodes[n as usize].into()).collect();
            let middle = corners.iter().sum::<Vector3<f64>>() / corners.len() as f64;
            hole::is_in_plane(
                area_vector(&corners),
                middle,
                centre,
                -inward,
                SeatFacts::depth(seat.outer),
            )
        });
        let in_plane: Vec<&Face> = in_plane.collect();
        Ok(Self {
            facts: SeatFacts {
                centre: centre.into(),
                hole: nearest_hole(nodes, &in_plane, centre, -inward, radii[1]),
                nodes: weights.len(),
                covered: area / (PI * (radii[1].powi(2) - radii[0].powi(2))),
                tilt,
            },
            height,
            weights,
        })
    }
}

/// The candidates that are connected with those up to `height`: faces of parts farther in are not, however thin the outer part.
fn grown<'c, 'f>(candidates: &'c [Candidate<'f>], height: f64) -> Vec<&'c Candidate<'f>> {
    let mut of_node: HashMap<u32, Vec<usize>> = HashMap::new();
    for (index, candidate) in candidates.iter().enumerate() {
        for &node in candidate.face.corners() {
            of_node.entry(node).or_default().push(index);
        }
    }
    let mut taken = vec![false; candidates.len()];
    let mut open: Vec<usize> = (0..candidates.len())
        .filter(|&i| candidates[i].height <= height)
        .collect();
    while let Some(index) = open.pop() {
        if !std::mem::replace(&mut taken[index], true) {
            let corners = candidates[index].face.corners();
            open.extend(corners.iter().filter_map(|node| of_node.get(node)).flatten());
        }
    }
    let members = candidates.iter().zip(taken);
    members
        .filter_map(|(candidate, taken)| taken.then_some(candidate))
        .collect()
}

fn area_vector(corners: &[Vector3<f64>]) -> Vector3<f64> {
    let fan = (1..corners.len() - 1).map(|i| (corners[i] - corners[0]).cross(&(corners[i + 1] - corners[0])));
    fan.sum::<Vector3<f64>>() * 0.5
}

/// Part of the area of a face whose points fulfil a condition, by samples.
fn part_inside(corners: &[Vector3<f64>], middle: Vector3<f64>, inside: impl Fn(Vector3<f64>) -> bool) -> f64 {
    let (mut all, mut within) = (0.0, 0.0);
    for (i, corner) in corners.iter().enumerate() {
        let sides = [corner - middle, corners[(i + 1) % corners.len()] - middle];
        let area = sides[0].cross(&sides[1]).norm();
        all += area;
        let mut count = 0;
        let at = |i: usize, j: usize, third: f64| {
            let [s, t] = [i, j].map(|k| (k as f64 + third) / SAMPLES as f64);
            inside(middle + sides[0] * s + sides[1] * t)
        };
        for i in 0..SAMPLES {
            // Centres of the triangles that point up, and of those that point down.
            count += (0..SAMPLES - i).filter(|&j| at(i, j, 1.0 / 3.0)).count();
            count += (1..SAMPLES - i).filter(|&j| at(i, j - 1, 2.0 / 3.0)).count();
        }
        within += area * count as f64 / (SAMPLES * SAMPLES) as f64;
    }
    within / all
}

/// Whether at least three nodes span a plane.
fn spread(nodes: &[[f64; 3]], weights: &BTreeMap<u32, f64>) -> bool {
    let at = || weights.keys().map(|&node| Vector3::from(nodes[node as usize]));
    let count = weights.len() as f64;
    let middle = at().sum::<Vector3<f64>>() / count;
    let scatter: Matrix3<f64> = at().map(|x| (x - middle) * (x - middle).transpose()).sum();
    let mut sizes: [f64; 3] = scatter.symmetric_eigenvalues().into();
    sizes.sort_by(f64::total_cmp);
    weights.len() >= 3 && sizes[1] > 1e-6 * sizes[2]
}
