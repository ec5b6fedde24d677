//! What a command shows while it works, and in the end: to a person, or as JSON to a program.

use crate::text;
use anyhow::Result;
use host::StageTimes;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use joints::progress::{Amplitude, Expected, Progress, Stage};
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Parts of a bar.
const STEPS: f64 = 1000.0;

/// Time between two events of progress, at least.
const BETWEEN: Duration = Duration::from_millis(100);

/// How a command shows what it does.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct Display {
    /// For programs: lines of JSON on standard error, one for each event, and in the end an object with the folder of the results and the answer on
    /// standard output.
    #[arg(long)]
    json: bool,
    /// Show nothing before the end but warnings and errors.
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
}

/// A line of JSON.
#[derive(Serialize)]
#[serde(tag = "event", rename_all = "lowercase")]
enum Event<'a> {
    Begin {
        stage: &'a str,
    },
    Progress {
        stage: &'a str,
        fraction: f64,
        seconds_left: Option<f64>,
    },
    Point {
        mode: usize,
        amplitude_m: f64,
        frequency_hz: f64,
        damping_ratio: Option<f64>,
    },
    End {
        stage: &'a str,
        seconds: f64,
    },
    Note {
        text: String,
    },
    Echo {
        text: String,
    },
    Warning {
        text: String,
    },
    Error {
        text: String,
    },
}

impl Event<'_> {
    /// What a person reads of it, in a line that stays.
    fn line(&self) -> Option<String> {
        match self {
            Self::Begin { .. } | Self::Progress { .. } | Self::Point { .. } => None,
            Self::End { stage, seconds } => Some(format!("{stage:>12} ... {seconds:.1} s")),
            Self::Note { text } => Some(format!("{:>12}     {text}", "")),
            Self::Echo { text } => Some(text.clone()),
            Self::Warning { text } => Some(format!("warning: {text}")),
            Self::Error { text } => Some(format!("error: {text}")),
        }
    }

    fn is_trouble(&self) -> bool {
        matches!(self, Self::Warning { .. } | Self::Error { .. })
    }
}

/// A text that may hold what files hold.
fn safe(text: &str) -> String {
    text::short(&text::visible(text))
}

impl Display {
    /// Tells an error with its causes.
    pub fn error(self, error: &anyhow::Error) {
        self.tell(&Event::Error {
            text: text::of_error(error),
        });
    }

    /// Tells what is wrong with what was found.
    pub fn warn(self, text: &str) {
        self.tell(&Event::Warning { text: safe(text) });
    }

    /// Ends a command: prints the `text`, or where the results are with the answer.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn conclude(self, results: &Path, answer: &impl Serialize, text: &str) -> Result<()> {
        match self.json {
            true => text::print(
                &(text::json(&json!({ "results": results.display().to_string(), "answer": answer }))? + "\n"),
            ),
            false => text::print(text),
        }
    }

    /// Writes an event to standard error. Who cannot be told is not told: progress that nobody can read must not stop a run.
    fn tell(self, event: &Event<'_>) {
        let line = match self.json {
            true => text::json(event).ok(),
            false => event.line().filter(|_| !self.quiet || event.is_trouble()),
        };
        if let Some(line) = line {
            let _ = writeln!(std::io::stderr(), "{line}");
        }
    }

    fn has_bar(self) -> bool {
        !self.json && !self.quiet && std::io::stderr().is_terminal()
    }
}

/// Where events go.
struct Screen {
    display: Display,
    /// If there is a terminal for it.
    bar: Option<ProgressBar>,
    /// When progress was told last.
    told: Mutex<Option<Instant>>,
    left: Arc<Mutex<Left>>,
}

/// Seconds that were left, and when.
type Left = Option<(Instant, f64)>;

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Screen {
    fn new(display: Display) -> Result<Self> {
        let left = Arc::default();
        Ok(Self {
            display,
            bar: display.has_bar().then(|| progress_bar(&left)).transpose()?,
            told: Mutex::default(),
            left,
        })
    }

    fn begin(&self, stage: &str) {
        if let Some(bar) = &self.bar {
            bar.reset();
            bar.set_prefix(stage.to_owned());
        }
        *lock(&self.told) = None;
        self.tell(&Event::Begin { stage });
    }

    /// Tells what is done of a stage, and what is `left` of all (s) if that is known.
    fn fraction(&self, stage: &str, fraction: f64, left: impl FnOnce() -> Option<f64>) {
        if let Some(bar) = &self.bar {
            bar.set_position((fraction * STEPS) as u64);
        }
        let mut told = lock(&self.told);
        if told.is_none_or(|told| told.elapsed() >= BETWEEN) {
            *told = Some(Instant::now());
            let seconds_left = left();
            *lock(&self.left) = seconds_left.map(|left| (Instant::now(), left));
            self.tell(&Event::Progress {
                stage,
                fraction,
                seconds_left,
            });
        }
    }

    fn tell(&self, event: &Event<'_>) {
        match (&self.bar, event.line()) {
            (Some(bar), Some(line)) => bar.println(line),
            (Some(_), None) => {}
            (None, _) => self.display.tell(event),
        }
    }

    fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// A bar with what is left of all.
fn progress_bar(left: &Arc<Mutex<Left>>) -> Result<ProgressBar> {
    let bar = ProgressBar::with_draw_target(Some(STEPS as u64), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{prefix:>12} [{bar:40}] {percent:>3} %  {elapsed}{left}")?;
    let left = Arc::clone(left);
    let left = move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
        if let Some((then, left)) = *lock(&left) {
            let left = Duration::from_secs_f64(left).saturating_sub(then.elapsed());
            // Whether there is room to write is the display's affair.
            let _ = write!(out, ", about {} left of all", HumanDuration(left));
        }
    };
    bar.set_style(style.with_key("left", left).progress_chars("=> "));
    bar.enable_steady_tick(Duration::from_millis(250));
    Ok(bar)
}

/// Progress and timing of a run.
pub struct Monitor {
    screen: Screen,
    times: StageTimes,
    /// Whether amplitudes are told.
    is_itself: bool,
}

impl Monitor {
    /// Begins to measure.
    ///
    /// # Errors
    /// The terminal refuses the bar.
    pub fn new(display: Display) -> Result<Self> {
        Ok(Self {
            screen: Screen::new(display)?,
            times: StageTimes::default(),
            is_itself: true,
        })
    }

    /// The same for a run beside that of the scene, whose amplitudes are not told.
    #[must_use]
    pub fn beside(self) -> Self {
        Self {
            is_itself: false,
            ..self
        }
    }

    /// Ends the display and gives the seconds per stage, zero for those that the cache made unnecessary.
    pub fn finish(&self) -> BTreeMap<String, f64> {
        self.screen.finish();
        self.times.seconds()
    }
}

impl Progress for Monitor {
    fn expect(&self, stage: Stage, expected: Expected) {
        self.times.expect(stage, expected);
    }

    fn begin(&self, stage: Stage) {
        self.screen.begin(stage.name());
        self.times.begin(stage);
        self.fraction(stage, 0.0);
    }

    fn fraction(&self, stage: Stage, done: f64) {
        let done = self.times.fraction(stage, done);
        self.screen.fraction(stage.name(), done, || self.times.left());
    }

    fn amplitude(&self, found: &Amplitude) {
        if self.is_itself {
            self.screen.tell(&Event::Point {
                mode: found.mode,
                amplitude_m: found.amplitude_m,
                frequency_hz: found.frequency_hz,
                damping_ratio: found.damping_ratio,
            });
        }
    }

    fn end(&self, stage: Stage) {
        let seconds = self.times.end(stage);
        self.screen.tell(&Event::End {
            stage: stage.name(),
            seconds,
        });
    }

    fn note(&self, text: &str) {
        self.screen.tell(&Event::Note { text: safe(text) });
    }

    fn warn(&self, text: &str) {
        self.screen.tell(&Event::Warning { text: safe(text) });
    }

    fn echo(&self, line: &str) {
        self.screen.tell(&Event::Echo { text: safe(line) });
    }
}

/// Progress of a study of many scenes: one stage.
pub struct Bar {
    screen: Screen,
    name: &'static str,
    began: Instant,
    is_over: AtomicBool,
}

impl Bar {
    /// A study that is called so.
    ///
    /// # Errors
    /// The terminal refuses the bar.
    pub fn new(name: &'static str, display: Display) -> Result<Self> {
        let screen = Screen::new(display)?;
        screen.begin(name);
        Ok(Self {
            screen,
            name,
            began: Instant::now(),
            is_over: AtomicBool::new(false),
        })
    }

    /// Whether lines are all that a person sees of it.
    pub fn is_plain(&self) -> bool {
        let Display { json, quiet } = self.screen.display;
        self.screen.bar.is_none() && !json && !quiet
    }

    /// Tells what is done, from 0 to 1.
    pub fn fraction(&self, done: f64) {
        let done = done.clamp(0.0, 1.0);
        self.screen.fraction(self.name, done, || self.left(done));
    }

    /// Seconds that are left at the pace so far.
    pub fn left(&self, done: f64) -> Option<f64> {
        (done > 0.0).then(|| self.began.elapsed().as_secs_f64() * (1.0 / done - 1.0))
    }

    /// Shows a line that stays.
    pub fn line(&self, text: &str) {
        self.screen.tell(&Event::Echo { text: safe(text) });
    }

    /// Ends the display.
    pub fn finish(&self) {
        self.screen.finish();
        // What a person sees at the end of a study are its counts.
        if self.screen.display.json && !self.is_over.swap(true, Ordering::Relaxed) {
            self.screen.tell(&Event::End {
                stage: self.name,
                seconds: self.began.elapsed().as_secs_f64(),
            });
        }
    }
}
