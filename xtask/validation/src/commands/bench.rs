//! `cargo xtask bench`: figures of one run, so that ratios hold even where times do not.

use anyhow::{Context, Result};
use host::{forget_peak_memory, peak_memory};
use microslip::commands::{RESULTS, print};
use microslip::progress::{Display, Monitor};
use serde_json::json;
use std::path::Path;
use validation::bench::{Instruments, periodic, processor, scaling, solver};
use xtask::arguments;

/// Runs the command.
pub(crate) fn run(arguments: &arguments::Bench) -> Result<()> {
    let mut figures = json!({ "processor": processor() });
    if arguments.scaling {
        let found = scaling(
            Path::new(RESULTS).join(".cache"),
            &instruments(&Monitor::new(Display::default())?),
        )?;
        figures["scaling"] = found.figures;
        print(&found.table)?;
        if let Some(path) = &arguments.plot {
            write(path, found.picture)?;
        }
    } else if arguments.periodic {
        let (found, table) = periodic(&instruments(&Monitor::new(Display::default())?))?;
        print(&table)?;
        if let (Some(all), serde_json::Value::Object(found)) = (figures.as_object_mut(), found) {
            all.extend(found);
        }
    } else {
        let (parts, table) = solver(&instruments(&Monitor::new(Display::default())?))?;
        print(&table)?;
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

fn instruments(monitor: &Monitor) -> Instruments<'_> {
    Instruments {
        progress: monitor,
        stages: Box::new(|| monitor.finish()),
        peak_memory,
        forget_peak_memory,
    }
}

fn write(path: &Path, text: String) -> Result<()> {
    Ok(file_io::durable::write(path, text.as_bytes())?)
}
