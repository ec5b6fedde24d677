//! What the analyses find.

use super::element_loops::ElementLoops;
use super::methods::MethodResult;
use super::periodic::{EpmcBackbone, ForcedResponse};
use super::sensitivities::Sensitivity;
use super::tightening::TighteningResult;
use contact_laws::Regime;
use cqsma_solver::BackbonePoint;
use cqsma_solver::prestress::Prestress;
use joints::store::checkpoint::Checkpoints;
use serde::{Deserialize, Serialize};
use zte_assembly::State;

/// Quantities at the quadrature points.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Fields {
    /// Jump x, y, interference n (m).
    pub jump: [Vec<f64>; 3],
    /// Traction x, y, n (Pa).
    pub traction: [Vec<f64>; 3],
    /// Regimes.
    pub regime: Vec<Regime>,
    /// Energy dissipated per area and cycle x, y, n (J/m^2); zero for a static state.
    pub flux: [Vec<f64>; 3],
}

/// What the loop of one amplitude did at the interface.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LoopFields {
    /// Area fraction that slips at the positive peak.
    pub slip_fraction: f64,
    /// Area fraction that is open there.
    pub open_fraction: f64,
    /// Dissipation per cycle from the points' loops (J) (eq. 43).
    pub dissipation: f64,
    /// Largest tangential motion from the prestress over the loop (m).
    pub largest_sliding: f64,
    /// Half the range of the displacement at the response point over the loop (m); it differs from `q phi` by what moves
    /// outside the linearised mode.
    pub response_motion: f64,
    /// Fields at the positive peak, for the amplitudes asked for.
    pub fields: Option<Fields>,
    /// Coordinates of the reduced structure that vibrates at the positive peak, if the bodies are to be shown deformed: jumps (m) first.
    pub displacement: Option<Vec<f64>>,
    /// The loops of the elements, for the same amplitudes; none where no element is recorded.
    pub loops: Option<ElementLoops>,
}

/// One amplitude.
#[derive(Clone, Debug)]
pub struct AmplitudeResult {
    /// The loop.
    pub point: BackbonePoint,
    /// What it did at the interface; none if it did not converge.
    pub fields: Option<LoopFields>,
    /// Acceleration amplitude at the response point (m/s^2).
    pub response_acceleration: Option<f64>,
    /// Displacement amplitude at the response point, `q phi` (m).
    pub response_displacement: Option<f64>,
}

/// The static state.
#[derive(Clone, Debug)]
pub struct PrestressResult {
    /// Solver's account.
    pub solution: Prestress<State>,
    /// Sum of the absolute residual forces over the interface relative to that of the loads.
    pub residual_ratio: f64,
    /// Relative difference between the integrated pressure and the bolt loads.
    pub equilibrium_error: f64,
    /// Fields.
    pub fields: Fields,
    /// Tension of each bolt (N).
    pub tensions: Vec<f64>,
    /// How the bolts came to it, where they are tightened one after the other.
    pub tightening: Option<TighteningResult>,
}

/// One mode, before its validity is judged.
pub(crate) struct ModeAnalysis {
    pub(crate) mode: usize,
    /// [`Validity::separation_modal_force`](super::validity::Validity::separation_modal_force).
    pub(crate) separation: Option<f64>,
    pub(crate) amplitudes: Vec<AmplitudeResult>,
    pub(crate) methods: Vec<MethodResult>,
    pub(crate) epmc: Option<EpmcBackbone>,
    pub(crate) sensitivities: Vec<Sensitivity>,
}

/// What the nonlinear solves made of an interface.
pub(crate) struct Analysis {
    pub(crate) prestress: PrestressResult,
    /// Linearised frequencies (Hz).
    pub(crate) frequencies: Vec<f64>,
    /// The modes followed, in the scene's order.
    pub(crate) modes: Vec<ModeAnalysis>,
    /// Forced responses, level by level.
    pub(crate) forced: Vec<ForcedResponse>,
    /// What lets the run resume until its results are safe.
    pub(crate) checkpoints: Checkpoints,
}
