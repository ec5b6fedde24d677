//! The traction law of a scene.

use contact_laws::{HistoryRule, TangentialReading};
use serde::{Deserialize, Serialize};

/// Traction law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Law {
    /// How the asperity sums are evaluated.
    pub kind: LawKind,
    /// Tangential stiffness of an asperity.
    pub tangential: TangentialReading,
    /// How the stuck traction follows from the last committed state.
    pub history: HistoryRule,
}

impl Default for Law {
    fn default() -> Self {
        Self {
            kind: LawKind::Tabulated,
            tangential: TangentialReading::Mindlin,
            history: HistoryRule::Incremental,
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
}
