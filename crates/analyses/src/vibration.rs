//! What an analysis of vibration about the static state is.

use super::linearised::Linearised;
use super::mode_backbone::ModeAnalysis;
use crate::Error;
use joints::progress::Progress;
use joints::store::checkpoint::Checkpoints;
use joints::store::key::KeyBuilder;
use std::path::Path;

/// What an analysis of vibration starts from.
pub(super) struct Start<'a> {
    pub(super) about: Linearised<'a>,
    /// The modes followed, in the scene's order, with their backbones.
    pub(super) modes: &'a [ModeAnalysis],
    /// Folder of checkpoints, if they are kept, and what all loops of the scene depend on.
    pub(super) kept: Option<(&'a Path, KeyBuilder)>,
    pub(super) progress: &'a dyn Progress,
}

/// An analysis of vibration about the static state; its settings, a block of a scene's `analyses`, implement it.
pub(super) trait VibrationAnalysis {
    /// What it finds.
    type Found;

    /// Finds it, with the checkpoints that let it resume until its results are safe.
    ///
    /// # Errors
    /// What ends the whole run; what ends this analysis alone may be part of what it finds.
    fn run(&self, start: Start<'_>) -> Result<(Self::Found, Checkpoints), Error>;
}
