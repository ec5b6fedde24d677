//! Long computations: threads, progress, and how they are stopped.

use crate::error::{Exception, input};
use host::StageTimes;
use joints::progress::{Progress, Stage};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::BTreeMap;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How often Python is asked whether a signal has arrived.
const SIGNALS: Duration = Duration::from_millis(50);

/// Pools of a process by their number of threads; zero stands for one per processor.
type Pools = BTreeMap<usize, Arc<ThreadPool>>;

/// Memory of the stack of each thread (bytes), which the system gives as it is used. What a program does in its main thread is done
/// by one of the pool here.
const STACK: usize = 16 << 20;

/// The pools and the process that they belong to: the child of a fork has none of its parent's threads.
static POOLS: Mutex<(u32, Pools)> = Mutex::new((0, Pools::new()));

/// A pool of so many threads, one per processor by default.
///
/// # Errors
/// `InputError` for a number out of range, or of threads that the system does not give.
pub(crate) fn pool(threads: Option<i64>) -> Result<Arc<ThreadPool>, Exception> {
    const RANGE: &str = "it must be from 1 to 1024, or None for one per processor";
    let number = within("threads", threads, 1024, RANGE)?.unwrap_or(0);
    let mut held = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if held.0 != process {
        // Nobody is left to answer if the pools of another process were told to end.
        std::mem::forget(std::mem::replace(&mut *held, (process, Pools::new())));
    }
    if let Some(pool) = held.1.get(&number) {
        return Ok(Arc::clone(pool));
    }
    let pool = ThreadPoolBuilder::new().num_threads(number).stack_size(STACK).build();
    let pool = Arc::new(pool.map_err(|error| input(format!("starting the threads: {error}")).of("threads", RANGE))?);
    held.1.insert(number, Arc::clone(&pool));
    Ok(pool)
}

/// An argument that counts something, from 1 to `most`; `range` says so in words.
///
/// # Errors
/// `InputError`.
pub(crate) fn within(argument: &str, given: Option<i64>, most: usize, range: &str) -> Result<Option<usize>, Exception> {
    let Some(given) = given else { return Ok(None) };
    match usize::try_from(given) {
        Ok(number) if (1..=most).contains(&number) => Ok(Some(number)),
        _ => Err(input(format!("{argument} = {given} is not admissible; {range}")).of(argument, range)),
    }
}

/// A part of a stage that is done, from 0 to 1.
type Event = (Stage, f64);

/// What a computation reports to.
pub(crate) struct Monitor<'a> {
    /// Seconds per stage.
    pub(crate) times: StageTimes,
    /// None if nobody listens.
    events: Option<Sender<Event>>,
    stop: &'a AtomicBool,
    /// Dropped when the computation ends, however it does.
    _alive: Sender<Event>,
}

impl Monitor<'_> {
    fn send(&self, stage: Stage, done: f64) {
        if let Some(events) = &self.events {
            // Whoever no longer listens has ended the computation.
            let _ = events.send((stage, done));
        }
    }
}

impl Progress for Monitor<'_> {
    fn begin(&self, stage: Stage) {
        self.times.begin(stage);
        self.send(stage, 0.0);
    }

    fn fraction(&self, stage: Stage, done: f64) {
        self.send(stage, done.clamp(0.0, 1.0));
    }

    fn end(&self, stage: Stage) {
        self.times.end(stage);
        self.send(stage, 1.0);
    }

    fn interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Does work on a pool without the lock of the interpreter. `progress` is called in this thread, with the name of the stage and what of
/// it is done. What it raises stops the work at its next point, and so does Ctrl-C in the main thread; it is raised when the work
/// has stopped.
///
/// # Errors
/// What `progress` or a signal raised.
pub(crate) fn supervise<T: Send>(
    py: Python<'_>,
    pool: &ThreadPool,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Monitor<'_>) -> T + Send,
) -> PyResult<T> {
    let (sender, events) = channel::<Event>();
    let stop = &AtomicBool::new(false);
    let monitor = Monitor {
        times: StageTimes::default(),
        events: progress.map(|_| sender.clone()),
        stop,
        _alive: sender,
    };
    let (result, raised) = py.detach(move || {
        std::thread::scope(|scope| {
            let worker = scope.spawn(move || {
                let result = pool.install(|| work(&monitor));
                drop(monitor);
                result
            });
            let mut raised: Option<PyErr> = None;
            let mut asked = Instant::now();
            loop {
                let heard = events.recv_timeout(SIGNALS);
                if let Err(RecvTimeoutError::Disconnected) = heard {
                    break;
                }
                if raised.is_some() {
                    continue;
                }
                let answer = Python::attach(|py| {
                    if let (Ok((stage, done)), Some(progress)) = (heard, progress) {
                        progress.call1(py, (stage.name(), done))?;
                    }
                    if asked.elapsed() >= SIGNALS {
                        asked = Instant::now();
                        py.check_signals()?;
                    }
                    Ok(())
                });
                if let Err(error) = answer {
                    stop.store(true, Ordering::Relaxed);
                    raised = Some(error);
                }
            }
            (worker.join(), raised)
        })
    });
    let result = result.unwrap_or_else(|panic| resume_unwind(panic));
    match raised {
        Some(error) => Err(error),
        None => Ok(result),
    }
}
