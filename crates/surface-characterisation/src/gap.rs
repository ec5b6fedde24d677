//! Bilinear reference surfaces of elements and the gap between two faces.

use crate::partition::ElementOutlines;

/// `c[0] + c[1] xi + c[2] eta + c[3] xi eta` over one element, with `xi`, `eta` scaled to the element's bounding box.
///
/// Scaled local coordinates keep the normal matrix of the fit well conditioned; in plain metres its condition number
/// exceeds 1e6.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Bilinear {
    /// Centre of the element's bounding box (m).
    pub centre: [f64; 2],
    /// Half widths of the bounding box (m).
    pub half_width: [f64; 2],
    /// Coefficients of 1, xi, eta and xi eta (m).
    pub coefficients: [f64; 4],
}

impl Bilinear {
    /// Value at `point` (m), which may lie outside the element (the form is then extrapolated).
    #[inline]
    pub fn at(&self, point: [f64; 2]) -> f64 {
        let [_, xi, eta, xi_eta] = self.columns(point);
        let c = &self.coefficients;
        c[0] + c[1] * xi + c[2] * eta + c[3] * xi_eta
    }

    /// Least and greatest value over the corners of `element`.
    pub fn range(&self, elements: &ElementOutlines, element: usize) -> [f64; 2] {
        elements
            .corners(element)
            .map(|p| self.at(p))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                [low.min(v), high.max(v)]
            })
    }

    /// The zero form in the scaled coordinates of `element`.
    pub(crate) fn zero(elements: &ElementOutlines, element: usize) -> Self {
        let (low, high) = elements.element_bounds(element);
        Self {
            centre: [0, 1].map(|k| 0.5 * (low[k] + high[k])),
            half_width: [0, 1].map(|k| 0.5 * (high[k] - low[k])),
            coefficients: [0.0; 4],
        }
    }

    /// The columns of the fit at `point`.
    #[inline]
    pub(crate) fn columns(&self, point: [f64; 2]) -> [f64; 4] {
        let xi = (point[0] - self.centre[0]) / self.half_width[0];
        let eta = (point[1] - self.centre[1]) / self.half_width[1];
        [1.0, xi, eta, xi * eta]
    }
}

/// Gap of a pair of faces over one element: the sum of what each face lies below its own tallest point.
///
/// `planes` are the bilinear forms of the two faces, `tallest` the height of the element's tallest peak above its
/// form, and `reference` the tallest point of each whole face, all (m). The gap vanishes where the tallest peaks of
/// both elements touch, which is what `u_n = 0` means to the traction law; measured from the mean planes it would
/// count the peak heights twice. Both faces must be given in one frame.
pub(crate) fn pair_gap(planes: [&Bilinear; 2], tallest: [f64; 2], reference: [f64; 2]) -> Bilinear {
    let mut gap = *planes[0];
    for k in 0..4 {
        gap.coefficients[k] = -(planes[0].coefficients[k] + planes[1].coefficients[k]);
    }
    gap.coefficients[0] += (reference[0] - tallest[0]) + (reference[1] - tallest[1]);
    gap
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detrend::LinearFit;

    #[test]
    fn a_bilinear_surface_is_recovered() {
        let outlines = ElementOutlines::try_new(
            vec![
                [59.0e-3, 1.0e-3],
                [61.4e-3, 0.9e-3],
                [61.0e-3, 3.6e-3],
                [58.8e-3, 3.5e-3],
            ],
            vec![vec![0, 1, 2, 3]],
        )
        .unwrap();
        let truth = |p: [f64; 2]| 4e-6 - 2e-4 * p[0] + 3e-4 * p[1] + 0.07 * p[0] * p[1];
        let mut plane = Bilinear::zero(&outlines, 0);
        let mut fit = LinearFit::<4>::default();
        for k in 0..400 {
            let p = [58.9e-3 + 1.1e-4 * (k % 20) as f64, 1.0e-3 + 1.2e-4 * (k / 20) as f64];
            fit.add(plane.columns(p), truth(p));
        }
        plane.coefficients = fit.solve().unwrap();
        for p in [[60.0e-3, 2.0e-3], [58.8e-3, 3.5e-3], [61.4e-3, 0.9e-3]] {
            assert!(
                (plane.at(p) - truth(p)).abs() < 1e-13 * 1e-3,
                "{} {}",
                plane.at(p),
                truth(p)
            );
        }
        let [low, high] = plane.range(&outlines, 0);
        let corner: Vec<f64> = outlines.corners(0).map(truth).collect();
        assert!((low - corner.iter().copied().fold(f64::INFINITY, f64::min)).abs() < 1e-15);
        assert!((high - corner.iter().copied().fold(f64::NEG_INFINITY, f64::max)).abs() < 1e-15);
    }

    #[test]
    fn the_gap_closes_where_both_tallest_peaks_stand() {
        let outlines = ElementOutlines::try_new(
            vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]],
            vec![vec![0, 1, 2, 3]],
        )
        .unwrap();
        let mut top = Bilinear::zero(&outlines, 0);
        top.coefficients = [-3.0, 0.5, 0.0, 0.25];
        let mut bottom = top;
        bottom.coefficients = [-1.0, -0.5, 0.125, 0.0];
        let gap = pair_gap([&top, &bottom], [0.75, 0.5], [0.0, 0.25]);
        for p in [[0.0, 0.0], [1.3, 0.2]] {
            let expected = (0.0 - top.at(p) - 0.75) + (0.25 - bottom.at(p) - 0.5);
            assert!((gap.at(p) - expected).abs() < 1e-15);
        }
    }
}
