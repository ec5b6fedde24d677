//! The methods beside CQSMA, at the same amplitudes of the same mode about the same static state.

use super::linearised::Linearised;
use crate::Error;
use cqsma_solver::loading::{self, LoadingPoint};
use cqsma_solver::newton::Effort;
use cqsma_solver::prestress::Prestress;
use cqsma_solver::{Failure, NoObserver, cqsma, masing, modes, rqnma};
use joints::interface::InterfaceForce;
use joints::progress::{Progress, Stage};
use rayon::prelude::*;
use reduction::ReducedModel;
use scenes::Method;
use zte_assembly::State;

/// The backbone of one method.
#[derive(Clone, Debug)]
pub struct MethodResult {
    /// Method.
    pub method: Method,
    /// Amplitudes in ascending order.
    pub points: Vec<MethodPoint>,
}

/// One amplitude.
#[derive(Clone, Debug)]
pub struct MethodPoint {
    /// The result, or why there is none.
    pub result: Result<MethodValues, Failure>,
    /// Work done.
    pub effort: Effort,
}

/// What a method says at one amplitude.
#[derive(Clone, Copy, Debug)]
pub struct MethodValues {
    /// Modal force `alpha = omega^2 q` (sqrt(kg) m/s^2).
    pub modal_force: f64,
    /// Modal amplitude `q` (sqrt(kg) m).
    pub modal_amplitude: f64,
    /// Secant frequency (rad/s).
    pub omega: f64,
    /// Frequency of the first harmonic (rad/s); that of methods without loops belongs to the loop by Masing's rule.
    pub harmonic_omega: f64,
    /// Damping ratio due to friction; none where it may be noise.
    pub zeta: Option<f64>,
    /// Damping ratios up to this one may be noise.
    pub zeta_floor: f64,
    /// Residual relative to the load (energy norm).
    pub residual: f64,
    /// Displacement amplitude at the response point (m): of RQNMA by the shape found, else by that of the linear mode.
    pub response_displacement: f64,
}

/// What the methods start from.
pub(super) struct Request<'a> {
    pub(super) about: Linearised<'a>,
    pub(super) reduced: &'a ReducedModel,
    pub(super) prestress: &'a Prestress<State>,
    pub(super) modal_forces: &'a [f64],
    pub(super) settings: &'a cqsma::Settings,
}

impl Request<'_> {
    /// Runs what the scene asks for.
    pub(super) fn run(&self, progress: &dyn Progress) -> Result<Vec<MethodResult>, Error> {
        type Run<'r> = fn(&Request<'r>) -> Result<Vec<MethodPoint>, Error>;
        let run_of = |&method: &Method| {
            let run: Run<'_> = match method {
                Method::Qsma => Self::qsma,
                Method::Masing => Self::masing,
                Method::Rqnma => Self::rqnma,
            };
            (method, run)
        };
        let methods: Vec<_> = self.about.scene.analyses.backbone.methods.iter().map(run_of).collect();
        if methods.is_empty() {
            return Ok(Vec::new());
        }
        progress.begin(Stage::Methods);
        let results = methods
            .par_iter()
            .map(|&(method, run)| {
                Ok(MethodResult {
                    method,
                    points: run(self)?,
                })
            })
            .collect();
        progress.end(Stage::Methods);
        results
    }

    fn qsma(&self) -> Result<Vec<MethodPoint>, Error> {
        let Prestress {
            displacement, state, ..
        } = self.prestress;
        let jump = &displacement[..self.about.force.interface().n_dofs()];
        let (linear, state) = self.about.force.interface().linearised(jump, state)?;
        self.loops(&InterfaceForce::new(&linear), state)
    }

    /// Loops about the static state with another force.
    fn loops(&self, force: &InterfaceForce<'_>, state: State) -> Result<Vec<MethodPoint>, Error> {
        let (stiffness, mass) = (self.reduced.stiffness.as_ref(), self.reduced.mass.as_ref());
        let n_modes = self.about.line.eigenvalues.len();
        let displacement = self.prestress.displacement.clone();
        let mut line = modes::linearise(stiffness, mass, force, displacement, state, n_modes)?;
        line.orient(self.about.response)?;
        line.limits = self.about.line.limits;
        let points = cqsma::run(&line, force, self.modal_forces, self.settings, |_| NoObserver)?;
        let points = points.into_iter().map(|(point, _)| MethodPoint {
            result: point.result.map(|r| MethodValues {
                modal_force: point.modal_force,
                modal_amplitude: r.modal_amplitude,
                omega: r.omega,
                harmonic_omega: r.harmonic_omega,
                zeta: r.is_resolved().then_some(r.zeta),
                zeta_floor: r.zeta_floor,
                residual: r.residual,
                response_displacement: r.modal_amplitude * self.response_of_the_mode(),
            }),
            effort: point.effort,
        });
        Ok(points.collect())
    }

    fn masing(&self) -> Result<Vec<MethodPoint>, Error> {
        // As many edges as a branch of a loop has.
        let settings = self.loading(2 * self.settings.vertices_per_quarter);
        let points = masing::run(self.about.line, self.about.force, self.modal_forces, &settings)?;
        let phi = self.response_of_the_mode();
        Ok(values(points, |q, _| q * phi))
    }

    fn rqnma(&self) -> Result<Vec<MethodPoint>, Error> {
        let settings = self.loading(self.settings.vertices_per_quarter);
        let eigenvalue = self.about.line.eigenvalues[self.settings.mode];
        let amplitudes: Vec<f64> = self.modal_forces.iter().map(|alpha| alpha / eigenvalue).collect();
        let points = rqnma::run(self.about.line, self.about.force, &amplitudes, &settings)?;
        Ok(values(points, |_, v| self.response_of(v.iter()).abs()))
    }

    fn loading(&self, edges: usize) -> loading::Settings {
        loading::Settings {
            mode: self.settings.mode,
            edges,
            newton: self.settings.newton,
            solver: self.settings.solver,
        }
    }

    fn response_of<'v>(&self, displacement: impl Iterator<Item = &'v f64>) -> f64 {
        displacement.zip(self.about.response).map(|(a, b)| a * b).sum()
    }

    fn response_of_the_mode(&self) -> f64 {
        self.response_of(self.about.line.shapes.col(self.settings.mode).iter())
            .abs()
    }
}

/// `response` gives the displacement at the response point from the modal amplitude and the displacement.
fn values(points: Vec<LoadingPoint>, response: impl Fn(f64, &[f64]) -> f64) -> Vec<MethodPoint> {
    points
        .into_iter()
        .map(|point| MethodPoint {
            result: point.result.map(|r| MethodValues {
                modal_force: r.modal_force,
                modal_amplitude: r.modal_amplitude,
                omega: r.omega,
                harmonic_omega: r.harmonic_omega,
                zeta: r.is_resolved().then_some(r.zeta),
                zeta_floor: r.zeta_floor,
                residual: r.residual,
                response_displacement: response(r.modal_amplitude, &r.displacement),
            }),
            effort: point.effort,
        })
        .collect()
}
