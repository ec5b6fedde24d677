//! Runs cases in this process: structure by structure, and on each the cases in parallel, with one thread each.

use crate::Error;
use crate::case::Case;
use crate::store::{Record, Store, Writer};
use crate::study::Study;
use analyses::cases::{CaseMode, CaseStructure};
use analyses::hyper_reduced::{Training, TrainingCase};
use joints::Options;
use joints::interface::SceneInterface;
use joints::progress::Silent;
use scenes::Scene;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Share of the free memory that cases may take.
const MEMORY: f64 = 0.8;

/// What a library must not find out by itself; called from several threads.
pub trait Machine: Sync {
    /// Seconds since some moment.
    fn seconds(&self) -> f64;
    /// Threads that cases may use.
    fn threads(&self) -> usize;
    /// Calls a function on so many threads at once, each of which is all that what it calls may use.
    fn on_threads(&self, number: usize, work: &(dyn Fn() + Sync));
    /// Memory of the process and of the system, where they tell.
    fn memory(&self) -> Option<Memory>;
    /// Makes the peak of the memory count from now on.
    fn forget_peak_memory(&self);
    /// Part of the cases that are done, from 0 to 1.
    fn fraction(&self, done: f64);
    /// A line that stays.
    fn line(&self, text: &str);
    /// Waits.
    fn wait(&self, seconds: f64);
}

/// Memory (bytes).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Largest of the process since its peak was forgotten.
    pub peak: u64,
    /// What the process may still take.
    pub free: u64,
}

/// What was run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Cases.
    pub cases: usize,
    /// Time of all cases, each on one thread (s).
    pub case_seconds: f64,
    /// Time for the structures (s).
    pub structure_seconds: f64,
    /// Wall time for the cases that others learn from, run before or not, and for learning (s).
    pub teaching_seconds: f64,
    /// Wall time (s).
    pub seconds: f64,
}

/// What is known of an interface whose asperities several cases share.
#[derive(Default)]
struct Shared {
    known: Mutex<Option<Arc<SceneInterface>>>,
    /// Cases that have not taken it yet.
    left: AtomicUsize,
}

/// Runs cases of a study, by index, and appends each to the store when it is done. `memory` (bytes) stands for what the system says is free.
///
/// # Errors
/// A line could not be written. Whatever ends a case is its record.
pub fn run(
    study: &Study<'_>,
    store: &Store,
    todo: &[usize],
    options: &Options,
    memory: Option<u64>,
    machine: &dyn Machine,
) -> Result<Tally, Error> {
    let began = machine.seconds();
    let all: Vec<&Case> = todo.iter().filter_map(|index| study.cases.get(*index)).collect();
    let runner = Runner {
        study,
        machine,
        writer: Mutex::new(Writer::new(store.root())),
        failed: Mutex::new(None),
        done: AtomicUsize::new(0),
        all: all.len(),
        tally: Mutex::default(),
    };
    let mut gang = Gang {
        allowed: machine.threads().max(1),
        largest: 0,
        memory,
    };
    for group in all.chunk_by(|a, b| a.structure == b.structure) {
        let Some(first) = group.first() else {
            continue;
        };
        let before = machine.seconds();
        let reduced = study
            .scene(first.number)
            .and_then(|scene| Ok(CaseStructure::try_new(&scene, options, &Silent)?));
        let reduction = machine.seconds() - before;
        runner.tally().structure_seconds += reduction;
        let structure = match &reduced {
            Ok(structure) => structure,
            Err(error) => {
                for case in group {
                    runner.finish(case, 0.0, Err(error.to_string()));
                }
                runner.ended()?;
                continue;
            }
        };
        let teachers = match group.iter().any(|case| case.learns.is_some()) {
            true => study.training.get(&first.structure).map_or(&[][..], Vec::as_slice),
            false => &[],
        };
        let teachers: Vec<&Case> = teachers.iter().filter_map(|index| study.cases.get(*index)).collect();
        let is_teacher = |case: &&Case| teachers.iter().any(|teacher| teacher.number == case.number);
        let pupils: Vec<&Case> = group.iter().copied().filter(|case| !is_teacher(case)).collect();
        let mut shared: BTreeMap<usize, Shared> = BTreeMap::new();
        for case in teachers.iter().chain(&pupils) {
            *shared.entry(case.surface).or_default().left.get_mut() += 1;
        }
        let site = Site {
            structure,
            shared,
            first_reduction: (runner.done.load(Ordering::Relaxed) == 0).then_some(reduction),
        };
        let began_teaching = machine.seconds();
        let training_cases: Mutex<BTreeMap<usize, Result<TrainingCase, String>>> = Mutex::default();
        let teach = |case: &Case| {
            let is_asked_for = group.iter().any(|own| own.number == case.number);
            let training_case = runner.training_case(case, &site, is_asked_for);
            let mut training_cases = training_cases.lock().unwrap_or_else(PoisonError::into_inner);
            training_cases.insert(case.number, training_case);
        };
        runner.all_of(&teachers, &site, &mut gang, store, &teach)?;
        let training_cases = training_cases.into_inner().unwrap_or_else(PoisonError::into_inner);
        let training = runner.train(&teachers, structure, training_cases);
        if !teachers.is_empty() {
            runner.tally().teaching_seconds += machine.seconds() - began_teaching;
        }
        runner.all_of(&pupils, &site, &mut gang, store, &|case| {
            runner.one(case, &site, training.as_ref())
        })?;
    }
    let mut tally = *runner.tally();
    tally.seconds = machine.seconds() - began;
    Ok(tally)
}

/// A structure whose cases are under way.
struct Site<'a> {
    structure: &'a CaseStructure,
    shared: BTreeMap<usize, Shared>,
    /// Time for its reduction (s), if it is the first of the study.
    first_reduction: Option<f64>,
}

/// Threads that may run cases at the same time.
struct Gang {
    allowed: usize,
    /// Size of the largest model that this is known of.
    largest: usize,
    /// Memory (bytes) that stands for what the system says is free.
    memory: Option<u64>,
}

impl Gang {
    /// Takes from the memory before and after a case how many there is memory for.
    fn measure(&mut self, start: Memory, end: Memory, machine: &dyn Machine) {
        let one = end.peak.saturating_sub(start.peak).max(1);
        let free = self.memory.map_or(MEMORY * end.free as f64, |budget| {
            budget.saturating_sub(start.peak) as f64
        });
        self.allowed = ((free / one as f64) as usize).clamp(1, machine.threads().max(1));
        if self.allowed < machine.threads() {
            machine.line(&format!(
                "memory for {} cases at a time, of about {:.0} MB each; --memory says how much there is",
                self.allowed,
                one as f64 / 1e6
            ));
        }
    }
}

/// What all threads share.
struct Runner<'a> {
    study: &'a Study<'a>,
    machine: &'a dyn Machine,
    writer: Mutex<Writer>,
    /// Why a line could not be written.
    failed: Mutex<Option<Error>>,
    done: AtomicUsize,
    all: usize,
    tally: Mutex<Tally>,
}

impl Runner<'_> {
    fn tally(&self) -> MutexGuard<'_, Tally> {
        self.tally.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn failure(&self) -> MutexGuard<'_, Option<Error>> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_ended(&self) -> bool {
        self.failure().is_some()
    }

    fn ended(&self) -> Result<(), Error> {
        self.failure().take().map_or(Ok(()), Err)
    }

    /// Does something with cases on one structure, in parallel.
    fn all_of(
        &self,
        cases: &[&Case],
        site: &Site<'_>,
        gang: &mut Gang,
        store: &Store,
        job: &(dyn Fn(&Case) + Sync),
    ) -> Result<(), Error> {
        let Some((first, rest)) = cases.split_first() else {
            return Ok(());
        };
        let size = site.structure.bytes();
        let mut cases = cases;
        if size > gang.largest {
            // One case alone tells what a case takes.
            gang.largest = size;
            self.machine.forget_peak_memory();
            let start = self.machine.memory();
            self.machine.on_threads(1, &|| job(first));
            if let (Some(start), Some(end)) = (start, self.machine.memory()) {
                gang.measure(start, end, self.machine);
            }
            if let Some(reduction) = site.first_reduction {
                self.estimate(store, reduction, size, gang.allowed);
            }
            cases = rest;
        }
        let next = AtomicUsize::new(0);
        let work = || {
            while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                if self.is_ended() {
                    return;
                }
                job(case);
            }
        };
        match gang.allowed.min(cases.len()) {
            0 => {}
            threads => self.machine.on_threads(threads, &work),
        }
        self.ended()
    }

    /// Runs a case, by what others taught if it learns.
    fn one(&self, case: &Case, site: &Site<'_>, training: Option<&Training>) {
        let began = self.machine.seconds();
        let structure = site.structure;
        let found = self.study.scene(case.number).and_then(|scene| {
            let interface = interface(&scene, structure, site.shared.get(&case.surface))?;
            Ok(match training.zip(case.learns) {
                Some((training, borne)) => structure.backbones_by(training, borne, &scene, &interface, &Silent)?,
                None => structure.backbones(&scene, &interface, &Silent)?,
            })
        });
        let seconds = self.machine.seconds() - began;
        self.finish(case, seconds, found.map_err(|error| error.to_string()));
    }

    /// Runs a case that others learn from, and stores what became of it if it is one of those asked for.
    fn training_case(&self, case: &Case, site: &Site<'_>, is_asked_for: bool) -> Result<TrainingCase, String> {
        let began = self.machine.seconds();
        let found = self.study.scene(case.number).and_then(|scene| {
            let interface = interface(&scene, site.structure, site.shared.get(&case.surface))?;
            Ok(site.structure.training_case(&scene, &interface, &Silent)?)
        });
        let seconds = self.machine.seconds() - began;
        let (outcome, training_case) = match found {
            Ok((modes, training_case)) => (Ok(modes), Ok(training_case)),
            Err(error) => (Err(error.to_string()), Err(error.to_string())),
        };
        if is_asked_for {
            self.finish(case, seconds, outcome);
        }
        training_case
    }

    /// What cases on a structure learn, in the order of the teachers; none, with a line why, if one of them failed: what is learned from the
    /// others alone would depend on what made it fail.
    fn train(
        &self,
        teachers: &[&Case],
        structure: &CaseStructure,
        mut training_cases: BTreeMap<usize, Result<TrainingCase, String>>,
    ) -> Option<Training> {
        let teacher = teachers.first()?;
        let mut learned = Vec::with_capacity(teachers.len());
        for case in teachers {
            match training_cases.remove(&case.number)? {
                Ok(training_case) => learned.push(training_case),
                Err(reason) => {
                    self.machine.line(&format!(
                        "every case is run with the whole joint, as case {}, which others would learn from, failed: {reason}",
                        case.number + 1
                    ));
                    return None;
                }
            }
        }
        let found = self.study.scene(teacher.number).and_then(|scene| {
            let interface = structure.interface(&scene, None)?;
            Ok(structure.train(&scene, &interface, learned)?)
        });
        let cases = teachers.len();
        match found {
            Ok(training) => {
                for (mode, sizes) in training.sizes() {
                    self.machine.line(&match sizes {
                        Ok([coordinates, points, of]) => format!(
                            "mode {mode}, learned from {cases} cases: {coordinates} coordinates beside it, and {points} of {of} points of contact"
                        ),
                        Err(error) => format!("mode {mode} is left to the whole joint in every case: {error}"),
                    });
                }
                Some(training)
            }
            Err(error) => {
                self.machine
                    .line(&format!("every case is run with the whole joint: {error}"));
                None
            }
        }
    }

    /// Stores what became of a case.
    fn finish(&self, case: &Case, seconds: f64, outcome: Result<Vec<CaseMode>, String>) {
        let record = Record { seconds, outcome };
        let structure = self.study.structures.get(case.structure).map_or("", String::as_str);
        let appended = {
            let mut writer = self.writer.lock().unwrap_or_else(PoisonError::into_inner);
            writer.append(structure, &case.address, &record)
        };
        if let Err(error) = appended {
            self.failure().get_or_insert(error);
            return;
        }
        {
            let mut tally = self.tally();
            tally.cases += 1;
            tally.case_seconds += seconds;
        }
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.machine.fraction(done as f64 / self.all as f64);
    }

    /// Tells what is to be expected, from the first case.
    fn estimate(&self, store: &Store, reduction: f64, size: usize, threads: usize) {
        let tally = *self.tally();
        if tally.cases == 0 {
            return;
        }
        let known: Vec<f64> = store.records().map(|record| record.seconds).collect();
        let own = tally.case_seconds / tally.cases as f64;
        let mean = (own + known.iter().sum::<f64>()) / (1 + known.len()) as f64;
        let left = self.all - tally.cases;
        let structures = self.study.structures.len().saturating_sub(1) as f64;
        let seconds = left as f64 * mean / threads as f64 + structures * reduction;
        self.machine.line(&format!(
            "{mean:.2} s per case ({}), {reduction:.1} s for the first structure, whose reduced model takes {:.1} MB in the cache; about {} \
             left with {threads} threads",
            match known.len() {
                0 => "measured on the first".to_owned(),
                n => format!("measured on {}", n + 1),
            },
            1e-6 * size as f64,
            duration(seconds)
        ));
    }
}

/// Seconds in words.
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// The interface of a case; the first of several with one surface makes it for all.
fn interface(
    scene: &Scene,
    structure: &CaseStructure,
    shared: Option<&Shared>,
) -> Result<Arc<SceneInterface>, analyses::Error> {
    let Some(shared) = shared else {
        return structure.interface(scene, None).map(Arc::new);
    };
    let is_last = shared.left.fetch_sub(1, Ordering::Relaxed) == 1;
    let mut known = shared.known.lock().unwrap_or_else(PoisonError::into_inner);
    let found = match known.clone() {
        Some(interface) => {
            if is_last {
                *known = None;
            }
            drop(known);
            return structure.interface(scene, Some(&interface)).map(Arc::new);
        }
        None if is_last => {
            drop(known);
            return structure.interface(scene, None).map(Arc::new);
        }
        // Others wait for what they need.
        None => Arc::new(structure.interface(scene, None)?),
    };
    *known = Some(found.clone());
    Ok(found)
}
