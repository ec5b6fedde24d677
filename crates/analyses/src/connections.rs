//! What the surroundings of each bolt do as one connection: the common motion of the bodies and the force between them, as elements of one
//! degree of freedom in other programs have them.

use super::amplitude::{ConnectionLoop, Fields};
use cqsma_solver::hysteresis::Loop;
use finite_elements::mesh::{Assembly, Dof, LoadPattern};
use joint_model::{Bodies, Joint};
use nalgebra::{Matrix2, Vector3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use zte_assembly::{Operators, Workspace};

/// The part of an interface that is nearest to a bolt; the whole interface where no bolt has a known place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Connection {
    /// Name of the interface, where there are several, and number of the bolt.
    pub name: String,
    /// Centre of its area (m).
    pub position: [f64; 3],
    /// Unit vectors as rows: two in the interface, and the normal from the top body into the bottom one; the mean ones of a curved interface.
    pub frame: [[f64; 3]; 3],
    /// Area (m^2).
    pub area: f64,
    /// Its quadrature points.
    #[serde(skip)]
    pub(crate) points: Vec<usize>,
}

/// The place of a bolt: the mean of what its load acts on.
fn place(assembly: &Assembly, load: &LoadPattern) -> Option<[f64; 3]> {
    let reference = |coupling: u32| assembly.couplings.get(coupling as usize).map(|of| of.reference);
    let node = |node: u32| assembly.mesh.nodes.get(node as usize).copied();
    let mut places: Vec<[f64; 3]> = Vec::new();
    for (dof, _) in &load.terms {
        match *dof {
            Dof::Node(number, _) => places.extend(node(number)),
            Dof::Reference(coupling, _) => places.extend(reference(coupling)),
            Dof::Pretension(number) => match assembly.shanks.get(number as usize) {
                Some(shank) => places.extend(shank.ends.iter().filter_map(|end| reference(*end))),
                None => {
                    let cut = assembly.cuts.get(number as usize - assembly.shanks.len())?;
                    places.extend(cut.pairs.iter().flatten().filter_map(|number| node(*number)));
                }
            },
        }
    }
    let count = places.len() as f64;
    (count > 0.0).then(|| [0, 1, 2].map(|c| places.iter().map(|place| place[c]).sum::<f64>() / count))
}

/// The mean of what each node has, at each point.
fn at_points<const N: usize>(operators: &Operators, of_nodes: impl Fn(usize) -> [f64; N]) -> Vec<[f64; N]> {
    let rows = operators.interpolation.outer_iterator();
    let at = rows.map(|row| {
        let mut at = [0.0; N];
        for (node, weight) in row.iter() {
            at.iter_mut()
                .zip(of_nodes(node))
                .for_each(|(at, value)| *at += weight * value);
        }
        at
    });
    at.collect()
}

/// Positions of the quadrature points in the coordinates of the model (m), from those of the nodes.
pub fn point_positions(operators: &Operators, nodes: &[[f64; 3]]) -> Vec<[f64; 3]> {
    at_points(operators, |node| nodes[node])
}

impl Connection {
    /// The connections of a joint, by interface and bolt; none where the nodes of the interface have no known place.
    pub(crate) fn all(joint: &Joint, operators: &Operators) -> Vec<Self> {
        let Some(nodes) = &joint.positions else {
            return Vec::new();
        };
        let positions = point_positions(operators, nodes);
        let frames = at_points(operators, |node| {
            let frame = joint.node_frames.get(node).unwrap_or(&joint.frame);
            std::array::from_fn::<f64, 9, _>(|k| frame[k / 3][k % 3])
        });
        let bolts: Vec<[f64; 3]> = match &joint.bodies {
            Bodies::Meshed(bodies) => {
                let loads = &bodies.assembly.loads;
                loads.iter().filter_map(|load| place(&bodies.assembly, load)).collect()
            }
            Bodies::Imported(_) => Vec::new(),
        };
        let mut groups: BTreeMap<(usize, Option<usize>), Vec<usize>> = BTreeMap::new();
        for (element, ends) in operators.first_point.windows(2).enumerate() {
            let part = joint.parts.iter().position(|part| part.elements.contains(&element));
            for point in ends[0]..ends[1] {
                let distance =
                    |bolt: &[f64; 3]| (Vector3::from(*bolt) - Vector3::from(positions[point])).norm_squared();
                let nearest = (0..bolts.len()).min_by(|a, b| distance(&bolts[*a]).total_cmp(&distance(&bolts[*b])));
                groups.entry((part.unwrap_or(0), nearest)).or_default().push(point);
            }
        }
        let connection = |((part, bolt), points): ((usize, Option<usize>), Vec<usize>)| {
            let weights = &operators.weights;
            let area: f64 = points.iter().map(|&p| weights[p]).sum();
            let mean = |value: &dyn Fn(usize) -> [f64; 3]| {
                let sum = points
                    .iter()
                    .map(|&p| weights[p] * Vector3::from(value(p)))
                    .sum::<Vector3<f64>>();
                sum / area
            };
            // The mean of directions, made orthonormal from the normal on.
            let row = |r: usize| mean(&|p| [frames[p][3 * r], frames[p][3 * r + 1], frames[p][3 * r + 2]]);
            let normal = row(2).normalize();
            let along = row(0);
            let along = (along - along.dot(&normal) * normal).normalize();
            // The second is to the side where the frame of the interface has it.
            let across = normal.cross(&along);
            let across = across * across.dot(&row(1)).signum();
            let part = joint
                .parts
                .get(part)
                .map(|part| part.name.clone())
                .filter(|_| joint.parts.len() > 1);
            let bolt = bolt.map(|bolt| format!("bolt {}", bolt + 1));
            let names: Vec<String> = part.into_iter().chain(bolt).collect();
            Self {
                name: if names.is_empty() {
                    "interface".into()
                } else {
                    names.join(", ")
                },
                position: mean(&|p| positions[p]).into(),
                frame: [along.into(), across.into(), normal.into()],
                area,
                points,
            }
        };
        groups.into_iter().map(connection).collect()
    }
}

/// Motions and forces of connections along a loop.
pub(crate) struct Walked<'a> {
    connections: &'a [Connection],
    /// Mean tangential jump (m) and tangential force (N) of each connection, vertex by vertex.
    vertices: Vec<Vec<[[f64; 2]; 2]>>,
    /// Of each connection at the positive peak.
    coherence: Vec<f64>,
}

impl<'a> Walked<'a> {
    pub(crate) fn new(connections: &'a [Connection]) -> Self {
        Self {
            connections,
            vertices: vec![Vec::new(); connections.len()],
            coherence: vec![0.0; connections.len()],
        }
    }

    pub(crate) fn vertex(&mut self, weights: &[f64], workspace: &Workspace) {
        for (connection, vertices) in self.connections.iter().zip(&mut self.vertices) {
            let sum = |of: &[f64]| connection.points.iter().map(|&p| weights[p] * of[p]).sum::<f64>();
            let motion = [0, 1].map(|c| sum(&workspace.jump[c]) / connection.area);
            vertices.push([motion, [0, 1].map(|c| sum(&workspace.traction[c]))]);
        }
    }

    pub(crate) fn peak(&mut self, weights: &[f64], workspace: &Workspace, prestress: &Fields) {
        for (connection, coherence) in self.connections.iter().zip(&mut self.coherence) {
            let (mut mean, mut square) = ([0.0; 2], 0.0);
            for &p in &connection.points {
                for (c, mean) in mean.iter_mut().enumerate() {
                    let motion = workspace.jump[c][p] - prestress.jump[c][p];
                    *mean += weights[p] * motion / connection.area;
                    square += weights[p] * motion * motion / connection.area;
                }
            }
            *coherence = if square > 0.0 {
                mean[0].hypot(mean[1]) / square.sqrt()
            } else {
                0.0
            };
        }
    }

    /// What came of a loop that dissipated `flux` (J/m^2) at the points.
    pub(crate) fn close(&self, weights: &[f64], flux: &[Vec<f64>; 3]) -> Vec<ConnectionLoop> {
        let all = self.connections.iter().zip(&self.vertices).zip(&self.coherence);
        let closed = all.map(|((connection, vertices), coherence)| {
            let angle = widest(vertices);
            let [x, y] = [angle.cos(), angle.sin()];
            let [along, across, _] = connection.frame;
            // With a sign that does not hang on round-off: the largest component is positive.
            let direction = [0, 1, 2].map(|c| x * along[c] + y * across[c]);
            let largest = direction
                .iter()
                .fold(0.0, |most: f64, v| if v.abs() > most.abs() + 1e-9 { *v } else { most });
            let sign = if largest < 0.0 { -1.0 } else { 1.0 };
            let path: Vec<[f64; 2]> = vertices
                .iter()
                .map(|of| of.map(|[a, b]| sign * (x * a + y * b)))
                .collect();
            let half_range = |which: usize| {
                let ends = path
                    .iter()
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high]: [f64; 2], at| {
                        [low.min(at[which]), high.max(at[which])]
                    });
                0.5 * (ends[1] - ends[0])
            };
            let (amplitude, force) = path.iter().map(|at| (at[0], at[1])).unzip();
            let energy = |p: &usize| weights[*p] * flux.iter().map(|flux| flux[*p]).sum::<f64>();
            ConnectionLoop {
                direction: direction.map(|v| sign * v),
                displacement: half_range(0),
                force: half_range(1),
                loop_area: Loop { force, amplitude }.area(),
                dissipation: connection.points.iter().map(energy).sum(),
                coherence: *coherence,
            }
        });
        closed.collect()
    }
}

/// Angle in the interface of the direction in which the motion varies most over a loop (rad).
fn widest(vertices: &[[[f64; 2]; 2]]) -> f64 {
    let count = vertices.len().max(1) as f64;
    let mean = [0, 1].map(|c| vertices.iter().map(|of| of[0][c]).sum::<f64>() / count);
    let mut spread = Matrix2::zeros();
    for [motion, _] in vertices {
        let from = [0, 1].map(|c| motion[c] - mean[c]);
        spread += Matrix2::from_fn(|i, j| from[i] * from[j]);
    }
    0.5 * (2.0 * spread[(0, 1)]).atan2(spread[(0, 0)] - spread[(1, 1)])
}
