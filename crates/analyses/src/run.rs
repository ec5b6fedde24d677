//! A scene, run from mesh to backbones.

use super::backbone::{self, uniform};
use super::deformed::Deformed;
use super::element_loops;
use super::ensemble::{self, Ensemble, Member};
use super::finite_differences;
use super::methods::MethodResult;
use super::outcome::{AmplitudeResult, Analysis, ModeAnalysis, PrestressResult};
use super::periodic::{self, EpmcBackbone, ForcedResponse};
use super::prestress::{self, bolt_load, closing, linearise, load_of, response};
use super::sensitivities::{Neighbours, Sensitivities, Sensitivity};
use super::tightening::tighten;
use super::validity::{self, LARGEST_CONTACT, Validity};
use super::variants::Study;
use super::warnings::{self, ContactCircles, Findings, Warning};
use crate::Error;
use cqsma_solver::{Limits, NewtonSettings};
use faer::Mat;
use joint_model::MovedPairs;
use joint_model::quadratic::RaisedElements;
use joints::interface::{InterfaceForce, LawReport, PartReport, SceneInterface};
use joints::progress::{Progress, Stage, end_stage, go_on};
use joints::store::Options;
use joints::store::checkpoint::{Checkpoint, Checkpoints};
use joints::store::key::KeyBuilder;
use joints::structure::{OuterSurface, Overview, StructuralModel, Structure, choice_name};
use reduction::ReducedModel;
use scenes::{Assembly, BoltBehaviour, MeshInterface, Parameter, Scale, Scene, Stress, Surface};
use sprs::CsMat;
use std::path::Path;
use zte_assembly::{Interface, InterfaceMesh};

/// A finished run.
#[derive(Debug)]
pub struct Run {
    /// The scene, in SI.
    pub scene: Scene,
    /// The structure.
    pub model: StructuralModel,
    /// What was computed with.
    pub overview: Overview,
    /// What is implausible in it or in the results.
    pub warnings: Vec<Warning>,
    /// The interface mesh.
    pub mesh: InterfaceMesh,
    /// Unit vectors of the relative coordinates as rows, see [`Joint::frame`](joint_model::Joint::frame).
    pub frame: [[f64; 3]; 3],
    /// The same at each interface node, see [`Joint::node_frames`](joint_model::Joint::node_frames).
    pub node_frames: Vec<[[f64; 3]; 3]>,
    /// Position of each interface node in the coordinates of the model (m), where it is known.
    pub positions: Option<Vec<[f64; 3]>>,
    /// The bodies from outside; none of matrices.
    pub surface: Option<OuterSurface>,
    /// The interface with its law.
    pub interface: Interface,
    /// About the law of the whole interface, or of its first part.
    pub law: LawReport,
    /// About the law of each part of the interface; never empty.
    pub interfaces: Vec<PartReport>,
    /// Points whose gap was set from a negative value to zero.
    pub clipped_gaps: usize,
    /// Static state.
    pub prestress: PrestressResult,
    /// Linearised frequencies (Hz).
    pub frequencies: Vec<f64>,
    /// Backbones of the modes followed, in the scene's order; never empty.
    pub backbones: Vec<ModeBackbone>,
    /// Forced responses, level by level.
    pub forced: Vec<ForcedResponse>,
    /// The bodies deformed, if the scene asks for them.
    pub deformed: Option<Deformed>,
    /// Interface elements at the places of `cqsma.loops_at`, in their order, each once.
    pub loop_elements: Vec<usize>,
    /// Where and in which direction amplitudes are measured, in words.
    pub response: String,
    /// Pairs of interface nodes that were moved.
    pub moved_pairs: Option<MovedPairs>,
    /// Linear elements that were made quadratic.
    pub raised: Option<RaisedElements>,
    /// Files in the cache that let the run resume. Whoever has put the results in a safe place, or does not want to keep them,
    /// calls [`Checkpoints::remove`].
    pub checkpoints: Checkpoints,
}

/// The backbone of one mode.
#[derive(Clone, Debug)]
pub struct ModeBackbone {
    /// The mode, counted from 1.
    pub mode: usize,
    /// Amplitudes in ascending order.
    pub amplitudes: Vec<AmplitudeResult>,
    /// Results of the methods beside CQSMA, in the scene's order.
    pub methods: Vec<MethodResult>,
    /// Free periodic motions, if the scene asks for them.
    pub epmc: Option<EpmcBackbone>,
    /// Derivatives with respect to the parameters of the scene's `sensitivities`, in their order.
    pub sensitivities: Vec<Sensitivity>,
    /// Limits of the model.
    pub validity: Validity,
}

impl Run {
    /// The backbone of the first mode followed.
    pub fn first(&self) -> &ModeBackbone {
        &self.backbones[0]
    }

    /// Amplitudes of the first mode followed.
    pub fn amplitudes(&self) -> &[AmplitudeResult] {
        &self.first().amplitudes
    }

    /// Limits of the model for the first mode followed.
    pub fn validity(&self) -> &Validity {
        &self.first().validity
    }

    /// Without the reduced matrices, which are most of its memory, and which neither tables nor pictures need.
    #[must_use]
    pub fn without_matrices(mut self) -> Self {
        let reduced = &mut self.model.reduced;
        (reduced.mass, reduced.stiffness, reduced.recovery) = (Mat::new(), Mat::new(), Mat::new());
        self
    }
}

/// A scene with its structure reduced and its interface built: everything before the first nonlinear solve.
#[derive(Debug)]
pub struct Prepared {
    scene: Scene,
    options: Options,
    clearance: Option<f64>,
    response: String,
    moved_pairs: Option<MovedPairs>,
    raised: Option<RaisedElements>,
    overview: Overview,
    mesh: InterfaceMesh,
    frame: [[f64; 3]; 3],
    node_frames: Vec<[[f64; 3]; 3]>,
    positions: Option<Vec<[f64; 3]>>,
    surface: Option<OuterSurface>,
    model: StructuralModel,
    interface: SceneInterface,
    neighbours: Vec<Neighbours>,
    /// Derivatives that the scene asks for, which are the first of them.
    shown: usize,
    loop_elements: Vec<usize>,
    /// Parameters whose derivatives are differences of whole backbones.
    differenced: Vec<Parameter>,
    /// The structure, if its bodies are to be shown deformed, or if there are such derivatives.
    structure: Option<Structure>,
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
        return Err(joints::Error::NoSamples.into());
    }
    prepare(scene, options, progress)?.solve_ensemble(realisations, progress)
}

/// Builds and reduces the structure, and turns the surface into laws.
///
/// # Errors
/// Of the mesher, the finite elements, the reduction, the surface and the laws.
pub fn prepare(scene: &Scene, options: &Options, progress: &dyn Progress) -> Result<Prepared, Error> {
    prepare_on(scene, options, progress).map(|(_, prepared)| prepared)
}

/// As [`prepare`], with the structure.
pub(super) fn prepare_on(
    scene: &Scene,
    options: &Options,
    progress: &dyn Progress,
) -> Result<(Structure, Prepared), Error> {
    scene.validate(&scene.name)?;
    progress.begin(Stage::Mesh);
    let structure = Structure::try_new(scene, progress)?;
    end_stage(progress, Stage::Mesh)?;
    let overview = structure.overview(scene)?;
    overview.lines().iter().for_each(|line| progress.echo(line));
    for warning in warnings::of_input(&overview) {
        progress.warn(&warning.message);
    }
    let prepared = Prepared::try_new(scene, &structure, options, progress)?;
    Ok((structure, prepared))
}

/// Fields of a scene that its asperities follow from.
fn asperities_from(scene: &Scene) -> String {
    let own = |interface: &MeshInterface| interface.surface.is_some();
    let surface = match &scene.surface {
        _ if scene
            .structure
            .mesh()
            .is_some_and(|mesh| mesh.interfaces.iter().any(own)) =>
        {
            "structure.mesh.interfaces[].surface".to_owned()
        }
        Surface::Measured => "surface".to_owned(),
        Surface::Finish(_) => "surface.finish (ra and rsm)".to_owned(),
        surface => format!("surface.{}", choice_name(surface)),
    };
    match scene.scale == Scale::default() {
        true => surface,
        false => format!("{surface} with scale"),
    }
}

/// The field of a scene that its bolt loads follow from.
fn loads_from(scene: &Scene) -> &'static str {
    let bolts = &scene.bolts;
    match (&bolts.torque, bolts.torques.as_slice(), bolts.loads.as_slice()) {
        (Some(_), ..) => "bolts.torque",
        (None, [_, ..], _) => "bolts.torques",
        (None, [], [_, ..]) => "bolts.loads",
        (None, [], []) => "bolts.load",
    }
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
        // Bolts and places that do not fit are refused before the time for the reduction is spent.
        check_bolts(scene, structure.n_bolts())?;
        loop_elements(scene, structure)?;
        let model = structure.reduce(options, progress)?;
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
        check_bolts(scene, model.reduced.loads.len())?;
        go_on(progress)?;
        progress.begin(Stage::Characterise);
        let load = bolt_load(scene, &model);
        let stop = || progress.interrupted();
        let limits = Limits::default().until(&stop);
        let interface = SceneInterface::within(limits, scene, structure.interface(), &structure.joint.parts, load)?;
        interface.notes().for_each(|note| progress.note(&note));
        end_stage(progress, Stage::Characterise)?;
        let (neighbours, differenced) = Neighbours::of(scene, structure, &model, &interface, progress)?;
        Ok(Self {
            scene: scene.clone(),
            options: options.clone(),
            clearance: structure.joint.clearance,
            response: structure.joint.response.clone(),
            moved_pairs: structure.joint.moved_pairs(),
            raised: structure.joint.raised(),
            overview: structure.overview(scene)?,
            mesh: structure.interface().clone(),
            frame: structure.joint.frame,
            node_frames: structure.joint.node_frames.clone(),
            positions: structure.joint.positions.clone(),
            surface: OuterSurface::of(&structure.joint),
            model,
            interface,
            shown: scene.sensitivities.len(),
            neighbours,
            loop_elements: loop_elements(scene, structure)?,
            structure: (scene.output.deformed || !differenced.is_empty()).then(|| structure.clone()),
            differenced,
        })
    }

    /// Asks for derivatives with respect to further parameters, as far as they take no further reduction and the law has them. Results do not
    /// show them.
    ///
    /// # Errors
    /// Of the law beside the values of the scene.
    pub(super) fn differentiate_also(&mut self, parameters: &[Parameter]) -> Result<(), Error> {
        let others = parameters.iter().filter(|one| !self.scene.sensitivities.contains(one));
        let found = Neighbours::without_reduction(&self.scene, others, &self.interface)?;
        let names = found.iter().map(|neighbours| neighbours.parameter().clone());
        self.scene.sensitivities.extend(names);
        self.neighbours.extend(found);
        Ok(())
    }

    /// Prestress, modes and backbone of the scene itself, with the derivatives of its loops.
    ///
    /// # Errors
    /// As [`Solver::analyse`].
    pub(super) fn analyse_itself(
        &self,
        forces: Option<&[Vec<f64>]>,
        progress: &dyn Progress,
    ) -> Result<Analysis, Error> {
        let interface = &self.interface;
        self.solver()
            .analyse(&self.scene, &interface.interface, interface.closure, forces, progress)
    }

    /// Prestress, modes and backbone of the scene itself, with all its derivatives.
    ///
    /// # Errors
    /// As [`Solver::analyse`].
    pub(super) fn analyse_in_full(&self, progress: &dyn Progress) -> Result<Analysis, Error> {
        let mut analysis = self.analyse_itself(None, progress)?;
        let Some(structure) = self.structure.as_ref().filter(|_| !self.differenced.is_empty()) else {
            return Ok(analysis);
        };
        let parameters = self.differenced.clone();
        let study = Study::try_new(&self.scene, parameters, structure, self, &self.options)?;
        let (found, checkpoints) = finite_differences::sensitivities(&study, &analysis, progress)?;
        analysis.checkpoints.extend(checkpoints);
        let order = |one: &Sensitivity| {
            self.scene
                .sensitivities
                .iter()
                .position(|known| *known == one.parameter)
        };
        for (mode, found) in analysis.modes.iter_mut().zip(found) {
            mode.sensitivities.extend(found);
            mode.sensitivities.sort_by_key(order);
        }
        Ok(analysis)
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
        load_of(&self.model.reduced, &tensions(&self.model, &self.scene))
    }

    /// The guess that prestress starts from: a uniform closure that carries the bolt load (m).
    pub fn start(&self) -> Vec<f64> {
        uniform(&self.model.reduced, self.interface.closure)
    }

    /// Prestress, modes and backbone.
    ///
    /// # Errors
    /// [`Error::Prestress`] and defects of the linear structure.
    pub fn solve(self, progress: &dyn Progress) -> Result<Run, Error> {
        let analysis = self.analyse_in_full(progress)?;
        let deformed = self.deformed(&analysis, progress)?;
        Ok(self.finish(analysis, deformed, progress))
    }

    /// As [`Prepared::solve`], and then the backbones of `realisations` bootstrap realisations of all elements' laws on
    /// the same reduced structure. With a cache, realisations of an interrupted ensemble are taken from there.
    ///
    /// # Errors
    /// As [`Prepared::solve`]; [`joints::Error::NoSamples`] for surfaces that are not scanned; an interruption. Whatever else
    /// ends a realisation is part of the result.
    pub fn solve_ensemble(self, realisations: usize, progress: &dyn Progress) -> Result<(Run, Ensemble), Error> {
        let mut analysis = self.analyse_in_full(progress)?;
        let (ensemble, checkpoints) = self.ensemble(realisations, &analysis, progress)?;
        analysis.checkpoints.extend(checkpoints);
        let deformed = self.deformed(&analysis, progress)?;
        Ok((self.finish(analysis, deformed, progress), ensemble))
    }

    /// The bodies deformed, if the scene asks for them.
    pub(super) fn deformed(&self, analysis: &Analysis, progress: &dyn Progress) -> Result<Option<Deformed>, Error> {
        let Some(structure) = self.structure.as_ref().filter(|_| self.scene.output.deformed) else {
            return Ok(None);
        };
        progress.note("the structure is factored again, to find displacements of the bodies");
        Deformed::new(structure, &self.model, self.scene.bolts.behaviour, analysis).map(Some)
    }

    fn ensemble(
        &self,
        realisations: usize,
        analysis: &Analysis,
        progress: &dyn Progress,
    ) -> Result<(Ensemble, Checkpoints), Error> {
        progress.begin(Stage::Ensemble);
        // Fields, other methods and other modes are left to the measured law.
        let scene = ensemble::loops_alone(&self.scene, false);
        let load = bolt_load(&scene, &self.model);
        let checkpoint = match kept(&scene, &self.options)? {
            None => Checkpoint::default(),
            Some((directory, mut key)) => {
                // Whatever else the realisations depend on has left its mark in the measured backbone.
                key.numbers(analysis.prestress.solution.displacement.iter().copied());
                key.numbers(analysis.frequencies.iter().copied());
                Checkpoint::open(directory, "ensemble", &key.finish())
            }
        };
        let realisations = ensemble::Batch {
            name: "realisations",
            number: realisations,
            loops: scene.cqsma.amplitudes.max(1),
            progress,
        };
        let solver = Solver {
            neighbours: &[],
            ..self.solver()
        };
        let analyse = |k, progress: &dyn Progress| {
            let (interface, closure) = self.interface.realisation(k, load)?;
            solver.analyse(&scene, &interface, closure, None, progress)
        };
        let describe = |k, found: Result<&Analysis, Error>| Member::new(k, found, scene.background_damping);
        let (members, checkpoints) = realisations.run(checkpoint, analyse, describe)?;
        progress.end(Stage::Ensemble);
        Ok((Ensemble::new(members, &analysis.modes[0].amplitudes), checkpoints))
    }

    pub(super) fn finish(mut self, analysis: Analysis, deformed: Option<Deformed>, progress: &dyn Progress) -> Run {
        self.scene.sensitivities.truncate(self.shown);
        let Analysis {
            prestress,
            frequencies,
            modes,
            forced,
            checkpoints,
        } = analysis;
        let asperities = self.interface.asperities();
        let shown = |mut all: Vec<Sensitivity>| {
            all.truncate(self.shown);
            all
        };
        let judge = |found: ModeAnalysis| ModeBackbone {
            validity: validity::assess(
                &self.interface.interface,
                asperities.as_ref(),
                self.scene.model.material.as_ref(),
                self.interface
                    .report()
                    .resolved
                    .as_ref()
                    .and_then(|law| law.onset_of_yield),
                self.scene.law.yielding(),
                &prestress.fields,
                self.clearance,
                found.separation,
                &found.amplitudes,
            ),
            mode: found.mode,
            amplitudes: found.amplitudes,
            methods: found.methods,
            epmc: found.epmc.map(|epmc| EpmcBackbone {
                sensitivities: shown(epmc.sensitivities),
                ..epmc
            }),
            sensitivities: shown(found.sensitivities),
        };
        let backbones: Vec<ModeBackbone> = modes.into_iter().map(judge).collect();
        let found = self.findings(&prestress, &frequencies, backbones.first().map(|first| &first.validity));
        let of_results = warnings::of_results(&self.overview, &found);
        of_results.iter().for_each(|warning| progress.warn(&warning.message));
        let mut warnings = warnings::of_input(&self.overview);
        warnings.extend(of_results);
        Run {
            backbones,
            warnings,
            overview: self.overview,
            frequencies,
            forced,
            prestress,
            law: self.interface.report().clone(),
            interfaces: self.interface.reports,
            clipped_gaps: self.interface.clipped_gaps,
            interface: self.interface.interface,
            mesh: self.mesh,
            frame: self.frame,
            node_frames: self.node_frames,
            positions: self.positions,
            surface: self.surface,
            model: self.model,
            deformed,
            loop_elements: self.loop_elements,
            response: self.response,
            moved_pairs: self.moved_pairs,
            raised: self.raised,
            scene: self.scene,
            checkpoints,
        }
    }

    /// What warnings judge.
    fn findings(&self, prestress: &PrestressResult, frequencies: &[f64], validity: Option<&Validity>) -> Findings {
        let pressures = &prestress.fields.traction[2];
        let hardness = self
            .scene
            .model
            .material
            .and_then(|material| material.hardness)
            .map(Stress::si);
        let operators = self.interface.interface.operators();
        let above = pressures.iter().zip(&operators.weights);
        let above = above.filter(|(pressure, _)| hardness.is_some_and(|hardness| **pressure > hardness));
        Findings {
            hardness,
            peak_pressure: pressures.iter().copied().fold(0.0, f64::max),
            share_above_hardness: above.map(|(_, weight)| weight).sum::<f64>() / operators.area(),
            yielded_asperities: validity.and_then(|validity| validity.yielded_asperity_fraction),
            in_contact: validity.map_or(1.0, |validity| validity.contact_area_fraction_by_points),
            first_frequency: frequencies.first().copied(),
            contact_circles: validity.and_then(|validity| {
                Some(ContactCircles {
                    ratio: validity.beyond_contact_formulas()?,
                    limit: LARGEST_CONTACT,
                    share: validity.pressure_share_within_formulas,
                    surface: asperities_from(&self.scene),
                    load: loads_from(&self.scene),
                })
            }),
        }
    }

    /// Stiffness over the jump of the contact under the bolt loads with everything in contact stuck, symmetrised (N/m).
    ///
    /// # Errors
    /// [`Error::Prestress`] and defects of the linear structure.
    pub fn stuck_tangent(&self, progress: &dyn Progress) -> Result<CsMat<f64>, Error> {
        let (scene, interface) = (&self.scene, &self.interface);
        let solver = self.solver();
        let prestress = solver.static_state(scene, &interface.interface, interface.closure, progress)?;
        let locked = solver.locked(scene)?;
        let vibrating = locked.as_ref().unwrap_or(&self.model.reduced);
        let force = InterfaceForce::new(&interface.interface);
        let line = linearise(scene, vibrating, &force, &prestress.solution)?;
        let (pattern, n) = (interface.interface.pattern(), interface.interface.n_dofs());
        let indices = (pattern.indptr.clone(), pattern.indices.clone());
        Ok(CsMat::new((n, n), indices.0, indices.1, line.stuck_tangent().to_vec()))
    }

    /// What solves need of it.
    pub(super) fn solver(&self) -> Solver<'_> {
        Solver {
            model: &self.model,
            options: &self.options,
            loop_elements: &self.loop_elements,
            neighbours: &self.neighbours,
        }
    }
}

/// What the nonlinear solves need beside a scene and its interface.
#[derive(Clone, Copy)]
pub(super) struct Solver<'a> {
    pub(super) model: &'a StructuralModel,
    /// Where checkpoints of loops are kept.
    pub(super) options: &'a Options,
    /// Elements at `cqsma.loops_at`.
    pub(super) loop_elements: &'a [usize],
    /// What backbones are differentiated with respect to: what the scene's `sensitivities` name.
    pub(super) neighbours: &'a [Neighbours],
}

impl Solver<'_> {
    /// Equilibrium of an interface under the bolt loads, of which `closure` carries them (m).
    pub(super) fn static_state(
        &self,
        scene: &Scene,
        interface: &Interface,
        closure: f64,
        progress: &dyn Progress,
    ) -> Result<PrestressResult, Error> {
        let reduced = &self.model.reduced;
        progress.begin(Stage::Prestress);
        let start = uniform(reduced, closure);
        let assembled = assembled(scene, interface);
        let (tensions, newton) = (tensions(self.model, scene), newton_settings(scene));
        let prestress = match &scene.bolts.tightening {
            None => {
                let load = load_of(reduced, &tensions);
                let solution = prestress::solve(reduced, &assembled, &load, &start, &newton)?;
                let bolts = bolt_load(scene, self.model);
                prestress::checked(reduced, &assembled, solution, &load, tensions, bolts)?
            }
            Some(plan) => {
                let told = |done| progress.fraction(Stage::Prestress, done);
                let jump = &start[..reduced.n_relative];
                let (solution, found) = tighten(reduced, &assembled, &tensions, plan, jump, &newton, &told)?;
                let tensions = found.residual_preloads.clone();
                let bolts = closing(reduced)
                    .zip(&tensions)
                    .map(|(one, tension)| tension * one)
                    .sum();
                let load = load_of(reduced, &tensions);
                let mut checked = prestress::checked(reduced, &assembled, solution, &load, tensions, bolts)?;
                checked.tightening = Some(found);
                checked
            }
        };
        end_stage(progress, Stage::Prestress)?;
        Ok(prestress)
    }

    /// The reduced structure with locked bolts, if they are so in vibration.
    pub(super) fn locked(&self, scene: &Scene) -> Result<Option<ReducedModel>, Error> {
        Ok(match scene.bolts.behaviour {
            BoltBehaviour::DeadLoad => None,
            BoltBehaviour::Locked => Some(self.model.reduced.locked()?),
        })
    }

    /// Prestress, modes and backbones of an interface, of which `closure` carries the bolt load (m). `forces` are modal forces of
    /// each mode followed that stand for those by the amplitudes of the scene.
    pub(super) fn analyse(
        &self,
        scene: &Scene,
        interface: &Interface,
        closure: f64,
        forces: Option<&[Vec<f64>]>,
        progress: &dyn Progress,
    ) -> Result<Analysis, Error> {
        let reduced = &self.model.reduced;
        let force = InterfaceForce::new(interface);
        let newton = newton_settings(scene);
        let prestress = self.static_state(scene, interface, closure, progress)?;
        let static_load = load_of(reduced, &prestress.tensions);

        progress.begin(Stage::Modes);
        let locked = self.locked(scene)?;
        let vibrating = locked.as_ref().unwrap_or(reduced);
        let stop = || progress.interrupted();
        let mut line = linearise(scene, vibrating, &force, &prestress.solution)?;
        line.limits = line.limits.until(&stop);
        let sensitivities = match self.neighbours {
            [] => None,
            neighbours => Some(Sensitivities::try_new(
                neighbours,
                reduced,
                &assembled(scene, interface),
                &prestress.solution,
            )?),
        };
        end_stage(progress, Stage::Modes)?;
        progress.begin(Stage::Backbone);
        let followed = scene.cqsma.followed();
        let response = response(vibrating);
        let recorded = element_loops::recorded(
            &scene.cqsma,
            scene.fields_at().len(),
            interface.operators().n_elements(),
            self.loop_elements,
        );
        if recorded.len() < interface.operators().n_elements() {
            progress.note(&format!(
                "the loops of all elements would take more than {} MB; only those at cqsma.loops_at are kept",
                element_loops::MOST_RECORDED / 1_000_000
            ));
        }
        let mut modes = Vec::with_capacity(followed.len());
        let mut checkpoints = Checkpoints::default();
        for (place, mode) in followed.iter().enumerate() {
            let request = backbone::Request {
                scene,
                force: &force,
                reduced,
                vibrating,
                prestress: &prestress,
                line: &line,
                response: &response,
                static_load: &static_load,
                mass: self.model.facts.mass,
                mode: mode - 1,
                newton,
                recorded: &recorded,
                sensitivities: sensitivities.as_ref(),
                forces: forces.and_then(|forces| forces.get(place)),
            };
            let key = kept(scene, self.options)?;
            let share = |done: f64| (place as f64 + done) / followed.len() as f64;
            let (found, resume) = request.run(key, &share, progress)?;
            modes.push(found);
            checkpoints.extend(resume);
        }
        progress.end(Stage::Backbone);

        let request = periodic::Request {
            scene,
            force: &force,
            vibrating,
            line: &line,
        };
        let free: Vec<_> = modes
            .iter()
            .filter_map(|mode: &ModeAnalysis| mode.epmc.as_ref())
            .collect();
        let forced = match &scene.forced {
            Some(settings) => {
                let key = kept(scene, self.options)?;
                let (found, resume) = request.forced(settings, &free, key, progress)?;
                checkpoints.extend(resume);
                found
            }
            None => Vec::new(),
        };

        let frequencies = line.frequencies();
        drop(line);
        Ok(Analysis {
            prestress,
            frequencies,
            modes,
            forced,
            checkpoints,
        })
    }
}

/// Tension of each bolt in a scene (N).
fn tensions(model: &StructuralModel, scene: &Scene) -> Vec<f64> {
    let bolts = 0..model.reduced.loads.len();
    bolts.map(|bolt| scene.tension(bolt)).collect()
}

/// What all loops of a scene depend on.
///
/// # Errors
/// A scene that cannot be written.
fn key(scene: &Scene, options: &Options) -> Result<KeyBuilder, Error> {
    let mut key = KeyBuilder::new(options.build.as_deref());
    key.text(&scene.encoded()?.to_string());
    Ok(key)
}

/// Where loops of a scene are kept, if they are, and their key.
pub(super) fn kept<'a>(scene: &Scene, options: &'a Options) -> Result<Option<(&'a Path, KeyBuilder)>, Error> {
    let folder = options.cache.as_deref();
    folder.map(|folder| Ok((folder, key(scene, options)?))).transpose()
}

/// Refuses loads and orders of other bolts than there are.
pub(super) fn check_bolts(scene: &Scene, bolts: usize) -> Result<(), Error> {
    let given = scene.bolts.loads.len();
    if given > 0 && given != bolts {
        return Err(Error::BoltLoads { given, bolts });
    }
    if let Some(plan) = &scene.bolts.tightening {
        plan.check_bolts(bolts)?;
    }
    Ok(())
}

/// The interface elements at the places of `cqsma.loops_at`.
fn loop_elements(scene: &Scene, structure: &Structure) -> Result<Vec<usize>, Error> {
    let positions = structure.joint.positions.as_deref();
    element_loops::elements_at(&scene.cqsma.loops_at, structure.interface(), positions)
}

/// The interface while the bolts are tightened.
fn assembled<'a>(scene: &Scene, interface: &'a Interface) -> InterfaceForce<'a> {
    match scene.bolts.assembly {
        Assembly::WithFriction => InterfaceForce::new(interface),
        Assembly::Frictionless => InterfaceForce::frictionless(interface),
    }
}

pub(super) fn newton_settings(scene: &Scene) -> NewtonSettings {
    NewtonSettings {
        tolerance: scene.cqsma.tolerance,
        ..NewtonSettings::default()
    }
}
