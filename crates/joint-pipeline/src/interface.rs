//! From a scene's surface and law to the interface, and the adapter that lets the solver see it.

use crate::Error;
use crate::parameters::GivenLaw;
use crate::scene::{Gap, LawKind, Scene, Surface, Symmetry};
use crate::surface::{FileReport, ScannedSurface, U_REF, material};
use brake_reuss_beam::published;
use contact_laws::{
    AsperityPopulation, AsperitySumCurves, ContactCurves, ElasticPair, FittedCurves, FittedPoints, FrictionalLaw,
    GapDistribution, PointCurves, PointParameters, Sticking, TableOptions, Tabulated, TangentialEnds,
    TangentialReading, TractionLaw,
};
use cqsma_solver::{HystereticForce, Pattern, PointCounts, Sliding};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Arc;
use surface_characterisation::{
    Characterisation, ElementSurface, InterferenceRange, NormalFitReport, PairAsperities, TangentialFitReport,
    fit_normal, fit_tangential,
};
use zte_assembly::{Interface, InterfaceMesh, Operators, State, Workspace};

/// Interferences over which fits are made and compared (m).
const FIT_RANGE: InterferenceRange = InterferenceRange {
    from: 0.3e-6,
    to: 20e-6,
    points: 200,
};

/// Interferences covered by tables (m); beyond them the curves continue as power laws.
const TABLE_RANGE: [f64; 2] = [1e-10, 1e-3];

/// What is reported about the law.
#[derive(Clone, Debug, Serialize)]
pub struct LawReport {
    /// `tabulated`, `fitted`, `asperity-sum` or `elastic`.
    pub kind: &'static str,
    /// History rule.
    pub history: contact_laws::HistoryRule,
    /// What follows from asperities; left out where the parameters of the law are given.
    #[serde(flatten)]
    pub asperities: Option<AsperityReport>,
    /// Uniform closure that carries the bolt load (m).
    pub mean_closure: f64,
    /// Mean pressure there (Pa).
    pub mean_pressure: f64,
    /// Mean normal stiffness of the law in use there (Pa/m).
    pub normal_stiffness: f64,
    /// Mean tangential stiffness of the law in use there (Pa/m).
    pub tangential_stiffness: f64,
}

/// What is reported about a law that follows from asperities.
#[derive(Clone, Debug, Serialize)]
pub struct AsperityReport {
    /// `mindlin` or `paper`.
    pub tangential: TangentialReading,
    /// Files that the surface was scanned from; left out if there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub scans: Vec<FileReport>,
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
}

/// Asperities of the interface: populations, and which one each element has.
pub(crate) struct Asperities {
    pub(crate) populations: Vec<AsperityPopulation>,
    pub(crate) of_element: Vec<u32>,
    pub(crate) material: ElasticPair,
    scan: Option<(Characterisation, Vec<FileReport>)>,
}

/// The interface of a scene.
pub struct SceneInterface {
    /// Ready for evaluation.
    pub interface: Interface,
    /// What is reported about its law.
    pub report: LawReport,
    /// Points whose gap came out negative and was set to zero.
    pub clipped_gaps: usize,
    /// Uniform closure `u_n` above the gap that carries the bolt load (m): the guess that prestress starts from.
    pub closure: f64,
    /// None where the parameters of the law are given.
    pub(crate) asperities: Option<Asperities>,
    operators: Arc<Operators>,
    element_of: Vec<u32>,
}

impl SceneInterface {
    /// Builds law and gap; `load` is the sum of the bolt loads (N).
    ///
    /// # Errors
    /// Of the law, the surface, the interface; [`Error::NoContact`].
    pub fn try_new(scene: &Scene, mesh: &InterfaceMesh, load: f64) -> Result<Self, Error> {
        let operators = Arc::new(operators(mesh, scene.model.symmetry, scene.points_per_direction)?);
        let n = operators.n_points();
        let element_of: Vec<u32> = operators
            .first_point
            .windows(2)
            .enumerate()
            .flat_map(|(e, r)| vec![e as u32; r[1] - r[0]])
            .collect();
        let law_of = |asperities: Asperities| -> Result<Source, Error> {
            let built = asperities.law(scene, &operators, &element_of)?;
            Ok(Source::Asperities(Box::new(built)))
        };
        let from = match &scene.surface {
            Surface::Measured => law_of(Asperities::measured(scene, mesh)?)?,
            Surface::SyntheticScan(_) | Surface::Scans(_) => law_of(Asperities::scanned(scene, mesh)?)?,
            Surface::Parameters(parameters) => Source::Given(GivenLaw::try_new(scene, parameters, &element_of)?),
        };
        let (law, kind, gap, clipped_gaps) = match &from {
            Source::Given(given) => (given.law.clone(), given.kind, given.gap.clone(), 0),
            Source::Asperities(built) => {
                let clipped = built.raw_gap.iter().filter(|g| **g < 0.0).count();
                let gap = built.raw_gap.iter().map(|g| g.max(0.0)).collect();
                (built.law.clone(), built.kind, gap, clipped)
            }
        };
        let interface = Interface::try_new(operators.clone(), vec![(0..n, law)], gap)?;
        let closure = uniform_closure(&interface, load)?;
        let flat = interface.with_gap(vec![0.0; n])?;
        let mean_closure = uniform_closure(&flat, load)?;
        let (stiffness, asperity_report) = match &from {
            Source::Given(given) => {
                let of_curves = |p: usize| stiffnesses(given.at(p), mean_closure);
                (mean(&operators, of_curves), None)
            }
            Source::Asperities(built) => {
                let (stiffness, report) = built.describe(scene, &operators, &element_of, mean_closure)?;
                (stiffness, Some(report))
            }
        };
        let report = LawReport {
            kind,
            history: scene.law.history,
            asperities: asperity_report,
            mean_closure,
            mean_pressure: load / operators.area(),
            normal_stiffness: stiffness[0],
            tangential_stiffness: stiffness[1],
        };
        Ok(Self {
            interface,
            report,
            clipped_gaps,
            closure,
            asperities: match from {
                Source::Given(_) => None,
                Source::Asperities(built) => Some(built.asperities),
            },
            operators,
            element_of,
        })
    }

    /// The interface with the laws of bootstrap realisation `k` of all elements, and the closure as in
    /// [`SceneInterface::closure`]. Gaps are those of this interface; where a realisation lacks the tallest peak, contact
    /// begins at its own tallest, by so much later.
    ///
    /// # Errors
    /// [`Error::NoSamples`] unless the surface is scanned; else as [`SceneInterface::try_new`].
    pub fn realisation(&self, scene: &Scene, k: usize, load: f64) -> Result<(Interface, f64), Error> {
        let measured = self
            .asperities
            .as_ref()
            .and_then(|a| a.scan.as_ref().map(|scan| (a, scan)));
        let (asperities, (scan, _)) = measured.ok_or(Error::NoSamples)?;
        let drawn: Vec<_> = scan
            .realisation(k)?
            .iter()
            .map(PairAsperities::from_own_tallest)
            .collect();
        let populations = drawn.iter().map(|(pair, _)| population(scene, pair));
        let realisation = Asperities {
            populations: populations.collect::<Result<_, Error>>()?,
            of_element: asperities.of_element.clone(),
            material: asperities.material,
            scan: None,
        };
        let sums = realisation.sums(scene.law.tangential)?;
        let fits = match scene.law.kind {
            LawKind::Fitted => fits_of(&sums, scene.law.tangential, scan.options.interference)?,
            LawKind::Tabulated | LawKind::AsperitySum => Vec::new(),
        };
        let (_, law, _) = realisation.traction_law(scene, &self.element_of, &sums, &fits)?;
        let mut gap: Vec<f64> = self.element_of.iter().map(|&e| drawn[e as usize].1).collect();
        for (gap, own) in gap.iter_mut().zip(self.interface.gap().unwrap_or_default()) {
            *gap += own;
        }
        let interface = Interface::try_new(self.operators.clone(), vec![(0..gap.len(), law)], gap)?;
        let closure = uniform_closure(&interface, load)?;
        Ok((interface, closure))
    }

    /// What the readers of the scans had to settle by convention, one sentence each.
    pub(crate) fn notes(&self) -> impl Iterator<Item = String> {
        let scans = self.report.asperities.iter().flat_map(|report| &report.scans);
        scans.flat_map(|file| file.notes.iter().map(|note| format!("{}: {note}", file.path.display())))
    }
}

/// Geometry and quadrature of the interface of which `mesh` is all or half.
pub(crate) fn operators(
    mesh: &InterfaceMesh,
    symmetry: Symmetry,
    points_per_direction: usize,
) -> Result<Operators, Error> {
    Ok(match symmetry {
        Symmetry::None => Operators::try_new(mesh, points_per_direction)?,
        Symmetry::Half => Operators::try_new_mirrored(mesh, points_per_direction)?,
    })
}

/// What the law follows from.
enum Source {
    Given(GivenLaw),
    Asperities(Box<BuiltLaw>),
}

/// Average over the area of values at the points.
fn mean(operators: &Operators, of: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
    let points = operators.weights.iter().enumerate();
    let sum = points.fold([0.0; 2], |sum, (p, w)| {
        let value = of(p);
        [sum[0] + w * value[0], sum[1] + w * value[1]]
    });
    sum.map(|sum| sum / operators.area())
}

/// Normal and mean tangential stiffness of curves at an interference.
fn stiffnesses(curves: &dyn ContactCurves, u: f64) -> [f64; 2] {
    let k = curves.tangential(u);
    [curves.normal(u).1, 0.5 * (k[0].value + k[1].value)]
}

/// Name of the kind, law, and largest relative errors (normal, tangential) of its tables.
type NamedLaw = (&'static str, Arc<dyn TractionLaw>, Option<[f64; 2]>);

/// A law that follows from asperities.
struct BuiltLaw {
    asperities: Asperities,
    law: Arc<dyn TractionLaw>,
    kind: &'static str,
    /// Gap at each point (m), negative values included.
    raw_gap: Vec<f64>,
    sums: Vec<AsperitySumCurves>,
    fits: Vec<Fit>,
    /// Largest relative errors of the tables, normal and tangential.
    table_errors: Option<[f64; 2]>,
}

impl Asperities {
    /// The measured statistics, the same everywhere.
    fn measured(scene: &Scene, mesh: &InterfaceMesh) -> Result<Self, Error> {
        let values = published::ASPERITY_GAP_QUANTILES;
        let last = (values.len() - 1) as f64;
        let probabilities: Vec<f64> = (0..values.len()).map(|i| i as f64 / last).collect();
        let radius = published::EFFECTIVE_RADIUS;
        let population = AsperityPopulation::try_new(
            GapDistribution::try_from_quantiles(&probabilities, &values)?,
            published::ASPERITIES_PER_AREA,
            [radius, radius],
        )?;
        Ok(Self {
            populations: vec![population],
            of_element: vec![0; mesh.elements.len()],
            material: material(scene),
            scan: None,
        })
    }

    /// Those of two scans, element by element.
    fn scanned(scene: &Scene, mesh: &InterfaceMesh) -> Result<Self, Error> {
        let ScannedSurface { found, files, .. } = ScannedSurface::try_new(scene, mesh)?;
        let populations = found.elements.iter().map(|e| population(scene, &e.population));
        Ok(Self {
            populations: populations.collect::<Result<_, Error>>()?,
            of_element: (0..mesh.elements.len() as u32).collect(),
            material: material(scene),
            scan: Some((found, files)),
        })
    }

    fn sums(&self, reading: TangentialReading) -> Result<Vec<AsperitySumCurves>, Error> {
        let curves = self
            .populations
            .iter()
            .map(|p| AsperitySumCurves::try_new(p.clone(), self.material, reading));
        Ok(curves.collect::<Result<_, _>>()?)
    }

    fn law(self, scene: &Scene, operators: &Operators, element_of: &[u32]) -> Result<BuiltLaw, Error> {
        let sums = self.sums(scene.law.tangential)?;
        let fits = match &self.scan {
            Some((scan, _)) => scan.elements.iter().map(Fit::of_element).collect::<Result<_, _>>()?,
            None => fits_of(&sums, scene.law.tangential, FIT_RANGE)?,
        };
        let (kind, law, table_errors) = self.traction_law(scene, element_of, &sums, &fits)?;
        Ok(BuiltLaw {
            raw_gap: self.gap(scene, operators, element_of),
            asperities: self,
            law,
            kind,
            sums,
            fits,
            table_errors,
        })
    }

    /// The law of the scene's kind from the sums or the fits of all populations.
    fn traction_law(
        &self,
        scene: &Scene,
        element_of: &[u32],
        sums: &[AsperitySumCurves],
        fits: &[Fit],
    ) -> Result<NamedLaw, Error> {
        let history = scene.law.history;
        let population_of: Vec<u32> = element_of.iter().map(|&e| self.of_element[e as usize]).collect();
        let mu = PointParameters::uniform(scene.mu, population_of.len());
        Ok(match scene.law.kind {
            LawKind::AsperitySum => {
                let curves = PointParameters::try_indexed(sums.to_vec(), population_of)?;
                ("asperity-sum", frictional(curves, mu, history)?, None)
            }
            LawKind::Fitted => {
                let fitted = fits.iter().map(|fit| fit.curves).collect();
                let curves = PointParameters::try_indexed(fitted, population_of)?;
                let points = FittedPoints::<f64>::new(&curves);
                ("fitted", frictional(points, mu, history)?, None)
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
                let tables = sums
                    .par_iter()
                    .map(|curves| Tabulated::try_new(curves.clone(), TABLE_RANGE, options))
                    .collect::<Result<Vec<_>, _>>()?;
                let worst =
                    |of: &dyn Fn(&Tabulated<AsperitySumCurves>) -> f64| tables.iter().map(of).fold(0.0, f64::max);
                let errors = [
                    worst(&Tabulated::max_relative_error_normal),
                    worst(&Tabulated::max_relative_error_tangential),
                ];
                let curves = PointParameters::try_indexed(tables, population_of)?;
                ("tabulated", frictional(curves, mu, history)?, Some(errors))
            }
        })
    }

    /// Gap per point (m).
    fn gap(&self, scene: &Scene, operators: &Operators, element_of: &[u32]) -> Vec<f64> {
        operators
            .positions
            .iter()
            .zip(element_of)
            .map(|(&[x, y], &element)| match (scene.gap, &self.scan) {
                (Gap::Measured, _) => published::mesoscale_gap(x, y),
                (Gap::Scan, Some((scan, _))) => scan.elements[element as usize].gap.at([x, y]),
                _ => 0.0,
            })
            .collect()
    }
}

impl BuiltLaw {
    /// Mean stiffnesses (Pa/m) at a closure, and the report.
    fn describe(
        &self,
        scene: &Scene,
        operators: &Operators,
        element_of: &[u32],
        closure: f64,
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
        let fitted = average(&|population| stiffnesses(&self.fits[population].curves, closure));
        let [paper, mindlin] = [reading(TangentialReading::Paper)?, reading(TangentialReading::Mindlin)?];
        let fits = &self.fits;
        let report = AsperityReport {
            tangential: scene.law.tangential,
            scans: asperities
                .scan
                .as_ref()
                .map_or_else(Vec::new, |(_, files)| files.clone()),
            n_populations: asperities.populations.len(),
            fit_rms_normal: median(fits.iter().map(|f| f.rms[0]).collect()),
            fit_rms_tangential: median(fits.iter().map(|f| f.rms[1]).collect()),
            fit_fallbacks: fits.iter().filter(|f| f.fallback).count(),
            table_error_normal: self.table_errors.map(|e| e[0]),
            table_error_tangential: self.table_errors.map(|e| e[1]),
            fitted_to_summed: fitted[1] / summed[1],
            paper_to_mindlin: paper[1] / mindlin[1],
        };
        let in_use = if scene.law.kind == LawKind::Fitted {
            fitted
        } else {
            summed
        };
        Ok((in_use, report))
    }
}

/// The population of a pair of faces as the scene's law takes it. A sum over single samples has a kink of square-root type
/// at every one of them, which no table follows: tables take the heights interpolated.
fn population(scene: &Scene, pair: &PairAsperities) -> Result<AsperityPopulation, Error> {
    Ok(match scene.law.kind {
        LawKind::Tabulated => pair.interpolated_population()?,
        LawKind::Fitted | LawKind::AsperitySum => pair.law_population()?,
    })
}

/// Fits of eqs. (28) and (29) to sums over a range of interferences.
fn fits_of(
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

struct Fit {
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

fn frictional<C: PointCurves + 'static>(
    curves: C,
    mu: PointParameters<f64>,
    history: contact_laws::HistoryRule,
) -> Result<Arc<dyn TractionLaw>, Error> {
    Ok(Arc::new(FrictionalLaw::try_new(curves, mu, history)?))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 {
        f64::NAN
    } else {
        0.5 * (values[(n - 1) / 2] + values[n / 2])
    }
}

/// The rigid approach of the two faces at which the interface carries `load` (N); bisection on a rising function.
fn uniform_closure(interface: &Interface, load: f64) -> Result<f64, Error> {
    let state = interface.initial_state();
    let mut end = state.clone();
    let mut workspace = interface.workspace();
    let mut force = vec![0.0; interface.n_dofs()];
    let mut carried = |closure: f64| {
        let jump: Vec<f64> = (0..interface.n_dofs())
            .map(|i| if i % 3 == 2 { closure } else { 0.0 })
            .collect();
        interface.evaluate(
            &jump,
            Sticking::Coulomb,
            &state,
            &mut end,
            &mut workspace,
            &mut force,
            None,
        );
        force.iter().skip(2).step_by(3).sum::<f64>()
    };
    let smallest = interface
        .gap()
        .unwrap_or(&[0.0])
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    let (mut low, mut high) = (smallest, smallest + 1e-9);
    while carried(high) < load {
        low = high;
        high = smallest + 2.0 * (high - smallest);
        if high > smallest + 1.0 {
            return Err(Error::NoContact {
                load,
                closure: high,
                carried: carried(high),
            });
        }
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if carried(middle) < load {
            low = middle
        } else {
            high = middle
        }
    }
    Ok(0.5 * (low + high))
}

/// The interface as the solver sees it.
pub struct InterfaceForce<'a> {
    interface: &'a Interface,
    pattern: Pattern,
}

impl<'a> InterfaceForce<'a> {
    /// Wraps an interface.
    pub fn new(interface: &'a Interface) -> Self {
        let pattern = interface.pattern();
        Self {
            interface,
            pattern: Pattern {
                indptr: pattern.indptr.clone(),
                indices: pattern.indices.clone(),
            },
        }
    }

    /// The interface.
    pub fn interface(&self) -> &Interface {
        self.interface
    }
}

impl HystereticForce for InterfaceForce<'_> {
    type State = State;
    type Workspace = Workspace;

    fn n_dofs(&self) -> usize {
        self.interface.n_dofs()
    }

    fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    fn initial_state(&self) -> State {
        self.interface.initial_state()
    }

    fn workspace(&self) -> Workspace {
        self.interface.workspace()
    }

    fn dissipates(&self) -> bool {
        self.interface.dissipates()
    }

    fn evaluate(
        &self,
        u: &[f64],
        sliding: Sliding,
        begin: &State,
        end: &mut State,
        workspace: &mut Workspace,
        force: &mut [f64],
        tangent: Option<&mut [f64]>,
    ) -> PointCounts {
        let sticking = match sliding {
            Sliding::Allowed => Sticking::Coulomb,
            Sliding::Prevented => Sticking::Full,
        };
        let counts = self
            .interface
            .evaluate(u, sticking, begin, end, workspace, force, tangent);
        PointCounts {
            stick: counts.stick,
            slip: counts.slip,
            open: counts.open,
        }
    }
}
