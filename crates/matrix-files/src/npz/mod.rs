//! NumPy archives (`.npz`): a ZIP file of arrays in `.npy` format, plain (`savez`) or compressed (`savez_compressed`).
//!
//! Layout: NumPy Enhancement Proposal 1 and `numpy.lib.format`. A sparse matrix is five arrays, as
//! `scipy.sparse.save_npz` writes them: `format` (`csr` or `csc`), `shape`, `indptr`, `indices`, `data`. Alone in a
//! file it is called [`MATRIX`] here; beside others its arrays are called `name.format`, `name.shape` and so on.

mod npy;
mod sparse;
mod writer;

use std::path::Path;

use self::npy::Npy;
pub use self::sparse::MATRIX;
use self::sparse::sparse_matrices;
pub use self::writer::to_bytes;
use crate::Error;
use crate::archive;
use crate::text;
use crate::value::{Array, Collection, Skipped};
use file_io::{Place, Source};

/// Reads the file at `path`.
///
/// # Errors
/// [`Error::File`], and those of [`parse`].
pub fn read(path: &Path) -> Result<Collection, Error> {
    text::read(path, parse)
}

/// Reads all arrays: real numbers, integers, truth values and text of up to two dimensions, by rows or columns, and
/// sparse matrices. Single numbers are 1 x 1, vectors are columns. Other members of the archive are listed as skipped.
///
/// Entries of a sparse matrix at the same place add up, as SciPy defines.
///
/// # Errors
/// [`Error::Malformed`], [`Error::Unsupported`] for sparse matrices in other formats, [`Error::Oversized`],
/// [`Error::OutOfRange`], [`Error::NotFinite`].
pub fn parse(source: Source<'_>) -> Result<Collection, Error> {
    let mut found = arrays(source, false)?;
    sparse_matrices(source, &mut found.arrays)?;
    Ok(found)
}

/// Reads the arrays of a measurement: full ones only, and with NaN and infinities kept, since NumPy marks missing values
/// by NaN.
///
/// # Errors
/// [`Error::Malformed`], [`Error::Oversized`].
pub fn parse_measured(source: Source<'_>) -> Result<Collection, Error> {
    arrays(source, true)
}

/// Reads one array in a file of its own (`.npy`), with NaN and infinities kept as by [`parse_measured`].
///
/// # Errors
/// [`Error::Malformed`], [`Error::Unsupported`], [`Error::Oversized`].
pub fn parse_measured_array(source: Source<'_>) -> Result<Array, Error> {
    let npy = Npy {
        file: source.name,
        member: None,
        measured: true,
        bytes: source.bytes,
    };
    npy.parse()?.map_err(|found| Error::Unsupported {
        file: source.name.into(),
        place: Place::Byte(0),
        found,
        remedy: "save real numbers as an array of one or two dimensions",
    })
}

fn arrays(source: Source<'_>, measured: bool) -> Result<Collection, Error> {
    let mut archive = archive::Archive::open(source)?;
    let mut found = Collection::default();
    for (index, name) in archive.names()?.into_iter().enumerate() {
        let bytes = archive.member(index)?;
        let Some(key) = name.strip_suffix(".npy") else {
            found.skip(&name, "it is no array");
            continue;
        };
        let npy = Npy {
            file: source.name,
            member: Some(&name),
            measured,
            bytes: &bytes,
        };
        match npy.parse()? {
            Err(reason) => found.skip(key, &reason),
            Ok(array) => {
                if found.arrays.insert(key.into(), array).is_some() {
                    return Err(npy.malformed(0, "a second array of this name", "each name once"));
                }
            }
        }
    }
    Ok(found)
}

impl Collection {
    fn skip(&mut self, name: &str, reason: &str) {
        self.skipped.push(Skipped {
            name: name.into(),
            reason: reason.into(),
        });
    }
}
