//! The traction law of a scene.

use super::units::{Length, Stress};
use contact_laws::{AsperityLimit, Cone, HistoryRule, TangentialReading, YieldCurves};
use serde::{Deserialize, Serialize};

/// Traction law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Law {
    /// How the asperity sums are evaluated, for lumped friction; or, with `boundary-elements`, what takes their place.
    pub kind: LawKind,
    /// Tangential stiffness of an asperity. For lumped friction; asperities with a history of their own have Mindlin's.
    pub tangential: TangentialReading,
    /// How the stuck traction follows from the last committed state.
    pub history: HistoryRule,
    /// What sticks or slips as a whole: by default springs of a foundation for elastic asperities, and annuli for asperities that yield. Without asperities (`surface.parameters`) points do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
    /// How asperities yield; by default they are elastic. For resolved friction.
    #[serde(rename = "yield", skip_serializing_if = "Option::is_none")]
    pub yielding: Option<Yield>,
    /// Shape of the slip limit.
    pub cone: Cone,
    /// What limits the tangential force of an asperity. Others than Coulomb's for asperities that yield; `mu` is then without
    /// effect.
    pub limit: AsperityLimit,
    /// Bins that stand for the asperities of a point. For resolved friction.
    pub bins: Bins,
    /// Radii at which an asperity slips. For `mindlin-iwan`.
    pub radii: RadialRule,
}

impl Law {
    /// What sticks or slips as a whole.
    pub fn friction(&self) -> Friction {
        let by_default = match self.yielding {
            None => Friction::Foundation,
            Some(_) => Friction::MindlinIwan,
        };
        self.friction.unwrap_or(by_default)
    }

    /// How asperities yield, in SI.
    pub fn yielding(&self) -> Option<contact_laws::Yield> {
        self.yielding.map(|of| contact_laws::Yield {
            strength: of.strength.si(),
            tangent_modulus: of.tangent_modulus.si(),
            curves: of.curves,
        })
    }
}

impl Default for Law {
    fn default() -> Self {
        Self {
            kind: LawKind::Tabulated,
            tangential: TangentialReading::Mindlin,
            history: HistoryRule::Incremental,
            friction: None,
            yielding: None,
            cone: Cone::Circle,
            limit: AsperityLimit::Coulomb,
            bins: Bins::Error(3e-4),
            radii: RadialRule::Annuli(8),
        }
    }
}

/// How the asperity sums are evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LawKind {
    /// Monotone table with a measured error bound. Of scans, the empirical distribution of the heights is interpolated
    /// linearly between its order statistics ([`surface_characterisation::PairAsperities::interpolated_population`]).
    Tabulated,
    /// Curves fitted with eqs. (28) and (29).
    Fitted,
    /// The sums themselves.
    AsperitySum,
    /// Contact of the scanned faces by boundary elements ([`surface_characterisation::BoundaryElements`]), element by element; also for a foundation.
    BoundaryElements,
}

/// What sticks or slips as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Friction {
    /// A quadrature point, as in the method paper.
    Lumped,
    /// A spring of an elastic foundation that has the normal traction of the asperities: partial slip as Cattaneo and Mindlin found it, for
    /// elastic asperities ([`contact_laws::friction::foundation`]).
    Foundation,
    /// An asperity.
    Resolved,
    /// An annulus of the contact circle of an asperity.
    MindlinIwan,
}

/// How asperities yield.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Yield {
    /// Yield strength (force/length^2).
    pub strength: Stress,
    /// Tangent modulus of the hardening material (force/length^2).
    pub tangent_modulus: Stress,
    /// What is made of the jumps in the published curves.
    #[serde(default)]
    pub curves: YieldCurves,
}

/// Bins that stand for the asperities of a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Bins {
    /// As few Gauss bins as keep the largest relative error of elastic traction, stiffness and dissipated energy below this
    /// ([`contact_laws::AsperityBins::errors`], amplitudes from a tenth of gross slip).
    Error(f64),
    /// So many Gauss bins, an even number, up to the largest interference expected
    /// ([`contact_laws::AsperityBins::gauss`]); springs of a foundation are placed about the interference of each point under the bolt loads
    /// ([`contact_laws::Growth::springs_about`]).
    Gauss(usize),
    /// So many equally spaced gaps, the same at every point.
    EquallySpaced(usize),
}

/// Radii at which an asperity slips.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum RadialRule {
    /// So many annuli, which keep their places relative to the contact radius ([`contact_laws::AsperityFriction::Annuli`]).
    Annuli(usize),
    /// So many equally spaced radii, between which the history is interpolated, as published
    /// ([`contact_laws::AsperityFriction::MindlinIwan`]).
    EquallySpaced(usize),
}

/// A part of the interface with a friction coefficient of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FrictionZone {
    /// Friction coefficient (-).
    pub mu: f64,
    /// Smallest and largest x of the quadrature points in it, in the plane of the interface, as fields of the interface have it
    /// (length).
    pub x: [Length; 2],
    /// Smallest and largest y (length).
    pub y: [Length; 2],
}
