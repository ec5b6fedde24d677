//! Bolts, analyses and outputs of a scene.

use super::tightening::Tightening;
use super::torque::ThreadSize;
use super::units::{Force, Length, Torque};
use cqsma_solver::cqsma::Commit;
use serde::{Deserialize, Serialize};

/// Methods beside CQSMA.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Loops with the contact linearised about the static state (eqs. 34-36).
    Qsma,
    /// The same with the contact as it is instead of linearised, beside the normal stiffness that linearising it gave: the
    /// mistake that the method paper warns of, to see how much too stiff it makes a joint.
    QsmaTwice,
    /// Masing's rule on one initial loading curve.
    Masing,
    /// Rayleigh-quotient nonlinear modal analysis, with Masing's rule.
    Rqnma,
    /// Free periodic motions by the extended periodic motion concept, in harmonic balance.
    Epmc,
}

impl Method {
    /// Name as used in scenes and outputs.
    pub fn name(self) -> &'static str {
        match self {
            Method::Qsma => "qsma",
            Method::QsmaTwice => "qsma-twice",
            Method::Masing => "masing",
            Method::Rqnma => "rqnma",
            Method::Epmc => "epmc",
        }
    }
}

/// Bolts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Bolts {
    /// Tension of each bolt (force); where a file gives a torque, the one that follows from it.
    pub load: Force,
    /// In its place, the tension of each bolt in the order of the structure's bolts (force).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loads: Vec<Force>,
    /// In the place of both, the torque that each bolt is tightened with (torque).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<Torque>,
    /// In its place, the torque of each bolt in the order of the structure's bolts (torque).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub torques: Vec<Torque>,
    /// Size of the thread, such as `"M8"` or `"M10x1.25"`, with a hexagon head; by default that of `structure.mesh.bolts`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<String>,
    /// In its place, the thread.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thread: Option<ThreadSize>,
    /// Coefficient of friction in the thread while it is tightened (-).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thread_friction: Option<f64>,
    /// Coefficient of friction below the head or nut that turns (-).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub head_friction: Option<f64>,
    /// Inner and outer diameter of the face that turns (length); by default clearance hole and face below the head of the size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bearing_diameters: Option<[Length; 2]>,
    /// In which order the bolts are tightened; by default all at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tightening: Option<Tightening>,
    /// What the bolts do in vibration.
    #[serde(default)]
    pub behaviour: BoltBehaviour,
    /// Whether the faces have friction while the bolts are tightened.
    #[serde(default)]
    pub assembly: Assembly,
}

/// What bolts do once they are tightened to their load. The prestress is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum BoltBehaviour {
    /// Constant opposite forces on bolt and nut at all times, as in the method paper: their tension never changes, and
    /// their axial stiffness does not act.
    #[default]
    DeadLoad,
    /// The axial motion of bolt and nut relative to one another is locked in the prestressed state, as by the thread of
    /// a tightened nut: tension changes in vibration, and the bolts' axial stiffness acts.
    Locked,
}

/// Whether the faces have friction while the bolts are tightened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Assembly {
    /// That of the scene.
    #[default]
    WithFriction,
    /// None: no tangential traction is there before the structure vibrates.
    Frictionless,
}

/// A place on the interface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    untagged,
    expecting = "a place [x, y, z] in the coordinates of the model, or [x, y] in the plane of an interface whose place is not known"
)]
pub enum InterfacePlace {
    /// In the coordinates of the model (length).
    Model([Length; 3]),
    /// In the plane of the interface, where its place in the model is not known (length).
    Plane([Length; 2]),
}

/// Settings of the analysis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Cqsma {
    /// Mode followed, counted from 1. Not together with `modes_of_interest`.
    pub mode: usize,
    /// Modes followed where it is more than one, each with a backbone of its own about the same prestress.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub modes_of_interest: Vec<usize>,
    /// Linearised modes computed.
    pub modes: usize,
    /// Smallest displacement at the response point, by linear estimate (length).
    pub amplitude_from: Length,
    /// Largest displacement at the response point, by linear estimate (length).
    pub amplitude_to: Length,
    /// Amplitudes, spaced in log; 0 for prestress and linearised modes alone.
    pub amplitudes: usize,
    /// Vertices per quarter loop.
    pub vertices_per_quarter: usize,
    /// Cycles walked, the last of which is measured; by default as many as it takes until the loop closes.
    pub cycles: Option<usize>,
    /// Distance between the ends of a loop, relative to the motion there (energy norm), at which it counts as closed;
    /// 1e-4 by default. Not together with `cycles`.
    pub until_closed: Option<f64>,
    /// When the friction history is committed.
    pub commit: Commit,
    /// Residual relative to the load, in the energy norm.
    pub tolerance: f64,
    /// Places on the interface (length). The hysteresis loops of the elements there are written as a table, at the amplitudes whose
    /// fields are stored.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub loops_at: Vec<InterfacePlace>,
}

impl Default for Cqsma {
    fn default() -> Self {
        Self {
            mode: 1,
            modes_of_interest: Vec::new(),
            modes: 10,
            amplitude_from: Length::from_si(1e-7),
            amplitude_to: Length::from_si(1e-3),
            amplitudes: 20,
            vertices_per_quarter: 8,
            cycles: None,
            until_closed: None,
            commit: Commit::AtEveryVertex,
            tolerance: 1e-9,
            loops_at: Vec::new(),
        }
    }
}

impl Cqsma {
    /// The modes followed, counted from 1, in the scene's order.
    pub fn followed(&self) -> &[usize] {
        match self.modes_of_interest.as_slice() {
            [] => std::slice::from_ref(&self.mode),
            several => several,
        }
    }
}

/// Stored fields.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Output {
    /// Numbers of the amplitudes (from 1) whose interface fields are stored; by default the first, the last and two
    /// between. The prestress is always stored.
    pub fields_at: Option<Vec<usize>>,
    /// Whether the bodies are written deformed beside the interface, under the bolt loads and at these amplitudes. The structure is factored
    /// a second time for it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub deformed: bool,
}
