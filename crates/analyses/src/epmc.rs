//! Free periodic motions of a mode about the static state of a scene, by the extended periodic motion concept (EPMC).

use super::linearised::{Linearised, flow, newton};
use super::sensitivities::Sensitivity;
use crate::Error;
use harmonic_balance::aft::PointHistory;
use harmonic_balance::backbone::{self, Accuracy, Kind, Motion, Point};
use harmonic_balance::{Sampling, interface};
use joints::progress::{Progress, Stage};
use joints::store::checkpoint::{Checkpoint, Checkpoints};
use joints::store::key::KeyBuilder;
use scenes::Epmc;
use std::path::Path;

/// Damping ratio below which errors of sampling do not matter.
const DAMPING_FLOOR: f64 = 1e-5;

/// Most harmonics and samples that an accuracy leads to.
const MOST: (usize, usize) = (31, 4096);

/// An EPMC backbone.
#[derive(Clone, Debug)]
pub struct EpmcBackbone {
    /// Amplitudes in ascending order.
    pub points: Vec<Point>,
    /// Displacement amplitude of the first harmonic at the response point (m), where there is a motion.
    pub response_displacement: Vec<Option<f64>>,
    /// Hysteresis loops of single points, amplitude by amplitude, at a few amplitudes.
    pub loops: Vec<PointLoop>,
    /// Derivatives with respect to the parameters of the scene's `sensitivities`, in their order.
    pub sensitivities: Vec<Sensitivity>,
}

/// The loop of a point at an amplitude.
#[derive(Clone, Debug)]
pub struct PointLoop {
    /// Modal amplitude (sqrt(kg) m).
    pub modal_amplitude: f64,
    /// The loop, sample by sample; points are counted from 0.
    pub history: PointHistory,
}

impl Linearised<'_> {
    /// The backbone of free motions that begins as mode `mode` (from 0), at the amplitudes of the scene or else at `otherwise`.
    pub(super) fn epmc(
        &self,
        settings: &Epmc,
        mode: usize,
        otherwise: Vec<f64>,
        key: Option<(&Path, KeyBuilder)>,
        progress: &dyn Progress,
    ) -> Result<(EpmcBackbone, Checkpoints), Error> {
        progress.begin(Stage::Epmc);
        let amplitudes = settings.modal_amplitudes.as_ref().map_or(otherwise, |a| a.values());
        let checkpoint: Checkpoint<Point> = match key {
            None => Checkpoint::default(),
            Some((directory, mut key)) => {
                key.numbers(self.line.displacement().iter().copied());
                key.numbers(self.line.shapes.col(mode).iter().copied());
                key.numbers(amplitudes.iter().copied());
                Checkpoint::open(directory, "epmc", &key.finish())
            }
        };
        let known = checkpoint.leading();
        if !known.is_empty() {
            let (found, all) = (known.len(), amplitudes.len());
            progress.note(&format!(
                "{found} of {all} periodic motions were taken from an interrupted run"
            ));
        }
        let mut done = known.len();
        let points = backbone::follow(
            self.line,
            self.force,
            Kind::Free,
            &amplitudes,
            &backbone::Settings {
                mode,
                sampling: Sampling {
                    harmonics: settings.harmonics,
                    samples: settings.samples,
                    periods: settings.periods,
                },
                accuracy: settings.accuracy.map(|target| Accuracy {
                    frequency: target.frequency,
                    damping: target.damping,
                    damping_floor: DAMPING_FLOOR * target.damping,
                    max_harmonics: MOST.0,
                    max_samples: MOST.1,
                }),
                newton: newton(settings.tolerance),
            },
            known,
            &mut |point| {
                checkpoint.add(done, point);
                done += 1;
                progress.fraction(Stage::Epmc, done as f64 / amplitudes.len() as f64);
                flow(progress)
            },
        )?;
        let first = |motion: &Motion| {
            let along = motion.displacement.along(self.response);
            along[1].hypot(along[2])
        };
        let response_displacement = points.iter().map(|p| p.result.as_ref().ok().map(first)).collect();
        let loops = self.loops(settings, &points);
        progress.end(Stage::Epmc);
        let (_, checkpoints) = checkpoint.complete();
        Ok((
            EpmcBackbone {
                points,
                response_displacement,
                loops,
                sensitivities: Vec::new(),
            },
            checkpoints,
        ))
    }

    /// Loops of the points asked for at the largest amplitude and two smaller ones.
    fn loops(&self, settings: &Epmc, points: &[Point]) -> Vec<PointLoop> {
        let motions: Vec<&Motion> = points.iter().filter_map(|p| p.result.as_ref().ok()).collect();
        let Some(last) = motions.last() else { return Vec::new() };
        let wanted = settings
            .loops_at
            .as_ref()
            .map(|points| points.iter().map(|p| p - 1).collect());
        let wanted: Vec<usize> = wanted.unwrap_or_else(|| {
            let flux = interface::dissipation(self.line, self.force, &last.displacement, last.sampling);
            let total = zte_assembly::flux::total(&flux);
            let most = (0..total.len()).max_by(|a, b| total[*a].total_cmp(&total[*b]));
            most.into_iter().collect()
        });
        let mut chosen: Vec<usize> = [motions.len() / 2, 3 * motions.len() / 4, motions.len() - 1].into();
        chosen.dedup();
        let of = |index: usize| {
            let motion = motions[index];
            let found = interface::histories(self.line, self.force, &motion.displacement, motion.sampling, &wanted);
            found.into_iter().map(|history| PointLoop {
                modal_amplitude: motion.modal_amplitude,
                history,
            })
        };
        chosen.into_iter().flat_map(of).collect()
    }
}
