//! Inverses of matrices that a reflection of the coordinates leaves as they are: two of half the size.

use crate::packed::Symmetric;
use crate::{Error, cholesky_in_place};
use faer::{Mat, MatRef};
use rayon::prelude::*;

/// A reflection of coordinates: each has an image and a sign, and is the image of its image.
#[derive(Clone, Debug, PartialEq)]
pub struct Reflection {
    images: Vec<(usize, f64)>,
}

impl Reflection {
    /// Images and signs of one, or none if they are not those of a reflection.
    pub fn try_new(images: Vec<(usize, f64)>) -> Option<Self> {
        let returns = |(i, &(j, sign)): (usize, &(usize, f64))| sign.abs() == 1.0 && images.get(j) == Some(&(i, sign));
        images.iter().enumerate().all(returns).then_some(Self { images })
    }

    /// The same of more coordinates, of which the others stay as they are.
    #[must_use]
    pub fn of_first(mut self, count: usize) -> Self {
        self.images.extend((self.images.len()..count).map(|i| (i, 1.0)));
        self
    }

    /// Image and sign of a coordinate.
    ///
    /// # Panics
    /// If there is no such coordinate.
    pub fn image(&self, i: usize) -> (usize, f64) {
        self.images[i]
    }

    /// Whether it leaves a symmetric matrix as it is: no entry `ij` changes by more than `tolerance` times the root of the product of the entries `ii`
    /// and `jj`.
    fn keeps(&self, a: MatRef<'_, f64>, tolerance: f64) -> bool {
        let own: Vec<f64> = (0..a.nrows()).map(|i| a[(i, i)].abs().sqrt()).collect();
        (0..a.ncols()).into_par_iter().all(|j| {
            let (of, sign) = self.images[j];
            let (column, image) = (a.col(j), a.col(of));
            j > of
                || column.iter().enumerate().all(|(i, value)| {
                    let (at, turned) = self.images[i];
                    // Also false for NaN.
                    (value - sign * turned * image[at]).abs() <= tolerance * own[i] * own[j]
                })
        })
    }
}

/// Two coordinates that are the image of each other, or one that is its own, in a combination that the reflection leaves as it is or reverses.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    first: usize,
    /// The other one and its factor.
    second: Option<(usize, f64)>,
}

impl Pair {
    fn members(self) -> impl Iterator<Item = (usize, f64)> {
        let weight = if self.second.is_some() { 0.5_f64.sqrt() } else { 1.0 };
        let second = self.second.map(|(i, factor)| (i, weight * factor));
        std::iter::once((self.first, weight)).chain(second)
    }
}

/// The inverse of a symmetric matrix that a reflection leaves as it is. It takes half the memory of [`Symmetric`], and half of its traffic.
#[derive(Clone, Debug, PartialEq)]
pub struct ReflectedInverse {
    size: usize,
    /// Combinations that the reflection leaves as they are, and those that it reverses, with the inverses over them.
    parts: [(Vec<Pair>, Symmetric); 2],
}

impl ReflectedInverse {
    /// The inverse of `a` and entries added to it, rows, columns and values that the reflection leaves as they are together: of the part of `a` that it
    /// leaves as it is, if this is all of `a` but for `tolerance` times the roots of the products of diagonal entries.
    ///
    /// # Errors
    /// [`Error::NotPositiveDefinite`], with a pivot of one of the two parts.
    ///
    /// # Panics
    /// If the matrix is not square, the reflection is that of another number of coordinates, or an entry is outside.
    pub fn try_new(
        a: MatRef<'_, f64>,
        entries: impl Iterator<Item = (usize, usize, f64)> + Clone,
        reflection: &Reflection,
        tolerance: f64,
    ) -> Result<Option<Self>, Error> {
        let size = a.nrows();
        assert!(a.ncols() == size && reflection.images.len() == size);
        if !reflection.keeps(a, tolerance) {
            return Ok(None);
        }
        let part = |parity: f64| {
            let of = |first: usize| {
                let (second, sign) = reflection.images[first];
                match first.cmp(&second) {
                    std::cmp::Ordering::Less => Some(Pair {
                        first,
                        second: Some((second, parity * sign)),
                    }),
                    std::cmp::Ordering::Equal => (sign == parity).then_some(Pair { first, second: None }),
                    std::cmp::Ordering::Greater => None,
                }
            };
            let pairs: Vec<Pair> = (0..size).filter_map(of).collect();
            let mut block = Mat::zeros(pairs.len(), pairs.len());
            let columns = block.par_col_iter_mut().zip(&pairs).enumerate();
            columns.for_each(|(j, (block, column))| {
                for (entry, row) in block.iter_mut().zip(&pairs).skip(j) {
                    for (l, factor) in column.members() {
                        for (k, weight) in row.members() {
                            *entry += weight * factor * a[(k, l)];
                        }
                    }
                }
            });
            // Of each coordinate the combination that it takes part in, and its weight there.
            let mut places = vec![None; size];
            for (at, pair) in pairs.iter().enumerate() {
                pair.members().for_each(|(i, weight)| places[i] = Some((at, weight)));
            }
            for (row, column, value) in entries.clone() {
                if let (Some((i, weight)), Some((j, factor))) = (places[row], places[column])
                    && i >= j
                {
                    block[(i, j)] += weight * factor * value;
                }
            }
            let lower = cholesky_in_place(block)?;
            Ok((pairs, Symmetric::inverse_of_factor(lower.as_ref())))
        };
        Ok(Some(Self {
            size,
            parts: [part(1.0)?, part(-1.0)?],
        }))
    }

    /// `y = self x`. The order of summation is fixed.
    ///
    /// # Panics
    /// If the lengths do not fit.
    pub fn product_into(&self, x: &[f64], y: &mut [f64]) {
        assert!(x.len() == self.size && y.len() == self.size);
        y.fill(0.0);
        for (pairs, inverse) in &self.parts {
            let own: Vec<f64> = pairs
                .iter()
                .map(|pair| pair.members().map(|(i, weight)| weight * x[i]).sum())
                .collect();
            let mut found = vec![0.0; own.len()];
            inverse.product_into(&own, &mut found);
            for (pair, value) in pairs.iter().zip(found) {
                pair.members().for_each(|(i, weight)| y[i] += weight * value);
            }
        }
    }

    /// Memory of the entries, which a product reads once.
    pub fn bytes(&self) -> usize {
        self.parts.iter().map(|(_, inverse)| inverse.bytes()).sum()
    }

    /// The diagonal, from the first entry to the last.
    pub fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.size];
        for (pairs, inverse) in &self.parts {
            for (pair, value) in pairs.iter().zip(inverse.diagonal()) {
                pair.members()
                    .for_each(|(i, weight)| diagonal[i] += weight * weight * value);
            }
        }
        diagonal
    }
}
