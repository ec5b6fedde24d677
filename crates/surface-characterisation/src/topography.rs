//! Height maps on regular grids.

use crate::error::{SurfaceError, finite, positive};

/// Heights of a map, in either precision.
#[derive(Debug, Clone, PartialEq)]
enum Heights {
    F32(Vec<f32>),
    F64(Vec<f64>),
}

/// Heights to build a [`HeightMap`] from: `Vec<f32>` or `Vec<f64>`, metres, x running fastest, NaN where there
/// is no data.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightData(Heights);

impl From<Vec<f32>> for HeightData {
    fn from(heights: Vec<f32>) -> Self {
        Self(Heights::F32(heights))
    }
}

impl From<Vec<f64>> for HeightData {
    fn from(heights: Vec<f64>) -> Self {
        Self(Heights::F64(heights))
    }
}

/// A measured face: heights over a regular grid in the plane of the interface, with missing points.
///
/// Heights (m) point out of the body, towards the mating face. Point `(i, j)` lies at
/// `origin + (i dx, j dy)`, with x along the beam and y across it, in the frame of the interface mesh. A mating face
/// that was scanned from its own side is brought into this frame by [`HeightMap::mirrored_x`].
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    nx: usize,
    ny: usize,
    step: [f64; 2],
    origin: [f64; 2],
    heights: Heights,
    missing: usize,
    height_step: Option<f64>,
}

impl HeightMap {
    /// Builds a map of `nx` by `ny` points with steps `step` (m) from `origin` (m).
    ///
    /// # Errors
    /// Fewer than 3 points along a direction, steps that are not positive, an origin that is not finite, another
    /// number of heights than `nx * ny`, or an infinite height.
    pub fn try_new(
        nx: usize,
        ny: usize,
        step: [f64; 2],
        origin: [f64; 2],
        heights: impl Into<HeightData>,
    ) -> Result<Self, SurfaceError> {
        for (field, n) in [("nx", nx), ("ny", ny)] {
            if n < 3 {
                return Err(SurfaceError::InvalidValue {
                    field,
                    value: n as f64,
                    unit: "points",
                    requirement: "at least 3, the width of the peak kernel",
                });
            }
        }
        positive("dx", step[0], "m")?;
        positive("dy", step[1], "m")?;
        finite("origin x", origin[0], "m")?;
        finite("origin y", origin[1], "m")?;
        let HeightData(heights) = heights.into();
        let found = match &heights {
            Heights::F32(h) => h.len(),
            Heights::F64(h) => h.len(),
        };
        if nx.checked_mul(ny) != Some(found) {
            return Err(SurfaceError::LengthMismatch {
                field: "heights",
                found,
                expected: nx.saturating_mul(ny),
                remedy: "give nx * ny heights, x running fastest",
            });
        }
        let mut map = Self {
            nx,
            ny,
            step,
            origin,
            heights,
            missing: 0,
            height_step: None,
        };
        for index in 0..found {
            let value = map.value(index);
            if value.is_infinite() {
                return Err(SurfaceError::InfiniteHeight {
                    i: index % nx,
                    j: index / nx,
                    value,
                });
            }
            map.missing += usize::from(value.is_nan());
        }
        Ok(map)
    }

    /// States the height resolution `height_step` (m) of the instrument.
    ///
    /// Neighbouring points that differ by less than half of it count as level when peaks are looked for: without it,
    /// the small slope that de-trending puts on the steps of a quantised map makes false peaks of them.
    ///
    /// # Errors
    /// A step that is not positive and finite.
    pub fn with_height_step(mut self, height_step: f64) -> Result<Self, SurfaceError> {
        self.height_step = Some(positive("height_step", height_step, "m")?);
        Ok(self)
    }

    /// Number of points along x.
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Number of points along y.
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// Lateral steps along x and y (m).
    pub fn step(&self) -> [f64; 2] {
        self.step
    }

    /// Position of point (0, 0) (m).
    pub fn origin(&self) -> [f64; 2] {
        self.origin
    }

    /// Height resolution (m), where stated.
    pub fn height_step(&self) -> Option<f64> {
        self.height_step
    }

    /// Number of points without data.
    pub fn missing(&self) -> usize {
        self.missing
    }

    /// Position of point `(i, j)` (m).
    pub fn position(&self, i: usize, j: usize) -> [f64; 2] {
        [
            self.origin[0] + i as f64 * self.step[0],
            self.origin[1] + j as f64 * self.step[1],
        ]
    }

    /// Height of point `(i, j)` (m); `None` outside the grid or where there is no data.
    pub fn height(&self, i: usize, j: usize) -> Option<f64> {
        if i >= self.nx || j >= self.ny {
            return None;
        }
        let z = self.value(j * self.nx + i);
        (!z.is_nan()).then_some(z)
    }

    /// Height at a position (m), bilinear between the four points around it; `None` where one of them has no data.
    pub fn interpolated(&self, at: [f64; 2]) -> Option<f64> {
        let n = [self.nx, self.ny];
        let place = [0, 1].map(|axis| {
            let x = (at[axis] - self.origin[axis]) / self.step[axis];
            // On the last point, or within rounding of a point.
            let nearest = x.round();
            let x = if (x - nearest).abs() < 1e-6 { nearest } else { x };
            (x >= 0.0 && x <= (n[axis] - 1) as f64).then(|| (x.floor() as usize, x.fract()))
        });
        let [(i, x), (j, y)] = [place[0]?, place[1]?];
        let mut sum = 0.0;
        for (di, of_x) in [(0, 1.0 - x), (1, x)] {
            for (dj, of_y) in [(0, 1.0 - y), (1, y)] {
                if of_x * of_y > 0.0 {
                    sum += of_x * of_y * self.height(i + di, j + dj)?;
                }
            }
        }
        Some(sum)
    }

    /// The face seen from the other side: x becomes `2 about - x`, heights keep their sign (still out of the body).
    #[must_use]
    pub fn mirrored_x(&self, about: f64) -> Self {
        let mut map = self.clone();
        match &mut map.heights {
            Heights::F32(h) => h.chunks_mut(self.nx).for_each(<[f32]>::reverse),
            Heights::F64(h) => h.chunks_mut(self.nx).for_each(<[f64]>::reverse),
        }
        map.origin[0] = 2.0 * about - (self.origin[0] + (self.nx - 1) as f64 * self.step[0]);
        map
    }

    /// The same heights with the grid moved by `shift` (m): the in-plane registration of one face to the other.
    ///
    /// # Errors
    /// A shift that is not finite.
    pub fn shifted(mut self, shift: [f64; 2]) -> Result<Self, SurfaceError> {
        self.origin[0] += finite("shift x", shift[0], "m")?;
        self.origin[1] += finite("shift y", shift[1], "m")?;
        Ok(self)
    }

    /// The same grid with other heights and another height resolution.
    pub(crate) fn with_heights(&self, heights: Vec<f64>, height_step: Option<f64>) -> Result<Self, SurfaceError> {
        let map = Self::try_new(self.nx, self.ny, self.step, self.origin, heights)?;
        Ok(Self { height_step, ..map })
    }

    /// Height at the flat index, NaN where there is no data.
    pub(crate) fn value(&self, index: usize) -> f64 {
        match &self.heights {
            Heights::F32(h) => f64::from(h[index]),
            Heights::F64(h) => h[index],
        }
    }

    /// Columns (or rows, `axis = 1`) whose points lie in `[from, to]`, cut to the grid: first and one past the last.
    pub(crate) fn indices_within(&self, axis: usize, from: f64, to: f64) -> (usize, usize) {
        let n = if axis == 0 { self.nx } else { self.ny };
        let first = ((from - self.origin[axis]) / self.step[axis])
            .ceil()
            .clamp(0.0, n as f64) as usize;
        let last = ((to - self.origin[axis]) / self.step[axis])
            .floor()
            .clamp(-1.0, n as f64 - 1.0)
            + 1.0;
        (first, (last as usize).max(first))
    }
}

/// The rows of a grid of `nx` by `ny` values as its columns.
pub(crate) fn turn<T: Copy>(rows: &[T], [nx, ny]: [usize; 2], columns: &mut [T]) {
    for j in 0..ny {
        for i in 0..nx {
            columns[i * ny + j] = rows[j * nx + i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_precisions_positions_and_missing_points() {
        let f32_map = HeightMap::try_new(3, 3, [1.0, 2.0], [10.0, 20.0], vec![1.0f32; 9]).unwrap();
        assert_eq!(f32_map.height(2, 2), Some(1.0));
        assert_eq!(f32_map.position(2, 1), [12.0, 22.0]);
        let mut heights: Vec<f64> = (0..9).map(f64::from).collect();
        heights[4] = f64::NAN;
        let map = HeightMap::try_new(3, 3, [1.0, 2.0], [10.0, 20.0], heights).unwrap();
        assert_eq!((map.height(1, 1), map.missing()), (None, 1));
        assert_eq!(
            (map.interpolated([12.0, 21.0]), map.interpolated([11.0, 20.0])),
            (Some(3.5), Some(1.0))
        );
        assert_eq!(
            (map.interpolated([11.5, 21.0]), map.interpolated([12.1, 21.0])),
            (None, None)
        );
        assert_eq!(map.height(3, 0), None);
        let mirrored = map.mirrored_x(0.0);
        // The point that was at x = 12 is now at -12.
        assert_eq!(mirrored.position(0, 0), [-12.0, 20.0]);
        assert_eq!(mirrored.height(0, 2), map.height(2, 2));
        let back = mirrored.mirrored_x(0.0);
        assert_eq!(back.origin(), map.origin());
        assert!((0..9).all(|k| back.height(k % 3, k / 3) == map.height(k % 3, k / 3)));
        assert_eq!(map.shifted([1.0, -1.0]).unwrap().origin(), [11.0, 19.0]);
    }

    #[test]
    fn invalid_maps_are_named() {
        let flat = || vec![0.0f64; 9];
        let new = |nx, ny, step, origin, h: Vec<f64>| HeightMap::try_new(nx, ny, step, origin, h);
        assert!(matches!(
            new(2, 4, [1.0, 1.0], [0.0, 0.0], flat()),
            Err(SurfaceError::InvalidValue { field: "nx", .. })
        ));
        assert!(matches!(
            new(3, 3, [0.0, 1.0], [0.0, 0.0], flat()),
            Err(SurfaceError::InvalidValue { field: "dx", .. })
        ));
        assert!(matches!(
            new(3, 3, [1.0, 1.0], [f64::NAN, 0.0], flat()),
            Err(SurfaceError::InvalidValue { field: "origin x", .. })
        ));
        assert!(matches!(
            new(3, 4, [1.0, 1.0], [0.0, 0.0], flat()),
            Err(SurfaceError::LengthMismatch {
                expected: 12,
                found: 9,
                ..
            })
        ));
        assert!(new(usize::MAX, 3, [1.0, 1.0], [0.0, 0.0], flat()).is_err());
        let mut infinite = flat();
        infinite[5] = f64::INFINITY;
        assert!(matches!(
            new(3, 3, [1.0, 1.0], [0.0, 0.0], infinite),
            Err(SurfaceError::InfiniteHeight { i: 2, j: 1, .. })
        ));
        assert!(
            new(3, 3, [1.0, 1.0], [0.0, 0.0], flat())
                .unwrap()
                .with_height_step(-1.0)
                .is_err()
        );
    }

    #[test]
    fn index_ranges_are_cut_to_the_grid() {
        let map = HeightMap::try_new(5, 3, [0.5, 1.0], [1.0, 0.0], vec![0.0f64; 15]).unwrap();
        assert_eq!(map.indices_within(0, 1.5, 2.5), (1, 4));
        assert_eq!(map.indices_within(0, -9.0, 99.0), (0, 5));
        assert_eq!(map.indices_within(0, 99.0, 100.0), (5, 5));
        assert_eq!(map.indices_within(0, -5.0, -4.0), (0, 0));
    }
}
