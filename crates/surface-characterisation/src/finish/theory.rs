//! The fast route: the population that the characterisation finds of a pair, in expectation and without any surface.

use contact_laws::{AsperityPopulation, GapDistribution};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use std::f64::consts::LN_2;

use super::ensemble::PairFinish;
use super::error::FinishError;
use super::face::FaceFinish;
use super::sampled::{LinePeaks, Summits};
use crate::face::{AsperityCount, PackingHeight, packing_count};
use crate::options::Options;
use crate::pair::HeightCombination;
use crate::peaks::RadiusStatistic;
use crate::random::{NormalDeviates, mix, uniform};

/// Step of heights, in standard deviations of the rougher face, and of summits, in standard normal values.
const STEP: f64 = 0.05;
/// Range of the summits in standard normal values.
const SUMMITS: [f64; 2] = [-3.0, 6.5];

/// Expected asperities of a pair of faces over a patch.
///
/// Peaks of profiles come in clusters: about a summit of height `t` the lines of the grid cross a ridge that falls as a
/// parabola, so that `sqrt(t - z)` of them lie above `z`, but for a factor. With the summits as a Poisson process of intensity
/// `Lambda`, `N(z) = w(z) sum_i sqrt(t_i - z)` peaks lie above `z`, and `w` follows from the expected number of peaks, which is
/// known at any height.
#[derive(Debug, Clone)]
pub struct Theory {
    faces: [Face; 2],
    /// Area of the patch (m^2).
    area: f64,
    /// Pair radii along x and y (m), scaled alike so that their geometric mean is the effective radius.
    radii: [f64; 2],
    /// Median height of the tallest summit (m).
    tallest: f64,
    /// Heights above the lowest peaks of each face (m), descending by equal steps.
    heights: Vec<f64>,
}

/// One face over the patch.
#[derive(Debug, Clone)]
struct Face {
    finish: FaceFinish,
    /// Points of the patch.
    points: f64,
    lines: [LinePeaks; 2],
    summits: Summits,
    /// Height of the lowest line peak (m).
    datum: f64,
    /// Line peaks above each of the pair's heights, and what the sum over summits is multiplied with to give them.
    above: Vec<f64>,
    weight: Vec<f64>,
    options: Options,
    area: f64,
}

impl Face {
    fn new(finish: &FaceFinish, pair: &PairFinish, options: &Options) -> Self {
        let points = (pair.points[0] * pair.points[1]) as f64;
        let lines = [0, 1].map(|axis| LinePeaks::new(finish, axis, pair.step[axis]));
        let summits = Summits::new(finish, pair.step);
        let mut face = Self {
            finish: finish.clone(),
            points,
            lines,
            summits,
            datum: 0.0,
            above: Vec::new(),
            weight: Vec::new(),
            options: *options,
            area: pair.area(),
        };
        // Low peaks are far apart: each counts for itself.
        let (mut low, mut high) = (-12.0, 12.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if face.points * (face.peaks() - face.peaks_above(middle)) < LN_2 {
                low = middle;
            } else {
                high = middle;
            }
        }
        face.datum = finish.height(low);
        face
    }

    /// Peaks along x and y lines per point.
    fn peaks(&self) -> f64 {
        self.lines[0].share + self.lines[1].share
    }

    /// Those above a standard normal value.
    fn peaks_above(&self, y: f64) -> f64 {
        self.lines.iter().map(|line| line.share * line.above(y)).sum()
    }

    fn normal(&self, height: f64) -> f64 {
        self.finish.normal(height + self.datum)
    }

    /// Summits expected above a height over the datum.
    fn summits_above(&self, height: f64) -> f64 {
        self.points * self.summits.above(self.normal(height))
    }

    /// Height over the datum above which a number of summits is expected.
    fn top(&self, number: f64) -> f64 {
        self.finish.height(self.summits.level(self.points, number)) - self.datum
    }

    /// The same with the share of its cluster in the mean of those as tall: a summit of curvature c has `1/sqrt(c)` of a ridge
    /// above a height, along either axis, and curvatures at a height scatter. `deviate` is standard normal.
    fn drawn_top(&self, number: f64, deviate: f64) -> [f64; 2] {
        let y = self.summits.level(self.points, number);
        let [a, b] = self.lines.each_ref().map(LinePeaks::scatter);
        // Of the mean of two independent ridges; low summits scatter as those at one standard deviation.
        let width = 0.25 * (a + b).sqrt() / y.max(1.0);
        [
            self.finish.height(y) - self.datum,
            (width * (deviate - 0.5 * width)).exp(),
        ]
    }

    /// Highest minus lowest point where these numbers of summits are expected beyond each (m).
    fn total_roughness(&self, numbers: [f64; 2]) -> f64 {
        let [top, bottom] = numbers.map(|number| self.summits.level(self.points, number));
        self.finish.height(top) - self.finish.height(-bottom)
    }

    fn tabulate(&mut self, heights: &[f64]) {
        self.above = heights
            .iter()
            .map(|z| self.points * self.peaks_above(self.normal(*z)))
            .collect();
        // Heights of summits, and how many are expected about each.
        let bins = ((SUMMITS[1] - SUMMITS[0]) / STEP).round() as usize;
        let tops: Vec<[f64; 2]> = (0..bins)
            .map(|k| {
                let y = SUMMITS[0] + k as f64 * STEP;
                let number = self.points * (self.summits.above(y) - self.summits.above(y + STEP));
                [self.finish.height(y + 0.5 * STEP) - self.datum, number]
            })
            .collect();
        let of_summits = |z: f64| {
            tops.iter()
                .map(|[t, number]| number * (t - z).max(0.0).sqrt())
                .sum::<f64>()
        };
        self.weight = heights
            .iter()
            .zip(&self.above)
            .map(|(z, above)| {
                let sum = of_summits(*z);
                if sum > 0.0 { above / sum } else { 0.0 }
            })
            .collect();
    }

    /// Asperities on the patch by the chosen count.
    fn count(&self, total_roughness: f64, summits: f64) -> Result<f64, FinishError> {
        Ok(match self.options.count {
            AsperityCount::Summits => summits.max(1.0),
            AsperityCount::Packing => {
                let height = match self.options.packing_height {
                    PackingHeight::TotalRoughness => total_roughness,
                    PackingHeight::MeanPeak => self.mean_peak(),
                };
                let radius = [0, 1].map(|axis| 1.0 / self.lines[axis].curvature);
                packing_count(self.area, height, radius, self.options.packing_efficiency)?
            }
        })
    }

    /// Mean height of the line peaks above the lowest (m).
    fn mean_peak(&self) -> f64 {
        let step = STEP * self.finish.rms();
        let shares = (0..400).map(|k| self.peaks_above(self.normal((k as f64 + 0.5) * step)));
        step * shares.sum::<f64>() / self.peaks()
    }
}

impl Theory {
    /// Of a pair, for the readings of `options`.
    ///
    /// # Errors
    /// [`FinishError::Reading`] for readings without a theory: summed heights, and the mean of the radii, which has no
    /// finite variance.
    pub fn try_new(pair: &PairFinish, options: &Options) -> Result<Self, FinishError> {
        if options.heights == HeightCombination::Summed {
            return Err(FinishError::Reading {
                reading: "heights = \"summed\"",
            });
        }
        if options.radius == RadiusStatistic::Mean {
            return Err(FinishError::Reading {
                reading: "radius = \"mean\"",
            });
        }
        let [top, bottom] = &pair.faces;
        let (first, second) = rayon::join(
            || Face::new(top, pair, options),
            || (bottom != top).then(|| Face::new(bottom, pair, options)),
        );
        let second = second.unwrap_or_else(|| first.clone());
        let mut faces = [first, second];
        let curvature = [0, 1].map(|axis| faces.iter().map(|f| f.lines[axis].curvature).sum::<f64>());
        let (radius, effective) = options.pair_radius.of(curvature);
        let scale = effective / (radius[0] * radius[1]).sqrt();

        let largest = |of: &dyn Fn(&Face) -> f64| faces.iter().map(of).fold(0.0, f64::max);
        let rms = largest(&|f| f.finish.rms());
        // From above anything that is drawn to the lowest peaks.
        let first = largest(&|f| f.top(1e-3)) + 0.5 * rms;
        let step = STEP * rms;
        let number = (first / step).ceil() as usize + 1;
        let heights: Vec<f64> = (0..=number).map(|k| first - k as f64 * step).collect();
        let tallest = tallest(&faces, LN_2);
        faces.iter_mut().for_each(|face| face.tabulate(&heights));
        Ok(Self {
            area: pair.area(),
            radii: radius.map(|r| r * scale),
            tallest,
            faces,
            heights,
        })
    }

    /// Asperities per area (1/m^2).
    ///
    /// # Errors
    /// Those of [`packing_count`].
    pub fn asperity_density(&self) -> Result<f64, FinishError> {
        self.density([self.total_roughness(), self.summits()])
    }

    /// Pair radii along x and y (m), scaled alike so that their geometric mean is the effective radius.
    pub fn radii(&self) -> [f64; 2] {
        self.radii
    }

    /// Median total roughness of top and bottom face (m).
    pub fn total_roughness(&self) -> [f64; 2] {
        self.faces.each_ref().map(|f| f.total_roughness([LN_2; 2]))
    }

    /// Expected summits of top and bottom face in a patch.
    pub fn summits(&self) -> [f64; 2] {
        self.faces.each_ref().map(|f| f.points * f.summits.share())
    }

    /// Median height of the tallest summit of both faces, each above its lowest peak (m).
    pub fn contact_height(&self) -> f64 {
        self.tallest
    }

    fn density(&self, [total, summits]: [[f64; 2]; 2]) -> Result<f64, FinishError> {
        let mut count = 0.0;
        for (face, (total, summits)) in self.faces.iter().zip(total.into_iter().zip(summits)) {
            count += 0.5 * face.count(total, summits)?;
        }
        Ok(count / self.area)
    }

    /// The asperities of a typical patch: the `i`-th tallest summit of both faces where `i - 1 + ln 2` are expected above, the
    /// median of its height for the tallest one, and nearly so for all.
    ///
    /// # Errors
    /// The contact laws' own.
    pub fn population(&self) -> Result<AsperityPopulation, FinishError> {
        let all: f64 = self.summits().iter().sum();
        let mut tops = [Vec::new(), Vec::new()];
        let (mut arrival, mut height) = (LN_2, self.tallest);
        loop {
            // Of either face as their summits lie there.
            let there = self.faces.each_ref().map(|f| {
                let half = STEP * f.finish.rms();
                f.summits_above(height - half) - f.summits_above(height + half)
            });
            let sum: f64 = there.iter().sum();
            for (own, there) in tops.iter_mut().zip(there) {
                own.push([height, there / sum.max(f64::MIN_POSITIVE)]);
            }
            arrival += 1.0;
            if arrival >= all {
                break;
            }
            height = tallest(&self.faces, arrival);
        }
        self.with(&tops, self.tallest, self.asperity_density()?)
    }

    /// `realisations` populations as patches scatter: summits of both faces drawn from their Poisson processes, contact
    /// beginning at the tallest of them. Each depends on the seed and its number alone.
    ///
    /// # Errors
    /// The contact laws' own.
    pub fn realisations(&self, realisations: usize, seed: u64) -> Result<Vec<AsperityPopulation>, FinishError> {
        let drawn = |k: usize| {
            let mut rng = Pcg64::seed_from_u64(mix(seed, k as u64, 4));
            let mut normal = NormalDeviates::new(mix(seed, k as u64, 6));
            let mut exponential = || -uniform(&mut rng).ln();
            let (mut tops, mut total, mut summits) = (Vec::new(), [0.0; 2], [0.0; 2]);
            for (side, face) in self.faces.iter().enumerate() {
                let expected = face.points * face.summits.share();
                let lowest = exponential();
                let first = exponential();
                total[side] = face.total_roughness([first, lowest]);
                // Ordered arrivals: the summits from the tallest on.
                let (mut arrival, mut own) = (first, Vec::new());
                while arrival < expected {
                    own.push(face.drawn_top(arrival, normal.next()));
                    arrival += exponential();
                }
                if own.is_empty() {
                    own.push([face.top(expected), 1.0]);
                }
                summits[side] = own.len() as f64;
                tops.push(own);
            }
            let tallest = tops.iter().flatten().map(|[t, _]| *t).fold(f64::NEG_INFINITY, f64::max);
            self.with(&tops, tallest, self.density([total, summits])?)
        };
        let drawn: Vec<_> = (0..realisations).into_par_iter().map(drawn).collect();
        drawn.into_iter().collect()
    }

    /// The population of summits with weights on each face, contact beginning at `tallest`.
    fn with(&self, tops: &[Vec<[f64; 2]>], tallest: f64, density: f64) -> Result<AsperityPopulation, FinishError> {
        let (mut numbers, mut gaps) = (vec![0.0], vec![0.0]);
        let mut most: f64 = 0.0;
        for (k, &z) in self.heights.iter().enumerate() {
            if z >= tallest {
                continue;
            }
            let above = self.faces.iter().zip(tops).map(|(face, tops)| {
                let roots = tops.iter().map(|[t, number]| number * (t - z).max(0.0).sqrt());
                face.weight[k] * roots.sum::<f64>()
            });
            // Far below all summits the factor falls as the sum rises; no peak is lost there.
            most = most.max(above.sum());
            numbers.push(most);
            gaps.push(tallest - z);
        }
        let probabilities: Vec<f64> = numbers.iter().map(|n| n / most).collect();
        let gaps = GapDistribution::try_from_quantiles(&probabilities, &gaps)?;
        Ok(AsperityPopulation::try_new(gaps, density, self.radii)?)
    }
}

/// Height above the lowest peaks of each face above which a number of summits of both is expected.
fn tallest(faces: &[Face; 2], number: f64) -> f64 {
    let largest = |number: f64| faces.iter().map(|f| f.top(number)).fold(f64::NEG_INFINITY, f64::max);
    // One face alone reaches no higher than both, and both no higher than where each has half of the number.
    let (mut low, mut high) = (largest(number), largest(0.5 * number));
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if faces.iter().map(|f| f.summits_above(middle)).sum::<f64>() > number {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
