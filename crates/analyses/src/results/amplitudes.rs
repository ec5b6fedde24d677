//! An amplitude of a backbone as programs read it.

use crate::amplitude::ConnectionLoop;
use crate::dials::AmplitudeError;
use serde::{Deserialize, Serialize};

/// What came of an amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// All vertices converged, and the damping is larger than the noise.
    Resolved,
    /// All vertices converged, but what was found of damping may be noise.
    BelowFloor,
    /// The load is within the round-off of the contact forces: there is neither frequency nor damping.
    BelowRoundOff,
    /// Bolts of constant tension cannot hold the halves against the inertia of the mode at this force
    /// ([`crate::validity::Validity::separation_modal_force`]).
    NoEquilibrium,
    /// A vertex did not converge.
    NotConverged,
}

/// What the loop of an amplitude did at one of several interfaces.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JointSummary {
    /// Name of the interface.
    pub name: String,
    /// Share of its area that slips at the positive peak.
    pub slip_fraction: f64,
    /// Share of its area that is not open there.
    pub contact_area_fraction: f64,
    /// Dissipation per cycle (J).
    pub dissipation: f64,
    /// Share of the dissipation of all interfaces; `null` where these dissipate nothing.
    pub dissipation_share: Option<f64>,
}

/// One amplitude; `null` where the loop did not converge.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BackboneSummary {
    /// What came of it.
    pub status: Status,
    /// Peak modal force (sqrt(kg) m/s^2).
    pub modal_force: f64,
    /// Modal amplitude (sqrt(kg) m): half the range of the modal coordinate.
    pub modal_amplitude: Option<f64>,
    /// Secant frequency (Hz).
    pub frequency_hz: Option<f64>,
    /// Frequency of the first harmonic of the modal force in a sinusoidal motion (Hz): closer to a free oscillation's.
    #[serde(default)]
    pub frequency_first_harmonic_hz: Option<f64>,
    /// Secant frequencies of the halves of positive and of negative modal force (Hz), from the static state.
    pub half_frequencies_hz: Option<[f64; 2]>,
    /// Total damping ratio, friction plus background; `null` below the floor.
    pub damping_ratio: Option<f64>,
    /// Part of it due to friction; `null` below the floor.
    pub friction_damping_ratio: Option<f64>,
    /// Total damping ratio with the frequency of the first harmonic in the place of the secant one; `null` below the floor.
    #[serde(default)]
    pub damping_ratio_first_harmonic: Option<f64>,
    /// What residuals, an open loop, and with commits at reversals points that do not slip, may make of the friction part.
    pub damping_floor: Option<f64>,
    /// Dissipation per cycle summed over the points (J).
    pub dissipation: Option<f64>,
    /// The same from the modal loop (J).
    pub loop_area: Option<f64>,
    /// The same from every second vertex of the loop (J); `null` if there are too few.
    pub coarse_loop_area: Option<f64>,
    /// Acceleration amplitude at the response point by the linearised mode (m/s^2).
    pub response_acceleration: Option<f64>,
    /// Displacement amplitude at the response point by the linearised mode, modal amplitude times mode shape (m).
    pub response_displacement: Option<f64>,
    /// Displacement amplitude at the response point as it moved: half its range over the loop (m).
    #[serde(default)]
    pub response_motion: Option<f64>,
    /// Area fraction slipping at the positive peak.
    pub slip_fraction: Option<f64>,
    /// Area fraction open there.
    pub open_fraction: Option<f64>,
    /// What each interface did, where there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<JointSummary>,
    /// What each connection did, in the order of the summary's; missing in older summaries.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub connections: Vec<ConnectionLoop>,
    /// Equilibria found, all cycles together.
    pub load_points: usize,
    /// Newton iterations of the whole loop.
    pub iterations: usize,
    /// Evaluations of the interface.
    pub evaluations: usize,
    /// Preconditioned Krylov steps.
    pub krylov_steps: usize,
    /// Direct factorisations.
    pub factorisations: usize,
    /// Part of the peak motion that is mass-orthogonal to the mode.
    pub shape_deviation: Option<f64>,
    /// Cycles computed, the measured one included.
    pub cycles: Option<usize>,
    /// Vertices per quarter of the measured loop: those of the scene, or more where these did not resolve the damping.
    #[serde(default)]
    pub vertices_per_quarter: Option<usize>,
    /// Whether the measured loop was computed one way only, because the cycle before it dissipated nothing and
    /// nothing slips or opens on the way.
    #[serde(default)]
    pub one_way: Option<bool>,
    /// Whether the loop closed; `null` for a fixed number of cycles.
    pub closed: Option<bool>,
    /// Distance between the ends of the measured loop relative to the motion there (energy norm): what points under low
    /// pressure creep on in a cycle counts, also where force and amplitude close.
    pub loop_closure: Option<f64>,
    /// Largest residual of a vertex relative to the peak load (energy norm).
    pub residual: Option<f64>,
    /// Error of frequency and damping by numerical settings; left out where it is not estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<AmplitudeError>,
    /// Whether all vertices converged.
    pub converged: bool,
    /// If not: why.
    pub failure: Option<String>,
}
