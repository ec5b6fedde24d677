//! Factors on what a surface is known by.

use serde::{Deserialize, Serialize};

/// Factors on what is known of the faces, and a tilt of one against the other: the numbers that sensitivities, calibrations and
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
}

impl Default for Scale {
    fn default() -> Self {
        Self {
            asperity_radius: 1.0,
            asperity_density: 1.0,
            asperity_height: 1.0,
            gap: 1.0,
            gap_tilt: [0.0; 2],
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
        let least = |axis: usize| {
            let terms = points.iter().map(|point| self.gap_tilt[axis] * point[axis]);
            terms.fold(f64::INFINITY, f64::min)
        };
        // Without a tilt not even a zero is added, so that gaps keep their bits.
        let is_tilted = self.gap_tilt != [0.0; 2];
        let corner = if is_tilted { least(0) + least(1) } else { 0.0 };
        known
            .zip(points)
            .map(|(gap, [x, y])| {
                let [along, across] = self.gap_tilt;
                let plane = if is_tilted {
                    along * x + across * y - corner
                } else {
                    0.0
                };
                self.gap * gap + plane
            })
            .collect()
    }
}
