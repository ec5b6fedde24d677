//! The interfaces of a scene: what their faces are, and the law of their contact.

use super::law::{FrictionZone, Law};
use super::scale::Scale;
use super::surface::{Gap, Surface};
use serde::{Deserialize, Serialize};

/// What all interfaces of a structure have in common, and what single ones have of their own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Interfaces {
    /// What the traction law follows from.
    pub surface: Surface,
    /// Gap between the faces before they are loaded.
    #[serde(default)]
    pub gap: Gap,
    /// Factors on what is known of the faces.
    #[serde(default)]
    pub scale: Scale,
    /// Traction law.
    #[serde(default)]
    pub law: Law,
    /// Friction coefficient (-), not negative; left out with a `law.limit` that follows from the strength.
    pub mu: f64,
    /// Parts of the interface with another friction coefficient. Zones without points, or with points of another zone, are refused.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub friction_zones: Vec<FrictionZone>,
    /// Gauss points per direction of each interface element: 1, 2, 3, 4 or 5. Points of contact have none.
    #[serde(default = "Interfaces::default_points")]
    pub points_per_direction: usize,
    /// What each interface of a mesh has in the place of the above, in the order of `structure.mesh.interfaces`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub each: Vec<OwnInterface>,
}

/// What one interface has of its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct OwnInterface {
    /// What its traction law follows from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<Surface>,
    /// Gap between its faces before they are loaded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Its traction law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<Law>,
    /// Its friction coefficient (-).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu: Option<f64>,
}

impl Interfaces {
    pub(super) fn default_points() -> usize {
        3
    }

    /// Those of one interface, counted from zero, alone.
    pub(super) fn of(&self, number: usize) -> Self {
        let mut own = self.clone();
        if let Some(OwnInterface { surface, gap, law, mu }) = own.each.get(number).cloned() {
            own.surface = surface.unwrap_or(own.surface);
            own.gap = gap.unwrap_or(own.gap);
            own.law = law.unwrap_or(own.law);
            own.mu = mu.unwrap_or(own.mu);
        }
        own.each.clear();
        own
    }

    /// Those of every interface with something of its own, or those that all have in common where none has.
    pub fn single(&self) -> impl Iterator<Item = Self> {
        (0..self.each.len().max(1)).map(|number| self.of(number))
    }

    /// All surfaces.
    pub fn surfaces(&self) -> impl Iterator<Item = &Surface> {
        let own = self.each.iter().filter_map(|own| own.surface.as_ref());
        std::iter::once(&self.surface).chain(own)
    }
}
