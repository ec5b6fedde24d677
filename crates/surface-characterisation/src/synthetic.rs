//! Seeded synthetic faces: Gaussian roughness, waviness, tilt, quantisation and missing data.

use rayon::prelude::*;

use crate::error::{SurfaceError, finite, not_negative, positive};
use crate::random::{NormalDeviates, mix};
use crate::topography::HeightMap;

/// A sinusoidal undulation of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waviness {
    /// Amplitude (half of peak to valley) (m).
    pub amplitude: f64,
    /// Wave vector components `1/wavelength` along x and y (1/m).
    pub wavenumber: [f64; 2],
    /// Phase at the origin of the map (rad).
    pub phase: f64,
}

/// A synthetic face: what a profilometer would report of a rough, wavy, tilted surface.
///
/// The roughness is Gaussian with zero mean, standard deviation `rms` and the autocorrelation
/// `exp(-(s/l_x)^2 - (t/l_y)^2)` at lags `(s, t)`: white noise under a separable moving average with the weights
/// `exp(-2 s^2/l^2)`, cut at `2.5 l` (where they are below 4e-6) and normalised on the grid, so that the standard
/// deviation is exact in the mean at any ratio of correlation length to step. Below about one step the correlation is
/// that of the grid: white.
#[derive(Debug, Clone, PartialEq)]
pub struct SyntheticFace {
    /// Points along x and y.
    pub points: [usize; 2],
    /// Lateral steps (m).
    pub step: [f64; 2],
    /// Position of point (0, 0) (m).
    pub origin: [f64; 2],
    /// Root mean square roughness (m).
    pub rms: f64,
    /// Correlation lengths along x and y (m) (autocorrelation 1/e).
    pub correlation_length: [f64; 2],
    /// Undulations that are added.
    pub waviness: Vec<Waviness>,
    /// Slopes along x and y (1).
    pub tilt: [f64; 2],
    /// Height step of the instrument (m); `None` for exact heights.
    pub height_step: Option<f64>,
    /// Seed: the same seed gives the same face, on any number of threads.
    pub seed: u64,
}

impl SyntheticFace {
    /// Generates the map; points for which `missing` holds (bolt holes, shadows) have no data.
    ///
    /// # Errors
    /// Lengths that are not positive, a negative roughness, other values that are not finite, or a correlation length
    /// beyond the length of the grid.
    pub fn generate(&self, missing: impl Fn([f64; 2]) -> bool + Sync) -> Result<HeightMap, SurfaceError> {
        let [nx, ny] = self.points;
        for (axis, field) in ["correlation_length x", "correlation_length y"].into_iter().enumerate() {
            positive(["dx", "dy"][axis], self.step[axis], "m")?;
            let length = positive(field, self.correlation_length[axis], "m")?;
            if length > self.points[axis] as f64 * self.step[axis] {
                return Err(SurfaceError::InvalidValue {
                    field,
                    value: length,
                    unit: "m",
                    requirement: "at most the length of the grid",
                });
            }
            finite("tilt", self.tilt[axis], "1")?;
        }
        not_negative("rms", self.rms, "m")?;
        for wave in &self.waviness {
            finite("waviness amplitude", wave.amplitude, "m")?;
            finite("waviness phase", wave.phase, "rad")?;
            finite("waviness wavenumber x", wave.wavenumber[0], "1/m")?;
            finite("waviness wavenumber y", wave.wavenumber[1], "1/m")?;
        }
        if let Some(q) = self.height_step {
            positive("height_step", q, "m")?;
        }
        // Checks numbers of points, steps and origin before any work is done on them.
        HeightMap::try_new(
            3.min(nx),
            3.min(ny),
            self.step,
            self.origin,
            vec![0.0; 3.min(nx) * 3.min(ny)],
        )?;

        let weights = [0, 1].map(|k| moving_average(self.correlation_length[k] / self.step[k]));
        let reach = weights[1].len() / 2;
        let mut along_x = vec![0.0; nx * (ny + 2 * reach)];
        along_x.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
            // One generator per row: rows can be made in any order.
            let mut normal = NormalDeviates::new(mix(self.seed, row as u64, 0));
            let noise: Vec<f64> = (0..nx + weights[0].len() - 1).map(|_| normal.next()).collect();
            for (i, z) in out.iter_mut().enumerate() {
                *z = noise[i..].iter().zip(&weights[0]).map(|(n, w)| n * w).sum();
            }
        });
        let mut heights = vec![0.0; nx * ny];
        heights.par_chunks_mut(nx).enumerate().for_each(|(j, out)| {
            for (t, w) in weights[1].iter().enumerate() {
                for (z, a) in out.iter_mut().zip(&along_x[(j + t) * nx..]) {
                    *z += w * a;
                }
            }
            for (i, z) in out.iter_mut().enumerate() {
                let s = [i as f64 * self.step[0], j as f64 * self.step[1]];
                *z = self.rms * *z + self.tilt[0] * s[0] + self.tilt[1] * s[1];
                for w in &self.waviness {
                    let turns = w.wavenumber[0] * s[0] + w.wavenumber[1] * s[1];
                    *z += w.amplitude * (std::f64::consts::TAU * turns + w.phase).sin();
                }
                if let Some(q) = self.height_step {
                    *z = (*z / q).round() * q;
                }
                if missing([self.origin[0] + s[0], self.origin[1] + s[1]]) {
                    *z = f64::NAN;
                }
            }
        });
        let map = HeightMap::try_new(nx, ny, self.step, self.origin, heights)?;
        match self.height_step {
            Some(q) => map.with_height_step(q),
            None => Ok(map),
        }
    }
}

/// Weights `exp(-2 (k/length)^2)` of unit energy, an odd number of them, for a correlation length in steps.
fn moving_average(length: f64) -> Vec<f64> {
    let reach = (2.5 * length).ceil() as i64;
    let weights: Vec<f64> = (-reach..=reach)
        .map(|k| (-2.0 * (k as f64 / length).powi(2)).exp())
        .collect();
    let norm = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    weights.into_iter().map(|w| w / norm).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face() -> SyntheticFace {
        SyntheticFace {
            points: [600, 500],
            step: [30e-6, 50e-6],
            origin: [0.01, -0.02],
            rms: 2e-6,
            correlation_length: [120e-6, 150e-6],
            waviness: vec![],
            tilt: [0.0; 2],
            height_step: None,
            seed: 42,
        }
    }

    #[test]
    fn rms_and_autocorrelation_are_as_stated() {
        let map = face().generate(|_| false).unwrap();
        let z = |i: usize, j: usize| map.height(i, j).unwrap() / 2e-6;
        let (nx, ny) = (map.nx(), map.ny());
        let correlation = |di: usize, dj: usize| {
            let mut sum = 0.0;
            for j in 0..ny - dj {
                for i in 0..nx - di {
                    sum += z(i, j) * z(i + di, j + dj);
                }
            }
            sum / ((nx - di) * (ny - dj)) as f64
        };
        // Effective number of independent patches: area over pi/2 l_x l_y; 5 sigma of a correlation estimate.
        let patches = 600.0 * 500.0 * 30.0 * 50.0 / (0.5 * std::f64::consts::PI * 120.0 * 150.0);
        let tolerance = 5.0 * (2.0f64 / patches).sqrt();
        for (di, dj) in [(0, 0), (2, 0), (4, 0), (0, 3), (4, 3), (10, 8), (40, 0)] {
            let (s, t) = (di as f64 * 30.0 / 120.0, dj as f64 * 50.0 / 150.0);
            let expected = (-s * s - t * t).exp();
            let found = correlation(di, dj);
            assert!(
                (found - expected).abs() < tolerance,
                "({di}, {dj}): {found} against {expected} +- {tolerance}"
            );
        }
    }

    #[test]
    fn the_same_on_any_number_of_threads_and_different_by_seed() {
        let on = |n: usize, face: &SyntheticFace| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(n)
                .build()
                .unwrap()
                .install(|| face.generate(|_| false).unwrap())
        };
        let one = on(1, &face());
        assert_eq!(one, on(2, &face()));
        assert_eq!(one, on(5, &face()));
        assert_ne!(one, on(2, &SyntheticFace { seed: 43, ..face() }));
    }

    #[test]
    fn faces_of_neighbouring_seeds_are_unrelated() {
        let white = |seed| {
            let face = SyntheticFace {
                points: [200, 64],
                correlation_length: [1e-6; 2],
                seed,
                ..face()
            };
            face.generate(|_| false).unwrap()
        };
        let (a, b) = (white(1), white(2));
        // No row of one face is any row of the other: correlations of 200 points stay within 5 sigma.
        for j in 0..64 {
            for k in 0..64 {
                let sum: f64 = (0..200)
                    .map(|i| a.height(i, j).unwrap() * b.height(i, k).unwrap())
                    .sum();
                assert!((sum / (200.0 * 4e-12)).abs() < 5.0 / 200f64.sqrt(), "rows {j} and {k}");
            }
        }
    }

    #[test]
    fn waviness_tilt_steps_and_holes() {
        let wave = Waviness {
            amplitude: 5e-6,
            wavenumber: [100.0, 0.0],
            phase: 0.5,
        };
        let smooth = SyntheticFace {
            rms: 0.0,
            waviness: vec![wave],
            tilt: [1e-3, -2e-3],
            ..face()
        };
        let map = smooth.generate(|p| p[0] < 0.0102).unwrap();
        assert_eq!(map.height(0, 0), None);
        assert_eq!(map.missing(), 7 * 500);
        let expected = |i: usize, j: usize| {
            let (x, y) = (i as f64 * 30e-6, j as f64 * 50e-6);
            5e-6 * (std::f64::consts::TAU * 100.0 * x + 0.5).sin() + 1e-3 * x - 2e-3 * y
        };
        for (i, j) in [(7, 0), (100, 33), (599, 499)] {
            assert!((map.height(i, j).unwrap() - expected(i, j)).abs() < 1e-18);
        }
        let stepped = SyntheticFace {
            height_step: Some(0.5e-6),
            ..smooth
        }
        .generate(|_| false)
        .unwrap();
        for (i, j) in [(0, 0), (100, 33), (599, 499)] {
            let z = stepped.height(i, j).unwrap();
            assert!((z - expected(i, j)).abs() <= 0.25e-6 + 1e-18);
            assert!((z / 0.5e-6 - (z / 0.5e-6).round()).abs() < 1e-9);
        }
        assert_eq!(stepped.height_step(), Some(0.5e-6));
    }

    #[test]
    fn invalid_faces_are_named() {
        let error = |f: SyntheticFace| f.generate(|_| false).unwrap_err();
        assert!(matches!(
            error(SyntheticFace { rms: -1.0, ..face() }),
            SurfaceError::InvalidValue { field: "rms", .. }
        ));
        assert!(matches!(
            error(SyntheticFace {
                points: [2, 9],
                ..face()
            }),
            SurfaceError::InvalidValue { .. }
        ));
        assert!(matches!(
            error(SyntheticFace {
                correlation_length: [1.0, 1e-4],
                ..face()
            }),
            SurfaceError::InvalidValue {
                field: "correlation_length x",
                ..
            }
        ));
        assert!(matches!(
            error(SyntheticFace {
                height_step: Some(0.0),
                ..face()
            }),
            SurfaceError::InvalidValue {
                field: "height_step",
                ..
            }
        ));
    }
}
