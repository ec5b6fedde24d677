//! Progress and timing of a run.

use crate::text;
use host::StageTimes;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use joints::progress::{Progress, Stage};
use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::time::Duration;

/// Parts of a bar.
const STEPS: f64 = 1000.0;

/// Shows progress on standard error: a bar with an estimate on a terminal, plain lines elsewhere.
pub struct Monitor {
    bar: Option<ProgressBar>,
    times: StageTimes,
}

impl Monitor {
    /// Begins to measure.
    ///
    /// # Errors
    /// The terminal refuses the bar.
    pub fn new() -> anyhow::Result<Self> {
        Ok(Self {
            bar: progress_bar()?,
            times: StageTimes::default(),
        })
    }

    /// Ends the display and gives the seconds per stage, zero for those that the cache made unnecessary.
    pub fn finish(&self) -> BTreeMap<String, f64> {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        self.times.seconds()
    }

    fn line(&self, text: &str) {
        line(self.bar.as_ref(), text);
    }
}

/// A bar with an estimate, if standard error is a terminal.
fn progress_bar() -> anyhow::Result<Option<ProgressBar>> {
    if !std::io::stderr().is_terminal() {
        return Ok(None);
    }
    let bar = ProgressBar::with_draw_target(Some(STEPS as u64), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{prefix:>12} [{bar:40}] {percent:>3} %  {elapsed}{left}")?;
    // Before the first sign of progress there is nothing to estimate from.
    let left = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
        if state.pos() > 0 {
            // Whether there is room to write is the display's affair.
            let _ = write!(out, ", about {} left", HumanDuration(state.eta()));
        }
    };
    bar.set_style(style.with_key("left", left).progress_chars("=> "));
    bar.enable_steady_tick(Duration::from_millis(250));
    Ok(Some(bar))
}

fn line(bar: Option<&ProgressBar>, text: &str) {
    let text = text::short(&text::visible(text));
    match bar {
        Some(bar) => bar.println(text),
        // Progress that nobody can read must not stop the run.
        None => drop(writeln!(std::io::stderr(), "{text}")),
    }
}

/// Progress of a study of many scenes: one bar on a terminal, plain lines elsewhere.
pub struct Bar {
    bar: Option<ProgressBar>,
}

impl Bar {
    /// A bar with this word before it.
    ///
    /// # Errors
    /// The terminal refuses the bar.
    pub fn new(name: &'static str) -> anyhow::Result<Self> {
        let bar = progress_bar()?;
        if let Some(bar) = &bar {
            bar.set_prefix(name);
        }
        Ok(Self { bar })
    }

    /// Moves the bar, from 0 to 1.
    pub fn fraction(&self, done: f64) {
        if let Some(bar) = &self.bar {
            bar.set_position((done.clamp(0.0, 1.0) * STEPS) as u64);
        }
    }

    /// Shows a line that stays.
    pub fn line(&self, text: &str) {
        line(self.bar.as_ref(), text);
    }

    /// Ends the display.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Progress for Monitor {
    fn begin(&self, stage: Stage) {
        if let Some(bar) = &self.bar {
            bar.reset();
            bar.set_prefix(stage.name());
        }
        self.times.begin(stage);
    }

    fn fraction(&self, _: Stage, done: f64) {
        if let Some(bar) = &self.bar {
            bar.set_position((done.clamp(0.0, 1.0) * STEPS) as u64);
        }
    }

    fn end(&self, stage: Stage) {
        let seconds = self.times.end(stage);
        self.line(&format!("{:>12} ... {seconds:.1} s", stage.name()));
    }

    fn note(&self, text: &str) {
        self.line(&format!("{:>12}     {text}", ""));
    }

    fn warn(&self, text: &str) {
        self.line(&format!("warning: {text}"));
    }

    fn echo(&self, line: &str) {
        self.line(line);
    }
}
