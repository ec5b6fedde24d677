//! What the analyses of one interface find.

use super::amplitude::AmplitudeResult;
use super::comparison::Backbone;
use super::methods::MethodResult;
use super::periodic::{EpmcBackbone, ForcedResponse};
use super::prestress::PrestressResult;
use super::ring_down::{self, RingDown};
use super::sensitivities::Sensitivity;
use super::tightening::TighteningResult;
use super::validity::Validity;
use crate::Error;
use joints::store::checkpoint::Checkpoints;

/// The backbone of one mode.
#[derive(Clone, Debug)]
pub struct ModeBackbone {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Amplitudes in ascending order.
    pub amplitudes: Vec<AmplitudeResult>,
    /// Results of the methods beside CQSMA, in the scene's order.
    pub methods: Vec<MethodResult>,
    /// Free periodic motions, if the scene asks for them.
    pub epmc: Option<EpmcBackbone>,
    /// Derivatives with respect to the parameters of the scene's `sensitivities`, in their order.
    pub sensitivities: Vec<Sensitivity>,
    /// Limits of the model.
    pub validity: Validity,
}

impl ModeBackbone {
    /// All backbones over the acceleration at the response point, by name.
    ///
    /// # Errors
    /// [`Error::Comparison`].
    pub fn over_acceleration(&self, background: f64) -> Result<Vec<(String, Backbone)>, Error> {
        ring_down::backbones(&self.amplitudes, &self.methods, self.epmc.as_ref(), background)
    }
}

/// One mode, before its validity is judged.
pub(crate) struct ModeAnalysis {
    pub(crate) mode: usize,
    /// [`Validity::separation_modal_force`].
    pub(crate) separation: Option<f64>,
    pub(crate) amplitudes: Vec<AmplitudeResult>,
    pub(crate) methods: Vec<MethodResult>,
    pub(crate) epmc: Option<EpmcBackbone>,
    pub(crate) sensitivities: Vec<Sensitivity>,
}

/// What the nonlinear solves made of an interface.
pub(crate) struct Analysis {
    pub(crate) prestress: PrestressResult,
    /// How the bolts came to it, where they are tightened one after the other.
    pub(crate) tightening: Option<TighteningResult>,
    /// Linearised frequencies (Hz).
    pub(crate) frequencies: Vec<f64>,
    /// The modes followed, in the scene's order.
    pub(crate) modes: Vec<ModeAnalysis>,
    /// Forced responses, level by level.
    pub(crate) forced: Vec<ForcedResponse>,
    /// The ring-down, or why there is none.
    pub(crate) ring_down: Option<Result<RingDown, Error>>,
    /// What lets the run resume until its results are safe.
    pub(crate) checkpoints: Checkpoints,
}
