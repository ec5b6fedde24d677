//! `export` of a finished run: its joints as elements for other programs.

use super::destination::default_directory;
use crate::files::{self, Overwrite};
use crate::text::print;
use anyhow::{Result, ensure};
use file_io::durable::Identity;
use reports::Output;
use reports::elements::{self, Coordinate, Family};
use std::path::Path;

/// What is written of a run.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Elements {
    Nastran,
    Abaqus,
    Fitted(Family),
}

/// Writes the elements of the run in `folder`, by the format `name`, to `out`.
pub(super) fn export(folder: &Path, of: Elements, name: &str, out: Option<&Path>, overwrite: &Overwrite) -> Result<()> {
    ensure!(
        folder.is_dir(),
        "{} is no folder; --format {name} takes the folder of a finished run, which `microslip run` writes",
        folder.display()
    );
    let summary = files::summary(folder)?;
    let run = summary.scene["name"].as_str().unwrap_or_default().to_owned();
    ensure!(
        summary.scene.pointer("/model/symmetry").and_then(|of| of.as_str()) != Some("half"),
        "{}: the half of the scene {run} has half of the bolts and of their forces; leave out model.symmetry and run it again",
        folder.display()
    );
    let directory = match out {
        Some(path) => path.to_owned(),
        None => default_directory(&format!("{run}-export-{name}"))?,
    };
    let coordinates = elements::coordinates(&summary);
    let has_levels = |of: &Coordinate| !of.levels.is_empty();
    ensure!(
        coordinates.iter().any(has_levels),
        "{}: no amplitude converged, so that there is nothing to export",
        folder.display()
    );
    let (output, lines) = match of {
        Elements::Fitted(family) => {
            let fits = elements::fitted(&run, &coordinates, family)?;
            (Output::new(format!("{name}.json"), fits.json), fits.lines)
        }
        tables => {
            ensure!(
                coordinates.iter().any(|of| of.connection.is_some()),
                "{}: the run has no connections: it is older than they are, or the place of its interface is not known, as of matrices; run the scene again, \
                 or take --format iwan of its modal coordinate",
                folder.display()
            );
            let output = match tables {
                Elements::Abaqus => Output::new("connectors.inp", elements::abaqus(&run, &coordinates)),
                _ => Output::new("cbush.bdf", elements::nastran(&run, &coordinates)),
            };
            (output, coordinates.iter().filter_map(Coordinate::remark).collect())
        }
    };
    let identity = Identity::new(format!("export --format {name}"), run);
    let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
    let written = format!("{text}written to {}: {}\n", directory.display(), output.name);
    files::publish(overwrite.open(&directory, &identity, &[])?, &[output])?;
    print(&written)
}
