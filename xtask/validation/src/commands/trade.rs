//! `cargo xtask trade`: what accuracy costs.

use anyhow::{Context, Result};
use host::results_of;
use microslip::commands::print;
use microslip::files::publish;
use microslip::{Defaults, Outcome};
use std::io::Write;
use validation::trade::{Launcher, Plan};
use xtask::arguments;

/// Runs the command.
pub(crate) fn run(arguments: &arguments::Trade, defaults: &Defaults) -> Result<Outcome> {
    let scene = arguments.scene.read(defaults)?.scene;
    let identity = results_of("trade", &scene);
    let plan = Plan::try_new(scene, &arguments.only, arguments.quick, &arguments.meshes)?;
    let results = arguments.overwrite.open(&arguments.out, &identity, &[])?;
    let runs = arguments.out.join("runs");
    std::fs::create_dir_all(&runs).with_context(|| format!("making the folder {}", runs.display()))?;
    let launcher = Launcher {
        program: std::env::current_exe().context("finding this program")?,
        // The runs are parts of these results, whatever scene was varied before.
        arguments: vec!["brb".into(), "--overwrite".into()],
    };
    // Progress that nobody can read must not stop the run.
    let trade = plan.measure(&runs, &launcher, |line| {
        drop(writeln!(std::io::stderr(), "{line}"));
    })?;
    publish(results, &trade.outputs)?;
    let names = trade
        .outputs
        .iter()
        .map(|o| o.name.as_str())
        .collect::<Vec<_>>()
        .join(", ");
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
