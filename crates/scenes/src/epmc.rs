//! Free periodic motions by the extended periodic motion concept (EPMC).

use super::check::Check;
use super::units::ModalAmplitude;
use crate::Error;
use serde::{Deserialize, Serialize};

/// Free periodic motions by the extended periodic motion concept (method `epmc`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Epmc {
    /// Modal amplitudes of the first harmonic (sqrt(mass) length), ascending; by default those that the amplitudes of `backbone`
    /// belong to by linear estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modal_amplitudes: Option<Amplitudes>,
    /// Highest harmonic, 1 to 100; with `accuracy` the one that the first amplitude begins with.
    pub harmonics: usize,
    /// Samples per period, 8 to 65536 and more than twice the harmonics; the same.
    pub samples: usize,
    /// Periods that the history is followed for, the last of which is measured.
    pub periods: usize,
    /// Residual relative to the elastic forces of the first harmonic, in the energy norm.
    pub tolerance: f64,
    /// Errors that are borne: harmonics and samples are raised at each amplitude until what two harmonics more and twice the samples
    /// change shows smaller ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<SamplingAccuracy>,
    /// Quadrature points, counted from 1, whose hysteresis loops are stored; by default the one that takes most energy per area at the
    /// largest amplitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loops_at: Option<Vec<usize>>,
}

impl Default for Epmc {
    fn default() -> Self {
        Self {
            modal_amplitudes: None,
            harmonics: 3,
            samples: 128,
            periods: 2,
            tolerance: 1e-8,
            accuracy: None,
            loops_at: None,
        }
    }
}

/// Amplitudes one by one, in ascending order, or `{ "from": .., "to": .., "number": .. }`, spaced in log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    untagged,
    expecting = "a list of modal amplitudes, or {\"from\": .., \"to\": .., \"number\": ..}"
)]
pub enum Amplitudes {
    /// Each of them.
    List(Vec<ModalAmplitude>),
    /// Spaced in log.
    Range(AmplitudeRange),
}

/// Amplitudes that are spaced in log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AmplitudeRange {
    /// Smallest (sqrt(mass) length).
    pub from: ModalAmplitude,
    /// Largest (sqrt(mass) length).
    pub to: ModalAmplitude,
    /// How many.
    pub number: usize,
}

impl Amplitudes {
    /// All of them (sqrt(kg) m).
    pub fn values(&self) -> Vec<f64> {
        match self {
            Self::List(values) => values.iter().map(|q| q.si()).collect(),
            Self::Range(AmplitudeRange { from, to, number }) => {
                let ratio = (to.si() / from.si()).ln();
                let last = number.saturating_sub(1).max(1) as f64;
                (0..*number)
                    .map(|i| match i {
                        // To the last bit.
                        0 => from.si(),
                        i if i + 1 == *number => to.si(),
                        i => from.si() * (ratio * i as f64 / last).exp(),
                    })
                    .collect()
            }
        }
    }
}

/// Errors of sampling that are borne.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SamplingAccuracy {
    /// Relative error of the frequency.
    pub frequency: f64,
    /// Relative error of the damping ratio, where that is above 1e-5.
    pub damping: f64,
}

impl Epmc {
    /// Refuses values outside their ranges.
    pub(super) fn validate(&self, check: &Check<'_>) -> Result<(), Error> {
        sampling(
            check,
            ["analyses.epmc.harmonics", "analyses.epmc.samples"],
            self.harmonics,
            self.samples,
        )?;
        check.that(
            self.tolerance >= 1e-13 && self.tolerance <= 1e-3,
            "analyses.epmc.tolerance",
            self.tolerance,
            "",
            "between 1e-13 and 1e-3",
        )?;
        if let Some(target) = self.accuracy {
            check.positive("analyses.epmc.accuracy.frequency", target.frequency, "")?;
            check.positive("analyses.epmc.accuracy.damping", target.damping, "")?;
        }
        for point in self.loops_at.iter().flatten() {
            check.that(
                *point > 0,
                "analyses.epmc.loops_at",
                0.0,
                "",
                "numbers of points, counted from 1",
            )?;
        }
        let Some(amplitudes) = &self.modal_amplitudes else {
            return Ok(());
        };
        if let Amplitudes::Range(range) = amplitudes {
            check.that(
                (1..=10_000).contains(&range.number),
                "analyses.epmc.modal_amplitudes.number",
                range.number as f64,
                "",
                "from 1 to 10000",
            )?;
        }
        let mut last = 0.0;
        for value in amplitudes.values() {
            check.positive("analyses.epmc.modal_amplitudes", value, "sqrt(kg) m")?;
            let rises = value > last;
            check.that(
                rises,
                "analyses.epmc.modal_amplitudes",
                value,
                "sqrt(kg) m",
                "above the one before it",
            )?;
            last = value;
        }
        Ok(())
    }
}

/// Harmonics and samples of harmonic balance.
pub(super) fn sampling(
    check: &Check<'_>,
    fields: [&'static str; 2],
    harmonics: usize,
    samples: usize,
) -> Result<(), Error> {
    let range = (1..=100).contains(&harmonics);
    check.that(range, fields[0], harmonics as f64, "", "from 1 to 100")?;
    let enough = samples > 2 * harmonics && (8..=65_536).contains(&samples);
    check.that(
        enough,
        fields[1],
        samples as f64,
        "",
        "from 8 to 65536, and more than twice the number of harmonics",
    )
}
