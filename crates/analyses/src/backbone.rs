//! The backbone of one mode: hysteresis loops over amplitudes, and the methods beside CQSMA.

use super::amplitude::{AmplitudeResult, LoopFields};
use super::connections::Connection;
use super::error_bar::ErrorBar;
use super::linearised::Linearised;
use super::methods;
use super::mode_backbone::ModeAnalysis;
use super::observer::{Stored, Watcher};
use super::prestress::PrestressResult;
use super::sensitivities::Sensitivities;
use super::walks::{self, Walks};
use crate::Error;
use cqsma_solver::cqsma::{self, Cycles, Settings};
use cqsma_solver::sensitivity::Derivatives;
use cqsma_solver::{BackbonePoint, NewtonSettings};
use dense_algebra::SystemMatrix;
use joints::interface::InterfaceForce;
use joints::progress::{Amplitude, Progress, Stage};
use joints::store::checkpoint::{Checkpoint, Checkpoints};
use joints::store::key::KeyBuilder;
use reduction::ReducedModel;
use scenes::{Length, Scene};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Modes that move the response point less than this share of a rigid motion cannot be scaled by its amplitude.
const LEAST_PARTICIPATION: f64 = 1e-2;

/// Stiffness against a uniform separation, relative to the sum of the stiffnesses of its coordinates, that is round-off.
const FREE_OF_ENERGY: f64 = 1e-9;

/// Inertia of a mode along a uniform separation, relative to that of the separation itself, that is round-off.
const FREE_OF_INERTIA: f64 = 1e-9;

/// Periodic motions where neither their amplitudes nor those of loops are given.
const EPMC_AMPLITUDES: usize = 20;

/// Changes whenever [`LoopFields`] holds something else, so that lines of another layout are not taken for finished amplitudes.
const LAYOUT: u64 = 7;

/// What came of an amplitude.
type Loop = (BackbonePoint, Option<LoopFields>);

/// Amplitudes that are done.
type Finished = Checkpoint<Loop>;

/// What the backbone of a mode starts from.
pub(super) struct Request<'a> {
    pub(super) about: Linearised<'a>,
    /// The structure under prestress.
    pub(super) reduced: &'a ReducedModel,
    pub(super) prestress: &'a PrestressResult,
    /// Static load on the reduced coordinates (N).
    pub(super) static_load: &'a [f64],
    /// Mass of the structure (kg), if it is known.
    pub(super) mass: Option<f64>,
    /// Index of the mode, from 0.
    pub(super) mode: usize,
    pub(super) newton: NewtonSettings,
    /// Elements whose loops are stored, ascending.
    pub(super) recorded: &'a [usize],
    /// Connections whose motions and forces are found.
    pub(super) connections: &'a [Connection],
    /// What derivatives start from, if the scene asks for any.
    pub(super) sensitivities: Option<&'a Sensitivities<'a>>,
    /// Modal forces (sqrt(kg) m/s^2) that stand for those by the amplitudes of the scene.
    pub(super) forces: Option<&'a Vec<f64>>,
    /// What errors of settings are estimated with, if they are.
    pub(super) walks: Option<&'a Walks<'a>>,
}

/// The loads of the loops of a mode.
pub(super) struct Loading {
    /// Mass-normalised shape of the mode.
    pub(super) shape: Vec<f64>,
    /// What it moves the response point by.
    pub(super) response: f64,
    /// Modal forces (sqrt(kg) m/s^2).
    pub(super) forces: Vec<f64>,
}

impl<'a> Request<'a> {
    /// Damping ratio of the mode apart from friction.
    pub(super) fn background(&self) -> f64 {
        self.about.background(self.mode)
    }

    /// Loops at all amplitudes, and the other methods, with what lets the run resume until its results are safe. `key` is the folder of checkpoints and what all loops of the run
    /// depend on; `share` maps the part of this backbone that is done to that of all backbones.
    ///
    /// # Errors
    /// [`Error::NoResponse`]; an interruption.
    pub(super) fn run(
        &self,
        key: Option<(&Path, KeyBuilder)>,
        share: &(dyn Fn(f64) -> f64 + Sync),
        progress: &dyn Progress,
    ) -> Result<(ModeAnalysis, Checkpoints), Error> {
        let Loading {
            shape,
            response: phi,
            forces,
        } = self.loading()?;
        let omega2 = self.about.line.eigenvalues[self.mode];
        let settings = self.settings();
        let epmc_key = key.clone();
        let finished = match key {
            Some((directory, key)) => self.finished(directory, key, &shape, &forces, progress),
            None => Finished::default(),
        };
        let derivatives = match self.sensitivities {
            Some(sensitivities) => Some((
                sensitivities,
                sensitivities.of_mode(self.about.line, self.about.force, self.mode)?,
            )),
            None => None,
        };
        let along = derivatives.as_ref().map(|(_, derivatives)| derivatives);
        let (done, checkpoints) = self.loops(finished, (&forces, phi), &settings, along, share, progress)?;
        let sensitivities = derivatives
            .as_ref()
            .map_or_else(Vec::new, |(sensitivities, derivatives)| {
                let loops = done.iter().map(|(point, _)| point.result.as_ref().ok());
                sensitivities.of_loops(derivatives, (&shape, omega2), self.about.response, loops)
            });
        let amplitude = |(point, fields): Loop| {
            let result = point.result.as_ref().ok();
            let motion = result.map(|r| (r.modal_amplitude * phi.abs(), r.omega));
            AmplitudeResult {
                fields,
                response_acceleration: motion.map(|(x, omega)| x * omega * omega),
                response_displacement: motion.map(|(x, _)| x),
                error: None,
                point,
            }
        };
        let methods = methods::Request {
            about: self.about,
            reduced: self.reduced,
            prestress: &self.prestress.solution,
            modal_forces: &forces,
            settings: &settings,
        };
        let mut checkpoints = checkpoints;
        let epmc = match &self.about.scene.analyses.epmc {
            None => None,
            Some(settings) => {
                let amplitudes = displacements(self.about.scene, EPMC_AMPLITUDES)
                    .iter()
                    .map(|x| x / phi.abs())
                    .collect();
                let (mut found, resume) = self.about.epmc(settings, self.mode, amplitudes, epmc_key, progress)?;
                checkpoints.extend(resume);
                if let Some((sensitivities, derivatives)) = &derivatives {
                    found.sensitivities = sensitivities.of_motions(
                        derivatives,
                        self.about.line,
                        self.about.force,
                        (&shape, self.about.response),
                        &found.points,
                    );
                }
                Some(found)
            }
        };
        let analysis = ModeAnalysis {
            sensitivities,
            epmc,
            mode: self.mode + 1,
            background: self.background(),
            separation: self.separation(&shape),
            truncation: walks::of_modes(self.about.vibrating, &shape, omega2),
            amplitudes: done.into_iter().map(amplitude).collect(),
            methods: methods.run(progress)?,
        };
        Ok((analysis, checkpoints))
    }

    /// What is loaded, and how.
    ///
    /// # Errors
    /// [`Error::NoResponse`].
    pub(super) fn loading(&self) -> Result<Loading, Error> {
        let shape: Vec<f64> = self.about.line.shapes.col(self.mode).iter().copied().collect();
        let response: f64 = shape.iter().zip(self.about.response).map(|(a, b)| a * b).sum();
        self.check_response(response)?;
        let omega2 = self.about.line.eigenvalues[self.mode];
        let by_amplitude = || {
            displacements(self.about.scene, 0)
                .into_iter()
                .map(|x| omega2 * x / response)
        };
        let forces = self.forces.cloned().unwrap_or_else(|| by_amplitude().collect());
        Ok(Loading {
            shape,
            response,
            forces,
        })
    }

    /// Refuses a mode of which amplitudes at the response point say nothing; `phi` is its response.
    fn check_response(&self, phi: f64) -> Result<(), Error> {
        let participation = phi.abs() / self.largest_response();
        if participation < LEAST_PARTICIPATION {
            return Err(Error::NoResponse {
                mode: self.mode + 1,
                frequency: self.about.line.frequencies()[self.mode],
                participation,
            });
        }
        Ok(())
    }

    /// What a mass-normalised mode moves the response point by if that takes part as in a rigid motion; where the mass is
    /// not known, the most that any of the modes moves it by.
    fn largest_response(&self) -> f64 {
        let moved = |shape: faer::ColRef<'_, f64>| {
            let terms = shape.iter().zip(self.about.response);
            terms.map(|(a, b)| a * b).sum::<f64>().abs()
        };
        match self.mass {
            Some(mass) => mass.sqrt().recip(),
            None => self
                .about
                .line
                .shapes
                .col_iter()
                .map(moved)
                .fold(f64::MIN_POSITIVE, f64::max),
        }
    }

    pub(super) fn settings(&self) -> Settings {
        let cqsma = &self.about.scene.analyses.backbone;
        Settings {
            mode: self.mode,
            vertices_per_quarter: cqsma.vertices_per_quarter,
            cycles: match (cqsma.cycles, cqsma.until_closed, Cycles::default()) {
                (Some(n), ..) => Cycles::Fixed(n),
                (None, Some(tolerance), Cycles::UntilClosed { most, .. }) => Cycles::UntilClosed { tolerance, most },
                (None, _, default) => default,
            },
            commit: cqsma.commit,
            newton: self.newton,
            ..Settings::default()
        }
    }

    /// Finished amplitudes of an earlier, interrupted run of the same loops.
    fn finished(
        &self,
        directory: &Path,
        mut key: KeyBuilder,
        shape: &[f64],
        forces: &[f64],
        progress: &dyn Progress,
    ) -> Finished {
        // Whatever else the loops depend on has left its mark in the static state or the mode.
        key.numbers(self.about.line.displacement().iter().copied());
        key.numbers(shape.iter().copied());
        key.numbers(forces.iter().copied());
        let random = self.about.scene.analyses.random.is_some();
        key.integers([LAYOUT, u64::from(self.walks.is_some()), u64::from(random)]);
        let finished = Finished::open(directory, "loops", &key.finish());
        let (found, all) = (finished.n_finished(), forces.len());
        if found > 0 {
            progress.note(&format!(
                "{found} of {all} amplitudes were taken from an interrupted run"
            ));
        }
        finished
    }

    /// All loops in ascending order of amplitude; a mode moves the response point by `phi`.
    fn loops(
        &self,
        finished: Finished,
        (forces, phi): (&[f64], f64),
        settings: &Settings,
        derivatives: Option<&Derivatives<'_, InterfaceForce<'a>>>,
        share: &(dyn Fn(f64) -> f64 + Sync),
        progress: &dyn Progress,
    ) -> Result<(Vec<Loop>, Checkpoints), Error> {
        let pending: Vec<usize> = (0..forces.len()).filter(|i| !finished.holds(*i)).collect();
        let pending_forces: Vec<f64> = pending.iter().map(|&i| forces[i]).collect();
        let scene = self.about.scene;
        let stored = scene.fields_at();
        let estimates_mesh = self.walks.is_some() && ErrorBar::is_estimated(scene);
        let tell = |point: &BackbonePoint| {
            if let Ok(found) = &point.result {
                progress.amplitude(&Amplitude {
                    mode: self.mode + 1,
                    amplitude_m: found.modal_amplitude * phi.abs(),
                    frequency_hz: found.omega / TAU,
                    damping_ratio: found.is_resolved().then_some(found.zeta + scene.background_damping),
                });
            }
        };
        finished.values().for_each(|(point, _)| tell(point));
        let count = AtomicUsize::new(0);
        // Loops of large amplitudes take up to twice as long as those of small ones.
        let cost = |index: usize| forces.len() + index;
        let all: usize = pending.iter().map(|index| cost(*index)).sum();
        let finish = |index: usize, point: &BackbonePoint, fields: Option<&LoopFields>| {
            finished.add(index, (point, fields));
            tell(point);
            let done = count.fetch_add(cost(index), Ordering::Relaxed) + cost(index);
            progress.fraction(Stage::Backbone, share(done as f64 / all as f64));
            if progress.interrupted() {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let watch = |at: usize| {
            let index = pending[at];
            let elements = stored.contains(&(index + 1)).then_some(self.recorded);
            let stored = Stored {
                elements,
                displacement: estimates_mesh || (elements.is_some() && scene.output.deformed),
                motions: scene.analyses.random.is_some(),
            };
            Watcher::new(
                self.about.force.interface(),
                &self.prestress.fields,
                self.about.response,
                index,
                stored,
                self.connections,
                self.walks,
                &finish,
            )
        };
        let points = match derivatives {
            Some(derivatives) => cqsma::run_differentiated(
                self.about.line,
                self.about.force,
                &pending_forces,
                settings,
                derivatives,
                watch,
            )?,
            None => cqsma::run(self.about.line, self.about.force, &pending_forces, settings, watch)?,
        };
        let points: Vec<_> = points
            .into_iter()
            .map(|(point, watcher)| (point, watcher.fields))
            .collect();
        let (mut done, checkpoints) = finished.complete();
        done.extend(pending.iter().copied().zip(points));
        Ok((done.into_values().collect(), checkpoints))
    }

    /// Modal force at which the inertia of a mode pulls a vibrating structure apart as much as the bolt loads hold it
    /// together.
    fn separation(&self, shape: &[f64]) -> Option<f64> {
        let (vibrating, load) = (self.about.vibrating, self.static_load);
        let apart = uniform(vibrating, 1.0);
        let normals = || (2..vibrating.n_relative).step_by(3);
        let along = |matrix: &SystemMatrix, left: &[f64]| -> f64 {
            let mut forces = vec![0.0; left.len()];
            matrix.as_ref().multiply(left, &mut forces);
            normals().map(|j| forces[j]).sum()
        };
        let diagonal = vibrating.stiffness.as_ref().diagonal();
        let stiffnesses: f64 = normals().map(|j| diagonal[j]).sum();
        if along(&vibrating.stiffness, &apart) > FREE_OF_ENERGY * stiffnesses {
            return None;
        }
        // Modes that are antisymmetric in it have no inertia along it but round-off.
        let inertia = along(&vibrating.mass, shape).abs();
        let all = along(&vibrating.mass, &apart).max(0.0).sqrt();
        let holds = normals().map(|j| load[j]).sum::<f64>() / inertia;
        (inertia > FREE_OF_INERTIA * all).then_some(holds)
    }
}

/// A uniform jump along the normal (m), over the reduced coordinates.
pub(super) fn uniform(reduced: &ReducedModel, closure: f64) -> Vec<f64> {
    let mut jump = vec![0.0; reduced.size()];
    jump[2..reduced.n_relative]
        .iter_mut()
        .step_by(3)
        .for_each(|u| *u = closure);
    jump
}

/// Displacements at the response point that the modal forces are chosen for, by linear estimate (m); `otherwise` is their number where
/// the scene asks for no loops.
fn displacements(scene: &Scene, otherwise: usize) -> Vec<f64> {
    let c = &scene.analyses.backbone;
    let count = if c.amplitudes == 0 { otherwise } else { c.amplitudes };
    let [from, to] = [c.amplitude_from, c.amplitude_to].map(Length::si);
    let ratio = (to / from).ln();
    let last = count.saturating_sub(1).max(1) as f64;
    (0..count).map(|i| from * (ratio * i as f64 / last).exp()).collect()
}
