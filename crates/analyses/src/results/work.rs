//! What the analyses of a run did, in numbers that their times go with.

use crate::Run;
use cqsma_solver::newton;
use joints::progress::Stage;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::AddAssign;

/// What one stage did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Work {
    /// Newton iterations.
    pub iterations: usize,
    /// Residuals evaluated.
    pub residuals: usize,
    /// Evaluations of the law at all points that these took: one each, and of periodic motions as many as samples of all periods.
    pub law_evaluations: usize,
    /// Krylov steps of the linear systems.
    pub krylov_steps: usize,
    /// Factorisations of linear systems that these did not solve.
    pub factorisations: usize,
    /// Products with the stuck structure's flexibility: one for each residual and Krylov step, and of periodic motions one for each coefficient of the
    /// Fourier series.
    pub products: usize,
    /// Bytes of flexibility that the products read.
    pub bytes_read: u64,
}

impl AddAssign<newton::Effort> for Work {
    fn add_assign(&mut self, effort: newton::Effort) {
        self.iterations += effort.iterations;
        self.residuals += effort.evaluations;
        self.law_evaluations += effort.evaluations;
        self.krylov_steps += effort.krylov_steps;
        self.factorisations += effort.factorisations;
        self.products += effort.evaluations + effort.krylov_steps;
    }
}

impl AddAssign<harmonic_balance::Effort> for Work {
    fn add_assign(&mut self, effort: harmonic_balance::Effort) {
        self.iterations += effort.iterations;
        self.residuals += effort.evaluations;
        self.law_evaluations += effort.law_evaluations;
        self.krylov_steps += effort.krylov_steps;
        self.products += effort.flexibility_products;
    }
}

/// What the stages of a run did, by name; those that did nothing are left out.
pub(super) fn of(run: &Run) -> BTreeMap<String, Work> {
    let [mut loops, mut methods, mut epmc, mut forced] = [Work::default(); 4];
    for mode in &run.backbones {
        mode.amplitudes
            .iter()
            .for_each(|amplitude| loops += amplitude.point.effort);
        let points = mode.methods.iter().flat_map(|method| &method.points);
        points.for_each(|point| methods += point.effort);
        let points = mode.epmc.iter().flat_map(|found| &found.points);
        points.for_each(|point| epmc += point.effort);
    }
    let levels = run.vibration.forced.iter().flatten();
    levels.for_each(|level| forced += level.effort);
    let stages = [
        (Stage::Backbone, loops),
        (Stage::Methods, methods),
        (Stage::Epmc, epmc),
        (Stage::Forced, forced),
    ];
    let of_stage = |(stage, work): (Stage, Work)| {
        let bytes_read = run.flexibility_bytes as u64 * work.products as u64;
        (stage.name().to_owned(), Work { bytes_read, ..work })
    };
    stages
        .into_iter()
        .filter(|(_, work)| work.residuals > 0)
        .map(of_stage)
        .collect()
}
