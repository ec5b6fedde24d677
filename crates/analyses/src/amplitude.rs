//! What is found at one amplitude.

use super::dials::{AmplitudeError, Dial, DialError};
use super::element_loops::ElementLoops;
use contact_laws::Regime;
use cqsma_solver::BackbonePoint;
use serde::{Deserialize, Serialize};

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

/// What the loop of one amplitude did at one of several interfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointLoop {
    /// Share of its area that slips at the positive peak.
    pub slip_fraction: f64,
    /// Share that is open there.
    pub open_fraction: f64,
    /// Dissipation per cycle (J).
    pub dissipation: f64,
}

/// What a connection did over the loop of an amplitude. With the mean tangential motion `s` of the top body against the bottom one over the area, and
/// the tangential force `F` between them along the direction in which `s` varies most.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ConnectionLoop {
    /// The direction, in the coordinates of the model.
    pub direction: [f64; 3],
    /// Half the range of `s` (m).
    pub displacement: f64,
    /// Half the range of `F` (N).
    pub force: f64,
    /// Closed integral of `F` over `s` (J).
    pub loop_area: f64,
    /// Dissipation per cycle over the area (J), of which the loop area is the part that moves in common.
    pub dissipation: f64,
    /// Magnitude of `s` at the positive peak, from the static state, over the root mean square of the tangential motion: one where all points
    /// move alike, less where they turn or stretch.
    pub coherence: f64,
}

/// What the loop of one amplitude did at each interface element, as means over its area.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ElementMotions {
    /// Energy dissipated per area and cycle (J/m^2).
    pub dissipation: Vec<f64>,
    /// Largest tangential motion from the prestress (m).
    pub sliding: Vec<f64>,
    /// Largest change of the tangential traction from the prestress (Pa).
    pub traction: Vec<f64>,
}

/// What the loop of one amplitude did at the interface.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LoopFields {
    /// Area fraction that slips at the positive peak.
    pub slip_fraction: f64,
    /// Area fraction that is open there.
    pub open_fraction: f64,
    /// The same of each interface, where there are several.
    #[serde(default)]
    pub joints: Vec<JointLoop>,
    /// What each connection did, in the order of the run's.
    pub connections: Vec<ConnectionLoop>,
    /// Dissipation per cycle from the points' loops (J) (eq. 43).
    pub dissipation: f64,
    /// Largest tangential motion from the prestress over the loop (m).
    pub largest_sliding: f64,
    /// What each element did; none where no random vibration is asked for.
    pub elements: Option<ElementMotions>,
    /// Half the range of the displacement at the response point over the loop (m); it differs from `q phi` by what moves
    /// outside the linearised mode.
    pub response_motion: f64,
    /// Fields at the positive peak, for the amplitudes asked for.
    pub fields: Option<Fields>,
    /// Coordinates of the reduced structure that vibrates at the positive peak, jumps (m) first: where the bodies are to be shown deformed, and at
    /// all amplitudes where the error of their mesh is to be estimated.
    pub displacement: Option<Vec<f64>>,
    /// The loops of the elements, for the same amplitudes; none where no element is recorded.
    pub loops: Option<ElementLoops>,
    /// Errors of the settings of the law and of the vertices; empty where they are not estimated.
    pub errors: Vec<(Dial, DialError)>,
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
    /// Its error by numerical settings, where it is estimated.
    pub error: Option<AmplitudeError>,
}
