//! Scans from the files that profilometers write.
//!
//! | module | format | unit of positions | unit of heights |
//! |---|---|---|---|
//! | [`x3p`] | X3P (ISO 25178-72): surfaces and gridded points, binary or XML, one layer of several | m | m |
//! | [`sdf`] | SDF (ISO 25178-71 1.0 and 2.0, BCR-1.0), text and binary | m | m |
//! | [`sur`] | SUR of Digital Surf, plain and compressed | stated | stated |
//! | [`text`] | grid of heights, or `x y z` per line | header or [`Options`] | header or [`Options`] |
//! | [`numpy`] | `.npy`, `.npz`: a matrix of heights | [`Options`] | [`Options`] |
//!
//! [`read`] tells the format by the contents, and takes the extension only as a second opinion.
//!
//! **Units** are read from the file or required from the caller, never guessed, and converted to metres once. A unit
//! that is stated twice must be the same.
//!
//! **Missing points** (NaN, `BAD`, `***`, empty cells, the markers of each format) are masked.
//!
//! **Orientation.** Point `(i, j)` of the map is the `i`-th value of the `j`-th line of the file, and lines follow one
//! another towards larger y: x3p and ISO 25178-71 say so. BCR, SUR, grids as text and NumPy leave it open, and some
//! programs draw their first line at the top; this is noted, and [`Options::first_row`] turns such a file over. Negative
//! increments of X3P are turned into positive ones, points and positions together. A rotation stated in X3P is not
//! applied but noted, since a tilted grid is no height map.
//!
//! **Plausibility.** A wrong unit is caught where no scan can look like that: the larger lateral extent lies between
//! 1 um and 1 m (microscopes see no less, profilometers travel no farther); the range of heights is at most as large as
//! this extent (a scan from above cannot follow more), and at least a billionth of it or zero (no instrument resolves
//! less); the mean slope between neighbours is at most 10 (84 degrees: no probe or lens follows steeper flanks all
//! over). Heights in too small a unit look like a polished face and cannot be told from it.
//!
//! **Memory** stays within a fixed multiple of the file's size, whatever its header claims; of compressed files (X3P,
//! `.npz`, SUR), within that multiple of the unpacked size, which is at most 1032 times as large.

mod bytes;
mod format;
mod grid;
pub mod numpy;
mod options;
mod scan;
pub mod sdf;
pub mod sur;
pub mod text;
mod units;
pub mod x3p;

use file_io::quoted;
pub use file_io::{Place, Source};
use matrix_files::Error as Layout;
use std::path::Path;

pub use crate::error::FileError;
pub use format::Format;
pub use options::{FirstRow, Options};
pub use scan::Scan;
pub use units::{Declaration, LengthUnit, UnknownUnit};

/// Reads the file at `path`.
///
/// # Errors
/// [`FileError`]; each names the file, the place where there is one, and what to do.
pub fn read(path: &Path, options: &Options) -> Result<Scan, FileError> {
    let bytes = file_io::input::read(path, file_io::input::Kind::Scan).map_err(Layout::from)?;
    parse(
        Source {
            name: &path.to_string_lossy(),
            bytes: &bytes,
        },
        options,
    )
}

/// Reads a file that was loaded already. The extension of its name serves as second opinion on the format.
///
/// # Errors
/// [`FileError`].
pub fn parse(source: Source<'_>, options: &Options) -> Result<Scan, FileError> {
    let format = match options.format {
        Some(format) => format,
        None => detect(source)?,
    };
    match format {
        Format::X3p => x3p::parse(source, options),
        Format::Sdf => sdf::parse(source, options),
        Format::Sur => sur::parse(source, options),
        Format::Xyz | Format::Grid => text::parse(source, options),
        Format::Npy | Format::Npz => numpy::parse(source, options),
    }
}

fn detect(source: Source<'_>) -> Result<Format, FileError> {
    let unknown = |problem: String| FileError::UnknownFormat {
        file: source.name.into(),
        found: quoted(source.bytes),
        problem,
    };
    match source.bytes {
        [b'P', b'K', 3 | 5, 4 | 6, ..] => {
            let names = matrix_files::archive::Archive::open(source)?.names()?;
            if names.iter().any(|name| x3p::is_main(name)) {
                Ok(Format::X3p)
            } else if names.iter().any(|name| name.ends_with(".npy")) {
                Ok(Format::Npz)
            } else {
                Err(unknown("a ZIP archive with neither `main.xml` nor NumPy arrays".into()))
            }
        }
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Ok(Format::Npy),
        bytes if sur::is_magic(bytes) => Ok(Format::Sur),
        bytes if sdf::is_magic(bytes) => Ok(Format::Sdf),
        [] => Err(unknown("empty".into())),
        bytes => {
            let extension = Path::new(source.name).extension().and_then(|e| e.to_str());
            let extension = extension.unwrap_or_default().to_ascii_lowercase();
            if ["x3p", "sdf", "sur", "npy", "npz"].contains(&extension.as_str()) {
                Err(unknown(format!("not those of `.{extension}`")))
            } else if bytes.contains(&0) && !text::is_utf16(bytes) {
                Err(unknown("binary and of no known format".into()))
            } else {
                // The number of columns decides which.
                Ok(Format::Grid)
            }
        }
    }
}
