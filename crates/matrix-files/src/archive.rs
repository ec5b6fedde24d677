//! ZIP archives, unpacked member by member.

use std::io::{Cursor, Read};

use crate::Error;
use file_io::{Place, Source};
use zip::ZipArchive;

/// Deflate packs at most 1032 bytes into one.
pub const INFLATION: usize = 1032;

/// An archive whose members unpack to no more than [`INFLATION`] times its size in all.
#[derive(Debug)]
pub struct Archive<'a> {
    source: Source<'a>,
    zip: ZipArchive<Cursor<&'a [u8]>>,
    // Members that share their bytes would unpack to more than the file's size allows.
    packed_so_far: u64,
}

impl<'a> Archive<'a> {
    /// Reads the directory.
    ///
    /// # Errors
    /// [`Error::Malformed`].
    pub fn open(source: Source<'a>) -> Result<Self, Error> {
        let zip = ZipArchive::new(Cursor::new(source.bytes)).map_err(|e| broken(source, &e))?;
        if zip.has_duplicate_names() {
            return Err(broken(source, &"two members of the same name"));
        }
        Ok(Self {
            source,
            zip,
            packed_so_far: 0,
        })
    }

    /// Names of the members as the archive spells them.
    ///
    /// # Errors
    /// [`Error::Malformed`].
    pub fn names(&self) -> Result<Vec<String>, Error> {
        let names = self.zip.file_names().map(|name| Ok(name?.into_owned()));
        names
            .collect::<zip::result::ZipResult<_>>()
            .map_err(|e| broken(self.source, &e))
    }

    /// Unpacks the member at `index` of [`Archive::names`]. Each can be asked for once.
    ///
    /// # Errors
    /// [`Error::Malformed`], [`Error::Oversized`].
    pub fn member(&mut self, index: usize) -> Result<Vec<u8>, Error> {
        let file = || self.source.name.to_owned();
        let member = self.zip.by_index(index).map_err(|e| broken(self.source, &e))?;
        let name = member.name().map_err(|e| broken(self.source, &e))?.into_owned();
        let start = || Place::Inside {
            part: format!("`{}`", name.escape_debug()),
            byte: 0,
        };
        self.packed_so_far = self.packed_so_far.saturating_add(member.compressed_size());
        if self.packed_so_far > self.source.bytes.len() as u64 {
            return Err(Error::Oversized {
                file: file(),
                place: start(),
                what: "the number of bytes of all members",
                stated: self.packed_so_far.into(),
                possible: self.source.bytes.len(),
            });
        }
        let size = member.size();
        let possible = usize::try_from(member.compressed_size())
            .unwrap_or(usize::MAX)
            .saturating_mul(INFLATION);
        let Some(size) = usize::try_from(size).ok().filter(|size| *size <= possible) else {
            return Err(Error::Oversized {
                file: file(),
                place: start(),
                what: "the number of unpacked bytes",
                stated: size.into(),
                possible,
            });
        };
        let mut bytes = Vec::with_capacity(size);
        let unpacked = member.take(size as u64 + 1).read_to_end(&mut bytes);
        let found = match unpacked {
            Ok(n) if n == size => return Ok(bytes),
            Ok(n) => format!("{n} bytes or more, not {size}"),
            Err(e) => e.to_string(),
        };
        Err(Error::Malformed {
            file: file(),
            place: start(),
            found,
            expected: "data as long as stated and true to their checksum".into(),
        })
    }
}

fn broken(source: Source<'_>, reason: &dyn std::fmt::Display) -> Error {
    Error::Malformed {
        file: source.name.into(),
        place: Place::Byte(0),
        found: reason.to_string(),
        expected: "a ZIP archive".into(),
    }
}
