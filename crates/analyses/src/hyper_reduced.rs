//! Cases on one structure that learn from some of them: loops over few coordinates and from few points of contact.

use super::backbone::Request;
use super::cases::{CaseMode, CasePoint, CaseStructure, ErrorBounds};
use super::linearised::Linearised;
use super::observer::ResponseMotion;
use super::prestress::{linearise, load_of, response};
use super::solver::newton_settings;
use super::variants::VariantPoint;
use crate::Error;
use cqsma_solver::cqsma;
use cqsma_solver::{BackbonePoint, LoopObserver, LoopResult};
pub use hyper_reduction::ErrorEstimate;
use hyper_reduction::{
    HyperReducedJoint, JudgedLoop, LoopRecord, Recorder, Settings, StaticState, Trained, TrainingMode, train,
};
use joints::interface::{InterfaceForce, SceneInterface};
use joints::progress::Progress;
use scenes::Scene;
use std::f64::consts::TAU;
use zte_assembly::Workspace;

/// Most amplitudes of a mode of a case that are learned from.
const TRAINING_AMPLITUDES: usize = 12;

/// What a case teaches: its modes with their loops.
#[derive(Clone, Debug)]
pub struct TrainingCase {
    modes: Vec<TrainingMode>,
}

/// What cases on one structure have learned, mode by mode.
#[derive(Debug)]
pub struct Training {
    /// Of each mode, counted from 1, what was learned, or why nothing was.
    modes: Vec<(usize, Result<Trained, hyper_reduction::Error>)>,
}

impl Training {
    /// Of each mode, counted from 1, the coordinates beside it, the points that stand for all, and how many these are; or why nothing was learned,
    /// so that it is left to the whole joint.
    pub fn sizes(&self) -> impl Iterator<Item = (usize, Result<[usize; 3], &hyper_reduction::Error>)> {
        let sizes = |mode: &Trained| [mode.basis.ncols(), mode.points.points.len(), mode.of_points];
        self.modes
            .iter()
            .map(move |(mode, learned)| (*mode, learned.as_ref().map(sizes)))
    }
}

impl CaseStructure {
    /// The backbones of a case as [`CaseStructure::backbones`] has them, to the last bit, and what they teach.
    ///
    /// # Errors
    /// As there.
    pub fn training_case(
        &self,
        case: &Scene,
        interface: &SceneInterface,
        progress: &dyn Progress,
    ) -> Result<(Vec<CaseMode>, TrainingCase), Error> {
        let one = |request: &Request<'_>| {
            let interface = request.about.force.interface();
            let at_rest = StaticState::new(interface, request.about.line);
            let (loading, settings) = (request.loading()?, request.settings());
            let number = loading.forces.len();
            // Some of the amplitudes, the last among them.
            let is_recorded = |at: usize| {
                number <= TRAINING_AMPLITUDES
                    || (at + 1) * TRAINING_AMPLITUDES / number > at * TRAINING_AMPLITUDES / number
            };
            let recorder = || Recorder::new(interface, &at_rest, settings.vertices_per_quarter);
            let observer = |at| TrainingObserver {
                recorder: is_recorded(at).then(recorder),
                motion: ResponseMotion::new(request.about.response),
            };
            let found = cqsma::run(
                request.about.line,
                request.about.force,
                &loading.forces,
                &settings,
                observer,
            )?;
            let (mut records, mut quiet): (Vec<LoopRecord>, usize) = (Vec::new(), 0);
            let amplitudes = found.into_iter().map(|(point, taught)| {
                let motion = taught.motion.half_range();
                let is_resolved = point.result.as_ref().is_ok_and(LoopResult::is_resolved);
                match taught.recorder {
                    Some(recorder) if is_resolved => records.push(recorder.finish()),
                    Some(_) => quiet += 1,
                    None => {}
                }
                found_point(request.background(), &point, loading.response, motion, None)
            });
            let mode = case_mode(request, amplitudes.collect());
            let training_case =
                TrainingMode::try_new(request.about.line, at_rest.clone(), request.mode, records, quiet)?;
            Ok((mode, training_case))
        };
        let (modes, training_cases) = self.on_modes(case, interface, progress, one)?.into_iter().unzip();
        Ok((modes, TrainingCase { modes: training_cases }))
    }

    /// What is learned from training_cases of cases on this structure, in their order; `case` and its `interface` are those of one of them.
    ///
    /// # Errors
    /// Of the structure with locked bolts.
    pub fn train(
        &self,
        case: &Scene,
        interface: &SceneInterface,
        training_cases: Vec<TrainingCase>,
    ) -> Result<Training, Error> {
        let locked = self.solver().locked(case)?;
        let vibrating = locked.as_ref().unwrap_or(&self.model().reduced);
        let followed = &case.analyses.modes.followed;
        let mut of_modes: Vec<Vec<TrainingMode>> = followed.iter().map(|_| Vec::new()).collect();
        for training_case in training_cases {
            of_modes
                .iter_mut()
                .zip(training_case.modes)
                .for_each(|(all, mode)| all.push(mode));
        }
        let stiffness = vibrating.stiffness.as_ref();
        let modes = followed.iter().zip(&of_modes).map(|(mode, training_cases)| {
            let learned = train(&interface.interface, stiffness, training_cases, &Settings::default());
            (*mode, learned)
        });
        Ok(Training { modes: modes.collect() })
    }

    /// The backbones of a case by what was learned. Loops with estimated errors beyond what is borne are computed with the whole joint, and so are
    /// those that do not converge.
    ///
    /// # Errors
    /// As [`CaseStructure::backbones`]; [`Error::HyperReduction`] for a training on another interface, or without a mode that the case follows.
    pub fn backbones_by(
        &self,
        training: &Training,
        borne: ErrorBounds,
        case: &Scene,
        interface: &SceneInterface,
        progress: &dyn Progress,
    ) -> Result<Vec<CaseMode>, Error> {
        let one = |request: &Request<'_>| {
            let mode = request.mode + 1;
            let learned = training.modes.iter().find(|(own, _)| *own == mode);
            let (_, learned) = learned.ok_or(hyper_reduction::Error::Mode { mode })?;
            let amplitudes = request.loops_by(learned.as_ref().ok(), borne)?;
            Ok(case_mode(request, amplitudes))
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
        let reduced = &self.model().reduced;
        let (prestress, _) = solver.static_state(case, &interface.interface, interface.closure, progress)?;
        let static_load = load_of(reduced, &prestress.tensions);
        let locked = solver.locked(case)?;
        let vibrating = locked.as_ref().unwrap_or(reduced);
        let force = InterfaceForce::new(&interface.interface);
        let mut line = linearise(case, vibrating, &force, &prestress.solution)?;
        line.dampers = self.model().dampers(vibrating);
        let response = response(vibrating);
        let about = Linearised {
            scene: case,
            force: &force,
            vibrating,
            line: &line,
            response: &response,
            facts: &solver.model.facts,
        };
        let followed = &case.analyses.modes.followed;
        let requests = followed.iter().map(|mode| Request {
            about,
            reduced,
            prestress: &prestress,
            static_load: &static_load,
            mass: solver.model.facts.mass,
            mode: mode - 1,
            newton: newton_settings(case),
            connections: &[],
            recorded: &[],
            sensitivities: None,
            forces: None,
            walks: None,
        });
        let requests: Vec<_> = requests.collect();
        requests.iter().map(one).collect()
    }
}

impl Request<'_> {
    /// Loops by what was learned, and those of the whole joint where that is not enough.
    fn loops_by(&self, learned: Option<&Trained>, borne: ErrorBounds) -> Result<Vec<Result<CasePoint, String>>, Error> {
        use cqsma_solver::Error::Interrupted;
        use hyper_reduction::Error::Solver;
        let (loading, settings) = (self.loading()?, self.settings());
        let found = match learned {
            None => None,
            Some(trained) => {
                let joint =
                    HyperReducedJoint::try_new(self.about.force.interface(), self.about.line, self.mode, trained)?;
                match joint.run(&loading.forces, &settings, self.about.response) {
                    // A reduced structure without modes is no defect of the case.
                    Err(Solver(error)) if !matches!(error, Interrupted) => None,
                    found => Some(found?),
                }
            }
        };
        let by_few: Vec<Option<JudgedLoop>> = match found {
            Some(found) => found.into_iter().map(Some).collect(),
            None => loading.forces.iter().map(|_| None).collect(),
        };
        let is_within = |estimate: &ErrorEstimate| estimate.is_within(borne.frequency, borne.damping);
        let refused = by_few.iter().zip(&loading.forces);
        let estimate_of =
            |found: &Option<JudgedLoop>| found.as_ref().and_then(|found| found.estimate).filter(is_within);
        let refused = refused.filter(|(found, _)| estimate_of(found).is_none());
        let refused: Vec<f64> = refused.map(|(_, force)| *force).collect();
        let whole = |_| ResponseMotion::new(self.about.response);
        let mut of_whole = cqsma::run(self.about.line, self.about.force, &refused, &settings, whole)?.into_iter();
        let points = by_few.iter().filter_map(|found| match (found, estimate_of(found)) {
            (Some(found), Some(estimate)) => {
                let (point, motion) = (&found.point, found.response_motion);
                Some(found_point(
                    self.background(),
                    point,
                    loading.response,
                    motion,
                    Some(estimate),
                ))
            }
            _ => {
                let (point, motion) = of_whole.next()?;
                Some(found_point(
                    self.background(),
                    &point,
                    loading.response,
                    motion.half_range(),
                    None,
                ))
            }
        });
        Ok(points.collect())
    }
}

fn case_mode(request: &Request<'_>, amplitudes: Vec<Result<CasePoint, String>>) -> CaseMode {
    CaseMode {
        mode: request.mode + 1,
        linear_frequency_hz: request.about.line.eigenvalues[request.mode].max(0.0).sqrt() / TAU,
        background: request.background(),
        amplitudes,
    }
}

/// An amplitude of a case, with its damping ratio apart from friction; a mass-normalised motion moves the response point by `response`.
fn found_point(
    background: f64,
    point: &BackbonePoint,
    response: f64,
    response_motion: f64,
    estimate: Option<ErrorEstimate>,
) -> Result<CasePoint, String> {
    let result = point.result.as_ref().map_err(|failure| failure.reason.to_string())?;
    let displacement = result.modal_amplitude * response.abs();
    Ok(CasePoint {
        point: VariantPoint::of(result, displacement, response_motion, background),
        estimate,
    })
}

/// Hears of a loop that is learned from.
struct TrainingObserver<'a> {
    recorder: Option<Recorder<'a>>,
    motion: ResponseMotion<'a>,
}

impl LoopObserver<Workspace> for TrainingObserver<'_> {
    fn begin(&mut self) {
        if let Some(recorder) = &mut self.recorder {
            recorder.begin();
        }
        self.motion.begin();
    }

    fn vertex(&mut self, modal_force: f64, displacement: &[f64], workspace: &Workspace) {
        if let Some(recorder) = &mut self.recorder {
            recorder.vertex(modal_force, displacement, workspace);
        }
        self.motion.vertex(modal_force, displacement, workspace);
    }
}
