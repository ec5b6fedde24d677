//! Threads and interruptions.

use super::bench::Bench;
use super::case::Case;
use super::findings::Findings;
use analyses::{Error, Run, run};
use anyhow::{Context, Result, bail};
use joints::Options;
use joints::progress::{Progress, Silent, Stage};
use std::sync::atomic::{AtomicUsize, Ordering};

pub(super) static CASES: &[Case] = &[
    Case {
        name: "threads-1-and-64",
        change: "one thread, and many more than processors, from the mesh to the backbone",
        expected: "the same results to the last bit",
        run: threads,
    },
    Case {
        name: "interrupted-and-resumed",
        change: "interrupted after every number of amplitudes, the last of which was written down in part, and resumed",
        expected: "the results of an uninterrupted run to the last bit",
        run: interrupted,
    },
];

/// Everything that a run found, in digits that read back to the last bit.
fn digits(run: &Run) -> String {
    let amplitudes = run.amplitudes().iter();
    let amplitudes = amplitudes.map(|a| format!("{:?} {:?} {:?}\n", a.point, a.fields, a.response_acceleration));
    format!(
        "{:?} {:?} {:?}\n{}",
        run.frequencies,
        run.prestress.solution.displacement,
        run.model.facts,
        amplitudes.collect::<String>()
    )
}

fn threads(bench: &Bench) -> Result<Findings> {
    let with = |n: usize| -> Result<Run> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build()?;
        Ok(pool.install(|| run(&bench.scene, &Options::default(), &Silent))?)
    };
    let (one, many) = (with(1)?, with(64)?);
    let mut findings = Findings::default();
    findings.sound("", &one)?;
    findings.that("one and 64 threads, same digits", digits(&one) == digits(&many));
    findings.that(
        "as with a reduced model from the cache",
        digits(&one) == digits(&bench.base),
    );
    findings.outcome = format!("{} characters of digits agree", digits(&one).len());
    Ok(findings)
}

/// Stops a run after so many amplitudes.
struct Impatient {
    left: AtomicUsize,
}

impl Progress for Impatient {
    fn fraction(&self, stage: Stage, _: f64) {
        if stage == Stage::Backbone {
            let _ = self
                .left
                .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1));
        }
    }

    fn interrupted(&self) -> bool {
        self.left.load(Ordering::Relaxed) == 0
    }
}

fn interrupted(bench: &Bench) -> Result<Findings> {
    // Alone, a thread stops where it is told to; the others of a pool would finish what they have begun.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let undisturbed = digits(&bench.base);
    let mut findings = Findings::default();
    let last = bench.scene.analyses.backbone.amplitudes;
    for stop in 1..last {
        let watch = Impatient { left: stop.into() };
        let stopped = pool.install(|| run(&bench.scene, &bench.options(), &watch));
        findings.that(
            &format!("stopped after {stop}"),
            matches!(stopped, Err(Error::Solver(cqsma_solver::Error::Interrupted))),
        );
        let mut entries = std::fs::read_dir(&bench.folder)?.filter_map(|entry| Some(entry.ok()?.path()));
        let Some(path) = entries.find(|path| path.extension().is_some_and(|e| e == "jsonl")) else {
            bail!("an interrupted run left nothing to resume from");
        };
        let text = std::fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
        // A power cut in the middle of a line.
        std::fs::write(&path, &text[..text.len() - 20])?;
        let resumed = bench.run_scene(&bench.scene)?;
        findings.count(&resumed);
        findings.that(
            &format!("resumed after {stop}, same digits"),
            digits(&resumed) == undisturbed,
        );
        findings.that(&format!("nothing left behind after {stop}"), !path.exists());
    }
    findings.outcome = format!("interrupted at {} points, the same digits", last - 1);
    Ok(findings)
}
