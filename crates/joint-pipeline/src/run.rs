//! A scene, run from mesh to backbone.

use crate::Error;
use crate::cache::KeyBuilder;
use crate::checkpoint::Checkpoint;
use crate::ensemble::{self, Ensemble};
use crate::interface::{InterfaceForce, LawReport, SceneInterface};
use crate::methods::{self, MethodResult};
use crate::model::{StructuralModel, Structure};
use crate::progress::{Progress, Stage};
use crate::scene::{BoltBehaviour, CommitName, Scene};
use crate::validity::{Validity, assess};
use contact_laws::{Regime, Sticking};
use cqsma_solver::cqsma::{self, Commit, Cycles, Settings};
use cqsma_solver::prestress::{self, Prestress};
use cqsma_solver::{BackbonePoint, Linearisation, LoopObserver, NewtonSettings, modes};
use faer::Mat;
use reduction::ReducedModel;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use zte_assembly::flux::LoopArea;
use zte_assembly::{Interface, InterfaceMesh, State, Workspace};

/// Modes that move the response point less than this share of a rigid motion cannot be scaled by its amplitude.
const LEAST_PARTICIPATION: f64 = 1e-2;

/// Stiffness against a uniform separation, relative to the sum of the stiffnesses of its coordinates, that is round-off.
const FREE_OF_ENERGY: f64 = 1e-9;

/// Inertia of a mode along a uniform separation, relative to that of the separation itself, that is round-off.
const FREE_OF_INERTIA: f64 = 1e-9;

/// What is not part of the scene.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Folder of cached reduced models, and of the finished amplitudes of interrupted runs; none: nothing is read or
    /// stored.
    pub cache: Option<PathBuf>,
}

/// Quantities at the quadrature points.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Fields {
    /// Jump x, y, interference n (m).
    pub jump: [Vec<f64>; 3],
    /// Traction x, y, n (Pa).
    pub traction: [Vec<f64>; 3],
    /// Regimes.
    pub regime: Vec<Regime>,
    /// Energy dissipated per area and cycle x, y, n (J/m^2); zero for a static state.
    pub flux: [Vec<f64>; 3],
}

/// What the loop of one amplitude did at the interface.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LoopFields {
    /// Area fraction that slips at the positive peak.
    pub slip_fraction: f64,
    /// Area fraction that is open there.
    pub open_fraction: f64,
    /// Dissipation per cycle from the points' loops (J) (eq. 43).
    pub dissipation: f64,
    /// Largest tangential motion from the prestress over the loop (m).
    pub largest_sliding: f64,
    /// Fields at the positive peak, for the amplitudes asked for.
    pub fields: Option<Fields>,
}

/// One amplitude.
#[derive(Clone, Debug)]
pub struct AmplitudeResult {
    /// The loop.
    pub point: BackbonePoint,
    /// What it did at the interface; none if it did not converge.
    pub fields: Option<LoopFields>,
    /// Acceleration amplitude at the response point (m/s^2).
    pub response_acceleration: Option<f64>,
    /// Displacement amplitude at the response point, `q phi` (m).
    pub response_displacement: Option<f64>,
}

/// The static state.
#[derive(Clone, Debug)]
pub struct PrestressResult {
    /// Solver's account.
    pub solution: Prestress<State>,
    /// Sum of the absolute residual forces over the interface relative to that of the loads.
    pub residual_ratio: f64,
    /// Relative difference between the integrated pressure and the bolt loads.
    pub equilibrium_error: f64,
    /// Fields.
    pub fields: Fields,
}

/// A finished run.
#[derive(Debug)]
pub struct Run {
    /// The scene, in SI.
    pub scene: Scene,
    /// The structure.
    pub model: StructuralModel,
    /// The interface mesh.
    pub mesh: InterfaceMesh,
    /// The interface with its law.
    pub interface: Interface,
    /// About the law.
    pub law: LawReport,
    /// Points whose gap was set from a negative value to zero.
    pub clipped_gaps: usize,
    /// Static state.
    pub prestress: PrestressResult,
    /// Linearised frequencies (Hz).
    pub frequencies: Vec<f64>,
    /// Amplitudes in ascending order.
    pub amplitudes: Vec<AmplitudeResult>,
    /// Results of the methods beside CQSMA, in the scene's order.
    pub methods: Vec<MethodResult>,
    /// Limits of the model.
    pub validity: Validity,
}

/// What the nonlinear solves made of an interface.
pub(crate) struct Analysis {
    prestress: PrestressResult,
    /// [`Validity::separation_modal_force`].
    separation: Option<f64>,
    pub(crate) frequencies: Vec<f64>,
    pub(crate) amplitudes: Vec<AmplitudeResult>,
    methods: Vec<MethodResult>,
}

/// Amplitudes that are done.
type Loops = Checkpoint<(BackbonePoint, Option<LoopFields>)>;

/// A scene with its structure reduced and its interface built: everything before the first nonlinear solve.
#[derive(Debug)]
pub struct Prepared {
    scene: Scene,
    cache: Option<PathBuf>,
    clearance: Option<f64>,
    mesh: InterfaceMesh,
    model: StructuralModel,
    interface: SceneInterface,
}

impl std::fmt::Debug for SceneInterface {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SceneInterface")
            .field("interface", &self.interface)
            .field("law", &self.report)
            .finish()
    }
}

/// Runs a scene.
///
/// # Errors
/// Whatever makes the scene impossible to run. Amplitudes that do not converge are results, not errors.
pub fn run(scene: &Scene, options: &Options, progress: &dyn Progress) -> Result<Run, Error> {
    prepare(scene, options, progress)?.solve(progress)
}

/// Runs a scene and an ensemble of `realisations` bootstrap realisations of its laws, see [`Prepared::solve_ensemble`].
///
/// # Errors
/// As [`run`] and [`Prepared::solve_ensemble`].
pub fn run_ensemble(
    scene: &Scene,
    realisations: usize,
    options: &Options,
    progress: &dyn Progress,
) -> Result<(Run, Ensemble), Error> {
    if !scene.surface.is_scanned() {
        return Err(Error::NoSamples);
    }
    prepare(scene, options, progress)?.solve_ensemble(realisations, progress)
}

/// Builds and reduces the structure, and turns the surface into laws.
///
/// # Errors
/// Of the mesher, the finite elements, the reduction, the surface and the laws.
pub fn prepare(scene: &Scene, options: &Options, progress: &dyn Progress) -> Result<Prepared, Error> {
    scene.validate(&scene.name)?;
    progress.begin(Stage::Mesh);
    let structure = Structure::try_new(&scene.model, scene.bolts.behaviour, progress)?;
    progress.end(Stage::Mesh);
    Prepared::try_new(scene, &structure, options, progress)
}

impl Prepared {
    /// The scene on a structure that is already meshed.
    ///
    /// # Errors
    /// Of the finite elements, the reduction, the surface and the laws.
    pub fn try_new(
        scene: &Scene,
        structure: &Structure,
        options: &Options,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let model = structure.reduce(options.cache.as_deref(), progress)?;
        Self::with_model(scene, structure, model, options, progress)
    }

    /// The scene on a structure that is already reduced, so that several scenes share one reduction.
    ///
    /// # Errors
    /// Of the surface and the laws.
    pub fn with_model(
        scene: &Scene,
        structure: &Structure,
        model: StructuralModel,
        options: &Options,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        scene.validate(&scene.name)?;
        progress.begin(Stage::Characterise);
        let load = scene.bolts.load * closing(&model);
        let interface = SceneInterface::try_new(scene, structure.interface(), load)?;
        interface.notes().for_each(|note| progress.note(&note));
        progress.end(Stage::Characterise);
        Ok(Self {
            scene: scene.clone(),
            cache: options.cache.clone(),
            clearance: structure.joint.clearance,
            mesh: structure.interface().clone(),
            model,
            interface,
        })
    }

    /// The reduced structure.
    pub fn model(&self) -> &StructuralModel {
        &self.model
    }

    /// The interface.
    pub fn interface(&self) -> &SceneInterface {
        &self.interface
    }

    /// Static load on the reduced coordinates (N).
    pub fn static_load(&self) -> Vec<f64> {
        let reduced = &self.model.reduced;
        let mut load = vec![0.0; reduced.mass.nrows()];
        for unit in &reduced.loads {
            load.iter_mut()
                .zip(unit)
                .for_each(|(sum, value)| *sum += self.scene.bolts.load * value);
        }
        load
    }

    /// The guess that prestress starts from: a uniform closure that carries the bolt load (m).
    pub fn start(&self) -> Vec<f64> {
        self.uniform(self.interface.closure)
    }

    fn uniform(&self, closure: f64) -> Vec<f64> {
        let reduced = &self.model.reduced;
        let mut start = vec![0.0; reduced.mass.nrows()];
        start[2..reduced.n_relative]
            .iter_mut()
            .step_by(3)
            .for_each(|u| *u = closure);
        start
    }

    /// Modal force at which the inertia of a mode pulls a vibrating structure apart as much as the bolt loads hold it together.
    fn separation(&self, vibrating: &ReducedModel, shape: &[f64]) -> Option<f64> {
        let (apart, load) = (self.uniform(1.0), self.static_load());
        let normals = || (2..vibrating.n_relative).step_by(3);
        let along = |matrix: &Mat<f64>, left: &[f64]| -> f64 {
            let entry = |j| matrix.col(j).iter().zip(left).map(|(a, b)| a * b).sum::<f64>();
            normals().map(entry).sum()
        };
        let stiffnesses: f64 = normals().map(|j| vibrating.stiffness[(j, j)]).sum();
        if along(&vibrating.stiffness, &apart) > FREE_OF_ENERGY * stiffnesses {
            return None;
        }
        // Modes that are antisymmetric in it have no inertia along it but round-off.
        let inertia = along(&vibrating.mass, shape).abs();
        let all = along(&vibrating.mass, &apart).max(0.0).sqrt();
        let holds = normals().map(|j| load[j]).sum::<f64>() / inertia;
        (inertia > FREE_OF_INERTIA * all).then_some(holds)
    }

    /// Prestress, modes and backbone.
    ///
    /// # Errors
    /// [`Error::Prestress`] and defects of the linear structure.
    pub fn solve(self, progress: &dyn Progress) -> Result<Run, Error> {
        let interface = &self.interface;
        let analysis = self.analyse(&self.scene, &interface.interface, interface.closure, progress)?;
        Ok(self.finish(analysis))
    }

    /// As [`Prepared::solve`], and then the backbones of `realisations` bootstrap realisations of all elements' laws on
    /// the same reduced structure. With a cache, realisations of an interrupted ensemble are taken from there.
    ///
    /// # Errors
    /// As [`Prepared::solve`]; [`Error::NoSamples`] for surfaces that are not scanned; an interruption. Whatever else
    /// ends a realisation is part of the result.
    pub fn solve_ensemble(self, realisations: usize, progress: &dyn Progress) -> Result<(Run, Ensemble), Error> {
        let interface = &self.interface;
        let analysis = self.analyse(&self.scene, &interface.interface, interface.closure, progress)?;
        let ensemble = self.ensemble(realisations, &analysis, progress)?;
        Ok((self.finish(analysis), ensemble))
    }

    fn ensemble(&self, realisations: usize, analysis: &Analysis, progress: &dyn Progress) -> Result<Ensemble, Error> {
        progress.begin(Stage::Ensemble);
        // Fields and other methods are the business of the measured law.
        let mut scene = self.scene.clone();
        scene.methods.clear();
        scene.output.fields_at = Some(Vec::new());
        let load = scene.bolts.load * closing(&self.model);
        let checkpoint = match &self.cache {
            None => Checkpoint::default(),
            Some(directory) => {
                let mut key = self.key(&scene);
                // Whatever else the realisations depend on has left its mark in the measured backbone.
                key.numbers(analysis.prestress.solution.displacement.iter().copied());
                key.numbers(analysis.frequencies.iter().copied());
                Checkpoint::open(directory, "ensemble", &key.finish())
            }
        };
        let members = ensemble::members(&scene, realisations, checkpoint, progress, |k, progress| {
            let (interface, closure) = self.interface.realisation(&scene, k, load)?;
            self.analyse(&scene, &interface, closure, progress)
        })?;
        progress.end(Stage::Ensemble);
        Ok(Ensemble::new(members, &analysis.amplitudes))
    }

    fn key(&self, scene: &Scene) -> KeyBuilder {
        let mut key = KeyBuilder::new();
        key.text(&serde_json::to_string(scene).unwrap_or_default());
        key.text(contact_laws::instruction_set());
        key
    }

    fn finish(self, analysis: Analysis) -> Run {
        let Analysis {
            prestress,
            separation,
            frequencies,
            amplitudes,
            methods,
        } = analysis;
        let validity = assess(
            &self.interface.interface,
            self.interface.asperities.as_ref(),
            self.scene.model.material.hardness,
            &prestress.fields,
            self.clearance,
            separation,
            &amplitudes,
        );
        Run {
            validity,
            frequencies,
            amplitudes,
            methods,
            prestress,
            law: self.interface.report,
            clipped_gaps: self.interface.clipped_gaps,
            interface: self.interface.interface,
            mesh: self.mesh,
            model: self.model,
            scene: self.scene,
        }
    }

    /// Prestress, modes and backbone of an interface, of which `closure` carries the bolt load (m).
    fn analyse(
        &self,
        scene: &Scene,
        interface: &Interface,
        closure: f64,
        progress: &dyn Progress,
    ) -> Result<Analysis, Error> {
        let reduced = &self.model.reduced;
        let stiffness = reduced.stiffness.as_ref();
        let force = InterfaceForce::new(interface);
        let newton = NewtonSettings {
            tolerance: scene.cqsma.tolerance,
            ..NewtonSettings::default()
        };

        progress.begin(Stage::Prestress);
        let static_load = self.static_load();
        let start = self.uniform(closure);
        let solution = prestress::solve(stiffness, &force, &static_load, &start, &newton)?.map_err(|failure| {
            Error::Prestress {
                reason: failure.reason,
                history: failure.history,
            }
        })?;
        let prestress = self.describe_prestress(&force, solution, &static_load);
        progress.end(Stage::Prestress);

        progress.begin(Stage::Modes);
        let solution = &prestress.solution;
        let locked = match scene.bolts.behaviour {
            BoltBehaviour::DeadLoad => None,
            BoltBehaviour::Locked => Some(reduced.locked()?),
        };
        let vibrating = locked.as_ref().unwrap_or(reduced);
        let response = response(vibrating);
        let line = linearise(scene, vibrating, &force, solution)?;
        progress.end(Stage::Modes);

        progress.begin(Stage::Backbone);
        let mode = scene.cqsma.mode - 1;
        let shape: Vec<f64> = line.shapes.col(mode).iter().copied().collect();
        let separation = self.separation(vibrating, &shape);
        let phi: f64 = line.shapes.col(mode).iter().zip(&response).map(|(a, b)| a * b).sum();
        let omega2 = line.eigenvalues[mode];
        let participation = phi.abs() / self.largest_response(&line, &response);
        if participation < LEAST_PARTICIPATION {
            let frequency = line.frequencies()[mode];
            return Err(Error::NoResponse {
                mode: mode + 1,
                frequency,
                participation,
            });
        }
        let forces: Vec<f64> = displacements(scene).into_iter().map(|x| omega2 * x / phi).collect();
        let settings = Settings {
            mode,
            vertices_per_quarter: scene.cqsma.vertices_per_quarter,
            cycles: match (scene.cqsma.cycles, scene.cqsma.until_closed, Cycles::default()) {
                (Some(n), ..) => Cycles::Fixed(n),
                (None, Some(tolerance), Cycles::UntilClosed { most, .. }) => Cycles::UntilClosed { tolerance, most },
                (None, _, default) => default,
            },
            commit: match scene.cqsma.commit {
                CommitName::AtReversals => Commit::AtReversals,
                CommitName::AtEveryVertex => Commit::AtEveryVertex,
            },
            newton,
            ..Settings::default()
        };
        let checkpoint = self.checkpoint(scene, &line, mode, &forces, progress);
        let pending: Vec<usize> = (0..forces.len()).filter(|i| !checkpoint.holds(*i)).collect();
        let pending_forces: Vec<f64> = pending.iter().map(|&i| forces[i]).collect();
        let stored = scene.fields_at();
        let finished = AtomicUsize::new(forces.len() - pending.len());
        let finish = |index: usize, point: &BackbonePoint, fields: Option<&LoopFields>| {
            checkpoint.add(index, (point, fields));
            let done = finished.fetch_add(1, Ordering::Relaxed) + 1;
            progress.fraction(Stage::Backbone, done as f64 / forces.len() as f64);
            if progress.interrupted() {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let points = cqsma::run(&line, &force, &pending_forces, &settings, |at| {
            let index = pending[at];
            let store = stored.contains(&(index + 1));
            Watcher::new(interface, &prestress.fields, index, store, &finish)
        })?;
        let points: Vec<_> = points
            .into_iter()
            .map(|(point, watcher)| (point, watcher.fields))
            .collect();
        let mut done = checkpoint.complete();
        done.extend(pending.iter().copied().zip(points));
        let amplitudes: Vec<AmplitudeResult> = done
            .into_values()
            .map(|(point, fields)| {
                let motion = point
                    .result
                    .as_ref()
                    .ok()
                    .map(|r| (r.modal_amplitude * phi.abs(), r.omega));
                AmplitudeResult {
                    fields,
                    response_acceleration: motion.map(|(x, omega)| x * omega * omega),
                    response_displacement: motion.map(|(x, _)| x),
                    point,
                }
            })
            .collect();
        progress.end(Stage::Backbone);

        let methods = methods::Request {
            scene,
            interface,
            reduced,
            prestress: solution,
            line: &line,
            force: &force,
            response: &response,
            modal_forces: &forces,
            settings: &settings,
        }
        .run(progress)?;

        let frequencies = line.frequencies();
        drop(line);
        Ok(Analysis {
            prestress,
            separation,
            frequencies,
            amplitudes,
            methods,
        })
    }

    /// What a mass-normalised mode moves the response point by if that takes part as in a rigid motion; where the mass is
    /// not known, the most that any of the modes moves it by.
    fn largest_response(&self, line: &Linearisation<'_, State>, response: &[f64]) -> f64 {
        let moved = |shape: faer::ColRef<'_, f64>| shape.iter().zip(response).map(|(a, b)| a * b).sum::<f64>().abs();
        match self.model.facts.mass {
            Some(mass) => mass.sqrt().recip(),
            None => line.shapes.col_iter().map(moved).fold(f64::MIN_POSITIVE, f64::max),
        }
    }

    /// Finished amplitudes of an earlier, interrupted run of the same loops.
    fn checkpoint(
        &self,
        scene: &Scene,
        line: &Linearisation<'_, State>,
        mode: usize,
        forces: &[f64],
        progress: &dyn Progress,
    ) -> Loops {
        let Some(directory) = &self.cache else {
            return Loops::default();
        };
        let mut key = self.key(scene);
        // Whatever else the loops depend on has left its mark in the static state or the mode.
        key.numbers(line.displacement().iter().copied());
        key.numbers(line.shapes.col(mode).iter().copied());
        key.numbers(forces.iter().copied());
        let checkpoint = Checkpoint::open(directory, "loops", &key.finish());
        let (found, all) = (checkpoint.len(), forces.len());
        if found > 0 {
            progress.note(&format!(
                "{found} of {all} amplitudes were taken from an interrupted run"
            ));
        }
        checkpoint
    }

    fn describe_prestress(
        &self,
        force: &InterfaceForce<'_>,
        solution: Prestress<State>,
        static_load: &[f64],
    ) -> PrestressResult {
        let interface = force.interface();
        let nd = interface.n_dofs();
        let mut workspace = interface.workspace();
        let mut end = solution.state.clone();
        let mut contact = vec![0.0; nd];
        let u = &solution.displacement;
        let state = &solution.state;
        interface.evaluate(
            &u[..nd],
            Sticking::Coulomb,
            state,
            &mut end,
            &mut workspace,
            &mut contact,
            None,
        );
        let stiffness = &self.model.reduced.stiffness;
        let (mut residual, mut loads) = (0.0, 0.0);
        for i in 0..nd {
            let elastic: f64 = stiffness.col(i).iter().zip(u).map(|(k, u)| k * u).sum();
            residual += (elastic + contact[i] - static_load[i]).abs();
            loads += static_load[i].abs();
        }
        let carried: f64 = contact.iter().skip(2).step_by(3).sum();
        let bolts = self.scene.bolts.load * closing(&self.model);
        PrestressResult {
            solution,
            residual_ratio: residual / loads,
            equilibrium_error: (carried / bolts - 1.0).abs(),
            fields: Fields {
                jump: workspace.jump,
                traction: workspace.traction,
                regime: workspace.regime,
                flux: std::array::from_fn(|_| vec![0.0; interface.operators().n_points()]),
            },
        }
    }
}

/// Modes of the structure that vibrates, with locked bolts if they are so, about a static state of the one that does not;
/// the response is not negative on any of them.
pub(crate) fn linearise<'a>(
    scene: &Scene,
    vibrating: &'a ReducedModel,
    force: &InterfaceForce<'_>,
    solution: &Prestress<State>,
) -> Result<Linearisation<'a, State>, Error> {
    let mut displacement = solution.displacement.clone();
    if scene.bolts.behaviour == BoltBehaviour::Locked {
        // The jump acts on the contact; the other coordinates of the locked structure count from the prestress.
        displacement.truncate(vibrating.n_relative);
        displacement.resize(vibrating.mass.nrows(), 0.0);
    }
    let (stiffness, mass) = (vibrating.stiffness.as_ref(), vibrating.mass.as_ref());
    let state = solution.state.clone();
    let mut line = modes::linearise(stiffness, mass, force, displacement, state, scene.cqsma.modes)?;
    line.orient(&response(vibrating))?;
    Ok(line)
}

/// Recovers the displacement at the response point.
pub(crate) fn response(model: &ReducedModel) -> Vec<f64> {
    model.recovery.row(0).iter().copied().collect()
}

/// Generalised force on a uniform closure of the interface at unit tension of all bolts.
fn closing(model: &StructuralModel) -> f64 {
    let reduced = &model.reduced;
    let of_one = |load: &Vec<f64>| load[2..reduced.n_relative].iter().step_by(3).sum::<f64>();
    reduced.loads.iter().map(of_one).sum()
}

/// Displacements at the response point that the modal forces are chosen for, by linear estimate (m).
fn displacements(scene: &Scene) -> Vec<f64> {
    let c = &scene.cqsma;
    let ratio = (c.amplitude_to / c.amplitude_from).ln();
    let last = c.amplitudes.saturating_sub(1).max(1) as f64;
    (0..c.amplitudes)
        .map(|i| c.amplitude_from * (ratio * i as f64 / last).exp())
        .collect()
}

/// Hears of a finished amplitude: its place in the backbone, the loop, and what it did at the interface.
type Finish<'a> = dyn Fn(usize, &BackbonePoint, Option<&LoopFields>) -> ControlFlow<()> + Sync + 'a;

/// Watches one loop at the quadrature points.
struct Watcher<'a> {
    interface: &'a Interface,
    prestress: &'a Fields,
    index: usize,
    store: bool,
    finish: &'a Finish<'a>,
    area: LoopArea,
    workspace: Workspace,
    end: Option<State>,
    force: Vec<f64>,
    peak: f64,
    slip_fraction: f64,
    open_fraction: f64,
    largest_sliding: f64,
    /// The workspace at the positive peak, if it is to be stored.
    at_peak: Option<Workspace>,
    /// What came of the loop, when it is done and has converged.
    fields: Option<LoopFields>,
}

impl<'a> Watcher<'a> {
    fn new(interface: &'a Interface, prestress: &'a Fields, index: usize, store: bool, finish: &'a Finish<'a>) -> Self {
        Self {
            interface,
            prestress,
            index,
            store,
            finish,
            area: LoopArea::new(interface.operators().n_points()),
            workspace: interface.workspace(),
            end: None,
            force: vec![0.0; interface.n_dofs()],
            peak: f64::NEG_INFINITY,
            slip_fraction: 0.0,
            open_fraction: 0.0,
            largest_sliding: 0.0,
            at_peak: None,
            fields: None,
        }
    }

    fn close(&mut self) -> LoopFields {
        let flux = std::mem::replace(&mut self.area, LoopArea::new(0)).close();
        let weights = &self.interface.operators().weights;
        let dissipation = flux
            .iter()
            .map(|f| f.iter().zip(weights).map(|(f, w)| f * w).sum::<f64>())
            .sum();
        LoopFields {
            slip_fraction: self.slip_fraction,
            open_fraction: self.open_fraction,
            dissipation,
            largest_sliding: self.largest_sliding,
            fields: self.at_peak.take().map(|peak| Fields {
                jump: peak.jump,
                traction: peak.traction,
                regime: peak.regime,
                flux,
            }),
        }
    }
}

impl LoopObserver<State> for Watcher<'_> {
    fn done(&mut self, point: &BackbonePoint) -> ControlFlow<()> {
        self.fields = point.result.is_ok().then(|| self.close());
        (self.finish)(self.index, point, self.fields.as_ref())
    }

    fn vertex(&mut self, modal_force: f64, displacement: &[f64], begin: &State) {
        let end = self.end.get_or_insert_with(|| begin.clone());
        let jump = &displacement[..self.interface.n_dofs()];
        self.interface.evaluate(
            jump,
            Sticking::Coulomb,
            begin,
            end,
            &mut self.workspace,
            &mut self.force,
            None,
        );
        self.area.add(&self.workspace);
        for p in 0..self.workspace.regime.len() {
            let slide = |c: usize| self.workspace.jump[c][p] - self.prestress.jump[c][p];
            self.largest_sliding = self.largest_sliding.max(slide(0).hypot(slide(1)));
        }
        // The loop begins and ends at its positive peak; the end carries the regimes that led there.
        if modal_force >= self.peak {
            self.peak = modal_force;
            let operators = self.interface.operators();
            let fraction = |regime: Regime| {
                let found = self
                    .workspace
                    .regime
                    .iter()
                    .zip(&operators.weights)
                    .filter(|(r, _)| **r == regime);
                found.fold(0.0, |sum, (_, w)| sum + w) / operators.area()
            };
            (self.slip_fraction, self.open_fraction) = (fraction(Regime::Slip), fraction(Regime::Open));
            if self.store {
                self.at_peak = Some(self.workspace.clone());
            }
        }
    }
}
