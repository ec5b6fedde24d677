//! Traction curves of several populations, and the interval in which those of a further one lie.

use contact_laws::{AsperityPopulation, AsperitySumCurves, ContactCurves, ElasticPair, TangentialReading};

use super::error::FinishError;

/// Probabilities of the bounds of a [`LawInterval`] (%).
pub const PERCENTILES: [f64; 3] = [5.0, 50.0, 95.0];

/// Fewest realisations between which 5 % and 95 % lie.
pub const LEAST_REALISATIONS: usize = 19;

/// 5, 50 and 95 % of tractions and stiffnesses over realisations, at the same interferences.
///
/// The percentiles are at rank `p (n + 1)`, so that a further realisation lies between the first and the last with probability
/// 0.90, whatever the distribution and the number of realisations.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LawInterval {
    /// Interference `u_n` (m), 0 where the tallest peaks of the patch touch.
    pub interference: Vec<f64>,
    /// Normal traction (Pa).
    pub normal: [Vec<f64>; 3],
    /// Normal traction stiffness (Pa/m).
    pub normal_stiffness: [Vec<f64>; 3],
    /// Tangential traction stiffness along x and y (Pa/m).
    pub tangential: [[Vec<f64>; 3]; 2],
}

impl LawInterval {
    /// Of the populations of realisations.
    ///
    /// # Errors
    /// Fewer than 19 populations; those of [`AsperitySumCurves::try_new`].
    pub fn try_new(
        populations: &[AsperityPopulation],
        material: ElasticPair,
        reading: TangentialReading,
        interference: Vec<f64>,
    ) -> Result<Self, FinishError> {
        if populations.len() < LEAST_REALISATIONS {
            return Err(FinishError::Value {
                field: "realisations",
                value: populations.len() as f64,
                unit: "",
                requirement: "at least 19: fewer do not hold 90 % between them",
            });
        }
        let curves = populations
            .iter()
            .map(|p| AsperitySumCurves::try_new(p.clone(), material, reading))
            .collect::<Result<Vec<_>, _>>()?;
        let percentiles = |of: &dyn Fn(&AsperitySumCurves, f64) -> f64| {
            let mut bounds: [Vec<f64>; 3] = Default::default();
            for &u in &interference {
                let mut values: Vec<f64> = curves.iter().map(|c| of(c, u)).collect();
                values.sort_by(f64::total_cmp);
                for (bound, p) in bounds.iter_mut().zip(PERCENTILES) {
                    bound.push(at_rank(&values, p / 100.0 * (values.len() + 1) as f64));
                }
            }
            bounds
        };
        Ok(Self {
            normal: percentiles(&|c, u| c.normal(u).0),
            normal_stiffness: percentiles(&|c, u| c.normal(u).1),
            tangential: [0, 1].map(|q| percentiles(&|c, u| c.tangential(u)[q].value)),
            interference,
        })
    }
}

/// Value at a rank from 1 among sorted values, linear between them.
fn at_rank(sorted: &[f64], rank: f64) -> f64 {
    let position = (rank - 1.0).clamp(0.0, (sorted.len() - 1) as f64);
    let below = position.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (position - below as f64) * (sorted[above] - sorted[below])
}
