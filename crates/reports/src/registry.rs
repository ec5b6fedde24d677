//! All analyses whose results are shown beside the backbone.

use crate::analysis::Analysis;
use crate::{ensemble, joints, names, periodic, random, ring_down, sensitivity, shock, tightening, uncertainty};
use analyses::results::summary::Summary;

/// In the order of the page and of the terminal.
pub static ANALYSES: [&Analysis; 9] = [
    &joints::ANALYSIS,
    &sensitivity::ANALYSIS,
    &periodic::ANALYSIS,
    &random::ANALYSIS,
    &shock::ANALYSIS,
    &ring_down::ANALYSIS,
    &tightening::ANALYSIS,
    &ensemble::ANALYSIS,
    &uncertainty::ANALYSIS,
];

/// Whether a run of some scene may write a file of this name beside those that every run writes.
pub fn is_of_some_run(name: &str) -> bool {
    names::is_of_backbones(name) || ANALYSES.iter().any(|analysis| (analysis.writes)(name))
}

/// Whether all that was asked for converged.
pub fn is_complete(summary: &Summary) -> bool {
    let backbones = summary.by_mode().all(|(_, of_mode)| {
        of_mode.backbone.iter().all(|b| b.converged) && of_mode.methods.values().flatten().all(|m| m.converged)
    });
    backbones && ANALYSES.iter().all(|analysis| (analysis.is_complete)(summary))
}
