//! The table of history rules: the name that calling codes and files use, and the type behind it.

use super::end_point::EndPoint;
use super::incremental::Incremental;
use super::paper::Paper;
use super::potential::Potential;
use super::return_map::Block;
use super::rule::{FrictionRule, Memory, StiffnessAt};
use crate::law::RegimeCounts;

/// How the stuck traction follows from the state committed last, and what limits it; see the [module](super).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum HistoryRule {
    /// [Midpoint rule](super::incremental) along the closed part of the path.
    #[default]
    Incremental,
    /// As [published](super::paper): linearised about the end point, with the total displacement.
    Paper,
    /// With the stiffness at the [end point](super::end_point) of the path.
    EndPoint,
    /// From a [potential](super::potential), with the elastic stretch as state.
    Potential,
}

/// The expression `$body` with `$rule` as the value behind the name: compiled once per rule.
macro_rules! with_rule {
    ($name:expr, $rule:ident => $body:expr) => {
        match $name {
            HistoryRule::Incremental => {
                let $rule = Incremental;
                $body
            }
            HistoryRule::Paper => {
                let $rule = Paper;
                $body
            }
            HistoryRule::EndPoint => {
                let $rule = EndPoint;
                $body
            }
            HistoryRule::Potential => {
                let $rule = Potential;
                $body
            }
        }
    };
}

/// What a law has to know of its rule before it evaluates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Needs {
    pub(crate) memory: Memory,
    pub(crate) stiffness: StiffnessAt,
    pub(crate) curvature: bool,
}

impl Needs {
    fn of<R: FrictionRule>(_rule: R) -> Self {
        Self {
            memory: R::MEMORY,
            stiffness: R::STIFFNESS,
            curvature: R::CURVATURE,
        }
    }
}

impl HistoryRule {
    pub(crate) fn needs(self) -> Needs {
        with_rule!(self, rule => Needs::of(rule))
    }

    /// Tractions and all else of a block.
    pub(crate) fn respond<const B: usize>(self, block: Block<'_, B>) -> RegimeCounts {
        with_rule!(self, rule => block.respond(rule))
    }
}
