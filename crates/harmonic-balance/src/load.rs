//! Harmonic loads.

use crate::harmonics::Harmonics;
use dense_algebra::dot;

/// A harmonic load per unit of its amplitude, `cosine cos(omega t) + sine sin(omega t)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Forces over the coordinates at the begin of a period.
    pub cosine: Vec<f64>,
    /// Forces a quarter period later.
    pub sine: Vec<f64>,
    /// Whether it grows with the square of the frequency, as that of a rotating unbalance: its amplitude is a mass times an eccentricity (kg m), and that
    /// of other loads a force (N).
    pub is_unbalance: bool,
}

impl Load {
    /// One force along a row over the coordinates.
    pub fn force(row: &[f64]) -> Self {
        Self {
            cosine: row.to_vec(),
            sine: vec![0.0; row.len()],
            is_unbalance: false,
        }
    }

    /// Force per unit of its amplitude at a square of the angular frequency (rad^2/s^2).
    pub(crate) fn factor(&self, square: f64) -> f64 {
        if self.is_unbalance { square } else { 1.0 }
    }

    /// Adds `amplitude` of it at a square of the angular frequency.
    pub(crate) fn add(&self, amplitude: f64, square: f64, to: &mut Harmonics) {
        let factor = amplitude * self.factor(square);
        for (column, row) in [(1, &self.cosine), (2, &self.sine)] {
            let to = to.column_mut(column).iter_mut();
            to.zip(row).for_each(|(to, e)| *to += factor * e);
        }
    }

    /// What of the first harmonic of a motion is in phase with it, and a quarter period behind it, per unit of its amplitude: the work of that part over a
    /// period is `pi` times it.
    pub fn along(&self, motion: &Harmonics) -> [f64; 2] {
        let [c, s] = motion.pair(1);
        [
            dot(&self.cosine, c) + dot(&self.sine, s),
            dot(&self.cosine, s) - dot(&self.sine, c),
        ]
    }
}
