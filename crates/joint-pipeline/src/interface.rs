//! From a scene's surface and law to the interface, and the adapter that lets the solver see it.

use crate::Error;
use crate::parameters::GivenLaw;
use crate::scene::{Gap, LawKind, Scene, Surface, SyntheticScan};
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
    Bootstrap, Characterisation, ElementOutlines, InterferenceRange, Options, SyntheticFace, Waviness, characterise,
    fit_normal, fit_tangential,
};
use zte_assembly::{Interface, InterfaceMesh, Operators, State, Workspace};

/// Interferences over which fits are made and compared (m).
const FIT_RANGE: InterferenceRange = InterferenceRange {
    from: 0.3e-6,
    to: 20e-6,
    points: 200,
};

/// Reference interference of the fits (m).
const U_REF: f64 = 1e-6;

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
    scan: Option<Characterisation>,
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
}

impl SceneInterface {
    /// Builds law and gap; `load` is the sum of the bolt loads (N).
    ///
    /// # Errors
    /// Of the law, the surface, the interface; [`Error::NoContact`].
    pub fn try_new(scene: &Scene, mesh: &InterfaceMesh, load: f64) -> Result<Self, Error> {
        let operators = Arc::new(Operators::try_new(mesh, scene.points_per_direction)?);
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
            Surface::SyntheticScan(scan) => law_of(Asperities::scanned(scene, scan, mesh)?)?,
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
        let interface = Interface::try_new(operators, vec![(0..n, law)], gap)?;
        let closure = uniform_closure(&interface, load)?;
        let flat = interface.with_gap(vec![0.0; n])?;
        let mean_closure = uniform_closure(&flat, load)?;
        let operators = flat.operators();
        let (stiffness, asperity_report) = match &from {
            Source::Given(given) => {
                let of_curves = |p: usize| stiffnesses(given.at(p), mean_closure);
                (mean(operators, of_curves), None)
            }
            Source::Asperities(built) => {
                let (stiffness, report) = built.describe(scene, operators, &element_of, mean_closure)?;
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
        })
    }
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

    /// Those of two synthetic scans, element by element.
    fn scanned(scene: &Scene, scan: &SyntheticScan, mesh: &InterfaceMesh) -> Result<Self, Error> {
        let outlines = ElementOutlines::try_new(
            mesh.nodes.clone(),
            mesh.elements.iter().map(|e| e.nodes().to_vec()).collect(),
        )?;
        let (top, bottom) = (face(scan, mesh, 0)?, face(scan, mesh, 1)?);
        let mut options = Options::new(material(scene));
        options.tangential = scene.law.tangential;
        options.u_ref = U_REF;
        options.bootstrap = Bootstrap {
            realisations: scan.bootstrap,
            seed: scan.seed,
            ..Bootstrap::default()
        };
        let found = characterise(&top, &bottom, &outlines, &options)?;
        let smooth = scene.law.kind == LawKind::Tabulated;
        let populations = found
            .elements
            .iter()
            .map(|element| {
                let population = element.population.law_population()?;
                if smooth {
                    interpolated(&population, element.population.heights())
                } else {
                    Ok(population)
                }
            })
            .collect::<Result<_, Error>>()?;
        Ok(Self {
            populations,
            of_element: (0..mesh.elements.len() as u32).collect(),
            material: material(scene),
            scan: Some(found),
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
        let law = &scene.law;
        let population_of: Vec<u32> = element_of.iter().map(|&e| self.of_element[e as usize]).collect();
        let sums = self.sums(law.tangential)?;
        let fits = self.fits(&sums, law.tangential)?;
        let mu = PointParameters::uniform(scene.mu, population_of.len());
        let mut table_errors = None;
        let (kind, law): (_, Arc<dyn TractionLaw>) = match law.kind {
            LawKind::AsperitySum => {
                let curves = PointParameters::try_indexed(sums.clone(), population_of)?;
                ("asperity-sum", frictional(curves, mu, law.history)?)
            }
            LawKind::Fitted => {
                let fitted = fits.iter().map(|fit| fit.curves).collect();
                let curves = PointParameters::try_indexed(fitted, population_of)?;
                (
                    "fitted",
                    frictional(FittedPoints::<f64>::new(&curves), mu, law.history)?,
                )
            }
            LawKind::Tabulated => {
                // Hundreds of tables: a coarser one each is still far below the scatter of the samples behind it.
                let options = if self.scan.is_some() {
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
                table_errors = Some([
                    worst(&Tabulated::max_relative_error_normal),
                    worst(&Tabulated::max_relative_error_tangential),
                ]);
                let curves = PointParameters::try_indexed(tables, population_of)?;
                ("tabulated", frictional(curves, mu, law.history)?)
            }
        };
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

    fn fits(&self, sums: &[AsperitySumCurves], reading: TangentialReading) -> Result<Vec<Fit>, Error> {
        if let Some(scan) = &self.scan {
            return scan
                .elements
                .iter()
                .map(|e| {
                    Ok(Fit {
                        curves: FittedCurves::try_new(
                            e.normal.parameters,
                            [e.tangential[0].parameters, e.tangential[1].parameters],
                        )?,
                        rms: [e.normal.rms, e.tangential[0].rms.max(e.tangential[1].rms)],
                        fallback: e.normal.fallback.is_some() || e.tangential.iter().any(|t| t.fallback.is_some()),
                    })
                })
                .collect();
        }
        let u = FIT_RANGE.samples()?;
        let ends = match reading {
            TangentialReading::Mindlin => TangentialEnds::Mindlin,
            TangentialReading::Paper => TangentialEnds::Constant,
        };
        sums.iter()
            .map(|curves| {
                let t: Vec<f64> = u.iter().map(|&u| curves.normal(u).0).collect();
                let normal = fit_normal(&u, &t, U_REF)?;
                let tangential = [0, 1].map(|q| {
                    let k: Vec<f64> = u.iter().map(|&u| curves.tangential(u)[q].value).collect();
                    fit_tangential(&u, &k, U_REF, ends)
                });
                let [x, y] = tangential;
                let (x, y) = (x?, y?);
                Ok(Fit {
                    curves: FittedCurves::try_new(normal.parameters, [x.parameters, y.parameters])?,
                    rms: [normal.rms, x.rms.max(y.rms)],
                    fallback: normal.fallback.is_some() || x.fallback.is_some() || y.fallback.is_some(),
                })
            })
            .collect()
    }

    /// Gap per point (m).
    fn gap(&self, scene: &Scene, operators: &Operators, element_of: &[u32]) -> Vec<f64> {
        operators
            .positions
            .iter()
            .zip(element_of)
            .map(|(&[x, y], &element)| match (scene.gap, &self.scan) {
                (Gap::Measured, _) => published::mesoscale_gap(x, y),
                (Gap::Scan, Some(scan)) => scan.elements[element as usize].gap.at([x, y]),
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

fn material(scene: &Scene) -> ElasticPair {
    ElasticPair {
        youngs_modulus: scene.model.material.youngs_modulus,
        poisson_ratio: scene.model.material.poisson_ratio,
    }
}

/// The population with its sample of heights (tallest first) interpolated linearly between the order statistics: a
/// sum over single samples has a kink of square-root type at every one of them, which no table follows.
fn interpolated(population: &AsperityPopulation, heights: &[f64]) -> Result<AsperityPopulation, Error> {
    if heights.len() < 2 {
        return Ok(population.clone());
    }
    let last = (heights.len() - 1) as f64;
    let probabilities: Vec<f64> = (0..heights.len()).map(|i| i as f64 / last).collect();
    let mut gaps: Vec<f64> = heights.iter().map(|z| heights[0] - z).collect();
    gaps.sort_by(f64::total_cmp);
    let distribution = GapDistribution::try_from_quantiles(&probabilities, &gaps)?;
    Ok(AsperityPopulation::try_new(
        distribution,
        population.density(),
        population.radii(),
    )?)
}

struct Fit {
    curves: FittedCurves,
    rms: [f64; 2],
    fallback: bool,
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

/// One face of the pair, over the bounding box of the interface; the bottom one has its own seed and waviness phase.
fn face(scan: &SyntheticScan, mesh: &InterfaceMesh, side: u64) -> Result<surface_characterisation::HeightMap, Error> {
    let bounds = |axis: usize| {
        mesh.nodes
            .iter()
            .map(|x| x[axis])
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
    };
    let (x, y) = (bounds(0), bounds(1));
    // A wrong step must end in an error of the generator, not in a request for all memory.
    let points = [(x, scan.step[0]), (y, scan.step[1])].map(|((low, high), step)| {
        let count = ((high - low) / step).floor() + 1.0;
        if count.is_finite() {
            count.clamp(0.0, 1e5) as usize
        } else {
            0
        }
    });
    let synthetic = SyntheticFace {
        points,
        step: scan.step,
        origin: [x.0, y.0],
        rms: scan.rms,
        correlation_length: scan.correlation_length,
        waviness: vec![Waviness {
            amplitude: scan.waviness,
            wavenumber: [1.0 / scan.wavelength, 0.0],
            phase: 0.5 * std::f64::consts::PI * side as f64,
        }],
        tilt: scan.tilt,
        height_step: Some(scan.height_step),
        seed: scan.seed.wrapping_add(side),
    };
    let geometry = brake_reuss_beam::geometry::Geometry::default();
    let (holes, radius) = (geometry.hole_positions(), 0.5 * geometry.hole_diameter);
    Ok(synthetic.generate(move |[x, y]| holes.iter().any(|hole| (x - hole).hypot(y) < radius))?)
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
    let smallest = interface.gap().iter().copied().fold(f64::INFINITY, f64::min);
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
