//! How long the stages of a run take, and how long is left of it.

use joints::progress::{Expected, Stage};
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

const STAGES: [Stage; 17] = [
    Stage::Mesh,
    Stage::Assemble,
    Stage::Factor,
    Stage::Reduce,
    Stage::Characterise,
    Stage::Comparisons,
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
    Stage::Bodies,
];

/// Part of a stage from which on its own pace alone tells how long it takes.
const OWN_PACE: f64 = 0.25;

/// Part of a stage from which on its pace tells anything.
const SEEN: f64 = 0.05;

/// Share of all that was expected of the stages so far from which on those of one kind tell the pace of their kind.
const OF_ITS_KIND: f64 = 0.15;

/// Measures the stages of a run, from when it is made on.
///
/// What is left is the sum over the stages that are begun and to come. A stage that is begun goes on at its own pace, as far as it is seen. Of a
/// stage to come, what is expected is scaled by the ratio of measured to expected seconds of the stages so far: of those of its kind, linear
/// algebra or contact, where enough of them are known, or else of all.
pub struct StageTimes {
    began: Instant,
    stages: Mutex<Stages>,
}

#[derive(Default)]
struct Stages {
    timings: BTreeMap<Stage, Timing>,
    expected: BTreeMap<Stage, Expected>,
}

#[derive(Clone, Copy)]
struct Timing {
    began: Instant,
    /// Of all that has ended.
    seconds: f64,
    is_open: bool,
    /// What is done of it.
    part: f64,
}

impl Timing {
    /// Since it began, if it has not ended.
    fn elapsed(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }
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
    /// A stage is to come.
    pub fn expect(&self, stage: Stage, expected: Expected) {
        self.stages().expected.insert(stage, expected);
    }

    /// A stage begins, perhaps once more.
    pub fn begin(&self, stage: Stage) {
        let mut stages = self.stages();
        let seconds = stages.timings.get(&stage).map_or(0.0, |timing| timing.seconds);
        let timing = Timing {
            began: Instant::now(),
            seconds,
            is_open: true,
            part: 0.0,
        };
        stages.timings.insert(stage, timing);
    }

    /// What is done of a stage, from 0 to 1; it does not fall.
    pub fn fraction(&self, stage: Stage, done: f64) -> f64 {
        let mut stages = self.stages();
        let Some(timing) = stages.timings.get_mut(&stage) else {
            return 0.0;
        };
        timing.part = timing.part.max(done.clamp(0.0, 1.0));
        timing.part
    }

    /// A stage ends; gives its seconds.
    pub fn end(&self, stage: Stage) -> f64 {
        self.stages().timings.get_mut(&stage).map_or(0.0, |timing| {
            let seconds = timing.elapsed();
            timing.seconds += seconds;
            timing.is_open = false;
            seconds
        })
    }

    /// Seconds that are left of all stages; none where there is no telling.
    pub fn left(&self) -> Option<f64> {
        let stages = self.stages();
        STAGES.iter().map(|stage| stages.left(*stage)).sum()
    }

    /// Seconds per stage, zero for those that the cache made unnecessary, and in total.
    pub fn seconds(&self) -> BTreeMap<String, f64> {
        let stages = self.stages();
        let seconds = |stage: Stage| stages.timings.get(&stage).map_or(0.0, |timing| timing.seconds);
        let mut timings: BTreeMap<String, f64> = STAGES.iter().map(|&s| (s.name().into(), seconds(s))).collect();
        timings.insert("total".into(), self.began.elapsed().as_secs_f64());
        timings
    }

    fn stages(&self) -> MutexGuard<'_, Stages> {
        self.stages.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Whether most of a stage is linear algebra.
fn is_linear(stage: Stage) -> bool {
    matches!(stage, Stage::Assemble | Stage::Factor | Stage::Reduce | Stage::Bodies)
}

impl Stages {
    /// Seconds that are left of a stage.
    fn left(&self, stage: Stage) -> Option<f64> {
        match self.timings.get(&stage) {
            Some(timing) if timing.is_open => {
                let (part, elapsed) = (timing.part, timing.elapsed());
                let own = (part >= SEEN).then(|| elapsed / part);
                let whole = match (own, self.whole(stage)) {
                    (Some(own), Some(expected)) => {
                        let weight = (part / OWN_PACE).min(1.0);
                        weight * own + (1.0 - weight) * expected
                    }
                    (own, expected) => own.or(expected)?,
                };
                // One of which nothing is seen has at least passed the time that it has taken.
                Some(if own.is_none() {
                    (whole - elapsed).max(0.0)
                } else {
                    (1.0 - part) * whole
                })
            }
            Some(_) => Some(0.0),
            // Whatever comes before one that is begun was skipped.
            None if self.timings.keys().any(|begun| *begun > stage) => Some(0.0),
            None if self.expected.contains_key(&stage) => self.whole(stage),
            None => Some(0.0),
        }
    }

    /// Seconds that a stage is expected to take.
    fn whole(&self, stage: Stage) -> Option<f64> {
        match self.expected.get(&stage)? {
            Expected::Seconds(seconds) => Some(seconds * self.pace(is_linear(stage))?),
            Expected::Times(times, of) => {
                let known = self.timings.get(of).filter(|timing| !timing.is_open);
                let of = known.map_or_else(|| self.whole(*of), |timing| Some(timing.seconds));
                Some(times * of?)
            }
        }
    }

    /// Measured over expected seconds of the stages so far.
    fn pace(&self, of_linear: bool) -> Option<f64> {
        let mut sums = [[0.0; 2]; 2];
        for (stage, timing) in &self.timings {
            let Some(Expected::Seconds(expected)) = self.expected.get(stage) else {
                continue;
            };
            let (measured, part) = match timing.is_open {
                true if timing.part >= SEEN => (timing.elapsed(), timing.part),
                true => continue,
                false => (timing.seconds, 1.0),
            };
            let sum = &mut sums[usize::from(is_linear(*stage) == of_linear)];
            sum[0] += measured;
            sum[1] += expected * part;
        }
        let [others, own] = sums;
        let all = [others[0] + own[0], others[1] + own[1]];
        let [measured, expected] = if own[1] > OF_ITS_KIND * all[1] { own } else { all };
        (expected > 0.0).then(|| measured / expected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// A stage that ended after so many seconds.
    fn ended(seconds: f64) -> Timing {
        Timing {
            began: Instant::now(),
            seconds,
            is_open: false,
            part: 1.0,
        }
    }

    /// A stage that began so many seconds ago, and is done in part.
    fn open(seconds: f64, part: f64) -> Timing {
        Timing {
            began: Instant::now() - Duration::from_secs_f64(seconds),
            seconds: 0.0,
            is_open: true,
            part,
        }
    }

    fn left(timings: &[(Stage, Timing)], expected: &[(Stage, Expected)]) -> Option<f64> {
        let times = StageTimes::default();
        *times.stages() = Stages {
            timings: timings.iter().copied().collect(),
            expected: expected.iter().copied().collect(),
        };
        times.left()
    }

    fn is_about(found: Option<f64>, seconds: f64) {
        let found = found.expect("an estimate");
        assert!(
            (found - seconds).abs() < 0.01 * seconds,
            "{found} s are not {seconds} s"
        );
    }

    #[test]
    fn what_is_left_follows_from_the_pace_so_far() {
        let expected = [
            (Stage::Factor, Expected::Seconds(2.0)),
            (Stage::Reduce, Expected::Seconds(3.0)),
            (Stage::Characterise, Expected::Seconds(1.0)),
            (Stage::Comparisons, Expected::Times(2.0, Stage::Characterise)),
        ];
        assert_eq!(left(&[], &expected), None);
        // Twice as slow as expected, and nothing known of the contact.
        is_about(left(&[(Stage::Factor, ended(4.0))], &expected), 6.0 + 2.0 + 4.0);
        // Halfway, the stage's own pace counts for it.
        is_about(
            left(&[(Stage::Factor, open(8.0, 0.5))], &expected),
            8.0 + 24.0 + 8.0 + 16.0,
        );
        // What is measured stands for what was expected; the contact has a pace of its own.
        let contact = [
            (Stage::Factor, ended(4.0)),
            (Stage::Reduce, ended(6.0)),
            (Stage::Characterise, ended(5.0)),
        ];
        is_about(left(&contact, &expected), 10.0);
        // Stages that the cache made unnecessary are passed.
        is_about(left(&[(Stage::Characterise, ended(5.0))], &expected), 10.0);
    }

    #[test]
    fn nothing_is_said_where_nothing_is_known() {
        let expected = [
            (Stage::Factor, Expected::Seconds(2.0)),
            (Stage::Epmc, Expected::Times(3.0, Stage::Backbone)),
        ];
        assert_eq!(left(&[(Stage::Factor, ended(4.0))], &expected), None);
        assert_eq!(left(&[(Stage::Epmc, open(1.0, 0.0))], &expected), None);
        is_about(left(&[(Stage::Epmc, open(1.0, 0.2))], &expected), 4.0);
        assert_eq!(left(&[(Stage::Epmc, ended(4.0))], &expected), Some(0.0));
    }

    #[test]
    fn parts_do_not_fall() {
        let times = StageTimes::default();
        times.begin(Stage::Factor);
        assert_eq!(times.fraction(Stage::Factor, 0.5), 0.5);
        assert_eq!(times.fraction(Stage::Factor, 0.25), 0.5);
        times.begin(Stage::Factor);
        assert_eq!(times.fraction(Stage::Factor, 0.25), 0.25);
    }
}
