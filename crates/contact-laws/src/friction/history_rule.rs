//! The registry of history rules: a rule is a file of the folder `history_rule`, and a row here.
//!
//! All else follows from the row: [`HistoryRule`] with its names in files, the constants of the C interface, the names in
//! Python, [the table of rules](HISTORY_RULES), the rules that the tests run on. What cannot be made from it (the header
//! for C, the type hints for Python, the pages of the documentation) is compared with it by tests.

pub mod end_point;
pub mod incremental;
pub mod paper;
pub mod potential;

use super::annuli::{Annuli, Ruled};
use super::return_map::Block;
use super::rule::{FrictionRule, Memory, StiffnessAt};
use crate::choice::choices;
use crate::law::{Quantity, RegimeCounts};
use crate::simd::run;

/// What there is for every rule, from its row.
macro_rules! history_rules {
    ($(
        $Rule:ident in $module:ident: $name:literal, $number:literal, $summary:literal,
            trial $trial:literal, source $source:literal;
    )+) => {
        choices! {
            /// How the stuck traction follows from the state committed last, and what limits it; see
            /// [`friction`](crate::friction).
            pub enum HistoryRule, "HISTORY", "History rule" {
                $($Rule = $name, $number, $summary;)+
            }
        }

        /// All rules, in the order of [`Choice::ALL`](crate::Choice::ALL). The pages of the rules explain the symbols.
        ///
        /// | rule | name | number in C | what it is | stuck trial | source |
        /// |---|---|---|---|---|---|
        $(#[doc = concat!(
            "| [`", stringify!($Rule), "`](", stringify!($module), ") | `", $name, "` | ", $number, " | ", $summary,
            " | `", $trial, "` | ", $source, " |"
        )])+
        pub static HISTORY_RULES: &[HistoryRuleInfo] = &[$(
            HistoryRuleInfo {
                rule: HistoryRule::$Rule,
                stuck_trial: $trial,
                source: $source,
                state: <$module::$Rule as FrictionRule>::MEMORY.quantities(),
            },
        )+];

        impl HistoryRule {
            pub(crate) fn needs(self) -> Needs {
                match self {
                    $(Self::$Rule => Needs::of($module::$Rule),)+
                }
            }

            /// Tractions and all else of a block: compiled once per rule.
            pub(crate) fn respond<const B: usize>(self, block: Block<'_, B>) -> RegimeCounts {
                match self {
                    $(Self::$Rule => block.respond($module::$Rule),)+
                }
            }

            /// What the annuli of a bin answer.
            pub(crate) fn annuli<const B: usize>(self, annuli: Annuli<'_, B>) {
                match self {
                    $(Self::$Rule => run(Ruled(annuli, $module::$Rule)),)+
                }
            }

            /// [`FrictionRule::described`].
            #[cfg(test)]
            pub(crate) fn described(
                self,
                path: &crate::tests::described::Described<'_>,
            ) -> crate::tests::described::Quantity3 {
                match self {
                    $(Self::$Rule => $module::$Rule::described(path),)+
                }
            }
        }
    };
}

// Rule in its module: name, number in C (which never changes), what it is, stuck trial, source.
history_rules! {
    Incremental in incremental: "incremental", 0, "Midpoint rule along the closed part of the path.",
        trial "t_q0 + f k_q((u_n + l)/2) (u_q - u_q0)",
        source "this project, for eq. (17) of 10.1016/j.ymssp.2020.106615";
    Paper in paper: "paper", 1, "As published: linearised about the end point, with the total displacement.",
        trial "t_q0 + k_q(u_n) (u_q - u_q0) + k_q'(u_n) (u_n - u_n0) u_q",
        source "10.1016/j.ymssp.2020.106615, eq. (18)";
    EndPoint in end_point: "end-point", 3, "With the stiffness at the end of the path, along the whole path.",
        trial "t_q0 + k_q(u_n) (u_q - u_q0)",
        source "10.1016/j.ymssp.2023.110210";
    Potential in potential: "potential", 2, "From a potential, with the elastic stretch as state.",
        trial "k_q(u_n) e_q, e_q = e_q0 + f (u_q - u_q0)",
        source "this project";
}

/// A row of [`HISTORY_RULES`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HistoryRuleInfo {
    /// The rule.
    pub rule: HistoryRule,
    /// Stuck trial of the tangential traction along a direction `q`.
    pub stuck_trial: &'static str,
    /// Where it is from.
    pub source: &'static str,
    /// What the state remembers beside the jump.
    pub state: [Quantity; 2],
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
