//! The block-structured hexahedral mesh of the beam and everything that connects and loads it.
//!
//! Plane sections are extruded into layers; blocks share their nodes by construction, never by a search for
//! coinciding points.
//! - Elements are linear or quadratic. Edges on circles of holes and hardware are straight or parabolas accordingly; nodes lie on the
//!   radius for which the area is that of the circle.
//! - Half-beams: the interface mesh extruded through half the height, and a brick-meshed arm on one side. The arm's
//!   end face beside the other half-beam's lap stays free.
//! - Bolt: head and shank are one body with the washer under the head; nut and its washer are another. The shank runs
//!   freely through washers and holes.
//! - Ties glue each washer to the beam's face. Distributing couplings on the nut's bore and on the part of the shank
//!   that faces it lead to two reference points, whose motions are equal except for the displacement along the bolt.
mod half;
mod refinement;
mod section;

pub use refinement::{Refinement, Washers};

use crate::geometry::{Geometry, positive};
use crate::{Error, Result, quality};
use finite_elements::elements::Formulation;
use finite_elements::mesh::{
    Assembly, BeyondTolerance, Cell, Coupling, CouplingKind, Dof, Element as Solid, Equation, Face, LoadPattern,
    Material, Mesh, Tie,
};
use joint_model::benchmark::ElementOrder;
use joint_model::quadratic;
use refinement::require_count;
use section::{Hardware, Lap, Section, centred, sorted};
use std::collections::HashMap;
use std::ops::Range;
use zte_assembly::mesh::{Element, InterfaceMesh};

/// Neighbouring layers of an arm may differ by this factor at most.
const GREATEST_GRADING: f64 = 1.5;

/// Position tolerance of the ties in washer thicknesses: the washers lie on the faces up to rounding.
const TIE_TOLERANCE: f64 = 1e-6;

/// The meshed benchmark.
///
/// The top half-beam (`z > 0` in the lap) carries the arm towards `-x` and the bolts' heads; the bottom half-beam
/// carries the arm towards `+x` and the nuts.
#[derive(Clone, Debug, PartialEq)]
pub struct BrakeReussBeam {
    /// Solid mesh, six washer ties, six couplings (shank and nut of each bolt in turn), fifteen equations, and the
    /// load patterns `bolt_load_1` to `bolt_load_3` (by increasing `x`). Use these or their sum, not both.
    pub assembly: Assembly,
    /// The interface in its plane, coordinates (x, y) (m).
    pub interface: InterfaceMesh,
    /// Node of the top half-beam for each interface node.
    pub top_nodes: Vec<u32>,
    /// Node of the bottom half-beam for each interface node.
    pub bottom_nodes: Vec<u32>,
    /// Unit vectors of the relative coordinates as rows: along the beam, across, and the normal that points from the
    /// top half-beam into the bottom one. They are x, y, -z of the mesh.
    pub frame: [[f64; 3]; 3],
    /// Node at the beam's end at the least `x`, in the middle of the section's upper edge.
    pub response_node: u32,
    /// Bending direction at the response node: `z`.
    pub response_direction: [f64; 3],
    /// The parts, in the order of their elements; together they cover the mesh.
    pub parts: Vec<Part>,
}

impl BrakeReussBeam {
    /// The sum of the loads of all bolts, named `bolt_load`.
    pub fn bolt_load_pattern(&self) -> LoadPattern {
        LoadPattern {
            name: "bolt_load".to_owned(),
            terms: self
                .assembly
                .loads
                .iter()
                .flat_map(|load| load.terms.iter().copied())
                .collect(),
        }
    }

    /// Gives all elements a node in the middle of each edge; those of some edges are given (m).
    fn raise(&mut self, middles: &HashMap<[u32; 2], [f64; 3]>) -> Result<()> {
        let sides = [&mut self.top_nodes, &mut self.bottom_nodes];
        let middle = |edge| middles.get(&edge).copied();
        quadratic::raise(&mut self.assembly, &mut self.interface, sides, self.frame, middle)?;
        Ok(())
    }

    /// The part of this name.
    pub fn part(&self, name: &str) -> Option<&Part> {
        self.parts.iter().find(|part| part.name == name)
    }
}

/// A named range of elements.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// `top_half_beam`, `bottom_half_beam`, and for each bolt `b` from 1 to 3 `shank_b`, `head_b`, `head_washer_b`,
    /// `nut_b`, `nut_washer_b`.
    pub name: String,
    /// Elements of the mesh.
    pub elements: Range<usize>,
}

/// Meshes the beam. `bolt_tension` is the tension of each bolt (N). Hexahedra have incompatible modes; quadratic ones have reduced
/// integration.
///
/// # Errors
/// [`Error`] if a dimension, a count, a material constant or the load is not admissible, or if an element comes out
/// inverted.
pub fn build(
    geometry: &Geometry,
    refinement: &Refinement,
    order: ElementOrder,
    material: &Material,
    bolt_tension: f64,
) -> Result<BrakeReussBeam> {
    geometry.validate()?;
    refinement.validate()?;
    if !(bolt_tension.is_finite() && bolt_tension >= 0.0) {
        return Err(Error::Value {
            place: "bolts",
            field: "bolt_tension",
            value: bolt_tension,
            unit: "N",
            requirement: "finite and not negative",
        });
    }
    let mut builder = Builder::try_new(material)?;
    let lap = section::lap(geometry, refinement, order)?;
    let top = builder.half_beam(geometry, refinement, &lap, Side::Top)?;
    let bottom = builder.half_beam(geometry, refinement, &lap, Side::Bottom)?;

    let hardware = section::hardware(geometry, refinement, order)?;
    let mut assembly = Assembly::default();
    for (index, x) in geometry.hole_positions().into_iter().enumerate() {
        let fastener = builder.fastener(geometry, refinement, &hardware, x, index + 1);
        fastener.connect(
            geometry,
            [&top.face_quads, &bottom.face_quads],
            bolt_tension,
            &mut assembly,
        );
    }
    assembly.mesh = builder.mesh;
    let mut beam = BrakeReussBeam {
        assembly,
        interface: InterfaceMesh::flat(
            lap.section.nodes.clone(),
            lap.section.quads.iter().copied().map(Element::quad4).collect(),
        ),
        top_nodes: top.interface,
        bottom_nodes: bottom.interface,
        frame: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
        response_node: top.end_edge_middle,
        response_direction: [0.0, 0.0, 1.0],
        parts: builder.parts,
    };
    if order == ElementOrder::Quadratic {
        beam.raise(&builder.middles)?;
    }
    check(&beam.assembly.mesh, &beam.parts)?;
    Ok(beam)
}

/// Meshes the top half-beam alone.
///
/// # Errors
/// As [`build`].
pub fn half_beam(geometry: &Geometry, refinement: &Refinement, material: &Material) -> Result<Mesh> {
    geometry.validate()?;
    refinement.validate()?;
    let mut builder = Builder::try_new(material)?;
    builder.half_beam(
        geometry,
        refinement,
        &section::lap(geometry, refinement, ElementOrder::Linear)?,
        Side::Top,
    )?;
    check(&builder.mesh, &builder.parts)?;
    Ok(builder.mesh)
}

/// Meshes a bar of `nx` x `ny` x `nz` equal bricks (m): `x` from 0 to `length`, section centred about `y = z = 0`.
/// Node
/// `(i, j, k)` has number `(i (ny + 1) + j) (nz + 1) + k`.
///
/// # Errors
/// [`Error::Value`] or [`Error::Count`] if an argument is not admissible.
pub fn uniform_bar(
    length: f64,
    width: f64,
    height: f64,
    nx: usize,
    ny: usize,
    nz: usize,
    material: &Material,
) -> Result<Mesh> {
    for (field, value) in [("length", length), ("width", width), ("height", height)] {
        positive("bar", field, value, "m")?;
    }
    for (field, value) in [("nx", nx), ("ny", ny), ("nz", nz)] {
        require_count(field, value)?;
    }
    let mut builder = Builder::try_new(material)?;
    let levels: Vec<_> = centred(length, nx).map(|x| x + 0.5 * length).collect();
    let section = section::rectangle(centred(width, ny), centred(height, nz));
    builder.part("bar", |builder| {
        builder.extrude(&section, &levels, along_x, |_, _| None)
    });
    check(&builder.mesh, &builder.parts)?;
    Ok(builder.mesh)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Top,
    Bottom,
}

/// What the rest needs to know about a half-beam.
struct HalfBeam {
    /// Interface nodes in the order of the lap's section.
    interface: Vec<u32>,
    /// Faces of the lap's outer surface; counter-clockwise seen from outside.
    face_quads: Vec<[u32; 4]>,
    /// Node at the arm's end in the middle of the edge at the greatest `z`.
    end_edge_middle: u32,
}

/// Bolt, nut and two washers.
struct Fastener {
    number: usize,
    x: f64,
    head_washer_face: Vec<u32>,
    nut_washer_face: Vec<u32>,
    /// Surfaces that the couplings hold on to, by layers of nodes from the nut's lower to its upper end.
    shank_surface: Vec<Vec<u32>>,
    nut_bore: Vec<Vec<u32>>,
}

struct Builder {
    mesh: Mesh,
    parts: Vec<Part>,
    /// Middles of edges that may be curved, by the ends in increasing order (m).
    middles: HashMap<[u32; 2], [f64; 3]>,
}

impl Builder {
    fn try_new(material: &Material) -> Result<Self> {
        material.validate()?;
        let mesh = Mesh {
            materials: vec![material.clone()],
            ..Mesh::default()
        };
        Ok(Self {
            mesh,
            parts: Vec::new(),
            middles: HashMap::new(),
        })
    }

    /// Records the elements that `make` adds as a part.
    fn part<T>(&mut self, name: impl Into<String>, make: impl FnOnce(&mut Self) -> T) -> T {
        let first = self.mesh.elements.len();
        let made = make(self);
        self.parts.push(Part {
            name: name.into(),
            elements: first..self.mesh.elements.len(),
        });
        made
    }

    /// Extrudes a section through increasing levels. `place` maps section coordinates and level to space without
    /// mirroring; `shared` names the existing node to use for a section node and a level number, if there is one.
    /// Returns the nodes, level by level.
    fn extrude(
        &mut self,
        section: &Section,
        levels: &[f64],
        place: impl Fn([f64; 2], f64) -> [f64; 3],
        shared: impl Fn(usize, usize) -> Option<u32>,
    ) -> Vec<Vec<u32>> {
        let mesh = &mut self.mesh;
        let mut nodes: Vec<Vec<u32>> = Vec::with_capacity(levels.len());
        for (level, &height) in levels.iter().enumerate() {
            let layer = section.nodes.iter().enumerate().map(|(node, &point)| {
                shared(node, level).unwrap_or_else(|| {
                    mesh.nodes.push(place(point, height));
                    mesh.nodes.len() as u32 - 1
                })
            });
            nodes.push(layer.collect());
        }
        for (layer, &height) in nodes.iter().zip(levels) {
            let middles = section.middles();
            let in_space =
                |(edge, at): ([u32; 2], _)| (sorted(edge.map(|node| layer[node as usize])), place(at, height));
            self.middles.extend(middles.map(in_space));
        }
        for pair in nodes.windows(2) {
            for &[a, b, c, d] in &section.quads {
                let corners = [a, b, c, d].map(|node| node as usize);
                let [e, f, g, h] = corners.map(|node| pair[0][node]);
                let [i, j, k, l] = corners.map(|node| pair[1][node]);
                mesh.elements.push(Solid {
                    cell: Cell::hex8([e, f, g, h, i, j, k, l], Formulation::IncompatibleModes),
                    material: 0,
                });
            }
        }
        nodes
    }

    fn half_beam(&mut self, geometry: &Geometry, refinement: &Refinement, lap: &Lap, side: Side) -> Result<HalfBeam> {
        let (across, layers) = (refinement.across, refinement.layers);
        let heights = section::symmetric(geometry.height, layers, refinement.layer_growth);
        let arm = section::rectangle(centred(geometry.width, across), heights.iter().copied());
        let distances = graded("arm", lap.edge_column, geometry.arm_length(), refinement.arm_layers)?;

        let half_lap = 0.5 * geometry.lap_length;
        // The lap's layers in the arm's numbering, and the arm's stations by increasing x with the joint among them.
        let (lap_layers, edge, stations, joint): (_, _, Vec<f64>, _) = match side {
            Side::Top => {
                let stations = distances.iter().rev().map(|d| -half_lap - d).collect();
                (layers..=2 * layers, &lap.left, stations, refinement.arm_layers)
            }
            Side::Bottom => (
                0..=layers,
                &lap.right,
                distances.iter().map(|d| half_lap + d).collect(),
                0,
            ),
        };
        let name = if side == Side::Top {
            "top_half_beam"
        } else {
            "bottom_half_beam"
        };
        Ok(self.part(name, |builder| {
            let levels = &heights[lap_layers.clone()];
            let lap_nodes = builder.extrude(&lap.section, levels, |p, z| [p[0], p[1], z], |_, _| None);
            let arm_nodes = builder.extrude(&arm, &stations, along_x, |node, station| {
                let (column, layer) = (node / (2 * layers + 1), node % (2 * layers + 1));
                let in_lap = station == joint && lap_layers.contains(&layer);
                in_lap.then(|| lap_nodes[layer - lap_layers.start()][edge[column] as usize])
            });
            let (interface, face, end) = match side {
                Side::Top => (&lap_nodes[0], &lap_nodes[layers], &arm_nodes[0]),
                Side::Bottom => (&lap_nodes[layers], &lap_nodes[0], &arm_nodes[refinement.arm_layers]),
            };
            let face_quads = lap.section.quads.iter().map(|quad| {
                let [a, b, c, d] = quad.map(|node| face[node as usize]);
                if side == Side::Top { [a, b, c, d] } else { [a, d, c, b] }
            });
            HalfBeam {
                interface: interface.clone(),
                face_quads: face_quads.collect(),
                end_edge_middle: end[across / 2 * (2 * layers + 1) + 2 * layers],
            }
        }))
    }

    fn fastener(
        &mut self,
        geometry: &Geometry,
        refinement: &Refinement,
        hardware: &Hardware,
        x: f64,
        number: usize,
    ) -> Fastener {
        let place = |p: [f64; 2], z: f64| [x + p[0], p[1], z];
        let layers = |from: f64, to: f64, count: usize| -> Vec<f64> {
            (0..=count)
                .map(|i| i as f64 / count as f64)
                .map(|t| (1.0 - t) * from + t * to)
                .collect()
        };
        let face = 0.5 * geometry.height;
        let seat = face + geometry.washer_thickness;
        let head_top = seat + geometry.head_height;
        let nut_end = -seat - geometry.nut_height;
        let (seat_nodes, sectors) = (hardware.seat, refinement.sectors);
        let shank_nodes = hardware.shank.nodes.len();

        let mut shank_levels = layers(head_top - geometry.bolt_length, nut_end, refinement.tip_layers);
        let nut_levels = layers(nut_end, -seat, refinement.head_layers);
        shank_levels.extend(&nut_levels[1..]);
        shank_levels.extend(&layers(-seat, seat, refinement.grip_layers)[1..]);
        let shank = self.part(format!("shank_{number}"), |builder| {
            builder.extrude(&hardware.shank, &shank_levels, place, |_, _| None)
        });
        let shank_top = &shank[shank.len() - 1];
        let head_levels = layers(seat, head_top, refinement.head_layers);
        let head = self.part(format!("head_{number}"), |builder| {
            builder.extrude(&hardware.head, &head_levels, place, |node, level| {
                (level == 0 && node < shank_nodes).then(|| shank_top[node])
            })
        });
        let head_washer = self.part(format!("head_washer_{number}"), |builder| {
            let levels = layers(face, seat, refinement.washer_layers);
            builder.extrude(&hardware.washer, &levels, place, |node, level| {
                (level == refinement.washer_layers && node < seat_nodes).then(|| head[0][shank_nodes + node])
            })
        });
        let nut = self.part(format!("nut_{number}"), |builder| {
            builder.extrude(&hardware.nut, &nut_levels, place, |_, _| None)
        });
        let nut_washer = self.part(format!("nut_washer_{number}"), |builder| {
            let levels = layers(-seat, -face, refinement.washer_layers);
            let nut_face = &nut[refinement.head_layers];
            builder.extrude(&hardware.washer, &levels, place, |node, level| {
                (level == 0 && node < seat_nodes).then(|| nut_face[sectors + node])
            })
        });

        let facing_nut = &shank[refinement.tip_layers..=refinement.tip_layers + refinement.head_layers];
        Fastener {
            number,
            x,
            head_washer_face: head_washer[0].clone(),
            nut_washer_face: nut_washer[refinement.washer_layers].clone(),
            // The shank's surface is its section's last ring, the bore is the nut's first.
            shank_surface: facing_nut
                .iter()
                .map(|layer| layer[shank_nodes - sectors..].to_vec())
                .collect(),
            nut_bore: nut.iter().map(|layer| layer[..sectors].to_vec()).collect(),
        }
    }
}

/// Refuses elements that are inverted or degenerate anywhere that a quadrature or a nodal average may look.
fn check(mesh: &Mesh, parts: &[Part]) -> Result<()> {
    for part in parts {
        for element in part.elements.clone() {
            let determinant = quality::least_jacobian_determinant(mesh, &mesh.elements[element]);
            if determinant <= 0.0 || determinant.is_nan() {
                return Err(Error::InvertedElement {
                    part: part.name.clone(),
                    element,
                    determinant,
                });
            }
        }
    }
    Ok(())
}

impl Fastener {
    /// Ties the washers to the half-beams' outer faces (top, bottom), couples nut and shank, and adds the bolt's
    /// load.
    fn connect(self, geometry: &Geometry, faces: [&[[u32; 4]]; 2], bolt_tension: f64, assembly: &mut Assembly) {
        let number = self.number;
        for (washer, slave_nodes, faces) in [
            ("head", self.head_washer_face, faces[0]),
            ("nut", self.nut_washer_face, faces[1]),
        ] {
            assembly.ties.push(Tie {
                name: format!("{washer}_washer_{number}"),
                slave_nodes,
                master_faces: faces.iter().copied().map(Face::quad4).collect(),
                position_tolerance: TIE_TOLERANCE * geometry.washer_thickness,
                beyond: BeyondTolerance::Refuse,
                adjust: true,
            });
        }

        let middle = -0.5 * (geometry.height + geometry.nut_height) - geometry.washer_thickness;
        let shank = assembly.couplings.len() as u32;
        let nut = shank + 1;
        for (part, layers) in [("shank", self.shank_surface), ("nut", self.nut_bore)] {
            let last = layers.len() - 1;
            // Tributary areas: all sectors and layers are alike, so the end layers have half the area of the others.
            let weights = layers
                .iter()
                .enumerate()
                .flat_map(|(i, layer)| vec![if i == 0 || i == last { 0.5 } else { 1.0 }; layer.len()])
                .collect();
            assembly.couplings.push(Coupling {
                name: format!("{part}_{number}"),
                reference: [self.x, 0.0, middle],
                nodes: layers.concat(),
                kind: CouplingKind::Distributing(weights),
            });
        }
        // All but the displacement along the bolt (component 2).
        for component in [0, 1, 3, 4, 5] {
            assembly.equations.push(Equation {
                name: format!(
                    "bolt_{number}_{}",
                    ["ux", "uy", "uz", "rx", "ry", "rz"][usize::from(component)]
                ),
                terms: vec![
                    (Dof::Reference(shank, component), 1.0),
                    (Dof::Reference(nut, component), -1.0),
                ],
            });
        }
        // Tension pulls the shank out of the head's side, downwards, and the nut against its washer.
        assembly.loads.push(LoadPattern {
            name: format!("bolt_load_{number}"),
            terms: vec![
                (Dof::Reference(shank, 2), -bolt_tension),
                (Dof::Reference(nut, 2), bolt_tension),
            ],
        });
    }
}

/// Section coordinates are (y, z) and levels are x: a rotation, so no element is mirrored.
fn along_x(point: [f64; 2], x: f64) -> [f64; 3] {
    [x, point[0], point[1]]
}

/// Distances from 0 to `length` in `layers` steps, the first being `first` and each next one larger or smaller by
/// the same ratio, which is chosen so that they fill the length.
fn graded(place: &'static str, first: f64, length: f64, layers: usize) -> Result<Vec<f64>> {
    let sum = |ratio: f64| (1..layers).fold(1.0, |sum, _| 1.0 + ratio * sum);
    let wanted = length / first;
    let (least, greatest) = (1.0 / GREATEST_GRADING, GREATEST_GRADING);
    // A single layer has no ratio to choose.
    if layers > 1 && !(sum(least) <= wanted && wanted <= sum(greatest)) {
        return Err(Error::Grading {
            place,
            layers,
            first,
            length,
            least,
            greatest,
        });
    }
    let (mut low, mut high) = (least, greatest);
    // The sum increases with the ratio; bisection halves the bracket down to rounding.
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (low + high);
        if sum(middle) < wanted {
            low = middle
        } else {
            high = middle
        }
    }
    let ratio = 0.5 * (low + high);
    let mut steps = vec![0.0];
    let mut step = 1.0;
    for i in 0..layers {
        steps.push(steps[i] + step);
        step *= ratio;
    }
    // Rounding is spread over all of them, so that the last one is the length exactly.
    let total = steps[layers];
    Ok(steps
        .into_iter()
        .map(|s| if s == total { length } else { s / total * length })
        .collect())
}
