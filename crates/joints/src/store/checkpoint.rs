//! Finished parts of a run under way, so that an interrupted one goes on where it stopped.
//!
//! One line per part, an amplitude or a realisation, written when it is done: a checksum, and JSON. Numbers are written so
//! that they read back bit by bit, and parts are independent: what is taken from here and what is computed afresh make the
//! same as one run. A line of which a bit has changed counts as not done.

use super::key::Key;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The files that let a run resume. They outlive the run, until its results are safe.
#[derive(Clone, Debug, Default)]
pub struct Checkpoints(Vec<PathBuf>);

impl Checkpoints {
    /// Removes the files. To be called when the results are where they shall be, or are not to be kept; a run that ends
    /// before resumes from them.
    pub fn remove(&self) {
        // One that stays is found again by the same run, and changes no result.
        let _ = self.clone().try_remove();
    }

    /// Removes the files, and gives those that stay.
    pub fn try_remove(self) -> Self {
        let stays = |path: &PathBuf| {
            let removed = std::fs::remove_file(path);
            removed.is_err_and(|error| error.kind() != ErrorKind::NotFound)
        };
        Self(self.0.into_iter().filter(stays).collect())
    }

    /// Whether there are no files.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Takes the files of another run too.
    pub fn extend(&mut self, others: Self) {
        self.0.extend(others.0);
    }
}

/// Parts that are done, by their number, and where they are written down.
pub struct Checkpoint<T> {
    finished: BTreeMap<usize, T>,
    path: PathBuf,
    /// None if the folder cannot be written, or nothing is to be kept.
    file: Option<Mutex<File>>,
    /// What else the checksums of lines cover.
    key: String,
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
            key: String::new(),
        }
    }
}

impl<T: DeserializeOwned> Checkpoint<T> {
    /// Reads what an earlier run with the same key has finished of `what`, and goes on writing there. Whatever is not as it
    /// was written, such as a line that was cut off, counts as not done.
    pub fn open(directory: &Path, what: &str, key: &Key) -> Self {
        let path = directory.join(format!("{what}-{}.jsonl", key.short()));
        let text = file_io::input::read(&path, file_io::input::Kind::Checkpoint).unwrap_or_default();
        let part = |line: &[u8]| {
            let line: Line<T> = serde_json::from_slice(file_io::durable::unseal_line(&key.0, line)?).ok()?;
            Some((line.index, line.value))
        };
        let finished = text.split(|byte| *byte == b'\n').filter_map(part).collect();
        let mut file = std::fs::create_dir_all(directory)
            .and_then(|()| File::options().create(true).append(true).open(&path))
            .ok();
        if let Some(file) = file.as_mut().filter(|_| !text.is_empty() && !text.ends_with(b"\n")) {
            // Whether this succeeds shows in the next line only, which would then count as not done.
            let _ = file.write_all(b"\n");
        }
        Self {
            finished,
            path,
            file: file.map(Mutex::new),
            key: key.0.clone(),
        }
    }

    /// Number of finished parts.
    pub fn n_finished(&self) -> usize {
        self.finished.len()
    }

    /// The finished parts.
    pub fn values(&self) -> impl Iterator<Item = &T> {
        self.finished.values()
    }

    /// The parts from number 0 on without a gap.
    pub fn leading(&self) -> Vec<T>
    where
        T: Clone,
    {
        (0..).map_while(|index| self.finished.get(&index).cloned()).collect()
    }

    /// Whether a part is finished.
    pub fn holds(&self, index: usize) -> bool {
        self.finished.contains_key(&index)
    }

    /// Writes down a part, which may be given by reference. A run goes on without its checkpoint if that fails: it is a
    /// convenience.
    pub fn add(&self, index: usize, value: impl Serialize) {
        let Some(file) = &self.file else { return };
        let Ok(json) = serde_json::to_vec(&Line { index, value }) else {
            return;
        };
        let line = file_io::durable::seal_line(&self.key, &json);
        let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = file.write_all(&line).and_then(|()| file.sync_data());
    }

    /// The run is complete: what was found at the beginning, and the file, which stays until the results are safe.
    pub fn complete(self) -> (BTreeMap<usize, T>, Checkpoints) {
        let kept = self.file.is_some().then_some(self.path);
        (self.finished, Checkpoints(kept.into_iter().collect()))
    }
}
