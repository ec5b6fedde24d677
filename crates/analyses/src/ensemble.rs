//! Backbones of bootstrap realisations: how sure a backbone is, given the samples that its laws were measured from.
//!
//! Realisation `k` draws the heights of every element anew ([`surface_characterisation::realisation`]) and goes through
//! prestress, modes and loops on the same reduced structure. Everything in it depends on the seed and `k` alone, so
//! neither the number of threads nor an interruption changes a bit.

use super::amplitude::AmplitudeResult;
use super::outcome::Analysis;
use crate::Error;
use joints::progress::{Progress, Stage};
use joints::store::checkpoint::{Checkpoint, Checkpoints};
use rayon::prelude::*;
use scenes::{Analyses, Backbone, Scene};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Percentiles that are given.
pub const PERCENTILES: [f64; 3] = [5.0, 50.0, 95.0];

/// An amplitude of a realisation, where its loop converged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MemberPoint {
    /// Displacement amplitude at the response point (m).
    pub response_displacement: f64,
    /// Secant frequency (Hz).
    pub frequency_hz: f64,
    /// Frequency of the first harmonic (Hz).
    pub frequency_first_harmonic_hz: f64,
    /// Total damping ratio, friction plus background; none below its floor.
    pub damping_ratio: Option<f64>,
}

/// A realisation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Member {
    /// Its number, from 0.
    pub realisation: usize,
    /// The amplitudes that converged, ascending.
    pub points: Vec<MemberPoint>,
    /// Amplitudes that did not.
    pub not_converged: usize,
    /// Why it has no backbone at all, if so.
    pub failure: Option<String>,
}

/// Percentiles over the realisations at one amplitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BandPoint {
    /// Displacement amplitude at the response point (m).
    pub response_displacement: f64,
    /// Realisations that reach it.
    pub realisations: usize,
    /// 5, 50 and 95 % of the secant frequency (Hz).
    pub frequency_hz: [f64; 3],
    /// 5, 50 and 95 % of the frequency of the first harmonic (Hz).
    pub frequency_first_harmonic_hz: [f64; 3],
    /// 5, 50 and 95 % of the total damping ratio; none where the percentile lies among dampings below their floor.
    pub damping_ratio: [Option<f64>; 3],
}

/// An ensemble of backbones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Ensemble {
    /// Realisations.
    pub realisations: usize,
    /// How many of them have no backbone.
    pub failed: usize,
    /// Percentiles at the measured backbone's amplitudes, as far as all realisations with a backbone reach.
    pub bands: Vec<BandPoint>,
    /// The realisations themselves.
    pub members: Vec<Member>,
}

/// The scene with the loops of its first mode followed alone, or of all: fields, other methods and what else is asked for are left to the
/// run of the scene itself.
pub(super) fn loops_alone(scene: &Scene, all_modes: bool) -> Scene {
    let mut scene = scene.clone();
    if !all_modes {
        scene.analyses.modes.followed.truncate(1);
    }
    let asked = std::mem::take(&mut scene.analyses);
    scene.analyses = Analyses {
        modes: asked.modes,
        backbone: Backbone {
            methods: Vec::new(),
            loops_at: Vec::new(),
            ..asked.backbone
        },
        tightening: asked.tightening,
        ..Analyses::default()
    };
    scene.uncertain = None;
    scene.output.fields_at = Some(Vec::new());
    scene.output.deformed = false;
    scene
}

/// Analyses many variants of a scene.
pub(super) struct Batch<'a> {
    /// What they are called in messages.
    pub(super) name: &'a str,
    /// How many.
    pub(super) number: usize,
    /// Loops of each.
    pub(super) loops: usize,
    pub(super) progress: &'a dyn Progress,
}

impl Batch<'_> {
    /// Analyses those that `checkpoint` does not hold, and gives what `describe` makes of each, with what lets the run resume.
    ///
    /// # Errors
    /// An interruption; whatever else ends a variant is described.
    pub(super) fn run<M: Serialize + DeserializeOwned + Send + Sync>(
        &self,
        checkpoint: Checkpoint<M>,
        analyse: impl Fn(usize, &dyn Progress) -> Result<Analysis, Error> + Sync,
        describe: impl Fn(usize, Result<&Analysis, Error>) -> M + Sync,
    ) -> Result<(Vec<M>, Checkpoints), Error> {
        let (all, name, progress) = (self.number, self.name, self.progress);
        let pending: Vec<usize> = (0..all).filter(|k| !checkpoint.holds(*k)).collect();
        let found = all - pending.len();
        if found > 0 {
            progress.note(&format!("{found} of {all} {name} were taken from an interrupted run"));
        }
        let inner = Within {
            progress,
            finished: AtomicUsize::new(found * self.loops),
            all: all * self.loops,
        };
        let member = |&k: &usize| {
            let mut loops = Checkpoints::default();
            let member = match analyse(k, &inner) {
                Ok(analysis) => {
                    let member = describe(k, Ok(&analysis));
                    loops = analysis.checkpoints;
                    member
                }
                Err(error) if error.is_interruption() => return Err(error),
                Err(error) => describe(k, Err(error)),
            };
            // The loops go first: nobody looks for those of a variant that the checkpoint holds.
            let left = loops.try_remove();
            if left.is_empty() {
                checkpoint.add(k, &member);
            }
            Ok((k, member, left))
        };
        let mut fresh = Vec::with_capacity(pending.len());
        // As many at a time as there are threads: a thread that waits for the loops of one may begin another, and so on without
        // end.
        for some in pending.chunks(rayon::current_num_threads().max(1)) {
            fresh.extend(some.par_iter().map(member).collect::<Result<Vec<_>, Error>>()?);
        }
        let (mut done, mut checkpoints) = checkpoint.complete();
        for (k, member, left) in fresh {
            done.insert(k, member);
            checkpoints.extend(left);
        }
        Ok((done.into_values().take(all).collect(), checkpoints))
    }
}

/// Shows the loops of all variants as the progress of one stage.
struct Within<'a> {
    progress: &'a dyn Progress,
    finished: AtomicUsize,
    all: usize,
}

impl Progress for Within<'_> {
    fn fraction(&self, stage: Stage, _: f64) {
        if stage == Stage::Backbone {
            let done = self.finished.fetch_add(1, Ordering::Relaxed) + 1;
            self.progress.fraction(Stage::Ensemble, done as f64 / self.all as f64);
        }
    }

    fn interrupted(&self) -> bool {
        self.progress.interrupted()
    }
}

impl Member {
    /// What a realisation is, or why it is none.
    pub(super) fn new(realisation: usize, found: Result<&Analysis, Error>) -> Self {
        match found {
            Ok(analysis) => Self::of(realisation, &analysis.modes[0].amplitudes, analysis.modes[0].background),
            Err(error) => Self {
                realisation,
                points: Vec::new(),
                not_converged: 0,
                failure: Some(error.to_string()),
            },
        }
    }

    pub(crate) fn of(realisation: usize, amplitudes: &[AmplitudeResult], background: f64) -> Self {
        let points: Vec<MemberPoint> = amplitudes
            .iter()
            .filter_map(|a| {
                let result = a.point.result.as_ref().ok()?;
                Some(MemberPoint {
                    response_displacement: a.response_displacement?,
                    frequency_hz: result.omega / TAU,
                    frequency_first_harmonic_hz: result.harmonic_omega / TAU,
                    damping_ratio: result.is_resolved().then_some(result.zeta + background),
                })
            })
            .collect();
        Self {
            realisation,
            not_converged: amplitudes.len() - points.len(),
            points,
            failure: None,
        }
    }

    /// Secant frequency, damping and frequency of the first harmonic at an amplitude between the first and the last one,
    /// linear in the logarithm of the amplitude; damping below the floor is below every other.
    pub(crate) fn at(&self, amplitude: f64) -> Option<[f64; 3]> {
        let [first, .., last] = self.points.as_slice() else {
            return None;
        };
        if !(first.response_displacement..=last.response_displacement).contains(&amplitude) {
            return None;
        }
        let above = self.points.partition_point(|p| p.response_displacement < amplitude);
        let [a, b] = [&self.points[above.saturating_sub(1)], &self.points[above]];
        let span = (b.response_displacement / a.response_displacement).ln();
        let part = if span > 0.0 {
            (amplitude / a.response_displacement).ln() / span
        } else {
            0.0
        };
        let between = |a: f64, b: f64| a + part * (b - a);
        let damping = match [a.damping_ratio, b.damping_ratio] {
            [Some(a), Some(b)] => between(a, b),
            // On a point its neighbour has no say.
            [Some(a), None] if part == 0.0 => a,
            [None, Some(b)] if part == 1.0 => b,
            _ => f64::NEG_INFINITY,
        };
        let harmonic = between(a.frequency_first_harmonic_hz, b.frequency_first_harmonic_hz);
        Some([between(a.frequency_hz, b.frequency_hz), damping, harmonic])
    }
}

impl Ensemble {
    /// Bands over `members` at the amplitudes of the measured backbone.
    pub(crate) fn new(members: Vec<Member>, measured: &[AmplitudeResult]) -> Self {
        let measured = measured.iter().filter_map(|a| a.response_displacement);
        Self {
            realisations: members.len(),
            failed: members.iter().filter(|m| m.points.is_empty()).count(),
            bands: bands(&members, measured),
            members,
        }
    }
}

/// Percentiles at `amplitudes`; those beyond what all members reach are moved there, once.
fn bands(members: &[Member], amplitudes: impl Iterator<Item = f64>) -> Vec<BandPoint> {
    let ends = members.iter().filter_map(|m| {
        let [first, .., last] = m.points.as_slice() else {
            return None;
        };
        Some([first.response_displacement, last.response_displacement])
    });
    let [from, to] = ends.fold([0.0, f64::INFINITY], |[low, high]: [f64; 2], [first, last]| {
        [low.max(first), high.min(last)]
    });
    if !(from < to && to.is_finite()) {
        return Vec::new();
    }
    let mut common: Vec<f64> = amplitudes.map(|x| x.clamp(from, to)).collect();
    common.sort_by(f64::total_cmp);
    common.dedup();
    let band = |amplitude| {
        let values: Vec<[f64; 3]> = members.iter().filter_map(|m| m.at(amplitude)).collect();
        let of = |which: usize| {
            let mut sorted: Vec<f64> = values.iter().map(|v| v[which]).collect();
            sorted.sort_by(f64::total_cmp);
            PERCENTILES.map(|p| percentile(&sorted, p / 100.0))
        };
        BandPoint {
            response_displacement: amplitude,
            realisations: values.len(),
            frequency_hz: of(0),
            frequency_first_harmonic_hz: of(2),
            damping_ratio: of(1).map(|v| v.is_finite().then_some(v)),
        }
    };
    common.into_iter().map(band).collect()
}

/// Percentile of sorted values with linear interpolation between order statistics.
pub(super) fn percentile(sorted: &[f64], p: f64) -> f64 {
    let position = p * (sorted.len() - 1) as f64;
    let below = position.floor() as usize;
    let part = position - below as f64;
    match sorted.get(below + 1) {
        Some(above) if part > 0.0 => sorted[below] + part * (above - sorted[below]),
        _ => sorted[below],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A member with the frequencies `f - ln x` and the dampings given.
    fn member(realisation: usize, f: f64, amplitudes: [f64; 3], damping: [Option<f64>; 3]) -> Member {
        let points = amplitudes
            .into_iter()
            .zip(damping)
            .map(|(x, damping_ratio)| MemberPoint {
                response_displacement: x,
                frequency_hz: f - x.ln(),
                frequency_first_harmonic_hz: f - x.ln() - 1.0,
                damping_ratio,
            });
        Member {
            realisation,
            points: points.collect(),
            not_converged: 0,
            failure: None,
        }
    }

    #[test]
    fn bands_are_percentiles_on_common_amplitudes() {
        let all = [Some(1e-4), Some(2e-4), Some(4e-4)];
        // 21 members: 5, 50 and 95 % are the 2nd, the 11th and the 20th.
        let mut members: Vec<Member> = (0..21)
            .map(|k| member(k, 100.0 + k as f64, [1e-6, 1e-5, 1e-4], all))
            .collect();
        let found = bands(&members, [1e-6, 3e-5, 1e-4].into_iter());
        for band in &found {
            let shift = band.response_displacement.ln();
            for (f, expected) in band.frequency_hz.iter().zip([101.0, 110.0, 119.0]) {
                assert!((f + shift - expected).abs() < 1e-9, "{band:?}");
            }
            for (f, first) in band.frequency_hz.iter().zip(band.frequency_first_harmonic_hz) {
                assert!((f - first - 1.0).abs() < 1e-9, "{band:?}");
            }
        }
        let halfway = 2e-4 + 2e-4 * 3f64.log10();
        assert!((found[1].damping_ratio[1].unwrap() - halfway).abs() < 1e-12);
        // A member that reaches less far moves the ends; one that failed does not.
        members.push(member(21, 110.0, [2e-6, 1e-5, 9e-5], all));
        members.push(Member {
            points: Vec::new(),
            failure: Some("why".into()),
            ..member(22, 0.0, [1.0; 3], all)
        });
        let found = bands(&members, [1e-6, 1.5e-6, 3e-5, 1e-4].into_iter());
        let at: Vec<f64> = found.iter().map(|b| b.response_displacement).collect();
        assert_eq!(at, [2e-6, 3e-5, 9e-5]);
        assert!(found.iter().all(|b| b.realisations == 22));
        assert!(bands(&[], [1e-6].into_iter()).is_empty());
    }

    #[test]
    fn damping_below_its_floor_is_below_every_other() {
        let low = [None, Some(2e-4), Some(4e-4)];
        let all = [Some(1e-4), Some(2e-4), Some(4e-4)];
        let members: Vec<Member> = (0..21)
            .map(|k| member(k, 100.0, [1e-6, 1e-5, 1e-4], if k < 5 { low } else { all }))
            .collect();
        let found = bands(&members, [1e-6, 1e-5].into_iter());
        assert_eq!(found[0].damping_ratio, [None, Some(1e-4), Some(1e-4)]);
        assert_eq!(found[1].damping_ratio, [Some(2e-4); 3]);
    }
}
