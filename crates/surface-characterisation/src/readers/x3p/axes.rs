//! The axes: where the numbers of points lie in metres.

use file_io::quoted;

use super::document::{AXES, Document};
use crate::error::FileError;

/// An axis of coordinates.
#[derive(Clone, Copy)]
pub(super) struct Axis {
    /// Type of the numbers, unless they are counted.
    pub(super) data: Option<DataType>,
    pub(super) increment: f64,
    pub(super) offset: f64,
}

impl Axis {
    /// The coordinate (m) of a number.
    pub(super) fn metres(&self, number: f64) -> f64 {
        let scaled = if self.increment == 1.0 {
            number
        } else {
            self.increment * number
        };
        // Adding zero would lose the sign of zeros.
        if self.offset == 0.0 {
            scaled
        } else {
            scaled + self.offset
        }
    }
}

/// Type of stored numbers.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum DataType {
    I,
    L,
    F,
    D,
}

impl DataType {
    /// Number of bytes.
    pub(super) fn width(self) -> usize {
        match self {
            Self::I => 2,
            Self::L | Self::F => 4,
            Self::D => 8,
        }
    }

    /// The number at the start of a piece that is long enough.
    pub(super) fn number(self, bytes: &[u8]) -> Option<f64> {
        Some(match self {
            Self::I => i16::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::L => i32::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::F => f32::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::D => f64::from_le_bytes(*bytes.first_chunk()?),
        })
    }
}

/// The axes x, y and z. Where the document states a rotation, the offsets are left out, and this is noted.
pub(super) fn axes(document: &Document<'_>, notes: &mut Vec<String>) -> Result<[Axis; 3], FileError> {
    let rotated = is_rotated(document)?;
    let [x, y, z] = AXES;
    let mut axes = [axis(document, x)?, axis(document, y)?, axis(document, z)?];
    if axes[2].data.is_none() {
        let at = document.at("Record1/Axes/CZ/AxisType");
        return Err(document.malformed(at, "an incremental axis z", "an absolute one"));
    }
    if rotated {
        let offsets = axes.map(|axis| axis.offset);
        notes.push(format!(
            "rotation and offsets {offsets:?} m not applied: the map is in the axes of its grid"
        ));
        axes.iter_mut().for_each(|axis| axis.offset = 0.0);
    }
    Ok(axes)
}

/// Whether the stated rotation turns the axes.
fn is_rotated(document: &Document<'_>) -> Result<bool, FileError> {
    let mut rotated = false;
    for row in 1..=3 {
        for column in 1..=3 {
            let entry = document.real(&format!("Record1/Axes/Rotation/r{row}{column}"))?;
            let unit = f64::from(u8::from(row == column));
            // Angles below 1e-6 move no point of a field by as much as a step.
            rotated |= (entry.unwrap_or(unit) - unit).abs() > 1e-6;
        }
    }
    Ok(rotated)
}

fn axis(document: &Document<'_>, name: &str) -> Result<Axis, FileError> {
    let path = |field: &str| format!("Record1/Axes/{name}/{field}");
    let refused = |field: &str, found: &str, expected: &str| {
        let path = path(field);
        document.malformed(
            document.at(&path),
            quoted(found.as_bytes()),
            format!("{expected} as `{path}`"),
        )
    };
    let data = match document.required(&path("AxisType"))? {
        "I" => None,
        "A" => Some(match document.required(&path("DataType"))? {
            "I" => DataType::I,
            "L" => DataType::L,
            "F" => DataType::F,
            "D" => DataType::D,
            other => return Err(refused("DataType", other, "I, L, F or D")),
        }),
        other => return Err(refused("AxisType", other, "I or A")),
    };
    let increment = match document.real(&path("Increment"))? {
        Some(0.0) => return Err(refused("Increment", "0", "a number that is not zero")),
        Some(increment) => increment,
        None if data.is_some() => 1.0,
        None => return Err(refused("Increment", "", "the length of a step")),
    };
    Ok(Axis {
        data,
        increment,
        offset: document.real(&path("Offset"))?.unwrap_or(0.0),
    })
}
