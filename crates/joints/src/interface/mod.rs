//! From a scene's surface and law to the interface.

mod asperities;
mod finish;
mod force;
mod friction;
mod given;
mod law;
mod population;
mod pressed;
mod pressures;
mod resolved;
mod stiffness;
mod surface;
mod variation;
mod work;

pub use asperities::{Asperities, measured_population};
pub use finish::{FinishReport, FinishedFace, FinishedSurface, GreenwoodWilliamsonParameters};
pub use force::InterfaceForce;
pub use given::curves_of_element;
pub use law::{AsperityReport, LawReport};
pub use pressed::BoundaryElementsReport;
pub use resolved::ResolvedReport;
pub use stiffness::interference_at;
pub use surface::{
    FileReport, Profile, SCHEMA_VERSION as SURFACE_SCHEMA_VERSION, ScannedSurface, SurfaceReport, in_frame, synthetic,
};

use crate::Error;
use crate::progress::{Progress, Stage};
use crate::store::Options;
use contact_laws::{PointParameters, Sticking, TractionLaw};
use dense_algebra::Limits;
use given::GivenLaw;
use joint_model::InterfacePart;
use law::{BuiltLaw, NamedLaw, fits_of};
use population::population;
use pressures::{Counted, Pressures};
use rayon::prelude::*;
use scenes::{Bins, Friction, Scene, Surface};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use stiffness::{mean, stiffnesses, stuck_stiffness};
use surface_characterisation::PairAsperities;
use work::Work;
use zte_assembly::{Interface, InterfaceMesh, Operators};

/// The interface of a scene.
pub struct SceneInterface {
    /// Ready for evaluation.
    pub interface: Interface,
    /// Points whose gap came out negative and was set to zero.
    pub clipped_gaps: usize,
    /// Uniform closure `u_n` above the gap that carries the bolt load (m), zero without one: the guess that prestress starts from.
    pub closure: f64,
    /// Sum of the bolt loads (N).
    load: f64,
    operators: Arc<Operators>,
    /// The parts by their names, in the order of their points; never empty.
    parts: Vec<(String, PartLaw)>,
    /// Pressures at the points at rest that laws follow (Pa).
    at_rest: Option<Vec<f64>>,
}

/// What is reported about a part of an interface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PartReport {
    /// Its name.
    pub name: String,
    /// Area that is in contact at most (m^2).
    pub area: f64,
    /// Elements.
    pub elements: usize,
    /// Friction coefficient (-), where no zone has its own.
    pub mu: f64,
    /// Its law.
    pub law: LawReport,
}

impl std::fmt::Debug for SceneInterface {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SceneInterface")
            .field("interface", &self.interface)
            .field("closure", &self.closure)
            .finish()
    }
}

/// A part of an interface with its law, before the parts are joined.
struct PartLaw {
    /// With the surface, gap, law and friction of the part.
    scene: Scene,
    /// Number of the interface in the scene that it belongs to, where the scene has several.
    source: Option<usize>,
    operators: Arc<Operators>,
    element_of: Vec<u32>,
    /// Friction coefficients of the points.
    mu: PointParameters<f64>,
    from: Source,
    /// Gap of the points (m), and how many were negative.
    gap: Vec<f64>,
    clipped_gaps: usize,
}

impl PartLaw {
    /// Builds law and gap over a mesh in its own plane coordinates, with its operators; `pressure` is the mean one of the bolts (Pa).
    /// Asperities that are known already are those of `known`, a part whose surface is the same.
    fn try_new(
        scene: Scene,
        mesh: &InterfaceMesh,
        operators: Arc<Operators>,
        (pressure, counted): (f64, &Counted),
        known: Option<&Self>,
        work: Work<'_>,
    ) -> Result<Self, Error> {
        let element_of: Vec<u32> = operators
            .first_point
            .windows(2)
            .enumerate()
            .flat_map(|(e, r)| vec![e as u32; r[1] - r[0]])
            .collect();
        let mu = friction::coefficients(&scene, &operators.positions)?;
        let pressures = Pressures {
            mean: pressure,
            at_rest: None,
            counted,
        };
        let law_of = |asperities: Asperities| -> Result<Source, Error> {
            let built = asperities.law(&scene, &operators, &element_of, &mu, pressures)?;
            Ok(Source::Asperities(Box::new(built)))
        };
        // Populations depend on the surface, and on how the law takes them.
        let is_same = |part: &&Self| {
            part.scene.interfaces.surface == scene.interfaces.surface
                && part.scene.interfaces.law.kind == scene.interfaces.law.kind
        };
        let known = known.filter(is_same).and_then(|part| match &part.from {
            Source::NumberOrText(_) => None,
            Source::Asperities(built) => Some(&built.asperities),
        });
        let from = match (&scene.interfaces.surface, known) {
            (Surface::Parameters(parameters), _) => {
                Source::NumberOrText(GivenLaw::try_new(&scene, parameters, &element_of, &mu)?)
            }
            (_, Some(known)) => law_of(known.varied(&scene)?)?,
            (Surface::Measured | Surface::Benchmark(_), None) => {
                let measured = scene
                    .measured_surface()
                    .ok_or_else(|| scenes::Error::NoMeasuredSurface {
                        place: scene.name.clone(),
                        field: "interfaces.surface",
                    })?;
                law_of(Asperities::measured(&measured, &scene, mesh)?)?
            }
            (Surface::SyntheticScan(_) | Surface::Scans(_), None) => law_of(Asperities::scanned(&scene, mesh, work)?)?,
            (Surface::Finish(_), None) => law_of(Asperities::finished(&scene, mesh)?)?,
        };
        let (gap, clipped_gaps) = match &from {
            Source::NumberOrText(given) => (given.gap.clone(), 0),
            Source::Asperities(built) => {
                let clipped = built.known_gap.iter().filter(|g| **g < 0.0).count();
                let known = built.known_gap.iter().map(|g| g.max(0.0));
                (scene.interfaces.scale.gaps(known, &operators.positions), clipped)
            }
        };
        refuse_gap_beyond_the_faces(&gap, mesh)?;
        Ok(Self {
            scene,
            operators,
            source: None,
            element_of,
            mu,
            from,
            gap,
            clipped_gaps,
        })
    }

    /// Whether the parameters of its law are given.
    fn is_given(&self) -> bool {
        matches!(self.from, Source::NumberOrText(_))
    }

    /// Whether its law follows the pressures at rest.
    fn follows_rest(&self) -> bool {
        let law = &self.scene.interfaces.law;
        !self.is_given() && law.friction() == Friction::Foundation && !matches!(law.bins, Bins::EquallySpaced(_))
    }

    /// With its law for the pressures at rest, where it follows them.
    fn about(self, pressures: Pressures<'_>) -> Result<Self, Error> {
        let follows = self.follows_rest();
        let from = match self.from {
            Source::Asperities(built) if follows => {
                let built = built.about(&self.scene, &self.element_of, &self.mu, pressures)?;
                Source::Asperities(Box::new(built))
            }
            from => from,
        };
        Ok(Self { from, ..self })
    }

    fn law(&self) -> Arc<dyn TractionLaw> {
        match &self.from {
            Source::NumberOrText(given) => given.law.clone(),
            Source::Asperities(built) => built.law.clone(),
        }
    }

    /// Interference at each point that a preload belongs to (m).
    fn interference(&self) -> Vec<f64> {
        match &self.from {
            Source::NumberOrText(given) => given.interference.clone(),
            Source::Asperities(_) => vec![0.0; self.gap.len()],
        }
    }

    /// The part alone.
    fn interface(&self) -> Result<Interface, Error> {
        let n = self.gap.len();
        let interface = Interface::try_new(self.operators.clone(), vec![(0..n, self.law())], self.gap.clone())?;
        Ok(match &self.from {
            Source::NumberOrText(given) => interface.with_interference(given.interference.clone())?,
            Source::Asperities(_) => interface,
        })
    }

    /// What is reported about it where the bolts load it by `load` (N).
    fn report(&self, load: f64) -> Result<LawReport, Error> {
        let (scene, operators) = (&self.scene, &self.operators);
        let (mean_closure, mean_pressure) = match &self.from {
            // What the preload holds together moves little from where it is.
            Source::NumberOrText(given) if load == 0.0 => {
                let [closure, pressure] = mean(operators, |p| [given.interference[p], given.preload[p]]);
                (closure, pressure)
            }
            _ => {
                let flat = self.interface()?.with_gap(vec![0.0; self.gap.len()])?;
                (uniform_closure(&flat, load)?, load / operators.area())
            }
        };
        let (kind, resolved) = match &self.from {
            Source::NumberOrText(given) => (given.kind, None),
            Source::Asperities(built) => (built.kind, built.resolved.clone()),
        };
        let (stiffness, asperity_report) = match &self.from {
            Source::NumberOrText(given) => {
                let of_curves = |p: usize| stiffnesses(given.at(p), mean_closure);
                (mean(operators, of_curves), None)
            }
            Source::Asperities(built) => {
                let (stiffness, report) =
                    built.describe(scene, operators, &self.element_of, (mean_closure, mean_pressure))?;
                let stiffness = match &resolved {
                    None => stiffness,
                    Some(_) => mean(operators, |p| stuck_stiffness(&*built.law, p, mean_closure)),
                };
                (stiffness, Some(report))
            }
        };
        Ok(LawReport {
            kind: kind.to_owned(),
            history: scene.interfaces.law.history,
            asperities: asperity_report,
            resolved,
            mean_closure,
            mean_pressure,
            normal_stiffness: stiffness[0],
            tangential_stiffness: stiffness[1],
        })
    }
}

/// Share of the laws of all parts in the time of building an interface.
const LAWS: f64 = 0.4;

impl SceneInterface {
    /// Builds laws and gaps; `parts` are those of `mesh`, none where it is one whole. `load` is the sum of the bolt loads (N), zero only
    /// for given parameters with a preload.
    ///
    /// # Errors
    /// Of the law, the surface, the interface; [`Error::NoContact`].
    pub fn try_new(scene: &Scene, mesh: &InterfaceMesh, parts: &[InterfacePart], load: f64) -> Result<Self, Error> {
        Self::build(scene, mesh, parts, load, None, Work::default())
    }

    /// The same, until `progress` is interrupted; what takes long is taken from the cache of `options`, or stored there.
    ///
    /// # Errors
    /// As [`SceneInterface::try_new`]; an interruption. A cache that cannot be written is noted, not fatal.
    pub fn within(
        (options, progress): (&Options, &dyn Progress),
        scene: &Scene,
        mesh: &InterfaceMesh,
        parts: &[InterfacePart],
        load: f64,
    ) -> Result<Self, Error> {
        let stop = || progress.interrupted();
        let work = Work {
            limits: Limits::default().until(&stop),
            options,
            progress,
        };
        Self::build(scene, mesh, parts, load, None, work)
    }

    /// The interface of a scene that may differ from that of a `known` one in numbers alone. Where they are not those of the surface, it is
    /// not measured again.
    ///
    /// # Errors
    /// As [`SceneInterface::try_new`].
    pub fn knowing(
        known: Option<&Self>,
        scene: &Scene,
        mesh: &InterfaceMesh,
        parts: &[InterfacePart],
        load: f64,
    ) -> Result<Self, Error> {
        Self::build(scene, mesh, parts, load, known, Work::default())
    }

    fn build(
        scene: &Scene,
        mesh: &InterfaceMesh,
        parts: &[InterfacePart],
        load: f64,
        known: Option<&Self>,
        work: Work<'_>,
    ) -> Result<Self, Error> {
        let known_part = |number: usize| Some(&known?.parts.get(number)?.1);
        let operators = Arc::new(
            scene
                .model
                .symmetry
                .operators(mesh, scene.interfaces.points_per_direction)?,
        );
        let counted = Counted::default();
        let of_whole = (load / operators.area(), &counted);
        let done = AtomicUsize::new(0);
        let built = match parts {
            [] => vec![(
                "interface".to_owned(),
                PartLaw::try_new(scene.clone(), mesh, operators.clone(), of_whole, known_part(0), work)?,
            )],
            _ => parts
                .par_iter()
                .enumerate()
                .map(|(number, part)| {
                    let own = scene.of_interface(part.source);
                    let mesh = part.mesh(mesh);
                    let operators = scene
                        .model
                        .symmetry
                        .operators(&mesh, scene.interfaces.points_per_direction)?;
                    let law = PartLaw::try_new(own, &mesh, Arc::new(operators), of_whole, known_part(number), work)?;
                    let done = 1 + done.fetch_add(1, Ordering::Relaxed);
                    let share = done as f64 / parts.len() as f64;
                    work.progress.fraction(Stage::Characterise, LAWS * share);
                    let source = Some(part.source);
                    Ok((part.name.clone(), PartLaw { source, ..law }))
                })
                // The first error in the order of the parts, whatever the threads.
                .collect::<Vec<Result<_, Error>>>()
                .into_iter()
                .collect::<Result<_, _>>()?,
        };
        let interface = joined(&operators, &built)?;
        let are_given = built.iter().all(|(_, part)| part.is_given());
        let closure = match are_given && load == 0.0 {
            true => 0.0,
            false => uniform_closure(&interface, load)?,
        };
        Ok(Self {
            clipped_gaps: built.iter().map(|(_, part)| part.clipped_gaps).sum(),
            interface,
            closure,
            load,
            operators,
            parts: built,
            at_rest: None,
        })
    }

    /// What is reported about the law of each part, in their order; never empty. It takes evaluations of all laws.
    ///
    /// # Errors
    /// [`Error::NoContact`] for a part that does not carry its share of the load; of fits to the curves.
    pub fn reports(&self) -> Result<Vec<PartReport>, Error> {
        let share = |area: f64| self.load / self.operators.area() * area;
        let of_part = |(name, part): &(String, PartLaw)| {
            let area = part.operators.area();
            // The whole carries the whole load, to the last bit.
            let is_whole = self.parts.len() == 1;
            let load = if is_whole { self.load } else { share(area) };
            Ok(PartReport {
                name: name.clone(),
                area,
                elements: part.operators.n_elements(),
                mu: part.scene.interfaces.mu,
                law: part.report(load)?,
            })
        };
        let reports: Vec<Result<_, Error>> = self.parts.par_iter().map(of_part).collect();
        reports.into_iter().collect()
    }

    /// Whether a law follows the pressures under the bolt loads: those of an elastic foundation lie about where it is at rest.
    pub fn follows_rest(&self) -> bool {
        self.load > 0.0 && self.parts.iter().any(|(_, part)| part.follows_rest())
    }

    /// Pressures at the points at rest that laws follow (Pa); none before [`Self::about`].
    pub fn pressures_at_rest(&self) -> Option<&[f64]> {
        self.at_rest.as_deref()
    }

    /// The interface with laws that follow the pressures at the points (Pa) under its bolt loads. Its closure stays the guess that it was.
    ///
    /// # Errors
    /// As [`SceneInterface::try_new`].
    pub fn about(self, pressures: &[f64]) -> Result<Self, Error> {
        let (mean, counted) = (self.load / self.operators.area(), Counted::default());
        let mut rest = pressures;
        let mut parts = Vec::with_capacity(self.parts.len());
        for (name, part) in self.parts {
            let (own, others) = rest.split_at(part.gap.len());
            rest = others;
            parts.push((name, part, own));
        }
        let about = parts.into_par_iter().map(|(name, part, at_rest)| {
            let pressures = Pressures {
                mean,
                at_rest: Some(at_rest),
                counted: &counted,
            };
            Ok((name, part.about(pressures)?))
        });
        let parts = about.collect::<Vec<Result<_, Error>>>();
        let parts = parts.into_iter().collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            interface: joined(&self.operators, &parts)?,
            parts,
            at_rest: Some(pressures.to_vec()),
            ..self
        })
    }

    /// The asperities of all parts together; none where the parameters of the law of a part are given.
    pub fn asperities(&self) -> Option<Asperities> {
        let of_parts = self.parts.iter().map(|(_, part)| match &part.from {
            Source::NumberOrText(_) => None,
            Source::Asperities(built) => Some(&built.asperities),
        });
        Asperities::joined(of_parts.collect::<Option<Vec<_>>>()?)
    }

    /// The interface with the laws of bootstrap realisation `k` of all elements, and the closure as in
    /// [`SceneInterface::closure`]. Gaps are those of this interface; where a realisation lacks the tallest peak, contact
    /// begins at its own tallest, by so much later.
    ///
    /// # Errors
    /// [`Error::NoSamples`] unless the surface of all parts is scanned; else as [`SceneInterface::try_new`].
    pub fn realisation(&self, k: usize) -> Result<(Interface, f64), Error> {
        let mut laws = Vec::with_capacity(self.parts.len());
        let mut gap = Vec::new();
        let (mean, counted) = (self.load / self.operators.area(), Counted::default());
        for (_, part) in &self.parts {
            let points = gap.len()..gap.len() + part.gap.len();
            let pressures = Pressures {
                mean,
                at_rest: self.pressures_at_rest().map(|all| &all[points.clone()]),
                counted: &counted,
            };
            let (law, of_part) = part.realisation(k, pressures)?;
            laws.push((points, law));
            gap.extend(of_part);
        }
        for (gap, own) in gap.iter_mut().zip(self.interface.gap().unwrap_or_default()) {
            *gap += own;
        }
        let interface = Interface::try_new(self.operators.clone(), laws, gap)?;
        let closure = uniform_closure(&interface, self.load)?;
        Ok((interface, closure))
    }

    /// What the readers of the scans had to settle by convention, one sentence each.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        let scans = self.parts.iter().filter_map(|(_, part)| match &part.from {
            Source::NumberOrText(_) => None,
            Source::Asperities(built) => built.asperities.scan.as_deref(),
        });
        scans
            .flat_map(|(_, files)| files)
            .flat_map(|file| file.notes.iter().map(|note| format!("{}: {note}", file.path.display())))
    }
}

impl PartLaw {
    /// The law of a realisation, and by how much later contact begins at each point (m).
    fn realisation(&self, k: usize, pressures: Pressures<'_>) -> Result<(Arc<dyn TractionLaw>, Vec<f64>), Error> {
        let scene = &self.scene;
        let Source::Asperities(built) = &self.from else {
            return Err(Error::NoSamples);
        };
        let asperities = &built.asperities;
        let (scan, _) = asperities.scan.as_deref().ok_or(Error::NoSamples)?;
        let drawn: Vec<_> = scan
            .realisation(k)?
            .iter()
            .map(PairAsperities::from_own_tallest)
            .collect();
        let populations = drawn.iter().map(|(pair, _)| population(scene, pair));
        let populations = populations.collect::<Result<_, Error>>()?;
        let realisation = asperities.with_populations(populations, &scene.interfaces.scale)?;
        let sums = realisation.sums(scene.interfaces.law.tangential)?;
        let fits = || fits_of(&sums, scene.interfaces.law.tangential, scan.options.interference);
        let NamedLaw { law, .. } =
            realisation.traction_law(scene, &self.element_of, &self.mu, &sums, &fits, pressures)?;
        let height = scene.interfaces.scale.asperity_height;
        let later = self.element_of.iter().map(|&e| height * drawn[e as usize].1).collect();
        Ok((law, later))
    }
}

/// The parts side by side, with their gaps and preloads.
fn joined(operators: &Arc<Operators>, parts: &[(String, PartLaw)]) -> Result<Interface, Error> {
    let mut laws = Vec::with_capacity(parts.len());
    let mut first = 0;
    for (_, part) in parts {
        let range = first..first + part.gap.len();
        first = range.end;
        laws.push((range, part.law()));
    }
    let gap = parts.iter().flat_map(|(_, part)| part.gap.iter().copied()).collect();
    let interface = Interface::try_new(operators.clone(), laws, gap)?;
    Ok(match parts.iter().any(|(_, part)| part.is_given()) {
        true => interface.with_interference(parts.iter().flat_map(|(_, part)| part.interference()).collect())?,
        false => interface,
    })
}

/// What the law follows from.
enum Source {
    NumberOrText(GivenLaw),
    Asperities(Box<BuiltLaw>),
}

/// Refuses faces that are farther apart everywhere than they are long: small motions cannot close them. Points have no length.
fn refuse_gap_beyond_the_faces(gap: &[f64], mesh: &InterfaceMesh) -> Result<(), Error> {
    if mesh.is_of_points() {
        return Ok(());
    }
    let smallest = gap.iter().copied().fold(f64::INFINITY, f64::min);
    let size = |axis: usize| {
        let along = mesh.nodes.iter().map(|x| x[axis]);
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        high - low
    };
    let extent = size(0).hypot(size(1));
    if smallest > extent {
        return Err(Error::GapBeyondFaces { smallest, extent });
    }
    Ok(())
}

/// The rigid approach of the two faces at which the interface carries `load` (N); the Illinois method on a rising function.
///
/// # Errors
/// [`Error::NoContact`] if a closure of 1 m does not carry it.
pub fn uniform_closure(interface: &Interface, load: f64) -> Result<f64, Error> {
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
    // Beyond round-off of the gap, or the bracket would never grow.
    let first = f64::max(1e-9, 4.0 * f64::EPSILON * smallest.abs());
    let (mut low, mut high) = (smallest, smallest + first);
    let mut carried_low = 0.0;
    let mut carried_high = carried(high);
    while carried_high < load {
        (low, carried_low) = (high, carried_high);
        high = smallest + 2.0 * (high - smallest);
        carried_high = carried(high);
        if high > smallest + 1.0 {
            return Err(Error::NoContact {
                load,
                closure: high,
                carried: carried_high,
            });
        }
    }
    let (mut below, mut above) = (carried_low - load, carried_high - load);
    let mut best = if below.abs() <= above.abs() {
        (low, below)
    } else {
        (high, above)
    };
    // Whether the upper end moved last.
    let mut moved = None;
    for step in 1.. {
        // Halves now and then, as kinks slow the secant down.
        let middle = match step % 8 {
            0 => 0.5 * (low + high),
            _ => low - below * (high - low) / (above - below),
        };
        // Also where the secant has no slope.
        if !(low < middle && middle < high) {
            break;
        }
        let excess = carried(middle) - load;
        if excess.abs() < best.1.abs() {
            best = (middle, excess);
        }
        // An end that stays counts half, or it would stay for ever.
        if excess < 0.0 {
            above *= if moved == Some(false) { 0.5 } else { 1.0 };
            (low, below, moved) = (middle, excess, Some(false));
        } else {
            below *= if moved == Some(true) { 0.5 } else { 1.0 };
            (high, above, moved) = (middle, excess, Some(true));
        }
    }
    Ok(best.0)
}
