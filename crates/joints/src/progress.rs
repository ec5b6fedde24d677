//! How a run tells what it is doing. Libraries read no clocks; the receiver may.

use crate::Error;

/// The stages of a run, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Stage {
    /// Meshing.
    Mesh,
    /// Assembling mass and stiffness.
    Assemble,
    /// Factorising it and condensing it onto the interface, its modes with the interface stuck, and its frequencies to check the reduced model by.
    Factor,
    /// Putting the reduced model together and checking it (this and the two before are skipped when the cache holds it).
    Reduce,
    /// From surface to traction laws.
    Characterise,
    /// The same with other numbers of its settings, which errors of the settings follow from (skipped without loops).
    Comparisons,
    /// Static equilibrium.
    Prestress,
    /// Linearised modes.
    Modes,
    /// Hysteresis loops.
    Backbone,
    /// Methods beside CQSMA (skipped when none is asked for).
    Methods,
    /// Free periodic motions (skipped when none is asked for).
    Epmc,
    /// Forced responses (skipped when none is asked for).
    Forced,
    /// Stationary random vibration (skipped when none is asked for).
    Random,
    /// Realisations of an ensemble (skipped when none is asked for).
    Ensemble,
    /// A shock followed in time (skipped when none is asked for).
    Shock,
    /// A motion followed in time (skipped when none is asked for).
    Transient,
    /// Displacements of the bodies, and the error of their mesh (skipped when neither is asked for).
    Bodies,
}

impl Stage {
    /// Name as used in the outputs.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Mesh => "mesh",
            Stage::Assemble => "assemble",
            Stage::Factor => "factor",
            Stage::Reduce => "reduce",
            Stage::Characterise => "characterise",
            Stage::Comparisons => "comparisons",
            Stage::Prestress => "prestress",
            Stage::Modes => "modes",
            Stage::Backbone => "backbone",
            Stage::Methods => "methods",
            Stage::Epmc => "epmc",
            Stage::Forced => "forced",
            Stage::Random => "random",
            Stage::Ensemble => "ensemble",
            Stage::Shock => "shock",
            Stage::Transient => "transient",
            Stage::Bodies => "bodies",
        }
    }
}

/// An amplitude of a mode that is finished.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amplitude {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Displacement amplitude at the response point (m).
    pub amplitude_m: f64,
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Total damping ratio; none below its floor.
    pub damping_ratio: Option<f64>,
}

/// What a stage to come is expected to take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// So many seconds on a usual computer: what counts is their ratio to those of other stages.
    Seconds(f64),
    /// So many times what another stage takes.
    Times(f64, Stage),
}

/// Receives the progress of a run; calls may come from several threads.
pub trait Progress: Sync {
    /// A stage is to come. Stages that are not told of may come too, and one that is told of may be skipped.
    fn expect(&self, _stage: Stage, _expected: Expected) {}
    /// A stage begins.
    fn begin(&self, _stage: Stage) {}
    /// Part of the current stage that is done, from 0 to 1.
    fn fraction(&self, _stage: Stage, _done: f64) {}
    /// An amplitude of a backbone of the scene itself is finished, in any order. The first one after a stage [`Stage::Backbone`] began stands in the
    /// place of all before.
    fn amplitude(&self, _found: &Amplitude) {}
    /// A stage has ended.
    fn end(&self, _stage: Stage) {}
    /// Asked often, from any thread: whether to stop. What is finished is kept for the next run of the scene if there is a cache.
    fn interrupted(&self) -> bool {
        false
    }
    /// Something the user should know.
    fn note(&self, _text: &str) {}
    /// Something implausible, in a sentence.
    fn warn(&self, text: &str) {
        self.note(&format!("warning: {text}"));
    }
    /// A line about what will be computed with, before it is.
    fn echo(&self, _line: &str) {}
}

/// An error if the run shall stop.
pub fn go_on(progress: &dyn Progress) -> Result<(), Error> {
    match progress.interrupted() {
        true => Err(Error::Interrupted),
        false => Ok(()),
    }
}

/// Ends a stage that others follow: an error if the run shall stop.
pub fn end_stage(progress: &dyn Progress, stage: Stage) -> Result<(), Error> {
    progress.end(stage);
    go_on(progress)
}

/// Ignores everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {}

/// Shows nothing but whether to stop.
pub struct Quiet<'a>(pub &'a dyn Progress);

impl Progress for Quiet<'_> {
    fn interrupted(&self) -> bool {
        self.0.interrupted()
    }
}

/// Shows work as a part of a stage: its own stages are not shown, but for loops.
pub struct Within<'a> {
    progress: &'a dyn Progress,
    stage: Stage,
    part: [f64; 2],
}

impl<'a> Within<'a> {
    /// Work between these two parts of a stage, from 0 to 1.
    pub fn new(progress: &'a dyn Progress, stage: Stage, part: [f64; 2]) -> Self {
        Self { progress, stage, part }
    }

    /// Tells what of the work is done, from 0 to 1.
    pub fn done(&self, part: f64) {
        let [begin, end] = self.part;
        self.progress.fraction(self.stage, begin + (end - begin) * part);
    }

    /// A part of this work.
    #[must_use]
    pub fn part(&self, begin: f64, end: f64) -> Self {
        let place = |part: f64| self.part[0] + (self.part[1] - self.part[0]) * part;
        Self::new(self.progress, self.stage, [place(begin), place(end)])
    }
}

impl Progress for Within<'_> {
    fn fraction(&self, stage: Stage, done: f64) {
        if stage == Stage::Backbone {
            self.done(done);
        }
    }

    fn note(&self, text: &str) {
        self.progress.note(text);
    }

    fn interrupted(&self) -> bool {
        self.progress.interrupted()
    }
}
