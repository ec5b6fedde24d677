//! Files that others trust: written whole or not at all, checked when they are read.

mod error;
mod folder;
mod lines;
mod lock;
mod manifest;
mod sealed;
mod write;

pub use error::Error;
pub use folder::Folder;
pub use lines::{Segment, read_segment, seal_line, segments, unseal_line};
pub use manifest::{Defect, Entry, Identity, MANIFEST, Manifest};
pub use sealed::{read_sealed, seal, unseal, write_sealed};
pub use write::write;

use sha2::{Digest, Sha256};
use std::io::Read;
use std::path::Path;

/// Bytes as lower-case hexadecimal text.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// SHA-256 of bytes, as hexadecimal text.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Size in bytes and SHA-256 of a file, without holding all of it in memory.
///
/// # Errors
/// [`Error::File`].
pub fn sha256_of_file(path: &Path) -> Result<(u64, String), Error> {
    let fail = |source| Error::file(path, "reading", source);
    let mut file = std::fs::File::open(path).map_err(fail)?;
    let (mut hash, mut size, mut buffer) = (Sha256::new(), 0, vec![0; 1 << 16]);
    loop {
        match file.read(&mut buffer).map_err(fail)? {
            0 => return Ok((size, hex(&hash.finalize()))),
            n => {
                size += n as u64;
                hash.update(&buffer[..n]);
            }
        }
    }
}
