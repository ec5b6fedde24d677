//! MATLAB files (`.mat`) of level 5: what MATLAB saves with `-v6` (plain) and `-v7` (compressed), Octave with the same
//! options, SciPy with `savemat`.
//!
//! Layout: *MAT-File Format*, The MathWorks. A header of 128 bytes, then elements: a tag with type and size, the data,
//! and padding to eight bytes. An array is an element of elements: flags, dimensions, name, data. Files of `-v7.3` are
//! HDF5, and read too.

mod elements;
mod hdf5;
mod layout;
mod writer;

use std::path::Path;

use self::elements::View;
use self::layout::{COMPRESSED, MATRIX};
pub use self::writer::to_bytes;
use crate::Error;
use crate::text;
use crate::value::Collection;
use file_io::{Place, Source};

/// Reads the file at `path`.
///
/// # Errors
/// [`Error::File`], and those of [`parse`].
pub fn read(path: &Path) -> Result<Collection, Error> {
    text::read(path, parse)
}

/// Reads all variables. Fields of structures are called `structure.field`.
///
/// Numbers and truth values of one or two dimensions, sparse matrices and text are read; cells, objects, functions,
/// arrays of structures, complex numbers and arrays of more dimensions are listed as skipped.
///
/// # Errors
/// [`Error::Unsupported`] for other levels of the format, [`Error::Malformed`], [`Error::Oversized`],
/// [`Error::OutOfRange`], [`Error::NotFinite`].
pub fn parse(source: Source<'_>) -> Result<Collection, Error> {
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    if source.bytes.starts_with(HDF5) || source.bytes.get(512..520) == Some(HDF5) {
        return hdf5::parse(source);
    }
    let big = byte_order(source)?;
    let mut file = View {
        file: source.name,
        part: None,
        bytes: &source.bytes[128..],
        start: 128,
        at: 0,
        big,
    };
    let mut found = Collection::default();
    while file.at < file.bytes.len() {
        let start = file.start + file.at;
        let (kind, mut body) = file.element()?;
        match kind {
            MATRIX => body.array(None, 0, &mut found)?,
            COMPRESSED => {
                let unpacked = body.inflate()?;
                let part = format!("the element compressed at byte {start}");
                let mut inner = View {
                    part: Some(&part),
                    bytes: &unpacked,
                    start: 0,
                    at: 0,
                    ..body
                };
                match inner.element()? {
                    (MATRIX, mut body) => body.array(None, 0, &mut found)?,
                    (kind, body) => return Err(body.malformed(format!("an element of type {kind}"), "an array")),
                }
            }
            _ => return Err(body.malformed(format!("an element of type {kind}"), "an array")),
        }
    }
    Ok(found)
}

/// Whether numbers are stored with the highest byte first.
fn byte_order(source: Source<'_>) -> Result<bool, Error> {
    let bytes = source.bytes;
    let unsupported = |found: &str, remedy| Error::Unsupported {
        file: source.name.into(),
        place: Place::Byte(0),
        found: found.into(),
        remedy,
    };
    let level = bytes.get(124..128);
    match level {
        Some([0, 1, b'I', b'M']) => Ok(false),
        Some([1, 0, b'M', b'I']) => Ok(true),
        // The type of the first variable of level 4 is a small integer.
        _ if bytes.len() >= 20 && bytes[..4].contains(&0) => Err(unsupported(
            "a file of level 4, or none of MATLAB's",
            "save it with `save(name, '-v7')`",
        )),
        _ => Err(Error::Malformed {
            file: source.name.into(),
            place: Place::Byte(bytes.len().min(124)),
            found: level.map_or("the end of the file".into(), file_io::quoted),
            expected: "the version and byte order of a MATLAB file of level 5".into(),
        }),
    }
}
