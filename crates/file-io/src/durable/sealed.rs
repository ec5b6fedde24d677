//! Files with a checksum over all of their bytes.

use crate::durable::write::write_all;
use crate::durable::{Error, sha256};
use std::path::Path;

/// Length of the line before the contents: SHA-256 as text, and the end of the line.
const SEAL: usize = 65;

/// Contents behind a line with their checksum.
pub fn seal(contents: &[u8]) -> Vec<u8> {
    [line(contents).as_bytes(), contents].concat()
}

/// The line before contents.
fn line(contents: &[u8]) -> String {
    sha256(contents) + "\n"
}

/// The contents behind a checksum; none unless every bit is as it was sealed.
pub fn unseal(sealed: &[u8]) -> Option<&[u8]> {
    let (line, contents) = sealed.split_at_checked(SEAL)?;
    let intact = line.strip_suffix(b"\n")? == sha256(contents).as_bytes();
    intact.then_some(contents)
}

/// As [`write`](crate::durable::write), with a checksum.
///
/// # Errors
/// [`Error::File`].
pub fn write_sealed(path: &Path, contents: &[u8]) -> Result<(), Error> {
    // Contents may be large: no copy of them is made.
    write_all(path, &[line(contents).as_bytes(), contents])
}

/// Contents of a file that [`write_sealed`] wrote. Damaged and foreign files count as absent.
pub fn read_sealed(path: &Path) -> Option<Vec<u8>> {
    let mut bytes = std::fs::read(path).ok()?;
    unseal(&bytes)?;
    bytes.drain(..SEAL);
    Some(bytes)
}
