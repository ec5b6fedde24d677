//! Bolts of a scene.

use super::units::{Force, Length, Torque};
use serde::{Deserialize, Serialize};

/// Bolts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Bolts {
    /// Tension of each bolt (force), positive; where a file gives a torque, the one that follows from it. 0 by default of matrices whose
    /// contact has a preload.
    pub load: Force,
    /// In its place, the tension of each bolt in the order of the structure's bolts (force).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loads: Vec<Force>,
    /// In the place of both, the torque that each bolt is tightened with (torque); it needs `size` or `thread`, `thread_friction` and
    /// `head_friction`.
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
    /// Coefficient of friction in the thread while it is tightened (-); needed with a torque, a `size` or a `thread`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thread_friction: Option<f64>,
    /// Coefficient of friction below the head or nut that turns (-); needed as the one before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub head_friction: Option<f64>,
    /// Inner and outer diameter of the face that turns (length); by default clearance hole and face below the head of the size;
    /// needed with `thread`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bearing_diameters: Option<[Length; 2]>,
    /// What the bolts do in vibration.
    #[serde(default)]
    pub behaviour: BoltBehaviour,
    /// Whether the faces have friction while the bolts are tightened.
    #[serde(default)]
    pub assembly: Assembly,
}

/// Sizes of a thread.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ThreadSize {
    /// Nominal diameter (length).
    pub diameter: Length,
    /// Pitch (length).
    pub pitch: Length,
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
