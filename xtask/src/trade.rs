//! `cargo xtask trade`: what accuracy costs.

use crate::folder;
use anyhow::{Context, Result};
use microslip::commands::{SceneArguments, print};
use microslip::files::write_all;
use microslip::{Defaults, Outcome};
use std::io::Write;
use std::path::PathBuf;
use studies::trade::{Launcher, Plan};

/// Arguments of the command.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The scene whose settings are varied; without it the built-in scene brb-flat.
    #[command(flatten)]
    scene: SceneArguments,
    /// Dials to measure [default: all].
    #[arg(long, value_name = "DIAL", num_args = 1..)]
    only: Vec<String>,
    /// A coarse mesh and only what takes seconds on it, for a look.
    #[arg(long)]
    quick: bool,
    /// Folder for the results and the runs, made if missing; finished runs of the same settings found there are kept.
    #[arg(long, value_name = "DIR", default_value = "results/trade")]
    out: PathBuf,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments, defaults: &Defaults) -> Result<Outcome> {
    let scene = arguments.scene.read(defaults)?;
    let plan = Plan::try_new(scene, &arguments.only, arguments.quick)?;
    let runs = arguments.out.join("runs");
    let launcher = Launcher {
        program: std::env::current_exe().context("finding this program")?,
        arguments: vec!["brb".into()],
    };
    // Progress that nobody can read must not stop the run.
    let trade = plan.measure(folder(&runs)?, &launcher, |line| {
        drop(writeln!(std::io::stderr(), "{line}"));
    })?;
    write_all(&arguments.out, &trade.outputs)?;
    let names = trade.outputs.each_ref().map(|o| o.name.as_str()).join(", ");
    print(&format!(
        "\n{}\nwritten to {}: {names}\n",
        trade.table,
        arguments.out.display()
    ))?;
    for (setting, reason) in &trade.exceeded {
        print(&format!("{setting}: {reason}\n"))?;
    }
    Ok(if trade.failed == 0 && trade.exceeded.is_empty() {
        Outcome::Success
    } else {
        Outcome::Incomplete
    })
}
