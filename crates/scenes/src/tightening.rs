//! The order in which bolts are tightened.

use super::check::Check;
use crate::Error;
use serde::{Deserialize, Serialize};

/// Bolts tightened one after the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Tightening {
    /// Numbers of the bolts, from 1, in the order in which each pass tightens them; each at least once.
    pub order: Vec<usize>,
    /// What each pass tightens to, as shares of each bolt's load (-); the last is 1.
    #[serde(default = "one_pass")]
    pub passes: Vec<f64>,
    /// Increments of the tension in each step, after each of which the friction history is committed.
    #[serde(default = "one")]
    pub increments: usize,
}

fn one_pass() -> Vec<f64> {
    vec![1.0]
}

fn one() -> usize {
    1
}

/// Steps beyond which a sequence is taken for a mistake.
const MOST_STEPS: usize = 10_000;

impl Tightening {
    pub(super) fn validate(&self, check: &Check<'_>) -> Result<(), Error> {
        let passes = self.passes.len();
        check.that(
            passes > 0,
            "analyses.tightening.passes",
            0.0,
            "(passes)",
            "at least one share, such as [0.5, 1.0]",
        )?;
        for &share in &self.passes {
            let holds = share > 0.0 && share <= 2.0;
            check.that(
                holds,
                "analyses.tightening.passes",
                share,
                "(share)",
                "above 0 and at most 2",
            )?;
        }
        let last = self.passes.last().copied().unwrap_or_default();
        check.that(
            last == 1.0,
            "analyses.tightening.passes",
            last,
            "(last share)",
            "1, so that the bolts are tightened to their load; change bolts.load for another one",
        )?;
        let steps = passes.saturating_mul(self.order.len()).saturating_mul(self.increments);
        check.that(
            (1..=MOST_STEPS).contains(&steps),
            "analyses.tightening",
            steps as f64,
            "(passes times bolts times increments)",
            "from 1 to 10000",
        )
    }

    /// Refuses an order that leaves out one of the structure's bolts or names another.
    ///
    /// # Errors
    /// [`Error::TighteningOrder`].
    pub fn check_bolts(&self, bolts: usize) -> Result<(), Error> {
        let refuse = |reason: String| Err(Error::TighteningOrder { reason, bolts });
        if let Some(unknown) = self.order.iter().find(|bolt| !(1..=bolts).contains(*bolt)) {
            return refuse(format!("names bolt {unknown}"));
        }
        match (1..=bolts).find(|bolt| !self.order.contains(bolt)) {
            Some(missing) => refuse(format!("leaves out bolt {missing}")),
            None => Ok(()),
        }
    }
}
