use core::fmt;

/// Where in the input a refused value stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The value holds for everything that is being made.
    Whole,
    /// Value of one point, counted from 0.
    Point(usize),
    /// Entry of a list (sample, quantile), counted from 0.
    Entry(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Whole => Ok(()),
            Place::Point(i) => write!(f, " at point {i}"),
            Place::Entry(i) => write!(f, " at entry {i}"),
        }
    }
}

/// Why a law, a curve or a population was refused.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub enum Error {
    /// A parameter is outside what its law allows.
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// Where it stands.
        place: Place,
        /// What is asked of it.
        requirement: &'static str,
    },
    /// Two lists that belong together differ in length.
    Length {
        /// Name of the list.
        list: &'static str,
        /// Length it must have.
        expected: usize,
        /// Length it has.
        found: usize,
    },
    /// A point refers to a parameter set that does not exist.
    Index {
        /// The point, counted from 0.
        point: usize,
        /// Its index.
        index: u32,
        /// Number of parameter sets.
        n_sets: usize,
    },
    /// Two choices exclude each other.
    Combination {
        /// One choice.
        first: &'static str,
        /// The other.
        second: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A curve does not rise everywhere in its range.
    NotMonotone {
        /// The curve.
        curve: &'static str,
        /// Interference (m) where the slope is least.
        interference: f64,
        /// The slope `d ln(value) / d ln(u_n)` there.
        log_slope: f64,
    },
    /// A table does not reach the tolerance asked for with the knots allowed.
    Tolerance {
        /// The curve.
        curve: &'static str,
        /// Interference (m) of the largest error.
        interference: f64,
        /// Largest relative error.
        error: f64,
        /// Tolerance asked for.
        tolerance: f64,
        /// Knots per octave reached.
        knots_per_octave: u32,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Parameter {
                parameter,
                value,
                unit,
                place,
                requirement,
            } => {
                let quantity = alloc::format!("{value:e} {unit}");
                write!(f, "{parameter} = {}{place}: must be {requirement}", quantity.trim_end())
            }
            Error::Length { list, expected, found } => {
                write!(
                    f,
                    "{list} has {found} entries where {expected} are needed: give one per point"
                )
            }
            Error::Index { point, index, n_sets } => {
                write!(
                    f,
                    "point {point} asks for parameter set {index}, but there are {n_sets}: use 0..{n_sets}"
                )
            }
            Error::Combination { first, second, remedy } => {
                write!(f, "{first} do not go with {second}: {remedy}")
            }
            Error::NotMonotone {
                curve,
                interference,
                log_slope,
            } => write!(
                f,
                "{curve} has log-slope {log_slope:e} at u_n = {interference:e} m: it must not fall, \
                 make it again with a bound on its slope or narrow the range"
            ),
            Error::Tolerance {
                curve,
                interference,
                error,
                tolerance,
                knots_per_octave,
            } => write!(
                f,
                "table of {curve} has relative error {error:e} at u_n = {interference:e} m with {knots_per_octave} \
                 knots per octave, asked for {tolerance:e}: raise the tolerance or the number of knots"
            ),
        }
    }
}

impl core::error::Error for Error {}

/// Refuses a parameter unless `ok`.
pub(crate) fn require(
    ok: bool,
    parameter: &'static str,
    value: f64,
    unit: &'static str,
    place: Place,
    requirement: &'static str,
) -> Result<(), Error> {
    if ok {
        Ok(())
    } else {
        Err(Error::Parameter {
            parameter,
            value,
            unit,
            place,
            requirement,
        })
    }
}
