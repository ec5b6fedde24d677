//! From two height maps to fitted laws per element, all steps in their order.

use contact_laws::{NormalFit, TangentialEnds, TangentialReading};
use rayon::prelude::*;

use crate::bootstrap::{CurveBands, bootstrap_bands, realisation};
use crate::error::{SurfaceError, not_negative, positive};
use crate::face::FaceAsperities;
use crate::fits::{FitFallback, FitReport, NormalFitReport, TangentialFitReport, fit_normal, fit_tangential};
use crate::gap::{Bilinear, pair_gap};
use crate::options::Options;
use crate::pair::{PairAsperities, PairOptions, combine};
use crate::partition::ElementOutlines;
use crate::registration::Registration;
use crate::response::{TractionCurves, check_material, traction_curves};
use crate::scan::{FaceSummary, scan_face};
use crate::statistics::median;
use crate::topography::HeightMap;

/// What is known of one interface element.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ElementSurface {
    /// Index of the element.
    pub element: usize,
    /// Top and bottom face.
    pub faces: [FaceAsperities; 2],
    /// Asperities of the pair. In the single-asperity fallback they all have one height.
    pub population: PairAsperities,
    /// Gap of the pair (m), measured where the tallest peaks would touch: where it is `g`, the law receives
    /// `u_n = jump_n - g`. A form tilted against its tallest peak can make it slightly negative.
    pub gap: Bilinear,
    /// Least and greatest gap at the corners (m).
    pub gap_range: [f64; 2],
    /// Traction curves of the whole sample, to which the fits are made.
    pub curves: TractionCurves,
    /// 95 % bands of the curves.
    pub bands: Option<CurveBands>,
    /// Fit of eq. (28).
    pub normal: NormalFitReport,
    /// Fits of eq. (29) along x and y.
    pub tangential: [TangentialFitReport; 2],
}

impl ElementSurface {
    /// Total roughness R_t of the pair, the mean of both faces' (m).
    pub fn total_roughness(&self) -> f64 {
        0.5 * (self.faces[0].total_roughness() + self.faces[1].total_roughness())
    }
}

/// A characterised pair of faces.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Characterisation {
    /// Every element, in the order given.
    pub elements: Vec<ElementSurface>,
    /// Top and bottom face.
    pub faces: [FaceSummary; 2],
    /// The readings and settings that gave all this.
    pub options: Options,
}

/// Counts and medians over the elements.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Summary {
    /// Number of elements.
    pub elements: usize,
    /// Elements in the single-asperity fallback.
    pub single_asperity: usize,
    /// Elements whose normal fit fell back to a power law.
    pub power_law: usize,
    /// Elements with a tangential fit that fell back to a constant.
    pub constant: usize,
    /// Median rms residual of the normal fits (ln).
    pub median_rms_normal: f64,
    /// Median rms residual of the tangential fits along x and y (ln).
    pub median_rms_tangential: [f64; 2],
    /// Least and greatest gap over all corners (m).
    pub gap_range: [f64; 2],
}

impl Characterisation {
    /// Bootstrap realisation `k` of every element's population, in their order.
    ///
    /// It is drawn by [`Options::bootstrap`] (its number of realisations aside: any `k` will do), so that realisation
    /// `k` of an element is the sample behind the `k`-th of the curves its bands were taken from. Gaps, counts and radii
    /// are not drawn: the law of a realisation starts where the measured one does. Depends on the heights, the seed,
    /// the element and `k` alone.
    ///
    /// # Errors
    /// An exponent of [`crate::TallestPeak::MOutOfN`] outside (0, 1).
    pub fn realisation(&self, k: usize) -> Result<Vec<PairAsperities>, SurfaceError> {
        self.elements
            .iter()
            .map(|e| realisation(&e.population, self.options.bootstrap, e.element, k))
            .collect()
    }

    /// Counts and medians over the elements; medians are NaN without elements.
    pub fn summary(&self) -> Summary {
        let all = &self.elements;
        let count = |of: &dyn Fn(&ElementSurface) -> bool| all.iter().filter(|e| of(e)).count();
        let median = |of: &dyn Fn(&ElementSurface) -> f64| median(all.iter().map(of).collect());
        Summary {
            elements: all.len(),
            single_asperity: count(&|e| e.normal.fallback == Some(FitFallback::SingleAsperity)),
            power_law: count(&|e| e.normal.fallback == Some(FitFallback::PowerLaw)),
            constant: count(&|e| e.tangential.iter().any(|t| t.fallback == Some(FitFallback::Constant))),
            median_rms_normal: median(&|e| e.normal.rms),
            median_rms_tangential: [0, 1].map(|q| median(&|e| e.tangential[q].rms)),
            gap_range: all
                .iter()
                .map(|e| e.gap_range)
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [l, h]| {
                    [low.min(l), high.max(h)]
                }),
        }
    }
}

/// Characterises a pair of faces over the elements of their interface.
///
/// Both maps are in the frame of the elements (a mating face scanned from its own side is mirrored first, see
/// [`HeightMap::mirrored_x`]), heights out of each body. Elements are worked on in parallel; the result does not
/// depend on the number of threads.
///
/// # Errors
/// Options outside their range, an undetermined trend plane, an element with too few points on a face, or without a
/// peak on either face.
pub fn characterise(
    top: &HeightMap,
    bottom: &HeightMap,
    elements: &ElementOutlines,
    options: &Options,
) -> Result<Characterisation, SurfaceError> {
    characterise_until(&|| false, top, bottom, elements, options)
}

/// As [`characterise`], unless `stop`, which is asked at each element from any thread, ends it.
///
/// # Errors
/// As [`characterise`]; [`SurfaceError::Interrupted`].
pub fn characterise_until(
    stop: &(dyn Fn() -> bool + Sync),
    top: &HeightMap,
    bottom: &HeightMap,
    elements: &ElementOutlines,
    options: &Options,
) -> Result<Characterisation, SurfaceError> {
    check_material(&options.material)?;
    positive("u_ref", options.u_ref, "m")?;
    positive("packing efficiency", options.packing_efficiency, "1")?;
    let interference = options.interference.samples()?;

    not_negative("pruning", options.pruning, "1")?;

    let (top, bottom) = rayon::join(
        || scan_face("top", top, elements, Registration::default(), options),
        || scan_face("bottom", bottom, elements, options.registration, options),
    );
    let (top_found, top) = top?;
    let (bottom_found, bottom) = bottom?;
    let reference = [top.reference, bottom.reference];
    let responses = top_found
        .into_par_iter()
        .zip(bottom_found)
        .enumerate()
        .map(|(e, (top, bottom))| match stop() {
            true => Err(SurfaceError::Interrupted),
            false => respond(e, elements, [top, bottom], reference, &interference, options),
        })
        .collect::<Vec<_>>();
    Ok(Characterisation {
        elements: responses.into_iter().collect::<Result<_, _>>()?,
        faces: [top, bottom],
        options: *options,
    })
}

fn respond(
    element: usize,
    elements: &ElementOutlines,
    faces: [FaceAsperities; 2],
    reference: [f64; 2],
    interference: &[f64],
    options: &Options,
) -> Result<ElementSurface, SurfaceError> {
    let pair = PairOptions {
        radius: options.pair_radius,
        heights: options.heights,
        seed: options.bootstrap.seed,
    };
    let sampled = combine(element, elements.area(element), [&faces[0], &faces[1]], pair)?;
    let single = sampled.heights().len() < options.least_peaks;
    let population = if single { sampled.uniform() } else { sampled };
    let Options {
        material,
        tangential: reading,
        u_ref,
        ..
    } = *options;

    let curves = traction_curves(&population, material, reading, interference)?;
    let bands = bootstrap_bands(&population, material, reading, interference, options.bootstrap, element)?;
    let ends = match reading {
        TangentialReading::Mindlin => TangentialEnds::Mindlin,
        TangentialReading::Paper => TangentialEnds::Constant,
    };
    let fit_stiffness = |q: usize| fit_tangential(interference, &curves.tangential[q], u_ref, ends);
    let along_x = fit_stiffness(0)?;
    let along_y = if curves.tangential[0] == curves.tangential[1] {
        along_x
    } else {
        fit_stiffness(1)?
    };
    let mut tangential = [along_x, along_y];
    let normal = if single {
        for fit in &mut tangential {
            fit.fallback = Some(FitFallback::SingleAsperity);
        }
        single_asperity(&curves, u_ref)
    } else {
        fit_normal(interference, &curves.normal, u_ref)?
    };

    let gap = pair_gap(
        [&faces[0].plane, &faces[1].plane],
        [faces[0].tallest, faces[1].tallest],
        reference,
    );
    let gap_range = gap.range(elements, element);
    Ok(ElementSurface {
        element,
        faces,
        population,
        gap,
        gap_range,
        curves,
        bands,
        normal,
        tangential,
    })
}

/// The closed form `t_n ~ u^(3/2)` as parameters of eq. (28), with its deviation from the curve it stands for.
fn single_asperity(curves: &TractionCurves, u_ref: f64) -> NormalFitReport {
    let (u, t) = (&curves.interference, &curves.normal);
    let last = u.len() - 1;
    let a = t[last].ln() - 1.5 * (u[last] / u_ref).ln();
    let residuals: Vec<f64> = u
        .iter()
        .zip(t)
        .map(|(u, t)| a + 1.5 * (u / u_ref).ln() - t.ln())
        .collect();
    FitReport {
        parameters: NormalFit {
            a,
            b: 1.5,
            c: 0.0,
            d: 0.0,
            e: 1.0,
            u_ref,
            t_ref: 1.0,
            range: Some([u[0], u[last]]),
        },
        rms: (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt(),
        max_residual: residuals.iter().fold(0.0, |m: f64, r| m.max(r.abs())),
        samples: u.len(),
        zero_samples: 0,
        fallback: Some(FitFallback::SingleAsperity),
    }
}
