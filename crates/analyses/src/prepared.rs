//! A scene before its first nonlinear solve: the structure reduced, the interface with its laws.

use super::backbone::uniform;
use super::comparison::Experiment;
use super::connections::Connection;
use super::costs;
use super::deformed::Deformed;
use super::element_loops;
use super::error_bar::ErrorBar;
use super::joint_info::JointInfo;
use super::outcome::Analysis;
use super::prestress::{closing_force, linearise, load_of};
use super::sensitivities::Neighbours;
use super::shock;
use super::solver::{Solver, tensions};
use super::walks::{self, Beside};
use super::warnings;
use crate::Error;
use dense_algebra::Limits;
use joint_model::InterfacePart;
use joints::interface::{InterfaceForce, PartReport, SceneInterface};
use joints::progress::{Progress, Silent, Stage, Within, end_stage, go_on};
use joints::store::Options;
use joints::structure::{StructuralModel, Structure};
use modal_identification::signal::Quantity;
use scenes::{Parameter, Scene};
use sprs::CsMat;
use zte_assembly::InterfaceMesh;

/// A scene with its structure reduced and its interface built: everything before the first nonlinear solve.
#[derive(Debug)]
pub struct Prepared {
    pub(super) scene: Scene,
    pub(super) options: Options,
    pub(super) joint: JointInfo,
    pub(super) model: StructuralModel,
    pub(super) interface: SceneInterface,
    /// About the law of each part of the interface.
    pub(super) reports: Vec<PartReport>,
    /// The mesh of the interface and its parts.
    faces: (InterfaceMesh, Vec<InterfacePart>),
    pub(super) derivatives: Derivatives,
    pub(super) loop_elements: Vec<usize>,
    /// The parts of the interface by bolt.
    pub(super) connections: Vec<Connection>,
    /// Measured backbones, over displacement.
    pub(super) measured: Vec<Experiment>,
    /// The structure, if its bodies are to be shown deformed, its mesh's error is to be estimated, or if there are such derivatives.
    pub(super) structure: Option<Structure>,
}

/// What backbones are differentiated with respect to.
#[derive(Debug)]
pub(super) struct Derivatives {
    /// Laws beside that of the scene.
    neighbours: Vec<Neighbours>,
    /// Derivatives that the scene asks for, which are the first of them.
    pub(super) shown: usize,
    /// Parameters whose derivatives are differences of whole backbones.
    pub(super) differenced: Vec<Parameter>,
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
    check_inputs(scene)?;
    let structure = mesh(scene, progress)?;
    let prepared = Prepared::try_new(scene, &structure, options, progress)?;
    Ok((structure, prepared))
}

/// Meshes the structure of a scene and tells what it is.
///
/// # Errors
/// Of the mesher.
pub(super) fn mesh(scene: &Scene, progress: &dyn Progress) -> Result<Structure, Error> {
    progress.begin(Stage::Mesh);
    let structure = Structure::try_new(scene, progress)?;
    end_stage(progress, Stage::Mesh)?;
    let overview = structure.overview(scene)?;
    overview.lines().iter().for_each(|line| progress.echo(line));
    for warning in warnings::of_input(&overview) {
        progress.warn(&warning.message);
    }
    costs::expect(scene, &structure, progress);
    Ok(structure)
}

/// Refuses files beside the structure that cannot be used, before any time is spent.
pub(super) fn check_inputs(scene: &Scene) -> Result<(), Error> {
    scene.analyses.shock.as_ref().map_or(Ok(()), shock::check)?;
    measured(scene).map(drop)
}

/// The measured backbones of a scene, over displacement.
fn measured(scene: &Scene) -> Result<Vec<Experiment>, Error> {
    let paths = scene.analyses.backbone.measured.iter();
    paths
        .map(|path| Experiment::read(path)?.over(Quantity::Displacement))
        .collect()
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
        let load = closing_force(scene, &model);
        let (mesh, parts) = (structure.interface(), &structure.joint.parts);
        let interface = SceneInterface::within((options, progress), scene, mesh, parts, load)?;
        interface.notes().for_each(|note| progress.note(&note));
        let interface = Solver::of(&model, options).settled(scene, interface, progress)?;
        let reports = interface.reports()?;
        end_stage(progress, Stage::Characterise)?;
        let (neighbours, differenced) = Neighbours::of(scene, structure, &model, &interface, progress)?;
        let connections = Connection::all(&structure.joint, interface.interface.operators());
        Ok(Self {
            scene: scene.clone(),
            options: options.clone(),
            joint: JointInfo::of(scene, structure)?,
            model,
            interface,
            reports,
            faces: (structure.interface().clone(), structure.joint.parts.clone()),
            loop_elements: loop_elements(scene, structure)?,
            connections,
            measured: measured(scene)?,
            structure: (scene.output.deformed || !differenced.is_empty() || ErrorBar::is_estimated(scene))
                .then(|| structure.clone()),
            derivatives: Derivatives {
                shown: scene.analyses.sensitivities.len(),
                neighbours,
                differenced,
            },
        })
    }

    /// Asks for derivatives with respect to further parameters, as far as they take no further reduction and the law has them. Results do not
    /// show them.
    ///
    /// # Errors
    /// Of the law beside the values of the scene.
    pub(super) fn differentiate_also(&mut self, parameters: &[Parameter]) -> Result<(), Error> {
        let others = parameters
            .iter()
            .filter(|one| !self.scene.analyses.sensitivities.contains(one));
        let found = Neighbours::without_reduction(&self.scene, others, &self.interface)?;
        let names = found.iter().map(|neighbours| neighbours.parameter().clone());
        self.scene.analyses.sensitivities.extend(names);
        self.derivatives.neighbours.extend(found);
        Ok(())
    }

    /// Prestress, modes and backbone of the scene itself, with the derivatives of its loops, and their errors where there are interfaces `beside`.
    ///
    /// # Errors
    /// As [`Solver::analyse`].
    pub(super) fn analyse_itself(
        &self,
        forces: Option<&[Vec<f64>]>,
        beside: Option<&[Beside]>,
        progress: &dyn Progress,
    ) -> Result<Analysis, Error> {
        let interface = &self.interface;
        let solver = Solver {
            beside,
            ..self.solver()
        };
        solver.analyse(&self.scene, &interface.interface, interface.closure, forces, progress)
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

    /// The bodies deformed, if the scene asks for them.
    pub(super) fn deformed(&self, analysis: &Analysis, within: &Within<'_>) -> Result<Option<Deformed>, Error> {
        let Some(structure) = self.structure.as_ref().filter(|_| self.scene.output.deformed) else {
            return Ok(None);
        };
        within.note("the structure is factored again, to find displacements of the bodies");
        let (stop, hear) = (|| within.interrupted(), |done| within.done(done));
        let limits = Limits::default().until(&stop).heard_by(&hear);
        Deformed::new(structure, &self.model, &self.scene, analysis, &self.options, limits).map(Some)
    }

    /// Stiffness over the jump of the contact under the bolt loads with everything in contact stuck, symmetrised (N/m).
    ///
    /// # Errors
    /// [`Error::Prestress`] and defects of the linear structure.
    pub fn stuck_tangent(&self, progress: &dyn Progress) -> Result<CsMat<f64>, Error> {
        let (scene, interface) = (&self.scene, &self.interface);
        let solver = self.solver();
        let (prestress, _) = solver.static_state(scene, &interface.interface, interface.closure, progress)?;
        let locked = solver.locked(scene)?;
        let vibrating = locked.as_ref().unwrap_or(&self.model.reduced);
        let force = InterfaceForce::new(&interface.interface);
        let line = linearise(scene, vibrating, &force, &prestress.solution)?;
        let (pattern, n) = (interface.interface.pattern(), interface.interface.n_dofs());
        let indices = (pattern.indptr.clone(), pattern.indices.clone());
        Ok(CsMat::new((n, n), indices.0, indices.1, line.stuck_tangent().to_vec()))
    }

    /// The interfaces with another number of each setting of its law, if there are loops whose errors are to be estimated.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn beside(&self, progress: &dyn Progress) -> Result<Option<Vec<Beside>>, Error> {
        if self.scene.analyses.backbone.amplitudes == 0 {
            return Ok(None);
        }
        progress.begin(Stage::Comparisons);
        let load = closing_force(&self.scene, &self.model);
        let (mesh, parts) = &self.faces;
        let own = (&self.interface, walks::bins(&self.reports));
        let settled = |scene: &Scene, other| self.solver().settled(scene, other, &Silent).ok();
        let told = |done| {
            progress.fraction(Stage::Comparisons, done);
            Ok(go_on(progress)?)
        };
        let found = walks::beside(&self.scene, (mesh, parts), own, load, settled, &told)?;
        end_stage(progress, Stage::Comparisons)?;
        Ok(Some(found))
    }

    /// What solves need of it.
    pub(super) fn solver(&self) -> Solver<'_> {
        Solver {
            loop_elements: &self.loop_elements,
            connections: &self.connections,
            neighbours: &self.derivatives.neighbours,
            ..Solver::of(&self.model, &self.options)
        }
    }
}

/// Refuses loads and orders of other bolts than there are.
pub(super) fn check_bolts(scene: &Scene, bolts: usize) -> Result<(), Error> {
    let given = scene.bolts.loads.len();
    if given > 0 && given != bolts {
        return Err(Error::BoltLoads { given, bolts });
    }
    if let Some(plan) = &scene.analyses.tightening {
        plan.check_bolts(bolts)?;
    }
    Ok(())
}

/// The interface elements at the places of `analyses.backbone.loops_at`.
fn loop_elements(scene: &Scene, structure: &Structure) -> Result<Vec<usize>, Error> {
    let positions = structure.joint.positions.as_deref();
    element_loops::elements_at(&scene.analyses.backbone.loops_at, structure.interface(), positions)
}
