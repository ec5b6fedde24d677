//! Finished parts of a run under way, so that an interrupted one goes on where it stopped.
//!
//! One line of JSON per part, an amplitude or a realisation, written when it is done. Numbers are written so that they read
//! back bit by bit, and parts are independent: what is taken from here and what is computed afresh make the same as one run.

use super::key::Key;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Parts that are done, by their number, and where they are written down.
pub(crate) struct Checkpoint<T> {
    finished: BTreeMap<usize, T>,
    path: PathBuf,
    /// None if the folder cannot be written, or nothing is to be kept.
    file: Option<Mutex<File>>,
}

#[derive(Serialize, Deserialize)]
struct Line<T> {
    index: usize,
    value: T,
}

impl<T> Default for Checkpoint<T> {
    fn default() -> Self {
        Self {
            finished: BTreeMap::new(),
            path: PathBuf::new(),
            file: None,
        }
    }
}

impl<T: DeserializeOwned> Checkpoint<T> {
    /// Reads what an earlier run with the same key has finished of `what`, and goes on writing there. Whatever cannot be
    /// read, such as a line that was cut off, counts as not done.
    pub(crate) fn open(directory: &Path, what: &str, key: &Key) -> Self {
        let path = directory.join(format!("{what}-{}.jsonl", key.short()));
        let text = input_files::read_text(&path, input_files::Kind::Checkpoint).unwrap_or_default();
        let finished = text
            .lines()
            .filter_map(|line| serde_json::from_str::<Line<T>>(line).ok())
            .map(|line| (line.index, line.value))
            .collect();
        let mut file = std::fs::create_dir_all(directory)
            .and_then(|()| File::options().create(true).append(true).open(&path))
            .ok();
        if let Some(file) = file.as_mut().filter(|_| !text.is_empty() && !text.ends_with('\n')) {
            // Whether this succeeds shows in the next line only, which would then count as not done.
            let _ = file.write_all(b"\n");
        }
        Self {
            finished,
            path,
            file: file.map(Mutex::new),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.finished.len()
    }

    pub(crate) fn holds(&self, index: usize) -> bool {
        self.finished.contains_key(&index)
    }

    /// Writes down a part, which may be given by reference. A run goes on without its checkpoint if that fails: it is a
    /// convenience.
    pub(crate) fn add(&self, index: usize, value: impl Serialize) {
        let Some(file) = &self.file else { return };
        if let Ok(mut line) = serde_json::to_vec(&Line { index, value }) {
            line.push(b'\n');
            let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
            let _ = file.write_all(&line).and_then(|()| file.sync_data());
        }
    }

    /// The run is complete: what was found at the beginning; the file is of no more use.
    pub(crate) fn complete(self) -> BTreeMap<usize, T> {
        if self.file.is_some() {
            let _ = std::fs::remove_file(&self.path);
        }
        self.finished
    }
}
