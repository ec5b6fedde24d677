//! What the analyses of one interface find.

use super::forced::ForcedResponse;
use super::linearised::Linearised;
use super::mode_backbone::ModeAnalysis;
use super::prestress::PrestressResult;
use super::random::{RandomFailure, RandomVibration};
use super::ring_down::RingDown;
use super::shock::ShockResponse;
use super::tightening::TighteningResult;
use super::vibration::{Start, VibrationAnalysis};
use crate::Error;
use joints::progress::Progress;
use joints::store::checkpoint::Checkpoints;
use joints::store::key::KeyBuilder;
use std::path::Path;

/// What the nonlinear solves made of an interface.
pub(crate) struct Analysis {
    pub(crate) prestress: PrestressResult,
    /// How the bolts came to it, where they are tightened one after the other.
    pub(crate) tightening: Option<TighteningResult>,
    /// Linearised frequencies (Hz).
    pub(crate) frequencies: Vec<f64>,
    /// Derivatives of their logarithms by those of the stiffness of each interface, mode by mode (-).
    pub(crate) by_interface: Vec<Vec<f64>>,
    /// Memory that a product with the stuck structure's flexibility reads (bytes).
    pub(crate) flexibility_bytes: usize,
    /// The modes followed, in the scene's order.
    pub(crate) modes: Vec<ModeAnalysis>,
    pub(crate) vibration: Vibration,
    /// What lets the run resume until its results are safe.
    pub(crate) checkpoints: Checkpoints,
}

/// What analyses of vibration find beside the backbones; nothing where the scene does not ask for them.
#[derive(Debug)]
pub struct Vibration {
    /// Forced responses, level by level.
    pub forced: Option<Vec<ForcedResponse>>,
    /// Stationary random vibration, level by level, or why there is none.
    pub random: Option<Result<Vec<RandomVibration>, RandomFailure>>,
    /// The shock, or why there is none.
    pub shock: Option<Result<ShockResponse, Error>>,
    /// The ring-down, or why there is none.
    pub ring_down: Option<Result<RingDown, Error>>,
}

impl Vibration {
    /// Runs what the scene asks for, one after the other, and adds what lets it resume to `checkpoints`.
    pub(crate) fn of(
        about: Linearised<'_>,
        modes: &[ModeAnalysis],
        kept: Option<(&Path, KeyBuilder)>,
        checkpoints: &mut Checkpoints,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let asked = &about.scene.analyses;
        let start = || Start {
            about,
            modes,
            kept: kept.clone(),
            progress,
        };
        Ok(Self {
            forced: find(asked.forced.as_ref(), start, checkpoints)?,
            random: find(asked.random.as_ref(), start, checkpoints)?,
            shock: find(asked.shock.as_ref(), start, checkpoints)?,
            ring_down: find(asked.ring_down.as_ref(), start, checkpoints)?,
        })
    }
}

fn find<'a, A: VibrationAnalysis>(
    settings: Option<&A>,
    start: impl Fn() -> Start<'a>,
    checkpoints: &mut Checkpoints,
) -> Result<Option<A::Found>, Error> {
    let Some(settings) = settings else { return Ok(None) };
    let (found, resume) = settings.run(start())?;
    checkpoints.extend(resume);
    Ok(Some(found))
}
