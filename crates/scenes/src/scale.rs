//! Factors on what a surface is known by.

use crate::units::Length;
use serde::{Deserialize, Serialize};

/// Factors on what is known of the faces, and a tilt and a crown of one against the other: the numbers that sensitivities, calibrations and
/// uncertain inputs vary where a surface was measured. All of them leave the surface as it is by default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Scale {
    /// Of the radii of asperities (-); above 0, as the next two.
    pub asperity_radius: f64,
    /// Of the number of asperities per area (-).
    pub asperity_density: f64,
    /// Of the differences in height between asperities (-).
    pub asperity_height: f64,
    /// Of the gap between the faces (-); at least 0.
    pub gap: f64,
    /// Slopes along x and y of a plane that is added to the gap (rad), at most 0.1 in size. It is zero at the corner of
    /// the interface where it is least.
    pub gap_tilt: [f64; 2],
    /// Rises along x and y of a parabola that is added to the gap (length), from the middle to the ends of the interface (its outermost
    /// quadrature points). Where it is negative the ends are nearer than the middle. It is zero where it is least.
    pub gap_crown: [Length; 2],
}

impl Default for Scale {
    fn default() -> Self {
        Self {
            asperity_radius: 1.0,
            asperity_density: 1.0,
            asperity_height: 1.0,
            gap: 1.0,
            gap_tilt: [0.0; 2],
            gap_crown: [Length::default(); 2],
        }
    }
}

impl Scale {
    /// Whether the surface is as it is known.
    pub fn is_one(&self) -> bool {
        *self == Self::default()
    }

    /// Whether the asperities are as they are known.
    pub fn keeps_asperities(&self) -> bool {
        [self.asperity_radius, self.asperity_density, self.asperity_height] == [1.0; 3]
    }

    /// The gaps (m) at points of the interface, from those that are known.
    pub fn gaps(&self, known: impl Iterator<Item = f64>, points: &[[f64; 2]]) -> Vec<f64> {
        let along = |axis: usize| points.iter().map(move |point| point[axis]);
        let added = [0, 1].map(|axis| {
            let (low, high) = along(axis).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            let (slope, rise, half) = (self.gap_tilt[axis], self.gap_crown[axis].si(), 0.5 * (high - low));
            move |x: f64| {
                let crown = if rise == 0.0 || half == 0.0 {
                    0.0
                } else {
                    rise * ((x - low) / half - 1.0).powi(2)
                };
                slope * x + crown
            }
        });
        let least = [0, 1].map(|axis| along(axis).map(added[axis]).fold(f64::INFINITY, f64::min));
        // Without a form not even a zero is added, so that gaps keep their bits.
        let is_flat = self.gap_tilt == [0.0; 2] && self.gap_crown == [Length::default(); 2];
        known
            .zip(points)
            .map(|(gap, [x, y])| {
                let form = match is_flat {
                    true => 0.0,
                    false => added[0](*x) + added[1](*y) - (least[0] + least[1]),
                };
                self.gap * gap + form
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(gap_tilt: [f64; 2], gap_crown: [f64; 2]) -> Vec<f64> {
        let points = [[-1.0, 2.0], [0.0, 2.0], [1.0, 2.0], [0.5, 4.0]];
        let scale = Scale {
            gap: 2.0,
            gap_tilt,
            gap_crown: gap_crown.map(Length::from_si),
            ..Scale::default()
        };
        scale.gaps([0.0, 1.0, 0.0, 0.0].into_iter(), &points)
    }

    #[test]
    fn forms_are_added_to_the_scaled_gap_and_are_zero_where_they_are_least() {
        assert_eq!(of([0.0; 2], [0.0; 2]), [0.0, 2.0, 0.0, 0.0]);
        assert_eq!(of([0.25, 0.0], [0.0; 2]), [0.0, 2.25, 0.5, 0.375]);
        // The ends stand apart, or touch first.
        assert_eq!(of([0.0; 2], [8.0, 0.0]), [8.0, 2.0, 8.0, 2.0]);
        assert_eq!(of([0.0; 2], [-8.0, 0.0]), [0.0, 10.0, 0.0, 6.0]);
        // Both at once are least at x = 0.5.
        assert_eq!(of([-2.0, 0.0], [2.0, 0.0]), [4.5, 2.5, 0.5, 0.0]);
        // Two rows of points are two ends.
        assert_eq!(of([0.0; 2], [0.0, 3.0]), [0.0, 2.0, 0.0, 0.0]);
    }
}
