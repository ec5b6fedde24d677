//! Random faces of prescribed correlation and height distribution on a grid, by the fast Fourier transform.

use rustfft::algorithm::Radix4;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftDirection};

use super::error::FinishError;
use super::face::FaceFinish;
use super::spectrum::Spectrum;
use crate::random::{NormalDeviates, mix};
use crate::topography::{HeightMap, turn};

/// Fewest points of a patch along an axis.
pub(super) const LEAST_POINTS: usize = 16;
/// Most points of a patch along an axis.
pub(super) const MOST_POINTS: usize = 2048;
/// Correlation lengths between the patch and its periodic image, beyond which a Gaussian correlation is below 1e-6.
const APART: f64 = 4.0;
/// Greatest number of points of the periodic grid.
const MOST: usize = 1 << 22;

/// Makes faces of one finish on one grid: circulant embedding (Dietrich and Newsam, SIAM J. Sci. Comput. 18, 1997,
/// doi 10.1137/S1064827592240555) of the correlation that the translation turns into the prescribed one.
#[derive(Debug, Clone)]
pub struct Synthesis {
    face: FaceFinish,
    step: [f64; 2],
    points: [usize; 2],
    size: [usize; 2],
    /// Standard deviations of the modes, x running fastest.
    amplitudes: Vec<f64>,
    clipped: f64,
}

impl Synthesis {
    /// For patches of `points` along x and y at distances `step` (m).
    ///
    /// # Errors
    /// [`FinishError::Points`] if the periodic grid around the patch has more than 2^22 points.
    pub fn try_new(face: &FaceFinish, step: [f64; 2], points: [usize; 2]) -> Result<Self, FinishError> {
        let extent = face.spectrum().extent();
        let wanted = [0, 1].map(|axis| {
            let apart = APART * extent[axis] / step[axis];
            (points[axis] as f64 + apart).max(2.0 * apart).ceil()
        });
        if let Some(axis) = (0..2).find(|&axis| !(wanted[axis] <= MOST as f64)) {
            return Err(too_many(axis, step, wanted));
        }
        let size = wanted.map(|n| (n as usize).next_power_of_two());
        if size[0].saturating_mul(size[1]) > MOST {
            return Err(too_many(usize::from(size[1] > size[0]), step, wanted));
        }
        let total = size[0] * size[1];
        let lag = |index: usize, axis: usize| {
            let n = size[axis] as f64;
            let k = index as f64;
            step[axis] * if 2.0 * k <= n { k } else { k - n }
        };
        let mut modes: Vec<Complex64> = match face.spectrum() {
            Spectrum::Gaussian { .. } => (0..total)
                .map(|k| {
                    let correlation = face.spectrum().correlation([lag(k % size[0], 0), lag(k / size[0], 1)]);
                    face.translation().normal_correlation(correlation).into()
                })
                .collect(),
            power @ Spectrum::PowerLaw { .. } => {
                let q = |index: usize, axis: usize| {
                    std::f64::consts::TAU * lag(index, axis) / (step[axis] * step[axis] * size[axis] as f64)
                };
                let density = |k: usize| power.density(q(k % size[0], 0).hypot(q(k / size[0], 1)));
                // The mean height is no roughness.
                let mut density: Vec<Complex64> = (0..total)
                    .map(|k| if k == 0 { 0.0 } else { density(k) }.into())
                    .collect();
                transform(&mut density, size, FftDirection::Inverse);
                let variance = density[0].re;
                density
                    .into_iter()
                    .map(|c| face.translation().normal_correlation(c.re / variance).into())
                    .collect()
            }
        };
        transform(&mut modes, size, FftDirection::Forward);
        let all: f64 = modes.iter().map(|m| m.re.abs()).sum();
        let kept: f64 = modes.iter().map(|m| m.re.max(0.0)).sum();
        Ok(Self {
            face: face.clone(),
            step,
            points,
            size,
            amplitudes: modes.into_iter().map(|m| (m.re.max(0.0) / kept).sqrt()).collect(),
            clipped: (all - kept) / all,
        })
    }

    /// Share of the variance that no correlation of Gaussian heights can give, and that was left out.
    pub fn clipped(&self) -> f64 {
        self.clipped
    }

    /// Two independent patches: real and imaginary part of one transform. Depends on the arguments and the seed alone.
    ///
    /// # Errors
    /// Those of [`HeightMap::try_new`].
    pub fn pair(&self, seed: u64) -> Result<[HeightMap; 2], FinishError> {
        let mut field: Vec<Complex64> = Vec::with_capacity(self.amplitudes.len());
        for (row, amplitudes) in self.amplitudes.chunks(self.size[0]).enumerate() {
            let mut normal = NormalDeviates::new(mix(seed, row as u64, 0));
            field.extend(
                amplitudes
                    .iter()
                    .map(|a| Complex64::new(a * normal.next(), a * normal.next())),
            );
        }
        transform(&mut field, self.size, FftDirection::Inverse);
        let part = |of: fn(&Complex64) -> f64| {
            let mut heights = Vec::with_capacity(self.points[0] * self.points[1]);
            for row in field.chunks(self.size[0]).take(self.points[1]) {
                heights.extend(row[..self.points[0]].iter().map(|c| self.face.height(of(c))));
            }
            let origin = self.step.map(|d| 0.5 * d);
            HeightMap::try_new(self.points[0], self.points[1], self.step, origin, heights)
        };
        Ok([part(|c| c.re)?, part(|c| c.im)?])
    }
}

fn too_many(axis: usize, step: [f64; 2], wanted: [f64; 2]) -> FinishError {
    FinishError::Points {
        window: step[axis] * wanted[axis],
        axis: ["x", "y"][axis],
        step: step[axis],
        points: wanted[axis],
        least: LEAST_POINTS,
        most: MOST_POINTS,
    }
}

/// Transforms rows and columns in place, sizes being powers of two, without a factor.
fn transform(values: &mut [Complex64], size: [usize; 2], direction: FftDirection) {
    let mut turned = vec![Complex64::default(); values.len()];
    let [nx, ny] = size;
    Radix4::new(nx, direction).process(values);
    turn(values, size, &mut turned);
    Radix4::new(ny, direction).process(&mut turned);
    turn(&turned, [ny, nx], values);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_is_the_discrete_one_along_both_axes() {
        let size = [8, 4];
        let value = |k: usize| Complex64::new((k * k % 7) as f64, (k % 3) as f64);
        let mut values: Vec<Complex64> = (0..32).map(value).collect();
        transform(&mut values, size, FftDirection::Forward);
        for (p, q) in [(0, 0), (3, 1), (7, 2), (5, 3)] {
            let sum: Complex64 = (0..32)
                .map(|k| {
                    let phase = p as f64 * (k % 8) as f64 / 8.0 + q as f64 * (k / 8) as f64 / 4.0;
                    value(k) * Complex64::from_polar(1.0, -std::f64::consts::TAU * phase)
                })
                .sum();
            assert!((values[q * 8 + p] - sum).norm() < 1e-12);
        }
    }
}
