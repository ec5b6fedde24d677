//! Bootstrap realisations of a run.

use crate::analysis::{Analysis, Document};
use crate::{Output, csv};

/// Name of the table of an ensemble.
pub const ENSEMBLE: &str = "ensemble.csv";

pub(crate) static ANALYSIS: Analysis = Analysis {
    writes: |name| name == ENSEMBLE,
    document: |_, summary| {
        let Some(found) = &summary.ensemble else {
            return Ok(None);
        };
        Ok(Some(Document {
            outputs: vec![Output::new(ENSEMBLE, csv::ensemble(found)?)],
            section: None,
        }))
    },
    lines: |summary| {
        let line = summary.ensemble.as_ref().map(|found| {
            format!(
                "{} bootstrap realisations, {} without a backbone; bands in {ENSEMBLE}\n",
                found.realisations, found.failed
            )
        });
        line.unwrap_or_default()
    },
    is_complete: |summary| {
        let mut members = summary.ensemble.iter().flat_map(|found| &found.members);
        members.all(|member| member.failure.is_none() && member.not_converged == 0)
    },
};
