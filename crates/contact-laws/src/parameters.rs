use alloc::vec::Vec;

use crate::error::Error;

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
