//! How a study of many scenes tells what it is doing.

use joints::progress::{Progress, Stage};
use std::sync::{Mutex, PoisonError};

/// Shows how far a study is; calls may come from several threads.
pub trait Display: Sync {
    /// Part of the work that is done, from 0 to 1.
    fn fraction(&self, done: f64);
    /// A line that stays.
    fn line(&self, text: &str);
}

/// Progress of many runs as one display.
pub(crate) struct Batch<'a> {
    display: &'a dyn Display,
    total: f64,
    /// Work done, in the unit of `total`, and finished runs.
    done: Mutex<(f64, usize)>,
    runs: usize,
}

impl<'a> Batch<'a> {
    /// `runs` runs whose work adds up to `total`, in any unit.
    pub(crate) fn new(display: &'a dyn Display, runs: usize, total: f64) -> Self {
        Self {
            display,
            total: total.max(f64::MIN_POSITIVE),
            done: Mutex::new((0.0, 0)),
            runs,
        }
    }

    /// A run that is about to begin.
    pub(crate) fn task(&self, work: f64) -> Task<'_> {
        Task {
            batch: self,
            work,
            told: Mutex::new(0.0),
        }
    }

    /// A run has ended; its `line` is shown.
    pub(crate) fn end(&self, task: &Task<'_>, line: &str) {
        task.reach(1.0);
        let number = {
            let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
            done.1 += 1;
            done.1
        };
        self.note(&format!("{number:>4} of {} {line}", self.runs));
    }

    pub(crate) fn note(&self, text: &str) {
        self.display.line(text);
    }
}

/// One run of a [`Batch`].
pub(crate) struct Task<'a> {
    batch: &'a Batch<'a>,
    work: f64,
    told: Mutex<f64>,
}

impl Task<'_> {
    fn reach(&self, part: f64) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        let more = (part - *told).max(0.0);
        *told += more;
        let mut done = self.batch.done.lock().unwrap_or_else(PoisonError::into_inner);
        done.0 += more * self.work;
        self.batch.display.fraction(done.0 / self.batch.total);
    }
}

impl Progress for Task<'_> {
    fn fraction(&self, stage: Stage, done: f64) {
        // Loops are where the time goes; what comes before and after is little.
        if stage == Stage::Backbone {
            self.reach(0.9 * done);
        }
    }

    fn note(&self, text: &str) {
        self.batch.note(&format!("             {text}"));
    }
}
