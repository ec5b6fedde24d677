//! What the caller knows of a file, and how it goes together with what the file says.

use super::format::Format;
use super::units::{Declaration, LengthUnit};
use crate::error::FileError;

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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

impl Options {
    /// Units of positions and of heights.
    pub(super) fn units(
        &self,
        file: &str,
        lateral: Option<LengthUnit>,
        height: Option<LengthUnit>,
    ) -> Result<[Declaration; 2], FileError> {
        Ok([
            unit(file, ["its positions", "lateral_unit"], lateral, self.lateral_unit)?,
            unit(file, ["its heights", "height_unit"], height, self.height_unit)?,
        ])
    }

    /// Steps of a grid in the unit of its positions: the file's, or the caller's.
    pub(super) fn steps(&self, file: &str, format: Format, stated: Option<[f64; 2]>) -> Result<[f64; 2], FileError> {
        match (stated, self.lateral_step) {
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
