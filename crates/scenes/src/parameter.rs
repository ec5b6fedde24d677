//! Numbers of a scene by their path: what sensitivities, calibrations and uncertain inputs vary.

use serde::{Deserialize, Serialize};
use std::fmt;

/// What a load follows from where the scene gives a torque.
const OF_TORQUE: [&str; 5] = [
    "bolts.torque",
    "bolts.thread.",
    "bolts.thread_friction",
    "bolts.head_friction",
    "bolts.bearing_diameters",
];

const ASPERITY_HEIGHT: &str = "interfaces.scale.asperity_height";

/// A number of a scene, named by its path: fields with dots between, elements of lists by their place from 0, such as `mu`,
/// `bolts.load`, `bolts.loads.2`, `model.material.youngs_modulus` or `interfaces.scale.asperity_radius`.
///
/// `bolts.load` of a scene whose bolts have loads of their own is a common factor on them, and the first of them its value. Where the loads
/// follow from a torque, a change of what they follow from changes them, and another load takes the place of the torque.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct Parameter(String);

/// What a change of a parameter makes necessary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Influence {
    /// Structure, interface and loads are others.
    Structure,
    /// Interface and loads are others.
    Interface,
    /// The loads of the bolts are others, and the interface where its law depends on them.
    Loads,
}

impl Parameter {
    /// From its path; whether a scene has such a number is found when it is asked.
    pub fn new(path: impl Into<String>) -> Self {
        Self(path.into())
    }

    /// The factor on the heights of asperities.
    pub(super) fn asperity_height() -> Self {
        Self::new(ASPERITY_HEIGHT)
    }

    /// Whether it is the factor on the heights of asperities.
    pub fn is_asperity_height(&self) -> bool {
        self.0 == ASPERITY_HEIGHT
    }

    /// Its path.
    pub fn path(&self) -> &str {
        &self.0
    }

    /// What depends on it.
    pub fn influence(&self) -> Influence {
        match self.0.split('.').next() {
            Some("bolts") => Influence::Loads,
            Some("model" | "structure") => Influence::Structure,
            _ => Influence::Interface,
        }
    }

    /// Whether it is one of the numbers that a surface is made from by drawing or measuring peaks, so that results do not change smoothly
    /// with it.
    pub fn is_drawn(&self) -> bool {
        let mut fields = self.0.split('.').peekable();
        if fields.next() != Some("interfaces") {
            return false;
        }
        if fields.next_if_eq(&"each").is_some() {
            fields.next();
        }
        fields.next() == Some("surface") && fields.next() != Some("parameters")
    }

    /// Whether it is the load of the bolts, or of one of them.
    pub(super) fn is_bolt_load(&self) -> bool {
        self.0 == "bolts.load" || self.0.starts_with("bolts.loads.")
    }

    /// Whether a load that follows from a torque depends on it.
    pub(super) fn is_of_torque(&self) -> bool {
        OF_TORQUE.iter().any(|field| self.0.starts_with(field))
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
