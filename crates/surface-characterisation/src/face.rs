//! Asperities of one face, and how many there are.

use crate::areal::ArealParameters;
use crate::error::{SurfaceError, not_negative, positive};
use crate::gap::Bilinear;
use crate::resolution::Resolution;

/// Peak height that enters the half-axes `w_q` of the packing estimate (eq. 26).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum PackingHeight {
    /// The element's total roughness R_t, as published.
    #[default]
    TotalRoughness,
    /// Mean height of the peaks above the lowest one (R_t where that vanishes: a single peak).
    MeanPeak,
}

/// Where the number of asperities comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum AsperityCount {
    /// Ellipses packed on the element's area (eq. 27).
    #[default]
    Packing,
    /// Measured summits (8 neighbours), at least one.
    Summits,
}

/// What one face shows over one element.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FaceAsperities {
    /// Points with data inside the element.
    pub points: usize,
    /// Points without data inside the element.
    pub missing: usize,
    /// Bilinear form of the de-trended heights; everything below is measured from it.
    pub plane: Bilinear,
    /// Areal parameters of the residual heights.
    pub areal: ArealParameters,
    /// Peaks found along x lines and along y lines.
    pub peaks: [usize; 2],
    /// Summits (8 neighbours).
    pub summits: usize,
    /// Radius along x and along y by the chosen statistic (m); `None` without a peak along that direction.
    pub radius: [Option<f64>; 2],
    /// What the instrument resolves of all this.
    pub resolution: Resolution,
    /// Peak heights above the lowest peak (m), both directions, in scan order. Not written out: the population of the pair
    /// is.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub heights: Vec<f64>,
    /// Height of the tallest peak (of the tallest point where there is no peak) above the plane (m).
    pub tallest: f64,
    /// Highest point or peak above the de-trended datum of the whole face (m).
    pub summit_level: f64,
    /// Number of asperities by the chosen count; `None` without peaks.
    pub asperity_count: Option<f64>,
}

impl FaceAsperities {
    /// Total roughness R_t, highest minus lowest residual height (m): Sz.
    pub fn total_roughness(&self) -> f64 {
        self.areal.sz
    }
}

/// Number of ellipses packed on an area (eq. 27): `eta A / (pi w_x w_y)` with `w_q = sqrt(z (2 R_q - z))` (eq. 26).
///
/// `area` (m^2), `height` z (m), single-face radii `radius` (m), packing efficiency `efficiency` (0.5 for peaks and
/// valleys alike). z is cut at `R_q`: beyond it the published form shrinks again and beyond `2 R_q` is imaginary.
///
/// # Errors
/// An argument that is not positive and finite.
pub fn packing_count(area: f64, height: f64, radius: [f64; 2], efficiency: f64) -> Result<f64, SurfaceError> {
    positive("area", area, "m^2")?;
    positive("height", height, "m")?;
    positive("packing efficiency", efficiency, "1")?;
    let mut axes = 1.0;
    for r in radius {
        let z = height.min(positive("radius", r, "m")?);
        axes *= (z * (2.0 * r - z)).sqrt();
    }
    Ok(efficiency * area / (std::f64::consts::PI * axes))
}

/// Asperity count of one face by the chosen readings; `None` without peaks.
pub(crate) fn face_count(
    face: &FaceAsperities,
    area: f64,
    count: AsperityCount,
    height: PackingHeight,
    efficiency: f64,
) -> Result<Option<f64>, SurfaceError> {
    let radius = match face.radius {
        [Some(x), Some(y)] => [x, y],
        [Some(r), None] | [None, Some(r)] => [r, r],
        [None, None] => return Ok(None),
    };
    let mean_peak = face.heights.iter().sum::<f64>() / face.heights.len() as f64;
    not_negative("mean peak height", mean_peak, "m")?;
    let height = match height {
        PackingHeight::MeanPeak if mean_peak > 0.0 => mean_peak,
        _ => face.total_roughness(),
    };
    Ok(Some(match count {
        AsperityCount::Packing => packing_count(area, height, radius, efficiency)?,
        AsperityCount::Summits => face.summits.max(1) as f64,
    }))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn face(radius: [Option<f64>; 2], heights: Vec<f64>, count: Option<f64>) -> FaceAsperities {
        FaceAsperities {
            points: 100,
            missing: 0,
            plane: Bilinear {
                centre: [0.0; 2],
                half_width: [1.0; 2],
                coefficients: [0.0; 4],
            },
            areal: ArealParameters {
                points: 100,
                sa: 0.8e-6,
                sq: 1e-6,
                sz: 4e-6,
                ssk: None,
                sku: None,
                sdq: None,
                peaks: 0,
                spd: 0.0,
                spc: None,
            },
            peaks: [heights.len(), 0],
            summits: 0,
            radius,
            resolution: Resolution {
                height_step: None,
                lateral_step: [1e-5; 2],
                least_curvature: None,
                curvature: [None; 2],
                curvature_at_double_step: [None; 2],
                samples_per_peak: [None; 2],
            },
            heights,
            tallest: 2e-6,
            summit_level: 2e-6,
            asperity_count: count,
        }
    }

    #[test]
    fn packing_of_spheres_and_its_cut() {
        // z = R: the ellipse is the great circle.
        let n = packing_count(1e-6, 1e-4, [1e-4, 1e-4], 0.5).unwrap();
        assert!((n - 0.5 * 1e-6 / (std::f64::consts::PI * 1e-8)).abs() < 1e-9);
        // Beyond the radius nothing changes: the published form would be imaginary at z = 2.5 R.
        assert_eq!(packing_count(1e-6, 2.5e-4, [1e-4, 1e-4], 0.5).unwrap(), n);
        let flat = packing_count(1e-6, 1e-6, [1e-3, 2e-3], 0.5).unwrap();
        let axes = (1e-6f64 * (2e-3 - 1e-6)).sqrt() * (1e-6f64 * (4e-3 - 1e-6)).sqrt();
        assert!((flat * std::f64::consts::PI * axes / 0.5e-6 - 1.0).abs() < 1e-14);
        assert!(packing_count(1e-6, 0.0, [1e-3, 2e-3], 0.5).is_err());
    }

    #[test]
    fn counts_by_each_reading() {
        let mut f = face([Some(1e-3), None], vec![0.0, 2e-6], None);
        let count = |f: &FaceAsperities, c, h| face_count(f, 1e-6, c, h, 0.5).unwrap().unwrap();
        let total = count(&f, AsperityCount::Packing, PackingHeight::TotalRoughness);
        let mean = count(&f, AsperityCount::Packing, PackingHeight::MeanPeak);
        // 4 um against 1 um: the packed area goes with z, so the count goes with 1/z.
        assert!((mean / total - 4.0).abs() < 0.01, "{}", mean / total);
        assert_eq!(count(&f, AsperityCount::Summits, PackingHeight::TotalRoughness), 1.0);
        f.summits = 7;
        assert_eq!(count(&f, AsperityCount::Summits, PackingHeight::TotalRoughness), 7.0);
        f.heights = vec![0.0];
        assert_eq!(count(&f, AsperityCount::Packing, PackingHeight::MeanPeak), total);
    }
}
