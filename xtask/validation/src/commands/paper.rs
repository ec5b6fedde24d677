//! `cargo xtask paper`: the results of the method paper, recomputed.

use anyhow::Result;
use file_io::durable::Identity;
use microslip::commands::print;
use microslip::files::publish;
use microslip::progress::{self, Bar};
use microslip::{Defaults, Outcome};
use std::time::Instant;
use validation::paper::{Paper, select};
use xtask::arguments;

/// Name of the page.
const REPORT: &str = "report.html";

/// A bar for many scenes.
struct Display(Bar);

impl validation::Display for Display {
    fn fraction(&self, done: f64) {
        self.0.fraction(done);
    }

    fn line(&self, text: &str) {
        self.0.line(text);
    }
}

/// Runs the command.
pub(crate) fn run(arguments: &arguments::Paper, defaults: &Defaults) -> Result<Outcome> {
    let began = Instant::now();
    let entries = select(&arguments.only)?;
    let out = &arguments.out;
    let folder = arguments.overwrite.open(out, &Identity::new("paper", ""), &[REPORT])?;
    let cache = defaults.cache.clone().filter(|_| !arguments.no_cache);
    let display = Display(Bar::new("scenes", progress::Display::default())?);
    let paper = Paper::compute(&entries, arguments.quick, cache, &display);
    display.0.finish();
    let paper = paper?;
    publish(folder, &paper.outputs()?)?;
    print(&paper.account(out, began.elapsed().as_secs_f64()))?;
    Ok(if paper.is_complete() {
        Outcome::Success
    } else {
        Outcome::Incomplete
    })
}
