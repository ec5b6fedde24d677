//! How an interface changes with a number of its scene.

use super::given::GivenLaw;
use super::{PartLaw, SceneInterface, Source, friction};
use crate::Error;
use contact_laws::{AsperityLimit, ContactCurves, CurveFactors, PointParameters, Similarity};
use scenes::{Scene, Surface};
use zte_assembly::Variation;

/// Relative difference of ratios that are the same but for round-off.
const SAME: f64 = 1e-9;

/// Interferences at which curves are compared (m): over what rough faces of machined parts reach.
const COMPARED: [f64; 4] = [1e-8, 1e-7, 1e-6, 1e-5];

impl SceneInterface {
    /// The change per unit of a parameter, from two scenes whose values of it are `apart` from one another, the larger one first. `None` if the
    /// law does not depend on it through factors of its curves and of its friction coefficients.
    ///
    /// # Errors
    /// As [`SceneInterface::try_new`].
    pub fn variation(&self, [above, below]: [&Scene; 2], apart: f64) -> Result<Option<Variation>, Error> {
        let mut points = Vec::with_capacity(self.operators.n_points());
        let mut gap = Vec::with_capacity(self.operators.n_points());
        for (_, part) in &self.parts {
            let of_part = |scene: &Scene| {
                part.source
                    .map_or_else(|| scene.clone(), |source| scene.of_interface(source))
            };
            let Some((similar, opening)) = part.variation([&of_part(above), &of_part(below)], apart)? else {
                return Ok(None);
            };
            points.extend(similar);
            gap.extend(opening);
        }
        if gap.iter().all(|gap| *gap == 0.0) {
            gap.clear();
        }
        Ok(self.interface.variation(&points, gap)?)
    }
}

/// Of each point of a part: the factors of its law, and the gap (m per unit).
type OfPoints = (Vec<Similarity>, Vec<f64>);

impl PartLaw {
    /// As [`SceneInterface::variation`].
    fn variation(&self, scenes: [&Scene; 2], apart: f64) -> Result<Option<OfPoints>, Error> {
        let [above, below] = scenes;
        if above.interfaces.law != below.interfaces.law {
            return Ok(None);
        }
        let found = match &self.from {
            Source::Asperities(built) => {
                let mut similar = Vec::with_capacity(built.asperities.populations.len());
                if above.interfaces.scale == below.interfaces.scale && above.model.material == below.model.material {
                    similar.resize(built.asperities.populations.len(), Similarity::default());
                } else {
                    let [high, low] = [above, below].map(|scene| built.asperities.varied(scene));
                    let (high, low) = (high?, low?);
                    let reading = above.interfaces.law.tangential;
                    let heights = above.interfaces.scale.asperity_height / below.interfaces.scale.asperity_height;
                    for (high, low) in high.sums(reading)?.iter().zip(&low.sums(reading)?) {
                        let density = (high.population().density() / low.population().density()).ln() / apart;
                        let factors = low.factors_to(high, heights);
                        similar.push(Similarity {
                            density,
                            ..Similarity::between(factors, apart)
                        });
                    }
                }
                let of_points = self.element_of.iter();
                let similar: Vec<Similarity> = of_points
                    .map(|&element| similar[built.asperities.of_element[element as usize] as usize])
                    .collect();
                let gaps = |scene: &Scene| {
                    let known = built.known_gap.iter().map(|gap| gap.max(0.0));
                    scene.interfaces.scale.gaps(known, &self.operators.positions)
                };
                let coefficients = |scene: &Scene| friction::coefficients(scene, &self.operators.positions);
                let mu = [coefficients(above)?, coefficients(below)?];
                let without_mu = above.interfaces.law.limit != AsperityLimit::Coulomb;
                let friction = |point: usize| match without_mu {
                    true => Some(0.0),
                    false => logarithmic(mu.each_ref().map(|mu| at(mu, point)), apart),
                };
                with_friction(similar, &friction).map(|similar| (similar, quotient(&gaps(above), &gaps(below), apart)))
            }
            Source::NumberOrText(_) => {
                let built = |scene: &Scene| match &scene.interfaces.surface {
                    Surface::Parameters(parameters) => {
                        let mu = friction::coefficients(scene, &self.operators.positions)?;
                        GivenLaw::try_new(scene, parameters, &self.element_of, &mu).map(Some)
                    }
                    _ => Ok(None),
                };
                let (Some(high), Some(low)) = (built(above)?, built(below)?) else {
                    return Ok(None);
                };
                let similar = (0..self.gap.len()).map(|point| {
                    let factors = factors_between(low.at(point), high.at(point))?;
                    Some(Similarity::between(factors, apart))
                });
                let similar = similar.collect::<Option<Vec<_>>>();
                let friction = |point: usize| {
                    let coefficient = |given: &GivenLaw| given.law.friction_coefficient(point);
                    logarithmic([coefficient(&high)?, coefficient(&low)?], apart)
                };
                let opening = quotient(&high.gap, &low.gap, apart);
                let pressing = quotient(&high.interference, &low.interference, apart);
                let opening = opening.iter().zip(pressing).map(|(gap, own)| gap - own).collect();
                similar
                    .and_then(|similar| with_friction(similar, &friction))
                    .map(|similar| (similar, opening))
            }
        };
        Ok(found)
    }
}

fn at(mu: &PointParameters<f64>, point: usize) -> f64 {
    *mu.at(point)
}

/// Logarithmic derivative from two values; none of a coefficient that is zero and changes.
fn logarithmic([above, below]: [f64; 2], apart: f64) -> Option<f64> {
    match (above == below, above > 0.0 && below > 0.0) {
        (true, _) => Some(0.0),
        (false, true) => Some((above / below).ln() / apart),
        (false, false) => None,
    }
}

fn with_friction(similar: Vec<Similarity>, of: &dyn Fn(usize) -> Option<f64>) -> Option<Vec<Similarity>> {
    let points = similar.into_iter().enumerate();
    let points = points.map(|(point, similar)| {
        Some(Similarity {
            friction: of(point)?,
            ..similar
        })
    });
    points.collect()
}

fn quotient(above: &[f64], below: &[f64], apart: f64) -> Vec<f64> {
    above.iter().zip(below).map(|(a, b)| (a - b) / apart).collect()
}

/// The factors from curves to others that differ from them by factors of their values alone; `None` if they differ otherwise.
fn factors_between(below: &dyn ContactCurves, above: &dyn ContactCurves) -> Option<CurveFactors> {
    let ratios = COMPARED.map(|u| {
        let (low, high) = (below.tangential(u), above.tangential(u));
        [
            above.normal(u).0 / below.normal(u).0,
            high[0].value / low[0].value,
            high[1].value / low[1].value,
        ]
    });
    // Curves that carry nothing somewhere tell nothing there.
    let one = |which: usize| {
        let mut known = ratios
            .iter()
            .map(|ratio| ratio[which])
            .filter(|ratio| ratio.is_finite());
        let first = known.next()?;
        known.all(|ratio| (ratio / first - 1.0).abs() <= SAME).then_some(first)
    };
    Some(CurveFactors {
        interference: 1.0,
        normal: one(0)?,
        tangential: [one(1)?, one(2)?],
    })
}
