//! Fourier coefficients of periodic vectors.

use rayon::prelude::*;
use std::f64::consts::PI;

/// Coefficients of `x(t) = X_0 + sum_h (C_h cos(h w t) + S_h sin(h w t))`, column after column: `X_0, C_1, S_1, C_2, ...`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Harmonics {
    size: usize,
    values: Vec<f64>,
}

impl Harmonics {
    /// Zeros, of vectors of `size` numbers and harmonics 0 to `count`.
    pub fn zeros(size: usize, count: usize) -> Self {
        Self {
            size,
            values: vec![0.0; size * (2 * count + 1)],
        }
    }

    /// Numbers of a vector.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The highest harmonic.
    pub fn count(&self) -> usize {
        self.values.len() / self.size.max(1) / 2
    }

    /// Number of columns, `2 count + 1`.
    pub fn n_columns(&self) -> usize {
        2 * self.count() + 1
    }

    /// A column: 0 the mean, `2 h - 1` the cosine and `2 h` the sine of harmonic `h`.
    pub fn column(&self, column: usize) -> &[f64] {
        &self.values[column * self.size..][..self.size]
    }

    /// The same, to be written.
    pub fn column_mut(&mut self, column: usize) -> &mut [f64] {
        &mut self.values[column * self.size..][..self.size]
    }

    /// Cosine and sine of harmonic `h >= 1`.
    pub fn pair(&self, h: usize) -> [&[f64]; 2] {
        [self.column(2 * h - 1), self.column(2 * h)]
    }

    /// The same, to be written.
    pub(crate) fn pair_mut(&mut self, h: usize) -> [&mut [f64]; 2] {
        let (cosine, sine) = self.values[(2 * h - 1) * self.size..][..2 * self.size].split_at_mut(self.size);
        [cosine, sine]
    }

    /// All numbers, column after column.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The same, to be written.
    pub(crate) fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// The same motion with harmonics up to `count`: zeros are added, or the highest ones left out.
    pub fn with_count(&self, count: usize) -> Self {
        let mut values = self.values.clone();
        values.resize(self.size * (2 * count + 1), 0.0);
        Self {
            size: self.size,
            values,
        }
    }

    /// Calls `change` for each column, in parallel.
    pub(crate) fn each_column(&mut self, change: impl Fn(usize, &mut [f64]) + Sync) {
        self.values
            .par_chunks_mut(self.size.max(1))
            .enumerate()
            .for_each(|(column, values)| change(column, values));
    }

    /// `self += factor * other`.
    pub(crate) fn add(&mut self, factor: f64, other: &Self) {
        for (a, b) in self.values.iter_mut().zip(&other.values) {
            *a += factor * b;
        }
    }

    /// `self *= factor`.
    pub(crate) fn scale(&mut self, factor: f64) {
        self.values.iter_mut().for_each(|v| *v *= factor);
    }

    /// Sum of the products of all coefficients.
    pub(crate) fn dot(&self, other: &Self) -> f64 {
        self.values.iter().zip(&other.values).map(|(a, b)| a * b).sum()
    }

    /// Work of this force along a motion over a period (J).
    pub fn work(&self, motion: &Self) -> f64 {
        let of = |h: usize| {
            let ([fc, fs], [c, s]) = (self.pair(h), motion.pair(h));
            let sum: f64 =
                fc.iter().zip(s).map(|(f, v)| f * v).sum::<f64>() - fs.iter().zip(c).map(|(f, v)| f * v).sum::<f64>();
            PI * h as f64 * sum
        };
        (1..=motion.count()).map(of).sum()
    }

    /// `along^T x` of every column.
    pub fn along(&self, row: &[f64]) -> Vec<f64> {
        (0..self.n_columns())
            .map(|column| self.column(column).iter().zip(row).map(|(a, b)| a * b).sum())
            .collect()
    }
}

/// Adds `(x + i y)` times the complex coefficient `c - i s` of `from` to that of `to`.
pub(crate) fn add_rotated(to: [&mut [f64]; 2], from: [&[f64]; 2], x: f64, y: f64) {
    let [to_c, to_s] = to;
    let [c, s] = from;
    for (((to_c, to_s), c), s) in to_c.iter_mut().zip(to_s).zip(c).zip(s) {
        *to_c += x * c + y * s;
        *to_s += x * s - y * c;
    }
}
