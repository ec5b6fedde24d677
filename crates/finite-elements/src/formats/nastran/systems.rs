//! Coordinate systems of nodes.

use super::cards::{Card, Source};
use crate::Error;
use crate::formats::labelled::Labelled;
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;

/// How deep systems may refer to one another.
const DEEPEST: usize = 100;

#[derive(Clone, Copy)]
enum Kind {
    Rectangular,
    Cylindrical,
    Spherical,
}

/// Origin, a point on the third axis, and one in the plane of the first and third: positions in another system, or nodes.
#[derive(Clone, Copy)]
enum Points {
    In(u64, [[f64; 3]; 3]),
    Nodes([u64; 3]),
}

/// A system in the global one.
#[derive(Clone, Copy)]
struct System {
    kind: Kind,
    origin: Vector3<f64>,
    axes: Matrix3<f64>,
}

/// A node as its card gives it.
pub(super) struct Given {
    pub(super) at: u32,
    pub(super) label: u64,
    pub(super) system: u64,
    pub(super) position: [f64; 3],
}

/// All systems of a file.
#[derive(Default)]
pub(super) struct Systems {
    defined: BTreeMap<u64, (u32, Kind, Points)>,
    resolved: BTreeMap<u64, System>,
}

impl Systems {
    /// Takes the cards `CORD1R` to `CORD2S`.
    pub(super) fn define(&mut self, source: &Source, card: &Card<'_>) -> Result<(), Error> {
        let kind = match card.name.as_bytes() {
            [.., b'R'] => Kind::Rectangular,
            [.., b'C'] => Kind::Cylindrical,
            _ => Kind::Spherical,
        };
        let mut add = |label: u64, points: Points| match self.defined.insert(label, (card.at, kind, points)) {
            None if label > 0 => Ok(()),
            _ => Err(source.contents(
                card.at,
                format!("the coordinate system {label} is given twice, or is the global one"),
                "give each system a number of its own",
            )),
        };
        if card.name.starts_with("CORD2") {
            let points = [2, 5, 8].map(|first| card.triple(source, first));
            let [a, b, c] = points;
            return add(
                card.integer(source, 0)?,
                Points::In(card.integer_or_zero(source, 1)?, [a?, b?, c?]),
            );
        }
        // A card may hold two systems.
        for first in [0, 4] {
            if first == 0 || !card.field(first).is_empty() {
                let nodes = [1, 2, 3].map(|place| card.integer(source, first + place));
                let [a, b, c] = nodes;
                add(card.integer(source, first)?, Points::Nodes([a?, b?, c?]))?;
            }
        }
        Ok(())
    }

    /// Adds the nodes, in the global system.
    pub(super) fn place(mut self, source: &Source, given: &[Given], mesh: &mut Labelled) -> Result<(), Error> {
        // Systems that follow nodes need these first.
        let of_nodes: BTreeMap<u64, &Given> = match self
            .defined
            .values()
            .any(|(.., points)| matches!(points, Points::Nodes(_)))
        {
            true => given.iter().map(|node| (node.label, node)).collect(),
            false => BTreeMap::new(),
        };
        let refuse = |at, problem, remedy| source.contents(at, problem, remedy);
        for node in given {
            let position = self.global(source, node, &of_nodes, 0)?;
            mesh.node(node.at, node.label, position.into(), &refuse)?;
        }
        Ok(())
    }

    fn global(
        &mut self,
        source: &Source,
        node: &Given,
        nodes: &BTreeMap<u64, &Given>,
        depth: usize,
    ) -> Result<Vector3<f64>, Error> {
        match node.system {
            0 => Ok(node.position.into()),
            label => Ok(self.system(source, node.at, label, nodes, depth)?.global(node.position)),
        }
    }

    fn system(
        &mut self,
        source: &Source,
        at: u32,
        label: u64,
        nodes: &BTreeMap<u64, &Given>,
        depth: usize,
    ) -> Result<System, Error> {
        if let Some(system) = self.resolved.get(&label) {
            return Ok(*system);
        }
        let Some(&(at, kind, points)) = self.defined.get(&label) else {
            return Err(source.contents(
                at,
                format!("the coordinate system {label} is not in the file"),
                "save the mesh with its coordinate systems, or with all nodes in the global one",
            ));
        };
        if depth > DEEPEST {
            return Err(source.contents(
                at,
                format!("the coordinate system {label} depends on itself, or on more than {DEEPEST} others in a row"),
                "define it in the global one",
            ));
        }
        let [a, b, c] = match points {
            Points::In(reference, points) => {
                let mut found = [Vector3::zeros(); 3];
                for (found, position) in found.iter_mut().zip(points) {
                    let point = Given {
                        at,
                        label: 0,
                        system: reference,
                        position,
                    };
                    *found = self.global(source, &point, nodes, depth + 1)?;
                }
                found
            }
            Points::Nodes(labels) => {
                let mut found = [Vector3::zeros(); 3];
                for (found, label) in found.iter_mut().zip(labels) {
                    let node = nodes.get(&label).ok_or_else(|| {
                        source.contents(
                            at,
                            format!("the node {label} of a coordinate system is not in the file"),
                            "save the mesh with all its nodes",
                        )
                    })?;
                    *found = self.global(source, node, nodes, depth + 1)?;
                }
                found
            }
        };
        let third = (b - a).try_normalize(0.0);
        let first = third.and_then(|third| {
            let in_plane = c - a;
            let across = in_plane - third * third.dot(&in_plane);
            (across.norm() > 1e-9 * in_plane.norm()).then(|| across.normalize())
        });
        let (Some(first), Some(third)) = (first, third) else {
            return Err(source.contents(
                at,
                format!("the three points of the coordinate system {label} lie on one line"),
                "correct the points",
            ));
        };
        let system = System {
            kind,
            origin: a,
            axes: Matrix3::from_columns(&[first, third.cross(&first), third]),
        };
        self.resolved.insert(label, system);
        Ok(system)
    }
}

impl System {
    fn global(&self, x: [f64; 3]) -> Vector3<f64> {
        let local = match self.kind {
            Kind::Rectangular => Vector3::from(x),
            Kind::Cylindrical => {
                let (sine, cosine) = x[1].to_radians().sin_cos();
                Vector3::new(x[0] * cosine, x[0] * sine, x[2])
            }
            // Radius, angle from the third axis, angle about it.
            Kind::Spherical => {
                let ((sine, cosine), (s, c)) = (x[1].to_radians().sin_cos(), x[2].to_radians().sin_cos());
                Vector3::new(x[0] * sine * c, x[0] * sine * s, x[0] * cosine)
            }
        };
        self.origin + self.axes * local
    }
}
