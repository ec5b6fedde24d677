//! The readings and settings of a characterisation.

use contact_laws::{ElasticPair, TangentialReading};

use crate::bootstrap::Bootstrap;
use crate::detrend::Detrend;
use crate::error::{SurfaceError, positive};
use crate::face::{AsperityCount, PackingHeight};
use crate::noise::NoiseHandling;
use crate::pair::{HeightCombination, PairRadius};
use crate::peaks::RadiusStatistic;
use crate::registration::Registration;

/// Interferences at which the traction curves are sampled, equidistant in their logarithm.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct InterferenceRange {
    /// Least interference (m).
    pub from: f64,
    /// Greatest interference (m).
    pub to: f64,
    /// Number of samples, at least 8.
    pub points: usize,
}

impl Default for InterferenceRange {
    /// 0.1 to 20 um in 64 samples: the operating range of a tightly bolted steel joint with a margin.
    fn default() -> Self {
        Self {
            from: 0.1e-6,
            to: 20e-6,
            points: 64,
        }
    }
}

impl InterferenceRange {
    /// The samples (m).
    ///
    /// # Errors
    /// Ends that are not positive and ascending, or fewer than 8 samples.
    pub fn samples(&self) -> Result<Vec<f64>, SurfaceError> {
        positive("least interference", self.from, "m")?;
        positive("greatest interference", self.to, "m")?;
        let invalid = |field, value, unit, requirement| {
            Err(SurfaceError::InvalidValue {
                field,
                value,
                unit,
                requirement,
            })
        };
        if self.to <= self.from {
            return invalid("greatest interference", self.to, "m", "above the least interference");
        }
        if self.points < 8 {
            return invalid("interference samples", self.points as f64, "1", "at least 8");
        }
        let ratio = (self.to / self.from).ln();
        Ok((0..self.points)
            .map(|k| self.from * (ratio * k as f64 / (self.points - 1) as f64).exp())
            .collect())
    }
}

/// Everything that [`crate::characterise`] can be told; [`Options::new`] gives the default readings.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Options {
    /// Elastic constants of both bodies.
    pub material: ElasticPair,
    /// Treatment of noise, before anything else.
    pub noise: NoiseHandling,
    /// Motion of the bottom face against the top one.
    pub registration: Registration,
    /// Plane that is taken off each face.
    pub detrend: Detrend,
    /// How the radii of an element's peaks become one.
    pub radius: RadiusStatistic,
    /// How the radii of two faces combine.
    pub pair_radius: PairRadius,
    /// Peak height in the packing estimate.
    pub packing_height: PackingHeight,
    /// Packing efficiency eta of eq. (27).
    pub packing_efficiency: f64,
    /// Where the number of asperities comes from.
    pub count: AsperityCount,
    /// How the heights of two faces combine.
    pub heights: HeightCombination,
    /// Reading of the tangential stiffness.
    pub tangential: TangentialReading,
    /// Interferences of the curves and fits.
    pub interference: InterferenceRange,
    /// Reference interference of the fits (m).
    pub u_ref: f64,
    /// Bands of the curves. Its seed also serves [`HeightCombination::Summed`].
    pub bootstrap: Bootstrap,
    /// Wolf pruning of the areal parameters as a fraction of Sz, see [`crate::ArealPatch::parameters`].
    pub pruning: f64,
    /// With fewer peaks than this in an element's pair, the closed single-asperity form takes the place of the sums.
    pub least_peaks: usize,
}

impl Options {
    /// The default readings for a material.
    pub fn new(material: ElasticPair) -> Self {
        Self {
            material,
            noise: NoiseHandling::default(),
            registration: Registration::default(),
            detrend: Detrend::default(),
            radius: RadiusStatistic::default(),
            pair_radius: PairRadius::default(),
            packing_height: PackingHeight::default(),
            packing_efficiency: 0.5,
            count: AsperityCount::default(),
            heights: HeightCombination::default(),
            tangential: TangentialReading::default(),
            interference: InterferenceRange::default(),
            u_ref: 1e-6,
            bootstrap: Bootstrap::default(),
            pruning: 0.05,
            least_peaks: 5,
        }
    }
}
