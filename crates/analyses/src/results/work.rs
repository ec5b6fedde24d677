//! What the analyses of a run did, in numbers that their times go with.

use crate::Run;
use joints::progress::Stage;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

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

/// Counts of a solver.
struct Counts {
    iterations: usize,
    residuals: usize,
    krylov_steps: usize,
    factorisations: usize,
}

impl From<cqsma_solver::newton::Effort> for Counts {
    fn from(effort: cqsma_solver::newton::Effort) -> Self {
        Self {
            iterations: effort.iterations,
            residuals: effort.evaluations,
            krylov_steps: effort.krylov_steps,
            factorisations: effort.factorisations,
        }
    }
}

impl From<harmonic_balance::Effort> for Counts {
    fn from(effort: harmonic_balance::Effort) -> Self {
        Self {
            iterations: effort.iterations,
            residuals: effort.evaluations,
            krylov_steps: effort.krylov_steps,
            factorisations: 0,
        }
    }
}

impl Work {
    /// Adds what a solver did, whose residuals take so many evaluations of the law and products each.
    fn add(&mut self, counts: impl Into<Counts>, [evaluations, products]: [usize; 2]) {
        let counts = counts.into();
        self.iterations += counts.iterations;
        self.residuals += counts.residuals;
        self.law_evaluations += evaluations * counts.residuals;
        self.krylov_steps += counts.krylov_steps;
        self.factorisations += counts.factorisations;
        self.products += products * (counts.residuals + counts.krylov_steps);
    }
}

/// What the stages of a run did, by name; those that did nothing are left out.
pub(super) fn of(run: &Run) -> BTreeMap<String, Work> {
    let mut stages: BTreeMap<Stage, Work> = BTreeMap::new();
    let mut add = |stage: Stage, counts: Counts, each: [usize; 2]| stages.entry(stage).or_default().add(counts, each);
    let of_motion = |harmonics: usize, samples: usize| [samples, 2 * harmonics + 1];
    for mode in &run.backbones {
        for amplitude in &mode.amplitudes {
            add(Stage::Backbone, amplitude.point.effort.into(), [1, 1]);
        }
        for point in mode.methods.iter().flat_map(|method| &method.points) {
            add(Stage::Methods, point.effort.into(), [1, 1]);
        }
        let asked = run.scene.analyses.epmc.as_ref();
        for (point, asked) in mode
            .epmc
            .iter()
            .flat_map(|epmc| &epmc.points)
            .zip(asked.into_iter().cycle())
        {
            let each = match &point.result {
                Ok(motion) => {
                    let sampling = motion.sampling;
                    of_motion(sampling.harmonics, sampling.samples * sampling.periods)
                }
                Err(_) => of_motion(asked.harmonics, asked.samples * asked.periods),
            };
            add(Stage::Epmc, point.effort.into(), each);
        }
    }
    if let Some(asked) = &run.scene.analyses.forced {
        for level in run.vibration.forced.iter().flatten() {
            let each = of_motion(asked.harmonics, asked.samples * crate::forced::PERIODS);
            add(Stage::Forced, level.effort.into(), each);
        }
    }
    let bytes = run.flexibility_bytes as u64;
    let of_stage = |(stage, mut work): (Stage, Work)| {
        work.bytes_read = bytes * work.products as u64;
        (stage.name().to_owned(), work)
    };
    stages
        .into_iter()
        .filter(|(_, work)| work.residuals > 0)
        .map(of_stage)
        .collect()
}
