//! Why the finish of a face could not be understood.

use thiserror::Error;

use crate::error::SurfaceError;

/// Why a drawing or a roughness report does not describe a face, or a pair of faces cannot be made of it.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FinishError {
    /// A value outside its range.
    #[error("{field} = {}; it must be {requirement}", format!("{value} {unit}").trim_end())]
    Value {
        /// Field of the face or of the pair.
        field: &'static str,
        /// Value given.
        value: f64,
        /// Its unit, empty without one.
        unit: &'static str,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// Something that the law depends on is not said.
    #[error("{what} is not given; {remedy}")]
    Missing {
        /// What is missing.
        what: &'static str,
        /// A field to add.
        remedy: &'static str,
    },
    /// Two fields that say the same, or a field without effect.
    #[error("`{field}` is given together with `{other}`; {remedy}")]
    Conflict {
        /// One field.
        field: &'static str,
        /// The other.
        other: &'static str,
        /// Which one to leave out.
        remedy: &'static str,
    },
    /// Two parameters of one surface in an order that no surface has.
    #[error("{smaller} = {first:.4e} m is above {larger} = {second:.4e} m; {reason}")]
    Order {
        /// Parameter that cannot be the larger one.
        smaller: &'static str,
        /// Its value (m).
        first: f64,
        /// Parameter that cannot be the smaller one.
        larger: &'static str,
        /// Its value (m).
        second: f64,
        /// Why, and what to check.
        reason: &'static str,
    },
    /// A kurtosis below that of any distribution.
    #[error(
        "kurtosis = {kurtosis} with skewness = {skewness}; it must be above skewness^2 + 1 = {}, which every distribution \
         exceeds (a Gaussian one has 3, without subtraction)", skewness * skewness + 1.0
    )]
    Kurtosis {
        /// Skewness.
        skewness: f64,
        /// Kurtosis.
        kurtosis: f64,
    },
    /// Moments that the family of distributions does not reach.
    #[error(
        "skewness = {skewness} with kurtosis = {kurtosis} is beyond what the sinh-arcsinh distribution reaches, by which \
         Gaussian heights are bent; give a kurtosis farther above skewness^2 + 1, or scan the faces"
    )]
    Translation {
        /// Skewness.
        skewness: f64,
        /// Kurtosis.
        kurtosis: f64,
    },
    /// Mean width of profile elements and correlation length of different surfaces.
    #[error(
        "rsm = {rsm:.4e} m with correlation_length = {length:.4e} m; a correlation that falls to 1/e there has profile \
         elements {expected:.4e} m wide, and the two differ by more than a factor of 1.5; leave one of them out"
    )]
    Spacing {
        /// Mean width of the profile elements (m).
        rsm: f64,
        /// Correlation length (m).
        length: f64,
        /// Width that belongs to it (m).
        expected: f64,
    },
    /// A grid that does not resolve the correlation.
    #[error(
        "the correlation length of {length:.4e} m along {axis} is below two grid steps of {step:.4e} m; give a smaller \
         step, or leave it out"
    )]
    Unresolved {
        /// Correlation length along that axis (m).
        length: f64,
        /// `x` or `y`.
        axis: &'static str,
        /// Grid step (m).
        step: f64,
    },
    /// A patch that holds too little of the roughness, or too many points.
    #[error(
        "a window of {window:.4e} m along {axis} at steps of {step:.4e} m has {points} points; between {least} and \
         {most} are computed; give another window or step"
    )]
    Points {
        /// Side of the window (m).
        window: f64,
        /// `x` or `y`.
        axis: &'static str,
        /// Grid step (m).
        step: f64,
        /// Points.
        points: f64,
        /// Least number.
        least: usize,
        /// Greatest number.
        most: usize,
    },
    /// A reading of the characterisation that the theory has no expectation for.
    #[error("the fast route has no theory for {reading}; leave it out, or take \"route\": \"ensemble\"")]
    Reading {
        /// The reading.
        reading: &'static str,
    },
    /// The characterisation of a synthesised patch.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The contact laws' own.
    #[error("the law of a patch: {0}")]
    Law(String),
}

impl From<contact_laws::Error> for FinishError {
    fn from(error: contact_laws::Error) -> Self {
        Self::Law(error.to_string())
    }
}

/// Refuses a value that is not positive and finite.
pub(super) fn positive(field: &'static str, value: f64, unit: &'static str) -> Result<f64, FinishError> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(FinishError::Value {
        field,
        value,
        unit,
        requirement: "positive and finite",
    })
}
