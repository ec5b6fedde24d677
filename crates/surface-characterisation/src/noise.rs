//! Optional treatment of noise: outliers and short waves. Off by default.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::detrend::fit_plane;
use crate::error::{SurfaceError, positive};
use crate::statistics::upper_median;
use crate::topography::HeightMap;

/// What is done to a height map before anything else; nothing by default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct NoiseHandling {
    /// Rule by which points are taken for outliers and their data dropped.
    pub outliers: Option<OutlierRule>,
    /// Cut-off wavelength of a Gaussian S-filter (m), applied after the outliers are gone.
    pub s_filter: Option<f64>,
}

/// A point is an outlier where it differs from the median of the square of `2 reach + 1` points around it by more than
/// `threshold` robust standard deviations of that difference.
///
/// The robust standard deviation is 1.4826 times the median absolute difference over the whole map (1.2533 times the
/// mean where more than half of the points equal their local median, as on coarsely quantised maps), and the limit is
/// never below one stated height step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct OutlierRule {
    /// Points to each side of the middle one, at least 1.
    pub reach: usize,
    /// Robust standard deviations.
    pub threshold: f64,
}

impl Default for OutlierRule {
    /// 5 x 5 points, six standard deviations: one point in 5e8 of Gaussian noise.
    fn default() -> Self {
        Self {
            reach: 2,
            threshold: 6.0,
        }
    }
}

impl NoiseHandling {
    /// The map as it is to be used, and the number of points dropped as outliers.
    ///
    /// # Errors
    /// As [`without_outliers`] and [`gaussian_s_filter`].
    pub fn apply<'a>(&self, map: &'a HeightMap) -> Result<(Cow<'a, HeightMap>, usize), SurfaceError> {
        let mut used = Cow::Borrowed(map);
        let mut dropped = 0;
        if let Some(rule) = self.outliers {
            let (cleaned, n) = without_outliers(&used, rule)?;
            dropped = n;
            used = Cow::Owned(cleaned);
        }
        if let Some(cutoff) = self.s_filter {
            used = Cow::Owned(gaussian_s_filter(&used, cutoff)?);
        }
        Ok((used, dropped))
    }
}

/// The map with the data of outliers dropped, and their number.
///
/// # Errors
/// A reach of zero or beyond the grid, or a threshold that is not positive.
pub fn without_outliers(map: &HeightMap, rule: OutlierRule) -> Result<(HeightMap, usize), SurfaceError> {
    positive("outlier threshold", rule.threshold, "1")?;
    let (nx, ny) = (map.nx(), map.ny());
    if rule.reach == 0 || 2 * rule.reach >= nx.min(ny) {
        return Err(SurfaceError::InvalidValue {
            field: "outlier reach",
            value: rule.reach as f64,
            unit: "points",
            requirement: "at least 1 and below half of the shorter side of the grid",
        });
    }
    let mut differences = vec![f64::NAN; nx * ny];
    differences.par_chunks_mut(nx).enumerate().for_each(|(j, row)| {
        let mut around = Vec::with_capacity((2 * rule.reach + 1).pow(2));
        for (i, difference) in row.iter_mut().enumerate() {
            let z = map.value(j * nx + i);
            if z.is_nan() {
                continue;
            }
            around.clear();
            for nj in j.saturating_sub(rule.reach)..=(j + rule.reach).min(ny - 1) {
                for ni in i.saturating_sub(rule.reach)..=(i + rule.reach).min(nx - 1) {
                    around.extend(Some(map.value(nj * nx + ni)).filter(|z| !z.is_nan()));
                }
            }
            *difference = z - upper_median(&mut around);
        }
    });
    let mut sizes: Vec<f64> = differences.iter().filter(|d| !d.is_nan()).map(|d| d.abs()).collect();
    if sizes.is_empty() {
        return Ok((map.clone(), 0));
    }
    let deviation = match 1.4826 * upper_median(&mut sizes) {
        0.0 => 1.2533 * sizes.iter().sum::<f64>() / sizes.len() as f64,
        deviation => deviation,
    };
    let limit = (rule.threshold * deviation).max(map.height_step().unwrap_or(0.0));
    let is_outlier = |k: usize| differences[k].abs() > limit;
    let dropped = (0..nx * ny).filter(|&k| is_outlier(k)).count();
    let heights = (0..nx * ny).map(|k| if is_outlier(k) { f64::NAN } else { map.value(k) });
    Ok((map.with_heights(heights.collect(), map.height_step())?, dropped))
}

/// Areal Gaussian filter of ISO 16610-61 with cut-off wavelength `cutoff` (m): a wave of length `l` keeps the share
/// `0.5^((cutoff/l)^2)` of its amplitude.
///
/// The weights `exp(-pi r^2 / (alpha cutoff)^2)`, `alpha = sqrt(ln 2 / pi)`, are cut at one cut-off wavelength along x
/// and y (where they are below 1e-6) and normalised over the points that have data, so that neither masks nor borders
/// pull heights down; the plane through all data is taken off before and put back, so that they do not bend a tilt.
/// Points without data stay without. A stated height step shrinks as the rms of its rounding does.
///
/// # Errors
/// A cut-off below two lateral steps or beyond the grid, or points that do not determine a plane.
pub fn gaussian_s_filter(map: &HeightMap, cutoff: f64) -> Result<HeightMap, SurfaceError> {
    positive("S-filter cut-off", cutoff, "m")?;
    let (n, step) = ([map.nx(), map.ny()], map.step());
    if (0..2).any(|q| cutoff < 2.0 * step[q] || cutoff > n[q] as f64 * step[q]) {
        return Err(SurfaceError::InvalidValue {
            field: "S-filter cut-off",
            value: cutoff,
            unit: "m",
            requirement: "at least two lateral steps and at most the length of the grid, along x and y",
        });
    }
    let weights = step.map(|d| {
        let reach = (cutoff / d).floor() as i64;
        let weights: Vec<f64> = (-reach..=reach)
            .map(|k| (-std::f64::consts::PI.powi(2) / std::f64::consts::LN_2 * (k as f64 * d / cutoff).powi(2)).exp())
            .collect();
        let sum: f64 = weights.iter().sum();
        weights.into_iter().map(|w| w / sum).collect::<Vec<f64>>()
    });
    let plane = fit_plane(map, |_| true)?;

    let [nx, ny] = n;
    // Weighted sums of heights and of the presence of data, which the same kernel runs over.
    let mut along_x = vec![[0.0; 2]; nx * ny];
    along_x.par_chunks_mut(nx).enumerate().for_each(|(j, out)| {
        let row: Vec<[f64; 2]> = (0..nx)
            .map(|i| {
                map.height(i, j)
                    .map_or([0.0; 2], |z| [z - plane.at(map.position(i, j)), 1.0])
            })
            .collect();
        let reach = weights[0].len() / 2;
        for (i, sums) in out.iter_mut().enumerate() {
            let first = i.saturating_sub(reach);
            for (w, value) in weights[0][first + reach - i..].iter().zip(&row[first..]) {
                sums[0] += w * value[0];
                sums[1] += w * value[1];
            }
        }
    });
    let mut heights = vec![f64::NAN; nx * ny];
    heights.par_chunks_mut(nx).enumerate().for_each(|(j, out)| {
        let reach = weights[1].len() / 2;
        let first = j.saturating_sub(reach);
        let mut sums = vec![[0.0; 2]; nx];
        for (w, row) in weights[1][first + reach - j..]
            .iter()
            .zip(along_x[first * nx..].chunks(nx))
        {
            for (sum, value) in sums.iter_mut().zip(row) {
                sum[0] += w * value[0];
                sum[1] += w * value[1];
            }
        }
        for (i, z) in out.iter_mut().enumerate() {
            if map.height(i, j).is_some() {
                *z = sums[i][0] / sums[i][1] + plane.at(map.position(i, j));
            }
        }
    });
    let share: f64 = weights.iter().map(|w| w.iter().map(|w| w * w).sum::<f64>()).product();
    map.with_heights(heights, map.height_step().map(|q| q * share.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(n: [usize; 2], step: [f64; 2], z: impl Fn(f64, f64) -> f64) -> HeightMap {
        let heights: Vec<f64> = (0..n[0] * n[1])
            .map(|k| z((k % n[0]) as f64 * step[0], (k / n[0]) as f64 * step[1]))
            .collect();
        HeightMap::try_new(n[0], n[1], step, [0.0; 2], heights).unwrap()
    }

    #[test]
    fn half_of_a_wave_passes_at_the_cut_off() {
        let (n, step, cutoff) = ([240usize, 160usize], [10e-6, 15e-6], 100e-6);
        for (length, axis) in [(100e-6, 0), (100e-6, 1), (60e-6, 0), (200e-6, 1), (400e-6, 0)] {
            let wave = |x: f64, y: f64| (std::f64::consts::TAU * [x, y][axis] / length).sin();
            let filtered = gaussian_s_filter(&map(n, step, wave), cutoff).unwrap();
            // Projection on the wave, away from the borders, over whole periods of 600 um.
            let (mut product, mut square) = (0.0, 0.0);
            for j in 40..120 {
                for i in 60..180 {
                    let p = filtered.position(i, j);
                    let w = wave(p[0], p[1]);
                    product += w * filtered.height(i, j).unwrap();
                    square += w * w;
                }
            }
            let expected = 0.5f64.powf((cutoff / length).powi(2));
            // The plane through all data takes a little of the wave with it and puts it back unfiltered.
            assert!(
                (product / square - expected).abs() < 3e-3,
                "{length} {axis}: {} {expected}",
                product / square
            );
        }
    }

    #[test]
    fn masks_and_borders_do_not_bend_a_plane() {
        let plane = |x: f64, y: f64| 3e-6 + 2e-3 * x - 1e-3 * y;
        let masked = map([60, 50], [10e-6, 20e-6], |x, y| {
            let hole = (x - 300e-6).hypot(y - 500e-6) < 150e-6;
            if hole || (x * 7e5 + y * 3e5) as i64 % 11 == 0 {
                f64::NAN
            } else {
                plane(x, y)
            }
        });
        let filtered = gaussian_s_filter(&masked.clone().with_height_step(1e-6).unwrap(), 80e-6).unwrap();
        assert!(masked.missing() > 300);
        assert_eq!(filtered.missing(), masked.missing());
        for j in 0..50 {
            for i in 0..60 {
                if let Some(z) = filtered.height(i, j) {
                    let [x, y] = filtered.position(i, j);
                    assert!((z - plane(x, y)).abs() < 1e-14);
                }
            }
        }
        // The integral of the squared weights, which four points per cut-off follow to 1 %.
        let share = std::f64::consts::PI / (2.0 * std::f64::consts::LN_2) * 10.0 * 20.0 / (80.0 * 80.0);
        assert!((filtered.height_step().unwrap() / (1e-6 * share.sqrt()) - 1.0).abs() < 1e-2);
    }

    #[test]
    fn spikes_go_and_roughness_stays() {
        let rough = |x: f64, y: f64| 1e-6 * ((x * 1.3e5).sin() + (y * 0.9e5).cos()) + 1e-2 * x;
        let clean = map([80, 70], [10e-6, 10e-6], rough);
        let rule = OutlierRule::default();
        assert_eq!(without_outliers(&clean, rule).unwrap().1, 0);
        let spikes = [
            (10usize, 5usize, 30e-6),
            (40, 33, -25e-6),
            (79, 69, 40e-6),
            (0, 0, 20e-6),
        ];
        let mut heights: Vec<f64> = (0..80 * 70).map(|k| clean.height(k % 80, k / 80).unwrap()).collect();
        for (i, j, by) in spikes {
            heights[j * 80 + i] += by;
        }
        let spiky = HeightMap::try_new(80, 70, [10e-6; 2], [0.0; 2], heights).unwrap();
        let (cleaned, dropped) = without_outliers(&spiky, rule).unwrap();
        assert_eq!((dropped, cleaned.missing()), (4, 4));
        assert!(spikes.iter().all(|&(i, j, _)| cleaned.height(i, j).is_none()));

        // Quantised so coarsely that most points equal their local median: single steps are no outliers, dust is.
        let stairs = map([80, 70], [10e-6, 10e-6], |x, y| (rough(x, y) / 4e-6).round() * 4e-6);
        assert_eq!(without_outliers(&stairs, rule).unwrap().1, 0);
        assert!(without_outliers(&clean, OutlierRule { reach: 0, ..rule }).is_err());
        assert!(without_outliers(&clean, OutlierRule { reach: 35, ..rule }).is_err());
        assert!(without_outliers(&clean, OutlierRule { threshold: 0.0, ..rule }).is_err());
        assert!(gaussian_s_filter(&clean, 15e-6).is_err() && gaussian_s_filter(&clean, 1e-3).is_err());
    }

    #[test]
    fn nothing_is_done_by_default() {
        let rough = map([20, 20], [1.0; 2], |x, y| (x * 1.3).sin() * y);
        let (same, dropped) = NoiseHandling::default().apply(&rough).unwrap();
        assert!(matches!(same, Cow::Borrowed(_)) && dropped == 0);
        let both = NoiseHandling {
            outliers: Some(OutlierRule::default()),
            s_filter: Some(4.0),
        };
        assert!(both.apply(&rough).unwrap().0.height(10, 10) != rough.height(10, 10));
    }
}
