//! Folders of results, each written by one command at a time and replaced as a set.

use anyhow::{Result, anyhow};
use file_io::durable::{Folder, Identity};
use reports::Output;
use reports::run::{
    BODIES_PRESTRESS, ELEMENT_LOOPS, ENSEMBLE, EPMC, FORCED, FORCED_PICTURE, LOOPS, PERIODIC, amplitude_file,
    bodies_file, harmonics_file, loops_file, picture_file, series_file, table_file,
};
use reports::tightening::{TIGHTENING, TIGHTENING_PICTURE};
use reports::uncertainty::{BANDS, INFLUENCES, SAMPLES, bands_picture};
use scenes::read_json;
use serde::de::DeserializeOwned;
use std::io::Write;
use std::path::Path;

/// Whether results of something else may be replaced.
#[derive(clap::Args)]
pub struct Overwrite {
    /// Replace what is in the folder, also results of another scene or command and files that no manifest lists.
    #[arg(long)]
    overwrite: bool,
}

impl Overwrite {
    /// Takes hold of the folder of results, made if missing, before what is computed. `names` are files that will be
    /// written.
    ///
    /// # Errors
    /// Another process holds the folder; it holds results of something else; it cannot be made.
    pub fn open(&self, directory: &Path, identity: &Identity, names: &[&str]) -> Result<Folder> {
        let folder = Folder::open(directory, identity, self.overwrite)?;
        folder.expect(names.iter().copied())?;
        if !folder.is_locked() {
            // Who cannot be told is not told.
            let _ = writeln!(
                std::io::stderr(),
                "warning: {}: the file system has no locks; start no other command with this folder before the end",
                directory.display()
            );
        }
        Ok(folder)
    }
}

/// Replaces the results in a folder by these, with their manifest, and gives the folder free.
///
/// # Errors
/// A file that cannot be written; the results that were there are as they were.
pub fn publish(folder: Folder, outputs: &[Output]) -> Result<()> {
    let files: Vec<(&str, &[u8])> = outputs.iter().map(|o| (o.name.as_str(), &o.contents[..])).collect();
    Ok(folder.publish(&files)?)
}

/// What is read where a run is named.
pub(crate) const A_SUMMARY: &str = "the summary of a run, which `microslip run` writes";

/// Reads the text of a JSON file as `what`; messages name the field.
///
/// # Errors
/// It is something else.
pub(crate) fn parse<T: DeserializeOwned>(path: &Path, text: &str, what: &str) -> Result<T> {
    read_json(text).map_err(|reason| anyhow!("{} is not {what}: {reason}", path.display()))
}

/// Whether a run of some scene may write a file of this name beside those that every run writes: the fields of an amplitude,
/// the bodies deformed at it, loops of elements, the backbone of a further mode, an ensemble, samples of uncertain inputs, or
/// periodic motions.
pub(crate) fn is_of_some_run(name: &str) -> bool {
    let of_first = [harmonics_file(None), loops_file(None), bands_picture(None)];
    if [
        BODIES_PRESTRESS,
        ELEMENT_LOOPS,
        ENSEMBLE,
        BANDS,
        SAMPLES,
        INFLUENCES,
        EPMC,
        FORCED,
        FORCED_PICTURE,
        LOOPS,
        PERIODIC,
        TIGHTENING,
        TIGHTENING_PICTURE,
    ]
    .contains(&name)
        || of_first.iter().any(|of| name == of)
    {
        return true;
    }
    let number = |text: &str| text.parse::<usize>().ok();
    if let Some(mode) = name
        .strip_prefix("mode-")
        .and_then(|rest| number(rest.split_once('-')?.0))
    {
        let of_mode = [
            table_file,
            picture_file,
            series_file,
            harmonics_file,
            loops_file,
            bands_picture,
        ]
        .map(|of| of(Some(mode)));
        return of_mode.iter().any(|known| known == name);
    }
    let of_amplitude = ["interface-", "bodies-"].map(|prefix| name.strip_prefix(prefix));
    let Some(rest) = of_amplitude.into_iter().flatten().next() else {
        return false;
    };
    let (mode, rest) = match rest.strip_prefix("mode-").and_then(|rest| rest.split_once('-')) {
        Some((mode, rest)) => (number(mode), rest),
        None => (None, rest),
    };
    let amplitude = rest
        .strip_prefix("amplitude-")
        .and_then(|rest| number(rest.strip_suffix(".vtu")?));
    amplitude.is_some_and(|amplitude| {
        [amplitude_file, bodies_file]
            .iter()
            .any(|of| of(mode, amplitude) == name)
    })
}
