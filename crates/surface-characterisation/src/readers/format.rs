//! The formats of files.

use std::fmt;

/// Formats of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
