//! How long the stages of a run take.

use joints::progress::Stage;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

const STAGES: [Stage; 15] = [
    Stage::Mesh,
    Stage::Assemble,
    Stage::Factor,
    Stage::Reduce,
    Stage::Characterise,
    Stage::Prestress,
    Stage::Modes,
    Stage::Backbone,
    Stage::Methods,
    Stage::Epmc,
    Stage::Forced,
    Stage::Random,
    Stage::Ensemble,
    Stage::Shock,
    Stage::Transient,
];

/// Measures the stages of a run, from when it is made on.
pub struct StageTimes {
    began: Instant,
    stages: Mutex<BTreeMap<Stage, Timing>>,
}

#[derive(Clone, Copy)]
struct Timing {
    began: Instant,
    seconds: f64,
}

impl Default for StageTimes {
    fn default() -> Self {
        Self {
            began: Instant::now(),
            stages: Mutex::default(),
        }
    }
}

impl StageTimes {
    /// A stage begins.
    pub fn begin(&self, stage: Stage) {
        let timing = Timing {
            began: Instant::now(),
            seconds: 0.0,
        };
        self.stages().insert(stage, timing);
    }

    /// A stage ends; gives its seconds.
    pub fn end(&self, stage: Stage) -> f64 {
        self.stages().get_mut(&stage).map_or(0.0, |timing| {
            timing.seconds = timing.began.elapsed().as_secs_f64();
            timing.seconds
        })
    }

    /// Seconds per stage, zero for those that the cache made unnecessary, and in total.
    pub fn seconds(&self) -> BTreeMap<String, f64> {
        let stages = self.stages();
        let seconds = |stage: Stage| stages.get(&stage).map_or(0.0, |timing| timing.seconds);
        let mut timings: BTreeMap<String, f64> = STAGES.iter().map(|&s| (s.name().into(), seconds(s))).collect();
        timings.insert("total".into(), self.began.elapsed().as_secs_f64());
        timings
    }

    fn stages(&self) -> MutexGuard<'_, BTreeMap<Stage, Timing>> {
        self.stages.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
