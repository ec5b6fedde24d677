//! The errors of the crate: of surfaces, and of the files that hold them.

use file_io::Place;
use thiserror::Error;

use crate::readers::{Declaration, Format, UnknownUnit};

/// Why a surface could not be characterised.
///
/// Every variant names the field or place, the value, its unit, and what to do about it.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SurfaceError {
    /// A scalar lies outside the range in which the method is defined.
    #[error("{field} = {}: must be {requirement}", format!("{value} {unit}").trim_end())]
    InvalidValue {
        /// Name of the field.
        field: &'static str,
        /// The value given.
        value: f64,
        /// Its unit (`1` when dimensionless).
        unit: &'static str,
        /// What is required of it.
        requirement: &'static str,
    },
    /// An array has another length than its companions require.
    #[error("{field} has {found} entries, expected {expected}: {remedy}")]
    LengthMismatch {
        /// Name of the array.
        field: &'static str,
        /// Length given.
        found: usize,
        /// Length required.
        expected: usize,
        /// What to do.
        remedy: &'static str,
    },
    /// Whoever asked for the work has ended it.
    #[error("the characterisation was interrupted")]
    Interrupted,
    /// Boundary elements did not find the contact of a surface.
    #[error(
        "contact of the surface at a mean pressure of {pressure:e} of the contact modulus: after {iterations} iterations gaps where there is contact are \
         {residual:e} of the rms deflection; take another law, or look for spikes in the scans"
    )]
    NoContact {
        /// Mean pressure over the contact modulus.
        pressure: f64,
        /// Gap over the rms deflection.
        residual: f64,
        /// Iterations made.
        iterations: usize,
    },
    /// A height is infinite. Missing data are marked by NaN.
    #[error("height of point ({i}, {j}) is {value} m: heights are finite, missing points are NaN")]
    InfiniteHeight {
        /// Column, along x.
        i: usize,
        /// Row, along y.
        j: usize,
        /// The value given.
        value: f64,
    },
    /// An array holds a value that is not finite or not in order.
    #[error("{field}[{index}] = {}: must be {requirement}", format!("{value} {unit}").trim_end())]
    InvalidSample {
        /// Name of the array.
        field: &'static str,
        /// Position in it.
        index: usize,
        /// The value given.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// What is required of it.
        requirement: &'static str,
    },
    /// An interface element is not a simple triangle or quadrilateral of the given nodes.
    #[error("interface element {element}: {problem}; give 3 or 4 distinct nodes in order around a simple polygon")]
    InvalidElement {
        /// Index of the element.
        element: usize,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A plane was asked for where there are too few points, or points on one line.
    #[error(
        "{place}: {points} points with data do not determine a plane; \
         widen the region, choose another reference or check the pose of the height map"
    )]
    UndeterminedPlane {
        /// Which plane.
        place: &'static str,
        /// Points found.
        points: usize,
    },
    /// An element has too few points with data on one face.
    #[error(
        "element {element}, {face} face: {points} points with data ({missing} missing), at least {needed} not in one \
         line are needed; check pose and mask of the height map, or coarsen the interface mesh"
    )]
    TooFewPoints {
        /// Index of the element.
        element: usize,
        /// `top` or `bottom`.
        face: &'static str,
        /// Points with data inside the element.
        points: usize,
        /// Points without data inside the element.
        missing: usize,
        /// Least number.
        needed: usize,
    },
    /// Neither face has a single roughness peak in this element.
    #[error(
        "element {element}: no peak on either face ({points_top} and {points_bottom} points), so there is no \
         asperity to contact; check height step and lateral step of the scans, or coarsen the interface mesh"
    )]
    NoPeaks {
        /// Index of the element.
        element: usize,
        /// Points of the top face.
        points_top: usize,
        /// Points of the bottom face.
        points_bottom: usize,
    },
    /// The masks do not fix where a height map lies.
    #[error(
        "alignment along {axis}: moving the map by one step leaves as many points inside the elements; it covers more \
         than the interface or its mask has no edge there: mask what lies beyond the face, or give the shift yourself"
    )]
    UndeterminedAlignment {
        /// `x` or `y`.
        axis: &'static str,
    },
    /// Two element fields have no rank correlation.
    #[error(
        "{change} against {field}: fewer than 3 elements in common, or one value in all of them; leave the field out, \
         or give a run in which it varies"
    )]
    UndefinedCorrelation {
        /// Name of the change.
        change: String,
        /// Name of the field.
        field: String,
    },
    /// A curve has too few usable samples for a fit.
    #[error("{curve}: {found} samples above zero, a fit needs at least {needed}; sample the curve over a wider range")]
    TooFewSamples {
        /// Which curve.
        curve: &'static str,
        /// Usable samples.
        found: usize,
        /// Samples needed.
        needed: usize,
    },
}

/// Why a scan could not be read or written.
#[non_exhaustive]
#[derive(Debug, Error)]
pub enum FileError {
    /// The file cannot be opened, breaks the rules of its format, is of a variant that is not read, or claims to hold
    /// more than it can.
    #[error(transparent)]
    Layout(#[from] matrix_files::Error),
    /// Nothing in the file tells its format.
    #[error(
        "{file}: the contents, beginning with {found}, are {problem}; give a scan as X3P, SDF (ISO 25178-71 or BCR), \
         SUR, .npy, .npz or text (grid or x y z)"
    )]
    UnknownFormat {
        /// File.
        file: String,
        /// Its first bytes.
        found: String,
        /// Why they are not understood.
        problem: String,
    },
    /// A checksum of the file does not match.
    #[error("{file}: `{part}` has the MD5 checksum {computed}, but {stated} is stated; the file was damaged or edited")]
    Checksum {
        /// File.
        file: String,
        /// Member of the archive.
        part: String,
        /// Checksum stated, hexadecimal.
        stated: String,
        /// Checksum computed.
        computed: String,
    },
    /// The file does not say in which unit its numbers are, and neither does the caller.
    #[error("{file}: the file does not state the unit of {quantity}; pass `{option}` (m, mm, um, nm, ...)")]
    UnitRequired {
        /// File.
        file: String,
        /// Whose unit.
        quantity: &'static str,
        /// Field of [`crate::readers::Options`] to set.
        option: &'static str,
    },
    /// The file states a unit that is not known.
    #[error("{file}, {place}: {source}")]
    Unit {
        /// File.
        file: String,
        /// Place.
        place: Place,
        /// The unit.
        source: UnknownUnit,
    },
    /// The file does not say how far apart its points are, and neither does the caller.
    #[error(
        "{file}: {format} without positions of its points; pass `lateral_step`, the distances of neighbours along x and \
         y in `lateral_unit`"
    )]
    StepRequired {
        /// File.
        file: String,
        /// Its format.
        format: Format,
    },
    /// The caller states something else than the file.
    #[error("{file}: `{option}` is given as {given}, but the file states {stated}; leave it out, or correct the file")]
    Contradiction {
        /// File.
        file: String,
        /// Field of [`crate::readers::Options`].
        option: &'static str,
        /// What the caller says.
        given: String,
        /// What the file says.
        stated: String,
    },
    /// The caller asks for something that has no meaning for this file.
    #[error("{file}: `{option}` has no meaning for this {format}; leave it out")]
    UnusedOption {
        /// File.
        file: String,
        /// Field of [`crate::readers::Options`].
        option: &'static str,
        /// Format of the file.
        format: Format,
    },
    /// The file holds several height maps, or not the one asked for.
    #[error("{file}: the height map is not determined, since the file holds {found}; pass `{option}`")]
    Choice {
        /// File.
        file: String,
        /// What there is.
        found: String,
        /// Field of [`crate::readers::Options`] to set.
        option: &'static str,
    },
    /// The points do not form a regular grid along x and y.
    #[error("{file}, {place}: {problem}; resample the points onto a regular grid along x and y, or export the grid")]
    NotAGrid {
        /// File.
        file: String,
        /// Place.
        place: Place,
        /// What is wrong.
        problem: String,
    },
    /// What was read cannot be a scan: most likely a unit is wrong.
    #[error(
        "{file}: the {quantity} is {value:.3e}{unit}, expected {low:e} to {high:e}{unit}, since {reason}; positions were \
         taken in {lateral}, heights in {height}: correct the one that is wrong, or set `accept_implausible`"
    )]
    Implausible {
        /// File.
        file: String,
        /// What is out of range.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// Its unit with a leading space, empty when dimensionless.
        unit: &'static str,
        /// Smallest plausible value.
        low: f64,
        /// Largest plausible value.
        high: f64,
        /// Why.
        reason: &'static str,
        /// Unit of positions.
        lateral: Declaration,
        /// Unit of heights.
        height: Declaration,
    },
    /// The heights make no map.
    #[error("{file}: {source}")]
    Map {
        /// File.
        file: String,
        /// Why not.
        source: SurfaceError,
    },
}

/// Returns `value` if it is finite and `> 0`.
pub(crate) fn positive(field: &'static str, value: f64, unit: &'static str) -> Result<f64, SurfaceError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(SurfaceError::InvalidValue {
            field,
            value,
            unit,
            requirement: "finite and greater than zero",
        })
    }
}

/// Returns `value` if it is finite and `>= 0`.
pub(crate) fn not_negative(field: &'static str, value: f64, unit: &'static str) -> Result<f64, SurfaceError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(SurfaceError::InvalidValue {
            field,
            value,
            unit,
            requirement: "finite and not negative",
        })
    }
}

/// Returns `value` if it is finite.
pub(crate) fn finite(field: &'static str, value: f64, unit: &'static str) -> Result<f64, SurfaceError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(SurfaceError::InvalidValue {
            field,
            value,
            unit,
            requirement: "finite",
        })
    }
}

/// Refuses lists with values that are not finite.
pub(crate) fn finite_samples(field: &'static str, values: &[f64], unit: &'static str) -> Result<(), SurfaceError> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(SurfaceError::InvalidSample {
            field,
            index,
            value: values[index],
            unit,
            requirement: "finite",
        }),
    }
}
