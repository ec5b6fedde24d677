//! Where the faces lie against each other.

use rayon::prelude::*;

use crate::detrend::Plane;
use crate::error::{SurfaceError, finite, positive};
use crate::partition::{ElementOutlines, Partition};
use crate::topography::HeightMap;

/// How the bottom face is moved against the top one before they are paired.
///
/// Both maps are in one frame by then: a mating face that was scanned from its own side is mirrored first
/// ([`HeightMap::mirrored_x`]). The shift moves its grid; the tilt is added after a plane was taken off
/// ([`crate::Detrend`]), about the centre of the rectangle around the interface, so that no de-trending undoes it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Registration {
    /// Shift along x and y (m).
    pub shift: [f64; 2],
    /// Slopes along x and y added to the heights of the bottom face (1).
    pub tilt: [f64; 2],
}

impl Registration {
    /// `trend` less the tilt.
    pub(crate) fn tilted(&self, trend: Plane, elements: &ElementOutlines) -> Result<Plane, SurfaceError> {
        finite("tilt x", self.tilt[0], "1")?;
        finite("tilt y", self.tilt[1], "1")?;
        let (low, high) = elements.bounds();
        let centre = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
        let tilted = Plane {
            centre: trend.centre,
            // The tilt vanishes at the centre of the interface, which may not be the centre of the trend.
            offset: trend.offset
                - (0..2)
                    .map(|k| self.tilt[k] * (trend.centre[k] - centre[k]))
                    .sum::<f64>(),
            slope: [0, 1].map(|k| trend.slope[k] - self.tilt[k]),
        };
        Ok(if self.tilt == [0.0; 2] { trend } else { tilted })
    }
}

/// A height map's place against the interface by the edges and holes of its mask.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Alignment {
    /// Shift that brings the map onto the elements (m), a whole number of lateral steps: hand it to
    /// [`HeightMap::shifted`].
    pub shift: [f64; 2],
    /// Lateral steps of the map (m), which is as far as the shift is resolved.
    pub resolution: [f64; 2],
    /// Points with data outside the elements or without data inside, before and after the shift.
    pub mismatch: [usize; 2],
    /// Points of the mismatch that one more step along x and along y would add, on the side where it adds less: how
    /// sharply edges and holes fix the place.
    pub sharpness: [usize; 2],
}

/// Finds the shift of at most `reach` (m) along x and y under which the data of `map` best cover the elements.
///
/// Data inside the elements and missing data outside count; every shift by whole steps is tried, and of equal ones the
/// smallest is taken. Scattered missing points count alike for every shift.
///
/// # Errors
/// A reach that is not positive or beyond half of the interface's shorter side, or a mask that does not fix the place:
/// [`SurfaceError::UndeterminedAlignment`].
pub fn align(map: &HeightMap, elements: &ElementOutlines, reach: f64) -> Result<Alignment, SurfaceError> {
    positive("alignment reach", reach, "m")?;
    let (low, high) = elements.bounds();
    let step = map.step();
    if reach > 0.5 * (high[0] - low[0]).min(high[1] - low[1]) {
        return Err(SurfaceError::InvalidValue {
            field: "alignment reach",
            value: reach,
            unit: "m",
            requirement: "at most half of the interface's shorter side",
        });
    }
    // One step more than asked for, so that the last shifts have neighbours too.
    let most = step.map(|d| (reach / d).floor() as i64);
    let pad = most.map(|m| m as usize + 1);
    let n = [map.nx(), map.ny()];
    let padded = [0, 1].map(|k| n[k] + 2 * pad[k]);
    let origin = [0, 1].map(|k| map.origin()[k] - pad[k] as f64 * step[k]);
    let grid = HeightMap::try_new(padded[0], padded[1], step, origin, vec![0.0f32; padded[0] * padded[1]])?;
    let partition = Partition::new(&grid, elements);
    let inside = BitRows::new(padded, |i, j| partition.element(i, j).is_some());
    let data = BitRows::new(n, |i, j| map.height(i, j).is_some());
    // Every data point that moves inside also takes one point without data away from there.
    let points = [&inside, &data].map(|rows| rows.words.iter().map(|w| w.count_ones() as usize).sum::<usize>());
    let mismatch = |[di, dj]: [i64; 2]| {
        let at = [(pad[0] as i64 + di) as usize, (pad[1] as i64 + dj) as usize];
        points[0] + points[1] - 2 * data.common(&inside, at)
    };

    let rows: Vec<_> = (-most[1]..=most[1])
        .into_par_iter()
        .map(|dj| {
            (-most[0]..=most[0])
                .map(|di| (mismatch([di, dj]), di * di + dj * dj, [di, dj]))
                .min()
        })
        .collect();
    let Some((least, _, best)) = rows.into_iter().flatten().min() else {
        return Err(SurfaceError::UndeterminedAlignment { axis: "x" });
    };
    let mut sharpness = [0; 2];
    for axis in 0..2 {
        let beside = [-1, 1].map(|by| {
            let mut shift = best;
            shift[axis] += by;
            mismatch(shift)
        });
        sharpness[axis] = beside[0].min(beside[1]).saturating_sub(least);
        if sharpness[axis] == 0 {
            return Err(SurfaceError::UndeterminedAlignment { axis: ["x", "y"][axis] });
        }
    }
    Ok(Alignment {
        shift: [0, 1].map(|k| best[k] as f64 * step[k]),
        resolution: step,
        mismatch: [mismatch([0, 0]), least],
        sharpness,
    })
}

/// A mask of which 64 points are compared at a time.
struct BitRows {
    words: Vec<u64>,
    per_row: usize,
    rows: usize,
}

impl BitRows {
    fn new(n: [usize; 2], holds: impl Fn(usize, usize) -> bool) -> Self {
        // One word more than needed: shifted rows read two words at a time.
        let per_row = n[0].div_ceil(64) + 1;
        let mut words = vec![0; per_row * n[1]];
        for j in 0..n[1] {
            for i in 0..n[0] {
                words[j * per_row + i / 64] |= u64::from(holds(i, j)) << (i % 64);
            }
        }
        Self {
            words,
            per_row,
            rows: n[1],
        }
    }

    /// Points that this mask, laid with its first point on point `at` of the larger `other`, has in common with it.
    fn common(&self, other: &Self, at: [usize; 2]) -> usize {
        let (skip, bits) = (at[0] / 64, at[0] % 64);
        let mut common = 0;
        for j in 0..self.rows {
            let own = &self.words[j * self.per_row..][..self.per_row];
            let theirs = &other.words[(j + at[1]) * other.per_row..][..other.per_row];
            for (k, word) in own.iter().enumerate() {
                let at = |k: usize| theirs.get(k).copied().unwrap_or(0);
                let high = if bits == 0 { 0 } else { at(k + skip + 1) << (64 - bits) };
                common += (word & (at(k + skip) >> bits | high)).count_ones() as usize;
            }
        }
        common
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::synthetic::SyntheticFace;

    /// 6 x 4 elements on 18 mm x 8 mm with one missing in the middle: an edge and a hole.
    pub(crate) fn outlines() -> ElementOutlines {
        let nodes = (0..35)
            .map(|k| [f64::from(k % 7) * 3e-3 - 9e-3, f64::from(k / 7) * 2e-3])
            .collect();
        let quads = (0..24u32)
            .filter(|e| *e != 8)
            .map(|e| {
                let a = e / 6 * 7 + e % 6;
                vec![a, a + 1, a + 8, a + 7]
            })
            .collect();
        ElementOutlines::try_new(nodes, quads).unwrap()
    }

    pub(crate) fn face(seed: u64, missing: impl Fn([f64; 2]) -> bool + Sync) -> HeightMap {
        SyntheticFace {
            points: [220, 110],
            step: [100e-6, 90e-6],
            origin: [-11.03e-3, -0.93e-3],
            rms: 1.5e-6,
            correlation_length: [300e-6, 300e-6],
            waviness: vec![],
            tilt: [1e-3, 0.0],
            height_step: Some(0.1e-6),
            seed,
        }
        .generate(missing)
        .unwrap()
    }

    fn in_elements([x, y]: [f64; 2]) -> bool {
        let hole = (-3e-3..0.0).contains(&x) && (2e-3..4e-3).contains(&y);
        (-9e-3..9e-3).contains(&x) && (0.0..8e-3).contains(&y) && !hole
    }

    #[test]
    fn a_displaced_mask_is_found_to_the_step() {
        for (di, dj) in [(0, 0), (5, -3), (-7, 4), (1, 0)] {
            let shift = [f64::from(di) * 100e-6, f64::from(dj) * 90e-6];
            // Dropouts all over, and the part of the map beyond the face without data.
            let map = face(1, |p| {
                let dropout = ((p[0] * 1e7) as i64 * 31 + (p[1] * 1e7) as i64 * 17) % 23 == 0;
                !in_elements([p[0] + shift[0], p[1] + shift[1]]) || dropout
            });
            let found = align(&map, &outlines(), 1e-3).unwrap();
            for k in 0..2 {
                assert!((found.shift[k] - shift[k]).abs() < 1e-12, "{found:?} {shift:?}");
            }
            assert!(found.mismatch[1] <= found.mismatch[0]);
            // Both edges and both sides of the hole: 2 (8 + 2) mm / 90 um and 2 (18 + 3) mm / 100 um points, less dropouts.
            assert!((170..250).contains(&found.sharpness[0]), "{found:?}");
            assert!((350..450).contains(&found.sharpness[1]), "{found:?}");
        }
    }

    #[test]
    fn a_mask_without_edges_is_refused() {
        let whole = face(1, |_| false);
        assert_eq!(
            align(&whole, &outlines(), 0.3e-3),
            Err(SurfaceError::UndeterminedAlignment { axis: "x" })
        );
        assert!(align(&whole, &outlines(), 5e-3).is_err() && align(&whole, &outlines(), -1.0).is_err());
        // Edges along x only, and the hole out of sight.
        let strip = face(1, |[_, y]| !(0.0..8e-3).contains(&y));
        let nodes = vec![[-5e-3, 0.0], [5e-3, 0.0], [5e-3, 8e-3], [-5e-3, 8e-3]];
        let plain = ElementOutlines::try_new(nodes, vec![vec![0, 1, 2, 3]]).unwrap();
        assert_eq!(
            align(&strip, &plain, 0.3e-3),
            Err(SurfaceError::UndeterminedAlignment { axis: "x" })
        );
    }
}
