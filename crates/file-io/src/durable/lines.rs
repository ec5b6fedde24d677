//! Lines with a checksum each, appended to files that have one writer.

use crate::durable::Error;
use crate::durable::write::{create_folder, sync_folder};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Characters of a line's checksum.
const CHECKSUM: usize = 32;

/// What names of segments end with.
const SUFFIX: &str = ".jsonl";

/// Random characters in the name of a segment, so that no two processes choose the same one.
const RANDOM: usize = 16;

/// Contents as a line behind a checksum that also covers `key`; contents must hold no end of line, which JSON does not.
pub fn seal_line(key: &str, contents: &[u8]) -> Vec<u8> {
    let mut line = checksum(key, contents).into_bytes();
    line.push(b' ');
    line.extend_from_slice(contents);
    line.push(b'\n');
    line
}

/// The contents of a line, without its end; none unless every bit is as it was sealed with the same key.
pub fn unseal_line<'a>(key: &str, line: &'a [u8]) -> Option<&'a [u8]> {
    let (sum, contents) = line.split_at_checked(CHECKSUM)?;
    let contents = contents.strip_prefix(b" ")?;
    (sum == checksum(key, contents).as_bytes()).then_some(contents)
}

fn checksum(key: &str, contents: &[u8]) -> String {
    let mut hash = Sha256::new();
    hash.update(key);
    hash.update(contents);
    let mut sum = crate::durable::hex(&hash.finalize());
    sum.truncate(CHECKSUM);
    sum
}

/// A file of sealed lines that this process alone writes, so that no lock is needed.
#[derive(Debug)]
pub struct Segment {
    path: PathBuf,
    file: File,
}

impl Segment {
    /// A new file with a name of its own in a folder, which is made if missing.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn create(folder: &Path) -> Result<Self, Error> {
        create_folder(folder)?;
        let mut builder = tempfile::Builder::new();
        builder.prefix("").suffix(SUFFIX).rand_bytes(RANDOM);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let made = builder
            .tempfile_in(folder)
            .and_then(|made| made.keep().map_err(|error| error.error));
        let (file, path) = made.map_err(|source| Error::file(folder, "making a file in the folder", source))?;
        sync_folder(folder)?;
        Ok(Self { path, file })
    }

    /// Appends a line and makes it durable.
    ///
    /// # Errors
    /// [`Error::File`]; the line may be torn then, and counts as absent.
    pub fn append(&mut self, key: &str, contents: &[u8]) -> Result<(), Error> {
        let line = seal_line(key, contents);
        let written = self.file.write_all(&line).and_then(|()| self.file.sync_data());
        written.map_err(|source| Error::file(&self.path, "appending", source))
    }
}

/// The segments in a folder, by name; none where there is no such folder.
///
/// # Errors
/// [`Error::File`].
pub fn segments(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let fail = |source| Error::file(folder, "listing the folder", source);
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(fail)?,
    };
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.map_err(fail)?.path();
        if path.to_string_lossy().ends_with(SUFFIX) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Hands the contents of the lines of a segment from byte `from` on to `each`, and gives the byte after the last whole line. Torn and
/// damaged lines are passed over; a last line without its end may be one that is being written, and is read the next time.
///
/// # Errors
/// [`Error::File`].
pub fn read_segment(path: &Path, key: &str, from: u64, each: &mut dyn FnMut(&[u8])) -> Result<u64, Error> {
    let fail = |source| Error::file(path, "reading", source);
    let mut file = File::open(path).map_err(fail)?;
    if file.metadata().map_err(fail)?.len() <= from {
        return Ok(from);
    }
    file.seek(SeekFrom::Start(from)).map_err(fail)?;
    let mut text = Vec::new();
    file.read_to_end(&mut text).map_err(fail)?;
    let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    let lines = text.get(..whole).unwrap_or_default().split(|byte| *byte == b'\n');
    lines.filter_map(|line| unseal_line(key, line)).for_each(each);
    Ok(from + whole as u64)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn a_line_is_as_it_was_written_or_absent() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("ab");
        let mut segment = Segment::create(&place).unwrap();
        let mut other = Segment::create(&place).unwrap();
        segment.append("key", b"{\"a\":1}").unwrap();
        segment.append("key", b"{\"a\":2}").unwrap();
        other.append("key", b"{\"a\":3}").unwrap();
        let all = segments(&place).unwrap();
        assert_eq!(all.len(), 2);
        let read = |path: &Path, key: &str, from: u64| {
            let mut lines = Vec::new();
            let next = read_segment(path, key, from, &mut |line| {
                lines.push(String::from_utf8(line.to_vec()).unwrap())
            });
            (lines, next.unwrap())
        };
        let (lines, end) = read(&segment.path, "key", 0);
        assert_eq!(lines, ["{\"a\":1}", "{\"a\":2}"]);
        assert_eq!(read(&segment.path, "other", 0).0, [""; 0]);
        // What is appended later is read from where the last reading ended.
        segment.append("key", b"{\"a\":4}").unwrap();
        assert_eq!(read(&segment.path, "key", end).0, ["{\"a\":4}"]);
        // Wherever the file is cut, and whichever bit has changed, the whole lines before are there and nothing else is.
        let whole = std::fs::read(&segment.path).unwrap();
        for cut in 0..whole.len() {
            std::fs::write(&segment.path, &whole[..cut]).unwrap();
            let (lines, next) = read(&segment.path, "key", 0);
            let ends = whole[..cut].iter().filter(|byte| **byte == b'\n').count();
            assert_eq!(lines.len(), ends);
            assert!(next as usize <= cut);
            let mut changed = whole.clone();
            changed[cut] ^= 1;
            std::fs::write(&segment.path, &changed).unwrap();
            assert!(read(&segment.path, "key", 0).0.len() < 3, "{cut}");
        }
        assert!(segments(&folder.path().join("missing")).unwrap().is_empty());
    }
}
