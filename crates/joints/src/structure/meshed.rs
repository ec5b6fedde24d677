//! Matrices of bodies of finite elements, and the same with the jump as coordinates.

use crate::Error;
use finite_elements::assemble::System;
use finite_elements::mesh::Dof;
use joint_model::{Excited, Joint, MeshedBodies, Sides};
use reduction::{FacingNodes, InterfacePairs, RelativeSystem};
use sprs::CsMat;
use std::borrow::Cow;

/// Matrices of bodies of finite elements.
pub(super) struct Meshed {
    pub(super) system: System,
    pub(super) relative: RelativeSystem,
}

impl Meshed {
    /// The system of bodies of finite elements, and the same in relative coordinates.
    pub(super) fn try_new(joint: &Joint, bodies: &MeshedBodies) -> Result<Self, Error> {
        let system = System::try_new(&bodies.assembly)?;
        let relative = relative(joint, &system, &bodies.sides)?;
        Ok(Self { system, relative })
    }

    /// What is recovered from reduced coordinates, over those of the relative system.
    pub(super) fn rows(&self, bodies: &MeshedBodies) -> Result<Vec<Vec<f64>>, Error> {
        let row = |what, (node, direction): (u32, [f64; 3])| -> Result<Vec<f64>, Error> {
            let terms: Vec<_> = (0..3_u8).zip(direction).map(|(c, d)| (Dof::Node(node, c), d)).collect();
            Ok(self
                .relative
                .row(&self.system.dofs.force(&bodies.assembly, what, &terms)?))
        };
        let mut rows = vec![row("the response", (bodies.response_node, bodies.response_direction))?];
        for excited in &bodies.excitations {
            rows.push(match *excited {
                Excited::Force { node, direction } => row("the force", (node, direction))?,
                Excited::Base(direction) => {
                    let mut momentum = vec![0.0; self.system.n_dofs()];
                    for (along, share) in self.system.momenta.iter().zip(direction) {
                        momentum.iter_mut().zip(along).for_each(|(sum, m)| *sum += share * m);
                    }
                    self.relative.row(&momentum)
                }
            });
        }
        Ok(rows)
    }
}

/// The system with the jump as coordinates.
pub(super) fn relative(joint: &Joint, system: &System, sides: &Sides) -> Result<RelativeSystem, Error> {
    let frame = joint.frame;
    let node_frames = match joint.node_frames.is_empty() {
        true => Cow::Owned(vec![frame; joint.interface.nodes.len()]),
        false => Cow::Borrowed(&joint.node_frames),
    };
    Ok(match sides {
        Sides::Pairs { top, bottom } if joint.node_frames.is_empty() => {
            RelativeSystem::try_new(system, InterfacePairs { top, bottom, frame })?
        }
        Sides::Pairs { top, bottom } => {
            let projection = CsMat::eye(top.len());
            let side = FacingNodes {
                own: top,
                own_is_top: true,
                other: bottom,
                projection: &projection,
                frames: &node_frames,
            };
            RelativeSystem::from_facing(system, &[side])?
        }
        Sides::Projected(parts) => {
            let mut first = 0;
            let facing = parts.iter().map(|part| {
                let frames = first..first + part.own.len();
                first = frames.end;
                FacingNodes {
                    own: &part.own,
                    own_is_top: part.own_is_top,
                    other: &part.other,
                    projection: &part.projection,
                    frames: &node_frames[frames],
                }
            });
            RelativeSystem::from_facing(system, &facing.collect::<Vec<_>>())?
        }
    })
}
