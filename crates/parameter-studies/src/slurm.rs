//! Parts of a study as tasks of a Slurm job array.
//!
//! The driver submits one task per part, follows the queue, and submits a part again that has left it unfinished, after a node died, a time
//! limit or a kill. What is done is known from the store alone, never from what the scheduler says of a task.

use crate::Error;
use crate::case::Part;
use crate::run::Machine;
use crate::store::Store;
use crate::study::Study;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folder for script and logs within that of the results.
const FOLDER: &str = "slurm";

/// Looks at the queue for which a task may be missing before it counts as ended: a moment after its submission it may not be listed yet.
const LOOKS: usize = 2;

/// What is submitted.
pub struct Job {
    /// Program and arguments that run a part, to which the number of the part is added as `K/N`.
    pub command: Vec<String>,
    /// Number of parts.
    pub parts: usize,
    /// Further options of `sbatch`.
    pub options: Vec<String>,
    /// Times that a part is submitted at most.
    pub tries: usize,
    /// Time between two looks at the queue (s).
    pub poll: f64,
    /// Folder of the results.
    pub folder: PathBuf,
    /// Whether failed cases are run again.
    pub retry: bool,
}

/// A text as one word of a shell.
fn word(text: &str) -> String {
    format!("'{}'", text.replace('\'', "'\\''"))
}

/// Numbers as Slurm writes arrays: `1-3,7`.
fn ranges(numbers: &BTreeSet<usize>) -> String {
    let sorted: Vec<usize> = numbers.iter().copied().collect();
    let runs = sorted.chunk_by(|a, b| a + 1 == *b).map(|run| match run {
        [one] => one.to_string(),
        [first, .., last] => format!("{first}-{last}"),
        [] => String::new(),
    });
    runs.collect::<Vec<_>>().join(",")
}

/// Task numbers in a list as `squeue` writes them: `1-3,7`, also with `%2` for the most at a time.
fn tasks(text: &str) -> Vec<usize> {
    let text = text.trim_matches(['[', ']']);
    let text = text.split('%').next().unwrap_or_default();
    let number = |text: &str| text.parse::<usize>().ok();
    text.split(',')
        .filter_map(|run| match run.split_once('-') {
            Some((first, last)) => Some(number(first)?..=number(last)?),
            None => number(run).map(|one| one..=one),
        })
        .flatten()
        .collect()
}

impl Job {
    fn script(&self) -> String {
        let words: Vec<String> = self.command.iter().map(|text| word(text)).collect();
        format!(
            "#!/bin/sh\n# Runs one part of a study. What other tasks have finished is skipped.\nexec {} --part \"$SLURM_ARRAY_TASK_ID\"/{} \
             --threads \"${{SLURM_CPUS_PER_TASK:-1}}\"\n",
            words.join(" "),
            self.parts
        )
    }

    fn logs(&self) -> PathBuf {
        self.folder.join(FOLDER)
    }

    /// Submits parts, and gives the number of the job.
    fn submit(&self, script: &Path, parts: &BTreeSet<usize>) -> Result<String, Error> {
        let mut command = Command::new("sbatch");
        command
            .arg("--parsable")
            .arg(format!("--array={}", ranges(parts)))
            .arg(format!("--output={}", self.logs().join("%A-%a.log").display()))
            .arg("--job-name=microslip-study")
            .args(&self.options)
            .arg(script);
        let said = output(&mut command, "sbatch")?;
        // The number, and on several clusters the cluster behind a semicolon.
        let job = said.trim().split(';').next().unwrap_or_default().to_owned();
        match job.parse::<u64>() {
            Ok(_) => Ok(job),
            Err(_) => Err(Error::Scheduler {
                program: "sbatch",
                reason: format!(
                    "`{}` is no number of a job; call it by hand to see what it says",
                    said.trim()
                ),
            }),
        }
    }

    /// The tasks of a job that wait or run; none if Slurm does not know the job any more.
    fn queued(&self, job: &str) -> Result<BTreeSet<usize>, Error> {
        let mut command = Command::new("squeue");
        command.args(["--noheader", "--format=%K", "--jobs", job]);
        match output(&mut command, "squeue") {
            Ok(listed) => Ok(listed.lines().flat_map(|line| tasks(line.trim())).collect()),
            Err(Error::Scheduler { reason, .. }) if reason.contains("Invalid job id") => Ok(BTreeSet::new()),
            Err(error) => Err(error),
        }
    }

    /// Parts with cases that are not in the store, with how many each.
    fn unfinished(&self, study: &Study<'_>, store: &Store, retry: bool) -> BTreeMap<usize, usize> {
        let parts = 1..=self.parts;
        let pending = parts.map(|number| {
            let cases = study.part(Some(Part { number, of: self.parts }));
            (number, study.pending(cases, store, retry).len())
        });
        pending.filter(|(_, pending)| *pending > 0).collect()
    }

    /// Runs all pending cases as tasks, and returns when they are in the store.
    ///
    /// # Errors
    /// [`Error::Scheduler`]; [`Error::Unfinished`]; files that cannot be written or read.
    pub fn run(&self, study: &Study<'_>, store: &mut Store, machine: &dyn Machine) -> Result<(), Error> {
        let logs = self.logs();
        let fail = |path: &Path, operation| {
            let path = path.to_owned();
            move |source| Error::File {
                path,
                operation,
                source,
            }
        };
        std::fs::create_dir_all(&logs).map_err(fail(&logs, "making the folder"))?;
        let script = logs.join("part.sh");
        std::fs::write(&script, self.script()).map_err(fail(&script, "writing"))?;
        let all: usize = study.part(None).len();
        let mut tried: BTreeMap<usize, usize> = BTreeMap::new();
        // Jobs with the tasks that have not ended, and for how many looks each was missing.
        let mut under_way: BTreeMap<String, BTreeMap<usize, usize>> = BTreeMap::new();
        let mut retry = self.retry;
        loop {
            store.refresh()?;
            let unfinished = self.unfinished(study, store, retry);
            retry = false;
            machine.fraction((all - unfinished.values().sum::<usize>()) as f64 / all.max(1) as f64);
            let busy: BTreeSet<usize> = under_way.values().flat_map(|tasks| tasks.keys().copied()).collect();
            if unfinished.is_empty() && busy.is_empty() {
                return Ok(());
            }
            let idle = unfinished.keys().filter(|part| !busy.contains(part));
            let again = |part: &&usize| tried.get(part).copied().unwrap_or(0) < self.tries;
            let wanted: BTreeSet<usize> = idle.filter(again).copied().collect();
            if !wanted.is_empty() {
                let job = self.submit(&script, &wanted)?;
                let repeated = wanted.iter().filter(|part| tried.contains_key(part)).count();
                let remark = match repeated {
                    0 => String::new(),
                    n => format!(", {n} of them again, as they ended before they were done"),
                };
                machine.line(&format!(
                    "job {job}: parts {} of {}{remark}",
                    ranges(&wanted),
                    self.parts
                ));
                wanted.iter().for_each(|part| *tried.entry(*part).or_default() += 1);
                under_way.insert(job, wanted.into_iter().map(|part| (part, 0)).collect());
            } else if busy.is_empty() {
                return Err(Error::Unfinished {
                    pending: unfinished.values().sum(),
                    cases: all,
                    parts: ranges(&unfinished.keys().copied().collect()),
                    tries: self.tries,
                    logs,
                });
            }
            machine.wait(self.poll);
            for (job, tasks) in &mut under_way {
                let queued = self.queued(job)?;
                tasks.retain(|task, missing| {
                    *missing = if queued.contains(task) { 0 } else { *missing + 1 };
                    *missing < LOOKS
                });
            }
            under_way.retain(|_, tasks| !tasks.is_empty());
        }
    }
}

/// What a program of the scheduler prints.
fn output(command: &mut Command, program: &'static str) -> Result<String, Error> {
    let refused = |reason: String| Error::Scheduler { program, reason };
    let output = command.output().map_err(|error| {
        refused(format!(
            "it cannot be called: {error}; run this where Slurm is installed, or take --engine local or --part K/N"
        ))
    })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(refused(format!("{}; correct it with --slurm-option", said.trim())));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn arrays_are_written_and_read_as_slurm_does() {
        let numbers = BTreeSet::from([1, 2, 3, 5, 8, 9]);
        assert_eq!(ranges(&numbers), "1-3,5,8-9");
        assert_eq!(tasks("1-3,5,8-9"), [1, 2, 3, 5, 8, 9]);
        assert_eq!(tasks("[2-4%2]"), [2, 3, 4]);
        assert_eq!(tasks("N/A"), [0; 0]);
    }

    #[test]
    fn scripts_quote_what_users_name() {
        let job = Job {
            command: vec!["micro slip".into(), "it's.json".into()],
            parts: 4,
            options: Vec::new(),
            tries: 3,
            poll: 1.0,
            folder: PathBuf::from("out"),
            retry: false,
        };
        let script = job.script();
        assert!(
            script.contains(r#"exec 'micro slip' 'it'\''s.json' --part "$SLURM_ARRAY_TASK_ID"/4 --threads"#),
            "{script}"
        );
    }
}
