//! Folders of results, each written by one command at a time and replaced as a set.

use crate::progress::Display;
use analyses::results::summary::Summary;
use anyhow::{Result, anyhow};
use file_io::durable::{Folder, Identity};
use file_io::input::{Kind, read_text};
use reports::Output;
use reports::names::SUMMARY;
use scenes::read_json;
use serde::de::DeserializeOwned;
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
        self.open_for(Display::default(), directory, identity, names)
    }

    /// The same for a command that shows what it does in a way of its own.
    pub(crate) fn open_for(
        &self,
        display: Display,
        directory: &Path,
        identity: &Identity,
        names: &[&str],
    ) -> Result<Folder> {
        let folder = Folder::open(directory, identity, self.overwrite)?;
        folder.expect(names.iter().copied())?;
        if !folder.is_locked() {
            display.warn(&format!(
                "{}: the file system has no locks; start no other command with this folder before the end",
                directory.display()
            ));
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

/// The summary of the run in a folder.
///
/// # Errors
/// A file that cannot be read, or is no summary of a run.
pub(crate) fn summary(folder: &Path) -> Result<Summary> {
    let path = folder.join(SUMMARY);
    let text = read_text(&path, Kind::Table)?;
    parse(&path, &text, A_SUMMARY)
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
