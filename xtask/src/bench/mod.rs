//! The benchmark set: figures of one run, so that ratios hold even where times do not.
mod kernel;
mod solver;

use crate::files::{self, Output};
use crate::progress::Monitor;
use anyhow::{Context, Result};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Options of `bench`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Write the figures to this file as well.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Only the kernel: seconds instead of minutes.
    #[arg(long, conflicts_with = "scaling")]
    kernel: bool,
    /// Instead, how the cost grows with the number of interface elements and of points per element: some ten minutes.
    #[arg(long)]
    scaling: bool,
    /// Draw what `--scaling` measured (SVG).
    #[arg(long, value_name = "FILE", requires = "scaling")]
    plot: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let mut figures = json!({ "processor": processor() });
    let show = |figures: &mut Value, name: &str, (value, table): (Value, String)| {
        figures[name] = value;
        crate::print(&table)
    };
    if arguments.scaling {
        let (value, table, picture) = solver::scaling(&Monitor::new()?)?;
        show(&mut figures, "scaling", (value, table))?;
        if let Some(path) = &arguments.plot {
            write(path, picture)?;
        }
    } else {
        show(&mut figures, "kernel", kernel::figures()?)?;
    }
    if !arguments.kernel && !arguments.scaling {
        let (parts, table) = solver::figures(&Monitor::new()?)?;
        crate::print(&table)?;
        for (name, part) in parts {
            figures[name] = part;
        }
    }
    if let Some(path) = &arguments.json {
        let text = serde_json::to_string_pretty(&figures).context("writing the figures as JSON")?;
        write(path, text + "\n")?;
    }
    Ok(())
}

fn write(path: &Path, text: String) -> Result<()> {
    let name = path
        .file_name()
        .with_context(|| format!("{} names no file", path.display()))?;
    let directory = path.parent().unwrap_or(Path::new(""));
    files::write_all(directory, &[Output::new(name.to_string_lossy(), text)])
}

/// What the figures were measured on.
fn processor() -> Value {
    json!({
        "architecture": std::env::consts::ARCH,
        "instruction_set": contact_laws::instruction_set(),
        "features": features(),
        "threads": std::thread::available_parallelism().map_or(1, usize::from),
    })
}

#[cfg(target_arch = "x86_64")]
fn features() -> Vec<&'static str> {
    [
        ("sse4.2", std::arch::is_x86_feature_detected!("sse4.2")),
        ("avx", std::arch::is_x86_feature_detected!("avx")),
        ("avx2", std::arch::is_x86_feature_detected!("avx2")),
        ("fma", std::arch::is_x86_feature_detected!("fma")),
        ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
    ]
    .into_iter()
    .filter_map(|(name, has)| has.then_some(name))
    .collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn features() -> Vec<&'static str> {
    Vec::new()
}
