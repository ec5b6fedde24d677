//! Cases on one structure that learn from some of them: loops over few coordinates and from few points of contact.

use super::backbone::Request;
use super::cases::{CaseMode, CasePoint, CaseStructure};
use super::prestress::{linearise, load_of, response};
use super::run::newton_settings;
use super::variants::VariantPoint;
use crate::Error;
use crate::interface::{InterfaceForce, SceneInterface};
use crate::progress::Progress;
use crate::scene::Scene;
use cqsma_solver::cqsma;
use cqsma_solver::{BackbonePoint, LoopObserver, LoopResult};
pub use hyper_reduction::ErrorEstimate;
use hyper_reduction::{HyperReducedJoint, LoopRecord, Recorder, Settings, StaticState, Trained, TrainingMode, train};
use std::f64::consts::TAU;
use zte_assembly::State;

/// Largest relative errors of results that are borne.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorneErrors {
    /// Of the frequency.
    pub frequency: f64,
    /// Of the damping ratio.
    pub damping: f64,
}

/// What a case teaches: its modes with their loops.
#[derive(Clone, Debug)]
pub struct Lesson {
    modes: Vec<TrainingMode>,
}

/// What cases on one structure have learned, mode by mode.
#[derive(Clone, Debug)]
pub struct Training {
    modes: Vec<Trained>,
}

impl Training {
    /// Of each mode the coordinates beside it, the points that stand for all, and how many these are.
    pub fn sizes(&self) -> impl Iterator<Item = [usize; 3]> {
        let sizes = |mode: &Trained| [mode.basis.ncols(), mode.points.points.len(), mode.of_points];
        self.modes.iter().map(sizes)
    }
}

impl CaseStructure {
    /// The backbones of a case as [`CaseStructure::backbones`] has them, to the last bit, and what they teach.
    ///
    /// # Errors
    /// As there.
    pub fn lesson(
        &self,
        case: &Scene,
        interface: &SceneInterface,
        progress: &dyn Progress,
    ) -> Result<(Vec<CaseMode>, Lesson), Error> {
        let one = |request: &Request<'_>| {
            let interface = request.force.interface();
            let at_rest = StaticState::new(interface, request.line);
            let loading = request.loading()?;
            let observer = |_| Taught {
                recorder: Recorder::new(interface, &at_rest),
                motion: ResponseMotion::new(request.response),
            };
            let found = cqsma::run(
                request.line,
                request.force,
                &loading.forces,
                &request.settings(),
                observer,
            )?;
            let mut records: Vec<LoopRecord> = Vec::new();
            let amplitudes = found.into_iter().map(|(point, taught)| {
                let motion = taught.motion.half_range();
                if point.result.as_ref().is_ok_and(LoopResult::is_resolved) {
                    records.push(taught.recorder.finish());
                }
                found_point(case, &point, loading.response, motion, None)
            });
            let mode = case_mode(request, amplitudes.collect());
            let lesson = TrainingMode::try_new(request.line, at_rest.clone(), request.mode, records)?;
            Ok((mode, lesson))
        };
        let (modes, lessons) = self.on_modes(case, interface, progress, one)?.into_iter().unzip();
        Ok((modes, Lesson { modes: lessons }))
    }

    /// What is learned from lessons of cases on this structure; `case` and its `interface` are those of one of them.
    ///
    /// # Errors
    /// [`Error::HyperReduction`] where nothing can be learned.
    pub fn train(&self, case: &Scene, interface: &SceneInterface, lessons: Vec<Lesson>) -> Result<Training, Error> {
        let locked = self.solver().locked(case)?;
        let vibrating = locked.as_ref().unwrap_or(self.reduced());
        let mut of_modes: Vec<Vec<TrainingMode>> = case.cqsma.followed().iter().map(|_| Vec::new()).collect();
        for lesson in lessons {
            of_modes
                .iter_mut()
                .zip(lesson.modes)
                .for_each(|(all, mode)| all.push(mode));
        }
        let stiffness = vibrating.stiffness.as_ref();
        let modes = of_modes
            .iter()
            .map(|modes| train(&interface.interface, stiffness, modes, &Settings::default()));
        Ok(Training {
            modes: modes.collect::<Result<_, _>>()?,
        })
    }

    /// The backbones of a case by what was learned. Loops with estimated errors beyond what is borne are computed with the whole joint, and so are
    /// those that do not converge.
    ///
    /// # Errors
    /// As [`CaseStructure::backbones`]; [`Error::HyperReduction`] for a training on another interface.
    pub fn backbones_by(
        &self,
        training: &Training,
        borne: BorneErrors,
        case: &Scene,
        interface: &SceneInterface,
        progress: &dyn Progress,
    ) -> Result<Vec<CaseMode>, Error> {
        let mut trained = training.modes.iter();
        let one = |request: &Request<'_>| {
            let found = match trained.next() {
                Some(trained) => request.loops_by(case, trained, borne)?,
                None => Vec::new(),
            };
            Ok(case_mode(request, found))
        };
        self.on_modes(case, interface, progress, one)
    }

    /// What the modes of a case make of its static state.
    fn on_modes<R>(
        &self,
        case: &Scene,
        interface: &SceneInterface,
        progress: &dyn Progress,
        one: impl FnMut(&Request<'_>) -> Result<R, Error>,
    ) -> Result<Vec<R>, Error> {
        let solver = self.solver();
        let reduced = self.reduced();
        let prestress = solver.static_state(case, &interface.interface, interface.closure, progress)?;
        let static_load = load_of(reduced, &prestress.tensions);
        let locked = solver.locked(case)?;
        let vibrating = locked.as_ref().unwrap_or(reduced);
        let force = InterfaceForce::new(&interface.interface);
        let line = linearise(case, vibrating, &force, &prestress.solution)?;
        let response = response(vibrating);
        let followed = case.cqsma.followed();
        let requests = followed.iter().map(|mode| Request {
            scene: case,
            force: &force,
            reduced,
            vibrating,
            prestress: &prestress,
            line: &line,
            response: &response,
            static_load: &static_load,
            mass: solver.model.facts.mass,
            mode: mode - 1,
            newton: newton_settings(case),
            recorded: &[],
            sensitivities: None,
            forces: None,
        });
        let requests: Vec<_> = requests.collect();
        requests.iter().map(one).collect()
    }
}

impl Request<'_> {
    /// Loops by what was learned, and those of the whole joint where that is not enough.
    fn loops_by(
        &self,
        case: &Scene,
        trained: &Trained,
        borne: BorneErrors,
    ) -> Result<Vec<Result<CasePoint, String>>, Error> {
        let (loading, settings) = (self.loading()?, self.settings());
        let joint = HyperReducedJoint::try_new(self.force.interface(), self.line, self.mode, trained)?;
        let by_few = joint.run(&loading.forces, &settings, self.response)?;
        let is_within = |estimate: &ErrorEstimate| estimate.is_within(borne.frequency, borne.damping);
        let refused = by_few.iter().zip(&loading.forces);
        let refused = refused.filter(|(found, _)| !found.estimate.as_ref().is_some_and(is_within));
        let refused: Vec<f64> = refused.map(|(_, force)| *force).collect();
        let whole = |_| ResponseMotion::new(self.response);
        let mut of_whole = cqsma::run(self.line, self.force, &refused, &settings, whole)?.into_iter();
        let points = by_few
            .iter()
            .filter_map(|found| match found.estimate.filter(is_within) {
                Some(estimate) => {
                    let motion = found.response_motion;
                    Some(found_point(
                        case,
                        &found.point,
                        loading.response,
                        motion,
                        Some(estimate),
                    ))
                }
                None => {
                    let (point, motion) = of_whole.next()?;
                    Some(found_point(case, &point, loading.response, motion.half_range(), None))
                }
            });
        Ok(points.collect())
    }
}

fn case_mode(request: &Request<'_>, amplitudes: Vec<Result<CasePoint, String>>) -> CaseMode {
    CaseMode {
        mode: request.mode + 1,
        linear_frequency_hz: request.line.eigenvalues[request.mode].max(0.0).sqrt() / TAU,
        amplitudes,
    }
}

/// An amplitude of a case; a mass-normalised motion moves the response point by `response`.
fn found_point(
    case: &Scene,
    point: &BackbonePoint,
    response: f64,
    response_motion: f64,
    estimate: Option<ErrorEstimate>,
) -> Result<CasePoint, String> {
    let result = point.result.as_ref().map_err(|failure| failure.reason.to_string())?;
    let displacement = result.modal_amplitude * response.abs();
    Ok(CasePoint {
        point: VariantPoint::of(result, displacement, response_motion, case.background_damping),
        estimate,
    })
}

/// Range of the displacement at the response point along a loop.
struct ResponseMotion<'a> {
    response: &'a [f64],
    range: [f64; 2],
}

impl<'a> ResponseMotion<'a> {
    fn new(response: &'a [f64]) -> Self {
        Self {
            response,
            range: [f64::INFINITY, f64::NEG_INFINITY],
        }
    }

    fn half_range(&self) -> f64 {
        0.5 * (self.range[1] - self.range[0])
    }
}

impl LoopObserver<State> for ResponseMotion<'_> {
    fn begin(&mut self) {
        *self = Self::new(self.response);
    }

    fn vertex(&mut self, _: f64, displacement: &[f64], _: &State) {
        let motion: f64 = displacement.iter().zip(self.response).map(|(u, r)| u * r).sum();
        self.range = [self.range[0].min(motion), self.range[1].max(motion)];
    }
}

/// Hears of a loop that is learned from.
struct Taught<'a> {
    recorder: Recorder<'a>,
    motion: ResponseMotion<'a>,
}

impl LoopObserver<State> for Taught<'_> {
    fn begin(&mut self) {
        self.recorder.begin();
        self.motion.begin();
    }

    fn vertex(&mut self, modal_force: f64, displacement: &[f64], begin: &State) {
        self.recorder.vertex(modal_force, displacement, begin);
        self.motion.vertex(modal_force, displacement, begin);
    }
}
