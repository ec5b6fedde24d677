//! The joint as results show it.

use crate::Error;
use joint_model::MovedPairs;
use joint_model::quadratic::RaisedElements;
use joints::structure::{OuterSurface, Overview, Structure};
use scenes::Scene;
use zte_assembly::InterfaceMesh;

/// The joint of a scene without its matrices: where the interface lies, what the bodies look like, and what all was made from.
#[derive(Clone, Debug)]
pub struct JointInfo {
    /// What was computed with.
    pub overview: Overview,
    /// The interface mesh.
    pub mesh: InterfaceMesh,
    /// Unit vectors of the relative coordinates as rows, see [`Joint::frame`](joint_model::Joint::frame).
    pub frame: [[f64; 3]; 3],
    /// The same at each interface node, see [`Joint::node_frames`](joint_model::Joint::node_frames).
    pub node_frames: Vec<[[f64; 3]; 3]>,
    /// Position of each interface node in the coordinates of the model (m), where it is known.
    pub positions: Option<Vec<[f64; 3]>>,
    /// The bodies from outside; none of matrices.
    pub surface: Option<OuterSurface>,
    /// Room of a bolt in its hole, from the middle to either side (m), where it is known.
    pub clearance: Option<f64>,
    /// Where and in which direction amplitudes are measured, in words.
    pub response: String,
    /// Pairs of interface nodes that were moved.
    pub moved_pairs: Option<MovedPairs>,
    /// Linear elements that were made quadratic.
    pub raised: Option<RaisedElements>,
}

impl JointInfo {
    pub(super) fn of(scene: &Scene, structure: &Structure) -> Result<Self, Error> {
        let joint = &structure.joint;
        Ok(Self {
            overview: structure.overview(scene)?,
            mesh: structure.interface().clone(),
            frame: joint.frame,
            node_frames: joint.node_frames.clone(),
            positions: joint.positions.clone(),
            surface: OuterSurface::of(joint),
            clearance: joint.clearance,
            response: joint.response.clone(),
            moved_pairs: joint.moved_pairs(),
            raised: joint.raised(),
        })
    }
}
