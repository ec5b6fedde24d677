//! Prestress, modes and backbones of an interface on a reduced structure.

use super::backbone::{self, uniform};
use super::connections::Connection;
use super::element_loops;
use super::linearised::Linearised;
use super::outcome::{Analysis, Vibration};
use super::prestress::{self, PrestressResult, closing, closing_force, linearise, load_of, response};
use super::sensitivities::{Neighbours, Sensitivities};
use super::tightening::{TighteningResult, tighten};
use super::walks::{AtRest, Beside, Walks};
use crate::Error;
use cqsma_solver::{HystereticForce, NewtonSettings};
use dense_algebra::Limits;
use joints::interface::{InterfaceForce, SceneInterface};
use joints::progress::{Progress, Quiet, Stage, end_stage};
use joints::store::Options;
use joints::store::checkpoint::Checkpoints;
use joints::store::key::KeyBuilder;
use joints::structure::StructuralModel;
use reduction::ReducedModel;
use scenes::{Assembly, BoltBehaviour, Scene};
use std::path::Path;
use zte_assembly::Interface;

/// What the nonlinear solves need beside a scene and its interface.
#[derive(Clone, Copy)]
pub(super) struct Solver<'a> {
    pub(super) model: &'a StructuralModel,
    /// Where checkpoints of loops are kept.
    pub(super) options: &'a Options,
    /// Elements at `analyses.backbone.loops_at`.
    pub(super) loop_elements: &'a [usize],
    /// Connections whose motions and forces are found.
    pub(super) connections: &'a [Connection],
    /// What backbones are differentiated with respect to: what the scene's `sensitivities` name.
    pub(super) neighbours: &'a [Neighbours],
    /// Interfaces with another number of a setting, if errors of loops are to be estimated.
    pub(super) beside: Option<&'a [Beside]>,
}

impl<'a> Solver<'a> {
    /// Without loops of elements, derivatives and errors.
    pub(super) fn of(model: &'a StructuralModel, options: &'a Options) -> Self {
        Self {
            model,
            options,
            loop_elements: &[],
            connections: &[],
            neighbours: &[],
            beside: None,
        }
    }
}

impl Solver<'_> {
    /// Equilibrium of an interface under the bolt loads, of which `closure` carries them (m).
    pub(super) fn static_state(
        &self,
        scene: &Scene,
        interface: &Interface,
        closure: f64,
        progress: &dyn Progress,
    ) -> Result<(PrestressResult, Option<TighteningResult>), Error> {
        let reduced = &self.model.reduced;
        progress.begin(Stage::Prestress);
        let start = uniform(reduced, closure);
        let assembled = assembled(scene, interface);
        let (tensions, newton) = (tensions(self.model, scene), newton_settings(scene));
        let told = |done| progress.fraction(Stage::Prestress, done);
        let found = match &scene.analyses.tightening {
            None => {
                let load = load_of(reduced, &tensions);
                let stop = || progress.interrupted();
                let limits = Limits::default().until(&stop).heard_by(&told);
                let solution = prestress::solve(reduced, &assembled, &load, &start, (&newton, limits))?;
                let bolts = closing_force(scene, self.model);
                let checked = prestress::checked(reduced, &assembled, solution, &load, tensions, bolts)?;
                (checked, None)
            }
            Some(plan) => {
                let jump = &start[..reduced.n_relative];
                let (solution, found) = tighten(reduced, &assembled, &tensions, plan, jump, &newton, &told)?;
                let tensions = found.residual_preloads.clone();
                let bolts = closing(reduced)
                    .zip(&tensions)
                    .map(|(one, tension)| tension * one)
                    .sum();
                let load = load_of(reduced, &tensions);
                let checked = prestress::checked(reduced, &assembled, solution, &load, tensions, bolts)?;
                (checked, Some(found))
            }
        };
        end_stage(progress, Stage::Prestress)?;
        Ok(found)
    }

    /// An interface whose laws follow its pressures at rest, where it has such laws. One without a static state stays as it is: what needs the
    /// state says why there is none.
    ///
    /// # Errors
    /// An interruption; of the laws.
    pub(super) fn settled(
        &self,
        scene: &Scene,
        interface: SceneInterface,
        progress: &dyn Progress,
    ) -> Result<SceneInterface, Error> {
        if !interface.follows_rest() {
            return Ok(interface);
        }
        match self.static_state(scene, &interface.interface, interface.closure, &Quiet(progress)) {
            Ok((found, _)) => Ok(interface.about(&found.fields.traction[2])?),
            Err(error) if error.is_interruption() => Err(error),
            Err(_) => Ok(interface),
        }
    }

    /// Static states of the interfaces with another number of a setting; none of one that has none.
    ///
    /// # Errors
    /// An interruption.
    fn at_rest(&self, scene: &Scene, progress: &dyn Progress) -> Result<Vec<Option<PrestressResult>>, Error> {
        let quiet = Quiet(progress);
        let of = |beside: &Beside| {
            let Some(other) = &beside.interface else {
                return Ok(None);
            };
            match self.static_state(scene, &other.interface, other.closure, &quiet) {
                Ok((found, _)) => Ok(Some(found)),
                Err(error) if error.is_interruption() => Err(error),
                Err(_) => Ok(None),
            }
        };
        self.beside.unwrap_or_default().iter().map(of).collect()
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
        let (prestress, tightening) = self.static_state(scene, interface, closure, progress)?;
        let static_load = load_of(reduced, &prestress.tensions);

        progress.begin(Stage::Modes);
        let locked = self.locked(scene)?;
        let vibrating = locked.as_ref().unwrap_or(reduced);
        let stop = || progress.interrupted();
        let mut line = linearise(scene, vibrating, &force, &prestress.solution)?;
        line.limits = line.limits.until(&stop);
        line.dampers = self.model.dampers(vibrating);
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
        let rests = self.at_rest(scene, progress)?;
        let walks = self.beside.map(|beside| Walks {
            own: AtRest::new(interface, &prestress),
            beside: beside
                .iter()
                .zip(&rests)
                .map(|(one, rest)| (one.dial, one.at_rest(rest.as_ref())))
                .collect(),
        });
        let followed = &scene.analyses.modes.followed;
        let response = response(vibrating);
        let about = Linearised {
            scene,
            force: &force,
            vibrating,
            line: &line,
            response: &response,
            facts: &self.model.facts,
        };
        let recorded = element_loops::recorded(
            &scene.analyses,
            scene.fields_at().len(),
            interface.operators().n_elements(),
            self.loop_elements,
        );
        if recorded.len() < interface.operators().n_elements() {
            progress.note(&format!(
                "the loops of all elements would take more than {} MB; only those at analyses.backbone.loops_at are kept",
                element_loops::MOST_RECORDED / 1_000_000
            ));
        }
        let mut modes = Vec::with_capacity(followed.len());
        let mut checkpoints = Checkpoints::default();
        for (place, mode) in followed.iter().enumerate() {
            let request = backbone::Request {
                about,
                reduced,
                prestress: &prestress,
                static_load: &static_load,
                mass: self.model.facts.mass,
                mode: mode - 1,
                newton,
                recorded: &recorded,
                connections: self.connections,
                sensitivities: sensitivities.as_ref(),
                forces: forces.and_then(|forces| forces.get(place)),
                walks: walks.as_ref(),
            };
            let key = kept(scene, self.options)?;
            let share = |done: f64| (place as f64 + done) / followed.len() as f64;
            let (found, resume) = request.run(key, &share, progress)?;
            modes.push(found);
            checkpoints.extend(resume);
        }
        progress.end(Stage::Backbone);

        let vibration = Vibration::of(about, &modes, kept(scene, self.options)?, &mut checkpoints, progress)?;
        let frequencies = line.frequencies();
        let nodes = interface
            .points_of_laws()
            .map(|points| interface.operators().nodes_of(points));
        let of_interfaces: Vec<_> = nodes.map(|nodes| 3 * nodes.start..3 * nodes.end).collect();
        let by_interface = (0..frequencies.len())
            .map(|mode| line.by_stiffness(force.pattern(), mode, of_interfaces.iter().cloned()))
            .collect();
        let flexibility_bytes = line.preconditioner_bytes();
        drop(line);
        Ok(Analysis {
            prestress,
            tightening,
            frequencies,
            by_interface,
            flexibility_bytes,
            modes,
            vibration,
            checkpoints,
        })
    }
}

/// Tension of each bolt in a scene (N).
pub(super) fn tensions(model: &StructuralModel, scene: &Scene) -> Vec<f64> {
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

/// The interface while the bolts are tightened.
fn assembled<'a>(scene: &Scene, interface: &'a Interface) -> InterfaceForce<'a> {
    match scene.bolts.assembly {
        Assembly::WithFriction => InterfaceForce::new(interface),
        Assembly::Frictionless => InterfaceForce::frictionless(interface),
    }
}

pub(super) fn newton_settings(scene: &Scene) -> NewtonSettings {
    NewtonSettings {
        tolerance: scene.analyses.backbone.tolerance,
        ..NewtonSettings::default()
    }
}
