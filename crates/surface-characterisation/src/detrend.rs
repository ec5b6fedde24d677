//! Planes removed from whole faces.

use nalgebra::{SMatrix, SVector};

use crate::error::{SurfaceError, positive};
use crate::partition::ElementOutlines;
use crate::topography::HeightMap;

/// Which points carry the plane that is taken off each face before anything else.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Detrend {
    /// Points along the free edges: within `width` times the shorter side of the rectangle around the interface.
    FreeEdges {
        /// Width of the strip as a fraction of the shorter side, in (0, 0.5].
        width: f64,
    },
    /// All points of the interface rectangle.
    WholeFace,
    /// No plane is removed: the registration of the map is trusted.
    Registered,
}

impl Default for Detrend {
    /// Free edges, 4 % of the shorter side (about 1 mm of a 25.4 mm wide face).
    fn default() -> Self {
        Self::FreeEdges { width: 0.04 }
    }
}

/// A plane `z = offset + slope . (x - centre)`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Plane {
    /// Point of reference in the plane of the interface (m).
    pub centre: [f64; 2],
    /// Height at the centre (m).
    pub offset: f64,
    /// Slopes along x and y (1).
    pub slope: [f64; 2],
}

impl Plane {
    /// Height of the plane at `point` (m).
    pub fn at(&self, point: [f64; 2]) -> f64 {
        self.offset + self.slope[0] * (point[0] - self.centre[0]) + self.slope[1] * (point[1] - self.centre[1])
    }
}

/// Least-squares plane through the points of `map` for which `region` holds, in scaled coordinates.
///
/// # Errors
/// [`SurfaceError::UndeterminedPlane`] with fewer than three points with data, or points on one line.
pub fn fit_plane(map: &HeightMap, region: impl Fn([f64; 2]) -> bool) -> Result<Plane, SurfaceError> {
    let last = map.position(map.nx() - 1, map.ny() - 1);
    let centre = [0.5 * (map.origin()[0] + last[0]), 0.5 * (map.origin()[1] + last[1])];
    let half = [last[0] - centre[0], last[1] - centre[1]];
    let mut fit = LinearFit::<3>::default();
    for j in 0..map.ny() {
        for i in 0..map.nx() {
            let p = map.position(i, j);
            if let Some(z) = map.height(i, j).filter(|_| region(p)) {
                fit.add([1.0, (p[0] - centre[0]) / half[0], (p[1] - centre[1]) / half[1]], z);
            }
        }
    }
    let [offset, sx, sy] = fit.solve().ok_or(SurfaceError::UndeterminedPlane {
        place: "plane of the face",
        points: fit.points,
    })?;
    Ok(Plane {
        centre,
        offset,
        slope: [sx / half[0], sy / half[1]],
    })
}

/// The plane that `how` takes off `map`.
///
/// # Errors
/// A strip width outside (0, 0.5], or too few points with data in the region.
pub fn trend(map: &HeightMap, elements: &ElementOutlines, how: Detrend) -> Result<Plane, SurfaceError> {
    let (low, high) = elements.bounds();
    let inside = move |p: [f64; 2], by: f64| (0..2).all(|k| p[k] >= low[k] + by && p[k] <= high[k] - by);
    match how {
        Detrend::Registered => Ok(Plane::default()),
        Detrend::WholeFace => fit_plane(map, |p| inside(p, 0.0)),
        Detrend::FreeEdges { width } => {
            positive("detrend width", width, "1")?;
            if width > 0.5 {
                return Err(SurfaceError::InvalidValue {
                    field: "detrend width",
                    value: width,
                    unit: "1",
                    requirement: "at most 0.5 of the shorter side",
                });
            }
            let strip = width * (high[0] - low[0]).min(high[1] - low[1]);
            fit_plane(map, |p| inside(p, 0.0) && !inside(p, strip))
        }
    }
}

/// Streaming linear least squares with `N` columns of order one, by normal equations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinearFit<const N: usize> {
    normal: SMatrix<f64, N, N>,
    right: SVector<f64, N>,
    pub(crate) points: usize,
}

impl<const N: usize> Default for LinearFit<N> {
    fn default() -> Self {
        Self {
            normal: SMatrix::zeros(),
            right: SVector::zeros(),
            points: 0,
        }
    }
}

impl<const N: usize> LinearFit<N> {
    #[inline]
    pub(crate) fn add(&mut self, columns: [f64; N], value: f64) {
        for r in 0..N {
            for c in 0..=r {
                self.normal[(r, c)] += columns[r] * columns[c];
            }
            self.right[r] += columns[r] * value;
        }
        self.points += 1;
    }

    /// The coefficients, or `None` when the points do not determine them.
    pub(crate) fn solve(&self) -> Option<[f64; N]> {
        let mut full = self.normal;
        for r in 0..N {
            for c in r + 1..N {
                full[(r, c)] = self.normal[(c, r)];
            }
        }
        let cholesky = full.cholesky()?;
        // Pivots lost to rounding: the columns are dependent.
        let dependent = (0..N).any(|k| cholesky.l_dirty()[(k, k)].powi(2) <= 1e-12 * full[(k, k)]);
        (!dependent).then(|| cholesky.solve(&self.right).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tilted(missing_stride: usize) -> HeightMap {
        let (nx, ny) = (40, 30);
        let mut heights = Vec::new();
        for j in 0..ny {
            for i in 0..nx {
                let (x, y) = (1.0 + i as f64 * 3e-5, -2.0 + j as f64 * 5e-5);
                let z = 3e-6 + 2e-3 * (x - 1.0) - 5e-3 * (y + 2.0);
                heights.push(if (i + j * nx) % missing_stride == 0 {
                    f64::NAN
                } else {
                    z
                });
            }
        }
        HeightMap::try_new(nx, ny, [3e-5, 5e-5], [1.0, -2.0], heights).unwrap()
    }

    #[test]
    fn a_known_plane_is_recovered_far_from_the_origin() {
        let plane = fit_plane(&tilted(7), |_| true).unwrap();
        assert!((plane.slope[0] - 2e-3).abs() < 1e-12, "{plane:?}");
        assert!((plane.slope[1] + 5e-3).abs() < 1e-12, "{plane:?}");
        assert!((plane.at([1.0, -2.0]) - 3e-6).abs() < 1e-14);
    }

    #[test]
    fn points_on_a_line_do_not_determine_a_plane() {
        let error = fit_plane(&tilted(7), |p| (p[1] + 2.0).abs() < 1e-9).unwrap_err();
        assert!(
            matches!(error, SurfaceError::UndeterminedPlane { points: 34, .. }),
            "{error}"
        );
        assert!(fit_plane(&tilted(1), |_| true).is_err());
    }

    #[test]
    fn free_edges_ignore_the_middle() {
        let (nx, ny) = (60, 40);
        let heights: Vec<f64> = (0..nx * ny)
            .map(|k| {
                let (i, j) = (k % nx, k / nx);
                let bump = if (20..40).contains(&i) && (15..25).contains(&j) {
                    1.0
                } else {
                    0.0
                };
                0.01 * i as f64 + bump * i as f64
            })
            .collect();
        let map = HeightMap::try_new(nx, ny, [1.0, 1.0], [0.0, 0.0], heights).unwrap();
        let outline = ElementOutlines::try_new(
            vec![[0.0, 0.0], [59.0, 0.0], [59.0, 39.0], [0.0, 39.0]],
            vec![vec![0, 1, 2, 3]],
        )
        .unwrap();
        let edges = trend(&map, &outline, Detrend::FreeEdges { width: 0.1 }).unwrap();
        assert!(
            (edges.slope[0] - 0.01).abs() < 1e-13 && edges.slope[1].abs() < 1e-13,
            "{edges:?}"
        );
        let whole = trend(&map, &outline, Detrend::WholeFace).unwrap();
        assert!((whole.slope[0] - 0.01).abs() > 1e-4);
        assert_eq!(trend(&map, &outline, Detrend::Registered).unwrap(), Plane::default());
        assert!(trend(&map, &outline, Detrend::FreeEdges { width: 0.7 }).is_err());
    }
}
