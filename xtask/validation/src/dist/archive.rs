//! Archives that are the same bytes whenever they are made of the same files.

use anyhow::{Context, Result};
use flate2::{Compression, GzBuilder};
use std::collections::BTreeMap;
use tar::{Builder, Header};

/// A file of an archive.
#[derive(Clone, Debug)]
pub struct File {
    /// What it holds.
    pub contents: Vec<u8>,
    /// Whether it is a program.
    pub is_program: bool,
}

impl File {
    /// A file that is no program.
    pub fn new(contents: impl Into<Vec<u8>>) -> Self {
        Self {
            contents: contents.into(),
            is_program: false,
        }
    }
}

/// A compressed archive of files in a folder, sorted by name, of one time and nobody's.
///
/// # Errors
/// A name is too long for an archive.
pub fn tar_gz(folder: &str, files: &BTreeMap<String, File>, seconds: u64) -> Result<Vec<u8>> {
    let compressed = GzBuilder::new().mtime(0).write(Vec::new(), Compression::best());
    let mut archive = Builder::new(compressed);
    for (name, file) in files {
        let mut header = Header::new_gnu();
        header.set_size(file.contents.len() as u64);
        header.set_mode(if file.is_program { 0o755 } else { 0o644 });
        header.set_mtime(seconds);
        header.set_uid(0);
        header.set_gid(0);
        archive
            .append_data(&mut header, format!("{folder}/{name}"), &file.contents[..])
            .with_context(|| format!("adding {name} to the archive"))?;
    }
    let compressed = archive.into_inner().context("ending the archive")?;
    compressed.finish().context("compressing the archive")
}
