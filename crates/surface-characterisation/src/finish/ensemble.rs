//! Pairs of synthesised patches, characterised like scans.

use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::error::{FinishError, positive};
use super::face::FaceFinish;
use super::spectrum::Spectrum;
use super::synthesis::{LEAST_POINTS, MOST_POINTS, Synthesis};
use crate::bootstrap::Bootstrap;
use crate::characterise::{ElementSurface, characterise};
use crate::detrend::Detrend;
use crate::options::Options;
use crate::partition::ElementOutlines;
use crate::random::{draw, mix};

/// Grid steps in a correlation length, and in a cut-off wavelength, unless the step is given.
const STEPS_PER_LENGTH: f64 = 8.0;
const STEPS_PER_CUTOFF: f64 = 4.0;
/// Correlation lengths in a patch, unless its size is given.
const LEAST_LENGTHS: f64 = 8.0;
/// Correlation lengths in a patch whose size is given.
const FEWEST_LENGTHS: f64 = 4.0;

/// Which of `realisations` patches an element takes by lot: depends on the arguments alone. Zero of none.
pub fn patch_of_element(seed: u64, element: usize, realisations: usize) -> usize {
    draw(&mut Pcg64::seed_from_u64(mix(seed, element as u64, 5)), realisations)
}

/// Two faces, and the patch of them that stands for an interface element.
#[derive(Debug, Clone, PartialEq)]
pub struct PairFinish {
    /// Top and bottom face.
    pub(super) faces: [FaceFinish; 2],
    /// Grid steps along x and y (m).
    pub(super) step: [f64; 2],
    /// Points along x and y.
    pub(super) points: [usize; 2],
}

impl PairFinish {
    /// A pair on patches of sides `window` (m) at steps `step` (m), and in words what was assumed.
    ///
    /// Without a window a patch is a square of `area` (m^2), that of an element, or longer where that has fewer than 8 correlation
    /// lengths. Without a step there are 8 in a correlation length of the profiles along each axis and 4 in a cut-off
    /// wavelength, of the face with the finer detail.
    ///
    /// # Errors
    /// Lengths that are not positive, a correlation length below two steps, too few or too many points, a window of fewer than 4
    /// correlation lengths.
    pub fn try_new(
        faces: [FaceFinish; 2],
        step: Option<[f64; 2]>,
        window: Option<[f64; 2]>,
        area: f64,
    ) -> Result<(Self, Vec<String>), FinishError> {
        let mut assumed = Vec::new();
        let least = |of: &dyn Fn(&FaceFinish) -> f64| faces.iter().map(of).fold(f64::INFINITY, f64::min);
        let wanted = match window {
            Some(window) => window,
            None => {
                let side = positive("area of an element", area, "m^2")?.sqrt();
                let longest = [0, 1].map(|k| faces.iter().map(|f| f.spectrum().extent()[k]).fold(0.0, f64::max));
                let window = longest.map(|l| side.max(LEAST_LENGTHS * l));
                assumed.push(if window == [side; 2] {
                    format!("window {side:.3e} m squared, the mean area of an interface element")
                } else {
                    format!(
                        "window {:.3e} m x {:.3e} m, {LEAST_LENGTHS} correlation lengths: an interface element ({side:.3e} m \
                         squared) has fewer",
                        window[0], window[1]
                    )
                });
                window
            }
        };
        for side in wanted {
            positive("window", side, "m")?;
        }
        let step = match step {
            Some(step) => step,
            None => {
                let step = [0, 1].map(|k| {
                    let steps = |face: &FaceFinish| {
                        let finest = face.spectrum().profile_lengths()[k];
                        finest
                            / match face.spectrum() {
                                Spectrum::Gaussian { .. } => STEPS_PER_LENGTH,
                                Spectrum::PowerLaw { .. } => STEPS_PER_CUTOFF,
                            }
                    };
                    least(&steps).min(wanted[k] / LEAST_POINTS as f64)
                });
                assumed.push(format!(
                    "grid steps {:.3e} m along x, {:.3e} m along y: {STEPS_PER_LENGTH} in a correlation length, \
                     {STEPS_PER_CUTOFF} in a cut-off wavelength; peaks are counted on this grid",
                    step[0], step[1]
                ));
                step
            }
        };
        let mut points = [0; 2];
        for k in 0..2 {
            let axis = ["x", "y"][k];
            positive("step", step[k], "m")?;
            let length = least(&|face: &FaceFinish| face.spectrum().profile_lengths()[k]);
            if length < 2.0 * step[k] {
                return Err(FinishError::Unresolved {
                    length,
                    axis,
                    step: step[k],
                });
            }
            let count = (wanted[k] / step[k]).round();
            if !(count >= LEAST_POINTS as f64 && count <= MOST_POINTS as f64) {
                return Err(FinishError::Points {
                    window: wanted[k],
                    axis,
                    step: step[k],
                    points: count,
                    least: LEAST_POINTS,
                    most: MOST_POINTS,
                });
            }
            let longest = faces.iter().map(|f| f.spectrum().extent()[k]).fold(0.0, f64::max);
            if wanted[k] < FEWEST_LENGTHS * longest {
                return Err(FinishError::Value {
                    field: "window",
                    value: wanted[k],
                    unit: "m",
                    requirement: "at least 4 correlation lengths, or 4/5 of a roll-off wavelength: a patch holds several asperities",
                });
            }
            points[k] = count as usize;
        }
        Ok((Self { faces, step, points }, assumed))
    }

    /// Top and bottom face.
    pub fn faces(&self) -> &[FaceFinish; 2] {
        &self.faces
    }

    /// Grid steps along x and y (m).
    pub fn step(&self) -> [f64; 2] {
        self.step
    }

    /// Sides of a patch along x and y (m): a whole number of steps.
    pub fn window(&self) -> [f64; 2] {
        [0, 1].map(|k| self.points[k] as f64 * self.step[k])
    }

    /// Area of a patch (m^2).
    pub fn area(&self) -> f64 {
        let [x, y] = self.window();
        x * y
    }

    /// `realisations` independent pairs of patches as elements, by the characterisation that scans go through; `options` give
    /// material, readings and interferences. Each depends on the pair, the options, the seed and its number alone.
    ///
    /// # Errors
    /// Those of [`Synthesis`] and [`characterise`].
    pub fn characterised(
        &self,
        realisations: usize,
        seed: u64,
        options: &Options,
    ) -> Result<Vec<ElementSurface>, FinishError> {
        let [top, bottom] = [0, 1].map(|side| Synthesis::try_new(&self.faces[side], self.step, self.points));
        let (top, bottom) = (top?, bottom?);
        let [x, y] = self.window();
        let outline = ElementOutlines::try_new(vec![[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]], vec![vec![0, 1, 2, 3]])?;
        // A transform makes two patches of a face: two realisations at a time, whose maps are dropped once characterised.
        let two = |k: usize| {
            let tops = top.pair(mix(seed, k as u64, 0))?;
            let bottoms = bottom.pair(mix(seed, k as u64, 1))?;
            let number = |part: usize| 2 * k + part;
            let pairs = tops.iter().zip(&bottoms).enumerate();
            let found = pairs
                .filter(|(part, _)| number(*part) < realisations)
                .map(|(part, (top, bottom))| {
                    let options = Options {
                        detrend: Detrend::WholeFace,
                        bootstrap: Bootstrap {
                            realisations: 0,
                            seed: mix(seed, number(part) as u64, 2),
                            ..options.bootstrap
                        },
                        ..*options
                    };
                    let mut found = characterise(top, bottom, &outline, &options)?;
                    Ok(found.elements.swap_remove(0))
                });
            found.collect::<Result<Vec<_>, FinishError>>()
        };
        let found: Vec<_> = (0..realisations.div_ceil(2)).into_par_iter().map(two).collect();
        Ok(found.into_iter().collect::<Result<Vec<_>, _>>()?.concat())
    }
}
