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
mod grid;
pub mod numpy;
pub mod sdf;
pub mod sur;
pub mod text;
mod units;
pub mod x3p;

use std::fmt;
use std::path::Path;

use matrix_files::Error as Layout;
pub use matrix_files::{Place, Source};
pub use units::LengthUnit;

pub use crate::error::{FileError, UnknownUnit};
use crate::topography::HeightMap;

/// What the caller knows of a file. Nothing is needed for files that say everything themselves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// The format, where its contents are not to decide. Needed only for a text of three columns that is a grid.
    pub format: Option<Format>,
    /// Unit of positions and steps.
    pub lateral_unit: Option<LengthUnit>,
    /// Unit of heights.
    pub height_unit: Option<LengthUnit>,
    /// Distances of neighbours along x and y of a grid whose file does not state them, in `lateral_unit`.
    pub lateral_step: Option<[f64; 2]>,
    /// Where the first line lies, for formats that leave it open; at the lowest y if `None`.
    pub first_row: Option<FirstRow>,
    /// Which layer of several (X3P), from 0.
    pub layer: Option<usize>,
    /// Which array of several (`.npz`).
    pub array: Option<String>,
    /// Lines of a text before its numbers, where they look like numbers themselves.
    pub header_lines: Option<usize>,
    /// Do without the check of plausibility.
    pub accept_implausible: bool,
}

/// Where the first line of a grid lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum FirstRow {
    /// Lines ascend along y.
    LowestY,
    /// Lines descend, as in a picture.
    HighestY,
}

/// Formats of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
#[non_exhaustive]
pub enum Format {
    /// ISO 25178-72.
    X3p,
    /// ISO 25178-71 and BCR-1.0.
    Sdf,
    /// Digital Surf.
    Sur,
    /// Text of three columns: x, y, z.
    Xyz,
    /// Text with a line of heights per line of points.
    Grid,
    /// One NumPy array.
    Npy,
    /// An archive of NumPy arrays.
    Npz,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X3p => "X3P file",
            Self::Sdf => "SDF file",
            Self::Sur => "SUR file",
            Self::Xyz => "text of x, y, z",
            Self::Grid => "grid of text",
            Self::Npy => "NumPy array",
            Self::Npz => "NumPy archive",
        })
    }
}

/// A unit, and who stated it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Declaration {
    /// The file, or its format.
    File(LengthUnit),
    /// The caller.
    Caller(LengthUnit),
}

impl Declaration {
    /// The unit.
    pub fn unit(self) -> LengthUnit {
        match self {
            Self::File(unit) | Self::Caller(unit) => unit,
        }
    }
}

impl fmt::Display for Declaration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(unit) => write!(f, "{unit} (by the file)"),
            Self::Caller(unit) => write!(f, "{unit} (as passed)"),
        }
    }
}

/// A height map and what its file says about it. Numbers of points, missing points and lateral steps are those of the
/// map.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Heights (m).
    pub map: HeightMap,
    /// Format of the file.
    pub format: Format,
    /// Unit of positions in the file.
    pub lateral_unit: Declaration,
    /// Unit of heights in the file.
    pub height_unit: Declaration,
    /// Difference of heights (m) that the file's numbers resolve, as stated: the step of heights stored as integers, or
    /// SDF's `Zresolution` if it is coarser.
    pub stated_step: Option<f64>,
    /// Smallest difference (m) between two heights that differ by more than rounding. With few different heights this is the height
    /// step of the instrument, which [`HeightMap::with_height_step`] asks for.
    pub smallest_step: Option<f64>,
    /// Number of different heights.
    pub distinct_heights: usize,
    /// What was ignored or settled by convention, one sentence each.
    pub notes: Vec<String>,
}

/// Reads the file at `path`.
///
/// # Errors
/// [`FileError`]; each names the file, the place where there is one, and what to do.
pub fn read(path: &Path, options: &Options) -> Result<Scan, FileError> {
    let bytes = std::fs::read(path).map_err(|source| Layout::Io {
        path: path.to_owned(),
        source,
    })?;
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

/// The start of a piece of a file, for messages.
fn quoted(text: &[u8]) -> String {
    const SHOWN: usize = 40;
    let shown = String::from_utf8_lossy(&text[..text.len().min(SHOWN)]);
    let more = if text.len() > SHOWN { " ..." } else { "" };
    format!("`{}`{more}", shown.escape_debug())
}

/// The unit of a quantity: the file's, or the caller's.
fn unit(
    file: &str,
    [quantity, option]: [&'static str; 2],
    stated: Option<LengthUnit>,
    given: Option<LengthUnit>,
) -> Result<Declaration, FileError> {
    match (stated, given) {
        (Some(stated), Some(given)) if stated != given => Err(FileError::Contradiction {
            file: file.into(),
            option,
            given: given.to_string(),
            stated: stated.to_string(),
        }),
        (Some(stated), _) => Ok(Declaration::File(stated)),
        (None, Some(given)) => Ok(Declaration::Caller(given)),
        (None, None) => Err(FileError::UnitRequired {
            file: file.into(),
            quantity,
            option,
        }),
    }
}

/// Units of positions and of heights.
fn units(
    file: &str,
    options: &Options,
    lateral: Option<LengthUnit>,
    height: Option<LengthUnit>,
) -> Result<[Declaration; 2], FileError> {
    Ok([
        unit(file, ["its positions", "lateral_unit"], lateral, options.lateral_unit)?,
        unit(file, ["its heights", "height_unit"], height, options.height_unit)?,
    ])
}

/// Steps of a grid in the unit of its positions: the file's, or the caller's.
fn steps(file: &str, format: Format, stated: Option<[f64; 2]>, given: Option<[f64; 2]>) -> Result<[f64; 2], FileError> {
    match (stated, given) {
        (Some(stated), Some(given)) if (0..2).any(|q| (stated[q] - given[q]).abs() > 1e-6 * given[q].abs()) => {
            Err(FileError::Contradiction {
                file: file.into(),
                option: "lateral_step",
                given: format!("{given:?}"),
                stated: format!("{stated:?}"),
            })
        }
        (Some(step), _) | (None, Some(step)) => Ok(step),
        (None, None) => Err(FileError::StepRequired {
            file: file.into(),
            format,
        }),
    }
}

/// A grid as it stands in a file, in metres.
struct Found {
    format: Format,
    size: [usize; 2],
    /// Negative where the axis runs backwards.
    step: [f64; 2],
    origin: [f64; 2],
    /// x running fastest, NaN where missing.
    heights: Vec<f64>,
    lateral_unit: Declaration,
    height_unit: Declaration,
    stated_step: Option<f64>,
    /// Whether the format leaves open where its first line lies.
    rows_open: bool,
    notes: Vec<String>,
}

impl Found {
    /// Turns the axes, makes the map, checks it.
    fn finish(mut self, file: &str, options: &Options) -> Result<Scan, FileError> {
        let text = matches!(self.format, Format::Xyz | Format::Grid);
        let stepless = matches!(self.format, Format::Grid | Format::Npy | Format::Npz);
        let unused = [
            ("lateral_step", options.lateral_step.is_some() && !stepless),
            ("first_row", options.first_row.is_some() && !self.rows_open),
            ("layer", options.layer.is_some() && self.format != Format::X3p),
            ("array", options.array.is_some() && self.format != Format::Npz),
            ("header_lines", options.header_lines.is_some() && !text),
        ];
        if let Some((option, _)) = unused.into_iter().find(|(_, unused)| *unused) {
            return Err(FileError::UnusedOption {
                file: file.into(),
                option,
                format: self.format,
            });
        }
        let [nx, ny] = self.size;
        if self.step[0] < 0.0 {
            self.heights.chunks_mut(nx.max(1)).for_each(<[f64]>::reverse);
        }
        let turned = options.first_row == Some(FirstRow::HighestY);
        if (self.step[1] < 0.0) != turned {
            for j in 0..ny / 2 {
                let (low, high) = self.heights.split_at_mut((ny - 1 - j) * nx);
                low[j * nx..(j + 1) * nx].swap_with_slice(&mut high[..nx]);
            }
        }
        for q in 0..2 {
            if self.step[q] < 0.0 {
                self.origin[q] += self.size[q].saturating_sub(1) as f64 * self.step[q];
                self.step[q] = -self.step[q];
                self.notes.push(format!(
                    "{} runs backwards in the file and was turned over",
                    ["x", "y"][q]
                ));
            }
        }
        if self.rows_open && options.first_row.is_none() {
            self.notes
                .push("the format does not say where its first line lies: taken as the lowest y".into());
        }
        let (smallest_step, distinct_heights) = resolution(&self.heights);
        let map =
            HeightMap::try_new(nx, ny, self.step, self.origin, self.heights).map_err(|source| FileError::Map {
                file: file.into(),
                source,
            })?;
        let scan = Scan {
            map,
            format: self.format,
            lateral_unit: self.lateral_unit,
            height_unit: self.height_unit,
            stated_step: self.stated_step,
            smallest_step,
            distinct_heights,
            notes: self.notes,
        };
        if !options.accept_implausible {
            scan.check_plausibility(file)?;
        }
        Ok(scan)
    }
}

/// Smallest difference between heights that differ by more than rounding, and number of such heights.
fn resolution(heights: &[f64]) -> (Option<f64>, usize) {
    let mut sorted: Vec<f64> = heights.iter().copied().filter(|z| z.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (Some(low), Some(high)) = (sorted.first(), sorted.last()) else {
        return (None, 0);
    };
    let rounding = 8.0 * f64::EPSILON * low.abs().max(high.abs());
    let steps = sorted
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|step| *step > rounding);
    let (count, smallest) = steps.fold((0, f64::INFINITY), |(n, smallest), step| (n + 1, smallest.min(step)));
    ((count > 0).then_some(smallest), count + 1)
}

impl Scan {
    fn check_plausibility(&self, file: &str) -> Result<(), FileError> {
        let map = &self.map;
        let (nx, ny, step) = (map.nx(), map.ny(), map.step());
        let extent = ((nx - 1) as f64 * step[0]).max((ny - 1) as f64 * step[1]);
        let (mut low, mut high, mut slopes, mut pairs) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0usize);
        for j in 0..ny {
            for i in 0..nx {
                let z = map.value(j * nx + i);
                if z.is_nan() {
                    continue;
                }
                (low, high) = (low.min(z), high.max(z));
                let before = [(i > 0).then(|| j * nx + i - 1), (j > 0).then(|| (j - 1) * nx + i)];
                for (q, index) in before.into_iter().enumerate() {
                    let slope = index.map(|index| (z - map.value(index)).abs() / step[q]);
                    if let Some(slope) = slope.filter(|slope| !slope.is_nan()) {
                        slopes += slope;
                        pairs += 1;
                    }
                }
            }
        }
        let range = (high - low).max(0.0);
        let checks = [
            (
                "lateral extent",
                extent,
                " m",
                1e-6,
                1.0,
                "microscopes see no less and profilometers travel no farther",
            ),
            (
                "range of heights over lateral extent",
                range / extent,
                "",
                if range == 0.0 { 0.0 } else { 1e-9 },
                1.0,
                "a scan from above follows no more and no instrument resolves less",
            ),
            (
                "mean slope between neighbours",
                slopes / pairs.max(1) as f64,
                "",
                0.0,
                10.0,
                "no probe or lens follows steeper flanks all over",
            ),
        ];
        for (quantity, value, unit, low, high, reason) in checks {
            if !(value >= low && value <= high) {
                return Err(FileError::Implausible {
                    file: file.into(),
                    quantity,
                    value,
                    unit,
                    low,
                    high,
                    reason,
                    lateral: self.lateral_unit,
                    height: self.height_unit,
                });
            }
        }
        Ok(())
    }
}
