//! What a run finds.

use super::adaptation::Adaptation;
use super::amplitude::AmplitudeResult;
use super::comparison::Experiment;
use super::connections::Connection;
use super::deformed::Deformed;
use super::error_bar::ErrorBar;
use super::joint_info::JointInfo;
use super::mode_backbone::ModeBackbone;
use super::outcome::Vibration;
use super::prestress::PrestressResult;
use super::tightening::TighteningResult;
use super::validity::Validity;
use super::warnings::Warning;
use faer::Mat;
use joints::interface::{LawReport, PartReport};
use joints::store::checkpoint::Checkpoints;
use joints::structure::StructuralModel;
use scenes::Scene;
use zte_assembly::Interface;

/// A finished run.
#[derive(Debug)]
pub struct Run {
    /// The scene, in SI.
    pub scene: Scene,
    /// The joint.
    pub joint: JointInfo,
    /// The structure, reduced.
    pub model: StructuralModel,
    /// The interface with its law.
    pub interface: Interface,
    /// About the law of each part of the interface; never empty.
    pub parts: Vec<PartReport>,
    /// Points whose gap was set from a negative value to zero.
    pub clipped_gaps: usize,
    /// Static state.
    pub prestress: PrestressResult,
    /// How the bolts came to it, where they are tightened one after the other.
    pub tightening: Option<TighteningResult>,
    /// Linearised frequencies (Hz).
    pub frequencies: Vec<f64>,
    /// Derivatives of their logarithms with respect to those of the stiffness of each interface with everything in contact stuck, mode by mode (-).
    pub by_interface: Vec<Vec<f64>>,
    /// Memory that a product with the stuck structure's flexibility reads (bytes).
    pub flexibility_bytes: usize,
    /// Backbones of the modes followed, in the scene's order; never empty.
    pub backbones: Vec<ModeBackbone>,
    /// What analyses of vibration find beside the backbones.
    pub vibration: Vibration,
    /// The bodies deformed, if the scene asks for them.
    pub deformed: Option<Deformed>,
    /// The error of the mesh, where it was estimated.
    pub estimated_error: Option<ErrorBar>,
    /// How the settings were adapted, where the scene names errors that it bears.
    pub adaptation: Option<Adaptation>,
    /// Interface elements at the places of `analyses.backbone.loops_at`, in their order, each once.
    pub loop_elements: Vec<usize>,
    /// The parts of the interface by bolt.
    pub connections: Vec<Connection>,
    /// Experiment backbones, over displacement.
    pub measured: Vec<Experiment>,
    /// What is implausible in the scene or in the results.
    pub warnings: Vec<Warning>,
    /// Files in the cache that let the run resume. Whoever has put the results in a safe place, or does not want to keep them,
    /// calls [`Checkpoints::remove`].
    pub checkpoints: Checkpoints,
}

impl Run {
    /// About the law of the whole interface, or of its first part.
    pub fn law(&self) -> &LawReport {
        &self.parts[0].law
    }

    /// The backbone of the first mode followed.
    pub fn first(&self) -> &ModeBackbone {
        &self.backbones[0]
    }

    /// Amplitudes of the first mode followed.
    pub fn amplitudes(&self) -> &[AmplitudeResult] {
        &self.first().amplitudes
    }

    /// Limits of the model for the first mode followed.
    pub fn validity(&self) -> &Validity {
        &self.first().validity
    }

    /// Without the reduced matrices, which are most of its memory, and which neither tables nor pictures need.
    #[must_use]
    pub fn without_matrices(mut self) -> Self {
        let reduced = &mut self.model.reduced;
        (reduced.mass, reduced.stiffness, reduced.recovery) = (Mat::new().into(), Mat::new().into(), Mat::new());
        self
    }
}
