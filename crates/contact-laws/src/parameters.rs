use alloc::vec::Vec;

use crate::error::{Error, Place, require};
use crate::law::Quantity;

/// A parameter of curves: what documents and refusals say of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name, unique among the parameters of its curves.
    pub name: &'static str,
    /// SI unit, `1` without.
    pub unit: &'static str,
    /// What is asked of its value.
    pub bounds: Bounds,
}

/// What is asked of a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bounds {
    /// Finite and above zero.
    Positive,
    /// Finite and not negative.
    NotNegative,
    /// Between two values, both included; the text says the same.
    Within([f64; 2], &'static str),
    /// More than one number can tell.
    Other(&'static str),
}

impl Bounds {
    /// The same in words, after "must be".
    pub const fn text(&self) -> &'static str {
        match self {
            Self::Positive => "finite and above zero",
            Self::NotNegative => "finite and not negative",
            Self::Within(_, text) | Self::Other(text) => text,
        }
    }

    fn admit(&self, value: f64) -> bool {
        match self {
            Self::Positive => value.is_finite() && value > 0.0,
            Self::NotNegative => value.is_finite() && value >= 0.0,
            Self::Within([lower, upper], _) => (*lower..=*upper).contains(&value),
            Self::Other(_) => true,
        }
    }
}

impl Parameter {
    /// With its bounds.
    pub const fn new(name: &'static str, unit: &'static str, bounds: Bounds) -> Self {
        Self { name, unit, bounds }
    }

    /// The same bounds for a value of another name.
    pub(crate) const fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// Name and unit.
    pub const fn quantity(&self) -> Quantity {
        Quantity::new(self.name, self.unit)
    }

    /// Refuses a value out of bounds.
    pub(crate) fn check(&self, value: f64) -> Result<(), Error> {
        self.check_at(Place::Whole, value)
    }

    /// The same of one entry of a list, or of one point.
    pub(crate) fn check_at(&self, place: Place, value: f64) -> Result<(), Error> {
        let unit = if self.unit == "1" { "(no unit)" } else { self.unit };
        require(
            self.bounds.admit(value),
            self.name,
            value,
            unit,
            place,
            self.bounds.text(),
        )
    }
}

/// Refuses a parameter that is not finite and above zero.
pub(crate) fn require_positive(parameter: &'static str, value: f64, unit: &'static str) -> Result<(), Error> {
    Parameter::new(parameter, unit, Bounds::Positive).check(value)
}

/// A parameter, or a set of parameters, for every point of a law.
#[derive(Debug, Clone, PartialEq)]
pub struct PointParameters<T>(Storage<T>);

#[derive(Debug, Clone, PartialEq)]
enum Storage<T> {
    Uniform { value: T, n_points: usize },
    PerPoint(Vec<T>),
    Indexed { values: Vec<T>, index: Vec<u32> },
}

impl<T> PointParameters<T> {
    /// The same `value` at `n_points` points.
    pub fn uniform(value: T, n_points: usize) -> Self {
        Self(Storage::Uniform { value, n_points })
    }

    /// One value for all of `n_points` points, or else one per point.
    pub fn one_or_each(mut values: Vec<T>, n_points: usize) -> Self {
        match values.len() {
            1 => Self::uniform(values.remove(0), n_points),
            _ => Self::per_point(values),
        }
    }

    /// One value per point.
    pub fn per_point(values: Vec<T>) -> Self {
        Self(Storage::PerPoint(values))
    }

    /// Few values that many points share, for instance one per element: point `i` uses `values[index[i]]`.
    ///
    /// # Errors
    /// [`Error::Index`] when an index does not exist.
    pub fn try_indexed(values: Vec<T>, index: Vec<u32>) -> Result<Self, Error> {
        match index.iter().position(|&i| i as usize >= values.len()) {
            Some(point) => Err(Error::Index {
                point,
                index: index[point],
                n_sets: values.len(),
            }),
            None => Ok(Self(Storage::Indexed { values, index })),
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        match &self.0 {
            Storage::Uniform { n_points, .. } => *n_points,
            Storage::PerPoint(values) => values.len(),
            Storage::Indexed { index, .. } => index.len(),
        }
    }

    /// True when there is no point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// True when all points share one value by construction.
    pub fn is_uniform(&self) -> bool {
        matches!(self.0, Storage::Uniform { .. })
    }

    /// What follows from each set of values, at the points that have it.
    pub(crate) fn try_map<U, E>(&self, of: impl FnMut(&T) -> Result<U, E>) -> Result<PointParameters<U>, E> {
        let mut of = of;
        Ok(PointParameters(match &self.0 {
            Storage::Uniform { value, n_points } => Storage::Uniform {
                value: of(value)?,
                n_points: *n_points,
            },
            Storage::PerPoint(values) => Storage::PerPoint(values.iter().map(of).collect::<Result<_, E>>()?),
            Storage::Indexed { values, index } => Storage::Indexed {
                values: values.iter().map(of).collect::<Result<_, E>>()?,
                index: index.clone(),
            },
        }))
    }

    /// All sets of values.
    pub(crate) fn sets(&self) -> &[T] {
        match &self.0 {
            Storage::Uniform { value, .. } => core::slice::from_ref(value),
            Storage::PerPoint(values) | Storage::Indexed { values, .. } => values,
        }
    }

    /// Which of [`Self::sets`] belongs to each of the points from `first` on.
    pub(crate) fn copy_set_numbers(&self, first: usize, into: &mut [u32]) {
        let n = into.len();
        match &self.0 {
            Storage::Uniform { .. } => into.fill(0),
            Storage::PerPoint(_) => {
                for (i, into) in into.iter_mut().enumerate() {
                    *into = (first + i) as u32;
                }
            }
            Storage::Indexed { index, .. } => into.copy_from_slice(&index[first..][..n]),
        }
    }

    /// Value at `point`.
    ///
    /// # Panics
    /// When `point` does not exist (a uniform value does not check).
    #[inline]
    pub fn at(&self, point: usize) -> &T {
        match &self.0 {
            Storage::Uniform { value, .. } => value,
            Storage::PerPoint(values) => &values[point],
            Storage::Indexed { values, index } => &values[index[point] as usize],
        }
    }
}

impl PointParameters<f64> {
    /// Copies the values from point `first` on.
    pub(crate) fn copy_to(&self, first: usize, into: &mut [f64]) {
        let n = into.len();
        match &self.0 {
            Storage::Uniform { value, .. } => into.fill(*value),
            Storage::PerPoint(values) => into.copy_from_slice(&values[first..][..n]),
            Storage::Indexed { values, index } => {
                for (into, &index) in into.iter_mut().zip(&index[first..][..n]) {
                    *into = values[index as usize];
                }
            }
        }
    }
}
