//! Loops of a hyper-reduced joint, each with its estimated errors.

use crate::error::Error;
use crate::estimate::{ErrorEstimate, estimate};
use crate::joint::HyperReducedJoint;
use cqsma_solver::cqsma::{self, Commit, Cycles, Settings};
use cqsma_solver::{BackbonePoint, LoopObserver, modes};
use std::ops::ControlFlow;

/// A loop of the reduced joint.
#[derive(Clone, Debug)]
pub struct JudgedLoop {
    /// The loop.
    pub point: BackbonePoint,
    /// Half the range of the displacement at the response point (m).
    pub response_motion: f64,
    /// Its estimated errors; none of a loop that did not converge, or for which they could not be found.
    pub estimate: Option<ErrorEstimate>,
}

impl HyperReducedJoint<'_> {
    /// Loops at modal forces (sqrt(kg) m/s^2), with the settings of those of the whole joint. `response` recovers the displacement at the response
    /// point from that of the whole joint.
    ///
    /// # Errors
    /// [`Error::Loops`] for loops that the estimates do not know how to judge; else as [`cqsma::run`].
    pub fn run(&self, modal_forces: &[f64], settings: &Settings, response: &[f64]) -> Result<Vec<JudgedLoop>, Error> {
        if settings.commit != Commit::AtEveryVertex || matches!(settings.cycles, Cycles::Fixed(_)) {
            return Err(Error::Loops);
        }
        let state = self.force.state();
        let coordinates = self.basis.ncols();
        // No more modes lie below that of the whole joint than there.
        let n_modes = coordinates.min(self.mode + 1);
        let at_rest = vec![0.0; coordinates];
        let (stiffness, mass) = (self.stiffness.as_ref(), self.mass.as_ref());
        let mut structure = modes::linearise(stiffness, mass, &self.force, at_rest, state, n_modes)?;
        let mut of_mode = vec![0.0; coordinates];
        of_mode[0] = 1.0;
        structure.orient(&of_mode)?;
        let distance = |mode: &usize| (structure.eigenvalues[*mode].sqrt() / self.omega - 1.0).abs();
        let mode = (0..n_modes).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let settings = Settings {
            mode: mode.unwrap_or_default(),
            ..*settings
        };
        let along = |column: faer::ColRef<'_, f64>| column.iter().zip(response).map(|(a, b)| a * b).sum();
        let response: Vec<f64> = self.basis.col_iter().map(along).collect();
        let found = cqsma::run(&structure, &self.force, modal_forces, &settings, |_| Judge {
            joint: self,
            response: &response,
            loads: Vec::new(),
            coordinates: Vec::new(),
            estimate: None,
        })?;
        let found = found.into_iter().map(|(point, judge)| JudgedLoop {
            response_motion: judge.response_motion(),
            estimate: judge.estimate,
            point,
        });
        Ok(found.collect())
    }
}

/// Estimates the errors of a loop when it is done.
struct Judge<'a> {
    joint: &'a HyperReducedJoint<'a>,
    /// Recovers the displacement at the response point from the coordinates.
    response: &'a [f64],
    loads: Vec<f64>,
    coordinates: Vec<Vec<f64>>,
    estimate: Option<ErrorEstimate>,
}

impl Judge<'_> {
    fn response_motion(&self) -> f64 {
        let motions = self
            .coordinates
            .iter()
            .map(|y| y.iter().zip(self.response).map(|(y, r)| y * r).sum());
        let (low, high) = motions.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x: f64| {
            (low.min(x), high.max(x))
        });
        0.5 * (high - low)
    }
}

impl<W> LoopObserver<W> for Judge<'_> {
    fn begin(&mut self) {
        self.loads.clear();
        self.coordinates.clear();
    }

    fn vertex(&mut self, modal_force: f64, displacement: &[f64], _: &W) {
        self.loads.push(modal_force);
        self.coordinates.push(displacement.to_vec());
    }

    fn done(&mut self, point: &BackbonePoint) -> ControlFlow<()> {
        if let Ok(result) = &point.result {
            self.estimate = estimate(self.joint, result, &self.loads, &self.coordinates);
        }
        ControlFlow::Continue(())
    }
}
