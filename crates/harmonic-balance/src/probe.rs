//! The parts of a solve one by one, for those who measure what they cost.

use crate::aft::Sampling;
use crate::backbone::Motion;
use crate::force::PointwiseForce;
use crate::harmonics::Harmonics;
use crate::load::Load;
use crate::system::{Derivative, Evaluation, System, Unknown};
use cqsma_solver::Linearisation;

/// A motion about which residuals and Krylov steps can be repeated.
pub struct Probe<'a, F: PointwiseForce> {
    system: System<'a, F>,
    unknown: Unknown,
    evaluation: Evaluation,
    coarse: Derivative,
}

impl<'a, F: PointwiseForce> Probe<'a, F> {
    /// About a free motion that was found.
    pub fn new(
        line: &'a Linearisation<'a, F::State>,
        force: &'a F,
        row: &'a [f64],
        motion: &Motion,
        sampling: Sampling,
    ) -> Self {
        let system = System::new(line, force, Load::force(row), 0.0, [0.0; 2], sampling);
        let v = motion.displacement.with_count(sampling.harmonics);
        let square = motion.omega * motion.omega;
        let mut unknown = Unknown {
            p: v.clone(),
            v,
            parameters: [square, 2.0 * motion.zeta.unwrap_or(0.0) * square, 0.0],
        };
        system.restore(&mut unknown);
        let evaluation = system.evaluate(&unknown);
        Self {
            coarse: Derivative::Coarse(system.coarse_forces(&unknown.v)),
            system,
            unknown,
            evaluation,
        }
    }

    /// One residual, with its stuck response.
    pub fn residual(&self) -> f64 {
        self.system.evaluate(&self.unknown).norm()
    }

    /// The contact forces of one residual.
    pub fn contact(&self) -> f64 {
        self.system.contact_forces(&self.unknown.v).dot(&self.unknown.v)
    }

    /// One step of the Krylov iteration without its orthogonalisation: preconditioner, product with the Jacobian, stuck response.
    pub fn krylov_step(&self) -> f64 {
        let Evaluation { residual, response, .. } = &self.evaluation;
        let [v, p] = self.system.precondition(&self.unknown, residual, response);
        let image = self.system.product(&self.unknown, &v, &p, &self.coarse);
        self.system.solve_stuck(&image).dot(&image)
    }

    /// The derivative of the contact forces of one such step.
    pub fn contact_derivative(&self) -> f64 {
        self.system
            .contact_derivative(
                &self.unknown,
                [&self.evaluation.response, &self.evaluation.residual],
                &self.coarse,
            )
            .dot(&self.unknown.v)
    }

    /// The responses of the stuck structure of one such step.
    pub fn stuck_response(&self) -> Harmonics {
        self.system.solve_stuck(&self.evaluation.residual)
    }
}
