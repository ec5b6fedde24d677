//! Peaks along scan lines (eq. 25) and summits of a patch.

/// A peak of one profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinePeak {
    /// Sample in the middle of the peak (the lower one of two for a plateau of even length).
    pub index: usize,
    /// Position of the vertex, from the first sample (same unit as the step).
    pub position: f64,
    /// Height of the vertex.
    pub height: f64,
    /// Curvature of the vertex, positive (1 / unit): the radius of eq. (25) is its inverse.
    pub curvature: f64,
}

/// Three-point peaks of a profile with spacing `step`; NaN marks missing samples.
///
/// A sample that both neighbours lie below is a peak; the parabola through the three gives vertex, height and radius
/// (eq. 25), and the vertex then lies within half a step of the sample. Neighbours that differ by no more than
/// `level` (>= 0) form a plateau. A plateau is one peak if the profile descends on both of its sides and none
/// otherwise, so the step of a rising flank (`z1 < z2 = z3 < z4`) is no peak; its parabola is the least-squares one
/// through the plateau and its two neighbours, which for a single sample is the three-point kernel. Peaks next to a
/// missing sample or to the profile's end are not resolved.
pub fn line_peaks(profile: &[f64], step: f64, level: f64) -> Vec<LinePeak> {
    let mut peaks = Vec::new();
    let mut first = 1;
    while first + 1 < profile.len() {
        if profile[first] - profile[first - 1] > level {
            let mut last = first;
            while last + 1 < profile.len() && (profile[last + 1] - profile[last]).abs() <= level {
                last += 1;
            }
            if last + 1 < profile.len() && profile[last] - profile[last + 1] > level {
                peaks.extend(
                    vertex(&profile[first - 1..=last + 1], step).map(|(offset, height, curvature)| LinePeak {
                        index: (first + last) / 2,
                        position: 0.5 * (first + last) as f64 * step + offset,
                        height,
                        curvature,
                    }),
                );
            }
            first = last + 1;
        } else {
            first += 1;
        }
    }
    peaks
}

/// Vertex (from the middle of `z`), height and curvature of the least-squares parabola through `z`.
fn vertex(z: &[f64], step: f64) -> Option<(f64, f64, f64)> {
    // Orthogonal columns 1, s, s^2 - mean(s^2) over equidistant s: no system to solve.
    let n = z.len() as f64;
    let mean_square = (n * n - 1.0) / 12.0;
    let sum_s2 = n * mean_square;
    let sum_p2 = n * (n * n - 1.0) * (n * n - 4.0) / 180.0;
    // Heights relative to the middle keep the digits of small peaks on tall offsets.
    let datum = z[z.len() / 2];
    let (mut mean, mut slope, mut bend) = (0.0, 0.0, 0.0);
    for (k, &height) in z.iter().enumerate() {
        let s = k as f64 - 0.5 * (n - 1.0);
        mean += (height - datum) / n;
        slope += s * (height - datum) / sum_s2;
        bend += (s * s - mean_square) * (height - datum) / sum_p2;
    }
    if bend.is_nan() || bend >= 0.0 {
        return None;
    }
    let offset = -slope / (2.0 * bend);
    let height = datum + mean - bend * mean_square - slope * slope / (4.0 * bend);
    Some((offset * step, height, -2.0 * bend / (step * step)))
}

/// How the radii of an element's peaks become one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum RadiusStatistic {
    /// Inverse of the mean curvature. The default: nearly flat peaks do not dominate it.
    #[default]
    InverseMeanCurvature,
    /// Mean of the radii, as published. Its variance is infinite for Gaussian profiles.
    Mean,
}

impl RadiusStatistic {
    /// The statistic of peaks with the given curvatures; `None` without peaks.
    pub fn of(self, curvatures: &[f64]) -> Option<f64> {
        let n = curvatures.len() as f64;
        (!curvatures.is_empty()).then(|| match self {
            Self::InverseMeanCurvature => n / curvatures.iter().sum::<f64>(),
            Self::Mean => curvatures.iter().map(|c| 1.0 / c).sum::<f64>() / n,
        })
    }
}

/// A summit of a patch: a point, or a plateau, above all of its surroundings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summit {
    /// Column of the summit's first point in row order.
    pub i: usize,
    /// Row of that point.
    pub j: usize,
    /// Greatest height of the summit.
    pub height: f64,
}

/// Summits of a patch of `nx` columns (x running fastest): points above all 8 neighbours.
///
/// Neighbours that differ by no more than `level` form one plateau, which is one summit if everything around it is
/// lower. Points next to a missing point (NaN) or to the border of the patch are not resolved.
pub fn summits(heights: &[f64], nx: usize, level: f64) -> Vec<Summit> {
    let ny = heights.len().checked_div(nx).unwrap_or(0);
    let mut visited = vec![false; heights.len()];
    let mut stack = Vec::new();
    let mut found = Vec::new();
    for start in 0..nx * ny {
        if visited[start] || heights[start].is_nan() {
            continue;
        }
        visited[start] = true;
        stack.push(start);
        let (mut is_summit, mut height) = (true, f64::NEG_INFINITY);
        while let Some(cell) = stack.pop() {
            let (i, j) = (cell % nx, cell / nx);
            height = height.max(heights[cell]);
            if i == 0 || j == 0 || i + 1 == nx || j + 1 == ny {
                is_summit = false;
            }
            for nj in j.saturating_sub(1)..=(j + 1).min(ny - 1) {
                for ni in i.saturating_sub(1)..=(i + 1).min(nx - 1) {
                    let neighbour = nj * nx + ni;
                    let rise = heights[neighbour] - heights[cell];
                    if rise.is_nan() || rise > level {
                        is_summit = false;
                    } else if rise >= -level && !visited[neighbour] {
                        visited[neighbour] = true;
                        stack.push(neighbour);
                    }
                }
            }
        }
        if is_summit {
            found.push(Summit {
                i: start % nx,
                j: start / nx,
                height,
            });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn parabola_vertex_height_and_radius_are_exact() {
        let (radius, step) = (1.3e-3, 30e-6);
        for offset in [-0.49, -0.2, 0.0, 0.31, 0.5 - 1e-9] {
            let vertex = (7.0 + offset) * step;
            let profile: Vec<f64> = (0..15)
                .map(|k| 4e-6 - (f64::from(k) * step - vertex).powi(2) / (2.0 * radius))
                .collect();
            let peaks = line_peaks(&profile, step, 0.0);
            assert_eq!(peaks.len(), 1, "{offset}");
            assert_eq!(peaks[0].index, 7);
            assert!((peaks[0].position - vertex).abs() < 1e-9 * step);
            assert!((peaks[0].height - 4e-6).abs() < 1e-18);
            assert!((1.0 / peaks[0].curvature / radius - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn plateaus_count_once_and_rising_flanks_not_at_all() {
        let count = |z: &[f64]| line_peaks(z, 1.0, 0.0).len();
        assert_eq!(count(&[0.0, 1.0, 1.0, 2.0]), 0);
        assert_eq!(count(&[2.0, 1.0, 1.0, 0.0]), 0);
        assert_eq!(count(&[0.0, 1.0, 1.0, 0.0]), 1);
        assert_eq!(count(&[0.0, 1.0, 1.0, 1.0, 1.0, 0.5]), 1);
        assert_eq!(count(&[0.0, 1.0, 1.0]), 0);
        assert_eq!(count(&[0.0, 1.0, f64::NAN, 1.0, 0.0]), 0);
        assert_eq!(count(&[0.0, 1.0, 1.0, f64::NAN]), 0);
        assert_eq!(count(&[0.0, 1.0, 0.0, 1.0, 0.0]), 2);
        assert_eq!(count(&[0.0, 0.0, 0.0]), 0);
        assert_eq!(count(&[]), 0);
        // Two samples at +-1/2 of a parabola: the four-point parabola is exact.
        let peak = line_peaks(&[-2.25, -0.25, -0.25, -2.25], 1.0, 0.0)[0];
        assert!((peak.position - 1.5).abs() < 1e-15 && peak.height.abs() < 1e-15);
        assert!((peak.curvature - 2.0).abs() < 1e-14);
    }

    #[test]
    fn a_tilted_staircase_has_no_peaks_when_its_level_is_known() {
        // Quantised rising flank after de-trending: each tread slopes down a little.
        let stair: Vec<f64> = (0..40)
            .map(|k| (f64::from(k) * 0.3).floor() * 0.5e-6 - f64::from(k) * 2e-8)
            .collect();
        assert!(line_peaks(&stair, 3e-5, 0.0).len() > 5);
        assert_eq!(line_peaks(&stair, 3e-5, 0.25e-6).len(), 0);
    }

    #[test]
    fn summits_of_a_patch() {
        #[rustfmt::skip]
        let z = [
            0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 9.0,
            0.0, 3.0, 0.0, 2.0, 2.0, 0.0, 0.0,
            0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0,
            0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0,
            0.0, 0.0, 1.5, 0.0, 4.0, f64::NAN, 0.0,
            0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        ];
        let found: Vec<_> = summits(&z, 7, 0.0).iter().map(|s| (s.i, s.j, s.height)).collect();
        // The border point 9, the point 1 beside the taller 1.5, and the point 4 beside missing data do not count.
        assert_eq!(found, vec![(1, 1, 3.0), (3, 1, 2.0), (2, 4, 1.5)]);
        assert!(summits(&[], 0, 0.0).is_empty());
    }

    #[test]
    fn radius_statistics() {
        let curvatures = [1.0, 4.0];
        assert_eq!(RadiusStatistic::InverseMeanCurvature.of(&curvatures), Some(0.4));
        assert_eq!(RadiusStatistic::Mean.of(&curvatures), Some(0.625));
        assert_eq!(RadiusStatistic::Mean.of(&[]), None);
    }

    /// Integer heights make plateaus common and shifts exact.
    fn patch() -> impl Strategy<Value = (usize, usize, Vec<f64>)> {
        (3usize..14, 3usize..14).prop_flat_map(|(nx, ny)| {
            let cell = prop_oneof![9 => (0i32..6).prop_map(f64::from), 1 => Just(f64::NAN)];
            (Just(nx), Just(ny), prop::collection::vec(cell, nx * ny))
        })
    }

    proptest! {
        #[test]
        fn summit_count_is_the_same_with_x_and_y_swapped((nx, ny, z) in patch()) {
            let swapped: Vec<f64> = (0..nx * ny).map(|k| z[(k % ny) * nx + k / ny]).collect();
            let (a, b) = (summits(&z, nx, 0.0), summits(&swapped, ny, 0.0));
            prop_assert_eq!(a.len(), b.len());
            let sorted = |s: &[Summit]| {
                let mut heights: Vec<f64> = s.iter().map(|s| s.height).collect();
                heights.sort_by(f64::total_cmp);
                heights
            };
            prop_assert_eq!(sorted(&a), sorted(&b));
        }

        #[test]
        fn shifts_and_reversal_move_peaks_and_nothing_else((_, _, z) in patch(), by in -8i32..8) {
            let peaks = line_peaks(&z, 2.0, 0.0);
            let shifted: Vec<f64> = z.iter().map(|h| h + f64::from(by)).collect();
            let moved = line_peaks(&shifted, 2.0, 0.0);
            let reversed: Vec<f64> = z.iter().rev().copied().collect();
            let mut back = line_peaks(&reversed, 2.0, 0.0);
            back.reverse();
            prop_assert_eq!(peaks.len(), moved.len());
            prop_assert_eq!(peaks.len(), back.len());
            let length = 2.0 * (z.len() as f64 - 1.0);
            for ((p, m), b) in peaks.iter().zip(&moved).zip(&back) {
                prop_assert_eq!((p.index, p.curvature), (m.index, m.curvature));
                prop_assert!((p.height + f64::from(by) - m.height).abs() < 1e-12);
                prop_assert!((length - b.position - p.position).abs() < 1e-9);
                prop_assert!((p.curvature - b.curvature).abs() < 1e-12);
            }
        }

        #[test]
        fn a_peak_stands_above_both_sides_and_its_vertex_is_near((_, _, z) in patch()) {
            for p in line_peaks(&z, 1.0, 0.0) {
                prop_assert!(p.curvature > 0.0);
                let run = z.iter().skip(p.index).take_while(|h| **h == z[p.index]).count();
                let before = z[..p.index].iter().rev().take_while(|h| **h == z[p.index]).count();
                let (first, last) = (p.index - before, p.index + run - 1);
                prop_assert!(z[first - 1] < z[first] && z[last + 1] < z[last]);
                let half = 0.5 * (last - first + 1) as f64;
                prop_assert!((p.position - 0.5 * (first + last) as f64).abs() <= half);
            }
        }
    }
}
