//! A run of the scene that was set up, by the same program.

use crate::check;
use anyhow::{Context, Result};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most events of a run that are kept; what is told beyond them is not shown.
const MOST_EVENTS: usize = 20_000;

/// Longest line that is read (bytes).
const LONGEST_LINE: u64 = 1 << 20;

/// A run that was begun.
pub(super) struct Job {
    child: Mutex<Child>,
    told: Mutex<Told>,
}

/// What a run has told.
#[derive(Default)]
struct Told {
    /// All but the progress within a stage.
    events: Vec<Value>,
    /// How far the present stage is.
    progress: Value,
    was_stopped: bool,
    /// How it ended.
    end: Option<Value>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // What a thread that panicked has left is as good as before.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Job {
    /// Begins to run a scene into a folder of results, in the place of other results there where `overwrite` says so.
    pub(super) fn start(scene: &Path, out: &Path, overwrite: bool) -> Result<Arc<Self>> {
        let program = std::env::current_exe().context("finding the program")?;
        let mut command = Command::new(program);
        command.arg("run").arg(scene).arg("--out").arg(out).arg("--json");
        if overwrite {
            command.arg("--overwrite");
        }
        command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut child = command.spawn().context("starting the run")?;
        let lines = child.stderr.take().context("listening to the run")?;
        let job = Arc::new(Self {
            child: Mutex::new(child),
            told: Mutex::default(),
        });
        let (listener, out) = (Arc::clone(&job), out.to_owned());
        std::thread::spawn(move || listener.listen(BufReader::new(lines), out));
        Ok(job)
    }

    pub(super) fn is_running(&self) -> bool {
        locked(&self.told).end.is_none()
    }

    /// Ends it. Reduced models and finished amplitudes stay in the cache.
    pub(super) fn stop(&self) {
        locked(&self.told).was_stopped = true;
        // A run that has ended needs no end.
        let _ = locked(&self.child).kill();
    }

    /// The events from a number on, and how it stands.
    pub(super) fn told(&self, from: usize) -> Value {
        let told = locked(&self.told);
        let events = told.events.get(from..).unwrap_or_default();
        json!({ "events": events, "next": told.events.len(), "progress": told.progress, "end": told.end })
    }

    /// Listens until the run ends.
    fn listen(&self, mut lines: impl BufRead, out: PathBuf) {
        let mut line = Vec::new();
        let mut error = String::new();
        while let Ok(1..) = (&mut lines).take(LONGEST_LINE).read_until(b'\n', &mut line) {
            let text = String::from_utf8_lossy(&line).trim_end().to_owned();
            let event = serde_json::from_str(&text)
                .ok()
                .filter(Value::is_object)
                .unwrap_or_else(|| json!({ "event": "text", "text": text }));
            // What is no event is of a program that could not even begin.
            if event["event"] == "error" || event["event"] == "text" {
                error = event["text"].as_str().unwrap_or_default().to_owned();
            }
            let mut told = locked(&self.told);
            match event["event"] == "progress" {
                true => told.progress = event,
                false if told.events.len() < MOST_EVENTS => told.events.push(event),
                false => {}
            }
            line.clear();
        }
        let status = locked(&self.child).wait();
        let code = status.ok().and_then(|status| status.code());
        let answer = match code {
            Some(0 | 3) => check::read(&out).map(|(summary, _)| reports::answer_lines(&summary)),
            _ => Ok(String::new()),
        };
        let error = match &answer {
            Err(unreadable) => format!("{unreadable:#}"),
            Ok(_) => error,
        };
        let mut told = locked(&self.told);
        told.end = Some(json!({
            "code": code,
            "stopped": told.was_stopped,
            "answer": answer.unwrap_or_default(),
            "error": error,
            // The results of something else, which the reader may give up.
            "occupied": error.contains("--overwrite"),
        }));
    }
}
