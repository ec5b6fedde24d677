//! Points with positions of their own, put onto the grid that they form.

use file_io::Place;

use crate::error::FileError;

/// A regular grid in the unit of the points.
pub(super) struct Gridded {
    pub(super) size: [usize; 2],
    pub(super) step: [f64; 2],
    pub(super) origin: [f64; 2],
    /// x running fastest, NaN where missing.
    pub(super) heights: Vec<f64>,
    /// Largest distance of a point from its place on the grid, in steps.
    pub(super) deviation: f64,
}

/// Positions may be off by this part of a step: rounding of text is far below it, positions that are not on a grid are
/// above it somewhere.
const TOLERANCE: f64 = 0.1;
/// Places of the grid per point. Circular fields and faces with holes fill more than half of theirs.
const SPARSENESS: usize = 16;

/// One axis of the grid.
#[derive(Clone, Copy)]
struct Axis {
    first: f64,
    step: f64,
    count: usize,
}

/// The grid on which points `x, y, z` lie in any order; x and y are finite, z is NaN where missing.
pub(super) fn grid(file: &str, points: &[[f64; 3]], place: impl Fn(usize) -> Place) -> Result<Gridded, FileError> {
    let refused = |index, problem| FileError::NotAGrid {
        file: file.into(),
        place: place(index),
        problem,
    };
    let mut axes = [Axis {
        first: 0.0,
        step: 1.0,
        count: 0,
    }; 2];
    let mut positions = Vec::with_capacity(points.len());
    for (q, axis) in axes.iter_mut().enumerate() {
        positions.clear();
        positions.extend(points.iter().map(|p| p[q]));
        positions.sort_unstable_by(f64::total_cmp);
        *axis = regular(&positions).ok_or_else(|| {
            let n = points.len();
            refused(0, format!("{n} points from here on have no regular {}", ["x", "y"][q]))
        })?;
    }
    let [x, y] = axes;
    let places = x.count.checked_mul(y.count);
    let Some(places) = places.filter(|places| *places <= SPARSENESS.saturating_mul(points.len())) else {
        let n = points.len();
        return Err(refused(
            0,
            format!(
                "{n} points from here on fill less than 1/{SPARSENESS} of {} x {} places",
                x.count, y.count
            ),
        ));
    };
    let mut heights = vec![f64::NAN; places];
    let mut taken = vec![false; places];
    let mut deviation = 0.0_f64;
    for (index, point) in points.iter().enumerate() {
        let mut at = [0; 2];
        for (q, axis) in axes.iter().enumerate() {
            let steps = (point[q] - axis.first) / axis.step;
            let off = (steps - steps.round()).abs();
            if !(off <= TOLERANCE) {
                let (name, value) = (["x", "y"][q], point[q]);
                return Err(refused(
                    index,
                    format!(
                        "{name} = {value} lies {off:.2} steps of {:.4e} beside the grid",
                        axis.step
                    ),
                ));
            }
            deviation = deviation.max(off);
            at[q] = (steps.round() as usize).min(axis.count - 1);
        }
        let k = at[1] * x.count + at[0];
        if std::mem::replace(&mut taken[k], true) {
            return Err(refused(
                index,
                format!("a second point at x = {}, y = {}", point[0], point[1]),
            ));
        }
        heights[k] = point[2];
    }
    Ok(Gridded {
        size: [x.count, y.count],
        step: [x.step, y.step],
        origin: [x.first, y.first],
        heights,
        deviation,
    })
}

/// The regular positions among sorted ones.
///
/// Distances between neighbours are steps, small multiples of them where lines are missing, and next to nothing where
/// one position was rounded differently. So either every distance counts, or those below the widest gap in their sizes
/// do not; right is what leaves no more than a quarter of the regular positions without a point.
fn regular(sorted: &[f64]) -> Option<Axis> {
    let (first, last) = (*sorted.first()?, *sorted.last()?);
    let mut gaps: Vec<f64> = sorted
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|gap| *gap > 0.0)
        .collect();
    gaps.sort_unstable_by(f64::total_cmp);
    if gaps.is_empty() {
        return Some(Axis {
            first,
            step: 1.0,
            count: 1,
        });
    }
    let widest = gaps.windows(2).max_by(|a, b| (a[1] / a[0]).total_cmp(&(b[1] / b[0])));
    [0.0].into_iter().chain(widest.map(|w| w[0])).find_map(|noise| {
        // Positions that differ by noise count once, at the middle between the outer two.
        let mut levels = Vec::new();
        let mut start = first;
        for pair in sorted.windows(2) {
            if pair[1] - pair[0] > noise {
                levels.push(0.5 * (start + pair[0]));
                start = pair[1];
            }
        }
        levels.push(0.5 * (start + last));
        let distances = || levels.windows(2).map(|w| w[1] - w[0]);
        let shortest = distances().fold(f64::INFINITY, f64::min);
        // Counted one by one, so that the error of the shortest does not add up.
        let steps: f64 = distances().map(|d| (d / shortest).round()).sum();
        let count = steps + 1.0;
        let full = levels.len() as f64 >= 0.75 * count;
        (full && steps >= 1.0).then(|| Axis {
            first: levels[0],
            step: (levels[levels.len() - 1] - levels[0]) / steps,
            count: count as usize,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(index: usize) -> Place {
        Place::Line(index + 1)
    }

    fn rectangle(nx: usize, ny: usize) -> Vec<[f64; 3]> {
        let point = |k: usize| [0.1 + 0.25 * (k % nx) as f64, -3.0 + 0.5 * (k / nx) as f64, k as f64];
        (0..nx * ny).map(point).collect()
    }

    #[test]
    fn points_in_any_order_with_holes_and_rounding_find_their_places() {
        let mut points = rectangle(7, 5);
        points.reverse();
        points.swap(3, 20);
        // A whole line and a single point are not there; positions are off by a thousandth of a step.
        points.retain(|p| (p[0] - 0.6).abs() > 1e-9 && p[2] != 12.0);
        for (k, p) in points.iter_mut().enumerate() {
            p[0] += [0.0, 2.5e-4, -2.5e-4][k % 3];
        }
        let found = grid("", &points, line).unwrap();
        assert_eq!(found.size, [7, 5]);
        assert!((found.step[0] - 0.25).abs() < 1e-4 && found.step[1] == 0.5);
        assert!((found.origin[0] - 0.1).abs() < 3e-4 && found.origin[1] == -3.0);
        assert!(found.deviation > 1e-4 && found.deviation < 3e-3);
        for (k, z) in found.heights.iter().enumerate() {
            let missing = k % 7 == 2 || k == 12;
            assert!(if missing { z.is_nan() } else { *z == k as f64 }, "{k}");
        }
    }

    #[test]
    fn points_beside_a_grid_are_named() {
        let refused = |points: &[[f64; 3]]| grid("f", points, line).err().unwrap().to_string();
        let mut points = rectangle(7, 5);
        points[9][0] += 0.05;
        let message = refused(&points);
        assert!(
            message.contains("line 10: x = 0.65 lies 0.20 steps of 2.5000e-1"),
            "{message}"
        );
        let mut points = rectangle(7, 5);
        points.push([0.1, -3.0, 7.0]);
        assert!(refused(&points).contains("line 36: a second point at x = 0.1, y = -3"));
        // Scattered points.
        let points: Vec<_> = (1..200)
            .map(|k| [0.754877666, 0.569840291].map(|a| (f64::from(k * k) * a).fract()))
            .map(|[x, y]| [x, y, 0.0])
            .collect();
        assert!(refused(&points).contains("no regular x"));
        // A diagonal would need its square.
        let points: Vec<_> = (0..1000).map(|k| [f64::from(k), f64::from(k), 0.0]).collect();
        assert!(refused(&points).contains("fill less than 1/16 of 1000 x 1000 places"));
        assert!(grid("f", &[], line).is_err());
    }
}
