//! How far a run is from one with finer settings.

use super::comparison::Backbone;
use super::run::Run;
use scenes::Preset;
use serde::{Deserialize, Serialize};

/// Differences between a run and one with finer settings: an estimate of the errors of the first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ErrorEstimate {
    /// The settings of the finer run.
    pub finer: String,
    /// Relative difference of the linearised frequency of the mode followed.
    pub linear_frequency: f64,
    /// Largest relative difference of the frequency at amplitudes common to both.
    pub frequency: Option<f64>,
    /// Largest difference of the logarithm of the damping ratio there.
    pub damping: Option<f64>,
}

impl ErrorEstimate {
    /// Compares a run with one of the scene that [`refined`](scenes::refined) gave.
    pub fn new(run: &Run, finer: &Preset, fine: &Run) -> Self {
        let mode = run.first().mode - 1;
        let cqsma = |run: &Run| -> Option<Backbone> {
            let all = run.first().over_acceleration();
            Some(all.ok()?.into_iter().next()?.1)
        };
        let misfit = cqsma(run).zip(cqsma(fine)).and_then(|(own, fine)| own.misfit(&fine));
        Self {
            finer: finer.name.to_owned(),
            linear_frequency: run.frequencies[mode] / fine.frequencies[mode] - 1.0,
            frequency: misfit.map(|misfit| misfit.frequency_percent.largest / 100.0),
            damping: misfit.and_then(|misfit| Some(misfit.damping_ln?.largest)),
        }
    }
}
