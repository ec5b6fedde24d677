//! `cargo xtask paper`: the results of the method paper, recomputed.

use crate::folder;
use anyhow::Result;
use microslip::commands::print;
use microslip::files::write_all;
use microslip::progress::Bar;
use microslip::{Defaults, Outcome};
use reports::Output;
use std::path::Path;
use std::time::Instant;
use studies::paper::{Paper, select};
use xtask::study;

/// A bar for many scenes.
struct Display(Bar);

impl studies::Display for Display {
    fn fraction(&self, done: f64) {
        self.0.fraction(done);
    }

    fn line(&self, text: &str) {
        self.0.line(text);
    }
}

/// Runs the command.
pub(crate) fn run(arguments: &study::Paper, defaults: &Defaults) -> Result<Outcome> {
    let began = Instant::now();
    let entries = select(&arguments.only)?;
    let out = folder(&arguments.out)?;
    let cache = defaults.cache.clone().filter(|_| !arguments.no_cache);
    let display = Display(Bar::new("scenes")?);
    let paper = Paper::compute(&entries, arguments.quick, cache, &display);
    display.0.finish();
    let paper = paper?;
    write_all(out, &paper.outputs()?)?;
    if arguments.docs {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
        write_all(folder(&docs.join("paper"))?, &paper.pictures())?;
        write_all(&docs, &[Output::new("paper.md", paper.markdown())])?;
    }
    print(&paper.account(out, began.elapsed().as_secs_f64()))?;
    Ok(if paper.is_complete() {
        Outcome::Success
    } else {
        Outcome::Incomplete
    })
}
