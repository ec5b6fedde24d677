//! `cargo xtask paper`: the results of the method paper, recomputed.

use crate::folder;
use anyhow::Result;
use microslip::commands::print;
use microslip::files::write_all;
use microslip::progress::Bar;
use microslip::{Defaults, Outcome};
use reports::Output;
use std::path::{Path, PathBuf};
use std::time::Instant;
use studies::paper::{Paper, select};

/// Arguments of the command.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Entries to compute [default: all].
    #[arg(long, value_name = "ID", num_args = 1..)]
    only: Vec<String>,
    /// Folder for the results, made if missing; other files in it are left alone.
    #[arg(long, value_name = "DIR", default_value = "results/paper")]
    out: PathBuf,
    /// Neither read nor store reduced models and finished scenes in results/.cache.
    #[arg(long)]
    no_cache: bool,
    /// A coarse mesh and few amplitudes, for a look: the figures are not those of the paper's mesh.
    #[arg(long)]
    quick: bool,
    /// Also write docs/paper.md and its pictures.
    #[arg(long, conflicts_with_all = ["only", "quick"])]
    docs: bool,
}

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
pub(crate) fn run(arguments: &Arguments, defaults: &Defaults) -> Result<Outcome> {
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
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
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
