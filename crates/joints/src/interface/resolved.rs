//! Laws with a history for every asperity.

use super::asperities::Asperities;
use super::pressures::{Count, Counting, Pressures};
use super::stiffness::{as_dyn, between, interference_at};
use crate::Error;
use contact_laws::friction::foundation::BEYOND_REACH;
use contact_laws::{
    Asperity, AsperityBins, AsperityFriction, AsperityPopulation, AsperitySumCurves, ContactCurves, Foundation,
    FoundationLaw, Growth, PointParameters, Radii, ResolvedLaw, TractionLaw,
};
use rayon::prelude::*;
use scenes::{Bins, Friction, RadialRule, Scene};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Interferences are expected up to that which carries so many times the mean pressure of the bolts.
const PRESSURE_REACH: f64 = 10.0;

/// Different places of the bins.
const PLACES: usize = 1024;

/// Places that errors are measured with, evenly spaced.
const MEASURED_PLACES: usize = 16;

/// Bins that errors are measured against.
const FINEST: usize = 1000;

/// Populations at which errors are measured, if there are more.
const MEASURED: usize = 8;

/// Springs of a law that the pressures at rest are found with.
const COUNT_BEFORE: usize = 128;

/// Interferences of a population that are known before others are found between them.
const KNOWN: usize = 64;

/// Springs about an interference at rest that are tried.
const COUNTS_ABOUT: [usize; 8] = [24, 32, 40, 48, 56, 64, 96, 128];

/// Amplitudes over gross slip from which the error of the dissipated energy counts.
const SMALLEST_AMPLITUDE: f64 = 0.1;

/// What is reported about a law with a history for every asperity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ResolvedReport {
    /// Most bins, or springs of a foundation, at a point.
    pub bins: usize,
    /// Largest interference that they were chosen for (m) (mean over the populations); asperities beyond are in two bins. Equally
    /// spaced bins reach to the largest gap, springs to this interference.
    pub reach: f64,
    /// Measured relative errors of elastic asperities in these bins: normal traction, tangential stiffness, dissipated energy. None of springs
    /// before the pressures under the bolt loads are known.
    pub bin_errors: Option<[f64; 3]>,
    /// Radii of an asperity; none where it slips as a whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radii: Option<usize>,
    /// Interference at the onset of yield (m) (mean over the populations); none for elastic asperities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub onset_of_yield: Option<f64>,
}

/// One population and what stands for it at points.
struct Source<'a> {
    asperity: Asperity,
    population: &'a AsperityPopulation,
    curves: &'a dyn ContactCurves,
    reach: f64,
}

/// What stands for a population at a point.
trait Parts: Clone + Send + Sync {
    /// Numbers that are tried.
    const COUNTS: &'static [usize];

    /// `count` parts, with shifted limits.
    fn gauss(source: &Source<'_>, count: usize, shifts: &[f64]) -> Result<Vec<Self>, Error>;

    /// `count` parts at equally spaced gaps, where there is such a rule.
    fn equally_spaced(source: &Source<'_>, count: usize) -> Result<Self, Error>;

    /// Errors of several against many parts.
    fn errors(sets: &[Self], reference: &Self, reach: f64) -> [f64; 3];

    fn len(&self) -> usize;
}

impl Parts for AsperityBins {
    const COUNTS: &'static [usize] = &[4, 6, 8, 10, 12, 16, 24, 32, 48, 64, 96, 128];

    fn gauss(source: &Source<'_>, count: usize, shifts: &[f64]) -> Result<Vec<Self>, Error> {
        Ok(Self::gauss(
            source.asperity,
            source.population,
            count,
            source.reach,
            shifts,
        )?)
    }

    fn equally_spaced(source: &Source<'_>, count: usize) -> Result<Self, Error> {
        Ok(Self::equally_spaced(source.asperity, source.population, count)?)
    }

    fn errors(sets: &[Self], reference: &Self, reach: f64) -> [f64; 3] {
        Self::errors(sets, reference, reach, SMALLEST_AMPLITUDE)
    }

    fn len(&self) -> usize {
        self.len()
    }
}

impl Parts for Foundation {
    /// Of springs that are evenly spaced alone.
    const COUNTS: &'static [usize] = &[];

    fn gauss(source: &Source<'_>, count: usize, shifts: &[f64]) -> Result<Vec<Self>, Error> {
        Ok(source.growth()?.springs(count, shifts)?)
    }

    fn equally_spaced(source: &Source<'_>, count: usize) -> Result<Self, Error> {
        let Source {
            asperity,
            curves,
            reach,
            ..
        } = source;
        let spacing = reach / count as f64;
        let at = |j: usize| (j as f64 + 0.5) * spacing;
        let slope = |u: f64| if u > 0.0 { curves.normal(u).1 } else { 0.0 };
        let grows = |j: usize| slope(at(j) + 0.5 * spacing) - slope(at(j) - 0.5 * spacing);
        let (gaps, stiffnesses) = (0..count).map(|j| (at(j), grows(j))).unzip();
        Ok(Self::try_new(gaps, stiffnesses, asperity.material().mindlin_ratio())?)
    }

    fn errors(sets: &[Self], reference: &Self, reach: f64) -> [f64; 3] {
        Self::errors(sets, reference, reach, SMALLEST_AMPLITUDE)
    }

    fn len(&self) -> usize {
        self.gaps().len()
    }
}

impl Source<'_> {
    fn growth(&self) -> Result<Growth, Error> {
        let ratio = self.asperity.material().mindlin_ratio();
        Ok(Growth::of_curves(
            self.curves,
            ratio,
            self.reach,
            BEYOND_REACH * self.reach,
        )?)
    }

    /// Parts at the places with these numbers.
    fn parts<P: Parts>(&self, bins: Bins, count: usize, places: &[usize]) -> Result<Vec<P>, Error> {
        Ok(match bins {
            Bins::EquallySpaced(n) => vec![P::equally_spaced(self, n)?; places.len()],
            Bins::Error(_) | Bins::Gauss(_) => {
                let shifts: Vec<f64> = places.iter().map(|&place| place as f64 / PLACES as f64).collect();
                P::gauss(self, count, &shifts)?
            }
        })
    }

    /// Errors of parts against others of the same population.
    fn errors<P: Parts>(&self, bins: Bins, count: usize, reference: &P) -> Result<[f64; 3], Error> {
        let places: Vec<usize> = (0..PLACES).step_by(PLACES / MEASURED_PLACES).collect();
        Ok(P::errors(&self.parts(bins, count, &places)?, reference, self.reach))
    }
}

/// Interferences of a population by its pressure.
struct Inverse(Vec<[f64; 2]>);

impl Inverse {
    /// Up to four times the reach.
    fn of(source: &Source<'_>) -> Self {
        let at = (0..=KNOWN).map(|i| BEYOND_REACH * source.reach * (i as f64 / KNOWN as f64).powi(2));
        Self(at.map(|u| [u, source.curves.normal(u).0]).collect())
    }

    /// The interference at a pressure (Pa), within 1e-6 of the reach; at most the largest that is known.
    fn at(&self, curves: &dyn ContactCurves, pressure: f64) -> f64 {
        let above = self.0.partition_point(|[_, known]| *known < pressure);
        let (Some([low, _]), Some([high, _])) = (self.0.get(above.saturating_sub(1)), self.0.get(above)) else {
            return self.0[KNOWN][0];
        };
        let [low, high] = between(curves, pressure, [*low, *high], 18);
        0.5 * (low + high)
    }
}

impl Asperities {
    /// The law of all points, from the pressures of the bolts.
    pub(super) fn resolved_law(
        &self,
        scene: &Scene,
        element_of: &[u32],
        mu: &PointParameters<f64>,
        sums: &[AsperitySumCurves],
        pressures: Pressures<'_>,
    ) -> Result<(Arc<dyn TractionLaw>, ResolvedReport), Error> {
        let law = &scene.interfaces.law;
        let yielding = law.yielding();
        let pressed = self.pressed_curves(scene)?;
        let curves = pressed.as_deref().map_or_else(|| as_dyn(sums), as_dyn);
        let sources = self.populations.iter().zip(curves).map(|(population, curves)| {
            Ok(Source {
                asperity: Asperity::try_new(self.material, population.effective_radius(), yielding)?,
                population,
                curves,
                reach: interference_at(curves, PRESSURE_REACH * pressures.mean),
            })
        });
        let sources = sources.collect::<Result<Vec<_>, Error>>()?;
        // Curves by boundary elements follow from more than their populations.
        let counted = |are_springs: bool, found: &dyn Fn() -> Result<Count, Error>| match &pressed {
            Some(_) => found(),
            None => {
                let of = measured(&sources).map(|source| (source.asperity, source.population.clone(), source.reach));
                let counting = Counting {
                    of: of.collect(),
                    reading: law.tangential,
                    bins: law.bins,
                    are_springs,
                };
                pressures.counted.or(counting, found)
            }
        };
        let mean = |of: &dyn Fn(&Source<'_>) -> f64| sources.iter().map(of).sum::<f64>() / sources.len() as f64;
        let (friction, radii) = match (law.friction(), law.radii) {
            (Friction::Foundation, _) => (None, None),
            (Friction::Lumped | Friction::Resolved, _) => (Some(AsperityFriction::StickSlip(law.history)), None),
            (Friction::MindlinIwan, RadialRule::Annuli(n)) => (Some(AsperityFriction::Annuli(law.history, n)), Some(n)),
            (Friction::MindlinIwan, RadialRule::EquallySpaced(n)) => {
                (Some(AsperityFriction::MindlinIwan(Radii::equally_spaced(n)?)), Some(n))
            }
        };
        let report = |bins, bin_errors: Option<[f64; 3]>| ResolvedReport {
            bins,
            reach: mean(&|source| source.reach),
            bin_errors,
            radii,
            onset_of_yield: yielding.map(|_| mean(&|source| source.asperity.onset_of_yield())),
        };
        let Some(friction) = friction else {
            let (springs, bins, errors) = match (law.bins, pressures.at_rest) {
                (Bins::Error(_) | Bins::Gauss(_), Some(at_rest)) => {
                    let growths = sources.par_iter().map(Source::growth).collect::<Vec<_>>();
                    let growths = growths.into_iter().collect::<Result<Vec<_>, _>>()?;
                    let (count, errors) = counted(true, &|| count_about(&sources, &growths, law.bins))?;
                    let (springs, most) = self.springs_about(&sources, &growths, count, element_of, at_rest)?;
                    (springs, most, Some(errors))
                }
                (Bins::EquallySpaced(_), _) => {
                    let (count, errors) = counted(true, &|| count::<Foundation>(&sources, law.bins))?;
                    let (springs, most) = self.parts_of(&sources, law.bins, count, element_of)?;
                    (springs, most, Some(errors))
                }
                // A law that the pressures at rest are found with.
                (Bins::Error(_) | Bins::Gauss(_), None) => {
                    let (springs, count) =
                        self.parts_of::<Foundation>(&sources, Bins::Gauss(COUNT_BEFORE), COUNT_BEFORE, element_of)?;
                    (springs, count, None)
                }
            };
            let population_of = element_of.iter().map(|&e| self.of_element[e as usize]).collect();
            let mu = mu.clone();
            let law: Arc<dyn TractionLaw> = match &pressed {
                None => {
                    let curves = PointParameters::try_indexed(sums.to_vec(), population_of)?;
                    Arc::new(FoundationLaw::try_new(springs, curves, mu)?)
                }
                Some(pressed) => {
                    let curves = PointParameters::try_indexed(pressed.clone(), population_of)?;
                    Arc::new(FoundationLaw::try_new(springs, curves, mu)?)
                }
            };
            return Ok((law, report(bins, errors)));
        };
        let (count, errors) = counted(false, &|| count::<AsperityBins>(&sources, law.bins))?;
        let (bins, most) = self.parts_of(&sources, law.bins, count, element_of)?;
        let law = ResolvedLaw::try_new(bins, mu.clone(), friction, law.cone)?.with_limit(law.limit)?;
        Ok((Arc::new(law), report(most, Some(errors))))
    }

    /// `count` springs of all points about their interferences at rest, from the pressures there (Pa), and most springs at a point.
    fn springs_about(
        &self,
        sources: &[Source<'_>],
        growths: &[Growth],
        count: usize,
        element_of: &[u32],
        at_rest: &[f64],
    ) -> Result<(PointParameters<Foundation>, usize), Error> {
        let places = places(element_of);
        let inverses: Vec<Inverse> = sources.par_iter().map(Inverse::of).collect();
        let springs = (0..element_of.len()).into_par_iter().map(|point| {
            let population = self.of_element[element_of[point] as usize] as usize;
            let rest = inverses[population].at(sources[population].curves, at_rest[point]);
            growths[population].springs_about(rest, count, places[point] as f64 / PLACES as f64)
        });
        let springs = springs.collect::<Vec<_>>().into_iter().collect::<Result<Vec<_>, _>>()?;
        let most = springs.iter().map(Parts::len).max().unwrap_or(0);
        let own = (0..springs.len() as u32).collect();
        Ok((PointParameters::try_indexed(springs, own)?, most))
    }

    /// `count` parts of each population at all points, and most parts at a point.
    fn parts_of<P: Parts>(
        &self,
        sources: &[Source<'_>],
        bins: Bins,
        count: usize,
        element_of: &[u32],
    ) -> Result<(PointParameters<P>, usize), Error> {
        // The sets that points need: a population, and a place of its parts.
        let places = match bins {
            Bins::EquallySpaced(_) => vec![0; element_of.len()],
            Bins::Error(_) | Bins::Gauss(_) => places(element_of),
        };
        let key = |(place, &element): (usize, &u32)| (self.of_element[element as usize], place);
        let keys: Vec<(u32, usize)> = places.into_iter().zip(element_of).map(key).collect();
        let mut needed: BTreeMap<u32, BTreeMap<usize, u32>> = BTreeMap::new();
        for &(population, place) in &keys {
            needed.entry(population).or_default().insert(place, 0);
        }
        let made = needed.par_iter().map(|(&population, places)| {
            let places: Vec<usize> = places.keys().copied().collect();
            sources[population as usize].parts(bins, count, &places)
        });
        let made = made.collect::<Vec<_>>().into_iter().collect::<Result<Vec<_>, _>>()?;
        let numbers = needed.values_mut().flat_map(BTreeMap::values_mut);
        numbers.zip(0..).for_each(|(number, next)| *number = next);
        let sets: Vec<P> = made.into_iter().flatten().collect();
        let index = keys
            .iter()
            .map(|(population, place)| needed[population][place])
            .collect();
        let most = sets.iter().map(P::len).max().unwrap_or(0);
        Ok((PointParameters::try_indexed(sets, index)?, most))
    }
}

/// The places of the bins at all points, those of an element one after the other.
fn places(element_of: &[u32]) -> Vec<usize> {
    let mut first = 0;
    let of_point = |(point, &element): (usize, &u32)| {
        if element != element_of[first] {
            first = point;
        }
        place(element, point - first)
    };
    element_of.iter().enumerate().map(of_point).collect()
}

/// The place of the bins at a point of an element. Golden sections spread the points of an element; elements are independent of each other, so that
/// no regular mesh can fall in step with the bins.
fn place(element: u32, point: usize) -> usize {
    // SplitMix64, Steele, Lea and Flood 2014, DOI 10.1145/2714064.2660195.
    let mut z = (u64::from(element) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let offset = (z ^ (z >> 31)) as f64 / 2f64.powi(64);
    let shift = (offset + point as f64 * 0.618_033_988_749_895).fract();
    (shift * PLACES as f64) as usize
}

/// The populations that errors are measured at, and what belongs to them.
fn measured<T>(of_all: &[T]) -> impl Iterator<Item = &T> {
    of_all.iter().step_by(of_all.len().div_ceil(MEASURED).max(1))
}

/// Gauss parts per point, and the errors measured with them.
fn count<P: Parts>(sources: &[Source<'_>], bins: Bins) -> Result<Count, Error> {
    let mut with_finest = Vec::with_capacity(MEASURED);
    for source in measured(sources) {
        let finest = P::gauss(source, FINEST, &[0.0])?;
        with_finest.extend(finest.into_iter().map(|finest| (source, finest)));
    }
    let errors = |count: usize| {
        let of_each = with_finest
            .par_iter()
            .map(|(source, finest)| source.errors(bins, count, finest));
        largest(of_each.collect::<Vec<_>>())
    };
    fewest(bins, P::COUNTS, errors)
}

/// Springs per point about its interference at rest, and the errors measured with them.
fn count_about(sources: &[Source<'_>], growths: &[Growth], bins: Bins) -> Result<Count, Error> {
    let measured: Vec<_> = measured(sources).zip(measured(growths)).collect();
    let shifts = (0..MEASURED_PLACES).map(|place| place as f64 / MEASURED_PLACES as f64);
    let shifts: Vec<f64> = shifts.collect();
    let finest = measured
        .par_iter()
        .map(|(_, growth)| Ok(growth.springs(FINEST, &[0.0])?.remove(0)));
    let finest = finest
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Result<Vec<_>, Error>>()?;
    let errors = |count: usize| -> Result<[f64; 3], Error> {
        let of_one = |((source, growth), finest): (&(&Source<'_>, &Growth), &Foundation)| -> Result<[f64; 3], Error> {
            let rests = (0..MEASURED).map(|i| source.reach * (1.0 + 2.0 * i as f64 / (MEASURED - 1) as f64) / 3.0);
            let sets = rests.map(|rest| {
                let springs = shifts.iter().map(|&shift| growth.springs_about(rest, count, shift));
                Ok((rest, springs.collect::<Result<Vec<_>, _>>()?))
            });
            let sets = sets.collect::<Result<Vec<_>, Error>>()?;
            Ok(Foundation::errors_about(
                &sets,
                finest,
                source.reach,
                SMALLEST_AMPLITUDE,
            ))
        };
        largest(measured.par_iter().zip(&finest).map(of_one).collect::<Vec<_>>())
    };
    fewest(bins, &COUNTS_ABOUT, errors)
}

/// The largest of each error.
fn largest(all: Vec<Result<[f64; 3], Error>>) -> Result<[f64; 3], Error> {
    let all = all.into_iter().collect::<Result<Vec<_>, _>>()?;
    Ok([0, 1, 2].map(|q| all.iter().map(|errors| errors[q]).fold(0.0, f64::max)))
}

/// The number that is given, or the fewest parts whose errors are borne; with their errors.
fn fewest(bins: Bins, counts: &[usize], errors: impl Fn(usize) -> Result<[f64; 3], Error>) -> Result<Count, Error> {
    match bins {
        Bins::Gauss(n) | Bins::EquallySpaced(n) => Ok((n, errors(n)?)),
        Bins::Error(target) => {
            let mut best = f64::INFINITY;
            for &count in counts {
                let found = errors(count)?;
                let worst = found.into_iter().fold(0.0, f64::max);
                if worst <= target {
                    return Ok((count, found));
                }
                best = best.min(worst);
            }
            Err(Error::Bins { target, reached: best })
        }
    }
}
