//! Traction laws from asperities: sums, tables and fits, and what is reported about them.

use super::asperities::Asperities;
use super::finish::FinishReport;
use super::pressed::BoundaryElementsReport;
use super::pressures::Pressures;
use super::resolved::ResolvedReport;
use super::stiffness::{mean, stiffnesses};
use super::surface::{FileReport, U_REF};
use crate::Error;
use contact_laws::{
    AsperitySumCurves, ContactCurves, FittedCurves, FittedPoints, FrictionalLaw, PointCurves, PointParameters,
    TableOptions, Tabulated, TangentialEnds, TangentialReading, TractionLaw,
};
use rayon::prelude::*;
use scenes::{Friction, LawKind, Scene};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use surface_characterisation::{
    ElementSurface, InterferenceRange, NormalFitReport, TangentialFitReport, fit_normal, fit_tangential, median,
};
use zte_assembly::Operators;

/// Interferences over which fits are made and compared (m).
const FIT_RANGE: InterferenceRange = InterferenceRange {
    from: 0.3e-6,
    to: 20e-6,
    points: 200,
};

/// Interferences covered by tables (m); beyond them the curves continue as power laws.
const TABLE_RANGE: [f64; 2] = [1e-10, 1e-3];

/// What is reported about the law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LawReport {
    /// `tabulated`, `fitted`, `asperity-sum`, `boundary-elements` or `elastic`; with friction of parts of a point `foundation`, `resolved` or `mindlin-iwan`.
    pub kind: String,
    /// History rule.
    pub history: contact_laws::HistoryRule,
    /// What follows from asperities; left out where the parameters of the law are given.
    #[serde(flatten)]
    pub asperities: Option<AsperityReport>,
    /// About the bins of asperities with a history of their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolved: Option<ResolvedReport>,
    /// Uniform closure that carries the bolt load (m); without one the mean interference of the preload.
    pub mean_closure: f64,
    /// Mean pressure there (Pa), of the preload without bolt load.
    pub mean_pressure: f64,
    /// Mean normal stiffness of the law in use there (Pa/m).
    pub normal_stiffness: f64,
    /// Mean tangential stiffness of the law in use there (Pa/m).
    pub tangential_stiffness: f64,
}

/// What is reported about a law that follows from asperities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AsperityReport {
    /// `mindlin` or `paper`.
    pub tangential: TangentialReading,
    /// Files that the surface was scanned from; left out if there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scans: Vec<FileReport>,
    /// Faces by their roughness parameters: assumptions and the interval of the law; left out of others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finish: Option<Box<FinishReport>>,
    /// Different asperity populations.
    pub n_populations: usize,
    /// Median rms residual of the fits of eq. (28) to the sums, in ln.
    pub fit_rms_normal: f64,
    /// Median rms residual of the fits of eq. (29), in ln (worse of x and y).
    pub fit_rms_tangential: f64,
    /// Elements whose fit fell back to a simpler form.
    pub fit_fallbacks: usize,
    /// Largest relative error of the tables, normal traction; `null` unless tabulated.
    pub table_error_normal: Option<f64>,
    /// Largest relative error of the tables, tangential stiffness.
    pub table_error_tangential: Option<f64>,
    /// The fitted over the summed tangential stiffness there.
    pub fitted_to_summed: f64,
    /// The `paper` over the `mindlin` reading of the summed tangential stiffness there.
    pub paper_to_mindlin: f64,
    /// About boundary elements, where the law follows from them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boundary_elements: Option<BoundaryElementsReport>,
}

/// A law and what is reported about it.
pub(super) struct NamedLaw {
    pub(super) kind: &'static str,
    pub(super) law: Arc<dyn TractionLaw>,
    /// Largest relative errors of its tables, normal and tangential.
    pub(super) table_errors: Option<[f64; 2]>,
    pub(super) resolved: Option<ResolvedReport>,
}

impl NamedLaw {
    fn lumped(kind: &'static str, law: Arc<dyn TractionLaw>) -> Self {
        Self {
            kind,
            law,
            table_errors: None,
            resolved: None,
        }
    }
}

/// A law that follows from asperities.
pub(super) struct BuiltLaw {
    pub(super) asperities: Asperities,
    pub(super) law: Arc<dyn TractionLaw>,
    pub(super) kind: &'static str,
    /// Gap at each point as it is known (m), negative values included.
    pub(super) known_gap: Vec<f64>,
    sums: Vec<AsperitySumCurves>,
    /// Largest relative errors of the tables, normal and tangential.
    table_errors: Option<[f64; 2]>,
    pub(super) resolved: Option<ResolvedReport>,
}

impl Asperities {
    pub(super) fn law(
        self,
        scene: &Scene,
        operators: &Operators,
        element_of: &[u32],
        mu: &PointParameters<f64>,
        pressures: Pressures<'_>,
    ) -> Result<BuiltLaw, Error> {
        let sums = self.sums(scene.interfaces.law.tangential)?;
        let fits = || self.fits(scene.interfaces.law.tangential, &sums);
        let NamedLaw {
            kind,
            law,
            table_errors,
            resolved,
        } = self.traction_law(scene, element_of, mu, &sums, &fits, pressures)?;
        Ok(BuiltLaw {
            known_gap: self.gap(scene, operators, element_of),
            asperities: self,
            law,
            kind,
            sums,
            table_errors,
            resolved,
        })
    }

    /// Fits of eqs. (28) and (29): those of the scans, or to the sums, as the scene scales them.
    fn fits(&self, reading: TangentialReading, sums: &[AsperitySumCurves]) -> Result<Vec<Fit>, Error> {
        let known = self.known_sums(reading, sums)?;
        let range = self.finish.as_deref().map_or(FIT_RANGE, |(report, _)| report.range());
        let of_sums = |sums: &[AsperitySumCurves]| fits_of(sums, reading, range);
        let fits: Vec<Fit> = match (self.scan.as_deref(), &known) {
            (Some((scan, _)), _) => scan.elements.iter().map(Fit::of_element).collect::<Result<_, _>>()?,
            (None, None) => of_sums(sums)?,
            (None, Some(known)) => of_sums(&known.iter().map(|(sum, _)| sum.clone()).collect::<Vec<_>>())?,
        };
        let Some(known) = known else { return Ok(fits) };
        let scaled = fits.into_iter().zip(&known).map(|(fit, (_, factors))| {
            let curves = fit.curves.scaled(*factors)?;
            Ok(Fit { curves, ..fit })
        });
        scaled.collect()
    }

    /// The law of the scene's kind from the sums or the fits of all populations.
    pub(super) fn traction_law(
        &self,
        scene: &Scene,
        element_of: &[u32],
        mu: &PointParameters<f64>,
        sums: &[AsperitySumCurves],
        fits: &dyn Fn() -> Result<Vec<Fit>, Error>,
        pressures: Pressures<'_>,
    ) -> Result<NamedLaw, Error> {
        let kind = match scene.interfaces.law.friction() {
            Friction::Lumped => None,
            Friction::Foundation => Some("foundation"),
            Friction::Resolved => Some("resolved"),
            Friction::MindlinIwan => Some("mindlin-iwan"),
        };
        if let Some(kind) = kind {
            let (law, report) = self.resolved_law(scene, element_of, mu, sums, pressures)?;
            return Ok(NamedLaw {
                resolved: Some(report),
                ..NamedLaw::lumped(kind, law)
            });
        }
        let population_of: Vec<u32> = element_of.iter().map(|&e| self.of_element[e as usize]).collect();
        let mu = mu.clone();
        Ok(match scene.interfaces.law.kind {
            LawKind::BoundaryElements => {
                let curves = self.pressed_curves(scene)?.unwrap_or_default();
                let curves = PointParameters::try_indexed(curves, population_of)?;
                NamedLaw::lumped("boundary-elements", frictional(curves, mu, scene)?)
            }
            LawKind::AsperitySum => {
                let curves = PointParameters::try_indexed(sums.to_vec(), population_of)?;
                NamedLaw::lumped("asperity-sum", frictional(curves, mu, scene)?)
            }
            LawKind::Fitted => {
                let fitted = fits()?.iter().map(|fit| fit.curves).collect();
                let curves = PointParameters::try_indexed(fitted, population_of)?;
                let points = FittedPoints::<f64>::new(&curves);
                NamedLaw::lumped("fitted", frictional(points, mu, scene)?)
            }
            LawKind::Tabulated => {
                // Hundreds of tables: a coarser one each is still far below the scatter of the samples behind it.
                let options = if sums.len() > 1 {
                    TableOptions {
                        tolerance_normal: 1e-3,
                        tolerance_tangential: 1e-2,
                        ..TableOptions::default()
                    }
                } else {
                    TableOptions::default()
                };
                let table = |curves: &AsperitySumCurves| Tabulated::try_new(curves.clone(), TABLE_RANGE, options);
                let tables = match self.known_sums(scene.interfaces.law.tangential, sums)? {
                    None => sums.par_iter().map(table).collect::<Result<Vec<_>, _>>()?,
                    Some(known) => known
                        .par_iter()
                        .zip(sums)
                        .map(|((known, factors), scaled)| table(known)?.scaled(scaled.clone(), *factors))
                        .collect::<Result<Vec<_>, _>>()?,
                };
                let worst =
                    |of: &dyn Fn(&Tabulated<AsperitySumCurves>) -> f64| tables.iter().map(of).fold(0.0, f64::max);
                let errors = [
                    worst(&Tabulated::max_relative_error_normal),
                    worst(&Tabulated::max_relative_error_tangential),
                ];
                let curves = PointParameters::try_indexed(tables, population_of)?;
                NamedLaw {
                    table_errors: Some(errors),
                    ..NamedLaw::lumped("tabulated", frictional(curves, mu, scene)?)
                }
            }
        })
    }
}

impl BuiltLaw {
    /// The law of the same asperities for other pressures.
    pub(super) fn about(
        self,
        scene: &Scene,
        element_of: &[u32],
        mu: &PointParameters<f64>,
        pressures: Pressures<'_>,
    ) -> Result<Self, Error> {
        let of = &self.asperities;
        let fits = || of.fits(scene.interfaces.law.tangential, &self.sums);
        let NamedLaw { law, resolved, .. } = of.traction_law(scene, element_of, mu, &self.sums, &fits, pressures)?;
        Ok(Self { law, resolved, ..self })
    }

    /// Mean stiffnesses (Pa/m) at a closure, and the report.
    pub(super) fn describe(
        &self,
        scene: &Scene,
        operators: &Operators,
        element_of: &[u32],
        (closure, pressure): (f64, f64),
    ) -> Result<([f64; 2], AsperityReport), Error> {
        let asperities = &self.asperities;
        let average = |of: &dyn Fn(usize) -> [f64; 2]| {
            let values: Vec<[f64; 2]> = (0..self.sums.len()).map(of).collect();
            mean(operators, |p| {
                values[asperities.of_element[element_of[p] as usize] as usize]
            })
        };
        let reading = |reading| -> Result<[f64; 2], Error> {
            let sums = asperities.sums(reading)?;
            Ok(average(&|population| stiffnesses(&sums[population], closure)))
        };
        let summed = average(&|population| stiffnesses(&self.sums[population], closure));
        let curves = asperities.pressed_curves(scene)?;
        let pressed = curves
            .as_ref()
            .map(|curves| average(&|population| stiffnesses(&curves[population], closure)));
        let fits = asperities.fits(scene.interfaces.law.tangential, &self.sums)?;
        let fitted = average(&|population| stiffnesses(&fits[population].curves, closure));
        let [paper, mindlin] = [reading(TangentialReading::Paper)?, reading(TangentialReading::Mindlin)?];
        let report = AsperityReport {
            tangential: scene.interfaces.law.tangential,
            scans: asperities
                .scan
                .as_deref()
                .map_or_else(Vec::new, |(_, files)| files.clone()),
            finish: asperities.finish.as_deref().map(|(report, _)| Box::new(report.clone())),
            n_populations: asperities.populations.len(),
            fit_rms_normal: median(fits.iter().map(|f| f.rms[0]).collect()),
            fit_rms_tangential: median(fits.iter().map(|f| f.rms[1]).collect()),
            fit_fallbacks: fits.iter().filter(|f| f.fallback).count(),
            table_error_normal: self.table_errors.map(|e| e[0]),
            table_error_tangential: self.table_errors.map(|e| e[1]),
            fitted_to_summed: fitted[1] / summed[1],
            paper_to_mindlin: paper[1] / mindlin[1],
            boundary_elements: curves
                .zip(asperities.pressed.as_deref())
                .map(|(curves, pressed)| pressed.report(asperities.material, &self.sums, &curves, pressure)),
        };
        let in_use = match (scene.interfaces.law.kind, pressed) {
            (_, Some(pressed)) => pressed,
            (LawKind::Fitted, None) => fitted,
            _ => summed,
        };
        Ok((in_use, report))
    }
}

/// Fits of eqs. (28) and (29) to sums over a range of interferences.
pub(super) fn fits_of(
    sums: &[AsperitySumCurves],
    reading: TangentialReading,
    range: InterferenceRange,
) -> Result<Vec<Fit>, Error> {
    let u = range.samples()?;
    let ends = match reading {
        TangentialReading::Mindlin => TangentialEnds::Mindlin,
        TangentialReading::Paper => TangentialEnds::Constant,
    };
    let fits = sums.par_iter().map(|curves| {
        let t: Vec<f64> = u.iter().map(|&u| curves.normal(u).0).collect();
        let normal = fit_normal(&u, &t, U_REF)?;
        let tangential = [0, 1].map(|q| {
            let k: Vec<f64> = u.iter().map(|&u| curves.tangential(u)[q].value).collect();
            fit_tangential(&u, &k, U_REF, ends)
        });
        let [x, y] = tangential;
        Fit::try_new(&normal, &[x?, y?])
    });
    fits.collect::<Vec<_>>().into_iter().collect()
}

pub(super) struct Fit {
    curves: FittedCurves,
    rms: [f64; 2],
    fallback: bool,
}

impl Fit {
    fn of_element(element: &ElementSurface) -> Result<Self, Error> {
        Self::try_new(&element.normal, &element.tangential)
    }

    fn try_new(normal: &NormalFitReport, tangential: &[TangentialFitReport; 2]) -> Result<Self, Error> {
        let [x, y] = tangential;
        Ok(Self {
            curves: FittedCurves::try_new(normal.parameters, [x.parameters, y.parameters])?,
            rms: [normal.rms, x.rms.max(y.rms)],
            fallback: normal.fallback.is_some() || x.fallback.is_some() || y.fallback.is_some(),
        })
    }
}

/// The scene's friction on curves.
pub(super) fn frictional<C: PointCurves + 'static>(
    curves: C,
    mu: PointParameters<f64>,
    scene: &Scene,
) -> Result<Arc<dyn TractionLaw>, Error> {
    let law = FrictionalLaw::try_new(curves, mu, scene.interfaces.law.history)?;
    Ok(Arc::new(law.with_cone(scene.interfaces.law.cone)))
}
