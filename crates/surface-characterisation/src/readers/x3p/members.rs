//! The members of the archive, and their checksums.

use file_io::{Place, Source, quoted};
use matrix_files::archive::Archive;
use md5::{Digest, Md5};

use super::document::MAIN;
use crate::error::FileError;
use crate::readers::bytes::malformed;

/// Whether a member of an archive is the document, at the top or in one folder.
pub(crate) fn is_main(name: &str) -> bool {
    let path = plain(name);
    path == MAIN || path.split_once('/').is_some_and(|(_, rest)| rest == MAIN)
}

/// A member by its path from the folder of `main.xml`.
pub(super) struct Members<'a> {
    file: &'a str,
    archive: Archive<'a>,
    paths: Vec<String>,
    read: usize,
}

impl<'a> Members<'a> {
    pub(super) fn open(source: Source<'a>) -> Result<Self, FileError> {
        let archive = Archive::open(source)?;
        let mut paths: Vec<String> = archive.names()?.iter().map(|name| plain(name)).collect();
        let folder = paths
            .iter()
            .find(|path| is_main(path))
            .and_then(|path| path.strip_suffix(MAIN));
        if let Some(folder) = folder
            .map(str::to_owned)
            .filter(|folder| !paths.iter().any(|p| p == MAIN) && !folder.is_empty())
        {
            for path in &mut paths {
                *path = path.strip_prefix(&folder).unwrap_or_default().to_owned();
            }
        }
        Ok(Self {
            file: source.name,
            archive,
            paths,
            read: 0,
        })
    }

    pub(super) fn get(&mut self, path: &str) -> Result<Option<Vec<u8>>, FileError> {
        let wanted = plain(path);
        let Some(index) = self.paths.iter().position(|path| *path == wanted) else {
            return Ok(None);
        };
        self.read += 1;
        Ok(Some(self.archive.member(index)?))
    }

    /// A member that the document refers to, checked against the checksum that the document states.
    pub(super) fn linked(
        &mut self,
        path: &str,
        stated: Option<&str>,
        notes: &mut Vec<String>,
    ) -> Result<Vec<u8>, FileError> {
        let Some(bytes) = self.get(path)? else {
            let found = format!("no member {}", quoted(path.as_bytes()));
            return Err(malformed(self.file, Place::Byte(0), found, "what `main.xml` refers to"));
        };
        verify(self.file, path, &bytes, stated, notes)?;
        Ok(bytes)
    }

    /// Says how many members were not asked for.
    pub(super) fn note_others(&self, notes: &mut Vec<String>) {
        let is_file = |path: &&String| !path.is_empty() && !path.ends_with('/');
        let others = self.paths.iter().filter(is_file).count();
        if others > self.read {
            notes.push(format!("{} other members of the archive ignored", others - self.read));
        }
    }
}

/// A path with slashes and without a beginning.
pub(super) fn plain(path: &str) -> String {
    let path = path.replace('\\', "/");
    path.trim_start_matches("./").trim_start_matches('/').to_owned()
}

pub(super) fn verify(
    file: &str,
    part: &str,
    bytes: &[u8],
    stated: Option<&str>,
    notes: &mut Vec<String>,
) -> Result<(), FileError> {
    let stated = stated.unwrap_or_default().trim();
    if stated.len() != 32 || !stated.bytes().all(|b| b.is_ascii_hexdigit()) {
        notes.push(format!("no checksum of `{}` to verify", part.escape_debug()));
        return Ok(());
    }
    let computed: String = Md5::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
    if computed.eq_ignore_ascii_case(stated) {
        return Ok(());
    }
    Err(FileError::Checksum {
        file: file.into(),
        part: part.into(),
        stated: stated.to_ascii_lowercase(),
        computed,
    })
}
